//! Chebyshev series from values at their nodes, cut where the rest is negligible.
//!
//! Σ_k c_k T_k(x) on \[−1, 1\] with c_k = (2 − δ_k0)/n Σ_j f_j cos(πk(j + ½)/n) from the values f_j at the n nodes
//! cos(π(j + ½)/n). Values and coefficients are rows of as many numbers as are wanted at once.

use std::cmp::Ordering;
use std::f64::consts::PI;
use std::ops::AddAssign;

/// cos(πm/2n), m = 0 … 4n − 1: node j is that of 2j + 1, and the weight of sample j in coefficient k that of k(2j + 1)
/// modulo 4n.
#[must_use]
pub fn cosines(n: usize) -> Vec<f64> {
    (0..4 * n).map(|m| (PI * m as f64 / (2 * n) as f64).cos()).collect()
}

/// The n nodes, falling.
pub fn nodes(n: usize) -> impl Iterator<Item = f64> {
    (0..n).map(move |j| (PI * (2 * j + 1) as f64 / (2 * n) as f64).cos())
}

/// Coefficients `[term][row]` from values `[node][row]`.
#[must_use]
pub fn coefficients(samples: &[f64], row: usize) -> Vec<f64> {
    let count = samples.len() / row;
    let cosines = cosines(count);
    let mut terms = vec![0.0; samples.len()];
    for (j, sample) in samples.chunks_exact(row).enumerate() {
        for (k, term) in terms.chunks_exact_mut(row).enumerate() {
            let weight = if k == 0 { 1.0 } else { 2.0 } / count as f64;
            let cosine = cosines[k * (2 * j + 1) % (4 * count)];
            for (sum, value) in term.iter_mut().zip(sample) {
                *sum += weight * value * cosine;
            }
        }
    }
    terms
}

/// How many terms to keep so that what is left out stays below `tolerance`, from the largest coefficient of each term;
/// `None` if the series has not settled (or is not finite).
pub fn needed<T: Copy + Default + PartialOrd + AddAssign>(
    largest: impl DoubleEndedIterator<Item = T> + ExactSizeIterator,
    tolerance: T,
) -> Option<usize> {
    let count = largest.len();
    let mut rest = T::default();
    let mut kept = count;
    for most in largest.rev() {
        rest += most;
        // Also where the rest is not a number.
        if rest.partial_cmp(&tolerance).is_none_or(Ordering::is_gt) {
            break;
        }
        kept -= 1;
    }
    // The last terms stand for all that were not computed, so some must be negligible.
    (kept + 2 <= count).then_some(kept.max(1))
}

/// Adds the series of coefficients `[term][row]` at `x` to a row of sums.
pub fn add_at(coefficients: &[f64], x: f64, sums: &mut [f64]) {
    let (mut before, mut now) = (x, 1.0);
    for term in coefficients.chunks_exact(sums.len()) {
        for (sum, c) in sums.iter_mut().zip(term) {
            *sum += c * now;
        }
        (before, now) = (now, 2.0 * x * now - before);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_of_smooth_functions_settle_and_give_them_back() {
        let functions = |x: f64| [(1.3 * x).exp(), 1.0 / (2.0 + x)];
        let samples: Vec<f64> = nodes(30).flat_map(functions).collect();
        let terms = coefficients(&samples, 2);
        let largest = terms.chunks_exact(2).map(|term| term[0].abs().max(term[1].abs()));
        let kept = needed(largest, 1e-9).unwrap();
        assert!((10..24).contains(&kept), "{kept}");
        for x in [-1.0, -0.3, 0.0, 0.77, 1.0] {
            let mut found = [0.0; 2];
            add_at(&terms[..2 * kept], x, &mut found);
            for (a, b) in found.iter().zip(functions(x)) {
                assert!((a - b).abs() < 1e-9, "{x}: {a} {b}");
            }
        }
    }

    #[test]
    fn series_that_have_not_settled_are_none() {
        assert_eq!(needed([1.0, 0.5, 0.25, 1e-12].into_iter(), 1e-9), None);
        assert_eq!(needed([1.0, 0.5, f64::NAN, 1e-12, 1e-12].into_iter(), 1e-9), Some(3));
        assert_eq!(needed([1e-12f32, 0.0, 0.0].into_iter(), 1e-9), Some(1));
    }
}
