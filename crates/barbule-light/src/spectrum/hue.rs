//! Hue in numbers: the wavelength whose light looks alike, and the Oklab colour space.

use super::colour::matching;

/// The white that hues are seen against: D65, as in sRGB.
const WHITE: [f64; 2] = [0.3127, 0.3290];

/// Wavelengths whose chromaticities bound the visible colours; beyond them they hardly differ.
const LOCUS_NM: std::ops::RangeInclusive<i32> = 390..=700;

/// The pure light that, mixed with white, matches a chromaticity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dominant {
    /// Its wavelength; of purples, which no pure light matches, that of the complementary colour.
    pub nm: f64,
    /// Whether the colour is such a purple.
    pub is_complementary: bool,
    /// 0 is white, 1 a pure light or, of purples, a mixture of the two ends of the spectrum.
    pub purity: f64,
}

/// The dominant wavelength of a chromaticity (x, y) against D65; none of white.
///
/// Source: CIE 15:2004, section 8; the 1931 2° observer at 1 nm, linear between.
#[must_use]
pub fn dominant([x, y]: [f64; 2]) -> Option<Dominant> {
    let away = [x - WHITE[0], y - WHITE[1]];
    if away[0].hypot(away[1]).is_nan() || away[0].hypot(away[1]) < 1e-6 {
        return None;
    }
    let locus = |nm: i32| {
        let [x, y, z] = matching(f64::from(nm));
        [x / (x + y + z) - WHITE[0], y / (x + y + z) - WHITE[1]]
    };
    let on_locus = |towards: [f64; 2]| {
        let mut next = locus(*LOCUS_NM.start());
        (*LOCUS_NM.start()..*LOCUS_NM.end()).find_map(|nm| {
            let from = next;
            next = locus(nm + 1);
            crossing(towards, from, next).map(|[ratio, part]| (f64::from(nm) + part, ratio))
        })
    };
    if let Some((nm, ratio)) = on_locus(away) {
        return Some(Dominant { nm, is_complementary: false, purity: 1.0 / ratio });
    }
    let (nm, _) = on_locus(away.map(|v| -v))?;
    let [ratio, _] = crossing(away, locus(*LOCUS_NM.start()), locus(*LOCUS_NM.end()))?;
    Some(Dominant { nm, is_complementary: true, purity: 1.0 / ratio })
}

/// Where the ray `ratio`·`towards` meets the segment between two points, and how far along the segment.
fn crossing(towards: [f64; 2], from: [f64; 2], to: [f64; 2]) -> Option<[f64; 2]> {
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let along = [to[0] - from[0], to[1] - from[1]];
    let turn = cross(towards, along);
    let (ratio, part) = (cross(from, along) / turn, cross(from, towards) / turn);
    (turn != 0.0 && ratio > 0.0 && (0.0..=1.0).contains(&part)).then_some([ratio, part])
}

/// Oklab's L, a, b of linear sRGB (Ottosson 2020, "A perceptual color space for image processing").
#[must_use]
pub fn oklab([r, g, b]: [f64; 3]) -> [f64; 3] {
    let row = |w: [f64; 3], v: [f64; 3]| w[0] * v[0] + w[1] * v[1] + w[2] * v[2];
    let cones = [
        [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
        [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
        [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
    ]
    .map(|w| libm::cbrt(row(w, [r, g, b])));
    [
        row([0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8], cones),
        row([1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9], cones),
        row([0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0], cones),
    ]
}

/// Oklab's hue angle of linear sRGB in degrees, 0 to 360; it does not depend on brightness. Red is 29, yellow 110,
/// green 142, cyan 195, blue 264, magenta 328.
#[must_use]
pub fn hue_deg(linear_rgb: [f64; 3]) -> f64 {
    let [_, a, b] = oklab(linear_rgb);
    libm::atan2(b, a).to_degrees().rem_euclid(360.0)
}

#[cfg(test)]
mod tests {
    use super::super::colour::{chromaticity, xyz_from_rgb};
    use super::*;

    #[test]
    fn pure_lights_are_their_own_dominant_wavelength() {
        for nm in [400.0, 450.5, 480.0, 520.25, 555.0, 600.0, 650.0] {
            let found = dominant(chromaticity(matching(nm))).unwrap();
            // Chords instead of the curve between 1 nm; at the ends of the spectrum chromaticities crowd together.
            assert!((found.nm - nm).abs() < 0.02 && !found.is_complementary, "{nm}: {found:?}");
            assert!((found.purity - 1.0).abs() < 1e-3, "{nm}: {found:?}");
        }
    }

    #[test]
    fn mixing_with_white_changes_the_purity_only() {
        let [x, y] = chromaticity(matching(500.0));
        let half = [0.5 * (x + WHITE[0]), 0.5 * (y + WHITE[1])];
        let found = dominant(half).unwrap();
        assert!((found.nm - 500.0).abs() < 1e-9 && (found.purity - 0.5).abs() < 1e-9, "{found:?}");
        assert_eq!(dominant(WHITE), None);
        assert_eq!(dominant([f64::NAN, 0.3]), None);
    }

    /// Published values of sRGB's primaries: 611.4, 549.1, 464.2 nm.
    #[test]
    fn primaries_have_their_published_wavelengths_and_magenta_has_none() {
        for (rgb, nm, complementary) in [
            ([1.0, 0.0, 0.0], 611.4, false),
            ([0.0, 1.0, 0.0], 549.1, false),
            ([0.0, 0.0, 1.0], 464.2, false),
            ([1.0, 0.0, 1.0], 549.1, true),
        ] {
            let found = dominant(chromaticity(xyz_from_rgb(rgb))).unwrap();
            assert!((found.nm - nm).abs() < 0.15, "{rgb:?}: {found:?}");
            assert_eq!(found.is_complementary, complementary, "{rgb:?}");
        }
    }

    /// Oklab as published, of sRGB's primaries.
    #[test]
    fn hues_of_primaries_are_the_published_ones_at_any_brightness() {
        for (rgb, hue) in [
            ([1.0, 0.0, 0.0], 29.23),
            ([1.0, 1.0, 0.0], 109.77),
            ([0.0, 1.0, 0.0], 142.50),
            ([0.0, 0.0, 1.0], 264.05),
        ] {
            assert!((hue_deg(rgb) - hue).abs() < 0.05, "{rgb:?}: {}", hue_deg(rgb));
            assert!((hue_deg(rgb.map(|c| 0.01 * c)) - hue_deg(rgb)).abs() < 1e-9);
        }
        let [lightness, a, b] = oklab([1.0; 3]);
        assert!((lightness - 1.0).abs() < 1e-6 && a.hypot(b) < 1e-6);
    }
}
