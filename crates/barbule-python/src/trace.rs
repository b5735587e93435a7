//! Micrographs, traced.

use std::path::PathBuf;

use barbule::error::shortened;
use barbule::io::{read_micrograph, write_whole};
use barbule::plot::{Format, Page};
use barbule::trace::{Grey, Kind};
use barbule::traced::{Micrograph, TracedImage, trace_image};
use barbule::{Error, Result};
use numpy::{PyArray2, PyArrayMethods as _, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::OrRaise as _;
use crate::opening::Given;

/// What a micrograph shows.
#[pyclass(frozen, module = "barbule")]
pub(crate) struct Traced {
    inner: TracedImage,
}

/// A picture as Python has one.
#[derive(FromPyObject)]
pub(crate) enum Picture<'py> {
    /// `[row, column]`, 0 black to 1 white.
    Values(PyReadonlyArray2<'py, f32>),
    /// A file.
    File(PathBuf),
}

fn kind_of(name: &str) -> Result<Kind> {
    match name {
        "lattice" => Ok(Kind::Lattice),
        "layers" => Ok(Kind::Layers),
        "section" => Ok(Kind::Section),
        _ => Err(Error::input(format!(
            "'kind' is '{}'; give 'lattice', 'layers' or 'section'",
            shortened(name)
        ))),
    }
}

/// Traces a picture.
#[pyfunction]
#[pyo3(signature = (image, nm_per_px, thresholds, classes, kind, cortex_nm, crop, media))]
#[allow(clippy::too_many_arguments)] // they have names in Python
pub(crate) fn trace(
    py: Python<'_>,
    image: Picture<'_>,
    nm_per_px: f64,
    thresholds: Option<Vec<f64>>,
    classes: Option<Vec<String>>,
    kind: Option<&str>,
    cortex_nm: Option<f64>,
    crop: Option<[usize; 4]>,
    media: Vec<(String, String)>,
) -> PyResult<Traced> {
    let kind = kind.map(kind_of).transpose().or_raise(py)?;
    let (name, values) = match image {
        Picture::File(path) => (path.file_stem().map(|stem| stem.to_string_lossy().into_owned()), Err(path)),
        Picture::Values(values) => {
            let view = values.as_array();
            (None, Ok((view.ncols(), view.nrows(), view.iter().copied().collect::<Vec<f32>>())))
        }
    };
    let given = Micrograph {
        media: classes,
        thresholds,
        kind,
        cortex_nm,
        name: name.unwrap_or_else(|| "traced".into()),
        ..Micrograph::of_pixels(nm_per_px)
    };
    let traced = py.detach(|| {
        let picture = match values {
            Ok((width, height, values)) => {
                Grey::new(width, height, values).map_err(|error| error.at("'image'"))?
            }
            Err(path) => read_micrograph(&path)?,
        };
        let picture = crop.map_or(Ok(picture.clone()), |part| picture.part(part))?;
        let opening = Given { media, ..Given::default() }.opening()?;
        trace_image(&picture, &given, opening.media.library())
    });
    Ok(Traced { inner: traced.or_raise(py)? })
}

#[pymethods]
impl Traced {
    /// What was measured, as JSON.
    fn json(&self) -> String {
        self.inner.json().to_string()
    }

    /// The flattened picture, grey levels 0 to 255, `[row, column]`.
    #[getter]
    fn flat<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let [width, height] = self.inner.traced.flat.size();
        numpy::PyArray1::from_slice(py, self.inner.traced.flat.values()).reshape([height, width])
    }

    /// Middles, outer and inner diameters of rods, px: `[rod, (x, y, diameter, hollow)]`.
    #[getter]
    fn rods_px<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rods = &self.inner.traced.rods;
        let values: Vec<f64> =
            rods.iter().flat_map(|rod| [rod.middle[0], rod.middle[1], rod.diameter, rod.hollow]).collect();
        numpy::PyArray1::from_vec(py, values).reshape([rods.len(), 4])
    }

    /// The text of a file that simulates.
    fn text(&self, py: Python<'_>, is_json: bool) -> PyResult<String> {
        self.inner.file(is_json, &self.source()).or_raise(py)
    }

    /// Writes a file that simulates.
    fn save(&self, py: Python<'_>, path: PathBuf, is_json: bool) -> PyResult<()> {
        py.detach(|| write_whole(&path, self.inner.file(is_json, &self.source())?.as_bytes())).or_raise(py)
    }

    /// Outlines, thresholds and measures over the picture.
    fn figure<'py>(&self, py: Python<'py>, format: &str) -> PyResult<Bound<'py, PyBytes>> {
        let kind = Format::of(std::path::Path::new(&format!("figure.{format}"))).or_raise(py)?;
        let bytes = py.detach(|| self.inner.figure("", &Page::default(), None).encode(kind, &[]));
        Ok(PyBytes::new(py, &bytes.or_raise(py)?))
    }
}

impl Traced {
    fn source(&self) -> String {
        format!("traced, 1 px = {:.4} nm", self.inner.nm_per_px)
    }
}
