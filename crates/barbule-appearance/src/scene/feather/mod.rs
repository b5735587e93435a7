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

/// The part of a feather to grow: a disc in the plane of the vane about a point of the shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Arc length of its middle on the shaft, mm.
    pub along_mm: f64,
    /// Its radius, mm.
    pub radius_mm: f64,
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
        point.x * point.x + point.y * point.y <= self.radius_mm * self.radius_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::geometry::RibbonNode;

    const PARTS: Parts = Parts { shaft: 0, ramus: 1, barbule: 2 };

    fn species() -> [(&'static str, Feather); 4] {
        [
            ("rock dove", species::rock_dove()),
            ("starling", species::starling()),
            ("bronzewing", species::bronzewing()),
            ("hummingbird", species::hummingbird()),
        ]
    }

    fn window(feather: &Feather) -> Window {
        Window { along_mm: 0.6 * feather.shaft.length_mm, radius_mm: 1.1 }
    }

    #[test]
    fn the_same_seed_gives_the_same_feather_and_another_does_not() {
        let grow = |seed| {
            let feather = species::starling();
            let mut geometry = Geometry::default();
            feather.grow(&mut geometry, PARTS, window(&feather), seed, 5).unwrap();
            geometry.ribbon_nodes
        };
        assert_eq!(grow(1), grow(1));
        assert_ne!(grow(1), grow(2));
    }

    #[test]
    fn barbs_are_as_many_as_their_perpendicular_spacing_says() {
        for (name, feather) in species() {
            let shaft = Shaft::new(&feather.shaft);
            let everything = Window { along_mm: 0.5 * feather.shaft.length_mm, radius_mm: 100.0 };
            let barbs = barb::along(&feather, &shaft, 1.0, everything, 1, 1);
            // ∫ ds sin(angle)/p over the vane.
            let [first, last] = shaft.vane_range();
            let steps = 2000;
            let step = (last - first) / f64::from(steps);
            let expected: f64 = (0..steps)
                .map(|i| {
                    let t = shaft.vane(first + (f64::from(i) + 0.5) * step);
                    let smooth = t * t * (3.0 - 2.0 * t);
                    let angle =
                        feather.barb.angle[0] + (feather.barb.angle[1] - feather.barb.angle[0]) * smooth;
                    step * angle.sin() / (1e-3 * feather.barb.spacing_um)
                })
                .sum();
            assert!((barbs.len() as f64 - expected).abs() < 2.0, "{name}: {} {expected}", barbs.len());
        }
    }

    /// Barbs are curved and of random length (3 %), so their ends scatter about the outline of straight ones.
    #[test]
    fn ends_of_straight_barbs_lie_on_the_outline() {
        let mut feather = species::starling();
        feather.barb.curl = 0.0;
        feather.barb.camber = 0.0;
        feather.shaft.arch = [0.0; 2];
        feather.shaft.radius_mm = 1e-6;
        feather.shaft.tip_radius_mm = 1e-6;
        feather.disorder.barb = [0.0; 3];
        let shaft = Shaft::new(&feather.shaft);
        let everything = Window { along_mm: 15.0, radius_mm: 30.0 };
        for barb in barb::along(&feather, &shaft, 1.0, everything, 1, 1) {
            let end = barb.points[barb.points.len() - 1];
            let t = shaft.vane(end.y);
            if t > 0.98 {
                continue;
            }
            let [a, b] = feather.barb.outline;
            let m = a / (a + b);
            let w = feather.barb.half_width_mm * (t / m).powf(a) * ((1.0 - t) / (1.0 - m)).powf(b);
            // The slow wave of a barb moves its end by some hundredths of its length.
            assert!((end.x - w).abs() < 0.05 * barb.length_mm + 0.05, "{end} {w}");
        }
    }

    #[test]
    fn barbules_of_the_two_vanes_mirror_each_other_without_disorder() {
        let mut feather = species::bronzewing();
        feather.disorder = Disorder { barb: [0.0; 3], barbule: [0.0; 4], turn: 0.0 };
        let shaft = Shaft::new(&feather.shaft);
        let grow = |side: f64| {
            let window = window(&feather);
            let mut barb = barb::along(&feather, &shaft, side, window, 1, 1).remove(3);
            // The slow wave is the barb's own: lay both barbs straight.
            let tangent = DVec3::new(side * 0.6, 0.8, 0.0);
            let steps = barb.points.len();
            for (i, point) in barb.points.iter_mut().enumerate() {
                *point = DVec3::new(side * 0.2, 0.0, 0.0) + tangent * (0.1 * i as f64);
            }
            barb.tangents = vec![tangent; steps];
            barb.normals = vec![DVec3::Z; steps];
            barb.length_mm = 0.1 * (steps - 1) as f64;
            let mut geometry = Geometry::default();
            let wide = Window { along_mm: 0.0, radius_mm: 50.0 };
            barbule::along(
                &mut geometry,
                &barb,
                &feather.barbule[0],
                &feather.disorder,
                0,
                2,
                (DVec3::ZERO, wide),
                1,
            );
            geometry.ribbon_nodes
        };
        let (left, right) = (grow(-1.0), grow(1.0));
        assert!(right.len() > 100);
        let mirrored = |n: &RibbonNode| glam::Vec3::new(-n.point.x, n.point.y, n.point.z);
        for (l, r) in left.iter().zip(&right) {
            assert!((mirrored(l) - r.point).length() < 1e-5);
        }
    }

    #[test]
    fn frames_across_a_barbule_face_upwards() {
        for (name, feather) in species() {
            let mut geometry = Geometry::default();
            let counts = feather.grow(&mut geometry, PARTS, window(&feather), 1, 1).unwrap();
            assert!(counts.barbs > 4 && counts.barbules > 400, "{name}: {counts:?}");
            geometry.check(3).unwrap();
            let mut upward = 0;
            for ribbon in &geometry.ribbons {
                let nodes = geometry.nodes_of(ribbon);
                let along = nodes[4].point - nodes[3].point;
                upward += usize::from(nodes[3].across.cross(along).z > 0.0);
            }
            assert!(upward == geometry.ribbons.len(), "{name}: {upward} of {}", geometry.ribbons.len());
        }
    }

    #[test]
    fn impossible_parameters_are_refused() {
        let mut feather = species::starling();
        feather.barbule[0].spacing_um = 0.0;
        assert!(feather.check().unwrap_err().to_string().contains("distal barbules' spacing"));
        feather = species::starling();
        feather.shaft.calamus = 1.0;
        assert!(feather.check().is_err());
    }
}
