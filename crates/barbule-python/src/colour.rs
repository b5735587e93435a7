//! Colours of spectra, as the standard observer sees them.

use barbule::spectrum::Spectrum;
use barbule::spectrum::colour::{Illuminant, Observer, display, rgb_from_xyz};
use barbule::spectrum::difference;
use numpy::{PyArray1, PyArray2, PyArrayMethods as _, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays::{Floats, wavelengths};
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
    let at = wavelengths(&wavelengths_nm).or_raise(py)?;
    let observer = Observer::under(Illuminant::named(illuminant).or_raise(py)?);
    let rows = reflectance.as_array();
    let xyz = rows
        .rows()
        .into_iter()
        .map(|row| Ok(observer.xyz(&Spectrum::new(at.clone(), row.to_vec())?)))
        .collect::<barbule::Result<Vec<[f64; 3]>>>()
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

/// CIEDE2000 of two colours X, Y, Z under the white of D65.
#[pyfunction]
pub(crate) fn delta_e_2000(one: [f64; 3], other: [f64; 3]) -> f64 {
    let white = barbule::spectrum::colour::xyz_from_rgb([1.0; 3]);
    difference::delta_e_2000(difference::lab(one, white), difference::lab(other, white))
}
