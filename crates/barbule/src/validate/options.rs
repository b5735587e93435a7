//! What is compared with full waves, as people choose it, and the plans that follow for a structure.

use serde::{Deserialize, Serialize};

use super::{FullWaves, Plan, usual_azimuths};
use crate::error::shortened;
use crate::progress::Clock;
use crate::solve::full_wave::{ELEMENTS, ELEMENTS_PER_WAVELENGTH, FullWave};
use crate::solve::{FAST, SHADOWED};
use crate::spectrum::Wavelengths;
use crate::structure::{Beneath, Ends, Smoothing, SpeciesModel, Structure};
use crate::{Error, Result};

/// The wavelengths of full waves unless others are asked for: first, step (nm) and number. In steps of 24.5 nm colours can still be told.
const USUAL_NM: [f64; 3] = [400.0, 12.0, 25.0];
const QUICK_NM: [f64; 3] = [400.0, 24.5, 13.0];

/// How wide species are in a quick look, µm.
const QUICK_WIDTH_UM: f64 = 6.0;

/// Azimuths of incidence, degrees. On 6 µm no beam comes from 60° alone.
const PHI_DEG: [f64; 3] = [0.0, 30.0, 60.0];
const QUICK_PHI_DEG: [f64; 2] = [0.0, 30.0];

/// The most individuals.
const MOST_INDIVIDUALS: usize = 1000;

/// Widths that a species may be given, µm, and numbers of layers.
const WIDTHS_UM: std::ops::RangeInclusive<f64> = 1.0..=1000.0;
const LAYERS: std::ops::RangeInclusive<u32> = 1..=100;

/// What is compared with full waves; the default is that of the command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FullWaveOptions {
    /// Vacuum wavelengths, nm, rising; without any 400 to 694 in steps of 12, of a quick look 24.5.
    pub wavelengths_nm: Option<Vec<f64>>,
    /// Azimuths of incidence, degrees; without any 0, 30 and 60, of a quick look 0 and 30.
    pub phi_deg: Option<Vec<f64>>,
    /// Width of a species' barbule, µm; its own without, of a quick look no more than 6.
    pub width_um: Option<f64>,
    /// Layers or rows of a species that counts them.
    pub layers: Option<u32>,
    /// Nodes per wavelength in the denser medium at each boundary.
    pub elements_per_wavelength: f64,
    /// How layers end at the sides.
    pub ends: Ends,
    /// Whether the top stands in its own light in the fast simulation's formulas.
    pub shadowing: bool,
    /// Over which standard deviation the fast simulation averages inclusions along the top, µm: 0 is not at all; the structure's own without.
    pub smooth_um: Option<f64>,
    /// The first individual, from 0.
    pub instance: usize,
    /// How many individuals.
    pub individuals: usize,
    /// Less of all.
    pub quick: bool,
    /// Seed of individuals.
    pub seed: u64,
}

impl Default for FullWaveOptions {
    fn default() -> Self {
        Self {
            wavelengths_nm: None,
            phi_deg: None,
            width_um: None,
            layers: None,
            elements_per_wavelength: ELEMENTS_PER_WAVELENGTH,
            ends: Ends::Open,
            shadowing: false,
            smooth_um: None,
            instance: 0,
            individuals: 1,
            quick: false,
            seed: 1,
        }
    }
}

impl FullWaveOptions {
    /// The comparison of a structure, checked before any work. Full waves are given up where they would take more than `memory_bytes`, and
    /// `clock` times them.
    ///
    /// # Errors
    /// A number is out of range; the width or layers of what is no species; sections without a top, or that cannot be closed; angles from
    /// which the light does not come.
    pub fn plan(&self, structure: Structure, memory_bytes: u64, clock: Clock) -> Result<FullWaves> {
        self.check()?;
        let structure = match self.smooth_um {
            None => structure,
            Some(0.0) => structure.smoothed(Smoothing::Off),
            Some(deviation_um) => structure.smoothed(Smoothing::over(deviation_um)?),
        };
        let quick = self.quick.then_some(QUICK_WIDTH_UM.min(structure.width_um()));
        let structure = narrowed(structure, self.width_um, self.layers, quick)?;
        let full = FullWave { elements_per_wavelength: self.elements_per_wavelength, memory_bytes, clock };
        let individuals = self.instance..self.instance + self.individuals;
        let plans = individuals.map(|instance| self.individual(&structure, instance, full));
        FullWaves::new(plans.collect::<Result<_>>()?)
    }

    fn check(&self) -> Result<()> {
        let Self { elements_per_wavelength, individuals, .. } = self;
        if !ELEMENTS.contains(elements_per_wavelength) {
            return Err(Error::input(format!(
                "{elements_per_wavelength} nodes per wavelength are asked for; give from {} to {}",
                ELEMENTS.start(),
                ELEMENTS.end()
            )));
        }
        if !(1..=MOST_INDIVIDUALS).contains(individuals) {
            return Err(Error::input(format!(
                "{individuals} individuals are to be compared; give from 1 to {MOST_INDIVIDUALS}"
            )));
        }
        check_species(self.width_um, self.layers)
    }

    fn individual(&self, structure: &Structure, instance: usize, full: FullWave) -> Result<Plan> {
        let section = structure.instance(self.seed, instance)?;
        let usual = if self.quick { QUICK_NM } else { USUAL_NM };
        let nm = self.wavelengths_nm.clone().unwrap_or_else(|| evenly(usual));
        let azimuths = usual_azimuths(&section, nm.iter().copied().fold(f64::INFINITY, f64::min));
        let closed = section.closed(Beneath::Absorbing, self.ends)?;
        if closed.fast.boundaries.is_empty() {
            return Err(Error::input(format!(
                "{}: the section has no top boundary, which the fast simulation needs; give one with boundaries",
                shortened(&section.name)
            )));
        }
        let plan = Plan {
            name: section.name.clone(),
            instance,
            closed,
            wavelengths: Wavelengths::new(nm)?,
            phi_i: self.phi_i()?,
            azimuths,
            full,
            method: if self.shadowing { SHADOWED } else { FAST },
        };
        plan.check_beams().map_err(|error| error.at("`phi_deg`").naming(&["phi_deg"]))?;
        Ok(plan)
    }

    /// Azimuths of incidence, rad, rising and none twice.
    fn phi_i(&self) -> Result<Vec<f64>> {
        let usual = if self.quick { &QUICK_PHI_DEG[..] } else { &PHI_DEG };
        let mut degrees = self.phi_deg.clone().unwrap_or_else(|| usual.to_vec());
        if degrees.is_empty() || !degrees.iter().all(|angle| angle.abs() <= 90.0) {
            return Err(
                Error::input("`phi_deg`: give at least one angle, each from -90 to 90°").naming(&["phi_deg"])
            );
        }
        degrees.sort_by(f64::total_cmp);
        degrees.dedup();
        Ok(degrees.into_iter().map(f64::to_radians).collect())
    }
}

/// Numbers in even steps: the first, the step and how many.
fn evenly([first, step, count]: [f64; 3]) -> Vec<f64> {
    (0..count as u32).map(|i| first + step * f64::from(i)).collect()
}

/// Refuses widths, µm, and numbers of layers that no species can have.
pub(super) fn check_species(width_um: Option<f64>, layers: Option<u32>) -> Result<()> {
    if let Some(bad) = width_um.filter(|width_um| !WIDTHS_UM.contains(width_um)) {
        return Err(Error::input(format!("`width_um` is {bad}; give 1 to 1000 µm")).naming(&["width_um"]));
    }
    match layers.filter(|count| !LAYERS.contains(count)) {
        Some(bad) => Err(Error::input(format!("`layers` is {bad}; give 1 to 100")).naming(&["layers"])),
        None => Ok(()),
    }
}

/// The structure with another width, µm, and number of layers; a species as wide as `usual` where nothing is asked.
pub(super) fn narrowed(
    structure: Structure,
    width_um: Option<f64>,
    layers: Option<u32>,
    usual: Option<f64>,
) -> Result<Structure> {
    let Structure::Species(model) = structure else {
        if width_um.is_some() || layers.is_some() {
            return Err(Error::input(
                "`width_um` and `layers` change species; a section is validated as it is, so leave them out",
            )
            .naming(&["width_um", "layers"]));
        }
        return Ok(structure);
    };
    let mut model = *model;
    if let Some(width_um) = width_um.or(usual) {
        model = model.with_parameters(&[("width_um", width_um.into())])?;
    }
    if let Some(layers) = layers {
        model = with_layers(&model, layers)?;
    }
    Ok(Structure::Species(Box::new(model)))
}

/// The species with so many layers or rows, where it counts them.
fn with_layers(model: &SpeciesModel, count: u32) -> Result<SpeciesModel> {
    let parameters = serde_json::to_value(&model.parameters)
        .map_err(|error| Error::machine(format!("parameters cannot be written: {error}")))?;
    if let Some(key) = ["layers", "rows"].into_iter().find(|key| parameters[*key].is_number()) {
        let changed = model.with_parameters(&[(key, count.into())]);
        return changed.map_err(|error| error.at("`layers`").naming(&["layers"]));
    }
    let title = model.title();
    let what = if parameters["layers"].is_array() {
        "lists its layers one by one, so no number changes them; take some out of that list in its file"
    } else {
        "has neither layers nor rows that are counted; leave it out"
    };
    Err(Error::input(format!("`layers` {count}: {} {what}", shortened(&title))).naming(&["layers"]))
}
