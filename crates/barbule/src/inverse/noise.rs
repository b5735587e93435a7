//! Errors of measured spectra, which are alike at neighbouring wavelengths.
//!
//! Their covariance is σ²·(w·δ_ij + (1 − w)·exp(−|λ_i − λ_j|/ℓ)): a part w that differs from sample to sample, as of a detector, and
//! one with a correlation length ℓ, as of smoothing, of a drifting lamp, and of what a model leaves out. [`Whitening`] turns it into
//! the unit matrix by the innovations of a Kalman filter, in a time proportional to the samples; how likely w and ℓ are follows from
//! residuals by restricted maximum likelihood, which allows for what was fitted.

use super::small::{cholesky, log_determinant, solve};

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
        Self { sigma, correlation_nm: 0.0, white: 1.0 }
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

/// The errors of one measurement: the likeliest, and all that are nearly as likely.
#[derive(Debug, Clone)]
pub(super) struct Errors {
    pub(super) likeliest: Noise,
    /// Variance (by its probability), correlation length and independent part of each.
    all: Vec<[f64; 3]>,
}

/// Covariances less probable than this are left out.
const IMPROBABLE: f64 = 1e-6;

impl Errors {
    /// Independent errors of this standard deviation.
    pub(super) fn independent(sigma: f64) -> Self {
        Self { likeliest: Noise::independent(sigma), all: vec![[sigma * sigma, 0.0, 1.0]] }
    }

    /// The covariance, in the mean over all that are likely, times a column of samples at these wavelengths.
    pub(super) fn covariance_times(&self, nm: &[f64], column: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; column.len()];
        let mut sums = product.clone();
        for &[variance, length, white] in &self.all {
            product.iter_mut().zip(column).for_each(|(sum, value)| *sum += variance * white * value);
            if length <= 0.0 {
                continue;
            }
            // exp(−|λ_i − λ_j|/ℓ) by recursions from both ends.
            let kept = |i: usize| (-(nm[i + 1] - nm[i]) / length).exp();
            let mut run = 0.0;
            for i in 0..column.len() {
                run = column[i] + if i > 0 { kept(i - 1) * run } else { 0.0 };
                sums[i] = run;
            }
            run = 0.0;
            for i in (0..column.len()).rev() {
                sums[i] += run;
                run = if i > 0 { kept(i - 1) * (run + column[i]) } else { 0.0 };
            }
            product
                .iter_mut()
                .zip(&sums)
                .for_each(|(product, sum)| *product += variance * (1.0 - white) * sum);
        }
        product
    }
}

/// A covariance that was tried.
struct Tried {
    noise: Noise,
    /// −2 times the logarithm of its restricted likelihood.
    unlikely: f64,
    /// How many candidates it stands for.
    times: f64,
}

/// The covariance under which `values` less a combination of `columns` is likeliest, by restricted maximum likelihood
/// (Patterson and Thompson, Biometrika 58 (1971) 545) over a grid of correlation lengths up to a third of the range, and all others, each as
/// probable as it is likely. Columns that others contain must not be among them.
pub(super) fn likeliest(nm: &[f64], values: &[f64], columns: &[Vec<f64>]) -> Option<Errors> {
    let count = nm.len();
    let range = nm[count - 1] - nm[0];
    let step = range / (count - 1).max(1) as f64;
    let lengths = (0..).map(|k| step * 0.5 * 2.0_f64.powi(k)).take_while(|length| *length <= range / 3.0);
    let correlated = lengths.flat_map(|length| WHITE.map(|white| (length, white, 1.0)));
    // Independent errors stand for all parts that are.
    let grid = std::iter::once((0.0, 1.0, WHITE.len() as f64)).chain(correlated);
    let tried: Vec<Tried> = grid.filter_map(|one| tried(nm, values, columns, one)).collect();
    let best = tried.iter().min_by(|a, b| a.unlikely.total_cmp(&b.unlikely))?;
    let probable = |one: &Tried| one.times * (0.5 * (best.unlikely - one.unlikely)).exp();
    let whole: f64 = tried.iter().map(probable).sum();
    let all = tried.iter().filter(|one| probable(one) > IMPROBABLE * whole).map(|one| {
        let Noise { sigma, correlation_nm, white } = one.noise;
        [sigma * sigma * probable(one) / whole, correlation_nm, white]
    });
    Some(Errors { likeliest: best.noise, all: all.collect() })
}

/// One covariance; none where the columns are not independent under it.
fn tried(
    nm: &[f64],
    values: &[f64],
    columns: &[Vec<f64>],
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
    Some(Tried { noise: Noise { sigma: variance.sqrt(), correlation_nm, white }, unlikely, times })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inverse::small::inverse;
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
        let errors =
            Errors { likeliest: Noise::independent(1.0), all: vec![[2.0, length, white], [0.5, 0.0, 1.0]] };
        for column in 0..5 {
            let unit: Vec<f64> = (0..5).map(|k| f64::from(u8::from(k == column))).collect();
            let product = errors.covariance_times(&nm, &unit);
            for row in 0..5 {
                let expected = 2.0 * covariance[row * 5 + column] + 0.5 * unit[row];
                assert!((product[row] - expected).abs() < 1e-12, "{row} {column}");
            }
        }
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
            found.push(likeliest(&nm, &values, &ones).unwrap().likeliest);
            let white: Vec<f64> = nm.iter().map(|_| 0.01 * stream.normal()).collect();
            let noise = likeliest(&nm, &white, &ones).unwrap().likeliest;
            assert!((noise.sigma / 0.01 - 1.0).abs() < 0.25, "{noise:?}");
        }
        found.sort_by(|a, b| a.correlation_nm.total_cmp(&b.correlation_nm));
        let median = found[15].correlation_nm;
        assert!((10.0..=40.0).contains(&median), "{median}");
    }
}
