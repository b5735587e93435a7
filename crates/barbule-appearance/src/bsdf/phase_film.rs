//! The "thin film" of a picture of 2005: a diffuse surface that is iridescent where its colour is blue.
//!
//! Pau (*Modeling and Rendering Peacock Tail Feathers*, 2005) takes from Gonzato & Pont (*A phenomenological representation of iridescent
//! colors in butterfly wings*) the reflectance
//!
//! ```text
//! R = cos² δ,  δ = (4π d/λ) √(n² − sin² θ) + π,
//! ```
//!
//! d = 140 nm, n = 1.54, θ from the viewer to the normal. It is no film: two beams that differ by the phase δ have cos²(δ/2), so that
//! colours are those of a film twice as thick; the π changes nothing, since cos² has that period; and R reaches 1. See
//! `docs/theory/peacock.md`. It stands here as it was written, to be compared.

use std::f64::consts::PI;

use crate::spectrum::colour::encode;
use crate::spectrum::dense::{Lambdas, WAVES};
use crate::{Error, Result};

/// Hues that count as blue, degrees, and how far beyond them they fade.
const BLUE_DEG: [f64; 2] = [190.0, 265.0];
const FADE_DEG: f64 = 15.0;
/// Greyer and darker colours are no blue.
const LEAST_SATURATION: f64 = 0.25;
const LEAST_VALUE: f64 = 0.05;

/// A film by the phase difference of two beams, as it was taken in 2005.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseFilm {
    /// n² and 4π d, nm.
    index_squared: f64,
    path_nm: f64,
}

impl PhaseFilm {
    /// # Errors
    /// A thickness that is not over 0 and up to 100,000 nm, or an index below 1 or over 4.
    pub fn new(thickness_nm: f64, index: f64) -> Result<Self> {
        if !(thickness_nm > 0.0 && thickness_nm <= 1e5 && (1.0..=4.0).contains(&index)) {
            return Err(Error::input(format!(
                "a film of {thickness_nm} nm of index {index}: give over 0 and up to 100000 nm, and 1 to 4"
            )));
        }
        Ok(Self { index_squared: index * index, path_nm: 4.0 * PI * thickness_nm })
    }

    /// cos² δ at a wavelength, for the cosine of the angle between viewer and normal.
    #[inline]
    #[must_use]
    pub fn reflectance(&self, nm: f64, cosine: f64) -> f64 {
        let sine_squared = (1.0 - cosine * cosine).max(0.0);
        let phase = self.path_nm / nm * (self.index_squared - sine_squared).sqrt() + PI;
        let cosine = libm::cos(phase);
        cosine * cosine
    }

    /// In place of a diffuse reflectance, where the linear colour beneath is blue.
    #[inline]
    pub(super) fn over(
        &self,
        diffuse: [f64; WAVES],
        colour: [f64; 3],
        cosine: f64,
        wavelengths: Lambdas,
    ) -> [f64; WAVES] {
        let blue = blueness(colour);
        if blue == 0.0 {
            return diffuse;
        }
        let film = wavelengths.map(|nm| self.reflectance(nm, cosine));
        std::array::from_fn(|k| diffuse[k] + (film[k] - diffuse[k]) * blue)
    }
}

/// How blue a linear colour is, 0 to 1: as its hue on the screen lies from 190° to 265°, or within 15° of that, unless it is grey or black.
#[must_use]
pub fn blueness(linear: [f64; 3]) -> f64 {
    let [r, g, b] = linear.map(|v| encode(v.clamp(0.0, 1.0)));
    let (most, least) = (r.max(g).max(b), r.min(g).min(b));
    let chroma = most - least;
    if most <= LEAST_VALUE || chroma <= LEAST_SATURATION * most {
        return 0.0;
    }
    let sixth = if most == r {
        (g - b) / chroma
    } else if most == g {
        2.0 + (b - r) / chroma
    } else {
        4.0 + (r - g) / chroma
    };
    let hue = 60.0 * sixth.rem_euclid(6.0);
    let outside = (BLUE_DEG[0] - hue).max(hue - BLUE_DEG[1]).max(0.0);
    let share = (1.0 - outside / FADE_DEG).max(0.0);
    share * share * (3.0 - 2.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Its maxima lie at 4 n d cos θ' = m λ: 862 and 431 nm for the numbers of 2005, and the π is not seen.
    #[test]
    fn maxima_are_those_of_a_film_twice_as_thick() {
        let film = PhaseFilm::new(140.0, 1.54).unwrap();
        for (nm, expected) in [(862.4, 1.0), (431.2, 1.0), (574.933_333, 0.0)] {
            assert!((film.reflectance(nm, 1.0) - expected).abs() < 1e-9, "{nm}");
        }
        for (nm, angle) in [(410.0, 0.2_f64), (523.0, 0.9), (660.0, 1.4)] {
            let path = 4.0 * PI * 140.0 / nm * (1.54_f64 * 1.54 - angle.sin() * angle.sin()).sqrt();
            let without = path.cos() * path.cos();
            assert!((film.reflectance(nm, angle.cos()) - without).abs() < 1e-12);
        }
        assert!(PhaseFilm::new(0.0, 1.54).is_err() && PhaseFilm::new(140.0, f64::NAN).is_err());
    }

    #[test]
    fn blue_is_a_hue_and_no_grey() {
        let of =
            |bytes: [u8; 3]| blueness(bytes.map(|v| crate::spectrum::colour::decode(f64::from(v) / 255.0)));
        for (bytes, expected) in [
            ([0, 0, 255], 1.0),
            ([40, 60, 190], 1.0),
            ([131, 157, 255], 1.0),
            ([255, 0, 0], 0.0),
            ([200, 205, 210], 0.0),
            ([4, 5, 12], 0.0),
            ([190, 165, 60], 0.0),
            // At 180° and 272.5°: 10° and 7.5° outside.
            ([0, 255, 255], 7.0 / 27.0),
            ([138, 0, 255], 0.5),
        ] {
            let found = of(bytes);
            assert!((found - expected).abs() < 0.01, "{bytes:?}: {found}");
        }
    }
}
