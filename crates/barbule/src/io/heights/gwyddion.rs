//! Gwyddion's own files, format 2: tables within tables, each entry a name, a letter for its type, and the value. Of their channels the
//! first whose values are lengths is read.

use std::cell::Cell;

use super::text::unit_um;
use super::{Raw, Scale, count};
use crate::error::shortened;
use crate::{Error, Result};

/// How such a file begins.
pub(super) const MAGIC: &[u8] = b"GWYP";

/// How deep tables may lie in each other; a file of Gwyddion's has four.
const DEEPEST: usize = 16;

/// Most entries of all tables together.
const MOST_ENTRIES: usize = 1_000_000;

/// A value of an entry, as far as it is looked at.
enum Value<'a> {
    Integer(i32),
    Number(f64),
    Text(&'a str),
    /// Doubles, 8 bytes each.
    Numbers(&'a [u8]),
    Table(Table<'a>),
    Other,
}

/// Entries of a table, by names.
struct Table<'a> {
    kind: &'a str,
    entries: Vec<(&'a str, Value<'a>)>,
}

/// Bytes that are still to be read, and how many entries more they may have.
struct Bytes<'a> {
    rest: &'a [u8],
    entries: &'a Cell<usize>,
}

impl<'a> Bytes<'a> {
    fn take(&mut self, length: usize) -> Result<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(length).ok_or_else(cut)?;
        self.rest = rest;
        Ok(taken)
    }

    fn number(&mut self) -> Result<u32> {
        let (taken, rest) = self.rest.split_first_chunk::<4>().ok_or_else(cut)?;
        self.rest = rest;
        Ok(u32::from_le_bytes(*taken))
    }

    /// A text that ends in a zero.
    fn text(&mut self) -> Result<&'a str> {
        let length = self.rest.iter().position(|byte| *byte == 0).ok_or_else(cut)?;
        let text =
            std::str::from_utf8(&self.rest[..length]).map_err(|_| damaged("a name that is no text"))?;
        self.rest = &self.rest[length + 1..];
        Ok(text)
    }

    fn table(&mut self, depth: usize) -> Result<Table<'a>> {
        if depth > DEEPEST {
            return Err(damaged("tables that lie too deep in each other"));
        }
        let kind = self.text()?;
        let length = self.number()? as usize;
        let mut own = Self { rest: self.take(length)?, entries: self.entries };
        let mut entries = Vec::new();
        while !own.rest.is_empty() {
            let left = self.entries.get().checked_sub(1).ok_or_else(|| damaged("too many entries"))?;
            self.entries.set(left);
            entries.push((own.text()?, own.value(depth)?));
        }
        Ok(Table { kind, entries })
    }

    fn value(&mut self, depth: usize) -> Result<Value<'a>> {
        let kind = self.take(1)?[0];
        let mut array = |size: usize| -> Result<&'a [u8]> {
            let length = (self.number()? as usize).checked_mul(size).ok_or_else(cut)?;
            self.take(length)
        };
        Ok(match kind {
            b'C' => array(1).map(|_| Value::Other)?,
            b'I' => array(4).map(|_| Value::Other)?,
            b'Q' => array(8).map(|_| Value::Other)?,
            b'D' => Value::Numbers(array(8)?),
            b'b' | b'c' => self.take(1).map(|_| Value::Other)?,
            b'i' => Value::Integer(self.number()?.cast_signed()),
            b'q' => self.take(8).map(|_| Value::Other)?,
            b'd' => Value::Number(double(self.take(8)?)),
            b's' => Value::Text(self.text()?),
            b'o' => Value::Table(self.table(depth + 1)?),
            b'S' => {
                for _ in 0..self.number()? {
                    self.text()?;
                }
                Value::Other
            }
            b'O' => {
                for _ in 0..self.number()? {
                    self.table(depth + 1)?;
                }
                Value::Other
            }
            other => return Err(damaged(&format!("a value of unknown type {other}"))),
        })
    }
}

impl<'a> Table<'a> {
    fn get(&self, name: &str) -> Option<&Value<'a>> {
        self.entries.iter().find(|(known, _)| *known == name).map(|(_, value)| value)
    }

    /// A unit's text: that of metres where there is none, as Gwyddion takes it.
    fn unit(&self, name: &str) -> &str {
        let Some(Value::Table(unit)) = self.get(name) else { return "m" };
        match unit.get("unitstr") {
            Some(Value::Text(text)) => text.trim(),
            _ => "",
        }
    }

    /// Columns or rows.
    fn side(&self, name: &str) -> Result<usize> {
        match self.get(name) {
            Some(Value::Integer(side)) if *side > 0 => Ok(*side as usize),
            _ => Err(damaged(&format!("a channel without {name}"))),
        }
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<Raw> {
    let entries = Cell::new(MOST_ENTRIES);
    let mut rest = Bytes { rest: bytes.strip_prefix(MAGIC).unwrap_or_default(), entries: &entries };
    let file = rest.table(0)?;
    // Channels are /0/data, /1/data and so on.
    let number = |name: &str| name.strip_prefix('/')?.strip_suffix("/data")?.parse::<u32>().ok();
    let mut channels: Vec<(u32, &Table<'_>)> = file
        .entries
        .iter()
        .filter_map(|(name, value)| match value {
            Value::Table(table) if table.kind == "GwyDataField" => Some((number(name)?, table)),
            _ => None,
        })
        .collect();
    channels.sort_by_key(|(number, _)| *number);
    let Some((channel, unit)) =
        channels.iter().find_map(|(_, channel)| Some((*channel, unit_um(channel.unit("si_unit_z"))?)))
    else {
        let units: Vec<&str> = channels.iter().map(|(_, channel)| channel.unit("si_unit_z")).collect();
        return Err(Error::input(match &units[..] {
            [] => "has no channel of heights".to_owned(),
            units => format!("has no channel of heights: units are {}", shortened(&units.join(", "))),
        }));
    };
    let cells = [channel.side("xres")?, channel.side("yres")?];
    let values = match channel.get("data") {
        Some(Value::Numbers(bytes)) if bytes.len() == 8 * count(cells)? => bytes,
        _ => {
            return Err(damaged(&format!(
                "a channel that does not hold its {} × {} heights",
                cells[0], cells[1]
            )));
        }
    };
    let across = channel.unit("si_unit_xy");
    let length = unit_um(across)
        .ok_or_else(|| Error::input(format!("has sides in '{}', which is no length", shortened(across))))?;
    let side = |name: &str| match channel.get(name) {
        Some(Value::Number(side)) if *side > 0.0 && side.is_finite() => Ok(side * length),
        _ => Err(damaged(&format!("a channel without {name}"))),
    };
    Ok(Raw {
        cells,
        values: values.chunks_exact(8).map(double).collect(),
        is_picture: true,
        scale: Scale::Unit(Some(unit)),
        size_um: Some([side("xreal")?, side("yreal")?]),
    })
}

/// Eight bytes as a number; what is shorter is none.
fn double(bytes: &[u8]) -> f64 {
    bytes.first_chunk().map_or(f64::NAN, |bytes| f64::from_le_bytes(*bytes))
}

fn cut() -> Error {
    Error::input("is a Gwyddion file that ends too early; save it again")
}

fn damaged(what: &str) -> Error {
    Error::input(format!("is a damaged Gwyddion file, with {what}; save it again"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(name: &str, kind: u8, value: &[u8]) -> Vec<u8> {
        [name.as_bytes(), &[0, kind], value].concat()
    }

    fn table(kind: &str, entries: &[Vec<u8>]) -> Vec<u8> {
        let entries = entries.concat();
        [kind.as_bytes(), &[0], &(entries.len() as u32).to_le_bytes(), &entries].concat()
    }

    fn unit(name: &str, text: &str) -> Vec<u8> {
        entry(name, b'o', &table("GwySIUnit", &[entry("unitstr", b's', format!("{text}\0").as_bytes())]))
    }

    /// A channel of 3 × 2 values from `first` on, 6 × 4 µm.
    fn channel(unit_z: &str, first: f64, more: &[Vec<u8>]) -> Vec<u8> {
        let values: Vec<u8> = (0..6).flat_map(|k| (1e-9 * (first + f64::from(k))).to_le_bytes()).collect();
        let data = [&6_u32.to_le_bytes()[..], &values].concat();
        let entries = [
            vec![
                entry("xres", b'i', &3_i32.to_le_bytes()),
                entry("yres", b'i', &2_i32.to_le_bytes()),
                entry("xreal", b'd', &6e-6_f64.to_le_bytes()),
                entry("yreal", b'd', &4e-6_f64.to_le_bytes()),
                unit("si_unit_xy", "m"),
                unit("si_unit_z", unit_z),
                entry("data", b'D', &data),
            ],
            more.to_vec(),
        ]
        .concat();
        table("GwyDataField", &entries)
    }

    fn file(entries: &[Vec<u8>]) -> Vec<u8> {
        [MAGIC, &table("GwyContainer", entries)].concat()
    }

    /// A file as Gwyddion writes it: a channel of volts before that of heights, titles, a table of colours, lists.
    fn usual() -> Vec<u8> {
        file(&[
            entry("/filename", b's', b"/home/x.gwy\0"),
            entry("/1/data", b'o', &channel("m", 10.0, &[])),
            entry("/0/data", b'o', &channel("V", 0.0, &[])),
            entry("/0/data/title", b's', b"Deflection\0"),
            entry("/0/base/palette", b'C', &[2, 0, 0, 0, 1, 2]),
            entry("/0/data/visible", b'b', &[1]),
            entry("/0/graph", b'O', &[&1_u32.to_le_bytes()[..], &table("GwyGraph", &[])].concat()),
            entry("/0/words", b'S', b"\x02\0\0\0a\0b\0"),
            entry("/0/many", b'q', &[0; 8]),
        ])
    }

    #[test]
    fn the_first_channel_of_lengths_is_read_with_its_sides() {
        let raw = read(&usual()).unwrap();
        assert_eq!((raw.cells, raw.is_picture, raw.scale), ([3, 2], true, Scale::Unit(Some(1e6))));
        let size = raw.size_um.unwrap();
        assert!((size[0] - 6.0).abs() < 1e-12 && (size[1] - 4.0).abs() < 1e-12);
        assert!(raw.values.iter().zip(10..).all(|(value, k)| (value * 1e9 - f64::from(k)).abs() < 1e-9));
    }

    #[test]
    fn cut_damaged_and_foreign_files_are_refused() {
        let usual = usual();
        for cut in 4..usual.len() {
            assert!(read(&usual[..cut]).is_err_and(|error| error.is_input()), "{cut}");
        }
        let message = |bytes: &[u8]| read(bytes).err().unwrap().to_string();
        let volts = entry("/0/data", b'o', &channel("V", 0.0, &[]));
        assert!(message(&file(&[volts])).contains("no channel of heights: units are V"));
        assert!(message(&file(&[])).contains("has no channel of heights"));
        assert!(message(&file(&[entry("a", b'Z', &[])])).contains("unknown type 90"));
        // A count that the file does not have is refused before anything is allocated for it.
        let huge = entry("data", b'D', &u32::MAX.to_le_bytes());
        assert!(message(&file(&[huge])).contains("ends too early"));
        let few = channel("m", 0.0, &[]);
        let wide = few.iter().position(|byte| *byte == 3).unwrap();
        let mut wide_one = few.clone();
        wide_one[wide] = 200;
        assert!(
            message(&file(&[entry("/0/data", b'o', &wide_one)]))
                .contains("does not hold its 200 × 2 heights")
        );
        let mut deep = table("a", &[]);
        for _ in 0..40 {
            deep = table("a", &[entry("b", b'o', &deep)]);
        }
        assert!(message(&[MAGIC, &deep].concat()).contains("too deep"));
    }
}
