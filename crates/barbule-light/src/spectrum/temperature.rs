//! The colour temperature of lights, whites of a temperature, and the adaptation of an eye from one white to another.

use super::cie;
use super::colour::{D65_WHITE, adaptation};
use crate::{Error, Result};

/// c₂ of Planck's law, nm K (CIE 15:2018, ITS-90).
const SECOND_RADIATION_NM_K: f64 = 1.4388e7;
/// Farther than this from the Planckian locus, in u and v of 1960, a colour has no temperature (CIE 15:2018, 9.4).
const FARTHEST_UV: f64 = 0.05;
/// Temperatures that are looked for, K.
const RANGE_K: [f64; 2] = [1000.0, 100_000.0];
/// Whites of pictures, K: from a candle to the blue of the sky.
pub const WHITES_K: [f64; 2] = [1500.0, 25_000.0];
/// From here on whites are those of daylight.
const DAYLIGHT_FROM_K: f64 = 4000.0;

/// Correlated colour temperature of a light's X, Y, Z, K: that of the black body whose u, v of 1960 are nearest (CIE 15:2018, 9.4); `None` where none
/// is within 0.05, as of green light, or between 1,000 and 100,000 K.
#[must_use]
pub fn correlated_temperature_k(xyz: [f64; 3]) -> Option<f64> {
    let own = uv(xyz);
    let distance = |mired: f64| {
        let [u, v] = uv(black_body(1e6 / mired));
        (u - own[0]).hypot(v - own[1])
    };
    let [low, high] = [1e6 / RANGE_K[1], 1e6 / RANGE_K[0]];
    // Equal steps of the reciprocal are about equally visible; the nearest of them brackets the minimum.
    let steps: u32 = 64;
    let place = |k: u32| low + (high - low) * f64::from(k) / f64::from(steps);
    let nearest = (0..=steps).min_by(|a, b| distance(place(*a)).total_cmp(&distance(place(*b))))?;
    if nearest == 0 || nearest == steps {
        return None;
    }
    let (mut from, mut to) = (place(nearest - 1), place(nearest + 1));
    for _ in 0..40 {
        let third = (to - from) / 3.0;
        if distance(from + third) < distance(to - third) { to -= third } else { from += third }
    }
    let mired = 0.5 * (from + to);
    (distance(mired) <= FARTHEST_UV).then(|| 1e6 / mired)
}

/// X, Y, Z (Y = 1) of the white of a temperature, K: of daylight from 4000 K on (CIE 15:2018, eq. 4.5 and 4.6), below of a black body.
///
/// # Errors
/// A temperature outside 1500 to 25,000 K.
pub fn white_of_temperature(kelvin: f64) -> Result<[f64; 3]> {
    if !(WHITES_K[0]..=WHITES_K[1]).contains(&kelvin) {
        return Err(Error::input(format!(
            "a white of {kelvin} K; give {} to {} K",
            WHITES_K[0], WHITES_K[1]
        )));
    }
    if kelvin < DAYLIGHT_FROM_K {
        return Ok(black_body(kelvin));
    }
    let [a, b, c, d] = if kelvin <= 7000.0 {
        [-4.6070e9, 2.9678e6, 0.099_11e3, 0.244_063]
    } else {
        [-2.0064e9, 1.9018e6, 0.247_48e3, 0.237_040]
    };
    let x = ((a / kelvin + b) / kelvin + c) / kelvin + d;
    let y = (-3.0 * x + 2.870) * x - 0.275;
    Ok([x / y, 1.0, (1.0 - x - y) / y])
}

/// The matrix that brings linear sRGB seen under a white (X, Y, Z) to how it looks under D65: von Kries' in the Bradford space; luminances of greys
/// stay.
#[must_use]
pub fn balance(white: [f64; 3]) -> [[f64; 3]; 3] {
    adaptation(white.map(|value| value / white[1]), D65_WHITE)
}

/// X, Y, Z of a black body, Y = 1.
fn black_body(kelvin: f64) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (row, nm) in cie::rows().iter().zip((0_u32..).map(|k| cie::FIRST_NM + f64::from(k))) {
        let power = libm::pow(nm / 560.0, -5.0) / libm::expm1(SECOND_RADIATION_NM_K / (nm * kelvin));
        for (sum, matching) in sum.iter_mut().zip(row) {
            *sum += power * matching;
        }
    }
    sum.map(|value| value / sum[1])
}

/// u and v of the CIE's diagram of 1960.
fn uv([x, y, z]: [f64; 3]) -> [f64; 2] {
    let sum = x + 15.0 * y + 3.0 * z;
    [4.0 * x / sum, 6.0 * y / sum]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::colour::{Illuminant, matching, rgb_from_xyz, xyz_from_rgb};

    fn white(illuminant: Illuminant) -> [f64; 3] {
        let each = (360..=830).map(f64::from);
        each.fold([0.0; 3], |sum, nm| {
            std::array::from_fn(|c| sum[c] + illuminant.power(nm) * matching(nm)[c])
        })
    }

    /// The temperatures that the CIE states of its illuminants; Illuminant A's was 2848 K by the constants of 1931.
    #[test]
    fn illuminants_have_the_temperatures_that_are_stated() {
        for (illuminant, kelvin) in
            [(Illuminant::D65, 6504.0), (Illuminant::D50, 5003.0), (Illuminant::A, 2855.5)]
        {
            let found = correlated_temperature_k(white(illuminant)).unwrap();
            assert!((found - kelvin).abs() < 2.5, "{illuminant:?}: {found}");
        }
        for kelvin in [1800.0, 3000.0, 7500.0, 20_000.0] {
            let found = correlated_temperature_k(black_body(kelvin)).unwrap();
            assert!((found / kelvin - 1.0).abs() < 1e-6, "{kelvin}: {found}");
        }
        // A screen's green and blue are no shades of white.
        for rgb in [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            assert_eq!(correlated_temperature_k(xyz_from_rgb(rgb)), None, "{rgb:?}");
        }
    }

    /// Daylight's whites have their own temperature; that of 6504 K is sRGB's within the digits of both.
    #[test]
    fn whites_are_those_of_daylight_and_of_black_bodies() {
        for kelvin in [2000.0, 3999.0, 4500.0, 5500.0, 9000.0, 20_000.0] {
            let found = correlated_temperature_k(white_of_temperature(kelvin).unwrap()).unwrap();
            assert!((found / kelvin - 1.0).abs() < 3e-3, "{kelvin}: {found}");
        }
        let day = white_of_temperature(6504.0).unwrap();
        assert!((0..3).all(|c| (day[c] - D65_WHITE[c]).abs() < 1e-3), "{day:?}");
        for bad in [0.0, 1000.0, 30_000.0, f64::NAN] {
            assert!(white_of_temperature(bad).unwrap_err().to_string().contains("give 1500 to 25000 K"));
        }
    }

    /// What is white becomes white, and grey keeps its luminance; the other way round comes back.
    #[test]
    fn balancing_brings_a_white_to_that_of_srgb() {
        for illuminant in [Illuminant::A, Illuminant::D50, Illuminant::D65] {
            let white = white(illuminant);
            let seen = rgb_from_xyz(white.map(|value| value / white[1]));
            let shown = balance(white).map(|row| (0..3).map(|k| row[k] * seen[k]).sum::<f64>());
            assert!(shown.iter().all(|v| (v - 1.0).abs() < 1e-9), "{illuminant:?}: {shown:?}");
        }
        let same = balance(D65_WHITE);
        for (i, row) in same.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                assert!((value - f64::from(u8::from(i == j))).abs() < 1e-12);
            }
        }
    }
}
