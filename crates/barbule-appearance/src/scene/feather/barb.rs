//! Barbs: where they leave the shaft, their curves and their rami.

use std::f64::consts::TAU;

use glam::{DVec3, Vec2};

use super::shaft::{Shaft, tube_triangles};
use super::{BarbShape, Feather, VaneDisc};
use crate::bsdf::{RAMUS_DEPTH, ramus_taper};
use crate::math::rng::{Stream, hash};
use crate::scene::geometry::{CurveNode, Geometry, Mesh};

/// Steps of a barb's curve.
const STEPS: usize = 24;
/// Corners of the surface around a ramus.
const AROUND: usize = 8;
/// Least sine of the insertion angle: barbs parallel to the shaft would never leave it.
const LEAST_SINE: f64 = 0.15;

/// One barb: a curve with the vane's normal along it.
#[derive(Debug, Clone)]
pub struct Barb {
    /// Points at equal steps of the arc length, mm.
    pub points: Vec<DVec3>,
    /// Unit tangents there.
    pub tangents: Vec<DVec3>,
    /// Unit normals of the vane there.
    pub normals: Vec<DVec3>,
    /// Length, mm.
    pub length_mm: f64,
    /// −1: left of the shaft, 1: right, seen from the dorsal side.
    pub side: f64,
    /// Identity.
    pub id: u64,
    /// Half the width of the ramus at the base, mm.
    pub radius_mm: f64,
    /// Arc length of its base on the shaft, mm.
    pub station_mm: f64,
}

/// All barbs of one side whose bases can reach into a window.
pub(super) fn along(
    feather: &Feather,
    shaft: &Shaft,
    side: f64,
    window: VaneDisc,
    seed: u64,
    identity: u64,
) -> Vec<Barb> {
    let shape = &feather.barbs;
    let [first, last] = shaft.vane_range();
    let side_name = u64::from(side > 0.0);
    let mut barbs = Vec::new();
    let mut s = first + 0.5e-3 * shape.spacing_um * Stream::new(seed, &[identity, side_name]).unit();
    let mut index = 0u64;
    while s < last {
        let t = shaft.vane(s);
        let smooth = t * t * (3.0 - 2.0 * t);
        let angle = shape.base_angle + (shape.tip_angle - shape.base_angle) * smooth;
        let id = hash(seed, &[identity, 1, side_name, index]);
        let reaches = |radius: f64| {
            let before = window.along_mm - (3.0 + 1.0 / angle.tan()) * radius;
            s > before && s < window.along_mm + 1.2 * radius
        };
        if window.radius_mm.is_none_or(reaches) {
            barbs.push(grow(feather, shaft, side, s, angle, id));
        }
        s += 1e-3 * shape.spacing_um / libm::sin(angle).max(LEAST_SINE);
        index += 1;
    }
    barbs
}

fn grow(feather: &Feather, shaft: &Shaft, side: f64, s: f64, angle: f64, id: u64) -> Barb {
    let shape = &feather.barbs;
    let mut stream = Stream::new(id, &[]);
    let disorder = &feather.disorder;
    let angle = angle + disorder.barb_angle * stream.normal();
    let s = s + disorder.barb_spacing * 1e-3 * shape.spacing_um * stream.normal();
    let station = shaft.at(s);
    let length = outline_length(shape, shaft, s, angle) * (1.0 + disorder.barb_length * stream.normal());
    let radius_mm = 0.5e-3 * shape.width_um;
    let step = length / STEPS as f64;
    // A slow wave keeps neighbouring barbs from being copies of each other.
    let (wave, phase) = (0.012 * stream.normal(), stream.unit() * TAU);
    let flat = |u: f64| {
        let turned = angle - shape.curl * u + wave * libm::sin(phase + 5.0 * u);
        (libm::sin(turned), libm::cos(turned))
    };
    let sink = |x: f64| shape.camber * x * x / shape.half_width_mm;
    let start = shaft.radius(s);
    let (mut x, mut y) = (0.75 * start, 0.0);
    let mut points = Vec::with_capacity(STEPS + 1);
    for i in 0..=STEPS {
        let z = 0.3 * start * shaft.height() - sink(x);
        points.push(station.point + station.right * (side * x) + station.tip * y + station.normal * z);
        let (sin, cos) = flat((i as f64 + 0.5) / STEPS as f64);
        x += sin * step;
        y += cos * step;
    }
    let tangents: Vec<DVec3> =
        (0..=STEPS).map(|i| (points[(i + 1).min(STEPS)] - points[i.saturating_sub(1)]).normalize()).collect();
    let normals = tangents
        .iter()
        .map(|t| {
            let slope = station.normal - *t * t.dot(station.normal);
            slope.normalize_or(station.normal)
        })
        .collect();
    Barb { points, tangents, normals, length_mm: length, side, id, radius_mm, station_mm: s }
}

/// Length at which a straight barb reaches the vane's outline, mm (bisection: the first crossing).
fn outline_length(shape: &BarbShape, shaft: &Shaft, s: f64, angle: f64) -> f64 {
    let (sin, cos) = (libm::sin(angle).max(LEAST_SINE), libm::cos(angle));
    let outline = |along: f64| shape.outline(shaft.vane(along));
    let outside = |l: f64| l * sin >= outline(s + l * cos);
    let longest = shape.half_width_mm / sin;
    let steps = 64;
    let mut high = longest;
    for i in 1..=steps {
        let l = longest * f64::from(i) / f64::from(steps);
        if outside(l) {
            high = l;
            break;
        }
    }
    let mut low = (high - longest / f64::from(steps)).max(0.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if outside(middle) { high = middle } else { low = middle }
    }
    high.max(0.05)
}

impl BarbShape {
    /// Half width of the vane at a share of its length, mm.
    fn outline(&self, t: f64) -> f64 {
        let t = t.clamp(0.0, 1.0);
        let (a, b) = (self.outline_base, self.outline_tip);
        let middle = a / (a + b);
        self.half_width_mm * libm::pow(t / middle, a) * libm::pow((1.0 - t) / (1.0 - middle), b)
    }

    /// Area of one side of a vane of this length, mm² (midpoint rule).
    pub(super) fn half_area(&self, vane_mm: f64) -> f64 {
        const PARTS: u32 = 200;
        let parts = (0..PARTS).map(|i| self.outline((f64::from(i) + 0.5) / f64::from(PARTS)));
        parts.sum::<f64>() * vane_mm / f64::from(PARTS)
    }
}

impl Barb {
    /// Whether any of it lies in the window.
    #[must_use]
    pub fn is_within(&self, origin: DVec3, window: VaneDisc) -> bool {
        self.points.iter().any(|p| window.holds(*p - origin))
    }

    /// Point, tangent and normal at an arc length, mm.
    #[must_use]
    pub fn at(&self, along_mm: f64) -> (DVec3, DVec3, DVec3) {
        let position = (along_mm / self.length_mm).clamp(0.0, 1.0) * STEPS as f64;
        let index = (position as usize).min(STEPS - 1);
        let rest = position - index as f64;
        let mix = |v: &[DVec3]| v[index].lerp(v[index + 1], rest);
        (mix(&self.points), mix(&self.tangents).normalize(), mix(&self.normals).normalize())
    }

    /// Half the width of the ramus at a share of its length, mm.
    #[must_use]
    pub fn half_width(&self, share: f64) -> f64 {
        self.radius_mm * ramus_taper(share)
    }

    /// Adds the ramus as a round fibre of its width.
    pub(super) fn fibre(&self, geometry: &mut Geometry, origin: DVec3) {
        let mut nodes = Vec::with_capacity(STEPS + 1);
        for ring in 0..=STEPS {
            let half = self.half_width(ring as f64 / STEPS as f64);
            let centre = self.points[ring] - self.normals[ring] * (RAMUS_DEPTH * half);
            nodes.push(CurveNode {
                point: (centre - origin).as_vec3(),
                radius: half as f32,
                vane_normal: self.normals[ring].as_vec3(),
            });
        }
        geometry.add_curve(&nodes, self.id);
    }

    /// Adds the ramus: a tube taller than wide.
    pub(super) fn mesh(&self, geometry: &mut Geometry, shape: &BarbShape, origin: DVec3) {
        let mut mesh = Mesh { id: self.id, ..Mesh::default() };
        for ring in 0..=STEPS {
            let share = ring as f64 / STEPS as f64;
            let (tangent, normal) = (self.tangents[ring], self.normals[ring]);
            let across = tangent.cross(normal);
            let half = self.half_width(share);
            // The ridge stands up from the plane of the barbules and its keel hangs below it.
            let centre = self.points[ring] - normal * (RAMUS_DEPTH * half * shape.height);
            for corner in 0..AROUND {
                let angle = TAU * corner as f64 / AROUND as f64;
                let (cos, sin) = (libm::cos(angle), libm::sin(angle));
                let place = across * (half * cos) + normal * (half * shape.height * sin);
                mesh.positions.push((centre + place - origin).as_vec3());
                let outward = across * cos + normal * (sin / shape.height);
                mesh.normals.push(outward.normalize().as_vec3());
                mesh.tangents.push(tangent.as_vec3());
                mesh.uvs.push(Vec2::new(angle as f32, (share * self.length_mm) as f32));
            }
        }
        mesh.triangles = tube_triangles(STEPS, AROUND);
        geometry.meshes.push(mesh);
    }
}
