//! Temporary files and folders that become results by a rename, and what is done about those of killed writers.
//!
//! Each is locked by its writer for as long as it is written, and a lock ends with its process: a temporary that can be
//! locked belongs to nobody and is swept. Where the file system knows no locks, age decides.

use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::Path;
use std::time::Duration;

/// Age from which on a temporary is taken for abandoned where locks are not to be had.
const ABANDONED: Duration = Duration::from_secs(600);

/// A write whose temporary was swept in the instant between its making and its lock is tried again so often.
pub(super) const ATTEMPTS: usize = 20;

/// Makes temporary files, or folders, with the permissions of any new one: they become results.
pub(super) fn shared(folders: bool) -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        // The system takes the user's mask off.
        builder.permissions(fs::Permissions::from_mode(if folders { 0o777 } else { 0o666 }));
    }
    #[cfg(not(unix))]
    let _ = folders;
    builder
}

/// Repeats what fails because its temporary was swept.
pub(super) fn again<T>(mut act: impl FnMut() -> io::Result<T>) -> io::Result<T> {
    let mut last = act();
    for _ in 1..ATTEMPTS {
        match &last {
            Err(error) if error.kind() == ErrorKind::NotFound => last = act(),
            _ => break,
        }
    }
    last
}

/// Deletes the temporaries of writers that are no more: entries of a folder whose name `is_ours`. Says how many.
pub(super) fn sweep(folder: &Path, is_ours: impl Fn(&str) -> bool) -> usize {
    let Ok(entries) = fs::read_dir(folder) else { return 0 };
    let swept = |path: &Path| {
        // Whoever just made it finds it locked until it is gone.
        let Some(_held) = abandoned(path) else { return false };
        if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) }.is_ok()
    };
    entries.flatten().filter(|e| e.file_name().to_str().is_some_and(&is_ours) && swept(&e.path())).count()
}

/// A temporary file or folder whose writer is gone, locked if it can be; `None` if somebody writes it.
pub(super) fn abandoned(path: &Path) -> Option<io::Result<File>> {
    let metadata = fs::symlink_metadata(path).ok()?;
    let opened = if metadata.is_dir() {
        File::open(path)
    } else if metadata.is_file() {
        // Locks across a network may ask for a file that can be written; of others' files, and where nothing can be, those that are read do.
        File::options().read(true).write(true).open(path).or_else(|_| File::open(path))
    } else {
        return None;
    };
    let is_old = || metadata.modified().is_ok_and(|at| at.elapsed().is_ok_and(|age| age > ABANDONED));
    match opened.as_ref().map(File::try_lock) {
        Ok(Ok(())) => Some(opened),
        Ok(Err(TryLockError::WouldBlock)) => None,
        Ok(Err(TryLockError::Error(_))) | Err(_) => is_old().then_some(opened),
    }
}
