//! The commands, one file each.

use std::io::Write;

use barbule::Result;
use clap::Subcommand;

mod completions;
mod render;

/// A command with its arguments.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Print completions for a shell
    Completions(completions::Args),
    /// Render a picture of a feather
    Render(render::Args),
}

impl Command {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        match self {
            Self::Completions(args) => args.run(out),
            Self::Render(args) => args.run(out),
        }
    }
}
