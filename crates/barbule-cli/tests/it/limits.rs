//! Numbers outside the model are flagged, memory is foretold, and small inputs that ask for much are refused.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::{Value, json};

use crate::common::{run, run_and_peak, succeed};

fn document(words: &[&str]) -> (Value, String) {
    let (out, message) = succeed(&[words, &["--json"]].concat());
    (serde_json::from_str(&out).unwrap(), message)
}

pub(crate) fn write(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_string_lossy().into_owned()
}

/// A keratin film 0.3 µm thick, 20 µm wide, whose top has these slopes left and right of its middle.
fn film(left: f64, right: f64) -> String {
    let line =
        |depth: f64| json!({"x": [-10, 0, 10], "z": [-10.0 * left - depth, -depth, 10.0 * right - depth]});
    json!({
        "barbule": 1, "units": "um", "width": 20, "name": "film",
        "boundaries": [line(0.0), line(0.3)], "media": ["air", "keratin", "air"],
    })
    .to_string()
}

#[test]
fn grazing_light_is_flagged_by_what_a_mirror_would_reflect() {
    let mirror = "air/0.05+8j";
    let (found, message) =
        document(&["spectrum", mirror, "--angle", "0,60,80,85", "--wavelengths", "500,694"]);
    assert!(
        message.contains("at φ = 85° and 694 nm a flat mirror 25 µm wide would reflect 0.67"),
        "{message}"
    );
    assert!(message.contains("(4 of 8 values are flagged)"), "{message}");
    assert_eq!(found["flagged"], json!([[false, false], [false, false], [true, true], [true, true]]));
    for (angle, row) in found["mean"].as_array().unwrap().iter().enumerate() {
        for wavelength in 0..2 {
            // The nearly perfect mirror shows the error itself.
            let [mean, expected] =
                [row, &found["mirror_fraction"][angle]].map(|row| row[wavelength].as_f64().unwrap());
            assert!((mean / expected - 1.0).abs() < 0.02, "{mean} {expected}");
        }
    }
    let (_, message) = document(&["spectrum", mirror, "--angle", "60"]);
    assert!(!message.contains("mirror"), "{message}");
    let along =
        document(&["spectrum", mirror, "--angle", "89.5", "--plane", "along", "--wavelengths", "600"]);
    assert!(along.1.contains("at θ = 89.5° and 600 nm"), "{}", along.1);
    let at = ["far-field", mirror, "--wavelength", "500", "--theta", "0", "--phi"];
    let (found, message) = document(&[&at[..], &["-89.9999999999999"]].concat());
    assert!(found["flagged"] == true && found["mirror_fraction"].as_f64().unwrap() > 1e12, "{found}");
    assert!(message.contains("the simulation is that far off so near grazing"), "{message}");
    let (found, message) = document(&[&at[..], &["30"]].concat());
    assert!(found["flagged"] == false && message.is_empty(), "{message}");
    let (found, _) = document(&[&at[..], &["-89", "--window", "none"]].concat());
    assert_eq!((&found["flagged"], &found["mirror_fraction"]), (&json!(false), &Value::Null));
}

/// The attributes of a store that `simulate` filled, and what was said.
fn simulated(structure: &str, store: &Path, flags: &[&str]) -> (Value, String) {
    let small = ["--wavelengths", "450,650", "--directions", "2x2", "--instances", "3", "-v"];
    let words = ["simulate", structure, "-o", store.to_str().unwrap()];
    let (code, _, message) = run(&[&words[..], &small, flags].concat());
    assert_eq!(code, 0, "{message}");
    assert!(message.contains("wrote ") && message.contains("4 of 4 units"), "{message}");
    // The same campaign goes on.
    let (code, _, again) = run(&[&words[..], &small, flags].concat());
    assert!(code == 0 && again.contains("nothing to do"), "{again}");
    let group: Value =
        serde_json::from_str(&std::fs::read_to_string(store.join("zarr.json")).unwrap()).unwrap();
    (group["attributes"].clone(), message)
}

#[test]
fn sections_that_are_not_their_own_mirror_images_are_lit_from_both_sides() {
    let folder = tempfile::tempdir().unwrap();
    let store = |name: &str| folder.path().join(name);
    let slanted = write(folder.path(), "slanted.json", &film(0.3, 0.3));
    let (attributes, message) = simulated(&slanted, &store("s.zarr"), &[]);
    assert!(
        message.contains("both signs of φ_i are simulated: film is not its own mirror image\n"),
        "{message}"
    );
    assert_eq!((&attributes["sides"], &attributes["campaign"]["sides"]), (&json!("both"), &json!("both")));
    let (attributes, message) = simulated(&slanted, &store("m.zarr"), &["--mirror", "--keep-fields", "650"]);
    assert!(message.contains("mirror image; each instance counts with its mirror image"), "{message}");
    assert_eq!((&attributes["sides"], &attributes["campaign"]["mirror"]), (&Value::Null, &json!(true)));
    assert_eq!(attributes["instances"], 6);
    // Another campaign than without the flag.
    let words =
        ["simulate", &slanted, "-o", store("s.zarr").to_str().unwrap(), "--mirror"].map(str::to_owned);
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let small = ["--wavelengths", "450,650", "--directions", "2x2", "--instances", "3"];
    let (code, _, message) = run(&[&words[..], &small].concat());
    assert!(code == 2 && message.contains("made with other parameters"), "{message}");
    let even = write(folder.path(), "even.json", &film(-0.1, 0.1));
    let (attributes, message) = simulated(&even, &store("e.zarr"), &["--mirror"]);
    assert!(!message.contains("both signs"), "{message}");
    assert!(message.contains("--mirror has no effect here: film is its own mirror image"), "{message}");
    let keys: Vec<&String> = attributes.as_object().unwrap().keys().collect();
    assert!(!keys.iter().any(|key| *key == "sides" || *key == "mirror"), "{keys:?}");
    let (report, _) =
        document(&["fit", store("e.zarr").to_str().unwrap(), "-o", store("e.barbule").to_str().unwrap()]);
    let info = barbule::io::read_material(&store("e.barbule")).unwrap().info;
    assert_eq!(info["clipped"], report["clipped"].as_array().unwrap().len());
    assert!(report["grazing"].is_array() && info["grazing"].is_u64(), "{info}");
}

#[test]
fn lower_sides_are_lit_where_there_are_some() {
    let folder = tempfile::tempdir().unwrap();
    let (attributes, message) = simulated("starling", &folder.path().join("b.zarr"), &["--side", "below"]);
    assert!(message.contains("the campaign starling:green (below), 4 of 4 units"), "{message}");
    assert_eq!(attributes["campaign"]["structure"]["side"], "below");
    // A stack from below is the reversed one from above.
    let spectrum = |stack: &str, side: &str| {
        document(&["spectrum", stack, "--side", side, "--wavelengths", "450,650", "--instances", "1"]).0
    };
    let below = spectrum("air/keratin:300/melanin:100/air", "below");
    let reversed = spectrum("air/melanin:100/keratin:300/air", "above");
    for wavelength in 0..2 {
        let [a, b] = [&below, &reversed].map(|found| found["mean"][0][wavelength].as_f64().unwrap());
        assert!((a / b - 1.0).abs() < 1e-5, "{a} {b}");
    }
    assert_eq!(below["structure"], "air/keratin:300/melanin:100/air (below)");
    // Turned over by its name too, and by both, which is not at all.
    let by_name = spectrum("air/keratin:300/melanin:100/air (below)", "above");
    assert_eq!((&by_name["structure"], &by_name["mean"]), (&below["structure"], &below["mean"]));
    let [twice, never] = ["air/keratin:300/melanin:100/air (below)", "air/keratin:300/melanin:100/air"]
        .map(|stack| spectrum(stack, if stack.ends_with(')') { "below" } else { "above" }));
    assert_eq!((&twice["structure"], &twice["mean"]), (&never["structure"], &never["mean"]));
    let words =
        ["far-field", "starling", "--side", "below", "--wavelength", "500", "--theta", "0", "--phi", "20"];
    let (code, out, message) = run(&words);
    assert!(code == 0 && out.starts_with("starling:green (below), instance 0"), "{out} {message}");
}

#[test]
fn a_structure_that_reflects_nothing_is_fitted_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let [store, material] = ["s.zarr", "m.barbule"].map(|name| folder.path().join(name));
    let [store, material] = [&store, &material].map(|path| path.to_str().unwrap());
    let small = ["--wavelengths", "500", "--directions", "2x2", "--instances", "3"];
    assert_eq!(run(&[&["simulate", "air/air:100/air", "-o", store], &small[..]].concat()).0, 0);
    let (code, _, message) = run(&["fit", store, "-o", material]);
    assert!(code == 0 && !message.contains("NaN"), "{message}");
    assert!(message.contains("none, since nothing is reflected"), "{message}");
}

/// The largest resident memory of a run, as often as it was looked at, and what the run said.
fn peak_mb(words: &[&str]) -> (f64, String) {
    let (output, peak) = run_and_peak(words);
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{message}");
    (peak, message)
}

#[test]
fn campaigns_stay_within_the_memory_that_is_foretold() {
    if !cfg!(target_os = "linux") {
        println!("skipped: the peak of memory is read from /proc");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for (number, (structure, instances)) in [
        ("air/300*(keratin:10/melanin:10)/air", "1"),
        ("starling", "10"),
        ("bronzewing", "2"),
        ("mallard", "4"),
    ]
    .into_iter()
    .enumerate()
    {
        let store = folder.path().join(format!("{number}.zarr"));
        let words = ["simulate", structure, "--wavelengths", "400", "--directions", "2x4", "-v", "-o"];
        let more =
            [store.to_str().unwrap(), "--instances", instances, "--cache", folder.path().to_str().unwrap()];
        let (peak, message) = peak_mb(&[&words[..], &more[..]].concat());
        let foretold = message.split(" at once, ").nth(1).and_then(|rest| rest.split(' ').next());
        let foretold: f64 = foretold.unwrap().parse().unwrap();
        assert!(peak > 5.0 && peak <= foretold, "{structure}: {peak} MB of {foretold}");
        let less = format!("{}MB", (0.9 * foretold) as u64);
        let other = folder.path().join("other.zarr");
        let less =
            [&words[..6], &["-o", other.to_str().unwrap(), "--instances", "100", "--memory", &less]].concat();
        let (code, _, message) = run(&less);
        assert!(code == 2 && message.contains("raise --memory") && !other.exists(), "{structure}: {message}");
    }
}

/// A mesh, curves and a picture on them: what is foretold is enough, and not far more than is taken.
#[test]
fn scenes_stay_within_the_memory_that_is_foretold() {
    if !cfg!(target_os = "linux") {
        println!("skipped: the peak of memory is read from /proc");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let side = 330;
    let mut ply = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        side * side,
        (side - 1) * (side - 1)
    );
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        ply += &format!("{} {} {}\n", f64::from(x) * 0.01, f64::from(y) * 0.01, f64::from(x * y % 7) * 0.01);
    }
    for corner in (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x)) {
        ply += &format!("4 {corner} {} {} {}\n", corner + 1, corner + side + 1, corner + side);
    }
    write(folder.path(), "field.ply", &ply);
    let mut strands = String::new();
    for strand in 0..8000 {
        for k in 0..20 {
            let (x, y, turn) = (f64::from(strand % 100) * 0.04, f64::from(strand / 100) * 0.04, f64::from(k));
            // Segments that slant in every direction take most.
            strands += &format!(
                "{:.4} {:.4} {:.4} 0.002\n",
                x + 0.05 * turn.sin(),
                y + 0.01 * turn,
                0.05 * (1.7 * turn).cos()
            );
        }
        strands.push('\n');
    }
    write(folder.path(), "strands.txt", &strands);
    for object in ["mesh = 'field.ply'", "curves = 'strands.txt'\nbasis = 'linear'"] {
        let scene = format!(
            "preset = 'starling'\nshows_feather = false\n[surfaces.wall]\ntype = 'diffuse'\n[[objects]]\nsurface = 'wall'\n{object}\n"
        );
        let scene = write(folder.path(), "scene.toml", &scene);
        let out = folder.path().join("a.png");
        let words =
            ["render", &scene, "-o", out.to_str().unwrap(), "--size", "16x16", "--samples", "1", "--memory"];
        let (code, _, message) = run(&[&words[..], &["100MB"]].concat());
        assert!(
            code == 2 && message.contains("smaller meshes, curves or pictures") && !out.exists(),
            "{message}"
        );
        let foretold = message.split(" needs ").nth(1).and_then(|rest| rest.split(' ').next());
        let foretold: f64 = foretold.unwrap().parse().unwrap();
        let (peak, _) = peak_mb(&[&words[..], &["2GB"]].concat());
        assert!(peak <= foretold && foretold < 2.0 * peak, "{object}: {peak} MB of {foretold}");
        std::fs::remove_file(&out).unwrap();
    }
}

const TINY: &[&str] = &["--wavelengths", "400", "--directions", "2x2", "--instances", "1"];

#[test]
fn what_asks_for_much_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str, text: &str| write(folder.path(), name, text);
    let out = folder.path().join("out.svg");
    let out = out.to_str().unwrap();
    let tiny = at(
        "tiny.json",
        r#"{"barbule": 1, "units": "um", "width": 2000, "boundaries": [{"x": [-1000, 0, 1000], "z": [0, 0, 0]}],
            "lattice": {"period": 0.0002, "cortex": 0.1, "rod": [{"circles": [{"diameter": 0.0001, "medium": "melanin"}]}]}}"#,
    );
    let mut rods = String::from("[lattice]\nperiod = 20\ncortex = 0.1\n");
    for k in 0..200 {
        write!(
            rods,
            "[[lattice.rod]]\nx = {}\ncircles = [{{ diameter = 0.1, medium = 'melanin' }}]\n",
            0.1 * f64::from(k)
        )
        .unwrap();
    }
    let rods = at("rods.toml", &rods);
    let zigzag: Vec<_> = (0..401).map(|k| json!([5 * k - 1000, 0.1 * f64::from(k).sin()])).collect();
    let [x, z] = [0, 1].map(|part| zigzag.iter().map(|point| point[part].clone()).collect::<Vec<_>>());
    let wide = json!({"barbule": 1, "units": "um", "width": 2000, "boundaries": [{"x": x, "z": z}], "media": ["air", "keratin"]});
    let wide = at("wide.json", &wide.to_string());
    let far = ["--wavelength", "500", "--theta", "0", "--phi", "0"];
    for (words, said) in [
        (vec!["geometry", &tiny, "-o", out], "10000000 rods lie under a top of 2000 µm"),
        (vec!["crystal", &rods], "unknowns together, over 3000"),
        ([&["far-field", &rods], &far[..]].concat(), "unknowns together, over 3000"),
        (
            [&["far-field", "air/5000*(keratin:1/melanin:1)/air", "--memory", "300MB"], &far[..]].concat(),
            "but 300 MB are allowed; raise --memory",
        ),
        (
            vec!["spectrum", "air/keratin:3/air", "--wavelengths", "300:830:0.0054", "--angle=-89:89:0.0018"],
            "of memory, but",
        ),
        (
            vec![
                "simulate",
                "air/keratin:3/air",
                "-o",
                out,
                "--directions",
                "200x200",
                "--instances",
                "10000",
            ],
            "MB are free; give fewer",
        ),
        // What is foretold of it takes little memory itself.
        (
            [&["simulate", &wide, "-o", out, "--memory", "100MB", "--quiet"], TINY].concat(),
            "MB of memory, but 100 MB are allowed; raise --memory",
        ),
        (
            vec!["crystal", "mallard", "--wavelength", "299.999"],
            "--wavelength: 299.999 nm is outside 300 to 830 nm",
        ),
        (vec!["crystal", "mallard", "--wavelength", "831"], "--wavelength: 831 nm is outside 300 to 830 nm"),
        (vec!["crystal", "mallard", "--theta", "90"], "--theta: 90° is at or past grazing"),
        (vec!["geometry", "starling", "-o", out, "--memory", "1kB"], "the program itself needs about 16 MB"),
        (vec!["lobes", "starling", "-o", out, "--memory", "1kB"], "the program itself needs about 16 MB"),
    ] {
        let (code, printed, message) = run(&words);
        assert_eq!(code, 2, "{words:?}: {message}");
        assert!(message.contains(said) && message.len() < 600 && printed.is_empty(), "{words:?}: {message}");
        assert!(!Path::new(out).exists(), "{words:?}");
    }
}

#[test]
fn many_layers_of_one_medium_are_one_layer() {
    let far = |structure: &str| {
        document(&["far-field", structure, "--wavelength", "500", "--theta", "10", "--phi", "20"]).0
    };
    let (many, one) = (far("air/50000*(keratin:0.01)/air"), far("air/keratin:500/air"));
    for polarization in ["polarization_1", "polarization_2"] {
        let [many, one] =
            [&many, &one].map(|found| found[polarization]["reflected_fraction"].as_f64().unwrap());
        assert!((many / one - 1.0).abs() < 1e-6, "{many} {one}");
    }
}

#[test]
fn the_field_of_a_crystal_is_a_document_too() {
    let folder = tempfile::tempdir().unwrap();
    let figure = folder.path().join("f.svg");
    let figure = figure.to_str().unwrap();
    let (found, message) = document(&["crystal", "magpie", "--field", "--wavelength", "560", "-o", figure]);
    assert!(message.contains("wrote "), "{message}");
    let rows = found["permittivity"].as_array().unwrap();
    assert_eq!(found["intensity"].as_array().unwrap().len(), 2);
    assert_eq!(found["intensity"][1].as_array().unwrap().len(), rows.len());
    // Air lies above the surface, and keratin below the rods.
    let at = |row: usize| rows[row][0].as_f64().unwrap();
    assert!((at(rows.len() - 1) - 1.0).abs() < 1e-9 && at(0) > 2.0, "{} {}", at(rows.len() - 1), at(0));
}
