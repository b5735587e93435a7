//! The commands, one file each.

use std::io::Write;

use barbule::Result;
use clap::Subcommand;

mod completions;

/// A command with its arguments.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Print completions for a shell
    Completions(completions::Args),
}

impl Command {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        match self {
            Self::Completions(args) => args.run(out),
        }
    }
}
