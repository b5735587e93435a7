//! Far blocks as products of thin matrices, by crosses of their rows and columns.

use num_complex::Complex64;

use super::super::dense::Dense;
use super::super::single::compressed;
use super::{Builder, Product, Tree};

/// An approximation under construction: Σ u vᵀ.
pub(super) struct Crosses<'a> {
    builder: &'a Builder<'a>,
    targets: &'a Tree,
    sources: &'a Tree,
    /// Columns of U and of V one after the other.
    u: Vec<Complex64>,
    v: Vec<Complex64>,
    used: Vec<bool>,
}

impl<'a> Crosses<'a> {
    pub(super) fn new(builder: &'a Builder<'a>, targets: &'a Tree, sources: &'a Tree) -> Self {
        let used = vec![false; targets.to - targets.from];
        Self { builder, targets, sources, u: Vec::new(), v: Vec::new(), used }
    }

    fn rows(&self) -> usize {
        (self.targets.to - self.targets.from) * self.builder.components
    }

    fn columns(&self) -> usize {
        (self.sources.to - self.sources.from) * self.builder.components
    }

    /// What is left of the rows of a target (a place of the order), one after the other.
    fn left_of_rows(&self, target: usize) -> Vec<Complex64> {
        let (m, columns) = (self.builder.components, self.columns());
        let mut rows = vec![Complex64::ZERO; m * columns];
        let mut block = vec![Complex64::ZERO; m * m];
        let order = self.builder.order;
        for (at, source) in (self.sources.from..self.sources.to).enumerate() {
            if self.builder.blocks.block(order[target], order[source], &mut block) {
                for (row, values) in block.chunks_exact(m).enumerate() {
                    rows[row * columns + at * m..][..m].copy_from_slice(values);
                }
            }
        }
        let first = (target - self.targets.from) * m;
        for (u, v) in self.u.chunks_exact(self.rows()).zip(self.v.chunks_exact(columns)) {
            for (row, factor) in rows.chunks_exact_mut(columns).zip(&u[first..first + m]) {
                subtract(row, *factor, v);
            }
        }
        rows
    }

    /// What is left of the columns of a source.
    fn left_of_columns(&self, source: usize) -> Vec<Complex64> {
        let (m, rows) = (self.builder.components, self.rows());
        let mut columns = vec![Complex64::ZERO; m * rows];
        let mut block = vec![Complex64::ZERO; m * m];
        let order = self.builder.order;
        for (at, target) in (self.targets.from..self.targets.to).enumerate() {
            if self.builder.blocks.block(order[target], order[source], &mut block) {
                for (row, values) in block.chunks_exact(m).enumerate() {
                    for (column, value) in values.iter().enumerate() {
                        columns[column * rows + at * m + row] = *value;
                    }
                }
            }
        }
        let first = (source - self.sources.from) * m;
        for (u, v) in self.u.chunks_exact(rows).zip(self.v.chunks_exact(self.columns())) {
            for (column, factor) in columns.chunks_exact_mut(rows).zip(&v[first..first + m]) {
                subtract(column, *factor, u);
            }
        }
        columns
    }

    /// Adds the cross of a target; whether it was negligible, and the target with most left near its columns.
    pub(super) fn add(&mut self, target: usize) -> (bool, Option<usize>) {
        let (m, rows, columns) = (self.builder.components, self.rows(), self.columns());
        self.used[target - self.targets.from] = true;
        let mut left = self.left_of_rows(target);
        let weight =
            |at: usize| -> f64 { (0..m).map(|row| square(&left[row * columns + at * m..][..m])).sum() };
        let Some(best) = (0..columns / m).max_by(|&a, &b| weight(a).total_cmp(&weight(b))) else {
            return (true, None);
        };
        if weight(best) == 0.0 {
            return (true, None);
        }
        let mut across = self.left_of_columns(self.sources.from + best);
        let mut added = 0.0;
        // The block where both meet, pivot by pivot; what cannot be told from rounding stays out.
        let largest = across.iter().map(Complex64::norm_sqr).fold(0.0, f64::max);
        let at = (target - self.targets.from) * m;
        for _ in 0..m {
            let pivots = (0..m).flat_map(|p| (0..m).map(move |q| (p, q)));
            let pivot = |p: usize, q: usize| across[q * rows + at + p];
            let Some((p, q)) =
                pivots.max_by(|a, b| pivot(a.0, a.1).norm_sqr().total_cmp(&pivot(b.0, b.1).norm_sqr()))
            else {
                break;
            };
            let pivot = pivot(p, q);
            if pivot.norm_sqr() <= 1e-24 * largest || pivot.norm_sqr() == 0.0 {
                break;
            }
            let u: Vec<Complex64> = across[q * rows..][..rows].iter().map(|value| value / pivot).collect();
            let v = left[p * columns..][..columns].to_vec();
            for (row, part) in left.chunks_exact_mut(columns).zip(&u[at..at + m]) {
                subtract(row, *part, &v);
            }
            for (k, column) in across.chunks_exact_mut(rows).enumerate() {
                subtract(column, v[best * m + k], &u);
            }
            added += square(&u) * square(&v);
            self.u.extend(&u);
            self.v.extend(&v);
        }
        let is_quiet = added <= self.builder.tolerance.powi(2);
        let last = self.u.len() / rows - usize::from(added > 0.0);
        let near = |place: usize| -> f64 {
            self.u[last * rows..].chunks_exact(rows).map(|u| square(&u[place * m..][..m])).sum()
        };
        let unused = (0..rows / m).filter(|&place| !self.used[place]);
        let best = unused.max_by(|&a, &b| near(a).total_cmp(&near(b)));
        (is_quiet, best.map(|place| self.targets.from + place))
    }

    /// Whether what is left of a target's rows is negligible.
    pub(super) fn is_approximated(&self, target: usize) -> bool {
        let left = square(&self.left_of_rows(target));
        left <= self.builder.tolerance.powi(2)
    }

    /// Both factors as thin as the tolerance allows, in single precision.
    pub(super) fn finish(self) -> Product {
        let (rows, columns, tolerance) = (self.rows(), self.columns(), self.builder.tolerance);
        let (u, v) = (Dense::from_columns(rows, self.u), Dense::from_columns(columns, self.v));
        let [u, v] = compressed(&u, &v, tolerance);
        Product { u, v }
    }
}

/// y ← y − a x.
fn subtract(y: &mut [Complex64], a: Complex64, x: &[Complex64]) {
    if a == Complex64::ZERO {
        return;
    }
    for (y, x) in y.iter_mut().zip(x) {
        *y -= a * x;
    }
}

fn square(values: &[Complex64]) -> f64 {
    values.iter().map(Complex64::norm_sqr).sum()
}
