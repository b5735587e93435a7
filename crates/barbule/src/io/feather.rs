//! Writing grown feathers as geometry that other programs read: triangle ribbons or curves, in mm.

mod gltf;
mod parts;
mod text;

use std::path::Path;

use super::{check_writable, write_whole};
use crate::scene::feather::Grown;
use crate::{Error, Result};

use parts::Part;

/// Most barbules of a file: so many ribbons have 5 million corners, the most that a mesh is read with.
pub const MOST_WRITTEN_BARBULES: usize = 350_000;

/// Feathers with more barbules than this are written without them unless asked otherwise.
pub const FEW_BARBULES: usize = 200_000;

/// All draws of a feather that is written are of one individual; the seed gives another.
pub const WRITTEN_IDENTITY: u64 = 1;

/// What a feather is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FeatherFormat {
    /// Triangle ribbons, binary little endian (`.ply`).
    Ply,
    /// Triangle ribbons (`.obj`).
    Obj,
    /// Triangle ribbons with an embedded buffer (`.gltf`).
    Gltf,
    /// Curves with normals, the shaft as a mesh (`.usda`).
    Usda,
    /// Curves and meshes of pbrt (`.pbrt`).
    Pbrt,
    /// Control points of round linear curves, as Mitsuba reads them (`.txt`).
    Curves,
}

impl FeatherFormat {
    /// All with the endings of their files.
    pub const ALL: [(&'static str, Self); 6] = [
        ("ply", Self::Ply),
        ("obj", Self::Obj),
        ("gltf", Self::Gltf),
        ("usda", Self::Usda),
        ("pbrt", Self::Pbrt),
        ("txt", Self::Curves),
    ];

    /// By the ending of a file's name.
    ///
    /// # Errors
    /// Another ending.
    pub fn of(path: &Path) -> Result<Self> {
        let ending = path.extension().map_or_else(String::new, |end| end.to_string_lossy().to_lowercase());
        let found = Self::ALL.iter().find(|(known, _)| *known == ending);
        found.map(|(_, format)| *format).ok_or_else(|| {
            Error::input(format!(
                "{}: feathers are written as .usda, .ply, .obj, .gltf, .pbrt or .txt; end the name with one of these",
                path.display()
            ))
        })
    }
}

/// Memory that [`write_feather`] takes for so many barbs and barbules with the feather itself, bytes, at most and about.
///
/// # Errors
/// An unknown ending.
pub fn foretell_written(path: &Path, barbs: f64, barbules: f64) -> Result<u64> {
    // Of a node: what is grown, its triangles, and the file's text, which grows by doubling.
    let per_node = match FeatherFormat::of(path)? {
        FeatherFormat::Ply => 210.0,
        FeatherFormat::Obj => 420.0,
        FeatherFormat::Gltf => 530.0,
        FeatherFormat::Usda => 240.0,
        FeatherFormat::Pbrt => 350.0,
        FeatherFormat::Curves => 180.0,
    };
    Ok((per_node * (NODES_OF_BARB * barbs + NODES_OF_BARBULE * barbules)) as u64)
}

/// Nodes of a barb and of a barbule as they are grown.
const NODES_OF_BARB: f64 = 25.0;
const NODES_OF_BARBULE: f64 = 7.0;

/// What the barbules of a feather look like in USD's preview: the least that every program draws.
#[derive(Debug, Clone, PartialEq)]
pub struct UsdLook {
    /// Linear sRGB of what they reflect of light from everywhere to an eye over them, 0 … 1.
    pub colour: [f64; 3],
    /// Roughness r, of which α is r².
    pub roughness: f64,
    /// Name of their material.
    pub material: String,
    /// BLAKE3 of its file.
    pub material_hash: String,
}

/// Writes a feather as USD with what its barbules look like, whole or not at all.
///
/// # Errors
/// Another ending than `.usda`, over 350,000 barbules, or the file cannot be written.
pub fn write_usd(path: &Path, grown: &Grown, look: &UsdLook, notes: &[(&str, &str)]) -> Result<()> {
    if FeatherFormat::of(path)? != FeatherFormat::Usda {
        return Err(Error::input("USD is written as text; end the name with .usda").in_file(path));
    }
    check_writable(path)?;
    check_barbules(path, grown)?;
    write_whole(path, &text::usda(grown, Some(look), notes))
}

fn check_barbules(path: &Path, grown: &Grown) -> Result<()> {
    let barbules = grown.counts().barbules;
    if barbules > MOST_WRITTEN_BARBULES {
        return Err(Error::input(format!(
            "{}: would hold {barbules} barbules, over the limit of {MOST_WRITTEN_BARBULES}; write barbs only",
            path.display()
        )));
    }
    Ok(())
}

/// Writes a feather, whole or not at all; `notes` say what made it, in formats that have comments.
///
/// # Errors
/// An unknown ending, over 350,000 barbules, or the file cannot be written.
pub fn write_feather(path: &Path, grown: &Grown, notes: &[(&str, &str)]) -> Result<()> {
    let format = FeatherFormat::of(path)?;
    check_writable(path)?;
    check_barbules(path, grown)?;
    let bytes = match format {
        FeatherFormat::Ply => text::ply(&Part::all(grown), notes),
        FeatherFormat::Obj => text::obj(&Part::all(grown), notes),
        FeatherFormat::Gltf => gltf::encoded(&Part::all(grown), notes)?,
        FeatherFormat::Usda => text::usda(grown, None, notes),
        FeatherFormat::Pbrt => text::pbrt(grown, notes),
        FeatherFormat::Curves => text::curves(grown),
    };
    write_whole(path, &bytes)
}

#[cfg(test)]
mod tests;
