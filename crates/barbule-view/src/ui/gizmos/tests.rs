use super::*;
use barbule::open::Opening;
use eframe::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;

fn frames() -> impl Iterator<Item = Frame> {
    let bearings = [(180.0, 90.0), (180.0, 30.0), (40.0, -20.0), (300.0, 0.0)];
    bearings
        .into_iter()
        .map(|(azimuth_deg, elevation_deg)| Camera { azimuth_deg, elevation_deg, ..Camera::usual() }.frame())
}

/// Of the antipode of the camera alone the place is not one, but a circle.
#[test]
fn each_place_of_the_dome_is_one_direction() {
    for frame in frames() {
        for azimuth_deg in [0.0, 77.0, 180.0, 359.0] {
            for elevation_deg in [-80.0, -10.0, 0.0, 35.0, 89.0] {
                let direction = Light { azimuth_deg, elevation_deg, ..Light::usual() }.direction();
                let place = dome_place(direction, &frame);
                let back = dome_direction(place, &frame);
                assert!(back.distance(direction) < 1e-6, "{azimuth_deg} {elevation_deg}: {place:?} {back}");
                // On the rim rounding decides.
                let near = direction.dot(frame.towards);
                assert!(near.abs() < 1e-9 || (place[0].hypot(place[1]) <= 1.0) == (near > 0.0));
                assert!(place[0].hypot(place[1]) <= 1.0 + COLLAR + 1e-12);
            }
        }
        assert!(dome_direction([0.0, 0.0], &frame).distance(frame.towards) < 1e-12);
        assert!(dome_direction([9.0, 9.0], &frame).distance(-frame.towards) < 1e-12);
        assert!(dome_direction([1.0, 0.0], &frame).distance(frame.right) < 1e-12);
    }
}

#[test]
fn directions_have_their_bearings() {
    for (azimuth_deg, elevation_deg) in [(0.0, 0.0), (90.0, 10.0), (200.0, -45.0), (340.0, 50.0)] {
        let direction = Light { azimuth_deg, elevation_deg, ..Light::usual() }.direction();
        let [azimuth, elevation] = bearing_of(direction, 7.0);
        assert!((azimuth - azimuth_deg).abs() < 1e-9 && (elevation - elevation_deg).abs() < 1e-9);
    }
    assert_eq!(bearing_of(DVec3::Z, 7.0), [7.0, 90.0]);
    let camera = Camera { azimuth_deg: 33.0, ..Camera::usual() };
    for (direction, expected) in
        [(DVec3::Z, [33.0, 90.0]), (DVec3::X, [90.0, 0.0]), (-DVec3::Y, [180.0, 0.0])]
    {
        let looks = along(camera, direction);
        assert_eq!([looks.azimuth_deg, looks.elevation_deg], expected);
        assert!(looks.frame().towards.distance(direction) < 1e-12);
    }
}

#[test]
fn scale_bars_have_round_lengths() {
    for (most, length, words) in [
        (7.0, 5.0, "5 mm"),
        (0.2, 0.2, "200 µm"),
        (1.0, 1.0, "1 mm"),
        (0.049, 0.02, "20 µm"),
        (55.0, 50.0, "50 mm"),
        (0.01, 0.01, "10 µm"),
    ] {
        let found = round_length(most);
        assert!((found / length - 1.0).abs() < 1e-9, "{most}: {found}");
        assert_eq!(length_words(found), words);
    }
}

/// A window with a picture and its gizmos over it, and what was done in it.
fn window(text: &str) -> Harness<'static, (State, Vec<Action>, bool)> {
    let state = State::open(text, &Opening::default(), &Unobserved).unwrap();
    let draw = |ui: &mut egui::Ui, (state, actions, took): &mut (State, Vec<Action>, bool)| {
        let rect = ui.available_rect_before_wrap();
        ui.interact(rect, ui.scope_id().with("picture"), Sense::click_and_drag());
        *took = gizmos(ui, rect, state, actions);
    };
    Harness::builder().with_size(vec2(600.0, 400.0)).build_ui_state(draw, (state, Vec::new(), false))
}

/// What was done, applied to a view, by what people call it.
fn done(harness: &mut Harness<'_, (State, Vec<Action>, bool)>) -> Vec<&'static str> {
    let (state, actions, _) = harness.state_mut();
    let apply = |action: Action| match action {
        Action::Look { what, change } => {
            state.look(what, change).unwrap();
            what
        }
        Action::Settle => "settle",
        other => panic!("{other:?}"),
    };
    std::mem::take(actions).into_iter().map(apply).collect()
}

fn drag(harness: &mut Harness<'_, (State, Vec<Action>, bool)>, from: Pos2, to: Pos2) {
    harness.hover_at(from);
    harness.run_steps(1);
    harness.drag_at(from);
    harness.run_steps(1);
    harness.hover_at(to);
    harness.run_steps(2);
    harness.drop_at(to);
    harness.run_steps(1);
}

#[test]
fn the_sun_is_dragged_to_where_the_pointer_is() {
    let mut harness = window("starling");
    harness.run_steps(2);
    let ball = harness.get_by_label("lamp").rect();
    assert!(ball.width() >= 28.0);
    let before = harness.state().0.view().clone();
    let to = ball.center() + vec2(0.5, -0.25) * BALL;
    drag(&mut harness, ball.center(), to);
    let all = done(&mut harness);
    assert!(all.contains(&"light") && all.last() == Some(&"settle"), "{all:?}");
    let view = harness.state().0.view();
    let place = dome_place(view.light.direction(), &view.camera.frame());
    assert!((place[0] - 0.5).abs() < 0.02 && (place[1] - 0.25).abs() < 0.02, "{place:?}");
    assert_eq!(view.camera, before.camera);
}

#[test]
fn the_wheel_over_the_lamp_changes_its_radius() {
    let mut harness = window("starling");
    harness.run_steps(2);
    let before = harness.state().0.view().light;
    let ball = harness.get_by_label("lamp").rect();
    harness.hover_at(ball.center());
    harness.run_steps(1);
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        source: egui::MouseWheelSource::Wheel,
        delta: vec2(0.0, 60.0),
        phase: egui::TouchPhase::Move,
        modifiers: egui::Modifiers::NONE,
    });
    harness.run_steps(8);
    assert!(harness.state().2);
    let all = done(&mut harness);
    assert!(!all.is_empty() && all.iter().all(|what| *what == "light radius"), "{all:?}");
    assert!(harness.state().0.view().light.radius_deg > before.radius_deg);
}

#[test]
fn axes_turn_the_camera_and_a_click_looks_along_them() {
    let mut harness = window("starling");
    harness.run_steps(2);
    let middle = harness.get_by_label("axes").rect().center();
    let before = harness.state().0.view().camera;
    drag(&mut harness, middle, middle + vec2(20.0, 0.0));
    let all = done(&mut harness);
    assert!(all.contains(&"camera") && all.last() == Some(&"settle"), "{all:?}");
    let turned = harness.state().0.view().camera;
    assert!((turned.azimuth_deg - before.azimuth_deg).rem_euclid(360.0) > 1.0);
    harness.run_steps(1);
    let up = ends(middle, &turned.frame()).into_iter().find(|end| end.is_named && end.axis == 2).unwrap();
    harness.hover_at(up.at);
    harness.run_steps(1);
    harness.drag_at(up.at);
    harness.run_steps(1);
    harness.drop_at(up.at);
    harness.run_steps(2);
    done(&mut harness);
    assert_eq!(harness.state().0.view().camera.elevation_deg, 90.0);
}

/// The renderer's camera of a scene has its own upward direction.
#[test]
fn scenes_have_their_own_axes() {
    let state = State::open("starling-bird", &Opening::default(), &Unobserved).unwrap();
    let mut found = None;
    let mut harness = Harness::new_ui(|ui| found = Some(seen(ui, &state)));
    harness.run_steps(1);
    drop(harness);
    let (found, camera) = (found.unwrap(), state.scene(&Unobserved).unwrap().0.camera());
    assert!(found.frame.towards.distance((camera.eye - camera.target).normalize()) < 1e-12);
    assert!(found.frame.up.dot(camera.up) > 0.9 && found.width_mm == camera.width_mm);
    assert!(found.frame.right.cross(found.frame.up).distance(found.frame.towards) < 1e-12);
}
