//! The crystal solvers against what an independent program says: `treams`, by `scripts/reference-crystals.py`.
//! The example `crystal_checks` prints the table of `docs/theory/crystals.md`.

use barbule::solve::crystal::{CrystalSolver, Fdtd, Multipole, Rcwa};

use crate::measure::treams::{cases, is_at_450_nm, largest};

/// The crystals of touching rods and of air channels are where treams' expansions settle slowest: to 1e-8 and, in
/// ultraviolet light, 1e-7. Multipoles stay within what treams itself still changes.
#[test]
fn multipoles_give_what_treams_gives() {
    let solver = Multipole::default();
    let mut worst = 0f64;
    for case in cases() {
        let difference = case.difference(&solver.respond(&case.cell, &case.incidence).unwrap());
        let name = &case.cell_name;
        // Both expansions are cut where little is left: multipoles at 1e-9.
        assert!(difference < 1.5 * case.error + 1e-9, "{name} {:?}: {difference:e}", case.incidence);
        worst = worst.max(difference);
    }
    // Reached: 2.9e-8, by treams' truncation.
    assert!(worst < 3e-8, "{worst:e}");
}

/// Reached: 7e-3, and 2e-2 for air in keratin at 400 nm and θ = 60°, the strongest contrast; at 450 nm
/// twice the orders and slices leave half of it.
#[test]
fn fourier_modes_come_near_what_treams_gives() {
    let with = |orders, slices| Rcwa { orders, slices, estimate: false };
    for (cell, most) in largest(&with(10, 24), |_| true) {
        assert!(most < if cell == "square holes" { 2.5e-2 } else { 8e-3 }, "{cell}: {most:e}");
    }
    let (coarse, fine) = (largest(&with(10, 24), is_at_450_nm), largest(&with(20, 48), is_at_450_nm));
    for ((cell, coarse), fine) in coarse.iter().zip(fine.values()) {
        assert!(*fine < 0.6 * coarse, "{cell}: {coarse:e} {fine:e}");
    }
}

/// Reached: 8e-3 at 60 cells/µm and 2e-3 at 120.
#[test]
fn finite_differences_come_near_what_treams_gives() {
    let with = |cells_per_um| Fdtd { cells_per_um, estimate: false, ..Fdtd::default() };
    let (coarse, fine) = (largest(&with(60.0), is_at_450_nm), largest(&with(120.0), is_at_450_nm));
    for ((cell, coarse), fine) in coarse.iter().zip(fine.values()) {
        assert!(*coarse < 1e-2 && *fine < 0.5 * coarse, "{cell}: {coarse:e} {fine:e}");
    }
}
