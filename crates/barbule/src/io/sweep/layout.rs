//! What the store of a sweep is made of: axes, arrays, blocks of cells.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::super::arrays::Numbers;
use super::super::store::{ATLAS, Files, difference};
use super::super::whole::{failure, hash_bytes};
use super::super::zarr::{DataType, Sharded, group_of};
use crate::error::shortened;
use crate::{Error, Result};

/// The version of the layout; others are not read.
const LAYOUT: u64 = 1;

/// Cells that a sweep may have, and bytes of one file.
pub const MOST_CELLS: usize = 1_000_000;
const MOST_FILE_BYTES: usize = 1 << 30;

/// The folder of materials inside a store, and the array that ties files to their units.
pub(super) const MATERIALS: &str = "materials";
pub(super) const DIGEST: &str = "digest";

/// The file in which a group or an array says what it is.
pub(super) const GROUP: &str = "zarr.json";

/// An axis with what stands along it.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepAxis {
    /// What it is called.
    pub name: String,
    /// Of the values; empty for pure numbers.
    pub units: String,
    /// What the values mean.
    pub meaning: String,
    /// As many as the axis is long.
    pub values: Numbers,
    /// Words for the values, where numbers only count them; else empty.
    pub labels: Vec<String>,
}

/// Values along one axis of cells beside the axis' own.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepCoordinate {
    /// What it is called.
    pub name: String,
    /// The axis along which it lies.
    pub axis: String,
    /// Of the values; empty for pure numbers.
    pub units: String,
    /// What the values mean.
    pub meaning: String,
    /// As many as the axis is long.
    pub values: Vec<f64>,
}

/// What is kept of every cell.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepArray {
    /// What it is called.
    pub name: String,
    /// Of the values; empty for pure numbers.
    pub units: String,
    /// What the values mean.
    pub meaning: String,
    /// The names of its axes after those of the cells.
    pub along: Vec<String>,
    /// Whether the values are whole numbers from 0 to 255.
    pub is_bytes: bool,
}

/// The store of a sweep before any unit is in it.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepLayout {
    /// What is swept.
    pub name: String,
    /// The SIMD instructions that compute it.
    pub width: String,
    /// The axes of cells, the slowest first.
    pub cells: Vec<SweepAxis>,
    /// How many cells a unit of work has along each of these.
    pub block: Vec<usize>,
    /// Further axes.
    pub further: Vec<SweepAxis>,
    /// Further values along axes of cells.
    pub coordinates: Vec<SweepCoordinate>,
    /// What is kept.
    pub arrays: Vec<SweepArray>,
    /// Whether each cell has a material.
    pub with_materials: bool,
    /// Every parameter.
    pub description: Value,
}

impl SweepLayout {
    /// All cells.
    #[must_use]
    pub fn count(&self) -> usize {
        self.cells.iter().map(|axis| axis.values.len()).product()
    }

    /// How many units of work there are along each axis of cells.
    fn blocks(&self) -> Vec<usize> {
        self.cells.iter().zip(&self.block).map(|(axis, block)| axis.values.len().div_ceil(*block)).collect()
    }

    /// All units of work.
    #[must_use]
    pub fn units(&self) -> usize {
        self.blocks().iter().product()
    }

    /// Where a unit's block lies among the blocks.
    pub(super) fn block_at(&self, unit: usize) -> Vec<usize> {
        places(unit, &self.blocks())
    }

    /// Of every place of a unit's block, in its order: the number of the cell, in the order of all cells; none beyond the edge.
    #[must_use]
    pub fn cells_of(&self, unit: usize) -> Vec<Option<usize>> {
        let block = self.block_at(unit);
        let inside = |place: usize| {
            let within = places(place, &self.block);
            let mut cell = 0;
            for (axis, values) in self.cells.iter().enumerate() {
                let at = block[axis] * self.block[axis] + within[axis];
                if at >= values.values.len() {
                    return None;
                }
                cell = cell * values.values.len() + at;
            }
            Some(cell)
        };
        (0..self.block.iter().product()).map(inside).collect()
    }

    /// Where a cell lies along each axis.
    #[must_use]
    pub fn place_of(&self, cell: usize) -> Vec<usize> {
        places(cell, &self.cells.iter().map(|axis| axis.values.len()).collect::<Vec<_>>())
    }

    /// Numbers that an array has of a cell.
    #[must_use]
    pub fn cell_len(&self, array: usize) -> usize {
        self.sharded(&self.arrays[array]).cell_len()
    }

    /// Files of the finished store.
    #[must_use]
    pub fn files(&self) -> usize {
        let materials = if self.with_materials { self.count() } else { 0 };
        self.own_files().len() + self.units() * (self.arrays.len() + 1) + materials
    }

    /// Bytes of the finished store's files; materials come on top.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let arrays = self.arrays.iter().map(|array| self.sharded(array)).chain([self.digest()]);
        let numbers: usize = arrays.map(|array| array.all_bytes()).sum();
        let own: usize = self.own_files().iter().map(|(_, bytes)| bytes.len()).sum();
        (numbers + own) as u64
    }

    /// Refuses what no store can be.
    ///
    /// # Errors
    /// Too many cells, files too large for memory, an axis without values, or two things of one name.
    pub(super) fn check(&self) -> Result<()> {
        let lengths = self.cells.iter().map(|axis| axis.values.len());
        let cells = lengths.into_iter().try_fold(1_usize, usize::checked_mul).unwrap_or(usize::MAX);
        if !(1..=MOST_CELLS).contains(&cells) {
            return Err(Error::input(format!(
                "the sweep has {cells} cells, but 1 to {MOST_CELLS} can be; give fewer values, or `samples`"
            )));
        }
        let mut names: Vec<&str> = self.named().map(|(name, ..)| name).collect();
        names.extend(self.arrays.iter().map(|array| array.name.as_str()));
        names.extend([DIGEST, MATERIALS]);
        names.sort_unstable();
        if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(Error::input(format!(
                "two things in the store would be called '{}'; give one of them another name",
                twice[0]
            )));
        }
        let largest = self.arrays.iter().map(|array| self.sharded(array).most_bytes()).max().unwrap_or(0);
        if largest > MOST_FILE_BYTES {
            return Err(Error::input(format!(
                "a unit's spectra would have {} MB, over the limit of {} MB; give fewer `unit_cells`, angles or wavelengths",
                largest / 1_000_000,
                MOST_FILE_BYTES / 1_000_000
            )));
        }
        Ok(())
    }

    /// Everything that has values along one axis: name, axis, units, meaning, values.
    fn named(&self) -> impl Iterator<Item = (&str, &str, &str, &str, Numbers)> {
        let axes = self.cells.iter().chain(&self.further);
        let own = axes.map(|a| {
            (a.name.as_str(), a.name.as_str(), a.units.as_str(), a.meaning.as_str(), a.values.clone())
        });
        let others = self.coordinates.iter().map(|c| {
            (
                c.name.as_str(),
                c.axis.as_str(),
                c.units.as_str(),
                c.meaning.as_str(),
                Numbers::Floats(c.values.clone()),
            )
        });
        own.chain(others)
    }

    /// The coordinates as arrays with the bytes of their only file.
    pub(super) fn coordinates(&self) -> Vec<(Sharded, Vec<u8>)> {
        let of = |(name, axis, units, meaning, values): (&str, &str, &str, &str, Numbers)| {
            let array = |data_type| Sharded {
                name: name.to_owned(),
                data_type,
                cells: Vec::new(),
                block: Vec::new(),
                trailing: vec![(axis.to_owned(), values.len())],
                units: units.to_owned(),
                meaning: meaning.to_owned(),
            };
            let (array, bytes) = match &values {
                Numbers::Floats(numbers) => {
                    let array = array(DataType::Float64);
                    let bytes = array.encode(&[true], numbers);
                    (array, bytes)
                }
                Numbers::Counts(counts) => {
                    let array = array(DataType::UInt64);
                    let bytes = array.encode(&[true], counts);
                    (array, bytes)
                }
            };
            // Type and length are the values' own; an axis has at least one.
            (array, bytes.unwrap_or_default())
        };
        self.named().map(of).collect()
    }

    /// An array of every cell.
    pub(super) fn sharded(&self, array: &SweepArray) -> Sharded {
        let length = |name: &String| {
            let axis = self.further.iter().find(|axis| axis.name == *name);
            (name.clone(), axis.map_or(0, |axis| axis.values.len()))
        };
        Sharded {
            name: array.name.clone(),
            data_type: if array.is_bytes { DataType::UInt8 } else { DataType::Float64 },
            cells: self.cells.iter().map(|axis| (axis.name.clone(), axis.values.len())).collect(),
            block: self.block.clone(),
            trailing: array.along.iter().map(length).collect(),
            units: array.units.clone(),
            meaning: array.meaning.clone(),
        }
    }

    /// What ties the files of a unit to it.
    pub(super) fn digest(&self) -> Sharded {
        Sharded {
            name: DIGEST.into(),
            data_type: DataType::UInt64,
            cells: vec![("unit".into(), self.units())],
            block: vec![1],
            trailing: vec![("array".into(), self.arrays.len() + 1)],
            units: String::new(),
            meaning: "of each array's file, in the order of writing and materials last: the first 8 bytes of BLAKE3 of sweep_hash, file, bytes".into(),
        }
    }

    /// What the checksum is of.
    fn covered(&self) -> Map<String, Value> {
        let axes: Map<String, Value> = self
            .cells
            .iter()
            .chain(&self.further)
            .map(|axis| {
                let values = match &axis.values {
                    Numbers::Floats(values) => json!(values),
                    Numbers::Counts(values) => json!(values),
                };
                (axis.name.clone(), values)
            })
            .collect();
        let labels: Map<String, Value> = self
            .cells
            .iter()
            .chain(&self.further)
            .filter(|axis| !axis.labels.is_empty())
            .map(|axis| (axis.name.clone(), json!(axis.labels)))
            .collect();
        let coordinates: Map<String, Value> =
            self.coordinates.iter().map(|c| (c.name.clone(), json!(c.values))).collect();
        let covered = json!({
            "barbule_store": ATLAS,
            "layout": LAYOUT,
            "name": self.name,
            "simd": self.width,
            "axes": axes,
            "labels": labels,
            "along_axes": coordinates,
            "unit_cells": self.block,
            "arrays": self.arrays.iter().map(|array| array.name.as_str()).collect::<Vec<_>>(),
            "materials": self.with_materials,
            "sweep": self.description,
        });
        match covered {
            Value::Object(covered) => covered,
            _ => Map::new(),
        }
    }

    /// BLAKE3 of all attributes, independent of the order of their keys, in hexadecimal.
    pub(super) fn hash(&self) -> String {
        let mut covered = Value::Object(self.covered());
        covered.sort_all_objects();
        hash_bytes(covered.to_string().as_bytes())
    }

    /// The content of the store's `zarr.json`.
    pub(super) fn group(&self) -> Value {
        let mut attributes = self.covered();
        attributes.insert("sweep_hash".into(), json!(self.hash()));
        // By CF's convention readers take these for coordinates, whatever they are called.
        let along: Vec<&str> = self.coordinates.iter().map(|c| c.name.as_str()).collect();
        if !along.is_empty() {
            attributes.insert("coordinates".into(), along.join(" ").into());
        }
        let mut metadata: Map<String, Value> =
            self.all().into_iter().map(|array| (array.name.clone(), array.metadata())).collect();
        if self.with_materials {
            metadata.insert(MATERIALS.into(), materials_group());
        }
        group_of(&attributes, metadata)
    }

    /// All arrays.
    fn all(&self) -> Vec<Sharded> {
        let arrays = self.arrays.iter().map(|array| self.sharded(array)).chain([self.digest()]);
        arrays.chain(self.coordinates().into_iter().map(|(array, _)| array)).collect()
    }

    /// The files that a store has without any unit, by their paths: what arrays say about themselves, values along axes, and the group's
    /// metadata last.
    pub(super) fn own_files(&self) -> Vec<(String, Vec<u8>)> {
        let text = |metadata: &Value| format!("{metadata:#}\n").into_bytes();
        let about = |name: &str| format!("{name}/{GROUP}");
        let mut files: Vec<(String, Vec<u8>)> =
            self.all().iter().map(|array| (about(&array.name), text(&array.metadata()))).collect();
        files.extend(self.coordinates().into_iter().map(|(array, bytes)| (array.path(&[]), bytes)));
        if self.with_materials {
            files.push((about(MATERIALS), text(&materials_group())));
        }
        files.push((GROUP.into(), text(&self.group())));
        files
    }

    /// Writes the store `path` without units into the folder `made`.
    pub(super) fn build(&self, path: &Path, made: &Path) -> Result<()> {
        let files = Files::new(made);
        let refuse = |e: std::io::Error| failure(path, "the store cannot be created", &e);
        self.own_files().iter().try_for_each(|(key, bytes)| files.write(key, bytes)).map_err(refuse)?;
        files.tidy();
        Ok(())
    }

    /// Refuses to go on with the store `path`, whose `zarr.json` is `there`, under other parameters; the first difference is named.
    pub(super) fn check_same(&self, path: &Path, there: &Value) -> Result<()> {
        let refuse = |what: String| Err(Error::input(what).in_file(path));
        let attributes = &there["attributes"];
        if attributes["barbule_store"] != json!(ATLAS) {
            return refuse("is not the store of an atlas; give another name".into());
        }
        if attributes["layout"] != json!(LAYOUT) {
            return refuse(format!(
                "is not an atlas of this version (its layout is {}, this program's is {LAYOUT}); make it again under another name",
                shortened(&attributes["layout"].to_string())
            ));
        }
        if attributes["simd"] != json!(self.width) {
            let width = shortened(attributes["simd"].as_str().unwrap_or_default());
            return Err(Error::input(format!(
                "was computed with {width} instructions, this run would use {}; give `width` {width} to continue it with the same bits",
                self.width
            ))
            .in_file(path)
            .naming(&["width"]));
        }
        let here = self.group();
        match difference(attributes, &here["attributes"], "") {
            Some(difference) => refuse(format!(
                "this atlas was made by another plan ({difference}); give another name, or the same plan to go on"
            )),
            None if there["consolidated_metadata"] != here["consolidated_metadata"] => {
                refuse("its arrays are not those that its plan says; make it again under another name".into())
            }
            None => Ok(()),
        }
    }
}

/// What a store's folder of materials says about itself.
fn materials_group() -> Value {
    let about =
        json!({"long_name": "materials of the cells, files N.barbule by the cells' numbers in C order"});
    json!({"zarr_format": 3, "node_type": "group", "attributes": about})
}

/// The digits of a number in the order of axes of these lengths.
fn places(number: usize, lengths: &[usize]) -> Vec<usize> {
    let mut rest = number;
    let mut places: Vec<usize> = lengths
        .iter()
        .rev()
        .map(|length| {
            let place = rest % length;
            rest /= length;
            place
        })
        .collect();
    places.reverse();
    places
}
