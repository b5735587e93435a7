//! The numbers of one path: an Owen-scrambled Sobol sequence, a pure function of (pixel, sample, seed).

use std::sync::LazyLock;

use fearless_simd::{Simd, f32x16, prelude::*, u32x16};
use sobol_burley::parts::{hash, owen_scramble_rev, sobol_rev};
use sobol_burley::{NUM_DIMENSION_SETS_4D, NUM_DIMENSIONS};

use crate::math::rng::hash as mixed;
use crate::math::simd::{dispatch_large, level};

/// Samples of one sequence; longer runs of samples go on in another one.
const SEQUENCE: u64 = 1 << 16;

/// Dimensions that are computed at once.
const LANES: usize = 16;

/// Sums (exclusive or) of the sequence's direction vectors, reversed, for four bits of the index at a time:
/// `[four bits][their value][dimension in the group]`.
type Directions = [[[u32; LANES]; 16]; 4];

/// Those of each group of dimensions.
static DIRECTIONS: LazyLock<Vec<Directions>> = LazyLock::new(|| {
    let groups = NUM_DIMENSIONS / LANES as u32;
    let row = |group: u32, four: u32, value: u32| {
        // The upper half of the reversed index; the sequence is not longer.
        let sum = |dimension: u32| sobol_rev(value << (16 + 4 * four), dimension);
        std::array::from_fn(|lane| sum(group * LANES as u32 + lane as u32))
    };
    let directions = |group: u32| -> Directions {
        std::array::from_fn(|four| std::array::from_fn(|value| row(group, four as u32, value as u32)))
    };
    (0..groups).map(directions).collect()
});

/// What tells the four dimensions of a set apart, as `sobol_burley` has them.
#[rustfmt::skip]
const APART: [u32; LANES] = [
    0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8, 0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8,
    0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8, 0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8,
];

/// Which set of four of a group each lane belongs to.
const SETS: [u32; LANES] = [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3];

/// Draws the numbers of one path in sets of four: those of `sobol_burley::sample_4d`, four sets computed at once.
#[derive(Debug, Clone)]
pub struct Sampler {
    index: u32,
    seed: u32,
    /// The index as this seed shuffles it, reversed.
    shuffled: u32,
    set: u32,
    numbers: [f32; LANES],
}

impl Sampler {
    /// The numbers of sample `sample` of pixel `pixel`.
    #[inline(always)]
    #[must_use]
    pub fn new(pixel: u64, sample: u64, seed: u64) -> Self {
        let index = (sample % SEQUENCE) as u32;
        let seed = mixed(seed, &[pixel, sample / SEQUENCE]) as u32;
        Self { index, seed, shuffled: shuffled(index, seed), set: 0, numbers: [0.0; LANES] }
    }

    /// The next four numbers, each in [0, 1).
    #[inline(always)]
    pub fn next4(&mut self) -> [f64; 4] {
        if self.set == NUM_DIMENSION_SETS_4D {
            // Out of dimensions: an independent sequence ("padding", Burley 2020).
            self.set = 0;
            self.seed = mixed(u64::from(self.seed), &[1]) as u32;
            self.shuffled = shuffled(self.index, self.seed);
        }
        let lane = 4 * (self.set as usize % (LANES / 4));
        if lane == 0 {
            self.fill();
        }
        self.set += 1;
        let n = &self.numbers[lane..lane + 4];
        [f64::from(n[0]), f64::from(n[1]), f64::from(n[2]), f64::from(n[3])]
    }

    /// The numbers of this set and the three after it.
    #[inline(never)] // one copy for all callers, which are inlined into one function
    fn fill(&mut self) {
        let directions = &DIRECTIONS[self.set as usize / (LANES / 4)];
        self.numbers =
            dispatch_large!(level(), simd => numbers(simd, directions, self.shuffled, self.set, self.seed));
    }
}

/// Compiled for each instruction set.
#[inline(always)]
fn numbers<S: Simd>(simd: S, directions: &Directions, shuffled: u32, set: u32, seed: u32) -> [f32; LANES] {
    let all = |v: u32| u32x16::splat(simd, v);
    let sum = |four: usize| {
        u32x16::from_slice(simd, &directions[four][(shuffled >> (16 + 4 * four)) as usize & 15])
    };
    let mut n = (sum(0) ^ sum(1)) ^ (sum(2) ^ sum(3));
    let scramble = all(seed.wrapping_mul(0x9c8f_2d3b))
        ^ (all(set) + u32x16::from_slice(simd, &SETS))
        ^ u32x16::from_slice(simd, &APART);
    // `sobol_burley::parts::hash` and `owen_scramble_rev`, in lanes.
    let mut h = scramble ^ all(0xe6fe_3beb);
    h = (h ^ (h >> 16)) * all(0x7feb_352d);
    h = (h ^ (h >> 15)) * all(0x846c_a68b);
    h ^= h >> 16;
    n ^= n * all(0x3d20_adea);
    n = (n + h) * ((h >> 16) | all(1));
    n ^= n * all(0x0552_6c56);
    n ^= n * all(0x53a2_2864);
    // Of the bits in reverse the first 23.
    n = ((n >> 1) & all(0x5555_5555)) | ((n & all(0x5555_5555)) << 1);
    n = ((n >> 2) & all(0x3333_3333)) | ((n & all(0x3333_3333)) << 2);
    n = ((n >> 4) & all(0x0f0f_0f0f)) | ((n & all(0x0f0f_0f0f)) << 4);
    n = ((n >> 8) & all(0x00ff_00ff)) | ((n & all(0x00ff_00ff)) << 8);
    n = (n >> 16) | (n << 16);
    let float = ((n >> 9) | all(0x3f80_0000)).bitcast::<f32x16<S>>();
    (float - f32x16::splat(simd, 1.0)).to_array()
}

#[inline(always)]
fn shuffled(index: u32, seed: u32) -> u32 {
    owen_scramble_rev(index.reverse_bits(), hash(seed ^ 0x79c6_8e4a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_samples_of_one_pixel_are_stratified_in_each_dimension() {
        let mut seen = [[false; 16]; 4];
        for sample in 0..16 {
            let values = Sampler::new(7, sample, 3).next4();
            for (dimension, value) in values.iter().enumerate() {
                seen[dimension][(value * 16.0) as usize] = true;
            }
        }
        assert!(seen.iter().flatten().all(|s| *s));
    }

    #[test]
    fn numbers_are_those_of_one_set_after_the_other() {
        for (pixel, sample) in [(0, 0), (7, 3), (123_456, 65_535), (1 << 40, 200_000)] {
            let mut sampler = Sampler::new(pixel, sample, 9);
            let mut seed = mixed(9, &[pixel, sample / SEQUENCE]) as u32;
            for set in 0..100 {
                if set == NUM_DIMENSION_SETS_4D {
                    seed = mixed(u64::from(seed), &[1]) as u32;
                }
                let index = (sample % SEQUENCE) as u32;
                let expected = sobol_burley::sample_4d(index, set % NUM_DIMENSION_SETS_4D, seed);
                assert_eq!(sampler.next4(), expected.map(f64::from));
            }
        }
    }

    #[test]
    fn pixels_seeds_and_long_paths_get_their_own_numbers() {
        let first = |pixel, sample, seed| Sampler::new(pixel, sample, seed).next4();
        assert_ne!(first(0, 0, 1), first(1, 0, 1));
        assert_ne!(first(0, 0, 1), first(0, 0, 2));
        assert_ne!(first(0, 0, 1), first(0, SEQUENCE, 1));
        let mut sampler = Sampler::new(0, 5, 1);
        let numbers: Vec<_> = (0..100).map(|_| sampler.next4()).collect();
        assert_ne!(numbers[0], numbers[64]);
    }
}
