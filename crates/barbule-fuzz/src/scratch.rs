//! One folder for readers that take paths alone: in memory where the system has such a place.

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// Where folders are made, unless `BARBULE_FUZZ_SCRATCH` names another place.
const IN_MEMORY: &str = "/dev/shm";

thread_local! {
    static FOLDER: TempDir = made();
}

fn made() -> TempDir {
    let asked = std::env::var_os("BARBULE_FUZZ_SCRATCH").map(PathBuf::from);
    let place = asked.unwrap_or_else(|| match Path::new(IN_MEMORY).is_dir() {
        true => IN_MEMORY.into(),
        false => std::env::temp_dir(),
    });
    tempfile::Builder::new().prefix("barbule-fuzz-").tempdir_in(place).unwrap_or_else(|error| {
        // Without it no target of this kind means anything.
        panic!("no folder for inputs can be made: {error}")
    })
}

/// The folder of this thread; it goes with the thread.
#[must_use]
pub fn folder() -> PathBuf {
    FOLDER.with(|folder| folder.path().to_owned())
}

/// A file of this thread with these bytes, which replace what it held.
///
/// # Panics
/// It cannot be written: the machine is full.
#[must_use]
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder().join(name);
    if let Some(parent) = path.parent() {
        // It is there after the first time.
        let _ = fs::create_dir_all(parent);
    }
    if let Err(error) = fs::write(&path, bytes) {
        panic!("{}: an input cannot be written: {error}", path.display());
    }
    path
}
