//! Correlation lengths: how the speckle stretches with wavelength and direction (S.26, S.28).

use rayon::prelude::*;

use super::material::LENGTHS;
use crate::scattering::statistics::{LAGS, NOISE_POINTS, Statistics};

/// The length l of one (λ, ω_i).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Length {
    /// By least squares of C₀(Δ/l) against C(Δ).
    pub(super) fitted: f64,
    /// Ratio of the 1/e lengths.
    pub(super) ratio: f64,
}

/// C₀: the autocovariance at the shortest wavelength and the direction nearest to normal incidence, both
/// polarizations together, with C₀(0) = 1; zeros where there is no light.
pub(super) fn reference(statistics: &Statistics) -> Vec<f64> {
    let axes = &statistics.axes;
    let node = axes.index(0, axes.cos_theta().len() - 1, axes.cos_phi().len() - 1);
    normalized(statistics, node, &[0, 1]).unwrap_or_else(|| vec![0.0; LAGS])
}

/// l of every (λ, ω_i); where there is no autocovariance, pure scaling with the wavelength.
pub(super) fn lengths(statistics: &Statistics, polarizations: &[usize]) -> Vec<Length> {
    let reference = reference(statistics);
    let axes = &statistics.axes;
    let per_wavelength = axes.cos_theta().len() * axes.phis();
    (0..axes.len())
        .into_par_iter()
        .map(|node| {
            let scaling = axes.wavelengths_nm()[node / per_wavelength] / axes.wavelengths_nm()[0];
            let missing = Length { fitted: scaling, ratio: scaling };
            let Some(lags) = normalized(statistics, node, polarizations) else { return missing };
            let (Some(own), Some(base)) = (decay(&lags), decay(&reference)) else { return missing };
            let bounded = |l: f64| l.clamp(f64::from(LENGTHS.0) * 1.01, f64::from(LENGTHS.1) * 0.99);
            let ratio = bounded(own / base);
            Length { fitted: bounded(best_scale(&reference, &lags, ratio, own)), ratio }
        })
        .collect()
}

/// Δx_o at which the autocovariance of a node falls to 1/e; `None` where there is none.
pub(super) fn correlation_length(
    statistics: &Statistics,
    node: usize,
    polarizations: &[usize],
) -> Option<f64> {
    Some(decay(&normalized(statistics, node, polarizations)?)? * 2.0 / NOISE_POINTS as f64)
}

/// The mean over the polarizations, divided by its value at lag 0.
fn normalized(statistics: &Statistics, node: usize, polarizations: &[usize]) -> Option<Vec<f64>> {
    let mut sum = vec![0.0; LAGS];
    for &p in polarizations {
        let from = &statistics.autocovariance[(node * 2 + p) * LAGS..][..LAGS];
        for (sum, value) in sum.iter_mut().zip(from) {
            *sum += f64::from(*value);
        }
    }
    let first = sum[0];
    let usable = first > 0.0 && sum.iter().all(|v| v.is_finite());
    usable.then(|| sum.iter().map(|v| v / first).collect())
}

/// The lag (in spacings) at which the function first falls to 1/e, linearly between lags.
fn decay(lags: &[f64]) -> Option<f64> {
    let level = libm::exp(-1.0);
    let at = lags.iter().position(|v| *v < level)?;
    let (above, below) = (lags[at - 1], lags[at]);
    Some((at - 1) as f64 + (above - level) / (above - below))
}

/// The l near `start` with the least squares of C₀(k/l) − C(k) over four 1/e lengths: a scan, then golden sections.
fn best_scale(reference: &[f64], lags: &[f64], start: f64, own: f64) -> f64 {
    let count = ((4.0 * own).ceil() as usize).clamp(4, LAGS);
    let error = |l: f64| -> f64 {
        (1..count)
            .map(|k| {
                let difference = interpolate(reference, k as f64 / l) - lags[k];
                difference * difference
            })
            .sum()
    };
    let scan = (-12..=12).map(|k| start * libm::exp(0.05 * f64::from(k)));
    let best = scan.min_by(|a, b| error(*a).total_cmp(&error(*b))).unwrap_or(start);
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (best * libm::exp(-0.05), best * libm::exp(0.05));
    for _ in 0..24 {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if error(a) < error(b) { high = b } else { low = a }
    }
    0.5 * (low + high)
}

/// C₀ between lags, by a cubic through four neighbours (the function is even), zero beyond the last.
pub(super) fn interpolate(lags: &[f64], at: f64) -> f64 {
    let k = at as usize;
    if k + 2 >= lags.len() {
        return lags.get(k).copied().unwrap_or(0.0);
    }
    let t = at - k as f64;
    let before = if k == 0 { lags[1] } else { lags[k - 1] };
    let (a, b, c, d) = (before, lags[k], lags[k + 1], lags[k + 2]);
    b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretched_function_has_its_own_scale() {
        let make = |scale: f64| -> Vec<f64> {
            (0..LAGS)
                .map(|k| {
                    let x = k as f64 / scale;
                    libm::exp(-(x / 9.0).powi(2)) * libm::cos(x / 7.0)
                })
                .collect()
        };
        let reference = make(1.0);
        for scale in [0.6, 1.0, 1.4, 1.735, 3.0] {
            let lags = make(scale);
            let own = decay(&lags).unwrap();
            let ratio = own / decay(&reference).unwrap();
            // The 1/e length is found by linear interpolation.
            assert!((ratio / scale - 1.0).abs() < 0.02, "{scale} {ratio}");
            let fitted = best_scale(&reference, &lags, ratio, own);
            assert!((fitted / scale - 1.0).abs() < 2e-3, "{scale} {fitted}");
        }
    }
}
