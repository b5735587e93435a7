//! The integral of the lobe over the outgoing hemisphere.

use glam::DVec3;
use std::f64::consts::PI;

use super::material::check_sigma;
use crate::scattering::directions::omega;
use crate::scattering::lobe::Lobe;
use crate::{Error, Result};

/// I = ∫ D G / (4 (z·ω_eff)(z·ω_o)) · (z·ω_o) dω_o, so that F = ρ/I reflects the fraction ρ (S.11).
///
/// Relative accuracy 1e-5 for cosθ_i ≥ 0.05; leading term σ√π/(2m). Angles in rad.
///
/// # Errors
/// σ out of range, or a lobe or θ_i at or past grazing.
pub fn lobe_integral(lobe: Lobe, theta_i: f64, sigma: f64) -> Result<f64> {
    check_sigma(sigma)?;
    let incident = omega(theta_i, lobe.phi);
    let positive = incident.z > 1e-6 && (0.001..=1.0).contains(&lobe.m);
    if !positive {
        return Err(Error::input("the lobe's direction must lie above the horizon and m between 0.001 and 1"));
    }
    let scaled = Quadrature::new().scaled_integral(lobe.m, incident, sigma);
    let z = incident.z;
    let g = 2.0 * z / (z + (z * z + lobe.m * lobe.m * (1.0 - z * z)).sqrt());
    Ok(sigma * PI.sqrt() / (2.0 * lobe.m) * g * scaled / z)
}

/// Nodes and weights of a rule on \[0, 1\].
type Rule = Vec<(f64, f64)>;

/// Rules that are made once.
#[derive(Debug, Clone)]
pub(super) struct Quadrature {
    /// For each half of the transverse range.
    half: Rule,
    /// For the longitudinal range, where the horizon does not cut it: h_y/σ and weights of exp(−t²)/√π.
    narrow: Rule,
    /// For the longitudinal range where it does.
    wide: Rule,
}

impl Quadrature {
    pub(super) fn new() -> Self {
        Self { half: gauss_legendre(20), narrow: gauss_hermite_8(), wide: gauss_legendre(48) }
    }

    /// J = 2m/(σ√π) ∫∫ D₁ D₂ G₁(ω_o) (ω_eff·h) dβ dh_y over h = (r sinβ, h_y, r cosβ), r² = 1 − h_y², where ω_o is above
    /// the horizon. I = σ√π/(2m) · G₁(ω_eff) J/(z·ω_eff), and so f̂ = ρ m/(2σ√π J) · D₁ D₂ G₁(ω_o)/(z·ω_o): J is all
    /// that a table needs, in (0, 1], and close to z·ω_eff for a narrow lobe.
    pub(super) fn scaled_integral(&self, m: f64, incident: DVec3, sigma: f64) -> f64 {
        let cosine = incident.x.hypot(incident.z);
        if cosine > 6.0 * sigma {
            let sum: f64 =
                self.narrow.iter().map(|&(t, w)| w * self.transverse(m, incident, sigma * t)).sum();
            return sum;
        }
        // Close to θ_i = ±90° the horizon cuts the longitudinal spread: a finite range and many nodes.
        let end = (6.0 * sigma).min(0.999);
        self.wide
            .iter()
            .map(|&(u, w)| {
                let y = end * (2.0 * u - 1.0);
                let t = y / sigma;
                w * 2.0 * end / (sigma * PI.sqrt()) * libm::exp(-t * t) * self.transverse(m, incident, y)
            })
            .sum()
    }

    /// 2m ∫ D₁ G₁ (ω_eff·h) dβ at one h_y.
    fn transverse(&self, m: f64, incident: DVec3, hy: f64) -> f64 {
        let r = (1.0 - hy * hy).sqrt();
        let Some((low, high)) = horizon(incident, r, hy) else { return 0.0 };
        // r sinβ = a tanτ flattens D₁: D₁ dh_x = m²/(π a³ (1−m²)²) cos²τ dτ. For m → 1 the lobe is flat already.
        let flat = m > 0.7;
        let a = m / (1.0 - m * m).sqrt();
        let forward = |beta: f64| if flat { beta } else { libm::atan(r * libm::sin(beta) / a) };
        let (first, last) = (forward(low), forward(high));
        let middle = 0.0_f64.clamp(first, last);
        let mut sum = 0.0;
        for (start, end) in [(middle, first), (middle, last)] {
            let width = end - start;
            if width == 0.0 {
                continue;
            }
            for &(u, w) in &self.half {
                // Nodes crowd at the horizon, where G₁ bends within an angle of order m.
                let place = start + width * u * (2.0 - u);
                let weight = w * 2.0 * (1.0 - u) * width.abs();
                let (sin, cos, density) = if flat {
                    let (sin, cos) = libm::sincos(place);
                    let q = m * m + (1.0 - m * m) * (r * sin) * (r * sin);
                    (sin, cos, m * m / (PI * q * q))
                } else {
                    let tan = libm::tan(place);
                    let sin = (a * tan / r).clamp(-1.0, 1.0);
                    let cos = (1.0 - sin * sin).max(1e-30).sqrt();
                    let q = 1.0 + tan * tan;
                    // D₁ dβ = D₁ a sec²τ / (r cosβ) dτ, and (1−m²)² a⁴ = m⁴.
                    (sin, cos, a / (PI * m * m * q * r * cos))
                };
                let h = DVec3::new(r * sin, hy, r * cos);
                let aligned = incident.dot(h);
                let z = (2.0 * aligned * h.z - incident.z).max(0.0);
                let g = 2.0 * z / (z + (z * z + m * m * (1.0 - z * z)).sqrt());
                sum += weight * density * g * aligned;
            }
        }
        2.0 * m * sum
    }
}

/// Range of β in which reflection about h leaves ω_o above the horizon: where
/// cosθ r² cos(2β − φ) + 2 r sinθ h_y cosβ − cosθ (1−r²) cosφ > 0.
fn horizon(incident: DVec3, r: f64, hy: f64) -> Option<(f64, f64)> {
    let phi = libm::atan2(incident.x, incident.z);
    let height = |beta: f64| {
        let (sin, cos) = libm::sincos(beta);
        let aligned = r * (incident.x * sin + incident.z * cos) + incident.y * hy;
        2.0 * aligned * r * cos - incident.z
    };
    // For h_y = 0 the range is φ/2 ± 45°; at β = ±90° the reflected direction is always below the horizon.
    let top = 0.5 * phi;
    let edge = |side: f64| {
        let start = (top + side * 0.25 * PI).clamp(-0.4999 * PI, 0.4999 * PI);
        find_root(&height, top, side * 0.5 * PI, start)
    };
    (height(top) > 0.0).then(|| (edge(-1.0), edge(1.0)))
}

/// The root between `inside` (positive) and `outside` (negative or zero): Newton with differences inside a bracket.
fn find_root(height: &impl Fn(f64) -> f64, inside: f64, outside: f64, start: f64) -> f64 {
    let (mut positive, mut negative, mut at) = (inside, outside, start);
    let (mut before, mut value_before) = (inside, height(inside));
    for _ in 0..60 {
        let value = height(at);
        if value > 0.0 {
            positive = at;
        } else {
            negative = at;
        }
        if value.abs() < 1e-14 || (positive - negative).abs() < 1e-13 {
            break;
        }
        let slope = (value - value_before) / (at - before);
        (before, value_before) = (at, value);
        let next = at - value / slope;
        let (low, high) = if positive < negative { (positive, negative) } else { (negative, positive) };
        at = if next > low && next < high { next } else { 0.5 * (low + high) };
        if at == before {
            break;
        }
    }
    at
}

/// Gauss–Legendre nodes and weights on \[0, 1\], by Newton's method on the recurrence.
fn gauss_legendre(count: usize) -> Rule {
    (0..count)
        .map(|k| {
            let mut x = libm::cos(PI * (k as f64 + 0.75) / (count as f64 + 0.5));
            let mut slope = 1.0;
            for _ in 0..100 {
                let (mut p, mut before) = (1.0, 0.0);
                for j in 0..count {
                    let j = j as f64;
                    (p, before) = (((2.0 * j + 1.0) * x * p - j * before) / (j + 1.0), p);
                }
                slope = count as f64 * (x * p - before) / (x * x - 1.0);
                let step = p / slope;
                x -= step;
                if step.abs() < 1e-15 {
                    break;
                }
            }
            (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// Eight Gauss–Hermite nodes with weights divided by √π (Abramowitz & Stegun, table 25.10).
fn gauss_hermite_8() -> Rule {
    let half: [(f64, f64); 4] = [
        (0.381_186_990_207_322_1, 6.611_470_125_582_413e-1),
        (1.157_193_712_446_780_2, 2.078_023_258_148_919e-1),
        (1.981_656_756_695_843, 1.707_798_300_741_347_5e-2),
        (2.930_637_420_257_244, 1.996_040_722_113_676e-4),
    ];
    half.iter().flat_map(|&(t, w)| [(t, w / PI.sqrt()), (-t, w / PI.sqrt())]).collect()
}
