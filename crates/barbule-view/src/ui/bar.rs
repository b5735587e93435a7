//! The bar at the top: what is open, on what it is shown, who sees it, and what can be done with it.

use barbule::open::eye_names;
use eframe::egui::{self, Align, Button, Key, Layout, Popup, PopupCloseBehavior, RichText, Ui};

use super::action::Action;
use super::keys::Wish;
use super::look::ACCENT;
use crate::state::{Entry, Export, Figure, Mode, Seer, Shown, State, View};

/// Width of the box in which people type what to open, points.
const BOX_WIDTH: f32 = 190.0;
/// Height of the list under it.
const LIST_HEIGHT: f32 = 360.0;
/// Width of the list under it.
const LIST_WIDTH: f32 = 420.0;

/// What somebody is typing to open, and what there is.
#[derive(Debug, Default)]
pub(super) struct Finder {
    /// What is typed.
    text: String,
    /// Everything that can be opened without a file.
    entries: Vec<Entry>,
    /// The entry that the arrows have come to.
    at: Option<usize>,
    is_open: bool,
    wants_focus: bool,
}

/// What the bar asks for beside actions.
#[derive(Debug)]
pub(super) enum Asked {
    /// As a key would.
    Wish(Wish),
    /// The command of a figure, into the clipboard.
    FigureCommand(Figure),
}

impl Finder {
    /// A box over everything that can be opened without a file.
    pub(super) fn new(entries: Vec<Entry>) -> Self {
        Self { entries, ..Self::default() }
    }

    /// Gives it the cursor.
    pub(super) fn focus(&mut self) {
        self.wants_focus = true;
    }

    /// Closes the list. Whether it was open.
    pub(super) fn leave(&mut self) -> bool {
        std::mem::take(&mut self.is_open)
    }

    /// What is shown of the entries: those of which every typed word is found in the name, the kind or what they are.
    fn found(&self) -> Vec<&Entry> {
        let words: Vec<String> = self.text.to_lowercase().split_whitespace().map(str::to_owned).collect();
        let is_found = |entry: &&Entry| {
            let all = format!("{} {} {}", entry.name, entry.kind, entry.about).to_lowercase();
            words.iter().all(|word| all.contains(word))
        };
        let mut found: Vec<&Entry> = self.entries.iter().filter(is_found).collect();
        // Those whose names begin so come first.
        let typed = self.text.trim().to_lowercase();
        found.sort_by_key(|entry| !entry.name.starts_with(&typed));
        found
    }

    fn show(&mut self, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
        let hint = state.subject().title();
        let text = egui::TextEdit::singleline(&mut self.text)
            .hint_text(hint)
            .desired_width(BOX_WIDTH)
            .char_limit(2000)
            .id_salt("open");
        let response = ui.add(text).on_hover_text(
            "A species (starling:green), a stack (air/keratin:595/air), a preset, or a file. Type to search.",
        );
        let response = response.accessible_name("Open");
        if std::mem::take(&mut self.wants_focus) {
            response.request_focus();
        }
        if response.gained_focus() || response.changed() {
            (self.is_open, self.at) = (true, None);
        }
        if !self.is_open {
            return;
        }
        let count = self.found().len();
        let (down, up, enter) = ui.input(|input| {
            let pressed = |key| input.key_pressed(key);
            (pressed(Key::ArrowDown), pressed(Key::ArrowUp), pressed(Key::Enter))
        });
        if down && count > 0 {
            self.at = Some(self.at.map_or(0, |at| (at + 1).min(count - 1)));
        }
        if up {
            self.at = self.at.and_then(|at| at.checked_sub(1));
        }
        let chosen =
            self.list(ui, &response).or_else(|| (enter && response.lost_focus()).then(|| self.typed()));
        if let Some(name) = chosen.filter(|name| !name.is_empty()) {
            self.text.clear();
            self.is_open = false;
            response.surrender_focus();
            actions.push(Action::Open(name));
        }
    }

    /// What Enter opens: the entry that the arrows have come to, else what is typed.
    fn typed(&self) -> String {
        let at = self.at.and_then(|at| self.found().get(at).map(|entry| entry.name.clone()));
        at.unwrap_or_else(|| self.text.trim().to_owned())
    }

    /// The list under the box; what was clicked in it.
    fn list(&mut self, ui: &Ui, response: &egui::Response) -> Option<String> {
        let mut chosen = None;
        let mut is_open = self.is_open;
        let found = self.found();
        let at = self.at;
        Popup::from_response(response)
            .open_bool(&mut is_open)
            .close_behavior(PopupCloseBehavior::IgnoreClicks)
            .width(LIST_WIDTH)
            .show(|ui| {
                egui::ScrollArea::vertical().max_height(LIST_HEIGHT).show(ui, |ui| {
                    ui.set_min_width(LIST_WIDTH);
                    if found.is_empty() {
                        ui.weak("Nothing of that name is built in; Enter opens it as a stack or a file.");
                    }
                    for (place, entry) in found.iter().enumerate() {
                        let is_at = at == Some(place);
                        let name = RichText::new(&entry.name).strong();
                        let row = ui
                            .horizontal(|ui| {
                                let row = ui.selectable_label(is_at, name);
                                ui.weak(format!("{}: {}", entry.kind, entry.about));
                                row
                            })
                            .inner;
                        if is_at {
                            row.scroll_to_me(None);
                        }
                        if row.clicked() {
                            chosen = Some(entry.name.clone());
                        }
                    }
                });
            });
        // The box itself is no elsewhere.
        let is_elsewhere = response.lost_focus() && !ui.ctx().is_pointer_over_egui() && chosen.is_none();
        self.is_open =
            is_open && !is_elsewhere && (chosen.is_some() || response.has_focus() || at_list(ui, response));
        chosen
    }
}

/// Whether the pointer is over the list, where a click takes the cursor from the box before it counts.
fn at_list(ui: &Ui, response: &egui::Response) -> bool {
    let list = Popup::default_response_id(response);
    let rect = ui.ctx().memory(|memory| memory.area_rect(list));
    let place = ui.input(|input| input.pointer.latest_pos());
    rect.zip(place).is_some_and(|(rect, place)| rect.contains(place))
}

/// Draws the bar.
pub(super) fn bar(ui: &mut Ui, state: &State, finder: &mut Finder, actions: &mut Vec<Action>) -> Vec<Asked> {
    let mut asked = Vec::new();
    ui.horizontal_wrapped(|ui| {
        finder.show(ui, state, actions);
        ui.separator();
        modes(ui, state, actions);
        ui.separator();
        seers(ui, state, actions);
        individuals(ui, state, actions);
        ui.separator();
        changes(ui, state, actions);
        export_menu(ui, state, actions, &mut asked);
        let help = Button::new("?").min_size(egui::vec2(24.0, 24.0));
        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
            if ui.add(help).on_hover_text("Keys, mouse and touch (F1)").clicked() {
                asked.push(Asked::Wish(Wish::Help));
            }
        });
    });
    asked
}

/// What it is shown on.
fn modes(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let can = state.subject().modes();
    for (number, (word, mode)) in (1..).zip(Mode::ALL) {
        let about = match mode {
            Mode::Sphere => "on a ball",
            Mode::Vane => "as a bent piece of vane",
            Mode::Feather => "as a feather with its barbs and barbules",
            Mode::Snake => "on the scales of a snake",
            Mode::Scene => "in its scene, path traced by the renderer",
        };
        let is_chosen = state.view().mode == *mode;
        let button = Button::selectable(is_chosen, *word);
        let response =
            ui.add_enabled(can.contains(mode), button).on_hover_text(format!("{about} ({number})"));
        let response =
            response.on_disabled_hover_text(format!("a {} is not shown so", state.subject().kind()));
        if response.clicked() && !is_chosen {
            actions.push(Action::Choose(*mode));
        }
    }
}

/// Who sees: people, or one of the birds.
fn seers(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let now = &state.view().eye;
    let name = match now {
        Seer::People => "human eye".to_owned(),
        Seer::Bird(name) => format!("{} eye", barbule::error::shortened(name)),
    };
    let combo = egui::ComboBox::from_id_salt("eye").selected_text(name).width(110.0);
    let response = combo.show_ui(ui, |ui| {
        let birds = eye_names().map(|name| Seer::Bird(name.to_owned()));
        for seer in std::iter::once(Seer::People).chain(birds) {
            let words = match &seer {
                Seer::People => "human".to_owned(),
                Seer::Bird(name) => format!("bird: {name}"),
            };
            if ui.selectable_label(*now == seer, words).clicked() && *now != seer {
                actions.push(Action::look("eye", move |view| view.eye = seer));
                actions.push(Action::Settle);
            }
        }
    });
    response
        .response
        .on_hover_text("Who sees: people, or a bird whose four cones are shown in false colours");
}

/// Whether barbules differ.
fn individuals(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    for (shown, word, about) in [
        (Shown::Mean, "mean", "every barbule is the mean over individuals (I)"),
        (Shown::Individuals, "individuals", "every barbule is one of its own, with its glints (I)"),
    ] {
        let is_chosen = state.view().shown == shown;
        if ui.selectable_label(is_chosen, word).on_hover_text(about).clicked() && !is_chosen {
            actions.push(Action::look("individuals", move |view: &mut View| view.shown = shown));
            actions.push(Action::Settle);
        }
    }
}

/// Undo, redo, pin and swap.
fn changes(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let [past, future] = state.steps();
    let is_pinned = state.pinned().is_some();
    let step = |count: usize| if count == 1 { "1 change".to_owned() } else { format!("{count} changes") };
    let buttons = [
        ("Undo", past > 0, format!("{} (Ctrl+Z)", step(past)), Action::Undo),
        ("Redo", future > 0, format!("{} (Ctrl+Shift+Z)", step(future)), Action::Redo),
    ];
    for (word, can, about, action) in buttons {
        if ui.add_enabled(can, Button::new(word)).on_hover_text(about).clicked() {
            actions.push(action);
        }
    }
    let pin = if is_pinned { RichText::new("Unpin").color(ACCENT) } else { RichText::new("Pin") };
    let about =
        if is_pinned { "takes the pinned one away (P)" } else { "pins it as it is, to compare with (P)" };
    if ui.button(pin).on_hover_text(about).clicked() {
        actions.push(if is_pinned { Action::Unpin } else { Action::Pin });
    }
    let swap = ui.add_enabled(is_pinned, Button::new("Swap"));
    if swap.on_hover_text("opens what is pinned, and pins what is open (X)").clicked() {
        actions.push(Action::Swap);
    }
}

/// Files and commands of what is seen.
fn export_menu(ui: &mut Ui, state: &State, actions: &mut Vec<Action>, asked: &mut Vec<Asked>) {
    ui.menu_button("Export", |ui| {
        for export in Export::of(state.subject()) {
            let words = match export {
                Export::Picture => "Picture (PNG)...",
                Export::Table => "Spectra as a table (CSV)...",
                Export::Figure => "Spectra as a figure (SVG, PDF, PNG)...",
                Export::Scene => "Scene (TOML)...",
                Export::Species => "Species with its sizes (TOML)...",
                Export::State => "This viewer (TOML)...",
            };
            if ui.button(words).clicked() {
                actions.push(Action::Export(export));
            }
        }
        ui.separator();
        if ui.button("Copy the command of the picture").clicked() {
            actions.push(Action::CopyCommand);
        }
        for figure in Figure::of(state.subject()) {
            let words = format!("Copy the command of the {}", figure.stem().replace('-', " "));
            if ui.button(words).clicked() {
                asked.push(Asked::FigureCommand(*figure));
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::catalogue;

    #[test]
    fn words_are_looked_for_in_names_and_in_what_things_are() {
        let mut finder = Finder::new(catalogue().unwrap());
        let all = finder.found().len();
        finder.text = "Starling gre".into();
        assert_eq!(finder.found()[0].name, "starling:green");
        finder.text = "sturnus".into();
        assert!(!finder.found().is_empty() && finder.found().len() < all);
        finder.text = "xenopel".into();
        assert_eq!(finder.found()[0].name, "xenopeltis");
        assert_eq!(finder.typed(), "xenopel");
        finder.at = Some(0);
        assert_eq!(finder.typed(), "xenopeltis");
        finder.text = "air/keratin:300/air".into();
        assert!(finder.found().is_empty());
        assert_eq!(finder.typed(), "air/keratin:300/air");
    }
}
