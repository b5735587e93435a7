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

/// One lobe at one wavelength and incident direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct SampledLobe {
    pub(super) m: f64,
    pub(super) incident: DVec3,
    pub(super) sigma: f64,
}

impl SampledLobe {
    /// ω_o, which may lie below the horizon, and its density per sr.
    pub(super) fn sample(&self, u: [f64; 2]) -> (DVec3, f64) {
        let inside = libm::erf(1.0 / self.sigma);
        let u_y = 0.5 + (u[0] - 0.5) * inside;
        let hy = self.sigma
            * std::f64::consts::FRAC_1_SQRT_2
            * normal::quantile(u_y.clamp(1e-300, 1.0 - f64::EPSILON / 2.0));
        let hy = hy.clamp(-1.0 + 1e-12, 1.0 - 1e-12);
        let end = (1.0 - hy * hy).sqrt();
        let a = self.a();
        let hx = if a > UNIFORM {
            (2.0 * u[1] - 1.0) * end
        } else {
            let share = (2.0 * u[1] - 1.0) * half_distribution(end / a);
            (a * inverse_half_distribution(share)).clamp(-end, end)
        };
        let h = DVec3::new(hx, hy, (1.0 - hx * hx - hy * hy).max(0.0).sqrt());
        let outgoing = (2.0 * self.incident.dot(h) * h - self.incident).normalize();
        (outgoing, self.density(h))
    }

    /// Density of ω_o per sr over the whole sphere (below the horizon too).
    pub(super) fn pdf(&self, outgoing: DVec3) -> f64 {
        let sum = self.incident + outgoing;
        let length = sum.length();
        if length < 1e-9 {
            return 0.0;
        }
        // A half vector below the horizon is one of its mirror image, seen from the other side.
        let h = sum / length;
        self.density(if h.z < 0.0 { -h } else { h })
    }

    fn a(&self) -> f64 {
        self.m / (1.0 - self.m * self.m).max(1e-30).sqrt()
    }

    /// p(h_y) p(h_x | h_y) h_z / (4 |ω_eff·h|).
    fn density(&self, h: DVec3) -> f64 {
        let y = h.y / self.sigma;
        if y * y > 700.0 {
            return 0.0;
        }
        let p_y = (-y * y).exp() / (self.sigma * PI.sqrt() * libm::erf(1.0 / self.sigma));
        let end = (1.0 - h.y * h.y).max(0.0).sqrt();
        let a = self.a();
        let p_x = if a > UNIFORM {
            0.5 / end
        } else {
            let q = 1.0 + (h.x / a) * (h.x / a);
            1.0 / (PI * a * q * q * half_distribution(end / a))
        };
        let aligned = self.incident.dot(h).abs();
        let density = p_y * p_x * h.z / (4.0 * aligned);
        if density.is_finite() { density } else { 0.0 }
    }
}

/// ∫₀^t 2/(π (1+s²)²) ds, between 0 and ½ for positive t.
fn half_distribution(t: f64) -> f64 {
    if t > 50.0 {
        // Two terms of the tail: relative error t⁻⁷.
        let inverse = 1.0 / (t * t);
        return 0.5 - inverse / (t * PI) * (2.0 / 3.0 - 0.8 * inverse);
    }
    (t / (1.0 + t * t) + libm::atan(t)) / PI
}

/// The t of a value of [`half_distribution`] in (−½, ½).
///
/// With t = cot(δ/2) the equation becomes Kepler's, δ − sinδ = π − 2π|v|, whose series in its cube root starts Newton's
/// method within 2 %.
fn inverse_half_distribution(v: f64) -> f64 {
    let z = PI - 2.0 * PI * v.abs();
    let s = (6.0 * z.max(0.0)).cbrt();
    let s2 = s * s;
    let mut delta = s * (1.0 + s2 * (1.0 / 60.0 + s2 * (1.0 / 1400.0 + s2 / 25_200.0)));
    if delta > 1e-3 {
        for _ in 0..8 {
            let (sin, cos) = delta.sin_cos();
            let step = (delta - sin - z) / (1.0 - cos);
            delta -= step;
            if step.abs() < 1e-12 {
                break;
            }
        }
    }
    let (sin, cos) = (0.5 * delta).sin_cos();
    (cos / sin.max(1e-300)).copysign(v)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_inverts() {
        for k in 0..1000 {
            let v = -0.4999 + 0.9998 * f64::from(k) / 999.0;
            let t = inverse_half_distribution(v);
            let back = half_distribution(t.abs()).copysign(v);
            assert!((back - v).abs() < 1e-12, "{v} {t} {back}");
        }
        assert!((half_distribution(50.0 + 1e-9) - half_distribution(50.0 - 1e-9)).abs() < 1e-12);
    }
}
