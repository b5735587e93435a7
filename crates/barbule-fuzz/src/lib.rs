//! Fuzzing: whatever bytes a reader is given, it accepts or refuses them, and never worse.
//!
//! A [`Target`] is one reader with the laws that it must hold. Two drivers feed them: the own one of this crate, small and the same on every
//! machine, which `./test` runs for less than a minute; and libFuzzer in `fuzz/`, guided by coverage, for as long as anybody likes.
//! `docs/robustness.md` says how to run both and what came out.
//!
//! The laws, beside that nothing panics or aborts:
//!
//! - a refusal is one sentence of fewer than 600 characters without control characters, and of exit code 2;
//! - what is accepted comes back the same from the writer of its format, where there is one;
//! - memory stays under [`Target::most_bytes`], where the program counts it ([`memory::Counting`]);
//! - an input takes no longer than [`work::PATIENCE`].

pub mod laws;
pub mod memory;
pub mod mutate;
pub mod past;
pub mod scratch;
pub mod seal;
pub mod targets;
pub mod work;

pub use laws::{Held, Seen, Verdict};
pub use targets::{Target, all, find};

/// Examines one input under all laws of a target.
///
/// # Errors
/// A law is broken: says which.
pub fn examine(target: &Target, bytes: &[u8]) -> Verdict {
    let mark = memory::mark();
    let verdict = (target.check)(bytes);
    let taken = memory::most_since(mark);
    let most = target.most_bytes(bytes.len());
    if taken > most {
        return Err(format!(
            "took {taken} bytes of memory for an input of {} bytes, over the limit of {most}",
            bytes.len()
        ));
    }
    verdict
}
