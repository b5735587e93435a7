//! Which presets there are, what mistyped names are told, and in which of them a bird of one's own is shown.

use std::path::Path;

use serde_json::Value;

use crate::common::{Ends as _, Ran, program, said_by};

fn render(folder: &Path, words: &[&str]) -> Ran {
    program().arg("render").args(words).current_dir(folder).ran()
}

#[test]
fn the_list_of_presets_says_what_each_shows() {
    let folder = tempfile::tempdir().unwrap();
    let (code, list, _) = render(folder.path(), &["--list"]);
    assert_eq!(code, 0);
    let line = list.lines().find(|line| line.starts_with("starling-feather ")).unwrap();
    assert!(
        line.ends_with("A starling's breast feather, whole: lanceolate, glossy, with a buff tip"),
        "{line}"
    );
    let (_, json, _) = render(folder.path(), &["--list", "--json"]);
    let json: Vec<Value> = serde_json::from_str(&json).unwrap();
    assert_eq!(json.len(), list.lines().count());
    let (_, help, _) = render(folder.path(), &["--help"]);
    for preset in &json {
        let (name, about) = (preset["name"].as_str().unwrap(), preset["about"].as_str().unwrap());
        assert!(list.contains(about) && help.contains(name), "{name}");
        let (code, toml, _) = render(folder.path(), &[name, "--toml"]);
        assert!(code == 0 && toml.starts_with('#'), "{name}");
    }
    let (_, json, _) = render(folder.path(), &["starling", "--toml", "--json"]);
    let json: Value = serde_json::from_str(&json).unwrap();
    assert!(json["camera"]["width_mm"].is_number() && json["light"].is_object(), "{json}");
    assert_eq!(render(folder.path(), &["--list", "starling"]).0, 2);
    assert_eq!(render(folder.path(), &["-o", "a.png"]).0, 2);
}

#[test]
fn mistyped_names_are_offered_presets_species_and_files() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("grey.toml"), "preset = 'starling'\n").unwrap();
    std::fs::create_dir(folder.path().join("birds")).unwrap();
    std::fs::write(folder.path().join("birds/coel.barbule"), "x").unwrap();
    for (typed, expected) in [
        (
            "starling-feathers",
            "there is no preset, species or file 'starling-feathers', did you mean 'starling-feather'?",
        ),
        ("magpye", "did you mean 'magpie'?"),
        ("grey.tml", "grey.tml: no such file, did you mean 'grey.toml'?"),
        ("gray.toml", "gray.toml: no such file, did you mean 'grey.toml'?"),
        ("grey", "no preset, species or file 'grey', did you mean 'grey.toml'?"),
        ("birds/coel.barbul", "no such file, did you mean 'birds/coel.barbule'?"),
        ("zebra.toml", "zebra.toml: no such file"),
        ("qqqqqqq", "(presets are rock-dove, starling,"),
    ] {
        let (code, _, said) = render(folder.path(), &[typed, "-o", "a.png"]);
        assert_eq!((code, said.trim().lines().count()), (2, 1), "{typed}: {said}");
        assert!(said.contains(expected) && said.len() < 600, "{typed}: {said}");
    }
    // Structures are no presets.
    let words = ["spectrum", "grey.tml"];
    let output = program().args(words).current_dir(folder.path()).output().unwrap();
    assert!(said_by(&output).contains("grey.tml: no such file, did you mean 'grey.toml'?"));
}

/// What is printed of the scene in which a file's bird is shown.
fn scene_of(folder: &Path, species: &str) -> toml::Table {
    std::fs::write(folder.join("mine.toml"), species).unwrap();
    let (code, text, said) = render(folder, &["mine.toml", "--toml"]);
    assert_eq!(code, 0, "{said}");
    toml::from_str(&text).unwrap()
}

#[test]
fn a_species_file_chooses_the_close_up_that_suits_it() {
    let folder = tempfile::tempdir().unwrap();
    let scene = |name: &str| -> toml::Table {
        let (_, text, _) = render(folder.path(), &[name, "--material", "mine.toml", "--toml"]);
        toml::from_str(&text).unwrap()
    };
    let starling = barbule::structure::species_toml("starling").unwrap();
    let mine = starling.replacen("name = \"starling\"", "name = \"coeligena\"", 1);
    // By its generator, exposed by what it shows: the preset's own exposure is for another bird.
    let by_generator = scene_of(folder.path(), &mine);
    assert_eq!(by_generator["exposure"].as_str(), Some("auto"));
    assert_eq!(by_generator["camera"], scene("starling")["camera"]);
    // By its own word, as it is.
    let chosen =
        scene_of(folder.path(), &mine.replacen("generator", "preset = \"hummingbird\"\ngenerator", 1));
    let hummingbird = scene("hummingbird");
    for key in ["camera", "exposure", "light"] {
        assert_eq!(chosen[key], hummingbird[key], "{key}");
    }
    let swallow = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/species/tree-swallow.toml");
    let shown = scene_of(folder.path(), &std::fs::read_to_string(swallow).unwrap());
    assert_eq!(shown["camera"], scene("mallard")["camera"], "without the starling's pale tips");
    std::fs::write(
        folder.path().join("mine.toml"),
        mine.replacen("generator", "preset = \"humingbird\"\ngenerator", 1),
    )
    .unwrap();
    let (code, _, said) = render(folder.path(), &["mine.toml", "--toml"]);
    assert_eq!(code, 2);
    assert!(
        said.contains(
            "mine.toml: line 6: preset: there is no preset 'humingbird', did you mean 'hummingbird'?"
        ),
        "{said}"
    );
}
