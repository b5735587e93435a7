//! Finding a material by its name or file.

use std::path::Path;

use barbule::brdf::{Material, example};
use barbule::error::did_you_mean;
use barbule::io::{decode_material, read_bytes};
use barbule::render::checkpoint::fingerprint;
use barbule::{Error, Result};

/// The variant that a bare species name means.
const DEFAULTS: &[(&str, &str)] = &[
    ("rock-dove", "forest"),
    ("starling", "green"),
    ("bronzewing", "green"),
    ("hummingbird", "anna"),
    ("mallard", "lime"),
    ("magpie", "violet"),
    ("peafowl", "yellow"),
];

/// A material and the hash of its file: a `.barbule` file, a shipped material by its name (`starling:pink`, `starling`
/// for its default variant), or `example`, a made-up one.
///
/// # Errors
/// There is no such material, or its file is none.
pub fn find(name: &str) -> Result<(Material, String)> {
    if Path::new(name).extension().is_some_and(|e| e == "barbule") {
        let bytes = read_bytes(Path::new(name))?;
        let material = decode_material(&bytes).map_err(|error| error.at(name))?;
        return Ok((material, fingerprint(&bytes)));
    }
    if name == "example" {
        return Ok((example(50), fingerprint(b"example")));
    }
    let full = match name.split_once(':') {
        Some((species, variant)) => format!("{species}-{variant}"),
        None => match DEFAULTS.iter().find(|(species, _)| *species == name) {
            Some((species, variant)) => format!("{species}-{variant}"),
            None => name.to_owned(),
        },
    };
    let Some(bytes) = barbule_materials::material(&full) else {
        let near = did_you_mean(&full, barbule_materials::MATERIALS.iter().map(|(known, _)| *known));
        return Err(Error::input(format!(
            "there is no shipped material '{full}'{near}; name one, or give a .barbule file"
        )));
    };
    Ok((decode_material(bytes).map_err(|error| error.at(&full))?, fingerprint(bytes)))
}
