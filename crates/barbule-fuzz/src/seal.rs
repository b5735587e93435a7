//! Checksums made right again, so that mutations get behind them.

use barbule::brdf::container_checksum;
use serde_json::Value;

/// A *safetensors* container whose description, the entry `entry` of its metadata, has the checksum of what is in it: that of
/// [`container_checksum`]. `None` where it is too broken for one.
#[must_use]
pub fn container(bytes: &[u8], entry: &str) -> Option<Vec<u8>> {
    resealed(bytes, entry, |description, tensors| {
        let mut description: Value = serde_json::from_str(description).ok()?;
        *description.get_mut("checksum")? = Value::String(String::new());
        let sum = container_checksum(&description.to_string(), tensors.iter().copied());
        description["checksum"] = Value::String(sum);
        Some(description.to_string())
    })
}

/// A table of a crystal's orders, whose entry is its key and a checksum.
#[must_use]
pub fn orders(bytes: &[u8], entry: &str) -> Option<Vec<u8>> {
    resealed(bytes, entry, |text, tensors| {
        let (key, _) = text.rsplit_once(' ')?;
        let mut hasher = blake3::Hasher::new();
        hasher.update(key.as_bytes());
        tensors.iter().for_each(|(_, bytes)| _ = hasher.update(bytes));
        Some(format!("{key} {}", hasher.finalize().to_hex()))
    })
}

/// A name and the bytes of an array.
type Tensor<'a> = (&'a str, &'a [u8]);

fn resealed(
    bytes: &[u8],
    entry: &str,
    sealed: impl FnOnce(&str, &[Tensor<'_>]) -> Option<String>,
) -> Option<Vec<u8>> {
    let (length, rest) = bytes.split_first_chunk::<8>()?;
    let (header, data) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
    let mut header: Value = serde_json::from_slice(header).ok()?;
    let mut tensors = Vec::new();
    for (name, about) in header.as_object()?.iter().filter(|(name, _)| *name != "__metadata__") {
        let at = |place: usize| usize::try_from(about["data_offsets"][place].as_u64()?).ok();
        tensors.push((name.as_str(), data.get(at(0)?..at(1)?)?));
    }
    tensors.sort_unstable_by_key(|(name, _)| *name);
    let text = sealed(header["__metadata__"][entry].as_str()?, &tensors)?;
    header["__metadata__"][entry] = Value::String(text);
    let mut header = header.to_string().into_bytes();
    // Data begin at a multiple of eight bytes.
    header.resize(header.len().next_multiple_of(8), b' ');
    Some([&(header.len() as u64).to_le_bytes(), &header[..], data].concat())
}

/// A PNG whose chunks have the checksums of what is in them.
#[must_use]
pub fn png(bytes: &[u8]) -> Vec<u8> {
    const SIGNATURE: usize = 8;
    const AROUND: usize = 12;
    let mut bytes = bytes.to_vec();
    let mut at = SIGNATURE;
    while let Some(length) = bytes.get(at..).and_then(|rest| rest.first_chunk::<4>()) {
        let end = at.saturating_add(u32::from_be_bytes(*length) as usize).saturating_add(AROUND);
        if end > bytes.len() {
            break;
        }
        let sum = crc32fast::hash(&bytes[at + 4..end - 4]);
        bytes[end - 4..end].copy_from_slice(&sum.to_be_bytes());
        at = end;
    }
    bytes
}

/// Bytes with their BLAKE3 behind them, in place of the last 32.
#[must_use]
pub fn trailing_blake3(bytes: &[u8]) -> Option<Vec<u8>> {
    let (body, _) = bytes.split_last_chunk::<32>()?;
    Some([body, blake3::hash(body).as_bytes()].concat())
}

/// A text whose first line is the BLAKE3 of all the others.
#[must_use]
pub fn first_line_blake3(bytes: &[u8]) -> Option<Vec<u8>> {
    let end = bytes.iter().position(|byte| *byte == b'\n')?;
    let rest = &bytes[end + 1..];
    Some([blake3::hash(rest).to_hex().as_bytes(), b"\n", rest].concat())
}

/// Bytes with their CRC-32C behind them, little-endian, in place of the last four.
#[must_use]
pub fn trailing_crc32c(bytes: &[u8]) -> Option<Vec<u8>> {
    let (body, _) = bytes.split_last_chunk::<4>()?;
    Some([body, &crc32c::crc32c(body).to_le_bytes()].concat())
}
