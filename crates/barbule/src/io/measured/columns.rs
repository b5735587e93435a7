//! Which column of a table is the wavelength, and which are samples.

use super::table::Table;
use super::{Found, Unit};
use crate::error::{did_you_mean, shortened};
use crate::{Error, Result};

/// What a column is by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// Where the values lie.
    Position(Unit),
    /// A reflectance, by its name.
    Reflectance,
    /// What a spectrometer's own files hold beside: counts, dark, reference, and other quantities than reflectance.
    Raw,
    /// A spread, an angle or another thing that is no sample.
    Beside,
    /// Anything else: the name of a sample.
    Sample,
}

const POSITIONS: [&str; 10] =
    ["wl", "wvl", "wave", "wavelength", "wavelengths", "lambda", "λ", "nm", "nanometers", "nanometres"];
const MICROMETRES: [&str; 7] = ["um", "µm", "μm", "micron", "microns", "micrometers", "micrometres"];
const WAVE_NUMBERS: [&str; 4] = ["wavenumber", "wavenumbers", "cm⁻¹", "kayser"];
/// Each alone says reflectance, whatever stands beside it.
const REFLECTANCES: [&str; 7] =
    ["refl", "reflectance", "reflectances", "reflection", "reflectivity", "reflektanz", "processed"];
/// A reflectance when nothing else stands beside.
const SHORT_REFLECTANCES: [&str; 5] = ["r", "%r", "%", "percent", "pct"];
/// No reflectance when nothing else stands beside: a sample may be a white throat.
const RAW: [&str; 16] = [
    "dark",
    "reference",
    "white",
    "counts",
    "count",
    "scope",
    "raw",
    "intensity",
    "irradiance",
    "radiance",
    "absorbance",
    "transmittance",
    "transmission",
    "absorption",
    "background",
    "%",
];
/// Spreads, first or last in a name.
const SPREADS: [&str; 9] = ["sd", "std", "stdev", "stddev", "se", "sem", "err", "error", "variance"];
/// Other columns than samples when nothing else stands beside.
const BESIDE: [&str; 6] = ["angle", "theta", "phi", "deg", "temperature", "time"];

/// The words of a name in lower case.
fn words(name: &str) -> Vec<String> {
    let word = |c: char| c.is_alphanumeric() || c == '%' || c == '⁻';
    name.split(|c| !word(c)).filter(|w| !w.is_empty()).map(str::to_lowercase).collect()
}

/// The unit of a column whose name says that it is a wavelength or a wave number; none of another.
pub(in crate::io) fn position_unit(name: &str) -> Option<Unit> {
    let words = words(name);
    let has = |known: &[&str]| words.iter().any(|word| known.contains(&word.as_str()));
    let all_are = |known: &[&[&str]]| words.iter().all(|w| known.iter().any(|k| k.contains(&w.as_str())));
    let inverse = name.to_lowercase().replace(' ', "");
    if has(&WAVE_NUMBERS) || ["1/cm", "cm-1", "cm^-1"].iter().any(|unit| inverse.contains(unit)) {
        return Some(Unit::PerCentimetre);
    }
    if words.is_empty() || !all_are(&[&POSITIONS, &MICROMETRES, &["in", "vacuum", "air", "x"]]) {
        return None;
    }
    if has(&MICROMETRES) {
        return Some(Unit::Micrometres);
    }
    has(&POSITIONS).then_some(Unit::Nanometres)
}

fn role(name: &str) -> Role {
    if let Some(unit) = position_unit(name) {
        return Role::Position(unit);
    }
    let words = words(name);
    let any = |known: &[&str]| words.iter().any(|word| known.contains(&word.as_str()));
    let all = |known: &[&str]| !words.is_empty() && words.iter().all(|word| known.contains(&word.as_str()));
    let ends = [words.first(), words.last()];
    match () {
        () if ends.iter().flatten().any(|word| SPREADS.contains(&word.as_str())) => Role::Beside,
        () if all(&BESIDE) => Role::Beside,
        () if any(&REFLECTANCES) || all(&SHORT_REFLECTANCES) => Role::Reflectance,
        () if all(&RAW) => Role::Raw,
        () => Role::Sample,
    }
}

/// Whether numbers count lines: 0, 1, 2, … or 1, 2, 3, …
pub(super) fn is_count(values: &[f64]) -> bool {
    let first = values.first().copied().unwrap_or(-1.0);
    (first == 0.0 || first == 1.0)
        && values.len() > 1
        && values.iter().enumerate().all(|(i, v)| *v == first + i as f64)
}

/// Whether numbers could be wavelengths in nm.
fn is_like_nm(values: &[f64]) -> bool {
    let known: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    let all = |holds: fn(f64, f64) -> bool| known.windows(2).all(|pair| holds(pair[0], pair[1]));
    known.len() > 1
        && known.iter().all(|v| (100.0..30_000.0).contains(v))
        && (all(|a, b| a <= b) || all(|a, b| a >= b))
        && known[0] != known[known.len() - 1]
}

/// Chooses the wavelengths and the samples of a table; `wanted` is the name of one column or its number from 1.
pub(super) fn choose(table: Table, wanted: Option<&str>) -> Result<Found> {
    let mut roles: Vec<Option<Role>> = table.names.iter().map(|name| Some(role(name))).collect();
    let mut said = vec![table.said.clone()];
    // The columns of Ocean Optics' Jaz: wavelength, dark, reference, sample, processed.
    if table.names.iter().map(|n| n.to_lowercase()).eq(["w", "d", "r", "s", "p"]) {
        let raw = Some(Role::Raw);
        roles = vec![Some(Role::Position(Unit::Nanometres)), raw, raw, raw, Some(Role::Reflectance)];
    }
    for (i, values) in table.columns.iter().enumerate() {
        let name = table.names[i].to_lowercase();
        if values.iter().all(|v| v.is_nan()) {
            roles[i] = None;
        } else if is_count(values) && ["", "x", "index", "row", "id", "no", "n", "#"].contains(&name.as_str())
        {
            roles[i] = None;
            said.push("row numbers left out".into());
        }
    }
    let (position, unit) = position(&table, &roles)?;
    roles[position] = None;
    let label = |i: usize| match table.names[i].trim() {
        "" => format!("column {}", i + 1),
        name => format!("'{}'", shortened(name)),
    };
    let chosen = match wanted {
        Some(wanted) => vec![named(&table, position, wanted)?],
        None => samples(&roles, &label, &mut said)?,
    };
    let headed = |i: &usize| {
        let name = table.names[*i].to_lowercase();
        name.contains('%')
            || words(&name).iter().any(|w| ["percent", "percentage", "pct"].contains(&w.as_str()))
    };
    let percent = chosen.iter().filter(|i| headed(i)).count();
    let largest = |i: &usize| table.columns[*i].iter().copied().fold(0.0, f64::max);
    if percent > 0
        && let Some(other) = chosen.iter().find(|i| !headed(i) && largest(i) <= super::PERCENT_ABOVE)
    {
        return Err(Error::input(format!(
            "some columns are in percent by their names, but {} is not and has values to {}; name one with `column`",
            label(*other),
            largest(other)
        ))
        .naming(&["column"]));
    }
    let samples =
        chosen.iter().map(|&i| (shortened(table.names[i].trim()), table.columns[i].clone())).collect();
    Ok(Found {
        said,
        position: label(position),
        unit,
        rows: table.lines.iter().copied().zip(table.columns[position].iter().copied()).collect(),
        samples,
        percent: percent > 0 || table.percent,
    })
}

/// The column of wavelengths, by its name or else by its numbers.
fn position(table: &Table, roles: &[Option<Role>]) -> Result<(usize, Unit)> {
    let named: Vec<(usize, Unit)> = roles
        .iter()
        .enumerate()
        .filter_map(|(i, role)| match role {
            Some(Role::Position(unit)) => Some((i, *unit)),
            _ => None,
        })
        .collect();
    if let [(first, unit), others @ ..] = &named[..] {
        let (first, unit) = (*first, *unit);
        // The same wavelengths again, before each sample: spreadsheets that were put side by side.
        return match others.iter().find(|(i, _)| table.columns[*i] != table.columns[first]) {
            None => Ok((first, unit)),
            Some((other, _)) => Err(Error::input(format!(
                "columns {} '{}' and {} '{}' are both wavelengths, and differ; keep one, or give each sample a file",
                first + 1,
                shortened(&table.names[first]),
                other + 1,
                shortened(&table.names[*other])
            ))),
        };
    }
    let like: Vec<usize> =
        (0..roles.len()).filter(|&i| roles[i].is_some() && is_like_nm(&table.columns[i])).collect();
    let first = roles.iter().position(Option::is_some).unwrap_or_default();
    match like[..] {
        // By custom the first column.
        [one, ..] if one == first => Ok((one, Unit::Nanometres)),
        [one] => Ok((one, Unit::Nanometres)),
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
fn samples(
    roles: &[Option<Role>],
    label: &dyn Fn(usize) -> String,
    said: &mut Vec<String>,
) -> Result<Vec<usize>> {
    let of = |wanted: Role| (0..roles.len()).filter(|&i| roles[i] == Some(wanted)).collect::<Vec<_>>();
    let (reflectances, raw, samples) = (of(Role::Reflectance), of(Role::Raw), of(Role::Sample));
    let list =
        |columns: &[usize]| shortened_list(&columns.iter().take(50).map(|&i| label(i)).collect::<Vec<_>>());
    let chosen = match (&reflectances[..], &raw[..], &samples[..]) {
        (found @ [_, ..], _, []) => found.to_vec(),
        // A spectrometer's own table: what is not reflectance is what it was made of.
        ([one], [_, ..], _) => vec![*one],
        ([], [], found @ [_, ..]) => found.to_vec(),
        ([], [], []) => {
            return Err(Error::input(
                "has wavelengths but no column of reflectance; write lines such as 500,0.12",
            ));
        }
        _ => {
            let mut all = [reflectances, raw, samples].concat();
            all.sort_unstable();
            return Err(Error::input(format!(
                "columns {} are not all reflectances by their names; name one with `column`",
                list(&all)
            ))
            .naming(&["column"]));
        }
    };
    let dropped: Vec<usize> =
        (0..roles.len()).filter(|i| roles[*i].is_some() && !chosen.contains(i)).collect();
    let dropped: Vec<usize> =
        dropped.into_iter().filter(|&i| !matches!(roles[i], Some(Role::Position(_)))).collect();
    if !dropped.is_empty() {
        said.push(format!("{} left out", list(&dropped)));
    }
    Ok(chosen)
}

/// The column that the user names, by name or number.
fn named(table: &Table, position: usize, wanted: &str) -> Result<usize> {
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
                let known = || table.names.iter().map(String::as_str).filter(|n| !n.trim().is_empty());
                let list: Vec<_> = known().take(8).map(|n| format!("'{}'", shortened(n))).collect();
                let near = did_you_mean(&shortened(wanted), known().take(1000));
                return Err(Error::input(format!(
                    "`column` {}: there is no such column{near}; there are {} columns{}",
                    shortened(wanted),
                    table.names.len(),
                    if list.is_empty() { String::new() } else { format!(": {}", shortened_list(&list)) }
                ))
                .naming(&["column"]));
            }
        },
    };
    if found == position {
        return Err(Error::input(format!(
            "`column` {}: that column is the wavelength; name one of reflectance",
            shortened(wanted)
        ))
        .naming(&["column"]));
    }
    Ok(found)
}

/// Names side by side, short enough for a sentence.
fn shortened_list(names: &[String]) -> String {
    let mut text = String::new();
    for name in names {
        if text.chars().count() + name.chars().count() > 240 {
            return format!("{text}, …");
        }
        text = if text.is_empty() { name.clone() } else { format!("{text}, {name}") };
    }
    text
}
