//! Markings of a feather: where its vanes lack pigment, and where they wear another dress.

use super::{Pattern, Substance, Zones};
use crate::{Error, Result};

/// What marks a place of a vane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Mark {
    /// A zone; zone 0 is the feather's own dress.
    Zone(usize),
    /// No pigment, whichever zone it is.
    Pale,
}

impl Mark {
    /// The zone whose substances are there: what is pale is the feather's own without pigment.
    #[inline]
    #[must_use]
    pub fn zone(self) -> usize {
        match self {
            Self::Zone(zone) => zone,
            Self::Pale => 0,
        }
    }
}

/// What differs from place to place of a feather's vanes; nothing, if it has neither. Down has none.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Markings {
    /// Where there is pigment.
    pub pattern: Option<Pattern>,
    /// Where there is another dress.
    pub zones: Option<Zones>,
}

/// What a zone wears where it differs from the feather's own.
#[derive(Debug, Clone, Default)]
pub struct ZoneDress {
    /// The rami.
    pub ramus: Option<Substance>,
    /// The barbules towards the feather's tip, and the others.
    pub barbules: [Option<Substance>; 2],
}

impl Markings {
    /// What marks a barbule or a piece of ramus of this name, on a barb left (−1) or right (1) of the shaft that leaves it at
    /// `station`, and `arc` along it, mm.
    #[inline]
    #[must_use]
    pub fn at(&self, side: f64, station: f64, arc: f64, name: u64) -> Mark {
        match &self.pattern {
            Some(pattern) if !pattern.is_dark(station, arc, name) => Mark::Pale,
            _ => Mark::Zone(self.zones.as_ref().map_or(0, |zones| zones.at(side, station, arc, name))),
        }
    }

    /// How many zones there are beside the feather's own.
    #[must_use]
    pub fn zones(&self) -> usize {
        self.zones.as_ref().map_or(0, Zones::count)
    }

    /// Refuses dresses that its zones cannot wear: each zone needs one, of the kinds of substances that the feather itself is made of
    /// (ramus, barbules towards its tip, the others), since those decide the shapes.
    ///
    /// # Errors
    /// The first such dress.
    pub fn check(&self, dresses: &[ZoneDress], own: [&Substance; 3]) -> Result<()> {
        let (zones, worn) = (self.zones(), dresses.len());
        if worn < zones {
            return Err(Error::input(format!(
                "the feather has {zones} zones but {worn} dresses; give each one"
            )));
        }
        for (index, dress) in dresses.iter().enumerate() {
            let [distal, proximal] = &dress.barbules;
            for ((part, worn), own) in PARTS.into_iter().zip([&dress.ramus, distal, proximal]).zip(own) {
                let Some(worn) = worn else { continue };
                let place = format!("the {part} of zone {}", index + 1);
                if worn.shape() != own.shape() {
                    let (worn, own) = (worn.shape(), own.shape());
                    return Err(Error::input(format!(
                        "{place} are {worn} where the feather's own are {own}; give {own}"
                    )));
                }
                if worn.roundness() != own.roundness() {
                    return Err(Error::input(format!(
                        "{place} are not as high over their width as the feather's own; give the same height_over_width"
                    )));
                }
            }
        }
        Ok(())
    }
}

/// The parts of a dress.
const PARTS: [&str; 3] = ["rami", "distal barbules", "proximal barbules"];
