//! The controls: what is shown, its sizes, its plots, and a line that says what one sees.

use eframe::egui;
use egui::{Color32, RichText, Slider, Ui};

use super::app::Page;
use super::choice::{BIRDS, Choice};
use super::film::{Film, Kind, STRIP_DEG};
use super::grating::Ridges;
use super::spectrum::{Axis, curve, strip, swatch};

/// The largest angle of incidence of the curve, °.
const MOST_DEG: f64 = 85.0;
/// What stands out: a blue that is told from the greys by lightness too.
const ACCENT: Color32 = Color32::from_rgb(96, 165, 250);
/// Behind what is chosen.
const CHOSEN: Color32 = Color32::from_rgb(32, 92, 168);
/// Sides of what fingers touch are at least so long, points.
const TOUCH: f32 = 30.0;

/// The page's greys, which do not tint what is beside them.
pub(super) fn dress(context: &egui::Context) {
    context.set_theme(egui::Theme::Dark);
    context.all_styles_mut(|style| {
        let visuals = &mut style.visuals;
        *visuals = egui::Visuals::dark();
        visuals.panel_fill = Color32::from_gray(30);
        visuals.override_text_color = Some(Color32::from_gray(225));
        visuals.selection.bg_fill = CHOSEN;
        visuals.hyperlink_color = ACCENT;
        visuals.slider_trailing_fill = true;
        style.spacing.item_spacing = egui::vec2(8.0, 8.0);
        style.spacing.button_padding = egui::vec2(10.0, 5.0);
        style.spacing.interact_size.y = TOUCH;
        style.spacing.slider_rail_height = 6.0;
    });
}

impl Page {
    pub(super) fn controls(&mut self, ui: &mut Ui) {
        ui.heading(RichText::new("Structural colour, live").size(21.0));
        ui.horizontal_wrapped(|ui| {
            for choice in Choice::all() {
                if chip(ui, self.asked.choice == choice, choice.label()) {
                    self.choose(choice);
                }
            }
        });
        ui.label(RichText::new(self.about()).color(Color32::from_gray(195)));
        ui.separator();
        self.of_the_shape(ui);
        match self.asked.choice {
            Choice::Bird(_) => self.of_a_bird(ui),
            Choice::Film => self.of_a_film(ui),
            Choice::Ridges => self.of_a_grating(ui),
        }
        ui.separator();
        self.plots(ui);
        ui.separator();
        self.foot(ui);
    }

    /// What one sees.
    fn about(&self) -> &'static str {
        match self.asked.choice {
            Choice::Bird(number) => BIRDS.get(number).map_or("", |bird| bird.about),
            Choice::Film => self.asked.film.kind.about(),
            Choice::Ridges => {
                "Even ridges, as on a CD or a snake's scale: each wavelength leaves in directions of its own. Nothing but the height of the surface makes these colours."
            }
        }
    }

    fn of_the_shape(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            for solid in self.asked.choice.solids() {
                if chip(ui, self.asked.solid == *solid, solid.label()) {
                    self.asked.solid = *solid;
                }
            }
        });
    }

    fn of_a_bird(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            for (individuals, label, hover) in [
                (true, "Individuals", "Each cell of each barbule has an interference pattern of its own."),
                (false, "Mean", "Every cell is the mean over all individuals, as one sees from afar."),
            ] {
                let button = egui::Button::selectable(self.view.individuals == individuals, label);
                if ui.add(button).on_hover_text(hover).clicked() {
                    self.view.individuals = individuals;
                }
            }
        });
    }

    fn of_a_film(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            for kind in Kind::ALL {
                if chip(ui, self.asked.film.kind == kind, kind.label()) && self.asked.film.kind != kind {
                    self.asked.film = Film::of_kind(kind);
                }
            }
        });
        let film = &mut self.asked.film;
        let is_layered = film.kind == Kind::Layers;
        let range = if is_layered { Film::LAYER_RANGE_NM } else { Film::RANGE_NM };
        let label = if is_layered { "thickness of each layer" } else { "thickness" };
        size(ui, &mut film.thickness_nm, range, label, (" nm", 0));
        if is_layered {
            size(ui, &mut film.gap_nm, Film::LAYER_RANGE_NM, "air between them", (" nm", 0));
        }
    }

    fn of_a_grating(&mut self, ui: &mut Ui) {
        let ridges = &mut self.asked.ridges;
        size(ui, &mut ridges.period_um, Ridges::PERIODS_UM, "from ridge to ridge", (" µm", 2));
        size(ui, &mut ridges.height_um, Ridges::HEIGHTS_UM, "height of the ridges", (" µm", 3));
    }

    fn plots(&mut self, ui: &mut Ui) {
        let axis = match self.asked.choice {
            Choice::Ridges => Axis::Degrees,
            _ => Axis::Reflectance,
        };
        if let Some(of) = &self.plots.curve {
            curve(ui, of, axis);
            if axis == Axis::Reflectance {
                swatch(ui, of.rgb);
            }
        }
        if axis == Axis::Degrees {
            ui.label("Where the first order of each wavelength leaves, for light from straight above.");
            return;
        }
        let mut degrees = self.asked.angle.to_degrees();
        let label = "angle of incidence";
        if size(ui, &mut degrees, [0.0, MOST_DEG], label, ("°", 0)) {
            self.asked.angle = degrees.to_radians();
        }
        if !self.plots.strip.is_empty() {
            strip(ui, &self.plots.strip, &STRIP_DEG);
        }
    }

    fn foot(&mut self, ui: &mut Ui) {
        size(ui, &mut self.view.stops, [-3.0, 5.0], "exposure", (" stops", 1));
        let small = |text: String| RichText::new(text).size(12.0).color(Color32::from_gray(150));
        let hint = "Drag to turn it; move the lamp on the dome in the corner, with the right button or with two fingers; wheel or pinch to come nearer; double click for the first view.";
        ui.label(small(hint.to_owned()));
        if self.asked.choice == Choice::Film {
            ui.label(small(format!("In a terminal: barbule film '{}'", self.asked.film.text())));
        }
        ui.horizontal_wrapped(|ui| {
            ui.hyperlink_to("What is this?", &self.help);
            let megabytes = self.picture.bytes() as f64 * 1e-6;
            ui.label(small(format!(
                "{} · {megabytes:.1} MB of tables and meshes · worked out in {:.0} ms",
                self.picture.adapter(),
                self.plots.ms
            )));
        });
    }
}

/// A button of which one of several is chosen.
fn chip(ui: &mut Ui, is_chosen: bool, label: &str) -> bool {
    ui.add(egui::Button::selectable(is_chosen, label)).clicked()
}

/// A slider in the whole width under its name and value; whether it was moved.
fn size(
    ui: &mut Ui,
    value: &mut f64,
    [low, high]: [f64; 2],
    label: &str,
    (unit, digits): (&str, usize),
) -> bool {
    let named = ui.label(format!("{label}: {value:.digits$}{unit}")).id;
    ui.spacing_mut().slider_width = ui.available_width() - 4.0;
    let step = 0.1_f64.powi(digits as i32);
    ui.add(Slider::new(value, low..=high).step_by(step).show_value(false)).labelled_by(named).changed()
}
