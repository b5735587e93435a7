//! `barbule render` as people and scripts use it.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::common::{CLOSE_UP, Ends as _, MADE_UP, program, said_by, write_made_up};

pub(crate) fn barbule(folder: &Path, arguments: &[&str]) -> Command {
    write_made_up();
    let mut command = program();
    command.args(["render"]).args(arguments).current_dir(folder);
    command
}

/// Small and without a simulated material: a second or two.
pub(crate) const QUICK: &[&str] = &["--material", MADE_UP, "--size", "48x30", "--samples", "4"];

#[test]
fn a_picture_is_a_png_that_says_where_it_comes_from() {
    let folder = tempfile::tempdir().unwrap();
    let words = ["starling", "-o", "s.png", "--json", "--light=60,45", "--seed", "7", "--arc", "light=30"];
    let arguments = [&words[..], QUICK].concat();
    let output = barbule(folder.path(), &arguments).output().unwrap();
    let said = said_by(&output);
    assert!(output.status.success(), "{said}");
    assert_eq!(said.matches("--arc or --path has no effect here: there is one frame").count(), 1, "{said}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let barbs = report[0]["barbs"].as_u64().unwrap();
    let barbules = report[0]["barbules"].as_u64().unwrap();
    assert!((15..=60).contains(&barbs) && (5_000..=30_000).contains(&barbules), "{report}");
    assert_eq!((&report[0]["light"], &report[0]["seed"]), (&"60,45".into(), &7.into()));
    let bytes = std::fs::read(folder.path().join("s.png")).unwrap();
    assert_eq!(&bytes[1..4], b"PNG");
    // Width, height, 8 bits, RGB.
    assert_eq!(bytes[16..26], [0, 0, 0, 48, 0, 0, 0, 30, 8, 2]);
    let text = String::from_utf8_lossy(&bytes);
    for word in ["command", "version", "material_hash", "seed", "barbule render starling"] {
        assert!(text.contains(word), "{word}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn what_lower_sides_wear_is_said_by_a_flag_and_kept_in_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let toml = |arguments: &[&str]| {
        let output = barbule(folder.path(), arguments).output().unwrap();
        assert!(output.status.success(), "{}", said_by(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    let text = toml(&["mallard", "--under", "keratin", "--toml"]);
    assert!(text.contains("under = \"keratin\"\n"), "{text}");
    std::fs::write(folder.path().join("dark.toml"), text).unwrap();
    assert!(toml(&["dark.toml", "--under", "default", "--toml"]).contains("underside"));
    assert!(!toml(&["dark.toml", "--under", "default", "--toml"]).contains("under = "));
    // The material is read, and named in the picture.
    let seen_from_below = ["--view=180,-60", "--under", MADE_UP, "-o", "s.png"];
    let arguments = [&["starling"], &seen_from_below[..], QUICK].concat();
    barbule(folder.path(), &arguments).ends(0);
    let refused = barbule(folder.path(), &["starling", "--under", "malard", "-o", "n.png"]).output().unwrap();
    let message = said_by(&refused);
    assert!(refused.status.code() == Some(2) && message.contains("did you mean 'mallard'"), "{message}");
    assert!(!folder.path().join("n.png").exists());
}

#[test]
fn exr_frames_and_scene_files_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let scene = format!(
        "preset = \"hummingbird\"\nmaterial = '{MADE_UP}'\nsize = [40, 24]\n[light]\nazimuth = 10.0\n"
    );
    std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let arguments = ["scene.toml", "-o", "h.exr", "--frames", "2", "--samples", "2"];
    barbule(folder.path(), &arguments).ends(0);
    for name in ["h-0000.exr", "h-0001.exr"] {
        let bytes = std::fs::read(folder.path().join(name)).unwrap();
        assert_eq!(bytes[..4], [0x76, 0x2f, 0x31, 0x01]);
        let text = String::from_utf8_lossy(&bytes[..4000.min(bytes.len())]).into_owned();
        for plane in ["normal.X", "depth.Z", "barbule.ID", "variance.Y", "samples.N", "material_hash"] {
            assert!(text.contains(plane), "{plane}");
        }
    }
    // A picture is an image of a sky as any other.
    let under =
        "preset = \"starling\"\n[sky_image]\nfile = \"h-0000.exr\"\nturn = 30.0\n[light]\nstrength = 0.0\n";
    std::fs::write(folder.path().join("under.toml"), under).unwrap();
    barbule(folder.path(), &[&["under.toml", "-o", "u.png"], QUICK].concat()).ends(0);
    std::fs::write(folder.path().join("under.toml"), under.replace("h-0000", "none")).unwrap();
    let refused = barbule(folder.path(), &[&["under.toml", "-o", "u.png"], QUICK].concat()).ends(2);
    assert!(said_by(&refused).contains("none.exr: no such file"));
}

/// Three frames of a turning light: one feather is grown, and each frame is the picture under its light alone.
#[test]
fn frames_share_one_feather_and_its_hierarchy() {
    let folder = tempfile::tempdir().unwrap();
    let common =
        ["starling", "--light=20,50", "-o", "f.png", "--frames", "3", "--arc", "light=360", "--verbose"];
    let output = barbule(folder.path(), &[&common[..], QUICK].concat()).output().unwrap();
    let log = said_by(&output);
    assert!(output.status.success(), "{log}");
    assert_eq!(log.matches("primitives; ready in").count(), 1, "{log}");
    assert_eq!(log.lines().filter(|line| line.starts_with("light ")).count(), 3, "{log}");
    barbule(folder.path(), &[&["starling", "--light=140,50", "-o", "g.png"], QUICK].concat()).ends(0);
    // What is drawn is the same; the notes in the files tell of different commands.
    let drawn = |name: &str| {
        let bytes = std::fs::read(folder.path().join(name)).unwrap();
        let at = bytes.windows(4).position(|w| w == b"IDAT").unwrap();
        let length = u32::from_be_bytes(bytes[at - 4..at].try_into().unwrap()) as usize;
        bytes[at..at + length].to_vec()
    };
    assert_eq!(drawn("f-0001.png"), drawn("g.png"));
    assert_ne!(drawn("f-0000.png"), drawn("f-0001.png"));
}

/// What a run reports of its pictures; the pixels' hash among it.
pub(crate) fn report(folder: &Path, arguments: &[&str]) -> Value {
    let output = barbule(folder, &[arguments, QUICK, &["--json"]].concat()).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", said_by(&output));
    serde_json::from_slice::<Value>(&output.stdout).unwrap()[0].clone()
}

/// A preset prints its own text; with flags, or from a file, the scene that they describe. Both are drawn as the same picture.
#[test]
fn a_printed_scene_is_the_same_picture_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("lamps")).unwrap();
    std::fs::write(at("lamps/lamp.csv"), "nm,power\n400,2000\n500,4000\n700,9000\n").unwrap();
    let text = "preset = \"magpie\"\nexposure = \"auto\"\n[[lights]]\ntype = \"sphere\"\nposition_mm = [4, 9, 9]\nradius_mm = 2\n\
                strength = 3\nspectrum = \"lamp.csv\"\n";
    std::fs::write(at("lamps/scene.toml"), text).unwrap();
    let cases: [&[&str]; 3] = [
        &["starling"],
        &["starling", "--light=30,50", "--exposure", "0.5", "--view=190,60,2.5"],
        &["lamps/scene.toml"],
    ];
    for arguments in cases {
        let printed = barbule(folder.path(), &[arguments, &["--toml"]].concat()).output().unwrap();
        assert!(printed.status.success(), "{}", said_by(&printed));
        std::fs::write(at("printed.toml"), &printed.stdout).unwrap();
        let drawn = report(folder.path(), &[arguments, &["-o", "a.png"]].concat());
        let again = report(folder.path(), &["printed.toml", "-o", "b.png"]);
        assert_eq!(drawn["pixel_hash"], again["pixel_hash"], "{arguments:?}");
        assert_eq!(drawn["exposure"], again["exposure"]);
        let has_comments = String::from_utf8_lossy(&printed.stdout).contains("# from radiance to");
        assert_eq!(has_comments, arguments.len() == 1 && arguments[0] == "starling");
    }
    let both = barbule(folder.path(), &["starling", "--toml", "-o", "x.png"]).ends(2);
    assert!(said_by(&both).contains("cannot be used with"));
}

#[test]
fn exposures_are_factors_or_found_by_a_key() {
    let folder = tempfile::tempdir().unwrap();
    let exposure = |report: &Value| report["exposure"].as_str().unwrap().parse::<f64>().unwrap();
    std::fs::write(folder.path().join("plain.toml"), CLOSE_UP).unwrap();
    let bright = report(folder.path(), &["plain.toml", "-o", "a.png", "--exposure", "0.5"]);
    assert_eq!((exposure(&bright), &bright["exposure_by"]), (0.5, &"factor".into()));
    let found = report(folder.path(), &["plain.toml", "-o", "b.png", "--exposure", "auto"]);
    assert_eq!(found["exposure_by"], "key");
    // Four times the light needs a quarter of the exposure: the key knows no unit.
    let fourfold =
        CLOSE_UP.replacen("sky = 0.8", "sky = 3.2", 1).replacen("strength = 2.5", "strength = 10.0", 1);
    std::fs::write(folder.path().join("bright.toml"), fourfold).unwrap();
    let fourfold = report(folder.path(), &["bright.toml", "-o", "c.png", "--exposure", "auto"]);
    let ratio = exposure(&found) / exposure(&fourfold);
    // Shadow rays for little light are drawn by its amount, so samples differ a little.
    assert!((ratio - 4.0).abs() < 0.05, "{ratio}");
    // Frames share the first one's.
    let common =
        ["plain.toml", "-o", "f.png", "--exposure", "auto", "--frames", "3", "--arc", "light=120", "--json"];
    let output = barbule(folder.path(), &[&common[..], QUICK].concat()).output().unwrap();
    let frames: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap();
    assert!(frames.iter().all(|frame| frame["exposure"] == frames[0]["exposure"]));
}

/// The usual sequence stays in the light: no frame is much darker than the brightest.
#[test]
fn no_frame_of_the_usual_sequence_is_dark() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plain.toml"), CLOSE_UP).unwrap();
    let arguments = ["plain.toml", "-o", "f.exr", "--frames", "4"];
    barbule(folder.path(), &[&arguments[..], QUICK].concat()).ends(0);
    let means: Vec<f64> = (0..4)
        .map(|frame| {
            let image =
                barbule::io::image::read_exr(&folder.path().join(format!("f-000{frame}.exr"))).unwrap();
            let green = image.pixels.iter().map(|pixel| f64::from(pixel[1]));
            green.sum::<f64>() / image.pixels.len() as f64
        })
        .collect();
    let brightest = means.iter().copied().fold(0.0, f64::max);
    assert!(means.iter().all(|mean| *mean > 0.3 * brightest), "{means:?}");
}

#[test]
fn pictures_are_cut_out_or_stand_before_a_background() {
    let folder = tempfile::tempdir().unwrap();
    // Far enough to see past the feather.
    std::fs::write(folder.path().join("plain.toml"), CLOSE_UP).unwrap();
    let far = ["plain.toml", "--view=190,60,20"];
    let draw = |more: &[&str]| report(folder.path(), &[&far, more].concat());
    draw(&["-o", "none.png", "--background", "none"]);
    let read = |name: &str| {
        let bytes = std::fs::read(folder.path().join(name)).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let channels = reader.next_frame(&mut pixels).unwrap().color_type.samples();
        (channels, pixels)
    };
    let (channels, cut) = read("none.png");
    let alpha: Vec<u8> = cut.chunks_exact(4).map(|pixel| pixel[3]).collect();
    assert_eq!((channels, alpha[0]), (4, 0));
    assert!(alpha.contains(&255) && alpha.iter().any(|a| (1..255).contains(a)));
    draw(&["-o", "blue.png", "--background", "#2040ff"]);
    let (channels, blue) = read("blue.png");
    assert_eq!((channels, &blue[..3]), (3, &[0x20, 0x40, 0xff][..]));
    // Where the feather covers a pixel, it is the same in front of everything.
    for (pixel, behind) in cut.chunks_exact(4).zip(blue.chunks_exact(3)).filter(|(pixel, _)| pixel[3] == 255)
    {
        assert_eq!(pixel[..3], *behind);
    }
    // A picture of itself: behind the feather it is what it was.
    draw(&["-o", "again.png", "--background", "blue.png"]);
    let (_, again) = read("again.png");
    assert_eq!(again[..3], blue[..3]);
    let sky = draw(&["-o", "sky.png", "--background", "sky"]);
    assert_eq!(sky["pixel_hash"], draw(&["-o", "plain.png"])["pixel_hash"]);
    let refused = barbule(folder.path(), &["starling", "-o", "x.png", "--background", "wall.jpg"]).ends(2);
    let message = said_by(&refused);
    assert!(message.contains("--background") && message.contains(".png, .exr or .hdr"), "{message}");
}

/// One plane of a picture in an EXR.
fn plane(path: &Path, name: &str) -> Vec<f32> {
    let image = exr::prelude::read_all_flat_layers_from_file(path).unwrap();
    let channels = &image.layer_data[0].channel_data.list;
    let found = channels.iter().find(|channel| channel.name.eq(name));
    found.unwrap_or_else(|| panic!("no plane {name}")).sample_data.values_as_f32().collect()
}

/// EXR: nothing below zero unless asked, spectral planes whose sum under ȳ is the luminance, mattes that cover what alpha covers.
#[test]
fn exr_planes_fit_together() {
    let folder = tempfile::tempdir().unwrap();
    let scene =
        "preset = 'magpie'\n[window]\nradius_mm = 3.4\n[camera]\nlens = 0.005\ntarget_mm = [0, 0, 0]\n";
    std::fs::write(folder.path().join("far.toml"), scene).unwrap();
    let arguments = ["far.toml", "--background", "none", "--view=190,60,20", "--spectral", "380:720:20"];
    for more in [&["-o", "m.exr"][..], &["-o", "k.exr", "--keep-gamut"]] {
        report(folder.path(), &[&arguments[..], more].concat());
    }
    let planes = |name: &str| {
        let path = folder.path().join(name);
        move |name: &str| plane(&path, name)
    };
    let (kept, plane) = (planes("k.exr"), planes("m.exr"));
    let lowest = |values: Vec<f32>| values.into_iter().fold(f32::INFINITY, f32::min);
    for name in ["R", "G", "B", "albedo.R", "albedo.G", "albedo.B"] {
        assert!(lowest(plane(name)) >= 0.0, "{name}");
    }
    assert!(["R", "G", "B"].iter().any(|name| lowest(kept(name)) < 0.0));
    let (alpha, luminance, depth) = (plane("A"), plane("XYZ.Y"), plane("depth.Z"));
    assert!(alpha.iter().all(|a| (0.0..=1.0).contains(a)));
    let mut cover = vec![0.0; alpha.len()];
    for layer in ["CryptoMaterial00.G", "CryptoMaterial00.A", "CryptoMaterial01.G"] {
        cover.iter_mut().zip(plane(layer)).for_each(|(sum, value)| *sum += value);
    }
    for (pixel, a) in alpha.iter().enumerate() {
        assert_eq!(depth[pixel] >= 1e10, cover[pixel] == 0.0);
        if *a == 0.0 {
            assert_eq!((luminance[pixel], cover[pixel]), (0.0, 0.0));
        }
        if *a == 1.0 {
            assert_eq!(cover[pixel], 1.0);
        }
    }
    // Bands of the spectrum, summed up as the eye does, are the luminance: within what 20 nm resolve.
    let mut sum = vec![0.0; alpha.len()];
    for nm in (380..=720).step_by(20) {
        let weight = barbule::spectrum::colour::matching(f64::from(nm))[1];
        let values = plane(&format!("S0.{nm},0nm"));
        sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * f64::from(value));
    }
    let total = |values: &[f64]| values.iter().sum::<f64>();
    let luminance: Vec<f64> = luminance.into_iter().map(f64::from).collect();
    let daylight = barbule::scene::emission::Emission::daylight().luminance() / 20.0;
    let ratio = total(&sum) / daylight / total(&luminance);
    assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
}

/// A curve covers the pixels that it should, and does so where the printed scene is drawn elsewhere; another basis begins later.
#[test]
fn curves_from_files_stand_in_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("scenes")).unwrap();
    // Four points 1 mm apart in +y, 0.25 mm wide either way at x = 1 mm once they are twice as large.
    let points: String = (0..4).map(|k| format!("0.5 {} 0 0.125\n", 0.5 * f64::from(k))).collect();
    std::fs::write(at("scenes/rod.txt"), points).unwrap();
    let scene = |basis: &str| {
        format!(
            "preset = 'starling'\nshows_feather = false\nbackground = 'none'\n[camera]\nprojection = 'orthographic'\n\
             azimuth_deg = 0\nelevation_deg = 90\nroll_deg = 0\nwidth_mm = 6\nlens = 0\ntarget_mm = [0, 0, 0]\n[surfaces.white]\ntype = 'diffuse'\n\
             [[objects]]\ncurves = 'rod.txt'\n{basis}scale = 2\nsurface = 'white'\n"
        )
    };
    // 48 x 30 pixels of an eighth of a mm: alpha over the picture's middle, whose columns go to +x and rows to -y.
    let covered = |name: &str, basis: &str| -> ([f64; 2], [f64; 2], Value) {
        std::fs::write(at("scenes/rod.toml"), scene(basis)).unwrap();
        let drawn = report(folder.path(), &["scenes/rod.toml", "-o", name]);
        let alpha = plane(&at(name), "A");
        assert_eq!(alpha.len(), 48 * 30);
        let (mut x, mut y) = ([f64::INFINITY, f64::NEG_INFINITY], [f64::INFINITY, f64::NEG_INFINITY]);
        for pixel in (0..alpha.len()).filter(|pixel| alpha[*pixel] > 0.5) {
            let place = [(pixel % 48) as f64 - 23.5, 14.5 - (pixel / 48) as f64].map(|v| v / 8.0);
            (x, y) = ([x[0].min(place[0]), x[1].max(place[0])], [y[0].min(place[1]), y[1].max(place[1])]);
        }
        (x, y, drawn["pixel_hash"].clone())
    };
    let (x, y, straight) = covered("l.exr", "basis = 'linear'\n");
    // Pixels' middles are half a pixel inside, ends are round; the picture ends at y = 1.875 mm.
    assert_eq!((x, y), ([0.8125, 1.1875], [-0.1875, 1.8125]));
    let (x, y, spline) = covered("b.exr", "");
    assert_eq!((x, y), ([0.8125, 1.1875], [0.8125, 1.8125]));
    assert_ne!(straight, spline);
    let printed = barbule(folder.path(), &["scenes/rod.toml", "--toml"]).output().unwrap();
    std::fs::write(at("printed.toml"), &printed.stdout).unwrap();
    let again = report(folder.path(), &["printed.toml", "-o", "p.exr"]);
    assert_eq!(again["pixel_hash"], spline);
    std::fs::write(at("scenes/rod.txt"), "0 0 0 1\n1 0 0 1\n").unwrap();
    let refused = barbule(folder.path(), &["scenes/rod.toml", "-o", "x.png"]).ends(2);
    let message = said_by(&refused);
    assert!(
        message.contains("objects[0].curves") && message.contains("has 2 points, but needs 4"),
        "{message}"
    );
}

/// Under the same light from everywhere smooth metal seen straight on is as bright as Fresnel's formula says: beside it the
/// camera sees that light itself.
#[test]
fn metal_reflects_what_its_index_says() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "preset = 'starling'\nshows_feather = false\nsky = 1\nsky_horizon = 1\nsky_below = 1\nexposure = 1\n\
                 background = 'sky'\nlights = []\n[light]\nstrength = 0\n[camera]\nprojection = 'orthographic'\nazimuth_deg = 0\nelevation_deg = 90\n\
                 roll_deg = 0\nwidth_mm = 6\nlens = 0\ntarget_mm = [0, 0, 0]\n[surfaces.plate]\ntype = 'conductor'\nroughness = [0.02, 0.03]\n\
                 METAL\n[[objects]]\nrectangle_mm = [2, 8]\nsurface = 'plate'\n";
    // Means of R, G, B on the plate over those beside it.
    let reflected = |metal: &str| -> [f64; 3] {
        std::fs::write(folder.path().join("plate.toml"), scene.replace("METAL", metal)).unwrap();
        report(folder.path(), &["plate.toml", "-o", "p.exr", "--keep-gamut"]);
        ["R", "G", "B"].map(|name| {
            let values = plane(&folder.path().join("p.exr"), name);
            let mean = |columns: std::ops::Range<usize>| {
                let rows = values.chunks(48).flat_map(|row| &row[columns.clone()]);
                rows.map(|v| f64::from(*v)).sum::<f64>() / (30 * columns.len()) as f64
            };
            mean(18..30) / mean(0..12)
        })
    };
    let (n, k) = (0.5_f64, 3.0_f64);
    let expected = ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k);
    for found in reflected("index = 0.5\nabsorption = 3.0") {
        assert!((found / expected - 1.0).abs() < 0.02, "{found}, but {expected}");
    }
    let [red, green, blue] = reflected("metal = 'copper'");
    assert!(red > 1.2 * green && green > blue && red > 0.85 && blue > 0.4, "{red} {green} {blue}");
}

/// And printed: the same picture from elsewhere, with all the files that they name.
#[test]
fn example_scenes_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes");
    let scenes = barbule::io::files_in(&examples, "toml");
    assert!(scenes.len() >= 2);
    for scene in scenes {
        let scene = scene.to_string_lossy();
        let printed = barbule(folder.path(), &[&scene, "--toml"]).ends(0);
        std::fs::write(folder.path().join("printed.toml"), &printed.stdout).unwrap();
        let drawn = report(folder.path(), &["printed.toml", "-o", "printed.png"]);
        assert!(drawn["paths"].as_u64().unwrap() > 0);
        let own = report(folder.path(), &[&scene, "-o", "own.png"]);
        assert_eq!(own["pixel_hash"], drawn["pixel_hash"], "{scene}");
    }
}

/// A coat on a pyramid: every feather counts, the picture is the same on one thread, and what makes no coat is refused with its key.
#[test]
fn a_coat_is_drawn_alike_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let pyramid = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes/pyramid.ply");
    std::fs::copy(pyramid, folder.path().join("pyramid.ply")).unwrap();
    let scene = |coat: &str| {
        let text = format!(
            "preset = 'osprey'\nsize = [48, 32]\n[camera]\nwidth_mm = 300.0\n[coat]\nmesh = 'pyramid.ply'\nscale = 40.0\n\
             variants = 2\n{coat}"
        );
        std::fs::write(folder.path().join("coat.toml"), text).unwrap();
    };
    scene("count = 60");
    let drawn = |threads: &str| {
        let words = ["coat.toml", "-o", "coat.png", "--samples", "4", "--json", "--threads", threads];
        let output = barbule(folder.path(), &words).output().unwrap();
        assert!(output.status.success(), "{}", said_by(&output));
        serde_json::from_slice::<Value>(&output.stdout).unwrap()[0].clone()
    };
    let (one, two) = (drawn("1"), drawn("2"));
    assert_eq!(one["pixel_hash"], two["pixel_hash"]);
    assert!(one["barbs"].as_u64().unwrap() >= 60 * 100, "{one}");
    let refused = |coat: &str, expected: &str| {
        scene(coat);
        let run = barbule(folder.path(), &["coat.toml", "-o", "other.png"]).ends(2);
        let message = said_by(&run);
        assert!(message.contains(expected) && message.trim_end().lines().count() == 1, "{message}");
        assert!(!folder.path().join("other.png").exists());
    };
    refused("count = 60\nhugs = 1", "did you mean 'hug'");
    refused(
        "count = 60\nwithin_mm = [[900, 0, 0], [901, 1, 1]]",
        "coat.within_mm and coat.bare leave hardly any",
    );
    std::fs::remove_file(folder.path().join("pyramid.ply")).unwrap();
    refused("count = 60", "coat.mesh");
}

/// Two cones of a file: a plane for each, false colours where the file has them, a checkpoint that is theirs.
#[test]
fn a_sensor_of_a_file_sees_its_own_channels() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("cones.csv", "wavelength_nm,UV,S\n300,0,0\n370,1,0\n400,0.5,0.5\n450,0,1\n550,0,0\n");
    let values = "[[channels]]\nname = 'UV'\nvalues = [1, 0]\n[[channels]]\nname = 'S'\nvalues = [0, 1]\n";
    let rows = "to_xyz = [[0.3, 0.1], [0.1, 0.3], [0.2, 0.2]]\n";
    write("false.toml", &format!("name = 'false colours'\nwavelength_nm = [300, 600]\n{rows}{values}"));
    let path = |name: &str| folder.path().join(name);
    let seen = report(folder.path(), &["starling", "-o", "c.exr", "--sensor", "cones.csv", "--resume"]);
    assert_eq!(seen["sensor"], "cones");
    for name in ["CH.UV", "CH.S", "albedo.UV", "variance.mean", "A"] {
        assert!(plane(&path("c.exr"), name).iter().sum::<f32>() > 0.0, "{name}");
    }
    let names = std::fs::read(path("c.exr")).unwrap();
    assert!(!String::from_utf8_lossy(&names[..4000]).contains("XYZ.Y"));
    // A picture that is not done keeps a checkpoint.
    let begun = ["starling", "-o", "k.exr", "--sensor", "cones.csv", "--resume", "--time", "0.001s"];
    barbule(folder.path(), &[&begun, QUICK].concat()).ends(0);
    let again = ["starling", "-o", "k.exr", "--sensor", "false.toml", "--resume"];
    let refused = barbule(folder.path(), &[&again, QUICK].concat()).ends(2);
    let message = said_by(&refused);
    assert!(message.contains("another picture") && message.contains("sensor"), "{message}");
    // The made-up material ends where the cones see on.
    let drawn = ["starling", "-o", "f.png", "--sensor", "false.toml"];
    let drawn = barbule(folder.path(), &[&drawn, QUICK].concat()).ends(0);
    let said = said_by(&drawn);
    assert!(said.contains("'false colours' sees 300 to 600 nm, but the material is known"), "{said}");
    let human = report(folder.path(), &["starling", "-o", "h.png", "--sensor", "human"]);
    assert_eq!(human["pixel_hash"], report(folder.path(), &["starling", "-o", "i.png"])["pixel_hash"]);
    assert!(human.get("sensor").is_none());
}

/// Which noise was asked for, what was reached, and why not: in the line, in the picture and in JSON.
#[test]
fn a_picture_says_whether_its_noise_was_reached() {
    let folder = tempfile::tempdir().unwrap();
    let render = |name: &str, more: &[&str]| {
        let arguments = ["starling", "--material", MADE_UP, "--size", "48x30", "--json", "-o", name];
        let run = barbule(folder.path(), &[&arguments[..], more].concat()).ends(0);
        let report: Value = serde_json::from_slice(&run.stdout).unwrap();
        let said = said_by(&run);
        (report[0].clone(), said)
    };
    let (report, said) = render("a.png", &["--noise", "0.3", "--time", "0.5s"]);
    assert!(
        said.contains("samples each, noise ") && said.contains(" %, target 0.3 % not reached: time is up"),
        "{said}"
    );
    assert_eq!((&report["noise_reached"], &report["noise_target_percent"]), (&false.into(), &0.3.into()));
    assert!(report["noise_percent"].as_f64().unwrap() > 0.3, "{report}");
    let bytes = std::fs::read(folder.path().join("a.png")).unwrap();
    assert!(String::from_utf8_lossy(&bytes).contains("target 0.3 % not reached: time is up"));
    let (report, said) = render("b.png", &["--noise", "90"]);
    assert!(said.contains("target 90 % reached") && report["noise_reached"] == true, "{said} {report}");
    let (_, said) = render("c.png", &["--noise", "0.3", "--samples", "4"]);
    assert!(said.contains("target 0.3 % not reached: all 4 samples are taken"), "{said}");
    let (_, said) = render("d.png", &["--noise", "0.3", "--samples", "1"]);
    assert!(said.contains("noise unknown, target 0.3 % not reached"), "{said}");
    let (_, said) = render("e.png", &["--samples", "4"]);
    assert!(!said.contains("noise"), "{said}");
}

#[test]
fn what_cannot_be_rendered_is_refused_in_a_sentence_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("d.png")).unwrap();
    std::fs::write(folder.path().join("bad.toml"), "preset = \"starling\"\nexposre = 1\n").unwrap();
    let film = "preset = \"starling\"\nshows_feather = false\n[surfaces.film]\ntype = \"film\"\nstack = \"air/keratin:400/melanin\"\nroughness = 0.2\n\
                [[objects]]\nsphere_mm = 1\nsurface = \"film\"\n";
    std::fs::write(folder.path().join("film.toml"), film).unwrap();
    std::fs::write(folder.path().join("bad.barbule"), "no material").unwrap();
    std::fs::write(folder.path().join("uv.csv"), "wavelength_nm,a\n300,1\n400,1\n").unwrap();
    std::fs::write(folder.path().join("bad.csv"), "wavelength_nm,a\n300,x\n").unwrap();
    let cases: &[(&[&str], &str)] = &[
        (&["starlign", "-o", "x.png"], "did you mean 'starling'"),
        (&["starling:pnk", "-o", "x.png"], "pnk"),
        (
            &["starling", "-o", "x.bmp", "--material", MADE_UP],
            "pictures are written as .png, .jpg, .webp or .exr",
        ),
        (&["starling", "-o", "x.jpg", "--background", "none"], "-o: x.jpg: a JPEG cannot be cut out"),
        (&["starling", "-o", "no/x.png", "--material", MADE_UP], "does not exist"),
        (&["starling", "-o", "d.png", "--material", MADE_UP], "is a folder"),
        (&["starling", "-o", "x.png", "--material", "none.barbule"], "no such file"),
        (&["starling", "-o", "x.png", "--material", "bad.barbule"], "is not a material file"),
        (&["starling", "-o", "x.png", "--size", "10"], "as in 1280x800"),
        (&["starling", "-o", "x.png", "--size", "0x10"], "each side must be"),
        (&["starling", "-o", "x.png", "--size", "99999x10"], "each side must be"),
        (&["starling", "-o", "x.png", "--samples", "0"], "--samples 0"),
        (&["starling", "-o", "x.png", "--time", "soon"], "such as 30s"),
        (&["starling", "-o", "x.png", "--noise", "-1"], "--noise -1"),
        (&["starling", "-o", "x.png", "--light", "1"], "azimuth and elevation"),
        (&["starling", "-o", "x.png", "--light", "1,a"], "--light 1,a"),
        (&["starling", "-o", "x.png", "--light", "1,91"], "light.elevation_deg is 91, outside -90 to 90"),
        (&["starling", "-o", "x.png", "--view", "1,2,3,4"], "width in mm"),
        (&["starling", "-o", "x.png", "--view", "1,2,5000"], "0.05 to 2000"),
        (&["starling", "-o", "x.png", "--frames", "0"], "--frames 0"),
        (&["starling", "-o", "x.png", "--frames", "3", "--arc", "lght=3"], "did you mean 'light'"),
        (&["starling", "-o", "x.png", "--frames", "3", "--arc", "light=9999"], "at most 3600"),
        (&["starling", "-o", "x.png", "--frames", "3", "--path", "light=3,50"], "two points"),
        (&["starling", "-o", "x.png", "--exposure", "-200"], "--exposure -200: give a factor"),
        (&["starling", "-o", "x.png", "--exposure", "+21"], "--exposure +21: give a factor"),
        (&["starling", "-o", "x.png", "--background", "#12"], "as in #20406a"),
        (&["starling", "-o", "x.png", "--background", "none.png"], "no such file"),
        (&["starling", "-o", "x.png", "--spectral", "500"], "end the name with .exr"),
        (&["starling", "-o", "x.exr", "--spectral", "300:700:10"], "--spectral: 300 nm is outside"),
        (&["starling", "-o", "x.png", "--sensor", "humn"], "did you mean 'human'?"),
        (
            &["starling", "-o", "x.png", "--sensor", "uv.csv"],
            "-o: x.png: the sensor 'uv' does not say how its",
        ),
        (&["starling", "-o", "x.exr", "--sensor", "bad.csv"], "--sensor: bad.csv: line 2: a is 'x'"),
        (&["starling", "-o", "x.exr", "--sensor", "uv.csv", "--spectral", "550"], "rendered, 300 to 400"),
        (&["film.toml", "-o", "x.exr", "--sensor", "uv.csv"], "films are known from 380 to 720 nm"),
        (&["starling", "-o", "x.png", "--preview=soon"], "--preview soon: give a time"),
        (&["none.toml", "-o", "x.png"], "no such file"),
        (&["bad.toml", "-o", "x.png"], "did you mean 'exposure'"),
    ];
    for (arguments, fragment) in cases {
        let refused = barbule(folder.path(), arguments).ends(2);
        let message = said_by(&refused);
        assert!(message.contains(fragment) && message.len() < 600, "{arguments:?}: {message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        assert!(!["x.png", "x.exr"].iter().any(|name| folder.path().join(name).exists()));
    }
}
