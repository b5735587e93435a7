//! Sets of numbers as people type them: `520`, `400,442,484`, `400:694:6` (start:stop:step, stop included).

use barbule::characterize::outside_wavelengths;
use barbule::error::shortened;
use barbule::math::steps::{stepped, steps_between};
use barbule::spectrum::Wavelengths;
use barbule::{Error, Result};

/// No command can use more values than this.
const MOST_VALUES: usize = 100_000;

/// Reads a set; `flag` names it in messages. The result keeps the order typed and is never empty.
///
/// # Errors
/// Not a number, not finite, a step of the wrong sign or zero, or over 100,000 values.
pub fn parse(flag: &str, text: &str) -> Result<Vec<f64>> {
    let mut values = Vec::new();
    for part in text.split(',') {
        let numbers = part
            .split(':')
            .map(|t| t.trim().parse::<f64>().ok().filter(|v| v.is_finite()))
            .collect::<Option<Vec<_>>>()
            .ok_or_else(|| {
                Error::input(format!(
                    "{flag} {}: '{}' is not a number or start:stop:step, as in 400:694:6",
                    shortened(text),
                    shortened(part)
                ))
            })?;
        match numbers[..] {
            [value] => values.push(value),
            [start, stop, step] => {
                let Some(count) = steps_between(start, stop, step) else {
                    return Err(Error::input(format!(
                        "{flag} {}: the step {step} does not lead from {start} to {stop}",
                        shortened(text)
                    )));
                };
                if count > MOST_VALUES as f64 {
                    return Err(Error::input(format!(
                        "{flag} {}: over {MOST_VALUES} values",
                        shortened(text)
                    )));
                }
                values.extend(stepped(start, step, count));
            }
            _ => {
                return Err(Error::input(format!(
                    "{flag} {}: '{}' is not a number or start:stop:step",
                    shortened(text),
                    shortened(part)
                )));
            }
        }
        if values.len() > MOST_VALUES {
            return Err(Error::input(format!("{flag} {}: over {MOST_VALUES} values", shortened(text))));
        }
    }
    Ok(values)
}

/// A set as people write it: `start:stop:step` of whole steps, else every value.
#[must_use]
pub fn written(values: &[f64]) -> String {
    if let [first, second, .., last] = values {
        let text = format!("{first}:{last}:{}", second - first);
        if parse("", &text).is_ok_and(|found| found == values) {
            return text;
        }
    }
    values.iter().map(f64::to_string).collect::<Vec<_>>().join(",")
}

/// A set of wavelengths in nm: sorted, within 300–830, none twice.
///
/// # Errors
/// As [`parse`], or a wavelength out of range.
pub fn wavelengths(text: &str) -> Result<Vec<f64>> {
    wavelengths_of("--wavelengths", text)
}

/// As [`wavelengths`]; `flag` names the set in messages.
///
/// # Errors
/// As [`wavelengths`].
pub fn wavelengths_of(flag: &str, text: &str) -> Result<Vec<f64>> {
    let mut values = parse(flag, text)?;
    if let Some(outside) = values.iter().find_map(|nm| outside_wavelengths(*nm)) {
        return Err(Error::input(format!("{flag}: {outside}")));
    }
    values.sort_by(f64::total_cmp);
    values.dedup();
    Ok(values)
}

/// As [`wavelengths`], for simulations and films.
///
/// # Errors
/// As [`wavelengths`].
pub fn wavelength_set(text: &str) -> Result<Wavelengths> {
    Wavelengths::new(wavelengths(text)?)
}

/// A range of wavelengths in nm, as in 400:700: both ends positive and finite, the second above the first.
///
/// # Errors
/// Not such a range.
pub fn range_nm(flag: &str, text: &str) -> Result<[f64; 2]> {
    let end = |text: &str| text.trim().parse::<f64>().ok().filter(|nm| nm.is_finite() && *nm > 0.0);
    let ends = text.split_once(':').and_then(|(from, to)| Some([end(from)?, end(to)?]));
    ends.filter(|[from, to]| from < to).ok_or_else(|| {
        Error::input(format!(
            "{flag} {}: write FROM:TO in nm with FROM below TO, as in 400:700",
            shortened(text)
        ))
    })
}

/// A single angle in degrees.
///
/// # Errors
/// As [`angles`], or a set of several.
pub fn angle(flag: &str, text: &str) -> Result<f64> {
    single(flag, text, &angles(flag, text)?.0)
}

fn single(flag: &str, text: &str, values: &[f64]) -> Result<f64> {
    match values {
        [value] => Ok(*value),
        _ => Err(Error::input(format!("{flag} {}: give one value", shortened(text)))),
    }
}

/// Angles in degrees in the order typed, each with |angle| < 90; at least one.
#[derive(Debug, Clone)]
pub struct Angles(pub Vec<f64>);

/// A set of angles in degrees.
///
/// # Errors
/// As [`parse`], or an angle at or past grazing.
pub fn angles(flag: &str, text: &str) -> Result<Angles> {
    let values = parse(flag, text)?;
    match values.iter().find(|v| v.abs() >= 90.0) {
        Some(bad) => Err(Error::input(format!(
            "{flag}: {bad}° is at or past grazing; give an angle between -90 and 90"
        ))),
        None => Ok(Angles(values)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_three_forms_are_read() {
        assert_eq!(parse("-x", "520").unwrap(), [520.0]);
        assert_eq!(parse("-x", "400,442,484").unwrap(), [400.0, 442.0, 484.0]);
        let range = parse("-x", "400:694:6").unwrap();
        assert_eq!((range.len(), range[49]), (50, 694.0));
        assert_eq!(parse("-x", "0:0.3:0.1").unwrap(), [0.0, 0.1, 0.2, 0.3]);
    }

    #[test]
    fn what_is_written_is_read_as_it_was() {
        for (text, short) in [("400:694:6", "400:694:6"), ("1,2,4", "1,2,4"), ("5", "5"), ("1,2", "1,2")] {
            assert_eq!(written(&parse("-x", text).unwrap()), short);
        }
    }

    #[test]
    fn bad_sets_are_refused() {
        for bad in ["", "a", "1:2", "1:2:-1", "1:2:0", "1:2:3:4", "nan", "inf", "0:1:1e-9"] {
            assert!(parse("--wavelengths", bad).unwrap_err().is_input(), "{bad}");
        }
        assert!(wavelengths("299").is_err());
        assert!(angles("--angle", "-90").is_err());
    }
}
