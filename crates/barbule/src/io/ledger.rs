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
    /// Ledgers that are open: commands that run at once in one process share one.
    open: usize,
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

/// Keeps, while it lives, every file that is read from being overwritten.
#[derive(Debug)]
#[must_use = "inputs are safe for as long as it lives"]
pub struct Ledger(());

impl Ledger {
    /// Begins to note what is read.
    pub fn open() -> Self {
        state().get_or_insert_default().open += 1;
        Self(())
    }
}

impl Drop for Ledger {
    fn drop(&mut self) {
        let mut state = state();
        if let Some(open) = state.as_mut() {
            open.open -= 1;
            if open.open == 0 {
                *state = None;
            }
        }
    }
}

/// Notes that a file is read, or every section of a folder, before it is opened. What is neither, or not there, is not
/// noted.
///
/// # Errors
/// It is an output too, or it names one, by whatever spelling, link or second name.
pub fn note_input(path: &Path) -> Result<()> {
    let mut state = state();
    let Some(state) = state.as_mut() else { return Ok(()) };
    if !path.is_dir() {
        state.note(path);
        return state.check();
    }
    state.folders.push(path.to_owned());
    files_in(path, SECTIONS).iter().for_each(|file| state.note(file));
    state.check()
}

/// Says that a file will be written, and how messages call it (`-o f.svg`), so that it is refused before any work.
///
/// # Errors
/// It is an input too, or would become one of a folder of sections.
pub fn claim_output(path: &Path, name: &str) -> Result<()> {
    let mut state = state();
    let Some(state) = state.as_mut() else { return Ok(()) };
    let claim = Claim { path: path.to_owned(), name: name.to_owned(), before: id(path) };
    state.check_claim(&claim)?;
    state.claims.push(claim);
    Ok(())
}

/// Asks whether a file may be written now.
///
/// # Errors
/// As [`claim_output`].
pub(super) fn begin_output(path: &Path) -> Result<()> {
    let mut state = state();
    let Some(state) = state.as_mut() else { return Ok(()) };
    let claim = Claim { path: path.to_owned(), name: path.display().to_string(), before: id(path) };
    state.check_claim(&claim)?;
    // What takes its place is the program's, which may read it again.
    state.claims.retain(|other| other.before.is_none() || other.before != claim.before);
    Ok(())
}

/// Which file a path leads to; none where there is none, or no regular file.
fn id(path: &Path) -> Option<FileId> {
    let metadata = fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
    file_id(path, &metadata)
}

impl State {
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

    fn check(&mut self) -> Result<()> {
        let claims = std::mem::take(&mut self.claims);
        let checked = claims.iter().try_for_each(|claim| self.check_claim(claim));
        self.claims = claims;
        checked
    }

    fn check_claim(&mut self, Claim { path, name, before }: &Claim) -> Result<()> {
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
    use crate::io::{check_writable, read_own, read_text, write_whole};

    #[test]
    fn whichever_of_reading_and_writing_comes_second_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for (name, text) in [
            ("a.toml", "curves = 'b.gltf'"),
            ("b.gltf", r#"{"buffers": [{"uri": "c%20d.bin"}]}"#),
            ("c d.bin", "x"),
            ("late.csv", "x"),
            ("own", "x"),
        ] {
            fs::write(path(name), text).unwrap();
        }
        let refusal = |result: Result<()>| result.unwrap_err().to_string();
        // Nobody asked for it.
        read_text(&path("late.csv")).unwrap();
        write_whole(&path("late.csv"), b"y").unwrap();
        let ledger = Ledger::open();
        read_text(&path("a.toml")).unwrap();
        for name in ["a.toml", "b.gltf", "c d.bin"] {
            let before = fs::read(path(name)).unwrap();
            for result in [write_whole(&path(name), b"lost"), check_writable(&path(name))] {
                let message = refusal(result);
                assert!(
                    message.contains("would be overwritten, but this command reads it (as "),
                    "{message}"
                );
            }
            assert_eq!(fs::read(path(name)).unwrap(), before);
        }
        // The other way round; and once it is written it is the program's.
        check_writable(&path("late.csv")).unwrap();
        assert!(refusal(read_text(&path("late.csv")).map(drop)).contains("late.csv: would be overwritten"));
        check_writable(&path("new.csv")).unwrap();
        for _ in 0..2 {
            write_whole(&path("new.csv"), b"mine").unwrap();
            read_own(&path("new.csv"), 100).unwrap();
        }
        read_own(&path("own"), 100).unwrap();
        write_whole(&path("own"), b"again").unwrap();
        drop(ledger);
        write_whole(&path("a.toml"), b"mine").unwrap();
    }

    #[test]
    fn nothing_joins_a_folder_of_sections_that_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let new = folder.path().join("new.json");
        let _ledger = Ledger::open();
        note_input(folder.path()).unwrap();
        let message = check_writable(&new).unwrap_err().to_string();
        assert!(message.contains("would become one of the sections in"), "{message}");
        assert!(write_whole(&new, b"{}").is_err() && !new.exists());
        write_whole(&folder.path().join("new.svg"), b"").unwrap();
    }
}
