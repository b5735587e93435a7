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

#[test]
fn what_cannot_be_compared_is_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out").to_string_lossy().into_owned();
    let rods = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/rods.json");
    let cases: [(&[&str], &str); 11] = [
        (&["validate", rods, "--full-wave"], "no top boundary"),
        (&["validate", rods, "--full-wave", "--width", "3"], "--width and --layers change species"),
        (&["validate", "starling", "--full-wave", "--layers", "3"], "no parameter rows"),
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
