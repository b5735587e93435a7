//! The picture: the stage behind egui's canvas, and what fingers and mice do to it.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use eframe::egui;
use eframe::egui_wgpu::{self, CallbackResources, CallbackTrait, ScreenDescriptor};
use egui::{Align2, Color32, FontId, PointerButton, Pos2, Rect, Sense, Stroke, Ui, pos2, vec2};
use glam::DVec3;

use super::view::{Extent, View};
use crate::Result;
use crate::gpu::Gpu;
use crate::stage::{Look, Show, Stage};

/// Wavelengths of a frame at most: more come in the next ones, whose mean is shown.
const WAVES: usize = 8;
/// Pixels of the picture for a point of the screen at most: more are drawn too slowly on telephones.
const MOST_SCALE: f32 = 1.5;
/// Radius of the dome on which the lamp is moved, and its distance from the corner, points.
const DOME: f32 = 38.0;
const DOME_MARGIN: f32 = 18.0;
/// Under WebGL one hears of finished frames only when something else is drawn: so soon it is.
const ASK_AGAIN: Duration = Duration::from_millis(50);
/// How much nearer a turn of the wheel by one point brings the shape.
const PER_SCROLL: f64 = 0.003;

/// The stage, shared with what egui calls back.
#[derive(Debug, Clone)]
pub(super) struct Picture {
    shared: Arc<Shared>,
    adapter: String,
    is_on_dome: bool,
}

#[derive(Debug)]
struct Shared {
    stage: Mutex<Stage>,
    fault: Mutex<Option<String>>,
    /// How the stage was looked at last, where nothing makes the picture better.
    rest: Mutex<Option<(Look, [u32; 2])>>,
    /// Whether a frame is being drawn: the next waits for it, or slow adapters would fall ever further behind the hand.
    is_busy: AtomicBool,
    /// Whether the page wants another one when it is done.
    is_awaited: AtomicBool,
    /// Frames that are done.
    frames: AtomicU32,
}

/// A frame to be drawn.
struct Frame {
    shared: Arc<Shared>,
    look: Look,
    size: [u32; 2],
    repaint: egui::Context,
}

impl CallbackTrait for Frame {
    fn prepare(
        &self,
        _device: &wgpu::Device,
        _queue: &wgpu::Queue,
        _screen: &ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        _resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if self.shared.is_busy.load(Ordering::Acquire) {
            // What is asked for now is drawn when the last frame is done.
            self.shared.is_awaited.store(true, Ordering::Release);
            self.repaint.request_repaint_after(ASK_AGAIN);
            return Vec::new();
        }
        let mut rest = self.shared.rest.lock().unwrap_or_else(PoisonError::into_inner);
        if rest.as_ref().is_some_and(|(look, size)| *look == self.look && *size == self.size) {
            return Vec::new();
        }
        let mut stage = self.shared.stage.lock().unwrap_or_else(PoisonError::into_inner);
        match stage.draw(self.size, &self.look) {
            Ok(_) if stage.is_empty() => {}
            Ok(is_better_yet) => {
                *rest = (!is_better_yet).then(|| (self.look.clone(), self.size));
                self.await_frame(&stage, is_better_yet);
            }
            Err(error) => {
                let mut fault = self.shared.fault.lock().unwrap_or_else(PoisonError::into_inner);
                *fault = Some(error.to_string());
            }
        }
        Vec::new()
    }

    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        _resources: &CallbackResources,
    ) {
        self.shared.stage.lock().unwrap_or_else(PoisonError::into_inner).paint(pass);
    }
}

impl Frame {
    /// Asks for another frame when this one is done, if it makes the picture better or is wanted by then.
    fn await_frame(&self, stage: &Stage, is_better_yet: bool) {
        let (shared, repaint) = (Arc::clone(&self.shared), self.repaint.clone());
        shared.is_busy.store(true, Ordering::Release);
        shared.is_awaited.store(is_better_yet, Ordering::Release);
        stage.gpu().queue().on_submitted_work_done(move || {
            shared.is_busy.store(false, Ordering::Release);
            let is_first = shared.frames.fetch_add(1, Ordering::Relaxed) == 0;
            if shared.is_awaited.load(Ordering::Acquire) || is_first {
                repaint.request_repaint();
            }
        });
        self.repaint.request_repaint_after(ASK_AGAIN);
    }
}

impl Picture {
    /// An empty one for targets of this format.
    pub(super) fn new(gpu: Gpu, format: wgpu::TextureFormat) -> Result<Self> {
        let adapter = gpu.to_string();
        let mut stage = Stage::new(gpu, format)?;
        stage.limit_waves(WAVES);
        let shared = Shared {
            stage: Mutex::new(stage),
            fault: Mutex::new(None),
            rest: Mutex::new(None),
            is_busy: AtomicBool::new(false),
            is_awaited: AtomicBool::new(false),
            frames: AtomicU32::new(0),
        };
        Ok(Self { shared: Arc::new(shared), adapter, is_on_dome: false })
    }

    /// Puts something else on.
    pub(super) fn put(&self, show: &Show) -> Result<()> {
        *self.shared.rest.lock().unwrap_or_else(PoisonError::into_inner) = None;
        self.shared.stage.lock().unwrap_or_else(PoisonError::into_inner).put(show)
    }

    /// What draws it.
    pub(super) fn adapter(&self) -> &str {
        &self.adapter
    }

    /// Frames so far.
    pub(super) fn frames(&self) -> u32 {
        self.shared.frames.load(Ordering::Relaxed)
    }

    /// Memory of tables and meshes on the adapter, bytes.
    pub(super) fn bytes(&self) -> u64 {
        self.shared.stage.lock().unwrap_or_else(PoisonError::into_inner).bytes()
    }

    /// Why the last frame could not be drawn; told once.
    pub(super) fn fault(&self) -> Option<String> {
        self.shared.fault.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// The picture in all the space that there is. Dragging turns the shape; with the right button, two fingers or on the dome in the
    /// corner it moves the lamp; wheel and pinch bring the shape nearer. How it is looked at from then on.
    pub(super) fn widget(&mut self, ui: &mut Ui, view: View, extent: Extent) -> View {
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        let dome = dome_of(rect);
        if response.drag_started() {
            let from = ui.input(|input| input.pointer.press_origin());
            self.is_on_dome = from.is_some_and(|from| dome.contains(from));
        }
        let mut view = view;
        let drag = response.drag_delta();
        let drag = [drag.x, drag.y].map(f64::from);
        if let Some(touch) = ui.input(egui::InputState::multi_touch).filter(|_| response.contains_pointer()) {
            let moved = touch.translation_delta;
            view = view.relit([moved.x, moved.y].map(f64::from)).zoomed(1.0 / f64::from(touch.zoom_delta));
        } else if self.is_on_dome && response.dragged() {
            if let Some(at) = response.interact_pointer_pos() {
                view = view.lit_from(place_on(dome, at));
            }
        } else if response.clicked() && response.interact_pointer_pos().is_some_and(|at| dome.contains(at)) {
            let at = response.interact_pointer_pos().unwrap_or(dome.center());
            view = view.lit_from(place_on(dome, at));
        } else if response.dragged_by(PointerButton::Primary) {
            view = view.orbited(drag);
        } else if response.dragged_by(PointerButton::Secondary) {
            view = view.relit(drag);
        } else if response.double_clicked() {
            let usual = View::usual();
            view = View { stops: view.stops, individuals: view.individuals, ..usual };
        }
        if response.hovered() {
            let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta.y, input.zoom_delta()));
            view = view.zoomed((-PER_SCROLL * f64::from(scroll)).exp() / f64::from(pinch));
        }
        let scale = ui.ctx().pixels_per_point().min(MOST_SCALE);
        let size = [rect.width(), rect.height()].map(|side| ((side * scale).round() as u32).max(1));
        let frame = Frame {
            shared: Arc::clone(&self.shared),
            look: view.look(extent, size),
            size,
            repaint: ui.ctx().clone(),
        };
        ui.painter().add(egui_wgpu::Callback::new_paint_callback(rect, frame));
        draw_dome(ui, dome, view.lamp);
        view
    }

    /// A sentence over the picture.
    pub(super) fn caption(&self, ui: &Ui, text: &str) {
        let area = ui.min_rect();
        let painter = ui.painter_at(area);
        let font = FontId::proportional(14.0);
        let galley = painter.layout(text.to_owned(), font, Color32::WHITE, area.width() - 64.0);
        let at = pos2(area.center().x - 0.5 * galley.size().x, area.top() + 20.0);
        let back = Rect::from_min_size(at, galley.size()).expand(8.0);
        painter.rect_filled(back, 5.0, Color32::from_black_alpha(190));
        painter.galley(at, galley, Color32::WHITE);
    }
}

/// Where the dome is: the lower left corner.
fn dome_of(rect: Rect) -> Rect {
    let radius = DOME.min(0.2 * rect.width().min(rect.height()));
    let middle = rect.left_bottom() + vec2(DOME_MARGIN + radius, -DOME_MARGIN - radius);
    Rect::from_center_size(middle, vec2(2.0 * radius, 2.0 * radius))
}

/// A place on the dome: to the right and up, 1 its rim.
fn place_on(dome: Rect, at: Pos2) -> [f64; 2] {
    let away = (at - dome.center()) / (0.5 * dome.width().max(1.0));
    [f64::from(away.x), f64::from(-away.y)]
}

/// The half sphere of all directions that light what is seen, from the camera, with the lamp on it.
fn draw_dome(ui: &Ui, dome: Rect, lamp: DVec3) {
    let painter = ui.painter();
    let (middle, radius) = (dome.center(), 0.5 * dome.width());
    painter.circle(middle, radius, Color32::from_black_alpha(120), Stroke::new(1.0, Color32::from_gray(130)));
    painter.circle_stroke(middle, 0.5 * radius, Stroke::new(0.5, Color32::from_gray(90)));
    let at = middle + radius * vec2(lamp.x as f32, -lamp.y as f32);
    let sun = Color32::from_rgb(255, 214, 120);
    painter.line_segment([middle, at], Stroke::new(1.0, Color32::from_gray(130)));
    painter.circle_filled(at, 6.0, sun);
    for ray in 0..8 {
        let (sin, cos) = (std::f32::consts::TAU * ray as f32 / 8.0).sin_cos();
        let out = vec2(cos, sin);
        painter.line_segment([at + 8.0 * out, at + 11.0 * out], Stroke::new(1.5, sun));
    }
    let below = middle + vec2(0.0, radius - 4.0);
    painter.text(below, Align2::CENTER_BOTTOM, "lamp", FontId::proportional(11.0), Color32::from_gray(190));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lamp stands where it is drawn.
    #[test]
    fn places_on_the_dome_are_the_lamps() {
        let dome = dome_of(Rect::from_min_size(pos2(0.0, 0.0), vec2(800.0, 600.0)));
        assert!(dome.left() > 0.0 && dome.bottom() < 600.0);
        let [x, y] = place_on(dome, dome.center() + vec2(0.5 * DOME, -0.25 * DOME));
        let view = View::usual().lit_from([x, y]);
        assert!((view.lamp.x - 0.5).abs() < 1e-6 && (view.lamp.y - 0.25).abs() < 1e-6);
    }
}
