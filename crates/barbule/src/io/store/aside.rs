//! Writing a store's files aside and renaming them, so that any number of processes may write one store.
//!
//! Names of temporary files are unique, and lie in one folder of the store.

use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, SystemTime};

use super::running;
use crate::io::output::{behind_links, is_inside_store};
use crate::io::temporary::{ATTEMPTS, again, shared, sweep};
use crate::io::whole::{failure, folder_of};
use crate::{Error, Result};

/// The folder of a store in which its files are written before they get their names; it is gone while nobody writes.
const FOLDER: &str = ".aside";

/// What the names of a store's temporary files begin with.
const PREFIX: &str = "new-";

/// The files of a store; their keys are relative paths with `/`.
#[derive(Debug)]
pub(in crate::io) struct Files {
    folder: PathBuf,
    aside: PathBuf,
    /// What says that this process fills them, while it does.
    pub(super) own: Mutex<Option<running::Own>>,
}

impl Files {
    /// The files in the folder `path`.
    pub(in crate::io) fn new(path: &Path) -> Self {
        Self { folder: path.to_owned(), aside: path.join(FOLDER), own: Mutex::default() }
    }

    /// Whether there is a file of this key.
    pub(in crate::io) fn has(&self, key: &str) -> bool {
        self.folder.join(key).is_file()
    }

    /// Since when there is a file of this key; nothing where there is none, or its time lies ahead.
    pub(super) fn age(&self, key: &str, now: SystemTime) -> Duration {
        let modified = fs::metadata(self.folder.join(key)).and_then(|metadata| metadata.modified());
        modified.ok().and_then(|at| now.duration_since(at).ok()).unwrap_or_default()
    }

    /// The folder of temporaries.
    pub(super) fn aside(&self) -> &Path {
        &self.aside
    }

    /// Reads a file; `None` where there is none, it cannot be read, or has more than `most` bytes.
    pub(in crate::io) fn read(&self, key: &str, most: usize) -> Option<Vec<u8>> {
        let path = self.folder.join(key);
        let metadata = fs::metadata(&path).ok().filter(fs::Metadata::is_file)?;
        let length = usize::try_from(metadata.len()).ok().filter(|length| *length <= most)?;
        let mut bytes = Vec::with_capacity(length);
        File::open(path).ok()?.take(most as u64 + 1).read_to_end(&mut bytes).ok()?;
        (bytes.len() <= most).then_some(bytes)
    }

    /// Writes a file aside, then renames it over what is there.
    pub(in crate::io) fn write(&self, key: &str, bytes: &[u8]) -> io::Result<()> {
        self.show_life();
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
        let file = shared(false).prefix(PREFIX).tempfile_in(&self.aside)?;
        // Without locks age protects it.
        let _ = file.as_file().try_lock();
        Ok(file)
    }

    /// Tries whether files can be written; nothing stays of it.
    pub(in crate::io) fn probe(&self) -> io::Result<()> {
        let tried = again(|| self.temporary().and_then(|mut file| file.write_all(b"probe")));
        self.tidy();
        tried
    }

    /// Deletes what writers left that are no more; says how many files.
    pub(in crate::io) fn sweep(&self) -> usize {
        sweep(&self.aside, |name| name.starts_with(PREFIX) || name.starts_with(running::PREFIX))
    }

    /// Removes the folder of temporaries if nobody uses it.
    pub(in crate::io) fn tidy(&self) {
        // It is in use where it cannot be removed.
        let _ = fs::remove_dir(&self.aside);
    }
}

/// What the names of folders begin with in which the store `path` is built.
fn prefix_beside(path: &Path) -> String {
    format!(".{}.new-", path.file_name().unwrap_or_default().to_string_lossy())
}

/// Deletes what killed processes left beside the store `path` when they built it.
pub(in crate::io) fn sweep_beside(path: &Path) {
    let prefix = prefix_beside(path);
    sweep(folder_of(path), |name| name.starts_with(&prefix));
}

/// Builds a store where nothing or an empty folder is; where something else is, it stays. Its place, behind links; `others` is what it
/// may not lie in, in words. `build` is given the place and the folder to build in.
///
/// # Errors
/// The path has no name, lies in another store or in a folder that does not exist, or as [`create_folder`].
pub(in crate::io) fn create_store(
    given: &Path,
    others: &str,
    build: impl Fn(&Path, &Path) -> Result<()>,
) -> Result<PathBuf> {
    let refuse = |what: &str| Err(Error::input(what).in_file(given));
    let path = behind_links(given)?;
    if path.file_name().is_none() {
        return refuse("a store needs a name of its own; give one, as in S.zarr");
    }
    if is_inside_store(&path) {
        return refuse(&format!("lies inside {others}; give a name elsewhere"));
    }
    sweep_beside(&path);
    let is_empty = fs::read_dir(&path).is_ok_and(|mut entries| entries.next().is_none());
    if !path.exists() || is_empty {
        let folder = folder_of(&path);
        if !folder.is_dir() {
            let what =
                format!("the store cannot be created (the folder {} does not exist)", folder.display());
            return refuse(&what);
        }
        // Processes that create one store at the same instant each build their own; the first rename wins.
        create_folder(&path, |made| build(&path, made))?;
    }
    Ok(path)
}

/// Builds a folder under another name beside `path` and renames it into place. Where another process was faster, its
/// folder stays and this one is dropped.
///
/// # Errors
/// `build` fails, or the folder cannot be made or renamed.
pub(in crate::io) fn create_folder(path: &Path, build: impl Fn(&Path) -> Result<()>) -> Result<()> {
    let refuse = |e: io::Error| match e.kind() {
        ErrorKind::ResourceBusy => Error::input(format!(
            "{}: is a mount point or in use, and a store cannot take its place; name a folder inside it",
            path.display()
        )),
        _ => failure(path, "the store cannot be created", &e),
    };
    let parent = folder_of(path);
    let prefix = prefix_beside(path);
    for attempt in 1.. {
        let folder = shared(true).prefix(&prefix).tempdir_in(parent).map_err(refuse)?;
        let lock = File::open(folder.path());
        let is_taken = matches!(lock.as_ref().map(File::try_lock), Ok(Err(TryLockError::WouldBlock)));
        if (is_taken || !folder.path().exists()) && attempt < ATTEMPTS {
            // A sweeper was faster: what is built there would go with it.
            continue;
        }
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
    fn a_new_store_survives_sweepers_at_work() {
        let folder = tempfile::tempdir().unwrap();
        let is_done = std::sync::atomic::AtomicBool::new(false);
        let path = |k: usize| folder.path().join(format!("{k}.zarr"));
        let build = |made: &Path| {
            let files = Files::new(made);
            for key in ["a/zarr.json", "b/zarr.json", "zarr.json"] {
                files.write(key, b"{}").map_err(|e| failure(made, "test", &e))?;
            }
            files.tidy();
            Ok(())
        };
        std::thread::scope(|scope| {
            for _ in 0..2 {
                scope.spawn(|| {
                    while !is_done.load(std::sync::atomic::Ordering::Relaxed) {
                        (0..60).for_each(|k| sweep_beside(&path(k)));
                    }
                });
            }
            (0..60).for_each(|k| create_folder(&path(k), build).unwrap());
            is_done.store(true, std::sync::atomic::Ordering::Relaxed);
        });
        for k in 0..60 {
            for key in ["a/zarr.json", "b/zarr.json", "zarr.json"] {
                assert!(path(k).join(key).is_file(), "{k} {key}");
            }
        }
    }

    #[test]
    fn of_many_creators_one_wins_and_all_find_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.zarr");
        fs::create_dir_all(folder.path().join(".s.zarr.new-dead/u")).unwrap();
        sweep_beside(&path);
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
