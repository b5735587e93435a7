//! Metals.

use super::Table;
use crate::Complex64;

/// Copper: wavelength in nm, n, k.
const COPPER: [[f64; 3]; 15] = [
    [367.9, 1.36, 1.975],
    [381.5, 1.33, 2.045],
    [397.4, 1.32, 2.116],
    [413.3, 1.28, 2.207],
    [430.5, 1.25, 2.305],
    [450.9, 1.24, 2.397],
    [471.4, 1.25, 2.483],
    [495.9, 1.22, 2.564],
    [520.9, 1.18, 2.608],
    [548.6, 1.02, 2.577],
    [582.1, 0.70, 2.704],
    [616.8, 0.30, 3.205],
    [659.5, 0.22, 3.747],
    [704.5, 0.21, 4.205],
    [756.0, 0.24, 4.665],
];

impl Table {
    /// Copper from 367.9 to 756 nm: Johnson & Christy, *Optical constants of the noble metals*, Phys. Rev. B 6, 4370
    /// (1972), table I; wavelengths from its photon energies. At room temperature, evaporated films.
    #[must_use]
    pub fn copper() -> Self {
        Self {
            name: "copper".to_owned(),
            wavelength_nm: COPPER.map(|[nm, ..]| nm).to_vec(),
            index: COPPER.map(|[_, n, k]| Complex64::new(n, k)).to_vec(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_those_of_a_sound_table() {
        let copper = Table::copper();
        let rows: Vec<_> = COPPER.iter().map(|&[nm, n, k]| (nm, Complex64::new(n, k))).collect();
        assert_eq!(Table::new("copper", &rows).unwrap(), copper);
        assert_eq!(copper.index(659.5).unwrap(), Complex64::new(0.22, 3.747));
    }
}
