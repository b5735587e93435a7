//! One stage over several parts whose own stages are not known beforehand.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use super::Progress;

/// Steps of the whole that one part has.
const STEPS: u64 = 1000;

/// Shows several pieces of work as one stage: each has the same part of it.
pub struct Several<'a> {
    whole: &'a dyn Progress,
}

/// The part of one piece of work.
pub struct Part<'a> {
    whole: &'a dyn Progress,
    /// Steps of the present stage: all, done.
    stage: Mutex<[u64; 2]>,
    /// Steps of the whole that have been shown.
    shown: AtomicU64,
}

impl<'a> Several<'a> {
    /// Begins the one stage of `whole`, of so many parts.
    #[must_use]
    pub fn begin(whole: &'a dyn Progress, label: &str, count: usize) -> Self {
        whole.begin(label, STEPS * count as u64);
        Self { whole }
    }

    /// The next piece of work's part; what it has not shown when it is dropped is shown then.
    #[must_use]
    pub fn part(&self) -> Part<'a> {
        Part { whole: self.whole, stage: Mutex::new([0, 0]), shown: AtomicU64::new(0) }
    }
}

impl Part<'_> {
    /// Moves the whole on to `steps` of this part; a later stage that starts over moves it only past what is shown.
    fn show(&self, steps: u64) {
        let before = self.shown.fetch_max(steps, Ordering::Relaxed);
        if steps > before {
            self.whole.advance(steps - before);
        }
    }
}

impl Progress for Part<'_> {
    fn begin(&self, _label: &str, total: u64) {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner) = [total, 0];
    }

    fn advance(&self, steps: u64) {
        let mut stage = self.stage.lock().unwrap_or_else(PoisonError::into_inner);
        stage[1] += steps;
        let [all, done] = *stage;
        drop(stage);
        self.show(STEPS.saturating_mul(done.min(all)) / all.max(1));
    }

    fn is_cancelled(&self) -> bool {
        self.whole.is_cancelled()
    }

    fn note(&self, what: &str) {
        self.whole.note(what);
    }

    fn doubt(&self, what: &str) {
        self.whole.doubt(what);
    }
}

impl Drop for Part<'_> {
    fn drop(&mut self) {
        self.show(STEPS);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Length and place of the whole.
    #[derive(Default)]
    struct Bar(AtomicU64, AtomicU64);

    impl Progress for Bar {
        fn begin(&self, _: &str, total: u64) {
            self.0.store(total, Ordering::Relaxed);
        }
        fn advance(&self, steps: u64) {
            self.1.fetch_add(steps, Ordering::Relaxed);
        }
        fn is_cancelled(&self) -> bool {
            false
        }
    }

    #[test]
    fn the_whole_never_goes_back_and_ends_full_whatever_stages_there_are() {
        let bar = Bar::default();
        let several = Several::begin(&bar, "three", 3);
        let at = || bar.1.load(Ordering::Relaxed);
        for stages in [&[4, 10][..], &[1], &[]] {
            let part = several.part();
            for &stage in stages {
                part.begin("x", stage);
                for _ in 0..stage {
                    let before = at();
                    part.advance(1);
                    assert!(at() >= before);
                }
            }
        }
        assert_eq!((bar.0.load(Ordering::Relaxed), at()), (3 * STEPS, 3 * STEPS));
    }
}
