//! Hummingbirds' melanosomes in three dimensions: discs in layers, each with air bubbles side by side.
//!
//! A layer's centres lie on a jittered hexagonal grid, turned at random, its discs have random sizes and flatten against their neighbours
//! (cells of the power diagram less half a gap), so that they cover as much of the plane as the section's do of its length.

use std::f64::consts::{PI, TAU};

use crate::math::rng::{Stream, hash, unit_of};
use crate::structure::species::{Hummingbird, NECK, Stacked};
use crate::{Error, Result};

/// A centre is moved off its grid by up to this part of the grid's step.
const JITTER: f64 = 0.2;

/// A disc is at most this many times as wide as one of its size alone, before it meets a neighbour.
const SWOLLEN: f64 = 1.3;

/// Places at which a layer's coverage is measured, and halvings of the gap that fits it.
const PROBES: usize = 4000;
const HALVINGS: usize = 14;

/// No layer has more discs.
const MOST_DISCS: f64 = 4e6;

/// All layers.
#[derive(Debug, Clone)]
pub(super) struct Pancakes {
    pub(super) layers: Vec<Layer>,
    /// Of the barbule.
    pub(super) thickness_um: f64,
    wall_um: f64,
    membrane_um: f64,
    bubble_spread_um: f64,
}

/// One layer of discs.
#[derive(Debug, Clone)]
pub(super) struct Layer {
    /// Of the middle, below the top.
    pub(super) depth_um: f64,
    air_um: f64,
    /// Half the thickness of a disc.
    half_um: f64,
    /// Half the length of a bubble.
    bubble_um: f64,
    /// Cosine and sine of the grid's turn; places of discs are in its own frame.
    turn: [f64; 2],
    /// Corner of the grid, its steps, and how many there are.
    origin_um: [f64; 2],
    step_um: [f64; 2],
    count: [usize; 2],
    gap_um: f64,
    discs: Vec<Disc>,
    seed: u64,
}

#[derive(Debug, Clone, Copy)]
struct Disc {
    centre_um: [f64; 2],
    radius_um: f64,
    /// Turn of its grid of bubbles.
    turn: [f64; 2],
}

/// Half thicknesses at a place, µm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Halves {
    /// Of the disc.
    pub(super) outer_um: f64,
    /// Of the air in it.
    pub(super) air_um: f64,
}

impl Pancakes {
    pub(super) fn new(
        bird: &Hummingbird,
        area_um: [f64; 2],
        seed: u64,
        index: usize,
        purpose: u64,
    ) -> Result<Self> {
        let (stacked, thickness_um) = bird.stacked(seed, index);
        let layer = |(number, stacked): (usize, &Stacked)| {
            let coverage = if number == 0 { bird.coverage_first } else { bird.coverage };
            Layer::new(bird, stacked, coverage, area_um, seed, &[index as u64, purpose, number as u64])
        };
        Ok(Self {
            layers: stacked.iter().enumerate().map(layer).collect::<Result<_>>()?,
            thickness_um,
            wall_um: bird.wall_um,
            membrane_um: bird.membrane_um,
            bubble_spread_um: bird.bubble_height_spread_um,
        })
    }

    /// What a layer has at a place.
    pub(super) fn at(&self, layer: &Layer, x_um: f64, y_um: f64) -> Halves {
        let [cos, sin] = layer.turn;
        let place = [cos * x_um + sin * y_um, cos * y_um - sin * x_um];
        let Some((index, edge)) = layer.nearest(place) else {
            return Halves { outer_um: 0.0, air_um: 0.0 };
        };
        let outer_um = rounded(edge, layer.half_um);
        let inner = edge - self.wall_um;
        if inner <= 0.0 {
            return Halves { outer_um, air_um: 0.0 };
        }
        let disc = layer.discs[index];
        let (off, cell) = layer.bubble(&disc, place, self.membrane_um);
        let spread = self.bubble_spread_um.min(0.5 * layer.air_um);
        let random = unit_of(hash(layer.seed, &[index as u64, cell[0] as u64, cell[1] as u64]));
        let height = 0.5 * (layer.air_um + spread * (2.0 * random - 1.0));
        let part = (off / layer.bubble_um).min(1.0);
        let scalloped = height * (1.0 - part * part).sqrt().max(NECK);
        Halves { outer_um, air_um: scalloped.min(rounded(inner, height)).min(outer_um) }
    }
}

/// Half the thickness at a distance from the edge of a plate whose rim is round.
fn rounded(edge: f64, half: f64) -> f64 {
    let short = (half - edge).max(0.0);
    (half * half - short * short).max(0.0).sqrt()
}

impl Layer {
    fn new(
        bird: &Hummingbird,
        stacked: &Stacked,
        coverage: f64,
        area_um: [f64; 2],
        seed: u64,
        path: &[u64],
    ) -> Result<Self> {
        let mut stream = Stream::new(seed, path);
        let (sin, cos) = libm::sincos(TAU * stream.unit());
        // Turned at will, the area lies in a square as wide as its diagonal.
        let area_um = [libm::hypot(area_um[0], area_um[1]); 2];
        let spread = bird.melanosome_length_spread;
        // ⟨U²⟩ of sizes U(1−s, 1+s).
        let mean_square = 1.0 + spread * spread / 3.0;
        let cell_um2 = 0.25 * PI * bird.melanosome_length_um.powi(2) * mean_square / coverage;
        let across = (cell_um2 * 2.0 / 3f64.sqrt()).sqrt();
        let step_um = [across, across * 0.75f64.sqrt()];
        // Two more on every side, so that all of the area has neighbours all around.
        let counts = [0, 1].map(|axis| (area_um[axis] / step_um[axis]).ceil() + 5.0);
        if counts[0] * counts[1] > MOST_DISCS {
            return Err(Error::input(format!(
                "a segment of {} × {} µm has {:.0} melanosomes in a layer, over {MOST_DISCS:.0}; make it shorter",
                area_um[0],
                area_um[1],
                counts[0] * counts[1]
            )));
        }
        let count = counts.map(|count| count as usize);
        let origin_um = [0, 1].map(|axis| -0.5 * area_um[axis] - (2.0 + stream.unit()) * step_um[axis]);
        let mut discs = Vec::with_capacity(count[0] * count[1]);
        for row in 0..count[1] {
            for column in 0..count[0] {
                let shift = [column as f64 + 0.5 * (row % 2) as f64, row as f64];
                let mut off = || JITTER * across * stream.uniform(-1.0, 1.0);
                let centre_um = [
                    origin_um[0] + shift[0] * step_um[0] + off(),
                    origin_um[1] + shift[1] * step_um[1] + off(),
                ];
                let size = stream.uniform(1.0 - spread, 1.0 + spread);
                let (sin, cos) = libm::sincos(TAU * stream.unit());
                let radius_um = 0.5 * bird.melanosome_length_um * size;
                discs.push(Disc { centre_um, radius_um, turn: [cos, sin] });
            }
        }
        let mut layer = Self {
            depth_um: stacked.depth_um,
            air_um: stacked.air_um,
            half_um: 0.5 * stacked.air_um + bird.wall_um,
            bubble_um: 0.5 * stacked.air_um * bird.bubble_aspect,
            turn: [cos, sin],
            origin_um,
            step_um,
            count,
            gap_um: 0.0,
            discs,
            seed: hash(seed, path),
        };
        layer.fit_gap(coverage, area_um, &mut stream);
        Ok(layer)
    }

    /// The gap between neighbours with which discs cover their part of the area.
    fn fit_gap(&mut self, coverage: f64, area_um: [f64; 2], stream: &mut Stream) {
        let probes: Vec<[f64; 2]> =
            (0..PROBES).map(|_| [0, 1].map(|axis| area_um[axis] * stream.uniform(-0.5, 0.5))).collect();
        let (mut low, mut high) = (0.0, 0.5 * self.step_um[0]);
        for _ in 0..HALVINGS {
            self.gap_um = 0.5 * (low + high);
            let covered = probes.iter().filter(|at| self.nearest(**at).is_some()).count();
            if covered as f64 > coverage * PROBES as f64 { low = self.gap_um } else { high = self.gap_um }
        }
    }

    /// The disc that holds a place, and how far from its edge the place is.
    fn nearest(&self, at: [f64; 2]) -> Option<(usize, f64)> {
        let row = ((at[1] - self.origin_um[1]) / self.step_um[1]).round() as isize;
        let (mut best, mut best_power) = (None, f64::INFINITY);
        for row in row - 1..=row + 1 {
            let shift = 0.5 * row.rem_euclid(2) as f64;
            let column = ((at[0] - self.origin_um[0]) / self.step_um[0] - shift).round() as isize;
            for column in column - 1..=column + 1 {
                let Some(index) = self.index(column, row) else { continue };
                let power = self.power(index, at);
                if power < best_power {
                    (best, best_power) = (Some((index, column, row)), power);
                }
            }
        }
        let (best, column, row) = best?;
        let disc = &self.discs[best];
        let mut edge = SWOLLEN * disc.radius_um - square(at, disc.centre_um).sqrt();
        // Neighbours' centres are at most so far away, which spares most roots.
        let farthest = 2.0 * self.step_um[0];
        let odd = row.rem_euclid(2);
        let around = [(-1, 0), (1, 0), (odd - 1, -1), (odd, -1), (odd - 1, 1), (odd, 1)];
        for (right, up) in around {
            let Some(index) = self.index(column + right, row + up) else { continue };
            let apart = self.power(index, at) - best_power;
            if apart < 2.0 * farthest * (edge + 0.5 * self.gap_um) {
                let distance = square(disc.centre_um, self.discs[index].centre_um).sqrt();
                edge = edge.min(0.5 * apart / distance - 0.5 * self.gap_um);
            }
        }
        (edge > 0.0).then_some((best, edge))
    }

    fn index(&self, column: isize, row: isize) -> Option<usize> {
        let inside = |k: isize, axis: usize| (0..self.count[axis] as isize).contains(&k);
        (inside(column, 0) && inside(row, 1)).then(|| row as usize * self.count[0] + column as usize)
    }

    /// The power of a place with respect to a disc.
    fn power(&self, index: usize, at: [f64; 2]) -> f64 {
        let Disc { centre_um, radius_um, .. } = self.discs[index];
        square(at, centre_um) - radius_um * radius_um
    }

    /// The distance to the centre of the nearest bubble of a disc, and which it is.
    fn bubble(&self, disc: &Disc, at: [f64; 2], membrane_um: f64) -> (f64, [i64; 2]) {
        let pitch = 2.0 * self.bubble_um + membrane_um;
        let off = [at[0] - disc.centre_um[0], at[1] - disc.centre_um[1]];
        let [cos, sin] = disc.turn;
        let local = [(cos * off[0] + sin * off[1]) / pitch, (cos * off[1] - sin * off[0]) / pitch];
        // The hexagonal grid is two rectangular ones.
        let tall = 3f64.sqrt();
        let nearest = |shift: [f64; 2]| {
            let cell = [(local[0] - shift[0]).round(), ((local[1] - shift[1]) / tall).round()];
            let centre = [cell[0] + shift[0], cell[1] * tall + shift[1]];
            (square(local, centre), [cell[0] as i64, 2 * cell[1] as i64 + i64::from(shift[0] > 0.0)])
        };
        let (a, b) = (nearest([0.0, 0.0]), nearest([0.5, 0.5 * tall]));
        let (squared, cell) = if a.0 <= b.0 { a } else { b };
        (pitch * squared.sqrt(), cell)
    }
}

fn square(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}
