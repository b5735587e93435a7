//! What can be written of what is seen, and to which kinds of files.

use std::path::Path;

use barbule::error::shortened;
use barbule::{Error, Result};

use super::command::Figure;
use super::subject::{Subject, What};

/// What can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Export {
    /// What the window shows, in its own pixels.
    Picture,
    /// The numbers of the curves that are shown.
    Table,
    /// The curves, drawn.
    Figure,
    /// The scene, for `barbule render`.
    Scene,
    /// The species with what was moved in it.
    Species,
    /// The viewer as it is.
    State,
}

impl Export {
    /// Everything that can be written.
    pub const ALL: [Self; 6] =
        [Self::Picture, Self::Table, Self::Figure, Self::Scene, Self::Species, Self::State];

    /// What it is called, in the plural.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Picture => "pictures",
            Self::Table => "tables",
            Self::Figure => "figures",
            Self::Scene => "scenes",
            Self::Species => "species",
            Self::State => "saved viewers",
        }
    }

    /// The endings of its files, the usual one first.
    #[must_use]
    pub fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Picture => &["png"],
            Self::Table => &["csv"],
            Self::Figure => &["svg", "pdf", "png"],
            Self::Scene | Self::Species | Self::State => &["toml"],
        }
    }

    /// What can be written of something.
    #[must_use]
    pub fn of(subject: &Subject) -> Vec<Self> {
        let has = |export: &Self| match export {
            Self::Picture | Self::Scene | Self::State => true,
            Self::Table | Self::Figure => Figure::of(subject).contains(&Figure::Spectrum),
            Self::Species => matches!(subject.what(), What::Species(_) | What::Material(_, Some(_))),
        };
        Self::ALL.into_iter().filter(has).collect()
    }

    /// A name for its file, of what it is of.
    #[must_use]
    pub fn file_name(self, subject: &Subject) -> String {
        let title = subject.title();
        let plain: String = title.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
        let words: Vec<&str> = plain.split('-').filter(|word| !word.is_empty()).collect();
        let stem: String = words.join("-").chars().take(60).collect();
        let kind = match self {
            Self::Picture => "",
            Self::Table | Self::Figure => "-spectrum",
            Self::Scene => "-scene",
            Self::Species => "-species",
            Self::State => "-view",
        };
        format!("{}{kind}.{}", stem.trim_end_matches('-'), self.endings()[0])
    }

    /// Refuses a file whose ending says something else.
    ///
    /// # Errors
    /// It does.
    pub fn check(self, path: &Path) -> Result<()> {
        let end = path.extension().map(|end| end.to_string_lossy().to_lowercase());
        if end.as_deref().is_some_and(|end| self.endings().contains(&end)) {
            return Ok(());
        }
        let endings: Vec<String> = self.endings().iter().map(|end| format!(".{end}")).collect();
        Err(Error::input(format!(
            "{}: {} are written as {}; name it {}",
            shortened(&path.display().to_string()),
            self.name(),
            endings.join(", "),
            shortened(&path.with_extension(self.endings()[0]).display().to_string())
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::Unobserved;
    use barbule::open::Opening;

    fn opened(text: &str) -> Subject {
        Subject::open(text, &Opening::default(), &Unobserved).unwrap()
    }

    #[test]
    fn what_can_be_written_depends_on_what_is_open() {
        assert_eq!(Export::of(&opened("starling")), Export::ALL);
        assert_eq!(Export::of(&opened("snake")), [Export::Picture, Export::Scene, Export::State]);
        assert!(!Export::of(&opened("air/keratin:300/air")).contains(&Export::Species));
    }

    #[test]
    fn names_of_files_follow_from_what_is_open() {
        assert_eq!(Export::Picture.file_name(&opened("starling:pink")), "starling-pink.png");
        assert_eq!(
            Export::Table.file_name(&opened("air/keratin:300/air")),
            "air-keratin-300-air-spectrum.csv"
        );
        assert_eq!(Export::State.file_name(&opened("rock-dove (below)")), "rock-dove-forest-below-view.toml");
    }

    #[test]
    fn other_endings_are_refused_with_the_right_one() {
        assert!(Export::Figure.check(Path::new("a.PDF")).is_ok());
        assert_eq!(
            Export::Picture.check(Path::new("a/b.gif")).unwrap_err().to_string(),
            "a/b.gif: pictures are written as .png; name it a/b.png"
        );
        assert!(
            Export::Figure
                .check(Path::new("a"))
                .unwrap_err()
                .to_string()
                .contains(".svg, .pdf, .png; name it a.svg")
        );
    }
}
