//! The part of a mean that does not fluctuate.

use super::products::{Azimuths, Steady};
use super::search::{Least, Limits, Normal, least, of_one};
use super::{Fitter, Lobe, Parameters, bounded, bounded_phi, chain, dot, unbounded};

/// Which power of the steady share is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Power {
    /// The share itself.
    First,
    /// Its square.
    Second,
}

/// A fitted steady share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteadyFit {
    /// The lobe.
    pub lobe: Lobe,
    /// Factors on the power of its steady share, ≥ 0, of each of the targets.
    pub scales: [f64; 2],
}

/// When searches end.
const LIMITS: Limits = Limits { error: 1e-5, step: 1e-6, evaluations: 45 };

/// Multiplies values by a lobe's steady share.
pub(super) fn narrow(parameters: &Parameters, azimuths: &Azimuths, shape: &mut [f64]) {
    for ((value, s), c) in shape.iter_mut().zip(&azimuths.sin).zip(&azimuths.cos) {
        let hx = s * parameters.cos + c * parameters.sin;
        let part = parameters.m2 / (parameters.m2 + (1.0 - parameters.m2) * hx * hx);
        *value *= part * part;
    }
}

impl Fitter {
    /// The lobe whose steady share (or its square) comes nearest to one or two targets at once, each with a scale of its
    /// own, with light from φ_i, rad; residuals count as much as `weights` says at each azimuth. Targets may be negative; if
    /// none has anything positive that a start meets, `None`.
    ///
    /// `free_phi` false keeps the azimuths of the starts; towards grazing they pass over into φ_i.
    #[must_use]
    pub fn fit_steady(
        &self,
        power: Power,
        phi_i: f64,
        free_phi: bool,
        starts: &[Lobe],
        targets: &[&[f64]],
        weights: &[f64],
    ) -> Option<SteadyFit> {
        let freedom = self.freedom(phi_i);
        let problem = Problem::new(self, power, targets, weights)?;
        let free = problem.best(free_phi && freedom > 0.0, starts)?;
        if !free_phi || freedom >= 1.0 {
            return Some(free);
        }
        let phi = bounded_phi(phi_i + freedom * (free.lobe.phi - phi_i));
        problem.best(false, &[Lobe { phi, ..free.lobe }])
    }
}

/// Least squares over the unbounded parameters (t, u) of the lobe, scales eliminated.
struct Problem<'a> {
    fitter: &'a Fitter,
    squared: bool,
    /// Of one target or two, weighted; of one the second is zero.
    targets: [Vec<f64>; 2],
    weights: Vec<f64>,
    total: f64,
}

impl<'a> Problem<'a> {
    fn new(fitter: &'a Fitter, power: Power, targets: &[&[f64]], weights: &[f64]) -> Option<Self> {
        let weighted = |k: usize| {
            let target = targets.get(k).copied().unwrap_or(&[]);
            fitter.azimuths.padded(target.iter().zip(weights).map(|(v, w)| v * w))
        };
        let targets = [weighted(0), weighted(1)];
        let total = targets.iter().map(|target| dot(target, target)).sum::<f64>();
        let weights = fitter.azimuths.padded(weights.iter().copied());
        (total.is_finite() && total > 0.0).then_some(Self {
            fitter,
            squared: power == Power::Second,
            targets,
            weights,
            total,
        })
    }

    /// The equations at parameters, and the scales.
    fn at(&self, [t, u]: [f64; 2], free_phi: bool) -> (Normal<2>, [f64; 2]) {
        let columns = Steady { lobe: bounded(t, u), squared: self.squared, weights: &self.weights };
        let targets = [&self.targets[0][..], &self.targets[1][..]];
        let Fitter { azimuths, kind, .. } = self.fitter;
        of_one(&azimuths.products(*kind, &columns, targets), chain(t, u, free_phi), self.total)
    }

    /// Refines the best of the starts.
    fn best(&self, free_phi: bool, starts: &[Lobe]) -> Option<SteadyFit> {
        let (_, start) = starts
            .iter()
            .map(|start| unbounded(*start, free_phi))
            .filter_map(|start| {
                let (normal, scales) = self.at(start, free_phi);
                scales.iter().any(|scale| *scale > 0.0).then_some((normal.error, start))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))?;
        let Least { parameters: [t, u], with: scales, .. } =
            least(start, LIMITS, |place| self.at(place, free_phi));
        Some(SteadyFit { lobe: bounded(t, u), scales })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scattering::directions;
    use crate::scattering::lobe::FitKind;
    use crate::scattering::lobe::search::tests::gradients_match;

    #[test]
    fn a_steady_lobe_is_found_again_from_two_targets() {
        let lobe = Lobe { m: 0.08, phi: 0.4 };
        let theta = 0.5;
        let shape: Vec<f64> = directions::azimuths(400).map(|p| lobe.steady_share(p)).collect();
        let fitter = Fitter::new(FitKind::Marginal, theta, 400);
        for (a, b) in fitter.steady_shares(lobe).iter().zip(&shape) {
            assert!((a - b).abs() < 1e-12 * (1.0 + b));
        }
        for (power, exponent) in [(Power::First, 1), (Power::Second, 2)] {
            let target =
                |scale: f64| -> Vec<f64> { shape.iter().map(|s| scale * s.powi(exponent)).collect() };
            let (one, two) = (target(0.7), target(0.2));
            let starts = [Lobe { m: 0.2, phi: 0.3 }, Lobe { m: 0.05, phi: 0.35 }];
            let fit = fitter.fit_steady(power, 0.4, true, &starts, &[&one, &two], &[1.0; 400]).unwrap();
            assert!((fit.lobe.m / 0.08 - 1.0).abs() < 1e-4 && (fit.lobe.phi - 0.4).abs() < 1e-4, "{fit:?}");
            assert!((fit.scales[0] - 0.7).abs() < 1e-3 && (fit.scales[1] - 0.2).abs() < 1e-3, "{fit:?}");
        }
        let dark = vec![-1.0; 400];
        assert!(fitter.fit_steady(Power::Second, 0.4, true, &[lobe], &[&dark], &[1.0; 400]).is_none());
        assert!(fitter.fit_steady(Power::Second, 0.4, true, &[lobe], &[&[0.0; 400]], &[1.0; 400]).is_none());
    }

    #[test]
    fn gradients_match_differences() {
        let fitter = Fitter::new(FitKind::Marginal, 0.4, 50);
        let one = fitter.steady_shares(Lobe { m: 0.2, phi: 0.3 });
        let two = fitter.values(Lobe { m: 0.3, phi: 0.2 });
        let weights: Vec<f64> = (0..50).map(|k| 1.0 + 0.01 * f64::from(k)).collect();
        let start = Lobe { m: 0.25, phi: 0.25 };
        let problem = Problem::new(&fitter, Power::Second, &[&one, &two], &weights).unwrap();
        gradients_match(unbounded(start, true), 1e-8, |place| problem.at(place, true));
    }
}
