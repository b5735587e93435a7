//! What is swept: species and stacks with sizes that have names.

use std::path::Path;

use serde_json::{Map, Value};

use super::plan::no_key;
use crate::error::shortened;
use crate::fields::{Key, Kind};
use crate::inverse;
use crate::io::read_flat_stack;
use crate::open::{Opening, structure, subject};
use crate::progress::Progress;
use crate::structure::{
    FlatStack, GeneratorParameters, MaterialSource, SpeciesFile, SpeciesModel, Structure,
};
use crate::{Error, Result};

/// Layers of stacks, nm.
const THICKNESS_NM: [f64; 2] = [0.0, 100_000.0];

/// A size that can be swept.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Size {
    /// What it is.
    pub(super) about: String,
    /// Its unit as units libraries read it, `um`, `nm`, `degree`; empty for pure numbers.
    pub(super) unit: String,
    /// From where to where it may go.
    pub(super) range: [f64; 2],
    /// Whether it is a whole number.
    pub(super) whole: bool,
}

/// A structure whose sizes have names.
#[derive(Debug, Clone)]
pub(super) enum Subject {
    /// A variant of a species, and its file.
    Species { file: Box<SpeciesFile>, model: Box<SpeciesModel> },
    /// A stack of flat layers.
    Stack(Box<FlatStack>),
}

impl Subject {
    /// Opens a species or a stack.
    pub(super) fn open(text: &str, opening: &Opening, progress: &dyn Progress) -> Result<Self> {
        let library = opening.media.library();
        let refuse = |what: &str| Err(Error::input(format!("{} {what}", shortened(text))));
        match structure(text, opening, progress)? {
            Structure::Species(_) => match subject(text, library)? {
                inverse::Subject::Species { file, model } => Ok(Self::Species { file, model }),
                inverse::Subject::Lattice(_) => {
                    refuse("is a lattice; give a species that has one, as in mallard")
                }
            },
            Structure::Below(_) => {
                refuse("is a lower side, which atlases do not sweep; give the structure itself")
            }
            Structure::Stack(flat) => Ok(Self::Stack(flat)),
            Structure::Sections { .. } => {
                let path = Path::new(text);
                let flat = match path.exists() {
                    true if path.is_dir() => None,
                    true => read_flat_stack(path, library)?,
                    false => FlatStack::parse(text, library.clone()).ok(),
                };
                let Some(mut flat) = flat else {
                    return refuse(
                        "has no sizes with names; give a species, a stack, or the .toml file of either",
                    );
                };
                opening.media.remember_in_stack(&mut flat);
                Ok(Self::Stack(Box::new(flat)))
            }
        }
    }

    /// What it is called.
    pub(super) fn name(&self) -> String {
        match self {
            Self::Species { model, .. } => model.title(),
            Self::Stack(flat) => flat.name.clone(),
        }
    }

    /// A size by its key.
    ///
    /// # Errors
    /// There is none; the nearest is offered.
    pub(super) fn size(&self, name: &str) -> Result<Size> {
        match self {
            Self::Species { file, .. } => {
                let keys = GeneratorParameters::keys(&file.generator)?;
                let numbers = || keys.iter().filter(|key| matches!(key.kind, Kind::Number { .. }));
                match numbers().find(|key| key.name == name).map(|key| (key, &key.kind)) {
                    Some((key, &Kind::Number { low, high, whole })) => {
                        Ok(Size { about: about(key), unit: unit(key).to_owned(), range: [low, high], whole })
                    }
                    _ => {
                        let known: Vec<String> = numbers().map(|key| key.name.to_owned()).collect();
                        Err(no_key(&self.name(), name, &known))
                    }
                }
            }
            Self::Stack(flat) => {
                let layer = layer(name, flat.stack.layers()).ok_or_else(|| {
                    let known: Vec<String> = (1..=flat.stack.layers()).map(|n| format!("layer{n}")).collect();
                    no_key(&self.name(), name, &known)
                })?;
                let about = format!("thickness of layer {}, {}", layer + 1, flat.stack.medium(layer + 1));
                Ok(Size { about, unit: "nm".into(), range: THICKNESS_NM, whole: false })
            }
        }
    }

    /// The same with other sizes.
    ///
    /// # Errors
    /// A size that it does not have or that is out of its range, or sizes that make no structure.
    pub(super) fn with(&self, sizes: &[(String, f64)]) -> Result<Self> {
        match self {
            Self::Species { file, model } => {
                let keys = GeneratorParameters::keys(&file.generator)?;
                let is_whole = |name: &str| {
                    keys.iter()
                        .any(|key| key.name == name && matches!(key.kind, Kind::Number { whole: true, .. }))
                };
                let value = |(name, size): &(String, f64)| match is_whole(name) && size.fract() == 0.0 {
                    true => Value::from(*size as i64),
                    false => Value::from(*size),
                };
                let changes: Vec<(&str, Value)> =
                    sizes.iter().map(|size| (size.0.as_str(), value(size))).collect();
                let model = Box::new(model.with_parameters(&changes)?);
                Ok(Self::Species { file: file.clone(), model })
            }
            Self::Stack(flat) => {
                let mut stack = flat.stack.clone();
                for (name, nm) in sizes {
                    let index = layer(name, stack.layers())
                        .ok_or_else(|| Error::input(format!("{} has no {name}", shortened(&flat.name))))?;
                    stack = stack.with_thickness(index, *nm)?;
                }
                let name = stack.text();
                Ok(Self::Stack(Box::new(FlatStack { name, stack, ..(**flat).clone() })))
            }
        }
    }

    /// What is simulated.
    ///
    /// # Errors
    /// As [`FlatStack::structure`].
    pub(super) fn structure(&self) -> Result<Structure> {
        match self {
            Self::Species { model, .. } => Ok(Structure::Species(model.clone())),
            Self::Stack(flat) => (**flat).clone().structure(),
        }
    }

    /// The text of a file of it.
    ///
    /// # Errors
    /// What the format cannot write.
    pub(super) fn toml(&self) -> Result<String> {
        match self {
            Self::Species { file, model } => {
                let parameters = serde_json::to_value(&model.parameters)
                    .map_err(|error| Error::machine(format!("parameters cannot be written: {error}")))?;
                let mut values = match parameters {
                    Value::Object(values) => values,
                    _ => Map::new(),
                };
                values.remove("generator");
                file.flat_toml_of(Some(&model.variant), &values)
            }
            Self::Stack(flat) => {
                let mut table = toml::Table::new();
                table.insert("stack".into(), flat.stack.text().into());
                let source = |source: &MaterialSource| match source {
                    MaterialSource::File(path) => toml::Value::from(path.to_string_lossy().into_owned()),
                    MaterialSource::Index(n) => toml::Value::from(vec![n.re, n.im]),
                };
                let media: toml::Table =
                    flat.materials.iter().map(|(name, of)| (name.clone(), source(of))).collect();
                if !media.is_empty() {
                    table.insert("materials".into(), media.into());
                }
                toml::to_string(&table).map_err(|e| Error::input(format!("cannot be written as TOML: {e}")))
            }
        }
    }
}

/// The layer, from 0, that `layer1` and so on name.
fn layer(name: &str, layers: usize) -> Option<usize> {
    // One name for each: neither `layer01` nor `layer+1`.
    let digits =
        name.strip_prefix("layer").filter(|digits| digits.starts_with(|c: char| ('1'..='9').contains(&c)))?;
    let number: usize = digits.parse().ok()?;
    (number <= layers).then(|| number - 1)
}

/// A key's unit as units libraries read it.
fn unit(key: &Key) -> &'static str {
    match key.unit() {
        "µm" => "um",
        "°" => "degree",
        "1/cm²" => "1/cm2",
        unit => unit,
    }
}

fn about(key: &Key) -> String {
    key.about.trim_end_matches('.').replace('`', "")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Unobserved;

    fn open(text: &str) -> Result<Subject> {
        Subject::open(text, &Opening::default(), &Unobserved)
    }

    #[test]
    fn sizes_of_species_and_stacks_have_units_and_ranges() {
        let starling = open("starling:pink").unwrap();
        let size = starling.size("cortex_um").unwrap();
        assert_eq!((size.unit.as_str(), size.range, size.whole), ("um", [0.001, 10.0], false));
        assert!(open("hummingbird").unwrap().size("layers").unwrap().whole);
        let film = open("air/keratin:300/melanin").unwrap();
        assert_eq!(film.size("layer1").unwrap().about, "thickness of layer 1, keratin");
        for (subject, key, part) in [
            (&starling, "cortex_nm", "did you mean 'cortex_um'?"),
            (&film, "layer2", "has no size 'layer2'"),
            (&film, "keratin", "known are layer1"),
            (&film, "layer+1", "has no size 'layer+1'"),
            (&film, "layer01", "has no size 'layer01'"),
        ] {
            let message = subject.size(key).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn a_changed_structure_is_that_of_its_own_file() {
        let folder = tempfile::tempdir().unwrap();
        let sizes = |key: &str, value| vec![(key.to_owned(), value)];
        for (text, size) in [
            ("starling:pink", sizes("cortex_um", 0.25)),
            ("hummingbird", sizes("layers", 7.0)),
            ("air/keratin:300/melanin", sizes("layer1", 250.0)),
        ] {
            let changed = open(text).unwrap().with(&size).unwrap();
            let path = folder.path().join("s.toml");
            std::fs::write(&path, changed.toml().unwrap()).unwrap();
            let again = open(&path.to_string_lossy()).unwrap();
            // A file has a name of its own, and the same individuals.
            let one = |subject: &Subject| {
                let structure = subject.structure().unwrap();
                // A film whose layers do not vary is one individual.
                let index = structure.count().map_or(3, |count| 3.min(count - 1));
                let section = structure.instance(7, index).unwrap();
                (section.boundaries, section.inclusions, section.media, section.smooth_um)
            };
            assert_eq!(one(&again), one(&changed), "{text}");
            assert_ne!(one(&open(text).unwrap()), one(&changed), "{text}");
        }
        let beyond = open("starling").unwrap().with(&sizes("cortex_um", 99.0)).unwrap_err().to_string();
        assert!(beyond.contains("cortex_um is 99, outside 0.001 to 10"), "{beyond}");
    }

    #[test]
    fn what_has_no_names_for_its_sizes_is_refused() {
        for (text, part) in [
            ("starling (below)", "is a lower side"),
            ("starlign", "did you mean 'starling'?"),
            ("nowhere.toml", "no such file"),
        ] {
            let message = open(text).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}
