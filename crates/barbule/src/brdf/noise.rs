//! The Gaussian process whose draws tell one barbule from another (S.32–S.49).

use rustfft::{FftPlanner, num_complex::Complex};
use std::f64::consts::TAU;

use super::material::NOISE_TERMS;
use crate::math::rng::{Stream, hash};
use crate::scattering::statistics::NOISE_POINTS;

/// Base functions; rotated, shifted and mirrored they give every instance a function of its own.
const BASES: usize = 512;

/// Rotations of (q_r, q_i) in their plane.
const ROTATIONS: usize = 1024;

/// Purpose of the random streams of this file.
const PURPOSE: u64 = 0x006e_6f69_7365;

/// The power spectrum P₁ … P_{N/2−1} of an autocovariance at lags 0 … N/2 − 1 of spacing 2/N.
///
/// The lags are normalized to C(0) = 1 and shifted by a constant so that they sum to zero over the period (S.34), tiny
/// negative P are clipped, P₀ = P_{N/2} = 0, and the result is normalized to Σ P = ½ over these terms. Without any
/// positive power (or with something not finite) the process is white.
#[must_use]
pub fn spectrum(autocovariance: &[f64]) -> Vec<f64> {
    let n = NOISE_POINTS;
    let lag = |k: usize| autocovariance.get(k).copied().unwrap_or(0.0);
    let mut circle: Vec<Complex<f64>> =
        (0..n).map(|k| Complex::new(lag(k.min(n - k).min(n / 2 - 1)), 0.0)).collect();
    // Dropping P₀ is the constant that makes the lags sum to zero.
    FftPlanner::new().plan_fft_forward(n).process(&mut circle);
    let power: Vec<f64> = circle[1..n / 2].iter().map(|c| c.re.max(0.0)).collect();
    let sum: f64 = power.iter().sum();
    if sum > 0.0 && sum.is_finite() {
        power.iter().map(|p| 0.5 * p / sum).collect()
    } else {
        vec![0.5 / NOISE_TERMS as f64; NOISE_TERMS]
    }
}

/// Draws of the process, ready for lookup.
#[derive(Debug, Clone)]
pub struct Noise {
    /// (q_r, q_i) of each base at each point. Shape `[base, point]`.
    values: Vec<[[f32; 2]; NOISE_POINTS]>,
    /// Cosine and sine of evenly spread angles.
    rotations: Vec<[f32; 2]>,
    /// Autocovariance of the final process at lags 0 … N/2.
    autocovariance: Vec<f64>,
    /// 1 − C₁, twice: the interpolation's loss of variance at t.
    loss: f32,
    seed: u64,
}

/// One instance: which base, and how it is turned, shifted and mirrored.
#[derive(Debug, Clone, Copy)]
pub struct Draw {
    base: usize,
    shift: i32,
    direction: i32,
    cosine: f32,
    sine: f32,
}

impl Noise {
    /// Draws the base functions of P₁ … P_{N/2−1}.
    #[must_use]
    pub fn new(power: &[f64], seed: u64) -> Self {
        let n = NOISE_POINTS;
        let mut planner = FftPlanner::new();
        let inverse = planner.plan_fft_inverse(n);
        let mut scratch = vec![Complex::new(0.0, 0.0); inverse.get_inplace_scratch_len()];
        let mut values = vec![[[0.0; 2]; NOISE_POINTS]; BASES];
        let mut terms = vec![Complex::new(0.0, 0.0); n];
        for (base, values) in values.iter_mut().enumerate() {
            let mut stream = Stream::new(seed, &[PURPOSE, base as u64]);
            // One complex transform makes two real functions: with independent normal terms at ±l of power 2 P_l each
            // (real and imaginary parts of P_l), real and imaginary parts are independent and follow S.36.
            terms.fill(Complex::new(0.0, 0.0));
            for (l, p) in power.iter().enumerate().take(NOISE_TERMS) {
                let amplitude = p.sqrt();
                terms[l + 1] = Complex::new(stream.normal(), stream.normal()) * amplitude;
                terms[n - l - 1] = Complex::new(stream.normal(), stream.normal()) * amplitude;
            }
            inverse.process_with_scratch(&mut terms, &mut scratch);
            for (value, c) in values.iter_mut().zip(&terms) {
                *value = [c.re as f32, c.im as f32];
            }
        }
        normalize(values.as_flattened_mut());
        let autocovariance: Vec<f64> = (0..=n / 2)
            .map(|k| {
                let term = |l: usize, p: &f64| p * libm::cos(TAU * ((k * (l + 1)) % n) as f64 / n as f64);
                2.0 * power.iter().enumerate().map(|(l, p)| term(l, p)).sum::<f64>()
            })
            .collect();
        let rotations = (0..ROTATIONS)
            .map(|k| {
                let (sin, cos) = libm::sincos(TAU * (k as f64 + 0.5) / ROTATIONS as f64);
                [cos as f32, sin as f32]
            })
            .collect();
        let loss = (2.0 * (1.0 - autocovariance[1])) as f32;
        Self { values, rotations, autocovariance, loss, seed }
    }

    /// The autocovariance of the process at lags 0 … N/2, spacing 2/N.
    #[must_use]
    pub fn autocovariance(&self) -> &[f64] {
        &self.autocovariance
    }

    /// The draw that belongs to an instance.
    #[must_use]
    #[inline(always)]
    pub fn draw(&self, instance: u64) -> Draw {
        let bits = hash(self.seed, &[instance]);
        let [cosine, sine] = self.rotations[(bits >> 40) as usize % ROTATIONS];
        Draw {
            base: bits as usize % BASES,
            shift: (bits >> 16) as i32 & (NOISE_POINTS as i32 - 1),
            direction: if bits >> 63 == 0 { 1 } else { -1 },
            cosine,
            sine,
        }
    }

    /// (q_r, q_i) at x, interpolated with the weights of S.47, which keep the variance; the period is 2.
    #[must_use]
    pub fn at(&self, draw: &Draw, x: f32) -> [f32; 2] {
        let [real, imaginary] = self.at_four(draw, [x; 4]);
        [real[0], imaginary[0]]
    }

    /// q_r and q_i at four places. Loops apart, so that all but the lookups is done four at a time.
    #[inline(always)]
    pub(super) fn at_four(&self, draw: &Draw, x: [f32; 4]) -> [[f32; 4]; 2] {
        let (mut index, mut r1, mut r2) = ([0_i32; 4], [0.0_f32; 4], [0.0_f32; 4]);
        for lane in 0..4 {
            // x_k = (2k + 1 − N)/N. The bounds keep the conversion exact far outside (−1, 1), where it is periodic.
            let position = (x[lane].clamp(-512.0, 512.0) + 1024.0) * (0.5 * NOISE_POINTS as f32) - 0.5;
            index[lane] = truncated(position);
            let t = position - index[lane] as f32;
            // (1−t)² + t² + 2 t (1−t) C₁ = 1 − 2 t (1−t)(1 − C₁).
            let scale = 1.0 / (1.0 - t * (1.0 - t) * self.loss).sqrt();
            (r1[lane], r2[lane]) = ((1.0 - t) * scale, t * scale);
        }
        let base = &self.values[draw.base];
        let (mut near, mut far) = ([[0.0_f32; 2]; 4], [[0.0_f32; 2]; 4]);
        for lane in 0..4 {
            let first = index[lane] * draw.direction + draw.shift;
            near[lane] = base[first as usize & (NOISE_POINTS - 1)];
            far[lane] = base[(first + draw.direction) as usize & (NOISE_POINTS - 1)];
        }
        let (mut real, mut imaginary) = ([0.0; 4], [0.0; 4]);
        for lane in 0..4 {
            let a = r1[lane] * near[lane][0] + r2[lane] * far[lane][0];
            let b = r1[lane] * near[lane][1] + r2[lane] * far[lane][1];
            real[lane] = draw.cosine * a - draw.sine * b;
            imaginary[lane] = draw.sine * a + draw.cosine * b;
        }
        [real, imaginary]
    }
}

/// The integer below a positive number under 2²²; by adding 2²³, which also serves vector registers.
#[inline(always)]
fn truncated(positive: f32) -> i32 {
    const MAGIC: f32 = 8_388_608.0;
    let nearest = positive - 0.5 + MAGIC;
    // Integers may round either way, so the weight runs over [0, 1] inclusive.
    (nearest.to_bits() & 0x007f_ffff) as i32
}

/// Makes the variance over all bases and points exactly 1, so that E[f] = f̂ over the instances that exist.
fn normalize(values: &mut [[f32; 2]]) {
    let sum: f64 = values.iter().map(|[r, i]| f64::from(*r).powi(2) + f64::from(*i).powi(2)).sum();
    let scale = (2.0 * values.len() as f64 / sum).sqrt() as f32;
    if scale.is_finite() {
        for value in values.iter_mut() {
            *value = value.map(|v| v * scale);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A band-limited process with correlation length 0.02.
    fn noise() -> Noise {
        let lags: Vec<f64> =
            (0..512).map(|k| libm::exp(-(2.0 * f64::from(k) / 1024.0 / 0.02).powi(2))).collect();
        Noise::new(&spectrum(&lags), 5)
    }

    #[test]
    fn values_have_zero_mean_unit_variance_and_the_autocovariance_also_between_points() {
        let noise = noise();
        let count = 40_000;
        for x in [0.0_f32, 0.000_488, 0.1003, -0.77] {
            let (mut mean, mut variance, mut cross) = (0.0, 0.0, 0.0);
            let mut lag = [0.0; 3];
            for instance in 0..count {
                let draw = noise.draw(instance);
                let [r, i] = noise.at(&draw, x).map(f64::from);
                mean += r + i;
                variance += 0.5 * (r * r + i * i);
                cross += r * i;
                for (k, sum) in lag.iter_mut().enumerate() {
                    let [r2, i2] = noise.at(&draw, x + (5 * (k + 1)) as f32 / 512.0).map(f64::from);
                    *sum += 0.5 * (r * r2 + i * i2);
                }
            }
            let n = count as f64;
            // Three standard deviations of the sums: √(2/n), √(1/n), …
            assert!((mean / n).abs() < 0.03, "{x} mean {}", mean / n);
            assert!((variance / n - 1.0).abs() < 0.02, "{x} variance {}", variance / n);
            assert!((cross / n).abs() < 0.02);
            for (k, sum) in lag.iter().enumerate() {
                let expected = noise.autocovariance()[5 * (k + 1)];
                assert!((sum / n - expected).abs() < 0.02, "{x} lag {k}: {} {expected}", sum / n);
            }
        }
    }

    #[test]
    fn interpolation_loses_no_variance_for_a_rough_process() {
        // Correlation length 0.6 of a spacing: plain linear interpolation would lose 40 % of the variance midway.
        let lags: Vec<f64> = (0..512).map(|k| libm::exp(-(f64::from(k) / 0.6).powi(2))).collect();
        let noise = Noise::new(&spectrum(&lags), 1);
        let count = 40_000;
        let mid: f64 = (0..count).map(|i| f64::from(noise.at(&noise.draw(i), 0.0)[0]).powi(2)).sum::<f64>();
        assert!((mid / count as f64 - 1.0).abs() < 0.02, "{}", mid / count as f64);
    }

    #[test]
    fn the_spectrum_is_that_of_the_autocovariance() {
        let lags: Vec<f64> = (0..512).map(|k| libm::cos(TAU * 7.0 * f64::from(k) / 1024.0)).collect();
        let power = spectrum(&lags);
        assert_eq!(power.len(), NOISE_TERMS);
        // Lag N/2 repeats none of the 512 given: a thousandth of the power leaks.
        assert!((power[6] - 0.5).abs() < 2e-3, "{}", power[6]);
        assert!((power.iter().sum::<f64>() - 0.5).abs() < 1e-12);
        assert!(spectrum(&[]).iter().chain(&spectrum(&[f64::NAN; 4])).all(|p| *p > 0.0));
    }
}
