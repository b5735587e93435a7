//! The tables of the CIE at 1 nm, 360 to 830 nm.

use std::sync::OnceLock;

/// The first wavelength of the tables in nm.
pub(super) const FIRST_NM: f64 = 360.0;
/// The last wavelength of the tables in nm.
pub(super) const LAST_NM: f64 = 830.0;
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

/// Columns at any wavelength, linear between the rows and 0 outside.
pub(super) fn at(nm: f64) -> [f64; COLUMNS] {
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
        assert_eq!(at(359.9), [0.0; COLUMNS]);
    }
}
