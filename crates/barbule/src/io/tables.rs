//! Readers of users' tables of refractive indices, and media named in other files.

use std::collections::BTreeMap;
use std::path::Path;

use saphyr_parser::{Event, Parser};

use super::measured::{Unit, position_unit};
use super::read_text;
use crate::error::shortened;
use crate::material::{Library, Material, Table};
use crate::{Complex64, Error, Result};

/// Nesting of YAML that is followed; the files of refractiveindex.info need 3.
const DEEPEST_YAML: usize = 32;

/// Wavelength, n and k.
const MOST_COLUMNS: usize = 3;

/// What people call n and k, in lower case and without signs: `Re(n)` is `ren`.
const INDEX_NAMES: [&[&str]; 2] = [
    &["n", "nreal", "realn", "ren", "nre", "real", "index", "ri", "refractiveindex", "refractiveindexn"],
    &["k", "kappa", "κ", "nimag", "imagn", "imn", "nim", "imag", "extinction", "extinctioncoefficient"],
];

/// Reads a table of indices: `.yml` and `.yaml` as refractiveindex.info writes them, anything else as CSV with the
/// columns nm, n and k (k may be left out where nothing absorbs), with or without a line of names; with names that are
/// known, n and k may change places.
///
/// # Errors
/// The file cannot be read, or a line is not as described; the message names it.
pub fn read_index_table(path: &Path) -> Result<Table> {
    let text = read_text(path)?;
    let name = path.display().to_string();
    let yaml =
        path.extension().is_some_and(|e| e.eq_ignore_ascii_case("yml") || e.eq_ignore_ascii_case("yaml"));
    let read = if yaml { parse_index_yaml } else { parse_index_csv };
    read(&name, &text).map_err(|error| error.of_file(path))
}

/// Reads CSV with the columns nm, n, k; `name` is what messages call the file.
///
/// # Errors
/// As [`read_index_table`].
pub fn parse_index_csv(name: &str, text: &str) -> Result<Table> {
    let sheet = Sheet::parse(name, text)?;
    let order = sheet.order(name)?;
    let mut rows = Vec::with_capacity(sheet.rows.len());
    for (line, row) in &sheet.rows {
        let at = |column: usize| if column < row.len() { row[column] } else { 0.0 };
        // A line's own number helps more than a row's.
        Material::constant(Complex64::new(at(order[0]), at(order[1])))
            .map_err(|e| e.in_line(*line).at(name))?;
        rows.push((row[0], Complex64::new(at(order[0]), at(order[1]))));
    }
    sheet.check_wavelengths(name)?;
    Table::new(name, &rows)
}

/// Numbers in lines, with the names of their columns if the file has them.
struct Sheet {
    names: Vec<String>,
    /// (line number from 1, numbers)
    rows: Vec<(usize, Vec<f64>)>,
}

impl Sheet {
    fn parse(name: &str, text: &str) -> Result<Self> {
        let mut sheet = Self { names: Vec::new(), rows: Vec::new() };
        for (i, line) in text.lines().enumerate() {
            let number = i + 1;
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let cells = cells(line, MOST_COLUMNS);
            if sheet.rows.is_empty() && sheet.names.is_empty() && number_of(cells[0]).is_none() {
                sheet.names = cells.iter().map(|c| c.trim_matches('"').to_lowercase()).collect();
                continue;
            }
            let here = |error: Error| error.in_line(number).at(name);
            if !(2..=MOST_COLUMNS).contains(&cells.len()) {
                let found = if cells.len() < 2 { "1 column" } else { "over 3 columns" };
                return Err(here(Error::input(format!(
                    "has {found}, but needs wavelength in nm, n and k, separated by commas"
                ))));
            }
            let mut row = Vec::with_capacity(cells.len());
            for (column, cell) in cells.iter().enumerate() {
                let value = number_of(cell).ok_or_else(|| {
                    Error::input(format!(
                        "{name}: line {number}, column {}: '{}' is not a finite number; write for example 1.56",
                        column + 1,
                        shortened(cell)
                    ))
                    .on_line(number, None)
                });
                row.push(value?);
            }
            if let Some((first, before)) = sheet.rows.first()
                && before.len() != row.len()
            {
                return Err(here(Error::input(format!(
                    "has {} columns, but line {first} has {}",
                    row.len(),
                    before.len()
                ))));
            }
            sheet.rows.push((number, row));
        }
        if sheet.rows.is_empty() {
            return Err(Error::input(format!(
                "{name}: has no lines of numbers; write lines such as 500,1.56,0.02"
            )));
        }
        Ok(sheet)
    }

    /// The columns of n and k: those that the names give, or 1 and 2 without names; k lies past the end where there
    /// is none.
    fn order(&self, name: &str) -> Result<[usize; 2]> {
        let columns = self.rows[0].1.len();
        let Some(first) = self.names.first() else { return Ok([1, 2]) };
        let refuse = |what: String| Err(Error::input(format!("{name}: {what}; name the columns nm,n,k")));
        if position_unit(first).is_none() {
            return refuse(format!(
                "the first column is '{}', but must be the wavelength in nm",
                shortened(first)
            ));
        }
        if self.names.len() != columns {
            return refuse(format!("{columns} columns have {} names", self.names.len()));
        }
        let mut order = [None; 2];
        for (column, given) in self.names.iter().enumerate().skip(1) {
            let word: String = given.chars().take(40).filter(|c| c.is_alphanumeric()).collect();
            let Some(which) = INDEX_NAMES.iter().position(|names| names.contains(&word.as_str())) else {
                return refuse(format!(
                    "column {} is '{}', which is neither n nor k",
                    column + 1,
                    shortened(given)
                ));
            };
            if order[which].replace(column).is_some() {
                return refuse(format!("column {} gives {} a second time", column + 1, ["n", "k"][which]));
            }
        }
        match order {
            [Some(n), k] => Ok([n, k.unwrap_or(columns)]),
            [None, _] => refuse("has no column of n".into()),
        }
    }

    /// Refuses wavelengths that do not rise, or are plainly in another unit.
    fn check_wavelengths(&self, name: &str) -> Result<()> {
        let unit = self.names.first().and_then(|first| position_unit(first));
        if unit == Some(Unit::PerCentimetre) {
            return Err(Error::input(format!(
                "{name}: the first column is wave numbers; write wavelengths in nm"
            )));
        }
        let micrometres = unit == Some(Unit::Micrometres);
        let largest = self.rows.iter().map(|(_, row)| row[0]).fold(0.0, f64::max);
        if micrometres || (largest > 0.0 && largest < 30.0) {
            return Err(Error::input(format!(
                "{name}: the wavelengths look like micrometres (the largest is {largest}); write them in nm"
            )));
        }
        for pair in self.rows.windows(2) {
            if pair[1].1[0] <= pair[0].1[0] {
                let error = Error::input(format!(
                    "the wavelength {} nm follows {} nm; sort the lines so that wavelengths rise",
                    pair[1].1[0], pair[0].1[0]
                ));
                return Err(error.in_line(pair[1].0).at(name));
            }
        }
        Ok(())
    }
}

/// Splits a line at commas, else semicolons, else blanks, into no more than one cell over `most`.
fn cells(line: &str, most: usize) -> Vec<&str> {
    for separator in [',', ';'] {
        if line.contains(separator) {
            return line.split(separator).take(most + 1).map(str::trim).collect();
        }
    }
    line.split_whitespace().take(most + 1).collect()
}

fn number_of(cell: &str) -> Option<f64> {
    cell.trim_matches('"').trim().parse::<f64>().ok().filter(|v| v.is_finite())
}

/// One `DATA` entry of a refractiveindex.info file.
#[derive(Default)]
struct Block {
    kind: String,
    data: String,
}

/// Reads the YAML of refractiveindex.info in its tabulated forms (`tabulated nk`, `tabulated n`, `tabulated k`;
/// wavelengths in µm there). Where n and k come apart, the table covers what both cover.
///
/// # Errors
/// Not YAML, no `DATA`, a formula in place of a table, no n, or lines that are not numbers; the message names them.
pub fn parse_index_yaml(name: &str, text: &str) -> Result<Table> {
    let blocks = data_blocks(text).map_err(|e| e.at(name))?;
    let refuse = |what: String| Err(Error::input(format!("{name}: {what}")));
    let (mut n, mut k) = (None, None);
    for (i, block) in blocks.iter().enumerate() {
        let place = format!("{name}: DATA[{i}]");
        let kind = block.kind.trim();
        let numbers = |columns| numbers(&place, &block.data, columns);
        let twice = match kind {
            "tabulated nk" => {
                let rows = numbers(3)?;
                let split = |c: usize| rows.iter().map(|row| (row[0], row[c])).collect::<Vec<_>>();
                n.replace(split(1)).is_some() | k.replace(split(2)).is_some()
            }
            "tabulated n" => n.replace(numbers(2)?.iter().map(|r| (r[0], r[1])).collect()).is_some(),
            "tabulated k" => k.replace(numbers(2)?.iter().map(|r| (r[0], r[1])).collect()).is_some(),
            other => {
                return refuse(format!(
                    "DATA[{i}] has the type '{}', but only tabulated nk, tabulated n and tabulated k are read; tabulate the formula",
                    shortened(other)
                ));
            }
        };
        if twice {
            return refuse(format!("DATA[{i}] gives n or k a second time; keep one table of each"));
        }
    }
    let Some(n) = n else {
        return refuse("has no table of n; DATA needs an entry of type tabulated n or tabulated nk".into());
    };
    Table::new(name, &joined(name, &n, k.as_deref())?)
}

/// One table from n and k on their own wavelengths in nm, over the range that both cover.
fn joined(name: &str, n: &[(f64, f64)], k: Option<&[(f64, f64)]>) -> Result<Vec<(f64, Complex64)>> {
    let Some(k) = k else { return Ok(n.iter().map(|&(nm, n)| (nm, n.into())).collect()) };
    let range = |rows: &[(f64, f64)]| (rows[0].0, rows[rows.len() - 1].0);
    let ((n_first, n_last), (k_first, k_last)) = (range(n), range(k));
    let (first, last) = (n_first.max(k_first), n_last.min(k_last));
    let mut at: Vec<f64> =
        n.iter().chain(k).map(|row| row.0).filter(|nm| (first..=last).contains(nm)).collect();
    if at.is_empty() {
        return Err(Error::input(format!(
            "{name}: n covers {n_first} to {n_last} nm and k covers {k_first} to {k_last} nm, which have nothing in common"
        )));
    }
    at.sort_by(f64::total_cmp);
    at.dedup();
    let value = |rows: &[(f64, f64)], nm: f64| {
        let after = rows.partition_point(|row| row.0 < nm);
        if rows[after].0 == nm {
            return rows[after].1;
        }
        let (low, high) = (rows[after - 1], rows[after]);
        let part = (nm - low.0) / (high.0 - low.0);
        low.1 * (1.0 - part) + high.1 * part
    };
    Ok(at.into_iter().map(|nm| (nm, Complex64::new(value(n, nm), value(k, nm)))).collect())
}

/// Lines of numbers in a YAML text block; the first column is turned from µm into nm and must rise.
fn numbers(place: &str, text: &str, columns: usize) -> Result<Vec<Vec<f64>>> {
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for (i, line) in text.lines().map(str::trim).filter(|line| !line.is_empty()).enumerate() {
        let row: Option<Vec<f64>> = cells(line, columns).into_iter().map(number_of).collect();
        let Some(mut row) = row.filter(|row| row.len() == columns) else {
            return Err(Error::input(format!(
                "{place}: line {} of data, '{}', is not {columns} numbers",
                i + 1,
                shortened(line)
            )));
        };
        // Rounded to 1e-9 nm, so that 0.4 µm is 400 nm.
        row[0] = (row[0] * 1e12).round() / 1e9;
        if row[0] <= rows.last().map_or(0.0, |before| before[0]) {
            return Err(Error::input(format!(
                "{place}: line {} of data: wavelengths must be positive and rise, but this is {} nm",
                i + 1,
                row[0]
            )));
        }
        rows.push(row);
    }
    if rows.is_empty() {
        return Err(Error::input(format!("{place}: has no lines of data")));
    }
    Ok(rows)
}

/// The `type` and `data` of each entry of the top-level list `DATA`, from YAML events: nothing is built for the rest.
fn data_blocks(text: &str) -> Result<Vec<Block>> {
    let mut blocks: Vec<Block> = Vec::new();
    // For each open collection: whether it is a mapping, and the key whose value comes next.
    let mut open: Vec<(bool, Option<String>)> = Vec::new();
    let mut found = false;
    let mut parser = Parser::new_from_str(text);
    while let Some(event) = parser.next_event() {
        let (event, _) =
            event.map_err(|e| Error::input(format!("is not YAML ({})", shortened(&e.to_string()))))?;
        let in_data = |open: &[(bool, Option<String>)], depth: usize| {
            open.len() == depth && open[0].1.as_deref() == Some("DATA") && depth > 1 && !open[1].0
        };
        match event {
            Event::MappingStart(..) | Event::SequenceStart(..) => {
                let mapping = matches!(event, Event::MappingStart(..));
                if mapping && in_data(&open, 2) {
                    blocks.push(Block::default());
                }
                if open.len() == 1 && open[0].1.as_deref() == Some("DATA") && !mapping {
                    found = true;
                }
                if open.len() >= DEEPEST_YAML {
                    return Err(Error::input(format!("is nested more than {DEEPEST_YAML} deep")));
                }
                // A collection as a key has no name.
                open.push((mapping, None));
            }
            Event::MappingEnd | Event::SequenceEnd => {
                open.pop();
                value_done(&mut open, None);
            }
            Event::Scalar(value, ..) => {
                if in_data(&open, 3)
                    && let (Some(block), (true, Some(key))) = (blocks.last_mut(), &open[2])
                {
                    match key.as_str() {
                        "type" => block.kind = value.to_string(),
                        "data" => block.data = value.to_string(),
                        _ => {}
                    }
                }
                value_done(&mut open, Some(&value));
            }
            Event::Alias(_) => return Err(Error::input("uses YAML aliases, which are not read here")),
            Event::DocumentEnd => break,
            _ => {}
        }
    }
    if !found {
        return Err(Error::input("has no list DATA; is it a file of refractiveindex.info?"));
    }
    if blocks.is_empty() {
        return Err(Error::input("the list DATA is empty"));
    }
    Ok(blocks)
}

/// Turns the innermost mapping from key to value or back.
fn value_done(open: &mut [(bool, Option<String>)], scalar: Option<&str>) {
    if let Some((true, key)) = open.last_mut() {
        *key = match key {
            Some(_) => None,
            None => Some(scalar.unwrap_or_default().to_owned()),
        };
    }
}

/// A medium as a structure's file gives it: the name of a table's file, or an index [n, k].
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(untagged, expecting = "a medium is the name of a file or an index [n, k]")]
pub enum MediumSource {
    /// A table's file, relative to the file that names it.
    File(String),
    /// n and k.
    Index([f64; 2]),
}

/// Adds the media that a structure's file defines to a library; `folder` is where that file lies.
///
/// # Errors
/// A name that cannot name a medium, an unusable index, or a table that cannot be read.
pub fn add_media(media: &BTreeMap<String, MediumSource>, folder: &Path, library: &mut Library) -> Result<()> {
    for (name, source) in media {
        let place = |e: Error| e.at(format!("materials.{}", shortened(name)));
        match source {
            MediumSource::File(file) => {
                library
                    .insert_table(name, read_index_table(&folder.join(file)).map_err(place)?)
                    .map_err(place)?;
            }
            MediumSource::Index([n, k]) => {
                let material = Material::constant(Complex64::new(*n, *k)).map_err(place)?;
                library.insert(name, material).map_err(place)?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn csv(text: &str) -> Result<Material> {
        parse_index_csv("t.csv", text).map(|t| Material::Table(t.into()))
    }

    fn yaml(text: &str) -> Result<Material> {
        parse_index_yaml("t.yml", text).map(|t| Material::Table(t.into()))
    }

    fn at(material: &Material, nm: f64) -> Complex64 {
        material.index(nm).unwrap()
    }

    #[test]
    fn csv_is_read_with_and_without_names_and_in_either_order() {
        let plain = csv("400,1.5,0.1\n500,1.7,0.3\n").unwrap();
        assert_eq!(at(&plain, 450.0), Complex64::new(1.6, 0.2));
        for same in [
            "nm,kappa,index\n400,0.1,1.5\n500,0.3,1.7",
            "nm,k,n_real\n400,0.1,1.5\n500,0.3,1.7",
            "Wavelength (nm),Re(n),Im(n)\n400,1.5,0.1\n500,1.7,0.3",
            "nm,n,k\n400,1.5,0.1\n500,1.7,0.3",
            "wavelength_nm;k;n\n400;0.1;1.5\n500;0.3;1.7\r\n",
            "# measured\n\n400 1.5 0.1\n500\t1.7  0.3",
        ] {
            assert_eq!(at(&csv(same).unwrap(), 450.0), at(&plain, 450.0), "{same}");
        }
        assert_eq!(at(&csv("nm,n\n400,1.5\n").unwrap(), 400.0), Complex64::new(1.5, 0.0));
    }

    #[test]
    fn bad_csv_is_refused_with_its_line() {
        for (text, part) in [
            ("", "no lines of numbers"),
            ("nm,n,k\n", "no lines of numbers"),
            ("400,1.5,0\n500,x,0", "line 2, column 2: 'x'"),
            ("400,1.5,0\n500,nan,0", "line 2, column 2: 'nan'"),
            ("400,1.5,0\n500,1e999,0", "not a finite number"),
            ("400\n", "line 1: has 1 column,"),
            ("400,1,2,3\n", "line 1: has over 3 columns"),
            ("400,1.5,0\n500,1.5", "but line 1 has 3"),
            ("500,1.5,0\n400,1.5,0", "line 2: the wavelength 400 nm follows 500 nm"),
            ("0.4,1.5,0\n0.5,1.5,0", "look like micrometres"),
            ("wl_um,n,k\n400,1.5,0", "look like micrometres"),
            ("n,nm,k\n1.5,400,0", "the first column is 'n'"),
            ("energy,n,k\n1.5,1.5,0", "the first column is 'energy', but must be the wavelength in nm"),
            ("nm,k\n400,0.1", "has no column of n; name the columns nm,n,k"),
            ("nm,eps1,eps2\n400,2.4,0.1", "column 2 is 'eps1', which is neither n nor k"),
            ("nm,n,x\n400,1.5,0.1", "column 3 is 'x', which is neither n nor k"),
            ("nm,n,index\n400,1.5,0.1", "column 3 gives n a second time"),
            ("nm,n\n400,1.5,0.1", "3 columns have 2 names"),
            ("1/cm,n,k\n20000,1.5,0.1", "wave numbers"),
            ("400,1.5,-0.1", "line 1: the index 1.5-0.1j has gain"),
            ("400,-1.5,0.1", "line 1: the index -1.5+0.1j is not usable"),
            ("-400,1.5,0.1", "not greater than zero"),
        ] {
            let message = csv(text).unwrap_err().to_string();
            assert!(message.starts_with("t.csv: ") && message.contains(part), "{text}: {message}");
        }
    }

    #[test]
    fn yaml_of_refractiveindex_info_is_read_in_its_tabulated_forms() {
        let nk = "REFERENCES: |\n  A. Author\nDATA:\n  - type: tabulated nk\n    data: |\n        0.4 1.5 0.1\n        0.5 1.7 0.3\nSPECS:\n  n_is_absolute: true\n";
        assert_eq!(at(&yaml(nk).unwrap(), 450.0), Complex64::new(1.6, 0.2));
        let apart = "DATA:\n  - type: tabulated n\n    data: |\n      0.3 1.4\n      0.5 1.8\n  - type: tabulated k\n    data: |\n      0.4 0.1\n      0.6 0.3\n";
        let Material::Table(table) = yaml(apart).unwrap() else { panic!() };
        assert_eq!(table.range_nm(), (400.0, 500.0));
        assert_eq!(table.wavelengths_nm(), [400.0, 500.0]);
        let index = at(&Material::Table(table), 450.0);
        assert!((index - Complex64::new(1.7, 0.15)).norm() < 1e-12);
        let only_n = "DATA: [{type: tabulated n, data: \"0.4 1.5\\n0.5 1.7\"}]";
        assert_eq!(at(&yaml(only_n).unwrap(), 400.0), Complex64::new(1.5, 0.0));
    }

    #[test]
    fn bad_yaml_is_refused() {
        let entry = |kind: &str, data: &str| format!("DATA:\n  - type: {kind}\n    data: |\n      {data}\n");
        for (text, part) in [
            (String::new(), "no list DATA"),
            ("- a\n- b\n".into(), "no list DATA"),
            ("DATA: 3\n".into(), "no list DATA"),
            ("DATA: []\n".into(), "DATA is empty"),
            ("DATA: {type: tabulated nk}\n".into(), "no list DATA"),
            ("DATA:\n - type: 'unclosed\n".into(), "is not YAML"),
            ("a: &x 1\nDATA: *x\n".into(), "aliases"),
            (entry("formula 1", "1 2 3"), "'formula 1'"),
            (entry("tabulated k", "0.4 0.1"), "no table of n"),
            (entry("tabulated nk", "0.4 1.5"), "DATA[0]: line 1 of data, '0.4 1.5', is not 3 numbers"),
            (entry("tabulated n", "0.4 nan"), "is not 2 numbers"),
            (entry("tabulated n", "-0.4 1.5"), "must be positive and rise"),
            (entry("tabulated nk", "0.4 1.5 -1"), "gain"),
            ("DATA:\n  - type: tabulated n\n".into(), "no lines of data"),
            ("[".repeat(40), "nested more than 32 deep"),
            ("[".repeat(100_000), "is not YAML"),
            (
                "DATA:\n - {type: tabulated n, data: \"0.4 1\"}\n - {type: tabulated n, data: \"0.4 1\"}"
                    .into(),
                "second time",
            ),
            (
                "DATA:\n - {type: tabulated n, data: \"0.4 1\"}\n - {type: tabulated k, data: \"0.5 1\"}"
                    .into(),
                "nothing in common",
            ),
        ] {
            let error = yaml(&text).unwrap_err();
            let message = error.to_string();
            assert!(error.is_input() && message.len() < 600);
            assert!(message.starts_with("t.yml: ") && message.contains(part), "{message}");
        }
    }

    #[test]
    fn media_of_a_file_are_added_under_their_names() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("c.csv"), "400,1.5,0\n700,1.5,0\n").unwrap();
        let media: BTreeMap<String, MediumSource> =
            serde_json::from_str(r#"{"chitin": "c.csv", "resin": [1.6, 0.01]}"#).unwrap();
        let mut library = Library::builtin();
        add_media(&media, folder.path(), &mut library).unwrap();
        assert_eq!(library.get("chitin").unwrap().index(500.0).unwrap().re, 1.5);
        assert_eq!(library.get("resin").unwrap().index(500.0).unwrap().im, 0.01);
        let bad: BTreeMap<String, MediumSource> = serde_json::from_str(r#"{"x": "none.csv"}"#).unwrap();
        let message = add_media(&bad, folder.path(), &mut library).unwrap_err().to_string();
        assert!(message.starts_with("materials.x: ") && message.contains("no such file"), "{message}");
    }
}
