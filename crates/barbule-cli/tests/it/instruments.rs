//! `barbule spectrum --instrument`: what is printed, written and refused.

use std::path::Path;

use serde_json::Value;

use crate::common::{Ends as _, MADE_UP, Ran, program, write_made_up};

fn run_in(folder: &Path, words: &str) -> Ran {
    program().current_dir(folder).args(words.split(' ')).args(["--cache", "cache"]).ran()
}

fn json(folder: &Path, words: &str) -> Value {
    let (code, out, message) = run_in(folder, &format!("{words} --json --quiet"));
    assert_eq!(code, 0, "{words}: {message}");
    serde_json::from_str(&out).unwrap()
}

const FILM: &str = "spectrum air/1.56:410/air --wavelengths 380:560:2";

#[test]
fn readings_say_their_instrument_and_its_reference() {
    let folder = tempfile::tempdir().unwrap();
    let words = format!("{FILM} --instrument probe:10 --angle 0,4 --turn 0,30");
    let document = json(folder.path(), &words);
    assert_eq!((&document["instrument"], &document["reference"]), (&"probe:10".into(), &"white".into()));
    assert_eq!(document["angle_deg"], serde_json::json!([0.0, 4.0, 0.0, 4.0]));
    assert_eq!(document["turn_deg"], serde_json::json!([0.0, 0.0, 30.0, 30.0]));
    // A film mirrors into the probe what white spreads over the hemisphere: 1/sin²10° = 33 times its reflectance.
    let largest = |row: usize| {
        let row = document["mean"][row].as_array().unwrap();
        row.iter().map(|value| value.as_f64().unwrap()).fold(0.0, f64::max)
    };
    assert!((5.0..6.5).contains(&largest(0)) && largest(1) < largest(0), "{} {}", largest(0), largest(1));
    assert_eq!(document["flagged"][0][0], false);
    let (_, out, _) = run_in(folder.path(), &words);
    assert!(out.contains("air/1.56:410/air, probe:10, φ = 4°, turned by 30°: peak "), "{out}");
    let several = json(folder.path(), &format!("{FILM} --instrument sphere --instrument microscope:0.3"));
    assert_eq!(several["instrument"], serde_json::json!(["sphere", "microscope:0.3"]));
    // What differs between kinds of instruments is not the angle alone, so they follow no law together.
    let kinds = "--instrument sphere --instrument microscope:0.3 --instrument arms:30,30,5";
    assert!(json(folder.path(), &format!("{FILM} {kinds} --angle 0,10"))["law"].is_null());
    let (code, _, message) = run_in(folder.path(), &format!("{FILM} {kinds} --law law.svg"));
    assert!(code == 2 && message.contains("of several kinds make no series"), "{message}");
}

#[test]
fn the_law_of_angles_is_printed_written_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let words = format!("{FILM} --angle 0:50:10");
    let (_, out, _) = run_in(folder.path(), &words);
    assert!(
        out.lines().last().unwrap().starts_with("air/1.56:410/air: λ(θ) = λ₀ √(1 − sin²θ/n²): λ₀ = 51"),
        "{out}"
    );
    let law = &json(folder.path(), &words)["law"];
    let number = |of: &Value, key: &str| of[key].as_f64().unwrap();
    assert!((number(&law["index"], "value") - 1.56).abs() < 0.02, "{law}");
    // Intervals of exact peaks are as narrow as parabolas through samples 2 nm apart are true.
    assert!(number(&law["index"], "low") < 1.5601 && number(&law["index"], "high") > 1.5599, "{law}");
    assert!(number(&law["line"]["b_nm_per_deg"], "value") > 0.0 && law["angles"] == 6);
    // Arms that open in mirror position are at the same angles.
    let arms: Vec<String> = (0..=50).step_by(10).map(|a| format!("--instrument arms:{a},{a},1")).collect();
    let arms = json(folder.path(), &format!("{FILM} {}", arms.join(" ")));
    assert_eq!(arms["law_angle_deg"][5].as_f64().unwrap().round(), 50.0);
    assert!((number(&arms["law"]["index"], "value") - number(&law["index"], "value")).abs() < 2e-3);
    let (code, _, message) = run_in(folder.path(), &format!("{words} --law law.svg --quiet"));
    assert_eq!(code, 0, "{message}");
    let svg = std::fs::read_to_string(folder.path().join("law.svg")).unwrap();
    assert!(svg.contains("peak wavelength (nm)") && svg.contains("λ₀ = 51") && svg.contains("n = 1.5"));
    let (code, _, message) = run_in(folder.path(), &format!("{FILM} --law law.svg"));
    assert!(code == 2 && message.contains("a law needs 3 angles and here are 1"), "{message}");
    let alike = format!("{FILM} --instrument arms:20,20,5 --angle 0,1,2 --law law.svg");
    let (code, _, message) = run_in(folder.path(), &alike);
    assert!(code == 2 && message.contains("all peaks are at about 20.00° to the layers"), "{message}");
}

/// What is written as spectrometers write it is read as a measurement of as many samples.
#[test]
fn tables_of_spectrometers_are_read_back_as_measurements() {
    let folder = tempfile::tempdir().unwrap();
    let base = "spectrum starling --instances 3 --wavelengths 400:700:20 --instrument probe:20";
    let write = format!("{base} --csv s.csv --csv-layout spectrometer --individuals");
    let document = json(folder.path(), &write);
    let table = std::fs::read_to_string(folder.path().join("s.csv")).unwrap();
    assert!(table.starts_with("wavelength_nm,\"starling probe:20, φ = 0°, individual 1 (%)\","), "{table}");
    let back = json(folder.path(), &format!("{base} --measured s.csv"));
    assert_eq!(back["measured"]["samples"].as_array().unwrap().len(), 3);
    for at in 0..16 {
        let (mean, read) = (&document["mean"][0][at], &back["measured"]["mean"][at]);
        assert!((mean.as_f64().unwrap() / read.as_f64().unwrap() - 1.0).abs() < 1e-9, "{mean} {read}");
    }
    assert!(back["comparison"][0]["rmse"].as_f64().unwrap() < 1e-9);
}

#[test]
fn materials_are_read_by_instruments_alone() {
    write_made_up();
    let folder = tempfile::tempdir().unwrap();
    let words = format!("spectrum {MADE_UP} --wavelengths 450,550,650 --angle 0,10 --instrument probe:15");
    let document = json(folder.path(), &words);
    let mean = document["mean"][0][1].as_f64().unwrap();
    assert!(mean > 0.0 && mean.is_finite() && document["instances"] == 1, "{document}");
    let (code, _, message) = run_in(folder.path(), &format!("spectrum {MADE_UP}"));
    assert!(code == 2 && message.contains("made-up.barbule"), "{message}");
}

#[test]
fn what_no_instrument_does_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (more, said) in [
        ("--instrument prob:10", "--instrument: the instrument 'prob:10' is none of probe:CONE"),
        ("--instrument arms:85,0,10", "below the horizon"),
        ("--instrument arms:60,10,2 --angle 35", "the lamp is 95.0000° from its normal"),
        ("--instrument sphere --collect cone:5", "cannot be used with"),
        ("--turn 10", "--instrument"),
        ("--instrument sphere --tilt 40", "give standard deviations from 0 to 30 degrees"),
        ("--instrument sphere --tilt 1,2,3", "give one standard deviation"),
        ("--instrument sphere --turn 400", "400° is more than a whole turn"),
    ] {
        let (code, _, message) = run_in(folder.path(), &format!("{FILM} {more}"));
        assert!(code == 2 && message.contains(said), "{more}: {message}");
    }
}
