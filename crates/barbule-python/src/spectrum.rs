//! Reflectance spectra of structures.

use barbule::Error;
use barbule::campaign::spectrum::{Collect, SpectrumRequest, spectra_and_individuals};
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use crate::arrays::{Floats, check_count, incidences, shaped, wavelengths};
use crate::error::OrRaise as _;
use crate::structure::Structure;
use crate::work::How;

/// Individuals of a spectrum, at most.
const MOST_INSTANCES: usize = 10_000;

/// Reflected fractions: mean and standard deviation `[direction, wavelength]`, individuals `[instance, direction, wavelength]`, and
/// whether the simulation is off there, `[direction, wavelength]`.
type Found<'py> = (
    Bound<'py, PyArrayDyn<f64>>,
    Bound<'py, PyArrayDyn<f64>>,
    Bound<'py, PyArrayDyn<f64>>,
    Bound<'py, PyArrayDyn<bool>>,
);

/// The spectra of light from `theta_deg` (along) and `phi_deg` (across), pairwise.
#[pyfunction]
#[pyo3(signature = (structure, wavelengths_nm, theta_deg, phi_deg, instances, seed, cone_deg, polarization, threads, progress))]
#[allow(clippy::too_many_arguments)] // they have names in Python
pub(crate) fn spectra<'py>(
    py: Python<'py>,
    structure: &Structure,
    wavelengths_nm: Floats<'py>,
    theta_deg: Floats<'py>,
    phi_deg: Floats<'py>,
    instances: usize,
    seed: u64,
    cone_deg: Option<f64>,
    polarization: [f64; 2],
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Found<'py>> {
    let at = wavelengths(&wavelengths_nm).or_raise(py)?;
    let [theta, phi] = [&theta_deg, &phi_deg].map(|angles| incidences("angles_deg", angles));
    let directions: Vec<(f64, f64)> = theta.or_raise(py)?.into_iter().zip(phi.or_raise(py)?).collect();
    check_count("instances", instances, MOST_INSTANCES).or_raise(py)?;
    if let Some(bad) = cone_deg.filter(|cone| !(*cone > 0.0 && *cone <= 90.0)) {
        let message = format!("'cone_deg' is {bad}; give degrees over 0 and up to 90");
        return Err(Error::input(message)).or_raise(py);
    }
    let request = SpectrumRequest {
        wavelengths: at,
        directions,
        instances: structure.inner.count().map_or(instances, |given| given.min(instances)),
        seed,
        collect: cone_deg.map_or(Collect::Hemisphere, |cone| Collect::Cone(cone.to_radians())),
        polarization,
    };
    let (found, individuals) = How::new(threads, progress)
        .run(py, |progress| spectra_and_individuals(&structure.inner, &request, progress))?;
    let (count, waves) = (request.directions.len(), request.wavelengths.len());
    let rows = |rows: &[Vec<f64>]| shaped(py, rows.concat(), &[count, waves]);
    let each = (0..individuals.count())
        .flat_map(|instance| {
            (0..count).flat_map({
                let individuals = &individuals;
                move |direction| individuals.of(instance, direction).iter().copied()
            })
        })
        .collect();
    Ok((
        rows(&found.mean)?,
        rows(&found.std)?,
        shaped(py, each, &[individuals.count(), count, waves])?,
        shaped(py, found.flagged().concat(), &[count, waves])?,
    ))
}
