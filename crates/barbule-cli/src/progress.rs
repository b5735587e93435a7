//! A progress bar with the time left, on a terminal only, and Ctrl-C as a flag that long work looks at.

use std::io::{IsTerminal, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use barbule::Error;
use barbule::progress::{Progress, left};
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use crate::common::Common;

static CANCELLED: AtomicBool = AtomicBool::new(false);

/// Signals this soon after the first are the same press: some programs send it to the process and to its group.
const SAME_PRESS: Duration = Duration::from_millis(300);

/// What Ctrl-C does now. One for the process, as its signals are.
static NOW: Mutex<Now> =
    Mutex::new(Now { pressed: None, bar: None, quiet: false, words: PLAIN, writes_nothing: false });

/// How long work that writes nothing has to end by itself: parts of it, as in the library that makes hierarchies, ask nobody.
const PATIENCE: Duration = Duration::from_millis(300);

struct Now {
    /// When Ctrl-C came first.
    pressed: Option<Instant>,
    /// The bar that stands on the terminal.
    bar: Option<ProgressBar>,
    quiet: bool,
    words: Words,
    /// Whether the work may be ended anywhere: it writes nothing.
    writes_nothing: bool,
}

/// What is said after Ctrl-C.
#[derive(Debug, Clone, Copy)]
struct Words {
    first: &'static str,
    second: &'static str,
}

const PLAIN: Words =
    Words { first: "stopping … Ctrl-C again to end at once", second: "interrupted, ended at once" };
const KEEPING: Words = Words {
    first: "writing what is done … Ctrl-C again to discard it",
    second: "interrupted, what was done since is discarded",
};

fn now() -> MutexGuard<'static, Now> {
    NOW.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Watches long work for a command.
pub struct Terminal {
    visible: bool,
    common: Common,
}

impl Terminal {
    /// Starts to listen for Ctrl-C (once a process) and shows bars on a terminal unless `--quiet`.
    #[must_use]
    pub fn new(common: &Common) -> Self {
        static LISTENING: OnceLock<()> = OnceLock::new();
        LISTENING.get_or_init(|| {
            // Where no handler can be set, Ctrl-C ends the program at once, as it does without one.
            let _ = ctrlc::set_handler(pressed);
        });
        let mut now = now();
        (now.quiet, now.words, now.writes_nothing) = (common.quiet, PLAIN, false);
        let visible = !common.quiet && std::io::stderr().is_terminal();
        Self { visible, common: common.clone() }
    }

    /// The same for work that writes nothing, as long as this lives: where it does not stop soon, Ctrl-C ends the program.
    #[must_use]
    pub fn writing_nothing(self) -> Self {
        now().writes_nothing = true;
        self
    }

    /// The same for work whose state is written after the first Ctrl-C, which then says so.
    #[must_use]
    pub fn keeping_what_is_done(self) -> Self {
        now().words = KEEPING;
        self
    }
}

/// Ctrl-C: the first asks the work to stop, one more ends the program.
fn pressed() {
    let mut now = now();
    let Now { pressed, bar, quiet, words, .. } = &mut *now;
    let say = |text: &str| {
        let write = || {
            let _ = writeln!(std::io::stderr(), "{text}");
        };
        match &*bar {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
    };
    match meaning(*pressed, Instant::now()) {
        Press::Stop => {
            *pressed = Some(Instant::now());
            CANCELLED.store(true, Ordering::SeqCst);
            if !*quiet {
                say(words.first);
            }
            // Held back by the lock as long as this.
            std::thread::spawn(end_what_writes_nothing);
        }
        Press::Same => {}
        Press::End => {
            say(&format!("barbule: {}", words.second));
            std::process::exit(130);
        }
    }
}

/// Ends the program, if after a while it is still at work that writes nothing.
fn end_what_writes_nothing() {
    std::thread::sleep(PATIENCE);
    // No such work ends while this is held, so that nothing is begun to be written.
    let now = now();
    if now.writes_nothing {
        if let Some(bar) = &now.bar {
            bar.finish_and_clear();
        }
        let _ = writeln!(std::io::stderr(), "barbule: {}", Error::interrupted());
        std::process::exit(130);
    }
}

/// What a signal means.
#[derive(Debug, PartialEq, Eq)]
enum Press {
    /// The work should stop.
    Stop,
    /// The signal before it, once more.
    Same,
    /// The program should end.
    End,
}

fn meaning(first: Option<Instant>, now: Instant) -> Press {
    match first {
        None => Press::Stop,
        Some(first) if now.saturating_duration_since(first) < SAME_PRESS => Press::Same,
        Some(_) => Press::End,
    }
}

fn style() -> Option<ProgressStyle> {
    let template = "{msg:28} {wide_bar} {percent:>3} %  {elapsed} gone{left}";
    let write_left = |state: &ProgressState, out: &mut dyn std::fmt::Write| {
        if let Some(left) = left(state.pos(), state.len().unwrap_or(0), state.elapsed()) {
            // A line of a bar that cannot be written is drawn without.
            let _ = write!(out, ", {:#} left", HumanDuration(left));
        }
    };
    Some(ProgressStyle::with_template(template).ok()?.with_key("left", write_left))
}

impl Progress for Terminal {
    fn begin(&self, label: &str, total: u64) {
        if !self.visible {
            return;
        }
        let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr());
        if let Some(style) = style() {
            bar.set_style(style);
        }
        bar.set_message(label.to_owned());
        bar.enable_steady_tick(Duration::from_millis(500));
        if let Some(before) = now().bar.replace(bar) {
            before.finish_and_clear();
        }
    }

    fn advance(&self, steps: u64) {
        if self.visible
            && let Some(bar) = &now().bar
        {
            bar.inc(steps);
        }
    }

    fn is_cancelled(&self) -> bool {
        CANCELLED.load(Ordering::Relaxed)
    }

    fn note(&self, what: &str) {
        aside(|| self.common.explain(what));
    }

    fn doubt(&self, what: &str) {
        aside(|| self.common.say(what));
    }
}

/// Writes beside a bar.
fn aside(write: impl FnOnce()) {
    match &now().bar {
        Some(bar) => bar.suspend(write),
        None => write(),
    }
}

/// Says what is doubtful about work that is too short to be watched or stopped.
pub(crate) struct Doubts<'a>(pub(crate) &'a Common);

impl Progress for Doubts<'_> {
    fn begin(&self, _label: &str, _total: u64) {}
    fn advance(&self, _steps: u64) {}
    fn is_cancelled(&self) -> bool {
        false
    }
    fn doubt(&self, what: &str) {
        self.0.say(what);
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let mut now = now();
        now.writes_nothing = false;
        if let Some(bar) = now.bar.take() {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_press_stops_its_echo_is_nothing_and_another_press_ends() {
        let first = Instant::now();
        let later = |milliseconds| meaning(Some(first), first + Duration::from_millis(milliseconds));
        assert_eq!(meaning(None, first), Press::Stop);
        assert_eq!([later(0), later(200), later(400)], [Press::Same, Press::Same, Press::End]);
    }
}
