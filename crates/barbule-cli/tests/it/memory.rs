//! Memory said is memory used: every command that grows with its input foretells it before it takes it, and keeps to what is allowed.

use std::fmt::Write as _;
use std::path::Path;

use super::limits::write;
use crate::common::run_and_peak;

/// What a run took, foretold and said.
struct Run {
    code: i32,
    /// As [`run_and_peak`] has it, MB.
    peak: f64,
    /// The largest that was foretold, MB.
    foretold: f64,
    message: String,
}

fn run(words: &[&str]) -> Run {
    let (output, peak) = run_and_peak(&[words, &["-v", "--threads", "2"]].concat());
    let message = String::from_utf8(output.stderr).unwrap();
    let foretold = message
        .lines()
        .filter_map(|line| line.strip_suffix(" MB of memory")?.rsplit_once(": up to ")?.1.parse::<f64>().ok())
        .fold(0.0, f64::max);
    Run { code: output.status.code().unwrap(), peak, foretold, message }
}

/// The command takes what is foretold and not far less; with less it is refused at once, within what is allowed, and leaves nothing.
fn keeps_to_what_is_foretold(words: &[&str], file: &Path) {
    let Run { code, peak, foretold, message } = run(words);
    assert_eq!(code, 0, "{words:?}: {message}");
    if cfg!(target_os = "linux") {
        assert!(peak > 5.0 && peak <= 1.2 * foretold, "{words:?}: {peak} MB of {foretold}");
        assert!(foretold < 2.0 * peak + 40.0, "{words:?}: {peak} MB of {foretold}");
    }
    let _ = std::fs::remove_file(file);
    is_refused(words, (0.9 * foretold) as u64, file);
}

/// With so many MB the command is refused, and does not take them.
fn is_refused(words: &[&str], allowed: u64, file: &Path) {
    let less = format!("{allowed}MB");
    let Run { code, peak, message, .. } = run(&[words, &["--memory", &less]].concat());
    assert!(code == 2 && message.contains("raise --memory"), "{words:?} within {less}: {message}");
    assert!(peak <= 1.2 * allowed as f64, "{words:?} within {less}: {peak} MB");
    assert!(!file.exists(), "{words:?} within {less}");
}

/// Before, the turns of all orders at all cells were held: 2 GB for each wavelength.
#[test]
fn values_of_a_wide_patch_take_memory_for_its_heights_alone() {
    let folder = tempfile::tempdir().unwrap();
    let heights: String = (0..300_000).map(|k| if k % 7 < 3 { "0.1 " } else { "0 " }).collect();
    let heights = write(folder.path(), "row.txt", &heights);
    let none = folder.path().join("none");
    let words = ["diffract", &heights, "--wi", "10,20", "--wo", "10,200", "--wavelengths", "450,550"];
    keeps_to_what_is_foretold(&[&words[..], &["--pitch", "0.003"]].concat(), &none);
    // Far wider than the coherence: refused before anything is summed.
    let Run { code, peak, message, .. } = run(&[&words[..], &["--pitch", "0.1"]].concat());
    assert!(
        code == 2 && message.contains("a patch of 30000 µm is far wider than the coherence"),
        "{message}"
    );
    assert!(peak < 60.0, "{peak}");
}

fn npy(folder: &Path, side: usize) -> String {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({side}, {side}), }}");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    let height = |place: usize| 0.05 * f64::from((place % side / 8 % 2) as u8);
    bytes.extend((0..side * side).flat_map(|place| height(place).to_le_bytes()));
    let path = folder.join("heights.npy");
    std::fs::write(&path, bytes).unwrap();
    path.to_string_lossy().into_owned()
}

#[test]
fn heights_are_refused_by_their_headers() {
    let folder = tempfile::tempdir().unwrap();
    let none = folder.path().join("none");
    let heights = npy(folder.path(), 2500);
    let words =
        ["diffract", &heights, "--pitch", "0.02", "--wi", "0,0", "--wo", "10,0", "--wavelengths", "600"];
    keeps_to_what_is_foretold(&words, &none);
    let Run { peak, message, .. } = run(&[&words[..], &["--memory", "70MB"]].concat());
    assert!(message.contains("heights.npy needs 166 MB") && peak < 30.0, "{peak} MB: {message}");
}

#[test]
fn gratings_and_their_pictures_keep_to_what_is_foretold() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["blazed.grating", "blazed.png"] {
        let file = folder.path().join(name);
        keeps_to_what_is_foretold(
            &["diffract", "blazed", "--size", "201", "-o", file.to_str().unwrap()],
            &file,
        );
    }
}

fn white(path: &Path, size: [u32; 2]) {
    let mut encoder = png::Encoder::new(std::fs::File::create(path).unwrap(), size[0], size[1]);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    let pixels = vec![255; (size[0] * size[1]) as usize];
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
}

/// A picture on many surfaces is read once; on surfaces that no object has it is not read at all.
#[test]
fn pictures_on_surfaces_are_held_once_and_refused_by_their_headers() {
    let folder = tempfile::tempdir().unwrap();
    white(&folder.path().join("t.png"), [2048, 1024]);
    let mut scene = "preset = 'starling'\nshows_feather = false\n".to_owned();
    for k in 0..40 {
        let _ = writeln!(scene, "[surfaces.t{k}]\ntype = 'diffuse'\nalbedo = 't.png'");
    }
    let balls = |count: usize| {
        (0..count)
            .map(|k| format!("[[objects]]\nsphere_mm = 1\nsurface = 't{k}'\ntranslate_mm = [{k}, 0, 0]\n"))
            .collect::<String>()
    };
    let picture = folder.path().join("a.png");
    let render = |count: usize| {
        let scene = write(folder.path(), "scene.toml", &(scene.clone() + &balls(count)));
        let words = ["render", &scene, "--size", "8x6", "--samples", "1", "-o", picture.to_str().unwrap()];
        words.map(str::to_owned)
    };
    let words = render(12);
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    keeps_to_what_is_foretold(&words, &picture);
    let Run { peak, message, .. } = run(&[&words[..], &["--memory", "60MB"]].concat());
    assert!(message.contains("needs") && peak < 40.0, "{peak} MB: {message}");
    let words = render(0);
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let Run { code, peak, message, .. } = run(&[&words[..], &["--memory", "60MB"]].concat());
    assert!(code == 0 && peak < 60.0, "{peak} MB: {message}");
}

/// A mesh of a hundred thousand triangles a hundred times says in its header that it does not fit.
#[test]
fn meshes_are_held_once_and_refused_by_their_headers() {
    let folder = tempfile::tempdir().unwrap();
    let side = 200_u32;
    let mut ply = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        side * side,
        (side - 1) * (side - 1)
    )
    .into_bytes();
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        ply.extend(
            [x as f32 * 0.01, y as f32 * 0.01, (x * y % 7) as f32 * 0.01]
                .iter()
                .flat_map(|v| v.to_le_bytes()),
        );
    }
    for corner in (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x)) {
        ply.push(4);
        ply.extend(
            [corner, corner + 1, corner + side + 1, corner + side].iter().flat_map(|v| v.to_le_bytes()),
        );
    }
    std::fs::write(folder.path().join("m.ply"), ply).unwrap();
    let picture = folder.path().join("a.png");
    let render = |count: usize| {
        let object = "[[objects]]\nsurface = 'w'\nmesh = 'm.ply'\n".repeat(count);
        let scene =
            format!("preset = 'starling'\nshows_feather = false\n[surfaces.w]\ntype = 'diffuse'\n{object}");
        let scene = write(folder.path(), "scene.toml", &scene);
        ["render", &scene, "--size", "8x6", "--samples", "1", "-o", picture.to_str().unwrap()]
            .map(str::to_owned)
    };
    let words = render(3);
    keeps_to_what_is_foretold(&words.each_ref().map(String::as_str), &picture);
    let words = render(100);
    let words = words.each_ref().map(String::as_str);
    let Run { code, peak, message, .. } = run(&[&words[..], &["--memory", "900MB"]].concat());
    assert!(code == 2 && message.contains("smaller meshes") && peak < 40.0, "{peak} MB: {message}");
}

/// Of every level, those of long downy barbs too; what is allowed is kept before anything grows.
#[test]
fn grown_feathers_keep_to_what_is_foretold() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("a.png");
    for (level, more) in [
        ("barbules", "[window]\nalong_mm = 20\nradius_mm = 8\n"),
        ("barbs", "[feather.barbs]\nspacing_um = 60\n"),
        ("barbules", ""),
        ("vane", ""),
        ("envelopes", ""),
        (
            "barbules",
            "[window]\nalong_mm = 20\nradius_mm = 3\n[feather.downy]\nshare = 1\nbarb_length_mm = 60\n",
        ),
    ] {
        let scene = format!("preset = 'starling-feather'\n[detail]\nlevel = '{level}'\n{more}");
        let scene = write(folder.path(), "scene.toml", &scene);
        let words = ["render", &scene, "--size", "8x6", "--samples", "1", "-o", picture.to_str().unwrap()];
        keeps_to_what_is_foretold(&words, &picture);
    }
    let long =
        "preset = 'starling-feather'\n[feather.shaft]\nlength_mm = 2000\n[feather.barbs]\nspacing_um = 5\n";
    let long = write(folder.path(), "long.toml", long);
    for (command, file) in [("render", "b.png"), ("feather", "b.ply")] {
        let file = folder.path().join(file);
        let Run { code, peak, message, .. } =
            run(&[command, &long, "-o", file.to_str().unwrap(), "--memory", "300MB"]);
        assert!(
            code == 2 && message.contains("raise --memory") && peak < 60.0,
            "{command}: {peak} MB: {message}"
        );
    }
}

#[test]
fn feathers_are_written_within_what_is_foretold() {
    let folder = tempfile::tempdir().unwrap();
    let fine =
        write(folder.path(), "fine.toml", "preset = 'starling-feather'\n[feather.barbs]\nspacing_um = 10\n");
    for ending in ["ply", "obj", "gltf", "usda", "pbrt", "txt"] {
        let file = folder.path().join(format!("f.{ending}"));
        keeps_to_what_is_foretold(
            &["feather", &fine, "--level", "barbs", "-o", file.to_str().unwrap()],
            &file,
        );
    }
    let file = folder.path().join("barbules.ply");
    keeps_to_what_is_foretold(
        &["feather", "starling-feather", "--level", "barbules", "-o", file.to_str().unwrap()],
        &file,
    );
}

/// Scenes with samples of heights, whose powers are made for them.
#[test]
fn samples_of_scenes_are_foretold() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("a.png");
    let words =
        ["render", "diffraction-bench", "--size", "8x6", "--samples", "1", "-o", picture.to_str().unwrap()];
    is_refused(&words, 60, &picture);
}

/// Spectra of many instances, and the statistics of a store while they are fitted.
#[test]
fn spectra_and_fits_keep_to_what_is_foretold() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (summary, store, material) = (at("s.csv"), at("s.zarr"), at("m.barbule"));
    let spectrum =
        ["spectrum", "hummingbird", "--wavelengths", "400:690:10", "--instances", "4", "--summary", &summary];
    keeps_to_what_is_foretold(&spectrum, Path::new(&summary));
    let simulate = ["simulate", "starling", "--thin", "10", "--instances", "4", "-o", &store];
    assert_eq!(run(&simulate).code, 0);
    keeps_to_what_is_foretold(&["fit", &store, "-o", &material], Path::new(&material));
}

#[test]
fn numbers_and_their_texts_are_foretold() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("t.csv");
    let path = table.to_str().unwrap();
    let film = ["film", "air/keratin:300/air", "--wavelengths", "300:830:2", "--angles", "0:80:0.5"];
    let brdf = ["brdf", "starling", "--wavelength", "400:690:10", "--wi", "0,10", "--wo-grid", "90"];
    let far = [
        "far-field",
        "air/keratin:300/air",
        "--wavelength",
        "500",
        "--theta",
        "0:40:10",
        "--phi",
        "0:50:10",
        "--azimuths",
        "5000",
    ];
    for words in [&film[..], &brdf, &far] {
        keeps_to_what_is_foretold(&[words, &["--csv", path]].concat(), &table);
        keeps_to_what_is_foretold(&[words, &["--json"]].concat(), &table);
    }
}
