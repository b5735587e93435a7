//! Spectra of lights, tabulated where the renderer samples them.

use std::sync::Arc;

use crate::spectrum::colour::Illuminant;
use crate::{Error, Result};

/// Shortest wavelength that the renderer samples, nm.
pub const SHORTEST_NM: f64 = 380.0;
/// Longest wavelength that the renderer samples, nm.
pub const LONGEST_NM: f64 = 720.0;
/// Values in a table: one per nm, both ends included.
pub const TABLE: usize = 341;

/// Spectral radiance, tabulated at 380, 381 … 720 nm, linear between and held outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Emission {
    table: Arc<[f64]>,
}

impl Emission {
    /// From a function of the wavelength in nm.
    ///
    /// # Errors
    /// A value that is negative or not finite.
    pub fn new(radiance: impl Fn(f64) -> f64) -> Result<Self> {
        let table: Arc<[f64]> = (0..TABLE).map(|i| radiance(SHORTEST_NM + i as f64)).collect();
        if table.iter().any(|v| !v.is_finite() || *v < 0.0) {
            return Err(Error::input("a light's spectrum has a value that is negative or not finite"));
        }
        Ok(Self { table })
    }

    /// Daylight (D65) of radiance 1: its value at 560 nm.
    #[must_use]
    pub fn daylight() -> Self {
        let at = |i: usize| Illuminant::D65.power(SHORTEST_NM + i as f64) / Illuminant::D65.power(560.0);
        Self { table: (0..TABLE).map(at).collect() }
    }

    /// The same spectrum times a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self { table: self.table.iter().map(|v| v * factor).collect() }
    }

    /// At one wavelength, nm.
    #[must_use]
    pub fn at(&self, wavelength_nm: f64) -> f64 {
        lookup(&self.table, wavelength_nm)
    }

    /// At the four wavelengths of a path, nm.
    #[must_use]
    pub fn at4(&self, wavelengths_nm: [f64; 4]) -> [f64; 4] {
        wavelengths_nm.map(|w| self.at(w))
    }
}

/// Linear interpolation in a table of [`TABLE`] values, held outside.
#[must_use]
pub fn lookup(table: &[f64], wavelength_nm: f64) -> f64 {
    let at = (wavelength_nm - SHORTEST_NM).clamp(0.0, (TABLE - 1) as f64);
    let index = (at as usize).min(TABLE - 2);
    let rest = at - index as f64;
    table[index] + (table[index + 1] - table[index]) * rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_linear_inside_and_held_outside() {
        let emission = Emission::new(|w| w).unwrap();
        assert_eq!(emission.at(500.25), 500.25);
        assert_eq!(emission.at(300.0), 380.0);
        assert_eq!(emission.at(800.0), 720.0);
        assert!(Emission::new(|w| w - 500.0).is_err());
    }
}
