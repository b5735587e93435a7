//! Fast 2.5D wave simulation of one barbule.
//!
//! At each point of the top the barbule reflects like the ideal stack, or crystal, that lies under it; the reflected field
//! there is an equivalent current, and the currents radiate to the far field. [`direct`](crate::solve::direct) evaluates the
//! same formulas plainly and is what this module is tested against. Source: the feather paper's section 4 and the
//! theory page on the simulation.
//!
//! One illumination: [`far_field`]. Many: prepare each [`Barbule`], make its [`Underside`] at each wavelength, and let a
//! [`Workspace`] scatter whole [`Batch`]es of azimuths.

mod barbule;
mod batch;
mod cone;
mod crystal;
mod mirror;
mod nodes;
mod points;
mod radiation;
mod rays;
mod reflection;
mod reflector;
mod resolution;
mod scalar;
mod stages;
mod synthesis;
mod table;
#[cfg(test)]
mod tests;

pub use barbule::{Barbule, Size, Underside};
pub use batch::{Batch, Workspace};
pub use cone::Cone;
pub use crystal::orders;
pub(in crate::solve) use crystal::{CrystalOrders, series, solver};
pub use mirror::{LARGEST_MIRROR_ERROR, mirror_fraction};
pub(in crate::solve) use points::{Optics, SlotMedium};
pub(in crate::solve) use reflection::{LANES, add_reflectances};
pub use resolution::{MOST_RAY_PARTS, ray_parts};
pub use stages::Stages;
pub use synthesis::Grid;

use num_complex::Complex64;

use super::beam;
use super::far_fields::{OneByOne, Prepared, SectionSolver};
use crate::Result;
use crate::math::simd::Width;
use crate::progress::{OnlyStops, Progress, Unobserved};
use crate::scattering::far_field::{Azimuths, FarField, Illumination, Window};
use crate::structure::Section;
use batch::{Buffers, unless_cancelled};
use radiation::nodes_at_once;

/// Longest quadrature element along the top, µm, where single illuminations are computed: halving it changes no value
/// by more than 1e-4 of the peak.
pub const FINE_ELEMENT_UM: f64 = 0.01;

/// Longest quadrature element, µm, where many instances are lit from many directions; structure below it is averaged by
/// rays. Fields differ from converged ones by less than 1e-3 (relative L2).
pub const CAMPAIGN_ELEMENT_UM: f64 = 0.04;

/// How finely, and with which instructions, a single illumination is computed; the default is converged.
#[derive(Debug, Clone, Copy)]
pub struct Accuracy {
    /// Longest quadrature element along the top, µm.
    pub element_um: f64,
    /// SIMD instructions, on which only roundings depend.
    pub width: Width,
}

impl Default for Accuracy {
    fn default() -> Self {
        Self { element_um: FINE_ELEMENT_UM, width: Width::best() }
    }
}

/// This simulation as a solver of sections.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fast(pub Accuracy);

impl SectionSolver for Fast {
    fn prepare<'a>(&self, section: &'a Section) -> Result<Box<dyn Prepared + 'a>> {
        let Self(accuracy) = *self;
        let far_field =
            move |section: &Section, light: &Illumination, azimuths: usize, progress: &dyn Progress| {
                far_field_observed(section, light, azimuths, &accuracy, progress)
            };
        Ok(Box::new(OneByOne { section, element_um: accuracy.element_um, far_field }))
    }
}

/// The far field of a section on so many azimuths of the upper half, in double precision with every quadrature point (two
/// per element) a source.
///
/// # Errors
/// The light does not come through air, a medium's table does not reach the wavelength, or a crystal cannot be solved.
pub fn far_field(
    section: &Section,
    illumination: &Illumination,
    azimuths: usize,
    accuracy: &Accuracy,
) -> Result<FarField> {
    far_field_observed(section, illumination, azimuths, accuracy, &Unobserved)
}

/// As [`far_field`], watched by `progress`.
///
/// # Errors
/// As [`far_field`], or the user cancelled.
#[inline(never)]
pub fn far_field_observed(
    section: &Section,
    illumination: &Illumination,
    azimuths: usize,
    accuracy: &Accuracy,
    progress: &dyn Progress,
) -> Result<FarField> {
    let Accuracy { element_um, width } = *accuracy;
    let Illumination { wavelength_nm, theta_i, phi_i, window } = *illumination;
    if window == Window::Beam {
        return beam::far_field(section, illumination, azimuths, &|wave, azimuths| {
            far_field_observed(section, wave, azimuths, accuracy, &OnlyStops(progress))
        });
    }
    let barbule = Barbule::new(section, element_um, window)?;
    let cone = Cone::around(std::slice::from_ref(&barbule), wavelength_nm, theta_i);
    let light = window.light(barbule.incident_power_um(theta_i, phi_i));
    let reflector = barbule.exactly(wavelength_nm, theta_i, &[phi_i], progress)?;
    let batch = Batch { cone: &cone, phi_i: &[phi_i], lights: &[light] };
    let mut buffers = Buffers::<f64>::new(width);
    progress.begin("radiating", barbule.points.padded().div_ceil(nodes_at_once(cone.angles, false)) as u64);
    buffers.radiate(&barbule.points, &reflector, &batch, &mut |stage| {
        progress.advance(u64::from(stage == "matrix product"));
        unless_cancelled(progress)
    })?;
    let refine = cone.refinement(azimuths);
    let grid = Grid { azimuths: azimuths * refine, margin: 0, shift: 0.0 };
    let mut fine = Vec::new();
    buffers.synthesize(&cone, grid, &mut fine);
    let mut amplitudes: [[Vec<Complex64>; 2]; 2] = Default::default();
    let mut radiated = [0.0; 2];
    let step = Azimuths::UpperHalf(grid.azimuths).step();
    for (index, component) in fine.chunks_exact(grid.points()).enumerate() {
        let (polarization, along) = (index / 2, index % 2);
        radiated[polarization] +=
            theta_i.cos() * step * component.iter().map(Complex64::norm_sqr).sum::<f64>();
        amplitudes[polarization][along] =
            component.iter().skip(refine / 2).step_by(refine).copied().collect();
    }
    Ok(FarField { light, theta_i, azimuths: Azimuths::UpperHalf(azimuths), amplitudes, radiated })
}
