//! Directions of the barbule's frame: x across, y along, z out of the top.

use glam::DVec3;

/// Azimuths that fields keep beyond either horizon, for interpolation next to it.
pub const AZIMUTH_MARGIN: usize = 4;

/// ω = (cosθ sinφ, sinθ, cosθ cosφ), away from the surface; θ the longitudinal angle, φ the azimuth, rad.
#[must_use]
pub fn omega(theta: f64, phi: f64) -> DVec3 {
    let (sin_theta, cos_theta) = theta.sin_cos();
    let (sin_phi, cos_phi) = phi.sin_cos();
    DVec3::new(cos_theta * sin_phi, sin_theta, cos_theta * cos_phi)
}

/// e₁ = ∂ω/∂θ: the electric field's direction in polarization 1.
#[must_use]
pub fn e1(theta: f64, phi: f64) -> DVec3 {
    let (sin_theta, cos_theta) = theta.sin_cos();
    let (sin_phi, cos_phi) = phi.sin_cos();
    DVec3::new(-sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
}

/// e₂ = (cosφ, 0, −sinφ): the electric field's direction in polarization 2.
#[must_use]
pub fn e2(phi: f64) -> DVec3 {
    let (sin_phi, cos_phi) = phi.sin_cos();
    DVec3::new(cos_phi, 0.0, -sin_phi)
}

/// The azimuths (n + ½)·π/`count` − π/2 at which fields over the upper half of the specular cone are tabulated, rad.
pub fn azimuths(count: usize) -> impl Iterator<Item = f64> + Clone {
    use std::f64::consts::{FRAC_PI_2, PI};
    (0..count).map(move |n| (n as f64 + 0.5) * PI / count as f64 - FRAC_PI_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn omega_e1_e2_are_orthonormal_and_e1_is_the_derivative() {
        let (theta, phi) = (0.3, -0.7);
        let (w, a, b) = (omega(theta, phi), e1(theta, phi), e2(phi));
        for (value, expected) in [
            (w.dot(a), 0.0),
            (w.dot(b), 0.0),
            (a.dot(b), 0.0),
            (w.dot(w), 1.0),
            (a.dot(a), 1.0),
            (b.dot(b), 1.0),
        ] {
            assert!((value - expected).abs() < 1e-15);
        }
        let step = 1e-6;
        let derivative = (omega(theta + step, phi) - omega(theta - step, phi)) / (2.0 * step);
        assert!((derivative - a).length() < 1e-9);
    }
}
