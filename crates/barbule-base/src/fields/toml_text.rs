//! TOML as values, and the lines on which its keys stand.

use serde_json::Value;
use toml::de::{DeTable, DeValue};

use crate::error::shortened;
use crate::{Error, Result};

/// A TOML text as a value.
///
/// # Errors
/// It is not TOML; the message starts with the line.
pub fn parse_toml(text: &str) -> Result<Value> {
    let table: toml::Table = toml::from_str(text).map_err(|error| {
        let message = shortened(error.message());
        Error::input(match error.span() {
            Some(span) => format!("line {} is not TOML: {message}", line(text, span.start)),
            None => format!("is not TOML: {message}"),
        })
    })?;
    serde_json::to_value(table)
        .map_err(|error| Error::input(format!("cannot be read: {}", shortened(&error.to_string()))))
}

/// The same error after the line of the key with which its message starts, where the TOML text has that key.
#[must_use]
pub fn at_line(error: Error, text: &str) -> Error {
    match line_of(text, &error.to_string()) {
        Some(line) => error.at(format!("line {line}")),
        None => error,
    }
}

/// The line, from 1, of the innermost key of a path such as `variants[7].name`; what follows the path, as in a message,
/// does not matter. None where the text has no such key.
#[must_use]
pub fn line_of(text: &str, path: &str) -> Option<usize> {
    let root = DeTable::parse(text).ok()?;
    let (mut table, mut rest, mut found) = (root.get_ref(), path, None);
    loop {
        // A message about an unknown key names its table first.
        let unknown = rest.strip_prefix(": ").unwrap_or(rest).strip_prefix("unknown key '");
        let name = unknown.unwrap_or(rest);
        let Some((key, value)) = table
            .iter()
            .filter(|(key, _)| starts_with_key(name, key.get_ref()))
            .max_by_key(|(key, _)| key.get_ref().len())
        else {
            break;
        };
        found = Some(key.span().start);
        rest = &name[key.get_ref().len()..];
        let mut value = value.get_ref();
        while let (DeValue::Array(items), Some((index, after))) =
            (value, rest.strip_prefix('[').and_then(|inner| inner.split_once(']')))
        {
            let Some(item) = index.parse().ok().and_then(|index: usize| items.get(index)) else { break };
            found = Some(item.span().start);
            (value, rest) = (item.get_ref(), after);
        }
        let DeValue::Table(inner) = value else { break };
        (table, rest) = (inner, rest.strip_prefix('.').unwrap_or(rest));
    }
    found.map(|start| line(text, start))
}

fn starts_with_key(text: &str, key: &str) -> bool {
    let goes_on = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    !key.is_empty() && text.strip_prefix(key).is_some_and(|rest| !rest.starts_with(goes_on))
}

/// The line, from 1, of a byte.
fn line(text: &str, byte: usize) -> usize {
    text.as_bytes()[..byte.min(text.len())].iter().filter(|b| **b == b'\n').count() + 1
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
