//! From linear light to the 8 bits of a PNG.
//!
//! 1. Exposure: linear sRGB times a stated factor; nothing is adapted to the picture.
//! 2. Gamut: a colour outside sRGB (a negative component) moves towards the grey of its luminance just until it is
//!    inside; hue and luminance stay.
//! 3. Tone: the largest component m is kept up to 0.6 and above it becomes 1 − 0.4 exp(−(m − 0.6)/0.4); the others
//!    keep their ratio to it, so hue stays. Glints far over white (m > 1) lose saturation, as on film: a share
//!    1 − 1/(1 + ((m − 1)/3)²) of the colour is replaced by its largest component.
//! 4. The sRGB transfer curve, rounded to the nearest of 256 steps.

use crate::spectrum::colour::into_gamut;

/// Largest component kept as it is.
const SHOULDER: f64 = 0.6;

/// One pixel of linear sRGB after exposure, to 8 bits.
#[must_use]
pub fn to_bytes(linear: [f64; 3]) -> [u8; 3] {
    encoded(shown(linear))
}

/// One pixel of linear sRGB after exposure as a screen shows it, still linear: gamut and tone curve.
#[must_use]
pub fn shown(linear: [f64; 3]) -> [f64; 3] {
    shoulder(into_gamut(linear.map(|v| if v.is_finite() { v } else { 0.0 })))
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

/// The sRGB transfer curve (IEC 61966-2-1).
fn transfer(v: f64) -> f64 {
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greys_stay_grey_and_tones_rise() {
        let mut last = 0;
        for step in 0..200 {
            let [r, g, b] = to_bytes([f64::from(step) * 0.02; 3]);
            assert!(r == g && g == b && r >= last);
            last = r;
        }
        assert_eq!(to_bytes([0.5; 3])[0], 188);
        assert_eq!(to_bytes([f64::NAN, 0.0, 0.0]), [0; 3]);
    }

    #[test]
    fn colours_outside_srgb_keep_their_luminance() {
        let rgb = into_gamut([-0.1, 0.5, 0.2]);
        let luminance = |c: [f64; 3]| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
        assert!(rgb.iter().all(|v| *v >= 0.0));
        assert!((luminance(rgb) - luminance([-0.1, 0.5, 0.2])).abs() < 1e-12);
    }
}
