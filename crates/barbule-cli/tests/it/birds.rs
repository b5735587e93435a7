//! What birds see: `barbule birds`, `see`, `--bird`, and pictures through their eyes.

use std::path::Path;

use serde_json::Value;

use crate::common::{Ends as _, MADE_UP, program, run_in, write_made_up};

fn document(folder: &Path, words: &[&str]) -> Value {
    program().args(words).arg("--json").current_dir(folder).prints_json()
}

/// A sentence that refuses.
fn refused(folder: &Path, words: &[&str]) -> String {
    let (code, out, message) = run_in(folder, &[words, &["--quiet"]].concat());
    assert!(code == 2 && out.is_empty() && message.lines().count() == 1, "{words:?}: {code} {message}");
    assert!(message.len() < 600, "{message}");
    message
}

#[test]
fn birds_are_listed_and_told_with_their_cones_and_sources() {
    let folder = tempfile::tempdir().unwrap();
    let list = document(folder.path(), &["birds"]);
    assert_eq!(list["birds"].as_array().unwrap().len(), 8);
    let starling = document(folder.path(), &["birds", "Sturnus vulgaris", "-o", "cones.svg"]);
    assert_eq!(starling["wavelength_nm"].as_array().unwrap().len(), 401);
    let cones = starling["cones"].as_array().unwrap();
    assert_eq!(
        cones.iter().map(|cone| cone["name"].as_str().unwrap()).collect::<Vec<_>>(),
        ["UV", "S", "M", "L"]
    );
    for cone in cones {
        let values: Vec<f64> =
            cone["sensitivity"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        let top = values.iter().copied().fold(0.0, f64::max);
        let at = cone["peak_nm"].as_f64().unwrap() - 300.0;
        assert!((top - 1.0).abs() < 1e-12 && (values[at as usize] - 1.0).abs() < 1e-12);
    }
    assert!(starling["source"].as_str().unwrap().contains("Hart, Partridge & Cuthill 1998"));
    let figure = std::fs::read_to_string(folder.path().join("cones.svg")).unwrap();
    assert!(figure.contains("wavelength (nm)") && figure.contains("answer to a quantum"));
    assert!(refused(folder.path(), &["birds", "starlin"]).contains("did you mean 'starling'?"));
}

/// Two made-up reflectances from 300 to 700 nm: flat, and the same with more beyond 600 nm.
fn write_two(folder: &Path) {
    let table = |value: &dyn Fn(f64) -> f64| {
        let row = |i: i32| format!("{},{}\n", 300 + 5 * i, value(f64::from(300 + 5 * i)));
        "wl,patch\n".to_owned() + &(0..=80).map(row).collect::<String>()
    };
    std::fs::write(folder.join("grey.csv"), table(&|_| 0.2)).unwrap();
    std::fs::write(folder.join("red.csv"), table(&|nm| 0.2 + 0.1 / (1.0 + ((600.0 - nm) / 10.0).exp())))
        .unwrap();
    std::fs::write(folder.join("visible.csv"), "wl,patch\n400,0.2\n550,0.3\n700,0.2\n").unwrap();
}

#[test]
fn things_are_compared_by_noise_in_two_references_and_by_brightness() {
    let folder = tempfile::tempdir().unwrap();
    write_two(folder.path());
    let words = ["see", "grey.csv", "red.csv", "--bird", "starling", "--ratio", "1,2,2,4", "--weber", "0.1"];
    let seen = document(folder.path(), &[&words[..], &["-o", "both.svg", "--csv", "pairs.csv"]].concat());
    let number = |place: &str| seen.pointer(place).unwrap().as_f64().unwrap();
    for k in 0..4 {
        assert!((number(&format!("/catches/0/{k}")) - 0.2).abs() < 1e-12);
    }
    // By the closed form of two colours that differ in M and L alone, but for what the other cones see of it.
    let difference: Vec<f64> = (0..4)
        .map(|k| (number(&format!("/catches/1/{k}")) / number(&format!("/catches/0/{k}"))).ln())
        .collect();
    let weights = [1.0, 2.0, 2.0, 4.0].map(|n: f64| n / 4.0 / 0.01);
    let mean = difference.iter().zip(weights).map(|(d, w)| d * w).sum::<f64>() / weights.iter().sum::<f64>();
    let expected = difference.iter().zip(weights).map(|(d, w)| w * (d - mean).powi(2)).sum::<f64>().sqrt();
    assert!((number("/delta_s/0/1") / expected - 1.0).abs() < 1e-9 && number("/delta_s/0/0") == 0.0);
    assert!((number("/delta_s_rarest/1/0") / expected - 2.0).abs() < 1e-9);
    assert!(number("/delta_l/0/1") > 0.5 && number("/delta_e/0/1") > 3.0);
    assert!(number("/tetrahedral/0/r") < 1e-12 && number("/tetrahedral/1/theta_deg") < 0.0);
    let table = std::fs::read_to_string(folder.path().join("pairs.csv")).unwrap();
    assert!(table.starts_with("one,other,delta_s,delta_s_rarest,delta_l,delta_e\ngrey,red,"), "{table}");
    let figure = std::fs::read_to_string(folder.path().join("both.svg")).unwrap();
    assert!(figure.contains(">UV<") && figure.contains(">grey<") && figure.contains("reflectance"));
    let idle = ["--angle", "30", "--instances", "5", "--wavelengths", "400:700:10"];
    let (_, out, said) = run_in(folder.path(), &[&words[..], &idle].concat());
    for flag in ["--angle", "--instances", "--wavelengths"] {
        assert!(said.contains(&format!("{flag} has no effect here: all that is seen is measured")), "{said}");
    }
    assert!(out.contains("grey – red: ΔS ") && out.contains("of the rarest in brackets"), "{out}");
    // Under another light white is white all the same.
    let forest = document(folder.path(), &["see", "grey.csv", "--bird", "peafowl", "--illuminant", "forest"]);
    assert!((forest["catches"][0][0].as_f64().unwrap() - 0.2).abs() < 1e-12);
}

#[test]
fn nothing_is_invented_below_what_is_known() {
    let folder = tempfile::tempdir().unwrap();
    write_two(folder.path());
    let message = refused(folder.path(), &["see", "visible.csv", "--bird", "starling"]);
    assert!(
        message.contains("visible.csv")
            && message.contains("cone UV")
            && message.contains("nothing is invented")
    );
    assert!(message.contains("--wavelengths 300:700:4"), "{message}");
    let words = ["spectrum", "starling", "--bird", "starling", "--wavelengths", "400:694:6"];
    assert!(refused(folder.path(), &words).contains("known from 400 to 694 nm"));
    let words = ["species", "starling", "--bird", "starling", "--wavelengths", "380:780:10"];
    assert!(refused(folder.path(), &words).contains("cone UV"));
    write_made_up();
    let words = [
        "render",
        "starling",
        "--material",
        MADE_UP,
        "--sensor",
        "bird:starling",
        "--size",
        "8x5",
        "-o",
        "x.png",
    ];
    assert!(refused(folder.path(), &words).contains("nothing is invented outside"));
    for (words, part) in [
        (&["--ratio", "1,2,3"][..], "3 numbers for the 4 cones"),
        (&["--weber", "0"], "--weber 0: give a number over 0"),
        (&["--illuminant", "moon"], "there is no light 'moon'"),
        (&["--angle", "0,30"], "--angle: 2 angles; give one"),
    ] {
        let words = [&["see", "grey.csv", "--bird", "starling"], words].concat();
        let message = refused(folder.path(), &words);
        assert!(message.contains(part), "{message}");
    }
    let message = refused(folder.path(), &["render", "starling", "--human", "a.png", "-o", "x.png"]);
    assert!(message.contains("--human") && message.contains("--sensor bird:NAME"), "{message}");
}

#[test]
fn spectra_and_species_say_what_birds_see_from_300_nm_on() {
    let folder = tempfile::tempdir().unwrap();
    let words =
        ["spectrum", "air/keratin:320/melanin", "--bird", "starling", "--bird", "peafowl", "--angle", "0,50"];
    let seen = document(folder.path(), &[&words[..], &["--instances", "1", "-o", "s.svg"]].concat());
    assert_eq!((&seen["wavelength_nm"][0], &seen["wavelength_nm"][100]), (&300.0.into(), &700.0.into()));
    let birds = seen["birds"].as_array().unwrap();
    assert_eq!((birds.len(), &birds[1]["illuminant"]), (2, &"D65".into()));
    assert_eq!((&birds[0]["name"], &birds[0]["title"]), (&"starling".into(), &"European starling".into()));
    assert_eq!(birds[0]["catches"].as_array().unwrap().len(), 2);
    assert_eq!(birds[0]["catches"][1].as_array().unwrap().len(), 4);
    assert!(birds[0]["tetrahedral"][0]["r"].as_f64().unwrap() > 0.01);
    // The film has a peak at 349 nm, the thicker of keratin's orders, which people do not see.
    let q = |cone: usize| birds[0]["catches"][0][cone].as_f64().unwrap();
    assert!(q(0) > 0.02 && q(0) != q(3), "{birds:?}");
    let figure = std::fs::read_to_string(folder.path().join("s.svg")).unwrap();
    assert!(figure.contains("below 350 nm keratin absorbs"), "the gap is marked");
    let words = ["species", "air/keratin:320/melanin", "--bird", "blue-tit", "-o", "swatch.svg"];
    let species = document(folder.path(), &words);
    let of = &species["species"][0]["variants"][0]["birds"][0];
    assert_eq!(of["catches"][0].as_array().unwrap().len(), 4);
    let figure = std::fs::read_to_string(folder.path().join("swatch.svg")).unwrap();
    assert!(figure.contains("what the cones UV, S, M, L of Blue tit catch"), "{figure}");
}

#[test]
fn a_bird_and_people_see_the_same_paths() {
    let folder = tempfile::tempdir().unwrap();
    let words = [
        "render",
        "starling",
        "--size",
        "24x15",
        "--samples",
        "2",
        "--exposure",
        "1",
        "--keep-gamut",
        "--background",
        "none",
    ];
    let bird = ["--sensor", "bird:starling", "--human", "human.exr", "-o", "bird.exr"];
    let report = document(folder.path(), &[&words[..], &bird].concat());
    assert_eq!(report[0]["sensor"], "European starling");
    assert_eq!(report[0]["false_colour"], "L+UV,M,S+UV");
    let read = |name: &str| {
        let image = exr::prelude::read_first_flat_layer_from_file(folder.path().join(name)).unwrap();
        let channel = |name: &str| {
            let found = image.layer_data.channel_data.list.iter().find(|c| c.name == *name);
            found.unwrap_or_else(|| panic!("{name}")).sample_data.values_as_f32().collect::<Vec<f32>>()
        };
        (channel("R"), channel("G"), channel("CH.UV"), channel("CH.Y"), channel("CH.M"))
    };
    let (bird, human) = (read("bird.exr"), read("human.exr"));
    // One film: the same cones in both files, shown in other colours.
    assert_eq!((&bird.2, &bird.3, &bird.4), (&human.2, &human.3, &human.4));
    assert_ne!(bird.0, human.0);
    let close = |a: &[f32], b: &[f32]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-4 * (1.0 + b.abs()));
    assert!(bird.4.iter().any(|v| *v > 0.0) && close(&bird.1, &bird.4), "green is the cone M");
}

/// A simulation is no distance from itself, and some from what was measured; a measurement that does not reach is refused.
#[test]
fn simulations_are_as_far_from_measurements_as_birds_see() {
    let folder = tempfile::tempdir().unwrap();
    write_two(folder.path());
    let film = ["spectrum", "air/keratin:320/melanin", "--bird", "starling", "--wavelengths", "300:700:5"];
    let itself = document(folder.path(), &film);
    let values =
        itself["wavelength_nm"].as_array().unwrap().iter().zip(itself["mean"][0].as_array().unwrap());
    let table: String = values.map(|(nm, value)| format!("{nm},{value}\n")).collect();
    std::fs::write(folder.path().join("same.csv"), format!("wl,R\n{table}")).unwrap();
    let far = |file: &str| {
        let found = document(folder.path(), &[&film[..], &["--measured", file]].concat());
        let one = &found["birds"][0]["measured"][0];
        (one["delta_s"].as_f64().unwrap(), one["delta_l"].as_f64().unwrap())
    };
    let (same, red) = (far("same.csv"), far("red.csv"));
    assert!(same.0 < 1e-9 && same.1 < 1e-9 && red.0 > 1.0 && red.1 > 1.0, "{same:?} {red:?}");
    let (_, out, _) = run_in(folder.path(), &[&film[..], &["--measured", "red.csv"]].concat());
    assert!(out.contains("; measured is ΔS ") && out.contains("by the rarest cones"), "{out}");
    let message = refused(folder.path(), &[&film[..], &["--measured", "visible.csv"]].concat());
    assert!(message.contains("--measured: the measured reflectance is known from 400"), "{message}");
}
