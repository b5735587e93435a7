//! What a viewer remembers in a file: what is open, what was moved in it, how it is looked at, and what is pinned beside it.

use std::path::Path;

use barbule::fields::{NumbersByName, Record, Several, Text, in_toml, parse_toml, within};
use barbule::structure::Side;
use barbule::{Error, Result, open};
use barbule_base::record;

use super::beside::Beside;
use super::view::View;

/// Version of the format.
pub const FORMAT: usize = 1;

/// The key of the version, which tells such files from others.
const VERSION: &str = "barbule_view";

record! {
    /// Something with what was moved in it.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Kept {
        /// What it is, as it is typed.
        open: String = "open", Text("what is looked at, as in starling:green");
        /// The sizes that were moved.
        sizes: NumbersByName = "sizes", (), or NumbersByName::default();
    }
}

record! {
    /// A saved viewer.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Saved {
        /// Version of the format.
        version: usize = "barbule_view", within(FORMAT as f64, FORMAT as f64);
        /// Files of measured spectra that are drawn beside it.
        measured: Vec<String> = "measured",
            Several { least: 0, most: Beside::MOST, of: Text("the name of a file") }, or Vec::new();
        /// What is pinned beside it.
        pinned: Option<Kept> = "pinned", ();
        /// How it is looked at.
        view: View = "view", (), or View::default();
        @flat {
            /// What is open.
            subject: Kept;
        }
    }
}

impl Saved {
    /// Reads the text of a file.
    ///
    /// # Errors
    /// It is no TOML, no saved viewer, one of another version, or a key is unknown, missing or out of its range.
    pub fn parse(text: &str) -> Result<Self> {
        let value = parse_toml(text)?;
        match value.get(VERSION) {
            None => {
                return Err(Error::input(format!(
                    "is no saved viewer, which begins with {VERSION} = {FORMAT}; open species, stacks and scenes by their names or files"
                )));
            }
            Some(version) if version.as_u64() != Some(FORMAT as u64) => {
                return Err(Error::input(format!(
                    "{VERSION} is {version}, but this version reads format {FORMAT} only; save it anew with the program that wrote it, or open what it names"
                )));
            }
            Some(_) => {}
        }
        Self::read(&value, "").map_err(|error| in_toml(error, text))
    }

    /// The text of a file that is read as it.
    ///
    /// # Errors
    /// A number that TOML has not.
    pub fn to_toml(&self) -> Result<String> {
        let body = toml::to_string(&self.table())
            .map_err(|error| Error::machine(format!("the viewer's state cannot be written: {error}")))?;
        Ok(format!("# What Barbule's viewer shows; open it with `barbule-view FILE`.\n{body}"))
    }

    /// Whether a text is meant as one, damaged or not.
    #[must_use]
    pub fn is_meant(text: &str) -> bool {
        text.lines().any(|line| line.trim_start().starts_with(VERSION))
    }
}

/// What is open as it is named from anywhere: files by their whole paths, everything else as it was typed.
#[must_use]
pub fn named_from_anywhere(text: &str) -> String {
    let (upper, side) = match text.strip_suffix(Side::BELOW) {
        Some(upper) => (upper, Side::BELOW),
        None => (text, ""),
    };
    if open::is_built_in(upper) {
        return text.to_owned();
    }
    let whole = |file: &str| {
        let path = Path::new(file);
        path.exists().then(|| std::path::absolute(path).ok()).flatten()
    };
    if let Some(path) = whole(upper) {
        return format!("{}{side}", path.display());
    }
    match upper.rsplit_once(':').and_then(|(file, variant)| Some((whole(file)?, variant))) {
        Some((path, variant)) => format!("{}:{variant}{side}", path.display()),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::view::{Mode, Seer};

    fn saved() -> Saved {
        let sizes = NumbersByName(std::collections::BTreeMap::from([
            ("cortex_um".to_owned(), 0.25),
            ("layers[1].thickness_um".to_owned(), 0.12),
        ]));
        let view = View { mode: Mode::Vane, eye: Seer::Bird("starling".into()), ..View::default() };
        Saved {
            version: FORMAT,
            subject: Kept { open: "starling:pink".into(), sizes },
            measured: vec!["a.csv".into()],
            pinned: Some(Kept { open: "air/keratin:300/air".into(), sizes: NumbersByName::default() }),
            view,
        }
    }

    #[test]
    fn what_is_saved_is_read_as_it_was() {
        let text = saved().to_toml().unwrap();
        assert_eq!(Saved::parse(&text).unwrap(), saved());
        assert!(Saved::is_meant(&text) && !Saved::is_meant("preset = 'starling'"));
        let least = Saved::parse("barbule_view = 1\nopen = 'starling'\n").unwrap();
        assert_eq!(
            (least.subject.open.as_str(), least.view, least.pinned),
            ("starling", View::default(), None)
        );
    }

    #[test]
    fn files_that_do_not_fit_are_refused_in_a_sentence() {
        for (text, words) in [
            (
                "barbule_view = 2\nopen = 'starling'",
                "barbule_view is 2, but this version reads format 1 only",
            ),
            ("barbule_view = 'x'\nopen = 'starling'", "barbule_view is \"x\", but this version"),
            ("preset = 'starling'", "is no saved viewer, which begins with barbule_view = 1"),
            ("barbule_view = 1", "open is missing; give what is looked at"),
            ("barbule_view = 1\nopen = 3", "open is the number 3, but must be a text in quotes"),
            ("barbule_view = 1\nopen = 'a'\nveiw = 1", "unknown key 'veiw', did you mean 'view'?"),
            (
                "barbule_view = 1\nopen = 'a'\n[sizes]\ncortex_um = 'x'",
                "sizes.cortex_um is the text 'x', but must be a number",
            ),
            (
                "barbule_view = 1\nopen = 'a'\nsizes = 3",
                "sizes is the number 3, but must be a table of numbers",
            ),
            ("barbule_view = 1\nopen = 'a'\n[view]\nmode = 'x'", "view.mode is 'x'"),
            (
                "barbule_view = 1\nopen = 'a'\n[view.light]\nradius_deg = 0",
                "view.light.radius_deg is 0, outside 0.1 to 60",
            ),
            ("barbule_view = 1\nopen = 'a'\n[pinned]\nsizes = {}", "pinned.open is missing"),
            ("barbule_view = = 1", "line 1"),
        ] {
            let refused = Saved::parse(text).unwrap_err();
            let sentence = refused.to_string();
            assert!(refused.is_input() && sentence.contains(words), "{text}: {sentence}");
            assert!(!sentence.contains('\n') && sentence.len() < 600);
        }
    }

    #[test]
    fn files_are_named_by_their_whole_paths_and_nothing_else_is() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("mine.toml");
        std::fs::write(&file, "").unwrap();
        let file = file.to_string_lossy().into_owned();
        for text in ["starling", "starling:pink (below)", "air/keratin:300/air", "nowhere.toml"] {
            assert_eq!(named_from_anywhere(text), text);
        }
        for end in ["", " (below)", ":pink", ":pink (below)"] {
            let text = format!("{file}{end}");
            assert_eq!(named_from_anywhere(&text), text);
        }
        let relative = named_from_anywhere("Cargo.toml");
        assert!(Path::new(&relative).is_absolute() && relative.ends_with("Cargo.toml"), "{relative}");
    }
}
