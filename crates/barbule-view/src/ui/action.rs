//! What people do in the window, as values: whoever draws a part of it says what was done, and the window alone changes anything.

use std::fmt;

use crate::state::{Export, Mode, View};

/// Something that was done in the window.
pub enum Action {
    /// A slider was moved.
    Size {
        /// The slider's key.
        key: String,
        /// Where it is now, in its own unit.
        value: f64,
    },
    /// All sizes as they were at first.
    ResetSizes,
    /// The hand let go: the next change is another one to undo.
    Settle,
    /// It is looked at otherwise.
    Look {
        /// What people move, as `camera`: moves of the same are one change until [`Self::Settle`].
        what: &'static str,
        /// The change.
        change: Box<dyn FnOnce(&mut View)>,
    },
    /// Another mode, from where it looks best there.
    Choose(Mode),
    /// What is open is pinned to be compared with.
    Pin,
    /// What is pinned is taken away.
    Unpin,
    /// What is pinned is open, and the other way round.
    Swap,
    /// The last change is undone.
    Undo,
    /// What was undone last is done again.
    Redo,
    /// Something is opened by what people type.
    Open(String),
    /// A measured spectrum is taken away, by its place among them.
    TakeAway(usize),
    /// A file is to be written.
    Export(Export),
    /// The command that makes the picture, into the clipboard.
    CopyCommand,
    /// The material is to be made.
    MakeMaterial {
        /// All of it, which takes minutes; else a coarse one.
        whole: bool,
    },
    /// Whatever is computed stops.
    Stop,
}

impl Action {
    /// It is looked at otherwise.
    pub fn look(what: &'static str, change: impl FnOnce(&mut View) + 'static) -> Self {
        Self::Look { what, change: Box::new(change) }
    }
}

impl fmt::Debug for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size { key, value } => write!(f, "Size({key} = {value})"),
            Self::Look { what, .. } => write!(f, "Look({what})"),
            Self::Choose(mode) => write!(f, "Choose({})", mode.word()),
            Self::Open(text) => write!(f, "Open({text})"),
            Self::TakeAway(index) => write!(f, "TakeAway({index})"),
            Self::Export(export) => write!(f, "Export({})", export.name()),
            Self::MakeMaterial { whole } => write!(f, "MakeMaterial({whole})"),
            Self::ResetSizes => f.write_str("ResetSizes"),
            Self::Settle => f.write_str("Settle"),
            Self::Pin => f.write_str("Pin"),
            Self::Unpin => f.write_str("Unpin"),
            Self::Swap => f.write_str("Swap"),
            Self::Undo => f.write_str("Undo"),
            Self::Redo => f.write_str("Redo"),
            Self::CopyCommand => f.write_str("CopyCommand"),
            Self::Stop => f.write_str("Stop"),
        }
    }
}
