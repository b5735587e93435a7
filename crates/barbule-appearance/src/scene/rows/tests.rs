use super::*;
use crate::scene::feather::BarbShape;

/// A feather that bends every way.
fn bent() -> Feather {
    let mut feather = Feather::of_type("tail").unwrap();
    (feather.shaft.bend, feather.shaft.torsion) = (0.3, 0.2);
    feather
}

fn station(position_mm: [f64; 3], direction: [f64; 3]) -> Station {
    let [position_mm, direction] = [position_mm, direction].map(DVec3::from);
    Station {
        position_mm,
        direction,
        normal: DVec3::new(0.1, 0.0, 1.0),
        scale: 1.0,
        widths: [1.0; 2],
        kind: 0,
    }
}

/// Half a tail, from the middle outwards.
fn fan() -> FeatherRow {
    let outer = Station { scale: 0.7, widths: [0.5, 1.2], ..station([7.0, 1.0, -1.0], [0.5, -1.0, 0.0]) };
    FeatherRow {
        count: 6,
        stations: vec![station([1.0, 0.0, 0.0], [0.0, -2.0, 0.0]), outer],
        over: Over::First,
        clearance_mm: 0.2,
        roll: 0.06,
        mirror: false,
        turn_jitter: 0.0,
        size_jitter: 0.0,
        variants: 3,
    }
}

fn points(feather: &Feather, place: &Place) -> Vec<DVec3> {
    let shaft = Shaft::new(&feather.shaft);
    let root = window(feather).along_mm;
    let step = (feather.shaft.length_mm - root) / 20.0;
    let on_shaft = |i: u32| shaft.at(root + f64::from(i) * step).point - shaft.at(root).point;
    (0..=20).map(|i| place.point(on_shaft(i))).collect()
}

#[test]
fn feathers_are_as_many_as_said_and_their_tips_lie_where_they_point() {
    for over in [Over::First, Over::Last] {
        let row = FeatherRow { over, ..fan() };
        let laid = row.lay(&[bent()], 1);
        assert_eq!((laid.stands.len(), laid.variants.len()), (6, 3));
        for (index, stand) in laid.stands.iter().enumerate() {
            let share = index as f64 / 5.0;
            let feather = &laid.variants[stand.variant].feather;
            let place = stand.place(feather, 0);
            let line = points(feather, &place);
            let (root, tip) = (line[0], line[20]);
            let said = row.at(share);
            assert!((tip - root).normalize().dot(said.direction) > 1.0 - 1e-12);
            let beneath = if over == Over::First { index } else { 5 - index } as f64;
            let sunk = match beneath == 0.0 {
                true => 0.0,
                false => {
                    let BarbShape {
                        leading_half_width_mm: leading, trailing_half_width_mm: trailing, ..
                    } = bent().barbs;
                    libm::sin(0.06)
                        * said.scale
                        * f64::max(leading * said.widths[0], trailing * said.widths[1])
                }
            };
            assert!((root - said.position_mm + said.normal * (0.2 * beneath + sunk)).length() < 1e-12);
            // Straight from one station to the other.
            let position = DVec3::new(1.0 + 6.0 * share, share, -share);
            let scale = 1.0 - 0.3 * share;
            assert!((said.position_mm - position).length() < 1e-12 && (place.scale - scale).abs() < 1e-12);
            assert!((place.turn.determinant() - 1.0).abs() < 1e-12);
        }
        // Each variant is as wide as its two feathers are in the mean.
        let widths: Vec<f64> =
            laid.variants.iter().map(|variant| variant.feather.barbs.leading_half_width_mm).collect();
        for (variant, width) in widths.iter().enumerate() {
            let share = (2.0 * variant as f64 + 0.5) / 5.0;
            assert!((width - bent().barbs.leading_half_width_mm * (1.0 - 0.5 * share)).abs() < 1e-12);
        }
    }
}

/// Rows pass through their stations without a kink.
#[test]
fn stations_are_met_and_passed_smoothly() {
    let middle = Station { scale: 2.0, kind: 1, ..station([0.0, 5.0, 2.0], [0.3, -1.0, 0.2]) };
    let row = FeatherRow { stations: vec![fan().stations[0], middle, fan().stations[1]], ..fan() };
    for (share, of) in [0.0, 0.5, 1.0].into_iter().zip(&row.stations) {
        let at = row.at(share);
        assert!((at.position_mm - of.position_mm).length() < 1e-12 && (at.scale - of.scale).abs() < 1e-12);
        assert!((at.direction - of.direction.normalize()).length() < 1e-12);
        assert!(at.normal.dot(at.direction).abs() < 1e-12);
    }
    let slope = |low: f64, high: f64| (row.at(high).position_mm - row.at(low).position_mm) / (high - low);
    assert!((slope(0.4999, 0.5) - slope(0.5, 0.5001)).length() < 0.05);
    let kinds: Vec<usize> = [0.0, 0.24, 0.26, 0.74, 0.76].map(|share| row.at(share).kind).to_vec();
    assert_eq!(kinds, [0, 0, 1, 1, 0]);
}

/// Where two neighbours overlap, all of the upper one's vane is over the lower one's, and their shafts do not meet.
#[test]
fn neighbours_do_not_cut_through_each_other() {
    let level =
        |x: f64, direction: [f64; 3]| Station { normal: DVec3::Z, ..station([x, 0.0, 0.0], direction) };
    let wing = FeatherRow {
        count: 9,
        stations: vec![level(0.0, [0.2, -1.0, 0.0]), level(40.0, [-0.1, -1.0, 0.0])],
        clearance_mm: 0.05,
        ..fan()
    };
    let mut flat = Feather::of_type("covert").unwrap();
    let shaft = &mut flat.shaft;
    [shaft.arch, shaft.arch_quadratic, shaft.bend, shaft.bend_quadratic, shaft.torsion] = [0.0; 5];
    for row in [fan(), wing] {
        for over in [Over::First, Over::Last] {
            let laid = FeatherRow { over, ..row.clone() }.lay(&[flat], 3);
            let place = |i: usize| laid.stands[i].place(&laid.variants[laid.stands[i].variant].feather, 0);
            for i in 1..row.count {
                let (upper, lower) = if over == Over::First { (i - 1, i) } else { (i, i - 1) };
                let (upper, lower) = (place(upper), place(lower));
                let mut shared = 0;
                for (across, along) in (-10..=10).flat_map(|x| (1..=40).map(move |y| (x, y))) {
                    let point = DVec3::new(f64::from(across), f64::from(along), 0.0);
                    let beneath = lower.point_back(upper.point(point));
                    if beneath.x.abs() <= 10.0 && (0.0..=45.0).contains(&beneath.y) {
                        shared += 1;
                        assert!(beneath.z > 0.0, "{over:?} {i}: {point} is at {beneath}");
                    }
                }
                assert!(shared > 20, "{over:?} {i}: {shared}");
                let [one, other] = [points(&flat, &upper), points(&flat, &lower)];
                let apart = one.iter().flat_map(|p| other.iter().map(move |q| (*p - *q).length()));
                assert!(apart.fold(f64::INFINITY, f64::min) > 0.04);
            }
        }
    }
}

/// The other half is a mirror image, half a clearance lower.
#[test]
fn the_other_half_is_a_mirror_image() {
    let row = FeatherRow { mirror: true, ..fan() };
    let laid = row.lay(&[bent()], 5);
    assert_eq!((laid.stands.len(), laid.variants.len()), (12, 6));
    let (own, images) = laid.stands.split_at(6);
    for (stand, image) in own.iter().zip(images) {
        assert!(!stand.is_mirrored && image.is_mirrored && stand.index == image.index);
        let [one, other] = [stand, image].map(|stand| {
            let feather = &laid.variants[stand.variant].feather;
            (points(feather, &stand.place(feather, 0)), stand.place(feather, 0), feather.leading)
        });
        assert_ne!(one.2, other.2);
        let lower = row.at(stand.index as f64 / 5.0).normal * 0.1;
        let mirrored = |p: DVec3| DVec3::new(-p.x, p.y, p.z);
        for (p, q) in one.0.iter().zip(&other.0) {
            assert!((mirrored(*p - lower) - *q).length() < 1e-9, "{p} {q}");
        }
        // So are the vanes, not the shafts alone.
        let (edge, of_image) = (one.1.direction(DVec3::X), other.1.direction(DVec3::NEG_X));
        assert!((mirrored(edge) - of_image).length() < 1e-9);
        assert!((other.1.turn.determinant() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_seed_decides_the_row() {
    let row = FeatherRow { turn_jitter: 0.02, size_jitter: 0.05, ..fan() };
    assert_eq!(row.lay(&[bent()], 7), row.lay(&[bent()], 7));
    assert_ne!(row.lay(&[bent()], 7).stands, row.lay(&[bent()], 8).stands);
    let lone = FeatherRow { count: 1, ..fan() }.lay(&[bent()], 7);
    assert_eq!(lone.stands[0].station.position_mm, DVec3::X);
}
