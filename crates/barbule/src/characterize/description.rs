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

    /// The same campaign of `structure` with hashes of the version that an earlier result has.
    #[must_use]
    pub fn like(&self, recorded: &Value, structure: &Structure) -> Self {
        Self { structure: structure.description_like(&recorded["structure"]), ..self.clone() }
    }

    /// Whether an earlier result is of this campaign of `structure`.
    #[must_use]
    pub fn is_recorded(&self, recorded: &Value, structure: &Structure) -> bool {
        Self::read(recorded).is_ok_and(|there| there == self.like(recorded, structure))
    }
}
