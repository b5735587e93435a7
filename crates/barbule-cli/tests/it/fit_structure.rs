//! `barbule fit-structure` as people and scripts use it.

use serde_json::Value;

use crate::common::{Ends as _, at_root, said_by};

fn refusal(arguments: &[&str]) -> String {
    let (code, _, text) = at_root(&[&["fit-structure"], arguments].concat()).ran();
    assert!(code == 2 && text.len() < 900, "{text}");
    text
}

const STARLING: &str = "examples/measured/starling-back.csv";

/// What is simulated, scaled and given back as a measurement is found, written, and simulates as it was fitted.
#[test]
fn a_film_is_found_written_and_simulates_as_the_fitted_curve() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let mut table = "wl,R\n".to_owned();
    let film = ["film", "air/keratin:612/melanin", "--wavelengths", "400:700:5", "--angles", "20", "--json"];
    let film: Value = at_root(&film).prints_json();
    let reflected = |p: &str, k: usize| film[p][0][k].as_f64().unwrap();
    for (k, nm) in film["wavelength_nm"].as_array().unwrap().iter().enumerate() {
        table += &format!("{nm},{:.6}\n", 0.35 * (reflected("R_s", k) + reflected("R_p", k)));
    }
    std::fs::write(at("m.csv"), table).unwrap();
    let (measured, best, figure) = (at("m.csv@20"), at("best.toml"), at("fit.svg"));
    let line = [
        "fit-structure",
        "--measured",
        &measured,
        "--model",
        "film",
        "--stack",
        "air/keratin:?/melanin",
        "-o",
        &best,
        "--picture",
        &figure,
        "--json",
    ];
    let output = at_root(&line).output().unwrap();
    let said = said_by(&output);
    assert!(output.status.success() && said.contains("best.toml: the best of"), "{said}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let solution = &found["solutions"][0];
    let thickness = &solution["parameters"]["thickness_nm"];
    assert!((thickness["value"].as_f64().unwrap() - 612.0).abs() < 0.05, "{thickness}");
    assert!(
        thickness["low"].as_f64() < Some(612.0) && thickness["high"].as_f64() > Some(612.0),
        "{thickness}"
    );
    assert_eq!(thickness["unit"], "nm");
    assert!(
        solution["rmse"].as_f64().unwrap() < 1e-6
            && (solution["level"][0].as_f64().unwrap() - 0.7).abs() < 1e-3
    );
    let again = ["film", &best, "--wavelengths", "400:700:5", "--angles", "20", "--json"];
    let again: Value = at_root(&again).prints_json();
    let level = solution["level"][0].as_f64().unwrap();
    for (k, fitted) in solution["fitted"][0].as_array().unwrap().iter().enumerate() {
        let mean = ["R_s", "R_p"].map(|p| again[p][0][k].as_f64().unwrap()).iter().sum::<f64>() / 2.0;
        assert!((level * mean - fitted.as_f64().unwrap()).abs() < 1e-6, "{k}");
    }
    let drawn = std::fs::read_to_string(&figure).unwrap();
    assert!(
        drawn.contains("measured − fitted")
            && drawn.contains("thickness_nm")
            && drawn.contains("wavelength (nm)")
    );
    assert!(std::fs::read_to_string(&best).unwrap().contains("# thickness_nm"));
}

#[test]
fn samples_are_individuals_and_other_orders_are_ranked() {
    let line =
        ["fit-structure", "--measured", STARLING, "--model", "film", "--stack", "air/keratin:?/melanin"];
    let idle = ["--instances", "4", "--plane", "along"];
    let output = at_root(&[&line[..], &idle].concat()).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let said = said_by(&output);
    assert!(output.status.success(), "{said}");
    for flag in ["--instances", "--plane"] {
        assert!(said.contains(&format!("{flag} has no effect here: flat layers")), "{said}");
    }
    for part in ["1. best: rmse", "thickness_nm", "95 %:", "between samples", "level", "2. "] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// A layer that no light comes back from: its spread between samples would be anything.
#[test]
fn what_a_measurement_does_not_tell_is_said() {
    let stack = "air/keratin:?/melanin:8000/keratin:100..300/melanin";
    let output =
        at_root(&["fit-structure", "--measured", STARLING, "--model", "multilayer", "--stack", stack])
            .output()
            .unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", said_by(&output));
    let [first, second] =
        ["keratin_nm", "keratin_2_nm"].map(|name| text.lines().find(|line| line.contains(name)));
    assert!(first.is_some_and(|line| line.contains("between samples")), "{text}");
    assert!(second.is_some_and(|line| line.ends_with("; what was measured does not tell it")), "{text}");
}

#[test]
fn what_cannot_be_fitted_is_refused_with_what_to_do() {
    for (arguments, part) in [
        (&["--measured", STARLING, "--model", "flim"][..], "did you mean 'film'"),
        (&["--measured", STARLING, "--model", "multilayer"], "a multilayer needs a"),
        (
            &["--measured", STARLING, "--model", "film", "--stack", "air/keratin:300/air"],
            "nothing in it is to be found",
        ),
        (&["--measured", STARLING, "--model", "film", "--free", "cortex_um"], "write ? or LOW..HIGH"),
        (&["--measured", STARLING, "--model", "starling", "--stack", "air/keratin:?/air"], "leave it out"),
        (&["--measured", STARLING, "--model", "starling", "--free", "cortx_um"], "did you mean 'cortex_um'"),
        (
            &["--measured", STARLING, "--model", "mallard", "--instrument", "probe:5"],
            "is not made of flat layers alone",
        ),
        (
            &["--measured", STARLING, "--model", "film", "--range", "710:800"],
            "fewer than two of its wavelengths",
        ),
        (&["--measured", STARLING, "--model", "film", "--range", "500"], "give FROM:TO"),
        (&["--measured", STARLING, "--model", "film", "-o", "best.svg"], "end the name with .toml"),
        (&["--measured", STARLING, "--model", "nowhere.toml"], "no such file"),
        (&["--measured", "nowhere.csv", "--model", "film"], "nowhere.csv"),
        (&["--measured", STARLING, "--model", "examples/stacks/melanin-mirror.toml"], "is a stack"),
    ] {
        let text = refusal(arguments);
        assert!(text.contains(part), "{arguments:?}: {text}");
    }
}
