//! A batch on the campaign's path, stage by stage, for those who time it.

use super::barbule::Barbule;
use super::batch::{Batch, Buffers};
use super::cone::Cone;
use super::synthesis::Grid;
use crate::Result;
use crate::math::simd::Width;
use crate::progress::Unobserved;
use crate::scattering::directions::AZIMUTH_MARGIN;
use crate::scattering::far_field::IncidentLight;
use crate::scattering::statistics::AZIMUTHS;
use crate::structure::Section;

/// A turn of the barbule, rad, that no azimuth falls together with.
const SHIFT: f64 = 0.01;

/// A barbule with the buffers of one thread.
pub struct Stages {
    barbule: Barbule,
    buffers: Buffers<f32>,
}

impl Stages {
    /// `ray_parts`: parts into which elements are cut for rays through layers.
    ///
    /// # Errors
    /// As [`Barbule::for_campaign`].
    pub fn new(section: &Section, ray_parts: usize) -> Result<Self> {
        Ok(Self { barbule: Barbule::for_campaign(section, ray_parts)?, buffers: Buffers::new(Width::best()) })
    }

    /// Both polarizations of light from the azimuths `phi_i` on the cone of `theta_i` (rad), calling `lap` with its name after
    /// each stage. The first makes what a wavelength's batches share, or, of a crystal, what instances share.
    ///
    /// # Errors
    /// A medium's table does not reach the wavelength, or a crystal cannot be solved.
    pub fn run(
        &mut self,
        wavelength_nm: f64,
        theta_i: f64,
        phi_i: &[f64],
        lap: &mut dyn FnMut(&'static str),
    ) -> Result<()> {
        let Self { barbule, buffers } = self;
        let underside = if barbule.ray_parts().is_some() {
            let table = barbule.table(wavelength_nm, Width::best(), &Unobserved)?.0;
            lap("reflectance tables");
            table
        } else {
            let orders = barbule.exactly(wavelength_nm, theta_i, phi_i, &Unobserved)?;
            lap("orders of the crystal");
            orders
        };
        let cone = Cone::around(std::slice::from_ref(barbule), wavelength_nm, theta_i);
        let lights: Vec<IncidentLight> = phi_i
            .iter()
            .map(|&phi| IncidentLight::Beam { power_um: barbule.incident_power_um(theta_i, phi) })
            .collect();
        let batch = Batch { cone: &cone, phi_i, lights: &lights };
        buffers.radiate(&barbule.points, &underside, &batch, &mut |stage| {
            lap(stage);
            Ok(())
        })?;
        let azimuths = AZIMUTHS * cone.refinement(AZIMUTHS);
        buffers.synthesize(&cone, Grid { azimuths, margin: AZIMUTH_MARGIN, shift: SHIFT }, &mut Vec::new());
        lap("fields on azimuths");
        Ok(())
    }
}
