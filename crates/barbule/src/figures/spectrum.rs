//! Reflectance against wavelength.

use super::KERATIN_NOTE;
use crate::Result;
use crate::campaign::spectrum::Spectra;
use crate::material::KERATIN_CLEAR_FROM_NM;
use crate::plot::{self, Band, Drawing, MeasuredBand, Page};
use crate::spectrum::look::Look;
use crate::spectrum::{Spectrum, Wavelengths};

/// The simulated curves of one structure.
#[derive(Debug, Clone, Copy)]
pub struct Simulated<'a> {
    /// What the legend calls each direction.
    pub names: &'a [String],
    /// Mean and spread of each direction.
    pub spectra: &'a Spectra,
    /// Of how many instances; the spread of a single one is not drawn.
    pub instances: usize,
    /// The numbers of each direction; of several the peak that is followed through them is marked.
    pub looks: &'a [Look],
    /// Whether it has keratin, which is taken to be clear in the ultraviolet: that part is hatched.
    pub has_guess: bool,
}

/// Mean and spread of each direction of each structure at common wavelengths, and measured ones beside them.
///
/// # Errors
/// A spectrum that does not fit the wavelengths.
pub fn spectra(
    title: &str,
    at: &Wavelengths,
    simulated: &[Simulated],
    measured: &[MeasuredBand],
    page: &Page,
) -> Result<Drawing> {
    let mut bands = Vec::new();
    for of in simulated {
        let followed = of.looks.len() > 1;
        for (k, (name, (mean, std))) in
            of.names.iter().zip(of.spectra.mean.iter().zip(&of.spectra.std)).enumerate()
        {
            bands.push(Band {
                name: name.clone(),
                mean: Spectrum::new(at.clone(), mean.clone())?,
                std: (of.instances > 1).then(|| std.clone()),
                peak: of.looks.get(k).filter(|_| followed).and_then(|look| look.peak),
            });
        }
    }
    let mut figure = plot::spectra(title, &bands, measured);
    let from_nm = at.range_nm().0;
    if from_nm < KERATIN_CLEAR_FROM_NM && simulated.iter().any(|of| of.has_guess) {
        figure.hatched = Some([from_nm, KERATIN_CLEAR_FROM_NM]);
        let notes = figure.footnote.into_iter().chain([KERATIN_NOTE.to_owned()]);
        figure.footnote = Some(notes.collect::<Vec<_>>().join("; "));
    }
    Ok(figure.draw_on(page))
}
