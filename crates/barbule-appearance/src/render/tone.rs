//! From linear light to the 8 bits of a PNG.
//!
//! 1. Exposure: linear sRGB times a stated factor; nothing is adapted to the picture.
//! 2. Gamut: a colour outside sRGB (a negative component) moves towards the grey of its luminance just until it is
//!    inside; hue and luminance stay.
//! 3. Tone, one of two curves, both of the largest component m.
//!    *Plain*: m is kept up to 0.6 and above it becomes 1 − 0.4 exp(−(m − 0.6)/0.4); the others
//!    keep their ratio to it, so hue stays. Glints far over white (m > 1) lose saturation, as on film: a share
//!    1 − 1/(1 + ((m − 1)/3)²) of the colour is replaced by its largest component.
//!    *Filmic*: `filmic`.
//! 4. The sRGB transfer curve, rounded to the nearest of 256 steps.

use crate::scene::description::ToneWord;
use crate::spectrum::colour::into_gamut;

/// Largest component kept as it is by the plain curve.
const SHOULDER: f64 = 0.6;

/// The grey that the filmic curve leaves as it is: a grey card's.
const GREY: f64 = 0.18;
/// The largest component that it shows as the screen's white: 6.5 stops over that grey.
const BRIGHTEST: f64 = 16.3;
/// Slope of the logarithms where there is no shoulder: the contrast of prints.
const CONTRAST: f64 = 1.3;
/// Largest component at which colours have lost half of their chroma.
const HALF_WHITE: f64 = 5.0;

/// One pixel of linear sRGB after exposure, to 8 bits.
#[must_use]
pub fn to_bytes(tone: ToneWord, linear: [f64; 3]) -> [u8; 3] {
    encoded(shown(tone, linear))
}

/// One pixel of linear sRGB after exposure as a screen shows it, still linear: gamut and tone curve.
#[must_use]
pub fn shown(tone: ToneWord, linear: [f64; 3]) -> [f64; 3] {
    let inside = into_gamut(linear.map(|v| if v.is_finite() { v } else { 0.0 }));
    match tone {
        ToneWord::Plain => shoulder(inside),
        ToneWord::Filmic => filmic(inside),
    }
}

/// What a screen shows, in 8 bits.
#[must_use]
pub fn encoded(shown: [f64; 3]) -> [u8; 3] {
    shown.map(|v| (255.0 * transfer(v.clamp(0.0, 1.0)) + 0.5) as u8)
}

fn shoulder(rgb: [f64; 3]) -> [f64; 3] {
    let largest = rgb[0].max(rgb[1]).max(rgb[2]);
    if largest <= SHOULDER {
        return rgb;
    }
    let room = 1.0 - SHOULDER;
    let shown = 1.0 - room * (-(largest - SHOULDER) / room).exp();
    let over = ((largest - 1.0) / 3.0).max(0.0);
    let white = 1.0 - 1.0 / (1.0 + over * over);
    rgb.map(|v| {
        let kept = v * shown / largest;
        kept + (shown - kept) * white
    })
}

/// The film's curve: the largest component m becomes w mⁿ/(mⁿ + c), the response of receptors (Naka & Rushton 1966; of pictures
/// Reinhard & Devlin, *Dynamic range reduction inspired by photoreceptor physiology*, 2005), n = 1.3, with w and c such that 0.18 stays and 16.3, 6.5 stops
/// above, is white; the others keep their ratio to it. Then chroma goes, at constant hue of Oklab (Ottosson 2020): a share m²/(m² + 5²) of the way to the grey of the
/// largest component, so that no glint ends as a screen's primary. What this puts outside the screen's gamut loses the rest of the
/// chroma that does not fit.
fn filmic(rgb: [f64; 3]) -> [f64; 3] {
    let largest = rgb[0].max(rgb[1]).max(rgb[2]);
    if largest <= 0.0 {
        return [0.0; 3];
    }
    let bright = film_curve(largest.min(BRIGHTEST));
    if rgb == [largest; 3] {
        return [bright; 3];
    }
    let kept = rgb.map(|v| v * (bright / largest));
    let white = largest * largest / (largest * largest + HALF_WHITE * HALF_WHITE);
    let [lightness, a, b] = oklab(kept);
    let grey = libm::cbrt(bright);
    let faded = |chroma: f64| {
        // Lightness goes with the chroma, towards that of the grey.
        let lightness = grey + (lightness - grey) * chroma;
        from_oklab([lightness, a * chroma, b * chroma])
    };
    let fits = |rgb: &[f64; 3]| rgb.iter().all(|v| (0.0..=1.0).contains(v));
    let wished = faded(1.0 - white);
    if fits(&wished) {
        return wished;
    }
    let (mut low, mut high) = (0.0, 1.0 - white);
    for _ in 0..12 {
        let middle = 0.5 * (low + high);
        if fits(&faded(middle)) { low = middle } else { high = middle }
    }
    faded(low).map(|v| v.clamp(0.0, 1.0))
}

/// The curve itself.
fn film_curve(value: f64) -> f64 {
    let [power, grey, white] = [value, GREY, BRIGHTEST].map(|v| libm::pow(v, CONTRAST));
    // w g/(g + c) = GREY and w h/(h + c) = 1.
    let half = (1.0 - GREY) * grey * white / (GREY * white - grey);
    let most = 1.0 + half / white;
    most * power / (power + half)
}

/// Oklab of linear sRGB (Ottosson, *A perceptual color space for image processing*, 2020).
fn oklab([r, g, b]: [f64; 3]) -> [f64; 3] {
    let l = libm::cbrt(0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b);
    let m = libm::cbrt(0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b);
    let s = libm::cbrt(0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b);
    [
        0.210_454_255_3 * l + 0.793_617_785_0 * m - 0.004_072_046_8 * s,
        1.977_998_495_1 * l - 2.428_592_205_0 * m + 0.450_593_709_9 * s,
        0.025_904_037_1 * l + 0.782_771_766_2 * m - 0.808_675_766_0 * s,
    ]
}

/// Its inverse.
fn from_oklab([lightness, a, b]: [f64; 3]) -> [f64; 3] {
    let cube = |v: f64| v * v * v;
    let l = cube(lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b);
    let m = cube(lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b);
    let s = cube(lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ]
}

/// The sRGB transfer curve (IEC 61966-2-1).
fn transfer(v: f64) -> f64 {
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::colour::{D65_WHITE, xyz_from_rgb};
    use crate::spectrum::difference::lab;

    #[test]
    fn greys_stay_grey_and_tones_rise() {
        for tone in [ToneWord::Plain, ToneWord::Filmic] {
            let mut last = 0;
            for step in 0..1000 {
                let [r, g, b] = to_bytes(tone, [f64::from(step) * 0.02; 3]);
                assert!(r == g && g == b && r >= last);
                last = r;
            }
            assert_eq!(to_bytes(tone, [f64::NAN, 0.0, 0.0]), [0; 3]);
        }
        assert_eq!(to_bytes(ToneWord::Plain, [0.5; 3])[0], 188);
    }

    /// A grey card is 118 of 255 on the screen by either curve; white is reached 6.5 stops above it, and of what lies a stop
    /// below the film's curve shows less.
    #[test]
    fn a_grey_card_stays_and_film_has_six_stops_above_it() {
        for tone in [ToneWord::Plain, ToneWord::Filmic] {
            assert_eq!(to_bytes(tone, [0.18; 3]), [118; 3]);
        }
        let film = |v: f64| shown(ToneWord::Filmic, [v; 3])[0];
        assert!((film(0.18) - 0.18).abs() < 1e-6 && (film(BRIGHTEST) - 1.0).abs() < 1e-6);
        assert!(film(8.0) < 0.99 && to_bytes(ToneWord::Filmic, [8.0; 3])[0] < 255);
        assert!(film(0.09) < 0.085 && film(0.01) < 0.006);
    }

    /// Saturated colours of all hues, over nine stops: their hue in Oklab stays, which the plain curve turns by up to 11°; by another
    /// space, CIELAB, it stays within 9.5°, and 11° of blue, of which that space is known to err. Chroma falls from a stop over white on, and
    /// at the end everything is white.
    #[test]
    fn film_keeps_hues_and_ends_in_white() {
        let polar = |[_, a, b]: [f64; 3]| (a.hypot(b), libm::atan2(b, a).to_degrees());
        let cielab = |rgb: [f64; 3]| polar(lab(xyz_from_rgb(rgb), D65_WHITE));
        let apart = |one: f64, other: f64| ((one - other + 540.0).rem_euclid(360.0) - 180.0).abs();
        let (mut worst, mut by_film, mut by_plain): ([f64; 2], f64, f64) = ([0.0; 2], 0.0, 0.0);
        for k in 0..24 {
            let turn = std::f64::consts::TAU * f64::from(k) / 24.0;
            // A ring of saturated colours about grey.
            let colour: [f64; 3] =
                std::array::from_fn(|c| 0.5 + 0.48 * (turn - std::f64::consts::TAU * c as f64 / 3.0).cos());
            let most = colour.iter().copied().fold(0.0, f64::max);
            let colour = colour.map(|v| v / most);
            let hues = [cielab(colour).1, polar(oklab(colour)).1];
            let is_blue = colour[2] == 1.0 && colour[1] < 0.6;
            let mut last = f64::INFINITY;
            for step in 0..=36 {
                let scale = libm::exp2(-3.0 + 0.25 * f64::from(step));
                let [film, plain] =
                    [ToneWord::Filmic, ToneWord::Plain].map(|tone| shown(tone, colour.map(|v| v * scale)));
                let (chroma, own) = cielab(film);
                if chroma > 5.0 {
                    let place = usize::from(is_blue);
                    worst[place] = worst[place].max(apart(own, hues[0]));
                    by_film = by_film.max(apart(polar(oklab(film)).1, hues[1]));
                    by_plain = by_plain.max(apart(polar(oklab(plain)).1, hues[1]));
                }
                if scale >= 2.0 {
                    assert!(chroma <= last + 1e-3, "{colour:?} {scale}: {chroma} after {last}");
                    last = chroma;
                }
            }
            assert!(last < 1.0, "{colour:?}: {last}");
        }
        assert!(worst[0] < 9.5 && worst[1] < 11.0, "{worst:?}");
        assert!(by_film < 1e-3 && by_plain > 10.0, "{by_film} {by_plain}");
    }

    #[test]
    fn oklab_comes_back() {
        for rgb in [[1.0, 1.0, 1.0], [0.9, 0.1, 0.02], [0.0, 0.3, 0.7]] {
            let back = from_oklab(oklab(rgb));
            assert!(rgb.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-6), "{rgb:?} {back:?}");
        }
        // Its author's table: white has lightness 1 and no chroma.
        let white = oklab([1.0; 3]);
        assert!((white[0] - 1.0).abs() < 1e-6 && white[1].abs() < 1e-6 && white[2].abs() < 1e-6);
    }

    #[test]
    fn colours_outside_srgb_keep_their_luminance() {
        let rgb = into_gamut([-0.1, 0.5, 0.2]);
        let luminance = |c: [f64; 3]| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
        assert!(rgb.iter().all(|v| *v >= 0.0));
        assert!((luminance(rgb) - luminance([-0.1, 0.5, 0.2])).abs() < 1e-12);
    }
}
