//! Where the time of a batch goes, for benchmarks.

use std::time::Instant;

use num_complex::Complex;

use super::nodes::Nodes;
use super::points::{Surface, Window};
use super::radiation::{Cone, Workspace};
use super::rays::Rays;
use super::table::ReflectanceTable;
use super::{CAMPAIGN_ELEMENT_UM, inverse_root, refinement};
use crate::Result;
use crate::math::simd::Width;
use crate::scattering::statistics::AZIMUTHS;
use crate::structure::Section;

/// Seconds per stage of one batch (all `phi_i`, both polarizations) on the campaign's path with elements cut into `parts`
/// for rays, least of `repeats`.
///
/// # Errors
/// A medium's table does not reach the wavelength.
pub fn stage_seconds(
    section: &Section,
    wavelength_nm: f64,
    theta_i: f64,
    phi_i: &[f64],
    parts: usize,
    repeats: usize,
) -> Result<Vec<(&'static str, f64)>> {
    let width = Width::best();
    let surface = &Surface::new(section, CAMPAIGN_ELEMENT_UM, Window::Gaussian)?;
    let rays = Rays::cast(section, CAMPAIGN_ELEMENT_UM, parts)?;
    let mut best: Vec<(&'static str, f64)> = Vec::new();
    let mut workspace = Workspace::<f32>::new(width);
    let (mut coefficients, mut circle, mut scratch) = (Vec::new(), Vec::new(), Vec::new());
    let cone = Cone::new(std::f64::consts::TAU / (wavelength_nm * 1e-3), theta_i, surface.radius_um);
    for _ in 0..repeats.max(1) {
        let mut stages = Vec::new();
        let mut clock = Instant::now();
        let mut lap = |name: &'static str, stages: &mut Vec<(&'static str, f64)>| {
            stages.push((name, clock.elapsed().as_secs_f64()));
            clock = Instant::now();
        };
        let table = ReflectanceTable::new(width, surface, &rays, wavelength_nm)?;
        lap("reflectance table, once per wavelength", &mut stages);
        let nodes = Nodes::equidistant(surface, cone.kappa);
        let scales: Vec<f64> =
            phi_i.iter().map(|&phi| inverse_root(surface.incident_power_um(theta_i, phi))).collect();
        lap("nodes and powers", &mut stages);
        workspace.timed_far_fields(
            surface,
            &table,
            &nodes,
            &cone,
            phi_i,
            &scales,
            &mut coefficients,
            |name| {
                lap(name, &mut stages);
            },
        );
        let synthesis = workspace.synthesis(&cone, AZIMUTHS * refinement(&cone, AZIMUTHS), 4);
        let mut out = vec![Complex::new(0f32, 0.0); synthesis.points()];
        for component in coefficients.chunks_exact(cone.angles) {
            synthesis.evaluate(component, 0.01, &mut circle, &mut scratch, &mut out);
        }
        lap("fields on azimuths", &mut stages);
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
