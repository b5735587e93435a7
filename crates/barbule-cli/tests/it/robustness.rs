//! What may happen to a campaign while it runs, and what its store must be afterwards.

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{bytes_of, program, said_by};
use barbule::math::rng::Stream;

/// A campaign of half a second.
const TINY: &[&str] = &["--wavelengths", "450:650:50", "--directions", "3x2", "--instances", "3"];

fn command(store: &Path, more: &[&str]) -> Command {
    let mut command = program();
    command.args(["simulate", "starling", "-o"]).arg(store).args(TINY).args(more);
    command.stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

fn simulate(store: &Path, more: &[&str]) -> Output {
    command(store, more).output().unwrap()
}

fn start(store: &Path, more: &[&str]) -> Child {
    command(store, more).spawn().unwrap()
}

/// Kills campaigns at random moments and holds the resumed store against an uninterrupted one.
fn killed(repetitions: u64) {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("whole.zarr");
    let begun = Instant::now();
    assert!(simulate(&whole, &[]).status.success());
    let (took, whole) = (begun.elapsed().as_secs_f64(), bytes_of(&whole));
    for repetition in 0..repetitions {
        let store = folder.path().join(format!("{repetition}.zarr"));
        let mut random = Stream::new(95, &[repetition]);
        for _ in 0..2 {
            let mut child = start(&store, &[]);
            std::thread::sleep(Duration::from_secs_f64(took * random.unit()));
            child.kill().unwrap();
            child.wait().unwrap();
        }
        let output = simulate(&store, &[]);
        assert!(output.status.success(), "{}", said_by(&output));
        assert!(!said_by(&output).contains("damaged"), "{}", said_by(&output));
        assert!(bytes_of(&store) == whole, "repetition {repetition}");
    }
    // Nothing lies about.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count() as u64, repetitions + 1);
}

#[test]
fn a_killed_campaign_resumes_to_the_same_bits() {
    killed(3);
}

/// Before a release: `cargo test --release -p barbule-cli --test it robustness -- --ignored`.
#[test]
#[ignore = "minutes"]
fn a_hundred_killed_campaigns_resume_to_the_same_bits() {
    killed(100);
}

#[test]
fn several_processes_fill_one_new_store_to_the_same_bits_at_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let (alone, shared) = (folder.path().join("alone.zarr"), folder.path().join("shared.zarr"));
    assert!(simulate(&alone, &["--threads", "1"]).status.success());
    // The two that do everything meet in every unit; the shards meet both.
    let runs: [&[&str]; 4] = [
        &["--threads", "2"],
        &["--threads", "5"],
        &["--shard", "0/2", "--threads", "1"],
        &["--shard", "1/2", "--memory", "1GB"],
    ];
    let children: Vec<Child> = runs.iter().map(|more| start(&shared, more)).collect();
    for child in children {
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", said_by(&output));
    }
    assert!(bytes_of(&alone) == bytes_of(&shared));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn truncated_emptied_altered_and_lengthened_chunks_are_found_computed_again_and_said() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("s.zarr");
    assert!(simulate(&store, &[]).status.success());
    let whole = bytes_of(&store);
    let chunk = |name: &str| (store.join(name), std::fs::read(store.join(name)).unwrap());
    let (file, bytes) = chunk("u/c.0.1.0.0.0");
    std::fs::write(file, &bytes[..bytes.len() / 2]).unwrap();
    let (file, _) = chunk("unpolarized_contrast/c.1.0.0");
    std::fs::write(file, b"").unwrap();
    let (file, mut bytes) = chunk("autocovariance/c.2.2.0.0.0");
    bytes[40] ^= 4;
    std::fs::write(file, bytes).unwrap();
    let (file, bytes) = chunk("reflected/c.3.1.0.0");
    std::fs::write(file, [&bytes[..], &[0; 1 << 16]].concat()).unwrap();
    let mut status = program();
    let status = status.args(["simulate", "--status"]).arg(&store).output().unwrap();
    let status = String::from_utf8_lossy(&status.stdout).into_owned();
    assert!(status.contains("11 of 15 units done, 0 missing, 4 damaged"), "{status}");
    let output = simulate(&store, &[]);
    assert!(output.status.success());
    assert!(said_by(&output).contains("4 damaged units were computed again"), "{}", said_by(&output));
    assert!(bytes_of(&store) == whole);
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_soon_and_leaves_what_can_be_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("s.zarr");
    // Full size: minutes, were it not interrupted.
    let mut command = program();
    command.args(["simulate", "starling", "-o"]).arg(&store).stderr(Stdio::piped());
    let child = command.spawn().unwrap();
    let begun = Instant::now();
    let begun_units = || std::fs::read_dir(store.join("contrast")).is_ok_and(|files| files.count() > 1);
    while !begun_units() && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(20));
    }
    let asked = Instant::now();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    // Two seconds are promised on a machine of its own; tests share theirs.
    assert!(asked.elapsed() < Duration::from_secs(8), "{:?}", asked.elapsed());
    let status = barbule::io::store::Store::open(&store).unwrap().status();
    assert!(status.done > 0 && status.damaged == 0 && status.missing() > 0, "{status:?}");
    let said = String::from_utf8(output.stderr).unwrap();
    let sentence = format!("interrupted: {} of 1020 units done; the same command goes on", status.done);
    assert!(said.contains(&sentence), "{said}");
    assert!(!store.join(".aside").exists());
}

/// A hummingbird's instances take seconds to prepare, before the first unit.
#[cfg(unix)]
#[test]
fn ctrl_c_during_preparation_leaves_nothing_but_an_empty_store() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("s.zarr");
    let mut command = program();
    let mut child =
        command.args(["simulate", "hummingbird", "-o"]).arg(&store).stderr(Stdio::piped()).spawn().unwrap();
    let begun = Instant::now();
    while !store.join("zarr.json").exists() && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(200));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(!store.join(".aside").exists());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn memory_that_does_not_suffice_is_said_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("s.zarr");
    let output = simulate(&store, &["--memory", "20MB"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said_by(&output).contains("but 20 MB are allowed; raise --memory"), "{}", said_by(&output));
    assert!(!store.exists());
}

/// A file system of its own in memory, which goes with its value.
#[cfg(target_os = "linux")]
struct Disk(tempfile::TempDir);

#[cfg(target_os = "linux")]
impl Disk {
    /// `None`, with a line, where this user may not mount.
    fn new(size: &str) -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={size}"), "tmpfs"])
            .arg(folder.path())
            .stderr(Stdio::null())
            .status()
            .is_ok_and(|s| s.success());
        if !mounted {
            let _ = writeln!(std::io::stderr(), "skipped: a small disk cannot be mounted here");
        }
        mounted.then_some(Self(folder))
    }

    fn remount(&self, option: &str) {
        let option = format!("remount,{option}");
        assert!(Command::new("mount").args(["-o", &option]).arg(self.0.path()).status().unwrap().success());
    }
}

#[cfg(target_os = "linux")]
use std::io::Write as _;

#[cfg(target_os = "linux")]
impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0.path()).status();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_said_leaves_nothing_half_written_and_more_space_resumes() {
    let Some(disk) = Disk::new("260k") else { return };
    let folder = tempfile::tempdir().unwrap();
    let (whole, store) = (folder.path().join("s.zarr"), disk.0.path().join("s.zarr"));
    assert!(simulate(&whole, &[]).status.success());
    let output = simulate(&store, &[]);
    assert_eq!(output.status.code(), Some(1), "{}", said_by(&output));
    let text = said_by(&output);
    assert!(text.contains("No space left") && text.contains("free some space") && text.len() < 600, "{text}");
    let status = barbule::io::store::Store::open(&store).unwrap().status();
    assert!(status.damaged == 0 && status.missing() > 0, "{status:?}");
    assert!(!store.join(".aside").exists());
    disk.remount("size=20m");
    assert!(simulate(&store, &[]).status.success());
    assert!(bytes_of(&whole) == bytes_of(&store));
    // Too small for a store at all: nothing is there afterwards.
    let Some(tiny) = Disk::new("20k") else { return };
    let output = simulate(&tiny.0.path().join("s.zarr"), &[]);
    assert_eq!(output.status.code(), Some(1), "{}", said_by(&output));
    assert_eq!(std::fs::read_dir(tiny.0.path()).unwrap().count(), 0);
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_too_small_for_a_checkpoint_does_not_lose_the_picture() {
    use crate::common::{MADE_UP, write_made_up};
    let Some(disk) = Disk::new("200k") else { return };
    write_made_up();
    let render = |more: &[&str]| {
        let mut command = program();
        command.current_dir(disk.0.path()).args([
            "render",
            "starling",
            "--material",
            MADE_UP,
            "--samples",
            "2",
        ]);
        command.args(["--size", "64x64", "-o"]).args(more).output().unwrap()
    };
    // A picture that is done needs no checkpoint; one that is not goes on without.
    assert!(render(&["d.png", "--resume"]).status.success());
    std::fs::remove_file(disk.0.path().join("d.png")).unwrap();
    let output = render(&["r.png", "--resume", "--time", "0.001s"]);
    let text = said_by(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("r.png.checkpoint: cannot be written (No space left"), "{text}");
    assert!(text.contains("the picture itself is written") && text.len() < 600, "{text}");
    let picture = std::fs::read(disk.0.path().join("r.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG") && picture.ends_with(b"IEND\xaeB`\x82"));
    assert_eq!(std::fs::read_dir(disk.0.path()).unwrap().count(), 1);
    // All frames of a sequence are drawn, and it is said once.
    std::fs::remove_file(disk.0.path().join("r.png")).unwrap();
    let output = render(&["f.png", "--resume", "--frames", "3"]);
    let text = said_by(&output);
    assert!(output.status.success(), "{text}");
    assert_eq!(text.matches("cannot be written (No space left").count(), 1, "{text}");
    assert!(
        text.contains("f-0000.png.checkpoint: ") && text.contains("rendering goes on without it"),
        "{text}"
    );
    assert_eq!(std::fs::read_dir(disk.0.path()).unwrap().count(), 3);
}

#[cfg(target_os = "linux")]
#[test]
fn tables_that_do_not_fit_on_the_disk_leave_neither_themselves_nor_their_notes() {
    let Some(disk) = Disk::new("8k") else { return };
    let film = |set: &str| {
        let mut command = program();
        command.current_dir(disk.0.path()).args([
            "film",
            "air/keratin:300/air",
            "--csv",
            "t.csv",
            "--wavelengths",
            set,
        ]);
        command.output().unwrap()
    };
    // One page for the table, one for the notes; then the folder has no room for a second pair.
    for set in ["400:800:1", "400:460:1"] {
        let output = film(set);
        assert_eq!(output.status.code(), Some(1), "{}", said_by(&output));
        assert!(said_by(&output).contains("free some space"), "{}", said_by(&output));
        assert_eq!(std::fs::read_dir(disk.0.path()).unwrap().count(), 0);
    }
    disk.remount("size=1m");
    assert!(film("400:460:1").status.success());
    assert_eq!(std::fs::read_dir(disk.0.path()).unwrap().count(), 2);
    disk.remount("ro");
    let output = film("500");
    assert_eq!(output.status.code(), Some(2), "{}", said_by(&output));
}

#[cfg(target_os = "linux")]
#[test]
fn a_store_that_cannot_be_written_is_refused_before_work_unless_it_is_finished() {
    let Some(disk) = Disk::new("20m") else { return };
    let store = disk.0.path().join("s.zarr");
    assert!(simulate(&store, &["--shard", "0/2"]).status.success());
    // What a killed process leaves is known where nothing can be written, too.
    std::fs::create_dir(store.join(".aside")).unwrap();
    std::fs::write(store.join(".aside/run-1-2-1700000000-77-killed"), b"").unwrap();
    disk.remount("ro");
    let told = program().args(["simulate", "--status"]).arg(&store).output().unwrap();
    assert!(String::from_utf8_lossy(&told.stdout).contains("units, killed\n"), "{told:?}");
    let output = simulate(&store, &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said_by(&output).contains("the store cannot be written (Read-only"), "{}", said_by(&output));
    let finished = simulate(&store, &["--shard", "0/2"]);
    assert!(finished.status.success() && said_by(&finished).contains("nothing to do"));
    let output = simulate(&disk.0.path().join("other.zarr"), &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(said_by(&output).contains("cannot be created (Read-only"), "{}", said_by(&output));
    disk.remount("rw");
    assert!(simulate(&store, &[]).status.success());
}
