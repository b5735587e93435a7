//! `barbule film` as people and scripts use it.

use serde_json::Value;

use crate::common::{Ends as _, at_root};

fn film_json(arguments: &[&str]) -> Value {
    at_root(&[&["film", "--json"], arguments].concat()).prints_json()
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
        at_root(&["film", "air/keratin:595/air", "--seed", "7", "-o", &svg, "--csv", &csv]).output().unwrap();
    assert!(output.status.success());
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(printed.starts_with("0°, unpolarized: peak "), "the colour, without the table: {printed}");
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(said.lines().count(), 2);
    assert!(said.contains("wrote ") && said.contains("a.svg: R, T and A at 0° at 50 wavelengths"), "{said}");
    at_root(&["film", "air/keratin:595/air", "--angles", "0:80:2", "-o", &png]).ends(0);
    let text = std::fs::read_to_string(&csv).unwrap();
    assert!(text.starts_with("angle_deg,wavelength_nm,R_s,R_p,T_s,T_p,A_s,A_p,R,T,A\n0,400,"));
    assert_eq!(text.lines().count(), 51);
    let notes: Value =
        serde_json::from_str(&std::fs::read_to_string(format!("{csv}.json")).unwrap()).unwrap();
    assert_eq!((&notes["version"], &notes["seed"]), (&env!("CARGO_PKG_VERSION").into(), &7.into()));
    assert!(notes["command"].as_str().unwrap().starts_with("barbule film air/keratin:595/air"));
    assert!(std::fs::read_to_string(&svg).unwrap().contains("seed: 7"));
    assert!(std::fs::read(&png).unwrap().starts_with(b"\x89PNG"));
    let same_again = at_root(&["film", "air/keratin:595/air", "--threads", "1", "--json"]).output().unwrap();
    let all_cores = at_root(&["film", "air/keratin:595/air", "--json"]).output().unwrap();
    assert_eq!(same_again.stdout, all_cores.stdout);
}

#[test]
fn the_examples_run() {
    at_root(&["film", "examples/stacks/melanin-mirror.toml", "--angles", "0,30,60"]).ends(0);
    at_root(&["film", "examples/stacks/glass-on-silver.toml", "--wavelengths", "500"]).ends(0);
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
        (&[film, "--csv", "-"], "name a file; --json prints the numbers on standard output"),
        (&["air/keratin:200±x/air"], "with its standard deviation keratin:595±5%"),
        (&["air/keratin:200±300/air"], "from 0 to the thickness, 200 nm"),
        (&["air/keratin:200±5%/air", "--instances", "0"], "--instances"),
    ];
    for (arguments, part) in cases {
        let output = at_root(&[&["film"], *arguments].concat()).output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(part), "{arguments:?}: {message}");
        assert!(message.len() < 600 && message.trim_end().lines().count() == 1, "{arguments:?}: {message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4);
}

/// Cells of a CSV by its header.
fn column(text: &str, name: &str) -> Vec<f64> {
    let mut lines = text.lines();
    let place = lines.next().unwrap().split(',').position(|header| header == name).unwrap();
    lines.map(|line| line.split(',').nth(place).unwrap().parse().unwrap()).collect()
}

#[test]
fn unpolarized_light_is_the_mean_of_both_polarizations() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.csv");
    at_root(&["film", "air/keratin:400/melanin:200/air", "--angle", "50", "--wavelength", "400:700:10"])
        .args(["--quiet", "--csv"])
        .arg(&path)
        .ends(0);
    let text = std::fs::read_to_string(&path).unwrap();
    for letter in ["R", "T", "A"] {
        let [all, s, p] = ["", "_s", "_p"].map(|end| column(&text, &format!("{letter}{end}")));
        assert!(all.iter().zip(s.iter().zip(&p)).all(|(all, (s, p))| (all - 0.5 * (s + p)).abs() < 1e-16));
    }
}

#[test]
fn the_numbers_of_the_colour_are_printed_and_in_the_document() {
    let found = film_json(&["air/1.5:320/1.8", "--angles", "0,45", "--wavelengths", "400:700:2"]);
    let looks = found["looks"].as_array().unwrap();
    assert_eq!(looks.len(), 2);
    // A film on a denser medium is brightest where 2 n d is a whole number of wavelengths.
    let peak = number(&looks[0]["unpolarized"]["peak_nm"]);
    assert!((peak - 1.5 * 320.0).abs() < 1.0, "{peak}");
    // At normal incidence both polarizations are one but for rounding.
    let [s, p] = ["s", "p"].map(|which| number(&looks[0][which]["peak_reflectance"]));
    assert!((s - p).abs() < 1e-14);
    assert_eq!(looks[0]["s"]["srgb"], looks[0]["p"]["srgb"]);
    assert_ne!(looks[1]["s"]["peak_reflectance"], looks[1]["p"]["peak_reflectance"]);
    assert!(looks[1]["unpolarized"]["srgb"].as_str().unwrap().starts_with('#'));
    let printed = at_root(&["film", "air/keratin:300/melanin:500/air"]).output().unwrap();
    let printed = String::from_utf8(printed.stdout).unwrap();
    for part in ["0°, unpolarized: peak 49", "half width", "saturation S8", "x 0.", "sRGB #", "normalized #"]
    {
        assert!(printed.contains(part), "{part}: {printed}");
    }
    assert_eq!(film_json(&["air/1.5", "--wavelengths", "500"])["looks"], serde_json::json!([]));
}

#[test]
fn a_stack_that_spreads_gives_means_and_deviations() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let stack = "air/keratin:300±5%/melanin:300/air";
    let set = ["--wavelengths", "400:700:20", "--instances", "40"];
    let found = film_json(&[&[stack], &set[..]].concat());
    assert_eq!(found["instances"], 40);
    let std: Vec<f64> = found["std"]["R"][0].as_array().unwrap().iter().map(number).collect();
    assert!(std.iter().all(|s| *s > 0.0 && *s < 0.05));
    let (r, power) = (&found["r_s"][0][0], number(&found["R_s"][0][0]));
    assert!(
        number(&r[0]).powi(2) + number(&r[1]).powi(2) < power,
        "amplitudes of individuals differ in phase"
    );
    let again = film_json(&[&[stack, "--threads", "1"], &set[..]].concat());
    assert_eq!(found, again);
    let other = film_json(&[&[stack, "--seed", "2"], &set[..]].concat());
    assert_ne!(found["R"], other["R"]);
    let (svg, csv) = (path("a.svg"), path("a.csv"));
    at_root(&["film", stack, "--instances", "5", "-o", &svg, "--csv", &csv]).ends(0);
    let text = std::fs::read_to_string(&csv).unwrap();
    assert!(text.starts_with("angle_deg,wavelength_nm,R_s,R_p,T_s,T_p,A_s,A_p,R,T,A,R_s_std,R_p_std,T_s_std,T_p_std,A_s_std,A_p_std,R_std\n"));
    assert!(std::fs::read_to_string(&svg).unwrap().contains("mean ± 1 std of 5"));
    let ascii = film_json(&[&["air/keratin:300+-15/melanin:300/air"], &set[..]].concat());
    assert_eq!(ascii, found);
}

/// Small spreads act to second order: the mean of many individuals is near the mean stack's, and so is its figure.
#[test]
fn a_spread_blurs_and_no_spread_changes_nothing() {
    let set = ["--wavelengths", "400:700:50", "--instances", "200"];
    let plain = film_json(&[&["air/keratin:300/melanin:300/air"], &set[..2]].concat());
    let zero = film_json(&[&["air/keratin:300±0%/melanin:300/air"], &set[..2]].concat());
    assert_eq!(plain, zero);
    assert!(plain.get("std").is_none() && plain.get("instances").is_none());
    let near = film_json(&[&["air/keratin:300±0.1%/melanin:300/air"], &set[..]].concat());
    for (a, b) in near["R"][0].as_array().unwrap().iter().zip(plain["R"][0].as_array().unwrap()) {
        assert!((number(a) - number(b)).abs() < 1e-4);
    }
}

#[test]
fn what_is_doubtful_is_said_and_done() {
    let said = |arguments: &[&str]| {
        let output = at_root(arguments).output().unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stderr).unwrap()
    };
    let thin = "air/keratin:0.2/air";
    let expected = "keratin:0.2 is 0.2 nm thick; thicknesses are in nm: did you mean 200?\n";
    assert_eq!(said(&["film", thin, "--wavelengths", "500"]), expected);
    assert_eq!(said(&["far-field", thin, "--wavelength", "500", "--theta", "0", "--phi", "0"]), expected);
    assert_eq!(said(&["film", thin, "--wavelengths", "500", "--quiet"]), "");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("thin.toml");
    std::fs::write(&file, "stack = \"air/keratin:0.2/air\"").unwrap();
    let file = file.to_str().unwrap();
    assert_eq!(said(&["far-field", file, "--wavelength", "500", "--theta", "0", "--phi", "0"]), expected);
    let unused = said(&["film", "air/keratin:200/air", "--instances", "5", "--wavelengths", "500"]);
    assert!(unused.starts_with("--instances has no effect"), "{unused}");
}

/// A stack that spreads is a structure with endless individuals wherever structures go.
#[test]
fn spectra_of_a_stack_that_spreads_have_a_deviation() {
    let folder = tempfile::tempdir().unwrap();
    let csv = folder.path().join("s.csv");
    at_root(&[
        "spectrum",
        "air/keratin:300±5%/melanin:300/air",
        "--instances",
        "4",
        "--wavelengths",
        "450,600",
    ])
    .args(["--quiet", "--csv"])
    .arg(&csv)
    .ends(0);
    let text = std::fs::read_to_string(&csv).unwrap();
    assert!(column(&text, "std").iter().all(|std| *std > 1e-4), "{text}");
}

/// What a material records of such a stack makes its individuals again.
#[test]
fn a_material_of_a_stack_that_spreads_shows_its_individuals() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (material, picture, cache) = (path("m.barbule"), path("i.png"), path("cache"));
    let stack = "air/keratin:300±5%/melanin:300/air";
    let few = ["--wavelengths", "450,550,650", "--directions", "2x2", "--instances", "3"];
    at_root(&["characterize", stack, "--quiet", "--cache", &cache, "-o", &material]).args(few).ends(0);
    at_root(&["lobes", &material, "--fields", "--quiet", "--cache", &cache, "-o", &picture]).ends(0);
    assert!(std::fs::read(&picture).unwrap().starts_with(b"\x89PNG"));
}

/// A film on melanin: its peak moves by √(n² − sin²θ) whatever order is highest, and so do those of s and p light.
#[test]
fn the_peaks_of_several_angles_are_of_one_order() {
    let film = ["air/keratin:300/melanin:300/air", "--angles", "0:75:15", "--wavelengths", "300:700:4"];
    let document = film_json(&film);
    let mut jumps = 0;
    for which in ["unpolarized", "s"] {
        let peaks: Vec<f64> = document["looks"]
            .as_array()
            .unwrap()
            .iter()
            .map(|look| look[which]["peak_nm"].as_f64().unwrap())
            .collect();
        for (angle, nm) in peaks.iter().enumerate() {
            let sine = (15.0 * angle as f64).to_radians().sin();
            let law = peaks[0] * (1.56f64 * 1.56 - sine * sine).sqrt() / 1.56;
            assert!((nm / law - 1.0).abs() < 0.05, "{which}: {peaks:?}");
            jumps += usize::from(document["looks"][angle][which]["highest_is_another_order"] == true);
        }
    }
    assert!(jumps > 0, "no order but one was ever highest");
}
