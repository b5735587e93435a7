//! `barbule view` hands its words to the viewer, wherever that is.

#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::Command;

const PROGRAM: &str = env!("CARGO_BIN_EXE_barbule");

/// A folder with a copy of the program in it, so that what lies beside it is known.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(PROGRAM, folder.path().join("barbule")).unwrap();
    folder
}

/// A viewer that says with which words it was called.
fn viewer(folder: &Path) {
    let file = folder.join("barbule-view");
    fs::write(&file, "#!/bin/sh\nprintf '%s|' \"$@\"\nexit 7\n").unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
}

fn run(program: &Path, path: &Path, words: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(program.join("barbule")).args(words).env("PATH", path).output().unwrap();
    let [out, err] =
        [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    (output.status.code(), out, err)
}

#[test]
fn the_viewer_gets_the_words_and_gives_the_exit_code() {
    let (own, other) = (folder(), tempfile::tempdir().unwrap());
    viewer(other.path());
    let words = ["view", "air/keratin:300/air", "--screenshot", "a b.png", "--light", "-20,40", "--bench"];
    let expected = (
        Some(7),
        "air/keratin:300/air|--screenshot|a b.png|--light|-20,40|--bench|".to_owned(),
        String::new(),
    );
    assert_eq!(run(own.path(), other.path(), &words), expected, "on the PATH");
    viewer(own.path());
    assert_eq!(run(own.path(), Path::new("/nowhere"), &words), expected, "beside the program");
    assert_eq!(
        run(own.path(), Path::new("/nowhere"), &["view", "--bench", "starling"]).1,
        "--bench|starling|"
    );
    assert_eq!(run(own.path(), Path::new("/nowhere"), &["view", "--", "--help"]).1, "--help|");
}

#[test]
fn where_there_is_no_viewer_one_sentence_says_how_to_build_it() {
    let own = folder();
    let (code, out, err) = run(own.path(), Path::new("/nowhere"), &["view", "starling"]);
    assert_eq!((code, out.as_str()), (Some(2), ""));
    assert!(err.starts_with("barbule: the viewer barbule-view is neither beside"), "{err}");
    assert!(err.contains("cargo build --release -p barbule-view") && err.lines().count() == 1, "{err}");
}
