//! Barbules over photonic crystals: the fast simulation against its plain reference, closed forms and laws.
//! `target/release/examples/simulation_tables` prints the figures that are held here.

use barbule::scattering::far_field::Polarization;
use barbule::solve::crystal::{Cell, CrystalResponse, CrystalSolver, Incidence, Multipole};
use barbule::solve::surface::FINE_ELEMENT_UM;
use barbule::structure::{CrystalLayer, Polyline, Section, crystal_species};
use num_complex::Complex64;

use crate::measure::crystals::{
    converged_errors, fast, largest_reflected, layer, plain_errors, sparse, under,
};
use crate::measure::fields::larger;

/// A wavelength (nm), θ_i and φ_i (rad).
const SPARSE: (f64, f64, f64) = (450.0, 0.3, 0.3);

fn flat(width_um: f64, crystal: CrystalLayer) -> Section {
    let half = 0.5 * width_um;
    under(Polyline { x_um: vec![-half, 0.0, half], z_um: vec![0.0; 3] }, crystal)
}

/// The flat crystal itself.
fn ideal(crystal: &CrystalLayer, nm: f64, theta: f64, phi: f64) -> CrystalResponse {
    let cell = Cell::new(&crystal.lattice, nm).unwrap();
    Multipole::default().respond(&cell, &Incidence { wavelength_nm: nm, theta_i: theta, phi_i: phi }).unwrap()
}

/// Error of fields and powers whose orders come from series, of which up to 3e-5 of each element is left out: 9.5e-5 and
/// 7.3e-5 are reached.
const SERIES: f64 = 1.1e-4;

/// Error of a campaign's field (relative L2): 2.1e-4 is reached, by elements of 0.04 µm and nodes.
const CAMPAIGN_FIELD: f64 = 2.3e-4;

/// Relative error of its reflected power: 1.9e-4 is reached.
const CAMPAIGN_POWER: f64 = 2e-4;

#[test]
fn far_fields_equal_the_plain_evaluation() {
    let [field, power] = plain_errors();
    assert!(field < SERIES && power < SERIES, "{field:e} {power:e}");
}

#[test]
fn campaigns_equal_converged_fields() {
    let found = converged_errors();
    let [field, power] = found.iter().fold([0.0; 2], |worst, (_, errors)| larger(worst, *errors));
    assert!(field < CAMPAIGN_FIELD && power < CAMPAIGN_POWER, "{found:?}");
}

#[test]
fn a_flat_barbule_reflects_what_its_crystal_does_into_each_order() {
    let mut seen = [0; 2];
    let waves = [(320.0, 0.3, 0.6), (500.0, 0.5, -0.4), (620.0, 0.0, 0.0)];
    let crystals = crystal_species().map(|species| (species, layer(species, 0.03), &waves[..]));
    for (species, crystal, waves) in crystals.chain([("sparse", sparse(0.03), &[SPARSE][..])]) {
        let section = flat(40.0, crystal);
        for &(nm, theta, phi) in waves {
            let exact = ideal(section.crystal.as_ref().unwrap(), nm, theta, phi);
            let found = fast(&section, FINE_ELEMENT_UM, nm, theta, phi, 3000);
            let total = exact.reflectance(phi);
            for (p, total) in total.into_iter().enumerate() {
                let all = found.radiated[p];
                assert!((all - total).abs() < 2e-3, "{species} {nm}: {all} {total}");
                let intensity = found.intensity(Polarization::BOTH[p]).unwrap();
                for order in &exact.orders {
                    // The lobe of an order that is not near the horizon, ±6°.
                    if order.phi_o.cos() < 0.4 {
                        continue;
                    }
                    let step = std::f64::consts::PI / 3000.0;
                    let lobe: f64 = found
                        .azimuths
                        .phi_o()
                        .iter()
                        .zip(&intensity)
                        .filter(|(phi_o, _)| (*phi_o - order.phi_o).abs() < 0.1)
                        .map(|(_, i)| i * step * theta.cos())
                        .sum();
                    let expected = order.reflectance(phi)[p];
                    seen[usize::from(order.m != 0)] += 1;
                    assert!(
                        (lobe - expected).abs() < 2e-3,
                        "{species} {nm} order {}: {lobe} {expected}",
                        order.m
                    );
                }
            }
        }
    }
    assert!(seen[0] >= 16 && seen[1] >= 2, "zeroth and other orders that were looked at: {seen:?}");
}

#[test]
fn moving_the_lattice_turns_the_phase_of_each_order() {
    let ((nm, theta, phi), moved) = (SPARSE, 0.137);
    let fields = |offset: f64| fast(&flat(40.0, sparse(offset)), FINE_ELEMENT_UM, nm, theta, phi, 3000);
    let (here, there) = (fields(0.0), fields(moved));
    let crystal = sparse(0.0);
    let orders = ideal(&crystal, nm, theta, phi).orders;
    assert_eq!(orders.len(), 2);
    for order in orders {
        let peak = here.azimuths.phi_o().iter().position(|phi_o| *phi_o > order.phi_o).unwrap();
        let turn = -std::f64::consts::TAU * f64::from(order.m) * moved / crystal.lattice.period_um;
        let (a, b) = (here.amplitudes[0][0][peak], there.amplitudes[0][0][peak]);
        assert!((b / a - Complex64::from_polar(1.0, turn)).norm() < 1e-3, "{}: {}", order.m, b / a);
    }
}

#[test]
fn a_turned_barbule_is_the_same_barbule_seen_from_elsewhere() {
    let (nm, theta, phi) = SPARSE;
    // A turn by a whole number of azimuths, from x towards z; the window runs in x.
    let (azimuths, shift) = (360, 23);
    let turn = std::f64::consts::PI * shift as f64 / azimuths as f64;
    let (sin, cos) = turn.sin_cos();
    let ends = |along: f64| vec![-10.0 * along, 0.0, 10.0 * along];
    let turned = under(Polyline { x_um: ends(cos), z_um: ends(sin) }, sparse(0.05));
    let here = fast(&flat(20.0, sparse(0.05)), FINE_ELEMENT_UM, nm, theta, phi, azimuths);
    let there = fast(&turned, FINE_ELEMENT_UM, nm, theta, phi - turn, azimuths);
    let largest = here.amplitudes[0][0].iter().map(|v| v.norm()).fold(0.0, f64::max);
    for p in 0..2 {
        for c in 0..2 {
            for n in shift..azimuths {
                let (a, b) = (here.amplitudes[p][c][n], there.amplitudes[p][c][n - shift]);
                assert!((a - b).norm() < 1e-6 * largest, "{p} {c} {n}: {a} {b}");
            }
        }
    }
}

#[test]
fn no_barbule_reflects_more_than_it_gets() {
    let worst = largest_reflected();
    assert!(worst.0 <= 1.0, "{worst:?}");
}

#[test]
fn half_the_regularity_gives_a_quarter_of_the_light() {
    let mut crystal = layer("magpie", 0.02);
    let whole = fast(&flat(20.0, crystal.clone()), 0.02, 420.0, 0.1, 0.3, 100);
    crystal.regularity = Some(barbule::structure::Regularity { x_um: vec![-1.0, 1.0], value: vec![0.5; 2] });
    let half = fast(&flat(20.0, crystal), 0.02, 420.0, 0.1, 0.3, 100);
    assert_eq!(whole.light, half.light);
    for p in 0..2 {
        assert!((half.radiated[p] / whole.radiated[p] - 0.25).abs() < 1e-12);
    }
}
