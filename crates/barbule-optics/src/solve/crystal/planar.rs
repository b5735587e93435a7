//! Flat layers at any incidence as a Jones matrix: what crystals must become whose rods are of the host's own index or
//! fill the period. The amplitudes are those of [`film`](crate::film).

use glam::DVec3;

use super::Incidence;
use crate::film::{Polarization, reflect};
use crate::scattering::directions::{e1, e2, omega};
use crate::scattering::orders::Jones;
use crate::{Complex64, Result};

/// The Jones matrix `[out][in]` of `layers` (ε, thickness in µm) on a substrate, seen from a medium of index `n`.
///
/// # Errors
/// As [`reflect`].
pub fn jones(
    n: f64,
    layers: &[(Complex64, f64)],
    substrate: Complex64,
    incidence: &Incidence,
) -> Result<Jones> {
    let Incidence { wavelength_nm, theta_i, phi_i } = *incidence;
    let (incident, leaving) = (omega(theta_i, phi_i), omega(-theta_i, -phi_i));
    let inner = layers.iter().map(|layer| layer.0).chain([substrate]).map(Complex64::sqrt);
    let indices: Vec<Complex64> = std::iter::once(n.into()).chain(inner).collect();
    let thickness_nm: Vec<f64> = layers.iter().map(|layer| 1e3 * layer.1).collect();
    let angle = incident.z.acos();
    let amplitude = |polarization| reflect(&indices, &thickness_nm, wavelength_nm, angle, polarization);
    let (r_s, r_p) = (amplitude(Polarization::S)?, amplitude(Polarization::P)?);
    let side = incident.x.hypot(incident.y);
    let s = if side < 1e-12 { DVec3::Y } else { DVec3::new(-incident.y, incident.x, 0.0) / side };
    let columns = [e1(theta_i, phi_i), e2(phi_i)].map(|e| {
        // E along s reflects with r_s; H̃ = −nω×E along s with r_p, and E = −k̂×H̃/n.
        let (along, across) = (r_s * e.dot(s), r_p * incident.cross(e).dot(s));
        let p = leaving.cross(s);
        [e1(-theta_i, -phi_i), e2(-phi_i)].map(|out| along * s.dot(out) + across * p.dot(out))
    });
    Ok([[columns[0][0], columns[1][0]], [columns[0][1], columns[1][1]]])
}
