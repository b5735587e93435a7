//! `[surfaces.NAME]`: what objects are made of.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

use super::colour::colour;
use super::kinds::{kind_of, unknown};
use super::{FibreDescription, PigmentedKeratin};
use crate::bsdf::Texture;
use crate::fields::Fields;
use crate::{Error, Result};

/// A surface with a name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum NamedSurface {
    /// Perfectly diffuse.
    Diffuse {
        /// sRGB, 0 … 1.
        colour: [f64; 3],
        /// Pictures by their keys: `albedo`, `alpha`, `normal`.
        pictures: BTreeMap<&'static str, TextureFile>,
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
}

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

/// Keys of pictures on diffuse surfaces: what the colour is multiplied with, what is black where there are holes, normals.
const PICTURES: [&str; 3] = ["albedo", "alpha", "normal"];

const TYPES: [&str; 5] = ["diffuse", "keratin", "hair", "dielectric", "conductor"];

/// Metals whose index is known.
const METALS: [&str; 1] = ["copper"];

impl NamedSurface {
    /// Reads `[surfaces.NAME]` with a `type`.
    pub(super) fn read(table: &Value, place: &str) -> Result<Self> {
        let kind = kind_of(table, place, &TYPES)?;
        match kind {
            "diffuse" => {
                let fields =
                    Fields::new(table, place, &["type", "colour", PICTURES[0], PICTURES[1], PICTURES[2]])?;
                let white = [1.0; 3];
                let mut pictures = BTreeMap::new();
                for key in PICTURES {
                    if let Some(file) = fields.text(key)? {
                        pictures.insert(key, TextureFile::new(file));
                    }
                }
                let colour = fields.get("colour").map_or(Ok(white), |c| colour(c, &fields.path("colour")))?;
                Ok(Self::Diffuse { colour, pictures })
            }
            "keratin" => Ok(Self::Keratin(PigmentedKeratin::read(&untyped(table), place)?)),
            "hair" => Ok(Self::Hair(FibreDescription::read(&untyped(table), place)?)),
            "dielectric" => {
                let fields = Fields::new(table, place, &["type", "index", "roughness"])?;
                let index = fields.number_within("index", 1.01, 3.9)?;
                let roughness = fields.get("roughness").map(|_| roughness(&fields)).transpose()?;
                Ok(Self::Dielectric { index, roughness })
            }
            _ => {
                let fields =
                    Fields::new(table, place, &["type", "roughness", "metal", "index", "absorption"])?;
                Ok(Self::Conductor { roughness: roughness(&fields)?, metal: Metal::read(&fields, place)? })
            }
        }
    }

    /// Its table in a scene file.
    pub(super) fn table(&self) -> Value {
        let (kind, mut table) = match self {
            Self::Diffuse { colour, pictures } => {
                let mut table = serde_json::json!({"colour": colour});
                if let Value::Object(table) = &mut table {
                    let named = |(key, picture): (&&str, &TextureFile)| {
                        ((*key).to_owned(), picture.file.as_str().into())
                    };
                    table.extend(pictures.iter().map(named));
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
        };
        if let Value::Object(table) = &mut table {
            table.insert("type".to_owned(), kind.into());
        }
        table
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
    }
}
