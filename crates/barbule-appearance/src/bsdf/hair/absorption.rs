//! What a fibre absorbs: optical depth of one radius, by wavelength.

use std::f64::consts::{FRAC_PI_2, PI};

use super::FibreIndex;
use crate::bsdf::reflectance::Reflectance;
use crate::fresnel::fresnel;
use crate::material::ExponentialAbsorption;
use crate::spectrum::dense::{DenseSpectrum, Lambdas, WAVES};
use crate::{Error, Result};

/// Absorption of a fibre's inside: the optical depth σ_a r of one radius at every nm.
///
/// Per radius, not per length: scattering by a fibre knows no scale. Who has an absorption per µm multiplies it by the
/// radius in µm. Of an elliptical section the radius is its half width.
#[derive(Debug, Clone, PartialEq)]
pub struct Absorption {
    depth: DenseSpectrum,
}

/// Eumelanin of concentration 1: optical depth of one radius at 540 nm, and the exponent of its power law.
///
/// The exponents are those of Donner & Jensen 2006 (*A spectral BSSRDF for shading human skin*). The scale makes a
/// concentration mean what it means in other renderers, whose red, green and blue (0.419, 0.697, 1.37 and 0.187, 0.4,
/// 1.05) these laws give at 630, 540 and 445 nm within 5 %.
const EUMELANIN: (f64, f64) = (0.697, 3.33);
/// Pheomelanin, likewise.
const PHEOMELANIN: (f64, f64) = (0.4, 4.75);

/// Vanes of n fibres over a place in the mean, of optical depth d, evenly lit from all sides: of what is not gloss their covered part
/// keeps exp(−a nᵇ d/(1 + c n √d)), within 0.026 for vanes of contour feathers, coverts, primaries, secondaries and tails
/// (docs/theory/hair.md).
const VANE_SCALE: f64 = 2.95;
const VANE_POWER: f64 = 1.11;
const VANE_BEND: f64 = 0.734;
/// What of their surfaces' reflection fibres of closed vanes show; the rest of it meets other fibres. A lone fibre shows all.
const VANE_OPEN: f64 = 0.4;
/// Places across a fibre at which its surface's reflection is taken.
const ACROSS: u32 = 64;
/// Deeper absorption changes nothing that is seen.
const VANE_MOST: f64 = 8.0;
/// Halvings of that until nothing is left.
const VANE_HALVINGS: u32 = 44;

fn vane_depth(depth: f64, cover: f64) -> f64 {
    VANE_SCALE * libm::pow(cover, VANE_POWER) * depth / (1.0 + VANE_BEND * cover * depth.sqrt())
}

/// What surfaces of a round fibre of this index reflect of even light, seen across: Fresnel's reflectance in the mean over the width, 7.6 %
/// for 1.56.
fn surface_reflectance(index: f64) -> f64 {
    // By the angle γ at which the place's normal leans, for which its offset is sin γ: at the edge F rises like a root of the offset.
    let step = FRAC_PI_2 / f64::from(ACROSS);
    let at = |k: u32| {
        let cosine = libm::cos((f64::from(k) + 0.5) * step);
        fresnel(cosine, index) * cosine
    };
    (0..ACROSS).map(at).sum::<f64>() * step
}

/// What the covered part of a vane of black fibres reflects of light that is the same from everywhere.
fn vane_gloss(cover: f64, index: f64) -> f64 {
    surface_reflectance(index) * (VANE_OPEN + (1.0 - VANE_OPEN) * libm::exp(-cover))
}

impl Absorption {
    /// From the optical depth of one radius as a function of the wavelength in nm.
    ///
    /// # Errors
    /// A value that is negative or not finite.
    pub fn new(depth: impl Fn(f64) -> f64) -> Result<Self> {
        let depth = DenseSpectrum::new(depth);
        if depth.values().iter().any(|v| !v.is_finite() || *v < 0.0) {
            return Err(Error::input(
                "a fibre's absorption must be finite and not negative at every wavelength",
            ));
        }
        Ok(Self { depth })
    }

    /// Pigments of human hair by their concentrations: 0.3 of eumelanin is blond, 1.3 brown, 8 black; pheomelanin
    /// reddens.
    ///
    /// # Errors
    /// A concentration that is negative or not finite.
    pub fn pigments(eumelanin: f64, pheomelanin: f64) -> Result<Self> {
        if ![eumelanin, pheomelanin].iter().all(|c| c.is_finite() && *c >= 0.0) {
            return Err(Error::input(format!(
                "eumelanin of {eumelanin} and pheomelanin of {pheomelanin}: concentrations must be finite and not negative"
            )));
        }
        let law = |(depth, exponent): (f64, f64), w: f64| depth * libm::pow(540.0 / w, exponent);
        Self::new(|w| eumelanin * law(EUMELANIN, w) + pheomelanin * law(PHEOMELANIN, w))
    }

    /// Keratin of which a share is melanin granules: σ_a = f 4πk/λ with [melanin's k](ExponentialAbsorption::MELANIN);
    /// pure melanin has 1.67 /µm at 550 nm. Black barbules have 0.2 to 0.4.
    ///
    /// - `share`: of the volume, 0 … 1
    /// - `radius_um`: of the fibre
    ///
    /// # Errors
    /// A share outside 0 … 1, or a radius that is not over 0.
    pub fn melanin(share: f64, radius_um: f64) -> Result<Self> {
        if !((0.0..=1.0).contains(&share) && radius_um > 0.0 && radius_um.is_finite()) {
            return Err(Error::input(format!(
                "melanin's share of {share} in a fibre of radius {radius_um} um: give a share of 0 to 1 and a radius over 0"
            )));
        }
        let of = ExponentialAbsorption::MELANIN;
        Self::new(|w| share * radius_um * 4.0 * PI * of.c * of.decay(w) / (1e-3 * w))
    }

    /// What gives a mass of fibres this reflectance after all their scatterings: the fit of Chiang et al. 2016, §4.2, to
    /// simulated hair of this azimuthal roughness.
    ///
    /// # Errors
    /// A reflectance of 0 somewhere.
    pub fn of_reflectance(reflectance: &Reflectance, azimuthal_roughness: f64) -> Result<Self> {
        let scale = mass_scale(azimuthal_roughness);
        Self::new(|w| {
            let root = libm::log(reflectance.at(w)) / scale;
            root * root
        })
    }

    /// What a mass of such fibres reflects: [`Absorption::of_reflectance`] the other way round.
    ///
    /// # Errors
    /// None of an absorption that is not below 0.
    pub fn mass_reflectance(&self, azimuthal_roughness: f64) -> Result<Reflectance> {
        let scale = mass_scale(azimuthal_roughness);
        Reflectance::new(|w| libm::exp(-scale * self.at(w).max(0.0).sqrt()))
    }

    /// What makes closed vanes of such fibres, on white in even light, reflect this: the fit of `docs/theory/hair.md` to rendered
    /// vanes of five types. Gaps of the vane are no part of it.
    ///
    /// - `cover`: how many fibres lie over a place of the vane in the mean
    /// - `index`: the fibres', whose surfaces alone black vanes show
    ///
    /// # Errors
    /// A cover that is not over 0.
    pub fn of_vane(reflectance: &Reflectance, cover: f64, index: FibreIndex) -> Result<Self> {
        if !(cover > 0.0 && cover.is_finite()) {
            return Err(Error::input(format!(
                "a vane with {cover} fibres over a place: give a number over 0"
            )));
        }
        let most = vane_depth(VANE_MOST, cover);
        Self::new(|w| {
            let gloss = vane_gloss(cover, index.at(w));
            let through = ((reflectance.at(w) - gloss) / (1.0 - gloss)).max(f64::MIN_POSITIVE);
            let wanted = (-libm::log(through)).clamp(0.0, most);
            let (mut low, mut high) = (0.0, VANE_MOST);
            for _ in 0..VANE_HALVINGS {
                let middle = 0.5 * (low + high);
                if vane_depth(middle, cover) < wanted { low = middle } else { high = middle }
            }
            0.5 * (low + high)
        })
    }

    /// Optical depth of one radius at a wavelength, nm.
    #[inline]
    #[must_use]
    pub fn at(&self, wavelength_nm: f64) -> f64 {
        self.depth.at(wavelength_nm)
    }

    /// At the wavelengths of a path.
    #[inline(always)]
    #[must_use]
    pub fn at_each(&self, wavelengths: Lambdas) -> [f64; WAVES] {
        self.depth.at_each(wavelengths)
    }
}

/// −ln ρ over the root of the absorption.
fn mass_scale(azimuthal_roughness: f64) -> f64 {
    let b = azimuthal_roughness;
    5.969 + b * (-0.215 + b * (2.532 + b * (-10.73 + b * (5.574 + b * 0.245))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masses_of_fibres_reflect_what_their_absorption_is_of() {
        let grey = Reflectance::new(|nm| 0.1 + nm / 2000.0).unwrap();
        let back = Absorption::of_reflectance(&grey, 0.4).unwrap().mass_reflectance(0.4).unwrap();
        assert!([400.0, 550.0, 700.0].iter().all(|nm| (back.at(*nm) - grey.at(*nm)).abs() < 1e-9));
    }

    /// The power laws against the three numbers that renderers use, each at its band's middle.
    #[test]
    fn pigments_are_those_of_other_renderers_in_red_green_and_blue() {
        for (pigments, expected) in [((1.0, 0.0), [0.419, 0.697, 1.37]), ((0.0, 1.0), [0.187, 0.4, 1.05])] {
            let absorption = Absorption::pigments(pigments.0, pigments.1).unwrap();
            for (wavelength, value) in [630.0, 540.0, 445.0].into_iter().zip(expected) {
                let ratio = absorption.at(wavelength) / value;
                assert!((ratio - 1.0).abs() < 0.05, "{wavelength} nm: {ratio}");
            }
        }
    }

    #[test]
    fn pure_melanin_absorbs_what_the_literature_says() {
        assert!((Absorption::melanin(1.0, 1.0).unwrap().at(550.0) - 1.67).abs() < 0.005);
        assert!((Absorption::melanin(0.25, 8.0).unwrap().at(550.0) - 3.34).abs() < 0.01);
    }

    /// A vane's gloss is that of its surfaces: all of a lone fibre's, which black hair seen across keeps (the mean over a round fibre's
    /// width of Fresnel's reflectance, by a rule of another kind), and less of it the more of them lie over each other. What is
    /// no brighter is black.
    #[test]
    fn vanes_are_no_darker_than_their_surfaces() {
        // With h = sin γ the mean is ∫ F cos γ dγ, by Simpson's rule.
        let steps = 400;
        let turn = |k: i32| 0.5 * PI * f64::from(k) / f64::from(steps);
        let part = |k: i32| fresnel(turn(k).cos(), 1.56) * turn(k).cos();
        let weight = |k: i32| if k == 0 || k == steps { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
        let simpson = (0..=steps).map(|k| weight(k) * part(k)).sum::<f64>() * turn(1) / 3.0;
        assert!(
            (surface_reflectance(1.56) - simpson).abs() < 1e-4,
            "{} {simpson}",
            surface_reflectance(1.56)
        );
        assert!((vane_gloss(1e-9, 1.56) / simpson - 1.0).abs() < 2e-3);
        let index = FibreIndex::Constant(1.56);
        let depth = |reflectance: f64, cover: f64| {
            let even = Reflectance::new(|_| reflectance).unwrap();
            Absorption::of_vane(&even, cover, index).unwrap().at(550.0)
        };
        for cover in [0.3, 1.2, 2.6] {
            let gloss = vane_gloss(cover, 1.56);
            assert!((depth(0.999 * gloss, cover) - VANE_MOST).abs() < 1e-6 && depth(1.0, cover) < 1e-6);
            // Thinner vanes need more pigment for the same colour.
            assert!(depth(0.3, cover) > 1.5 * depth(0.3, 2.0 * cover));
            let back = gloss + (1.0 - gloss) * libm::exp(-vane_depth(depth(0.3, cover), cover));
            assert!((back - 0.3).abs() < 1e-9, "{cover}: {back}");
        }
        assert!(Absorption::of_vane(&Reflectance::new(|_| 0.5).unwrap(), 0.0, index).is_err());
    }

    #[test]
    fn impossible_pigments_are_refused() {
        assert!(Absorption::pigments(-0.1, 0.0).unwrap_err().to_string().contains("not negative"));
        assert!(Absorption::pigments(0.0, f64::NAN).is_err());
        assert!(Absorption::melanin(1.5, 4.0).unwrap_err().to_string().contains("a share of 0 to 1"));
        let black = Reflectance::new(|_| 0.0).unwrap();
        assert!(Absorption::of_reflectance(&black, 0.3).is_err());
        let white = Reflectance::new(|_| 1.0).unwrap();
        assert_eq!(Absorption::of_reflectance(&white, 0.3).unwrap().at(500.0), 0.0);
    }
}
