//! Campaigns in portions, for workers on several machines.

use std::path::PathBuf;

use barbule::Result;
use barbule::brdf::fit::FitOptions;
use barbule::campaign::Allowance;
use barbule::characterize::{Found, Origin, Portions, as_filed};
use barbule::io::available_memory;
use barbule::io::store::Store;
use barbule::material::Library;
use barbule::math::simd::Width;
use pyo3::prelude::*;

use crate::error::OrRaise as _;
use crate::make::campaign;
use crate::material::{Choices, Material};
use crate::opening::Given;
use crate::structure::Structure;
use crate::work::How;

/// The SIMD instructions of this processor by name, widest first.
#[pyfunction]
pub(crate) fn simd() -> Vec<&'static str> {
    Width::available().into_iter().map(Width::name).collect()
}

/// How a material is fitted.
fn fitted(sigma: Option<f64>, halo: bool) -> FitOptions {
    let usual = FitOptions::default();
    FitOptions { halo, sigma: sigma.unwrap_or(usual.sigma), ..usual }
}

/// A campaign in portions that take a few seconds each, with its store; instances are prepared with the first portion.
#[pyclass(frozen, module = "barbule._native")]
pub(crate) struct Campaign {
    portions: Portions,
}

#[pymethods]
impl Campaign {
    /// Creates the store, or opens it to go on; `options` are JSON, `seconds` what a portion is to take on one thread.
    #[new]
    #[pyo3(signature = (structure, store, options, keep_fields_nm, simd, seconds, cache, memory_bytes))]
    #[allow(clippy::too_many_arguments)] // they have names in Python
    fn new(
        py: Python<'_>,
        structure: &Structure,
        store: PathBuf,
        options: &str,
        keep_fields_nm: Vec<f64>,
        simd: Option<&str>,
        seconds: f64,
        cache: Option<PathBuf>,
        memory_bytes: Option<u64>,
    ) -> PyResult<Self> {
        let options = campaign(options).or_raise(py)?;
        let catalog = Given { cache, ..Given::default() }.opening().or_raise(py)?.catalog;
        let width = simd.map_or_else(|| Ok(Width::best()), Width::named).or_raise(py)?;
        let allowed = match memory_bytes {
            Some(bytes) => Allowance { bytes, asked: true },
            None => available_memory().map_or(Allowance::UNKNOWN, |bytes| Allowance { bytes, asked: false }),
        };
        let portions = How::default().run(py, |_| {
            let plan = options.plan(structure.inner.clone())?;
            Portions::new(plan, &store, &keep_fields_nm, width, seconds, catalog, allowed)
        })?;
        Ok(Self { portions })
    }

    /// The SIMD instructions that a store is computed with; `None` where there is none that can be opened.
    #[staticmethod]
    fn simd_of(py: Python<'_>, store: PathBuf) -> Option<String> {
        py.detach(|| Store::open(&store).ok().map(|store| store.width().to_owned()))
    }

    /// The structure's name.
    #[getter]
    fn name(&self) -> String {
        self.portions.store().name().to_owned()
    }

    /// The SIMD instructions that the store is computed with.
    #[getter]
    fn simd(&self) -> String {
        self.portions.store().width().to_owned()
    }

    /// Of each portion: how many units of the campaign it has, and the seconds that it takes on one thread, foretold.
    #[getter]
    fn portions(&self, py: Python<'_>) -> PyResult<Vec<(usize, f64)>> {
        let one = |portion| -> Result<(usize, f64)> {
            Ok((self.portions.units(portion)?.len(), self.portions.seconds(portion)?))
        };
        (0..self.portions.count()).map(one).collect::<Result<_>>().or_raise(py)
    }

    /// Memory that a worker takes which computes one portion at a time, bytes, foretold; takes seconds.
    #[pyo3(signature = (threads, progress))]
    fn memory_bytes(
        &self,
        py: Python<'_>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<u64> {
        How::new(threads, progress).run(py, |progress| self.portions.bytes(progress))
    }

    /// Whether a portion is in the store and its checksums hold.
    fn is_done(&self, py: Python<'_>, portion: usize) -> PyResult<bool> {
        py.detach(|| self.portions.is_whole(portion)).or_raise(py)
    }

    /// Prepares the instances, which the first portion does else; other threads wait for it.
    #[pyo3(signature = (threads, progress))]
    fn prepare(&self, py: Python<'_>, threads: Option<usize>, progress: Option<Py<PyAny>>) -> PyResult<()> {
        How::new(threads, progress).run(py, |progress| self.portions.prepare(progress))
    }

    /// Computes what the store lacks of a portion: how many units were computed, and how many were there.
    #[pyo3(signature = (portion, threads = Some(1), progress = None))]
    fn run(
        &self,
        py: Python<'_>,
        portion: usize,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(usize, usize)> {
        let outcome = How::new(threads, progress).run(py, |progress| self.portions.run(portion, progress))?;
        Ok((outcome.computed, outcome.found))
    }

    /// The files of each unit of a portion in the order of writing, relative to the store.
    fn files(&self, py: Python<'_>, portion: usize) -> PyResult<Vec<Vec<String>>> {
        self.portions.files(portion).or_raise(py)
    }

    /// The files that the store has without any portion, the group's description last.
    fn own_files(&self) -> Vec<String> {
        self.portions.store().own_files()
    }

    /// Units of the material's halo.
    #[getter]
    fn halo_count(&self) -> usize {
        self.portions.halo_count()
    }

    /// Memory that a worker takes for a unit of the halo, bytes.
    fn halo_bytes(&self, py: Python<'_>, threads: Option<usize>) -> PyResult<u64> {
        How::new(threads, None).run(py, |_| self.portions.halo_bytes())
    }

    /// Whether a unit of the halo is beside the store.
    fn is_halo_done(&self, py: Python<'_>, unit: usize) -> PyResult<bool> {
        py.detach(|| self.portions.halo_is_done(unit)).or_raise(py)
    }

    /// Simulates a unit of the halo and keeps it beside the store.
    #[pyo3(signature = (unit, threads, progress))]
    fn run_halo(
        &self,
        py: Python<'_>,
        unit: usize,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        How::new(threads, progress).run(py, |progress| self.portions.run_halo(unit, progress))
    }

    /// Refuses what no material can be fitted with.
    fn check(&self, py: Python<'_>, sigma: Option<f64>) -> PyResult<()> {
        self.portions.check(&fitted(sigma, false)).or_raise(py)
    }

    /// Fits the material of the finished store.
    #[pyo3(signature = (sigma, halo, threads, progress))]
    fn material(
        &self,
        py: Python<'_>,
        sigma: Option<f64>,
        halo: bool,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Material> {
        let found = How::new(threads, progress).run(py, |progress| {
            let (material, hash) = as_filed(&self.portions.material(&fitted(sigma, halo), progress)?)?;
            Ok(Found { material, hash, origin: Origin::Memory })
        })?;
        Material::of(py, found, Choices::default(), Library::default())
    }

    /// Ends what others see of this process in the store, which its first portion began.
    fn leave(&self, py: Python<'_>) {
        py.detach(|| self.portions.leave());
    }

    /// Removes what writing needed, unless other processes still write.
    fn end(&self, py: Python<'_>) {
        py.detach(|| self.portions.store().end_writing());
    }

    fn __len__(&self) -> usize {
        self.portions.count()
    }

    fn __repr__(&self) -> String {
        format!("<barbule._native.Campaign {}, {} portions>", self.name(), self.portions.count())
    }
}
