//! Modules use each other only along the arrows of `ARCHITECTURE.md`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Module → what it may use. Every module may also use `error`, `math`, `progress` and itself.
const ARROWS: &[(&str, &[&str])] = &[
    ("math", &[]),
    ("spectrum", &[]),
    ("material", &["spectrum"]),
    ("structure", &["material", "spectrum"]),
    ("scattering", &["spectrum"]),
    ("solve", &["structure", "material", "scattering", "spectrum"]),
    ("campaign", &["solve", "structure", "material", "scattering", "spectrum", "io"]),
    ("brdf", &["scattering", "spectrum"]),
    ("scene", &["brdf", "spectrum"]),
    ("render", &["scene", "brdf", "spectrum"]),
    ("plot", &["spectrum"]),
    ("io", &["spectrum", "material", "structure", "scattering", "brdf", "scene", "plot"]),
];

const COMMON: &[&str] = &["error", "math", "progress", "Error", "Result", "Complex64"];

fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|e| e == "rs") {
            into.push(path);
        }
    }
}

/// The first path segments after `crate::` in a source text, `use crate::{a, b}` included.
fn used(text: &str) -> Vec<String> {
    let code: String =
        text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
    let name =
        |s: &str| s.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut found = Vec::new();
    for rest in code.split("crate::").skip(1) {
        match rest.strip_prefix('{') {
            Some(list) => {
                let mut depth = 0;
                let mut start = 0;
                for (at, c) in list.char_indices() {
                    let ends = depth == 0 && matches!(c, ',' | '}');
                    if ends {
                        found.push(name(&list[start..at]));
                        start = at + 1;
                    }
                    depth += i32::from(c == '{') - i32::from(c == '}');
                    if depth < 0 {
                        break;
                    }
                }
            }
            None => found.push(name(rest)),
        }
    }
    found.retain(|name| !name.is_empty());
    found
}

#[test]
fn modules_follow_the_permitted_arrows() {
    let arrows: BTreeMap<_, _> = ARROWS.iter().copied().collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    let mut forbidden = Vec::new();
    for file in files {
        let relative = file.strip_prefix(&root).unwrap();
        let module = relative.iter().next().unwrap().to_str().unwrap().trim_end_matches(".rs");
        let Some(allowed) = arrows.get(module) else { continue };
        for target in used(&fs::read_to_string(&file).unwrap()) {
            let known = arrows.contains_key(target.as_str());
            if known && target != module && target != "math" && !allowed.contains(&target.as_str()) {
                forbidden.push(format!("{} uses crate::{target}", relative.display()));
            }
            assert!(
                known || COMMON.contains(&target.as_str()),
                "{}: what is crate::{target}?",
                relative.display()
            );
        }
    }
    assert!(forbidden.is_empty(), "arrows that ARCHITECTURE.md does not permit:\n{}", forbidden.join("\n"));
}

#[test]
fn the_check_sees_a_forbidden_arrow() {
    assert_eq!(
        used("use crate::{render::Film, error};\nlet x = crate::solve::film();"),
        ["render", "error", "solve"]
    );
}

#[test]
fn only_io_opens_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    for file in files {
        let relative = file.strip_prefix(&root).unwrap();
        let text = fs::read_to_string(&file).unwrap();
        let library = text.split("#[cfg(test)]").next().unwrap();
        if !relative.starts_with("io") {
            assert!(!library.contains("std::fs"), "{} opens files", relative.display());
        }
        assert!(!library.contains("std::env"), "{} looks at the environment", relative.display());
    }
}
