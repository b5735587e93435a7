//! Measured heightfields: NPY, TIFF, PNG, Gwyddion's own files, rows of numbers in text, Gwyddion's text export.
//!
//! `docs/formats/heights.md` says what is read as what. Formats are told apart by their content. Sizes that a header claims are
//! checked before anything is allocated for them.

mod gwyddion;
mod npy;
mod picture;
mod text;

use std::io::{BufRead as _, BufReader};
use std::path::Path;

use super::whole::{open_regular, read_at_most};
use crate::structure::{Cleaning, Heightfield, MOST_HEIGHTS};
use crate::{Error, Result};

/// The largest file: as many heights as are read, in double precision.
const LARGEST: u64 = (MOST_HEIGHTS as u64) * 8 + (1 << 16);

/// Bytes of a word of a line.
const PER_WORD: u64 = 64;

/// A header and more is among the first bytes of a file.
const HEAD: usize = 1 << 16;

/// A unit of heights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HeightUnit {
    /// 1e-6 m.
    #[default]
    Micrometre,
    /// 1e-9 m.
    Nanometre,
    /// 1 m.
    Metre,
}

impl HeightUnit {
    /// In µm.
    fn um(self) -> f64 {
        match self {
            Self::Micrometre => 1.0,
            Self::Nanometre => 1e-3,
            Self::Metre => 1e6,
        }
    }
}

/// Whether measured heights are made fit to repeat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Clean {
    /// Unless their opposite edges fit each other already.
    #[default]
    Auto,
    /// In any case.
    Always,
    /// Never.
    Never,
}

/// What a file does not say itself.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HeightsOptions {
    /// Distance of neighbours, µm.
    pub pitch_um: Option<f64>,
    /// Unit of numbers, where the file says none.
    pub unit: Option<HeightUnit>,
    /// Of pictures of whole numbers: height between black and white, µm.
    pub range_um: Option<f64>,
    /// Whether they are cleaned.
    pub clean: Clean,
}

/// Numbers of a file, as its rows follow each other.
struct Raw {
    cells: [usize; 2],
    values: Vec<f64>,
    /// Whether the first row is the top of a picture; else it is at y = 0.
    is_picture: bool,
    /// What a value of 1 is.
    scale: Scale,
    /// Sides, where the file says them, µm.
    size_um: Option<[f64; 2]>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Scale {
    /// In a unit that the file, by its length in µm, or the options say.
    Unit(Option<f64>),
    /// The whole range of a picture.
    Range,
}

/// Reads heights, µm, and cleans them as the options say: also whether that was done.
///
/// # Errors
/// The file is missing, too large, of none of the formats or damaged; the distance of neighbours or the range is not said, or
/// contradicts the file.
pub fn read_heights(path: &Path, options: &HeightsOptions) -> Result<(Heightfield, bool)> {
    let bytes = read_at_most(path, LARGEST)?;
    let raw = decode(&bytes).map_err(|error| error.in_file(path))?;
    // Cleaning needs the memory.
    drop(bytes);
    field(raw, options).map_err(|error| error.in_file(path))
}

/// Memory that [`read_heights`] takes at most at once, bytes, from the header of the file, or from counting the numbers of a
/// text; nothing where it is no regular file or cannot be read, which reading it will say.
#[must_use]
pub fn foretell_heights(path: &Path, options: &HeightsOptions) -> Option<u64> {
    let (file, length) = open_regular(path)?;
    let mut file = BufReader::with_capacity(HEAD, file);
    let head = file.fill_buf().ok()?;
    // What is decoded of a file beside its numbers, and how many these are.
    let (decoded, heights) = if head.starts_with(npy::MAGIC) {
        (0, npy::head(head).ok()?.heights)
    } else if head.starts_with(b"\x89PNG") {
        picture::head_of_png(file).ok()?
    } else if TIFF.iter().any(|magic| head.starts_with(magic)) {
        picture::head_of_tiff(file).ok()?
    } else if head.starts_with(gwyddion::MAGIC) {
        (0, usize::try_from(length / 8).ok()?)
    } else {
        let [all, longest] = text::count(file).ok()?;
        // Its ends of lines are made alike in a copy, and the words of a line stand apart.
        (2 * length + PER_WORD * longest as u64, all)
    };
    let numbers = (heights as u64).saturating_mul(8);
    let reading = length.saturating_add(decoded).saturating_add(numbers);
    // A copy that is cleaned, and one in order.
    let cleaning = if options.clean == Clean::Never { numbers } else { 3 * numbers };
    Some(reading.max(cleaning))
}

fn decode(bytes: &[u8]) -> Result<Raw> {
    if bytes.starts_with(npy::MAGIC) {
        npy::read(bytes)
    } else if bytes.starts_with(b"\x89PNG") {
        picture::read_png(bytes)
    } else if TIFF.iter().any(|magic| bytes.starts_with(magic)) {
        picture::read_tiff(bytes)
    } else if bytes.starts_with(gwyddion::MAGIC) {
        gwyddion::read(bytes)
    } else {
        text::read(bytes)
    }
}

/// The heightfield of a file's numbers, cleaned as the options say: also whether that was done.
fn field(mut raw: Raw, options: &HeightsOptions) -> Result<(Heightfield, bool)> {
    let scale_um = match raw.scale {
        Scale::Unit(own) => {
            if options.range_um.is_some() {
                let what =
                    "holds numbers with a unit, so `range_um` does not apply; give `unit`, or leave both out";
                return Err(Error::input(what).naming(&["range_um", "unit"]));
            }
            let asked = options.unit.map(HeightUnit::um);
            if let (Some(own), Some(asked)) = (own, asked)
                && (asked / own - 1.0).abs() > 1e-9
            {
                return Err(Error::input(format!(
                    "says that its numbers are {own} µm each, but `unit` says {asked} µm; leave `unit` out"
                ))
                .naming(&["unit"]));
            }
            own.or(asked).unwrap_or(HeightUnit::default().um())
        }
        Scale::Range if options.unit.is_some() => {
            let what =
                "is a picture of whole numbers, which have no unit; give `range_um` in place of `unit`";
            return Err(Error::input(what).naming(&["range_um", "unit"]));
        }
        Scale::Range => options.range_um.ok_or_else(|| {
            Error::input("is a picture; give `range_um`, the height in µm between its black and its white")
                .naming(&["range_um"])
        })?,
    };
    let size_um = match (raw.size_um, options.pitch_um) {
        (None, None) => {
            let what = "does not say how far its heights are apart; give `pitch_um`, their distance in µm";
            return Err(Error::input(what).naming(&["pitch_um"]));
        }
        (None, Some(pitch)) => raw.cells.map(|count| count as f64 * pitch),
        (Some(size), None) => size,
        (Some(size), Some(pitch)) => {
            let own = [0, 1].map(|axis| size[axis] / raw.cells[axis] as f64);
            if own.iter().any(|own| (pitch / own - 1.0).abs() > 0.01) {
                return Err(Error::input(format!(
                    "says that its heights are {} µm apart along x and {} µm along y, but `pitch_um` is {pitch}; leave `pitch_um` out",
                    own[0], own[1]
                ))
                .naming(&["pitch_um"]));
            }
            size
        }
    };
    let columns = raw.cells[0];
    if let Some(place) = raw.values.iter().position(|value| !value.is_finite()) {
        let (column, row) = (place % columns, place / columns);
        return Err(Error::input(format!("the height at column {column}, row {row} is not a finite number")));
    }
    if raw.is_picture {
        upside_down(&mut raw.values, columns);
    }
    let heights = raw.values.into_iter().map(|value| value * scale_um).collect();
    let field = Heightfield::new(raw.cells, size_um, heights)?;
    match options.clean {
        Clean::Auto if field.repeats() => Ok((field, false)),
        Clean::Never => Ok((field, false)),
        _ => Ok((field.cleaned(&Cleaning::default())?, true)),
    }
}

/// Refuses more heights than are read; how many there are.
fn count([columns, rows]: [usize; 2]) -> Result<usize> {
    columns
        .checked_mul(rows)
        .filter(|count| (1..=MOST_HEIGHTS).contains(count))
        .ok_or_else(|| Error::input(format!("has {columns} × {rows} heights; 1 to {MOST_HEIGHTS} are read")))
}

/// How TIFF begins: both orders of bytes, and with places of 64 bits.
const TIFF: [&[u8]; 4] = [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"];

/// Turns rows from the top of a picture into rows from y = 0.
fn upside_down(values: &mut [f64], columns: usize) {
    let rows = values.len() / columns;
    for row in 0..rows / 2 {
        let (above, below) = values.split_at_mut((rows - 1 - row) * columns);
        above[row * columns..][..columns].swap_with_slice(&mut below[..columns]);
    }
}

#[cfg(test)]
mod tests;
