//! The keys of users' files, as their readers define them: listings, JSON schemas for editors, and a page of the documentation.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::atlas::Plan;
use crate::error::did_you_mean;
use crate::fields::{Choice, Key, Kind, inner, schema, table_at};
use crate::scene::description::scene_keys;
use crate::structure::GeneratorParameters;
use crate::{Error, Result};

/// Kinds of files: `scene`, `atlas` for the plans of atlases, and `species:GENERATOR` for the parameters of each generator.
#[must_use]
pub fn kinds() -> Vec<String> {
    ["scene", "atlas"]
        .map(str::to_owned)
        .into_iter()
        .chain(GeneratorParameters::GENERATORS.iter().map(|generator| format!("species:{generator}")))
        .collect()
}

/// The keys at the top of a kind of file, or of one of its tables, as in `camera` or `feather.distal`.
///
/// # Errors
/// There is no such kind or table; the nearest is offered.
pub fn keys_of(kind: &str, table: Option<&str>) -> Result<Vec<Key>> {
    let keys = match kind.strip_prefix("species:") {
        Some(generator) => GeneratorParameters::keys(generator)?,
        None if kind == "scene" => scene_keys(),
        None if kind == "atlas" => Plan::file_keys(),
        None => {
            let kinds = kinds();
            let near = did_you_mean(kind, kinds.iter().map(String::as_str));
            return Err(Error::input(format!(
                "there is no kind of file '{kind}'{near}; known are {}",
                kinds.join(", ")
            )));
        }
    };
    match table {
        Some(path) => table_at(keys, path),
        None => Ok(keys),
    }
}

/// A JSON schema (draft 2020-12) of a kind of file.
///
/// # Errors
/// As [`keys_of`].
pub fn schema_of(kind: &str) -> Result<Value> {
    let mut schema = schema(&keys_of(kind, None)?);
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema".into();
    schema["title"] = format!("Barbule {kind}").into();
    Ok(schema)
}

/// Keys as lines of a table: name, values, what a missing one means, explanation.
#[must_use]
pub fn rows(keys: &[Key]) -> Vec<[String; 4]> {
    let row = |key: &Key| {
        let names =
            std::iter::once(key.name).chain(key.aliases.iter().copied()).collect::<Vec<_>>().join(", ");
        let otherwise = if key.otherwise().is_empty() { "needed".to_owned() } else { key.otherwise() };
        [names, key.allowed(), otherwise, key.about.trim_end_matches('.').to_owned()]
    };
    keys.iter().map(row).collect()
}

/// The keys as JSON: what [`rows`] shows, with ranges as numbers.
#[must_use]
pub fn json_of(keys: &[Key]) -> Value {
    let one = |key: &Key| {
        let range = match key.kind {
            Kind::Number { low, high, whole } => json!({"low": low, "high": high, "whole": whole}),
            _ => Value::Null,
        };
        json!({
            "name": key.name, "aliases": key.aliases, "unit": key.unit(), "about": key.about,
            "allowed": key.allowed(), "range": range, "usual": key.usual.value(),
        })
    };
    keys.iter().map(one).collect()
}

/// The page `docs/formats/keys.md`: every key of every kind of file.
#[must_use]
pub fn page() -> String {
    let mut page = String::from(
        "# All keys\n\nEvery key of [scenes](scene.md), [species](species.md) and [plans of atlases](atlas.md), which are explained on pages of their own. \
         `barbule keys scene camera` lists one table; the command also prints a JSON schema for editors, and this page, from the definitions that the readers \
         use.\n\n\
         What is *needed* may come from a scene's preset or a feather's type. Where *unless given* has a dash, nothing stands in for the key.\n",
    );
    for kind in kinds() {
        let keys = keys_of(&kind, None).unwrap_or_default();
        tables(&mut page, &kind, "", &keys, 2);
    }
    page
}

/// A table of keys, and those of the tables inside it.
fn tables(page: &mut String, kind: &str, path: &str, keys: &[Key], depth: usize) {
    let title = if path.is_empty() { format!("`{kind}`") } else { format!("`{path}`") };
    let _ = writeln!(
        page,
        "\n{} {title}\n\n| key | values | unless given | meaning |\n| --- | --- | --- | --- |",
        "#".repeat(depth)
    );
    for [name, allowed, otherwise, about] in rows(keys) {
        let cell = |text: String| text.replace('|', "\\|");
        let otherwise = if otherwise.len() > 40 { "see its table".to_owned() } else { otherwise };
        let _ = writeln!(page, "| `{name}` | {} | {} | {} |", cell(allowed), cell(otherwise), cell(about));
    }
    let join = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
    for key in keys {
        if let Some(inside) = inner(&key.kind) {
            let listed = if is_list(&key.kind) { format!("{}[]", join(key.name)) } else { join(key.name) };
            let named = if matches!(key.kind, Kind::Named(_)) { format!("{listed}.NAME") } else { listed };
            tables(page, kind, &named, &inside, (depth + 1).min(4));
        }
        if let Kind::Choice(choices) = &key.kind {
            for Choice { word, keys, .. } in choices {
                let title = format!("{path} ({} = \"{word}\")", key.name);
                if !keys.is_empty() {
                    tables(page, kind, &title, keys, (depth + 1).min(4));
                }
            }
        }
    }
}

fn is_list(kind: &Kind) -> bool {
    matches!(kind, Kind::List { .. })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fields::Usual;

    /// Whatever a reader takes stands on the page, and nothing else does.
    #[test]
    fn the_page_of_keys_is_what_the_readers_define() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/formats/keys.md");
        let written = std::fs::read_to_string(path).unwrap();
        assert!(written == page(), "docs/formats/keys.md is not what `barbule keys --markdown` prints");
    }

    /// The explained pages name every key too, and give the range that its reader has.
    #[test]
    fn explained_pages_name_every_key_with_its_range() {
        let scene = include_str!("../../../docs/formats/scene.md");
        let mut missing = Vec::new();
        walk("", &scene_keys(), &mut |path, key| {
            let rows = scene.lines().filter(|line| line.starts_with('|'));
            let names = |line: &str| {
                let cell = line.split('|').nth(1).unwrap_or_default().to_owned();
                let cell = cell.replace('`', " ");
                cell.split([',', ' ', '/', '.', '[', ']']).any(|name| name == key.name)
            };
            if !rows.clone().any(names)
                && !scene.contains(&format!("`{}", key.name))
                && !scene.contains(&format!("[{path}.{}]", key.name))
                && !scene.contains(&format!("[[{}]]", key.name))
            {
                missing.push(format!("{path}.{}", key.name));
            }
        });
        assert!(missing.is_empty(), "docs/formats/scene.md lacks {missing:?}");
    }

    fn walk(path: &str, keys: &[Key], visit: &mut dyn FnMut(&str, &Key)) {
        for key in keys {
            visit(path, key);
            if let Some(inside) = inner(&key.kind) {
                walk(key.name, &inside, visit);
            }
            if let Kind::Choice(choices) = &key.kind {
                choices.iter().for_each(|choice| walk(path, &choice.keys, visit));
            }
        }
    }

    /// Usual values lie in their own ranges, and a schema asks for no more than its reader.
    #[test]
    fn usual_values_are_allowed() {
        walk("", &scene_keys(), &mut |_, key| {
            if let (Kind::Number { low, high, .. }, Usual::Value(value)) = (&key.kind, &key.usual) {
                assert!((*low..=*high).contains(&value.as_f64().unwrap()), "{}", key.name);
            }
        });
        let schema = schema_of("scene").unwrap();
        assert_eq!(schema["properties"]["camera"]["properties"]["f_number"]["maximum"], 1000.0);
        assert_eq!(schema["required"], json!(["camera"]));
        assert!(keys_of("scene", Some("camrea")).unwrap_err().to_string().contains("did you mean 'camera'"));
        assert!(keys_of("scenes", None).unwrap_err().to_string().contains("did you mean 'scene'"));
    }
}
