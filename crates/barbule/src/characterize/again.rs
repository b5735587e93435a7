//! The barbules that a material was simulated from, made again from what it records.

use super::{CampaignDescription, Catalog, unrecorded};
use crate::Result;
use crate::brdf::FeatherMaterial;
use crate::bsdf::Arch;
use crate::campaign::{Campaign, CampaignParameters, Resources};
use crate::material::Library;
use crate::progress::Progress;
use crate::scattering::statistics::{Axes, Sides};
use crate::structure::{MOST_INSTANCES, Side, SpeciesModel, Structure};

/// The species that a material was simulated from, with the generator's parameters that it records; `None` where these are
/// missing or it was made of given sections.
#[must_use]
pub fn species_of(material: &FeatherMaterial, media: Library) -> Option<SpeciesModel> {
    let recorded = &material.info["campaign"]["structure"];
    let text = |key: &str| recorded[key].as_str().unwrap_or_default();
    SpeciesModel::from_parameters(text("species"), text("variant"), &recorded["parameters"], media).ok()
}

/// A material's barbules, with what simulating them needs.
#[derive(Debug, Clone)]
pub struct Barbules {
    structure: Structure,
    campaign: CampaignDescription,
    catalog: Catalog,
}

impl Barbules {
    /// Those of a material; `given` finds the structure of the name of given sections or of a stack, `media` are the media of species.
    ///
    /// # Errors
    /// The material records too little, or its sections or media are not to be had any more or have changed.
    pub fn of(
        material: &FeatherMaterial,
        media: Library,
        given: &dyn Fn(&str) -> Result<Structure>,
        catalog: Catalog,
    ) -> Result<Self> {
        let campaign = CampaignDescription::read(&material.info["campaign"]).map_err(|_| unrecorded())?;
        let recorded = &campaign.structure;
        let structure = if recorded["parameters"].is_object() {
            species_of(material, media).map(|model| Structure::Species(Box::new(model)))
        } else {
            let text = |key: &str| recorded[key].as_str();
            let name = text("stack").or_else(|| material.info["name"].as_str());
            let name = name.map(|name| name.strip_suffix(Side::BELOW).unwrap_or(name));
            name.filter(|name| !name.is_empty()).and_then(|name| given(name).ok())
        };
        let is_below = recorded["side"].as_str() == Some("below");
        let structure = structure.and_then(|s| if is_below { s.underside().ok() } else { Some(s) });
        let structure = structure.filter(|structure| structure.description() == *recorded);
        let structure = structure.ok_or_else(unrecorded)?.smoothed(campaign.smooth_um.into());
        Ok(Self { structure, campaign, catalog })
    }

    /// The arch of the barbules' cross-sections, of which each place mirrors its own pairs of directions; none of flat ones.
    ///
    /// # Errors
    /// Individuals that cannot be made.
    pub fn arch(&self) -> Result<Option<Arch>> {
        let normals = self.structure.edge_normals(self.campaign.seed)?;
        Ok(normals.and_then(|normals| Arch::between(normals, self.structure.width_um())))
    }

    /// The campaign that the material was made in, on other axes; with so many instances, or without tilt, where asked.
    ///
    /// # Errors
    /// As [`Campaign::with_orders`].
    pub fn campaign(
        &self,
        axes: Axes,
        instances: Option<usize>,
        tilted: bool,
        progress: &dyn Progress,
    ) -> Result<Campaign> {
        let recorded = self.campaign.instances.clamp(1, MOST_INSTANCES);
        let mut instances = instances.unwrap_or(recorded).max(1);
        if let Some(count) = self.structure.count().filter(|count| *count > 1) {
            instances = instances.min(count);
        }
        let tilt = if tilted { self.campaign.tilt_deg.clamp(0.0, 30.0).to_radians() } else { 0.0 };
        let orders = self.catalog.orders(&self.structure, &axes, progress)?;
        let mirror = self.campaign.mirror && axes.sides() == Sides::Alike;
        let places = self.campaign.places.clamp(1, instances);
        let parameters =
            CampaignParameters { axes, instances, seed: self.campaign.seed, tilt, mirror, places };
        Campaign::with_orders(&self.structure, parameters, orders, &Resources::default(), progress)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_holds_barbules_holds_all_they_need() {
        fn is_owned<T: Clone + Send + Sync + 'static>() {}
        is_owned::<Barbules>();
    }
}
