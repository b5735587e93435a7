//! A key that a file's format does not know is refused, wherever it stands: every kind of file, every table.

use std::path::{Path, PathBuf};

use barbule::Result;
use barbule::fields::{Value, parse_json};
use barbule::io::{read_lattice, read_section, read_sensor, read_species, read_stack};
use barbule::material::Library;
use barbule::open::{Opening, structure};
use barbule::progress::Unobserved;
use barbule::scene::description::SceneDescription;

/// A key that no format has.
const FOREIGN: &str = "zzforeign";

type Reader = fn(&Path) -> Result<()>;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn scene(path: &Path) -> Result<()> {
    SceneDescription::parse(&std::fs::read_to_string(path).unwrap()).map(drop)
}

fn species(path: &Path) -> Result<()> {
    read_species(path, None, &Library::builtin()).map(drop)
}

fn stack(path: &Path) -> Result<()> {
    read_stack(path, &Library::builtin()).map(drop)
}

fn lattice(path: &Path) -> Result<()> {
    read_lattice(path, &Library::builtin()).map(drop)
}

fn section(path: &Path) -> Result<()> {
    read_section(path, &Library::builtin()).map(drop)
}

fn sensor(path: &Path) -> Result<()> {
    read_sensor(path).map(drop)
}

/// As commands open what they are given, by what is in it.
fn opened(path: &Path) -> Result<()> {
    structure(&path.to_string_lossy(), &Opening::default(), &Unobserved).map(drop)
}

/// The files `.toml` and `.json` of a folder of the repository.
fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    let found = barbule::io::files_in(&root().join(folder), ending);
    assert!(!found.is_empty(), "{folder}");
    found
}

/// Refuses, or the test fails: the message names the key and where it stands.
fn refused(path: &Path, place: &str, read: Reader) {
    match read(path) {
        Ok(()) => panic!("{}: {FOREIGN} in {place} is accepted", path.display()),
        Err(error) => {
            let text = error.to_string();
            assert!(error.is_input() && text.contains(FOREIGN) && text.contains(place), "{place}: {text}");
        }
    }
}

/// Puts the key into each table of a TOML, as its first line, and into each that stands in a line.
fn in_every_table(original: &Path, text: &str, readers: &[Reader]) {
    let path =
        original.with_file_name(format!("foreign-{}", original.file_name().unwrap().to_string_lossy()));
    let lines: Vec<&str> = text.lines().collect();
    let mut changed: Vec<(usize, String)> = vec![(0, format!("{FOREIGN} = 1"))];
    for (index, line) in lines.iter().enumerate() {
        let code = line.trim_start();
        // Names of media are the user's own.
        if code.starts_with("[materials]") {
            continue;
        }
        if line.starts_with('[') {
            changed.push((index + 1, format!("{FOREIGN} = 1")));
        } else if !code.starts_with('#') {
            let code = &line[..line.find(" #").unwrap_or(line.len())];
            changed.extend(code.match_indices('{').map(|(at, _)| {
                (usize::MAX, format!("{index} {}{FOREIGN} = 1, {}", &line[..=at], &line[at + 1..]))
            }));
        }
    }
    for (index, new) in changed {
        let mut text: Vec<String> = lines.iter().map(|line| (*line).to_owned()).collect();
        let number = if index == usize::MAX {
            let (at, new) = new.split_once(' ').unwrap();
            let at: usize = at.parse().unwrap();
            new.clone_into(&mut text[at]);
            at + 1
        } else {
            text.insert(index, new);
            index + 1
        };
        std::fs::write(&path, text.join("\n")).unwrap();
        for read in readers {
            refused(&path, &format!("line {number}"), *read);
        }
    }
    std::fs::remove_file(path).unwrap();
}

/// Puts the key into each table of a JSON; the place is its path.
fn in_every_object(path: &Path, document: &Value, readers: &[Reader]) {
    let mut places = Vec::new();
    let mut open = vec![(String::new(), document)];
    while let Some((place, value)) = open.pop() {
        match value {
            Value::Object(table) => {
                open.extend(table.iter().map(|(key, value)| (format!("{place}/{key}"), value)));
                places.push(place);
            }
            Value::Array(values) => {
                open.extend(values.iter().enumerate().map(|(k, value)| (format!("{place}/{k}"), value)));
            }
            _ => {}
        }
    }
    for place in places {
        let mut changed = document.clone();
        changed.pointer_mut(&place).unwrap().as_object_mut().unwrap().insert(FOREIGN.to_owned(), 1.into());
        std::fs::write(path, changed.to_string()).unwrap();
        // As messages write it: `inclusions[0].circle`.
        let words = place.trim_start_matches('/').split('/');
        let named = words.fold(String::new(), |path, word| match word.parse::<usize>() {
            Ok(number) => format!("{path}[{number}]"),
            Err(_) if path.is_empty() => word.to_owned(),
            Err(_) => format!("{path}.{word}"),
        });
        for read in readers {
            refused(path, &named, *read);
        }
    }
}

/// Copies a file with what lies beside it, and gives its place: what it names is found there.
fn beside(folder: &Path, original: &Path) -> PathBuf {
    for entry in std::fs::read_dir(original.parent().unwrap()).unwrap() {
        let from = entry.unwrap().path();
        if from.is_file() {
            std::fs::copy(&from, folder.join(from.file_name().unwrap())).unwrap();
        }
    }
    folder.join(original.file_name().unwrap())
}

fn walk(files: &[PathBuf], readers: &[Reader]) {
    for original in files {
        let folder = tempfile::tempdir().unwrap();
        let path = beside(folder.path(), original);
        for read in readers {
            read(&path).unwrap();
        }
        let text = std::fs::read_to_string(&path).unwrap();
        if path.extension().is_some_and(|end| end == "json") {
            in_every_object(&path, &parse_json(&text).unwrap(), readers);
        } else {
            in_every_table(&path, &text, readers);
        }
    }
}

/// Texts that the documentation has no file of: each table that a format knows, once.
fn written(name: &str, text: &str, readers: &[Reader]) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    walk(&[path], readers);
}

#[test]
fn species_and_their_feathers() {
    let birds = std::fs::read_dir(root().join("crates/barbule-birds/birds")).unwrap();
    let own: Vec<PathBuf> =
        birds.map(|entry| entry.unwrap().path().join("species.toml")).filter(|path| path.is_file()).collect();
    assert!(own.len() > 5);
    walk(&own, &[species, opened]);
    walk(&files("examples/species", "toml"), &[species, opened]);
}

#[test]
fn stacks() {
    walk(&files("examples/stacks", "toml"), &[stack, opened]);
}

#[test]
fn lattices() {
    walk(&files("examples/lattices", "toml"), &[lattice, opened]);
    let toml = "[lattice]\nperiod = 0.19\nhost = { index = [1.56, 0] }\ncortex = 0.28\n\
        [[lattice.rod]]\nx = 0.0\ncircles = [{ diameter = 0.13, medium = { index = [1.8, 0.1] } }]\n\
        [materials]\nmine = [1.5, 0]\n";
    written("l.toml", toml, &[lattice, opened]);
    let json = r#"{"lattice": {"period": 0.19, "host": {"index": [1.56, 0]}, "cortex": 0.28,
        "rod": [{"circles": [{"diameter": 0.13, "medium": "melanin"}]}]}, "materials": {"mine": [1.5, 0]}}"#;
    written("l.json", json, &[lattice, opened]);
}

#[test]
fn sections_and_segments() {
    walk(&files("examples", "json"), &[section, opened]);
    let json = r#"{"barbule": 1, "units": "um", "width": 2.0, "materials": {"mine": [1.5, 0]},
        "boundaries": [{"x": [-1, 0, 1], "z": [0, 0, 0]}, {"x": [-1, 0, 1], "z": [-3, -3, -3]}],
        "media": ["air", {"mix": [{"index": [1.5, 0]}, "keratin"], "x": [-1, 1], "fraction": [0, 1]}, "keratin"],
        "inclusions": [{"circle": {"x": 0, "z": -1, "radius": 0.3}, "medium": {"index": [1, 0]},
            "holes": [{"circle": {"x": 0, "z": -1, "radius": 0.1}}]}]}"#;
    written("s.json", json, &[section, opened]);
    let json = r#"{"barbule": 1, "units": "um", "width": 2.0, "boundaries": [{"x": [-1, 0, 1], "z": [0, 0, 0]}],
        "lattice": {"period": 0.19, "cortex": 0.28, "offset": 0.1, "regularity": {"x": [-1, 1], "value": [1, 1]},
            "rod": [{"circles": [{"diameter": 0.13, "medium": "melanin"}]}]}}"#;
    written("c.json", json, &[section, opened]);
}

#[test]
fn scenes_feathers_and_coats() {
    walk(&files("examples/scenes", "toml"), &[scene]);
    walk(&files("crates/barbule-appearance/src/scene/presets", "toml"), &[scene]);
    let birds = std::fs::read_dir(root().join("crates/barbule-birds/birds")).unwrap();
    let presets: Vec<PathBuf> = birds
        .flat_map(|entry| {
            let folder = entry.unwrap().path();
            ["scene.toml", "feather.toml"].map(|name| folder.join(name))
        })
        .filter(|path| path.is_file())
        .collect();
    walk(&presets, &[scene]);
}

#[test]
fn sensors() {
    let toml = "name = 'eye'\nwavelength_nm = [400, 700]\n[[channels]]\nname = 'L'\nvalues = [1, 1]\n\
        [[channels]]\nname = 'S'\nvalues = [1, 0.5]\n";
    written("eye.toml", toml, &[sensor]);
}
