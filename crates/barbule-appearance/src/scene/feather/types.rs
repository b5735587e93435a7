//! The feathers that are shipped as data: types, and single birds' feathers that differ from them.

use barbule_birds::BIRDS;
use serde_json::Value;

use super::tables::layered;
use crate::Result;
use crate::fields::parse_toml;
use crate::scene::preset;

/// A feather with the type that it differs from, and the text of its sizes.
type Feather = (&'static str, Option<&'static str>, &'static str);

/// The types; a contour feather gives every size.
const TYPES: [Feather; 8] = [
    ("contour", None, include_str!("types/contour.toml")),
    ("primary", Some("contour"), include_str!("types/primary.toml")),
    ("secondary", Some("primary"), include_str!("types/secondary.toml")),
    ("tail", Some("primary"), include_str!("types/tail.toml")),
    ("covert", Some("contour"), include_str!("types/covert.toml")),
    ("semiplume", Some("contour"), include_str!("types/semiplume.toml")),
    ("down", Some("semiplume"), include_str!("types/down.toml")),
    ("train", Some("contour"), include_str!("types/train.toml")),
];

/// The types, then single birds' feathers.
fn feathers() -> impl Iterator<Item = Feather> + Clone {
    let birds = BIRDS.iter().filter_map(|bird| Some((bird.name, Some("primary"), bird.primary?)));
    TYPES.into_iter().chain(birds)
}

/// Names of all types and birds.
pub fn names() -> impl Iterator<Item = &'static str> + Clone {
    feathers().map(|(name, ..)| name)
}

/// The table of a type, with every key; nothing where there is none of this name.
pub(super) fn table(name: &str) -> Option<Result<Value>> {
    let (_, base, text) = feathers().find(|(known, ..)| *known == name)?;
    let own = parse_toml(text);
    Some(match base.and_then(table) {
        None => own,
        Some(base) => own.and_then(|own| Ok(layered(Some(own), Some(base?)).unwrap_or_default())),
    })
}

/// What the file of a type, bird or preset says about a size: the comment beside it, with its source and mark. `key` is
/// `table.key` as in scene files, without `feather.`.
#[must_use]
pub fn source(name: &str, key: &str) -> Option<&'static str> {
    let (table, key) = key.split_once('.')?;
    if let Some((_, base, text)) = feathers().find(|(known, ..)| *known == name) {
        return comment(text, table, key).or_else(|| source(base?, &format!("{table}.{key}")));
    }
    let text = preset::toml(name).ok()?;
    let kind = line_in(text, "feather", "type").and_then(|line| line.split('"').nth(1)).unwrap_or("contour");
    comment(text, &format!("feather.{table}"), key).or_else(|| source(kind, &format!("{table}.{key}")))
}

/// The comment beside a key; an empty one where there is the key alone.
fn comment(text: &'static str, table: &str, key: &str) -> Option<&'static str> {
    // A key for both vanes stands for either.
    let both = key.replacen("leading_", "", 1).replacen("trailing_", "", 1);
    let both = if both == "half_width_mm" { "vane_half_width_mm".to_owned() } else { both };
    let line = line_in(text, table, key).or_else(|| line_in(text, table, &both))?;
    Some(line.split_once('#').map_or("", |(_, comment)| comment.trim()))
}

/// The line of a key in a table.
fn line_in(text: &'static str, table: &str, key: &str) -> Option<&'static str> {
    let mut lines = text.lines().skip_while(|line| !line.starts_with(&format!("[{table}]")));
    lines.next()?;
    lines
        .take_while(|line| !line.starts_with('['))
        .find(|line| line.split('=').next().map(str::trim) == Some(key))
}
