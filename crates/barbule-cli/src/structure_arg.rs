//! STRUCTURE as people type it: a stack, a species, a file, or a folder of sections.

use std::path::Path;

use barbule::error::shortened;
use barbule::io::{
    InputKind, kind_of, read_flat_stack, read_lattice, read_section, read_sections, read_structure_toml,
};
use barbule::material::Library;
use barbule::structure::{
    FlatStack, Lattice, MaterialSource, Section, Side, SpeciesModel, Structure, Substance, species_name,
};
use barbule::{Error, Result};
use clap::ValueEnum;

use crate::common::Common;
use crate::media;
use crate::provenance::quoted;

/// What every STRUCTURE argument says in `--help`.
pub const HELP: &str = "A stack as in 'air/keratin:595/air', SPECIES[:VARIANT], a section .json, a species or lattice .toml, or a folder of sections; with ' (below)' behind it its lower side";

/// Which side of the barbules is lit.
#[derive(Debug, Clone, Copy, clap::Args)]
pub(crate) struct SideArg {
    /// The side that is lit: below is each barbule turned upside down, by 180° about its long axis
    #[arg(long, value_enum, default_value_t = Lit::Above)]
    side: Lit,
}

/// Sides of barbules.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Lit {
    /// The upper one
    Above,
    /// The lower one
    Below,
}

impl SideArg {
    /// The structure as it is lit.
    ///
    /// # Errors
    /// It has no lower side that can be simulated.
    pub(crate) fn of(self, structure: Structure) -> Result<Structure> {
        match self.side {
            Lit::Above => Ok(structure),
            Lit::Below => structure.underside().map_err(|error| error.at("--side below")),
        }
    }
}

/// Whether a text is the name of a built-in species, or of a variant of one, there or not. Such a name never means a file.
pub(crate) fn is_built_in(text: &str) -> bool {
    let text = text.strip_suffix(Side::BELOW).unwrap_or(text);
    let name = text.split_once(':').map_or(text, |(name, _)| name);
    species_name(name).is_ok()
}

/// Finds a structure and says which `--medium` it does without: `SPECIES[:VARIANT]`, a file by what is in it,
/// `FILE.toml[:VARIANT]`, a folder of sections, or a stack; a stack or lattice alone lies flat. ` (below)` behind any of
/// them means its lower side, as names of materials say it. Built-in names come first, whatever files and folders are
/// called.
///
/// # Errors
/// An unknown name (the nearest known one is offered), a file that is missing or not of such a kind, or one that
/// describes no valid structure.
pub fn parse(text: &str, common: &Common) -> Result<Structure> {
    let structure = read(text, common)?;
    media::say_unused(&structure, common);
    Ok(structure)
}

fn read(text: &str, common: &Common) -> Result<Structure> {
    if let Some(upper) = text.strip_suffix(Side::BELOW) {
        return read(upper, common)?.underside().map_err(|error| error.at(shortened(text)));
    }
    let library = common.library()?;
    let (name, variant) = text.split_once(':').map_or((text, None), |(name, variant)| (name, Some(variant)));
    let species = |library| {
        SpeciesModel::builtin(name, variant, library).map(|model| Structure::Species(Box::new(model)))
    };
    if is_built_in(text) {
        return species(library);
    }
    let path = Path::new(text);
    let ends_with = |text: &str, end: &str| text.to_lowercase().ends_with(end);
    if ends_with(text, ".json") || ends_with(text, ".toml") || path.exists() {
        return in_file(text, common, &library);
    }
    if let Some((file, variant)) = text.rsplit_once(':').filter(|(file, _)| ends_with(file, ".toml")) {
        return read_structure_toml(Path::new(file), Some(variant), &library);
    }
    if !text.contains('/') {
        return species(library);
    }
    if text.ends_with('/') {
        return Err(Error::input(format!("{}: no such folder", shortened(text))));
    }
    flat(FlatStack::parse(text, library)?, common)
}

/// A stack as a flat barbule; says what is doubtful about it.
fn flat(mut flat: FlatStack, common: &Common) -> Result<Structure> {
    if let Some(doubt) = flat.stack.doubt() {
        common.say(&doubt);
    }
    let regions = 0..flat.stack.layers() + 2;
    for (name, source) in given_media(common) {
        if regions.clone().any(|region| flat.stack.medium(region).contains(&name)) {
            flat.materials.entry(name).or_insert(source);
        }
    }
    flat.structure()
}

/// The structure of a file or folder, by what is in it.
fn in_file(text: &str, common: &Common, library: &Library) -> Result<Structure> {
    let path = Path::new(text);
    let ends_with = |end: &str| text.to_lowercase().ends_with(end);
    let given = |name: String, mut sections: Vec<Section>| {
        remember_media(&mut sections, common);
        Ok(Structure::Sections { name, sections })
    };
    match kind_of(path)? {
        InputKind::Lattice => {
            let section = Section::flat_crystal(text, read_lattice(path, library)?)?;
            Ok(Structure::Sections { name: text.to_owned(), sections: vec![section] })
        }
        InputKind::Folder if !ends_with(".json") && !ends_with(".toml") => {
            given(text.to_owned(), read_sections(path, library)?)
        }
        InputKind::Stack => match read_flat_stack(path, library)? {
            Some(stack) => flat(stack, common),
            None => Err(no_structure(text, InputKind::Other)),
        },
        InputKind::Species => read_structure_toml(path, None, library),
        // What is no valid file of its kind is refused by the reader of that kind.
        kind @ (InputKind::Section | InputKind::Folder | InputKind::Table | InputKind::Other)
            if kind == InputKind::Section || ends_with(".json") =>
        {
            let section = read_section(path, library)?;
            given(section.name.clone(), vec![section])
        }
        InputKind::Folder | InputKind::Table | InputKind::Other if ends_with(".toml") => {
            read_structure_toml(path, None, library)
        }
        kind => Err(no_structure(text, kind)),
    }
}

/// What a file is that is no structure, and what to do with it.
fn no_structure(text: &str, kind: InputKind) -> Error {
    let text = shortened(text);
    Error::input(match kind {
        InputKind::Material => {
            format!("{text}: is a material, made from a structure already; render and lobes take it")
        }
        InputKind::Scene => {
            format!("{text}: is a scene; draw it with `barbule render {} -o picture.png`", quoted(&text))
        }
        InputKind::Store => {
            format!(
                "{text}: is a campaign store; make its material with `barbule fit {} -o material.barbule`",
                quoted(&text)
            )
        }
        _ => format!(
            "{text}: is no structure; sections are .json files, species, stacks and lattices .toml files"
        ),
    })
}

/// Finds a photonic crystal: that of any structure that has one.
///
/// # Errors
/// As [`parse`], or a structure that is no photonic crystal.
pub(crate) fn lattice(text: &str, common: &Common) -> Result<Lattice> {
    let structure = parse(text, common)?;
    structure.lattice().ok_or_else(|| {
        Error::input(format!("{} is made of layers, not of a photonic crystal; {LATTICES}", structure.name()))
    })
}

const LATTICES: &str = "give mallard, magpie, peafowl, or a file with a [lattice]";

/// Keeps the files of `--medium` with sections that name them, so that a written section finds them again.
fn remember_media(sections: &mut [Section], common: &Common) {
    for (name, source) in given_media(common) {
        for section in &mut *sections {
            let named = |s: &Substance| matches!(s, Substance::Named(text) if text.contains(&name));
            if section.all_media().flat_map(|medium| medium.substances()).any(named) {
                section.materials.entry(name.clone()).or_insert(source.clone());
            }
        }
    }
}

/// The names and files of `--medium`.
fn given_media(common: &Common) -> impl Iterator<Item = (String, MaterialSource)> {
    common.medium.iter().filter_map(|given| {
        let (name, file) = given.split_once('=')?;
        let path = std::path::absolute(file).unwrap_or_else(|_| file.into());
        Some((name.trim().to_owned(), MaterialSource::File(path)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        common: Common,
    }

    fn common(words: &[&str]) -> Common {
        Line::try_parse_from(std::iter::once(&"x").chain(words)).unwrap().common
    }

    fn refusal(text: &str) -> String {
        let error = parse(text, &common(&[])).unwrap_err();
        assert!(error.is_input() && error.to_string().len() < 600, "{error}");
        error.to_string()
    }

    #[test]
    fn every_kind_of_structure_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let usual = common(&[]);
        assert_eq!(parse("starling", &usual).unwrap().name(), "starling:green");
        assert_eq!(parse("rock-dove:purple", &usual).unwrap().name(), "rock-dove:purple");
        let flat = parse("air/keratin:595/air", &usual).unwrap();
        assert_eq!((flat.count(), flat.width_um()), (Some(1), 25.0));
        let path = folder.path().join("mine.toml");
        std::fs::write(&path, barbule::structure::species_toml("bronzewing").unwrap()).unwrap();
        let text = path.to_string_lossy().into_owned();
        assert_eq!(parse(&text, &usual).unwrap().name(), "bronzewing:green");
        assert_eq!(parse(&format!("{text}:pink"), &usual).unwrap().name(), "bronzewing:pink");
        let stack = folder.path().join("stack.toml");
        std::fs::write(&stack, "stack = 'air/keratin:595/air'").unwrap();
        assert_eq!(parse(&stack.to_string_lossy(), &usual).unwrap().count(), Some(1));
        for k in 0..3 {
            let section = flat.instance(1, 0).unwrap();
            barbule::io::write_section(&folder.path().join(format!("{k}.json")), &section).unwrap();
        }
        assert_eq!(parse(&folder.path().to_string_lossy(), &usual).unwrap().count(), Some(3));
        let one = folder.path().join("1.json");
        assert_eq!(parse(&one.to_string_lossy(), &usual).unwrap().count(), Some(1));
    }

    #[test]
    fn crystals_are_species_or_files() {
        let folder = tempfile::tempdir().unwrap();
        let usual = common(&[]);
        assert_eq!(lattice("magpie", &usual).unwrap().rows, 3);
        assert_eq!(lattice("peafowl:yellow", &usual).unwrap().placed().count(), 11);
        let path = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path.to_string_lossy().into_owned()
        };
        let species = path("duck.toml", barbule::structure::species_toml("mallard").unwrap());
        assert_eq!(lattice(&format!("{species}:blue"), &usual).unwrap().period_um, 0.17);
        let alone = path(
            "alone.toml",
            "[lattice]\nperiod = 0.2\ncortex = 0.1\n[[lattice.rod]]\ncircles = [{ diameter = 0.1, medium = 'melanin' }]",
        );
        assert_eq!(lattice(&alone, &usual).unwrap().rows, 1);
        for none in ["starling", "air/keratin:500/air"] {
            assert!(lattice(none, &usual).unwrap_err().to_string().contains("[lattice]"), "{none}");
        }
    }

    #[test]
    fn what_is_no_structure_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let other = folder.path().join("a.txt");
        std::fs::write(&other, "x").unwrap();
        assert!(refusal("starlign").contains("did you mean 'starling'"));
        assert!(refusal("starling:grean").contains("did you mean 'green'"));
        assert!(refusal("mallard:pink").contains("no variant 'pink'"));
        assert!(refusal("nowhere.json").contains("no such file"));
        assert!(refusal("nowhere.toml").contains("no such file"));
        assert!(refusal("nowhere/").contains("no such folder"));
        assert!(refusal("air/keratine:5/air").contains("did you mean 'keratin'"));
        assert!(refusal(&other.to_string_lossy()).contains("is no structure"));
        assert!(refusal(&folder.path().to_string_lossy()).contains("no .json file"));
    }
}
