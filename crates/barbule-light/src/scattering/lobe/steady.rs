//! The lobe of what does not fluctuate.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DVector, Dyn, Matrix, OMatrix, U2, VecStorage, Vector2, storage::Owned};

use super::{Azimuths, Fitter, Lobe, Parameters, bounded, bounded_phi, chain, dot, unbounded};

/// Which power of the steady shape is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Power {
    /// The intensity itself.
    First,
    /// The squared intensity.
    Second,
}

/// A fitted steady lobe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteadyFit {
    /// The lobe.
    pub lobe: Lobe,
    /// Factors on the power of its steady shape, ≥ 0, of each of the targets.
    pub scales: [f64; 2],
}

/// Turns a lobe's shape into its steady shape.
pub(super) fn narrow(parameters: &Parameters, azimuths: &Azimuths, shape: &mut [f64]) {
    for ((value, s), c) in shape.iter_mut().zip(&azimuths.sin).zip(&azimuths.cos) {
        let hx = s * parameters.cos + c * parameters.sin;
        let part = parameters.m2 / (parameters.m2 + (1.0 - parameters.m2) * hx * hx);
        *value *= part * part;
    }
}

impl Fitter {
    /// The lobe whose steady shape (or its square) comes nearest to one or two targets at once, each with a scale of its
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
        let weighted = |target: &&[f64]| target.iter().zip(weights).map(|(v, w)| v * w).collect();
        let targets: &[Vec<f64>] = &targets.iter().map(weighted).collect::<Vec<_>>();
        let free = self.best_steady(power, free_phi && freedom > 0.0, starts, targets, weights)?;
        if !free_phi || freedom >= 1.0 {
            return Some(free);
        }
        let phi = bounded_phi(phi_i + freedom * (free.lobe.phi - phi_i));
        self.best_steady(power, false, &[Lobe { phi, ..free.lobe }], targets, weights)
    }

    /// Refines the best of the starts.
    fn best_steady(
        &self,
        power: Power,
        free_phi: bool,
        starts: &[Lobe],
        targets: &[Vec<f64>],
        weights: &[f64],
    ) -> Option<SteadyFit> {
        let norm = targets.iter().map(|target| dot(target, target)).sum::<f64>().sqrt();
        if !(norm.is_finite() && norm > 0.0) {
            return None;
        }
        let problem = |lobe: &Lobe| Problem::new(self, power, targets, weights, norm, free_phi, *lobe);
        let start = starts
            .iter()
            .map(problem)
            .filter(|problem| problem.scales.iter().any(|scale| *scale > 0.0))
            .min_by(|a, b| a.error().total_cmp(&b.error()))?;
        let settings =
            LevenbergMarquardt::new().with_ftol(1e-5).with_xtol(1e-6).with_gtol(1e-8).with_patience(15);
        let (problem, _) = settings.minimize(start);
        Some(SteadyFit { lobe: problem.lobe(), scales: problem.scales })
    }
}

/// Least squares over the unbounded parameters (t, u) of the lobe, scales eliminated.
struct Problem<'a> {
    fitter: &'a Fitter,
    power: Power,
    targets: &'a [Vec<f64>],
    weights: &'a [f64],
    norm: f64,
    free_phi: bool,
    parameters: Vector2<f64>,
    /// The power of the steady shape, weighted.
    shape: Vec<f64>,
    square: f64,
    scales: [f64; 2],
    residuals: DVector<f64>,
}

impl<'a> Problem<'a> {
    fn new(
        fitter: &'a Fitter,
        power: Power,
        targets: &'a [Vec<f64>],
        weights: &'a [f64],
        norm: f64,
        free_phi: bool,
        start: Lobe,
    ) -> Self {
        let [t, u] = unbounded(start, free_phi);
        let count = fitter.azimuths.sin.len();
        let mut problem = Self {
            fitter,
            power,
            targets,
            weights,
            norm,
            free_phi,
            parameters: Vector2::new(t, u),
            shape: vec![0.0; count],
            square: 0.0,
            scales: [0.0; 2],
            residuals: DVector::zeros(count * targets.len()),
        };
        problem.update();
        problem
    }

    fn lobe(&self) -> Lobe {
        bounded(self.parameters.x, self.parameters.y)
    }

    /// Shape, scales and residuals at the present parameters.
    fn update(&mut self) {
        let parameters = Parameters::new(self.lobe());
        self.fitter.evaluate(&parameters, &mut self.shape);
        narrow(&parameters, &self.fitter.azimuths, &mut self.shape);
        if self.power == Power::Second {
            for value in &mut self.shape {
                *value *= *value;
            }
        }
        for (value, weight) in self.shape.iter_mut().zip(self.weights) {
            *value *= weight;
        }
        self.square = dot(&self.shape, &self.shape);
        let count = self.shape.len();
        for (k, target) in self.targets.iter().enumerate() {
            self.scales[k] = (dot(&self.shape, target) / self.square).max(0.0);
            let out = &mut self.residuals.as_mut_slice()[k * count..(k + 1) * count];
            for ((out, value), shape) in out.iter_mut().zip(target).zip(&self.shape) {
                *out = (self.scales[k] * shape - value) / self.norm;
            }
        }
    }

    fn error(&self) -> f64 {
        dot(self.residuals.as_slice(), self.residuals.as_slice())
    }
}

impl LeastSquaresProblem<f64, Dyn, U2> for Problem<'_> {
    type ResidualStorage = VecStorage<f64, Dyn, nalgebra::U1>;
    type JacobianStorage = Owned<f64, Dyn, U2>;
    type ParameterStorage = Owned<f64, U2>;

    fn set_params(&mut self, parameters: &Vector2<f64>) {
        self.parameters = *parameters;
        self.update();
    }

    fn params(&self) -> Vector2<f64> {
        self.parameters
    }

    fn residuals(&self) -> Option<Matrix<f64, Dyn, nalgebra::U1, Self::ResidualStorage>> {
        Some(self.residuals.clone())
    }

    /// Kaufman's approximation: the derivative of the shape, less what the shape explains of it.
    fn jacobian(&self) -> Option<OMatrix<f64, Dyn, U2>> {
        let count = self.shape.len();
        let parameters = Parameters::new(self.lobe());
        let chain = chain(self.parameters.x, self.parameters.y, self.free_phi);
        let mut jacobian = OMatrix::<f64, Dyn, U2>::zeros(self.residuals.len());
        let rows = self.residuals.len();
        let (by_t, by_u) = jacobian.as_mut_slice().split_at_mut(rows);
        let Azimuths { sin, cos, slope } = &self.fitter.azimuths;
        for k in 0..count {
            let [t, u] = steady_slopes(self.fitter, &parameters, sin[k], cos[k], slope[k]);
            let factor = if self.power == Power::Second { 2.0 } else { 1.0 } * self.shape[k] / self.norm;
            by_t[k] = factor * chain[0] * t;
            by_u[k] = factor * chain[1] * u;
        }
        for column in [by_t, by_u] {
            let explained = dot(&column[..count], &self.shape) / self.square;
            for (value, shape) in column[..count].iter_mut().zip(&self.shape) {
                *value -= explained * shape;
            }
            for target in (0..self.targets.len()).rev() {
                for k in 0..count {
                    column[target * count + k] = self.scales[target] * column[k];
                }
            }
        }
        Some(jacobian)
    }
}

/// The derivatives of the steady shape's logarithm by ln m and by φ_eff.
#[inline(always)]
fn steady_slopes(fitter: &Fitter, parameters: &Parameters, sin: f64, cos: f64, slope: f64) -> [f64; 2] {
    let [value, by_ln_m, by_phi] = parameters.derivatives(fitter.kind, sin, cos, slope);
    let m2 = parameters.m2;
    let hx = sin * parameters.cos + cos * parameters.sin;
    let hx_by_phi = 0.5 * (cos * parameters.cos - sin * parameters.sin);
    let inverse_q = 1.0 / (m2 + (1.0 - m2) * hx * hx);
    [
        by_ln_m / value + 4.0 - 4.0 * m2 * (1.0 - hx * hx) * inverse_q,
        by_phi / value - 4.0 * (1.0 - m2) * hx * hx_by_phi * inverse_q,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scattering::directions;
    use crate::scattering::lobe::FitKind;

    #[test]
    fn a_steady_lobe_is_found_again_from_two_targets() {
        let lobe = Lobe { m: 0.08, phi: 0.4 };
        let theta = 0.5;
        let shape: Vec<f64> =
            directions::azimuths(400).map(|p| lobe.steady_shape(FitKind::Marginal, theta, p)).collect();
        let fitter = Fitter::new(FitKind::Marginal, theta, 400);
        for (a, b) in fitter.steady_values(lobe).iter().zip(&shape) {
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
        let one = fitter.steady_values(Lobe { m: 0.2, phi: 0.3 });
        let two = fitter.values(Lobe { m: 0.3, phi: 0.2 });
        let targets = [one, two];
        let weights: Vec<f64> = (0..50).map(|k| 1.0 + 0.01 * f64::from(k)).collect();
        let start = Lobe { m: 0.25, phi: 0.25 };
        let mut problem = Problem::new(&fitter, Power::Second, &targets, &weights, 2.0, true, start);
        let gradient = problem.jacobian().unwrap().transpose() * &problem.residuals;
        let at = problem.parameters;
        for k in 0..2 {
            let mut error = |step: f64| {
                let mut moved = at;
                moved[k] += step;
                problem.set_params(&moved);
                0.5 * problem.error()
            };
            let expected = (error(1e-5) - error(-1e-5)) / 2e-5;
            assert!(
                (gradient[k] - expected).abs() < 1e-6 * (1.0 + expected.abs()),
                "{} {expected}",
                gradient[k]
            );
        }
    }
}
