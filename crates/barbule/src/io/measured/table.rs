//! Tables of numbers in text: which sign separates cells, which is the decimal sign, where the numbers begin.

use std::borrow::Cow;

use super::columns::is_count;
use super::names::position_unit;
use super::{MOST_COLUMNS, MOST_NUMBERS, MOST_ROWS, lines};
use crate::error::shortened;
use crate::{Error, Result};

/// What stands between cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Separator {
    Sign(char),
    Blanks,
}

impl Separator {
    /// In the order of trust: a tab is never part of a number or of a name.
    pub(super) const ALL: [Self; 5] =
        [Self::Sign('\t'), Self::Sign(';'), Self::Sign(','), Self::Sign('|'), Self::Blanks];

    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Sign('\t') => "tabs",
            Self::Sign(';') => "semicolons",
            Self::Sign('|') => "bars",
            Self::Sign(_) => "commas",
            Self::Blanks => "blanks",
        }
    }
}

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Style {
    pub(super) separator: Separator,
    pub(super) decimal_comma: bool,
}

/// A cell that is one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cell {
    Number(f64),
    Percent(f64),
    Missing,
}

/// What programs write where there is no number.
const MISSING: [&str; 9] = ["", "na", "nan", "n/a", "null", "-", "--", "#n/a", "#div/0!"];

impl Style {
    fn every() -> impl Iterator<Item = Self> {
        Separator::ALL
            .into_iter()
            .flat_map(|separator| [false, true].map(|decimal_comma| Self { separator, decimal_comma }))
    }

    /// The cells of a line; a separator between double quotes does not count.
    pub(super) fn cells(self, line: &str) -> impl Iterator<Item = Cow<'_, str>> {
        let mut rest = Some(line);
        std::iter::from_fn(move || {
            let text = match self.separator {
                Separator::Blanks => rest?.trim_start(),
                Separator::Sign(_) => rest?,
            };
            if self.separator == Separator::Blanks && text.is_empty() {
                return None;
            }
            let mut quoted = false;
            let end = text.char_indices().find(|&(_, c)| {
                quoted ^= c == '"';
                !quoted
                    && match self.separator {
                        Separator::Sign(sign) => c == sign,
                        Separator::Blanks => c.is_whitespace(),
                    }
            });
            let cell = end.map_or(text, |(at, _)| &text[..at]);
            rest = end.map(|(at, c)| &text[at + c.len_utf8()..]);
            Some(unquoted(cell))
        })
    }

    pub(super) fn cell(self, text: &str) -> Option<Cell> {
        let percent = text.ends_with('%');
        let text = text.trim_end_matches('%').trim_end();
        let number = if self.decimal_comma {
            if text.contains('.') {
                return None;
            }
            text.replacen(',', ".", 1).parse()
        } else {
            text.parse::<f64>()
        };
        match number {
            Ok(value) if value.is_finite() => {
                Some(if percent { Cell::Percent(value) } else { Cell::Number(value) })
            }
            // "nan" parses, 1e999 too: one is missing, the other is no number.
            _ => MISSING.iter().any(|m| m.eq_ignore_ascii_case(text)).then_some(Cell::Missing),
        }
    }

    /// How many cells a line of numbers has; none where it is not one.
    fn numbers(self, line: &str) -> Option<usize> {
        let (mut cells, mut known) = (0, 0);
        for text in self.cells(line) {
            known += usize::from(self.cell(&text)? != Cell::Missing);
            cells += 1;
        }
        (known > 0 && cells > 1).then_some(cells)
    }
}

fn unquoted(cell: &str) -> Cow<'_, str> {
    let cell = cell.trim();
    match cell.strip_prefix('"').and_then(|c| c.strip_suffix('"')) {
        Some(inside) if inside.contains('"') => inside.replace("\"\"", "\"").trim().to_owned().into(),
        Some(inside) => inside.trim().into(),
        None => cell.into(),
    }
}

/// A table with the names of its columns.
pub(super) struct Table {
    /// What has been guessed.
    pub(super) said: String,
    /// One for each column; empty where it has none.
    pub(super) names: Vec<String>,
    /// The line of each row.
    pub(super) lines: Vec<usize>,
    /// `[column][row]`, NaN where a cell is missing.
    pub(super) columns: Vec<Vec<f64>>,
    /// Whether a cell of a column ends in %.
    pub(super) percent: Vec<bool>,
    /// The first cell of the line of names that is no number, where it may be a line of numbers with a typing error:
    /// line, column from 1, text.
    pub(super) spoilt: Option<(usize, usize, String)>,
}

/// Reads a table: everything before its first line of numbers is a header, everything after is numbers.
pub(super) fn read(text: &str) -> Result<Table> {
    if lines(text).nth(2 * MOST_ROWS).is_some() {
        return Err(Error::input(format!("has over {} lines", 2 * MOST_ROWS)));
    }
    let begin = lines(text).find(|(_, line)| line.starts_with(">>>>>Begin")).map_or(0, |(line, _)| line);
    let body: Vec<(usize, &str)> = lines(text)
        .skip(begin)
        .take_while(|(_, line)| !line.starts_with(">>>>>End"))
        .filter(|(_, line)| !line.trim().is_empty())
        .collect();
    let style = style(&body)?;
    let width = width(&body, style);
    let start = body.iter().position(|(_, line)| style.numbers(line) == Some(width)).unwrap_or_default();
    // pandas numbers columns without names, and leaves the name of its row numbers empty: that line is one of numbers, too.
    let counted = numbered_names(body[start].1, style, width).filter(|_| start + 1 < body.len());
    let first = start + usize::from(counted.is_some());
    let (percent, table_lines, columns) = numbers(&body[first..], style, width)?;
    let (names, spoilt) = match counted {
        Some(names) => (names, None),
        None => header(lines(text).take(body[start].0 - 1).skip(begin), style, &columns)?,
    };
    let origin = if begin > 0 { "spectrometer text, " } else { "" };
    let decimal = if style.decimal_comma { ", decimal commas" } else { "" };
    let said = format!("{origin}{}{decimal}", style.separator.words());
    Ok(Table { said, names, lines: table_lines, columns, percent, spoilt })
}

/// The names of a line whose first cell is empty and whose others count from 0 or 1.
fn numbered_names(line: &str, style: Style, width: usize) -> Option<Vec<String>> {
    let names: Vec<String> = style.cells(line).take(width).map(Cow::into_owned).collect();
    let (index, others) = names.split_first()?;
    let numbers: Vec<f64> = others.iter().map_while(|name| name.parse().ok()).collect();
    (index.is_empty() && numbers.len() == others.len() && is_count(&numbers)).then_some(names)
}

/// The style in which most lines follow one another as numbers.
fn style(body: &[(usize, &str)]) -> Result<Style> {
    let longest = |style: Style| {
        let (mut best, mut run, mut before) = (0, 0, None);
        for (_, line) in body {
            let cells = style.numbers(line);
            run = if cells.is_some() && cells == before { run + 1 } else { usize::from(cells.is_some()) };
            before = cells;
            best = best.max(run);
        }
        best
    };
    // The first of equals, so that points go before commas.
    let mut best = (0, None);
    for style in Style::every() {
        let run = longest(style);
        if run > best.0 {
            best = (run, Some(style));
        }
    }
    best.1.ok_or_else(|| {
        let shown = body.iter().find(|(_, line)| line.starts_with(|c: char| c.is_ascii_digit()));
        match shown {
            Some((line, text)) => Error::input(format!(
                "'{}' is not a wavelength and a reflectance; write lines such as 500,0.12",
                shortened(text)
            ))
            .in_line(*line),
            None => Error::input("has no lines of numbers; write lines such as 500,0.12"),
        }
    })
}

/// The number of cells of the longest run of lines of numbers.
fn width(body: &[(usize, &str)], style: Style) -> usize {
    let (mut best, mut width, mut run, mut before) = (0, 0, 0, None);
    for (_, line) in body {
        let cells = style.numbers(line);
        run = if cells == before { run + 1 } else { 1 };
        before = cells;
        if let Some(cells) = cells.filter(|_| run > best) {
            (best, width) = (run, cells);
        }
    }
    width
}

type Numbers = (Vec<bool>, Vec<usize>, Vec<Vec<f64>>);

/// Whether a cell of each column says percent, the lines, and `[column][row]`.
fn numbers(body: &[(usize, &str)], style: Style, width: usize) -> Result<Numbers> {
    let rows: Vec<&(usize, &str)> =
        body.iter().filter(|(_, line)| !line.trim_start().starts_with('#')).collect();
    if width > MOST_COLUMNS || rows.len() > MOST_ROWS || width * rows.len() > MOST_NUMBERS {
        return Err(Error::input(format!(
            "has {} lines of {width} numbers, over the limit of {MOST_ROWS} lines, {MOST_COLUMNS} columns and {MOST_NUMBERS} numbers",
            rows.len()
        )));
    }
    let mut columns = vec![Vec::with_capacity(rows.len()); width];
    let mut percent = vec![false; width];
    for (number, line) in &rows {
        let cells = style.cells(line).count();
        if cells != width {
            let error = Error::input(format!("has {cells} columns, but line {} has {width}", rows[0].0));
            return Err(error.in_line(*number));
        }
        for (column, text) in style.cells(line).enumerate() {
            let value = match style.cell(&text) {
                Some(Cell::Number(value)) => value,
                Some(Cell::Percent(value)) => {
                    percent[column] = true;
                    value
                }
                Some(Cell::Missing) => f64::NAN,
                None => {
                    return Err(Error::input(format!(
                        "line {number}, column {}: '{}' is not a finite number",
                        column + 1,
                        shortened(&text)
                    ))
                    .on_line(*number, None));
                }
            };
            columns[column].push(value);
        }
    }
    Ok((percent, rows.iter().map(|row| row.0).collect(), columns))
}

type Header = (Vec<String>, Option<(usize, usize, String)>);

/// The names above the numbers, one for each column; R writes none for its row numbers. A second line with units in
/// brackets is joined to the names. Beside them what [`Table::spoilt`] is.
fn header<'a>(
    lines: impl Iterator<Item = (usize, &'a str)>,
    style: Style,
    columns: &[Vec<f64>],
) -> Result<Header> {
    let width = columns.len();
    let mut above = [None, None];
    let mut is_comment = false;
    for (number, line) in lines {
        let line = line.trim_start();
        let bare = line.trim_start_matches('#').trim_start();
        if !bare.is_empty() {
            above = [above[1], Some((number, bare))];
            is_comment = bare.len() < line.len();
        }
    }
    let words = |line: &str| style.cells(line).take(width + 1).map(Cow::into_owned).collect::<Vec<_>>();
    let none = (vec![String::new(); width], None);
    let Some((number, line)) = above[1] else { return Ok(none) };
    let mut names = words(line);
    if is_comment && style.numbers(line).is_some() {
        return Ok(none);
    }
    // A line of numbers that does not fit those below is no title.
    if names.len() != width && style.numbers(line).is_some() {
        let error = Error::input(format!(
            "has {} columns, but the lines of numbers below have {width}",
            style.cells(line).count()
        ));
        return Err(error.in_line(number));
    }
    if names.len() + 1 == width && is_count(&columns[0]) {
        names.insert(0, String::new());
    }
    if names.len() != width {
        // A title or a setting, unless it names a wavelength.
        if names.len() > 1 && names.iter().any(|name| position_unit(name).is_some()) {
            let error = Error::input(format!(
                "names {} columns, but the lines of numbers have {width} (are these decimal commas? separate cells by semicolons)",
                style.cells(line).count()
            ));
            return Err(error.in_line(number));
        }
        return Ok(none);
    }
    let is_unit =
        |cell: &String| cell.is_empty() || cell.starts_with(['[', '(']) && cell.ends_with([']', ')']);
    if names.iter().all(is_unit)
        && let Some(first) = above[0].map(|(_, line)| words(line)).filter(|first| first.len() == width)
    {
        names = first.into_iter().zip(names).map(|(word, unit)| format!("{word} {unit}")).collect();
    }
    let spoilt = names.iter().position(|name| style.cell(name).is_none());
    // What is commented out is no line of numbers.
    let spoilt = spoilt.filter(|_| !is_comment).map(|at| (number, at + 1, shortened(&names[at])));
    Ok((names, spoilt))
}
