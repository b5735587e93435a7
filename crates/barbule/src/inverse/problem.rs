//! Least squares of a model's sizes, the levels of the instruments projected out.
//!
//! A reading is level · model + offset + error. Levels and offsets enter linearly, so for any sizes the best ones follow in closed
//! form, and what is left depends on the sizes alone (variable projection: Golub and Pereyra, SIAM J. Numer. Anal. 10 (1973) 413, with
//! the derivative of Kaufman, BIT 15 (1975) 49).

use super::noise::Errors;
use super::reading::Reading;
use super::small::{cholesky, inverse, solve};
use super::{Level, Model};
use crate::Result;

/// Degrees of freedom of a variance, at least: fewer say nothing of it.
const FEWEST_FREE: f64 = 3.0;

/// What of each reading is free beside the sizes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Nuisance {
    pub(super) level: Level,
    pub(super) offset: bool,
}

impl Nuisance {
    /// How many numbers of each reading that is.
    pub(super) fn count(self) -> usize {
        usize::from(self.level == Level::Free) + usize::from(self.offset)
    }
}

/// One reading, in units of its errors.
struct Block {
    /// Where its samples lie among all.
    start: usize,
    values: Vec<f64>,
    ones: Vec<f64>,
    nm: Vec<f64>,
    per_sigma: f64,
}

/// Readings and a model, under a covariance of the errors.
pub(super) struct Problem<'a> {
    pub(super) model: &'a dyn Model,
    nuisance: Nuisance,
    errors: &'a [Errors],
    blocks: Vec<Block>,
    samples: usize,
    /// As many independent samples would tell the errors' variance as well.
    independent: f64,
}

/// What sizes leave of the readings.
#[derive(Debug, Clone)]
pub(super) struct Left {
    /// The sum of squares, in units of the errors' variance.
    pub(super) squares: f64,
    /// Level and offset of each reading.
    pub(super) levels: Vec<[f64; 2]>,
    /// Residuals (measured − modelled), projected, in units of the errors.
    pub(super) residuals: Vec<f64>,
    /// How the modelled values change with each size, projected, in units of the errors, `[size][sample]`.
    pub(super) slopes: Vec<Vec<f64>>,
}

/// The directions of what is free of a reading, orthonormal, and how their parts become level and offset.
struct Basis {
    directions: Vec<Vec<f64>>,
    nuisance: Nuisance,
    /// ⟨1, first direction⟩ and the length of what is left of the ones.
    ones: [f64; 2],
    length: f64,
}

impl<'a> Problem<'a> {
    /// Each reading weighed by the size of its errors.
    pub(super) fn new(
        model: &'a dyn Model,
        readings: &[Reading],
        nuisance: Nuisance,
        errors: &'a [Errors],
    ) -> Self {
        let each = || readings.iter().zip(errors);
        let independent = each().map(|(r, errors)| errors.likeliest.independent_samples(r.nm())).sum();
        let mut samples = 0;
        let blocks = each().map(|(reading, errors)| {
            let per_sigma = errors.likeliest.sigma.recip();
            let values: Vec<f64> = reading.mean.values().iter().map(|value| value * per_sigma).collect();
            let start = samples;
            samples += values.len();
            Block { start, ones: vec![per_sigma; values.len()], values, nm: reading.nm().to_vec(), per_sigma }
        });
        let blocks = blocks.collect();
        Self { model, nuisance, errors, blocks, samples, independent }
    }

    /// Degrees of freedom of the variance that is left, whose samples are not independent.
    pub(super) fn freedom_of_variance(&self) -> f64 {
        (self.independent - self.fitted()).max(FEWEST_FREE)
    }

    fn fitted(&self) -> f64 {
        (self.model.parameters().len() + self.nuisance.count() * self.blocks.len()) as f64
    }

    /// The sum of squares that sizes leave.
    pub(super) fn squares(&self, sizes: &[f64]) -> Result<f64> {
        let mut modelled = vec![0.0; self.samples];
        self.model.values(sizes, &mut modelled)?;
        Ok(self.blocks.iter().map(|block| block.projected(&mut modelled, self.nuisance).1).sum())
    }

    /// What sizes leave, and how it changes with them.
    pub(super) fn left(&self, sizes: &[f64]) -> Result<Left> {
        let count = sizes.len();
        let mut modelled = vec![0.0; self.samples];
        let mut slopes = vec![vec![0.0; self.samples]; count];
        self.model.slopes(sizes, &mut modelled, &mut slopes)?;
        let mut left = Left { squares: 0.0, levels: Vec::new(), residuals: vec![0.0; self.samples], slopes };
        for block in &self.blocks {
            let (basis, squares, residuals, levels) = block.projected(&mut modelled, self.nuisance);
            left.squares += squares;
            left.residuals[block.range()].copy_from_slice(&residuals);
            for slope in &mut left.slopes {
                let part = &mut slope[block.range()];
                part.iter_mut().for_each(|value| *value *= levels[0] * block.per_sigma);
                basis.remove(part);
            }
            left.levels.push(levels);
        }
        Ok(left)
    }

    /// What a change of one reading's values would change the sizes by, to first order: the best sizes' own response.
    pub(super) fn response(&self, left: &Left, reading: usize, change: &[f64]) -> Option<Vec<f64>> {
        let block = &self.blocks[reading];
        let change: Vec<f64> = change.iter().map(|value| value * block.per_sigma).collect();
        let mut sizes: Vec<f64> =
            left.slopes.iter().map(|slope| product(&slope[block.range()], &change)).collect();
        solve(&cholesky(&left.normal(), sizes.len())?, &mut sizes);
        Some(sizes)
    }
}

/// How sure sizes are.
pub(super) struct Sureness {
    /// Their covariance, row by row: (JᵀJ)⁻¹ Jᵀ V J (JᵀJ)⁻¹ for errors of covariance V.
    pub(super) covariance: Vec<f64>,
    /// By what the variance of each is larger than for independent errors of the same size.
    pub(super) inflation: Vec<f64>,
}

impl Problem<'_> {
    /// How sure sizes at a least square are, however their errors are correlated; none where nothing depends on one of them.
    pub(super) fn sureness(&self, left: &Left) -> Option<Sureness> {
        let count = left.slopes.len();
        let plain = inverse(&left.normal(), count)?;
        let mut middle = vec![0.0; count * count];
        for (block, errors) in self.blocks.iter().zip(self.errors) {
            for (k, slope) in left.slopes.iter().enumerate() {
                let spread = errors.covariance_times(&block.nm, &slope[block.range()]);
                for (j, other) in left.slopes.iter().enumerate() {
                    middle[j * count + k] +=
                        block.per_sigma * block.per_sigma * product(&other[block.range()], &spread);
                }
            }
        }
        let times = |a: &[f64], b: &[f64]| -> Vec<f64> {
            let element =
                |at: usize| (0..count).map(|k| a[at / count * count + k] * b[k * count + at % count]).sum();
            (0..count * count).map(element).collect()
        };
        let covariance = times(&times(&plain, &middle), &plain);
        let inflation = (0..count).map(|k| covariance[k * (count + 1)] / plain[k * (count + 1)]).collect();
        Some(Sureness { covariance, inflation })
    }
}

impl Left {
    /// The matrix of the normal equations, row by row.
    pub(super) fn normal(&self) -> Vec<f64> {
        self.slopes.iter().flat_map(|a| self.slopes.iter().map(|b| product(a, b))).collect()
    }
}

impl Block {
    fn range(&self) -> std::ops::Range<usize> {
        self.start..self.start + self.values.len()
    }

    /// The basis of what is free, the sum of squares and the residuals that are left, level and offset; `modelled` comes into units of the errors.
    fn projected(&self, modelled: &mut [f64], nuisance: Nuisance) -> (Basis, f64, Vec<f64>, [f64; 2]) {
        let model = &mut modelled[self.range()];
        model.iter_mut().for_each(|value| *value *= self.per_sigma);
        let mut residuals = self.values.clone();
        let mut fitted = self.fit(model, nuisance, &mut residuals);
        if fitted.1[0] <= 0.0 {
            // No instrument turns a curve upside down: what is left is what a level of 0 leaves.
            let nuisance = Nuisance { level: Level::Fixed, ..nuisance };
            residuals.copy_from_slice(&self.values);
            fitted = self.fit(&vec![0.0; model.len()], nuisance, &mut residuals);
            fitted.1[0] = 0.0;
        }
        let squares = product(&residuals, &residuals);
        (fitted.0, squares, residuals, fitted.1)
    }

    /// Takes what is free out of `residuals`, the values; the level and offset that this is.
    fn fit(&self, model: &[f64], nuisance: Nuisance, residuals: &mut [f64]) -> (Basis, [f64; 2]) {
        if nuisance.level == Level::Fixed {
            residuals.iter_mut().zip(model).for_each(|(value, model)| *value -= model);
        }
        let basis = Basis::new(model, &self.ones, nuisance);
        let parts = basis.remove(residuals);
        let levels = basis.levels(&parts);
        (basis, levels)
    }
}

impl Basis {
    fn new(model: &[f64], ones: &[f64], nuisance: Nuisance) -> Self {
        let mut directions = Vec::new();
        let mut length = 0.0;
        if nuisance.level == Level::Free {
            length = product(model, model).sqrt();
            let unit = if length > 0.0 { length.recip() } else { 0.0 };
            directions.push(model.iter().map(|value| value * unit).collect::<Vec<_>>());
        }
        let mut of_ones = [0.0; 2];
        if nuisance.offset {
            let mut rest = ones.to_vec();
            let whole = product(ones, ones).sqrt();
            if let Some(first) = directions.first() {
                of_ones[0] = product(&rest, first);
                rest.iter_mut().zip(first).for_each(|(value, first)| *value -= of_ones[0] * first);
            }
            of_ones[1] = product(&rest, &rest).sqrt();
            // A model as flat as the ones has no offset of its own.
            let unit = if of_ones[1] > 1e-9 * whole { of_ones[1].recip() } else { 0.0 };
            of_ones[1] *= f64::from(u8::from(unit > 0.0));
            rest.iter_mut().for_each(|value| *value *= unit);
            directions.push(rest);
        }
        Self { directions, nuisance, ones: of_ones, length }
    }

    /// Takes the free directions out of a column; its parts along them.
    fn remove(&self, column: &mut [f64]) -> [f64; 2] {
        let mut parts = [0.0; 2];
        for (part, direction) in parts.iter_mut().zip(&self.directions) {
            *part = product(column, direction);
            column.iter_mut().zip(direction).for_each(|(value, along)| *value -= *part * along);
        }
        parts
    }

    /// Level and offset from the parts of the values.
    fn levels(&self, parts: &[f64; 2]) -> [f64; 2] {
        let free = self.nuisance.level == Level::Free;
        let of_offset = if free { parts[1] } else { parts[0] };
        let offset = if self.ones[1] > 0.0 { of_offset / self.ones[1] } else { 0.0 };
        let level = match free {
            true if self.length > 0.0 => (parts[0] - offset * self.ones[0]) / self.length,
            true => 0.0,
            false => 1.0,
        };
        [level, offset]
    }
}

pub(super) fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
