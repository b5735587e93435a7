//! What the views share in their look: inks that colour-blind readers tell apart, swatches and strips of colour.

use barbule::plot::PALETTE;
use barbule::spectrum::look::hex;
use eframe::egui::{
    Color32, Mesh, Painter, Pos2, Rect, Response, Role, Sense, Shape, Stroke, StrokeKind, Ui, Vec2,
    WidgetInfo, pos2, vec2,
};
use egui_plot::{LineStyle, MarkerShape, Plot};

/// The height of strips of colour, points.
pub(super) const STRIP: f32 = 14.0;
/// Strips change their colour so often.
const STEPS: u16 = 128;
/// Markers of measured curves in their order.
const MARKERS: [MarkerShape; 8] = [
    MarkerShape::Circle,
    MarkerShape::Square,
    MarkerShape::Up,
    MarkerShape::Diamond,
    MarkerShape::Cross,
    MarkerShape::Down,
    MarkerShape::Plus,
    MarkerShape::Asterisk,
];

pub(super) fn rgb([r, g, b]: [u8; 3]) -> Color32 {
    Color32::from_rgb(r, g, b)
}

/// One of the colours of curves, light or dark enough for what is behind it.
fn ink(ui: &Ui, on_light: usize, on_dark: usize) -> Color32 {
    rgb(PALETTE[if ui.visuals().dark_mode { on_dark } else { on_light }])
}

/// The ink of what is open; its curves are solid.
fn own(ui: &Ui) -> Color32 {
    ink(ui, 0, 5)
}

/// The ink of what is pinned; its curves are dashed.
fn pinned(ui: &Ui) -> Color32 {
    ink(ui, 1, 6)
}

/// Dashes of what is pinned, and of marks that are no curves.
pub(super) const DASHED: LineStyle = LineStyle::Dashed { length: 7.0 };
/// Dots of what was measured.
const DOTTED: LineStyle = LineStyle::Dotted { spacing: 4.0 };

/// How a measured curve is drawn, by its place.
pub(super) fn measured(place: usize) -> Pen {
    let inks = [PALETTE[2], PALETTE[3]];
    let marker = Some(MARKERS[place % MARKERS.len()]);
    Pen { ink: rgb(inks[place % inks.len()]), width: 1.2, dashes: DOTTED, marker }
}

/// The height of a plot that is as wide as there is room, points.
pub(super) fn plot_height(ui: &Ui) -> f32 {
    (0.55 * ui.available_width()).clamp(120.0, 240.0)
}

/// A plot that is read and not moved: the wheel scrolls what it stands in, and a drag of the right button looks nearer.
pub(super) fn plot<'a>(name: &str, x: &str, y: &str) -> Plot<'a> {
    Plot::new(name.to_owned())
        .allow_scroll(false)
        .allow_zoom(false)
        .allow_drag(false)
        .label_formatter(|_| None)
        .x_axis_label(x.to_owned())
        .y_axis_label(y.to_owned())
}

/// What tells a curve from others.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pen {
    pub(super) ink: Color32,
    pub(super) width: f32,
    pub(super) dashes: LineStyle,
    pub(super) marker: Option<MarkerShape>,
}

impl Pen {
    /// What is open, and what is pinned.
    pub(super) fn both(ui: &Ui) -> [Self; 2] {
        let pen = |ink, dashes, marker| Self { ink, width: 2.0, dashes, marker: Some(marker) };
        [pen(own(ui), LineStyle::Solid, MarkerShape::Circle), pen(pinned(ui), DASHED, MarkerShape::Square)]
    }

    /// The same without markers.
    pub(super) fn plain(self) -> Self {
        Self { marker: None, ..self }
    }
}

/// Names curves beside a piece of each, above their plot, where they cover nothing.
pub(super) fn keys<'a>(ui: &mut Ui, keys: impl IntoIterator<Item = (&'a str, Pen)>) {
    ui.horizontal_wrapped(|ui| {
        for (name, pen) in keys {
            let (rect, _) = ui.allocate_exact_size(vec2(26.0, STRIP), Sense::hover());
            let [from, to] = [rect.left_center(), rect.right_center()];
            let stroke = Stroke::new(pen.width, pen.ink);
            let piece = match pen.dashes {
                LineStyle::Solid => vec![Shape::line_segment([from, to], stroke)],
                LineStyle::Dashed { length } => Shape::dashed_line(&[from, to], stroke, length, 0.6 * length),
                LineStyle::Dotted { spacing } => Shape::dotted_line(&[from, to], pen.ink, spacing, pen.width),
            };
            ui.painter().extend(piece);
            if let Some(marker) = pen.marker {
                ui.painter().extend(mark(marker, rect.center(), pen.ink));
            }
            ui.small(name);
        }
    });
}

/// A marker as plots draw it.
fn mark(marker: MarkerShape, at: Pos2, ink: Color32) -> Vec<Shape> {
    let stroke = Stroke::new(1.5, ink);
    let polygon = |corners: &[[f32; 2]]| {
        let points = corners.iter().map(|[x, y]| at + 3.5 * vec2(*x, *y)).collect();
        vec![Shape::convex_polygon(points, ink, Stroke::NONE)]
    };
    let lines = |ends: &[[f32; 2]]| -> Vec<Shape> {
        let line = |[x, y]: &[f32; 2]| {
            Shape::line_segment([at - 3.5 * vec2(*x, *y), at + 3.5 * vec2(*x, *y)], stroke)
        };
        ends.iter().map(line).collect()
    };
    let (tall, half) = (0.87, 0.5);
    match marker {
        MarkerShape::Circle => vec![Shape::circle_filled(at, 3.0, ink)],
        MarkerShape::Square => polygon(&[[-0.7, -0.7], [0.7, -0.7], [0.7, 0.7], [-0.7, 0.7]]),
        MarkerShape::Diamond => polygon(&[[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]),
        MarkerShape::Up => polygon(&[[0.0, -1.0], [tall, half], [-tall, half]]),
        MarkerShape::Down => polygon(&[[0.0, 1.0], [-tall, -half], [tall, -half]]),
        MarkerShape::Left => polygon(&[[-1.0, 0.0], [half, -tall], [half, tall]]),
        MarkerShape::Right => polygon(&[[1.0, 0.0], [-half, tall], [-half, -tall]]),
        MarkerShape::Cross => lines(&[[0.7, 0.7], [0.7, -0.7]]),
        MarkerShape::Plus => lines(&[[1.0, 0.0], [0.0, 1.0]]),
        MarkerShape::Asterisk => lines(&[[1.0, 0.0], [half, tall], [half, -tall]]),
    }
}

/// A patch of colour that is called by what it shows.
pub(super) fn swatch(ui: &mut Ui, srgb: [u8; 3], what: &str) -> Response {
    let side = 1.1 * ui.spacing().interact_size.y;
    let (rect, response) = ui.allocate_exact_size(Vec2::new(1.6 * side, side), Sense::hover());
    let edge = Stroke::new(1.0, ui.visuals().weak_text_color());
    ui.painter().rect(rect, 3.0, rgb(srgb), edge, StrokeKind::Inside);
    let words = format!("{what}: {}", hex(srgb));
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &words));
    response.on_hover_text(words)
}

/// A strip whose colour changes along it, by the part of the way from its left end.
pub(super) fn strip(painter: &Painter, rect: Rect, colour: impl Fn(f32) -> Color32) {
    let mut mesh = Mesh::default();
    for step in 0..=STEPS {
        let part = f32::from(step) / f32::from(STEPS);
        let x = rect.left() + part * rect.width();
        let colour = colour(part);
        let first = mesh.vertices.len() as u32;
        mesh.colored_vertex(pos2(x, rect.top()), colour);
        mesh.colored_vertex(pos2(x, rect.bottom()), colour);
        if step > 0 {
            mesh.add_triangle(first - 2, first - 1, first);
            mesh.add_triangle(first - 1, first, first + 1);
        }
    }
    painter.add(mesh);
}

/// Room for a strip under a plot's frame, whose ends are given: the strip, and what is left of it for a name.
pub(super) fn under(ui: &mut Ui, [left, right]: [f32; 2]) -> (Rect, Rect, Response) {
    let wide = ui.available_width();
    let (rect, response) = ui.allocate_exact_size(vec2(wide, STRIP), Sense::click());
    let strip = Rect::from_x_y_ranges(left.max(rect.left())..=right.min(rect.right()), rect.y_range());
    let name = Rect::from_x_y_ranges(rect.left()..=strip.left() - 4.0, rect.y_range());
    (strip, name, response)
}

/// Why something is not there, in a quiet voice.
pub(super) fn not_there(ui: &mut Ui, why: &str) {
    ui.weak(why);
}
