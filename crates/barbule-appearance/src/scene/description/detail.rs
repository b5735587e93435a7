//! `detail`: how finely a feather is made, and how its barbs are seen; `window`: which part of it.

use crate::fields::{Fields, Key, Map, Record, Value, within};
use crate::identity::Hasher;
use crate::scene::feather::{Feather, Level, VaneDisc};
use crate::{Error, Result, record, words};

words! {
    /// Which parts of a feather stand there one by one.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum DetailLevel {
        /// As fine as the picture shows.
        #[default]
        "auto": Auto,
        /// Every barbule.
        "barbules": Barbules,
        /// Every barb; its barbules are stretches that repeat.
        "barbs": Barbs,
        /// The vane as a surface.
        "vane": Vane,
        /// Every barb's envelope, on which barbules are looked up.
        "envelopes": Envelopes,
    }
}

words! {
    /// How barbs are seen.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum ViewModel {
        /// As they grew, at the feather's level.
        #[default]
        "grown": Grown,
        /// As rami with barbules that are looked up on envelopes.
        "substructure": Substructure,
        /// As one fibre each.
        "fibre": Fibre,
        /// Both, side by side.
        "both": Both,
    }
}

record! {
    /// How finely a feather is made, and how its barbs are seen.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub struct Detail {
        /// Which parts of the feather are made one by one.
        level: DetailLevel = "level", (), or DetailLevel::Auto;
        /// How barbs are seen.
        view_model: ViewModel = "view_model", (), or ViewModel::Grown;
    }
}

/// The finest pixel that is thought of, as a share of a picture's width.
const PIXEL: f64 = 1e-3;

/// Pixels as wide as this share of the distance between barbules show none.
const RESOLVES: f64 = 0.7;

/// Pixels as wide as this many barbs show a surface.
const BARBS: f64 = 3.0;

/// More barbules than this repeat.
const MOST_GROWN: f64 = 1.5e6;

impl Detail {
    /// How finely a feather is made: as is said here, or as fine as a picture of a thousand pixels shows that is so wide on the feather,
    /// mm.
    #[must_use]
    pub fn level_of(&self, feather: &Feather, window: VaneDisc, width_mm: f64) -> Level {
        match self.level {
            _ if self.view_model != ViewModel::Grown => Level::Envelopes,
            DetailLevel::Barbules => Level::Barbules,
            DetailLevel::Barbs => Level::Barbs,
            // Barbs that stand apart are no surface.
            DetailLevel::Vane if feather.eye.is_there() => Level::Barbs,
            DetailLevel::Vane => Level::Vane,
            DetailLevel::Envelopes => Level::Envelopes,
            DetailLevel::Auto => {
                let finest = feather.distal.spacing_um.min(feather.proximal.spacing_um);
                let is_resolved = PIXEL * width_mm < RESOLVES * 1e-3 * finest;
                let many = feather.barbules_in(window) > MOST_GROWN;
                let shows_barbs = PIXEL * width_mm < 1e-3 * BARBS * feather.barbs.spacing_um;
                match (is_resolved && !many, shows_barbs || feather.eye.is_there()) {
                    (true, _) => Level::Barbules,
                    (false, true) => Level::Barbs,
                    (false, false) => Level::Vane,
                }
            }
        }
    }
}

record! {
    /// The table `[window]`.
    #[derive(Debug, Clone, PartialEq)]
    struct WindowKeys {
        /// Its middle on the shaft, from the shaft's base: the feather's origin.
        along_mm: f64 = "along_mm", within(0, 2000), or 0.0;
        /// Its radius in the vane's plane.
        radius_mm: Option<f64> = "radius_mm", within(0.01, 500);
        /// Whether it is the whole feather, as it is where no radius is given.
        whole: Option<bool> = "whole", ();
    }
}

impl VaneDisc {
    /// The whole feather about its shaft's base.
    pub const WHOLE: Self = Self { along_mm: 0.0, radius_mm: None };

    fn keys_of(&self) -> WindowKeys {
        let whole = self.radius_mm.is_none().then_some(true);
        WindowKeys { along_mm: self.along_mm, radius_mm: self.radius_mm, whole }
    }
}

impl Record for VaneDisc {
    fn keys() -> Vec<Key> {
        WindowKeys::keys()
    }

    fn read_fields(fields: &Fields<'_>) -> Result<Self> {
        let WindowKeys { along_mm, radius_mm, whole } = WindowKeys::read_fields(fields)?;
        match (whole, radius_mm) {
            (Some(true), Some(_)) => Err(Error::input(format!(
                "{} and {} are both given; leave one out",
                fields.path("whole"),
                fields.path("radius_mm")
            ))),
            (Some(false), None) => Err(Error::input(format!(
                "{} is missing; give a number from 0.01 to 500",
                fields.path("radius_mm")
            ))),
            (_, radius_mm) => Ok(Self { along_mm, radius_mm }),
        }
    }

    fn check_given(fields: &Fields<'_>) -> Result<()> {
        WindowKeys::check_given(fields)
    }

    fn write_into(&self, table: &mut Map<String, Value>) {
        self.keys_of().write_into(table);
    }

    fn check(&self, place: &str) -> Result<()> {
        Record::check(&self.keys_of(), place)
    }

    fn feed_fields(&self, to: &mut Hasher) {
        self.keys_of().feed_fields(to);
    }
}
