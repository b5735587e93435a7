//! How finely the structure under a campaign's points must be sampled.

use num_complex::Complex;

use crate::math::simd::Width;
use crate::progress::Progress;
use crate::solve::surface::{
    CAMPAIGN_ELEMENT_UM, Cone, Nodes, Rays, ReflectanceTable, Stacks, Surface, Window, Workspace,
};
use crate::structure::{Section, Structure};
use crate::{Error, Result};

/// Change of a field (relative L2) under halving from which on rays are dense enough. What is left is a third of it,
/// and other instances and directions have up to thrice as much.
const SETTLED: f64 = 6.0e-4;

/// The most parts that elements are cut into.
const MOST_PARTS: usize = 8;

/// Instances that are asked.
const ASKED: usize = 2;

/// The parts into which elements must be cut for rays, at the campaign's shortest wavelength and normal incidence.
///
/// # Errors
/// An instance cannot be made, a medium's table does not reach, or the user cancelled.
pub(super) fn ray_parts(
    structure: &Structure,
    seed: u64,
    distinct: usize,
    shortest_nm: f64,
    width: Width,
    progress: &dyn Progress,
) -> Result<usize> {
    let mut parts = 1;
    for instance in 0..distinct.min(ASKED) {
        let section = structure.instance(seed, instance)?;
        let mut coarse = field(&section, parts, shortest_nm, width)?;
        while parts < MOST_PARTS {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let fine = field(&section, 2 * parts, shortest_nm, width)?;
            let change: f64 = coarse.iter().zip(&fine).map(|(a, b)| f64::from((a - b).norm_sqr())).sum();
            let whole: f64 = fine.iter().map(|v| f64::from(v.norm_sqr())).sum();
            if change <= SETTLED * SETTLED * whole {
                break;
            }
            parts *= 2;
            coarse = fine;
        }
    }
    Ok(parts)
}

/// The field of a section at normal incidence, as Fourier coefficients.
fn field(section: &Section, parts: usize, wavelength_nm: f64, width: Width) -> Result<Vec<Complex<f32>>> {
    let surface = Surface::new(section, CAMPAIGN_ELEMENT_UM, Window::Gaussian)?;
    let rays = Rays::cast(section, CAMPAIGN_ELEMENT_UM, parts)?;
    let table = ReflectanceTable::new(width, &surface, &rays, wavelength_nm)?;
    let cone = Cone::new(std::f64::consts::TAU / (wavelength_nm * 1e-3), 0.0, surface.radius_um);
    let nodes = Nodes::equidistant(&surface, cone.kappa);
    let mut coefficients = Vec::new();
    Workspace::new(width).far_fields(
        &surface,
        &Stacks(&table),
        &nodes,
        &cone,
        &[0.0],
        &[1.0],
        &mut coefficients,
    );
    Ok(coefficients)
}
