//! Scenes that need no file of the user's: close-ups of feathers and whole ones, and gratings, as the texts of their scene files.

use crate::error::{did_you_mean, shortened};
use crate::{Error, Result};

const PRESETS: &[(&str, &str)] = &[
    ("rock-dove", include_str!("presets/rock-dove.toml")),
    ("starling", include_str!("presets/starling.toml")),
    ("bronzewing", include_str!("presets/bronzewing.toml")),
    ("hummingbird", include_str!("presets/hummingbird.toml")),
    ("mallard", include_str!("presets/mallard.toml")),
    ("magpie", include_str!("presets/magpie.toml")),
    ("peafowl", include_str!("presets/peafowl.toml")),
    ("rock-dove-feather", include_str!("presets/rock-dove-feather.toml")),
    ("starling-feather", include_str!("presets/starling-feather.toml")),
    ("bronzewing-feather", include_str!("presets/bronzewing-feather.toml")),
    ("hummingbird-feather", include_str!("presets/hummingbird-feather.toml")),
    ("mallard-feather", include_str!("presets/mallard-feather.toml")),
    ("magpie-feather", include_str!("presets/magpie-feather.toml")),
    ("peafowl-feather", include_str!("presets/peafowl-feather.toml")),
    ("osprey", include_str!("presets/osprey.toml")),
    ("turkey-vulture", include_str!("presets/turkey-vulture.toml")),
    ("rock-dove-wing", include_str!("presets/rock-dove-wing.toml")),
    ("snake", include_str!("presets/snake.toml")),
    ("diffraction-bench", include_str!("presets/diffraction-bench.toml")),
];

/// The presets' names.
pub fn names() -> impl Iterator<Item = &'static str> + Clone {
    PRESETS.iter().map(|(name, _)| *name)
}

/// A preset's scene file.
///
/// # Errors
/// There is none of this name; the message offers the nearest.
pub fn toml(name: &str) -> Result<&'static str> {
    PRESETS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text).ok_or_else(|| {
        let known = names().collect::<Vec<_>>().join(", ");
        let near = did_you_mean(name, names());
        Error::input(format!("there is no preset '{}'{near} (known are {known})", shortened(name)))
    })
}
