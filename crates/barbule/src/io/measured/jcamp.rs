//! JCAMP-DX, the exchange format of spectroscopy: `##LABEL= value` records with plain or compressed numbers.
//!
//! Source: McDonald & Wilks 1988, "JCAMP-DX: a standard form for exchange of infrared spectra in computer readable
//! form", *Appl. Spectrosc.* 42, 151 (version 4.24); its sections on ASDF forms: AFFN, PAC, SQZ, DIF and DUP.

use super::names::{is_bare_quantity, is_other_quantity};
use super::{Found, MOST_COLUMNS, MOST_NUMBERS, MOST_ROWS, Unit, lines};
use crate::error::shortened;
use crate::{Error, Result};

/// Whether a text begins as JCAMP-DX does.
pub(super) fn is_jcamp(text: &str) -> bool {
    lines(text)
        .find(|(_, line)| !line.trim().is_empty())
        .is_some_and(|(_, line)| line.trim_start().strip_prefix("##").is_some_and(|rest| rest.contains('=')))
}

/// One spectrum with what its records say.
#[derive(Default, Clone)]
struct Block {
    title: String,
    x_units: String,
    y_units: String,
    factors: [Option<f64>; 2],
    ends: [Option<f64>; 2],
    step: Option<f64>,
    count: Option<usize>,
    /// (line, x, y) in the file's units.
    points: Vec<(usize, f64, f64)>,
}

/// Reads the spectra of a file; `wanted` is the title of one or its number from 1.
pub(super) fn read(text: &str, wanted: Option<&str>) -> Result<Found> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut block = Block::default();
    let mut all = lines(text).peekable();
    let mut total = 0;
    while let Some((number, line)) = all.next() {
        let line = uncommented(line);
        let Some((label, value)) = line.trim_start().strip_prefix("##").and_then(|r| r.split_once('='))
        else {
            continue;
        };
        let place = |error: Error| error.in_line(number);
        match label_of(label).as_str() {
            "TITLE" => block = Block { title: value.trim().to_owned(), ..Block::default() },
            "XUNITS" => block.x_units = value.trim().to_uppercase(),
            "YUNITS" => block.y_units = value.trim().to_uppercase(),
            "XFACTOR" => block.factors[0] = Some(number_of(label, value).map_err(place)?),
            "YFACTOR" => block.factors[1] = Some(number_of(label, value).map_err(place)?),
            "FIRSTX" => block.ends[0] = Some(number_of(label, value).map_err(place)?),
            "LASTX" => block.ends[1] = Some(number_of(label, value).map_err(place)?),
            "DELTAX" => block.step = Some(number_of(label, value).map_err(place)?),
            "NPOINTS" => {
                let count = number_of(label, value).map_err(place)?;
                if !(1.0..=MOST_ROWS as f64).contains(&count) || count.fract() != 0.0 {
                    return Err(place(Error::input(format!(
                        "NPOINTS is {count}, but must be a whole number to {MOST_ROWS}"
                    ))));
                }
                block.count = Some(count as usize);
            }
            "NTUPLES" => {
                return Err(place(Error::input("holds NTUPLES, which are not read; export XYDATA")));
            }
            "XYDATA" | "XYPOINTS" => {
                let form = value.trim().to_uppercase().replace(' ', "");
                let data = std::iter::from_fn(|| {
                    all.next_if(|(_, line)| !uncommented(line).trim_start().starts_with("##"))
                })
                .map(|(number, line)| (number, uncommented(line).trim()))
                .filter(|(_, line)| !line.is_empty());
                block.points = match form.as_str() {
                    "(X++(Y..Y))" => equidistant(&block, data)?,
                    "(XY..XY)" => pairs(&block, data)?,
                    _ => {
                        return Err(place(Error::input(format!(
                            "the form '{}' is not read; known are (X++(Y..Y)) and (XY..XY)",
                            shortened(&form)
                        ))));
                    }
                };
                if let Some((line, x, y)) =
                    block.points.iter().find(|(_, x, y)| !(x.is_finite() && y.is_finite()))
                {
                    let error =
                        Error::input(format!("the point ({x}, {y}), with its factors, is not finite"));
                    return Err(error.in_line(*line));
                }
                total += block.points.len();
                if total > MOST_NUMBERS || blocks.len() > MOST_COLUMNS {
                    return Err(place(Error::input(format!(
                        "the file holds over {MOST_NUMBERS} numbers or {MOST_COLUMNS} spectra"
                    ))));
                }
                check_count(&block)?;
                blocks.push(block.clone());
            }
            _ => {}
        }
    }
    choose(blocks, wanted)
}

fn check_count(block: &Block) -> Result<()> {
    match block.count {
        Some(count) if count != block.points.len() => Err(Error::input(format!(
            "NPOINTS is {count}, but the data have {} points; is the file cut off?",
            block.points.len()
        ))),
        _ if block.points.is_empty() => Err(Error::input("has no data")),
        _ => Ok(()),
    }
}

/// The spectra that are asked for, as samples over common positions.
fn choose(blocks: Vec<Block>, wanted: Option<&str>) -> Result<Found> {
    let count = blocks.len();
    let chosen = match wanted.map(str::trim) {
        None => blocks,
        Some(wanted) => {
            let by_title = blocks.iter().position(|b| b.title.eq_ignore_ascii_case(wanted));
            let by_number = wanted.parse::<usize>().ok().and_then(|n| n.checked_sub(1));
            let at = by_title.or(by_number).filter(|at| *at < count).ok_or_else(|| {
                Error::input(format!(
                    "`column` {}: there is no such spectrum; the file holds {count}",
                    shortened(wanted)
                ))
                .naming(&["column"])
            })?;
            vec![blocks[at].clone()]
        }
    };
    let Some(first) = chosen.first() else {
        return Err(Error::input("is JCAMP-DX without XYDATA or XYPOINTS"));
    };
    let unit = unit(first)?;
    let mut percent = Vec::new();
    let mut samples = Vec::new();
    for block in &chosen {
        let same = block.points.len() == first.points.len()
            && block.points.iter().zip(&first.points).all(|(a, b)| a.1 == b.1);
        if !same || self::unit(block)? != unit {
            let refusal =
                Error::input(format!("holds {count} spectra at different positions; name one with `column`"));
            return Err(refusal.naming(&["column"]));
        }
        percent.push(is_percent(block)?);
        samples.push((shortened(&block.title), block.points.iter().map(|p| p.2).collect()));
    }
    Ok(Found {
        said: vec!["JCAMP-DX".into()],
        position: "##XYDATA".into(),
        unit,
        rows: first.points.iter().map(|p| (p.0, p.1)).collect(),
        samples,
        percent,
    })
}

fn unit(block: &Block) -> Result<Unit> {
    match block.x_units.replace([' ', '_'], "").as_str() {
        "NANOMETERS" | "NANOMETRES" | "NANOMETER" | "NM" | "WAVELENGTH(NM)" => Ok(Unit::Nanometres),
        "MICROMETERS" | "MICROMETRES" | "MICROMETER" | "MICRONS" | "UM" | "µM" => Ok(Unit::Micrometres),
        "1/CM" | "CM-1" | "CM^-1" | "WAVENUMBERS" | "WAVENUMBER" => Ok(Unit::PerCentimetre),
        other => Err(Error::input(format!(
            "XUNITS is '{}', but must be NANOMETERS, MICROMETERS or 1/CM",
            shortened(other)
        ))),
    }
}

/// Whether the values are percent; refuses those that are no reflectance.
fn is_percent(block: &Block) -> Result<bool> {
    let units = &block.y_units;
    let is_other = is_other_quantity(units) || is_bare_quantity(units, &[]);
    if is_other || ["KUBELKA", "COUNTS", "EMISSION"].iter().any(|other| units.contains(other)) {
        return Err(Error::input(format!(
            "YUNITS is '{}', which is no reflectance; export reflectance",
            shortened(units)
        )));
    }
    Ok(units.contains('%') || units.contains("PERCENT"))
}

/// The text before `$$`.
fn uncommented(line: &str) -> &str {
    line.split_once("$$").map_or(line, |(text, _)| text)
}

/// Labels are the same whatever their case and signs.
fn label_of(label: &str) -> String {
    label.chars().take(40).filter(|c| c.is_ascii_alphanumeric()).collect::<String>().to_uppercase()
}

fn number_of(label: &str, value: &str) -> Result<f64> {
    value.trim().parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| {
        Error::input(format!("{} is '{}', not a number", shortened(label.trim()), shortened(value.trim())))
    })
}

/// `(XY..XY)`: pairs.
fn pairs<'a>(block: &Block, data: impl Iterator<Item = (usize, &'a str)>) -> Result<Vec<(usize, f64, f64)>> {
    let [x_factor, y_factor] = block.factors.map(|f| f.unwrap_or(1.0));
    let mut points = Vec::new();
    for (line, text) in data {
        let refuse = |what: String| Error::input(what).in_line(line);
        let mut x = None;
        for word in text.split([',', ';', ' ', '\t']).filter(|word| !word.is_empty()) {
            let value = word
                .parse::<f64>()
                .ok()
                .filter(|v| v.is_finite())
                .ok_or_else(|| refuse(format!("'{}' is not a finite number", shortened(word))))?;
            match x.take() {
                None => x = Some(value),
                Some(x) => points.push((line, x * x_factor, value * y_factor)),
            }
        }
        if x.is_some() {
            return Err(refuse("has a position without a value".into()));
        }
        if points.len() > MOST_ROWS {
            return Err(refuse(format!("the data hold over {MOST_ROWS} points")));
        }
    }
    Ok(points)
}

/// A number of the compressed forms.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Token {
    /// A value.
    Value(f64),
    /// A difference from the value before.
    Difference(f64),
    /// The last token, so many times in all.
    Repeat(usize),
}

/// `(X++(Y..Y))`: a position, then values at equal steps.
fn equidistant<'a>(
    block: &Block,
    data: impl Iterator<Item = (usize, &'a str)>,
) -> Result<Vec<(usize, f64, f64)>> {
    let [x_factor, y_factor] = block.factors.map(|f| f.unwrap_or(1.0));
    let data: Vec<(usize, &str)> = data.take(MOST_ROWS + 1).collect();
    let Unpacked { values, positions } = unpacked(&data)?;
    let Some(&(_, _, first)) = positions.first() else { return Ok(Vec::new()) };
    let first = block.ends[0].unwrap_or(first * x_factor);
    let steps = values.len().saturating_sub(1).max(1) as f64;
    let step = match (block.ends[1], block.step) {
        (Some(last), _) => (last - first) / steps,
        (None, Some(step)) => step,
        (None, None) => return Err(Error::input("has neither LASTX nor DELTAX")),
    };
    for (line, place, x) in positions {
        let expected = first + step * place as f64;
        // Positions are often rounded to whole units.
        let near = (x * x_factor - expected).abs() <= 1.01 * step.abs() + 0.5 * x_factor.abs();
        if !near {
            let error = Error::input(format!(
                "begins at {}, but {place} steps of {step} from {first} lead to {expected}; is a line missing?",
                x * x_factor
            ));
            return Err(error.in_line(line));
        }
    }
    Ok(values
        .into_iter()
        .enumerate()
        .map(|(i, (line, value))| (line, first + step * i as f64, value * y_factor))
        .collect())
}

/// The lines of `(X++(Y..Y))` in the file's own units.
#[derive(Default)]
struct Unpacked {
    /// (line, value).
    values: Vec<(usize, f64)>,
    /// (line, place among the values, position) of each line's first value.
    positions: Vec<(usize, usize, f64)>,
}

fn unpacked(data: &[(usize, &str)]) -> Result<Unpacked> {
    // Exponents and the 5 of SQZ are both an E: other letters tell which.
    let packed = data.iter().any(|(_, text)| {
        text.chars().any(|c| c.is_ascii_alphabetic() && !c.eq_ignore_ascii_case(&'e') || "@%".contains(c))
    });
    let Unpacked { mut values, mut positions } = Unpacked::default();
    let mut differs = false;
    for &(line, text) in data {
        let refuse = |what: String| Error::input(what).in_line(line);
        let mut tokens = Tokens { text, packed };
        let Some(Token::Value(x)) = tokens.next().transpose().map_err(refuse)? else {
            return Err(refuse("does not begin with a position".into()));
        };
        let before = values.last().map(|value: &(usize, f64)| value.1);
        let checked = differs;
        let start = values.len();
        let mut last = None;
        for token in tokens {
            let times = match token.map_err(refuse)? {
                Token::Repeat(times) => times - 1,
                other => {
                    last = Some(other);
                    1
                }
            };
            if values.len() + times > MOST_ROWS + 1 {
                return Err(refuse(format!("the data hold over {MOST_ROWS} points")));
            }
            for _ in 0..times {
                match (last, values.last()) {
                    (Some(Token::Value(value)), _) => values.push((line, value)),
                    (Some(Token::Difference(step)), Some(&(_, previous))) if values.len() > start => {
                        values.push((line, previous + step));
                    }
                    _ => return Err(refuse("begins with a difference or a repetition of nothing".into())),
                }
            }
        }
        differs = matches!(last, Some(Token::Difference(_)));
        // After a line that ends in differences the next one begins with its last value again.
        match (before, values.get(start)) {
            (Some(before), Some(&(_, again))) if checked => {
                if before != again {
                    return Err(refuse(format!("begins with {again}, but the line before ends at {before}")));
                }
                values.remove(start);
                positions.push((line, start - 1, x));
            }
            _ => positions.push((line, start, x)),
        }
    }
    Ok(Unpacked { values, positions })
}

/// The numbers of a line, packed or not.
struct Tokens<'a> {
    text: &'a str,
    packed: bool,
}

impl Iterator for Tokens<'_> {
    type Item = Result<Token, String>;

    fn next(&mut self) -> Option<Self::Item> {
        self.text = self.text.trim_start_matches([' ', '\t', ',', ';']);
        let first = self.text.chars().next()?;
        // Unknown values are a question mark in the standard.
        if first == '?' {
            return Some(Err("holds '?', a value that is not known; leave the point out".into()));
        }
        let (digit, kind): (i64, fn(f64) -> Token) = match first {
            '@' => (0, Token::Value),
            'A'..='I' => (first as i64 - 'A' as i64 + 1, Token::Value),
            'a'..='i' => (-(first as i64 - 'a' as i64 + 1), Token::Value),
            '%' => (0, Token::Difference),
            'J'..='R' => (first as i64 - 'J' as i64 + 1, Token::Difference),
            'j'..='r' => (-(first as i64 - 'j' as i64 + 1), Token::Difference),
            'S'..='Z' => (first as i64 - 'S' as i64 + 1, Token::Value),
            's' => (9, Token::Value),
            _ => return Some(self.plain().map(Token::Value)),
        };
        let rest = &self.text[1..];
        let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
        let sign = if digit < 0 { "-" } else { "" };
        let text = format!("{sign}{}{}", digit.abs(), &rest[..end]);
        self.text = &rest[end..];
        if end > 30 {
            return Some(Err(format!("'{}' is not a number", shortened(&text))));
        }
        if matches!(first, 'S'..='Z' | 's') {
            let times = text.parse::<usize>().ok().filter(|n| (1..=MOST_ROWS).contains(n));
            return Some(times.map(Token::Repeat).ok_or_else(|| format!("{text} repetitions are too many")));
        }
        Some(text.parse().map(kind).map_err(|_| format!("'{}' is not a number", shortened(&text))))
    }
}

impl Tokens<'_> {
    /// A number in plain digits; a sign begins the next one (PAC).
    fn plain(&mut self) -> Result<f64, String> {
        let bytes = self.text.as_bytes();
        let mut end = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
        while let Some(byte) = bytes.get(end) {
            let next = bytes.get(end + 1);
            match byte {
                b'0'..=b'9' | b'.' => end += 1,
                b'e' | b'E' if matches!(next, Some(b'+' | b'-')) && end > 0 => end += 2,
                b'e' | b'E' if !self.packed && matches!(next, Some(b'0'..=b'9')) && end > 0 => end += 1,
                _ => break,
            }
        }
        let word = &self.text[..end];
        let value = word.parse::<f64>().ok().filter(|v| v.is_finite());
        match value {
            Some(value) => {
                self.text = &self.text[end..];
                Ok(value)
            }
            None => {
                let shown: String = self.text.chars().take(20).collect();
                self.text = "";
                Err(format!("'{}' is not a finite number", shortened(&shown)))
            }
        }
    }
}
