//! The shaft: its centre line and its surface.

use std::f64::consts::TAU;

use glam::{DVec3, Vec2};

use super::{ShaftShape, VaneDisc};
use crate::math::rng::{Stream, hash};
use crate::scene::geometry::{Geometry, Mesh};

/// Steps of the centre line.
const STEPS: usize = 256;
/// Corners of the surface around the shaft.
const AROUND: usize = 96;

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

/// The centre line of a shaft.
pub struct Shaft {
    shape: ShaftShape,
    points: Vec<DVec3>,
}

impl Shaft {
    /// Integrates the headings along the arc length (midpoint rule).
    #[must_use]
    pub fn new(shape: &ShaftShape) -> Self {
        let step = shape.length_mm / STEPS as f64;
        let mut points = vec![DVec3::ZERO];
        let mut at = DVec3::ZERO;
        for i in 0..STEPS {
            at += heading(shape, (i as f64 + 0.5) / STEPS as f64) * step;
            points.push(at);
        }
        Self { shape: *shape, points }
    }

    /// The station at an arc length, mm; held at both ends.
    #[must_use]
    pub fn at(&self, along_mm: f64) -> Station {
        let t = (along_mm / self.shape.length_mm).clamp(0.0, 1.0);
        let position = t * STEPS as f64;
        let index = (position as usize).min(STEPS - 1);
        let point = self.points[index].lerp(self.points[index + 1], position - index as f64);
        let tip = heading(&self.shape, t);
        let right = tip.cross(DVec3::Z).normalize_or(DVec3::X);
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

    /// Height over width of the cross-section.
    #[must_use]
    pub fn height(&self) -> f64 {
        self.shape.height
    }

    /// Adds the surface within a window: a tube whose underside is flattened, with fine ridges along it.
    pub(super) fn mesh(&self, geometry: &mut Geometry, window: VaneDisc, origin: DVec3, identity: u64) {
        let ends = |radius: f64| (window.along_mm - 1.3 * radius, window.along_mm + 1.3 * radius, 40);
        let (from, to, rings) = window.radius_mm.map_or((0.0, f64::INFINITY, STEPS), ends);
        let (from, to) = (from.max(0.0), to.min(self.shape.length_mm));
        let ridges = Ridges::new(identity);
        let mut mesh = Mesh { id: hash(identity, &[0]), ..Mesh::default() };
        for ring in 0..=rings {
            let s = from + (to - from) * ring as f64 / rings as f64;
            let station = self.at(s);
            let radius = self.radius(s);
            for corner in 0..AROUND {
                let angle = TAU * corner as f64 / AROUND as f64;
                let (cos, sin) = (libm::cos(angle), libm::sin(angle));
                let height = self.shape.height * if sin < 0.0 { 0.7 } else { 1.0 };
                let (ridge, slope) = ridges.at(angle, s / self.shape.length_mm);
                let out = radius * (1.0 + ridge);
                let place = station.right * (out * cos) + station.normal * (out * height * sin);
                let round = (station.right * cos + station.normal * (sin / height)).normalize();
                let around = (station.normal * (cos * height) - station.right * sin).normalize();
                mesh.positions.push((station.point + place - origin).as_vec3());
                mesh.normals.push((round - around * slope).normalize().as_vec3());
                mesh.tangents.push(station.tip.as_vec3());
                mesh.uvs.push(Vec2::new(angle as f32, s as f32));
            }
        }
        mesh.triangles = tube_triangles(rings, AROUND);
        geometry.meshes.push(mesh);
    }
}

/// Fine ridges along a shaft: waves around it of random phase that drift slowly along it.
struct Ridges {
    /// Waves around the shaft, height over the radius, phase, turns of phase over the shaft's length.
    waves: [(f64, f64, f64, f64); 5],
}

impl Ridges {
    fn new(identity: u64) -> Self {
        let mut stream = Stream::new(identity, &[0, 1]);
        let waves = [9.0, 14.0, 21.0, 27.0, 33.0].map(|count| {
            let drift = stream.uniform(-3.0, 3.0);
            (count, 0.06 / count * stream.uniform(0.6, 1.4), TAU * stream.unit(), TAU * drift)
        });
        Self { waves }
    }

    /// Height over the radius, and its slope around the shaft.
    fn at(&self, angle: f64, along: f64) -> (f64, f64) {
        self.waves.iter().fold((0.0, 0.0), |(height, slope), &(count, size, phase, drift)| {
            let at = count * angle + phase + drift * along;
            (height + size * libm::sin(at), slope + size * count * libm::cos(at))
        })
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
