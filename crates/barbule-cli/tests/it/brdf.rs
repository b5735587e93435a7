//! `barbule brdf`: values as scripts read them, and the same values written again in Python.

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};

use barbule::brdf::FeatherMaterial;
use barbule::brdf::fixtures::halo;
use serde_json::Value;

use crate::common::{MADE_UP, json, printed, run, succeed, write_made_up};

fn document(words: &[&str]) -> Value {
    json(&[&["brdf"], words, &["--json"]].concat())
}

/// `[row][column]`.
fn table(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(list).collect()
}

fn list(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

#[test]
fn values_have_the_contracts_keys_and_shapes() {
    let words = ["starling", "--wavelengths", "450,520", "--wi", "-30,20", "--wo=30,-20", "--wo", "28,-10"];
    let found = document(&words);
    assert_eq!(found["wavelength_nm"], serde_json::json!([450.0, 520.0]));
    assert_eq!((&found["theta_in_deg"], &found["phi_in_deg"]), (&(-30.0).into(), &20.0.into()));
    assert_eq!(found["theta_out_deg"], serde_json::json!([30.0, 28.0]));
    assert_eq!(found["phi_out_deg"], serde_json::json!([-20.0, -10.0]));
    let [f, s, pdf] = ["f", "s", "pdf"].map(|key| table(&found[key]));
    for (f, (s, pdf)) in f.iter().zip(s.iter().zip(&pdf)) {
        assert_eq!((f.len(), s.len(), pdf.len()), (2, 2, 2));
        assert!(f.iter().zip(s).all(|(f, s)| *f > 0.0 && (0.0..=*f).contains(s)));
        assert!(pdf.iter().all(|p| *p > 0.0));
    }
    // Light of both polarizations is the mean of each; the steady part is that of every instance.
    let with = |more: &[&str]| document(&[&words[..], more].concat());
    let [first, second] = ["1", "2"].map(|p| table(&with(&["--polarization", p])["f"]));
    for (k, f) in f.iter().flatten().enumerate() {
        let mean = 0.5 * (first[k / 2][k % 2] + second[k / 2][k % 2]);
        // Values are mixed: exact but for rounding, between the nodes too.
        assert!((mean / f - 1.0).abs() < 1e-6, "{mean} {f}");
    }
    let third = with(&["--instance", "3"]);
    assert_eq!(third["s"], found["s"]);
    assert_ne!(third["f"], found["f"]);
    assert_ne!(third["f"], with(&["--instance", "18446744073709551615"])["f"]);
    assert_eq!(third["material_hash"].as_str().unwrap().len(), 64);
}

/// Exchanged, light and eye see the same where that is asked for: what one of both orders gives, or their mean.
#[test]
fn values_are_reciprocal_where_that_is_asked_for() {
    let of = |wi: &str, wo: &str, how: &str| {
        let words = ["starling", "--wavelength", "550", "--wi", wi, "--wo", wo, "--reciprocity", how];
        let found = document(&words);
        assert_eq!(found["reciprocity"], how);
        [table(&found["f"])[0][0], table(&found["pdf"])[0][0]]
    };
    let orders = |how: &str| [of("2,60", "-2,-25", how), of("-2,-25", "2,60", how)];
    let [[flat, flat_pdf], [steep, _]] = orders("none");
    assert!((flat / steep - 1.0).abs() > 0.01, "{flat} {steep}");
    let [[there, pdf], [back, _]] = orders("steeper");
    assert_eq!((there, back, pdf), (steep, steep, flat_pdf));
    let [[there, _], [back, _]] = orders("mean");
    assert!((there - 0.5 * (flat + steep)).abs() < 1e-12 && (there - back).abs() < 1e-12);
    let (code, _, message) =
        run(&["brdf", MADE_UP, "--wavelength", "500", "--wi", "0,0", "--marginal", "--reciprocity", "mean"]);
    assert_eq!(code, 2);
    assert!(message.contains("leave --reciprocity out"));
}

/// Where a cross-section is an arch its places share the whole's light out, each towards where it faces; flat ones do not.
#[test]
fn places_of_an_arch_have_the_whole_for_their_mean() {
    let of = |name: &str, wo: &str, place: Option<f64>| {
        let mut words = vec![name.to_owned()];
        words.extend(
            ["--wavelength", "450,550", "--wi", "0,10", "--instance", "5", "--wo", wo].map(str::to_owned),
        );
        words.extend(place.into_iter().flat_map(|x| ["--place".to_owned(), x.to_string()]));
        let found = document(&words.iter().map(String::as_str).collect::<Vec<_>>());
        assert_eq!(found["place"].as_f64(), place);
        let [f, s, pdf] = ["f", "s", "pdf"].map(|key| table(&found[key]));
        [f[0][0], f[1][0], s[0][0], pdf[0][0]]
    };
    for (wo, brightest) in [("0,-10", 0.0), ("0,20", 0.75), ("1,-50", -1.0)] {
        let whole = of("rock-dove", wo, None);
        let (mut mean, mut best, steps) = ([0.0; 4], (0.0, 0.0), 16);
        for k in 0..steps {
            let x = (2.0 * f64::from(k) + 1.0) / f64::from(steps) - 1.0;
            let here = of("rock-dove", wo, Some(x));
            (0..4).for_each(|n| mean[n] += here[n] / f64::from(steps));
            best = if here[0] > best.1 { (x, here[0]) } else { best };
        }
        // Sixteen steps of a Gaussian that ends at the edges.
        for (mean, whole) in mean.iter().zip(whole) {
            assert!((mean / whole - 1.0).abs() < 0.01, "{wo}: {mean} {whole}");
        }
        assert!((best.0 - brightest).abs() < 0.2, "{wo}: {best:?}");
    }
    assert_eq!(of("starling", "0,-10", Some(0.7)), of("starling", "0,-10", None));
    write_made_up();
    let flat = ["brdf", MADE_UP, "--wavelength", "550", "--wi", "0,0", "--wo", "0,0", "--place", "0"];
    let (code, _, message) = run(&flat);
    // The barbules that it was made of are nowhere.
    assert!(code == 2 && message.starts_with("barbule: --place: "), "{message}");
    for (words, expected) in [
        (["--wo", "0,0", "--place", "1.5"].as_slice(), "--place 1.5: write a number from -1 to 1"),
        (["--marginal", "--place", "0"].as_slice(), "leave --place out"),
    ] {
        let (code, _, message) =
            run(&[&["brdf", "rock-dove", "--wavelength", "550", "--wi", "0,0"], words].concat());
        assert!(code == 2 && message.contains(expected), "{message}");
    }
}

/// The lower side of a species that ships with both: a material of its own.
#[test]
fn undersides_have_values_of_their_own() {
    let of = |name: &str| {
        let found =
            document(&[name, "--wavelength", "550", "--wi", "0,20", "--marginal", "--azimuths", "90"]);
        [table(&found["marginal"]), table(&found["marginal_s"])].map(|rows| rows[0].clone())
    };
    let [[above, steady], [below, _]] = ["mallard", "mallard (below)"].map(of);
    assert!(above.iter().zip(&steady).all(|(f, s)| (0.0..=*f).contains(s)));
    let apart: f64 = above.iter().zip(&below).map(|(a, b)| (a - b).abs()).sum();
    // The same rows under a top of another form.
    assert!(apart > 0.02 * above.iter().sum::<f64>(), "{apart}");
    let (code, ..) = run(&["brdf", "mallardo (below)", "--wavelength", "550", "--wi", "0,20", "--wo", "0,0"]);
    assert_eq!(code, 2);
}

#[test]
fn a_grid_integrates_to_what_the_marginal_says_is_reflected() {
    let common = ["starling", "--wavelength", "450,600", "--wi", "15,35"];
    let grid = document(&[&common[..], &["--wo-grid", "200"]].concat());
    let marginal = document(&[&common[..], &["--marginal", "--azimuths", "300"]].concat());
    let (x, y) = (list(&grid["x_out"]), list(&grid["y_out"]));
    // Cells of the unit disc: z dω = dx dy.
    assert!((x.len() as f64 * 4.0 / 40_000.0 - std::f64::consts::PI).abs() < 0.01);
    for (x, (y, (theta, phi))) in
        x.iter().zip(y.iter().zip(list(&grid["theta_out_deg"]).into_iter().zip(list(&grid["phi_out_deg"]))))
    {
        let (theta, phi) = (theta.to_radians(), phi.to_radians());
        assert!((theta.cos() * phi.sin() - x).abs() < 1e-12 && (theta.sin() - y).abs() < 1e-12);
    }
    let phi = list(&marginal["phi_out_deg"]);
    assert!((phi[0] + 89.7).abs() < 1e-9 && phi.len() == 300);
    let reflected = list(&marginal["reflected_fraction"]);
    for (wave, (f, row)) in table(&grid["f"]).iter().zip(table(&marginal["marginal"])).enumerate() {
        let by_cells = f.iter().sum::<f64>() * 4.0 / 40_000.0;
        let by_azimuths = row.iter().sum::<f64>() * (0.6f64).to_radians() * 15f64.to_radians().cos();
        // The fraction is the material's own; 300 azimuths come this near.
        assert!((by_azimuths / reflected[wave] - 1.0).abs() < 1e-4, "{by_azimuths} {}", reflected[wave]);
        // Cells 0.01 wide under a ridge of σ = 0.04.
        assert!((by_cells / by_azimuths - 1.0).abs() < 1e-3, "{by_cells} {by_azimuths}");
    }
}

/// `marginal` is the far field's intensity in the mean over barbules: over 200 of them both polarizations' fields scatter
/// by 1/√200 of their speckle about the fitted lobe.
#[test]
fn the_marginal_is_the_mean_far_field() {
    let words = ["brdf", "starling", "--wavelength", "520", "--wi", "0,30", "--marginal", "--json"];
    let found: Value = json(&words);
    let marginal = table(&found["marginal"]).remove(0);
    let mut mean = vec![0.0; 400];
    let count = 40;
    for instance in 0..count {
        let number = instance.to_string();
        let words = [
            "far-field",
            "starling",
            "--wavelength",
            "520",
            "--theta",
            "0",
            "--phi",
            "30",
            "--instance",
            &number,
            "--json",
        ];
        let far: Value = json(&words);
        for key in ["polarization_1", "polarization_2"] {
            for (sum, value) in mean.iter_mut().zip(list(&far[key]["intensity"])) {
                *sum += 0.5 * value / f64::from(count);
            }
        }
    }
    let total = |values: &[f64]| values.iter().sum::<f64>();
    let ratio = total(&marginal) / total(&mean);
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
    // Over 9° at a time the speckle of 40 barbules is down to some percent.
    let (smooth, rough): (Vec<f64>, Vec<f64>) =
        marginal.chunks(20).zip(mean.chunks(20)).map(|(a, b)| (total(a), total(b))).unzip();
    let apart: f64 = smooth.iter().zip(&rough).map(|(a, b)| (a - b).powi(2)).sum();
    let relative = (apart / rough.iter().map(|b| b * b).sum::<f64>()).sqrt();
    assert!(relative < 0.2, "{relative}");
}

#[test]
fn tables_and_figures_are_written_and_said() {
    write_made_up();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (csv, svg, png) = (path("a.csv"), path("a.svg"), path("b.png"));
    let (out, said) = succeed(&[
        "brdf",
        MADE_UP,
        "--wavelength",
        "500",
        "--wi",
        "0,0",
        "--wo-grid",
        "9",
        "--csv",
        &csv,
        "-o",
        &svg,
    ]);
    assert!(out.is_empty());
    assert!(
        said.contains("wrote") && said.contains("a.svg: f of example green, mean, unpolarized"),
        "{said}"
    );
    let rows = std::fs::read_to_string(&csv).unwrap();
    assert!(rows.starts_with("wavelength_nm,theta_out_deg,phi_out_deg,x_out,y_out,f,s,pdf\n500,"), "{rows}");
    assert!(rows.contains("\n500,0,0,0,0,"));
    assert!(Path::new(&format!("{csv}.json")).is_file());
    assert!(std::fs::read_to_string(&svg).unwrap().contains("f (1/sr)"));
    let marginal =
        ["brdf", MADE_UP, "--wavelength", "450,500", "--wi", "0,0", "--marginal", "--azimuths", "20"];
    succeed(&[&marginal[..], &["-o", &png]].concat());
    assert!(std::fs::read(&png).unwrap().starts_with(b"\x89PNG"));
    let printed = printed(&marginal);
    assert!(printed.starts_with("example green, mean, unpolarized, θ_i 0°, φ_i 0°\n"), "{printed}");
    assert_eq!(printed.lines().count(), 2 + 40);
}

/// A set of instances and incident directions is the single runs one beside the other, in every form of output.
#[test]
fn sets_are_the_single_values_with_their_axes() {
    write_made_up();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let common = [MADE_UP, "--wavelength", "450,500", "--wo", "0,-30", "--wo", "3,10", "--wo", "0,80"];
    let sets = ["--wi", "0,30", "--wi=-10,20", "--instance", "0:4:4,9"];
    let with = |more: &[&str]| document(&[&common[..], more].concat());
    let found = with(&sets);
    assert_eq!(found["axes"], serde_json::json!(["instance", "wi", "wavelength_nm", "wo"]));
    assert_eq!(found["instance"], serde_json::json!([0, 4, 9]));
    assert_eq!(found["theta_in_deg"], serde_json::json!([0.0, -10.0]));
    let mut flat = Vec::new();
    for (k, instance) in ["0", "4", "9"].into_iter().enumerate() {
        for (d, wi) in ["--wi=0,30", "--wi=-10,20"].into_iter().enumerate() {
            let single = with(&[wi, "--instance", instance]);
            assert_eq!(single["axes"], serde_json::json!(["wavelength_nm", "wo"]));
            assert_eq!(found["f"][k][d], single["f"]);
            flat.extend(table(&single["f"]).concat());
        }
    }
    let bytes: Vec<u8> = flat.iter().flat_map(|value| value.to_le_bytes()).collect();
    let write = |name: &str| {
        let (out, said) = succeed(&[&["brdf"], &common[..], &sets, &["-o", &path(name)]].concat());
        assert!(out.is_empty() && said.contains("wrote"), "{said}");
    };
    write("t.npy");
    let npy = std::fs::read(path("t.npy")).unwrap();
    assert!(npy.ends_with(&bytes));
    let labels: Value = serde_json::from_slice(&std::fs::read(path("t.npy.json")).unwrap()).unwrap();
    assert_eq!((&labels["axes"], &labels["shape"]), (&found["axes"], &serde_json::json!([3, 2, 2, 3])));
    assert_eq!(
        (labels["units"].as_str(), labels["coordinates"][0]["values"][2].as_u64()),
        (Some("1/sr"), Some(9))
    );
    write("t.zarr");
    let chunk = std::fs::read(path("t.zarr/f/c.0.0.0.0")).unwrap();
    assert_eq!(chunk[..chunk.len() - 4], bytes);
    let group: Value = serde_json::from_slice(&std::fs::read(path("t.zarr/zarr.json")).unwrap()).unwrap();
    assert!(group["attributes"]["material_hash"].is_string(), "{group}");
    let (code, _, again) = run(&[&["brdf"], &common[..], &sets, &["-o", &path("t.zarr")]].concat());
    assert_eq!(code, 2);
    assert!(again.contains("is there already; give another name"));
    write("t.csv");
    let rows = std::fs::read_to_string(path("t.csv")).unwrap();
    let head =
        "instance,theta_in_deg,phi_in_deg,wavelength_nm,theta_out_deg,phi_out_deg,f,s,pdf\n0,0,30,450,0,-30,";
    assert!(rows.starts_with(head) && rows.lines().count() == 1 + 36, "{rows}");
    assert!(Path::new(&path("t.csv.json")).is_file());
}

#[test]
fn long_tables_are_printed_short_and_grids_of_light_are_directions() {
    write_made_up();
    let words = ["brdf", MADE_UP, "--wavelength", "500", "--wi-grid", "8", "--wo-grid", "8"];
    let printed = printed(&words);
    assert_eq!(printed.lines().count(), 2 + 40 + 1, "{printed}");
    // 52 of the 64 centres lie inside the circle.
    assert!(
        printed.ends_with("… and 2664 rows more: all with -o F.csv, F.npy or F.zarr, or --json\n"),
        "{printed}"
    );
    let found: Value = json(&[&words[..], &["--json"]].concat());
    assert_eq!(found["axes"], serde_json::json!(["wi", "wavelength_nm", "wo"]));
    assert_eq!(found["theta_in_deg"], found["theta_out_deg"]);
}

/// What is reflected does not depend on the azimuths asked for, and single instances over all light are flagged.
#[test]
fn reflected_fractions_are_the_materials_own() {
    let of = |azimuths: &str, more: &[&str]| {
        let words = ["hummingbird", "--wavelength", "550", "--marginal", "--azimuths", azimuths];
        document(&[&words[..], more].concat())
    };
    let grazing = ["--wi", "0,89.99"];
    let (few, many) = (of("2", &grazing), of("4000", &grazing));
    assert_eq!(few["reflected_fraction"], many["reflected_fraction"]);
    assert_eq!(few["flagged"], serde_json::json!([false]));
    let words = ["brdf", "starling", "--wavelength", "550", "--marginal", "--azimuths", "2", "--json"];
    let (out, message) = succeed(&[&words[..], &["--wi", "0,87", "--instance", "43:44:1"]].concat());
    let drawn: Value = serde_json::from_str(&out).unwrap();
    let fractions = table(&drawn["reflected_fraction"]).concat();
    let flagged: Vec<bool> = fractions.iter().map(|fraction| *fraction > 1.001).collect();
    assert!(flagged.contains(&true) && flagged.contains(&false), "{fractions:?}");
    let said: Vec<bool> =
        drawn["flagged"].as_array().unwrap().iter().map(|row| row[0].as_bool().unwrap()).collect();
    assert_eq!(said, flagged);
    assert!(message.contains("single instances may where light grazes, their mean does not"), "{message}");
}

#[test]
fn what_cannot_be_is_refused_in_one_sentence() {
    write_made_up();
    let usual = ["--wavelength", "500", "--wi", "0,0", "--wo", "0,0"];
    for (words, part) in [
        (&["--wi", "0,0", "--wo", "0,0"][..], "--wavelength"),
        (&["--wavelength", "500", "--wi", "0,0"], "--wo-grid"),
        (&["--wavelength", "500", "--wi", "0,90", "--wo", "0,0"], "at or past grazing"),
        (&["--wavelength", "500", "--wi", "0", "--wo", "0,0"], "write THETA,PHI in degrees"),
        (&["--wavelength", "500", "--wi", "0,0", "--wo", "1,2,3"], "write THETA,PHI in degrees"),
        (&["--wavelength", "500", "--wi", "0,nan", "--wo", "0,0"], "is not a number"),
        (&["--wavelength", "710", "--wi", "0,0", "--wo", "0,0"], "710 nm is outside 400 to 694 nm"),
        (&["--wavelength", "500", "--wi", "0,0", "--wo-grid", "0"], "from 1 to 1000"),
        (&["--wavelength", "400:690:1", "--wi", "0,0", "--wo-grid", "1000"], "give fewer"),
        (&["--wavelength", "500", "--wi", "0,0", "--marginal", "--azimuths", "1"], "from 2 to 100000"),
        (&["--wavelength", "500", "--wi", "0,0", "--marginal", "--wo", "0,0"], "cannot be used with"),
        (&["--wavelength", "500", "--wi", "0,0", "--wi-grid", "4", "--wo", "0,0"], "cannot be used with"),
        (
            &["--wavelength", "500", "--wi-grid", "0", "--wo", "0,0"],
            "--wi-grid 0: give a number from 1 to 1000",
        ),
        (
            &["--wavelength", "500", "--wi-grid", "100", "--wo-grid", "40"],
            "incident directions times 1 wavelengths",
        ),
        (&[&usual[..], &["--instance", "5:1:1"]].concat(), "0:59:1"),
        (
            &["--wavelength", "500", "--wi", "0,0", "--wi", "0,9", "--wo-grid", "9", "-o", "x.svg"],
            "draws one --wi and one --instance",
        ),
        (&[&usual[..], &["-o", "no/x.zarr"]].concat(), "the folder no does not exist"),
        (&[&usual[..], &["--azimuths", "10"]].concat(), "--marginal only"),
        (&[&usual[..], &["-o", "x.svg"]].concat(), "have no figure"),
        (&[&usual[..], &["--instance", "-1"]].concat(), "--instance -1: write whole numbers"),
        (&[&usual[..], &["--polarization", "3"]].concat(), "--polarization"),
    ] {
        let (code, _, message) = run(&[&["brdf", MADE_UP], words].concat());
        assert_eq!(code, 2, "{words:?}: {message}");
        assert!(message.contains(part) && message.len() < 600, "{words:?}: {message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
    }
}

/// The Python script reads the file by its documentation and draws the instances itself. Floor of the comparison: 1e-6 of
/// the largest value of a document. Reached: 4e-7, densities 2e-8.
#[test]
fn values_written_again_in_python_agree() {
    if Command::new("python3").arg("--version").output().is_err() {
        println!("skipped: there is no python3 here");
        return;
    }
    let material = barbule::io::decode_material(barbule_birds::material("starling-green").unwrap()).unwrap();
    python_agrees(&material);
    python_agrees(&FeatherMaterial { halo: Some(halo()), ..material });
}

fn python_agrees(material: &FeatherMaterial) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("starling.barbule");
    barbule::io::write_material(&file, material).unwrap();
    let file = file.to_str().unwrap();
    let documents = [
        &["--wavelength", "520", "--wi", "0,30", "--wo", "0,-30", "--wo", "2,-20", "--wo=-3,40"][..],
        &["--wavelength", "487.3", "--wi", "20,-65", "--wo=-20,65", "--wo=-22,30", "--wo=-17,-10"],
        &["--wavelength", "610", "--wi=-35,25", "--wo", "35,-25", "--wo", "33,0", "--instance", "0"],
        &["--wavelength", "455", "--wi", "40,50", "--wo=-40,-50", "--wo=-41,-45", "--instance", "7"],
        &["--wavelength", "610", "--wi=-35,25", "--wo", "35,-25", "--instance", "12345678901234567890"],
    ]
    .map(|words| printed(&[&["brdf", file], words, &["--json"]].concat()));
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/python/brdf.py");
    let source = std::fs::read_to_string(&script).unwrap();
    assert!(source.lines().count() <= 250);
    let mut python = Command::new("python3")
        .arg(&script)
        .arg(file)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    python.stdin.take().unwrap().write_all(documents.concat().as_bytes()).unwrap();
    let output = python.wait_with_output().unwrap();
    assert!(output.status.success());
    let again = String::from_utf8(output.stdout).unwrap();
    assert_eq!(again.lines().count(), documents.len());
    for (ours, theirs) in documents.iter().zip(again.lines()) {
        let [ours, theirs]: [Value; 2] = [ours, theirs].map(|text: &str| serde_json::from_str(text).unwrap());
        for key in ["f", "s", "pdf"] {
            let [a, b] = [&ours, &theirs].map(|document| table(&document[key]).concat());
            let floor = 1e-6 * a.iter().fold(0.0, |largest: f64, v| largest.max(*v));
            for (a, b) in a.iter().zip(&b) {
                assert!((a - b).abs() <= 1e-5 * a.max(floor), "{key}: {a} {b} in {ours}");
            }
        }
    }
    // Some of these have a steady part, or it would not have been compared.
    assert!(documents.iter().any(|d| !d.contains("\"s\":[[0.0,0.0")));
}

#[test]
fn the_bench_compares_with_the_plain_evaluation() {
    let found: Value = json(&["bench", "brdf", "starling", "--json"]);
    for name in ["instance_ns", "smooth_ns", "together_ns", "sample_ns"] {
        assert!(found[name].as_f64().unwrap() > 0.0, "{name}: {found}");
    }
    assert!(found["plain_ratio"].as_f64().unwrap() > 1.0, "{found}");
    assert!(found["largest_difference"].as_f64().unwrap() < 1e-4, "{found}");
}
