//! Materials: values, samples and densities in batches, and the tables behind them.

use std::borrow::Cow;
use std::path::PathBuf;
use std::sync::OnceLock;

use barbule::brdf::{FeatherBrdf, FeatherMaterial, Numbers, Options, Reciprocity, TableArray};
use barbule::bsdf::{Arch, Keratin, Reflectance};
use barbule::characterize::{Barbules, Catalog, Found, Origin};
use barbule::io::{self, encode_material};
use barbule::material::Library;
use barbule::open::{self, Opening};
use barbule::scattering::far_field::Polarization;
use barbule::scattering::lobe::FitKind;
use barbule::scattering::statistics::Sides;
use barbule::{Error, Result, Unobserved};
use numpy::ndarray::{ArrayViewD, IxDyn};
use numpy::{
    Element, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods as _, PyReadonlyArray1, PyReadonlyArray2,
    PyReadwriteArray,
};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use rayon::prelude::*;

use crate::arrays::shaped;
use crate::batch::{Batch, Rows, check_nm, check_unit, vector};
use crate::error::OrRaise as _;
use crate::opening::Given;
use crate::work::How;

/// A feather's material, ready to be evaluated.
#[pyclass(frozen, module = "barbule._native", subclass)]
pub(crate) struct Material {
    pub(crate) material: FeatherMaterial,
    pub(crate) brdf: FeatherBrdf,
    pub(crate) hash: String,
    source: String,
    /// The media that it was opened with.
    media: Library,
    /// Found when a place is first asked for.
    arch: OnceLock<Option<Arch>>,
}

/// How a material is evaluated, as Python says it.
#[derive(Default)]
pub(crate) struct Choices {
    reciprocity: Option<String>,
    sigma: Option<f64>,
    polarization: Option<u8>,
}

impl Choices {
    fn options(&self) -> Result<Options> {
        let polarization = match self.polarization {
            None => None,
            Some(1) => Some(Polarization::First),
            Some(2) => Some(Polarization::Second),
            Some(other) => {
                return Err(Error::input(format!("'polarization' is {other}; give 1, 2 or None")));
            }
        };
        let reciprocity = match &self.reciprocity {
            None => Reciprocity::default(),
            Some(word) => Reciprocity::named("'reciprocity'", word)?,
        };
        Ok(Options { sigma: self.sigma, reciprocity, polarization })
    }
}

impl Material {
    pub(crate) fn of(py: Python<'_>, found: Found, choices: Choices, media: Library) -> PyResult<Self> {
        let options = choices.options().or_raise(py)?;
        let source = match &found.origin {
            Origin::Shipped(_) => "shipped".to_owned(),
            Origin::File(path) => path.to_string_lossy().into_owned(),
            Origin::Memory => "memory".to_owned(),
        };
        let brdf = py.detach(|| FeatherBrdf::new(&found.material, options)).or_raise(py)?;
        Ok(Self { material: found.material, brdf, hash: found.hash, source, media, arch: OnceLock::new() })
    }

    /// The arch of the barbules that it was made of; none where they are flat.
    fn arch(&self) -> Result<Option<Arch>> {
        if let Some(known) = self.arch.get() {
            return Ok(*known);
        }
        let given = |name: &str| open::structure(name, &Opening::default(), &Unobserved);
        let barbules = Barbules::of(&self.material, self.media.clone(), &given, Catalog::default());
        let arch = barbules.and_then(|barbules| barbules.arch()).map_err(|e| e.at("'place'"))?;
        Ok(*self.arch.get_or_init(|| arch))
    }
}

fn slice<'a, T: Element>(array: &'a PyReadonlyArray1<'_, T>) -> Result<&'a [T]> {
    array.as_slice().map_err(|_| Error::input("an array is not contiguous"))
}

fn slice2<'a, T: Element>(array: &'a PyReadonlyArray2<'_, T>) -> Result<&'a [T]> {
    array.as_slice().map_err(|_| Error::input("an array is not contiguous"))
}

/// Runs at once, without the lock, on so many threads.
fn at_once<T: Send>(py: Python<'_>, threads: Option<usize>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = How::new(threads, None).pool().or_raise(py)?;
    Ok(py.detach(|| match pool {
        Some(pool) => pool.install(work),
        None => work(),
    }))
}

/// Directions `[row, 3]` and densities `[row]`.
type Drawn<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>);

#[pymethods]
impl Material {
    /// Opens a material: a file, or a structure whose material ships, is cached, or is made now.
    #[staticmethod]
    #[pyo3(signature = (text, media, cache, seed, may_compute, reciprocity, sigma, polarization, threads, progress))]
    #[allow(clippy::too_many_arguments)] // they have names in Python
    fn open(
        py: Python<'_>,
        text: &str,
        media: Vec<(String, String)>,
        cache: Option<PathBuf>,
        seed: Option<u64>,
        may_compute: bool,
        reciprocity: Option<String>,
        sigma: Option<f64>,
        polarization: Option<u8>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let opening = Given { media, cache, seed, may_compute }.opening().or_raise(py)?;
        let how = How::new(threads, progress);
        let found = how.run(py, |progress| open::material(text, &opening, progress))?;
        let media = opening.media.library().clone();
        Self::of(py, found, Choices { reciprocity, sigma, polarization }, media)
    }

    /// f `[row, wavelength]`, 1/sr; rows of each argument are one or as many as there are values.
    #[pyo3(signature = (wavelengths_nm, wi, wo, instance, count, threads))]
    fn eval_rows<'py>(
        &self,
        py: Python<'py>,
        wavelengths_nm: PyReadonlyArray2<'py, f64>,
        wi: PyReadonlyArray2<'py, f64>,
        wo: PyReadonlyArray2<'py, f64>,
        instance: Option<PyReadonlyArray1<'py, u64>>,
        count: usize,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let waves = wavelengths_nm.as_array().ncols();
        let names = instance.as_ref().map(slice).transpose().or_raise(py)?;
        let [nm, wi, wo] = [&wavelengths_nm, &wi, &wo].map(slice2);
        let (nm, wi, wo) = (nm.or_raise(py)?, wi.or_raise(py)?, wo.or_raise(py)?);
        let values = at_once(py, threads, || {
            let batch = Batch::new(nm, waves, wi, wo, count)?;
            let names = names.map(|names| Rows::new("instance", names, 1, count)).transpose()?;
            batch.eval(&self.brdf, names)
        })?;
        shaped(py, values.or_raise(py)?, &[count, waves])
    }

    /// How much of a value comes from a place, −1 to 1 across, over the mean of the width, `[row]`.
    #[pyo3(signature = (place, wi, wo, count))]
    fn shares_rows<'py>(
        &self,
        py: Python<'py>,
        place: f64,
        wi: PyReadonlyArray2<'py, f64>,
        wo: PyReadonlyArray2<'py, f64>,
        count: usize,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let [wi, wo] = [&wi, &wo].map(slice2);
        let (wi, wo) = (wi.or_raise(py)?, wo.or_raise(py)?);
        let shares = py.detach(|| {
            if !(-1.0..=1.0).contains(&place) {
                return Err(Error::input(format!("'place' is {place}; give a number from -1 to 1")));
            }
            let (wi, wo) = (Rows::new("wi", wi, 3, count)?, Rows::new("wo", wo, 3, count)?);
            let arch = self.arch()?;
            let one = |row: usize| {
                arch.map_or(1.0, |arch| arch.share(place, vector(wo.at(row)), vector(wi.at(row))))
            };
            Ok((0..count).into_par_iter().map(one).collect::<Vec<_>>())
        });
        Ok(PyArray1::from_vec(py, shares.or_raise(py)?))
    }

    /// Densities `[row, wavelength]`, 1/sr.
    #[pyo3(signature = (wavelengths_nm, wi, wo, count, threads))]
    fn pdf_rows<'py>(
        &self,
        py: Python<'py>,
        wavelengths_nm: PyReadonlyArray2<'py, f64>,
        wi: PyReadonlyArray2<'py, f64>,
        wo: PyReadonlyArray2<'py, f64>,
        count: usize,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let waves = wavelengths_nm.as_array().ncols();
        let [nm, wi, wo] = [&wavelengths_nm, &wi, &wo].map(slice2);
        let (nm, wi, wo) = (nm.or_raise(py)?, wi.or_raise(py)?, wo.or_raise(py)?);
        let values = at_once(py, threads, || {
            let batch = Batch::new(nm, waves, wi, wo, count)?;
            batch.check()?;
            Ok(batch.pdf(&self.brdf))
        })?;
        shaped(py, values.or_raise(py)?, &[count, waves])
    }

    /// Outgoing directions `[row, 3]` and their densities `[row]`; NaN and 0 where light comes from below or none is drawn.
    #[pyo3(signature = (wavelength_nm, wi, u, count, threads))]
    fn sample_rows<'py>(
        &self,
        py: Python<'py>,
        wavelength_nm: PyReadonlyArray2<'py, f64>,
        wi: PyReadonlyArray2<'py, f64>,
        u: PyReadonlyArray2<'py, f64>,
        count: usize,
        threads: Option<usize>,
    ) -> PyResult<Drawn<'py>> {
        let [nm, wi, u] = [&wavelength_nm, &wi, &u].map(slice2);
        let (nm, wi, uniform) = (nm.or_raise(py)?, wi.or_raise(py)?, u.or_raise(py)?);
        let drawn = at_once(py, threads, || {
            let nm = Rows::new("wavelength_nm", nm, 1, count)?;
            let wi = Rows::new("wi", wi, 3, count)?;
            let u = Rows::new("u", uniform, 2, count)?;
            check_nm("wavelength_nm", nm)?;
            check_unit("wi", wi)?;
            if let Some(bad) = uniform.par_iter().find_first(|u| !(0.0..1.0).contains(*u)) {
                return Err(Error::input(format!("'u' holds {bad}; give numbers from 0 to below 1")));
            }
            let one = |row: usize| {
                let u = u.at(row);
                self.brdf.sample(nm.at(row)[0] as f32, vector(wi.at(row)), [u[0], u[1]])
            };
            Ok((0..count).into_par_iter().map(one).collect::<Vec<_>>())
        })?;
        let drawn = drawn.or_raise(py)?;
        let directions: Vec<f64> =
            drawn.iter().flat_map(|one| one.map_or([f64::NAN; 3], |(wo, _)| wo.to_array())).collect();
        let densities: Vec<f64> = drawn.iter().map(|one| one.map_or(0.0, |(_, pdf)| pdf)).collect();
        let directions = PyArray1::from_vec(py, directions).reshape([count, 3])?;
        Ok((directions, PyArray1::from_vec(py, densities)))
    }

    /// What the mean reflects of light from `wi`, `[row]`.
    #[pyo3(signature = (wavelength_nm, wi, count, threads))]
    fn albedo_rows<'py>(
        &self,
        py: Python<'py>,
        wavelength_nm: PyReadonlyArray2<'py, f64>,
        wi: PyReadonlyArray2<'py, f64>,
        count: usize,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let [nm, wi] = [&wavelength_nm, &wi].map(slice2);
        let (nm, wi) = (nm.or_raise(py)?, wi.or_raise(py)?);
        let values = at_once(py, threads, || {
            let nm = Rows::new("wavelength_nm", nm, 1, count)?;
            let wi = Rows::new("wi", wi, 3, count)?;
            check_nm("wavelength_nm", nm)?;
            check_unit("wi", wi)?;
            let one = |row: usize| self.brdf.albedo(nm.at(row)[0] as f32, vector(wi.at(row)));
            Ok((0..count).into_par_iter().map(one).collect::<Vec<_>>())
        })?;
        Ok(PyArray1::from_vec(py, values.or_raise(py)?))
    }

    /// All that is evaluated, by name, as read-only arrays on this material's own memory (`docs/formats/brdf-tables.md`).
    fn tables<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let py = slf.py();
        let all = PyDict::new(py);
        for array in slf.get().brdf.tables().arrays() {
            let (name, shape) = (array.name, array.shape);
            let values = match array.numbers {
                Numbers::F64(values) => held(slf, values, &shape)?.into_any(),
                Numbers::F32(values) => held(slf, values, &shape)?.into_any(),
                Numbers::I16(values) => held(slf, values, &shape)?.into_any(),
            };
            all.set_item(name, values)?;
        }
        Ok(all)
    }

    /// What the tables mean: the header of `docs/formats/brdf-tables.md`.
    fn header<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        header_of(py, &self.brdf)
    }

    /// The bytes of its file.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| encode_material(&self.material)).or_raise(py)?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Writes a material file, whole or not at all.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| barbule::io::write_material(&path, &self.material)).or_raise(py)
    }

    /// How it was made, as JSON.
    fn info_json(&self) -> String {
        self.material.info.to_string()
    }

    #[getter]
    fn name(&self) -> String {
        barbule::figures::title(&self.material)
    }

    #[getter]
    fn hash(&self) -> &str {
        &self.hash
    }

    #[getter]
    fn source(&self) -> &str {
        &self.source
    }

    #[getter]
    fn wavelengths_nm<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.material.axes.wavelengths_nm())
    }

    #[getter]
    fn cos_theta_i<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.material.axes.cos_theta())
    }

    #[getter]
    fn cos_phi_i<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.material.axes.cos_phi())
    }

    #[getter]
    fn sigma(&self) -> f64 {
        self.brdf.sigma()
    }

    #[getter]
    fn halo_sigmas(&self) -> Vec<f64> {
        self.brdf.halo_sigmas().to_vec()
    }
}

/// The header of `docs/formats/brdf-tables.md` by name.
fn header_of<'py>(py: Python<'py>, brdf: &FeatherBrdf) -> PyResult<Bound<'py, PyDict>> {
    let header = brdf.tables().header();
    let all = PyDict::new(py);
    all.set_item("version", header.version)?;
    all.set_item(
        "kind",
        match header.kind {
            FitKind::Marginal => "marginal",
            FitKind::Cone => "cone",
        },
    )?;
    all.set_item(
        "sides",
        match header.sides {
            Sides::Alike => "alike",
            Sides::Both => "both",
        },
    )?;
    all.set_item("polarization", header.polarization.map(|p| p.index() + 1))?;
    all.set_item("reciprocity", brdf.reciprocity().word())?;
    all.set_item("sigma", header.sigma)?;
    all.set_item("halo", header.halo)?;
    all.set_item("height_um", header.spectral.height_um)?;
    all.set_item("achromatic", header.spectral.achromatic)?;
    all.set_item("seed", header.seed)?;
    all.set_item("sets", header.sets)?;
    all.set_item("thetas", header.thetas)?;
    all.set_item("phis", header.phis)?;
    all.set_item("waves", header.waves)?;
    Ok(all)
}

/// The header and the arrays of a file of tables (`docs/formats/brdf-tables.md`).
#[pyfunction]
pub(crate) fn read_tables(py: Python<'_>, path: PathBuf) -> PyResult<(Bound<'_, PyDict>, Bound<'_, PyDict>)> {
    let brdf = py.detach(|| io::read_tables(&path).map(FeatherBrdf::from_tables)).or_raise(py)?;
    let all = PyDict::new(py);
    for TableArray { name, shape, numbers } in brdf.tables().arrays() {
        let values = match numbers {
            Numbers::F64(values) => shaped(py, values.into_owned(), &shape)?.into_any(),
            Numbers::F32(values) => shaped(py, values.into_owned(), &shape)?.into_any(),
            Numbers::I16(values) => shaped(py, values.into_owned(), &shape)?.into_any(),
        };
        all.set_item(name, values)?;
    }
    Ok((header_of(py, &brdf)?, all))
}

/// Of the boundary of keratin of this roughness (GGX α) and index: its directional albedo at cosines that are even from 0 to 1, and its
/// cosine-weighted mean.
#[pyfunction]
pub(crate) fn keratin_boundary(py: Python<'_>, roughness: f64, index: f64) -> PyResult<(Vec<f64>, f64)> {
    let keratin = Reflectance::new(|_| 0.0).and_then(|black| Keratin::new(roughness, index, black));
    let keratin = keratin.or_raise(py)?;
    let (albedo, mean) = keratin.boundary();
    Ok((albedo.to_vec(), mean))
}

/// A read-only array over numbers that a material holds, or over a copy of those that are computed as they are asked for.
fn held<'py, T: Element + Copy>(
    owner: &Bound<'py, Material>,
    values: Cow<'_, [T]>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let array = match values {
        Cow::Owned(values) => shaped(owner.py(), values, shape)?,
        Cow::Borrowed(values) => {
            let view = ArrayViewD::from_shape(IxDyn(shape), values);
            let view = view.map_err(|error| Error::machine(error.to_string())).or_raise(owner.py())?;
            // SAFETY: the numbers lie in the tables of `owner`, which nobody can change or move (the class is frozen, the tables are
            // behind an `Arc` that it keeps), NumPy keeps `owner` alive, and the array is made read-only before anybody sees it.
            #[allow(unsafe_code)]
            let array = unsafe { PyArrayDyn::borrow_from_array(&view, owner.clone().into_any()) };
            array
        }
    };
    PyReadwriteArray::make_nonwriteable(array.readwrite());
    Ok(array)
}
