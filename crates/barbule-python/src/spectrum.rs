//! Reflectance spectra of structures.

use barbule::Error;
use barbule::campaign::spectrum::{
    Collect, Individuals, Mount, ReadingRequest, Spectra, SpectrumRequest, readings_and_individuals,
    spectra_and_individuals,
};
use barbule::instrument::Instrument;
use barbule::reading;
use barbule::spectrum::angle_law::{AngleLaw, Interval};
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use crate::arrays::{Floats, check_count, incidences, radians, shaped, wavelengths};
use crate::error::OrRaise as _;
use crate::material::Material;
use crate::structure::Structure;
use crate::work::How;

/// Individuals of a spectrum, at most.
pub(crate) const MOST_INSTANCES: usize = 10_000;

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
    arrays(py, &found, &individuals, request.wavelengths.len())
}

/// What an instrument reads of a structure at each angle, as [`spectra`]; `tilt_deg` are the standard deviations of slopes and turns.
#[pyfunction]
#[pyo3(signature = (structure, wavelengths_nm, angles_deg, instrument, along, turn_deg, tilt_deg, instances, seed, polarization, threads, progress))]
#[allow(clippy::too_many_arguments)] // they have names in Python
pub(crate) fn readings<'py>(
    py: Python<'py>,
    structure: &Structure,
    wavelengths_nm: Floats<'py>,
    angles_deg: Floats<'py>,
    instrument: &str,
    along: bool,
    turn_deg: f64,
    tilt_deg: [f64; 2],
    instances: usize,
    seed: u64,
    polarization: [f64; 2],
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Found<'py>> {
    check_count("instances", instances, MOST_INSTANCES).or_raise(py)?;
    let request = ReadingRequest {
        wavelengths: wavelengths(&wavelengths_nm).or_raise(py)?,
        mounts: mounts(&angles_deg, instrument, along, turn_deg, tilt_deg).or_raise(py)?,
        instances: structure.inner.count().map_or(instances, |given| given.min(instances)),
        seed,
        polarization,
    };
    let (found, individuals) = How::new(threads, progress)
        .run(py, |progress| readings_and_individuals(&structure.inner, &request, progress))?;
    arrays(py, &found, &individuals, request.wavelengths.len())
}

/// What an instrument reads of a material's smooth mean, `[angle, wavelength]`.
#[pyfunction]
#[pyo3(signature = (material, wavelengths_nm, angles_deg, instrument, along, turn_deg, tilt_deg, threads, progress))]
#[allow(clippy::too_many_arguments)] // they have names in Python
pub(crate) fn material_readings<'py>(
    py: Python<'py>,
    material: &Material,
    wavelengths_nm: Floats<'py>,
    angles_deg: Floats<'py>,
    instrument: &str,
    along: bool,
    turn_deg: f64,
    tilt_deg: [f64; 2],
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let at = wavelengths(&wavelengths_nm).or_raise(py)?;
    let mounts = mounts(&angles_deg, instrument, along, turn_deg, tilt_deg).or_raise(py)?;
    let found = How::new(threads, progress)
        .run(py, |progress| reading::of_material(&material.material, &at, &mounts, None, progress))?;
    shaped(py, found.concat(), &[mounts.len(), at.len()])
}

fn mounts(
    angles_deg: &Floats<'_>,
    instrument: &str,
    along: bool,
    turn_deg: f64,
    tilt_deg: [f64; 2],
) -> barbule::Result<Vec<Mount>> {
    let instrument = Instrument::parse(instrument)?;
    if !turn_deg.is_finite() || !tilt_deg.iter().all(|tilt| (0.0..=30.0).contains(tilt)) {
        let message = format!(
            "'turn_deg' {turn_deg}, 'tilt_deg' {tilt_deg:?}: give a finite turn and tilts from 0 to 30 degrees"
        );
        return Err(Error::input(message));
    }
    let mount = |turned| Mount {
        instrument,
        turned,
        along,
        about_normal: turn_deg.to_radians(),
        tilt: tilt_deg.map(f64::to_radians),
        vane: None,
    };
    Ok(incidences("angles_deg", angles_deg)?.into_iter().map(mount).collect())
}

/// A value with the ends of its interval; the upper one may be missing.
type Ends = (f64, f64, Option<f64>);

/// λ₀ in nm, n, and the RMSE of the law of layers; a in nm, b in nm per degree, and the RMSE of the straight line.
#[pyfunction]
pub(crate) fn angle_law(
    py: Python<'_>,
    angles_deg: Floats<'_>,
    peaks_nm: Vec<f64>,
) -> PyResult<(Ends, Option<Ends>, f64, Ends, Ends, f64)> {
    let angles = radians(&angles_deg);
    if angles.len() != peaks_nm.len() {
        let message = format!("{} angles and {} peaks; give one for each", angles.len(), peaks_nm.len());
        return Err(Error::input(message)).or_raise(py);
    }
    let peaks: Vec<(f64, f64)> = angles.into_iter().zip(peaks_nm).collect();
    let law = AngleLaw::fit(&peaks).or_raise(py)?;
    let ends = |one: Interval| (one.value, one.low, one.high);
    let line = law.line;
    let index = law.index.map(ends);
    Ok((ends(law.normal_nm), index, law.rmse_nm, ends(line.a_nm), ends(line.b_nm_per_deg), line.rmse_nm))
}

fn arrays<'py>(
    py: Python<'py>,
    found: &Spectra,
    individuals: &Individuals,
    waves: usize,
) -> PyResult<Found<'py>> {
    let count = found.mean.len();
    let rows = |rows: &[Vec<f64>]| shaped(py, rows.concat(), &[count, waves]);
    let each = (0..individuals.count())
        .flat_map(|instance| {
            (0..count).flat_map(move |direction| individuals.of(instance, direction).iter().copied())
        })
        .collect();
    Ok((
        rows(&found.mean)?,
        rows(&found.std)?,
        shaped(py, each, &[individuals.count(), count, waves])?,
        shaped(py, found.flagged().concat(), &[count, waves])?,
    ))
}
