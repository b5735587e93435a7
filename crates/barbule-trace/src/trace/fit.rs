//! Linear least squares with few unknowns.

use barbule_base::Complex64;
use barbule_base::math::dense::Dense;

/// Sums of the normal equations.
#[derive(Debug, Clone)]
pub(super) struct Normal {
    unknowns: usize,
    matrix: Vec<f64>,
    right: Vec<f64>,
}

impl Normal {
    pub(super) fn new(unknowns: usize) -> Self {
        Self { unknowns, matrix: vec![0.0; unknowns * unknowns], right: vec![0.0; unknowns] }
    }

    /// One equation Σ row·unknown = value.
    pub(super) fn add(&mut self, row: &[f64], value: f64) {
        for (i, a) in row.iter().enumerate() {
            self.right[i] += a * value;
            for (j, b) in row.iter().enumerate() {
                self.matrix[i * self.unknowns + j] += a * b;
            }
        }
    }

    /// Holds an unknown near a value with a weight.
    pub(super) fn hold(&mut self, unknown: usize, value: f64, weight: f64) {
        self.matrix[unknown * self.unknowns + unknown] += weight;
        self.right[unknown] += weight * value;
    }

    /// The unknowns; none where the equations do not say them.
    pub(super) fn solved(&self) -> Option<Vec<f64>> {
        let n = self.unknowns;
        let matrix = Dense::from_fn(n, n, |i, j| Complex64::new(self.matrix[i * n + j], 0.0));
        let mut right = Dense::from_fn(n, 1, |i, _| Complex64::new(self.right[i], 0.0));
        matrix.solve(&mut right);
        let solution: Vec<f64> = right.column(0).iter().map(|value| value.re).collect();
        solution.iter().all(|value| value.is_finite()).then_some(solution)
    }
}
