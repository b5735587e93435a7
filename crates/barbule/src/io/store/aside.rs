//! Writing a store's files aside and renaming them, so that any number of processes may write one store.
//!
//! Names of temporary files are unique, and lie in one folder of the store. Each is locked by its writer for as long as
//! it is written, and a lock ends with its process: a temporary that can be locked belongs to nobody and is swept. Where
//! the file system knows no locks, age decides.

use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::io::whole::shared_temporaries;
use crate::{Error, Result};

/// The folder of a store in which its files are written before they get their names; it is gone while nobody writes.
const FOLDER: &str = ".aside";

/// Age from which on a temporary is taken for abandoned where locks are not to be had.
const ABANDONED: Duration = Duration::from_secs(600);

/// A write whose temporary was swept in the instant between its making and its lock is tried again so often.
const ATTEMPTS: usize = 20;

/// The files of a store; their keys are relative paths with `/`.
#[derive(Debug)]
pub(super) struct Files {
    folder: PathBuf,
    aside: PathBuf,
}

impl Files {
    /// The files in the folder `path`.
    pub(super) fn new(path: &Path) -> Self {
        Self { folder: path.to_owned(), aside: path.join(FOLDER) }
    }

    /// Whether there is a file of this key.
    pub(super) fn has(&self, key: &str) -> bool {
        self.folder.join(key).is_file()
    }

    /// Reads a file; `None` where there is none, it cannot be read, or has more than `most` bytes.
    pub(super) fn read(&self, key: &str, most: usize) -> Option<Vec<u8>> {
        let path = self.folder.join(key);
        let metadata = fs::metadata(&path).ok().filter(fs::Metadata::is_file)?;
        let length = usize::try_from(metadata.len()).ok().filter(|length| *length <= most)?;
        let mut bytes = Vec::with_capacity(length);
        File::open(path).ok()?.take(most as u64 + 1).read_to_end(&mut bytes).ok()?;
        (bytes.len() <= most).then_some(bytes)
    }

    /// Writes a file aside, then renames it over what is there.
    pub(super) fn write(&self, key: &str, bytes: &[u8]) -> io::Result<()> {
        let path = self.folder.join(key);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        // What describes the store is synced. Chunks are not (7 ms each on a common disk): one that a power failure
        // damages is found by its checksum and computed again.
        let synced = key.ends_with("zarr.json");
        again(|| {
            let mut file = self.temporary()?;
            file.write_all(bytes)?;
            if synced {
                file.as_file().sync_all()?;
            }
            file.persist(&path).map(|_| ()).map_err(|e| e.error)
        })
    }

    fn temporary(&self) -> io::Result<tempfile::NamedTempFile> {
        fs::create_dir_all(&self.aside)?;
        let file = shared_temporaries(false).prefix("new-").tempfile_in(&self.aside)?;
        // Without locks age protects it.
        let _ = file.as_file().try_lock();
        Ok(file)
    }

    /// Tries whether files can be written.
    pub(super) fn probe(&self) -> io::Result<()> {
        again(|| self.temporary().and_then(|mut file| file.write_all(b"probe")))
    }

    /// Deletes what writers left that are no more; says how many files.
    pub(super) fn sweep(&self) -> usize {
        let Ok(entries) = fs::read_dir(&self.aside) else { return 0 };
        entries.flatten().filter(|e| is_abandoned(&e.path()) && fs::remove_file(e.path()).is_ok()).count()
    }

    /// Removes the folder of temporaries if nobody uses it.
    pub(super) fn tidy(&self) {
        // It is in use where it cannot be removed.
        let _ = fs::remove_dir(&self.aside);
    }
}

/// Repeats what fails because its temporary was swept.
fn again<T>(mut act: impl FnMut() -> io::Result<T>) -> io::Result<T> {
    let mut last = act();
    for _ in 1..ATTEMPTS {
        match &last {
            Err(error) if error.kind() == ErrorKind::NotFound => last = act(),
            _ => break,
        }
    }
    last
}

/// Whether the writer of a temporary file or folder is gone.
fn is_abandoned(path: &Path) -> bool {
    let opened =
        if path.is_dir() { File::open(path) } else { File::options().read(true).write(true).open(path) };
    match opened.map(|file| file.try_lock()) {
        Ok(Ok(())) => true,
        Ok(Err(TryLockError::WouldBlock)) => false,
        Ok(Err(TryLockError::Error(_))) | Err(_) => fs::metadata(path)
            .and_then(|m| m.modified())
            .is_ok_and(|at| at.elapsed().is_ok_and(|age| age > ABANDONED)),
    }
}

/// Builds a folder under another name beside `path` and renames it into place. Where another process was faster, its
/// folder stays and this one is dropped.
///
/// # Errors
/// `build` fails, or the folder cannot be made or renamed.
pub(super) fn create_folder(path: &Path, build: impl Fn(&Path) -> Result<()>) -> Result<()> {
    let refuse = |e: io::Error| failure(path, "the store cannot be created", &e);
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let prefix = format!(".{name}.new-");
    if let Ok(entries) = fs::read_dir(parent) {
        for entry in entries.flatten() {
            if entry.file_name().to_string_lossy().starts_with(&prefix) && is_abandoned(&entry.path()) {
                // Another process may sweep it too.
                let _ = fs::remove_dir_all(entry.path());
            }
        }
    }
    for attempt in 1.. {
        let folder = shared_temporaries(true).prefix(&prefix).tempdir_in(parent).map_err(refuse)?;
        let lock = File::open(folder.path());
        let _locked = lock.as_ref().map(File::try_lock);
        let done = build(folder.path()).and_then(|()| fs::rename(folder.path(), path).map_err(refuse));
        let swept = !folder.path().exists();
        match done {
            Ok(()) => {
                // It has another name now: nothing is left to delete.
                let _ = folder.keep();
                return Ok(());
            }
            Err(_) if path.join("zarr.json").is_file() => return Ok(()),
            Err(_) if swept && attempt < ATTEMPTS => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// An error of the file system: the machine's when the disk is full, else the user's.
pub(super) fn failure(path: &Path, what: &str, error: &io::Error) -> Error {
    match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            Error::machine(format!(
                "{}: {what} ({error}); free some space and run the same command again: what is done stays",
                path.display()
            ))
        }
        _ => Error::input(format!("{}: {what} ({error})", path.display())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_nobody_writes_is_swept() {
        let folder = tempfile::tempdir().unwrap();
        let files = Files::new(folder.path());
        let busy = files.temporary().unwrap();
        fs::write(folder.path().join(FOLDER).join("new-dead"), b"half").unwrap();
        assert_eq!(files.sweep(), 1);
        assert!(busy.path().exists());
        files.tidy();
        assert!(busy.path().exists());
        drop(busy);
        files.tidy();
        assert!(!folder.path().join(FOLDER).exists());
    }

    #[test]
    fn a_file_survives_sweepers_at_work() {
        let folder = tempfile::tempdir().unwrap();
        let files = Files::new(folder.path());
        std::thread::scope(|scope| {
            for _ in 0..2 {
                scope.spawn(|| (0..200).for_each(|_| _ = files.sweep()));
                scope.spawn(|| (0..100).for_each(|_| files.write("a/b", b"whole").unwrap()));
            }
        });
        assert_eq!(fs::read(folder.path().join("a/b")).unwrap(), b"whole");
    }

    #[test]
    fn of_many_creators_one_wins_and_all_find_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.zarr");
        fs::create_dir(folder.path().join(".s.zarr.new-dead")).unwrap();
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    let build = |made: &Path| {
                        fs::write(made.join("zarr.json"), b"{}").map_err(|e| failure(made, "test", &e))
                    };
                    create_folder(&path, build).unwrap();
                    assert!(path.join("zarr.json").is_file());
                });
            }
        });
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
