//! `barbule species`: copies that are edited count, names as people write them, and files of every kind.

use barbule::fields::parse_toml;
use serde_json::Value;

use crate::common::{json, printed, run, succeed};

fn document(words: &[&str]) -> Value {
    json(&[words, &["--json"]].concat())
}

#[test]
fn an_unchanged_copy_reflects_the_same_and_an_edited_one_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("swallow.toml").to_string_lossy().into_owned();
    let copy = printed(&["species", "starling:pink", "--toml"]);
    assert!(!copy.contains("variants") && copy.contains("name = \"my-starling\""), "{copy}");
    let spectrum = |structure: &str| {
        let words = ["spectrum", structure, "--wavelengths", "450,600", "--instances", "3"];
        document(&words)["mean"].clone()
    };
    std::fs::write(&path, &copy).unwrap();
    assert_eq!(spectrum(&path), spectrum("starling:pink"));
    std::fs::write(&path, copy.replace("cortex_um = 0.38 ", "cortex_um = 0.2 ")).unwrap();
    assert_ne!(spectrum(&path), spectrum("starling:pink"));
    std::fs::write(&path, copy.replace("cortex_um = 0.38 ", "cortex_um = 200 ")).unwrap();
    let (code, _, message) = run(&["spectrum", &path]);
    assert_eq!(code, 2);
    let expected = "swallow.toml: line 16: parameters.cortex_um is 200, outside 0.001 to 10; did you mean 0.2 (200 nm)?\n";
    assert!(message.ends_with(expected), "{message}");
}

#[test]
fn an_edit_that_variants_would_hide_is_refused_with_both_lines() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml").to_string_lossy().into_owned();
    let whole = printed(&["species", "starling", "--toml"]);
    std::fs::write(&path, whole.replace("[parameters]", "[parameters]\ncortex_um = 0.2")).unwrap();
    let (code, out, message) = run(&["species", &path]);
    assert_eq!((code, out.as_str()), (2, ""));
    let expected = "parameters.cortex_um (line 13) has no effect on variant 'aqua', which gives cortex_um too (line 28); keep it in";
    assert!(message.contains(expected), "{message}");
}

#[test]
fn files_are_printed_as_toml_or_as_json_of_the_same_content() {
    let toml = parse_toml(&printed(&["species", "magpie:blue", "--toml"])).unwrap();
    let json = document(&["species", "magpie:blue", "--toml"]);
    assert_eq!(toml, json);
    assert_eq!(json["parameters"]["period_um"], 0.19);
    let whole = parse_toml(&printed(&["species", "magpie", "--toml"])).unwrap();
    assert_eq!(whole["variants"].as_array().unwrap().len(), 8);
}

#[test]
fn species_are_known_by_the_names_that_people_use() {
    let listed = document(&["species", "Sturnus vulgaris:pink"]);
    let entry = &listed["species"][0];
    assert_eq!((&entry["name"], &entry["latin"]), (&"starling".into(), &"Sturnus vulgaris".into()));
    assert!(entry["source"].as_str().unwrap().contains("Freyer et al. 2021"));
    assert_eq!((&entry["generator"], &entry["default"]), (&"starling".into(), &"green".into()));
    let [variant] = &entry["variants"].as_array().unwrap()[..] else { panic!("{entry}") };
    assert_eq!((&variant["name"], &variant["parameters"]["cortex_um"]), (&"pink".into(), &0.38.into()));
    for (key, low, high) in [
        ("luminous_reflectance", 0.03, 0.08),
        ("peak_nm", 400.0, 460.0),
        ("peak_reflectance", 0.05, 0.1),
        ("half_width_nm", 40.0, 120.0),
        ("mean_reflectance", 0.03, 0.08),
        ("saturation", 0.3, 2.0),
        ("purity", 0.05, 0.4),
        ("hue_deg", 300.0, 360.0),
        ("x", 0.3, 0.36),
    ] {
        let value = variant[key].as_f64().unwrap();
        assert!((low..high).contains(&value), "{key}: {value}");
    }
    // Brightened, and at its own luminance.
    assert_eq!((&variant["srgb_normalized"], &variant["srgb"]), (&"#f3b7df".into(), &"#4e3846".into()));
    let text = printed(&["species", "European-starling:pink"]);
    assert!(text.starts_with("starling (Sturnus vulgaris): a keratin thin film"), "{text}");
    assert!(text.contains("source: ") && text.contains("cortex_um = 0.38 "), "{text}");
}

#[test]
fn every_kind_of_structure_has_its_colour() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let normalized = |structure: &str| {
        let found = document(&["species", structure]);
        found["species"][0]["variants"][0]["srgb_normalized"].as_str().unwrap().to_owned()
    };
    std::fs::write(path("duck.toml"), printed(&["species", "mallard:blue", "--toml"])).unwrap();
    assert_eq!(normalized(&path("duck.toml")), normalized("mallard:blue"));
    std::fs::write(path("birds.toml"), printed(&["species", "starling", "--toml"])).unwrap();
    assert_eq!(normalized(&format!("{}:teal", path("birds.toml"))), normalized("starling:teal"));
    let stack = normalized("air/keratin:300/air");
    std::fs::write(path("stack.toml"), "stack = 'air/keratin:300/air'").unwrap();
    assert_eq!(normalized(&path("stack.toml")), stack);
    std::fs::create_dir(path("folder")).unwrap();
    succeed(&["geometry", "air/keratin:300/air", "-o", &path("folder/a.json")]);
    assert_eq!((normalized(&path("folder/a.json")), normalized(&path("folder"))), (stack.clone(), stack));
    let lattice = "[lattice]\nperiod = 0.17\ncortex = 0.26\nrows = 6\nrow_pitch = 0.15\nrow_shift = 0.5\n\
        [[lattice.rod]]\ncircles = [{ diameter = 0.13, medium = 'melanin' }]\n";
    std::fs::write(path("lattice.toml"), lattice).unwrap();
    assert_eq!(normalized(&path("lattice.toml")), normalized("mallard:blue"));
    let figure = path("swatches.svg");
    let (code, _, message) = run(&["species", &path("birds.toml"), "-o", &figure]);
    assert_eq!(code, 0);
    assert!(
        message.contains("swatches.svg: colours of starling at normal incidence, 8 swatches"),
        "{message}"
    );
}

#[test]
fn what_is_printed_fits_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml").to_string_lossy().into_owned();
    for name in ["starling:pink", "hummingbird", "peafowl:blue", "rock-dove"] {
        std::fs::write(&path, printed(&["species", name, "--toml"])).unwrap();
        for structure in [name, &path] {
            let text = printed(&["species", structure]);
            let widest = text.lines().max_by_key(|line| line.chars().count()).unwrap();
            assert!(widest.chars().count() <= 80, "{structure}: {widest}");
        }
    }
    // Parameters begin lines, and what they are stands beside them in a column of its own.
    let text = printed(&["species", "starling:pink"]);
    let key = text.lines().find(|line| line.starts_with("    cortex_um = 0.38 ")).unwrap();
    assert!(key.trim_end().len() > 40, "{key}");
}
