//! Dense matrices, column by column: complex ones with what solvers ask of them, and products of real ones.

use faer::linalg::matmul::matmul;
use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::{Accum, MatMut, MatRef, Par};
use num_complex::Complex64;

/// Real numbers that matrices are multiplied of: `f32` or `f64`.
pub trait Factor: Sized {
    /// C = A·B, or C += A·B if `add`; A is `rows`×`inner`, B `inner`×`columns`, all column by column.
    ///
    /// # Panics
    /// A slice is shorter than its matrix.
    fn multiply(c: &mut [Self], add: bool, a: &[Self], b: &[Self], rows: usize, inner: usize, columns: usize);
}

macro_rules! factor {
    ($($real:ty)*) => {$(
        impl Factor for $real {
            fn multiply(
                c: &mut [Self],
                add: bool,
                a: &[Self],
                b: &[Self],
                rows: usize,
                inner: usize,
                columns: usize,
            ) {
                matmul(
                    MatMut::from_column_major_slice_mut(&mut c[..rows * columns], rows, columns),
                    if add { Accum::Add } else { Accum::Replace },
                    MatRef::from_column_major_slice(&a[..rows * inner], rows, inner),
                    MatRef::from_column_major_slice(&b[..inner * columns], inner, columns),
                    1.0,
                    Par::Seq,
                );
            }
        }
    )*};
}

factor!(f32 f64);

/// A square matrix as the product of two triangular ones, with its rows in another order.
#[derive(Debug, Clone)]
pub struct Factors(PartialPivLu<Complex64>);

impl Factors {
    /// b ← A⁻¹ b.
    pub fn solve(&self, b: &mut Dense) {
        self.0.solve_in_place(b.view_mut());
    }
}

/// A complex matrix whose columns follow one another.
#[derive(Debug, Clone)]
pub struct Dense {
    rows: usize,
    columns: usize,
    data: Vec<Complex64>,
}

impl Dense {
    /// All elements 0.
    #[must_use]
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self { rows, columns, data: vec![Complex64::new(0.0, 0.0); rows * columns] }
    }

    /// 1 on the diagonal, 0 elsewhere.
    #[must_use]
    pub fn identity(size: usize) -> Self {
        let mut one = Self::zeros(size, size);
        one.add_one();
        one
    }

    /// Element by element from (row, column).
    #[must_use]
    pub fn from_fn(rows: usize, columns: usize, mut element: impl FnMut(usize, usize) -> Complex64) -> Self {
        let mut data = Vec::with_capacity(rows * columns);
        for k in 0..columns {
            data.extend((0..rows).map(|i| element(i, k)));
        }
        Self { rows, columns, data }
    }

    /// From columns of so many rows, one after the other.
    ///
    /// # Panics
    /// The last column is not whole.
    #[must_use]
    pub fn from_columns(rows: usize, data: Vec<Complex64>) -> Self {
        let columns = data.len() / rows.max(1);
        assert_eq!(rows * columns, data.len(), "columns are whole");
        Self { rows, columns, data }
    }

    /// How many rows it has.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// How many columns it has.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Column `k`.
    #[must_use]
    pub fn column(&self, k: usize) -> &[Complex64] {
        &self.data[k * self.rows..(k + 1) * self.rows]
    }

    /// Column `k`.
    pub fn column_mut(&mut self, k: usize) -> &mut [Complex64] {
        &mut self.data[k * self.rows..(k + 1) * self.rows]
    }

    /// All elements, column by column.
    #[must_use]
    pub fn elements(&self) -> &[Complex64] {
        &self.data
    }

    /// All elements, column by column.
    pub fn elements_mut(&mut self) -> &mut [Complex64] {
        &mut self.data
    }

    fn view(&self) -> MatRef<'_, Complex64> {
        MatRef::from_column_major_slice(&self.data, self.rows, self.columns)
    }

    fn view_mut(&mut self) -> MatMut<'_, Complex64> {
        MatMut::from_column_major_slice_mut(&mut self.data, self.rows, self.columns)
    }

    /// A·B.
    #[must_use]
    pub fn times(&self, b: &Self) -> Self {
        let mut product = Self::zeros(self.rows, b.columns);
        matmul(product.view_mut(), Accum::Replace, self.view(), b.view(), Complex64::new(1.0, 0.0), Par::Seq);
        product
    }

    /// A + B.
    #[must_use]
    pub fn plus(&self, b: &Self) -> Self {
        let data = self.data.iter().zip(&b.data).map(|(x, y)| x + y).collect();
        Self { data, ..*self }
    }

    /// Adds A·B.
    pub fn add_product(&mut self, a: &Self, b: &Self) {
        matmul(self.view_mut(), Accum::Add, a.view(), b.view(), Complex64::new(1.0, 0.0), Par::Seq);
    }

    /// Aᵀ·B, without conjugation.
    #[must_use]
    pub fn transposed_times(&self, b: &Self) -> Self {
        let mut product = Self::zeros(self.columns, b.columns);
        let one = Complex64::new(1.0, 0.0);
        matmul(product.view_mut(), Accum::Replace, self.view().transpose(), b.view(), one, Par::Seq);
        product
    }

    /// The rows of this matrix, then those of `b`.
    #[must_use]
    pub fn above(&self, b: &Self) -> Self {
        let mut data = Vec::with_capacity(self.data.len() + b.data.len());
        for k in 0..self.columns {
            data.extend_from_slice(self.column(k));
            data.extend_from_slice(b.column(k));
        }
        Self { rows: self.rows + b.rows, columns: self.columns, data }
    }

    /// Puts all columns of `b` from `row` on.
    pub fn set_block(&mut self, row: usize, b: &Self) {
        for k in 0..self.columns {
            self.column_mut(k)[row..row + b.rows].copy_from_slice(b.column(k));
        }
    }

    /// A ← 1 − A.
    pub fn one_less(&mut self) {
        for element in &mut self.data {
            *element = -*element;
        }
        self.add_one();
    }

    /// A ← A + 1.
    pub fn add_one(&mut self) {
        for k in 0..self.columns {
            self.data[k * self.rows + k] += 1.0;
        }
    }

    /// diag(left)·A·diag(right).
    #[must_use]
    pub fn scaled(&self, left: &[Complex64], right: &[Complex64]) -> Self {
        let mut data = Vec::with_capacity(self.data.len());
        for (column, by) in self.data.chunks_exact(self.rows.max(1)).zip(right) {
            data.extend(column.iter().zip(left).map(|(x, y)| x * y * by));
        }
        Self { data, ..*self }
    }

    /// b ← A⁻¹ b.
    pub fn solve(&self, b: &mut Self) {
        self.factor().solve(b);
    }

    /// Factors for several solutions.
    #[must_use]
    pub fn factor(&self) -> Factors {
        Factors(PartialPivLu::new(self.view()))
    }

    /// A⁻¹ B.
    #[must_use]
    pub fn under(&self, mut b: Self) -> Self {
        self.solve(&mut b);
        b
    }

    /// A B⁻¹.
    #[must_use]
    pub fn over(&self, b: &Self) -> Self {
        b.transposed().under(self.transposed()).transposed()
    }

    /// Rows for columns.
    #[must_use]
    pub fn transposed(&self) -> Self {
        Self::from_fn(self.columns, self.rows, |i, k| self[(k, i)])
    }

    /// Eigenvalues and the matrix whose columns are the eigenvectors; `None` if they were not found.
    #[must_use]
    pub fn eigen(&self) -> Option<(Vec<Complex64>, Self)> {
        let pairs = self.view().eigen().ok()?;
        let values = pairs.S().column_vector().iter().copied().collect();
        let vectors = pairs.U();
        Some((values, Self::from_fn(self.rows, self.columns, |i, k| vectors[(i, k)])))
    }

    /// Whether every element is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.data.iter().all(|element| element.is_finite())
    }

    /// The matrices side by side, all with the same number of rows.
    #[must_use]
    pub fn beside<'a>(parts: impl Iterator<Item = &'a Self>) -> Self {
        let mut all = Self::zeros(0, 0);
        for part in parts {
            all.rows = part.rows;
            all.columns += part.columns;
            all.data.extend_from_slice(&part.data);
        }
        all
    }

    /// `rows`×`columns` elements from (row, column) on.
    #[must_use]
    pub fn block(&self, row: usize, column: usize, rows: usize, columns: usize) -> Self {
        let mut data = Vec::with_capacity(rows * columns);
        for k in column..column + columns {
            data.extend_from_slice(&self.column(k)[row..row + rows]);
        }
        Self { rows, columns, data }
    }
}

impl std::ops::Index<(usize, usize)> for Dense {
    type Output = Complex64;

    fn index(&self, (row, column): (usize, usize)) -> &Complex64 {
        &self.data[column * self.rows + row]
    }
}

impl std::ops::IndexMut<(usize, usize)> for Dense {
    fn index_mut(&mut self, (row, column): (usize, usize)) -> &mut Complex64 {
        &mut self.data[column * self.rows + row]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Dense {
        Dense::from_fn(5, 5, |i, k| {
            let (i, k) = (i as f64, k as f64);
            Complex64::new(
                (1.7 * i - 0.3 * k * i).sin() + if i == k { 3.0 } else { 0.0 },
                (i * k + 0.4 * k).cos(),
            )
        })
    }

    fn apart(a: &Dense, b: &Dense) -> f64 {
        (0..a.columns())
            .flat_map(|k| a.column(k).iter().zip(b.column(k)))
            .map(|(x, y)| (x - y).norm())
            .fold(0.0, f64::max)
    }

    #[test]
    fn quotients_give_back_what_was_multiplied() {
        let (a, b) = (example(), example().times(&example()));
        assert!(apart(&a.times(&a.under(b.clone())), &b) < 1e-13);
        assert!(apart(&b.over(&a).times(&a), &b) < 1e-13);
        assert!(apart(&a.under(a.clone()), &Dense::identity(5)) < 1e-14);
        let mut sum = Dense::identity(5);
        sum.add_product(&a, &b);
        assert!(apart(&sum, &a.times(&b).plus(&Dense::identity(5))) < 1e-12);
        assert!(a.is_finite() && !Dense::from_fn(1, 1, |_, _| Complex64::new(0.0, f64::NAN)).is_finite());
    }

    #[test]
    fn eigenvectors_are_stretched_alone() {
        let a = example();
        let (values, vectors) = a.eigen().unwrap();
        let stretched = Dense::from_fn(5, 5, |i, k| vectors[(i, k)] * values[k]);
        assert!(apart(&a.times(&vectors), &stretched) < 1e-12);
    }
}
