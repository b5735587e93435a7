//! The species: files of generator parameters with colour variants, and the generators.

mod bronzewing;
mod crystal;
mod file;
mod generator;
mod hummingbird;
mod rock_dove;
mod starling;

use serde_json::Value;

use super::lattice::Lattice;
use super::section::Section;
use crate::error::{did_you_mean, shortened};
use crate::fields::Fields;
use crate::material::Library;
use crate::{Error, Result};
use generator::Random;

pub use bronzewing::Bronzewing;
pub use crystal::Crystal;
pub use file::SpeciesFile;
pub use generator::GeneratorParameters;
pub use hummingbird::Hummingbird;
pub use rock_dove::RockDove;
pub use starling::Starling;

/// A built-in species: its name and the text of its file.
type Builtin = (&'static str, &'static str);

/// Species made of layers.
const LAYERED: &[Builtin] = &[
    ("rock-dove", include_str!("rock-dove.toml")),
    ("starling", include_str!("starling.toml")),
    ("bronzewing", include_str!("bronzewing.toml")),
    ("hummingbird", include_str!("hummingbird.toml")),
];

/// Species coloured by a photonic crystal.
const CRYSTALS: &[Builtin] = &[
    ("mallard", include_str!("mallard.toml")),
    ("magpie", include_str!("magpie.toml")),
    ("peafowl", include_str!("peafowl.toml")),
];

/// One species in one colour variant: makes random sections.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeciesModel {
    /// The species' name, as in `starling`.
    pub name: String,
    /// The variant's name.
    pub variant: String,
    /// Its Latin name.
    pub latin: String,
    /// What colours it, in one line.
    pub coloration: String,
    /// The generator's parameters.
    pub parameters: GeneratorParameters,
    /// The materials that keratin, melanin and air mean.
    pub library: Library,
}

impl SpeciesModel {
    /// A built-in species; without a variant its default one.
    ///
    /// # Errors
    /// Unknown names; the nearest is offered.
    pub fn builtin(name: &str, variant: Option<&str>, library: Library) -> Result<Self> {
        let Some((_, text)) = builtin().find(|(known, _)| *known == name) else {
            let known = species_names();
            let near = did_you_mean(name, known.clone());
            let help = if near.is_empty() {
                format!("; known are {}", known.collect::<Vec<_>>().join(", "))
            } else {
                near
            };
            return Err(Error::input(format!("there is no species '{}'{help}", shortened(name))));
        };
        Self::from_toml(text, variant, library)
    }

    /// A species from the text of its file; without a variant the file's default one.
    ///
    /// # Errors
    /// Anything that `docs/formats/species.md` lists; the message starts with the key.
    pub fn from_toml(text: &str, variant: Option<&str>, library: Library) -> Result<Self> {
        let file = SpeciesFile::parse(text)?;
        file.model(variant, library)
    }

    /// A species from what results recorded of it: name, variant, and all parameters with their generator.
    ///
    /// # Errors
    /// Unknown generators, missing parameters, or values out of range; the message starts with the key.
    pub fn from_parameters(name: &str, variant: &str, parameters: &Value, library: Library) -> Result<Self> {
        let generator = parameters["generator"].as_str().unwrap_or_default();
        let mut table = parameters.clone();
        if let Value::Object(table) = &mut table {
            table.remove("generator");
        }
        let fields = Fields::new(&table, "parameters", GeneratorParameters::keys(generator)?)?;
        let about = SpeciesFile::builtin(name).ok();
        let about = |pick: fn(&SpeciesFile) -> &str| about.as_ref().map_or("", pick).to_owned();
        Ok(Self {
            name: name.to_owned(),
            variant: variant.to_owned(),
            latin: about(|file| &file.latin),
            coloration: about(|file| &file.coloration),
            parameters: GeneratorParameters::read(generator, &fields)?,
            library,
        })
    }

    /// One random section. The same parameters, seed and index give the same bits everywhere.
    ///
    /// # Errors
    /// Parameters whose regions do not fit into each other; never for the built-in species.
    pub fn section(&self, seed: u64, index: usize) -> Result<Section> {
        let random = Random { seed, instance: index as u64 };
        let mut parts = self.parameters.generator().parts(&random, &self.library);
        parts.name = format!("{} {index}", self.title());
        parts.source = format!("barbule {}, seed {seed}, instance {index}", self.title());
        Section::new(parts, self.library.clone()).map_err(|error| {
            error.at(format!("{}, instance {index} (its parameters leave too little room)", self.title()))
        })
    }

    /// The photonic crystal under a flat top, where the species has one.
    #[must_use]
    pub fn lattice(&self) -> Option<Lattice> {
        self.parameters.generator().lattice(&self.library)
    }

    /// `species:variant`.
    #[must_use]
    pub fn title(&self) -> String {
        format!("{}:{}", self.name, self.variant)
    }

    /// The barbule's width.
    #[must_use]
    pub fn width_um(&self) -> f64 {
        self.parameters.generator().width_um()
    }

    /// Whether the outline is an arch rather than a slab.
    #[must_use]
    pub fn is_curved(&self) -> bool {
        self.parameters.generator().is_curved()
    }
}

/// The names of the built-in species that are made of layers.
pub fn layered_species() -> impl Iterator<Item = &'static str> + Clone {
    LAYERED.iter().map(|(name, _)| *name)
}

/// The names of the built-in species that a photonic crystal colours.
pub fn crystal_species() -> impl Iterator<Item = &'static str> + Clone {
    CRYSTALS.iter().map(|(name, _)| *name)
}

/// The names of the built-in species.
pub fn species_names() -> impl Iterator<Item = &'static str> + Clone {
    builtin().map(|(name, _)| *name)
}

fn builtin() -> impl Iterator<Item = &'static Builtin> + Clone {
    LAYERED.iter().chain(CRYSTALS)
}

/// The text of a built-in species' file.
///
/// # Errors
/// As [`SpeciesModel::builtin`].
pub fn species_toml(name: &str) -> Result<&'static str> {
    match builtin().find(|(known, _)| *known == name) {
        Some((_, text)) => Ok(text),
        None => SpeciesModel::builtin(name, None, Library::builtin()).map(|_| ""),
    }
}
