//! Numbers over named axes, as files that other programs open: with names, units and coordinates.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::output::{behind_links, is_inside_store};
use super::store::{Files, create_folder, sweep_beside};
use super::whole::{failure, folder_of};
use super::zarr::{Array, DataType, Element, group_metadata};
use crate::{Error, Result};

/// Quantities over the same axes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LabelledArrays {
    /// Names and lengths of the axes, the slowest first.
    pub axes: Vec<(&'static str, usize)>,
    /// What stands along them.
    pub coordinates: Vec<Coordinate>,
    /// What is given over all of them.
    pub quantities: Vec<Quantity>,
}

/// Values along one axis; one that is called as its axis is the axis' own.
#[derive(Debug, Clone, PartialEq)]
pub struct Coordinate {
    /// What it is called.
    pub name: &'static str,
    /// The axis along which it lies.
    pub axis: &'static str,
    /// Of the values; empty for pure numbers.
    pub units: &'static str,
    /// What the values mean.
    pub meaning: &'static str,
    /// As many as the axis is long.
    pub values: Numbers,
}

/// Numbers of either kind.
#[derive(Debug, Clone, PartialEq)]
pub enum Numbers {
    /// Measures.
    Floats(Vec<f64>),
    /// Whole numbers, of which no bit is lost.
    Counts(Vec<u64>),
}

/// Values over all axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// What it is called.
    pub name: &'static str,
    /// Of the values; empty for pure numbers.
    pub units: &'static str,
    /// What the values mean.
    pub meaning: &'static str,
    /// In the order of the axes, the last one fastest.
    pub values: Vec<f64>,
}

impl Numbers {
    /// How many.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Floats(values) => values.len(),
            Self::Counts(values) => values.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn json(&self) -> Value {
        match self {
            Self::Floats(values) => json!(values),
            Self::Counts(values) => json!(values),
        }
    }
}

impl LabelledArrays {
    /// The lengths of the axes.
    #[must_use]
    pub fn shape(&self) -> Vec<usize> {
        self.axes.iter().map(|(_, length)| *length).collect()
    }

    /// Names, axes, units and coordinates, for what stands beside a bare array of one quantity.
    #[must_use]
    pub fn labels(&self, quantity: &Quantity) -> Value {
        let coordinate = |c: &Coordinate| json!({"name": c.name, "axis": c.axis, "units": c.units, "meaning": c.meaning, "values": c.values.json()});
        json!({
            "name": quantity.name,
            "units": quantity.units,
            "meaning": quantity.meaning,
            "axes": self.axes.iter().map(|(name, _)| *name).collect::<Vec<_>>(),
            "shape": self.shape(),
            "coordinates": self.coordinates.iter().map(coordinate).collect::<Vec<_>>(),
        })
    }

    /// One quantity as NumPy's `.npy` (version 1.0, little-endian 64-bit floats in C order).
    #[must_use]
    pub fn npy(&self, quantity: &Quantity) -> Vec<u8> {
        const BEFORE: usize = 10;
        let shape: String = self.shape().iter().map(|length| format!("{length}, ")).collect();
        let mut header =
            format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}), }}", shape.trim_end());
        let end = (BEFORE + header.len() + 1).next_multiple_of(64) - BEFORE - 1;
        header.extend(std::iter::repeat_n(' ', end - header.len()));
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        // Shapes of a few axes never fill two bytes of length.
        bytes.extend_from_slice(&u16::try_from(header.len()).unwrap_or(u16::MAX).to_le_bytes());
        bytes.extend_from_slice(header.as_bytes());
        quantity.values.iter().for_each(|value| value.put(&mut bytes));
        bytes
    }

    /// The axes of an array, by the names of those it lies along.
    fn array(&self, name: &'static str, along: &[(&'static str, usize)], data_type: DataType) -> Array {
        let (dimension_names, shape): (_, Vec<usize>) = along.iter().copied().unzip();
        Array { name, data_type, chunk_shape: shape.clone(), shape, dimension_names, units: "", meaning: "" }
    }

    fn build(&self, path: &Path, made: &Path, attributes: &Map<String, Value>) -> Result<()> {
        let files = Files::new(made);
        let write = |key: &str, bytes: &[u8]| {
            files.write(key, bytes).map_err(|e| failure(path, "cannot be written", &e))
        };
        let mut arrays = Vec::new();
        let mut put = |array: Array, chunk: Option<Vec<u8>>| {
            let chunk = chunk.ok_or_else(|| {
                Error::machine(format!("the array '{}' has other values than its axes say", array.name))
            })?;
            write(&format!("{}/zarr.json", array.name), format!("{:#}\n", array.metadata()).as_bytes())?;
            write(&array.chunk_path(&[]), &chunk)?;
            arrays.push(array);
            Ok::<(), Error>(())
        };
        for Coordinate { name, axis, units, meaning, values } in &self.coordinates {
            let along = [(*axis, values.len())];
            let of = |data_type| Array { units, meaning, ..self.array(name, &along, data_type) };
            match values {
                Numbers::Floats(values) => {
                    let array = of(DataType::Float64);
                    let chunk = array.encode(values);
                    put(array, chunk)?;
                }
                Numbers::Counts(values) => {
                    let array = of(DataType::UInt64);
                    let chunk = array.encode(values);
                    put(array, chunk)?;
                }
            }
        }
        for Quantity { name, units, meaning, values } in &self.quantities {
            let array = Array { units, meaning, ..self.array(name, &self.axes, DataType::Float64) };
            let chunk = array.encode(values);
            put(array, chunk)?;
        }
        let mut attributes = attributes.clone();
        // By CF's convention readers take these for coordinates, whatever they are called.
        let names: Vec<&str> = self.coordinates.iter().map(|c| c.name).collect();
        attributes.insert("coordinates".into(), names.join(" ").into());
        write("zarr.json", format!("{:#}\n", group_metadata(&attributes, arrays.iter())).as_bytes())?;
        files.tidy();
        Ok(())
    }
}

/// Refuses, before any work, a path at which [`write_zarr`] could not make its folder.
///
/// # Errors
/// Something is there already; the folder around it is missing; inside a campaign store.
pub fn check_new_zarr(path: &Path) -> Result<()> {
    let refuse = |what: &str| Err(Error::input(what).in_file(path));
    let end = behind_links(path)?;
    if end.file_name().is_none() {
        return refuse("needs a name of its own; give one, as in values.zarr");
    }
    if is_inside_store(&end) {
        return refuse("lies inside a campaign store; give a name elsewhere");
    }
    if end.exists() {
        return refuse("is there already; give another name, or remove it");
    }
    if !folder_of(&end).is_dir() {
        return refuse(&format!("the folder {} does not exist", folder_of(&end).display()));
    }
    Ok(())
}

/// Writes arrays as a group of Zarr version 3, a folder that appears whole: `xarray.open_zarr` finds axes, coordinates and units.
///
/// # Errors
/// As [`check_new_zarr`], or the disk is full.
pub fn write_zarr(path: &Path, arrays: &LabelledArrays, attributes: &Map<String, Value>) -> Result<()> {
    check_new_zarr(path)?;
    let path = &behind_links(path)?;
    sweep_beside(path);
    create_folder(path, |made| arrays.build(path, made, attributes))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arrays() -> LabelledArrays {
        let coordinate =
            |name, axis, units, values| Coordinate { name, axis, units, meaning: "a test", values };
        LabelledArrays {
            axes: vec![("instance", 2), ("wavelength_nm", 3)],
            coordinates: vec![
                coordinate("instance", "instance", "", Numbers::Counts(vec![0, u64::MAX])),
                coordinate(
                    "wavelength_nm",
                    "wavelength_nm",
                    "nm",
                    Numbers::Floats(vec![400.0, 500.0, 600.0]),
                ),
            ],
            quantities: vec![Quantity {
                name: "f",
                units: "1/sr",
                meaning: "a test",
                values: vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.5],
            }],
        }
    }

    #[test]
    fn npy_files_are_as_numpy_defines_them() {
        let arrays = arrays();
        let bytes = arrays.npy(&arrays.quantities[0]);
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((&bytes[..8], (10 + length) % 64), (&b"\x93NUMPY\x01\x00"[..], 0));
        let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
        assert!(
            header.starts_with("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3,), }"),
            "{header}"
        );
        assert!(header.ends_with('\n'));
        assert_eq!(bytes[10 + length..].len(), 6 * 8);
        assert_eq!(bytes[bytes.len() - 8..], 5.5f64.to_le_bytes());
    }

    #[test]
    fn folders_appear_whole_and_nothing_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.zarr");
        write_zarr(&path, &arrays(), &Map::new()).unwrap();
        let group: Value = serde_json::from_slice(&std::fs::read(path.join("zarr.json")).unwrap()).unwrap();
        assert_eq!(group["attributes"]["coordinates"], "instance wavelength_nm");
        let f: Value = serde_json::from_slice(&std::fs::read(path.join("f/zarr.json")).unwrap()).unwrap();
        assert_eq!(f["dimension_names"], json!(["instance", "wavelength_nm"]));
        assert_eq!((&f["shape"], &f["attributes"]["units"]), (&json!([2, 3]), &json!("1/sr")));
        assert_eq!(std::fs::read(path.join("f/c.0.0")).unwrap().len(), 6 * 8 + 4);
        let refused = write_zarr(&path, &arrays(), &Map::new()).unwrap_err().to_string();
        assert!(refused.contains("is there already; give another name"), "{refused}");
        let nowhere = check_new_zarr(&folder.path().join("no/a.zarr")).unwrap_err().to_string();
        assert!(nowhere.contains("does not exist"), "{nowhere}");
        let mut wrong = arrays();
        wrong.quantities[0].values.pop();
        assert!(write_zarr(&folder.path().join("b.zarr"), &wrong, &Map::new()).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
