//! Masking by lookup: what each direction sees, and where on each part.
//!
//! A weight of every pair of directions would need a table of four dimensions. What is kept of each direction instead is how
//! much of its light arrives at each of a few pieces of each part; the share that is both seen and lit follows from the
//! products of two such profiles, for any pair, and is the same when they are exchanged.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};

use super::row::Row;
use super::vane::{Barbs, PARTS, RAMUS, VaneRows, flat};
use crate::math::elementary::{asin, atan2};

/// Pieces of a section's circumference.
const AROUND: usize = 24;
/// Pieces of a barbule's length.
const ALONG: usize = 16;
/// Numbers of a direction for barbs: weights; shares of the ramus seen and its profile; profiles of both sides.
const OF_BARBS: usize = PARTS + 1 + 2 * AROUND + 2 * ALONG;
/// Numbers of a direction for barbules.
const OF_BARBULES: usize = 2 * AROUND;
/// Steps of the angle across a row, of each half space.
const ANGLES: usize = 96;
/// Steps of the inclination along the barbs.
const INCLINATIONS: usize = 24;

/// Masking of a vane for all directions. Built once for a feather; lookups allocate nothing.
#[derive(Debug, Clone)]
pub struct MaskingTable {
    rows: VaneRows,
    /// `[side of the vane][angle][inclination]`.
    barbs: Vec<[f32; OF_BARBS]>,
    /// `[left, right][side of the row][angle]`.
    barbules: [Vec<[f32; OF_BARBULES]>; 2],
}

/// What a direction sees.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    barbs: [f32; OF_BARBS],
    barbules: [[f32; OF_BARBULES]; 2],
}

impl MaskingTable {
    /// Cost: 4608 exact problems, of which those near the horizon see hundreds of parts: about 0.15 s, 1.6 MB. A lookup
    /// ([`MaskingTable::look`]) takes about 0.3 µs.
    #[must_use]
    pub fn new(barbs: &Barbs) -> Self {
        let rows = VaneRows::new(barbs);
        let mut table = Vec::with_capacity(2 * ANGLES * INCLINATIONS);
        for half in [1.0, -1.0] {
            for i in 0..ANGLES {
                for j in 0..INCLINATIONS {
                    let (sin, cos) = libm::sincos(node(i, ANGLES));
                    let (sin_along, cos_along) = libm::sincos(node(j, INCLINATIONS));
                    let direction = DVec3::new(cos_along * sin, sin_along, half * cos_along * cos);
                    table.push(of_barbs(&rows, direction));
                }
            }
        }
        let barbules = [0, 1].map(|side: usize| {
            let row: &Row = &rows.sides[side].row;
            let one = |number: usize| {
                let (sin, cos) = libm::sincos(node(number % ANGLES, ANGLES));
                let toward = DVec2::new(sin, if number < ANGLES { cos } else { -cos });
                let mut pieces = [0.0; OF_BARBULES];
                let (shares, profile) = pieces.split_at_mut(AROUND);
                row.shares(0, toward, shares);
                row.profile(0, toward, &[0.0], profile);
                pieces.map(|v| v as f32)
            };
            (0..2 * ANGLES).map(one).collect()
        });
        Self { rows, barbs: table, barbules }
    }

    /// Memory, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.barbs) + self.barbules.iter().map(|one| size_of_val(&**one)).sum::<usize>()
    }

    /// What a direction sees, in the barb's frame, on either side of the vane.
    #[must_use]
    pub fn look(&self, direction: DVec3) -> Look {
        let inclination = asin(direction.y.clamp(-1.0, 1.0));
        let ([i, angle], [j, along]) =
            (between(angle_of(direction.x, direction.z), ANGLES), between(inclination, INCLINATIONS));
        let first = if direction.z >= 0.0 { 0 } else { ANGLES };
        let mut look = Look { barbs: [0.0; OF_BARBS], barbules: [[0.0; OF_BARBULES]; 2] };
        for (step, weight) in [(0, 1.0 - angle), (1, angle)] {
            let start = (first + i as usize + step) * INCLINATIONS + j as usize;
            for (node, weight) in [(start, weight * (1.0 - along)), (start + 1, weight * along)] {
                add(&mut look.barbs, &self.barbs[node], weight);
            }
        }
        for (side, look) in look.barbules.iter_mut().enumerate() {
            let flat = self.rows.sides[side].flat(direction);
            let [i, angle] = between(angle_of(flat.x, flat.y), ANGLES);
            let start = i as usize + if flat.y >= 0.0 { 0 } else { ANGLES };
            add(look, &self.barbules[side][start], 1.0 - angle);
            add(look, &self.barbules[side][start + 1], angle);
        }
        look
    }
}

impl Look {
    /// Shares of the projected area of each part and of what passes; their sum is 1.
    #[must_use]
    pub fn seen(&self) -> [f64; PARTS + 1] {
        let [ramus, left, right, passing, ..] = self.barbs;
        [ramus, left, right, passing].map(f64::from)
    }

    /// As [`VaneRows::lit`], of the light from another direction.
    #[must_use]
    pub fn lit(&self, light: &Self) -> [f64; PARTS] {
        const SECTIONS: usize = PARTS + 1 + 2 * AROUND;
        let mut lit = [0.0; PARTS];
        lit[RAMUS] = lit_section(&self.barbs[PARTS + 1..SECTIONS], &light.barbs[PARTS + 1..SECTIONS]);
        for side in 0..2 {
            let pieces = SECTIONS + side * ALONG..SECTIONS + (side + 1) * ALONG;
            let (mut both, mut own) = (0.0, 0.0);
            for (a, b) in self.barbs[pieces.clone()].iter().zip(&light.barbs[pieces]) {
                both += a * b;
                own += a;
            }
            let of_row = lit_section(&self.barbules[side], &light.barbules[side]);
            lit[1 + side] = ratio(both, own) * of_row;
        }
        lit
    }
}

/// Of what is seen of an ellipse the share that is lit; each is the shares of its pieces and what arrives there.
fn lit_section(seen: &[f32], light: &[f32]) -> f64 {
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

#[inline(always)]
fn add<const N: usize>(sum: &mut [f32; N], node: &[f32; N], weight: f64) {
    let weight = weight as f32;
    for (sum, value) in sum.iter_mut().zip(node) {
        *sum += value * weight;
    }
}

fn of_barbs(rows: &VaneRows, direction: DVec3) -> [f32; OF_BARBS] {
    let (toward, transparencies) = (flat(direction), rows.transparencies(direction));
    let mut numbers = [0.0; OF_BARBS];
    let (weights, rest) = numbers.split_at_mut(PARTS + 1);
    weights.copy_from_slice(&rows.seen(direction));
    let (shares, rest) = rest.split_at_mut(AROUND);
    rows.barbs.shares(RAMUS, toward, shares);
    let (profile, rest) = rest.split_at_mut(AROUND);
    rows.barbs.profile(RAMUS, toward, &transparencies, profile);
    for (side, profile) in rest.chunks_exact_mut(ALONG).enumerate() {
        rows.barbs.profile(side + 1, toward, &transparencies, profile);
    }
    numbers.map(|v| v as f32)
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
