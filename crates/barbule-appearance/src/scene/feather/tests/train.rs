//! What feathers of a train must be, with their eye.

use super::*;

/// ∫ ds sin(angle)/p from the quill to the tuft, with the laws of the eye written out again, and by another rule.
#[test]
fn a_train_has_as_many_barbs_as_its_spacings_say() {
    for (spacing_um, loose_spacing_um) in [(300.0, 3000.0), (250.0, 5000.0), (400.0, 400.0)] {
        let mut feather = Feather::of_type("train").unwrap();
        feather.barbs.spacing_um = spacing_um;
        feather.eye.loose_spacing_um = loose_spacing_um;
        let (shape, eye, length) = (&feather.barbs, &feather.eye, feather.shaft.length_mm);
        let smooth = |x: f64| x.clamp(0.0, 1.0).powi(2) * (3.0 - 2.0 * x.clamp(0.0, 1.0));
        let first = feather.shaft.calamus * length;
        let last = length - shape.tuft * (length - first);
        let steps = 40_000;
        let step = (last - first) / f64::from(steps);
        let expected: f64 = (0..steps)
            .map(|i| {
                let s = first + (f64::from(i) + 0.5) * step;
                let before = length - eye.length_mm - s;
                let fan = smooth(1.0 - (length - s) / eye.length_mm);
                let angle =
                    shape.leading_base_angle + (shape.leading_tip_angle - shape.leading_base_angle) * fan;
                let loose = smooth(before / eye.border_mm);
                let p = spacing_um.powf(1.0 - loose) * loose_spacing_um.powf(loose);
                step * angle.sin() * 1e3 / p
            })
            .sum();
        for barbs in rows(&feather, 1) {
            let count = barbs.iter().filter(|barb| !barb.is_tuft).count() as f64;
            assert!((count - expected).abs() <= 1.0, "{spacing_um} {loose_spacing_um}: {count} {expected}");
        }
    }
}

/// Barbs of the eye are hooked up to its border and reach the fringe's length beyond; those below hang loose.
#[test]
fn barbs_of_a_train_are_hooked_within_its_eye_alone() {
    let mut feather = orderly(Feather::of_type("train").unwrap());
    let free = feather.eye;
    // In the plane, straight, to be measured.
    (feather.eye.spread, feather.eye.wave, feather.eye.hang, feather.barbs.curl) = (0.0, 0.0, 0.0, 0.0);
    let (eye, length) = (feather.eye, feather.shaft.length_mm);
    let [left, right] = rows(&feather, 1);
    let (mut crossing, mut loose) = (0, 0);
    for barb in left.iter().chain(&right) {
        let (base, end) = (barb.path[0], barb.path[barb.path.len() - 1]);
        let along = (end - base) / barb.length;
        let radius = |arc: f64| {
            let place = base + along * arc;
            let [x, y] =
                [place.x / eye.half_width_mm, (place.y - length + eye.middle_mm) / eye.half_length_mm];
            (x * x + y * y).sqrt()
        };
        let before = length - eye.length_mm - barb.along;
        if before > eye.border_mm {
            loose += 1;
            assert_eq!((barb.hooked_mm, barb.is_free), (0.0, [true; 2]));
            assert!((barb.length - eye.loose_length_mm).abs() < 1e-9, "{}", barb.length);
        } else if before < 0.0 && radius(barb.hooked_mm) < 1.0 + 1e-6 {
            crossing += 1;
            assert!((radius(barb.hooked_mm) - 1.0).abs() < 1e-6 || barb.hooked_mm == 0.0);
            assert!(radius(barb.hooked_mm + 1.0) > 1.0);
            assert!((barb.length - barb.hooked_mm - eye.fringe_mm).abs() < 1e-6, "{}", barb.length);
        }
    }
    assert!(crossing > 120 && loose > 300, "{crossing} {loose}");
    // In space what is hooked lies in the vane, and the rest leaves it.
    feather.eye.spread = free.spread;
    feather.eye.wave = free.wave;
    let (shaft, barbs) = feather.barbs_within(WHOLE, (1, 1), &Unobserved).unwrap();
    let away = |barb: &Barb, share: f64| {
        let (point, ..) = barb.at(share * barb.length_mm);
        let station = shaft.at((point - shaft.at(0.0).point).y.clamp(0.0, length));
        (point - station.point).dot(station.normal).abs()
    };
    let mean = |share: f64, is_eye: bool| {
        let of: Vec<f64> = barbs
            .iter()
            .filter(|barb| !barb.is_loose && (length - barb.along_mm < 0.7 * eye.length_mm) == is_eye)
            .map(|barb| away(barb, share))
            .collect();
        of.iter().sum::<f64>() / of.len() as f64
    };
    assert!(mean(0.5, true) < 0.3, "{}", mean(0.5, true));
    assert!(mean(0.9, true) > 0.5 && mean(0.9, false) > 4.0, "{} {}", mean(0.9, true), mean(0.9, false));
}

/// What is foretold of a window's barbs is near to what grows.
#[test]
fn a_trains_census_holds_what_grows() {
    let feather = Feather::of_type("train").unwrap();
    let length = feather.shaft.length_mm;
    for window in [WHOLE, VaneDisc { along_mm: length - 20.0, radius_mm: Some(60.0) }] {
        let (_, barbs) = feather.barbs_within(window, (1, 1), &Unobserved).unwrap();
        let grown: f64 = barbs.iter().filter(|barb| !barb.is_loose).map(|barb| barb.length_mm).sum();
        let foretold = feather.census(window).barbs_mm[0];
        assert!((0.95..1.8).contains(&(foretold / grown)), "{window:?}: {foretold} {grown}");
    }
}
