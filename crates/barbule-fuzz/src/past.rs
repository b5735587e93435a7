//! Inputs that once broke a law: each is a file `past/TARGET/WHAT-IT-DID`.

use std::path::{Path, PathBuf};

/// The folder of what this crate has beside its sources.
fn beside(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)
}

/// The files of a target in one of the folders `past` and `seeds`, by name; none where it has no folder of its own there.
#[must_use]
pub fn files(folder: &str, target: &str) -> Vec<(String, Vec<u8>)> {
    let entries = std::fs::read_dir(beside(folder).join(target)).into_iter().flatten().flatten();
    let mut all: Vec<(String, Vec<u8>)> = entries
        .filter_map(|entry| {
            Some((entry.file_name().to_string_lossy().into_owned(), std::fs::read(entry.path()).ok()?))
        })
        .collect();
    all.sort_unstable_by(|(a, _), (b, _)| a.cmp(b));
    all
}

/// The targets that have a folder in `past` or `seeds`.
#[must_use]
pub fn folders(folder: &str) -> Vec<String> {
    let entries = std::fs::read_dir(beside(folder)).into_iter().flatten().flatten();
    entries
        .filter(|entry| entry.path().is_dir())
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect()
}
