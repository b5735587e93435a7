//! Progress that any thread may look at while others work.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::Progress;

/// How far work is, for whoever watches it from another thread, and a way to stop it. Steps are counted without a lock.
///
/// ```
/// use barbule_base::progress::{Progress, Shared};
///
/// let shared = Shared::default();
/// std::thread::scope(|scope| {
///     scope.spawn(|| {
///         shared.begin("simulating", 4);
///         (0..3).for_each(|_| shared.advance(1));
///     });
/// });
/// let now = shared.snapshot();
/// assert_eq!((now.label.as_str(), now.fraction()), ("simulating", 0.75));
/// ```
#[derive(Debug, Default)]
pub struct Shared {
    stage: Mutex<Stage>,
    done: AtomicU64,
    is_cancelled: AtomicBool,
}

/// What [`Progress::begin`] says, and how often it did.
#[derive(Debug, Default)]
struct Stage {
    number: u64,
    label: String,
    total: u64,
}

/// How far work is at a moment.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Snapshot {
    /// Which stage this is, from 1; 0 before the first. A clock of the stage starts anew where it rises.
    pub stage: u64,
    /// What the stage is.
    pub label: String,
    /// Steps of the stage that are done; never more than all.
    pub done: u64,
    /// Steps of the stage.
    pub total: u64,
}

impl Shared {
    /// Asks the work to stop.
    pub fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// How far the present stage is.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let Stage { number, label, total } = &*self.stage();
        let done = self.done.load(Ordering::Relaxed).min(*total);
        Snapshot { stage: *number, label: label.clone(), done, total: *total }
    }

    fn stage(&self) -> MutexGuard<'_, Stage> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Progress for Shared {
    fn begin(&self, label: &str, total: u64) {
        let mut stage = self.stage();
        *stage = Stage { number: stage.number + 1, label: label.to_owned(), total };
        // Still under the lock: no snapshot sees the steps of one stage as those of the next.
        self.done.store(0, Ordering::Relaxed);
    }

    fn advance(&self, steps: u64) {
        self.done.fetch_add(steps, Ordering::Relaxed);
    }

    fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }
}

impl Snapshot {
    /// The part of the stage that is done, 0 to 1; a stage without steps is done.
    #[must_use]
    pub fn fraction(&self) -> f64 {
        match (self.stage, self.total) {
            (0, _) => 0.0,
            (_, 0) => 1.0,
            (_, total) => self.done as f64 / total as f64,
        }
    }

    /// The time that is left of a stage that has run for `elapsed`, at the pace so far; unknown before the first step and
    /// after the last.
    #[must_use]
    pub fn left(&self, elapsed: Duration) -> Option<Duration> {
        left(self.done, self.total, elapsed)
    }
}

/// The time that is left where `done` of `total` steps took `elapsed`, at that pace; unknown before the first step and after
/// the last.
#[must_use]
pub fn left(done: u64, total: u64, elapsed: Duration) -> Option<Duration> {
    if done == 0 || done >= total {
        return None;
    }
    Duration::try_from_secs_f64(elapsed.as_secs_f64() * (total - done) as f64 / done as f64).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_many_threads_are_all_counted_and_a_stage_starts_over() {
        let shared = Shared::default();
        assert_eq!((shared.snapshot(), shared.snapshot().fraction()), (Snapshot::default(), 0.0));
        shared.begin("first", 4000);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..500).for_each(|_| shared.advance(1)));
            }
        });
        let half = Snapshot { stage: 1, label: "first".into(), done: 2000, total: 4000 };
        assert_eq!((shared.snapshot(), half.fraction()), (half.clone(), 0.5));
        shared.begin("second", 3);
        assert_eq!(shared.snapshot(), Snapshot { stage: 2, label: "second".into(), done: 0, total: 3 });
        // Work that takes more steps than it said is not over done.
        shared.advance(5);
        assert_eq!((shared.snapshot().done, shared.snapshot().fraction()), (3, 1.0));
        shared.begin("nothing", 0);
        assert_eq!(shared.snapshot().fraction(), 1.0);
    }

    #[test]
    fn whoever_watches_stops_the_work() {
        let shared = Shared::default();
        std::thread::scope(|scope| {
            let work = scope.spawn(|| {
                shared.begin("endless", u64::MAX);
                while !shared.is_cancelled() {
                    shared.advance(1);
                }
            });
            while shared.snapshot().done == 0 {
                std::thread::yield_now();
            }
            shared.cancel();
            work.join().unwrap();
        });
        assert!(shared.is_cancelled() && shared.snapshot().stage == 1);
    }

    #[test]
    fn the_time_left_follows_the_pace_and_is_not_guessed_without_one() {
        let left = |done, total, elapsed| {
            Snapshot { done, total, ..Snapshot::default() }.left(Duration::from_secs(elapsed))
        };
        assert_eq!(left(0, 100, 3), None);
        assert_eq!(left(25, 100, 3), Some(Duration::from_secs(9)));
        assert_eq!(left(100, 100, 3), None);
        assert_eq!(left(1, u64::MAX, u64::MAX / 2), None);
    }
}
