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
    /// No sample begins that would likely end later than this: the last rounds are as short as they must be.
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
    let mut clock = Pace::default();
    let start = now();
    let left = |&tile: &usize| u64::from(goal.samples.saturating_sub(film.tiles[tile].count));
    let most = film.held().iter().map(left).sum();
    progress.begin("rendering", most);
    loop {
        let open: Vec<usize> = open(film, &goal).collect();
        if open.is_empty() {
            return Ok(Ended::Done);
        }
        if progress.is_cancelled() {
            return Ok(Ended::Stopped);
        }
        let begun = now();
        let step = match goal.time {
            None => goal.round.clamp(1, ROUND),
            Some(limit) => {
                let left = limit.most.saturating_sub(begun.saturating_sub(start));
                match clock.affords(open.len(), left) {
                    0 => return Ok(Ended::OutOfTime),
                    samples => samples.min(goal.round.clamp(1, ROUND)),
                }
            }
        };
        let samples = round((integrator, &glow), film, seed, (&goal, step), &open, progress);
        clock.add(samples, now().saturating_sub(begun));
        after_round(film)?;
    }
}

/// How long samples took so far, each that of all pixels of a tile.
#[derive(Debug, Default)]
struct Pace {
    samples: u64,
    taken: Duration,
    /// Seconds of one, in the last round.
    last: f64,
}

impl Pace {
    fn add(&mut self, samples: u64, taken: Duration) {
        self.last = taken.as_secs_f64() / samples.max(1) as f64;
        self.samples += samples;
        self.taken += taken;
    }

    /// How many samples of so many tiles likely end within a time; one where nothing is known yet.
    fn affords(&self, tiles: usize, left: Duration) -> u32 {
        if self.samples == 0 {
            return 1;
        }
        // What is left to do may be slower than what is done, and the machine busier.
        let mean = self.taken.as_secs_f64() / self.samples as f64;
        let one = mean.max(self.last) * tiles as f64;
        (left.as_secs_f64() / one.max(1e-9)) as u32
    }
}

/// One round of `step` samples of all open tiles, and how many those were together. A tile stays as it was where a cancellation kept it from
/// starting or from ending: a sample of the whole tile may take long.
fn round(
    scene: (&Integrator<'_>, &Glow),
    film: &mut Film,
    seed: u64,
    (goal, step): (&Goal, u32),
    open: &[usize],
    progress: &dyn Progress,
) -> u64 {
    let done: Vec<Option<Tile>> = open
        .par_iter()
        .map(|&tile| {
            if progress.is_cancelled() {
                return None;
            }
            let from = film.tiles[tile].count;
            let to = goal.samples.min((from / ROUND + 1) * ROUND).min(from + step);
            let grown = grown(scene, film, tile, (seed, to), progress)?;
            progress.advance(u64::from(to - from));
            Some(grown)
        })
        .collect();
    let mut samples = 0;
    for (&tile, grown) in open.iter().zip(done) {
        if let Some(grown) = grown {
            samples += u64::from(grown.count - film.tiles[tile].count);
            film.tiles[tile] = grown;
        }
    }
    samples
}

/// A tile with so many samples per pixel; none where a cancellation came before.
fn grown(
    scene: (&Integrator<'_>, &Glow),
    film: &Film,
    tile: usize,
    (seed, samples): (u64, u32),
    progress: &dyn Progress,
) -> Option<Tile> {
    let mut grown = film.tiles[tile].clone();
    let whole = dispatch_large!(Level::new(), simd => grow(simd, scene, film, (tile, &mut grown), (seed, samples), progress));
    whole.then_some(grown)
}

/// Whether the tile came so far. Compiled for each instruction set: paths of eight wavelengths are loops over arrays of eight.
#[inline(always)]
fn grow<S: Simd>(
    _simd: S,
    (integrator, glow): (&Integrator<'_>, &Glow),
    film: &Film,
    (number, tile): (usize, &mut Tile),
    (seed, samples): (u64, u32),
    progress: &dyn Progress,
) -> bool {
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
            if progress.is_cancelled() {
                return false;
            }
            let shot = Shot { pixel: [x, y], size, sample: u64::from(sample), seed };
            if follows {
                let seen = integrator.seen(&view, shot, density);
                if is_possible(&seen.radiance) {
                    tile.add(place, x1 - x0, (planes, response), &seen, sample);
                } else {
                    tile.leave_out(place, x1 - x0, sample, Fault::new([x, y], sample, &seen.first));
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
    true
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
        tile.add_behind(place, width, response, behind, sample);
    } else {
        tile.leave_out(place, width, sample, Fault::new(pixel, sample, &NO_HIT));
    }
}

/// Whether a film, or the part of a picture that it holds, needs no more samples; how long they took is not asked.
#[must_use]
pub fn is_done(film: &Film, goal: &Goal) -> bool {
    open(film, goal).next().is_none()
}

/// The tiles that need more samples.
fn open<'a>(film: &'a Film, goal: &'a Goal) -> impl Iterator<Item = usize> + 'a {
    film.held().iter().copied().filter(|&tile| !is_tile_done(film, tile, goal))
}

/// Depends on the tile's own samples only, at counts that do not depend on how a run was cut into pieces.
fn is_tile_done(film: &Film, tile: usize, goal: &Goal) -> bool {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The first round learns how long a sample takes; the last ones are short, and none begins that ends too late.
    #[test]
    fn rounds_fit_into_the_time_that_is_left() {
        let second = Duration::from_secs(1);
        let mut pace = Pace::default();
        assert_eq!(pace.affords(10, Duration::ZERO), 1);
        // Half a second for a sample of ten tiles.
        pace.add(10, second / 2);
        assert_eq!([0, 1, 4].map(|left| pace.affords(10, left * second)), [0, 2, 8]);
        assert_eq!(pace.affords(5, second), 4);
        assert_eq!(pace.affords(10, second * 49 / 100), 0);
        // Slower now: the last round counts; faster: all do.
        pace.add(10, 2 * second);
        assert_eq!(pace.affords(10, 4 * second), 2);
        pace.add(80, second / 2);
        assert_eq!(pace.affords(10, 31 * second / 10), 10);
    }
}
