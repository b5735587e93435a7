//! The interface that all solvers share, and sweeps with any of them.

use rayon::prelude::*;

use super::{Cell, CrystalResponse, Incidence};
use crate::progress::Progress;
use crate::structure::Lattice;
use crate::{Error, Result};

/// Solves photonic crystals.
pub trait CrystalSolver: Sync {
    /// The response of a cell to one plane wave in both polarizations.
    ///
    /// # Errors
    /// A wave at or past grazing or of no wavelength, a cell that this solver cannot do, or a computation that did not
    /// settle.
    fn respond(&self, cell: &Cell, incidence: &Incidence) -> Result<CrystalResponse>;

    /// The responses to waves of one wavelength and one θ_i (rad) from azimuths `phi_i` (rad), which may share work;
    /// `progress` is asked before each whether to go on.
    ///
    /// # Errors
    /// As [`Self::respond`], or the user cancelled.
    fn respond_to_azimuths(
        &self,
        cell: &Cell,
        wavelength_nm: f64,
        theta_i: f64,
        phi_i: &[f64],
        progress: &dyn Progress,
    ) -> Result<Vec<CrystalResponse>> {
        let one = |&phi_i: &f64| {
            unless_cancelled(progress)?;
            self.respond(cell, &Incidence { wavelength_nm, theta_i, phi_i })
        };
        phi_i.iter().map(one).collect()
    }
}

/// An error once the user cancelled.
pub(super) fn unless_cancelled(progress: &dyn Progress) -> Result<()> {
    if progress.is_cancelled() { Err(Error::interrupted()) } else { Ok(()) }
}

/// Reflectance of all orders by polarization, `[phi_i][wavelength]`, wavelengths in parallel.
///
/// # Errors
/// As [`Cell::new`] and [`CrystalSolver::respond`], or the user cancelled.
pub fn sweep(
    solver: &dyn CrystalSolver,
    lattice: &Lattice,
    wavelengths_nm: &[f64],
    theta_i: f64,
    phi_i: &[f64],
    progress: &dyn Progress,
) -> Result<Vec<[f64; 2]>> {
    progress.begin("solving", wavelengths_nm.len() as u64);
    let columns = wavelengths_nm
        .par_iter()
        .with_max_len(1)
        .map(|&nm| {
            let responses =
                solver.respond_to_azimuths(&Cell::new(lattice, nm)?, nm, theta_i, phi_i, progress)?;
            progress.advance(1);
            Ok(responses.iter().zip(phi_i).map(|(r, &phi)| r.reflectance(phi)).collect::<Vec<_>>())
        })
        .collect::<Result<Vec<_>>>()?;
    Ok((0..phi_i.len()).flat_map(|phi| columns.iter().map(move |column| column[phi])).collect())
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::material::Library;
    use crate::solve::crystal::Rcwa;
    use crate::structure::SpeciesModel;

    /// Stops after so many questions.
    struct Impatient(AtomicUsize);

    impl Progress for Impatient {
        fn begin(&self, _: &str, _: u64) {}
        fn advance(&self, _: u64) {}
        fn is_cancelled(&self) -> bool {
            self.0.fetch_add(1, Ordering::Relaxed) >= 3
        }
    }

    #[test]
    fn a_sweep_stops_between_two_azimuths() {
        let lattice = SpeciesModel::builtin("mallard", None, Library::builtin()).unwrap().lattice().unwrap();
        let (user, solver) = (Impatient(AtomicUsize::new(0)), Rcwa { orders: 2, slices: 2, estimate: false });
        let phi_i: Vec<f64> = (0..100).map(|i| 0.01 * f64::from(i)).collect();
        let error = sweep(&solver, &lattice, &[500.0], 0.0, &phi_i, &user).unwrap_err();
        assert!(error.is_interrupted(), "{error}");
        assert_eq!(user.0.load(Ordering::Relaxed), 4);
    }
}
