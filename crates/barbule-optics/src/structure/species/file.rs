//! Species files: a generator's parameters and the colour variants that differ in some of them.

use serde_json::{Map, Value};

use super::generator::generator_names;
use super::{GeneratorParameters, SpeciesModel, species_toml};
use crate::error::{did_you_mean, shortened};
use crate::fields::{Fields, list};
use crate::material::Library;
use crate::{Error, Result};

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
            generator: text("generator", &generator_names())?,
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
        let keys = GeneratorParameters::keys(&self.generator)?;
        let place = format!("variants[{index}]");
        Fields::new(&Value::Object(variant.overrides.clone()), &place, keys)?;
        Fields::new(&self.parameters, "parameters", keys)?;
        let mut merged = self.parameters.clone();
        if let Value::Object(table) = &mut merged {
            table.extend(variant.overrides.clone());
        }
        let parameters = GeneratorParameters::read(
            &self.generator,
            &Fields::new(&merged, "parameters", keys)?,
        )
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
