use super::*;
use crate::bsdf::{NumberMap, Texture};

fn coat(count: usize) -> Coat {
    Coat {
        number: Number::Count(count),
        region: None,
        bare: Vec::new(),
        guides: vec![Guide::PLAIN],
        erection_deg: 8.0,
        erection_jitter_deg: 0.5,
        turn_jitter_deg: 3.0,
        size_jitter: 0.05,
        variants: 4,
        clearance_mm: 0.1,
        most_lift: MOST_LIFT,
        hug: 1.0,
    }
}

/// Kinds of the nearest guides.
const SHARP: Kinds<'_> = Kinds::Guides { mix_mm: 0.0 };

fn contour() -> Feather {
    Feather::of_type("contour").unwrap()
}

fn laid(coat: &Coat) -> Laid {
    let feathers = [contour()];
    let body = Body::ellipsoid([60.0, 90.0, 60.0], &Place::HERE, edge_mm(&feathers));
    coat.lay(body, &feathers, SHARP, 7).unwrap()
}

/// Feathers that stand as they fall cut through each other; lifted they lie on each other.
#[test]
fn lifted_feathers_lie_over_those_beneath() {
    let region = Some(Region { low: [-100.0, -65.0, -100.0], high: [100.0, 65.0, 100.0] });
    let laid = laid(&Coat { region, ..coat(300) });
    let [before, after] = laid.buried();
    println!("buried: {before:.4} before, {after:.4} after");
    println!("layers: {:.2}, L sqrt(density): {:.2}", laid.layers(), laid.overlap());
    let lifts: Vec<f64> =
        laid.stands.iter().zip(&laid.before).map(|(a, b)| (a.erection - b.erection).to_degrees()).collect();
    let mean = lifts.iter().sum::<f64>() / lifts.len() as f64;
    println!("lifted by {mean:.2} degrees, {:.2} at most", lifts.iter().fold(0.0, |a: f64, b| a.max(*b)));
    assert!(before > 0.02 && after < 0.003, "{before} {after}");
    assert!(lifts.iter().all(|lift| *lift >= 0.0));
}

/// A coat of a number and one of the same density are the same, on whatever thread they are laid; another seed lays another.
#[test]
fn the_same_seed_lays_the_same_coat() {
    let first = laid(&coat(150));
    let density = 100.0 * 150.0 / first.area_mm2;
    let second = std::thread::spawn(move || laid(&Coat { number: Number::PerCm2(density), ..coat(1) }));
    let second = second.join().unwrap();
    assert_eq!((&first.stands, &first.variants), (&second.stands, &second.variants));
    let other = coat(150).lay(first.body.clone(), &[contour()], SHARP, 8).unwrap();
    assert_ne!(other.stands, first.stands);
}

/// Feathers point where the field does, within their jitter, and rise by their angle; of two that overlap the one nearer the head
/// is laid later.
#[test]
fn feathers_lie_along_the_field_from_tail_to_head() {
    let laid = laid(&coat(400));
    let mut turns = Vec::new();
    for stand in &laid.stands {
        let normal = stand.spot.normal;
        if normal.y.abs() < 0.9 {
            let field = (DVec3::NEG_Y + normal * normal.y).normalize();
            let turn = field.cross(stand.along).dot(normal).asin().to_degrees();
            turns.push(turn * turn);
        }
        let place = stand.place(0);
        assert!((place.turn.determinant() - 1.0).abs() < 1e-12);
        assert!((place.direction(DVec3::Y).dot(normal) - stand.erection.sin()).abs() < 1e-9);
        assert!(
            place.direction(DVec3::Y).dot(stand.along) > 0.0 && place.direction(DVec3::Z).dot(normal) > 0.0
        );
    }
    // The root of their mean square is the jitter of 3 degrees.
    let spread = (turns.iter().sum::<f64>() / turns.len() as f64).sqrt();
    assert!((spread - 3.0).abs() < 0.35, "{spread}");
    let mut rank = vec![0; laid.stands.len()];
    laid.order.iter().enumerate().for_each(|(place, &index)| rank[index as usize] = place);
    let (mut pairs, mut wrong) = (0, 0);
    for (i, a) in laid.stands.iter().enumerate() {
        for (j, b) in laid.stands.iter().enumerate() {
            let apart = b.spot.point - a.spot.point;
            if apart.length() < 35.0 && apart.dot(a.along + b.along) > 0.0 {
                (pairs, wrong) = (pairs + 1, wrong + usize::from(rank[i] < rank[j]));
            }
        }
    }
    // Meridians run in no circles, but neighbours turned by their jitter may.
    assert!(pairs > 1000 && 500 * wrong < pairs, "{wrong} of {pairs}");
}

/// A feather that hugs a sphere stays at one height beyond where it rises: without, its tip stands off by L²/2R.
#[test]
fn feathers_are_bent_as_the_body() {
    let heights = |hug: f64| {
        let feather = contour();
        let body = Body::ellipsoid([50.0; 3], &Place::HERE, edge_mm(&[feather]));
        let quiet = Coat {
            hug,
            erection_deg: 0.0,
            erection_jitter_deg: 0.0,
            size_jitter: 0.0,
            variants: 1,
            ..coat(3)
        };
        let mut stiff = feather;
        stiff.shaft.arch_quadratic = 0.0;
        let laid = quiet.lay(body, &[stiff], SHARP, 1).unwrap();
        let tip = laid.shapes[0].tests[4];
        laid.before[0].place(0).point(tip).length() - 50.0
    };
    // 0.98 of 35 mm from the middle of a quill of 4.2 mm: 32.2 mm along the tangent of a sphere of 50 mm.
    let stands_off = (50.0_f64.powi(2) + 32.2_f64.powi(2)).sqrt() - 50.0;
    let [straight, bent] = [0.0, 1.0].map(heights);
    assert!((straight - stands_off).abs() < 0.2, "{straight} {stands_off}");
    assert!(bent.abs() < 0.25, "{bent}");
}

/// A contour feather and a covert half as long.
fn two() -> [Feather; 2] {
    let mut short = Feather::of_type("covert").unwrap();
    short.shaft.length_mm = 0.5 * contour().shaft.length_mm;
    [contour(), short]
}

fn guided() -> Coat {
    let guide = |y: f64, kind| Guide { position_mm: [0.0, y, 0.0], kind, ..Guide::PLAIN };
    Coat { guides: vec![guide(90.0, 1), guide(-90.0, 0)], ..coat(500) }
}

fn egg() -> Body {
    Body::ellipsoid([60.0, 90.0, 60.0], &Place::HERE, edge_mm(&two()))
}

/// Each follicle bears what the nearer guide says; over a band both, with a share that falls from one side to the other.
#[test]
fn guides_choose_the_kinds_of_feathers() {
    let sharp = guided().lay(egg(), &two(), SHARP, 7).unwrap();
    assert!(sharp.stands.iter().all(|stand| stand.kind == usize::from(stand.spot.point.y > 0.0)));
    assert_eq!(sharp.variants.len(), 8);
    let own = |stand: &Stand| sharp.variants[stand.variant].kind == stand.kind;
    assert!(sharp.stands.iter().all(own));
    for (kind, feather) in two().iter().enumerate() {
        let lengths = sharp.variants.iter().filter(|v| v.kind == kind).map(|v| v.feather.shaft.length_mm);
        assert_eq!(lengths.collect::<Vec<_>>(), [feather.shaft.length_mm; 4]);
    }
    let mixed = guided().lay(egg(), &two(), Kinds::Guides { mix_mm: 80.0 }, 7).unwrap();
    let (mut both, mut expected, mut variance) = (0.0, 0.0, 0.0);
    for stand in &mixed.stands {
        let point = stand.spot.point;
        let [near, far] = [-90.0, 90.0].map(|y| (point - DVec3::Y * y).length());
        // The farther kind's weight is less by the difference of the distances, of 80 mm.
        let less = |distance: f64| (near.min(far) + 80.0 - distance).max(0.0);
        let share = less(far) / (less(near) + less(far));
        (expected, variance) = (expected + share, variance + share * (1.0 - share));
        both += f64::from(u8::from(stand.kind == 1));
        assert!((0.0 < share && share < 1.0) || stand.kind == usize::from(point.y > 0.0));
    }
    assert!(
        variance > 20.0 && (both - expected).abs() < 3.0 * variance.sqrt(),
        "{both} {expected} {variance}"
    );
    // Follicles, directions and sizes are those of a coat of one kind.
    let one =
        Coat { guides: guided().guides.into_iter().map(|g| Guide { kind: 0, ..g }).collect(), ..guided() };
    let one = one.lay(egg(), &two()[..1], SHARP, 7).unwrap();
    assert!(one.before.iter().zip(&sharp.before).all(|(a, b)| (a.spot, a.along) == (b.spot, b.along)));
}

/// A map of two halves: feathers right and left of the body. The same seed lays the same on any thread.
#[test]
fn a_map_chooses_the_kinds_of_feathers() {
    let texels = vec![[1.0 / 255.0; 3], [0.0; 3]];
    let map = NumberMap::new(Texture::new([2, 1], texels).unwrap(), 2, "feathers").unwrap();
    let lay = |seed| coat(200).lay(egg(), &two(), Kinds::Map(&map), seed).unwrap();
    let first = lay(7);
    // u < 0.5 is where x > 0.
    assert!(first.stands.iter().all(|stand| stand.kind == usize::from(stand.spot.point.x > 0.0)));
    let second = std::thread::scope(|scope| scope.spawn(|| lay(7)).join().unwrap());
    assert_eq!((&first.stands, &first.variants), (&second.stands, &second.variants));
    assert_ne!(first.stands, lay(8).stands);
}

/// Two kinds lie over each other as one does.
#[test]
fn feathers_of_two_kinds_are_lifted_over_each_other() {
    let region = Some(Region { low: [-100.0, -65.0, -100.0], high: [100.0, 65.0, 100.0] });
    let coat = Coat { region, ..guided() };
    let [before, after] = coat.lay(egg(), &two(), Kinds::Guides { mix_mm: 60.0 }, 7).unwrap().buried();
    println!("buried: {before:.4} before, {after:.4} after");
    assert!(before > 0.01 && after < 0.003, "{before} {after}");
}

#[test]
fn kinds_that_are_not_there_are_refused() {
    let message =
        |feathers: &[Feather], kinds| guided().lay(egg(), feathers, kinds, 7).unwrap_err().to_string();
    assert!(message(&two()[..1], SHARP).contains("coat.guides[0].kind is 1, but the coat has 1 kinds"));
    assert!(message(&[], SHARP).contains("no feather"));
    let picture = Texture::new([1, 1], vec![[1.0 / 255.0; 3]]).unwrap();
    let map = NumberMap::new(picture, 2, "feathers").unwrap();
    assert!(message(&two()[..1], Kinds::Map(&map)).contains("value 1 (of 255), but the coat has 1 kinds"));
    let bare = Body::mesh(&egg().skin(1), &Place::HERE, 4.0).unwrap();
    let refused = coat(5).lay(bare, &two(), Kinds::Map(&map), 7).unwrap_err().to_string();
    assert!(refused.contains("needs texture coordinates"), "{refused}");
}

/// Feathers of a third of the size about the head lie over each other as those of one size do, shorter still before a bare place, which
/// none reaches into along its shaft.
#[test]
fn sizes_vary_from_tract_to_tract() {
    let guide = |y: f64, size| Guide { position_mm: [0.0, y, 0.0], size, ..Guide::PLAIN };
    let region = Some(Region { low: [-100.0, -50.0, -100.0], high: [100.0, 50.0, 100.0] });
    let bare = vec![Bare { position_mm: [46.0, 0.0, 0.0], radius_mm: 10.0 }];
    let coat = Coat { region, bare, guides: vec![guide(70.0, 0.33), guide(-70.0, 1.0)], ..coat(540) };
    let feathers = [contour()];
    let body = Body::ellipsoid([46.0, 70.0, 46.0], &Place::HERE, coat.edge_mm(&feathers));
    let laid = coat.lay(body, &feathers, SHARP, 7).unwrap();
    let mean = |of: &dyn Fn(&&Stand) -> bool| {
        let some: Vec<f64> = laid.stands.iter().filter(of).map(|stand| stand.scale).collect();
        some.iter().sum::<f64>() / some.len() as f64
    };
    let [head, tail] = [mean(&|s| s.spot.point.y > 38.0), mean(&|s| s.spot.point.y < -38.0)];
    assert!(head < 0.6 && tail > 0.7, "{head} {tail}");
    let length = contour().shaft.length_mm - window(&contour()).along_mm;
    let middle = DVec3::X * 46.0;
    let mut shortened = 0;
    for stand in &laid.before {
        assert!((stand.spot.point - middle).length() >= 10.0);
        if stand.scale > SHORTEST * stand.size {
            let reaches = |t: f64| (stand.spot.point + stand.along * t - middle).length() < 9.99;
            assert!(!(0..=40).any(|i| reaches(stand.scale * length * f64::from(i) / 40.0)));
        }
        shortened += usize::from(stand.scale < 0.8 * stand.size);
    }
    assert!(shortened > 4, "{shortened}");
    let [before, after] = laid.buried();
    println!("buried: {before:.4} before, {after:.4} after; {} feathers", laid.stands.len());
    assert!(before > 0.02 && after < 0.006, "{before} {after}");
}

/// A sphere whose faces look inwards bears its feathers outside.
#[test]
fn feathers_grow_out_of_a_body_that_is_inside_out() {
    let mut skin = egg().skin(1);
    let lay =
        |skin| coat(20).lay(Body::mesh(&skin, &Place::HERE, 4.0).unwrap(), &[contour()], SHARP, 7).unwrap();
    assert!(!lay(skin.clone()).was_inside_out);
    skin.triangles.iter_mut().for_each(|corners| corners.swap(0, 1));
    let laid = lay(skin);
    assert!(laid.was_inside_out);
    for stand in &laid.stands {
        assert!(stand.spot.normal.dot(stand.spot.point) > 0.0);
        assert!(stand.place(0).direction(DVec3::Z).dot(stand.spot.point) > 0.0);
    }
}
