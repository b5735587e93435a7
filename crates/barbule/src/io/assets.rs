//! Where the files that a scene names are read from: a folder, memory, or whatever a front end has.

use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::PathBuf;

use super::whole::{open_regular, read_at_most};
use crate::{Error, Result};

/// Files by the names under which a scene has them.
pub trait Assets {
    /// The bytes of a file of at most `largest` bytes.
    ///
    /// # Errors
    /// There is none of this name, or it is too large; the message begins with what [`Assets::place`] says.
    fn read(&self, name: &str, largest: u64) -> Result<Vec<u8>>;

    /// The first bytes of a file, at most so many, and its length, for foretelling what it takes in memory; nothing where it cannot
    /// be looked at without being used up, or not at all, which reading it will say.
    fn beginning(&self, name: &str, most: usize) -> Option<(Vec<u8>, u64)>;

    /// What messages call a file.
    fn place(&self, name: &str) -> String;
}

/// Files of a folder; names are paths from there.
#[derive(Debug, Clone, Default)]
pub struct Folder(pub PathBuf);

impl Assets for Folder {
    fn read(&self, name: &str, largest: u64) -> Result<Vec<u8>> {
        read_at_most(&self.0.join(name), largest)
    }

    fn beginning(&self, name: &str, most: usize) -> Option<(Vec<u8>, u64)> {
        let (file, length) = open_regular(&self.0.join(name))?;
        let mut bytes = Vec::new();
        file.take(most as u64).read_to_end(&mut bytes).ok()?;
        Some((bytes, length))
    }

    fn place(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }
}

/// Files in memory: of a web page, an archive or a test.
#[derive(Debug, Clone, Default)]
pub struct Memory(pub BTreeMap<String, Vec<u8>>);

impl Assets for Memory {
    fn read(&self, name: &str, largest: u64) -> Result<Vec<u8>> {
        let refuse = |what: &str| Error::input(format!("{}: {what}", self.place(name)));
        let bytes = self.0.get(name).ok_or_else(|| refuse("no such file"))?;
        if bytes.len() as u64 > largest {
            return Err(refuse(&format!("has {} bytes, over the limit of {largest}", bytes.len())));
        }
        Ok(bytes.clone())
    }

    fn beginning(&self, name: &str, most: usize) -> Option<(Vec<u8>, u64)> {
        let bytes = self.0.get(name)?;
        Some((bytes[..most.min(bytes.len())].to_vec(), bytes.len() as u64))
    }

    fn place(&self, name: &str) -> String {
        name.to_owned()
    }
}

/// The ending of a file's name, in lower case.
pub(super) fn ending(name: &str) -> String {
    std::path::Path::new(name)
        .extension()
        .map_or_else(String::new, |end| end.to_string_lossy().to_lowercase())
}
