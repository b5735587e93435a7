//! The simulation commands as people and scripts use them.

use std::path::Path;

use crate::common::{MADE_UP, bytes_of, json, printed, run, succeed, write_made_up};
use barbule::brdf::FeatherMaterial;
use serde_json::Value;

/// A campaign of a second.
const SMALL: &[&str] = &["--wavelengths", "450:650:100", "--directions", "2x2", "--instances", "3"];

#[test]
fn stores_are_the_same_bytes_whole_sharded_interrupted_or_repaired() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let simulate = |name: &str, more: &[&str]| {
        let output = path(name);
        let words = [&["simulate", "starling", "-o", &output, "--keep-fields", "550"], SMALL, more].concat();
        run(&words)
    };
    assert_eq!(simulate("a.zarr", &["--threads", "2"]).0, 0);
    let whole = bytes_of(&folder.path().join("a.zarr"));
    assert_eq!(simulate("b.zarr", &["--shard", "1/3", "--threads", "1"]).0, 0);
    let status: Value = json(&["simulate", &path("b.zarr"), "--status", "--json"]);
    assert_eq!((status["units"].as_u64(), status["done"].as_u64()), (Some(6), Some(2)));
    let missing = run(&["fit", &path("b.zarr"), "-o", &path("b.barbule")]);
    assert_eq!(missing.0, 2);
    assert!(missing.2.contains("4 of 6 units are missing"), "{}", missing.2);
    assert!(!folder.path().join("b.barbule").exists());
    for shard in ["0/3", "2/3"] {
        assert_eq!(simulate("b.zarr", &["--shard", shard]).0, 0);
    }
    assert_eq!(whole, bytes_of(&folder.path().join("b.zarr")));

    // A lost chunk, a damaged chunk, and what a killed writer leaves.
    let chunk = |name: &str| folder.path().join("b.zarr").join(name);
    std::fs::remove_file(chunk("digest/c.0.0.0")).unwrap();
    let damaged = chunk("u/c.1.1.0.0.0");
    let mut bytes = std::fs::read(&damaged).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&damaged, bytes).unwrap();
    std::fs::create_dir(folder.path().join("b.zarr/.aside")).unwrap();
    std::fs::write(folder.path().join("b.zarr/.aside/new-dead"), b"half").unwrap();
    let status = printed(&["simulate", &path("b.zarr"), "--status"]);
    assert!(status.contains("4 of 6 units done, 1 missing, 1 damaged"), "{status}");
    let (code, _, message) = simulate("b.zarr", &[]);
    assert_eq!(code, 0);
    assert!(message.contains("1 damaged units were computed again"), "{message}");
    assert_eq!(whole, bytes_of(&folder.path().join("b.zarr")));
    let (code, _, message) = simulate("b.zarr", &[]);
    assert_eq!(code, 0);
    assert!(message.contains("nothing to do"));

    // Other readers find values by the coordinates.
    std::fs::remove_file(chunk("wavelength/c.0")).unwrap();
    std::fs::write(chunk("lag/c.0"), b"cut").unwrap();
    let lost = "missing or damaged coordinates: wavelength, lag";
    let status = printed(&["simulate", &path("b.zarr"), "--status"]);
    assert!(status.contains("6 of 6 units done") && status.contains(lost), "{status}");
    let status: Value = json(&["simulate", &path("b.zarr"), "--status", "--json"]);
    assert_eq!(status["damaged_coordinates"], serde_json::json!(["wavelength", "lag"]));
    let fitted = run(&["fit", &path("b.zarr"), "-o", &path("b.barbule")]);
    assert!(fitted.0 == 0 && fitted.2.contains(lost), "{}", fitted.2);
    let (code, _, message) = simulate("b.zarr", &[]);
    assert!(code == 0 && message.contains(lost) && !message.contains("nothing to do"), "{message}");
    assert_eq!(whole, bytes_of(&folder.path().join("b.zarr")));

    let (code, _, message) = simulate("b.zarr", &["--seed", "2"]);
    assert_eq!(code, 2);
    assert!(message.contains("other parameters (campaign.seed: 1 there, 2 here)"), "{message}");
}

/// `--thin` asks for 12 instances where nobody asks for another number.
#[test]
fn instances_that_are_asked_for_are_simulated_in_thinned_campaigns_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let store = path("s.zarr");
    let thinned = ["simulate", "air/keratin:300/melanin:300/air", "--thin", "20", "-o", &store];
    let simulate = |more: &[&str]| run(&[&thinned[..], more].concat());
    assert_eq!(simulate(&["--instances", "2"]).0, 0);
    let attributes = std::fs::read_to_string(path("s.zarr/zarr.json")).unwrap();
    let attributes: Value = serde_json::from_str(&attributes).unwrap();
    let attributes = &attributes["attributes"];
    assert_eq!((&attributes["instances"], &attributes["campaign"]["instances"]), (&2.into(), &2.into()));
    let (code, _, message) = simulate(&["--instances", "2"]);
    assert!(code == 0 && message.contains("nothing to do"), "{message}");
    for (asked, count) in [(&["--instances", "20"][..], 20), (&[], 12)] {
        let (code, _, message) = simulate(asked);
        assert_eq!(code, 2, "{message}");
        assert!(message.contains(&format!("campaign.instances: 2 there, {count} here")), "{message}");
    }
    let words = ["characterize", "air/keratin:300/melanin:300/air", "--thin", "20", "--instances", "3"];
    succeed(&[&words[..], &["-o", &path("m.barbule")]].concat());
    let material = barbule::io::read_material(path("m.barbule").as_ref()).unwrap();
    assert_eq!(material.info["campaign"]["instances"], 3);
}

#[test]
fn a_strangers_bird_becomes_a_picture() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let built_in = printed(&["species", "starling:green", "--toml"]);
    let mine = built_in.replace("cortex_um = 0.32 ", "cortex_um = 0.36 ");
    assert_ne!(built_in, mine);
    std::fs::write(path("my-bird.toml"), mine).unwrap();
    succeed(&["geometry", &path("my-bird.toml"), "-o", &path("my-bird.svg")]);
    let words = ["characterize", &path("my-bird.toml"), "-o", &path("my-bird.barbule")];
    succeed(
        &[&words, &["--wavelengths", "420:660:60", "--directions", "4x4", "--instances", "4"][..]].concat(),
    );
    assert!(std::fs::metadata(path("my-bird.barbule")).unwrap().len() < 400_000);
    let quick = ["--size", "64x40", "--samples", "2"];
    let picture = ["render", "starling", "--material", &path("my-bird.barbule"), "-o", &path("my-bird.png")];
    succeed(&[&picture[..], &quick].concat());
    assert!(std::fs::read(path("my-bird.png")).unwrap().starts_with(b"\x89PNG"));
    // The shipped starling is another bird.
    let shipped = ["render", "starling", "-o", &path("shipped.png")];
    succeed(&[&shipped[..], &quick].concat());
    assert_ne!(std::fs::read(path("my-bird.png")).unwrap(), std::fs::read(path("shipped.png")).unwrap());
}

#[test]
fn simulate_then_fit_equals_characterize() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    succeed(&[&["simulate", "rock-dove", "-o", &path("s.zarr")], SMALL].concat());
    succeed(&["fit", &path("s.zarr"), "-o", &path("a.barbule")]);
    let cache = path("cache");
    let file = printed(&[&["characterize", "rock-dove", "--cache", &cache], SMALL].concat());
    assert_eq!(std::fs::read(file.trim()).unwrap(), std::fs::read(path("a.barbule")).unwrap());
    assert!(printed(&["cache", "--cache", &cache]).contains(": 1 cached"));
    succeed(&["cache", "--cache", &cache, "--clear"]);
    assert!(printed(&["cache", "--cache", &cache]).contains(": 0 cached"));
}

#[test]
fn a_strangers_crystal_goes_the_same_way_and_is_solved_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let lattice = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/lattices/square-holes.toml");
    let far = |structure: &str| {
        printed(&["far-field", structure, "--wavelength", "420", "--theta", "10", "--phi=-30", "--json"])
    };
    // Alone it lies flat; the written section has it under its top.
    succeed(&["geometry", lattice, "-o", &path("flat.json")]);
    assert_eq!(far(lattice), far(&path("flat.json")));
    succeed(&["geometry", "magpie", "--instance", "2", "-o", &path("magpie.json")]);
    let instance = ["far-field", "magpie", "--instance", "2", "--wavelength", "420", "--theta", "10"];
    let instance = printed(&[&instance[..], &["--phi=-30", "--json"]].concat());
    assert_eq!(far(&path("magpie.json")), instance);

    let cache = path("cache");
    let make = |name: &str| {
        let words = ["simulate", "peafowl", "-v", "--cache", &cache, "-o", &path(name)];
        let (code, _, message) = run(&[&words[..], SMALL].concat());
        assert_eq!(code, 0, "{message}");
        (message, bytes_of(&folder.path().join(name)))
    };
    let (first, again) = (make("a.zarr"), make("b.zarr"));
    assert!(!first.0.contains("in the cache") && again.0.contains("in the cache"), "{}", again.0);
    assert!(first.1 == again.1);
    // A damaged table is made anew.
    let table = bytes_of(&folder.path().join("cache")).into_keys().next().unwrap();
    let table = folder.path().join("cache").join(table);
    let mut bytes = std::fs::read(&table).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&table, bytes).unwrap();
    let third = make("c.zarr");
    assert!(!third.0.contains("in the cache") && third.1 == first.1);
    assert!(printed(&["cache", "--cache", &cache]).contains(": 1 cached"));
}

/// A shipped species with layers and one with a crystal, made again at a few of their nodes: what ships is what the program
/// computes.
#[test]
fn the_shipped_materials_are_what_the_command_makes() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    for (species, stem) in [("starling", "starling-green"), ("magpie", "magpie-violet")] {
        // Nodes that the shipped tables have too: cosines 0.5 and 1, two wavelengths, all 50 instances.
        let words = ["characterize", species, "-o", &path(stem), "--cache", &path("cache")];
        succeed(&[&words[..], &["--wavelengths", "300,524", "--directions", "2x2"]].concat());
        let thinned = barbule::io::read_material(path(stem).as_ref()).unwrap();
        let shipped = barbule::io::decode_material(barbule_birds::material(stem).unwrap()).unwrap();
        let parameters = |m: &FeatherMaterial| m.info["campaign"]["structure"]["parameters"].clone();
        assert_eq!(parameters(&thinned), parameters(&shipped));
        for (w, wavelength) in [(0, 0), (1, 28)] {
            for theta in 0..2 {
                for phi in 0..2 {
                    let a = thinned.axes.index(w, theta, phi);
                    let b = shipped.axes.index(wavelength, 10 * theta + 9, 10 * phi + 9);
                    let pairs = [
                        (thinned.sets[0].reflected(a) as f32, shipped.sets[0].reflected(b) as f32, 1e-4),
                        (thinned.sets[0].mean[0].m[a], shipped.sets[0].mean[0].m[b], 1e-3),
                        // Fitted beside slopes, which a campaign of two wavelengths tells otherwise.
                        (thinned.sets[0].steady.share[a], shipped.sets[0].steady.share[b], 5e-2),
                        (thinned.sets[0].length[a], shipped.sets[0].length[b], 5e-3),
                    ];
                    for (x, y, tolerance) in pairs {
                        assert!((x - y).abs() < tolerance, "{stem} {w} {theta} {phi}: {x} {y}");
                    }
                }
            }
        }
    }
}

#[test]
fn far_fields_follow_the_contract() {
    let words = ["far-field", "starling", "--wavelength", "520", "--theta", "20", "--phi=-30", "--json"];
    let fast: Value = json(&words);
    let azimuths = fast["phi_out_deg"].as_array().unwrap();
    assert_eq!((azimuths.len(), azimuths[0].as_f64()), (400, Some(-89.775)));
    assert!(fast["incident_power"].as_f64().unwrap() > 0.0);
    let direct: Value = json(&[&words[..], &["--solver", "direct"]].concat());
    for polarization in ["polarization_1", "polarization_2"] {
        let fraction = |v: &Value| v[polarization]["reflected_fraction"].as_f64().unwrap();
        assert!((fraction(&fast) / fraction(&direct) - 1.0).abs() < 1e-9);
        let intensity = fast[polarization]["intensity"][200].as_f64().unwrap();
        let norm = |key: &str| {
            let z = &fast[polarization][key][200];
            z[0].as_f64().unwrap().powi(2) + z[1].as_f64().unwrap().powi(2)
        };
        assert!((intensity - norm("e1") - norm("e2")).abs() < 1e-12 * intensity.max(1.0));
    }
    let plane: Value = json(&[&words[..], &["--window", "none"]].concat());
    assert!(plane["incident_power"].is_null());
}

#[test]
fn spectra_are_tables_and_figures() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let words =
        ["spectrum", "starling", "--angle", "0,40", "--instances", "3", "--wavelengths", "400:700:50"];
    succeed(&[&words[..], &["-o", &path("s.svg"), "--csv", &path("s.csv")]].concat());
    let csv = std::fs::read_to_string(path("s.csv")).unwrap();
    assert!(csv.starts_with("angle_deg,wavelength_nm,mean,std\n0,400,"));
    assert_eq!(csv.lines().count(), 1 + 2 * 7);
    assert!(std::fs::read_to_string(path("s.svg")).unwrap().contains("<svg"));
    assert!(Path::new(&path("s.csv.json")).exists());
    // All that is reflected falls into the cone of 90° about a mirror direction along z.
    let total: Value = json(&[&words[..], &["--json"]].concat());
    let cone: Value = json(&[&words[..], &["--collect", "cone:90", "--json"]].concat());
    assert_eq!(total["mean"][0], cone["mean"][0]);
}

#[test]
fn refusals_are_one_sentence_with_exit_code_2_and_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("s.zarr").to_string_lossy().into_owned();
    let file = folder.path().join("m.barbule").to_string_lossy().into_owned();
    let nowhere = folder.path().join("no/where.zarr").to_string_lossy().into_owned();
    let here = folder.path().to_string_lossy().into_owned();
    let other = tempfile::tempdir().unwrap();
    std::fs::write(other.path().join("mine.txt"), "x").unwrap();
    let occupied = other.path().to_string_lossy().into_owned();
    let far = ["far-field", "starling", "--wavelength", "520", "--theta", "0", "--phi", "0"];
    let with = |more: &[&'static str]| [&far[..], more].concat();
    let simulate = |more: &[&'static str]| {
        let mut words = vec!["simulate", "starling", "-o", "STORE"];
        words.extend_from_slice(more);
        words
    };
    let cases: Vec<(Vec<&str>, &str)> = vec![
        (with(&["--solver", "full-wave", "--memory", "100M"]), "this full wave needs"),
        (with(&["--solver", "full-wave", "--elements", "1"]), "from 4 to 200"),
        (with(&["--azimuths", "1"]), "from 2 to 100000"),
        (with(&["--azimuths", "100001"]), "from 2 to 100000"),
        (
            vec!["far-field", "starling", "--wavelength", "299", "--theta", "0", "--phi", "0"],
            "outside 300 to 830",
        ),
        (vec!["far-field", "starling", "--wavelength", "x", "--theta", "0", "--phi", "0"], "not a number"),
        (vec!["far-field", "starling", "--wavelength", "500", "--theta", "90", "--phi", "0"], "past grazing"),
        (vec!["far-field", "starling", "--wavelength", "500", "--theta", "0", "--phi=-90"], "past grazing"),
        (vec!["far-field", "sparrow", "--wavelength", "500", "--theta", "0", "--phi", "0"], "sparrow"),
        (vec!["spectrum", "1.5/keratin:300/air"], "comes through 1.5"),
        (vec!["spectrum", "starling", "--collect", "cone"], "cone:5"),
        (vec!["spectrum", "starling", "--collect", "cone:0"], "cone:5"),
        (vec!["spectrum", "starling", "--polarization", "3"], "write mean, 1 or 2"),
        (vec!["spectrum", "starling", "--instances", "0"], "from 1 to 10000"),
        (vec!["spectrum", "starling", "--angle", "89:91:1"], "past grazing"),
        (vec!["spectrum", "starling", "--measured", "no.csv"], "no such file"),
        (vec!["spectrum", "starling", "-o", "s.eps"], ".svg, .pdf or .png"),
        (simulate(&["--directions", "20"]), "NxM"),
        (simulate(&["--directions", "1x20"]), "NxM"),
        (simulate(&["--instances", "0"]), "from 1 to 10000"),
        (simulate(&["--tilt", "31"]), "from 0 to 30"),
        (simulate(&["--thin", "0"]), "from 1 to 20"),
        (simulate(&["--shard", "2/2"]), "0 <= i < n"),
        (simulate(&["--shard", "-1/2"]), "--shard"),
        (simulate(&["--simd", "avx1024"]), "not one of this processor's"),
        (simulate(&["--wavelengths", "900"]), "outside 300 to 830"),
        (simulate(&["--keep-fields", "401"]), "does not simulate"),
        (vec!["simulate", "starling", "-o", &nowhere], "does not exist"),
        (vec!["simulate", "starling", "-o", &occupied], "not a campaign store"),
        (vec!["simulate", "starling"], "--output"),
        (vec!["simulate", &nowhere, "--status"], "no such store"),
        (vec!["fit", &nowhere, "-o", &file], "no such store"),
        (vec!["fit", &here, "-o", &file], "not a campaign store"),
        (vec!["characterize", "starling", "-o", &file, "--sigma", "2"], "between 0.002 and 0.25"),
        (vec!["characterize", "starling", "-o", &here], "is a folder"),
        (vec!["characterize", "starling", "-o", &file, "--keep-store", &nowhere], "no such folder"),
        (vec!["characterize", "nobody.toml", "-o", &file], "no such file"),
    ];
    for (words, expected) in cases {
        let words: Vec<&str> =
            words.into_iter().map(|w| if w == "STORE" { store.as_str() } else { w }).collect();
        let (code, out, message) = run(&words);
        assert_eq!(code, 2, "{words:?}: {message}");
        assert!(message.contains(expected), "{words:?}: {message}");
        assert!(message.trim().len() < 700 && out.is_empty(), "{words:?}: {message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn every_picture_of_a_material_is_drawn_from_the_material_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (material, figure) = (path("a.barbule"), path("a.svg"));
    succeed(&[&["characterize", "starling:teal", "-o", &material, "--quiet"], SMALL].concat());
    for (flag, words) in [
        ("--parameters", &["m_eff", "cosθ_i"][..]),
        ("--fits", &["U (simulated)", "steady part", "550 nm"]),
        ("--fields", &["the pattern shifts", "the pattern stretches", "√U′ R"]),
        ("--noise", &["single barbules", "mean of all", "power spectrum"]),
        ("--instances=2", &["instance 0", "instance 1", "simulated barbules", "synthesized barbules"]),
    ] {
        succeed(&["lobes", &material, flag, "-o", &figure, "--quiet"]);
        let text = std::fs::read_to_string(&figure).unwrap();
        for word in words {
            assert!(text.contains(word), "{flag}: {word}");
        }
        // Pictures inside are base64, which may spell anything.
        assert!(flag.starts_with("--instances") || !text.contains("NaN"), "{flag}");
    }
    // A made-up material has no barbules: what does not need them is drawn.
    write_made_up();
    for flag in ["--fields", "--fits"] {
        let (code, _, message) = run(&["lobes", MADE_UP, flag, "-o", &figure]);
        assert_eq!(code, 2);
        assert!(message.contains("cannot be made again") && message.len() < 600, "{message}");
    }
    let (code, _, message) = run(&["lobes", MADE_UP, "--noise", "-o", &figure]);
    assert!(code == 0 && message.contains("no single barbules"), "{message}");
}
