//! Every size of what is open as a slider, and what is computed of it.

use barbule::error::shortened;
use eframe::egui::{self, Button, PointerButton, Response, RichText, Sense, SliderClamping, Ui};

use super::style;
use super::words::about;
use super::{Memory, Once};
use crate::live::{MaterialJob, Results, expected_seconds};
use crate::state::{Shown, Slider, State, What};
use crate::ui::Action;

/// Angles of incidence, deg; wavelengths of lobes, nm; and individuals, as views may have them.
const ANGLES_DEG: [f64; 2] = [-85.0, 85.0];
const WAVELENGTHS_NM: [f64; 2] = [300.0, 830.0];
const LAST_INDIVIDUAL: usize = 9999;

/// Room for the number beside a slider, and for the groups' indent, points.
const NUMBER_WIDE: f32 = 120.0;

/// What the sliders remember.
#[derive(Default)]
pub(super) struct Kept {
    /// Whether sliders reach over all that their numbers may be.
    whole_ranges: bool,
    /// What is known of the structure as it was when nothing was being dragged.
    known: Once<(String, Vec<f64>), Known>,
}

/// What is known of a structure without computing it.
#[derive(Debug, Clone, PartialEq)]
struct Known {
    /// How many individuals there are, where they are given ones.
    count: Option<usize>,
    /// What its material takes.
    material: Takes,
}

/// What a material takes to be there.
#[derive(Debug, Clone, PartialEq)]
enum Takes {
    /// It is there.
    Nothing,
    /// So many seconds for a coarse one, and for the whole one.
    Seconds([f64; 2]),
    /// It cannot be made, or nothing is known of it.
    Unknown(String),
    /// There is nothing of which one could be made.
    NoStructure,
}

/// Draws the sliders of what is open, how it is looked at in the views, and the buttons that make its material.
pub fn sliders(
    ui: &mut Ui,
    state: &State,
    results: &Results,
    memory: &mut Memory,
    actions: &mut Vec<Action>,
) {
    // The number beside a slider takes the rest.
    ui.spacing_mut().slider_width = (ui.available_width() - NUMBER_WIDE).max(60.0);
    let kept = &mut memory.sliders;
    let sliders = state.subject().sliders();
    if sliders.is_empty() {
        style::not_there(ui, "what is open has no sizes to move; open a species or a stack");
    } else {
        heading(ui, &sliders, &mut kept.whole_ranges, actions);
        for (title, members) in grouped(&sliders) {
            let header = egui::CollapsingHeader::new(title).default_open(is_open_first(title, sliders.len()));
            header.show(ui, |ui| {
                for slider in members {
                    size(ui, slider, kept.whole_ranges, actions);
                }
            });
        }
    }
    ui.separator();
    // While a hand drags, every frame is another structure.
    let values: Vec<f64> = sliders.iter().map(|slider| slider.value).collect();
    let is_dragged = ui.input(|input| input.pointer.any_down());
    let known = known(&mut kept.known, (state.subject().text().to_owned(), values), state, is_dragged);
    looks(ui, state, known.as_ref().and_then(|known| known.count), actions);
    ui.separator();
    material(ui, results, known.as_ref().map(|known| &known.material), actions);
}

/// What is known of what is open; of what is being dragged nothing, unless it was known before.
fn known(
    kept: &mut Once<(String, Vec<f64>), Known>,
    key: (String, Vec<f64>),
    state: &State,
    is_dragged: bool,
) -> Option<Known> {
    if is_dragged && kept.0.as_ref().is_none_or(|(known, _)| *known != key) {
        return None;
    }
    Some(kept.of(&key, |_| find(state)).clone())
}

fn find(state: &State) -> Known {
    match state.structure() {
        Ok(None) => Known { count: None, material: Takes::NoStructure },
        Err(error) => Known { count: None, material: Takes::Unknown(error.to_string()) },
        Ok(Some(structure)) => {
            let count = structure.count();
            let job = MaterialJob { structure, opening: state.opening().clone(), whole: true };
            let cores = std::thread::available_parallelism().map_or(1, usize::from);
            let material = match expected_seconds(&job, cores) {
                Ok(None) => Takes::Nothing,
                Ok(Some(seconds)) => Takes::Seconds(seconds),
                Err(error) => Takes::Unknown(error.to_string()),
            };
            Known { count, material }
        }
    }
}

fn heading(ui: &mut Ui, sliders: &[Slider], whole_ranges: &mut bool, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        let moved = sliders.iter().filter(|slider| slider.is_moved()).count();
        let reset = ui.add_enabled(moved > 0, Button::new("reset all"));
        if reset.on_hover_text("every size as it was at first").clicked() {
            actions.push(Action::ResetSizes);
        }
        ui.checkbox(whole_ranges, "whole ranges")
            .on_hover_text("all that a size may be, rather than half to double of what it is at first");
        if moved > 0 {
            ui.weak(format!("{moved} moved"));
        }
    });
}

/// The groups of sliders in the order in which they are shown.
const GROUPS: [&str; 7] =
    ["layers", "repetitions", "mixtures", "rods and granules", "shape", "disorder", "drawing"];

/// Which of the groups a size belongs to, by its key.
fn group(key: &str) -> &'static str {
    let has = |words: &[&str]| words.iter().any(|word| key.contains(word));
    if key.starts_with("point_spacing") {
        return "drawing";
    }
    if has(&["spread", "roughness", "correlation", "waviness", "amplitude", "regularity"]) {
        return "disorder";
    }
    if has(&["count[", "repeats"]) {
        return "repetitions";
    }
    if has(&["fraction["]) {
        return "mixtures";
    }
    let rods =
        ["melanosome", "melanin", "rod", "core", "channel", "period", "row", "bubble", "spacing", "coverage"];
    if has(&rods) || ["air_", "wall_"].iter().any(|word| key.starts_with(word)) {
        return "rods and granules";
    }
    if has(&["thickness", "layer", "cortex", "gap", "membrane"]) {
        return "layers";
    }
    "shape"
}

/// The sliders by their groups; groups without any are left out.
fn grouped(sliders: &[Slider]) -> Vec<(&'static str, Vec<&Slider>)> {
    let of = |title: &'static str| {
        let members: Vec<&Slider> = sliders.iter().filter(|slider| group(&slider.key) == title).collect();
        (title, members)
    };
    GROUPS.into_iter().map(of).filter(|(_, members)| !members.is_empty()).collect()
}

/// Whether a group is open before anybody opens or closes it: what makes colours is, and everything where there is little.
fn is_open_first(title: &str, all: usize) -> bool {
    all <= 8 || !["shape", "disorder", "drawing"].contains(&title)
}

/// A size: its name, marked where it was moved, and its slider. A double click on either puts it back.
fn size(ui: &mut Ui, slider: &Slider, whole_ranges: bool, actions: &mut Vec<Action>) {
    let [low, high] = if whole_ranges { slider.range } else { slider.usual() };
    let hover =
        format!("{}\nAt first {}. Double click puts it back.", slider.about, slider.words(slider.default));
    let name = match slider.is_moved() {
        true => RichText::new(format!("{} (moved)", slider.name)).strong(),
        false => RichText::new(&slider.name),
    };
    let label = ui.add(egui::Label::new(name).sense(Sense::click())).on_hover_text(&hover);
    let mut value = slider.value;
    let suffix = match slider.unit {
        "" | "°" => slider.unit.to_owned(),
        unit => format!(" {unit}"),
    };
    // Typed numbers may leave the usual range, but not the whole one.
    let mut widget = egui::Slider::new(&mut value, low..=high)
        .clamping(SliderClamping::Never)
        .logarithmic(slider.is_logarithmic() && low > 0.0)
        .suffix(suffix);
    if slider.whole {
        widget = widget.integer();
    }
    let response = ui.add(widget).labelled_by(label.id).on_hover_text(hover);
    let is_put_back = label.double_clicked() || is_double_clicked(ui, &response);
    let value = if is_put_back { slider.default } else { value.clamp(slider.range[0], slider.range[1]) };
    let value = if slider.whole { value.round() } else { value };
    if value != slider.value {
        actions.push(Action::Size { key: slider.key.clone(), value });
    }
    settle(&response, is_put_back, actions);
}

/// Whether a slider's rail was double clicked; its number is, to be typed over.
fn is_double_clicked(ui: &Ui, response: &Response) -> bool {
    let rail = response.rect.left()..=response.rect.left() + ui.spacing().slider_width;
    let on_rail = response.contains_pointer()
        && ui.input(|input| input.pointer.interact_pos()).is_some_and(|at| rail.contains(&at.x));
    on_rail && ui.input(|input| input.pointer.button_double_clicked(PointerButton::Primary))
}

/// What follows is another change, once a hand lets go or a number has been typed.
fn settle(response: &Response, is_done: bool, actions: &mut Vec<Action>) {
    if is_done || response.drag_stopped() || response.lost_focus() {
        actions.push(Action::Settle);
    }
}

/// How it is looked at in the views: which individual, at which angle, at which wavelength.
fn looks(ui: &mut Ui, state: &State, count: Option<usize>, actions: &mut Vec<Action>) {
    let view = state.view();
    let has_individuals = count.is_none_or(|count| count > 1)
        && !matches!(state.subject().what(), What::Grating(_) | What::Scene(_));
    if has_individuals {
        let last = count.map_or(LAST_INDIVIDUAL, |count| count - 1).min(LAST_INDIVIDUAL);
        let label = ui.label("individual").on_hover_text(match view.shown {
            Shown::Mean => "whose section is drawn; everything else shows the mean",
            Shown::Individuals => "whose section and lobe are drawn",
        });
        let mut index = view.individual;
        let response =
            ui.add(egui::DragValue::new(&mut index).range(0..=last).speed(0.1)).labelled_by(label.id);
        if index != view.individual {
            actions.push(Action::look("individual", move |view| view.individual = index));
        }
        settle(&response, false, actions);
    }
    let angle = plain(ui, ("angle of incidence", "°"), view.angle_deg, ANGLES_DEG, actions);
    if let Some(degrees) = angle {
        actions.push(Action::look("angle", move |view| view.angle_deg = degrees));
    }
    let wavelength =
        plain(ui, ("wavelength of the lobe", " nm"), view.wavelength_nm, WAVELENGTHS_NM, actions);
    if let Some(nm) = wavelength {
        actions.push(Action::look("wavelength", move |view| view.wavelength_nm = nm));
    }
}

/// A slider of the view, which moves in whole steps; its new value, if it was moved.
fn plain(
    ui: &mut Ui,
    (name, suffix): (&str, &str),
    now: f64,
    [low, high]: [f64; 2],
    actions: &mut Vec<Action>,
) -> Option<f64> {
    let label = ui.label(name);
    let mut value = now;
    let slider = egui::Slider::new(&mut value, low..=high).step_by(1.0).suffix(suffix);
    let response = ui.add(slider).labelled_by(label.id);
    settle(&response, false, actions);
    // A value between the steps is kept until somebody moves it.
    (response.changed() && value != now).then_some(value)
}

/// What there is of the material, and the buttons that make it.
fn material(ui: &mut Ui, results: &Results, takes: Option<&Takes>, actions: &mut Vec<Action>) {
    let made = results.own.material.as_ref().map(|made| made.thinned);
    if made == Some(None) {
        ui.label("material: there, whole");
        return;
    }
    if let Some(Some(thin)) = made {
        ui.label(format!("material: coarse, of every {thin}th wavelength and direction"));
    }
    match takes {
        None => ui.weak("material: let go to see what it takes"),
        Some(Takes::NoStructure) => ui.weak("no material can be made of what is open"),
        Some(Takes::Unknown(why)) => ui.weak(shortened(why)),
        Some(Takes::Nothing) => button(ui, "use its material (it is there)", false, actions),
        Some(Takes::Seconds([coarse, whole])) => {
            ui.horizontal_wrapped(|ui| {
                if made.is_none() {
                    button(ui, &format!("make the material, coarse ({})", about(*coarse)), false, actions);
                }
                button(ui, &format!("make the material ({})", about(*whole)), true, actions);
            })
            .response
        }
    };
}

fn button(ui: &mut Ui, words: &str, whole: bool, actions: &mut Vec<Action>) -> Response {
    let response = ui.button(words);
    if response.clicked() {
        actions.push(Action::MakeMaterial { whole });
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::Unobserved;
    use barbule::open::Opening;
    use barbule::structure::species_names;

    fn opened(text: &str) -> State {
        State::open(text, &Opening::default(), &Unobserved).unwrap()
    }

    /// Every slider of everything that is built in is shown, once.
    #[test]
    fn every_size_is_in_one_group() {
        let stack = "air/mix(keratin,melanin,0.4):80±5%/6*(melanin:99/keratin:100±3)/keratin";
        for text in species_names().chain([stack]) {
            let sliders = opened(text).subject().sliders();
            let groups = grouped(&sliders);
            let count: usize = groups.iter().map(|(_, members)| members.len()).sum();
            assert_eq!(count, sliders.len(), "{text}");
            assert!(groups.iter().any(|(title, _)| is_open_first(title, sliders.len())), "{text}");
        }
    }

    #[test]
    fn sizes_are_where_people_look_for_them() {
        for (key, expected) in [
            ("cortex_um", "layers"),
            ("layers[1].thickness_um", "layers"),
            ("thickness_nm[0]", "layers"),
            ("spread_percent[0]", "disorder"),
            ("count[0]", "repetitions"),
            ("fraction[0]", "mixtures"),
            ("melanosome_diameter_um", "rods and granules"),
            ("melanosome_spread", "disorder"),
            ("row_pitch_um", "rods and granules"),
            ("air_um", "rods and granules"),
            ("width_um", "shape"),
            ("point_spacing_um", "drawing"),
        ] {
            assert_eq!(group(key), expected, "{key}");
        }
    }

    #[test]
    fn what_a_material_takes_is_found_once_and_not_while_a_hand_drags() {
        let mut kept = Once::default();
        let state = opened("air/keratin:300/melanin");
        let key = |value: f64| ("air/keratin:300/melanin".to_owned(), vec![value]);
        assert_eq!(known(&mut kept, key(300.0), &state, true), None);
        let found = known(&mut kept, key(300.0), &state, false).unwrap();
        assert!(matches!(found.material, Takes::Seconds([coarse, whole]) if coarse < whole), "{found:?}");
        assert_eq!(found.count, Some(1));
        assert_eq!(known(&mut kept, key(300.0), &state, true), Some(found));
        assert_eq!(known(&mut kept, key(301.0), &state, true), None);
        assert_eq!(find(&opened("starling")).material, Takes::Nothing);
        assert_eq!(find(&opened("snake")).material, Takes::NoStructure);
    }
}
