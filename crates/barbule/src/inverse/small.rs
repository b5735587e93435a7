//! Small symmetric equations, and how much worse a fit may be.

use crate::math::student::fisher_quantile;

/// The lower Cholesky factor of a symmetric positive matrix, row by row; `None` where it is not positive to rounding.
pub(super) fn cholesky(matrix: &[f64], size: usize) -> Option<Vec<f64>> {
    let mut factor = matrix.to_vec();
    for row in 0..size {
        for column in 0..=row {
            let known: f64 = (0..column).map(|k| factor[row * size + k] * factor[column * size + k]).sum();
            let left = matrix[row * size + column] - known;
            factor[row * size + column] = if row == column {
                // What is left of the diagonal is a square of a distance: rounding of its parts is not one.
                if left <= 1e-14 * matrix[row * size + row] || !left.is_finite() {
                    return None;
                }
                left.sqrt()
            } else {
                left / factor[column * size + column]
            };
        }
    }
    Some(factor)
}

/// Solves L Lᵀ x = b in place.
pub(super) fn solve(factor: &[f64], b: &mut [f64]) {
    let size = b.len();
    for row in 0..size {
        let known: f64 = (0..row).map(|k| factor[row * size + k] * b[k]).sum();
        b[row] = (b[row] - known) / factor[row * size + row];
    }
    for row in (0..size).rev() {
        let known: f64 = (row + 1..size).map(|k| factor[k * size + row] * b[k]).sum();
        b[row] = (b[row] - known) / factor[row * size + row];
    }
}

/// The inverse of a symmetric positive matrix, row by row.
pub(super) fn inverse(matrix: &[f64], size: usize) -> Option<Vec<f64>> {
    let factor = cholesky(matrix, size)?;
    let mut all = Vec::with_capacity(size * size);
    for column in 0..size {
        let mut unit = vec![0.0; size];
        unit[column] = 1.0;
        solve(&factor, &mut unit);
        all.extend(unit);
    }
    Some(all)
}

/// Twice the logarithm of the product of a factor's diagonal: that of the determinant.
pub(super) fn log_determinant(factor: &[f64], size: usize) -> f64 {
    (0..size).map(|k| 2.0 * factor[k * size + k].ln()).sum()
}

/// How much worse, in units of the noise's variance, parameters may fit that are as likely as the best at 95 %: the region of all
/// parameters together, with a variance that is estimated from `freedom` degrees of freedom (Fisher's F).
pub(super) fn as_good_within(parameters: usize, freedom: f64) -> f64 {
    parameters as f64 * fisher_quantile(0.95, parameters as f64, freedom)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equations_are_solved_and_singular_ones_are_none() {
        let matrix = [4.0, 1.0, 0.5, 1.0, 3.0, -0.2, 0.5, -0.2, 2.0];
        let found = inverse(&matrix, 3).unwrap();
        for row in 0..3 {
            for column in 0..3 {
                let sum: f64 = (0..3).map(|k| matrix[row * 3 + k] * found[k * 3 + column]).sum();
                assert!((sum - f64::from(u8::from(row == column))).abs() < 1e-14);
            }
        }
        let factor = cholesky(&matrix, 3).unwrap();
        // 4(6 − 0.04) − (2 + 0.1) + 0.5(−0.2 − 1.5)
        assert!((log_determinant(&factor, 3) - 20.89_f64.ln()).abs() < 1e-12);
        assert!(cholesky(&[1.0, 1.0, 1.0, 1.0], 2).is_none());
    }
}
