//! Barbules: bent ribbons along both sides of a barb.

use glam::DVec3;

use super::barb::Barb;
use super::{BarbuleShape, Disorder, VaneDisc};
use crate::math::rng::{Stream, hash};
use crate::scene::geometry::{Geometry, Ribbon, RibbonNode};

/// Segments of a barbule.
const STEPS: usize = 6;

/// Adds the barbules of one side of a barb (0: towards the feather's tip, 1: the other) whose bases lie in the window.
pub(super) fn along(
    geometry: &mut Geometry,
    barb: &Barb,
    shape: &BarbuleShape,
    disorder: &Disorder,
    which: usize,
    (origin, window): (DVec3, VaneDisc),
    seed: u64,
) {
    let spacing = 1e-3 * shape.spacing_um;
    let count = (barb.length_mm / spacing) as usize;
    let mut nodes = Vec::new();
    for index in 0..count {
        let id = hash(seed, &[barb.id, 2, which as u64, index as u64]);
        let mut stream = Stream::new(id, &[]);
        let along = (index as f64 + 0.5 + disorder.barbule_spacing * stream.normal()) * spacing;
        let (base, ..) = barb.at(along);
        if !window.holds(base - origin) {
            continue;
        }
        nodes.clear();
        grow(&mut nodes, barb, shape, disorder, which, along, origin, &mut stream);
        let ribbon = Ribbon {
            id,
            cell: (1e-3 * shape.cell_um) as f32,
            phase: stream.unit() as f32,
            swelling: shape.swelling as f32,
            ..Ribbon::default()
        };
        geometry.add_ribbon(&nodes, ribbon);
    }
}

fn grow(
    nodes: &mut Vec<RibbonNode>,
    barb: &Barb,
    shape: &BarbuleShape,
    disorder: &Disorder,
    which: usize,
    along: f64,
    origin: DVec3,
    stream: &mut Stream,
) {
    let share = along / barb.length_mm;
    let (base, tangent, normal) = barb.at(along);
    // The side towards the feather's tip is to the left of a right barb and to the right of a left one.
    let distal = if which == 0 { 1.0 } else { -1.0 };
    let sideways = normal.cross(tangent) * (barb.side * distal);
    let turn_angle = disorder.barbule_angle * stream.normal();
    let turn_lift = disorder.barbule_lift * stream.normal();
    let turn = disorder.barbule_turn * stream.normal();
    let bow = 0.5 * disorder.barbule_lift * stream.normal();
    // Shorter where the barb begins and near its end.
    let grown = (0.75 + 0.25 * libm::sin(std::f64::consts::PI * libm::pow(share.clamp(0.0, 1.0), 0.7)))
        * ((1.0 - share) / 0.15).clamp(0.15, 1.0);
    let length =
        1e-3 * shape.length_um * grown * (1.0 + disorder.barbule_length * stream.normal()).clamp(0.5, 1.5);
    let step = length / STEPS as f64;
    let mut at = base + sideways * (0.8 * barb.half_width(share));
    for i in 0..=STEPS {
        let t = i as f64 / STEPS as f64;
        let mix = |base: f64, end: f64| base + (end - base) * t;
        let angle = mix(shape.base_angle, shape.end_angle) + turn_angle;
        let lift = mix(shape.base_lift, shape.end_lift) + turn_lift + bow * (2.0 * t - 1.0);
        let planar = tangent * libm::cos(angle) + sideways * libm::sin(angle);
        let direction = planar * libm::cos(lift) + normal * libm::sin(lift);
        let up = (normal - direction * normal.dot(direction)).normalize();
        // Across, towards the barb's tip: the shingles' slope turns about the barbule's own axis.
        let ahead = (tangent - direction * tangent.dot(direction)).normalize_or(sideways);
        let tilt = shape.tilt + turn + shape.root_tilt * (1.0 - 10.0 * t).max(0.0);
        let plate = up * libm::cos(tilt) + ahead * libm::sin(tilt);
        let x = direction.cross(plate);
        let half = 0.5e-3 * shape.width_um * width_profile(t);
        nodes.push(RibbonNode {
            point: (at - origin).as_vec3(),
            across: (x * half).as_vec3(),
            arc: (t * length) as f32,
        });
        at += direction * step;
    }
}

/// Width along a barbule over its largest: narrower at the root, then full, then a thin end.
fn width_profile(t: f64) -> f64 {
    let root = 0.65 + 0.35 * (t / 0.12).min(1.0);
    let end = if t < 0.6 { 1.0 } else { 1.0 - 0.8 * libm::pow((t - 0.6) / 0.4, 1.5) };
    root * end
}
