//! What a store is made of: its arrays and its attributes.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::aside::Files;
use super::coordinates::{Coordinate, coordinates};
use crate::io::whole::{failure, hash_bytes};
use crate::io::zarr::{Array, DataType, group_metadata};
use crate::scattering::statistics::{AZIMUTHS, Axes, GLINTS, LAGS, Sides};
use crate::spectrum::Wavelengths;
use crate::structure::MOST_INSTANCES;
use crate::{Error, Result};

/// The version of the layout; others are not read.
pub(super) const LAYOUT: u64 = 5;

/// What the attribute of the version says in the store of an atlas.
pub(in crate::io) const ATLAS: &str = "atlas";

/// The attribute that says that both signs of φ_i were simulated, and how; without it φ_i ≥ 0 stands for both.
const SIDES: &str = "sides";
const BOTH: &str = "both";

/// An array of the store.
struct ArrayKind {
    name: &'static str,
    data_type: DataType,
    /// Axes after φ_i.
    trailing: &'static [(&'static str, usize)],
    units: &'static str,
    meaning: &'static str,
}

const POLARIZATION: (&str, usize) = ("polarization", 2);

/// Number of arrays that every unit writes.
pub(super) const ARRAYS: usize = 9;

/// Arrays in the order in which a unit writes them.
const KINDS: [ArrayKind; ARRAYS] = [
    ArrayKind {
        name: "u",
        data_type: DataType::Float32,
        trailing: &[POLARIZATION, ("azimuth", AZIMUTHS)],
        units: "1/rad",
        meaning: "mean of |E|^2/Phi_i over instances (S.12)",
    },
    ArrayKind {
        name: "v",
        data_type: DataType::Float32,
        trailing: &[POLARIZATION, ("azimuth", AZIMUTHS)],
        units: "1/rad",
        meaning: "|mean of E|^2/Phi_i without bias (S.21)",
    },
    ArrayKind {
        name: "autocovariance",
        data_type: DataType::Float32,
        trailing: &[POLARIZATION, ("lag", LAGS)],
        units: "",
        meaning: "autocovariance of the weighted field at lags 2k/1024 in x_o (S.30)",
    },
    ArrayKind {
        name: "reflected",
        data_type: DataType::Float64,
        trailing: &[POLARIZATION],
        units: "",
        meaning: "mean of Phi_r/Phi_i over instances",
    },
    ArrayKind {
        name: "reflected_std",
        data_type: DataType::Float64,
        trailing: &[POLARIZATION],
        units: "",
        meaning: "standard deviation of Phi_r/Phi_i over instances",
    },
    ArrayKind {
        name: "pattern_correlation",
        data_type: DataType::Float64,
        trailing: &[],
        units: "",
        meaning: "correlation of the two polarizations' intensity patterns",
    },
    ArrayKind {
        name: "unpolarized_contrast",
        data_type: DataType::Float64,
        trailing: &[],
        units: "",
        meaning: "contrast of the unpolarized intensity over instances",
    },
    ArrayKind {
        name: "contrast",
        data_type: DataType::Float32,
        trailing: &[POLARIZATION, ("azimuth", AZIMUTHS)],
        units: "",
        meaning: "contrast of |E|^2 over instances",
    },
    ArrayKind {
        name: "glints",
        data_type: DataType::Float32,
        trailing: &[("glint", GLINTS.len()), INSTANCE],
        units: "1/rad",
        meaning: "unpolarized |E|^2/Phi_i of each instance at azimuths about the mirror direction",
    },
];

/// As long as the campaign has instances.
const INSTANCE: (&str, usize) = ("instance", 0);

/// The arrays of a store.
pub(super) struct Arrays {
    /// Those of every unit, in the order in which it writes them.
    pub(super) unit: [Array; ARRAYS],
    /// Fields of every instance, where the campaign keeps them.
    pub(super) fields: Option<Array>,
    /// What ties the chunks of a unit to it; the last that a unit writes.
    pub(super) digest: Array,
    pub(super) coordinates: Vec<Coordinate>,
}

impl Arrays {
    /// As the axes say; the wavelengths `kept_nm` keep their fields.
    fn new(axes: &Axes, instances: usize, kept_nm: &[f64]) -> Self {
        let shape = [axes.wavelengths_nm().len(), axes.cos_theta().len(), axes.phis()];
        let array = |name, data_type, units, meaning, dimensions: &[(&'static str, usize)]| {
            let (dimension_names, shape): (_, Vec<usize>) = dimensions.iter().copied().unzip();
            let mut chunk_shape = shape.clone();
            chunk_shape[..2].fill(1);
            Array { name, data_type, shape, chunk_shape, dimension_names, units, meaning }
        };
        let first = [("wavelength", shape[0]), ("theta_i", shape[1]), ("phi_i", shape[2])];
        let unit = KINDS.map(|ArrayKind { name, data_type, trailing, units, meaning }| {
            let trailing: Vec<_> = trailing
                .iter()
                .map(|dimension| if *dimension == INSTANCE { (INSTANCE.0, instances) } else { *dimension })
                .collect();
            array(name, data_type, units, meaning, &[&first[..], &trailing].concat())
        });
        let fields = (!kept_nm.is_empty()).then(|| {
            let dimensions = [
                ("kept_wavelength", kept_nm.len()),
                first[1],
                first[2],
                POLARIZATION,
                ("component", 2),
                ("instance", instances),
                ("azimuth", AZIMUTHS),
            ];
            array("fields", DataType::Complex64, "", "E along e1, e2 over sqrt(Phi_i)", &dimensions)
        });
        let digest = {
            let meaning = "of each array's chunk, in the order of writing and fields last: the first 8 bytes of BLAKE3 of campaign_hash, array, indices, bytes";
            array("digest", DataType::UInt64, "", meaning, &[first[0], first[1], ("array", ARRAYS + 1)])
        };
        let coordinates = coordinates(axes, instances, kept_nm);
        Self { unit, fields, digest, coordinates }
    }

    /// All of them.
    pub(super) fn all(&self) -> impl Iterator<Item = &Array> {
        let coordinates = self.coordinates.iter().map(|coordinate| &coordinate.array);
        self.unit.iter().chain(&self.fields).chain([&self.digest]).chain(coordinates)
    }

    /// The coordinates that are missing or not as the axes say.
    pub(super) fn damaged_coordinates(&self, files: &Files) -> impl Iterator<Item = &Coordinate> {
        self.coordinates.iter().filter(|coordinate| {
            let chunk = coordinate.chunk();
            files.read(&coordinate.key(), chunk.len()).is_none_or(|there| there != chunk)
        })
    }

    /// Writes the coordinates that are missing or not as the axes say.
    pub(super) fn write_coordinates(&self, files: &Files) -> std::io::Result<()> {
        self.damaged_coordinates(files)
            .try_for_each(|coordinate| files.write(&coordinate.key(), &coordinate.chunk()))
    }
}

/// What a store's attributes say.
pub(super) struct Attributes {
    pub(super) axes: Axes,
    pub(super) instances: usize,
    pub(super) name: String,
    pub(super) width: String,
    /// Wavelengths, nm, at which the fields of all instances are kept.
    pub(super) kept_nm: Vec<f64>,
    /// Every parameter of structure and simulation.
    pub(super) description: Value,
}

impl Attributes {
    /// Reads the attributes of a group and says which arrays they ask for. The checksum is left to [`Self::matches`].
    pub(super) fn read(attributes: &Value) -> std::result::Result<(Self, Arrays), String> {
        if attributes["barbule_store"] == json!(ATLAS) {
            return Err("is an atlas, not the store of a campaign; xarray opens it, and `barbule atlas` goes on with it".into());
        }
        let version =
            attributes["barbule_store"].as_u64().ok_or("is not a campaign store of this version")?;
        if version != LAYOUT {
            return Err(format!(
                "is not a campaign store of this version (its layout is {version}, this program's is {LAYOUT}); simulate again under another name"
            ));
        }
        let (axes, instances) = checked_axes(attributes)?;
        let text = |key: &str| attributes[key].as_str().unwrap_or_default().to_owned();
        let kept_nm = numbers(attributes, "kept_nm")?;
        if let Some(nm) = kept_nm.iter().find(|nm| !axes.wavelengths_nm().contains(nm)) {
            return Err(format!("its attribute 'kept_nm' has {nm}, which is no wavelength of it"));
        }
        let (name, width, description) = (text("name"), text("simd"), attributes["campaign"].clone());
        let arrays = Arrays::new(&axes, instances, &kept_nm);
        Ok((Self { axes, instances, name, width, kept_nm, description }, arrays))
    }

    /// Those of a new store.
    pub(super) fn new(
        axes: &Axes,
        instances: usize,
        name: &str,
        width: &str,
        kept_nm: &[f64],
        description: &Value,
    ) -> Self {
        Self {
            axes: axes.clone(),
            instances,
            name: name.into(),
            width: width.into(),
            kept_nm: kept_nm.to_vec(),
            description: description.clone(),
        }
    }

    /// Places across the barbule at which instances were lit in turn.
    pub(super) fn places(&self) -> usize {
        let recorded = self.description["places"].as_u64().and_then(|places| usize::try_from(places).ok());
        recorded.map_or(1, |places| places.clamp(1, self.instances))
    }

    /// Whether the checksum among a group's attributes is that of what was read from them.
    pub(super) fn matches(&self, attributes: &Value) -> bool {
        attributes["campaign_hash"] == json!(self.hash())
    }

    /// Checksum of all attributes, independent of the order of their keys.
    pub(super) fn hash(&self) -> String {
        let mut covered = self.covered();
        covered.sort_all_objects();
        hash_bytes(covered.to_string().as_bytes())
    }

    /// What the checksum is of.
    fn covered(&self) -> Value {
        let mut covered = json!({
            "barbule_store": LAYOUT,
            "wavelengths_nm": self.axes.wavelengths_nm(),
            "cos_theta_i": self.axes.cos_theta(),
            "cos_phi_i": self.axes.cos_phi(),
            "instances": self.instances,
            "name": self.name,
            "simd": self.width,
            "kept_nm": self.kept_nm,
            "campaign": self.description,
        });
        if self.axes.sides() == Sides::Both {
            covered[SIDES] = BOTH.into();
        }
        covered
    }

    /// Writes the store `path` without units into the folder `made`.
    pub(super) fn build(&self, path: &Path, made: &Path) -> Result<()> {
        let mut attributes = match self.covered() {
            Value::Object(attributes) => attributes,
            _ => Map::new(),
        };
        attributes.insert("campaign_hash".into(), json!(self.hash()));
        let arrays = Arrays::new(&self.axes, self.instances, &self.kept_nm);
        let files = Files::new(made);
        let refuse = |e: std::io::Error| failure(path, "the store cannot be created", &e);
        let write = |key: &str, metadata: &Value| {
            files.write(key, format!("{metadata:#}\n").as_bytes()).map_err(refuse)
        };
        for array in arrays.all() {
            write(&format!("{}/zarr.json", array.name), &array.metadata())?;
        }
        arrays.write_coordinates(&files).map_err(refuse)?;
        write("zarr.json", &group_metadata(&attributes, arrays.all()))?;
        files.tidy();
        Ok(())
    }

    /// Refuses, at the store `path`, to continue it with what `here` says; the first difference is named.
    pub(super) fn check_same(&self, path: &Path, here: &Self) -> Result<()> {
        let parts = |a: &Self| json!({"campaign": a.description, "kept_nm": a.kept_nm});
        // The axes follow from the description, unless somebody changed the file.
        let axes = |a: &Self| {
            json!({
                "wavelengths_nm": a.axes.wavelengths_nm(),
                "cos_theta_i": a.axes.cos_theta(),
                "cos_phi_i": a.axes.cos_phi(),
                "instances": a.instances,
                SIDES: if a.axes.sides() == Sides::Both { BOTH } else { "alike" },
            })
        };
        let found =
            difference(&parts(self), &parts(here), "").or_else(|| difference(&axes(self), &axes(here), ""));
        if let Some(difference) = found {
            return Err(Error::input(format!(
                "this store was made with other parameters ({difference}); give another name, or the same parameters to resume"
            ))
            .in_file(path));
        }
        if self.width != here.width {
            return Err(Error::input(format!(
                "was computed with {} instructions, this run would use {}; give `width` {} to continue it with the same bits",
                self.width, here.width, self.width
            ))
            .in_file(path)
            .naming(&["width"]));
        }
        Ok(())
    }
}

/// A list of numbers in a store's attributes.
fn numbers(attributes: &Value, key: &str) -> std::result::Result<Vec<f64>, String> {
    attributes[key]
        .as_array()
        .and_then(|values| values.iter().map(Value::as_f64).collect())
        .ok_or_else(|| format!("its attribute '{key}' is missing or damaged"))
}

/// Axes and number of instances, within what a campaign can have: a made-up store must not claim memory.
fn checked_axes(attributes: &Value) -> std::result::Result<(Axes, usize), String> {
    let axis = |key: &str, most: usize, from: f64, to: f64| {
        let values = numbers(attributes, key)?;
        if values.is_empty() || values.len() > most {
            return Err(format!("its attribute '{key}' has {} values; 1 to {most} can be", values.len()));
        }
        match values.iter().find(|v| !(from..=to).contains(*v)) {
            Some(bad) => Err(format!("its attribute '{key}' has {bad}, outside {from} to {to}")),
            None => Ok(values),
        }
    };
    let nm = axis("wavelengths_nm", 100_000, 300.0, 830.0)?;
    let (cos_theta, cos_phi) = (axis("cos_theta_i", 200, 0.0, 1.0)?, axis("cos_phi_i", 200, 0.0, 1.0)?);
    let sides = match &attributes[SIDES] {
        Value::Null => Sides::Alike,
        Value::String(text) if text == BOTH => Sides::Both,
        _ => return Err(format!("its attribute '{SIDES}' is not '{BOTH}', all it can be")),
    };
    let axes = Wavelengths::new(nm)
        .and_then(|wavelengths| Axes::new(&wavelengths, cos_theta, cos_phi))
        .map_err(|e| e.to_string())?
        .with_sides(sides);
    let instances = attributes["instances"]
        .as_u64()
        .and_then(|n| usize::try_from(n).ok())
        .filter(|n| (1..=MOST_INSTANCES).contains(n))
        .ok_or("its attribute 'instances' is no number from 1 to 10000")?;
    Ok((axes, instances))
}

/// The first place where two descriptions differ: `key: there → here`.
pub(in crate::io) fn difference(there: &Value, here: &Value, place: &str) -> Option<String> {
    match (there, here) {
        (Value::Object(a), Value::Object(b)) => a.keys().chain(b.keys()).find_map(|key| {
            let place = if place.is_empty() { key.clone() } else { format!("{place}.{key}") };
            difference(a.get(key).unwrap_or(&Value::Null), b.get(key).unwrap_or(&Value::Null), &place)
        }),
        _ if there == here => None,
        _ => {
            let short = |v: &Value| v.to_string().chars().take(60).collect::<String>();
            Some(format!("{place}: {} there, {} here", short(there), short(here)))
        }
    }
}
