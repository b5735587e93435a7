//! A photonic crystal under the top of a section.

use super::lattice::Lattice;
use super::section::{Medium, Parts, Polyline, profile, refuse};
use crate::Result;

/// No top has more rods under it.
const MOST_RODS_UNDER_TOP: f64 = 200_000.0;

/// Rows of rods that follow the top: at arc length s from x = 0 the crystal looks like the flat one at x = s − offset.
#[derive(Debug, Clone, PartialEq)]
pub struct CrystalLayer {
    /// The crystal under a flat top.
    pub lattice: Lattice,
    /// Where along the top, from x = 0, the lattice has its x = 0.
    pub offset_um: f64,
    /// How much of the reflected field a place gives, 0 to 1; `None`: all of it everywhere.
    pub regularity: Option<Regularity>,
}

/// A function of x: linear between its points, constant beyond the ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Regularity {
    /// Positions, increasing strictly.
    pub x_um: Vec<f64>,
    /// Values at them, 0 to 1.
    pub value: Vec<f64>,
}

/// A circle of a rod under a top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BuriedCircle {
    /// Centre across the barbule.
    pub x_um: f64,
    /// Centre's height.
    pub z_um: f64,
    /// Radius.
    pub radius_um: f64,
    /// Row, from 0.
    pub row: usize,
    /// Which rod of [`Lattice::rods`].
    pub rod: usize,
    /// Which circle of it.
    pub circle: usize,
}

impl Regularity {
    /// The value at `x_um`.
    #[must_use]
    pub fn at(&self, x_um: f64) -> f64 {
        profile(&self.x_um, &self.value, x_um)
    }
}

impl CrystalLayer {
    /// Every circle of every rod that hangs on the top, a rod's outermost first.
    ///
    /// Axes lie at their depth along the normal of the top where the lattice has them.
    #[must_use]
    pub fn circles(&self, top: &Polyline) -> Vec<BuriedCircle> {
        let arc = top.arc_um();
        let origin = top.arc_at_zero(&arc) + self.offset_um;
        let total = arc[arc.len() - 1];
        let period = self.lattice.period_um;
        let mut circles = Vec::new();
        for placed in self.lattice.placed() {
            let first = ((-origin - placed.x_um) / period).ceil();
            let mut s = origin + placed.x_um + first * period;
            while s <= total {
                let right = arc.partition_point(|&a| a <= s).clamp(1, arc.len() - 1);
                let length = arc[right] - arc[right - 1];
                let (dx, dz) = (top.x_um[right] - top.x_um[right - 1], top.z_um[right] - top.z_um[right - 1]);
                let t = (s - arc[right - 1]) / length;
                let x_um = top.x_um[right - 1] + t * dx + placed.depth_um * dz / length;
                let z_um = top.z_um[right - 1] + t * dz - placed.depth_um * dx / length;
                let shells = self.lattice.rods[placed.rod].circles.iter().enumerate();
                circles.extend(shells.map(|(circle, c)| BuriedCircle {
                    x_um,
                    z_um,
                    radius_um: 0.5 * c.diameter_um,
                    row: placed.row,
                    rod: placed.rod,
                    circle,
                }));
                s += period;
            }
        }
        circles
    }
}

impl Polyline {
    /// Arc length from the left end at each point.
    #[must_use]
    pub fn arc_um(&self) -> Vec<f64> {
        let mut sum = 0.0;
        let steps = self.x_um.windows(2).zip(self.z_um.windows(2));
        std::iter::once(0.0)
            .chain(steps.map(|(x, z)| {
                sum += libm::hypot(x[1] - x[0], z[1] - z[0]);
                sum
            }))
            .collect()
    }

    /// Arc length from the left end to x = 0, with [`Self::arc_um`] given; beyond the ends the end segments go on.
    #[must_use]
    pub fn arc_at_zero(&self, arc_um: &[f64]) -> f64 {
        let right = self.x_um.partition_point(|&x| x <= 0.0).clamp(1, self.x_um.len() - 1);
        let (x0, x1) = (self.x_um[right - 1], self.x_um[right]);
        arc_um[right - 1] - (arc_um[right] - arc_um[right - 1]) * x0 / (x1 - x0)
    }
}

/// Refuses a crystal that does not go with the rest of the section.
pub(super) fn check(parts: &Parts) -> Result<()> {
    let Some(crystal) = &parts.crystal else { return Ok(()) };
    crystal.lattice.check()?;
    if let Some(top) = parts.boundaries.first() {
        let length_um: f64 = top
            .x_um
            .windows(2)
            .zip(top.z_um.windows(2))
            .map(|(x, z)| libm::hypot(x[1] - x[0], z[1] - z[0]))
            .sum();
        let rods = length_um / crystal.lattice.period_um * crystal.lattice.placed().count() as f64;
        if rods > MOST_RODS_UNDER_TOP {
            return refuse(format!(
                "lattice: {rods:.0} rods lie under a top of {length_um:.0} µm with a period of {} µm, over {MOST_RODS_UNDER_TOP}; \
                 give a longer period, fewer rows or a narrower section",
                crystal.lattice.period_um
            ));
        }
    }
    if parts.boundaries.len() != 1 || !parts.inclusions.is_empty() {
        return refuse(format!(
            "lattice: a section with a lattice has the top as its only boundary and no inclusions, but this one has {} boundaries and {} inclusions",
            parts.boundaries.len(),
            parts.inclusions.len()
        ));
    }
    let (above, below) = (&crystal.lattice.incidence, &crystal.lattice.host);
    if parts.media != [Medium::Pure(above.clone()), Medium::Pure(below.clone())] {
        return refuse(format!(
            "media must be the lattice's own, [{}, {}]; leave media out",
            above.label(),
            below.label()
        ));
    }
    if !crystal.offset_um.is_finite() {
        return refuse("lattice.offset must be a finite number".into());
    }
    let Some(Regularity { x_um, value }) = &crystal.regularity else { return Ok(()) };
    let place = "lattice.regularity";
    if x_um.is_empty() || x_um.len() != value.len() {
        return refuse(format!(
            "{place} has {} x but {} values; give as many of both, at least one",
            x_um.len(),
            value.len()
        ));
    }
    if let Some(at) = x_um.iter().position(|x| !x.is_finite()) {
        return refuse(format!("{place}.x[{at}] is not a finite number; give a finite one"));
    }
    if let Some(at) = x_um.windows(2).position(|x| x[0] >= x[1]) {
        return refuse(format!("{place}.x[{}] is not larger than the one before; sort by x", at + 1));
    }
    if let Some(at) = value.iter().position(|v| !(0.0..=1.0).contains(v)) {
        return refuse(format!("{place}.value[{at}] is {}, outside 0 to 1", value[at]));
    }
    Ok(())
}
