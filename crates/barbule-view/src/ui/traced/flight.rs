//! A flight from a bird to its barbules, and back.

use barbule::DVec3;
use eframe::egui::Ui;

use super::Traced;
use crate::state::{Camera, State};
use crate::ui::Action;

/// How long it takes, s.
const SECONDS: f64 = 8.0;
/// How wide the picture is at its end where no end is known, mm: some forty barbules.
const NEAR_MM: f64 = 1.0;

/// Where flights end in scenes of which a good place is known: on gloss, seen so that its barbules are side by side.
const ENDS: [(&str, Camera); 1] = [(
    "starling-bird",
    Camera { azimuth_deg: 66.0, elevation_deg: 10.0, width_mm: 1.8, target_mm: [27.3, 47.0, 20.8] },
)];

/// A camera on its way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flight {
    from: Camera,
    to: Camera,
    /// When it began, s; none before its first step.
    began: Option<f64>,
}

impl Flight {
    pub(super) fn new(from: Camera, to: Camera) -> Self {
        Self { from, to, began: None }
    }

    /// The camera after a share of the way, 0 … 1. It begins and ends gently; widths change by equal factors, and what it ends at moves in a
    /// straight line through the picture.
    pub(super) fn at(&self, share: f64) -> Camera {
        let Self { from, to, .. } = self;
        let t = share.clamp(0.0, 1.0);
        // With neither speed nor acceleration at its ends (Perlin 2002).
        let eased = t * t * t * (t * (6.0 * t - 15.0) + 10.0);
        let width_mm = from.width_mm * (to.width_mm / from.width_mm).powf(eased);
        let way = from.width_mm - to.width_mm;
        // Where widths differ, the target's distance from the end shrinks as they do.
        let left =
            if way.abs() > 1e-6 * from.width_mm { (width_mm - to.width_mm) / way } else { 1.0 - eased };
        let (start, end) = (DVec3::from(from.target_mm), DVec3::from(to.target_mm));
        let turn = (to.azimuth_deg - from.azimuth_deg + 180.0).rem_euclid(360.0) - 180.0;
        Camera {
            azimuth_deg: (from.azimuth_deg + eased * turn).rem_euclid(360.0),
            elevation_deg: from.elevation_deg + eased * (to.elevation_deg - from.elevation_deg),
            width_mm,
            target_mm: (end + (start - end) * left).into(),
        }
    }
}

/// Where a flight ends that begins in a state: at a place that is known, else at what is in the middle of the picture.
pub(super) fn end(state: &State, middle: Option<DVec3>) -> Camera {
    let (view, text) = (state.view(), state.subject().text());
    let name = view.preset.as_deref().unwrap_or(text);
    match ENDS.iter().find(|(known, _)| *known == name) {
        Some((_, camera)) => *camera,
        None => {
            let target_mm = middle.map_or(view.camera.target_mm, DVec3::into);
            Camera { width_mm: NEAR_MM.min(view.camera.width_mm), target_mm, ..view.camera }
        }
    }
}

/// A step of the flight that is on its way, if one is.
pub(super) fn step(ui: &Ui, memory: &mut Traced, actions: &mut Vec<Action>) {
    let Some(flight) = &mut memory.flight else { return };
    let now = ui.input(|input| input.time);
    let share = (now - *flight.began.get_or_insert(now)) / SECONDS;
    let camera = flight.at(share);
    actions.push(Action::look("camera", move |view| view.camera = camera));
    if share >= 1.0 {
        memory.flight = None;
        actions.push(Action::Settle);
    }
    ui.ctx().request_repaint();
}
