//! The system's time, for what the libraries below measure and limit: they also run where the system is a browser.

use std::sync::LazyLock;
use std::time::{Duration, Instant, SystemTime};

/// Time since it was first asked for.
#[must_use]
pub fn system() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}

/// The time of day: what files say of when they were written is held against it.
#[must_use]
pub fn now() -> SystemTime {
    SystemTime::now()
}
