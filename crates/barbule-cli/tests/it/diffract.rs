//! `barbule diffract`, and gratings in scenes.

use std::path::Path;

use crate::common::{json, run};

fn refusal(words: &[&str]) -> String {
    let (code, _, said) = run(words);
    assert_eq!((code, said.trim().lines().count()), (2, 1), "{said}");
    said
}

/// f of the blazed grating where its first order of 500 nm leaves, by its closed form: sinc² of a ramp of single steps.
#[test]
fn a_blazed_grating_sends_500_nm_to_its_first_order() {
    let found = json(&["diffract", "blazed", "--wi", "0,0", "--wo", "11.536959,0", "--json"]);
    let nm: Vec<f64> = serde_json::from_value(found["wavelength_nm"].clone()).unwrap();
    let f: Vec<f64> = serde_json::from_value(found["spectrum"].clone()).unwrap();
    assert_eq!((nm.len(), nm[0], nm[80]), (81, 380.0, 780.0));
    let peak = (0..81).max_by(|a, b| f[*a].total_cmp(&f[*b])).unwrap();
    assert_eq!(nm[peak], 500.0);
    let cos_o = 11.536_959_f64.to_radians().cos();
    let half = 0.5 * 11.536_959_f64.to_radians();
    let t = (1.0 - half.sin().powi(2) / 2.25).sqrt();
    let (s, p) =
        ((half.cos() - 1.5 * t) / (half.cos() + 1.5 * t), (1.5 * half.cos() - t) / (1.5 * half.cos() + t));
    let reflectance = 0.5 * (s * s + p * p);
    let x = std::f64::consts::PI * ((1.0 + cos_o) * 0.24623 / 0.5 - 1.0);
    let s_f = 1.0 / (std::f64::consts::TAU * 16.25);
    // Γ = 1/cosθ_o at normal incidence.
    let expected = reflectance / cos_o * (x.sin() / x).powi(2) / (0.25 * std::f64::consts::PI * s_f * s_f);
    assert!((f[peak] / expected - 1.0).abs() < 2e-4, "{} {expected}", f[peak]);
    let [tables, reference] = ["tables", "reference"]
        .map(|of| serde_json::from_value::<[f64; 3]>(found["xyz"][of].clone()).unwrap());
    for (a, b) in tables.iter().zip(reference) {
        assert!((a / b - 1.0).abs() < 4e-3, "{tables:?} {reference:?}");
    }
    assert!(found["delta_e"].as_f64().unwrap() < 0.05, "{found}");
    // To the other side goes hardly anything.
    let other = json(&["diffract", "blazed", "--wi", "0,0", "--wo", "11.536959,180", "--json"]);
    assert!(other["spectrum"][24].as_f64().unwrap() < 1e-3 * f[peak]);
}

/// The same heights from a file as the sample, in single precision: the same values.
#[test]
fn heights_from_a_file_are_as_good_as_a_sample() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sine.npy");
    let heights = (0..2600).map(|i| 0.123 * f64::cos(std::f64::consts::TAU * f64::from(i % 100) / 100.0));
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2600), }\n";
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(heights.flat_map(f64::to_le_bytes));
    std::fs::write(&path, bytes).unwrap();
    let directions = ["--wi", "20,0", "--wo", "7.5,180", "--json"];
    let file = path.to_str().unwrap();
    let own = json(&[&["diffract", file, "--pitch", "0.025"], &directions[..]].concat());
    let sample = json(&[&["diffract", "sinusoid"], &directions[..]].concat());
    // One row stands for a patch 0.025 µm long along y, along which nothing changes.
    for (a, b) in own["spectrum"].as_array().unwrap().iter().zip(sample["spectrum"].as_array().unwrap()) {
        let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
        assert!((a - b).abs() <= 1e-9 * b.abs() + 1e-12, "{a} {b}");
    }
    let far = run(&[&["diffract", file, "--pitch", "25"], &directions[..]].concat()).2;
    assert!(far.contains("--pitch 25: heights 25 µm apart; did you mean 0.025 (25 nm)?"), "{far}");
    let said = refusal(&[&["diffract", file], &directions[..]].concat());
    assert!(said.contains("sine.npy") && said.contains("--pitch"), "{said}");
}

#[test]
fn what_cannot_be_is_refused_in_one_sentence() {
    assert!(refusal(&["diffract", "blazd", "-o", "a.png"]).contains("did you mean 'blazed'"));
    assert!(refusal(&["diffract", "blazed"]).contains("nothing to do"));
    // What a file lacks is said at once, and not only when there is something to do.
    let folder = tempfile::tempdir().unwrap();
    let heights = folder.path().join("afm.txt").to_string_lossy().into_owned();
    std::fs::write(&heights, "0 1\n1 0\n").unwrap();
    let said = refusal(&["diffract", &heights]);
    assert!(said.contains("give --pitch, their distance in µm; and give -o FIG"), "{said}");
    assert!(refusal(&["diffract", &heights, "--pitch", "0.1"]).contains("nothing to do: give -o FIG"));
    assert!(refusal(&["diffract", "blazed", "--wi", "10,0", "--json"]).contains("give --wo too"));
    assert!(refusal(&["diffract", "blazed", "--wi", "95,0", "--wo", "0,0"]).contains("POLAR,AZIMUTH"));
    assert!(refusal(&["diffract", "blazed", "-o", "a.jpg"]).contains(".svg, .pdf or .png"));
    assert!(refusal(&["diffract", "blazed", "--size", "10", "-o", "a.png"]).contains("odd number"));
    assert!(refusal(&["diffract", "blazed", "--pitch", "1", "-o", "a.png"]).contains("--pitch is of files"));
    assert!(refusal(&["diffract", "blazed", "--coherence", "0", "-o", "a.png"]).contains("coherence"));
    assert!(
        refusal(&["diffract", "none.npy", "--pitch", "1", "-o", "a.png"]).contains("none.npy: no such file")
    );
    assert!(!Path::new("a.png").exists());
}

/// From heights to a file to a picture; a damaged file is refused.
#[test]
fn a_grating_of_ones_own_is_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let ridges: String = (0..40).map(|i| format!("{} ", 0.1 * f64::from(i % 20) / 20.0)).collect();
    std::fs::write(path("ridges.txt"), ridges).unwrap();
    let (heights, grating) = (path("ridges.txt"), path("ridges.grating"));
    let told = json(&["diffract", &heights, "--pitch", "0.1", "--size", "21", "-o", &grating, "--json"]);
    assert_eq!((told["file"].as_str(), &told["heights"]), (Some(&*grating), &"ridges".into()));
    assert!(told["tables"].as_u64() > Some(0) && told["orders"].as_array().unwrap().len() == 2, "{told}");
    let figure = path("blazed.svg");
    let few = ["--wavelengths", "400:700:50", "--size", "21"];
    let drawn = json(&[&["diffract", "blazed", "-o", &figure, "--json"], &few[..]].concat());
    assert_eq!((drawn["file"].as_str(), &drawn["heights"]), (Some(&*figure), &"blazed".into()));
    assert!(drawn["mean_delta_e"].is_number() && drawn["largest_of_peak"].is_number(), "{drawn}");
    let scene = "preset = 'starling'\nshows_feather = false\n[surfaces.disc]\ntype = 'grating'\nfile = 'ridges.grating'\n\
                 pigment = '#402010'\n[[objects]]\nsphere_mm = 0.5\nsurface = 'disc'\n";
    std::fs::write(path("disc.toml"), scene).unwrap();
    let render = |name: &str| {
        run(&["render", &path("disc.toml"), "--size", "24x16", "--samples", "2", "-o", &path(name)])
    };
    let (code, _, said) = render("disc.png");
    assert_eq!(code, 0, "{said}");
    let picture = std::fs::read(path("disc.png")).unwrap();
    render("again.png");
    assert!(picture.len() > 300 && std::fs::read(path("again.png")).is_ok());
    let mut bytes = std::fs::read(path("ridges.grating")).unwrap();
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    std::fs::write(path("ridges.grating"), bytes).unwrap();
    let (code, _, said) = render("none.png");
    assert!(code == 2 && said.contains("surfaces.disc.file") && said.contains("checksum"), "{said}");
}

#[test]
fn snakes_and_the_bench_render() {
    let folder = tempfile::tempdir().unwrap();
    for (name, coloured) in [("snake", true), ("diffraction-bench", false)] {
        let path = folder.path().join(name).with_extension("png");
        let words = ["render", name, "--size", "48x30", "--samples", "4", "-o", path.to_str().unwrap()];
        let (code, _, said) = run(&words);
        assert_eq!(code, 0, "{said}");
        let decoder = png::Decoder::new(std::io::Cursor::new(std::fs::read(&path).unwrap()));
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        let spread = |p: &[u8]| p.iter().max().unwrap() - p.iter().min().unwrap();
        let vivid = pixels.chunks_exact(3).filter(|p| spread(p) > 80).count();
        assert!(!coloured || vivid > 30, "{name}: {vivid} pixels of strong colour");
        assert!(pixels.iter().any(|v| *v > 60), "{name} is dark");
    }
    let (_, out, _) = run(&["render", "snake", "--toml"]);
    assert!(out.contains("sample = \"xenopeltis\""));
}

/// Far from every order a table has zeros, and the exact sum what rounding leaves: both are black.
#[test]
fn black_beside_black_is_no_difference_and_no_zero_has_a_sign() {
    let folder = tempfile::tempdir().unwrap();
    let found = json(&["diffract", "blazed", "--wi", "0,0", "--wo", "5,90", "--json"]);
    assert_eq!(found["delta_e"], 0.0, "{found}");
    let path = folder.path().join("flat.txt").to_string_lossy().into_owned();
    std::fs::write(&path, "0 0.1 0 0.1 0 0.1 0 0.1\n".repeat(8)).unwrap();
    // Steps of 1 µm tell nothing of directions so far from the mirror's.
    let words =
        ["diffract", &path, "--pitch", "1", "--wi", "0,0", "--wo", "70,0", "--place", "anywhere", "--json"];
    let (code, out, said) = run(&words);
    assert_eq!(code, 0, "{said}");
    assert!(out.contains("0.0") && !out.contains("-0.0"), "{out}");
}
