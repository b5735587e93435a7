//! Finding a material by its name or file.

use barbule::brdf::{Material, example};
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

/// A material and the hash of its file. `example` is a made-up one; the others are shipped with the program.
///
/// # Errors
/// There is no such material.
pub fn find(name: &str) -> Result<(Material, String)> {
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
    Err(Error::input(format!("there is no material '{full}'")))
}
