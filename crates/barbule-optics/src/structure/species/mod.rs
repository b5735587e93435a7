//! The species: files of generator parameters with colour variants, and the generators.

mod bronzewing;
mod crystal;
mod file;
mod flat;
mod generator;
mod hummingbird;
mod multilayer;
mod rock_dove;
mod starling;

use barbule_birds::{BIRDS, Bird};
use serde_json::Value;

use super::lattice::Lattice;
use super::section::{Parts, Section};
use super::smooth::Smoothing;
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
pub(in crate::structure) use hummingbird::{NECK, Stacked};
pub use multilayer::{LowerSide, Multilayer, MultilayerLayer, MultilayerSizes};
pub use rock_dove::RockDove;
pub use starling::Starling;

/// The variant of a file without variants; titles do without it.
pub const DEFAULT_VARIANT: &str = "default";

/// The media that generators name of themselves.
const USUAL_MEDIA: [&str; 3] = ["air", "keratin", "melanin"];

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
    /// Whether simulations of its [`Structure`](super::Structure) average what is finer than light.
    pub smoothing: Smoothing,
}

impl SpeciesModel {
    /// A built-in species by its name, Latin name or another that people use; without a variant its default one.
    ///
    /// # Errors
    /// Unknown names; the nearest is offered, and all are listed.
    pub fn builtin(name: &str, variant: Option<&str>, library: Library) -> Result<Self> {
        Self::from_toml(species_toml(name)?, variant, library)
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
        let keys: Vec<_> = GeneratorParameters::keys(generator)?.iter().map(|key| key.name).collect();
        let fields = Fields::new(&table, "parameters", &keys)?;
        let about = SpeciesFile::builtin(name).ok();
        let about = |pick: fn(&SpeciesFile) -> &str| about.as_ref().map_or("", pick).to_owned();
        let model = Self {
            name: name.to_owned(),
            variant: variant.to_owned(),
            latin: about(|file| &file.latin),
            coloration: about(|file| &file.coloration),
            parameters: GeneratorParameters::read(generator, &fields)?,
            library,
            smoothing: Smoothing::default(),
        };
        model.check_media()?;
        Ok(model)
    }

    /// The same species with other values of some of its generator's parameters.
    ///
    /// # Errors
    /// A parameter that the generator does not have, or a value out of its range.
    pub fn with_parameters(&self, changes: &[(&str, Value)]) -> Result<Self> {
        let mut parameters = serde_json::to_value(&self.parameters)
            .map_err(|error| Error::machine(format!("parameters cannot be written: {error}")))?;
        let generator = parameters["generator"].as_str().unwrap_or_default();
        let keys = GeneratorParameters::keys(generator)?;
        for (key, value) in changes {
            // One that is left out is none of the table's.
            if !keys.iter().any(|known| known.name == *key) {
                return Err(Error::input(format!("{} has no parameter {key} to change", self.title())));
            }
            parameters[*key] = value.clone();
        }
        Ok(Self {
            latin: self.latin.clone(),
            smoothing: self.smoothing,
            ..Self::from_parameters(&self.name, &self.variant, &parameters, self.library.clone())?
        })
    }

    /// Refuses parameters that name media which the library does not have.
    pub(super) fn check_media(&self) -> Result<()> {
        for (key, medium) in self.parameters.generator().media() {
            crate::material::parse(medium, &self.library).map_err(|error| error.at(key))?;
        }
        Ok(())
    }

    /// The media that individuals are made of: those of all generators, then further ones that the parameters name.
    pub(super) fn media(&self) -> impl Iterator<Item = &str> {
        let mut media = USUAL_MEDIA.to_vec();
        for (_, medium) in self.parameters.generator().media() {
            if !media.contains(&medium) {
                media.push(medium);
            }
        }
        media.into_iter()
    }

    /// One random section. The same parameters, seed and index give the same bits everywhere.
    ///
    /// # Errors
    /// Parameters whose regions do not fit into each other; never for the built-in species.
    pub fn section(&self, seed: u64, index: usize) -> Result<Section> {
        let parts =
            self.parameters.generator().parts(&Random { seed, instance: index as u64 }, &self.library);
        self.checked(parts, seed, index)
    }

    /// The lower side of [`Self::section`], lit from below: the section turned upside down. Of a crystal only the upper half
    /// is in the section; the lower one hangs under the lower outline.
    ///
    /// # Errors
    /// As [`Self::section`], or as [`Section::underside`].
    pub fn underside(&self, seed: u64, index: usize) -> Result<Section> {
        match self.parameters.generator().lower_parts(&Random { seed, instance: index as u64 }, &self.library)
        {
            Some(parts) => self.checked(parts, seed, index),
            None => self.section(seed, index)?.underside(),
        }
    }

    fn checked(&self, mut parts: Parts, seed: u64, index: usize) -> Result<Section> {
        parts.name = format!("{} {index}", self.title());
        parts.source = format!("barbule {}, seed {seed}, instance {index}", self.title());
        Section::new(parts, self.library.clone()).map_err(|error| {
            let room = self.parameters.generator().room();
            error.at(format!("{}, instance {index}: too little room ({room})", self.title()))
        })
    }

    /// The photonic crystal under a flat top, where the species has one.
    #[must_use]
    pub fn lattice(&self) -> Option<Lattice> {
        self.parameters.generator().lattice(&self.library)
    }

    /// The photonic crystal of the lower side as seen from below, under a flat top.
    #[must_use]
    pub fn lower_lattice(&self) -> Option<Lattice> {
        self.parameters.generator().lower_lattice(&self.library)
    }

    /// Whether the lower side, lit from below, shows what the upper one does, up to single individuals: the same layers lie under both.
    #[must_use]
    pub fn is_alike_below(&self) -> bool {
        self.parameters.generator().is_alike_below()
    }

    /// `species:variant`; the name alone where a file has no variants.
    #[must_use]
    pub fn title(&self) -> String {
        if self.variant == DEFAULT_VARIANT {
            return self.name.clone();
        }
        format!("{}:{}", self.name, self.variant)
    }

    /// The standard deviation, µm, over which simulations average inclusions along the top; `None`: not at all.
    #[must_use]
    pub fn smooth_um(&self) -> Option<f64> {
        self.smoothing.deviation_um(self.parameters.generator().smooth_um())
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
    species_names().filter(|name| !is_crystal(name))
}

/// The names of the built-in species that a photonic crystal colours.
pub fn crystal_species() -> impl Iterator<Item = &'static str> + Clone {
    species_names().filter(|name| is_crystal(name))
}

fn is_crystal(name: &str) -> bool {
    SpeciesFile::builtin(name).is_ok_and(|file| file.generator == "crystal")
}

/// The names of the built-in species.
pub fn species_names() -> impl Iterator<Item = &'static str> + Clone {
    builtin().map(|(bird, _)| bird.name)
}

/// The birds with a species file, and its text.
fn builtin() -> impl Iterator<Item = (&'static Bird, &'static str)> + Clone {
    BIRDS.iter().filter_map(|bird| Some((bird, bird.species?)))
}

/// The text of a built-in species' file.
///
/// # Errors
/// As [`SpeciesModel::builtin`].
pub fn species_toml(name: &str) -> Result<&'static str> {
    Ok(find(name)?.1)
}

/// The built-in species that a name means: its own, its Latin one or another that people use, however it is spelled.
///
/// # Errors
/// Unknown names; the nearest is offered, and all are listed.
pub fn species_name(name: &str) -> Result<&'static str> {
    Ok(find(name)?.0.name)
}

fn find(name: &str) -> Result<(&'static Bird, &'static str)> {
    let wanted = spelled(name);
    let is_it = |(bird, _): &(&Bird, &str)| bird.name == wanted || bird.also.contains(&wanted.as_str());
    builtin().find(is_it).ok_or_else(|| {
        let near = match did_you_mean(&wanted, species_names()) {
            none if none.is_empty() => {
                did_you_mean(&wanted, builtin().flat_map(|(bird, _)| bird.also.iter().copied()))
            }
            near => near,
        };
        let known: Vec<_> = species_names().collect();
        Error::input(format!(
            "there is no species '{}'{near} (known are {})",
            shortened(name),
            known.join(", ")
        ))
    })
}

/// A name in lower case with - between its words: Anna's Hummingbird is annas-hummingbird.
fn spelled(name: &str) -> String {
    let plain: String = name.chars().filter(|c| !matches!(c, '\'' | '’' | '`')).take(200).collect();
    let words =
        plain.split(|c: char| c.is_whitespace() || c == '_' || c == '-').filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("-").to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_species_is_found_by_its_latin_name_and_by_no_name_of_another() {
        let mut all = std::collections::BTreeSet::new();
        for (species, _) in builtin() {
            let file = SpeciesFile::builtin(species.name).unwrap();
            assert!(species.also.contains(&spelled(&file.latin).as_str()), "{}", file.latin);
            assert_eq!(file.name, species.name);
            for name in species.also.iter().chain([&species.name]) {
                assert_eq!((spelled(name), species_name(name).unwrap()), ((*name).to_owned(), species.name));
                assert!(all.insert(*name), "{name} is another's too");
            }
        }
    }

    #[test]
    fn names_are_understood_as_people_write_them() {
        for (name, species) in [
            ("Starling", "starling"),
            ("sturnus vulgaris", "starling"),
            ("Sturnus_vulgaris", "starling"),
            ("European-starling", "starling"),
            ("Anna's hummingbird", "hummingbird"),
            ("Anna’s Hummingbird", "hummingbird"),
            ("peacock", "peafowl"),
            ("  Rock  Pigeon ", "rock-dove"),
        ] {
            assert_eq!(species_name(name).unwrap(), species, "{name}");
        }
        for (name, near) in [
            ("starlign", ", did you mean 'starling'? (known are rock-dove, starling,"),
            ("sturnus vulgarus", ", did you mean 'sturnus-vulgaris'?"),
            ("ostrich-of-the-sea-and-sky", "'ostrich-of-the-sea-and-sky' (known are rock-dove"),
            ("", "there is no species '' (known are"),
        ] {
            let message = species_name(name).unwrap_err().to_string();
            assert!(message.contains(near), "{message}");
        }
    }
}
