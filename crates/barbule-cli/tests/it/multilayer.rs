//! The birds in `examples/species`, made by the generator of multilayers: they run, and their colours are those of their
//! mean stacks (the film's transfer matrix as the second method) and of what is published.

use serde_json::Value;

use crate::common::{Ends as _, at_root, said_by};

fn document(arguments: &[&str]) -> Value {
    at_root(&[arguments, &["--json", "--quiet"]].concat()).prints_json()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// The mean spectrum of a few individuals at normal incidence.
fn spectrum(example: &str, set: &str, collect: &str) -> Vec<f64> {
    let file = format!("examples/species/{example}");
    let found =
        document(&["spectrum", &file, "--wavelengths", set, "--collect", collect, "--instances", "8"]);
    numbers(&found["mean"][0])
}

fn film(stack: &str, set: &str) -> Vec<f64> {
    numbers(&document(&["film", stack, "--wavelengths", set])["R"][0])
}

/// Places that are higher than all others so near on both sides.
fn maxima(values: &[f64], near: usize) -> Vec<usize> {
    let highest = |i: usize| {
        let around = &values[i.saturating_sub(near)..(i + near + 1).min(values.len())];
        around.iter().all(|v| *v <= values[i])
    };
    (near..values.len() - near).filter(|&i| highest(i)).collect()
}

fn peak_nm(values: &[f64], first_nm: f64, step_nm: f64) -> f64 {
    let highest = values.iter().copied().fold(0.0, f64::max);
    first_nm + step_nm * values.iter().position(|v| *v == highest).unwrap() as f64
}

/// Bitton & Dawson (2008): metallic blue to metallic green. A rough film tilts, which shifts its peak by under 3 %.
#[test]
fn the_tree_swallow_has_its_films_peak_in_both_colours() {
    for (variant, cortex, low, high) in [("blue", 295, 450.0, 495.0), ("green", 325, 495.0, 550.0)] {
        let set = "410:650:8";
        let half = format!("melanin:600/keratin:{cortex}/air");
        let stack = format!("air/keratin:{cortex}/melanin:600/mix(keratin,melanin,0.7):2000/{half}");
        let flat = peak_nm(&film(&stack, set), 410.0, 8.0);
        let found =
            peak_nm(&spectrum(&format!("tree-swallow.toml:{variant}"), set, "hemisphere"), 410.0, 8.0);
        assert!((found / flat - 1.0).abs() < 0.03, "{variant}: {found} nm, flat {flat} nm");
        assert!((low..high).contains(&found), "{variant}: {found} nm");
    }
}

/// Brink & van der Berg (2004): six peaks from the near UV to the near IR, up to four of them in the visible.
#[test]
fn the_hadeda_ibis_has_the_six_peaks_that_are_published() {
    let set = "300:830:5";
    let found = spectrum("hadeda-ibis.toml", set, "hemisphere");
    let flat = film("air/keratin:800/melanin:50/air:100/melanin:50/mix(keratin,melanin,0.5)", set);
    let peaks = |values: &[f64]| maxima(values, 4).into_iter().map(|i| 300.0 + 5.0 * i as f64).collect();
    let (found, flat): (Vec<f64>, Vec<f64>) = (peaks(&found), peaks(&flat));
    assert_eq!((found.len(), flat.len()), (6, 6), "{found:?} {flat:?}");
    assert!(found.iter().zip(&flat).all(|(a, b)| (a / b - 1.0).abs() < 0.03), "{found:?} {flat:?}");
    assert!((3..=4).contains(&found.iter().filter(|nm| (390.0..730.0).contains(*nm)).count()));
}

/// Stavenga et al. (2011): a yellow-orange mirror in the plane of the feather and two bluish ones at about 30°, so light that
/// falls along the normal leaves the latter at 60°.
#[test]
fn the_parotia_is_three_mirrors_of_two_colours() {
    let file = "examples/species/lawes-parotia.toml";
    let powers = |nm: &str| {
        let far = document(&[
            "far-field",
            file,
            "--wavelength",
            nm,
            "--theta",
            "0",
            "--phi",
            "0",
            "--azimuths",
            "180",
        ]);
        let phi = numbers(&far["phi_out_deg"]);
        let intensity = numbers(&far["polarization_1"]["intensity"]);
        let step = std::f64::consts::PI / phi.len() as f64;
        let within = |low: f64, high: f64| {
            let inside = phi.iter().zip(&intensity).filter(|(phi, _)| (low..high).contains(*phi));
            step * inside.map(|(_, i)| i).sum::<f64>()
        };
        ([within(-75.0, -45.0), within(-15.0, 15.0), within(45.0, 75.0)], within(-90.0, 90.0))
    };
    let [(blue, all), (yellow, _), (red, _)] = ["470", "578", "640"].map(powers);
    assert!(blue.iter().sum::<f64>() > 0.9 * all, "nothing goes elsewhere: {blue:?} of {all}");
    assert!(yellow[1] > 0.2 && yellow[1] > 5.0 * blue[1] && yellow[1] > 5.0 * red[1]);
    for side in [0, 2] {
        assert!(
            blue[side] > 1.2 * yellow[side] && blue[side] > 1.4 * red[side],
            "{blue:?} {yellow:?} {red:?}"
        );
        // The film at its local 30° is flat but for the window's edges: both arms are 13 of 19 µm, seen under cos 30°.
        assert!((0.003..0.02).contains(&blue[side]), "{blue:?}");
    }
    let set = "540:620:8";
    let flat = peak_nm(&film("air/keratin:310/25*(melanin:90/keratin:90)/keratin", set), 540.0, 8.0);
    let found = peak_nm(&spectrum("lawes-parotia.toml", set, "cone:10"), 540.0, 8.0);
    assert!((found / flat - 1.0).abs() < 0.03, "{found} nm, flat {flat} nm");
}

#[test]
fn every_bird_is_drawn_and_described() {
    let folder = tempfile::tempdir().unwrap();
    for (bird, curved) in [("tree-swallow", false), ("hadeda-ibis", false), ("lawes-parotia", true)] {
        let picture = folder.path().join(format!("{bird}.svg"));
        let file = format!("examples/species/{bird}.toml");
        at_root(&["geometry", &file, "-o", picture.to_str().unwrap()]).ends(0);
        assert!(std::fs::metadata(&picture).unwrap().len() < 1_500_000, "strips of one shade are one path");
        let section = document(&["geometry", &file]);
        let heights = numbers(&section["boundaries"][0]["z"]);
        assert_eq!(heights[0] < heights[heights.len() / 2] - 1.0, curved, "{bird}");
    }
}

/// A user's own medium goes wherever a medium does, and a wrong name is refused by its key.
#[test]
fn media_of_a_multilayer_come_from_its_file_the_flags_and_nowhere_else() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.toml");
    let text = "barbule = 1\nname = \"mine\"\ngenerator = \"multilayer\"\n[parameters]\nwidth_um = 9.0\n\
        layers = [{ medium = \"resin\", thickness_um = 0.2 }]\n";
    let write = |more: &str| std::fs::write(&file, format!("{text}{more}")).unwrap();
    let path = file.to_str().unwrap();
    let run =
        |more: &[&str]| at_root(&[&["geometry", path, "--json", "--quiet"], more].concat()).output().unwrap();
    write("");
    let refused = String::from_utf8(run(&[]).stderr).unwrap();
    assert!(refused.contains("parameters.layers[0].medium: ") && refused.contains("resin"), "{refused}");
    assert!(run(&["--medium", "resin=examples/stacks/glass.csv"]).status.success());
    write("[materials]\nresin = [1.6, 0.0]\n");
    assert!(run(&[]).status.success());
}

/// A clear core is a film, whose fringes the mean over individuals keeps as long as their cores are alike.
#[test]
fn fringes_of_cores_that_are_alike_are_said_with_what_takes_them_out() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.toml");
    let spectrum = |more: &str| {
        let text = format!(
            "barbule = 1\nname = \"mine\"\ngenerator = \"multilayer\"\n[parameters]\nwidth_um = 20.0\n\
            cortex_um = 0.28\nspread = 0.05\ncore_um = 2.0\n{more}\n\
            layers = [{{ medium = \"melanin\", thickness_um = 0.1 }}]\n"
        );
        std::fs::write(&file, text).unwrap();
        let words = ["spectrum", file.to_str().unwrap(), "--instances", "20", "--wavelengths", "500:700:5"];
        let output = at_root(&[&words[..], &["--json"]].concat()).output().unwrap();
        assert!(output.status.success(), "{}", said_by(&output));
        let document: Value = serde_json::from_slice(&output.stdout).unwrap();
        let mean = numbers(&document["mean"][0]);
        // What is left of a running mean over one fringe, 30 to 60 nm.
        let ripple = |i: usize| mean[i] - mean[i - 5..=i + 5].iter().sum::<f64>() / 11.0;
        let squares: f64 = (5..mean.len() - 5).map(|i| ripple(i).powi(2)).sum();
        ((squares / (mean.len() - 10) as f64).sqrt(), document["core_note"].clone())
    };
    let (alike, note) = spectrum("");
    let note = note.as_str().unwrap();
    assert!(note.contains("of 20 individuals keeps") && note.contains("core_spread = 0.1"), "{note}");
    for more in ["core_spread = 0.1", "lower = \"none\""] {
        let (left, note) = spectrum(more);
        assert!(note.is_null() && left < 0.5 * alike, "{more}: {left} of {alike}, {note}");
    }
}
