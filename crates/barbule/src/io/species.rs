//! Structures in TOML: species files, and stacks as flat sections.

use std::path::Path;

use super::section::materials;
use super::{parse_stack, read_text};
use crate::material::{Library, shortened};
use crate::structure::{Section, SpeciesFile, SpeciesModel, Structure};
use crate::{Error, Result};

/// Reads a species file; without a variant its default one.
///
/// # Errors
/// The file cannot be read, or anything that `docs/formats/species.md` lists; the message names the file and the key.
pub fn read_species(path: &Path, variant: Option<&str>, library: &Library) -> Result<SpeciesModel> {
    let folder = path.parent().unwrap_or(Path::new("."));
    parse_species(&read_text(path)?, variant, folder, library).map_err(|error| error.at(path.display()))
}

fn parse_species(
    text: &str,
    variant: Option<&str>,
    folder: &Path,
    library: &Library,
) -> Result<SpeciesModel> {
    let file = SpeciesFile::parse(text)?;
    let mut library = library.clone();
    materials(file.materials.as_ref(), folder, &mut library)?;
    file.model(variant, library)
}

/// Reads a structure in TOML: a species, or a stack, which becomes a flat section.
///
/// # Errors
/// As [`read_species`] or [`super::read_stack`]; a lattice, which this version does not simulate.
pub fn read_structure_toml(path: &Path, variant: Option<&str>, library: &Library) -> Result<Structure> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let text = read_text(path)?;
    let at = |error: Error| error.at(path.display());
    let table: toml::Table = toml::from_str(&text).unwrap_or_default();
    let is_stack = ["stack", "layers", "entry", "exit"].iter().any(|key| table.contains_key(*key));
    if !is_stack {
        return parse_species(&text, variant, folder, library)
            .map(|m| Structure::Species(Box::new(m)))
            .map_err(at);
    }
    if let Some(variant) = variant {
        return Err(at(Error::input(format!("a stack has no variants, so no '{}'", shortened(variant)))));
    }
    let stack = parse_stack(&text, folder, library).map_err(at)?;
    let mut library = library.clone();
    let table = table.get("materials").and_then(|value| serde_json::to_value(value).ok());
    let sources = materials(table.as_ref(), folder, &mut library).map_err(at)?;
    let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let mut section = Section::flat(&name, &stack, library).map_err(at)?;
    section.materials = sources;
    Ok(Structure::Sections { name, sections: vec![section] })
}
