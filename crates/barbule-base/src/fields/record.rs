//! Records: structs whose fields are the keys of users' files, each defined by one line.
//!
//! From that line come reading, checking, writing, hashing, the tables of the documentation, listings, the JSON schema, and the
//! ranges that sliders and fits take. See [`record!`](crate::record), [`words!`](crate::words) and
//! [`variants!`](crate::variants).

use std::borrow::Cow;

use serde_json::{Map, Value};

use super::key::{Key, Kind};
use super::{Fields, list, number_in, path_of, refused, shown, wrong_kind};
use crate::error::{counted, did_you_mean, shortened};
use crate::identity::{Hasher, Identify};
use crate::{Error, Result};

/// A table of a file as a value: what its keys are, and how it is read, checked, written and hashed.
pub trait Record: Sized {
    /// All keys that there may be.
    fn keys() -> Vec<Key>;

    /// The keys that this table may have: fewer than all where one key chooses which others there are.
    ///
    /// # Errors
    /// The key that chooses is missing or has no known value.
    fn keys_in(_table: &Value, _place: &str) -> Result<Vec<Key>> {
        Ok(Self::keys())
    }

    /// The table as it is read: with what stands for other keys written out. As it is, where nothing stands for others.
    ///
    /// # Errors
    /// What is short for others contradicts them.
    fn prepared<'a>(table: &'a Value, _place: &str) -> Result<Cow<'a, Value>> {
        Ok(Cow::Borrowed(table))
    }

    /// Reads its keys from a table, which may have others.
    ///
    /// # Errors
    /// A value is missing, of the wrong kind or out of range; the message names the key.
    fn read_fields(fields: &Fields<'_>) -> Result<Self>;

    /// Refuses a value that a table gives and that is of the wrong kind or out of range; others may be missing.
    ///
    /// # Errors
    /// As the method says.
    fn check_given(fields: &Fields<'_>) -> Result<()>;

    /// Writes its keys into a table.
    fn write_into(&self, table: &mut Map<String, Value>);

    /// Refuses the first value out of its range; `place` is the table's path.
    ///
    /// # Errors
    /// As the method says.
    fn check(&self, place: &str) -> Result<()>;

    /// Feeds everything that decides the value.
    fn feed_fields(&self, to: &mut Hasher);

    /// Reads a table that has no keys but these.
    ///
    /// # Errors
    /// As [`Record::read_fields`]; not a table, or an unknown key.
    fn read(table: &Value, place: &str) -> Result<Self> {
        let table = Self::prepared(table, place)?;
        let keys = Self::keys_in(&table, place)?;
        let known: Vec<&str> = keys.iter().map(|key| key.name).collect();
        Self::read_fields(&Fields::new(&table, place, &known)?)
    }

    /// The table that is read as this value.
    fn table(&self) -> Value {
        let mut table = Map::new();
        self.write_into(&mut table);
        Value::Object(table)
    }
}

/// A record as something to hash.
pub struct Fed<'a, T>(pub &'a T);

impl<T: Record> Identify for Fed<'_, T> {
    fn feed(&self, to: &mut Hasher) {
        self.0.feed_fields(to);
    }
}

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

/// The one of several names that a text is.
///
/// # Errors
/// It is none of them; the nearest is offered.
pub fn one_of<T: Copy>(path: &str, name: &str, known: &[(&'static str, T)]) -> Result<T> {
    let found = known.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
    found.ok_or_else(|| unknown(path, name, &known.iter().map(|(known, _)| *known).collect::<Vec<_>>()))
}

/// The refusal of a name that is none of those known.
#[must_use]
pub fn unknown(path: &str, name: &str, known: &[&str]) -> Error {
    let name = shortened(name);
    let near = did_you_mean(&name, known.iter().copied());
    refused(path, &format!("is '{name}'{near}; known are {}", known.join(", ")))
}

/// The word under the key that chooses what else a table has.
///
/// # Errors
/// It is missing, no text or unknown; the nearest known one is offered.
pub fn chosen<'a>(table: &'a Value, place: &str, key: &str, known: &[&'static str]) -> Result<&'a str> {
    let path = path_of(place, key);
    let Some(word) = table.get(key).and_then(Value::as_str) else {
        return Err(Error::input(format!("{path} is missing; give one of {}", known.join(", "))));
    };
    if known.contains(&word) { Ok(word) } else { Err(unknown(&path, word, known)) }
}

/// Defines a struct whose fields are keys of a file, one line a key:
///
/// ```
/// use barbule_base::fields::{Record, degrees, within};
///
/// barbule_base::record! {
///     /// A lamp.
///     #[derive(Debug, Clone, PartialEq)]
///     pub struct Lamp {
///         /// Its radius, mm.
///         radius_mm: f64 = "radius_mm", within(0.1, 60);
///         /// Where it stands, rad.
///         azimuth: f64 = "azimuth_deg" | "azimuth", degrees(-360, 360), or 0.0;
///         /// Its name.
///         name: Option<String> = "name", barbule_base::fields::Text("a name");
///     }
/// }
///
/// let lamp = Lamp::read(&serde_json::json!({"radius_mm": 2, "azimuth_deg": 180}), "lamp")?;
/// assert_eq!(lamp.azimuth, std::f64::consts::PI);
/// assert_eq!(lamp.table()["azimuth_deg"], 180.0);
/// let message = Lamp::read(&serde_json::json!({"radius_mm": 99}), "lamp").unwrap_err().to_string();
/// assert_eq!(message, "lamp.radius_mm is 99, outside 0.1 to 60");
/// # Ok::<(), barbule_base::Error>(())
/// ```
///
/// A line is `field: Type = "key" | "alias", limits, or usual;` where aliases and the usual value may be left out; the comment is the
/// key's explanation. `@flat { … }` at the end holds fields whose keys stand in the same table; `@prepare function, keys;` names what
/// writes out keys that are short for others, and what lists those; `@agree function;` names a function of the value and its place
/// that refuses what does not go together.
#[macro_export]
macro_rules! record {
    ($(#[$meta:meta])* $vis:vis struct $name:ident {
        $($(#[doc = $doc:literal])* $field:ident: $kind:ty = $key:literal $(| $alias:literal)*, $limits:expr $(, or $usual:expr)?;)*
        $(@flat { $($(#[doc = $flat_doc:literal])* $flat:ident: $flat_kind:ty;)+ })?
        $(@prepare $prepare:path, $short:path;)?
        $(@agree $agree:path;)?
    }) => {
        $(#[$meta])*
        $vis struct $name {
            $($(#[doc = $doc])* pub $field: $kind,)*
            $($($(#[doc = $flat_doc])* pub $flat: $flat_kind,)+)?
        }

        impl $crate::fields::Record for $name {
            fn keys() -> Vec<$crate::fields::Key> {
                #[allow(unused_mut)]
                let mut keys = vec![$($crate::fields::Key::new::<$kind>(
                    $key,
                    &[$($alias),*],
                    concat!($($doc),*),
                    &$limits,
                    None::<$kind>$(.or_else(|| Some($usual)))?,
                )),*];
                $($(keys.extend(<$flat_kind as $crate::fields::Record>::keys());)+)?
                $(keys.splice(0..0, $short());)?
                keys
            }

            $(fn prepared<'a>(
                table: &'a $crate::fields::Value,
                place: &str,
            ) -> $crate::Result<std::borrow::Cow<'a, $crate::fields::Value>> {
                $prepare(table, place)
            })?

            fn keys_in(_table: &$crate::fields::Value, _place: &str) -> $crate::Result<Vec<$crate::fields::Key>> {
                #[allow(unused_mut)]
                let mut keys = Self::keys();
                $(
                    let flat: Vec<&str> = [$(<$flat_kind as $crate::fields::Record>::keys()),+]
                        .iter().flatten().map(|key| key.name).collect();
                    keys.retain(|key| !flat.contains(&key.name));
                    $(keys.extend(<$flat_kind as $crate::fields::Record>::keys_in(_table, _place)?);)+
                )?
                Ok(keys)
            }

            fn read_fields(fields: &$crate::fields::Fields<'_>) -> $crate::Result<Self> {
                let read = Self {
                    $($field: match fields.get($key) {
                        Some(value) =>
                            <$kind as $crate::fields::FieldValue>::of_value(value, &fields.path($key), &$limits)?,
                        None => match None::<$kind>$(.or_else(|| Some($usual)))? {
                            Some(usual) => usual,
                            None => <$kind as $crate::fields::FieldValue>::missing(&fields.path($key), &$limits)?,
                        },
                    },)*
                    $($($flat: <$flat_kind as $crate::fields::Record>::read_fields(fields)?,)+)?
                };
                $($agree(&read, fields.place())?;)?
                Ok(read)
            }

            fn check_given(fields: &$crate::fields::Fields<'_>) -> $crate::Result<()> {
                $(if let Some(value) = fields.get($key) {
                    <$kind as $crate::fields::FieldValue>::of_value(value, &fields.path($key), &$limits)?;
                })*
                $($(<$flat_kind as $crate::fields::Record>::check_given(fields)?;)+)?
                Ok(())
            }

            fn write_into(&self, table: &mut $crate::fields::Map<String, $crate::fields::Value>) {
                $(if let Some(value) = $crate::fields::FieldValue::to_value(&self.$field, &$limits) {
                    table.insert($key.to_owned(), value);
                })*
                $($($crate::fields::Record::write_into(&self.$flat, table);)+)?
            }

            fn check(&self, place: &str) -> $crate::Result<()> {
                $($crate::fields::FieldValue::check_value(
                    &self.$field, &$crate::fields::path_of(place, $key), &$limits)?;)*
                $($($crate::fields::Record::check(&self.$flat, place)?;)+)?
                $($agree(self, place)?;)?
                Ok(())
            }

            fn feed_fields(&self, to: &mut $crate::identity::Hasher) {
                $($crate::fields::FieldValue::feed_value(&self.$field, $key, to);)*
                $($($crate::fields::Record::feed_fields(&self.$flat, to);)+)?
            }
        }
    };
}

/// Defines an enum of which each variant is a word in files:
///
/// ```
/// barbule_base::words! {
///     /// Which way.
///     #[derive(Debug, Clone, Copy, PartialEq, Eq)]
///     pub enum Way {
///         /// Up.
///         "up": Up,
///         /// Down.
///         "down": Down,
///     }
/// }
///
/// assert_eq!(Way::named("way", "up")?, Way::Up);
/// assert!(Way::named("way", "donw").unwrap_err().to_string().contains("did you mean 'down'"));
/// # Ok::<(), barbule_base::Error>(())
/// ```
#[macro_export]
macro_rules! words {
    ($(#[$meta:meta])* $vis:vis enum $name:ident { $($(#[$about:meta])* $word:literal: $variant:ident,)+ }) => {
        $(#[$meta])*
        $vis enum $name { $($(#[$about])* $variant,)+ }

        impl $name {
            /// All with their words.
            $vis const ALL: &[(&'static str, Self)] = &[$(($word, Self::$variant)),+];

            /// Its word.
            #[must_use]
            $vis fn word(self) -> &'static str {
                match self { $(Self::$variant => $word,)+ }
            }

            /// By its word; `path` names the key in messages.
            ///
            /// # Errors
            /// There is none of this name; the nearest is offered.
            $vis fn named(path: &str, word: &str) -> $crate::Result<Self> {
                $crate::fields::one_of(path, word, Self::ALL)
            }
        }

        impl $crate::fields::FieldValue for $name {
            type Limits = ();

            fn of_value(value: &$crate::fields::Value, path: &str, (): &()) -> $crate::Result<Self> {
                let word = value.as_str().ok_or_else(|| {
                    $crate::fields::wrong_kind(value, path, "a text in quotes")
                })?;
                Self::named(path, word)
            }

            fn to_value(&self, (): &()) -> Option<$crate::fields::Value> {
                Some(self.word().into())
            }

            fn check_value(&self, _: &str, (): &()) -> $crate::Result<()> {
                Ok(())
            }

            fn feed_value(&self, key: &str, to: &mut $crate::identity::Hasher) {
                to.text(key, self.word());
            }

            fn kind((): &()) -> $crate::fields::Kind {
                $crate::fields::Kind::Word(vec![$($word),+])
            }
        }
    };
}

/// Defines an enum of records of which a key, `type` as a rule, chooses one.
#[macro_export]
macro_rules! variants {
    ($(#[$meta:meta])* $vis:vis enum $name:ident by $key:literal {
        $($(#[doc = $about:literal])* $word:literal: $variant:ident($kind:ty),)+
    }) => {
        $(#[$meta])*
        $vis enum $name { $($(#[doc = $about])* $variant($kind),)+ }

        impl $name {
            /// The words that choose.
            $vis const WORDS: &[&'static str] = &[$($word),+];

            /// Its word.
            #[must_use]
            $vis fn word(&self) -> &'static str {
                match self { $(Self::$variant(_) => $word,)+ }
            }
        }

        impl $crate::fields::Record for $name {
            fn keys() -> Vec<$crate::fields::Key> {
                vec![$crate::fields::Key::choice($key, vec![$($crate::fields::Choice {
                    word: $word,
                    about: concat!($($about),*).trim(),
                    keys: <$kind as $crate::fields::Record>::keys(),
                }),+])]
            }

            fn keys_in(table: &$crate::fields::Value, place: &str) -> $crate::Result<Vec<$crate::fields::Key>> {
                let mut keys = Self::keys();
                match $crate::fields::chosen(table, place, $key, Self::WORDS)? {
                    $($word => keys.extend(<$kind as $crate::fields::Record>::keys_in(table, place)?),)+
                    _ => {}
                }
                Ok(keys)
            }

            fn read_fields(fields: &$crate::fields::Fields<'_>) -> $crate::Result<Self> {
                match $crate::fields::chosen(fields.table(), fields.place(), $key, Self::WORDS)? {
                    $($word => Ok(Self::$variant(<$kind as $crate::fields::Record>::read_fields(fields)?)),)+
                    other => Err($crate::fields::unknown(&fields.path($key), other, Self::WORDS)),
                }
            }

            fn check_given(fields: &$crate::fields::Fields<'_>) -> $crate::Result<()> {
                match $crate::fields::chosen(fields.table(), fields.place(), $key, Self::WORDS)? {
                    $($word => <$kind as $crate::fields::Record>::check_given(fields),)+
                    _ => Ok(()),
                }
            }

            fn write_into(&self, table: &mut $crate::fields::Map<String, $crate::fields::Value>) {
                table.insert($key.to_owned(), self.word().into());
                match self { $(Self::$variant(record) => $crate::fields::Record::write_into(record, table),)+ }
            }

            fn check(&self, place: &str) -> $crate::Result<()> {
                match self { $(Self::$variant(record) => $crate::fields::Record::check(record, place),)+ }
            }

            fn feed_fields(&self, to: &mut $crate::identity::Hasher) {
                to.text($key, self.word());
                match self { $(Self::$variant(record) => $crate::fields::Record::feed_fields(record, to),)+ }
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use serde_json::json;

    use super::*;
    use crate::identity::Hasher;

    crate::words! {
        /// A colour.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        enum Hue {
            /// Red.
            "red": Red,
            /// Green.
            "green": Green,
        }
    }

    crate::record! {
        /// Where.
        #[derive(Debug, Clone, Copy, PartialEq)]
        struct Spot {
            /// The place, mm.
            at_mm: [f64; 3] = "at_mm", within(-10, 10), or [0.0; 3];
        }
    }

    crate::record! {
        /// All kinds of keys.
        #[derive(Debug, Clone, PartialEq)]
        struct Thing {
            /// Thickness, µm.
            thickness_um: f64 = "thickness_um", within(0.001, 10);
            /// How often.
            count: usize = "count", within(1, 9), or 3;
            /// Turn, rad.
            turn: f64 = "turn_deg" | "turn", degrees(-360, 360), or 0.0;
            /// Hue.
            hue: Hue = "hue", (), or Hue::Red;
            /// Whether.
            on: Option<bool> = "on", ();
            /// Names.
            names: Vec<String> = "names", Several { least: 0, most: 2, of: Text("a name") }, or Vec::new();
            @flat {
                /// Where it is.
                spot: Spot;
            }
            @agree Thing::agree;
        }
    }

    impl Thing {
        fn agree(&self, place: &str) -> Result<()> {
            if self.count == 7 { Err(Error::input(format!("{place}: seven is unlucky"))) } else { Ok(()) }
        }
    }

    crate::variants! {
        /// One or the other.
        #[derive(Debug, Clone, PartialEq)]
        enum Either by "type" {
            /// A spot.
            "spot": Spot(Spot),
            /// A thing.
            "thing": Thing(Thing),
        }
    }

    fn refusal(table: Value) -> String {
        Thing::read(&table, "thing").unwrap_err().to_string()
    }

    #[test]
    fn what_is_left_out_is_usual_and_what_is_written_is_read_again() {
        let bare = Thing::read(&json!({"thickness_um": 0.5}), "thing").unwrap();
        assert_eq!(
            (bare.count, bare.turn, bare.hue, bare.on, bare.spot.at_mm),
            (3, 0.0, Hue::Red, None, [0.0; 3])
        );
        let given = json!({"thickness_um": 0.5, "count": 4, "turn_deg": 90, "hue": "green", "on": false,
                           "names": ["a", "b"], "at_mm": [1, 2, 3]});
        let thing = Thing::read(&given, "thing").unwrap();
        assert_eq!((thing.turn, thing.hue, thing.spot.at_mm), (0.5 * PI, Hue::Green, [1.0, 2.0, 3.0]));
        assert_eq!(Thing::read(&thing.table(), "thing").unwrap(), thing);
        // Degrees are written as round as they were.
        let tilted = Thing { turn: 27.3_f64.to_radians(), ..thing };
        assert_eq!(tilted.table()["turn_deg"], 27.3);
    }

    #[test]
    fn what_is_wrong_is_refused_by_its_key() {
        assert_eq!(refusal(json!({})), "thing.thickness_um is missing; give a number from 0.001 to 10");
        assert_eq!(
            refusal(json!({"thickness_um": 500})),
            "thing.thickness_um is 500, outside 0.001 to 10; did you mean 0.5 (500 nm)?"
        );
        let with = |key: &str, value: Value| {
            let mut table = json!({"thickness_um": 1});
            table[key] = value;
            refusal(table)
        };
        assert_eq!(with("count", json!(2.5)), "thing.count is 2.5, but must be a whole number");
        assert_eq!(with("turn_deg", json!(400)), "thing.turn_deg is 400, outside -360 to 360");
        assert!(with("hue", json!("gren")).contains("did you mean 'green'"));
        assert!(with("on", json!(1)).contains("thing.on is the number 1, but must be true or false"));
        assert!(with("names", json!(["a", "b", "c"])).contains("3 are over the limit of 2"));
        assert!(
            with("at_mm", json!([1, 2]))
                .contains("thing.at_mm has 2 numbers; give three numbers from -10 to 10")
        );
        assert!(with("at_mm", json!([1, 2, 30])).contains("thing.at_mm[2] is 30"));
        assert!(with("coutn", json!(1)).contains("did you mean 'count'"));
        assert_eq!(with("count", json!(7)), "thing: seven is unlucky");
        let thing = Thing { count: 12, ..Thing::read(&json!({"thickness_um": 1}), "").unwrap() };
        assert_eq!(thing.check("a").unwrap_err().to_string(), "a.count is 12, outside 1 to 9");
    }

    #[test]
    fn a_word_chooses_which_keys_there_are() {
        let read = |table: Value| Either::read(&table, "it");
        let spot = read(json!({"type": "spot", "at_mm": [0, 0, 1]})).unwrap();
        assert_eq!((spot.word(), read(spot.table()).unwrap()), ("spot", spot.clone()));
        let message = |table| read(table).unwrap_err().to_string();
        assert_eq!(message(json!({"at_mm": [0, 0, 1]})), "it.type is missing; give one of spot, thing");
        assert!(message(json!({"type": "spto"})).contains("did you mean 'spot'"));
        assert!(message(json!({"type": "spot", "count": 3})).contains("it: unknown key 'count'"));
    }

    #[test]
    fn everything_that_decides_is_hashed() {
        let hash = |thing: &Thing| {
            let mut hasher = Hasher::new("thing");
            thing.feed_fields(&mut hasher);
            hasher.hex()
        };
        let thing = Thing::read(&json!({"thickness_um": 0.5}), "thing").unwrap();
        let others = [
            Thing { count: 4, ..thing.clone() },
            Thing { hue: Hue::Green, ..thing.clone() },
            Thing { on: Some(false), ..thing.clone() },
            Thing { names: vec![String::new()], ..thing.clone() },
            Thing { spot: Spot { at_mm: [0.0, 0.0, 1.0] }, ..thing.clone() },
        ];
        let mut all: Vec<String> = others.iter().chain([&thing]).map(hash).collect();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 6);
    }
}
