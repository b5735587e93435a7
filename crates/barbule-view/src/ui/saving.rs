//! The viewer's state between two windows: kept in a file of the program's own when a window closes, and read when one opens.

use std::path::{Path, PathBuf};
use std::sync::PoisonError;

use barbule::error::shortened;
use barbule::io::{make_folder, read_own, write_whole};
use barbule::open::Opening;
use barbule::progress::Progress;

use super::Farewell;
use crate::state::{Saved, State};
use crate::{Error, Result};

/// The largest file of a state, bytes.
const LARGEST: u64 = 1 << 20;
/// The file's name.
const FILE: &str = "view.toml";

/// Where the state is kept.
#[derive(Debug, Clone)]
pub struct Saving {
    /// The file.
    pub file: PathBuf,
    /// Where an error of the last moment is left.
    pub farewell: Farewell,
}

impl Saving {
    /// Keeps a state; what goes wrong is left behind.
    pub(super) fn write(&self, state: &State) {
        if let Err(error) = self.written(state) {
            *self.farewell.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
        }
    }

    fn written(&self, state: &State) -> Result<()> {
        let text = state.saved().to_toml()?;
        if let Some(folder) = self.file.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            make_folder(folder)?;
        }
        write_whole(&self.file, text.as_bytes())
    }
}

/// The state that was kept in a file; none where there is no such file.
///
/// # Errors
/// The file is damaged, or what it names is no longer there.
pub fn restored(file: &Path, opening: &Opening, progress: &dyn Progress) -> Result<Option<State>> {
    if !file.exists() {
        return Ok(None);
    }
    let read = || {
        let bytes = read_own(file, LARGEST)?;
        let text = String::from_utf8(bytes).map_err(|_| Error::input("is no text").in_file(file))?;
        let state = Saved::parse(&text).and_then(|saved| State::restored(&saved, opening, progress));
        state.map_err(|error| error.in_file(file))
    };
    read().map(Some)
}

/// Where the state is kept if nobody says otherwise: in `$XDG_STATE_HOME/barbule`, `%LOCALAPPDATA%\barbule` or
/// `~/.local/state/barbule`; `variable` reads the environment.
#[must_use]
pub fn usual_file(variable: impl Fn(&str) -> Option<PathBuf>) -> Option<PathBuf> {
    let folders = [("XDG_STATE_HOME", ""), ("LOCALAPPDATA", ""), ("HOME", ".local/state")];
    usual_folder(&folders, variable).map(|folder| folder.join(FILE))
}

/// The folder `barbule` below the first of these variables that is set and an absolute path, and what stands behind its name.
#[must_use]
pub fn usual_folder(places: &[(&str, &str)], variable: impl Fn(&str) -> Option<PathBuf>) -> Option<PathBuf> {
    places.iter().find_map(|(name, below)| {
        let base = variable(name).filter(|path| path.is_absolute())?;
        Some(base.join(below).join("barbule"))
    })
}

/// What is said where a state that was kept cannot be used.
#[must_use]
pub fn lost(error: &Error) -> String {
    format!("the viewer's last state cannot be used, so it begins anew: {}", shortened_sentence(error))
}

fn shortened_sentence(error: &Error) -> String {
    let sentence = error.to_string();
    if sentence.chars().count() > 300 { shortened(&sentence) } else { sentence }
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::Unobserved;

    #[test]
    fn a_state_is_kept_and_read_again_and_a_damaged_one_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("new/view.toml");
        let opening = Opening::default();
        assert!(restored(&file, &opening, &Unobserved).unwrap().is_none());
        let mut state = State::open("air/keratin:300/air", &opening, &Unobserved).unwrap();
        state.move_size("thickness_nm[0]", 250.0).unwrap();
        let saving = Saving { file: file.clone(), farewell: Farewell::default() };
        saving.write(&state);
        assert!(saving.farewell.lock().unwrap().is_none());
        assert_eq!(restored(&file, &opening, &Unobserved).unwrap().unwrap().saved(), state.saved());
        for damaged in ["barbule_view = 1\nopen = 'starlign'", "\u{0}", "barbule_view = 7"] {
            std::fs::write(&file, damaged).unwrap();
            let error = restored(&file, &opening, &Unobserved).unwrap_err();
            assert!(!lost(&error).contains('\n') && error.to_string().contains("view.toml"), "{error}");
        }
        let nowhere = Saving { file: folder.path().join("new/view.toml/x.toml"), ..saving };
        nowhere.write(&state);
        assert!(nowhere.farewell.lock().unwrap().is_some());
    }

    #[test]
    fn the_usual_folder_is_an_absolute_path_of_the_environment() {
        let absolute = std::env::temp_dir();
        let variable = |name: &str| match name {
            "XDG_STATE_HOME" => Some(PathBuf::from("relative")),
            "HOME" => Some(absolute.clone()),
            _ => None,
        };
        assert_eq!(usual_file(variable), Some(absolute.join(".local/state/barbule/view.toml")));
        assert_eq!(usual_file(|_| None), None);
    }
}
