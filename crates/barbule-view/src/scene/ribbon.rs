//! Ribbons and fibres of feathers as strips of triangles, and meshes as they are.

use barbule_appearance::scene::geometry::{Curve, Geometry, Mesh, Ribbon, RibbonNode};
use glam::Vec3;

use super::{Shape, Vertex};

/// The places among `count` nodes that are kept where every `stride`-th is: both ends always.
pub(super) fn kept(count: usize, stride: usize) -> impl Iterator<Item = usize> {
    let last = count.saturating_sub(1);
    (0..last).step_by(stride.max(1)).chain(std::iter::once(last))
}

/// How many triangles a strip over so many nodes has, of which every `stride`-th is kept.
pub(super) fn strip_triangles(count: usize, stride: usize) -> usize {
    2 * (kept(count, stride).count() - 1)
}

/// Adds the two triangles between neighbours of a strip, whose corners are pairs: the −x edge, the +x edge.
pub(super) fn strip(shape: &mut Shape, first: u32, pairs: u32) {
    for at in (0..pairs.saturating_sub(1)).map(|k| first + 2 * k) {
        // x to the right and y onwards: counter-clockwise seen from +z.
        shape.triangles.extend([[at, at + 1, at + 2], [at + 2, at + 1, at + 3]]);
    }
}

/// The frame of a ribbon at a node, as the renderer has it there: unit vectors across to +x, along, and out of the upper side.
pub(super) fn frame(nodes: &[RibbonNode], at: usize) -> [Vec3; 3] {
    let along = RibbonNode::tangent(nodes, at).normalize_or(Vec3::Y);
    let across = nodes[at].across.normalize_or(Vec3::X);
    let z = across.cross(along).normalize_or(Vec3::Z);
    [along.cross(z), along, z]
}

/// Adds all ribbons of a geometry, of every `stride`-th of their nodes.
pub(super) fn add_ribbons(shape: &mut Shape, geometry: &Geometry, part: u32, stride: usize) {
    for ribbon in &geometry.ribbons {
        add_ribbon(shape, ribbon, geometry.nodes_of(ribbon), part, stride);
    }
}

fn add_ribbon(shape: &mut Shape, ribbon: &Ribbon, nodes: &[RibbonNode], part: u32, stride: usize) {
    let first = shape.vertices.len() as u32;
    let mut pairs = 0;
    for at in kept(nodes.len(), stride) {
        let [_, along, z] = frame(nodes, at);
        let node = &nodes[at];
        let vertex = Vertex {
            swelling: ribbon.swelling,
            half_width_mm: node.across.length(),
            part,
            ..Vertex::at(node.point, z, along, ribbon.id)
        };
        let cells = cells_along(ribbon, f64::from(node.arc)) as f32;
        for side in [-1.0_f32, 1.0] {
            let position_mm = (node.point + node.across * side).into();
            shape.push(Vertex { position_mm, place: [cells, side], ..vertex });
        }
        pairs += 1;
    }
    strip(shape, first, pairs);
}

/// How far along a ribbon an arc length is, in cells, as hits count them; half a cell where the whole ribbon is one.
pub(super) fn cells_along(ribbon: &Ribbon, arc_mm: f64) -> f64 {
    if ribbon.cell > 0.0 { arc_mm / f64::from(ribbon.cell) + f64::from(ribbon.phase) } else { 0.5 }
}

/// Adds all fibres of a geometry as strips in the plane of the vane, of every `stride`-th of their nodes.
pub(super) fn add_fibres(shape: &mut Shape, geometry: &Geometry, part: u32, stride: usize) {
    for curve in &geometry.curves {
        add_fibre(shape, geometry, curve, part, stride);
    }
}

fn add_fibre(shape: &mut Shape, geometry: &Geometry, curve: &Curve, part: u32, stride: usize) {
    let nodes = geometry.nodes_of_curve(curve);
    let first = shape.vertices.len() as u32;
    let mut pairs = 0;
    for at in kept(nodes.len(), stride) {
        let (before, after) = (at.saturating_sub(1), (at + 1).min(nodes.len() - 1));
        let along = (nodes[after].point - nodes[before].point).normalize_or(Vec3::Y);
        let node = &nodes[at];
        let normal = if node.vane_normal == Vec3::ZERO { Vec3::Z } else { node.vane_normal };
        let vertex =
            Vertex { half_width_mm: node.radius, part, ..Vertex::at(node.point, normal, along, curve.id) };
        let across = along.cross(normal).normalize_or(Vec3::X) * node.radius;
        for side in [-1.0_f32, 1.0] {
            let position_mm = (node.point + across * side).into();
            shape.push(Vertex { position_mm, place: [0.5, side], ..vertex });
        }
        pairs += 1;
    }
    strip(shape, first, pairs);
}

/// How many triangles the ribbons and fibres of a geometry have, of every `stride`-th of their nodes.
pub(super) fn strips_of(geometry: &Geometry, stride: usize) -> usize {
    let ribbons = geometry.ribbons.iter().map(|ribbon| strip_triangles(ribbon.count as usize, stride));
    let curves = geometry.curves.iter().map(|curve| strip_triangles(curve.count as usize, stride));
    ribbons.chain(curves).sum()
}

/// How many triangles the meshes of a geometry have.
pub(super) fn meshed(geometry: &Geometry) -> usize {
    geometry.meshes.iter().map(|mesh| mesh.triangles.len()).sum()
}

/// Adds the meshes of a geometry: those without normals with the faces' own.
pub(super) fn add_meshes(shape: &mut Shape, geometry: &Geometry, part: u32) {
    geometry.meshes.iter().for_each(|mesh| add_mesh(shape, mesh, mesh.id, part));
}

/// Adds a mesh under a name; its places are its texture coordinates.
pub(super) fn add_mesh(shape: &mut Shape, mesh: &Mesh, name: u64, part: u32) {
    let first = shape.vertices.len() as u32;
    let faces = if mesh.normals.is_empty() { face_normals(mesh) } else { Vec::new() };
    let normals = if mesh.normals.is_empty() { &faces } else { &mesh.normals };
    for (k, position) in mesh.positions.iter().enumerate() {
        let along = mesh.tangents.get(k).copied().unwrap_or(Vec3::Y);
        let place = mesh.uvs.get(k).map_or([0.5, 0.0], |uv| (*uv).into());
        shape.push(Vertex { place, part, ..Vertex::at(*position, normals[k], along, name) });
    }
    shape.triangles.extend(mesh.triangles.iter().map(|corners| corners.map(|corner| first + corner)));
}

/// At each corner the mean normal of its faces, by their areas.
fn face_normals(mesh: &Mesh) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
        let normal = (b - a).cross(c - a);
        corners.iter().for_each(|&corner| sums[corner as usize] += normal);
    }
    sums.into_iter().map(|sum| sum.normalize_or(Vec3::Z)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Naming;
    use barbule_appearance::scene::geometry::CurveNode;

    fn bent() -> Geometry {
        let node = |k: usize| {
            let angle = 0.2 * k as f32;
            RibbonNode {
                point: Vec3::new(0.1, angle.sin(), angle.cos()),
                across: Vec3::X * (0.05 - 0.005 * k as f32),
                arc: angle,
            }
        };
        let nodes: Vec<RibbonNode> = (0..7).map(node).collect();
        let mut geometry = Geometry::default();
        let ribbon = Ribbon { id: 9, cell: 0.5, phase: 0.25, swelling: 0.1, ..Ribbon::default() };
        geometry.add_ribbon(&nodes, ribbon);
        geometry
    }

    #[test]
    fn both_ends_are_kept_at_every_stride() {
        let of = |count, stride| kept(count, stride).collect::<Vec<_>>();
        assert_eq!(of(7, 1), [0, 1, 2, 3, 4, 5, 6]);
        assert_eq!((of(7, 2), of(7, 4), of(7, 99)), (vec![0, 2, 4, 6], vec![0, 4, 6], vec![0, 6]));
        assert_eq!((of(2, 1), strip_triangles(7, 3)), (vec![0, 1], 4));
    }

    #[test]
    fn ribbons_become_strips_with_their_edges_cells_and_upper_sides() {
        let geometry = bent();
        for stride in [1, 2, 9] {
            let mut shape = Shape::new(Naming::Ribbon);
            add_ribbons(&mut shape, &geometry, 3, stride);
            shape.check().unwrap();
            assert_eq!(shape.triangles.len(), strips_of(&geometry, stride));
            let last = shape.vertices[shape.vertices.len() - 1];
            assert_eq!((last.place, last.name, last.part), ([1.2 / 0.5 + 0.25, 1.0], [9, 0], 3));
            for corners in &shape.triangles {
                let [a, b, c] = corners.map(|corner| Vec3::from(shape.vertices[corner as usize].position_mm));
                let normal = Vec3::from(shape.vertices[corners[0] as usize].normal);
                assert!((b - a).cross(c - a).dot(normal) > 0.0);
            }
        }
    }

    #[test]
    fn fibres_lie_in_the_vane_and_meshes_keep_their_places() {
        let node = |x: f32| CurveNode { point: Vec3::new(x, 0.0, 0.0), radius: 0.1, vane_normal: Vec3::Z };
        let mut geometry = Geometry::default();
        geometry.add_curve(&[node(0.0), node(1.0), node(2.0)], 4);
        let mut shape = Shape::new(Naming::Ribbon);
        add_fibres(&mut shape, &geometry, 0, 1);
        shape.check().unwrap();
        assert_eq!(shape.triangles.len(), 4);
        assert!(shape.vertices.iter().all(|v| v.position_mm[1].abs() == 0.1 && v.normal == [0.0, 0.0, 1.0]));
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        add_mesh(&mut shape, &mesh, 5, 1);
        shape.check().unwrap();
        assert_eq!(shape.vertices[6].normal, [0.0, 0.0, 1.0]);
        assert_eq!(shape.triangles[4], [6, 7, 8]);
    }
}
