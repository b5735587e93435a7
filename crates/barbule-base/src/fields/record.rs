//! Records: structs whose fields are the keys of users' files, each defined by one line.
//!
//! From that line come reading, checking, writing, hashing, the tables of the documentation, listings, the JSON schema, and the
//! ranges that sliders and fits take. See [`record!`](crate::record), [`words!`](crate::words) and
//! [`variants!`](crate::variants).

use std::borrow::Cow;

use serde_json::{Map, Value};

use super::key::Key;
use super::{Fields, path_of, refused};
use crate::error::{did_you_mean, shortened};
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
mod tests;
