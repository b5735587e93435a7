//! Words of scene files of which only some are known.

use serde_json::Value;

use crate::error::{did_you_mean, shortened};
use crate::{Error, Result};

/// The `type` of a table, which must be one of those known.
///
/// # Errors
/// It is missing, no text or unknown; the nearest known one is offered.
pub(super) fn kind_of(table: &Value, place: &str, known: &[&'static str]) -> Result<&'static str> {
    let Some(Value::String(kind)) = table.get("type") else {
        return Err(Error::input(format!("{place}.type is missing; give one of {}", known.join(", "))));
    };
    let found = known.iter().find(|one| *one == kind);
    found.copied().ok_or_else(|| unknown(&format!("{place}.type"), kind, known))
}

/// The refusal of a name that is none of those known.
pub(super) fn unknown(path: &str, name: &str, known: &[&str]) -> Error {
    let name = shortened(name);
    let near = did_you_mean(&name, known.iter().copied());
    Error::input(format!("{path} is '{name}'{near}; known are {}", known.join(", ")))
}
