use super::controls::{memory_words, picture_words};
use super::*;
use barbule::open::Opening;
use eframe::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;

#[test]
fn every_barbule_is_what_the_guide_says() {
    let mut scene = SceneDescription::named("starling-bird").unwrap();
    assert!(every_barbule(&mut scene));
    let guide = "preset = 'starling-bird'\n[detail]\nlevel = 'barbules'\n[coat]\nvariants = 2";
    assert_eq!(scene, SceneDescription::parse(guide).unwrap());
    let gigabytes = scene.bytes(&BTreeMap::new()) as f64 / 1e9;
    assert!((3.5..5.0).contains(&gigabytes), "{gigabytes}");
    assert!(!every_barbule(&mut SceneDescription::named("snake").unwrap()));
    assert_eq!((memory_words(4_212_000_000), memory_words(89_100_000)), ("4.2 GB".into(), "89 MB".into()));
}

#[test]
fn flights_begin_and_end_where_they_should_and_widths_fall_evenly() {
    let from =
        Camera { azimuth_deg: 350.0, elevation_deg: 10.0, width_mm: 250.0, target_mm: [0.0, 10.0, 0.0] };
    let to = Camera { azimuth_deg: 10.0, elevation_deg: 30.0, width_mm: 1.0, target_mm: [20.0, 0.0, 5.0] };
    let flight = Flight::new(from, to);
    assert_eq!((flight.at(0.0), flight.at(-1.0)), (from, from));
    let end = flight.at(1.0);
    assert!((end.width_mm - 1.0).abs() < 1e-9 && (end.azimuth_deg - 10.0).abs() < 1e-9);
    let middle = flight.at(0.5);
    assert!((middle.width_mm - 250.0_f64.sqrt()).abs() < 1e-9);
    // Through north, not all the way round.
    assert!(middle.azimuth_deg < 1e-9 || middle.azimuth_deg > 359.9, "{}", middle.azimuth_deg);
    let mut before = from;
    for k in 1..=50 {
        let now = flight.at(f64::from(k) / 50.0);
        assert!(now.width_mm <= before.width_mm);
        // What it ends at comes no further from the middle of the picture.
        let off =
            |camera: Camera| DVec3::from(camera.target_mm).distance(to.target_mm.into()) / camera.width_mm;
        assert!(off(now) < off(from) * 1.01 + 1e-9, "{k}");
        before = now;
    }
    let still = Flight::new(from, Camera { width_mm: 250.0, ..to });
    assert!(DVec3::from(still.at(0.5).target_mm).distance(DVec3::new(10.0, 5.0, 2.5)) < 1e-9);
}

/// What is under the pointer stays there.
#[test]
fn zooming_keeps_a_place_where_it_is() {
    let camera = Camera { width_mm: 20.0, target_mm: [1.0, 2.0, 3.0], ..Camera::usual() };
    let place = DVec3::new(4.0, 1.0, 5.0);
    let near = nearer(camera, place, 0.25);
    let seen = |camera: Camera| {
        let frame = camera.frame();
        let eye = frame.target_mm + frame.towards * (Camera::DISTANCE * camera.width_mm);
        let [x, y, z] = [frame.right, frame.up, frame.towards].map(|axis| (place - eye).dot(axis));
        [x / z, y / z]
    };
    assert!((near.width_mm - 5.0).abs() < 1e-12);
    assert!((0..2).all(|k| (seen(near)[k] - seen(camera)[k]).abs() < 1e-12));
    // At the least width nothing moves any more.
    let least = Camera { width_mm: 0.05, ..camera };
    assert_eq!(nearer(least, place, 0.5), least);
}

#[test]
fn pictures_have_at_most_so_many_pixels() {
    assert_eq!(pixels(vec2(800.0, 600.0)), [800, 600]);
    let [width, height] = pixels(vec2(4000.0, 2000.0));
    assert!(f64::from(width * height) < 1.01 * MOST_PIXELS && width == 2 * height);
}

/// A window with a traced picture, and what was done in it.
struct Desk {
    state: State,
    memory: Traced,
    actions: Vec<Action>,
    all: Vec<String>,
}

fn window(text: &str, change: impl FnOnce(&mut State)) -> Harness<'static, Desk> {
    let mut state = State::open(text, &Opening::default(), &Unobserved).unwrap();
    change(&mut state);
    let draw = |ui: &mut egui::Ui, desk: &mut Desk| {
        traced(ui, &desk.state, &mut desk.memory, &mut desk.actions);
        for action in std::mem::take(&mut desk.actions) {
            desk.all.push(format!("{action:?}"));
            match action {
                Action::Look { what, change } => desk.state.look(what, change).unwrap(),
                Action::Settle => desk.state.settle(),
                other => panic!("{other:?}"),
            }
        }
    };
    let mut memory = Traced::default();
    memory.settings.samples = 4;
    let desk = Desk { state, memory, actions: Vec::new(), all: Vec::new() };
    Harness::builder().with_size(vec2(900.0, 200.0)).build_ui_state(draw, desk)
}

fn until(harness: &mut Harness<'_, Desk>, condition: impl Fn(&Desk) -> bool) {
    let start = std::time::Instant::now();
    while !condition(harness.state()) {
        assert!(start.elapsed().as_secs() < 60, "it never happens: {:?}", harness.state().memory.failed);
        std::thread::sleep(std::time::Duration::from_millis(5));
        harness.run_steps(1);
    }
}

/// A file of a small scene: the harness traces it in a moment.
fn ball(folder: &tempfile::TempDir) -> String {
    let file = folder.path().join("ball.toml");
    let text = "shows_feather = false\nsky = 0.5\n[light]\nazimuth_deg = 300\nelevation_deg = 40\nradius_deg = 5\nstrength = 2\n[camera]\nazimuth_deg = 180\nelevation_deg = 20\nwidth_mm = 26\n[surfaces.skin]\ntype = 'diffuse'\ncolour = '#a05020'\n[[objects]]\nname = 'ball'\nsurface = 'skin'\nsphere_mm = 10\n";
    std::fs::write(&file, text).unwrap();
    file.to_string_lossy().into_owned()
}

#[test]
fn the_window_shows_samples_as_they_come_and_dragging_turns_the_camera() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(&ball(&folder), |_| {});
    until(&mut harness, |desk| desk.memory.is_done);
    harness.run_steps(1);
    let picture = harness.state().memory.picture.clone().unwrap();
    assert!(harness.get_all_by_label_contains("4 samples · noise").count() == 1);
    assert!(picture_words(&picture).starts_with("4 samples · noise "));
    let (size, rgba) = harness.state().memory.picture().unwrap();
    assert_eq!(rgba.len(), 4 * size[0] as usize * size[1] as usize);
    let rect = harness.get_by_label("traced picture").rect();
    let before = harness.state().state.view().camera;
    let from = rect.center() - vec2(0.0, 40.0);
    harness.hover_at(from);
    harness.run_steps(1);
    harness.drag_at(from);
    harness.run_steps(1);
    harness.hover_at(from + vec2(50.0, 0.0));
    harness.run_steps(2);
    harness.drop_at(from + vec2(50.0, 0.0));
    harness.run_steps(2);
    let turned = harness.state().state.view().camera;
    assert!((turned.azimuth_deg - before.azimuth_deg).rem_euclid(360.0) > 5.0, "{turned:?}");
    assert!(harness.state().all.ends_with(&["Settle".to_owned()]), "{:?}", harness.state().all);
    until(&mut harness, |desk| desk.memory.is_done && !desk.memory.is_busy());
    let camera = harness.state().memory.picture.as_ref().unwrap().camera;
    assert!((camera.eye - camera.target).normalize().distance(turned.frame().towards) < 1e-9);
}

#[test]
fn the_wheel_zooms_and_a_flight_arrives() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(&ball(&folder), |_| {});
    until(&mut harness, |desk| desk.memory.is_done);
    let rect = harness.get_by_label("traced picture").rect();
    harness.hover_at(rect.center());
    harness.run_steps(1);
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        source: egui::MouseWheelSource::Wheel,
        delta: vec2(0.0, 50.0),
        phase: egui::TouchPhase::Move,
        modifiers: egui::Modifiers::NONE,
    });
    harness.run_steps(8);
    assert!(harness.state().state.view().camera.width_mm < 25.0);
    // The flight ends at what is in the middle: the ball's skin.
    harness.get_by_label("Fly to barbules").click();
    harness.run_steps(2);
    assert!(harness.state().memory.flight.is_some());
    harness.get_by_label("Stop");
    until(&mut harness, |desk| desk.memory.flight.is_none());
    let camera = harness.state().state.view().camera;
    assert!((camera.width_mm - 1.0).abs() < 1e-9);
    assert!((DVec3::from(camera.target_mm).length() - 10.0).abs() < 0.5, "{camera:?}");
    assert!(harness.state().all.ends_with(&["Settle".to_owned()]));
}

#[test]
fn errors_are_shown_and_memory_is_foretold() {
    let mut harness = window("starling-feather", |_| {});
    harness.run_steps(2);
    assert!(harness.get_all_by_label_contains("every barbule (").count() == 1);
    harness.state_mut().memory.stop();
    drop(harness);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bad.toml");
    let text = std::fs::read_to_string(ball(&folder)).unwrap();
    std::fs::write(&file, text.replace("sphere_mm = 10", "mesh = 'nowhere.ply'")).unwrap();
    let mut harness = window(&file.to_string_lossy(), |_| {});
    until(&mut harness, |desk| desk.memory.failed.is_some());
    harness.run_steps(1);
    assert!(harness.get_all_by_label_contains("nowhere.ply").count() == 1);
}
