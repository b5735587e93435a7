//! The campaign store: a Zarr v3 group with one chunk per unit of work in each array.
//!
//! The whole empty store is built aside and renamed into place. A chunk is written aside and renamed, so it exists whole
//! or not at all, however many processes write; its checksum (CRC-32C) is verified on reading. The arrays of a unit are written in a fixed order, so the unit is done when the last has its
//! chunk. The group's attributes hold every parameter and their hash.

mod aside;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use num_complex::Complex;
use rayon::prelude::*;
use serde_json::{Value, json};
use zarrs::array::{
    Array, ArrayBuilder, ArrayCreateError, ArrayError, BytesToBytesCodecTraits, Element, ElementOwned,
    FillValue, IntoArrayBytes, codec, data_type,
};
use zarrs::group::GroupBuilder;

use self::aside::Files;
use super::whole::read_text;
use crate::scattering::statistics::{AZIMUTHS, Axes, LAGS, Statistics, Unit};
use crate::{Error, Result};

/// Version of the store's layout.
const SCHEMA: u64 = 1;

/// Name of the array of kept fields.
const FIELDS: &str = "fields";

/// An array of the store.
struct ArrayKind {
    name: &'static str,
    /// f32, else f64.
    single: bool,
    /// Axes after φ_i.
    trailing: &'static [(&'static str, usize)],
    meaning: &'static str,
}

const POLARIZATION: (&str, usize) = ("polarization", 2);

/// Arrays in the order in which a unit writes them.
const ARRAYS: [ArrayKind; 7] = [
    ArrayKind {
        name: "u",
        single: true,
        trailing: &[POLARIZATION, ("azimuth", AZIMUTHS)],
        meaning: "mean of |E|^2/Phi_i over instances, 1/rad (S.12)",
    },
    ArrayKind {
        name: "v",
        single: true,
        trailing: &[POLARIZATION, ("azimuth", AZIMUTHS)],
        meaning: "|mean of E|^2/Phi_i without bias, 1/rad (S.21)",
    },
    ArrayKind {
        name: "autocovariance",
        single: true,
        trailing: &[POLARIZATION, ("lag", LAGS)],
        meaning: "autocovariance of the weighted field at lags 2k/1024 in x_o (S.30)",
    },
    ArrayKind {
        name: "reflected",
        single: false,
        trailing: &[POLARIZATION],
        meaning: "mean of Phi_r/Phi_i over instances",
    },
    ArrayKind {
        name: "reflected_std",
        single: false,
        trailing: &[POLARIZATION],
        meaning: "standard deviation of Phi_r/Phi_i over instances",
    },
    ArrayKind {
        name: "pattern_correlation",
        single: false,
        trailing: &[],
        meaning: "correlation of the two polarizations' intensity patterns",
    },
    ArrayKind {
        name: "contrast",
        single: false,
        trailing: &[],
        meaning: "contrast of the unpolarized intensity over instances",
    },
];

/// How far a store is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status {
    /// All units.
    pub units: usize,
    /// Units that are there and whole.
    pub done: usize,
    /// Units that are there but fail their checksums.
    pub damaged: usize,
}

impl Status {
    /// Units that are not there.
    #[must_use]
    pub fn missing(&self) -> usize {
        self.units - self.done - self.damaged
    }
}

/// An open campaign store.
pub struct Store {
    path: PathBuf,
    files: Arc<Files>,
    arrays: Vec<Array<Files>>,
    /// Fields of every instance, where the campaign keeps them.
    fields: Option<Array<Files>>,
    kept_nm: Vec<f64>,
    axes: Axes,
    instances: usize,
    name: String,
    width: String,
    description: Value,
}

impl Store {
    /// Creates a store, or opens the one that is there if it was made with the same description.
    ///
    /// `description` holds every parameter of the campaign; it is kept in the group's attributes with its hash, beside
    /// the structure's `name` and the SIMD `width` that computes it. The fields of all instances are kept at the
    /// wavelengths `kept_nm`.
    ///
    /// # Errors
    /// The path cannot be written, holds something else, or a store with other parameters or of another width; a kept
    /// wavelength that the campaign does not have.
    pub fn create(
        path: &Path,
        axes: &Axes,
        instances: usize,
        name: &str,
        description: &Value,
        kept_nm: &[f64],
        width: &str,
    ) -> Result<Self> {
        if let Some(nm) = kept_nm.iter().find(|nm| !axes.wavelengths_nm.contains(nm)) {
            return Err(Error::input(format!(
                "fields are to be kept at {nm} nm, which the campaign does not simulate"
            )));
        }
        let is_empty =
            |folder: &Path| std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_none());
        if !path.exists() || is_empty(path) {
            let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
            if !folder.is_dir() {
                return Err(Error::input(format!(
                    "{}: the store cannot be created (the folder {} does not exist)",
                    path.display(),
                    folder.display()
                )));
            }
            let attributes = json!({
                "barbule_store": SCHEMA,
                "wavelengths_nm": axes.wavelengths_nm,
                "cos_theta_i": axes.cos_theta,
                "cos_phi_i": axes.cos_phi,
                "instances": instances,
                "name": name,
                "simd": width,
                "kept_nm": kept_nm,
                "campaign": description,
                "campaign_hash": hash(description),
            });
            // Processes that create one store at the same instant each build their own; the first rename wins.
            aside::create_folder(path, |made| {
                build(path, made, axes, instances, kept_nm.len(), &attributes)
            })?;
        }
        let store = Self::open(path)?;
        let there = json!({"campaign": store.description, "kept_nm": store.kept_nm});
        let here = json!({"campaign": description, "kept_nm": kept_nm});
        if let Some(difference) = difference(&there, &here, "") {
            return Err(Error::input(format!(
                "{}: this store was made with other parameters ({difference}); give another name, or the same parameters to resume",
                path.display()
            )));
        }
        if store.width != width {
            return Err(Error::input(format!(
                "{}: was computed with {} instructions, this run would use {width}; give --simd {} to continue it with the same bits",
                path.display(),
                store.width,
                store.width
            )));
        }
        Ok(store)
    }

    /// Opens a store.
    ///
    /// # Errors
    /// Missing, unreadable, or not a campaign store of this version.
    pub fn open(path: &Path) -> Result<Self> {
        let refuse = |what: &str| Error::input(format!("{}: {what}", path.display()));
        if !path.exists() {
            return Err(refuse("no such store"));
        }
        let metadata = path.join("zarr.json");
        if !metadata.is_file() {
            return Err(refuse("is not a campaign store (no zarr.json in it)"));
        }
        let group: Value = serde_json::from_str(&read_text(&metadata)?)
            .map_err(|e| refuse(&format!("its zarr.json is damaged ({e})")))?;
        let attributes = &group["attributes"];
        if group["node_type"] != json!("group") || attributes["barbule_store"].as_u64() != Some(SCHEMA) {
            return Err(refuse("is not a campaign store of this version"));
        }
        let (axes, instances) = checked_axes(attributes).map_err(|what| refuse(&what))?;
        let description = attributes["campaign"].clone();
        if attributes["campaign_hash"] != json!(hash(&description)) {
            return Err(refuse("its parameters do not match their checksum"));
        }
        let kept_nm = numbers(attributes, "kept_nm").map_err(|what| refuse(&what))?;
        if let Some(nm) = kept_nm.iter().find(|nm| !axes.wavelengths_nm.contains(nm)) {
            return Err(refuse(&format!("its attribute 'kept_nm' has {nm}, which is no wavelength of it")));
        }
        let files = Arc::new(Files::new(path)?);
        // What the arrays are follows from the axes alone. Their own descriptions must say the same.
        let (arrays, fields) = arrays(&files, &axes, instances, kept_nm.len())
            .map_err(|e| refuse(&format!("its axes make no arrays ({e})")))?;
        for array in arrays.iter().chain(&fields) {
            let name = array.path().as_str().trim_start_matches('/');
            let text = read_text(&path.join(name).join("zarr.json"))?;
            let there: Value = serde_json::from_str(&text)
                .map_err(|e| refuse(&format!("the zarr.json of its array '{name}' is damaged ({e})")))?;
            let here = serde_json::to_value(array.metadata()).map_err(|e| refuse(&e.to_string()))?;
            for key in ["shape", "data_type", "chunk_grid", "chunk_key_encoding", "codecs"] {
                if there[key] != here[key] {
                    return Err(refuse(&format!("its array '{name}' has another {key} than its axes say")));
                }
            }
        }
        let text = |key: &str| attributes[key].as_str().unwrap_or_default().to_owned();
        let (name, width) = (text("name"), text("simd"));
        let path = path.to_owned();
        Ok(Self { path, files, arrays, fields, kept_nm, axes, instances, name, width, description })
    }

    /// Makes ready for writing: deletes what writers left that are no more, and tries whether files can be written.
    ///
    /// # Errors
    /// The store is not writable, or the disk is full.
    pub fn prepare_writing(&self) -> Result<()> {
        self.files.sweep();
        self.files.probe().map_err(|e| aside::failure(&self.path, "the store cannot be written", &e))
    }

    /// Ends writing: removes what it needed, unless other processes still write.
    pub fn end_writing(&self) {
        self.files.sweep();
        self.files.tidy();
    }

    /// How many units are done, missing and damaged; reads them all.
    #[must_use]
    pub fn status(&self) -> Status {
        let units: Vec<_> = self.units().collect();
        let count = |pick: &(dyn Fn(usize, usize) -> bool + Sync)| {
            units.par_iter().filter(|&&(w, t)| pick(w, t)).count()
        };
        let present = count(&|w, t| self.is_done(w, t));
        let done = count(&|w, t| self.is_whole(w, t));
        Status { units: units.len(), done, damaged: present.saturating_sub(done) }
    }

    /// The structure's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The SIMD width that computes this store.
    #[must_use]
    pub fn width(&self) -> &str {
        &self.width
    }

    /// The wavelengths, nm, at which the fields of all instances are kept.
    #[must_use]
    pub fn kept_nm(&self) -> &[f64] {
        &self.kept_nm
    }

    /// Whether the fields of this wavelength are kept.
    #[must_use]
    pub fn keeps(&self, wavelength: usize) -> bool {
        self.kept_nm.contains(&self.axes.wavelengths_nm[wavelength])
    }

    /// Whether a unit is there and every checksum in it holds.
    #[must_use]
    pub fn is_whole(&self, wavelength: usize, theta: usize) -> bool {
        self.read(wavelength, theta).is_some()
            && (!self.keeps(wavelength) || self.fields(wavelength, theta).is_some())
    }

    /// Kept fields of a unit, over √Φ_i, shape `[φ_i, polarization, e₁ e₂, instance, AZIMUTHS]`; `None` when they are
    /// missing or damaged.
    #[must_use]
    pub fn fields(&self, wavelength: usize, theta: usize) -> Option<Vec<Complex<f32>>> {
        let kept = self.kept_nm.iter().position(|nm| *nm == self.axes.wavelengths_nm[wavelength])?;
        let chunk = [kept as u64, theta as u64, 0, 0, 0, 0, 0];
        self.fields.as_ref()?.retrieve_chunk_if_exists::<Vec<Complex<f32>>>(&chunk).ok().flatten()
    }

    /// The axes of the campaign.
    #[must_use]
    pub fn axes(&self) -> &Axes {
        &self.axes
    }

    /// Number of instances M.
    #[must_use]
    pub fn instances(&self) -> usize {
        self.instances
    }

    /// The parameters given to [`Self::create`].
    #[must_use]
    pub fn description(&self) -> &Value {
        &self.description
    }

    /// All units (λ, θ_i), in the order of work.
    pub fn units(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let thetas = self.axes.cos_theta.len();
        (0..self.axes.wavelengths_nm.len()).flat_map(move |w| (0..thetas).map(move |t| (w, t)))
    }

    /// The units of shard `shard` of `shards`: neighbours, so that those of one wavelength mostly fall together.
    #[must_use]
    pub fn shard(&self, shard: usize, shards: usize) -> Vec<(usize, usize)> {
        let count = self.units().count();
        let bound = |shard: usize| count * shard / shards.max(1);
        self.units().skip(bound(shard)).take(bound(shard + 1) - bound(shard)).collect()
    }

    /// Whether a unit is there, by the presence of its last chunk.
    #[must_use]
    pub fn is_done(&self, wavelength: usize, theta: usize) -> bool {
        let last = self.chunk_path(ARRAYS.len() - 1, wavelength, theta);
        last.is_file()
    }

    fn chunk_path(&self, array: usize, wavelength: usize, theta: usize) -> PathBuf {
        let ArrayKind { name, trailing, .. } = ARRAYS[array];
        let mut path = self.path.join(name).join("c").join(wavelength.to_string()).join(theta.to_string());
        for _ in 0..=trailing.len() {
            path.push("0");
        }
        path
    }

    fn chunk(array: usize, wavelength: usize, theta: usize) -> Vec<u64> {
        let mut chunk = vec![wavelength as u64, theta as u64];
        chunk.resize(3 + ARRAYS[array].trailing.len(), 0);
        chunk
    }

    /// Writes a unit.
    ///
    /// # Errors
    /// The disk is full or the store is not writable.
    pub fn write(&self, wavelength: usize, theta: usize, unit: &Unit) -> Result<()> {
        if let (Some(array), Some(kept)) =
            (&self.fields, self.kept_nm.iter().position(|nm| *nm == self.axes.wavelengths_nm[wavelength]))
        {
            let chunk = [kept as u64, theta as u64, 0, 0, 0, 0, 0];
            self.replace(array, &chunk, &unit.fields)?;
        }
        let singles = [&unit.u, &unit.v, &unit.autocovariance];
        let doubles = [&unit.reflected, &unit.reflected_std, &unit.pattern_correlation, &unit.contrast];
        for (index, values) in singles.into_iter().enumerate() {
            self.write_chunk(index, wavelength, theta, values)?;
        }
        for (index, values) in doubles.into_iter().enumerate() {
            self.write_chunk(singles.len() + index, wavelength, theta, values)?;
        }
        Ok(())
    }

    fn write_chunk<T: Element + Clone>(
        &self,
        array: usize,
        wavelength: usize,
        theta: usize,
        values: &[T],
    ) -> Result<()>
    where
        Vec<T>: IntoArrayBytes<'static>,
    {
        self.replace(&self.arrays[array], &Self::chunk(array, wavelength, theta), values)
    }

    fn replace<T: Element + Clone>(&self, array: &Array<Files>, chunk: &[u64], values: &[T]) -> Result<()>
    where
        Vec<T>: IntoArrayBytes<'static>,
    {
        array.store_chunk(chunk, values.to_vec()).map_err(|e| match e {
            ArrayError::StorageError(e) => {
                aside::storage_failure(&self.path, "a chunk cannot be written", &e)
            }
            other => Error::machine(format!("{}: a chunk cannot be encoded ({other})", self.path.display())),
        })
    }

    /// Reads a unit; `None` when it is missing or damaged (its checksum fails), so that it can be computed again.
    #[must_use]
    pub fn read(&self, wavelength: usize, theta: usize) -> Option<Unit> {
        if !self.is_done(wavelength, theta) {
            return None;
        }
        Some(Unit {
            u: self.read_chunk(0, wavelength, theta)?,
            v: self.read_chunk(1, wavelength, theta)?,
            autocovariance: self.read_chunk(2, wavelength, theta)?,
            reflected: self.read_chunk(3, wavelength, theta)?,
            reflected_std: self.read_chunk(4, wavelength, theta)?,
            pattern_correlation: self.read_chunk(5, wavelength, theta)?,
            contrast: self.read_chunk(6, wavelength, theta)?,
            fields: Vec::new(),
        })
    }

    fn read_chunk<T: ElementOwned>(&self, array: usize, wavelength: usize, theta: usize) -> Option<Vec<T>>
    where
        Vec<T>: zarrs::array::FromArrayBytes,
    {
        self.arrays[array]
            .retrieve_chunk_if_exists::<Vec<T>>(&Self::chunk(array, wavelength, theta))
            .ok()
            .flatten()
    }

    /// All statistics of a finished store.
    ///
    /// # Errors
    /// Units are missing or damaged: says how many and which is first.
    pub fn statistics(&self) -> Result<Statistics> {
        let mut statistics = Statistics::empty(self.axes.clone(), self.instances);
        let mut missing = Vec::new();
        for (wavelength, theta) in self.units() {
            match self.read(wavelength, theta) {
                Some(unit) => statistics.append(unit),
                None => missing.push((wavelength, theta)),
            }
        }
        match missing.first() {
            None => Ok(statistics),
            Some(&(wavelength, theta)) => Err(Error::input(format!(
                "{}: {} of {} units are missing or damaged, the first at {} nm and cosθ = {}; run the same simulate command again to complete it",
                self.path.display(),
                missing.len(),
                self.units().count(),
                self.axes.wavelengths_nm[wavelength],
                self.axes.cos_theta[theta],
            ))),
        }
    }
}

/// The arrays of [`ARRAYS`], and that of kept fields.
type UnitArrays = (Vec<Array<Files>>, Option<Array<Files>>);

/// The arrays of a store as its axes say, and that of kept fields; nothing is read or written.
fn arrays(
    files: &Arc<Files>,
    axes: &Axes,
    instances: usize,
    kept: usize,
) -> std::result::Result<UnitArrays, ArrayCreateError> {
    let shape = [axes.wavelengths_nm.len(), axes.cos_theta.len(), axes.cos_phi.len()];
    let codecs = || -> Vec<Arc<dyn BytesToBytesCodecTraits>> {
        vec![Arc::new(codec::ZstdCodec::new(3, false)), Arc::new(codec::Crc32cCodec::new())]
    };
    let unit = |extents: &[u64]| {
        let mut chunk = extents.to_vec();
        chunk[..2].fill(1);
        chunk
    };
    let mut arrays = Vec::new();
    for ArrayKind { name, single, trailing, meaning } in ARRAYS {
        let extents: Vec<u64> =
            shape.iter().copied().chain(trailing.iter().map(|(_, n)| *n)).map(|n| n as u64).collect();
        let chunk = unit(&extents);
        let mut builder = if single {
            ArrayBuilder::new(extents, chunk, data_type::float32(), f32::NAN)
        } else {
            ArrayBuilder::new(extents, chunk, data_type::float64(), f64::NAN)
        };
        let names = ["wavelength", "theta_i", "phi_i"].into_iter().chain(trailing.iter().map(|(n, _)| *n));
        let mut attributes = serde_json::Map::new();
        attributes.insert("meaning".into(), json!(meaning));
        let array = builder
            .dimension_names(Some(names.collect::<Vec<_>>()))
            .attributes(attributes)
            .bytes_to_bytes_codecs(codecs())
            .build(files.clone(), &format!("/{name}"))?;
        arrays.push(array);
    }
    if kept == 0 {
        return Ok((arrays, None));
    }
    let extents = [kept, shape[1], shape[2], 2, 2, instances, AZIMUTHS].map(|n| n as u64);
    let nan = FillValue::from([f32::NAN.to_ne_bytes(), f32::NAN.to_ne_bytes()].concat());
    let names = ["kept_wavelength", "theta_i", "phi_i", "polarization", "component", "instance", "azimuth"];
    let fields = ArrayBuilder::new(extents.to_vec(), unit(&extents), data_type::complex64(), nan)
        .dimension_names(Some(names))
        .bytes_to_bytes_codecs(codecs())
        .build(files.clone(), &format!("/{FIELDS}"))?;
    Ok((arrays, Some(fields)))
}

/// Writes the store `path` without units into the folder `made`.
fn build(
    path: &Path,
    made: &Path,
    axes: &Axes,
    instances: usize,
    kept: usize,
    attributes: &Value,
) -> Result<()> {
    const WHAT: &str = "the store cannot be created";
    let refuse = |e: &dyn std::fmt::Display| Error::input(format!("{}: {WHAT} ({e})", path.display()));
    let files = Arc::new(Files::new(made)?);
    let (arrays, fields) = arrays(&files, axes, instances, kept).map_err(|e| refuse(&e))?;
    for array in arrays.iter().chain(&fields) {
        array.store_metadata().map_err(|e| aside::storage_failure(path, WHAT, &e))?;
    }
    let mut group = GroupBuilder::new().build(files.clone(), "/").map_err(|e| refuse(&e))?;
    if let Value::Object(attributes) = attributes {
        group.attributes_mut().extend(attributes.clone());
    }
    group.store_metadata().map_err(|e| aside::storage_failure(path, WHAT, &e))?;
    files.tidy();
    Ok(())
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
    let axes = Axes {
        wavelengths_nm: axis("wavelengths_nm", 100_000, 300.0, 830.0)?,
        cos_theta: axis("cos_theta_i", 200, 0.0, 1.0)?,
        cos_phi: axis("cos_phi_i", 200, 0.0, 1.0)?,
    };
    let instances = attributes["instances"]
        .as_u64()
        .and_then(|n| usize::try_from(n).ok())
        .filter(|n| (1..=10_000).contains(n))
        .ok_or("its attribute 'instances' is no number from 1 to 10000")?;
    Ok((axes, instances))
}

/// Hash of a description, independent of the order of its keys.
#[must_use]
pub fn hash(description: &Value) -> String {
    // serde_json keeps the keys of objects sorted.
    blake3::hash(description.to_string().as_bytes()).to_hex().to_string()
}

/// The first place where two descriptions differ: `key: there → here`.
fn difference(there: &Value, here: &Value, place: &str) -> Option<String> {
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
