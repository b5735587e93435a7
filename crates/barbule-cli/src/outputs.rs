//! Names of outputs, before any work: each its own, none that of an input.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use barbule::io::{claim_output, is_inside_store, is_same_file, note_input};
use barbule::structure::species_names;
use barbule::{Error, Result};
use clap::ArgMatches;
use clap::parser::ValueSource;

use crate::provenance::{check_table, is_beside, sidecar};

/// Arguments whose values are files to be written.
pub(crate) const OUTPUTS: [&str; 6] = ["output", "csv", "summary", "law", "human", "picture"];

/// Those of them that are tables in text.
const TABLES: [&str; 2] = ["csv", "summary"];

/// Arguments whose values are folders that the program fills, and so no inputs.
pub(crate) const FOLDERS: [&str; 5] = ["cache", "keep_store", "write_curves", "folder", "page"];

/// A file that a command line asks to be written.
struct Output {
    path: PathBuf,
    /// As messages call it.
    name: String,
    flag: String,
    is_table: bool,
}

/// Refuses, before any work, what would destroy a file that the same command reads or writes: by whatever other spelling,
/// link or second name, and also where only a file of the command line names it. What commands read and write beside what
/// the command line names is found by the ledger that is open.
///
/// # Errors
/// One output for two purposes; an output that is an input; a table with another format's ending.
pub(crate) fn check(matches: &ArgMatches) -> Result<()> {
    let mut matches = matches;
    while let Some((_, deeper)) = matches.subcommand() {
        matches = deeper;
    }
    let outputs = outputs(matches);
    for (index, output) in outputs.iter().enumerate() {
        if is_inside_store(&output.path) {
            return Err(Error::input(format!(
                "{}: lies inside a campaign store; give a name elsewhere",
                output.name
            )));
        }
        if let Some(other) = outputs[..index].iter().find(|other| is_same_file(&other.path, &output.path)) {
            return Err(Error::input(format!(
                "{}: is the same file as {}; give two names",
                output.name, other.name
            )));
        }
    }
    outputs
        .iter()
        .filter(|output| output.is_table)
        .try_for_each(|table| check_table(&table.flag, &table.path))?;
    outputs.iter().try_for_each(|output| claim_output(&output.path, &output.name))?;
    words(matches).iter().flat_map(|word| readings(word)).try_for_each(|path| note_input(&path))
}

/// All outputs, notes beside tables too.
fn outputs(matches: &ArgMatches) -> Vec<Output> {
    let mut found = Vec::new();
    for id in OUTPUTS {
        let flag = if id == "output" { "-o".to_owned() } else { format!("--{id}") };
        for path in values(matches, id).into_iter().map(PathBuf::from) {
            let name = format!("{flag} {}", path.display());
            let is_table = TABLES.contains(&id);
            let has_notes = is_table || ["csv", "npy"].iter().any(|end| ends_with(&path, end));
            if has_notes && is_beside(&path) {
                let notes = sidecar(&path);
                let name = format!("{} (the notes beside {name})", notes.display());
                found.push(Output { path: notes, name, flag: flag.clone(), is_table: false });
            }
            found.push(Output { path, name, flag: flag.clone(), is_table });
        }
    }
    found
}

fn ends_with(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// The words of a command line that may name what is read.
fn words(matches: &ArgMatches) -> Vec<OsString> {
    let is_read = |id: &&str| !OUTPUTS.contains(id) && !FOLDERS.contains(id);
    matches.ids().map(clap::Id::as_str).filter(is_read).flat_map(|id| values(matches, id)).collect()
}

/// What was typed for an argument.
fn values(matches: &ArgMatches, id: &str) -> Vec<OsString> {
    if !matches!(matches.try_contains_id(id), Ok(true))
        || matches.value_source(id) != Some(ValueSource::CommandLine)
    {
        return Vec::new();
    }
    let raw = matches.try_get_raw(id).ok().flatten();
    raw.into_iter().flatten().map(OsStr::to_owned).collect()
}

/// What a word names if it names files: itself, NAME=FILE, FILE:VARIANT, KIND:FILE, FILE@ANGLE.
fn readings(word: &OsStr) -> Vec<PathBuf> {
    let mut found = vec![PathBuf::from(word)];
    if let Some(text) = word.to_str() {
        let species = text.split(':').next().unwrap_or_default();
        if species_names().any(|name| name == species) {
            return Vec::new();
        }
        found.extend(text.split_once('=').map(|(_, file)| PathBuf::from(file)));
        found.extend(text.rsplit_once(':').map(|(file, _)| PathBuf::from(file)));
        found.extend(text.rsplit_once('@').map(|(file, _)| PathBuf::from(file)));
        found.extend(text.split_once(':').map(|(_, file)| PathBuf::from(file)));
    }
    found.retain(|path| path.exists());
    found
}

#[cfg(test)]
mod tests {
    use std::any::TypeId;

    use super::*;

    /// Arguments whose values are files or folders that are read.
    const INPUTS: [&str; 6] = ["curves", "denoise", "image", "measured", "plan", "store"];

    #[test]
    fn of_every_path_argument_it_is_known_whether_it_is_written() {
        let mut open = vec![crate::command()];
        while let Some(mut command) = open.pop() {
            command.build();
            for argument in command.get_arguments() {
                let (id, kind) = (argument.get_id().as_str(), argument.get_value_parser().type_id());
                let is_path = kind == TypeId::of::<PathBuf>();
                let known = OUTPUTS.contains(&id) || FOLDERS.contains(&id) || INPUTS.contains(&id);
                assert!(known || !is_path, "{} {id}: say whether it is read or written", command.get_name());
            }
            open.extend(command.get_subcommands().cloned());
        }
    }
}
