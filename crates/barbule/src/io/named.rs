//! Which further files a user's file names.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::read_text;

/// Keys whose texts name files, in structures and scenes.
const KEYS: [&str; 8] = ["materials", "material", "file", "spectrum", "mesh", "albedo", "alpha", "normal"];

/// The files there are of those that a structure's or scene's file names under these keys. None
/// where it cannot be read.
#[must_use]
pub fn files_named_in(path: &Path) -> Vec<PathBuf> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let value = match extension.as_str() {
        "json" => read_text(path).ok().and_then(|text| serde_json::from_str(&text).ok()),
        "toml" => read_text(path).ok().and_then(|text| toml::from_str(&text).ok()),
        _ => None,
    };
    let mut names = Vec::new();
    collect(&value.unwrap_or(Value::Null), false, &mut names);
    let folder = path.parent().unwrap_or(Path::new(""));
    names.into_iter().map(|name| folder.join(name)).filter(|place| place.is_file()).collect()
}

/// The texts under such keys, at any depth.
fn collect(value: &Value, named: bool, names: &mut Vec<String>) {
    match value {
        Value::String(text) if named => names.push(text.clone()),
        Value::Array(values) => values.iter().for_each(|value| collect(value, named, names)),
        Value::Object(table) => {
            for (key, value) in table {
                collect(value, named || KEYS.contains(&key.as_str()), names);
            }
        }
        _ => {}
    }
}

/// The files in a folder with this ending, sorted; none where it cannot be read.
#[must_use]
pub fn files_in(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut files: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))).collect();
    files.sort();
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_found_wherever_a_structure_or_scene_names_them() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        for name in ["a.csv", "b.csv", "c.exr", "other"] {
            write(name, "");
        }
        write(
            "s.json",
            r#"{"name": "other", "materials": {"x": "a.csv", "y": [1, 0], "z": "none.csv"}, "lattice": {"materials": {"b": "b.csv"}}}"#,
        );
        write("s.toml", "material = 'a.csv'\nsource = 'other'\n[sky_image]\nfile = 'c.exr'\n");
        write("bad.toml", "material = ");
        let found = |name: &str| {
            let names = files_named_in(&folder.path().join(name));
            names.iter().map(|p| p.file_name().unwrap().to_string_lossy().into_owned()).collect::<Vec<_>>()
        };
        assert_eq!(found("s.json"), ["a.csv", "b.csv"]);
        assert_eq!(found("s.toml"), ["a.csv", "c.exr"]);
        assert!(found("bad.toml").is_empty() && found("none.json").is_empty() && found("a.csv").is_empty());
        assert_eq!(files_in(folder.path(), "json").len(), 1);
    }
}
