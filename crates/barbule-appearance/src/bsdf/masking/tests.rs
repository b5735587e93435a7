//! The rows against the published reference values, closed forms and rays.

use glam::{DVec2, DVec3};

use super::*;
use crate::math::rng::Stream;

fn toward(degrees: f64) -> DVec2 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    DVec2::new(sin, cos)
}

/// A ramus and the roof of its and its neighbour's barbules: height over width, length of barbules in half widths of the
/// ramus, lift in degrees. Period 1.
fn roof(height: f64, length: f64, lift: f64) -> Row {
    let (sin, cos) = f64::to_radians(lift).sin_cos();
    let g = 0.5 / (1.0 + length * cos);
    let ridge = DVec2::new(g * (2.0 + length * cos), g * length * sin);
    let ramus = Outline::Ellipse {
        centre: DVec2::new(g, 0.0),
        axes: [DVec2::new(g, 0.0), DVec2::new(0.0, g * height)],
    };
    let left = Outline::Segment { from: DVec2::new(1.0, 0.0), to: ridge };
    let right = Outline::Segment { from: DVec2::new(2.0 * g, 0.0), to: ridge };
    Row::new(vec![ramus, left, right], 1.0)
}

/// Barb, left, right, transmitted; degrees of the viewer towards +x. Values of a numerical reference of the published model,
/// four decimals.
#[test]
fn reference_values_of_the_barb_row() {
    let cases = [
        (1.5, 2.75, 45.0, 0.5, 0.0, [0.3396, 0.1651, 0.1651, 0.3302]),
        (1.5, 2.75, 45.0, 0.5, 25.0, [0.3957, 0.2234, 0.0881, 0.2928]),
        (1.5, 2.75, 45.0, 0.5, 50.0, [0.5591, 0.2728, 0.0158, 0.1522]),
        (1.5, 2.75, 45.0, 0.5, 70.0, [0.5122, 0.3435, 0.1443, 0.0000]),
        (1.0, 2.0, 0.0, 0.0, 0.0, [0.3333, 0.3333, 0.3333, 0.0]),
        (1.0, 2.0, 0.0, 0.0, 25.0, [0.3506, 0.3161, 0.3333, 0.0]),
        (1.0, 2.0, 0.0, 0.0, 50.0, [0.4260, 0.2407, 0.3333, 0.0]),
        (1.0, 2.0, 0.0, 0.0, 70.0, [0.6540, 0.0127, 0.3333, 0.0]),
        (3.0, 1.0, 0.0, 0.0, 25.0, [0.6799, 0.0701, 0.2500, 0.0]),
        (3.0, 1.0, 0.0, 0.0, 50.0, [1.0, 0.0, 0.0, 0.0]),
        (3.0, 1.0, 0.0, 0.0, 75.0, [1.0, 0.0, 0.0, 0.0]),
    ];
    for (height, length, lift, transparency, angle, expected) in cases {
        let row = roof(height, length, lift);
        let transparency = [0.0, transparency, transparency];
        for (sign, [left, right]) in [(1.0, [1, 2]), (-1.0, [2, 1])] {
            let seen = row.seen(toward(sign * angle), &transparency);
            let found = [seen.weights[0], seen.weights[left], seen.weights[right], seen.transmitted];
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 6e-5, "{sign} {angle}: {seen:?}, {expected}");
            }
        }
    }
}

/// A row of ellipses of half width 1 and this height over width, `gap` widths apart.
fn ellipses(height: f64, gap: f64) -> Row {
    let axes = [DVec2::X, DVec2::new(0.0, height)];
    Row::new(vec![Outline::Ellipse { centre: DVec2::ZERO, axes }], 2.0 * (1.0 + gap))
}

/// Closed form: 1 − 2 √(cos²ω + e² sin²ω)/(p cosω), and its values for a gap of one width and of ten.
#[test]
fn barbules_let_through_what_the_closed_form_says() {
    for (height, gap, expected) in [
        (1.0, 1.0, [0.500, 0.448, 0.347, 0.000]),
        (2.0, 1.0, [0.500, 0.316, 0.023, 0.000]),
        (1.0, 10.0, [0.909, 0.900, 0.881, 0.818]),
    ] {
        for (angle, expected) in [0.0, 25.0, 40.0, 60.0].into_iter().zip(expected) {
            for sign in [1.0, -1.0] {
                let toward = toward(sign * angle);
                let seen = ellipses(height, gap).seen(toward, &[0.0]);
                let (c, s) = (toward.y, toward.x);
                let width = (c * c + height * height * s * s).sqrt();
                let closed = (1.0 - 2.0 * width / (2.0 * (1.0 + gap) * c)).max(0.0);
                assert!((seen.transmitted - closed).abs() < 1e-12, "{seen:?} {closed}");
                assert!((seen.transmitted - expected).abs() < 6e-4, "{seen:?} {expected}");
            }
        }
    }
}

/// Rows of every kind: height of the ramus, both ends of each sheet from the ramus's middle, tilt of the ramus. Sheets
/// cross each other, the next ramus, or nothing.
fn random_row(stream: &mut Stream) -> (Row, Vec<Outline>) {
    let (r, tilt) = (stream.uniform(0.05, 0.3), stream.uniform(-0.5, 0.5));
    let (sin, cos) = f64::sin_cos(tilt);
    let height = r * stream.uniform(0.3, 3.0);
    let ramus = Outline::Ellipse {
        centre: DVec2::new(0.3, 0.1),
        axes: [DVec2::new(cos, sin) * r, DVec2::new(-sin, cos) * height],
    };
    let mut sheet = |side: f64| {
        let from = DVec2::new(0.3 + side * 1.3 * r, 0.1);
        let to = from + DVec2::new(side * stream.uniform(0.1, 0.9), stream.uniform(-0.2, 0.6));
        Outline::Segment { from, to }
    };
    let parts = vec![ramus, sheet(-1.0), sheet(1.0)];
    (Row::new(parts.clone(), 1.0), parts)
}

/// What a ray meets from a point on, as parts in order; from a point of the part `own` what it meets beyond that.
fn met(parts: &[Outline], origin: DVec2, toward: DVec2, own: Option<usize>) -> Vec<usize> {
    let mut met = Vec::new();
    let mut beyond = 1e-9_f64;
    for number in -60..=60 {
        for (part, outline) in parts.iter().enumerate() {
            let moved = DVec2::new(f64::from(number), 0.0);
            let distance = match *outline {
                Outline::Segment { from, to } => {
                    let (p, d) = (from + moved - origin, to - from);
                    // origin + t toward = from + u d.
                    let determinant = toward.perp_dot(d);
                    let (t, u) = (p.perp_dot(d) / determinant, p.perp_dot(toward) / determinant);
                    (0.0..=1.0).contains(&u).then_some(t)
                }
                Outline::Ellipse { centre, axes: [a, b] } => {
                    let (p, q) = (origin - centre - moved, toward);
                    let (a, b) = (a / a.length_squared(), b / b.length_squared());
                    let (p, q) = (DVec2::new(p.dot(a), p.dot(b)), DVec2::new(q.dot(a), q.dot(b)));
                    let (half, c) = (p.dot(q), p.length_squared() - 1.0);
                    let square = half * half - q.length_squared() * c;
                    // From within it the far wall counts.
                    (square > 0.0).then(|| (square.sqrt() - half) / q.length_squared())
                }
            };
            if number == 0 && own == Some(part) {
                beyond = beyond.max(distance.unwrap_or(0.0));
            } else if let Some(distance) = distance {
                met.push((distance, part));
            }
        }
    }
    met.retain(|(distance, _)| *distance > beyond);
    met.sort_by(|a, b| a.0.total_cmp(&b.0));
    met.into_iter().map(|(_, part)| part).collect()
}

/// Against 20,000 random rays a case that look for what they meet one by one, with transparencies: four deviations.
#[test]
fn rows_show_what_random_rays_meet() {
    let mut stream = Stream::new(71, &[]);
    let count = 20_000;
    let mut worst = 0.0_f64;
    for _ in 0..40 {
        let (row, parts) = random_row(&mut stream);
        let toward = toward(stream.uniform(-85.0, 85.0)) * if stream.unit() < 0.5 { 1.0 } else { -1.0 };
        let transparency = [stream.uniform(0.0, 0.5), stream.unit(), stream.unit()];
        let seen = row.seen(toward, &transparency);
        let sum: f64 = seen.weights.iter().sum::<f64>() + seen.transmitted;
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        let mut found = [0.0; 4];
        for _ in 0..count {
            // Backwards: towards the viewer from far behind; the last that is met is in front. An ellipse is met at its far
            // wall, which the ray leaves last.
            let origin = DVec2::new(stream.unit(), 0.0) - toward * 50.0;
            let mut passing = 1.0;
            for part in met(&parts, origin, toward, None).into_iter().rev() {
                found[part] += passing * (1.0 - transparency[part]) / f64::from(count);
                passing *= transparency[part];
            }
            found[3] += passing / f64::from(count);
        }
        for (found, exact) in found.iter().zip(seen.weights.iter().chain([&seen.transmitted])) {
            worst = worst.max((found - exact).abs());
            assert!((found - exact).abs() < 4.0 * (0.5 / f64::from(count).sqrt()), "{found} {exact}");
        }
    }
    println!("largest difference from {count} rays: {worst:.1e}");
}

/// What is seen is the width of each part over the period, less what hides it: two ways to the same number.
#[test]
fn weights_are_widths_less_what_hides_them() {
    let mut stream = Stream::new(72, &[]);
    for _ in 0..200 {
        let (row, parts) = random_row(&mut stream);
        let toward = toward(stream.uniform(-88.0, 88.0)) * if stream.unit() < 0.5 { 1.0 } else { -1.0 };
        let transparency = [0.0, stream.unit(), stream.unit()];
        let seen = row.seen(toward, &transparency);
        let visible = row.visible(toward, &transparency);
        for (part, outline) in parts.iter().enumerate() {
            let sight = super::outline::Sight::new(toward);
            let [low, high] = outline.extent(&sight);
            let weight = (high - low) / sight.across.x * (1.0 - transparency[part]) * visible[part];
            assert!((weight - seen.weights[part]).abs() < 1e-9, "{part}: {weight} {seen:?}");
        }
    }
}

/// Seen from one direction and lit from another, against rays from points of the part towards both; exchanging the two
/// changes nothing; and lit from where it is seen an opaque row is all lit.
#[test]
fn what_is_seen_and_lit_is_what_rays_meet_and_reciprocal() {
    let mut stream = Stream::new(73, &[]);
    let count = 10_000;
    let mut worst = 0.0_f64;
    for case in 0..40 {
        let (row, parts) = random_row(&mut stream);
        let mut direction = || {
            let toward = toward(stream.uniform(-80.0, 80.0));
            // Every other pair has its light from behind.
            (toward, [0.0, stream.unit(), stream.unit()])
        };
        let ((o, t_o), (i, t_i)) = (direction(), direction());
        let i = if case % 2 == 0 { i } else { -i };
        let shared = row.shared([o, i], [&t_o, &t_i]);
        for (a, b) in shared.iter().zip(row.shared([i, o], [&t_i, &t_o])) {
            assert!((a - b).abs() < 1e-12);
        }
        let visible = [row.visible(o, &t_o), row.visible(i, &t_i)];
        let opaque = [0.0; 3];
        for part in 0..3 {
            assert!(shared[part] <= visible[0][part].min(visible[1][part]) + 1e-12);
            assert!(
                (row.shared([o, o], [&opaque, &opaque])[part] - row.visible(o, &opaque)[part]).abs() < 1e-12
            );
            let mut sums = [0.0; 2];
            for (sum, toward) in sums.iter_mut().zip([o, i]) {
                for _ in 0..count {
                    let u = stream.uniform(-1.0, 1.0);
                    // A point of the front, evenly in the width that this direction sees.
                    let point = match parts[part] {
                        Outline::Segment { from, to } => from.lerp(to, 0.5 * (u + 1.0)),
                        Outline::Ellipse { centre, axes: [a, b] } => {
                            let stretched = DVec2::new(
                                toward.dot(a) / a.length_squared(),
                                toward.dot(b) / b.length_squared(),
                            )
                            .normalize();
                            let at = stretched * (1.0 - u * u).sqrt() + stretched.perp() * u;
                            centre + a * at.x + b * at.y
                        }
                    };
                    let passes = |toward: DVec2, t: &[f64; 3]| -> f64 {
                        met(&parts, point, toward, Some(part)).into_iter().map(|other| t[other]).product()
                    };
                    *sum += passes(o, &t_o) * passes(i, &t_i) / f64::from(count);
                }
            }
            let found = sums[0].min(sums[1]);
            worst = worst.max((found - shared[part]).abs());
            assert!(
                (found - shared[part]).abs() < 4.5 * (0.5 / f64::from(count).sqrt()),
                "case {case} part {part}: {found} {}",
                shared[part]
            );
        }
    }
    println!("largest difference from {count} rays: {worst:.1e}");
}

/// A flat roof hides and shades nothing of itself: every share is 1, from both sides.
#[test]
fn a_flat_roof_is_all_seen_and_lit() {
    let sheet = Outline::Segment { from: DVec2::ZERO, to: DVec2::X };
    let row = Row::new(vec![sheet], 1.0);
    for (a, b) in [(0.0, 60.0), (-80.0, 89.0), (30.0, 150.0), (-10.0, -170.0)] {
        let towards = [toward(a), toward(b)];
        assert!((row.seen(towards[0], &[0.0]).weights[0] - 1.0).abs() < 1e-12);
        assert!((row.shared(towards, [&[0.0], &[0.0]])[0] - 1.0).abs() < 1e-12);
    }
}

/// A flight feather's vane, in µm.
fn vane(lift: f64) -> Barbs {
    let one = |length: f64, angle: f64| Barbules {
        length,
        angle: angle.to_radians(),
        lift: f64::to_radians(lift),
        tilt: 0.2,
        half_width: 4.0,
        height_over_width: 0.6,
        spacing: 25.0,
    };
    Barbs {
        spacing: 250.0,
        half_width: 15.0,
        height_over_width: 2.5,
        barbules: [one(230.0, 35.0), one(240.0, 40.0)],
    }
}

fn direction(stream: &mut Stream) -> DVec3 {
    DVec3::new(stream.normal(), stream.normal(), stream.normal()).normalize()
}

/// Axes of barbules: orthonormal, right-handed, mirrored on the other side (without tilt).
#[test]
fn axes_of_barbules_are_right_handed_and_mirrored() {
    let barbules = Barbules { tilt: 0.3, ..vane(12.0).barbules[0] };
    for side in [-1.0, 1.0] {
        let [x, y, z] = barbules.axes(side);
        assert!(
            (x.cross(y) - z).length() < 1e-14 && x.dot(y).abs() < 1e-14 && (z.length() - 1.0).abs() < 1e-14
        );
        assert!((y.x / y.y - side * barbules.angle.tan()).abs() < 1e-12 && y.z > 0.0);
    }
    let straight = Barbules { tilt: 0.0, ..barbules };
    let ([_, left, left_up], [_, right, right_up]) = (straight.axes(-1.0), straight.axes(1.0));
    let mirrored = |v: DVec3| DVec3::new(-v.x, v.y, v.z);
    assert!((left - mirrored(right)).length() < 1e-14 && (left_up - mirrored(right_up)).length() < 1e-14);
    // A positive tilt turns the upper side towards the barb's tip, on both sides.
    for side in [-1.0, 1.0] {
        let ([_, _, flat_up], [_, _, up]) = (straight.axes(side), barbules.axes(side));
        assert!((up.dot(flat_up) - f64::cos(0.3)).abs() < 1e-12 && up.y > flat_up.y + 0.1);
    }
}

/// The transparency of a side of barbules against its row's sweep, and against rays among slanted rods in space.
#[test]
fn barbules_in_space_let_through_what_their_row_does() {
    let mut stream = Stream::new(74, &[]);
    let rows = VaneRows::new(&vane(15.0));
    for _ in 0..300 {
        let wo = direction(&mut stream);
        for side in &rows.sides {
            let seen = side.row.seen(side.flat(wo), &[0.0]);
            assert!((seen.transmitted - side.transparency(wo)).abs() < 1e-9);
        }
    }
    // Rods through the points n D ŷ with the barbule's axes; a ray meets one where in the rod's axes it meets the ellipse.
    let barbules = vane(15.0).barbules[1];
    let [x, _, z] = barbules.axes(1.0);
    let (r, h) = (barbules.half_width, barbules.half_width * barbules.height_over_width);
    for _ in 0..10 {
        let wo = direction(&mut stream);
        let count = 20_000;
        let mut passed = 0;
        for _ in 0..count {
            let start = DVec3::new(0.0, stream.uniform(0.0, barbules.spacing), 0.0);
            let blocked = (-200..200).any(|number| {
                let p = start - DVec3::Y * (barbules.spacing * f64::from(number));
                let (p, d) =
                    (DVec2::new(p.dot(x) / r, p.dot(z) / h), DVec2::new(wo.dot(x) / r, wo.dot(z) / h));
                p.perp_dot(d).abs() < d.length()
            });
            passed += i32::from(!blocked);
        }
        let found = f64::from(passed) / f64::from(count);
        assert!((found - rows.sides[1].transparency(wo)).abs() < 0.015, "{found}");
    }
}

/// Of the whole vane, seen weights sum to 1; weight × lit over the projected width of each part is symmetric.
#[test]
fn masking_of_a_vane_is_reciprocal() {
    let mut stream = Stream::new(75, &[]);
    for lift in [0.0, 15.0] {
        let barbs = vane(lift);
        let rows = VaneRows::new(&barbs);
        // Projected areas over that of the vane, from the shapes themselves.
        let area = |d: DVec3| {
            let mut areas = [0.0; PARTS];
            let across = (barbs.half_width * d.z).hypot(barbs.half_width * barbs.height_over_width * d.x);
            areas[RAMUS] = 2.0 * across / (barbs.spacing * d.z.abs());
            for (part, side) in [(LEFT, -1.0), (RIGHT, 1.0)] {
                let barbules = &barbs.barbules[part - 1];
                let [x, y, z] = barbules.axes(side);
                let (r, h) = (barbules.half_width, barbules.half_width * barbules.height_over_width);
                let width = (r * d.dot(z)).hypot(h * d.dot(x));
                let step = (DVec3::Y - y * y.y) * barbules.spacing;
                let normal = step.normalize().cross(y);
                let length = DVec2::new(y.x, y.z) * barbules.length;
                let sheet = length.perp_dot(DVec2::new(d.x, d.z)).abs() / (barbs.spacing * d.z.abs());
                areas[part] = 2.0 * width / (step.length() * d.dot(normal).abs()) * sheet;
            }
            areas
        };
        let mut nonzero = 0;
        for _ in 0..300 {
            let (o, i) = (direction(&mut stream), direction(&mut stream));
            let shares = |o: DVec3, i: DVec3| {
                let (seen, lit, area) = (rows.seen(o), rows.lit(o, i), area(o));
                assert!((seen.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                assert!(lit.iter().all(|lit| (0.0..=1.0 + 1e-12).contains(lit)));
                [0, 1, 2].map(|part| seen[part] * lit[part] / area[part])
            };
            for (there, back) in shares(o, i).into_iter().zip(shares(i, o)) {
                assert!((there - back).abs() < 1e-9, "{there} {back}");
                nonzero += usize::from(there > 0.1);
            }
        }
        assert!(nonzero > 200);
    }
}

/// How far lookups are from the exact rows, and whether their weights sum to 1. Away from the horizon, at which endlessly
/// many parts stand behind each other. Largest errors lie at kinks: where a side of barbules closes, where a sheet is seen from its
/// edge.
#[test]
fn lookups_are_near_the_exact_rows() {
    let mut stream = Stream::new(76, &[]);
    for lift in [0.0, 20.0, 45.0] {
        let rows = VaneRows::new(&vane(lift));
        let table = MaskingTable::new(&vane(lift));
        let mut direction = || {
            let mut one = direction(&mut stream);
            while one.z.abs() < 0.1 {
                one = direction(&mut stream);
            }
            one
        };
        let mut errors = [Vec::new(), Vec::new()];
        for _ in 0..2000 {
            let (o, i) = (direction(), direction());
            let (seen, exact) = (table.seen(o), rows.seen(o));
            assert!((seen.iter().sum::<f64>() - 1.0).abs() < 1e-5);
            errors[0].extend(seen.iter().zip(exact).map(|(found, exact)| (found - exact).abs()));
            let found = [RAMUS, LEFT, RIGHT].map(|part| table.part(part, o).lit(&table.part(part, i)));
            let lit = rows.lit(o, i);
            assert!(found.iter().all(|lit| (0.0..=1.0).contains(lit)));
            errors[1]
                .extend((0..PARTS).map(|part| (found[part] * seen[part] - lit[part] * exact[part]).abs()));
        }
        for (errors, what) in errors.iter_mut().zip(["seen", "seen and lit"]) {
            errors.sort_by(f64::total_cmp);
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            let (high, most) = (errors[errors.len() * 99 / 100], errors[errors.len() - 1]);
            println!("lift {lift}, {what}: {mean:.1e} in the mean, {high:.1e} for 99 %, {most:.1e} at most");
            assert!(mean < 2e-3 && high < 3e-2);
        }
    }
}

/// Opaque rows without gaps: all of the view is barbules, so of each is seen the period over its width. They overlap like
/// tiles, cut through each other, or stand as a Venetian blind.
#[test]
fn closed_rows_show_a_period_of_each_barbule() {
    let mut stream = Stream::new(77, &[]);
    for (height, tilt, period) in [(1.0, 0.0, 1.6), (0.1, 0.6, 1.2), (0.1, -0.9, 0.9), (2.0, 0.3, 1.9)] {
        let (sin, cos) = f64::sin_cos(tilt);
        let axes = [DVec2::new(cos, sin), DVec2::new(-sin, cos) * height];
        let row = Row::new(vec![Outline::Ellipse { centre: DVec2::ZERO, axes }], period);
        for _ in 0..50 {
            let toward = toward(stream.uniform(-85.0, 85.0));
            let across = DVec2::new(toward.y, -toward.x);
            let width = 2.0 * axes[0].dot(across).hypot(axes[1].dot(across));
            let expected = (period * toward.y / width).min(1.0);
            let visible = row.visible(toward, &[0.0])[0];
            assert!((visible - expected).abs() < 1e-9, "{visible} {expected}");
            assert!(
                (row.seen(toward, &[0.0]).transmitted - (1.0 - width / (period * toward.y)).max(0.0)).abs()
                    < 1e-9
            );
        }
    }
}
