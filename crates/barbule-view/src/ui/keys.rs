//! The keyboard: one table of keys, what they do, and how the help calls them.

use eframe::egui::{self, Key, KeyboardShortcut, Modifiers};

use super::action::Action;
use crate::state::{Mode, Shown, State};

/// Degrees that an arrow turns the camera or moves the light by.
const STEP_DEG: f64 = 5.0;
/// The picture's width before and after a step of the zoom.
const STEP_ZOOM: f64 = 1.15;

/// What a key asks for.
#[derive(Debug)]
pub(super) enum Wish {
    /// Something that is done anywhere in the window.
    Do(Action),
    /// The help opens, or closes.
    Help,
    /// The box in which people type what to open.
    Find,
    /// Whatever is in front closes; else what is computed stops.
    Leave,
    /// Nothing there is.
    Nothing,
}

/// A key and what it does.
pub(super) struct Row {
    /// How the help calls it.
    pub keys: &'static str,
    /// What it does, in the words of the help.
    pub does: &'static str,
    /// Keys with their modifiers.
    shortcuts: &'static [KeyboardShortcut],
    wish: fn(&State) -> Wish,
}

const fn plain(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::NONE, key)
}

const fn shift(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::SHIFT, key)
}

const fn ctrl(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::COMMAND, key)
}

const CTRL_SHIFT_Z: KeyboardShortcut =
    KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z);

/// All keys. What has more modifiers stands first: it would be taken for what has fewer.
pub(super) const ROWS: &[Row] = &[
    Row {
        keys: "Ctrl+Shift+Z, Ctrl+Y",
        does: "does again what was undone",
        shortcuts: &[CTRL_SHIFT_Z, ctrl(Key::Y)],
        wish: |_| Wish::Do(Action::Redo),
    },
    Row {
        keys: "Ctrl+Z",
        does: "undoes the last change",
        shortcuts: &[ctrl(Key::Z)],
        wish: |_| Wish::Do(Action::Undo),
    },
    Row {
        keys: "Ctrl+O, /",
        does: "types what to open",
        shortcuts: &[ctrl(Key::O), plain(Key::Slash)],
        wish: |_| Wish::Find,
    },
    Row {
        keys: "Ctrl+S",
        does: "saves the viewer as it is",
        shortcuts: &[ctrl(Key::S)],
        wish: |_| Wish::Do(Action::Export(crate::state::Export::State)),
    },
    Row {
        keys: "1",
        does: "shows it on a sphere",
        shortcuts: &[plain(Key::Num1)],
        wish: |_| mode(Mode::Sphere),
    },
    Row {
        keys: "2",
        does: "shows it as a bent piece of vane",
        shortcuts: &[plain(Key::Num2)],
        wish: |_| mode(Mode::Vane),
    },
    Row {
        keys: "3",
        does: "shows it as a feather",
        shortcuts: &[plain(Key::Num3)],
        wish: |_| mode(Mode::Feather),
    },
    Row {
        keys: "4",
        does: "shows it on a snake",
        shortcuts: &[plain(Key::Num4)],
        wish: |_| mode(Mode::Snake),
    },
    Row {
        keys: "5",
        does: "traces its scene by the renderer",
        shortcuts: &[plain(Key::Num5)],
        wish: |_| mode(Mode::Scene),
    },
    Row {
        keys: "I",
        does: "shows individuals, or their mean",
        shortcuts: &[plain(Key::I)],
        wish: |state| {
            let shown = match state.view().shown {
                Shown::Mean => Shown::Individuals,
                Shown::Individuals => Shown::Mean,
            };
            look("individuals", move |view| view.shown = shown)
        },
    },
    Row {
        keys: "P",
        does: "pins what is open to compare with, or takes the pinned one away",
        shortcuts: &[plain(Key::P)],
        wish: |state| Wish::Do(if state.pinned().is_some() { Action::Unpin } else { Action::Pin }),
    },
    Row {
        keys: "X",
        does: "swaps what is open and what is pinned",
        shortcuts: &[plain(Key::X)],
        wish: |state| if state.pinned().is_some() { Wish::Do(Action::Swap) } else { Wish::Nothing },
    },
    Row {
        keys: "R",
        does: "puts the camera back",
        shortcuts: &[plain(Key::R)],
        wish: |state| mode(state.view().mode),
    },
    Row {
        keys: "Shift+M",
        does: "makes the whole material, in minutes",
        shortcuts: &[shift(Key::M)],
        wish: |_| Wish::Do(Action::MakeMaterial { whole: true }),
    },
    Row {
        keys: "M",
        does: "makes a coarse material of what is open",
        shortcuts: &[plain(Key::M)],
        wish: |_| Wish::Do(Action::MakeMaterial { whole: false }),
    },
    Row {
        keys: "S",
        does: "writes the picture as a file",
        shortcuts: &[plain(Key::S)],
        wish: |_| Wish::Do(Action::Export(crate::state::Export::Picture)),
    },
    Row {
        keys: "C",
        does: "copies the command that makes the picture",
        shortcuts: &[plain(Key::C)],
        wish: |_| Wish::Do(Action::CopyCommand),
    },
    Row {
        keys: "Shift+Left",
        does: "moves the light to the left",
        shortcuts: &[shift(Key::ArrowLeft)],
        wish: |_| light([-1.0, 0.0]),
    },
    Row {
        keys: "Shift+Right",
        does: "moves the light to the right",
        shortcuts: &[shift(Key::ArrowRight)],
        wish: |_| light([1.0, 0.0]),
    },
    Row {
        keys: "Shift+Up",
        does: "moves the light up",
        shortcuts: &[shift(Key::ArrowUp)],
        wish: |_| light([0.0, 1.0]),
    },
    Row {
        keys: "Shift+Down",
        does: "moves the light down",
        shortcuts: &[shift(Key::ArrowDown)],
        wish: |_| light([0.0, -1.0]),
    },
    Row {
        keys: "Left",
        does: "turns the camera to the left",
        shortcuts: &[plain(Key::ArrowLeft)],
        wish: |_| orbit([1.0, 0.0]),
    },
    Row {
        keys: "Right",
        does: "turns the camera to the right",
        shortcuts: &[plain(Key::ArrowRight)],
        wish: |_| orbit([-1.0, 0.0]),
    },
    Row {
        keys: "Up",
        does: "turns the camera up",
        shortcuts: &[plain(Key::ArrowUp)],
        wish: |_| orbit([0.0, 1.0]),
    },
    Row {
        keys: "Down",
        does: "turns the camera down",
        shortcuts: &[plain(Key::ArrowDown)],
        wish: |_| orbit([0.0, -1.0]),
    },
    Row {
        keys: "+",
        does: "comes nearer",
        shortcuts: &[plain(Key::Plus), plain(Key::Equals)],
        wish: |_| look("zoom", |view| view.camera = view.camera.zoomed(1.0 / STEP_ZOOM)),
    },
    Row {
        keys: "-",
        does: "goes farther away",
        shortcuts: &[plain(Key::Minus)],
        wish: |_| look("zoom", |view| view.camera = view.camera.zoomed(STEP_ZOOM)),
    },
    Row {
        keys: "? or F1",
        does: "opens and closes this help",
        shortcuts: &[plain(Key::Questionmark), plain(Key::F1)],
        wish: |_| Wish::Help,
    },
    Row {
        keys: "Esc",
        does: "closes what is in front, else stops what is computed",
        shortcuts: &[plain(Key::Escape)],
        wish: |_| Wish::Leave,
    },
];

/// What is done with the mouse or with fingers, for the help.
pub(super) const HANDS: &[(&str, &str)] = &[
    ("drag", "turns the camera"),
    ("drag with L held, or drag the sun", "moves the light"),
    ("right drag, or two fingers", "moves the picture"),
    ("wheel, or pinch", "comes nearer or goes farther away"),
    ("double click", "puts the camera back"),
    ("drop a file", "opens it, or draws a measured spectrum beside what is computed"),
];

fn mode(mode: Mode) -> Wish {
    Wish::Do(Action::Choose(mode))
}

fn look(what: &'static str, change: impl FnOnce(&mut crate::state::View) + 'static) -> Wish {
    Wish::Do(Action::look(what, change))
}

fn orbit(steps: [f64; 2]) -> Wish {
    look("camera", move |view| view.camera = view.camera.orbited(steps.map(|step| STEP_DEG * step)))
}

fn light(steps: [f64; 2]) -> Wish {
    Wish::Do(super::picture::move_light(steps.map(|step| STEP_DEG * step)))
}

/// What the keys that were pressed ask for. While somebody types, letters and arrows are theirs.
pub(super) fn pressed(ctx: &egui::Context, state: &State) -> Vec<Wish> {
    let is_typing = ctx.egui_wants_keyboard_input();
    ctx.input_mut(|input| {
        let free = |shortcut: &&KeyboardShortcut| !(is_typing && is_of_text(shortcut));
        let is_pressed =
            |row: &&Row| row.shortcuts.iter().filter(free).any(|one| input.consume_shortcut(one));
        ROWS.iter().filter(is_pressed).map(|row| (row.wish)(state)).collect()
    })
}

/// Whether a key edits text where there is a cursor.
fn is_of_text(shortcut: &KeyboardShortcut) -> bool {
    let is_function = matches!(shortcut.logical_key, Key::F1);
    !is_function && (!shortcut.modifiers.command || matches!(shortcut.logical_key, Key::Z | Key::Y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_hides_another() {
        let all: Vec<&KeyboardShortcut> = ROWS.iter().flat_map(|row| row.shortcuts).collect();
        for (place, later) in all.iter().enumerate() {
            for earlier in &all[..place] {
                let is_hidden = later.logical_key == earlier.logical_key
                    && later.modifiers.matches_logically(earlier.modifiers);
                assert!(!is_hidden, "{later:?} is never reached behind {earlier:?}");
            }
        }
    }

    #[test]
    fn every_row_says_what_it_does() {
        let mut names: Vec<&str> = ROWS.iter().map(|row| row.keys).collect();
        assert!(ROWS.iter().all(|row| !row.does.is_empty() && !row.shortcuts.is_empty()));
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), ROWS.len());
    }
}
