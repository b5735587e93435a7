//! What there is to open without a file of one's own.

use barbule::Result;
use barbule::scene::preset;
use barbule::structure::{SAMPLES, SpeciesFile, species_names};

/// Something that can be opened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// What is typed to open it.
    pub name: String,
    /// What it is, in a line.
    pub about: String,
    /// What kind it is: `species`, `scene` or `grating`.
    pub kind: &'static str,
}

/// Every variant of the species that are built in, then the presets that no species is called, then the samples of heights.
///
/// # Errors
/// None of what is built in.
pub fn catalogue() -> Result<Vec<Entry>> {
    let mut all = Vec::new();
    for species in species_names() {
        let file = SpeciesFile::builtin(species)?;
        let latin = if file.latin.is_empty() { String::new() } else { format!(" ({})", file.latin) };
        let about = format!("{}{latin}", file.coloration);
        let several = file.variants().count() > 1;
        all.extend(file.variants().map(|variant| Entry {
            name: if several { format!("{species}:{variant}") } else { species.to_owned() },
            about: about.clone(),
            kind: "species",
        }));
    }
    for name in preset::names().filter(|name| species_names().all(|species| species != *name)) {
        all.push(Entry { name: name.to_owned(), about: preset::about(name)?, kind: "scene" });
    }
    let about = "heights of a surface that diffracts light";
    all.extend(SAMPLES.map(|name| Entry { name: name.to_owned(), about: about.to_owned(), kind: "grating" }));
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::Subject;
    use barbule::Unobserved;
    use barbule::open::Opening;

    #[test]
    fn everything_in_the_catalogue_is_opened_as_what_it_says() {
        let all = catalogue().unwrap();
        assert!(all.len() > 30);
        for entry in &all {
            let opened = Subject::open(&entry.name, &Opening::default(), &Unobserved);
            let kind = opened.unwrap_or_else(|error| panic!("{}: {error}", entry.name)).kind();
            assert_eq!(kind, entry.kind, "{}", entry.name);
            assert!(!entry.about.is_empty() && !entry.about.contains('\n'), "{}", entry.name);
        }
        let mut names: Vec<&str> = all.iter().map(|entry| entry.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all.len());
    }
}
