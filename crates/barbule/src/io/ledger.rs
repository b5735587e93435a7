//! What a program reads and what it will write: no output takes the place of an input.
//!
//! While a [`Ledger`] is open, whatever in this module opens a user's file notes it here, and whatever writes one asks
//! here before it begins; whichever comes second is refused. So no command can leave it out. To read a file is also
//! to read every file that its texts name, opened or not: a scene would be lost with its textures. Where no ledger is
//! open, as in programs that call the library, a file that was read may be replaced.
//!
//! Files of the program's own, which it replaces where they are damaged, are read by [`super::read_own`] and not noted:
//! caches and checkpoints. The arrays of a campaign store are written by the store alone.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::named::{files_in, files_named_in};
use super::output::{FileId, file_id, is_same_file};
use super::whole::folder_of;
use crate::{Error, Result};

/// The ending of the files that a folder of sections consists of.
const SECTIONS: &str = "json";

/// What is read and written between [`Ledger::open`] and the last drop.
#[derive(Default)]
struct State {
    /// Files that are read, with the names under which they are.
    read: HashMap<FileId, PathBuf>,
    /// Those of them whose texts are not searched for names yet.
    unsearched: Vec<PathBuf>,
    /// Folders of which every section is read.
    folders: Vec<PathBuf>,
    /// Outputs to come.
    claims: Vec<Claim>,
}

/// An output to come.
struct Claim {
    path: PathBuf,
    /// As messages call it.
    name: String,
    /// What stands in its place and would be lost.
    before: Option<FileId>,
}

static STATE: Mutex<Option<State>> = Mutex::new(None);

/// What is open: nothing is refused that is asked for without one.
fn state() -> MutexGuard<'static, Option<State>> {
    // Whatever panicked in between left whole entries.
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Held by the ledger that is open: what one command writes is no concern of another's.
static ONE: Mutex<()> = Mutex::new(());

/// Keeps, while it lives, every file that is read from being overwritten. There is one at a time in a process: a second
/// command waits until the first is done.
#[derive(Debug)]
#[must_use = "inputs are safe for as long as it lives"]
pub struct Ledger {
    _one: MutexGuard<'static, ()>,
}

impl Ledger {
    /// Begins to note what is read, once no other ledger is open. (On a thread that holds one it would wait for itself.)
    pub fn open() -> Self {
        let one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
        *state() = Some(State::default());
        Self { _one: one }
    }
}

impl Drop for Ledger {
    fn drop(&mut self) {
        *state() = None;
    }
}

/// Notes that a file is read, or every section of a folder, before it is opened. What is neither, or not there, is not
/// noted.
///
/// # Errors
/// It is an output too, or it names one, by whatever spelling, link or second name.
pub fn note_input(path: &Path) -> Result<()> {
    state().as_mut().map_or(Ok(()), |state| state.note_input(path))
}

/// Says that a file will be written, and how messages call it (`-o f.svg`), so that it is refused before any work.
///
/// # Errors
/// It is an input too, or would become one of a folder of sections.
pub fn claim_output(path: &Path, name: &str) -> Result<()> {
    state().as_mut().map_or(Ok(()), |state| state.claim(path, name))
}

/// Asks whether a file may be written now.
///
/// # Errors
/// As [`claim_output`].
pub(super) fn begin_output(path: &Path) -> Result<()> {
    state().as_mut().map_or(Ok(()), |state| state.begin(path))
}

/// Which file a path leads to; none where there is none, or no regular file.
fn id(path: &Path) -> Option<FileId> {
    let metadata = fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
    file_id(path, &metadata)
}

impl State {
    fn note_input(&mut self, path: &Path) -> Result<()> {
        if path.is_dir() {
            self.folders.push(path.to_owned());
            files_in(path, SECTIONS).iter().for_each(|file| self.note(file));
        } else {
            self.note(path);
        }
        let claims = std::mem::take(&mut self.claims);
        let checked = claims.iter().try_for_each(|claim| self.check(claim));
        self.claims = claims;
        checked
    }

    fn claim(&mut self, path: &Path, name: &str) -> Result<()> {
        let claim = Claim { path: path.to_owned(), name: name.to_owned(), before: id(path) };
        self.check(&claim)?;
        self.claims.push(claim);
        Ok(())
    }

    fn begin(&mut self, path: &Path) -> Result<()> {
        let claim = Claim { path: path.to_owned(), name: path.display().to_string(), before: id(path) };
        self.check(&claim)?;
        // What takes its place is the program's, which may read it again.
        self.claims.retain(|other| other.before.is_none() || other.before != claim.before);
        Ok(())
    }

    fn note(&mut self, path: &Path) {
        if let Some(id) = id(path)
            && !self.read.contains_key(&id)
        {
            self.read.insert(id, path.to_owned());
            self.unsearched.push(path.to_owned());
        }
    }

    /// Follows what is read to what it names, and that to what it names.
    fn search(&mut self) {
        while let Some(path) = self.unsearched.pop() {
            files_named_in(&path).iter().for_each(|named| self.note(named));
        }
    }

    /// Refuses an output that is an input, or would become one.
    fn check(&mut self, Claim { path, name, before }: &Claim) -> Result<()> {
        let is_section = path.extension().is_some_and(|e| e.eq_ignore_ascii_case(SECTIONS));
        let joined = self.folders.iter().find(|folder| is_section && is_same_file(folder, folder_of(path)));
        if let Some(folder) = joined {
            return Err(Error::input(format!(
                "{name}: would become one of the sections in {}, which this command reads; give a name elsewhere",
                folder.display()
            )));
        }
        // What is not there yet cannot be lost.
        let Some(before) = before else { return Ok(()) };
        self.search();
        match self.read.get(before) {
            None => Ok(()),
            Some(input) => Err(Error::input(format!(
                "{name}: would be overwritten, but this command reads it (as {}); give another name",
                input.display()
            ))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In a folder: what names what, and a file that nobody names.
    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [
            ("a.toml", "curves = 'b.gltf'"),
            ("b.gltf", r#"{"buffers": [{"uri": "c%20d.bin"}]}"#),
            ("c d.bin", "x"),
            ("late.csv", "x"),
        ] {
            fs::write(folder.path().join(name), text).unwrap();
        }
        folder
    }

    // Not by way of the one that all tests of this process share.
    #[test]
    fn whichever_of_reading_and_writing_comes_second_is_refused() {
        let folder = folder();
        let path = |name: &str| folder.path().join(name);
        let mut state = State::default();
        let refusal = |result: Result<()>| result.unwrap_err().to_string();
        state.note_input(&path("a.toml")).unwrap();
        for name in ["a.toml", "b.gltf", "c d.bin"] {
            for result in [state.begin(&path(name)), state.claim(&path(name), "-o it")] {
                let message = refusal(result);
                assert!(
                    message.contains("would be overwritten, but this command reads it (as "),
                    "{message}"
                );
            }
        }
        state.claim(&path("late.csv"), "-o late.csv").unwrap();
        let message = refusal(state.note_input(&path("late.csv")));
        assert!(message.starts_with("-o late.csv: would be overwritten"), "{message}");
        // It was read all the same.
        assert!(state.begin(&path("late.csv")).is_err());
    }

    #[test]
    fn what_the_program_wrote_it_may_read_and_write_again() {
        let folder = folder();
        let (old, new) = (folder.path().join("late.csv"), folder.path().join("new.csv"));
        let mut state = State::default();
        for path in [&old, &new] {
            state.claim(path, "-o F").unwrap();
            state.begin(path).unwrap();
            // As outputs appear: under another name, then in its place.
            let aside = folder.path().join("aside");
            fs::write(&aside, "mine").unwrap();
            fs::rename(&aside, path).unwrap();
            state.begin(path).unwrap();
            state.note_input(path).unwrap();
        }
    }

    #[test]
    fn nothing_joins_a_folder_of_sections_that_is_read() {
        let folder = folder();
        let mut state = State::default();
        state.note_input(folder.path()).unwrap();
        let message = state.claim(&folder.path().join("new.json"), "-o new.json").unwrap_err().to_string();
        assert!(message.contains("new.json: would become one of the sections in"), "{message}");
        state.claim(&folder.path().join("new.svg"), "-o new.svg").unwrap();
    }
}
