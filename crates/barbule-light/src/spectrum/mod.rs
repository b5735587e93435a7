//! Wavelengths, spectra and colour.
//!
//! [`Wavelengths`] are a sorted set in nm that is cheap to share; a [`Spectrum`] has one value for each and is linear
//! between them, a [`dense::DenseSpectrum`] one for each nm. [`colour`] turns reflectances into what an observer sees, [`hue`] says which colour that is, [`look`] gives
//! all numbers of a colour together, [`peaks`] finds peaks, [`orders`] which of them correspond and [`angle_law`] how they move with the angle; [`comparison`] holds a simulated spectrum against a measured one. [`sensor`] is who looks at a
//! picture, [`hero`] which wavelengths its paths have; [`temperature`] says which white a light is; [`glassner`] are spectra as pictures of 2005 had them.

pub mod angle_law;
mod cie;
pub mod colour;
pub mod comparison;
pub mod dense;
pub mod difference;
pub mod fields;
pub mod glassner;
pub mod hero;
pub mod hue;
pub mod look;
pub mod orders;
pub mod peaks;
pub mod primaries;
pub mod residual;
pub mod sensor;
pub mod spread;
pub mod temperature;

use std::sync::Arc;

use crate::{Error, Result};

/// Vacuum wavelengths in nm: positive, rising, never empty. A copy costs nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Wavelengths(Arc<[f64]>);

impl Wavelengths {
    /// Wavelengths in nm.
    ///
    /// # Errors
    /// Empty, not positive and finite, or not rising.
    pub fn new(nm: impl Into<Arc<[f64]>>) -> Result<Self> {
        let nm = nm.into();
        if nm.is_empty() {
            return Err(Error::input("the set of wavelengths is empty; give one or more in nm"));
        }
        if let Some(bad) = nm.iter().find(|w| !(w.is_finite() && **w > 0.0)) {
            return Err(Error::input(format!("the wavelength {bad} nm is not greater than zero")));
        }
        if let Some(pair) = nm.windows(2).find(|pair| pair[1] <= pair[0]) {
            return Err(Error::input(format!(
                "the wavelength {} nm follows {} nm; wavelengths must rise",
                pair[1], pair[0]
            )));
        }
        Ok(Self(nm))
    }

    /// 400, 406, …, 694 nm: the fifty wavelengths that everything uses unless told otherwise.
    #[must_use]
    pub fn usual() -> Self {
        Self((0..50).map(|i| 400.0 + 6.0 * f64::from(i)).collect())
    }

    /// The wavelengths in nm.
    #[must_use]
    pub fn nm(&self) -> &[f64] {
        &self.0
    }

    /// How many there are, at least 1.
    #[must_use]
    #[allow(clippy::len_without_is_empty)] // never empty
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// The first and the last in nm.
    #[must_use]
    pub fn range_nm(&self) -> (f64, f64) {
        (self.0[0], self.0[self.0.len() - 1])
    }

    /// The place of the last wavelength at or below `nm` and the part of the way to the next; the ends are held.
    #[must_use]
    pub fn place(&self, nm: f64) -> (usize, f64) {
        let after = self.0.partition_point(|&w| w <= nm);
        if after == 0 {
            return (0, 0.0);
        }
        match self.0.get(after) {
            None => (self.0.len() - 1, 0.0),
            Some(next) => (after - 1, (nm - self.0[after - 1]) / (next - self.0[after - 1])),
        }
    }
}

impl std::ops::Deref for Wavelengths {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.0
    }
}

/// The vacuum wave number k = 2π/λ of a wavelength in nm, rad/µm.
#[must_use]
pub fn wave_number_per_um(wavelength_nm: f64) -> f64 {
    std::f64::consts::TAU / (wavelength_nm * 1e-3)
}

/// One value per wavelength, linear between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    at: Wavelengths,
    values: Vec<f64>,
}

impl Spectrum {
    /// A spectrum from one value for each wavelength.
    ///
    /// # Errors
    /// Not as many values as wavelengths, or a value that is not finite.
    pub fn new(at: Wavelengths, values: Vec<f64>) -> Result<Self> {
        if values.len() != at.len() {
            return Err(Error::input(format!("{} values do not fit {} wavelengths", values.len(), at.len())));
        }
        if let Some(i) = values.iter().position(|v| !v.is_finite()) {
            return Err(Error::input(format!(
                "the value at {} nm is {}, not a finite number",
                at[i], values[i]
            )));
        }
        Ok(Self { at, values })
    }

    /// The wavelengths of the values.
    #[must_use]
    pub fn wavelengths(&self) -> &Wavelengths {
        &self.at
    }

    /// The values, one per wavelength.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The value at a wavelength in nm, or nothing outside the spectrum's range.
    #[must_use]
    pub fn value(&self, nm: f64) -> Option<f64> {
        let (first, last) = self.at.range_nm();
        (first..=last).contains(&nm).then(|| self.held(nm))
    }

    /// The value at a wavelength in nm; outside the range the end values hold, as is usual for the colour of a
    /// reflectance.
    #[must_use]
    pub fn held(&self, nm: f64) -> f64 {
        let (low, part) = self.at.place(nm);
        match self.values.get(low + 1) {
            Some(next) if part > 0.0 => self.values[low] * (1.0 - part) + next * part,
            _ => self.values[low],
        }
    }

    /// The part within a range of nm, with its ends between samples; none where they share no more than a point.
    #[must_use]
    pub fn within(&self, [from, to]: [f64; 2]) -> Option<Self> {
        let (first, last) = self.at.range_nm();
        let (from, to) = (from.max(first), to.min(last));
        if from >= to {
            return None;
        }
        let inner = self.at.iter().copied().filter(|nm| (from..to).contains(nm) && *nm > from);
        let nm: Vec<f64> = std::iter::once(from).chain(inner).chain([to]).collect();
        let values = nm.iter().map(|&nm| self.held(nm)).collect();
        Some(Self { at: Wavelengths(nm.into()), values })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_wavelengths_are_400_to_694_in_steps_of_6() {
        let usual = Wavelengths::usual();
        assert_eq!((usual.len(), usual.range_nm(), usual[1]), (50, (400.0, 694.0), 406.0));
    }

    #[test]
    fn sets_that_do_not_rise_are_refused() {
        for bad in [&[][..], &[500.0, 500.0], &[500.0, 400.0], &[0.0], &[f64::NAN], &[1.0, f64::INFINITY]] {
            assert!(Wavelengths::new(bad).unwrap_err().is_input(), "{bad:?}");
        }
    }

    #[test]
    fn spectra_are_linear_inside_and_held_or_nothing_outside() {
        let spectrum = Spectrum::new(Wavelengths::new([400.0, 500.0]).unwrap(), vec![1.0, 3.0]).unwrap();
        assert_eq!(spectrum.value(425.0), Some(1.5));
        assert_eq!((spectrum.value(400.0), spectrum.value(500.0)), (Some(1.0), Some(3.0)));
        assert_eq!((spectrum.value(399.0), spectrum.value(501.0)), (None, None));
        assert_eq!((spectrum.held(399.0), spectrum.held(501.0)), (1.0, 3.0));
        let part = spectrum.within([425.0, 900.0]).unwrap();
        assert_eq!((part.wavelengths().nm(), part.values()), (&[425.0, 500.0][..], &[1.5, 3.0][..]));
        assert_eq!(
            (spectrum.within([500.0, 600.0]), spectrum.within([300.0, 900.0])),
            (None, Some(spectrum))
        );
        assert!(Spectrum::new(Wavelengths::usual(), vec![1.0]).unwrap_err().is_input());
        assert!(Spectrum::new(Wavelengths::new([1.0]).unwrap(), vec![f64::NAN]).unwrap_err().is_input());
    }
}
