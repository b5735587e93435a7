//! The whole window without a window: what hands and keys do to the state, what is shown of it, and two pictures of everything.

use super::*;
use crate::live::MaterialFound;
use crate::state::{Export, Seer, Shown};
use barbule::open::Opening;
use eframe::egui::{Key, Modifiers, PointerButton, Pos2, Role, Vec2, vec2};
use eframe::egui_wgpu::RenderState;
use egui_kittest::kittest::Queryable as _;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use egui_kittest::{Harness, HarnessBuilder, SnapshotOptions};
use std::time::{Duration, Instant};

/// A window's size, points.
const SIZE: Vec2 = Vec2::new(900.0, 600.0);
/// Means over few individuals, and small lobes.
const LITTLE: Effort = Effort { individuals: 2, lobe_pixels: 16, draws: true };
const STACK: &str = "air/keratin:300/melanin";

/// An app that is made in its first frame, since that needs the window's context.
struct Held {
    app: Option<App>,
    start: Option<Start>,
    adapter: Option<Adapter>,
}

type Window = Harness<'static, Held>;

fn start(text: &str) -> Start {
    let state = State::open(text, &Opening::default(), &Unobserved).unwrap();
    Start { state, folder: PathBuf::new(), saving: None, words: None, effort: LITTLE }
}

fn built(builder: HarnessBuilder<Held>, start: Start, adapter: Option<Adapter>) -> Window {
    let held = Held { app: None, start: Some(start), adapter };
    let draw = |ui: &mut Ui, held: &mut Held| {
        if let Some(start) = held.start.take() {
            held.app = Some(App::new(ui.ctx(), held.adapter.take(), start).unwrap());
        }
        // Behind the margin that a window has not.
        let behind = ui.ctx().layer_painter(egui::LayerId::background());
        behind.rect_filled(ui.ctx().content_rect(), 0.0, look::BEHIND);
        held.app.as_mut().unwrap().draw(ui);
    };
    let mut window = builder.with_size(SIZE).build_ui_state(draw, held);
    window.run_steps(2);
    window
}

fn window(text: &str) -> Window {
    built(Harness::builder(), start(text), None)
}

fn app(window: &Window) -> &App {
    window.state().app.as_ref().unwrap()
}

/// Draws frames until nothing is computed any more, nor is asked for because of what was found last.
fn finish(window: &mut Window) {
    let start = Instant::now();
    let mut idle = 0;
    while idle < 3 {
        window.step();
        idle = if app(window).is_busy() { 0 } else { idle + 1 };
        assert!(start.elapsed() < Duration::from_secs(60), "it never ends");
        std::thread::sleep(Duration::from_millis(2));
    }
    window.run_steps(3);
}

fn press(window: &mut Window, modifiers: Modifiers, key: Key) {
    window.key_press_modifiers(modifiers, key);
    window.run_steps(2);
}

fn click(window: &mut Window, label: &str) {
    window.get_by_role_and_label(Role::Button, label).click();
    window.run_steps(3);
}

fn thickness(window: &Window) -> f64 {
    app(window).state().subject().sliders()[0].value
}

#[test]
fn sliders_move_the_state_and_undo_restores_it() {
    let mut window = window(STACK);
    let name = app(&window).state().subject().sliders()[0].name.clone();
    window.get_by_role_and_label(Role::Slider, &name).set_value_accesskit(250.0);
    window.run_steps(3);
    assert_eq!(thickness(&window), 250.0);
    // The film is computed anew.
    finish(&mut window);
    let curves = app(&window).results().own.curves.clone().unwrap();
    assert_eq!((curves.angle.len(), app(&window).results().own.is_whole), (18, true));
    click(&mut window, "Undo");
    assert_eq!(thickness(&window), 300.0);
    finish(&mut window);
    assert_ne!(app(&window).results().own.curves.as_ref().unwrap().reflected, curves.reflected);
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(thickness(&window), 250.0);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(thickness(&window), 300.0);
}

#[test]
fn what_is_pinned_is_computed_too_and_swapped() {
    let mut window = window(STACK);
    click(&mut window, "Pin");
    assert!(app(&window).state().pinned().is_some());
    let done = window.state_mut().app.as_mut().unwrap().state.move_size("thickness_nm[0]", 200.0);
    assert!(done.is_ok());
    finish(&mut window);
    let results = app(&window).results();
    assert_ne!(results.own.curves, results.pinned.curves);
    assert!(results.pinned.curves.is_some() && results.pinned.individual.is_some());
    press(&mut window, Modifiers::NONE, Key::X);
    assert_eq!(thickness(&window), 300.0);
    press(&mut window, Modifiers::NONE, Key::P);
    finish(&mut window);
    assert!(app(&window).state().pinned().is_none() && app(&window).results().pinned.curves.is_none());
}

#[test]
fn modes_eyes_and_individuals_are_chosen_by_buttons_and_keys() {
    let mut window = window(STACK);
    for (label, mode) in [("sphere", Mode::Sphere), ("vane", Mode::Vane), ("feather", Mode::Feather)] {
        click(&mut window, label);
        assert_eq!(app(&window).state().view().mode, mode);
    }
    press(&mut window, Modifiers::NONE, Key::Num1);
    assert_eq!(app(&window).state().view().mode, Mode::Sphere);
    // A stack is not shown on a snake: the key says so.
    press(&mut window, Modifiers::NONE, Key::Num4);
    assert!(app(&window).words().unwrap().contains("view.mode is snake"));
    let shown = app(&window).state().view().shown;
    press(&mut window, Modifiers::NONE, Key::I);
    assert_ne!(app(&window).state().view().shown, shown);
    click(&mut window, "mean");
    assert_eq!(app(&window).state().view().shown, Shown::Mean);
    window.get_by_role(Role::ComboBox).click();
    window.run_steps(3);
    window.get_by_label("bird: starling").click();
    window.run_steps(3);
    assert_eq!(app(&window).state().view().eye, Seer::Bird("starling".into()));
    finish(&mut window);
    let curves = app(&window).results().own.curves.clone().unwrap();
    assert_eq!(curves.at.range_nm(), (300.0, 700.0));
}

#[test]
fn the_help_lists_every_key_and_closes() {
    let mut window = window(STACK);
    press(&mut window, Modifiers::NONE, Key::F1);
    window.run_steps(2);
    for row in keys::ROWS {
        assert!(window.query_all_by_label(row.does).next().is_some(), "{}", row.keys);
    }
    for (what, _) in keys::HANDS {
        assert!(window.query_all_by_label(what).next().is_some(), "{what}");
    }
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(window.query_by_label(keys::ROWS[0].does).is_none());
}

/// A file that is dropped.
#[derive(Debug)]
struct File(PathBuf);

impl egui::DroppedFile for File {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> std::result::Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

#[test]
fn dropped_files_are_drawn_beside_or_opened_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let mut window = window(STACK);
    let mut drop = |path: PathBuf| {
        window.input_mut().dropped_files.push(Arc::new(File(path)));
        window.run_steps(2);
        let app = app(&window);
        (app.state().beside().len(), app.state().subject().text().to_owned(), app.words().unwrap().to_owned())
    };
    let (count, _, words) = drop(file("back.csv", "wl,R\n400,10\n500,30\n600,20\n700,20\n"));
    assert!(count == 1 && words.contains("back.csv is drawn beside the spectrum"), "{words}");
    let stack = file("stack.toml", "stack = 'air/keratin:310/melanin'");
    let (count, text, _) = drop(stack.clone());
    assert_eq!((count, text), (1, stack.display().to_string()));
    let (count, text, words) = drop(file("none.txt", "nothing"));
    assert_eq!((count, text), (1, stack.display().to_string()));
    assert!(words.contains("none.txt"), "{words}");
}

#[test]
fn what_is_typed_is_opened_or_refused_in_a_sentence_that_can_be_dismissed() {
    let mut window = window(STACK);
    let mut open = |text: &str| {
        press(&mut window, Modifiers::COMMAND, Key::O);
        window.get_by_label("Open").type_text(text);
        window.run_steps(2);
        press(&mut window, Modifiers::NONE, Key::Enter);
        app(&window).state().subject().text().to_owned()
    };
    assert_eq!(open("starlign"), STACK);
    assert_eq!(open("air/keratin:400/air"), "air/keratin:400/air");
    assert_eq!(open("nowhere.toml"), "air/keratin:400/air");
    assert!(app(&window).words().unwrap().contains("no such file"));
    click(&mut window, "Dismiss");
    assert_eq!(app(&window).words(), None);
    // The arrows come to what is found.
    press(&mut window, Modifiers::COMMAND, Key::O);
    window.get_by_label("Open").type_text("xenopel");
    window.run_steps(2);
    press(&mut window, Modifiers::NONE, Key::ArrowDown);
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert_eq!(app(&window).state().subject().text(), "xenopeltis");
}

#[test]
fn hands_turn_move_and_zoom_the_picture_and_a_drag_is_one_change() {
    let mut window = window(STACK);
    let view = |window: &Window| app(window).state().view().clone();
    let middle: Pos2 = window.get_by_label("picture").rect().center();
    let first = view(&window);
    window.drag_at(middle);
    window.step();
    for way in [10.0, 20.0] {
        window.hover_at(middle + vec2(way, 0.0));
        window.step();
    }
    window.drop_at(middle + vec2(20.0, 0.0));
    window.run_steps(2);
    let turned = view(&window);
    assert!((turned.camera.azimuth_deg - first.camera.azimuth_deg - 9.0).abs() < 1e-3);
    assert_eq!((turned.light, app(&window).state().steps()), (first.light, [1, 0]));
    window.hover_at(middle);
    window.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        source: egui::MouseWheelSource::Wheel,
        delta: vec2(0.0, 50.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    window.run_steps(12);
    assert!(view(&window).camera.width_mm < 0.9 * first.camera.width_mm);
    assert_eq!(app(&window).state().steps(), [2, 0]);
    window.key_down(Key::L);
    window.drag_at(middle);
    window.step();
    window.hover_at(middle + vec2(0.0, -20.0));
    window.step();
    window.drop_at(middle + vec2(0.0, -20.0));
    window.key_up(Key::L);
    window.run_steps(2);
    assert!((view(&window).light.elevation_deg - first.light.elevation_deg - 9.0).abs() < 1e-3);
    press(&mut window, Modifiers::NONE, Key::R);
    assert_eq!(view(&window).camera, first.camera);
    press(&mut window, Modifiers::SHIFT, Key::ArrowUp);
    press(&mut window, Modifiers::NONE, Key::ArrowUp);
    press(&mut window, Modifiers::NONE, Key::Plus);
    assert!(view(&window).camera.elevation_deg > first.camera.elevation_deg);
    assert!(view(&window).camera.width_mm < first.camera.width_mm);
    // Pans by the right button.
    let target = view(&window).camera.target_mm;
    for (place, pressed) in
        [(middle, true), (middle + vec2(30.0, 0.0), true), (middle + vec2(30.0, 0.0), false)]
    {
        window.hover_at(place);
        window.event(egui::Event::PointerButton {
            pos: place,
            button: PointerButton::Secondary,
            pressed,
            modifiers: Modifiers::NONE,
        });
        window.step();
    }
    assert_ne!(view(&window).camera.target_mm, target);
}

#[test]
fn files_are_written_where_their_names_say() {
    let folder = tempfile::tempdir().unwrap();
    let mut window =
        built(Harness::builder(), Start { folder: folder.path().to_owned(), ..start(STACK) }, None);
    finish(&mut window);
    click(&mut window, "Export");
    window.get_by_label("Spectra as a table (CSV)...").click();
    window.run_steps(3);
    click(&mut window, "Write");
    let file = folder.path().join("air-keratin-300-melanin-spectrum.csv");
    assert!(std::fs::read_to_string(file).unwrap().starts_with("angle_deg,wavelength_nm,mean\n"));
    assert!(app(&window).words().unwrap().contains("-spectrum.csv is written"));
    press(&mut window, Modifiers::NONE, Key::C);
    assert!(app(&window).words().unwrap().contains("is in the clipboard; it reads scene.toml"));
    assert!(folder.path().join("scene.toml").exists());
    // Without an adapter there is no picture, and that is said.
    let app = window.state_mut().app.as_mut().unwrap();
    let refused = app.write(Export::Picture, &folder.path().join("a.png")).unwrap_err().to_string();
    assert!(refused.starts_with("No graphics adapter is there"), "{refused}");
}

#[test]
fn species_become_known_step_by_step_and_materials_are_made_when_asked() {
    let mut window = window("starling");
    finish(&mut window);
    let of = &app(&window).results().own;
    assert_eq!((of.individuals, of.is_whole, of.curves.as_ref().unwrap().angle.len()), (2, true, 6));
    // It ships with its material, of which the lobe is drawn.
    assert!(matches!(of.material, Some(MaterialFound { thinned: None, .. })));
    assert_eq!((of.brdf.is_some(), of.hemisphere.as_ref().unwrap().side), (true, 16));
    assert!(of.individual.as_ref().unwrap().lobe.is_some());
    let app_of = |window: &mut Window| window.state_mut().app.take().unwrap();
    let mut changed = app_of(&mut window);
    changed.state.move_size("cortex_um", 0.2).unwrap();
    window.state_mut().app = Some(changed);
    finish(&mut window);
    let of = &app(&window).results().own;
    assert!(of.material.is_none() && of.brdf.is_none() && of.hemisphere.is_none());
    // Esc stops what is asked for.
    press(&mut window, Modifiers::NONE, Key::M);
    assert!(app(&window).is_busy());
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(!app(&window).is_busy() && app(&window).results().own.material.is_none());
}

/// Differences of a pixel's colour that the rounding of different adapters makes, as kittest measures them.
const COLOUR: f32 = 1.5;
/// Pixels of 540000 that may differ more: letters' edges, and the rim of the sphere.
const PIXELS: usize = 1000;
/// Frames of which the compared picture is the mean.
const FRAMES: usize = 4;

/// An adapter as a window has one; none, with a line, where the machine has none.
fn adapter() -> Option<RenderState> {
    match Gpu::new(None) {
        Ok(_) => {
            Some(create_render_state(default_wgpu_setup(), eframe::egui_wgpu::RendererOptions::PREDICTABLE))
        }
        Err(error) => {
            eprintln!("no picture of the window is compared: {error}");
            None
        }
    }
}

/// The pictures lie in `tests/snapshots`; `UPDATE_SNAPSHOTS=true` writes them anew where they differ. They are kept small: packed anew
/// without loss, and looked at, before they are committed.
#[test]
fn the_whole_window_looks_as_it_did() {
    let Some(render) = adapter() else { return };
    let gpu = Gpu::of(render.device.clone(), render.queue.clone(), render.adapter.get_info());
    let adapter = Adapter { gpu, format: render.target_format };
    let builder = Harness::builder().renderer(WgpuTestRenderer::from_render_state(render));
    let mut start = start(STACK);
    start.state.choose(Mode::Sphere, &Unobserved).unwrap();
    let mut window = built(builder, start, Some(adapter));
    // The adapter's name is another elsewhere.
    window.state_mut().app.as_mut().unwrap().adapter = "adapter".into();
    finish(&mut window);
    let options = SnapshotOptions::new().threshold(COLOUR).max_failed_pixels(PIXELS);
    // Each picture makes the sphere finer, as frames of a window do.
    (0..FRAMES).for_each(|_| drop(window.render().unwrap()));
    window.snapshot_options("window_sphere", &options);
    press(&mut window, Modifiers::NONE, Key::P);
    let app = window.state_mut().app.as_mut().unwrap();
    app.state.move_size("thickness_nm[0]", 230.0).unwrap();
    finish(&mut window);
    // Of the second the interface alone is compared, so that its file is small.
    let picture = window.get_by_label("picture").rect();
    window.mask(picture);
    window.snapshot_options("window_pinned", &options);
}
