//! The outline of a vane: its half width along the shaft on either side, and the barbs' angles.

use super::shaft::Shaft;
use super::{BarbShape, Feather, VaneDisc, smoothstep};

/// Length of the step in an emarginated vane, as a share of the vane.
const EMARGINATION_STEP: f64 = 0.08;

/// One of the two vanes of a feather.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Vane {
    /// That which cuts the air: the narrower one of a flight feather.
    Leading,
    /// The other one.
    Trailing,
}

impl Vane {
    /// Both, leading first.
    pub const BOTH: [Self; 2] = [Self::Leading, Self::Trailing];
}

impl Feather {
    /// Which vane lies on a side, −1: left of the shaft, 1: right, seen from the dorsal side.
    #[must_use]
    pub fn vane_at(&self, side: f64) -> Vane {
        if side * self.leading.sign() > 0.0 { Vane::Leading } else { Vane::Trailing }
    }

    /// Half width of a vane at an arc length of the shaft, mm, measured from the shaft's axis: the barbs' ends lie there, but
    /// nowhere inside the shaft.
    #[must_use]
    pub fn half_width(&self, shaft: &Shaft, vane: Vane, along_mm: f64) -> f64 {
        self.barbs.outline(vane, shaft.vane(along_mm)).max(shaft.radius(along_mm))
    }

    /// Area of both vanes, mm².
    #[must_use]
    pub fn vane_area(&self) -> f64 {
        self.vane_area_in(VaneDisc::WHOLE)
    }

    /// Area of both vanes within a window about a straight shaft, mm² (midpoint rule).
    #[must_use]
    pub fn vane_area_in(&self, window: VaneDisc) -> f64 {
        const PARTS: u32 = 400;
        let first = self.shaft.length_mm * self.shaft.calamus;
        let length = self.shaft.length_mm - first;
        // Half a chord of the window.
        let chord = |along_mm: f64| {
            window.radius_mm.map_or(f64::INFINITY, |radius| {
                let away = along_mm - window.along_mm;
                (radius * radius - away * away).max(0.0).sqrt()
            })
        };
        let width = |t: f64| {
            let half = chord(first + t * length);
            Vane::BOTH.iter().map(|vane| self.barbs.outline(*vane, t).min(half)).sum::<f64>()
        };
        let parts = (0..PARTS).map(|i| width((f64::from(i) + 0.5) / f64::from(PARTS)));
        parts.sum::<f64>() * length / f64::from(PARTS)
    }
}

impl BarbShape {
    /// Half width of a vane at a share of its length, mm: W (t/t_m)^a ((1 − t)/(1 − t_m))^b, t_m = a/(a + b), and the leading
    /// one's emargination.
    #[must_use]
    pub fn outline(&self, vane: Vane, t: f64) -> f64 {
        let t = t.clamp(0.0, 1.0);
        let (a, b) = (self.outline_base, self.outline_tip);
        let widest = a / (a + b);
        let share = libm::pow(t / widest, a) * libm::pow((1.0 - t) / (1.0 - widest), b);
        match vane {
            Vane::Trailing => self.trailing_half_width_mm * share,
            Vane::Leading => {
                let narrowed = smoothstep((t - self.emargination_start) / EMARGINATION_STEP);
                self.leading_half_width_mm * share * (1.0 - self.emargination * narrowed)
            }
        }
    }

    /// Largest half width of a vane, mm.
    pub(super) fn half_width_mm(&self, vane: Vane) -> f64 {
        match vane {
            Vane::Leading => self.leading_half_width_mm,
            Vane::Trailing => self.trailing_half_width_mm,
        }
    }

    /// Angle of the barbs to the shaft at a share of the vane's length, rad.
    #[must_use]
    pub fn insertion(&self, vane: Vane, t: f64) -> f64 {
        let [base, tip] = match vane {
            Vane::Leading => [self.leading_base_angle, self.leading_tip_angle],
            Vane::Trailing => [self.trailing_base_angle, self.trailing_tip_angle],
        };
        base + (tip - base) * smoothstep(t)
    }
}
