//! `barbule film` as people and scripts use it.

use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

fn barbule(arguments: &[&str]) -> Command {
    let mut command = Command::cargo_bin("barbule").unwrap();
    command.args(arguments).current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."));
    command
}

fn film_json(arguments: &[&str]) -> Value {
    let output = barbule(&[&["film", "--json"], arguments].concat()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn json_has_the_contracts_keys_and_shapes_and_its_energy_is_one() {
    let found = film_json(&[
        "air/6*(melanin:99/keratin:100)/keratin",
        "--wavelengths",
        "400:700:100",
        "--angles",
        "0,-60",
    ]);
    assert_eq!(found["wavelength_nm"], serde_json::json!([400.0, 500.0, 600.0, 700.0]));
    assert_eq!(found["angle_deg"], serde_json::json!([0.0, -60.0]));
    for p in ["s", "p"] {
        let key = |letter: &str| &found[format!("{letter}_{p}")];
        for a in 0..2 {
            for w in 0..4 {
                let r = &key("r")[a][w];
                let (re, im) = (number(&r[0]), number(&r[1]));
                assert!((re * re + im * im - number(&key("R")[a][w])).abs() < 1e-14);
                let sum = number(&key("R")[a][w]) + number(&key("T")[a][w]) + number(&key("A")[a][w]);
                assert!((sum - 1.0).abs() < 1e-12, "{sum}");
                let layers = found["absorbed_per_layer"][p].as_array().unwrap();
                assert_eq!(layers.len(), 12);
                let absorbed: f64 = layers.iter().map(|l| number(&l[a][w])).sum();
                assert!((absorbed - number(&key("A")[a][w])).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn a_bare_surface_reflects_as_fresnel_says() {
    let found = film_json(&["air/1.5", "--wavelengths", "500"]);
    assert!((number(&found["R_s"][0][0]) - 0.04).abs() < 1e-15);
    assert!((number(&found["r_s"][0][0][0]) + 0.2).abs() < 1e-15);
    assert!((number(&found["r_p"][0][0][0]) - 0.2).abs() < 1e-15, "p is of H, so its sign is the other");
    assert_eq!(found["absorbed_per_layer"]["s"], serde_json::json!([]));
}

#[test]
fn figures_and_tables_are_written_with_their_provenance() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (svg, png, csv) = (path("a.svg"), path("b.png"), path("c.csv"));
    let output =
        barbule(&["film", "air/keratin:595/air", "--seed", "7", "-o", &svg, "--csv", &csv]).output().unwrap();
    assert!(
        output.status.success() && output.stdout.is_empty(),
        "a file was asked for, so nothing is printed"
    );
    barbule(&["film", "air/keratin:595/air", "--angles", "0:80:2", "-o", &png]).assert().success();
    let text = std::fs::read_to_string(&csv).unwrap();
    assert!(text.starts_with("angle_deg,wavelength_nm,R_s,R_p,T_s,T_p,A_s,A_p\n0,400,"));
    assert_eq!(text.lines().count(), 51);
    let notes: Value =
        serde_json::from_str(&std::fs::read_to_string(format!("{csv}.json")).unwrap()).unwrap();
    assert_eq!((&notes["version"], &notes["seed"]), (&env!("CARGO_PKG_VERSION").into(), &7.into()));
    assert!(notes["command"].as_str().unwrap().starts_with("barbule film air/keratin:595/air"));
    assert!(std::fs::read_to_string(&svg).unwrap().contains("seed: 7"));
    assert!(std::fs::read(&png).unwrap().starts_with(b"\x89PNG"));
    let same_again = barbule(&["film", "air/keratin:595/air", "--threads", "1", "--json"]).output().unwrap();
    let all_cores = barbule(&["film", "air/keratin:595/air", "--json"]).output().unwrap();
    assert_eq!(same_again.stdout, all_cores.stdout);
}

#[test]
fn the_examples_run() {
    barbule(&["film", "examples/stacks/melanin-mirror.toml", "--angles", "0,30,60"]).assert().success();
    barbule(&["film", "examples/stacks/glass-on-silver.toml", "--wavelengths", "500"]).assert().success();
    let own = film_json(&[
        "air/glass:100/air",
        "--medium",
        "glass=examples/stacks/glass.csv",
        "--wavelengths",
        "500",
    ]);
    assert!(number(&own["A_s"][0][0]).abs() < 1e-12);
}

#[test]
fn bad_input_is_refused_in_one_sentence_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(path("bad.csv"), "400,1.5,0\nx,1,0\n").unwrap();
    std::fs::write(path("short.csv"), "450,1.5,0\n500,1.5,0\n").unwrap();
    std::fs::write(path("bad.toml"), "tack = 3").unwrap();
    std::fs::write(path("stack.json"), "{}").unwrap();
    let film = "air/keratin:595/air";
    let media = |name: &str| format!("m={}", path(name));
    let cases: &[(&[&str], &str)] = &[
        (&["air/keratine:5/air"], "did you mean 'keratin'"),
        (&["air"], "at least two media"),
        (&["melanin/keratin"], "first medium 'melanin' absorbs"),
        (&["air/100000*(keratin:5/air:5)/air"], "over 100000 layers"),
        (&["air/1.5-0.1j:5/air"], "gain"),
        (&[&path("none.toml")], "no such file"),
        (&[&path("bad.toml")], "unknown field `tack`"),
        (&[&path("stack.json")], "end in .toml"),
        (&[film, "--angles", "90"], "at or past grazing"),
        (&[film, "--angles=-95"], "at or past grazing"),
        (&[film, "--angles", "x"], "is not a number"),
        (&[film, "--wavelengths", "200"], "outside 300 to 830 nm"),
        (&[film, "--wavelengths", "700:400:6"], "does not lead"),
        (&[film, "-o", &path("f.eps")], ".svg, .pdf or .png"),
        (&[film, "-o", &path("no/where.svg")], "does not exist"),
        (&[film, "-o", &path("same.svg"), "--csv", &path("same.svg")], "two names"),
        (&[film, "--csv", folder.path().to_str().unwrap()], "is a folder"),
        (&[film, "--medium", "x"], "NAME=FILE"),
        (&[film, "--medium", "1x=a.csv"], "no such file"),
        (&[film, "--medium", &media("bad.csv")], "bad.csv: line 2"),
        (&["air/m:5/air", "--medium", &media("short.csv")], "covers 450 to 500 nm"),
        (&[film, "--angles", "0:80:0.001", "--wavelengths", "300:830:0.01"], "raise --memory"),
        (&[film, "--threads", "0"], "--threads 0"),
    ];
    for (arguments, part) in cases {
        let output = barbule(&[&["film"], *arguments].concat()).output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(part), "{arguments:?}: {message}");
        assert!(message.len() < 600 && message.trim_end().lines().count() == 1, "{arguments:?}: {message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4);
}
