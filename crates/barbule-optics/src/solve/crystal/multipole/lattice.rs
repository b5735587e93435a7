//! Sums of cylindrical waves over the period, with the Bloch phase.
//!
//! σ_q(r) = Σ_s e^{jα₀sΔ} H_q(κ|r − sΔx̂|) e^{jqϑ(r − sΔx̂)}, without s = 0 where r = 0. A rod at r_l with b_p acts on one at
//! r_j with a_n = Σ_p σ_{p−n}(r_j − r_l) b_p (Graf).
//!
//! r = 0: σ_q = lim_{z→0+} of [Σ_m − ∫dm] of the plane-wave form (2/(Δγ_m)) (−j)^q w_m^q e^{jγ_m z}, the integral being the
//! term s = 0. For α < 0, where w^q grows, w^q = w^{−q} + 2j(γ/κ)U_{q−1}(α/κ): the first part converges, and for the
//! polynomial the difference of sum and integral is a Hurwitz zeta function, hence Bernoulli polynomials (Twersky 1961;
//! Linton 2010, SIAM Review 52, section 3). What is left of the first part beyond a window is its integral, which is
//! elementary, with the Euler–Maclaurin corrections written as central differences.
//!
//! r ≠ 0: plane waves where rows are far apart in z; else the nearest rods one by one and the rest, which is regular
//! at the origin, translated from σ_q(0) without these rods.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

use super::orders::Orders;
use crate::Result;
use crate::math::bessel::{Cylinder, power_of_j};

/// Euler–Maclaurin end corrections as differences f(N+i) − f(N−i): 2Σ_i e_i i^{2k−1} = −B_{2k}/(2k), k = 1 … 8.
const END: [f64; 8] = [
    -0.078_362_263_347_846_43,
    0.029_658_915_402_555_077,
    -0.011_001_664_606_348_528,
    0.003_464_763_345_380_610_4,
    -0.000_856_083_761_099_629_7,
    0.000_153_193_640_394_266_08,
    -1.753_039_202_853_559e-5,
    9.595_026_156_320_693e-7,
];

/// Bernoulli numbers B_0, B_1, B_2, B_4, … B_14 as (index, value).
const BERNOULLI: [(usize, f64); 9] = [
    (0, 1.0),
    (1, -0.5),
    (2, 1.0 / 6.0),
    (4, -1.0 / 30.0),
    (6, 1.0 / 42.0),
    (8, -1.0 / 30.0),
    (10, 5.0 / 66.0),
    (12, -691.0 / 2730.0),
    (14, 7.0 / 6.0),
];

/// Bernoulli polynomials over k! up to this degree from their coefficients, beyond from their Fourier series.
const EXPLICIT: usize = 14;

/// Images on each side that a displaced sum takes one by one.
const NEAR: i32 = 3;

/// Orders of the regular rest of a displaced sum.
const REST: usize = 30;

/// Rows further apart than this, in periods, are coupled by plane waves.
const FAR: f64 = 0.7;

/// Rounding in σ_q(0) is about the unit roundoff times |H_q(κΔ)|; past this size the rest is summed directly.
const DIRECT: f64 = 1e16;

/// Half width of the window of orders (without the end differences) that the sums of one wave need.
fn half_window(kappa: Complex64, period: f64) -> i32 {
    18 + (kappa.norm() * period / TAU).ceil() as i32
}

/// Orders that [`LatticeSums`] needs.
pub(super) fn window(kappa: Complex64, alpha0: f64, period: f64) -> (i32, i32) {
    let centre = -(alpha0 * period / TAU).round() as i32;
    let half = half_window(kappa, period) + END.len() as i32;
    (centre - half, centre + half)
}

/// Factorials up to 170!.
fn factorials() -> &'static [f64; 171] {
    static TABLE: std::sync::OnceLock<[f64; 171]> = std::sync::OnceLock::new();
    TABLE.get_or_init(|| {
        let mut table = [1.0; 171];
        for n in 1..171 {
            table[n] = table[n - 1] * n as f64;
        }
        table
    })
}

/// B_k(x)/k! for k = 0 … k_max, 0 ≤ x < 1.
fn bernoulli(x: f64, k_max: usize) -> Vec<f64> {
    let factorial = factorials();
    let mut values: Vec<f64> = (0..=k_max.min(EXPLICIT))
        .map(|k| {
            let terms = BERNOULLI.iter().take_while(|(i, _)| *i <= k);
            terms.map(|(i, b)| b / factorial[*i] * x.powi((k - i) as i32) / factorial[k - i]).sum()
        })
        .collect();
    let waves: [(f64, f64); 12] = std::array::from_fn(|n| (TAU * x * (n + 1) as f64).sin_cos());
    for k in EXPLICIT + 1..=k_max {
        let series = waves.iter().enumerate().map(|(n, (sin, cos))| {
            let quarter = match k % 4 {
                0 => *cos,
                1 => *sin,
                2 => -cos,
                _ => -sin,
            };
            quarter * (TAU * (n + 1) as f64).powi(-(k as i32))
        });
        values.push(-2.0 * series.sum::<f64>());
    }
    values
}

/// Sums of one wave on one period.
#[derive(Debug, Clone)]
pub(super) struct LatticeSums {
    kappa: Complex64,
    alpha0: f64,
    period: f64,
    /// σ_q(0) for q ≥ 0; σ_{−q} = (−1)^q σ_q.
    own: Vec<Complex64>,
}

impl LatticeSums {
    /// σ_q(0), q = 0 … `q_max` ≤ 160. `orders` reach over [`window`] at least.
    pub(super) fn new(kappa: Complex64, alpha0: f64, period: f64, orders: &Orders, q_max: usize) -> Self {
        let shift = alpha0 * period / TAU;
        let last_negative = (-shift).floor() as i32;
        let (first, last) = window(kappa, alpha0, period);
        let ends = [first + END.len() as i32, last - END.len() as i32];
        let mut sums = vec![Complex64::new(0.0, 0.0); q_max + 1];
        for m in first..=last {
            let at = orders.index(m);
            let beyond = (ends[0] - m).max(m - ends[1]);
            let weight = match beyond {
                0 => 0.5,
                1.. => END[beyond as usize - 1],
                _ if beyond >= -(END.len() as i32) => 1.0 - END[(-beyond) as usize - 1],
                _ => 1.0,
            };
            let v = if m <= last_negative { orders.w[at].inv() } else { orders.w[at] };
            let mut term = weight * 2.0 / (period * orders.gamma[at]);
            for sum in &mut sums {
                *sum += term;
                term *= v;
            }
        }
        let (plus, minus) = (orders.w[orders.index(ends[1])], orders.w[orders.index(ends[0])].inv());
        // ∫dα/(πγ) over the window is (ζ₋ − ζ₊)/π, ζ₊ = −j ln w, ζ₋ = π + j ln(−1/w)
        let span = PI + Complex64::i() * ((-minus).ln() + plus.ln());
        sums[0] -= span / PI;
        let (mut power_plus, mut power_minus) = (Complex64::new(1.0, 0.0), Complex64::new(1.0, 0.0));
        for (q, sum) in sums.iter_mut().enumerate().skip(1) {
            power_plus *= plus;
            power_minus *= minus;
            let upward = power_of_j(q);
            let both = upward + upward.conj() - power_plus - power_minus;
            *sum += Complex64::i() * both / (PI * q as f64);
        }
        add_polynomials(&mut sums, kappa * period, -shift - f64::from(last_negative));
        for (q, sum) in sums.iter_mut().enumerate() {
            *sum *= power_of_j(q).conj();
        }
        Self { kappa, alpha0, period, own: sums }
    }

    /// σ_q(0) of either sign of q.
    pub(super) fn own(&self, q: i32) -> Complex64 {
        let value = self.own[q.unsigned_abs() as usize];
        if q < 0 && q % 2 != 0 { -value } else { value }
    }

    /// Highest |q| of [`Self::displaced`] if σ(0) reaches `q_max`.
    pub(super) fn reach(q: usize) -> usize {
        q + REST
    }

    /// σ_q(r) for q = −q_max … q_max at r = (x, z) ≠ 0, µm.
    ///
    /// # Errors
    /// Cylinder functions leave the range of numbers.
    pub(super) fn displaced(&self, orders: &Orders, x: f64, z: f64, q_max: usize) -> Result<Vec<Complex64>> {
        let turns = (x / self.period).round();
        let x = x - turns * self.period;
        let phase = Complex64::cis(self.alpha0 * turns * self.period);
        let mut sums = if z.abs() >= FAR * self.period {
            plane_waves(orders, self.period, x, z, q_max)
        } else {
            self.images(x, z, q_max)?
        };
        for sum in &mut sums {
            *sum *= phase;
        }
        Ok(sums)
    }

    /// Displaced sums from the nearest images and the regular rest: σ_q(r) = Σ_{|s|≤S} + Σ_n ρ_{q−n} J_n(κr) e^{jnϑ}.
    fn images(&self, x: f64, z: f64, q_max: usize) -> Result<Vec<Complex64>> {
        let rest = self.rest(Self::reach(q_max))?;
        let mut sums = vec![Complex64::new(0.0, 0.0); 2 * q_max + 1];
        for s in -NEAR..=NEAR {
            let (dx, phase) =
                (x - f64::from(s) * self.period, Complex64::cis(self.alpha0 * f64::from(s) * self.period));
            let table = Cylinder::new(self.kappa * dx.hypot(z), q_max + 1)?;
            let turn = Complex64::new(dx, z) / dx.hypot(z);
            let mut around = phase;
            for q in 0..=q_max {
                sums[q_max + q] += table.h[q] * around;
                if q > 0 {
                    // H_{−q} = (−1)^q H_q with e^{−jqϑ}
                    let sign = if q % 2 == 0 { 1.0 } else { -1.0 };
                    sums[q_max - q] += sign * table.h[q] * phase * (around / phase).conj();
                }
                around *= turn;
            }
        }
        let radius = x.hypot(z);
        if radius < 1e-9 * self.period {
            return Ok(sums);
        }
        let table = Cylinder::new(self.kappa * radius, REST)?;
        let turn = Complex64::new(x, z) / radius;
        let centre = Self::reach(q_max) as i32;
        let mut around = Complex64::new(1.0, 0.0);
        for n in 0..=REST as i32 {
            let value = table.j[n as usize];
            let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
            for q in -(q_max as i32)..=q_max as i32 {
                let sum = &mut sums[(q + q_max as i32) as usize];
                *sum += rest[(q - n + centre) as usize] * value * around;
                if n > 0 {
                    *sum += rest[(q + n + centre) as usize] * value * sign * around.conj();
                }
            }
            around *= turn;
        }
        Ok(sums)
    }

    /// σ_q(0) without the images |s| ≤ S, q = −q_max … q_max.
    fn rest(&self, q_max: usize) -> Result<Vec<Complex64>> {
        let mut tables = Vec::new();
        for s in 1..=NEAR + 8 {
            tables.push(Cylinder::new(self.kappa * self.period * f64::from(s), q_max + 1)?.h);
        }
        let pair = |q: usize, s: usize| {
            let phase = Complex64::cis(self.alpha0 * self.period * s as f64);
            let sign = if q.is_multiple_of(2) { 1.0 } else { -1.0 };
            tables[s - 1][q] * (sign * phase + phase.conj())
        };
        let mut rest = vec![Complex64::new(0.0, 0.0); 2 * q_max + 1];
        for q in 0..=q_max {
            let near = NEAR as usize;
            let value = if tables[0][q].norm() > DIRECT {
                (near + 1..=tables.len()).map(|s| pair(q, s)).sum::<Complex64>()
            } else {
                self.own[q] - (1..=near).map(|s| pair(q, s)).sum::<Complex64>()
            };
            rest[q_max + q] = value;
            rest[q_max - q] = if q % 2 == 0 { value } else { -value };
        }
        Ok(rest)
    }
}

/// Adds (4j/(κΔ)) Σ reg U_{q−1}(α_m/κ) over α_m ≤ 0, of which the first is −2πx₀/Δ: with
/// U_{q−1}(u) = Σ_i (−1)^i (q−1−i)!/(i! k!) (2u)^k, k = q−1−2i, and Σ_{j≥0} (j + x₀)^k → −B_{k+1}(x₀)/(k+1).
fn add_polynomials(sums: &mut [Complex64], kappa_period: Complex64, x0: f64) {
    let q_max = sums.len() - 1;
    let factorial = factorials();
    let step = -2.0 * TAU / kappa_period;
    let mut scale = Complex64::new(1.0, 0.0);
    let mut powers = Vec::with_capacity(q_max + 1);
    for b in bernoulli(x0, q_max + 1).iter().skip(1) {
        powers.push(scale * *b);
        scale *= step;
    }
    let lead = Complex64::new(0.0, 4.0) / kappa_period;
    for (q, sum) in sums.iter_mut().enumerate().skip(1) {
        let mut series = Complex64::new(0.0, 0.0);
        for i in 0..=(q - 1) / 2 {
            let term = powers[q - 1 - 2 * i] * (factorial[q - 1 - i] / factorial[i]);
            series += if i % 2 == 0 { -term } else { term };
        }
        *sum += lead * series;
    }
}

/// σ_q(r) = Σ_m (2/(Δγ_m)) (−j)^q w_m^{±q} e^{j(α_m x + γ_m|z|)}, sign of z.
fn plane_waves(orders: &Orders, period: f64, x: f64, z: f64, q_max: usize) -> Vec<Complex64> {
    let mut sums = vec![Complex64::new(0.0, 0.0); 2 * q_max + 1];
    for m in 0..orders.len() {
        let start = 2.0 / (period * orders.gamma[m])
            * (Complex64::i() * (orders.alpha[m] * x + orders.gamma[m] * z.abs())).exp();
        let w = if z > 0.0 { orders.w[m] } else { orders.w[m].inv() };
        for (direction, v) in [(1, -Complex64::i() * w), (-1, Complex64::i() / w)] {
            let mut term = start;
            for q in 0..=q_max as i32 {
                if q > 0 || direction > 0 {
                    sums[(q_max as i32 + direction * q) as usize] += term;
                }
                term *= v;
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests;
