//! The targets: one for each reader and format.

mod containers;
mod pictures;
mod shapes;
mod spectra;
mod stores;
mod texts;
mod words;

use std::sync::OnceLock;

use barbule::material::Library;

use crate::past;
use crate::{Held, Verdict};

/// A reader with its laws.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// As it is called on command lines.
    pub name: &'static str,
    /// What it reads, in a few words.
    pub about: &'static str,
    /// Words of the format, for mutations.
    pub tokens: &'static [&'static str],
    /// Inputs to begin with, beside the files in `seeds/NAME`.
    seeds: fn() -> Vec<Vec<u8>>,
    /// Examines one input.
    pub(crate) check: fn(&[u8]) -> Verdict,
    weight: Weight,
}

/// What an input may cost.
#[derive(Debug, Clone, Copy)]
enum Weight {
    /// Texts: their trees take up to so many times their bytes.
    Text,
    /// Numbers that are kept about as the file has them.
    Numbers,
    /// The same, of a megabyte.
    Large,
    /// A file of a store that is opened anew for each.
    Store,
    /// Pictures, which packed files hold many of in few bytes.
    Picture,
}

/// Memory that is there whatever is read: what readers fill once.
const ANYWAY: usize = 24 << 20;

impl Target {
    /// Inputs to begin with.
    #[must_use]
    pub fn seeds(&self) -> Vec<Vec<u8>> {
        let files = past::files("seeds", self.name).into_iter().map(|(_, bytes)| bytes);
        (self.seeds)().into_iter().chain(files).collect()
    }

    /// The most memory that an input of so many bytes may take at once, bytes.
    #[must_use]
    pub fn most_bytes(&self, length: usize) -> usize {
        match self.weight {
            Weight::Text | Weight::Store => ANYWAY + 2_000 * length,
            Weight::Numbers | Weight::Large => ANYWAY + 64 * length,
            // What `docs/formats/files.md` promises of all files.
            Weight::Picture => 1_500_000_000,
        }
    }

    /// How many inputs the smoke test makes: what is slow gets fewer.
    #[must_use]
    pub fn smoke(&self) -> u64 {
        match self.weight {
            Weight::Text | Weight::Numbers => 2_000,
            Weight::Picture => 700,
            Weight::Store => 200,
            Weight::Large => 60,
        }
    }
}

/// All targets, by name.
#[must_use]
pub fn all() -> &'static [Target] {
    static ALL: OnceLock<Vec<Target>> = OnceLock::new();
    ALL.get_or_init(|| {
        let mut all: Vec<Target> = [
            texts::TARGETS,
            spectra::TARGETS,
            shapes::TARGETS,
            pictures::TARGETS,
            containers::TARGETS,
            stores::TARGETS,
            words::TARGETS,
        ]
        .concat();
        all.sort_by_key(|target| target.name);
        all
    })
}

/// The target of a name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Target> {
    all().iter().find(|target| target.name == name)
}

/// The built-in media, made once.
fn library() -> &'static Library {
    static LIBRARY: OnceLock<Library> = OnceLock::new();
    LIBRARY.get_or_init(Library::builtin)
}

/// The bytes of texts.
fn bytes_of<'a>(texts: impl IntoIterator<Item = &'a str>) -> Vec<Vec<u8>> {
    texts.into_iter().map(|text| text.as_bytes().to_vec()).collect()
}

/// Every value is a number.
fn finite<'a>(what: &str, values: impl IntoIterator<Item = &'a f64>) -> Held {
    match values.into_iter().find(|value| !value.is_finite()) {
        Some(value) => Err(format!("{what}: {value} was accepted")),
        None => Ok(()),
    }
}
