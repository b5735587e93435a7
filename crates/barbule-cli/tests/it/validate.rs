//! `barbule validate`: both simulations of one section, in figures and numbers.

use serde_json::{Value, json};

fn command(words: &[&str]) -> (bool, String, String) {
    let output = assert_cmd::cargo::cargo_bin_cmd!("barbule").args(words).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.success(), text(output.stdout), text(output.stderr))
}

/// A flat film 4 µm wide reflects by the fast simulation as by Maxwell's equations, but for its ends.
#[test]
fn a_flat_film_is_the_same_by_both() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let line = |z: f64| json!({"x": [-2.0, 0.0, 2.0], "z": [z, z, z]});
    let section = json!({
        "barbule": 1, "units": "um", "width": 4.0, "name": "a film",
        "boundaries": [line(0.0), line(-0.5)], "media": ["air", "keratin", "air"], "source": "a test"
    });
    std::fs::write(path("film.json"), section.to_string()).unwrap();
    let out = path("out");
    let words = ["validate", &path("film.json"), "--full-wave", "--wavelengths", "500,600", "-o", &out];
    let (done, table, said) = command(&words);
    assert!(done, "{said}");
    assert!(table.contains("power error") && said.contains("unknowns"), "{table}{said}");
    let numbers: Value =
        serde_json::from_slice(&std::fs::read(format!("{out}/numbers.json")).unwrap()).unwrap();
    let normal = &numbers["incidences"][0];
    assert_eq!((&normal["phi_deg"], numbers["width_um"].as_f64()), (&json!(0.0), Some(4.0)));
    for case in normal["wavelengths"].as_array().unwrap() {
        let value = |key: &str| case[key].as_f64().unwrap();
        assert!(value("pattern_correlation") > 0.99, "{case}");
        assert!(value("power_error").abs() < 0.1, "{case}");
        assert!(value("absorbed_full_wave").abs() < 1e-6, "keratin does not absorb");
    }
    assert!(normal["delta_e_2000"].as_f64().unwrap() < 5.0);
    for name in ["colours.svg", "curves-0-500nm.svg", "curves-60-600nm.svg"] {
        assert!(std::fs::read_to_string(format!("{out}/{name}")).unwrap().starts_with("<svg"), "{name}");
    }
}

/// Numbers without what made them and how long it took.
fn timeless(mut value: Value) -> Value {
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
    let film = |name: &str, depth: f64| {
        let line = |z: f64| json!({"x": [-1.0, 0.0, 1.0], "z": [z, z, z]});
        let section = json!({
            "barbule": 1, "units": "um", "width": 2.0, "name": "a film",
            "boundaries": [line(0.0), line(-depth)], "media": ["air", "keratin", "air"], "source": "a test"
        });
        std::fs::write(path(name), section.to_string()).unwrap();
    };
    film("film.json", 0.4);
    film("thicker.json", 0.5);
    let run = |section: &str, nm: &str, out: &str| -> (Value, String) {
        let words = ["validate", &path(section), "--full-wave", "--wavelengths", nm, "-o", &path(out)];
        let (done, _, said) = command(&words);
        assert!(done, "{said}");
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
    let cases: [(&[&str], &str); 12] = [
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
        (&["validate", "starling"], "--full-wave"),
        (&["validate", "starling", "--full-wave", "--three-d"], "cannot be used with"),
        (&["validate", "starling", "--full-wave", "--invariant"], "cannot be used with"),
        (&["validate", "starling", "--full-wave", "--length", "9"], "give it with --three-d"),
        (&["validate", "starling", "--three-d", "--instances", "0"], "--instances"),
        (&["validate", "starling", "--three-d", "--roughness", "0.3"], "half the shorter correlation length"),
        (
            &["validate", "starling", "--three-d", "--memory", "50M", "--length", "1000"],
            "this comparison needs",
        ),
    ];
    for (words, expected) in cases {
        let (done, _, said) = command(&[words, &["-o", &out]].concat());
        assert!(!done && said.contains(expected), "{words:?}: {said}");
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
        let (done, table, said) =
            command(&[&asked[..], &["--width", "8", "--length", "16", "-o", &out], more].concat());
        assert!(done, "{said}");
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
    let (kept, _, said) = command(
        &[
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
        .concat(),
    );
    assert!(kept && said.contains("6 of 6 far fields are there from before"), "{said}");
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
