//! Pictures made by rule: of a peacock's eye for a flat disk its colours, relief and outline, and of a bird's own eye an iris for a flat
//! square behind its cornea, with the pupil's hole.
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

/// The names of a peacock's.
pub const NAMES: [&str; 3] = ["eye:colour", "eye:bump", "eye:alpha"];
/// The names of an iris's: how bright its parts are, to be multiplied with its colour, and where it is.
pub const IRIS: [&str; 2] = ["eye:iris", "eye:pupil"];
/// Radius of the pupil over the iris's.
pub const PUPIL: f64 = 0.43;
/// Strands of an iris and of their bundles, and how much each sort of them varies.
const STRANDS: [(u64, f64); 3] = [(23, 0.16), (79, 0.3), (211, 0.34)];

/// The picture of a name, and a text that changes whenever it does.
///
/// # Errors
/// There is none of this name; the nearest is offered.
pub fn made(name: &str) -> Result<(Texture, String)> {
    let texel: fn(f64, f64) -> [f32; 3] = match name {
        "eye:colour" => colour,
        "eye:bump" => bump,
        "eye:alpha" => alpha,
        "eye:iris" => |x, y| iris([x, y].map(|mm| 2.0 * mm / SIDE_MM)),
        "eye:pupil" => |x, y| pupil([x, y].map(|mm| 2.0 * mm / SIDE_MM)),
        _ => {
            let known = [&NAMES[..], &IRIS[..]].concat();
            let near = did_you_mean(name, known.iter().copied());
            let known = known.join(", ");
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

/// Smooth noise around a circle of so many strands, 0 to 1; `which` tells several apart.
fn around(turns: f64, strands: u64, which: u64) -> f64 {
    let place = (turns - libm::floor(turns)) * strands as f64;
    let first = libm::floor(place);
    let of = |k: u64| unit_of(hash(0x6972_6973, &[which, (first as u64 + k) % strands]));
    let share = place - first;
    let eased = share * share * (3.0 - 2.0 * share);
    of(0) + eased * (of(1) - of(0))
}

/// From 0 at `low` to 1 at `high`.
fn eased(value: f64, low: f64, high: f64) -> f64 {
    let share = ((value - low) / (high - low)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// How bright an iris is at a place in units of its radius: wavy strands from pupil to rim, darker at both.
fn iris([x, y]: [f64; 2]) -> [f32; 3] {
    let radius = (x * x + y * y).sqrt();
    let turns = libm::atan2(y, x) / std::f64::consts::TAU;
    let bent = turns + 0.006 * libm::sin(19.0 * radius + 5.0 * around(turns, 9, 3));
    let strands: f64 =
        (0..).zip(STRANDS).map(|(which, (count, share))| share * around(bent, count, which)).sum();
    let most: f64 = STRANDS.iter().map(|(_, share)| share).sum();
    let within = 0.45 + 0.55 * eased(radius, PUPIL, PUPIL + 0.12);
    let rim = 1.0 - 0.72 * eased(radius, 0.8, 1.0);
    [((1.0 - most + strands) * within * rim) as f32; 3]
}

/// 1 where an iris is, 0 in the pupil and beyond the rim.
fn pupil([x, y]: [f64; 2]) -> [f32; 3] {
    let radius = (x * x + y * y).sqrt();
    [if (PUPIL..1.0).contains(&radius) { 1.0 } else { 0.0 }; 3]
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

    /// Strands vary around the iris, not along themselves; it is darker at the pupil and at the rim, and absent in the hole and beyond.
    #[test]
    fn an_iris_has_strands_and_a_hole() {
        let [shade, alpha] = IRIS.map(|name| made(name).unwrap().0);
        let place = |radius: f64, turns: f64| {
            let angle = std::f64::consts::TAU * turns;
            [0.5 * SIDE_MM * radius * angle.cos(), 0.5 * SIDE_MM * radius * angle.sin()]
        };
        for (radius, there) in
            [(0.0, 0.0), (PUPIL - 0.02, 0.0), (PUPIL + 0.02, 1.0), (0.98, 1.0), (1.02, 0.0)]
        {
            assert_eq!(at(&alpha, place(radius, 0.1))[0], there, "{radius}");
        }
        let ring = |radius: f64| -> Vec<f64> {
            (0..720).map(|k| at(&shade, place(radius, f64::from(k) / 720.0))[0]).collect()
        };
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let [inner, middle, outer] = [PUPIL + 0.01, 0.65, 0.97].map(ring);
        assert!(mean(&middle) > 1.4 * mean(&inner) && mean(&middle) > 2.0 * mean(&outer));
        assert!(middle.iter().all(|v| (0.15..=1.0).contains(v)));
        let apart =
            |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / a.len() as f64;
        let turned: Vec<f64> = (0..720).map(|k| middle[(k + 7) % 720]).collect();
        assert!(apart(&middle, &turned) > 2.0 * apart(&middle, &ring(0.655)), "strands lie around");
        assert!(made("eye:irs").unwrap_err().to_string().contains("did you mean 'eye:iris'"));
    }
}
