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
    angles: usize,
    grid: Grid,
}

impl<T: Scalar> Synthesis<T> {
    pub(super) fn new(plans: &mut Plans<T>, cone: &Cone, grid: Grid) -> Self {
        Self { transform: plans.inverse(2 * grid.azimuths), angles: cone.angles, grid }
    }

    /// Values on the grid; `circle` and `scratch` are scratch.
    pub(super) fn evaluate(
        &self,
        coefficients: &[Complex<T>],
        circle: &mut Vec<Complex<T>>,
        scratch: &mut Vec<Complex<T>>,
        out: &mut [Complex<T>],
    ) {
        let Grid { azimuths, margin, shift } = self.grid;
        let length = 2 * azimuths;
        let zero = Complex { re: T::of(0.0), im: T::of(0.0) };
        circle.clear();
        circle.resize(length, zero);
        let start = 0.5 * std::f64::consts::PI / azimuths as f64 - std::f64::consts::FRAC_PI_2 + shift;
        let half = self.angles / 2;
        let turn = Complex::from_polar(1.0, start);
        let mut phase = Complex::new(1.0, 0.0);
        for order in 0..half {
            // A rotation that is renewed often enough to stay exact to rounding.
            if order % 64 == 0 {
                phase = Complex::from_polar(1.0, start * order as f64);
            }
            let (re, im) = (T::of(phase.re), T::of(phase.im));
            let bin = &mut circle[order % length];
            *bin += coefficients[order] * Complex { re, im };
            if order > 0 {
                let bin = &mut circle[(length - order % length) % length];
                *bin += coefficients[self.angles - order] * Complex { re, im: -im };
            }
            phase *= turn;
        }
        scratch.resize(self.transform.scratch_len(), zero);
        self.transform.process(circle, scratch);
        for (n, value) in out.iter_mut().enumerate() {
            *value = circle[(n + length - margin) % length];
        }
    }
}
