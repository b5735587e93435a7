//! No command writes over what it reads: each with every kind of its inputs, and with names that only it makes up.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use barbule::io::image::write_png;
use barbule::scattering::statistics::Axes;
use barbule::spectrum::Wavelengths;

use crate::common::{CLOSE_UP, MADE_UP, bytes_of, run_inside, write_made_up};

const SECTION: &str = r#"{"barbule": 1, "units": "um", "width": 2.0, "name": "a", "materials": {"chitin": "n.csv"},
 "boundaries": [{"x": [-1, 0, 1], "z": [0, 0, 0]}], "media": ["air", "chitin"]}"#;

const LATTICE: &str = "[lattice]\nperiod = 0.19\nhost = 'chitin'\ncortex = 0.2\n\
    [[lattice.rod]]\ncircles = [{ diameter = 0.1, medium = 'melanin' }]\n[materials]\nchitin = 'n.csv'\n";

/// Objects, lamps and surfaces that name a file each.
const SCENE: &str = "preset = 'starling'\nmaterial = 'made.barbule'\n[background]\nfile = 'bg.png'\n\
    [sky_image]\nfile = 'sky.exr'\n[[lights]]\ntype = 'sun'\nazimuth_deg = 0\nelevation_deg = 50\nstrength = 1\nspectrum = 'lamp.csv'\n\
    [surfaces.a]\ntype = 'diffuse'\nalbedo = 'f-0001.png'\nalpha = 'leaf.png'\nnormal = 'n.png'\n\
    [surfaces.b]\ntype = 'diffuse'\n[surfaces.scales]\ntype = 'grating'\nfile = 'g.grating'\n[surfaces.paint]\ntype = 'measured'\nfile = 'p.bsdf'\n\
    [[objects]]\nrectangle_mm = [1, 1]\nsurface = 'paint'\n    [[objects]]\ncurves = 'c.txt'\nsurface = 'b'\n[[objects]]\nmesh = 'm.gltf'\nsurface = 'a'\n\
    [[objects]]\nmesh = 'm.ply'\nsurface = 'scales'\n";

/// The plan of an atlas that names a stack and a bird.
const PLAN: &str = "barbule = 1\nname = 'x'\nstructure = 'stack.toml'\nbirds = ['bird.toml']\nindividuals = 1\n\
    wavelengths_nm = '300:700:20'\n[[vary]]\nkey = 'layer1'\nvalues = [300, 310]\n";

/// Each command that writes with its inputs; then the flags of its outputs, and the files that it reads, under whatever
/// names. `@` is the folder.
const LINES: &[(&str, &[&str], &[&str])] = &[
    ("film @stack.toml --medium q=@q.csv", &["-o", "--csv"], &["stack.toml", "n.csv", "q.csv"]),
    ("lobes @made.barbule", &["-o"], &["made.barbule"]),
    ("brdf @made.barbule --wi 10,20 --wo 0,0 --wavelength 550", &["-o", "--csv"], &["made.barbule"]),
    ("far-field @in.json --wavelength 550 --theta 0 --phi 0", &["-o", "--csv"], &["in.json", "n.csv"]),
    ("spectrum @secs --measured @r.csv", &["-o", "--csv", "--summary"], &["secs/a.json", "n.csv", "r.csv"]),
    ("fit-structure --model film --measured @r.csv", &["-o", "--picture"], &["r.csv"]),
    ("fit-structure --model @mine.toml --measured @r.csv", &["-o"], &["mine.toml", "r.csv"]),
    ("spectrum @mine.toml:green", &["-o", "--csv", "--summary"], &["mine.toml"]),
    ("crystal @lattice.toml", &["-o"], &["lattice.toml", "n.csv"]),
    ("diffract @z.txt --pitch 0.1", &["-o"], &["z.txt"]),
    ("simulate @in.json", &["-o"], &["in.json", "n.csv"]),
    ("fit @s.zarr", &["-o"], &["s.zarr/zarr.json"]),
    ("characterize @lattice.toml", &["-o"], &["lattice.toml", "n.csv"]),
    ("characterize @secs", &["-o"], &["secs/a.json", "n.csv"]),
    ("cache --copy @made.barbule", &["-o"], &["made.barbule"]),
    ("geometry @in.json", &["-o"], &["in.json", "n.csv"]),
    ("geometry @secs", &["-o"], &["secs/a.json", "n.csv"]),
    ("trace @bg.png --scale 1nm=1px", &["-o", "--picture"], &["bg.png"]),
    ("feather @s.toml --level barbs", &["-o"], &["s.toml", "c.txt", "m.gltf", "x.txt", "made.barbule"]),
    ("species @mine.toml", &["-o"], &["mine.toml"]),
    ("feather @mine.toml", &["-o"], &["mine.toml"]),
    ("birds @bird.toml", &["-o"], &["bird.toml"]),
    ("atlas @plan.toml", &["-o"], &["plan.toml", "stack.toml", "n.csv", "bird.toml"]),
    ("atlas @plan.toml -o @a.zarr", &["--picture"], &["plan.toml", "stack.toml", "n.csv", "bird.toml"]),
    (
        "see @r.csv --bird @bird.toml --illuminant @lamp.csv",
        &["-o", "--csv"],
        &["r.csv", "bird.toml", "lamp.csv"],
    ),
    ("spectrum @secs --bird @bird.toml", &["-o", "--csv", "--summary"], &["secs/a.json", "bird.toml"]),
    ("render @s.toml --sensor bird:@bird.toml", &["-o"], &["s.toml", "bird.toml", "made.barbule"]),
    (
        "render @s.toml --sensor bird:@bird.toml -o @o.png",
        &["--human"],
        &["s.toml", "bird.toml", "made.barbule"],
    ),
    (
        "render @s.toml --sensor @eye.toml",
        &["-o"],
        &[
            "s.toml",
            "eye.toml",
            "made.barbule",
            "bg.png",
            "sky.exr",
            "lamp.csv",
            "f-0001.png",
            "leaf.png",
            "n.png",
            "g.grating",
            "p.bsdf",
            "c.txt",
            "m.gltf",
            "x.txt",
            "m.ply",
        ],
    ),
    ("render @mine.toml --background @bg.png", &["-o"], &["mine.toml", "bg.png"]),
    ("render @s.toml --material @lattice.toml", &["-o"], &["s.toml", "lattice.toml", "n.csv", "x.txt"]),
    ("export @made.barbule --to bsdf", &["-o"], &["made.barbule"]),
    ("export @stack.toml --to gltf --medium q=@q.csv", &["-o"], &["stack.toml", "n.csv", "q.csv"]),
    ("export @s.toml --to mitsuba", &["-o"], &["s.toml", "made.barbule", "c.txt", "m.ply", "p.bsdf"]),
    ("validate @in.json --full-wave", &[], &[]),
    ("bench render", &[], &[]),
    ("man", &[], &[]),
];

fn inputs(folder: &Path) {
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
    for name in ["secs", "v", "curves", "p"] {
        fs::create_dir(folder.join(name)).unwrap();
    }
    write("in.json", SECTION);
    let elsewhere = SECTION.replace("n.csv", "../n.csv");
    write("secs/a.json", &elsewhere);
    write("v/numbers.json", &elsewhere);
    for name in ["n.csv", "q.csv", "v/colours.svg"] {
        write(name, "300,1.5,0\n830,1.5,0\n");
    }
    write("r.csv", "400,0.1\n700,0.2\n");
    write("z.txt", "0 1\n1 0\n");
    write("stack.toml", "stack = 'air/chitin:300/air'\n[materials]\nchitin = 'n.csv'\n");
    write("plan.toml", PLAN);
    write("p/index.html", &PLAN.replace("stack.toml", "../stack.toml").replace("bird.toml", "../bird.toml"));
    write("lattice.toml", LATTICE);
    write("s.toml", SCENE);
    write("m.gltf", r#"{"asset": {"version": "2.0"}, "buffers": [{"uri": "x.txt", "byteLength": 4}]}"#);
    write("eye.toml", "wavelength_nm = [400, 700]\n[[channels]]\nname = 'L'\nvalues = [1, 1]\n");
    write("bird.toml", "[[cones]]\nname = 'L'\npigment_nm = 563\n");
    for name in [
        "made.barbule",
        "sky.exr",
        "lamp.csv",
        "leaf.png",
        "n.png",
        "g.grating",
        "p.bsdf",
        "c.txt",
        "x.txt",
        "m.ply",
    ] {
        write(name, "never looked at");
    }
    for name in ["bg.png", "f-0001.png"] {
        write_png(&folder.join(name), [1, 1], &[9, 9, 9], false, &[]).unwrap();
    }
    for name in ["curves/feather_barbs.txt", "curves/feather_barbules.txt"] {
        write(name, include_str!("../../../../examples/scenes/tuft.txt"));
    }
    let mut species = Vec::new();
    barbule_cli::run(["barbule", "species", "starling", "--toml"], &mut species, &mut Vec::new());
    fs::write(folder.join("mine.toml"), species).unwrap();
    let axes = Axes::new(&Wavelengths::new([450.0]).unwrap(), vec![1.0], vec![1.0]).unwrap();
    let description = serde_json::json!({});
    barbule::io::store::Store::create(&folder.join("s.zarr"), &axes, 2, "x", &description, &[], "scalar")
        .unwrap();
}

/// The program's exit code and message.
fn run(folder: &Path, line: &str) -> (u8, String) {
    let place = format!("{}/", folder.display());
    let words = line.split_whitespace().chain(["--quiet"]).map(|word| word.replace('@', &place));
    let (code, _, message) = run_inside(words);
    (code, message)
}

#[test]
fn no_command_writes_over_any_kind_of_its_inputs() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    inputs(at);
    // Of another name and ending, so that nothing but the ledger can refuse it.
    let mut aliases = Vec::new();
    let read: BTreeSet<&str> = LINES.iter().flat_map(|(_, _, inputs)| *inputs).copied().collect();
    for (index, input) in read.iter().enumerate() {
        for end in ["svg", "csv", "png", "barbule", "ply", "grating", "zarr"] {
            let alias = format!("alias-{index}.{end}");
            fs::hard_link(at.join(input), at.join(&alias)).unwrap();
            aliases.push((*input, alias));
        }
    }
    let before = bytes_of(at);
    for (line, flags, inputs) in LINES {
        for (flag, input) in flags.iter().flat_map(|flag| inputs.iter().map(move |input| (flag, input))) {
            let own = [*input].into_iter();
            let others = aliases.iter().filter(|(of, _)| of == input).map(|(_, alias)| alias.as_str());
            for output in own.chain(others) {
                let line = format!("{line} {flag} @{output}");
                let (code, text) = run(at, &line);
                let said = [
                    "this command reads it",
                    "one of the sections",
                    "inside a campaign store",
                    "tables are written as CSV",
                ];
                // A store is a folder; that a figure's name has no such ending is said first, too.
                let is_said = said.iter().any(|part| text.contains(part));
                assert!(code == 2 && is_said, "{line}\n{text}");
            }
        }
        assert!(bytes_of(at) == before, "{line}");
    }
}

#[test]
fn every_command_that_writes_is_tried() {
    const WRITTEN: [&str; 8] =
        ["output", "csv", "summary", "human", "store", "folder", "page", "write_curves"];
    let tried: BTreeSet<&str> =
        LINES.iter().filter_map(|(line, ..)| line.split_whitespace().next()).collect();
    let mut command = barbule_cli::command();
    command.build();
    for command in command.get_subcommands() {
        let mut open = vec![command];
        while let Some(inner) = open.pop() {
            let writes = inner.get_arguments().any(|argument| WRITTEN.contains(&argument.get_id().as_str()));
            assert!(
                !writes || tried.contains(command.get_name()),
                "{}: say what it reads",
                command.get_name()
            );
            open.extend(inner.get_subcommands());
        }
    }
}

#[test]
fn names_that_only_the_command_makes_up_are_refused_too() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    inputs(at);
    fs::copy(at.join("n.csv"), at.join("o.png.part-1-of-2")).unwrap();
    let before = bytes_of(at);
    for (line, part) in [
        (
            "render @s.toml --medium q=@o.png.part-1-of-2 --size 8x8 --samples 1 --shard 1/2 -o @o.png",
            "o.png.part-1-of-2: would be overwritten",
        ),
        ("validate @v/numbers.json --full-wave -o @v", "numbers.json: would be overwritten"),
        ("validate @v/numbers.json --three-d -o @v", "numbers.json: would be overwritten"),
        (
            "validate air/q:300/air --medium q=@v/colours.svg --full-wave -o @v",
            "colours.svg: would be overwritten",
        ),
        ("validate @secs --full-wave -o @secs", "numbers.json: would become one of the sections"),
        ("render @s.toml --frames 2 --size 8x8 --samples 1 -o @f.png", "f-0001.png: would be overwritten"),
        (
            "render starling --frames 2 --size 8x8 --samples 1 --background @f-0001.png -o @f.png",
            "f-0001.png: would be overwritten",
        ),
        ("feather @s.toml --level barbs -o @c.txt", "c.txt: would be overwritten"),
        ("feather @s.toml --level barbs -o @x.txt", "x.txt: would be overwritten"),
        ("bench render --curves @curves --write-curves @curves", "feather_barbs.txt: would be overwritten"),
        ("atlas @p/index.html -o @a.zarr --page @p", "index.html: would be overwritten"),
    ] {
        let (code, text) = run(at, line);
        assert!(code == 2 && text.contains(part) && text.lines().count() == 1, "{line}\n{text}");
        assert!(bytes_of(at) == before, "{line}");
    }
}

#[test]
fn what_a_command_wrote_it_writes_again() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_made_up();
    fs::write(at.join("s.toml"), CLOSE_UP).unwrap();
    let picture =
        format!("render @s.toml --material {MADE_UP} --size 8x8 --samples 1 --frames 2 --resume -o @f.png");
    let cached = "characterize air/keratin:300/air --wavelengths 450:650:100 --directions 2x2 --instances 2 --cache @c";
    for line in [&picture, cached, "film air/keratin:3/air --wavelengths 500 -o @t.svg --csv @t.csv"] {
        for _ in 0..2 {
            let (code, text) = run(at, line);
            assert!(code == 0, "{line}\n{text}");
            // A damaged file of the cache is read, and replaced.
            for entry in fs::read_dir(at.join("c")).into_iter().flatten() {
                fs::write(entry.unwrap().path(), "damaged").unwrap();
            }
        }
    }
}
