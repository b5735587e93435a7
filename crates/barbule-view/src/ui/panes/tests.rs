//! The views as people use them, without a window: what they say, and what comes of a drag or a press.

use std::sync::Arc;

use barbule::Unobserved;
use barbule::brdf::{FeatherBrdf, Options};
use barbule::characterize::Catalog;
use barbule::open::Opening;
use barbule::spectrum::Wavelengths;
use barbule::structure::Structure;
use eframe::egui::{Event, Modifiers, PointerButton, Pos2, Rect, Role, Ui, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{AccessKitNode, By, NodeT as _, Queryable as _};

use super::Memory;
use crate::live::{
    Curves, FilmJob, HemisphereJob, IndividualJob, Known, MaterialFound, Results, film, hemisphere,
    individual, lit_across,
};
use crate::state::{Beside, Seer, State};
use crate::ui::Action;

/// One of the views.
type Pane = fn(&mut Ui, &State, &Results, &mut Memory, &mut Vec<Action>);

/// Frames follow each other so fast that two presses are a double click, s.
const STEP_S: f32 = 0.02;
const FILM: &str = "air/6*(melanin:99/keratin:100)/keratin";
const OTHER: &str = "air/6*(melanin:99/keratin:140)/keratin";

/// What a window has, and what was done in it.
struct App {
    state: State,
    results: Results,
    memory: Memory,
    done: Vec<String>,
}

impl App {
    fn new(text: &str) -> Self {
        let state = State::open(text, &Opening::default(), &Unobserved).unwrap();
        Self { state, results: Results::default(), memory: Memory::default(), done: Vec::new() }
    }

    /// A stack with everything that is computed of it.
    fn film() -> Self {
        let mut app = Self::new(FILM);
        app.results.own = of_stack(FILM);
        app
    }

    /// The same with another one pinned.
    fn two() -> Self {
        let mut app = Self::film();
        app.state.pin();
        app.state.move_size("thickness_nm[1]", 140.0).unwrap();
        app.results.pinned = std::mem::replace(&mut app.results.own, of_stack(OTHER));
        app
    }

    /// Draws a view; sizes that it moves are moved at once, everything else is written down alone.
    fn show(self, pane: Pane, size: [f32; 2]) -> Harness<'static, Self> {
        let draw = move |ui: &mut Ui, app: &mut Self| {
            let mut actions = Vec::new();
            pane(ui, &app.state, &app.results, &mut app.memory, &mut actions);
            for action in actions {
                app.done.push(format!("{action:?}"));
                match action {
                    Action::Size { key, value } => app.state.move_size(&key, value).unwrap(),
                    Action::Look { what, change } => app.state.look(what, change).unwrap(),
                    _ => {}
                }
            }
        };
        Harness::builder().with_size(vec2(size[0], size[1])).with_step_dt(STEP_S).build_ui_state(draw, self)
    }
}

fn of_stack(text: &str) -> Known {
    let opened = State::open(text, &Opening::default(), &Unobserved).unwrap();
    let at = Wavelengths::usual();
    let angle = (0..6).map(|k| f64::from(15 * k).to_radians()).collect();
    let stack = opened.subject().stack().unwrap().clone();
    let curves = film(&FilmJob { stack, at, angle, individuals: 1, seed: 1 }, &Unobserved).unwrap();
    let structure = opened.structure().unwrap().unwrap();
    Known {
        curves: Some(curves),
        individuals: 1,
        is_whole: true,
        individual: Some(one(structure)),
        ..Known::default()
    }
}

/// An individual with what it scatters.
fn one(structure: Structure) -> crate::live::Individual {
    let at = Wavelengths::usual();
    let job =
        IndividualJob { structure, seed: 1, index: 0, at, wavelength_nm: Some(550.0), incident: [0.0; 2] };
    let mut last = None;
    individual(&job, &Unobserved, &mut |one| last = Some(one)).unwrap();
    last.unwrap()
}

/// The starling with its material and a small lobe.
fn starling() -> App {
    let mut app = App::new("starling");
    let structure = Structure::builtin("starling:green").unwrap();
    let found = Arc::new(Catalog::default().shipped(&structure).unwrap().unwrap());
    let brdf = Arc::new(FeatherBrdf::new(&found.material, Options::default()).unwrap());
    app.state.look("angle", |view| view.angle_deg = 30.0).unwrap();
    let job = HemisphereJob {
        brdf: Arc::clone(&brdf),
        incident: lit_across(30.0_f64.to_radians()),
        individual: None,
        side: 12,
        at: Wavelengths::new([450.0, 550.0, 650.0]).unwrap(),
    };
    app.results.own = Known {
        hemisphere: Some(hemisphere(&job, &Unobserved).unwrap()),
        brdf: Some(brdf),
        material: Some(MaterialFound { found, thinned: None }),
        ..Known::default()
    };
    app
}

fn has(harness: &Harness<'_, App>, words: &str) -> bool {
    harness.query_all_by_label_contains(words).next().is_some()
}

fn rect(harness: &Harness<'_, App>, role: Role, label: &str) -> Rect {
    let named = |node: &AccessKitNode<'_>| node.label().is_some_and(|own| own.contains(label));
    harness.get(By::new().role(role).predicate(named)).rect()
}

fn drag(harness: &mut Harness<'_, App>, [from, to]: [Pos2; 2]) {
    harness.hover_at(from);
    harness.drag_at(from);
    harness.run_steps(2);
    harness.hover_at(to);
    harness.run_steps(2);
    harness.drop_at(to);
    harness.run_steps(2);
}

fn double_click(harness: &mut Harness<'_, App>, at: Pos2) {
    harness.hover_at(at);
    // Long enough after any press before, which would count as one of three.
    harness.run_steps(40);
    for pressed in [true, false, true, false] {
        harness.event(Event::PointerButton {
            pos: at,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        });
        harness.step();
    }
    harness.run_steps(2);
}

#[test]
fn a_slider_that_is_dragged_moves_its_size_and_a_double_click_puts_it_back() {
    let mut harness = App::film().show(super::sliders, [300.0, 900.0]);
    harness.run_steps(2);
    let place = rect(&harness, Role::Slider, "1: melanin");
    drag(&mut harness, [place.center(), place.center() + vec2(25.0, 0.0)]);
    let done = &harness.state().done;
    let is_size = |one: &&String| one.starts_with("Size(thickness_nm[0] = ");
    assert!(done.iter().filter(is_size).count() >= 1 && done.last().unwrap() == "Settle", "{done:?}");
    let moved = harness.state().state.subject().moved();
    let value = moved["thickness_nm[0]"];
    assert!((99.0..200.0).contains(&value) && value != 99.0, "{moved:?}");
    assert!(has(&harness, "1: melanin (moved)") && has(&harness, "1 moved"));
    let label = rect_of_label(&harness, "1: melanin (moved)");
    double_click(&mut harness, label.center());
    assert!(harness.state().state.subject().moved().is_empty(), "{:?}", harness.state().done);
}

fn rect_of_label(harness: &Harness<'_, App>, words: &str) -> Rect {
    harness.get(By::new().role(Role::Label).label(words).include_labels()).rect()
}

#[test]
fn sliders_reset_look_and_make_materials() {
    let mut app = App::film();
    app.state.move_size("thickness_nm[0]", 120.0).unwrap();
    let mut harness = app.show(super::sliders, [300.0, 900.0]);
    harness.run_steps(2);
    harness.get_by_label("reset all").click();
    harness.run_steps(2);
    harness.get_by_label_contains("make the material (about").click();
    harness.run_steps(2);
    harness.get_by_label_contains("make the material, coarse (").click();
    harness.run_steps(2);
    let whole = harness.get_by_label("whole ranges");
    whole.click();
    harness.run_steps(2);
    let place = rect(&harness, Role::Slider, "angle of incidence");
    drag(&mut harness, [place.center(), place.center() + vec2(10.0, 0.0)]);
    let done = &harness.state().done;
    assert_eq!(done[..3], ["ResetSizes", "MakeMaterial(true)", "MakeMaterial(false)"]);
    assert!(done.contains(&"Look(angle)".to_owned()) && done.last().unwrap() == "Settle", "{done:?}");
    let degrees = harness.state().state.view().angle_deg;
    assert!(degrees > 0.0 && degrees.fract() == 0.0, "{degrees}");
    // A stack that does not spread has one individual.
    assert!(harness.query_by_label("individual").is_none());
}

#[test]
fn a_species_has_its_sliders_in_groups_and_its_material_there() {
    let mut harness = starling().show(super::sliders, [320.0, 1600.0]);
    harness.run_steps(2);
    for words in ["layers", "rods and granules", "disorder", "cortex", "individual", "material: there, whole"]
    {
        assert!(has(&harness, words), "{words}");
    }
    let mut scene = App::new("snake").show(super::sliders, [320.0, 600.0]);
    scene.run_steps(2);
    assert!(has(&scene, "no sizes to move") && has(&scene, "no material can be made"));
}

#[test]
fn the_spectrum_says_what_is_seen_and_reads_its_curves() {
    let mut harness = App::two().show(super::spectrum, [420.0, 600.0]);
    harness.run_steps(3);
    for words in [
        "open, 0°: peak",
        "pinned, 0°: peak",
        "half width",
        "open as people see it: #",
        "point at the curves",
    ] {
        assert!(has(&harness, words), "{words}");
    }
    harness.hover_at(Pos2::new(240.0, 200.0));
    harness.run_steps(2);
    assert!(has(&harness, " nm · open ") && has(&harness, "pinned "));
    // A bird needs the ultraviolet, and is told so.
    harness.state_mut().state.look("eye", |view| view.eye = Seer::Bird("starling".into())).unwrap();
    harness.run_steps(2);
    assert!(has(&harness, "nothing is invented outside"));
    let mut empty = App::new("snake").show(super::spectrum, [420.0, 600.0]);
    empty.run_steps(2);
    assert!(has(&empty, "no reflectance yet"));
}

#[test]
fn measured_spectra_have_numbers_and_are_taken_away() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("blue back.csv");
    std::fs::write(&file, "wl,R\n400,10\n450,15\n500,30\n550,45\n600,20\n650,20\n690,20\n").unwrap();
    assert!(Beside::is_meant(&file).unwrap());
    let mut app = App::film();
    app.state.drop_file(&file, &Unobserved).unwrap();
    app.results.own.is_whole = false;
    app.results.own.individuals = 4;
    let mut harness = app.show(super::spectrum, [420.0, 600.0]);
    harness.run_steps(3);
    for words in ["blue back: rms difference", "so far of 4 individuals"] {
        assert!(has(&harness, words), "{words}");
    }
    harness.get_by_label("take away").click();
    harness.run_steps(2);
    assert_eq!(harness.state().done, ["TakeAway(0)"]);
}

#[test]
fn a_click_on_the_strip_of_angles_looks_from_there() {
    let mut harness = App::two().show(super::angles, [420.0, 500.0]);
    harness.run_steps(3);
    assert!(has(&harness, "pinned as people see it: #"));
    let strip = rect(&harness, Role::Image, "open as people see it");
    let at = strip.center() + vec2(60.0, 0.0);
    harness.hover_at(at);
    harness.drag_at(at);
    harness.step();
    harness.drop_at(at);
    harness.run_steps(2);
    assert_eq!(harness.state().done, ["Look(angle)", "Settle"]);
    let degrees = harness.state().state.view().angle_deg;
    assert!((20.0..70.0).contains(&degrees), "{degrees}");
    let mut alone = App::film();
    let curves = alone.results.own.curves.take().unwrap();
    let spectrum = curves.spectrum(0).unwrap().values().to_vec();
    alone.results.own.curves = Some(Curves::new(curves.at, vec![0.0], spectrum, None).unwrap());
    let mut harness = alone.show(super::angles, [420.0, 500.0]);
    harness.run_steps(2);
    assert!(has(&harness, "colours at several angles come"));
}

#[test]
fn the_lobe_is_touched_and_a_click_keeps_the_place() {
    let mut harness = starling().show(super::lobe, [400.0, 800.0]);
    harness.run_steps(3);
    // Without a touch it is the mirror's direction.
    assert!(has(&harness, "towards -30° across, 0° along the barbule"));
    assert!(has(&harness, "there as people see it: #") && has(&harness, "× a white diffuser"));
    let disc = rect(&harness, Role::Image, "lobe over the hemisphere");
    let at = disc.center() + vec2(40.0, -30.0);
    harness.hover_at(at);
    harness.run_steps(2);
    assert!(!has(&harness, "towards -30° across"));
    assert_eq!(harness.state().memory.kept_direction(), None);
    harness.drag_at(at);
    harness.step();
    harness.drop_at(at);
    harness.run_steps(2);
    let kept = harness.state().memory.kept_direction().unwrap();
    assert!(kept[0] > 0.1 && kept[1] > 0.1, "{kept:?}");
    assert!(!has(&harness, "towards -30° across"), "it stays");
    harness.get_by_label("choose what is white").click();
    harness.run_steps(2);
    assert!(harness.query(By::new().role(Role::Slider).label("what is white")).is_some());
    harness.get_by_label("mean over individuals").click();
    harness.run_steps(2);
    assert_eq!(harness.state().done, ["Look(shown)", "Settle"]);
}

#[test]
fn without_a_material_the_individuals_far_field_is_drawn() {
    let mut harness = App::two().show(super::lobe, [400.0, 500.0]);
    harness.run_steps(3);
    assert!(has(&harness, "open, individual 0 at 550 nm: brightest at 0°"));
    assert!(has(&harness, "pinned, individual 0 at 550 nm"));
    let mut empty = App::new(FILM).show(super::lobe, [400.0, 500.0]);
    empty.run_steps(2);
    assert!(has(&empty, "make the material to see it in colour"));
}

#[test]
fn the_section_has_its_media_and_is_looked_at_from_nearer() {
    let mut harness = App::two().show(super::section, [700.0, 700.0]);
    harness.run_steps(3);
    for words in ["melanin", "keratin", "air", "layers of what is open", "section of what is pinned"] {
        assert!(has(&harness, words), "{words}");
    }
    let wide = |harness: &Harness<'_, App>| {
        let images = harness.get_all(By::new().role(Role::Image));
        images.filter_map(|node| node.accesskit_node().label()).next().unwrap_or_default()
    };
    let before = wide(&harness);
    harness.get_by_label("+").click();
    harness.run_steps(2);
    let nearer = wide(&harness);
    assert_ne!(before, nearer);
    let place = rect(&harness, Role::Image, "section of what is open");
    double_click(&mut harness, place.center());
    assert_eq!(wide(&harness), before);
    // Two stacks of one individual have no other.
    assert!(harness.query_by_label("next").is_none());
}

#[test]
fn a_birds_section_is_one_of_many() {
    let mut app = App::new("starling");
    let structure = Structure::builtin("starling:green").unwrap();
    let section = structure.instance(1, 0).unwrap();
    let film = of_stack(FILM).individual.unwrap();
    app.results.own.individual = Some(crate::live::Individual { section, ..film });
    let mut harness = app.show(super::section, [400.0, 600.0]);
    harness.run_steps(3);
    assert!(has(&harness, "open: starling:green") && has(&harness, "individual 0"));
    harness.get_by_label("next").click();
    harness.run_steps(2);
    assert_eq!(harness.state().done, ["Look(individual)", "Settle"]);
    assert_eq!(harness.state().state.view().individual, 1);
}

#[test]
fn the_comparison_names_what_differs_and_swaps() {
    let mut harness = App::two().show(super::comparison, [400.0, 600.0]);
    harness.run_steps(2);
    for words in [
        "colour, people: ΔE00",
        "shift of the peak",
        "peak",
        "brightness",
        "2: keratin",
        "140 nm",
        "100 nm",
        "open as people see it",
    ] {
        assert!(has(&harness, words), "{words}");
    }
    for button in ["swap", "unpin", "pin anew"] {
        harness.get_by_label(button).click();
        harness.run_steps(2);
    }
    assert_eq!(harness.state().done, ["Swap", "Unpin", "Pin"]);
    let mut alone = App::film().show(super::comparison, [400.0, 300.0]);
    alone.run_steps(2);
    alone.get_by_label("pin").click();
    alone.run_steps(2);
    assert_eq!(alone.state().done, ["Pin"]);
}
