//! TOML as values, and the places of its keys.

use std::ops::Range;

use serde_json::Value;
use toml::de::{DeTable, DeValue};

use super::spot::{Spot, Tree, line_and_column};
use crate::error::shortened;
use crate::{Error, Result};

/// A TOML text as a value.
///
/// # Errors
/// It is not TOML; the message starts with the line.
pub fn parse_toml(text: &str) -> Result<Value> {
    let table: toml::Table = toml::from_str(text).map_err(|error| {
        let message = shortened(error.message());
        let refusal = match &error.span() {
            Some(span) => format!("line {} is not TOML: {message}", line_and_column(text, span.start).0),
            None => format!("is not TOML: {message}"),
        };
        at_span(Error::input(refusal), text, error.span())
    })?;
    serde_json::to_value(table)
        .map_err(|error| Error::input(format!("cannot be read: {}", shortened(&error.to_string()))))
}

/// The same error after the line of the key with which its message starts, where the TOML text has that key.
#[must_use]
pub fn at_line(error: Error, text: &str) -> Error {
    let path = error.to_string();
    at_key(error, text, &path)
}

/// The same error after the line of the key with which `path` starts, where the TOML text has that key.
#[must_use]
pub fn at_key(error: Error, text: &str, path: &str) -> Error {
    match spot(text, path) {
        Some(spot) => {
            let line = spot.line;
            spot.mark(error).at(format!("line {line}"))
        }
        None => error,
    }
}

/// The same error, which knows line and column of the key with which its message starts, where the TOML text has that key.
#[must_use]
pub fn in_toml(error: Error, text: &str) -> Error {
    match spot(text, &error.to_string()) {
        Some(spot) => spot.mark(error),
        None => error,
    }
}

/// The same error, which knows line and column where a part of a TOML text begins, as its reader's errors name it, and the
/// key that stands there or has its value there.
#[must_use]
pub fn at_span(error: Error, text: &str, span: Option<Range<usize>>) -> Error {
    let Some(Range { start: byte, .. }) = span else { return error };
    let (line, column) = line_and_column(text, byte);
    let root = DeTable::parse(text).map(|root| DeValue::Table(root.into_inner()));
    let key = root.ok().and_then(|root| key_around(&root, byte));
    let error = if let Some(key) = key { error.about(key) } else { error };
    error.on_line(line, Some(column))
}

/// The line, from 1, of the innermost key of a path such as `variants[7].name`; what follows the path, as in a message,
/// does not matter. None where the text has no such key.
#[must_use]
pub fn line_of(text: &str, path: &str) -> Option<usize> {
    spot(text, path).map(|spot| spot.line)
}

fn spot(text: &str, path: &str) -> Option<Spot> {
    let root = DeValue::Table(DeTable::parse(text).ok()?.into_inner());
    Spot::find(&root, text, path)
}

impl<'t> Tree<'t> for &'t DeValue<'t> {
    fn keys(self) -> Box<dyn Iterator<Item = (&'t str, usize, Self)> + 't> {
        let table = self.as_table().into_iter().flatten();
        Box::new(table.map(|(key, value)| (key.get_ref().as_ref(), key.span().start, value.get_ref())))
    }

    fn item(self, index: usize) -> Option<(usize, Self)> {
        self.as_array()?.get(index).map(|item| (item.span().start, item.get_ref()))
    }
}

/// The path of the innermost key that stands around a byte, or whose value does.
fn key_around(value: &DeValue<'_>, byte: usize) -> Option<String> {
    let inner = |value: &DeValue<'_>, here: String, is_around: bool| match key_around(value, byte) {
        Some(inner) if inner.starts_with('[') => Some(here + &inner),
        Some(inner) => Some(format!("{here}.{inner}")),
        None => is_around.then_some(here),
    };
    match value {
        DeValue::Table(table) => table.iter().find_map(|(key, value)| {
            let is_around = key.span().contains(&byte) || value.span().contains(&byte);
            inner(value.get_ref(), key.get_ref().to_string(), is_around)
        }),
        DeValue::Array(items) => items.iter().enumerate().find_map(|(index, item)| {
            inner(item.get_ref(), format!("[{index}]"), item.span().contains(&byte))
        }),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str =
        "a = 1\n[b]\nc_um = 2\nc = { d = 4, list = [\n 5,\n 6 ] }\n[[e]]\nf = 7\n[[e]]\nf = 8\n";

    #[test]
    fn keys_are_found_on_their_lines() {
        for (path, line) in [
            ("a is 1", Some(1)),
            ("b: unknown key 'c', did you mean", Some(4)),
            ("b.c_um is 2, outside", Some(3)),
            ("b.c_nm is missing", Some(2)),
            ("b.c.list[1] is 6", Some(6)),
            ("e[1].f is 8", Some(10)),
            ("e[1].name is missing", Some(9)),
            ("e[9] is none", Some(7)),
            ("unknown key 'b'", Some(2)),
            ("nothing of the kind", None),
        ] {
            assert_eq!(line_of(TEXT, path), line, "{path}");
        }
        assert_eq!(at_line(Error::input("b.c_um is 2"), TEXT).to_string(), "line 3: b.c_um is 2");
    }

    #[test]
    fn errors_know_their_key_and_the_places_of_bytes_have_keys() {
        let place = |error: &Error| (error.key().map(str::to_owned), error.line(), error.column());
        let known = |key: &str, line, column| (Some(key.to_owned()), Some(line), Some(column));
        let error = in_toml(Error::input("b.c.list[1] is 6"), TEXT);
        assert_eq!(
            (error.to_string().as_str(), place(&error)),
            ("b.c.list[1] is 6", known("b.c.list[1]", 6, 2))
        );
        let missing = at_line(Error::input("e[1].name is missing").about("e[1].name"), TEXT);
        assert_eq!(place(&missing), known("e[1].name", 9, 1));
        let merged = at_key(Error::input("a.f is 8").about("a.f"), TEXT, "e[1].f");
        assert_eq!(
            (merged.to_string().as_str(), place(&merged)),
            ("line 10: a.f is 8", known("e[1].f", 10, 1))
        );
        for (at, key) in [
            ("a = 1", "a"),
            ("4, list", "b.c.d"),
            ("list =", "b.c.list"),
            ("6 ]", "b.c.list[1]"),
            ("8", "e[1].f"),
        ] {
            let byte = TEXT.find(at).unwrap();
            assert_eq!(at_span(Error::input("x"), TEXT, Some(byte..byte)).key(), Some(key), "{at}");
        }
        assert_eq!(place(&at_span(Error::input("x"), "a = ", Some(4..4))), (None, Some(1), Some(5)));
    }

    #[test]
    fn what_is_not_toml_is_said_with_its_line() {
        for (text, expected) in
            [("a = 1\nb = = 2", "line 2 is not TOML"), ("a = 1\na = 2", "line 2 is not TOML")]
        {
            let message = parse_toml(text).unwrap_err().to_string();
            assert!(message.starts_with(expected), "{message}");
        }
        assert_eq!(parse_toml("a = 1").unwrap()["a"], 1);
    }
}
