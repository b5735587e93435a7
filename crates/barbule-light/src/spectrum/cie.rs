//! The tables of the CIE at 1 nm, 360 to 830 nm, and its illuminants from 300 nm.

use std::sync::OnceLock;

/// The first wavelength of the tables in nm.
pub(super) const FIRST_NM: f64 = 360.0;
/// The last wavelength of the tables in nm.
pub(super) const LAST_NM: f64 = 830.0;
/// The first wavelength of the illuminants in nm.
pub(super) const FIRST_POWER_NM: f64 = 300.0;
/// Rows: x̄, ȳ, z̄, A, D50, D65.
const COLUMNS: usize = 6;

/// One row per nm: x̄, ȳ, z̄ of the 1931 2° observer, then the relative powers of A, D50 and D65.
pub(super) fn rows() -> &'static [[f64; COLUMNS]] {
    static ROWS: OnceLock<Vec<[f64; COLUMNS]>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let text = include_str!("../../data/cie.csv");
        let data = text.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit()));
        data.map(|line| {
            let mut row = [0.0; COLUMNS];
            for (value, cell) in row.iter_mut().zip(line.split(',').skip(1)) {
                // A test reads every cell of this file of ours.
                *value = cell.parse().unwrap_or(f64::NAN);
            }
            row
        })
        .collect()
    })
}

/// Relative powers of D50 and D65 at 300, 305 … 360 nm (CIE 15), where the observer's tables have not begun; linear between.
const ULTRAVIOLET: [[f64; 2]; 13] = [
    [0.019, 0.0341],
    [1.035, 1.6643],
    [2.051, 3.2945],
    [4.914, 11.7652],
    [7.778, 20.236],
    [11.263, 28.6447],
    [14.748, 37.0535],
    [16.348, 38.5011],
    [17.948, 39.9488],
    [19.479, 42.4302],
    [21.01, 44.9117],
    [22.476, 45.775],
    [23.942, 46.6383],
];

/// The columns from 300 to 360 nm. A is Planck's law of 2848 K with c₂ = 1.435·10⁷ nm K (CIE 15).
fn ultraviolet(nm: f64) -> [f64; COLUMNS] {
    let planck = |nm: f64| libm::pow(nm, -5.0) / (libm::exp(1.435e7 / (2848.0 * nm)) - 1.0);
    let at = (nm - FIRST_POWER_NM) / 5.0;
    let low = (at as usize).min(ULTRAVIOLET.len() - 2);
    let part = at - low as f64;
    let [d50, d65] =
        std::array::from_fn(|i| ULTRAVIOLET[low][i] * (1.0 - part) + ULTRAVIOLET[low + 1][i] * part);
    [0.0, 0.0, 0.0, 100.0 * planck(nm) / planck(560.0), d50, d65]
}

/// Columns at any wavelength, linear between the rows and 0 outside.
pub(super) fn at(nm: f64) -> [f64; COLUMNS] {
    if (FIRST_POWER_NM..FIRST_NM).contains(&nm) {
        return ultraviolet(nm);
    }
    if !(FIRST_NM..=LAST_NM).contains(&nm) {
        return [0.0; COLUMNS];
    }
    let rows = rows();
    let low = ((nm - FIRST_NM) as usize).min(rows.len() - 2);
    let part = nm - FIRST_NM - low as f64;
    std::array::from_fn(|i| rows[low][i] * (1.0 - part) + rows[low + 1][i] * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_are_complete_and_are_those_of_the_cie() {
        assert_eq!(rows().len(), 471);
        assert!(rows().iter().flatten().all(|v| v.is_finite() && *v >= 0.0));
        let sum: f64 = rows().iter().map(|row| row[1]).sum();
        assert!((sum - 106.857).abs() < 2e-3, "the published sum of the luminous efficiency: {sum}");
        assert_eq!(at(560.0)[3..], [100.0; 3]);
        assert_eq!(at(555.0)[1], 1.0);
        assert_eq!(at(359.9)[..3], [0.0; 3]);
        assert_eq!((at(299.9), at(830.1)), ([0.0; COLUMNS], [0.0; COLUMNS]));
        assert_eq!((at(310.0)[5], at(342.5)[4]), (3.2945, 0.5 * (17.948 + 19.479)));
        // Where the tables meet they are one.
        for (below, row) in ultraviolet(360.0).into_iter().zip(rows()[0]).skip(3) {
            assert!((below / row - 1.0).abs() < 1e-9, "{below} {row}");
        }
    }
}
