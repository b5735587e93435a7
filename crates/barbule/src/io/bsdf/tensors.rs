//! Tensor files: named arrays in one file, as the RGL database keeps its materials in.
//!
//! Little endian: `tensor_file` and a zero byte, the version's two bytes 1 and 0, the number of fields as u32; of each field the length of
//! its name as u16, the name, its dimensions as u16, its type as u8, its offset in the file as u64, and its shape as u64s. Arrays lie at offsets
//! that are multiples of eight, in C order.

use std::collections::BTreeMap;

use crate::error::shortened;
use crate::{Error, Result};

const MAGIC: &[u8] = b"tensor_file\0\x01\0";
const MOST_FIELDS: u32 = 256;
const MOST_DIMENSIONS: u16 = 8;

/// Codes of types.
const U8: u8 = 1;
const F32: u8 = 10;

/// One array of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tensor<'a> {
    code: u8,
    bytes: &'a [u8],
}

/// An array to be written: its shape and its bytes.
pub(super) struct Written<'a> {
    pub(super) name: &'a str,
    pub(super) shape: Vec<usize>,
    pub(super) values: WrittenValues<'a>,
}

/// Values to be written.
pub(super) enum WrittenValues<'a> {
    Bytes(&'a [u8]),
    Singles(&'a [f32]),
}

/// Whether bytes begin as a tensor file does.
pub(super) fn is_tensor_file(bytes: &[u8]) -> bool {
    bytes.starts_with(b"tensor_file\0")
}

/// The arrays of a file, by name, with their shapes.
///
/// # Errors
/// No tensor file of version 1.0, or one that ends too early.
pub(super) fn decode(bytes: &[u8]) -> Result<BTreeMap<String, (Vec<usize>, Tensor<'_>)>> {
    if !bytes.starts_with(MAGIC) {
        return Err(Error::input("is not a tensor file of version 1.0"));
    }
    let mut at = MAGIC.len();
    let mut take = |count: usize| {
        let taken = bytes.get(at..at.checked_add(count)?)?;
        at += count;
        Some(taken)
    };
    let early = || Error::input("ends too early");
    let count = take(4).and_then(number).ok_or_else(early)?;
    if count > u64::from(MOST_FIELDS) {
        return Err(Error::input(format!("says that it has {count} fields; at most {MOST_FIELDS} are read")));
    }
    let mut fields = BTreeMap::new();
    for _ in 0..count {
        let length = take(2).and_then(number).ok_or_else(early)?;
        let name = String::from_utf8_lossy(take(length as usize).ok_or_else(early)?).into_owned();
        let dimensions = take(2).and_then(number).ok_or_else(early)?;
        if dimensions > u64::from(MOST_DIMENSIONS) {
            return Err(Error::input(format!("field {} has {dimensions} dimensions", shortened(&name))));
        }
        let code = *take(1).and_then(<[u8]>::first).ok_or_else(early)?;
        let offset = take(8).and_then(number).ok_or_else(early)?;
        let shape = (0..dimensions)
            .map(|_| take(8).and_then(number).map(|side| side as usize).ok_or_else(early))
            .collect::<Result<Vec<_>>>()?;
        let beyond = || Error::input(format!("field {} reaches beyond the end", shortened(&name)));
        let length =
            shape.iter().try_fold(size_of(code), |all, side| all.checked_mul(*side)).ok_or_else(beyond)?;
        let from = usize::try_from(offset).map_err(|_| beyond())?;
        let own = from.checked_add(length).and_then(|to| bytes.get(from..to)).ok_or_else(beyond)?;
        fields.insert(name.clone(), (shape, Tensor { code, bytes: own }));
    }
    Ok(fields)
}

impl Tensor<'_> {
    /// Its values, if they are singles.
    pub(super) fn singles(&self) -> Option<Vec<f32>> {
        let of = |four: &[u8]| f32::from_le_bytes([four[0], four[1], four[2], four[3]]);
        (self.code == F32).then(|| self.bytes.chunks_exact(4).map(of).collect())
    }

    /// Its bytes, if that is what it holds.
    pub(super) fn bytes(&self) -> Option<&[u8]> {
        (self.code == U8).then_some(self.bytes)
    }
}

/// A tensor file of these arrays.
pub(super) fn encode(fields: &[Written<'_>]) -> Vec<u8> {
    let head: usize =
        fields.iter().map(|field| 2 + field.name.len() + 2 + 1 + 8 + 8 * field.shape.len()).sum();
    let mut offset = (MAGIC.len() + 4 + head).next_multiple_of(8);
    let mut bytes = MAGIC.to_vec();
    bytes.extend((fields.len() as u32).to_le_bytes());
    for field in fields {
        let (code, length) = match field.values {
            WrittenValues::Bytes(values) => (U8, values.len()),
            WrittenValues::Singles(values) => (F32, size_of_val(values)),
        };
        bytes.extend((field.name.len() as u16).to_le_bytes());
        bytes.extend(field.name.as_bytes());
        bytes.extend((field.shape.len() as u16).to_le_bytes());
        bytes.push(code);
        bytes.extend((offset as u64).to_le_bytes());
        field.shape.iter().for_each(|side| bytes.extend((*side as u64).to_le_bytes()));
        offset = (offset + length).next_multiple_of(8);
    }
    for field in fields {
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        match field.values {
            WrittenValues::Bytes(values) => bytes.extend(values),
            WrittenValues::Singles(values) => {
                values.iter().for_each(|value| bytes.extend(value.to_le_bytes()))
            }
        }
    }
    bytes
}

/// Bytes of a value of a type: u8, i8, u16, i16, u32, i32, u64, i64, f16, f32, f64.
fn size_of(code: u8) -> usize {
    match code {
        1 | 2 => 1,
        3 | 4 | 9 => 2,
        5 | 6 | F32 => 4,
        _ => 8,
    }
}

fn number(bytes: &[u8]) -> Option<u64> {
    let mut eight = [0; 8];
    eight.get_mut(..bytes.len())?.copy_from_slice(bytes);
    Some(u64::from_le_bytes(eight))
}
