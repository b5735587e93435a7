//! What a person sees: spectra → CIE XYZ (1931, 2°) → sRGB.
//!
//! Reflectances are linear between their samples and their end values hold outside (see [`held`]). The integral is
//! the trapezoidal rule on the CIE's 1 nm tables from 360 to 830 nm together with the samples' own wavelengths, so
//! white is white at any sampling.

use super::{Spectrum, Wavelengths, cie};
use crate::error::did_you_mean;
use crate::{Error, Result};

/// A light by which reflectances are seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Illuminant {
    /// Average daylight, 6504 K: the white of sRGB.
    #[default]
    D65,
    /// Horizon light, 5003 K.
    D50,
    /// A tungsten lamp, 2856 K.
    A,
    /// The same power at every wavelength.
    E,
}

impl Illuminant {
    /// Every illuminant with its name.
    pub const ALL: [(&'static str, Self); 4] =
        [("D65", Self::D65), ("D50", Self::D50), ("A", Self::A), ("E", Self::E)];

    /// The illuminant of a name, in upper or lower case.
    ///
    /// # Errors
    /// No illuminant has that name.
    pub fn named(name: &str) -> Result<Self> {
        let found = Self::ALL.iter().find(|(known, _)| known.eq_ignore_ascii_case(name));
        found.map(|(_, illuminant)| *illuminant).ok_or_else(|| {
            let short: String = name.chars().take(40).collect();
            let near = did_you_mean(&short, Self::ALL.iter().map(|(known, _)| *known));
            Error::input(format!("there is no illuminant '{short}'{near}; known are D65, D50, A and E"))
        })
    }

    /// Relative power at a wavelength in nm, 100 at 560 nm; 0 outside 300 to 830 nm.
    #[must_use]
    pub fn power(self, nm: f64) -> f64 {
        self.of(&cie::at(nm), nm)
    }

    fn of(self, row: &[f64; 6], nm: f64) -> f64 {
        match self {
            Self::A => row[3],
            Self::D50 => row[4],
            Self::D65 => row[5],
            Self::E if (cie::FIRST_POWER_NM..=cie::LAST_NM).contains(&nm) => 100.0,
            Self::E => 0.0,
        }
    }
}

/// The colour-matching functions x̄, ȳ, z̄ of the 1931 2° observer at a wavelength in nm; 0 outside 360 to 830 nm.
#[must_use]
pub fn matching(nm: f64) -> [f64; 3] {
    let row = cie::at(nm);
    [row[0], row[1], row[2]]
}

/// The 1931 2° observer under one light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Observer {
    /// The light.
    pub illuminant: Illuminant,
}

/// Numbers that turn samples of a reflectance into colour by three dot products.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// For each wavelength its part in X, Y and Z; a perfect white has Y = 1.
    xyz: Vec<[f64; 3]>,
    /// For each wavelength its part in linear sRGB.
    rgb: Vec<[f64; 3]>,
}

impl Observer {
    /// An observer under a light.
    #[must_use]
    pub fn under(illuminant: Illuminant) -> Self {
        Self { illuminant }
    }

    /// The weights of reflectance samples at these wavelengths.
    #[must_use]
    pub fn weights(&self, at: &Wavelengths) -> Weights {
        let mut nodes: Vec<f64> = (0..cie::rows().len()).map(|i| cie::FIRST_NM + i as f64).collect();
        nodes.extend(at.iter().filter(|nm| (cie::FIRST_NM..=cie::LAST_NM).contains(*nm)));
        nodes.sort_by(f64::total_cmp);
        nodes.dedup();
        let mut xyz = vec![[0.0; 3]; at.len()];
        let mut luminance = 0.0;
        for (i, &nm) in nodes.iter().enumerate() {
            let width = (nodes[(i + 1).min(nodes.len() - 1)] - nodes[i.saturating_sub(1)]) / 2.0;
            let seen = self.seen(nm).map(|v| v * width);
            luminance += seen[1];
            let (low, part) = at.place(nm);
            for c in 0..3 {
                xyz[low][c] += seen[c] * (1.0 - part);
                if part > 0.0 {
                    xyz[low + 1][c] += seen[c] * part;
                }
            }
        }
        for value in xyz.iter_mut().flatten() {
            *value /= luminance;
        }
        let matrix =
            self.rgb_matrix(xyz.iter().fold([0.0; 3], |sum, w| std::array::from_fn(|c| sum[c] + w[c])));
        let rgb = xyz.iter().map(|w| times(&matrix, *w)).collect();
        Weights { xyz, rgb }
    }

    /// X, Y, Z of a reflectance; a perfect white has Y = 1.
    #[must_use]
    pub fn xyz(&self, reflectance: &Spectrum) -> [f64; 3] {
        self.weights(reflectance.wavelengths()).xyz(reflectance.values())
    }

    /// Linear sRGB of a reflectance; a perfect white is (1, 1, 1) under any light (von Kries adaptation in the
    /// Bradford space). Values below 0 or above 1 are colours that sRGB cannot show.
    #[must_use]
    pub fn linear_rgb(&self, reflectance: &Spectrum) -> [f64; 3] {
        self.weights(reflectance.wavelengths()).linear_rgb(reflectance.values())
    }

    /// Light times matching functions. Their product is what is linear between the 1 nm rows, so that more nodes
    /// leave the integral of white as it is.
    fn seen(&self, nm: f64) -> [f64; 3] {
        let rows = cie::rows();
        let low = ((nm - cie::FIRST_NM) as usize).min(rows.len() - 2);
        let part = nm - cie::FIRST_NM - low as f64;
        let product = |row: &[f64; 6], c: usize| row[c] * self.illuminant.of(row, nm);
        std::array::from_fn(|c| product(&rows[low], c) * (1.0 - part) + product(&rows[low + 1], c) * part)
    }

    /// XYZ under this light → linear sRGB, where `white` (XYZ of a perfect white) becomes (1, 1, 1).
    fn rgb_matrix(self, white: [f64; 3]) -> [[f64; 3]; 3] {
        product(&XYZ_TO_RGB, &adapted(white, D65_WHITE))
    }
}

/// X, Y, Z as they look under the white `to` from those seen under the white `from`: von Kries' adaptation in the Bradford space.
fn adapted(from: [f64; 3], to: [f64; 3]) -> [[f64; 3]; 3] {
    let (from, to) = (times(&BRADFORD, from), times(&BRADFORD, to));
    let mut scaled = BRADFORD;
    for (row, ratio) in scaled.iter_mut().zip((0..3).map(|c| to[c] / from[c])) {
        *row = row.map(|v| v * ratio);
    }
    product(&inverse(&BRADFORD), &scaled)
}

/// The same of linear sRGB.
pub(super) fn adaptation(from: [f64; 3], to: [f64; 3]) -> [[f64; 3]; 3] {
    product(&XYZ_TO_RGB, &product(&adapted(from, to), &inverse(&XYZ_TO_RGB)))
}

impl Weights {
    /// X, Y, Z of reflectance samples at the weights' wavelengths.
    #[must_use]
    pub fn xyz(&self, samples: &[f64]) -> [f64; 3] {
        dot(&self.xyz, samples)
    }

    /// Linear sRGB of reflectance samples at the weights' wavelengths.
    #[must_use]
    pub fn linear_rgb(&self, samples: &[f64]) -> [f64; 3] {
        dot(&self.rgb, samples)
    }

    /// The parts of each wavelength in X, Y, Z.
    #[must_use]
    pub fn xyz_parts(&self) -> &[[f64; 3]] {
        &self.xyz
    }

    /// The parts of each wavelength in linear sRGB.
    #[must_use]
    pub fn rgb_parts(&self) -> &[[f64; 3]] {
        &self.rgb
    }
}

fn dot(weights: &[[f64; 3]], samples: &[f64]) -> [f64; 3] {
    debug_assert_eq!(weights.len(), samples.len());
    let mut sum = [0.0; 3];
    for (weight, sample) in weights.iter().zip(samples) {
        for c in 0..3 {
            sum[c] += weight[c] * sample;
        }
    }
    sum
}

/// The part of X, Y or Z of white that may lie outside the samples before it is said: of less, neither twice the light nor
/// none makes a difference that is seen.
const SAID_FROM: f64 = 0.01;

/// What to tell the user where so much of a reflectance is continued that its colour depends on it; nothing when the samples
/// cover at least 99 % of each of X, Y and Z of white under D65, as those from 400 to 694 nm do.
#[must_use]
pub fn held(at: &Wavelengths) -> Option<String> {
    let (first, last) = at.range_nm();
    let unknown = 1.0 - known_share(at);
    (unknown > SAID_FROM).then(|| {
        format!(
            "colour: reflectance is known from {first} to {last} nm; its end values are held outside, where {:.0} % of what the eye sees of white lies",
            100.0 * unknown
        )
    })
}

/// The part of X, Y or Z of white under D65 that comes from within the range of wavelengths: that of the least known.
#[must_use]
pub fn known_share(at: &Wavelengths) -> f64 {
    let (first, last) = at.range_nm();
    let (mut all, mut known) = ([0.0; 3], [0.0; 3]);
    for row in 0..cie::rows().len() {
        let nm = cie::FIRST_NM + row as f64;
        let seen = Observer::default().seen(nm);
        for c in 0..3 {
            all[c] += seen[c];
            known[c] += if (first..=last).contains(&nm) { seen[c] } else { 0.0 };
        }
    }
    (0..3).map(|c| known[c] / all[c]).fold(1.0, f64::min)
}

/// x and y of the chromaticity diagram.
#[must_use]
pub fn chromaticity(xyz: [f64; 3]) -> [f64; 2] {
    let sum = xyz[0] + xyz[1] + xyz[2];
    [xyz[0] / sum, xyz[1] / sum]
}

/// The white point of sRGB, x = 0.3127, y = 0.3290 (IEC 61966-2-1).
pub const D65_WHITE: [f64; 3] = [0.3127 / 0.3290, 1.0, (1.0 - 0.3127 - 0.3290) / 0.3290];

/// Linear sRGB from XYZ, exact for the primaries and the white of IEC 61966-2-1 (whose own matrix is rounded).
const XYZ_TO_RGB: [[f64; 3]; 3] = [
    [3.240_969_941_904_521, -1.537_383_177_570_093, -0.498_610_760_293_003_4],
    [-0.969_243_636_280_879_6, 1.875_967_501_507_720_2, 0.041_555_057_407_175_57],
    [0.055_630_079_696_993_66, -0.203_976_958_888_976_52, 1.056_971_514_242_878_6],
];

/// Cone responses of the Bradford adaptation (Lam 1985).
const BRADFORD: [[f64; 3]; 3] =
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// Linear sRGB from XYZ relative to D65.
#[must_use]
pub fn rgb_from_xyz(xyz: [f64; 3]) -> [f64; 3] {
    times(&XYZ_TO_RGB, xyz)
}

/// XYZ relative to D65 from linear sRGB.
#[must_use]
pub fn xyz_from_rgb(rgb: [f64; 3]) -> [f64; 3] {
    times(&inverse(&XYZ_TO_RGB), rgb)
}

/// Rec. 709 luminance of linear sRGB.
#[must_use]
pub fn luminance(rgb: [f64; 3]) -> f64 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}

/// The sRGB transfer curve of one linear value in 0 to 1 (IEC 61966-2-1).
#[must_use]
pub fn encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 }
}

/// The linear value of an encoded sRGB one.
#[must_use]
pub fn decode(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// A colour outside sRGB moved towards the grey of its luminance until no component is negative; black where the luminance is
/// not over 0.
#[must_use]
pub fn into_gamut(rgb: [f64; 3]) -> [f64; 3] {
    let luminance = luminance(rgb);
    let least = rgb[0].min(rgb[1]).min(rgb[2]);
    if least >= 0.0 {
        return rgb;
    }
    if luminance <= 0.0 {
        return [0.0; 3];
    }
    let keep = luminance / (luminance - least);
    // Rounding may leave the least component a hair below 0.
    rgb.map(|v| (luminance + (v - luminance) * keep).max(0.0))
}

/// The colour to show: each linear channel clipped to 0…1 (which may shift the hue of colours outside sRGB), encoded,
/// and rounded to a byte.
#[must_use]
pub fn display(linear_rgb: [f64; 3]) -> [u8; 3] {
    // NaN clips to 0.
    linear_rgb.map(|v| (encode(v.clamp(0.0, 1.0)) * 255.0).round() as u8)
}

/// Matrix times vector.
fn times(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn product(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    a.map(|row| std::array::from_fn(|j| (0..3).map(|k| row[k] * b[k][j]).sum()))
}

fn inverse(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    // Cofactors with cyclic indices carry their own signs.
    let cofactor = |i: usize, j: usize| {
        let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let determinant: f64 = (0..3).map(|j| m[0][j] * cofactor(0, j)).sum();
    std::array::from_fn(|i| std::array::from_fn(|j| cofactor(j, i) / determinant))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIGHTS: [Illuminant; 4] = [Illuminant::D65, Illuminant::D50, Illuminant::A, Illuminant::E];

    fn flat(first: f64, last: f64, step: f64) -> Spectrum {
        let count = ((last - first) / step).floor() as usize + 1;
        let at: Vec<f64> = (0..count).map(|i| first + i as f64 * step).collect();
        Spectrum::new(Wavelengths::new(at).unwrap(), vec![1.0; count]).unwrap()
    }

    #[test]
    fn white_is_white_at_any_sampling_and_light() {
        for (first, last, step) in [
            (400.0, 694.0, 6.0),
            (360.0, 830.0, 1.0),
            (400.0, 700.0, 10.0),
            (300.0, 830.0, 0.37),
            (412.3, 650.0, 7.7),
        ] {
            for light in LIGHTS {
                let observer = Observer::under(light);
                let white = flat(first, last, step);
                assert!((observer.xyz(&white)[1] - 1.0).abs() < 1e-12);
                for channel in observer.linear_rgb(&white) {
                    assert!((channel - 1.0).abs() < 1e-12, "{light:?} {first} {last} {step}: {channel}");
                }
            }
        }
    }

    #[test]
    fn without_adaptation_d65_white_is_white_to_the_rounding_of_its_published_chromaticity() {
        let xyz = Observer::default().xyz(&flat(360.0, 830.0, 1.0));
        for channel in rgb_from_xyz(xyz) {
            assert!((channel - 1.0).abs() < 3e-4, "{channel}");
        }
    }

    #[test]
    fn sampling_a_smooth_spectrum_finer_changes_little() {
        let film = |nm: f64| 0.5 + 0.5 * (std::f64::consts::TAU * 2.0 * 1.55 * 200.0 / nm).cos();
        let colour = |step: f64| {
            let white = flat(360.0, 830.0, step);
            let values = white.wavelengths().iter().map(|&nm| film(nm)).collect();
            Observer::default().linear_rgb(&Spectrum::new(white.wavelengths().clone(), values).unwrap())
        };
        let (fine, coarse) = (colour(0.5), colour(5.0));
        for c in 0..3 {
            assert!((fine[c] - coarse[c]).abs() < 2e-3, "{fine:?} {coarse:?}");
        }
    }

    #[test]
    fn encoding_is_srgbs_and_has_an_inverse() {
        assert!((encode(0.5) - 0.735_356_983_052_449).abs() < 1e-12);
        for i in 0..=100 {
            let v = f64::from(i) / 100.0;
            assert!((decode(encode(v)) - v).abs() < 1e-12);
        }
        assert_eq!(display([-1.0, 0.5, 2.0]), [0, 188, 255]);
        assert_eq!(display([f64::NAN, 1.0, 0.0]), [0, 255, 0]);
    }

    #[test]
    fn matrices_are_inverse_and_luminance_is_y() {
        let rgb = [0.2, 0.5, 0.9];
        let xyz = xyz_from_rgb(rgb);
        let back = rgb_from_xyz(xyz);
        for c in 0..3 {
            assert!((back[c] - rgb[c]).abs() < 1e-12);
        }
        assert!((xyz[1] - luminance(rgb)).abs() < 1e-4);
    }

    #[test]
    fn the_share_of_what_is_seen_is_that_of_the_least_known_stimulus() {
        let share = |range: [f64; 2]| known_share(&Wavelengths::new(range).unwrap());
        assert_eq!((share([300.0, 900.0]), share([300.0, 350.0])), (1.0, 0.0));
        assert!(share([400.0, 694.0]) > 0.99 && share([450.0, 830.0]) < 0.7);
    }

    #[test]
    fn continued_reflectances_are_said_and_names_are_read() {
        let said = |range: [f64; 2]| held(&Wavelengths::new(range).unwrap());
        assert!(
            said([420.0, 700.0])
                .unwrap()
                .contains("from 420 to 700 nm; its end values are held outside, where ")
        );
        assert_eq!(
            (held(&Wavelengths::usual()), said([300.0, 700.0]), said([360.0, 830.0])),
            (None, None, None)
        );
        // Twice as much light beyond 700 nm, or none, is no difference that anybody sees.
        let lab = |beyond: f64| {
            let white = flat(360.0, 830.0, 1.0);
            let values =
                white.wavelengths().iter().map(|&nm| if nm > 700.0 { beyond } else { 0.1 }).collect();
            let xyz = Observer::default().xyz(&Spectrum::new(white.wavelengths().clone(), values).unwrap());
            super::super::difference::lab(xyz, Observer::default().xyz(&white))
        };
        for beyond in [0.0, 0.2] {
            let seen = super::super::difference::delta_e_2000(lab(0.1), lab(beyond));
            assert!(seen < 0.3, "{beyond}: {seen}");
        }
        assert_eq!(Illuminant::named("d50").unwrap(), Illuminant::D50);
        assert!(Illuminant::named("D75").unwrap_err().to_string().contains("did you mean 'D65'"));
    }
}
