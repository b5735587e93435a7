//! Scenes as people type them.

use std::path::{Path, PathBuf};

use super::{Opening, is_built_in, material, structure, unknown, worn};
use crate::characterize::species_of;
use crate::error::shortened;
use crate::io::{Folder, InputKind, Shown, kind_of, read_material, read_shown, read_text};
use crate::material::Library;
use crate::picture::scene_for;
use crate::progress::Progress;
use crate::resolve::resolve;
use crate::scene::description::{Named, ReadyScene, SceneDescription};
use crate::scene::preset;
use crate::structure::{GeneratorParameters, SpeciesModel, Structure};
use crate::{Error, Result};

/// Opens a scene as `barbule render` takes it, with everything that it names: a preset, `SPECIES:VARIANT`, a scene file, or a structure or
/// material in the scene that suits it.
///
/// # Errors
/// As [`description`], [`resolve`] and [`material()`].
///
/// ```
/// use barbule::open::{Opening, scene};
/// use barbule::{Picture, PictureOptions, Unobserved};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let file = folder.path().join("mine.toml");
/// std::fs::write(&file, "preset = \"starling\"\n[camera]\nwidth_mm = 1.2\n")?;
/// let mine = scene(&file.to_string_lossy(), &Opening::default(), &Unobserved)?;
/// let small = PictureOptions { size: [24, 16], samples: 1, ..PictureOptions::default() };
/// Picture::of(&mine, &small, &Unobserved)?.save(folder.path().join("mine.png"))?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn scene(text: &str, opening: &Opening, progress: &dyn Progress) -> Result<ReadyScene> {
    let description = description(text, opening, progress)?;
    let mut dye = |name: &str| {
        let found = material(name, opening, progress)?;
        worn(&found.material, found.hash)
    };
    resolve(description, &Folder(folder_of(text)), &mut dye, opening.seed, progress)
}

/// The folder in which the files lie that a scene names.
#[must_use]
pub fn folder_of(text: &str) -> PathBuf {
    Path::new(text).with_file_name("")
}

/// The scene of a name, file, folder or stack, of which nothing is read that it names. Presets come first, whatever files and folders
/// are called; files are told apart by what is in them.
///
/// # Errors
/// An unknown name (the nearest known one is offered), or a file that is missing, damaged or of another kind.
pub fn description(text: &str, opening: &Opening, progress: &dyn Progress) -> Result<SceneDescription> {
    let name = text.split_once(':').map_or(text, |(name, _)| name);
    if preset::names().any(|known| known == name) {
        return SceneDescription::named(text);
    }
    let path = Path::new(text);
    let ends_with = |end: &str| text.to_lowercase().ends_with(end);
    if !path.exists() && !is_built_in(text) && names_nothing(text) {
        return Err(if unknown::is_file_name(text) {
            unknown::no_file(text)
        } else {
            unknown::no_scene(text)
        });
    }
    let kind = if path.exists() || ends_with(".toml") { kind_of(path)? } else { InputKind::Other };
    let mut scene = match kind {
        InputKind::Scene => return scene_in(text),
        // What is no TOML is refused as a scene, with the line.
        InputKind::Other if path.is_file() && ends_with(".toml") => return scene_in(text),
        InputKind::Table if ends_with(".toml") => {
            return Err(Error::input(format!(
                "{}: is neither a scene (preset, material, light …), nor a species (generator, parameters), a stack (stack) or a lattice ([lattice])",
                shortened(text)
            )));
        }
        InputKind::Material => of_material(path)?,
        _ if ends_with(".barbule") => of_material(path)?,
        InputKind::Table | InputKind::Other if path.is_file() && !ends_with(".json") => {
            let text = shortened(text);
            return Err(Error::input(format!("{text}: is neither a scene, a material nor a structure")));
        }
        _ => of_structure(&structure(text, opening, progress)?, shown_in(text, kind)?)?,
    };
    scene.set_material(text);
    Ok(scene)
}

/// Whether a text that is no file and no built-in name cannot be a variant, a lower side, a stack or a folder either.
fn names_nothing(text: &str) -> bool {
    unknown::is_file_name(text) || !text.contains(['/', ':', '('])
}

fn scene_in(text: &str) -> Result<SceneDescription> {
    let path = Path::new(text);
    let mut scene = SceneDescription::parse(&read_text(path)?).map_err(|error| error.in_file(path))?;
    for (_, named) in scene.named_mut() {
        if let Named::Material(slot) = named {
            slot.name = beside(path, std::mem::take(&mut slot.name));
        }
    }
    Ok(scene)
}

/// A scene's material, where it is a file or folder: as seen from the scene's folder. Names of species and stacks stay.
fn beside(scene: &Path, material: String) -> String {
    const ENDINGS: [&str; 3] = [".toml", ".json", ".barbule"];
    if is_built_in(&material) {
        return material;
    }
    let name = material.split_once(':').map_or(material.as_str(), |(name, _)| name);
    let place = scene.with_file_name(&material);
    let is_file = ENDINGS.iter().any(|ending| name.to_lowercase().ends_with(ending))
        || ["./", "../"].iter().any(|start| material.starts_with(start))
        // What stands where the program runs is not meant, though it bears the name.
        || place.exists()
        || Path::new(&material).exists();
    if is_file { place.to_string_lossy().into_owned() } else { material }
}

/// What a species file says about its picture; `FILE.toml:VARIANT` names one too.
fn shown_in(text: &str, kind: InputKind) -> Result<Shown> {
    let file = match kind {
        InputKind::Species => text,
        InputKind::Other if text.contains(".toml:") => text.rsplit_once(':').map_or(text, |(file, _)| file),
        _ => return Ok(Shown::default()),
    };
    read_shown(Path::new(file))
}

fn of_structure(structure: &Structure, Shown { preset, feather }: Shown) -> Result<SceneDescription> {
    let species = match structure.upper() {
        Structure::Species(model) => Some(&**model),
        Structure::Stack(_) | Structure::Sections { .. } | Structure::Below(_) => None,
    };
    let own = preset.as_deref().or(species.map(|model| model.name.as_str()));
    scene_for(own, usual_preset(species, structure.is_curved()), feather)
}

fn of_material(path: &Path) -> Result<SceneDescription> {
    let material = read_material(path)?;
    let model = species_of(&material, Library::builtin());
    let is_arched = model.as_ref().is_some_and(SpeciesModel::is_curved);
    scene_for(material.info["species"].as_str(), usual_preset(model.as_ref(), is_arched), None)
}

/// The preset that shows barbules of which no preset's name is known: that of the bird that has such, a close-up without pale tips where
/// several have.
fn usual_preset(species: Option<&SpeciesModel>, is_arched: bool) -> &'static str {
    match species.map(|model| &model.parameters) {
        Some(GeneratorParameters::Starling(_)) => "starling",
        Some(GeneratorParameters::Bronzewing(_)) => "bronzewing",
        Some(GeneratorParameters::Hummingbird(_)) => "hummingbird",
        Some(GeneratorParameters::Crystal(_)) if is_arched => "peafowl",
        Some(GeneratorParameters::Crystal(_) | GeneratorParameters::Multilayer(_)) if !is_arched => "mallard",
        Some(_) | None if is_arched => "rock-dove",
        Some(_) | None => "starling",
    }
}
