//! `barbule export`: files that other programs read, and what they say of themselves.

use barbule::io::image::{Meaning, decode_picture};
use serde_json::Value;

use crate::common::run_in;

/// What is said of a file is true of it, and a scene shows it as bright as the barbules that it was made of.
#[test]
fn a_bsdf_comes_back_as_a_surface() {
    let folder = tempfile::tempdir().unwrap();
    let words = ["export", "starling", "--to", "bsdf-rgb", "-o", "s.bsdf", "--size", "3", "--json"];
    let (code, out, message) = run_in(folder.path(), &words);
    assert_eq!(code, 0, "{message}");
    let said: Value = serde_json::from_str(&out).unwrap();
    let number = |key: &str| said[key].as_f64().unwrap();
    assert_eq!(number("bytes"), std::fs::metadata(folder.path().join("s.bsdf")).unwrap().len() as f64);
    assert!(number("bytes") < 3e6 && number("relative_l1") < 0.1 && number("delta_e") < 1.0, "{said}");
    assert!(message.contains("MB") && message.contains("ΔE00"), "{message}");

    let scene = "preset = \"starling\"\nshows_feather = false\nexposure = 0.3\nsize = [48, 48]\n[camera]\nwidth_mm = 4.0\ntarget_mm = [0, 0, 0]\n\
         [[objects]]\nsphere_mm = 1.5\nsurface = \"it\"\n[surfaces.it]\n";
    let mean = |name: &str, surface: &str| {
        let toml = format!("{name}.toml");
        std::fs::write(folder.path().join(&toml), format!("{scene}{surface}")).unwrap();
        let picture = format!("{name}.png");
        let words = ["render", &toml, "--samples", "64", "-o", &picture, "--quiet"];
        let (code, _, message) = run_in(folder.path(), &words);
        assert_eq!(code, 0, "{message}");
        let bytes = std::fs::read(folder.path().join(&picture)).unwrap();
        let (image, _) = decode_picture(&picture, &bytes, Meaning::Colour).unwrap();
        image.pixels.iter().flatten().map(|value| f64::from(*value)).sum::<f64>()
    };
    let measured = mean("measured", "type = \"measured\"\nfile = \"s.bsdf\"\n");
    let barbules = mean(
        "barbules",
        "type = \"barbule\"\nmaterial = \"starling\"\nuv_mm = [6.0, 3.0]\nwidth_um = 20.0\ncell_um = 20.0\n",
    );
    // The file's own error, and that these barbules are some and not all.
    assert!((measured / barbules - 1.0).abs() < 0.08, "{measured} {barbules}");
}

#[test]
fn what_cannot_be_exported_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |words: &[&str]| {
        let (code, _, message) = run_in(folder.path(), words);
        assert_eq!(code, 2, "{message}");
        assert!(!folder.path().join("x.bsdf").exists());
        message
    };
    let export =
        |more: &[&str]| refused(&[&["export", "starling", "-o", "x.bsdf", "--to", "bsdf"], more].concat());
    assert!(export(&["--size", "0"]).contains("--size 0: give 1 to 2000 MB"));
    assert!(export(&["--size", "1"]).contains("MB at least"));
    assert!(export(&["--memory", "100MB"]).contains("a smaller --size"));
    assert!(
        refused(&["export", "starlin", "--to", "bsdf", "-o", "x.bsdf"]).contains("did you mean 'starling'")
    );
    assert!(refused(&["export", "starling", "--to", "bsfd", "-o", "x.bsdf"]).contains("bsdf"));
    std::fs::write(folder.path().join("bad.bsdf"), b"tensor_file\0\x01\0\xff\xff").unwrap();
    let scene = "preset = \"starling\"\nshows_feather = false\n[[objects]]\nsphere_mm = 1.5\nsurface = \"it\"\n[surfaces.it]\ntype = \"measured\"\nfile = \"bad.bsdf\"\n";
    std::fs::write(folder.path().join("s.toml"), scene).unwrap();
    assert!(refused(&["render", "s.toml", "-o", "x.png"]).contains("bad.bsdf"));
}

/// Films say how far their format is off at each angle; other stacks and barbules are refused with a way out.
#[test]
fn films_are_exported_and_barbules_are_told_where_to_go() {
    let folder = tempfile::tempdir().unwrap();
    for (format, file) in [("gltf", "film.gltf"), ("openpbr", "film.mtlx")] {
        let words =
            ["export", "air/keratin:595/air", "--to", format, "-o", file, "--json", "--without", "shaft"];
        let (code, out, message) = run_in(folder.path(), &words);
        assert_eq!(code, 0, "{message}");
        assert!(message.contains("--without has no effect here: only scenes"), "{message}");
        let document: Value = serde_json::from_str(&out).unwrap();
        let angles = document["details"]["angles"].as_array().unwrap();
        assert_eq!(angles.len(), 6);
        assert!(angles.iter().all(|row| row["delta_e"].as_f64().unwrap() < 10.0), "{document}");
        assert!(document["delta_e"].as_f64().unwrap() < 6.0 && folder.path().join(file).exists());
    }
    for (what, word) in [("starling", "no barbules"), ("air/melanin:99/keratin:100/air", "barbule_film")] {
        let (code, _, message) = run_in(folder.path(), &["export", what, "--to", "gltf", "-o", "x.gltf"]);
        assert!(code == 2 && message.contains(word), "{message}");
    }
    assert!(!folder.path().join("x.gltf").exists());
}

/// A shader finds its table beside it, and both say what made them.
#[test]
fn a_shader_and_its_table_lie_beside_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let words = ["export", "starling", "--to", "osl", "-o", "s.osl", "--json"];
    let (code, out, message) = run_in(folder.path(), &words);
    assert_eq!(code, 0, "{message}");
    let document: Value = serde_json::from_str(&out).unwrap();
    assert!(document["relative_l1"].as_f64().unwrap() < 0.2, "{document}");
    let shader = std::fs::read_to_string(folder.path().join("s.osl")).unwrap();
    assert!(shader.contains("string Table = \"s.exr\"") && shader.contains("// material_hash: "), "{shader}");
    assert!(folder.path().join("s.exr").exists());
}
