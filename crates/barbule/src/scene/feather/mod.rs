//! Feathers grown from parameters: a shaft, barbs on both sides, barbules on both sides of every barb.
//!
//! Parameters follow the biological description of Streit & Heidrich 2002 and Chen et al. 2002; sizes per species are
//! in [`species`]. Every draw is named by its place (barb, side, barbule), so one barbule never depends on another.

mod barb;
mod barbule;
mod shaft;
pub mod species;

use glam::DVec3;

pub use barb::Barb;
pub use shaft::{Shaft, Station};

use super::geometry::Geometry;
use crate::{Error, Result};

/// The shaft of a feather. The centre line bends by angles that are quadratic in the arc length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShaftShape {
    /// Length of the whole shaft, mm.
    pub length_mm: f64,
    /// Share of the length that bears no barbs (the quill).
    pub calamus: f64,
    /// Radius at the base, mm.
    pub radius_mm: f64,
    /// Radius at the tip, mm.
    pub tip_radius_mm: f64,
    /// Exponent of the taper.
    pub taper: f64,
    /// Height over width of the cross-section.
    pub height: f64,
    /// Bend in the vane's plane at the tip: linear and quadratic part, rad.
    pub bend: [f64; 2],
    /// Bend towards the dorsal side at the tip: linear and quadratic part, rad.
    pub arch: [f64; 2],
}

/// The barbs of a feather.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BarbShape {
    /// Distance between neighbours, perpendicular to them, µm.
    pub spacing_um: f64,
    /// Angle to the shaft at the vane's base and tip, opening towards the tip, rad.
    pub angle: [f64; 2],
    /// How much a barb turns towards the feather's tip from its base to its end, rad.
    pub curl: f64,
    /// Sag of the vane at its edge over its half width.
    pub camber: f64,
    /// Width of the ramus at its base, µm.
    pub width_um: f64,
    /// Height over width of the ramus.
    pub height: f64,
    /// Half width of the vane, mm.
    pub half_width_mm: f64,
    /// Exponents a, b of the outline w(t) = W (t/t_m)^a ((1 − t)/(1 − t_m))^b, t_m = a/(a + b).
    pub outline: [f64; 2],
}

/// The barbules on one side of the barbs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BarbuleShape {
    /// Length in the middle of a barb, µm.
    pub length_um: f64,
    /// Full width, µm.
    pub width_um: f64,
    /// Distance between neighbours along the ramus, µm.
    pub spacing_um: f64,
    /// Angle to the barb at the barbule's base and end, rad.
    pub angle: [f64; 2],
    /// Elevation over the vane at the base and end, rad.
    pub lift: [f64; 2],
    /// Turn about its own axis, rad: positive turns the upper side towards the barb's tip.
    pub tilt: f64,
    /// Further turn at the root, gone after a tenth of the length, rad.
    pub root_tilt: f64,
    /// Length of a cell, µm: structure is constant within it.
    pub cell_um: f64,
    /// Swelling of cells, low arches along the barbule: slope at their ends, rad.
    pub swelling: f64,
}

/// Random differences.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disorder {
    /// Of barbs: length (share), angle (rad), spacing (share).
    pub barb: [f64; 3],
    /// Of barbules: planar angle (rad), lift (rad), spacing (share), length (share).
    pub barbule: [f64; 4],
    /// Turn of a barbule about its own axis, rad, beyond what its material holds.
    pub turn: f64,
}

/// A whole feather.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feather {
    /// The shaft.
    pub shaft: ShaftShape,
    /// The barbs.
    pub barb: BarbShape,
    /// Barbules on the side of the feather's tip (distal), then on the other (proximal).
    pub barbule: [BarbuleShape; 2],
    /// Random differences.
    pub disorder: Disorder,
}

/// The part of a feather to grow: a box in the plane of the vane about a point of the shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Arc length of its middle on the shaft, mm.
    pub along_mm: f64,
    /// Half its extent along the shaft, mm.
    pub half_length_mm: f64,
    /// Half its extent across, mm.
    pub half_width_mm: f64,
}

/// Surfaces of the parts, as indices into a scene's list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parts {
    /// Of the shaft.
    pub shaft: u32,
    /// Of the rami.
    pub ramus: u32,
    /// Of the barbules.
    pub barbule: u32,
}

/// How many of each part were grown.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Barbs.
    pub barbs: usize,
    /// Barbules.
    pub barbules: usize,
}

impl Feather {
    /// Refuses parameters that make no feather.
    ///
    /// # Errors
    /// A length, width or spacing that is not positive or not finite, or an angle out of range.
    pub fn check(&self) -> Result<()> {
        let positive = [
            ("the shaft's length", self.shaft.length_mm),
            ("the shaft's radius", self.shaft.radius_mm),
            ("the shaft's radius at the tip", self.shaft.tip_radius_mm),
            ("the barbs' spacing", self.barb.spacing_um),
            ("the barbs' width", self.barb.width_um),
            ("the vane's half width", self.barb.half_width_mm),
            ("the distal barbules' length", self.barbule[0].length_um),
            ("the distal barbules' width", self.barbule[0].width_um),
            ("the distal barbules' spacing", self.barbule[0].spacing_um),
            ("the proximal barbules' length", self.barbule[1].length_um),
            ("the proximal barbules' width", self.barbule[1].width_um),
            ("the proximal barbules' spacing", self.barbule[1].spacing_um),
        ];
        for (name, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::input(format!("{name} is {value}, but must be greater than zero")));
            }
        }
        if !(0.0..1.0).contains(&self.shaft.calamus) {
            return Err(Error::input("the quill's share of the shaft must be 0 to 1"));
        }
        Ok(())
    }

    /// Grows the part of the feather within a window, moved so that the window's middle is the origin. `seed` and
    /// `identity` name every random draw.
    ///
    /// # Errors
    /// As [`Feather::check`].
    pub fn grow(
        &self,
        geometry: &mut Geometry,
        parts: Parts,
        window: Window,
        seed: u64,
        identity: u64,
    ) -> Result<Counts> {
        self.check()?;
        let shaft = Shaft::new(&self.shaft);
        let origin = shaft.at(window.along_mm).point;
        shaft.mesh(geometry, parts.shaft, window, origin, identity);
        let mut counts = Counts::default();
        for side in [-1.0, 1.0] {
            for barb in barb::along(self, &shaft, side, window, seed, identity) {
                if !barb.is_within(origin, window) {
                    continue;
                }
                barb.mesh(geometry, &self.barb, parts.ramus, origin);
                counts.barbs += 1;
                for (which, shape) in self.barbule.iter().enumerate() {
                    counts.barbules += barbule::along(
                        geometry,
                        &barb,
                        shape,
                        &self.disorder,
                        which,
                        parts.barbule,
                        (origin, window),
                        seed,
                    );
                }
            }
        }
        Ok(counts)
    }
}

impl Window {
    fn holds(&self, point: DVec3) -> bool {
        point.x.abs() <= self.half_width_mm && point.y.abs() <= self.half_length_mm
    }
}
