//! Running the integrator over the film: rounds of samples over tiles, until a count, a noise target or a time.

use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::film::{Film, Pixel};
use super::integrator::Integrator;
use crate::progress::Progress;
use crate::{Error, Result};

/// When a picture is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Most samples per pixel.
    pub samples: u32,
    /// A tile is done earlier when the standard error of its mean luminance per pixel, relative to the luminance (with
    /// 0.05 added), is below this on average; `None`: never.
    pub noise: Option<f64>,
    /// No new round begins that would likely end later than this; `None`: no limit.
    pub time: Option<Duration>,
}

/// Samples per pixel after which noise is looked at, and per round.
pub const ROUND: u32 = 8;

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
/// A goal out of range.
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
    let start = Instant::now();
    let mut slowest = Duration::ZERO;
    let most = film.counts.iter().map(|c| u64::from(goal.samples.saturating_sub(*c))).sum();
    progress.begin("rendering", most);
    loop {
        let open: Vec<usize> = (0..film.tiles()).filter(|&t| !is_done(film, t, &goal)).collect();
        if open.is_empty() {
            return Ok(Ended::Done);
        }
        if progress.is_cancelled() {
            return Ok(Ended::Stopped);
        }
        if goal.time.is_some_and(|time| slowest > Duration::ZERO && start.elapsed() + slowest > time) {
            return Ok(Ended::OutOfTime);
        }
        let begun = Instant::now();
        round(integrator, film, seed, &goal, &open, progress);
        slowest = slowest.max(begun.elapsed());
        after_round(film)?;
    }
}

/// One round of all open tiles; a tile that a cancellation kept from starting stays as it was.
fn round(
    integrator: &Integrator<'_>,
    film: &mut Film,
    seed: u64,
    goal: &Goal,
    open: &[usize],
    progress: &dyn Progress,
) {
    let done: Vec<Option<(Vec<Pixel>, u32)>> = open
        .par_iter()
        .map(|&tile| {
            if progress.is_cancelled() {
                return None;
            }
            let from = film.counts[tile];
            let to = goal.samples.min((from / ROUND + 1) * ROUND);
            let pixels = tile_samples(integrator, film, tile, seed, from..to);
            progress.advance(u64::from(to - from));
            Some((pixels, to))
        })
        .collect();
    for (&tile, result) in open.iter().zip(done) {
        let Some((pixels, count)) = result else { continue };
        let [x0, y0, x1, y1] = film.bounds(tile);
        let width = film.size()[0];
        let mut pixels = pixels.into_iter();
        for y in y0..y1 {
            let row = (y * width) as usize;
            let line = &mut film.pixels[row + x0 as usize..row + x1 as usize];
            line.iter_mut().zip(&mut pixels).for_each(|(to, from)| *to = from);
        }
        film.counts[tile] = count;
    }
}

fn tile_samples(
    integrator: &Integrator<'_>,
    film: &Film,
    tile: usize,
    seed: u64,
    samples: std::ops::Range<u32>,
) -> Vec<Pixel> {
    let [x0, y0, x1, y1] = film.bounds(tile);
    let mut pixels = Vec::with_capacity(((x1 - x0) * (y1 - y0)) as usize);
    for y in y0..y1 {
        for x in x0..x1 {
            let mut pixel = *film.pixel(x, y);
            for sample in samples.clone() {
                let drawn = integrator.sample([x, y], film.size(), u64::from(sample), seed);
                pixel.add(&drawn, sample == 0);
            }
            pixels.push(pixel);
        }
    }
    pixels
}

/// Depends on the tile's own samples only, at counts that do not depend on how a run was cut into pieces.
fn is_done(film: &Film, tile: usize, goal: &Goal) -> bool {
    let count = film.counts[tile];
    if count >= goal.samples {
        return true;
    }
    let Some(noise) = goal.noise else { return false };
    if count < 2 * ROUND || !count.is_multiple_of(ROUND) {
        return false;
    }
    let [x0, y0, x1, y1] = film.bounds(tile);
    let mut sum = 0.0;
    for y in y0..y1 {
        for x in x0..x1 {
            sum += film.variance(x, y).sqrt() / (film.xyz(x, y)[1].max(0.0) + 0.05);
        }
    }
    sum / f64::from((x1 - x0) * (y1 - y0)) < noise
}
