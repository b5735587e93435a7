//! How sure the numbers of a simulated colour are: intervals over individuals, and over sizes and indices that are not known exactly.
//!
//! Individuals are drawn again with replacement (the bootstrap of Efron 1979): how the numbers of the mean vary says how well so many
//! individuals fix it. Percentiles of few are too narrow, so their distances from the mean are taken √(n/(n−1)) t/1.96 times, with Student's
//! t of n − 1 degrees of freedom (Hesterberg 2015, *The American Statistician* 69, 371, on what they lack).
//! Uncertain inputs are moved by their standard deviation, up and down, with the same individuals; halves of the
//! differences are what they contribute, and all add in squares (the *Guide to the Expression of Uncertainty in Measurement*, JCGM 100:2008, §5.1.2).

mod numbers;
mod uncertain;

pub use numbers::{Known, Part};
pub use uncertain::{Amount, Uncertain};

use crate::error::shortened;
use crate::math::rng::Stream;
use crate::open::Opening;
use crate::progress::{Progress, Several};
use crate::spectrum::look::Look;
use crate::spectrum::{Spectrum, Wavelengths};
use crate::structure::Structure;
use crate::{Error, Result};
use numbers::{COUNT, Numbers};
use serde::Serialize;
use uncertain::Moved;

/// How often individuals are drawn again.
const RESAMPLED: usize = 1000;

/// The intervals of one direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Intervals {
    /// Of how many individuals the mean is.
    pub individuals: usize,
    /// The numbers that the mean has; as a document they stand under their names.
    #[serde(serialize_with = "numbers::by_name")]
    pub numbers: Vec<Known>,
}

/// What a spectrum was, whose intervals are wanted.
#[derive(Debug, Clone, Copy)]
pub struct Simulated<'a> {
    /// Its wavelengths.
    pub at: &'a Wavelengths,
    /// The mean of each direction.
    pub means: &'a [Vec<f64>],
    /// The curves of the individuals, `[direction][individual][wavelength]`.
    pub curves: &'a [Vec<Vec<f64>>],
    /// The peak of each direction, as it is followed through them.
    pub looks: &'a [Look],
}

/// How a structure is simulated as the one was whose intervals are wanted, with the same individuals: means, `[direction][wavelength]`.
pub type Simulate<'a> = &'a dyn Fn(Structure, &dyn Progress) -> Result<Vec<Vec<f64>>>;

/// Refuses, before anything is simulated, intervals from one of several individuals: how they differ it does not show.
///
/// # Errors
/// One individual of a structure that has several.
pub fn check_individuals(structure: &Structure, individuals: usize) -> Result<()> {
    if individuals > 1 || structure.count() == Some(1) {
        return Ok(());
    }
    let name = structure.name();
    Err(Error::input(format!(
        "instances is 1, but intervals are of how individuals of {} differ; give at least 2",
        shortened(&name)
    )))
}

/// The intervals of each direction of a spectrum of the structure that `text` names. `progress` hears of two simulations for each uncertain
/// input; `seed` is that of the resampling.
///
/// # Errors
/// An uncertain input that the structure does not have, or that makes no structure once it is moved; what `simulate` refuses.
pub fn intervals(
    text: &str,
    opening: &Opening,
    simulate: Simulate,
    seed: u64,
    simulated: Simulated,
    uncertain: &[Uncertain],
    progress: &dyn Progress,
) -> Result<Vec<Intervals>> {
    // All are made before any is simulated.
    let pairs = moved(text, opening, uncertain)?;
    let mut spectra = Vec::with_capacity(pairs.len());
    if !pairs.is_empty() {
        let several = Several::begin(progress, "moving uncertain inputs", 2 * pairs.len());
        for pair in pairs {
            let [up, down] = pair.map(|moved| simulate(moved.0, &several.part()));
            spectra.push([up?, down?]);
        }
    }
    let directions = 0..simulated.means.len();
    directions.map(|direction| of_direction(direction, seed, simulated, uncertain, &spectra)).collect()
}

/// Each uncertain input moved up and down.
fn moved(text: &str, opening: &Opening, uncertain: &[Uncertain]) -> Result<Vec<[Moved; 2]>> {
    for (i, one) in uncertain.iter().enumerate() {
        if uncertain[..i].iter().any(|before| before.name == one.name) {
            return Err(Error::input(format!("{} is uncertain twice; give it once", one.name)));
        }
    }
    let of = |one: &Uncertain| Ok([one.moved(text, opening, 1.0)?, one.moved(text, opening, -1.0)?]);
    uncertain.iter().map(of).collect()
}

fn of_direction(
    direction: usize,
    seed: u64,
    simulated: Simulated,
    uncertain: &[Uncertain],
    moved: &[[Vec<Vec<f64>>; 2]],
) -> Result<Intervals> {
    let of = |values: Vec<f64>, peak| -> Result<Numbers> {
        Ok(Numbers::of(&Spectrum::new(simulated.at.clone(), values)?, peak))
    };
    let peak = simulated.looks.get(direction).and_then(|look| look.peak);
    let mean = of(simulated.means[direction].clone(), peak)?;
    let curves = &simulated.curves[direction];
    let drawn: Vec<Numbers> = if curves.len() > 1 {
        resampled(seed, curves, RESAMPLED).map(|mean| of(mean, peak)).collect::<Result<_>>()?
    } else {
        Vec::new()
    };
    let parts: Vec<[Numbers; 2]> = moved
        .iter()
        .map(|[up, down]| Ok([of(up[direction].clone(), peak)?, of(down[direction].clone(), peak)?]))
        .collect::<Result<_>>()?;
    let names: Vec<&str> = uncertain.iter().map(|one| one.name.as_str()).collect();
    let numbers = (0..COUNT)
        .filter_map(|which| Known::of(which, &mean, &drawn, &names, &parts, curves.len()))
        .collect();
    Ok(Intervals { individuals: curves.len(), numbers })
}

/// Means of as many curves drawn with replacement, so many times.
fn resampled(seed: u64, curves: &[Vec<f64>], times: usize) -> impl Iterator<Item = Vec<f64>> + '_ {
    (0..times).map(move |time| {
        let mut stream = Stream::new(seed, &[0x626f_6f74, time as u64]);
        let mut mean = vec![0.0; curves[0].len()];
        for _ in curves {
            let drawn = (stream.unit() * curves.len() as f64) as usize;
            for (sum, value) in mean.iter_mut().zip(&curves[drawn.min(curves.len() - 1)]) {
                *sum += value;
            }
        }
        mean.iter_mut().for_each(|sum| *sum /= curves.len() as f64);
        mean
    })
}

#[cfg(test)]
mod tests;
