//! Feather materials as `.barbule` files, whose bytes [`brdf`](crate::brdf) makes and reads.

use std::path::Path;

use super::{read_bytes, write_whole};
use crate::Result;
use crate::brdf::{FeatherMaterial, decode_material, encode_material};

/// Writes a material.
///
/// # Errors
/// A material that fails [`FeatherMaterial::check`], or a path that cannot be written.
pub fn write_material(path: &Path, material: &FeatherMaterial) -> Result<()> {
    write_whole(path, &encode_material(material)?)
}

/// Reads a material.
///
/// # Errors
/// The file is missing or too large, or no valid material; the message begins with the file's name.
pub fn read_material(path: &Path) -> Result<FeatherMaterial> {
    decode_material(&read_bytes(path)?).map_err(|error| error.in_file(path))
}
