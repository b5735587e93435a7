//! What `barbule render` draws, as people type it.

use std::path::Path;

use barbule::io::{InputKind, kind_of};
use barbule::scene::description::SceneDescription;
use barbule::{Result, open};

use crate::common::Common;
use crate::progress::Doubts;
use crate::structure_arg::with_advice;

/// What every SCENE argument says in `--help`.
pub(crate) const HELP: &str = "A preset, SPECIES:VARIANT, a scene .toml, or your own bird: a species or lattice .toml, a section .json, a folder of sections, a stack, or a .barbule file";

/// The scene of a name, file, folder or stack; see [`open::description`].
///
/// # Errors
/// As there.
pub(crate) fn parse(text: &str, common: &Common) -> Result<SceneDescription> {
    open::description(text, &common.opening()?, &Doubts(common)).map_err(|error| {
        match kind_of(Path::new(text)) {
            // It is one, with a fault.
            Ok(InputKind::Scene) => error,
            _ => with_advice(error, text),
        }
    })
}
