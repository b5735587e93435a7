//! Flat layers at any incidence, for tests: Fresnel's formulas and the recursion from the substrate up.

use super::Incidence;
use crate::Complex64;

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

/// The Jones matrix `[out][in]` of layers (ε, thickness in µm) on a substrate, seen from a medium of index n.
pub(crate) fn jones(
    n: f64,
    layers: &[(Complex64, f64)],
    substrate: Complex64,
    incidence: &Incidence,
) -> [[Complex64; 2]; 2] {
    let [omega, e1, e2] = frame(incidence.theta_i, incidence.phi_i);
    let [out, o1, o2] = frame(-incidence.theta_i, -incidence.phi_i);
    // n² cos²α, without the digits that 1 − cos²α loses near grazing.
    let cosine_squared = n * n * omega[2] * omega[2];
    let k = std::f64::consts::TAU / (incidence.wavelength_nm * 1e-3);
    let q = |eps: Complex64| (eps - n * n + cosine_squared).sqrt();
    let gamma = |p: bool| {
        let admittance = |eps: Complex64| if p { q(eps) / eps } else { q(eps) };
        let mut below = substrate;
        let mut gamma = Complex64::ZERO;
        for &(eps, thickness) in layers.iter().rev() {
            let r = (admittance(eps) - admittance(below)) / (admittance(eps) + admittance(below));
            gamma = (r + gamma) / (1.0 + r * gamma) * (2.0 * Complex64::I * q(eps) * k * thickness).exp();
            below = eps;
        }
        let top = Complex64::from(n * n);
        let r = (admittance(top) - admittance(below)) / (admittance(top) + admittance(below));
        (r + gamma) / (1.0 + r * gamma)
    };
    let (r_s, r_p) = (gamma(false), gamma(true));
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
    [[columns[0][0], columns[1][0]], [columns[0][1], columns[1][1]]]
}
