//! What outputs may be called, what becomes of what is there, and what they leave when they fail.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::common::{MADE_UP, bytes_of, program, said_by, write_made_up};

fn barbule(folder: &Path) -> Command {
    let mut command = program();
    command.current_dir(folder).stdin(Stdio::null());
    command
}

fn run(folder: &Path, line: &str) -> Output {
    barbule(folder).args(line.split_whitespace()).output().unwrap()
}

fn is_one_sentence(message: &str) -> bool {
    message.starts_with("barbule: ") && message.trim_end().lines().count() == 1 && message.len() < 600
}

/// A second's film.
const FILM: &str = "film air/keratin:300/air --wavelengths 500,600";

const SECTION: &str = r#"{"barbule": 1, "units": "um", "width": 2.0, "name": "a", "materials": {"chitin": "n.csv"},
 "boundaries": [{"x": [-1, 0, 1], "z": [0, 0, 0]}], "media": ["air", "chitin"]}"#;

/// Inputs of every kind, also under second names.
fn inputs(folder: &Path) {
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
    for name in ["sub", "secs"] {
        fs::create_dir(folder.join(name)).unwrap();
    }
    for name in ["in.json", "s.csv.json"] {
        write(name, SECTION);
    }
    write("secs/a.json", &SECTION.replace("n.csv", "../n.csv"));
    write("n.csv", "300,1.5,0\n830,1.5,0\n");
    write("m.csv", "400,0.1\n700,0.2\n");
    write("stack.toml", "stack = 'air/chitin:300/air'\n[materials]\nchitin = 'n.csv'\n");
    write("scene.toml", "preset = 'starling'\nmaterial = 'made.barbule'\n[sky_image]\nfile = 'sky.exr'\n");
    for name in ["sky.exr", "made.barbule", "fig.svg"] {
        write(name, "never looked at");
    }
    let mut species = Vec::new();
    barbule_cli::run(["barbule", "species", "starling", "--toml"], &mut species, &mut Vec::new());
    fs::write(folder.join("mine.toml"), species).unwrap();
    fs::hard_link(folder.join("in.json"), folder.join("hard.json")).unwrap();
    fs::hard_link(folder.join("fig.svg"), folder.join("fig.csv")).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink("in.json", folder.join("soft.json")).unwrap();
    let axes = barbule::scattering::statistics::Axes::new(
        &barbule::spectrum::Wavelengths::new([450.0]).unwrap(),
        vec![1.0],
        vec![1.0],
    );
    let store = folder.join("s.zarr");
    barbule::io::store::Store::create(&store, &axes.unwrap(), 2, "x", &serde_json::json!({}), &[], "scalar")
        .unwrap();
}

#[test]
fn an_output_that_is_read_too_is_refused_under_every_name_and_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    inputs(folder.path());
    let mut lines = vec![
        ("characterize in.json -o in.json", "this command reads it"),
        ("geometry in.json -o ./in.json", "this command reads it"),
        ("geometry in.json -o sub/../in.json", "this command reads it"),
        ("geometry in.json -o hard.json", "this command reads it (as in.json)"),
        ("spectrum in.json --measured m.csv --csv m.csv", "--csv m.csv: would be overwritten"),
        ("spectrum in.json --measured m.csv@30 --csv m.csv", "--csv m.csv: would be overwritten"),
        ("spectrum in.json --csv n.csv", "this command reads it (as n.csv)"),
        ("film air/q:300/air --medium q=n.csv --csv sub/../n.csv", "this command reads it (as n.csv)"),
        ("film stack.toml --csv n.csv", "this command reads it (as n.csv)"),
        (
            "spectrum s.csv.json --csv s.csv",
            "s.csv.json (the notes beside --csv s.csv): would be overwritten",
        ),
        ("spectrum secs --csv n.csv", "this command reads it"),
        ("geometry secs -o secs/a.json", "would become one of the sections in secs"),
        ("geometry secs/ -o secs/new.json", "would become one of the sections in secs"),
        ("spectrum secs --csv secs/new.csv", "would become one of the sections in secs"),
        ("characterize mine.toml:green -o mine.toml", "this command reads it (as mine.toml)"),
        ("render scene.toml -o sky.exr", "this command reads it (as sky.exr)"),
        ("characterize scene.toml -o made.barbule", "this command reads it (as made.barbule)"),
        ("fit s.zarr -o s.zarr/zarr.json", "lies inside a campaign store"),
        ("fit s.zarr -o s.zarr/u/new.barbule", "lies inside a campaign store"),
        ("simulate starling -o s.zarr/inner.zarr", "lies inside a campaign store"),
        ("film air/keratin:5/air -o fig.svg --csv fig.csv", "is the same file as -o fig.svg; give two names"),
        ("film air/keratin:5/air -o new.svg --csv sub/../new.svg", "give two names"),
        ("film air/keratin:5/air --csv new.svg", "tables are written as CSV"),
        ("film air/keratin:5/air --csv -", "--csv -: name a file"),
        ("film air/keratin:5/air --csv x.xlsx", "tables are written as CSV"),
        ("spectrum starling --csv x.ODS", "end the name with .csv"),
        ("fit s.zarr -o -", "outputs are files and have names"),
    ];
    if cfg!(unix) {
        lines.push(("geometry in.json -o soft.json", "this command reads it (as in.json)"));
    }
    let before = bytes_of(folder.path());
    for (line, part) in lines {
        let output = run(folder.path(), line);
        let text = said_by(&output);
        assert!(text.contains(part) && is_one_sentence(&text), "{line}\n{part}\n{text}");
        assert_eq!(output.status.code(), Some(2), "{line}");
        assert!(output.stdout.is_empty() && bytes_of(folder.path()) == before, "{line}");
    }
    // What is only called alike is no input.
    for line in
        ["geometry in.json -o out.json", "geometry in.json -o out.json", "geometry in.json -o secs/b.json"]
    {
        let output = run(folder.path(), line);
        assert!(output.status.success(), "{line}: {}", said_by(&output));
    }
    fs::write(folder.path().join("starling"), "").unwrap();
    assert!(run(folder.path(), "geometry starling -o starling.json").status.success());
}

#[test]
fn tables_go_through_pipes_and_devices_and_leave_nothing_beside_them() {
    let folder = tempfile::tempdir().unwrap();
    if !cfg!(target_os = "linux") {
        return;
    }
    let printed = run(folder.path(), &format!("{FILM} --csv /dev/stdout"));
    assert!(printed.status.success(), "{}", said_by(&printed));
    let table = String::from_utf8(printed.stdout).unwrap();
    assert!(table.starts_with("angle_deg,wavelength_nm") && table.lines().count() == 3, "{table}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    assert!(!Path::new("/dev/stdout.json").exists());
    // Into a file of the shell's, behind what is there; a shell's own pipe; nowhere.
    let shell = |script: &str| {
        let script = script
            .replace("FILM", &format!("{} {FILM}", barbule(folder.path()).get_program().to_string_lossy()));
        Command::new("bash").args(["-c", &script]).current_dir(folder.path()).output().unwrap()
    };
    let output = shell(
        "echo first > t.csv && FILM --csv /dev/stdout >> t.csv && FILM --csv >(cat > u.csv) && sleep 0.3",
    );
    assert!(output.status.success(), "{}", said_by(&output));
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(read("t.csv"), format!("first\n{table}"));
    assert_eq!(read("u.csv"), table);
    std::os::unix::fs::symlink("/dev/null", folder.path().join("null.csv")).unwrap();
    assert!(run(folder.path(), &format!("{FILM} --csv null.csv")).status.success());
    assert!(fs::symlink_metadata(folder.path().join("null.csv")).unwrap().is_symlink());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3);
}

#[cfg(unix)]
#[test]
fn what_is_there_keeps_its_permissions_and_is_refused_where_it_is_write_protected() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.csv");
    let mode = || fs::metadata(&path).unwrap().permissions().mode() & 0o777;
    fs::write(&path, "old").unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
    assert!(run(folder.path(), &format!("{FILM} --csv t.csv")).status.success());
    assert_eq!(mode(), 0o600);
    let table = fs::read(&path).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
    // Also where it is the notes that cannot be replaced: then the table stays too.
    for (protected, open) in [("t.csv", "t.csv.json"), ("t.csv.json", "t.csv")] {
        let set = |name: &str, mode: u32| {
            fs::set_permissions(folder.path().join(name), fs::Permissions::from_mode(mode)).unwrap();
        };
        set(protected, 0o444);
        set(open, 0o644);
        let output = run(folder.path(), "film air/keratin:999/air --wavelengths 500 --csv t.csv");
        assert_eq!(output.status.code(), Some(2));
        assert!(said_by(&output).contains("is write-protected; give another name"), "{}", said_by(&output));
        assert!(fs::read(&path).unwrap() == table, "{protected}");
    }
}

#[test]
fn what_killed_runs_left_beside_an_output_is_gone_after_the_next() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(".barbule-0123456789ab.part"), "half a table").unwrap();
    assert!(run(folder.path(), &format!("{FILM} --csv t.csv")).status.success());
    let mut names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["t.csv", "t.csv.json"]);
}

#[test]
fn exit_codes_say_whose_turn_it_is() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("folder.csv")).unwrap();
    let mut lines = vec![
        ("--help".to_owned(), 0),
        ("film --help".into(), 0),
        ("--version".into(), 0),
        (FILM.into(), 0),
        (format!("{FILM} --csv t.csv"), 0),
        // What the user can mend: arguments, names, ranges, files that are missing, folders, unreadable, of another kind.
        (String::new(), 2),
        ("flim".into(), 2),
        ("film air/keratine:3/air".into(), 2),
        (format!("{FILM} --threads 0"), 2),
        ("geometry none.json -o f.svg".into(), 2),
        (format!("{FILM} --csv folder.csv"), 2),
        (format!("{FILM} --csv no/t.csv"), 2),
        (format!("{FILM} --medium q=folder.csv"), 2),
        ("lobes t.csv -o f.svg".into(), 2),
    ];
    if cfg!(target_os = "linux") {
        // Failures of the machine.
        lines.push((format!("{FILM} --csv /dev/full"), 1));
    }
    for (line, code) in &lines {
        let output = run(folder.path(), line);
        assert_eq!(output.status.code(), Some(*code), "{line}: {}", said_by(&output));
    }
    #[cfg(target_os = "linux")]
    for line in ["--help", "film --help", "--version", FILM, "species"] {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let output = barbule(folder.path()).args(line.split_whitespace()).stdout(full).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{line}");
        assert!(said_by(&output).contains("standard output cannot be written"), "{}", said_by(&output));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn names_that_are_no_unicode_are_written_and_said() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;
    let folder = tempfile::tempdir().unwrap();
    let name = OsStr::from_bytes;
    let succeed = |command: &mut Command| {
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", said_by(&output));
        serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap()
    };
    write_made_up();
    let picture =
        ["render", "starling", "--material", MADE_UP, "--size", "8x8", "--samples", "1", "--json", "-o"];
    let report = succeed(barbule(folder.path()).args(picture).arg(name(b"\xff.png")));
    assert_eq!(report[0]["output"], "\u{fffd}.png");
    let small =
        "characterize air/keratin:300/air --wavelengths 450:650:100 --directions 2x2 --instances 2 --json -o";
    let report = succeed(barbule(folder.path()).args(small.split(' ')).arg(name(b"m\xff.barbule")));
    assert_eq!(report["material"], "m\u{fffd}.barbule");
    assert!(folder.path().join(name(b"m\xff.barbule")).is_file());
    let cache = folder.path().join(name(b"c\xff"));
    fs::create_dir(&cache).unwrap();
    fs::write(cache.join(name(b"\xfe.barbule")), "x").unwrap();
    let report = succeed(barbule(folder.path()).args(["cache", "--json", "--cache"]).arg(&cache));
    assert!(report.to_string().contains("c\u{fffd}"), "{report}");
    succeed(barbule(folder.path()).args(["cache", "--json"]).env("XDG_CACHE_HOME", &cache));
}

/// The program under a limit of address space, kB.
#[cfg(target_os = "linux")]
fn limited(folder: &Path, limit: u32, line: &str) -> Output {
    let program = barbule(folder).get_program().to_string_lossy().into_owned();
    let script = format!("ulimit -v {limit}; exec {program} {line}");
    let mut command = Command::new("sh");
    if line.contains("--threads 20") {
        // Stacks are what fails first.
        command.env("RUST_MIN_STACK", "400000000");
    }
    command.args(["-c", &script]).current_dir(folder).output().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn threads_that_cannot_start_and_memory_that_is_not_there_end_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let output = limited(folder.path(), 900_000, "film air/keratin:3/air --threads 20");
    assert_eq!(output.status.code(), Some(2), "{}", said_by(&output));
    assert!(said_by(&output).contains("--threads 20: cannot be started"), "{}", said_by(&output));
    assert!(is_one_sentence(&said_by(&output)));
    let sweep = "film air/keratin:3/air --threads 1 --wavelengths 300:830:0.2 --angles 0:80:0.2 --csv t.csv";
    let output = limited(folder.path(), 300_000, sweep);
    assert_eq!(output.status.code(), Some(1), "{}", said_by(&output));
    assert!(said_by(&output).contains("the system has no more memory"), "{}", said_by(&output));
    assert!(is_one_sentence(&said_by(&output)));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}
