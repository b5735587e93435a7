//! Finished pieces of long work in a folder, so that the same work goes on where it was stopped.
//!
//! Each is a file of its own that appears whole, named by what it is and by the head of its identity: a hash of all that decides its
//! numbers. It holds the BLAKE3 of all that follows, the whole identity, and the value as JSON, in a line each. What is damaged, or of
//! another identity, is not there.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::whole::{hash_bytes, make_folder, read_own};
use super::write_whole;
use crate::{Error, Result};

/// Digits of an identity, or of another hash, in a file's name.
pub const HASH_DIGITS: usize = 16;

/// The largest unit that is read: 1 GiB.
const LARGEST: u64 = 1 << 30;

/// The units of one folder, which is made with the first of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Units {
    folder: PathBuf,
}

impl Units {
    /// Those in a folder, which need not be there.
    #[must_use]
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.to_owned() }
    }

    /// The unit of this name and identity, where it was kept and is whole.
    #[must_use]
    pub fn get<T: DeserializeOwned>(&self, name: &str, identity: &str) -> Option<T> {
        let bytes = read_own(&self.path(name, identity), LARGEST).ok()?;
        let text = std::str::from_utf8(&bytes).ok()?;
        let (sum, rest) = text.split_once('\n')?;
        let (of, value) = rest.split_once('\n')?;
        (sum == hash_bytes(rest.as_bytes()) && of == identity)
            .then(|| serde_json::from_str(value).ok())
            .flatten()
    }

    /// Keeps a unit under its name and identity; the same numbers are read back to the bit.
    ///
    /// # Errors
    /// The folder or the file cannot be written.
    pub fn keep<T: Serialize>(&self, name: &str, identity: &str, value: &T) -> Result<()> {
        let value = serde_json::to_string(value)
            .map_err(|e| Error::machine(format!("{name} cannot be kept: {e}")))?;
        let rest = format!("{identity}\n{value}\n");
        make_folder(&self.folder)?;
        write_whole(&self.path(name, identity), format!("{}\n{rest}", hash_bytes(rest.as_bytes())).as_bytes())
    }

    /// Takes a unit away that a larger one holds now; one that cannot be deleted does no harm.
    pub fn forget(&self, name: &str, identity: &str) {
        let _ = std::fs::remove_file(self.path(name, identity));
    }

    fn path(&self, name: &str, identity: &str) -> PathBuf {
        let head = identity.get(..HASH_DIGITS).unwrap_or(identity);
        self.folder.join(format!("{name}-{head}.unit"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn identity(digit: char) -> String {
        digit.to_string().repeat(64)
    }

    #[test]
    fn units_come_back_to_the_bit_and_never_as_anothers() {
        let folder = tempfile::tempdir().unwrap();
        let units = Units::new(&folder.path().join("units"));
        assert_eq!(units.get::<Vec<f64>>("a", &identity('1')), None);
        let values = vec![0.1 + 0.2, f64::MIN_POSITIVE / 3.0, -0.0, 1e300];
        units.keep("a", &identity('1'), &values).unwrap();
        let back: Vec<f64> = units.get("a", &identity('1')).unwrap();
        assert_eq!(
            back.iter().map(|v| v.to_bits()).collect::<Vec<_>>(),
            values.iter().map(|v| v.to_bits()).collect::<Vec<_>>()
        );
        // Another identity with the same head.
        let near = identity('1')[..HASH_DIGITS].to_owned() + &identity('2')[HASH_DIGITS..];
        assert_eq!(units.get::<Vec<f64>>("a", &near), None);
        assert_eq!(units.get::<Vec<f64>>("b", &identity('1')), None);
        units.forget("a", &identity('1'));
        assert_eq!(units.get::<Vec<f64>>("a", &identity('1')), None);
    }

    #[test]
    fn damaged_units_are_not_there() {
        let folder = tempfile::tempdir().unwrap();
        let units = Units::new(folder.path());
        let values = vec![1.5, 2.25];
        units.keep("a", &identity('1'), &values).unwrap();
        let path = units.path("a", &identity('1'));
        let good = std::fs::read(&path).unwrap();
        for at in 0..good.len() {
            let mut bad = good.clone();
            bad[at] ^= 1;
            std::fs::write(&path, &bad).unwrap();
            assert_eq!(units.get::<Vec<f64>>("a", &identity('1')), None, "{at}");
            std::fs::write(&path, &good[..at]).unwrap();
            assert_eq!(units.get::<Vec<f64>>("a", &identity('1')), None, "{at}");
        }
    }
}
