//! Discrete Fourier transforms of any length, in both precisions.
//!
//! RustFFT's planners are generic; planned here, for `f32` and `f64` alone, they are compiled once.

use std::collections::HashMap;
use std::sync::Arc;

use num_complex::Complex;
use rustfft::{Fft, FftNum, FftPlanner};

/// A number that transforms are planned for: `f32` or `f64`.
pub trait Transformable: FftNum {
    /// A plan of Σ x_n e^{−2πj kn/N} for N = `length` points.
    fn forward(length: usize) -> Transform<Self>;
    /// A plan of Σ X_k e^{+2πj kn/N}, without 1/N, for N = `length` points.
    fn inverse(length: usize) -> Transform<Self>;
}

/// The least multiple of 16 that is ≥ `least` and has no prime factor over 5: a length that transforms fast.
#[must_use]
pub fn fast_length(least: usize) -> usize {
    (least.div_ceil(16)..)
        .map(|n| n * 16)
        .find(|&length| {
            let mut rest = length;
            for prime in [2, 3, 5] {
                while rest % prime == 0 {
                    rest /= prime;
                }
            }
            rest == 1
        })
        .unwrap_or(least)
}

/// One planned transform; clones share the plan.
#[derive(Clone)]
pub struct Transform<T>(Arc<dyn Fft<T>>);

impl<T: FftNum> Transform<T> {
    /// Numbers of scratch that [`Self::process`] wants.
    #[must_use]
    pub fn scratch_len(&self) -> usize {
        self.0.get_inplace_scratch_len()
    }

    /// Transforms `values` in place; `scratch` has at least [`Self::scratch_len`] numbers, whatever they are.
    ///
    /// # Panics
    /// `values` is not as long as planned for, or `scratch` is too short.
    pub fn process(&self, values: &mut [Complex<T>], scratch: &mut [Complex<T>]) {
        self.0.process_with_scratch(values, scratch);
    }

    /// [`Self::process`] with scratch of its own.
    ///
    /// # Panics
    /// `values` is not as long as planned for.
    pub fn process_once(&self, values: &mut [Complex<T>]) {
        self.0.process(values);
    }
}

/// Plans that are made once per length.
#[derive(Default)]
pub struct Plans<T> {
    forward: HashMap<usize, Transform<T>>,
    inverse: HashMap<usize, Transform<T>>,
}

impl<T: Transformable> Plans<T> {
    /// [`Transformable::forward`].
    pub fn forward(&mut self, length: usize) -> Transform<T> {
        self.forward.entry(length).or_insert_with(|| T::forward(length)).clone()
    }

    /// [`Transformable::inverse`].
    pub fn inverse(&mut self, length: usize) -> Transform<T> {
        self.inverse.entry(length).or_insert_with(|| T::inverse(length)).clone()
    }
}

macro_rules! transformable {
    ($($real:ty)*) => {$(
        impl Transformable for $real {
            fn forward(length: usize) -> Transform<Self> {
                Transform(FftPlanner::<$real>::new().plan_fft_forward(length))
            }

            fn inverse(length: usize) -> Transform<Self> {
                Transform(FftPlanner::<$real>::new().plan_fft_inverse(length))
            }
        }
    )*};
}

transformable!(f32 f64);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forward_is_the_defining_sum_and_inverse_undoes_it() {
        let length = 12;
        let values: Vec<Complex<f64>> =
            (0..length).map(|n| Complex::new((n as f64).sin(), 0.3 * n as f64)).collect();
        let mut plans = Plans::default();
        let mut spectrum = values.clone();
        plans.forward(length).process_once(&mut spectrum);
        for (k, value) in spectrum.iter().enumerate() {
            let turn = -std::f64::consts::TAU * k as f64 / length as f64;
            let sum: Complex<f64> =
                values.iter().enumerate().map(|(n, x)| x * Complex::from_polar(1.0, turn * n as f64)).sum();
            assert!((sum - value).norm() < 1e-12, "order {k}");
        }
        plans.inverse(length).process_once(&mut spectrum);
        for (back, value) in spectrum.iter().zip(&values) {
            assert!((back / length as f64 - value).norm() < 1e-13);
        }
    }
}
