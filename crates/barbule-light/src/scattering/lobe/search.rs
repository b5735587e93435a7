//! Levenberg's and Marquardt's search for least squares of a few parameters, from normal equations.
//!
//! Scales are eliminated by projection (variable projection, Golub and Pereyra 1973) with Kaufman's approximation of the
//! Jacobian (1975), which leaves out the projection's own derivative; its gradient is exact. Then the equations of all
//! parameters follow from products of shapes, derivatives and targets, and no residual is ever formed.

use super::products::Products;

/// The squared error relative to that of no lobe at all, half its gradient, and the matrix of the normal equations.
#[derive(Debug, Clone, Copy)]
pub(super) struct Normal<const N: usize> {
    pub(super) error: f64,
    pub(super) gradient: [f64; N],
    pub(super) matrix: [[f64; N]; N],
}

/// When a search ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Relative change of the squared error.
    pub(super) error: f64,
    /// Change of the parameters.
    pub(super) step: f64,
    /// Evaluations, at most.
    pub(super) evaluations: usize,
}

/// Where a search ended.
#[derive(Debug, Clone, Copy)]
pub(super) struct Least<const N: usize, T> {
    pub(super) parameters: [f64; N],
    pub(super) error: f64,
    /// What the function said beside.
    pub(super) with: T,
    /// Whether it ended before it had to.
    pub(super) converged: bool,
}

/// A squared error is a difference of sums, which rounding leaves uncertain by so much of them.
const ROUNDING: f64 = 1e-13;

/// Cosine between residuals and columns below which no step would gain anything.
const FLAT: f64 = 1e-8;

/// Damping at the start, and the least.
const DAMPING: [f64; 2] = [1e-3, 1e-9];

/// Searches from `start`; `at` says what its equations are at parameters, and what else is to be known there.
pub(super) fn least<const N: usize, T: Copy>(
    start: [f64; N],
    limits: Limits,
    at: impl Fn([f64; N]) -> (Normal<N>, T),
) -> Least<N, T> {
    let (normal, with) = at(start);
    let mut here = Least { parameters: start, error: normal.error, with, converged: false };
    let mut normal = normal;
    let [mut damping, least_damping] = DAMPING;
    let mut growth = 2.0;
    // The largest so far, so that the measure of steps never shrinks.
    let mut scale = [0.0_f64; N];
    for _ in 1..limits.evaluations {
        let flat = |i: usize| {
            normal.gradient[i].abs() <= FLAT * (normal.matrix[i][i] * normal.error).max(0.0).sqrt()
        };
        if here.error <= ROUNDING || (0..N).all(flat) {
            return Least { converged: true, ..here };
        }
        let mut matrix = normal.matrix;
        for i in 0..N {
            scale[i] = scale[i].max(matrix[i][i]);
            // A parameter without effect stays where it is.
            matrix[i][i] += if scale[i] > 0.0 { damping * scale[i] } else { 1.0 };
        }
        let step = solved(matrix, normal.gradient.map(|g| -g));
        let foretold: f64 =
            (0..N).map(|i| step[i] * (damping * scale[i] * step[i] - normal.gradient[i])).sum();
        let parameters: [f64; N] = std::array::from_fn(|i| here.parameters[i] + step[i]);
        let (found, with) = at(parameters);
        let gained = here.error - found.error;
        let settled = |change: f64| change <= limits.error * here.error;
        let is_least = (settled(gained.abs()) && settled(foretold) && gained <= 2.0 * foretold.max(0.0))
            || step.iter().zip(parameters).all(|(step, at)| step.abs() <= limits.step * (1.0 + at.abs()));
        if gained > 1e-4 * foretold {
            let ratio = 2.0 * gained / foretold - 1.0;
            damping = (damping * (1.0 - ratio * ratio * ratio).max(1.0 / 3.0)).max(least_damping);
            growth = 2.0;
            here = Least { parameters, error: found.error, with, converged: false };
            normal = found;
        } else {
            damping *= growth;
            growth *= 2.0;
        }
        if is_least {
            return Least { converged: true, ..here };
        }
    }
    here
}

/// Solves the equations of a symmetric matrix that is positive, by its Cholesky factor.
fn solved<const N: usize>(mut matrix: [[f64; N]; N], mut right: [f64; N]) -> [f64; N] {
    for i in 0..N {
        for j in 0..=i {
            let inner: f64 = (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum();
            let rest = matrix[i][j] - inner;
            matrix[i][j] = if i == j { rest.max(f64::MIN_POSITIVE).sqrt() } else { rest / matrix[j][j] };
        }
        let inner: f64 = (0..i).map(|k| matrix[i][k] * right[k]).sum();
        right[i] = (right[i] - inner) / matrix[i][i];
    }
    for i in (0..N).rev() {
        let inner: f64 = (i + 1..N).map(|k| matrix[k][i] * right[k]).sum();
        right[i] = (right[i] - inner) / matrix[i][i];
    }
    right
}

/// The equations of one shape, each target with a scale ≥ 0 of its own; `chain` are the derivatives of ln m and φ_eff by the
/// parameters, `total` is the sum of the targets' squares. Beside it the scales.
pub(super) fn of_one<const V: usize>(
    products: &Products<3, V>,
    chain: [f64; 2],
    total: f64,
) -> (Normal<2>, [f64; V]) {
    let Products { gram, targets } = products;
    let square = gram[0][0];
    let scales = targets.map(|with| if with[0] > 0.0 && square > 0.0 { with[0] / square } else { 0.0 });
    let squares: f64 = scales.iter().map(|scale| scale * scale).sum();
    let explained: f64 = scales.iter().zip(targets).map(|(scale, with)| scale * with[0]).sum();
    // What the shape explains of a derivative is no slope.
    let part = [1, 2].map(|i| if square > 0.0 { gram[0][i] / square } else { 0.0 });
    let gradient = [0, 1].map(|i| {
        let along = |(scale, with): (&f64, &[f64; 3])| scale * (part[i] * with[0] - with[i + 1]);
        chain[i] * scales.iter().zip(targets).map(along).sum::<f64>() / total
    });
    let matrix = [0, 1].map(|i| {
        [0, 1].map(|j| {
            let rest = gram[i + 1][j + 1] - part[i] * gram[0][j + 1];
            chain[i] * chain[j] * squares * rest / total
        })
    });
    (Normal { error: ((total - explained) / total).max(0.0), gradient, matrix }, scales)
}

/// The equations of two shapes; `chain` by lobe. Beside it the scales.
pub(super) fn of_two(products: &Products<6, 1>, chain: [[f64; 2]; 2], total: f64) -> (Normal<4>, [f64; 2]) {
    let Products { gram, targets: [with] } = products;
    let shapes = [gram[0][0], gram[0][3], gram[3][3]];
    let scales = best_scales(shapes, [with[0], with[3]]);
    let active = scales.map(|scale| scale > 0.0);
    // Columns of the parameters, their factors, and what the shapes explain of them.
    let column = [1, 2, 4, 5];
    let factor: [f64; 4] = std::array::from_fn(|i| scales[i / 2] * chain[i / 2][i % 2]);
    let part = column.map(|c| weights(shapes, [gram[0][c], gram[3][c]], active));
    let gradient = std::array::from_fn(|i| {
        let c = column[i];
        factor[i] * (scales[0] * gram[0][c] + scales[1] * gram[3][c] - with[c]) / total
    });
    let matrix = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let (a, b) = (column[i], column[j]);
            let rest = gram[a][b] - part[i][0] * gram[0][b] - part[i][1] * gram[3][b];
            factor[i] * factor[j] * rest / total
        })
    });
    let explained = scales[0] * with[0] + scales[1] * with[3];
    (Normal { error: ((total - explained) / total).max(0.0), gradient, matrix }, scales)
}

/// Solves the normal equations of the active shapes; 0 for the others.
fn weights([a, b, c]: [f64; 3], [p, q]: [f64; 2], active: [bool; 2]) -> [f64; 2] {
    let determinant = a * c - b * b;
    match active {
        // Two shapes that are the same leave one scale.
        [true, true] if determinant > 1e-12 * a * c => {
            [(c * p - b * q) / determinant, (a * q - b * p) / determinant]
        }
        [true, _] => [p / a, 0.0],
        [false, true] => [0.0, q / c],
        [false, false] => [0.0, 0.0],
    }
}

/// Scales ≥ 0 of least squares, from the shapes' products with each other and with the values.
fn best_scales(gram: [f64; 3], products: [f64; 2]) -> [f64; 2] {
    let [a, _, c] = gram;
    let [p, q] = products;
    let both = weights(gram, products, [true, c > 0.0]);
    if both.iter().all(|scale| *scale > 0.0) {
        return both;
    }
    let explained = |product: f64, square: f64| {
        if product > 0.0 && square > 0.0 { product * product / square } else { 0.0 }
    };
    let (first, second) = (explained(p, a), explained(q, c));
    match (first > 0.0 || second > 0.0, first >= second) {
        (false, _) => [0.0, 0.0],
        (true, true) => [p / a, 0.0],
        (true, false) => [0.0, q / c],
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Holds a gradient to differences of the error.
    pub(in super::super) fn gradients_match<const N: usize, T: Copy>(
        place: [f64; N],
        tolerance: f64,
        at: impl Fn([f64; N]) -> (Normal<N>, T),
    ) {
        let gradient = at(place).0.gradient;
        for k in 0..N {
            let error = |step: f64| {
                let mut moved = place;
                moved[k] += step;
                0.5 * at(moved).0.error
            };
            let expected = (error(1e-5) - error(-1e-5)) / 2e-5;
            assert!((gradient[k] - expected).abs() < tolerance, "{k}: {} {expected}", gradient[k]);
        }
    }

    #[test]
    fn equations_are_solved() {
        let matrix = [[4.0, 1.0, 0.5], [1.0, 3.0, -0.2], [0.5, -0.2, 2.0]];
        let wanted = [0.3, -1.0, 2.0];
        let right = matrix.map(|row| row.iter().zip(wanted).map(|(a, b)| a * b).sum());
        let found = solved(matrix, right);
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-14), "{found:?}");
    }

    /// Rosenbrock's valley as residuals 10 (y − x²) and 1 − x.
    #[test]
    fn a_bent_valley_is_followed_to_its_end() {
        let at = |[x, y]: [f64; 2]| {
            let rows = [(10.0 * (y - x * x), [-20.0 * x, 10.0]), (1.0 - x, [-1.0, 0.0])];
            let error = rows.iter().map(|(r, _)| r * r).sum();
            let gradient = [0, 1].map(|i| rows.iter().map(|(r, row)| r * row[i]).sum());
            let matrix = [0, 1].map(|i| [0, 1].map(|j| rows.iter().map(|(_, row)| row[i] * row[j]).sum()));
            (Normal { error, gradient, matrix }, ())
        };
        let limits = Limits { error: 1e-9, step: 1e-9, evaluations: 100 };
        let found = least([-1.2, 1.0], limits, at);
        let [x, y] = found.parameters;
        assert!(found.converged && (x - 1.0).abs() < 1e-5 && (y - 1.0).abs() < 1e-5, "{found:?}");
        let stopped = least([-1.2, 1.0], Limits { evaluations: 3, ..limits }, at);
        assert!(!stopped.converged && stopped.error <= at([-1.2, 1.0]).0.error, "{stopped:?}");
    }
}
