//! Spectra of three smooth functions, as pictures of 2005 derived them from red, green and blue.
//!
//! Glassner, *How to derive a spectrum from an RGB triplet* (IEEE Computer Graphics and Applications 9(4), 1989), adds
//!
//! ```text
//! Φ₁ = 1,  Φ₂ = (1 + sin 2πt)/2,  Φ₃ = (1 + cos 2πt)/2,  t = (λ − λ₀)/(λ₁ − λ₀),
//! ```
//!
//! with weights w = D⁻¹ (R, G, B), in which column j of D is what Φ_j looks like: D_cj = Σ_k M_ck ∫Φ_j x̄_k dλ / ∫ȳ dλ, M from XYZ to the
//! screen's primaries. What comes of it has the colour exactly, and may be negative: nothing holds a sum of waves over 0. It is here for
//! the sake of pictures that were made so; [`super::primaries`] are what colours are made of elsewhere.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

use super::colour::matching;

/// From XYZ to linear R, G and B as pbrt's first version has it (ITU-R BT.709 primaries, D65), to six digits.
const PHOSPHORS: DMat3 = DMat3::from_cols_array(&[
    3.240_479, -0.969_256, 0.055_648, -1.537_150, 1.875_991, -0.204_043, -0.498_535, 0.041_556, 1.057_311,
]);

/// Which wave is the second function; the third is the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Waves {
    /// The sine.
    SineFirst,
    /// The cosine.
    CosineFirst,
}

/// Glassner's three functions over a range of wavelengths.
#[derive(Debug, Clone)]
pub struct Glassner {
    range_nm: [f64; 2],
    waves: Waves,
    looks: DMat3,
    weights: DMat3,
}

impl Glassner {
    /// Step of the sums that stand for integrals, nm: 95 wavelengths from 360 to 830 nm.
    pub const STEP_NM: f64 = 5.0;

    /// Over 360 to 830 nm with the sine as the second function, as pbrt's first version has wavelengths.
    #[must_use]
    pub fn of_2005() -> Self {
        Self::new([360.0, 830.0], Waves::SineFirst)
    }

    /// `range_nm`: λ₀ and λ₁, in order; Glassner has 380 and 780.
    #[must_use]
    pub fn new(range_nm: [f64; 2], waves: Waves) -> Self {
        let mut of = Self { range_nm, waves, looks: DMat3::IDENTITY, weights: DMat3::IDENTITY };
        let look = |j: usize| of.linear_rgb(|nm| of.functions(nm)[j]);
        let looks = DMat3::from_cols(look(0), look(1), look(2));
        (of.looks, of.weights) = (looks, looks.inverse());
        of
    }

    /// The wavelengths of the sums, nm.
    pub fn wavelengths(&self) -> impl Iterator<Item = f64> + Clone {
        let [low, high] = self.range_nm;
        let steps = ((high - low) / Self::STEP_NM).round() as u32;
        (0..=steps).map(move |step| low + Self::STEP_NM * f64::from(step))
    }

    /// Φ₁, Φ₂ and Φ₃ at a wavelength.
    #[must_use]
    pub fn functions(&self, nm: f64) -> [f64; 3] {
        let [low, high] = self.range_nm;
        let turn = TAU * (nm - low) / (high - low);
        let (sine, cosine) = (0.5 * (1.0 + libm::sin(turn)), 0.5 * (1.0 + libm::cos(turn)));
        match self.waves {
            Waves::SineFirst => [1.0, sine, cosine],
            Waves::CosineFirst => [1.0, cosine, sine],
        }
    }

    /// The weights of a colour, linear R, G and B.
    #[must_use]
    pub fn weights(&self, rgb: [f64; 3]) -> [f64; 3] {
        (self.weights * DVec3::from(rgb)).into()
    }

    /// The spectrum of a colour at a wavelength of its range, which may be negative.
    #[must_use]
    pub fn value(&self, rgb: [f64; 3], nm: f64) -> f64 {
        self.weights(rgb).iter().zip(self.functions(nm)).map(|(weight, one)| weight * one).sum()
    }

    /// What a spectrum looks like: linear R, G and B, by the sums that the weights are from.
    #[must_use]
    pub fn seen(&self, spectrum: impl Fn(f64) -> f64) -> [f64; 3] {
        self.linear_rgb(spectrum).into()
    }

    /// D: what the functions look like, row by row.
    #[must_use]
    pub fn looks(&self) -> [[f64; 3]; 3] {
        self.looks.transpose().to_cols_array_2d()
    }

    fn linear_rgb(&self, spectrum: impl Fn(f64) -> f64) -> DVec3 {
        let (mut xyz, mut white) = (DVec3::ZERO, 0.0);
        for nm in self.wavelengths() {
            let eye = DVec3::from(matching(nm));
            xyz += eye * spectrum(nm);
            white += eye.y;
        }
        PHOSPHORS * xyz / white
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ratio of the largest to the smallest stretch of a matrix, from the eigenvalues of DᵀD (Smith 1961).
    fn condition(rows: [[f64; 3]; 3]) -> f64 {
        let d = DMat3::from_cols_array_2d(&rows);
        let a = d * d.transpose();
        let mean = (a.x_axis.x + a.y_axis.y + a.z_axis.z) / 3.0;
        let off = a - DMat3::from_diagonal(DVec3::splat(mean));
        let size = (off.to_cols_array().iter().map(|v| v * v).sum::<f64>() / 6.0).sqrt();
        let angle = ((off * (1.0 / size)).determinant() / 2.0).clamp(-1.0, 1.0).acos() / 3.0;
        let eigenvalue = |turn: f64| mean + 2.0 * size * (angle + turn).cos();
        (eigenvalue(0.0) / eigenvalue(TAU / 3.0)).sqrt()
    }

    #[test]
    fn ninety_five_wavelengths_give_every_colour_back() {
        let of = Glassner::of_2005();
        assert_eq!(of.wavelengths().count(), 95);
        for rgb in [[1.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.1, 0.3, 0.8]] {
            let back = of.seen(|nm| of.value(rgb, nm));
            assert!((0..3).all(|c| (back[c] - rgb[c]).abs() < 1e-13), "{rgb:?} {back:?}");
        }
        // The same power everywhere is pinkish to a screen whose white is daylight.
        let [r, g, b] = of.seen(|_| 1.0);
        assert!(r > 1.15 && g < 0.97 && (0.85..0.95).contains(&b), "{r} {g} {b}");
    }

    /// Beside the same from another table of the eye: the analytic fits of Wyman, Sloan & Shirley (2013), which differ from the CIE's by
    /// some percent, computed by another program. Condition numbers, and how far spectra of screens' colours go below 0 and over 1.
    #[test]
    fn spectra_of_saturated_colours_are_negative_in_places() {
        let glassner = Glassner::new([380.0, 780.0], Waves::SineFirst);
        let numbers = [condition(glassner.looks()), condition(Glassner::of_2005().looks())];
        assert!(
            (numbers[0] / 6.16 - 1.0).abs() < 0.03 && (numbers[1] / 8.43 - 1.0).abs() < 0.03,
            "{numbers:?}"
        );
        let swapped = condition(Glassner::new([380.0, 780.0], Waves::CosineFirst).looks());
        assert!((swapped - numbers[0]).abs() < 1e-9, "{swapped}");
        for (rgb, least, most) in [
            ([1.0, 0.0, 0.0], -0.149, 1.118),
            ([0.0, 0.0, 1.0], -0.107, 1.441),
            ([0.1, 0.3, 0.8], 0.132, 0.914),
            ([0.0, 1.0, 0.0], -1.418, 1.024),
            ([0.2, 0.5, 0.2], -0.257, 0.520),
        ] {
            let values: Vec<f64> = glassner.wavelengths().map(|nm| glassner.value(rgb, nm)).collect();
            let low = values.iter().copied().fold(f64::INFINITY, f64::min);
            let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            println!("{rgb:?} {low:.3} {high:.3}");
            assert!((low - least).abs() < 0.04 && (high - most).abs() < 0.04, "{rgb:?} {low} {high}");
        }
    }
}
