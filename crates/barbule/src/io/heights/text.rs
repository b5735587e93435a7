//! Rows of numbers, and Gwyddion's export of them with the sizes in comments.

use std::borrow::Cow;
use std::io::{self, BufRead};

use super::{Raw, Scale};
use crate::error::shortened;
use crate::structure::MOST_HEIGHTS;
use crate::{Error, Result};

/// What Gwyddion's comments say.
#[derive(Default)]
struct Comments {
    width_um: Option<f64>,
    height_um: Option<f64>,
    unit_um: Option<f64>,
}

/// About how many numbers a text has, and how many its longest line, by the marks between them; read piece by piece.
pub(super) fn count(mut text: impl BufRead) -> io::Result<[usize; 2]> {
    // Of semicolons, tabs, commas and words, in all and in the longest line; comments count as well.
    let (mut all, mut longest, mut line) = ([0_usize; 4], [0_usize; 4], [0_usize; 4]);
    let (mut lines, mut in_word) = (0, false);
    loop {
        let piece = text.fill_buf()?;
        if piece.is_empty() {
            break;
        }
        for byte in piece {
            // Vertical tabs part words as well, and what is not ASCII may: each of its bytes counts as a word.
            let is_blank = byte.is_ascii_whitespace() || *byte == b'\x0b';
            match byte {
                b';' => line[0] += 1,
                b'\t' => line[1] += 1,
                b',' => line[2] += 1,
                b'\n' | b'\r' => {
                    lines += 1;
                    close(&mut all, &mut longest, &mut line);
                }
                _ if !byte.is_ascii() || !is_blank && !in_word => line[3] += 1,
                _ => {}
            }
            in_word = !is_blank && byte.is_ascii();
        }
        let length = piece.len();
        text.consume(length);
    }
    close(&mut all, &mut longest, &mut line);
    // A mark before or behind all words of a line parts none.
    Ok(match (0..3).find(|mark| all[*mark] > 0) {
        Some(mark) => [all[3].max(all[mark] + lines + 1), longest[3].max(longest[mark] + 1)],
        None => [all[3], longest[3]],
    })
}

/// Ends a line.
fn close(all: &mut [usize; 4], longest: &mut [usize; 4], line: &mut [usize; 4]) {
    for (kind, count) in std::mem::take(line).into_iter().enumerate() {
        all[kind] += count;
        longest[kind] = longest[kind].max(count);
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<Raw> {
    let text = decoded(bytes)?.replace("\r\n", "\n").replace('\r', "\n");
    let mut comments = Comments::default();
    for (number, line) in rows(&text) {
        if let Some(comment) = line.strip_prefix('#') {
            comments.read(comment).map_err(|what| Error::input(what).in_line(number))?;
        }
    }
    let (values, columns) = heights(&text)?;
    if comments.width_um.is_some() != comments.height_um.is_some() {
        let refusal = Error::input("says only one of Width and Height; give both, or neither and `pitch_um`");
        return Err(refusal.naming(&["pitch_um"]));
    }
    let size_um = comments.width_um.zip(comments.height_um).map(|(width, height)| [width, height]);
    let cells = [columns, values.len() / columns];
    // With sides it is an image.
    Ok(Raw { cells, values, is_picture: size_um.is_some(), scale: Scale::Unit(comments.unit_um), size_um })
}

/// The text of a file: UTF-8, or else Latin-1, as instruments' programs write µ as one byte.
fn decoded(bytes: &[u8]) -> Result<Cow<'_, str>> {
    if let Ok(text) = std::str::from_utf8(bytes) {
        return Ok(text.strip_prefix('\u{feff}').unwrap_or(text).into());
    }
    // What is no text at all has other control characters.
    if bytes.iter().any(|b| *b < 0x20 && !matches!(b, b'\t' | b'\n' | b'\r' | 0x0c)) {
        return Err(Error::input(
            "is no heightfield: give an NPY, TIFF, PNG or .gwy file, or rows of numbers in text",
        ));
    }
    Ok(bytes.iter().map(|b| char::from(*b)).collect::<String>().into())
}

/// Lines that are not empty, with their numbers.
fn rows(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let numbered = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    numbered.filter(|(_, line)| !line.is_empty())
}

/// The heights, one row after the other, and how many each row has.
fn heights(text: &str) -> Result<(Vec<f64>, usize)> {
    // Where semicolons or tabs separate, commas are decimal; else commas separate, and blanks where there is none.
    let data = || rows(text).filter(|(_, line)| !line.starts_with('#'));
    let separator = [';', '\t', ','].into_iter().find(|mark| data().any(|(_, line)| line.contains(*mark)));
    let is_wide = matches!(separator, Some(';' | '\t'));
    let words = |line: &str| -> Vec<String> {
        match separator {
            // One at the end of a line ends it.
            Some(mark) => line
                .strip_suffix(mark)
                .unwrap_or(line)
                .split(mark)
                .map(|word| word.trim().to_owned())
                .collect(),
            None => line.split_whitespace().map(str::to_owned).collect(),
        }
    };
    let (mut values, mut columns) = (Vec::new(), 0);
    for (number, line) in data() {
        let before = values.len();
        for word in words(line) {
            let value = if is_wide { word.replace(',', ".").parse() } else { word.parse() };
            let value: f64 = value.map_err(|_| {
                Error::input(format!(
                    "line {number}, column {}: '{}' is no number; give rows of heights with one separator, comments begin with #",
                    values.len() - before + 1,
                    shortened(&word)
                ))
                .on_line(number, None)
            })?;
            if values.len() == MOST_HEIGHTS {
                return Err(Error::input(format!("has over {MOST_HEIGHTS} heights; give a part of them")));
            }
            values.push(value);
        }
        let found = values.len() - before;
        if columns == 0 {
            columns = found;
        }
        if found != columns {
            let error = Error::input(format!(
                "line {number} has {found} heights, but those before it have {columns}; give rows of equal length"
            ));
            return Err(error.on_line(number, None));
        }
    }
    if values.is_empty() {
        return Err(Error::input("has no heights: give rows of numbers"));
    }
    Ok((values, columns))
}

impl Comments {
    fn read(&mut self, comment: &str) -> std::result::Result<(), String> {
        let Some((name, value)) = comment.split_once(':') else { return Ok(()) };
        let value = value.trim();
        match name.trim() {
            "Width" => self.width_um = Some(length_um(value)?),
            "Height" => self.height_um = Some(length_um(value)?),
            "Value units" => self.unit_um = Some(unit_um(value).ok_or_else(|| unknown(value))?),
            _ => {}
        }
        Ok(())
    }
}

fn unknown(text: &str) -> String {
    format!("'{}' is no length in m, mm, µm, nm or pm", shortened(text))
}

/// A length such as `65.0 µm`, in µm.
fn length_um(text: &str) -> std::result::Result<f64, String> {
    let (number, unit) = text.split_once(char::is_whitespace).ok_or_else(|| unknown(text))?;
    let factor = unit_um(unit.trim()).ok_or_else(|| unknown(text))?;
    let number =
        number.replace(',', ".").parse::<f64>().ok().filter(|value| *value > 0.0 && value.is_finite());
    number.map(|number| number * factor).ok_or_else(|| unknown(text))
}

/// A unit of length in µm.
pub(super) fn unit_um(text: &str) -> Option<f64> {
    match text {
        "m" => Some(1e6),
        "mm" => Some(1e3),
        "µm" | "μm" | "um" => Some(1.0),
        "nm" => Some(1e-3),
        "pm" => Some(1e-6),
        _ => None,
    }
}
