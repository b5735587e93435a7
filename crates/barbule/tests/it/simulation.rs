//! The fast simulation over random species, variants, directions and wavelengths: energy, and its reference.
//! `target/release/examples/simulation_tables` prints what is held here.

use crate::measure::fields::larger;
use crate::measure::simulation::{
    ROUGHNESSES, converged_errors, largest_reflected, mirror_energy, plain_errors,
};

/// How far the mean of 50 mirrors is from keeping all light: 3.0e-3 is reached.
const MEAN_ENERGY: f64 = 3.2e-3;

#[test]
fn rough_mirrors_conserve_energy() {
    for row in ROUGHNESSES {
        let (tau, height, _, name) = row;
        let found = mirror_energy(row);
        assert!(found.worst_mean() < MEAN_ENERGY, "{name}: {}", found.worst_mean());
        // The steepest slopes of all, of the lattice species' tops, shade each other at 45° already.
        let bound = if tau < 1.5 && height > 0.2 { 0.025 } else { 0.02 };
        assert!(found.steep().iter().all(|v| (v - 1.0).abs() < bound), "{name}");
    }
}

#[test]
fn no_barbule_reflects_more_than_it_receives() {
    let [worst, _] = largest_reflected();
    assert!(worst.0 <= 1.01, "{worst:?}");
}

/// Error of double precision against the plain evaluation, rounding over thousands of points: 3.5e-11 is reached.
const PLAIN: f64 = 1e-10;

#[test]
fn double_precision_equals_the_plain_evaluation_for_random_barbules() {
    let [field, power] = plain_errors();
    assert!(field < PLAIN && power < PLAIN, "{field:e} {power:e}");
}

/// Error of a campaign's field (relative L2): 3.8e-4 is reached, of which what rays average is the largest part;
/// reflectance tables (3e-5) and nodes (8e-5) are smaller ones.
const CAMPAIGN_FIELD: f64 = 4e-4;

/// Relative error of its reflected power: 2.3e-4 is reached.
const CAMPAIGN_POWER: f64 = 2.5e-4;

#[test]
fn campaigns_equal_converged_fields_for_random_barbules() {
    let found = converged_errors();
    let [field, power] = found.iter().fold([0.0; 2], |worst, (_, errors)| larger(worst, *errors));
    assert!(field < CAMPAIGN_FIELD && power < CAMPAIGN_POWER, "{found:?}");
}
