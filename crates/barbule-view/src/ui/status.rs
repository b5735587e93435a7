//! The line at the bottom: what is computed and how long it still takes, what went wrong or was written, the adapter, frames.

use eframe::egui::{self, Align, Layout, ProgressBar, RichText, Ui};

use super::action::Action;
use super::look::{QUIET, WRONG};
use crate::live::{Busy, Known};

/// Frames of which the rate is the mean.
const FRAMES: usize = 30;
/// Without a frame for so long the rate is none, s.
const STANDS_STILL_S: f64 = 0.5;

/// A sentence for people.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Message {
    /// The sentence.
    pub words: String,
    /// Whether something went wrong, rather than right.
    pub is_wrong: bool,
}

/// When the last frames were drawn.
#[derive(Debug, Default)]
pub(super) struct Frames {
    /// s of the window's clock, rising.
    at: Vec<f64>,
}

impl Frames {
    /// Notes a frame.
    pub(super) fn note(&mut self, now: f64) {
        if self.at.last().is_some_and(|last| now - last > STANDS_STILL_S) {
            self.at.clear();
        }
        if self.at.len() > FRAMES {
            self.at.remove(0);
        }
        self.at.push(now);
    }

    /// Frames a second while something moves.
    pub(super) fn rate(&self) -> Option<f64> {
        let (first, last) = (self.at.first()?, self.at.last()?);
        (self.at.len() > FRAMES / 2 && last > first).then(|| (self.at.len() - 1) as f64 / (last - first))
    }
}

/// What the line shows.
pub(super) struct Line<'a> {
    /// What is computed.
    pub busy: Option<Busy>,
    /// What has been computed of what is open.
    pub of: &'a Known,
    /// The adapter's name, or why there is none.
    pub adapter: &'a str,
    /// Memory of the picture on the adapter, bytes.
    pub bytes: Option<u64>,
    /// Frames a second.
    pub rate: Option<f64>,
}

/// Draws the line.
pub(super) fn status(ui: &mut Ui, line: &Line, message: &mut Option<Message>, actions: &mut Vec<Action>) {
    // What is wrong has a line of its own, so that it is read whole.
    if let Some(Message { words, is_wrong }) = message.clone() {
        ui.horizontal(|ui| {
            if ui.button("Dismiss").clicked() {
                *message = None;
            }
            let colour = if is_wrong { WRONG } else { ui.visuals().text_color() };
            ui.add(egui::Label::new(RichText::new(words).color(colour)).wrap().selectable(true));
        });
    }
    ui.horizontal(|ui| {
        progress(ui, line, actions);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if let Some(rate) = line.rate {
                ui.label(RichText::new(format!("{rate:.0} fps")).color(QUIET));
            }
            let memory = line.bytes.filter(|bytes| *bytes > 0).map_or_else(String::new, |bytes| {
                format!(" | {:.1} MB of tables and meshes", bytes as f64 / 1e6)
            });
            let adapter = RichText::new(format!("{}{memory}", line.adapter)).color(QUIET);
            ui.add(egui::Label::new(adapter).truncate()).on_hover_text("what draws the picture");
        });
    });
}

fn progress(ui: &mut Ui, line: &Line, actions: &mut Vec<Action>) {
    let Some(Busy { what, label, fraction, left_s }) = &line.busy else {
        ui.label(RichText::new(summary(line.of)).color(QUIET));
        return;
    };
    let left = left_s.map_or_else(String::new, |left| format!(", {} left", duration(left)));
    ui.label(format!("{what}: {}{left}", if label.is_empty() { "starting" } else { label }));
    ui.add(ProgressBar::new(*fraction as f32).desired_width(110.0).desired_height(8.0));
    if ui.button("Stop").on_hover_text("stops what is computed (Esc)").clicked() {
        actions.push(Action::Stop);
    }
}

/// What there is, in a line.
fn summary(of: &Known) -> String {
    let mut parts = Vec::new();
    match (&of.curves, of.is_whole, of.individuals) {
        (Some(_), _, 1) => parts.push("exact spectra".to_owned()),
        (Some(_), true, count) => parts.push(format!("means over {count} individuals")),
        (Some(_), false, count) => parts.push(format!("means over {count} individuals, stopped")),
        (None, ..) => {}
    }
    match of.material.as_ref().map(|found| found.thinned) {
        Some(None) => parts.push("material there".to_owned()),
        Some(Some(stride)) => {
            parts.push(format!("coarse material, every {stride}th wavelength and direction"));
        }
        None => {}
    }
    if parts.is_empty() { "ready".to_owned() } else { parts.join(" | ") }
}

/// Seconds as people say them.
fn duration(seconds: f64) -> String {
    let whole = seconds.round().max(1.0);
    if whole < 90.0 {
        return format!("{whole:.0} s");
    }
    let minutes = (whole / 60.0).round();
    if minutes < 90.0 { format!("{minutes:.0} min") } else { format!("{:.1} h", whole / 3600.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_of_what_moves_alone() {
        let mut frames = Frames::default();
        assert_eq!(frames.rate(), None);
        (0..40).for_each(|k| frames.note(f64::from(k) / 50.0));
        assert!((frames.rate().unwrap() - 50.0).abs() < 1e-9);
        frames.note(10.0);
        assert_eq!(frames.rate(), None);
    }

    #[test]
    fn times_are_said_as_people_say_them() {
        assert_eq!(
            [0.2, 59.7, 100.0, 4000.0, 9000.0].map(duration),
            ["1 s", "60 s", "2 min", "67 min", "2.5 h"]
        );
    }
}
