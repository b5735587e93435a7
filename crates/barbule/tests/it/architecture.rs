//! The house is what `ARCHITECTURE.md` says: its table of modules is read here and held against the sources.
//!
//! Between crates the compiler forbids arrows upwards; inside a crate it does not, so this does. Test code is left out.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The libraries, from the ground up. The programs see only the last one.
const LIBRARIES: &[&str] =
    &["barbule-base", "barbule-light", "barbule-optics", "barbule-appearance", "barbule-trace", "barbule"];

/// The crate that serves everyone: its modules need no arrow.
const BASE: &str = "barbule-base";

/// Opens files, looks at the environment or the clock, prints or ends the process: tokens and the modules that may.
const RESERVED: &[(&[&str], &[&str])] = &[
    (&["fs::", "File::", "OpenOptions", "tempfile::", "::to_file(", "::from_file("], &["io"]),
    (&["env::", "process::exit", "println!", "print!", "eprintln!", "eprint!", "stdout()", "stderr()"], &[]),
    (&["build_global"], &[]),
    (&["Instant::now", "SystemTime::now"], &["clock"]),
];

/// A module of a library: what it may use, in the words of the table.
#[derive(Debug)]
struct Room {
    library: String,
    may_use: BTreeSet<String>,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The rows `| module | crate | owns | may use |` of ARCHITECTURE.md.
fn table(text: &str) -> BTreeMap<String, Room> {
    let mut rooms = BTreeMap::new();
    for line in text.lines() {
        let cells: Vec<_> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [modules, library, _, may_use] = cells[..] else { continue };
        let library = library.trim_matches('`').to_owned();
        if !LIBRARIES.contains(&library.as_str()) {
            continue;
        }
        let names = |cell: &str| -> BTreeSet<String> {
            cell.split(',')
                .map(|name| name.trim().trim_matches('`').to_owned())
                .filter(|n| n != "–")
                .collect()
        };
        for module in names(modules) {
            let room = Room { library: library.clone(), may_use: names(may_use) };
            assert!(rooms.insert(module.clone(), room).is_none(), "{module} stands twice in ARCHITECTURE.md");
        }
    }
    rooms
}

/// Every source of a library but its root, with the top-level module it belongs to.
fn sources(library: &str) -> Vec<(String, PathBuf)> {
    let source = root().join("crates").join(library).join("src");
    let mut open = vec![source.clone()];
    let mut found = Vec::new();
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let top = path.strip_prefix(&source).unwrap().iter().next().unwrap().to_string_lossy();
                let module = top.trim_end_matches(".rs").to_owned();
                // `tests.rs` and `…_tests.rs` are test code.
                if module != "lib" && !path.to_string_lossy().ends_with("tests.rs") {
                    found.push((module, path));
                }
            }
        }
    }
    found.sort();
    found
}

/// How deep a file's module lies: 1 for `solve/mod.rs` and `error.rs`, 2 for `solve/film.rs`.
fn depth(path: &Path) -> usize {
    let below = path.iter().rev().take_while(|part| *part != "src").count();
    if path.file_name().is_some_and(|name| name == "mod.rs") { below - 1 } else { below }
}

/// The text without comments, and with literals emptied.
fn bare(text: &str) -> String {
    let letters: Vec<char> = text.chars().collect();
    let mut out = String::with_capacity(text.len());
    let mut at = 0;
    let next = |at: usize| letters.get(at + 1).copied();
    while at < letters.len() {
        match letters[at] {
            '/' if next(at) == Some('/') => {
                while at < letters.len() && letters[at] != '\n' {
                    at += 1;
                }
            }
            '/' if next(at) == Some('*') => {
                let mut open = 1;
                at += 2;
                while at < letters.len() && open > 0 {
                    match (letters[at], next(at)) {
                        ('*', Some('/')) => (open, at) = (open - 1, at + 2),
                        ('/', Some('*')) => (open, at) = (open + 1, at + 2),
                        _ => at += 1,
                    }
                }
            }
            'r' if matches!(next(at), Some('"' | '#')) && !out.ends_with(|c: char| c.is_alphanumeric()) => {
                let hashes = letters[at + 1..].iter().take_while(|c| **c == '#').count();
                if letters.get(at + 1 + hashes) != Some(&'"') {
                    out.push('r');
                    at += 1;
                    continue;
                }
                at += 2 + hashes;
                let ends = |at: usize| {
                    letters[at] == '"'
                        && letters[at + 1..].iter().take(hashes).filter(|c| **c == '#').count() == hashes
                };
                while at < letters.len() && !ends(at) {
                    at += 1;
                }
                at += 1 + hashes;
                out.push_str("\"\"");
            }
            '"' => {
                at += 1;
                while at < letters.len() && letters[at] != '"' {
                    at += if letters[at] == '\\' { 2 } else { 1 };
                }
                at += 1;
                out.push_str("\"\"");
            }
            // A character, not a lifetime.
            '\'' if next(at) == Some('\\') || letters.get(at + 2) == Some(&'\'') => {
                at += if next(at) == Some('\\') { 3 } else { 2 };
                while at < letters.len() && letters[at] != '\'' {
                    at += 1;
                }
                at += 1;
            }
            letter => {
                out.push(letter);
                at += 1;
            }
        }
    }
    out
}

/// Bare code without the items under `#[cfg(test)]` and `#[test]`, and the modules of which only tests know.
fn library_code(bare: &str) -> (String, Vec<String>) {
    let mut rest = bare;
    let mut out = String::new();
    let mut test_modules = Vec::new();
    while let Some(at) = rest.find("#[cfg(test)]") {
        out.push_str(&rest[..at]);
        rest = &rest[at + "#[cfg(test)]".len()..];
        // The item ends with its first semicolon or with the brace that closes its first one.
        let end = rest.find([';', '{']).map_or(rest.len(), |end| {
            if rest.as_bytes()[end] == b';' {
                return end + 1;
            }
            let mut open = 0;
            rest[end..]
                .char_indices()
                .find(|(_, letter)| {
                    open += i32::from(*letter == '{') - i32::from(*letter == '}');
                    open == 0
                })
                .map_or(rest.len(), |(close, _)| end + close + 1)
        });
        let item = rest[..end].trim();
        if let Some(name) = item.strip_suffix(';').and_then(|item| item.split("mod ").nth(1)) {
            test_modules.push(name.trim().to_owned());
        }
        rest = &rest[end..];
    }
    out.push_str(rest);
    (out, test_modules)
}

/// The names behind each `prefix` in code: one name, or those of a list in braces.
fn named_after(code: &str, prefix: &str) -> Vec<String> {
    let name =
        |s: &str| s.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut found = Vec::new();
    for (at, _) in code.match_indices(prefix) {
        // Not the end of a longer path, as `super::super::` in `super::super::super::`.
        if code[..at].ends_with(|c: char| c.is_alphanumeric() || matches!(c, '_' | ':')) {
            continue;
        }
        let rest = &code[at + prefix.len()..];
        let Some(list) = rest.strip_prefix('{') else {
            found.push(name(rest));
            continue;
        };
        let (mut depth, mut start) = (0, 0);
        for (at, letter) in list.char_indices() {
            if depth == 0 && matches!(letter, ',' | '}') {
                found.push(name(&list[start..at]));
                start = at + 1;
            }
            depth += i32::from(letter == '{') - i32::from(letter == '}');
            if depth < 0 {
                break;
            }
        }
    }
    found.retain(|name| !name.is_empty() && name != "self" && name != "super");
    found
}

/// Every module's library code, file by file.
fn code_of_all() -> Vec<(String, String, PathBuf, String)> {
    let mut all = Vec::new();
    for library in LIBRARIES {
        let files = sources(library);
        let mut hidden = BTreeSet::new();
        let mut found = Vec::new();
        for (module, path) in files {
            let (code, tests) = library_code(&bare(&fs::read_to_string(&path).unwrap()));
            let folder = path.parent().unwrap();
            let here = if depth(&path) == 1 || path.ends_with("mod.rs") {
                folder.to_owned()
            } else {
                folder.join(path.file_stem().unwrap())
            };
            for test in tests {
                hidden.insert(here.join(format!("{test}.rs")));
                hidden.insert(folder.join(format!("{test}.rs")));
            }
            found.push(((*library).to_owned(), module, path, code));
        }
        all.extend(found.into_iter().filter(|(_, _, path, _)| !hidden.contains(path)));
    }
    all
}

#[test]
fn modules_are_those_of_the_table_and_use_each_other_along_its_arrows() {
    let rooms = table(&fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap());
    let mut wrong = BTreeSet::new();
    let mut used: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (library, module, path, code) in code_of_all() {
        let Some(room) = rooms.get(&module).filter(|room| room.library == library) else {
            wrong.insert(format!("{library}::{module} is not in the table"));
            continue;
        };
        let mut targets = named_after(&code, "crate::");
        targets.extend(named_after(&code, &"super::".repeat(depth(&path))));
        for other in LIBRARIES {
            targets.extend(named_after(&code, &format!("{}::", other.replace('-', "_"))));
        }
        for target in targets {
            let Some(aim) = rooms.get(&target) else { continue };
            if target == module || aim.library == BASE {
                continue;
            }
            if !room.may_use.contains(&target) {
                wrong.insert(format!("{module} uses {target} ({})", path.display()));
            }
            used.entry(module.clone()).or_default().insert(target);
        }
    }
    for (module, room) in &rooms {
        for target in &room.may_use {
            if !used.get(module).is_some_and(|used| used.contains(target)) {
                wrong.insert(format!("{module} may use {target} and does not"));
            }
        }
        let folder = root().join("crates").join(&room.library).join("src");
        if !folder.join(module).is_dir() && !folder.join(format!("{module}.rs")).is_file() {
            wrong.insert(format!("there is no {}::{module}", room.library));
        }
    }
    assert!(
        wrong.is_empty(),
        "ARCHITECTURE.md and the sources differ:\n{}",
        Vec::from_iter(wrong).join("\n")
    );
}

#[test]
fn arrows_of_the_table_form_no_circle() {
    let mut rooms = table(&fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap());
    while !rooms.is_empty() {
        let open: BTreeSet<String> = rooms.keys().cloned().collect();
        let ground: Vec<_> = rooms
            .iter()
            .filter(|(_, room)| room.may_use.iter().all(|target| !open.contains(target)))
            .map(|(module, _)| module.clone())
            .collect();
        assert!(!ground.is_empty(), "a circle among {open:?}");
        rooms.retain(|module, _| !ground.contains(module));
    }
}

#[test]
fn only_io_opens_files_and_no_library_prints_or_looks_around() {
    let mut wrong = BTreeSet::new();
    for (_, module, path, code) in code_of_all() {
        for (tokens, allowed) in RESERVED {
            for token in *tokens {
                let word = |at: usize| !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
                if !allowed.contains(&module.as_str()) && code.match_indices(token).any(|(at, _)| word(at)) {
                    wrong.insert(format!("{}: {token}", path.display()));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "not here:\n{}", Vec::from_iter(wrong).join("\n"));
}

/// Opening and making files: tokens.
const OPENING: [&str; 11] = [
    "File::open",
    "File::options",
    "File::create",
    "OpenOptions",
    "fs::read(",
    "fs::read_to_string(",
    "fs::write(",
    "fs::copy(",
    "fs::rename(",
    "hard_link(",
    ".persist(",
];

/// The files of `io` with them: where inputs are noted and outputs ask first, and what is never an input.
const OPENERS: [&str; 5] = ["whole.rs", "output.rs", "temporary.rs", "aside.rs", "machine.rs"];

#[test]
fn files_are_read_and_written_where_the_ledger_hears_of_it() {
    let commands = sources("barbule-cli").into_iter().map(|(_, path)| {
        let (code, _) = library_code(&bare(&fs::read_to_string(&path).unwrap()));
        (path, code)
    });
    let mut wrong = BTreeSet::new();
    for (path, code) in code_of_all().into_iter().map(|(_, _, path, code)| (path, code)).chain(commands) {
        let may = OPENERS.iter().any(|name| path.ends_with(name));
        wrong.extend(
            OPENING
                .iter()
                .filter(|token| !may && code.contains(**token))
                .map(|token| format!("{}: {token}", path.display())),
        );
    }
    assert!(wrong.is_empty(), "not here:\n{}", Vec::from_iter(wrong).join("\n"));
}

/// Whatever calls the library has its own names for its arguments: messages have them in backticks ([`barbule::Error::naming`]).
#[test]
fn messages_of_the_libraries_name_no_flags() {
    let mut wrong = BTreeSet::new();
    for (_, path) in LIBRARIES.iter().flat_map(|library| sources(library)) {
        let text = fs::read_to_string(&path).unwrap();
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
        for (number, line) in (1..).zip(code.lines().map(str::trim_start)) {
            if !line.starts_with("//") && names_a_flag(line) {
                wrong.insert(format!("{}:{number}: {line}", path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "flags in the library:\n{}", Vec::from_iter(wrong).join("\n"));
    assert!(names_a_flag("\"give --simd {}\"") && !names_a_flag("a - -b") && !names_a_flag("// ----"));
}

fn names_a_flag(line: &str) -> bool {
    line.match_indices("--").any(|(at, _)| line[at + 2..].starts_with(|c: char| c.is_ascii_lowercase()))
}

#[test]
fn programs_see_the_facade_only() {
    for entry in fs::read_dir(root().join("crates")).unwrap() {
        let folder = entry.unwrap().path();
        let name = folder.file_name().unwrap().to_string_lossy().into_owned();
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
        // What of the viewer runs in browsers stands on what is below the façade.
        if LIBRARIES.contains(&name.as_str()) || name == "barbule-view" {
            continue;
        }
        for inner in LIBRARIES.iter().filter(|library| **library != "barbule") {
            assert!(!manifest.contains(&format!("{inner}.")), "{name} depends on {inner}, not on barbule");
        }
    }
}

#[test]
fn the_check_sees_what_it_must() {
    assert_eq!(named_after("use crate::{render::Film, error};", "crate::"), ["render", "error"]);
    assert_eq!(named_after("let x = crate::solve::film();", "crate::"), ["solve"]);
    assert_eq!(named_after("use super::super::render::Film;", "super::super::"), ["render"]);
    assert!(named_after("use super::super::render::Film;", "super::").iter().all(|name| name != "render"));
    let text = "/* crate::a */ let s = \"crate::b\"; // crate::c\nlet c = '\"'; crate::d::e('\\'');";
    assert_eq!(named_after(&bare(text), "crate::"), ["d"]);
    let text = "#[cfg(test)]\nmod tests;\n#[cfg(test)]\nmod more { use std::fs; fn f() {} }\nuse std::fs;";
    let (code, modules) = library_code(text);
    assert_eq!((code.matches("fs").count(), modules), (1, vec!["tests".to_owned()]));
    let rooms = table("| `a`, `b` | `barbule` | things | `c` |\n| `c` | `barbule-base` | – | – |");
    assert!(rooms["b"].may_use.contains("c") && rooms["c"].may_use.is_empty());
}
