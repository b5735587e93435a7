//! Random streams that are the same bits on every system.
//!
//! A [`Stream`] is named by a seed and a path of integers (instance, purpose, …). Streams of different names are
//! independent, so the order in which work is done never changes a draw.

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng as _;

/// One named stream of random numbers.
#[derive(Debug, Clone)]
pub struct Stream {
    generator: Pcg64Mcg,
}

/// A number in [0, 1) that random bits, or a name, stand for.
#[inline]
#[must_use]
pub fn unit_of(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// One step of SplitMix64 (Steele, Lea & Flood 2014), used to hash names into states.
#[must_use]
pub fn split_mix(mut state: u64) -> u64 {
    state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    state = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    state = (state ^ (state >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    state ^ (state >> 31)
}

/// A 64-bit hash of a path of integers.
#[must_use]
pub fn hash(seed: u64, path: &[u64]) -> u64 {
    path.iter().fold(split_mix(seed), |state, &word| split_mix(state ^ split_mix(word)))
}

impl Stream {
    /// The stream of this name.
    #[must_use]
    pub fn new(seed: u64, path: &[u64]) -> Self {
        let low = hash(seed, path);
        let state = (u128::from(split_mix(low)) << 64) | u128::from(low);
        Self { generator: Pcg64Mcg::new(state) }
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.generator.next_u64()
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        unit_of(self.bits())
    }

    /// Uniform in [low, high): U(low, high) of the structure pages.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Standard normal, by Box and Muller with `libm`, so that the bits do not depend on the system.
    pub fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.unit()));
        radius * libm::cos(std::f64::consts::TAU * self.unit())
    }

    /// A random permutation of 0 … `count` − 1 (Fisher and Yates).
    pub fn permutation(&mut self, count: usize) -> Vec<usize> {
        let mut items: Vec<usize> = (0..count).collect();
        for last in (1..count).rev() {
            let other = (self.unit() * (last + 1) as f64) as usize;
            items.swap(last, other.min(last));
        }
        items
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_of_the_same_name_are_equal_and_others_differ() {
        let draw = |seed, path: &[u64]| Stream::new(seed, path).bits();
        assert_eq!(draw(1, &[2, 3]), draw(1, &[2, 3]));
        assert_ne!(draw(1, &[2, 3]), draw(1, &[3, 2]));
        assert_ne!(draw(1, &[2, 3]), draw(2, &[2, 3]));
    }

    #[test]
    fn normal_has_zero_mean_and_unit_variance() {
        let mut stream = Stream::new(7, &[]);
        let (mut sum, mut squares) = (0.0, 0.0);
        let count = 100_000;
        for _ in 0..count {
            let x = stream.normal();
            sum += x;
            squares += x * x;
        }
        assert!((sum / count as f64).abs() < 0.01);
        assert!((squares / count as f64 - 1.0).abs() < 0.02);
    }

    #[test]
    fn a_permutation_holds_every_number_once() {
        let mut items = Stream::new(1, &[9]).permutation(50);
        items.sort_unstable();
        assert!(items.iter().copied().eq(0..50));
    }
}
