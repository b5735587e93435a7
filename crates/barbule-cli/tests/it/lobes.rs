//! `barbule lobes`: what is drawn, as numbers too, and from which campaign.

use std::path::Path;

use barbule::scattering::directions::omega;
use serde_json::Value;

use crate::common::{MADE_UP, run_in, succeed_in, write_made_up};

fn numbers(folder: &Path, words: &[&str]) -> Value {
    let (out, _) = succeed_in(folder, &[&["lobes"], words, &["--json"]].concat());
    serde_json::from_str(&out).unwrap()
}

/// A campaign of a second.
const SMALL: &[&str] = &["--wavelengths", "450:650:100", "--directions", "2x2", "--instances", "3"];

#[test]
fn hemispheres_as_numbers_are_the_brdf_in_colour() {
    write_made_up();
    let folder = tempfile::tempdir().unwrap();
    let found = numbers(folder.path(), &[MADE_UP, "--instances", "0"]);
    assert_eq!(found["title"], "example green");
    let lobes = &found["lobes"]["hemispheres"];
    assert_eq!(lobes["instances"], serde_json::json!([]));
    let at = |key: &str, k: usize| lobes[key][k].as_f64().unwrap();
    assert_eq!((at("theta_in_deg", 4), at("phi_in_deg", 4)), (40.0, 0.0));
    // The brightest pixel of θ_i = 40° lies at the mirror direction; the corners are outside.
    let mirror = omega(-40f64.to_radians(), 0.0);
    let mut brightest = (0.0, [0.0; 2]);
    for y in 0..60 {
        for x in 0..60 {
            let pixel = &lobes["mean"][4][y][x];
            let place = [at("x_out", x), at("y_out", y)];
            assert_eq!(pixel.is_null(), place[0].hypot(place[1]) >= 1.0, "{place:?}");
            if pixel[1].as_f64().is_some_and(|g| g > brightest.0) {
                brightest = (pixel[1].as_f64().unwrap(), place);
            }
        }
    }
    assert!((brightest.1[0] - mirror.x).hypot(brightest.1[1] - mirror.y) < 0.05, "{brightest:?}");
    // Without a figure and without numbers there is nothing to do.
    let (code, out, message) = run_in(folder.path(), &["lobes", MADE_UP]);
    assert!(code == 2 && out.is_empty() && message.contains("give -o FIG"), "{message}");
}

#[test]
fn every_kind_gives_the_numbers_that_it_draws() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    succeed_in(here, &[&["characterize", "starling:teal", "-o", "a.barbule", "--quiet"], SMALL].concat());
    let parameters = numbers(here, &["a.barbule", "--parameters"]);
    assert_eq!(parameters["parameters"]["wavelength_nm"], serde_json::json!([450.0, 550.0, 650.0]));
    let m = parameters["parameters"]["m"][2][1][1].as_f64().unwrap();
    assert!(m > 0.001 && m <= 1.0 && parameters["parameters"]["f"][0][0][0].as_f64().unwrap() > 0.0);
    let fits = &numbers(here, &["a.barbule", "--fits"])["fits"];
    assert_eq!((fits.as_array().unwrap().len(), &fits[0]["phi_in_deg"]), (6, &0.0.into()));
    // What is fitted carries the same energy as what was simulated.
    let sum = |key: &str| fits[1][key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).sum::<f64>();
    assert!(
        (sum("u_fitted") / sum("u_simulated") - 1.0).abs() < 1e-3,
        "{} {}",
        sum("u_fitted"),
        sum("u_simulated")
    );
    let fields = &numbers(here, &["a.barbule", "--fields"])["fields"];
    assert_eq!(fields["oblique"][2]["phi_in_deg"], 40.0);
    assert_eq!(fields["normal"][0], fields["oblique"][0]);
    let noise = &numbers(here, &["a.barbule", "--noise"])["noise"];
    assert_eq!((noise["c0"][0].as_f64(), noise["simulated"]["mean"][1][0].as_f64()), (Some(1.0), Some(1.0)));
    assert_eq!(noise["q_r"].as_array().unwrap().len(), 3);
    // With a figure the numbers are the same, and one line says what was written.
    let words = ["lobes", "a.barbule", "--noise", "-o", "n.svg", "--json"];
    let (out, said) = succeed_in(here, &words);
    assert_eq!(&serde_json::from_str::<Value>(&out).unwrap()["noise"], noise);
    assert!(said.contains("wrote n.svg: the noise of starling teal"), "{said}");
    let instances = &numbers(here, &["a.barbule", "--instances", "2"])["lobes"];
    assert_eq!(instances["hemispheres"]["instances"].as_array().unwrap().len(), 2);
    assert_eq!(instances["patterns"]["directions"][0]["simulated"][0].as_array().unwrap().len(), 2);
    // The first row below the mean is the instance that `brdf` calls 0.
    succeed_in(here, &["lobes", "a.barbule", "--instances", "1", "-o", "l.svg"]);
    let drawn = std::fs::read_to_string(here.join("l.svg")).unwrap();
    assert!(drawn.contains(">instance 0<") && !drawn.contains(">instance 1<"));
}

#[test]
fn thinned_materials_are_marked_in_titles() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let words = ["characterize", "starling", "--thin", "10", "-o", "thin.barbule", "--quiet"];
    succeed_in(here, &words);
    let (_, said) = succeed_in(here, &["lobes", "thin.barbule", "--parameters", "-o", "p.svg"]);
    assert!(said.contains("of starling green (thinned)"), "{said}");
    let figure = std::fs::read_to_string(here.join("p.svg")).unwrap();
    assert!(figure.contains("starling green (thinned)"));
    // Three wavelengths are drawn; the numbers are those of all six.
    assert!(figure.contains("m_eff, 540 nm") && !figure.contains("m_eff, 460 nm"));
    let parameters = &numbers(here, &["thin.barbule", "--parameters"])["parameters"];
    assert_eq!(parameters["wavelength_nm"], serde_json::json!([300.0, 380.0, 460.0, 540.0, 620.0, 700.0]));
    for key in ["m", "f", "phi_shift_deg", "second"] {
        assert_eq!(parameters[key].as_array().unwrap().len(), 6, "{key}");
    }
    let (out, _) =
        succeed_in(here, &["brdf", "thin.barbule", "--wavelength", "520", "--wi", "0,0", "--wo", "0,0"]);
    assert!(out.starts_with("starling green (thinned), mean"), "{out}");
}

#[test]
fn only_the_campaign_that_a_file_was_fitted_to_is_believed() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    succeed_in(here, &[&["simulate", "starling:teal", "-o", "a.zarr", "--quiet"], SMALL].concat());
    succeed_in(here, &["fit", "a.zarr", "-o", "a.barbule", "--quiet"]);
    let own = numbers(here, &["a.barbule", "--fits"]);
    // Another bird's store with the same wavelengths and directions.
    std::fs::remove_dir_all(here.join("a.zarr")).unwrap();
    succeed_in(here, &[&["simulate", "bronzewing", "-o", "a.zarr", "--quiet"], SMALL].concat());
    let (code, out, message) = run_in(here, &["lobes", "a.barbule", "--fits", "-o", "f.svg"]);
    assert_eq!((code, out.as_str()), (2, ""));
    assert!(message.contains("a.zarr: is not the campaign that the material was fitted to"), "{message}");
    assert!(
        message.contains("bronzewing:green there, of starling:teal here") && message.len() < 600,
        "{message}"
    );
    assert!(!here.join("f.svg").exists());
    // Away with it, and the barbules are simulated again.
    std::fs::rename(here.join("a.zarr"), here.join("starling.zarr")).unwrap();
    assert_eq!(numbers(here, &["a.barbule", "--fits"]), own);
    // The name of a species is no file's: the store in this folder has nothing to do with it.
    let (code, _, message) = run_in(here, &["lobes", "starling", "--fits", "--json", "--quiet"]);
    assert!(code == 0 && message.is_empty(), "{message}");
}
