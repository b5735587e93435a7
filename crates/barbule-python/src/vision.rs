//! What birds see.

use barbule::open::{self, Simulation};
use barbule::spectrum::Spectrum;
use barbule::vision::{Catches, Cone, Eye, Noise, Reference, Tetrahedral, View};
use barbule::{Error, Result};
use numpy::{PyArrayDyn, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays::{Floats, check_count, flat, incidences, sampled, shaped, wavelengths};
use crate::error::OrRaise as _;
use crate::opening::Given;
use crate::work::How;

/// Individuals of a structure, at most.
const MOST_INSTANCES: usize = 10_000;

/// A cone: its name, peak in nm, abundance, source, and its answers at 300, 301 … 830 nm.
type OfCone<'py> = (String, f64, f64, String, Bound<'py, PyArrayDyn<f64>>);

/// A thing that is seen: its name, wavelengths in nm, reflectance, and whether it was measured.
type OfThing<'py> = (String, Bound<'py, PyArrayDyn<f64>>, Bound<'py, PyArrayDyn<f64>>, bool);

/// What single cones catch `[row, cone]`, and double ones `[row]`.
type Caught<'py> = (Bound<'py, PyArrayDyn<f64>>, Bound<'py, PyArrayDyn<f64>>);

/// An eye: its name, Latin name, cones, double cones, Weber fractions (single, double) and sources.
type OfEye<'py> = (String, String, Vec<OfCone<'py>>, Option<OfCone<'py>>, [f64; 2], Vec<String>);

/// The names of the eyes that are built in.
#[pyfunction]
pub(crate) fn eye_names() -> Vec<&'static str> {
    open::eye_names().collect()
}

/// An eye by its name, or from a file.
#[pyfunction]
pub(crate) fn eye<'py>(py: Python<'py>, bird: &str) -> PyResult<OfEye<'py>> {
    let Eye { name, latin, sources, cones, double, weber, weber_double } = open::eye(bird).or_raise(py)?;
    let of = |cone: Cone| -> PyResult<OfCone<'py>> {
        let values = cone.sensitivity.values().to_vec();
        let count = values.len();
        Ok((cone.name, cone.peak_nm, cone.abundance, cone.source, shaped(py, values, &[count])?))
    };
    let cones = cones.into_iter().map(of).collect::<PyResult<_>>()?;
    Ok((name, latin, cones, double.map(of).transpose()?, [weber, weber_double], sources))
}

/// Catches of reflectances `[row, wavelength]` over those of white: `[row, cone]`, and of the double cones `[row]`, NaN without any.
#[pyfunction]
pub(crate) fn catches<'py>(
    py: Python<'py>,
    wavelengths_nm: Floats<'py>,
    reflectance: PyReadonlyArray2<'py, f64>,
    bird: &str,
    illuminant: &str,
) -> PyResult<Caught<'py>> {
    let at = sampled(&wavelengths_nm).or_raise(py)?;
    let view = open::eye(bird).and_then(|eye| View::new(eye, open::light(illuminant)?)).or_raise(py)?;
    let rows = reflectance.as_array();
    let found = rows
        .rows()
        .into_iter()
        .map(|row| view.catches(&Spectrum::new(at.clone(), row.to_vec())?))
        .collect::<Result<Vec<Catches>>>()
        .or_raise(py)?;
    let double = found.iter().map(|catches| catches.double.unwrap_or(f64::NAN)).collect();
    let cones = found.iter().flat_map(|catches| catches.cones.iter().copied()).collect();
    Ok((shaped(py, cones, &[found.len(), view.eye.cones.len()])?, shaped(py, double, &[found.len()])?))
}

/// ΔS of catches `[row, cone]`, `[row, row]`, NaN where a catch is not above 0; `is_rarest`: the Weber fraction is that of the rarest cones,
/// else of the last.
#[pyfunction]
pub(crate) fn jnd<'py>(
    py: Python<'py>,
    catches: PyReadonlyArray2<'py, f64>,
    ratio: Floats<'py>,
    weber: f64,
    is_rarest: bool,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let (rows, ratio) = (all(&catches), flat(&ratio));
    let is_positive = |value: &f64| value.is_finite() && *value > 0.0;
    if ratio.len() != catches.as_array().ncols() || !ratio.iter().all(is_positive) || !is_positive(&weber) {
        let message = format!(
            "'ratio' has {} numbers for {} cones; give one over 0 for each, and a 'weber' over 0",
            ratio.len(),
            catches.as_array().ncols()
        );
        return Err(Error::input(message)).or_raise(py);
    }
    let noise = Noise::new(&ratio, weber, if is_rarest { Reference::Rarest } else { Reference::Longest });
    let each = |one: &Catches| {
        rows.iter().map(|other| noise.delta_s(one, other).unwrap_or(f64::NAN)).collect::<Vec<_>>()
    };
    shaped(py, rows.iter().flat_map(each).collect(), &[rows.len(), rows.len()])
}

/// Places of catches `[row, 4]`: x, y, z, θ and φ in degrees, r and the part of the largest r, `[row, 7]`; NaN where there is none.
#[pyfunction]
pub(crate) fn tetrahedral<'py>(
    py: Python<'py>,
    catches: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let rows = all(&catches);
    let of = |catches: &Catches| match Tetrahedral::of(catches) {
        Some(Tetrahedral { xyz: [x, y, z], theta_deg, phi_deg, r, achieved, .. }) => {
            [x, y, z, theta_deg, phi_deg, r, achieved]
        }
        None => [f64::NAN; 7],
    };
    shaped(py, rows.iter().flat_map(of).collect(), &[rows.len(), 7])
}

fn all(catches: &PyReadonlyArray2<'_, f64>) -> Vec<Catches> {
    let rows = catches.as_array();
    rows.rows().into_iter().map(|row| Catches { cones: row.to_vec(), double: None }).collect()
}

/// The things of a text: a measured file's mean or samples, or a structure's mean reflectance.
#[pyfunction]
#[pyo3(signature = (text, each_sample, wavelengths_nm, angle_deg, instances, seed, media, threads, progress))]
pub(crate) fn things<'py>(
    py: Python<'py>,
    text: &str,
    each_sample: bool,
    wavelengths_nm: Floats<'py>,
    angle_deg: Floats<'py>,
    instances: usize,
    seed: u64,
    media: Vec<(String, String)>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Vec<OfThing<'py>>> {
    check_count("instances", instances, MOST_INSTANCES).or_raise(py)?;
    let simulation = Simulation {
        wavelengths: wavelengths(&wavelengths_nm).or_raise(py)?,
        angle: incidences("angle_deg", &angle_deg).or_raise(py)?[0],
        instances,
    };
    let opening = Given { media, seed: Some(seed), ..Given::default() }.opening().or_raise(py)?;
    let found = How::new(threads, progress)
        .run(py, |progress| open::things(text, each_sample, &simulation, &opening, progress))?;
    let of = |thing: open::Thing| -> PyResult<OfThing<'py>> {
        let (nm, values) = (thing.reflectance.wavelengths().nm(), thing.reflectance.values());
        let [at, values] = [nm, values].map(|numbers| shaped(py, numbers.to_vec(), &[nm.len()]));
        Ok((thing.name, at?, values?, thing.reading.is_some()))
    };
    found.into_iter().map(of).collect()
}
