//! Species files: a generator's parameters and the colour variants that differ in some of them.

use std::collections::BTreeSet;

use serde_json::{Map, Value};

use super::super::smooth::Smoothing;
use super::generator::generator_names;
use super::{DEFAULT_VARIANT, GeneratorParameters, SpeciesModel, species_toml};
use crate::error::{did_you_mean, shortened};
use crate::fields::{Fields, Key, Usual, at_key, at_line, in_toml, line_of, list, parse_toml};
use crate::material::Library;
use crate::{Error, Result};

/// A file has no more variants than this.
const MOST_VARIANTS: usize = 1000;

const KEYS: &[&str] = &[
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
    "preset",
    "feather",
];

/// A species file that has passed every check.
#[derive(Debug, Clone)]
pub struct SpeciesFile {
    /// The species' name.
    pub name: String,
    /// Its Latin name.
    pub latin: String,
    /// What colours it.
    pub coloration: String,
    /// Where its numbers come from.
    pub source: String,
    /// The variant of a bare name.
    pub default: String,
    /// What makes its sections.
    pub generator: String,
    /// The table of the file's own materials, which lie in other files.
    pub materials: Option<Value>,
    /// The scene in which it is shown: whoever draws feathers knows the names.
    pub preset: Option<String>,
    /// The table of the feather that bears the barbules, as it is written: whoever draws feathers reads it.
    pub feather: Option<Value>,
    variants: Vec<Variant>,
    parameters: Map<String, Value>,
}

impl SpeciesFile {
    /// The file of a built-in species.
    ///
    /// # Errors
    /// As [`SpeciesModel::builtin`].
    pub fn builtin(name: &str) -> Result<Self> {
        Self::parse(species_toml(name)?)
    }

    /// Reads a species file's text. A key stands in `[parameters]` or in variants, not in both: what is edited counts.
    ///
    /// # Errors
    /// Not TOML, unknown, missing or repeated keys, values out of range; the message starts with the line.
    pub fn parse(text: &str) -> Result<Self> {
        let value = parse_toml(text)?;
        let file = Self::read(&value).map_err(|error| at_line(error, text))?;
        file.check_variants(text)?;
        Ok(file)
    }

    fn read(value: &Value) -> Result<Self> {
        if value.get("lattice").is_some() {
            return Err(Error::input(
                "lattice: a species' crystal is described by the parameters of generator \"crystal\"; a lattice alone is a file of its own",
            ));
        }
        let fields = Fields::new(value, "", KEYS)?;
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
        let optional = |key: &str| Ok(fields.text(key)?.unwrap_or_default().to_owned());
        let generator = text("generator", &generator_names())?;
        let keys = GeneratorParameters::keys(&generator)?;
        let names: Vec<_> = keys.iter().map(|key| key.name).collect();
        let parameters = fields.need("parameters", "the table of the generator's parameters")?;
        GeneratorParameters::check_given(&generator, &Fields::new(parameters, "parameters", &names)?)?;
        let variants = read_variants(fields.get("variants"), &generator, &names)?;
        Ok(Self {
            name: text("name", "the species' name")?,
            latin: optional("latin")?,
            coloration: optional("coloration")?,
            source: optional("source")?,
            default: chosen(fields.text("default")?, &variants)?,
            generator,
            parameters: parameters.as_object().cloned().unwrap_or_default(),
            materials: fields.get("materials").cloned(),
            preset: fields.text("preset")?.map(str::to_owned),
            feather: fields.get("feather").cloned(),
            variants: if variants.is_empty() { vec![Variant::only()] } else { variants },
        })
    }

    /// Checks every variant, so that a slip in one that is not used is found too.
    fn check_variants(&self, text: &str) -> Result<()> {
        for (index, variant) in self.variants.iter().enumerate() {
            if let Some(key) = variant.overrides.keys().find(|key| self.parameters.contains_key(*key)) {
                let line = |path: &str| line_of(text, path).map_or(String::new(), |n| format!(" (line {n})"));
                let error = Error::input(format!(
                    "parameters.{key}{} has no effect on variant '{}', which gives {key} too{}; keep it in \
                     [parameters] or in all variants, not in both",
                    line(&format!("parameters.{key}")),
                    variant.name,
                    line(&format!("variants[{index}].{key}")),
                ));
                return Err(in_toml(error, text));
            }
            self.parameters_of(index).map_err(|error| self.of_variant(error, index, text))?;
        }
        Ok(())
    }

    /// An error of a variant's merged parameters, with the line where the key stands and the variant's name.
    fn of_variant(&self, error: Error, index: usize, text: &str) -> Error {
        let variant = &self.variants[index];
        let message = error.to_string();
        let key = message.strip_prefix("parameters.").unwrap_or_default();
        let key = key.split(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or_default();
        let path = match variant.overrides.contains_key(key) {
            true => format!("variants[{index}].{key}"),
            false => message,
        };
        let error =
            if self.variants.len() > 1 { error.at(format!("variant {}", variant.name)) } else { error };
        at_key(error, text, &path)
    }

    /// The names of the variants in the file's order.
    pub fn variants(&self) -> impl Iterator<Item = &str> + Clone {
        self.variants.iter().map(|v| v.name.as_str())
    }

    /// The model of a variant, or of the default one.
    ///
    /// # Errors
    /// No such variant, or it names a medium that the library does not have.
    pub fn model(&self, variant: Option<&str>, library: Library) -> Result<SpeciesModel> {
        let index = self.index(variant)?;
        let model = SpeciesModel {
            name: self.name.clone(),
            variant: self.variants[index].name.clone(),
            latin: self.latin.clone(),
            coloration: self.coloration.clone(),
            parameters: self.parameters_of(index)?,
            library,
            smoothing: Smoothing::default(),
        };
        model.check_media()?;
        Ok(model)
    }

    /// A variant's parameters as the file gives them, each with its key, in the order of the generator's keys; those that are
    /// left out have their usual values.
    ///
    /// # Errors
    /// No such variant.
    pub fn given(&self, variant: Option<&str>) -> Result<Vec<(Key, Value)>> {
        let merged = self.merged(self.index(variant)?);
        let keys = GeneratorParameters::keys(&self.generator)?;
        let with_value = |key: Key| {
            let value = merged.get(key.name).cloned().or_else(|| key.usual.value().cloned())?;
            Some((key, value))
        };
        Ok(keys.into_iter().filter_map(with_value).collect())
    }

    fn index(&self, variant: Option<&str>) -> Result<usize> {
        let wanted = variant.unwrap_or(&self.default);
        self.variants
            .iter()
            .position(|v| v.name == wanted)
            .ok_or_else(|| no_variant(&self.name, wanted, self.variants()))
    }

    fn merged(&self, index: usize) -> Map<String, Value> {
        let mut merged = self.parameters.clone();
        merged.extend(self.variants[index].overrides.clone());
        merged
    }

    fn parameters_of(&self, index: usize) -> Result<GeneratorParameters> {
        let keys = GeneratorParameters::keys(&self.generator)?;
        let merged = self.merged(index);
        for key in keys.iter().filter(|key| key.usual == Usual::Needed && !merged.contains_key(key.name)) {
            if let Some(other) = self.variants.iter().find(|v| v.overrides.contains_key(key.name)) {
                let missing = format!("variants[{index}].{}", key.name);
                return Err(Error::input(format!(
                    "{missing} is missing; give it here as variant '{}' does, or in [parameters] alone",
                    other.name
                ))
                .about(missing));
            }
        }
        let names: Vec<_> = keys.iter().map(|key| key.name).collect();
        let merged = Value::Object(merged);
        GeneratorParameters::read(&self.generator, &Fields::new(&merged, "parameters", &names)?)
    }
}

/// A variant: its name and the parameters that it gives.
#[derive(Debug, Clone)]
struct Variant {
    name: String,
    overrides: Map<String, Value>,
}

impl Variant {
    /// The one variant of a file without any.
    fn only() -> Self {
        Self { name: DEFAULT_VARIANT.to_owned(), overrides: Map::new() }
    }

    fn read(entry: &Value, place: &str, generator: &str, keys: &[&str]) -> Result<Self> {
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
        let given = Value::Object(overrides);
        GeneratorParameters::check_given(generator, &Fields::new(&given, place, keys)?)?;
        let overrides = if let Value::Object(table) = given { table } else { Map::new() };
        Ok(Self { name, overrides })
    }
}

fn read_variants(value: Option<&Value>, generator: &str, keys: &[&str]) -> Result<Vec<Variant>> {
    let Some(value) = value else { return Ok(Vec::new()) };
    let entries = list(value, "variants")?;
    if entries.len() > MOST_VARIANTS {
        return Err(Error::input(format!(
            "variants: there are {}, over the limit of {MOST_VARIANTS}; split the file",
            entries.len()
        )));
    }
    let mut names = BTreeSet::new();
    let mut variants = Vec::with_capacity(entries.len());
    for (index, entry) in entries.iter().enumerate() {
        let variant = Variant::read(entry, &format!("variants[{index}]"), generator, keys)?;
        if !names.insert(variant.name.clone()) {
            return Err(Error::input(format!("variants[{index}].name is '{}' a second time", variant.name)));
        }
        variants.push(variant);
    }
    Ok(variants)
}

/// The variant of the bare name: the one that `default` names, else the first.
fn chosen(default: Option<&str>, variants: &[Variant]) -> Result<String> {
    match (default, variants) {
        (None, []) => Ok(DEFAULT_VARIANT.to_owned()),
        (None, [first, ..]) => Ok(first.name.clone()),
        (Some(DEFAULT_VARIANT), []) => Ok(DEFAULT_VARIANT.to_owned()),
        (Some(name), []) => Err(Error::input(format!(
            "default names the variant '{}', but this file has no variants; delete the line",
            shortened(name)
        ))),
        (Some(name), _) if variants.iter().any(|v| v.name == name) => Ok(name.to_owned()),
        (Some(name), _) => {
            Err(no_variant("default: the file", name, variants.iter().map(|v| v.name.as_str())))
        }
    }
}

fn is_variant_name(name: &str) -> bool {
    (1..=64).contains(&name.len()) && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-')
}

fn no_variant<'a>(name: &str, wanted: &str, known: impl Iterator<Item = &'a str> + Clone) -> Error {
    let wanted = shortened(wanted);
    if known.clone().eq([DEFAULT_VARIANT]) {
        return Error::input(format!("{name} has no variants, so no '{wanted}'; leave it out"));
    }
    let near = did_you_mean(&wanted, known.clone());
    let all = shortened(&known.collect::<Vec<_>>().join(", "));
    Error::input(format!("{name} has no variant '{wanted}'{near} (known are {all})",))
}
