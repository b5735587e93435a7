//! The part of a node's intensity that does not fluctuate from barbule to barbule.
//!
//! A field v + n of a steady modulus and a Gaussian rest has U = A² + 2σ² and Var I = U² − A⁴, whatever the phase of v is:
//! A⁴ = U² (1 − C²) with the contrast C. Where a barbule's slope dims and brightens it too (by τ, see the module `slope`), a
//! sample of M instances is expected to show C₀² if nothing is steady and C₁² if all is, so that
//!
//! ```text
//! A⁴ = U² (C₀² − C²)/(C₀² − C₁²),    without slopes C₀² = (M − 1)/(M + 1), C₁² = 0,
//! ```
//!
//! signed, like the intensity V of the mean field, which is a second, lower bound of A².

use super::fitted::scale_of;
use crate::scattering::lobe::{Fitter, Lobe, Power, SteadyFit};
use crate::scattering::statistics::AZIMUTHS;

/// With fewer instances contrasts say nothing.
pub(super) const FEWEST: usize = 8;

/// Where residuals of steady parts count less: a part of the mean's peak.
const FLOOR: f64 = 0.01;

/// The most that a steady part is raised to make up for what the mean cuts off.
const MOST_RAISED: f64 = 3.0;

/// What was found of one incident polarization at one node, on the azimuths.
pub(super) struct Observed {
    /// U, 1/rad.
    pub(super) u: Vec<f64>,
    /// V without its bias, signed.
    pub(super) v: Vec<f64>,
    /// Squared contrast C², population form.
    pub(super) contrast2: Vec<f64>,
    /// The mean intensity of the fitted lobes, which the steady part never exceeds.
    pub(super) mean: Vec<f64>,
}

/// One node of a set.
pub(super) struct Node<'a> {
    pub(super) fitter: &'a Fitter,
    pub(super) cos_theta: f64,
    /// Incident azimuth, rad.
    pub(super) phi_i: f64,
    /// Whether the node is its own mirror image.
    pub(super) is_even: bool,
    pub(super) instances: usize,
    /// Δx_o at which the autocovariance of the fields falls to 1/e.
    pub(super) correlation: f64,
    /// The lobes of the mean.
    pub(super) lobes: &'a [Lobe],
    /// C² that instances are expected to show on the azimuths, without a steady part and with nothing but one.
    pub(super) expected: Vec<[f64; 2]>,
    /// The polarizations that the set stands for.
    pub(super) observed: Vec<Observed>,
}

/// The steady part of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Steady {
    pub(super) lobe: Lobe,
    /// Reflected fraction, mean over the polarizations.
    pub(super) reflected: f64,
    /// Part of the first polarization in it.
    pub(super) fraction_1: f64,
}

impl Node<'_> {
    /// Fits the squared steady intensity and the mean field, and takes what has the larger total.
    pub(super) fn fit(&self) -> Steady {
        let squared = (self.instances >= FEWEST).then(|| self.squares()).flatten();
        let coherent = (self.instances > 1).then(|| self.coherent()).flatten();
        let total = |fit: &SteadyFit| {
            fit.scales.iter().sum::<f64>()
                / scale_of(&self.fitter.steady_values(fit.lobe), self.cos_theta, 1.0)
        };
        let best = [squared, coherent].into_iter().flatten().max_by(|a, b| total(a).total_cmp(&total(b)));
        let Some(best) = best else {
            return Steady { lobe: self.lobes[0], reflected: 0.0, fraction_1: 0.5 };
        };
        let shape = self.fitter.steady_values(best.lobe);
        let mut scales = best.scales;
        for (scale, observed) in scales.iter_mut().zip(&self.observed) {
            *scale = raised(*scale, &shape, &observed.mean);
        }
        let count = self.observed.len() as f64;
        let sum: f64 = scales.iter().sum();
        let reflected = sum / count / scale_of(&shape, self.cos_theta, 1.0);
        let fraction_1 = if sum > 0.0 { scales[0] / sum } else { 0.5 };
        Steady { lobe: best.lobe, reflected, fraction_1 }
    }

    /// s from A⁴: scales on the steady shape.
    fn squares(&self) -> Option<SteadyFit> {
        let count = self.instances as f64;
        let target = |o: &Observed| {
            let found = o.u.iter().zip(&o.contrast2).zip(&self.expected);
            self.folded(found.map(|((u, c2), [speckle, steady])| u * u * (speckle - c2) / (speckle - steady)))
        };
        let targets: Vec<Vec<f64>> = self.observed.iter().map(target).collect();
        // What counts is the contrast where the light is: residuals of (s/f̂)² times f̂.
        let weights = self.weights(1.0);
        let mut fit = self.best(Power::Second, &targets, &weights)?;
        let shape = self.fitter.steady_values(fit.lobe);
        let weights: Vec<f64> = shape.iter().zip(&weights).map(|(s, w)| s * s * w * w).collect();
        let square = weights.iter().zip(&shape).map(|(w, s)| w * s * s).sum();
        for (scale, observed) in fit.scales.iter_mut().zip(&self.observed) {
            // 4I − I², whose mean is 2⟨I⟩² − ⟨I²⟩ about ⟨I⟩ = 1, is 2 − 2L₂(I) with Laguerre's polynomial L₂: of
            // speckle it has the variance 4 and the correlation |μ|⁴; of a field that is nearly steady 4C².
            let deviation = observed.u.iter().zip(&observed.contrast2).map(|(u, c2)| 2.0 * u * u * c2.sqrt());
            let variance = self.variance(&weights, square, deviation, 0.5) / count;
            *scale = shrunk(*scale, variance).sqrt();
        }
        Some(fit)
    }

    /// s from V: scales on the steady shape.
    fn coherent(&self) -> Option<SteadyFit> {
        let count = self.instances as f64;
        let targets: Vec<Vec<f64>> = self.observed.iter().map(|o| self.folded(o.v.iter().copied())).collect();
        let weights = self.weights(0.5);
        let mut fit = self.best(Power::First, &targets, &weights)?;
        let shape = self.fitter.steady_values(fit.lobe);
        let weights: Vec<f64> = shape.iter().zip(&weights).map(|(s, w)| s * w * w).collect();
        let square = weights.iter().zip(&shape).map(|(w, s)| w * s).sum();
        for (scale, observed) in fit.scales.iter_mut().zip(&self.observed) {
            // Of speckle |mean|² is exponential with the mean U/M; it correlates as |μ|².
            let deviation = observed.u.iter().map(|u| u / count);
            let variance = self.variance(&weights, square, deviation, std::f64::consts::FRAC_1_SQRT_2);
            *scale = shrunk(*scale, variance);
        }
        Some(fit)
    }

    fn best(&self, power: Power, targets: &[Vec<f64>], weights: &[f64]) -> Option<SteadyFit> {
        let peak = (0..AZIMUTHS).max_by(|&a, &b| {
            let sum = |k: usize| targets.iter().map(|target| target[k]).sum::<f64>();
            sum(a).total_cmp(&sum(b))
        })?;
        let phi_o =
            (peak as f64 + 0.5) * std::f64::consts::PI / AZIMUTHS as f64 - std::f64::consts::FRAC_PI_2;
        let at_peak = Lobe { phi: -phi_o, ..self.lobes[0] };
        let starts: Vec<Lobe> = self
            .lobes
            .iter()
            .chain([&at_peak])
            .flat_map(|lobe| {
                [1.0, 2.5].map(|factor| Lobe {
                    m: (factor * lobe.m).clamp(0.003, 0.95),
                    phi: if self.is_even { 0.0 } else { lobe.phi },
                })
            })
            .collect();
        let targets: Vec<&[f64]> = targets.iter().map(|target| &target[..]).collect();
        self.fitter.fit_steady(power, self.phi_i, !self.is_even, &starts, &targets, weights)
    }

    /// The fitted mean to a negative power, bounded in the wings.
    fn weights(&self, power: f64) -> Vec<f64> {
        let sum = |k: usize| self.observed.iter().map(|o| o.mean[k]).sum::<f64>();
        let peak = (0..AZIMUTHS).map(sum).fold(f64::MIN_POSITIVE, f64::max);
        (0..AZIMUTHS).map(|k| libm::pow(sum(k) / peak + FLOOR, -power)).collect()
    }

    /// The mean with the mirror image where the node is its own.
    fn folded(&self, values: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut values: Vec<f64> = values.collect();
        if self.is_even {
            fold(&mut values);
        }
        values
    }

    /// Variance of Σ weight · noise / `square` for noise of these deviations; neighbours correlate as exp(−(Δx/(cℓ))²) with
    /// c = `narrowing`.
    fn variance(
        &self,
        weights: &[f64],
        square: f64,
        deviations: impl Iterator<Item = f64>,
        narrowing: f64,
    ) -> f64 {
        let step = std::f64::consts::PI / AZIMUTHS as f64;
        let cell = narrowing * self.correlation * std::f64::consts::PI.sqrt();
        let (mut apart, mut together) = (0.0, 0.0);
        for ((k, weight), deviation) in weights.iter().enumerate().zip(deviations) {
            let phi_o = (k as f64 + 0.5) * step - std::f64::consts::FRAC_PI_2;
            let per_cell = (cell / (self.cos_theta * libm::cos(phi_o) * step)).max(1.0);
            let term = weight * deviation;
            apart += term * term * per_cell;
            together += term;
        }
        // No more than if all azimuths moved as one.
        apart.min(together * together) / (square * square).max(f64::MIN_POSITIVE)
    }
}

/// What an estimate with this variance says: all of it where it is many deviations, next to nothing below one.
fn shrunk(estimate: f64, variance: f64) -> f64 {
    let square = estimate * estimate;
    if square <= 0.0 {
        return 0.0;
    }
    estimate / (1.0 + 4.0 * (variance / square) * (variance / square))
}

/// The scale with which the shape, cut off at `mean`, has the squares that it has with `scale` uncut.
fn raised(scale: f64, shape: &[f64], mean: &[f64]) -> f64 {
    let squares = |scale: f64| -> f64 {
        let cut = shape.iter().zip(mean).map(|(shape, mean)| (scale * shape).min(*mean) * shape);
        cut.map(|v| v * v).sum()
    };
    let wanted: f64 = shape.iter().map(|s| (scale * s * s) * (scale * s * s)).sum();
    if squares(scale) >= wanted * (1.0 - 1e-9) {
        return scale;
    }
    let (mut low, mut high) = (scale, MOST_RAISED * scale);
    for _ in 0..20 {
        let middle = 0.5 * (low + high);
        if squares(middle) < wanted { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Takes the mean with the mirror image.
pub(super) fn fold(values: &mut [f64]) {
    let count = values.len();
    for k in 0..count / 2 {
        let mean = 0.5 * (values[k] + values[count - 1 - k]);
        (values[k], values[count - 1 - k]) = (mean, mean);
    }
}
