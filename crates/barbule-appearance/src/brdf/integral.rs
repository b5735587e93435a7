//! The integral of the lobe over the outgoing hemisphere.

use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

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
    if !(omega(theta_i, lobe.phi).z > 1e-6 && (0.001..=1.0).contains(&lobe.m)) {
        return Err(Error::input(
            "the lobe's direction must lie above the horizon and m between 0.001 and 1",
        ));
    }
    Ok(Fine::new().integral(lobe, theta_i, sigma))
}

/// Nodes and weights of a rule on \[0, 1\].
pub(super) type Rule = Vec<(f64, f64)>;

/// Where the longitudinal spread ends, in units of σ: exp(−20) is left out.
const END: f64 = 4.5;

/// A cut beyond this many σ leaves the Gauss–Hermite rule accurate.
const HERMITE: f64 = 3.4;

/// The rule with a relative accuracy of 1e-5.
pub(super) type Fine = Quadrature<20>;

/// An eighth of the work; relative accuracy 5e-3.
pub(super) type Rough = Quadrature<8>;

/// Rules that are made once, with `HALF` nodes in each half of the transverse range.
#[derive(Debug, Clone)]
pub(super) struct Quadrature<const HALF: usize> {
    /// For each half of the transverse range: s/s_end, crowded where s comes to its end, and the weights.
    half: [[f64; HALF]; 2],
    /// For the longitudinal range where the horizon does not cut it: h_y/σ and weights of exp(−t²)/√π.
    hermite: Rule,
    /// For each of its two parts where the horizon does.
    part: Rule,
    level: Level,
}

impl<const HALF: usize> Quadrature<HALF> {
    pub(super) fn new() -> Self {
        let half = gauss_legendre(HALF);
        Self {
            half: [
                std::array::from_fn(|k| half[k].0 * (2.0 - half[k].0)),
                std::array::from_fn(|k| 2.0 * half[k].1 * (1.0 - half[k].0)),
            ],
            hermite: gauss_hermite_8(),
            part: gauss_legendre(HALF + 4),
            level: Level::new(),
        }
    }

    /// I of a lobe above the horizon.
    pub(super) fn integral(&self, lobe: Lobe, theta_i: f64, sigma: f64) -> f64 {
        let (m, incident) = (lobe.m, omega(theta_i, lobe.phi));
        let z = incident.z;
        let g = 2.0 * z / (z + (z * z + m * m * (1.0 - z * z)).sqrt());
        sigma * PI.sqrt() / (2.0 * m) * g * self.scaled_integral(m, incident, sigma) / z
    }

    /// J = 2m/(σ√π) ∫∫ D₁ D₂ G₁(ω_o) (ω_eff·h) dβ dh_y over h = (r sinβ, h_y, r cosβ), r² = 1 − h_y², where ω_o is above
    /// the horizon. I = σ√π/(2m) · G₁(ω_eff) J/(z·ω_eff), and so f̂ = ρ m/(2σ√π J) · D₁ D₂ G₁(ω_o)/(z·ω_o): J is all
    /// that a table needs, in (0, 1], and close to z·ω_eff for a narrow lobe.
    pub(super) fn scaled_integral(&self, m: f64, incident: DVec3, sigma: f64) -> f64 {
        dispatch!(self.level, simd => self.scaled_integral_wide(simd, m, incident, sigma))
    }

    #[inline(always)]
    fn scaled_integral_wide<S: Simd>(&self, _simd: S, m: f64, incident: DVec3, sigma: f64) -> f64 {
        let transverse = Transverse { rule: &self.half, m, incident };
        // At this h_y the lobe's centre reflects into the horizon.
        let cut = -0.5 * incident.z * incident.y.signum() / incident.y.abs().max(1e-9);
        if cut.abs() > HERMITE * sigma {
            let (mut hy, mut weights) = ([0.0; BATCH], [0.0; BATCH]);
            for (k, &(t, w)) in self.hermite.iter().enumerate() {
                (hy[k], weights[k]) = (sigma * t, w);
            }
            return transverse.batch(&hy, &weights);
        }
        let end = (END * sigma).min(0.99);
        let mut sum = 0.0;
        for width in [-end - cut, end - cut] {
            for nodes in self.part.chunks(BATCH) {
                let (mut hy, mut weights) = ([0.0; BATCH], [0.0; BATCH]);
                for (k, &(u, w)) in nodes.iter().enumerate() {
                    // Nodes crowd at the cut, where narrow lobes bend.
                    hy[k] = cut + width * u * u;
                    let t = hy[k] / sigma;
                    weights[k] = 2.0 * u * w * width.abs() * libm::exp(-t * t);
                }
                sum += transverse.batch(&hy, &weights);
            }
        }
        sum / (sigma * PI.sqrt())
    }
}

/// Longitudinal nodes whose horizons are found side by side.
const BATCH: usize = 8;

/// The integral across the barbule at one h_y.
struct Transverse<'a, const HALF: usize> {
    rule: &'a [[f64; HALF]; 2],
    m: f64,
    incident: DVec3,
}

impl<const HALF: usize> Transverse<'_, HALF> {
    /// The weighted sum over several h_y; weights of 0 take no time.
    #[inline(always)]
    fn batch(&self, hy: &[f64; BATCH], weights: &[f64; BATCH]) -> f64 {
        let (sines, found) = self.horizons(hy);
        let mut sum = 0.0;
        for k in 0..BATCH {
            if weights[k] == 0.0 {
                continue;
            }
            let r = (1.0 - hy[k] * hy[k]).sqrt();
            let ends = if found[k] && found[BATCH + k] {
                Some((sines[k], sines[BATCH + k]))
            } else {
                self.horizon(r, hy[k])
            };
            if let Some((low, high)) = ends {
                sum += weights[k] * self.at(hy[k], low, high);
            }
        }
        sum
    }

    /// Both ends of [`horizon`](Self::horizon) for several h_y, low ends first, and whether they were found.
    #[inline(always)]
    fn horizons(&self, hy: &[f64; BATCH]) -> ([f64; 2 * BATCH], [bool; 2 * BATCH]) {
        let DVec3 { x, y, z } = self.incident;
        let (cos, sin) = half_angle(z / (x * x + z * z).sqrt(), x);
        let (mut s, mut c) = ([0.0; 2 * BATCH], [0.0; 2 * BATCH]);
        let (mut r, mut fixed) = ([0.0; 2 * BATCH], [0.0; 2 * BATCH]);
        for k in 0..2 * BATCH {
            let side = if k < BATCH { -1.0 } else { 1.0 };
            (s[k], c[k]) = ((sin + side * cos) * FRAC_1_SQRT_2, (cos - side * sin) * FRAC_1_SQRT_2);
            let h = hy[k % BATCH];
            (r[k], fixed[k]) = ((1.0 - h * h).sqrt(), y * h);
        }
        // Newton's method, turning sine and cosine by the small angle itself; nearly always enough.
        for _ in 0..4 {
            for k in 0..2 * BATCH {
                let aligned = r[k] * (x * s[k] + z * c[k]) + fixed[k];
                let value = 2.0 * aligned * r[k] * c[k] - z;
                let slope = 2.0 * r[k] * (r[k] * (x * c[k] - z * s[k]) * c[k] - aligned * s[k]);
                let turn = (-value / slope).clamp(-0.5, 0.5);
                let (turned_s, turned_c) = (s[k] + turn * c[k], c[k] - turn * s[k]);
                // One step of Newton's method towards 1/length; the next turns are small and their steps exact.
                let scale = 1.5 - 0.5 * (turned_s * turned_s + turned_c * turned_c);
                (s[k], c[k]) = (turned_s * scale, turned_c * scale);
            }
        }
        let mut found = [false; 2 * BATCH];
        for k in 0..2 * BATCH {
            let side = if k < BATCH { -1.0 } else { 1.0 };
            let value = 2.0 * (r[k] * (x * s[k] + z * c[k]) + fixed[k]) * r[k] * c[k] - z;
            let middle = 2.0 * (r[k] * (x * sin + z * cos) + fixed[k]) * r[k] * cos - z;
            let length = s[k] * s[k] + c[k] * c[k];
            found[k] = (value.abs() < 1e-6)
                & ((length - 1.0).abs() < 1e-6)
                & (middle > 0.0)
                & (c[k] > 0.0)
                & (side * (s[k] * cos - c[k] * sin) > 0.0);
        }
        (s, found)
    }

    /// 2m ∫ D₁ G₁ (ω_eff·h) dβ between these sinβ.
    #[inline(always)]
    fn at(&self, hy: f64, low: f64, high: f64) -> f64 {
        let r2 = 1.0 - hy * hy;
        let r = r2.sqrt();
        let m2 = self.m * self.m;
        // h_x = r sinβ = a s/√(1−s²) flattens D₁: D₁ dh_x = a/(π m²) √(1−s²) ds. a grows without bound as m → 1, where
        // s stays small.
        let a2 = m2 / (1.0 - m2).max(1e-12);
        let a = a2.sqrt();
        let forward = |sin: f64| r * sin / (a2 + r2 * sin * sin).sqrt();
        let (first, last) = (forward(low), forward(high));
        let middle = 0.0_f64.clamp(first, last);
        let (x, z) = (self.incident.x, self.incident.z);
        let fixed = self.incident.y * hy;
        let mut sum = 0.0;
        for end in [first, last] {
            let width = end - middle;
            // Terms first, then their sum, so that the terms are computed side by side.
            let mut terms = [0.0; HALF];
            let [places, weights] = self.rule;
            for ((term, u), w) in terms.iter_mut().zip(places).zip(weights) {
                let s = middle + width * u;
                let rest = (1.0 - s * s).max(1e-300);
                // h_x √rest, h_z √rest and ω_eff·h √rest, of which the root is divided out once.
                let hx = a * s;
                let hz = (r2 * rest - hx * hx).max(1e-30).sqrt();
                let root = rest.sqrt();
                let aligned = x * hx + z * hz + fixed * root;
                let out = (2.0 * aligned * hz / rest - z).max(0.0);
                let g = (out * out + m2 * (1.0 - out * out)).sqrt() + out;
                *term = w * root * out * aligned / (g * hz);
            }
            sum += terms.iter().sum::<f64>() * width.abs();
        }
        // 2m · a/(π m²) · the 2 of G₁.
        4.0 * a / (PI * self.m) * sum
    }

    /// sinβ at the ends of the range in which reflection about h leaves ω_o above the horizon, where
    /// cosθ r² cos(2β − φ) + 2 r sinθ h_y cosβ − cosθ (1−r²) cosφ > 0.
    ///
    /// The integrand falls to zero linearly at the ends, so an error of 1e-4 there costs 1e-8. The sure way, for the few
    /// that [`horizons`](Self::horizons) does not find.
    fn horizon(&self, r: f64, hy: f64) -> Option<(f64, f64)> {
        let DVec3 { x, y, z } = self.incident;
        // Height of ω_o and its slope against β.
        let height = |sin: f64, cos: f64| {
            let aligned = r * (x * sin + z * cos) + y * hy;
            let slope = r * (x * cos - z * sin);
            (2.0 * aligned * r * cos - z, 2.0 * r * (slope * cos - aligned * sin))
        };
        // For h_y = 0 the range is φ/2 ± 45°.
        let cosine = x.hypot(z);
        let (cos, sin) = half_angle(z / cosine, x);
        if height(sin, cos).0 <= 0.0 {
            return None;
        }
        let edge = |side: f64| {
            // φ/2 ± 45°, moved outwards to β = ±90° at most, where the reflected direction is always below.
            let (mut s, mut c) = ((sin + side * cos) * FRAC_1_SQRT_2, (cos - side * sin) * FRAC_1_SQRT_2);
            let (mut inside, mut outside) = (0.0, side * (PI / 2.0 - side * sin.atan2(cos)));
            let mut at = side * 0.25 * PI;
            for _ in 0..30 {
                let (value, slope) = height(s, c);
                if value.abs() < 1e-7 {
                    break;
                }
                if value > 0.0 {
                    inside = at
                } else {
                    outside = at
                }
                let next = at - value / slope;
                let bracketed = (next - inside) * (next - outside) < 0.0;
                at = if bracketed { next } else { 0.5 * (inside + outside) };
                let (sin_at, cos_at) = at.sin_cos();
                (s, c) = (sin * cos_at + cos * sin_at, cos * cos_at - sin * sin_at);
            }
            s
        };
        Some((edge(-1.0), edge(1.0)))
    }
}

/// Cosine and sine of half an angle of this cosine and the sign of `sine`.
fn half_angle(cosine: f64, sine: f64) -> (f64, f64) {
    let sin = (0.5 * (1.0 - cosine)).max(0.0).sqrt();
    ((0.5 * (1.0 + cosine)).max(0.0).sqrt(), sin.copysign(sine))
}

/// Gauss–Legendre nodes and weights on \[0, 1\], by Newton's method on the recurrence.
pub(super) fn gauss_legendre(count: usize) -> Rule {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// J by a plain sum over h, no substitution: slow, and only as good as its cells are small.
    fn plain(m: f64, incident: DVec3, sigma: f64) -> f64 {
        let (rows, columns) = (400, 16_000);
        let mut sum = 0.0;
        for i in 0..rows {
            let hy = 5.0 * sigma * (2.0 * (f64::from(i) + 0.5) / f64::from(rows) - 1.0);
            let r2 = 1.0 - hy * hy;
            let mut row = 0.0;
            for k in 0..columns {
                let beta = PI * ((f64::from(k) + 0.5) / f64::from(columns) - 0.5);
                let h = DVec3::new(r2.sqrt() * beta.sin(), hy, r2.sqrt() * beta.cos());
                let out = 2.0 * incident.dot(h) * h - incident;
                if out.z > 0.0 {
                    let q = m * m + (1.0 - m * m) * h.x * h.x;
                    let g = 2.0 / (1.0 + (1.0 + m * m * (1.0 - out.z * out.z) / (out.z * out.z)).sqrt());
                    row += m * m / (PI * q * q) * g * incident.dot(h);
                }
            }
            sum += row * (-(hy / sigma).powi(2)).exp();
        }
        let cell = 10.0 * sigma / f64::from(rows) * PI / f64::from(columns);
        sum * cell * 2.0 * m / (sigma * PI.sqrt())
    }

    #[test]
    fn the_quadrature_agrees_with_a_plain_sum() {
        let quadrature = Fine::new();
        for sigma in [0.04, 0.08] {
            for (m, ct, phi) in [
                (0.05, 0.9, 0.3),
                (0.3, 0.5, -1.0),
                (1.0, 1.0, 0.0),
                (0.9, 0.3, 1.2),
                (0.02, 0.1, 0.5),
                (0.4, 0.05, 0.2),
                (0.1, 0.2, 1.4),
                (0.6, 0.6, 1.5),
            ] {
                let incident = omega(f64::acos(ct), phi);
                let (fast, slow) =
                    (quadrature.scaled_integral(m, incident, sigma), plain(m, incident, sigma));
                let error = (fast / slow - 1.0).abs();
                assert!(error < 3e-5, "{sigma} {m} {ct} {phi}: {fast} {slow} {error:e}");
            }
        }
    }

    #[test]
    fn the_rough_rule_stays_within_its_bound() {
        let (fine, rough) = (Fine::new(), Rough::new());
        let mut worst = 0.0_f64;
        for m in [0.001, 0.01, 0.05, 0.2, 0.6, 1.0] {
            for ct in [0.01, 0.03, 0.1, 0.3, 0.7, 1.0] {
                for phi in [0.0, 0.4, 0.9, 1.3, 1.5, 1.55] {
                    let incident = omega(f64::acos(ct), phi);
                    let [a, b] =
                        [fine.scaled_integral(m, incident, 0.04), rough.scaled_integral(m, incident, 0.04)];
                    worst = worst.max((b / a - 1.0).abs());
                }
            }
        }
        assert!(worst < 6e-3, "{worst:e}");
    }

    #[test]
    fn a_narrow_lobe_has_the_leading_term() {
        let value = lobe_integral(Lobe { m: 0.001, phi: 0.0 }, 0.0, 0.01).unwrap();
        assert!((value / (0.01 * PI.sqrt() / 0.002) - 1.0).abs() < 2e-3, "{value}");
        assert!(lobe_integral(Lobe { m: 0.1, phi: 1.6 }, 0.0, 0.04).is_err());
        assert!(lobe_integral(Lobe { m: 0.1, phi: 0.0 }, 0.0, 0.5).is_err());
    }
}
