//! How a view is looked at on a stage.

use barbule::scene::description::ToneWord;

use crate::stage::Look;
use crate::state::{Camera, Shown, View};

/// Behind everything: a dark neutral grey, in which colours are judged well; #26282b, as in the scenes that are exported.
const BEHIND: [f32; 3] = [0.0194, 0.0212, 0.0242];

/// Camera and light of a view.
#[must_use]
pub fn look(view: &View) -> Look {
    let frame = view.camera.frame();
    let sky = view.light.sky as f32;
    Look {
        target_mm: frame.target_mm,
        up: frame.up,
        towards: frame.towards,
        width_mm: view.camera.width_mm,
        distance: Camera::DISTANCE,
        to_lamp: view.light.direction(),
        lamp_radius: view.light.radius_deg.to_radians(),
        lamp: view.light.strength,
        sky: [sky; 3],
        contrast: if view.shown == Shown::Individuals { 1.0 } else { 0.0 },
        stops: 0.0,
        tone: ToneWord::Filmic,
        behind: BEHIND,
    }
}
