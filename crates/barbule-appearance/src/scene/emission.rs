//! Spectra of lights.

use crate::spectrum::colour::{D65_WHITE, Illuminant, matching};
use crate::spectrum::dense::{DenseSpectrum, Lambdas, WAVES};
use crate::spectrum::sensor::Band;
use crate::{Error, Result};

/// Spectral radiance, finite and not negative.
#[derive(Debug, Clone, PartialEq)]
pub struct Emission {
    spectrum: DenseSpectrum,
}

impl Emission {
    /// From a function of the wavelength in nm.
    ///
    /// # Errors
    /// A value that is negative or not finite.
    pub fn new(radiance: impl Fn(f64) -> f64) -> Result<Self> {
        let spectrum = DenseSpectrum::new(radiance);
        if spectrum.values().iter().any(|v| !v.is_finite() || *v < 0.0) {
            return Err(Error::input("a light's spectrum has a value that is negative or not finite"));
        }
        Ok(Self { spectrum })
    }

    /// Daylight (D65) of radiance 1: its value at 560 nm.
    #[must_use]
    pub fn daylight() -> Self {
        let white = Illuminant::D65.power(560.0);
        Self { spectrum: DenseSpectrum::new(|w| Illuminant::D65.power(w) / white) }
    }

    /// The same spectrum times a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self { spectrum: self.spectrum.scaled(factor) }
    }

    /// How bright it is to the eye: the integral with ȳ over 380 to 720 nm, nm.
    #[must_use]
    pub fn luminance(&self) -> f64 {
        self.xyz()[1]
    }

    /// The integrals with x̄, ȳ and z̄ over 380 to 720 nm, nm.
    #[must_use]
    pub fn xyz(&self) -> [f64; 3] {
        let band = Band::HUMAN;
        let values = band.each_nm().zip(band.of(&self.spectrum));
        values.fold([0.0; 3], |sum, (nm, value)| {
            let weight = if nm == band.low_nm() || nm == band.high_nm() { 0.5 } else { 1.0 };
            let matching = matching(nm);
            std::array::from_fn(|c| sum[c] + weight * value * matching[c])
        })
    }

    /// X, Y, Z as pictures have them: daylight has exactly sRGB's white.
    #[must_use]
    pub fn pictured(&self) -> [f64; 3] {
        let (own, daylight) = (self.xyz(), Self::daylight().xyz());
        std::array::from_fn(|c| own[c] / daylight[c] * D65_WHITE[c])
    }

    /// At every nanometre.
    #[must_use]
    pub fn spectrum(&self) -> &DenseSpectrum {
        &self.spectrum
    }

    /// At one wavelength, nm.
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_light_is_refused() {
        assert!(Emission::new(|w| w - 500.0).is_err());
        assert!((Emission::daylight().at(560.0) - 1.0).abs() < 1e-15);
    }
}
