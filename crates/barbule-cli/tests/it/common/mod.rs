//! What several of these tests need.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::Duration;

use barbule::brdf::fixtures::example;
use barbule::io::write_material;

/// The program, with nothing said to it yet.
pub(crate) fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_barbule"))
}

/// What a command ends with, held while it runs.
pub(crate) trait Ends {
    /// Runs the command, which has to end with `code`.
    fn ends(&mut self, code: i32) -> Output;
}

impl Ends for Command {
    fn ends(&mut self, code: i32) -> Output {
        let output = self.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{:?} says: {said}", self.get_args());
        output
    }
}

/// The file of a made-up material; [`write_made_up`] writes it.
pub(crate) const MADE_UP: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/made-up.barbule");

/// Writes [`MADE_UP`] once per run of the tests.
pub(crate) fn write_made_up() {
    static WRITTEN: OnceLock<()> = OnceLock::new();
    WRITTEN.get_or_init(|| write_material(Path::new(MADE_UP), &example(50)).unwrap());
}

/// A scene whose light and framing are the tests' own: presets may be composed anew.
pub(crate) const CLOSE_UP: &str = include_str!("../../../../barbule/tests/it/data/close-up.toml");

/// A run of the program, and its largest resident memory, as often as it was looked at, MB; 0 where the system does not say.
pub(crate) fn run_and_peak(words: &[&str]) -> (Output, f64) {
    let mut child = program().args(words).stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0f64;
    while child.try_wait().unwrap().is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let kilobytes = text.lines().find_map(|l| l.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB"));
        peak = peak.max(kilobytes.and_then(|k| k.trim().parse::<f64>().ok()).unwrap_or(0.0) * 1024e-6);
        std::thread::sleep(Duration::from_millis(1));
    }
    (child.wait_with_output().unwrap(), peak)
}

/// Everything in a folder, hidden files too: relative path → bytes.
pub(crate) fn bytes_of(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(path) = open.pop() {
        for entry in std::fs::read_dir(path).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_string_lossy().into_owned();
                found.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    found
}
