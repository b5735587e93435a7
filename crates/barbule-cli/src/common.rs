//! What every command shares: flags, exit codes, machine output.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};

use barbule::campaign::Allowance;
use barbule::error::{shortened, visible};
use barbule::io::available_memory;
use barbule::material::KERATIN_CLEAR_FROM_NM;
use barbule::open::{Media, Opening};
use barbule::{Error, Result};
use clap::Args;

use crate::materials::catalog;

/// Flags that every command takes.
#[derive(Debug, Clone, Args)]
pub struct Common {
    /// Seed of everything random
    #[arg(long, default_value_t = 1, global = true, value_name = "N")]
    pub seed: u64,
    /// Threads to use [default: all cores]
    #[arg(long, global = true, value_name = "N")]
    pub threads: Option<usize>,
    /// Memory to stay within, as in 8GiB or 500MB
    #[arg(long, global = true, value_name = "SIZE", value_parser = memory)]
    pub memory: Option<u64>,
    /// No progress, no messages
    #[arg(long, global = true)]
    pub quiet: bool,
    /// Say what was decided
    #[arg(short, long, global = true)]
    pub verbose: bool,
    /// One JSON document on standard output
    #[arg(long, global = true)]
    pub json: bool,
    /// Folder for computed materials [default: the system's cache folder]
    #[arg(long, global = true, value_name = "DIR")]
    pub cache: Option<PathBuf>,
    /// A medium of your own from a table of n and k: NAME=FILE (repeatable)
    #[arg(long, global = true, value_name = "NAME=FILE")]
    pub medium: Vec<String>,
}

impl Common {
    /// Sets the number of threads of the process, once, before any work.
    ///
    /// # Errors
    /// `--threads` is 0 or over 4096, or the pool cannot start.
    pub fn start_threads(&self) -> Result<()> {
        if let Some(bad) = self.threads.filter(|threads| !(1..=4096).contains(threads)) {
            return Err(Error::input(format!("--threads {bad}: give a number from 1 to 4096")));
        }
        // 0: as many as there are cores.
        match rayon::ThreadPoolBuilder::new().num_threads(self.threads.unwrap_or(0)).build_global() {
            // A second call in one process (tests) keeps the first pool; results do not depend on it.
            Err(error) if std::error::Error::source(&error).is_none() => Ok(()),
            Err(error) => Err(match self.threads {
                Some(threads) => {
                    Error::input(format!("--threads {threads}: cannot be started ({error}); give fewer"))
                }
                None => Error::machine(format!("threads cannot be started ({error}); try --threads 1")),
            }),
            Ok(()) => Ok(()),
        }
    }

    /// What decides how names and files are opened: media, those of `--medium` among them, cache and seed.
    ///
    /// # Errors
    /// A `--medium` is not NAME=FILE, its name cannot be one, or its table cannot be read.
    pub(crate) fn opening(&self) -> Result<Opening> {
        let mut media = Media::default();
        let mut names = BTreeSet::new();
        for given in &self.medium {
            let (name, file) =
                given.split_once('=').filter(|(_, file)| !file.is_empty()).ok_or_else(|| {
                    Error::input(format!(
                        "--medium {}: write NAME=FILE, as in chitin=chitin.csv",
                        shortened(given)
                    ))
                })?;
            if !names.insert(name.trim()) {
                return Err(Error::input(format!(
                    "--medium {}: is given twice; give one table for each name",
                    shortened(name.trim())
                )));
            }
            media.add(name.trim(), file.as_ref())?;
        }
        Ok(Opening { media, catalog: catalog(self), seed: self.seed, ..Opening::default() })
    }

    /// The memory that may be taken: `--memory`, else what the machine has left.
    #[must_use]
    pub fn allowance(&self) -> Allowance {
        match self.memory {
            Some(bytes) => Allowance { bytes, asked: true },
            None => available_memory().map_or(Allowance::UNKNOWN, |bytes| Allowance { bytes, asked: false }),
        }
    }

    /// Refuses, before any work, what does not fit into memory; `what` begins the sentence, `remedy` ends it. Says what is foretold,
    /// with `--verbose` or where it is much.
    ///
    /// # Errors
    /// It does not fit.
    pub fn check_memory(&self, what: &str, bytes: u64, remedy: &str) -> Result<()> {
        self.allowance().check(what, bytes, remedy)?;
        self.say_memory(what, bytes);
        Ok(())
    }

    /// Says what memory is foretold, bytes, with `--verbose` or where it is much.
    pub fn say_memory(&self, what: &str, bytes: u64) {
        let said = format!("{what}: up to {} MB of memory", bytes.div_ceil(1_000_000));
        if bytes > MUCH_MEMORY { self.say(&said) } else { self.explain(&said) }
    }

    /// Writes a message for people to standard error, unless `--quiet`.
    pub fn say(&self, message: &str) {
        if !self.quiet {
            let _ = writeln!(std::io::stderr(), "{}", harmless(message));
        }
    }

    /// Says that a file has been written and what it shows, in one line on standard error: `wrote x.png: what`.
    pub fn wrote(&self, path: &Path, what: &str) {
        self.say(&format!("wrote {}: {what}", path.display()));
    }

    /// Says that a flag that was given changes nothing in this run: `--flag has no effect here: why`.
    pub fn idle(&self, flag: &str, why: &str) {
        self.say(&format!("{flag} has no effect here: {why}"));
    }

    /// Says of each of these `--medium` that nothing is made of it.
    pub(crate) fn say_unused(&self, what: &str, media: &[&str]) {
        for name in media {
            let why = format!("nothing in {} is made of it", shortened(what));
            self.idle(&format!("--medium {}", shortened(name)), &why);
        }
    }

    /// Says that what is shown below 350 nm is that of keratin that absorbs nothing.
    pub(crate) fn say_guessed(&self) {
        self.say(&format!(
            "below {KERATIN_CLEAR_FROM_NM} nm keratin absorbs, how much nobody has tabulated: k = 0 is taken there, so that birds are darker than this"
        ));
    }

    /// Writes what was decided to standard error, with `--verbose`.
    pub fn explain(&self, message: &str) {
        if self.verbose {
            self.say(message);
        }
    }
}

/// A time in the unit that people would use.
pub(crate) fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{:.0} s", s.max(1.0)),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

/// A text of several lines without what a terminal would obey: names in it may come from anybody's files.
fn harmless(text: &str) -> String {
    text.chars().map(|c| if matches!(c, '\n' | '\t') { c } else { visible(c) }).collect()
}

/// A path for a JSON document; what is no Unicode in it is replaced.
#[must_use]
pub fn path_json(path: &Path) -> serde_json::Value {
    path.to_string_lossy().into()
}

/// The exit code of an error: 2 for what the user can mend, 130 after Ctrl-C, else 1.
#[must_use]
pub fn exit_code(error: &Error) -> u8 {
    match error {
        e if e.is_input() => 2,
        e if e.is_interrupted() => 130,
        _ => 1,
    }
}

/// Writes one line of text to a command's output; a closed pipe ends the program quietly.
///
/// # Errors
/// Standard output cannot be written.
pub fn print(out: &mut dyn Write, text: &str) -> Result<()> {
    match writeln!(out, "{}", harmless(text)).and_then(|()| out.flush()) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => std::process::exit(0),
        Err(error) => Err(Error::machine(format!("standard output cannot be written: {error}"))),
        Ok(()) => Ok(()),
    }
}

/// Writes one JSON document to a command's output.
///
/// # Errors
/// The value has no JSON form, or standard output cannot be written.
pub fn print_json(out: &mut dyn Write, value: &impl serde::Serialize) -> Result<()> {
    let text = serde_json::to_string(value).map_err(|e| Error::machine(format!("no JSON form: {e}")))?;
    print(out, &text)
}

/// More than this is said before it is taken, bytes.
const MUCH_MEMORY: u64 = 1_000_000_000;

/// What the smallest command takes, bytes.
pub(crate) const LEAST_MEMORY: f64 = 16e6;

/// A memory size: a number with an optional unit B, kB, MB, GB, KiB, MiB, GiB.
fn memory(text: &str) -> Result<u64, String> {
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let unit = match text[split..].to_ascii_lowercase().as_str() {
        "" | "b" => 1.0,
        "k" | "kb" => 1e3,
        "m" | "mb" => 1e6,
        "g" | "gb" => 1e9,
        "kib" => 1024.0,
        "mib" => 1024.0 * 1024.0,
        "gib" => 1024.0 * 1024.0 * 1024.0,
        other => return Err(format!("unknown unit '{}': write for example 8GiB or 500MB", shortened(other))),
    };
    match text[..split].trim().parse::<f64>() {
        Ok(value) if value * unit >= 1.0 && value * unit < LEAST_MEMORY => {
            Err(format!("the program itself needs about {:.0} MB; raise --memory", LEAST_MEMORY / 1e6))
        }
        Ok(value) if value.is_finite() && value * unit >= 1.0 => Ok((value * unit) as u64),
        _ => Err("write a size such as 8GiB or 500MB".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_sizes_are_read_in_both_kinds_of_units() {
        assert_eq!(memory("8GiB"), Ok(8 << 30));
        assert_eq!(memory("500 MB"), Ok(500_000_000));
        assert!(memory("15MB").unwrap_err().contains("needs about 16 MB; raise --memory"));
        assert!(memory("lots").is_err());
        assert!(memory("0").is_err());
        assert!(memory("5XB").is_err());
    }

    #[test]
    fn names_from_files_cannot_move_a_terminals_cursor() {
        assert_eq!(harmless("a\u{1b}[2Jb\nc\td\u{202e}"), "a [2Jb\nc\td ");
    }
}
