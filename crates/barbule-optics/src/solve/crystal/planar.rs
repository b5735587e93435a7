//! Flat layers at any incidence as a Jones matrix: what crystals must become whose rods are of the host's own index or
//! fill the period. The amplitudes are those of [`film`](crate::solve::film).

use super::Incidence;
use crate::solve::film::{Polarization, reflect};
use crate::{Complex64, Result};

type Vector = [Complex64; 3];

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Vector, b: Vector) -> Complex64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// (ω, e₁, e₂) of a direction.
fn frame(theta: f64, phi: f64) -> [Vector; 3] {
    let ((st, ct), (sp, cp)) = (theta.sin_cos(), phi.sin_cos());
    [[ct * sp, st, ct * cp], [-st * sp, ct, -st * cp], [cp, 0.0, -sp]].map(|v| v.map(Complex64::from))
}

/// The Jones matrix `[out][in]` of `layers` (ε, thickness in µm) on a substrate, seen from a medium of index `n`.
///
/// # Errors
/// As [`reflect`].
pub fn jones(
    n: f64,
    layers: &[(Complex64, f64)],
    substrate: Complex64,
    incidence: &Incidence,
) -> Result<[[Complex64; 2]; 2]> {
    let [omega, e1, e2] = frame(incidence.theta_i, incidence.phi_i);
    let [out, o1, o2] = frame(-incidence.theta_i, -incidence.phi_i);
    let inner = layers.iter().map(|layer| layer.0).chain([substrate]).map(Complex64::sqrt);
    let indices: Vec<Complex64> = std::iter::once(n.into()).chain(inner).collect();
    let thickness_nm: Vec<f64> = layers.iter().map(|layer| 1e3 * layer.1).collect();
    let angle = omega[2].re.acos();
    let amplitude =
        |polarization| reflect(&indices, &thickness_nm, incidence.wavelength_nm, angle, polarization);
    let (r_s, r_p) = (amplitude(Polarization::S)?, amplitude(Polarization::P)?);
    let side = (omega[0] * omega[0] + omega[1] * omega[1]).sqrt();
    let s: Vector = if side.norm() < 1e-12 {
        [Complex64::ZERO, Complex64::ONE, Complex64::ZERO]
    } else {
        [-omega[1] / side, omega[0] / side, Complex64::ZERO]
    };
    let columns = [e1, e2].map(|e| {
        // E along s reflects with r_s; H̃ = −nω×E along s with r_p, and E = −k̂×H̃/n.
        let h = cross(omega, e).map(|x| -n * x);
        let p = cross(out, s).map(|x| -r_p * dot(h, s) * x / n);
        let reflected: Vector = std::array::from_fn(|i| r_s * dot(e, s) * s[i] + p[i]);
        [dot(reflected, o1), dot(reflected, o2)]
    });
    Ok([[columns[0][0], columns[1][0]], [columns[0][1], columns[1][1]]])
}
