//! Arrays in and out.

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

/// Wavelengths that a function was given.
pub(crate) fn wavelengths(given: &Floats<'_>) -> Result<Wavelengths> {
    Wavelengths::new(flat(given)).map_err(|error| error.at("'wavelengths_nm'"))
}

/// Angles given in degrees, in radians.
pub(crate) fn radians(given: &Floats<'_>) -> Vec<f64> {
    given.as_array().iter().map(|angle| angle.to_radians()).collect()
}

/// Complex numbers of this shape.
pub(crate) fn complex<'py>(
    py: Python<'py>,
    values: Vec<Complex64>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<Complex64>>> {
    shaped(py, values, shape)
}
