//! The two factors of the lobe: across the barbule the fitted shape, along it the spread.
//!
//! f̂ (z·ω_o) = P(φ_o) · E/Q(θ_i) with P = Σ ρ_k shape_k(φ_o)/area_k and E = exp(−t²/σ²), t = sin((θ_i + θ_o)/2), which
//! is h_y of a half vector in the barbule's long plane. Since Q = ∫ E cosθ_o dθ_o, the far field that is radiated per
//! dφ_o, ∫ f̂ (z·ω_o) cosθ_o dθ_o, is P at every azimuth and for every σ.

use std::f64::consts::{FRAC_PI_2, PI};

use super::arrays::{Arrays, TableArray};
use super::material::check_sigma;
use crate::math::quadrature::gauss_legendre;
use crate::scattering::lobe::{FitKind, Lobe};
use crate::{Error, Result};

/// Whether a lobe is one of the mean, or that of the steady part, whose wings are narrower.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Mean,
    Steady,
}

/// Integrals of lobes over φ_o.
#[derive(Debug, Clone)]
pub(super) struct Areas {
    kind: FitKind,
    /// Nodes and weights on \[0, 1\], crowded towards 1.
    rule: Vec<(f64, f64)>,
}

impl Areas {
    pub(super) fn new(kind: FitKind) -> Self {
        let crowded = |(u, w): (f64, f64)| (1.0 - (1.0 - u).powi(4), 4.0 * w * (1.0 - u).powi(3));
        Self { kind, rule: gauss_legendre(32).into_iter().map(crowded).collect() }
    }

    /// ∫ shape dφ_o above the horizon, for ω_i with this cosθ_i; relative accuracy 1e-7.
    ///
    /// With h = sin((φ_o + φ_eff)/2) = a s/√(1−s²), a² = m²/(1−m²), D₁ dh = a/(π m²) √(1−s²) ds is flat.
    pub(super) fn area(&self, part: Part, lobe: Lobe, cos_theta: f64) -> f64 {
        let m2 = lobe.m * lobe.m;
        let a = (m2 / (1.0 - m2).max(1e-12)).sqrt();
        let reach = |phi_o: f64| {
            let h = libm::sin(0.5 * (phi_o + lobe.phi));
            h / (a * a + h * h).sqrt()
        };
        let (first, last) = (reach(-FRAC_PI_2), reach(FRAC_PI_2));
        let middle = 0.0_f64.clamp(first, last);
        let (sin_eff, cos_eff) = libm::sincos(lobe.phi);
        let mut sum = 0.0;
        for end in [first, last] {
            let width = end - middle;
            for &(u, w) in &self.rule {
                let s = middle + width * u;
                let rest = (1.0 - s * s).max(1e-300);
                let h = a * s / rest.sqrt();
                let cos_h = (1.0 - h * h).max(1e-300).sqrt();
                // φ_o = 2β − φ_eff with h = sin β.
                let cos_out = (1.0 - 2.0 * h * h) * cos_eff + 2.0 * h * cos_h * sin_eff;
                let z = (cos_theta * cos_out).max(0.0);
                let g = 2.0 * z / (z + (z * z + m2 * (1.0 - z * z)).sqrt()).max(f64::MIN_POSITIVE);
                let cosine = match self.kind {
                    FitKind::Marginal => cos_h * cos_eff + h * sin_eff,
                    FitKind::Cone => 1.0,
                };
                let narrower = if part == Part::Steady { rest * rest } else { 1.0 };
                sum += w * width.abs() * rest.sqrt() * g * cosine * narrower / cos_h;
            }
        }
        2.0 * a / (PI * m2) * sum
    }
}

/// The longitudinal spread of one σ.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Longitudinal {
    pub(super) sigma: f64,
    /// 1/Q at evenly spaced √cosθ_i.
    inverse_q: Vec<f64>,
}

/// Intervals of the table of 1/Q: linear interpolation is right to 1e-6 at σ = 0.04, to 1e-5 at the smallest.
const INTERVALS: usize = 4096;

/// exp(−this) is nothing.
pub(super) const END: f64 = 45.0;

impl Longitudinal {
    pub(super) fn new(sigma: f64) -> Self {
        let rule = gauss_legendre(32);
        let inverse_q = (0..=INTERVALS)
            .map(|k| {
                let cos_theta = (k as f64 / INTERVALS as f64).powi(2);
                1.0 / spread_integral(&rule, sigma, libm::acos(cos_theta))
            })
            .collect();
        Self { sigma, inverse_q }
    }

    pub(super) fn array(&self) -> TableArray<'_> {
        TableArray::new("inverse_q", &[INTERVALS + 1], &self.inverse_q)
    }

    pub(super) fn from_arrays(from: Arrays<'_>, sigma: f64) -> Result<Self> {
        let inverse_q = from.get("inverse_q", &[INTERVALS + 1], &[[1e-3, 1e9]])?.to_vec();
        Ok(Self { sigma, inverse_q })
    }

    /// 1/Q at this cosθ_i.
    #[inline]
    pub(super) fn inverse_q(&self, cos_theta: f64) -> f64 {
        let position = cos_theta.clamp(0.0, 1.0).sqrt() * INTERVALS as f64;
        let index = (position as usize).min(INTERVALS - 1);
        let t = position - index as f64;
        self.inverse_q[index] * (1.0 - t) + self.inverse_q[index + 1] * t
    }

    /// E/Q for the y of ω_i and of ω_o and the cosines of θ_i and θ_o.
    #[inline]
    pub(super) fn value(&self, [y_i, cos_i]: [f64; 2], [y_o, cos_o]: [f64; 2]) -> f64 {
        let t2 = half_sine_squared([y_i, cos_i], [y_o, cos_o]);
        (-t2 / (self.sigma * self.sigma)).exp() * self.inverse_q(cos_i)
    }
}

/// t² = sin²((θ_i + θ_o)/2) from sines and cosines, without cancellation.
#[inline]
pub(super) fn half_sine_squared([y_i, cos_i]: [f64; 2], [y_o, cos_o]: [f64; 2]) -> f64 {
    let sine = y_i * cos_o + y_o * cos_i;
    let cosine = cos_i * cos_o - y_i * y_o;
    // For directions that run together, sinδ is small where t is 1.
    if cosine > 0.0 { sine * sine / (2.0 * (1.0 + cosine)) } else { 0.5 * (1.0 - cosine) }
}

/// Q = ∫ exp(−sin²((θ_i + θ_o)/2)/σ²) cosθ_o dθ_o.
fn spread_integral(rule: &[(f64, f64)], sigma: f64, theta_i: f64) -> f64 {
    let farthest = 2.0 * libm::asin((END.sqrt() * sigma).min(1.0));
    let side = |end: f64| -> f64 {
        let width = end.abs().min(farthest) * end.signum();
        let term = |&(u, w): &(f64, f64)| {
            let delta = width * u;
            let t = libm::sin(0.5 * delta) / sigma;
            w * libm::exp(-t * t) * libm::cos(delta - theta_i)
        };
        width.abs() * rule.iter().map(term).sum::<f64>()
    };
    side(FRAC_PI_2 + theta_i) + side(theta_i - FRAC_PI_2)
}

/// I = ∫ D G (z·ω_o) dω_o / (4 (z·ω_eff)(z·ω_o)) of a narrow spread, with which F_eff = ρ/I (S.11): in the leading order
/// in σ, σ√π G₁(ω_eff) area/(2 cosφ_eff).
///
/// # Errors
/// A lobe below the horizon, θ_i beyond a right angle, or σ out of range.
pub fn lobe_integral(lobe: Lobe, theta_i: f64, sigma: f64) -> Result<f64> {
    check_sigma(sigma)?;
    let (cos_theta, cos_phi) = (libm::cos(theta_i), libm::cos(lobe.phi));
    if !(lobe.phi.abs() < FRAC_PI_2 && cos_theta > 0.0 && lobe.m > 0.0 && lobe.m <= 1.0) {
        return Err(Error::input(format!(
            "a lobe of m = {} and φ_eff = {} rad at θ_i = {theta_i} rad is none; m is in (0, 1], angles below a right one",
            lobe.m, lobe.phi
        )));
    }
    let z = cos_theta * cos_phi;
    let g = 2.0 * z / (z + (z * z + lobe.m * lobe.m * (1.0 - z * z)).sqrt());
    let area = Areas::new(FitKind::Marginal).area(Part::Mean, lobe, cos_theta);
    Ok(sigma * PI.sqrt() * g * area / (2.0 * cos_phi))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_are_plain_sums_of_the_shape() {
        for kind in [FitKind::Marginal, FitKind::Cone] {
            let areas = Areas::new(kind);
            for (m, phi, theta) in
                [(0.01, 0.3, 0.2), (0.1, -1.2, 1.3), (0.5, 1.5, 0.0), (1.0, 0.1, 0.7), (0.07, 1.52, 0.3)]
            {
                let lobe = Lobe { m, phi };
                let count = 200_000;
                let step = PI / f64::from(count);
                let azimuth = |k: i32| (f64::from(k) + 0.5) * step - FRAC_PI_2;
                let plain: f64 = (0..count).map(|k| lobe.shape(kind, theta, azimuth(k))).sum::<f64>() * step;
                let narrow = |k: i32| {
                    let h = libm::sin(0.5 * (azimuth(k) + phi));
                    let q = m * m + (1.0 - m * m) * h * h;
                    lobe.shape(kind, theta, azimuth(k)) * (m * m / q).powi(2)
                };
                let steady: f64 = (0..count).map(narrow).sum::<f64>() * step;
                for (part, plain) in [(Part::Mean, plain), (Part::Steady, steady)] {
                    let fast = areas.area(part, lobe, libm::cos(theta));
                    assert!((fast / plain - 1.0).abs() < 1e-6, "{kind:?} {part:?} {lobe:?}: {fast} {plain}");
                }
            }
        }
    }

    #[test]
    fn the_spread_integrates_to_one() {
        for sigma in [0.01, 0.04, 0.25] {
            let longitudinal = Longitudinal::new(sigma);
            for theta_i in [0.0, 0.5, -1.0, 1.4, 1.55, 1.5705] {
                let count = 100_000;
                let step = PI / f64::from(count);
                let incident = [f64::sin(theta_i), f64::cos(theta_i)];
                let sum: f64 = (0..count)
                    .map(|k| {
                        let theta_o = (f64::from(k) + 0.5) * step - FRAC_PI_2;
                        longitudinal.value(incident, [theta_o.sin(), theta_o.cos()]) * theta_o.cos()
                    })
                    .sum();
                assert!((sum * step - 1.0).abs() < 4e-6, "{sigma} {theta_i}: {}", sum * step);
            }
        }
    }

    #[test]
    fn a_narrow_lobe_has_the_leading_term() {
        let value = lobe_integral(Lobe { m: 0.001, phi: 0.0 }, 0.0, 0.01).unwrap();
        assert!((value / (0.01 * PI.sqrt() / 0.002) - 1.0).abs() < 2e-3, "{value}");
        assert!(lobe_integral(Lobe { m: 0.1, phi: 1.6 }, 0.0, 0.04).is_err());
        assert!(lobe_integral(Lobe { m: 0.1, phi: 0.0 }, 0.0, 0.5).is_err());
    }
}
