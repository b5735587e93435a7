//! Barbule's command line as a library: typed arguments → checked values → the library's calls.
//!
//! Nothing is computed here. Each command is one file in [`commands`]; what all share is in [`common`] (flags, exit
//! codes, output), [`sets`] (sets of numbers) and [`progress`].

mod arguments;
mod bird_args;
mod campaign;
pub mod commands;
pub mod common;
mod complete;
mod exhausted;
pub mod figure;
mod heights_arg;
mod materials;
mod measured_args;
mod outputs;
mod peak_args;
pub mod progress;
pub mod provenance;
mod scene_arg;
mod segment_args;
pub mod sets;
mod shard;
pub mod structure_arg;

pub use exhausted::EndsWhenExhausted;
pub use materials::usual_cache_folder;

use std::io::Write;

use barbule::error::sentence;
use barbule::io::Ledger;
use barbule::{Error, Result};
use clap::{CommandFactory, FromArgMatches, Parser};

/// Turns the nanostructure of a bird's feather into its picture.
#[derive(Debug, Parser)]
#[command(name = "barbule", version, propagate_version = true, max_term_width = 100)]
#[command(after_help = "Example:\n  barbule render starling -o starling.png")]
struct Cli {
    #[command(subcommand)]
    command: commands::Command,
    /// So that flags that every command takes may stand before it; each command finds them among its own.
    #[command(flatten)]
    _common: common::Common,
}

/// Runs the program on these arguments, the first of which is its own name, with the process's outputs.
#[must_use]
pub fn program(arguments: Vec<std::ffi::OsString>) -> u8 {
    match complete::answer(&arguments) {
        Ok(false) => {}
        Ok(true) => return 0,
        // A shell shows nothing of it.
        Err(_) => return 1,
    }
    let mut out = std::io::stdout().lock();
    run(arguments, &mut out, &mut std::io::stderr())
}

/// Runs one command line: results to `out`, messages to `err`.
///
/// Returns the exit code: 0 done, 2 what the user can mend, 1 failures of the machine or of convergence, 130 after Ctrl-C.
pub fn run<I, T>(args: I, out: &mut dyn Write, err: &mut dyn Write) -> u8
where
    I: IntoIterator<Item = T>,
    T: Into<std::ffi::OsString> + Clone,
{
    let words: Vec<std::ffi::OsString> = args.into_iter().map(Into::into).collect();
    match done(&words, out) {
        Ok(()) => 0,
        Err(Ending::Unclear(error)) if error.use_stderr() => {
            // A closed pipe on the other side is not an error of ours.
            let _ = match error.kind() {
                clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
                    write!(err, "{}", error.render())
                }
                _ => writeln!(err, "barbule: {}", as_typed(unclear(&error), &words)),
            };
            2
        }
        // Help and version.
        Err(Ending::Unclear(text)) => match common::print(out, text.render().to_string().trim_end()) {
            Ok(()) => 0,
            Err(error) => refused(&error, &words, err),
        },
        Err(Ending::Failed(error)) => refused(&error, &words, err),
    }
}

/// Why a command line ended early.
enum Ending {
    /// Its words are none that can be run, or ask for help.
    Unclear(clap::Error),
    Failed(Error),
}

fn done(words: &[std::ffi::OsString], out: &mut dyn Write) -> Result<(), Ending> {
    // No command can leave it out: what is read from here on, by readers of arguments too, is never written over.
    let _ledger = Ledger::open();
    let matches = command().try_get_matches_from(words).map_err(Ending::Unclear)?;
    let cli = Cli::from_arg_matches(&matches).map_err(|e| Ending::Unclear(e.format(&mut command())))?;
    outputs::check(&matches).and_then(|()| cli.command.run(out)).map_err(Ending::Failed)
}

fn refused(error: &Error, words: &[std::ffi::OsString], err: &mut dyn Write) -> u8 {
    let _ = writeln!(err, "barbule: {}", as_typed(arguments::spoken(error), words));
    common::exit_code(error)
}

/// A sentence that begins with a flag, with the synonym of it that was typed.
fn as_typed(sentence: String, words: &[std::ffi::OsString]) -> String {
    let Some((flag, rest)) = sentence.find([' ', ':']).map(|end| sentence.split_at(end)) else {
        return sentence;
    };
    let Some(long) = flag.strip_prefix("--") else { return sentence };
    let is_typed = |name: &str| {
        words.iter().filter_map(|word| word.to_str()?.strip_prefix("--")).any(|word| {
            word.strip_prefix(name).is_some_and(|value| value.is_empty() || value.starts_with('='))
        })
    };
    if is_typed(long) {
        return sentence;
    }
    let command = command();
    let arguments = command.get_subcommands().flat_map(clap::Command::get_arguments);
    let mut synonyms = arguments
        .filter(|argument| argument.get_long() == Some(long))
        .flat_map(|argument| argument.get_all_aliases().unwrap_or_default());
    synonyms.find(|name| is_typed(name)).map_or_else(|| sentence.clone(), |name| format!("--{name}{rest}"))
}

/// What is wrong with the arguments, in one sentence: that of the value's reader where it is one of ours, else clap's lines
/// without its summary of the usage and its far-fetched tips.
#[must_use]
pub fn unclear(error: &clap::Error) -> String {
    let reader = std::error::Error::source(error).and_then(|source| source.downcast_ref::<Error>());
    if let Some(refused) = reader {
        return refused.to_string();
    }
    if let Some(text) = unexpected(error) {
        return text;
    }
    let text = error.render().to_string();
    let lines = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"))
        .filter(|line| !line.is_empty());
    let joined = lines.collect::<Vec<_>>().join(" ").replace(" tip: ", "; ");
    let words = joined.trim_start_matches("error: ").trim_end_matches(['.', ' ']);
    sentence(&format!("{words}; --help says what can be given"))
}

/// Of an argument that no command or not this one takes: what it is, and the nearest that there is.
fn unexpected(error: &clap::Error) -> Option<String> {
    use clap::error::{ContextKind, ContextValue, ErrorKind};
    if error.kind() != ErrorKind::UnknownArgument {
        return None;
    }
    let Some(ContextValue::String(given)) = error.get(ContextKind::InvalidArg) else { return None };
    let near = match error.get(ContextKind::SuggestedArg) {
        Some(ContextValue::String(flag)) => barbule::error::did_you_mean(given, [flag.as_str()]),
        _ => String::new(),
    };
    let rest = if near.is_empty() { "; --help says what can be given" } else { &near };
    Some(format!("unexpected argument '{}'{rest}", barbule::error::shortened(given)))
}

/// The command-line definition, for shell completions and tests.
#[must_use]
pub fn command() -> clap::Command {
    with_negative_numbers(Cli::command())
}

/// So that -1 behind a flag is its value, and is refused as such where it is none.
fn with_negative_numbers(command: clap::Command) -> clap::Command {
    command.allow_negative_numbers(true).mut_subcommands(with_negative_numbers)
}
