//! The one error type of the library.
//!
//! A message is one sentence in lower case without a full stop: the user's own file and field first, then what was
//! found, what is allowed, and what to do. Whatever texts of users go into it, it is one line without control characters
//! of fewer than 600 bytes. Arguments of the call stand in it in backticks, and programs may call them otherwise.
//!
//! Beside the sentence an error carries, where they are known, the file that it is about, the key in it, line and column.

use std::fmt;
use std::path::{Path, PathBuf};

/// What went wrong, with a sentence for the user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    kind: Kind,
    message: String,
    about: Option<Box<About>>,
}

/// What a sentence is about, as data.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
struct About {
    file: Option<PathBuf>,
    key: Option<String>,
    line: Option<usize>,
    column: Option<usize>,
    arguments: &'static [&'static str],
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
        Self { kind, message: sentence(message), about: None }
    }

    fn saying(self, message: &str) -> Self {
        Self { message: sentence(message), ..self }
    }

    /// Changes what is known of the file's content, which once the file has a name stays: what is outside is about another one.
    fn placed(mut self, change: impl FnOnce(&mut About)) -> Self {
        if self.file().is_none() {
            change(self.about.get_or_insert_default());
        }
        self
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
        let message = format!("{place}: {}", self.message);
        self.saying(&message)
    }

    /// The same error with more behind its message.
    #[must_use]
    pub fn followed_by(self, more: &str) -> Self {
        let message = format!("{}{more}", self.message);
        self.saying(&message)
    }

    /// The same error, known to be about a key of a file, as in `lights[2].strength`.
    #[must_use]
    pub fn about(self, key: impl Into<String>) -> Self {
        self.placed(|about| about.key = Some(key.into()))
    }

    /// The same error, known to be about a line and a column of a text, both from 1.
    #[must_use]
    pub fn on_line(self, line: usize, column: Option<usize>) -> Self {
        self.placed(|about| (about.line, about.column) = (Some(line), column))
    }

    /// The same error about a line, from 1, whose number goes in front of its message.
    #[must_use]
    pub fn in_line(self, line: usize) -> Self {
        self.on_line(line, None).at(format!("line {line}"))
    }

    /// The same error, known to be about a file that its message names already. The innermost file is kept, which key, line
    /// and column are of.
    #[must_use]
    pub fn of_file(self, path: &Path) -> Self {
        self.placed(|about| about.file = Some(path.to_owned()))
    }

    /// The same error about a file, whose name goes in front of its message.
    #[must_use]
    pub fn in_file(self, path: &Path) -> Self {
        self.of_file(path).at(path.display())
    }

    /// The same error, whose message names these arguments of the call in backticks.
    #[must_use]
    pub fn naming(mut self, arguments: &'static [&'static str]) -> Self {
        self.about.get_or_insert_default().arguments = arguments;
        self
    }

    /// The message with the arguments of the call as somebody else calls them, without backticks.
    #[must_use]
    pub fn calling(&self, name: impl Fn(&str) -> String) -> String {
        let message = self.message.clone();
        let renamed = self
            .arguments()
            .iter()
            .fold(message, |message, argument| message.replace(&format!("`{argument}`"), &name(argument)));
        sentence(&renamed)
    }

    /// The arguments of the call that the message names.
    #[must_use]
    pub fn arguments(&self) -> &'static [&'static str] {
        self.about.as_ref().map_or(&[], |about| about.arguments)
    }

    /// The file that it is about; of nested ones the innermost.
    #[must_use]
    pub fn file(&self) -> Option<&Path> {
        self.about.as_ref()?.file.as_deref()
    }

    /// The key that it is about, as a path inside the file: `lights[2].strength`.
    #[must_use]
    pub fn key(&self) -> Option<&str> {
        self.about.as_ref()?.key.as_deref()
    }

    /// The line that it is about, from 1.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        self.about.as_ref()?.line
    }

    /// The column in that line, from 1.
    #[must_use]
    pub fn column(&self) -> Option<usize> {
        self.about.as_ref()?.column
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
/// stands as a word in `given`, as in `European-starling`, and the nearest of all is `given` with its unit: `width_mm` for `width`.
#[must_use]
pub fn did_you_mean<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    const UNITS: [&str; 4] = ["_um", "_nm", "_mm", "_deg"];
    let given = given.to_lowercase();
    let has_its_unit = |name: &str| name.strip_prefix(&given).is_some_and(|rest| UNITS.contains(&rest));
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
            let nearness = match distance {
                _ if has_its_unit(&lower) => 0,
                distance if !lower.is_empty() && is_word(&lower) => distance.min(1),
                distance => distance,
            };
            (nearness, distance, name)
        })
        // Of a word in it and a name that is but a letter away the latter is meant.
        .min_by_key(|(nearness, distance, _)| (*nearness, *distance))
        .filter(|(nearness, _, name)| *nearness <= 2.max(name.chars().count() / 2))
        .map_or_else(String::new, |(.., name)| format!(", did you mean '{name}'?"))
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
        assert_eq!(
            did_you_mean("starling-feathers", ["starling", "starling-feather"]),
            ", did you mean 'starling-feather'?"
        );
        assert_eq!(did_you_mean("starlingsandtheirfriends", ["mallard", "starling"]), "");
        assert_eq!(did_you_mean("cortex", ["core", "cortex_um", "vortex"]), ", did you mean 'cortex_um'?");
        assert_eq!(did_you_mean("tilt", ["tilt_spread", "tile", "tilt_deg"]), ", did you mean 'tilt_deg'?");
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
    fn what_is_known_of_the_innermost_file_stays_and_the_sentence_is_as_without() {
        let inner = Error::input("n is 0").about("n").on_line(3, Some(5)).in_file(Path::new("a.csv"));
        let outer =
            inner.at("lights[0].spectrum").about("lights[0].spectrum").in_file(Path::new("scene.toml"));
        assert_eq!(outer.to_string(), "scene.toml: lights[0].spectrum: a.csv: n is 0");
        assert_eq!(
            (outer.file(), outer.key(), outer.line(), outer.column()),
            (Some(Path::new("a.csv")), Some("n"), Some(3), Some(5))
        );
        let renamed = Error::input("x").about("parameters.x").about("variants[1].x");
        assert_eq!((renamed.key(), renamed.file(), renamed.line()), (Some("variants[1].x"), None, None));
        assert!(size_of::<Error>() <= 40, "an error is returned by everything: {} bytes", size_of::<Error>());
    }

    #[test]
    fn arguments_are_called_as_the_caller_calls_them_and_nothing_else_is() {
        let error = Error::input("give `unit` or `range_um`, not `unity`").naming(&["unit", "range_um"]);
        let called = error.calling(|name| format!("--{}", name.trim_end_matches("_um")));
        assert_eq!(called, "give --unit or --range, not `unity`");
        assert_eq!(error.at("a.png").arguments(), ["unit", "range_um"]);
        // Whatever a user's file has in backticks.
        assert_eq!(Error::input("unknown field `unit`").calling(|_| "--unit".into()), "unknown field `unit`");
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
