//! Reading tables of keys with messages that name the key, its range, and the nearest known one.

mod json_text;
mod key;
mod record;
mod spot;
mod toml_text;
mod value;

use std::ops::RangeInclusive;

pub use serde_json::{Map, Value};

pub use json_text::{in_json, parse_json};
pub use key::{Choice, Key, Kind, Usual, canonical, inner, schema, table_at};
pub use record::{Fed, Record, chosen, one_of, unknown};
pub use toml_text::{at_key, at_line, at_span, in_toml, line_of, parse_toml};
pub use value::{FieldValue, NumbersByName, Several, Text, Within, degrees, up_to, within};

use crate::error::{did_you_mean, shortened};
use crate::{Error, Result};

/// A table of a user's file; `place` is its path inside the file, empty at the top.
#[derive(Debug)]
pub struct Fields<'a> {
    value: &'a Value,
    table: &'a Map<String, Value>,
    place: String,
}

impl<'a> Fields<'a> {
    /// The fields of a value that must be a table with no keys but `known`.
    ///
    /// # Errors
    /// Not a table, or an unknown key.
    pub fn new(value: &'a Value, place: &str, known: &[&str]) -> Result<Self> {
        let Value::Object(table) = value else {
            let what = if place.is_empty() { "the file" } else { place };
            let error = Error::input(format!("{what} is {}, but must be a table of keys", kind(value)));
            return Err(if place.is_empty() { error } else { error.about(place) });
        };
        let fields = Self { value, table, place: place.to_owned() };
        if let Some(key) = table.keys().find(|key| !known.contains(&key.as_str())) {
            let unknown = shortened(key);
            let near = did_you_mean(&unknown, known.iter().copied());
            let help = if near.is_empty() { format!("; known are {}", known.join(", ")) } else { near };
            let error = Error::input(format!("{}unknown key '{unknown}'{help}", fields.prefix()));
            return Err(error.about(fields.path(key)));
        }
        Ok(fields)
    }

    fn prefix(&self) -> String {
        if self.place.is_empty() { String::new() } else { format!("{}: ", self.place) }
    }

    /// The whole table.
    #[must_use]
    pub fn table(&self) -> &'a Value {
        self.value
    }

    /// Its path inside the file, empty at the top.
    #[must_use]
    pub fn place(&self) -> &str {
        &self.place
    }

    /// The path of a key inside the file.
    #[must_use]
    pub fn path(&self, key: &str) -> String {
        path_of(&self.place, key)
    }

    /// The value of a key that may be left out.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&'a Value> {
        self.table.get(key)
    }

    /// The value of a key that is needed; `what` says what to give.
    ///
    /// # Errors
    /// It is missing.
    pub fn need(&self, key: &str, what: &str) -> Result<&'a Value> {
        self.get(key).ok_or_else(|| refused(self.path(key), &format!("is missing; give {what}")))
    }

    /// A text that may be left out.
    ///
    /// # Errors
    /// It is not a text.
    pub fn text(&self, key: &str) -> Result<Option<&'a str>> {
        match self.get(key) {
            None => Ok(None),
            Some(Value::String(text)) => Ok(Some(text)),
            Some(other) => {
                Err(refused(self.path(key), &format!("is {}, but must be a text in quotes", kind(other))))
            }
        }
    }

    /// A number that may be left out.
    ///
    /// # Errors
    /// It is no number.
    pub fn number(&self, key: &str) -> Result<Option<f64>> {
        self.get(key).map(|value| number(value, &self.path(key))).transpose()
    }

    /// A number that is needed.
    ///
    /// # Errors
    /// It is missing or no number.
    pub fn need_number(&self, key: &str, what: &str) -> Result<f64> {
        number(self.need(key, what)?, &self.path(key))
    }

    /// A number from `low` to `high` that is needed; not a number: refused. Keys that end in `_um` are lengths, and what
    /// would fit as nm is asked for.
    ///
    /// # Errors
    /// It is missing, no number or outside.
    pub fn number_within(&self, key: &str, low: f64, high: f64) -> Result<f64> {
        number_in(self.need(key, &format!("a number from {low} to {high}"))?, &self.path(key), low, high)
    }

    /// A whole number from `low` to `high` that is needed.
    ///
    /// # Errors
    /// It is missing, no whole number or outside.
    pub fn count_within(&self, key: &str, low: usize, high: usize) -> Result<usize> {
        let value = self.number_within(key, low as f64, high as f64)?;
        if value.fract() != 0.0 {
            let what = format!("is {}, but must be a whole number", shown(value));
            return Err(refused(self.path(key), &what));
        }
        Ok(value as usize)
    }

    /// A list of numbers that is needed.
    ///
    /// # Errors
    /// It is missing, no list, or holds what is no number.
    pub fn numbers(&self, key: &str) -> Result<Vec<f64>> {
        let path = self.path(key);
        let values = self.list(key, "a list of numbers")?;
        values.iter().enumerate().map(|(i, value)| number(value, &format!("{path}[{i}]"))).collect()
    }

    /// A list that is needed.
    ///
    /// # Errors
    /// It is missing or no list.
    pub fn list(&self, key: &str, what: &str) -> Result<&'a [Value]> {
        list(self.need(key, what)?, &self.path(key))
    }
}

/// The path of a key in a table at `place`, which is empty at the top.
#[must_use]
pub fn path_of(place: &str, key: &str) -> String {
    if place.is_empty() { key.to_owned() } else { format!("{place}.{key}") }
}

/// A value that must be a number from `low` to `high`. Keys that end in `_um` are lengths, and what would fit as nm is asked for.
///
/// # Errors
/// It is no number or outside.
pub fn number_in(value: &Value, path: &str, low: f64, high: f64) -> Result<f64> {
    let value = number(value, path)?;
    if (low..=high).contains(&value) {
        return Ok(value);
    }
    let hint = if path.ends_with("_um") { typed_in_nm(value, &(low..=high)) } else { String::new() };
    Err(refused(path, &format!("is {}, outside {low} to {high}{hint}", shown(value))))
}

/// The refusal of a value that must be something else.
#[must_use]
pub fn wrong_kind(value: &Value, path: &str, wanted: &str) -> Error {
    refused(path, &format!("is {}, but must be {wanted}", kind(value)))
}

/// `; did you mean 0.2 (200 nm)?` for a length that is out of its range in µm but in it where nm were typed, else nothing.
#[must_use]
pub fn typed_in_nm(value_um: f64, allowed_um: &RangeInclusive<f64>) -> String {
    // Nobody types parts of a nm.
    let meant_um = value_um / 1000.0;
    if value_um.abs() < 1.0 || allowed_um.contains(&value_um) || !allowed_um.contains(&meant_um) {
        return String::new();
    }
    format!("; did you mean {meant_um} ({value_um} nm)?")
}

/// A number in few letters: huge and tiny ones with an exponent.
#[must_use]
pub fn shown(value: f64) -> String {
    let text = format!("{value:?}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// A value that must be a list.
///
/// # Errors
/// It is none.
pub fn list<'a>(value: &'a Value, place: &str) -> Result<&'a [Value]> {
    match value {
        Value::Array(values) => Ok(values),
        other => Err(refused(place, &format!("is {}, but must be a list", kind(other)))),
    }
}

/// A value that must be a number.
///
/// # Errors
/// It is none, or not finite.
pub fn number(value: &Value, place: &str) -> Result<f64> {
    match value {
        Value::Number(number) => number.as_f64().filter(|n| n.is_finite()).ok_or_else(|| {
            refused(place, &format!("is {number}, which no 64-bit float holds; give a smaller number"))
        }),
        // JSON has no NaN, and TOML's ones arrive as null.
        Value::Null => Err(refused(place, "is not a finite number; give a finite one")),
        other => Err(refused(place, &format!("is {}, but must be a number", kind(other)))),
    }
}

/// A sentence about a key that begins with it.
pub(crate) fn refused(key: impl Into<String>, what: &str) -> Error {
    let key = key.into();
    Error::input(format!("{key} {what}")).about(key)
}

fn kind(value: &Value) -> String {
    match value {
        Value::Null => "null".into(),
        Value::Bool(value) => format!("{value}"),
        Value::Number(number) => format!("the number {number}"),
        Value::String(text) => format!("the text '{}'", shortened(text)),
        Value::Array(_) => "a list".into(),
        Value::Object(_) => "a table".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nm_are_guessed_only_where_they_would_fit() {
        let hint = |value| typed_in_nm(value, &(0.001..=10.0));
        assert_eq!(hint(200.0), "; did you mean 0.2 (200 nm)?");
        assert_eq!([hint(5.0), hint(1e6), hint(-200.0), hint(0.0005), hint(f64::NAN)], [const { "" }; 5]);
        let table = serde_json::json!({"cortex_um": 205, "count": 205});
        let fields = Fields::new(&table, "parameters", &["cortex_um", "count"]).unwrap();
        let message = fields.number_within("cortex_um", 0.001, 10.0).unwrap_err().to_string();
        assert_eq!(message, "parameters.cortex_um is 205, outside 0.001 to 10; did you mean 0.205 (205 nm)?");
        assert!(!fields.number_within("count", 0.0, 10.0).unwrap_err().to_string().contains("nm"));
        assert_eq!([shown(25.0), shown(0.19), shown(1e300), shown(-0.0)], ["25", "0.19", "1e300", "-0"]);
    }
}
