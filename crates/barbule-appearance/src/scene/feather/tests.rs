//! What a grown feather must be, for every type and species that is shipped.

mod train;

use glam::DVec2;

use super::barb::laid_out;
use super::row::{BORDER, FlatBarb};
use super::*;
use crate::bsdf::{Region, Ring, ZonePlan};
use crate::fields::Record as _;
use crate::scene::description::SceneDescription;
use crate::scene::geometry::{Geometry, RibbonNode};
use crate::scene::preset;

fn feather(name: &str) -> Feather {
    *SceneDescription::named(name).unwrap().feather().unwrap()
}

fn species() -> impl Iterator<Item = (&'static str, Feather)> {
    preset::names()
        .filter_map(|name| Some((name, SceneDescription::named(name).unwrap().lone_feather()?.feather)))
}

/// The feathers of all presets and all types.
fn all() -> impl Iterator<Item = (&'static str, Feather)> {
    species().chain(names().map(|name| (name, Feather::of_type(name).unwrap())))
}

/// Those whose barbs end on the outline.
fn without_eye() -> impl Iterator<Item = (&'static str, Feather)> {
    all().filter(|(_, feather)| !feather.eye.is_there())
}

/// The same without anything random, all in one plane.
fn orderly(mut feather: Feather) -> Feather {
    let disorder = &mut feather.disorder;
    for size in [
        &mut disorder.barb_length,
        &mut disorder.barb_angle,
        &mut disorder.barb_spacing,
        &mut disorder.barb_wave,
        &mut disorder.barb_end,
        &mut disorder.wear,
        &mut disorder.clump,
        &mut disorder.barbule_angle,
        &mut disorder.barbule_lift,
        &mut disorder.barbule_spacing,
        &mut disorder.barbule_length,
        &mut disorder.barbule_turn,
    ] {
        *size = 0.0;
    }
    feather.splits.count = 0.0;
    feather.downy.share = 0.0;
    feather
}

fn window(feather: &Feather) -> VaneDisc {
    VaneDisc { along_mm: 0.75 * feather.shaft.length_mm, radius_mm: Some(1.1) }
}

const WHOLE: VaneDisc = VaneDisc { along_mm: 0.0, radius_mm: None };

fn rows(feather: &Feather, seed: u64) -> [Vec<FlatBarb>; 2] {
    let shaft = Shaft::new(&feather.shaft);
    [-1.0, 1.0].map(|side| laid_out(feather, &shaft, side, (seed, 1), &Unobserved).unwrap())
}

#[test]
fn the_same_seed_gives_the_same_feather_and_another_does_not() {
    let grow = |seed| {
        let feather = feather("starling");
        feather
            .grow(window(&feather), Level::Barbules, None, seed, 5)
            .unwrap()
            .barbules
            .map(|row| row.ribbon_nodes)
    };
    assert_eq!(grow(1), grow(1));
    assert_ne!(grow(1), grow(2));
}

/// ∫ ds sin(angle)/p over the vane below its tuft, by another rule than the growth's.
#[test]
fn barbs_are_as_many_as_their_perpendicular_spacing_says() {
    for (name, feather) in without_eye() {
        let shaft = Shaft::new(&feather.shaft);
        let [first, tip] = shaft.vane_range();
        let last = tip - feather.barbs.tuft * (tip - first);
        for (side, barbs) in [-1.0, 1.0].into_iter().zip(rows(&feather, 1)) {
            let steps = 20_000;
            let step = (last - first) / f64::from(steps);
            let expected: f64 = (0..steps)
                .map(|i| {
                    let t = shaft.vane(first + (f64::from(i) + 0.5) * step);
                    let angle = feather.barbs.insertion(feather.vane_at(side), t);
                    step * angle.sin().max(0.15) / (1e-3 * feather.barbs.spacing_um)
                })
                .sum();
            let count = barbs.iter().filter(|barb| !barb.is_tuft).count() as f64;
            assert!((count - expected).abs() <= 1.0, "{name}: {count} {expected}");
        }
    }
}

/// Curved, curled barbs, camber and bent shaft included, against the outline's formula written out again.
#[test]
fn ends_of_barbs_lie_on_the_outline() {
    for (name, feather) in without_eye() {
        let feather = orderly(feather);
        let (shape, shaft) = (&feather.barbs, Shaft::new(&feather.shaft));
        for (side, barbs) in [-1.0, 1.0].into_iter().zip(rows(&feather, 1)) {
            let is_leading = feather.vane_at(side) == Vane::Leading;
            assert!(barbs.len() > 10, "{name}");
            for barb in barbs {
                let end = barb.path[barb.path.len() - 1];
                let (a, b) = (shape.outline_base, shape.outline_tip);
                let (t, m) = (shaft.vane(end.y).clamp(0.0, 1.0), a / (a + b));
                let full =
                    if is_leading { shape.leading_half_width_mm } else { shape.trailing_half_width_mm };
                let mut width = full * (t / m).powf(a) * ((1.0 - t) / (1.0 - m)).powf(b);
                if is_leading {
                    let x = ((t - shape.emargination_start) / 0.08).clamp(0.0, 1.0);
                    width *= 1.0 - shape.emargination * x * x * (3.0 - 2.0 * x);
                }
                // Nowhere inside the shaft.
                let width = width.max(shaft.radius(end.y));
                assert!(
                    (end.x - width).abs() < 0.05 || end.y >= feather.shaft.length_mm,
                    "{name}: {end} {width}"
                );
                assert!(end.y < feather.shaft.length_mm + 0.05, "{name}: {end}");
            }
        }
    }
}

/// In space the ends are where the plane says: beside the shaft's station, at the outline's distance.
#[test]
fn raised_barbs_keep_their_place_beside_a_bent_shaft() {
    for (name, feather) in without_eye() {
        let feather = orderly(feather);
        let (shaft, barbs) = feather.barbs_within(WHOLE, (1, 1), &Unobserved).unwrap();
        let flat = rows(&feather, 1).concat();
        assert_eq!(barbs.len(), flat.len());
        for (barb, flat) in barbs.iter().zip(&flat) {
            let end = flat.path[flat.path.len() - 1];
            let station = shaft.at(end.y);
            let offset = barb.points[barb.points.len() - 1] - station.point;
            assert!((offset.dot(station.right) * barb.side - end.x).abs() < 1e-9, "{name}");
            assert!(offset.dot(station.tip).abs() < 1e-9, "{name}");
            let lengths: f64 = barb.points.windows(2).map(|pair| (pair[1] - pair[0]).length()).sum();
            assert!((lengths / barb.length_mm - 1.0).abs() < 2e-3, "{name}");
            for (tangent, normal) in barb.tangents.iter().zip(&barb.normals) {
                assert!(tangent.dot(*normal).abs() < 1e-9 && (normal.length() - 1.0).abs() < 1e-9, "{name}");
            }
        }
    }
}

/// A left wing's feather is the mirror image of a right wing's, with all its disorder.
#[test]
fn feathers_of_the_two_wings_mirror_each_other() {
    for (name, feather) in all() {
        let mut other = feather;
        other.leading =
            if feather.leading == LeadingSide::Left { LeadingSide::Right } else { LeadingSide::Left };
        other.shaft.bend = -feather.shaft.bend;
        other.shaft.bend_quadratic = -feather.shaft.bend_quadratic;
        other.shaft.torsion = -feather.shaft.torsion;
        let barbs = |feather: &Feather, side: f64| -> Vec<Barb> {
            let (_, barbs) = feather.barbs_within(WHOLE, (3, 1), &Unobserved).unwrap();
            barbs.into_iter().filter(|barb| barb.side == side).collect()
        };
        for side in [-1.0, 1.0] {
            let (these, those) = (barbs(&feather, side), barbs(&other, -side));
            assert_eq!(these.len(), those.len());
            for (a, b) in these.iter().zip(&those) {
                for (p, q) in a.points.iter().zip(&b.points) {
                    assert!(
                        (p.x + q.x).abs() + (p.y - q.y).abs() + (p.z - q.z).abs() < 1e-9,
                        "{name}: {p} {q}"
                    );
                }
            }
        }
        let window = window(&feather);
        let [here, there] = [&feather, &other].map(|feather| {
            let [distal, _] = feather.grow(window, Level::Barbules, None, 3, 1).unwrap().barbules;
            distal
        });
        assert_eq!(here.ribbons.len(), there.ribbons.len(), "{name}");
        let key = |n: &RibbonNode, sign: f32| (1e6 * sign * n.point.x) as i64 + (1e3 * n.point.y) as i64;
        let sum = |g: &Geometry, sign: f32| g.ribbon_nodes.iter().map(|n| key(n, sign)).sum::<i64>() as f64;
        let (a, b) = (sum(&here, 1.0), sum(&there, -1.0));
        assert!((a - b).abs() <= 4.0 * here.ribbon_nodes.len() as f64, "{name}: {a} {b}");
    }
}

#[test]
fn a_feather_twice_as_large_has_as_many_barbs_if_its_spacing_grows_too() {
    let small = feather("magpie");
    let mut large = small;
    large.shaft.length_mm *= 2.0;
    large.shaft.radius_mm *= 2.0;
    large.shaft.tip_radius_mm *= 2.0;
    large.barbs.leading_half_width_mm *= 2.0;
    large.barbs.trailing_half_width_mm *= 2.0;
    let count = |feather: &Feather| rows(feather, 1).concat().len() as f64;
    let fixed = count(&large);
    large.barbs.spacing_um *= 2.0;
    assert!((count(&large) - count(&small)).abs() <= 2.0, "{} {}", count(&large), count(&small));
    assert!((fixed / count(&small) - 2.0).abs() < 0.02, "{fixed} {}", count(&small));
}

/// Whether two polylines cross.
fn cross(a: &[DVec2], b: &[DVec2]) -> bool {
    let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    a.windows(2).any(|s| {
        b.windows(2).any(|t| {
            side(s[0], s[1], t[0]) * side(s[0], s[1], t[1]) < 0.0
                && side(t[0], t[1], s[0]) * side(t[0], t[1], s[1]) < 0.0
        })
    })
}

#[test]
fn hooked_barbs_do_not_cross_even_at_splits() {
    for (name, feather) in without_eye() {
        let split = |count: f64, seed: u64| {
            let mut feather = feather;
            feather.splits.count = count;
            rows(&feather, seed)
        };
        for seed in 1..4 {
            let mut splits = 0;
            for (barbs, before) in split(12.0, seed).iter().zip(&split(0.0, seed)) {
                for k in 1..barbs.len() {
                    let pair = [&barbs[k - 1], &barbs[k]];
                    if pair.iter().any(|barb| barb.looseness > 0.0 || barb.is_tuft) {
                        continue;
                    }
                    let was = cross(&before[k - 1].path, &before[k].path);
                    let bases = pair.map(|barb| (barb.along, barb.angle, barb.length, barb.is_free));
                    let crosses = cross(&pair[0].path, &pair[1].path);
                    assert!(!crosses, "{name}, seed {seed}: {was} {bases:?}");
                    if pair[0].is_free[0] {
                        assert!(pair[1].is_free[1]);
                        splits += 1;
                        let end = |barb: &FlatBarb| barb.path[barb.path.len() - 1];
                        let gap = |row: &[FlatBarb]| (end(&row[k]) - end(&row[k - 1])).length();
                        assert!(gap(barbs) > gap(before) + 0.04 * pair[0].length, "{name}: {}", gap(barbs));
                    }
                }
            }
            assert!(splits > 0 || feather.downy.share >= 1.0, "{name}");
        }
    }
}

#[test]
fn the_downy_part_is_loose_and_the_rest_lies_in_the_vane() {
    for (name, feather) in all() {
        let share = feather.downy.share;
        let (shaft, barbs) = feather.barbs_within(WHOLE, (1, 1), &Unobserved).unwrap();
        let t = |barb: &Barb| shaft.vane(barb.along_mm);
        // Within the border both kinds alternate; bases differ from their even places a little.
        let [from, to] = [1.0 - 0.5 * BORDER, 1.0 + 0.5 * BORDER].map(|side| side * share);
        assert!(barbs.iter().filter(|barb| t(barb) < from - 0.01).all(|barb| barb.is_loose), "{name}");
        let above = |barb: &&Barb| share < 1.0 && t(barb) > to + 0.01;
        assert!(barbs.iter().filter(above).all(|barb| !barb.is_loose), "{name}");
        let within: Vec<bool> =
            barbs.iter().filter(|barb| t(barb) > from && t(barb) < to).map(|barb| barb.is_loose).collect();
        let both = within.contains(&true) && within.contains(&false);
        assert!(both || share >= 1.0 || within.len() < 8, "{name}: {}", within.len());
        let [distal, _] = feather.barbules_of(&barbs[0]);
        let is_downy = distal.length_um == feather.downy.length_um;
        assert_eq!(is_downy, barbs[0].is_loose, "{name}");
    }
    // Down stands all round: ends in every quadrant about the shaft.
    let (shaft, barbs) = Feather::of_type("down").unwrap().barbs_within(WHOLE, (1, 1), &Unobserved).unwrap();
    assert!((20..=60).contains(&barbs.len()), "{}", barbs.len());
    let base = shaft.at(0.0);
    let mut quadrants = [0; 4];
    for barb in &barbs {
        let end = barb.points[barb.points.len() - 1] - base.point;
        let angle = f64::atan2(end.dot(base.normal), end.dot(base.right)).rem_euclid(std::f64::consts::TAU);
        quadrants[((angle / std::f64::consts::FRAC_PI_2) as usize).min(3)] += 1;
        assert!((5.0..25.0).contains(&barb.length_mm), "{}", barb.length_mm);
    }
    assert!(quadrants.iter().all(|count| *count > 2), "{quadrants:?}");
}

#[test]
fn frames_across_a_barbule_face_upwards() {
    for (name, feather) in species().filter(|(_, feather)| !feather.eye.is_there()) {
        let grown = feather.grow(window(&feather), Level::Barbules, None, 1, 1).unwrap();
        let counts = grown.counts();
        assert!(counts.barbs > 4 && counts.barbules > 400, "{name}: {counts:?}");
        grown.shaft.check().unwrap();
        grown.rami.check().unwrap();
        grown.barbs.check().unwrap();
        assert_eq!(grown.barbs.curves.len(), counts.barbs);
        for geometry in grown.barbules {
            geometry.check().unwrap();
            let mut upward = 0;
            for ribbon in &geometry.ribbons {
                let nodes = geometry.nodes_of(ribbon);
                let along = nodes[4].point - nodes[3].point;
                upward += usize::from(nodes[3].across.cross(along).z > 0.0);
            }
            assert!(upward == geometry.ribbons.len(), "{name}: {upward} of {}", geometry.ribbons.len());
        }
    }
}

#[test]
fn a_whole_feather_reaches_from_the_base_to_the_tip() {
    for (name, mut feather) in all().filter(|(_, feather)| feather.shaft.length_mm < 40.0) {
        let along_mm = 0.6 * feather.shaft.length_mm;
        let grown =
            feather.grow(VaneDisc { along_mm, radius_mm: None }, Level::Barbules, None, 1, 1).unwrap();
        for part in [&grown.shaft, &grown.rami, &grown.barbs, &grown.barbules[0], &grown.barbules[1]] {
            part.check().unwrap();
        }
        let [low, high] = grown.shaft.bounds().unwrap();
        let length = f64::from(high.y - low.y);
        assert!(length > 0.9 * feather.shaft.length_mm && length < 1.02 * feather.shaft.length_mm, "{name}");
        assert!((f64::from(low.y) + along_mm).abs() < 0.05 * length, "{name}: {low}");
        feather.downy.share = 0.0;
        let grown =
            feather.grow(VaneDisc { along_mm, radius_mm: None }, Level::Barbules, None, 1, 1).unwrap();
        let [left, right] = grown.rami.bounds().unwrap();
        let full = feather.barbs.leading_half_width_mm + feather.barbs.trailing_half_width_mm;
        let wide = f64::from(right.x - left.x) / full;
        assert!((0.85..1.15).contains(&wide) || name == "down", "{name}: {wide}");
        // The estimate by which too many are refused counts full barbs: the true number is near.
        let per_mm = 1e3 / feather.distal.spacing_um + 1e3 / feather.proximal.spacing_um;
        let full = feather.vane_area() * 1e3 / feather.barbs.spacing_um * per_mm;
        let share = grown.counts().barbules as f64 / full;
        assert!((0.7..1.2).contains(&share) || name == "down", "{name}: {share}");
    }
    let mut feather = feather("peafowl");
    feather.barbs.spacing_um = 50.0;
    let message = feather.check_count(WHOLE).unwrap_err().to_string();
    assert!(message.contains("in place of window.whole"), "{message}");
}

/// Zones take from the feather what lies in them, and nothing else: every barbule and every piece of ramus is in one of them.
#[test]
fn every_barbule_is_in_one_zone() {
    let feather = feather("starling");
    let window = VaneDisc { along_mm: 18.0, radius_mm: Some(2.5) };
    let all = Region { along: [0.0, 1.0], across: [-1.0, 1.0], ring: None, edge_mm: 0.0 };
    let base = feather.flat_vane().base_mm;
    let border = (18.0 - base) / feather.flat_vane().length_mm;
    let disc = Ring::disc([1.5, 18.0 - base], 0.8);
    let regions = vec![Region { along: [0.0, border], ..all }, Region { ring: Some(disc), ..all }];
    let zones = feather.zones(ZonePlan::Regions(regions)).unwrap();
    for level in [Level::Barbules, Level::Barbs] {
        let [own, zoned] =
            [None, Some(&zones)].map(|zones| feather.grow(window, level, zones, 1, 1).unwrap());
        assert_eq!(own.counts(), zoned.counts());
        assert!(own.zones.is_empty() && zoned.zones.len() == 2);
        let row = |grown: &Grown, which: usize| {
            let of_zones = grown.zones.iter().map(|zone| zone.barbules[which].ribbon_count());
            let counts: Vec<usize> =
                std::iter::once(grown.barbules[which].ribbon_count()).chain(of_zones).collect();
            counts
        };
        for which in [0, 1] {
            let counts = row(&zoned, which);
            assert_eq!(counts.iter().sum::<usize>(), row(&own, which)[0]);
            // Half of the patch, and a tenth of it of which half is in the other zone, which wins.
            let share = |zone: usize| counts[zone] as f64 / counts.iter().sum::<usize>() as f64;
            assert!((0.38..0.47).contains(&share(1)) && (0.07..0.14).contains(&share(2)), "{counts:?}");
        }
        let triangles =
            |geometry: &Geometry| geometry.meshes.iter().map(|m| m.triangles.len()).sum::<usize>();
        let segments = |geometry: &Geometry| geometry.curve_nodes.len() - geometry.curves.len();
        let of_zones = |count: &dyn Fn(&ZoneParts) -> usize| zoned.zones.iter().map(count).sum::<usize>();
        assert_eq!(triangles(&own.rami), triangles(&zoned.rami) + of_zones(&|zone| triangles(&zone.rami)));
        let fibres = segments(&zoned.fibres[0]) + of_zones(&|zone| segments(&zone.fibres));
        assert_eq!(segments(&own.fibres[0]), fibres);
        zoned.zones.iter().for_each(|zone| zone.rami.check().unwrap());
    }
    // Those that grew one by one are the same, and lie where their zone is, within what their barbs differ from straight ones.
    let grown = feather.grow(window, Level::Barbules, Some(&zones), 1, 1).unwrap();
    let names = |grown: &Grown| {
        let mut names: Vec<u64> = grown.all_barbules().ribbons.iter().map(|ribbon| ribbon.id).collect();
        names.sort_unstable();
        names
    };
    assert_eq!(names(&grown), names(&feather.grow(window, Level::Barbules, None, 1, 1).unwrap()));
    for (zone, parts) in grown.zones.iter().enumerate() {
        for geometry in &parts.barbules {
            for ribbon in &geometry.ribbons {
                let root = geometry.nodes_of(ribbon)[0].point;
                let outside =
                    if zone == 0 { root.y } else { (root.truncate() - glam::Vec2::X * 1.5).length() - 0.8 };
                assert!(outside < 0.8, "{zone}: {root}");
            }
        }
    }
}

/// Barbules of either side reach the next barb (spec: l sin φ ≥ p − 2r) in every vane but down's and of bare barbs.
#[test]
fn vanes_are_closed() {
    let has_vane = |feather: &Feather| feather.downy.share < 1.0 && feather.distal.length_um > 10.0;
    for (name, feather) in all().filter(|(_, feather)| has_vane(feather)) {
        for shape in [&feather.distal, &feather.proximal] {
            let reach = shape.length_um * (0.5 * (shape.base_angle + shape.end_angle)).sin();
            let gap = feather.barbs.spacing_um - feather.barbs.width_um;
            assert!(reach >= gap, "{name}: {reach} < {gap}");
        }
    }
}

/// Hit fraction of the closed vane along its normal: flight feathers are shut, contour feathers let some light through.
#[test]
fn light_along_the_normal_meets_closed_vanes() {
    let coverage = |name: &str| Feather::of_type(name).unwrap().coverage(1, 1, &Unobserved).unwrap().unwrap();
    for name in ["primary", "secondary", "tail", "osprey", "turkey-vulture", "rock-dove-wing"] {
        assert!(coverage(name) >= 0.97, "{name}: {}", coverage(name));
    }
    for name in ["contour", "covert"] {
        assert!((0.7..0.95).contains(&coverage(name)), "{name}: {}", coverage(name));
    }
    assert_eq!(Feather::of_type("down").unwrap().coverage(1, 1, &Unobserved).unwrap(), None);
    // Without barbules only the rami are met: about their mean width over their spacing.
    let mut bare = Feather::of_type("contour").unwrap();
    bare.distal.length_um = 5.0;
    bare.proximal.length_um = 5.0;
    let rami = bare.coverage(1, 1, &Unobserved).unwrap().unwrap();
    let most = bare.barbs.width_um / bare.barbs.spacing_um;
    assert!((0.4 * most..2.0 * most).contains(&rami), "{rami} {most}");
}

/// Means of a rock dove's seventh primary and fifth secondary (Harvey et al. 2022) within 6 %, and the classic count of
/// 990,000 barbules in a primary within 10 %.
#[test]
fn flight_feathers_measure_what_a_rock_doves_do() {
    let measures = |name: &str| Feather::of_type(name).unwrap().measures(1, 1, &Unobserved).unwrap();
    for (name, leading, trailing, vane) in
        [("primary", 5.2, 13.9, 135.0), ("secondary", 8.6, 12.5, 84.5), ("rock-dove-wing", 4.4, 13.2, 146.0)]
    {
        let of = measures(name);
        for (grown, measured) in [
            (of.leading.mean_width_mm, leading),
            (of.trailing.mean_width_mm, trailing),
            (of.length_mm - of.calamus_mm, vane),
        ] {
            assert!((grown / measured - 1.0).abs() < 0.06, "{name}: {grown} {measured}");
        }
    }
    let primary = measures("primary");
    assert!((primary.barbules as f64 / 990_000.0 - 1.0).abs() < 0.1, "{}", primary.barbules);
    assert!((primary.trailing.spacing_um - 140.0).abs() < 3.0, "{}", primary.trailing.spacing_um);
}

#[test]
fn impossible_parameters_are_refused() {
    let mut feather = feather("starling");
    feather.distal.spacing_um = 0.0;
    let message = feather.check().unwrap_err().to_string();
    assert_eq!(message, "feather.distal.spacing_um is 0, outside 1 to 10000");
    feather.distal.spacing_um = f64::NAN;
    assert!(feather.check().is_err());
    feather = self::feather("starling");
    feather.shaft.calamus = 1.0;
    assert!(feather.check().is_err());
    let mut large = Feather::of_type("primary").unwrap();
    large.barbs.trailing_half_width_mm = 200.0;
    let wide = VaneDisc { along_mm: 90.0, radius_mm: Some(500.0) };
    let refused = |feather: &Feather, level, window, expected: &str| {
        let refusal = feather.grow(window, level, None, 1, 1).err();
        assert!(refusal.is_some_and(|error| error.to_string().contains(expected)), "{expected}");
    };
    refused(&large, Level::Barbules, wide, "give a smaller radius_mm");
    refused(&large, Level::Barbules, WHOLE, "in place of window.whole");
    large.barbs.spacing_um = 10.0;
    refused(&large, Level::Barbs, WHOLE, "stretches of barbules");
}

#[test]
fn tables_start_from_a_type_and_keys_for_both_vanes_mean_either() {
    let read = |text: &str| Feather::read(&crate::fields::parse_toml(text).unwrap(), "feather");
    let primary = Feather::of_type("primary").unwrap();
    assert_eq!(read("type = 'primary'").unwrap(), primary);
    assert_eq!(read("").unwrap(), Feather::of_type("contour").unwrap());
    let wide = read("type = 'primary'\n[barbs]\nvane_half_width_mm = 9").unwrap();
    assert_eq!((wide.barbs.leading_half_width_mm, wide.barbs.trailing_half_width_mm), (9.0, 9.0));
    assert_eq!(wide.barbs.leading_base_angle, primary.barbs.leading_base_angle);
    for (name, feather) in all() {
        assert_eq!(Feather::read(&feather.table(), "feather").unwrap(), feather, "{name}");
    }
    let message = |text: &str| read(text).unwrap_err().to_string();
    assert!(message("type = 'primery'").contains("feather.type is 'primery', did you mean 'primary'"));
    assert!(message("leading = 'up'").contains("feather.leading is 'up'; known are left, right"));
    assert!(message("[barbs]\nvane_half_width = 3").contains("did you mean 'vane_half_width_mm'"));
    assert_eq!(
        message("[barbs]\nvane_half_width_mm = 3\nleading_half_width_mm = 2"),
        "feather.barbs.vane_half_width_mm is of both vanes, and feather.barbs.leading_half_width_mm is given too; leave one out"
    );
    assert!(
        message("[barbs]\nvane_half_width_mm = 0").contains("feather.barbs.vane_half_width_mm is 0, outside")
    );
    // A scene over its preset.
    let scene = |text: &str| {
        *SceneDescription::parse(&format!("preset = 'magpie'\n{text}")).unwrap().feather().unwrap()
    };
    assert_eq!(scene("[feather]\ntype = 'primary'"), primary);
    let magpie = feather("magpie");
    let narrow = scene("[feather.barbs]\nvane_half_width_mm = 3");
    assert_eq!(narrow.barbs.leading_half_width_mm, 3.0);
    assert_eq!(
        (narrow.shaft, narrow.barbs.leading_base_angle),
        (magpie.shaft, magpie.barbs.leading_base_angle)
    );
    assert_eq!(scene("[feather.barbs]\nleading_half_width_mm = 3").barbs.trailing_half_width_mm, 15.0);
}
