//! Sampling of a lobe's half vectors.
//!
//! h_y is normal with standard deviation σ/√2, h_x follows 1/(a² + h_x²)², a = m/√(1−m²), a Student t with three
//! degrees of freedom; both are truncated to h_x² + h_y² < 1 and the truncations are in the densities. ω_o is ω_eff
//! reflected about h.

use glam::DVec3;
use std::f64::consts::PI;

use crate::math::normal;

/// From this a on, h_x is uniform within a relative 2e-6.
const UNIFORM: f64 = 1000.0;

/// Intervals of the tabulated inverse of h_x's distribution.
const INTERVALS: usize = 64;

/// What all half vectors of one σ share.
#[derive(Debug, Clone)]
pub(super) struct HalfVectors {
    sigma: f64,
    /// Share of the normal distribution of h_y inside ±1.
    inside: f64,
    /// δ and dδ/ds at evenly spaced s; see [`HalfVectors::inverse`].
    nodes: Vec<[f64; 2]>,
}

/// One lobe at one wavelength and incident direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct SampledLobe {
    pub(super) m: f64,
    pub(super) incident: DVec3,
}

impl SampledLobe {
    /// ω_o, which may lie below the horizon.
    pub(super) fn sample(&self, shared: &HalfVectors, u: [f64; 2]) -> DVec3 {
        let u_y = 0.5 + (u[0] - 0.5) * shared.inside;
        let hy = shared.sigma
            * std::f64::consts::FRAC_1_SQRT_2
            * normal::quantile(u_y.clamp(1e-300, 1.0 - f64::EPSILON / 2.0));
        let hy = hy.clamp(-1.0 + 1e-12, 1.0 - 1e-12);
        let end = (1.0 - hy * hy).sqrt();
        let a = self.m / (1.0 - self.m * self.m).max(1e-30).sqrt();
        let hx = if a > UNIFORM {
            (2.0 * u[1] - 1.0) * end
        } else {
            let share = (2.0 * u[1] - 1.0) * half_distribution(end / a);
            (a * shared.inverse(share)).clamp(-end, end)
        };
        let h = DVec3::new(hx, hy, (1.0 - hx * hx - hy * hy).max(0.0).sqrt());
        (2.0 * self.incident.dot(h) * h - self.incident).normalize()
    }
}

impl HalfVectors {
    pub(super) fn new(sigma: f64) -> Self {
        let nodes = (0..=INTERVALS)
            .map(|k| {
                let s = LAST * k as f64 / INTERVALS as f64;
                let delta = solve_kepler(s * s * s / 6.0);
                // dz/ds = s²/2, dz/dδ = 1 − cosδ; both vanish at 0, where the ratio is 1.
                let slope = if k == 0 { 1.0 } else { 0.5 * s * s / (1.0 - libm::cos(delta)) };
                [delta, slope]
            })
            .collect();
        Self { sigma, inside: libm::erf(1.0 / sigma), nodes }
    }

    /// The t of a value of [`half_distribution`] in (−½, ½).
    ///
    /// With t = cot(δ/2) the equation becomes Kepler's, δ − sinδ = z = π − 2π|v|. δ is smooth in s = ∛(6z): cubic
    /// interpolation is right to 1e-8 and one step of Newton's method to rounding.
    fn inverse(&self, v: f64) -> f64 {
        let z = (PI - 2.0 * PI * v.abs()).max(0.0);
        let position = (6.0 * z).cbrt() * (INTERVALS as f64 / LAST);
        let index = (position as usize).min(INTERVALS - 1);
        let (t, h) = (position - index as f64, LAST / INTERVALS as f64);
        let ([low, low_slope], [high, high_slope]) = (self.nodes[index], self.nodes[index + 1]);
        let u = 1.0 - t;
        let delta = low * u * u * (1.0 + 2.0 * t)
            + high * t * t * (3.0 - 2.0 * t)
            + h * t * u * (low_slope * u - high_slope * t);
        let (mut sin, mut cos) = (0.5 * delta).sin_cos();
        if delta > 1e-3 {
            // Half the step, by which sine and cosine are turned.
            let half = 0.25 * (delta - 2.0 * sin * cos - z) / (sin * sin);
            (sin, cos) = (sin - half * cos, cos + half * sin);
        }
        (cos / sin.max(1e-300)).copysign(v)
    }
}

/// Largest s: z = π.
const LAST: f64 = 2.661_340_078_986_675;

/// ∫₀^t 2/(π (1+s²)²) ds, between 0 and ½ for positive t.
pub(super) fn half_distribution(t: f64) -> f64 {
    if t > 50.0 {
        // Two terms of the tail: relative error t⁻⁷.
        let inverse = 1.0 / (t * t);
        return 0.5 - inverse / (t * PI) * (2.0 / 3.0 - 0.8 * inverse);
    }
    (t / (1.0 + t * t) + libm::atan(t)) / PI
}

/// The δ of δ − sinδ = z, 0 ≤ z ≤ π: the series in the cube root starts Newton's method within 2 %.
fn solve_kepler(z: f64) -> f64 {
    let s = libm::cbrt(6.0 * z);
    let s2 = s * s;
    let mut delta = s * (1.0 + s2 * (1.0 / 60.0 + s2 * (1.0 / 1400.0 + s2 / 25_200.0)));
    if delta > 1e-3 {
        for _ in 0..8 {
            let (sin, cos) = libm::sincos(delta);
            let step = (delta - sin - z) / (1.0 - cos);
            delta -= step;
            if step.abs() < 1e-14 {
                break;
            }
        }
    }
    delta
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_inverts() {
        let shared = HalfVectors::new(0.04);
        for k in 0..1000 {
            let v = -0.499_999 + 0.999_998 * f64::from(k) / 999.0;
            let t = shared.inverse(v);
            let back = half_distribution(t.abs()).copysign(v);
            assert!((back - v).abs() < 1e-12, "{v} {t} {back}");
        }
        assert!((half_distribution(50.0 + 1e-9) - half_distribution(50.0 - 1e-9)).abs() < 1e-12);
    }
}
