//! The reference against closed forms and laws.

use barbule_light::fresnel::fresnel;

use super::*;
use crate::math::bessel::Cylinder;
use crate::progress::Unobserved;
use crate::scattering::grating::{Coherence, Obliquity, TableGrid};
use crate::solve::crystal::Rcwa;
use crate::spectrum::colour::Observer;

/// A direction by its polar angle from the normal and its azimuth from +x, degrees.
fn direction(polar: f64, azimuth: f64) -> DVec3 {
    let (sin, cos) = polar.to_radians().sin_cos();
    let (s, c) = azimuth.to_radians().sin_cos();
    DVec3::new(sin * c, sin * s, cos)
}

fn flat(cells: [usize; 2]) -> Heightfield {
    Heightfield::new(cells, [65.0; 2], vec![0.3; cells[0] * cells[1]]).unwrap()
}

fn f(field: &Heightfield, setup: &Setup, nm: f64, w_i: DVec3, w_o: DVec3) -> f64 {
    value(field, &Turns::of(field), setup, nm, [w_i, w_o], &Unobserved).unwrap()
}

/// ∫ f (z·ω_o) dω_o over a square of direction cosines around a direction.
fn energy(
    field: &Heightfield,
    setup: &Setup,
    nm: f64,
    w_i: DVec3,
    around: [f64; 2],
    half: f64,
    steps: i32,
) -> f64 {
    let step = 2.0 * half / f64::from(steps);
    let at = |i: i32| (f64::from(i) + 0.5) * step - half;
    let mut sum = 0.0;
    for i in 0..steps {
        for j in 0..steps {
            let (x, y) = (around[0] + at(i), around[1] + at(j));
            let up = 1.0 - x * x - y * y;
            if up > 0.0 {
                sum += f(field, setup, nm, w_i, DVec3::new(x, y, up.sqrt())) * step * step;
            }
        }
    }
    sum
}

#[test]
fn a_flat_field_is_a_mirror() {
    let field = flat([8, 8]);
    for obliquity in
        [Obliquity::Kirchhoff, Obliquity::Reciprocal, Obliquity::HarveyShack, Obliquity::Radiance]
    {
        for place in [Place::At([3.0, 7.0]), Place::Anywhere] {
            for polar in [0.0, 30.0, 60.0] {
                let setup = Setup { obliquity, place, ..Setup::default() };
                let w_i = direction(polar, 20.0);
                let found = energy(&field, &setup, 550.0, w_i, [-w_i.x, -w_i.y], 0.03, 80);
                let mirror = fresnel(w_i.z, 1.5);
                assert!((found / mirror - 1.0).abs() < 1e-3, "{obliquity:?} {polar}: {found} {mirror}");
            }
        }
    }
}

/// Squared amplitudes of single orders, with the window far narrower than their distance.
fn order(field: &Heightfield, j: i64, period_um: f64, w: f64, nm: f64) -> f64 {
    let wavelength = nm * 1e-3;
    let u = j as f64 * wavelength / period_um;
    let (turns, q) = (Turns::of(field), DVec3::new(u, 0.0, w));
    squared_amplitude(field, &turns, Place::Anywhere, (wavelength, 1e-4), q, &Unobserved).unwrap()
}

#[test]
fn a_sinusoid_has_bessel_functions_and_a_ramp_has_sinc() {
    let (period, amplitude, w, nm) = (2.5, 0.12, -1.8_f64, 550.0);
    let k = std::f64::consts::TAU / (nm * 1e-3);
    let field = Heightfield::sinusoid(period, amplitude, 4, 200).unwrap();
    let Cylinder { j, .. } = Cylinder::new((k * w.abs() * amplitude).into(), 6).unwrap();
    for m in -5..=5_i64 {
        let expected = j[m.unsigned_abs() as usize].norm_sqr();
        assert!((order(&field, m, period, w, nm) - expected).abs() < 1e-10, "{m}");
    }
    // Steps of the ramp scatter as sinc of a step; 4,000 are fine enough for 1e-6.
    let fall = 0.24623;
    let field = Heightfield::blazed(period, fall, 2, 4000).unwrap();
    for m in -3..=3_i64 {
        // The ramp falls: p = e^{−j k w fall x/d}, and w < 0.
        let x = std::f64::consts::PI * (w.abs() * fall / (nm * 1e-3) + m as f64);
        let expected = if x == 0.0 { 1.0 } else { (x.sin() / x).powi(2) };
        assert!((order(&field, m, period, w, nm) - expected).abs() < 1e-6, "{m}");
    }
}

/// Half of each period is `depth` deep: even orders vanish, and order 0 is cos²(κ depth/2).
#[test]
fn a_binary_grating_has_odd_orders_alone() {
    let (depth, w, nm) = (0.1, -1.7, 520.0);
    let heights = (0..1600).map(|i| if i % 400 < 200 { depth } else { 0.0 }).collect();
    let field = Heightfield::new([1600, 1], [8.0, 8.0], heights).unwrap();
    let kappa = std::f64::consts::TAU / (nm * 1e-3) * w;
    assert!((order(&field, 0, 2.0, w, nm) - (0.5 * kappa * depth).cos().powi(2)).abs() < 1e-12);
    for m in [-4, -2, 2, 4] {
        assert!(order(&field, m, 2.0, w, nm) < 1e-20, "{m}");
    }
    for m in [-3, -1, 1, 3] {
        // 2/(πm) of a continuous one; steps of a 400th of the period: 1e-4.
        let expected = (2.0 / (std::f64::consts::PI * m as f64) * (0.5 * kappa * depth).sin()).powi(2);
        assert!((order(&field, m, 2.0, w, nm) / expected - 1.0).abs() < 3e-4, "{m}");
    }
}

#[test]
fn a_blazed_grating_sends_green_to_its_first_order_along_x() {
    let field = Heightfield::blazed(2.5, 0.24623, 26, 100).unwrap();
    let setup = Setup::default();
    let normal = direction(0.0, 0.0);
    let first = f(&field, &setup, 500.0, normal, direction(11.537, 0.0));
    let other = f(&field, &setup, 500.0, normal, direction(11.537, 180.0));
    assert!(first > 100.0 * other, "{first} {other}");
    // 99.8 % of the reflected light by the closed form, times Γ = 1/cosθ_o.
    let around = [0.2, 0.0];
    let share =
        energy(&field, &setup, 500.0, normal, around, 0.03, 60) / fresnel(direction(5.77, 0.0).z, 1.5);
    let expected = 0.998 / direction(11.537, 0.0).z;
    assert!((share / expected - 1.0).abs() < 2e-3, "{share} {expected}");
}

#[test]
fn the_grating_equation_tells_the_period() {
    let field = Heightfield::blazed(2.5, 0.24623, 26, 100).unwrap();
    let setup = Setup { obliquity: Obliquity::Radiance, ..Setup::default() };
    let w_i = direction(75.0, 0.0);
    for nm in [380.0, 500.0, 640.0, 780.0] {
        // sinθ_o = λ/d − sinθ_i in the plane.
        let expected = w_i.x - nm * 1e-3 / 2.5;
        let (mut best, mut brightest) = (0.0, 0.0);
        for step in -400..=400 {
            let x = -expected + 1e-5 * f64::from(step);
            let found = f(&field, &setup, nm, w_i, DVec3::new(x, 0.0, (1.0 - x * x).sqrt()));
            if found > brightest {
                (best, brightest) = (x, found);
            }
        }
        let period = nm / (w_i.x + best);
        assert!((period - 2500.0).abs() < 1.0, "{nm}: {period}");
    }
}

#[test]
fn there_and_back_is_the_same_and_turning_the_field_turns_the_pattern() {
    let field =
        crate::structure::Fingers { cells: 120, size_um: 11.0, ..crate::structure::Fingers::XENOPELTIS };
    let field = Heightfield::fingers(&field, 3).unwrap();
    let turned = field.turned();
    let setup = Setup { place: Place::Anywhere, ..Setup::default() };
    for (a, b) in [((30.0, 10.0), (45.0, 170.0)), ((10.0, 80.0), (60.0, 260.0)), ((0.0, 0.0), (35.0, 100.0))]
    {
        let (w_i, w_o) = (direction(a.0, a.1), direction(b.0, b.1));
        let there = f(&field, &setup, 520.0, w_i, w_o);
        let back = f(&field, &setup, 520.0, w_o, w_i);
        assert!((there - back).abs() <= 1e-12 * there, "{there} {back}");
        let quarter = |w: DVec3| DVec3::new(-w.y, w.x, w.z);
        let other = f(&turned, &setup, 520.0, quarter(w_i), quarter(w_o));
        assert!((there - other).abs() <= 1e-9 * there, "{there} {other}");
    }
}

/// λ and all lengths times a.
#[test]
fn only_ratios_to_the_wavelength_count() {
    let one = Heightfield::sinusoid(2.0, 0.1, 16, 64).unwrap();
    let two = Heightfield::sinusoid(4.0, 0.2, 16, 64).unwrap();
    let (w_i, w_o) = (direction(20.0, 0.0), direction(40.0, 184.0));
    let of = |field: &Heightfield, nm: f64, deviation: f64| {
        f(field, &Setup { coherence: Coherence::Fixed(deviation), ..Setup::default() }, nm, w_i, w_o)
    };
    let (a, b) = (of(&one, 400.0, 5.0), of(&two, 800.0, 10.0));
    assert!((a / b - 1.0).abs() < 1e-12);
}

/// The specular part of a normally distributed surface is e^{−(k w s)²}.
#[test]
fn a_rough_mirror_keeps_its_part_of_the_light() {
    let mut stream = crate::math::rng::Stream::new(5, &[1]);
    let rms = 0.03;
    let heights = (0..128 * 128).map(|_| rms * stream.normal()).collect();
    let field = Heightfield::new([128, 128], [16.0, 16.0], heights).unwrap();
    let (w, nm) = (-1.7, 600.0);
    let k = std::f64::consts::TAU / 0.6;
    let found = order(&field, 0, 1.0, w, nm);
    let expected = (-(k * w * rms).powi(2)).exp();
    assert!((found / expected - 1.0).abs() < 0.03, "{found} {expected}");
}

/// Moving the window changes speckles, not their mean.
#[test]
fn the_mean_over_places_is_the_incoherent_sum() {
    let field =
        crate::structure::Fingers { cells: 60, size_um: 11.0, ..crate::structure::Fingers::XENOPELTIS };
    let field = Heightfield::fingers(&field, 3).unwrap();
    let (w_i, w_o) = (direction(20.0, 30.0), direction(35.0, 200.0));
    let coherence = Coherence::Fixed(2.0);
    let of = |place| f(&field, &Setup { place, coherence, ..Setup::default() }, 550.0, w_i, w_o);
    let places: Vec<f64> = (0..12 * 12)
        .map(|i| of(Place::At([f64::from(i % 12) * 11.0 / 12.0, f64::from(i / 12) * 11.0 / 12.0])))
        .collect();
    let mean = places.iter().sum::<f64>() / places.len() as f64;
    assert!((mean / of(Place::Anywhere) - 1.0).abs() < 1e-9, "{mean} {}", of(Place::Anywhere));
    assert!(places.iter().fold(0.0, |a: f64, b| a.max(*b)) > 1.5 * mean);
}

/// A patch that is flat on one side, with ridges on the other or a quarter of the way along: a window sees what it stands on, and its
/// series sees the same.
#[test]
fn a_window_sees_the_part_of_the_patch_that_it_stands_on() {
    let cells = 400;
    let ridges = |at: usize| 0.1 * (std::f64::consts::TAU * at as f64 * 0.1 / 2.0).cos();
    let (w_i, nm) = (direction(0.0, 0.0), 500.0);
    let at = Wavelengths::new([nm]).unwrap();
    for axis in [0, 1] {
        // Ridges from 20 to 40 of 40 µm, across `axis`.
        let height = |k: usize| if k < cells / 2 { 0.0 } else { ridges(k) };
        let (counts, size) = if axis == 0 { ([cells, 4], [40.0, 4.0]) } else { ([4, cells], [4.0, 40.0]) };
        let heights = (0..4 * cells).map(|k| height(if axis == 0 { k % cells } else { k / 4 })).collect();
        let field = Heightfield::new(counts, size, heights).unwrap();
        let first = direction(f64::asin(0.25).to_degrees(), 90.0 * axis as f64);
        let of = |place_um: f64, w_o: DVec3| {
            let mut place = [2.0; 2];
            place[axis] = place_um;
            let coherence = Coherence::Fixed(1.5);
            let setup = Setup { place: Place::At(place), coherence, ..Setup::default() };
            let fast =
                Amplitudes::new(&field, &setup, Reach::of(&setup, &at), Series::Chebyshev, &Unobserved)
                    .unwrap();
            let (plain, series) = (f(&field, &setup, nm, w_i, w_o), fast.value(&setup, nm * 1e-3, w_i, w_o));
            assert!((plain - series).abs() < 1e-8, "{axis} {place_um}: {plain} {series}");
            plain
        };
        let [flat, rough] = [10.0, 30.0].map(|place| [w_i, first].map(|w_o| of(place, w_o)));
        assert!(flat[1] < 1e-6 * flat[0] && rough[1] > 0.2 * flat[0], "{axis}: {flat:?} {rough:?}");
    }
}

/// A small patch of a snake and windows that see several orders of it.
fn small_snake() -> (Heightfield, Setup) {
    let field =
        crate::structure::Fingers { cells: 150, size_um: 11.0, ..crate::structure::Fingers::XENOPELTIS };
    let setup = Setup { coherence: Coherence::Fixed(3.0), ..Setup::default() };
    (Heightfield::fingers(&field, 3).unwrap(), setup)
}

fn pairs() -> Vec<(DVec3, DVec3)> {
    [
        ((30.0, 10.0), (45.0, 170.0)),
        ((10.0, 80.0), (60.0, 260.0)),
        ((0.0, 0.0), (1.0, 100.0)),
        ((75.0, 0.0), (20.0, 185.0)),
    ]
    .into_iter()
    .map(|(a, b)| (direction(a.0, a.1), direction(b.0, b.1)))
    .collect()
}

#[test]
fn amplitudes_and_powers_give_the_plain_sums() {
    let (field, setup) = small_snake();
    let at = Wavelengths::new([400.0, 530.0, 700.0]).unwrap();
    for place in [Place::At([2.0, 7.5]), Place::Anywhere] {
        let setup = Setup { place, ..setup };
        let reach = Reach::of(&setup, &at);
        let fast = Amplitudes::new(&field, &setup, reach, Series::Chebyshev, &Unobserved).unwrap();
        let powers = fast.powers().unwrap();
        for nm in at.nm() {
            for (w_i, w_o) in pairs() {
                let plain = f(&field, &setup, *nm, w_i, w_o);
                // Of a mirror's peak.
                let peak = setup.of_directions(w_i, w_o) * setup.of_wavelength(nm * 1e-3);
                let found = fast.value(&setup, nm * 1e-3, w_i, w_o);
                assert!((found - plain).abs() < 1e-9 * peak, "{nm} {place:?}: {found} {plain} of {peak}");
                if place == Place::Anywhere {
                    let found = powers.value(&setup, nm * 1e-3, w_i, w_o);
                    assert!((found - plain).abs() < 1e-7 * peak, "{nm}: {found} {plain} of {peak}");
                }
            }
        }
    }
}

/// At the places of the grid, and for the whole table as for single places.
#[test]
fn tables_are_the_sum_over_wavelengths() {
    let (field, setup) = small_snake();
    let at = Wavelengths::new([400.0, 480.0, 560.0, 640.0, 720.0]).unwrap();
    let observer = Observer::default();
    let grid = TableGrid { size: 21, exponent: 3.0 };
    let weights = observer.weights(&at);
    for place in [Place::At([0.0; 2]), Place::Anywhere] {
        let setup = Setup { place, ..setup };
        for (series, tolerance) in [(Series::Chebyshev, 1e-6), (Series::Taylor(30), 1e-6)] {
            let builder = Builder::new(&field, &setup, grid, series, &observer, &at, &Unobserved).unwrap();
            let tables = builder.tables(&Unobserved).unwrap();
            let mut largest: f64 = 0.0;
            let mut compared = 0;
            for (i, j) in [(10, 10), (11, 9), (7, 12), (14, 10), (10, 6)] {
                let (u, v) = (grid.coordinate(i), grid.coordinate(j));
                // Directions with this u and v and several w.
                for w_i in [direction(5.0, 30.0), direction(40.0, 200.0), direction(70.0, 90.0)] {
                    let (x, y) = (-u - w_i.x, -v - w_i.y);
                    if x * x + y * y >= 0.99 {
                        continue;
                    }
                    let w_o = DVec3::new(x, y, (1.0 - x * x - y * y).sqrt());
                    let spectrum: Vec<f64> =
                        at.nm().iter().map(|nm| f(&field, &setup, *nm, w_i, w_o)).collect();
                    let expected = weights.xyz(&spectrum)[1];
                    let mirror = setup.of_directions(w_i, w_o) * setup.of_wavelength(0.55);
                    let whole = tables.xyz(w_i, w_o);
                    largest = largest.max((whole[1] - expected).abs() / mirror);
                    compared += 1;
                    let alone = builder.xyz(w_i, w_o);
                    assert!((alone[1] - whole[1]).abs() < 1e-9 * mirror, "{alone:?} {whole:?}");
                }
            }
            assert!(compared > 8 && largest < tolerance, "{series:?} {place:?}: {largest:e}, {compared}");
        }
    }
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let (field, setup) = small_snake();
    let at = Wavelengths::new([450.0, 600.0]).unwrap();
    let grid = TableGrid { size: 15, exponent: 3.0 };
    let make = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let unobserved = crate::progress::Unobserved;
            Builder::new(&field, &setup, grid, Series::Chebyshev, &Observer::default(), &at, &unobserved)
                .and_then(|builder| builder.tables(&unobserved))
                .unwrap()
        })
    };
    assert_eq!(make(1), make(3));
}

/// The turns that orders go through from cell to cell are those of e^{2πi j x/T} to the last bit, on either side of zero.
#[test]
fn orders_go_from_cell_to_cell_through_the_turns_of_the_axis() {
    for count in [1_i64, 2, 7, 64, 1000] {
        let field = Heightfield::new([count as usize, 3], [1.0; 2], vec![0.0; 3 * count as usize]).unwrap();
        let Turns([by_x, by_y]) = Turns::of(&field);
        assert_eq!((by_x.len(), by_y.len()), (count as usize, 3));
        let orders: Vec<(i64, f64)> = (-9..=9).map(|j| (j, 1.0)).collect();
        let mut places = Places::of(&orders, count as usize);
        for cell in 0..count {
            places.next(&by_x, orders.iter(), |(j, _), turn| {
                let part = (j * cell).rem_euclid(count) as f64;
                assert_eq!(turn, cis(std::f64::consts::TAU * part / count as f64), "order {j}, cell {cell}");
            });
        }
    }
}

/// A patch far wider than the coherence is refused before anything is summed, by values as by tables.
#[test]
fn patches_far_wider_than_the_coherence_are_refused_first() {
    let field = Heightfield::new([100, 1], [30_000.0, 1.0], vec![0.0; 100]).unwrap();
    let at = Wavelengths::new([450.0, 550.0]).unwrap();
    let (setup, observer) = (Setup::default(), Observer::default());
    let values = spectrum(&field, &setup, &at, DVec3::Z, DVec3::Z, &Unobserved).unwrap_err();
    let grid = TableGrid { size: 3, ..TableGrid::USUAL };
    let tables =
        Builder::new(&field, &setup, grid, Series::Chebyshev, &observer, &at, &Unobserved).err().unwrap();
    for error in [values, tables] {
        assert!(
            error.to_string().starts_with("a patch of 30000 µm is far wider than the coherence"),
            "{error}"
        );
    }
}

/// Without heights both are Fresnel's mirror in both polarizations; with heights far below the wavelength over a period far above it they have the
/// same orders.
#[test]
fn gentle_ridges_have_the_orders_of_maxwells_equations() {
    let solver = Rcwa { orders: 12, slices: 8, estimate: false };
    let flat = Heightfield::new([16, 1], [2.0; 2], vec![0.0; 16]).unwrap();
    for phi in [0.0, 0.7_f64] {
        let found = ridge_orders(&flat, 1.56, 550.0, phi, &solver).unwrap();
        for polarization in [0, 1] {
            let [scalar, exact] = found.whole(|order| order.polarized(polarization));
            assert!((scalar / exact - 1.0).abs() < 1e-9, "{phi} {polarization}: {scalar} {exact}");
        }
        let [scalar, _] = found.whole(OrderPower::unpolarized);
        assert!((scalar / fresnel(phi.cos(), 1.56) - 1.0).abs() < 1e-9);
    }
    let gentle = Heightfield::sinusoid(5.5, 0.02, 1, 64).unwrap();
    let solver = Rcwa { orders: 36, slices: 12, estimate: false };
    let found = ridge_orders(&gentle, 1.56, 550.0, 0.3, &solver).unwrap();
    assert!(found.misplaced(OrderPower::unpolarized) < 0.01, "{found:?}");
    assert!(ridge_orders(&flat.turned(), 1.56, 550.0, 0.0, &solver).unwrap_err().is_input());
}
