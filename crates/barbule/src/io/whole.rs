//! Reading users' files whole, within limits on their size and kind.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read as _};
use std::path::Path;

use super::ledger::note_input;
use crate::{Error, Result};

/// Bytes of a file, or of all files in a folder; of what is not there none.
#[must_use]
pub fn bytes_of(path: &Path) -> u64 {
    let length = |path: &Path| fs::metadata(path).map_or(0, |of| of.len());
    match fs::read_dir(path) {
        Ok(entries) => entries.flatten().map(|entry| length(&entry.path())).sum(),
        Err(_) => length(path),
    }
}

/// What follows `middle` in the names of files that begin with the name of `path` and it, in the folder where `path` is or is to be: files of the
/// program's own beside an output. None where the folder cannot be listed.
#[must_use]
pub fn endings_beside(path: &Path, middle: &str) -> Vec<String> {
    let Some(name) = path.file_name() else { return Vec::new() };
    let ending = |entry: fs::DirEntry| {
        let of_file = entry.file_name();
        let rest = of_file.as_encoded_bytes().strip_prefix(name.as_encoded_bytes())?;
        std::str::from_utf8(rest).ok()?.strip_prefix(middle).map(str::to_owned)
    };
    fs::read_dir(folder_of(path)).into_iter().flatten().flatten().filter_map(ending).collect()
}

/// The largest input file that is read: 64 MiB.
pub const LARGEST_INPUT: u64 = 64 << 20;

/// The largest TOML or YAML: 4 MiB, since their readers take up to 110 bytes per byte.
const LARGEST_BY_HAND: u64 = 4 << 20;

/// The largest table in text: 16 MiB, since the shortest lines become 15 bytes per byte.
pub const LARGEST_TABLE: u64 = 16 << 20;

/// Most commas and opening brackets of a JSON, a bound of its values: each takes up to 300 bytes. The largest section has
/// half as many.
const MOST_JSON_VALUES: usize = 4_000_000;

/// Reads a user's file of at most [`LARGEST_INPUT`] bytes.
///
/// # Errors
/// Missing, a folder or another thing that is no file, unreadable, or too large; an output of a [`super::Ledger`] that is
/// open.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    read_at_most(path, LARGEST_INPUT)
}

/// Reads a file of at most `largest` bytes, for formats with a limit of their own.
///
/// # Errors
/// As [`read_bytes`].
pub fn read_at_most(path: &Path, largest: u64) -> Result<Vec<u8>> {
    note_input(path)?;
    read_own(path, largest)
}

/// Reads a file of the program's own, which it replaces when it likes: of a cache, a checkpoint. Users' files are read by
/// [`read_at_most`], which keeps them from being overwritten.
///
/// # Errors
/// As [`read_bytes`].
pub fn read_own(path: &Path, largest: u64) -> Result<Vec<u8>> {
    let refuse = |what: &str| Error::input(what).in_file(path);
    let metadata = fs::metadata(path).map_err(|error| match error.kind() {
        ErrorKind::NotFound => refuse("no such file"),
        _ => failure(path, "cannot be read", &error),
    })?;
    if metadata.is_dir() {
        return Err(refuse("is a folder, but a file is needed"));
    }
    // A pipe that nobody fills would be waited for in vain, and a device never ends.
    if !metadata.is_file() && !is_descriptor(path) {
        return Err(refuse(
            "is a pipe or a device, but a file is needed; what a pipe brings is read from /dev/stdin",
        ));
    }
    let limit = format!("over the limit of {} MiB for such a file", largest.div_ceil(1 << 20));
    if metadata.len() > largest {
        return Err(refuse(&format!("has {} bytes, {limit}", metadata.len())));
    }
    let mut bytes = Vec::new();
    fs::File::open(path)
        .and_then(|file| file.take(largest + 1).read_to_end(&mut bytes))
        .map_err(|error| failure(path, "cannot be read", &error))?;
    if bytes.len() as u64 > largest {
        return Err(refuse(&format!("is {limit}")));
    }
    Ok(bytes)
}

/// A regular file and its length, bytes, for looking at what it says of its size; nothing of anything else, which would be read
/// only once.
pub(super) fn open_regular(path: &Path) -> Option<(File, u64)> {
    let file = fs::metadata(path).ok().filter(fs::Metadata::is_file).and_then(|_| File::open(path).ok())?;
    let length = file.metadata().ok()?.len();
    Some((file, length))
}

/// Reads a user's text file (UTF-8, a byte-order mark is dropped): at most 4 MiB of TOML or YAML, 64 MiB of JSON with
/// 4,000,000 commas and opening brackets, 16 MiB of anything else.
///
/// # Errors
/// As [`read_bytes`], or not UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let largest = match extension.as_str() {
        "toml" | "yml" | "yaml" => LARGEST_BY_HAND,
        "json" => LARGEST_INPUT,
        _ => LARGEST_TABLE,
    };
    let bytes = read_at_most(path, largest)?;
    let refuse = |what: &str| Error::input(what).in_file(path);
    if extension == "json" && bytes.iter().filter(|b| b",[{".contains(b)).count() > MOST_JSON_VALUES {
        return Err(refuse(&format!(
            "has over {MOST_JSON_VALUES} commas and opening brackets, more than any file that is read here needs"
        )));
    }
    let text = String::from_utf8(bytes).map_err(|_| refuse("is not UTF-8 text; save it as UTF-8"))?;
    match text.strip_prefix('\u{feff}') {
        Some(rest) => Ok(rest.to_owned()),
        None => Ok(text),
    }
}

/// Whether a path names an open descriptor of the process, as `/dev/stdin` does and a shell's `<(…)`.
pub(super) fn is_descriptor(path: &Path) -> bool {
    ["/dev/stdin", "/dev/stdout", "/dev/stderr"].iter().any(|name| path == Path::new(name))
        || path.starts_with("/dev/fd")
        || (path.starts_with("/proc") && path.parent().is_some_and(|folder| folder.ends_with("fd")))
}

/// The folder that a file lies in, or will.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// An error of the file system as a sentence: the user's where a path or a permission is wrong, else the machine's.
pub(super) fn failure(path: &Path, what: &str, error: &io::Error) -> Error {
    let sentence = format!("{what} ({error})");
    let error = match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            Error::machine(format!("{sentence}; free some space and run the same command again"))
        }
        ErrorKind::NotFound
        | ErrorKind::PermissionDenied
        | ErrorKind::ReadOnlyFilesystem
        | ErrorKind::IsADirectory
        | ErrorKind::NotADirectory
        | ErrorKind::DirectoryNotEmpty
        | ErrorKind::AlreadyExists
        | ErrorKind::InvalidFilename
        | ErrorKind::InvalidInput
        | ErrorKind::ExecutableFileBusy
        | ErrorKind::ResourceBusy
        | ErrorKind::CrossesDevices
        | ErrorKind::Unsupported => Error::input(sentence),
        _ => Error::machine(sentence),
    };
    error.in_file(path)
}

/// BLAKE3 of bytes, in hexadecimal.
#[must_use]
pub fn hash_bytes(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

/// BLAKE3 of a file's bytes, in hexadecimal; a file may have any length.
///
/// # Errors
/// As [`read_bytes`], but for the length.
pub fn hash_file(path: &Path) -> Result<String> {
    if !fs::metadata(path).is_ok_and(|metadata| metadata.is_file()) {
        return Ok(hash_bytes(&read_bytes(path)?));
    }
    note_input(path)?;
    let mut hasher = blake3::Hasher::new();
    let read = File::open(path).and_then(|file| hasher.update_reader(file).map(drop));
    read.map_err(|e| failure(path, "cannot be read", &e))?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// Makes a folder with those it lies in.
///
/// # Errors
/// It cannot be made.
pub fn make_folder(path: &Path) -> Result<()> {
    fs::create_dir_all(path).map_err(|e| failure(path, "cannot be made", &e))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message<T>(result: Result<T>) -> String {
        result.err().map(|e| e.to_string()).unwrap_or_default()
    }

    #[test]
    fn hashes_are_those_of_the_bytes_however_large_a_file_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large");
        fs::write(&path, b"few").unwrap();
        assert_eq!(hash_file(&path).unwrap(), hash_bytes(b"few"));
        File::create(&path).unwrap().set_len(LARGEST_INPUT + 1).unwrap();
        assert_eq!(hash_file(&path).unwrap(), hash_bytes(&vec![0; LARGEST_INPUT as usize + 1]));
        assert!(message(hash_file(&folder.path().join("none"))).contains("no such file"));
    }

    #[test]
    fn folders_missing_files_and_what_is_not_text_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        assert!(message(read_bytes(folder.path())).contains("is a folder"));
        assert!(message(read_bytes(&folder.path().join("x"))).contains("no such file"));
        let path = folder.path().join("a.csv");
        fs::write(&path, b"\xff").unwrap();
        assert!(message(read_text(&path)).contains("is not UTF-8 text"));
        fs::write(&path, "\u{feff}1,2").unwrap();
        assert_eq!(read_text(&path).unwrap(), "1,2");
    }

    #[test]
    fn each_kind_of_text_has_its_limit_so_that_reading_it_fits_into_memory() {
        let folder = tempfile::tempdir().unwrap();
        for (name, largest, limit) in [
            ("a.toml", LARGEST_BY_HAND, "limit of 4 MiB"),
            ("a.YAML", LARGEST_BY_HAND, "limit of 4 MiB"),
            ("a.csv", LARGEST_TABLE, "limit of 16 MiB"),
            ("a.json", LARGEST_INPUT, "limit of 64 MiB"),
        ] {
            let path = folder.path().join(name);
            fs::File::create(&path).unwrap().set_len(largest + 1).unwrap();
            assert!(message(read_text(&path)).contains(limit), "{name}");
        }
        let path = folder.path().join("many.json");
        fs::write(&path, vec![b'['; MOST_JSON_VALUES]).unwrap();
        assert!(read_text(&path).is_ok());
        fs::write(&path, vec![b','; MOST_JSON_VALUES + 1]).unwrap();
        assert!(message(read_text(&path)).contains("over 4000000 commas"));
    }

    #[cfg(unix)]
    #[test]
    fn pipes_without_a_writer_and_devices_are_refused_and_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("p.json");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in [pipe.as_path(), Path::new("/dev/zero"), Path::new("/dev/null")] {
            let text = message(read_text(path));
            assert!(text.contains("is a pipe or a device, but a file is needed"), "{text}");
        }
        assert!(is_descriptor(Path::new("/dev/stdin")) && is_descriptor(Path::new("/dev/fd/63")));
        assert!(is_descriptor(Path::new("/proc/self/fd/0")) && !is_descriptor(Path::new("/dev/zero")));
    }

    #[test]
    fn whose_fault_an_error_is_follows_from_its_kind() {
        for (kind, is_input) in [
            (ErrorKind::PermissionDenied, true),
            (ErrorKind::ReadOnlyFilesystem, true),
            (ErrorKind::NotFound, true),
            (ErrorKind::StorageFull, false),
            (ErrorKind::Other, false),
        ] {
            let error = failure(Path::new("a"), "cannot be written", &kind.into());
            assert_eq!(error.is_input(), is_input, "{error}");
        }
    }
}
