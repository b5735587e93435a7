//! Gratings: what a heightfield makes of light, by the scalar Kirchhoff integral over its patch.
//!
//! With q = (u, v, w) = −ω_i − ω_o and p(x, y) = e^{jkwh} of a patch that repeats with the periods T, seen through a Gaussian
//! window of coherence,
//!
//! ```text
//! P(u, v) = Σ_j c_j e^{−|(u, v)/λ − j/T|²/(2 s_f²)},   c_j = 1/N Σ_x p(x) e^{+2πi j·x/T},   s_f = 1/(2π s_s),
//! f = R Γ |P|²/(λ² π s_f²),
//! ```
//!
//! so that a flat patch reflects as a mirror does: ∫ f cosθ_o dω_o = R. Everything about a patch is P, a function of the
//! frequency (u, v)/λ and of κ = kw alone, which [`Powers`] keep for any wavelength, and [`Tables`] once integrated over a
//! light's wavelengths. Sources: Stam, *Diffraction Shaders*, SIGGRAPH 1999; Dhillon et al., *Interactive Diffraction from
//! Biological Nanostructures*, 2014. Here angles are polar ones from the surface's normal z.

mod powers;
mod tables;

use std::f64::consts::{PI, SQRT_2, TAU};

use glam::DVec3;

pub use powers::{Orders, Powers, Taps};
pub use tables::{Basis, Cell, GREATEST_SIZE, MOST_TABLES, TableGrid, Tables, check_size, interpolated};

use crate::fresnel::fresnel;
use crate::{Error, Result};

/// Windows of coherence end at so many s_f from their middle: amplitudes there are e⁻⁸.
pub const WINDOW: f64 = 4.0;

/// Angular radius of the sun's disc, rad.
pub const SUN_RADIUS: f64 = 0.004_65;

/// What the reflected amplitude is weighed by besides the reflectance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Obliquity {
    /// (1 + ω_i·ω_o)²/(cosθ_i cosθ_o (cosθ_i + cosθ_o)²): Kirchhoff's, Stam's.
    Kirchhoff,
    /// (cosθ_i + cosθ_o)²/(4 cosθ_i cosθ_o): the generalized Harvey–Shack form made reciprocal.
    Reciprocal,
    /// cosθ_o/cosθ_i: generalized Harvey–Shack; not reciprocal.
    HarveyShack,
    /// 1.
    Radiance,
}

impl Obliquity {
    /// Every form with its name.
    pub const ALL: [(&'static str, Self); 4] = [
        ("kirchhoff", Self::Kirchhoff),
        ("reciprocal", Self::Reciprocal),
        ("harvey-shack", Self::HarveyShack),
        ("radiance", Self::Radiance),
    ];

    /// Γ between two directions over the surface.
    #[inline]
    #[must_use]
    pub fn weight(self, w_i: DVec3, w_o: DVec3) -> f64 {
        let (cos_i, cos_o) = (w_i.z, w_o.z);
        match self {
            Self::Kirchhoff => {
                let both = cos_i + cos_o;
                (1.0 + w_i.dot(w_o)).powi(2) / (cos_i * cos_o * both * both)
            }
            Self::Reciprocal => (cos_i + cos_o).powi(2) / (4.0 * cos_i * cos_o),
            Self::HarveyShack => cos_o / cos_i,
            Self::Radiance => 1.0,
        }
    }
}

/// How far across light is coherent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Coherence {
    /// Standard deviation s_s of the window on the field, µm.
    Fixed(f64),
    /// A disc of this angular radius, rad: the window narrows with the wavelength so that a mirror's lobe is as wide as the disc.
    Disc(f64),
}

impl Coherence {
    /// 65 µm, the side of the coherence area of filtered sunlight, are four standard deviations.
    pub const USUAL: Self = Self::Fixed(16.25);
    /// As wide as the sun.
    pub const SUN: Self = Self::Disc(SUN_RADIUS);

    /// Standard deviation s_s of the window at a wavelength, µm.
    #[must_use]
    pub fn deviation_um(self, wavelength_um: f64) -> f64 {
        match self {
            Self::Fixed(deviation) => deviation,
            Self::Disc(radius) => wavelength_um / (SQRT_2 * PI * radius),
        }
    }

    /// Standard deviation s_f of the window over frequencies, 1/µm.
    #[must_use]
    pub fn frequency_per_um(self, wavelength_um: f64) -> f64 {
        1.0 / (TAU * self.deviation_um(wavelength_um))
    }
}

/// Whether the window stands at one place, or anywhere in the mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// At this place of the patch, µm: orders interfere, speckles.
    At([f64; 2]),
    /// The mean over all places: orders add up as powers.
    Anywhere,
}

/// What f means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Normalization {
    /// A BRDF, 1/sr.
    Energy,
    /// The seed's: relative to a mirror's own peak at each wavelength; 1 at the specular direction of a flat patch at normal
    /// incidence.
    Relative,
}

/// How a patch is lit and seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    /// Weight of directions.
    pub obliquity: Obliquity,
    /// Coherence of the light.
    pub coherence: Coherence,
    /// Of the window.
    pub place: Place,
    /// What is computed.
    pub normalization: Normalization,
    /// Refractive index of the surface.
    pub index: f64,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            obliquity: Obliquity::Kirchhoff,
            coherence: Coherence::USUAL,
            place: Place::At([0.0; 2]),
            normalization: Normalization::Energy,
            index: 1.5,
        }
    }
}

impl Setup {
    /// Refuses what makes no sense.
    ///
    /// # Errors
    /// A coherence or a refractive index out of range, a place that is not finite.
    pub fn check(&self) -> Result<()> {
        let (name, value, low, high) = match self.coherence {
            Coherence::Fixed(deviation) => ("coherence, µm,", deviation, 0.5, 1000.0),
            Coherence::Disc(radius) => ("radius of the light, rad,", radius, 1e-4, 0.2),
        };
        if !(low..=high).contains(&value) {
            return Err(Error::input(format!("the {name} is {value}; give {low} to {high}")));
        }
        if !(1.01..=4.0).contains(&self.index) {
            return Err(Error::input(format!("the refractive index is {}; give 1.01 to 4", self.index)));
        }
        match self.place {
            Place::At(place) if !place.iter().all(|x| x.abs() <= 1e6) => {
                Err(Error::input(format!("the window's place {}, {} µm is too far away", place[0], place[1])))
            }
            _ => Ok(()),
        }
    }

    /// What |P|² is multiplied by at every wavelength alike: R Γ, and for relative values what brings a mirror's peak to 1. 0
    /// below the surface.
    #[must_use]
    pub fn of_directions(&self, w_i: DVec3, w_o: DVec3) -> f64 {
        if w_i.z <= 0.0 || w_o.z <= 0.0 {
            return 0.0;
        }
        let half = (w_i + w_o).normalize();
        let weight = fresnel(w_i.dot(half), self.index) * self.obliquity.weight(w_i, w_o);
        match self.normalization {
            Normalization::Energy => weight,
            Normalization::Relative => weight / fresnel(1.0, self.index) * w_i.z,
        }
    }

    /// What it is multiplied by at a wavelength besides: 1/(λ² π s_f²), or 1 for relative values.
    #[must_use]
    pub fn of_wavelength(&self, wavelength_um: f64) -> f64 {
        match self.normalization {
            Normalization::Energy => {
                let s_f = self.coherence.frequency_per_um(wavelength_um);
                1.0 / (wavelength_um * wavelength_um * PI * s_f * s_f)
            }
            Normalization::Relative => 1.0,
        }
    }
}

/// (u, v, w) = −ω_i − ω_o.
#[must_use]
pub fn q(w_i: DVec3, w_o: DVec3) -> DVec3 {
    -(w_i + w_o)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At a mirror's pair all forms are 1, and the reciprocal ones are the same there and back.
    #[test]
    fn obliquities_are_one_at_the_mirror() {
        let (a, b) = (DVec3::new(0.3, 0.2, 1.0).normalize(), DVec3::new(-0.7, 0.1, 0.6).normalize());
        let mirror = DVec3::new(-a.x, -a.y, a.z);
        for (name, form) in Obliquity::ALL {
            assert!((form.weight(a, mirror) - 1.0).abs() < 1e-12, "{name}");
            let apart = (form.weight(a, b) - form.weight(b, a)).abs();
            assert_eq!(apart < 1e-12, form != Obliquity::HarveyShack, "{name}: {apart}");
        }
    }

    /// The lobe of a mirror, std λ s_f/√2 per axis of direction cosines, is half as wide as a disc's radius.
    #[test]
    fn a_disc_has_the_same_lobe_at_all_wavelengths() {
        for um in [0.4, 0.7] {
            let lobe = um * Coherence::SUN.frequency_per_um(um) / SQRT_2;
            assert!((lobe / (0.5 * SUN_RADIUS) - 1.0).abs() < 1e-12, "{lobe}");
        }
    }

    #[test]
    fn setups_out_of_range_are_refused() {
        let usual = Setup::default();
        usual.check().unwrap();
        for bad in [
            Setup { index: 1.0, ..usual },
            Setup { coherence: Coherence::Fixed(0.0), ..usual },
            Setup { coherence: Coherence::Disc(f64::NAN), ..usual },
            Setup { place: Place::At([f64::INFINITY, 0.0]), ..usual },
        ] {
            assert!(bad.check().unwrap_err().is_input());
        }
    }
}
