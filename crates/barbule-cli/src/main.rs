//! The `barbule` program.

use std::process::ExitCode;

use barbule_cli::EndsWhenExhausted;

#[global_allocator]
static ALLOCATOR: EndsWhenExhausted = EndsWhenExhausted;

fn main() -> ExitCode {
    barbule_cli::program(std::env::args_os().collect()).into()
}
