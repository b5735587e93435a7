//! What two standards make of a film: the formulas of their own texts, evaluated here to tell how far they are off.
//!
//! Both sum the film's interference in the frequencies of the optical path instead of wavelengths (Belcour & Barla 2017, "A practical
//! extension to microfacet theory for the modeling of varying iridescence", *ACM Trans. Graph.* 36, 65, section 4): what the eye sees of
//! cos(2πD/λ) is a sum of Gaussians in D.

use std::f64::consts::TAU;

use super::OneFilm;

/// The Gaussians of x̄, ȳ, z̄ over wave numbers, and x̄'s second one, as (value, position 1/m, variance 1/m²): Belcour & Barla 2017,
/// supplemental code, repeated by both standards.
const SEEN: [[f64; 3]; 3] =
    [[5.4856e-13, 1.6810e6, 4.3278e9], [4.4201e-13, 1.7953e6, 9.3046e9], [5.2481e-13, 2.2084e6, 6.6121e9]];
const SEEN_X_TOO: [f64; 3] = [9.7470e-14, 2.2399e6, 4.5282e9];
/// What Y of a perfect white is of them.
const SEEN_WHITE: f64 = 1.0685e-7;

/// Terms of the series beside the constant one, in both standards.
const TERMS: i32 = 2;

/// Linear sRGB from XYZ in D65, rounded as in the glTF extension.
const REC709: [[f64; 3]; 3] = [
    [3.240_454_2, -1.537_138_5, -0.498_531_4],
    [-0.969_266_0, 1.876_010_8, 0.041_556_0],
    [0.055_643_4, -0.204_025_9, 1.057_225_2],
];

/// R, G, B of the CIE from XYZ, with the white of equal energy, which MaterialX takes.
const CIE_RGB: [[f64; 3]; 3] = [
    [2.370_674_3, -0.900_040_5, -0.470_633_8],
    [-0.513_885_0, 1.425_303_6, 0.088_581_4],
    [0.005_298_2, -0.014_694_9, 1.009_396_8],
];

fn times(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// X, Y, Z of cos(2πD/λ) for an optical path D in m.
fn seen(path_m: f64) -> [f64; 3] {
    let one = |[value, position, variance]: [f64; 3]| {
        let turned = TAU * path_m;
        value
            * (TAU * variance).sqrt()
            * libm::cos(position * turned)
            * libm::exp(-variance * turned * turned)
    };
    let mut xyz = SEEN.map(one);
    xyz[0] += one(SEEN_X_TOO);
    xyz.map(|v| v / SEEN_WHITE)
}

/// Reflected amplitudes of a film's two boundaries with their signs, and what a film between them makes of light: the constant part of the
/// reflectance, and the factors of cos(φ), cos(2φ), φ being the phase of the path in the film.
fn series(above: f64, below: f64) -> (f64, [f64; TERMS as usize]) {
    let (first, second) = (above * above, below * below);
    let through = 1.0 - first;
    let back = through * through * second / (1.0 - first * second);
    // Inside, the upper boundary reflects with the other sign.
    let once = -above * below;
    (first + back, std::array::from_fn(|m| 2.0 * (back - through) * once.powi(m as i32 + 1)))
}

/// Linear sRGB of `KHR_materials_iridescence` (Khronos Group 2022, "Implementation notes"): Schlick's Fresnel at both boundaries, the
/// base known by its reflectance in air alone, polarizations not told apart.
pub(super) fn gltf(film: &OneFilm, cosine: f64) -> [f64; 3] {
    let squared = |v: f64| v * v;
    let schlick = |normal: f64, cosine: f64| normal + (1.0 - normal) * (1.0 - cosine).powi(5);
    let inside = (1.0 - (1.0 - cosine * cosine) / squared(film.index)).max(0.0).sqrt();
    let above = schlick(squared((film.index - 1.0) / (film.index + 1.0)), cosine);
    // The extension guards against a base without reflectance of its own.
    let root = (squared((film.base_index - 1.0) / (film.base_index + 1.0)) + 1e-4).sqrt();
    let base = (1.0 + root) / (1.0 - root);
    let below = schlick(squared((base - film.index) / (base + film.index)), inside);
    // Of a denser medium the amplitude turns its sign.
    let amplitude = |reflected: f64, is_denser: bool| {
        if is_denser { -reflected.sqrt() } else { reflected.sqrt() }
    };
    let (constant, factors) = series(amplitude(above, true), amplitude(below, base >= film.index));
    let path = 2.0 * film.index * film.thickness_nm * 1e-9 * inside;
    let mut rgb = [constant; 3];
    for (m, factor) in (1..=TERMS).zip(factors) {
        let wave = times(&REC709, seen(f64::from(m) * path));
        rgb = std::array::from_fn(|c| rgb[c] + factor * wave[c]);
    }
    rgb.map(|v| v.max(0.0))
}

/// R, G, B of OpenPBR's film as MaterialX 1.39.5 draws `open_pbr_surface` (dielectric base): Fresnel's formulas for both polarizations.
pub(super) fn openpbr(film: &OneFilm, cosine: f64) -> [f64; 3] {
    let (outside, index, base) = (1.0, film.index, film.base_index);
    let refracted = |n: f64| (1.0 - (1.0 - cosine * cosine) / (n * n)).max(0.0).sqrt();
    let (inside, under) = (refracted(index), refracted(base));
    let s = |n: f64, c: f64, m: f64, d: f64| (n * c - m * d) / (n * c + m * d);
    let pairs = [
        [s(outside, cosine, index, inside), s(index, inside, base, under)],
        // p: each index times the other side's cosine, of H.
        [s(index, cosine, outside, inside), s(base, inside, index, under)],
    ];
    let path = 2.0 * index * film.thickness_nm * 1e-9 * inside;
    let mut xyz = [0.0; 3];
    for [above, below] in pairs {
        let (constant, factors) = series(above, below);
        xyz = xyz.map(|v| v + 0.5 * constant);
        for (m, factor) in (1..=TERMS).zip(factors) {
            let wave = seen(f64::from(m) * path);
            xyz = std::array::from_fn(|c| xyz[c] + 0.5 * factor * wave[c]);
        }
    }
    times(&CIE_RGB, xyz).map(|v| v.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// What the eye sees of no path at all is white, and of a long one nothing.
    #[test]
    fn the_waves_that_are_seen_are_those_of_the_observer() {
        for v in seen(0.0) {
            assert!((v - 1.0).abs() < 0.02, "{v}");
        }
        // A wave of one period between neighbours of 555 nm: cos(2πD/λ) of a path of half a wavelength is −1 there.
        assert!(seen(0.5 * 555e-9)[1] < -0.9);
        assert!(seen(20e-6).iter().all(|v| v.abs() < 1e-3));
    }

    /// The series is Airy's formula, cut after two terms: |r|² of the same amplitudes.
    #[test]
    fn the_series_is_airys_formula() {
        for [above, below] in [[-0.22, 0.22], [-0.22, -0.06], [0.15, 0.3]] {
            for phase in [0.0, 0.4, PI, 4.0] {
                let (constant, factors) = series(above, below);
                let summed = constant + factors[0] * libm::cos(phase) + factors[1] * libm::cos(2.0 * phase);
                let turned = num_complex::Complex64::from_polar(below, phase);
                let exact = ((above + turned) / (1.0 + above * turned)).norm_sqr();
                assert!((summed - exact).abs() < 2e-3, "{above} {below} {phase}: {summed} {exact}");
            }
        }
    }

    /// A film of 300 nm between air and two bases, at 0°, 45° and 75°: both standards' shader texts, copied out into another language
    /// statement by statement and run.
    #[test]
    fn formulas_give_what_the_standards_own_texts_give() {
        let expected = [
            (
                1.56,
                1.0,
                [
                    ([0.2215, 0.0915, 0.0195], [0.2061, 0.1011, 0.0263]),
                    ([0.1514, 0.1664, 0.0383], [0.1789, 0.1803, 0.0633]),
                    ([0.1880, 0.3863, 0.3748], [0.3411, 0.5378, 0.5488]),
                ],
            ),
            (
                1.5,
                1.9,
                [
                    ([0.0, 0.0344, 0.0940], [0.0, 0.0347, 0.0889]),
                    ([0.0523, 0.0093, 0.0619], [0.0538, 0.0235, 0.0649]),
                    ([0.3773, 0.2505, 0.1757], [0.3116, 0.2584, 0.2129]),
                ],
            ),
        ];
        for (index, base_index, rows) in expected {
            let film = OneFilm::clear(index, 300.0, base_index);
            for (degrees, (first, second)) in [0.0_f64, 45.0, 75.0].into_iter().zip(rows) {
                let cosine = libm::cos(degrees.to_radians());
                for (found, expected) in [(gltf(&film, cosine), first), (openpbr(&film, cosine), second)] {
                    for c in 0..3 {
                        assert!(
                            (found[c] - expected[c]).abs() < 1e-4,
                            "{film:?} {degrees}: {found:?} {expected:?}"
                        );
                    }
                }
            }
        }
    }
}
