//! Colour and peak against the angle of incidence.

use barbule::spectrum::look::hex;
use eframe::egui::{Align2, Rect, Response, Role, TextStyle, Ui, WidgetInfo, pos2};
use egui_plot::{Line, PlotTransform, Points, VLine, uniform_grid_spacer};

use super::seen;
use super::style::{self, Pen};
use super::{Memory, Once};
use crate::live::{AngleSeen, Curves, Known, Results, Viewer, along_angles};
use crate::state::{Seer, State};
use crate::ui::Action;

/// What was seen last along the angles of one of the two, or why it was not.
pub(super) type Kept = Once<(Curves, Seer), Result<Vec<AngleSeen>, String>>;

/// Angles of incidence that can be looked at, deg.
const STEEPEST_DEG: f64 = 85.0;

/// Draws the wavelength of the peak against the angle of incidence, and strips of what is seen at each angle; a click looks at an angle.
pub fn angles(ui: &mut Ui, state: &State, results: &Results, memory: &mut Memory, actions: &mut Vec<Action>) {
    let Memory { viewer, along, .. } = memory;
    let viewer = match seen::viewer(viewer, state) {
        Ok(viewer) => viewer,
        Err(why) => return style::not_there(ui, &why),
    };
    let [own, pinned] = along;
    let pinned_of = state.pinned().is_some().then_some(&results.pinned);
    let each = [
        ("open", seen_along(own, state, Some(&results.own), viewer)),
        ("pinned", seen_along(pinned, state, pinned_of, viewer)),
    ];
    let several = |seen: &Option<&Result<Vec<AngleSeen>, String>>| match seen {
        Some(Ok(seen)) => seen.len() > 1,
        Some(Err(_)) => true,
        None => false,
    };
    if !each.iter().any(|(_, seen)| several(seen)) {
        return style::not_there(ui, "colours at several angles come once they are computed");
    }
    let drawn = each.iter().filter_map(|(whose, seen)| Some((*whose, seen.as_ref()?.as_ref().ok()?)));
    let (frame, transform, clicked) = peaks(ui, drawn.collect(), state);
    let mut chosen = clicked;
    for (whose, seen) in &each {
        match seen {
            Some(Ok(seen)) => chosen = strips(ui, seen, state, (whose, frame, &transform)).or(chosen),
            Some(Err(why)) => style::not_there(ui, &format!("{whose}: {why}")),
            None => {}
        }
    }
    if let Some(degrees) = chosen {
        let degrees = degrees.round().clamp(-STEEPEST_DEG, STEEPEST_DEG);
        actions.push(Action::look("angle", move |view| view.angle_deg = degrees));
        actions.push(Action::Settle);
    }
}

fn seen_along<'a>(
    kept: &'a mut Kept,
    state: &State,
    of: Option<&Known>,
    viewer: &Viewer,
) -> Option<&'a Result<Vec<AngleSeen>, String>> {
    let curves = of?.curves.as_ref()?;
    let key = (curves.clone(), state.view().eye.clone());
    Some(kept.of(&key, |(curves, _)| along_angles(curves, viewer).map_err(|error| error.to_string())))
}

/// The peaks' wavelengths as curves: the plot's frame, where values lie in it, and the angle that was clicked, deg.
fn peaks(
    ui: &mut Ui,
    drawn: Vec<(&str, &Vec<AngleSeen>)>,
    state: &State,
) -> (Rect, PlotTransform, Option<f64>) {
    let pens = Pen::both(ui);
    let weak = ui.visuals().weak_text_color();
    let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
    for one in drawn.iter().flat_map(|(_, seen)| *seen) {
        ends = [ends[0].min(one.reach[0].to_degrees()), ends[1].max(one.reach[1].to_degrees())];
    }
    // Where nothing is known yet, the axis has all angles; a plot without ends would have a grid without one.
    if !(ends[0].is_finite() && ends[0] < ends[1]) {
        ends = [0.0, 90.0];
    }
    let curves: Vec<(String, Vec<[f64; 2]>)> = drawn
        .into_iter()
        .map(|(whose, seen)| {
            let points = seen.iter().filter_map(|one| Some([one.angle.to_degrees(), one.peak_nm?]));
            (whose.to_owned(), points.collect())
        })
        .collect();
    let pen_of = |whose: &str| pens[usize::from(whose != "open")];
    style::keys(ui, curves.iter().map(|(whose, _)| (whose.as_str(), pen_of(whose))));
    let now = state.view().angle_deg;
    let shown = style::plot("angles", "angle of incidence (deg)", "peak wavelength (nm)")
        .height(style::plot_height(ui))
        .include_x(ends[0])
        .include_x(ends[1])
        .set_margin_fraction(eframe::egui::vec2(0.0, 0.1))
        .x_grid_spacer(uniform_grid_spacer(|_| [10.0, 30.0, 90.0]))
        .show(ui, move |plot| {
            plot.vline(VLine::new("angle of the spectrum", now).color(weak).style(style::DASHED).width(1.0));
            for (whose, points) in curves {
                let Pen { ink, width, dashes, marker } = pens[usize::from(whose != "open")];
                if let Some(marker) = marker {
                    plot.points(
                        Points::new(whose.clone(), points.clone()).shape(marker).radius(2.5).color(ink),
                    );
                }
                plot.line(Line::new(whose, points).color(ink).width(width).style(dashes));
            }
        });
    let clicked = clicked(&shown.response, &shown.transform);
    (*shown.transform.frame(), shown.transform, clicked)
}

/// The angle at which something was clicked, deg.
fn clicked(response: &Response, transform: &PlotTransform) -> Option<f64> {
    let at = response.clicked().then(|| response.interact_pointer_pos())??;
    Some(transform.value_from_position(at).x)
}

/// A strip as people see it, and one as a bird does; the angle that was clicked on one of them, deg.
fn strips(
    ui: &mut Ui,
    seen: &[AngleSeen],
    state: &State,
    (whose, frame, transform): (&str, Rect, &PlotTransform),
) -> Option<f64> {
    let people = seen.iter().map(|one| Some(one.sight.srgb)).collect::<Option<Vec<_>>>();
    let bird = seen.iter().map(|one| one.sight.bird_srgb).collect::<Option<Vec<_>>>();
    let name = match &state.view().eye {
        Seer::People => String::new(),
        Seer::Bird(bird) => format!("{whose} as the {bird} sees it"),
    };
    let both = [(format!("{whose} as people see it"), whose, people), (name, "bird", bird)];
    let mut chosen = None;
    for (words, short, colours) in both {
        let Some(colours) = colours else { continue };
        let (strip, room, response) = style::under(ui, [frame.left(), frame.right()]);
        for (one, srgb) in seen.iter().zip(&colours) {
            let [left, right] = one.reach.map(|angle| transform.position_from_point_x(angle.to_degrees()));
            let patch =
                Rect::from_x_y_ranges(left.max(strip.left())..=right.min(strip.right()), strip.y_range());
            if patch.is_positive() {
                ui.painter().rect_filled(patch, 0.0, style::rgb(*srgb));
            }
        }
        let font = TextStyle::Small.resolve(ui.style());
        let at = pos2(room.right(), room.center().y);
        ui.painter().with_clip_rect(room).text(
            at,
            Align2::RIGHT_CENTER,
            short,
            font,
            ui.visuals().text_color(),
        );
        let ends =
            [colours.first(), colours.last()].map(|srgb| srgb.map_or(String::new(), |srgb| hex(*srgb)));
        let words = format!("{words}: {} to {}", ends[0], ends[1]);
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &words));
        chosen = clicked(&response, transform).or(chosen);
        response.on_hover_text(words);
    }
    chosen
}
