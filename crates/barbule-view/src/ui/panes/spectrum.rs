//! Reflectance against wavelength.

use barbule::spectrum::Spectrum;
use barbule::spectrum::comparison::Comparison;
use eframe::egui::{self, Ui};
use egui_plot::{FilledArea, Line, LineStyle, Points, VLine};

use super::seen::{self, Seen};
use super::style::{self, Pen};
use super::words::{digits, percent};
use super::{Memory, Once};
use crate::live::{Results, spectral_srgb};
use crate::state::{Beside, State};
use crate::ui::Action;

/// What was found of measured spectra: with the files, since they are all that tells one from another.
pub(super) type Kept = Once<(Spectrum, Vec<String>), Vec<Result<Comparison, String>>>;

/// A curve of the plot.
struct Curve {
    name: String,
    spectrum: Spectrum,
    deviation: Option<Vec<f64>>,
    pen: Pen,
}

/// Draws reflectance against wavelength: of what is open with its deviation between individuals, of what is pinned, of the individual
/// that is looked at, and what was measured; colours and numbers above, colours of the wavelengths below.
pub fn spectrum(
    ui: &mut Ui,
    state: &State,
    results: &Results,
    memory: &mut Memory,
    actions: &mut Vec<Action>,
) {
    if let Err(why) = seen::viewer(&mut memory.viewer, state) {
        return style::not_there(ui, &why);
    }
    let both = seen::both(memory, state, results);
    for (seen, whose) in both.into_iter().zip(["open", "pinned"]) {
        if let Some(seen) = seen {
            header(ui, seen, state, whose);
        }
    }
    if both[0].is_some() && !results.own.is_whole {
        ui.weak(format!("so far of {}, more to come", individuals(results.own.individuals)));
    }
    let curves = curves(ui, both, state, results);
    let own = both[0].map(|seen| seen.spectrum.clone());
    if curves.is_empty() {
        style::not_there(ui, "no reflectance yet: it is computed, or there is none of what is open");
        return;
    }
    plot(ui, curves, state);
    if let Some(own) = own {
        measured(ui, state, &own, &mut memory.measured, actions);
    }
}

fn individuals(count: usize) -> String {
    if count == 1 { "1 individual".to_owned() } else { format!("{count} individuals") }
}

fn header(ui: &mut Ui, seen: &Seen, state: &State, whose: &str) {
    ui.horizontal_wrapped(|ui| {
        seen::swatches(ui, &seen.sight, state, whose);
        ui.label(format!("{whose}, {}°: {}", digits(seen.angle.to_degrees()), seen.words()));
    });
}

/// Everything that is drawn, what is open first.
fn curves(ui: &Ui, [own, pinned]: [Option<&Seen>; 2], state: &State, results: &Results) -> Vec<Curve> {
    let mut curves = Vec::new();
    let named = [own, pinned].into_iter().zip(["open", "pinned"]).zip(Pen::both(ui));
    for ((seen, name), pen) in named {
        if let Some(Seen { spectrum, deviation, .. }) = seen {
            let (spectrum, deviation) = (spectrum.clone(), deviation.clone());
            curves.push(Curve { name: name.to_owned(), spectrum, deviation, pen: pen.plain() });
        }
    }
    if let Some(one) = &results.own.individual {
        let thin = Pen { ink: ui.visuals().text_color(), width: 0.8, dashes: LineStyle::Solid, marker: None };
        curves.push(Curve {
            name: format!("individual {}, along its normal", state.view().individual),
            spectrum: one.reflected.clone(),
            deviation: None,
            pen: thin,
        });
    }
    for (place, beside) in state.beside().iter().enumerate() {
        curves.push(Curve {
            name: beside.name(),
            spectrum: beside.measured().mean.clone(),
            deviation: beside.measured().std.clone(),
            pen: style::measured(place),
        });
    }
    curves
}

fn plot(ui: &mut Ui, curves: Vec<Curve>, state: &State) {
    let reading: Vec<(String, Spectrum)> =
        curves.iter().map(|curve| (curve.name.clone(), curve.spectrum.clone())).collect();
    style::keys(ui, curves.iter().map(|curve| (curve.name.as_str(), curve.pen)));
    let marked = state.view().wavelength_nm;
    let weak = ui.visuals().weak_text_color();
    let shown = style::plot("spectrum", "wavelength (nm)", "reflectance")
        .height(style::plot_height(ui))
        .include_y(0.0)
        .show(ui, move |plot| {
            plot.vline(VLine::new("lobe's wavelength", marked).color(weak).style(style::DASHED).width(1.0));
            for curve in curves {
                draw(plot, curve);
            }
        });
    let frame = *shown.transform.frame();
    let (strip, _, _) = style::under(ui, [frame.left(), frame.right()]);
    let [from, to] = [frame.left(), frame.right()]
        .map(|x| shown.transform.value_from_position(egui::pos2(x, frame.center().y)).x);
    style::strip(ui.painter(), strip, |part| style::rgb(spectral_srgb(from + f64::from(part) * (to - from))));
    let words = match shown.response.hover_pos() {
        Some(at) => read(&reading, shown.transform.value_from_position(at).x).join(" · "),
        None => "point at the curves to read them".to_owned(),
    };
    ui.weak(words);
}

fn draw(plot: &mut egui_plot::PlotUi<'_>, curve: Curve) {
    let Curve { name, spectrum, deviation, pen } = curve;
    let Pen { ink, width, dashes, marker } = pen;
    let (nm, values) = (spectrum.wavelengths().nm(), spectrum.values());
    if let Some(deviation) = deviation.filter(|deviation| deviation.len() == values.len()) {
        let with = |sign: f64| -> Vec<f64> {
            values.iter().zip(&deviation).map(|(mean, std)| (mean + sign * std).max(0.0)).collect()
        };
        let band = FilledArea::new(name.clone(), nm, &with(-1.0), &with(1.0));
        plot.add(band.fill_color(ink.gamma_multiply(0.18)).allow_hover(false));
    }
    let points: Vec<[f64; 2]> = nm.iter().zip(values).map(|(nm, value)| [*nm, *value]).collect();
    if let Some(marker) = marker {
        // About a dozen markers tell curves apart, and do not cover them.
        let every = (points.len() / 12).max(1);
        let some: Vec<[f64; 2]> = points.iter().copied().step_by(every).collect();
        plot.points(Points::new(name.clone(), some).shape(marker).radius(3.5).color(ink).allow_hover(false));
    }
    plot.line(Line::new(name, points).color(ink).width(width).style(dashes));
}

/// A wavelength, and each curve's value there.
fn read(curves: &[(String, Spectrum)], nm: f64) -> Vec<String> {
    let each =
        curves.iter().filter_map(|(name, spectrum)| Some(format!("{name} {}", percent(spectrum.value(nm)?))));
    std::iter::once(format!("{nm:.0} nm")).chain(each).collect()
}

/// The measured spectra in numbers, each with a button that takes it away.
fn measured(ui: &mut Ui, state: &State, own: &Spectrum, kept: &mut Kept, actions: &mut Vec<Action>) {
    let files: Vec<String> = state.beside().iter().map(|beside| beside.file().to_owned()).collect();
    let compare = |beside: &Beside| beside.compare(own).map_err(|error| error.to_string());
    let found = kept.of(&(own.clone(), files), |_| state.beside().iter().map(compare).collect());
    for (place, (beside, found)) in state.beside().iter().zip(found).enumerate() {
        ui.horizontal_wrapped(|ui| {
            let button = ui.small_button("take away").on_hover_text(beside.file());
            if button.clicked() {
                actions.push(Action::TakeAway(place));
            }
            ui.label(match found {
                Ok(found) => format!("{}: {}", beside.name(), numbers(found)),
                Err(why) => format!("{}: {why}", beside.name()),
            })
            .on_hover_text(&beside.measured().reading);
        });
    }
}

/// What a comparison with a measurement says first.
fn numbers(found: &Comparison) -> String {
    let mut parts = vec![format!("rms difference {}", percent(found.rmse))];
    if let Some(peak) = found.measured.peak {
        parts.push(format!("peak {:.0} nm", peak.nm));
    }
    if let Some(shift) = found.peak_shift_nm() {
        parts.push(format!("open's is {shift:+.0} nm from it"));
    }
    if let Some(delta) = found.delta_e_2000 {
        parts.push(format!("\u{394}E00 {}", digits(delta)));
    }
    parts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::spectrum::Wavelengths;

    fn line(from: f64, to: f64) -> Spectrum {
        Spectrum::new(Wavelengths::new([400.0, 500.0, 600.0]).unwrap(), vec![from, 0.5 * (from + to), to])
            .unwrap()
    }

    #[test]
    fn curves_are_read_where_they_are_known() {
        let curves = [("open".to_owned(), line(0.1, 0.3)), ("pinned".to_owned(), line(0.4, 0.4))];
        assert_eq!(read(&curves, 450.0), ["450 nm", "open 15 %", "pinned 40 %"]);
        assert_eq!(read(&curves, 700.0), ["700 nm"]);
    }

    #[test]
    fn comparisons_say_how_far_apart_curves_are() {
        let found = Comparison::of(&line(0.1, 0.3), &line(0.2, 0.4), None).unwrap();
        assert!(numbers(&found).starts_with("rms difference 10 %"), "{}", numbers(&found));
    }
}
