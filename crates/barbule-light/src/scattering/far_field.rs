//! Light on one barbule and the far field that it makes: what every wave solver takes and gives.
//!
//! A barbule is invariant along y, so light of longitudinal angle θ_i leaves on its specular cone: at −θ_i, towards any
//! azimuth φ_o. There the field is 𝓔 = 𝓔₁ e₁ + 𝓔₂ e₂ times a cylindrical wave, a trigonometric polynomial in φ_o whose
//! orders end near κ times the barbule's radius.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

use super::directions::azimuths;
use crate::math::band_limited::NODES_PER_PERIOD;
use crate::math::fft::fast_length;
use crate::spectrum::wave_number_per_um;

/// Which way the incident electric field points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Polarization {
    /// Along e₁, polarization 1.
    First,
    /// Along e₂, polarization 2.
    Second,
}

impl Polarization {
    /// Both, in the order of every array's axis `polarization`.
    pub const BOTH: [Self; 2] = [Self::First, Self::Second];

    /// Its place on that axis.
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }
}

/// How far across the light falls on a section.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Window {
    /// g(x) = exp(−x²/(W/4)²) with the section's width W on the top as it is: light of limited coherence on a finite barbule.
    Gaussian,
    /// The beam whose field on z = 0 is g(x) times the plane wave's: Maxwell's equations allow no field that is g on a top that is
    /// not flat. It comes slanting, so that at φ_i = 60° a hill of 1 µm takes what belongs to a place 1.7 µm beside it.
    Beam,
    /// A plane wave on the whole section.
    PlaneWave,
}

impl Window {
    /// Factor to the plane wave's field at a point of the top of a section; of the plane waves of a beam, one.
    #[inline]
    #[must_use]
    pub fn at(self, x_um: f64, width_um: f64) -> f64 {
        match self {
            Self::Gaussian => (-(x_um / (width_um / 4.0)).powi(2)).exp(),
            Self::Beam | Self::PlaneWave => 1.0,
        }
    }

    /// The light whose incident power is Φ_i, µm, where it has one.
    #[must_use]
    pub fn light(self, power_um: f64) -> IncidentLight {
        match self {
            Self::Gaussian | Self::Beam => IncidentLight::Beam { power_um },
            Self::PlaneWave => IncidentLight::PlaneWave,
        }
    }
}

/// Light of unit |E| at the origin from one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Illumination {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Longitudinal angle of incidence, rad, |θ_i| < π/2.
    pub theta_i: f64,
    /// Azimuth of incidence, rad.
    pub phi_i: f64,
    /// How far across it falls.
    pub window: Window,
}

impl Illumination {
    /// The vacuum wave number k, rad/µm.
    #[must_use]
    pub fn wave_number_per_um(&self) -> f64 {
        wave_number_per_um(self.wavelength_nm)
    }
}

/// The light to which amplitudes belong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum IncidentLight {
    /// Light through a window: amplitudes are over √Φ_i.
    Beam {
        /// Φ_i, the incident power per length for c₀ = 1 and unit |E|, µm.
        power_um: f64,
    },
    /// A plane wave: amplitudes belong to unit |E|.
    PlaneWave,
}

impl IncidentLight {
    /// What fields for unit |E| are multiplied by to give amplitudes: 1/√Φ_i, zero where no light arrives, for a beam; 1 for
    /// a plane wave.
    #[must_use]
    pub fn scale(self) -> f64 {
        match self {
            Self::Beam { power_um } if power_um > 0.0 => power_um.sqrt().recip(),
            Self::Beam { .. } => 0.0,
            Self::PlaneWave => 1.0,
        }
    }
}

/// Equidistant outgoing azimuths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Azimuths {
    /// So many over the upper half of the cone: (n + ½)·180°/N − 90°.
    UpperHalf(usize),
    /// So many over all of it: n·360°/N − 180°.
    FullCircle(usize),
}

impl Azimuths {
    /// The azimuths, rad, rising.
    #[must_use]
    pub fn phi_o(self) -> Vec<f64> {
        match self {
            Self::UpperHalf(count) => azimuths(count).collect(),
            Self::FullCircle(count) => (0..count).map(|n| n as f64 * TAU / count as f64 - PI).collect(),
        }
    }

    /// The angle between neighbours, rad.
    #[must_use]
    pub fn step(self) -> f64 {
        match self {
            Self::UpperHalf(count) => PI / count as f64,
            Self::FullCircle(count) => TAU / count as f64,
        }
    }
}

/// The far field of one instance for one incident direction and both incident polarizations.
#[derive(Debug, Clone, PartialEq)]
pub struct FarField {
    /// The light that it belongs to.
    pub light: IncidentLight,
    /// θ_i, rad.
    pub theta_i: f64,
    /// Outgoing azimuths.
    pub azimuths: Azimuths,
    /// 𝓔₁ and 𝓔₂, `[incident polarization][e₁, e₂][azimuth]`: rad^−½ over √Φ_i for a beam, √µm for a plane wave.
    pub amplitudes: [[Vec<Complex64>; 2]; 2],
    /// cosθ_i ∫|𝓔|² dφ_o over the azimuths' range, by incident polarization, from a grid that resolves it: a part of
    /// Φ_i for a beam, µm for a plane wave.
    pub radiated: [f64; 2],
}

impl FarField {
    /// Radiant intensity c₀|𝓔|²/Φ_i, rad⁻¹, `[azimuth]`; `None` for a plane wave, whose power has no bound.
    #[must_use]
    pub fn intensity(&self, polarization: Polarization) -> Option<Vec<f64>> {
        match self.light {
            IncidentLight::Beam { .. } => Some(self.scaled(polarization, 1.0)),
            IncidentLight::PlaneWave => None,
        }
    }

    /// Differential scattering width dσ/dφ_o = cosθ_i c₀|𝓔|² for unit |E|, µm/rad, `[azimuth]`.
    #[must_use]
    pub fn differential_width_um(&self, polarization: Polarization) -> Vec<f64> {
        self.scaled(polarization, self.theta_i.cos() * self.squared_amplitude_um())
    }

    /// What is scattered per radian of azimuth, `[azimuth]`: [`Self::intensity`], rad⁻¹, of a beam;
    /// [`Self::differential_width_um`], µm/rad, of a plane wave.
    #[must_use]
    pub fn per_radian(&self, polarization: Polarization) -> Vec<f64> {
        self.intensity(polarization).unwrap_or_else(|| self.differential_width_um(polarization))
    }

    /// Φ_r/Φ_i, the part of the light that leaves over these azimuths; `None` for a plane wave.
    #[must_use]
    pub fn reflected_fraction(&self, polarization: Polarization) -> Option<f64> {
        match self.light {
            IncidentLight::Beam { .. } => Some(self.radiated[polarization.index()]),
            IncidentLight::PlaneWave => None,
        }
    }

    /// The scattering width over these azimuths, ∫dσ, µm: the scattered power per length for unit |E|.
    #[must_use]
    pub fn scattering_width_um(&self, polarization: Polarization) -> f64 {
        self.squared_amplitude_um() * self.radiated[polarization.index()]
    }

    /// What turns squares of the amplitudes into those for unit |E|, µm.
    fn squared_amplitude_um(&self) -> f64 {
        match self.light {
            IncidentLight::Beam { power_um } => power_um,
            IncidentLight::PlaneWave => 1.0,
        }
    }

    fn scaled(&self, polarization: Polarization, scale: f64) -> Vec<f64> {
        let [e1, e2] = &self.amplitudes[polarization.index()];
        e1.iter().zip(e2).map(|(a, b)| scale * (a.norm_sqr() + b.norm_sqr())).collect()
    }
}

/// Fourier coefficients over the azimuth that carry the far field of sources within `radius_um` of the origin, for the
/// transverse wave number `kappa` (rad/µm): a length that transforms fast, orders −N/2 … N/2 − 1.
#[must_use]
pub fn coefficients(kappa: f64, radius_um: f64) -> usize {
    fast_length((2.1 * kappa * radius_um + 40.0).ceil() as usize)
}

/// How many times finer than `count` azimuths of the upper half a field of so many Fourier coefficients is sampled: the
/// least odd number (grids then nest) at which intensities are resolved and fields can be interpolated.
#[must_use]
pub fn refinement(coefficients: usize, count: usize) -> usize {
    let band = coefficients / 2;
    let least = (NODES_PER_PERIOD * band as f64 / (2 * count) as f64).ceil() as usize;
    least.max(1) | 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uniform(light: IncidentLight) -> FarField {
        let azimuths = Azimuths::FullCircle(8);
        let row = || vec![Complex64::new(0.0, 0.5); 8];
        let amplitudes = [[row(), row()], [row(), row()]];
        let radiated = [0.5 * TAU * 0.6_f64.cos(); 2];
        FarField { light, theta_i: 0.6, azimuths, amplitudes, radiated }
    }

    #[test]
    fn grids_are_those_of_their_formulas() {
        let degrees = |azimuths: Azimuths| -> Vec<f64> {
            azimuths.phi_o().iter().map(|phi| phi.to_degrees().round()).collect()
        };
        assert_eq!(degrees(Azimuths::UpperHalf(3)), [-60.0, 0.0, 60.0]);
        assert_eq!(degrees(Azimuths::FullCircle(4)), [-180.0, -90.0, 0.0, 90.0]);
    }

    #[test]
    fn widths_integrate_to_what_is_radiated_whatever_the_light() {
        for (light, power_um) in
            [(IncidentLight::PlaneWave, 1.0), (IncidentLight::Beam { power_um: 7.0 }, 7.0)]
        {
            let far = uniform(light);
            for polarization in Polarization::BOTH {
                let sum: f64 = far.differential_width_um(polarization).iter().sum();
                let width = far.scattering_width_um(polarization);
                assert!((sum * far.azimuths.step() / width - 1.0).abs() < 1e-14);
                assert!((width / power_um - 0.5 * TAU * 0.6_f64.cos()).abs() < 1e-14);
                let beam = light != IncidentLight::PlaneWave;
                assert_eq!(far.intensity(polarization), beam.then(|| vec![0.5; 8]));
                assert_eq!(far.reflected_fraction(polarization).is_some(), beam);
            }
        }
    }
}
