//! Reading tables of keys with messages that name the key, its range, and the nearest known one.

use serde_json::{Map, Value};

use crate::error::{did_you_mean, shortened};
use crate::{Error, Result};

/// A table of a user's file; `place` is its path inside the file, empty at the top.
#[derive(Debug)]
pub struct Fields<'a> {
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
            return Err(Error::input(format!("{what} is {}, but must be a table of keys", kind(value))));
        };
        let fields = Self { table, place: place.to_owned() };
        if let Some(unknown) = table.keys().find(|key| !known.contains(&key.as_str())) {
            let unknown = shortened(unknown);
            let near = did_you_mean(&unknown, known.iter().copied());
            let help = if near.is_empty() { format!("; known are {}", known.join(", ")) } else { near };
            return Err(Error::input(format!("{}unknown key '{unknown}'{help}", fields.prefix())));
        }
        Ok(fields)
    }

    fn prefix(&self) -> String {
        if self.place.is_empty() { String::new() } else { format!("{}: ", self.place) }
    }

    /// The path of a key inside the file.
    #[must_use]
    pub fn path(&self, key: &str) -> String {
        if self.place.is_empty() { key.to_owned() } else { format!("{}.{key}", self.place) }
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
        self.get(key).ok_or_else(|| Error::input(format!("{} is missing; give {what}", self.path(key))))
    }

    /// A text that may be left out.
    ///
    /// # Errors
    /// It is not a text.
    pub fn text(&self, key: &str) -> Result<Option<&'a str>> {
        match self.get(key) {
            None => Ok(None),
            Some(Value::String(text)) => Ok(Some(text)),
            Some(other) => Err(Error::input(format!(
                "{} is {}, but must be a text in quotes",
                self.path(key),
                kind(other)
            ))),
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

    /// A number from `low` to `high` that is needed; not a number: refused.
    ///
    /// # Errors
    /// It is missing, no number or outside.
    pub fn number_within(&self, key: &str, low: f64, high: f64) -> Result<f64> {
        let value = self.need_number(key, &format!("a number from {low} to {high}"))?;
        if (low..=high).contains(&value) {
            return Ok(value);
        }
        Err(Error::input(format!("{} is {value}, outside {low} to {high}", self.path(key))))
    }

    /// A whole number from `low` to `high` that is needed.
    ///
    /// # Errors
    /// It is missing, no whole number or outside.
    pub fn count_within(&self, key: &str, low: usize, high: usize) -> Result<usize> {
        let value = self.number_within(key, low as f64, high as f64)?;
        if value.fract() != 0.0 {
            return Err(Error::input(format!("{} is {value}, but must be a whole number", self.path(key))));
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

/// A value that must be a list.
///
/// # Errors
/// It is none.
pub fn list<'a>(value: &'a Value, place: &str) -> Result<&'a [Value]> {
    match value {
        Value::Array(values) => Ok(values),
        other => Err(Error::input(format!("{place} is {}, but must be a list", kind(other)))),
    }
}

/// A value that must be a number.
///
/// # Errors
/// It is none, or not finite.
pub fn number(value: &Value, place: &str) -> Result<f64> {
    match value {
        Value::Number(number) => number.as_f64().filter(|n| n.is_finite()).ok_or_else(|| {
            Error::input(format!("{place} is {number}, which no 64-bit float holds; give a smaller number"))
        }),
        // JSON has no NaN, and TOML's ones arrive as null.
        Value::Null => Err(Error::input(format!("{place} is not a finite number; give a finite one"))),
        other => Err(Error::input(format!("{place} is {}, but must be a number", kind(other)))),
    }
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
