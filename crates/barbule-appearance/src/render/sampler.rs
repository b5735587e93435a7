//! The numbers of one path: an Owen-scrambled Sobol sequence, a pure function of (pixel, sample, seed).

use crate::math::rng::hash;

/// Samples of one sequence; longer runs of samples go on in another one.
const SEQUENCE: u64 = 1 << 16;

/// Draws the numbers of one path in sets of four.
#[derive(Debug, Clone)]
pub struct Sampler {
    index: u32,
    seed: u32,
    set: u32,
}

impl Sampler {
    /// The numbers of sample `sample` of pixel `pixel`.
    #[must_use]
    pub fn new(pixel: u64, sample: u64, seed: u64) -> Self {
        Self {
            index: (sample % SEQUENCE) as u32,
            seed: hash(seed, &[pixel, sample / SEQUENCE]) as u32,
            set: 0,
        }
    }

    /// The next four numbers, each in [0, 1).
    pub fn next4(&mut self) -> [f64; 4] {
        if self.set == sobol_burley::NUM_DIMENSION_SETS_4D {
            // Out of dimensions: an independent sequence ("padding", Burley 2020).
            self.set = 0;
            self.seed = hash(u64::from(self.seed), &[1]) as u32;
        }
        let values = sobol_burley::sample_4d(self.index, self.set, self.seed);
        self.set += 1;
        values.map(f64::from)
    }
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
