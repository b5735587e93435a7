use std::f64::consts::FRAC_PI_2;

use super::*;
use crate::bsdf::{Absorption, FibreIndex, HairParameters, Reflectance, Surface};
use crate::math::rng::Stream;

fn hair(height_over_width: f64) -> Hair {
    Hair::new(HairParameters {
        longitudinal_roughness: 0.2,
        azimuthal_roughness: 0.3,
        scale_tilt: 0.0,
        index: FibreIndex::Constant(1.55),
        absorption: Absorption::pigments(0.0, 0.0).unwrap(),
        height_over_width,
    })
    .unwrap()
}

fn keratin() -> Keratin {
    Keratin::new(0.3, 1.56, Reflectance::melanin(3.0).unwrap()).unwrap()
}

/// Barbules across the barb, half a gap wide, flat in the vane.
fn row() -> Row {
    Row {
        length: 0.3,
        half_width: 0.005,
        spacing: 0.02,
        angle: [FRAC_PI_2; 2],
        lift: [0.0; 2],
        tilt: 0.0,
        root_tilt: 0.0,
        cell: 0.0,
        swelling: 0.0,
        disorder: RowDisorder::default(),
    }
}

fn barb(row: Row, substance: &Substance, tip: f64) -> BarbSurface {
    let ramus = Ramus { substance: Substance::Keratin(keratin()), half_width: 0.015, height: 1.5 };
    let rows = [(row, substance.clone()), (row, substance.clone())];
    let dress = Dress { markings: Markings::default(), zones: Vec::new(), pale: keratin() };
    BarbSurface::new(BarbModel::Substructure, ramus, rows, tip, dress).unwrap()
}

/// On a barb of 10 mm whose envelope is 0.4 mm wide on each side.
fn hit(arc: f64, across: f64) -> Hit {
    let ribbon = OnRibbon { half_width: 0.4, place: arc / 10.0, cell_length: 10.0, ..OnRibbon::default() };
    Hit { uv: [arc, across], ribbon, id: 7, ..Hit::default() }
}

/// Numbers of 0 … 1 that fall into step with nothing.
fn spread(i: u32) -> f64 {
    (f64::from(i) * 0.618_033_988_749_894_9).fract()
}

/// Share of the places at this distance from the ramus that a viewer sees through.
fn transparency(barb: &BarbSurface, side: f64, wo: DVec3) -> f64 {
    let count = 20_000_u32;
    let through = (0..count).filter(|i| {
        let arc = 4.0 + 0.8 * spread(*i);
        barb.opacity(&hit(arc, side / 0.4), wo) == 0.0
    });
    through.count() as f64 / f64::from(count)
}

/// Coverage of elliptical barbules seen along the barb: 2r √(cos² + e² sin²)/(p cos), which the specification of the model tabulates.
#[test]
fn oblique_rows_close_as_their_silhouettes_say() {
    for (height, expected) in [(1.0, [0.5, 0.448, 0.347, 0.0]), (2.0, [0.5, 0.316, 0.023, 0.0])] {
        let barb = barb(row(), &Substance::Fibre(hair(height)), 1.0);
        for (degrees, expected) in [0.0_f64, 25.0, 40.0, 60.0].into_iter().zip(expected) {
            let angle = degrees.to_radians();
            for along in [-1.0, 1.0] {
                let wo = DVec3::new(0.0, along * angle.sin(), angle.cos());
                let found = transparency(&barb, 0.1, wo);
                assert!((found - expected).abs() < 1.5e-3, "{height} {degrees}: {found} {expected}");
            }
        }
    }
}

/// Slats turned like a blind's are closed where one sees their faces, and let through what their edges leave.
#[test]
fn tilted_slats_are_a_blind() {
    let tilt = 0.6_f64;
    let barb = barb(Row { tilt, ..row() }, &Substance::Keratin(keratin()), 1.0);
    for degrees in [-50.0_f64, -20.0, 0.0, 20.0, 50.0] {
        let angle = degrees.to_radians();
        let wo = DVec3::new(0.0, angle.sin(), angle.cos());
        // Width of a slat at right angles to the view over the distance of slats there.
        let covered = (0.01 * (angle - tilt).cos().abs() / (0.02 * angle.cos())).min(1.0);
        let found = transparency(&barb, 0.1, wo);
        assert!((found - (1.0 - covered)).abs() < 1.5e-3, "{degrees}: {found} {covered}");
    }
}

/// Seen from above, the ramus and the two rows take their shares of the width, and beyond the barbules' reach is nothing.
#[test]
fn parts_take_their_shares() {
    let barb = barb(row(), &Substance::Keratin(keratin()), 1.0);
    let mut counts = [0.0; 3];
    let mut stream = Stream::new(91, &[]);
    let count = 400_000;
    for _ in 0..count {
        let hit = hit(stream.uniform(4.0, 4.8), stream.uniform(-1.0, 1.0));
        match barb.meet(&hit, DVec3::Z) {
            Some(Part::Ramus(_)) => counts[0] += 1.0 / f64::from(count),
            Some(Part::Barbule(which, _)) => counts[1 + which] += 1.0 / f64::from(count),
            None => {}
        }
    }
    let share = 0.44;
    let ramus = 0.015 * ramus_taper(share) / 0.4;
    assert!((counts[0] - ramus).abs() < 1e-3, "{counts:?} {ramus}");
    // ∫ 2 r(t)/D over the barbule, from the ramus' edge.
    let length = row().length_at(share);
    let steps = 10_000;
    let width = |t: f64| 2.0 * row().half_width_at(t) / 0.02;
    let hidden = 0.2 * 0.015 * ramus_taper(share) / length;
    let rows: f64 =
        (0..steps).map(|i| (f64::from(i) + 0.5) / f64::from(steps)).filter(|t| *t > hidden).map(width).sum();
    let expected = rows / f64::from(steps) * length / 0.8;
    for row in &counts[1..] {
        assert!((row - expected).abs() < 1.5e-3, "{counts:?} {expected}");
    }
}

/// Barbs of the two vanes mirror each other, disorder and all.
#[test]
fn vanes_mirror_each_other() {
    let disorder = RowDisorder { angle: 0.05, lift: 0.07, spacing: 0.1, length: 0.06, turn: 0.1 };
    let row = Row { angle: [0.7, 0.5], lift: [0.2, -0.1], tilt: -0.2, half_width: 0.012, disorder, ..row() };
    let wavelengths = Lambdas::splat(550.0);
    let mut stream = Stream::new(92, &[]);
    let mut lit = 0;
    for substance in [Substance::Keratin(keratin()), Substance::Fibre(hair(0.6))] {
        let [one, other] = [1.0, -1.0].map(|tip| Surface::Barb(Box::new(barb(row, &substance, tip))));
        for _ in 0..2000 {
            let hit = hit(stream.uniform(1.0, 9.0), stream.uniform(-0.7, 0.7));
            let mirrored = Hit { uv: [hit.uv[0], -hit.uv[1]], ..hit };
            let mut direction =
                || DVec3::new(stream.normal(), stream.normal(), 1.0 + stream.unit()).normalize();
            let (wo, wi) = (direction(), direction());
            let mirror = |v: DVec3| DVec3::new(-v.x, v.y, v.z);
            let opacity = one.opacity(&hit, -wo, wo);
            assert_eq!(opacity, other.opacity(&mirrored, -mirror(wo), mirror(wo)));
            if opacity == 0.0 {
                continue;
            }
            let value = |evaluation: crate::bsdf::Evaluation| evaluation.f[0] * evaluation.cosine;
            let a = value(one.bind(&hit, wo, wavelengths).eval(wi));
            let b = value(other.bind(&mirrored, mirror(wo), wavelengths).eval(mirror(wi)));
            assert!((a - b).abs() <= 1e-9 * (1.0 + a), "{a} {b}");
            lit += u32::from(a > 0.0);
        }
    }
    assert!(lit > 500, "{lit}");
}

/// What is drawn leaves with a weight of 1 where nothing absorbs and no neighbour is near.
#[test]
fn clear_barbules_that_stand_alone_lose_no_light() {
    let alone = Row { spacing: 0.2, half_width: 0.008, angle: [0.7, 0.5], lift: [0.2, 0.0], ..row() };
    let barb = Surface::Barb(Box::new(barb(alone, &Substance::Fibre(hair(0.5)), 1.0)));
    let mut stream = Stream::new(93, &[]);
    let mut drawn = 0;
    for _ in 0..20_000 {
        let hit = hit(stream.uniform(1.0, 9.0), stream.uniform(0.1, 0.5));
        let wo = DVec3::new(stream.normal(), stream.normal(), 2.0).normalize();
        if barb.opacity(&hit, -wo, wo) == 0.0 {
            continue;
        }
        let bsdf = barb.bind(&hit, wo, Lambdas::splat(550.0));
        let u = [stream.unit(), stream.unit(), stream.unit()];
        if let Some(sample) = bsdf.sample(u) {
            let evaluation = sample.evaluation;
            let weight = evaluation.f[0] * evaluation.cosine / evaluation.pdf[0];
            assert!((weight - 1.0).abs() < 1e-9, "{weight}");
            drawn += 1;
        }
    }
    assert!(drawn > 500, "{drawn}");
}

/// A blind of slats turned by τ, closed from above, under light that leans by β towards their lower edges: each upper edge
/// shades the slat behind it, which leaves 1/(1 + tanτ tanβ) lit. Light from the other side reaches all.
#[test]
fn slats_shade_each_other() {
    let tilt = 0.5_f64;
    let row = Row { spacing: 0.008, half_width: 0.005, tilt, ..row() };
    let barb = Surface::Barb(Box::new(barb(row, &Substance::Keratin(keratin()), 1.0)));
    for light in [-0.9_f64, -0.4, 0.0, 0.4, 0.8, 1.1] {
        let wi = DVec3::new(0.0, light.sin(), light.cos());
        let count = 8000_u32;
        let lit = (0..count).filter(|i| {
            let hit = hit(4.0 + 0.8 * spread(*i), 0.25);
            barb.bind(&hit, DVec3::Z, Lambdas::splat(550.0)).eval(wi).f[0] > 0.0
        });
        let share = lit.count() as f64 / f64::from(count);
        let expected = 1.0 / (1.0 + tilt.tan() * light.tan().max(0.0));
        assert!((share - expected).abs() < 2e-3, "{light}: {share} {expected}");
    }
}

/// 10 mm of vane, 5 mm wide on either side, with barbs in this direction.
fn vane(direction: [f64; 2]) -> FlatVane {
    let barbs = [[StraightBarb { start_mm: 0.0, direction }; STATIONS]; 2];
    FlatVane { base_mm: 0.0, length_mm: 10.0, stations_mm: [0.0, 10.0], half_widths_mm: [5.0; 2], barbs }
}

/// What is pale is so in every zone, and zones wear only what has the form of the feather's own.
#[test]
fn pale_places_win_over_zones_whose_dress_must_fit() {
    let left = Region { along: [0.0, 1.0], across: [-1.0, 0.0], ring: None, edge_mm: 0.0 };
    let zones = Some(Zones::new(vane([1.0, 0.0]), ZonePlan::Regions(vec![left])).unwrap());
    let pattern = Some(Pattern { spacing: 0.0, dark_share: 0.5, lean: 0.0, tip: 8.0, edge: 0.0, pale: 0.1 });
    let markings = Markings { pattern, zones };
    for (side, station, expected) in [
        (-1.0, 3.0, Mark::Zone(1)),
        (1.0, 3.0, Mark::Zone(0)),
        (-1.0, 9.0, Mark::Pale),
        (1.0, 9.0, Mark::Pale),
    ] {
        assert_eq!(markings.at(side, station, 2.0, 1), expected);
    }
    let refusal = |zones: Vec<ZoneDress>| {
        let ramus = Ramus { substance: Substance::Keratin(keratin()), half_width: 0.015, height: 1.5 };
        let rows = [(row(), Substance::Fibre(hair(1.0))), (row(), Substance::Fibre(hair(1.0)))];
        let dress = Dress { markings: markings.clone(), zones, pale: keratin() };
        BarbSurface::new(BarbModel::Substructure, ramus, rows, 1.0, dress)
            .err()
            .map(|error| error.to_string())
    };
    let proximal = |substance| ZoneDress { ramus: None, barbules: [None, Some(substance)] };
    assert_eq!(refusal(vec![proximal(Substance::Fibre(hair(1.0)))]), None);
    assert_eq!(refusal(Vec::new()).unwrap(), "the feather has 1 zones but 0 dresses; give each one");
    assert_eq!(
        refusal(vec![proximal(Substance::Keratin(keratin()))]).unwrap(),
        "the proximal barbules of zone 1 are keratin where the feather's own are fibres; give fibres"
    );
    assert_eq!(
        refusal(vec![proximal(Substance::Fibre(hair(0.5)))]).unwrap(),
        "the proximal barbules of zone 1 are not as high over their width as the feather's own; give the same height_over_width"
    );
}

/// On an envelope the barbules and the ramus of a zone are those of its dress.
#[test]
fn envelopes_show_the_dress_of_their_zone() {
    // From the middle of the barb on.
    let end = Region { along: [0.5, 1.0], across: [-1.0, 1.0], ring: None, edge_mm: 0.0 };
    let zones = Some(Zones::new(vane([0.0, 1.0]), ZonePlan::Regions(vec![end])).unwrap());
    let own = Substance::Keratin(keratin());
    let ramus = Ramus { substance: own.clone(), half_width: 0.015, height: 1.5 };
    let black = Substance::Keratin(Keratin::new(0.3, 1.56, Reflectance::new(|_| 0.0).unwrap()).unwrap());
    let dress = Dress {
        markings: Markings { pattern: None, zones },
        zones: vec![ZoneDress { ramus: Some(black.clone()), barbules: [Some(black), None] }],
        pale: keratin(),
    };
    let rows = [(row(), own.clone()), (row(), own.clone())];
    let zoned = BarbSurface::new(BarbModel::Substructure, ramus, rows, 1.0, dress).unwrap();
    let plain = barb(row(), &own, 1.0);
    let mut stream = Stream::new(95, &[]);
    let mut darker = [0; 3];
    for _ in 0..4000 {
        let hit = hit(stream.uniform(3.0, 7.0), stream.uniform(-1.0, 1.0));
        let part = match plain.meet(&hit, DVec3::Z) {
            Some(Part::Ramus(_)) => 0,
            Some(Part::Barbule(which, _)) => 1 + which,
            None => continue,
        };
        let wi = DVec3::new(0.3, 0.1, 1.0).normalize();
        let [a, b] =
            [&plain, &zoned].map(|barb| barb.bind(&hit, DVec3::Z, Lambdas::splat(550.0)).eval(wi).f[0]);
        let is_other = hit.uv[0] > 5.0 && part != 2 && a > 0.0;
        assert!(if is_other { b < a } else { b == a }, "{} {part}: {a} {b}", hit.uv[0]);
        darker[part] += usize::from(is_other);
    }
    assert!(darker[0] > 10 && darker[1] > 100, "{darker:?}");
}
