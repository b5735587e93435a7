//! How far the noise of both incident polarizations is the same.
//!
//! Intensities (μ_p + σ_p q_p)² whose noises correlate by γ have the covariance 4 μ₁μ₂σ₁σ₂γ + 4 σ₁²σ₂²γ² and the variances
//! 4 μ_p²σ_p² + 4 σ_p⁴, with μ_p² = s_p and 2σ_p² = f̂_p − s_p. The slope's factor τ, which both share, makes of a relative
//! covariance c the covariance E[τ²](1 + c) − 1.

use super::fitted::Fitted;
use super::slope;

/// The γ in \[0, 1\] with which the patterns of both polarizations correlate as `wanted`: relative deviations, weighted by
/// the mean intensity of both.
pub(super) fn solved(sides: &[Fitted; 2], wanted: f64) -> f64 {
    let Terms { shared, linear, quadratic, spread } = Terms::new(sides);
    if spread <= 0.0 || !wanted.is_finite() {
        // Nothing fluctuates: any γ does.
        return 1.0;
    }
    let wanted = wanted * spread - shared;
    if wanted <= 0.0 {
        return 0.0;
    }
    if wanted >= linear + quadratic {
        return 1.0;
    }
    // The positive root of quadratic γ² + linear γ = wanted, in the form without cancellation.
    2.0 * wanted / (linear + (linear * linear + 4.0 * quadratic * wanted).sqrt())
}

/// The correlation of the patterns with this γ.
#[cfg(test)]
pub(super) fn expected(sides: &[Fitted; 2], gamma: f64) -> f64 {
    let Terms { shared, linear, quadratic, spread } = Terms::new(sides);
    if spread > 0.0 { (shared + linear * gamma + quadratic * gamma * gamma) / spread } else { 1.0 }
}

/// Weighted sums over the azimuths: the covariance is shared + linear·γ + quadratic·γ², the product of the deviations
/// `spread`.
struct Terms {
    shared: f64,
    linear: f64,
    quadratic: f64,
    spread: f64,
}

impl Terms {
    fn new(sides: &[Fitted; 2]) -> Self {
        let floor = [0, 1].map(|p| 1e-12 * sides[p].mean.iter().fold(0.0, |a: f64, b| a.max(*b)));
        let variance = *slope::VARIANCE;
        let (mut shared, mut linear, mut quadratic, mut squares) = (0.0, 0.0, 0.0, [0.0; 2]);
        for k in 0..sides[0].mean.len() {
            let [first, second] = [0, 1].map(|p| sides[p].mean[k]);
            if first <= floor[0] || second <= floor[1] {
                continue;
            }
            let weight = first + second;
            // s/f̂ and what is left of it.
            let steady = [sides[0].steady[k] / first, sides[1].steady[k] / second];
            let rest = steady.map(|part| 1.0 - part);
            // E[τ²] − 1 of both polarizations together, and of each.
            let [h, h_2] = [0, 1].map(|p| sides[p].sloped[k]);
            let tau2 = |h: f64, h_2: f64| variance * h * h_2;
            let both = tau2(h, h_2);
            shared += weight * both;
            linear +=
                (1.0 + both) * weight * 2.0 * (steady[0] * steady[1] * rest[0] * rest[1]).max(0.0).sqrt();
            quadratic += (1.0 + both) * weight * rest[0] * rest[1];
            for ((sum, part), h) in squares.iter_mut().zip(steady).zip([h, h_2]) {
                *sum += weight * ((1.0 + tau2(h, h)) * (2.0 - part * part) - 1.0);
            }
        }
        Self { shared, linear, quadratic, spread: (squares[0] * squares[1]).sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sides() -> [Fitted; 2] {
        let mean: Vec<f64> = (0..40).map(|k| 1.0 + libm::sin(0.2 * f64::from(k))).collect();
        [0.7, 0.3].map(|part| Fitted {
            mean: mean.clone(),
            steady: mean.iter().map(|m| part * m).collect(),
            sloped: vec![0.6; 40],
        })
    }

    /// Against intensities that are drawn: field by field, with both noises.
    #[test]
    fn correlations_are_those_of_drawn_intensities() {
        let sides = sides();
        for gamma in [0.0, 0.4, 0.8, 1.0] {
            let mut stream = crate::math::rng::Stream::new(7, &[]);
            let (mut cross, mut squares) = (0.0, [0.0; 2]);
            let values = slope::values();
            for _ in 0..400_000 {
                let tau = 1.0 + 0.6 * (values[stream.bits() as usize % slope::VALUES] - 1.0);
                let noise = [stream.normal(), stream.normal()];
                let other = noise.map(|q| gamma * q + f64::sqrt(1.0 - gamma * gamma) * stream.normal());
                let mean = [&sides[0], &sides[1]].map(|side| (side.mean[3], side.steady[3]));
                let deviation = [(mean[0], noise), (mean[1], other)].map(|((mean, steady), [r, i])| {
                    let spread = f64::sqrt(0.5 * (mean - steady));
                    let (re, im) = (steady.sqrt() + spread * r, spread * i);
                    tau * (re * re + im * im) / mean - 1.0
                });
                cross += deviation[0] * deviation[1];
                squares = [squares[0] + deviation[0].powi(2), squares[1] + deviation[1].powi(2)];
            }
            let found = cross / (squares[0] * squares[1]).sqrt();
            assert!(
                (solved(&sides, found) - gamma).abs() < 0.02,
                "{gamma} {found} {}",
                solved(&sides, found)
            );
        }
    }

    #[test]
    fn what_cannot_be_reached_is_bounded() {
        let sides = sides();
        assert_eq!(solved(&sides, -0.2), 0.0);
        assert_eq!(solved(&sides, 1.2), 1.0);
        assert_eq!(solved(&sides, f64::NAN), 1.0);
        let dark = [0, 1].map(|_| Fitted { mean: vec![0.0; 4], steady: vec![0.0; 4], sloped: vec![0.0; 4] });
        assert_eq!(solved(&dark, 0.3), 1.0);
    }
}
