//! Feathers grown from parameters: a shaft, barbs on both sides, barbules on both sides of every barb.
//!
//! Parameters follow the biological description of Streit & Heidrich 2002 and Chen et al. 2002; presets and species
//! give their sizes in files. Every draw is named by its place (barb, side, barbule), so one barbule never depends on another.

mod barb;
mod barbule;
mod loose;
mod measure;
mod noise;
mod outline;
mod row;
mod section;
mod shaft;
mod sizes;
mod split;
mod tables;
mod types;

use glam::DVec3;

pub use barb::Barb;
pub use measure::{Measures, VaneMeasures};
pub use outline::Vane;
pub use shaft::{Shaft, Station};
pub use sizes::{BarbShape, BarbuleShape, Disorder, DownyShape, ShaftShape, SplitShape};
pub(in crate::scene) use tables::layered;
pub use tables::{Feather, LeadingSide};
pub use types::{names, source};

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
    /// The barbules.
    pub barbules: Geometry,
}

impl Grown {
    /// How many barbs and barbules there are.
    #[must_use]
    pub fn counts(&self) -> Counts {
        Counts { barbs: self.rami.meshes.len(), barbules: self.barbules.ribbons.len() }
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
    pub fn grow(&self, window: VaneDisc, seed: u64, identity: u64) -> Result<Grown> {
        self.check()?;
        self.check_count(window)?;
        let (mut grown, barbs, origin) = self.rami(window, seed, identity)?;
        for barb in &barbs {
            for (which, shape) in self.barbules_of(barb).iter().enumerate() {
                let place = (origin, window);
                barbule::along(&mut grown.barbules, barb, shape, &self.disorder, which, place, seed);
            }
        }
        Ok(grown)
    }

    /// The same without barbules: a feather as it looks from afar.
    ///
    /// # Errors
    /// As [`Feather::check`].
    pub fn grow_barbs(&self, window: VaneDisc, seed: u64, identity: u64) -> Result<Grown> {
        self.rami(window, seed, identity).map(|(grown, ..)| grown)
    }

    /// Shaft and rami, the barbs that they are made of, and the origin in the feather's own place.
    fn rami(&self, window: VaneDisc, seed: u64, identity: u64) -> Result<(Grown, Vec<Barb>, DVec3)> {
        let (shaft, barbs) = self.barbs_within(window, seed, identity)?;
        let origin = shaft.at(window.along_mm).point;
        let mut grown = Grown::default();
        shaft.mesh(&mut grown.shaft, window, origin, identity);
        for barb in &barbs {
            barb.mesh(&mut grown.rami, &self.barbs, origin);
            barb.fibre(&mut grown.fibres, origin);
        }
        Ok((grown, barbs, origin))
    }

    /// The shaft and the barbs that reach into a window, in the feather's own place: the shaft's base is the origin.
    ///
    /// # Errors
    /// As [`Feather::check`].
    pub fn barbs_within(&self, window: VaneDisc, seed: u64, identity: u64) -> Result<(Shaft, Vec<Barb>)> {
        self.check()?;
        let shaft = Shaft::new(&self.shaft);
        let origin = shaft.at(window.along_mm).point;
        let mut barbs = Vec::new();
        for side in [-1.0, 1.0] {
            let row = barb::along(self, &shaft, side, window, seed, identity);
            barbs.extend(row.into_iter().filter(|barb| barb.is_within(origin, window)));
        }
        Ok((shaft, barbs))
    }

    /// The distal and the proximal barbules of a barb.
    #[must_use]
    pub fn barbules_of(&self, barb: &Barb) -> [BarbuleShape; 2] {
        if barb.is_loose { [self.downy.barbules(); 2] } else { [self.distal, self.proximal] }
    }
}

impl Feather {
    /// Refuses a window that would hold more barbules than fit into memory: those on barbs that fill its area at
    /// their spacing.
    fn check_count(&self, window: VaneDisc) -> Result<()> {
        let area = window.radius_mm.map_or(self.vane_area(), |radius| std::f64::consts::PI * radius * radius);
        let downy = if self.downy.share > 0.0 { 2e3 / self.downy.spacing_um } else { 0.0 };
        let per_mm = (1e3 / self.distal.spacing_um + 1e3 / self.proximal.spacing_um).max(downy);
        let barbules = area * 1e3 / self.barbs.spacing_um * per_mm;
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
}

impl VaneDisc {
    fn holds(&self, point: DVec3) -> bool {
        self.radius_mm.is_none_or(|radius| point.x * point.x + point.y * point.y <= radius * radius)
    }
}

#[cfg(test)]
mod tests;
