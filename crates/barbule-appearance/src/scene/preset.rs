//! Scenes that need no file of the user's: close-ups of feathers and whole ones, and gratings, as the texts of their scene files.

use barbule_birds::BIRDS;

use crate::error::{did_you_mean, shortened};
use crate::{Error, Result};

/// Those of no bird.
const GRATINGS: [(&str, &str); 2] = [
    ("snake", include_str!("presets/snake.toml")),
    ("diffraction-bench", include_str!("presets/diffraction-bench.toml")),
];

/// Close-ups, then whole feathers, then feathers without structural colour, then gratings.
fn presets() -> impl Iterator<Item = (&'static str, &'static str)> + Clone {
    let close_ups = BIRDS.iter().filter_map(|bird| Some((bird.name, bird.scene?)));
    let feathers = BIRDS.iter().filter_map(|bird| Some((bird.feather_name, bird.feather?)));
    let wings = BIRDS.iter().filter_map(|bird| Some((bird.name, bird.wing?)));
    close_ups.chain(feathers).chain(wings).chain(GRATINGS)
}

/// The presets' names.
pub fn names() -> impl Iterator<Item = &'static str> + Clone {
    presets().map(|(name, _)| name)
}

/// A preset's scene file.
///
/// # Errors
/// There is none of this name; the message offers the nearest.
pub fn toml(name: &str) -> Result<&'static str> {
    presets().find(|(known, _)| *known == name).map(|(_, text)| text).ok_or_else(|| {
        let known = names().collect::<Vec<_>>().join(", ");
        let near = did_you_mean(name, names());
        Error::input(format!("there is no preset '{}'{near} (known are {known})", shortened(name)))
    })
}
