//! The geometry and species commands on files.

use std::path::Path;

use crate::common::run;

#[test]
fn pictures_and_sections_are_written_and_sections_round_trip() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    for structure in ["rock-dove", "hummingbird", "air/keratin:595/air"] {
        for name in ["a.svg", "a.pdf", "a.png", "a.json"] {
            let (code, _, message) = run(&["geometry", structure, "-o", &file(name)]);
            assert_eq!(code, 0, "{structure} {name}: {message}");
            assert!(std::fs::metadata(file(name)).unwrap().len() > 100);
        }
        run(&["geometry", &file("a.json"), "-o", &file("b.json")]);
        assert_eq!(std::fs::read(file("a.json")).unwrap(), std::fs::read(file("b.json")).unwrap());
    }
}

#[test]
fn examples_are_structures() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    for name in ["granules.json", "small-hummingbird.toml"] {
        let (code, text, message) = run(&["geometry", &examples.join(name).to_string_lossy(), "--json"]);
        assert_eq!(code, 0, "{message}");
        assert!(text.starts_with('{'));
    }
}

#[test]
fn refusals_are_one_sentence_with_exit_code_2_and_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("x.svg").to_string_lossy().into_owned();
    for (words, expected) in [
        (vec!["geometry", "starling", "--three-d", "--roughness", "0.4", "-o", &output], "half the shorter"),
        (vec!["geometry", "starling"], "say where to write"),
        (vec!["geometry", "starling", "-o", "x.eps"], ".svg, .pdf, .png or .json"),
        (vec!["geometry", "air/keratin:5/air", "--instance", "3", "-o", &output], "no instance 3"),
        (vec!["geometry", "starling:cyan", "-o", &output], "no variant 'cyan'"),
        (vec!["species", "starlin"], "did you mean 'starling'"),
    ] {
        let (code, out, message) = run(&words);
        assert_eq!((code, out.as_str()), (2, ""), "{words:?}: {message}");
        assert!(message.contains(expected) && message.lines().count() == 1, "{words:?}: {message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn printed_species_files_are_structures() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    let (_, text, _) = run(&["species", "rock-dove", "--toml"]);
    std::fs::write(&path, text).unwrap();
    let (code, out, message) = run(&["geometry", &format!("{}:purple", path.display()), "--json"]);
    assert_eq!(code, 0, "{message}");
    assert!(out.contains("rock-dove:purple 0"));
}
