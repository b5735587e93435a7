//! The line of controls over a traced picture, and what is known of the picture.

use eframe::egui::{Button, Color32, ComboBox, RichText, Slider, SliderClamping, Ui};

use super::Traced;
use super::flight::{self, Flight};
use crate::live::trace::{TracedPicture, Tracer};
use crate::state::{Camera, Seer, State};
use crate::ui::Action;

/// Numbers of samples that are offered.
const SAMPLES: [u32; 6] = [4, 16, 64, 256, 1024, 4096];
/// The slider's widths of the picture, mm: from a bird to its barbules.
const WIDTHS_MM: [f64; 2] = [1.0, 250.0];
/// Heights of what is touched, points.
const TOUCH: f32 = 28.0;

const ERROR: Color32 = Color32::from_rgb(0xff, 0x9c, 0x6e);

/// Draws the controls.
pub(super) fn controls(ui: &mut Ui, state: &State, memory: &mut Traced, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().interact_size.y = TOUCH;
        pause(ui, memory);
        samples(ui, memory);
        let is_human = state.view().eye == Seer::People;
        let denoise = ui.add_enabled(
            is_human,
            eframe::egui::Checkbox::new(&mut memory.settings.denoise, "denoise"),
        );
        denoise
            .on_hover_text("takes the noise away with Open Image Denoise, where the system has it, at every doubling of the samples")
            .on_disabled_hover_text("only pictures that people see are denoised");
        exposure(ui, memory);
        barbules(ui, state, memory);
        ui.separator();
        zoom(ui, state.view().camera, memory, actions);
        fly(ui, state, memory, actions);
    });
}

fn pause(ui: &mut Ui, memory: &mut Traced) {
    let is_paused = memory.tracer.as_ref().is_some_and(Tracer::is_paused);
    let words = if is_paused { "Go on" } else { "Pause" };
    let is_possible = memory.tracer.is_some() && (is_paused || !memory.is_done);
    if ui.add_enabled(is_possible, Button::new(words)).clicked() {
        memory.tracer.iter().for_each(|tracer| tracer.pause(!is_paused));
    }
}

fn samples(ui: &mut Ui, memory: &mut Traced) {
    let chosen = &mut memory.settings.samples;
    let list =
        ComboBox::from_id_salt("samples").selected_text(format!("{chosen} samples")).show_ui(ui, |ui| {
            for samples in SAMPLES {
                ui.selectable_value(chosen, samples, samples.to_string());
            }
        });
    list.response.on_hover_text("samples per pixel; what is there is kept where more are asked for");
}

fn exposure(ui: &mut Ui, memory: &mut Traced) {
    let Some(now) = memory.picture.as_ref().map(|picture| picture.exposure) else { return };
    let mut is_held = memory.settings.exposure.is_some();
    let hint = "the exposure stays as it is now, wherever the camera goes; else a picture that says nothing else is exposed by what it shows";
    if ui.checkbox(&mut is_held, "hold exposure").on_hover_text(hint).changed() {
        memory.settings.exposure = is_held.then_some(now);
    }
}

fn barbules(ui: &mut Ui, state: &State, memory: &mut Traced) {
    let Some(bytes) = memory.foretold(state) else { return };
    let words = format!("every barbule ({})", memory_words(bytes));
    let hint = "every barbule stands at every distance, so that one zooms from a bird to its barbules without a break: detail.level = \"barbules\", and of coats variants = 2; what that takes in memory is foretold";
    ui.checkbox(&mut memory.settings.barbules, words).on_hover_text(hint);
}

/// Bytes in the unit that people have.
pub(super) fn memory_words(bytes: u64) -> String {
    let mega = bytes as f64 / 1e6;
    if mega >= 1000.0 { format!("{:.1} GB", mega / 1e3) } else { format!("{:.0} MB", mega.max(1.0)) }
}

fn zoom(ui: &mut Ui, camera: Camera, memory: &mut Traced, actions: &mut Vec<Action>) {
    let [least, most] = WIDTHS_MM;
    let mut width_mm = camera.width_mm;
    let slider = Slider::new(&mut width_mm, least.min(camera.width_mm)..=most.max(camera.width_mm))
        .logarithmic(true)
        .clamping(SliderClamping::Never)
        .suffix(" mm")
        .text("wide");
    let response = ui
        .add(slider)
        .on_hover_text("width of the picture at its target: a double click in the picture says at what");
    if response.changed() && width_mm > 0.0 {
        memory.flight = None;
        actions.push(Action::look("camera", move |view| {
            view.camera = view.camera.zoomed(width_mm / view.camera.width_mm);
        }));
    }
    if response.drag_stopped() {
        actions.push(Action::Settle);
    }
}

fn fly(ui: &mut Ui, state: &State, memory: &mut Traced, actions: &mut Vec<Action>) {
    let camera = state.view().camera;
    if memory.flight.is_some() {
        if ui.button("Stop").on_hover_text("the flight ends where it is").clicked() {
            memory.flight = None;
            actions.push(Action::Settle);
        }
        return;
    }
    let middle = memory.picture.as_ref().and_then(|picture| picture.place([0.5; 2]));
    let end = flight::end(state, middle);
    let hint = "flies from here to the barbules, in some seconds";
    if ui
        .add_enabled(camera.width_mm > 1.5 * end.width_mm, Button::new("Fly to barbules"))
        .on_hover_text(hint)
        .clicked()
    {
        (memory.origin, memory.flight) = (Some(camera), Some(Flight::new(camera, end)));
    }
    if let Some(origin) = memory.origin.filter(|origin| *origin != camera)
        && ui.button("Fly back").clicked()
    {
        memory.flight = Some(Flight::new(camera, origin));
    }
}

/// What is known of the picture, what is done, and what went wrong.
pub(super) fn told(ui: &mut Ui, memory: &mut Traced) {
    let progress = memory.tracer.as_ref().and_then(Tracer::progress);
    let mut asks_for_whole = false;
    ui.horizontal_wrapped(|ui| {
        if let Some(failed) = &memory.failed {
            ui.colored_label(ERROR, failed);
            return;
        }
        match &memory.picture {
            Some(picture) => ui.label(picture_words(picture)),
            None => ui.label("no picture yet"),
        };
        // Rendering is told by its samples.
        if let Some(now) = progress.filter(|now| now.stage > 0 && now.label != "rendering") {
            ui.spinner();
            ui.label(format!("{} {:.0} %", now.label, 100.0 * now.fraction()));
        } else if memory.tracer.as_ref().is_some_and(Tracer::is_paused) {
            ui.label(RichText::new("paused").strong());
        }
        if let Some(every) = memory.picture.as_ref().and_then(|picture| picture.thinned) {
            ui.label(format!("· coarse material, every {every}th wavelength and direction"));
            asks_for_whole = !memory.settings.whole
                && ui
                    .button("Make it whole")
                    .on_hover_text("simulates the whole material, which takes minutes")
                    .clicked();
        }
        for note in &memory.notes {
            ui.colored_label(ERROR, note);
        }
    });
    memory.settings.whole |= asks_for_whole;
}

/// `64 samples · noise 3 % · 12 s`, with what is still to come.
pub(super) fn picture_words(picture: &TracedPicture) -> String {
    if picture.is_small {
        return format!("a first look, {} × {} pixels", picture.size[0], picture.size[1]);
    }
    let samples = match picture.samples.round() {
        count if count >= f64::from(picture.of) => format!("{count} samples"),
        count => format!("{count} of {} samples", picture.of),
    };
    let noise = picture.noise.map_or_else(String::new, |noise| match 100.0 * noise {
        percent if percent < 10.0 => format!(" · noise {percent:.1} %"),
        percent => format!(" · noise {percent:.0} %"),
    });
    let seconds = match picture.seconds {
        seconds if seconds < 10.0 => format!(" · {seconds:.1} s"),
        seconds if seconds < 120.0 => format!(" · {seconds:.0} s"),
        seconds => format!(" · {:.0} min", seconds / 60.0),
    };
    let denoised = if picture.denoised_by.is_some() { " · denoised" } else { "" };
    samples + &noise + &seconds + denoised
}
