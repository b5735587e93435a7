//! The light that falls on a section, at points.

use glam::DVec3;

use super::super::beam::{PlaneWave, plane_waves};
use super::shape::Point;
use crate::Complex64;
use crate::scattering::directions::{e1, e2, omega};
use crate::scattering::far_field::{Illumination, Polarization};

/// Plane waves that make up the light of one polarization.
#[derive(Debug, Clone)]
pub(super) struct Incidence {
    waves: Vec<Wave>,
}

#[derive(Debug, Clone, Copy)]
struct Wave {
    /// Wave vector across the barbule (x, z), rad/µm.
    k: [f64; 2],
    amplitude: f64,
    electric: DVec3,
    magnetic: DVec3,
}

impl Incidence {
    /// The waves of [`plane_waves`], each with its own e₁ or e₂.
    pub(super) fn new(
        light: &Illumination,
        polarization: Polarization,
        width_um: f64,
        radius_um: f64,
    ) -> Self {
        let k = light.wave_number_per_um();
        let wave = |phi: f64, amplitude: f64| {
            let (electric, magnetic) = match polarization {
                Polarization::First => (e1(light.theta_i, phi), e2(phi)),
                Polarization::Second => (e2(phi), -e1(light.theta_i, phi)),
            };
            let w = omega(light.theta_i, phi);
            Wave { k: [-k * w.x, -k * w.z], amplitude, electric, magnetic }
        };
        let waves = plane_waves(light, width_um, radius_um);
        Self {
            waves: waves.into_iter().map(|PlaneWave { phi_i, amplitude }| wave(phi_i, amplitude)).collect(),
        }
    }

    /// E_y, H̃_t, H̃_y, E_t at a point.
    pub(super) fn at(&self, point: &Point) -> [Complex64; 4] {
        let mut sum = [Complex64::ZERO; 4];
        let [tx, tz] = point.tangent;
        for wave in &self.waves {
            let phase = wave.k[0] * point.at[0] + wave.k[1] * point.at[1];
            let (sin, cos) = libm::sincos(phase);
            let field = Complex64::new(cos, sin) * wave.amplitude;
            let along = |v: DVec3| v.x * tx + v.z * tz;
            let parts = [wave.electric.y, along(wave.magnetic), wave.magnetic.y, along(wave.electric)];
            for (sum, part) in sum.iter_mut().zip(parts) {
                *sum += field * part;
            }
        }
        sum
    }

    /// How many plane waves there are.
    #[cfg(test)]
    fn count(&self) -> usize {
        self.waves.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scattering::far_field::Window;

    #[test]
    fn a_window_gives_its_gaussian_on_the_plane_through_the_origin() {
        let light = Illumination { wavelength_nm: 500.0, theta_i: 0.4, phi_i: 0.3, window: Window::Gaussian };
        let plane = Illumination { window: Window::PlaneWave, ..light };
        let beam = Incidence::new(&light, Polarization::Second, 20.0, 14.0);
        let wave = Incidence::new(&plane, Polarization::Second, 20.0, 14.0);
        assert!(beam.count() > 20 && wave.count() == 1);
        for x in [-12.0, -3.0, 0.0, 1.0, 7.5] {
            let point = Point { at: [x, 0.0], tangent: [1.0, 0.0] };
            let g = (-(x / 5.0_f64).powi(2)).exp();
            // Each plane wave has its own e₂: across the beam, E_t = cosφ varies by its width in angle.
            let [got, expected] = [beam.at(&point)[1], wave.at(&point)[1]];
            assert!((got - g * expected).norm() < 2e-2, "{x}: {got} {expected}");
            let [got, expected] = [&beam, &wave].map(|light| light.at(&point)[0]);
            assert!((got - g * expected).norm() < 1e-12);
        }
        let first = Incidence::new(&light, Polarization::First, 20.0, 14.0);
        let single = Incidence::new(&plane, Polarization::First, 20.0, 14.0);
        let point = Point { at: [2.0, 0.0], tangent: [1.0, 0.0] };
        let g = (-(2.0 / 5.0_f64).powi(2)).exp();
        assert!((first.at(&point)[0] - g * single.at(&point)[0]).norm() < 1e-12);
    }
}
