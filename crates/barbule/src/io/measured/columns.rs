//! Which column of a table is the wavelength, and which are samples.

use super::names::{Role, is_bare_quantity, is_light, numbered_position_unit, role, says_percent, words};
use super::resample::{Own, brought_to};
use super::scale::PERCENT_ABOVE;
use super::table::Table;
use super::{Found, Unit};
use crate::error::{did_you_mean, shortened};
use crate::{Error, Result};

/// A mean is that of samples if it differs by at most so much of its largest value: tables round.
const ROUNDED: f64 = 5e-3;

/// Whether numbers count lines: 0, 1, 2, … or 1, 2, 3, …
pub(super) fn is_count(values: &[f64]) -> bool {
    let first = values.first().copied().unwrap_or(-1.0);
    (first == 0.0 || first == 1.0)
        && values.len() > 1
        && values.iter().enumerate().all(|(i, v)| *v == first + i as f64)
}

/// Whether numbers rise or fall throughout, and all lie within a range; of fewer than two nothing is known.
fn runs_within(values: &[f64], [from, to]: [f64; 2]) -> bool {
    let known: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    let all = |holds: fn(f64, f64) -> bool| known.windows(2).all(|pair| holds(pair[0], pair[1]));
    known.len() > 1
        && known.iter().all(|v| (from..to).contains(v))
        && (all(|a, b| a <= b) || all(|a, b| a >= b))
        && known[0] != known[known.len() - 1]
}

/// Whether numbers could be wavelengths in nm.
fn is_like_nm(values: &[f64]) -> bool {
    runs_within(values, [100.0, 30_000.0])
}

/// Whether numbers can hardly be anything but wavelengths in nm: none could be a percentage.
fn is_plainly_nm(values: &[f64]) -> bool {
    runs_within(values, [200.0, 2500.0])
}

/// Whether what should be a name is a wavelength, or one with a typing error: digits with an O, an l or a comma among
/// them.
fn is_spoilt_number(name: &str) -> bool {
    let name = name.trim();
    match name.replacen(',', ".", 1).parse::<f64>() {
        Ok(value) => (100.0..30_000.0).contains(&value),
        Err(_) => {
            let like = |c: char| c.is_ascii_digit() || ".,+-eEoOlI ".contains(c);
            name.len() > 2 && name.starts_with(|c: char| c.is_ascii_digit()) && name.chars().all(like)
        }
    }
}

/// A column by its name or else its number, for messages.
fn label(table: &Table, column: usize) -> String {
    match table.names[column].trim() {
        "" => format!("column {}", column + 1),
        name => format!("'{}'", shortened(name)),
    }
}

/// Chooses the wavelengths and the samples of a table; `wanted` is the name of one column or its number from 1. In a table of
/// light what is called irradiance or counts is what is sought.
pub(super) fn choose(table: Table, wanted: Option<&str>, is_of_light: bool) -> Result<Found> {
    let mut said = vec![table.said.clone()];
    let mut roles = roles(&table, &mut said);
    if is_of_light {
        for (role, name) in roles.iter_mut().zip(&table.names) {
            if *role == Some(Role::Raw) && is_light(name) {
                *role = Some(Role::Sample);
            }
        }
    }
    let positions = positions(&table, &mut roles)?;
    let (first, _) = positions[0];
    if let Some((line, column, text)) = &table.spoilt
        && is_spoilt_number(&table.names[first])
    {
        return Err(Error::input(format!(
            "line {line}, column {column}: '{text}' is not a finite number (are these names? name the wavelengths wl)"
        ))
        .on_line(*line, None));
    }
    let chosen = match wanted {
        Some(wanted) => vec![named(&table, &positions, wanted)?],
        None => samples(&table, &roles, &mut said)?,
    };
    let values = |column: usize| table.columns[column].clone();
    let percent = |column: usize| table.percent[column] || says_percent(&table.names[column]);
    let owners =
        chosen.iter().map(|&column| owner(&table, &positions, column)).collect::<Result<Vec<_>>>()?;
    let name = |column: usize| shortened(table.names[column].trim());
    if wanted.is_none()
        && let Some(idle) = positions.iter().position(|position| !owners.contains(position))
    {
        let [one, other] = if idle == 0 { [0, 1] } else { [0, idle] };
        return Err(two_wavelengths(&table, positions[one].0, positions[other].0));
    }
    let (base, unit) = owners[0];
    let samples = if owners.iter().all(|owner| *owner == owners[0]) {
        chosen.iter().map(|&column| (name(column), values(column))).collect()
    } else {
        said.push("samples at wavelengths of their own, brought to those of the first".into());
        let nm = |position: usize, unit: Unit| -> Vec<f64> {
            table.columns[position].iter().map(|&at| unit.nm(at)).collect()
        };
        let owned = chosen.iter().zip(&owners).map(|(&column, &(position, unit))| Own {
            name: name(column),
            positions: nm(position, unit),
            values: values(column),
        });
        brought_to(&nm(base, unit), owned)?
    };
    Ok(Found {
        said,
        position: label(&table, base),
        unit,
        rows: table.lines.iter().copied().zip(table.columns[base].iter().copied()).collect(),
        samples,
        percent: chosen.iter().map(|&column| percent(column)).collect(),
    })
}

/// What each column is; none for what is left out, which is said of row numbers.
fn roles(table: &Table, said: &mut Vec<String>) -> Vec<Option<Role>> {
    let mut roles: Vec<Option<Role>> = table.names.iter().map(|name| Some(role(name))).collect();
    // The columns of Ocean Optics' Jaz: wavelength, dark, reference, sample, processed.
    if table.names.iter().map(|n| n.to_lowercase()).eq(["w", "d", "r", "s", "p"]) {
        let raw = Some(Role::Raw);
        roles = vec![Some(Role::Position(Unit::Nanometres)), raw, raw, raw, Some(Role::Reflectance)];
    }
    let is_named = roles.iter().any(|role| matches!(role, Some(Role::Position(_))));
    for (i, values) in table.columns.iter().enumerate() {
        let name = table.names[i].trim().to_lowercase();
        // What pandas calls a column of row numbers that it reads again.
        let is_unnamed = name.is_empty() || name.starts_with("unnamed:");
        let counts = is_count(values)
            && (is_unnamed || ["x", "index", "row", "id", "no", "n", "#"].contains(&name.as_str()));
        // Row numbers of some of the lines, where another column is the wavelength by its name.
        let rises = is_unnamed
            && i == 0
            && is_named
            && values.len() > 1
            && values.iter().all(|v| *v >= 0.0 && v.fract() == 0.0)
            && values.windows(2).all(|pair| pair[0] < pair[1]);
        if values.iter().all(|v| v.is_nan()) {
            roles[i] = None;
        } else if counts || rises {
            roles[i] = None;
            said.push("row numbers left out".into());
        }
        if roles[i] == Some(Role::Sample)
            && is_like_nm(values)
            && let Some(unit) = numbered_position_unit(&table.names[i])
        {
            roles[i] = Some(Role::Position(unit));
        }
    }
    let samples: Vec<usize> = (0..roles.len()).filter(|&i| roles[i] == Some(Role::Sample)).collect();
    for &i in &samples {
        let others: Vec<&str> =
            samples.iter().filter(|&&other| other != i).map(|&other| table.names[other].as_str()).collect();
        if is_bare_quantity(&table.names[i], &others) {
            roles[i] = Some(Role::Raw);
        }
    }
    roles
}

/// The columns of wavelengths, by their names or else by their numbers: one, unless others have different numbers.
/// None of them has a role any more.
fn positions(table: &Table, roles: &mut [Option<Role>]) -> Result<Vec<(usize, Unit)>> {
    let mut found: Vec<(usize, Unit)> = roles
        .iter()
        .enumerate()
        .filter_map(|(i, role)| match role {
            Some(Role::Position(unit)) => Some((i, *unit)),
            _ => None,
        })
        .collect();
    if found.is_empty() {
        found.push((position_by_numbers(table, roles)?, Unit::Nanometres));
    }
    found.iter().for_each(|(i, _)| roles[*i] = None);
    // What has no such name but is nothing else either.
    let first = &table.columns[found[0].0];
    for (i, values) in table.columns.iter().enumerate() {
        if roles[i] == Some(Role::Sample) && is_plainly_nm(values) && overlap(first, values) {
            roles[i] = None;
            found.push((i, Unit::Nanometres));
        }
    }
    found.sort_by_key(|(i, _)| *i);
    // The same wavelengths again, before each sample: spreadsheets that were put side by side.
    let (first, unit) = found[0];
    let same = |other: usize| {
        let pairs = table.columns[first].iter().zip(&table.columns[other]);
        pairs.into_iter().all(|(a, b)| a == b || a.is_nan() && b.is_nan())
    };
    if found.iter().all(|&(i, u)| u == unit && same(i)) {
        found.truncate(1);
    } else if let Some((other, _)) =
        found.iter().find(|&&(i, u)| u == Unit::Nanometres && !is_like_nm(&table.columns[i]))
    {
        let [a, b] = if *other == first { [first, found[1].0] } else { [first, *other] };
        return Err(two_wavelengths(table, a, b));
    }
    Ok(found)
}

/// Whether two columns share half the range of the narrower one.
fn overlap(one: &[f64], other: &[f64]) -> bool {
    let range = |values: &[f64]| {
        let known = values.iter().copied().filter(|v| v.is_finite());
        known.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
    };
    let ([a, b], [c, d]) = (range(one), range(other));
    b.min(d) - a.max(c) >= 0.5 * (b - a).min(d - c)
}

/// The wavelengths of a sample: the nearest column of them on its left, where there are several.
fn owner(table: &Table, positions: &[(usize, Unit)], column: usize) -> Result<(usize, Unit)> {
    if let [only] = positions {
        return Ok(*only);
    }
    let left = positions.iter().rev().find(|(position, _)| *position < column);
    left.copied().ok_or_else(|| two_wavelengths(table, positions[0].0, positions[1].0))
}

fn two_wavelengths(table: &Table, one: usize, other: usize) -> Error {
    Error::input(format!(
        "columns {} '{}' and {} '{}' are both wavelengths, and differ; keep one, put each before its own samples, or give each sample a file",
        one + 1,
        shortened(&table.names[one]),
        other + 1,
        shortened(&table.names[other])
    ))
}

/// The column of wavelengths by its numbers, where none has such a name.
fn position_by_numbers(table: &Table, roles: &[Option<Role>]) -> Result<usize> {
    let like: Vec<usize> =
        (0..roles.len()).filter(|&i| roles[i].is_some() && is_like_nm(&table.columns[i])).collect();
    let first = roles.iter().position(Option::is_some).unwrap_or_default();
    match like[..] {
        // By custom the first column.
        [one, ..] if one == first => Ok(one),
        [one] => Ok(one),
        [] => {
            let largest = table.columns[first].iter().copied().fold(0.0, f64::max);
            let hint = if largest > 0.0 && largest < 30.0 {
                format!("; column {} looks like micrometres (to {largest}): name it um", first + 1)
            } else {
                String::new()
            };
            Err(Error::input(format!(
                "no column is named wl, wavelength, lambda or nm, and none rises or falls as wavelengths in nm do{hint}"
            )))
        }
        [one, other, ..] => Err(Error::input(format!(
            "columns {} and {} could both be wavelengths; name one wl",
            one + 1,
            other + 1
        ))),
    }
}

/// The columns that are samples when the user names none.
fn samples(table: &Table, roles: &[Option<Role>], said: &mut Vec<String>) -> Result<Vec<usize>> {
    let of = |wanted: Role| (0..roles.len()).filter(|&i| roles[i] == Some(wanted)).collect::<Vec<_>>();
    let (mut reflectances, raw, mut samples, means) =
        (of(Role::Reflectance), of(Role::Raw), of(Role::Sample), of(Role::Mean));
    let list = |columns: &[usize]| {
        shortened_list(&columns.iter().take(50).map(|&i| label(table, i)).collect::<Vec<_>>())
    };
    // Beside a mean, what is called 2.5% or low is a bound of it.
    let is_bound = |&i: &usize| {
        let words = words(&table.names[i]);
        let bound =
            |w: &String| ["low", "high", "lo", "hi"].contains(&w.as_str()) || w.ends_with('%') && w.len() > 1;
        words.iter().all(|w| bound(w) || w.bytes().all(|b| b.is_ascii_digit())) && words.iter().any(bound)
    };
    samples.retain(|i| means.is_empty() || !is_bound(i));
    // A mean is a sample where nothing else is one.
    if reflectances.is_empty() && samples.is_empty() {
        reflectances.clone_from(&means);
    }
    let chosen = match (&reflectances[..], &raw[..], &samples[..]) {
        (found @ [_, ..], _, []) => found.to_vec(),
        // A spectrometer's own table: what is not reflectance is what it was made of.
        ([one], [_, ..], _) => vec![*one],
        ([], [], found @ [_, ..]) => {
            let is_explained = |mean: usize| is_middle(table, mean, found) || is_constant(table, mean, found);
            if let Some(&odd) = means.iter().find(|mean| !is_explained(**mean)) {
                let mut all = [found, &means[..]].concat();
                all.sort_unstable();
                return Err(Error::input(format!(
                    "columns {} may all be reflectances, but {} is not the mean of the others; name one with `column`",
                    list(&all),
                    label(table, odd)
                ))
                .naming(&["column"]));
            }
            found.to_vec()
        }
        ([], [], []) => {
            return Err(Error::input(
                "has wavelengths but no column of reflectance; write lines such as 500,0.12",
            ));
        }
        _ => {
            let mut all = [reflectances, raw, samples].concat();
            all.sort_unstable();
            let what = if all.len() == 1 { "column" } else { "columns" };
            let verdict = if all.len() == 1 {
                "is no reflectance by its name"
            } else {
                "are not all reflectances by their names"
            };
            return Err(Error::input(format!("{what} {} {verdict}; name one with `column`", list(&all)))
                .naming(&["column"]));
        }
    };
    let dropped: Vec<usize> =
        (0..roles.len()).filter(|i| roles[*i].is_some() && !chosen.contains(i)).collect();
    if !dropped.is_empty() {
        said.push(format!("{} left out", list(&dropped)));
    }
    Ok(chosen)
}

/// Whether a column is the average or the median of others, in the lines where all have numbers.
fn is_middle(table: &Table, column: usize, others: &[usize]) -> bool {
    let (mut largest, mut off_average, mut off_median) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut is_known = false;
    let mut beside: Vec<f64> = Vec::with_capacity(others.len());
    for (row, &value) in table.columns[column].iter().enumerate() {
        beside.clear();
        beside.extend(others.iter().map(|&other| table.columns[other][row]));
        if !value.is_finite() || !beside.iter().all(|v| v.is_finite()) {
            continue;
        }
        beside.sort_by(f64::total_cmp);
        let average = beside.iter().sum::<f64>() / beside.len() as f64;
        let median = 0.5 * (beside[(beside.len() - 1) / 2] + beside[beside.len() / 2]);
        largest = largest.max(value.abs());
        off_average = off_average.max((value - average).abs());
        off_median = off_median.max((value - median).abs());
        is_known = true;
    }
    is_known && off_average.min(off_median) <= ROUNDED * largest
}

/// Whether a column has the same number in every line, too large for parts of 1, beside samples in parts of 1: a number of
/// birds, whatever it is called.
fn is_constant(table: &Table, column: usize, samples: &[usize]) -> bool {
    let known = |column: usize| table.columns[column].iter().copied().filter(|value| value.is_finite());
    let Some(first) = known(column).next() else { return false };
    first > PERCENT_ABOVE
        && known(column).count() > 2
        && known(column).all(|value| value == first)
        && samples.iter().all(|&sample| known(sample).all(|value| value <= PERCENT_ABOVE))
}

/// The column that the user names, by name or number.
fn named(table: &Table, positions: &[(usize, Unit)], wanted: &str) -> Result<usize> {
    let wanted = wanted.trim();
    let matching: Vec<usize> =
        (0..table.names.len()).filter(|&i| table.names[i].trim().eq_ignore_ascii_case(wanted)).collect();
    let by_number = wanted.parse::<usize>().ok().filter(|n| (1..=table.names.len()).contains(n));
    let found = match matching[..] {
        [one] => one,
        [one, other, ..] => {
            return Err(Error::input(format!(
                "`column` {}: columns {} and {} have this name; give the number",
                shortened(wanted),
                one + 1,
                other + 1
            ))
            .naming(&["column"]));
        }
        [] => match by_number {
            Some(number) => number - 1,
            None => {
                return Err(no_such(
                    wanted,
                    table.names.iter().map(String::as_str),
                    "column",
                    table.names.len(),
                ));
            }
        },
    };
    if positions.iter().any(|(position, _)| *position == found) {
        return Err(Error::input(format!(
            "`column` {}: that column is the wavelength; name one of reflectance",
            shortened(wanted)
        ))
        .naming(&["column"]));
    }
    Ok(found)
}

/// The refusal of a name that none of so many things has.
pub(super) fn no_such<'a>(
    wanted: &str,
    names: impl Iterator<Item = &'a str> + Clone,
    what: &str,
    count: usize,
) -> Error {
    let known = names.filter(|name| !name.trim().is_empty());
    let list: Vec<_> = known.clone().take(8).map(|name| format!("'{}'", shortened(name))).collect();
    let near = did_you_mean(&shortened(wanted), known.take(1000));
    Error::input(format!(
        "`column` {}: there is no such {what}{near}; there are {count} {what}s{}",
        shortened(wanted),
        if list.is_empty() { String::new() } else { format!(": {}", shortened_list(&list)) }
    ))
    .naming(&["column"])
}

/// Names side by side, short enough for a sentence.
pub(super) fn shortened_list(names: &[String]) -> String {
    let mut text = String::new();
    for name in names {
        if text.chars().count() + name.chars().count() > 240 {
            return format!("{text}, …");
        }
        text = if text.is_empty() { name.clone() } else { format!("{text}, {name}") };
    }
    text
}
