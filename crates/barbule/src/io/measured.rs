//! Measured reflectance spectra as spectrometers, R and spreadsheets write them.
//!
//! [`read_measured`] reads tables of text and JCAMP-DX. What it guesses it says in one
//! sentence; where two readings are possible it refuses and names the choice.

mod columns;
mod jcamp;
mod long;
mod names;
mod resample;
mod scale;
mod series;
mod table;
#[cfg(test)]
mod tests;

use std::path::Path;

pub(super) use names::position_unit;
pub use series::{AtAngle, Measurements, read_measurements};

use super::read_at_most;
pub use super::whole::LARGEST_TABLE;
use crate::error::{counted, shortened};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::{Error, Result};

/// What is kept, nm: where structures are simulated. Spectrometers reach further, into their own noise.
const KEPT_NM: [f64; 2] = [300.0, 830.0];
/// The largest table: wavelengths, columns, and numbers in all.
const MOST_ROWS: usize = 100_000;
const MOST_COLUMNS: usize = 2_000;
const MOST_NUMBERS: usize = 4_000_000;
/// A step between wavelengths is a hole if it is over so many nm, and over so many times the usual step.
const HOLE_NM: f64 = 20.0;
const HOLE_STEPS: f64 = 3.0;
/// Wavelengths beyond these, nm, are typing errors: of light none are measured there.
const POSSIBLE_NM: [f64; 2] = [1.0, 1e6];
/// Values beyond it are typing errors, and deviations of them no numbers.
const LARGEST_VALUE: f64 = 1e100;

/// In which unit the values of a file are, when the user says so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// 0 to 100.
    Percent,
    /// 0 to 1.
    Fraction,
    /// No reflectance: a lamp's power, in whatever unit.
    Power,
}

/// One measured sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// The name of its column, or the title of its block, shortened.
    pub name: String,
    /// Reflectance as a part of 1.
    pub spectrum: Spectrum,
}

/// What a file of measurements holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// The samples, at least one, all at the same wavelengths.
    pub samples: Vec<Sample>,
    /// Their mean.
    pub mean: Spectrum,
    /// Their standard deviation, one number per wavelength; none of a single sample.
    pub std: Option<Vec<f64>>,
    /// How the file was read, in one sentence: what was found and what was guessed.
    pub reading: String,
}

/// Reads the measured reflectance of one or several samples; `column` is the name of one or its number from 1.
///
/// Read are tables of text (commas, semicolons, tabs or blanks; points or commas as decimal signs; with or without a
/// line of names; the row numbers of R and pandas; the headers of spectrometers; one column for each sample, or one line for
/// each wavelength of each sample, which `column` then names) and JCAMP-DX (`.jdx`, `.dx`). Wavelengths in nm, or in µm or
/// wave numbers in 1/cm where the file says so; reflectance as a part of 1 or in percent.
///
/// # Errors
/// The file cannot be read, is no such file, or can be read in two ways; the message names the line or the choice.
pub fn read_measured(path: &Path, column: Option<&str>, scale: Option<Scale>) -> Result<Measured> {
    let bytes = read_at_most(path, LARGEST_TABLE)?;
    parse_measured(&path.display().to_string(), &bytes, column, scale).map_err(|error| error.of_file(path))
}

/// Reads measurements from a file's bytes; `name` is what messages call the file.
///
/// # Errors
/// As [`read_measured`].
pub fn parse_measured(
    name: &str,
    bytes: &[u8],
    column: Option<&str>,
    scale: Option<Scale>,
) -> Result<Measured> {
    let text = decoded(bytes).map_err(|e| e.at(name))?;
    let found = if jcamp::is_jcamp(&text) {
        jcamp::read(&text, column)
    } else {
        match long::read(&text, column) {
            Ok(Some(found)) => Ok(found),
            Ok(None) => {
                let is_of_light = scale == Some(Scale::Power);
                table::read(&text).and_then(|table| columns::choose(table, column, is_of_light))
            }
            Err(error) => Err(error),
        }
    };
    found.and_then(|found| found.finish(scale)).map_err(|e| e.at(name)).map(|mut measured| {
        measured.reading = format!("{name}: {}", measured.reading);
        measured
    })
}

/// The text of a file: UTF-8, UTF-16 with its mark, or else Latin-1, which spectrometers write for µ and °.
fn decoded(bytes: &[u8]) -> Result<String> {
    if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(&[0xd0, 0xcf, 0x11, 0xe0]) {
        return Err(Error::input("is a spreadsheet or an archive, not text; save the sheet as CSV"));
    }
    let utf16 = |wide: &[u8], unit: fn([u8; 2]) -> u16| {
        let units = wide.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
        char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect::<String>()
    };
    let text = match bytes {
        [0xff, 0xfe, wide @ ..] => utf16(wide, u16::from_le_bytes),
        [0xfe, 0xff, wide @ ..] => utf16(wide, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => latin(rest),
        _ => latin(bytes),
    };
    if text.contains('\0') {
        return Err(Error::input("is not text; export the spectrum as text, CSV or JCAMP-DX"));
    }
    Ok(text)
}

fn latin(bytes: &[u8]) -> String {
    std::str::from_utf8(bytes).map_or_else(|_| bytes.iter().map(|&b| char::from(b)).collect(), str::to_owned)
}

/// The lines of a text with their numbers from 1, whatever ends them.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let end = if text.contains('\n') { '\n' } else { '\r' };
    text.split(end).map(str::trim_end).enumerate().map(|(i, line)| (i + 1, line))
}

/// What a column of positions is measured in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unit {
    Nanometres,
    Micrometres,
    PerCentimetre,
}

impl Unit {
    fn nm(self, value: f64) -> f64 {
        match self {
            Self::Nanometres => value,
            // Rounded to 1e-9 nm, so that 0.4 µm is 400 nm.
            Self::Micrometres => (value * 1e12).round() / 1e9,
            Self::PerCentimetre => 1e7 / value,
        }
    }
}

/// Positions and values before their units and order are settled.
struct Found {
    /// What has been guessed so far.
    said: Vec<String>,
    /// What the positions are called in messages, as in `'wl'` or `column 1`.
    position: String,
    unit: Unit,
    /// Positions with the lines they stand in.
    rows: Vec<(usize, f64)>,
    /// (name, shortened; one value per row, NaN where it is missing).
    samples: Vec<(String, Vec<f64>)>,
    /// Whether the name or cells of each sample say percent.
    percent: Vec<bool>,
}

impl Found {
    fn finish(mut self, scale: Option<Scale>) -> Result<Measured> {
        self.say_missing()?;
        self.check_values()?;
        self.convert()?;
        self.rise()?;
        self.keep()?;
        self.say_holes();
        let mut said = std::mem::take(&mut self.said);
        said.extend(self.scale(scale)?);
        let below = self.samples.iter().flat_map(|(_, values)| values).filter(|v| **v < 0.0).count();
        if below > 0 {
            said.push(format!("{} below zero", counted(below, "value")));
        }
        let nm: Vec<f64> = self.rows.iter().map(|row| row.1).collect();
        let at = Wavelengths::new(nm)?;
        let samples = self
            .samples
            .into_iter()
            .map(|(name, values)| Ok(Sample { name, spectrum: Spectrum::new(at.clone(), values)? }))
            .collect::<Result<Vec<_>>>()?;
        let (mean, std) = mean(&samples, &at)?;
        Ok(Measured { samples, mean, std, reading: said.join("; ") })
    }

    /// Leaves out lines where a position or a sample has no number.
    fn say_missing(&mut self) -> Result<()> {
        let known: Vec<bool> = (0..self.rows.len())
            .map(|i| self.rows[i].1.is_finite() && self.samples.iter().all(|(_, v)| v[i].is_finite()))
            .collect();
        let lost = known.iter().filter(|known| !**known).count();
        if lost == known.len() {
            let refusal =
                Error::input("no line has a number for every sample; name one sample with `column`");
            return Err(refusal.naming(&["column"]));
        }
        if lost > 0 {
            self.said.push(format!("{} with missing values left out", counted(lost, "line")));
            self.retain(|i| known[i]);
        }
        Ok(())
    }

    /// Refuses values that no sample and no lamp has.
    fn check_values(&self) -> Result<()> {
        for (name, values) in &self.samples {
            if let Some((row, value)) =
                self.rows.iter().zip(values).find(|(_, value)| value.abs() > LARGEST_VALUE)
            {
                let error = Error::input(format!(
                    "'{}' has the value {value:e}, which is no reflectance; the file may be damaged",
                    shortened(name)
                ));
                return Err(error.in_line(row.0));
            }
        }
        Ok(())
    }

    fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        let only = |i: &mut usize| {
            *i += 1;
            keep(*i - 1)
        };
        let mut at = 0;
        self.rows.retain(|_| only(&mut at));
        for (_, values) in &mut self.samples {
            let mut at = 0;
            values.retain(|_| only(&mut at));
        }
    }

    /// Turns positions into nm.
    fn convert(&mut self) -> Result<()> {
        if let Some((line, bad)) = self.rows.iter().find(|row| row.1 <= 0.0) {
            let error =
                Error::input(format!("the wavelength {bad} in {} is not greater than zero", self.position));
            return Err(error.in_line(*line));
        }
        let largest = self.rows.iter().map(|row| row.1).fold(0.0, f64::max);
        if self.unit == Unit::Nanometres && largest < 30.0 {
            return Err(Error::input(format!(
                "the wavelengths in {} look like micrometres (the largest is {largest}); write them in nm, or name the column um",
                self.position
            )));
        }
        let [shortest, longest] = POSSIBLE_NM;
        for row in &mut self.rows {
            let nm = self.unit.nm(row.1);
            if !(shortest..=longest).contains(&nm) {
                let error = Error::input(format!(
                    "{:e} in {} is no wavelength of light, which has {shortest} to {longest} nm",
                    row.1, self.position
                ));
                return Err(error.in_line(row.0));
            }
            row.1 = nm;
        }
        let (first, last) = (self.rows[0].1, self.rows[self.rows.len() - 1].1);
        let from = match self.unit {
            Unit::Nanometres => "",
            Unit::Micrometres => ", µm turned into nm",
            Unit::PerCentimetre => ", 1/cm turned into nm",
        };
        let short = |nm: f64| (nm * 100.0).round() / 100.0;
        let (low, high) = (short(first.min(last)), short(first.max(last)));
        self.said.push(format!("wavelengths from {} ({low}–{high} nm{from})", self.position));
        Ok(())
    }

    /// Sorts falling wavelengths and averages doubled ones.
    fn rise(&mut self) -> Result<()> {
        if self.rows.len() > 1 && self.rows[0].1 > self.rows[self.rows.len() - 1].1 {
            self.rows.reverse();
            self.samples.iter_mut().for_each(|(_, values)| values.reverse());
            self.said.push("falling wavelengths turned round".into());
        }
        if let Some(pair) = self.rows.windows(2).find(|pair| pair[1].1 < pair[0].1) {
            let error = Error::input(format!(
                "the wavelength {} nm is out of order beside {} nm in line {}; sort the lines, and give each sample a column of its own",
                pair[1].1, pair[0].1, pair[0].0
            ));
            return Err(error.in_line(pair[1].0));
        }
        let starts: Vec<usize> =
            (0..self.rows.len()).filter(|&i| i == 0 || self.rows[i].1 > self.rows[i - 1].1).collect();
        let doubled = self.rows.len() - starts.len();
        if doubled > 0 {
            let ends = starts.iter().skip(1).copied().chain([self.rows.len()]);
            let runs: Vec<_> = starts.iter().copied().zip(ends).collect();
            for (_, values) in &mut self.samples {
                let mean =
                    |&(from, to): &(usize, usize)| values[from..to].iter().sum::<f64>() / (to - from) as f64;
                *values = runs.iter().map(mean).collect();
            }
            self.rows = starts.iter().map(|&i| self.rows[i]).collect();
            self.said.push(format!("{} averaged", counted(doubled, "doubled wavelength")));
        }
        Ok(())
    }

    /// Keeps what can be compared.
    fn keep(&mut self) -> Result<()> {
        let [from, to] = KEPT_NM;
        let (first, last) = (self.rows[0].1, self.rows[self.rows.len() - 1].1);
        let inside: Vec<bool> = self.rows.iter().map(|row| (from..=to).contains(&row.1)).collect();
        if inside.iter().filter(|inside| **inside).count() < 2 {
            return Err(Error::input(format!(
                "the wavelengths in {} go from {first} to {last} nm, of which fewer than two lie within {from} to {to} nm; give a spectrum of what can be simulated",
                self.position
            )));
        }
        if inside.contains(&false) {
            self.retain(|i| inside[i]);
            let (first, last) = (self.rows[0].1, self.rows[self.rows.len() - 1].1);
            self.said.push(format!("{first}–{last} nm kept"));
        }
        Ok(())
    }

    /// Says where values are missing within the spectrum, since between its wavelengths it is a straight line.
    fn say_holes(&mut self) {
        // In the file's own unit, since even steps in 1/cm are uneven ones in nm.
        let per_cm = self.unit == Unit::PerCentimetre;
        let own = |nm: f64| if per_cm { 1e7 / nm } else { nm };
        let step = |from: f64, to: f64| (own(to) - own(from)).abs();
        let pairs: Vec<[f64; 2]> = self.rows.windows(2).map(|pair| [pair[0].1, pair[1].1]).collect();
        let mut steps: Vec<f64> = pairs.iter().map(|&[from, to]| step(from, to)).collect();
        steps.sort_by(f64::total_cmp);
        let Some(&usual) = steps.get(steps.len().saturating_sub(1) / 2) else { return };
        let is_hole = |from: f64, to: f64| to - from > HOLE_NM && step(from, to) > HOLE_STEPS * usual;
        let holes: Vec<[f64; 2]> = pairs.into_iter().filter(|&[from, to]| is_hole(from, to)).collect();
        let widest = holes.iter().max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
        let Some(&[from, to]) = widest else { return };
        let short = |nm: f64| (nm * 100.0).round() / 100.0;
        let others = match holes.len() - 1 {
            0 => String::new(),
            more => format!(", and {}", counted(more, "more hole")),
        };
        self.said.push(format!(
            "no values from {} to {} nm{others}: a straight line is taken there",
            short(from),
            short(to)
        ));
    }
}

/// Mean and standard deviation over samples at the same wavelengths.
fn mean(samples: &[Sample], at: &Wavelengths) -> Result<(Spectrum, Option<Vec<f64>>)> {
    let count = samples.len() as f64;
    let of = |i: usize| samples.iter().map(move |sample| sample.spectrum.values()[i]);
    let mean: Vec<f64> = (0..at.len()).map(|i| of(i).sum::<f64>() / count).collect();
    let std = (samples.len() > 1).then(|| {
        let square = |i: usize| of(i).map(|v| (v - mean[i]).powi(2)).sum::<f64>() / (count - 1.0);
        (0..at.len()).map(|i| square(i).sqrt()).collect()
    });
    Ok((Spectrum::new(at.clone(), mean)?, std))
}
