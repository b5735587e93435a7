//! `barbule trace`: from micrographs to spectra.

use std::path::Path;

use serde_json::Value;

use crate::common::{json, run};

/// What `examples/micrographs/rods.png` was drawn from: rods of 110 nm, air of 55 nm, 170 nm apart in rows of 147 nm; 2 nm per px.
const RODS: &str = "[lattice]\nperiod = 0.17\nhost = 'keratin'\ncortex = 0.1298\nrows = 4\nrow_pitch = 0.147\nrow_shift = 0.5\n\
    [[lattice.rod]]\ncircles = [{ diameter = 0.11, medium = 'melanin' }, { diameter = 0.055, medium = 'air' }]\n";

/// What `layers.png` was drawn from.
const LAYERS: &str = "barbule = 1\nname = 'truth'\ngenerator = 'multilayer'\n[parameters]\nwidth_um = 20.0\ncore = 'keratin'\nlower = 'none'\n\
    layers = [{ medium = 'keratin', thickness_um = 0.2 }, { medium = 'melanin', thickness_um = 0.12 },\n\
    { medium = 'keratin', thickness_um = 0.15 }, { medium = 'melanin', thickness_um = 0.09 }]\n";

fn micrograph(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/micrographs");
    folder.join(name).to_string_lossy().into_owned()
}

fn hold(what: &Value, truth: f64, part: f64) {
    let found = what["mean"].as_f64().unwrap();
    assert!((found - truth).abs() <= part * truth, "{found}, but {truth}");
}

/// Relative L1 of two spectra.
fn apart(found: &[f64], truth: &[f64]) -> f64 {
    let off: f64 = found.iter().zip(truth).map(|(a, b)| (a - b).abs()).sum();
    off / truth.iter().sum::<f64>()
}

#[test]
fn a_traced_lattice_reflects_what_the_one_that_was_drawn_does() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (rods, truth, figure) = (file("rods.toml"), file("truth.toml"), file("rods.svg"));
    std::fs::write(&truth, RODS).unwrap();
    let image = micrograph("rods.png");
    let found =
        json(&["trace", &image, "--scale", "200nm=100px", "-o", &rods, "--picture", &figure, "--json"]);
    let lattice = &found["lattice"];
    hold(&lattice["period_nm"], 170.0, 0.01);
    hold(&lattice["row_pitch_nm"], 147.0, 0.01);
    hold(&lattice["diameter_nm"], 110.0, 0.01);
    hold(&lattice["hollow_nm"], 55.0, 0.01);
    hold(&lattice["row_shift"], 0.5, 0.02);
    assert_eq!((lattice["rows"]["mean"].as_f64(), found["kind"].as_str()), (Some(4.0), Some("lattice")));
    let drawn = std::fs::read_to_string(&figure).unwrap();
    assert!(
        drawn.contains("grey level, flattened") && drawn.contains("period:") && drawn.contains("nm</text>")
    );
    let reflected = |structure: &str| -> Vec<f64> {
        let waves = [430, 470, 500, 530, 560, 600, 650];
        let of = |nm: &u32| {
            let nm = nm.to_string();
            let point =
                json(&["crystal", structure, "--wavelength", &nm, "--theta", "0", "--phi", "0", "--json"]);
            let orders = point["orders"].as_array().unwrap();
            orders.iter().map(|order| order["R"][0].as_f64().unwrap() + order["R"][1].as_f64().unwrap()).sum()
        };
        waves.iter().map(of).collect()
    };
    let off = apart(&reflected(&rods), &reflected(&truth));
    println!("lattice: relative L1 {off}");
    assert!(off < 0.02, "relative L1 {off}");
}

#[test]
fn traced_layers_reflect_what_those_that_were_drawn_do_and_the_bar_gives_their_scale() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (layers, truth, section) = (file("layers.toml"), file("truth.toml"), file("layers.json"));
    std::fs::write(&truth, LAYERS).unwrap();
    let image = micrograph("layers.png");
    let found = json(&["trace", &image, "--scale", "200nm=bar", "-o", &layers, "--json"]);
    let of = found["layers"].as_array().unwrap();
    assert_eq!(of.len(), 4);
    for (layer, (medium, nm)) in
        of.iter().zip([("keratin", 200.0), ("melanin", 120.0), ("keratin", 150.0), ("melanin", 90.0)])
    {
        assert_eq!(layer["medium"], medium);
        hold(&layer["thickness_nm"], nm, 0.01);
    }
    let reflected = |structure: &str| -> Vec<f64> {
        let words = ["spectrum", structure, "--wavelengths", "400:700:50", "--instances", "1", "--json"];
        let mean = json(&words)["mean"][0].clone();
        mean.as_array().unwrap().iter().map(|r| r.as_f64().unwrap()).collect()
    };
    let off = apart(&reflected(&layers), &reflected(&truth));
    println!("layers: relative L1 {off}");
    assert!(off < 0.02, "relative L1 {off}");
    // The outlines themselves, as a section, are opened too.
    let (code, _, message) =
        run(&["trace", &image, "--scale", "0.2um=bar", "-o", &section, "--cortex", "90"]);
    assert!(code == 0 && message.contains("scale bar found: 100.0 px"), "{message}");
    assert!(message.contains("--cortex has no effect here"), "{message}");
    let traced = json(&["geometry", &section, "--json"]);
    assert_eq!(traced["boundaries"].as_array().unwrap().len(), 5);
}

#[test]
fn what_cannot_be_traced_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let output = file("x.toml");
    let (rods, layers) = (micrograph("rods.png"), micrograph("layers.png"));
    let whole = std::fs::read(&rods).unwrap();
    std::fs::write(file("cut.png"), &whole[..whole.len() / 2]).unwrap();
    std::fs::write(file("words.png"), "no picture").unwrap();
    let [cut, words, none] = ["cut.png", "words.png", "none.tif"].map(file);
    let at = "2nm=1px";
    for (line, expected) in [
        (vec![&*rods, "--scale", "85px"], "--scale 85px: give a length and its pixels"),
        (vec![&*rods, "--scale", "1e9nm=1px"], "--scale"),
        (vec![&*rods, "--scale", "100nm=bar"], "has no scale bar"),
        (vec![&*rods, "--scale", at, "--thresholds", "90,170"], "the brighter first"),
        (
            vec![&*rods, "--scale", at, "--thresholds", "200", "--classes", "air,keratin,melanin"],
            "3 classes have 2",
        ),
        (vec![&*rods, "--scale", at, "--classes", "air,keratin,melamin"], "did you mean 'melanin'"),
        (vec![&*rods, "--scale", at, "--as", "layers"], "shows no layers"),
        (vec![&*rods, "--scale", at, "--as", "section"], "written as .json"),
        (vec![&*rods, "--scale", at, "--crop", "0,0,9000,50"], "leaves the picture of 480 × 380"),
        (vec![&*rods, "--scale", at, "--crop", "40,24,40,40"], "rods.png:"),
        (vec![&*layers, "--scale", at, "--as", "lattice"], "shows no lattice"),
        (vec![&*cut, "--scale", at], "cut.png: cannot be read as a PNG"),
        (vec![&*words, "--scale", at], "no PNG, TIFF or JPEG"),
        (vec![&*none, "--scale", at], "no such file"),
    ] {
        let words = [&["trace"], &line[..], &["-o", &output]].concat();
        let (code, out, message) = run(&words);
        assert_eq!((code, out.as_str()), (2, ""), "{words:?}: {message}");
        assert!(message.contains(expected), "{words:?}: {message}");
        assert!(!Path::new(&output).exists());
    }
    let (code, _, message) = run(&["trace", &rods, "--scale", at, "-o", &file("x.svg")]);
    assert!(code == 2 && message.contains(".toml") && message.contains(".json"), "{message}");
}
