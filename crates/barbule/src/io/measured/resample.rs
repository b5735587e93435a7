//! Samples at wavelengths of their own, brought to those of one of them.

use crate::error::shortened;
use crate::spectrum::{Spectrum, Wavelengths};
use crate::{Error, Result};

/// A sample with its own wavelengths, nm, in any order; NaN where a cell is missing.
pub(super) struct Own {
    pub(super) name: String,
    pub(super) positions: Vec<f64>,
    pub(super) values: Vec<f64>,
}

/// The values of samples at common wavelengths, nm, linear between their own; NaN outside of them.
///
/// # Errors
/// A sample has no number.
pub(super) fn brought_to(
    at_nm: &[f64],
    samples: impl IntoIterator<Item = Own>,
) -> Result<Vec<(String, Vec<f64>)>> {
    let values = |own: Own| {
        let all = own.positions.iter().copied().zip(own.values.iter().copied());
        let mut points: Vec<(f64, f64)> =
            all.filter(|(nm, value)| nm.is_finite() && value.is_finite()).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        // The same wavelength again is averaged.
        let runs: Vec<_> = points.chunk_by(|a, b| a.0 == b.0).collect();
        if runs.is_empty() {
            return Err(Error::input(format!("the sample '{}' has no numbers", shortened(&own.name))));
        }
        let mean = |run: &&[(f64, f64)]| run.iter().map(|point| point.1).sum::<f64>() / run.len() as f64;
        let nm: Vec<f64> = runs.iter().map(|run| run[0].0).collect();
        let spectrum = Spectrum::new(Wavelengths::new(nm)?, runs.iter().map(mean).collect())?;
        let at = |&nm: &f64| spectrum.value(nm).unwrap_or(f64::NAN);
        Ok((own.name, at_nm.iter().map(at).collect()))
    };
    samples.into_iter().map(values).collect()
}
