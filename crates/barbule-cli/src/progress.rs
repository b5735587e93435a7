//! A progress bar with the time left, on a terminal only, and Ctrl-C as a flag that long work looks at.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock};
use std::time::Duration;

use barbule::progress::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::common::Common;

static CANCELLED: AtomicBool = AtomicBool::new(false);

/// Watches long work for a command.
pub struct Terminal {
    bar: Mutex<ProgressBar>,
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
            let _ = ctrlc::set_handler(|| {
                if CANCELLED.swap(true, Ordering::SeqCst) {
                    std::process::exit(130);
                }
            });
        });
        let visible = !common.quiet && std::io::stderr().is_terminal();
        Self { bar: Mutex::new(ProgressBar::hidden()), visible, common: common.clone() }
    }

    fn with_bar<T>(&self, act: impl FnOnce(&mut ProgressBar) -> T) -> T {
        act(&mut self.bar.lock().unwrap_or_else(std::sync::PoisonError::into_inner))
    }
}

impl Progress for Terminal {
    fn begin(&self, label: &str, total: u64) {
        if !self.visible {
            return;
        }
        self.with_bar(|bar| {
            bar.finish_and_clear();
            *bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr());
            let template = "{msg:28} {wide_bar} {percent:>3} %  {elapsed} gone, {eta} left";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style);
            }
            bar.set_message(label.to_owned());
            bar.enable_steady_tick(Duration::from_millis(500));
        });
    }

    fn advance(&self, steps: u64) {
        if self.visible {
            self.with_bar(|bar| bar.inc(steps));
        }
    }

    fn is_cancelled(&self) -> bool {
        CANCELLED.load(Ordering::Relaxed)
    }

    fn note(&self, what: &str) {
        self.common.explain(what);
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        self.with_bar(|bar| bar.finish_and_clear());
    }
}
