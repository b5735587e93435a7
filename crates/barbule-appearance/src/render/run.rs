//! Running the integrator over the film: rounds of samples over tiles, until a count, a noise target or a time.

use std::time::Duration;

use fearless_simd::{Level, Simd};
use rayon::prelude::*;

use super::faults::{Fault, is_possible};
use super::film::{Film, Tile};
use super::integrator::{Behind, Integrator, NO_HIT, Shot};
use super::light::Glow;
use super::response::{EYE, Response, Rows};
use crate::math::simd::dispatch_large;
use crate::progress::{Clock, Progress};
use crate::spectrum::sensor::MOST_CHANNELS;
use crate::{Error, Result};

/// When a picture is done.
#[derive(Debug, Clone, Copy)]
pub struct Goal {
    /// Most samples per pixel.
    pub samples: u32,
    /// A tile is done earlier when the standard error of its mean luminance per pixel, relative to the luminance (with
    /// 0.05 added), is below this on average; `None`: never.
    pub noise: Option<f64>,
    /// `None`: no limit.
    pub time: Option<TimeLimit>,
    /// Samples per pixel of a round, 1 to [`ROUND`]: fewer, and the whole picture is there sooner. The film's bits are the
    /// same.
    pub round: u32,
}

/// How long a picture may take.
#[derive(Debug, Clone, Copy)]
pub struct TimeLimit {
    /// No new round begins that would likely end later than this.
    pub most: Duration,
    /// By this clock.
    pub clock: Clock,
}

/// Samples per pixel after which noise is looked at, and usually of a round.
pub const ROUND: u32 = 8;

/// Side of the blocks of pixels that are asked together whether any of their rays may meet a surface.
const BLOCK: u32 = 4;

impl Goal {
    /// So many samples per pixel, however noisy they leave it and however long they take.
    #[must_use]
    pub fn samples(samples: u32) -> Self {
        Self { samples, noise: None, time: None, round: ROUND }
    }
}

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// All tiles reached the sample count or the noise target.
    Done,
    /// The time was over.
    OutOfTime,
    /// The progress asked to stop.
    Stopped,
}

/// Adds rounds to a film until the goal is reached. Every tile's samples are summed in their order, so the film is the
/// same bits for any number of threads and however often a run was interrupted.
///
/// # Errors
/// A goal out of range, or a sensor that sees wavelengths for which the scene has no values.
pub fn run(
    integrator: &Integrator<'_>,
    film: &mut Film,
    seed: u64,
    goal: Goal,
    progress: &dyn Progress,
    after_round: &mut dyn FnMut(&Film) -> Result<()>,
) -> Result<Ended> {
    if goal.samples == 0 || goal.samples > 1 << 24 {
        return Err(Error::input(format!("{} samples per pixel: give 1 to 16777216", goal.samples)));
    }
    integrator.check(&film.planes().sensor)?;
    let glow = integrator.glow(film.response());
    let now = || goal.time.map_or(Duration::ZERO, |limit| (limit.clock)());
    let start = now();
    let mut slowest = Duration::ZERO;
    let most = film.tiles.iter().map(|tile| u64::from(goal.samples.saturating_sub(tile.count))).sum();
    progress.begin("rendering", most);
    loop {
        let open: Vec<usize> = (0..film.tiles()).filter(|&t| !is_done(film, t, &goal)).collect();
        if open.is_empty() {
            return Ok(Ended::Done);
        }
        if progress.is_cancelled() {
            return Ok(Ended::Stopped);
        }
        let begun = now();
        if goal.time.is_some_and(|limit| slowest > Duration::ZERO && begun - start + slowest > limit.most) {
            return Ok(Ended::OutOfTime);
        }
        round((integrator, &glow), film, seed, &goal, &open, progress);
        slowest = slowest.max(now() - begun);
        after_round(film)?;
    }
}

/// One round of all open tiles; a tile that a cancellation kept from starting stays as it was.
fn round(
    scene: (&Integrator<'_>, &Glow),
    film: &mut Film,
    seed: u64,
    goal: &Goal,
    open: &[usize],
    progress: &dyn Progress,
) {
    let done: Vec<Option<Tile>> = open
        .par_iter()
        .map(|&tile| {
            if progress.is_cancelled() {
                return None;
            }
            let from = film.tiles[tile].count;
            let step = goal.round.clamp(1, ROUND);
            let to = goal.samples.min((from / ROUND + 1) * ROUND).min(from + step);
            let grown = grown(scene, film, tile, seed, to);
            progress.advance(u64::from(to - from));
            Some(grown)
        })
        .collect();
    for (&tile, grown) in open.iter().zip(done) {
        if let Some(grown) = grown {
            film.tiles[tile] = grown;
        }
    }
}

/// A tile with so many samples per pixel.
fn grown(scene: (&Integrator<'_>, &Glow), film: &Film, tile: usize, seed: u64, samples: u32) -> Tile {
    let mut grown = film.tiles[tile].clone();
    dispatch_large!(Level::new(), simd => grow(simd, scene, film, (tile, &mut grown), seed, samples));
    grown
}

/// Compiled for each instruction set: paths of eight wavelengths are loops over arrays of eight.
#[inline(always)]
fn grow<S: Simd>(
    _simd: S,
    (integrator, glow): (&Integrator<'_>, &Glow),
    film: &Film,
    (number, tile): (usize, &mut Tile),
    seed: u64,
    samples: u32,
) {
    let ([x0, y0, x1, y1], size) = (film.bounds(number), film.size());
    let (planes, response) = (film.planes(), film.response());
    let density = planes.sensor.density();
    let view = integrator.view(size);
    let blocks = (x1 - x0).div_ceil(BLOCK);
    let keeps_spectra = !planes.spectral.nm().is_empty();
    let follows: Vec<bool> = (0..blocks * (y1 - y0).div_ceil(BLOCK))
        .map(|block| [x0 + block % blocks * BLOCK, y0 + block / blocks * BLOCK])
        .map(|low| (low, [(low[0] + BLOCK).min(x1), (low[1] + BLOCK).min(y1)]))
        .map(|(low, high)| keeps_spectra || integrator.may_meet(&view, low, high, size))
        .collect();
    for (x, y) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))) {
        let place = [x - x0, y - y0];
        let follows = follows[(place[1] / BLOCK * blocks + place[0] / BLOCK) as usize];
        for sample in tile.count..samples {
            let shot = Shot { pixel: [x, y], size, sample: u64::from(sample), seed };
            if follows {
                let seen = integrator.seen(&view, shot, density);
                if is_possible(&seen.radiance) {
                    tile.add(place, x1 - x0, (planes, response), &seen, sample == 0);
                } else {
                    tile.faults.add(Fault::new([x, y], sample, &seen.first));
                }
            } else if let Rows::Eye(_) = response.rows {
                let behind = integrator.behind::<EYE>(&view, shot, glow);
                add_behind(tile, (place, [x, y], sample), x1 - x0, response, &behind);
            } else {
                let behind = integrator.behind::<MOST_CHANNELS>(&view, shot, glow);
                add_behind(tile, (place, [x, y], sample), x1 - x0, response, &behind);
            }
        }
    }
    tile.count = samples;
}

/// Adds a sample of what is behind the scene, of pixel `[x, y]` at `place` in its tile. Channels may be negative where a sensor's
/// curves are.
#[inline(always)]
fn add_behind<const LANES: usize>(
    tile: &mut Tile,
    (place, pixel, sample): ([u32; 2], [u32; 2], u32),
    width: u32,
    response: &Response,
    behind: &Behind<LANES>,
) {
    if behind.channels.iter().all(|value| value.is_finite()) {
        tile.add_behind(place, width, response, behind);
    } else {
        tile.faults.add(Fault::new(pixel, sample, &NO_HIT));
    }
}

/// Depends on the tile's own samples only, at counts that do not depend on how a run was cut into pieces.
fn is_done(film: &Film, tile: usize, goal: &Goal) -> bool {
    let count = film.tiles[tile].count;
    if count >= goal.samples {
        return true;
    }
    let Some(noise) = goal.noise else { return false };
    if count < 2 * ROUND || !count.is_multiple_of(ROUND) {
        return false;
    }
    film.tiles[tile].noise() < noise
}
