//! From measured spectra to sizes.

use std::path::PathBuf;

use barbule::campaign::spectrum::Collect;
use barbule::characterize::WAVELENGTHS_NM;
use barbule::instrument::Instrument;
use barbule::inverse::{Level, Lighting, Open, Reading, Settings, Simulation};
use barbule::io::measured::read_measurements;
use barbule::spectrum::Spectrum;
use barbule::{Error, Result, Wavelengths, open};
use pyo3::prelude::*;

use crate::arrays::{Floats, check_count, flat, sampled};
use crate::error::OrRaise as _;
use crate::opening::Given;
use crate::work::How;

/// Individuals of a simulated spectrum, at most.
const MOST_INSTANCES: usize = 1000;

/// What was found, as the JSON of `barbule fit-structure`, and the file of the best solution. `reflectance` is `[angle, sample,
/// wavelength]`, and read only where there are no `files`.
#[pyfunction]
#[pyo3(signature = (files, wavelengths_nm, reflectance, angles_deg, model, stack, free, instrument, along, range_nm, column, fixed, offset, solutions, instances, seed, media, threads, progress))]
#[allow(clippy::too_many_arguments)] // they have names in Python
pub(crate) fn fit_structure(
    py: Python<'_>,
    files: Vec<PathBuf>,
    wavelengths_nm: Floats<'_>,
    reflectance: Floats<'_>,
    angles_deg: Floats<'_>,
    model: &str,
    stack: Option<&str>,
    free: Vec<String>,
    instrument: Option<&str>,
    along: bool,
    range_nm: Option<[f64; 2]>,
    column: Option<&str>,
    fixed: bool,
    offset: bool,
    solutions: usize,
    instances: usize,
    seed: u64,
    media: Vec<(String, String)>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, String)> {
    let opening = Given { media, ..Given::default() }.opening().or_raise(py)?;
    check_count("instances", instances, MOST_INSTANCES).or_raise(py)?;
    check_count("solutions", solutions, 50).or_raise(py)?;
    let instrument = instrument.map(Instrument::parse).transpose().or_raise(py)?;
    let free = free.iter().map(|text| Open::parse(text)).collect::<Result<Vec<_>>>().or_raise(py)?;
    let simulation = Simulation { instances, seed, collect: Collect::Hemisphere };
    let target = open::target(model, stack, free, simulation, &opening).or_raise(py)?;
    target.check_instrument(instrument.as_ref()).or_raise(py)?;
    let thickest_nm = target.thickest_nm().or_raise(py)?;
    let lighting = Lighting { instrument: instrument.as_ref(), along, thickest_nm };
    let readings = if files.is_empty() {
        let at = sampled(&wavelengths_nm).or_raise(py)?;
        let (values, angles) = (flat(&reflectance), flat(&angles_deg));
        given(&at, &values, &angles, lighting, range_nm)
    } else {
        let files: Vec<String> = files.iter().map(|file| file.to_string_lossy().into_owned()).collect();
        read_measurements(&files, column, None)
            .and_then(|measured| Reading::of(&measured, lighting, range_nm))
    };
    let readings = readings.or_raise(py)?;
    let settings = Settings { level: if fixed { Level::Fixed } else { Level::Free }, offset, solutions };
    How::new(threads, progress).run(py, |progress| {
        let outcome = target.fit(&readings, &settings, progress)?;
        outcome.fit.doubts.iter().for_each(|doubt| progress.doubt(doubt));
        Ok((outcome.document(&readings).to_string(), outcome.toml))
    })
}

/// Readings from arrays `[angle, sample, wavelength]`, of which as of files only wavelengths that can be simulated are kept.
fn given(
    at: &Wavelengths,
    values: &[f64],
    angles: &[f64],
    lighting: Lighting<'_>,
    range_nm: Option<[f64; 2]>,
) -> Result<Vec<Reading>> {
    let per_angle = values.len() / angles.len().max(1);
    if values.is_empty() || per_angle * angles.len() != values.len() || !per_angle.is_multiple_of(at.len()) {
        return Err(Error::input(format!(
            "'reflectance' holds {} numbers, which are not as many samples of {} wavelengths at each of {} angles",
            values.len(),
            at.len(),
            angles.len()
        )));
    }
    if let Some(bad) = angles.iter().find(|angle| angle.is_nan() || angle.abs() >= 90.0) {
        return Err(Error::input(format!("'angles_deg' holds {bad}; give degrees between -90 and 90")));
    }
    let all = at.nm();
    let kept: Vec<usize> = (0..all.len()).filter(|&i| WAVELENGTHS_NM.contains(&all[i])).collect();
    if kept.len() < 2 {
        let ((first, last), low, high) = (at.range_nm(), WAVELENGTHS_NM.start(), WAVELENGTHS_NM.end());
        return Err(Error::input(format!(
            "'wavelengths_nm': fewer than two of its wavelengths, {first} to {last} nm, lie within {low} to {high} nm; give them in nm"
        )));
    }
    let at = Wavelengths::new(kept.iter().map(|&i| all[i]).collect::<Vec<f64>>())?;
    let one = |(angle, values): (&f64, &[f64])| {
        let whole = values.chunks_exact(all.len());
        let rows: Vec<Vec<f64>> = whole.map(|row| kept.iter().map(|&i| row[i]).collect()).collect();
        let count = rows.len() as f64;
        let mean = (0..at.len()).map(|i| rows.iter().map(|row| row[i]).sum::<f64>() / count).collect();
        let samples = rows
            .iter()
            .map(|row| Spectrum::new(at.clone(), row.clone()))
            .collect::<Result<Vec<_>>>()
            .map_err(|error| error.at("'reflectance'"))?;
        let mean = Spectrum::new(at.clone(), mean)?;
        Reading::at(*angle, &mean, &samples, lighting, range_nm)
    };
    angles.iter().zip(values.chunks_exact(per_angle)).map(one).collect()
}
