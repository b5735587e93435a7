//! The commands, one file each.

use std::io::Write;

use barbule::Result;
use clap::Subcommand;

mod completions;
mod film;
mod lobes;

/// A command with its arguments.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Reflection, transmission and absorption of a stack of flat layers
    Film(film::Args),
    /// Pictures of a material's BRDF, parameters, noise and fits
    Lobes(lobes::Args),
    /// Print completions for a shell
    Completions(completions::Args),
}

impl Command {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        match self {
            Self::Film(args) => args.run(out),
            Self::Lobes(args) => args.run(out),
            Self::Completions(args) => args.run(out),
        }
    }
}
