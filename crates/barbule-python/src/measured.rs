//! What was measured, held against what is simulated; how sure simulated numbers are.

use barbule::campaign::spectrum::{Collect, SpectrumRequest, spectra_and_individuals};
use barbule::confidence::{Simulated, Uncertain, check_individuals, intervals as intervals_of};
use barbule::io::measured::{Scale, read_measurements};
use barbule::progress::Progress;
use barbule::spectrum::Spectrum;
use barbule::spectrum::comparison::Comparison;
use barbule::spectrum::look::Look;
use barbule::spectrum::peaks::Origin;
use barbule::structure::Structure;
use barbule::{Error, Result, open};
use numpy::PyArrayDyn;
use pyo3::prelude::*;

use crate::arrays::{Floats, check_count, flat, incidences, sampled, shaped, wavelengths};
use crate::error::OrRaise as _;
use crate::opening::Given;
use crate::spectrum::MOST_INSTANCES;
use crate::work::How;

/// An angle, the names of the samples, their wavelengths, the samples `[sample, wavelength]`, mean, and how the files were read.
type AtAngle<'py> = (
    Option<f64>,
    Vec<String>,
    Bound<'py, PyArrayDyn<f64>>,
    Bound<'py, PyArrayDyn<f64>>,
    Bound<'py, PyArrayDyn<f64>>,
    String,
);

/// Measurements by their angles.
#[pyfunction]
#[pyo3(signature = (places, column, is_percent))]
pub(crate) fn measured<'py>(
    py: Python<'py>,
    places: Vec<String>,
    column: Option<&str>,
    is_percent: Option<bool>,
) -> PyResult<Vec<AtAngle<'py>>> {
    let scale = is_percent.map(|percent| if percent { Scale::Percent } else { Scale::Fraction });
    let found = read_measurements(&places, column, scale).or_raise(py)?;
    let of = |at: &barbule::io::measured::AtAngle| {
        let (samples, mean) = (&at.measured.samples, &at.measured.mean);
        let waves = mean.wavelengths().len();
        let values = samples.iter().flat_map(|sample| sample.spectrum.values()).copied().collect();
        Ok((
            at.angle_deg,
            samples.iter().map(|sample| sample.name.clone()).collect(),
            shaped(py, mean.wavelengths().nm().to_vec(), &[waves])?,
            shaped(py, values, &[samples.len(), waves])?,
            shaped(py, mean.values().to_vec(), &[waves])?,
            at.measured.reading.clone(),
        ))
    };
    found.angles.iter().map(of).collect()
}

/// The comparison of a simulated mean and its individuals, `[individual, wavelength]`, with measured samples, `[sample, wavelength]`, as the
/// JSON of `barbule spectrum --measured`.
#[pyfunction]
#[pyo3(signature = (wavelengths_nm, mean, individuals, measured_nm, samples, peak_range_nm))]
pub(crate) fn compare(
    py: Python<'_>,
    wavelengths_nm: Floats<'_>,
    mean: Floats<'_>,
    individuals: Floats<'_>,
    measured_nm: Floats<'_>,
    samples: Floats<'_>,
    peak_range_nm: Option<[f64; 2]>,
) -> PyResult<String> {
    let curves = |nm: &Floats, values: &Floats| -> Result<Vec<Spectrum>> {
        let at = sampled(nm)?;
        flat(values).chunks(at.len()).map(|row| Spectrum::new(at.clone(), row.to_vec())).collect()
    };
    let found = || -> Result<String> {
        let [simulated, measured] = [curves(&wavelengths_nm, &individuals)?, curves(&measured_nm, &samples)?];
        let mean = curves(&wavelengths_nm, &mean)?.pop().ok_or_else(|| Error::input("'mean' is empty"))?;
        let first = measured.first().ok_or_else(|| Error::input("'samples' is empty; give at least one"))?;
        let at = first.wavelengths().clone();
        let of = |w: usize| measured.iter().map(|one| one.values()[w]).sum::<f64>() / measured.len() as f64;
        let measured_mean = Spectrum::new(at.clone(), (0..at.len()).map(of).collect())?;
        let comparison = Comparison::of(&mean, &measured_mean, peak_range_nm)?;
        serde_json::to_string(&comparison.with_individuals(&simulated, &measured))
            .map_err(|error| Error::machine(format!("the comparison cannot be written: {error}")))
    };
    found().or_raise(py)
}

/// How sure the numbers of a colour are, for each angle, as the JSON of `barbule spectrum --intervals`.
#[pyfunction]
#[pyo3(signature = (text, wavelengths_nm, theta_deg, phi_deg, instances, seed, uncertain, media, threads, progress))]
#[allow(clippy::too_many_arguments)] // they have names in Python
pub(crate) fn intervals(
    py: Python<'_>,
    text: &str,
    wavelengths_nm: Floats<'_>,
    theta_deg: Floats<'_>,
    phi_deg: Floats<'_>,
    instances: usize,
    seed: u64,
    uncertain: Vec<String>,
    media: Vec<(String, String)>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let opening = Given { media, ..Given::default() }.opening().or_raise(py)?;
    check_count("instances", instances, MOST_INSTANCES).or_raise(py)?;
    let at = wavelengths(&wavelengths_nm).or_raise(py)?;
    let [theta, phi] = [&theta_deg, &phi_deg].map(|angles| incidences("angles_deg", angles));
    let directions: Vec<(f64, f64)> = theta.or_raise(py)?.into_iter().zip(phi.or_raise(py)?).collect();
    let uncertain =
        uncertain.iter().map(|text| Uncertain::parse(text)).collect::<Result<Vec<_>>>().or_raise(py)?;
    How::new(threads, progress).run(py, |progress| {
        let structure = open::structure(text, &opening, progress)?;
        let instances = structure.count().map_or(instances, |given| given.min(instances));
        check_individuals(&structure, instances)?;
        let request = SpectrumRequest {
            wavelengths: at.clone(),
            instances,
            directions,
            seed,
            collect: Collect::Hemisphere,
            polarization: [0.5, 0.5],
        };
        let (spectra, individuals) = spectra_and_individuals(&structure, &request, progress)?;
        let means = spectra.mean.iter().map(|mean| Spectrum::new(at.clone(), mean.clone()));
        let angles: Vec<f64> =
            request.directions.iter().map(|(theta, phi)| theta.to_degrees() + phi.to_degrees()).collect();
        let looks = Look::series(&angles, &means.collect::<Result<Vec<_>>>()?, Origin::Computed, None);
        let of = |d: usize| (0..individuals.count()).map(|i| individuals.of(i, d).to_vec()).collect();
        let curves: Vec<Vec<Vec<f64>>> = (0..request.directions.len()).map(of).collect();
        let simulated = Simulated { at: &at, means: &spectra.mean, curves: &curves, looks: &looks };
        let simulate = |moved: Structure, progress: &dyn Progress| {
            Ok(spectra_and_individuals(&moved, &request, progress)?.0.mean)
        };
        let found = intervals_of(text, &opening, &simulate, seed, simulated, &uncertain, progress)?;
        serde_json::to_string(&found)
            .map_err(|error| Error::machine(format!("the intervals cannot be written: {error}")))
    })
}
