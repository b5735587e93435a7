//! The autocovariance of patterns on the points of S.44 (S.30), by Wiener and Khinchin: the mean of |DFT|² of the
//! patterns, padded so that none of the lags that are kept wraps, is the transform of the sum of the covariances of
//! their real and imaginary parts.

use std::ops::{AddAssign, DivAssign, MulAssign, RemAssign, SubAssign};

use num_complex::Complex;

use crate::math::fft::{Transform, Transformable, fast_length};
use crate::math::simd::Real;
use crate::scattering::statistics::{LAGS, NOISE_POINTS};

/// `f32` or `f64`.
pub(super) trait Number:
    Transformable + Real + Into<f64> + AddAssign + SubAssign + MulAssign + DivAssign + RemAssign
{
}

impl Number for f32 {}
impl Number for f64 {}

/// The transform that all covariances of one precision and one length of patterns share.
pub(super) struct Covariance<T> {
    transform: Transform<T>,
    padded: usize,
}

impl<T: Number> Covariance<T> {
    /// For patterns of so many values.
    pub(super) fn new(values: usize) -> Self {
        let padded = fast_length(values + LAGS);
        Self { transform: T::forward(padded), padded }
    }

    /// A sum over no pattern yet.
    pub(super) fn sum(&self) -> Sum<'_, T> {
        let zero = Complex { re: T::of(0.0), im: T::of(0.0) };
        Sum {
            transform: &self.transform,
            pattern: vec![zero; self.padded],
            scratch: vec![zero; self.transform.scratch_len()],
            power: vec![0.0; self.padded],
            patterns: 0,
        }
    }
}

/// Power spectra of patterns, summed.
pub(super) struct Sum<'a, T> {
    transform: &'a Transform<T>,
    pattern: Vec<Complex<T>>,
    scratch: Vec<Complex<T>>,
    power: Vec<f64>,
    patterns: usize,
}

impl<T: Number> Sum<'_, T> {
    /// Adds a pattern with values on consecutive points, less their mean; it is zero elsewhere.
    pub(super) fn add(&mut self, values: impl Iterator<Item = Complex<T>>) {
        let zero = Complex { re: T::of(0.0), im: T::of(0.0) };
        self.pattern.fill(zero);
        let (mut mean, mut count) = (zero, 0);
        for (place, value) in self.pattern.iter_mut().zip(values) {
            mean += value;
            *place = value;
            count += 1;
        }
        mean /= T::of(count.max(1) as f64);
        for place in &mut self.pattern[..count] {
            *place -= mean;
        }
        self.transform.process(&mut self.pattern, &mut self.scratch);
        for (sum, value) in self.power.iter_mut().zip(&self.pattern) {
            *sum += value.norm_sqr().into();
        }
        self.patterns += 1;
    }

    /// C_m at lags 0 … [`LAGS`] − 1: mean over the patterns and over real and imaginary parts.
    pub(super) fn mean(mut self) -> Vec<T> {
        for (value, sum) in self.pattern.iter_mut().zip(&self.power) {
            *value = Complex { re: T::of(*sum), im: T::of(0.0) };
        }
        // The power spectrum is real, so the forward transform of it is, conjugated, the inverse.
        self.transform.process(&mut self.pattern, &mut self.scratch);
        let terms = 2 * self.pattern.len() * (NOISE_POINTS - 1) * self.patterns;
        let scale = T::of(1.0) / T::of(terms as f64);
        self.pattern[..LAGS].iter().map(|value| value.re * scale).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_complex::Complex64;

    #[test]
    fn lags_are_those_of_the_defining_sum() {
        for count in [400, 900, 7] {
            let values: Vec<Complex64> = (0..count)
                .map(|n| Complex64::from_polar(1.0 + (0.3 * f64::from(n)).sin(), 0.1 * f64::from(n * n)))
                .collect();
            let mean = values.iter().sum::<Complex64>() / values.len() as f64;
            let covariance = Covariance::<f64>::new(values.len());
            let mut sum = covariance.sum();
            sum.add(values.iter().copied());
            for (lag, found) in sum.mean().into_iter().enumerate() {
                let pairs = values.iter().zip(values.iter().skip(lag));
                let exact: f64 = pairs.map(|(a, b)| ((a - mean) * (b - mean).conj()).re).sum();
                assert!((found - 0.5 * exact / (NOISE_POINTS - 1) as f64).abs() < 1e-13, "{count} {lag}");
            }
        }
    }
}
