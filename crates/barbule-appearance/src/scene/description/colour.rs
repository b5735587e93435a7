//! Colours of scene files: what a screen shows, `"#rrggbb"` or three numbers from 0 to 1.

use crate::error::shortened;
use crate::fields::{FieldValue, Kind, Value, list, number};
use crate::identity::Hasher;
use crate::{Error, Result};

/// sRGB, 0 … 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colour(pub [f64; 3]);

impl Colour {
    /// Black.
    pub const BLACK: Self = Self([0.0; 3]);
    /// White.
    pub const WHITE: Self = Self([1.0; 3]);
}

impl FieldValue for Colour {
    type Limits = ();

    fn of_value(value: &Value, path: &str, (): &()) -> Result<Self> {
        colour(value, path).map(Self)
    }

    fn to_value(&self, (): &()) -> Option<Value> {
        Some(self.0.to_vec().into())
    }

    fn check_value(&self, path: &str, (): &()) -> Result<()> {
        if self.0.iter().all(|value| (0.0..=1.0).contains(value)) { Ok(()) } else { Err(wanted(path)) }
    }

    fn feed_value(&self, key: &str, to: &mut Hasher) {
        to.numbers(key, &self.0);
    }

    fn kind((): &()) -> Kind {
        Kind::Colour
    }
}

fn wanted(place: &str) -> Error {
    Error::input(format!("{place}: give three numbers from 0 to 1, or \"#rrggbb\""))
}

/// The three numbers of a colour; `place` names it in messages.
///
/// # Errors
/// Neither six hexadecimal digits after `#` nor three numbers from 0 to 1.
fn colour(value: &Value, place: &str) -> Result<[f64; 3]> {
    if let Value::String(text) = value {
        return parse_colour(text).map_err(|error| error.at(place));
    }
    let numbers: Vec<f64> =
        list(value, place)?.iter().map(|value| number(value, place)).collect::<Result<_>>()?;
    match numbers[..] {
        [r, g, b] if [r, g, b].iter().all(|v| (0.0..=1.0).contains(v)) => Ok([r, g, b]),
        _ => Err(wanted(place)),
    }
}

/// The three numbers of a text `#rrggbb`.
///
/// # Errors
/// As above.
pub fn parse_colour(text: &str) -> Result<[f64; 3]> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.is_ascii());
    let byte = |k: usize| u8::from_str_radix(digits?.get(2 * k..2 * k + 2)?, 16).ok();
    match (byte(0), byte(1), byte(2)) {
        (Some(r), Some(g), Some(b)) => Ok([r, g, b].map(|v| f64::from(v) / 255.0)),
        _ => Err(Error::input(format!("'{}' is no colour; write it as in #20406a", shortened(text)))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_what_a_screen_shows() {
        assert_eq!(parse_colour("#ff0000").unwrap(), [1.0, 0.0, 0.0]);
        assert_eq!(colour(&serde_json::json!([0.5, 0, 1]), "light").unwrap(), [0.5, 0.0, 1.0]);
        assert_eq!(colour(&serde_json::json!("#3300ff"), "light").unwrap(), [0.2, 0.0, 1.0]);
        for bad in ["", "#12345", "#12345g", "red", "#äöü"] {
            assert!(parse_colour(bad).unwrap_err().to_string().contains("#20406a"), "{bad}");
        }
        let refused = |value| colour(&value, "background.colour").unwrap_err().to_string();
        assert!(refused(serde_json::json!([0.5, 0.5])).contains("three numbers from 0 to 1"));
        assert!(refused(serde_json::json!([0.5, 0.5, 2.0])).contains("background.colour"));
        assert!(refused(serde_json::json!("blue")).contains("background.colour: 'blue'"));
    }
}
