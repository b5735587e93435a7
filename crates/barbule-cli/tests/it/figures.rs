//! Figures as they are asked for: format, title, size, words.

use std::path::Path;

use crate::common::{printed, run};

/// Width and height of a file in mm, and of a PNG in pixels.
fn size(path: &Path) -> ([f64; 2], [u32; 2]) {
    let bytes = std::fs::read(path).unwrap();
    // A letter for every byte, so that places in both are the same.
    let all: String = bytes.iter().map(|b| if b.is_ascii() { *b as char } else { '?' }).collect();
    let number = |text: &str| text.split(['"', ' ', ']']).next().unwrap().parse::<f64>().unwrap();
    match path.extension().unwrap().to_str().unwrap() {
        "svg" => {
            let after = |key: &str| number(&all[all.find(key).unwrap() + key.len()..]);
            ([after(" width=\""), after(" height=\"")].map(|px| px * 25.4 / 96.0), [0; 2])
        }
        "pdf" => {
            let page = &all[all.find("/MediaBox [0 0 ").unwrap() + 15..];
            let mut numbers = page.split(' ').map(number);
            ([(); 2].map(|()| numbers.next().unwrap() * 25.4 / 72.0), [0; 2])
        }
        _ => {
            let word = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
            let pixels = [word(16), word(20)];
            let density = word(all.find("pHYs").unwrap() + 4);
            (pixels.map(|n| 1e3 * f64::from(n) / f64::from(density)), pixels)
        }
    }
}

/// A structure's figure, and one of curves and maps.
const COMMANDS: &[&[&str]] = &[
    &["geometry", "hummingbird"],
    &["crystal", "magpie", "--map", "--wavelengths", "400:700:100"],
    &["crystal", "magpie", "--field"],
    &["film", "air/6*(melanin:99/keratin:100)/keratin", "--angles", "0,20,40,60"],
    &["spectrum", "air/keratin:595/air", "--instances", "3", "--wavelengths", "400:700:50"],
    &["species", "starling:green"],
    &["far-field", "starling", "--wavelength", "500", "--theta", "0", "--phi", "20"],
];

#[test]
fn figures_have_the_size_they_are_asked_for_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    for (number, command) in COMMANDS.iter().enumerate() {
        // The field is a simulation: one of its formats will do.
        let endings: &[&str] = if command.contains(&"--field") { &["pdf"] } else { &["svg", "pdf", "png"] };
        for ending in endings {
            let path = folder.path().join(format!("{number}.{ending}"));
            let mut words = command.to_vec();
            words.extend(["--figure-size", "85x60mm", "--font-size", "7", "-o", path.to_str().unwrap()]);
            let (code, _, message) = run(&words);
            assert_eq!(code, 0, "{words:?}: {message}");
            let ([width, height], _) = size(&path);
            // A PNG has whole pixels.
            let slack = if *ending == "png" { 0.15 } else { 0.01 };
            assert!(
                (width - 85.0).abs() < slack && (height - 60.0).abs() < slack,
                "{words:?} {width} {height}"
            );
        }
    }
}

#[test]
fn pixels_of_a_png_are_those_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let file = path.to_str().unwrap();
    let geometry = ["geometry", "starling", "-o", file, "--figure-size"];
    for (more, pixels, dpi) in [
        (&["600x400px"][..], [600, 400], 192.0),
        (&["601x401px", "--figure-dpi", "300"], [601, 401], 300.0),
        (&["4x3in", "--figure-dpi", "100"], [400, 300], 100.0),
    ] {
        let words: Vec<&str> = geometry.iter().chain(more).copied().collect();
        assert_eq!(run(&words).0, 0);
        let ([width, _], found) = size(&path);
        assert_eq!(found, pixels);
        assert!((f64::from(found[0]) / width * 25.4 / dpi - 1.0).abs() < 1e-3);
    }
}

#[test]
fn titles_are_those_given_and_otherwise_read_well() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.svg");
    let file = path.to_str().unwrap();
    let drawn = |more: &[&str]| {
        let words: Vec<&str> = ["geometry", "starling", "-o", file].iter().chain(more).copied().collect();
        assert_eq!(run(&words).0, 0);
        std::fs::read_to_string(&path).unwrap()
    };
    assert!(drawn(&["--title", "A starling's <barbule>"]).contains(">A starling's &lt;barbule&gt;<"));
    assert!(drawn(&[]).contains(">starling:green 0<"));
    assert!(!drawn(&["--title", ""]).contains(">starling:green 0<"));
}

#[test]
fn flags_that_change_nothing_are_said_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let table = path("mine.csv");
    std::fs::write(&table, "300,1.5,0\n830,1.5,0").unwrap();
    let medium = format!("mine={table}");
    let own = format!("keratin={table}");
    let holes = format!("{}/../../examples/lattices/square-holes.toml", env!("CARGO_MANIFEST_DIR"));
    let material =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../barbule-birds/birds/starling/starling-green.barbule");
    let read = ["--instrument", "probe:5", "--wavelengths", "400:700:100"];
    let (code, _, message) = run(&[&["spectrum", material, "--side", "below"][..], &read].concat());
    assert!(code == 2 && message.contains("is of the side that it was made of"), "{message}");
    for (words, said) in [
        (
            vec!["geometry", "starling", "--medium", &medium, "--json"],
            "--medium mine has no effect here: nothing in starling:green is made of it",
        ),
        (vec!["geometry", "mallard", "--medium", &medium, "--json"], "nothing in mallard:lime is made of it"),
        (vec!["geometry", "starling", "--medium", &own, "--json"], ""),
        (
            "far-field starling --wavelength 550 --theta 0 --phi 0 --smooth 0.06".split(' ').collect(),
            "--smooth has no effect here: starling:green has no inclusions",
        ),
        ("far-field hummingbird --wavelength 550 --theta 0 --phi 0 --smooth off".split(' ').collect(), ""),
        (
            "diffract blazed --wi 0,0 --wo 0,0 --normalization relative --index 2".split(' ').collect(),
            "--index has no effect here: values are relative to a mirror",
        ),
        (
            "see air/1.5:300/1.7 --bird starling --weber-double 0.2".split(' ').collect(),
            "--weber-double has no effect here: one thing has no differences",
        ),
        (
            "see air/1.5:300/1.7 air/1.5:310/1.7 --bird starling --samples".split(' ').collect(),
            "--samples has no effect here: nothing that is seen is measured",
        ),
        (
            "render bronzewing --toml --sensor bird:starling".split(' ').collect(),
            "--sensor has no effect here: --toml prints a scene",
        ),
        (
            [&["spectrum", material, "--instances", "3"][..], &read].concat(),
            "--instances has no effect here: a material is of the individuals",
        ),
        (
            [&["spectrum", material, "--smooth", "0.1"][..], &read].concat(),
            "--smooth has no effect here: a material is of the inclusions",
        ),
        (vec!["geometry", "air/mix(mine,keratin,0.5):90/air", "--medium", &medium, "--json"], ""),
        (vec!["geometry", "starling", "--title", "x", "-o", &path("a.json")], "--title has no effect here"),
        (
            vec!["geometry", "starling", "--figure-dpi", "300", "-o", &path("a.pdf")],
            "--figure-dpi has no effect here",
        ),
        (
            vec!["render", "snake", "--material", "starling", "--toml"],
            "--material has no effect here: the scene begins with no feather whose barbules wear a material",
        ),
        (
            vec!["render", "peacock", "--model", "film", "--under", "keratin", "--toml"],
            "--under has no effect here: the scene begins with no feather",
        ),
        (
            vec!["render", "osprey", "--material", "starling", "--toml"],
            "--material has no effect here: the scene begins with no feather",
        ),
        (vec!["render", "starling", "--material", "magpie", "--under", "keratin", "--toml"], ""),
        (
            vec!["render", "diffraction-bench", "--view-model", "fibre", "--toml"],
            "--view-model has no effect here: the scene has no feather",
        ),
        (
            vec!["render", "starling", "--samples", "4", "--toml"],
            "--samples has no effect here: --toml prints a scene",
        ),
        (vec!["render", "starling", "--frames", "9", "--toml"], "--frames has no effect here"),
        (vec!["render", "starling", "--denoise", "--toml"], "--denoise has no effect here"),
        (vec!["render", "starling", "--size", "9x9", "--toml"], ""),
        (vec!["keys", "--markdown", "--json"], "--json has no effect here: a page of Markdown"),
        (vec!["completions", "bash", "--json"], "--json has no effect here: a shell reads"),
        (
            vec!["crystal", "mallard", "--map", "--wavelengths", "500", "--phi", "3", "-o", &path("c.svg")],
            "--phi has no effect here: a map is of all φ_i",
        ),
        (
            vec!["crystal", &holes, "--field", "--solver", "rcwa", "-o", &path("c.svg")],
            "--solver has no effect here: fields are found by finite differences in time",
        ),
        (
            "far-field air/keratin:300/air --wavelength 520 --theta 0 --phi 0 --elements 8"
                .split(' ')
                .collect(),
            "--elements has no effect here: it is of full waves",
        ),
        (
            vec!["species", "starling", "--toml", "--wavelengths", "400:700:10"],
            "--wavelengths has no effect here: --toml prints the species file",
        ),
        (vec!["species", "starling", "--toml", "--bird", "starling"], "--bird has no effect here"),
        (vec!["species", "starling", "--toml", "--peak-range", "400:500"], "--peak-range has no effect here"),
        (vec!["species", "starling", "--toml", "--json"], ""),
    ] {
        let (code, _, message) = run(&words);
        assert_eq!(code, 0, "{words:?}: {message}");
        let lines: Vec<&str> = message.lines().filter(|line| !line.starts_with("wrote ")).collect();
        assert_eq!(lines.len(), usize::from(!said.is_empty()), "{words:?}: {message}");
        assert!(message.contains(said), "{words:?}: {message}");
    }
}

#[test]
fn flags_of_every_command_may_stand_before_it() {
    let after = printed(&["geometry", "starling", "--seed", "7", "--json"]);
    assert_eq!(printed(&["--seed", "7", "geometry", "starling", "--json"]), after);
    assert_eq!(printed(&["--json", "--threads", "1", "--seed=7", "geometry", "starling"]), after);
    assert_ne!(printed(&["geometry", "starling", "--json"]), after);
    let (_, _, loud) = run(&["-v", "film", "air/keratin:5/air"]);
    assert!(loud.contains("1 layers, 50 wavelengths"), "{loud}");
}
