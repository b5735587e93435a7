//! Factors of large dense matrices, in place and on all threads.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{solve_unit_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Accum, MatMut, MatRef, Par};
use num_complex::Complex64;
use rayon::prelude::*;

use super::dense::Dense;
use crate::progress::Progress;
use crate::{Error, Result};

/// Columns of one step of the factorization.
const STEP: usize = 128;

/// Columns that one task updates: fixed, so that results do not depend on the number of threads.
const TASK: usize = 64;

/// A square matrix as the product of two triangular ones with rows in another order, in its own memory.
#[derive(Debug)]
pub struct LargeFactors {
    factors: Dense,
    /// Row `order[i]` of the matrix is row i of the product.
    order: Vec<usize>,
}

impl LargeFactors {
    /// Factors of `a`: blocks of columns from left to right (right-looking LU with partial pivoting, Golub and Van Loan
    /// 3.4.7), the rest updated in parallel. `progress` gets steps of equal work, [`Self::steps`] in all.
    ///
    /// # Errors
    /// A pivot is zero or not finite, or the user cancelled.
    ///
    /// # Panics
    /// `a` is not square.
    pub fn new(mut a: Dense, progress: &dyn Progress) -> Result<Self> {
        let size = a.rows();
        assert_eq!(size, a.columns(), "only square matrices have factors");
        let mut order: Vec<usize> = (0..size).collect();
        let mut told = 0;
        for from in (0..size).step_by(STEP) {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let width = STEP.min(size - from);
            let (left, rest) = a.elements_mut().split_at_mut((from + width) * size);
            let (done, panel) = left.split_at_mut(from * size);
            let moved = factor_panel(panel, size, from, width);
            let panel = &*panel;
            let pivots = panel.chunks_exact(size).enumerate().map(|(k, column)| column[from + k]);
            if pivots.map(|pivot| pivot.norm_sqr()).any(|square| !(square > 0.0 && square.is_finite())) {
                return Err(Error::not_settled("a system of equations is singular"));
            }
            let reorder = |columns: &mut [Complex64], scratch: &mut Vec<Complex64>| {
                for column in columns.chunks_exact_mut(size) {
                    scratch.clear();
                    scratch.extend(moved.iter().map(|&row| column[from + row]));
                    column[from..].copy_from_slice(scratch);
                }
            };
            done.par_chunks_mut(TASK * size)
                .for_each_init(Vec::new, |scratch, columns| reorder(columns, scratch));
            rest.par_chunks_mut(TASK * size).for_each_init(Vec::new, |scratch, columns| {
                reorder(columns, scratch);
                update(panel, columns, size, from, width);
            });
            let before = order[from..].to_vec();
            for (place, row) in order[from..].iter_mut().zip(&moved) {
                *place = before[*row];
            }
            let now = work(size, from + width);
            progress.advance(now - told);
            told = now;
        }
        Ok(Self { factors: a, order })
    }

    /// How many steps a factorization of this size tells.
    #[must_use]
    pub fn steps(size: usize) -> u64 {
        work(size, size)
    }

    /// b ← A⁻¹ b.
    pub fn solve(&self, b: &mut Dense) {
        let size = self.factors.rows();
        let mut scratch = Vec::with_capacity(size);
        for k in 0..b.columns() {
            let column = b.column_mut(k);
            scratch.clear();
            scratch.extend(self.order.iter().map(|&row| column[row]));
            column.copy_from_slice(&scratch);
        }
        let columns = b.columns();
        let factors = MatRef::from_column_major_slice(self.factors.elements(), size, size);
        let mut unknowns = MatMut::from_column_major_slice_mut(b.elements_mut(), size, columns);
        solve_unit_lower_triangular_in_place(factors, unknowns.as_mut(), Par::Seq);
        solve_upper_triangular_in_place(factors, unknowns, Par::Seq);
    }
}

/// Thousandths of the whole work that are done with the first `columns`.
fn work(size: usize, columns: usize) -> u64 {
    let left = (size - columns) as f64 / size.max(1) as f64;
    (1000.0 * (1.0 - left * left * left)).round() as u64
}

/// Factors the rows from `from` on of columns `from`…; which row came to which place, counted from `from`.
fn factor_panel(panel: &mut [Complex64], size: usize, from: usize, width: usize) -> Vec<usize> {
    let below = size - from;
    let whole = MatMut::from_column_major_slice_mut(panel, size, width);
    let part = whole.subrows_mut(from, below);
    let (mut order, mut inverse) = (vec![0_usize; below], vec![0_usize; below]);
    let mut memory = MemBuffer::new(lu_in_place_scratch::<usize, Complex64>(
        below,
        width,
        Par::Seq,
        faer::Spec::default(),
    ));
    lu_in_place(part, &mut order, &mut inverse, Par::Seq, MemStack::new(&mut memory), faer::Spec::default());
    order
}

/// What a factored panel leaves of columns to its right.
fn update(panel: &[Complex64], columns: &mut [Complex64], size: usize, from: usize, width: usize) {
    let panel = MatRef::from_column_major_slice(panel, size, width);
    let count = columns.len() / size;
    let columns = MatMut::from_column_major_slice_mut(columns, size, count);
    let (_, below) = columns.split_at_row_mut(from);
    let (mut here, rest) = below.split_at_row_mut(width);
    solve_unit_lower_triangular_in_place(panel.subrows(from, width), here.as_mut(), Par::Seq);
    let lower = panel.subrows(from + width, size - from - width);
    matmul(rest, Accum::Add, lower, here.as_ref(), Complex64::new(-1.0, 0.0), Par::Seq);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Unobserved;

    #[test]
    fn large_systems_are_solved_whatever_their_size() {
        for size in [1, 40, STEP, 3 * STEP + 17] {
            let a = Dense::from_fn(size, size, |i, k| {
                let (i, k) = (i as f64, k as f64);
                Complex64::new((1.7 * i - 0.3 * k * i).sin(), (i * k + 0.4 * k).cos())
            });
            let x = Dense::from_fn(size, 2, |i, k| Complex64::new(i as f64, 1.0 - k as f64));
            let mut b = a.times(&x);
            LargeFactors::new(a, &Unobserved).unwrap().solve(&mut b);
            for k in 0..2 {
                for (got, expected) in b.column(k).iter().zip(x.column(k)) {
                    assert!((got - expected).norm() < 1e-8 * size as f64, "{size}: {got} for {expected}");
                }
            }
        }
        let singular = Dense::zeros(3, 3);
        assert!(LargeFactors::new(singular, &Unobserved).is_err());
        assert_eq!(LargeFactors::steps(500), 1000);
    }
}
