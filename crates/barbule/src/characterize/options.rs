//! What a campaign simulates, as people choose it, and the plan that follows for a structure.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::catalog::file_stem;
use super::{CAMPAIGN_VERSION, CampaignDescription, Catalog};
use crate::campaign::{Campaign, CampaignParameters, Demand, Keep, Resources, Results, places, sides};
use crate::io::HASH_DIGITS;
use crate::io::store::Store;
use crate::progress::Progress;
use crate::scattering::far_field::Window;
use crate::scattering::statistics::{Axes, Sides};
use crate::solve::cost::Cost;
use crate::solve::surface::{Barbule, CAMPAIGN_ELEMENT_UM};
use crate::spectrum::Wavelengths;
use crate::structure::{MOST_INSTANCES, Structure, Symmetry};
use crate::{Error, Result, identity};

/// Wavelengths that can be simulated, nm.
pub const WAVELENGTHS_NM: std::ops::RangeInclusive<f64> = 300.0..=830.0;

/// Why a wavelength in nm cannot be simulated, as the end of a sentence; none of one that can.
#[must_use]
pub fn outside_wavelengths(nm: f64) -> Option<String> {
    let (low, high) = (WAVELENGTHS_NM.start(), WAVELENGTHS_NM.end());
    if WAVELENGTHS_NM.contains(&nm) {
        return None;
    }
    let why = if nm < *low {
        "the formula of keratin's index begins there, since below keratin absorbs"
    } else {
        "the tables of lights and of the eye end there"
    };
    Some(format!("{nm} nm is outside {low} to {high} nm: {why}"))
}

/// Instances of a campaign, and of a thinned one, where nobody asks for others.
const USUAL_INSTANCES: usize = 50;
const THINNED_INSTANCES: usize = 12;

/// What simulations take on one core, to foretell durations (`barbule bench campaign`), each per µm of the barbule's width:
/// seconds per illumination, per layer under the top of one instance at one wavelength, and per pair of an instance's layers.
const ILLUMINATION_S_PER_UM: f64 = 2.3e-6;
const LAYER_S_PER_UM: f64 = 4e-5;
const LAYER_PAIR_S_PER_UM: f64 = 6e-6;

/// How much longer light on a crystal takes, and how much of a layer's time one that is an average: it needs one ray where others
/// need several.
const OVER_CRYSTAL: f64 = 1.7;
const OF_AVERAGES: f64 = 0.4;

/// How much more of an arch there is than its width.
const ARCH: f64 = 1.5;

/// Seconds that the fit takes per wavelength and direction, and at all, on one core.
const FIT_S: f64 = 1e-3;
const START_S: f64 = 1.6;

/// What a campaign simulates; the default is that of every command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CampaignOptions {
    /// Vacuum wavelengths, nm, rising.
    pub wavelengths_nm: Vec<f64>,
    /// Directions: cosθ_i in so many equal steps up to 1, cosφ_i likewise.
    pub directions: [usize; 2],
    /// Random instances: without a number 50, of a thinned campaign 12. Structures of given sections may have fewer.
    pub instances: Option<usize>,
    /// Largest tilt of an instance about its axis, degrees.
    pub tilt_deg: f64,
    /// Keep both incident polarizations apart in the material.
    pub polarized: bool,
    /// Every so many-th wavelength and direction only.
    pub thin: Option<usize>,
    /// Seed of instances and tilts.
    pub seed: u64,
    /// Barbules lie either way round: each instance counts with its mirror image. Structures that are their own mirror
    /// images, each or in the mean, do without.
    pub mirror: bool,
}

impl Default for CampaignOptions {
    fn default() -> Self {
        Self {
            wavelengths_nm: (0..51).map(|i| f64::from(300 + 8 * i)).collect(),
            directions: [20, 20],
            instances: None,
            tilt_deg: 2.0,
            polarized: false,
            thin: None,
            seed: 1,
            mirror: false,
        }
    }
}

impl CampaignOptions {
    /// Refuses what no campaign can be.
    ///
    /// # Errors
    /// A value out of range; the message starts with its name.
    pub fn check(&self) -> Result<()> {
        let refuse = |message: String| Err(Error::input(message));
        let Self { wavelengths_nm, directions: [thetas, phis], instances, tilt_deg, thin, .. } = self;
        if wavelengths_nm.is_empty() || !wavelengths_nm.is_sorted_by(|a, b| a < b) {
            return refuse("wavelengths: give at least one, rising".into());
        }
        if let Some(outside) = wavelengths_nm.iter().find_map(|nm| outside_wavelengths(*nm)) {
            return refuse(format!("wavelengths: {outside}"));
        }
        if ![thetas, phis].into_iter().all(|n| (2..=200).contains(n)) {
            return refuse(format!("directions {thetas}x{phis}: write NxM with 2 to 200 each, as in 20x20"));
        }
        // With its mirror image each instance counts twice.
        let most = if self.mirror { MOST_INSTANCES / 2 } else { MOST_INSTANCES };
        if let Some(bad) = instances.filter(|count| !(1..=most).contains(count)) {
            return refuse(format!("instances {bad}: give a number from 1 to {most}"));
        }
        if !(0.0..=30.0).contains(tilt_deg) {
            return refuse(format!("tilt {tilt_deg}: give degrees from 0 to 30"));
        }
        match thin {
            Some(thin) if !(1..=20).contains(thin) => {
                refuse(format!("thin {thin}: give a number from 1 to 20"))
            }
            _ => Ok(()),
        }
    }

    /// How many instances that is.
    #[must_use]
    pub fn count(&self) -> usize {
        let usual = if self.thin.is_some() { THINNED_INSTANCES } else { USUAL_INSTANCES };
        self.instances.unwrap_or(usual)
    }

    /// The campaign of a structure.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn plan(&self, structure: Structure) -> Result<Plan> {
        self.check()?;
        let thin = self.thin.unwrap_or(1);
        let nm: Vec<f64> = self.wavelengths_nm.iter().copied().step_by(thin).collect();
        let [cos_theta, cos_phi] = self.directions.map(|count| steps(count, thin));
        let symmetry = structure.symmetry();
        let mirror = self.mirror && !symmetry.is_mirrored();
        let sides = if mirror { Sides::Alike } else { sides(&symmetry) };
        let axes = Axes::new(&Wavelengths::new(nm)?, cos_theta, cos_phi)?.with_sides(sides);
        let asked = self.count();
        // A single section serves any number of instances, which differ by their tilts.
        let instances = structure.count().filter(|count| *count > 1).map_or(asked, |count| asked.min(count));
        let places = places(&structure, instances);
        let description = CampaignDescription {
            campaign_version: CAMPAIGN_VERSION,
            structure: structure.description(),
            wavelengths_nm: axes.wavelengths_nm().to_vec(),
            cos_theta_i: axes.cos_theta().to_vec(),
            cos_phi_i: axes.cos_phi().to_vec(),
            instances,
            seed: self.seed,
            tilt_deg: self.tilt_deg,
            polarized: self.polarized,
            thinned: self.thin,
            sides,
            mirror,
            smooth_um: structure.smooth_um(),
            places,
        };
        let tilt = self.tilt_deg.to_radians();
        let parameters = CampaignParameters { axes, instances, seed: self.seed, tilt, mirror, places };
        Ok(Plan { structure, symmetry, parameters, description, asked })
    }
}

/// i/count for i = 1 … count, every `thin`-th from the end, so that normal incidence stays.
fn steps(count: usize, thin: usize) -> Vec<f64> {
    let mut kept: Vec<f64> = (1..=count).rev().step_by(thin).map(|i| i as f64 / count as f64).collect();
    kept.reverse();
    kept
}

/// A campaign that has been checked.
#[derive(Debug, Clone)]
pub struct Plan {
    /// What is simulated.
    pub structure: Structure,
    /// Whether it is its own mirror image, which decides the signs of φ_i.
    pub symmetry: Symmetry,
    /// On which axes, with how many instances.
    pub parameters: CampaignParameters,
    /// Everything that decides the numbers, for results.
    pub description: CampaignDescription,
    /// Instances that were asked for: given sections may be fewer.
    pub asked: usize,
}

impl Plan {
    /// Prepares the instances; orders of crystals come from the catalog's cache or go there.
    ///
    /// # Errors
    /// An instance cannot be made, a medium's table does not reach a wavelength, or a stop by `progress`.
    pub fn campaign(
        &self,
        resources: &Resources,
        catalog: &Catalog,
        progress: &dyn Progress,
    ) -> Result<Campaign> {
        let orders = catalog.orders(&self.structure, &self.parameters.axes, progress)?;
        Campaign::with_orders(&self.structure, self.parameters.clone(), orders, resources, progress)
    }

    /// Creates the campaign's store, or opens it to go on; fields of all instances are kept at wavelengths `kept_nm`. The
    /// store records the SIMD instructions of `resources`.
    ///
    /// # Errors
    /// As [`Store::create`].
    pub fn store(&self, path: &Path, kept_nm: &[f64], resources: &Resources) -> Result<Store> {
        let (name, description) = (self.structure.name(), self.description.to_json()?);
        let (axes, instances) = (&self.parameters.axes, self.parameters.realizations());
        Store::create(path, axes, instances, &name, &description, kept_nm, resources.width.name())
    }

    /// A file name for the campaign's store: that of the structure, readable, and the head of the campaign's hash.
    #[must_use]
    pub fn store_name(&self) -> String {
        let key = identity::hash("campaign", &self.description);
        format!("{}-{}.zarr", file_stem(&self.structure.name()), &key[..HASH_DIGITS])
    }

    /// Illuminations of the whole campaign.
    #[must_use]
    pub fn illuminations(&self) -> usize {
        self.parameters.simulated().len() * self.parameters.instances * 2
    }

    /// Seconds that simulation and fit take on so many cores that do nothing else, roughly.
    #[must_use]
    pub fn seconds(&self, cores: usize) -> f64 {
        (self.fit_seconds() + self.simulating_seconds()) / cores as f64
    }

    /// Seconds that the fit takes on one core, with what begins and ends a characterization, roughly.
    pub(crate) fn fit_seconds(&self) -> f64 {
        START_S + FIT_S * self.parameters.axes.len() as f64
    }

    /// What one [unit](crate::scattering::statistics::Unit) takes on so many cores, beside what all share: its fields and results,
    /// and its part of the time; at most and roughly.
    ///
    /// # Errors
    /// An instance cannot be made.
    pub fn unit_cost(&self, keep: Keep, cores: usize) -> Result<Cost> {
        let demand = Demand::bound(&self.structure, &self.parameters, keep, Results::Stored)?;
        let units = self.parameters.axes.units().count() * cores;
        let seconds = self.simulating_seconds() / units as f64;
        Ok(Cost { bytes: demand.unit, seconds: Some(seconds), ..Cost::default() })
    }

    /// Seconds that the simulation takes on one core.
    fn simulating_seconds(&self) -> f64 {
        let CampaignParameters { axes, instances, seed, .. } = &self.parameters;
        let layers = self
            .structure
            .instance(*seed, 0)
            .and_then(|section| Barbule::new(&section, CAMPAIGN_ELEMENT_UM, Window::Gaussian))
            .map_or(6.0, |barbule| barbule.slots() as f64);
        let layers = layers * if self.structure.smooth_um().is_some() { OF_AVERAGES } else { 1.0 };
        let crystal = if self.structure.lattice().is_some() { OVER_CRYSTAL } else { 1.0 };
        // A single given section serves all instances.
        let prepared = self.structure.count().map_or(*instances, |count| count.min(*instances)) as f64;
        let tables = prepared * axes.wavelengths_nm().len() as f64;
        let per_um = crystal * ILLUMINATION_S_PER_UM * self.illuminations() as f64
            + LAYER_S_PER_UM * layers * tables
            + LAYER_PAIR_S_PER_UM * layers * layers * prepared;
        per_um * self.structure.width_um() * if self.structure.is_curved() { ARCH } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::SpeciesModel;

    fn starling() -> Structure {
        let model = SpeciesModel::builtin("starling", None, crate::material::Library::builtin());
        Structure::Species(Box::new(model.unwrap()))
    }

    #[test]
    fn defaults_are_those_of_the_shipped_materials() {
        let plan = CampaignOptions::default().plan(starling()).unwrap();
        let shipped = barbule_birds::material("starling-green").unwrap();
        let shipped = crate::io::decode_material(shipped).unwrap();
        assert!(plan.description.is_recorded(&shipped.info["campaign"]));
    }

    /// CPU seconds of `barbule characterize` on the machine of `docs/performance.md`; they vary by a third there.
    #[test]
    fn durations_are_foretold_within_a_half() {
        let thinned = CampaignOptions { thin: Some(4), ..CampaignOptions::default() };
        for (name, full_s, thinned_s) in [
            ("starling", 115.0, 3.7),
            ("rock-dove", 165.0, 4.1),
            ("bronzewing", 350.0, 9.1),
            ("hummingbird", 520.0, 20.7),
            ("mallard", 320.0, 4.2),
        ] {
            for (options, measured_s) in [(CampaignOptions::default(), full_s), (thinned.clone(), thinned_s)]
            {
                let plan = options.plan(Structure::builtin(name).unwrap()).unwrap();
                let ratio: f64 = plan.seconds(1) / measured_s;
                assert!((1.0 / 1.5..1.5).contains(&ratio), "{name}: {ratio}");
                assert!((plan.seconds(1) / plan.seconds(4) - 4.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn units_take_their_part_of_the_time_and_keeping_fields_takes_memory() {
        let plan = CampaignOptions::default().plan(starling()).unwrap();
        let cost = |keep, cores| plan.unit_cost(keep, cores).unwrap();
        let seconds = cost(Keep::Statistics, 2).seconds.unwrap();
        let units = plan.parameters.axes.units().count() as f64;
        // The rest is the fit's.
        assert!((0.8..1.0).contains(&(seconds * units / plan.seconds(2))), "{seconds}");
        assert!(cost(Keep::Fields, 1).bytes > cost(Keep::Statistics, 1).bytes);
    }

    #[test]
    fn a_thinned_campaign_keeps_normal_incidence() {
        let options = CampaignOptions { thin: Some(10), ..CampaignOptions::default() };
        let plan = options.plan(starling()).unwrap();
        let axes = &plan.parameters.axes;
        assert_eq!((axes.cos_theta(), plan.parameters.instances), (&[0.5, 1.0][..], 12));
        assert_eq!(axes.wavelengths_nm(), [300.0, 380.0, 460.0, 540.0, 620.0, 700.0]);
    }

    #[test]
    fn instances_that_are_asked_for_are_simulated_thinned_or_not() {
        for (thin, instances, simulated) in [
            (None, None, 50),
            (Some(4), None, 12),
            (Some(4), Some(20), 20),
            (Some(4), Some(3), 3),
            (None, Some(12), 12),
        ] {
            let options = CampaignOptions { thin, instances, ..CampaignOptions::default() };
            let plan = options.plan(starling()).unwrap();
            assert_eq!((plan.parameters.instances, plan.description.instances), (simulated, simulated));
        }
    }

    #[test]
    fn options_out_of_range_are_refused_by_name() {
        let usual = CampaignOptions::default;
        for (bad, part) in [
            (CampaignOptions { wavelengths_nm: vec![], ..usual() }, "wavelengths: give"),
            (CampaignOptions { wavelengths_nm: vec![500.0, 400.0], ..usual() }, "rising"),
            (CampaignOptions { wavelengths_nm: vec![900.0], ..usual() }, "900 nm is outside 300 to 830"),
            (CampaignOptions { directions: [1, 20], ..usual() }, "directions 1x20"),
            (CampaignOptions { instances: Some(0), ..usual() }, "instances 0"),
            (CampaignOptions { tilt_deg: f64::NAN, ..usual() }, "tilt NaN"),
            (CampaignOptions { thin: Some(21), ..usual() }, "thin 21"),
        ] {
            let message = bad.check().unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn descriptions_come_back_from_json() {
        let description = CampaignOptions::default().plan(starling()).unwrap().description;
        let json = description.to_json().unwrap();
        assert_eq!(CampaignDescription::read(&json).unwrap(), description);
        assert_eq!((&json["campaign_version"], &json["structure"]["identity"]), (&2.into(), &2.into()));
        assert!(CampaignDescription::read(&serde_json::json!({"seed": 1})).unwrap_err().is_input());
    }
}
