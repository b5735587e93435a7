//! The feathers that are shipped as data: types, and single birds' feathers that differ from them.

use serde_json::Value;

use super::tables::layered;
use crate::Result;
use crate::fields::parse_toml;

/// Each with the type that it differs from; a contour feather gives every size.
const FEATHERS: &[(&str, Option<&str>, &str)] = &[
    ("contour", None, include_str!("types/contour.toml")),
    ("primary", Some("contour"), include_str!("types/primary.toml")),
    ("secondary", Some("primary"), include_str!("types/secondary.toml")),
    ("tail", Some("primary"), include_str!("types/tail.toml")),
    ("covert", Some("contour"), include_str!("types/covert.toml")),
    ("semiplume", Some("contour"), include_str!("types/semiplume.toml")),
    ("down", Some("semiplume"), include_str!("types/down.toml")),
    ("osprey", Some("primary"), include_str!("types/osprey.toml")),
    ("turkey-vulture", Some("primary"), include_str!("types/turkey-vulture.toml")),
    ("rock-dove-wing", Some("primary"), include_str!("types/rock-dove-wing.toml")),
];

/// Names of all types and birds.
pub fn names() -> impl Iterator<Item = &'static str> + Clone {
    FEATHERS.iter().map(|(name, ..)| *name)
}

/// The table of a type, with every key; nothing where there is none of this name.
pub(super) fn table(name: &str) -> Option<Result<Value>> {
    let (_, base, text) = FEATHERS.iter().find(|(known, ..)| *known == name)?;
    let own = parse_toml(text);
    Some(match base.and_then(table) {
        None => own,
        Some(base) => own.and_then(|own| Ok(layered(Some(own), Some(base?)).unwrap_or_default())),
    })
}
