//! `barbule feather`: measures and geometry.

use crate::common::{json, run};

/// What is measured on the grown geometry is what was asked for, and every size has a source.
#[test]
fn measures_stand_beside_what_was_given() {
    for name in ["primary", "secondary", "tail", "covert", "contour", "osprey", "starling", "mallard"] {
        let document = json(&["feather", name, "--json"]);
        let rows = document["table"].as_array().unwrap();
        let row = |key: &str| rows.iter().find(|row| row["key"] == key).unwrap();
        for (key, share) in [
            ("length_mm", 0.002),
            ("calamus_share", 0.002),
            ("leading_spacing_um", 0.06),
            ("trailing_spacing_um", 0.06),
            ("trailing_widest_mm", 0.15),
        ] {
            let (grown, given) = (row(key)["grown"].as_f64().unwrap(), row(key)["given"].as_f64().unwrap());
            assert!((grown / given - 1.0).abs() < share, "{name}: {key} {grown} {given}");
        }
        let sources = rows.iter().filter_map(|row| row["source"].as_str());
        assert!(
            sources.clone().count() > 8
                && sources.clone().any(|text| text.contains("[R]") || text.contains("[M]"))
        );
        let coverage = row("coverage")["grown"].as_f64().unwrap();
        assert!((0.6..=1.0).contains(&coverage), "{name}: {coverage}");
    }
    let (code, text, message) = run(&["feather", "down"]);
    assert_eq!((code, message.as_str()), (0, ""));
    assert!(text.lines().next().unwrap().contains("source of what is given") && text.contains("downy barbs"));
}

#[test]
fn geometry_is_written_and_the_same_seed_gives_the_same_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    for ending in ["usda", "ply", "obj", "gltf", "pbrt", "txt"] {
        let path = file(&format!("a.{ending}"));
        let (code, out, message) = run(&["feather", "hummingbird", "--level", "barbs", "-o", &path]);
        assert_eq!((code, out.as_str()), (0, ""), "{message}");
        assert!(message.starts_with("wrote ") && message.contains("barbs, in mm"), "{message}");
        assert!(std::fs::metadata(&path).unwrap().len() > 10_000);
    }
    let written = |name: &str, seed: &str| {
        let document = json(&[
            "feather",
            "hummingbird",
            "--level",
            "barbs",
            "--seed",
            seed,
            "-o",
            &file(name),
            "--json",
        ]);
        assert_eq!((document["level"].as_str(), document["barbules"].as_u64()), (Some("barbs"), Some(0)));
        std::fs::read(file(name)).unwrap()
    };
    let first = written("a.txt", "3");
    assert_eq!(written("a.txt", "3"), first);
    assert_ne!(written("a.txt", "4"), first);
    // Few barbules are written unasked, many are not.
    assert_eq!(json(&["feather", "hummingbird", "-o", &file("b.ply"), "--json"])["level"], "barbules");
    let (code, _, message) = run(&["feather", "primary", "-o", &file("c.ply")]);
    assert!(code == 0 && message.starts_with("barbs only: with its "), "{message}");
}

#[test]
fn refusals_name_what_can_be_given_and_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    for (words, expected) in [
        (vec!["feather", "primary", "-o", &file("a.stl")], ".usda, .ply, .obj, .gltf, .pbrt or .txt"),
        (vec!["feather", "starlin", "-o", &file("a.ply")], "starlin"),
        (vec!["feather", "primary", "--level", "barbules", "-o", &file("a.ply")], "give --level barbs"),
        (vec!["feather", "primary", "-o", &file("none/a.ply")], "none"),
    ] {
        let (code, out, message) = run(&words);
        assert_eq!((code, out.as_str()), (2, ""), "{words:?}: {message}");
        assert!(message.contains(expected) && message.lines().count() == 1, "{words:?}: {message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
