//! Reading and writing files whole.

use std::fs;
use std::io::{Read as _, Write as _};
use std::path::Path;

use crate::{Error, Result};

/// The largest input file that is read: 64 MiB.
pub const LARGEST_INPUT: u64 = 64 << 20;

/// Reads a user's file of at most [`LARGEST_INPUT`] bytes.
///
/// # Errors
/// Missing, a folder, unreadable, or too large.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    read_at_most(path, LARGEST_INPUT)
}

/// Reads a file of at most `largest` bytes, for formats with a limit of their own.
///
/// # Errors
/// As [`read_bytes`].
pub fn read_at_most(path: &Path, largest: u64) -> Result<Vec<u8>> {
    let refuse = |what: &str| Error::input(format!("{}: {what}", path.display()));
    let metadata = fs::metadata(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => refuse("no such file"),
        _ => refuse(&format!("cannot be read ({error})")),
    })?;
    if metadata.is_dir() {
        return Err(refuse("is a folder, but a file is needed"));
    }
    let limit = format!("over the limit of {} MiB", largest.div_ceil(1 << 20));
    if metadata.len() > largest {
        return Err(refuse(&format!("has {} bytes, {limit}", metadata.len())));
    }
    let mut bytes = Vec::new();
    fs::File::open(path)
        .and_then(|file| file.take(largest + 1).read_to_end(&mut bytes))
        .map_err(|error| refuse(&format!("cannot be read ({error})")))?;
    if bytes.len() as u64 > largest {
        return Err(refuse(&format!("is {limit}")));
    }
    Ok(bytes)
}

/// Reads a user's text file (UTF-8, a byte-order mark is dropped).
///
/// # Errors
/// As [`read_bytes`], or not UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    let text = String::from_utf8(read_bytes(path)?)
        .map_err(|_| Error::input(format!("{}: is not UTF-8 text", path.display())))?;
    Ok(text.strip_prefix('\u{feff}').map_or(text.clone(), str::to_owned))
}

/// Writes a file so that it appears whole or not at all: a temporary file in the same folder, synced, then renamed.
///
/// # Errors
/// The folder is missing or not writable, or the disk is full.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let refuse = |what: String| Error::input(format!("{}: {what}", path.display()));
    if path.is_dir() {
        return Err(refuse("is a folder; give a file name".into()));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(refuse(format!("the folder {} does not exist", folder.display())));
    }
    let mut file = shared_temporaries(false)
        .prefix(".barbule-")
        .tempfile_in(folder)
        .map_err(|e| refuse(format!("cannot be written ({e})")))?;
    let written = file.write_all(bytes).and_then(|()| file.as_file().sync_all());
    written.map_err(|e| Error::machine(format!("{}: cannot be written ({e})", path.display())))?;
    file.persist(path).map_err(|e| refuse(format!("cannot be written ({})", e.error)))?;
    Ok(())
}

/// Makes temporary files, or folders, with the permissions of any new one: they become results.
pub(super) fn shared_temporaries(folders: bool) -> tempfile::Builder<'static, 'static> {
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

/// Refuses early, before long work, a path that [`write_whole`] would refuse.
///
/// # Errors
/// The folder is missing, or the path is a folder or in a folder that is not writable.
pub fn check_writable(path: &Path) -> Result<()> {
    let refuse = |what: String| Error::input(format!("{}: {what}", path.display()));
    if path.is_dir() {
        return Err(refuse("is a folder; give a file name".into()));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(refuse(format!("the folder {} does not exist", folder.display())));
    }
    tempfile::Builder::new()
        .prefix(".barbule-")
        .tempfile_in(folder)
        .map(|_| ())
        .map_err(|e| refuse(format!("cannot be written ({e})")))
}

/// BLAKE3 of bytes, in hexadecimal.
#[must_use]
pub fn hash_bytes(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

/// BLAKE3 of a file's bytes, in hexadecimal.
///
/// # Errors
/// As [`read_bytes`].
pub fn hash_file(path: &Path) -> Result<String> {
    Ok(hash_bytes(&read_bytes(path)?))
}

/// Makes a folder with those it lies in.
///
/// # Errors
/// It cannot be made.
pub fn make_folder(path: &Path) -> Result<()> {
    fs::create_dir_all(path).map_err(|e| Error::input(format!("{}: cannot be made ({e})", path.display())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_written_whole_and_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_whole(&path, b"one").unwrap();
        write_whole(&path, b"two").unwrap();
        assert_eq!(read_text(&path).unwrap(), "two");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn folders_and_missing_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        assert!(read_bytes(folder.path()).unwrap_err().to_string().contains("is a folder"));
        assert!(read_bytes(&folder.path().join("x")).unwrap_err().to_string().contains("no such file"));
        assert!(
            write_whole(&folder.path().join("no/where"), b"")
                .unwrap_err()
                .to_string()
                .contains("does not exist")
        );
        assert!(check_writable(folder.path()).is_err());
    }
}
