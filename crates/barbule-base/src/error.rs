//! The one error type of the library.
//!
//! A message is one sentence in lower case without a full stop: the user's own file and field first, then what was
//! found, what is allowed, and what to do. Whatever texts of users go into it, it is one line without control characters
//! of fewer than 600 bytes.

use std::fmt;

/// What went wrong, with a sentence for the user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    kind: Kind,
    message: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Input,
    Machine,
    NotSettled,
    Interrupted,
}

/// The result of anything in this library that can fail.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    fn of(kind: Kind, message: &str) -> Self {
        Self { kind, message: sentence(message) }
    }

    /// Something that the user can mend: an argument, a file's contents, a missing or unwritable file.
    pub fn input(message: impl Into<String>) -> Self {
        Self::of(Kind::Input, &message.into())
    }

    /// The machine's fault: a full disk, a failed read in the middle of a file.
    pub fn machine(message: impl Into<String>) -> Self {
        Self::of(Kind::Machine, &message.into())
    }

    /// A computation that did not reach its accuracy.
    pub fn not_settled(message: impl Into<String>) -> Self {
        Self::of(Kind::NotSettled, &message.into())
    }

    /// The user asked to stop.
    #[must_use]
    pub fn interrupted() -> Self {
        Self::of(Kind::Interrupted, "interrupted")
    }

    /// The user asked to stop: what was done by then, and how it goes on.
    #[must_use]
    pub fn interrupted_after(done: impl fmt::Display) -> Self {
        Self::of(Kind::Interrupted, &format!("interrupted: {done}"))
    }

    /// The same error with a place in front of its message: `name: message`.
    #[must_use]
    pub fn at(self, place: impl fmt::Display) -> Self {
        Self::of(self.kind, &format!("{place}: {}", self.message))
    }

    /// The same error with more behind its message.
    #[must_use]
    pub fn followed_by(self, more: &str) -> Self {
        Self::of(self.kind, &format!("{}{more}", self.message))
    }

    /// Whether the user can mend it.
    #[must_use]
    pub fn is_input(&self) -> bool {
        self.kind == Kind::Input
    }

    /// Whether a computation did not reach its accuracy.
    #[must_use]
    pub fn is_not_settled(&self) -> bool {
        self.kind == Kind::NotSettled
    }

    /// Whether the user asked to stop.
    #[must_use]
    pub fn is_interrupted(&self) -> bool {
        self.kind == Kind::Interrupted
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Error {}

/// `, did you mean 'x'?` with the known name nearest to `given`, or nothing when none is near. A name is near too that
/// stands as a word in `given`, as in `European-starling`.
#[must_use]
pub fn did_you_mean<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let given = given.to_lowercase();
    let is_word = |name: &str| {
        let ends = |c: Option<char>| !c.is_some_and(char::is_alphanumeric);
        given.match_indices(name).any(|(at, found)| {
            ends(given[..at].chars().next_back()) && ends(given[at + found.len()..].chars().next())
        })
    };
    known
        .into_iter()
        .map(|name| {
            let lower = name.to_lowercase();
            let distance = strsim::damerau_levenshtein(&given, &lower);
            (if !lower.is_empty() && is_word(&lower) { distance.min(1) } else { distance }, name)
        })
        .min_by_key(|(distance, _)| *distance)
        .filter(|(distance, name)| *distance <= 2.max(name.chars().count() / 2))
        .map_or_else(String::new, |(_, name)| format!(", did you mean '{name}'?"))
}

/// A user's text short enough for a message, on one line and without control characters.
#[must_use]
pub fn shortened(text: &str) -> String {
    const LONGEST: usize = 80;
    let clean: String = text.chars().take(LONGEST + 1).map(visible).collect();
    if clean.chars().count() <= LONGEST {
        return clean;
    }
    clean.chars().take(LONGEST - 1).chain(['…']).collect()
}

/// Bytes of a sentence, at most: a program's name in front of it still fits into 600.
const LONGEST_SENTENCE: usize = 580;

/// A message on one line, without control characters. What is too long loses its middle: the place stands in front, the
/// reason and the remedy at the end.
#[must_use]
pub fn sentence(text: &str) -> String {
    const MARK: &str = " … ";
    const FRONT: usize = 200;
    if text.len() <= LONGEST_SENTENCE {
        return text.chars().map(visible).collect();
    }
    let front = &text[..text.floor_char_boundary(FRONT)];
    let end = &text[text.ceil_char_boundary(text.len() - (LONGEST_SENTENCE - FRONT - MARK.len()))..];
    [front, MARK, end].concat().chars().map(visible).collect()
}

/// A character that neither moves a terminal's cursor, nor ends a line, nor turns the direction of what follows; others
/// become blanks.
#[must_use]
pub fn visible(c: char) -> char {
    let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    if c.is_control() || turns { ' ' } else { c }
}

/// A number of things in words: `1 angle`, `2 angles`.
#[must_use]
pub fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_name_is_offered_and_far_ones_are_not() {
        assert_eq!(did_you_mean("starlign", ["mallard", "starling"]), ", did you mean 'starling'?");
        assert_eq!(did_you_mean("qqqqqqqqqqqq", ["mallard", "starling"]), "");
        assert_eq!(did_you_mean("European-Starling", ["mallard", "starling"]), ", did you mean 'starling'?");
        assert_eq!(did_you_mean("starlingsandtheirfriends", ["mallard", "starling"]), "");
    }

    #[test]
    fn one_thing_is_not_several() {
        assert_eq!((counted(1, "angle"), counted(0, "angle")), ("1 angle".into(), "0 angles".into()));
    }

    #[test]
    fn a_place_goes_in_front_and_keeps_the_kind() {
        let error = Error::input("width is 0").at("a.json");
        assert_eq!(error.to_string(), "a.json: width is 0");
        assert!(error.is_input());
    }

    #[test]
    fn whatever_a_user_typed_a_message_is_one_short_line() {
        for typed in ["a\nb\r\u{1b}[31mred\u{202e}", &"9".repeat(10_000_000), &"µ".repeat(2000), "", "\u{0}"]
        {
            for error in
                [Error::input(typed), Error::machine("no").at(typed), Error::not_settled(typed).at(typed)]
            {
                let text = error.to_string();
                assert!(text.len() <= LONGEST_SENTENCE && !text.chars().any(char::is_control), "{text}");
            }
            assert!(shortened(typed).chars().count() <= 80 && !shortened(typed).contains('\u{1b}'));
        }
        let text = Error::input("is empty; give a name").at("x".repeat(5000)).to_string();
        assert!(
            text.starts_with("xxx") && text.ends_with("x: is empty; give a name") && text.contains(" … ")
        );
        // A short one stays as it is.
        assert_eq!(Error::input("µ is 5 … 7").to_string(), "µ is 5 … 7");
    }
}
