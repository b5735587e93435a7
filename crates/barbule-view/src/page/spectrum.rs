//! Curves over the wavelength with their axes, and strips of colours: drawn with egui's painter alone.

use std::sync::OnceLock;

use barbule_light::spectrum::colour::{encode, into_gamut, luminance, matching, rgb_from_xyz};
use eframe::egui;
use egui::{Align2, Color32, FontId, Mesh, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2, pos2, vec2};

/// First and last wavelength of the axis, nm.
const AXIS_NM: [f64; 2] = [300.0, 800.0];
/// Labelled every so many nm.
const TICK_NM: f64 = 100.0;
/// Height of a plot and of its strip of colours, points.
const HEIGHT: f32 = 168.0;
const STRIP: f32 = 7.0;
/// Room for labels: left, right, and below.
const LEFT: f32 = 54.0;
const RIGHT: f32 = 14.0;
const BELOW: f32 = 34.0;
/// Where axes of a share may end.
const ENDS: [f64; 10] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0];
/// Steps of the strip.
const STEPS: usize = 100;

/// Values over wavelengths.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curve {
    /// Wavelengths in vacuum, nm, rising.
    pub nm: Vec<f64>,
    /// A value for each.
    pub values: Vec<f64>,
    /// Linear sRGB of a reflectance of these values; of other quantities nothing of meaning.
    pub rgb: [f64; 3],
}

/// What an axis of values says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Axis {
    /// A share of the light, up to a round end over the largest value.
    Reflectance,
    /// Angles in degrees, up to 90.
    Degrees,
}

impl Axis {
    fn title(self) -> &'static str {
        match self {
            Self::Reflectance => "reflectance",
            Self::Degrees => "leaves at (°)",
        }
    }

    /// The largest value and how many parts it is divided into.
    fn end(self, values: &[f64]) -> (f64, u32) {
        match self {
            Self::Degrees => (90.0, 3),
            Self::Reflectance => {
                let most = values.iter().copied().fold(0.0, f64::max);
                let end = ENDS.into_iter().find(|end| *end >= 1.02 * most).unwrap_or(1.0);
                let parts = if [0.3, 0.6].contains(&end) { 3 } else { 4 };
                (end, parts)
            }
        }
    }

    fn label(self, value: f64, end: f64) -> String {
        match self {
            Self::Degrees => format!("{value:.0}"),
            Self::Reflectance if end < 0.04 => format!("{value:.4}"),
            Self::Reflectance if end < 0.3 => format!("{value:.3}"),
            Self::Reflectance => format!("{value:.2}"),
        }
    }
}

/// Draws a curve in the whole width that there is; its values are told where the pointer is.
pub(super) fn curve(ui: &mut Ui, curve: &Curve, axis: Axis) {
    let size = vec2(ui.available_width(), HEIGHT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let inner = Rect::from_min_max(rect.min + vec2(LEFT, 8.0), rect.max - vec2(RIGHT, BELOW + STRIP));
    let (end, parts) = axis.end(&curve.values);
    let place = |nm: f64, value: f64| place_in(inner, nm, value / end);
    let (ink, faint) = (ui.visuals().text_color(), ui.visuals().weak_text_color());
    let font = FontId::proportional(11.0);
    let painter = ui.painter_at(rect);
    let line = Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
    for part in 0..=parts {
        let value = end * f64::from(part) / f64::from(parts);
        let at = place(AXIS_NM[0], value);
        painter.line_segment([at, place(AXIS_NM[1], value)], line);
        let text = axis.label(value, end);
        painter.text(at - vec2(5.0, 0.0), Align2::RIGHT_CENTER, text, font.clone(), faint);
    }
    let strip = Rect::from_min_size(pos2(inner.left(), inner.bottom()), vec2(inner.width(), STRIP));
    painter.add(spectral_strip(strip));
    let count = ((AXIS_NM[1] - AXIS_NM[0]) / TICK_NM).round() as u32;
    for tick in 0..=count {
        let nm = AXIS_NM[0] + TICK_NM * f64::from(tick);
        let at = place(nm, 0.0) + vec2(0.0, STRIP);
        painter.line_segment([at, at + vec2(0.0, 4.0)], Stroke::new(1.0, faint));
        painter.text(at + vec2(0.0, 5.0), Align2::CENTER_TOP, format!("{nm:.0}"), font.clone(), faint);
    }
    let below = pos2(inner.center().x, rect.bottom() - 1.0);
    painter.text(below, Align2::CENTER_BOTTOM, "wavelength (nm)", font.clone(), faint);
    upright(&painter, pos2(rect.left() + 1.0, inner.center().y), axis.title(), font.clone(), faint);
    let points = curve.nm.iter().zip(&curve.values).map(|(nm, value)| place(*nm, *value)).collect();
    painter.add(Shape::line(points, Stroke::new(2.0, ink)));
    if let Some((nm, value)) = response.hover_pos().and_then(|pointer| nearest(curve, inner, pointer)) {
        let at = place(nm, value);
        painter.circle_filled(at, 3.5, ink);
        let side = if at.x > inner.center().x { Align2::RIGHT_BOTTOM } else { Align2::LEFT_BOTTOM };
        let text = format!("{nm:.0} nm: {}", axis.label(value, end.min(0.2)));
        let high = pos2(at.x, (at.y - 7.0).max(inner.top() + 12.0));
        painter.text(high, side, text, FontId::proportional(12.0), ink);
    }
}

fn place_in(inner: Rect, nm: f64, share: f64) -> Pos2 {
    let across = (nm - AXIS_NM[0]) / (AXIS_NM[1] - AXIS_NM[0]);
    pos2(inner.left() + inner.width() * across as f32, inner.bottom() - inner.height() * share as f32)
}

/// The wavelength and value nearest to a place across.
fn nearest(curve: &Curve, inner: Rect, pointer: Pos2) -> Option<(f64, f64)> {
    let away = |nm: f64| (place_in(inner, nm, 0.0).x - pointer.x).abs();
    let at = (0..curve.nm.len()).min_by(|a, b| away(curve.nm[*a]).total_cmp(&away(curve.nm[*b])))?;
    (away(curve.nm[at]) < 20.0).then_some((curve.nm[at], *curve.values.get(at)?))
}

/// A text that runs upwards, its left edge at a place.
fn upright(painter: &egui::Painter, at: Pos2, text: &str, font: FontId, colour: Color32) {
    let galley = painter.layout_no_wrap(text.to_owned(), font, colour);
    let start = at + vec2(0.0, 0.5 * galley.size().x);
    let shape = egui::epaint::TextShape::new(start, galley, colour).with_angle(-std::f32::consts::FRAC_PI_2);
    painter.add(shape);
}

/// The colours of the spectrum as a screen can show them, all as bright as their place in the eye's curve.
fn spectral_strip(rect: Rect) -> Mesh {
    static COLOURS: OnceLock<Vec<Color32>> = OnceLock::new();
    let colours = COLOURS.get_or_init(|| {
        let nm = |k: usize| AXIS_NM[0] + (AXIS_NM[1] - AXIS_NM[0]) * k as f64 / STEPS as f64;
        (0..=STEPS).map(|k| on_screen(rgb_from_xyz(matching(nm(k))))).collect()
    });
    let mut mesh = Mesh::default();
    for (k, colour) in colours.iter().enumerate() {
        let x = rect.left() + rect.width() * k as f32 / STEPS as f32;
        mesh.colored_vertex(pos2(x, rect.top()), *colour);
        mesh.colored_vertex(pos2(x, rect.bottom()), *colour);
        if k > 0 {
            let at = 2 * k as u32;
            mesh.add_triangle(at - 2, at - 1, at);
            mesh.add_triangle(at - 1, at, at + 1);
        }
    }
    mesh
}

/// A colour in linear sRGB as a screen has it, within what it can show.
#[must_use]
pub fn on_screen(linear: [f64; 3]) -> Color32 {
    let shown = into_gamut(linear).map(|v| (255.0 * encode(v.clamp(0.0, 1.0))).round() as u8);
    Color32::from_rgb(shown[0], shown[1], shown[2])
}

/// Colours side by side over their angles, all brighter by the same factor, so that the brightest is as bright as a screen shows
/// without losing its hue.
pub(super) fn strip(ui: &mut Ui, colours: &[[f64; 3]], degrees: &[f64]) {
    let size = vec2(ui.available_width(), 44.0);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    let inner = Rect::from_min_max(rect.min + vec2(LEFT, 2.0), rect.max - vec2(RIGHT, 28.0));
    let painter = ui.painter_at(rect);
    let factor = brightening(colours);
    let width = inner.width() / colours.len().max(1) as f32;
    let font = FontId::proportional(11.0);
    let faint = ui.visuals().weak_text_color();
    for (k, (colour, degrees)) in colours.iter().zip(degrees).enumerate() {
        let left = inner.left() + width * k as f32;
        let cell = Rect::from_min_size(pos2(left, inner.top()), Vec2::new(width + 0.5, inner.height()));
        painter.rect_filled(cell, 0.0, on_screen(colour.map(|v| v * factor)));
        if k % 4 == 0 {
            let at = pos2(left + 0.5 * width, inner.bottom() + 1.0);
            painter.text(at, Align2::CENTER_TOP, format!("{degrees:.0}"), font.clone(), faint);
        }
    }
    let title = "colour by angle of incidence (°)";
    painter.text(pos2(inner.center().x, rect.bottom()), Align2::CENTER_BOTTOM, title, font, faint);
}

/// What makes the brightest channel 1.
fn brightening(colours: &[[f64; 3]]) -> f64 {
    let most = colours.iter().flat_map(|rgb| into_gamut(*rgb)).fold(0.0, f64::max);
    if most > 0.0 { 1.0 / most } else { 1.0 }
}

/// A patch of a colour, made brighter as [`strip`] does, with how bright it is.
pub(super) fn swatch(ui: &mut Ui, linear: [f64; 3]) {
    ui.horizontal(|ui| {
        let (rect, _) = ui.allocate_exact_size(vec2(34.0, 22.0), Sense::hover());
        let factor = brightening(&[linear]);
        ui.painter().rect_filled(rect, 3.0, on_screen(linear.map(|v| v * factor)));
        ui.label(format!("its colour; it reflects {:.1} % of white light", 100.0 * luminance(linear)));
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_end_at_round_numbers_over_the_curve() {
        for (most, end) in [(0.003, 0.01), (0.099, 0.2), (0.25, 0.3), (0.99, 1.0), (1.0, 1.0)] {
            assert_eq!(Axis::Reflectance.end(&[0.0, most]).0, end);
        }
        assert_eq!(Axis::Reflectance.label(0.05, 0.1), "0.050");
        assert_eq!(Axis::Degrees.end(&[3.0]), (90.0, 3));
    }

    #[test]
    fn what_is_under_the_pointer_is_the_nearest_value() {
        let curve = Curve { nm: vec![400.0, 500.0, 600.0], values: vec![0.1, 0.2, 0.3], rgb: [0.2; 3] };
        let inner = Rect::from_min_size(pos2(0.0, 0.0), vec2(500.0, 100.0));
        assert_eq!(nearest(&curve, inner, pos2(195.0, 0.0)), Some((500.0, 0.2)));
        assert_eq!(nearest(&curve, inner, pos2(480.0, 0.0)), None);
    }

    /// Half a grey is as white as white.
    #[test]
    fn colours_are_brightened_to_the_screens_white() {
        assert_eq!(brightening(&[[0.5; 3], [0.1; 3]]), 2.0);
        assert_eq!(on_screen([1.0; 3]), Color32::WHITE);
    }
}
