//! Tools of the generators: rough profiles, normal offsets, cuts. All bits are the same on every system.

use std::f64::consts::{PI, TAU};

use super::section::Polyline;
use crate::math::rng::Stream;

/// A rough profile R(τ; low, high): its correlation length and its exact range, µm (or fractions).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Roughness {
    pub(super) correlation_um: f64,
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Roughness {
    /// R(τ; ±amplitude).
    pub(super) fn symmetric(correlation_um: f64, amplitude: f64) -> Self {
        Self { correlation_um, low: -amplitude, high: amplitude }
    }

    /// The profile at points 0, step, 2·step, …: spans exactly [low, high] over them.
    ///
    /// It is periodic over twice the points' length, so that the two ends are independent.
    pub(super) fn along(&self, stream: &mut Stream, count: usize, step: f64) -> Vec<f64> {
        let period = 2.0 * step * count as f64;
        let mut values = periodic(stream, self.correlation_um, period, count, step);
        self.span(&mut values);
        values
    }

    /// Rescales values linearly so that they span exactly [low, high].
    pub(super) fn span(&self, values: &mut [f64]) {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        for value in values {
            let t = if high > low { (*value - low) / (high - low) } else { 0.5 };
            *value = self.low * (1.0 - t) + self.high * t;
        }
    }
}

/// A random periodic function with amplitude spectrum exp(−π² f² τ²) and uniform phases, at 0, step, 2·step, …
pub(super) fn periodic(
    stream: &mut Stream,
    correlation: f64,
    period: f64,
    count: usize,
    step: f64,
) -> Vec<f64> {
    // Beyond this frequency amplitudes are below 1e-12 of the first.
    let highest = (1.68 * period / correlation).ceil().max(1.0) as usize;
    let mut values = vec![0.0; count];
    for k in 1..=highest {
        let frequency = k as f64 / period;
        let exponent = PI * frequency * correlation;
        let amplitude = libm::exp(-exponent * exponent);
        let phase = TAU * stream.unit();
        // Rotates by one step at a time: two products instead of a cosine for each point.
        let (turn_sin, turn_cos) = (libm::sin(TAU * frequency * step), libm::cos(TAU * frequency * step));
        let (mut re, mut im) = (amplitude * libm::cos(phase), amplitude * libm::sin(phase));
        for value in &mut values {
            *value += re;
            (re, im) = (re * turn_cos - im * turn_sin, re * turn_sin + im * turn_cos);
        }
    }
    values
}

/// How many points a curve of this length gets.
pub(super) fn point_count(length: f64, spacing: f64) -> usize {
    (length / spacing).ceil().max(2.0) as usize + 1
}

/// `count` points from −width/2 to width/2, the ends exact.
pub(super) fn grid(width: f64, count: usize) -> Vec<f64> {
    (0..count)
        .map(|i| {
            let t = i as f64 / (count - 1) as f64;
            width * (t - 0.5)
        })
        .collect()
}

pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

impl Polyline {
    /// The mirror image in z = 0.
    pub(super) fn flipped(&self) -> Self {
        Self { x_um: self.x_um.clone(), z_um: self.z_um.iter().map(|z| -z).collect() }
    }

    /// With the end segments' lines going on by `by` in x, one more point at each end.
    pub(super) fn extended(&self, by: f64) -> Self {
        let last = self.x_um.len() - 1;
        let (left, right) = (self.x_um[0] - by, self.x_um[last] + by);
        let mut x_um = Vec::with_capacity(last + 3);
        let mut z_um = Vec::with_capacity(last + 3);
        x_um.push(left);
        z_um.push(self.height(left));
        x_um.extend(&self.x_um);
        z_um.extend(&self.z_um);
        x_um.push(right);
        z_um.push(self.height(right));
        Self { x_um, z_um }
    }

    /// Unit normals (n_x, n_z) with n_z > 0, at the points.
    pub(super) fn normals(&self) -> Vec<[f64; 2]> {
        let last = self.x_um.len() - 1;
        (0..=last)
            .map(|i| {
                let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
                let (dx, dz) = (self.x_um[b] - self.x_um[a], self.z_um[b] - self.z_um[a]);
                let length = libm::hypot(dx, dz);
                [-dz / length, dx / length]
            })
            .collect()
    }

    /// The curve `depth(i)` below point i along the local normal; points that fall behind are left out.
    pub(super) fn below(&self, depth: impl Fn(usize) -> f64) -> Self {
        let mut builder = Increasing::default();
        for (i, normal) in self.normals().iter().enumerate() {
            builder.push(self.x_um[i] - depth(i) * normal[0], self.z_um[i] - depth(i) * normal[1]);
        }
        builder.curve
    }

    /// The part within ±width/2, with points exactly at both ends.
    pub(super) fn cut(&self, width: f64) -> Self {
        let (left, right) = (-0.5 * width, 0.5 * width);
        let mut builder = Increasing::default();
        builder.push(left, self.height(left));
        for (&x, &z) in self.x_um.iter().zip(&self.z_um) {
            // Points closer than this to the ends would make slivers.
            if x > left + 1e-6 && x < right - 1e-6 {
                builder.push(x, z);
            }
        }
        builder.push(right, self.height(right));
        builder.curve
    }
}

/// Collects points whose x increases.
#[derive(Debug, Default)]
pub(super) struct Increasing {
    pub(super) curve: Polyline,
}

impl Increasing {
    /// Adds a point, unless it lies behind the last one.
    pub(super) fn push(&mut self, x: f64, z: f64) {
        if self.curve.x_um.last().is_none_or(|&last| x > last + 1e-9) {
            self.curve.x_um.push(x);
            self.curve.z_um.push(z);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rough_profile_spans_exactly_its_range() {
        for seed in 0..20 {
            let roughness = Roughness { correlation_um: 0.7, low: 0.25, high: 0.75 };
            let values = roughness.along(&mut Stream::new(seed, &[]), 700, 0.03);
            assert_eq!(values.iter().copied().fold(f64::INFINITY, f64::min), 0.25);
            assert_eq!(values.iter().copied().fold(0.0, f64::max), 0.75);
        }
    }

    /// Random phases make the sum Gaussian with a spectrum of exp(−2π²f²τ²), so a correlation of exp(−x²/2τ²).
    #[test]
    fn a_rough_profile_has_its_correlation_length() {
        let (step, lag, tau) = (0.03, 50, 1.5);
        let (mut product, mut square) = (0.0, 0.0);
        for seed in 0..400 {
            let values = periodic(&mut Stream::new(seed, &[]), tau, 80.0, 1333, step);
            for i in 0..values.len() - lag {
                product += values[i] * values[i + lag];
                square += values[i] * values[i];
            }
        }
        // 400 × about 10 independent stretches: a standard error of 0.016.
        assert!((product / square - libm::exp(-0.5)).abs() < 0.05, "{}", product / square);
    }

    #[test]
    fn a_curve_below_a_line_is_at_its_depth() {
        let line = Polyline { x_um: vec![-1.0, 0.0, 1.0], z_um: vec![-0.5, 0.0, 0.5] };
        let below = line.below(|_| 0.3);
        for (&x, &z) in below.x_um.iter().zip(&below.z_um) {
            assert!(((0.5 * x - z) / libm::sqrt(1.25) - 0.3).abs() < 1e-15);
        }
    }
}
