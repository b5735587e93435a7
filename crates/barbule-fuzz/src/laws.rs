//! What holds of every reader.

use barbule::{Error, Result};

/// What a reader made of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// It was read.
    Accepted,
    /// It was refused, in one sentence.
    Refused,
}

/// What a reader made of an input, or which law it broke.
pub type Verdict = std::result::Result<Seen, String>;

/// Whether a law holds, or how it is broken.
pub type Held = std::result::Result<(), String>;

/// The most characters of a refusal.
const MOST_LETTERS: usize = 600;

/// A refusal as the command line prints it: one sentence, short, without control characters, and the user's to mend.
///
/// # Errors
/// It is none.
pub fn refusal(error: &Error) -> Held {
    if !error.is_input() {
        return Err(format!("an input is refused as a failure of the machine: {error}"));
    }
    sentence(&error.to_string())
}

/// A message to people.
///
/// # Errors
/// It is empty, long, or has control characters.
pub fn sentence(text: &str) -> Held {
    let letters = text.chars().count();
    if text.trim().is_empty() {
        return Err("the refusal is empty".into());
    }
    if letters >= MOST_LETTERS {
        return Err(format!("the refusal has {letters} characters: {text:.300}"));
    }
    match text.chars().find(|letter| letter.is_control()) {
        Some(letter) => Err(format!("the refusal has the control character {letter:?}: {text:?}")),
        None => Ok(()),
    }
}

/// A refusal that keeps its laws, or a value that keeps those of `further`.
///
/// # Errors
/// Either does not.
pub fn judged<T>(found: Result<T>, further: impl FnOnce(T) -> Held) -> Verdict {
    match found {
        Ok(value) => further(value).map(|()| Seen::Accepted),
        Err(error) => refusal(&error).map(|()| Seen::Refused),
    }
}

/// What was accepted is written, read and written again: to the same bytes.
///
/// # Errors
/// It cannot be written, what was written is refused, or it comes back as something else.
pub fn comes_back<T>(
    value: &T,
    write: impl Fn(&T) -> Result<Vec<u8>>,
    read: impl Fn(&[u8]) -> Result<T>,
) -> Held {
    let show = |bytes: &[u8]| String::from_utf8_lossy(bytes).chars().take(400).collect::<String>();
    let first = write(value).map_err(|error| format!("what was accepted cannot be written: {error}"))?;
    let back = read(&first)
        .map_err(|error| format!("what was written is refused: {error}; it begins {:?}", show(&first)))?;
    let second = write(&back).map_err(|error| format!("what came back cannot be written: {error}"))?;
    if first == second {
        return Ok(());
    }
    let at = first.iter().zip(&second).take_while(|(a, b)| a == b).count();
    let near =
        |bytes: &[u8]| show(&bytes[at.saturating_sub(60).min(bytes.len())..(at + 60).min(bytes.len())]);
    Err(format!("it comes back changed at byte {at}: {:?} became {:?}", near(&first), near(&second)))
}

/// A law that is a condition.
///
/// # Errors
/// It does not hold: `what` says how.
pub fn holds(condition: bool, what: impl FnOnce() -> String) -> Held {
    if condition { Ok(()) } else { Err(what()) }
}
