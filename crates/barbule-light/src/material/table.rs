//! Tabulated indices.

use crate::identity::{Hasher, Identify};
use crate::{Complex64, Error, Result};

/// n and k against the wavelength, interpolated linearly and never extrapolated.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    pub(super) name: String,
    pub(super) wavelength_nm: Vec<f64>,
    pub(super) index: Vec<Complex64>,
}

impl Table {
    /// A table of rows (wavelength in nm, n + jk) in rising order of wavelength; `name` is what messages call it.
    ///
    /// # Errors
    /// Empty, wavelengths that are not positive and rising, or an index that is not usable (gain, n < 0).
    pub fn new(name: impl Into<String>, rows: &[(f64, Complex64)]) -> Result<Self> {
        let name = name.into();
        let refuse = |what: String| Err(Error::input(format!("{name}: {what}")));
        if rows.is_empty() {
            return refuse("the table has no rows; give lines of wavelength in nm, n, k".into());
        }
        let mut before = 0.0;
        for (i, &(wavelength_nm, index)) in rows.iter().enumerate() {
            let row = i + 1;
            if !(wavelength_nm.is_finite() && wavelength_nm > 0.0) {
                return refuse(format!(
                    "row {row}: the wavelength {wavelength_nm} nm is not greater than zero"
                ));
            }
            if wavelength_nm <= before {
                return refuse(format!(
                    "row {row}: the wavelength {wavelength_nm} nm follows {before} nm; wavelengths must rise"
                ));
            }
            super::check(index).map_err(|e| e.at(format!("{name}: row {row}")))?;
            before = wavelength_nm;
        }
        let (wavelength_nm, index) = rows.iter().copied().unzip();
        Ok(Self { name, wavelength_nm, index })
    }

    /// What messages call the table, usually its file.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The first and the last wavelength in nm.
    #[must_use]
    pub fn range_nm(&self) -> (f64, f64) {
        (self.wavelength_nm[0], self.wavelength_nm[self.wavelength_nm.len() - 1])
    }

    /// The wavelengths of the rows in nm, rising.
    #[must_use]
    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.wavelength_nm
    }

    /// The indices n + jk of the rows.
    #[must_use]
    pub fn indices(&self) -> &[Complex64] {
        &self.index
    }

    pub(super) fn index(&self, wavelength_nm: f64) -> Result<Complex64> {
        let (first, last) = self.range_nm();
        let after = self.wavelength_nm.partition_point(|&w| w < wavelength_nm);
        if after < self.wavelength_nm.len() && self.wavelength_nm[after] == wavelength_nm {
            return Ok(self.index[after]);
        }
        if after == 0 || after == self.wavelength_nm.len() {
            return Err(Error::input(format!(
                "{}: {wavelength_nm} nm is outside the table, which covers {first} to {last} nm; tables are not extrapolated, choose wavelengths within it",
                self.name
            )));
        }
        let (low, high) = (self.wavelength_nm[after - 1], self.wavelength_nm[after]);
        let part = (wavelength_nm - low) / (high - low);
        Ok(self.index[after - 1] * (1.0 - part) + self.index[after] * part)
    }
}

impl Identify for Table {
    fn feed(&self, to: &mut Hasher) {
        // Where a table was read from changes nothing.
        let Self { name: _, wavelength_nm, index } = self;
        let parts = |part: fn(&Complex64) -> f64| index.iter().map(part).collect::<Vec<_>>();
        to.numbers("wavelength_nm", wavelength_nm);
        to.numbers("n", &parts(|index| index.re)).numbers("k", &parts(|index| index.im));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(rows: &[(f64, f64, f64)]) -> Vec<(f64, Complex64)> {
        rows.iter().map(|&(w, n, k)| (w, Complex64::new(n, k))).collect()
    }

    #[test]
    fn values_between_rows_are_linear_and_rows_are_exact() {
        let table = Table::new("t", &rows(&[(400.0, 1.5, 0.1), (500.0, 1.7, 0.3)])).unwrap();
        assert_eq!(table.index(400.0).unwrap(), Complex64::new(1.5, 0.1));
        assert_eq!(table.index(500.0).unwrap(), Complex64::new(1.7, 0.3));
        assert!((table.index(425.0).unwrap() - Complex64::new(1.55, 0.15)).norm() < 1e-15);
    }

    #[test]
    fn outside_the_range_the_message_names_table_range_and_wavelength() {
        let table = Table::new("gold.csv", &rows(&[(400.0, 1.5, 0.1), (500.0, 1.7, 0.3)])).unwrap();
        for wavelength in [399.0, 501.0] {
            let message = table.index(wavelength).unwrap_err().to_string();
            for part in ["gold.csv", "400 to 500 nm", &wavelength.to_string()] {
                assert!(message.contains(part), "{message}");
            }
        }
    }

    #[test]
    fn bad_rows_are_named() {
        let message = |r: &[(f64, f64, f64)]| Table::new("t", &rows(r)).unwrap_err().to_string();
        assert!(message(&[]).contains("no rows"));
        assert!(message(&[(400.0, 1.5, 0.0), (400.0, 1.5, 0.0)]).contains("row 2"));
        assert!(message(&[(400.0, 1.5, 0.0), (300.0, 1.5, 0.0)]).contains("must rise"));
        assert!(message(&[(400.0, 1.5, -0.1)]).contains("row 1: the index 1.5-0.1j has gain"));
        assert!(message(&[(f64::NAN, 1.5, 0.0)]).contains("row 1"));
    }
}
