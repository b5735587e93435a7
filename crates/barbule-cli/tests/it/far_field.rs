//! `barbule far-field` over sets of wavelengths and directions.

use serde_json::Value;

use crate::common::{json, printed, succeed};

const SETS: [&str; 8] =
    ["far-field", "starling", "--wavelengths", "450,600", "--theta", "0", "--phi=-20,0,35", "--azimuths"];

fn document(words: &[&str]) -> Value {
    json(words)
}

#[test]
fn sets_stack_the_documents_of_single_far_fields() {
    let all = document(&[&SETS[..], &["60", "--json"]].concat());
    assert_eq!(all["wavelength_nm"], serde_json::json!([450.0, 600.0]));
    assert_eq!(all["theta_deg"], serde_json::json!([0.0]));
    assert_eq!(all["phi_deg"], serde_json::json!([-20.0, 0.0, 35.0]));
    for (w, nm) in ["450", "600"].into_iter().enumerate() {
        for (p, phi) in ["--phi=-20", "--phi=0", "--phi=35"].into_iter().enumerate() {
            let words =
                ["far-field", "starling", "--wavelength", nm, "--theta", "0", phi, "--azimuths", "60"];
            let one = document(&[&words[..], &["--json"]].concat());
            let keys: Vec<_> = one.as_object().unwrap().keys().collect();
            let contract = ["phi_out_deg", "incident_power", "polarization_1", "polarization_2"];
            assert_eq!(keys[..4], contract);
            assert_eq!(keys[4..], ["mirror_fraction", "flagged"]);
            for key in ["mirror_fraction", "flagged"] {
                assert_eq!(all[key][w][0][p], one[key]);
            }
            assert_eq!(all["phi_out_deg"], one["phi_out_deg"]);
            assert_eq!(all["incident_power"][w][0][p], one["incident_power"]);
            for polarization in ["polarization_1", "polarization_2"] {
                for (key, value) in one[polarization].as_object().unwrap() {
                    assert_eq!(all[polarization][key][w][0][p], *value, "{nm} {phi} {polarization} {key}");
                }
            }
        }
    }
}

#[test]
fn tables_have_one_row_for_each_azimuth_and_the_numbers_of_the_document() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (csv, figure) = (path("f.csv"), path("f.png"));
    let (out, said) = succeed(&[&SETS[..], &["40", "--csv", &csv, "-o", &figure]].concat());
    assert_eq!(out, "");
    assert!(
        said.contains("f.csv: 6 far fields of starling:green, instance 0") && said.contains("240 rows"),
        "{said}"
    );
    assert!(said.contains("f.png: intensity against the outgoing azimuth"), "{said}");
    assert!(std::fs::read(&figure).unwrap().starts_with(b"\x89PNG"));
    let text = std::fs::read_to_string(&csv).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next().unwrap(),
        "wavelength_nm,theta_deg,phi_deg,phi_out_deg,intensity_1,intensity_2,\
         e1_re_1,e1_im_1,e2_re_1,e2_im_1,e1_re_2,e1_im_2,e2_re_2,e2_im_2"
    );
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 6 * 40);
    let all = document(&[&SETS[..], &["40", "--json"]].concat());
    let row = &rows[4 * 40 + 7];
    assert_eq!(row[..3], [600.0, 0.0, 0.0]);
    assert_eq!(all["phi_out_deg"][7], row[3]);
    for (p, polarization) in ["polarization_1", "polarization_2"].into_iter().enumerate() {
        let found = &all[polarization];
        assert_eq!(found["intensity"][1][0][1][7], row[4 + p]);
        for (part, column) in [("e1", 6 + 4 * p), ("e2", 8 + 4 * p)] {
            assert_eq!(found[part][1][0][1][7], serde_json::json!([row[column], row[column + 1]]));
        }
        let squares: f64 = row[6 + 4 * p..10 + 4 * p].iter().map(|v| v * v).sum();
        assert!((squares / row[4 + p] - 1.0).abs() < 1e-12);
    }
    let beside: Value = serde_json::from_str(&std::fs::read_to_string(path("f.csv.json")).unwrap()).unwrap();
    assert!(beside["command"].as_str().unwrap().contains("far-field") && beside["seed"] == 1);
}

#[test]
fn words_show_one_far_field_whole_and_several_in_a_row_each() {
    let one =
        printed(&["far-field", "air/keratin:300/air", "--wavelength", "520", "--theta", "0", "--phi", "30"]);
    let lines: Vec<_> = one.lines().collect();
    assert_eq!(lines[0], "air/keratin:300/air, instance 0, 520 nm, θ_i = 0°, φ_i = 30°");
    assert!(lines[1].starts_with("incident power") && lines[2].contains("intensity 2 (1/rad)"), "{one}");
    assert_eq!(lines.len(), 3 + 400);
    let several = printed(&[
        "far-field",
        "air/keratin:300/air",
        "--wavelength",
        "520",
        "--theta",
        "0",
        "--phi",
        "0,30",
    ]);
    let rows: Vec<Vec<f64>> = several
        .lines()
        .filter_map(|line| line.split_whitespace().map(|cell| cell.parse().ok()).collect())
        .collect();
    assert_eq!(rows.len(), 2, "{several}");
    // A flat film reflects into the mirror direction, within the window's width.
    assert!((rows[1][5] + 30.0).abs() < 0.5 && rows[0][5].abs() < 0.5, "{several}");
}

#[test]
fn the_number_of_threads_decides_no_bit() {
    let with = |threads: &str| printed(&[&SETS[..], &["50", "--json", "--threads", threads]].concat());
    assert_eq!(with("1"), with("3"));
}

const RODS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/rods.json");

/// What is scattered and absorbed is missing behind; light through a window has a reflected part instead.
#[test]
fn full_waves_give_widths_that_balance() {
    let words = [
        "far-field",
        RODS,
        "--solver",
        "full-wave",
        "--wavelength",
        "500",
        "--theta",
        "30",
        "--phi",
        "0",
        "--json",
    ];
    let plane = document(&[&words[..], &["--window", "none", "--azimuths", "8"]].concat());
    let keys: Vec<_> = plane.as_object().unwrap().keys().collect();
    let contract = ["phi_out_deg", "incident_power", "polarization_1", "polarization_2"];
    assert_eq!(keys[..4], contract);
    assert_eq!(keys[4..], ["unknowns", "elements_per_wavelength", "seconds", "memory_bytes"]);
    assert_eq!(plane["phi_out_deg"][0], -180.0);
    assert_eq!(plane["phi_out_deg"][7], 135.0);
    for polarization in ["polarization_1", "polarization_2"] {
        let width = |key: &str| plane[polarization][key].as_f64().unwrap();
        assert!(width("absorbed") > 0.2, "two of the rods absorb");
        let balance = (width("scattered") + width("absorbed")) / width("extinction") - 1.0;
        assert!(balance.abs() < 1e-5, "{polarization}: {balance:e}");
        assert!(plane[polarization]["reflected_fraction"].is_null());
    }
    let beam = document(&[&words[..], &["--azimuths", "8"]].concat());
    let reflected = beam["polarization_1"]["reflected_fraction"].as_f64().unwrap();
    assert!(reflected > 0.0 && reflected < 1.0 && beam["polarization_1"]["extinction"].is_null());
    let (table, _) = succeed(&words[..words.len() - 1]);
    assert!(table.contains("nodes per wavelength"), "{table}");
}

/// The power of both polarizations at once, printed for one far field.
fn reflected(words: &[&str]) -> f64 {
    let document = document(
        &[&["far-field", "--wavelength", "550", "--theta", "0", "--phi", "0", "--json"], words].concat(),
    );
    let power = |key: &str| {
        let intensity = document[key]["intensity"].as_array().unwrap();
        intensity.iter().map(|value| value.as_f64().unwrap()).sum::<f64>()
    };
    power("polarization_1") + power("polarization_2")
}

#[test]
fn bubbles_are_averaged_unless_somebody_turns_it_off() {
    let bird = |words: &[&str]| reflected(&[&["hummingbird"], words].concat());
    let (averaged, off) = (bird(&[]), bird(&["--smooth", "off"]));
    assert!(averaged > 1.1 * off, "{averaged} {off}");
    assert_eq!(averaged, bird(&["--smooth", "0.06"]));
    // Twelve layers hang on the length a little: 5 % less.
    assert!((bird(&["--smooth", "0.1"]) / averaged - 0.946).abs() < 0.01);
    // The plain evaluation sees the same layers.
    assert!((bird(&["--solver", "direct"]) / averaged - 1.0).abs() < 1e-6);
    assert_eq!(reflected(&["starling"]), reflected(&["starling", "--smooth", "0.06"]));
}
