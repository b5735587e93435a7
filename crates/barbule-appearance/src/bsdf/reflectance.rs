//! Diffuse reflectances, and those of pigmented keratin: Kubelka and Munk's for melanin, whose absorption falls as k/λ
//! with melanin's k.

use crate::material::ExponentialAbsorption;
use crate::spectrum::dense::{DenseSpectrum, Lambdas, WAVES};
use crate::spectrum::primaries::shares;
use crate::spectrum::sensor::Band;
use crate::{Error, Result};

/// A diffuse reflectance or transmittance: one value per nm.
#[derive(Debug, Clone, PartialEq)]
pub struct Reflectance {
    spectrum: DenseSpectrum,
    mean: f64,
}

impl Reflectance {
    /// From a function of the wavelength in nm.
    ///
    /// # Errors
    /// A value outside 0 … 1.
    pub fn new(value: impl Fn(f64) -> f64) -> Result<Self> {
        let spectrum = DenseSpectrum::new(value);
        if !spectrum.values().iter().all(|v| (0.0..=1.0).contains(v)) {
            return Err(Error::input("a reflectance must lie between 0 and 1 at every wavelength"));
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let seen = mean(Band::HUMAN.of(&spectrum));
        let mean = if seen > 0.0 { seen } else { mean(spectrum.values()) };
        Ok(Self { spectrum, mean })
    }

    /// Keratin pigmented with melanin. `absorption`: absorption over scattering at 550 nm; 0 is white, 1 brown, 20
    /// nearly black.
    ///
    /// # Errors
    /// Negative or not finite.
    pub fn melanin(absorption: f64) -> Result<Self> {
        if !(absorption.is_finite() && absorption >= 0.0) {
            return Err(Error::input("melanin's absorption must be finite and not negative"));
        }
        let relative = |w: f64| ExponentialAbsorption::MELANIN.decay(w) / w;
        Self::new(|w| {
            let ratio = absorption * relative(w) / relative(550.0);
            1.0 + ratio - (ratio * ratio + 2.0 * ratio).sqrt()
        })
    }

    /// Of a colour in linear sRGB, 0 … 1: its smoothest spectrum within 0 … 1.
    ///
    /// # Errors
    /// A colour outside 0 … 1.
    pub fn of_colour(colour: [f64; 3]) -> Result<Self> {
        if !colour.iter().all(|v| (0.0..=1.0).contains(v)) {
            return Err(Error::input("a colour must lie between 0 and 1"));
        }
        let basis = shares();
        let sum = |w: f64| basis.iter().zip(colour).map(|(share, c)| c * share.at(w)).sum::<f64>();
        Self::new(|w| sum(w).clamp(0.0, 1.0))
    }

    /// The values, one per nm.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        self.spectrum.values()
    }

    /// At one wavelength, nm.
    #[inline]
    #[must_use]
    pub fn at(&self, wavelength_nm: f64) -> f64 {
        self.spectrum.at(wavelength_nm)
    }

    /// At the wavelengths of a path.
    #[inline(always)]
    #[must_use]
    pub fn at_each(&self, wavelengths: Lambdas) -> [f64; WAVES] {
        self.spectrum.at_each(wavelengths)
    }

    /// Mean over the wavelengths of the human eye, or over all where it is black to it: the part of it in samples.
    #[inline]
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn melanin_is_brown_and_darker_with_more_of_it() {
        let body = Reflectance::melanin(1.0).unwrap();
        assert!(body.at(650.0) > body.at(550.0) && body.at(550.0) > body.at(450.0));
        assert!(Reflectance::melanin(10.0).unwrap().mean() < body.mean());
        assert!(Reflectance::melanin(-1.0).is_err());
    }
}
