//! Fields on azimuths from their Fourier coefficients.

use num_complex::Complex;

use super::cone::Cone;
use super::scalar::Scalar;
use crate::math::fft::{Plans, Transform};

/// Azimuths (n + ½)·π/`azimuths` − π/2 + `shift` for n = −`margin` … `azimuths` + `margin` − 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Azimuths of the upper half.
    pub azimuths: usize,
    /// How many more lie beyond either horizon.
    pub margin: usize,
    /// By how much all are shifted, rad.
    pub shift: f64,
}

impl Grid {
    /// All azimuths, margins included.
    #[must_use]
    pub fn points(&self) -> usize {
        self.azimuths + 2 * self.margin
    }
}

/// Evaluates Fourier coefficients on a grid.
pub(super) struct Synthesis<T: Scalar> {
    transform: Transform<T>,
    grid: Grid,
    /// By which each order is turned to the grid's first azimuth, from 0 on.
    turns: Vec<Complex<T>>,
}

impl<T: Scalar> Synthesis<T> {
    /// A grid tells all orders of the cone apart (its azimuths are [refined](Cone::refinement)).
    pub(super) fn new(plans: &mut Plans<T>, cone: &Cone, grid: Grid) -> Self {
        let azimuths = grid.azimuths;
        let start = 0.5 * std::f64::consts::PI / azimuths as f64 - std::f64::consts::FRAC_PI_2 + grid.shift;
        let turn = Complex::from_polar(1.0, start);
        let mut phase = Complex::new(1.0, 0.0);
        let turns = (0..cone.angles / 2).map(|order| {
            // A rotation that is renewed often enough to stay exact to rounding.
            if order % 64 == 0 {
                phase = Complex::from_polar(1.0, start * order as f64);
            }
            let now = Complex { re: T::of(phase.re), im: T::of(phase.im) };
            phase *= turn;
            now
        });
        let turns = turns.collect();
        debug_assert!(cone.angles <= 2 * azimuths, "{} orders on {azimuths} azimuths", cone.angles);
        Self { transform: plans.inverse(2 * azimuths), grid, turns }
    }

    /// Values on the grid; `circle` and `scratch` are scratch.
    pub(super) fn evaluate(
        &self,
        coefficients: &[Complex<T>],
        circle: &mut Vec<Complex<T>>,
        scratch: &mut Vec<Complex<T>>,
        out: &mut [Complex<T>],
    ) {
        let Grid { azimuths, margin, .. } = self.grid;
        let zero = Complex { re: T::of(0.0), im: T::of(0.0) };
        circle.clear();
        circle.resize(2 * azimuths, zero);
        for ((bin, value), turn) in circle.iter_mut().zip(coefficients).zip(&self.turns) {
            *bin = *value * *turn;
        }
        let backward = circle.iter_mut().rev().zip(coefficients.iter().rev());
        for ((bin, value), turn) in backward.zip(self.turns.iter().skip(1)) {
            *bin = *value * Complex { re: turn.re, im: -turn.im };
        }
        scratch.resize(self.transform.scratch_len(), zero);
        self.transform.process(circle, scratch);
        let (before, rest) = out.split_at_mut(margin);
        before.copy_from_slice(&circle[circle.len() - margin..]);
        rest.copy_from_slice(&circle[..rest.len()]);
    }
}
