//! How roughness spreads a lobe along the fibre and around it. Both densities are normalized and sampled exactly.

use std::f64::consts::{PI, TAU};

use crate::math::elementary::{exp, ln, sin_cos_turns};

/// Lobes whose density is below e^−60 of what it could be add nothing.
pub(super) const NEGLIGIBLE: f64 = -60.0;

/// Along the fibre: d'Eon et al. 2011, *An energy-conserving hair reflectance model*,
/// M(θ_i, θ_o) = exp(−sinθ_i sinθ_o/v) I₀(cosθ_i cosθ_o/v) / (2v sinh(1/v)), with ∫ M cosθ_i dθ_i = 1 for every θ_o.
///
/// It is the density of a von Mises–Fisher lobe about the direction of inclination −θ_o, seen without its azimuth.
#[derive(Debug, Clone, Copy)]
pub(super) struct Longitudinal {
    variance: f64,
    inverse: f64,
    /// e^(−2/v).
    least: f64,
    /// 1/(v (1 − e^(−2/v))): the normalization without its e^(1/v), which overflows.
    scale: f64,
}

impl Longitudinal {
    pub(super) fn new(variance: f64) -> Self {
        let least = exp(-2.0 / variance);
        Self { variance, inverse: 1.0 / variance, least, scale: 1.0 / (variance * (1.0 - least)) }
    }

    /// One over the variance.
    pub(super) fn inverse(&self) -> f64 {
        self.inverse
    }

    /// The normalization, without e^(1/v).
    pub(super) fn scale(&self) -> f64 {
        self.scale
    }

    /// The density; directions by sine and cosine of their inclinations.
    #[cfg(test)]
    pub(super) fn density(&self, [sin_o, cos_o]: [f64; 2], sin_i: f64, cos_i: f64) -> f64 {
        let a = cos_i * cos_o * self.inverse;
        // Without I₀'s own e^a, which a small variance would make overflow.
        let rest = -(sin_i * sin_o + 1.0) * self.inverse;
        let is_small = a < SMALL;
        let power = if is_small { rest } else { a + rest };
        let i0 = if is_small { i0_small(a) } else { i0_large(a) };
        if power < NEGLIGIBLE { 0.0 } else { self.scale * i0 * exp(power) }
    }

    /// Sine of an inclination with that density, from two uniform numbers (d'Eon et al. 2013, *Importance sampling for
    /// physically-based hair fiber models*).
    #[inline(always)]
    pub(super) fn sample(&self, [sin_o, cos_o]: [f64; 2], u: f64, v: f64) -> f64 {
        let cosine = (1.0 + self.variance * ln(u + (1.0 - u) * self.least)).clamp(-1.0, 1.0);
        let sine = (1.0 - cosine * cosine).sqrt();
        (-cosine * sin_o + sine * sin_cos_turns(v)[1] * cos_o).clamp(-1.0, 1.0)
    }
}

/// Where the two approximations of I₀ meet.
pub(super) const SMALL: f64 = 3.75;

/// I₀(x) − 1 for 0 ≤ x ≤ 3.75 in powers of (x/3.75)² from the first on (Abramowitz & Stegun 9.8.1, within 1.6e-7).
pub(super) const SMALL_I0: [f64; 6] =
    [3.515_622_9, 3.089_942_4, 1.206_749_2, 0.265_973_2, 0.036_076_8, 0.004_581_3];

/// √x I₀(x) e^−x for x ≥ 3.75 in powers of 3.75/x (Abramowitz & Stegun 9.8.2, within 1.9e-7).
pub(super) const LARGE_I0: [f64; 9] = [
    0.398_942_28,
    0.013_285_92,
    0.002_253_19,
    -0.001_575_65,
    0.009_162_81,
    -0.020_577_06,
    0.026_355_37,
    -0.016_476_33,
    0.003_923_77,
];

#[cfg(test)]
fn i0_small(x: f64) -> f64 {
    let t = (x / SMALL) * (x / SMALL);
    1.0 + SMALL_I0.iter().rev().fold(0.0, |sum, term| (sum + term) * t)
}

/// Times e^−x.
#[cfg(test)]
fn i0_large(x: f64) -> f64 {
    let t = SMALL / x;
    LARGE_I0.iter().rev().fold(0.0, |sum, term| sum * t + term) / x.sqrt()
}

/// Around the fibre: a logistic distribution cut to one turn (Chiang et al. 2016, *A practical and controllable hair and
/// fur model for production path tracing*).
#[derive(Debug, Clone, Copy)]
pub(super) struct Azimuthal {
    inverse: f64,
    scale: f64,
    /// The distribution's share below −π.
    below: f64,
    /// Its share within one turn.
    inside: f64,
    /// 1/(s · share).
    normalization: f64,
}

impl Azimuthal {
    /// `scale`: the logistic's s, rad.
    pub(super) fn new(scale: f64) -> Self {
        let below = 1.0 / (1.0 + exp(PI / scale));
        let inside = 1.0 - 2.0 * below;
        Self { inverse: 1.0 / scale, scale, below, inside, normalization: 1.0 / (scale * inside) }
    }

    /// One over the logistic's s, 1/rad.
    pub(super) fn inverse(&self) -> f64 {
        self.inverse
    }

    /// One over s and the share within one turn, 1/rad.
    pub(super) fn normalization(&self) -> f64 {
        self.normalization
    }

    /// 1/rad at an azimuth from the lobe's middle; both −π … π before they were subtracted.
    #[cfg(test)]
    pub(super) fn density(&self, difference: f64) -> f64 {
        let wrapped = wrap(difference).abs();
        let e = exp(-wrapped * self.inverse);
        self.normalization * e / ((1.0 + e) * (1.0 + e))
    }

    /// An azimuth from the lobe's middle, from a uniform number.
    #[inline(always)]
    pub(super) fn sample(&self, u: f64) -> f64 {
        let share = self.below + u * self.inside;
        (self.scale * ln(share / (1.0 - share))).clamp(-PI, PI)
    }
}

/// An angle between −2π and 2π, turned to −π … π.
#[inline(always)]
pub(super) fn wrap(angle: f64) -> f64 {
    if angle > PI {
        angle - TAU
    } else if angle < -PI {
        angle + TAU
    } else {
        angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against ∫ e^(x (cos t − 1)) dt/π by the midpoint rule, which is exact to rounding for periodic functions.
    #[test]
    fn bessel_function_is_that_of_its_integral() {
        for x in [0.0, 0.5, 2.0, 3.74, 3.76, 6.0, 20.0, 300.0, 5000.0] {
            let count = 4000;
            let integral: f64 = (0..count)
                .map(|i| (x * ((PI * (f64::from(i) + 0.5) / f64::from(count)).cos() - 1.0)).exp())
                .sum::<f64>()
                / f64::from(count);
            let ours = if x < SMALL { i0_small(x) * (-x).exp() } else { i0_large(x) };
            assert!((ours / integral - 1.0).abs() < 6e-7, "{x}: {ours} {integral}");
        }
    }

    /// Simpson's rule in sinθ, with steps that follow the lobe's width.
    #[test]
    fn longitudinal_lobes_are_normalized_for_every_variance_and_inclination() {
        for variance in [1e-5, 2e-4, 0.01, 0.0999, 0.1, 0.5, 5.0, 27.0] {
            let lobe = Longitudinal::new(variance);
            for inclination in [-1.57, -1.2, -0.3, 0.0, 0.7, 1.5, PI / 2.0] {
                let (sin, cos) = f64::sin_cos(inclination);
                let steps = 40_000;
                let mut sum = 0.0;
                for i in 0..=steps {
                    let theta = PI * (f64::from(i) / f64::from(steps) - 0.5);
                    let weight = if i == 0 || i == steps { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
                    sum += weight * lobe.density([sin, cos], theta.sin(), theta.cos().max(0.0)) * theta.cos();
                }
                let total = sum * PI / f64::from(3 * steps);
                assert!((total - 1.0).abs() < 6e-7, "v {variance}, θ {inclination}: {total}");
            }
        }
    }

    #[test]
    fn azimuthal_lobes_are_normalized_and_sampled() {
        for scale in [0.003, 0.05, 0.3, 1.0, 4.0] {
            let lobe = Azimuthal::new(scale);
            let steps = 200_000;
            let step = TAU / f64::from(steps);
            let total: f64 = (0..steps).map(|i| step * lobe.density(step * (f64::from(i) + 0.5) - PI)).sum();
            assert!((total - 1.0).abs() < 1e-6, "{scale}: {total}");
            // The share below a sample is the number that it was made of.
            for u in [0.0, 0.1, 0.5, 0.93, 1.0] {
                let end = lobe.sample(u);
                let step = (end + PI) / f64::from(steps);
                let below: f64 =
                    (0..steps).map(|i| step * lobe.density(step * (f64::from(i) + 0.5) - PI)).sum();
                assert!((below - u).abs() < 1e-4, "{scale}: {below} {u}");
            }
        }
    }
}
