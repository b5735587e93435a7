//! `barbule view`: the viewer, a program of its own.

use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

use barbule::{Error, Result};

/// The viewer's program.
const PROGRAM: &str = "barbule-view";

/// Arguments of `barbule view`.
#[derive(Debug, clap::Args)]
#[command(
    override_usage = "barbule view [X] [OPTIONS OF barbule-view]",
    after_help = "Examples:\n  barbule view starling\n  barbule view air/keratin:595/air --mode sphere\n  \
        barbule view starling --screenshot starling.png --size 640x480 --light 340,50\n  barbule view xenopeltis --mode snake --bench\n\n\
        The window is another program, barbule-view, found beside barbule or on the PATH; `barbule view -- --help` lists its flags."
)]
pub(crate) struct Args {
    /// A species, stack, grating or preset, or the file of one, and flags of barbule-view: --screenshot, --size, --light, --camera, --mode, --mean, --eye, --frames, --bench, --state
    #[arg(value_name = "X", trailing_var_arg = true, allow_hyphen_values = true)]
    words: Vec<OsString>,
}

impl Args {
    pub(crate) fn run(&self) -> Result<()> {
        let beside = std::env::current_exe().map(|own| own.with_file_name(named())).ok();
        let found = beside.filter(|file| file.is_file());
        let mut command = Command::new(found.as_deref().unwrap_or(Path::new(PROGRAM)));
        command.args(self.words.iter().skip_while(|word| *word == "--"));
        let error = replaced(&mut command);
        Err(match error.kind() {
            std::io::ErrorKind::NotFound => Error::input(
                "the viewer barbule-view is neither beside barbule nor on the PATH; build it in Barbule's folder with: cargo build --release -p barbule-view",
            ),
            _ => Error::machine(format!("the viewer barbule-view cannot be started: {error}")),
        })
    }
}

fn named() -> String {
    format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX)
}

/// Runs another program in place of this one, with its output and its exit code; returns only where it cannot be started.
#[cfg(unix)]
fn replaced(command: &mut Command) -> std::io::Error {
    use std::os::unix::process::CommandExt as _;

    command.exec()
}

#[cfg(not(unix))]
fn replaced(command: &mut Command) -> std::io::Error {
    match command.status() {
        Ok(status) => std::process::exit(status.code().unwrap_or(1)),
        Err(error) => error,
    }
}
