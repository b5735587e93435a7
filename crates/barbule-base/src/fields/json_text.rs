//! JSON as values, and the places of its keys.

use std::fmt;

use serde::de::{Deserialize, Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

use super::spot::{Spot, Tree};
use crate::error::shortened;
use crate::{Error, Result};

/// A JSON text as a value.
///
/// # Errors
/// It is not JSON, or a table has a key twice; the message ends with line and column.
pub fn parse_json(text: &str) -> Result<Value> {
    let Unique(value) = serde_json::from_str(text).map_err(|error| {
        let said = shortened(&error.to_string());
        // What is not as it should be in JSON that is well formed is a key that stands twice.
        let message = if error.is_data() { said } else { format!("is not JSON: {said}") };
        Error::input(message).on_line(error.line(), Some(error.column()))
    })?;
    Ok(value)
}

/// A value whose tables have each key once: of two with one name `Value` silently takes the last.
struct Unique(Value);

impl<'de> Deserialize<'de> for Unique {
    fn deserialize<D: Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error> {
        from.deserialize_any(AnyValue).map(Self)
    }
}

struct AnyValue;

impl<'de> Visitor<'de> for AnyValue {
    type Value = Value;

    fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str("a value")
    }

    fn visit_unit<E>(self) -> std::result::Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, value: bool) -> std::result::Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E>(self, value: i64) -> std::result::Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E>(self, value: u64) -> std::result::Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E>(self, value: f64) -> std::result::Result<Value, E> {
        Ok(value.into())
    }

    fn visit_str<E>(self, value: &str) -> std::result::Result<Value, E> {
        Ok(value.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> std::result::Result<Value, A::Error> {
        let mut all = Vec::new();
        while let Some(Unique(item)) = items.next_element()? {
            all.push(item);
        }
        Ok(all.into())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> std::result::Result<Value, A::Error> {
        let mut all = Map::new();
        while let Some(key) = entries.next_key::<String>()? {
            if all.contains_key(&key) {
                return Err(A::Error::custom(format!("the key '{key}' stands twice; leave one out")));
            }
            let Unique(value) = entries.next_value()?;
            all.insert(key, value);
        }
        Ok(all.into())
    }
}

/// The same error, which knows line and column of the key with which its message starts, where the JSON text has that key.
#[must_use]
pub fn in_json(error: Error, text: &str) -> Error {
    let root = Json { text, at: after_blanks(text.as_bytes(), 0) };
    match Spot::find(root, text, &error.to_string()) {
        Some(spot) => spot.mark(error),
        None => error,
    }
}

/// A value in a text that is JSON.
#[derive(Clone, Copy)]
struct Json<'t> {
    text: &'t str,
    /// Its first byte.
    at: usize,
}

impl<'t> Json<'t> {
    /// What a table or list holds: the byte where each part begins, in a table its name, and its value.
    fn parts(self) -> impl Iterator<Item = (usize, &'t str, Self)> + 't {
        let Self { text, at: mut before } = self;
        let bytes = text.as_bytes();
        let is_table = bytes.get(before) == Some(&b'{');
        let mut goes_on = is_table || bytes.get(before) == Some(&b'[');
        std::iter::from_fn(move || {
            let start = after_blanks(bytes, before + 1);
            if !goes_on || matches!(bytes.get(start)?, b'}' | b']') {
                return None;
            }
            let (name, at) = if is_table {
                let end = after_string(bytes, start);
                let colon = after_blanks(bytes, end);
                (text.get(start + 1..end - 1)?, after_blanks(bytes, colon + 1))
            } else {
                ("", start)
            };
            before = after_blanks(bytes, after_value(bytes, at));
            goes_on = bytes.get(before) == Some(&b',');
            Some((start, name, Self { text, at }))
        })
    }
}

impl<'t> Tree<'t> for Json<'t> {
    fn keys(self) -> Box<dyn Iterator<Item = (&'t str, usize, Self)> + 't> {
        Box::new(
            self.parts().filter(|(_, name, _)| !name.is_empty()).map(|(at, name, value)| (name, at, value)),
        )
    }

    fn item(self, index: usize) -> Option<(usize, Self)> {
        let is_list = self.text.as_bytes().get(self.at) == Some(&b'[');
        is_list.then(|| self.parts().nth(index)).flatten().map(|(at, _, value)| (at, value))
    }
}

/// The first byte from `at` on that is no blank.
fn after_blanks(bytes: &[u8], at: usize) -> usize {
    at + bytes.iter().skip(at).take_while(|byte| byte.is_ascii_whitespace()).count()
}

/// Behind the string whose opening quote is at `at`.
fn after_string(bytes: &[u8], at: usize) -> usize {
    let mut end = at + 1;
    while end < bytes.len() && bytes[end] != b'"' {
        end += if bytes[end] == b'\\' { 2 } else { 1 };
    }
    end + 1
}

/// Behind the value that begins at `at`.
fn after_value(bytes: &[u8], at: usize) -> usize {
    let (mut end, mut depth) = (at, 0_usize);
    while end < bytes.len() {
        match bytes[end] {
            b'"' => {
                end = after_string(bytes, end);
                continue;
            }
            b'{' | b'[' => depth += 1,
            b'}' | b']' | b',' if depth == 0 => break,
            b'}' | b']' => depth -= 1,
            _ => {}
        }
        end += 1;
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "{\n \"a\": [1, [2,3], \"],{\"],\n  \"b_um\": 2, \"b\": {\"µ\\\"\": \"{\", \"c\": [\n{\"d\": 1}, {\"d\" : null}]}\n}";

    #[test]
    fn keys_are_found_in_their_lines_and_columns() {
        for (message, place) in [
            ("a is 1", Some(("a", 2, 2))),
            ("a[1] is 1", Some(("a[1]", 2, 11))),
            ("a[1][1]: is 1", Some(("a[1][1]", 2, 14))),
            ("a[7] is none", Some(("a", 2, 2))),
            ("b_um is 2", Some(("b_um", 3, 3))),
            ("b: unknown key 'c', did you mean", Some(("b.c", 3, 32))),
            ("b.c[1].d is null", Some(("b.c[1].d", 4, 12))),
            ("b.d is missing", Some(("b", 3, 14))),
            ("nothing of the kind", None),
        ] {
            let error = in_json(Error::input(message), TEXT);
            assert_eq!(error.to_string(), message);
            let found = error.key().map(|key| (key, error.line().unwrap(), error.column().unwrap()));
            assert_eq!(found, place, "{message}");
        }
        let missing = in_json(Error::input("b.d is missing").about("b.d"), TEXT);
        assert_eq!((missing.key(), missing.line()), (Some("b.d"), Some(3)));
    }

    #[test]
    fn what_is_not_json_is_said_with_its_place_and_looked_at_without_harm() {
        let error = parse_json("{\n \"a\": 1,, }").unwrap_err();
        assert_eq!((error.line(), error.column()), (Some(2), Some(9)), "{error}");
        for end in 0..TEXT.len() {
            let _ = in_json(Error::input("b.c[1].d is null"), &TEXT[..TEXT.floor_char_boundary(end)]);
        }
        let error = parse_json("{\"a\": {\n\"b\": 1, \"b\": 2}}").unwrap_err();
        assert!(error.to_string().starts_with("the key 'b' stands twice; leave one out"), "{error}");
        assert_eq!(error.line(), Some(2));
        for text in
            ["[1, -2, 0.5, \"x\", null, true]", "{\"a\": [{}, {\"b\": 1e300}]}", "18446744073709551615"]
        {
            assert_eq!(parse_json(text).unwrap(), serde_json::from_str::<Value>(text).unwrap());
        }
        assert_eq!(parse_json(TEXT).unwrap()["b"]["c"][1]["d"], Value::Null);
    }
}
