//! Structures and their sections.

use barbule::Structure as Opened;
use barbule::figures;
use barbule::io::{section_json, write_section};
use barbule::plot::{Format, Page};
use barbule::structure::{Medium, Polyline, Side};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};

use crate::arrays::{Floats, flat};
use crate::error::OrRaise as _;

/// What a barbule is made of: a species, a stack, given sections or a lattice.
///
/// Example:
///
///     >>> import barbule
///     >>> mallard: barbule.Structure = barbule.open("mallard")
///     >>> mallard.instance(0).width_um
///     40.0
#[pyclass(frozen, module = "barbule")]
pub(crate) struct Structure {
    pub(crate) inner: Opened,
}

impl Structure {
    pub(crate) fn of(inner: Opened) -> Self {
        Self { inner }
    }
}

#[pymethods]
impl Structure {
    /// What it is called, as in `starling:green`.
    #[getter]
    fn name(&self) -> String {
        self.inner.name()
    }

    /// The barbule's width, µm.
    #[getter]
    fn width_um(&self) -> f64 {
        self.inner.width_um()
    }

    /// How many sections there are; `None` of random structures, which have no end of them.
    #[getter]
    fn count(&self) -> Option<usize> {
        self.inner.count()
    }

    /// Whether light falls on its lower side.
    #[getter]
    fn is_lower_side(&self) -> bool {
        self.inner.side() == Side::Below
    }

    /// BLAKE3 of all that decides its numbers, hexadecimal.
    #[getter]
    fn hash(&self) -> String {
        self.inner.hash()
    }

    /// The same barbule, lit from below.
    fn underside(&self, py: Python<'_>) -> PyResult<Self> {
        Ok(Self::of(self.inner.clone().underside().or_raise(py)?))
    }

    /// One individual, from 0; the same seed and number are the same one everywhere.
    #[pyo3(signature = (index = 0, seed = 1))]
    fn instance(&self, py: Python<'_>, index: usize, seed: u64) -> PyResult<Section> {
        py.detach(|| self.inner.instance(seed, index)).or_raise(py).map(|inner| Section { inner })
    }

    fn __repr__(&self) -> String {
        format!("<barbule.Structure {}, {} µm wide>", self.inner.name(), self.inner.width_um())
    }

    /// The first individual, drawn.
    fn _repr_svg_(&self, py: Python<'_>) -> PyResult<String> {
        self.instance(py, 0, 1)?._repr_svg_(py)
    }
}

/// A barbule's cross section.
///
/// Example:
///
///     >>> import barbule
///     >>> section: barbule.Section = barbule.open("starling").instance(0)
///     >>> section.media_at([0.0, 0.0], [5.0, -0.3])[0]
///     'air'
#[pyclass(frozen, module = "barbule")]
pub(crate) struct Section {
    pub(crate) inner: barbule::Section,
}

/// A curve as `(x_um, z_um)`.
type Curve<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

fn curve<'py>(py: Python<'py>, line: &Polyline) -> Curve<'py> {
    (PyArray1::from_slice(py, &line.x_um), PyArray1::from_slice(py, &line.z_um))
}

fn label(medium: &Medium) -> String {
    let substances: Vec<String> = medium.substances().map(|substance| substance.label()).collect();
    substances.join(" + ")
}

#[pymethods]
impl Section {
    /// What it is called.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    /// The barbule's width, µm.
    #[getter]
    fn width_um(&self) -> f64 {
        self.inner.width_um
    }

    /// Open curves from the top down, each `(x_um, z_um)`.
    #[getter]
    fn boundaries<'py>(&self, py: Python<'py>) -> Vec<Curve<'py>> {
        self.inner.boundaries.iter().map(|line| curve(py, line)).collect()
    }

    /// What lies above, between and below the boundaries: one more than these.
    #[getter]
    fn media(&self) -> Vec<String> {
        self.inner.media.iter().map(label).collect()
    }

    /// Closed regions: dictionaries of `outline` (`(x_um, z_um)`, circles with 64 corners), `medium` and `holes`.
    #[getter]
    fn inclusions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let all = PyList::empty(py);
        for inclusion in &self.inner.inclusions {
            let one = PyDict::new(py);
            one.set_item("outline", curve(py, &inclusion.outline.corners()))?;
            one.set_item("medium", label(&inclusion.medium))?;
            let holes: Vec<_> = inclusion.holes.iter().map(|hole| curve(py, &hole.corners())).collect();
            one.set_item("holes", holes)?;
            all.append(one)?;
        }
        Ok(all)
    }

    /// The names of the media at points, µm; both arrays of one length.
    fn media_at(&self, py: Python<'_>, x_um: Floats<'_>, z_um: Floats<'_>) -> PyResult<Vec<String>> {
        let (x, z) = (flat(&x_um), flat(&z_um));
        if x.len() != z.len() {
            let message = format!("'x_um' has {} numbers and 'z_um' {}; give as many", x.len(), z.len());
            return Err(barbule::Error::input(message)).or_raise(py);
        }
        Ok(x.iter().zip(&z).map(|(&x, &z)| label(self.inner.medium_at(x, z))).collect())
    }

    /// The text of a section file.
    fn json(&self) -> String {
        format!("{:#}", section_json(&self.inner))
    }

    /// Writes a section file.
    fn save(&self, py: Python<'_>, path: std::path::PathBuf) -> PyResult<()> {
        py.detach(|| write_section(&path, &self.inner)).or_raise(py)
    }

    /// The section as a figure, `svg`, `pdf` or `png`.
    #[pyo3(signature = (format = "svg"))]
    fn figure<'py>(&self, py: Python<'py>, format: &str) -> PyResult<Bound<'py, PyBytes>> {
        let kind = Format::of(std::path::Path::new(&format!("figure.{format}"))).or_raise(py)?;
        let bytes = py.detach(|| {
            figures::section(&self.inner, &self.inner.name, None, &Page::default()).encode(kind, &[])
        });
        Ok(PyBytes::new(py, &bytes.or_raise(py)?))
    }

    fn _repr_svg_(&self, py: Python<'_>) -> PyResult<String> {
        let bytes = self.figure(py, "svg")?;
        Ok(String::from_utf8_lossy(bytes.as_bytes()).into_owned())
    }

    fn __repr__(&self) -> String {
        let barbule::Section { name, width_um, boundaries, inclusions, .. } = &self.inner;
        format!(
            "<barbule.Section {name}, {width_um} µm wide, {} boundaries, {} inclusions>",
            boundaries.len(),
            inclusions.len()
        )
    }
}
