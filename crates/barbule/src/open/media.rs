//! The media that structures may name, and where those of the caller's own come from.

use std::path::Path;

use crate::Result;
use crate::io::tables::read_index_table;
use crate::material::{KERATIN_CLEAR_FROM_NM, Library, Material};
use crate::structure::{FlatStack, MaterialSource, Medium, Section, Structure, Substance};

/// Media by name: those built in, and the caller's own, each from a table of n and k.
#[derive(Debug, Clone, Default)]
pub struct Media {
    library: Library,
    own: Vec<(String, MaterialSource)>,
}

impl Media {
    /// Adds a medium from a table, in place of one that had its name.
    ///
    /// # Errors
    /// The table cannot be read, or the name cannot be one of a medium.
    pub fn add(&mut self, name: &str, file: &Path) -> Result<()> {
        let table = read_index_table(file)?;
        self.library.insert_table(name, table).map_err(|e| e.at("`media`").naming(&["media"]))?;
        let path = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
        self.own.retain(|(known, _)| known != name);
        self.own.push((name.to_owned(), MaterialSource::File(path)));
        Ok(())
    }

    /// Makes a medium's n higher by `by` at every wavelength.
    ///
    /// # Errors
    /// There is no such medium, or it would have an index that none has.
    pub fn shift(&mut self, name: &str, by: f64) -> Result<()> {
        let shifted = self.library.get(name)?.with_higher_index(by)?;
        self.library.insert(name, shifted)
    }

    /// All of them by name.
    #[must_use]
    pub fn library(&self) -> &Library {
        &self.library
    }

    /// The caller's own that nothing is made of where media have these names, or are expressions of names.
    #[must_use]
    pub fn unused<'a>(&'a self, media: &[&str]) -> Vec<&'a str> {
        let names = self.own.iter().map(|(name, _)| name.as_str());
        names.filter(|name| !media.iter().any(|medium| is_made_of(medium, name))).collect()
    }

    /// The caller's own that a structure does without, by its first individual; one without any is refused where it is needed.
    #[must_use]
    pub fn unused_in(&self, structure: &Structure, seed: u64) -> Vec<&str> {
        if self.own.is_empty() {
            return Vec::new();
        }
        let Ok(section) = structure.instance(seed, 0) else { return Vec::new() };
        self.unused(&named_in(&section))
    }

    /// Whether light of this wavelength, nm, meets keratin where nobody has measured what it absorbs, if these are the media.
    #[must_use]
    pub fn guesses(&self, media: &[&str], wavelength_nm: f64) -> bool {
        wavelength_nm < KERATIN_CLEAR_FROM_NM
            && self.library.get("keratin").is_ok_and(|own| *own == Material::keratin())
            && media.iter().any(|medium| is_made_of(medium, "keratin"))
    }

    /// [`guesses`](Self::guesses) of what a structure's first individual is made of.
    #[must_use]
    pub fn guesses_in(&self, structure: &Structure, seed: u64, wavelength_nm: f64) -> bool {
        wavelength_nm < KERATIN_CLEAR_FROM_NM
            && structure
                .instance(seed, 0)
                .is_ok_and(|section| self.guesses(&named_in(&section), wavelength_nm))
    }

    /// Keeps the files of own media with sections that name them, so that a written section finds them again.
    pub(super) fn remember_in(&self, sections: &mut [Section]) {
        for (name, source) in &self.own {
            for section in &mut *sections {
                let named = |s: &Substance| matches!(s, Substance::Named(text) if text.contains(name));
                if section.all_media().flat_map(|medium| medium.substances()).any(named) {
                    section.materials.entry(name.clone()).or_insert(source.clone());
                }
            }
        }
    }

    /// The same for a stack.
    pub(crate) fn remember_in_stack(&self, flat: &mut FlatStack) {
        let regions = 0..flat.stack.layers() + 2;
        for (name, source) in &self.own {
            if regions.clone().any(|region| flat.stack.medium(region).contains(name)) {
                flat.materials.entry(name.clone()).or_insert(source.clone());
            }
        }
    }
}

/// The names of all media of a section and of its crystal's rods.
fn named_in(section: &Section) -> Vec<&str> {
    let lattice = section.crystal.iter().map(|crystal| &crystal.lattice);
    let rods = lattice.flat_map(|lattice| &lattice.rods).flat_map(|rod| &rod.circles).map(|c| &c.medium);
    let media = section.all_media().flat_map(Medium::substances).chain(rods);
    media
        .filter_map(|substance| match substance {
            Substance::Named(name) => Some(name.as_str()),
            Substance::Index(_) => None,
        })
        .collect()
}

/// Whether a medium, such as `keratin` or `mix(keratin,melanin,0.4)`, names another one.
fn is_made_of(medium: &str, name: &str) -> bool {
    let of_names = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.');
    medium == name || medium.split(|c| !of_names(c)).any(|word| word == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_medium_is_used_where_its_whole_name_stands() {
        assert!(is_made_of("keratin", "keratin") && is_made_of("mix(keratin,melanin,0.4)", "melanin"));
        assert!(is_made_of("mix(chitin.2,melanin,0.4)", "chitin.2"));
        assert!(!is_made_of("mykeratin", "keratin") && !is_made_of("keratin", "mykeratin"));
    }

    #[test]
    fn keratin_is_guessed_at_below_its_measurements_and_a_table_of_it_is_not() {
        let mut media = Media::default();
        let starling = Structure::builtin("starling").unwrap();
        assert!(
            media.guesses(&["air", "mix(keratin,air,0.5)"], 349.0) && media.guesses_in(&starling, 1, 300.0)
        );
        assert!(!media.guesses(&["keratin"], 350.0) && !media.guesses(&["air", "melanin"], 300.0));
        let folder = tempfile::tempdir().unwrap();
        let own = folder.path().join("keratin.csv");
        std::fs::write(&own, "300,1.6,0.01\n830,1.55,0\n").unwrap();
        media.add("keratin", &own).unwrap();
        assert!(!media.guesses(&["keratin"], 300.0) && !media.guesses_in(&starling, 1, 300.0));
    }

    #[test]
    fn a_name_has_the_table_that_was_given_last() {
        let folder = tempfile::tempdir().unwrap();
        let [one, other] = [("a.csv", "1.4"), ("b.csv", "1.7")].map(|(name, n)| {
            let path = folder.path().join(name);
            std::fs::write(&path, format!("300,{n}\n830,{n}\n")).unwrap();
            path
        });
        let mut media = Media::default();
        media.add("q", &one).unwrap();
        media.add("q", &other).unwrap();
        assert_eq!(media.library().get("q").unwrap().index(500.0).unwrap().re, 1.7);
        let mut stack = FlatStack::parse("air/q:5/air", media.library().clone()).unwrap();
        media.remember_in_stack(&mut stack);
        assert_eq!(stack.materials["q"], MaterialSource::File(other));
        assert_eq!((media.unused(&["air"]), media.unused(&["mix(q,air,0.5)"])), (vec!["q"], vec![]));
        let refused = media.add("5x", &one).unwrap_err();
        assert!(refused.to_string().starts_with("`media`: '5x' cannot name"), "{refused}");
    }
}
