//! The lobe's factor across the barbule, the fitted shape.
//!
//! f̂ (z·ω_o) = P(φ_o) · E/Q(θ_i) with P = Σ ρ_k shape_k(φ_o)/area_k and the spread E/Q along the barbule (the module
//! `longitudinal`). Since ∫ E/Q cosθ_o dθ_o is 1, the far field that is radiated per dφ_o, ∫ f̂ (z·ω_o) cosθ_o dθ_o, is P at
//! every azimuth and for every spread.

use std::f64::consts::{FRAC_PI_2, PI};

use super::material::check_sigma;
use crate::math::quadrature::gauss_legendre;
use crate::scattering::lobe::{FitKind, Lobe};
use crate::{Error, Result};

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
    pub(super) fn area(&self, lobe: Lobe, cos_theta: f64) -> f64 {
        self.integral(lobe, cos_theta, |_| 1.0)
    }

    /// The same of the shape times a function of φ_o.
    pub(super) fn integral(&self, lobe: Lobe, cos_theta: f64, of: impl Fn(f64) -> f64) -> f64 {
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
                let phi_o = 2.0 * libm::asin(h.clamp(-1.0, 1.0)) - lobe.phi;
                sum += w * width.abs() * rest.sqrt() * g * cosine * of(phi_o) / cos_h;
            }
        }
        2.0 * a / (PI * m2) * sum
    }
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
    let area = Areas::new(FitKind::Marginal).area(lobe, cos_theta);
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
                let fast = areas.area(lobe, libm::cos(theta));
                assert!((fast / plain - 1.0).abs() < 1e-6, "{kind:?} {lobe:?}: {fast} {plain}");
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
