//! The ellipse against rays traced in space, the round section, plates, and exchange of directions.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::*;
use crate::bsdf::hair::section::{Round, tests::refract};
use crate::bsdf::hair::spread::wrap;
use crate::math::rng::Stream;

fn toward(azimuth: f64) -> DVec2 {
    DVec2::new(azimuth.cos(), azimuth.sin())
}

/// What is reflected, leaves first and leaves second: directions and powers of a ray through the elliptical cylinder
/// x² + z²/h² = 1, surface by surface, in space.
fn traced(
    height: f64,
    toward_viewer: DVec3,
    point: DVec3,
    index: f64,
    depth: f64,
) -> [(DVec3, f64); FOLLOWED] {
    let squares = DVec3::new(1.0, 0.0, 1.0 / (height * height));
    let d = -toward_viewer;
    let normal = (point * squares).normalize();
    let (inside, reflectance) = refract(d, normal, 1.0, index);
    let mut out = [(d - normal * (2.0 * d.dot(normal)), reflectance), (DVec3::ZERO, 0.0), (DVec3::ZERO, 0.0)];
    let mut inside = inside.unwrap();
    let (mut at, mut power, mut way) = (point, 1.0 - reflectance, 1);
    for _ in 0..MOST_CHORDS {
        let length = -2.0 * at.dot(inside * squares) / inside.dot(inside * squares);
        at += inside * length;
        power *= (-depth * length).exp();
        let outward = (at * squares).normalize();
        let (leaving, reflectance) = refract(inside, -outward, index, 1.0);
        if let Some(leaving) = leaving {
            out[way] = (leaving, power * (1.0 - reflectance));
            way += 1;
            if way == FOLLOWED {
                break;
            }
        }
        power *= reflectance;
        inside -= outward * (2.0 * inside.dot(outward));
    }
    out
}

/// Azimuths and powers of every way against the ray followed in space by the laws of Snell and Fresnel for vectors and
/// the length of its path alone. Reached: 2.3e-12 and 1.1e-13; near the critical angle the outer cosine loses digits.
#[test]
fn ways_are_those_of_a_ray_that_is_traced_in_space() {
    let mut stream = Stream::new(22, &[]);
    let (mut worst, mut compared, mut guided) = ([0.0_f64; 2], [0; FOLLOWED], 0);
    for _ in 0..4000 {
        let height = libm::exp(stream.uniform(-2.3, 2.3));
        let (offset, index) = (stream.uniform(-0.999, 0.999), stream.uniform(1.2, 2.0));
        let inclination = stream.uniform(-1.4, 1.4);
        let azimuth = stream.uniform(-PI, PI);
        let depth = stream.uniform(0.0, 2.0);
        let (sin, cos) = inclination.sin_cos();
        let v = toward(azimuth);
        let viewer = DVec3::new(cos * v.x, sin, cos * v.y);
        // The point by its definition: on the line at the distance offset × half the width seen, nearest to the viewer.
        let across = v.perp() * (offset * libm::hypot(v.y, height * v.x));
        let inverse = DVec2::new(1.0, 1.0 / (height * height));
        let (a, b) = (v.dot(v * inverse), across.dot(v * inverse));
        let c = across.dot(across * inverse) - 1.0;
        let on = across + v * ((-b + (b * b - a * c).sqrt()) / a);
        let section = Ellipse::new(height, v, offset, [sin, cos], index);
        let powers = section.attenuations_at(depth);
        let expected = traced(height, viewer, DVec3::new(on.x, 0.0, on.y), index, depth);
        guided += usize::from(
            section.lengths[0] > 2.0 * height.max(1.0) / (1.0 - sin * sin / index / index).sqrt() + 1e-9,
        );
        for (way, (direction, power)) in expected.into_iter().enumerate() {
            if direction == DVec3::ZERO {
                assert!(powers[way] == 0.0);
                continue;
            }
            compared[way] += 1;
            let found = azimuth + section.azimuths[way];
            let difference = (found - direction.z.atan2(direction.x)).rem_euclid(TAU);
            worst[0] = worst[0].max(difference.min(TAU - difference));
            worst[1] = worst[1].max((powers[way] - power).abs());
            assert!((direction.y + sin).abs() < 1e-9, "way {way}");
        }
    }
    println!("worst azimuth and power: {worst:?} of {compared:?} ways, {guided} guided");
    assert!(worst[0] < 1e-10 && worst[1] < 1e-11, "{worst:?}");
    assert!(compared.iter().all(|&count| count > 2500) && guided > 50);
}

/// Height over width 1 is the round section.
#[test]
fn an_ellipse_of_equal_axes_is_round() {
    let mut stream = Stream::new(23, &[]);
    for _ in 0..2000 {
        let (offset, index) = (stream.uniform(-0.9999, 0.9999), stream.uniform(1.2, 2.0));
        let (sin, cos) = stream.uniform(-1.5, 1.5).sin_cos();
        let depth = stream.uniform(0.0, 3.0);
        let round = Round::new(offset, [sin, cos], index);
        let ellipse = Ellipse::new(1.0, toward(stream.uniform(-PI, PI)), offset, [sin, cos], index);
        let powers = ellipse.attenuations_at(depth);
        for (found, expected) in powers.iter().zip(round.attenuations_at(depth)) {
            assert!((found - expected).abs() < 1e-9, "h {offset}: {found} {expected}");
        }
        for (found, expected) in ellipse.azimuths.iter().zip(round.azimuths) {
            assert!(wrap(wrap(found - expected)).abs() < 1e-9, "h {offset}: {found} {expected}");
        }
    }
}

/// In the middle of a very flat one light passes as through a plate: mirrored at it, straight through, its path
/// 2H/cosγ_t, TRT mirrored too.
#[test]
fn a_flat_ellipse_is_a_plate() {
    let (height, index, depth) = (1e-5, 1.56, 3e4);
    for tilt in [0.0, 0.4, -1.1] {
        let v = toward(0.5 * PI + tilt);
        // The ray meets the top's middle where its offset is 0: nearly, the ellipse is thin.
        let met = v.perp().dot(DVec2::new(0.0, height)) / libm::hypot(v.y, height * v.x);
        let section = Ellipse::new(height, v, met, [0.0, 1.0], index);
        let f = fresnel(tilt.cos(), index);
        let inside = (1.0 - (tilt.sin() / index).powi(2)).sqrt();
        let kept = (-depth * 2.0 * height / inside).exp();
        let expected = [f, (1.0 - f) * (1.0 - f) * kept, (1.0 - f) * kept * f * kept * (1.0 - f)];
        let azimuths = [-2.0 * tilt, PI, -2.0 * tilt];
        for way in 0..FOLLOWED {
            let power = section.attenuations_at(depth)[way];
            assert!((power - expected[way]).abs() < 1e-8, "way {way}: {power} {}", expected[way]);
            let difference = (section.azimuths[way] - azimuths[way]).rem_euclid(TAU);
            assert!(difference.min(TAU - difference) < 1e-8, "way {way}: {difference}");
        }
    }
}

/// Mirrored left to right, rays leave at the mirrored azimuths with the same powers.
#[test]
fn a_mirrored_ray_goes_the_mirrored_way() {
    let mut stream = Stream::new(24, &[]);
    for _ in 0..500 {
        let (height, offset) = (stream.uniform(0.2, 5.0), stream.uniform(-0.99, 0.99));
        let (sin, cos) = stream.uniform(-1.4, 1.4).sin_cos();
        let v = toward(stream.uniform(-PI, PI));
        let one = Ellipse::new(height, v, offset, [sin, cos], 1.55);
        for mirrored in [DVec2::new(-v.x, v.y), DVec2::new(v.x, -v.y)] {
            let other = Ellipse::new(height, mirrored, -offset, [sin, cos], 1.55);
            for way in 0..FOLLOWED {
                assert!(wrap(one.azimuths[way] + other.azimuths[way]).abs() < 1e-9);
                assert!((one.attenuations_at(0.3)[way] - other.attenuations_at(0.3)[way]).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn nothing_is_lost_without_absorption() {
    for height in [0.1, 0.5, 1.0, 3.0, 10.0] {
        for azimuth in [0.0, 0.3, 0.5 * PI, 2.0, PI] {
            for offset in [-1.0, -0.9, 0.0, 0.3, 0.999_999, 1.0] {
                for inclination in [0.0, 0.8, -1.5, 0.5 * PI] {
                    let (sin, cos) = f64::sin_cos(inclination);
                    let section = Ellipse::new(height, toward(azimuth), offset, [sin, cos.max(0.0)], 1.55);
                    let sum: f64 = section.attenuations_at(0.0).iter().sum();
                    assert!((sum - 1.0).abs() < 1e-12, "{height} {azimuth} {offset} {inclination}: {sum}");
                }
            }
        }
    }
}

/// Rays keep their étendue: what reaches the azimuths b of all rays (azimuth and distance from the axis) that come from the
/// azimuths a is, way by way, what reaches a from b, with absorption too. This is the reciprocity of the far field: (width
/// seen from a) × mean over the offset.
#[test]
fn the_far_field_is_reciprocal_way_by_way() {
    const BINS: usize = 12;
    let (height, index, depth, inclination) = (0.4, 1.55, 0.3, 0.5);
    let (sin, cos) = f64::sin_cos(inclination);
    let (azimuths, offsets) = (2400, 1500);
    let bin = |azimuth: f64| ((azimuth.rem_euclid(TAU) / TAU * BINS as f64) as usize).min(BINS - 1);
    let mut transfer = [[[0.0; BINS]; BINS]; FOLLOWED];
    for i in 0..azimuths {
        // The bins' edges stand askew to the ellipse, so that no symmetry makes the test pass.
        let azimuth = TAU * (f64::from(i) + 0.5) / f64::from(azimuths);
        let v = toward(azimuth + 0.2);
        let width = libm::hypot(v.y, height * v.x);
        for j in 0..offsets {
            let offset = 2.0 * (f64::from(j) + 0.5) / f64::from(offsets) - 1.0;
            let section = Ellipse::new(height, v, offset, [sin, cos], index);
            let powers = section.attenuations_at(depth);
            for way in 0..FOLLOWED {
                transfer[way][bin(azimuth)][bin(azimuth + section.azimuths[way])] += width * powers[way];
            }
        }
    }
    for (way, transfer) in transfer.iter().enumerate() {
        let most = transfer.iter().flatten().fold(0.0, |most: f64, v| most.max(*v));
        let mut worst = 0.0_f64;
        let mut asymmetry = 0.0_f64;
        for a in 0..BINS {
            for b in 0..BINS {
                worst = worst.max((transfer[a][b] - transfer[b][a]).abs() / most);
                asymmetry =
                    asymmetry.max((transfer[a][b] - transfer[(a + 1) % BINS][(b + 1) % BINS]).abs() / most);
            }
        }
        println!("way {way}: exchange changes {worst:.1e} of the largest, a turn of both {asymmetry:.2}");
        assert!(worst < 3e-3 && asymmetry > 0.1, "way {way}: {worst}");
    }
}

/// How much leaves later than the followed ways, and how much of it was guided over more chords than are followed.
#[test]
fn little_is_guided_over_more_chords_than_are_followed() {
    for height in [0.1, 0.25, 0.5, 0.7, 1.5, 2.0, 4.0, 10.0] {
        let (mut later, mut cut, mut count) = (0.0, 0.0, 0.0);
        for i in 0..60 {
            let v = toward(TAU * (f64::from(i) + 0.5) / 60.0);
            let width = libm::hypot(v.y, height * v.x);
            for j in 0..400 {
                let offset = 2.0 * (f64::from(j) + 0.5) / 400.0 - 1.0;
                let section = Ellipse::new(height, v, offset, [0.3, 0.954], 1.55);
                let powers = section.attenuations_at(0.0);
                later += width * powers[3];
                cut += if section.reflectances[1] == 1.0 { width * powers[3] } else { 0.0 };
                count += width;
            }
        }
        println!("height over width {height}: later {:.4}, cut {:.4}", later / count, cut / count);
        assert!(cut / count < 0.02);
    }
}
