//! What is open against what is pinned: the sizes that differ, and what of the colour does.

use barbule::spectrum::Spectrum;
use eframe::egui::{Grid, Ui};

use super::seen;
use super::style;
use super::words::digits;
use super::{Memory, Once};
use crate::live::{Compared, Results, Told};
use crate::state::{Seer, Slider, State};
use crate::ui::Action;

/// What was compared last, or why it was not.
pub(super) type Kept = Once<(Spectrum, Spectrum, Seer), Result<Compared, String>>;

/// Draws how what is open differs from what is pinned; offers to pin where nothing is.
pub fn comparison(
    ui: &mut Ui,
    state: &State,
    results: &Results,
    memory: &mut Memory,
    actions: &mut Vec<Action>,
) {
    let Some(pinned) = state.pinned() else {
        style::not_there(
            ui,
            "pin what is open, then change it or open something else: the two are compared here",
        );
        if ui.button("pin").clicked() {
            actions.push(Action::Pin);
        }
        return;
    };
    ui.label(format!("open: {}", state.subject().title()));
    ui.label(format!("pinned: {}", pinned.title()));
    ui.horizontal_wrapped(|ui| {
        for (words, action) in [("swap", Action::Swap), ("unpin", Action::Unpin), ("pin anew", Action::Pin)] {
            if ui.button(words).clicked() {
                actions.push(action);
            }
        }
    });
    colours(ui, state, results, memory);
    differences(ui, &state.differences());
}

fn colours(ui: &mut Ui, state: &State, results: &Results, memory: &mut Memory) {
    let [Some(own), Some(pinned)] = seen::both(memory, state, results) else {
        return style::not_there(ui, "colours are compared once both reflectances are there");
    };
    ui.horizontal_wrapped(|ui| {
        for (seen, whose) in [(own, "open"), (pinned, "pinned")] {
            ui.label(whose);
            seen::swatches(ui, &seen.sight, state, whose);
        }
    });
    let peaks = [own, pinned].map(|seen| seen.look.peak.map(|peak| peak.nm));
    let key = (own.spectrum.clone(), pinned.spectrum.clone(), state.view().eye.clone());
    let Memory { viewer, compared, .. } = memory;
    let Ok(viewer) = seen::viewer(viewer, state) else { return };
    let found = compared
        .of(&key, |(own, pinned, _)| Compared::of(own, pinned, viewer).map_err(|error| error.to_string()));
    match found {
        Ok(found) => {
            Grid::new("differences in colour").num_columns(2).striped(true).show(ui, |ui| {
                for (what, value) in rows(found, peaks, &state.view().eye) {
                    ui.label(what);
                    ui.label(value);
                    ui.end_row();
                }
            });
        }
        Err(why) => style::not_there(ui, why),
    }
}

/// The numbers of a comparison, each with what it is.
fn rows(found: &Compared, peaks: [Option<f64>; 2], eye: &Seer) -> Vec<(String, String)> {
    let none = || "not known".to_owned();
    let peak = |nm: Option<f64>| nm.map_or_else(|| "none".to_owned(), |nm| format!("{nm:.0} nm"));
    let mut rows = vec![
        ("colour, people: \u{394}E00".to_owned(), found.delta_e_2000.map_or_else(none, digits)),
        ("peaks, open and pinned".to_owned(), peaks.map(peak).join(", ")),
        (
            "shift of the peak".to_owned(),
            found.peak_shift_nm.map_or_else(|| "none in common".to_owned(), |nm| format!("{nm:+.0} nm")),
        ),
        ("brightness".to_owned(), found.brightness.map_or_else(none, |ratio| format!("× {}", digits(ratio)))),
    ];
    let Seer::Bird(bird) = eye else { return rows };
    let jnd = |value: Option<f64>| value.map_or_else(none, |value| format!("{} JND", digits(value)));
    match &found.bird {
        Some(Told::Jnd { delta_s, delta_l }) => {
            rows.push((format!("colour, {bird}: \u{394}S"), jnd(*delta_s)));
            if delta_l.is_some() {
                rows.push((format!("brightness, {bird}: \u{394}L"), jnd(*delta_l)));
            }
        }
        Some(Told::Unknown(why)) => rows.push((format!("colour, {bird}"), why.clone())),
        None => {}
    }
    rows
}

fn differences(ui: &mut Ui, differences: &[(Slider, f64)]) {
    if differences.is_empty() {
        return style::not_there(ui, "no size that both have differs");
    }
    Grid::new("differing sizes").num_columns(3).striped(true).show(ui, |ui| {
        for words in ["size", "open", "pinned"] {
            ui.strong(words);
        }
        ui.end_row();
        for (slider, pinned) in differences {
            ui.label(&slider.name).on_hover_text(&slider.about);
            ui.label(slider.words(slider.value));
            ui.label(slider.words(*pinned));
            ui.end_row();
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_their_names_and_what_is_unknown_is_said() {
        let people = Compared {
            delta_e_2000: Some(12.34),
            peak_shift_nm: Some(-20.4),
            brightness: Some(1.25),
            bird: None,
        };
        let values = |found: &Compared, eye: &Seer| -> Vec<String> {
            rows(found, [Some(510.2), None], eye).into_iter().map(|(_, value)| value).collect()
        };
        assert_eq!(values(&people, &Seer::People), ["12.3", "510 nm, none", "-20 nm", "× 1.25"]);
        let told = Told::Jnd { delta_s: Some(3.0), delta_l: None };
        let bird = Compared { peak_shift_nm: None, brightness: None, bird: Some(told), ..people.clone() };
        let eye = Seer::Bird("starling".into());
        assert_eq!(values(&bird, &eye), ["12.3", "510 nm, none", "none in common", "not known", "3 JND"]);
        let unknown = Compared { bird: Some(Told::Unknown("the reflectance ends".into())), ..people };
        assert_eq!(values(&unknown, &eye).last().unwrap(), "the reflectance ends");
    }
}
