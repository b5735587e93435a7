//! Barbules: bent ribbons along both sides of a barb.

use glam::DVec3;

use super::barb::Barb;
use super::{BarbuleShape, Disorder, Grown, VaneDisc};
use crate::bsdf::{Arch, Cells, Markings, RAMUS_ROOT, Row, RowDisorder, axes};
use crate::math::rng::{Stream, hash};
use crate::scene::geometry::{Ribbon, RibbonNode};

/// Segments of a barbule.
const STEPS: usize = 6;

impl BarbuleShape {
    /// The row of such barbules on one side of a barb.
    #[must_use]
    pub fn row(&self, disorder: &Disorder) -> Row {
        Row {
            length: 1e-3 * self.length_um,
            half_width: 0.5e-3 * self.width_um,
            spacing: 1e-3 * self.spacing_um,
            angle: [self.base_angle, self.end_angle],
            lift: [self.base_lift, self.end_lift],
            tilt: self.tilt,
            root_tilt: self.root_tilt,
            cell: 1e-3 * self.cell_um,
            swelling: self.swelling,
            disorder: RowDisorder {
                angle: disorder.barbule_angle,
                lift: disorder.barbule_lift,
                spacing: disorder.barbule_spacing,
                length: disorder.barbule_length,
                turn: disorder.barbule_turn,
            },
        }
    }

    /// How such barbules differ from place to place.
    #[must_use]
    pub fn cells(&self, disorder: &Disorder) -> Cells {
        Cells {
            size: disorder.cell_size,
            barbule_size: disorder.barbule_size,
            wall_mm: 1e-3 * self.wall_um,
            arch: Arch::between([self.arch_low, self.arch_high], self.width_um),
        }
    }
}

/// Adds the barbules of one side of a barb (0: towards the feather's tip, 1: the other) whose bases lie in the window. `roll`, rad:
/// see [`super::envelope::roll`].
pub(super) fn along(
    grown: &mut Grown,
    barb: &Barb,
    row: &Row,
    which: usize,
    (roll, markings): (f64, &Markings),
    (origin, window): (DVec3, VaneDisc),
    seed: u64,
) {
    let count = (barb.length_mm / row.spacing) as usize;
    let mut nodes = Vec::new();
    for index in 0..count {
        let id = hash(seed, &[barb.id, 2, which as u64, index as u64]);
        let mut stream = Stream::new(id, &[]);
        let along = (index as f64 + 0.5 + row.disorder.spacing * stream.normal()) * row.spacing;
        let (base, ..) = barb.at(along);
        if !window.holds(base - origin) {
            continue;
        }
        let root = Root::on(barb, along, which, roll).moved(-origin);
        root.grow(&mut nodes, row, barb.fullness(along) * row.length_at(along / barb.length_mm), &mut stream);
        let ribbon = ribbon(row, id, &mut stream);
        let mark = barb.mark(markings, along, id);
        grown.barbules_at(barb.is_loose, which, mark).add_ribbon(&nodes, ribbon);
    }
}

/// A ribbon's cells.
pub(super) fn ribbon(row: &Row, id: u64, stream: &mut Stream) -> Ribbon {
    Ribbon {
        id,
        cell: row.cell as f32,
        phase: stream.unit() as f32,
        swelling: row.swelling as f32,
        ..Ribbon::default()
    }
}

/// Where a barbule is rooted: a place, and the directions along the barb, away from it and out of the vane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Root {
    pub at: DVec3,
    pub tangent: DVec3,
    pub sideways: DVec3,
    pub normal: DVec3,
}

impl Root {
    /// At an arc length of a barb, on one of its sides (0: towards the feather's tip, 1: the other).
    pub(super) fn on(barb: &Barb, along: f64, which: usize, roll: f64) -> Self {
        let (base, tangent, normal) = barb.at(along);
        let root = Self::of([base, tangent, normal], barb.side, which, roll);
        root.moved(root.sideways * (RAMUS_ROOT * barb.half_width(along / barb.length_mm)))
    }

    /// On the middle line of a barb left (−1) or right (1) of the shaft, of this place, tangent and normal.
    pub(super) fn of([at, tangent, normal]: [DVec3; 3], side: f64, which: usize, roll: f64) -> Self {
        // The side towards the feather's tip is to the left of a right barb and to the right of a left one.
        let distal = if which == 0 { 1.0 } else { -1.0 };
        let level = normal.cross(tangent) * (side * distal);
        // The row towards the feather's tip lies over the next barb's other one.
        let (rise, flat) = (libm::sin(distal * roll), libm::cos(roll));
        let (sideways, normal) = (level * flat + normal * rise, normal * flat - level * rise);
        Self { at, tangent, sideways, normal }
    }

    pub(super) fn moved(self, by: DVec3) -> Self {
        Self { at: self.at + by, ..self }
    }

    /// The nodes of a barbule of a row that is `usual` long if it is like most, mm.
    pub(super) fn grow(&self, nodes: &mut Vec<RibbonNode>, row: &Row, usual: f64, stream: &mut Stream) {
        let turn_angle = row.disorder.angle * stream.normal();
        let turn_lift = row.disorder.lift * stream.normal();
        let turn = row.disorder.turn * stream.normal();
        let bow = row.disorder.lift * stream.normal();
        let length = usual * (1.0 + row.disorder.length * stream.normal()).clamp(0.5, 1.5);
        let step = length / STEPS as f64;
        let mut at = self.at;
        let along = |t: f64| {
            let angle = row.angle_at(t) + turn_angle;
            let lift = row.lift_at(t) + turn_lift + bow * row.bow_at(t);
            axes([self.tangent, self.sideways, self.normal], angle, lift)
        };
        nodes.clear();
        for i in 0..=STEPS {
            let t = i as f64 / STEPS as f64;
            let [direction, ahead, up] = along(t);
            // Shingles: the turn about the barbule's own axis.
            let tilt = row.tilt_at(t) + turn;
            let plate = up * libm::cos(tilt) + ahead * libm::sin(tilt);
            let x = direction.cross(plate);
            nodes.push(RibbonNode {
                point: at.as_vec3(),
                across: (x * row.half_width_at(t)).as_vec3(),
                arc: (t * length) as f32,
            });
            let [middle, ..] = along(t + 0.5 / STEPS as f64);
            at += middle * step;
        }
    }
}
