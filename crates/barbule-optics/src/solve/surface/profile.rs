//! Where the time of a batch goes, for benchmarks.

use std::time::Instant;

use num_complex::Complex;

use super::super::crystal::{Cell, Multipole, order_series};
use super::crystal::CrystalOrders;
use super::nodes::Nodes;
use super::points::{Surface, Window};
use super::radiation::{Cone, Workspace};
use super::rays::Rays;
use super::reflection::{Reflector, Stacks};
use super::table::ReflectanceTable;
use super::{CAMPAIGN_ELEMENT_UM, inverse_root, refinement};
use crate::Result;
use crate::math::simd::Width;
use crate::scattering::statistics::AZIMUTHS;
use crate::structure::Section;

/// Seconds per stage of one batch (all `phi_i`, both polarizations) on the campaign's path, least of `repeats`; layers
/// with elements cut into `parts` for rays. The first stage is what is shared: a layered instance's reflectance table by
/// `shared_by` batches of its wavelength, a crystal's orders by as many instances.
///
/// # Errors
/// A medium's table does not reach the wavelength, or a crystal cannot be solved.
pub fn stage_seconds(
    section: &Section,
    wavelength_nm: f64,
    theta_i: f64,
    phi_i: &[f64],
    parts: usize,
    shared_by: usize,
    repeats: usize,
) -> Result<Vec<(&'static str, f64)>> {
    let width = Width::best();
    let surface = Surface::new(section, CAMPAIGN_ELEMENT_UM, Window::Gaussian)?;
    let batch = Batch { surface: &surface, wavelength_nm, theta_i, phi_i };
    let rays =
        if surface.lattice.is_none() { Some(Rays::cast(section, CAMPAIGN_ELEMENT_UM, parts)?) } else { None };
    let mut best: Vec<(&'static str, f64)> = Vec::new();
    let mut workspace = Workspace::new(width);
    for _ in 0..repeats.max(1) {
        let begun = Instant::now();
        let mut stages = match (&rays, &surface.lattice) {
            (Some(rays), _) => {
                let table = ReflectanceTable::new(width, &surface, rays, wavelength_nm)?;
                batch.run("reflectance tables", begun, &Stacks(&table), &mut workspace)
            }
            (None, Some(lattice)) => {
                let cell = Cell::new(lattice, wavelength_nm)?;
                let series = order_series(&Multipole::default(), &cell, wavelength_nm, theta_i)?;
                let orders = CrystalOrders::new(&series, theta_i, lattice.bottom_um());
                batch.run("orders of the crystal", begun, &orders, &mut workspace)
            }
            (None, None) => Vec::new(),
        };
        if let Some(first) = stages.first_mut() {
            first.1 /= shared_by as f64;
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

/// One batch to be timed.
struct Batch<'a> {
    surface: &'a Surface,
    wavelength_nm: f64,
    theta_i: f64,
    phi_i: &'a [f64],
}

impl Batch<'_> {
    /// The stages; the first one, `named`, began before.
    fn run(
        &self,
        named: &'static str,
        begun: Instant,
        reflector: &impl Reflector<f32>,
        workspace: &mut Workspace<f32>,
    ) -> Vec<(&'static str, f64)> {
        let mut stages = Vec::new();
        let mut clock = begun;
        let mut lap = |name: &'static str, stages: &mut Vec<(&'static str, f64)>| {
            stages.push((name, clock.elapsed().as_secs_f64()));
            clock = Instant::now();
        };
        lap(named, &mut stages);
        let Self { surface, wavelength_nm, theta_i, phi_i } = *self;
        let (mut coefficients, mut circle, mut scratch) = (Vec::new(), Vec::new(), Vec::new());
        let cone = Cone::new(std::f64::consts::TAU / (wavelength_nm * 1e-3), theta_i, surface.radius_um);
        let nodes = Nodes::equidistant(surface, cone.kappa);
        let scales: Vec<f64> =
            phi_i.iter().map(|&phi| inverse_root(surface.incident_power_um(theta_i, phi))).collect();
        lap("nodes and powers", &mut stages);
        workspace.timed_far_fields(
            surface,
            reflector,
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
        stages
    }
}
