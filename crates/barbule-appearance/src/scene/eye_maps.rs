//! Pictures of a peacock's eye for a flat disk, made by rule: colours, relief and outline.
//!
//! Rings are those of the flat vane, about the middle of the eye; barbs fan out from a place of the rachis below it. Scenes name the
//! pictures `eye:colour`, `eye:bump` and `eye:alpha` where they could name files.

use crate::bsdf::{Ring, Texture};
use crate::error::did_you_mean;
use crate::math::rng::{hash, unit_of};
use crate::spectrum::colour::decode;
use crate::{Error, Result};

/// What names of these pictures begin with.
const PREFIX: &str = "eye:";
/// Width and height, pixels.
pub const SIDE: usize = 1024;
/// Width and height of what they show, mm.
pub const SIDE_MM: f64 = 68.0;
/// How far below the eye's middle its barbs fan out from, mm; their distance at the middle, mm.
const FAN_MM: f64 = 62.0;
const SPACING_MM: f64 = 0.5;
/// Half axes of the disk across and along the feather, mm.
const DISK_MM: [f64; 2] = [26.0, 28.0];
/// How far the disk's border strays from barb to barb, as a share.
const FRAY: f64 = 0.09;

/// Rings from within: outer radius in mm, and the colour on a screen. Radii as in the barbs' own zones; the first two are blue.
const RINGS: [(f64, [u8; 3]); 7] = [
    (6.0, [38, 34, 150]),
    (7.2, [24, 70, 190]),
    (11.0, [26, 148, 138]),
    (18.0, [134, 84, 34]),
    (20.0, [188, 160, 62]),
    (24.0, [66, 116, 52]),
    (f64::INFINITY, [92, 86, 44]),
];

/// The heart about which the rings lie, mm: wider towards the tip, with a notch towards the base.
#[must_use]
pub fn heart() -> Ring {
    Ring { stretch: 1.1, widening_per_mm: 0.005, notch_mm: [4.5, 2.8], ..Ring::disc([0.0; 2], 6.0) }
}

/// Whether a name is one of these pictures, or meant to be.
#[must_use]
pub fn is_made(name: &str) -> bool {
    name.starts_with(PREFIX)
}

/// The names of these pictures.
pub const NAMES: [&str; 3] = ["eye:colour", "eye:bump", "eye:alpha"];

/// The picture of a name, and a text that changes whenever it does.
///
/// # Errors
/// There is none of this name; the nearest is offered.
pub fn made(name: &str) -> Result<(Texture, String)> {
    let texel: fn(f64, f64) -> [f32; 3] = match name {
        "eye:colour" => colour,
        "eye:bump" => bump,
        "eye:alpha" => alpha,
        _ => {
            let near = did_you_mean(name, NAMES);
            let known = NAMES.join(", ");
            return Err(Error::input(format!("there is no picture '{name}'{near} (known are {known})")));
        }
    };
    let mm = |pixel: usize| SIDE_MM * ((pixel as f64 + 0.5) / SIDE as f64 - 0.5);
    let texels = (0..SIDE * SIDE).map(|i| texel(mm(i % SIDE), -mm(i / SIDE))).collect();
    Ok((Texture::new([SIDE, SIDE], texels)?, format!("{name} 1")))
}

/// Which barb a place lies on, counted from the shaft, and how far along it from where they fan out, mm.
fn barb(x: f64, y: f64) -> [f64; 2] {
    let up = y + FAN_MM;
    [libm::atan2(x, up) * FAN_MM / SPACING_MM, (x * x + up * up).sqrt()]
}

/// A number of a barb from 0 to 1; `which` tells several apart.
fn of_barb(barb: f64, which: u64) -> f64 {
    unit_of(hash(0x7065_6163_6f63_6b00 + which, &[libm::floor(barb) as i64 as u64]))
}

/// Linear light: the ring's colour, shifted and shaded from barb to barb.
fn colour(x: f64, y: f64) -> [f32; 3] {
    let [index, _] = barb(x, y);
    let radius = heart().radius([x, y]) + 0.5 * (of_barb(index, 0) - 0.5);
    let ring = RINGS.iter().position(|(outer, _)| radius < *outer).unwrap_or(RINGS.len() - 1);
    let shade = 0.82 + 0.36 * of_barb(index, 1);
    RINGS[ring].1.map(|v| (decode(f64::from(v) / 255.0) * shade).min(1.0) as f32)
}

/// Heights |sin(π u)| of the place u across the barbs, as a share of the highest.
fn bump(x: f64, y: f64) -> [f32; 3] {
    let [index, _] = barb(x, y);
    [libm::sin(std::f64::consts::PI * index).abs() as f32; 3]
}

/// 1 within a border that strays from barb to barb, 0 beyond.
fn alpha(x: f64, y: f64) -> [f32; 3] {
    let [index, _] = barb(x, y);
    let place = [x / DISK_MM[0], y / DISK_MM[1]];
    let radius = (place[0] * place[0] + place[1] * place[1]).sqrt();
    let border = 1.0 + FRAY * (2.0 * of_barb(index, 2) - 1.0);
    [if radius < border { 1.0 } else { 0.0 }; 3]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::blueness;

    fn at(picture: &Texture, [x, y]: [f64; 2]) -> [f64; 3] {
        picture.at([0.5 + x / SIDE_MM, 0.5 + y / SIDE_MM])
    }

    #[test]
    fn the_pictures_are_the_same_each_time_and_show_an_eye() {
        let [colour, bump, alpha] = NAMES.map(|name| made(name).unwrap().0);
        assert_eq!(colour, made("eye:colour").unwrap().0);
        // Blue in the heart and in no ring beyond turquoise; the notch is no blue.
        for place in [[0.0, 2.0], [4.0, 0.0], [-5.0, 1.0]] {
            assert!(blueness(at(&colour, place)) > 0.9, "{place:?}");
        }
        for place in [[15.0, 0.0], [0.0, -20.0], [-22.0, 3.0], [0.0, -11.0]] {
            assert_eq!(blueness(at(&colour, place)), 0.0, "{place:?}");
        }
        let mean = |picture: &Texture, of: &dyn Fn(f64) -> f64| {
            let places = (0..900).map(|i| [f64::from(i % 30) - 14.5, f64::from(i / 30) - 14.5]);
            places.map(|place| of(at(picture, place)[0])).sum::<f64>() / 900.0
        };
        // The mean of |sin| and of its square.
        assert!((mean(&bump, &|h| h) - 2.0 / std::f64::consts::PI).abs() < 0.03);
        assert!((mean(&bump, &|h| h * h) - 0.5).abs() < 0.04);
        assert_eq!((at(&alpha, [0.0, 0.0])[0], at(&alpha, [30.0, 0.0])[0]), (1.0, 0.0));
        // Near the border some barbs reach farther than others.
        let border: Vec<f64> = (0..200)
            .map(|i| {
                let turn = 0.01 * f64::from(i) - 1.0;
                at(&alpha, [DISK_MM[0] * turn.sin(), DISK_MM[1] * turn.cos()])[0]
            })
            .collect();
        assert!(border.iter().any(|a| *a < 0.5) && border.iter().any(|a| *a > 0.5));
        assert!(made("eye:color").unwrap_err().to_string().contains("did you mean 'eye:colour'"));
    }
}
