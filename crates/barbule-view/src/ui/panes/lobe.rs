//! The lobe: a material's colours over the hemisphere, and the spectrum where it is touched; of what has no material, what one
//! individual scatters over the azimuths.

use std::sync::Arc;

use barbule::brdf::FeatherBrdf;
use barbule::spectrum::colour::{display, into_gamut};
use barbule::spectrum::{Spectrum, Wavelengths};
use barbule::{DVec3, Error, Result};
use eframe::egui::{
    Align2, Color32, ColorImage, FontId, Painter, Pos2, Rect, Role, Sense, Slider, Stroke, TextStyle,
    TextureHandle, TextureId, TextureOptions, Ui, WidgetInfo, pos2, vec2,
};
use egui_plot::{Line, uniform_grid_spacer};

use super::style::Pen;
use super::words::digits;
use super::{Memory, seen, style};
use crate::live::{
    Hemisphere, Known, Lobe, Results, Sight, Viewer, direction_at, lit_across, lobe_spectrum, place_of,
    radius_of,
};
use crate::state::{Shown, State};
use crate::ui::Action;

/// The disc is no larger than this, points.
const LARGEST: f32 = 340.0;
/// Room about the disc for the names of its axes, points.
const MARGIN: f32 = 18.0;
/// Circles of equal angles from the normal, deg.
const CIRCLES_DEG: [f64; 2] = [30.0, 60.0];
/// What white on the screen may stand for, where a white diffuser is 1.
const WHITES: [f64; 2] = [0.01, 1000.0];
/// The width of the scale of brightness, points.
const SCALE_WIDE: f32 = 120.0;

/// What the lobe's view remembers.
#[derive(Default)]
pub(super) struct Kept {
    /// The place of the disc that people keep looking at; the mirror's direction without one.
    pub(super) place: Option<[f64; 2]>,
    /// What white on the screen stands for, where somebody chose it.
    white: Option<f64>,
    /// The disc that was drawn last: of what, with which white.
    disc: Option<(Hemisphere, f64, TextureHandle)>,
}

/// What is asked of the material in a direction.
struct Touch<'a> {
    brdf: &'a Arc<FeatherBrdf>,
    incident: DVec3,
    individual: Option<u64>,
}

/// Draws the lobe of what is open.
pub fn lobe(ui: &mut Ui, state: &State, results: &Results, memory: &mut Memory, actions: &mut Vec<Action>) {
    let Some(hemisphere) = &results.own.hemisphere else { return far_field(ui, state, results) };
    let incident = lit_across(state.view().angle_deg.to_radians());
    let Memory { viewer, lobe: kept, .. } = memory;
    let touched = disc(ui, hemisphere, incident, kept);
    let white = kept.white.unwrap_or_else(|| hemisphere.white());
    scale(ui, hemisphere, white, kept);
    shown(ui, state, actions);
    let Some(brdf) = &results.own.brdf else { return };
    let individual = match state.view().shown {
        Shown::Mean => None,
        Shown::Individuals => Some(state.view().individual as u64),
    };
    let place = touched.or(kept.place).unwrap_or_else(|| mirror(incident));
    let range = results.own.material.as_ref().map(|made| {
        let nm = made.found.material.axes.wavelengths_nm();
        [nm[0], nm[nm.len() - 1]]
    });
    match seen::viewer(viewer, state) {
        Ok(viewer) => {
            let touch = Touch { brdf, incident, individual };
            there(ui, &touch, place, (viewer, range, state));
        }
        Err(why) => style::not_there(ui, &why),
    }
}

/// The place of the direction into which a flat mirror sends the light.
fn mirror(incident: DVec3) -> [f64; 2] {
    place_of(DVec3::new(-incident.x, -incident.y, incident.z))
}

/// Draws the disc; the place that the pointer touches, if it does. A click keeps a place, a double click lets it go.
fn disc(ui: &mut Ui, hemisphere: &Hemisphere, incident: DVec3, kept: &mut Kept) -> Option<[f64; 2]> {
    let side = ui.available_width().clamp(4.0 * MARGIN, LARGEST);
    let (rect, response) = ui.allocate_exact_size(vec2(side, side), Sense::click());
    let disc = rect.shrink(MARGIN);
    let white = kept.white.unwrap_or_else(|| hemisphere.white());
    let texture = texture(ui, hemisphere, white, kept);
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    let painter = ui.painter();
    painter.circle_filled(disc.center(), 0.5 * disc.width(), Color32::BLACK);
    painter.image(texture, disc, whole, Color32::WHITE);
    let touched = response.hover_pos().and_then(|at| place_at(disc, at));
    if response.double_clicked() {
        kept.place = None;
    } else if response.clicked() {
        kept.place = touched;
    }
    marks(ui, painter, disc, [place_of(incident), mirror(incident)]);
    if let Some(place) = kept.place {
        let at = screen(disc, place);
        for (wide, ink) in [(3.0, Color32::BLACK), (1.5, Color32::WHITE)] {
            painter.circle_stroke(at, 5.0, Stroke::new(wide, ink));
        }
    }
    let words = "lobe over the hemisphere; point at a direction to see its spectrum, click to keep it";
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, words));
    touched
}

/// The place of the disc under a point of the screen; none outside of it.
fn place_at(disc: Rect, at: Pos2) -> Option<[f64; 2]> {
    let from_middle = (at - disc.center()) / (0.5 * disc.width());
    let place = [f64::from(from_middle.x), -f64::from(from_middle.y)];
    direction_at(place).map(|_| place)
}

fn screen(disc: Rect, [x, y]: [f64; 2]) -> Pos2 {
    disc.center() + 0.5 * disc.width() * vec2(x as f32, -y as f32)
}

/// The disc's pixels on the graphics card, made anew where they have changed.
fn texture(ui: &Ui, hemisphere: &Hemisphere, white: f64, kept: &mut Kept) -> TextureId {
    let is_known =
        |(known, with, _): &(Hemisphere, f64, TextureHandle)| known == hemisphere && *with == white;
    if let Some((_, _, texture)) = kept.disc.as_ref().filter(|disc| is_known(disc)) {
        return texture.id();
    }
    let image = ColorImage::new([hemisphere.side; 2], pixels(hemisphere, white));
    let texture = ui.ctx().load_texture("lobe", image, TextureOptions::LINEAR);
    let id = texture.id();
    kept.disc = Some((hemisphere.clone(), white, texture));
    id
}

/// The disc's colours with this brightness as white; nothing outside of it.
fn pixels(hemisphere: &Hemisphere, white: f64) -> Vec<Color32> {
    let side = hemisphere.side;
    let centre = |k: usize| 2.0 * (k as f64 + 0.5) / side as f64 - 1.0;
    let of = |(index, rgb): (usize, &[f32])| {
        if direction_at([centre(index % side), -centre(index / side)]).is_none() {
            return Color32::TRANSPARENT;
        }
        let linear = [rgb[0], rgb[1], rgb[2]].map(|channel| f64::from(channel) / white);
        style::rgb(display(into_gamut(linear)))
    };
    hemisphere.rgb.chunks_exact(3).enumerate().map(of).collect()
}

/// Circles of equal angles, axes, and where the light and its mirror are.
fn marks(ui: &Ui, painter: &Painter, disc: Rect, [light, mirror]: [[f64; 2]; 2]) {
    let text = ui.visuals().text_color();
    let font = TextStyle::Small.resolve(ui.style());
    let faint = Color32::from_white_alpha(110);
    let radius = 0.5 * disc.width();
    for degrees in CIRCLES_DEG {
        let r = radius * radius_of(degrees.to_radians()) as f32;
        painter.circle_stroke(disc.center(), r, Stroke::new(1.0, faint));
        let at = disc.center() + vec2(0.0, -r);
        painter.text(at, Align2::CENTER_BOTTOM, format!("{degrees}°"), font.clone(), Color32::from_gray(200));
    }
    painter.circle_stroke(disc.center(), radius, Stroke::new(1.0, text));
    axes(painter, disc, &font, text);
    let sun = screen(disc, light);
    painter.circle(sun, 4.5, Color32::from_rgb(240, 228, 66), Stroke::new(1.5, Color32::BLACK));
    name(painter, sun, "light", &font);
    let at = screen(disc, mirror);
    let corner = |x: f32, y: f32| at + 5.5 * vec2(x, y);
    let diamond =
        vec![corner(0.0, -1.0), corner(1.0, 0.0), corner(0.0, 1.0), corner(-1.0, 0.0), corner(0.0, -1.0)];
    painter.line(diamond.clone(), Stroke::new(3.0, Color32::BLACK));
    painter.line(diamond, Stroke::new(1.5, Color32::WHITE));
    if at.distance(sun) > 12.0 {
        name(painter, at, "mirror", &font);
    }
}

/// The axes beside the disc: across the barbule to the right, along it upwards.
fn axes(painter: &Painter, disc: Rect, font: &FontId, ink: Color32) {
    let stroke = Stroke::new(1.2, ink);
    let corner = disc.left_bottom() + vec2(-0.5 * MARGIN, 0.5 * MARGIN);
    let long = 2.0 * MARGIN;
    painter.arrow(corner, vec2(long, 0.0), stroke);
    painter.arrow(corner, vec2(0.0, -long), stroke);
    let beside = corner + vec2(long + 4.0, 0.0);
    painter.text(beside, Align2::LEFT_CENTER, "across the barbule", font.clone(), ink);
    let above = corner + vec2(-0.4 * MARGIN, -long - 2.0);
    painter.text(above, Align2::LEFT_BOTTOM, "along", font.clone(), ink);
}

/// A name beside a mark, readable on any colour.
fn name(painter: &Painter, at: Pos2, words: &str, font: &FontId) {
    let place = at + vec2(0.0, 8.0);
    let shadow = place + vec2(1.0, 1.0);
    painter.text(shadow, Align2::CENTER_TOP, words, font.clone(), Color32::BLACK);
    painter.text(place, Align2::CENTER_TOP, words, font.clone(), Color32::WHITE);
}

/// The scale of brightness with its numbers, and where white is chosen.
fn scale(ui: &mut Ui, hemisphere: &Hemisphere, white: f64, kept: &mut Kept) {
    ui.horizontal_wrapped(|ui| {
        ui.label("0");
        let (rect, _) = ui.allocate_exact_size(vec2(SCALE_WIDE, style::STRIP), Sense::hover());
        style::strip(ui.painter(), rect, |part| style::rgb(display([f64::from(part); 3])));
        let words = format!(
            "{} × a white diffuser (brightest {})",
            digits(white),
            digits(f64::from(hemisphere.peak))
        );
        ui.label(words);
    });
    ui.horizontal_wrapped(|ui| {
        let mut is_own = kept.white.is_some();
        if ui.checkbox(&mut is_own, "choose what is white").changed() {
            kept.white = is_own.then_some(white.clamp(WHITES[0], WHITES[1]));
        }
        if let Some(white) = &mut kept.white {
            let slider = ui.add(Slider::new(white, WHITES[0]..=WHITES[1]).logarithmic(true).suffix(" ×"));
            slider.accessible_name("what is white");
        }
    });
}

/// The spectrum in the direction that is touched.
fn there(
    ui: &mut Ui,
    touch: &Touch<'_>,
    place: [f64; 2],
    (viewer, range, state): (&Viewer, Option<[f64; 2]>, &State),
) {
    let Some(outgoing) = direction_at(place) else { return };
    let words = direction_words(outgoing);
    match touched(touch, outgoing, viewer, range) {
        Ok((spectrum, sight)) => {
            let words_of_cones = sight.as_ref().ok().and_then(|sight| seen::catches(sight, viewer));
            ui.horizontal_wrapped(|ui| {
                seen::swatches(ui, &sight, state, "there");
                ui.label(words);
            });
            if let Some(cones) = words_of_cones {
                ui.weak(format!("caught over white: {cones}"));
            }
            let nm = spectrum.wavelengths().nm().iter();
            let points: Vec<[f64; 2]> = nm.zip(spectrum.values()).map(|(nm, value)| [*nm, *value]).collect();
            let [pen, _] = Pen::both(ui);
            ui.weak("\u{3c0}f: 1 is a white diffuser");
            style::plot("touched", "wavelength (nm)", "\u{3c0}f")
                .height(0.8 * style::plot_height(ui))
                .include_y(0.0)
                .show(ui, |plot| plot.line(Line::new("there", points).color(pen.ink).width(pen.width)));
        }
        Err(error) => style::not_there(ui, &error.to_string()),
    }
}

/// Where a direction is: its slopes across and along the barbule.
fn direction_words(outgoing: DVec3) -> String {
    // A zero that is added takes the sign of another one away.
    let whole = |radians: f64| radians.to_degrees().round() + 0.0;
    let across = whole(libm::atan2(outgoing.x, outgoing.z));
    let along = whole(libm::asin(outgoing.y.clamp(-1.0, 1.0)));
    format!("towards {across}° across, {along}° along the barbule")
}

/// Spectrum and sight of a direction, at the viewer's wavelengths that the material has.
fn touched(
    touch: &Touch<'_>,
    outgoing: DVec3,
    viewer: &Viewer,
    range: Option<[f64; 2]>,
) -> Result<(Spectrum, std::result::Result<Sight, String>)> {
    let at = within(viewer.wavelengths(), range)?;
    let spectrum = lobe_spectrum(touch.brdf, [touch.incident, outgoing], touch.individual, &at)?;
    let sight = viewer.sees(&spectrum).map_err(|error| error.to_string());
    Ok((spectrum, sight))
}

/// The wavelengths that lie within a range.
fn within(at: &Wavelengths, range: Option<[f64; 2]>) -> Result<Wavelengths> {
    let Some([from, to]) = range else { return Ok(at.clone()) };
    let nm: Vec<f64> = at.iter().copied().filter(|nm| (from..=to).contains(nm)).collect();
    if nm.is_empty() {
        return Err(Error::input(format!(
            "the material is known from {from} to {to} nm, where this eye sees nothing; choose another eye"
        )));
    }
    Wavelengths::new(nm)
}

/// What one individual scatters over the azimuths, where there is no material yet.
fn far_field(ui: &mut Ui, state: &State, results: &Results) {
    let lobe = |of: &Known| of.individual.as_ref().and_then(|one| one.lobe.clone());
    let own = lobe(&results.own);
    let pinned = state.pinned().and_then(|_| lobe(&results.pinned));
    if own.is_none() && pinned.is_none() {
        return style::not_there(
            ui,
            "the lobe appears here once it is computed; make the material to see it in colour",
        );
    }
    let pens = Pen::both(ui).map(Pen::plain);
    let named = [("open", &own), ("pinned", &pinned)];
    for (whose, lobe) in named.into_iter().filter_map(|(whose, lobe)| Some((whose, lobe.as_ref()?))) {
        ui.label(lobe_words(whose, lobe, state.view().individual));
    }
    let curves: Vec<(String, Vec<[f64; 2]>)> = named
        .into_iter()
        .map(|(whose, lobe)| (whose.to_owned(), lobe.as_ref().map(points).unwrap_or_default()))
        .collect();
    let drawn = || curves.iter().zip(pens).filter(|((_, points), _)| !points.is_empty());
    style::keys(ui, drawn().map(|((whose, _), pen)| (whose.as_str(), pen)));
    let lines: Vec<(String, Vec<[f64; 2]>, Pen)> =
        drawn().map(|((whose, points), pen)| (whose.clone(), points.clone(), pen)).collect();
    style::plot("far field", "azimuth (deg)", "intensity (1/rad)")
        .height(style::plot_height(ui))
        .include_y(0.0)
        .include_x(-90.0)
        .include_x(90.0)
        .x_grid_spacer(uniform_grid_spacer(|_| [10.0, 30.0, 90.0]))
        .show(ui, move |plot| {
            for (whose, points, pen) in lines {
                plot.line(Line::new(whose, points).color(pen.ink).width(pen.width).style(pen.dashes));
            }
        });
}

fn points(lobe: &Lobe) -> Vec<[f64; 2]> {
    lobe.azimuth.iter().zip(&lobe.intensity).map(|(azimuth, value)| [azimuth.to_degrees(), *value]).collect()
}

fn lobe_words(whose: &str, lobe: &Lobe, individual: usize) -> String {
    let peak =
        points(lobe).into_iter().max_by(|a, b| a[1].total_cmp(&b[1])).map_or(0.0, |[azimuth, _]| azimuth);
    format!(
        "{whose}, individual {individual} at {:.0} nm: brightest at {peak:.0}°, {} % reflected",
        lobe.wavelength_nm,
        digits(100.0 * lobe.reflected)
    )
}

/// Whether the mean or an individual is drawn.
fn shown(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let mut is_mean = state.view().shown == Shown::Mean;
    if ui.checkbox(&mut is_mean, "mean over individuals").changed() {
        let shown = if is_mean { Shown::Mean } else { Shown::Individuals };
        actions.push(Action::look("shown", move |view| view.shown = shown));
        actions.push(Action::Settle);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_on_the_screen_are_those_of_the_disc() {
        let disc = Rect::from_min_max(pos2(10.0, 20.0), pos2(110.0, 120.0));
        assert_eq!(place_at(disc, pos2(60.0, 70.0)), Some([0.0, 0.0]));
        assert_eq!(place_at(disc, pos2(85.0, 45.0)), Some([0.5, 0.5]));
        assert_eq!(place_at(disc, pos2(12.0, 22.0)), None);
        assert_eq!(screen(disc, [0.5, 0.5]), pos2(85.0, 45.0));
    }

    #[test]
    fn the_mirror_is_opposite_the_light_and_directions_have_words() {
        let incident = lit_across(0.5);
        let [light, mirror] = [place_of(incident), mirror(incident)];
        assert!((light[0] + mirror[0]).abs() < 1e-12 && light[0] > 0.2);
        assert_eq!(direction_words(lit_across(0.5)), "towards 29° across, 0° along the barbule");
        let along = DVec3::new(0.0, libm::sin(0.3), libm::cos(0.3));
        assert_eq!(direction_words(along), "towards 0° across, 17° along the barbule");
    }

    #[test]
    fn the_disc_is_scaled_to_its_white_and_clear_outside() {
        let rgb = [2.0_f32; 3 * 16].to_vec();
        let lobe = Hemisphere { side: 4, rgb, peak: 2.0 };
        let pixels = pixels(&lobe, 2.0);
        assert_eq!((pixels[0], pixels[5]), (Color32::TRANSPARENT, Color32::WHITE));
        assert_eq!(super::pixels(&lobe, 4.0)[5], style::rgb(display([0.5; 3])));
    }

    #[test]
    fn wavelengths_that_a_material_lacks_are_left_out() {
        let at = Wavelengths::new([300.0, 400.0, 500.0]).unwrap();
        assert_eq!(within(&at, Some([350.0, 450.0])).unwrap().nm(), [400.0]);
        assert_eq!(within(&at, None).unwrap(), at);
        assert!(within(&at, Some([800.0, 900.0])).unwrap_err().to_string().contains("sees nothing"));
    }
}
