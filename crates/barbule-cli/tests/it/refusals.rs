//! What is refused, how it is said, and that nothing is left behind: bad arguments and bad files of every kind.
//!
//! Words that start with `@` are names in the test's own folder.

mod files;
mod lines;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use barbule::io::encode_material;
use barbule::io::store::Store;
use barbule::scattering::statistics::Axes;
use barbule::spectrum::Wavelengths;

use crate::common::run_inside;
use files::{Change, SCENE, SCENES, SECTION, SECTIONS, SPECIES, STACK, STACKS, STORES, TABLES};
use lines::{HOSTILE, LINES, READERS};

fn changed(good: &str, (from, to, _): &Change) -> String {
    assert!(good.contains(from), "{from}");
    good.replacen(from, to, 1)
}

fn axes() -> Axes {
    Axes::new(&Wavelengths::new([450.0, 550.0]).unwrap(), vec![0.5, 1.0], vec![0.5, 1.0]).unwrap()
}

fn make_store(path: &Path) {
    let description = serde_json::json!({"structure": {"species": "nobody"}});
    Store::create(path, &axes(), 2, "nobody", &description, &[], "scalar").unwrap();
}

/// Makes all files and gives the command lines that read them.
fn prepared(folder: &Path) -> Vec<(String, &'static str)> {
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
    write("good.csv", b"300,1.5,0\n830,1.5,0\n");
    write("words.csv", b"no numbers\n");
    write("good.json", SECTION.as_bytes());
    write(
        "inclusions.json",
        br#"{"barbule": 1, "units": "um", "inclusions": [{"circle": {"x": 1, "z": 0, "radius": 0.5}, "medium": "melanin"}]}"#,
    );
    for (name, mebibytes) in [("large.toml", 4), ("large.yml", 4), ("large.csv", 16), ("large.json", 64)] {
        let file = std::fs::File::create(folder.join(name)).unwrap();
        file.set_len((mebibytes << 20) + 1).unwrap();
    }
    write("many.json", &vec![b','; 4_000_001]);
    for name in ["empty", "folder.json", "full", "sections"] {
        std::fs::create_dir(folder.join(name)).unwrap();
    }
    write("full/mine.txt", b"x");
    write("sections/a.json", SECTION.as_bytes());
    write("sections/b.json", SECTION.replace("2.0", "4.0").replace("[-1, 0, 1]", "[-2, 0, 2]").as_bytes());
    make_store(&folder.join("good.zarr"));
    let mut lines: Vec<(String, &'static str)> =
        LINES.iter().map(|(line, part)| (line.replace("@empty/full", "@full"), *part)).collect();
    let mut species = Vec::new();
    barbule_cli::run(["barbule", "species", "starling", "--toml"], &mut species, &mut Vec::new());
    let species = String::from_utf8(species).unwrap();
    write("good.toml", species.as_bytes());
    let mut add = |kind: &str, end: &str, good: &str, changes: &'static [Change], command: &str| {
        for (index, change) in changes.iter().enumerate() {
            let name = format!("{kind}-{index}.{end}");
            write(&name, changed(good, change).as_bytes());
            lines.push((command.replace("FILE", &format!("@{name}")), change.2));
        }
    };
    add("section", "json", SECTION, SECTIONS, "geometry FILE -o @f.svg");
    add("species", "toml", &species, SPECIES, "geometry FILE -o @f.svg");
    add("stack", "toml", STACK, STACKS, "film FILE -o @f.svg");
    add("scene", "toml", SCENE, SCENES, "render FILE -o @f.png --samples 1");
    for (index, (end, text, part)) in TABLES.iter().enumerate() {
        write(&format!("table-{index}.{end}"), text.as_bytes());
        lines.push((format!("film air/chitin:5/air --medium chitin=@table-{index}.{end} -o @f.svg"), part));
    }
    for (index, change) in STORES.iter().enumerate() {
        let store = folder.join(format!("store-{index}.zarr"));
        make_store(&store);
        let file = store.join("zarr.json");
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::write(&file, changed(&text, change)).unwrap();
        lines.push((format!("simulate @store-{index}.zarr --status"), change.2));
        lines.push((format!("fit @store-{index}.zarr -o @f.barbule"), change.2));
    }
    let array = folder.join("array.zarr");
    make_store(&array);
    let text = std::fs::read_to_string(array.join("u/zarr.json")).unwrap();
    std::fs::write(array.join("u/zarr.json"), text.replace("crc32c", "gzip")).unwrap();
    lines.push(("simulate @array.zarr --status".into(), "'u' has another codecs"));
    let lacking = folder.join("lacking.zarr");
    make_store(&lacking);
    std::fs::remove_file(lacking.join("v/zarr.json")).unwrap();
    lines.push(("fit @lacking.zarr -o @f.barbule".into(), "v/zarr.json: no such file"));
    let good = encode_material(&barbule::brdf::fixtures::example(2)).unwrap();
    let altered = |at: usize| {
        let mut bytes = good.clone();
        bytes[at] ^= 1;
        bytes
    };
    let materials: [(&str, Vec<u8>, &'static str); 6] = [
        ("nothing", Vec::new(), "is not a material file"),
        ("text", b"this is a text, not a material".to_vec(), "is not a material file"),
        ("long-header", [&u64::MAX.to_le_bytes()[..], b"{}"].concat(), "is not a material file"),
        ("cut", good[..good.len() / 2].to_vec(), "is not a material file"),
        ("last-byte", altered(good.len() - 1), "checksum does not match"),
        ("middle", altered(good.len() * 3 / 4), "checksum does not match"),
    ];
    for (name, bytes, part) in materials {
        write(&format!("{name}.barbule"), &bytes);
        lines.push((format!("lobes @{name}.barbule -o @f.svg"), part));
        lines.push((format!("render starling --material @{name}.barbule -o @f.png"), part));
    }
    lines
}

fn names(folder: &Path) -> BTreeSet<PathBuf> {
    let mut found = BTreeSet::new();
    let mut open = vec![folder.to_owned()];
    while let Some(path) = open.pop() {
        for entry in std::fs::read_dir(path).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path.clone());
            }
            found.insert(path);
        }
    }
    found
}

#[test]
fn whatever_is_typed_a_refusal_is_one_short_line_without_control_characters() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("good.csv"), "300,1.5,0\n830,1.5,0\n").unwrap();
    let here = format!("{}/", folder.path().display());
    let long = "9".repeat(6000);
    let mut wrong = Vec::new();
    for line in READERS {
        for hostile in HOSTILE.map(|text| text.replace("LONG", &long)) {
            let word = |word: &str| word.replace('@', &here).replace('X', &hostile);
            let words: Vec<String> = line.split_whitespace().map(word).collect();
            let (code, out, message) = run_inside(&words);
            let sentence = message.strip_suffix('\n').unwrap_or(&message);
            let is_one = sentence.starts_with("barbule: ") && sentence.len() < 600;
            let clean = !sentence.chars().any(|c| c.is_control() || c == '\u{202e}');
            if code != 2 || !is_one || !clean || !out.is_empty() {
                wrong.push(format!("{line} {hostile:.20?}\n    {code:?} {}: {message:?}", sentence.len()));
            }
        }
    }
    assert!(wrong.is_empty(), "{} lines:\n{}", wrong.len(), wrong.join("\n"));
    assert_eq!(names(folder.path()).len(), 1);
}

#[cfg(unix)]
#[test]
fn pipes_without_a_writer_and_devices_are_no_inputs_and_are_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    for name in ["p.json", "p.toml", "p.csv", "p.barbule"] {
        assert!(std::process::Command::new("mkfifo").arg(at(name)).status().unwrap().success());
    }
    let svg = at("f.svg");
    for line in [
        vec!["geometry", &at("p.json"), "-o", &svg],
        vec!["geometry", &at("p.toml"), "-o", &svg],
        vec!["film", "air/q:5/air", "--medium", &format!("q={}", at("p.csv"))],
        vec!["film", "air/q:5/air", "--medium", "q=/dev/zero"],
        vec!["spectrum", "starling", "--measured", &at("p.csv")],
        vec!["lobes", &at("p.barbule"), "-o", &svg],
        vec!["render", &at("p.toml"), "-o", &at("f.png")],
    ] {
        let words: Vec<String> = line.iter().map(|word| (*word).to_owned()).collect();
        let (code, _, message) = run_inside(&words);
        assert!(code == 2 && message.contains("is a pipe or a device"), "{line:?}: {message}");
    }
}

#[test]
fn every_refusal_is_one_sentence_with_exit_code_2_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let lines = prepared(folder.path());
    assert!(lines.len() >= 150, "{}", lines.len());
    let before = names(folder.path());
    let here = format!("{}/", folder.path().display());
    let mut wrong = Vec::new();
    for (line, part) in &lines {
        let words: Vec<String> = line.split_whitespace().map(|w| w.replace('@', &here)).collect();
        let outcome = std::panic::catch_unwind(|| run_inside(&words));
        let Ok((code, out, message)) = outcome else {
            wrong.push(format!("{line}\n    panics"));
            continue;
        };
        let sentence = message.trim_end();
        let is_one = sentence.starts_with("barbule: ") && !sentence.contains('\n') && sentence.len() < 600;
        if code != 2 || !is_one || !sentence.contains(part) || !out.is_empty() {
            wrong.push(format!("{line}\n    expected: {part}\n    {code:?} {}: {message}", out.len()));
        }
    }
    let left: Vec<_> = names(folder.path()).difference(&before).cloned().collect();
    assert!(wrong.is_empty(), "{} of {} lines:\n{}", wrong.len(), lines.len(), wrong.join("\n"));
    assert!(left.is_empty(), "{left:?}");
}
