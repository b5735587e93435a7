//! Structures as people type them.

use std::path::Path;

use super::{Opening, unknown};
use crate::error::shortened;
use crate::io::{
    InputKind, kind_of, read_flat_stack, read_lattice, read_section, read_sections, read_stack,
    read_structure_toml,
};
use crate::material::Library;
use crate::progress::Progress;
use crate::stack::Stack;
use crate::structure::{FlatStack, Lattice, Section, Side, SpeciesModel, Structure, species_name};
use crate::{Error, Result};

/// A stack of the stack language or, where the text ends in `.toml`, of that file.
///
/// # Errors
/// Neither; a medium that is unknown or a layer without sense.
pub fn stack(text: &str, library: &Library) -> Result<Stack> {
    let path = Path::new(text);
    if path.extension().is_some_and(|end| end.eq_ignore_ascii_case("toml")) {
        return read_stack(path, library);
    }
    Stack::parse(text, library).map_err(|error| {
        if path.exists() {
            return Error::input(format!(
                "{text}: is not a stack; files with stacks are TOML and end in .toml"
            ));
        }
        error
    })
}

/// As [`stack`], where formats of flat films are made: barbules are told what has them.
///
/// # Errors
/// As there, or the name of a bird or of a material's file.
pub fn film_stack(text: &str, library: &Library) -> Result<Stack> {
    let is_material = Path::new(text).extension().is_some_and(|end| end.eq_ignore_ascii_case("barbule"));
    if is_built_in(text) || is_material {
        return Err(Error::input(format!(
            "{}: glTF and OpenPBR have flat films and no barbules; export these as bsdf, osl or mitsuba, or give a stack of one film, as in air/keratin:595/air",
            shortened(text)
        )));
    }
    stack(text, library)
}

/// Whether a text is the name of a built-in species, or of a variant of one, there or not. Such a name never means a file.
#[must_use]
pub fn is_built_in(text: &str) -> bool {
    let text = text.strip_suffix(Side::BELOW).unwrap_or(text);
    let name = text.split_once(':').map_or(text, |(name, _)| name);
    species_name(name).is_ok()
}

/// Opens a structure: `SPECIES[:VARIANT]`, a file by what is in it, `FILE.toml[:VARIANT]`, a folder of sections, or a stack;
/// a stack or lattice alone lies flat. ` (below)` behind any of them means its lower side, as names of materials say it.
/// Built-in names come first, whatever files and folders are called. `progress` is told what is doubtful.
///
/// # Errors
/// An unknown name (the nearest known one is offered), a file that is missing or not of such a kind, or one that
/// describes no valid structure.
///
/// ```
/// use barbule::Unobserved;
/// use barbule::open::{Opening, structure};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let file = folder.path().join("mine.toml");
/// std::fs::write(&file, "stack = \"air/keratin:320±5%/melanin\"")?;
/// let mine = structure(&file.to_string_lossy(), &Opening::default(), &Unobserved)?;
/// assert_eq!(mine.instance(1, 7)?.media.len(), 3);
///
/// let lower = structure("starling:pink (below)", &Opening::default(), &Unobserved)?;
/// assert_eq!(lower.name(), "starling:pink (below)");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn structure(text: &str, opening: &Opening, progress: &dyn Progress) -> Result<Structure> {
    if let Some(upper) = text.strip_suffix(Side::BELOW) {
        let upper = structure(upper, opening, progress)?;
        return upper.underside().map_err(|error| error.at(shortened(text)));
    }
    let library = opening.media.library();
    let (name, variant) = text.split_once(':').map_or((text, None), |(name, variant)| (name, Some(variant)));
    let species = || {
        SpeciesModel::builtin(name, variant, library.clone()).map(|model| Structure::Species(Box::new(model)))
    };
    if is_built_in(text) {
        return species();
    }
    let path = Path::new(text);
    let ends_with = |text: &str, end: &str| text.to_lowercase().ends_with(end);
    if !path.exists() && unknown::is_file_name(text) {
        return Err(unknown::no_file(text));
    }
    if ends_with(text, ".json") || ends_with(text, ".toml") || path.exists() {
        return in_file(text, opening, progress);
    }
    if let Some((file, variant)) = text.rsplit_once(':').filter(|(file, _)| ends_with(file, ".toml")) {
        return read_structure_toml(Path::new(file), Some(variant), library);
    }
    if !text.contains('/') {
        return species();
    }
    if text.ends_with('/') {
        return Err(Error::input("no such folder").of_file(path).at(shortened(text)));
    }
    flat(FlatStack::parse(text, library.clone())?, opening, progress)
}

/// A stack as a flat barbule.
fn flat(mut flat: FlatStack, opening: &Opening, progress: &dyn Progress) -> Result<Structure> {
    if let Some(doubt) = flat.stack.doubt() {
        progress.doubt(&doubt);
    }
    opening.media.remember_in_stack(&mut flat);
    flat.structure()
}

/// The structure of a file or folder, by what is in it.
fn in_file(text: &str, opening: &Opening, progress: &dyn Progress) -> Result<Structure> {
    let (path, library) = (Path::new(text), opening.media.library());
    let ends_with = |end: &str| text.to_lowercase().ends_with(end);
    let given = |name: String, mut sections: Vec<Section>| {
        opening.media.remember_in(&mut sections);
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
            Some(stack) => flat(stack, opening, progress),
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

/// What a file is that is no structure.
fn no_structure(text: &str, kind: InputKind) -> Error {
    let what = match kind {
        InputKind::Material => "is a material, made from a structure already",
        InputKind::Scene => "is a scene",
        InputKind::Store => "is a campaign store",
        _ => "is no structure; sections are .json files, species, stacks and lattices .toml files",
    };
    Error::input(what).of_file(Path::new(text)).at(shortened(text))
}

/// Opens a photonic crystal: that of any structure that has one.
///
/// # Errors
/// As [`structure`], or a structure that is no photonic crystal.
pub fn lattice(text: &str, opening: &Opening, progress: &dyn Progress) -> Result<Lattice> {
    lattice_of(&structure(text, opening, progress)?)
}

/// The photonic crystal of a structure.
///
/// # Errors
/// It has none.
pub fn lattice_of(structure: &Structure) -> Result<Lattice> {
    structure.lattice().ok_or_else(|| {
        Error::input(format!(
            "{} is made of layers, not of a photonic crystal; give mallard, magpie, peafowl, or a file with a [lattice]",
            structure.name()
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Unobserved;
    use crate::io::write_section;
    use crate::structure::species_toml;

    fn opened(text: &str) -> Result<Structure> {
        structure(text, &Opening::default(), &Unobserved)
    }

    fn refusal(text: &str) -> String {
        let error = opened(text).unwrap_err();
        assert!(error.is_input() && error.to_string().len() < 600, "{error}");
        error.to_string()
    }

    #[test]
    fn every_kind_of_structure_is_found() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(opened("starling").unwrap().name(), "starling:green");
        assert_eq!(opened("rock-dove:purple").unwrap().name(), "rock-dove:purple");
        let flat = opened("air/keratin:595/air").unwrap();
        assert_eq!((flat.count(), flat.width_um()), (Some(1), 25.0));
        let path = folder.path().join("mine.toml");
        std::fs::write(&path, species_toml("bronzewing").unwrap()).unwrap();
        let text = path.to_string_lossy().into_owned();
        assert_eq!(opened(&text).unwrap().name(), "bronzewing:green");
        assert_eq!(opened(&format!("{text}:pink")).unwrap().name(), "bronzewing:pink");
        let stack = folder.path().join("stack.toml");
        std::fs::write(&stack, "stack = 'air/keratin:595/air'").unwrap();
        assert_eq!(opened(&stack.to_string_lossy()).unwrap().count(), Some(1));
        for k in 0..3 {
            let section = flat.instance(1, 0).unwrap();
            write_section(&folder.path().join(format!("{k}.json")), &section).unwrap();
        }
        assert_eq!(opened(&folder.path().to_string_lossy()).unwrap().count(), Some(3));
        let one = folder.path().join("1.json");
        assert_eq!(opened(&one.to_string_lossy()).unwrap().count(), Some(1));
    }

    #[test]
    fn crystals_are_species_or_files() {
        let folder = tempfile::tempdir().unwrap();
        let lattice = |text: &str| lattice(text, &Opening::default(), &Unobserved);
        assert_eq!(lattice("magpie").unwrap().rows, 3);
        assert_eq!(lattice("peafowl:yellow").unwrap().placed().count(), 11);
        let path = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path.to_string_lossy().into_owned()
        };
        let species = path("duck.toml", species_toml("mallard").unwrap());
        assert_eq!(lattice(&format!("{species}:blue")).unwrap().period_um, 0.17);
        let alone = path(
            "alone.toml",
            "[lattice]\nperiod = 0.2\ncortex = 0.1\n[[lattice.rod]]\ncircles = [{ diameter = 0.1, medium = 'melanin' }]",
        );
        assert_eq!(lattice(&alone).unwrap().rows, 1);
        for none in ["starling", "air/keratin:500/air"] {
            assert!(lattice(none).unwrap_err().to_string().contains("[lattice]"), "{none}");
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
        assert!(refusal("nowhere.tml").contains("nowhere.tml: no such file"));
        assert!(refusal("nowhere/").contains("no such folder"));
        assert!(refusal("air/keratine:5/air").contains("did you mean 'keratin'"));
        assert!(refusal(&other.to_string_lossy()).contains("is no structure"));
        assert!(refusal(&folder.path().to_string_lossy()).contains("no .json file"));
    }

    #[test]
    fn thicknesses_that_look_like_micrometres_are_doubted() {
        #[derive(Default)]
        struct Doubts(std::sync::Mutex<Vec<String>>);
        impl Progress for Doubts {
            fn begin(&self, _: &str, _: u64) {}
            fn advance(&self, _: u64) {}
            fn is_cancelled(&self) -> bool {
                false
            }
            fn doubt(&self, what: &str) {
                self.0.lock().unwrap().push(what.to_owned());
            }
        }
        let doubts = Doubts::default();
        structure("air/keratin:0.3/air", &Opening::default(), &doubts).unwrap();
        structure("air/keratin:300/air", &Opening::default(), &doubts).unwrap();
        let said = doubts.0.into_inner().unwrap();
        assert_eq!(said, ["keratin:0.3 is 0.3 nm thick; thicknesses are in nm: did you mean 300?"]);
    }
}
