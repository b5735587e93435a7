//! From measured spectra to the sizes of what reflected them: the inverse of [`crate::film`] and [`crate::campaign`].
//!
//! A reading is level · model(sizes) + offset + error. All sizes within their ranges are searched; what is found are all least squares,
//! with the interval of each size and with how much worse than the best they fit, since spectra often do not decide between orders of
//! interference. Method, statistics and their coverage: `docs/theory/inverse.md`.

mod interval;
mod noise;
mod outcome;
mod planar;
mod problem;
mod reading;
mod search;
mod small;
mod structure;
mod subject;
mod table;
mod target;
mod template;
#[cfg(test)]
mod tests;
mod weighing;

pub use noise::Noise;
pub use outcome::{Outcome, in_words};
pub use reading::{Beam, Lighting, Reading};
pub use structure::{FittedStructure, Simulation, fit_structure};
pub use subject::{Open, Subject};
pub use target::{FILM, FILM_NM, LAYER_NM, Target};

use rayon::prelude::*;

use crate::error::counted;
use crate::material::Library;
use crate::spectrum::Spectrum;
use crate::{Error, Result};
use noise::{Errors, likeliest};
use planar::Planar;
use problem::{Nuisance, Problem};
use search::{Found, MOST_STEPS, descend, distinct, minima};
use small::as_good_within;
use template::Template;
use weighing::Weighing;

/// Sizes of one fit, at most.
pub const MOST_PARAMETERS: usize = 6;
/// Readings of one fit, at most.
pub const MOST_READINGS: usize = 64;
/// Solutions that are given, at most, if they fit as well as the best.
const MOST_SOLUTIONS: usize = 12;
/// Least squares that are followed to their end, the best of all that were found.
const MOST_FOLLOWED: usize = 12;
/// Errors are taken to be at least this part of a reading's size: numbers in files have so many digits.
const LEAST_ERROR: f64 = 1e-6;

/// A size that is to be found.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Its name, as `thickness_nm` or `cortex_um`.
    pub name: String,
    /// Its unit; empty where it has none.
    pub unit: String,
    /// The least that is looked at.
    pub low: f64,
    /// The greatest that is looked at.
    pub high: f64,
}

/// Whether an instrument's scale is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Level {
    /// Each reading has a factor of its own.
    #[default]
    Free,
    /// Reflectances are absolute.
    Fixed,
}

/// How a fit is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The scale of each reading.
    pub level: Level,
    /// Whether each reading has a constant of its own, as of gloss and stray light.
    pub offset: bool,
    /// How many solutions are given at least, if there are as many; those that fit as well as the best always are, up to 12.
    pub solutions: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { level: Level::Free, offset: false, solutions: 3 }
    }
}

/// A size with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The best value.
    pub value: f64,
    /// The lower end of the interval.
    pub low: f64,
    /// The upper end.
    pub high: f64,
    /// Whether the lower and the upper end are those of the range, beyond which nothing was looked at.
    pub open: [bool; 2],
}

/// Sizes that fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// One for each parameter.
    pub sizes: Vec<Estimate>,
    /// Covariance of the sizes, row by row, where the model is linear about them; infinite where nothing depends on one.
    pub covariance: Vec<Vec<f64>>,
    /// Standard deviation of each size over the samples of the readings (individuals), to first order; none of fewer than three.
    pub between_samples: Option<Vec<f64>>,
    /// Level and offset of each reading.
    pub levels: Vec<[f64; 2]>,
    /// Root mean square of measured − fitted over all samples.
    pub rmse: f64,
    /// The part of the variance of the readings that is fitted.
    pub explained: f64,
    /// How much worse than the best it fits, in variances of the errors: Δχ².
    pub worse_by: f64,
    /// Whether the measurement does not decide, at 95 %, between this and the best.
    pub as_good: bool,
    /// The fitted curve of each reading.
    pub fitted: Vec<Spectrum>,
}

/// What a fit found.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The sizes that were looked for.
    pub parameters: Vec<Parameter>,
    /// The solutions, the best first.
    pub solutions: Vec<Solution>,
    /// The errors of each reading, from what the best solution leaves.
    pub noise: Vec<Noise>,
    /// What is doubtful, in sentences.
    pub doubts: Vec<String>,
}

/// What can be fitted: the values of all samples of all readings as functions of sizes.
trait Model: Sync {
    /// The sizes.
    fn parameters(&self) -> &[Parameter];
    /// Distances of the sizes over which the values change little.
    fn steps(&self) -> Vec<f64>;
    /// The value at every sample of every reading.
    fn values(&self, sizes: &[f64], values: &mut [f64]) -> Result<()>;
    /// The same with the derivatives by each size, `[size][sample]`.
    fn slopes(&self, sizes: &[f64], values: &mut [f64], slopes: &mut [Vec<f64>]) -> Result<()>;
}

/// The stack of a fit with the numbers of one of its solutions.
#[derive(Debug, Clone)]
pub struct FittedStack {
    template: Template,
    /// What was found.
    pub fit: Fit,
}

impl FittedStack {
    /// The stack of a solution in the stack language, thicknesses to 0.001 nm.
    #[must_use]
    pub fn text(&self, solution: &Solution) -> String {
        let rounded = |size: &Estimate| (size.value * 1e3).round() / 1e3;
        self.template.text(&solution.sizes.iter().map(rounded).collect::<Vec<_>>())
    }
}

/// Finds the numbers of a stack of flat layers that are left open in `text`, as in `air/keratin:?/air`; a thickness that is only `?`
/// is looked for within `usual_nm`. Derivatives are exact ([`crate::film::gradient`]).
///
/// # Errors
/// No stack with open numbers, no index at a wavelength, no or too many readings, or too few samples for so many numbers.
///
/// ```
/// use barbule::inverse::{Beam, Reading, Settings, fit_stack};
/// use barbule::film::sweep;
/// use barbule::material::Library;
/// use barbule::spectrum::Spectrum;
/// use barbule::{Stack, Unobserved, Wavelengths};
///
/// let library = Library::builtin();
/// let at = Wavelengths::usual();
/// let film = sweep(&Stack::parse("air/keratin:643/air", &library)?, &at, &[0.0], &Unobserved)?;
/// let measured = Spectrum::new(at, film.unpolarized().iter().map(|r| 0.4 * r).collect())?;
///
/// let straight = Beam { direction: (0.0, 0.0), weight: 1.0 };
/// let reading = Reading::new("dove", &measured, &[], vec![straight], None)?;
/// let found = fit_stack("air/keratin:?/air", [50.0, 3000.0], &library, &[reading], &Settings::default())?;
/// assert!((found.fit.solutions[0].sizes[0].value - 643.0).abs() < 1e-3);
/// # Ok::<(), barbule::Error>(())
/// ```
pub fn fit_stack(
    text: &str,
    usual_nm: [f64; 2],
    library: &Library,
    readings: &[Reading],
    settings: &Settings,
) -> Result<FittedStack> {
    let template = Template::parse(text, usual_nm, library)?;
    check(readings, template.parameters.len(), settings)?;
    let model = Planar::new(template.clone(), readings, library)?;
    Ok(FittedStack { template, fit: fit(&model, readings, settings)? })
}

/// Refuses what cannot be fitted.
fn check(readings: &[Reading], parameters: usize, settings: &Settings) -> Result<()> {
    if !(1..=MOST_READINGS).contains(&readings.len()) {
        return Err(Error::input(format!(
            "there are {} measured spectra; give 1 to {MOST_READINGS} in one fit",
            readings.len()
        )));
    }
    let samples: usize = readings.iter().map(|reading| reading.nm().len()).sum();
    let nuisance = Nuisance { level: settings.level, offset: settings.offset };
    let fitted = parameters + nuisance.count() * readings.len();
    // Errors must be seen too, beside what is fitted.
    if samples < fitted + 5 {
        return Err(Error::input(format!(
            "{} do not decide {} and their errors; give more wavelengths, or leave fewer numbers open",
            counted(samples, "measured sample"),
            counted(fitted, "number")
        )));
    }
    for reading in readings {
        let values = reading.mean.values();
        let flat = values.iter().all(|value| (value - values[0]).abs() <= 1e-9 * values[0].abs());
        if flat && !(settings.level == Level::Fixed) {
            return Err(Error::input(format!(
                "{}: is {} at all wavelengths, from which no size follows; give a spectrum with features, or fix the level",
                reading.name, values[0]
            )));
        }
    }
    Ok(())
}

/// Searches the sizes of a model, estimates the errors from what the best ones leave, and weighs all least squares by them.
fn fit(model: &dyn Model, readings: &[Reading], settings: &Settings) -> Result<Fit> {
    let nuisance = Nuisance { level: settings.level, offset: settings.offset };
    let mut weights: Vec<Errors> =
        readings.iter().map(|reading| Errors::independent(scatter(reading))).collect();
    let mut found = minima(&Problem::new(model, readings, nuisance, &weights))?;
    found.truncate(MOST_FOLLOWED);
    found = followed(&Problem::new(model, readings, nuisance, &weights), found)?;
    // Readings weigh as their errors are small; these follow once more where others became the best.
    for _ in 0..2 {
        weights = errors(model, readings, nuisance, &found[0])?;
        found = followed(&Problem::new(model, readings, nuisance, &weights), found)?;
    }
    let problem = Problem::new(model, readings, nuisance, &weights);
    let sure = problem.sureness(&found[0].left);
    let inflation = sure.map_or(1.0, |sure| sure.inflation.into_iter().fold(1.0, f64::max));
    let likely = as_good_within(model.parameters().len(), problem.freedom_of_variance());
    let weighing = Weighing { problem: &problem, readings, inflation, likely, best: found[0].left.squares };
    let as_good = found.iter().take_while(|one| weighing.worse_by(one) <= likely).count();
    found.truncate(as_good.clamp(settings.solutions.max(1), MOST_SOLUTIONS.max(settings.solutions)));
    let solutions = found.par_iter().map(|one| weighing.solution(one)).collect::<Result<Vec<_>>>()?;
    let solutions = apart(solutions);
    let as_good = solutions.iter().filter(|solution| solution.as_good).count();
    let doubts = doubts(model.parameters(), &solutions[0], as_good);
    let noise = weights.iter().map(|errors| errors.likeliest).collect();
    Ok(Fit { parameters: model.parameters().to_vec(), solutions, noise, doubts })
}

/// Solutions without those that lie within the intervals of a better one: another place of the same valley.
fn apart(sorted: Vec<Solution>) -> Vec<Solution> {
    let mut kept: Vec<Solution> = Vec::new();
    for one in sorted {
        let within = |other: &Solution| {
            let mut pairs = one.sizes.iter().zip(&other.sizes);
            one.as_good && pairs.all(|(size, other)| (other.low..=other.high).contains(&size.value))
        };
        if !kept.iter().any(within) {
            kept.push(one);
        }
    }
    kept
}

/// How much a reading's values vary: its weight until its errors are known.
fn scatter(reading: &Reading) -> f64 {
    let values = reading.mean.values();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64;
    square.sqrt().max(LEAST_ERROR * mean.abs()).max(f64::MIN_POSITIVE)
}

/// The errors of each reading from what sizes leave of it.
fn errors(model: &dyn Model, readings: &[Reading], nuisance: Nuisance, found: &Found) -> Result<Vec<Errors>> {
    let samples = found.left.residuals.len();
    let mut values = vec![0.0; samples];
    let mut slopes = vec![vec![0.0; samples]; found.sizes.len()];
    model.slopes(&found.sizes, &mut values, &mut slopes)?;
    let mut start = 0;
    let mut all = Vec::with_capacity(readings.len());
    for (reading, [level, offset]) in readings.iter().zip(&found.left.levels) {
        let range = start..start + reading.nm().len();
        start = range.end;
        let modelled = &values[range.clone()];
        let left: Vec<f64> =
            reading.mean.values().iter().zip(modelled).map(|(v, m)| v - level * m - offset).collect();
        let mut columns = Vec::new();
        if nuisance.level == Level::Free {
            columns.push(modelled.to_vec());
        }
        if nuisance.offset {
            columns.push(vec![1.0; left.len()]);
        }
        let without = columns.len();
        columns.extend(slopes.iter().map(|slope| slope[range.clone()].to_vec()));
        let of = |columns: &[Vec<f64>]| likeliest(reading.nm(), &left, columns);
        let mut found = of(&columns)
            // Sizes on which this reading does not depend.
            .or_else(|| of(&columns[..without]))
            .unwrap_or(Errors::independent(scatter(reading)));
        let size = reading.mean.values().iter().map(|v| v.abs()).fold(0.0, f64::max);
        let least = (LEAST_ERROR * size).max(f64::MIN_POSITIVE);
        if found.likeliest.sigma < least {
            found = Errors::independent(least);
        }
        all.push(found);
    }
    Ok(all)
}

/// Least squares under other errors, from those that were found before; the best first.
fn followed(problem: &Problem, found: Vec<Found>) -> Result<Vec<Found>> {
    let mut found: Vec<Found> = found
        .into_par_iter()
        .map(|one| descend(problem, one.sizes, None, MOST_STEPS))
        .collect::<Result<_>>()?;
    found.sort_by(|a, b| a.left.squares.total_cmp(&b.left.squares));
    Ok(distinct(found, &problem.model.steps()))
}

/// A fit explains less than this part of the variance: another structure, or errors as large as the features.
const POOR: f64 = 0.7;

/// What is doubtful of the best solution.
fn doubts(parameters: &[Parameter], best: &Solution, as_good: usize) -> Vec<String> {
    let mut doubts = Vec::new();
    for (p, size) in parameters.iter().zip(&best.sizes) {
        let (name, low, high) = (&p.name, p.low, p.high);
        if size.open == [true, true] {
            doubts.push(format!(
                "the measurement does not decide {name}: every value from {low} to {high} fits as well"
            ));
        } else if size.value <= low || size.value >= high {
            doubts.push(format!(
                "{name} is at an end of its range, {low} to {high}: widen it, or the structure is another"
            ));
        }
    }
    if best.explained < POOR {
        doubts.push(format!(
            "only {:.0} % of the variance is explained: the structure is another, or the errors are as large as its features",
            100.0 * best.explained.max(0.0)
        ));
    }
    if as_good > 1 {
        doubts.push(format!(
            "{as_good} solutions fit as well as each other; a wider range of wavelengths, further angles or a known size decide"
        ));
    }
    doubts
}
