//! Colours of spectra, as the standard observer sees them.

use barbule::spectrum::Spectrum;
use barbule::spectrum::colour::{Illuminant, Observer, display, held, known_share, rgb_from_xyz};
use barbule::spectrum::difference;
use barbule::spectrum::look::COLOUR_NEEDS;
use barbule::{Error, Result};
use numpy::{PyArray1, PyArray2, PyArrayMethods as _, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays::{Floats, sampled};
use crate::error::OrRaise as _;

/// X, Y, Z `[row, 3]` (Y = 1 of a perfect white), linear sRGB `[row, 3]` and the bytes a screen shows `[row, 3]`.
type Colours<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<u8>>);

/// The colours of reflectances `[row, wavelength]` under an illuminant.
#[pyfunction]
#[pyo3(signature = (wavelengths_nm, reflectance, illuminant))]
pub(crate) fn xyz_of<'py>(
    py: Python<'py>,
    wavelengths_nm: Floats<'py>,
    reflectance: PyReadonlyArray2<'py, f64>,
    illuminant: &str,
) -> PyResult<Colours<'py>> {
    let at = sampled(&wavelengths_nm).or_raise(py)?;
    let observer = Observer::under(Illuminant::named(illuminant).or_raise(py)?);
    let rows = reflectance.as_array();
    let xyz = rows
        .rows()
        .into_iter()
        .map(|row| Ok(observer.xyz(&Spectrum::new(at.clone(), row.to_vec())?)))
        .collect::<Result<Vec<[f64; 3]>>>()
        .or_raise(py)?;
    let rgb: Vec<[f64; 3]> = xyz.iter().map(|xyz| rgb_from_xyz(*xyz)).collect();
    let shown: Vec<[u8; 3]> = rgb.iter().map(|rgb| display(*rgb)).collect();
    let shape = [xyz.len(), 3];
    Ok((
        PyArray1::from_vec(py, xyz.concat()).reshape(shape)?,
        PyArray1::from_vec(py, rgb.concat()).reshape(shape)?,
        PyArray1::from_vec(py, shown.concat()).reshape(shape)?,
    ))
}

/// What to say of colours of reflectances at these wavelengths, beyond which the end values hold; refuses those that are too little of what
/// the eye sees.
#[pyfunction]
pub(crate) fn colour_doubt(py: Python<'_>, wavelengths_nm: Floats<'_>) -> PyResult<Option<String>> {
    let at = sampled(&wavelengths_nm).or_raise(py)?;
    if known_share(&at) >= COLOUR_NEEDS {
        return Ok(held(&at));
    }
    let (first, last) = at.range_nm();
    let message = format!(
        "'wavelengths_nm': no colour: {first} to {last} nm are too little of what the eye sees; give wavelengths from 400 to 700 nm"
    );
    Err(Error::input(message)).or_raise(py)
}

/// CIEDE2000 of two colours X, Y, Z under the white of D65.
#[pyfunction]
pub(crate) fn delta_e_2000(py: Python<'_>, one: [f64; 3], other: [f64; 3]) -> PyResult<f64> {
    for (name, xyz) in [("one", one), ("other", other)] {
        if let Some(bad) = xyz.iter().find(|part| !part.is_finite()) {
            let message = format!("'{name}' holds {bad}; give finite X, Y and Z");
            return Err(Error::input(message)).or_raise(py);
        }
    }
    let white = barbule::spectrum::colour::xyz_from_rgb([1.0; 3]);
    Ok(difference::delta_e_2000(difference::lab(one, white), difference::lab(other, white)))
}
