//! Structures in TOML: species files, and stacks as flat sections.

use std::path::Path;

use super::kind::{InputKind, kind_of_text};
use super::media::materials;
use super::{parse_stack, read_text};
use crate::error::shortened;
use crate::fields::{Record as _, at_line};
use crate::material::Library;
use crate::scene::description::SceneDescription;
use crate::scene::feather::Feather;
use crate::scene::preset;
use crate::structure::{FlatStack, SpeciesFile, SpeciesModel, Structure};
use crate::{Error, Result};

/// Reads a species file; without a variant its default one.
///
/// # Errors
/// As [`read_species_file`], or no such variant.
pub fn read_species(path: &Path, variant: Option<&str>, library: &Library) -> Result<SpeciesModel> {
    let (file, library) = read_species_file(path, library)?;
    file.model(variant, library).map_err(|error| error.in_file(path))
}

/// Reads a species file with all its variants; also the media that its sections are made of: those of `library` and its own.
///
/// # Errors
/// The file cannot be read, or anything that `docs/formats/species.md` lists; the message names the file, the line and
/// the key.
pub fn read_species_file(path: &Path, library: &Library) -> Result<(SpeciesFile, Library)> {
    let folder = path.parent().unwrap_or(Path::new("."));
    parse_file(&read_text(path)?, folder, library).map_err(|error| error.in_file(path))
}

/// Whether a TOML file is meant as a species: it is neither a lattice nor a stack.
///
/// # Errors
/// The file cannot be read.
pub fn is_species(path: &Path) -> Result<bool> {
    let table: toml::Table = toml::from_str(&read_text(path)?).unwrap_or_default();
    Ok(!is_stack(&table) && (table.contains_key("generator") || !table.contains_key("lattice")))
}

fn is_stack(table: &toml::Table) -> bool {
    ["stack", "layers", "entry", "exit"].iter().any(|key| table.contains_key(*key))
}

fn parse_file(text: &str, folder: &Path, library: &Library) -> Result<(SpeciesFile, Library)> {
    let file = SpeciesFile::parse(text)?;
    let mut library = library.clone();
    let shown = shown_of(&file).map(drop);
    let media = materials(file.materials.as_ref(), folder, &mut library).map(drop);
    media.and(shown).map_err(|error| at_line(error, text))?;
    Ok((file, library))
}

fn parse_species(
    text: &str,
    variant: Option<&str>,
    folder: &Path,
    library: &Library,
) -> Result<SpeciesModel> {
    let (file, library) = parse_file(text, folder, library)?;
    file.model(variant, library)
}

/// The feather that a species file describes in its table `[feather]`, if it has one.
///
/// # Errors
/// An unknown or missing key, or a size out of its range; the message names the key.
pub fn feather_of(file: &SpeciesFile) -> Result<Option<Feather>> {
    file.feather.as_ref().map(|table| Feather::read(table, "feather")).transpose()
}

/// What a species file says about its picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shown {
    /// The preset in which it is shown.
    pub preset: Option<String>,
    /// The feather that bears it.
    pub feather: Option<Feather>,
}

/// What a species file says about its picture.
///
/// # Errors
/// As [`feather_of`]; or no preset of this name, or one that does not show one feather.
pub fn shown_of(file: &SpeciesFile) -> Result<Shown> {
    if let Some(name) = &file.preset {
        preset::toml(name).map_err(|error| error.at("preset"))?;
        if SceneDescription::named(name)?.lone_feather().is_none() {
            return Err(Error::input(format!(
                "preset is '{name}', which shows no feather; give a bird's, as in \"hummingbird\""
            )));
        }
    }
    Ok(Shown { preset: file.preset.clone(), feather: feather_of(file)? })
}

/// What a species file says about its picture, as [`shown_of`] has it.
///
/// # Errors
/// The file cannot be read or is no species; the message names the file and the key.
pub fn read_shown(path: &Path) -> Result<Shown> {
    let text = read_text(path)?;
    let shown =
        SpeciesFile::parse(&text).and_then(|file| shown_of(&file).map_err(|error| at_line(error, &text)));
    shown.map_err(|error| error.in_file(path))
}

/// Reads a structure in TOML: a species, or a stack, which becomes a flat section.
///
/// # Errors
/// As [`read_species`] or [`super::read_stack`]; a lattice alone has a reader of its own, [`super::read_lattice`].
pub fn read_structure_toml(path: &Path, variant: Option<&str>, library: &Library) -> Result<Structure> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let text = read_text(path)?;
    let at = |error: Error| error.in_file(path);
    if kind_of_text(&text) != InputKind::Stack {
        return parse_species(&text, variant, folder, library)
            .map(|m| Structure::Species(Box::new(m)))
            .map_err(at);
    }
    if let Some(variant) = variant {
        return Err(at(Error::input(format!("a stack has no variants, so no '{}'", shortened(variant)))));
    }
    flat_stack(path, &text, library).and_then(FlatStack::structure).map_err(at)
}

/// Reads a stack in TOML as a flat barbule; the file's name without ending is its name. `None`: the file describes no stack,
/// or cannot be read as TOML.
///
/// # Errors
/// The file cannot be read, or as [`super::read_stack`].
pub fn read_flat_stack(path: &Path, library: &Library) -> Result<Option<FlatStack>> {
    let text = read_text(path)?;
    if kind_of_text(&text) != InputKind::Stack {
        return Ok(None);
    }
    flat_stack(path, &text, library).map(Some).map_err(|error| error.in_file(path))
}

fn flat_stack(path: &Path, text: &str, library: &Library) -> Result<FlatStack> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let stack = parse_stack(text, folder, library)?;
    let table: toml::Table = toml::from_str(text).unwrap_or_default();
    let table = table.get("materials").and_then(|value| serde_json::to_value(value).ok());
    let mut library = library.clone();
    let materials = materials(table.as_ref(), folder, &mut library)?;
    let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    Ok(FlatStack { name, stack, library, materials })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::species_toml;

    fn parse(text: &str, variant: Option<&str>) -> Result<SpeciesModel> {
        parse_species(text, variant, Path::new("."), &Library::builtin())
    }

    #[test]
    fn a_key_counts_where_it_stands_or_is_refused() {
        let text = species_toml("starling").unwrap();
        // The variants give it too.
        for value in ["0.200", "200"] {
            let both = text.replace("[parameters]\n", &format!("[parameters]\ncortex_um = {value}\n"));
            let message = parse(&both, None).unwrap_err().to_string();
            let expected = if value == "200" {
                "line 13: parameters.cortex_um is 200, outside 0.001 to 10; did you mean 0.2 (200 nm)?"
            } else {
                "parameters.cortex_um (line 13) has no effect on variant 'aqua', which gives cortex_um too (line 28); keep it in"
            };
            assert!(message.starts_with(expected), "{message}");
        }
        let moved = text.replace("name = \"pink\"\ncortex_um = 0.380", "name = \"pink\"");
        let message = parse(&moved, Some("green")).unwrap_err().to_string();
        assert!(
            message.contains("variants[4].cortex_um is missing; give it here as variant 'aqua' does"),
            "{message}"
        );
        assert!(message.starts_with("line 41: variant pink: "), "{message}");
    }

    #[test]
    fn a_default_without_variants_names_the_line_to_delete() {
        let text = species_toml("starling").unwrap();
        let alone = text[..text.find("# The keratin film, top").unwrap()].to_owned();
        let alone = alone.replace("[parameters]", "[parameters]\ncortex_um = 0.3");
        assert_eq!(
            parse(&alone, None).unwrap_err().to_string(),
            "line 10: default names the variant 'green', but this file has no variants; delete the line"
        );
        let model = parse(&alone.replace("default = \"green\"\n", ""), None).unwrap();
        assert_eq!((model.title().as_str(), model.variant.as_str()), ("starling", "default"));
    }

    #[test]
    fn refusals_name_the_line_of_the_key() {
        let text = species_toml("starling").unwrap();
        for (from, to, expected) in [
            (
                "width_um = 25.0",
                "width_um = 2500.0",
                "line 13: parameters.width_um is 2500, outside 1 to 200; did you mean 2.5",
            ),
            ("width_um = 25.0", "widht_um = 25.0", "line 13: parameters: unknown key 'widht_um'"),
            ("latin =", "latn =", "line 7: unknown key 'latn'"),
            (
                "cortex_um = 0.440",
                "cortex_um = 440",
                "line 55: variants[7].cortex_um is 440, outside 0.001 to 10; did you mean 0.44 (440 nm)?",
            ),
            (
                "core_fraction_low = 0.3",
                "core_fraction_low = 0.9",
                "line 20: variant aqua: parameters.core_fraction_low",
            ),
            (
                "[parameters]",
                "materials = { keratin = 3 }\n[parameters]",
                "line 12: materials.keratin must be",
            ),
        ] {
            let message = parse(&text.replacen(from, to, 1), None).unwrap_err().to_string();
            assert!(message.starts_with(expected), "{message}");
        }
    }

    #[test]
    fn very_many_variants_are_refused_at_once() {
        let text = species_toml("starling").unwrap();
        let more: String =
            (0..50_000).map(|i| format!("[[variants]]\nname = \"v{i}\"\ncortex_um = 0.3\n")).collect();
        let message = parse(&(text.to_owned() + "\n" + &more), None).unwrap_err().to_string();
        assert!(message.contains("variants: there are 50008, over the limit of 1000"), "{message}");
    }

    #[test]
    fn a_copied_and_edited_species_works() {
        let text = species_toml("starling").unwrap().replace("thickness_um = 4.0", "thickness_um = 5.0");
        let model = parse(&text, Some("pink")).unwrap();
        let section = model.section(1, 0).unwrap();
        let bottom = section.boundaries.last().unwrap();
        let mean = bottom.z_um.iter().sum::<f64>() / bottom.z_um.len() as f64;
        assert!((mean + 5.0).abs() < 1e-12);
        assert_eq!(parse(species_toml("starling").unwrap(), None).unwrap().variant, "green");
    }

    #[test]
    fn materials_of_a_species_file_take_the_place_of_the_built_in_ones() {
        let text = format!("{}\n[materials]\nkeratin = [1.6, 0.0]\n", species_toml("starling").unwrap());
        let model = parse(&text, None).unwrap();
        assert_eq!(model.library.get("keratin").unwrap().index(500.0).unwrap(), 1.6.into());
        assert_ne!(
            Structure::Species(Box::new(model)).hash(),
            Structure::Species(Box::new(parse(species_toml("starling").unwrap(), None).unwrap())).hash()
        );
    }

    /// A preset's feather, as a species file may bring it.
    fn with_feather() -> String {
        let preset = crate::scene::preset::toml("starling").unwrap();
        let feather = &preset[preset.find("[feather.shaft]").unwrap()..];
        format!("{}\n{feather}", species_toml("starling").unwrap())
    }

    #[test]
    fn the_feather_of_a_species_file_is_read_and_checked() {
        let text = with_feather();
        assert_eq!(parse(&text, None).unwrap(), parse(species_toml("starling").unwrap(), None).unwrap());
        let feather = feather_of(&SpeciesFile::parse(&text).unwrap()).unwrap().unwrap();
        assert_eq!((feather.distal.length_um, feather.barbs.spacing_um), (295.0, 200.0));
        assert_eq!(feather_of(&SpeciesFile::builtin("starling").unwrap()).unwrap(), None);
        for (good, bad, expected) in [
            ("length_um = 295.0", "length_um = -1.0", "feather.distal.length_um is -1, outside 5 to 10000"),
            ("length_um = 295.0", "length_mm = 0.28", "unknown key 'length_mm', did you mean 'length_um'?"),
            ("[feather.barbs]", "[feather.barb]", "unknown key 'barb', did you mean 'barbs'?"),
            ("calamus_share = 0.12", "calamus_share = 'a'", "feather.shaft.calamus_share is the text 'a'"),
        ] {
            let line = text.lines().find(|line| line.starts_with(good)).unwrap();
            let message = parse(&text.replacen(line, bad, 1), None).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn a_species_file_says_in_which_scene_it_is_shown() {
        let with = |preset: &str| {
            let text = species_toml("starling").unwrap();
            text.replacen("generator =", &format!("preset = \"{preset}\"\ngenerator ="), 1)
        };
        let file = SpeciesFile::parse(&with("hummingbird")).unwrap();
        assert_eq!(shown_of(&file).unwrap().preset.as_deref(), Some("hummingbird"));
        assert_eq!(
            parse(&with("hummingbird"), None).unwrap(),
            parse(species_toml("starling").unwrap(), None).unwrap()
        );
        let flat = file.flat_toml(None).unwrap();
        assert_eq!(SpeciesFile::parse(&flat).unwrap().preset.as_deref(), Some("hummingbird"));
        for (preset, expected) in [
            ("hummingbrd", "preset: there is no preset 'hummingbrd', did you mean 'hummingbird'?"),
            ("hummingbird:anna", "preset: there is no preset 'hummingbird:anna'"),
            ("snake", "preset is 'snake', which shows no feather"),
        ] {
            let message = parse(&with(preset), None).unwrap_err().to_string();
            assert!(message.starts_with("line 6: ") && message.contains(expected), "{message}");
        }
    }

    /// The species, what is replaced in its file, by what, and what the refusal must say.
    const BAD: &[(&str, &str, &str, &str)] = &[
        ("starling", "barbule = 1", "", "barbule is missing"),
        ("starling", "barbule = 1", "barbule = 3", "reads format 1 only"),
        ("starling", "barbule = 1", "barbule = ", "line 4 is not TOML"),
        ("starling", "name = \"starling\"", "", "name is missing"),
        ("starling", "name = \"starling\"", "name = \"\"", "name must be one line"),
        ("starling", "name = \"starling\"", "name = 3", "name is the number 3"),
        ("starling", "generator = \"starling\"", "", "generator is missing"),
        ("starling", "generator = \"starling\"", "generator = \"starlin\"", "did you mean 'starling'"),
        ("starling", "generator = \"starling\"", "generator = \"bronzewing\"", "unknown key 'thickness_um'"),
        ("starling", "default = \"green\"", "default = \"grey\"", "no variant 'grey', did you mean 'green'?"),
        ("starling", "latin =", "latn =", "did you mean 'latin'"),
        ("starling", "[parameters]", "[parameter]", "unknown key 'parameter', did you mean 'parameters'?"),
        ("starling", "width_um = 25.0", "width_um = 0.0", "parameters.width_um is 0, outside 1 to 200"),
        ("starling", "width_um = 25.0", "width_um = inf", "width_um is not a finite number"),
        ("starling", "width_um = 25.0", "width_um = nan", "width_um is not a finite number"),
        ("starling", "width_um = 25.0", "width_um = \"25\"", "width_um is the text '25'"),
        ("starling", "width_um = 25.0", "widht_um = 25.0", "did you mean 'width_um'"),
        ("starling", "width_um = 25.0", "", "parameters.width_um is missing; give a number from 1 to 200"),
        (
            "starling",
            "core_fraction_low = 0.3",
            "core_fraction_low = 0.9",
            "above core_fraction_high, 0.7; swap them",
        ),
        ("starling", "core_fraction_high = 0.7", "core_fraction_high = 1.7", "outside 0 to 1"),
        (
            "starling",
            "cortex_um = 0.440",
            "cortex_nm = 440",
            "variants[7]: unknown key 'cortex_nm', did you mean 'cortex_um'?",
        ),
        ("starling", "name = \"teal\"", "name = \"aqua\"", "variants[7].name is 'aqua' a second time"),
        ("starling", "name = \"teal\"", "name = \"a b\"", "variants[7].name must be a text"),
        ("starling", "name = \"teal\"", "", "variants[7].name is missing"),
        ("starling", "[parameters]", "[lattice]\n[parameters]", "a lattice alone"),
        ("starling", "point_spacing_um = 0.03", "point_spacing_um = 1e-9", "outside 0.005 to 1"),
        (
            "rock-dove",
            "arc_low_deg = 30.0",
            "arc_low_deg = 80.0",
            "arc_low_deg is 80, above arc_high_deg, 75",
        ),
        ("rock-dove", "gap_low_um = 0.25", "gap_low_um = 0.85", "above gap_high_um"),
        ("rock-dove", "slope_high_deg = 30.0", "slope_high_deg = 90.0", "outside 0 to 60"),
        ("bronzewing", "rows = 6 ", "rows = 6.5 ", "rows is 6.5, but must be a whole number"),
        ("bronzewing", "rows = 6 ", "rows = 0 ", "rows is 0, outside 1 to 40"),
        ("bronzewing", "spacing_um = 0.063", "spacing_um = 0.005", "touch those of the next layer"),
        ("hummingbird", "width_um = 40.0", "width_um = 3.0", "too narrow for one melanosome"),
        (
            "hummingbird",
            "melanosome_length_um = 2.0",
            "melanosome_length_um = 0.06",
            "under half as long as thick",
        ),
        ("hummingbird", "coverage = 0.90", "coverage = 1.0", "coverage is 1, outside 0.05 to 0.99"),
    ];

    #[test]
    fn bad_species_are_refused_each_with_its_key_and_remedy() {
        for (species, good, bad, expected) in BAD {
            let text = species_toml(species).unwrap();
            assert!(text.contains(good), "{good}");
            let error = parse(&text.replacen(good, bad, 1), None).expect_err(bad);
            let message = error.to_string();
            assert!(error.is_input() && message.contains(expected), "{bad}\n{message}\nexpected: {expected}");
            assert!(message.len() < 600 && !message.contains('\n'), "{message}");
        }
    }

    #[test]
    fn more_bubbles_than_a_section_holds_are_refused_before_they_are_made() {
        let text = species_toml("hummingbird").unwrap();
        let text =
            text.replace("width_um = 40.0", "width_um = 200.0").replace("layers = 12 ", "layers = 60 ");
        assert!(parse(&text, None).unwrap_err().to_string().contains("bubbles, over the limit"));
    }

    #[test]
    fn parameters_without_room_are_refused_with_the_place_where_regions_meet() {
        let text = species_toml("starling").unwrap().replace("thickness_um = 4.0", "thickness_um = 0.5");
        let message = parse(&text, None).unwrap().section(1, 0).unwrap_err().to_string();
        assert!(message.contains("too little room") && message.contains("µm"), "{message}");
    }
}
