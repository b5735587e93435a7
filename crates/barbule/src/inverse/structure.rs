//! Sizes of species and lattices: spectra are simulated at some, are polynomials between them, and once more at those that fit.

use super::reading::Reading;
use super::subject::{Open, Subject};
use super::table::{Simulator, Table};
use super::{Estimate, Fit, Parameter, Settings, check, fit};
use crate::campaign::spectrum::{Collect, SpectrumRequest, spectra};
use crate::progress::{Progress, Several};
use crate::solve::crystal::{Multipole, sweep};
use crate::spectrum::Wavelengths;
use crate::structure::Structure;
use crate::{Error, Result};

/// Sizes of one fit whose spectra are tabulated, at most.
const MOST_TABULATED: usize = 3;
/// Values of each size that are simulated, of one, two and three.
const NODES: [usize; MOST_TABULATED] = [13, 8, 6];
/// The same about what was found.
const NODES_NEAR: [usize; MOST_TABULATED] = [5, 4, 3];
/// Wavelengths are simulated no further apart than this, nm, and are cubic in between.
const FURTHEST_NM: f64 = 10.0;
/// Tables are made anew about what was found until they are off by less than this part of what the fit leaves.
const OFF: f64 = 0.2;
const MOST_REFINED: usize = 3;
/// Half the width of the first such table in parts of the whole range, at least, and that of the next in parts of it, once the best
/// sizes are inside.
const NEAR: f64 = 0.1;
const NEARER: f64 = 0.4;

/// How spectra are simulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Simulation {
    /// Random individuals of a species whose mean is fitted.
    pub instances: usize,
    /// Their seed.
    pub seed: u64,
    /// What of the reflected light a reading holds.
    pub collect: Collect,
}

/// A fitted species or lattice.
#[derive(Debug, Clone)]
pub struct FittedStructure {
    /// What was found.
    pub fit: Fit,
    /// The subject with the best sizes.
    pub best: Subject,
    /// Root mean square of the table − the simulation at the best sizes, reflectance of the readings.
    pub table_error: f64,
    /// How many spectra were simulated.
    pub simulated: usize,
}

/// Finds sizes of a species or a lattice, from one to three. Those of `open`, or if it is empty those that set the colour most, are
/// looked for within their ranges.
///
/// # Errors
/// As [`Subject::with`]; an unknown key; too few samples; what the simulation refuses; or the user cancelled.
pub fn fit_structure(
    subject: &Subject,
    open: &[Open],
    simulation: &Simulation,
    readings: &[Reading],
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<FittedStructure> {
    let parameters = subject.parameters(open)?;
    if parameters.len() > MOST_TABULATED {
        return Err(Error::input(format!(
            "{} sizes are open, but up to {MOST_TABULATED} can be looked for at once in species and lattices; fix some",
            parameters.len()
        )));
    }
    check(readings, parameters.len(), settings)?;
    let simulated = Simulated::new(subject, &parameters, simulation, readings)?;
    let sizes = parameters.len();
    let (whole, near) = (NODES[sizes - 1].pow(sizes as u32), NODES_NEAR[sizes - 1].pow(sizes as u32));
    let stage = Several::begin(progress, "simulating sizes", whole + MOST_REFINED * (near + 1));
    let table = Table::new(&simulated, parameters.clone(), NODES[sizes - 1], &|| stage.part())?;
    let mut found = fit(&table, readings, settings)?;
    let mut count = whole;
    let (mut table_error, mut part) = (f64::INFINITY, NEAR);
    for round in 0..=MOST_REFINED {
        let values: Vec<f64> = found.solutions[0].sizes.iter().map(|size| size.value).collect();
        let exact = simulated.simulate(&values, &stage.part())?;
        count += 1;
        table_error = off(&found, &exact);
        if table_error <= OFF * found.solutions[0].rmse || round == MOST_REFINED {
            break;
        }
        let about = narrowed(&parameters, &found, part);
        let table = Table::new(&simulated, about.clone(), NODES_NEAR[sizes - 1], &|| stage.part())?;
        count += near;
        let nearer = fit(&table, readings, &Settings { solutions: 1, ..*settings })?;
        refine(&mut found, nearer, &about);
        let best = found.solutions[0].sizes.iter().zip(&about);
        let inside = |(size, p): (&Estimate, &Parameter)| size.value > p.low && size.value < p.high;
        part *= if best.into_iter().all(inside) { NEARER } else { 1.0 };
    }
    let best: Vec<f64> = found.solutions[0].sizes.iter().map(|size| size.value).collect();
    let best = subject.with(&found.parameters, &best)?;
    Ok(FittedStructure { fit: found, best, table_error, simulated: count })
}

/// Root mean square of the fitted curves − what is simulated at the best sizes.
fn off(found: &Fit, exact: &[f64]) -> f64 {
    let best = &found.solutions[0];
    let mut start = 0;
    let mut squares = 0.0;
    for (curve, [level, offset]) in best.fitted.iter().zip(&best.levels) {
        let exact = &exact[start..start + curve.values().len()];
        start += curve.values().len();
        squares +=
            exact.iter().zip(curve.values()).map(|(e, c)| (level * e + offset - c).powi(2)).sum::<f64>();
    }
    (squares / exact.len() as f64).sqrt()
}

/// Ranges about the best sizes that hold their intervals, half as wide as this part of the whole ones at least, within these.
fn narrowed(whole: &[Parameter], found: &Fit, part: f64) -> Vec<Parameter> {
    let about = |(p, size): (&Parameter, &Estimate)| {
        let range = p.high - p.low;
        let half = (1.5 * (size.high - size.low)).max(part * range).min(0.5 * range);
        let middle = size.value.clamp(p.low + half, p.high - half);
        Parameter { low: middle - half, high: middle + half, ..p.clone() }
    };
    whole.iter().zip(&found.solutions[0].sizes).map(about).collect()
}

/// Puts the best solution of a nearer table in the place of that of the one before; an interval that ends where the nearer table ends
/// keeps its end.
fn refine(found: &mut Fit, nearer: Fit, parameters: &[Parameter]) {
    let Fit { solutions, noise, .. } = nearer;
    let Some(mut best) = solutions.into_iter().next() else { return };
    for ((size, p), before) in best.sizes.iter_mut().zip(parameters).zip(&found.solutions[0].sizes) {
        if size.open[0] && size.low <= p.low {
            (size.low, size.open[0]) = (before.low.min(size.low), before.open[0]);
        }
        if size.open[1] && size.high >= p.high {
            (size.high, size.open[1]) = (before.high.max(size.high), before.open[1]);
        }
    }
    found.solutions[0] = best;
    found.noise = noise;
}

/// The wavelengths of a reading, nm, and its directions with their weights.
type Sampled = (Vec<f64>, Vec<(usize, f64)>);

/// Spectra of a subject at the samples of readings.
struct Simulated<'a> {
    subject: &'a Subject,
    parameters: Vec<Parameter>,
    simulation: Simulation,
    /// Where it is simulated, nm, equidistant.
    at: Wavelengths,
    /// Directions, those of one θ_i together.
    directions: Vec<(f64, f64)>,
    /// How each reading samples them.
    readings: Vec<Sampled>,
}

impl<'a> Simulated<'a> {
    fn new(
        subject: &'a Subject,
        parameters: &[Parameter],
        simulation: &Simulation,
        readings: &[Reading],
    ) -> Result<Self> {
        let ends = readings.iter().map(|reading| reading.mean.wavelengths().range_nm());
        let first = ends.clone().map(|(first, _)| first).fold(f64::INFINITY, f64::min);
        let last = ends.map(|(_, last)| last).fold(0.0, f64::max);
        // A cubic needs four.
        let steps = ((last - first) / FURTHEST_NM).ceil().max(3.0) as usize;
        let nm: Vec<f64> = (0..=steps).map(|k| first + (last - first) * k as f64 / steps as f64).collect();
        let mut directions: Vec<(f64, f64)> =
            readings.iter().flat_map(|reading| reading.beams.iter().map(|beam| beam.direction)).collect();
        directions.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        directions.dedup();
        let place = |direction| directions.iter().position(|known| *known == direction).unwrap_or(0);
        let readings = readings.iter().map(|reading| {
            let beams = reading.beams.iter().map(|beam| (place(beam.direction), beam.weight)).collect();
            (reading.nm().to_vec(), beams)
        });
        let readings = readings.collect();
        Ok(Self {
            subject,
            parameters: parameters.to_vec(),
            simulation: *simulation,
            at: Wavelengths::new(nm)?,
            directions,
            readings,
        })
    }

    /// Reflected fractions, `[direction][wavelength]`.
    fn reflected(&self, sizes: &[f64], progress: &dyn Progress) -> Result<Vec<Vec<f64>>> {
        match self.subject.with(&self.parameters, sizes)? {
            Subject::Species { model, .. } => {
                let request = SpectrumRequest {
                    wavelengths: self.at.clone(),
                    directions: self.directions.clone(),
                    instances: self.simulation.instances,
                    seed: self.simulation.seed,
                    collect: self.simulation.collect,
                    polarization: [0.5; 2],
                };
                Ok(spectra(&Structure::Species(model), &request, progress)?.mean)
            }
            Subject::Lattice(lattice) => {
                let mut all = Vec::with_capacity(self.directions.len());
                for run in self.directions.chunk_by(|a, b| a.0 == b.0) {
                    let phi: Vec<f64> = run.iter().map(|direction| direction.1).collect();
                    let solver = Multipole::default();
                    let both = sweep(&solver, &lattice, self.at.nm(), run[0].0, &phi, progress)?;
                    let mean = |row: &[[f64; 2]]| row.iter().map(|[a, b]| 0.5 * (a + b)).collect();
                    all.extend(both.chunks_exact(self.at.len()).map(mean));
                }
                Ok(all)
            }
        }
    }
}

impl Simulator for Simulated<'_> {
    fn simulate(&self, sizes: &[f64], progress: &dyn Progress) -> Result<Vec<f64>> {
        let reflected = self.reflected(sizes, progress)?;
        let mut values = Vec::new();
        for (nm, beams) in &self.readings {
            let mixed: Vec<f64> = (0..self.at.len())
                .map(|w| beams.iter().map(|(direction, weight)| weight * reflected[*direction][w]).sum())
                .collect();
            values.extend(nm.iter().map(|&nm| cubic(&self.at, &mixed, nm)));
        }
        Ok(values)
    }
}

/// The cubic through the four nearest of equidistant values.
fn cubic(at: &[f64], values: &[f64], nm: f64) -> f64 {
    let step = at[1] - at[0];
    let along = (nm - at[0]) / step;
    let first = (along.floor() as usize).saturating_sub(1).min(values.len() - 4);
    let t = along - first as f64;
    let weight = |k: usize| -> f64 {
        (0..4).filter(|&j| j != k).map(|j| (t - j as f64) / (k as f64 - j as f64)).product()
    };
    (0..4).map(|k| weight(k) * values[first + k]).sum()
}
