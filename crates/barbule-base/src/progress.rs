//! How long work is shared out, reports its progress and learns that it should stop. The library itself never prints.

mod several;
mod shard;
mod shared;

use std::time::Duration;

pub use several::{Part, Several};
pub use shard::{MOST_SHARDS, Shard};
pub use shared::{Shared, Snapshot, left};

/// Time since any moment. Whoever calls has it: a browser's is not the system's.
pub type Clock = fn() -> Duration;

/// For whom no time counts.
pub const NO_CLOCK: Clock = || Duration::ZERO;

/// Watches a long computation. Called from any thread.
pub trait Progress: Sync {
    /// A stage with `total` equal steps begins; `label` says what it is in a few words.
    fn begin(&self, label: &str, total: u64);
    /// `steps` more steps are done.
    fn advance(&self, steps: u64);
    /// Whether to stop: work then ends with [`Error::interrupted`](crate::Error::interrupted) and a resumable state.
    fn is_cancelled(&self) -> bool;
    /// Something was decided that explains what happens, for example that a table was found in a cache.
    fn note(&self, _what: &str) {}
    /// What was given is done as it says, but probably meant otherwise, or something that was wished for is left out.
    fn doubt(&self, what: &str) {
        self.note(what);
    }
}

/// Passes on nothing but the wish to stop: for a part of work whose progress is told as a whole.
pub struct OnlyStops<'a>(pub &'a dyn Progress);

impl Progress for OnlyStops<'_> {
    fn begin(&self, _label: &str, _total: u64) {}
    fn advance(&self, _steps: u64) {}
    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}

/// Watches nothing and never stops.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unobserved;

impl Progress for Unobserved {
    fn begin(&self, _label: &str, _total: u64) {}
    fn advance(&self, _steps: u64) {}
    fn is_cancelled(&self) -> bool {
        false
    }
}
