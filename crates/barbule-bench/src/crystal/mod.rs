//! The crystal solvers' speed and accuracy in figures, from a sample of points.

pub mod balance;

use std::time::Duration;

use cpu_time::ProcessTime;

use barbule::progress::{Progress, Unobserved};
use barbule::solve::crystal::{Cell, CrystalResponse, CrystalSolver, Fdtd, Incidence, Multipole, Rcwa};
use barbule::structure::Lattice;
use barbule::{Error, Result};

/// Wavelengths of the sample, nm.
const WAVELENGTHS_NM: [f64; 4] = [400.0, 500.0, 600.0, 694.0];

/// θ_i and φ_i of the sample, degrees.
const ANGLES: [f64; 3] = [0.0, 30.0, 60.0];

/// cosθ_i of the sample for tables: the middles of four equal parts.
const TABLE_COS_THETA: [f64; 4] = [0.15, 0.4, 0.65, 0.9];

/// Wavelengths, θ_i and φ_i of a full table.
pub const TABLE: [usize; 3] = [50, 20, 50];

/// How many points are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// Every point with multipoles, a quarter with the Fourier modal method, four by finite differences.
    Usual,
    /// One point.
    Least,
}

impl Effort {
    /// Every how many points a solver is measured, and the first.
    fn steps(self) -> [(usize, usize); 3] {
        match self {
            // Steps that come to every direction, or to four of them, and to every wavelength.
            Self::Usual => [(0, 1), (0, 4), (0, 11)],
            Self::Least => [(13, 36); 3],
        }
    }
}

/// One solver at points (one wavelength, one direction, both polarizations).
#[derive(Debug, Clone)]
pub struct SolverFigures {
    /// What it is and how finely it computes.
    pub name: &'static str,
    /// How many points were measured.
    pub points: usize,
    /// CPU seconds per point, the mean.
    pub seconds: f64,
    /// These over the multipoles' at the same points.
    pub ratio: f64,
    /// The largest difference of an order's reflectance from the multipoles'.
    pub difference: f64,
    /// The largest |R + T + A − 1|.
    pub imbalance: f64,
}

/// What a crystal costs on one core, in CPU seconds, so that other work on the machine does not count.
#[derive(Debug, Clone)]
pub struct CrystalFigures {
    /// Multipoles, Fourier modal method, finite differences.
    pub solvers: Vec<SolverFigures>,
    /// Multipoles: one wavelength and direction of a table, both polarizations.
    pub table_point_seconds: f64,
}

impl CrystalFigures {
    /// CPU seconds of a full table.
    #[must_use]
    pub fn table_seconds(&self) -> f64 {
        self.table_point_seconds * TABLE.iter().product::<usize>() as f64
    }
}

/// Measures a crystal on one thread.
///
/// # Errors
/// A medium has no index at 400 to 694 nm, a solver fails, or the user cancelled.
pub fn measure(lattice: &Lattice, effort: Effort, progress: &dyn Progress) -> Result<CrystalFigures> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .map_err(|e| Error::machine(format!("no thread for the benchmark: {e}")))?;
    pool.install(|| sample(lattice, effort, progress))
}

fn sample(lattice: &Lattice, effort: Effort, progress: &dyn Progress) -> Result<CrystalFigures> {
    let cells = WAVELENGTHS_NM.map(|nm| Cell::new(lattice, nm)).into_iter().collect::<Result<Vec<_>>>()?;
    let directions = ANGLES.iter().flat_map(|&theta| ANGLES.iter().map(move |&phi| [theta, phi]));
    let points: Vec<(&Cell, Incidence)> = WAVELENGTHS_NM
        .iter()
        .zip(&cells)
        .flat_map(|(&wavelength_nm, cell)| {
            directions.clone().map(move |[theta, phi]| {
                let (theta_i, phi_i) = (theta.to_radians(), phi.to_radians());
                (cell, Incidence { wavelength_nm, theta_i, phi_i })
            })
        })
        .collect();
    let solvers: [(&'static str, &dyn CrystalSolver); 3] = [
        ("multipoles", &Multipole::default()),
        ("Fourier modes, 20 orders, 24 slices", &Rcwa { estimate: false, ..Rcwa::default() }),
        ("FDTD, 100 cells/µm", &Fdtd { estimate: false, ..Fdtd::default() }),
    ];
    let total: usize =
        effort.steps().iter().map(|&(first, step)| (points.len() - first).div_ceil(step)).sum();
    progress.begin("measuring", (total + WAVELENGTHS_NM.len()) as u64);
    let mut exact: Vec<(CrystalResponse, f64)> = Vec::new();
    let mut found = Vec::new();
    for ((name, solver), (first, step)) in solvers.iter().zip(effort.steps()) {
        let mut figures =
            SolverFigures { name, points: 0, seconds: 0.0, ratio: 0.0, difference: 0.0, imbalance: 0.0 };
        let mut multipole_seconds = 0.0;
        for (index, (cell, incidence)) in points.iter().enumerate().skip(first).step_by(step) {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let begun = ProcessTime::now();
            let response = solver.respond(cell, incidence)?;
            let seconds = begun.elapsed().as_secs_f64();
            progress.advance(1);
            figures.points += 1;
            figures.seconds += seconds;
            figures.imbalance = figures.imbalance.max(response.imbalance(incidence.phi_i));
            if found.is_empty() {
                exact.push((response, seconds));
                multipole_seconds += seconds;
            } else {
                // With the least effort the multipoles' only point is everyone's.
                let (reference, seconds) = &exact[if exact.len() == 1 { 0 } else { index }];
                multipole_seconds += seconds;
                figures.difference = figures.difference.max(response.distance(reference, incidence.phi_i));
            }
        }
        figures.ratio = figures.seconds / multipole_seconds;
        figures.seconds /= figures.points as f64;
        found.push(figures);
    }
    let table_point_seconds = table_point(&cells, effort, progress)?;
    Ok(CrystalFigures { solvers: found, table_point_seconds })
}

/// CPU seconds of one wavelength and direction of a table.
fn table_point(cells: &[Cell], effort: Effort, progress: &dyn Progress) -> Result<f64> {
    let azimuths = TABLE[2];
    let phi_i: Vec<f64> = (1..=azimuths).map(|i| (i as f64 / azimuths as f64).acos()).collect();
    let cosines = if effort == Effort::Least { &TABLE_COS_THETA[2..3] } else { &TABLE_COS_THETA };
    let mut spent = Duration::ZERO;
    for (cell, &nm) in cells.iter().zip(&WAVELENGTHS_NM) {
        for cosine in cosines {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let begun = ProcessTime::now();
            std::hint::black_box(Multipole::default().respond_to_azimuths(
                cell,
                nm,
                cosine.acos(),
                &phi_i,
                &Unobserved,
            )?);
            spent += begun.elapsed();
        }
        progress.advance(1);
    }
    Ok(spent.as_secs_f64() / (cells.len() * cosines.len() * azimuths) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::material::Library;
    use barbule::progress::Unobserved;
    use barbule::structure::SpeciesModel;

    #[test]
    fn one_point_of_each_solver_agrees() {
        let lattice = SpeciesModel::builtin("mallard", None, Library::builtin()).unwrap().lattice().unwrap();
        let figures = measure(&lattice, Effort::Least, &Unobserved).unwrap();
        let [multipole, modes, fdtd] = &figures.solvers[..] else { panic!("three solvers") };
        assert!(multipole.imbalance < 1e-12 && modes.imbalance < 1e-11 && fdtd.imbalance < 1e-3);
        assert!(modes.difference < 1e-3 && fdtd.difference < 5e-3, "{figures:?}");
        assert!(multipole.ratio == 1.0 && figures.table_point_seconds > 0.0, "{figures:?}");
    }
}
