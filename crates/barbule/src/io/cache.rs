//! The files of a cache folder.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::{Error, Result};

/// A file of a cache folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CacheFile {
    /// Where it is.
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
    /// When it was last written, where the system knows.
    pub modified: Option<SystemTime>,
}

/// The materials (`.barbule`) and tables of crystals (`.orders`) in a folder, sorted by name; none where there is no such
/// folder.
///
/// # Errors
/// The path is a file, or the folder cannot be read.
pub fn list_cache(folder: &Path) -> Result<Vec<CacheFile>> {
    let refuse = |what: String| Error::input(what).in_file(folder);
    if folder.is_file() {
        return Err(
            refuse("is a file, but a cache is a folder; give another with `cache`".into()).naming(&["cache"])
        );
    }
    let unreadable = |e: std::io::Error| refuse(format!("cannot be read ({e})"));
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(unreadable)?,
    };
    let mut files = Vec::new();
    for entry in entries {
        let path = entry.map_err(unreadable)?.path();
        if !path.extension().is_some_and(|e| e == "barbule" || e == "orders") {
            continue;
        }
        // What another process has just deleted is not there.
        if let Ok(metadata) = fs::metadata(&path)
            && metadata.is_file()
        {
            files.push(CacheFile { path, bytes: metadata.len(), modified: metadata.modified().ok() });
        }
    }
    files.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(files)
}

/// Deletes a file that can be made again; one that is gone already is fine.
///
/// # Errors
/// It cannot be deleted.
pub fn delete_file(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => {
            Err(Error::input(format!("cannot be deleted ({error})")).in_file(path))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_materials_and_tables_are_listed_and_listing_makes_no_folder() {
        let folder = tempfile::tempdir().unwrap();
        let none = folder.path().join("none");
        assert_eq!(list_cache(&none).unwrap(), []);
        assert!(!none.exists());
        for name in ["b.orders", "a.barbule", "notes.txt"] {
            fs::write(folder.path().join(name), name).unwrap();
        }
        fs::create_dir(folder.path().join("c.barbule")).unwrap();
        let files = list_cache(folder.path()).unwrap();
        let names: Vec<_> =
            files.iter().map(|f| (f.path.file_name().unwrap().to_str().unwrap(), f.bytes)).collect();
        assert_eq!(names, [("a.barbule", 9), ("b.orders", 8)]);
        assert!(list_cache(&files[0].path).unwrap_err().to_string().contains("a cache is a folder"));
        delete_file(&files[0].path).unwrap();
        delete_file(&files[0].path).unwrap();
        assert_eq!(list_cache(folder.path()).unwrap().len(), 1);
    }
}
