//! Atlases as people and scripts make them.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::common::{Ends as _, bytes_of, program, succeed_in};
use serde_json::Value;

/// Two layers over each other, 12 structures in 8 units.
const PLAN: &str = "barbule = 1
name = 'films'
structure = 'starling'
wavelengths_nm = '400:700:20'
individuals = 3
unit_cells = 2

[[vary]]
key = 'cortex_um'
values = '0.25:0.40:0.05'

[[vary]]
key = 'melanosome_diameter_um'
values = { low = 0.2, high = 0.3, count = 3 }
";

fn command(folder: &Path, words: &[&str]) -> Command {
    let mut command = program();
    command.current_dir(folder).arg("atlas").args(words).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn succeed(folder: &Path, words: &[&str]) -> (String, String) {
    command(folder, words).succeeds()
}

fn with_plan() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("plan.toml"), PLAN).unwrap();
    folder
}

#[test]
fn parts_in_any_order_and_killed_runs_give_the_bytes_of_one_process() {
    let folder = with_plan();
    let at = folder.path();
    succeed(at, &["plan.toml", "-o", "whole.zarr", "--threads", "2"]);
    let whole = bytes_of(&at.join("whole.zarr"));
    for part in ["2/3", "0/3", "1/3"] {
        succeed(at, &["plan.toml", "-o", "parts.zarr", "--shard", part, "--threads", "1"]);
    }
    assert!(bytes_of(&at.join("parts.zarr")) == whole);
    for repetition in 0..2 {
        let name = format!("killed-{repetition}.zarr");
        for wait in [60, 150 + 200 * repetition] {
            let mut child = command(at, &["plan.toml", "-o", &name]).spawn().unwrap();
            std::thread::sleep(Duration::from_millis(wait));
            child.kill().unwrap();
            child.wait().unwrap();
        }
        let (_, message) = succeed(at, &["plan.toml", "-o", &name]);
        assert!(!message.contains("damaged"), "{message}");
        assert!(bytes_of(&at.join(&name)) == whole, "{name}");
    }
    let (_, message) = succeed(at, &["plan.toml", "-o", "whole.zarr"]);
    assert!(message.contains("nothing to do"), "{message}");
    // Nothing lies about.
    assert_eq!(std::fs::read_dir(at).unwrap().count(), 1 + 2 + 2);
}

#[test]
fn a_status_foretells_then_counts() {
    let folder = with_plan();
    let at = folder.path();
    let read = |words: &[&str]| serde_json::from_str::<Value>(&succeed(at, words).0).unwrap();
    let before = read(&["plan.toml", "--status", "--json"]);
    assert_eq!(
        (&before["structures"], &before["units"], &before["done"]),
        (&12.into(), &8.into(), &0.into())
    );
    assert!(before["seconds_left"].as_f64().unwrap() > 0.0 && before["memory_bytes"].as_u64().unwrap() > 0);
    assert_eq!(std::fs::read_dir(at).unwrap().count(), 1);
    let part = read(&["plan.toml", "-o", "s.zarr", "--shard", "1/4", "--json"]);
    assert_eq!((&part["computed"], part["unit_seconds"].as_array().unwrap().len()), (&2.into(), 2));
    let (text, _) = succeed(at, &["plan.toml", "-o", "s.zarr", "--status"]);
    assert!(
        text.starts_with("films: 2 of 8 units done, 6 missing, 0 damaged; ") && text.contains("left"),
        "{text}"
    );
    succeed(at, &["plan.toml", "-o", "s.zarr"]);
    let after = read(&["plan.toml", "-o", "s.zarr", "--status", "--json"]);
    assert_eq!((&after["done"], &after["seconds_left"]), (&8.into(), &0.0.into()));
    assert_eq!(bytes_of(&at.join("s.zarr")).len() as u64, before["files"].as_u64().unwrap());
}

#[cfg(unix)]
#[test]
fn a_part_that_runs_is_seen_and_one_that_was_killed_is_named() {
    let folder = with_plan();
    let at = folder.path();
    let slow = PLAN.replace("individuals = 3", "individuals = 60");
    std::fs::write(at.join("plan.toml"), slow).unwrap();
    let read = |more: &[&str]| -> Value {
        let words = [&["plan.toml", "-o", "s.zarr", "--status", "--json"], more].concat();
        serde_json::from_str(&succeed(at, &words).0).unwrap()
    };
    let states = |told: &Value| -> Vec<String> {
        let parts = told["shards"]["parts"].as_array().unwrap();
        parts.iter().map(|part| part["state"].as_str().unwrap().to_owned()).collect()
    };
    let mut child =
        command(at, &["plan.toml", "-o", "s.zarr", "--shard", "1/2", "--threads", "1"]).spawn().unwrap();
    let begun = std::time::Instant::now();
    let times = || std::fs::read_dir(at.join("s.zarr/.times")).map_or(0, Iterator::count);
    while times() == 0 && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(1));
    }
    // Held where it is, so that what is told of it can be looked at.
    assert!(Command::new("kill").args(["-STOP", &child.id().to_string()]).status().unwrap().success());
    let told = read(&[]);
    assert_eq!(states(&told), ["waiting", "running"], "{told}");
    assert_eq!(told["running"][0]["process"], child.id());
    let (text, _) = succeed(at, &["plan.toml", "-o", "s.zarr", "--status"]);
    assert!(text.contains("shard 1/2: ") && text.contains("to be started (again): 0\n"), "{text}");
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(states(&read(&[])), ["waiting", "killed"]);
    succeed(at, &["plan.toml", "-o", "s.zarr", "--shard", "1/2"]);
    // Units are dealt out in turn.
    assert_eq!(states(&read(&["--shards", "2"])), ["waiting", "done"]);
    assert_eq!(read(&["--shards", "4"])["shards"]["to_start"], serde_json::json!([0, 2]));
    assert_eq!(states(&read(&["--shard", "3/4"])), ["done"]);
}

#[test]
fn a_page_and_a_picture_stand_where_they_were_asked_for() {
    let folder = with_plan();
    let at = folder.path();
    succeed(at, &["plan.toml", "-o", "s.zarr", "--page", "page", "--picture", "map.png"]);
    let page = bytes_of(&at.join("page"));
    assert_eq!(page.len(), 2 + 12);
    succeed(at, &["plan.toml", "-o", "s.zarr", "--page", "page"]);
    let text = String::from_utf8(page["index.html"].clone()).unwrap();
    assert!(text.contains("12 of 12 structures") && text.contains("cortex (µm)"), "{text}");
    assert!(at.join("map.png").is_file());
    // What a page links to simulates.
    succeed_in(at, &["spectrum", "page/structures/000011.toml", "--instances", "1", "--json"]);
}

#[test]
fn plans_that_cannot_be_are_refused_and_leave_nothing() {
    let folder = with_plan();
    let at = folder.path();
    for (from, to, part) in [
        ("key = 'cortex_um'", "key = 'cortx_um'", "did you mean 'cortex_um'?"),
        ("'0.25:0.40:0.05'", "'0.25:400:0.5'", "cortex_um is 10.25, outside 0.001 to 10"),
        ("'0.25:0.40:0.05'", "'0.25:0.40'", "which says no values; give a step"),
        ("structure = 'starling'", "structure = 'starlign'", "did you mean 'starling'?"),
        ("structure = 'starling'", "structure = 'nowhere.toml'", "no such file"),
        ("'400:700:20'", "'200:700:20'", "200 nm is outside 300 to 830 nm"),
        ("individuals = 3", "birds = ['starling']", "birds see from 300 nm"),
        ("individuals = 3", "angles_deg = [95]", "give angles between -90 and 90"),
        ("individuals = 3", "angles_deg = '0:80:0.01'", "angles_deg has 8001 values, over 1000"),
        ("name = 'films'", "name = ''", "name must be 1 to 120 letters"),
        ("barbule = 1", "", "barbule is missing"),
        ("unit_cells = 2", "unit_cels = 2", "did you mean 'unit_cells'?"),
    ] {
        std::fs::write(at.join("bad.toml"), PLAN.replace(from, to)).unwrap();
        let (code, _, message) = command(at, &["bad.toml", "-o", "s.zarr"]).ran();
        assert_eq!(code, 2, "{message}");
        assert!(
            message.contains(part) && message.lines().count() == 1 && message.contains("bad.toml"),
            "{message}"
        );
        assert!(!at.join("s.zarr").exists(), "{message}");
    }
    succeed(at, &["plan.toml", "-o", "s.zarr"]);
    std::fs::create_dir(at.join("taken")).unwrap();
    std::fs::write(at.join("taken/index.html"), "<!doctype html>mine").unwrap();
    std::fs::write(at.join("other.toml"), PLAN.replace("individuals = 3", "individuals = 4")).unwrap();
    let (_, _, message) = command(at, &["other.toml", "-o", "s.zarr"]).ran();
    assert!(message.contains("made by another plan (sweep.plan.individuals: 3 there, 4 here)"), "{message}");
    std::fs::write(at.join("uv.toml"), PLAN.replace("'400:700:20'", "'300:380:20'")).unwrap();
    for (words, part) in [
        (&["uv.toml", "-o", "t.zarr", "--page", "uv"][..], "the atlas has no colours"),
        (&["uv.toml", "-o", "t.zarr", "--picture", "uv.png"], "the atlas has no colours"),
        (&["plan.toml", "-o", "s.zarr/inner.zarr"], "inside a campaign store"),
        (&["plan.toml", "-o", "s.zarr", "--page", "s.zarr"], "--page: s.zarr: lies inside a campaign store"),
        (&["plan.toml", "-o", "s.zarr", "--page", "plan.toml"], "is a file; give a folder"),
        (
            &["plan.toml", "-o", "s.zarr", "--page", "taken"],
            "that is not the page of an atlas; give another folder",
        ),
        (&["plan.toml", "-o", "s.zarr", "--picture", "map.txt"], "figures are written as .svg, .pdf or .png"),
        (&["plan.toml"], "--output"),
        (&["plan.toml", "-o", "t.zarr", "--shard", "4/4"], "write i/n with 0 <= i < n"),
    ] {
        let (code, _, message) = command(at, words).ran();
        assert!(code == 2 && message.contains(part), "{words:?}: {message}");
    }
}
