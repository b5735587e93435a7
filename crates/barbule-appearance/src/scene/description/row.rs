//! Rows: feathers side by side, as tails and folded wings have them.

use glam::DVec3;

use super::detail::{Detail, ViewModel};
use super::dress::{Dress, FeatherObject, Zone};
use super::objects::{MOST_ZONES, Placement};
use super::slot::Slot;
use crate::bsdf::Texture;
use crate::fields::{Several, Text, path_of, up_to, within};
use crate::math::rng::hash;
use crate::progress::Progress;
use crate::scene::Object;
use crate::scene::coat::window;
use crate::scene::feather::{Counts, Feather};
use crate::scene::geometry::Place;
use crate::scene::memory::PER_PLACE;
use crate::scene::rows::{
    FeatherRow, LaidRow, MOST_FEATHERS, MOST_STATIONS, Over, RowVariant, Station, seed_of,
};
use crate::{Error, Result, record};

/// Most variants of a kind, and most kinds beside the first.
const MOST_VARIANTS: u8 = 64;
const MOST_KINDS: usize = 31;

/// Identity of the feathers' places.
const ROW: u64 = 0x0072_6f77;

/// Objects that a feather has, at most, beside those of its zones.
const PARTS: usize = 7;

/// Most feathers in all places of the object.
const MOST_PLACES: usize = 1_000_000;

/// Lengths of directions below which they point nowhere.
const LEAST_LENGTH: f64 = 1e-6;

/// A row of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct RowObject {
    /// How its feathers stand, and its further kinds.
    pub row: RowDescription,
    /// The feather of kind 0.
    pub first: RowFeather,
    /// How finely they are made.
    pub detail: Detail,
}

record! {
    /// How the feathers of a row stand.
    #[derive(Debug, Clone, PartialEq)]
    pub struct RowDescription {
        /// How many there are; twice as many with `mirror`.
        count: usize = "count", within(1, MOST_FEATHERS as f64);
        /// What the row is like from its first feather to its last; stations share it evenly.
        stations: Vec<StationDescription> = "stations", Several { least: 1, most: MOST_STATIONS, of: () };
        /// Which end lies on top: each feather lies over the next one, or over the one before.
        over: Over = "over", (), or Over::First;
        /// How far a feather lies under its neighbour, along its normal.
        clearance_mm: f64 = "clearance_mm", within(0, 20), or 0.2;
        /// By how much feathers are rolled about their length, so that an edge lies over the feather beneath and the other under that above.
        roll_deg: f64 = "roll_deg", within(0, 45), or 4.0;
        /// Whether its mirror image in the plane x = 0 stands beside it: the other wing, or the other half of a tail.
        mirror: bool = "mirror", (), or false;
        /// Standard deviation of their turn in the plane of their vanes.
        turn_jitter_deg: f64 = "turn_jitter_deg", within(0, 30), or 0.5;
        /// Standard deviation of their size, as a share.
        size_jitter: f64 = "size_jitter", within(0, 0.3), or 0.01;
        /// How many are grown of each kind at most, each for a part of the row.
        variants: usize = "variants", within(1, MOST_VARIANTS), or 4;
        /// Further kinds of feathers, from 1; the object's own is kind 0.
        feathers: Vec<RowFeather> = "feathers", up_to(MOST_KINDS), or Vec::new();
        @agree RowDescription::agree;
    }
}

record! {
    /// What a row is like at one place.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct StationDescription {
        /// Where the shaft leaves the skin.
        position_mm: [f64; 3] = "position_mm", within(-1e5, 1e5);
        /// From there to the feather's tip; of any length.
        direction: [f64; 3] = "direction", within(-1e6, 1e6);
        /// Out of the upper side of its vane; of any length.
        normal: [f64; 3] = "normal", within(-1e6, 1e6), or [0.0, 0.0, 1.0];
        /// Factor to the feather's size.
        scale: f64 = "scale", within(0.05, 20), or 1.0;
        /// Factors to the widths of its leading and its trailing vane, beyond that.
        widths: [f64; 2] = "widths", within(0.05, 20), or [1.0, 1.0];
        /// Which kind of feather stands nearest to it.
        kind: usize = "kind", within(0, MOST_KINDS as f64), or 0;
        @agree StationDescription::agree;
    }
}

record! {
    /// A kind of feather of a row.
    #[derive(Debug, Clone, PartialEq)]
    pub struct RowFeather {
        /// Its sizes, or the name of a type.
        feather: Feather = "feather", ();
        /// What its parts are made of.
        dress: Dress = "dress", ();
        /// Places of its vane with a dress of their own.
        zones: Vec<Zone> = "zones", up_to(MOST_ZONES), or Vec::new();
        /// A grey picture over the vane: pixels of value i (of 255) are the i-th zone.
        zone_map: Option<Slot<Texture>> = "zone_map", Text("a grey .png");
        /// A picture of its vane that its fibres take their colours from.
        albedo: Option<Slot<Texture>> = "albedo", Text("the name of a .png, .exr or .hdr");
        @agree RowFeather::agree;
    }
}

impl StationDescription {
    fn agree(&self, place: &str) -> Result<()> {
        let [direction, normal] = [self.direction, self.normal].map(DVec3::from);
        for (key, what, along) in [("direction", "feathers", direction), ("normal", "vanes", normal)] {
            if along.length() < LEAST_LENGTH {
                return Err(Error::input(format!(
                    "{} has no length; give where {what} point",
                    path_of(place, key)
                )));
            }
        }
        if direction.normalize().cross(normal.normalize()).length() < 1e-3 {
            return Err(Error::input(format!(
                "{} is along direction; give where the upper side of the vane looks",
                path_of(place, "normal")
            )));
        }
        Ok(())
    }

    fn station(&self) -> Station {
        let Self { position_mm, direction, normal, scale, widths, kind } = *self;
        let [position_mm, direction, normal] = [position_mm, direction, normal].map(DVec3::from);
        Station { position_mm, direction, normal, scale, widths, kind }
    }
}

impl RowFeather {
    fn agree(&self, place: &str) -> Result<()> {
        self.one(self.feather, Detail::default()).agree(place)
    }

    /// One of these feathers, with sizes of its own.
    fn one(&self, feather: Feather, detail: Detail) -> FeatherObject {
        let Self { dress, zones, zone_map, albedo, .. } = self.clone();
        FeatherObject { feather, window: window(&feather), detail, dress, zones, zone_map, albedo }
    }
}

impl RowDescription {
    fn agree(&self, place: &str) -> Result<()> {
        let kinds = 1 + self.feathers.len();
        match self.stations.iter().enumerate().find(|(_, station)| station.kind >= kinds) {
            Some((i, station)) => Err(Error::input(format!(
                "{}[{i}].kind is {}, but the row has {kinds} kinds of feathers, from 0",
                path_of(place, "stations"),
                station.kind
            ))),
            None => Ok(()),
        }
    }

    fn row(&self) -> FeatherRow {
        FeatherRow {
            count: self.count,
            stations: self.stations.iter().map(StationDescription::station).collect(),
            over: self.over,
            clearance_mm: self.clearance_mm,
            roll: self.roll_deg.to_radians(),
            mirror: self.mirror,
            turn_jitter: self.turn_jitter_deg.to_radians(),
            size_jitter: self.size_jitter,
            variants: self.variants,
        }
    }
}

impl RowObject {
    /// Refuses a row of what stands nowhere twice.
    pub(super) fn agree(&self, place: &str) -> Result<()> {
        if self.detail.view_model == ViewModel::Both {
            return Err(Error::input(format!(
                "{} is both, but a row has no second row beside it; give substructure or fibre",
                path_of(place, "detail.view_model")
            )));
        }
        self.first.agree(place)
    }

    fn kinds(&self) -> impl Iterator<Item = &RowFeather> {
        std::iter::once(&self.first).chain(&self.row.feathers)
    }

    /// The row with every feather in its place.
    #[must_use]
    pub fn laid(&self, seed: u64) -> LaidRow {
        let feathers: Vec<Feather> = self.kinds().map(|kind| kind.feather).collect();
        self.row.row().lay(&feathers, seed)
    }

    /// The parts of each variant at their places, in each place of the object.
    pub(super) fn parts(
        &self,
        places: &[Placement],
        width_mm: f64,
        (seed, index): (u64, u64),
        progress: &dyn Progress,
    ) -> Result<(Vec<Object>, Counts)> {
        let many = self.row.count * if self.row.mirror { 2 } else { 1 } * places.len();
        if many > MOST_PLACES {
            return Err(Error::input(format!(
                "a row makes {many} feathers, over the limit of {MOST_PLACES}; give a lower count or fewer instances"
            )));
        }
        let laid = self.laid(seed);
        let kinds: Vec<&RowFeather> = self.kinds().collect();
        let (mut objects, mut counts) = (Vec::new(), Counts::default());
        for (variant, RowVariant { kind, feather }) in laid.variants.iter().enumerate() {
            let stands: Vec<_> =
                laid.stands.iter().enumerate().filter(|(_, stand)| stand.variant == variant).collect();
            let mut one = kinds[*kind].one(*feather, self.detail);
            if stands.first().is_some_and(|(_, stand)| stand.is_mirrored) {
                one = one.with_zones_mirrored()?;
            }
            let (parts, own) = one.parts(width_mm, seed_of(variant, seed), progress)?;
            let outer =
                places.iter().enumerate().map(|(at, place)| place.place(hash(ROW, &[index, at as u64])));
            let all: Vec<Place> = outer
                .flat_map(|outer| {
                    stands.iter().map(move |(number, stand)| {
                        stand.place(feather, hash(ROW, &[*number as u64])).then(&outer)
                    })
                })
                .collect();
            counts.barbs += own.barbs * all.len();
            counts.barbules += own.barbules * all.len();
            let placed = |part: Object| Object { geometry: part.geometry.placed_at(&all), ..part };
            objects.extend(parts.into_iter().map(placed));
        }
        Ok((objects, counts))
    }

    /// Memory that it takes in so many places while its hierarchy is built, bytes, at most.
    pub(super) fn bytes(&self, places: usize, width_mm: f64) -> f64 {
        let laid = self.laid(0);
        let kinds: Vec<&RowFeather> = self.kinds().collect();
        let grown = laid.variants.iter().enumerate().map(|(variant, RowVariant { kind, feather })| {
            let one = kinds[*kind].one(*feather, self.detail);
            let many = laid.stands.iter().filter(|stand| stand.variant == variant).count() * places;
            let parts = (PARTS + 3 * one.zone_count()) as f64 + one.places(width_mm);
            one.bytes(width_mm) + many as f64 * parts * PER_PLACE
        });
        grown.sum()
    }

    /// Names of its parts, in their order.
    pub(super) fn part_names(&self, width_mm: f64) -> Vec<String> {
        let kinds: Vec<&RowFeather> = self.kinds().collect();
        let of =
            |variant: &RowVariant| kinds[variant.kind].one(variant.feather, self.detail).part_names(width_mm);
        self.laid(0).variants.iter().flat_map(of).collect()
    }
}

#[cfg(test)]
mod tests;
