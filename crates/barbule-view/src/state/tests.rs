//! The viewer without its window, from opening to saving.

use super::*;
use barbule::Unobserved;

fn opened(text: &str) -> State {
    State::open(text, &Opening::default(), &Unobserved).unwrap()
}

fn cortex(state: &State) -> f64 {
    state.subject().sliders().into_iter().find(|slider| slider.key == "cortex_um").unwrap().value
}

#[test]
fn things_are_opened_as_they_look_best() {
    let starling = opened("starling");
    assert_eq!((starling.view().mode, starling.view().camera.width_mm), (Mode::Feather, 1.6));
    assert_eq!((starling.view().light.azimuth_deg, starling.view().light.elevation_deg), (340.0, 50.0));
    assert_eq!(opened("starling-feather").view().mode, Mode::Scene);
    assert_eq!(opened("xenopeltis").view().mode, Mode::Sphere);
    // Each can be drawn from there.
    for text in ["starling", "starling-feather", "xenopeltis", "air/keratin:300/melanin", "magpie"] {
        let state = opened(text);
        state.scene(&Unobserved).unwrap();
        assert!(state.picture_command([64, 48], &Unobserved).unwrap().line().starts_with("barbule render "));
    }
}

#[test]
fn every_change_is_undone_and_done_again() {
    let mut state = opened("starling");
    let first = cortex(&state);
    for value in [0.3, 0.29, 0.28] {
        state.move_size("cortex_um", value).unwrap();
    }
    state.settle();
    state.look("light", |view| view.light = view.light.moved([10.0, 0.0])).unwrap();
    state.look("light", |view| view.light = view.light.moved([10.0, 0.0])).unwrap();
    state.choose(Mode::Sphere, &Unobserved).unwrap();
    assert_eq!(state.steps(), [3, 0]);
    assert!(state.undo().unwrap());
    assert_eq!((state.view().mode, state.view().light.azimuth_deg), (Mode::Feather, 0.0));
    assert!(state.undo().unwrap());
    assert_eq!((state.view().light.azimuth_deg, cortex(&state)), (340.0, 0.28));
    assert!(state.undo().unwrap());
    assert_eq!((cortex(&state), state.undo().unwrap()), (first, false));
    assert!(
        state.redo().unwrap() && state.redo().unwrap() && state.redo().unwrap() && !state.redo().unwrap()
    );
    assert_eq!((state.view().mode, cortex(&state)), (Mode::Sphere, 0.28));
    state.reset_sizes().unwrap();
    assert_eq!((cortex(&state), state.steps()), (first, [4, 0]));
    // What changes nothing is no change.
    state.reset_sizes().unwrap();
    assert_eq!(state.steps(), [4, 0]);
}

#[test]
fn what_cannot_be_is_refused_and_leaves_everything_as_it_was() {
    let mut state = opened("starling");
    let before = state.setting();
    let refusals = [
        state.move_size("cortex_um", 300.0).unwrap_err(),
        state.move_size("cortx_um", 0.3).unwrap_err(),
        state.look("mode", |view| view.mode = Mode::Snake).unwrap_err(),
        state.look("camera", |view| view.camera.width_mm = -1.0).unwrap_err(),
        state.look("eye", |view| view.eye = Seer::Bird("dodo-of-mauritius".into())).unwrap_err(),
    ];
    let words = [
        "outside 0.001 to 10",
        "did you mean 'cortex_um'?",
        "view.mode is snake, but a species is shown as sphere",
        "camera.width_mm is -1, outside 0.05 to 2000",
        "there is no eye 'dodo-of-mauritius'",
    ];
    for (refused, words) in refusals.iter().zip(words) {
        assert!(refused.is_input() && refused.to_string().contains(words), "{refused}");
    }
    assert_eq!((state.setting(), state.steps()), (before, [0, 0]));
}

#[test]
fn what_is_pinned_is_compared_and_swapped() {
    let mut state = opened("starling:green");
    assert!(state.differences().is_empty() && !state.swap(&Unobserved).unwrap());
    state.pin();
    state.move_size("cortex_um", 0.2).unwrap();
    let first = state.pinned().unwrap().sliders().into_iter().find(|s| s.key == "cortex_um").unwrap().value;
    let differences = state.differences();
    assert_eq!(differences.len(), 1);
    assert_eq!((differences[0].0.value, differences[0].1), (0.2, first));
    assert!(state.swap(&Unobserved).unwrap());
    assert_eq!((cortex(&state), state.pinned().unwrap().is_moved()), (first, true));
    state.unpin();
    assert!(state.pinned().is_none() && state.differences().is_empty());
}

#[test]
fn a_viewer_is_saved_and_opened_again_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("view.toml").to_string_lossy().into_owned();
    let mut state = opened("starling:pink");
    state.pin();
    state.move_size("cortex_um", 0.21).unwrap();
    state.look("eye", |view| view.eye = Seer::Bird("starling".into())).unwrap();
    state.choose(Mode::Vane, &Unobserved).unwrap();
    std::fs::write(&file, state.text_of(Export::State, &Unobserved).unwrap()).unwrap();
    let again = opened(&file);
    assert_eq!(again.setting(), state.setting());
    assert_eq!(again.pinned().unwrap().text(), "starling:pink");
    assert_eq!(again.saved(), state.saved());
    for (text, words) in [
        (
            "barbule_view = 1\nopen = 'starlign'",
            "open: there is no preset, species or file 'starlign', did you mean 'starling'?",
        ),
        (
            "barbule_view = 1\nopen = 'starling'\n[sizes]\ncortex_um = 99",
            "open: sizes: starling:green: parameters.cortex_um is 99, outside",
        ),
        (
            "barbule_view = 1\nopen = 'air/keratin:300/air'\n[sizes]\ncortex_um = 0.3",
            "has no size 'cortex_um'",
        ),
        (
            "barbule_view = 1\nopen = 'snake'\n[view]\nmode = 'vane'",
            "view.mode is vane, but a scene is shown as scene",
        ),
        ("barbule_view = 3\nopen = 'starling'", "barbule_view is 3, but this version reads format 1 only"),
    ] {
        std::fs::write(&file, text).unwrap();
        let refused = State::open(&file, &Opening::default(), &Unobserved).unwrap_err();
        assert!(
            refused.to_string().contains(words) && refused.to_string().contains("view.toml"),
            "{refused}"
        );
    }
}

#[test]
fn texts_are_those_of_what_is_open() {
    let mut state = opened("starling:pink");
    state.move_size("cortex_um", 0.21).unwrap();
    assert!(state.text_of(Export::Species, &Unobserved).unwrap().contains("cortex_um = 0.21"));
    let scene = state.text_of(Export::Scene, &Unobserved).unwrap();
    assert_eq!(SceneDescription::parse(&scene).unwrap().material(), Some("my-starling.toml"));
    let refused = opened("snake").text_of(Export::Species, &Unobserved).unwrap_err().to_string();
    assert_eq!(refused, "of a scene no species are written as text");
}

#[test]
fn dropped_files_are_opened_or_drawn_beside() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let mut state = opened("starling");
    state.pin();
    let measured = file("back.csv", "wl,R\n400,10\n500,30\n600,20\n700,20\n");
    assert_eq!(state.drop_file(&measured, &Unobserved).unwrap(), Dropped::Measured);
    assert_eq!(state.beside()[0].name(), "back");
    let stack = file("stack.toml", "stack = 'air/keratin:300/melanin'");
    assert_eq!(state.drop_file(&stack, &Unobserved).unwrap(), Dropped::Opened);
    assert_eq!((state.subject().kind(), state.beside().len()), ("stack", 1));
    assert_eq!(state.pinned().unwrap().text(), "starling");
    // It is saved and read again.
    let saved = file("view.toml", &state.text_of(Export::State, &Unobserved).unwrap());
    let again = opened(&saved.to_string_lossy());
    assert_eq!((again.beside().len(), again.saved()), (1, state.saved()));
    for (path, words) in [
        (file("b.txt", "no numbers"), "b.txt"),
        (folder.path().join("none.csv"), "none.csv"),
        (file("bad.toml", "stack = 'air'"), "bad.toml"),
    ] {
        let refused = state.drop_file(&path, &Unobserved).unwrap_err();
        assert!(refused.to_string().contains(words), "{refused}");
        assert_eq!((state.subject().kind(), state.beside().len()), ("stack", 1));
    }
    for _ in 1..Beside::MOST {
        state.drop_file(&measured, &Unobserved).unwrap();
    }
    let refused = state.drop_file(&measured, &Unobserved).unwrap_err().to_string();
    assert!(refused.contains("8 measured spectra are shown"), "{refused}");
    state.take_away(0);
    assert_eq!(state.beside().len(), Beside::MOST - 1);
}

#[test]
fn a_feathers_window_is_that_of_its_preset() {
    let (feather, window) = opened("starling").feather(&Unobserved).unwrap();
    assert_eq!((window.along_mm, window.radius_mm, feather.shaft.length_mm), (25.0, Some(2.5), 30.0));
    let refused = opened("snake").feather(&Unobserved).unwrap_err().to_string();
    assert!(refused.contains("shows no feather by itself"), "{refused}");
}
