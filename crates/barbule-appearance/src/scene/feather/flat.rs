//! The vanes as zones see them: flat, with straight barbs.

use super::row::BASE_SHARE;
use super::{Feather, Shaft};
use crate::Result;
use crate::bsdf::{FlatVane, STATIONS, StraightBarb, ZonePlan, Zones};

/// How far the straight line from its base that lies nearest to an even turn (least squares over its length) has turned, over that turn:
/// half of ∫a³/∫a².
const MEAN_TURN: f64 = 0.375;

/// Sine and cosine of the angle to the shaft of the straight line nearest to a barb that leaves it at an angle and turns evenly.
pub(super) fn straight(angle: f64, turn: f64) -> [f64; 2] {
    let straight = angle - MEAN_TURN * turn;
    [libm::sin(straight), libm::cos(straight)]
}

impl Feather {
    /// Zones of its vanes.
    ///
    /// # Errors
    /// As [`Zones::new`].
    pub fn zones(&self, plan: ZonePlan) -> Result<Zones> {
        Zones::new(self.flat_vane(), plan)
    }

    /// Its vanes without draws: barbs begin where those of the feather do, and each is the straight line nearest to its even turn.
    #[must_use]
    pub fn flat_vane(&self) -> FlatVane {
        let (shaft, shape) = (Shaft::new(&self.shaft), &self.barbs);
        let [base_mm, tip_mm] = shaft.vane_range();
        let length_mm = tip_mm - base_mm;
        let fan_mm = self.fan_from_mm();
        let sides = [-1.0, 1.0].map(|side| self.vane_at(side));
        let barbs = sides.map(|vane| {
            std::array::from_fn(|station| {
                let along_mm = fan_mm + (tip_mm - fan_mm) * station as f64 / (STATIONS - 1) as f64;
                let t = shaft.vane(along_mm);
                let angle = self.insertion(vane, t);
                StraightBarb {
                    start_mm: BASE_SHARE * shaft.radius(along_mm),
                    direction: straight(angle, self.turn_of(angle, t)),
                }
            })
        });
        let half_widths_mm = sides.map(|vane| shape.half_width_mm(vane));
        FlatVane { base_mm, length_mm, stations_mm: [fan_mm - base_mm, length_mm], half_widths_mm, barbs }
    }
}
