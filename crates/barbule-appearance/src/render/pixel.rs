//! What a pixel of a film knows of its samples, and how sure it is of their mean.

use super::integrator::FirstHit;

/// What a pixel knows of the samples that were taken in it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Pixel {
    /// Luminances Y; of other sensors than the human eye the mean of the channels in its place, as everywhere, each over what it
    /// sees of radiance 1.
    pub luminance: f64,
    /// Squares of Y.
    pub squares: f64,
    /// Shading normals of first hits.
    pub normal: [f64; 3],
    /// Distances of first hits, mm.
    pub depth: f64,
    /// How many samples hit something.
    pub hits: u32,
    /// Identity of the object that the first sample hit, 0 for none.
    pub id: u32,
    /// Luminances Y of the samples in runs of equal length, at most this many: 8 samples each, twice as many whenever all are full.
    pub runs: [f32; RUNS],
}

/// Runs of samples that a pixel tells apart.
pub const RUNS: usize = 8;

/// Samples of a run at first: as many as lie one in each eighth of every dimension.
const SHORTEST_RUN: u32 = 8;

/// Samples of a run when this sample is added: the least power of 2 of which all up to it are in [`RUNS`].
#[inline(always)]
fn run_length(sample: u32) -> u32 {
    SHORTEST_RUN << (u32::BITS - (sample / (SHORTEST_RUN * RUNS as u32)).leading_zeros())
}

impl Pixel {
    /// What is known before the first sample.
    pub(super) const EMPTY: Self = Self {
        luminance: 0.0,
        squares: 0.0,
        normal: [0.0; 3],
        depth: 0.0,
        hits: 0,
        id: 0,
        runs: [0.0; RUNS],
    };

    #[inline(always)]
    pub(super) fn add(&mut self, first: &FirstHit, luminance: f64, number: u32) {
        self.luminance += luminance;
        self.squares += luminance * luminance;
        let run = self.run(number);
        self.runs[run] += luminance as f32;
        if first.id != 0 {
            for (sum, value) in self.normal.iter_mut().zip(first.normal.to_array()) {
                *sum += value;
            }
            self.depth += first.depth;
            self.hits += 1;
        }
        if number == 0 {
            self.id = first.id;
        }
    }

    /// The run that a sample of this number is in. Where all are full, pairs become one.
    #[inline(always)]
    pub(super) fn run(&mut self, number: u32) -> usize {
        let length = run_length(number);
        if number > 0 && length != run_length(number - 1) {
            self.runs =
                std::array::from_fn(
                    |k| {
                        if 2 * k < RUNS { self.runs[2 * k] + self.runs[2 * k + 1] } else { 0.0 }
                    },
                );
        }
        (number / length) as usize
    }

    /// Standard error of the mean Y after `count` samples, from how far the means of its runs scatter. Samples of a run are spread evenly over all that
    /// they are drawn for, and so is a part of their noise gone that [`Pixel::variance`] counts. Of so few runs the root of the variance is too
    /// small in the mean by (4n − 4)/(4n − 3), which is made up for (of normal means; Gurland & Tripathi 1971). Before the second run as of independent
    /// samples.
    pub(super) fn error(&self, count: u32) -> f64 {
        let length = run_length(count.saturating_sub(1));
        let full = (count / length) as usize;
        if full < 2 {
            return self.variance(count).sqrt();
        }
        let (runs, n) = (&self.runs[..full], full as f64);
        let mean = runs.iter().map(|sum| f64::from(*sum)).sum::<f64>() / n;
        let squares: f64 = runs.iter().map(|sum| (f64::from(*sum) - mean) * (f64::from(*sum) - mean)).sum();
        // Of sums over `length` samples; the mean is over all of `count`.
        let variance = squares / (n - 1.0) / (f64::from(length) * f64::from(count));
        variance.sqrt() * (4.0 * n - 3.0) / (4.0 * n - 4.0)
    }

    /// Variance of the mean Y after `count` samples; 0 before the second.
    #[must_use]
    pub fn variance(&self, count: u32) -> f64 {
        let n = f64::from(count);
        if count < 2 {
            return 0.0;
        }
        let mean = self.luminance / n;
        ((self.squares / n - mean * mean).max(0.0)) / (n - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::integrator::NO_HIT;

    /// Numbers that alternate within each run, or are independent, in every count of runs: the error of the mean is that of the runs' means.
    #[test]
    fn the_error_of_a_mean_is_that_of_the_means_of_runs() {
        let mut stream = crate::math::rng::Stream::new(11, &[]);
        for count in [16, 24, 64, 72, 128, 200, 512, 1000] {
            let (mut even, mut independent) = (0.0, 0.0);
            for _ in 0..400 {
                let (mut runs, mut scattered) = (Pixel::default(), Pixel::default());
                for number in 0..count {
                    let away = if number % 2 == 0 { 1.0 } else { -1.0 };
                    runs.add(&NO_HIT, 3.0 + away, number);
                    scattered.add(&NO_HIT, 3.0 + stream.normal(), number);
                }
                even += runs.error(count) / 400.0;
                independent += scattered.error(count) / 400.0;
                assert!(
                    (scattered.runs.iter().map(|v| f64::from(*v)).sum::<f64>() / scattered.luminance - 1.0)
                        .abs()
                        < 1e-5
                );
            }
            let expected = 1.0 / f64::from(count).sqrt();
            // 400 means of as few as one degree of freedom: 0.04.
            assert!((independent / expected - 1.0).abs() < 0.12, "{count}: {independent} {expected}");
            assert!(even < 1e-3 * expected, "{count}: {even}");
        }
        let mut few = Pixel::default();
        (0..8).for_each(|number| few.add(&NO_HIT, f64::from(number), number));
        assert_eq!(few.error(8), few.variance(8).sqrt());
    }
}
