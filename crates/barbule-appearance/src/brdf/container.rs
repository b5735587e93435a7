//! What all *safetensors* containers of this program have in common.

use serde::Serialize;

use crate::{Error, Result};

/// [`container_checksum`] of a description that is to be written as JSON; its own checksum must be empty.
///
/// # Errors
/// It has no JSON form.
pub fn checksum_of<'a>(
    bare: &impl Serialize,
    arrays: impl Iterator<Item = (&'a str, &'a [u8])>,
) -> Result<String> {
    let json = serde_json::to_string(bare).map_err(|e| Error::machine(format!("no JSON form: {e}")))?;
    Ok(container_checksum(&json, arrays))
}

/// BLAKE3 of a container's description, whose own checksum is empty, then of each array's name, a zero byte and its bytes.
#[must_use]
pub fn container_checksum<'a>(
    description: &str,
    arrays: impl Iterator<Item = (&'a str, &'a [u8])>,
) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(description.as_bytes());
    for (name, bytes) in arrays {
        hasher.update(name.as_bytes()).update(&[0]).update(bytes);
    }
    hasher.finalize().to_hex().to_string()
}
