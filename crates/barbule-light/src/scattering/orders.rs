//! What a photonic crystal reflects of light from any azimuth: Jones matrices of its orders as series.
//!
//! At one wavelength and one θ_i everything is a function of φ_i alone. It has a square root wherever an order begins to
//! propagate, in air or in the crystal's host (Rayleigh's angles), and at grazing incidence; between two such places
//! s₀ < sinφ_i < s₁ it is analytic in ψ with sinφ_i = (s₀ + s₁)/2 − (s₁ − s₀)/2·cosψ, because a root at an end of
//! the interval is a sine or cosine of ψ/2. So Chebyshev series in ψ converge geometrically right up to the ends, and an
//! order that appears there does so without ringing.

use std::f64::consts::PI;

use barbule_base::math::chebyshev;
use num_complex::Complex64;

/// `[out][in]` along e₁, e₂ of the outgoing and of the incident direction.
pub type Jones = [[Complex64; 2]; 2];

/// Real numbers of a Jones matrix: J₁₁, J₁₂, J₂₁, J₂₂, each re, im.
pub const JONES: usize = 8;

/// The reflected orders of one wavelength and one θ_i.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderSeries {
    /// λ/(Δ n cosθ_i): sinφ_m = −sinφ_i + m·step.
    pub step: f64,
    /// Whether only φ_i ≥ 0 is kept because x → −x maps the crystal onto itself.
    pub mirrored: bool,
    /// Without gaps from φ_i = −90° (0° if mirrored) to 90°.
    pub pieces: Vec<Piece>,
}

/// A range of azimuths in which the same orders propagate.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// The neighbouring Rayleigh angles s₀ < s₁, sinφ_i.
    pub between: [f64; 2],
    /// The part of ψ/π that this piece covers.
    pub part: [f64; 2],
    /// The lowest order.
    pub first: i32,
    /// How many orders, consecutive.
    pub orders: usize,
    /// `[term][order][JONES]`
    pub coefficients: Vec<f64>,
}

/// The orders of several wavelengths and θ_i.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderTable {
    /// Vacuum wavelengths, nm.
    pub wavelengths_nm: Vec<f64>,
    /// cosθ_i.
    pub cos_theta: Vec<f64>,
    /// `[wavelength][θ_i]`
    pub series: Vec<OrderSeries>,
}

impl OrderTable {
    /// The orders at a wavelength and a θ_i by their numbers.
    #[must_use]
    pub fn at(&self, wavelength: usize, theta: usize) -> &OrderSeries {
        &self.series[wavelength * self.cos_theta.len() + theta]
    }
}

impl OrderSeries {
    /// Bytes that it takes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.pieces.iter().map(|piece| size_of::<Piece>() + size_of_val(&piece.coefficients[..])).sum()
    }

    /// sinφ of the outgoing direction of order `m` for light from sinφ_i.
    #[must_use]
    pub fn sin_phi_o(&self, m: i32, sin_phi_i: f64) -> f64 {
        f64::from(m) * self.step - sin_phi_i
    }

    /// Appends the orders that propagate at `phi_i` (rad) and their matrices.
    pub fn evaluate(&self, phi_i: f64, out: &mut Vec<(i32, Jones)>) {
        let turned = self.mirrored && phi_i < 0.0;
        let s = if turned { -phi_i.sin() } else { phi_i.sin() };
        let at = self.pieces.partition_point(|piece| piece.end() <= s).min(self.pieces.len() - 1);
        let piece = &self.pieces[at];
        let x = piece.position(s);
        let mut sums = vec![0.0; piece.orders * JONES];
        chebyshev::add_at(&piece.coefficients, x, &mut sums);
        for (m, values) in (piece.first..).zip(sums.as_chunks::<JONES>().0) {
            let [a, b, c, d, e, f, g, h] = *values;
            // In the mirror e₂ points the other way.
            let across = if turned { -1.0 } else { 1.0 };
            let jones = [
                [Complex64::new(a, b), across * Complex64::new(c, d)],
                [across * Complex64::new(e, f), Complex64::new(g, h)],
            ];
            out.push((if turned { -m } else { m }, jones));
        }
    }
}

impl Piece {
    /// sinφ_i at a position x ∈ [−1, 1] of the piece.
    #[must_use]
    pub fn sine(&self, x: f64) -> f64 {
        let [s0, s1] = self.between;
        let [from, to] = self.part;
        let psi = PI * (from + (to - from) * 0.5 * (x + 1.0));
        // cos and sin of half the angle keep the digits near either end.
        let (sin, cos) = (0.5 * psi).sin_cos();
        s0 * cos * cos + s1 * sin * sin
    }

    /// The position x of sinφ_i: the inverse of [`Self::sine`].
    #[must_use]
    pub fn position(&self, sine: f64) -> f64 {
        let [s0, s1] = self.between;
        let [from, to] = self.part;
        let psi = 2.0 * f64::atan2((sine - s0).max(0.0).sqrt(), (s1 - sine).max(0.0).sqrt());
        (2.0 * (psi / PI - from) / (to - from) - 1.0).clamp(-1.0, 1.0)
    }

    /// sinφ_i at the upper end.
    fn end(&self) -> f64 {
        self.sine(1.0)
    }
}
