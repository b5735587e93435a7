//! Densities over the unit square, bilinear between the points of a grid, one for each node of up to two parameters: evaluated, sampled
//! and inverted between nodes too, where the density is the mean of theirs.

use crate::{Error, Result};

/// Nodes of the parameters about a place, each with its weight; the weights' sum is 1.
pub type Nodes = [(usize, f64); 4];

/// Densities over the unit square. Points lie on its borders too; rows are the first coordinate, and are drawn first.
#[derive(Debug, Clone, PartialEq)]
pub struct Warp {
    rows: usize,
    columns: usize,
    /// `[node][row][column]`, each node's of integral 1.
    density: Vec<f32>,
    /// The integral along each row up to each column.
    along: Vec<f32>,
    /// The integral over all rows up to each: `[node][row]`.
    before: Vec<f32>,
}

impl Warp {
    /// From values `[node][row][column]` of any scale.
    ///
    /// # Errors
    /// Fewer than two rows or columns, not a whole number of nodes, a value that is negative or not finite, or a node that is zero
    /// everywhere.
    pub fn new([rows, columns]: [usize; 2], mut density: Vec<f32>) -> Result<Self> {
        let per_node = rows.saturating_mul(columns);
        if rows < 2 || columns < 2 || density.is_empty() || !density.len().is_multiple_of(per_node) {
            return Err(Error::input(format!(
                "a density of {rows} × {columns} points has {} values",
                density.len()
            )));
        }
        if density.iter().any(|value| !value.is_finite() || *value < 0.0) {
            return Err(Error::input("a density has a value that is negative or not finite"));
        }
        let (mut along, mut before) = (Vec::with_capacity(density.len()), Vec::new());
        for node in density.chunks_exact_mut(per_node) {
            let (mut rows_of, mut own) = (Vec::with_capacity(rows), Vec::with_capacity(per_node));
            for row in node.chunks_exact(columns) {
                rows_of.push(*cumulative(row.iter().copied(), &mut own).last().unwrap_or(&0.0));
            }
            let mut sums = Vec::with_capacity(rows);
            let whole = *cumulative(rows_of.iter().map(|v| *v as f32), &mut sums).last().unwrap_or(&0.0);
            if whole <= 0.0 {
                return Err(Error::input("a density is zero everywhere"));
            }
            node.iter_mut().for_each(|value| *value = (f64::from(*value) / whole) as f32);
            along.extend(own.iter().map(|v| (v / whole) as f32));
            before.extend(sums.iter().map(|v| (v / whole) as f32));
        }
        Ok(Self { rows, columns, density, along, before })
    }

    /// How many nodes it has.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.density.len() / (self.rows * self.columns)
    }

    /// Memory, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        4 * (self.density.len() + self.along.len() + self.before.len())
    }

    /// The density at a place.
    #[inline]
    #[must_use]
    pub fn density(&self, nodes: &Nodes, place: [f64; 2]) -> f64 {
        let ((row, a), (column, b)) = (cell(place[0], self.rows), cell(place[1], self.columns));
        let [low, high] = self.corners(&self.density, nodes, row, column);
        lerp(lerp(low[0], high[0], a), lerp(low[1], high[1], a), b)
    }

    /// The place that two uniform numbers become, and the density there.
    #[inline]
    #[must_use]
    pub fn sample(&self, nodes: &Nodes, u: [f64; 2]) -> ([f64; 2], f64) {
        let width = 1.0 / (self.rows - 1) as f64;
        let before = |row: usize| self.of_row(&self.before, nodes, row);
        let wanted = u[0].clamp(0.0, 1.0) * before(self.rows - 1);
        let row = last_below(self.rows, wanted, before);
        let total = |row: usize| self.of_row_end(nodes, row);
        let a = inverse([total(row), total(row + 1)], (wanted - before(row)) / width);
        let along = |column: usize| {
            let [low, high] = self.column(&self.along, nodes, row, column);
            lerp(low, high, a)
        };
        let width = 1.0 / (self.columns - 1) as f64;
        let wanted = u[1].clamp(0.0, 1.0) * along(self.columns - 1);
        let column = last_below(self.columns, wanted, along);
        let [low, high] = self.corners(&self.density, nodes, row, column);
        let ends = [lerp(low[0], high[0], a), lerp(low[1], high[1], a)];
        let b = inverse(ends, (wanted - along(column)) / width);
        let place =
            [(row as f64 + a) / (self.rows - 1) as f64, (column as f64 + b) / (self.columns - 1) as f64];
        (place, lerp(ends[0], ends[1], b))
    }

    /// The uniform numbers that become a place, and the density there.
    #[inline]
    #[must_use]
    pub fn invert(&self, nodes: &Nodes, place: [f64; 2]) -> ([f64; 2], f64) {
        let ((row, a), (column, b)) = (cell(place[0], self.rows), cell(place[1], self.columns));
        let part =
            |[low, high]: [f64; 2], t: f64, cells: usize| t * (low + 0.5 * t * (high - low)) / cells as f64;
        let totals = [self.of_row_end(nodes, row), self.of_row_end(nodes, row + 1)];
        let whole = self.of_row(&self.before, nodes, self.rows - 1);
        let first = self.of_row(&self.before, nodes, row) + part(totals, a, self.rows - 1);
        let [low, high] = self.corners(&self.density, nodes, row, column);
        let ends = [lerp(low[0], high[0], a), lerp(low[1], high[1], a)];
        let [low, high] = self.column(&self.along, nodes, row, column);
        let second = lerp(low, high, a) + part(ends, b, self.columns - 1);
        let row_total = lerp(totals[0], totals[1], a);
        let share = |part: f64, whole: f64| if whole > 0.0 { (part / whole).clamp(0.0, 1.0) } else { 0.0 };
        ([share(first, whole), share(second, row_total)], lerp(ends[0], ends[1], b))
    }

    /// The integral along a row.
    #[inline]
    fn of_row_end(&self, nodes: &Nodes, row: usize) -> f64 {
        let at = row * self.columns + self.columns - 1;
        weighted(nodes, |node| self.along[node * self.rows * self.columns + at])
    }

    #[inline]
    fn of_row(&self, values: &[f32], nodes: &Nodes, row: usize) -> f64 {
        weighted(nodes, |node| values[node * self.rows + row])
    }

    /// A column's values in a row and the next.
    #[inline]
    fn column(&self, values: &[f32], nodes: &Nodes, row: usize, column: usize) -> [f64; 2] {
        let at = row * self.columns + column;
        let of = |at: usize| weighted(nodes, |node| values[node * self.rows * self.columns + at]);
        [of(at), of(at + self.columns)]
    }

    /// Values of a cell: `[row][column]`.
    #[inline]
    fn corners(&self, values: &[f32], nodes: &Nodes, row: usize, column: usize) -> [[f64; 2]; 2] {
        let [a, b] = self.column(values, nodes, row, column);
        let [c, d] = self.column(values, nodes, row, column + 1);
        [[a, c], [b, d]]
    }
}

/// Σ w v over the nodes that count.
#[inline]
fn weighted(nodes: &Nodes, value: impl Fn(usize) -> f32) -> f64 {
    nodes.iter().filter(|(_, w)| *w > 0.0).map(|(node, w)| w * f64::from(value(*node))).sum()
}

#[inline]
pub(super) fn lerp(low: f64, high: f64, t: f64) -> f64 {
    low + (high - low) * t
}

/// The cell of `points` that lie evenly on 0 … 1, and where in it.
#[inline]
pub(super) fn cell(place: f64, points: usize) -> (usize, f64) {
    let at = place.clamp(0.0, 1.0) * (points - 1) as f64;
    let low = (at as usize).min(points - 2);
    (low, at - low as f64)
}

/// Sums by trapezoids of values that lie evenly on 0 … 1, added to `to`; what was added is returned.
fn cumulative(values: impl ExactSizeIterator<Item = f32>, to: &mut Vec<f64>) -> &[f64] {
    let (from, width) = (to.len(), 1.0 / (values.len() - 1) as f64);
    let (mut sum, mut last) = (0.0, None);
    for value in values.map(f64::from) {
        sum += last.map_or(0.0, |last: f64| 0.5 * (last + value) * width);
        last = Some(value);
        to.push(sum);
    }
    &to[from..]
}

/// The last of the first `count` − 1 places whose rising value is not over what is wanted.
#[inline]
fn last_below(count: usize, wanted: f64, value: impl Fn(usize) -> f64) -> usize {
    let (mut low, mut high) = (0, count - 1);
    while high - low > 1 {
        let middle = usize::midpoint(low, high);
        if value(middle) <= wanted { low = middle } else { high = middle }
    }
    low
}

/// t of 0 … 1 up to which the line between two densities has an integral.
#[inline]
fn inverse([low, high]: [f64; 2], integral: f64) -> f64 {
    let root = (low * low + 2.0 * (high - low) * integral.max(0.0)).max(0.0).sqrt();
    if low + root > 0.0 { (2.0 * integral / (low + root)).clamp(0.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn warp() -> Warp {
        let value = |i: usize| ((i * 7919) % 23) as f32 * 0.3 + if i.is_multiple_of(5) { 0.0 } else { 0.2 };
        Warp::new([5, 7], (0..4 * 35).map(value).collect()).unwrap()
    }

    const NODES: Nodes = [(0, 0.1), (1, 0.4), (2, 0.3), (3, 0.2)];

    /// Places and numbers are each other's, and the density is what numbers crowd by.
    #[test]
    fn samples_are_inverted_and_as_dense_as_is_said() {
        let warp = warp();
        let (n, step) = (40, 1e-5);
        for i in 0..n * n {
            let u = [(i % n) as f64, (i / n) as f64].map(|v| (v + 0.5) / n as f64);
            let (place, density) = warp.sample(&NODES, u);
            let (back, again) = warp.invert(&NODES, place);
            assert!((back[0] - u[0]).abs() < 1e-5 && (back[1] - u[1]).abs() < 1e-5, "{u:?} {back:?}");
            assert!(
                (density - again).abs() < 1e-5 * density
                    && (density - warp.density(&NODES, place)).abs() < 1e-9
            );
            // Rows do not depend on the second number, so the determinant is a product.
            let moved = warp.sample(&NODES, [u[0] + step, u[1]]).0[0] - place[0];
            let along = warp.sample(&NODES, [u[0], u[1] + step]).0[1] - place[1];
            let measured = step * step / (moved * along);
            assert!((measured / density - 1.0).abs() < 0.05, "{u:?}: {measured} {density}");
        }
    }

    #[test]
    fn what_is_no_density_is_refused() {
        assert!(Warp::new([1, 4], vec![1.0; 4]).is_err());
        assert!(Warp::new([2, 2], vec![1.0; 5]).is_err());
        assert!(Warp::new([2, 2], vec![1.0, 1.0, -1.0, 1.0]).is_err());
        assert!(Warp::new([2, 2], vec![0.0; 4]).unwrap_err().to_string().contains("zero everywhere"));
    }
}
