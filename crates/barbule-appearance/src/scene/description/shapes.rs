//! The shapes of objects that are no feathers, as geometry about their own origins.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec2, Vec3};

use crate::math::rng::hash;
use crate::scene::geometry::{CurveNode, Geometry, Mesh};
use crate::scene::spline::{Basis, ControlCurve};
use crate::{Error, Result};

/// Most conical segments of an object's curves: as many as a mesh may have triangles.
pub(super) const MOST_SEGMENTS: usize = 5_000_000;

/// Columns and rows of a sphere's quadrangles.
pub(super) const SPHERE: [u32; 2] = [192, 96];

pub(super) fn nodes(curve: &ControlCurve) -> Vec<CurveNode> {
    let node = |&[x, y, z, radius]: &[f64; 4]| CurveNode {
        point: DVec3::new(x, y, z).as_vec3(),
        radius: radius as f32,
        ..CurveNode::default()
    };
    curve.iter().map(node).collect()
}

/// Curves as conical segments; `id`: the object's.
pub(super) fn grow(curves: &[ControlCurve], basis: Basis, id: u64) -> Result<Geometry> {
    let mut geometry = Geometry::default();
    let mut segments = 0;
    for (index, curve) in (0_u64..).zip(curves) {
        let nodes = nodes(curve);
        segments += basis.segments(&nodes);
        if segments > MOST_SEGMENTS {
            return Err(Error::input(format!(
                "its curves need over {MOST_SEGMENTS} segments; give fewer or less bent ones, or share them among several objects"
            )));
        }
        geometry.add_control_curve(&nodes, basis, hash(id, &[index]));
    }
    Ok(geometry)
}

/// At each vertex the direction in which the texture's v grows, the mean over its triangles; none where a mesh has no texture
/// coordinates.
pub(super) fn upwards(mesh: &Mesh) -> Vec<Vec3> {
    if mesh.uvs.is_empty() {
        return Vec::new();
    }
    let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|corner| corner as usize);
        let (p, q) = (mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
        let (s, t) = (mesh.uvs[b] - mesh.uvs[a], mesh.uvs[c] - mesh.uvs[a]);
        // p = s.x ∂u + s.y ∂v, q = t.x ∂u + t.y ∂v, times the determinant's sign.
        let along = (q * s.x - p * t.x) * s.perp_dot(t).signum();
        for corner in [a, b, c] {
            sums[corner] += along;
        }
    }
    sums.into_iter().map(|sum| sum.normalize_or(Vec3::Y)).collect()
}

/// A sphere of quadrangles; u goes round from +y clockwise seen from +z, v from the lower pole to the upper one.
pub(super) fn sphere(radius_mm: f64) -> Mesh {
    let [columns, rows] = SPHERE;
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let (u, v) = (f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows));
            let (around, polar) = (TAU * u, PI * (1.0 - v));
            let (sine, cosine) = (libm::sin(polar), libm::cos(polar));
            let normal = DVec3::new(sine * libm::sin(around), sine * libm::cos(around), cosine);
            mesh.positions.push((normal * radius_mm).as_vec3());
            mesh.normals.push(normal.as_vec3());
            mesh.uvs.push(Vec2::new(u as f32, v as f32));
        }
    }
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let at = row * (columns + 1) + column;
        let (above, right) = (at + columns + 1, 1);
        mesh.triangles.push([at, above, at + right]);
        mesh.triangles.push([at + right, above, above + right]);
    }
    mesh
}

pub(super) fn rectangle([x, y]: [f64; 2]) -> Mesh {
    let (x, y) = ((0.5 * x) as f32, (0.5 * y) as f32);
    Mesh {
        positions: vec![
            Vec3::new(-x, -y, 0.0),
            Vec3::new(x, -y, 0.0),
            Vec3::new(x, y, 0.0),
            Vec3::new(-x, y, 0.0),
        ],
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Outwards, closed, of the sphere's area but for the facets.
    #[test]
    fn spheres_are_closed_and_face_outwards() {
        let mesh = sphere(2.0);
        let (mut area, mut volume) = (0.0, 0.0);
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize].as_dvec3());
            let normal = (b - a).cross(c - a);
            assert!(normal.dot(a + b + c) >= -1e-9);
            area += 0.5 * normal.length();
            volume += a.dot(b.cross(c)) / 6.0;
        }
        assert!((area / (16.0 * PI) - 1.0).abs() < 1e-3 && (volume / (32.0 / 3.0 * PI) - 1.0).abs() < 2e-3);
        let all = Geometry { meshes: vec![mesh], ..Geometry::default() };
        all.check().unwrap();
    }
}
