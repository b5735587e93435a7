//! Stacks in TOML.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use super::read_text;
use super::tables::{MediumSource, add_media};
use crate::error::shortened;
use crate::fields::{at_span, in_toml};
use crate::material::Library;
use crate::stack::{DEEPEST_REPETITION, Part, Stack};
use crate::{Error, Result};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    #[serde(default)]
    materials: BTreeMap<String, MediumSource>,
    stack: Option<String>,
    entry: Option<String>,
    exit: Option<String>,
    layers: Option<Vec<Layer>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Layer {
    medium: Option<String>,
    thickness_nm: Option<f64>,
    spread: Option<f64>,
    spread_nm: Option<f64>,
    repeat: Option<usize>,
    layers: Option<Vec<Layer>>,
}

/// Reads a stack from TOML: either `stack = "air/keratin:595/air"`, or `entry`, `exit` and a list `layers` of
/// `{ medium, thickness_nm }` (and `spread` or `spread_nm`, its standard deviation) and `{ repeat, layers }`; `materials` may define media by files (relative to this one)
/// or indices.
///
/// # Errors
/// The file cannot be read, is not such TOML, or describes no valid stack.
pub fn read_stack(path: &Path, library: &Library) -> Result<Stack> {
    let folder = path.parent().unwrap_or(Path::new("."));
    parse_stack(&read_text(path)?, folder, library).map_err(|e| e.in_file(path))
}

/// As [`read_stack`], from text; `folder` is where the files of media lie.
///
/// # Errors
/// As [`read_stack`].
pub fn parse_stack(text: &str, folder: &Path, library: &Library) -> Result<Stack> {
    let document: Document = toml::from_str(text).map_err(|error| {
        let refusal = Error::input(format!("is not a stack in TOML: {}", one_line(&error, text)));
        at_span(refusal, text, error.span())
    })?;
    stack(document, folder, library).map_err(|error| in_toml(error, text))
}

fn stack(document: Document, folder: &Path, library: &Library) -> Result<Stack> {
    let mut library = library.clone();
    add_media(&document.materials, folder, &mut library)?;
    let Document { stack, entry, exit, layers, .. } = document;
    match (stack, entry, exit, layers) {
        (Some(text), None, None, None) => Stack::parse(&text, &library),
        (None, Some(entry), Some(exit), layers) => {
            Stack::from_parts(&entry, &parts(layers.unwrap_or_default(), "layers", 0)?, &exit, &library)
        }
        _ => Err(Error::input(
            "give either stack = \"air/keratin:595/air\", or entry, layers and exit, and not both",
        )),
    }
}

fn parts(layers: Vec<Layer>, place: &str, depth: usize) -> Result<Vec<Part>> {
    if depth > DEEPEST_REPETITION {
        return Err(Error::input(format!("repetitions are nested more than {DEEPEST_REPETITION} deep")));
    }
    let mut made = Vec::with_capacity(layers.len());
    for (i, layer) in layers.into_iter().enumerate() {
        let here = format!("{place}[{i}]");
        let spread_nm = spread_nm(&layer).map_err(|e| e.at(shortened(&here)))?;
        made.push(match (layer, spread_nm) {
            (
                Layer {
                    medium: Some(medium),
                    thickness_nm: Some(thickness_nm),
                    repeat: None,
                    layers: None,
                    ..
                },
                spread_nm,
            ) => Part::Layer { medium, thickness_nm, spread_nm: spread_nm.unwrap_or(0.0) },
            (
                Layer { medium: None, thickness_nm: None, repeat: Some(count), layers: Some(inner), .. },
                None,
            ) => Part::Repeat { count, parts: parts(inner, &format!("{here}.layers"), depth + 1)? },
            _ => {
                return Err(Error::input(format!(
                    "{}: give either medium and thickness_nm (and spread or spread_nm), or repeat and layers",
                    shortened(&here)
                )));
            }
        });
    }
    Ok(made)
}

/// The standard deviation of a layer's thickness in nm, where one is given.
fn spread_nm(layer: &Layer) -> Result<Option<f64>> {
    match (layer.spread, layer.spread_nm) {
        (Some(_), Some(_)) => {
            Err(Error::input("give spread, a part of the thickness, or spread_nm, not both"))
        }
        (Some(part), None) if !(0.0..=1.0).contains(&part) => Err(Error::input(format!(
            "spread is {part}, but it is a part of the thickness, 0 to 1, as in 0.05 for 5 %; lengths are given as spread_nm"
        ))),
        (Some(part), None) => Ok(Some(part * layer.thickness_nm.unwrap_or(0.0))),
        (None, length) => Ok(length),
    }
}

/// A TOML error as one line with its place.
fn one_line(error: &toml::de::Error, text: &str) -> String {
    let message = shortened(error.message());
    match error.span() {
        Some(span) => {
            let line =
                text.as_bytes()[..span.start.min(text.len())].iter().filter(|b| **b == b'\n').count() + 1;
            format!("line {line}: {message}")
        }
        None => message,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Stack> {
        parse_stack(text, Path::new("."), &Library::builtin())
    }

    #[test]
    fn both_forms_give_the_same_stack() {
        let language = read("stack = \"air/6*(melanin:99/keratin:100)/keratin\"").unwrap();
        let list = read(
            r#"
            entry = "air"
            exit = "keratin"
            [[layers]]
            repeat = 6
            layers = [{ medium = "melanin", thickness_nm = 99 }, { medium = "keratin", thickness_nm = 100.0 }]
            "#,
        )
        .unwrap();
        assert_eq!(language, list);
        let spread = read(
            r#"
            entry = "air"
            exit = "air"
            layers = [{ medium = "keratin", thickness_nm = 200, spread = 0.05 }, { medium = "air", thickness_nm = 9, spread_nm = 2 }]
            "#,
        );
        assert_eq!(spread.unwrap(), read("stack = \"air/keratin:200±5%/air:9±2/air\"").unwrap());
        let own = read("stack = \"air/resin:50/air\"\n[materials]\nresin = [1.6, 0.01]").unwrap();
        assert_eq!(own.indices(500.0).unwrap()[1].im, 0.01);
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, part) in [
            ("", "give either stack"),
            ("stack = 3", "line 1"),
            ("stack = \"air/air\"\nentry = \"air\"", "and not both"),
            ("entry = \"air\"", "give either stack"),
            ("tack = \"air/air\"", "unknown field `tack`"),
            (
                "entry = \"air\"\nexit = \"air\"\nlayers = [{ medium = \"air\" }]",
                "layers[0]: give either medium",
            ),
            (
                "entry = \"air\"\nexit = \"air\"\nlayers = [{ medium = \"air\", thickness_nm = 5, spread = 5 }]",
                "layers[0]: spread is 5, but it is a part of the thickness",
            ),
            (
                "entry = \"air\"\nexit = \"air\"\nlayers = [{ medium = \"air\", thickness_nm = 5, spread = 0.1, spread_nm = 1 }]",
                "not both",
            ),
            ("entry = \"air\"\nexit = \"airr\"", "did you mean 'air'"),
            ("entry = \"air\"\nexit = \"air\"\nlayers = [{ repeat = 0, layers = [] }]", "count of 1 or more"),
            (
                "entry = \"air\"\nexit = \"air\"\nlayers = [{ repeat = -1, layers = [] }]",
                "not a stack in TOML",
            ),
            ("stack = \"air/x:5/air\"\n[materials]\nx = \"none.csv\"", "no such file"),
            ("stack = \"air/x:5/air\"\n[materials]\nx = [1.5]", "not a stack in TOML"),
            ("= = =", "not a stack in TOML: line 1"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.is_input() && error.to_string().len() < 600);
            assert!(error.to_string().contains(part), "{text}: {error}");
        }
        let deep = format!("layers = {}1{}", "[{layers=".repeat(5000), "}]".repeat(5000));
        read(&deep).unwrap_err();
    }
}
