//! The cone of directions over which the light of one (λ, θ_i) leaves.

use super::Barbule;
use crate::scattering::far_field::{coefficients, refinement};
use crate::spectrum::wave_number_per_um;

/// The specular cone of one (λ, θ_i): its angles and constants.
#[derive(Debug, Clone)]
pub struct Cone {
    /// θ_i, rad.
    pub(super) theta_i: f64,
    /// Transverse wave number κ = k cosθ_i, rad/µm.
    pub(super) kappa: f64,
    /// Vacuum wave number, rad/µm.
    pub(super) k: f64,
    /// N, the number of angles and of Fourier coefficients.
    pub(super) angles: usize,
    pub(super) sin_phi: Vec<f64>,
    pub(super) cos_phi: Vec<f64>,
}

impl Cone {
    /// For a vacuum wavelength (nm), θ_i (rad) and any of these barbules.
    #[must_use]
    pub fn around(barbules: &[Barbule], wavelength_nm: f64, theta_i: f64) -> Self {
        let radius_um = barbules.iter().fold(0f64, |r, barbule| r.max(barbule.points.radius_um));
        Self::new(wavelength_nm, theta_i, radius_um)
    }

    /// For a structure that stays within `radius_um` of the origin.
    #[must_use]
    pub fn new(wavelength_nm: f64, theta_i: f64, radius_um: f64) -> Self {
        let k = wave_number_per_um(wavelength_nm);
        let kappa = k * theta_i.cos();
        let angles = coefficients(kappa, radius_um);
        let step = std::f64::consts::TAU / angles as f64;
        let (sin_phi, cos_phi) = (0..angles / 2).map(|j| (j as f64 * step).sin_cos()).unzip();
        Self { theta_i, kappa, k, angles, sin_phi, cos_phi }
    }

    /// θ_i, rad.
    #[must_use]
    pub fn theta_i(&self) -> f64 {
        self.theta_i
    }

    /// How many times finer than `azimuths` over the upper half fields must be sampled; odd, so that grids nest.
    #[must_use]
    pub fn refinement(&self, azimuths: usize) -> usize {
        refinement(self.angles, azimuths)
    }
}
