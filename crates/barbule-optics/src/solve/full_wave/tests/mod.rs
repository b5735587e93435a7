//! Boundary elements against series, conservation laws and themselves.

mod series;

use super::*;
use crate::material::Library;
use crate::progress::{NO_CLOCK, Unobserved};
use crate::structure::{Inclusion, Loop, Medium, Parts, Substance};
use series::{Circle, Series};

fn index(n: f64, k: f64) -> Complex64 {
    Complex64::new(n, k)
}

fn circle(at: [f64; 2], radius_um: f64, index: Complex64, parent: Option<usize>) -> Circle {
    Circle { at, radius_um, index, parent }
}

fn section_of(circles: &[Circle]) -> Section {
    let inclusions = circles.iter().map(|circle| Inclusion {
        outline: Loop::Circle { x_um: circle.at[0], z_um: circle.at[1], radius_um: circle.radius_um },
        medium: Medium::Pure(Substance::Index(circle.index)),
        holes: Vec::new(),
    });
    let parts =
        Parts { media: vec![Medium::named("air")], inclusions: inclusions.collect(), ..Parts::default() };
    Section::new(parts, Library::builtin()).unwrap()
}

fn solved(section: &Section, theta: f64, phi: f64, elements: f64) -> Scattered {
    let problem = Problem::new(section, 500.0, theta, elements).unwrap().by(Method::Dense);
    problem.solve(&[phi], Window::PlaneWave, 72, NO_CLOCK, &Unobserved).unwrap().swap_remove(0)
}

/// The largest error of amplitudes against their largest value.
fn error(circles: &[Circle], theta: f64, phi: f64, elements: f64) -> f64 {
    let section = section_of(circles);
    let found = solved(&section, theta, phi, elements);
    let k = crate::spectrum::wave_number_per_um(500.0);
    let series = Series { circles, k, theta_i: theta, phi_i: phi, orders: 28 };
    let phi_o = Azimuths::FullCircle(72).phi_o();
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for polarization in 0..2 {
        let expected = series.far(polarization, &phi_o);
        for (got, expected) in found.far.amplitudes[polarization].iter().zip(&expected) {
            for (a, b) in got.iter().zip(expected) {
                worst = worst.max((a - b).norm());
                largest = largest.max(b.norm());
            }
        }
    }
    worst / largest
}

/// Waves at every θ_i, of single, coated, hollow and absorbing circles, of eccentric rods in one, and of several.
#[test]
fn circles_in_circles_scatter_as_their_series() {
    let (keratin, melanin) = (index(1.56, 0.0), index(1.75, 0.1));
    let cases: [&[Circle]; 6] = [
        &[circle([0.1, -0.2], 0.5, keratin, None)],
        &[circle([0.0, 0.0], 0.4, melanin, None)],
        &[circle([0.0, 0.0], 0.5, keratin, None), circle([0.0, 0.0], 0.35, melanin, Some(0))],
        &[circle([0.0, 0.0], 0.5, keratin, None), circle([0.0, 0.0], 0.45, index(1.0, 0.0), Some(0))],
        &[
            circle([0.0, 0.0], 0.7, keratin, None),
            circle([0.25, 0.2], 0.2, melanin, Some(0)),
            circle([-0.3, 0.1], 0.15, index(1.0, 0.0), Some(0)),
            circle([0.1, -0.35], 0.25, melanin, Some(0)),
            circle([0.15, -0.35], 0.1, index(1.0, 0.0), Some(3)),
        ],
        &[
            circle([-0.5, 0.0], 0.3, keratin, None),
            circle([0.2, 0.3], 0.3, melanin, None),
            circle([0.3, -0.4], 0.25, keratin, None),
        ],
    ];
    for circles in cases {
        for theta in [0.0, 30.0, 60.0_f64] {
            let error = error(circles, theta.to_radians(), 0.3, 10.0);
            assert!(error < 1e-5, "{} circles, θ_i = {theta}°: {error:e}", circles.len());
        }
    }
}

/// Errors fall with the order of the panels, eight nodes each: spectrally until tables and rounding end it.
#[test]
fn errors_converge_with_the_order_of_the_panels() {
    let circles =
        [circle([0.0, 0.0], 0.6, index(1.56, 0.0), None), circle([0.1, 0.2], 0.3, index(1.75, 0.1), Some(0))];
    let error = |elements: f64| error(&circles, 0.5, 0.3, elements);
    // The table of the theory page, with a little room.
    let most = [(5.0, 3e-4), (7.0, 1e-5), (10.0, 4e-7), (14.0, 1e-8), (20.0, 5e-10)];
    for (elements, most) in most {
        let error = error(elements);
        assert!(error < most, "{elements} nodes per wavelength: {error:e}");
    }
}

/// A polygon with an index.
fn polygon(corners: &[[f64; 2]], n: Complex64) -> Inclusion {
    let [x, z] = [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).collect());
    Inclusion { outline: Loop::polygon(x, z), medium: Medium::Pure(Substance::Index(n)), holes: Vec::new() }
}

fn section(inclusions: Vec<Inclusion>) -> Section {
    let parts = Parts { media: vec![Medium::named("air")], inclusions, ..Parts::default() };
    Section::new(parts, Library::builtin()).unwrap()
}

/// A regular polygon, turned by a little.
fn regular(corners: usize, at: [f64; 2], radius_um: f64) -> Vec<[f64; 2]> {
    let angle = |i: usize| std::f64::consts::TAU * i as f64 / corners as f64 + 0.2;
    (0..corners).map(|i| [at[0] + radius_um * angle(i).sin(), at[1] + radius_um * angle(i).cos()]).collect()
}

/// Five circles of 0.25 µm joined at notches, sampled every 15°: a chain of melanosomes.
fn chain(at: [f64; 2]) -> Vec<[f64; 2]> {
    let (radius, notch) = (0.125, (2.0_f64 / 3.0).acos());
    let mut upper = Vec::new();
    for c in 0..5 {
        let left = if c == 0 { -PI / 2.0 } else { notch - PI / 2.0 };
        let right = if c == 4 { PI / 2.0 } else { PI / 2.0 - notch };
        let step = if c == 0 || c == 4 { 10 } else { 6 };
        for s in (if c == 0 { 0 } else { 1 })..=step {
            let angle = left + (right - left) * f64::from(s) / f64::from(step);
            let x = 2.0 * radius * notch.sin() * f64::from(c);
            upper.push([at[0] + x + radius * angle.sin(), at[1] + radius * angle.cos()]);
        }
    }
    let lower: Vec<[f64; 2]> =
        upper[1..upper.len() - 1].iter().rev().map(|p| [p[0], 2.0 * at[1] - p[1]]).collect();
    upper.into_iter().chain(lower).collect()
}

/// A body with a square hole's worth of air, an absorbing chain and a rod.
fn body() -> Section {
    section(vec![
        polygon(&regular(60, [0.5, 0.0], 1.0), index(1.56, 0.0)),
        polygon(&chain([0.05, 0.45]), index(1.75, 0.08)),
        polygon(&regular(4, [0.4, -0.2], 0.3), index(1.0, 0.0)),
        polygon(&regular(7, [1.9, 0.3], 0.25), index(1.6, 0.02)),
    ])
}

/// Largest difference of two far fields against the largest amplitude.
fn apart(a: &Scattered, b: &Scattered) -> f64 {
    let all =
        |found: &Scattered| found.far.amplitudes.iter().flatten().flatten().copied().collect::<Vec<_>>();
    let (a, b) = (all(a), all(b));
    let worst = a.iter().zip(&b).map(|(x, y)| (x - y).norm()).fold(0.0, f64::max);
    worst / a.iter().map(|x| x.norm()).fold(0.0, f64::max)
}

#[test]
fn scattered_and_absorbed_light_is_what_is_missing_behind() {
    let body = body();
    for (theta, phi) in [(0.0, 0.3), (0.7, -0.5), (-0.4, 1.1)] {
        let found = solved(&body, theta, phi, 10.0);
        for p in 0..2 {
            let Exact { scattered_um, extinction_um, absorbed_um } = found.exact.unwrap();
            let extinct = extinction_um.unwrap()[p];
            let balance = (scattered_um[p] + absorbed_um[p]) / extinct - 1.0;
            assert!(absorbed_um[p] > 0.05 * extinct, "the chain absorbs");
            assert!(balance.abs() < 3e-4, "{theta} {phi} {p}: {balance:e}");
        }
    }
}

#[test]
fn polygons_converge_though_fields_are_singular_at_corners() {
    let body = body();
    let reference = solved(&body, 0.3, 0.2, 30.0);
    for (elements, most) in [(6.0, 2e-2), (10.0, 2e-3), (20.0, 5e-4)] {
        let error = apart(&reference, &solved(&body, 0.3, 0.2, elements));
        assert!(error < most, "{elements}: {error:e}");
    }
}

/// Light that goes the way back: from (−θ_i, φ_o), seen towards φ_i.
#[test]
fn amplitudes_are_the_same_on_the_way_back() {
    let body = body();
    let degrees = |n: usize| (n as f64 * 5.0 - 180.0).to_radians();
    let (there, back) = (40, 29);
    for theta in [0.0, 0.6] {
        let one = solved(&body, theta, degrees(there), 10.0);
        let other = solved(&body, -theta, degrees(back), 10.0);
        let largest = one.far.amplitudes.iter().flatten().flatten().map(|a| a.norm()).fold(0.0, f64::max);
        for p in 0..2 {
            for q in 0..2 {
                let (a, b) = (one.far.amplitudes[q][p][back], other.far.amplitudes[p][q][there]);
                assert!((a - b).norm() < 5e-4 * largest, "{theta} {q} {p}: {a} {b}");
            }
        }
    }
}

#[test]
fn numbers_of_regions_and_invisible_boundaries_change_nothing() {
    let body = body();
    let found = solved(&body, 0.4, 0.3, 10.0);
    let mut turned = body.inclusions.clone();
    turned.rotate_left(2);
    assert!(apart(&found, &solved(&section(turned), 0.4, 0.3, 10.0)) < 1e-10);
    let mut more = body.inclusions.clone();
    more.push(polygon(&regular(30, [1.1, -0.3], 0.08), index(1.56, 0.0)));
    more.push(polygon(&regular(50, [-1.5, 0.0], 0.3), index(1.0, 0.0)));
    let error = apart(&found, &solved(&section(more), 0.4, 0.3, 10.0));
    // Currents on an invisible boundary radiate nothing out of it, as far as quadrature tells; it stands so far from the
    // others that they keep their panels.
    assert!(error < 1e-5, "{error:e}");
}

#[test]
fn what_cannot_be_solved_is_refused_by_its_place() {
    let refused = |section: &Section| Problem::new(section, 500.0, 0.0, 10.0).err().unwrap().to_string();
    let n = index(1.5, 0.0);
    // Between corners of the polygons of 64 that stand for circles where sections are checked.
    let (z, x) = (PI / 64.0).sin_cos();
    let beside = [0.4996 * x, 0.4996 * z];
    let touching = section_of(&[circle([0.0, 0.0], 0.25, n, None), circle(beside, 0.25, n, None)]);
    assert!(refused(&touching).contains("inclusions[0] and inclusions[1]"), "{}", refused(&touching));
    let open = crate::structure::Structure::flat("air/keratin:500/air").unwrap().instance(1, 0).unwrap();
    assert!(refused(&open).contains("closed"), "{}", refused(&open));
    let mixture = Medium::Mixture {
        first: Substance::named("keratin"),
        second: Substance::named("melanin"),
        x_um: vec![-1.0, 1.0],
        fraction: vec![0.2, 0.8],
    };
    let graded = section(vec![Inclusion { medium: mixture, ..polygon(&regular(5, [0.0; 2], 0.5), n) }]);
    assert!(refused(&graded).contains("inclusions[0]"), "{}", refused(&graded));
}

/// Bits, costs, and light through a window.
#[test]
fn solutions_are_the_same_bits_on_any_number_of_threads() {
    let body = body();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let problem = Problem::new(&body, 500.0, 0.4, 7.0).unwrap();
        pool.install(|| problem.solve(&[0.1, -0.4], Window::Gaussian, 36, NO_CLOCK, &Unobserved).unwrap())
    };
    let (one, three) = (run(1), run(3));
    for (one, three) in one.iter().zip(&three) {
        assert_eq!((&one.far, one.reflected, one.exact), (&three.far, three.reflected, three.exact));
        let reflected = one.reflected.unwrap();
        assert!((0..2).all(|p| reflected[p] > 0.0 && reflected[p] < one.far.radiated[p]));
        assert!(one.exact.unwrap().extinction_um.is_none());
        assert_eq!(
            one.effort.unwrap().unknowns,
            Problem::new(&body, 500.0, 0.4, 7.0).unwrap().cost(1).unknowns
        );
    }
}

/// A long slab with rows of rods: what is near is far away along it.
fn slab(length_um: f64) -> Section {
    let half = 0.5 * length_um;
    let mut circles = Vec::new();
    let mut x = 0.2 - half;
    while x < half - 0.15 {
        for row in 0..3 {
            circles.push(circle([x, -0.25 * f64::from(row)], 0.08, index(1.7, 0.05), None));
        }
        x += 0.25;
    }
    let mut inclusions = section_of(&circles).inclusions;
    let outline = [[-half, 0.2], [half, 0.2], [half, -0.7], [-half, -0.7]];
    inclusions.push(polygon(&outline, index(1.56, 0.0)));
    section(inclusions)
}

#[test]
fn thin_products_give_what_all_elements_give() {
    let slab = slab(2.5);
    for theta in [0.0, 0.4] {
        let run = |method| {
            let problem = Problem::new(&slab, 500.0, theta, 8.0).unwrap().by(method);
            problem.solve(&[0.3], Window::PlaneWave, 72, NO_CLOCK, &Unobserved).unwrap().swap_remove(0)
        };
        let (dense, thin) = (run(Method::Dense), run(Method::Hierarchical));
        let error = apart(&dense, &thin);
        assert!(error < 3e-5, "{theta}: {error:e}");
    }
    let problem = Problem::new(&slab, 500.0, 0.0, 8.0).unwrap().by(Method::Hierarchical).within(1 << 20);
    let refused = problem.solve(&[0.3], Window::PlaneWave, 72, NO_CLOCK, &Unobserved);
    assert!(refused.unwrap_err().to_string().contains("memory"));
}

/// A solution whose powers do not balance is said to be none.
#[test]
fn powers_that_do_not_balance_are_said() {
    let section = section_of(&[circle([0.0; 2], 0.3, index(1.5, 0.1), None)]);
    let found = solved(&section, 0.2, 0.1, 10.0);
    let light = Illumination { wavelength_nm: 500.0, theta_i: 0.2, phi_i: 0.1, window: Window::PlaneWave };
    assert_eq!(balance_doubt(&light, &found), None);
    let mut exact = found.exact.unwrap();
    exact.scattered_um[1] *= 1.2;
    let doubt = balance_doubt(&light, &Scattered { exact: Some(exact), ..found.clone() }).unwrap();
    assert!(doubt.contains("at 500 nm") && doubt.contains("polarization 2 scatters and absorbs"), "{doubt}");
    let exact = Some(Exact { extinction_um: None, ..found.exact.unwrap() });
    let beam = Scattered { reflected: Some([0.2, 1.2]), exact, ..found };
    assert!(balance_doubt(&light, &beam).unwrap().contains("polarization 2 reflects 1.2000"));
}

/// What lies under a crystal's rods sends back less than an amplitude of 0.003 at normal incidence, 0.007 at the steepest that light has in
/// keratin: one step of all k at once, 0.032.
#[test]
fn the_absorbing_host_sends_nothing_back() {
    use crate::film::{Polarization, reflect};
    use crate::structure::{ABSORPTION, RAMP, RAMP_STEP_UM};
    let n = 1.56;
    let mut indices = vec![index(n, 0.0)];
    indices.extend(RAMP.iter().map(|part| index(n, part * ABSORPTION)));
    let thickness_nm = vec![1e3 * RAMP_STEP_UM; RAMP.len() - 1];
    let most = |angle: f64| {
        let amplitudes = (400..=694).step_by(6).flat_map(|nm| {
            [Polarization::S, Polarization::P].map(|polarization| {
                reflect(&indices, &thickness_nm, f64::from(nm), angle, polarization).unwrap().norm()
            })
        });
        amplitudes.fold(0.0, f64::max)
    };
    assert!(most(0.0) < 0.003, "{}", most(0.0));
    assert!(most((1.0 / n).asin()) < 0.016, "{}", most((1.0 / n).asin()));
    let at_once = reflect(&[index(n, 0.0), index(n, ABSORPTION)], &[], 550.0, 0.0, Polarization::S).unwrap();
    assert!((at_once.norm() - 0.032).abs() < 1e-3);
    // What is left of light that goes down to the bottom and back, of keratin in air, from 1.5 µm under the top.
    let depth_um = 2.5 - RAMP_STEP_UM * RAMP.len() as f64;
    let way = (-8.0 * PI * ABSORPTION * depth_um / 0.694).exp();
    assert!((way * 0.048).sqrt() < 0.006, "{}", (way * 0.048).sqrt());
}
