//! Formats of pictures, skies as Radiance files, metals, and exposures of dark things with highlights.

use std::path::Path;

use serde_json::Value;

use crate::common::{Ends as _, MADE_UP, program, said_by, write_made_up};

fn render(folder: &Path, words: &[&str]) -> (String, Value) {
    write_made_up();
    let output = program()
        .arg("render")
        .args(words)
        .args(["--size", "48x36", "--samples", "4", "--json"])
        .current_dir(folder)
        .output()
        .unwrap();
    let said = said_by(&output);
    assert!(output.status.success(), "{words:?}: {said}");
    let report: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap();
    (said, report[0].clone())
}

/// JPEG and WebP are of the same pixels as the PNG, and say how they were made.
#[test]
fn pictures_are_written_for_the_web() {
    let folder = tempfile::tempdir().unwrap();
    let draw = |name: &str| render(folder.path(), &["starling", "--material", MADE_UP, "-o", name]).1;
    let png = draw("a.png");
    for name in ["a.jpg", "a.jpeg", "a.webp"] {
        let report = draw(name);
        assert_eq!(report["pixel_hash"], png["pixel_hash"], "{name}");
        let bytes = std::fs::read(folder.path().join(name)).unwrap();
        assert!(bytes.len() > 500, "{name}");
        if name == "a.webp" {
            assert_eq!((&bytes[..4], &bytes[8..12]), (&b"RIFF"[..], &b"WEBP"[..]));
        } else {
            assert_eq!(bytes[..2], [0xff, 0xd8]);
        }
        let text = String::from_utf8_lossy(&bytes);
        for fact in ["command: barbule render starling", "seed: 1", "material_hash: ", "pixel_hash: "] {
            assert!(text.contains(fact), "{name} {fact}");
        }
    }
    render(folder.path(), &["starling", "--material", MADE_UP, "--background", "none", "-o", "cut.webp"]);
}

/// A ball that is nothing but a mirror or dull, in a sky alone.
fn ball(surface: &str) -> String {
    format!(
        "preset = 'starling'\nshows_feather = false\nlights = []\nexposure = 0.3\n[light]\nstrength = 0\n[sky_image]\nfile = 'sky.hdr'\n\
         [camera]\nwidth_mm = 3\ntarget_mm = [0, 0, 0]\n[surfaces.of]\n{surface}\n[[objects]]\nsphere_mm = 1\nsurface = 'of'\n"
    )
}

/// A sky of one colour in 8 x 4 pixels, plain or with a spot.
fn sky(spot: bool) -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    for pixel in 0..32 {
        bytes.extend(if spot && pixel == 6 { [128, 128, 128, 141] } else { [128, 128, 128, 129] });
    }
    bytes
}

/// The mean of the ball's middle, linear sRGB.
fn mean(folder: &Path) -> [f64; 3] {
    let image = barbule::io::image::read_exr(&folder.join("a.exr")).unwrap();
    let middle: Vec<[f32; 3]> =
        (12..24).flat_map(|y| (18..30).map(move |x| y * 48 + x)).map(|at| image.pixels[at]).collect();
    [0, 1, 2].map(|k| middle.iter().map(|pixel| f64::from(pixel[k])).sum::<f64>() / middle.len() as f64)
}

#[test]
fn skies_are_read_from_radiance_files_and_metals_have_their_colours_in_them() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("sky.hdr"), sky(false)).unwrap();
    let colour = |metal: &str| {
        let surface = format!("type = 'conductor'\nroughness = 0.05\nmetal = '{metal}'");
        std::fs::write(folder.path().join("s.toml"), ball(&surface)).unwrap();
        render(folder.path(), &["s.toml", "-o", "a.exr"]);
        mean(folder.path())
    };
    // Reflectances of the metals in a sky of radiance 1, nearly straight on.
    for (metal, expected) in
        [("gold", [1.03, 0.73, 0.36]), ("silver", [0.98, 0.98, 0.97]), ("aluminium", [0.91, 0.92, 0.92])]
    {
        let found = colour(metal);
        assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 0.05), "{metal} {found:?}");
    }
    std::fs::write(folder.path().join("sky.hdr"), &sky(false)[..60]).unwrap();
    let refused = program().args(["render", "s.toml", "-o", "b.png"]).current_dir(folder.path()).ends(2);
    let said = said_by(&refused);
    assert!(
        said.contains("sky.hdr: is cut off or damaged in line 1 of 4") && said.trim().lines().count() == 1,
        "{said}"
    );
}

/// Of a dark, glossy ball under a small bright lamp a share that the key alone would leave white keeps its colours.
#[test]
fn automatic_exposure_keeps_highlights_and_takes_stops() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("sky.hdr"), sky(true)).unwrap();
    std::fs::write(
        folder.path().join("s.toml"),
        ball("type = 'keratin'\nroughness = 0.3\nindex = 1.56\nmelanin = 50"),
    )
    .unwrap();
    let draw = |exposure: &str| {
        let (_, report) = render(folder.path(), &["s.toml", "-o", "a.png", "--exposure", exposure]);
        let factor = report["exposure"].as_str().unwrap().parse::<f64>().unwrap();
        (factor, report["clipped"].as_f64().unwrap())
    };
    let (auto, clipped) = draw("auto");
    let (_, brighter) = draw(&(4.0 * auto).to_string());
    println!("clipped: {clipped:.3} by auto, {brighter:.3} two stops brighter");
    assert!(clipped <= 0.02 && brighter > 2.0 * clipped + 0.01, "{clipped} {brighter}");
    let (darker, none) = draw("auto-1.5");
    assert!((darker / auto - 2.0_f64.powf(-1.5)).abs() < 1e-12 && none <= clipped);
    assert!((draw("+1").0 - 0.6).abs() < 1e-12, "of the scene's 0.3");
    assert!((draw("-2").0 - 0.075).abs() < 1e-12);
    let scene = std::fs::read_to_string(folder.path().join("s.toml")).unwrap();
    std::fs::write(folder.path().join("s.toml"), scene.replace("exposure = 0.3", "exposure = 'auto+1'"))
        .unwrap();
    let (_, report) = render(folder.path(), &["s.toml", "-o", "a.png"]);
    let factor = report["exposure"].as_str().unwrap().parse::<f64>().unwrap();
    assert!((factor / auto - 2.0).abs() < 1e-12);
}

#[test]
fn a_key_light_that_does_not_shine_stands_nowhere() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("sky.hdr"), sky(false)).unwrap();
    std::fs::write(folder.path().join("s.toml"), ball("type = 'diffuse'")).unwrap();
    let (said, _) = render(folder.path(), &["s.toml", "-o", "a.png", "--light", "60,40"]);
    assert!(said.contains("--light has no effect here: the scene's key light has strength 0"), "{said}");
    assert!(said.contains("wrote a.png: 48 x 36 pixels, 4.0 samples each, lit by image 650"), "{said}");
    let (said, _) =
        render(folder.path(), &["starling", "--material", MADE_UP, "-o", "a.png", "--light", "60,40"]);
    assert!(said.contains("light 60,40, 48 x 36 pixels") && !said.contains("no effect"), "{said}");
}

/// A white card that lies in the light of a tungsten lamp, as a preset of its own.
const CARD: &str = "exposure = 0.3\nsky = 0\n[camera]\nazimuth_deg = 0\nelevation_deg = 80\nwidth_mm = 3\n[[lights]]\ntype = 'sun'\nazimuth_deg = 0\n\
    elevation_deg = 90\nstrength = 2\nilluminant = 'A'\n[surfaces.of]\ntype = 'diffuse'\ncolour = '#ffffff'\n[[objects]]\nrectangle_mm = [9, 9]\nsurface = 'of'\n";

/// The card in the lamp's white is neutral: ΔE00 below 1, by that of the lamp as by its temperature, and orange without.
#[test]
fn a_white_card_is_white_by_the_balance_of_its_lamp() {
    use barbule::spectrum::colour::{D65_WHITE, decode, xyz_from_rgb};
    use barbule::spectrum::difference::{delta_e_2000, lab};
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("s.toml"), CARD).unwrap();
    let seen = |more: &[&str]| {
        let (said, report) = render(folder.path(), &[&["s.toml", "-o", "a.png"], more].concat());
        assert!(said.contains("lit by A 285"), "{said}");
        let bytes = std::fs::read(folder.path().join("a.png")).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut rgb).unwrap();
        // A pixel of few paths has chance's colours; the middle of the card has 432.
        let middle = || (9..27).flat_map(|y| (12..36).map(move |x| 3 * (y * 48 + x)));
        let mean = |k: usize| middle().map(|at| decode(f64::from(rgb[at + k]) / 255.0)).sum::<f64>() / 432.0;
        let linear: [f64; 3] = std::array::from_fn(mean);
        let shown = lab(xyz_from_rgb(linear), D65_WHITE);
        (delta_e_2000(shown, [shown[0], 0.0, 0.0]), report)
    };
    let (orange, report) = seen(&[]);
    assert_eq!(report["lamps"][0]["name"], "lights[0]");
    assert_eq!((&report["lamps"][0]["illuminant"], &report["white_balance"]), (&"A".into(), &"none".into()));
    assert!((report["lamps"][0]["cct_k"].as_f64().unwrap() - 2856.0).abs() < 10.0, "{report}");
    let (auto, report) = seen(&["--white-balance", "auto"]);
    assert_eq!(report["white_balance"], "auto");
    let (by_number, _) = seen(&["--white-balance", "2856"]);
    let (film, report) = seen(&["--white-balance", "auto", "--tone", "filmic"]);
    assert_eq!(report["tone"], "filmic");
    println!(
        "ΔE00 of the card: {orange:.1} as it is, {auto:.2} by auto, {by_number:.2} by 2856 K, {film:.2} on film"
    );
    assert!(
        orange > 15.0 && auto < 1.0 && by_number < 1.0 && film < 1.0,
        "{orange} {auto} {by_number} {film}"
    );
}

/// Qualities set samples and noise; what is given beside them holds.
#[test]
fn qualities_are_samples_and_noise_in_a_word() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("s.toml"), CARD).unwrap();
    let draw = |words: &[&str]| {
        let output = program()
            .args(["render", "s.toml", "-o", "a.png", "--size", "16x12", "--json"])
            .args(words)
            .current_dir(folder.path())
            .output()
            .unwrap();
        let said = said_by(&output);
        (
            output.status.code(),
            said,
            serde_json::from_slice::<Vec<Value>>(&output.stdout).ok().map(|all| all[0].clone()),
        )
    };
    let (_, _, draft) = draw(&["--quality", "draft"]);
    let draft = draft.unwrap();
    assert_eq!(
        (&draft["samples"], &draft["quality"], draft.get("noise_target_percent")),
        (&"8.0".into(), &"draft".into(), None)
    );
    let (_, said, good) = draw(&["--quality", "good"]);
    let good = good.unwrap();
    assert_eq!(
        (good["noise_target_percent"].as_f64(), &good["noise_reached"]),
        (Some(4.0), &true.into()),
        "{said} {good}"
    );
    let (_, _, both) = draw(&["--quality", "final", "--samples", "3"]);
    assert_eq!(both.unwrap()["paths"], 3 * 16 * 12);
    let (code, said, _) = draw(&["--quality", "fnal"]);
    assert!(code == Some(2) && said.contains("did you mean 'final'"), "{said}");
}

/// Without the library one sentence says how to install it, before anything is drawn; with it the light stays and the noise goes.
#[test]
fn noise_is_taken_away_where_the_library_is() {
    use barbule::io::image::read_exr;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("s.toml"), ball("type = 'diffuse'")).unwrap();
    std::fs::write(folder.path().join("sky.hdr"), sky(true)).unwrap();
    let draw = |name: &str, samples: &str, more: &[&str]| {
        program()
            .args(["render", "s.toml", "--size", "160x120", "--samples", samples, "-o", name])
            .args(more)
            .current_dir(folder.path())
            .output()
            .unwrap()
    };
    let run = draw("no.exr", "4", &["--denoise=nowhere/libOpenImageDenoise.so.2"]);
    let said = said_by(&run);
    assert_eq!(run.status.code(), Some(2));
    assert!(
        said.contains("--denoise: nowhere/libOpenImageDenoise.so.2") && said.trim().lines().count() == 1,
        "{said}"
    );
    assert!(!folder.path().join("no.exr").exists());
    let run = draw("clean.exr", "4", &["--denoise"]);
    let said = said_by(&run);
    if run.status.code() == Some(2) {
        println!("Open Image Denoise is not installed here: only what is said without it is tested");
        assert!(said.contains("is not installed; install it (Debian") && said.len() < 600, "{said}");
        return;
    }
    assert!(run.status.success() && said.contains("denoised by Open Image Denoise "), "{said}");
    assert!(
        draw("noisy.exr", "4", &[]).status.success() && draw("reference.exr", "256", &[]).status.success()
    );
    let [clean, noisy, reference] = ["clean", "noisy", "reference"]
        .map(|name| read_exr(&folder.path().join(format!("{name}.exr"))).unwrap().pixels);
    let (mut mean, mut squares) = ([0.0; 2], [0.0; 2]);
    for (place, image) in [clean, noisy].iter().enumerate() {
        for (own, known) in image.iter().zip(&reference) {
            let away = f64::from(own[1]) - f64::from(known[1]);
            mean[place] += f64::from(own[1]);
            squares[place] += away * away;
        }
    }
    let known: f64 = reference.iter().map(|pixel| f64::from(pixel[1])).sum();
    let fallen = (squares[1] / squares[0]).sqrt();
    println!("RMSE falls by {fallen:.2}, mean {:.4}", mean[0] / known);
    assert!(fallen > 1.5 && (mean[0] / known - 1.0).abs() < 0.01, "{fallen} {}", mean[0] / known);
}
