//! `barbule completions`: tab completion for shells.

use std::io::Write;

use barbule::{Error, Result};

use crate::common::Common;
use crate::complete::{SHELLS, VARIABLE};

/// Arguments of `barbule completions`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  barbule completions bash > ~/.local/share/bash-completion/completions/barbule\n\n\
        The script asks the program, which must be on the PATH, and so knows species, variants and presets:\n  \
        zsh: barbule completions zsh > ~/.zfunc/_barbule (a folder of $fpath), fish: barbule completions fish > \
        ~/.config/fish/completions/barbule.fish"
)]
pub(crate) struct Args {
    /// The shell
    #[arg(value_parser = ["bash", "elvish", "fish", "powershell", "zsh"])]
    shell: String,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        let failed = |e: std::io::Error| Error::machine(format!("standard output cannot be written: {e}"));
        let Some(shell) = SHELLS.completer(&self.shell) else {
            return Err(Error::input(format!("there are no completions for {}", self.shell)));
        };
        if self.common.json {
            self.common.idle("--json", "a shell reads its script as it is");
        }
        shell.write_registration(VARIABLE, "barbule", "barbule", "barbule", out).map_err(failed)
    }
}
