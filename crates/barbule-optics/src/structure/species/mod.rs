//! The species: files of generator parameters with colour variants, and the generators.

mod bronzewing;
mod crystal;
mod hummingbird;
mod rock_dove;
mod starling;

use serde::Serialize;
use serde_json::{Map, Value};

use super::lattice::Lattice;
use super::section::{Parts, Section};
use crate::error::did_you_mean;
use crate::error::shortened;
use crate::fields::{Fields, list};
use crate::material::Library;
use crate::math::rng::Stream;
use crate::{Error, Result};

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

const GENERATORS: &[&str] = &["rock-dove", "starling", "bronzewing", "hummingbird", "crystal"];

/// Reads the values of one generator's parameters.
pub(super) trait Parameter: Sized {
    fn read(fields: &Fields<'_>, key: &str, low: f64, high: f64) -> Result<Self>;
}

impl Parameter for f64 {
    fn read(fields: &Fields<'_>, key: &str, low: f64, high: f64) -> Result<Self> {
        fields.number_within(key, low, high)
    }
}

impl Parameter for usize {
    fn read(fields: &Fields<'_>, key: &str, low: f64, high: f64) -> Result<Self> {
        fields.count_within(key, low as usize, high as usize)
    }
}

/// A generator's parameters: a struct whose fields are the keys of its species files, with their ranges, and for keys that
/// may be left out what they then are.
macro_rules! parameters {
    ($(#[$about:meta])* $name:ident {
        $($(#[$doc:meta])* $field:ident: $kind:ty = $low:literal to $high:literal $(or $usual:literal)?,)*
    }) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize)]
        pub struct $name { $($(#[$doc])* pub $field: $kind,)* }

        impl $name {
            pub(super) const KEYS: &'static [&'static str] = &[$(stringify!($field)),*];

            pub(super) fn read(fields: &$crate::fields::Fields<'_>) -> $crate::Result<Self> {
                Ok(Self {
                    $($field: match (<[$kind]>::first(&[$($usual)?]), fields.get(stringify!($field))) {
                        (Some(&usual), None) => usual,
                        _ => $crate::structure::species::Parameter::read(
                            fields, stringify!($field), f64::from($low), f64::from($high))?,
                    },)*
                })
            }
        }
    };
}
use parameters;

pub use bronzewing::Bronzewing;
pub use crystal::Crystal;
pub use hummingbird::Hummingbird;
pub use rock_dove::RockDove;
pub use starling::Starling;

/// The parameters of one species and variant, by generator.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "generator", rename_all = "kebab-case")]
pub enum Parameters {
    /// A keratin cortex between air outside and inside.
    RockDove(RockDove),
    /// A keratin film over a layer of melanosomes.
    Starling(Starling),
    /// Two stacks of melanosome layers.
    Bronzewing(Bronzewing),
    /// Layers of air-filled pancake melanosomes.
    Hummingbird(Hummingbird),
    /// A photonic crystal of melanosomes.
    Crystal(Crystal),
}

impl Parameters {
    fn keys(generator: &str) -> Result<&'static [&'static str]> {
        match generator {
            "rock-dove" => Ok(RockDove::KEYS),
            "starling" => Ok(Starling::KEYS),
            "bronzewing" => Ok(Bronzewing::KEYS),
            "hummingbird" => Ok(Hummingbird::KEYS),
            "crystal" => Ok(Crystal::KEYS),
            other => {
                let near = did_you_mean(other, GENERATORS.iter().copied());
                let help =
                    if near.is_empty() { format!("; known are {}", GENERATORS.join(", ")) } else { near };
                Err(Error::input(format!("generator: there is no '{}'{help}", shortened(other))))
            }
        }
    }

    /// Of a generator that [`Self::keys`] knows.
    fn read(generator: &str, fields: &Fields<'_>) -> Result<Self> {
        Ok(match generator {
            "rock-dove" => {
                let parameters = RockDove::read(fields)?;
                parameters.check()?;
                Self::RockDove(parameters)
            }
            "bronzewing" => {
                let parameters = Bronzewing::read(fields)?;
                parameters.check()?;
                Self::Bronzewing(parameters)
            }
            "hummingbird" => {
                let parameters = Hummingbird::read(fields)?;
                parameters.check()?;
                Self::Hummingbird(parameters)
            }
            "crystal" => {
                let parameters = Crystal::read(fields)?;
                parameters.check()?;
                Self::Crystal(parameters)
            }
            _ => {
                let parameters = Starling::read(fields)?;
                parameters.check()?;
                Self::Starling(parameters)
            }
        })
    }

    fn width_um(&self) -> f64 {
        match self {
            Self::RockDove(p) => p.width_um,
            Self::Starling(p) => p.width_um,
            Self::Bronzewing(p) => p.width_um,
            Self::Hummingbird(p) => p.width_um,
            Self::Crystal(p) => p.width_um,
        }
    }
}

/// Refuses a range whose low end is above its high end.
fn ordered(low_key: &str, low: f64, high_key: &str, high: f64) -> Result<()> {
    if low <= high {
        return Ok(());
    }
    Err(Error::input(format!("parameters.{low_key} is {low}, above {high_key}, {high}; swap them")))
}

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
    pub parameters: Parameters,
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
        let fields = Fields::new(&table, "parameters", Parameters::keys(generator)?)?;
        let about = SpeciesFile::builtin(name).ok();
        let about = |pick: fn(&SpeciesFile) -> &str| about.as_ref().map_or("", pick).to_owned();
        Ok(Self {
            name: name.to_owned(),
            variant: variant.to_owned(),
            latin: about(|file| &file.latin),
            coloration: about(|file| &file.coloration),
            parameters: Parameters::read(generator, &fields)?,
            library,
        })
    }

    /// One random section. The same parameters, seed and index give the same bits everywhere.
    ///
    /// # Errors
    /// Parameters whose regions do not fit into each other; never for the built-in species.
    pub fn section(&self, seed: u64, index: usize) -> Result<Section> {
        let random = Random { seed, instance: index as u64 };
        let mut parts = match &self.parameters {
            Parameters::RockDove(p) => p.parts(&random),
            Parameters::Starling(p) => p.parts(&random),
            Parameters::Bronzewing(p) => p.parts(&random),
            Parameters::Hummingbird(p) => p.parts(&random),
            Parameters::Crystal(p) => p.parts(&random, self.library.clone()),
        };
        parts.name = format!("{} {index}", self.title());
        parts.source = format!("barbule {}, seed {seed}, instance {index}", self.title());
        Section::new(parts, self.library.clone()).map_err(|error| {
            error.at(format!("{}, instance {index} (its parameters leave too little room)", self.title()))
        })
    }

    /// The photonic crystal under a flat top, where the species has one.
    #[must_use]
    pub fn lattice(&self) -> Option<Lattice> {
        match &self.parameters {
            Parameters::Crystal(p) => Some(p.lattice(self.library.clone())),
            _ => None,
        }
    }

    /// `species:variant`.
    #[must_use]
    pub fn title(&self) -> String {
        format!("{}:{}", self.name, self.variant)
    }

    /// The barbule's width.
    #[must_use]
    pub fn width_um(&self) -> f64 {
        self.parameters.width_um()
    }

    /// Whether the outline is an arch rather than a slab.
    #[must_use]
    pub fn is_curved(&self) -> bool {
        match &self.parameters {
            Parameters::RockDove(_) => true,
            Parameters::Crystal(p) => p.is_arched(),
            _ => false,
        }
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

/// The random streams of one instance: one for each purpose.
#[derive(Debug, Clone, Copy)]
pub(super) struct Random {
    seed: u64,
    instance: u64,
}

impl Random {
    pub(super) fn stream(&self, purpose: u64) -> Stream {
        Stream::new(self.seed, &[self.instance, purpose])
    }

    pub(super) fn part(&self, purpose: u64, part: usize) -> Stream {
        Stream::new(self.seed, &[self.instance, purpose, part as u64])
    }
}

/// What a generator leaves to the caller: name and source.
pub(super) fn parts(width_um: f64, boundaries: Vec<super::Polyline>, media: Vec<super::Medium>) -> Parts {
    Parts { width_um: Some(width_um), boundaries, media, ..Parts::default() }
}

/// A species file that has passed every check.
#[derive(Debug, Clone)]
pub struct SpeciesFile {
    /// The species' name.
    pub name: String,
    /// Its Latin name.
    pub latin: String,
    /// What colours it.
    pub coloration: String,
    /// The variant of a bare name.
    pub default: String,
    /// The table of the file's own materials, which lie in other files.
    pub materials: Option<Value>,
    /// The table of the feather that bears the barbules, as it is written: whoever draws feathers reads it.
    pub feather: Option<Value>,
    variants: Vec<Variant>,
    generator: String,
    parameters: Value,
}

impl SpeciesFile {
    /// The file of a built-in species.
    ///
    /// # Errors
    /// As [`SpeciesModel::builtin`].
    pub fn builtin(name: &str) -> Result<Self> {
        Self::parse(species_toml(name)?)
    }

    /// Reads a species file's text.
    ///
    /// # Errors
    /// Not TOML, unknown or missing keys.
    pub fn parse(text: &str) -> Result<Self> {
        let value: Value = toml::from_str::<toml::Table>(text)
            .map_err(|error| {
                let line = error.span().map_or(0, |span| {
                    text.as_bytes()[..span.start.min(text.len())].iter().filter(|b| **b == b'\n').count() + 1
                });
                Error::input(format!("line {line} is not TOML: {}", shortened(error.message())))
            })
            .and_then(|table| {
                serde_json::to_value(table)
                    .map_err(|e| Error::input(format!("cannot be read: {}", shortened(&e.to_string()))))
            })?;
        let keys = [
            "barbule",
            "name",
            "latin",
            "coloration",
            "source",
            "generator",
            "default",
            "parameters",
            "variants",
            "materials",
            "feather",
        ];
        if value.get("lattice").is_some() {
            return Err(Error::input(
                "lattice: a species' crystal is described by the parameters of generator \"crystal\"; a lattice alone is a file of its own",
            ));
        }
        let fields = Fields::new(&value, "", &keys)?;
        let version = fields.need_number("barbule", "the format's version, barbule = 1")?;
        if version != 1.0 {
            return Err(Error::input(format!("barbule is {version}, but this version reads format 1 only")));
        }
        let text = |key: &str, what: &str| -> Result<String> {
            let text =
                fields.text(key)?.ok_or_else(|| Error::input(format!("{key} is missing; give {what}")))?;
            let plain = !text.is_empty() && text.len() <= 200 && !text.contains(char::is_control);
            if plain {
                Ok(text.to_owned())
            } else {
                Err(Error::input(format!("{key} must be one line of 1 to 200 letters")))
            }
        };
        fields.text("source")?;
        let mut variants = Vec::new();
        if let Some(value) = fields.get("variants") {
            for (index, entry) in list(value, "variants")?.iter().enumerate() {
                variants.push(Variant::read(entry, &format!("variants[{index}]"))?);
            }
        }
        if variants.is_empty() {
            variants.push(Variant { name: "default".to_owned(), overrides: Map::new() });
        }
        if let Some(at) =
            (1..variants.len()).find(|&i| variants[..i].iter().any(|v| v.name == variants[i].name))
        {
            return Err(Error::input(format!(
                "variants[{at}].name is '{}' a second time",
                variants[at].name
            )));
        }
        let default = fields.text("default")?.unwrap_or(&variants[0].name).to_owned();
        let optional = |key: &str| Ok(fields.text(key)?.unwrap_or_default().to_owned());
        let file = Self {
            name: text("name", "the species' name")?,
            latin: optional("latin")?,
            coloration: optional("coloration")?,
            generator: text("generator", "starling, rock-dove, bronzewing, hummingbird or crystal")?,
            parameters: fields.need("parameters", "the table of the generator's parameters")?.clone(),
            materials: fields.get("materials").cloned(),
            feather: fields.get("feather").cloned(),
            default,
            variants,
        };
        // Every variant is checked at once, so that a slip in one that is not used is found too.
        for variant in &file.variants {
            file.model(Some(&variant.name), Library::builtin())?;
        }
        file.model(None, Library::builtin())?;
        Ok(file)
    }

    /// The names of the variants in the file's order.
    pub fn variants(&self) -> impl Iterator<Item = &str> + Clone {
        self.variants.iter().map(|v| v.name.as_str())
    }

    /// The model of a variant, or of the default one.
    ///
    /// # Errors
    /// No such variant, or a parameter that is missing or out of range.
    pub fn model(&self, variant: Option<&str>, library: Library) -> Result<SpeciesModel> {
        let wanted = variant.unwrap_or(&self.default);
        let index = self
            .variants
            .iter()
            .position(|v| v.name == wanted)
            .ok_or_else(|| no_variant(&self.name, wanted, self.variants()))?;
        let variant = &self.variants[index];
        let keys = Parameters::keys(&self.generator)?;
        let place = format!("variants[{index}]");
        Fields::new(&Value::Object(variant.overrides.clone()), &place, keys)?;
        Fields::new(&self.parameters, "parameters", keys)?;
        let mut merged = self.parameters.clone();
        if let Value::Object(table) = &mut merged {
            table.extend(variant.overrides.clone());
        }
        let parameters = Parameters::read(&self.generator, &Fields::new(&merged, "parameters", keys)?)
            .map_err(|error| {
                if self.variants.len() > 1 { error.at(format!("variant {}", variant.name)) } else { error }
            })?;
        Ok(SpeciesModel {
            name: self.name.clone(),
            variant: variant.name.clone(),
            latin: self.latin.clone(),
            coloration: self.coloration.clone(),
            parameters,
            library,
        })
    }
}

/// A variant: its name and the parameters in which it differs.
#[derive(Debug, Clone)]
struct Variant {
    name: String,
    overrides: Map<String, Value>,
}

impl Variant {
    fn read(entry: &Value, place: &str) -> Result<Self> {
        let Value::Object(table) = entry else {
            return Err(Error::input(format!(
                "{place} must be a table, as in {{ name = \"green\", cortex_um = 0.32 }}"
            )));
        };
        let mut overrides = table.clone();
        let name = match overrides.remove("name") {
            Some(Value::String(name)) if is_variant_name(&name) => name,
            Some(_) => {
                return Err(Error::input(format!(
                    "{place}.name must be a text of up to 64 letters, digits and -"
                )));
            }
            None => return Err(Error::input(format!("{place}.name is missing; give the variant's name"))),
        };
        Ok(Self { name, overrides })
    }
}

fn is_variant_name(name: &str) -> bool {
    (1..=64).contains(&name.len()) && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-')
}

fn no_variant<'a>(name: &str, wanted: &str, known: impl Iterator<Item = &'a str> + Clone) -> Error {
    let wanted = shortened(wanted);
    let near = did_you_mean(&wanted, known.clone());
    let all = shortened(&known.collect::<Vec<_>>().join(", "));
    Error::input(format!("{name} has no variant '{wanted}'{near} (known are {all})",))
}
