//! Materials as they are kept and found again, and one's own bird wherever a species goes.

use std::path::{Path, PathBuf};
use std::process::Stdio;

use barbule::brdf::FeatherMaterial;
use barbule::brdf::fit::FitOptions;
use barbule::brdf::fixtures::example;
use barbule::characterize::{CampaignOptions, Catalog};
use barbule::io::{
    hash_bytes, hash_file, read_lattice, read_material, read_sections, read_species, write_material,
};
use barbule::material::Library;
use barbule::structure::{Section, Structure, species_toml};
use serde_json::Value;

use crate::common::{Ran, program, said_by};

/// A folder to work in, with a cache.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    fn command(&self, words: &[&str]) -> std::process::Command {
        let mut command = program();
        command.args(words).args(["--cache", "cache"]).current_dir(self.0.path());
        command
    }

    fn run(&self, words: &[&str]) -> Ran {
        let output = self.command(words).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
        (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
    }

    fn succeed(&self, words: &[&str]) -> (String, String) {
        let (code, out, said) = self.run(words);
        assert_eq!(code, 0, "{words:?}: {said}");
        (out, said)
    }

    fn refused(&self, words: &[&str], part: &str) {
        let (code, out, said) = self.run(words);
        assert!(code == 2 && said.contains(part), "{words:?}: {code} {said}");
        assert!(out.is_empty() && said.len() < 600 && said.lines().count() == 1, "{words:?}: {said}");
    }

    fn json(&self, words: &[&str]) -> Value {
        serde_json::from_str(&self.succeed(&[words, &["--json"]].concat()).0).unwrap()
    }

    /// Files of the cache.
    fn cached(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.path("cache")).into_iter().flatten();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// Keeps, as the full default material of a structure, one that took no minutes to make.
    fn keep_full(&self, structure: Structure) -> PathBuf {
        let plan = CampaignOptions::default().plan(structure).unwrap();
        let mut material = example(2);
        material.info = serde_json::json!({
            "name": plan.structure.name(), "campaign": plan.description.to_json().unwrap(),
        });
        Catalog { cache: Some(self.path("cache")) }.keep(&plan, &FitOptions::default(), &material).unwrap()
    }

    /// Writes a material of few wavelengths, which renders at once.
    fn write_small(&self) {
        write_material(&self.path("small.barbule"), &example(2)).unwrap();
    }

    fn swallow(&self) -> Structure {
        let text = species_toml("starling").unwrap().replace("name = \"starling\"", "name = \"swallow\"");
        self.write("swallow.toml", &text);
        let model = read_species(&self.path("swallow.toml"), None, &Library::builtin()).unwrap();
        Structure::Species(Box::new(model))
    }
}

/// A campaign of a tenth of a second.
const TINY: &[&str] = &["--wavelengths", "500,600", "--directions", "2x2", "--instances", "2"];

/// A picture of a tenth of a second.
const SMALL: &[&str] = &["--size", "24x15", "--samples", "2"];

#[test]
fn materials_of_other_structures_and_options_stand_beside_each_other() {
    let place = Place::new();
    let characterize = |words: &[&str]| place.succeed(&[&["characterize"], words].concat()).0;
    let mut paths = vec![
        characterize(&["air/keratin:300/air", "--thin", "10"]),
        characterize(&[&["air/keratin:300/air", "--sigma", "0.05"], TINY].concat()),
        characterize(&[&["air/keratin:300/air", "--halo"], TINY].concat()),
        characterize(&[&["starling", "--sigma", "0.05"], TINY].concat()),
    ];
    assert!(paths[0].contains("air-keratin-300-air-") && paths[0].ends_with(".barbule"), "{}", paths[0]);
    let hashes: Vec<String> = paths.iter().map(|path| hash_file(&place.path(path)).unwrap()).collect();
    // Again: the same files with the same bytes.
    assert_eq!(characterize(&["air/keratin:300/air", "--thin", "10"]), paths[0]);
    let again: Vec<String> = paths.iter().map(|path| hash_file(&place.path(path)).unwrap()).collect();
    assert_eq!(hashes, again);
    // Spelled differently: the same file, which bears the new name inside.
    assert_eq!(characterize(&["air/keratin:300.0/air", "--thin", "10"]), paths[0]);
    paths.sort();
    paths.dedup();
    assert_eq!((paths.len(), place.cached().len()), (4, 4));
    let list = place.json(&["cache"]);
    let files = list["files"].as_array().unwrap();
    assert!(files.iter().all(|file| file["full"] == false && file["own"] == false), "{list}");
    assert_eq!(files.iter().filter(|file| file["thinned"] == 10).count(), 1);
    assert_eq!(files.iter().filter(|file| file["sigma"] == 0.05).count(), 2);
    assert_eq!(files.iter().filter(|file| file["halo"] == true).count(), 1);
}

#[test]
fn a_quick_look_neither_replaces_nor_shadows_a_full_material() {
    let place = Place::new();
    let kept = place.keep_full(place.swallow());
    let hash = hash_file(&kept).unwrap();
    for words in [&["--thin", "10"][..], TINY] {
        let (path, said) = place.succeed(&[&["characterize", "swallow.toml"], words].concat());
        assert_ne!(place.path(&path), kept);
        assert!(said.contains("wrote ") && said.contains("swallow:green"), "{said}");
    }
    let (path, _) = place.succeed(&["cache", "--path", "swallow.toml"]);
    assert_eq!(place.path(&path), kept);
    let (code, _, said) = place.run(&["cache", "--path", "swallow.toml:pink"]);
    assert!(code == 2 && said.contains("make it with `barbule characterize swallow.toml:pink`"), "{said}");
    let report = place.json(&[&["render", "swallow.toml", "-o", "s.png"], SMALL].concat());
    assert_eq!(report[0]["material_hash"].as_str(), Some(&*hash));
    assert_eq!(hash_file(&kept).unwrap(), hash);
}

#[test]
fn one_material_made_by_two_processes_at_once_is_whole() {
    let place = Place::new();
    let words = [&["characterize", "starling"], TINY].concat();
    let start = || place.command(&words).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let paths = [start(), start()].map(|child| {
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stdout).unwrap()
    });
    assert_eq!(paths[0], paths[1]);
    assert_eq!(place.cached().len(), 1);
    read_material(&place.path(paths[0].trim())).unwrap();
}

#[test]
fn shipped_and_cached_materials_are_written_as_files() {
    let place = Place::new();
    let (_, said) = place.succeed(&["cache", "--copy", "starling", "-o", "s.barbule"]);
    assert_eq!(said, "wrote s.barbule: the material starling:green");
    let shipped = barbule_birds::material("starling-green").unwrap();
    assert!(std::fs::read(place.path("s.barbule")).unwrap() == shipped);
    let kept = place.keep_full(place.swallow());
    let copied = place.json(&["cache", "--copy", "swallow.toml", "-o", "w.barbule"]);
    assert!(std::fs::read(place.path("w.barbule")).unwrap() == std::fs::read(&kept).unwrap());
    assert_eq!(copied["hash"], hash_file(&kept).unwrap());
    place.refused(&["cache", "--path", "starling"], "`barbule cache --copy starling -o FILE.barbule`");
    place.refused(
        &["cache", "--copy", "starling:pink", "-o", "p.barbule"],
        "`barbule characterize starling:pink`",
    );
    place.refused(
        &["cache", "--path", "air/2*(keratin:5)/air"],
        "`barbule characterize 'air/2*(keratin:5)/air'`",
    );
    place.refused(&["cache", "--copy", "starling", "-o", "no/s.barbule"], "does not exist");
    assert_eq!(place.run(&["cache", "--copy", "starling"]).0, 2);
    // A file is where it is.
    assert_eq!(place.succeed(&["cache", "--path", "s.barbule"]).0, "s.barbule");
    assert!(!place.path("p.barbule").exists());
}

#[test]
fn a_list_makes_nothing_and_clearing_leaves_what_is_ones_own() {
    let place = Place::new();
    assert_eq!(place.succeed(&["cache"]).0, "cache: 0 cached");
    assert!(!place.path("cache").exists());
    place.succeed(&[&["characterize", "mallard"], TINY].concat());
    let mut made = place.cached();
    made.sort_by_key(|name| name.ends_with(".orders"));
    assert!(made.len() == 2 && made[0].ends_with(".barbule") && made[1].ends_with(".orders"), "{made:?}");
    // A fit of one's own, and a copy of what was made.
    write_material(&place.path("cache/mine.barbule"), &example(3)).unwrap();
    std::fs::copy(place.path("cache").join(&made[0]), place.path("cache/mallard.barbule")).unwrap();
    let (list, _) = place.succeed(&["cache"]);
    assert!(list.starts_with("cache: 2 cached, 2 of your own"), "{list}");
    for part in
        ["mallard:lime", "2 wavelengths 500 to 600 nm", "2 instances", "orders of a crystal", "(your own)"]
    {
        assert!(list.contains(part), "{part}: {list}");
    }
    let (list, _) = place.succeed(&["cache", "--clear"]);
    assert_eq!((list.matches("  deleted").count(), list.matches("  left").count()), (2, 2), "{list}");
    assert_eq!(place.cached(), ["mallard.barbule", "mine.barbule"]);
}

#[test]
fn a_cache_must_be_a_place_of_its_own() {
    let place = Place::new();
    place.write("file", "");
    let run = |name: &str, value: &str| {
        let mut command = program();
        for variable in ["XDG_CACHE_HOME", "LOCALAPPDATA", "HOME"] {
            command.env_remove(variable);
        }
        let output = command.arg("cache").env(name, value).current_dir(place.0.path()).output().unwrap();
        (output.status.code().unwrap(), said_by(&output))
    };
    for name in ["HOME", "XDG_CACHE_HOME"] {
        let (code, said) = run(name, "relative");
        assert!(
            code == 2 && said.contains(&format!("{name} is 'relative', but must be an absolute path")),
            "{said}"
        );
    }
    let (code, said) = run("UNKNOWN", "");
    assert!(code == 2 && said.contains("give one with --cache"), "{said}");
    assert_eq!(run("HOME", &place.path("home").to_string_lossy()).0, 0);
    assert_eq!(std::fs::read_dir(place.0.path()).unwrap().count(), 1);
}

#[cfg(unix)]
#[test]
fn paths_that_are_no_text_are_no_panic() {
    use std::os::unix::ffi::OsStrExt as _;
    let place = Place::new();
    let odd = std::ffi::OsStr::from_bytes(b"c\xff");
    std::fs::create_dir(place.0.path().join(odd)).unwrap();
    write_material(&place.0.path().join(odd).join(std::ffi::OsStr::from_bytes(b"\xfe.barbule")), &example(3))
        .unwrap();
    for words in [&["cache", "--json"][..], &["cache"]] {
        let mut command = program();
        let output =
            command.args(words).arg("--cache").arg(odd).current_dir(place.0.path()).output().unwrap();
        assert!(output.status.success(), "{}", said_by(&output));
        assert!(String::from_utf8_lossy(&output.stdout).contains('\u{fffd}'));
    }
    let made = |words: &[&str], file: &[u8]| {
        let mut command = program();
        let command = command.args(words).arg("-o").arg(std::ffi::OsStr::from_bytes(file));
        let output =
            command.args(["--json", "--cache", "cache"]).current_dir(place.0.path()).output().unwrap();
        assert!(output.status.success(), "{}", said_by(&output));
    };
    made(&[&["characterize", "starling"], TINY].concat(), b"m\xff.barbule");
    place.write_small();
    made(&[&["render", "starling", "--material", "small.barbule"], SMALL].concat(), b"\xff.png");
}

#[test]
fn built_in_names_never_mean_a_file_or_a_folder() {
    let place = Place::new();
    place.write("starling", "no material");
    std::fs::create_dir(place.path("mallard")).unwrap();
    std::fs::create_dir(place.path("starling.zarr")).unwrap();
    place.write("starling.zarr/zarr.json", "{}");
    for name in ["starling", "mallard"] {
        place.refused(&["cache", "--path", name], "ships inside the program");
        place.succeed(&["geometry", name, "-o", "g.svg"]);
    }
    let report = place.json(&[&["render", "starling", "-o", "r.png"], SMALL].concat());
    let shipped = barbule_birds::material("starling-green").unwrap();
    assert_eq!(report[0]["material_hash"], hash_bytes(shipped));
    place.refused(&["geometry", "starling:grean", "-o", "g.svg"], "did you mean 'green'");
}

/// A species, a lattice, a section, a folder of sections and stacks, each as a scene and as a material of a scene.
#[test]
fn ones_own_bird_goes_wherever_a_species_goes() {
    let place = Place::new();
    place.keep_full(place.swallow());
    let library = Library::builtin();
    let flat = |stack: &str| Structure::flat(stack).unwrap();
    let section = flat("air/keratin:310/air").instance(1, 0).unwrap();
    let sections = |name: &str, sections: Vec<Section>| Structure::Sections { name: name.into(), sections };
    barbule::io::write_section(&place.path("one.json"), &section).unwrap();
    place.keep_full(sections("one", vec![section]));
    std::fs::create_dir(place.path("two")).unwrap();
    for k in 1..=2 {
        let section = flat("air/keratin:320/melanin").instance(1, 0).unwrap();
        barbule::io::write_section(&place.path(&format!("two/{k}.json")), &section).unwrap();
    }
    place.keep_full(sections("two", read_sections(&place.path("two"), &library).unwrap()));
    place.write("stack.toml", "stack = 'air/keratin:330/air'");
    place.keep_full(flat("air/keratin:330/air"));
    place.keep_full(flat("air/keratin:340/air"));
    let lattice = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/lattices/square-holes.toml");
    std::fs::copy(lattice, place.path("holes.toml")).unwrap();
    let crystal = Section::flat_crystal("holes", read_lattice(lattice.as_ref(), &library).unwrap()).unwrap();
    place.keep_full(sections("holes", vec![crystal]));
    std::fs::copy(place.path("swallow.toml"), place.path("bird.txt")).unwrap();
    let birds = [
        "swallow.toml",
        "swallow.toml:green",
        "bird.txt",
        "one.json",
        "two",
        "two/",
        "./stack.toml",
        "holes.toml",
        "air/keratin:340/air",
    ];
    place.write("corner.toml", "preset = 'rock-dove'\n[window]\nradius_mm = 0.1\n");
    for bird in birds {
        let (_, said) = place.succeed(&[&["render", bird, "-o", "a.png", "--light=33,44"], SMALL].concat());
        let line =
            format!("wrote a.png: {bird}, light 33,44, 24 x 15 pixels, 2.0 samples each, lit by D65 6504 K");
        assert_eq!(said, line);
        let with = [&["render", "corner.toml", "--material", bird, "-o", "b.png"], SMALL].concat();
        assert!(!place.succeed(&with).1.contains("characterizing"));
        place.succeed(&["lobes", bird, "-o", "l.svg", "--parameters"]);
    }
}

/// A scene's files are those beside it, wherever the program runs.
#[test]
fn the_material_of_a_scene_stands_beside_it() {
    let place = Place::new();
    std::fs::create_dir(place.path("scenes")).unwrap();
    write_material(&place.path("scenes/one.barbule"), &example(2)).unwrap();
    write_material(&place.path("one.barbule"), &example(3)).unwrap();
    let scene = |material: &str| {
        place.write(
            "scenes/s.toml",
            &format!("preset = 'rock-dove'\nmaterial = '{material}'\n[window]\nradius_mm = 0.1\n"),
        );
        [&["render", "scenes/s.toml", "-o", "a.png"], SMALL].concat()
    };
    let hash = |material: &str| place.json(&scene(material))[0]["material_hash"].clone();
    let [beside, here] =
        ["scenes/one.barbule", "one.barbule"].map(|file| hash_file(&place.path(file)).unwrap());
    assert_eq!((hash("one.barbule"), hash("../one.barbule")), (beside.into(), here.into()));
    std::fs::remove_file(place.path("scenes/one.barbule")).unwrap();
    place.refused(&scene("one.barbule"), "scenes/one.barbule: no such file");
    // Names of species and stacks stay what they are.
    place.refused(&scene("starling:puce"), "starling has no variant 'puce'");
    place.keep_full(Structure::flat("air/keratin:340/air").unwrap());
    place.succeed(&scene("air/keratin:340/air"));
}

#[test]
fn a_species_file_brings_its_feather_and_a_material_its_species() {
    let place = Place::new();
    let preset = barbule::scene::preset::toml("starling").unwrap();
    let feather = &preset[preset.find("[feather.shaft]").unwrap()..];
    let text = |feather: &str| format!("{}\n{feather}", species_toml("starling").unwrap());
    place.write("same.toml", &text(feather));
    place.write("dense.toml", &text(&feather.replacen("spacing_um = 24.0", "spacing_um = 12.0", 1)));
    place.write("bad.toml", &text(&feather.replacen("spacing_um = 24.0", "spacing_um = 0.0", 1)));
    place.write_small();
    let with = |scene: &str, more: &[&str]| {
        place.json(&[&["render", scene, "-o", "a.png"], SMALL, more].concat())[0].clone()
    };
    let render = |scene: &str| with(scene, &["--material", "small.barbule"]);
    let (same, dense, built_in) = (render("same.toml"), render("dense.toml"), render("starling"));
    assert_eq!((&same["barbules"], &same["pixel_hash"]), (&built_in["barbules"], &built_in["pixel_hash"]));
    assert!(dense["barbules"].as_u64() > same["barbules"].as_u64().map(|count| count * 3 / 2));
    place.refused(
        &["render", "bad.toml", "-o", "x.png"],
        "feather.distal.spacing_um is 0, outside 1 to 10000",
    );
    // A material is shown in the scene of its species, whatever its file is called.
    let mut material = example(2);
    material.info = serde_json::json!({ "species": "magpie" });
    write_material(&place.path("made.barbule"), &material).unwrap();
    std::fs::rename(place.path("made.barbule"), place.path("one.bin")).unwrap();
    let (own, magpie) = (with("one.bin", &[]), with("magpie", &["--material", "one.bin"]));
    assert_eq!((&own["barbules"], &own["pixel_hash"]), (&magpie["barbules"], &magpie["pixel_hash"]));
    assert_ne!(own["barbules"], built_in["barbules"]);
}

#[test]
fn what_a_file_is_is_said_with_what_to_do() {
    let place = Place::new();
    place.write("scene.toml", "preset = 'starling'\n");
    place.write("odd.toml", "a = 1\n");
    place.write("broken.toml", "a = = 1\n");
    place.write("words.txt", "words");
    std::fs::write(place.path("m.barbule"), barbule_birds::material("starling-green").unwrap()).unwrap();
    place.succeed(&[&["simulate", "starling", "-o", "s.zarr"], TINY].concat());
    let fit = "`barbule fit s.zarr -o material.barbule`";
    for (words, part) in [
        (&["render", "s.zarr", "-o", "x.png"][..], fit),
        (&["spectrum", "s.zarr"], fit),
        (&["lobes", "s.zarr", "-o", "x.svg"], fit),
        (
            &["spectrum", "m.barbule"],
            "is a material, made from a structure already; render and lobes take it",
        ),
        (&["spectrum", "scene.toml"], "is a scene; draw it with `barbule render scene.toml -o picture.png`"),
        (&["render", "starling", "--material", "scene.toml", "-o", "x.png"], "is a scene; draw it with"),
        (
            &["render", "odd.toml", "-o", "x.png"],
            "odd.toml: is neither a scene (preset, material, light …), nor a species",
        ),
        (&["render", "broken.toml", "-o", "x.png"], "broken.toml: line 1"),
        (
            &["render", "words.txt", "-o", "x.png"],
            "words.txt: is neither a scene, a material nor a structure",
        ),
        (&["render", "none.json", "-o", "x.png"], "none.json: no such file"),
        (&["render", "none.barbule", "-o", "x.png"], "none.barbule: no such file"),
        (&["render", "none.toml:x", "-o", "x.png"], "none.toml: no such file"),
        (&["render", "European-starlign", "-o", "x.png"], "did you mean 'european-starling'"),
        (&["render", "sparrow", "-o", "x.png"], "presets are rock-dove, starling"),
    ] {
        place.refused(words, part);
    }
    // A scene with a fault is one all the same.
    place.write("fault.toml", "preset = 'starling'\nskies = 1\n");
    let (code, _, said) = place.run(&["render", "fault.toml", "-o", "x.png"]);
    assert!(code == 2 && said.contains("skies") && !said.contains("draw it with"), "{said}");
    assert!(!place.path("x.png").exists());
}

#[test]
fn pictures_of_a_quick_look_say_so() {
    let place = Place::new();
    place.succeed(&["characterize", "air/keratin:300/air", "--thin", "10", "-o", "t.barbule"]);
    let words = [&["render", "starling", "--material", "t.barbule", "-o", "t.png"], SMALL].concat();
    let (_, said) = place.succeed(&words);
    assert!(said.contains("the material t.barbule is thinned, a quick look: every 10 wavelengths"), "{said}");
    assert!(said.contains("wrote t.png: t.barbule (thinned), light"), "{said}");
    let bytes = std::fs::read(place.path("t.png")).unwrap();
    assert!(bytes.windows(7).any(|word| word == b"thinned"));
    assert_eq!(place.json(&words)[0]["thinned"], "10");
    place.write_small();
    let full = ["render", "starling", "--material", "small.barbule", "-o", "f.png"];
    let full = place.json(&[&full[..], SMALL].concat());
    assert!(full[0].get("thinned").is_none());
}

#[test]
fn the_hash_of_pixels_does_not_depend_on_how_they_were_asked_for() {
    let place = Place::new();
    place.write("lit.toml", "preset = 'starling'\n[light]\nazimuth_deg = 20\nelevation_deg = 62\n");
    place.write_small();
    let hash = |file: &str, more: &[&str]| {
        let words =
            [&["render", "lit.toml", "--material", "small.barbule", "-o", file], SMALL, more].concat();
        place.json(&words)[0]["pixel_hash"].as_str().unwrap().to_owned()
    };
    for file in ["a.png", "a.exr"] {
        let first = hash(file, &["--threads", "1"]);
        assert!(first.len() == 64 && first == hash(file, &["--threads", "2", "--light", "20,62"]));
        assert_ne!(first, hash(file, &["--seed", "2"]));
    }
}

#[test]
fn a_campaign_goes_on_however_its_structure_is_spelled() {
    let place = Place::new();
    let lattice = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/lattices/square-holes.toml");
    std::fs::copy(lattice, place.path("holes.toml")).unwrap();
    std::fs::create_dir(place.path("two")).unwrap();
    for k in 1..=2 {
        let section = Structure::builtin("starling").unwrap().instance(1, k).unwrap();
        barbule::io::write_section(&place.path(&format!("two/{k}.json")), &section).unwrap();
    }
    let pairs =
        [("holes.toml", "./holes.toml"), ("two", "two/"), ("air/keratin:300/air", "air/keratin:300.0/air")];
    for (number, (first, second)) in pairs.into_iter().enumerate() {
        let store = format!("{number}.zarr");
        place.succeed(&[&["simulate", first, "-o", &store], TINY].concat());
        let (_, said) = place.succeed(&[&["simulate", second, "-o", &store], TINY].concat());
        assert!(said.contains("nothing to do"), "{said}");
    }
    place.refused(
        &[&["simulate", "air/keratin:301/air", "--quiet", "-o", "2.zarr"], TINY].concat(),
        "made with other parameters",
    );
    // Stores that are kept beside a material are named by their campaign.
    std::fs::create_dir(place.path("kept")).unwrap();
    for film in ["air/keratin:300/air", "air/melanin:100/air", "air/keratin:300/air"] {
        place.succeed(&[&["characterize", film, "-o", "m.barbule", "--keep-store", "kept"], TINY].concat());
    }
    assert_eq!(std::fs::read_dir(place.path("kept")).unwrap().count(), 2);
}

#[test]
fn the_barbules_of_given_sections_are_found_again_by_their_name() {
    let place = Place::new();
    place.succeed(&[&["characterize", "air/keratin:300/air", "-o", "m.barbule"], TINY].concat());
    let material: FeatherMaterial = read_material(&place.path("m.barbule")).unwrap();
    assert!(material.info["campaign"]["structure"].get("sections").is_none());
    place.succeed(&["lobes", "m.barbule", "--fits", "-o", "f.svg"]);
    assert!(Path::new(&place.path("f.svg")).exists());
}

#[test]
fn light_comes_from_somewhere_and_from_where_it_can_be_seen() {
    let place = Place::new();
    place.write_small();
    place.write("dark.toml", "preset = 'starling'\nsky = 0\n");
    place.write("night.toml", "preset = 'starling'\nsky = 0\nlights = []\n[light]\nstrength = 0\n");
    place.write("turned.toml", "preset = 'starling'\n[sky_image]\nfile = 'sky.exr'\nturn = 1e17\n");
    place.write("unlit.toml", "preset = 'starling'\n[sky_image]\nfile = 'none.exr'\nstrength = 0\n");
    let render = |scene: &str, more: &[&str]| {
        place.json(&[&["render", scene, "--material", "small.barbule", "-o", "a.png"], SMALL, more].concat())
            [0]["pixel_hash"]
            .clone()
    };
    // Without a sky the picture is that of the key light alone, as under an image that does not shine.
    assert_eq!(render("dark.toml", &[]), render("unlit.toml", &[]));
    assert_ne!(render("dark.toml", &[]), render("starling", &[]));
    place.refused(&["render", "night.toml", "-o", "x.png"], "night.toml: sky and light.strength are both 0");
    place.refused(&["render", "turned.toml", "-o", "x.png"], "turned.toml: sky_image.turn_deg is 1");
    place.refused(
        &["render", "starling", "-o", "x.png", "--light", "1e17,45"],
        "--light: light.azimuth_deg is 1",
    );
    let (_, said) = place.succeed(
        &[&["render", "starling", "--material", "small.barbule", "-o", "a.png", "--light", "45,-20"], SMALL]
            .concat(),
    );
    assert!(said.starts_with("the key light stands at elevation -20 degrees, behind the vane"), "{said}");
    let from_below = [
        "render",
        "starling",
        "--material",
        "small.barbule",
        "-o",
        "a.png",
        "--light",
        "45,-20",
        "--view",
        "190,-60",
    ];
    assert!(!place.succeed(&[&from_below[..], SMALL].concat()).1.contains("behind the vane"));
}
