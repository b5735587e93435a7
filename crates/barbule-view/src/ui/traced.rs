//! The picture of a scene, traced by the renderer while one looks.
//!
//! What is to be traced follows from the state alone: whenever that changes the tracer is asked anew, and it decides what it keeps. From a
//! whole bird to its barbules one zooms by the wheel, by a slider, or in a flight. Most scenes are as fine as their pictures' widths ask for,
//! so that feathers are grown anew on the way. A scene of which every barbule stands goes all the way without a break; a check box
//! makes that of any scene with feathers, as `[detail] level = "barbules"` and `[coat] variants = 2` do in its file. The memory that it takes is
//! foretold beside it:
//!
//! | preset | GB |
//! | --- | --- |
//! | `starling-bird`, which a flight knows its way in | 4.2 |
//! | `dove-bird` | 9.2 |
//! | `mallard-head` | 2.7 |
//! | `hummingbird-gorget` | 1.7 |
//! | `magpie-tail` | 0.8 |
//! | `peacock` | 6.2 |
//! | whole feathers, from `starling-feather` to `magpie-feather` | 0.4 to 4.2 |

mod controls;
mod flight;

use std::collections::BTreeMap;
use std::sync::Arc;

use barbule::open;
use barbule::scene::description::{DetailLevel, Exposure, ObjectShape, SceneDescription};
use barbule::spectrum::sensor::Sensor;
use barbule::vision::{FalseColour, false_colour};
use barbule::{DVec3, Result, Unobserved};
use eframe::egui::{
    Color32, ColorImage, Context, CursorIcon, Frame, Margin, PointerButton, Pos2, Rect, Response, Role,
    Sense, TextureHandle, TextureOptions, Ui, Vec2, WidgetInfo, pos2, vec2,
};

use super::Action;
use super::gizmos::{DEG_PER_POINT, Seen, gizmos, seen};
use crate::live::trace::{TraceJob, TraceUpdate, TracedPicture, Tracer};
use crate::state::{Camera, Seer, State, View};

use self::flight::Flight;

/// Most pixels of a picture; larger windows show it enlarged.
const MOST_PIXELS: f64 = 2.5e6;
/// Variants of each kind of feather that a coat of which every barbule stands has: each has some 100,000 barbules.
const VARIANTS: usize = 2;
/// A hand that has not moved for so long, s, has let go of the wheel.
const STILL: f64 = 0.25;
/// By how much the wheel zooms, per point.
const ZOOM_PER_POINT: f64 = 0.0037;

/// What people choose about the picture.
#[derive(Debug, Clone, PartialEq)]
struct Settings {
    samples: u32,
    denoise: bool,
    /// Whether every barbule stands, whatever the scene says.
    barbules: bool,
    /// Whether a material that is not there is made wholly.
    whole: bool,
    /// An exposure that is held, in place of the scene's.
    exposure: Option<f64>,
}

impl Default for Settings {
    fn default() -> Self {
        Self { samples: 64, denoise: false, barbules: false, whole: false, exposure: None }
    }
}

/// What a picture was asked for.
#[derive(Debug, Clone, PartialEq)]
struct Asked {
    what: (String, BTreeMap<String, f64>),
    view: View,
    settings: Settings,
    size: [u32; 2],
    is_moving: bool,
}

/// What the memory that a scene takes depends on: what is open, its preset, and whether every barbule stands.
type OfMemory = (String, Option<String>);

/// What the traced picture remembers between the window's frames.
#[derive(Default)]
pub(super) struct Traced {
    tracer: Option<Tracer>,
    asked: Option<Asked>,
    picture: Option<Arc<TracedPicture>>,
    texture: Option<TextureHandle>,
    settings: Settings,
    /// Memory with every barbule, bytes, foretold; none where the scene has no feathers.
    foretold: Option<(OfMemory, Option<u64>)>,
    flight: Option<Flight>,
    /// Where the last flight began.
    origin: Option<Camera>,
    /// When the camera or the lamp moved last, s.
    moved_at: Option<f64>,
    is_done: bool,
    failed: Option<String>,
    notes: Vec<String>,
}

impl Traced {
    /// The newest picture: its size in pixels, and RGBA with 8 bits each, row by row.
    #[must_use]
    pub(super) fn picture(&self) -> Option<([u32; 2], &[u8])> {
        self.picture.as_ref().map(|picture| (picture.size, &picture.rgba[..]))
    }

    /// Whether samples are on their way.
    #[must_use]
    pub(super) fn is_busy(&self) -> bool {
        self.tracer.as_ref().is_some_and(Tracer::is_busy)
    }

    /// Stops and forgets what is traced, as while another mode is shown; what stands in the scene is kept.
    pub(super) fn stop(&mut self) {
        if self.asked.take().is_some() {
            self.tracer.iter().for_each(Tracer::stop);
        }
        self.flight = None;
    }

    /// Lets the samples rest until somebody goes on.
    pub(super) fn pause(&self) {
        self.tracer.iter().for_each(|tracer| tracer.pause(true));
    }

    /// Fetches what the tracer tells.
    fn listen(&mut self, ctx: &Context) {
        for update in self.tracer.iter().flat_map(Tracer::updates).collect::<Vec<_>>() {
            match update {
                TraceUpdate::Picture(picture) => {
                    let image = ColorImage::from_rgba_unmultiplied(
                        picture.size.map(|side| side as usize),
                        &picture.rgba,
                    );
                    match &mut self.texture {
                        Some(texture) => texture.set(image, TextureOptions::LINEAR),
                        None => {
                            self.texture = Some(ctx.load_texture("traced", image, TextureOptions::LINEAR))
                        }
                    }
                    self.picture = Some(picture);
                }
                TraceUpdate::Note(note) => {
                    if !self.notes.contains(&note) {
                        self.notes.push(note);
                    }
                }
                TraceUpdate::Done => self.is_done = true,
                TraceUpdate::Failed(error) => self.failed = Some(error.to_string()),
            }
        }
    }

    /// Asks for the picture of the state, where it is not what was asked for last.
    fn ask(&mut self, ctx: &Context, state: &State, size: [u32; 2], is_moving: bool) {
        let what = (state.subject().text().to_owned(), state.subject().moved());
        let (view, settings) = (state.view().clone(), self.settings.clone());
        let asked = Asked { what, view, settings, size, is_moving };
        if self.asked.as_ref() == Some(&asked) {
            return;
        }
        if self.asked.as_ref().is_none_or(|before| before.what != asked.what) {
            self.notes.clear();
            self.settings.exposure = None;
        }
        (self.failed, self.is_done) = (None, false);
        let sent = self.tracer(ctx).and_then(|()| job(state, &self.settings, size, is_moving));
        match (sent, &self.tracer) {
            (Ok(job), Some(tracer)) => tracer.ask(job),
            (Ok(_), None) => {}
            (Err(error), _) => self.failed = Some(error.to_string()),
        }
        self.asked = Some(asked);
    }

    fn tracer(&mut self, ctx: &Context) -> Result<()> {
        if self.tracer.is_none() {
            let ctx = ctx.clone();
            self.tracer = Some(Tracer::start(move || ctx.request_repaint())?);
        }
        Ok(())
    }

    /// Memory with every barbule, bytes, where the scene has feathers.
    fn foretold(&mut self, state: &State) -> Option<u64> {
        let of = (state.subject().text().to_owned(), state.view().preset.clone());
        if let Some((known, bytes)) = &self.foretold
            && *known == of
        {
            return *bytes;
        }
        let settings = Settings { barbules: true, ..self.settings.clone() };
        let job = job(state, &settings, [640, 480], false).ok();
        let bytes = job.filter(|job| job.scene.clone().detail_mut().is_some()).map(|job| job.bytes());
        self.foretold = Some((of, bytes));
        bytes
    }

    /// Whether a hand or a flight moves the view; what a wheel did is one change once it rests.
    fn is_moving(&mut self, ui: &Ui, view: &View, actions: &mut Vec<Action>) -> bool {
        let now = ui.input(|input| input.time);
        let before = self.asked.as_ref().map(|asked| (asked.view.camera, asked.view.light));
        if before.is_some_and(|before| before != (view.camera, view.light)) {
            self.moved_at = Some(now);
        }
        let is_held = ui.input(|input| input.pointer.any_down()) && self.moved_at.is_some();
        let is_recent = self.moved_at.is_some_and(|moved| now - moved < STILL);
        if is_recent {
            ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(STILL));
        }
        if !is_held && !is_recent && self.moved_at.take().is_some() {
            actions.push(Action::Settle);
        }
        self.flight.is_some() || is_held || is_recent
    }
}

/// Every barbule of the first feathers of a scene stands, of a coat in few variants. Whether it has feathers.
pub(super) fn every_barbule(scene: &mut SceneDescription) -> bool {
    let Some(detail) = scene.detail_mut() else { return false };
    detail.level = DetailLevel::Barbules;
    let coat = scene.objects.iter_mut().find_map(|object| match &mut object.shape {
        ObjectShape::Coat(of) => Some(of),
        _ => None,
    });
    if let Some(of) = coat {
        of.coat.variants = of.coat.variants.min(VARIANTS);
    }
    true
}

/// What is to be traced of a state.
///
/// # Errors
/// As [`State::scene`], or there is no such eye.
fn job(state: &State, settings: &Settings, size: [u32; 2], is_moving: bool) -> Result<TraceJob> {
    let (mut scene, files) = state.scene(&Unobserved)?;
    if settings.barbules {
        every_barbule(&mut scene);
    }
    if let Some(exposure) = settings.exposure {
        scene.exposure = Exposure::Factor(exposure);
    }
    let sensor = match &state.view().eye {
        Seer::People => Sensor::human(),
        Seer::Bird(name) => {
            let eye = open::eye(name)?;
            false_colour(&eye, &FalseColour::usual(&eye))?
        }
    };
    Ok(TraceJob {
        scene,
        files: files.into_iter().map(|file| (file.name, file.text)).collect(),
        folder: open::folder_of(state.subject().text()),
        denoise: settings.denoise && sensor.is_human(),
        sensor,
        size,
        samples: settings.samples,
        is_moving,
        whole: settings.whole,
        opening: state.opening().clone(),
    })
}

/// Draws the traced picture with what belongs to it, in all the room that there is: a line of controls, what is known of the picture,
/// and the picture itself, under lamp, axes and scale bar. Dragging turns the camera, with the right button or two fingers it shifts; the wheel
/// zooms towards what is under the pointer, and a double click puts that into the middle.
pub(super) fn traced(ui: &mut Ui, state: &State, memory: &mut Traced, actions: &mut Vec<Action>) {
    memory.listen(ui.ctx());
    Frame::new().inner_margin(Margin::symmetric(8, 4)).show(ui, |ui| {
        controls::controls(ui, state, memory, actions);
        controls::told(ui, memory);
    });
    let rect = ui.available_rect_before_wrap();
    if rect.width() < 8.0 || rect.height() < 8.0 {
        return;
    }
    let response = ui.allocate_rect(rect, Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "traced picture"));
    let area = shown(ui, rect, memory);
    let seen = seen(ui, state);
    let takes = gizmos(ui, rect, state, actions);
    moved(ui, &response, (area, rect), (state, &seen), memory, actions);
    if !takes {
        zoomed(ui, &response, area, (state, &seen), memory, actions);
    }
    flight::step(ui, memory, actions);
    let size = pixels(rect.size() * ui.pixels_per_point());
    let is_moving = memory.is_moving(ui, state.view(), actions);
    memory.ask(ui.ctx(), state, size, is_moving);
    response.on_hover_cursor(CursorIcon::Crosshair);
}

/// The picture's size for so many pixels of the screen.
fn pixels(screen: Vec2) -> [u32; 2] {
    let smaller = (MOST_PIXELS / (f64::from(screen.x) * f64::from(screen.y))).sqrt().min(1.0);
    [screen.x, screen.y].map(|side| (f64::from(side) * smaller).round().max(1.0) as u32)
}

/// Draws the newest picture as wide as the room, and says where it lies.
fn shown(ui: &Ui, rect: Rect, memory: &Traced) -> Rect {
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0.0, Color32::from_gray(0x24));
    let Some((texture, picture)) = memory.texture.as_ref().zip(memory.picture.as_ref()) else { return rect };
    let [width, height] = picture.size.map(|side| side as f32);
    let area = Rect::from_center_size(rect.center(), vec2(rect.width(), rect.width() * height / width));
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    painter.image(texture.id(), area, whole, Color32::WHITE);
    area
}

/// The point of the picture under a pointer: 0 … 1 to the right and downwards.
fn point(area: Rect, pointer: Pos2) -> [f64; 2] {
    let at = pointer - area.min;
    [f64::from(at.x / area.width()), f64::from(at.y / area.height())]
}

/// The place of the scene under a pointer, mm: on what the picture shows there, or in the plane through the target.
fn place(area: Rect, pointer: Pos2, seen: &Seen, picture: Option<&TracedPicture>) -> DVec3 {
    let at = point(area, pointer);
    let from_middle = (pointer - area.center()) / area.width();
    let Seen { frame, width_mm } = seen;
    picture.and_then(|picture| picture.place(at)).unwrap_or_else(|| {
        let [right, down] = [from_middle.x, from_middle.y].map(|share| f64::from(share) * width_mm);
        frame.target_mm + frame.right * right - frame.up * down
    })
}

/// The camera nearer by a factor to a place, which stays where it is in the picture.
fn nearer(camera: Camera, place: DVec3, factor: f64) -> Camera {
    let zoomed = camera.zoomed(factor);
    let target = DVec3::from(camera.target_mm);
    let target = place + (target - place) * (zoomed.width_mm / camera.width_mm);
    Camera { target_mm: target.into(), ..zoomed }
}

/// Turns and shifts the camera, and puts what is clicked twice into the middle.
fn moved(
    ui: &Ui,
    response: &Response,
    (area, rect): (Rect, Rect),
    (state, seen): (&State, &Seen),
    memory: &mut Traced,
    actions: &mut Vec<Action>,
) {
    let by = response.drag_delta();
    let touch = ui.input(|input| input.multi_touch());
    let shifts = response.dragged_by(PointerButton::Secondary) || response.dragged_by(PointerButton::Middle);
    let shift = match touch {
        Some(touch) if response.contains_pointer() => touch.translation_delta,
        _ if shifts => by,
        _ => Vec2::ZERO,
    };
    if shift != Vec2::ZERO {
        memory.flight = None;
        let per_point = seen.width_mm / f64::from(rect.width());
        let target = DVec3::from(state.view().camera.target_mm)
            - (seen.frame.right * f64::from(shift.x) - seen.frame.up * f64::from(shift.y)) * per_point;
        actions.push(Action::look("camera", move |view| view.camera.target_mm = target.into()));
    } else if touch.is_none() && response.dragged_by(PointerButton::Primary) && by != Vec2::ZERO {
        memory.flight = None;
        let turn = [f64::from(by.x) * DEG_PER_POINT, f64::from(by.y) * DEG_PER_POINT];
        actions.push(Action::look("camera", move |view| view.camera = view.camera.orbited(turn)));
    }
    if response.drag_stopped() {
        actions.push(Action::Settle);
    }
    if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.double_clicked()) {
        memory.flight = None;
        let target = place(area, pointer, seen, memory.picture.as_deref());
        actions.push(Action::look("camera", move |view| view.camera.target_mm = target.into()));
        actions.push(Action::Settle);
    }
}

/// Zooms by the wheel or two fingers, towards what is under them.
fn zoomed(
    ui: &Ui,
    response: &Response,
    area: Rect,
    (state, seen): (&State, &Seen),
    memory: &mut Traced,
    actions: &mut Vec<Action>,
) {
    let Some(pointer) = response.hover_pos().filter(|_| response.contains_pointer()) else { return };
    let (pinched, scrolled) = ui
        .input_mut(|input| (f64::from(input.zoom_delta()), std::mem::take(&mut input.smooth_scroll_delta).y));
    let factor = (-ZOOM_PER_POINT * f64::from(scrolled)).exp() / pinched.max(1e-3);
    if (factor - 1.0).abs() < 1e-9 {
        return;
    }
    memory.flight = None;
    let place = place(area, pointer, seen, memory.picture.as_deref());
    let camera = nearer(state.view().camera, place, factor);
    actions.push(Action::look("camera", move |view| view.camera = camera));
}

#[cfg(test)]
mod tests;
