//! Reflectance against wavelength.

use crate::Result;
use crate::campaign::spectrum::{Spectra, SpectrumRequest};
use crate::plot::{self, Band, Drawing};
use crate::spectrum::Spectrum;

/// Mean and spread of each direction, which `names` names, and measured spectra beside them.
///
/// # Errors
/// The wavelengths of the request do not rise.
pub fn spectra(
    title: &str,
    request: &SpectrumRequest,
    found: &Spectra,
    names: &[String],
    measured: &[(String, Spectrum)],
) -> Result<Drawing> {
    let at = &request.wavelengths;
    let bands = names
        .iter()
        .zip(found.mean.iter().zip(&found.std))
        .map(|(name, (mean, std))| {
            Ok(Band {
                name: name.clone(),
                mean: Spectrum::new(at.clone(), mean.clone())?,
                std: (request.instances > 1).then(|| std.clone()),
            })
        })
        .collect::<Result<Vec<_>>>()?;
    Ok(plot::spectra(title, &bands, measured).draw())
}
