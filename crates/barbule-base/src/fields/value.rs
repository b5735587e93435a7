//! Values that keys of records may have: numbers within ranges, lists, texts, tables.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

use super::key::Kind;
use super::record::{Fed, Record};
use super::{list, number, number_in, path_of, refused, shown, wrong_kind};
use crate::error::counted;
use crate::identity::Hasher;
use crate::{Error, Result};

/// A value that a key may have.
pub trait FieldValue: Sized {
    /// What tells allowed values from others.
    type Limits;

    /// Whether the key may be left out, whatever else is said.
    const OPTIONAL: bool = false;

    /// Reads a value; `path` is the key's.
    ///
    /// # Errors
    /// It is of the wrong kind or out of range.
    fn of_value(value: &Value, path: &str, limits: &Self::Limits) -> Result<Self>;

    /// What a key that is left out means where no usual value is given.
    ///
    /// # Errors
    /// It may not be left out.
    fn missing(path: &str, limits: &Self::Limits) -> Result<Self> {
        Err(refused(path, &format!("is missing; give {}", Self::kind(limits).wanted())))
    }

    /// The value in a file; `None`: the key is left out.
    fn to_value(&self, limits: &Self::Limits) -> Option<Value>;

    /// Refuses a value out of range.
    ///
    /// # Errors
    /// As the method says.
    fn check_value(&self, path: &str, limits: &Self::Limits) -> Result<()>;

    /// Feeds the value under a key.
    fn feed_value(&self, key: &str, to: &mut Hasher);

    /// What values there are, for people and editors.
    fn kind(limits: &Self::Limits) -> Kind;
}

impl<T: Record> FieldValue for T {
    type Limits = ();

    fn of_value(value: &Value, path: &str, (): &()) -> Result<Self> {
        T::read(value, path)
    }

    fn to_value(&self, (): &()) -> Option<Value> {
        Some(self.table()).filter(|table| table.as_object().is_some_and(|table| !table.is_empty()))
    }

    fn check_value(&self, path: &str, (): &()) -> Result<()> {
        T::check(self, path)
    }

    fn feed_value(&self, key: &str, to: &mut Hasher) {
        to.part(key, &Fed(self));
    }

    fn kind((): &()) -> Kind {
        Kind::Table(T::keys())
    }
}

/// A range of numbers as files have them, and what they are multiplied with when they are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Within {
    /// The least.
    pub low: f64,
    /// The greatest.
    pub high: f64,
    /// The value in memory of 1 in a file.
    pub unit: f64,
}

/// Numbers from `low` to `high`, the same in files and in memory.
#[must_use]
pub fn within(low: impl Into<f64>, high: impl Into<f64>) -> Within {
    Within { low: low.into(), high: high.into(), unit: 1.0 }
}

/// Angles from `low` to `high` degrees in files, radians in memory.
#[must_use]
pub fn degrees(low: impl Into<f64>, high: impl Into<f64>) -> Within {
    Within { unit: std::f64::consts::PI / 180.0, ..within(low, high) }
}

impl Within {
    fn check(&self, value: f64, path: &str) -> Result<()> {
        let Self { low, high, unit } = *self;
        if (low * unit..=high * unit).contains(&value) {
            return Ok(());
        }
        Err(refused(path, &format!("is {}, outside {low} to {high}", shown(value / unit))))
    }

    /// The number with the fewest digits that is read as this value.
    fn in_file(&self, value: f64) -> f64 {
        let exact = value / self.unit;
        let read = |number: &f64| number * self.unit == value;
        let rounded = (1..=15).filter_map(|digits| format!("{exact:.digits$e}").parse::<f64>().ok());
        rounded.chain([exact, exact.next_up(), exact.next_down()]).find(read).unwrap_or(exact)
    }
}

impl FieldValue for f64 {
    type Limits = Within;

    fn of_value(value: &Value, path: &str, limits: &Within) -> Result<Self> {
        Ok(number_in(value, path, limits.low, limits.high)? * limits.unit)
    }

    fn to_value(&self, limits: &Within) -> Option<Value> {
        Some(limits.in_file(*self).into())
    }

    fn check_value(&self, path: &str, limits: &Within) -> Result<()> {
        limits.check(*self, path)
    }

    fn feed_value(&self, key: &str, to: &mut Hasher) {
        to.number(key, *self);
    }

    fn kind(limits: &Within) -> Kind {
        Kind::Number { low: limits.low, high: limits.high, whole: false }
    }
}

/// Whole numbers of these types.
macro_rules! whole {
    ($($type:ty),*) => {$(
        impl FieldValue for $type {
            type Limits = Within;

            fn of_value(value: &Value, path: &str, limits: &Within) -> Result<Self> {
                let read = number_in(value, path, limits.low, limits.high)?;
                if read.fract() != 0.0 {
                    return Err(Error::input(format!("{path} is {}, but must be a whole number", shown(read))));
                }
                Ok(read as Self)
            }

            fn to_value(&self, _: &Within) -> Option<Value> {
                Some((*self).into())
            }

            fn check_value(&self, path: &str, limits: &Within) -> Result<()> {
                limits.check(*self as f64, path)
            }

            fn feed_value(&self, key: &str, to: &mut Hasher) {
                to.number(key, *self as f64);
            }

            fn kind(limits: &Within) -> Kind {
                Kind::Number { low: limits.low, high: limits.high, whole: true }
            }
        }
    )*};
}
whole!(usize, u32);

/// So many numbers in a list, all of one range: places, sizes, directions.
impl<T: FieldValue<Limits = Within>, const N: usize> FieldValue for [T; N] {
    type Limits = Within;

    fn of_value(value: &Value, path: &str, limits: &Within) -> Result<Self> {
        let values = list(value, path)?;
        let read = |(i, value): (usize, &Value)| T::of_value(value, &format!("{path}[{i}]"), limits);
        let count = counted(values.len(), "number");
        let wanted = || Error::input(format!("{path} has {count}; give {}", Self::kind(limits).wanted()));
        if values.len() != N {
            return Err(wanted());
        }
        let values: Vec<T> = values.iter().enumerate().map(read).collect::<Result<_>>()?;
        values.try_into().map_err(|_| wanted())
    }

    fn to_value(&self, limits: &Within) -> Option<Value> {
        self.iter().map(|value| value.to_value(limits)).collect::<Option<Vec<_>>>().map(Value::Array)
    }

    fn check_value(&self, path: &str, limits: &Within) -> Result<()> {
        self.iter().enumerate().try_for_each(|(i, value)| value.check_value(&format!("{path}[{i}]"), limits))
    }

    fn feed_value(&self, key: &str, to: &mut Hasher) {
        self.iter().for_each(|value| value.feed_value(key, to));
    }

    fn kind(limits: &Within) -> Kind {
        Kind::List { of: Box::new(T::kind(limits)), least: N, most: N }
    }
}

impl FieldValue for bool {
    type Limits = ();

    fn of_value(value: &Value, path: &str, (): &()) -> Result<Self> {
        value.as_bool().ok_or_else(|| wrong_kind(value, path, "true or false"))
    }

    fn to_value(&self, (): &()) -> Option<Value> {
        Some((*self).into())
    }

    fn check_value(&self, _: &str, (): &()) -> Result<()> {
        Ok(())
    }

    fn feed_value(&self, key: &str, to: &mut Hasher) {
        to.count(key, u64::from(*self));
    }

    fn kind((): &()) -> Kind {
        Kind::Switch
    }
}

/// What a text is, as in `the name of a material`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Text(pub &'static str);

impl FieldValue for String {
    type Limits = Text;

    fn of_value(value: &Value, path: &str, _: &Text) -> Result<Self> {
        value.as_str().map(str::to_owned).ok_or_else(|| wrong_kind(value, path, "a text in quotes"))
    }

    fn to_value(&self, _: &Text) -> Option<Value> {
        Some(self.as_str().into())
    }

    fn check_value(&self, _: &str, _: &Text) -> Result<()> {
        Ok(())
    }

    fn feed_value(&self, key: &str, to: &mut Hasher) {
        to.text(key, self);
    }

    fn kind(limits: &Text) -> Kind {
        Kind::Text(limits.0)
    }
}

impl<T: FieldValue> FieldValue for Option<T> {
    type Limits = T::Limits;
    const OPTIONAL: bool = true;

    fn of_value(value: &Value, path: &str, limits: &T::Limits) -> Result<Self> {
        T::of_value(value, path, limits).map(Some)
    }

    fn missing(_: &str, _: &T::Limits) -> Result<Self> {
        Ok(None)
    }

    fn to_value(&self, limits: &T::Limits) -> Option<Value> {
        self.as_ref().and_then(|value| value.to_value(limits))
    }

    fn check_value(&self, path: &str, limits: &T::Limits) -> Result<()> {
        self.as_ref().map_or(Ok(()), |value| value.check_value(path, limits))
    }

    fn feed_value(&self, key: &str, to: &mut Hasher) {
        to.count(key, u64::from(self.is_some()));
        if let Some(value) = self {
            value.feed_value(key, to);
        }
    }

    fn kind(limits: &T::Limits) -> Kind {
        T::kind(limits)
    }
}

/// A table of numbers, by keys that are nowhere listed; an empty one is left out where it is written.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NumbersByName(pub BTreeMap<String, f64>);

impl FieldValue for NumbersByName {
    type Limits = ();

    fn of_value(value: &Value, path: &str, (): &()) -> Result<Self> {
        let Value::Object(table) = value else { return Err(wrong_kind(value, path, "a table of numbers")) };
        let one = |(key, value): (&String, &Value)| Ok((key.clone(), number(value, &path_of(path, key))?));
        table.iter().map(one).collect::<Result<_>>().map(Self)
    }

    fn to_value(&self, (): &()) -> Option<Value> {
        let table: Map<String, Value> =
            self.0.iter().map(|(key, value)| (key.clone(), (*value).into())).collect();
        (!table.is_empty()).then_some(Value::Object(table))
    }

    fn check_value(&self, _: &str, (): &()) -> Result<()> {
        Ok(())
    }

    fn feed_value(&self, key: &str, to: &mut Hasher) {
        to.count(key, self.0.len() as u64);
        for (name, value) in &self.0 {
            to.text("key", name).number("value", *value);
        }
    }

    fn kind((): &()) -> Kind {
        Kind::Named(Box::new(Kind::Number { low: -1e9, high: 1e9, whole: false }))
    }
}

/// How many of what there are in a list.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Several<L> {
    /// The least number.
    pub least: usize,
    /// The greatest.
    pub most: usize,
    /// Limits of each.
    pub of: L,
}

/// Up to so many tables or words.
#[must_use]
pub fn up_to(most: usize) -> Several<()> {
    Several { least: 0, most, of: () }
}

impl<T: FieldValue> FieldValue for Vec<T> {
    type Limits = Several<T::Limits>;

    fn of_value(value: &Value, path: &str, limits: &Self::Limits) -> Result<Self> {
        let values = list(value, path)?;
        if !(limits.least..=limits.most).contains(&values.len()) {
            let Several { least, most, .. } = limits;
            let many = values.len();
            return Err(Error::input(if many > *most {
                format!("{path}: {many} are over the limit of {most}")
            } else {
                format!("{path}: give {least} to {most} of them")
            }));
        }
        values
            .iter()
            .enumerate()
            .map(|(i, value)| T::of_value(value, &format!("{path}[{i}]"), &limits.of))
            .collect()
    }

    fn to_value(&self, limits: &Self::Limits) -> Option<Value> {
        let written = |value: &T| value.to_value(&limits.of).unwrap_or_else(|| Value::Object(Map::new()));
        (!self.is_empty()).then(|| self.iter().map(written).collect())
    }

    fn check_value(&self, path: &str, limits: &Self::Limits) -> Result<()> {
        self.iter()
            .enumerate()
            .try_for_each(|(i, value)| value.check_value(&format!("{path}[{i}]"), &limits.of))
    }

    fn feed_value(&self, key: &str, to: &mut Hasher) {
        to.count(key, self.len() as u64);
        self.iter().for_each(|value| value.feed_value(key, to));
    }

    fn kind(limits: &Self::Limits) -> Kind {
        Kind::List { of: Box::new(T::kind(&limits.of)), least: limits.least, most: limits.most }
    }
}
