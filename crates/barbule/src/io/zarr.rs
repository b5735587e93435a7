//! Arrays of Zarr version 3 in regular chunks of numbers, as far as campaign stores need them.
//!
//! A chunk is its values in C order, little endian, with a CRC-32C checksum behind. Nothing compresses it: floats of a
//! campaign hardly shrink, and a chunk whose length is known cannot ask for more memory than its shape.
//!
//! Specification: <https://zarr-specs.readthedocs.io/en/latest/v3/core/index.html>.

mod sharded;

use crc32c::crc32c;
use num_complex::Complex;
use serde_json::{Map, Value, json};

pub(super) use self::sharded::Sharded;

/// Length of a checksum, bytes.
const CHECKSUM: usize = 4;

/// What an element of an array is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DataType {
    Float32,
    Float64,
    Complex64,
    UInt64,
    UInt8,
}

impl DataType {
    fn name(self) -> &'static str {
        match self {
            Self::Float32 => "float32",
            Self::Float64 => "float64",
            Self::Complex64 => "complex64",
            Self::UInt64 => "uint64",
            Self::UInt8 => "uint8",
        }
    }

    fn bytes(self) -> usize {
        match self {
            Self::UInt8 => 1,
            Self::Float32 => 4,
            Self::Float64 | Self::Complex64 | Self::UInt64 => 8,
        }
    }

    /// What readers put where a chunk is missing.
    fn fill_value(self) -> Value {
        match self {
            Self::Float32 | Self::Float64 => json!("NaN"),
            Self::Complex64 => json!(["NaN", "NaN"]),
            Self::UInt64 | Self::UInt8 => json!(0),
        }
    }
}

/// A number that arrays hold.
pub(super) trait Element: Copy {
    const DATA_TYPE: DataType;

    /// Appends the little-endian bytes.
    fn put(self, bytes: &mut Vec<u8>);

    /// The number whose little-endian bytes these are: as many as [`Self::DATA_TYPE`] has, else `None`.
    fn get(bytes: &[u8]) -> Option<Self>;
}

impl Element for f32 {
    const DATA_TYPE: DataType = DataType::Float32;

    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(&self.to_le_bytes());
    }

    fn get(bytes: &[u8]) -> Option<Self> {
        bytes.try_into().ok().map(Self::from_le_bytes)
    }
}

impl Element for f64 {
    const DATA_TYPE: DataType = DataType::Float64;

    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(&self.to_le_bytes());
    }

    fn get(bytes: &[u8]) -> Option<Self> {
        bytes.try_into().ok().map(Self::from_le_bytes)
    }
}

impl Element for u64 {
    const DATA_TYPE: DataType = DataType::UInt64;

    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(&self.to_le_bytes());
    }

    fn get(bytes: &[u8]) -> Option<Self> {
        bytes.try_into().ok().map(Self::from_le_bytes)
    }
}

impl Element for u8 {
    const DATA_TYPE: DataType = DataType::UInt8;

    fn put(self, bytes: &mut Vec<u8>) {
        bytes.push(self);
    }

    fn get(bytes: &[u8]) -> Option<Self> {
        bytes.try_into().ok().map(Self::from_le_bytes)
    }
}

impl Element for Complex<f32> {
    const DATA_TYPE: DataType = DataType::Complex64;

    fn put(self, bytes: &mut Vec<u8>) {
        self.re.put(bytes);
        self.im.put(bytes);
    }

    fn get(bytes: &[u8]) -> Option<Self> {
        let (re, im) = bytes.split_at_checked(4)?;
        Some(Self::new(f32::get(re)?, f32::get(im)?))
    }
}

/// What an array is; where it lies is its owner's concern.
#[derive(Debug, Clone)]
pub(super) struct Array {
    pub(super) name: &'static str,
    pub(super) data_type: DataType,
    pub(super) shape: Vec<usize>,
    pub(super) chunk_shape: Vec<usize>,
    pub(super) dimension_names: Vec<&'static str>,
    /// Of the values; empty for pure numbers.
    pub(super) units: &'static str,
    /// What the values mean, for people.
    pub(super) meaning: &'static str,
}

impl Array {
    /// The content of the array's `zarr.json`.
    pub(super) fn metadata(&self) -> Value {
        let codecs = json!([
            {"name": "bytes", "configuration": {"endian": "little"}},
            {"name": "crc32c"},
        ]);
        let mut attributes = json!({"long_name": self.meaning});
        if !self.units.is_empty() {
            attributes["units"] = json!(self.units);
        }
        json!({
            "zarr_format": 3,
            "node_type": "array",
            "shape": self.shape,
            "data_type": self.data_type.name(),
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": self.chunk_shape}},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
            "fill_value": self.data_type.fill_value(),
            "codecs": codecs,
            "attributes": attributes,
            "dimension_names": self.dimension_names,
        })
    }

    /// Path, from the store's folder, of the file of the chunk with these indices along the first axes and 0 along
    /// the others.
    pub(super) fn chunk_path(&self, first: &[usize]) -> String {
        let indices = first.iter().chain(std::iter::repeat(&0)).take(self.shape.len());
        let indices: Vec<String> = indices.map(usize::to_string).collect();
        format!("{}/c.{}", self.name, indices.join("."))
    }

    /// Values in a chunk.
    pub(super) fn chunk_len(&self) -> usize {
        self.chunk_shape.iter().product()
    }

    /// The most bytes that a chunk's file can have.
    pub(super) fn most_bytes(&self) -> usize {
        self.chunk_len() * self.data_type.bytes() + CHECKSUM
    }

    /// The bytes of a chunk; `None` where `values` are not as many or not of the type that the array has.
    pub(super) fn encode<T: Element>(&self, values: &[T]) -> Option<Vec<u8>> {
        if T::DATA_TYPE != self.data_type || values.len() != self.chunk_len() {
            return None;
        }
        let mut bytes = Vec::with_capacity(self.most_bytes());
        for value in values {
            value.put(&mut bytes);
        }
        let checksum = crc32c(&bytes);
        bytes.extend_from_slice(&checksum.to_le_bytes());
        Some(bytes)
    }

    /// The values of a chunk; `None` where its checksum fails or it holds anything but as many values as its shape says.
    pub(super) fn decode<T: Element>(&self, bytes: &[u8]) -> Option<Vec<T>> {
        let (content, checksum) = bytes.split_last_chunk::<CHECKSUM>()?;
        if T::DATA_TYPE != self.data_type || crc32c(content) != u32::from_le_bytes(*checksum) {
            return None;
        }
        let size = self.data_type.bytes();
        let needed = self.chunk_len() * size;
        (content.len() == needed).then(|| content.chunks_exact(size).map(T::get).collect()).flatten()
    }
}

/// The content of a group's `zarr.json`, with that of its arrays in it, as readers of datasets look for (consolidated metadata
/// of zarr-python).
pub(super) fn group_metadata<'a>(
    attributes: &Map<String, Value>,
    arrays: impl Iterator<Item = &'a Array>,
) -> Value {
    group_of(attributes, arrays.map(|array| (array.name.to_owned(), array.metadata())).collect())
}

/// The same of arrays, and groups inside, whose own `zarr.json` is given by name.
pub(super) fn group_of(attributes: &Map<String, Value>, metadata: Map<String, Value>) -> Value {
    json!({
        "zarr_format": 3,
        "node_type": "group",
        "attributes": attributes,
        "consolidated_metadata": {"kind": "inline", "must_understand": false, "metadata": metadata},
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array() -> Array {
        Array {
            name: "a",
            data_type: DataType::Float32,
            shape: vec![4, 3],
            chunk_shape: vec![1, 3],
            dimension_names: vec!["x", "y"],
            units: "",
            meaning: "test",
        }
    }

    fn sealed(content: &[u8]) -> Vec<u8> {
        [content, &crc32c(content).to_le_bytes()].concat()
    }

    #[test]
    fn checksums_are_those_of_rfc_3720() {
        let ascending: Vec<u8> = (0..32).collect();
        assert_eq!(crc32c(&ascending), 0x46dd_794e);
    }

    #[test]
    fn values_come_back_with_all_their_bits() {
        let array = array();
        let values = [1.5f32, f32::from_bits(0x7fc0_1234), -0.0];
        let bytes = array.encode(&values).unwrap();
        assert_eq!(bytes.len(), array.most_bytes());
        let back: Vec<u32> = array.decode::<f32>(&bytes).unwrap().into_iter().map(f32::to_bits).collect();
        assert_eq!(back, values.map(f32::to_bits));
        let counts = Array { data_type: DataType::UInt64, ..array.clone() };
        assert_eq!(
            counts.decode::<u64>(&counts.encode(&[0, 1, u64::MAX]).unwrap()).unwrap(),
            [0, 1, u64::MAX]
        );
        let complex = Array { data_type: DataType::Complex64, ..array };
        let values = [Complex::new(1.0, 2.0), Complex::new(-3.0, 4.0), Complex::new(0.0, -0.5)];
        assert_eq!(complex.decode::<Complex<f32>>(&complex.encode(&values).unwrap()).unwrap(), values);
    }

    #[test]
    fn chunks_of_other_lengths_and_types_are_refused() {
        let array = array();
        assert!(array.encode(&[1f32, 2.0]).is_none() && array.encode(&[1f64, 2.0, 3.0]).is_none());
        for length in [0, 8, 16, 1 << 20] {
            assert!(array.decode::<f32>(&sealed(&vec![0; length])).is_none(), "{length}");
        }
        assert!(array.decode::<f32>(&sealed(&[0; 12])).is_some());
        assert!(array.decode::<f64>(&sealed(&[0; 24])).is_none());
    }

    #[test]
    fn every_cut_and_every_flipped_bit_is_found() {
        let array = array();
        let good = sealed(&[7; 12]);
        assert!(array.decode::<f32>(&good).is_some());
        for length in 0..good.len() {
            assert!(array.decode::<f32>(&good[..length]).is_none());
        }
        for bit in 0..8 * good.len() {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(array.decode::<f32>(&bad).is_none(), "{bit}");
        }
    }
}
