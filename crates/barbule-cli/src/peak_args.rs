//! Which peak of a spectrum is meant.

use barbule::spectrum::Wavelengths;
use barbule::spectrum::look::{Look, order_notes};
use barbule::{Error, Result};
use clap::Args;

use crate::sets;

/// The flag of commands that print peaks.
#[derive(Debug, Clone, Args)]
pub(crate) struct PeakArgs {
    /// Wavelengths in nm within which the highest peak is the one that is meant, as in 400:700 [default: all]
    #[arg(long = "peak-range", value_name = "FROM:TO", value_parser = |text: &str| sets::range_nm("--peak-range", text))]
    range_nm: Option<[f64; 2]>,
}

impl PeakArgs {
    /// The range, of which some of the wavelengths must lie inside.
    ///
    /// # Errors
    /// None does.
    pub(crate) fn within(&self, at: &Wavelengths) -> Result<Option<[f64; 2]>> {
        let Some([from, to]) = self.range_nm else { return Ok(None) };
        if at.iter().any(|nm| (from..=to).contains(nm)) {
            return Ok(self.range_nm);
        }
        let (first, last) = at.range_nm();
        Err(Error::input(format!(
            "--peak-range {from}:{to}: none of the wavelengths from {first} to {last} nm lies within; give --wavelengths there"
        )))
    }
}

/// What to tell of the peaks of a series of angles, and what to do where one is lost.
pub(crate) fn notes(angles_deg: &[f64], looks: &[Look]) -> Vec<String> {
    let mut notes = order_notes(angles_deg, looks);
    if let Some(last) = notes.last_mut().filter(|_| looks.iter().any(|look| look.lost.is_some())) {
        *last += "; --peak-range follows another";
    }
    notes
}
