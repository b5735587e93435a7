//! Every bird's folder is complete, and listed.

use std::path::Path;

use barbule::SceneDescription;
use barbule::io::decode_material;
use barbule::material::Library;
use barbule::structure::{SpeciesFile, SpeciesModel, species_name};
use barbule_birds::{BIRDS, materials};

/// The files of a folder, without `notes.md`.
fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name != "notes.md")
        .collect();
    names.sort();
    names
}

#[test]
fn every_folder_is_listed_with_every_file() {
    let birds = Path::new(env!("CARGO_MANIFEST_DIR")).join("../barbule-birds/birds");
    let mut listed: Vec<_> = BIRDS.iter().map(|bird| bird.name).collect();
    listed.sort_unstable();
    assert_eq!(files(&birds), listed);
    for bird in BIRDS {
        let folder = birds.join(bird.name);
        let held = [
            ("species.toml", bird.species),
            ("scene.toml", bird.scene),
            ("feather.toml", bird.feather),
            ("wing.toml", bird.wing),
            ("primary.toml", bird.primary),
        ];
        let texts = held.into_iter().filter(|(_, text)| text.is_some()).map(|(name, _)| name.to_owned());
        let own =
            materials().map(|(stem, _)| format!("{stem}.barbule")).filter(|file| folder.join(file).exists());
        let further = bird.presets.iter().map(|(name, _)| format!("{name}.toml"));
        let mut expected: Vec<_> = texts.chain(further).chain(own).collect();
        expected.sort();
        assert_eq!(files(&folder), expected, "{}", bird.name);
        assert!(bird.notes.starts_with("# "), "{}: notes.md begins with its title", bird.name);
        assert!(bird.notes.lines().count() > 2, "{}: notes.md says nothing", bird.name);
    }
}

#[test]
fn every_species_has_scenes_that_wear_a_species_and_a_material_of_its_default_variant() {
    for bird in BIRDS {
        let scenes = [bird.scene, bird.feather, bird.wing];
        for text in scenes.into_iter().flatten() {
            SceneDescription::parse(text).unwrap_or_else(|error| panic!("{}: {error}", bird.name));
            for line in text.lines().filter_map(|line| line.strip_prefix("material = \"")) {
                let name = line.split(['"', ':']).next().unwrap();
                species_name(name).unwrap_or_else(|error| panic!("{}: {error}", bird.name));
            }
        }
        assert_eq!(
            bird.wing.is_some(),
            bird.primary.is_some(),
            "{}: a wing's scene and its sizes",
            bird.name
        );
        let Some(species) = bird.species else { continue };
        assert!(
            bird.scene.is_some() && bird.feather.is_some(),
            "{}: a close-up and a whole feather",
            bird.name
        );
        let file = SpeciesFile::parse(species).unwrap();
        assert_eq!(file.name, bird.name);
        let stem = format!("{}-{}", file.name, file.default);
        assert!(materials().any(|(name, _)| name == stem), "{stem} ships");
    }
}

#[test]
fn every_material_is_of_a_variant_of_its_bird() {
    for (stem, bytes) in materials() {
        let info = decode_material(bytes).unwrap().info;
        let (species, variant) = (info["species"].as_str().unwrap(), info["variant"].as_str().unwrap());
        SpeciesModel::builtin(species, Some(variant), Library::builtin()).unwrap();
        assert_eq!(stem.trim_end_matches("-below"), format!("{species}-{variant}"));
    }
}
