//! What is said of a text that names nothing.

use std::path::Path;

use barbule_birds::BIRDS;

use crate::Error;
use crate::error::{did_you_mean, shortened};
use crate::io::files_in;
use crate::scene::preset;
use crate::structure::species_names;

/// Endings of files that structures, scenes and materials are read from.
const ENDINGS: [&str; 3] = ["toml", "json", "barbule"];

/// Whether a text is written as a file's name is: it ends in a point and a few letters, and lies in a folder that is there.
pub(super) fn is_file_name(text: &str) -> bool {
    let path = Path::new(text);
    let end = path.extension().map(|end| end.to_string_lossy().into_owned()).unwrap_or_default();
    let is_ending = (1..=8).contains(&end.len())
        && end.starts_with(|c: char| c.is_ascii_alphabetic())
        && end.chars().all(|c| c.is_ascii_alphanumeric());
    is_ending && folder(path).is_dir()
}

/// There is no such file; one that lies there under a similar name is offered.
pub(super) fn no_file(text: &str) -> Error {
    let files = files_beside(text);
    let near = did_you_mean(&beginning(text), files.iter().map(String::as_str));
    Error::input(format!("{}: no such file{near}", shortened(text))).of_file(Path::new(text))
}

/// A scene that is neither a preset nor a species nor a file; the nearest of all of them is offered.
pub(super) fn no_scene(text: &str) -> Error {
    let files = files_beside(text);
    let names: Vec<&str> = preset::names().chain(species_names()).collect();
    let known = names.iter().copied().chain(files.iter().map(String::as_str));
    let is_it = |file: &&String| Path::new(file).file_stem() == Path::new(text).file_name();
    // A file without its ending, else the nearest.
    let near = match files.iter().find(is_it) {
        Some(file) => format!(", did you mean '{}'?", shortened(file)),
        None => did_you_mean(&beginning(text), known),
    };
    // Then by the other names that birds have.
    let near = match near.is_empty() {
        true => did_you_mean(&beginning(text), BIRDS.iter().flat_map(|bird| bird.also.iter().copied())),
        false => near,
    };
    let presets = preset::names().collect::<Vec<_>>().join(", ");
    let known = if near.is_empty() { format!(" (presets are {presets})") } else { near };
    Error::input(format!("there is no preset, species or file '{}'{known}", shortened(text)))
}

/// As much of a text as is compared with names.
fn beginning(text: &str) -> String {
    text.chars().take(200).collect()
}

/// The files that could have been meant, in the folder that a text names, and named as it does.
fn files_beside(text: &str) -> Vec<String> {
    let path = Path::new(text);
    let found = ENDINGS.iter().flat_map(|ending| files_in(folder(path), ending));
    let named = |found: std::path::PathBuf| {
        found.file_name().map(|name| path.with_file_name(name).to_string_lossy().into_owned())
    };
    found.filter_map(named).collect()
}

/// The folder in which a file would lie.
fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_are_told_from_stacks_and_birds() {
        for text in ["grey.tml", "./a.b7", "x.barbule"] {
            assert!(is_file_name(text), "{text}");
        }
        for text in [
            "starling",
            "air/1.56+0.02j",
            "air/1.5",
            "mix(a,b,0.4)",
            "S. vulgaris",
            "no/such/folder/x.toml",
            "x.",
            ".",
            "a.toml:pink",
        ] {
            assert!(!is_file_name(text), "{text}");
        }
    }

    #[test]
    fn what_lies_beside_is_offered() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
        std::fs::write(at("grey.toml"), "").unwrap();
        let message = no_file(&at("grey.tml")).to_string();
        assert!(
            message.contains("grey.tml: no such file, did you mean '") && message.contains("grey.toml'?"),
            "{message}"
        );
        let message = no_scene("starling-feathers").to_string();
        assert_eq!(
            message,
            "there is no preset, species or file 'starling-feathers', did you mean 'starling-feather'?"
        );
        let message = no_scene(&"q".repeat(10_000)).to_string();
        assert!(message.contains("(presets are rock-dove, ") && message.len() < 600, "{message}");
    }
}
