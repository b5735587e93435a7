//! `barbule completions`: tab completion for shells.

use std::io::Write;

use barbule::{Error, Result};
use clap_complete::Shell;

/// Arguments of `barbule completions`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  barbule completions bash > ~/.local/share/bash-completion/completions/barbule"
)]
pub(crate) struct Args {
    /// The shell
    shell: Shell,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut crate::command(), "barbule", &mut script);
        out.write_all(&script).map_err(|e| Error::machine(format!("standard output cannot be written: {e}")))
    }
}
