//! What decides a campaign's numbers, as stores and materials record it.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::structure::Structure;
use crate::{Error, Result};

/// Everything that decides the numbers of a campaign. Results are the same campaign's where these are equal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CampaignDescription {
    /// [`CAMPAIGN_VERSION`](super::CAMPAIGN_VERSION) of the program that computes.
    pub campaign_version: u64,
    /// [`Structure::description`].
    pub structure: Value,
    /// Vacuum wavelengths, nm, rising.
    pub wavelengths_nm: Vec<f64>,
    /// cosθ_i, rising.
    pub cos_theta_i: Vec<f64>,
    /// cosφ_i, rising.
    pub cos_phi_i: Vec<f64>,
    /// Number of instances.
    pub instances: usize,
    /// Seed of instances and tilts.
    pub seed: u64,
    /// Largest tilt of an instance, degrees.
    pub tilt_deg: f64,
    /// Whether a material keeps both incident polarizations apart.
    pub polarized: bool,
    /// Every how many-th wavelength and direction was kept.
    pub thinned: Option<usize>,
    /// The part by which both sides of the structure differ, where it was looked for ([`Plan::compare_sides`](super::Plan::compare_sides)).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asymmetry: Option<f64>,
}

impl CampaignDescription {
    /// Reads what a store or a material recorded.
    ///
    /// # Errors
    /// A field is missing or of another type.
    pub fn read(recorded: &Value) -> Result<Self> {
        Self::deserialize(recorded).map_err(|e| {
            Error::input(format!("records no campaign of this program ({e}); simulate it again"))
        })
    }

    /// As it is recorded.
    ///
    /// # Errors
    /// Never for numbers that are finite.
    pub fn to_json(&self) -> Result<Value> {
        serde_json::to_value(self).map_err(|e| Error::machine(format!("the campaign has no JSON form: {e}")))
    }

    /// The width of the barbules, µm, where the structure's description has it.
    #[must_use]
    pub fn width_um(&self) -> Option<f64> {
        let parameters = &self.structure["parameters"];
        parameters["width_um"].as_f64().or_else(|| self.structure["width_um"].as_f64())
    }

    /// The same campaign of `structure` with hashes of the version that an earlier result has, and with what that one
    /// found out besides.
    #[must_use]
    pub fn like(&self, recorded: &Value, structure: &Structure) -> Self {
        let asymmetry = recorded["asymmetry"].as_f64();
        Self { structure: structure.description_like(&recorded["structure"]), asymmetry, ..self.clone() }
    }

    /// Whether an earlier result is of this campaign of `structure`.
    #[must_use]
    pub fn is_recorded(&self, recorded: &Value, structure: &Structure) -> bool {
        Self::read(recorded).is_ok_and(|there| there == self.like(recorded, structure))
    }
}
