use super::*;

fn coat(count: usize) -> Coat {
    Coat {
        number: Number::Count(count),
        region: None,
        guides: vec![Guide { position_mm: [0.0; 3], direction: [0.0, -1.0, 0.0] }],
        erection_deg: 8.0,
        erection_jitter_deg: 0.5,
        turn_jitter_deg: 3.0,
        size_jitter: 0.05,
        variants: 4,
        clearance_mm: 0.1,
        hug: 1.0,
    }
}

fn contour() -> Feather {
    Feather::of_type("contour").unwrap()
}

fn laid(coat: &Coat) -> Laid {
    let feather = contour();
    coat.lay(Body::ellipsoid([60.0, 90.0, 60.0], &Place::HERE, edge_mm(&feather)), &feather, 7).unwrap()
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
    let feather = contour();
    let other = coat(150).lay(first.body.clone(), &feather, 8).unwrap();
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
        let body = Body::ellipsoid([50.0; 3], &Place::HERE, edge_mm(&feather));
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
        let laid = quiet.lay(body, &stiff, 1).unwrap();
        let tip = laid.shapes[0].tests[4];
        laid.before[0].place(0).point(tip).length() - 50.0
    };
    // 0.98 of 35 mm from the middle of a quill of 4.2 mm: 32.2 mm along the tangent of a sphere of 50 mm.
    let stands_off = (50.0_f64.powi(2) + 32.2_f64.powi(2)).sqrt() - 50.0;
    let [straight, bent] = [0.0, 1.0].map(heights);
    assert!((straight - stands_off).abs() < 0.2, "{straight} {stands_off}");
    assert!(bent.abs() < 0.25, "{bent}");
}
