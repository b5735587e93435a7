//! Least squares as solutions: intervals, what samples scatter by, and how much worse than the best they fit.

use super::interval::interval;
use super::problem::{Problem, Sureness};
use super::reading::Reading;
use super::search::Found;
use super::{Estimate, Parameter, Solution, scatter};
use crate::Result;
use crate::math::student::interval_95;
use crate::spectrum::Spectrum;

/// Samples from which on intervals also follow from their scatter.
const FEWEST_SAMPLES: usize = 3;

/// What solutions are held against.
pub(super) struct Weighing<'a> {
    pub(super) problem: &'a Problem<'a>,
    pub(super) readings: &'a [Reading],
    /// By what the best solution's least sure size is less so than under independent errors.
    pub(super) inflation: f64,
    /// Up to which [`Self::worse_by`] the measurement does not decide.
    pub(super) likely: f64,
    pub(super) best: f64,
}

impl Weighing<'_> {
    /// How much worse than the best sizes fit: Δχ².
    pub(super) fn worse_by(&self, found: &Found) -> f64 {
        (found.left.squares - self.best) / self.inflation
    }

    pub(super) fn solution(&self, found: &Found) -> Result<Solution> {
        let (count, freedom) = (found.sizes.len(), self.problem.freedom_of_variance());
        let quantile = interval_95(freedom);
        let Sureness { covariance, inflation } = self.problem.sureness(&found.left).unwrap_or_else(|| {
            Sureness { covariance: vec![f64::INFINITY; count * count], inflation: vec![1.0; count] }
        });
        let mut sizes = Vec::with_capacity(count);
        for size in 0..count {
            let expected = quantile * covariance[size * count + size].sqrt();
            let worse = quantile * quantile * inflation[size];
            sizes.push(interval(self.problem, found, size, worse, expected)?);
        }
        let between_samples = self.between_samples(found);
        if let Some((_, error, freedom)) = &between_samples {
            let reach = error.iter().map(|error| interval_95(*freedom) * error);
            let ranges = self.problem.model.parameters();
            for ((size, reach), range) in sizes.iter_mut().zip(reach).zip(ranges) {
                *size = size.widened(reach, range);
            }
        }
        let (fitted, rmse, explained) = self.curves(found)?;
        Ok(Solution {
            sizes,
            covariance: covariance.chunks_exact(count).map(<[f64]>::to_vec).collect(),
            between_samples: between_samples.map(|(deviation, ..)| deviation),
            levels: found.left.levels.clone(),
            rmse,
            explained,
            worse_by: self.worse_by(found),
            as_good: self.worse_by(found) <= self.likely,
            fitted,
        })
    }

    /// Deviation of each size between samples, its standard error, and the degrees of freedom of both: what each sample's own
    /// difference from the mean changes the sizes by. Only where every reading has samples enough.
    fn between_samples(&self, found: &Found) -> Option<(Vec<f64>, Vec<f64>, f64)> {
        let fewest = self.readings.iter().map(|reading| reading.samples.len()).min()?;
        if fewest < FEWEST_SAMPLES {
            return None;
        }
        let mut variance = vec![0.0; found.sizes.len()];
        let mut of_mean = variance.clone();
        for (k, reading) in self.readings.iter().enumerate() {
            let count = reading.samples.len() as f64;
            for sample in &reading.samples {
                let change: Vec<f64> =
                    sample.values().iter().zip(reading.mean.values()).map(|(a, b)| a - b).collect();
                for (j, change) in self.problem.response(&found.left, k, &change)?.iter().enumerate() {
                    variance[j] += change * change / (count - 1.0);
                    of_mean[j] += change * change / ((count - 1.0) * count);
                }
            }
        }
        let root = |values: Vec<f64>| values.into_iter().map(f64::sqrt).collect();
        Some((root(variance), root(of_mean), fewest as f64 - 1.0))
    }

    /// The fitted curves, the root mean square of what they leave, and the part of the variance that they explain.
    fn curves(&self, found: &Found) -> Result<(Vec<Spectrum>, f64, f64)> {
        let mut values = vec![0.0; found.left.residuals.len()];
        self.problem.model.values(&found.sizes, &mut values)?;
        let (mut start, mut curves, mut left, mut whole) = (0, Vec::new(), 0.0, 0.0);
        for (reading, [level, offset]) in self.readings.iter().zip(&found.left.levels) {
            let measured = reading.mean.values();
            let fitted: Vec<f64> =
                values[start..start + measured.len()].iter().map(|value| level * value + offset).collect();
            start += measured.len();
            left += fitted.iter().zip(measured).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            whole += scatter(reading).powi(2) * measured.len() as f64;
            curves.push(Spectrum::new(reading.mean.wavelengths().clone(), fitted)?);
        }
        Ok((curves, (left / values.len() as f64).sqrt(), 1.0 - left / whole))
    }
}

impl Estimate {
    /// The same with ends at least so far from the value, within the range.
    fn widened(self, reach: f64, range: &Parameter) -> Self {
        let (low, high) = (self.low.min(self.value - reach), self.high.max(self.value + reach));
        Self {
            low: low.max(range.low),
            high: high.min(range.high),
            open: [self.open[0] || low <= range.low, self.open[1] || high >= range.high],
            ..self
        }
    }
}
