//! Fast 2.5D wave simulation of one barbule.
//!
//! At each point of the top the barbule reflects like the ideal stack, or crystal, that lies under it; the reflected field
//! there is an equivalent current, and the currents radiate to the far field. [`direct`](crate::solve::direct) evaluates the
//! same formulas plainly and is what this module is tested against. Source: the feather paper's section 4 and the
//! theory page on the simulation.

mod crystal;
mod nodes;
mod points;
mod profile;
mod radiation;
mod rays;
mod reflection;
mod table;
#[cfg(test)]
mod tests;

use num_complex::{Complex, Complex64};

pub use crystal::CrystalOrders;
pub use nodes::Nodes;

pub use points::{Surface, Window};
pub use profile::stage_seconds;

pub use radiation::{Cone, Workspace};
pub use rays::Rays;
pub use reflection::Stacks;
pub use table::ReflectanceTable;

use super::crystal::{Cell, Multipole, order_series};
use crate::Result;
use crate::math::band_limited::NODES_PER_PERIOD;
use crate::math::simd::Width;

/// Longest quadrature element along the top, µm, where single illuminations are computed: halving it changes no value
/// by more than 1e-4 of the peak.
pub const FINE_ELEMENT_UM: f64 = 0.01;

/// Longest quadrature element, µm, where many instances are lit from many directions; structure below it is averaged by
/// rays. Fields differ from converged ones by less than 1e-3 (relative L2).
pub const CAMPAIGN_ELEMENT_UM: f64 = 0.04;

/// The far field of one instance for one incident direction and both incident polarizations.
#[derive(Debug, Clone)]
pub struct FarField {
    /// Outgoing azimuths, rad.
    pub phi_o: Vec<f64>,
    /// Components along the outgoing e₁ and e₂, `[incident polarization][e₁, e₂][azimuth]`, over √Φ_i; for a plane
    /// wave without window they belong to unit |E|.
    pub fields: [[Vec<Complex64>; 2]; 2],
    /// Φ_i, µm, for c₀ = 1 and unit |E|; `None` without window.
    pub incident_power_um: Option<f64>,
    /// Φ_r/Φ_i by incident polarization; without window the reflected width in µm.
    pub reflected: [f64; 2],
    /// cosθ_i.
    pub cos_theta: f64,
}

impl FarField {
    /// c₀|𝓔|²/Φ_i, rad⁻¹; without window cosθ·|𝓔|², the differential width in µm/rad.
    #[must_use]
    pub fn intensity(&self, polarization: usize) -> Vec<f64> {
        let scale = if self.incident_power_um.is_some() { 1.0 } else { self.cos_theta };
        let [e1, e2] = &self.fields[polarization];
        e1.iter().zip(e2).map(|(a, b)| scale * (a.norm_sqr() + b.norm_sqr())).collect()
    }
}

/// How many times finer than the asked azimuths fields are sampled: the least odd number (grids then nest) at which
/// intensities are resolved and fields can be interpolated.
#[must_use]
pub fn refinement(cone: &Cone, azimuths: usize) -> usize {
    let least = (NODES_PER_PERIOD * cone.band() as f64 / (2 * azimuths) as f64).ceil() as usize;
    least.max(1) | 1
}

/// The far field of a prepared surface, in double precision with every quadrature point a source.
///
/// `phi_o` are the azimuths (n + ½)·π/`azimuths` − π/2.
///
/// # Errors
/// A medium's table does not reach the wavelength, or a crystal cannot be solved.
pub fn far_field(
    surface: &Surface,
    window: Window,
    wavelength_nm: f64,
    theta_i: f64,
    phi_i: f64,
    azimuths: usize,
    width: Width,
) -> Result<FarField> {
    let optics = surface.optics(wavelength_nm)?;
    let cone = Cone::new(optics.k, theta_i, surface.radius_um);
    let incident_power_um = (window == Window::Gaussian).then(|| surface.incident_power_um(theta_i, phi_i));
    let scale = incident_power_um.map_or(1.0, inverse_root);
    let mut workspace = Workspace::<f64>::new(width);
    let mut coefficients = Vec::new();
    let nodes = Nodes::at_points(surface);
    if let Some(lattice) = &surface.lattice {
        let cell = Cell::new(lattice, wavelength_nm)?;
        let series = order_series(&Multipole::default(), &cell, wavelength_nm, theta_i)?;
        let orders = CrystalOrders::new(&series, theta_i, lattice.bottom_um());
        workspace.far_fields(surface, &orders, &nodes, &cone, &[phi_i], &[scale], &mut coefficients);
    } else {
        workspace.far_fields(surface, &Stacks(&optics), &nodes, &cone, &[phi_i], &[scale], &mut coefficients);
    }
    let refine = refinement(&cone, azimuths);
    let synthesis = workspace.synthesis(&cone, azimuths * refine, 0);
    let (mut circle, mut scratch) = (Vec::new(), Vec::new());
    let mut fine = vec![Complex::new(0.0, 0.0); synthesis.points()];
    let mut fields: [[Vec<Complex64>; 2]; 2] = Default::default();
    let mut reflected = [0.0; 2];
    let step = std::f64::consts::PI / fine.len() as f64;
    for (index, component) in coefficients.chunks_exact(cone.angles).enumerate() {
        synthesis.evaluate(component, 0.0, &mut circle, &mut scratch, &mut fine);
        let (polarization, along) = (index / 2, index % 2);
        reflected[polarization] += theta_i.cos() * step * fine.iter().map(Complex64::norm_sqr).sum::<f64>();
        fields[polarization][along] = fine.iter().skip(refine / 2).step_by(refine).copied().collect();
    }
    Ok(FarField {
        phi_o: crate::scattering::directions::azimuths(azimuths).collect(),
        fields,
        incident_power_um,
        reflected,
        cos_theta: theta_i.cos(),
    })
}

/// 1/√Φ_i, zero where no light arrives.
pub fn inverse_root(incident_power_um: f64) -> f64 {
    if incident_power_um > 0.0 { incident_power_um.sqrt().recip() } else { 0.0 }
}
