//! Feathers grown from parameters: a shaft, barbs on both sides, barbules on both sides of every barb.
//!
//! Parameters follow the biological description of Streit & Heidrich 2002 and Chen et al. 2002; presets and species
//! give their sizes in files. Every draw is named by its place (barb, side, barbule), so one barbule never depends on another.

mod barb;
mod barbule;
mod envelope;
mod eye;
mod flat;
mod grown;
mod loose;
mod measure;
mod memory;
mod noise;
mod outline;
mod row;
mod section;
mod shaft;
mod sheet;
mod sizes;
mod split;
mod stretch;
mod swatch;
mod tables;
mod types;

use glam::DVec3;

pub use barb::Barb;
pub use envelope::tip_side;
pub use grown::{Counts, Grown, ZoneParts};
pub use measure::{Measures, VaneMeasures};
pub use memory::Census;
pub use outline::Vane;
pub use shaft::{Shaft, Station};
pub use sheet::SheetBarbs;
pub use sizes::{
    BarbShape, BarbuleShape, Disorder, DownyShape, EyeShape, PatternShape, ShaftShape, SplitShape,
};
pub use swatch::Swatch;
pub(in crate::scene) use tables::layered;
pub use tables::{Feather, LeadingSide};
pub use types::{names, source};

use self::stretch::Stretches;
use crate::bsdf::{Markings, Zones};
use crate::progress::{Progress, Unobserved};
use crate::scene::go_on;
use crate::{Error, Result};

/// The part of a feather to grow: a disc in the plane of the vane about a point of the shaft, or all of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VaneDisc {
    /// Arc length of its middle on the shaft, mm: the origin.
    pub along_mm: f64,
    /// Its radius, mm; the whole feather where there is none.
    pub radius_mm: Option<f64>,
}

/// Which parts of a feather stand there one by one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Every barbule.
    Barbules,
    /// Every barb; its barbules are stretches that repeat.
    Barbs,
    /// The vane, a surface that shows a swatch of barbs and barbules; of the downy part every envelope.
    Vane,
    /// Every barb's envelope, on which barbules are looked up (Baron et al. 2021).
    Envelopes,
}

/// More barbules than this are not grown: each takes about a kilobyte.
const MOST_BARBULES: f64 = 4e6;

/// Sorts of rows: whether their barbs are loose, on which side of the shaft, on which side of the barb.
const SORTS: [(bool, f64, usize); 8] = [
    (false, -1.0, 0),
    (false, -1.0, 1),
    (false, 1.0, 0),
    (false, 1.0, 1),
    (true, -1.0, 0),
    (true, -1.0, 1),
    (true, 1.0, 0),
    (true, 1.0, 1),
];

/// More places of stretches are not made: each takes a quarter of a kilobyte.
const MOST_PLACES: f64 = 1e7;

impl Feather {
    /// Grows the part of the feather within a window, moved so that the window's middle is the origin. `seed` and
    /// `identity` name every random draw. Rami and barbules that stand there one by one come apart by `zones`.
    ///
    /// # Errors
    /// As [`Feather::check`]; a window that would hold more than 4 million barbules, or 10 million stretches of them.
    pub fn grow(
        &self,
        window: VaneDisc,
        level: Level,
        zones: Option<&Zones>,
        seed: u64,
        identity: u64,
    ) -> Result<Grown> {
        self.grow_watched(window, level, zones, (seed, identity), &Unobserved)
    }

    /// The same for who may stop it.
    ///
    /// # Errors
    /// As [`Feather::grow`], or a stop by `progress`.
    pub fn grow_watched(
        &self,
        window: VaneDisc,
        level: Level,
        zones: Option<&Zones>,
        (seed, identity): (u64, u64),
        progress: &dyn Progress,
    ) -> Result<Grown> {
        self.check()?;
        match level {
            Level::Barbules => self.check_count(window)?,
            Level::Barbs => self.check_places(window)?,
            Level::Vane | Level::Envelopes => {}
        }
        let (shaft, barbs) = self.barbs_within(window, (seed, identity), progress)?;
        let origin = shaft.at(window.along_mm).point;
        let markings = self.markings(zones);
        let mut grown = Grown::new(markings.zones());
        shaft.mesh(&mut grown.shaft, window, origin, identity);
        let (loose, closed): (Vec<&Barb>, Vec<&Barb>) =
            barbs.iter().partition(|barb| barb.is_loose && level == Level::Vane);
        match level {
            Level::Barbules => {
                self.add_rami(&mut grown, &closed, &markings, origin, progress)?;
                self.add_barbules(&mut grown, &closed, &markings, (origin, window), seed, progress)?;
            }
            Level::Barbs => {
                self.add_rami(&mut grown, &closed, &markings, origin, progress)?;
                self.add_stretches(&mut grown, &closed, &markings, (origin, window), seed, progress)?;
            }
            Level::Envelopes => self.add_envelopes(&mut grown, &closed, origin, progress)?,
            Level::Vane => {
                for (k, side) in [-1.0, 1.0].into_iter().enumerate() {
                    let barbs = closed.iter().copied().filter(|b| b.side == side);
                    grown.sheet_barbs[k] = sheet::add(&mut grown.sheets[k], barbs, origin, identity);
                }
            }
        }
        self.add_envelopes(&mut grown, &loose, origin, progress)?;
        Ok(grown)
    }

    /// Shaft and barbs alone, these as round fibres.
    ///
    /// # Errors
    /// As [`Feather::check`], or a stop by `progress`.
    pub fn grow_barbs(
        &self,
        window: VaneDisc,
        seed: u64,
        identity: u64,
        progress: &dyn Progress,
    ) -> Result<Grown> {
        let (shaft, barbs) = self.barbs_within(window, (seed, identity), progress)?;
        let origin = shaft.at(window.along_mm).point;
        let mut grown = Grown::default();
        shaft.mesh(&mut grown.shaft, window, origin, identity);
        for barb in &barbs {
            go_on(progress)?;
            barb.fibre(&mut grown.barbs, origin);
        }
        Ok(grown)
    }

    fn add_rami(
        &self,
        grown: &mut Grown,
        barbs: &[&Barb],
        markings: &Markings,
        origin: DVec3,
        progress: &dyn Progress,
    ) -> Result<()> {
        for barb in barbs {
            go_on(progress)?;
            barb.fibre(&mut grown.barbs, origin);
            if barb.is_loose {
                barb.fibre(&mut grown.downy, origin);
            } else {
                let marks = barb.marks(markings);
                barb.meshes(grown, &self.barbs, &marks, origin);
                barb.parted(grown, &marks, origin);
            }
        }
        Ok(())
    }

    fn add_barbules(
        &self,
        grown: &mut Grown,
        barbs: &[&Barb],
        markings: &Markings,
        place: (DVec3, VaneDisc),
        seed: u64,
        progress: &dyn Progress,
    ) -> Result<()> {
        let roll = envelope::roll(1e-3 * self.barbs.spacing_um);
        for barb in barbs {
            go_on(progress)?;
            for (which, shape) in self.barbules_of(barb).iter().enumerate() {
                let row = shape.row(&self.disorder);
                barbule::along(grown, barb, &row, which, (roll, markings), place, seed);
            }
        }
        Ok(())
    }

    fn add_stretches(
        &self,
        grown: &mut Grown,
        barbs: &[&Barb],
        markings: &Markings,
        place: (DVec3, VaneDisc),
        seed: u64,
        progress: &dyn Progress,
    ) -> Result<()> {
        let roll = envelope::roll(1e-3 * self.barbs.spacing_um);
        for (is_loose, side, which) in SORTS {
            let of_sort = || barbs.iter().filter(|barb| barb.is_loose == is_loose && barb.side == side);
            let Some(first) = of_sort().next() else { continue };
            let row = self.barbules_of(first)[which].row(&self.disorder);
            let mut stretches = Stretches::new(row, side, which, roll, seed);
            for barb in of_sort() {
                go_on(progress)?;
                stretches.along(barb, markings, place);
            }
            for (mark, stretch) in stretches.placed() {
                grown.barbules_at(is_loose, which, mark).repeated.push(stretch);
            }
        }
        Ok(())
    }

    fn add_envelopes(
        &self,
        grown: &mut Grown,
        barbs: &[&Barb],
        origin: DVec3,
        progress: &dyn Progress,
    ) -> Result<()> {
        let roll = envelope::roll(1e-3 * self.barbs.spacing_um);
        for barb in barbs {
            go_on(progress)?;
            let rows = self.barbules_of(barb).map(|shape| shape.row(&self.disorder));
            let envelopes = if barb.is_loose { &mut grown.downy_envelopes } else { &mut grown.envelopes };
            envelope::add(&mut envelopes[usize::from(barb.side > 0.0)], barb, &rows, roll, origin);
        }
        Ok(())
    }

    /// What differs from place to place of its vanes.
    #[must_use]
    pub fn markings(&self, zones: Option<&Zones>) -> Markings {
        Markings { pattern: self.pattern.pattern(), zones: zones.cloned() }
    }

    /// The shaft and the barbs that reach into a window, in the feather's own place: the shaft's base is the origin.
    ///
    /// # Errors
    /// As [`Feather::check`], or a stop by `progress`.
    pub fn barbs_within(
        &self,
        window: VaneDisc,
        (seed, identity): (u64, u64),
        progress: &dyn Progress,
    ) -> Result<(Shaft, Vec<Barb>)> {
        self.check()?;
        let shaft = Shaft::new(&self.shaft);
        let origin = shaft.at(window.along_mm).point;
        let mut barbs = Vec::new();
        for side in [-1.0, 1.0] {
            let row = barb::along(self, &shaft, side, window, (seed, identity), progress)?;
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

    /// Refuses a window with more places of stretches than fit into memory.
    fn check_places(&self, window: VaneDisc) -> Result<()> {
        let places = 2.0 * self.barbs_mm_in(window) / stretch::LENGTH_MM;
        if places <= MOST_PLACES {
            return Ok(());
        }
        Err(Error::input(format!(
            "the feather may hold {places:.0} stretches of barbules, over the limit of {MOST_PLACES:.0}; give a smaller window.radius_mm or detail.level = \"vane\""
        )))
    }

    /// About how long all barbs in a window are, mm: those that fill its area at their spacing.
    fn barbs_mm_in(&self, window: VaneDisc) -> f64 {
        if self.eye.is_there() {
            return self.census(window).barbs_mm.iter().sum();
        }
        let disc = window.radius_mm.map_or(f64::INFINITY, |radius| std::f64::consts::PI * radius * radius);
        self.vane_area().min(disc) * 1e3 / self.barbs.spacing_um
    }

    /// About how many barbules a window holds.
    #[must_use]
    pub fn barbules_in(&self, window: VaneDisc) -> f64 {
        let downy = if self.downy.share > 0.0 { 2e3 / self.downy.spacing_um } else { 0.0 };
        let per_mm = (1e3 / self.distal.spacing_um + 1e3 / self.proximal.spacing_um).max(downy);
        self.barbs_mm_in(window) * per_mm
    }
}

impl VaneDisc {
    fn holds(&self, point: DVec3) -> bool {
        self.radius_mm.is_none_or(|radius| point.x * point.x + point.y * point.y <= radius * radius)
    }
}

/// 0 before 0, 1 after 1, a cubic between.
fn smoothstep(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests;
