//! Arrays of Zarr version 3 whose files hold many chunks each (the codec `sharding_indexed`), so that thousands of small pieces
//! are not thousands of files and one of them is still read alone.
//!
//! A shard is its chunks one behind the other, each with a CRC-32C checksum, then where each lies: offset and length, two
//! little-endian 64-bit numbers a chunk, with a checksum of their own.
//!
//! Specification: <https://zarr-specs.readthedocs.io/en/latest/v3/codecs/sharding-indexed/index.html>.

use crc32c::crc32c;
use serde_json::{Map, Value, json};

use super::{CHECKSUM, DataType, Element};

/// Offset and length of a chunk that is not there.
const NOWHERE: u64 = u64::MAX;

/// Bytes of a chunk's entry among the places.
const PLACE: usize = 16;

/// An array over cells, each a chunk of its own with all that lies along the further dimensions; blocks of cells are files.
#[derive(Debug, Clone)]
pub(in crate::io) struct Sharded {
    pub(in crate::io) name: String,
    pub(in crate::io) data_type: DataType,
    /// Names and lengths of the dimensions of cells, the slowest first.
    pub(in crate::io) cells: Vec<(String, usize)>,
    /// How many cells a file has along each of these.
    pub(in crate::io) block: Vec<usize>,
    /// Names and lengths of the further dimensions.
    pub(in crate::io) trailing: Vec<(String, usize)>,
    /// Of the values; empty for pure numbers.
    pub(in crate::io) units: String,
    /// What the values mean, for people.
    pub(in crate::io) meaning: String,
}

impl Sharded {
    /// The content of the array's `zarr.json`.
    pub(in crate::io) fn metadata(&self) -> Value {
        let lengths = |of: &[(String, usize)]| of.iter().map(|(_, length)| *length).collect::<Vec<_>>();
        let names: Vec<&str> =
            self.cells.iter().chain(&self.trailing).map(|(name, _)| name.as_str()).collect();
        let trailing = lengths(&self.trailing);
        let shape = [lengths(&self.cells), trailing.clone()].concat();
        let file = [self.block.clone(), trailing.clone()].concat();
        let chunk = [vec![1; self.cells.len()], trailing].concat();
        let plain = json!([{"name": "bytes", "configuration": {"endian": "little"}}, {"name": "crc32c"}]);
        let mut attributes = Map::new();
        attributes.insert("long_name".into(), json!(self.meaning));
        if !self.units.is_empty() {
            attributes.insert("units".into(), json!(self.units));
        }
        json!({
            "zarr_format": 3,
            "node_type": "array",
            "shape": shape,
            "data_type": self.data_type.name(),
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": file}},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
            "fill_value": self.data_type.fill_value(),
            "codecs": [{"name": "sharding_indexed", "configuration": {
                "chunk_shape": chunk,
                "codecs": plain,
                "index_codecs": plain,
                "index_location": "end",
            }}],
            "attributes": attributes,
            "dimension_names": names,
        })
    }

    /// Path, from the store's folder, of the file of the block with these indices.
    pub(in crate::io) fn path(&self, block: &[usize]) -> String {
        let zeros = std::iter::repeat_n(&0, self.trailing.len());
        let indices: Vec<String> = block.iter().chain(zeros).map(usize::to_string).collect();
        format!("{}/c.{}", self.name, indices.join("."))
    }

    /// Values of a cell.
    pub(in crate::io) fn cell_len(&self) -> usize {
        self.trailing.iter().map(|(_, length)| length).product()
    }

    /// The most bytes that a file can have.
    pub(in crate::io) fn most_bytes(&self) -> usize {
        let cells: usize = self.block.iter().product();
        cells * (self.cell_len() * self.data_type.bytes() + CHECKSUM + PLACE) + CHECKSUM
    }

    /// The bytes of all files: of each cell its values and their checksum, of each place of a block where it lies, and a checksum of these.
    pub(in crate::io) fn all_bytes(&self) -> usize {
        let cells: usize = self.cells.iter().map(|(_, length)| length).product();
        let blocks = self.cells.iter().zip(&self.block).map(|((_, length), block)| length.div_ceil(*block));
        let places: usize = self.block.iter().product();
        cells * (self.cell_len() * self.data_type.bytes() + CHECKSUM)
            + blocks.product::<usize>() * (places * PLACE + CHECKSUM)
    }

    /// The bytes of a file: `values` are those of the cells that `is_there` names, in the order of the block. `None` where they
    /// are not as many, or not of the array's type.
    pub(in crate::io) fn encode<T: Element>(&self, is_there: &[bool], values: &[T]) -> Option<Vec<u8>> {
        let (each, there) = (self.cell_len(), is_there.iter().filter(|there| **there).count());
        let fits = is_there.len() == self.block.iter().product::<usize>() && values.len() == there * each;
        if T::DATA_TYPE != self.data_type || !fits || each == 0 {
            return None;
        }
        let mut bytes = Vec::with_capacity(self.most_bytes());
        let mut places = Vec::with_capacity(PLACE * is_there.len());
        let mut cells = values.chunks_exact(each);
        for there in is_there {
            let cell = if *there { cells.next() } else { None };
            let start = bytes.len();
            for value in cell.into_iter().flatten() {
                value.put(&mut bytes);
            }
            let place = if cell.is_some() {
                let checksum = crc32c(&bytes[start..]);
                bytes.extend_from_slice(&checksum.to_le_bytes());
                [start as u64, (bytes.len() - start) as u64]
            } else {
                [NOWHERE; 2]
            };
            place.into_iter().for_each(|number| number.put(&mut places));
        }
        let checksum = crc32c(&places);
        bytes.extend_from_slice(&places);
        bytes.extend_from_slice(&checksum.to_le_bytes());
        Some(bytes)
    }

    /// The values of the cells that `is_there` names; `None` where a checksum fails, or anything lies otherwise than
    /// [`Self::encode`] puts it.
    pub(in crate::io) fn decode<T: Element>(&self, is_there: &[bool], bytes: &[u8]) -> Option<Vec<T>> {
        let (rest, checksum) = bytes.split_last_chunk::<CHECKSUM>()?;
        let (content, places) = rest.split_at_checked(rest.len().checked_sub(PLACE * is_there.len())?)?;
        if T::DATA_TYPE != self.data_type || crc32c(places) != u32::from_le_bytes(*checksum) {
            return None;
        }
        let size = self.data_type.bytes();
        let length = self.cell_len() * size + CHECKSUM;
        let mut values = Vec::with_capacity(is_there.len() * self.cell_len());
        let mut at = 0;
        for (there, place) in is_there.iter().zip(places.chunks_exact(PLACE)) {
            let expected = if *there { [at as u64, length as u64] } else { [NOWHERE; 2] };
            let (offset, held) = place.split_at(PLACE / 2);
            if [u64::get(offset)?, u64::get(held)?] != expected {
                return None;
            }
            if !there {
                continue;
            }
            let (cell, sum) = content.get(at..at + length)?.split_last_chunk::<CHECKSUM>()?;
            if crc32c(cell) != u32::from_le_bytes(*sum) {
                return None;
            }
            for value in cell.chunks_exact(size) {
                values.push(T::get(value)?);
            }
            at += length;
        }
        (at == content.len()).then_some(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array(data_type: DataType) -> Sharded {
        Sharded {
            name: "mean".into(),
            data_type,
            cells: vec![("cortex_um".into(), 3), ("gap_um".into(), 5)],
            block: vec![2, 2],
            trailing: vec![("wavelength".into(), 3)],
            units: String::new(),
            meaning: "test".into(),
        }
    }

    #[test]
    fn a_block_at_the_edge_comes_back_without_the_cells_that_are_not_there() {
        let array = array(DataType::Float64);
        let (whole, edge) = ([true; 4], [true, false, false, false]);
        let values: Vec<f64> = (0..12).map(f64::from).collect();
        let bytes = array.encode(&whole, &values).unwrap();
        assert_eq!(bytes.len(), array.most_bytes());
        assert_eq!(array.decode::<f64>(&whole, &bytes).unwrap(), values);
        let part = array.encode(&edge, &values[..3]).unwrap();
        assert_eq!(part.len(), 3 * 8 + 4 + 4 * 16 + 4);
        assert_eq!(array.decode::<f64>(&edge, &part).unwrap(), values[..3]);
        assert!(array.decode::<f64>(&whole, &part).is_none() && array.decode::<f64>(&edge, &bytes).is_none());
        assert!(array.encode(&edge, &values).is_none() && array.encode(&whole, &[0_u8; 12]).is_none());
        assert_eq!(array.path(&[1, 2]), "mean/c.1.2.0");
        // Blocks of four, two, two, one; two, one cells.
        let (cell, places) = (3 * 8 + 4, 4 * 16 + 4);
        assert_eq!(array.all_bytes(), 15 * cell + 6 * places);
    }

    #[test]
    fn every_cut_and_every_flipped_bit_of_a_shard_is_found() {
        let array = array(DataType::UInt8);
        let is_there = [true, true, false, false];
        let good = array.encode(&is_there, &[1_u8, 2, 3, 4, 5, 6]).unwrap();
        assert_eq!(array.decode::<u8>(&is_there, &good).unwrap(), [1, 2, 3, 4, 5, 6]);
        for length in 0..good.len() {
            assert!(array.decode::<u8>(&is_there, &good[..length]).is_none(), "{length}");
        }
        for bit in 0..8 * good.len() {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(array.decode::<u8>(&is_there, &bad).is_none(), "{bit}");
        }
    }

    #[test]
    fn files_are_blocks_and_chunks_are_cells() {
        let metadata = array(DataType::Float64).metadata();
        assert_eq!(metadata["shape"], json!([3, 5, 3]));
        assert_eq!(metadata["chunk_grid"]["configuration"]["chunk_shape"], json!([2, 2, 3]));
        assert_eq!(metadata["codecs"][0]["configuration"]["chunk_shape"], json!([1, 1, 3]));
        assert_eq!(metadata["dimension_names"], json!(["cortex_um", "gap_um", "wavelength"]));
    }
}
