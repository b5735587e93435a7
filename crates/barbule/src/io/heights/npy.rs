//! NumPy's `.npy`, versions 1 to 3: a header of three keys, then the numbers. (A reader of Python's literals would be far more
//! than those three keys need.)

use super::{Raw, Scale, count};
use crate::error::shortened;
use crate::{Error, Result};

pub(super) const MAGIC: &[u8] = b"\x93NUMPY";

/// The longest header: NumPy's own limit for untrusted files.
const LONGEST_HEADER: usize = 10_000;

fn damaged(what: &str) -> Error {
    Error::input(format!("is no NPY file of heights: {what}"))
}

/// What a header says.
pub(super) struct Head<'a> {
    cells: [usize; 2],
    pub(super) heights: usize,
    kind: &'a str,
    is_fortran: bool,
    is_big: bool,
    /// What follows it.
    data: &'a [u8],
}

/// Reads the header that these bytes begin with.
pub(super) fn head(bytes: &[u8]) -> Result<Head<'_>> {
    let truncated = || damaged("it ends within its header");
    let (version, rest) = bytes[MAGIC.len()..].split_first_chunk::<2>().ok_or_else(truncated)?;
    let (length, rest) = match version[0] {
        1 => rest.split_first_chunk::<2>().map(|(b, rest)| (usize::from(u16::from_le_bytes(*b)), rest)),
        2 | 3 => rest.split_first_chunk::<4>().map(|(b, rest)| (u32::from_le_bytes(*b) as usize, rest)),
        other => return Err(damaged(&format!("its version is {other}; 1 to 3 are read"))),
    }
    .ok_or_else(truncated)?;
    if length > LONGEST_HEADER {
        return Err(damaged("its header is longer than an array of numbers needs"));
    }
    let (header, data) = rest.split_at_checked(length).ok_or_else(truncated)?;
    let header = std::str::from_utf8(header).map_err(|_| damaged("its header is no text"))?;
    let after = |key: &str| {
        let at = header.find(&format!("'{key}'"))?;
        header[at + key.len() + 2..].trim_start().strip_prefix(':').map(str::trim_start)
    };
    let missing = |key: &str| damaged(&format!("its header has no key '{key}'"));
    let kind = after("descr").ok_or_else(|| missing("descr"))?;
    let kind = kind.strip_prefix('\'').and_then(|rest| rest.split_once('\'')).map(|(kind, _)| kind);
    let kind = kind.ok_or_else(|| damaged("it holds records; give an array of numbers"))?;
    let is_fortran = after("fortran_order").ok_or_else(|| missing("fortran_order"))?.starts_with("True");
    let shape = after("shape").ok_or_else(|| missing("shape"))?;
    let shape = shape.strip_prefix('(').and_then(|rest| rest.split_once(')')).map(|(shape, _)| shape);
    let shape: Option<Vec<usize>> = shape.and_then(|text| {
        text.split(',').map(str::trim).filter(|part| !part.is_empty()).map(|part| part.parse().ok()).collect()
    });
    let cells = match shape.as_deref() {
        Some([rows, columns]) => [*columns, *rows],
        Some([columns]) => [*columns, 1],
        Some(other) => {
            return Err(damaged(&format!("its shape has {} axes; heights have two, [y][x]", other.len())));
        }
        None => return Err(damaged("its shape is no tuple of numbers")),
    };
    let heights = count(cells)?;
    let (order, kind) = kind.split_at_checked(1).unwrap_or_default();
    let is_big = match order {
        "<" | "|" | "=" => false,
        ">" => true,
        _ => return Err(damaged("its type is none of numbers")),
    };
    Ok(Head { cells, heights, kind, is_fortran, is_big, data })
}

pub(super) fn read(bytes: &[u8]) -> Result<Raw> {
    let Head { cells, heights, kind, is_fortran, is_big, data } = head(bytes)?;
    let number = reader(kind, is_big).ok_or_else(|| {
        damaged(&format!("its type is '{}'; numbers f4, f8, i1 to i8 and u1 to u8 are read", shortened(kind)))
    })?;
    let width = usize::from(kind.as_bytes()[1] - b'0');
    if data.len() != heights * width {
        return Err(damaged(&format!(
            "{} bytes follow its header, but {} × {} numbers of {width} are {}",
            data.len(),
            cells[1],
            cells[0],
            heights * width
        )));
    }
    let read = |place: usize| number(&data[place * width..][..width]);
    let values = (0..heights).map(|place| match is_fortran {
        false => read(place),
        true => read((place % cells[0]) * cells[1] + place / cells[0]),
    });
    Ok(Raw { cells, values: values.collect(), is_picture: false, scale: Scale::Unit(None), size_um: None })
}

/// What reads a number of a kind as `f8` from its bytes.
fn reader(kind: &str, is_big: bool) -> Option<fn(&[u8]) -> f64> {
    macro_rules! of {
        ($($name:literal $type:ty),*) => {
            match (kind, is_big) {
                $(($name, false) => Some(|b: &[u8]| b.try_into().map_or(f64::NAN, |b| <$type>::from_le_bytes(b) as f64)),
                ($name, true) => Some(|b: &[u8]| b.try_into().map_or(f64::NAN, |b| <$type>::from_be_bytes(b) as f64)),)*
                _ => None,
            }
        };
    }
    of!("f4" f32, "f8" f64, "i1" i8, "i2" i16, "i4" i32, "i8" i64, "u1" u8, "u2" u16, "u4" u32, "u8" u64)
}
