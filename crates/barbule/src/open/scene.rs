//! Scenes as people type them.

use std::path::{Path, PathBuf};

use super::{Opening, is_built_in, material, structure};
use crate::characterize::species_of;
use crate::error::shortened;
use crate::io::{Folder, InputKind, kind_of, read_feather, read_material, read_text};
use crate::material::Library;
use crate::picture::scene_for;
use crate::progress::Progress;
use crate::resolve::{Worn, resolve};
use crate::scene::description::{Named, ReadyScene, SceneDescription};
use crate::scene::feather::Feather;
use crate::scene::preset;
use crate::structure::Structure;
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
        Worn::new(&found.material, found.hash)
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
        _ => of_structure(&structure(text, opening, progress)?, feather_in(text, kind)?)?,
    };
    scene.set_material(text);
    Ok(scene)
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

/// The feather that a species file brings; `FILE.toml:VARIANT` names one too.
fn feather_in(text: &str, kind: InputKind) -> Result<Option<Feather>> {
    let file = match kind {
        InputKind::Species => text,
        InputKind::Other if text.contains(".toml:") => text.rsplit_once(':').map_or(text, |(file, _)| file),
        _ => return Ok(None),
    };
    read_feather(Path::new(file))
}

fn of_structure(structure: &Structure, feather: Option<Feather>) -> Result<SceneDescription> {
    let species = match structure.upper() {
        Structure::Species(model) => Some(model.name.as_str()),
        Structure::Stack(_) | Structure::Sections { .. } | Structure::Below(_) => None,
    };
    scene_for(species, structure.is_curved(), feather)
}

fn of_material(path: &Path) -> Result<SceneDescription> {
    let material = read_material(path)?;
    let model = species_of(&material, Library::builtin());
    let is_arched = model.is_some_and(|model| model.is_curved());
    scene_for(material.info["species"].as_str(), is_arched, None)
}
