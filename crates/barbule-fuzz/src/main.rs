//! The fuzzer's own driver: `scripts/fuzz` calls it.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program")]

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, ExitStatus};
use std::sync::Mutex;
use std::time::Instant;

use barbule_fuzz::memory::Counting;
use barbule_fuzz::work::{SLOW, Tally, Work, work};
use barbule_fuzz::{Target, all, examine, find, past};

#[global_allocator]
static MEMORY: Counting = Counting;

const USAGE: &str = "barbule-fuzz list                                   names of the targets, and what they read
barbule-fuzz seeds FOLDER                           writes the seeds of all targets, and past findings, to FOLDER/TARGET
barbule-fuzz one TARGET FILE ...                    examines files
barbule-fuzz smoke [--seed N] [--times X] [TARGET]  all targets, or one, with the inputs of a seed; X times as many as usual";

/// Of the smoke test.
const SEED: u64 = 40;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let done = match words[..] {
        ["list"] => {
            all().iter().for_each(|target| println!("{:18} {}", target.name, target.about));
            Ok(())
        }
        ["seeds", folder] => seeds(Path::new(folder)),
        ["one", name, ref files @ ..] => one(name, files),
        ["smoke", ref rest @ ..] => smoke(rest),
        ["work", name, seed, executions, traces, finding] => {
            return worker(name, seed, executions, traces == "traces", finding);
        }
        _ => Err(USAGE.to_owned()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}

fn known(name: &str) -> Result<&'static Target, String> {
    find(name).ok_or_else(|| format!("there is no target '{name}'; `list` names them"))
}

fn seeds(folder: &Path) -> Result<(), String> {
    for target in all() {
        let folder = folder.join(target.name);
        std::fs::create_dir_all(&folder).map_err(|error| error.to_string())?;
        let past = past::files("past", target.name).into_iter().map(|(_, bytes)| bytes);
        for (number, bytes) in target.seeds().into_iter().chain(past).enumerate() {
            std::fs::write(folder.join(format!("seed-{number}")), bytes)
                .map_err(|error| error.to_string())?;
        }
    }
    Ok(())
}

fn one(name: &str, files: &[&str]) -> Result<(), String> {
    let target = known(name)?;
    for file in files {
        let bytes = std::fs::read(file).map_err(|error| format!("{file}: {error}"))?;
        let begun = Instant::now();
        let seen = examine(target, &bytes).map_err(|broken| format!("{file}: {broken}"))?;
        println!("{file}: {seen:?}, {:.3} s", begun.elapsed().as_secs_f64());
    }
    Ok(())
}

/// One target in this process. The last line says what came out.
fn worker(name: &str, seed: &str, executions: &str, traces: bool, finding: &str) -> ExitCode {
    let (Ok(target), Ok(seed), Ok(executions)) = (known(name), seed.parse(), executions.parse()) else {
        eprintln!("{USAGE}");
        return ExitCode::FAILURE;
    };
    match work(target, &Work { seed, executions, traces, finding: finding.into() }) {
        Ok(Tally { executions, accepted, broken: None }) => {
            println!("{executions} {accepted}");
            ExitCode::SUCCESS
        }
        Ok(Tally { broken, .. }) => {
            eprintln!("{}", broken.unwrap_or_default());
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Every target in a process of its own, a few at once, so that whatever ends it is only its own end.
fn smoke(words: &[&str]) -> Result<(), String> {
    let (mut seed, mut times, mut chosen) = (SEED, 1.0, None);
    let mut words = words.iter();
    while let Some(word) = words.next() {
        let mut number = || words.next().and_then(|word| word.parse::<f64>().ok()).ok_or(USAGE);
        match *word {
            "--seed" => seed = number()? as u64,
            "--times" => times = number()?,
            name => chosen = Some(known(name)?),
        }
    }
    let begun = Instant::now();
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let left = Mutex::new(
        all()
            .iter()
            .filter(|target| chosen.is_none_or(|chosen| chosen.name == target.name))
            .rev()
            .collect::<Vec<_>>(),
    );
    let rows = Mutex::new(Vec::new());
    let workers = std::thread::available_parallelism().map_or(2, usize::from).min(4);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                while let Some(target) = left.lock().ok().and_then(|mut left| left.pop()) {
                    let executions = (target.smoke() as f64 * times) as u64;
                    let row = tried(target, seed, executions, folder.path());
                    if let Ok(mut rows) = rows.lock() {
                        rows.push(row);
                    }
                }
            });
        }
    });
    let mut rows = rows.into_inner().unwrap_or_default();
    rows.sort_by_key(|row| row.name);
    println!("{:18} {:>10} {:>9} {:>8}", "target", "executions", "accepted", "s");
    for Row { name, executions, accepted, seconds, .. } in &rows {
        println!("{name:18} {executions:>10} {accepted:>9} {seconds:>8.2}");
    }
    let sum: u64 = rows.iter().map(|row| row.executions).sum();
    println!("{} targets, {sum} executions, {:.0} s", rows.len(), begun.elapsed().as_secs_f64());
    let broken: Vec<&str> = rows.iter().filter_map(|row| row.broken.as_deref()).collect();
    if broken.is_empty() { Ok(()) } else { Err(broken.join("\n")) }
}

/// What came out of one target.
struct Row {
    name: &'static str,
    executions: u64,
    accepted: u64,
    seconds: f64,
    broken: Option<String>,
}

/// Where findings of the smoke test are kept.
fn kept(target: &Target) -> PathBuf {
    std::env::temp_dir().join(format!("barbule-fuzz-finding-{}", target.name))
}

fn tried(target: &'static Target, seed: u64, executions: u64, folder: &Path) -> Row {
    let begun = Instant::now();
    let finding = folder.join(target.name);
    let ran = run(target, seed, executions, "quick", &finding);
    let (mut counts, mut broken) = ([0, 0], None);
    match ran {
        Ok((status, said, _)) if status.success() => {
            let mut numbers = said.split_whitespace().filter_map(|word| word.parse().ok());
            counts = [numbers.next().unwrap_or(0), numbers.next().unwrap_or(0)];
            if counts[1] == 0 {
                broken = Some(format!("{}: no input was accepted, so its seeds are none", target.name));
            }
        }
        Ok((status, _, why)) => {
            // Whatever ended the process without a word is found by writing each input down first.
            let was_silent = status.code().is_none_or(|code| code != 1 && code != SLOW);
            let again =
                was_silent.then(|| run(target, seed, executions, "traces", &finding)).and_then(Result::ok);
            let why = match (status.code(), again) {
                (Some(SLOW), _) => "an input took too long".to_owned(),
                (_, Some((_, _, more))) => format!("{status}: {}", more.lines().last().unwrap_or_default()),
                _ => why.lines().last().unwrap_or_default().to_owned(),
            };
            let place = kept(target);
            // Without the copy the line is still worth printing.
            let _ = std::fs::copy(&finding, &place);
            broken = Some(format!("{}: {why}; the input is in {}", target.name, place.display()));
        }
        Err(error) => broken = Some(format!("{}: {error}", target.name)),
    }
    let [executions, accepted] = counts;
    Row { name: target.name, executions, accepted, seconds: begun.elapsed().as_secs_f64(), broken }
}

/// A worker's end, what it printed, and what it complained of.
fn run(
    target: &Target,
    seed: u64,
    executions: u64,
    how: &str,
    finding: &Path,
) -> Result<(ExitStatus, String, String), String> {
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let mut command = Command::new(program);
    command.args(["work", target.name, &seed.to_string(), &executions.to_string(), how]).arg(finding);
    let output = command.output().map_err(|error| error.to_string())?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Ok((output.status, text(&output.stdout), text(&output.stderr)))
}
