//! Work that several processes share out among them: the same bytes as one process writes, in any order, however often killed.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::{Value, json};

use crate::common::{CLOSE_UP, bytes_of, program, said_by, succeed_in};
use crate::validate::timeless;

/// A campaign of a second: 24 units, one of which takes some hundredths.
const CAMPAIGN: &[&str] = &["--wavelengths", "450:650:100", "--directions", "8x4", "--instances", "50"];

fn barbule(folder: &Path, words: &[&str]) -> Command {
    let mut command = program();
    command.current_dir(folder).args(words);
    command
}

fn run(folder: &Path, words: &[&str]) -> Output {
    barbule(folder, words).output().unwrap()
}

fn succeed(folder: &Path, words: &[&str]) -> String {
    succeed_in(folder, words).0
}

fn simulating<'a>(store: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["simulate", "starling", "-o", store], CAMPAIGN, more].concat()
}

/// What `--status --json` says of a store.
fn status(folder: &Path, store: &str, more: &[&str]) -> Value {
    let words = [&["simulate", store, "--status", "--json"], more].concat();
    serde_json::from_str(&succeed(folder, &words)).unwrap()
}

/// The states of a store's shards, in words.
fn states(status: &Value) -> Vec<&str> {
    let parts = status["shards"]["parts"].as_array().unwrap();
    parts.iter().map(|part| part["state"].as_str().unwrap()).collect()
}

#[test]
fn shards_in_any_order_are_one_campaign_and_their_state_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    succeed(at, &simulating("whole.zarr", &[]));
    let none = json!({"count": 0, "parts": [], "seconds_left": null, "to_start": []});
    succeed(at, &simulating("s.zarr", &["--shard", "4/5"]));
    assert_eq!(status(at, "s.zarr", &[])["shards"], none);
    let told = status(at, "s.zarr", &["--shards", "5"]);
    assert_eq!(states(&told), ["waiting", "waiting", "waiting", "waiting", "done"]);
    assert_eq!(told["shards"]["to_start"], json!([0, 1, 2, 3]));
    assert_eq!((&told["units"], &told["done"], &told["missing"]), (&json!(24), &json!(5), &json!(19)));
    for shard in ["1/5", "0/5", "3/5"] {
        succeed(at, &simulating("s.zarr", &["--shard", shard, "--threads", "1"]));
    }
    let text = succeed(at, &["simulate", "s.zarr", "--status", "--shards", "5"]);
    assert!(text.contains("19 of 24 units done, 5 missing, 0 damaged"), "{text}");
    assert!(text.contains("shard 2/5: 0 of 5 units, not running"), "{text}");
    assert!(text.contains("shard 4/5: 5 of 5 units, done"), "{text}");
    assert!(text.ends_with("to be started (again): 2\n"), "{text}");
    // One part alone, and another division of the same work.
    let text = succeed(at, &["simulate", "s.zarr", "--status", "--shard", "2/5"]);
    assert!(text.contains("shard 2/5") && !text.contains("shard 1/5"), "{text}");
    let halves = status(at, "s.zarr", &["--shards", "2"]);
    assert_eq!(states(&halves), ["waiting", "waiting"]);
    let repeated = run(at, &simulating("s.zarr", &["--shard", "0/5"]));
    assert!(
        repeated.status.success() && said_by(&repeated).contains("nothing to do"),
        "{}",
        said_by(&repeated)
    );
    succeed(at, &simulating("s.zarr", &["--shard", "2/5"]));
    assert_eq!(states(&status(at, "s.zarr", &["--shards", "5"])), ["done"; 5]);
    assert!(bytes_of(&at.join("s.zarr")) == bytes_of(&at.join("whole.zarr")));
}

#[cfg(unix)]
#[test]
fn a_shard_that_runs_is_seen_and_one_that_was_killed_is_repeated_to_the_same_bytes() {
    use std::process::Stdio;
    use std::time::{Duration, Instant};

    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    succeed(at, &simulating("whole.zarr", &[]));
    let start = |shard: &str| {
        let words = simulating("s.zarr", &["--threads", "1", "--quiet", "--shard", shard]);
        barbule(at, &words).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let mut child = start("1/3");
    let begun = Instant::now();
    let units =
        || std::fs::read_dir(at.join("s.zarr/digest")).map_or(0, |files| files.count().saturating_sub(1));
    while units() == 0 && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(1));
    }
    // Held where it is, so that what is told of it can be looked at.
    let signal =
        |name: &str| Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success();
    assert!(signal("-STOP"));
    let told = status(at, "s.zarr", &[]);
    assert_eq!(states(&told), ["waiting", "running", "waiting"], "{told}");
    let run_of_it = &told["running"][0];
    assert_eq!((&run_of_it["shard"], &run_of_it["shards"]), (&json!(1), &json!(3)));
    assert_eq!(run_of_it["process"], json!(child.id()));
    assert!(told["shards"]["parts"][1]["seconds_left"].is_number(), "{told}");
    assert_eq!(told["shards"]["to_start"], json!([0, 2]));
    let text = succeed(at, &["simulate", "s.zarr", "--status"]);
    assert!(text.contains("shard 1/3: ") && text.contains(", running for "), "{text}");
    assert!(text.contains("to be started (again): 0,2\n"), "{text}");
    child.kill().unwrap();
    child.wait().unwrap();
    let told = status(at, "s.zarr", &[]);
    assert_eq!(states(&told), ["waiting", "killed", "waiting"], "{told}");
    assert_eq!((&told["shards"]["to_start"], &told["running"]), (&json!([0, 1, 2]), &json!([])));
    // Two at once, then that one again.
    for child in [start("0/3"), start("2/3")] {
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", said_by(&output));
    }
    succeed(at, &simulating("s.zarr", &["--shard", "1/3"]));
    assert!(bytes_of(&at.join("s.zarr")) == bytes_of(&at.join("whole.zarr")));
}

/// Anyone who may write into a store may leave anything there.
#[cfg(unix)]
#[test]
fn traces_that_no_process_left_do_no_harm() {
    use std::os::unix::ffi::OsStrExt as _;

    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    succeed(at, &simulating("s.zarr", &["--shard", "0/3"]));
    let aside = at.join("s.zarr/.aside");
    std::fs::create_dir(&aside).unwrap();
    let names: [&[u8]; 7] = [
        b"run-1-3-1-1-of-another",
        b"run-2-3-99999999999-4-of-tomorrow",
        b"run-2-3-1700000000-5-two\nlines\x1b[31m",
        b"run-2-3-1700000000-5-\xff\xfe",
        b"run-0-0-1700000000-5-of-none",
        b"run-2-100001-1700000000-5-of-too-many",
        b"run-1-3-1700000000-6-huge",
    ];
    for name in names {
        let file = std::fs::File::create(aside.join(std::ffi::OsStr::from_bytes(name))).unwrap();
        file.set_len(if name.ends_with(b"huge") { 10 << 30 } else { 0 }).unwrap();
    }
    std::fs::write(at.join("kept"), b"kept").unwrap();
    std::os::unix::fs::symlink(at.join("kept"), aside.join("run-1-3-1700000000-7-link")).unwrap();
    assert!(Command::new("mkfifo").arg(aside.join("run-1-3-1700000000-8-pipe")).status().unwrap().success());
    let told = status(at, "s.zarr", &[]);
    assert_eq!(states(&told), ["done", "killed", "killed"], "{told}");
    assert_eq!((&told["running"], &told["shards"]["to_start"]), (&json!([]), &json!([1, 2])));
    let text = succeed(at, &["simulate", "s.zarr", "--status"]);
    assert!(text.ends_with("to be started (again): 1-2\n") && text.lines().count() == 5, "{text}");
    succeed(at, &simulating("s.zarr", &[]));
    assert_eq!(status(at, "s.zarr", &[])["missing"], json!(0));
    assert_eq!(std::fs::read(at.join("kept")).unwrap(), b"kept");
}

#[test]
fn values_that_share_nothing_out_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("s.toml"), CLOSE_UP).unwrap();
    for (words, expected) in [
        ("simulate starling -o s.zarr --shards 4", "--status"),
        ("simulate starling -o s.zarr --shard=-1/4", "write i/n with 0 <= i < n, as in 0/4"),
        ("simulate s.zarr --status --shards 0", "--shards 0: give the number of parts, from 1 to 100000"),
        ("simulate s.zarr --status --shards x", "--shards x: give the number of parts"),
        ("simulate s.zarr --status --shards 4 --shard 1/4", "cannot be used with"),
        ("characterize starling -o m.barbule --shard 0/2", "--keep-store"),
        ("validate starling --full-wave --quick -o v --shard 3/3", "write i/n with 0 <= i < n"),
        ("validate starling --three-d --quick -o v --shard 1", "write i/n with 0 <= i < n"),
        ("render s.toml -o f.png --frames 4 --shard 4/4", "write i/n with 0 <= i < n"),
        ("render s.toml -o f.png --shard 2/2", "write i/n with 0 <= i < n"),
        (
            "render s.toml -o f.png --time 5s --shard 0/2",
            "--time: parts of a picture end by --samples or --noise",
        ),
        ("render s.toml -o no/f.png --shard 0/2", "no"),
        ("render s.toml -o f.png --frames 4 --exposure auto --shard 0/2", "give a factor by --exposure"),
    ] {
        let output = run(folder.path(), &words.split(' ').collect::<Vec<_>>());
        let message = said_by(&output);
        assert_eq!(output.status.code(), Some(2), "{words}: {message}");
        assert!(message.contains(expected) && message.trim().len() < 600, "{words}: {message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn full_waves_of_several_processes_are_found_by_the_one_that_draws() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let words =
        "validate air/keratin:400±10%/air --full-wave --elements 5 --wavelengths 650 --phi 0 --ensemble 2 -o";
    let validate = |out: &str, more: &[&str]| -> (String, String) {
        let words = [&words.split(' ').collect::<Vec<_>>()[..], &[out], more].concat();
        let output = run(at, &words);
        assert!(output.status.success(), "{}", said_by(&output));
        (String::from_utf8_lossy(&output.stdout).into_owned(), said_by(&output))
    };
    let numbers = |out: &str| -> Value {
        serde_json::from_slice(&std::fs::read(at.join(out).join("numbers.json")).unwrap()).unwrap()
    };
    validate("alone", &[]);
    assert_eq!(validate("s", &["--status"]).0, "0 of 2 individuals' wavelengths done, 2 missing\n");
    assert!(validate("s", &["--shard", "1/2"]).1.contains("1 of 1 individuals' wavelengths of its part"));
    assert!(!at.join("s/numbers.json").exists());
    assert!(validate("s", &["--shard", "1/2"]).1.contains("nothing to do"));
    let told: Value = serde_json::from_str(&validate("s", &["--status", "--json"]).0).unwrap();
    assert_eq!(told, json!({"units": 2, "done": 1, "missing": 1}));
    assert_eq!(
        validate("s", &["--status", "--shard", "0/2"]).0,
        "0 of 1 individuals' wavelengths done, 1 missing\n"
    );
    validate("s", &["--shard", "0/2"]);
    assert!(validate("s", &[]).1.contains("2 of 2 individuals' wavelengths are there from before"));
    assert_eq!(timeless(numbers("s")), timeless(numbers("alone")));
}

#[test]
fn materials_and_halos_of_several_processes_are_those_of_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let words = "characterize air/keratin:300/air --halo --wavelengths 500,600 --directions 2x2 --instances 2 --cache c";
    let words: Vec<&str> = words.split(' ').collect();
    let characterize = |more: &[&str]| {
        let output = run(at, &[&words[..], more].concat());
        assert!(output.status.success(), "{}", said_by(&output));
        (String::from_utf8_lossy(&output.stdout).into_owned(), said_by(&output))
    };
    characterize(&["-o", "alone.barbule"]);
    std::fs::create_dir(at.join("stores")).unwrap();
    let part = |shard: &'static str| ["--keep-store", "stores", "--shard", shard];
    let (told, _) = characterize(&[&part("1/2")[..], &["--json"]].concat());
    let told: Value = serde_json::from_str(&told).unwrap();
    assert_eq!((&told["computed"], &told["found"]), (&json!(2), &json!(0)));
    let kept = || {
        let names = bytes_of(&at.join("stores")).into_keys();
        names.filter(|name| name.ends_with(".unit")).count()
    };
    // Of eight lights, shorter wavelengths take longer.
    assert_eq!(kept(), 5);
    let (_, message) = characterize(&[&part("0/2")[..], &["-o", "m.barbule"]].concat());
    assert!(message.contains("-o has no effect here: a part is simulated"), "{message}");
    assert!(kept() == 8 && !at.join("m.barbule").exists());
    let store = told["store"].as_str().unwrap();
    assert_eq!(states(&status(at, store, &["--shards", "2"])), ["done"; 2]);
    characterize(&["--keep-store", "stores", "-o", "m.barbule"]);
    assert!(std::fs::read(at.join("m.barbule")).unwrap() == std::fs::read(at.join("alone.barbule")).unwrap());
}

#[test]
fn frames_of_several_processes_are_the_pictures_of_one() {
    let folder = tempfile::tempdir().unwrap();
    let (alone, shared) = (folder.path().join("alone"), folder.path().join("shared"));
    let words = ["render", "s.toml", "-o", "f.png", "--frames", "3", "--size", "32x20", "--samples", "1"];
    for at in [&alone, &shared] {
        std::fs::create_dir(at).unwrap();
        std::fs::write(at.join("s.toml"), CLOSE_UP).unwrap();
    }
    succeed(&alone, &words);
    succeed(&shared, &[&words[..], &["--shard", "1/2"]].concat());
    let names: Vec<String> = bytes_of(&shared).into_keys().collect();
    assert_eq!(names, ["f-0001.png", "f-0002.png", "s.toml"]);
    succeed(&shared, &[&["render", "--shard=0/2"][..], &words[1..]].concat());
    assert!(bytes_of(&alone) == bytes_of(&shared));
}

/// Six tiles, at the right and lower edge not whole, exposed by what the picture shows.
const PICTURE: &[&str] = &["render", "s.toml", "--size", "90x60", "--exposure", "auto", "-o"];

fn drawing<'a>(picture: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [PICTURE, &[picture], more].concat()
}

/// The files of a folder that holds a scene, but for the scene.
fn pictures(folder: &Path) -> std::collections::BTreeMap<String, Vec<u8>> {
    let mut files = bytes_of(folder);
    files.remove("s.toml");
    files
}

#[test]
fn a_picture_in_parts_is_that_of_one_process() {
    let folder = tempfile::tempdir().unwrap();
    let (alone, shared) = (folder.path().join("alone"), folder.path().join("shared"));
    for at in [&alone, &shared] {
        std::fs::create_dir(at).unwrap();
        std::fs::write(at.join("s.toml"), CLOSE_UP).unwrap();
    }
    succeed(&alone, &drawing("f.png", &["--samples", "3", "--json"]));
    // The seventh of seven has no tile.
    for of in [1, 7] {
        for number in (0..of).rev() {
            let (shard, threads) = (format!("{number}/{of}"), (1 + number % 2).to_string());
            succeed(
                &shared,
                &drawing("f.png", &["--samples", "3", "--shard", &shard, "--threads", &threads]),
            );
        }
        assert_eq!(pictures(&shared).len(), of.min(6), "of {of}");
        let output = run(&shared, &drawing("f.png", &["--samples", "3", "--json"]));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(
            (&report[0]["paths"], &report[0]["exposure_by"]),
            (&json!(0), &json!("key")),
            "{}",
            said_by(&output)
        );
        let parts = if of == 1 {
            "1 part is joined\n".to_owned()
        } else {
            format!("{} parts are joined\n", of.min(6))
        };
        assert!(said_by(&output).contains(&parts), "{}", said_by(&output));
        assert!(pictures(&shared) == pictures(&alone), "of {of}");
        std::fs::remove_file(shared.join("f.png")).unwrap();
    }
    // All planes, with tiles of different counts; what is lacking is rendered by the one that joins.
    let planes = ["--spectral", "450,550,650", "--noise", "20", "--samples", "24"];
    succeed(&alone, &drawing("f.exr", &planes));
    succeed(&shared, &drawing("f.exr", &[&planes[..], &["--shard=2/3"]].concat()));
    succeed(&shared, &drawing("f.exr", &[&["--shard", "0/2"], &planes[..]].concat()));
    let output = run(&shared, &drawing("f.exr", &planes));
    assert!(
        said_by(&output).contains("2 parts are joined; what they lack is rendered here"),
        "{}",
        said_by(&output)
    );
    let mut expected = pictures(&alone);
    expected.remove("f.png");
    assert!(pictures(&shared) == expected && expected.len() == 1);
}

#[test]
fn parts_that_were_killed_damaged_or_of_another_picture_are_rendered_anew() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("s.toml"), CLOSE_UP).unwrap();
    let long = ["--samples", "8"];
    let mut child =
        barbule(at, &drawing("f.png", &["--shard", "1/2", "--quiet", "--samples", "8"])).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(250));
    child.kill().unwrap();
    child.wait().unwrap();
    succeed(at, &drawing("f.png", &long));
    let whole = pictures(at);
    std::fs::remove_file(at.join("f.png")).unwrap();
    let part = |shard: &str, more: &[&str]| {
        said_by(&run(at, &drawing("f.png", &[&["--shard", shard], &long[..], more].concat())))
    };
    part("1/2", &[]);
    let kept = at.join("f.png.part-1-of-2");
    let good = std::fs::read(&kept).unwrap();
    let message = part("1/2", &["--resume"]);
    assert!(message.contains("part 1/2 is done, there is nothing to do"), "{message}");
    assert!(message.contains("--resume has no effect here"), "{message}");
    let mut damaged = good.clone();
    damaged[good.len() / 2] ^= 1;
    for (bytes, word) in [
        (&damaged[..], "its checksum differs"),
        (&good[..99], "checksum"),
        (b"x", "is not one of this program"),
    ] {
        std::fs::write(&kept, bytes).unwrap();
        let message = part("1/2", &[]);
        assert!(message.contains(word) && message.contains("; it is rendered anew"), "{message}");
        assert!(std::fs::read(&kept).unwrap() == good);
    }
    // Another light, and other samples: not of this picture, neither for its part nor for who joins.
    let message = part("1/2", &["--light=1,50"]);
    assert!(message.contains("another picture") && std::fs::read(&kept).unwrap() != good, "{message}");
    part("0/2", &[]);
    let message = said_by(&run(at, &drawing("f.png", &long)));
    assert!(message.contains("f.png.part-1-of-2: ") && message.contains("; it is not joined"), "{message}");
    assert!(message.contains("1 part is joined; what it lacks is rendered here"), "{message}");
    // What is of another picture is not this one's to delete.
    let mut found = pictures(at);
    assert!(found.remove("f.png.part-1-of-2").is_some() && found == whole);
}

/// The scripts of `examples/cluster`, with schedulers that run every task here.
#[cfg(unix)]
mod scripts {
    use std::path::PathBuf;

    use super::*;

    /// Runs the tasks of an array, the last first.
    const SBATCH: &str = r#"#!/bin/sh
set -eu
range=${1#--array=}
shift
task=${range#*-}
while [ "$task" -ge "${range%-*}" ]; do
    SLURM_ARRAY_TASK_ID=$task SLURM_CPUS_PER_TASK=1 SLURM_MEM_PER_NODE=2048 sh "$@"
    task=$((task - 1))
done
"#;

    /// `qsub -J FIRST-LAST -v NAME=VALUE,… SCRIPT`, which runs somewhere else than where it was submitted.
    const QSUB: &str = r#"#!/bin/sh
set -eu
range=$2
IFS=,
for pair in $4; do export "${pair?}"; done
unset IFS
PBS_O_WORKDIR=$PWD
export PBS_O_WORKDIR
cd /
task=${range%-*}
while [ "$task" -le "${range#*-}" ]; do
    PBS_ARRAY_INDEX=$task NCPUS=1 sh "$5"
    task=$((task + 1))
done
"#;

    fn script(name: &str) -> PathBuf {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/cluster");
        folder.join(name).canonicalize().unwrap()
    }

    fn all() -> Vec<PathBuf> {
        ["local-array.sh", "pbs-array.sh", "slurm-array.sh"].map(script).to_vec()
    }

    /// A command of the shell, with the program and the schedulers where it looks for programs.
    fn shell(at: &Path, line: &str, script: &Path) -> Output {
        let program = PathBuf::from(program().get_program());
        let own = [at.join("bin"), program.parent().unwrap().to_owned()];
        let others = std::env::var_os("PATH").unwrap();
        let path = own.into_iter().chain(std::env::split_paths(&others));
        Command::new("sh")
            .args(["-c", line, "sh"])
            .arg(script)
            .current_dir(at)
            .env("PATH", std::env::join_paths(path).unwrap())
            .env("SIMD", barbule::math::simd::Width::best().name())
            .output()
            .unwrap()
    }

    fn write_program(path: &Path, text: &str) {
        use std::os::unix::fs::PermissionsExt as _;
        std::fs::write(path, text).unwrap();
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755)).unwrap();
    }

    #[test]
    fn shells_can_read_them_and_a_checker_finds_nothing() {
        for script in all() {
            assert!(Command::new("sh").arg("-n").arg(&script).status().unwrap().success());
            match Command::new("shellcheck").arg(&script).output() {
                Ok(output) => assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout)),
                Err(_) => {
                    use std::io::Write as _;
                    let _ = writeln!(std::io::stderr(), "skipped: no shellcheck is installed");
                }
            }
        }
    }

    /// Arrays begin at 0, and as many tasks as stand in a script are its parts.
    #[test]
    fn their_directives_are_as_many_tasks_as_they_have_parts() {
        for (name, directive) in
            [("slurm-array.sh", "#SBATCH --array=0-15\n"), ("pbs-array.sh", "#PBS -J 0-15\n")]
        {
            let text = std::fs::read_to_string(script(name)).unwrap();
            assert!(text.contains(directive) && text.contains("${SHARDS:-16}"), "{name}");
        }
    }

    #[test]
    fn each_fills_the_store_that_one_process_fills() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        std::fs::create_dir(at.join("bin")).unwrap();
        write_program(&at.join("bin/sbatch"), SBATCH);
        write_program(&at.join("bin/qsub"), QSUB);
        let flags = "--wavelengths 450:650:100 --directions 3x2 --instances 3";
        let words: Vec<&str> = flags.split(' ').collect();
        succeed(at, &[&["simulate", "starling", "-o", "whole.zarr"], &words[..]].concat());
        let whole = bytes_of(&at.join("whole.zarr"));
        let lines = [
            ("slurm-array.sh", format!("SHARDS=4 sbatch --array=0-3 \"$1\" s.zarr starling {flags}")),
            (
                "pbs-array.sh",
                format!("qsub -J 0-3 -v 'SHARDS=4,STORE=s.zarr,STRUCTURE=starling,FLAGS={flags}' \"$1\""),
            ),
            ("local-array.sh", format!("SHARDS=4 AT_ONCE=3 sh \"$1\" s.zarr starling {flags}")),
        ];
        for (name, line) in lines {
            // A second time there is nothing to do.
            for _ in 0..2 {
                let output = shell(at, &line, &script(name));
                assert!(output.status.success(), "{name}: {}", said_by(&output));
                assert!(bytes_of(&at.join("s.zarr")) == whole, "{name}");
            }
            std::fs::remove_dir_all(at.join("s.zarr")).unwrap();
        }
        // Single tasks again, and what is left out is told.
        let line = format!("SHARDS=4 sbatch --array=1-2 \"$1\" s.zarr starling {flags}");
        assert!(shell(at, &line, &script("slurm-array.sh")).status.success());
        assert_eq!(status(at, "s.zarr", &["--shards", "4"])["shards"]["to_start"], json!([0, 3]));
    }

    #[test]
    fn what_is_forgotten_is_said() {
        let folder = tempfile::tempdir().unwrap();
        for (name, line, expected) in [
            ("slurm-array.sh", "sh \"$1\" s.zarr", "usage: sbatch"),
            ("slurm-array.sh", "sh \"$1\" s.zarr starling", "with sbatch --array=0-15"),
            ("pbs-array.sh", "sh \"$1\"", "with qsub -J 0-15"),
            ("pbs-array.sh", "PBS_ARRAY_INDEX=0 sh \"$1\"", "-v STRUCTURE="),
            ("local-array.sh", "sh \"$1\"", "usage: SHARDS=n"),
            ("local-array.sh", "SHARDS=x sh \"$1\" s.zarr starling", "give whole numbers"),
            ("local-array.sh", "AT_ONCE=0 sh \"$1\" s.zarr starling", "give numbers from 1 on"),
        ] {
            let output = shell(folder.path(), line, &script(name));
            assert!(!output.status.success(), "{name} {line}: {}", said_by(&output));
            assert!(said_by(&output).contains(expected), "{name} {line}: {}", said_by(&output));
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
