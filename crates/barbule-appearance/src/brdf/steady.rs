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
//! (C₀² less what is fixed since every barbule reflects as much, see [`of_kept_energy`]), signed, like the intensity V of the mean field, which is a second, lower bound of A². What is looked for is the part A²/U:
//! a narrow lobe of mirrors on flat tops, and much the same all over the lobe of an arch.

use crate::scattering::lobe::{Fitter, Lobe, Power, SteadyFit};
use crate::scattering::statistics::AZIMUTHS;

/// With fewer instances contrasts say nothing.
pub(super) const FEWEST: usize = 8;

/// Where residuals of steady parts count less: a part of the mean's peak.
const FLOOR: f64 = 0.01;

/// What was found of one incident polarization at one node, on the azimuths.
pub(super) struct Observed {
    /// U, 1/rad.
    pub(super) u: Vec<f64>,
    /// V without its bias, signed.
    pub(super) v: Vec<f64>,
    /// Squared contrast C², population form.
    pub(super) contrast2: Vec<f64>,
    /// The mean intensity of the fitted lobes.
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
    /// Part of the mean in the lobe's middle, the same of both polarizations.
    pub(super) share: f64,
    /// Part of the whole mean.
    pub(super) energy: f64,
}

impl Steady {
    /// Nothing.
    pub(super) fn none(lobe: Lobe) -> Self {
        Self { lobe, share: 0.0, energy: 0.0 }
    }
}

impl Node<'_> {
    /// Fits the squared steady intensity and the mean field, and takes what has the larger total.
    pub(super) fn fit(&self) -> Steady {
        let squared = (self.instances >= FEWEST).then(|| self.squares()).flatten();
        let coherent = (self.instances > 1).then(|| self.coherent()).flatten();
        let both = [squared, coherent].into_iter().flatten().map(|fit| self.steady(&fit));
        both.max_by(|a, b| a.energy.total_cmp(&b.energy)).unwrap_or(Steady::none(self.lobes[0]))
    }

    /// What the scales of a shape make of the means.
    fn steady(&self, fit: &SteadyFit) -> Steady {
        let shape = self.fitter.steady_shares(fit.lobe);
        let (mut whole, mut energy, mut sum) = (0.0, 0.0, 0.0);
        for (observed, scale) in self.observed.iter().zip(fit.scales) {
            let mean: f64 = observed.mean.iter().sum();
            let steady = observed.mean.iter().zip(&shape).map(|(mean, part)| mean * part).sum::<f64>();
            (whole, sum) = (whole + mean, sum + scale.min(1.0) * mean);
            energy += scale.min(1.0) * steady;
        }
        let whole = f64::max(whole, f64::MIN_POSITIVE);
        Steady { lobe: fit.lobe, share: (sum / whole).min(1.0), energy: energy / whole }
    }

    /// s from A⁴: scales on the steady shares.
    fn squares(&self) -> Option<SteadyFit> {
        let count = self.instances as f64;
        let target = |o: &Observed| {
            let found = o.u.iter().zip(&o.contrast2).zip(&self.expected);
            let is_dark = |u: f64| u <= f64::MIN_POSITIVE;
            self.folded(found.map(
                |((u, c2), [speckle, steady])| {
                    if is_dark(*u) { 0.0 } else { (speckle - c2) / (speckle - steady) }
                },
            ))
        };
        let targets: Vec<Vec<f64>> = self.observed.iter().map(target).collect();
        let weights = self.weights();
        let mut fit = self.best(Power::Second, &targets, &weights)?;
        let shape = self.fitter.steady_shares(fit.lobe);
        let weights: Vec<f64> = shape.iter().zip(&weights).map(|(s, w)| s * s * w * w).collect();
        let square = weights.iter().zip(&shape).map(|(w, s)| w * s * s).sum();
        for (scale, observed) in fit.scales.iter_mut().zip(&self.observed) {
            // 4I − I², whose mean is 2⟨I⟩² − ⟨I²⟩ about ⟨I⟩ = 1, is 2 − 2L₂(I) with Laguerre's polynomial L₂: of
            // speckle it has the variance 4 and the correlation |μ|⁴; of a field that is nearly steady 4C².
            let deviation = observed.contrast2.iter().map(|c2| 2.0 * c2.sqrt());
            let variance = self.variance(&weights, square, deviation, 0.5) / count * self.chances(&shape);
            *scale = shrunk(*scale, variance).sqrt();
        }
        Some(fit)
    }

    /// s from V: scales on the steady shares.
    fn coherent(&self) -> Option<SteadyFit> {
        let count = self.instances as f64;
        let part = |(u, v): (&f64, &f64)| if *u > f64::MIN_POSITIVE { v / u } else { 0.0 };
        let target = |o: &Observed| self.folded(o.u.iter().zip(&o.v).map(part));
        let targets: Vec<Vec<f64>> = self.observed.iter().map(target).collect();
        let weights = self.weights();
        let mut fit = self.best(Power::First, &targets, &weights)?;
        let shape = self.fitter.steady_shares(fit.lobe);
        let weights: Vec<f64> = shape.iter().zip(&weights).map(|(s, w)| s * w * w).collect();
        let square = weights.iter().zip(&shape).map(|(w, s)| w * s).sum();
        for scale in &mut fit.scales {
            // Of speckle |mean|² is exponential with the mean U/M; it correlates as |μ|².
            let deviation = shape.iter().map(|_| 1.0 / count);
            let variance = self.variance(&weights, square, deviation, std::f64::consts::FRAC_1_SQRT_2);
            let variance = variance * self.chances(&shape);
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
                [1.0, 2.5, 10.0].map(|factor| Lobe {
                    m: (factor * lobe.m).clamp(0.003, 0.95),
                    phi: if self.is_even { 0.0 } else { lobe.phi },
                })
            })
            .collect();
        let targets: Vec<&[f64]> = targets.iter().map(|target| &target[..]).collect();
        self.fitter.fit_steady(power, self.phi_i, !self.is_even, &starts, &targets, weights)
    }

    /// The root of the fitted mean, so that squares of residuals count by the light there, with something for the wings.
    fn weights(&self) -> Vec<f64> {
        let sum = |k: usize| self.observed.iter().map(|o| o.mean[k]).sum::<f64>();
        let peak = (0..AZIMUTHS).map(sum).fold(f64::MIN_POSITIVE, f64::max);
        (0..AZIMUTHS).map(|k| (sum(k) / peak + FLOOR).sqrt()).collect()
    }

    /// The mean with the mirror image where the node is its own.
    fn folded(&self, values: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut values: Vec<f64> = values.collect();
        if self.is_even {
            fold(&mut values);
        }
        values
    }

    /// How much a variance grows by the choice of the best of many places: of N independent normal numbers the largest is about
    /// √(2 lnN) deviations, and a narrow shape could stand at as many places as the mean is wider than it.
    fn chances(&self, shape: &[f64]) -> f64 {
        let (mut whole, mut part) = (0.0, 0.0);
        for observed in &self.observed {
            for (mean, share) in observed.mean.iter().zip(shape) {
                (whole, part) = (whole + mean, part + mean * share);
            }
        }
        1.0 + 2.0 * libm::log(f64::max(whole / f64::max(part, f64::MIN_POSITIVE), 1.0))
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

/// What is left of C² of speckle where every barbule reflects as much as the next one: of N cells of speckle in a lobe that share
/// out what is reflected (a Dirichlet distribution) each has (N − 1)/(N + 1). Instances know of no such sharing: taken as steady it
/// makes their patterns coarser, left out it makes them vary too much. Its fourth root leaves both within what 50 barbules tell.
///
/// `mean` is the lobe on azimuths, `correlation` the Δx_o at which the autocovariance of the fields falls to 1/e.
pub(super) fn of_kept_energy(mean: &[f64], cos_theta: f64, correlation: f64) -> f64 {
    let step = std::f64::consts::PI / mean.len().max(1) as f64;
    let (mut sum, mut squares) = (0.0, 0.0);
    for (k, value) in mean.iter().enumerate() {
        let phi_o = (k as f64 + 0.5) * step - std::f64::consts::FRAC_PI_2;
        let dx = cos_theta * libm::cos(phi_o) * step;
        (sum, squares) = (sum + value * dx, squares + value * value * dx);
    }
    let cell = correlation * std::f64::consts::FRAC_PI_2.sqrt();
    let cells = (sum * sum / (squares * cell).max(f64::MIN_POSITIVE)).max(FEWEST_CELLS);
    ((cells - 1.0) / (cells + 1.0)).sqrt().sqrt()
}

/// A lobe of fewer cells is one cell with its rim, and says nothing of the kind.
const FEWEST_CELLS: f64 = 8.0;

/// What an estimate with this variance says: all of it where it is many deviations, next to nothing below one.
fn shrunk(estimate: f64, variance: f64) -> f64 {
    let square = estimate * estimate;
    if square <= 0.0 {
        return 0.0;
    }
    estimate / (1.0 + 4.0 * (variance / square) * (variance / square))
}

/// Takes the mean with the mirror image.
pub(super) fn fold(values: &mut [f64]) {
    let count = values.len();
    for k in 0..count / 2 {
        let mean = 0.5 * (values[k] + values[count - 1 - k]);
        (values[k], values[count - 1 - k]) = (mean, mean);
    }
}
