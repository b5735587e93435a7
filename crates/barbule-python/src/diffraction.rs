//! Diffraction by heights.

use std::path::PathBuf;

use barbule::io::{HeightsOptions, read_heights};
use barbule::scattering::grating::{Coherence, Setup};
use barbule::solve::diffraction::spectrum;
use barbule::structure::{Heightfield, SAMPLES};
use barbule::{DVec3, Error, Result};
use numpy::{PyArray1, PyArray2, PyArrayMethods as _, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays::{Floats, wavelengths};
use crate::batch::is_unit;
use crate::error::OrRaise as _;
use crate::work::How;

/// A direction; refuses what is no unit vector.
fn direction(name: &str, given: [f64; 3]) -> Result<DVec3> {
    let found = DVec3::from_array(given);
    if is_unit(found) {
        return Ok(found);
    }
    let ([x, y, z], length) = (given, found.length());
    Err(Error::input(format!("'{name}' is ({x}, {y}, {z}), of length {length:.3}; give a unit vector")))
}

/// A measured or made patch of heights.
#[pyclass(frozen, module = "barbule._native")]
pub(crate) struct Heights {
    inner: Heightfield,
}

#[pymethods]
impl Heights {
    /// Heights in µm, `[row along y, column along x]`, over a patch of these sides, µm.
    #[staticmethod]
    fn of(py: Python<'_>, height_um: PyReadonlyArray2<'_, f64>, size_um: [f64; 2]) -> PyResult<Self> {
        let view = height_um.as_array();
        let cells = [view.ncols(), view.nrows()];
        let inner = Heightfield::new(cells, size_um, view.iter().copied().collect()).or_raise(py)?;
        Ok(Self { inner })
    }

    /// A file of heights.
    #[staticmethod]
    #[pyo3(signature = (path, pitch_um, range_um))]
    fn open(py: Python<'_>, path: PathBuf, pitch_um: Option<f64>, range_um: Option<f64>) -> PyResult<Self> {
        let options = HeightsOptions { pitch_um, range_um, ..HeightsOptions::default() };
        let (inner, _) = py.detach(|| read_heights(&path, &options)).or_raise(py)?;
        Ok(Self { inner })
    }

    /// One of the samples.
    #[staticmethod]
    fn sample(py: Python<'_>, name: &str, seed: u64) -> PyResult<Self> {
        let known = || Error::input(format!("there is no sample '{name}'; known are {}", SAMPLES.join(", ")));
        let made = py.detach(|| Heightfield::sample(name, seed).unwrap_or_else(|| Err(known())));
        Ok(Self { inner: made.or_raise(py)? })
    }

    /// Heights, µm, `[row along y, column along x]`.
    #[getter]
    fn height_um<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let [columns, rows] = self.inner.cells();
        PyArray1::from_slice(py, self.inner.height_um()).reshape([rows, columns])
    }

    /// Sides of the patch along x and y, µm.
    #[getter]
    fn size_um(&self) -> [f64; 2] {
        self.inner.size_um()
    }

    /// f `[wavelength]` for light from `wi` towards `wo`, 1/sr; `coherence_um` without a number is 16.25.
    #[pyo3(signature = (wavelengths_nm, wi, wo, coherence_um, index, threads, progress))]
    #[allow(clippy::too_many_arguments)] // they have names in Python
    fn spectrum<'py>(
        &self,
        py: Python<'py>,
        wavelengths_nm: Floats<'py>,
        wi: [f64; 3],
        wo: [f64; 3],
        coherence_um: Option<f64>,
        index: Option<f64>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let at = wavelengths(&wavelengths_nm).or_raise(py)?;
        let usual = Setup::default();
        let setup = Setup {
            coherence: coherence_um.map_or(usual.coherence, Coherence::Fixed),
            index: index.unwrap_or(usual.index),
            ..usual
        };
        let (wi, wo) = (direction("wi", wi).or_raise(py)?, direction("wo", wo).or_raise(py)?);
        let found = How::new(threads, progress)
            .run(py, |progress| spectrum(&self.inner, &setup, &at, wi, wo, progress))?;
        Ok(PyArray1::from_vec(py, found))
    }

    fn __repr__(&self) -> String {
        let ([columns, rows], [x, y]) = (self.inner.cells(), self.inner.size_um());
        format!("<barbule.Heights {columns} × {rows}, {x} × {y} µm>")
    }
}
