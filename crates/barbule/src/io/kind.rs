//! What a user's file is, by its content.

use std::path::Path;

use serde_json::Value;

use super::read_bytes;
use crate::Result;

/// What a file or folder is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InputKind {
    /// A feather material.
    Material,
    /// A scene in TOML.
    Scene,
    /// A species in TOML.
    Species,
    /// A stack in TOML.
    Stack,
    /// A lattice alone, in TOML or JSON.
    Lattice,
    /// A cross section in JSON.
    Section,
    /// A folder, of sections unless somebody errs.
    Folder,
    /// The store of a campaign.
    Store,
    /// TOML of none of these kinds.
    Table,
    /// Something else, or damaged.
    Other,
}

/// Keys that only scenes have, species, and stacks. `feather` is of scenes and species.
const SCENE: [&str; 21] = [
    "preset",
    "material",
    "light",
    "lights",
    "background",
    "objects",
    "turn",
    "turn_deg",
    "camera",
    "window",
    "detail",
    "surfaces",
    "shows_feather",
    "coat",
    "exposure",
    "scatterings",
    "sky",
    "sky_horizon",
    "sky_below",
    "sky_image",
    "size",
];
const SPECIES: [&str; 5] = ["generator", "parameters", "variants", "latin", "coloration"];
const STACK: [&str; 4] = ["stack", "layers", "entry", "exit"];

/// What a file or folder is, by what is in it rather than by its name.
///
/// # Errors
/// It is missing, cannot be read, or is too large.
pub fn kind_of(path: &Path) -> Result<InputKind> {
    if path.is_dir() {
        let is_store = path.join("zarr.json").is_file();
        return Ok(if is_store { InputKind::Store } else { InputKind::Folder });
    }
    let bytes = read_bytes(path)?;
    if is_container(&bytes) {
        return Ok(InputKind::Material);
    }
    Ok(std::str::from_utf8(&bytes).map_or(InputKind::Other, kind_of_text))
}

/// What a text is, TOML or JSON.
pub(super) fn kind_of_text(text: &str) -> InputKind {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    // JSON is tried only where it may be: a bracket never begins TOML that is of use here.
    if text.trim_start().starts_with('{') {
        let has = |value: &Value, key: &str| value.get(key).is_some();
        return match serde_json::from_str::<Value>(text) {
            Ok(value) if has(&value, "boundaries") || has(&value, "media") => InputKind::Section,
            Ok(value) if has(&value, "lattice") => InputKind::Lattice,
            _ => InputKind::Other,
        };
    }
    let Ok(table) = toml::from_str::<toml::Table>(text) else { return InputKind::Other };
    let has = |keys: &[&str]| keys.iter().any(|key| table.contains_key(*key));
    if has(&["lattice"]) && !has(&["generator"]) {
        InputKind::Lattice
    } else if has(&STACK) {
        InputKind::Stack
    } else if has(&SPECIES) {
        InputKind::Species
    } else if has(&SCENE) {
        InputKind::Scene
    } else {
        InputKind::Table
    }
}

/// Whether bytes begin as a *safetensors* container does: the length of its header, then the header in JSON.
fn is_container(bytes: &[u8]) -> bool {
    let Some((length, header)) = bytes.split_first_chunk::<8>() else { return false };
    u64::from_le_bytes(*length) <= header.len() as u64 && header.first() == Some(&b'{')
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::{encode_material, section_json};
    use crate::scene::description::SceneDescription;
    use crate::structure::{Structure, species_toml};

    #[test]
    fn files_are_told_apart_by_what_is_in_them() {
        let folder = tempfile::tempdir().unwrap();
        let kind = |bytes: &[u8]| {
            let path = folder.path().join("file");
            std::fs::write(&path, bytes).unwrap();
            kind_of(&path).unwrap()
        };
        let section = Structure::flat("air/keratin:300/air").unwrap().instance(1, 0).unwrap();
        let material = encode_material(&crate::brdf::fixtures::example(3)).unwrap();
        assert_eq!(kind(&material), InputKind::Material);
        assert_eq!(kind(&material[..40]), InputKind::Other);
        assert_eq!(kind(section_json(&section).to_string().as_bytes()), InputKind::Section);
        assert_eq!(kind(species_toml("mallard").unwrap().as_bytes()), InputKind::Species);
        assert_eq!(kind(crate::scene::preset::toml("mallard").unwrap().as_bytes()), InputKind::Scene);
        assert_eq!(kind(b"\xef\xbb\xbfpreset = 'starling'"), InputKind::Scene);
        assert_eq!(kind(b"stack = 'air/keratin:300/air'"), InputKind::Stack);
        assert_eq!(kind(b"[lattice]\nperiod = 0.2"), InputKind::Lattice);
        assert_eq!(kind(b" {\"lattice\": {}}"), InputKind::Lattice);
        assert_eq!([kind(b""), kind(b"a = 1")], [InputKind::Table; 2]);
        for other in [&b"{"[..], b"[1, 2]", b"a = = 1", b"wavelength,R\n400,0.1\n", b"\xff\xfe"] {
            assert_eq!(kind(other), InputKind::Other, "{other:?}");
        }
        assert_eq!(kind_of(folder.path()).unwrap(), InputKind::Folder);
        std::fs::write(folder.path().join("zarr.json"), "{}").unwrap();
        assert_eq!(kind_of(folder.path()).unwrap(), InputKind::Store);
        assert!(kind_of(&folder.path().join("none")).unwrap_err().to_string().contains("no such file"));
    }

    /// What is a scene's key by the list is one to its reader, and what the documentation's first tables name is in the list.
    #[test]
    fn every_key_of_a_scene_makes_a_scene() {
        for key in SCENE {
            if let Err(refused) = SceneDescription::parse(&format!("{key} = 'x'")) {
                assert!(!refused.to_string().contains("unknown field"), "{refused}");
            }
        }
        let page = include_str!("../../../../docs/formats/scene.md");
        let keys = page.split("detail.view_model").next().unwrap();
        let keys: Vec<&str> = keys
            .lines()
            .filter_map(|line| line.strip_prefix("| `")?.split(" | ").next())
            .flat_map(|cell| cell.split(", `"))
            .map(|key| key.split(['.', '`']).next().unwrap())
            .collect();
        assert!(keys.len() > 30);
        for key in keys {
            assert_eq!(kind_of_text(&format!("{key} = 1")), InputKind::Scene, "{key}");
        }
        for key in ["coat", "lights", "objects", "shows_feather", "surfaces"] {
            assert_eq!(kind_of_text(&format!("{key} = 1")), InputKind::Scene, "{key}");
        }
    }
}
