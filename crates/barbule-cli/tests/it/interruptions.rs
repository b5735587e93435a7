//! What Ctrl-C does while a command works, and what is said.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{MADE_UP, program, write_made_up};

/// A picture of minutes.
fn rendering(output: &str, more: &[&str]) -> Child {
    write_made_up();
    let mut command = program();
    command.args(["render", "starling", "--material", MADE_UP, "--size", "64x48", "--samples", "1000000"]);
    command.args(["-v", "-o", output]).args(more).stderr(Stdio::piped()).stdout(Stdio::null());
    command.spawn().unwrap()
}

fn interrupt(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}

/// Lines on standard error until one contains `part`.
fn read_until(lines: &mut impl BufRead, part: &str) -> String {
    let mut text = String::new();
    while lines.read_line(&mut text).unwrap() > 0 {
        if text.contains(part) {
            return text;
        }
    }
    panic!("no '{part}' in {text}")
}

#[test]
fn two_signals_at_once_are_one_press_and_the_picture_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("x.png");
    let mut child = rendering(output.to_str().unwrap(), &[]);
    let mut lines = BufReader::new(child.stderr.take().unwrap());
    read_until(&mut lines, "view ");
    // Time for the first round.
    std::thread::sleep(Duration::from_millis(1500));
    interrupt(&child);
    interrupt(&child);
    let mut said = String::new();
    lines.read_to_string(&mut said).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{said}");
    assert!(said.contains("writing what is done … Ctrl-C again to discard it"), "{said}");
    assert!(said.contains("barbule: interrupted: ") && said.contains("of 1000000 samples done; "), "{said}");
    assert!(said.contains("x.png shows what is done") && said.contains("--resume"), "{said}");
    assert!(std::fs::read(&output).unwrap().starts_with(b"\x89PNG"));
}

/// Within one wavelength of a slow solver, too: a row of its 90 angles takes half a minute.
#[test]
fn a_slow_solver_stops_between_two_angles() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("map.png");
    let mut command = program();
    command.args(["crystal", "peafowl", "--map", "--solver", "rcwa", "--wavelengths", "400,500", "-o"]);
    let mut child = command.arg(&output).stderr(Stdio::null()).stdout(Stdio::null()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(1500));
    let asked = Instant::now();
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    // Two seconds are promised on a machine of its own; tests share theirs.
    assert!(asked.elapsed() < Duration::from_secs(10), "{:?}", asked.elapsed());
    assert!(!output.exists());
}

#[test]
fn a_command_that_keeps_nothing_says_that_it_stops_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("map.png");
    let mut command = program();
    command.args(["crystal", "peafowl", "--map", "--wavelengths", "300:830:0.1", "-o"]).arg(&output);
    let mut child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(1500));
    interrupt(&child);
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(said, "stopping … Ctrl-C again to end at once\nbarbule: interrupted\n");
    assert!(!output.exists());
}

/// Each wavelength of full waves is kept as it comes.
#[test]
fn a_comparison_with_full_waves_goes_on_after_ctrl_c() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out");
    let line = |z: f64| serde_json::json!({"x": [-2.0, 0.0, 2.0], "z": [z, z, z]});
    let section = serde_json::json!({
        "barbule": 1, "units": "um", "width": 4.0, "name": "a film",
        "boundaries": [line(0.0), line(-0.5)], "media": ["air", "keratin", "air"], "source": "a test"
    });
    let film = folder.path().join("film.json");
    std::fs::write(&film, section.to_string()).unwrap();
    let words = ["--full-wave", "--wavelengths", "400:700:20", "--phi", "0", "-o"];
    let begin = || {
        let mut command = program();
        command
            .arg("validate")
            .arg(&film)
            .args(words)
            .arg(&output)
            .stderr(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .unwrap()
    };
    let kept = || std::fs::read_dir(output.join("units")).map_or(0, |units| units.count());
    let mut child = begin();
    while kept() == 0 && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(5));
    }
    interrupt(&child);
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{said}");
    assert!(said.contains(" of 16 wavelengths are kept; the same command goes on"), "{said}");
    assert!(!output.join("numbers.json").exists());
    let there = kept();
    assert!((1..16).contains(&there));
    let resumed = begin().wait_with_output().unwrap();
    let said = String::from_utf8(resumed.stderr).unwrap();
    assert!(
        resumed.status.success() && said.contains(&format!("{there} of 16 wavelengths are there")),
        "{said}"
    );
    assert!(output.join("numbers.json").is_file());
}

/// While a scene is built, whatever of it takes long: feathers, coats, places of objects and their hierarchies.
#[test]
fn scenes_that_take_long_to_build_stop_soon() {
    let folder = tempfile::tempdir().unwrap();
    let feather = "preset = 'starling'\n[detail]\nlevel = 'barbs'\n[window]\nwhole = true\n\
        [feather.shaft]\nlength_mm = 1000\n[feather.barbs]\nspacing_um = 20\n";
    let coat = "preset = 'starling-feather'\n[detail]\nlevel = 'vane'\n[coat]\nellipsoid_mm = [38, 70, 38]\n\
        count = 50000\n";
    let instances: String = (0..100_000).map(|i| format!("{{translate_mm = [{i}, 0, 0]}},")).collect();
    let balls = format!(
        "preset = 'starling'\nshows_feather = false\n[surfaces.a]\ntype = 'diffuse'\n[[objects]]\n\
        sphere_mm = 0.1\nsurface = 'a'\ninstances = [{instances}]\n"
    );
    for (name, text) in [("feather", feather), ("coat", coat), ("balls", &balls)] {
        write_made_up();
        std::fs::write(folder.path().join("s.toml"), text).unwrap();
        let mut command = program();
        command.args([
            "render",
            "s.toml",
            "--material",
            MADE_UP,
            "--size",
            "1200x900",
            "--samples",
            "1000000",
        ]);
        command.args(["-o", "x.png"]).current_dir(folder.path());
        let mut child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(1200));
        let asked = Instant::now();
        interrupt(&child);
        let mut said = String::new();
        child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(130), "{name}: {said}");
        // Half a second is promised on a machine of its own; tests share theirs.
        assert!(asked.elapsed() < Duration::from_secs(5), "{name}: {:?}", asked.elapsed());
    }
}
