//! Where the key of a path stands in a text, whatever its format.

use crate::Error;

/// A parsed text whose parts know the bytes where they begin.
pub(super) trait Tree<'t>: Copy + 't {
    /// The keys of a table: each with the byte where it begins, and its value; none of anything else.
    fn keys(self) -> Box<dyn Iterator<Item = (&'t str, usize, Self)> + 't>;

    /// An item of a list with the byte where it begins.
    fn item(self, index: usize) -> Option<(usize, Self)>;
}

/// A key in a text.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Spot {
    /// Its path, as in `variants[7].name`.
    pub(super) key: String,
    /// From 1.
    pub(super) line: usize,
    /// In letters from 1.
    pub(super) column: usize,
}

impl Spot {
    /// The innermost key of a path such as `variants[7].name`; what follows the path, as in a message, does not matter.
    pub(super) fn find<'t>(root: impl Tree<'t>, text: &str, path: &str) -> Option<Self> {
        let (mut here, mut rest, mut key, mut start) = (root, path, String::new(), None);
        loop {
            // A message about an unknown key names its table first.
            let unknown = rest.strip_prefix(": ").unwrap_or(rest).strip_prefix("unknown key '");
            let name = unknown.unwrap_or(rest);
            let Some((found, at, value)) =
                here.keys().filter(|(key, ..)| starts_with_key(name, key)).max_by_key(|(key, ..)| key.len())
            else {
                break;
            };
            key += if key.is_empty() { "" } else { "." };
            key += found;
            (here, rest, start) = (value, &name[found.len()..], Some(at));
            while let Some((index, after)) = rest.strip_prefix('[').and_then(|inner| inner.split_once(']')) {
                let Some((at, item)) = index.parse().ok().and_then(|index| here.item(index)) else { break };
                key += &format!("[{index}]");
                (here, rest, start) = (item, after, Some(at));
            }
            rest = rest.strip_prefix('.').unwrap_or(rest);
        }
        let (line, column) = line_and_column(text, start?);
        Some(Self { key, line, column })
    }

    /// An error about this key; one that knows a key inside it, as one that is missing, keeps that.
    pub(super) fn mark(self, error: Error) -> Error {
        let Self { key, line, column } = self;
        let is_inside = error.key().is_some_and(|known| known.starts_with(&key));
        let error = if is_inside { error } else { error.about(key) };
        error.on_line(line, Some(column))
    }
}

fn starts_with_key(text: &str, key: &str) -> bool {
    let goes_on = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    !key.is_empty() && text.strip_prefix(key).is_some_and(|rest| !rest.starts_with(goes_on))
}

/// The line, and the column in letters, of a byte, both from 1.
pub(super) fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let before = &text[..text.floor_char_boundary(byte)];
    let line = before.rsplit('\n').next().unwrap_or_default();
    (before.matches('\n').count() + 1, line.chars().count() + 1)
}
