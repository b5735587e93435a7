//! The shaft: its centre line, its frames and its surface.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec2};

use super::section::{Ridges, Section};
use super::{ShaftShape, VaneDisc};
use crate::math::rng::hash;
use crate::scene::geometry::{Geometry, Mesh};

/// Steps of the centre line.
const STEPS: usize = 256;
/// Corners of the surface around the shaft.
const AROUND: usize = 96;
/// Rings over a part of a shaft.
const PART_RINGS: usize = 40;
/// Further rings over the blunt end of a whole one.
const BLUNT_RINGS: usize = 16;
/// Share of the length over which the quill's end is blunted.
const BLUNT_SHARE: f64 = 0.05;

/// A point of the shaft with the vane's frame there.
#[derive(Debug, Clone, Copy)]
pub struct Station {
    /// On the centre line, mm.
    pub point: DVec3,
    /// To the right in the vane.
    pub right: DVec3,
    /// Towards the tip.
    pub tip: DVec3,
    /// Dorsal normal.
    pub normal: DVec3,
}

/// The centre line of a shaft with a frame that turns about it by the shaft's torsion only.
pub struct Shaft {
    shape: ShaftShape,
    points: Vec<DVec3>,
    rights: Vec<DVec3>,
}

impl Shaft {
    /// Integrates the headings along the arc length (midpoint rule) and carries the frame along it without rotation
    /// (double reflection; Wang, Jüttler, Zheng & Liu 2008), then turned by the torsion.
    #[must_use]
    pub fn new(shape: &ShaftShape) -> Self {
        let step = shape.length_mm / STEPS as f64;
        let mut points = vec![DVec3::ZERO];
        let mut at = DVec3::ZERO;
        for i in 0..STEPS {
            at += heading(shape, (i as f64 + 0.5) / STEPS as f64) * step;
            points.push(at);
        }
        let mut tip = heading(shape, 0.0);
        let mut right = tip.cross(DVec3::Z).normalize_or(DVec3::X);
        let mut rights = Vec::with_capacity(points.len());
        for i in 0..=STEPS {
            let turn = shape.torsion * i as f64 / STEPS as f64;
            rights.push(right * libm::cos(turn) + right.cross(tip) * libm::sin(turn));
            if i < STEPS {
                let next = heading(shape, (i as f64 + 1.0) / STEPS as f64);
                (right, tip) = (carried(right, tip, points[i + 1] - points[i], next), next);
            }
        }
        Self { shape: *shape, points, rights }
    }

    /// The station at an arc length, mm; before the base and past the tip straight on.
    #[must_use]
    pub fn at(&self, along_mm: f64) -> Station {
        let t = (along_mm / self.shape.length_mm).clamp(0.0, 1.0);
        let position = t * STEPS as f64;
        let index = (position as usize).min(STEPS - 1);
        let rest = position - index as f64;
        let tip = heading(&self.shape, t);
        let past = along_mm - t * self.shape.length_mm;
        let point = self.points[index].lerp(self.points[index + 1], rest) + tip * past;
        let right = self.rights[index].lerp(self.rights[index + 1], rest);
        let right = (right - tip * tip.dot(right)).normalize();
        Station { point, right, tip, normal: right.cross(tip) }
    }

    /// Half the width at an arc length, mm.
    #[must_use]
    pub fn radius(&self, along_mm: f64) -> f64 {
        let shape = &self.shape;
        let rest = (1.0 - along_mm / shape.length_mm) / (1.0 - shape.calamus);
        if rest >= 1.0 {
            return shape.radius_mm;
        }
        (shape.radius_mm * libm::pow(rest.max(0.0), shape.taper)).max(shape.tip_radius_mm)
    }

    /// The same of the surface: blunted at the quill's end, down to the opening there.
    fn surface_radius(&self, along_mm: f64) -> f64 {
        let short = 1.0 - (along_mm / (BLUNT_SHARE * self.shape.length_mm)).clamp(0.0, 1.0);
        let round = libm::sqrt(1.0 - short * short);
        self.radius(along_mm) * (self.shape.umbilicus + (1.0 - self.shape.umbilicus) * round)
    }

    /// Position of an arc length in the vane: 0 at the first barb, 1 at the tip.
    #[must_use]
    pub fn vane(&self, along_mm: f64) -> f64 {
        (along_mm / self.shape.length_mm - self.shape.calamus) / (1.0 - self.shape.calamus)
    }

    /// Arc length of the first barb and of the tip, mm.
    #[must_use]
    pub fn vane_range(&self) -> [f64; 2] {
        [self.shape.calamus * self.shape.length_mm, self.shape.length_mm]
    }

    /// Height over width of the cross-section at an arc length.
    #[must_use]
    pub fn height(&self, along_mm: f64) -> f64 {
        self.shape.height_at((along_mm / self.shape.length_mm).clamp(0.0, 1.0))
    }

    /// Adds the surface within a window: a tube, closed at the tip and, but for the opening's rim, at the base.
    pub(super) fn mesh(&self, geometry: &mut Geometry, window: VaneDisc, origin: DVec3, identity: u64) {
        let length = self.shape.length_mm;
        let stations: Vec<f64> = match window.radius_mm {
            Some(radius) => {
                let from = (window.along_mm - 1.3 * radius).clamp(0.0, length);
                let to = (window.along_mm + 1.3 * radius).clamp(0.0, length);
                (0..=PART_RINGS).map(|i| from + (to - from) * i as f64 / PART_RINGS as f64).collect()
            }
            // The end is round: rings stand close where it turns fast.
            None => (0..BLUNT_RINGS)
                .map(|i| BLUNT_SHARE * libm::pow(i as f64 / BLUNT_RINGS as f64, 2.0))
                .chain((0..=STEPS).map(|i| BLUNT_SHARE + (1.0 - BLUNT_SHARE) * i as f64 / STEPS as f64))
                .map(|share| share * length)
                .collect(),
        };
        let ridges = Ridges::new(identity);
        let mut mesh = Mesh { id: hash(identity, &[0]), ..Mesh::default() };
        for &s in &stations {
            let radius = self.surface_radius(s);
            let section = Section::new(&self.shape, &ridges, s / length, radius);
            let step = 1e-4 * length;
            let slope = (self.surface_radius(s + step) - self.surface_radius(s - step)) / (2.0 * step);
            self.ring(&mut mesh, s, &section, slope, origin);
        }
        let rings = stations.len() - 1;
        mesh.triangles = tube_triangles(rings, AROUND);
        for (ring, is_tip) in [(0, false), (rings, true)] {
            self.cap(&mut mesh, stations[ring], ring, is_tip, origin);
        }
        geometry.meshes.push(mesh);
    }

    /// Adds a ring of corners; `slope`: of the radius along the shaft.
    fn ring(&self, mesh: &mut Mesh, s: f64, section: &Section<'_>, slope: f64, origin: DVec3) {
        let station = self.at(s);
        let place = |v: DVec2| station.right * v.x + station.normal * v.y;
        for corner in 0..AROUND {
            let angle = TAU * corner as f64 / AROUND as f64;
            let (point, normal) = section.at(angle);
            let outward = (place(normal) - station.tip * slope).normalize();
            mesh.positions.push((station.point + place(point) - origin).as_vec3());
            mesh.normals.push(outward.as_vec3());
            mesh.tangents.push(station.tip.as_vec3());
            mesh.uvs.push(Vec2::new(angle as f32, s as f32));
        }
    }

    /// Closes an end by a fan about its middle.
    fn cap(&self, mesh: &mut Mesh, s: f64, ring: usize, is_tip: bool, origin: DVec3) {
        let station = self.at(s);
        let outward = if is_tip { station.tip } else { -station.tip };
        let rim = ring * AROUND..(ring + 1) * AROUND;
        let first = mesh.positions.len() as u32;
        for corner in rim {
            let (position, tangent, uv) = (mesh.positions[corner], mesh.tangents[corner], mesh.uvs[corner]);
            mesh.positions.push(position);
            mesh.tangents.push(tangent);
            mesh.uvs.push(uv);
            mesh.normals.push(outward.as_vec3());
        }
        mesh.positions.push((station.point - origin).as_vec3());
        mesh.tangents.push(station.tip.as_vec3());
        mesh.uvs.push(Vec2::new(0.0, s as f32));
        mesh.normals.push(outward.as_vec3());
        let around = AROUND as u32;
        for corner in 0..around {
            let (one, next) = (first + corner, first + (corner + 1) % around);
            mesh.triangles.push(if is_tip {
                [first + around, next, one]
            } else {
                [first + around, one, next]
            });
        }
    }
}

/// The triangles of a tube of `rings` + 1 rings of `around` corners, counter-clockwise from outside.
pub(super) fn tube_triangles(rings: usize, around: usize) -> Vec<[u32; 3]> {
    let at = |ring: usize, corner: usize| (ring * around + corner % around) as u32;
    (0..rings)
        .flat_map(|ring| (0..around).map(move |corner| (ring, corner)))
        .flat_map(|(r, c)| {
            [[at(r, c), at(r + 1, c), at(r, c + 1)], [at(r, c + 1), at(r + 1, c), at(r + 1, c + 1)]]
        })
        .collect()
}

/// Direction of the shaft at a share t of its length.
fn heading(shape: &ShaftShape, t: f64) -> DVec3 {
    let turn = |linear: f64, quadratic: f64| linear * t + quadratic * t * t;
    let (psi, chi) = (turn(shape.bend, shape.bend_quadratic), turn(shape.arch, shape.arch_quadratic));
    let flat = libm::cos(chi);
    DVec3::new(libm::sin(psi) * flat, libm::cos(psi) * flat, libm::sin(chi))
}

/// A direction across a curve, carried over a step of it without turning about it.
fn carried(across: DVec3, tangent: DVec3, step: DVec3, next: DVec3) -> DVec3 {
    let reflected = |v: DVec3, by: DVec3| v - by * (2.0 * by.dot(v) / by.length_squared());
    let (across, tangent) = (reflected(across, step), reflected(tangent, step));
    let rest = next - tangent;
    let across = if rest.length_squared() < 1e-24 { across } else { reflected(across, rest) };
    (across - next * next.dot(across)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::feather::Feather;

    #[test]
    fn frames_do_not_turn_about_a_bent_shaft_but_by_its_torsion() {
        let mut shape = Feather::of_type("primary").unwrap().shaft;
        (shape.bend, shape.bend_quadratic, shape.arch, shape.arch_quadratic) = (0.7, 0.3, -0.5, 0.4);
        shape.torsion = 0.0;
        let length = shape.length_mm;
        let straight = Shaft::new(&shape);
        // Seen from the moving tangent, the frame stands still: its derivative has no part across.
        for i in 1..40 {
            let (a, b) = (
                straight.at(length * f64::from(i) / 40.0 - 0.05),
                straight.at(length * f64::from(i) / 40.0 + 0.05),
            );
            let turn = (b.right - a.right).dot(0.5 * (a.normal + b.normal)) / (b.tip - a.tip).length();
            assert!(turn.abs() < 0.02, "{i}: {turn}");
            assert!((a.right.cross(a.tip) - a.normal).length() < 1e-12);
        }
        shape.torsion = 0.6;
        let twisted = Shaft::new(&shape);
        for t in [0.0, 0.3, 1.0] {
            let (a, b) = (straight.at(t * length), twisted.at(t * length));
            assert!((a.right.angle_between(b.right) - 0.6 * t).abs() < 1e-3 && a.tip == b.tip, "{t}");
        }
        // The right vane rises where the torsion is positive: its normal leans left.
        assert!(twisted.at(length).right.dot(straight.at(length).normal) > 0.5);
    }

    #[test]
    fn a_whole_shaft_is_closed_and_ends_in_its_opening() {
        let shape = Feather::of_type("primary").unwrap().shaft;
        let mut geometry = Geometry::default();
        Shaft::new(&shape).mesh(&mut geometry, VaneDisc { along_mm: 0.0, radius_mm: None }, DVec3::ZERO, 1);
        let mesh = &geometry.meshes[0];
        // Volume by the divergence theorem: that of the circular quill and the tapering rest, within the section's shape.
        let at = |i: u32| mesh.positions[i as usize].as_dvec3();
        let volume: f64 = mesh.triangles.iter().map(|&[a, b, c]| at(a).dot(at(b).cross(at(c))) / 6.0).sum();
        let full = std::f64::consts::PI * shape.radius_mm * shape.radius_mm * shape.length_mm;
        assert!((0.1..0.9).contains(&(volume / full)), "{volume} {full}");
        // Every corner's normal faces as its triangles do.
        for &[a, b, c] in &mesh.triangles {
            let face = (at(b) - at(a)).cross(at(c) - at(a));
            let normal = mesh.normals[a as usize].as_dvec3();
            assert!(face.length() < 1e-9 || face.normalize().dot(normal) > -0.2, "{face} {normal}");
        }
        let rim = (0..AROUND).map(|i| at(i as u32).length()).fold(0.0, f64::max);
        assert!((rim / shape.radius_mm - shape.umbilicus).abs() < 0.06 * shape.umbilicus + 0.02, "{rim}");
    }
}
