//! What several of these tests need.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::Duration;

use barbule::brdf::fixtures::example;
use barbule::io::write_material;
use serde_json::Value;

/// The program, with nothing said to it yet.
pub(crate) fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_barbule"))
}

/// What a run leaves: exit code, standard output, standard error.
pub(crate) type Ran = (i32, String, String);

/// What a command ends with, held while it runs.
pub(crate) trait Ends {
    /// Runs the command, which has to end with `code`.
    fn ends(&mut self, code: i32) -> Output;

    /// Runs the command, whatever it ends with.
    fn ran(&mut self) -> Ran;

    /// Runs the command, which has to succeed: what it prints, and what it says on standard error.
    fn succeeds(&mut self) -> (String, String);

    /// Runs the command, which has to succeed and to print JSON.
    fn prints_json(&mut self) -> Value;
}

impl Ends for Command {
    fn ends(&mut self, code: i32) -> Output {
        let output = self.output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{:?} says: {}", self.get_args(), said_by(&output));
        output
    }

    fn ran(&mut self) -> Ran {
        let output = self.output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
    }

    fn succeeds(&mut self) -> (String, String) {
        let (code, out, message) = self.ran();
        assert_eq!(code, 0, "{:?} says: {message}", self.get_args());
        (out, message)
    }

    fn prints_json(&mut self) -> Value {
        let (out, _) = self.succeeds();
        serde_json::from_str(&out).unwrap()
    }
}

/// What a run says on standard error.
pub(crate) fn said_by(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Runs the program where the tests are.
pub(crate) fn run(words: &[&str]) -> Ran {
    program().args(words).ran()
}

/// Runs the program in a folder.
pub(crate) fn run_in(folder: &Path, words: &[&str]) -> Ran {
    program().args(words).current_dir(folder).ran()
}

/// What words print that have to succeed, and what they say on standard error.
pub(crate) fn succeed(words: &[&str]) -> (String, String) {
    program().args(words).succeeds()
}

/// As [`succeed`], in a folder.
pub(crate) fn succeed_in(folder: &Path, words: &[&str]) -> (String, String) {
    program().args(words).current_dir(folder).succeeds()
}

/// What words print that have to succeed.
pub(crate) fn printed(words: &[&str]) -> String {
    succeed(words).0
}

/// The document that words print that have to succeed; `--json` is among them.
pub(crate) fn json(words: &[&str]) -> Value {
    program().args(words).prints_json()
}

/// The program with these words, to be run at the repository's root, where `examples/` is.
pub(crate) fn at_root(words: &[&str]) -> Command {
    let mut command = program();
    command.args(words).current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."));
    command
}

/// As [`Ran`], of the program inside the test's own process, which is faster by its start; `words` are without its name.
pub(crate) fn run_inside<W: Into<OsString>>(words: impl IntoIterator<Item = W>) -> (u8, String, String) {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let all = std::iter::once("barbule".into()).chain(words.into_iter().map(Into::into));
    let code = barbule_cli::run(all, &mut out, &mut err);
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    (code, text(out), text(err))
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
