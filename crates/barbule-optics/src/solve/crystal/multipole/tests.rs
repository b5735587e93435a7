//! Laws that any solution must obey. Values of an independent program: `barbule/tests/it/crystal_values.rs`.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::*;
use crate::solve::crystal::cells::{in_keratin, keratin, magpie, mallard, melanin, peafowl, rod};

const AIR: Complex64 = Complex64::new(1.0, 0.0);

/// Rods of several kinds at odd places, without any symmetry, in one layer of two depths and another layer.
fn irregular(nm: f64) -> Cell {
    let rods = vec![
        rod(0.03, 0.11, &[(0.12, melanin(nm)), (0.05, AIR)]),
        rod(0.21, 0.15, &[(0.07, AIR)]),
        rod(0.15, 0.33, &[(0.1, melanin(nm))]),
    ];
    in_keratin(0.29, nm, rods)
}

const CELLS: [fn(f64) -> Cell; 4] = [mallard, magpie, peafowl, irregular];

/// `count` points (λ in nm, θ, φ) spread over 300–700 nm and angles up to 89.9°.
fn points(count: u32) -> impl Iterator<Item = (f64, f64, f64)> {
    let reach = 89.9f64.to_radians();
    let spread = move |i: u32, step: f64| 2.0 * (f64::from(i + 1) * step).fract() - 1.0;
    (0..count).map(move |i| {
        (500.0 + 200.0 * spread(i, 0.819_172), reach * spread(i, 0.671_043_6), reach * spread(i, 0.549_700_5))
    })
}

fn respond(cell: &Cell, nm: f64, theta_i: f64, phi_i: f64) -> CrystalResponse {
    Multipole::default().respond(cell, &Incidence { wavelength_nm: nm, theta_i, phi_i }).unwrap()
}

fn order(response: &CrystalResponse, m: i32) -> &Order {
    response.orders.iter().find(|order| order.m == m).unwrap()
}

fn apart(a: &Order, b: &Order) -> f64 {
    (0..4).map(|i| (a.jones[i / 2][i % 2] - b.jones[i / 2][i % 2]).norm()).fold(0.0, f64::max)
}

#[test]
fn energy_is_kept_from_the_zenith_to_the_horizon() {
    for make in CELLS {
        for (nm, theta, phi) in points(40) {
            let response = respond(&make(nm), nm, theta, phi);
            for q in 0..2 {
                let sum: f64 = response.orders.iter().map(|order| order.reflectance(phi)[q]).sum();
                let error = sum + response.transmitted[q] + response.absorbed[q] - 1.0;
                // rounding of fluxes over cosφ·cosθ
                assert!(error.abs() < 1e-12 + 1e-14 / phi.cos(), "{nm} {theta} {phi} {q}: {error:e}");
            }
        }
    }
}

#[test]
fn rods_of_the_host_leave_the_flat_surface() {
    for (nm, theta, phi) in points(30) {
        let mut crystal = irregular(nm);
        for shell in crystal.rods.iter_mut().flat_map(|rod| &mut rod.shells) {
            shell.eps = crystal.host_eps;
        }
        let response = respond(&crystal, nm, theta, phi);
        // Fresnel in the plane of incidence, from the angles alone; s lies along ω × z
        let (n, cosine) = (keratin(nm).re.sqrt(), theta.cos() * phi.cos());
        let inner = (1.0 - (1.0 - cosine * cosine) / (n * n)).sqrt();
        let s = (cosine - n * inner) / (cosine + n * inner);
        let p = (n * cosine - inner) / (n * cosine + inner);
        let power: f64 = (0..2).map(|q| order(&response, 0).reflectance(phi)[q]).sum();
        assert!((power - s * s - p * p).abs() < 1e-13, "{nm} {theta} {phi}");
        let jones = order(&response, 0).jones;
        let determinant = jones[0][0] * jones[1][1] - jones[0][1] * jones[1][0];
        // s keeps E, p keeps H̃: with outgoing e₁, e₂ of mirrored handedness the determinant is −s·p
        assert!((determinant + s * p).norm() < 1e-13, "{nm} {theta} {phi}: {determinant} {}", s * p);
        assert!(response.absorbed.iter().all(|a| a.abs() < 1e-13));
    }
}

#[test]
fn nothing_reflects_where_nothing_differs() {
    for (nm, theta, phi) in points(20) {
        let mut crystal = magpie(nm);
        crystal.host_eps = AIR;
        for shell in crystal.rods.iter_mut().flat_map(|rod| &mut rod.shells) {
            shell.eps = AIR;
        }
        let response = respond(&crystal, nm, theta, phi);
        assert!(
            response.orders.iter().all(|o| o.jones.iter().flatten().all(|x| x.norm() < 1e-9)),
            "{nm} {theta} {phi}"
        );
        assert!(response.transmitted.iter().all(|t| (t - 1.0).abs() < 1e-9), "{:?}", response.transmitted);
    }
}

#[test]
fn larger_expansions_change_nothing_beyond_the_estimate() {
    for make in CELLS {
        for (nm, theta, phi) in points(12) {
            let found = respond(&make(nm), nm, theta, phi);
            let fine =
                Multipole { tolerance: 1e-11 }.prepare(&make(nm), nm, theta).unwrap().respond(phi).unwrap();
            for (a, b) in found.orders.iter().zip(&fine.orders) {
                for q in 0..2 {
                    let error = (a.reflectance(phi)[q] - b.reflectance(phi)[q]).abs();
                    // the estimate is of the right size, no bound
                    assert!(
                        error < 5e-9 && found.convergence.unwrap() <= TOLERANCE,
                        "{nm} {theta} {phi}: {error:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn every_multipole_gains_the_same_factor() {
    let (nm, theta, phi) = (420.0, 0.4, 0.7);
    let crystal = mallard(nm);
    let prepared = Multipole { tolerance: 1e-13 }.prepare(&crystal, nm, theta).unwrap();
    let with = |m: usize| prepared.respond_with(m, phi).unwrap();
    let exact = with(20);
    let errors: Vec<f64> = [2, 4, 6, 8].map(|m| apart(&with(m).orders[0], &exact.orders[0])).to_vec();
    assert!(errors.windows(2).all(|pair| pair[1] < 0.1 * pair[0]) && errors[3] < 1e-8, "{errors:?}");
}

#[test]
fn light_goes_the_same_way_back() {
    // from ω_i to −ω_i's order m and back along the same path: J ↔ Jᵀ
    for make in [peafowl, irregular] {
        for (nm, theta, phi) in points(16) {
            let forth = respond(&make(nm), nm, theta, phi);
            for out in &forth.orders {
                let back = respond(&make(nm), nm, -theta, out.phi_o);
                let twin = order(&back, out.m);
                assert!((twin.phi_o - phi).abs() < 1e-6);
                let scale = (out.phi_o.cos() / phi.cos()).sqrt();
                for (i, k, sign) in [(0, 0, 1.0), (1, 1, 1.0), (0, 1, 1.0), (1, 0, 1.0)] {
                    let difference = out.jones[i][k] * scale - sign * twin.jones[k][i] / scale;
                    assert!(
                        difference.norm() < 1e-8,
                        "{nm} {theta} {phi} {} {i}{k}: {:?} {:?}",
                        out.m,
                        out.jones,
                        twin.jones
                    );
                }
            }
        }
    }
}

#[test]
fn mirror_images_and_turned_crystals_answer_alike() {
    for (nm, theta, phi) in points(12) {
        let crystal = irregular(nm);
        let mut mirrored = crystal.clone();
        for rod in &mut mirrored.rods {
            rod.x_um = -rod.x_um;
        }
        let plain = respond(&crystal, nm, theta, phi);
        let image = respond(&mirrored, nm, theta, -phi);
        // x → −x: e₁ keeps its y, e₂ turns round; y → −y: e₁ turns round
        let beyond = respond(&crystal, nm, -theta, phi);
        for out in &plain.orders {
            let (image, beyond) = (order(&image, -out.m), order(&beyond, out.m));
            for (i, k) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let sign = if i == k { 1.0 } else { -1.0 };
                assert!(
                    (out.jones[i][k] - sign * image.jones[i][k]).norm() < 1e-11,
                    "mirror {nm} {theta} {phi}"
                );
                assert!((out.jones[i][k] - sign * beyond.jones[i][k]).norm() < 1e-11, "θ {nm} {theta} {phi}");
            }
        }
        let turned = respond(&mirrored, nm, -theta, -phi);
        for out in &plain.orders {
            assert!(apart(out, order(&turned, -out.m)) < 1e-11, "turn {nm} {theta} {phi}");
        }
    }
}

#[test]
fn two_periods_are_one_supercell() {
    for make in [mallard, magpie, peafowl] {
        for (nm, theta, phi) in points(4) {
            let crystal = make(nm);
            let mut double = crystal.clone();
            double.period_um *= 2.0;
            for rod in &crystal.rods {
                let mut copy = rod.clone();
                copy.x_um += crystal.period_um;
                double.rods.push(copy);
            }
            let (single, double) = (respond(&crystal, nm, theta, phi), respond(&double, nm, theta, phi));
            for out in &double.orders {
                if out.m % 2 == 0 {
                    let error = apart(out, order(&single, out.m / 2));
                    assert!(error < 3e-9, "{nm} {theta} {phi} {}: {error:e}", out.m);
                } else {
                    assert!(
                        out.jones.iter().flatten().all(|x| x.norm() < 1e-10),
                        "{nm} {theta} {phi} {}",
                        out.m
                    );
                }
            }
            assert!((0..2).all(|q| (single.absorbed[q] - double.absorbed[q]).abs() < 3e-9));
        }
    }
}

#[test]
fn rods_may_come_in_any_order_and_shifts_only_turn_phases() {
    for (nm, theta, phi) in points(8) {
        let crystal = irregular(nm);
        let plain = respond(&crystal, nm, theta, phi);
        let mut other = crystal.clone();
        other.rods.reverse();
        let shift = 0.37;
        for rod in &mut other.rods {
            rod.x_um += shift;
        }
        let moved = respond(&other, nm, theta, phi);
        for (a, b) in plain.orders.iter().zip(&moved.orders) {
            let phase = Complex64::cis(-TAU * f64::from(a.m) * shift / crystal.period_um);
            let expected = Order { jones: a.jones.map(|row| row.map(|x| x * phase)), ..*a };
            assert!(apart(&expected, b) < 1e-11, "{nm} {theta} {phi}");
        }
    }
}

#[test]
fn one_cluster_and_separate_layers_agree() {
    let nm = 480.0;
    let close = |gap: f64| {
        let shells = [(0.06, melanin(nm))];
        in_keratin(0.2, nm, vec![rod(0.0, 0.1, &shells), rod(0.07, 0.1 + gap, &shells)])
    };
    // either side of the depth at which rods go into layers of their own
    let (near, far) =
        (respond(&close(0.05 - 1e-9), nm, 0.5, 0.6), respond(&close(0.05 + 1e-9), nm, 0.5, 0.6));
    assert!(apart(&near.orders[0], &far.orders[0]) < 1e-8);
}

#[test]
fn grazing_light_is_reflected_whole() {
    for make in CELLS {
        for theta in [0.0, 0.8, -1.5] {
            for side in [-1.0, 1.0] {
                for phi in [FRAC_PI_2.next_down(), FRAC_PI_2 - 1e-9] {
                    let jones = order(&respond(&make(450.0), 450.0, theta, side * phi), 0).jones;
                    let expected = [[-1.0, 0.0], [0.0, 1.0]];
                    for (i, k) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                        assert!((jones[i][k] - expected[i][k]).norm() < 1e-6, "{theta} {phi}: {jones:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn orders_at_their_cut_off_are_no_obstacle() {
    let nm: f64 = 320.0;
    let crystal = mallard(nm);
    let wave = |theta: f64| Wave::new(&crystal, nm, theta).unwrap();
    for theta in [0.0, 0.3, 89f64.to_radians()] {
        let wave = wave(theta);
        for kappa in [wave.kappa0, wave.kappa.re] {
            for m in -2..=2 {
                for side in [-1.0, 1.0] {
                    let sine = (f64::from(m) * TAU / 0.2 - side * kappa) / wave.kappa0;
                    if sine.abs() >= 1.0 {
                        continue;
                    }
                    let exact = sine.asin();
                    let found = respond(&crystal, nm, theta, exact);
                    let beside = respond(&crystal, nm, theta, exact + 1e-11);
                    let change = apart(order(&found, 0), order(&beside, 0));
                    // R has a root at the cut-off: √(2·1e-11) of an amplitude at most
                    assert!(change < 3e-5, "{theta} {m} {kappa}: {change:e}");
                    let total = found.orders.iter().map(|o| o.reflectance(exact)[0]).sum::<f64>();
                    assert!((total + found.transmitted[0] + found.absorbed[0] - 1.0).abs() < 1e-6);
                }
            }
        }
    }
    for angle in [0.0, 89f64.to_radians(), 89.9f64.to_radians()] {
        assert!(respond(&crystal, nm, angle, angle).orders.iter().all(|o| o.jones[0][0].is_finite()));
    }
}

#[test]
fn an_absorbing_host_is_a_limit_of_a_lossless_one() {
    let (nm, theta, phi) = (450.0, 0.5, -0.6);
    for make in CELLS {
        let lossless = respond(&make(nm), nm, theta, phi);
        let mut crystal = make(nm);
        crystal.host_eps += Complex64::new(0.0, 1e-9);
        let lossy = respond(&crystal, nm, theta, phi);
        assert!(apart(&lossless.orders[0], &lossy.orders[0]) < 1e-7);
        // 1 − R − T there, the fluxes into the rods here.
        let change = |q: usize| (lossless.absorbed[q] - lossy.absorbed[q]).abs();
        assert!(change(0).max(change(1)) < 1e-7, "{:e} {:e}", change(0), change(1));
        crystal.host_eps += Complex64::new(0.0, 0.2);
        let dark = respond(&crystal, nm, theta, phi);
        assert!(dark.absorbed[0] > lossless.absorbed[0] && dark.transmitted[0] > 0.0);
    }
}
