//! The commands, one file each.

use std::io::Write;

use barbule::Result;
use clap::Subcommand;

mod completions;
mod film;
mod render;

/// A command with its arguments.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Reflection, transmission and absorption of a stack of flat layers
    Film(film::Args),
    /// Print completions for a shell
    Completions(completions::Args),
    /// Render a picture of a feather
    Render(render::Args),
}

impl Command {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        match self {
            Self::Film(args) => args.run(out),
            Self::Completions(args) => args.run(out),
            Self::Render(args) => args.run(out),
        }
    }
}
