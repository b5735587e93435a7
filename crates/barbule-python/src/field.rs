//! Far fields of sections, by formulas or full waves.

use barbule::progress::Progress;
use barbule::scattering::far_field::{Azimuths, Polarization, Window};
use barbule::solve::far_fields::{ELEMENTS, Illuminations, Scattered, Settings};
use barbule::solve::method;
use barbule::{Complex64, Error, Result, clock};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Floats, check_count, complex, incidences, shaped, wavelengths};
use crate::error::OrRaise as _;
use crate::structure::Section;
use crate::work::How;

/// Outgoing azimuths, at most.
const MOST_AZIMUTHS: usize = 100_000;

/// The far fields of light of each wavelength, inclination and azimuth: `amplitude` `[wavelength, theta_i, phi_i, polarization,
/// component, phi_o]`, `intensity` and `reflected` of both polarizations, and the azimuths `phi_o` in degrees.
#[pyfunction]
#[pyo3(signature = (section, wavelengths_nm, theta_deg, phi_deg, azimuths, window, solver, elements_per_wavelength, memory_bytes, threads, progress))]
#[allow(clippy::too_many_arguments)] // they have names in Python
pub(crate) fn far_fields<'py>(
    py: Python<'py>,
    section: &Section,
    wavelengths_nm: Floats<'py>,
    theta_deg: Floats<'py>,
    phi_deg: Floats<'py>,
    azimuths: usize,
    window: &str,
    solver: &str,
    elements_per_wavelength: f64,
    memory_bytes: u64,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    check_count("azimuths", azimuths, MOST_AZIMUTHS).or_raise(py)?;
    if !ELEMENTS.contains(&elements_per_wavelength) {
        let (least, most) = (ELEMENTS.start(), ELEMENTS.end());
        let message = format!(
            "'elements_per_wavelength' is {elements_per_wavelength}; give a number from {least} to {most}"
        );
        return Err(Error::input(message)).or_raise(py);
    }
    let light = Illuminations {
        wavelengths_nm: wavelengths(&wavelengths_nm).or_raise(py)?.nm().to_vec(),
        theta_i: incidences("theta_deg", &theta_deg).or_raise(py)?,
        phi_i: incidences("phi_deg", &phi_deg).or_raise(py)?,
        window: window_of(window).or_raise(py)?,
    };
    let settings = Settings { elements_per_wavelength, memory_bytes, clock: clock::system };
    let found = How::new(threads, progress)
        .run(py, |progress| solve(section, solver, &settings, &light, azimuths, progress))?;
    let shape = light.shape();
    let Some(first) = found.first() else {
        return Err(Error::input("no light: give at least one wavelength, inclination and azimuth"))
            .or_raise(py);
    };
    let count = first.far.azimuths.phi_o().len();
    let values = PyDict::new(py);
    let fields: Vec<Complex64> =
        found.iter().flat_map(|one| one.far.amplitudes.iter().flatten().flatten().copied()).collect();
    values.set_item("amplitude", complex(py, fields, &[&shape[..], &[2, 2, count]].concat())?)?;
    let widths = found.iter().flat_map(|one| Polarization::BOTH.map(|p| one.far.per_radian(p)));
    values.set_item(
        "intensity",
        shaped(py, widths.flatten().collect(), &[&shape[..], &[2, count]].concat())?,
    )?;
    let reflected = found.iter().flat_map(|one| one.reflected.unwrap_or([f64::NAN; 2]));
    values.set_item("reflected", shaped(py, reflected.collect(), &[&shape[..], &[2]].concat())?)?;
    let phi_o: Vec<f64> = first.far.azimuths.phi_o().iter().map(|phi| phi.to_degrees()).collect();
    values.set_item("phi_o", shaped(py, phi_o, &[count])?)?;
    let is_circle = matches!(first.far.azimuths, Azimuths::FullCircle(_));
    values.set_item("is_circle", is_circle)?;
    if let Some(exact) = found.iter().map(|one| one.exact).collect::<Option<Vec<_>>>() {
        for (name, of) in [
            ("scattered_um", exact.iter().map(|e| e.scattered_um).collect::<Vec<_>>()),
            ("absorbed_um", exact.iter().map(|e| e.absorbed_um).collect()),
        ] {
            values.set_item(name, shaped(py, of.concat(), &[&shape[..], &[2]].concat())?)?;
        }
    }
    Ok(values)
}

fn window_of(name: &str) -> Result<Window> {
    match name {
        "gaussian" => Ok(Window::Gaussian),
        "beam" => Ok(Window::Beam),
        "none" => Ok(Window::PlaneWave),
        _ => Err(Error::input(format!("'window' is '{name}'; give gaussian, beam or none"))),
    }
}

fn solve(
    section: &Section,
    solver: &str,
    settings: &Settings,
    light: &Illuminations,
    azimuths: usize,
    progress: &dyn Progress,
) -> Result<Vec<Scattered>> {
    let Some(method) = method(solver) else {
        let known: Vec<&str> = barbule::solve::METHODS.iter().map(|method| method.name).collect();
        return Err(Error::input(format!("there is no 'solver' '{solver}'; known are {}", known.join(", "))));
    };
    let solver = (method.solver)(settings);
    let prepared = solver.prepare(&section.inner)?;
    for change in prepared.changes() {
        progress.doubt(change);
    }
    let cost = prepared.cost(light, azimuths, rayon::current_num_threads(), progress)?;
    if cost.bytes > settings.memory_bytes {
        return Err(Error::input(format!(
            "{}s need {:.2} GB of memory, but {:.2} GB are allowed; give {}, or raise 'memory_bytes'",
            method.noun,
            cost.bytes as f64 / 1e9,
            settings.memory_bytes as f64 / 1e9,
            method.smaller
        )));
    }
    prepared.scatter(light, azimuths, progress)
}
