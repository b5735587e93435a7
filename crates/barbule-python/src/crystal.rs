//! Photonic crystals as infinite lattices.

use barbule::open;
use barbule::progress::Progress;
use barbule::solve::crystal::fdtd::Fdtd;
use barbule::solve::crystal::multipole::Multipole;
use barbule::solve::crystal::rcwa::Rcwa;
use barbule::solve::crystal::{CrystalSolver, sweep};
use barbule::{Error, Result};
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use crate::arrays::{Floats, incidences, shaped, wavelengths};
use crate::error::OrRaise as _;
use crate::opening::Given;
use crate::work::How;

/// Reflectance of all orders, `[phi_i, wavelength, polarization]`.
#[pyfunction]
#[pyo3(signature = (text, wavelengths_nm, theta_deg, phi_deg, solver, media, threads, progress))]
#[allow(clippy::too_many_arguments)] // they have names in Python
pub(crate) fn crystal<'py>(
    py: Python<'py>,
    text: &str,
    wavelengths_nm: Floats<'py>,
    theta_deg: f64,
    phi_deg: Floats<'py>,
    solver: &str,
    media: Vec<(String, String)>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let opening = Given { media, ..Given::default() }.opening().or_raise(py)?;
    let solver = solver_of(solver).or_raise(py)?;
    let at = wavelengths(&wavelengths_nm).or_raise(py)?;
    let phi = incidences("phi_deg", &phi_deg).or_raise(py)?;
    let found = How::new(threads, progress).run(py, |progress: &dyn Progress| {
        let lattice = open::lattice(text, &opening, progress)?;
        sweep(&*solver, &lattice, at.nm(), theta_deg.to_radians(), &phi, progress)
    })?;
    shaped(py, found.concat(), &[phi.len(), at.len(), 2])
}

fn solver_of(name: &str) -> Result<Box<dyn CrystalSolver + Send>> {
    match name {
        "multipole" => Ok(Box::new(Multipole::default())),
        "rcwa" => Ok(Box::new(Rcwa::default())),
        "fdtd" => Ok(Box::new(Fdtd::default())),
        _ => Err(Error::input(format!("'solver' is '{name}'; known are multipole, rcwa and fdtd"))),
    }
}
