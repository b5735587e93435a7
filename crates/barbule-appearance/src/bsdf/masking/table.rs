//! Masking by lookup: what each direction sees, and where on each part.
//!
//! A weight of every pair of directions would need a table of four dimensions. What is kept of each direction instead is how
//! much of its light arrives at each of a few pieces of each part; the share that is both seen and lit follows from the
//! products of two such profiles, for any pair, and is the same when they are exchanged.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};

use super::vane::{Barbs, PARTS, RAMUS, VaneRows, flat};
use crate::math::elementary::{asin, atan2};

/// Pieces of a section's circumference.
const AROUND: usize = 24;
/// Pieces of a barbule's length.
const ALONG: usize = 16;
/// Steps of the angle across a row, of each half space.
const ANGLES: usize = 96;
/// Steps of the inclination along the barbs.
const INCLINATIONS: usize = 24;

/// Of each piece of a section: the share of the width seen that it is, then how much light arrives there.
type Section = [f32; 2 * AROUND];
/// Of each piece of a barbule's length: how much light arrives there.
type Length = [f32; ALONG];

/// Masking of a vane for all directions. Built once for a feather; lookups allocate nothing.
#[derive(Debug, Clone)]
pub struct MaskingTable {
    rows: VaneRows,
    /// Weights of each part and of what passes, `[side of the vane][angle][inclination]`.
    seen: Vec<[f32; PARTS + 1]>,
    /// Of a ramus among the barbs, likewise.
    rami: Vec<Section>,
    /// Of the barbules to the left and right among the barbs, likewise.
    sheets: [Vec<Length>; 2],
    /// Of a barbule in its row, `[left, right][side of the row][angle]`.
    barbules: [Vec<Section>; 2],
}

/// What of one part is seen from a direction.
#[derive(Debug, Clone, Copy)]
pub struct PartSeen {
    section: Section,
    /// All 1 for rami.
    along: Length,
}

impl MaskingTable {
    /// Cost: 4608 exact problems, of which those near the horizon see hundreds of parts: about 0.15 s, 1.6 MB. A lookup
    /// takes about 0.1 µs.
    #[must_use]
    pub fn new(barbs: &Barbs) -> Self {
        let rows = VaneRows::new(barbs);
        let mut directions = Vec::with_capacity(2 * ANGLES * INCLINATIONS);
        for half in [1.0, -1.0] {
            for i in 0..ANGLES {
                for j in 0..INCLINATIONS {
                    let (sin, cos) = libm::sincos(node(i, ANGLES));
                    let (sin_along, cos_along) = libm::sincos(node(j, INCLINATIONS));
                    directions.push(DVec3::new(cos_along * sin, sin_along, half * cos_along * cos));
                }
            }
        }
        let seen = directions.iter().map(|d| rows.seen(*d).map(|v| v as f32)).collect();
        let ramus = |d: &DVec3| section(&rows.barbs, RAMUS, flat(*d), &rows.transparencies(*d));
        let rami = directions.iter().map(ramus).collect();
        let sheets = [1, 2].map(|part| {
            let one = |d: &DVec3| {
                let mut profile = [0.0; ALONG];
                rows.barbs.profile(part, flat(*d), &rows.transparencies(*d), &mut profile);
                profile.map(|v| v as f32)
            };
            directions.iter().map(one).collect()
        });
        let barbules = [0, 1].map(|side: usize| {
            let one = |number: usize| {
                let (sin, cos) = libm::sincos(node(number % ANGLES, ANGLES));
                let toward = DVec2::new(sin, if number < ANGLES { cos } else { -cos });
                section(&rows.sides[side].row, 0, toward, &[0.0])
            };
            (0..2 * ANGLES).map(one).collect()
        });
        Self { rows, seen, rami, sheets, barbules }
    }

    /// Memory, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let sheets: usize = self.sheets.iter().map(|one| size_of_val(&**one)).sum();
        let barbules: usize = self.barbules.iter().map(|one| size_of_val(&**one)).sum();
        size_of_val(&*self.seen) + size_of_val(&*self.rami) + sheets + barbules
    }

    /// What is seen from a direction in the barb's frame, on either side of the vane: shares of the projected area of each
    /// part and of what passes; their sum is 1.
    #[must_use]
    pub fn seen(&self, direction: DVec3) -> [f64; PARTS + 1] {
        mixed(&self.seen, &nodes(direction)).map(f64::from)
    }

    /// What of a part is seen from a direction, in the barb's frame.
    #[inline]
    #[must_use]
    pub fn part(&self, part: usize, direction: DVec3) -> PartSeen {
        let nodes = nodes(direction);
        if part == RAMUS {
            return PartSeen { section: mixed(&self.rami, &nodes), along: [1.0; ALONG] };
        }
        let side = part - 1;
        let flat = self.rows.sides[side].flat(direction);
        let [i, rest] = between(angle_of(flat.x, flat.y), ANGLES);
        let start = i as usize + if flat.y >= 0.0 { 0 } else { ANGLES };
        let in_row = [(start, (1.0 - rest) as f32), (start + 1, rest as f32)];
        PartSeen { section: mixed(&self.barbules[side], &in_row), along: mixed(&self.sheets[side], &nodes) }
    }

    /// A place of a part's section that is seen from a direction, evenly over what is seen of it: its signed distance from the
    /// axis over half the width seen (see [`FibreSection::offset`](crate::bsdf::FibreSection::offset)), and the outward normal
    /// there; in the barb's frame. `u`: uniform, 0 … 1.
    #[must_use]
    pub fn place(&self, part: usize, seen: &PartSeen, wo: DVec3, u: f64) -> (f64, DVec3) {
        let (shares, arrives) = seen.section.split_at(AROUND);
        let weight = |i: usize| f64::from(shares[i] * arrives[i]);
        let mut rest = u * (0..AROUND).map(weight).sum::<f64>();
        let mut piece = 0;
        while piece < AROUND - 1 && rest >= weight(piece) {
            rest -= weight(piece);
            piece += 1;
        }
        let rest = (rest / weight(piece).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let span = [piece as f64 / AROUND as f64, (piece + 1) as f64 / AROUND as f64];
        self.rows.front_place(part, wo, span, rest)
    }
}

impl PartSeen {
    /// As [`VaneRows::lit`]: of what is seen, the share that is lit from another direction.
    #[must_use]
    pub fn lit(&self, light: &Self) -> f64 {
        let (mut both, mut own) = (0.0, 0.0);
        for (a, b) in self.along.iter().zip(&light.along) {
            both += a * b;
            own += a;
        }
        ratio(both, own) * lit_section(&self.section, &light.section)
    }
}

fn lit_section(seen: &Section, light: &Section) -> f64 {
    let ((shares, arrives), (other_shares, other_arrives)) = (seen.split_at(AROUND), light.split_at(AROUND));
    let (mut own, mut first, mut second) = (0.0, 0.0, 0.0);
    for i in 0..AROUND {
        let both = arrives[i] * other_arrives[i];
        own += shares[i] * arrives[i];
        first += shares[i] * both;
        second += other_shares[i] * both;
    }
    ratio(first.min(second), own)
}

fn ratio(both: f32, own: f32) -> f64 {
    if own > 0.0 { f64::from(both / own).min(1.0) } else { 0.0 }
}

/// Weighted sum of nodes.
#[inline(always)]
fn mixed<const N: usize>(table: &[[f32; N]], nodes: &[(usize, f32)]) -> [f32; N] {
    let mut sum = [0.0; N];
    for &(node, weight) in nodes {
        for (sum, value) in sum.iter_mut().zip(&table[node]) {
            *sum += value * weight;
        }
    }
    sum
}

/// Nodes of the vane's tables about a direction, and their weights.
#[inline(always)]
fn nodes(direction: DVec3) -> [(usize, f32); 4] {
    let inclination = asin(direction.y.clamp(-1.0, 1.0));
    let ([i, angle], [j, along]) =
        (between(angle_of(direction.x, direction.z), ANGLES), between(inclination, INCLINATIONS));
    let first = if direction.z >= 0.0 { 0 } else { ANGLES };
    let (start, next) = (
        (first + i as usize) * INCLINATIONS + j as usize,
        (first + i as usize + 1) * INCLINATIONS + j as usize,
    );
    [
        (start, ((1.0 - angle) * (1.0 - along)) as f32),
        (start + 1, ((1.0 - angle) * along) as f32),
        (next, (angle * (1.0 - along)) as f32),
        (next + 1, (angle * along) as f32),
    ]
}

fn section(row: &super::Row, part: usize, toward: DVec2, transparency: &[f64]) -> Section {
    let mut pieces = [0.0; 2 * AROUND];
    let (shares, profile) = pieces.split_at_mut(AROUND);
    row.shares(part, toward, shares);
    row.profile(part, toward, transparency, profile);
    pieces.map(|v| v as f32)
}

/// Middle of a step of an angle from −π/2 to π/2.
fn node(number: usize, count: usize) -> f64 {
    PI * ((number as f64 + 0.5) / count as f64 - 0.5)
}

/// The angle of a direction from the normal's line, −π/2 … π/2.
fn angle_of(sideways: f64, up: f64) -> f64 {
    atan2(sideways, up.abs())
}

/// The node before an angle, and how far on it lies to the next.
fn between(angle: f64, count: usize) -> [f64; 2] {
    let last = (count - 1) as f64;
    let at = ((angle + FRAC_PI_2) / PI * count as f64 - 0.5).clamp(0.0, last);
    let before = libm::floor(at).min(last - 1.0);
    [before, at - before]
}
