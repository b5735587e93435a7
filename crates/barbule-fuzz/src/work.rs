//! One target, many inputs, in a process of its own: what ends it is told by a file.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

use crate::mutate::Mutator;
use crate::{Seen, Target, examine};

/// The longest that one input may take: machines of tests are slow and shared.
pub const PATIENCE: Duration = Duration::from_secs(20);

/// The stack of a program's first thread, which readers must do with.
const STACK: usize = 8 << 20;

/// Which inputs a worker makes.
#[derive(Debug, Clone)]
pub struct Work {
    /// Of the random numbers.
    pub seed: u64,
    /// How many inputs, beside the seeds themselves.
    pub executions: u64,
    /// Whether each input is written to the file of the last one before it is examined: slow, but nothing hides it.
    pub traces: bool,
    /// The file of the input that broke a law.
    pub finding: PathBuf,
}

/// What came out of it.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    /// Inputs that were examined.
    pub executions: u64,
    /// Of them those that were read.
    pub accepted: u64,
    /// The law that was broken; the input is in the file of the finding.
    pub broken: Option<String>,
}

/// The input at work and when it began, for whoever watches.
static CURRENT: Mutex<Option<(Vec<u8>, Instant)>> = Mutex::new(None);
/// How many inputs were examined.
static DONE: AtomicU64 = AtomicU64::new(0);

/// Examines the seeds and so many inputs; ends with the first that breaks a law.
///
/// # Errors
/// The thread cannot be started.
pub fn work(target: &'static Target, work: &Work) -> std::io::Result<Tally> {
    let watched = work.clone();
    std::thread::spawn(move || watch(&watched.finding));
    let work = work.clone();
    let thread = std::thread::Builder::new().stack_size(STACK).spawn(move || all(target, &work))?;
    Ok(thread
        .join()
        .unwrap_or_else(|_| Tally { broken: Some("the worker panicked".into()), ..Tally::default() }))
}

fn all(target: &'static Target, work: &Work) -> Tally {
    // The message of a panic is wanted, and not among the lines of the others.
    let message = std::sync::Arc::new(Mutex::new(String::new()));
    let heard = message.clone();
    std::panic::set_hook(Box::new(move |info| {
        if let Ok(mut text) = heard.lock() {
            *text = info.to_string().replace('\n', " ");
        }
    }));
    let seeds = target.seeds();
    let mut mutator = Mutator::new(work.seed, &seeds, target.tokens);
    let mut tally = Tally::default();
    let mut given = seeds.iter();
    while tally.executions < seeds.len() as u64 + work.executions {
        let input = given.next().cloned().unwrap_or_else(|| mutator.make());
        if work.traces {
            keep(&work.finding, &input);
        }
        if let Ok(mut current) = CURRENT.lock() {
            *current = Some((input.clone(), Instant::now()));
        }
        let verdict = catch_unwind(AssertUnwindSafe(|| examine(target, &input)))
            .unwrap_or_else(|_| Err(message.lock().map_or_else(|_| "panicked".into(), |text| text.clone())));
        tally.executions += 1;
        DONE.store(tally.executions, Relaxed);
        match verdict {
            Ok(Seen::Accepted) => {
                tally.accepted += 1;
                mutator.keep(&input);
            }
            Ok(Seen::Refused) => {}
            Err(broken) => {
                keep(&work.finding, &input);
                tally.broken = Some(broken);
                break;
            }
        }
    }
    if let Ok(mut current) = CURRENT.lock() {
        *current = None;
    }
    tally
}

fn keep(file: &Path, input: &[u8]) {
    if let Err(error) = std::fs::write(file, input) {
        panic!("{}: cannot be written: {error}", file.display());
    }
}

/// Ends the process where an input takes too long, with the input in the file of the finding.
fn watch(finding: &Path) {
    loop {
        std::thread::sleep(Duration::from_millis(500));
        let Ok(current) = CURRENT.lock() else { return };
        if let Some((input, begun)) = &*current
            && begun.elapsed() > PATIENCE
        {
            keep(finding, input);
            std::process::exit(SLOW);
        }
    }
}

/// The exit code of a worker whose input took too long.
pub const SLOW: i32 = 77;
