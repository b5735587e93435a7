//! Curves against wavelength, as they are drawn and written.

use std::fmt::Write as _;

use barbule::spectrum::{Spectrum, Wavelengths};
use barbule::{Error, Result};

/// Reflectance at several angles and wavelengths.
#[derive(Debug, Clone, PartialEq)]
pub struct Curves {
    /// Vacuum wavelengths, nm.
    pub at: Wavelengths,
    /// Angles of incidence across the barbule, rad.
    pub angle: Vec<f64>,
    /// The reflected part of unpolarized light. Shape: `[angle, wavelength]`, row-major.
    pub reflected: Vec<f64>,
    /// Its standard deviation between individuals, of the same shape; none where there are no several.
    pub std: Option<Vec<f64>>,
}

impl Curves {
    /// Curves of these shapes.
    ///
    /// # Errors
    /// Numbers of values do not fit, or a value is not finite.
    pub fn new(at: Wavelengths, angle: Vec<f64>, reflected: Vec<f64>, std: Option<Vec<f64>>) -> Result<Self> {
        let count = at.len() * angle.len();
        let wrong =
            [Some(&reflected), std.as_ref()].into_iter().flatten().find(|values| values.len() != count);
        if let Some(values) = wrong {
            return Err(Error::machine(format!(
                "{} values do not fit {} wavelengths and {} angles",
                values.len(),
                at.len(),
                angle.len()
            )));
        }
        Ok(Self { at, angle, reflected, std })
    }

    /// The reflectance at one of the angles.
    ///
    /// # Errors
    /// There is no such angle.
    pub fn spectrum(&self, angle: usize) -> Result<Spectrum> {
        let columns = self.at.len();
        let row = self.reflected.get(angle * columns..(angle + 1) * columns);
        let row = row
            .ok_or_else(|| Error::machine(format!("there is no angle {angle} among {}", self.angle.len())))?;
        Spectrum::new(self.at.clone(), row.to_vec())
    }

    /// Which of the angles is nearest to one, rad; one from the other side, as flat layers are computed from one alone, where none is
    /// nearer.
    #[must_use]
    pub fn nearest(&self, angle: f64) -> usize {
        let other_side = 1e-9;
        let far = |row: &usize| {
            let own = self.angle[*row];
            (own - angle).abs().min((own + angle).abs() + other_side)
        };
        (0..self.angle.len()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or_default()
    }

    /// The standard deviations between individuals at one of the angles; none where there are no several.
    #[must_use]
    pub fn deviation(&self, angle: usize) -> Option<&[f64]> {
        let columns = self.at.len();
        self.std.as_ref()?.get(angle * columns..(angle + 1) * columns)
    }

    /// The curves as the text of a CSV file, as `barbule spectrum` has it: angle_deg, wavelength_nm, mean and, where there is one, std.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = String::from("angle_deg,wavelength_nm,mean");
        text += if self.std.is_some() { ",std\n" } else { "\n" };
        for (row, angle) in self.angle.iter().enumerate() {
            for (column, nm) in self.at.iter().enumerate() {
                let place = row * self.at.len() + column;
                // Writing to a string cannot fail.
                let _ = write!(text, "{},{nm},{}", rounded(angle.to_degrees()), self.reflected[place]);
                if let Some(std) = &self.std {
                    let _ = write!(text, ",{}", std[place]);
                }
                text.push('\n');
            }
        }
        text
    }
}

/// Degrees without the last digits that the turn from radians leaves.
fn rounded(degrees: f64) -> f64 {
    (degrees * 1e9).round() / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_cut_into_spectra_and_written_as_tables() {
        let at = Wavelengths::new([400.0, 500.0]).unwrap();
        let angle = vec![0.0, 30.0_f64.to_radians()];
        let curves = Curves::new(at.clone(), angle.clone(), vec![0.1, 0.2, 0.3, 0.4], None).unwrap();
        assert_eq!(curves.spectrum(1).unwrap().values(), [0.3, 0.4]);
        assert!(curves.spectrum(2).is_err());
        assert_eq!([0.1, 0.3, 2.0, -0.5].map(|angle| curves.nearest(angle)), [0, 1, 1, 1]);
        let both = Curves { angle: vec![0.5, -0.5], ..curves.clone() };
        assert_eq!([0.5, -0.5].map(|angle| both.nearest(angle)), [0, 1]);
        assert_eq!(curves.deviation(0), None);
        assert_eq!(
            curves.csv(),
            "angle_deg,wavelength_nm,mean\n0,400,0.1\n0,500,0.2\n30,400,0.3\n30,500,0.4\n"
        );
        let spread = Curves { std: Some(vec![0.01; 4]), ..curves };
        assert_eq!(spread.deviation(1), Some(&[0.01, 0.01][..]));
        assert!(spread.csv().starts_with("angle_deg,wavelength_nm,mean,std\n0,400,0.1,0.01\n"));
        assert!(Curves::new(at, angle, vec![0.1; 3], None).is_err());
    }
}
