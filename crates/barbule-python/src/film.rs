//! Planar multilayers.

use barbule::film::gradient::{Gradient, gradients};
use barbule::film::{Ensemble, FilmTables, ensemble, sweep};
use barbule::{Complex64, Error, Result, Stack, Wavelengths};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Floats, check_count, complex, radians, shaped, wavelengths};
use crate::error::OrRaise as _;
use crate::opening::Given;
use crate::spectrum::MOST_INSTANCES;
use crate::work::How;

/// Amplitudes and powers, `[angle, wavelength]`: r_s, r_p, t_s, t_p, R_s, R_p, T_s, T_p, A_s, A_p and the absorption in each layer
/// (`[layer, angle, wavelength]`), A_layer_s and A_layer_p. Of a stack whose thicknesses spread these are means over so many individuals,
/// and `std` is the standard deviation of the unpolarized reflectance.
#[pyfunction]
#[pyo3(signature = (stack, wavelengths_nm, angles_deg, instances, seed, media, threads, progress))]
#[allow(clippy::too_many_arguments)] // they have names in Python
pub(crate) fn film<'py>(
    py: Python<'py>,
    stack: &str,
    wavelengths_nm: Floats<'py>,
    angles_deg: Floats<'py>,
    instances: usize,
    seed: u64,
    media: Vec<(String, String)>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (stack, at, angles) = inputs(stack, &wavelengths_nm, &angles_deg, media).or_raise(py)?;
    check_count("instances", instances, MOST_INSTANCES).or_raise(py)?;
    let (found, std) = How::new(threads, progress).run(py, |progress| {
        stack.doubt().iter().for_each(|doubt| progress.doubt(doubt));
        if !stack.is_random() {
            let found = sweep(&stack, &at, &angles, progress)?;
            found.doubt(&stack).iter().for_each(|doubt| progress.doubt(doubt));
            return Ok((found, None));
        }
        let Ensemble { mean, unpolarized_std, .. } =
            ensemble(&stack, &at, &angles, instances, seed, progress)?;
        Ok((mean, Some(unpolarized_std)))
    })?;
    let all = PyDict::new(py);
    let shape = [angles.len(), at.len()];
    let layered = [stack.layers(), angles.len(), at.len()];
    for (name, tables) in ["s", "p"].into_iter().zip(found.polarization) {
        let FilmTables { r, t, reflected, transmitted, absorbed, absorbed_per_layer } = tables;
        all.set_item(format!("r_{name}"), complex(py, r, &shape)?)?;
        all.set_item(format!("t_{name}"), complex(py, t, &shape)?)?;
        all.set_item(format!("R_{name}"), shaped(py, reflected, &shape)?)?;
        all.set_item(format!("T_{name}"), shaped(py, transmitted, &shape)?)?;
        all.set_item(format!("A_{name}"), shaped(py, absorbed, &shape)?)?;
        all.set_item(format!("A_layer_{name}"), shaped(py, absorbed_per_layer, &layered)?)?;
    }
    if let Some(std) = std {
        all.set_item("std", shaped(py, std, &shape)?)?;
    }
    Ok(all)
}

/// Derivatives of the reflected amplitudes: by thickness `[angle, wavelength, layer]`, 1/nm, and by index `[angle, wavelength,
/// layer and exit]`, each for s and p.
type Gradients<'py> = [Bound<'py, PyArrayDyn<Complex64>>; 4];

/// See [`Gradients`]: s by thickness, s by index, p by thickness, p by index.
#[pyfunction]
#[pyo3(signature = (stack, wavelengths_nm, angles_deg, media, threads))]
pub(crate) fn film_gradients<'py>(
    py: Python<'py>,
    stack: &str,
    wavelengths_nm: Floats<'py>,
    angles_deg: Floats<'py>,
    media: Vec<(String, String)>,
    threads: Option<usize>,
) -> PyResult<Gradients<'py>> {
    let (stack, at, angles) = inputs(stack, &wavelengths_nm, &angles_deg, media).or_raise(py)?;
    if stack.is_random() {
        let message = "'gradients': derivatives are of one stack; leave out the spreads";
        return Err(Error::input(message)).or_raise(py);
    }
    let how = How::new(threads, None);
    let found = how.run(py, |progress| gradients(&stack, &at, &angles, progress))?;
    let (layers, cells) = (stack.layers(), angles.len() * at.len());
    // Found wavelength by wavelength; given angle by angle.
    let table = |polarization: usize, by_index: bool| {
        let depth = layers + usize::from(by_index);
        let mut values = Vec::with_capacity(cells * depth);
        for angle in 0..angles.len() {
            for column in &found {
                let Gradient { by_thickness, by_index: indices, .. } = &column[angle][polarization];
                values.extend_from_slice(if by_index { indices } else { by_thickness });
            }
        }
        complex(py, values, &[angles.len(), at.len(), depth])
    };
    Ok([table(0, false)?, table(0, true)?, table(1, false)?, table(1, true)?])
}

fn inputs(
    stack: &str,
    wavelengths_nm: &Floats<'_>,
    angles_deg: &Floats<'_>,
    media: Vec<(String, String)>,
) -> Result<(Stack, Wavelengths, Vec<f64>)> {
    let stack = Given { media, ..Given::default() }.stack(stack)?;
    let angles = radians(angles_deg);
    if angles.is_empty() {
        return Err(Error::input("'angles_deg' is empty; give at least one angle"));
    }
    Ok((stack, wavelengths(wavelengths_nm)?, angles))
}
