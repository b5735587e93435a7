//! Which further files a user's file names.

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

use serde::de::{Deserialize, DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::mesh::{LARGEST_MESH, chunks, local};
use super::whole::read_own;

/// A text that is longer names no file: systems have paths of 4096 bytes at most.
const LONGEST_NAME: usize = 4096;

/// The files there are of those that the texts of a file in TOML or JSON (glTF too) name, under whatever key. None where
/// it cannot be read.
pub(super) fn files_named_in(path: &Path) -> Vec<PathBuf> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if !["json", "gltf", "glb", "toml"].contains(&&*extension) {
        return Vec::new();
    }
    let bytes = read_own(path, LARGEST_MESH).unwrap_or_default();
    let text = String::from_utf8_lossy(if extension == "glb" {
        chunks(&bytes).map_or(&[][..], |(text, _)| text)
    } else {
        &bytes
    });
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let Texts(names) = match &*extension {
        "toml" => toml::from_str(text).unwrap_or_default(),
        _ => serde_json::from_str(text).unwrap_or_default(),
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    // glTF writes blanks as %20.
    let spelled = names.into_iter().flat_map(|name| {
        let decoded = local(&name).ok().filter(|decoded| *decoded != name);
        decoded.into_iter().chain([name])
    });
    spelled.map(|name| folder.join(name)).filter(|place| place.is_file()).collect()
}

/// The texts of a document, at any depth, without the rest of it.
#[derive(Default)]
struct Texts(Vec<String>);

impl<'de> Deserialize<'de> for Texts {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut texts = Vec::new();
        deserializer.deserialize_any(Collect(&mut texts))?;
        Ok(Self(texts))
    }
}
/// Adds every text to a list; numbers and keys are passed over.
struct Collect<'a>(&'a mut Vec<String>);

impl<'de> DeserializeSeed<'de> for Collect<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Collect<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a document")
    }

    fn visit_bool<E>(self, _: bool) -> Result<(), E> {
        Ok(())
    }

    fn visit_i64<E>(self, _: i64) -> Result<(), E> {
        Ok(())
    }

    fn visit_u64<E>(self, _: u64) -> Result<(), E> {
        Ok(())
    }

    fn visit_f64<E>(self, _: f64) -> Result<(), E> {
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_str<E>(self, text: &str) -> Result<(), E> {
        if !text.is_empty() && text.len() <= LONGEST_NAME {
            self.0.push(text.to_owned());
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<(), A::Error> {
        while values.next_element_seed(Collect(&mut *self.0))?.is_some() {}
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut values: A) -> Result<(), A::Error> {
        while values.next_key::<IgnoredAny>()?.is_some() {
            values.next_value_seed(Collect(&mut *self.0))?;
        }
        Ok(())
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
    fn files_are_found_under_whatever_key_they_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        for name in ["a.csv", "b.csv", "c d.bin", "x.exr", "other"] {
            write(name, "");
        }
        write(
            "s.json",
            r#"{"other": 1, "materials": {"x": "a.csv", "y": [1, -0.5, null, true], "z": "none.csv"}, "lattice": {"new": ["b.csv"]}}"#,
        );
        write("m.gltf", r#"{"buffers": [{"uri": "c%20d.bin"}, {"uri": "data:,"}]}"#);
        let glb = [&b"glTF\x02\0\0\0\x34\0\0\0\x20\0\0\0JSON"[..], br#"{"buffers": [{"uri": "b.csv"} ]}"#];
        fs::write(folder.path().join("m.glb"), glb.concat()).unwrap();
        write(
            "s.toml",
            "material = 'a.csv'\nday = 2026-01-02\n[sky_image]\nfile = 'x.exr'\n[[objects]]\ncurves = 'b.csv'\n",
        );
        write("bad.toml", "material = ");
        let found = |name: &str| {
            let names = files_named_in(&folder.path().join(name));
            let mut names: Vec<String> =
                names.iter().map(|p| p.file_name().unwrap().to_string_lossy().into_owned()).collect();
            names.sort();
            names
        };
        assert_eq!(found("s.json"), ["a.csv", "b.csv"]);
        assert_eq!(found("m.gltf"), ["c d.bin"]);
        assert_eq!(found("m.glb"), ["b.csv"]);
        assert_eq!(found("s.toml"), ["a.csv", "b.csv", "x.exr"]);
        assert!(found("bad.toml").is_empty() && found("none.json").is_empty() && found("a.csv").is_empty());
        assert_eq!(files_in(folder.path(), "json").len(), 1);
    }
}
