//! The Kronecker sequence of the generalized golden ratio: points that fill a cube of any dimension evenly.

/// The points whose coordinates are the fractions of ½ + k/g, ½ + k/g², …, where g^(d+1) = g + 1.
#[derive(Debug, Clone, Copy)]
pub struct GoldenPoints {
    ratio: f64,
}

impl GoldenPoints {
    /// In a cube of so many dimensions.
    #[must_use]
    pub fn new(dimensions: usize) -> Self {
        let root = 1.0 / (dimensions as f64 + 1.0);
        Self { ratio: (0..60).fold(2.0_f64, |g, _| (1.0 + g).powf(root)) }
    }

    /// A coordinate of point `k`, from 0 to 1.
    #[must_use]
    pub fn at(&self, k: usize, axis: usize) -> f64 {
        (0.5 + k as f64 * self.ratio.powi(-(axis as i32 + 1))).fract()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_solve_their_equation_and_points_fill_the_square_evenly() {
        let golden = GoldenPoints::new(1).ratio;
        assert!((golden - 0.5 * (1.0 + 5.0_f64.sqrt())).abs() < 1e-15);
        for dimensions in 1..8 {
            let g = GoldenPoints::new(dimensions).ratio;
            assert!((g.powi(dimensions as i32 + 1) - g - 1.0).abs() < 1e-14);
        }
        // 1024 points at random would lie in 64 cells by 16 ± 4 each.
        let points = GoldenPoints::new(2);
        let mut counts = [0_usize; 64];
        for k in 0..1024 {
            let [x, y] = [0, 1].map(|axis| (8.0 * points.at(k, axis)) as usize);
            counts[8 * x + y] += 1;
        }
        assert!(counts.iter().all(|count| (13..=19).contains(count)), "{counts:?}");
    }
}
