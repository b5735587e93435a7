//! The feather materials that ship with Barbule: data only, embedded in the program.
//!
//! Each is a `.barbule` file as `barbule characterize` writes it, read through the same reader as users' files.

/// The shipped materials: name (`species-variant`, as in `starling-green`; `-below` for lower sides that differ from the
/// upper ones) and the bytes of the file.
pub const MATERIALS: &[(&str, &[u8])] = &[
    ("bronzewing-green", include_bytes!("../materials/bronzewing-green.barbule")),
    ("hummingbird-anna", include_bytes!("../materials/hummingbird-anna.barbule")),
    ("magpie-violet", include_bytes!("../materials/magpie-violet.barbule")),
    ("magpie-violet-below", include_bytes!("../materials/magpie-violet-below.barbule")),
    ("mallard-lime", include_bytes!("../materials/mallard-lime.barbule")),
    ("mallard-lime-below", include_bytes!("../materials/mallard-lime-below.barbule")),
    ("peafowl-yellow", include_bytes!("../materials/peafowl-yellow.barbule")),
    ("peafowl-yellow-below", include_bytes!("../materials/peafowl-yellow-below.barbule")),
    ("rock-dove-forest", include_bytes!("../materials/rock-dove-forest.barbule")),
    ("rock-dove-jade", include_bytes!("../materials/rock-dove-jade.barbule")),
    ("rock-dove-purple", include_bytes!("../materials/rock-dove-purple.barbule")),
    ("rock-dove-sea", include_bytes!("../materials/rock-dove-sea.barbule")),
    ("rock-dove-teal", include_bytes!("../materials/rock-dove-teal.barbule")),
    ("rock-dove-violet", include_bytes!("../materials/rock-dove-violet.barbule")),
    ("starling-green", include_bytes!("../materials/starling-green.barbule")),
];

/// The bytes of a shipped material.
#[must_use]
pub fn material(name: &str) -> Option<&'static [u8]> {
    MATERIALS.iter().find(|(n, _)| *n == name).map(|(_, bytes)| *bytes)
}
