//! One variant of a species as a file of its own, to be edited: no variants, and every key explained.

use std::fmt::Write;

use serde_json::{Map, Value};

use super::{DEFAULT_VARIANT, GeneratorParameters, SpeciesFile};
use crate::fields::Key;
use crate::{Error, Result};

/// What the species of a copy is called, until its owner finds a better name.
const OWN: &str = "my-";

impl SpeciesFile {
    /// The text of a file without variants that makes the same sections as a variant of this one, bit by bit. Its name
    /// is its own; each line says what the key is, its range and its unit.
    ///
    /// # Errors
    /// No such variant, or what the format cannot write.
    pub fn flat_toml(&self, variant: Option<&str>) -> Result<String> {
        self.flat_toml_of(variant, &Map::new())
    }

    /// The same with other values of some parameters.
    ///
    /// # Errors
    /// As [`Self::flat_toml`].
    pub fn flat_toml_of(&self, variant: Option<&str>, values: &Map<String, Value>) -> Result<String> {
        let lines_of_parameters = self.explained_with(variant, values)?;
        let variant = variant.unwrap_or(&self.default);
        let from =
            if variant == DEFAULT_VARIANT { self.name.clone() } else { format!("{}:{variant}", self.name) };
        let name = if self.name.starts_with(OWN) { self.name.clone() } else { format!("{OWN}{}", self.name) };
        let text = |value: &str| toml::Value::from(value).to_string();
        let mut lines = vec![
            ("barbule = 1".to_owned(), "version of the format".to_owned()),
            (format!("name = {}", text(&name)), "yours to choose".to_owned()),
            (
                format!("generator = {}", text(&self.generator)),
                about(GeneratorParameters::about(&self.generator)?),
            ),
        ];
        let words = [("latin", &self.latin), ("coloration", &self.coloration), ("source", &self.source)];
        for (key, value) in words.into_iter().filter(|(_, value)| !value.is_empty()) {
            lines.push((format!("{key} = {}", text(value)), String::new()));
        }
        if let Some(preset) = &self.preset {
            lines.push((format!("preset = {}", text(preset)), "the scene that shows it".to_owned()));
        }
        // Writing to a string cannot fail, here and below.
        let mut out = String::new();
        let _ = writeln!(
            out,
            "# A species of your own, begun as {from}. Change any number: the comment beside it says"
        );
        let _ = writeln!(
            out,
            "# what it is and from where to where it may go; U(a, b) is drawn anew between a and b for"
        );
        let _ = writeln!(out, "# each individual or part. Give this file wherever a species is named.");
        push_aligned(&mut out, &lines);
        let _ = writeln!(out, "\n[parameters]");
        push_aligned(&mut out, &lines_of_parameters);
        let tables = [("materials", &self.materials), ("feather", &self.feather)];
        let others: Map<String, Value> =
            tables.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value.clone()?))).collect();
        if !others.is_empty() {
            let _ = write!(out, "\n{}", toml::to_string(&others).map_err(unwritable)?);
        }
        Ok(out)
    }

    /// A variant's parameters as lines of a file, each with what it is and what is allowed.
    ///
    /// # Errors
    /// No such variant, or what the format cannot write.
    pub fn explained(&self, variant: Option<&str>) -> Result<Vec<(String, String)>> {
        self.explained_with(variant, &Map::new())
    }

    fn explained_with(
        &self,
        variant: Option<&str>,
        values: &Map<String, Value>,
    ) -> Result<Vec<(String, String)>> {
        let given = self.given(variant)?;
        let lines = given.iter().map(|(key, value)| (key, values.get(key.name).unwrap_or(value)));
        lines.map(|(key, value)| Ok((line(key, value)?, explained(key)))).collect()
    }
}

fn unwritable(error: impl std::fmt::Display) -> Error {
    Error::input(format!("cannot be written as TOML: {error}"))
}

fn line(key: &Key, value: &Value) -> Result<String> {
    let value = toml::Value::try_from(value).map_err(unwritable)?;
    Ok(format!("{} = {value}", key.name))
}

/// What a parameter is and its range.
fn explained(key: &Key) -> String {
    format!("{} ({})", about(key.about), key.allowed())
}

/// A sentence of the documentation as a comment: no full stop, no capital but in formulas and names.
fn about(sentence: &str) -> String {
    let plain = sentence.trim_end_matches('.').replace('`', "");
    let mut letters = plain.chars();
    match (letters.next(), letters.clone().next()) {
        (Some(first), Some(second)) if second.is_lowercase() || second == ' ' => {
            first.to_lowercase().chain(letters).collect()
        }
        _ => plain,
    }
}

/// Lines with their comments below each other; those without one stand as they are.
fn push_aligned(out: &mut String, lines: &[(String, String)]) {
    let commented = lines.iter().filter(|(_, comment)| !comment.is_empty());
    let width = commented.map(|(line, _)| line.chars().count()).max().unwrap_or(0);
    for (line, comment) in lines {
        let _ = match comment.as_str() {
            "" => writeln!(out, "{line}"),
            comment => writeln!(out, "{line:width$}  # {comment}"),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Library;
    use crate::structure::species_names;

    #[test]
    fn a_flat_copy_makes_the_same_sections_bit_by_bit() {
        for name in species_names() {
            let file = SpeciesFile::builtin(name).unwrap();
            for variant in file.variants().map(Some).chain([None]) {
                let text = file.flat_toml(variant).unwrap();
                let copy = SpeciesFile::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
                assert_eq!(copy.variants().collect::<Vec<_>>(), [DEFAULT_VARIANT]);
                let model = |file: &SpeciesFile, variant| file.model(variant, Library::builtin()).unwrap();
                let (mine, theirs) = (model(&copy, None), model(&file, variant));
                assert_eq!(mine.parameters, theirs.parameters, "{name} {variant:?}");
                if variant.is_none() {
                    let (a, b) = (mine.section(3, 1).unwrap(), theirs.section(3, 1).unwrap());
                    assert_eq!(a.boundaries, b.boundaries);
                    assert_eq!(crate::identity::hash("section", &a), crate::identity::hash("section", &b));
                }
                // A copy of a copy keeps its name.
                assert_eq!(copy.flat_toml(None).unwrap().lines().nth(4), text.lines().nth(4));
            }
        }
    }

    #[test]
    fn every_key_is_explained_with_its_range_and_unit() {
        let text = SpeciesFile::builtin("starling").unwrap().flat_toml(Some("pink")).unwrap();
        for line in [
            "name = \"my-starling\"",
            "cortex_um = 0.38                # keratin between the surface and the melanosomes (0.001 to 10 µm)",
            "core_fraction_low = 0.3         # least melanin fraction between the chains (0 to 1)",
        ] {
            assert!(text.contains(line), "{text}");
        }
        assert!(!text.contains("variants") && !text.contains("default"), "{text}");
        let crystal = SpeciesFile::builtin("mallard").unwrap().flat_toml(None).unwrap();
        // What the file leaves out is there to be changed.
        assert!(crystal.contains("rows = 6 ") && crystal.contains("regularity_low = 1.0 "), "{crystal}");
    }

    #[test]
    fn own_materials_go_along() {
        let text = format!(
            "{}\n[materials]\nkeratin = [1.6, 0.0]\n",
            crate::structure::species_toml("starling").unwrap()
        );
        let copy = SpeciesFile::parse(&text).unwrap().flat_toml(None).unwrap();
        assert_eq!(
            SpeciesFile::parse(&copy).unwrap().materials,
            Some(serde_json::json!({"keratin": [1.6, 0.0]}))
        );
    }
}
