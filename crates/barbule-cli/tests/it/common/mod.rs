//! What several of these tests need.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::OnceLock;

use barbule::brdf::fixtures::example;
use barbule::io::write_material;

/// The file of a made-up material; [`write_made_up`] writes it.
pub(crate) const MADE_UP: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/made-up.barbule");

/// Writes [`MADE_UP`] once per run of the tests.
pub(crate) fn write_made_up() {
    static WRITTEN: OnceLock<()> = OnceLock::new();
    WRITTEN.get_or_init(|| write_material(Path::new(MADE_UP), &example(50)).unwrap());
}

/// A scene whose light and framing are the tests' own: presets may be composed anew.
pub(crate) const CLOSE_UP: &str = include_str!("../../../../barbule/tests/it/data/close-up.toml");

/// Everything in a folder, hidden files too: relative path → bytes.
pub(crate) fn bytes_of(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(path) = open.pop() {
        for entry in std::fs::read_dir(path).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_string_lossy().into_owned();
                found.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    found
}
