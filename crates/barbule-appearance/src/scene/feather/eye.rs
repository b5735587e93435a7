//! Eyes of a train: a zipped disc near the feather's tip, fringed, on barbs that stand apart below it.
//!
//! In the flat vane of the zones ([`crate::bsdf::FlatVane`]) the eye is an ellipse about a place of the shaft's axis. A barb is hooked to
//! its neighbours until it leaves the ellipse, and free beyond; one that leaves the shaft below the eye is free from its base. What is
//! free leaves the vane's plane and waves, the farther the longer it is.

use glam::{DVec2, DVec3};

use super::outline::Vane;
use super::row::FlatBarb;
use super::shaft::{Shaft, Station};
use super::{EyeShape, Feather, noise, smoothstep};
use crate::math::rng::{Stream, hash};

/// Over so much of a barb beyond the eye it begins to leave its place, mm.
const ONSET_MM: f64 = 4.0;

impl EyeShape {
    /// Whether there is one.
    #[must_use]
    pub fn is_there(&self) -> bool {
        self.length_mm > 0.0
    }

    /// Where a straight barb from a place of the flat vane leaves the ellipse for good, as an arc length on it, mm; where it passes beside
    /// it the place nearest to it, in its own measure. `tip_mm`: arc length of the shaft's tip.
    fn leaves(&self, [x, y]: [f64; 2], [sin, cos]: [f64; 2], tip_mm: f64) -> f64 {
        let axes = DVec2::new(self.half_width_mm, self.half_length_mm);
        let from = DVec2::new(x, y - (tip_mm - self.middle_mm)) / axes;
        let step = DVec2::new(sin, cos) / axes;
        // |from + e step|² = 1
        let (a, b, c) = (step.length_squared(), from.dot(step), from.length_squared() - 1.0);
        let root = (b * b - a * c).max(0.0).sqrt();
        ((root - b) / a).max(0.0)
    }
}

impl Feather {
    /// How loose the barbs stand at a place of the vane: 0 in an eye and in a feather without one, 1 below it.
    fn apart(&self, t: f64) -> f64 {
        if !self.eye.is_there() {
            return 0.0;
        }
        let before_mm = (1.0 - t) * self.vane_mm() - self.eye.length_mm;
        smoothstep(before_mm / self.eye.border_mm)
    }

    /// Length of the vane along the shaft, mm.
    fn vane_mm(&self) -> f64 {
        self.shaft.length_mm * (1.0 - self.shaft.calamus)
    }

    /// Distance between neighbouring barbs, perpendicular to them, at a share of the vane's length, mm: from that of the eye to that below
    /// it by equal factors.
    #[must_use]
    pub fn spacing_mm(&self, t: f64) -> f64 {
        let (own, apart) = (1e-3 * self.barbs.spacing_um, self.apart(t));
        if apart == 0.0 {
            return own;
        }
        own * libm::pow(1e-3 * self.eye.loose_spacing_um / own, apart)
    }

    /// Angle of the barbs to the shaft at a share of the vane's length, rad; with an eye its barbs fan out, and all below stand as its
    /// first.
    #[must_use]
    pub fn insertion(&self, vane: Vane, t: f64) -> f64 {
        if !self.eye.is_there() {
            return self.barbs.insertion(vane, t);
        }
        self.barbs.insertion(vane, 1.0 - (1.0 - t) * self.vane_mm() / self.eye.length_mm.min(self.vane_mm()))
    }

    /// How much a barb that leaves the shaft at an angle turns towards the tip, at a share of the vane's length: back, where it hangs.
    pub(super) fn turn_of(&self, angle: f64, t: f64) -> f64 {
        let (own, apart) = (self.barbs.curl_at(angle), self.apart(t));
        own + (-self.eye.hang - own) * apart
    }

    /// From where on the shaft directions of barbs may differ from place to place, mm.
    pub(super) fn fan_from_mm(&self) -> f64 {
        let base_mm = self.shaft.length_mm * self.shaft.calamus;
        if !self.eye.is_there() {
            return base_mm;
        }
        (self.shaft.length_mm - self.eye.length_mm - self.eye.border_mm).max(base_mm)
    }

    /// Of a barb of a feather with an eye, which leaves the shaft's axis by `start_mm` at `along_mm` under `angle`: its length, and the
    /// arc length up to which it is hooked, mm; nothing where there is no eye.
    pub(super) fn reach(
        &self,
        shaft: &Shaft,
        [start_mm, along_mm]: [f64; 2],
        angle: f64,
    ) -> Option<[f64; 2]> {
        if !self.eye.is_there() {
            return None;
        }
        let t = shaft.vane(along_mm).clamp(0.0, 1.0);
        let straight = super::flat::straight(angle, self.turn_of(angle, t));
        let [_, tip_mm] = shaft.vane_range();
        let hooked = self.eye.leaves([start_mm, along_mm], straight, tip_mm);
        let apart = self.apart(t);
        let fringed = hooked + self.eye.fringe_mm;
        Some([fringed + (self.eye.loose_length_mm - fringed) * apart, hooked * (1.0 - apart)])
    }
}

/// How the free part of a barb leaves its place in the vane.
pub(super) struct Sway {
    hooked_mm: f64,
    /// Slopes out of the vane's plane and across the barb in it.
    lean: [f64; 2],
    wave: f64,
    wavelength_mm: f64,
    name: u64,
    across: [DVec3; 2],
}

impl Sway {
    /// Of a barb that leaves the shaft at `base`; nothing where hooks hold all of it.
    pub(super) fn new(eye: &EyeShape, barb: &FlatBarb, base: &Station, side: f64) -> Option<Self> {
        if barb.hooked_mm >= barb.length {
            return None;
        }
        let mut stream = Stream::new(barb.id, &[7]);
        let slope = libm::tan(eye.spread);
        let lean = [slope * stream.normal(), 0.3 * slope * stream.normal()].map(|lean| lean.clamp(-2.0, 2.0));
        let along = base.right * (side * libm::sin(barb.angle)) + base.tip * libm::cos(barb.angle);
        Some(Self {
            hooked_mm: barb.hooked_mm,
            lean,
            wave: eye.wave,
            wavelength_mm: eye.wavelength_mm,
            name: hash(barb.id, &[8]),
            across: [base.normal, base.normal.cross(along).normalize_or(base.right) * side],
        })
    }

    /// A point of the vane at an arc length of the barb, moved.
    pub(super) fn moved(&self, point: DVec3, arc_mm: f64) -> DVec3 {
        let free = (arc_mm - self.hooked_mm).max(0.0);
        // Stiff where it is still held.
        let free = free * free / (free + ONSET_MM);
        let wave = |k: u64| noise::smooth(hash(self.name, &[k]), arc_mm / self.wavelength_mm);
        let moved = |k: usize| self.across[k] * (free * (self.lean[k] + self.wave * wave(k as u64)));
        point + moved(0) + moved(1)
    }
}
