//! The barbules that a material was simulated from, made again from what it records.

use super::{CampaignDescription, Catalog, unrecorded};
use crate::Result;
use crate::brdf::FeatherMaterial;
use crate::campaign::{Campaign, CampaignParameters, Resources};
use crate::material::Library;
use crate::progress::Progress;
use crate::scattering::statistics::Axes;
use crate::structure::{SpeciesModel, Structure};

/// A material's barbules, with what simulating them needs.
pub struct Barbules<'a> {
    structure: Structure,
    campaign: CampaignDescription,
    catalog: &'a Catalog,
    progress: &'a dyn Progress,
}

impl<'a> Barbules<'a> {
    /// Those of a material; `given` finds the structure of the name of given sections or of a stack, `media` are the media of species.
    ///
    /// # Errors
    /// The material records too little, or its sections or media are not to be had any more or have changed.
    pub fn of(
        material: &FeatherMaterial,
        media: Library,
        given: &dyn Fn(&str) -> Result<Structure>,
        catalog: &'a Catalog,
        progress: &'a dyn Progress,
    ) -> Result<Self> {
        let campaign = CampaignDescription::read(&material.info["campaign"]).map_err(|_| unrecorded())?;
        let recorded = &campaign.structure;
        let text = |key: &str| recorded[key].as_str().unwrap_or_default();
        let structure = if recorded["parameters"].is_object() {
            let (species, variant) = (text("species"), text("variant"));
            let model = SpeciesModel::from_parameters(species, variant, &recorded["parameters"], media);
            model.ok().map(|model| Structure::Species(Box::new(model)))
        } else {
            let name = ["sections", "stack"].map(text).into_iter().find(|name| !name.is_empty());
            name.and_then(|name| given(name).ok())
        };
        let structure = structure.filter(|structure| structure.description_like(recorded) == *recorded);
        Ok(Self { structure: structure.ok_or_else(unrecorded)?, campaign, catalog, progress })
    }

    /// The campaign that the material was made in, on other axes; with so many instances, or without tilt, where asked.
    ///
    /// # Errors
    /// As [`Campaign::with_orders`].
    pub fn campaign(&self, axes: Axes, instances: Option<usize>, tilted: bool) -> Result<Campaign> {
        let recorded = self.campaign.instances.clamp(1, 10_000);
        let mut instances = instances.unwrap_or(recorded).max(1);
        if let Some(count) = self.structure.count().filter(|count| *count > 1) {
            instances = instances.min(count);
        }
        let tilt = if tilted { self.campaign.tilt_deg.clamp(0.0, 30.0).to_radians() } else { 0.0 };
        let orders = self.catalog.orders(&self.structure, &axes, self.progress)?;
        let parameters = CampaignParameters { axes, instances, seed: self.campaign.seed, tilt };
        Campaign::with_orders(&self.structure, parameters, orders, &Resources::default(), self.progress)
    }

    /// What watches the simulations.
    #[must_use]
    pub fn progress(&self) -> &dyn Progress {
        self.progress
    }
}
