//! `barbule render` as people and scripts use it.

use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

use crate::common::{MADE_UP, write_made_up};

fn barbule(folder: &Path, arguments: &[&str]) -> Command {
    write_made_up();
    let mut command = Command::cargo_bin("barbule").unwrap();
    command.args(["render"]).args(arguments).current_dir(folder);
    command
}

/// Small and without a simulated material: a second or two.
const QUICK: &[&str] = &["--material", MADE_UP, "--size", "48x30", "--samples", "4"];

#[test]
fn a_picture_is_a_png_that_says_where_it_comes_from() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [&["starling", "-o", "s.png", "--json", "--light=60,45", "--seed", "7"], QUICK].concat();
    let output = barbule(folder.path(), &arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let barbs = report[0]["barbs"].as_u64().unwrap();
    let barbules = report[0]["barbules"].as_u64().unwrap();
    assert!((15..=45).contains(&barbs) && (5_000..=30_000).contains(&barbules), "{report}");
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
fn exr_frames_and_scene_files_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let scene = format!(
        "preset = \"hummingbird\"\nmaterial = '{MADE_UP}'\nsize = [40, 24]\n[light]\nazimuth = 10.0\n"
    );
    std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let arguments = ["scene.toml", "-o", "h.exr", "--frames", "2", "--samples", "2"];
    barbule(folder.path(), &arguments).assert().success();
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
    barbule(folder.path(), &[&["under.toml", "-o", "u.png"], QUICK].concat()).assert().success();
    std::fs::write(folder.path().join("under.toml"), under.replace("h-0000", "none")).unwrap();
    let refused = barbule(folder.path(), &[&["under.toml", "-o", "u.png"], QUICK].concat()).assert().code(2);
    assert!(String::from_utf8_lossy(&refused.get_output().stderr).contains("none.exr: no such file"));
}

/// Three frames of a turning light: one feather is grown, and each frame is the picture under its light alone.
#[test]
fn frames_share_one_feather_and_its_hierarchy() {
    let folder = tempfile::tempdir().unwrap();
    let common = ["starling", "--light=20,50", "-o", "f.png", "--frames", "3", "--verbose"];
    let output = barbule(folder.path(), &[&common[..], QUICK].concat()).output().unwrap();
    let log = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{log}");
    assert_eq!(log.matches("primitives; ready in").count(), 1, "{log}");
    assert_eq!(log.lines().filter(|line| line.starts_with("light ")).count(), 3, "{log}");
    barbule(folder.path(), &[&["starling", "--light=140,50", "-o", "g.png"], QUICK].concat())
        .assert()
        .success();
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

#[test]
fn a_resumed_picture_has_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let render = |name: &str, samples: &str| {
        let arguments = ["starling", "--material", MADE_UP, "--size", "40x24", "--resume", "-o", name];
        barbule(folder.path(), &[&arguments[..], &["--samples", samples]].concat()).assert().success();
    };
    render("a.png", "8");
    render("a.png", "20");
    render("b.png", "20");
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(read("a.png.checkpoint"), read("b.png.checkpoint"));
    // Another light is another picture.
    let other =
        ["starling", "--material", MADE_UP, "--size", "40x24", "--resume", "-o", "a.png", "--light=1,50"];
    let refused = barbule(folder.path(), &other).assert().code(2);
    assert!(String::from_utf8_lossy(&refused.get_output().stderr).contains("another picture"));
}

#[test]
fn what_cannot_be_rendered_is_refused_in_a_sentence_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("d.png")).unwrap();
    std::fs::write(folder.path().join("bad.toml"), "preset = \"starling\"\nexposre = 1\n").unwrap();
    std::fs::write(folder.path().join("bad.barbule"), "no material").unwrap();
    let cases: &[(&[&str], &str)] = &[
        (&["starlign", "-o", "x.png"], "did you mean 'starling'"),
        (&["starling:pnk", "-o", "x.png"], "pnk"),
        (&["starling", "-o", "x.jpg", "--material", MADE_UP], "pictures are written as .png or .exr"),
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
        (&["starling", "-o", "x.png", "--view", "1,2,1000"], "0.05 to 50"),
        (&["starling", "-o", "x.png", "--frames", "0"], "--frames 0"),
        (&["none.toml", "-o", "x.png"], "no such file"),
        (&["bad.toml", "-o", "x.png"], "did you mean 'exposure'"),
    ];
    for (arguments, fragment) in cases {
        let refused = barbule(folder.path(), arguments).assert().code(2);
        let message = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
        assert!(message.contains(fragment) && message.len() < 600, "{arguments:?}: {message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        assert!(!folder.path().join("x.png").exists());
    }
}
