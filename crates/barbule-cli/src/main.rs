//! The `barbule` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    barbule_cli::main()
}
