//! Where the time of a batch goes, for benchmarks.

use std::time::Instant;

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

/// One batch to be timed: a section at one (λ, θ_i).
#[derive(Debug, Clone, Copy)]
pub struct Timed<'a> {
    /// The section.
    pub section: &'a Section,
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// θ_i, rad.
    pub theta_i: f64,
    /// Azimuths of incidence, rad.
    pub phi_i: &'a [f64],
    /// Parts into which elements are cut for rays through layers.
    pub ray_parts: usize,
    /// What shares the first stage: batches that share a reflectance table, or instances that share a crystal's orders.
    pub shared_by: usize,
}

/// Seconds per stage of a batch (all φ_i, both polarizations) on the campaign's path, least of `repeats`. The first stage
/// is what is shared, divided by those that share it.
///
/// # Errors
/// A medium's table does not reach the wavelength, or a crystal cannot be solved.
pub fn stage_seconds(timed: &Timed<'_>, repeats: usize) -> Result<Vec<(&'static str, f64)>> {
    let barbule = Barbule::for_campaign(timed.section, timed.ray_parts)?;
    let mut buffers = Buffers::new(Width::best());
    let mut best: Vec<(&'static str, f64)> = Vec::new();
    for _ in 0..repeats.max(1) {
        let mut stages = once(timed, &barbule, &mut buffers)?;
        if let Some(first) = stages.first_mut() {
            first.1 /= timed.shared_by as f64;
        }
        if best.is_empty() {
            best = stages;
        } else {
            for (kept, new) in best.iter_mut().zip(stages) {
                kept.1 = kept.1.min(new.1);
            }
        }
    }
    Ok(best)
}

fn once(
    timed: &Timed<'_>,
    barbule: &Barbule,
    buffers: &mut Buffers<f32>,
) -> Result<Vec<(&'static str, f64)>> {
    let Timed { wavelength_nm, theta_i, phi_i, .. } = *timed;
    let mut stages = Vec::new();
    let mut clock = Instant::now();
    let mut lap = |name: &'static str| {
        stages.push((name, clock.elapsed().as_secs_f64()));
        clock = Instant::now();
        Ok(())
    };
    let underside = if barbule.ray_parts().is_some() {
        let table = barbule.table(wavelength_nm, Width::best(), &Unobserved)?.0;
        lap("reflectance tables")?;
        table
    } else {
        let orders = barbule.exactly(wavelength_nm, theta_i, phi_i, &Unobserved)?;
        lap("orders of the crystal")?;
        orders
    };
    let cone = Cone::around(std::slice::from_ref(barbule), wavelength_nm, theta_i);
    let lights: Vec<IncidentLight> = phi_i
        .iter()
        .map(|&phi| IncidentLight::Beam { power_um: barbule.incident_power_um(theta_i, phi) })
        .collect();
    let batch = Batch { cone: &cone, phi_i, lights: &lights };
    buffers.radiate(&barbule.points, &underside, &batch, &mut lap)?;
    let grid = Grid { azimuths: AZIMUTHS * cone.refinement(AZIMUTHS), margin: AZIMUTH_MARGIN, shift: SHIFT };
    buffers.synthesize(&cone, grid, &mut Vec::new());
    lap("fields on azimuths")?;
    Ok(stages)
}
