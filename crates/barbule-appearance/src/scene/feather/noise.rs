//! Smooth random functions of one number, named by a hash: no state, the same bits on every system.

use crate::math::rng::{hash, split_mix};

/// A smooth random function with one knot a unit: values between about −1 and 1, mean 0.
pub(super) fn smooth(name: u64, x: f64) -> f64 {
    let knot = libm::floor(x);
    let rest = x - knot;
    // Knots are hashed by their two's complement, so that negative ones are as good as others.
    let slope = |k: i64| 2.0 * unit(hash(name, &[k as u64])) - 1.0;
    let left = knot as i64;
    let fade = rest * rest * rest * (rest * (6.0 * rest - 15.0) + 10.0);
    let (from, to) = (slope(left) * rest, slope(left + 1) * (rest - 1.0));
    // Gradient noise of one dimension reaches ±1/2.
    2.0 * (from + (to - from) * fade)
}

/// A standard normal value at every knot, with smooth steps between: of standard deviation 1 at the knots, 0.8 over all.
pub(super) fn normal(name: u64, x: f64) -> f64 {
    let knot = libm::floor(x);
    let rest = x - knot;
    let value = |k: i64| crate::math::rng::Stream::new(name, &[k as u64]).normal();
    let left = knot as i64;
    let fade = rest * rest * (3.0 - 2.0 * rest);
    value(left) * (1.0 - fade) + value(left + 1) * fade
}

/// Four octaves of [`smooth`], each of half the height and twice as fine, from 0 to 1.
pub(super) fn fractal(name: u64, x: f64) -> f64 {
    let (mut sum, mut height, mut scale) = (0.0, 1.0, 1.0);
    for octave in 0..4 {
        sum += height * smooth(split_mix(name ^ octave), scale * x);
        height *= 0.5;
        scale *= 2.0;
    }
    (0.5 + 0.5 * sum).clamp(0.0, 1.0)
}

fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_smooth_bounded_and_without_bias() {
        type Noise = fn(u64, f64) -> f64;
        for (of, centre) in [(smooth as Noise, 0.0), (fractal, 0.5), (normal, 0.0)] {
            let values: Vec<f64> = (0..40_000).map(|i| of(7, -200.0 + 0.01 * f64::from(i))).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            assert!((mean - centre).abs() < 0.12, "{mean}");
            let step = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
            assert!(step < 0.12, "{step}");
            assert_ne!(of(7, 0.4), of(8, 0.4));
        }
        let all = (0..10_000).map(|i| smooth(3, 0.037 * f64::from(i)));
        assert!(all.clone().all(|v| v.abs() <= 1.0) && all.fold(0.0, f64::max) > 0.6);
    }
}
