//! The campaign store: a Zarr v3 group with one chunk per unit of work in each array.
//!
//! The whole empty store is built aside and renamed into place. A chunk is written aside and renamed, so it exists whole
//! or not at all, however many processes write; its checksum (CRC-32C) is verified on reading. The arrays of a unit are
//! written in a fixed order and then a digest of them all, which ties them to their unit and campaign; so the unit is
//! done when its digest is there. The group's attributes hold every parameter and their hash.

mod aside;
mod coordinates;
mod layout;
mod running;
mod survey;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use num_complex::Complex;
use serde_json::{Value, json};

pub(super) use self::aside::{Files, create_folder, create_store, sweep_beside};
use self::coordinates::Coordinate;
use self::layout::{ARRAYS, Arrays, Attributes};
pub(super) use self::layout::{ATLAS, difference};
pub use self::running::{Announced, Run};
pub(super) use self::survey::Deal;
pub use self::survey::{Part, Survey};
use super::whole::{failure, read_text};
use super::zarr::{Array, Element};
use crate::progress::Shard;
use crate::scattering::statistics::{Axes, Statistics, Unit, UnitStatistics};
use crate::{Error, Result};

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
    files: Files,
    attributes: Attributes,
    arrays: Arrays,
    /// BLAKE3 of the attributes, in hexadecimal.
    hash: String,
}

impl Store {
    /// Creates a store, or opens the one that is there if it was made with the same description.
    ///
    /// `description` holds every parameter of the campaign; it is kept in the group's attributes with its hash, beside
    /// the structure's `name` and the SIMD `width` that computes it. The fields of all instances are kept at the
    /// wavelengths `kept_nm`.
    ///
    /// # Errors
    /// The path cannot be written, holds something else, or a store with other parameters, of another width or of an
    /// older layout; a kept wavelength that the campaign does not have.
    pub fn create(
        path: &Path,
        axes: &Axes,
        instances: usize,
        name: &str,
        description: &Value,
        kept_nm: &[f64],
        width: &str,
    ) -> Result<Self> {
        if let Some(nm) = kept_nm.iter().find(|nm| !axes.wavelengths_nm().contains(nm)) {
            return Err(Error::input(format!(
                "fields are to be kept at {nm} nm, which the campaign does not simulate"
            )));
        }
        let here = Attributes::new(axes, instances, name, width, kept_nm, description);
        let path = &create_store(path, "another campaign store", |path, made| here.build(path, made))?;
        let store = Self::open(path)?;
        store.attributes.check_same(path, &here)?;
        Ok(store)
    }

    /// Opens a store.
    ///
    /// # Errors
    /// Missing, unreadable, or not a campaign store of this version.
    pub fn open(path: &Path) -> Result<Self> {
        let refuse = |what: &str| Error::input(what).in_file(path);
        if !path.exists() {
            return Err(refuse("no such store"));
        }
        let metadata = path.join("zarr.json");
        if !metadata.is_file() {
            return Err(refuse("is not a campaign store (no zarr.json in it)"));
        }
        let group: Value = serde_json::from_str(&read_text(&metadata)?)
            .map_err(|e| refuse(&format!("its zarr.json is damaged ({e})")))?;
        if group["node_type"] != json!("group") {
            return Err(refuse("is not a campaign store of this version"));
        }
        // What the arrays are follows from the axes alone. Their own descriptions must say the same.
        let (attributes, arrays) = Attributes::read(&group["attributes"]).map_err(|what| refuse(&what))?;
        for array in arrays.all() {
            let name = array.name;
            let text = read_text(&path.join(name).join("zarr.json"))?;
            let there: Value = serde_json::from_str(&text)
                .map_err(|e| refuse(&format!("the zarr.json of its array '{name}' is damaged ({e})")))?;
            let here = array.metadata();
            for key in ["shape", "data_type", "chunk_grid", "chunk_key_encoding", "codecs"] {
                if there[key] != here[key] {
                    return Err(refuse(&format!("its array '{name}' has another {key} than its axes say")));
                }
            }
        }
        if !attributes.matches(&group["attributes"]) {
            return Err(refuse("its parameters do not match their checksum"));
        }
        let hash = attributes.hash();
        let (path, files) = (path.to_owned(), Files::new(path));
        Ok(Self { path, files, attributes, arrays, hash })
    }

    /// Refuses to be filled by a campaign with other axes or another number of instances.
    ///
    /// # Errors
    /// They differ.
    pub fn check_belongs(&self, axes: &Axes, instances: usize) -> Result<()> {
        if *self.axes() == *axes && self.instances() == instances {
            return Ok(());
        }
        Err(Error::input(format!(
            "{}: has other wavelengths, directions or instances than the campaign; give another name",
            self.path.display()
        )))
    }

    /// Makes ready for writing: deletes what writers left that are no more, tries whether files can be written, and
    /// restores coordinates that somebody changed or lost.
    ///
    /// # Errors
    /// The store is not writable, or the disk is full.
    pub fn prepare_writing(&self) -> Result<()> {
        self.files.sweep();
        let done = self.files.probe().and_then(|()| self.arrays.write_coordinates(&self.files));
        self.files.tidy();
        done.map_err(|e| failure(&self.path, "the store cannot be written", &e))
    }

    /// Ends writing: removes what it needed, unless other processes still write.
    pub fn end_writing(&self) {
        self.files.sweep();
        self.files.tidy();
        aside::sweep_beside(&self.path);
    }

    /// Lets others see ([`Self::survey`]) that this process computes a part of the units, until what is given back is dropped.
    /// Where this cannot be written, nobody sees it, and the work is the same.
    #[must_use = "what is announced ends with it"]
    pub fn announce(&self, shard: Shard) -> Announced<'_> {
        self.files.announce(shard)
    }

    /// As [`Self::announce`], until [`Self::leave`] or the end of this value.
    pub(crate) fn enter(&self, shard: Shard) {
        self.files.enter(shard);
    }

    /// Ends what [`Self::enter`] began.
    pub(crate) fn leave(&self) {
        self.files.leave();
    }

    /// How far every unit is, and which processes compute; reads all units.
    #[must_use]
    pub fn survey(&self) -> Survey {
        let units: Vec<_> = self.units().collect();
        let key = |at: usize| self.arrays.digest.chunk_path(&[units[at].0, units[at].1]);
        Survey::new(&self.files, units.len(), Deal::Neighbours, &key, &|at| {
            self.is_whole(units[at].0, units[at].1)
        })
    }

    /// How many units are done, missing and damaged; reads them all.
    #[must_use]
    pub fn status(&self) -> Status {
        self.survey().status()
    }

    /// The names of the coordinates (`wavelength`, `theta_i` …) that are missing or not as the attributes say. Units do not
    /// need them, but other readers find their values by them: a missing one is zeros there. [`Self::prepare_writing`]
    /// restores them.
    #[must_use]
    pub fn damaged_coordinates(&self) -> Vec<&'static str> {
        self.arrays.damaged_coordinates(&self.files).map(|coordinate| coordinate.array.name).collect()
    }

    /// The structure's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.attributes.name
    }

    /// The SIMD width that computes this store.
    #[must_use]
    pub fn width(&self) -> &str {
        &self.attributes.width
    }

    /// The wavelengths, nm, at which the fields of all instances are kept.
    #[must_use]
    pub fn kept_nm(&self) -> &[f64] {
        &self.attributes.kept_nm
    }

    /// Whether the fields of this wavelength are kept.
    #[must_use]
    pub fn keeps(&self, wavelength: usize) -> bool {
        self.kept(wavelength).is_some()
    }

    /// Which of the kept wavelengths this one is.
    fn kept(&self, wavelength: usize) -> Option<usize> {
        let nm = self.attributes.axes.wavelengths_nm().get(wavelength)?;
        self.attributes.kept_nm.iter().position(|kept| kept == nm)
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
        let array = self.arrays.fields.as_ref()?;
        let chunk = [self.kept(wavelength)?, theta];
        let bytes = self.sealed(array, &chunk, &self.digest([wavelength, theta])?, ARRAYS)?;
        array.decode(&bytes).filter(|fields: &Vec<Complex<f32>>| fields.iter().all(|e| e.is_finite()))
    }

    /// The axes of the campaign.
    #[must_use]
    pub fn axes(&self) -> &Axes {
        &self.attributes.axes
    }

    /// Number of instances M.
    #[must_use]
    pub fn instances(&self) -> usize {
        self.attributes.instances
    }

    /// The parameters given to [`Self::create`].
    #[must_use]
    pub fn description(&self) -> &Value {
        &self.attributes.description
    }

    /// The numbers of all units (λ, θ_i), in the order of work.
    pub fn units(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        self.axes().units().map(|unit| (unit.wavelength, unit.theta))
    }

    /// Whether a unit is there, by the presence of its last chunk.
    #[must_use]
    pub fn is_done(&self, wavelength: usize, theta: usize) -> bool {
        self.files.has(&self.arrays.digest.chunk_path(&[wavelength, theta]))
    }

    /// The files of a unit, relative to the store and with `/`, in the order of writing: it is done when the last is there. A copy
    /// that is made in this order is a store at any time.
    #[must_use]
    pub fn unit_files(&self, Unit { wavelength, theta }: Unit) -> Vec<String> {
        let kept = self.kept(wavelength);
        let fields = self.arrays.fields.iter().filter_map(|array| Some(array.chunk_path(&[kept?, theta])));
        let others = self.arrays.unit.iter().chain([&self.arrays.digest]);
        fields.chain(others.map(|array| array.chunk_path(&[wavelength, theta]))).collect()
    }

    /// The files that a store has without any unit: descriptions and coordinates, that of the group last.
    #[must_use]
    pub fn own_files(&self) -> Vec<String> {
        let described = self.arrays.all().map(|array| format!("{}/zarr.json", array.name));
        let coordinates = self.arrays.coordinates.iter().map(Coordinate::key);
        described.chain(coordinates).chain(["zarr.json".into()]).collect()
    }

    /// Writes a unit.
    ///
    /// # Errors
    /// The disk is full or the store is not writable; the unit is of other axes than the store; its values are none that
    /// a reflection can have.
    pub fn write(&self, wavelength: usize, theta: usize, unit: &UnitStatistics) -> Result<()> {
        if !is_possible(unit) {
            return Err(Error::not_settled(format!(
                "{}: the unit at {} nm and cosθ = {} came out with values that are not finite or negative",
                self.path.display(),
                self.attributes.axes.wavelengths_nm()[wavelength],
                self.attributes.axes.cos_theta()[theta],
            )));
        }
        let at = [wavelength, theta];
        let mut digests = [0; ARRAYS + 1];
        if let (Some(fields), Some(kept)) = (&self.arrays.fields, self.kept(wavelength)) {
            digests[ARRAYS] = self.write_chunk(fields, [kept, theta], &unit.fields)?;
        }
        let arrays = &self.arrays.unit;
        digests[0] = self.write_chunk(&arrays[0], at, &unit.u)?;
        digests[1] = self.write_chunk(&arrays[1], at, &unit.v)?;
        digests[2] = self.write_chunk(&arrays[2], at, &unit.autocovariance)?;
        digests[3] = self.write_chunk(&arrays[3], at, &unit.reflected)?;
        digests[4] = self.write_chunk(&arrays[4], at, &unit.reflected_std)?;
        digests[5] = self.write_chunk(&arrays[5], at, &unit.pattern_correlation)?;
        digests[6] = self.write_chunk(&arrays[6], at, &unit.unpolarized_contrast)?;
        digests[7] = self.write_chunk(&arrays[7], at, &unit.contrast)?;
        digests[8] = self.write_chunk(&arrays[8], at, &unit.glints)?;
        self.write_chunk(&self.arrays.digest, at, &digests)?;
        Ok(())
    }

    /// Writes a chunk; its digest.
    fn write_chunk<T: Element>(&self, array: &Array, at: [usize; 2], values: &[T]) -> Result<u64> {
        let Some(bytes) = array.encode(values) else {
            return Err(Error::input(format!(
                "{}: {} values cannot be a chunk of its array '{}', which has {}; the campaign has other axes than the store",
                self.path.display(),
                values.len(),
                array.name,
                array.chunk_len()
            )));
        };
        let key = array.chunk_path(&at);
        self.files.write(&key, &bytes).map_err(|e| failure(&self.path, "a chunk cannot be written", &e))?;
        Ok(self.digest_of(&key, &bytes))
    }

    /// What ties a chunk to its place in this campaign.
    fn digest_of(&self, key: &str, bytes: &[u8]) -> u64 {
        let mut hasher = blake3::Hasher::new();
        for part in [self.hash.as_bytes(), key.as_bytes()] {
            hasher.update(&(part.len() as u64).to_le_bytes()).update(part);
        }
        let hash = hasher.update(bytes).finalize();
        hash.as_bytes().first_chunk().copied().map_or(0, u64::from_le_bytes)
    }

    /// The digests of a unit's chunks: `None` where they are missing or damaged.
    fn digest(&self, at: [usize; 2]) -> Option<Vec<u64>> {
        let array = &self.arrays.digest;
        array.decode(&self.files.read(&array.chunk_path(&at), array.most_bytes())?)
    }

    /// The bytes of a chunk that has the digest number `index`.
    fn sealed(&self, array: &Array, at: &[usize; 2], digests: &[u64], index: usize) -> Option<Vec<u8>> {
        let key = array.chunk_path(at);
        let bytes = self.files.read(&key, array.most_bytes())?;
        (digests.get(index) == Some(&self.digest_of(&key, &bytes))).then_some(bytes)
    }

    /// Reads a unit; `None` when it is missing or damaged (a checksum or digest fails, a chunk is not of the length that
    /// its shape asks for, or has values that no reflection has), so that it can be computed again.
    #[must_use]
    pub fn read(&self, wavelength: usize, theta: usize) -> Option<UnitStatistics> {
        if !self.is_done(wavelength, theta) {
            return None;
        }
        let at = [wavelength, theta];
        let digests = self.digest(at)?;
        let unit = UnitStatistics {
            u: self.read_chunk(0, &at, &digests)?,
            v: self.read_chunk(1, &at, &digests)?,
            autocovariance: self.read_chunk(2, &at, &digests)?,
            reflected: self.read_chunk(3, &at, &digests)?,
            reflected_std: self.read_chunk(4, &at, &digests)?,
            pattern_correlation: self.read_chunk(5, &at, &digests)?,
            unpolarized_contrast: self.read_chunk(6, &at, &digests)?,
            contrast: self.read_chunk(7, &at, &digests)?,
            glints: self.read_chunk(8, &at, &digests)?,
            fields: Vec::new(),
        };
        is_possible(&unit).then_some(unit)
    }

    fn read_chunk<T: Element>(&self, index: usize, at: &[usize; 2], digests: &[u64]) -> Option<Vec<T>> {
        let array = &self.arrays.unit[index];
        array.decode(&self.sealed(array, at, digests, index)?)
    }

    /// All statistics of a finished store.
    ///
    /// # Errors
    /// Units are missing or damaged: says how many and which is first.
    pub fn statistics(&self) -> Result<Statistics> {
        let mut statistics = Statistics::empty(self.attributes.axes.clone(), self.attributes.instances)
            .with_places(self.attributes.places());
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
                self.attributes.axes.wavelengths_nm()[wavelength],
                self.attributes.axes.cos_theta()[theta],
            ))),
        }
    }
}

/// Whether values can be those of a reflection: finite, and intensities not negative. What is relative to the light that
/// comes back is undefined where none does.
fn is_possible(unit: &UnitStatistics) -> bool {
    let intensity = |values: &[f64]| values.iter().all(|v| v.is_finite() && *v >= 0.0);
    unit.u.iter().all(|v| v.is_finite() && *v >= 0.0)
        // Glints of several places are departures from their means.
        && unit.v.iter().chain(&unit.autocovariance).chain(&unit.glints).all(|v| v.is_finite())
        && intensity(&unit.reflected)
        && intensity(&unit.reflected_std)
        && unit.unpolarized_contrast.iter().all(|v| v.is_nan() || *v >= 0.0)
        && unit.contrast.iter().all(|v| v.is_finite() && *v >= 0.0)
        && !unit.pattern_correlation.iter().any(|v| v.is_infinite())
        && unit.fields.iter().all(|e| e.is_finite())
}
