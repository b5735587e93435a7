//! Random fields over the plane: sums of plane waves, known anywhere without a map of them.

use std::f64::consts::{SQRT_2, TAU};

use crate::math::dense::Factor;
use crate::math::rng::Stream;

/// Plane waves that add up to one field: enough for heights that are normally distributed to a part in a hundred of the
/// fourth moment.
const WAVES: usize = 96;

/// One plane wave cos(k·r + start).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Wave {
    k_per_um: [f64; 2],
    start: f64,
}

/// A normally distributed field of mean 0 and standard deviation 1 with the autocorrelation exp(−Δx²/2τ_x² − Δy²/2τ_y²):
/// that of the profiles R(τ; a, b), in both directions.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Relief {
    waves: Vec<Wave>,
}

/// A field prepared on a line of places y.
pub(super) struct Relieved<'a> {
    relief: &'a Relief,
    /// cos and sin of k_y·y. Shape: `[wave][cos, sin][y]`.
    table: Vec<f32>,
    count: usize,
}

/// What of a field is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Value,
    SlopeX,
    SlopeY,
}

impl Relief {
    pub(super) fn new(stream: &mut Stream, correlation_um: [f64; 2]) -> Self {
        let wave = |_| {
            let k_per_um = correlation_um.map(|tau| stream.normal() / tau);
            Wave { k_per_um, start: stream.uniform(0.0, TAU) }
        };
        Self { waves: (0..WAVES).map(wave).collect() }
    }

    /// Bytes of a field prepared on so many places.
    pub(super) fn bytes_on(count: usize) -> usize {
        (2 * WAVES * size_of::<f32>()).saturating_mul(count)
    }

    pub(super) fn on(&self, y_um: &[f64]) -> Relieved<'_> {
        let mut table = Vec::with_capacity(2 * WAVES * y_um.len());
        for wave in &self.waves {
            let turns = |y: &f64| libm::sincos(wave.k_per_um[1] * y);
            table.extend(y_um.iter().map(|y| turns(y).1 as f32));
            table.extend(y_um.iter().map(|y| turns(y).0 as f32));
        }
        Relieved { relief: self, table, count: y_um.len() }
    }
}

impl Relieved<'_> {
    /// The field times `scale` at x, for each y.
    pub(super) fn at(&self, x_um: f64, part: Part, scale: f64, out: &mut [f32]) {
        let size = scale * SQRT_2 / (WAVES as f64).sqrt();
        let mut factors = [0.0; 2 * WAVES];
        for (wave, factors) in self.relief.waves.iter().zip(factors.as_chunks_mut::<2>().0) {
            let (sin, cos) = libm::sincos(wave.k_per_um[0] * x_um + wave.start);
            let both = match part {
                Part::Value => [size * cos, -size * sin],
                Part::SlopeX => [sin, cos].map(|v| -size * wave.k_per_um[0] * v),
                Part::SlopeY => [sin, cos].map(|v| -size * wave.k_per_um[1] * v),
            };
            *factors = both.map(|v| v as f32);
        }
        f32::multiply(out, false, &self.table, &factors, self.count, 2 * WAVES, 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over 120 fields of 96 waves: the slopes' mean square has a standard error of √(2/(120·96)) = 0.013 by the waves alone.
    #[test]
    fn a_field_has_its_variance_its_correlations_and_its_slopes() {
        let tau = [0.5, 0.8];
        let y_um: Vec<f64> = (0..60).map(|i| 0.4 * f64::from(i)).collect();
        let (mut square, mut fourth, mut apart_x, mut apart_y, mut slope) = (0.0, 0.0, 0.0, 0.0, [0.0; 2]);
        let mut count = 0.0;
        for seed in 0..120 {
            let relief = Relief::new(&mut Stream::new(seed, &[]), tau);
            let on = relief.on(&y_um);
            let read = |x: f64, part| {
                let mut out = vec![0.0; y_um.len()];
                on.at(x, part, 1.0, &mut out);
                out
            };
            for column in 0..8 {
                let x = 2.0 * f64::from(column);
                let (here, right) = (read(x, Part::Value), read(x + tau[0], Part::Value));
                let slopes = [read(x, Part::SlopeX), read(x, Part::SlopeY)];
                for i in 0..58 {
                    let h = f64::from(here[i]);
                    square += h * h;
                    fourth += h.powi(4);
                    apart_x += h * f64::from(right[i]);
                    apart_y += h * f64::from(here[i + 2]);
                    for axis in 0..2 {
                        slope[axis] += f64::from(slopes[axis][i]).powi(2);
                    }
                    count += 1.0;
                }
            }
        }
        let half = (-0.5_f64).exp();
        assert!((square / count - 1.0).abs() < 0.03, "{}", square / count);
        assert!((fourth / count - 3.0).abs() < 0.2, "{}", fourth / count);
        assert!((apart_x / count - half).abs() < 0.03, "{}", apart_x / count);
        assert!((apart_y / count - half).abs() < 0.03, "{}", apart_y / count);
        for axis in 0..2 {
            assert!((slope[axis] / count * tau[axis].powi(2) - 1.0).abs() < 0.04, "{slope:?}");
        }
    }

    #[test]
    fn slopes_are_the_derivatives() {
        let relief = Relief::new(&mut Stream::new(7, &[3]), [0.4, 0.6]);
        let (x, y, step) = (1.7, -2.3, 1e-3);
        let read = |x: f64, y: f64, part| {
            let mut out = [0.0];
            relief.on(&[y]).at(x, part, 1.0, &mut out);
            f64::from(out[0])
        };
        let by_x = (read(x + step, y, Part::Value) - read(x - step, y, Part::Value)) / (2.0 * step);
        let by_y = (read(x, y + step, Part::Value) - read(x, y - step, Part::Value)) / (2.0 * step);
        assert!((by_x - read(x, y, Part::SlopeX)).abs() < 1e-3);
        assert!((by_y - read(x, y, Part::SlopeY)).abs() < 1e-3);
    }
}
