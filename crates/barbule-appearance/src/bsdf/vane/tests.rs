//! The vane against its masking, energy, its sampling, and where its highlights must lie.

use std::f64::consts::PI;

use super::super::masking::RIGHT;
use super::super::tests::{PATH, assert_samples_follow_density, barbule, hit, keratin, viewers};
use super::super::{Absorption, FibreIndex, Hair, HairParameters, Surface};
use super::*;
use crate::bsdf::masking::Barbules;
use crate::math::rng::Stream;

fn fibre(height_over_width: f64, roughness: f64, depth: f64) -> Substance {
    let parameters = HairParameters {
        longitudinal_roughness: roughness,
        azimuthal_roughness: roughness,
        scale_tilt: 0.0,
        index: FibreIndex::Constant(1.55),
        absorption: Absorption::new(|_| depth).unwrap(),
        height_over_width,
    };
    Substance::Fibre(Hair::new(parameters).unwrap())
}

fn barbs(lift: f64) -> Barbs {
    let one = |angle: f64| Barbules {
        length: 180.0,
        angle: angle.to_radians(),
        lift: f64::to_radians(lift),
        tilt: 0.0,
        half_width: 4.0,
        height_over_width: 0.6,
        spacing: 25.0,
    };
    Barbs { spacing: 250.0, half_width: 15.0, height_over_width: 2.0, barbules: [one(35.0), one(35.0)] }
}

fn vane(barbs: Barbs, roughness: f64, depth: f64) -> VaneSurface {
    let barbules = || fibre(0.6, roughness, depth);
    VaneSurface::new(barbs, [fibre(2.0, roughness, depth), barbules(), barbules()], 0.0)
}

/// The hit of another ray on the same vane.
fn another(number: u32) -> Hit {
    Hit { position: DVec3::new(f64::from(number) * 0.01, 0.3, 1.0), id: 3, ..hit() }
}

/// Hits show each part as often as masking weights it, within 4 deviations, and pass what is left; from both ends of a line
/// as much.
#[test]
fn hits_show_each_part_by_its_weight() {
    let vane = vane(barbs(10.0), 0.3, 0.0);
    for wo in viewers() {
        let local = hit().frame.to_local(wo);
        let seen = vane.masking().seen(local);
        let opacity = vane.opacity(&hit(), wo);
        assert!((opacity - (1.0 - seen[PARTS])).abs() < 1e-12);
        assert!((opacity - vane.opacity(&hit(), -wo)).abs() < 1e-5);
        let count = 20_000;
        let mut counts = [0.0; PARTS];
        for number in 0..count {
            let hit = another(number);
            let name = hash(hit.id, &hit.position.to_array().map(f64::to_bits));
            counts[vane.part(local, unit_of(name))] += 1.0 / f64::from(count);
        }
        for (found, weight) in counts.iter().zip(seen) {
            let expected = weight / opacity;
            let deviation = (expected * (1.0 - expected) / f64::from(count)).sqrt();
            assert!((found - expected).abs() < 4.0 * deviation + 1e-9, "{found} {expected}");
        }
    }
}

/// The place that is drawn on a section is where a ray at its offset meets the section, by the ellipse alone: offset and
/// normal agree. Without neighbours offsets are even; of a closed row of tiles only the uncovered part is drawn.
#[test]
fn places_on_sections_are_where_rays_meet_them() {
    let alone = Barbs {
        spacing: 1e5,
        barbules: barbs(0.0).barbules.map(|b| Barbules { length: 1e-3, ..b }),
        ..barbs(0.0)
    };
    let tiles = Barbs {
        barbules: barbs(0.0).barbules.map(|b| Barbules { half_width: 12.0, tilt: 0.3, ..b }),
        ..barbs(0.0)
    };
    let mut stream = Stream::new(81, &[]);
    for (barbs, part) in [(alone, RAMUS), (tiles, LEFT), (tiles, RIGHT)] {
        let table = MaskingTable::new(&barbs);
        let ([x, y, z], height) = match part {
            RAMUS => ([DVec3::X, DVec3::Y, DVec3::Z], barbs.height_over_width),
            _ => (barbs.barbules[part - 1].axes(2.0 * part as f64 - 3.0), 0.6),
        };
        for _ in 0..20 {
            let wo = DVec3::new(stream.uniform(-0.7, 0.7), stream.uniform(-0.7, 0.7), 0.7).normalize();
            let seen = table.part(part, wo);
            let count = 400;
            let mut offsets = Vec::new();
            for i in 0..count {
                let u = (f64::from(i) + 0.5) / f64::from(count);
                let (offset, normal) = table.place(part, &seen, wo, u);
                let (nx, nz) = (normal.dot(x), normal.dot(z));
                assert!(normal.dot(wo) > -1e-9 && normal.dot(y).abs() < 1e-9);
                // The ellipse's point of this normal, and its distance from the axis as the ray sees it.
                let scale = (nx * nx + height * height * nz * nz).sqrt();
                let point = (x * (nx) + z * (height * height * nz)) / scale;
                let side = wo.cross(y).normalize();
                let half = (x.dot(side).powi(2) + (height * z.dot(side)).powi(2)).sqrt();
                assert!((point.dot(side) / half - offset).abs() < 1e-6, "{offset}");
                offsets.push(offset);
            }
            offsets.sort_by(f64::total_cmp);
            let range = offsets[offsets.len() - 1] - offsets[0];
            if part == RAMUS {
                // Even: the k-th of them stands at its share.
                for (k, offset) in offsets.iter().enumerate() {
                    let even = 2.0 * (k as f64 + 0.5) / f64::from(count) - 1.0;
                    assert!((offset - even).abs() < 0.01, "{offset} {even}");
                }
            } else {
                let barbules = barbs.barbules[part - 1];
                let step = (DVec3::Y - y * y.y) * barbules.spacing;
                let side = wo.cross(y).normalize();
                let half =
                    barbules.half_width * (x.dot(side).powi(2) + (height * z.dot(side)).powi(2)).sqrt();
                let visible = (step.dot(side).abs() / (2.0 * half)).min(1.0);
                // Within the pieces of the circumference.
                assert!((0.5 * range - visible).abs() < 0.15, "{range} {visible}");
            }
        }
    }
}

/// For hits of every part and substance. Five deviations.
#[test]
fn samples_of_every_part_follow_their_density() {
    let plate = || Substance::Plate(barbule());
    let surfaces = [
        ("fibres", vane(barbs(10.0), 0.3, 0.2)),
        ("plates", VaneSurface::new(barbs(20.0), [Substance::Keratin(keratin(5.0)), plate(), plate()], 0.03)),
    ];
    for (name, vane) in surfaces {
        let surface = Surface::Vane(Box::new(vane));
        for wo in viewers() {
            for number in 0..5 {
                let hit = another(number);
                let bsdf = surface.bind(&hit, wo, Lambdas::new(PATH));
                assert_samples_follow_density(name, &bsdf, |_| {});
            }
        }
        assert!(!surface.is_opaque());
    }
}

/// Mean over hits of the sampled albedo.
fn albedo(vane: &VaneSurface, wo: DVec3) -> f64 {
    let mut stream = Stream::new(82, &[]);
    let count = 20_000;
    let mut sum = 0.0;
    for number in 0..count {
        let bsdf = vane.bind(&another(number), wo, Lambdas::new(PATH));
        if let Some(sample) = bsdf.sample([stream.unit(), stream.unit(), stream.unit()]) {
            let e = sample.evaluation;
            sum += e.f[0] * e.cosine / e.pdf[0] / f64::from(count);
        }
    }
    sum
}

/// Without absorption each part gives all that it gets: what is missing is what shadows keep, nothing where barbs stand far
/// apart. Monte Carlo: 1 %.
#[test]
fn white_vanes_lose_only_what_their_shadows_keep() {
    let sparse = Barbs {
        spacing: 5000.0,
        barbules: barbs(0.0).barbules.map(|b| Barbules { length: 1e-3, ..b }),
        ..barbs(0.0)
    };
    let sparse = vane(sparse, 0.4, 0.0);
    let dense = vane(barbs(10.0), 0.4, 0.0);
    for wo in viewers() {
        let alone = albedo(&sparse, wo);
        assert!((alone - 1.0).abs() < 0.01, "{alone}");
        let given = albedo(&dense, wo);
        let opacity = dense.opacity(&hit(), wo);
        println!("opacity {opacity:.3}, of what is met given back {given:.3}");
        assert!(given < 1.0 && given > 0.5);
    }
}

/// Bands of highlights: light is mirrored into the cone about each axis, so seen along the normal the rami's band lies across the
/// barb and those of the barbules at their angle to both sides. There the vane is at least three times as bright as its rami
/// alone.
#[test]
fn barbules_add_two_bands_of_highlights() {
    let angle = 50_f64.to_radians();
    let of_length = |length: f64| {
        let barbules = barbs(0.0).barbules.map(|b| Barbules { length, angle, ..b });
        vane(Barbs { barbules, ..barbs(0.0) }, 0.08, 8.0)
    };
    let (vane, bare) = (of_length(140.0), of_length(1e-3));
    let wo = hit().frame.z;
    // Radiance from light that falls at 35° from this azimuth (from x to y).
    let radiance = |vane: &VaneSurface, azimuth: f64| {
        let (sin, cos) = azimuth.sin_cos();
        let wi = hit().frame.to_world(DVec3::new(cos * 0.574, sin * 0.574, 0.819));
        let count = 2000;
        let mean: f64 = (0..count)
            .map(|number| {
                let e = vane.bind(&another(number), wo, Lambdas::new(PATH)).eval(wi);
                e.f[0] * e.cosine / f64::from(count)
            })
            .sum();
        mean * vane.opacity(&hit(), wo)
    };
    let step = PI / 90.0;
    let around: Vec<f64> = (-45..45).map(|k| radiance(&vane, f64::from(k) * step)).collect();
    let rami: Vec<f64> = (-45..45).map(|k| radiance(&bare, f64::from(k) * step)).collect();
    let brightest =
        |from: usize, to: usize| (from..to).max_by(|a, b| around[*a].total_cmp(&around[*b])).unwrap();
    for (from, to, expected) in [(8, 33, -50.0), (35, 56, 0.0), (58, 83, 50.0)] {
        let k = brightest(from, to);
        let degrees = 2.0 * (k as f64 - 45.0);
        println!("band at {degrees} degrees: {:.4} of the vane, {:.4} of its rami", around[k], rami[k]);
        assert!((degrees - expected).abs() <= 4.0, "{degrees}");
        if expected != 0.0 {
            assert!(around[k] > 3.0 * rami[k] && around[k] > around[k - 5] && around[k] > around[k + 5]);
        }
    }
}
