//! All that a grating evaluates, in the open: what a back end of another kind reads.

use super::places::REACH;
use super::{Grating, LOWEST, RHO, Reflectance};

/// The numbers of a [`Grating`], from which f follows at any wavelength λ (µm in these formulas) and pair of directions:
///
/// ```text
/// f = R(ω_i·h) Γ scale S/(λ² max(1, ρ(ω_i), ρ(ω_o))) + (1 − R(z_i)) (1 − R(z_o)) pigment(λ)/π
/// Γ = (1 + ω_i·ω_o)²/(z_i z_o (z_i + z_o)²),   h the half vector, R Fresnel's reflectance at `index`
/// ```
///
/// S = max(0, Σ w_x w_y Σ_n series T_n(2κ/kappa_most + 1)) at the frequency −(ω_i + ω_o)/λ, κ = −2π(z_i + z_o)/λ, T_n
/// Chebyshev's polynomials, the argument held within ±1. The sum runs over places k, at frequencies k `step` with |k| ≤ `most`:
/// with a `deviation` those within `reach` of it, w = exp(−f²/(2 deviation²)); without, the two about it, w their tents.
///
/// ρ is linear between its places: wavelengths evenly over [`Grating::BAND`]; cosθ at `lowest` + (1 − `lowest`) (j/(J − 1))², lower
/// ones as the lowest; azimuths 2πk/K of (x, y), periodic.
#[derive(Debug, Clone, Copy)]
pub struct GratingTables<'a> {
    /// Refractive index of the surface.
    pub index: f64,
    /// What is beneath.
    pub pigment: &'a Reflectance,
    /// Distance of the places along x and y, 1/µm.
    pub step_per_um: [f64; 2],
    /// Places on either side of frequency 0 along x and y.
    pub most: [usize; 2],
    /// Standard deviation of a place's Gaussian, 1/µm.
    pub deviation_per_um: Option<f64>,
    /// It ends at so many standard deviations along an axis.
    pub reach: f64,
    /// Where the series end, rad/µm.
    pub kappa_most_per_um: f64,
    /// Terms of each series.
    pub terms: usize,
    /// Shape `[f_y, f_x, term]`.
    pub series: &'a [f32],
    /// What sums are multiplied by besides 1/λ², µm².
    pub scale: f64,
    /// Shape `rho_shape`: `[wavelength, cosθ, φ]`.
    pub rho: &'a [f32],
    /// Wavelengths, cosines and azimuths of ρ.
    pub rho_shape: [usize; 3],
    /// Smallest cosθ of ρ.
    pub lowest: f64,
}

impl Grating {
    /// The numbers that it evaluates.
    #[must_use]
    pub fn tables(&self) -> GratingTables<'_> {
        let tabulated = &*self.0;
        let places = &tabulated.places;
        let [cosines, azimuths, waves] = RHO;
        GratingTables {
            index: tabulated.index,
            pigment: &tabulated.pigment,
            step_per_um: places.step,
            most: places.most,
            deviation_per_um: places.deviation(),
            reach: REACH,
            kappa_most_per_um: places.kappa_most(),
            terms: places.terms(),
            series: places.series(),
            scale: tabulated.window,
            rho: &tabulated.rho,
            rho_shape: [waves, cosines, azimuths],
            lowest: LOWEST,
        }
    }
}
