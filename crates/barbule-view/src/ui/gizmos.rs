//! The lamp, the camera's axes and a scale bar, drawn over a picture.
//!
//! The lamp stands on a little ball as the camera sees it, orthographically: in the disc it lights what is seen, in the collar about it it
//! stands behind. Each place of disc and collar is one direction, so a hand that drags the sun never loses it.

use std::f32::consts::TAU;

use barbule::{DVec3, Unobserved};
use eframe::egui::{
    Align2, Color32, CursorIcon, FontId, Id, Pos2, Rect, Response, Role, Sense, Shape, Stroke, Ui, Vec2,
    WidgetInfo, pos2, vec2,
};

use super::Action;
use crate::state::{Camera, Frame, Light, Mode, State};

/// Radius of the ball with the lamp, points.
const BALL: f32 = 36.0;
/// The collar for lamps behind is so wide, over the ball's radius.
const COLLAR: f64 = 0.4;
/// Radius of the axes, points, and of the round ends that are touched.
const AXES: f32 = 40.0;
const END: f32 = 14.0;
/// From the picture's edge, points.
const MARGIN: f32 = 12.0;
/// Pictures smaller than this have the scale bar alone, points.
const LEAST: Vec2 = vec2(280.0, 170.0);
/// Degrees that a camera turns for a point of the screen.
pub(super) const DEG_PER_POINT: f64 = 0.45;
/// The angular radii that lamps may have, degrees, and how fast the wheel changes them, per point.
const RADIUS_DEG: [f64; 2] = [0.1, 60.0];
const RADIUS_PER_POINT: f64 = 0.004;
/// Below this sine of its distance from the zenith a direction has no azimuth of its own.
const AT_ZENITH: f64 = 1e-6;

const LINE: Color32 = Color32::from_rgb(0xe8, 0xe8, 0xe8);
const DIM: Color32 = Color32::from_rgb(0x9a, 0x9a, 0x9a);
const BEHIND: Color32 = Color32::from_rgba_premultiplied(0, 0, 0, 0xa0);
const SUN: Color32 = Color32::from_rgb(0xff, 0xd8, 0x5c);

/// The scene's axes: their names at one end, their directions, and colours that are told apart without red or green (Okabe & Ito).
const AXIS: [(&str, DVec3, Color32); 3] = [
    ("across", DVec3::X, Color32::from_rgb(0x56, 0xb4, 0xe9)),
    ("tip", DVec3::Y, Color32::from_rgb(0xe6, 0x9f, 0x00)),
    ("up", DVec3::Z, Color32::from_rgb(0xf0, 0xf0, 0xf0)),
];

/// Where a lamp in this direction is drawn: to the right and upwards, in radii of the ball. `direction`: a unit vector towards it.
#[must_use]
pub(super) fn dome_place(direction: DVec3, frame: &Frame) -> [f64; 2] {
    let [x, y, z] = [frame.right, frame.up, frame.towards].map(|axis| direction.dot(axis));
    let sine = x.hypot(y);
    let radius = if z >= 0.0 { sine } else { 1.0 + COLLAR * (1.0 - sine) };
    if sine < 1e-9 { [radius, 0.0] } else { [x * radius / sine, y * radius / sine] }
}

/// The unit vector towards a lamp that is drawn there; beyond the collar, as at its edge.
#[must_use]
pub(super) fn dome_direction([x, y]: [f64; 2], frame: &Frame) -> DVec3 {
    let radius = x.hypot(y);
    let (sine, side) =
        if radius <= 1.0 { (radius, 1.0) } else { ((1.0 - (radius - 1.0) / COLLAR).max(0.0), -1.0) };
    let [right, up] = if radius > 0.0 { [x * sine / radius, y * sine / radius] } else { [0.0; 2] };
    let towards = side * (1.0 - sine * sine).max(0.0).sqrt();
    (frame.right * right + frame.up * up + frame.towards * towards).normalize()
}

/// Azimuth and elevation of a direction, degrees; at the zenith and the nadir the azimuth is `otherwise`.
#[must_use]
pub(super) fn bearing_of(direction: DVec3, otherwise: f64) -> [f64; 2] {
    let elevation = direction.z.clamp(-1.0, 1.0).asin().to_degrees();
    let azimuth = if direction.x.hypot(direction.y) < AT_ZENITH {
        otherwise
    } else {
        direction.x.atan2(direction.y).to_degrees().rem_euclid(360.0)
    };
    [azimuth, elevation]
}

/// The longest of 1, 2 or 5 times a power of ten that is no longer, mm.
#[must_use]
pub(super) fn round_length(most_mm: f64) -> f64 {
    let power = 10.0_f64.powf(most_mm.log10().floor());
    let times = [5.0, 2.0, 1.0].into_iter().find(|times| times * power <= most_mm * (1.0 + 1e-9));
    times.unwrap_or(1.0) * power
}

/// A length in the unit that has no zeros in front.
#[must_use]
pub(super) fn length_words(mm: f64) -> String {
    let shown = |value: f64| {
        let text = format!("{value:.3}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    };
    if mm < 0.9995 { format!("{} µm", shown(mm * 1e3)) } else { format!("{} mm", shown(mm)) }
}

/// The axes of the picture, and its width at the target, mm: in scenes those of the renderer's camera, which may have its own upward direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Seen {
    /// Its axes.
    pub frame: Frame,
    /// Its width, mm.
    pub width_mm: f64,
}

/// What was found out for a camera, so that scenes are not read anew for each picture of the window.
#[derive(Clone)]
struct Known {
    of: (String, Option<String>, Camera),
    seen: Seen,
}

/// From where the picture is seen.
#[must_use]
pub(super) fn seen(ui: &Ui, state: &State) -> Seen {
    let view = state.view();
    let own = Seen { frame: view.camera.frame(), width_mm: view.camera.width_mm };
    if view.mode != Mode::Scene {
        return own;
    }
    let (id, of) = (
        Id::unique("the scene's camera"),
        (state.subject().text().to_owned(), view.preset.clone(), view.camera),
    );
    if let Some(known) = ui.data(|data| data.get_temp::<Known>(id)).filter(|known| known.of == of) {
        return known.seen;
    }
    let seen = state.scene(&Unobserved).map_or(own, |(scene, _)| {
        let camera = scene.camera();
        let towards = (camera.eye - camera.target).normalize_or(own.frame.towards);
        let right = camera.up.cross(towards).normalize_or(own.frame.right);
        let frame = Frame { target_mm: camera.target, right, up: towards.cross(right), towards };
        Seen { frame, width_mm: camera.width_mm }
    });
    ui.data_mut(|data| data.insert_temp(id, Known { of, seen }));
    seen
}

/// Draws lamp, axes and scale bar over the picture in `rect`, whose whole width is that of the camera's picture, and takes what is done to them.
/// Called after the picture's own interaction, so that these lie over it. Whether they have the pointer.
pub(super) fn gizmos(ui: &Ui, rect: Rect, state: &State, actions: &mut Vec<Action>) -> bool {
    let seen = seen(ui, state);
    scale_bar(ui, rect, seen.width_mm);
    if rect.width() < LEAST.x || rect.height() < LEAST.y {
        return false;
    }
    let lamp = lamp(ui, rect, &seen.frame, state.view().light, actions);
    let axes = axes(ui, rect, &seen.frame, state.view().camera, actions);
    [lamp, axes].iter().any(|response| response.contains_pointer() || response.dragged())
}

/// The lamp on its ball, at the picture's lower left.
fn lamp(ui: &Ui, rect: Rect, frame: &Frame, light: Light, actions: &mut Vec<Action>) -> Response {
    let reach = BALL * (1.0 + COLLAR as f32) + 6.0;
    let middle = rect.left_bottom() + vec2(MARGIN + reach, -MARGIN - reach);
    let area = Rect::from_center_size(middle, Vec2::splat(2.0 * reach));
    let response = ui.interact(area, ui.scope_id().with("lamp"), Sense::drag());
    let words = format!(
        "lamp: azimuth {:.0}°, elevation {:.0}°, radius {:.1}°",
        light.azimuth_deg, light.elevation_deg, light.radius_deg
    );
    response.widget_info(|| WidgetInfo::labeled(Role::Slider, true, "lamp"));
    if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) {
        let place = (pointer - middle) / BALL;
        let direction = dome_direction([f64::from(place.x), -f64::from(place.y)], frame);
        let [azimuth_deg, elevation_deg] = bearing_of(direction, light.azimuth_deg);
        actions.push(Action::look("light", move |view| {
            (view.light.azimuth_deg, view.light.elevation_deg) = (azimuth_deg, elevation_deg);
        }));
    }
    if response.drag_stopped() {
        actions.push(Action::Settle);
    }
    if response.hovered() {
        let scrolled = ui.input_mut(|input| std::mem::take(&mut input.smooth_scroll_delta)).y;
        if scrolled != 0.0 {
            let [least, most] = RADIUS_DEG;
            let radius = light.radius_deg * (RADIUS_PER_POINT * f64::from(scrolled)).exp();
            let radius_deg = radius.clamp(least, most);
            actions.push(Action::look("light radius", move |view| view.light.radius_deg = radius_deg));
        }
    }
    draw_lamp(ui, middle, frame, &light, response.hovered() || response.dragged());
    response.on_hover_cursor(CursorIcon::Grab).on_hover_text(format!(
        "{words}\ndrag the sun; the wheel changes its radius; in the collar it stands behind"
    ))
}

fn draw_lamp(ui: &Ui, middle: Pos2, frame: &Frame, light: &Light, is_active: bool) {
    let painter = ui.painter();
    let collar = BALL * (1.0 + COLLAR as f32);
    painter.circle_filled(middle, collar + 4.0, BEHIND);
    painter.circle_stroke(middle, BALL, Stroke::new(if is_active { 1.5 } else { 1.0 }, LINE));
    painter.circle_stroke(middle, collar, Stroke::new(0.5, DIM));
    let at = |[x, y]: [f64; 2]| middle + vec2(x as f32, -y as f32) * BALL;
    // The vane's plane, z = 0, as a circle about the ball: dotted where it is behind.
    let plane: Vec<DVec3> = (0..=72)
        .map(|k| f64::from(k) / 72.0 * std::f64::consts::TAU)
        .map(|a| DVec3::new(a.sin(), a.cos(), 0.0))
        .collect();
    for pair in plane.windows(2) {
        let is_front = pair[0].dot(frame.towards) >= 0.0 && pair[1].dot(frame.towards) >= 0.0;
        let flat = |d: DVec3| at([d.dot(frame.right), d.dot(frame.up)]);
        let (from, to) = (flat(pair[0]), flat(pair[1]));
        if is_front {
            painter.line_segment([from, to], Stroke::new(1.0, DIM));
        } else {
            painter.circle_filled(from, 0.6, DIM);
        }
    }
    let direction = light.direction();
    let (sun, is_behind) = (at(dome_place(direction, frame)), direction.dot(frame.towards) < 0.0);
    let ring = (BALL * light.radius_deg.to_radians().sin() as f32).max(5.0);
    painter.line_segment([middle, sun], Stroke::new(0.5, DIM));
    painter.circle_stroke(sun, ring, Stroke::new(1.5, SUN));
    if !is_behind {
        painter.circle_filled(sun, 3.0, SUN);
    }
    for k in 0..8 {
        let ray = Vec2::angled(TAU * k as f32 / 8.0);
        painter.line_segment([sun + ray * (ring + 2.0), sun + ray * (ring + 5.0)], Stroke::new(1.0, SUN));
    }
}

/// An end of an axis as it is drawn.
struct End {
    axis: usize,
    is_named: bool,
    direction: DVec3,
    at: Pos2,
    /// Towards the camera, −1 … 1.
    near: f64,
}

/// The ends of the axes, the nearest last.
fn ends(middle: Pos2, frame: &Frame) -> Vec<End> {
    let one = |axis: usize, sign: f64| {
        let direction = AXIS[axis].1 * sign;
        let [x, y] = [frame.right, frame.up].map(|own| direction.dot(own) as f32);
        let at = middle + vec2(x, -y) * (AXES - END + 2.0);
        End { axis, is_named: sign > 0.0, direction, at, near: direction.dot(frame.towards) }
    };
    let mut ends: Vec<End> = (0..3).flat_map(|axis| [one(axis, 1.0), one(axis, -1.0)]).collect();
    ends.sort_by(|a, b| a.near.total_cmp(&b.near));
    ends
}

/// The camera that looks along an axis from its end.
fn along(camera: Camera, direction: DVec3) -> Camera {
    let [azimuth_deg, elevation_deg] = bearing_of(direction, camera.azimuth_deg);
    Camera { azimuth_deg, elevation_deg, ..camera }
}

/// The scene's axes as the camera sees them, at the picture's lower right.
fn axes(ui: &Ui, rect: Rect, frame: &Frame, camera: Camera, actions: &mut Vec<Action>) -> Response {
    let reach = AXES + END;
    let middle = rect.right_bottom() - Vec2::splat(MARGIN + reach);
    let area = Rect::from_center_size(middle, Vec2::splat(2.0 * reach));
    let response = ui.interact(area, ui.scope_id().with("axes"), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, "axes"));
    let ends = ends(middle, frame);
    let touched = response.hover_pos().or(response.interact_pointer_pos()).and_then(|pointer| {
        let within = |end: &&End| end.at.distance(pointer) <= END;
        ends.iter().rev().find(within)
    });
    if response.dragged() {
        let by = response.drag_delta();
        let turn = [f64::from(by.x) * DEG_PER_POINT, f64::from(by.y) * DEG_PER_POINT];
        if by != Vec2::ZERO {
            actions.push(Action::look("camera", move |view| view.camera = view.camera.orbited(turn)));
        }
    }
    if response.drag_stopped() {
        actions.push(Action::Settle);
    }
    if let Some(end) = touched.filter(|_| response.clicked()) {
        let looks = along(camera, end.direction);
        actions.push(Action::look("camera", move |view| view.camera = looks));
        actions.push(Action::Settle);
    }
    ui.painter().circle_filled(middle, reach, BEHIND);
    for (index, end) in ends.iter().enumerate() {
        let is_touched = touched.is_some_and(|touched| std::ptr::eq(touched, end));
        let is_crowded = ends[index + 1..].iter().any(|near| near.is_named && near.at.distance(end.at) < END);
        draw_end(ui, middle, end, is_touched, is_crowded);
    }
    let words = format!(
        "camera: azimuth {:.0}°, elevation {:.0}°\ndrag turns it; a click on an end looks from there",
        camera.azimuth_deg, camera.elevation_deg
    );
    response.on_hover_cursor(CursorIcon::Grab).on_hover_text(words)
}

/// Draws an end of an axis; its name goes below where a nearer one has its own above.
fn draw_end(ui: &Ui, middle: Pos2, end: &End, is_touched: bool, is_crowded: bool) {
    let (name, _, colour) = AXIS[end.axis];
    let painter = ui.painter();
    let colour = if end.near < -0.05 { colour.gamma_multiply(0.55) } else { colour };
    let line = Stroke::new(if is_touched { 2.5 } else { 1.5 }, colour);
    if end.is_named {
        painter.line_segment([middle, end.at], line);
        painter.circle_filled(end.at, 4.0, colour);
        let (away, side) = if is_crowded { (6.0, Align2::CENTER_TOP) } else { (-6.0, Align2::CENTER_BOTTOM) };
        let colour = if is_touched { Color32::WHITE } else { colour };
        painter.text(end.at + vec2(0.0, away), side, name, FontId::proportional(12.0), colour);
    } else {
        painter.extend(Shape::dashed_line(&[middle, end.at], Stroke::new(1.0, colour), 3.0, 3.0));
        painter.circle_stroke(end.at, 4.0, line);
    }
}

/// The scale bar, at the picture's lower edge.
fn scale_bar(ui: &Ui, rect: Rect, width_mm: f64) {
    let per_mm = f64::from(rect.width()) / width_mm;
    if !(per_mm.is_finite() && per_mm > 0.0) {
        return;
    }
    let length_mm = round_length(0.2 * width_mm);
    let half = (0.5 * length_mm * per_mm) as f32;
    let middle = rect.center_bottom() - vec2(0.0, MARGIN + 4.0);
    let painter = ui.painter();
    let text = painter.layout_no_wrap(length_words(length_mm), FontId::proportional(13.0), LINE);
    let wide = (2.0 * half).max(text.size().x) + 16.0;
    let plate = Rect::from_min_max(
        pos2(middle.x - 0.5 * wide, middle.y - text.size().y - 6.0),
        pos2(middle.x + 0.5 * wide, middle.y + 6.0),
    );
    painter.rect_filled(plate, 3.0, BEHIND);
    let stroke = Stroke::new(2.0, LINE);
    let (left, right) = (middle - vec2(half, 0.0), middle + vec2(half, 0.0));
    painter.line_segment([left, right], stroke);
    for end in [left, right] {
        painter.line_segment([end - vec2(0.0, 4.0), end + vec2(0.0, 4.0)], stroke);
    }
    painter.galley(pos2(middle.x - 0.5 * text.size().x, plate.top() + 1.0), text, LINE);
}

#[cfg(test)]
mod tests;
