//! Green's function of two dimensions and its slope.

use std::f64::consts::{FRAC_1_PI, PI};

use crate::math::bessel::hankel_scaled;
use crate::{Complex64, Result};

/// |κr| up to which the ascending series are summed.
const SERIES_END: f64 = 1.5;

/// Terms of the series: the next one is below 1e-16 at their end.
const TERMS: usize = 12;

/// Pieces of the table over 1/r, and coefficients of each.
const PIECES: usize = 16;
const ORDER: usize = 10;

/// Euler's constant.
const GAMMA: f64 = 0.577_215_664_901_532_9;

/// What the kernels need of G = (j/4) H₀⁽¹⁾(κr) at one distance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Radial {
    /// G.
    pub(super) value: Complex64,
    /// G′/r + 1/(2πr²), 1/µm²: what is left of the slope without its pole.
    pub(super) slope: Complex64,
}

/// G for one transverse wave number: ascending series near its source (DLMF 10.8), where differences of two media must keep
/// their digits, further out an interpolation in 1/r of what is left when wave and decay are split off.
#[derive(Debug, Clone)]
pub(super) struct Green {
    kappa: Complex64,
    kappa_squared: Complex64,
    /// ln(κ/2).
    log_half_kappa: Complex64,
    series_end_um: f64,
    /// `[piece][power]` of G e^{−jκr} √r and G′ e^{−jκr} √r over 1/r.
    table: Vec<[[Complex64; 2]; ORDER]>,
    /// Pieces per 1/µm.
    density_um: f64,
}

impl Green {
    /// For κ (rad/µm), Im κ ≥ 0.
    ///
    /// # Errors
    /// The Hankel functions are out of range.
    pub(super) fn new(kappa: Complex64) -> Result<Self> {
        let series_end_um = SERIES_END / kappa.norm();
        let density_um = PIECES as f64 * series_end_um;
        // Rounding must not lead past the last piece.
        let table = (0..=PIECES).map(|piece| fit(kappa, piece as f64 / density_um, 1.0 / density_um));
        Ok(Self {
            kappa,
            kappa_squared: kappa * kappa,
            log_half_kappa: (0.5 * kappa).ln(),
            series_end_um,
            table: table.collect::<Result<_>>()?,
            density_um,
        })
    }

    pub(super) fn kappa_squared(&self) -> Complex64 {
        self.kappa_squared
    }

    /// At `r_um` > 0.
    pub(super) fn at(&self, r_um: f64) -> Radial {
        if r_um < self.series_end_um { self.near(r_um) } else { self.far(r_um) }
    }

    fn near(&self, r_um: f64) -> Radial {
        let s = -0.25 * r_um * r_um * self.kappa_squared;
        let log = self.log_half_kappa + libm::log(r_um);
        let mut term = Complex64::new(1.0, 0.0);
        let (mut j0, mut y0, mut j1, mut y1) = (term, Complex64::ZERO, term, Complex64::ZERO);
        let mut harmonic = 0.0;
        y1 += 1.0 - 2.0 * GAMMA;
        for k in 1..TERMS {
            let order = k as f64;
            harmonic += 1.0 / order;
            term *= s / (order * order);
            let next = term / (order + 1.0);
            j0 += term;
            y0 += harmonic * term;
            j1 += next;
            y1 += (2.0 * (harmonic - GAMMA) + 1.0 / (order + 1.0)) * next;
        }
        // Y₀ = (2/π)[(ln(z/2) + γ)J₀ − Σ H_k s^k/k!²]; Y₁ + 2/(πz) = (2/π) ln(z/2) J₁ − (z/2π) Σ (ψ(k+1) + ψ(k+2)) …
        let y0 = 2.0 * FRAC_1_PI * ((log + GAMMA) * j0 - y0);
        let first = j1 + Complex64::i() * FRAC_1_PI * (2.0 * log * j1 - y1);
        Radial {
            value: 0.25 * Complex64::i() * (j0 + Complex64::i() * y0),
            slope: -0.125 * Complex64::i() * self.kappa_squared * first,
        }
    }

    fn far(&self, r_um: f64) -> Radial {
        let u = 1.0 / r_um;
        let place = u * self.density_um;
        let piece = place as usize;
        let t = 2.0 * (place - piece as f64) - 1.0;
        let rows = &self.table[piece.min(PIECES)];
        let [mut value, mut slope] = rows[ORDER - 1];
        for [v, s] in rows[..ORDER - 1].iter().rev() {
            value = value * t + v;
            slope = slope * t + s;
        }
        let (sin, cos) = libm::sincos(self.kappa.re * r_um);
        let decay = if self.kappa.im == 0.0 { 1.0 } else { libm::exp(-self.kappa.im * r_um) };
        let wave = Complex64::new(cos, sin) * (decay * u.sqrt());
        Radial { value: value * wave, slope: slope * wave * u + 0.5 * FRAC_1_PI * u * u }
    }
}

/// Powers of t ∈ \[−1, 1\] over one piece, through Chebyshev's nodes.
fn fit(kappa: Complex64, from: f64, width: f64) -> Result<[[Complex64; 2]; ORDER]> {
    let mut chebyshev = [[Complex64::ZERO; 2]; ORDER];
    let nodes = ORDER + 4;
    for node in 0..nodes {
        let angle = PI * (node as f64 + 0.5) / nodes as f64;
        let r_um = 1.0 / (from + width * 0.5 * (1.0 + libm::cos(angle)));
        let [h0, h1] = hankel_scaled(kappa * r_um)?;
        let scale = 0.25 * Complex64::i() * r_um.sqrt();
        for (k, pair) in chebyshev.iter_mut().enumerate() {
            let weight = libm::cos(k as f64 * angle) * if k == 0 { 1.0 } else { 2.0 } / nodes as f64;
            pair[0] += scale * h0 * weight;
            pair[1] -= scale * kappa * h1 * weight;
        }
    }
    Ok(powers(&chebyshev))
}

/// A Chebyshev sum as a sum of powers.
fn powers(chebyshev: &[[Complex64; 2]; ORDER]) -> [[Complex64; 2]; ORDER] {
    let mut sum = [[Complex64::ZERO; 2]; ORDER];
    let (mut before, mut now) = ([0.0; ORDER], [0.0; ORDER]);
    now[0] = 1.0;
    for (k, pair) in chebyshev.iter().enumerate() {
        for (power, factor) in now.iter().enumerate() {
            sum[power][0] += pair[0] * factor;
            sum[power][1] += pair[1] * factor;
        }
        // T₁ = t, T_{k+1} = 2t T_k − T_{k−1}.
        let twice = if k == 0 { 1.0 } else { 2.0 };
        let mut next = [0.0; ORDER];
        for power in 0..ORDER {
            let shifted = if power == 0 { 0.0 } else { now[power - 1] };
            next[power] = twice * shifted - before[power];
        }
        (before, now) = (now, next);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both against the library's Hankel functions, from a thousandth of a wavelength to hundreds.
    #[test]
    fn series_and_table_are_the_hankel_functions() {
        let mut worst: f64 = 0.0;
        for kappa in [
            Complex64::new(9.0, 0.0),
            Complex64::new(25.0, 0.7),
            Complex64::new(3.0, 2.0),
            Complex64::new(0.4, 1e-3),
        ] {
            let green = Green::new(kappa).unwrap();
            for step in 0..2000 {
                let r = 1e-3 * (1e6_f64).powf(f64::from(step) / 2000.0) / kappa.norm();
                let [h0, h1] = hankel_scaled(kappa * r).unwrap();
                let wave = (Complex64::i() * kappa * r).exp();
                let value = 0.25 * Complex64::i() * h0 * wave;
                let slope = -0.25 * Complex64::i() * kappa * h1 * wave / r;
                let got = green.at(r);
                worst = worst.max((got.value - value).norm() / (value.norm() + 1e-300));
                // What the pole's rounding leaves of slopes that have decayed is not looked at.
                let pole = 0.5 * FRAC_1_PI / (r * r);
                worst = worst.max((got.slope - pole - slope).norm() / (slope.norm() + 1e-5 * pole));
            }
        }
        assert!(worst < 1e-10, "{worst:e}");
    }
}
