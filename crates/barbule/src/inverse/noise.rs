//! Errors of measured spectra, which are alike at neighbouring wavelengths.
//!
//! Their covariance is σ²·(w·δ_ij + (1 − w)·exp(−|λ_i − λ_j|/ℓ)): a part w that differs from sample to sample, as of a detector, and
//! one with a correlation length ℓ, as of smoothing, of a drifting lamp, and of what a model leaves out. [`Whitening`] turns it into
//! the unit matrix by the innovations of a Kalman filter, in a time proportional to the samples; w and ℓ follow from residuals by
//! restricted maximum likelihood, which allows for the parameters that were fitted.

use super::small::{cholesky, inverse, log_determinant, solve};

/// What is known of the errors of one measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation of one sample, reflectance.
    pub sigma: f64,
    /// The distance at which the correlated part has fallen to 1/e; 0: all samples are independent.
    pub correlation_nm: f64,
    /// The part of the variance that is independent from sample to sample.
    pub white: f64,
}

impl Noise {
    /// Independent errors of this standard deviation.
    pub(super) fn independent(sigma: f64) -> Self {
        Self { sigma, correlation_nm: 0.0, white: 0.0 }
    }

    /// As many independent samples tell their variance as well as those at these wavelengths: n/(1 + 2 Σ ρ_k²), with the correlation
    /// ρ_k of samples k apart.
    pub(super) fn independent_samples(&self, nm: &[f64]) -> f64 {
        let count = nm.len() as f64;
        if self.correlation_nm <= 0.0 {
            return count;
        }
        let step = (nm[nm.len() - 1] - nm[0]) / (count - 1.0);
        let squared = (-2.0 * step / self.correlation_nm).exp();
        count / (1.0 + 2.0 * (1.0 - self.white).powi(2) * squared / (1.0 - squared))
    }
}

/// Makes errors of a covariance independent and of unit size, relative to σ.
#[derive(Debug, Clone)]
pub(super) struct Whitening {
    /// For each sample: the gain, one over the innovation's deviation, and the correlation with the next sample.
    steps: Vec<[f64; 3]>,
    /// Logarithm of the determinant of the correlation matrix.
    log_determinant: f64,
}

impl Whitening {
    /// For samples at rising wavelengths.
    pub(super) fn new(nm: &[f64], correlation_nm: f64, white: f64) -> Self {
        let smooth = 1.0 - white;
        let mut uncertain = smooth;
        let mut all = Self { steps: Vec::with_capacity(nm.len()), log_determinant: 0.0 };
        for (i, at) in nm.iter().enumerate() {
            let variance = uncertain + white;
            let gain = uncertain / variance;
            let kept = match nm.get(i + 1) {
                Some(next) if correlation_nm > 0.0 => (-(next - at) / correlation_nm).exp(),
                _ => 0.0,
            };
            all.steps.push([gain, variance.sqrt().recip(), kept]);
            all.log_determinant += variance.ln();
            uncertain = kept * kept * uncertain * (1.0 - gain) + (1.0 - kept * kept) * smooth;
        }
        all
    }

    /// Replaces a column of samples by its independent innovations.
    pub(super) fn apply(&self, column: &mut [f64]) {
        let mut expected = 0.0;
        for (value, [gain, scale, kept]) in column.iter_mut().zip(&self.steps) {
            let innovation = *value - expected;
            expected = kept * (expected + gain * innovation);
            *value = innovation * scale;
        }
    }
}

/// Parts of independent errors that are tried.
const WHITE: [f64; 6] = [0.0, 0.1, 0.3, 0.5, 0.7, 0.9];

/// The errors of one measurement, and how far they are known.
#[derive(Debug, Clone, Copy)]
pub(super) struct Likeliest {
    pub(super) noise: Noise,
    /// By what the variance of sizes is larger than under these errors, since others are nearly as likely.
    pub(super) caution: f64,
}

/// A covariance that was tried.
struct Tried {
    noise: Noise,
    /// −2 times the logarithm of its restricted likelihood.
    unlikely: f64,
    /// How many candidates it stands for.
    times: f64,
    /// The estimate of each size, and its variance.
    sizes: Vec<[f64; 2]>,
}

/// The covariance under which `values` less a combination of `columns` is likeliest, by restricted maximum likelihood
/// (Patterson and Thompson, Biometrika 58 (1971) 545) over a grid of correlation lengths up to a third of the range, and what the others,
/// each as likely as it is, add to the variance of the sizes: the last `sizes` columns. Columns that others contain must not be
/// among them.
pub(super) fn likeliest(nm: &[f64], values: &[f64], columns: &[Vec<f64>], sizes: usize) -> Option<Likeliest> {
    let count = nm.len();
    let range = nm[count - 1] - nm[0];
    let step = range / (count - 1).max(1) as f64;
    let lengths = (0..).map(|k| step * 0.5 * 2.0_f64.powi(k)).take_while(|length| *length <= range / 3.0);
    let correlated = lengths.flat_map(|length| WHITE.map(|white| (length, white, 1.0)));
    // Independent errors stand for all parts that are.
    let grid = std::iter::once((0.0, 0.0, WHITE.len() as f64)).chain(correlated);
    let tried: Vec<Tried> = grid
        .filter_map(|(length, white, times)| tried(nm, values, columns, sizes, (length, white, times)))
        .collect();
    let best = tried.iter().min_by(|a, b| a.unlikely.total_cmp(&b.unlikely))?;
    let weights: Vec<f64> =
        tried.iter().map(|one| one.times * (0.5 * (best.unlikely - one.unlikely)).exp()).collect();
    let whole: f64 = weights.iter().sum();
    let mean = |of: &dyn Fn(&Tried) -> f64| -> f64 {
        tried.iter().zip(&weights).map(|(one, weight)| weight * of(one)).sum::<f64>() / whole
    };
    let caution = |k: usize| {
        let middle = mean(&|one| one.sizes[k][0]);
        let total = mean(&|one| one.sizes[k][1] + (one.sizes[k][0] - middle).powi(2));
        total / best.sizes[k][1]
    };
    let caution =
        (0..sizes).map(caution).filter(|ratio| ratio.is_finite()).sum::<f64>() / sizes.max(1) as f64;
    Some(Likeliest { noise: best.noise, caution: caution.max(1.0) })
}

/// One covariance; none where the columns are not independent under it.
fn tried(
    nm: &[f64],
    values: &[f64],
    columns: &[Vec<f64>],
    sizes: usize,
    (correlation_nm, white, times): (f64, f64, f64),
) -> Option<Tried> {
    let whitening = Whitening::new(nm, correlation_nm, white);
    let whitened = |column: &[f64]| {
        let mut column = column.to_vec();
        whitening.apply(&mut column);
        column
    };
    let (values, columns) = (whitened(values), columns.iter().map(|c| whitened(c)).collect::<Vec<_>>());
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let size = columns.len();
    let matrix: Vec<f64> = columns.iter().flat_map(|a| columns.iter().map(|b| product(a, b))).collect();
    let factor = cholesky(&matrix, size)?;
    let mut combination: Vec<f64> = columns.iter().map(|column| product(column, &values)).collect();
    solve(&factor, &mut combination);
    let residual = |i: usize| {
        let fitted: f64 = columns.iter().zip(&combination).map(|(column, c)| column[i] * c).sum();
        values[i] - fitted
    };
    let squares: f64 = (0..values.len()).map(|i| residual(i).powi(2)).sum();
    let freedom = (values.len() - size) as f64;
    let variance = squares / freedom;
    let unlikely = freedom * squares.max(f64::MIN_POSITIVE).ln()
        + whitening.log_determinant
        + log_determinant(&factor, size);
    let inverse = inverse(&matrix, size)?;
    let sizes = (size - sizes..size).map(|k| [combination[k], variance * inverse[k * size + k]]).collect();
    Some(Tried { noise: Noise { sigma: variance.sqrt(), correlation_nm, white }, unlikely, times, sizes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Stream;

    #[test]
    fn whitening_is_a_factor_of_the_inverse_covariance() {
        let nm = [300.0, 304.0, 309.0, 320.0, 321.0];
        let (length, white) = (7.0, 0.3);
        let covariance: Vec<f64> = nm
            .iter()
            .flat_map(|a| {
                nm.iter().map(move |b| {
                    let own = if a == b { white } else { 0.0 };
                    own + (1.0 - white) * (-(a - b as &f64).abs() / length).exp()
                })
            })
            .collect();
        let exact = inverse(&covariance, 5).unwrap();
        let whitening = Whitening::new(&nm, length, white);
        let columns: Vec<Vec<f64>> = (0..5)
            .map(|k| {
                let mut unit = vec![0.0; 5];
                unit[k] = 1.0;
                whitening.apply(&mut unit);
                unit
            })
            .collect();
        for a in 0..5 {
            for b in 0..5 {
                let product: f64 = (0..5).map(|i| columns[a][i] * columns[b][i]).sum();
                assert!((product - exact[a * 5 + b]).abs() < 1e-12, "{a} {b}");
            }
        }
        let factor = cholesky(&covariance, 5).unwrap();
        assert!((whitening.log_determinant - log_determinant(&factor, 5)).abs() < 1e-12);
    }

    #[test]
    fn the_correlation_of_drawn_errors_is_found_again() {
        let nm: Vec<f64> = (0..161).map(|k| 300.0 + 2.5 * f64::from(k)).collect();
        let ones = vec![vec![1.0; nm.len()]];
        let mut found = Vec::new();
        for seed in 0..30 {
            let mut stream = Stream::new(seed, &[5]);
            let mut smooth = stream.normal();
            let kept = (-2.5_f64 / 20.0).exp();
            let values: Vec<f64> = nm
                .iter()
                .map(|_| {
                    smooth = kept * smooth + (1.0 - kept * kept).sqrt() * stream.normal();
                    0.5 + 0.01 * smooth
                })
                .collect();
            found.push(likeliest(&nm, &values, &ones, 0).unwrap().noise);
            let white: Vec<f64> = nm.iter().map(|_| 0.01 * stream.normal()).collect();
            let noise = likeliest(&nm, &white, &ones, 0).unwrap().noise;
            assert!((noise.sigma / 0.01 - 1.0).abs() < 0.25, "{noise:?}");
        }
        found.sort_by(|a, b| a.correlation_nm.total_cmp(&b.correlation_nm));
        let median = found[15].correlation_nm;
        assert!((10.0..=40.0).contains(&median), "{median}");
    }
}
