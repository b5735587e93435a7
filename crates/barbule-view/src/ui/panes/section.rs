//! The section to scale, with its media; what is pinned beside it on the same scale.

use barbule::structure::Section;
use eframe::egui::{
    Align2, Color32, ColorImage, Mesh, Painter, Pos2, Rect, Response, Role, Sense, Stroke, StrokeKind,
    TextStyle, TextureHandle, TextureId, TextureOptions, Ui, WidgetInfo, pos2, vec2,
};

use super::layers::{self, Layer};
use super::words::{length, round_below};
use super::{Memory, style};
use crate::live::{Entry, Legend, Raster, Results, Window, first_window, near_window, raster};
use crate::state::{State, Subject};
use crate::ui::Action;

/// Two sections stand side by side where each has so much room, points; else one under the other.
const SIDE_BY_SIDE: f32 = 260.0;
/// A view's height over its width, and its least and greatest height, points.
const TALL: f32 = 0.6;
const HEIGHTS: [f32; 2] = [120.0, 320.0];
/// Windows are so wide, µm.
const WIDTHS_UM: [f64; 2] = [0.02, 4000.0];
/// No more pixels than this are drawn along either side.
const MOST_PX: f32 = 1400.0;
/// How much nearer a turn of the wheel by one point looks.
const PER_POINT: f64 = 0.003;
/// How much nearer a button looks.
const STEP: f64 = 1.5;

/// What the section's view remembers.
#[derive(Default)]
pub(super) struct Kept {
    /// What is looked at of which subject: its middle and width stay as the view's shape changes.
    window: Option<(String, Window)>,
    /// The media, and of which sections.
    legend: Option<([Option<Section>; 2], Legend)>,
    drawn: [Option<Drawn>; 2],
}

/// A section as it was drawn last.
struct Drawn {
    section: Section,
    legend: Legend,
    window: Window,
    size: [usize; 2],
    texture: TextureHandle,
}

/// One of the two.
struct One<'a> {
    whose: &'static str,
    section: &'a Section,
    layers: Vec<Layer>,
}

/// Draws the section of the individual that is looked at, and that of what is pinned beside it.
pub fn section(
    ui: &mut Ui,
    state: &State,
    results: &Results,
    memory: &mut Memory,
    actions: &mut Vec<Action>,
) {
    let own = results.own.individual.as_ref().map(|one| &one.section);
    let pinned = state.pinned().and(results.pinned.individual.as_ref()).map(|one| &one.section);
    let subjects = [Some(state.subject()), state.pinned()];
    let each = [("open", own), ("pinned", pinned)].into_iter().zip(subjects);
    let shown: Vec<One<'_>> = each
        .filter_map(|((whose, section), subject)| {
            Some(One { whose, section: section?, layers: subject.map(layers_of).unwrap_or_default() })
        })
        .collect();
    let Some(first) = shown.first().map(|one| one.section) else {
        return style::not_there(
            ui,
            "the section appears here once it is made; gratings and scenes have none",
        );
    };
    let kept = &mut memory.section;
    let legend = legend(&mut kept.legend, [own, pinned]);
    let wide = ui.available_width();
    let columns = if wide >= SIDE_BY_SIDE * shown.len() as f32 { shown.len() } else { 1 };
    let gap = ui.spacing().item_spacing.x;
    let each_wide = ((wide - gap * (columns - 1) as f32) / columns as f32).max(40.0);
    let size = [each_wide, (TALL * each_wide).clamp(HEIGHTS[0], HEIGHTS[1])];
    let shape = f64::from(size[0] / size[1]);
    let window = window(&mut kept.window, state.subject().text(), first, shape);
    let mut moved = buttons(ui, window, first, shape);
    let mut views = |ui: &mut Ui| {
        for one in &shown {
            let drawn = &mut kept.drawn[usize::from(one.whose == "pinned")];
            ui.vertical(|ui| {
                moved = view(ui, one, (&legend, window, size), drawn).or(moved);
            });
        }
    };
    if columns > 1 {
        ui.horizontal_top(views);
    } else {
        views(ui);
    }
    if let (Some((_, kept)), Some(moved)) = (&mut kept.window, moved) {
        *kept = limited(moved);
    }
    entries(ui, &legend);
    listed(ui, &shown);
    individual(ui, state, actions);
}

/// The media of both, found anew where a section has changed.
fn legend(kept: &mut Option<([Option<Section>; 2], Legend)>, both: [Option<&Section>; 2]) -> Legend {
    match kept {
        Some((known, legend)) if known.each_ref().map(Option::as_ref) == both => legend.clone(),
        _ => {
            let legend = Legend::of(both.into_iter().flatten());
            *kept = Some((both.map(Option::<&Section>::cloned), legend.clone()));
            legend
        }
    }
}

fn layers_of(subject: &Subject) -> Vec<Layer> {
    subject.stack().map(layers::of).unwrap_or_default()
}

/// What is looked at, in the shape that the view has now.
fn window(kept: &mut Option<(String, Window)>, text: &str, section: &Section, shape: f64) -> Window {
    if kept.as_ref().is_none_or(|(of, _)| of != text) {
        *kept = Some((text.to_owned(), first_window(section, shape)));
    }
    kept.as_ref().map_or_else(|| first_window(section, shape), |(_, window)| window.shaped(shape))
}

/// A window that is neither too near nor too far to show anything.
fn limited(window: Window) -> Window {
    let wide = window.size()[0];
    let wanted = wide.clamp(WIDTHS_UM[0], WIDTHS_UM[1]);
    if wanted == wide { window } else { window.zoomed(wanted / wide, [0.5; 2]) }
}

fn buttons(ui: &mut Ui, window: Window, section: &Section, shape: f64) -> Option<Window> {
    let mut moved = None;
    ui.horizontal_wrapped(|ui| {
        for (words, about, factor) in
            [("+", "look nearer", 1.0 / STEP), ("−", "look from further away", STEP)]
        {
            if ui.button(words).on_hover_text(about).clicked() {
                moved = Some(window.zoomed(factor, [0.5; 2]));
            }
        }
        for (words, window) in [("all of it", first_window as fn(_, _) -> _), ("its top", near_window)] {
            if ui.button(words).clicked() {
                moved = Some(window(section, shape));
            }
        }
        ui.weak("wheel and drag look elsewhere");
    });
    moved
}

/// Draws one section; the window that people moved to.
fn view(
    ui: &mut Ui,
    one: &One<'_>,
    (legend, window, [wide, tall]): (&Legend, Window, [f32; 2]),
    drawn: &mut Option<Drawn>,
) -> Option<Window> {
    ui.label(format!("{}: {}", one.whose, one.section.name));
    let (rect, response) = ui.allocate_exact_size(vec2(wide, tall), Sense::click_and_drag());
    let words = format!("section of what is {}, {} wide", one.whose, length(window.size()[0]));
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &words));
    if ui.is_rect_visible(rect) {
        let texture = texture(ui, one.section, (legend, window), rect, drawn);
        let painter = ui.painter_at(rect);
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        painter.image(texture, rect, whole, Color32::WHITE);
        thicknesses(ui, &painter, (rect, window), &one.layers);
        scale_bar(ui, &painter, rect, window);
        let edge = Stroke::new(1.0, ui.visuals().weak_text_color());
        painter.rect_stroke(rect, 0.0, edge, StrokeKind::Inside);
    }
    moved(ui, &response, rect, window, one.section)
}

/// Where the wheel, fingers, drags and double clicks move a window.
fn moved(ui: &Ui, response: &Response, rect: Rect, window: Window, section: &Section) -> Option<Window> {
    let part = |at: Pos2| {
        let from = at - rect.min;
        [f64::from(from.x / rect.width()), f64::from(from.y / rect.height())]
    };
    if response.double_clicked() {
        return Some(first_window(section, f64::from(rect.width() / rect.height())));
    }
    if response.dragged() {
        let [across, down] = part(rect.min + response.drag_delta());
        return Some(window.moved([-across, -down]));
    }
    let at = response.hover_pos()?;
    // Taken here, so that nothing else scrolls.
    let (wheel, pinch) =
        ui.input_mut(|input| (std::mem::take(&mut input.smooth_scroll_delta).y, input.zoom_delta()));
    let factor = (-PER_POINT * f64::from(wheel)).exp() / f64::from(pinch);
    (factor != 1.0).then(|| window.zoomed(factor, part(at)))
}

/// A section's pixels on the graphics card, made anew where they have changed.
fn texture(
    ui: &Ui,
    section: &Section,
    (legend, window): (&Legend, Window),
    rect: Rect,
    drawn: &mut Option<Drawn>,
) -> TextureId {
    let pixels = |points: f32| (points * ui.ctx().pixels_per_point()).round().clamp(1.0, MOST_PX) as usize;
    let size = [pixels(rect.width()), pixels(rect.height())];
    let is_known = |known: &&mut Drawn| {
        known.size == size && known.window == window && known.section == *section && known.legend == *legend
    };
    if let Some(known) = drawn.as_mut().filter(is_known) {
        return known.texture.id();
    }
    let Raster { size, rgb } = raster(section, legend, &window, size);
    let image = ColorImage::from_rgb(size, &rgb);
    let texture = ui.ctx().load_texture("section", image, TextureOptions::LINEAR);
    let id = texture.id();
    *drawn = Some(Drawn { section: section.clone(), legend: legend.clone(), window, size, texture });
    id
}

/// Words on a patch that makes them readable on any medium.
fn on_patch(ui: &Ui, painter: &Painter, at: Pos2, anchor: Align2, words: String) {
    let font = TextStyle::Small.resolve(ui.style());
    let galley = painter.layout_no_wrap(words, font, Color32::BLACK);
    let place = anchor.anchor_size(at, galley.size());
    painter.rect_filled(place.expand2(vec2(2.0, 0.0)), 2.0, Color32::from_white_alpha(225));
    painter.galley(place.min, galley, Color32::BLACK);
}

/// A bar of a round length in the lower right corner.
fn scale_bar(ui: &Ui, painter: &Painter, rect: Rect, window: Window) {
    let per_um = f64::from(rect.width()) / window.size()[0];
    let um = round_below(0.3 * window.size()[0]);
    let corner = rect.right_bottom() - vec2(8.0, 8.0);
    let left = corner - vec2((um * per_um) as f32, 0.0);
    painter.line_segment([left - vec2(1.5, 0.0), corner + vec2(1.5, 0.0)], Stroke::new(6.0, Color32::WHITE));
    painter.line_segment([left, corner], Stroke::new(3.0, Color32::BLACK));
    on_patch(ui, painter, left.lerp(corner, 0.5) - vec2(0.0, 6.0), Align2::CENTER_BOTTOM, length(um));
}

/// The layers' thicknesses beside them, where they have room.
fn thicknesses(ui: &Ui, painter: &Painter, (rect, window): (Rect, Window), layers: &[Layer]) {
    let per_um = f64::from(rect.height()) / window.size()[1];
    let room = f64::from(ui.text_style_height(&TextStyle::Small));
    for layer in layers {
        let [upper, lower] = [layer.top_um, layer.top_um - 1e-3 * layer.thickness_nm]
            .map(|z| f64::from(rect.top()) + (window.top - z) * per_um);
        let middle = 0.5 * (upper.max(f64::from(rect.top())) + lower.min(f64::from(rect.bottom()))) as f32;
        if lower - upper > room && rect.y_range().contains(middle) {
            on_patch(ui, painter, pos2(rect.left() + 6.0, middle), Align2::LEFT_CENTER, layer.words());
        }
    }
}

/// What the shades and hatches mean.
fn entries(ui: &mut Ui, legend: &Legend) {
    ui.horizontal_wrapped(|ui| {
        for entry in &legend.entries {
            sample(ui, entry);
            ui.label(&entry.label);
        }
    });
}

/// A patch of a medium.
fn sample(ui: &mut Ui, entry: &Entry) {
    let (rect, _) = ui.allocate_exact_size(vec2(28.0, 14.0), Sense::hover());
    let [from, to] = entry.shades.map(style::rgb);
    style::strip(ui.painter(), rect, |part| from.lerp_to_gamma(to, part));
    // Pixels as those of the picture, which soft edges would fade.
    let ink = if entry.dark_lines { Color32::from_black_alpha(90) } else { Color32::from_white_alpha(90) };
    let mut lines = Mesh::default();
    for row in 0..rect.height() as usize {
        for column in (0..rect.width() as usize).filter(|column| entry.hatch.marks(*column, row)) {
            let at = rect.min + vec2(column as f32, row as f32);
            lines.add_colored_rect(Rect::from_min_size(at, vec2(1.0, 1.0)), ink);
        }
    }
    let painter = ui.painter_at(rect);
    painter.add(lines);
    let edge = Stroke::new(1.0, ui.visuals().weak_text_color());
    painter.rect_stroke(rect, 0.0, edge, StrokeKind::Inside);
}

/// The layers of stacks as lists, with what each is.
fn listed(ui: &mut Ui, shown: &[One<'_>]) {
    for one in shown.iter().filter(|one| !one.layers.is_empty()) {
        ui.collapsing(format!("layers of what is {}", one.whose), |ui| {
            for words in layers::lines(&one.layers) {
                ui.label(words);
            }
        });
    }
}

/// Whose section it is; a press makes another.
fn individual(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let index = state.view().individual;
    let is_random = state.subject().stack().is_none_or(|stack| stack.is_random());
    if !is_random {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.label(format!("individual {index}"));
        for (words, next) in
            [("before", index.checked_sub(1)), ("next", Some(index + 1).filter(|i| *i < 10_000))]
        {
            let button = ui.add_enabled(next.is_some(), eframe::egui::Button::new(words).small());
            if let Some(next) = next.filter(|_| button.clicked()) {
                actions.push(Action::look("individual", move |view| view.individual = next));
                actions.push(Action::Settle);
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_stay_where_something_is_seen() {
        let of = |wide: f64| Window { left: 0.0, right: wide, bottom: 0.0, top: 1.0 };
        assert_eq!(limited(of(2.0)), of(2.0));
        assert!((limited(of(1e-6)).size()[0] - WIDTHS_UM[0]).abs() < 1e-12);
        assert!((limited(of(1e9)).size()[0] - WIDTHS_UM[1]).abs() < 1e-6);
    }
}
