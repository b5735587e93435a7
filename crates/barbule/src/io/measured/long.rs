//! Long ("tidy") tables: one line for each wavelength of each sample, which a column names.

use std::borrow::Cow;
use std::collections::HashMap;

use super::columns::{no_such, shortened_list};
use super::names::{Role, is_angle, is_bare_quantity, position_unit, role, says_percent, words};
use super::resample::{Own, brought_to};
use super::table::{Cell, Separator, Style};
use super::{Found, MOST_COLUMNS, MOST_ROWS, Unit, lines};
use crate::error::{counted, shortened};
use crate::{Error, Result};

/// Columns that tell samples apart even where they are called by numbers.
const GROUPS: [&str; 22] = [
    "sample",
    "samples",
    "specimen",
    "individual",
    "ind",
    "bird",
    "id",
    "name",
    "group",
    "series",
    "spectrum",
    "spectra",
    "spec",
    "patch",
    "species",
    "ring",
    "variable",
    "key",
    "replicate",
    "rep",
    "label",
    "file",
];
/// What columns of reflectance are called in long tables alone.
const VALUES: [&str; 4] = ["value", "values", "y", "response"];
/// The line of names is looked for in so many lines.
const LONGEST_PREAMBLE: usize = 40;

/// A table whose columns are known.
struct Long<'a> {
    style: Style,
    names: Vec<String>,
    /// R writes no name for its row numbers.
    unnamed: usize,
    rows: Vec<(usize, &'a str)>,
    /// Columns of text and of samples' numbers.
    groups: Vec<usize>,
    /// Those of them that tell samples apart: that are not the same in all lines.
    telling: Vec<usize>,
    position: usize,
    unit: Unit,
}

/// A sample.
#[derive(Default)]
struct Group {
    name: String,
    /// (line, position, value), NaN where there is no value.
    points: Vec<(usize, f64, f64)>,
}

/// Reads a long table; none where the text is no such table. `wanted` is the name of one sample or its number from 1.
///
/// # Errors
/// A line that does not fit, a wavelength twice in a sample, several columns that could be reflectance.
pub(super) fn read(text: &str, wanted: Option<&str>) -> Result<Option<Found>> {
    if lines(text).nth(2 * MOST_ROWS).is_some() {
        return Ok(None);
    }
    let body: Vec<(usize, &str)> = lines(text)
        .filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#'))
        .collect();
    Long::find(&body).map_or(Ok(None), |long| long.found(wanted).map(Some))
}

impl<'a> Long<'a> {
    /// The first line that names a wavelength and two columns more, if the lines below have a column that tells samples
    /// apart.
    fn find(body: &[(usize, &'a str)]) -> Option<Self> {
        let places = body.iter().enumerate().take(LONGEST_PREAMBLE);
        let mut all = places.flat_map(|(at, line)| Separator::ALL.map(|separator| (at, line.1, separator)));
        all.find_map(|(at, line, separator)| {
            let plain = Style { separator, decimal_comma: false };
            let names: Vec<String> = plain.cells(line).take(MOST_COLUMNS).map(Cow::into_owned).collect();
            let position = names.iter().position(|name| position_unit(name).is_some())?;
            let unit = position_unit(&names[position])?;
            let rows = body[at + 1..].to_vec();
            let cells = plain.cells(rows.first()?.1).take(MOST_COLUMNS + 2).count();
            let unnamed = cells.checked_sub(names.len()).filter(|more| *more < 2)?;
            let long = Self {
                style: plain,
                names,
                unnamed,
                rows,
                groups: Vec::new(),
                telling: Vec::new(),
                position,
                unit,
            };
            if long.names.len() < 3 { None } else { long.grouped() }
        })
    }

    /// The cells of a line under their names.
    fn cells(&self, line: &'a str) -> impl Iterator<Item = Cow<'a, str>> {
        self.style.cells(line).skip(self.unnamed)
    }

    /// The same with its decimal sign and the columns that tell samples apart; none where there are none.
    fn grouped(mut self) -> Option<Self> {
        // How many cells of each column are text.
        let texts = |style: Style| {
            let mut count = vec![0_usize; self.names.len()];
            for (_, line) in &self.rows {
                for (count, text) in count.iter_mut().zip(style.cells(line).skip(self.unnamed)) {
                    *count += usize::from(style.cell(&text).is_none());
                }
            }
            count
        };
        let comma = Style { decimal_comma: true, ..self.style };
        let (plain, with_commas) = (texts(self.style), texts(comma));
        let better = with_commas.iter().sum::<usize>() < plain.iter().sum::<usize>();
        let texts = if better { with_commas } else { plain };
        if better {
            self.style = comma;
        }
        let mostly = |i: usize| 2 * texts[i] > self.rows.len();
        if mostly(self.position) {
            return None;
        }
        let is_group = |i: usize| {
            let words = words(&self.names[i]);
            is_angle(&self.names[i])
                || !words.is_empty() && words.iter().all(|word| GROUPS.contains(&word.as_str()))
        };
        self.groups = (0..self.names.len()).filter(|&i| mostly(i)).collect();
        let numbered: Vec<usize> =
            (0..self.names.len()).filter(|&i| i != self.position && !mostly(i) && is_group(i)).collect();
        if self.groups.is_empty() && !self.is_told_apart(&numbered) {
            return None;
        }
        self.groups.extend(numbered);
        self.groups.sort_unstable();
        let first: Vec<Cow<'_, str>> = self.cells(self.rows[0].1).collect();
        let mut varies = vec![false; self.names.len()];
        for (_, line) in &self.rows {
            for (i, (varies, cell)) in varies.iter_mut().zip(self.cells(line)).enumerate() {
                *varies |= first.get(i) != Some(&cell);
            }
        }
        let varying: Vec<usize> = self.groups.iter().copied().filter(|&i| varies[i]).collect();
        self.telling = if varying.is_empty() { self.groups[..1].to_vec() } else { varying };
        Some(self)
    }

    /// Whether whole numbers tell the lines of the same wavelength apart.
    fn is_told_apart(&self, columns: &[usize]) -> bool {
        let mut samples: HashMap<Vec<u64>, usize> = HashMap::new();
        let mut wavelengths: HashMap<u64, usize> = HashMap::new();
        for (_, line) in &self.rows {
            let numbers: Vec<f64> = self
                .cells(line)
                .map(|text| match self.style.cell(&text) {
                    Some(Cell::Number(value)) => value,
                    _ => f64::NAN,
                })
                .collect();
            let of: Option<Vec<u64>> = columns
                .iter()
                .map(|&i| {
                    let number = numbers.get(i).filter(|v| v.is_finite());
                    number.filter(|v| v.fract() == 0.0 || is_angle(&self.names[i])).map(|v| v.to_bits())
                })
                .collect();
            let (Some(of), Some(at)) = (of, numbers.get(self.position)) else { return false };
            *samples.entry(of).or_default() += 1;
            *wavelengths.entry(at.to_bits()).or_default() += 1;
        }
        let again = wavelengths.values().filter(|count| **count > 1).count();
        !columns.is_empty() && samples.len() > 1 && 2 * samples.len() <= self.rows.len() && again > 0
    }

    /// The names of the columns that tell samples apart.
    fn told(&self) -> String {
        let names: Vec<String> =
            self.telling.iter().map(|&i| format!("'{}'", shortened(self.names[i].trim()))).collect();
        shortened_list(&names)
    }

    /// The column of reflectance, and what is said of the others.
    fn values(&self, said: &mut Vec<String>) -> Result<usize> {
        let label = |i: &usize| format!("'{}'", shortened(self.names[*i].trim()));
        // Row numbers and empty ends of lines have no names.
        let rest: Vec<usize> = (0..self.names.len())
            .filter(|i| *i != self.position && !self.groups.contains(i))
            .filter(|&i| !self.names[i].trim().is_empty())
            .collect();
        let of = |wanted: &dyn Fn(&str) -> bool| -> Vec<usize> {
            rest.iter().copied().filter(|&i| wanted(self.names[i].trim())).collect()
        };
        let is_value = |name: &str| VALUES.contains(&name.to_lowercase().as_str());
        // A mean beside an unknown quantity: either may be meant.
        let is_sample = |name: &str| match role(name) {
            Role::Sample => !is_bare_quantity(name, &[]),
            other => other == Role::Mean,
        };
        let kinds = [of(&|name| role(name) == Role::Reflectance), of(&is_value), of(&is_sample)];
        match kinds.iter().find(|kind| !kind.is_empty()).map(Vec::as_slice) {
            Some([one]) => {
                let dropped: Vec<String> = rest.iter().filter(|i| *i != one).map(label).collect();
                if !dropped.is_empty() {
                    said.push(format!("{} left out", shortened_list(&dropped)));
                }
                Ok(*one)
            }
            Some(several) => Err(Error::input(format!(
                "has a line for each wavelength and sample, and columns {} that could all be reflectance; call the one R, or leave the others out",
                shortened_list(&several.iter().map(label).collect::<Vec<_>>())
            ))),
            None => Err(Error::input(format!(
                "has a line for each wavelength and sample, but no column of reflectance by its name{}; call it R",
                match &rest[..] {
                    [] => String::new(),
                    others => format!(
                        " (there is {})",
                        shortened_list(&others.iter().map(label).collect::<Vec<_>>())
                    ),
                }
            ))),
        }
    }

    fn found(&self, wanted: Option<&str>) -> Result<Found> {
        let decimal = if self.style.decimal_comma { ", decimal commas" } else { "" };
        let mut said = vec![
            format!("{}{decimal}", self.style.separator.words()),
            format!("a line for each wavelength and sample, told apart by {}", self.told()),
        ];
        let value = self.values(&mut said)?;
        let (groups, is_percent) = self.samples(value, &mut said)?;
        let mut chosen = match wanted {
            None => groups,
            Some(wanted) => vec![one_of(groups, wanted)?],
        };
        for group in &mut chosen {
            group.points.sort_by(|a, b| a.1.total_cmp(&b.1));
            if let Some(pair) = group.points.windows(2).find(|pair| pair[0].1 == pair[1].1) {
                let error = Error::input(format!(
                    "the sample '{}' has the wavelength {} again, as in line {}; tell repeated measurements apart by a further column",
                    shortened(&group.name),
                    pair[1].1,
                    pair[0].0
                ));
                return Err(error.in_line(pair[1].0));
            }
        }
        let first = &chosen[0].points;
        let same = |group: &Group| {
            group.points.len() == first.len() && group.points.iter().zip(first).all(|(a, b)| a.1 == b.1)
        };
        let rows: Vec<(usize, f64)> = first.iter().map(|point| (point.0, point.1)).collect();
        let samples = if chosen.iter().all(same) {
            let values = |group: &Group| group.points.iter().map(|point| point.2).collect();
            chosen.iter().map(|group| (shortened(&group.name), values(group))).collect()
        } else {
            said.push("samples at wavelengths of their own, brought to those of the first".into());
            let nm: Vec<f64> = rows.iter().map(|row| self.unit.nm(row.1)).collect();
            let own = |group: &Group| Own {
                name: shortened(&group.name),
                positions: group.points.iter().map(|point| self.unit.nm(point.1)).collect(),
                values: group.points.iter().map(|point| point.2).collect(),
            };
            brought_to(&nm, chosen.iter().map(own))?
        };
        Ok(Found {
            said,
            position: format!("'{}'", shortened(self.names[self.position].trim())),
            unit: self.unit,
            rows,
            percent: vec![is_percent || says_percent(&self.names[value]); samples.len()],
            samples,
        })
    }

    /// The samples in the order in which they begin, and whether a cell says percent.
    fn samples(&self, value: usize, said: &mut Vec<String>) -> Result<(Vec<Group>, bool)> {
        let mut groups: Vec<Group> = Vec::new();
        let mut known: HashMap<String, usize> = HashMap::new();
        let (mut is_percent, mut lost, mut rises) = (false, 0, true);
        let mut before: Option<f64> = None;
        for &(line, text) in &self.rows {
            let refuse = |what: String| Error::input(what).in_line(line);
            let cells: Vec<Cow<'_, str>> = self.cells(text).take(MOST_COLUMNS).collect();
            if cells.len() != self.names.len() {
                return Err(refuse(format!(
                    "has {} columns, but {} are named",
                    cells.len(),
                    self.names.len()
                )));
            }
            let number = |at: usize| match self.style.cell(&cells[at]) {
                Some(Cell::Number(value)) => Ok((value, false)),
                Some(Cell::Percent(value)) => Ok((value, true)),
                Some(Cell::Missing) => Ok((f64::NAN, false)),
                None => Err(Error::input(format!(
                    "line {line}, column {}: '{}' is not a finite number",
                    at + 1 + self.unnamed,
                    shortened(&cells[at])
                ))
                .on_line(line, None)),
            };
            let ((position, _), (value, says)) = (number(self.position)?, number(value)?);
            is_percent |= says;
            if position.is_nan() {
                lost += 1;
                continue;
            }
            rises &= before.is_none_or(|before| position > before);
            before = Some(position);
            // Numbers in a column of angles say degrees, as names of columns do.
            let told = |&i: &usize| match self.style.cell(&cells[i]) {
                Some(Cell::Number(angle)) if is_angle(&self.names[i]) => format!("{angle}deg"),
                _ => cells[i].trim().to_owned(),
            };
            let name = self.telling.iter().map(told).collect::<Vec<_>>().join(" ");
            let at = *known.entry(name).or_insert_with_key(|name| {
                groups.push(Group { name: name.trim().to_owned(), points: Vec::new() });
                groups.len() - 1
            });
            if groups.len() > MOST_COLUMNS {
                return Err(refuse(format!("over {MOST_COLUMNS} samples are told apart")));
            }
            groups[at].points.push((line, position, value));
        }
        if rises && groups.len() > 1 {
            return Err(Error::input(format!(
                "{} tells samples apart, but no wavelength has two of them; leave that column out if it holds remarks",
                self.told()
            )));
        }
        if groups.is_empty() {
            return Err(Error::input("no line has a number for the wavelength"));
        }
        if lost > 0 {
            said.push(format!("{} without a wavelength left out", counted(lost, "line")));
        }
        Ok((groups, is_percent))
    }
}

/// The sample that the user names, by name or number.
fn one_of(groups: Vec<Group>, wanted: &str) -> Result<Group> {
    let wanted = wanted.trim();
    let by_name = groups.iter().position(|group| group.name.eq_ignore_ascii_case(wanted));
    let by_number =
        wanted.parse::<usize>().ok().and_then(|n| n.checked_sub(1)).filter(|at| *at < groups.len());
    match by_name.or(by_number) {
        Some(at) => Ok(groups.into_iter().nth(at).unwrap_or_default()),
        None => Err(no_such(wanted, groups.iter().map(|group| group.name.as_str()), "sample", groups.len())),
    }
}
