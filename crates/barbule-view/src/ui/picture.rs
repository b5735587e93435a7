//! The picture in real time: the stage, drawn before the window and shown within it, and the hands on it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use eframe::egui::{self, Key, PointerButton, Rect, Response, Sense, Ui, Vec2};
use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait, ScreenDescriptor};

use super::action::Action;
use super::look::BEHIND;
use crate::gpu::{Gpu, Target};
use crate::stage::{Look, Show, Stage};
use crate::state::State;
use crate::{Error, Result, show};

/// Degrees that the camera or the light turns for a point of the pointer's way: half a turn over 400 points.
const TURN_DEG: f64 = 0.45;
/// How much nearer a point of the wheel comes: a notch of 50 points is a fifth.
const WHEEL: f64 = 0.0037;
/// After so long without the wheel its turn is a change of its own, s.
const WHEEL_RESTS_S: f64 = 0.4;
/// Most pixels along a side of what is drawn: more than screens show.
const MOST_PIXELS: f32 = 8192.0;
/// Times that a picture is refined before it is written, at most.
const MOST_REFINEMENTS: usize = 256;

/// A stage that the window and the graphics card's thread share.
#[derive(Clone)]
pub(super) struct Shared {
    stage: Arc<Mutex<Stage>>,
    told: Arc<Told>,
    gpu: Gpu,
    format: wgpu::TextureFormat,
}

/// What the drawing tells the window.
#[derive(Default)]
struct Told {
    error: Mutex<Option<Error>>,
    /// Whether something was put onto the stage; before that there is nothing to draw.
    is_set: AtomicBool,
}

/// What is remembered between frames.
#[derive(Debug, Default)]
pub(super) struct Memory {
    /// When the wheel was turned last, s.
    wheeled: Option<f64>,
    /// Where the picture was drawn last.
    pub rect: Option<Rect>,
    /// Its pixels.
    pub size_px: [u32; 2],
}

impl Shared {
    /// A stage on the adapter of a window.
    ///
    /// # Errors
    /// The adapter lacks something: one sentence.
    pub(super) fn new(gpu: Gpu, format: wgpu::TextureFormat) -> Result<Self> {
        let stage = Stage::new(gpu.clone(), format)?;
        Ok(Self { stage: Arc::new(Mutex::new(stage)), told: Arc::default(), gpu, format })
    }

    fn stage(&self) -> MutexGuard<'_, Stage> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts another shape and what it wears onto the stage.
    ///
    /// # Errors
    /// It does not fit onto the adapter.
    pub(super) fn put(&self, show: &Show) -> Result<()> {
        self.stage().put(show)?;
        self.told.is_set.store(true, Ordering::Relaxed);
        Ok(())
    }

    /// Whether there is something to draw.
    pub(super) fn is_set(&self) -> bool {
        self.told.is_set.load(Ordering::Relaxed)
    }

    /// What went wrong in drawing since the last call.
    pub(super) fn error(&self) -> Option<Error> {
        self.told.error.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Memory of tables and meshes on the adapter.
    pub(super) fn bytes(&self) -> u64 {
        self.stage().bytes()
    }

    /// The picture in so many pixels, refined to its end. Shape: `[row, column, 3]`, sRGB.
    ///
    /// # Errors
    /// It is larger than the adapter's textures, or the adapter was lost.
    pub(super) fn pixels(&self, size: [u32; 2], look: &Look) -> Result<Vec<u8>> {
        let mut stage = self.stage();
        for _ in 0..MOST_REFINEMENTS {
            if !stage.draw(size, look)? {
                break;
            }
        }
        let target = Target::new(&self.gpu, size, self.format)?;
        target.draw(&self.gpu, |pass| stage.paint(pass))?;
        rgb_of(&target.read(&self.gpu)?, self.format)
    }
}

/// The bytes of a window's picture as red, green, blue.
fn rgb_of(bytes: &[u8], format: wgpu::TextureFormat) -> Result<Vec<u8>> {
    use wgpu::TextureFormat::{Bgra8Unorm, Bgra8UnormSrgb, Rgba8Unorm, Rgba8UnormSrgb};
    let order = match format {
        Rgba8Unorm | Rgba8UnormSrgb => [0, 1, 2],
        Bgra8Unorm | Bgra8UnormSrgb => [2, 1, 0],
        _ => {
            return Err(Error::machine(format!(
                "the window's pixels are {format:?}, which no picture is written from; write it with --screenshot"
            )));
        }
    };
    Ok(bytes.chunks_exact(4).flat_map(|pixel| order.map(|channel| pixel[channel])).collect())
}

/// One frame of the picture.
struct Drawn {
    shared: Shared,
    size_px: [u32; 2],
    look: Look,
    ctx: egui::Context,
}

impl CallbackTrait for Drawn {
    fn prepare(
        &self,
        _: &wgpu::Device,
        _: &wgpu::Queue,
        _: &ScreenDescriptor,
        _: &mut wgpu::CommandEncoder,
        _: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        match self.shared.stage().draw(self.size_px, &self.look) {
            Ok(true) => self.ctx.request_repaint(),
            Ok(false) => {}
            Err(error) => {
                *self.shared.told.error.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            }
        }
        Vec::new()
    }

    fn paint(&self, _: egui::PaintCallbackInfo, pass: &mut wgpu::RenderPass<'static>, _: &CallbackResources) {
        self.shared.stage().paint(pass);
    }
}

/// Draws the picture over all that is left, and lets hands move its camera and its light.
pub(super) fn picture(
    ui: &mut Ui,
    state: &State,
    shared: &std::result::Result<Shared, String>,
    memory: &mut Memory,
    actions: &mut Vec<Action>,
) {
    let rect = ui.available_rect_before_wrap();
    let response = ui.allocate_rect(rect, Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "picture"));
    memory.rect = Some(rect);
    ui.painter().rect_filled(rect, 0.0, BEHIND);
    let size =
        (rect.size() * ui.ctx().pixels_per_point()).round().clamp(Vec2::ZERO, Vec2::splat(MOST_PIXELS));
    memory.size_px = [size.x as u32, size.y as u32];
    let is_seen = memory.size_px.iter().all(|side| *side > 0);
    match shared {
        Err(why) => say(ui, rect, why),
        Ok(shared) if shared.is_set() && is_seen => {
            let drawn = Drawn {
                shared: shared.clone(),
                size_px: memory.size_px,
                look: show::look(state.view()),
                ctx: ui.ctx().clone(),
            };
            ui.painter().add(Callback::new_paint_callback(rect, drawn));
        }
        Ok(_) => {}
    }
    hands(ui, &response, state, memory, actions);
}

/// A sentence in the middle of the picture.
pub(super) fn say(ui: &Ui, rect: Rect, words: &str) {
    let (font, colour) = (egui::TextStyle::Body.resolve(ui.style()), ui.visuals().text_color());
    let galley = ui.painter().layout(words.to_owned(), font, colour, (rect.width() - 48.0).max(80.0));
    let place = rect.center() - galley.size() / 2.0;
    ui.painter().galley(place, galley, colour);
}

/// What hands do: see [`super::keys::HANDS`].
fn hands(ui: &Ui, response: &Response, state: &State, memory: &mut Memory, actions: &mut Vec<Action>) {
    let touches = ui.input(|input| input.multi_touch()).filter(|_| response.contains_pointer());
    let way = response.drag_delta();
    if let Some(touches) = touches {
        pan(touches.translation_delta, response.rect, actions);
        zoom(f64::from(touches.zoom_delta), actions);
    } else if way != Vec2::ZERO {
        let is_light = ui.input(|input| input.key_down(Key::L));
        if !response.dragged_by(PointerButton::Primary) {
            pan(way, response.rect, actions);
        } else if is_light {
            let [right, down] = turned(way);
            actions.push(move_light([right, -down]));
        } else {
            let turn = turned(way);
            actions.push(Action::look("camera", move |view| view.camera = view.camera.orbited(turn)));
        }
    }
    if response.drag_stopped() {
        actions.push(Action::Settle);
    }
    if response.double_clicked() {
        actions.push(Action::Choose(state.view().mode));
    }
    wheel(ui, response, touches.is_some(), memory, actions);
}

/// What the wheel, and a pinch of a touchpad, asks for.
fn wheel(ui: &Ui, response: &Response, is_touched: bool, memory: &mut Memory, actions: &mut Vec<Action>) {
    let (scroll, pinch, now) =
        ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta(), input.time));
    if response.hovered() && !is_touched && (scroll != 0.0 || pinch != 1.0) {
        zoom(f64::from(pinch) * (WHEEL * f64::from(scroll)).exp(), actions);
        memory.wheeled = Some(now);
    }
    match memory.wheeled {
        Some(last) if now - last > WHEEL_RESTS_S => {
            memory.wheeled = None;
            actions.push(Action::Settle);
        }
        Some(_) => ui.ctx().request_repaint_after_secs(WHEEL_RESTS_S as f32),
        None => {}
    }
}

/// Degrees that something turns where the pointer goes so far: what is held follows the hand.
fn turned(way: Vec2) -> [f64; 2] {
    [TURN_DEG * f64::from(way.x), TURN_DEG * f64::from(way.y)]
}

/// The light moves to the right and upwards in the picture by so many degrees.
pub(super) fn move_light([right_deg, up_deg]: [f64; 2]) -> Action {
    Action::look("light", move |view| {
        let from_camera = (view.light.azimuth_deg - view.camera.azimuth_deg).to_radians();
        // On the camera's side of the dome azimuths run to the left, on the far side to the right.
        let clockwise = if from_camera.cos() >= 0.0 { -right_deg } else { right_deg };
        view.light = view.light.moved([clockwise, up_deg]);
    })
}

fn pan(way: Vec2, rect: Rect, actions: &mut Vec<Action>) {
    let width = f64::from(rect.width().max(1.0));
    let parts = [f64::from(way.x) / width, -f64::from(way.y) / width];
    if way != Vec2::ZERO {
        actions.push(Action::look("pan", move |view| view.camera = view.camera.panned(parts)));
    }
}

/// Comes nearer by a factor.
fn zoom(factor: f64, actions: &mut Vec<Action>) {
    if factor.is_finite() && factor > 0.0 && factor != 1.0 {
        actions.push(Action::look("zoom", move |view| view.camera = view.camera.zoomed(1.0 / factor)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_light_follows_the_hand_on_either_side_of_the_dome() {
        for azimuth_deg in [20.0, 100.0, 180.0, 250.0, 340.0] {
            let mut view = crate::state::View::default();
            view.light.azimuth_deg = azimuth_deg;
            let across = |view: &crate::state::View| view.light.direction().dot(view.camera.frame().right);
            let before = across(&view);
            let Action::Look { what: "light", change } = move_light([5.0, 0.0]) else { panic!() };
            change(&mut view);
            assert!(across(&view) > before, "{azimuth_deg}");
        }
    }

    #[test]
    fn pixels_of_windows_are_red_green_blue_whatever_their_order() {
        let bytes = [1, 2, 3, 4, 5, 6, 7, 8];
        let rgb = |format| rgb_of(&bytes, format).unwrap();
        assert_eq!(rgb(wgpu::TextureFormat::Rgba8Unorm), [1, 2, 3, 5, 6, 7]);
        assert_eq!(rgb(wgpu::TextureFormat::Bgra8Unorm), [3, 2, 1, 7, 6, 5]);
        assert!(rgb_of(&bytes, wgpu::TextureFormat::R8Unorm).is_err());
    }
}
