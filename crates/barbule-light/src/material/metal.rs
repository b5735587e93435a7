//! Metals.

use super::Table;
use crate::Complex64;

/// Copper; of each metal wavelength in nm, n, k.
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

/// Gold, and silver.
const GOLD: [[f64; 3]; 24] = [
    [292.4, 1.49, 1.878],
    [300.9, 1.53, 1.889],
    [310.7, 1.53, 1.893],
    [320.4, 1.54, 1.898],
    [331.5, 1.48, 1.883],
    [342.5, 1.48, 1.871],
    [354.2, 1.50, 1.866],
    [367.9, 1.48, 1.895],
    [381.5, 1.46, 1.933],
    [397.4, 1.47, 1.952],
    [413.3, 1.46, 1.958],
    [430.5, 1.45, 1.948],
    [450.9, 1.38, 1.914],
    [471.4, 1.31, 1.849],
    [495.9, 1.04, 1.833],
    [520.9, 0.62, 2.081],
    [548.6, 0.43, 2.455],
    [582.1, 0.29, 2.863],
    [616.8, 0.21, 3.272],
    [659.5, 0.14, 3.697],
    [704.5, 0.13, 4.103],
    [756.0, 0.14, 4.542],
    [821.1, 0.16, 5.083],
    [892.0, 0.17, 5.663],
];
const SILVER: [[f64; 3]; 24] = [
    [292.4, 1.39, 1.161],
    [300.9, 1.34, 0.964],
    [310.7, 1.13, 0.616],
    [320.4, 0.81, 0.392],
    [331.5, 0.17, 0.829],
    [342.5, 0.14, 1.142],
    [354.2, 0.10, 1.419],
    [367.9, 0.07, 1.657],
    [381.5, 0.05, 1.864],
    [397.4, 0.05, 2.070],
    [413.3, 0.05, 2.275],
    [430.5, 0.04, 2.462],
    [450.9, 0.04, 2.657],
    [471.4, 0.05, 2.869],
    [495.9, 0.05, 3.093],
    [520.9, 0.05, 3.324],
    [548.6, 0.06, 3.586],
    [582.1, 0.05, 3.858],
    [616.8, 0.06, 4.152],
    [659.5, 0.05, 4.483],
    [704.5, 0.04, 4.838],
    [756.0, 0.03, 5.242],
    [821.1, 0.04, 5.727],
    [892.0, 0.04, 6.312],
];

/// Aluminium.
const ALUMINIUM: [[f64; 3]; 18] = [
    [247.97, 0.18137, 2.9029],
    [309.96, 0.28003, 3.7081],
    [326.28, 0.31474, 3.9165],
    [364.66, 0.39877, 4.3957],
    [413.28, 0.52135, 5.0008],
    [442.80, 0.60790, 5.3676],
    [476.87, 0.72780, 5.7781],
    [516.60, 0.87340, 6.2418],
    [563.57, 1.0728, 6.7839],
    [619.93, 1.3660, 7.4052],
    [652.25, 1.5724, 7.7354],
    [688.81, 1.8301, 8.0601],
    [729.32, 2.1606, 8.3565],
    [774.91, 2.6154, 8.4914],
    [794.78, 2.7675, 8.3866],
    [815.69, 2.7668, 8.2573],
    [837.74, 2.6945, 8.1878],
    [885.61, 2.2802, 8.1134],
];

impl Table {
    /// Copper from 367.9 to 756 nm: Johnson & Christy, *Optical constants of the noble metals*, Phys. Rev. B 6, 4370
    /// (1972), table I; wavelengths from its photon energies. At room temperature, evaporated films.
    #[must_use]
    pub fn copper() -> Self {
        Self::of_rows("copper", &COPPER)
    }

    /// Gold from 292.4 to 892 nm, of the same source.
    #[must_use]
    pub fn gold() -> Self {
        Self::of_rows("gold", &GOLD)
    }

    /// Silver from 292.4 to 892 nm, of the same source.
    #[must_use]
    pub fn silver() -> Self {
        Self::of_rows("silver", &SILVER)
    }

    /// Aluminium from 248 to 885.6 nm: Rakić, *Algorithm for the determination of intrinsic optical constants of metal films: application to
    /// aluminum*, Appl. Opt. 34, 4755 (1995). Evaporated films without an oxide.
    #[must_use]
    pub fn aluminium() -> Self {
        Self::of_rows("aluminium", &ALUMINIUM)
    }

    fn of_rows(name: &str, rows: &[[f64; 3]]) -> Self {
        Self {
            name: name.to_owned(),
            wavelength_nm: rows.iter().map(|[nm, ..]| *nm).collect(),
            index: rows.iter().map(|&[_, n, k]| Complex64::new(n, k)).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_those_of_sound_tables() {
        for table in [Table::copper(), Table::gold(), Table::silver(), Table::aluminium()] {
            let rows: Vec<_> = table.wavelength_nm.iter().copied().zip(table.index.iter().copied()).collect();
            assert_eq!(Table::new(table.name.clone(), &rows).unwrap(), table);
        }
        assert_eq!(Table::copper().index(659.5).unwrap(), Complex64::new(0.22, 3.747));
    }

    /// Reflectances at normal incidence, ((n − 1)² + k²)/((n + 1)² + k²), as handbooks have them: gold lets blue through, silver and
    /// aluminium mirror all colours.
    #[test]
    fn metals_have_their_colours() {
        let reflectance = |table: &Table, nm: f64| {
            let Complex64 { re: n, im: k } = table.index(nm).unwrap();
            ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k)
        };
        for (table, [blue, green, red]) in [
            (Table::gold(), [0.39, 0.81, 0.97]),
            (Table::silver(), [0.98, 0.98, 0.99]),
            (Table::aluminium(), [0.92, 0.92, 0.90]),
        ] {
            for (nm, expected) in [(450.0, blue), (550.0, green), (700.0, red)] {
                let found = reflectance(&table, nm);
                assert!((found - expected).abs() < 0.03, "{} {nm}: {found}", table.name);
            }
        }
    }
}
