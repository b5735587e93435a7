//! What people type, as values: structures and materials by their names, files, folders or stacks.
//!
//! What the caller decides is in an [`Opening`]: media, cache, seed, and whether a material that is not there may be computed.
//! Nothing here looks at the environment.
//!
//! ```
//! use barbule::Unobserved;
//! use barbule::open::{Opened, Opening, open};
//!
//! # fn main() -> barbule::Result<()> {
//! # let folder = tempfile::tempdir().unwrap();
//! # let (resin, stack) = (folder.path().join("resin.csv"), folder.path().join("stack.toml"));
//! # std::fs::write(&resin, "300,1.6,0.01\n830,1.5,0\n").unwrap();
//! # std::fs::write(&stack, "stack = \"air/resin:320/keratin\"").unwrap();
//! let mut opening = Opening::default();
//! opening.media.add("resin", &resin)?; // a table of n and k
//! for text in ["starling:pink", "air/keratin:320/air", &stack.to_string_lossy()] {
//!     match open(text, &opening, &Unobserved)? {
//!         Opened::Structure(structure) => println!("{}", structure.name()),
//!         Opened::Material(found) => println!("a material of {} bytes", found.bytes()?.len()),
//!         _ => {}
//!     }
//! }
//! # Ok(())
//! # }
//! ```

mod material;
mod media;
mod scene;
mod structure;
mod subject;
mod unknown;
mod vision;

use std::path::Path;

pub use material::{Located, locate, made, material, material_of, worn};
pub use media::Media;
pub use scene::{description, folder_of, scene};
pub use structure::{film_stack, is_built_in, lattice, lattice_of, stack, structure};
pub use subject::{subject, target};
pub use vision::{Simulation, Thing, eye, eye_names, light, things};

use crate::Result;
use crate::campaign::Resources;
use crate::characterize::{CampaignOptions, Catalog, Found};
use crate::io::{InputKind, kind_of};
use crate::progress::Progress;
use crate::structure::Structure;

/// What the caller decides about what is opened.
#[derive(Debug, Clone)]
pub struct Opening {
    /// The media that structures may name.
    pub media: Media,
    /// Finished materials: those that ship, and those of a cache folder, where new ones are kept.
    pub catalog: Catalog,
    /// Seed of what is simulated for a material.
    pub seed: u64,
    /// Whether a material that is not there yet may be characterized, which takes minutes.
    pub may_compute: bool,
    /// What that is computed with.
    pub resources: Resources,
}

impl Default for Opening {
    fn default() -> Self {
        Self {
            media: Media::default(),
            catalog: Catalog::default(),
            seed: CampaignOptions::default().seed,
            may_compute: true,
            resources: Resources::default(),
        }
    }
}

/// What a text names.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Opened {
    /// A structure: a species, a stack, sections or a lattice.
    Structure(Structure),
    /// The material of a file.
    Material(Box<Found>),
}

/// Opens a text as people type it, by what it names: a material file, or as [`structure`].
///
/// # Errors
/// A damaged material, or as [`structure`].
pub fn open(text: &str, opening: &Opening, progress: &dyn Progress) -> Result<Opened> {
    match material_file(text)? {
        Some(found) => Ok(Opened::Material(Box::new(found))),
        None => structure(text, opening, progress).map(Opened::Structure),
    }
}

/// The material of a file, if the text names one: by its ending, or by what is in it. Built-in names never mean files.
///
/// # Errors
/// A file that ends in `.barbule` is missing, or a material is damaged.
pub fn material_file(text: &str) -> Result<Option<Found>> {
    let path = Path::new(text);
    let is_named = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("barbule"));
    if is_built_in(text) || !(is_named || path.is_file()) {
        return Ok(None);
    }
    // A damaged material is refused as one.
    let is_material = is_named || kind_of(path)? == InputKind::Material;
    is_material.then(|| Found::in_file(path)).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Unobserved;

    #[test]
    fn a_text_is_opened_as_what_it_names() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
        let bytes = barbule_birds::material("starling-green").unwrap();
        for name in ["a.barbule", "without-ending"] {
            std::fs::write(path(name), bytes).unwrap();
            let opened = open(&path(name), &Opening::default(), &Unobserved).unwrap();
            let Opened::Material(found) = opened else { panic!("{name} is {opened:?}") };
            assert_eq!(found.bytes().unwrap(), bytes);
        }
        let opened = open("starling", &Opening::default(), &Unobserved).unwrap();
        assert!(matches!(&opened, Opened::Structure(s) if s.name() == "starling:green"), "{opened:?}");
        std::fs::write(path("bad.barbule"), &bytes[..100]).unwrap();
        let refused = open(&path("bad.barbule"), &Opening::default(), &Unobserved).unwrap_err();
        assert!(refused.to_string().contains("is not a material file"), "{refused}");
    }
}
