//! Scenes as other renderers read them: syntax, and that every file that they name is there.

use std::fs;
use std::path::Path;

use barbule::Unobserved;
use barbule::export::scene::{ExportOptions, Exported};
use barbule::open::{Opening, scene};

const CLOSE: &str = "preset = 'starling'\n[camera]\nwidth_mm = 0.5\n[window]\nradius_mm = 0.5\n\
                     [[lights]]\ntype = 'point'\nposition_mm = [0, 0, 9]\nstrength = 1\n\
                     [[objects]]\nsphere_mm = 0.3\nsurface = 'white'\n[surfaces.white]\ntype = 'diffuse'\n";

fn exported(folder: &Path, toml: &str) -> Exported {
    let path = folder.join("scene-of-mine.toml");
    fs::write(&path, toml).unwrap();
    let ready = scene(&path.to_string_lossy(), &Opening::default(), &Unobserved).unwrap();
    Exported::new(&ready, ExportOptions::default(), &Unobserved).unwrap()
}

/// The tokens of a pbrt file: strings with their quotes, brackets, and words.
fn tokens(text: &str) -> Vec<String> {
    let mut all = Vec::new();
    for line in text.lines() {
        let mut rest = line.split('#').next().unwrap_or_default().trim_start();
        while let Some(first) = rest.chars().next() {
            let end = match first {
                '"' => rest[1..].find('"').expect("a string ends in its line") + 2,
                '[' | ']' => 1,
                _ => rest.find([' ', '"', '[', ']']).unwrap_or(rest.len()),
            };
            all.push(rest[..end].to_owned());
            rest = rest[end..].trim_start();
        }
    }
    all
}

/// Reads a pbrt file as far as its grammar goes: directives, each with strings and numbers, then parameters `"type name"` with a value
/// or a list of them. Counts directives, and checks that files are there.
fn read_pbrt(path: &Path, seen: &mut Vec<String>) {
    const TYPES: [&str; 8] = ["integer", "float", "point3", "string", "bool", "spectrum", "rgb", "texture"];
    let tokens = tokens(&fs::read_to_string(path).unwrap());
    let folder = path.parent().unwrap();
    let (mut at, mut depth) = (0, 0);
    while at < tokens.len() {
        let directive = tokens[at].clone();
        assert!(directive.chars().all(char::is_alphabetic), "{directive} in {}", path.display());
        depth += i32::from(directive == "AttributeBegin") - i32::from(directive == "AttributeEnd");
        assert!(depth >= 0);
        at += 1;
        while at < tokens.len() && !tokens[at].chars().all(char::is_alphabetic) {
            let token = &tokens[at];
            let words: Vec<_> = token.trim_matches('"').split(' ').collect();
            let is_parameter = token.starts_with('"') && words.len() == 2 && TYPES.contains(&words[0]);
            if !is_parameter {
                let is_number = token.parse::<f64>().is_ok() || token == "[" || token == "]";
                assert!(is_number || token.starts_with('"'), "{token} after {directive}");
                if directive == "Include" {
                    read_pbrt(&root_of(folder).join(token.trim_matches('"')), seen);
                }
                at += 1;
                continue;
            }
            let values: Vec<String> = if tokens[at + 1] == "[" {
                tokens[at + 2..].iter().take_while(|token| *token != "]").cloned().collect()
            } else {
                vec![tokens[at + 1].clone()]
            };
            assert!(!values.is_empty());
            match words[0] {
                "float" | "integer" | "point3" | "rgb" | "spectrum" => {
                    assert!(values.iter().all(|value| value.parse::<f64>().is_ok()), "{token}: {values:?}");
                }
                "bool" => assert!(values[0] == "true" || values[0] == "false" || values[0] == "\"false\""),
                _ => assert!(values.iter().all(|value| value.starts_with('"'))),
            }
            if words[1] == "filename" && directive != "Film" {
                assert!(root_of(folder).join(values[0].trim_matches('"')).is_file(), "{values:?}");
            }
            at += 1 + if tokens[at + 1] == "[" { values.len() + 2 } else { 1 };
        }
        seen.push(directive);
    }
    assert_eq!(depth, 0);
}

/// pbrt looks for files beside the first scene file, also from those that it includes.
fn root_of(folder: &Path) -> &Path {
    if folder.ends_with("starling") { folder.parent().unwrap() } else { folder }
}

#[test]
fn pbrt_scenes_are_of_its_grammar_and_name_files_that_are_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("starling.pbrt");
    let exported = exported(folder.path(), CLOSE);
    exported.write_pbrt(&path, &mut |_| Ok(b"a table".to_vec())).unwrap();
    assert_eq!(fs::read(folder.path().join("starling/barbule-0.bsdf")).unwrap(), b"a table");
    let mut seen = Vec::new();
    read_pbrt(&path, &mut seen);
    let count = |directive: &str| seen.iter().filter(|one| *one == directive).count();
    for (directive, least) in
        [("Camera", 1), ("Film", 1), ("WorldBegin", 1), ("AreaLightSource", 1), ("LightSource", 2)]
    {
        assert!(count(directive) >= least, "{directive}: {seen:?}");
    }
    assert!(count("Shape") >= 5 && count("NamedMaterial") >= 4);
    let none = folder.path().join("none.pbrt");
    let refused = exported.write_pbrt(&none, &mut |_| Err(barbule::Error::input("no table")));
    assert_eq!(refused.unwrap_err().to_string(), "no table");
    assert!(!none.exists() && !none.with_extension("").exists());
}

/// Tags close in the order they open; files are there; nothing is left of a scene that cannot be written.
#[test]
fn mitsuba_scenes_are_well_formed_and_name_files_that_are_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.xml");
    exported(folder.path(), CLOSE).write_mitsuba(&path).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    let mut open: Vec<&str> = Vec::new();
    for tag in text.split('<').skip(2) {
        let (inside, _) = tag.split_once('>').unwrap();
        let name = inside.trim_start_matches('/').split([' ', '/']).next().unwrap();
        if inside.starts_with('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !inside.ends_with('/') {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "{open:?}");
    let named: Vec<_> =
        text.split("value=\"mine/").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    assert!(named.len() >= 6);
    for file in named {
        assert!(path.with_file_name("mine").join(file).is_file(), "{file}");
    }
}

#[test]
fn what_other_renderers_cannot_show_is_refused_by_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gold.xml");
    let gold = "preset = 'starling'\n[camera]\nwidth_mm = 0.5\n[window]\nradius_mm = 0.4\n\
                [[objects]]\nsphere_mm = 0.3\nsurface = 'gold'\n[surfaces.gold]\ntype = 'conductor'\nroughness = 0.2\nmetal = 'gold'\n";
    let exported = exported(folder.path(), gold);
    let refused = exported.write_mitsuba(&path).unwrap_err().to_string();
    assert!(
        refused.contains(
            "'gold' cannot be shown in Mitsuba, which has nothing for metals, glass and rough films"
        ),
        "{refused}"
    );
    let refused = exported
        .write_pbrt(&path, &mut |_| panic!("asked before lamps and surfaces"))
        .unwrap_err()
        .to_string();
    assert!(refused.contains("is of a surface that pbrt has nothing for"), "{refused}");
    assert!(!path.exists());
    let whole = scene("magpie-feather", &Opening::default(), &Unobserved).unwrap();
    let refused = Exported::new(&whole, ExportOptions::default(), &Unobserved).unwrap_err().to_string();
    assert!(refused.contains("barbules, over the limit of 350000"), "{refused}");
    let path = folder.path().join("scene-of-mine.toml");
    let ready = scene(&path.to_string_lossy(), &Opening::default(), &Unobserved).unwrap();
    let left_out = |name: &str| ExportOptions { without: vec![name.to_owned()], ..ExportOptions::default() };
    let refused = Exported::new(&ready, left_out("shafft"), &Unobserved).unwrap_err().to_string();
    assert!(refused.contains("no part 'shafft' to leave out, did you mean 'shaft'"), "{refused}");
    let without = Exported::new(&ready, left_out("gold"), &Unobserved).unwrap();
    without.write_mitsuba(&folder.path().join("mine.xml")).unwrap();
}
