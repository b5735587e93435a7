//! Feathers grown from parameters: a shaft, barbs on both sides, barbules on both sides of every barb.
//!
//! Parameters follow the biological description of Streit & Heidrich 2002 and Chen et al. 2002; presets and species
//! give their sizes in files. Every draw is named by its place (barb, side, barbule), so one barbule never depends on another.

mod barb;
mod barbule;
mod envelope;
mod shaft;
mod sizes;

use glam::DVec3;

pub use barb::Barb;
pub use envelope::tip_side;
pub use shaft::{Shaft, Station};
pub use sizes::{BarbShape, BarbuleShape, Disorder, Feather, PatternShape, ShaftShape};

use super::geometry::Geometry;
use crate::{Error, Result};

/// The part of a feather to grow: a disc in the plane of the vane about a point of the shaft, or all of it.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct VaneDisc {
    /// Arc length of its middle on the shaft, mm: the origin.
    pub along_mm: f64,
    /// Its radius, mm; the whole feather where there is none.
    pub radius_mm: Option<f64>,
}

/// The grown parts, apart by what they are made of.
#[derive(Debug, Clone, Default)]
pub struct Grown {
    /// The shaft.
    pub shaft: Geometry,
    /// The barbs' rami.
    pub rami: Geometry,
    /// The same rami as round fibres, for those who see hair in them.
    pub fibres: Geometry,
    /// The barbules towards the feather's tip, and the others.
    pub barbules: [Geometry; 2],
    /// Barbules without pigment.
    pub pale: Geometry,
    /// In place of rami and barbules: ribbons about the barbs left and right of the shaft.
    pub envelopes: [Geometry; 2],
}

/// Which parts of a feather stand there one by one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum Level {
    /// Every barbule.
    Barbules,
    /// Every barb; its barbules are looked up where a ray meets its envelope.
    Barbs,
}

impl Grown {
    /// How many barbs and barbules there are.
    #[must_use]
    pub fn counts(&self) -> Counts {
        let envelopes = self.envelopes.iter().map(|side| side.ribbons.len()).sum::<usize>();
        let barbules = self.barbules.iter().chain([&self.pale]).map(|row| row.ribbons.len()).sum();
        Counts { barbs: self.rami.meshes.len() + envelopes, barbules }
    }
}

/// How many of each part were grown.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Barbs.
    pub barbs: usize,
    /// Barbules.
    pub barbules: usize,
}

/// More barbules than this are not grown: each takes about a kilobyte.
const MOST_BARBULES: f64 = 4e6;

impl Feather {
    /// Grows the part of the feather within a window, moved so that the window's middle is the origin. `seed` and
    /// `identity` name every random draw.
    ///
    /// # Errors
    /// As [`Feather::check`]; a window that would hold more than 4 million barbules.
    pub fn grow(&self, window: VaneDisc, level: Level, seed: u64, identity: u64) -> Result<Grown> {
        self.check()?;
        if level == Level::Barbules {
            self.check_count(window)?;
        }
        let rows = [&self.distal, &self.proximal].map(|shape| shape.row(&self.disorder));
        let shaft = Shaft::new(&self.shaft);
        let origin = shaft.at(window.along_mm).point;
        let roll = envelope::roll(1e-3 * self.barbs.spacing_um);
        let pattern = self.pattern.pattern();
        let mut grown = Grown::default();
        shaft.mesh(&mut grown.shaft, window, origin, identity);
        for side in [-1.0, 1.0] {
            for barb in barb::along(self, &shaft, side, window, seed, identity) {
                if !barb.is_within(origin, window) {
                    continue;
                }
                if level == Level::Barbs {
                    let envelope = &mut grown.envelopes[usize::from(side > 0.0)];
                    envelope::add(envelope, &barb, &rows, roll, origin);
                    continue;
                }
                barb.mesh(&mut grown.rami, &self.barbs, origin);
                barb.fibre(&mut grown.fibres, origin);
                for (which, row) in rows.iter().enumerate() {
                    let grown = [&mut grown.barbules[which], &mut grown.pale];
                    barbule::along(grown, &barb, row, which, (roll, pattern), (origin, window), seed);
                }
            }
        }
        Ok(grown)
    }
}

impl Feather {
    /// Refuses a window that would hold more barbules than fit into memory.
    fn check_count(&self, window: VaneDisc) -> Result<()> {
        let barbules = self.barbules_in(window);
        if barbules <= MOST_BARBULES {
            return Ok(());
        }
        let (part, remedy) = match window.radius_mm {
            Some(radius) => (format!("the window of radius {radius} mm"), "give a smaller radius_mm"),
            None => ("the whole feather".to_owned(), "give window.radius_mm in place of window.whole"),
        };
        Err(Error::input(format!(
            "{part} may hold {barbules:.0} barbules, over the limit of {MOST_BARBULES:.0}; {remedy}"
        )))
    }

    /// About how many barbules a window holds: those on barbs that fill its area at their spacing.
    #[must_use]
    pub fn barbules_in(&self, window: VaneDisc) -> f64 {
        let whole = 2.0 * self.barbs.half_area(self.shaft.length_mm * (1.0 - self.shaft.calamus));
        let area = window.radius_mm.map_or(whole, |radius| std::f64::consts::PI * radius * radius);
        let per_mm = 1e3 / self.distal.spacing_um + 1e3 / self.proximal.spacing_um;
        area * 1e3 / self.barbs.spacing_um * per_mm
    }
}

impl VaneDisc {
    fn holds(&self, point: DVec3) -> bool {
        self.radius_mm.is_none_or(|radius| point.x * point.x + point.y * point.y <= radius * radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::description::SceneDescription;
    use crate::scene::geometry::RibbonNode;
    use crate::scene::preset;

    fn feather(name: &str) -> Feather {
        SceneDescription::named(name).unwrap().feather
    }

    fn species() -> impl Iterator<Item = (&'static str, Feather)> {
        preset::names().map(|name| (name, feather(name)))
    }

    const ORDERLY: Disorder = Disorder {
        barb_length: 0.0,
        barb_angle: 0.0,
        barb_spacing: 0.0,
        barbule_angle: 0.0,
        barbule_lift: 0.0,
        barbule_spacing: 0.0,
        barbule_length: 0.0,
        barbule_turn: 0.0,
        cell_size: 0.0,
        barbule_size: 0.0,
    };

    fn window(feather: &Feather) -> VaneDisc {
        VaneDisc { along_mm: 0.6 * feather.shaft.length_mm, radius_mm: Some(1.1) }
    }

    #[test]
    fn the_same_seed_gives_the_same_feather_and_another_does_not() {
        let grow = |seed| {
            let feather = feather("starling");
            feather
                .grow(window(&feather), Level::Barbules, seed, 5)
                .unwrap()
                .barbules
                .map(|row| row.ribbon_nodes)
        };
        assert_eq!(grow(1), grow(1));
        assert_ne!(grow(1), grow(2));
    }

    #[test]
    fn barbs_are_as_many_as_their_perpendicular_spacing_says() {
        for (name, feather) in species() {
            let shaft = Shaft::new(&feather.shaft);
            let everything = VaneDisc { along_mm: 0.5 * feather.shaft.length_mm, radius_mm: None };
            let barbs = barb::along(&feather, &shaft, 1.0, everything, 1, 1);
            // ∫ ds sin(angle)/p over the vane.
            let [first, last] = shaft.vane_range();
            let steps = 2000;
            let step = (last - first) / f64::from(steps);
            let expected: f64 = (0..steps)
                .map(|i| {
                    let t = shaft.vane(first + (f64::from(i) + 0.5) * step);
                    let smooth = t * t * (3.0 - 2.0 * t);
                    let angle = feather.barbs.base_angle
                        + (feather.barbs.tip_angle - feather.barbs.base_angle) * smooth;
                    step * angle.sin() / (1e-3 * feather.barbs.spacing_um)
                })
                .sum();
            assert!((barbs.len() as f64 - expected).abs() < 2.0, "{name}: {} {expected}", barbs.len());
        }
    }

    /// Barbs are curved and of random length (3 %), so their ends scatter about the outline of straight ones.
    #[test]
    fn ends_of_straight_barbs_lie_on_the_outline() {
        for (name, mut feather) in species() {
            feather.barbs.curl = 0.0;
            feather.barbs.camber = 0.0;
            feather.shaft.arch_quadratic = 0.0;
            feather.shaft.radius_mm = 1e-6;
            feather.shaft.tip_radius_mm = 1e-6;
            feather.disorder = ORDERLY;
            let shaft = Shaft::new(&feather.shaft);
            let (a, b) = (feather.barbs.outline_base, feather.barbs.outline_tip);
            let everything = VaneDisc { along_mm: 0.5 * feather.shaft.length_mm, radius_mm: None };
            for barb in barb::along(&feather, &shaft, 1.0, everything, 1, 1) {
                let end = barb.points[barb.points.len() - 1];
                let t = shaft.vane(end.y);
                if t > 0.98 {
                    continue;
                }
                let m = a / (a + b);
                let w = feather.barbs.half_width_mm * (t / m).powf(a) * ((1.0 - t) / (1.0 - m)).powf(b);
                // The slow wave of a barb moves its end by some hundredths of its length.
                assert!((end.x - w).abs() < 0.05 * barb.length_mm + 0.05, "{name}: {end} {w}");
            }
        }
    }

    #[test]
    fn barbules_of_the_two_vanes_mirror_each_other_without_disorder() {
        for (name, mut feather) in species() {
            feather.disorder = ORDERLY;
            mirror_each_other(name, &feather);
        }
    }

    fn mirror_each_other(name: &str, feather: &Feather) {
        let shaft = Shaft::new(&feather.shaft);
        let grow = |side: f64| {
            let window = window(feather);
            let mut barb = barb::along(feather, &shaft, side, window, 1, 1).remove(3);
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
            let wide = VaneDisc { along_mm: 0.0, radius_mm: None };
            let place = (DVec3::ZERO, wide);
            let row = feather.distal.row(&feather.disorder);
            let mut pale = Geometry::default();
            barbule::along([&mut geometry, &mut pale], &barb, &row, 0, (0.03, None), place, 1);
            geometry.ribbon_nodes
        };
        let (left, right) = (grow(-1.0), grow(1.0));
        assert!(right.len() > 100, "{name}");
        let mirrored = |n: &RibbonNode| glam::Vec3::new(-n.point.x, n.point.y, n.point.z);
        for (l, r) in left.iter().zip(&right) {
            assert!((mirrored(l) - r.point).length() < 1e-5, "{name}");
        }
    }

    #[test]
    fn frames_across_a_barbule_face_upwards() {
        for (name, feather) in species() {
            let grown = feather.grow(window(&feather), Level::Barbules, 1, 1).unwrap();
            let counts = grown.counts();
            assert!(counts.barbs > 4 && counts.barbules > 400, "{name}: {counts:?}");
            grown.shaft.check().unwrap();
            grown.rami.check().unwrap();
            grown.fibres.check().unwrap();
            assert_eq!(grown.fibres.curves.len(), counts.barbs);
            for geometry in grown.barbules {
                geometry.check().unwrap();
                let mut upward = 0;
                for ribbon in &geometry.ribbons {
                    let nodes = geometry.nodes_of(ribbon);
                    let along = nodes[4].point - nodes[3].point;
                    upward += usize::from(nodes[3].across.cross(along).z > 0.0);
                }
                assert!(upward == geometry.ribbons.len(), "{name}: {upward} of {}", geometry.ribbons.len());
            }
        }
    }

    #[test]
    fn a_whole_feather_reaches_from_the_base_to_the_tip() {
        for (name, feather) in species().filter(|(_, feather)| feather.shaft.length_mm < 40.0) {
            let along_mm = 0.6 * feather.shaft.length_mm;
            let grown = feather.grow(VaneDisc { along_mm, radius_mm: None }, Level::Barbules, 1, 1).unwrap();
            let [low, high] = grown.shaft.bounds().unwrap();
            let length = f64::from(high.y - low.y);
            assert!(
                length > 0.9 * feather.shaft.length_mm && length < 1.02 * feather.shaft.length_mm,
                "{name}"
            );
            assert!((f64::from(low.y) + along_mm).abs() < 0.05 * length, "{name}: {low}");
            let [left, right] = grown.rami.bounds().unwrap();
            let wide = f64::from(right.x - left.x) / (2.0 * feather.barbs.half_width_mm);
            assert!((0.85..1.15).contains(&wide), "{name}: {wide}");
            // The estimate by which too many are refused counts full barbs: the true number is near.
            let area = 2.0 * feather.barbs.half_area(feather.shaft.length_mm * (1.0 - feather.shaft.calamus));
            let per_mm = 1e3 / feather.distal.spacing_um + 1e3 / feather.proximal.spacing_um;
            let share = grown.counts().barbules as f64 / (area * 1e3 / feather.barbs.spacing_um * per_mm);
            assert!((0.7..1.2).contains(&share), "{name}: {share}");
        }
        let mut feather = feather("peafowl");
        feather.barbs.spacing_um = 100.0;
        let whole = VaneDisc { along_mm: 60.0, radius_mm: None };
        let message = feather.grow(whole, Level::Barbules, 1, 1).unwrap_err().to_string();
        assert!(message.contains("in place of window.whole"), "{message}");
    }

    #[test]
    fn impossible_parameters_are_refused() {
        let mut feather = feather("starling");
        feather.distal.spacing_um = 0.0;
        let message = feather.check().unwrap_err().to_string();
        assert_eq!(message, "feather.distal.spacing_um is 0, outside 1 to 10000");
        feather.distal.spacing_um = f64::NAN;
        assert!(feather.check().is_err());
        feather = self::feather("starling");
        feather.shaft.calamus = 1.0;
        assert!(feather.check().is_err());
        feather = self::feather("starling");
        let wide = VaneDisc { along_mm: 15.0, radius_mm: Some(500.0) };
        assert!(
            feather
                .grow(wide, Level::Barbules, 1, 1)
                .unwrap_err()
                .to_string()
                .contains("give a smaller radius_mm")
        );
    }
}
