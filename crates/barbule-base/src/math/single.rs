//! Dense complex matrices held in single precision, for factors that are only right to less than that anyway.

use faer::linalg::matmul::matmul;
use faer::linalg::solvers::{Qr, Svd};
use faer::{Accum, Mat, MatMut, MatRef, Par};
use num_complex::{Complex32, Complex64};

use super::dense::Dense;

/// Rows that are multiplied in single precision; sums over more are in double precision.
const ROWS: usize = 1024;

/// A complex matrix in single precision whose columns follow one another. What it is multiplied with is in double precision.
#[derive(Debug, Clone)]
pub(super) struct Single {
    rows: usize,
    columns: usize,
    data: Vec<Complex32>,
}

/// To the nearest number of single precision.
pub(super) fn rounded(value: Complex64) -> Complex32 {
    Complex32::new(value.re as f32, value.im as f32)
}

/// The same number in double precision.
pub(super) fn exact(value: Complex32) -> Complex64 {
    Complex64::new(f64::from(value.re), f64::from(value.im))
}

/// Blocks of rows: where each starts, and how many it has.
fn blocks(rows: usize, most: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..rows).step_by(most).map(move |from| (from, most.min(rows - from)))
}

impl Single {
    /// How many rows it has.
    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    /// How many columns it has.
    pub(super) fn columns(&self) -> usize {
        self.columns
    }

    /// All elements, column by column.
    pub(super) fn elements_mut(&mut self) -> &mut [Complex32] {
        &mut self.data
    }

    /// Bytes of its elements.
    pub(super) fn bytes(&self) -> u64 {
        size_of_val(&self.data[..]) as u64
    }

    fn view(&self) -> MatRef<'_, Complex32> {
        MatRef::from_column_major_slice(&self.data, self.rows, self.columns)
    }

    /// Aᵀ·B, without conjugation.
    pub(super) fn transposed_times(&self, b: &Dense) -> Dense {
        let mut product = Dense::zeros(self.columns, b.columns());
        let mut few = Vec::with_capacity(ROWS * b.columns());
        for (from, count) in blocks(self.rows, ROWS) {
            few.clear();
            for k in 0..b.columns() {
                few.extend(b.column(k)[from..from + count].iter().map(|&value| rounded(value)));
            }
            let few = MatRef::from_column_major_slice(&few, count, b.columns());
            self.add_transposed(from, few, &mut product);
        }
        product
    }

    /// Aᵀ·B, without conjugation.
    pub(super) fn transposed_times_single(&self, b: &Self) -> Dense {
        let mut product = Dense::zeros(self.columns, b.columns);
        for (from, count) in blocks(self.rows, ROWS) {
            self.add_transposed(from, b.view().subrows(from, count), &mut product);
        }
        product
    }

    /// Adds Aᵀ·B of the rows from one on.
    fn add_transposed(&self, from: usize, b: MatRef<'_, Complex32>, product: &mut Dense) {
        let mut part = vec![Complex32::ZERO; self.columns * b.ncols()];
        matmul(
            MatMut::from_column_major_slice_mut(&mut part, self.columns, b.ncols()),
            Accum::Replace,
            self.view().subrows(from, b.nrows()).transpose(),
            b,
            Complex32::ONE,
            Par::Seq,
        );
        product.elements_mut().iter_mut().zip(&part).for_each(|(sum, &value)| *sum += exact(value));
    }

    /// b ← b − A·C.
    pub(super) fn take_product_from(&self, c: &Dense, b: &mut Dense) {
        let factor: Vec<Complex32> = c.elements().iter().map(|&value| rounded(value)).collect();
        let factor = MatRef::from_column_major_slice(&factor, c.rows(), c.columns());
        let mut part = vec![Complex32::ZERO; ROWS.min(self.rows) * c.columns()];
        for (from, count) in blocks(self.rows, ROWS) {
            let part = &mut part[..count * c.columns()];
            matmul(
                MatMut::from_column_major_slice_mut(part, count, c.columns()),
                Accum::Replace,
                self.view().subrows(from, count),
                factor,
                Complex32::ONE,
                Par::Seq,
            );
            for (k, column) in part.chunks_exact(count).enumerate() {
                let left = &mut b.column_mut(k)[from..from + count];
                left.iter_mut().zip(column).for_each(|(left, &value)| *left -= exact(value));
            }
        }
    }
}

/// A·C rounded, with sums in double precision.
fn product(a: &Dense, c: &Dense) -> Single {
    let rows = a.rows();
    let mut data = vec![Complex32::ZERO; rows * c.columns()];
    for (from, count) in blocks(rows, ROWS) {
        let part = a.block(from, 0, count, a.columns()).times(c);
        for (k, column) in data.chunks_exact_mut(rows).enumerate() {
            let to = column[from..from + count].iter_mut();
            to.zip(part.column(k)).for_each(|(to, &value)| *to = rounded(value));
        }
    }
    Single { rows, columns: c.columns(), data }
}

/// The triangular factor R of A = QR, block of rows by block of rows.
fn triangle(a: &Dense) -> Mat<Complex64> {
    let columns = a.columns();
    let mut above = Mat::<Complex64>::zeros(0, columns);
    for (from, count) in blocks(a.rows(), (4 * columns).max(ROWS)) {
        let kept = above.nrows();
        let whole = Mat::from_fn(kept + count, columns, |i, k| {
            if i < kept { above[(i, k)] } else { a[(from + i - kept, k)] }
        });
        above = Qr::new(whole.as_ref()).thin_R().to_owned();
        for k in 0..above.ncols() {
            for i in k + 1..above.nrows() {
                above[(i, k)] = Complex64::ZERO;
            }
        }
    }
    above
}

/// All of a matrix, rounded.
fn single(a: &Dense) -> Single {
    let data = a.elements().iter().map(|&value| rounded(value)).collect();
    Single { rows: a.rows(), columns: a.columns(), data }
}

/// U·Vᵀ with as few columns as it needs to be off by at most `tolerance` (root of the sum of all squares): QR of both, and the
/// singular values of the product of their triangles (Bebendorf 2008, section 1.1.5). As they are if these are not found.
pub(super) fn compressed(u: &Dense, v: &Dense, tolerance: f64) -> [Single; 2] {
    if u.columns() == 0 {
        return [single(u), single(v)];
    }
    let (r_u, r_v) = (triangle(u), triangle(v));
    let Ok(svd) = Svd::new_thin((&r_u * r_v.transpose()).as_ref()) else {
        return [single(u), single(v)];
    };
    let values: Vec<f64> = svd.S().column_vector().iter().map(|value| value.re).collect();
    let mut rank = values.len();
    let mut left = 0.0;
    while rank > 0 && left + values[rank - 1].powi(2) <= tolerance.powi(2) {
        rank -= 1;
        left += values[rank].powi(2);
    }
    // With R_u R_vᵀ = X S Yᴴ: Q_u X S = U R_vᵀ Y, and Q_v Y* = V R_uᵀ X* S⁻¹.
    let wide = r_v.transpose() * svd.V().subcols(0, rank);
    let unit = r_u.transpose() * svd.U().subcols(0, rank).conjugate();
    let columns = u.columns();
    let wide = Dense::from_fn(columns, rank, |i, k| wide[(i, k)]);
    let unit = Dense::from_fn(columns, rank, |i, k| unit[(i, k)] / values[k]);
    [product(u, &wide), product(v, &unit)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(rows: usize, columns: usize, step: f64) -> Dense {
        Dense::from_fn(rows, columns, |i, k| {
            let x = i as f64 / rows as f64 - 0.5;
            Complex64::from_polar(step.powi(k as i32), (k as f64 + 1.0) * x * 9.0 + 2.0 * x * x)
        })
    }

    fn double(a: &Single) -> Dense {
        Dense::from_columns(a.rows, a.data.iter().map(|&value| exact(value)).collect())
    }

    fn apart(a: &Dense, b: &Dense) -> f64 {
        a.elements().iter().zip(b.elements()).map(|(x, y)| (x - y).norm_sqr()).sum::<f64>().sqrt()
    }

    #[test]
    fn products_are_those_of_double_precision_but_for_rounding() {
        let (a, b, c) = (wave(2500, 7, 0.9), wave(2500, 5, 0.8), wave(7, 5, 0.9));
        let size = apart(&a, &Dense::zeros(2500, 7));
        let error = apart(&single(&a).transposed_times(&b), &a.transposed_times(&b));
        assert!(error < 1e-6 * size * size, "{error:e}");
        let (mut expected, mut found) = (b.clone(), b.clone());
        let minus_a = Dense::from_columns(2500, a.elements().iter().map(|value| -value).collect());
        expected.add_product(&minus_a, &c);
        single(&a).take_product_from(&c, &mut found);
        let error = apart(&expected, &found);
        assert!(error > 0.0 && error < 1e-6 * size * size, "{error:e}");
    }

    #[test]
    fn thinner_products_are_off_by_the_tolerance_at_most_and_not_by_much_less() {
        // Columns that nearly depend on each other, more of them than the product has rows.
        for (rows, columns) in [(3000, 40), (30, 40)] {
            let (u, v) = (wave(rows, columns, 0.8), wave(50, columns, 0.7));
            let whole = u.times(&v.transposed());
            let mut ranks = Vec::new();
            for tolerance in [1e-1, 1e-3] {
                let [a, b] = compressed(&u, &v, tolerance);
                assert_eq!(a.columns(), b.columns());
                ranks.push(a.columns());
                let product = double(&a).times(&double(&b).transposed());
                let error = apart(&whole, &product);
                assert!(error < 1.1 * tolerance && error > 0.05 * tolerance, "{error:e} at {tolerance:e}");
            }
            assert!(ranks[0] < ranks[1] && ranks[1] < 25, "{ranks:?}");
        }
        let nothing = compressed(&Dense::zeros(4, 0), &Dense::zeros(3, 0), 1e-3);
        assert_eq!(nothing.map(|part| part.columns()), [0, 0]);
    }
}
