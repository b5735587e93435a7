//! `[surfaces.NAME]`: what objects are made of.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;
use serde_json::Value;

use super::colour::colour;
use super::kinds::{kind_of, unknown};
use super::{FibreDescription, PigmentedKeratin};
use crate::bsdf::{Grating, Texture};
use crate::error::{did_you_mean, shortened};
use crate::fields::Fields;
use crate::material::Library;
use crate::scattering::grating::Powers;
use crate::spectrum::colour::decode;
use crate::stack::Stack;
use crate::{Error, Result};

/// A surface with a name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum NamedSurface {
    /// Perfectly diffuse.
    Diffuse {
        /// sRGB, 0 … 1.
        colour: [f64; 3],
        /// Pictures by their keys: `albedo`, `alpha`, `normal`, `bump`.
        pictures: BTreeMap<&'static str, TextureFile>,
        /// Height where `bump` is white, µm.
        #[serde(skip_serializing_if = "Option::is_none")]
        bump_um: Option<f64>,
    },
    /// Pigmented keratin.
    Keratin(PigmentedKeratin),
    /// Fibres of hair.
    Hair(FibreDescription),
    /// Glass, clear or frosted.
    Dielectric {
        /// Refractive index.
        index: f64,
        /// GGX α along the long axis of what it is on, and across; smooth where there is none.
        #[serde(skip_serializing_if = "Option::is_none")]
        roughness: Option<[f64; 2]>,
    },
    /// Rough metal.
    Conductor {
        /// GGX α along the long axis of what it is on, and across.
        roughness: [f64; 2],
        /// What it is.
        metal: Metal,
    },
    /// Layers over a rough base.
    Film {
        /// The layers, in the language of stacks.
        stack: String,
        /// GGX α along the long axis of what it is on, and across.
        roughness: [f64; 2],
        /// Of a diffuse body beneath, sRGB, 0 … 1.
        #[serde(skip_serializing_if = "Option::is_none")]
        colour: Option<[f64; 3]>,
    },
    /// A diffraction grating over pigment.
    Grating(GratingDescription),
    /// Others, chosen from place to place.
    Map {
        /// A grey picture: pixels of value i (of 255) are the i-th surface.
        picture: TextureFile,
        /// Their names.
        surfaces: Vec<String>,
    },
}

/// A grating of a scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GratingDescription {
    /// Whose heights.
    pub source: GratingSource,
    /// The powers of its orders, once they are made or read.
    #[serde(skip)]
    pub powers: Option<Arc<Powers>>,
    /// BLAKE3 of the file.
    pub content: String,
    /// Colour of what is beneath, sRGB, 0 … 1.
    pub pigment: [f64; 3],
    /// Refractive index.
    pub index: f64,
    /// Standard deviation of the window of coherence, µm.
    pub coherence_um: f64,
}

/// Where a grating's heights come from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum GratingSource {
    /// A built-in sample.
    Sample(String),
    /// A `.grating` file.
    File(#[serde(skip)] String),
}

/// Where nothing is said: lobes are 0.9° wide at 550 nm (standard deviation), as if the scale were a little uneven.
const USUAL_COHERENCE_UM: f64 = 4.0;

/// What a conductor is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum Metal {
    /// Copper by Johnson & Christy.
    Copper,
    /// One of the same index n + ik at all wavelengths.
    Constant {
        /// n.
        index: f64,
        /// k.
        absorption: f64,
    },
}

/// A picture on a surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TextureFile {
    /// The file.
    #[serde(skip)]
    pub file: String,
    /// What is in it, once it is read.
    #[serde(skip)]
    pub texture: Option<Texture>,
    /// BLAKE3 of the file.
    pub content: String,
}

impl TextureFile {
    fn new(file: &str) -> Self {
        Self { file: file.to_owned(), texture: None, content: String::new() }
    }

    /// The picture.
    ///
    /// # Errors
    /// It is not read.
    pub fn read(&self) -> Result<Texture> {
        let unread = || Error::input(format!("the texture '{}' is not read", self.file));
        self.texture.clone().ok_or_else(unread)
    }
}

/// Keys of pictures on diffuse surfaces: what the colour is multiplied with, what is black where there are holes, normals, heights.
const PICTURES: [&str; 4] = ["albedo", "alpha", "normal", "bump"];

const TYPES: [&str; 8] = ["diffuse", "keratin", "hair", "dielectric", "conductor", "film", "grating", "map"];

/// Most surfaces of a map: as many as an 8-bit grey tells apart.
const MOST_MAPPED: usize = 256;

/// Metals whose index is known.
const METALS: [&str; 1] = ["copper"];

impl NamedSurface {
    /// Reads `[surfaces.NAME]` with a `type`.
    pub(super) fn read(table: &Value, place: &str) -> Result<Self> {
        let kind = kind_of(table, place, &TYPES)?;
        match kind {
            "diffuse" => Self::read_diffuse(table, place),
            "keratin" => Ok(Self::Keratin(PigmentedKeratin::read(&untyped(table), place)?)),
            "hair" => Ok(Self::Hair(FibreDescription::read(&untyped(table), place)?)),
            "dielectric" => {
                let fields = Fields::new(table, place, &["type", "index", "roughness"])?;
                let index = fields.number_within("index", 1.01, 3.9)?;
                let roughness = fields.get("roughness").map(|_| roughness(&fields)).transpose()?;
                Ok(Self::Dielectric { index, roughness })
            }
            "conductor" => {
                let fields =
                    Fields::new(table, place, &["type", "roughness", "metal", "index", "absorption"])?;
                Ok(Self::Conductor { roughness: roughness(&fields)?, metal: Metal::read(&fields, place)? })
            }
            "film" => Self::read_film(table, place),
            "grating" => Ok(Self::Grating(GratingDescription::read(table, place)?)),
            _ => Self::read_map(table, place),
        }
    }

    fn read_diffuse(table: &Value, place: &str) -> Result<Self> {
        let known = [&["type", "colour", "bump_um"][..], &PICTURES].concat();
        let fields = Fields::new(table, place, &known)?;
        let mut pictures = BTreeMap::new();
        for key in PICTURES {
            if let Some(file) = fields.text(key)? {
                pictures.insert(key, TextureFile::new(file));
            }
        }
        let has = |key: &str| fields.get(key).is_some();
        if has("normal") && has("bump") {
            return Err(Error::input(format!(
                "{place}.normal and {place}.bump are both given; leave one out"
            )));
        }
        if has("bump_um") && !has("bump") {
            return Err(Error::input(format!(
                "{place}.bump_um is given, but there is no picture {place}.bump"
            )));
        }
        let bump_um = has("bump").then(|| fields.number_within("bump_um", -1e5, 1e5)).transpose()?;
        let colour = fields.get("colour").map_or(Ok([1.0; 3]), |c| colour(c, &fields.path("colour")))?;
        Ok(Self::Diffuse { colour, pictures, bump_um })
    }

    fn read_film(table: &Value, place: &str) -> Result<Self> {
        let fields = Fields::new(table, place, &["type", "stack", "roughness", "colour"])?;
        fields.need("stack", "layers such as air/keratin:400/melanin")?;
        let stack = fields.text("stack")?.unwrap_or_default();
        Stack::parse(stack, &Library::builtin()).map_err(|error| error.at(fields.path("stack")))?;
        let colour = fields.get("colour").map(|c| colour(c, &fields.path("colour"))).transpose()?;
        Ok(Self::Film { stack: stack.to_owned(), roughness: roughness(&fields)?, colour })
    }

    fn read_map(table: &Value, place: &str) -> Result<Self> {
        let fields = Fields::new(table, place, &["type", "file", "surfaces"])?;
        let file = fields.need("file", "a grey .png").and_then(|_| fields.text("file"))?.unwrap_or_default();
        let path = fields.path("surfaces");
        let names = fields.list("surfaces", "a list of names of tables [surfaces.NAME]")?;
        if !(1..=MOST_MAPPED).contains(&names.len()) {
            return Err(Error::input(format!("{path}: give 1 to {MOST_MAPPED} names")));
        }
        let name = |(i, name): (usize, &Value)| match name {
            Value::String(name) => Ok(name.clone()),
            _ => {
                Err(Error::input(format!("{path}[{i}] is no text; give the name of a table [surfaces.NAME]")))
            }
        };
        let surfaces = names.iter().enumerate().map(name).collect::<Result<_>>()?;
        Ok(Self::Map { picture: TextureFile::new(file), surfaces })
    }

    /// Refuses a map of surfaces that do not exist or are maps themselves.
    pub(super) fn check(&self, place: &str, all: &BTreeMap<String, Self>) -> Result<()> {
        let Self::Map { surfaces, .. } = self else { return Ok(()) };
        for (i, name) in surfaces.iter().enumerate() {
            match all.get(name) {
                None => {
                    let near = did_you_mean(name, all.keys().map(String::as_str));
                    let name = shortened(name);
                    return Err(Error::input(format!(
                        "{place}.surfaces[{i}] is '{name}'{near}; there is no table [surfaces.{name}] with a type"
                    )));
                }
                Some(Self::Map { .. }) => {
                    return Err(Error::input(format!(
                        "{place}.surfaces[{i}] is the map '{}'; give surfaces that are no maps",
                        shortened(name)
                    )));
                }
                Some(_) => {}
            }
        }
        Ok(())
    }

    /// Its pictures with their keys.
    pub fn pictures_mut(&mut self) -> Vec<(&'static str, &mut TextureFile)> {
        match self {
            Self::Diffuse { pictures, .. } => {
                pictures.iter_mut().map(|(key, picture)| (*key, picture)).collect()
            }
            Self::Map { picture, .. } => vec![("file", picture)],
            Self::Keratin(_)
            | Self::Hair(_)
            | Self::Dielectric { .. }
            | Self::Conductor { .. }
            | Self::Film { .. }
            | Self::Grating(_) => Vec::new(),
        }
    }

    /// Memory that its pictures take, bytes, once they are read.
    pub(super) fn bytes(&self) -> usize {
        let one = |picture: &TextureFile| picture.texture.as_ref().map_or(0, Texture::bytes);
        match self {
            Self::Diffuse { pictures, .. } => pictures.values().map(one).sum(),
            Self::Map { picture, .. } => one(picture),
            Self::Keratin(_)
            | Self::Hair(_)
            | Self::Dielectric { .. }
            | Self::Conductor { .. }
            | Self::Film { .. } => 0,
            // Beside the orders' powers the table that is rendered from, of about as many numbers.
            Self::Grating(of) => of.powers.as_ref().map_or(0, |powers| 3 * size_of_val(powers.series())),
        }
    }

    /// Its table in a scene file.
    pub(super) fn table(&self) -> Value {
        let (kind, mut table) = match self {
            Self::Diffuse { colour, pictures, bump_um } => {
                let mut table = serde_json::json!({"colour": colour});
                if let Value::Object(table) = &mut table {
                    let named = |(key, picture): (&&str, &TextureFile)| {
                        ((*key).to_owned(), picture.file.as_str().into())
                    };
                    table.extend(pictures.iter().map(named));
                    table.extend(bump_um.map(|height| ("bump_um".to_owned(), height.into())));
                }
                ("diffuse", table)
            }
            Self::Keratin(keratin) => ("keratin", keratin.table()),
            Self::Hair(hair) => ("hair", hair.table()),
            Self::Dielectric { index, roughness: None } => {
                ("dielectric", serde_json::json!({"index": index}))
            }
            Self::Dielectric { index, roughness } => {
                ("dielectric", serde_json::json!({"index": index, "roughness": roughness}))
            }
            Self::Conductor { roughness, metal } => {
                let table = match metal {
                    Metal::Copper => serde_json::json!({"roughness": roughness, "metal": "copper"}),
                    Metal::Constant { index, absorption } => {
                        serde_json::json!({"roughness": roughness, "index": index, "absorption": absorption})
                    }
                };
                ("conductor", table)
            }
            Self::Film { stack, roughness, colour: None } => {
                ("film", serde_json::json!({"stack": stack, "roughness": roughness}))
            }
            Self::Film { stack, roughness, colour } => {
                ("film", serde_json::json!({"stack": stack, "roughness": roughness, "colour": colour}))
            }
            Self::Grating(of) => ("grating", of.table()),
            Self::Map { picture, surfaces } => {
                ("map", serde_json::json!({"file": picture.file, "surfaces": surfaces}))
            }
        };
        if let Value::Object(table) = &mut table {
            table.insert("type".to_owned(), kind.into());
        }
        table
    }
}

impl GratingDescription {
    fn read(table: &Value, place: &str) -> Result<Self> {
        let known = ["type", "sample", "file", "pigment", "index", "coherence_um"];
        let fields = Fields::new(table, place, &known)?;
        let source = match (fields.text("sample")?, fields.text("file")?) {
            (Some(sample), None) => GratingSource::Sample(sample.to_owned()),
            (None, Some(file)) => GratingSource::File(file.to_owned()),
            (given, _) => {
                return Err(Error::input(format!(
                    "{place} has {} heights; give either sample or file",
                    if given.is_some() { "two" } else { "no" }
                )));
            }
        };
        let within = |key: &str, low: f64, high: f64, usual: f64| {
            fields.get(key).map_or(Ok(usual), |_| fields.number_within(key, low, high))
        };
        Ok(Self {
            source,
            powers: None,
            content: String::new(),
            pigment: fields.get("pigment").map_or(Ok([0.0; 3]), |c| colour(c, &fields.path("pigment")))?,
            index: within("index", 1.01, 3.9, 1.5)?,
            coherence_um: within("coherence_um", 0.5, 1000.0, USUAL_COHERENCE_UM)?,
        })
    }

    /// Its table in a scene file, without its type.
    fn table(&self) -> Value {
        let mut table = serde_json::json!({
            "pigment": self.pigment,
            "index": self.index,
            "coherence_um": self.coherence_um,
        });
        let (key, value) = match &self.source {
            GratingSource::Sample(name) => ("sample", name),
            GratingSource::File(file) => ("file", file),
        };
        if let Value::Object(table) = &mut table {
            table.insert(key.to_owned(), value.as_str().into());
        }
        table
    }

    /// The surface.
    ///
    /// # Errors
    /// Its powers are not there yet; a coherence that they cannot be rendered with.
    pub(super) fn build(&self) -> Result<Grating> {
        let powers = self.powers.as_ref().ok_or_else(|| {
            let (GratingSource::Sample(name) | GratingSource::File(name)) = &self.source;
            Error::input(format!("the grating '{name}' is not read"))
        })?;
        Grating::new(powers, self.coherence_um, self.index, self.pigment.map(decode))
    }
}

impl Metal {
    fn read(fields: &Fields<'_>, place: &str) -> Result<Self> {
        let constant = ["index", "absorption"].iter().any(|key| fields.get(key).is_some());
        match (fields.text("metal")?, constant) {
            (Some("copper"), false) => Ok(Self::Copper),
            (Some(other), false) => Err(unknown(&fields.path("metal"), other, &METALS)),
            (None, true) => Ok(Self::Constant {
                index: fields.number_within("index", 0.001, 100.0)?,
                absorption: fields.number_within("absorption", 0.0, 100.0)?,
            }),
            (given, _) => Err(Error::input(format!(
                "{place} has {}; give either metal ({}) or index and absorption (n and k)",
                if given.is_some() { "a metal and an index" } else { "no metal" },
                METALS.join(", ")
            ))),
        }
    }
}

/// GGX α along and across: one number for both, or two.
fn roughness(fields: &Fields<'_>) -> Result<[f64; 2]> {
    let Some(Value::Array(_)) = fields.get("roughness") else {
        return Ok([fields.number_within("roughness", 0.02, 1.0)?; 2]);
    };
    match fields.numbers("roughness")?[..] {
        [along, across] if [along, across].iter().all(|a| (0.02..=1.0).contains(a)) => Ok([along, across]),
        _ => Err(Error::input(format!(
            "{}: give one number or two (along, across), each 0.02 to 1",
            fields.path("roughness")
        ))),
    }
}

/// A table without its `type`.
fn untyped(table: &Value) -> Value {
    let mut table = table.clone();
    if let Value::Object(table) = &mut table {
        table.remove("type");
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_choose_among_surfaces_that_exist() {
        let message = |surfaces: &str| {
            let table = format!(
                "b = {{type = 'map', file = 'b.png', surfaces = [{surfaces}]}}\nglass = {{type = 'dielectric', index = 1.5}}"
            );
            let table: BTreeMap<String, Value> = toml::from_str(&table).unwrap();
            let all: BTreeMap<_, _> = table
                .iter()
                .map(|(name, one)| (name.clone(), NamedSurface::read(one, name).unwrap()))
                .collect();
            all["b"].check("surfaces.b", &all)
        };
        assert!(message("'glass', 'glass'").is_ok());
        assert!(
            message("'glass', 'glas'")
                .unwrap_err()
                .to_string()
                .contains("surfaces.b.surfaces[1] is 'glas', did you mean 'glass'?")
        );
        assert!(message("'b'").unwrap_err().to_string().contains("surfaces.b.surfaces[0] is the map 'b'"));
    }

    #[test]
    fn bad_surfaces_are_refused_by_key() {
        let surface = |text: &str| {
            let table: Value = toml::from_str(text).unwrap();
            NamedSurface::read(&table, "surfaces.table").unwrap_err().to_string()
        };
        assert!(surface("index = 1").contains("surfaces.table.type is missing"));
        assert!(surface("type = 'difuse'").contains("did you mean 'diffuse'"));
        assert!(surface("type = 'dielectric'\nindex = 9").contains("surfaces.table.index is 9"));
        assert!(
            surface("type = 'dielectric'\nindex = 1.5\nroughness = 0")
                .contains("roughness is 0, outside 0.02 to 1")
        );
        assert!(surface("type = 'diffuse'\ncolour = 3").contains("surfaces.table.colour"));
        assert!(
            surface("type = 'keratin'\nroughness = 0.2\nindex = 1.5")
                .contains("surfaces.table.melanin is missing")
        );
        let diffuse = |text: &str| surface(&format!("type = 'diffuse'\n{text}"));
        assert!(diffuse("bump = 'a.png'").contains("surfaces.table.bump_um is missing"));
        assert!(diffuse("bump = 'a.png'\nbump_um = 1e6").contains("bump_um is 1000000, outside"));
        assert!(diffuse("bump_um = 3").contains("there is no picture surfaces.table.bump"));
        assert!(diffuse("bump = 'a.png'\nbump_um = 3\nnormal = 'b.png'").contains("are both given"));
        let map = |text: &str| surface(&format!("type = 'map'\n{text}"));
        assert!(map("surfaces = ['a']").contains("surfaces.table.file is missing"));
        assert!(map("file = 'a.png'").contains("surfaces.table.surfaces is missing"));
        assert!(map("file = 'a.png'\nsurfaces = []").contains("give 1 to 256 names"));
        assert!(map("file = 'a.png'\nsurfaces = ['a', 3]").contains("surfaces[1] is no text"));
        let metal = |text: &str| surface(&format!("type = 'conductor'\n{text}"));
        assert!(surface("type = 'conducter'").contains("did you mean 'conductor'"));
        assert!(metal("metal = 'copper'").contains("surfaces.table.roughness is missing"));
        assert!(metal("roughness = 0.01\nmetal = 'copper'").contains("roughness is 0.01, outside 0.02 to 1"));
        assert!(
            metal("roughness = [0.1, 2]\nmetal = 'copper'").contains("two (along, across), each 0.02 to 1")
        );
        assert!(metal("roughness = [0.1]\nmetal = 'copper'").contains("one number or two"));
        assert!(metal("roughness = 0.1\nmetal = 'coper'").contains("did you mean 'copper'"));
        assert!(metal("roughness = 0.1").contains("surfaces.table has no metal"));
        assert!(metal("roughness = 0.1\nmetal = 'copper'\nindex = 1").contains("has a metal and an index"));
        assert!(metal("roughness = 0.1\nindex = 1").contains("surfaces.table.absorption is missing"));
        assert!(metal("roughness = 0.1\nindex = 0\nabsorption = 1").contains("surfaces.table.index is 0"));
        assert!(metal("roughnes = 0.1").contains("did you mean 'roughness'"));
        let film = |text: &str| surface(&format!("type = 'film'\n{text}"));
        assert!(film("roughness = 0.1").contains("surfaces.table.stack is missing"));
        assert!(film("stack = 'air/keratn:400/air'").contains("did you mean 'keratin'"));
        assert!(film("stack = 'air/keratin:400/air'").contains("surfaces.table.roughness is missing"));
        assert!(
            film("stack = 'air/keratin:400/air'\nroughness = 0.1\ncolour = 3")
                .contains("surfaces.table.colour")
        );
    }
}
