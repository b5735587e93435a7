//! `barbule validate`: both simulations of one section, in figures and numbers.

use serde_json::{Value, json};

use crate::common::run;

/// A flat film as a file: its name, and how wide and deep it is, µm.
fn write_film(path: &str, width_um: f64, depth_um: f64) {
    let half = 0.5 * width_um;
    let line = |z: f64| json!({"x": [-half, 0.0, half], "z": [z, z, z]});
    let section = json!({
        "barbule": 1, "units": "um", "width": width_um, "name": "a film",
        "boundaries": [line(0.0), line(-depth_um)], "media": ["air", "keratin", "air"], "source": "a test"
    });
    std::fs::write(path, section.to_string()).unwrap();
}

fn numbers_in(folder: &str) -> Value {
    serde_json::from_slice(&std::fs::read(format!("{folder}/numbers.json")).unwrap()).unwrap()
}

/// A flat film 5 µm wide reflects by the fast simulation as by Maxwell's equations, but for its ends.
#[test]
fn a_flat_film_is_the_same_by_both() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    write_film(&path("film.json"), 5.0, 0.5);
    let out = path("out");
    let film = path("film.json");
    let words =
        ["validate", &film, "--full-wave", "--wavelengths", "400:694:24.5", "--phi", "30,0", "-o", &out];
    let (code, table, said) = run(&words);
    assert_eq!(code, 0, "{said}");
    assert!(table.contains("power error") && said.contains("unknowns"), "{table}{said}");
    assert!(table.contains("5 µm wide, ends open, 13 wavelengths") && table.contains("-10 to 10"), "{table}");
    let numbers = numbers_in(&out);
    let normal = &numbers["incidences"][0];
    assert_eq!((&normal["phi_deg"], numbers["width_um"].as_f64()), (&json!(0.0), Some(5.0)));
    // ±λ/(πw) in the sine, at the longest wavelength.
    let end = normal["beam_range_deg"][1].as_f64().unwrap();
    assert!((end - (0.694 / (1.25 * std::f64::consts::PI)).asin().to_degrees()).abs() < 1e-9, "{end}");
    for case in normal["wavelengths"].as_array().unwrap() {
        let value = |key: &str| case[key].as_f64().unwrap();
        assert!(value("pattern_correlation") > 0.99, "{case}");
        assert!(value("power_error").abs() < 0.1, "{case}");
        assert!(value("absorbed_full_wave").abs() < 1e-6, "keratin does not absorb");
    }
    assert!(normal["delta_e"].as_f64().unwrap() < 5.0);
    for name in ["colours.svg", "spectra-30.svg", "curves-0-400nm.svg", "curves-30-694nm.svg"] {
        assert!(std::fs::read_to_string(format!("{out}/{name}")).unwrap().starts_with("<svg"), "{name}");
    }
    let lines = |name: &str| std::fs::read_to_string(format!("{out}/{name}")).unwrap().lines().count();
    assert_eq!(lines("numbers.csv"), 1 + 2 * 13);
    assert_eq!((lines("patterns.csv") - 1) % (2 * 13), 0);
    let (code, _, said) = run(&[&words[..], &["--ensemble", "2"]].concat());
    assert!(code != 0 && said.contains("has instances 0 to 0, so there is no instance 1"), "{said}");
}

/// Several individuals are compared one by one: what is printed of them are means of what is printed of each, and each is what it is
/// alone. What is done of one is kept for all.
#[test]
fn several_individuals_are_means_and_spreads_of_each() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (a, b) = (path("a"), path("b"));
    let asked = [
        "validate",
        "air/keratin:400±10%/air",
        "--full-wave",
        "--elements",
        "5",
        "--wavelengths",
        "650",
        "--phi",
        "0",
    ];
    let run = |out: &str, more: &[&str]| -> (Value, String) {
        let (code, table, said) = run(&[&asked[..], &["-o", out], more].concat());
        assert_eq!(code, 0, "{said}");
        assert!(
            table.contains("no colours") && !std::path::Path::new(out).join("colours.svg").exists(),
            "{table}"
        );
        (numbers_in(out), table + &said)
    };
    let (one, _) = run(&a, &["--instance", "1"]);
    let (three, said) = run(&a, &["--ensemble", "3"]);
    assert!(said.contains("1 of 3 individuals' wavelengths are there from before"), "{said}");
    assert!(said.contains("mean ± standard deviation of 3 individuals"), "{said}");
    let [of_three, of_one] = [&three, &three["individuals"][1]].map(|one| one["structure"].as_str().unwrap());
    assert!(of_one.starts_with(of_three) && of_one.ends_with(" 1") && !of_three.ends_with(" 0"), "{of_one}");
    let (fresh, _) = run(&b, &["--ensemble", "3"]);
    assert_eq!(timeless(three.clone()), timeless(fresh));
    assert_eq!(timeless(three["individuals"][1].clone()), timeless(one));
    for (w, of_all) in three["incidences"][0]["wavelengths"].as_array().unwrap().iter().enumerate() {
        let each: Vec<f64> = (0..3)
            .map(|k| {
                three["individuals"][k]["incidences"][0]["wavelengths"][w]["reflected_full_wave"]
                    .as_f64()
                    .unwrap()
            })
            .collect();
        let mean = each.iter().sum::<f64>() / 3.0;
        let std = (each.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 2.0).sqrt();
        assert!(std > 1e-4, "individuals differ: {each:?}");
        assert!((of_all["full"]["mean"].as_f64().unwrap() - mean).abs() < 1e-12);
        assert!((of_all["full"]["std"].as_f64().unwrap() - std).abs() < 1e-12);
    }
    let incidence = &three["incidences"][0];
    assert!(incidence["delta_e"].is_null() && incidence["beam_range_deg"][1].as_f64().unwrap() < 3.0);
    assert!(incidence["fast"]["mean"].is_f64() && incidence["full"]["std"].is_f64(), "{incidence}");
}

/// Two slabs in air are solved as such with open ends; walls and rings of 10 nm take many times the memory.
#[test]
fn layers_that_air_parts_end_freely_or_in_walls() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out").to_string_lossy().into_owned();
    let words = |ends: &'static str| {
        let asked = ["validate", "rock-dove", "--full-wave", "--width", "5", "--wavelengths", "690"];
        let more = ["--phi", "0", "--elements", "6", "--memory", "250M", "--ends", ends, "-o"];
        [&asked[..], &more].concat()
    };
    let (code, table, said) = run(&[&words("open")[..], &[&out]].concat());
    assert!(code == 0 && table.contains("ends open"), "{table}{said}");
    let numbers = numbers_in(&out);
    let changes = numbers["changes"].to_string();
    assert!(
        changes.contains("end freely in air") && changes.contains("is left out on both sides"),
        "{changes}"
    );
    let case = &numbers["incidences"][0]["wavelengths"][0];
    assert!(case["power_error"].as_f64().unwrap().abs() < 0.15, "{case}");
    let (code, _, said) = run(&[&words("closed")[..], &[&out]].concat());
    assert!(code != 0 && said.contains("this comparison needs"), "{said}");
}

/// Numbers without what made them and how long it took.
pub(crate) fn timeless(mut value: Value) -> Value {
    fn strip(value: &mut Value) {
        match value {
            Value::Object(fields) => {
                fields.retain(|key, _| !key.ends_with("seconds") && key != "speed_ratio" && key != "made");
                fields.values_mut().for_each(strip);
            }
            Value::Array(values) => values.iter_mut().for_each(strip),
            _ => {}
        }
    }
    strip(&mut value);
    value
}

/// Full waves of a wavelength are kept: the same section at more wavelengths asks for the others only, another section for all.
#[test]
fn what_was_compared_before_is_taken_from_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    write_film(&path("film.json"), 3.0, 0.4);
    write_film(&path("thicker.json"), 3.0, 0.5);
    let run = |section: &str, nm: &str, out: &str| -> (Value, String) {
        let words =
            ["validate", &path(section), "--full-wave", "--wavelengths", nm, "--phi", "0", "-o", &path(out)];
        let (code, _, said) = run(&words);
        assert_eq!(code, 0, "{said}");
        let numbers = std::fs::read(format!("{}/numbers.json", path(out))).unwrap();
        (serde_json::from_slice(&numbers).unwrap(), said)
    };
    assert!(!run("film.json", "500", "a").1.contains("from before"));
    let (resumed, said) = run("film.json", "500,600", "a");
    assert!(said.contains("1 of 2 wavelengths are there from before"), "{said}");
    let (fresh, _) = run("film.json", "500,600", "b");
    assert_eq!(timeless(resumed.clone()), timeless(fresh));
    let (again, said) = run("film.json", "500,600", "a");
    assert!(said.contains("2 of 2 wavelengths"), "{said}");
    assert_eq!(again["incidences"], resumed["incidences"]);
    let (other, said) = run("thicker.json", "500", "a");
    assert!(!said.contains("from before"), "{said}");
    assert_ne!(other["incidences"][0]["wavelengths"][0], resumed["incidences"][0]["wavelengths"][0]);
    // Nobody's unit is believed that is not whole.
    for unit in std::fs::read_dir(path("b/units")).unwrap() {
        std::fs::write(unit.unwrap().path(), "half").unwrap();
    }
    let (mended, said) = run("film.json", "500,600", "b");
    assert!(!said.contains("from before"), "{said}");
    assert_eq!(timeless(mended), timeless(resumed));
}

#[test]
fn what_cannot_be_compared_is_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out").to_string_lossy().into_owned();
    let rods = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/rods.json");
    let swallow = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/species/tree-swallow.toml");
    let cases: [(&[&str], &str); 17] = [
        (&["validate", rods, "--full-wave"], "no top boundary"),
        (&["validate", rods, "--full-wave", "--width", "3"], "--width and --layers change species"),
        (
            &["validate", "starling", "--full-wave", "--layers", "3"],
            "has neither layers nor rows that are counted",
        ),
        (
            &["validate", swallow, "--full-wave", "--layers", "2"],
            "--layers 2: tree-swallow:blue lists its layers one by one",
        ),
        (&["validate", "starling", "--full-wave", "--memory", "50M"], "this comparison needs"),
        (
            &["validate", "starling", "--full-wave", "--width", "6", "--wavelengths", "550,694"],
            "--phi: φ_i = 60°: the beam on 6 µm comes from 46° to 90° at 694 nm, more than 15° beside it; take a section from 8.9 µm on, \
             or leave this angle out",
        ),
        (&["validate", "starling", "--full-wave", "--phi=-80"], "φ_i = -80°"),
        (&["validate", "starling", "--full-wave", "--phi", "80"], "give angles below 75°"),
        (&["validate", "starling", "--three-d", "--ensemble", "2"], "cannot be used with"),
        (&["validate", "starling"], "--full-wave"),
        (&["validate", "starling", "--full-wave", "--three-d"], "cannot be used with"),
        (&["validate", "starling", "--full-wave", "--invariant"], "cannot be used with"),
        (&["validate", "starling", "--full-wave", "--length", "9"], "give it with --three-d"),
        (&["validate", "starling", "--three-d", "--instances", "0"], "--instances"),
        (&["validate", "starling", "--full-wave", "--simd", "scalar"], "cannot be used with"),
        (&["validate", "starling", "--three-d", "--roughness", "0.3"], "half the shorter correlation length"),
        (
            &["validate", "starling", "--three-d", "--memory", "50M", "--length", "1000"],
            "this comparison needs",
        ),
    ];
    for (words, expected) in cases {
        let (code, _, said) = run(&[words, &["-o", &out]].concat());
        assert!(code != 0 && said.contains(expected), "{words:?}: {said}");
        assert!(!std::path::Path::new(&out).exists());
    }
}

/// Invariant segments are what the 2.5D simulation means: the same light at the same places across, and along y nothing but the
/// window. Rough ones spread it.
#[test]
fn segments_without_roughness_are_what_invariant_barbules_are() {
    let folder = tempfile::tempdir().unwrap();
    let numbers = |name: &str, more: &[&str]| -> Value {
        let out = folder.path().join(name).to_string_lossy().into_owned();
        let asked = ["validate", "starling", "--three-d", "--instances", "2", "--wavelengths", "600"];
        let (code, table, said) =
            run(&[&asked[..], &["--width", "8", "--length", "16", "-o", &out], more].concat());
        assert_eq!(code, 0, "{said}");
        assert!(table.contains("2.5D") && said.contains("6 far fields of segments"), "{table}{said}");
        for file in ["hemispheres.svg", "across-0-30.svg", "along-30-30.svg"] {
            assert!(std::fs::read_to_string(format!("{out}/{file}")).unwrap().starts_with("<svg"), "{file}");
        }
        serde_json::from_slice(&std::fs::read(format!("{out}/numbers.json")).unwrap()).unwrap()
    };
    let value = |numbers: &Value, direction: usize, key: &str| {
        numbers["directions"][direction]["wavelengths"][0].pointer(key).unwrap().as_f64().unwrap()
    };
    let (smooth, rough) = (numbers("smooth", &["--invariant"]), numbers("rough", &[]));
    assert_eq!(numbers("smooth", &["--invariant"])["directions"], smooth["directions"]);
    let (code, _, said) =
        run(&[
            &[
                "validate",
                "starling",
                "--three-d",
                "--instances",
                "2",
                "--wavelengths",
                "600",
                "--width",
                "8",
            ][..],
            &["--length", "16", "--invariant", "-o", &folder.path().join("smooth").to_string_lossy()],
        ]
        .concat());
    assert!(code == 0 && said.contains("6 of 6 far fields are there from before"), "{said}");
    for direction in 0..3 {
        let of = |key: &str| value(&smooth, direction, key);
        assert!(of("/power_error").abs() < 0.01, "{}", of("/power_error"));
        let widths = of("/three_d/across_deviation") / of("/two_and_a_half_d/across_deviation");
        assert!((widths - 1.0).abs() < 0.01, "{widths}");
        // 0.3 % of a normal distribution lie beyond three deviations.
        assert!(of("/sigma_second_moment") < 0.005 && of("/beyond_window") < 0.01, "{smooth}");
        assert!(value(&rough, direction, "/sigma_second_moment") > 0.015, "{rough}");
    }
    assert_eq!(smooth["length_um"], json!(16.0));
}
