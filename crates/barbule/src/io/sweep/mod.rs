//! The store of a sweep: a Zarr v3 group of arrays over cells, one file of each array per unit of work.
//!
//! The whole empty store is built aside and renamed into place. A file is written aside and renamed, so it exists whole or not at
//! all, however many processes write. The arrays of a unit are written in a fixed order and then a digest of them all, which ties
//! them to their unit and sweep; so the unit is done when its digest is there. The group's attributes hold every parameter and
//! their hash. While units are missing, a hidden folder holds how long those that are there took; with the last unit it goes, and
//! what stays depends on the plan alone.

mod layout;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use serde_json::Value;

use self::layout::{GROUP, MATERIALS};
pub use self::layout::{MOST_CELLS, SweepArray, SweepAxis, SweepCoordinate, SweepLayout};
use super::store::{ATLAS, Announced, Deal, Files, Status, Survey, create_store, sweep_beside};
use super::whole::{failure, read_text};
use super::zarr::Sharded;
use crate::progress::Shard;
use crate::{Error, Result};

/// Where the times of units are while the store is unfinished.
const TIMES: &str = ".times";

/// The longest text of a time.
const TIME_BYTES: usize = 64;

/// The largest material that is read back, 1 GiB.
const MOST_MATERIAL: usize = 1 << 30;

/// Numbers of one array, of the cells of a unit in their order.
#[derive(Debug, Clone, PartialEq)]
pub enum SweepValues {
    /// Measures.
    Floats(Vec<f64>),
    /// Whole numbers from 0 to 255.
    Bytes(Vec<u8>),
}

/// What a unit of work brings.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepUnit {
    /// One for each array of the layout, in its order.
    pub values: Vec<SweepValues>,
    /// Numbers of cells with the bytes of their materials, rising; cells that are no structure have none.
    pub materials: Vec<(usize, Vec<u8>)>,
}

/// An open store.
pub struct SweepStore {
    path: PathBuf,
    files: Files,
    layout: SweepLayout,
    arrays: Vec<Sharded>,
    digest: Sharded,
    /// BLAKE3 of the attributes, in hexadecimal.
    hash: String,
}

impl SweepStore {
    /// Creates a store, or opens the one that is there if it is of the same layout.
    ///
    /// # Errors
    /// The path cannot be written, holds something else, or a store of another plan, width or version; a layout that no store can
    /// have.
    pub fn create(path: &Path, layout: SweepLayout) -> Result<Self> {
        layout.check()?;
        let path = &create_store(path, "another store", |path, made| layout.build(path, made))?;
        Self::open(path, layout)
    }

    /// Opens a store of this layout.
    ///
    /// # Errors
    /// Missing, unreadable, or of another plan, width or version.
    pub fn open(path: &Path, layout: SweepLayout) -> Result<Self> {
        layout.check()?;
        let refuse = |what: &str| Error::input(what).in_file(path);
        if !path.exists() {
            return Err(refuse("no such store"));
        }
        let metadata = path.join(GROUP);
        if !metadata.is_file() {
            return Err(refuse("is not the store of an atlas (no zarr.json in it)"));
        }
        let group: Value = serde_json::from_str(&read_text(&metadata)?)
            .map_err(|e| refuse(&format!("its zarr.json is damaged ({e})")))?;
        layout.check_same(path, &group)?;
        let arrays = layout.arrays.iter().map(|array| layout.sharded(array)).collect();
        let (digest, hash) = (layout.digest(), layout.hash());
        Ok(Self { path: path.to_owned(), files: Files::new(path), layout, arrays, digest, hash })
    }

    /// The SIMD instructions that the store `path` is computed with; `None` where there is none that can be read.
    #[must_use]
    pub fn width_of(path: &Path) -> Option<String> {
        let group: Value = serde_json::from_str(&read_text(&path.join(GROUP)).ok()?).ok()?;
        let attributes = &group["attributes"];
        let width = attributes["simd"].as_str().filter(|_| attributes["barbule_store"] == ATLAS);
        width.map(str::to_owned)
    }

    /// What it is made of.
    #[must_use]
    pub fn layout(&self) -> &SweepLayout {
        &self.layout
    }

    /// Makes ready for writing: deletes what writers left that are no more, tries whether files can be written, and restores
    /// coordinates and metadata of arrays that somebody changed or lost.
    ///
    /// # Errors
    /// The store is not writable, or the disk is full.
    pub fn prepare_writing(&self) -> Result<()> {
        self.files.sweep();
        // The group's own metadata were held against the plan; whoever wrote them anew may have laid them out otherwise.
        let own = self.layout.own_files().into_iter().filter(|(key, _)| key != GROUP);
        let restored = || {
            own.into_iter().try_for_each(|(key, bytes)| {
                let is_there = self.files.read(&key, bytes.len()).is_some_and(|there| there == bytes);
                if is_there { Ok(()) } else { self.files.write(&key, &bytes) }
            })
        };
        let done = self.files.probe().and_then(|()| restored());
        self.files.tidy();
        done.map_err(|e| failure(&self.path, "the store cannot be written", &e))
    }

    /// Ends writing: removes what it needed, unless other processes still write, and the times once every unit is there.
    pub fn end_writing(&self) {
        if (0..self.layout.units()).all(|unit| self.is_done(unit)) {
            // What cannot be removed does no harm.
            let _ = std::fs::remove_dir_all(self.path.join(TIMES));
        }
        self.files.sweep();
        self.files.tidy();
        sweep_beside(&self.path);
    }

    /// Whether a unit is there, by the presence of its last file.
    #[must_use]
    pub fn is_done(&self, unit: usize) -> bool {
        self.files.has(&self.digest.path(&[unit]))
    }

    /// Whether a unit is there and every checksum in it holds.
    #[must_use]
    pub fn is_whole(&self, unit: usize) -> bool {
        self.read(unit).is_some()
    }

    /// Lets others see ([`Self::survey`]) that this process computes a part of the units, until what is given back is dropped.
    /// Where this cannot be written, nobody sees it, and the work is the same.
    #[must_use = "what is announced ends with it"]
    pub fn announce(&self, shard: Shard) -> Announced<'_> {
        self.files.announce(shard)
    }

    /// As [`Self::announce`], until [`Self::leave`] or the end of this value.
    pub fn enter(&self, shard: Shard) {
        self.files.enter(shard);
    }

    /// Ends what [`Self::enter`] began.
    pub fn leave(&self) {
        self.files.leave();
    }

    /// How far every unit is, and which processes compute; reads all units.
    #[must_use]
    pub fn survey(&self) -> Survey {
        let key = |unit: usize| self.digest.path(&[unit]);
        Survey::new(&self.files, self.layout.units(), Deal::InTurn, &key, &|unit| self.is_whole(unit))
    }

    /// How many units are done, missing and damaged; reads them all.
    #[must_use]
    pub fn status(&self) -> Status {
        self.survey().status()
    }

    /// Seconds that units took that are there; none of a finished store.
    #[must_use]
    pub fn seconds(&self) -> Vec<f64> {
        let of = |unit: usize| {
            let bytes = self.files.read(&format!("{TIMES}/{unit}"), TIME_BYTES)?;
            let seconds: f64 = std::str::from_utf8(&bytes).ok()?.trim().parse().ok()?;
            (seconds.is_finite() && seconds >= 0.0).then_some(seconds)
        };
        (0..self.layout.units()).filter(|unit| self.is_done(*unit)).filter_map(of).collect()
    }

    /// Bytes of the store's files as they are.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let mut open = vec![self.path.clone()];
        let mut bytes = 0;
        while let Some(folder) = open.pop() {
            for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
                match entry.metadata() {
                    Ok(found) if found.is_dir() => open.push(entry.path()),
                    Ok(found) => bytes += found.len(),
                    Err(_) => {}
                }
            }
        }
        bytes
    }

    /// Writes a unit that took so many seconds.
    ///
    /// # Errors
    /// The disk is full or the store is not writable; the unit has other values than the layout says, or infinite ones.
    pub fn write(&self, unit: usize, found: &SweepUnit, seconds: f64) -> Result<()> {
        let cells = self.layout.cells_of(unit);
        let there: Vec<bool> = cells.iter().map(Option::is_some).collect();
        if !is_possible(found) {
            return Err(Error::not_settled(format!(
                "{}: unit {unit} came out with values that are infinite",
                self.path.display()
            )));
        }
        let block = self.layout.block_at(unit);
        let refuse = |e: std::io::Error| failure(&self.path, "a unit cannot be written", &e);
        let mut digests = Vec::with_capacity(self.arrays.len() + 1);
        for (index, array) in self.arrays.iter().enumerate() {
            let bytes = match found.values.get(index) {
                Some(SweepValues::Floats(values)) => array.encode(&there, values),
                Some(SweepValues::Bytes(values)) => array.encode(&there, values),
                None => None,
            };
            let bytes = bytes.ok_or_else(|| {
                Error::machine(format!(
                    "{}: unit {unit} has other values of '{}' than its cells ask for",
                    self.path.display(),
                    array.name
                ))
            })?;
            let key = array.path(&block);
            self.files.write(&key, &bytes).map_err(refuse)?;
            digests.push(self.digest_of(&[(key.as_str(), bytes.as_slice())]));
        }
        let materials: Vec<(String, &[u8])> =
            found.materials.iter().map(|(cell, bytes)| (material_key(*cell), bytes.as_slice())).collect();
        for (key, bytes) in &materials {
            self.files.write(key, bytes).map_err(refuse)?;
        }
        let sealed: Vec<(&str, &[u8])> =
            materials.iter().map(|(key, bytes)| (key.as_str(), *bytes)).collect();
        digests.push(self.digest_of(&sealed));
        self.files.write(&format!("{TIMES}/{unit}"), format!("{seconds:.6}").as_bytes()).map_err(refuse)?;
        let bytes = self.digest.encode(&[true], &digests).unwrap_or_default();
        self.files.write(&self.digest.path(&[unit]), &bytes).map_err(refuse)
    }

    /// What ties files to their places in this sweep.
    fn digest_of(&self, files: &[(&str, &[u8])]) -> u64 {
        let mut hasher = blake3::Hasher::new();
        let mut part = |bytes: &[u8]| {
            hasher.update(&(bytes.len() as u64).to_le_bytes()).update(bytes);
        };
        part(self.hash.as_bytes());
        for (key, bytes) in files {
            part(key.as_bytes());
            part(bytes);
        }
        hasher.finalize().as_bytes().first_chunk().copied().map_or(0, u64::from_le_bytes)
    }

    /// Reads a unit; `None` when it is missing or damaged, so that it can be computed again.
    #[must_use]
    pub fn read(&self, unit: usize) -> Option<SweepUnit> {
        let bytes = self.files.read(&self.digest.path(&[unit]), self.digest.most_bytes())?;
        let digests: Vec<u64> = self.digest.decode(&[true], &bytes)?;
        let cells = self.layout.cells_of(unit);
        let there: Vec<bool> = cells.iter().map(Option::is_some).collect();
        let block = self.layout.block_at(unit);
        let mut values = Vec::with_capacity(self.arrays.len());
        for ((array, kind), digest) in self.arrays.iter().zip(&self.layout.arrays).zip(&digests) {
            let key = array.path(&block);
            let bytes = self.files.read(&key, array.most_bytes())?;
            if self.digest_of(&[(key.as_str(), bytes.as_slice())]) != *digest {
                return None;
            }
            values.push(if kind.is_bytes {
                SweepValues::Bytes(array.decode(&there, &bytes)?)
            } else {
                SweepValues::Floats(array.decode(&there, &bytes)?)
            });
        }
        let materials: Vec<(usize, Vec<u8>)> = if self.layout.with_materials {
            let of = |cell: usize| Some((cell, self.files.read(&material_key(cell), MOST_MATERIAL)?));
            cells.into_iter().flatten().filter_map(of).collect()
        } else {
            Vec::new()
        };
        let keys: Vec<String> = materials.iter().map(|(cell, _)| material_key(*cell)).collect();
        let sealed: Vec<(&str, &[u8])> =
            keys.iter().zip(&materials).map(|(key, (_, bytes))| (key.as_str(), bytes.as_slice())).collect();
        if digests.last() != Some(&self.digest_of(&sealed)) {
            return None;
        }
        let found = SweepUnit { values, materials };
        is_possible(&found).then_some(found)
    }

    /// Values of one array over all cells that are done, in the order of cells; none of the others.
    ///
    /// # Errors
    /// There is no such array of numbers.
    pub fn numbers(&self, name: &str) -> Result<Vec<Option<Vec<f64>>>> {
        let index =
            self.layout.arrays.iter().position(|array| array.name == name).ok_or_else(|| {
                Error::input(format!("there is no array '{name}' in it")).in_file(&self.path)
            })?;
        let each = self.layout.cell_len(index).max(1);
        let mut all = vec![None; self.layout.count()];
        for unit in 0..self.layout.units() {
            let Some(found) = self.read(unit) else { continue };
            let values: Vec<f64> = match &found.values[index] {
                SweepValues::Floats(values) => values.clone(),
                SweepValues::Bytes(values) => values.iter().map(|value| f64::from(*value)).collect(),
            };
            let cells = self.layout.cells_of(unit).into_iter().flatten();
            for (cell, values) in cells.zip(values.chunks_exact(each)) {
                all[cell] = Some(values.to_vec());
            }
        }
        Ok(all)
    }
}

/// The file of a cell's material.
fn material_key(cell: usize) -> String {
    format!("{MATERIALS}/{cell:06}.barbule")
}

/// Whether values can be kept: finite, or NaN where there is none.
fn is_possible(found: &SweepUnit) -> bool {
    found.values.iter().all(|values| match values {
        SweepValues::Floats(values) => !values.iter().any(|value| value.is_infinite()),
        SweepValues::Bytes(_) => true,
    })
}
