//! Keys as people, editors and fits see them: what they are, which values they may have, what a missing one means.

use serde_json::{Map, Value, json};

use super::value::FieldValue;
use super::{path_of, shown};
use crate::error::{counted, did_you_mean};
use crate::{Error, Result};

/// A key of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// Other names under which it is read.
    pub aliases: &'static [&'static str],
    /// What it is, in a sentence.
    pub about: &'static str,
    /// Which values there are.
    pub kind: Kind,
    /// What a missing one means.
    pub usual: Usual,
}

/// What a missing key means.
#[derive(Debug, Clone, PartialEq)]
pub enum Usual {
    /// It is needed.
    Needed,
    /// There is no such thing.
    Nothing,
    /// This value.
    Value(Value),
}

/// Which values a key may have.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// A number in a range; the end of the key's name is its unit.
    Number {
        /// The least.
        low: f64,
        /// The greatest.
        high: f64,
        /// Whether it must be whole.
        whole: bool,
    },
    /// True or false.
    Switch,
    /// One of these words.
    Word(Vec<&'static str>),
    /// A text, and what it is: `the name of a file`.
    Text(&'static str),
    /// `"#rrggbb"` or three numbers from 0 to 1.
    Colour,
    /// So many values.
    List {
        /// What each is.
        of: Box<Self>,
        /// How many at least.
        least: usize,
        /// How many at most.
        most: usize,
    },
    /// A table.
    Table(Vec<Key>),
    /// A word that chooses which further keys its table has.
    Choice(Vec<Choice>),
    /// One of these kinds.
    Either(Vec<Self>),
    /// A table of tables, each under a name of the user's.
    Named(Box<Self>),
}

/// A word that chooses, and the keys that it brings.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// The word.
    pub word: &'static str,
    /// What it is.
    pub about: &'static str,
    /// The keys.
    pub keys: Vec<Key>,
}

impl Usual {
    /// The value, where there is one.
    #[must_use]
    pub fn value(&self) -> Option<&Value> {
        match self {
            Self::Value(value) => Some(value),
            Self::Needed | Self::Nothing => None,
        }
    }
}

impl Key {
    /// A key of values of a type.
    #[must_use]
    pub fn new<T: FieldValue>(
        name: &'static str,
        aliases: &'static [&'static str],
        about: &'static str,
        limits: &T::Limits,
        usual: Option<T>,
    ) -> Self {
        let usual = match usual.map(|value| value.to_value(limits)) {
            Some(Some(value)) => Usual::Value(value),
            Some(None) => Usual::Nothing,
            None if T::OPTIONAL => Usual::Nothing,
            None => Usual::Needed,
        };
        Self { name, aliases, about: plain(about), kind: T::kind(limits), usual }
    }

    /// A key whose word chooses further keys.
    #[must_use]
    pub fn choice(name: &'static str, choices: Vec<Choice>) -> Self {
        let about = "Which kind it is; it decides which other keys there are";
        Self { name, aliases: &[], about, kind: Kind::Choice(choices), usual: Usual::Needed }
    }

    /// The unit that the end of its name says.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        match self.name.rsplit_once('_').map(|(_, end)| end) {
            Some("um") => "µm",
            Some("mm") => "mm",
            Some("nm") => "nm",
            Some("deg") => "°",
            Some("cm2") => "1/cm²",
            _ => "",
        }
    }

    /// What it may be, as in `0.001 to 10 µm`.
    #[must_use]
    pub fn allowed(&self) -> String {
        let unit = match self.unit() {
            "°" => "°".to_owned(),
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        self.kind.allowed(&unit)
    }

    /// What a missing one means, in few words; empty where it is needed.
    #[must_use]
    pub fn otherwise(&self) -> String {
        match &self.usual {
            Usual::Needed => String::new(),
            Usual::Nothing => "–".to_owned(),
            Usual::Value(Value::Number(number)) => shown(number.as_f64().unwrap_or_default()),
            Usual::Value(Value::String(text)) => text.clone(),
            Usual::Value(value) => value.to_string(),
        }
    }
}

impl Kind {
    /// What it may be, as in `0.001 to 10 µm`.
    fn allowed(&self, unit: &str) -> String {
        match self {
            Self::Number { low, high, .. } => format!("{} to {}{unit}", shown(*low), shown(*high)),
            Self::Switch => "true or false".to_owned(),
            Self::Word(words) => words.join(", "),
            Self::Choice(choices) => choices.iter().map(|choice| choice.word).collect::<Vec<_>>().join(", "),
            Self::Text(what) => (*what).to_owned(),
            Self::Colour => "\"#rrggbb\", or three numbers from 0 to 1".to_owned(),
            Self::List { of, least, most } if least == most => format!("{least} of: {}", of.allowed(unit)),
            Self::List { of, least, most } => match **of {
                Self::Table(_) => format!("{least} to {most} tables"),
                _ => format!("{least} to {most} of: {}", of.allowed(unit)),
            },
            Self::Table(_) => "a table".to_owned(),
            Self::Either(kinds) => {
                kinds.iter().map(|kind| kind.allowed(unit)).collect::<Vec<_>>().join("; or ")
            }
            Self::Named(_) => "tables with names of your own".to_owned(),
        }
    }

    /// What to give, as in `a number from 1 to 2`.
    #[must_use]
    pub fn wanted(&self) -> String {
        match self {
            Self::Number { low, high, whole } => {
                format!("a {}number from {low} to {high}", if *whole { "whole " } else { "" })
            }
            Self::Word(words) => format!("one of {}", words.join(", ")),
            Self::Choice(_) => format!("one of {}", self.allowed("")),
            Self::Text(what) => (*what).to_owned(),
            Self::List { of, least, most } if least == most => match **of {
                Self::Number { low, high, .. } => {
                    let count = ["no", "one", "two", "three", "four"].get(*least).copied();
                    let count = count.map_or_else(|| least.to_string(), str::to_owned);
                    format!("{count} numbers from {low} to {high}")
                }
                _ => counted(*least, "value"),
            },
            Self::List { .. } => "a list".to_owned(),
            Self::Either(kinds) => kinds.iter().map(Self::wanted).collect::<Vec<_>>().join(", or "),
            Self::Switch | Self::Colour | Self::Table(_) | Self::Named(_) => self.allowed(""),
        }
    }

    /// As a JSON schema (draft 2020-12).
    #[must_use]
    pub fn schema(&self) -> Value {
        match self {
            Self::Number { low, high, whole } => {
                let kind = if *whole { "integer" } else { "number" };
                json!({"type": kind, "minimum": low, "maximum": high})
            }
            Self::Switch => json!({"type": "boolean"}),
            Self::Word(words) => json!({"enum": words}),
            Self::Choice(choices) => {
                json!({"enum": choices.iter().map(|choice| choice.word).collect::<Vec<_>>()})
            }
            Self::Text(what) => json!({"type": "string", "description": what}),
            Self::Colour => json!({"anyOf": [
                {"type": "string", "pattern": "^#[0-9a-fA-F]{6}$"},
                {"type": "array", "items": {"type": "number", "minimum": 0, "maximum": 1}, "minItems": 3, "maxItems": 3},
            ]}),
            Self::List { of, least, most } => {
                json!({"type": "array", "items": of.schema(), "minItems": least, "maxItems": most})
            }
            Self::Table(keys) => schema(keys),
            Self::Either(kinds) => json!({"anyOf": kinds.iter().map(Self::schema).collect::<Vec<_>>()}),
            Self::Named(of) => json!({"type": "object", "additionalProperties": of.schema()}),
        }
    }
}

/// An explanation without the unit at its end: a file's is in the key's name, and may be degrees where memory has radians.
fn plain(about: &'static str) -> &'static str {
    let about = about.trim();
    [", rad.", ", mm.", ", µm."].iter().find_map(|unit| about.strip_suffix(unit)).unwrap_or(about)
}

/// A table of these keys as a JSON schema; with a key that chooses, one schema for each choice.
#[must_use]
pub fn schema(keys: &[Key]) -> Value {
    let chooser = keys.iter().find_map(|key| match &key.kind {
        Kind::Choice(choices) => Some((key.name, choices)),
        _ => None,
    });
    let Some((name, choices)) = chooser else { return object(keys, &[]) };
    let others: Vec<Key> = keys.iter().filter(|key| key.name != name).cloned().collect();
    let one = |choice: &Choice| {
        let all: Vec<Key> = others.iter().chain(&choice.keys).cloned().collect();
        let mut schema = object(&all, &[name]);
        schema["properties"][name] = json!({"const": choice.word, "description": choice.about});
        schema
    };
    json!({"anyOf": choices.iter().map(one).collect::<Vec<_>>()})
}

fn object(keys: &[Key], also_needed: &[&str]) -> Value {
    let mut properties = Map::new();
    for key in keys {
        let mut schema = key.kind.schema();
        let unit = if key.unit().is_empty() { String::new() } else { format!(" [{}]", key.unit()) };
        schema["description"] = format!("{}{unit}", key.about).into();
        if let Usual::Value(usual) = &key.usual {
            schema["default"] = usual.clone();
        }
        for name in key.aliases.iter().chain([&key.name]) {
            properties.insert((*name).to_owned(), schema.clone());
        }
    }
    let needed =
        keys.iter().filter(|key| key.usual == Usual::Needed && key.aliases.is_empty()).map(|key| key.name);
    let needed: Vec<&str> = needed.chain(also_needed.iter().copied()).collect();
    json!({"type": "object", "properties": properties, "required": needed, "additionalProperties": false})
}

/// A table as its keys' own names have it: aliases are replaced at every depth.
///
/// # Errors
/// A key is given under two names.
pub fn canonical(value: Value, keys: &[Key], place: &str) -> Result<Value> {
    let Value::Object(table) = value else { return Ok(value) };
    let mut named = Map::new();
    for (given, value) in table {
        let key = keys.iter().find(|key| key.name == given || key.aliases.contains(&given.as_str()));
        let (name, value) = match key {
            None => (given.clone(), value),
            Some(key) => match (&key.kind, value) {
                (Kind::Table(inner), value) => {
                    (key.name.to_owned(), canonical(value, inner, &path_of(place, key.name))?)
                }
                (_, value) => (key.name.to_owned(), value),
            },
        };
        if named.insert(name.clone(), value).is_some() {
            let other = key.and_then(|key| key.aliases.first()).copied().unwrap_or(&given);
            return Err(Error::input(format!(
                "{} and {} are both given; leave one out",
                path_of(place, &name),
                path_of(place, other)
            )));
        }
    }
    Ok(Value::Object(named))
}

/// The keys of a table inside a table, by a path as in `camera` or `feather.distal`; lists and named tables are looked into.
///
/// # Errors
/// There is no such table; the nearest is offered.
pub fn table_at(keys: Vec<Key>, path: &str) -> Result<Vec<Key>> {
    let mut keys = keys;
    for name in path.split('.').filter(|name| !name.is_empty()) {
        let found = keys.iter().find(|key| key.name == name).and_then(|key| inner(&key.kind));
        keys = found.ok_or_else(|| {
            let tables = keys.iter().filter(|key| inner(&key.kind).is_some()).map(|key| key.name);
            let near = did_you_mean(name, tables.clone());
            Error::input(format!(
                "there is no table '{name}'{near}; known are {}",
                tables.collect::<Vec<_>>().join(", ")
            ))
        })?;
    }
    Ok(keys)
}

/// The keys of the tables that values of a kind are.
#[must_use]
pub fn inner(kind: &Kind) -> Option<Vec<Key>> {
    match kind {
        Kind::Table(keys) => Some(keys.clone()),
        Kind::List { of, .. } | Kind::Named(of) => inner(of),
        Kind::Either(kinds) => kinds.iter().find_map(inner),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fields::{Record, within};

    crate::record! {
        /// A turn.
        #[derive(Debug, Clone, PartialEq)]
        struct Turn {
            /// How far.
            turn_deg: f64 = "turn_deg" | "turn", within(-360, 360), or 0.0;
            /// How thick it is.
            thickness_um: f64 = "thickness_um", within(0.001, 10);
        }
    }

    crate::record! {
        /// With a table.
        #[derive(Debug, Clone, PartialEq)]
        struct Outer {
            /// A table.
            turn: Turn = "turn", ();
        }
    }

    #[test]
    fn keys_say_what_they_are() {
        let keys = Turn::keys();
        assert_eq!((keys[0].unit(), keys[0].otherwise()), ("°", "0".to_owned()));
        assert_eq!((keys[1].allowed(), keys[1].otherwise()), ("0.001 to 10 µm".to_owned(), String::new()));
        let schema = schema(&Outer::keys());
        let turn = &schema["properties"]["turn"];
        assert_eq!(turn["properties"]["turn_deg"]["maximum"], 360.0);
        assert_eq!((&turn["required"], &schema["required"]), (&json!(["thickness_um"]), &json!(["turn"])));
        assert_eq!(table_at(Outer::keys(), "turn").unwrap(), keys);
        assert!(table_at(Outer::keys(), "tunr").unwrap_err().to_string().contains("did you mean 'turn'"));
    }

    #[test]
    fn aliases_become_the_keys_own_names() {
        let read = |value: Value| canonical(value, &Outer::keys(), "");
        let named = read(json!({"turn": {"turn": 3, "else": 1}})).unwrap();
        assert_eq!(named, json!({"turn": {"turn_deg": 3, "else": 1}}));
        let both = read(json!({"turn": {"turn": 3, "turn_deg": 4}})).unwrap_err().to_string();
        assert_eq!(both, "turn.turn_deg and turn.turn are both given; leave one out");
    }
}
