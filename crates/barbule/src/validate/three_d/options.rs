//! What is compared with segments, as people choose it, and the plan that follows for a structure.

use serde::{Deserialize, Serialize};

use super::Plan;
use crate::brdf::FeatherMaterial;
use crate::math::simd::Width;
use crate::progress::Clock;
use crate::spectrum::Wavelengths;
use crate::structure::{MOST_INSTANCES, Roughness, SEGMENT_LENGTHS_UM, Smoothing, Structure};
use crate::validate::options::{check_species, narrowed};
use crate::{Error, Result};

/// Vacuum wavelengths, nm, unless others are asked for.
const USUAL_NM: [f64; 8] = [400.0, 442.0, 484.0, 526.0, 568.0, 610.0, 652.0, 694.0];
const QUICK_NM: [f64; 3] = [400.0, 550.0, 694.0];

/// How many segments are averaged.
const USUAL_INSTANCES: usize = 50;
const QUICK_INSTANCES: usize = 10;

/// θ_i and φ_i of the light, degrees.
const DIRECTIONS_DEG: [[f64; 2]; 3] = [[0.0, 0.0], [0.0, 30.0], [30.0, 30.0]];

/// Largest turn of an instance about its axis, degrees: as campaigns have it, since the BRDF contains it.
const TILT_DEG: f64 = 2.0;

/// What is compared with segments; the default is that of the command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SegmentOptions {
    /// Vacuum wavelengths, nm, rising; without any 400 to 694 in steps of 42, of a quick look three of them.
    pub wavelengths_nm: Option<Vec<f64>>,
    /// Width of a species' barbule, µm; its own without.
    pub width_um: Option<f64>,
    /// Layers or rows of a species that counts them.
    pub layers: Option<u32>,
    /// Segments that are averaged; 50 without, of a quick look 10. Structures of given sections may have fewer.
    pub instances: Option<usize>,
    /// Length of a segment, µm; the barbule's width without.
    pub length_um: Option<f64>,
    /// Standard deviation of each boundary's height, µm; 0 makes segments invariant along the barbule.
    pub roughness_um: f64,
    /// Correlation lengths of these heights across and along, µm.
    pub correlation_um: [f64; 2],
    /// Less of all.
    pub quick: bool,
    /// Seed of instances and of their roughness.
    pub seed: u64,
}

impl Default for SegmentOptions {
    fn default() -> Self {
        let Roughness { amplitude_um, correlation_um } = Roughness::default();
        Self {
            wavelengths_nm: None,
            width_um: None,
            layers: None,
            instances: None,
            length_um: None,
            roughness_um: amplitude_um,
            correlation_um,
            quick: false,
            seed: 1,
        }
    }
}

impl SegmentOptions {
    /// Whether the structure stays what it was: a changed species has no material of its own.
    #[must_use]
    pub fn is_as_named(&self) -> bool {
        self.width_um.is_none() && self.layers.is_none()
    }

    /// The comparison of a structure with segments and with its material, where that is at hand; computed with the instructions `width`,
    /// which decide roundings, and timed by `clock`.
    ///
    /// # Errors
    /// A number is out of range; the width or layers of what is no species.
    pub fn plan(
        &self,
        structure: Structure,
        material: Option<Box<FeatherMaterial>>,
        width: Width,
        clock: Clock,
    ) -> Result<Plan> {
        check_species(self.width_um, self.layers)?;
        let roughness = self.roughness()?;
        let [shortest, longest] = SEGMENT_LENGTHS_UM;
        if let Some(bad) = self.length_um.filter(|length_um| !(shortest..=longest).contains(length_um)) {
            let message = format!("`length_um` is {bad}; give {shortest} to {longest} µm");
            return Err(Error::input(message).naming(&["length_um"]));
        }
        let asked = self.instances.unwrap_or(if self.quick { QUICK_INSTANCES } else { USUAL_INSTANCES });
        if !(1..=MOST_INSTANCES).contains(&asked) {
            let message = format!("`instances` is {asked}; give 1 to {MOST_INSTANCES}");
            return Err(Error::input(message).naming(&["instances"]));
        }
        // Segments take each column for itself, and so does what they are held against.
        let structure = structure.smoothed(Smoothing::Off);
        let structure = narrowed(structure, self.width_um, self.layers, None)?;
        let usual = if self.quick { &QUICK_NM[..] } else { &USUAL_NM };
        Ok(Plan {
            seed: self.seed,
            instances: structure.count().map_or(asked, |given| asked.min(given)),
            wavelengths: Wavelengths::new(self.wavelengths_nm.clone().unwrap_or_else(|| usual.to_vec()))?,
            directions: DIRECTIONS_DEG.map(|direction| direction.map(f64::to_radians)).to_vec(),
            length_um: self.length_um.unwrap_or_else(|| structure.width_um().clamp(shortest, longest)),
            roughness,
            tilt: TILT_DEG.to_radians(),
            material,
            width,
            clock,
            structure,
        })
    }

    /// The roughness; of none the correlation lengths do not count.
    fn roughness(&self) -> Result<Roughness> {
        let given = Roughness { amplitude_um: self.roughness_um, correlation_um: self.correlation_um };
        given.check().map_err(|error| {
            error.at("`roughness_um`, `correlation_um`").naming(&["roughness_um", "correlation_um"])
        })?;
        Ok(if given.amplitude_um > 0.0 { given } else { Roughness::NONE })
    }
}
