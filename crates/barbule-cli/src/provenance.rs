//! Where an output comes from: version, command and seed, inside figures and beside CSV files.

use std::path::{Path, PathBuf};

use barbule::error::shortened;
use barbule::io::{check_writable, is_stream, write_together, write_whole};
use barbule::plot::{Drawing, Format};
use barbule::{Error, Result};

use crate::common::Common;

/// What made an output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Provenance {
    notes: Vec<(String, String)>,
}

impl Provenance {
    /// This version, this process's command line and its seed. How work was shared out decides nothing and is left out of the command:
    /// what several processes write is the same bytes as one writes.
    #[must_use]
    pub fn new(common: &Common) -> Self {
        let words = std::env::args_os().skip(1).map(|word| quoted(&word.to_string_lossy()));
        let words = without_shard(words.collect());
        let command = std::iter::once("barbule".to_owned()).chain(words).collect::<Vec<_>>().join(" ");
        let notes = [
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("command", command),
            ("seed", common.seed.to_string()),
        ];
        Self { notes: notes.into_iter().map(|(name, text)| (name.to_owned(), text)).collect() }
    }

    /// The same with a further note, for example `material_hash`.
    #[must_use]
    pub fn with(mut self, name: &str, text: impl Into<String>) -> Self {
        self.notes.push((name.to_owned(), text.into()));
        self
    }

    /// All notes (name, text), for formats that carry them inside.
    #[must_use]
    pub fn notes(&self) -> Vec<(&str, &str)> {
        self.notes.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect()
    }

    /// The notes as one JSON object.
    #[must_use]
    pub fn json(&self) -> serde_json::Value {
        let value = |(name, text): &(String, String)| {
            let number = (name == "seed").then(|| text.parse::<u64>().ok()).flatten();
            (name.clone(), number.map_or_else(|| text.clone().into(), serde_json::Value::from))
        };
        serde_json::Value::Object(self.notes.iter().map(value).collect())
    }

    /// Writes a figure, SVG, PDF or PNG by its extension, with the notes inside.
    ///
    /// # Errors
    /// Another extension, or the file cannot be written.
    pub fn write_figure(&self, path: &Path, drawing: &Drawing) -> Result<()> {
        write_whole(path, &drawing.encode(Format::of(path)?, &self.notes())?)
    }

    /// Writes a CSV file and, beside it, the notes as `FILE.json`: both or neither. What goes to a pipe or a device has
    /// nothing beside it.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write_csv(&self, path: &Path, text: &str) -> Result<()> {
        if !is_beside(path) {
            return write_whole(path, text.as_bytes());
        }
        let notes = format!("{}\n", self.json());
        write_together(&[(path, text.as_bytes()), (&sidecar(path), notes.as_bytes())])
    }
}

/// Whether a CSV file has its notes beside it.
#[must_use]
pub fn is_beside(path: &Path) -> bool {
    !is_stream(path)
}

/// The file beside a CSV file that says where it comes from.
#[must_use]
pub fn sidecar(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".json");
    name.into()
}

/// Refuses, before any work, outputs that could not be written: unknown extensions of figures, missing folders. That
/// each is a file of its own is checked before any command.
///
/// # Errors
/// As above.
pub fn check_outputs(figure: Option<&Path>, csv: Option<&Path>) -> Result<()> {
    for path in [figure, csv].into_iter().flatten() {
        if path.as_os_str() == "-" {
            return Err(Error::input(
                "-: files are written to paths, not to standard output; give a path, or --json for standard output",
            ));
        }
    }
    if let Some(path) = figure {
        Format::of(path)?;
        check_writable(path)?;
    }
    if let Some(path) = csv {
        check_writable(path)?;
        if is_beside(path) {
            check_writable(&sidecar(path))?;
        }
    }
    Ok(())
}

/// Refuses names of CSV files that plainly ask for something else: `-`, and extensions of other formats.
///
/// # Errors
/// As above; `flag` names the argument.
pub fn check_table(flag: &str, path: &Path) -> Result<()> {
    const OTHERS: [&str; 22] = [
        "xlsx", "xls", "xlsm", "ods", "numbers", "json", "svg", "png", "pdf", "eps", "jpg", "jpeg", "tif",
        "tiff", "exr", "html", "toml", "yml", "yaml", "zarr", "barbule", "npy",
    ];
    if path.as_os_str() == "-" {
        return Err(Error::input(format!(
            "{flag} -: name a file; --json prints the numbers on standard output"
        )));
    }
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if OTHERS.contains(&extension.as_str()) {
        return Err(Error::input(format!(
            "{flag} {}: tables are written as CSV, not as .{extension}; end the name with .csv",
            shortened(&path.to_string_lossy())
        )));
    }
    Ok(())
}

/// A cell of a CSV file: in quotes where it holds a comma, a quote or a line's end.
#[must_use]
pub fn csv_cell(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        return format!("\"{}\"", text.replace('"', "\"\""));
    }
    text.to_owned()
}

/// The words of a command line but for `--shard i/n`.
fn without_shard(words: Vec<String>) -> Vec<String> {
    let mut is_value = false;
    let keeps = |word: &String| {
        let is_left_out = std::mem::take(&mut is_value) || word.starts_with("--shard=");
        is_value = !is_left_out && word == "--shard";
        !(is_left_out || is_value)
    };
    words.into_iter().filter(keeps).collect()
}

/// A word as a shell needs it.
pub(crate) fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_where_a_shell_would_read_them_otherwise() {
        assert_eq!(quoted("--angle=-20"), "--angle=-20");
        assert_eq!(quoted("air/6*(keratin:5)/air"), "'air/6*(keratin:5)/air'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
    }

    #[test]
    fn how_work_was_shared_out_is_no_part_of_the_command() {
        let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<_>>();
        for text in ["a --shard 1/3 --b", "a --shard=1/3 --b", "a --b --shard 0/2"] {
            assert_eq!(without_shard(words(text)), ["a", "--b"], "{text}");
        }
        assert_eq!(without_shard(words("a --shards 3")), ["a", "--shards", "3"]);
    }

    #[test]
    fn names_of_other_formats_are_no_tables_and_cells_are_quoted() {
        for bad in ["-", "a.xlsx", "A.PNG", "b.json"] {
            assert!(
                check_table("--csv", Path::new(bad)).unwrap_err().to_string().starts_with("--csv "),
                "{bad}"
            );
        }
        for good in ["a.csv", "a.txt", "a", "a.tsv"] {
            check_table("--csv", Path::new(good)).unwrap();
        }
        assert_eq!(csv_cell("air/mix(a,b,0.4):1/air"), "\"air/mix(a,b,0.4):1/air\"");
        assert_eq!(csv_cell("star\"ling"), "\"star\"\"ling\"");
    }

    #[test]
    fn sidecars_stand_beside_their_file() {
        assert_eq!(sidecar(Path::new("a/b.csv")), Path::new("a/b.csv.json"));
        assert!(
            check_outputs(Some(Path::new("a.eps")), None)
                .unwrap_err()
                .to_string()
                .contains(".svg, .pdf or .png")
        );
    }
}
