//! What fitted lobes say at the nodes of a material's tables.

use crate::scattering::directions;
use crate::scattering::lobe::{FitKind, Lobe};
use crate::scattering::statistics::{AZIMUTHS, Axes};

/// Wavelength in nm and θ_i, φ_i in degrees of a node.
pub(super) fn direction(axes: &Axes, node: usize) -> (f64, f64, f64) {
    let phis = axes.cos_phi().len();
    let thetas = axes.cos_theta().len();
    (
        axes.wavelengths_nm()[node / phis / thetas],
        libm::acos(axes.cos_theta()[node / phis % thetas]).to_degrees(),
        libm::acos(axes.cos_phi()[node % phis]).to_degrees(),
    )
}

/// U' or V' of a lobe: the shape on the azimuths, scaled to reflect `reflected`.
#[must_use]
pub fn fitted_values(kind: FitKind, lobe: Lobe, theta_i: f64, reflected: f64) -> Vec<f64> {
    let scale = fitted_scale(kind, lobe, theta_i, reflected);
    directions::azimuths(AZIMUTHS).map(|phi_o| scale * lobe.shape(kind, theta_i, phi_o)).collect()
}

/// The factor on a lobe's shape with which it reflects `reflected`.
#[must_use]
pub fn fitted_scale(kind: FitKind, lobe: Lobe, theta_i: f64, reflected: f64) -> f64 {
    let step = std::f64::consts::PI / AZIMUTHS as f64;
    let sum: f64 = directions::azimuths(AZIMUTHS).map(|phi_o| lobe.shape(kind, theta_i, phi_o)).sum();
    reflected / (libm::cos(theta_i) * step * sum).max(f64::MIN_POSITIVE)
}
