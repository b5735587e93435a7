//! Barbules that repeat: a row is made of short stretches, of which there are some of each length of barbules, placed along all barbs.
//!
//! A primary has a million barbules and a few hundred stretches in a hundred thousand places. What light does among them is what it
//! does among barbules that grew one by one; only their draws repeat, and not their instances.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};

use super::VaneDisc;
use super::barb::Barb;
use super::barbule::{Root, ribbon};
use crate::bsdf::{Mark, Markings, Row};
use crate::math::rng::{Stream, hash, split_mix, unit_of};
use crate::scene::geometry::{Geometry, Place};

/// About how long a stretch is, mm: over it a barb turns by less than barbules differ.
pub(super) const LENGTH_MM: f64 = 0.25;
/// Lengths of barbules over those in the middle of a barb, and how many stretches there are of each. The long ones are the most seen.
const KINDS: [(f64, u64); 8] =
    [(0.1, 4), (0.2, 4), (0.35, 4), (0.5, 6), (0.65, 12), (0.8, 32), (0.9, 40), (1.0, 48)];

/// How many stretches there are of a row.
pub(super) const MADE: u64 = {
    let (mut sum, mut kind) = (0, 0);
    while kind < KINDS.len() {
        sum += KINDS[kind].1;
        kind += 1;
    }
    sum
};

/// The stretches of the rows of one side of the barbs left or right of the shaft.
pub(super) struct Stretches {
    row: Row,
    /// 0: towards the feather's tip, 1: the other.
    which: usize,
    roll: f64,
    seed: u64,
    /// Barbules of a stretch.
    count: usize,
    /// Of each kind, those that were made.
    made: [Vec<Stretch>; KINDS.len()],
}

/// One stretch: its barbules, and where they stand, apart by marks.
struct Stretch {
    geometry: Geometry,
    places: BTreeMap<Mark, Vec<Place>>,
}

impl Stretches {
    /// Makes them: `side`, −1 or 1, of the barbs; `roll`, rad: see [`super::envelope::roll`].
    pub(super) fn new(row: Row, side: f64, which: usize, roll: f64, seed: u64) -> Self {
        let count = libm::round(LENGTH_MM / row.spacing).max(1.0) as usize;
        let name = hash(seed, &[4, which as u64, u64::from(side > 0.0)]);
        let made = std::array::from_fn(|kind| {
            let (longest, variants) = KINDS[kind];
            (0..variants)
                .map(|variant| Stretch {
                    geometry: barbules(
                        &row,
                        (side, which, roll),
                        longest,
                        count,
                        hash(name, &[kind as u64, variant]),
                    ),
                    places: BTreeMap::new(),
                })
                .collect()
        });
        Self { row, which, roll, seed, count, made }
    }

    /// Places stretches along a barb, from its end to its base, where they lie in the window.
    pub(super) fn along(&mut self, barb: &Barb, markings: &Markings, (origin, window): (DVec3, VaneDisc)) {
        let length = self.count as f64 * self.row.spacing;
        for index in 0..libm::round(barb.length_mm / length) as u64 {
            let along = barb.length_mm - (index as f64 + 0.5) * length;
            let (base, tangent, normal) = barb.at(along.max(0.0));
            if !window.holds(base - origin) {
                continue;
            }
            let id = hash(self.seed, &[barb.id, 3, self.which as u64, index]);
            let root = Root::on(barb, along.max(0.0), self.which, self.roll);
            let across = tangent.cross(normal).normalize_or(DVec3::X);
            let place = Place {
                scale: 1.0,
                turn: DMat3::from_cols(across, tangent, across.cross(tangent)),
                shift: root.at - origin,
                id,
            };
            let share = (along / barb.length_mm).clamp(0.0, 1.0);
            let longest = barb.fullness(along) * self.row.length_at(share) / self.row.length;
            let mark = barb.mark(markings, along, id);
            self.pick(longest, id).places.entry(mark).or_default().push(place);
        }
    }

    /// A stretch whose barbules are so long over the longest: of the kinds below and above with the chances that keep the mean.
    fn pick(&mut self, longest: f64, name: u64) -> &mut Stretch {
        let above = KINDS.iter().position(|(kind, _)| *kind >= longest).unwrap_or(KINDS.len() - 1).max(1);
        let (low, high) = (KINDS[above - 1].0, KINDS[above].0);
        let draw = split_mix(name ^ 0x9e6c_63d0_876a_3f00);
        let kind = if unit_of(draw) < (longest - low) / (high - low) { above } else { above - 1 };
        let made = &mut self.made[kind];
        let count = made.len() as u64;
        &mut made[(split_mix(draw) % count) as usize]
    }

    /// The barbules in their places, with what marks them.
    pub(super) fn placed(self) -> impl Iterator<Item = (Mark, Geometry)> {
        self.made.into_iter().flatten().flat_map(|Stretch { geometry, places }| {
            places.into_iter().map(move |(mark, places)| (mark, Geometry { places, ..geometry.clone() }))
        })
    }
}

/// The barbules of a stretch of a straight barb along y, about the origin; z is the vane's normal.
fn barbules(
    row: &Row,
    (side, which, roll): (f64, usize, f64),
    longest: f64,
    count: usize,
    name: u64,
) -> Geometry {
    let mut geometry = Geometry::default();
    let mut nodes = Vec::new();
    for index in 0..count {
        let id = hash(name, &[index as u64]);
        let mut stream = Stream::new(id, &[]);
        let along =
            (index as f64 + 0.5 - 0.5 * count as f64 + row.disorder.spacing * stream.normal()) * row.spacing;
        let root = Root::of([DVec3::Y * along, DVec3::Y, DVec3::Z], side, which, roll);
        root.grow(&mut nodes, row, longest * row.length, &mut stream);
        geometry.add_ribbon(&nodes, ribbon(row, id, &mut stream));
    }
    geometry
}
