//! `barbule crystal` from words to figures.

use std::path::Path;

use serde_json::Value;

use crate::common::{json, printed, run};

fn point(words: &[&str]) -> Value {
    json(&[&["crystal"], words, &["--json"]].concat())
}

/// R of both polarizations, all orders.
fn reflected(point: &Value) -> [f64; 2] {
    [0, 1].map(|q| point["orders"].as_array().unwrap().iter().map(|o| o["R"][q].as_f64().unwrap()).sum())
}

#[test]
fn a_point_has_the_contracts_keys_and_its_power_adds_up() {
    let found = point(&["magpie:violet", "--wavelength", "310", "--theta", "20", "--phi", "60"]);
    let orders = found["orders"].as_array().unwrap();
    // sinφ + 1 > λ/(Δ cosθ): a diffraction order beside the mirror's.
    assert_eq!(orders.len(), 2);
    let reflectance = reflected(&found);
    for q in 0..2 {
        let rest = found["transmitted"][q].as_f64().unwrap() + found["absorbed"][q].as_f64().unwrap();
        assert!((reflectance[q] + rest - 1.0).abs() < 1e-9, "{found}");
    }
    for order in orders {
        let cosines = order["phi_deg"].as_f64().unwrap().to_radians().cos() / 60f64.to_radians().cos();
        let j = |out: usize| {
            let z = &order["J"][out][0];
            z[0].as_f64().unwrap().hypot(z[1].as_f64().unwrap())
        };
        assert!((order["R"][0].as_f64().unwrap() - (j(0).powi(2) + j(1).powi(2)) * cosines).abs() < 1e-12);
    }
    assert!(found["convergence"].as_f64().unwrap() < 1e-8);
}

#[test]
fn solvers_agree_on_a_lattice_from_a_file() {
    let file = file_of("square-holes");
    let with = |solver: &str| {
        let words = [&file, "--wavelength", "520", "--theta", "15", "--phi", "25", "--solver", solver];
        reflected(&point(&words.map(|w| w as &str)))
    };
    let exact = with("multipole");
    // Air in keratin at the default 20 orders, and at 100 cells/µm: reached 3.9e-3, 1.8e-3.
    for (solver, allowed) in [("rcwa", 5e-3), ("fdtd", 3e-3)] {
        let other = with(solver);
        for q in 0..2 {
            assert!((other[q] - exact[q]).abs() < allowed, "{solver}: {other:?} {exact:?}");
        }
    }
}

#[test]
fn a_wavelength_is_one_in_the_plural_too() {
    assert_eq!(point(&["mallard", "--wavelengths", "500"]), point(&["mallard", "--wavelength", "500"]));
    assert_ne!(point(&["mallard", "--wavelengths", "500"]), point(&["mallard"]));
}

#[test]
fn maps_and_fields_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (map, field) = (path("map.svg"), path("field.png"));
    let text =
        printed(&["crystal", "mallard", "--map", "--wavelengths", "400:700:100", "-o", &map, "--json"]);
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(document["R_1"].as_array().unwrap().len(), document["phi_deg"].as_array().unwrap().len());
    assert!(std::fs::read_to_string(&map).unwrap().contains("φ_i (°)"));
    let drawn =
        ["crystal", &file_of("square-holes"), "--field", "--wavelengths", "500", "-o", &field, "--json"];
    assert_eq!(json(&drawn)["wavelength_nm"], 500.0);
    assert!(std::fs::read(&field).unwrap().starts_with(b"\x89PNG"));
}

fn file_of(name: &str) -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../examples/lattices/{name}.toml"));
    file.to_string_lossy().into_owned()
}

#[test]
fn bad_crystals_are_refused_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let good = std::fs::read_to_string(file_of("square-holes")).unwrap();
    let path = folder.path().join("bad.toml");
    for (from, to, said) in [
        ("period = 0.22", "period = 90", "orders at 550 nm"),
        ("period = 0.22", "period = 900", "did you mean 0.9 (900 nm)?"),
        ("period = 0.22", "period = 0", "lattice.period is 0"),
        ("diameter = 0.12", "diameter = -0.12", "diameter is -0.12"),
        ("diameter = 0.12", "diameter = 0.23", "wider than the period"),
        ("row_pitch = 0.22", "row_pitch = 0.1", "overlap"),
        ("rows = 4", "rows = 400", "lattice.rows is 400"),
        ("cortex = 0.1", "cortex = 0.1\nincidence = 'melanin'", "does not absorb"),
    ] {
        std::fs::write(&path, good.replace(from, to)).unwrap();
        let (code, _, message) = run(&["crystal", path.to_str().unwrap()]);
        assert_eq!(code, 2, "{to}: {message}");
        assert!(message.contains(said) && message.trim().lines().count() == 1, "{to}: {message}");
    }
}

#[test]
fn the_bench_has_figures_of_every_solver() {
    let found: Value = json(&["bench", "crystal", "mallard", "--quick", "--json"]);
    let crystal = &found["crystals"][0];
    let solvers = crystal["solvers"].as_array().unwrap();
    assert_eq!((solvers.len(), &crystal["structure"]), (3, &"mallard".into()));
    assert!(crystal["table_cpu_seconds"].as_f64().unwrap() > 0.0);
    for solver in solvers {
        let figure = |name: &str| solver[name].as_f64().unwrap();
        assert!(figure("cpu_seconds") > 0.0 && figure("ratio") > 0.0, "{solver}");
        assert!(figure("largest_difference") < 5e-3 && figure("largest_imbalance") < 1e-3, "{solver}");
    }
}
