//! Arrays in and out.

use barbule::characterize::outside_wavelengths;
use barbule::{Error, Result, Wavelengths};
use num_complex::Complex64;
use numpy::ndarray::{ArrayD, IxDyn};
use numpy::{AllowTypeChange, Element, IntoPyArray as _, PyArrayDyn, PyArrayLikeDyn};
use pyo3::prelude::*;

use crate::error::OrRaise as _;

/// Numbers of any type, shape and stride, lists among them, read as 64-bit floats.
pub(crate) type Floats<'py> = PyArrayLikeDyn<'py, f64, AllowTypeChange>;

/// All numbers in the order of C.
pub(crate) fn flat<T: Element + Copy>(array: &PyArrayLikeDyn<'_, T, AllowTypeChange>) -> Vec<T> {
    array.as_array().iter().copied().collect()
}

/// An array of this shape.
pub(crate) fn shaped<'py, T: Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let array = ArrayD::from_shape_vec(IxDyn(shape), values);
    let array = array.map_err(|error| Error::machine(format!("an array does not fit its shape: {error}")));
    Ok(array.or_raise(py)?.into_pyarray(py))
}

/// Wavelengths at which something is simulated: those of the command line.
pub(crate) fn wavelengths(given: &Floats<'_>) -> Result<Wavelengths> {
    let found = sampled(given)?;
    check_simulated(found.nm())?;
    Ok(found)
}

/// Wavelengths of data, wherever they lie.
pub(crate) fn sampled(given: &Floats<'_>) -> Result<Wavelengths> {
    Wavelengths::new(flat(given)).map_err(|error| error.at("'wavelengths_nm'"))
}

/// Refuses wavelengths, nm, at which nothing can be simulated.
pub(crate) fn check_simulated(nm: &[f64]) -> Result<()> {
    let outside = nm.iter().find_map(|nm| outside_wavelengths(*nm));
    outside.map_or(Ok(()), |outside| Err(Error::input(format!("'wavelengths_nm': {outside}"))))
}

/// Angles given in degrees, in radians.
pub(crate) fn radians(given: &Floats<'_>) -> Vec<f64> {
    given.as_array().iter().map(|angle| angle.to_radians()).collect()
}

/// Angles of light from the normal given in degrees, in radians: at least one, all short of grazing.
pub(crate) fn incidences(name: &str, given: &Floats<'_>) -> Result<Vec<f64>> {
    let found = radians(given);
    if found.is_empty() {
        return Err(Error::input(format!("'{name}' is empty; give at least one angle")));
    }
    let bad = given.as_array().iter().copied().find(|angle| !(0.0..90.0).contains(&angle.abs()));
    bad.map_or(Ok(found), |bad| {
        Err(Error::input(format!("'{name}' holds {bad}; give degrees between -90 and 90")))
    })
}

/// Refuses a whole number that is not within 1 and `most`.
pub(crate) fn check_count(name: &str, count: usize, most: usize) -> Result<()> {
    if (1..=most).contains(&count) {
        return Ok(());
    }
    Err(Error::input(format!("'{name}' is {count}; give a number from 1 to {most}")))
}

/// Complex numbers of this shape.
pub(crate) fn complex<'py>(
    py: Python<'py>,
    values: Vec<Complex64>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<Complex64>>> {
    shaped(py, values, shape)
}
