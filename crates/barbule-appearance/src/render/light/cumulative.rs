//! Drawing one of many intervals in proportion to their weights.

/// Cumulative distributions, one a line, all of as many intervals, with a guide to each that says where to begin to search.
#[derive(Debug)]
pub(super) struct Cumulative {
    /// Intervals of a line.
    count: usize,
    /// `count` + 1 values a line, from 0 to 1; all 0 where a line has no weight.
    values: Vec<f64>,
    /// How many values are at most k/`count`, for k from 0: `count` a line.
    guide: Vec<u32>,
}

impl Cumulative {
    /// From weights, `count` a line; also their sum in each line.
    pub(super) fn new(count: usize, weights: &[f64]) -> (Self, Vec<f64>) {
        let lines = weights.len() / count;
        let mut values = Vec::with_capacity(lines * (count + 1));
        let mut guide = Vec::with_capacity(lines * count);
        let mut totals = Vec::with_capacity(lines);
        for line in weights.chunks_exact(count) {
            let first = values.len();
            let mut sum = 0.0;
            values.push(sum);
            for weight in line {
                sum += weight;
                values.push(sum);
            }
            let values = &mut values[first..];
            if sum > 0.0 {
                values.iter_mut().for_each(|v| *v /= sum);
            }
            let mut at = 0;
            for k in 0..count {
                let from = k as f64 / count as f64;
                while at <= count && values[at] <= from {
                    at += 1;
                }
                guide.push(at as u32);
            }
            totals.push(sum);
        }
        (Self { count, values, guide }, totals)
    }

    /// The interval of a line that holds `u` of its weight, 0 … 1, and where in it, 0 … 1.
    #[inline(always)]
    pub(super) fn invert(&self, line: usize, u: f64) -> (usize, f64) {
        let values = &self.values[line * (self.count + 1)..][..=self.count];
        let guide = &self.guide[line * self.count..][..self.count];
        let mut above = guide[((u * self.count as f64) as usize).min(self.count - 1)] as usize;
        while above <= self.count && values[above] <= u {
            above += 1;
        }
        let mut index = (above.max(1) - 1).min(self.count - 1);
        // Rounding may end in an interval of no weight; the one before has some.
        while index > 0 && values[index + 1] <= values[index] {
            index -= 1;
        }
        let width = values[index + 1] - values[index];
        (index, if width > 0.0 { ((u - values[index]) / width).clamp(0.0, 1.0) } else { 0.5 })
    }

    /// The share of an interval in its line.
    #[inline(always)]
    pub(super) fn share(&self, line: usize, index: usize) -> f64 {
        let first = line * (self.count + 1) + index;
        self.values[first + 1] - self.values[first]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Stream;

    /// Against a search through all values.
    #[test]
    fn intervals_hold_what_was_asked_for() {
        let mut stream = Stream::new(81, &[]);
        for count in [1, 2, 7, 64] {
            // Steep, with intervals of no weight among them.
            let weights: Vec<f64> =
                (0..3 * count).map(|_| (10.0 * stream.unit() - 3.0).max(0.0).powi(6)).collect();
            let (cumulative, totals) = Cumulative::new(count, &weights);
            for (line, weights) in weights.chunks(count).enumerate() {
                assert!((totals[line] - weights.iter().sum::<f64>()).abs() <= 1e-12 * totals[line]);
                if totals[line] == 0.0 {
                    continue;
                }
                for _ in 0..1000 {
                    let u = stream.unit();
                    let (index, rest) = cumulative.invert(line, u);
                    let before: f64 = weights[..index].iter().sum();
                    let found = (before + rest * weights[index]) / totals[line];
                    assert!(weights[index] > 0.0 && (found - u).abs() < 1e-12, "{u} {found}");
                    assert!((cumulative.share(line, index) - weights[index] / totals[line]).abs() < 1e-12);
                }
            }
        }
    }
}
