//! The campaign store: a Zarr v3 group with one chunk per unit of work in each array.
//!
//! A chunk is written aside and renamed, so it exists whole or not at all; its checksum (CRC-32C) is verified on
//! reading. The arrays of a unit are written in a fixed order, so the unit is done when the last has its
//! chunk. The group's attributes hold every parameter and their hash.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use num_complex::Complex;
use serde_json::{Value, json};
use zarrs::array::{Array, ArrayBuilder, Element, ElementOwned, FillValue, IntoArrayBytes, codec, data_type};
use zarrs::filesystem::FilesystemStore;
use zarrs::group::{Group, GroupBuilder};
use zarrs::storage::storage_adapter::atomic_write::AtomicWriteStorageAdapter;

use crate::scattering::statistics::{AZIMUTHS, Axes, LAGS, Statistics, Unit};
use crate::{Error, Result};

type Storage = AtomicWriteStorageAdapter<FilesystemStore>;

/// Version of the store's layout.
const SCHEMA: u64 = 1;

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

/// An open campaign store.
pub struct Store {
    path: PathBuf,
    arrays: Vec<Array<Storage>>,
    /// Fields of every instance, where the campaign keeps them.
    fields: Option<Array<Storage>>,
    kept_nm: Vec<f64>,
    axes: Axes,
    instances: usize,
    name: String,
    width: String,
    description: Value,
}

/// Name of the array of kept fields.
const FIELDS: &str = "fields";

impl Store {
    /// Creates a store, or opens the one that is there if it was made with the same description.
    ///
    /// `description` holds every parameter of the campaign; it is kept in the group's attributes with its hash, beside
    /// the structure's `name` and the SIMD `width` that computes it. The fields of all instances are kept at the
    /// wavelengths `kept_nm`.
    ///
    /// # Errors
    /// The path cannot be written, holds something else, or a store with other parameters; a kept wavelength that the
    /// campaign does not have.
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
        if path.exists() && !is_abandoned(path) {
            let store = Self::open(path)?;
            let there = json!({"campaign": store.description, "kept_nm": store.kept_nm});
            let here = json!({"campaign": description, "kept_nm": kept_nm});
            if let Some(difference) = difference(&there, &here, "") {
                return Err(Error::input(format!(
                    "{}: this store was made with other parameters ({difference}); give another name, or the same parameters to resume",
                    path.display()
                )));
            }
            return Ok(store);
        }
        let refuse = |what: &dyn std::fmt::Display| {
            Error::input(format!("{}: the store cannot be created ({what})", path.display()))
        };
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !folder.is_dir() {
            return Err(refuse(&format!("the folder {} does not exist", folder.display())));
        }
        let storage = storage(path)?;
        let shape = [axes.wavelengths_nm.len(), axes.cos_theta.len(), axes.cos_phi.len()];
        for ArrayKind { name, single, trailing, meaning } in ARRAYS {
            let extents: Vec<u64> =
                shape.iter().copied().chain(trailing.iter().map(|(_, n)| *n)).map(|n| n as u64).collect();
            let mut chunk = extents.clone();
            chunk[..2].fill(1);
            let mut builder = if single {
                ArrayBuilder::new(extents, chunk, data_type::float32(), f32::NAN)
            } else {
                ArrayBuilder::new(extents, chunk, data_type::float64(), f64::NAN)
            };
            let names =
                ["wavelength", "theta_i", "phi_i"].into_iter().chain(trailing.iter().map(|(n, _)| *n));
            let mut attributes = serde_json::Map::new();
            attributes.insert("meaning".into(), json!(meaning));
            let array = builder
                .dimension_names(Some(names.collect::<Vec<_>>()))
                .attributes(attributes)
                .bytes_to_bytes_codecs(vec![
                    Arc::new(codec::ZstdCodec::new(3, false)),
                    Arc::new(codec::Crc32cCodec::new()),
                ])
                .build(storage.clone(), &format!("/{name}"))
                .map_err(|e| refuse(&e))?;
            array.store_metadata().map_err(|e| refuse(&e))?;
        }
        if !kept_nm.is_empty() {
            create_fields(&storage, &shape, kept_nm.len(), instances).map_err(|e| refuse(&e))?;
        }
        // The group comes last: a store without it was never finished and is not opened.
        let mut group = GroupBuilder::new().build(storage, "/").map_err(|e| refuse(&e))?;
        let attributes = group.attributes_mut();
        attributes.insert("barbule_store".into(), json!(SCHEMA));
        attributes.insert("wavelengths_nm".into(), json!(axes.wavelengths_nm));
        attributes.insert("cos_theta_i".into(), json!(axes.cos_theta));
        attributes.insert("cos_phi_i".into(), json!(axes.cos_phi));
        attributes.insert("instances".into(), json!(instances));
        attributes.insert("name".into(), json!(name));
        attributes.insert("simd".into(), json!(width));
        attributes.insert("kept_nm".into(), json!(kept_nm));
        attributes.insert("campaign".into(), description.clone());
        attributes.insert("campaign_hash".into(), json!(hash(description)));
        group.store_metadata().map_err(|e| refuse(&e))?;
        Self::open(path)
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
        if !path.join("zarr.json").is_file() {
            return Err(refuse("is not a campaign store (no zarr.json in it)"));
        }
        let storage = storage(path)?;
        let group =
            Group::open(storage.clone(), "/").map_err(|e| refuse(&format!("is not readable ({e})")))?;
        let attributes = group.attributes();
        if attributes.get("barbule_store").and_then(Value::as_u64) != Some(SCHEMA) {
            return Err(refuse("is not a campaign store of this version"));
        }
        let numbers = |key: &str| -> Result<Vec<f64>> {
            attributes
                .get(key)
                .and_then(Value::as_array)
                .and_then(|values| values.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>())
                .filter(|values| !values.is_empty())
                .ok_or_else(|| refuse(&format!("its attribute '{key}' is missing or damaged")))
        };
        let axes = Axes {
            wavelengths_nm: numbers("wavelengths_nm")?,
            cos_theta: numbers("cos_theta_i")?,
            cos_phi: numbers("cos_phi_i")?,
        };
        let instances = attributes.get("instances").and_then(Value::as_u64).unwrap_or(0) as usize;
        let description = attributes.get("campaign").cloned().unwrap_or(Value::Null);
        if attributes.get("campaign_hash") != Some(&json!(hash(&description))) {
            return Err(refuse("its parameters do not match their checksum"));
        }
        let shape = [axes.wavelengths_nm.len(), axes.cos_theta.len(), axes.cos_phi.len()];
        let mut arrays = Vec::new();
        for ArrayKind { name, trailing, .. } in ARRAYS {
            let array = Array::open(storage.clone(), &format!("/{name}"))
                .map_err(|e| refuse(&format!("its array '{name}' is not readable ({e})")))?;
            let extents: Vec<u64> =
                shape.iter().copied().chain(trailing.iter().map(|(_, n)| *n)).map(|n| n as u64).collect();
            if array.shape() != extents.as_slice() {
                return Err(refuse(&format!("its array '{name}' does not have the shape of its axes")));
            }
            arrays.push(array);
        }
        let kept_nm = attributes
            .get("kept_nm")
            .and_then(Value::as_array)
            .map(|values| values.iter().filter_map(Value::as_f64).collect::<Vec<_>>())
            .unwrap_or_default();
        let fields = if kept_nm.is_empty() {
            None
        } else {
            let array = Array::open(storage, &format!("/{FIELDS}"))
                .map_err(|e| refuse(&format!("its array '{FIELDS}' is not readable ({e})")))?;
            Some(array)
        };
        let text = |key: &str| attributes.get(key).and_then(Value::as_str).unwrap_or_default().to_owned();
        let (name, width) = (text("name"), text("simd"));
        Ok(Self { path: path.to_owned(), arrays, fields, kept_nm, axes, instances, name, width, description })
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

    fn replace<T: Element + Clone>(&self, array: &Array<Storage>, chunk: &[u64], values: &[T]) -> Result<()>
    where
        Vec<T>: IntoArrayBytes<'static>,
    {
        // What an interrupted writer left aside would block this one.
        let mut aside = self.path.join(array.path().as_str().trim_start_matches('/')).join("c");
        aside.extend(chunk.iter().map(u64::to_string));
        let mut aside = aside.into_os_string();
        aside.push(".tmp");
        let _ = std::fs::remove_file(aside);
        array
            .store_chunk(chunk, values.to_vec())
            .map_err(|e| Error::machine(format!("{}: a chunk cannot be written ({e})", self.path.display())))
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

/// Makes the array of kept fields, one chunk per (kept wavelength, θ_i).
fn create_fields(
    storage: &Arc<Storage>,
    shape: &[usize; 3],
    kept: usize,
    instances: usize,
) -> std::result::Result<(), Box<dyn std::error::Error>> {
    let extents = [kept, shape[1], shape[2], 2, 2, instances, AZIMUTHS].map(|n| n as u64);
    let mut chunk = extents;
    chunk[..2].fill(1);
    let nan = FillValue::from([f32::NAN.to_ne_bytes(), f32::NAN.to_ne_bytes()].concat());
    let names = ["kept_wavelength", "theta_i", "phi_i", "polarization", "component", "instance", "azimuth"];
    let array = ArrayBuilder::new(extents.to_vec(), chunk.to_vec(), data_type::complex64(), nan)
        .dimension_names(Some(names))
        .bytes_to_bytes_codecs(vec![
            Arc::new(codec::ZstdCodec::new(3, false)),
            Arc::new(codec::Crc32cCodec::new()),
        ])
        .build(storage.clone(), &format!("/{FIELDS}"))?;
    array.store_metadata()?;
    Ok(())
}

fn storage(path: &Path) -> Result<Arc<Storage>> {
    let store = FilesystemStore::new(path)
        .map_err(|e| Error::input(format!("{}: is not a usable store folder ({e})", path.display())))?;
    Ok(Arc::new(AtomicWriteStorageAdapter::new(Arc::new(store))))
}

/// Whether a folder is what a creation leaves that was killed before its last file, the group's `zarr.json`.
fn is_abandoned(path: &Path) -> bool {
    let ours = |name: &std::ffi::OsStr| ARRAYS.iter().any(|kind| name == kind.name) || name == FIELDS;
    std::fs::read_dir(path).is_ok_and(|entries| {
        entries
            .into_iter()
            .all(|entry| entry.is_ok_and(|e| ours(&e.file_name()) || e.file_name() == "zarr.json.tmp"))
    })
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
