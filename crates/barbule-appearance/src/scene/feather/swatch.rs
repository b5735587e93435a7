//! Swatches: flat samples of a vane, for feathers so far that a pixel holds several barbs.

use glam::DVec3;

use super::barb::Barb;
use super::{Feather, Grown, SheetBarbs, VaneDisc};
use crate::bsdf::Markings;
use crate::math::rng::hash;
use crate::{Error, Result};

/// Straight barbs side by side along y with their barbules, in the plane z = 0 of the vane; z is its normal.
#[derive(Debug, Clone)]
pub struct Swatch {
    /// The barbs, from y = 0 to their ends, about x = 0.
    pub grown: Grown,
    /// The part that may be shown, from where nobody sees the rim: half its extent across the barbs, mm.
    pub half_width_mm: f64,
    /// Its extent along the barbs, mm.
    pub along_mm: [f64; 2],
}

/// Barbs of a swatch; and how many of them at each rim are there for the others' sake.
pub(super) const BARBS: usize = 27;
const RIM: usize = 6;
/// Where on its barbs a swatch is shown, as shares of their length: bases and ends differ.
const SHOWN: [f64; 2] = [0.15, 0.8];

impl Feather {
    /// A swatch of the vane left (−1) or right (1) of the shaft, with barbs as those of its sheet.
    ///
    /// # Errors
    /// As [`Feather::check`]; barbs that are not apart or have no length.
    pub fn swatch(&self, side: f64, barbs: &SheetBarbs, seed: u64) -> Result<Swatch> {
        self.check()?;
        let SheetBarbs { spacing_mm, length_mm, .. } = *barbs;
        if !(spacing_mm > 0.0 && length_mm > 0.0 && spacing_mm.is_finite() && length_mm.is_finite()) {
            return Err(Error::input(format!(
                "a swatch of barbs {length_mm} mm long and {spacing_mm} mm apart: give sizes over 0"
            )));
        }
        let name = hash(seed, &[5, u64::from(side > 0.0)]);
        let barbs: Vec<Barb> = (0..BARBS)
            .map(|k| {
                let x = (k as f64 - 0.5 * (BARBS - 1) as f64) * spacing_mm;
                let id = hash(name, &[k as u64]);
                Barb::straight(DVec3::X * x, length_mm, side, 0.5e-3 * self.barbs.width_um, id)
            })
            .collect();
        let barbs: Vec<&Barb> = barbs.iter().collect();
        let mut grown = Grown::default();
        let everywhere = VaneDisc { along_mm: 0.0, radius_mm: None };
        let plain = Markings::default();
        self.add_rami(&mut grown, &barbs, &plain, DVec3::ZERO);
        self.add_stretches(&mut grown, &barbs, &plain, (DVec3::ZERO, everywhere), name);
        let half_width_mm = (0.5 * BARBS as f64 - RIM as f64) * spacing_mm;
        Ok(Swatch { grown, half_width_mm, along_mm: SHOWN.map(|share| share * length_mm) })
    }
}
