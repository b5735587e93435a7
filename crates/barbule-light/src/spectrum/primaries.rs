//! Smooth spectra that colours are made of.

use super::dense::DenseSpectrum;

/// First wavelength of the tables below, nm.
const FIRST_NM: f64 = 380.0;
/// Their step, nm.
const STEP_NM: f64 = 10.0;

/// Red's share of daylight at 380, 390 … 720 nm; `scripts/sky-primaries.py` makes both.
#[rustfmt::skip]
const RED: [f64; 35] = [
    0.026_624, 0.026_616, 0.026_56, 0.026_311, 0.025_437, 0.023_079, 0.019_507, 0.018_819, 0.030_494, 0.012_404,
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.018_621, 0.208_603, 0.477_151, 0.736_784, 0.922_056, 1.0,
    1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0,
];

/// Green's; blue has the rest.
#[rustfmt::skip]
const GREEN: [f64; 35] = [
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.112_149, 0.297_488, 0.508_599, 0.714_756, 0.885_036,
    0.988_609, 1.0, 1.0, 1.0, 1.0, 0.935_072, 0.739_707, 0.488_246, 0.250_325, 0.077_944, 0.0, 0.0, 0.0, 0.0,
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
];

/// Shares of sRGB's red, green and blue in daylight (D65): between 0 and 1, in sum 1 at every wavelength, the smoothest whose
/// colours, seen at the renderer's wavelengths, are the primaries (after Mallett & Yuksel, *Spectral Primary Decomposition for Rendering
/// with sRGB Reflectance*, EGSR 2019); outside 380 to 720 nm those of the ends. Weighted with a colour's linear R, G and B of 0 to 1 they are a reflectance of that colour.
#[must_use]
pub fn shares() -> [DenseSpectrum; 3] {
    let red = |nm: f64| between(&RED, nm);
    let green = |nm: f64| between(&GREEN, nm);
    [
        DenseSpectrum::new(red),
        DenseSpectrum::new(green),
        DenseSpectrum::new(|nm| (1.0 - red(nm) - green(nm)).max(0.0)),
    ]
}

/// Linear between the tables' values, and the end values outside.
fn between(table: &[f64; 35], nm: f64) -> f64 {
    let at = ((nm - FIRST_NM) / STEP_NM).clamp(0.0, 34.0);
    let index = (at as usize).min(33);
    table[index] + (table[index + 1] - table[index]) * (at - index as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_parts_of_a_whole() {
        let [red, green, blue] = shares();
        for nm in 300..=830 {
            let parts = [&red, &green, &blue].map(|share| share.at(f64::from(nm)));
            assert!(parts.iter().all(|part| (0.0..=1.0).contains(part)));
            assert!((parts.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
        assert!(red.at(650.0) > 0.99 && green.at(540.0) > 0.9 && blue.at(450.0) > 0.9);
    }
}
