//! What work takes, before it is done.

/// The program itself with its data, and what allocators keep, bytes.
pub const PROGRAM: u64 = 48 << 20;

/// What work takes, foretold.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Cost {
    /// Memory at most at once, bytes.
    pub bytes: u64,
    /// About how long on the threads that it was asked for, s; `None` where that is short or not known.
    pub seconds: Option<f64>,
    /// Unknown numbers of the largest system of equations; 0 where none is solved.
    pub unknowns: usize,
}

impl Cost {
    /// Of one work after the other.
    #[must_use]
    pub fn then(self, next: Self) -> Self {
        let seconds = [self.seconds, next.seconds].into_iter().flatten();
        Self {
            bytes: self.bytes.max(next.bytes),
            seconds: seconds.reduce(|a, b| a + b),
            unknowns: self.unknowns.max(next.unknowns),
        }
    }
}
