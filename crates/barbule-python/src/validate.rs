//! The fast simulation against full waves and against segments, as units of work.

use std::path::{Path, PathBuf};

use barbule::campaign::Allowance;
use barbule::clock;
use barbule::io::{Units, available_memory};
use barbule::math::simd::Width;
use barbule::open::{Located, locate, material_of};
use barbule::progress::Progress;
use barbule::solve::cost::PROGRAM;
use barbule::validate::three_d::SegmentOptions;
use barbule::validate::{Comparing, FullWaveOptions, units_in};
use barbule::{Error, Result};
use pyo3::prelude::*;
use serde::de::DeserializeOwned;
use serde_json::json;

use crate::arrays::check_simulated;
use crate::error::OrRaise as _;
use crate::opening::Given;
use crate::structure::Structure;
use crate::work::How;

/// A comparison with the folder of its figures, in whose `units` its work is kept.
#[pyclass(frozen, module = "barbule._native")]
pub(crate) struct Comparison {
    plan: Box<dyn Comparing>,
    folder: PathBuf,
    kept: Units,
    seed: u64,
    /// Whether the SIMD instructions that are asked for decide all bits.
    is_pinned: bool,
}

/// What `options`, JSON, says; what it leaves out is usual.
fn read<T: DeserializeOwned>(options: &str) -> Result<T> {
    serde_json::from_str(options).map_err(|error| Error::input(format!("the comparison's options: {error}")))
}

#[pymethods]
impl Comparison {
    /// Plans it: `against` is `full-wave` or `three-d`, `options` are JSON. Segments are compared with a material where `with_material`
    /// says so: one of that name, or without a name the structure's own where it is at hand. Full waves may take `memory_bytes`.
    #[new]
    #[pyo3(signature = (structure, folder, against, options, with_material, material, media, simd, cache, memory_bytes))]
    #[allow(clippy::too_many_arguments)] // they have names in Python
    fn new(
        py: Python<'_>,
        structure: &Structure,
        folder: PathBuf,
        against: &str,
        options: &str,
        with_material: bool,
        material: Option<&str>,
        media: Vec<(String, String)>,
        simd: Option<&str>,
        cache: Option<PathBuf>,
        memory_bytes: Option<u64>,
    ) -> PyResult<Self> {
        let width = simd.map_or_else(|| Ok(Width::best()), Width::named).or_raise(py)?;
        let inner = structure.inner.clone();
        How::default().run(py, |progress| {
            let kept = units_in(&folder)?;
            if against == "full-wave" {
                let options: FullWaveOptions = read(options)?;
                check_simulated(options.wavelengths_nm.as_deref().unwrap_or_default())?;
                let memory_bytes = memory_bytes.or_else(available_memory).unwrap_or(u64::MAX);
                let plan = Box::new(options.plan(inner, memory_bytes, clock::system)?);
                return Ok(Self { plan, folder, kept, seed: options.seed, is_pinned: false });
            }
            let options: SegmentOptions = read(options)?;
            check_simulated(options.wavelengths_nm.as_deref().unwrap_or_default())?;
            let opening = Given { media, cache, seed: Some(options.seed), ..Given::default() }.opening()?;
            let located = match material.filter(|_| with_material) {
                Some(name) => Some(locate(name, &opening, progress)?),
                None if with_material && options.is_as_named() => Some(material_of(inner.clone(), &opening)?),
                None => None,
            };
            let material = match located {
                Some(Located::There(found)) => Some(Box::new(found.material)),
                _ => None,
            };
            // Orders of crystals come from dense algebra, which chooses instructions itself.
            let is_pinned = inner.lattice().is_none();
            let plan = Box::new(options.plan(inner, material, width, clock::system)?);
            Ok(Self { plan, folder, kept, seed: options.seed, is_pinned })
        })
    }

    /// Whether the SIMD instructions that are asked for decide all bits; if not, those of each processor do too.
    #[getter]
    fn is_pinned(&self) -> bool {
        self.is_pinned
    }

    /// What each unit takes on so many threads, foretold: seconds, and bytes of the whole process.
    fn costs(&self, py: Python<'_>, threads: usize) -> PyResult<Vec<(f64, u64)>> {
        How::default().run(py, |progress| {
            let each = self.plan.costs(threads, progress)?.into_iter();
            Ok(each.map(|cost| (cost.seconds.unwrap_or_default(), PROGRAM + cost.bytes)).collect())
        })
    }

    /// The units that are not kept.
    fn missing(&self, py: Python<'_>) -> Vec<usize> {
        let all: Vec<usize> = (0..self.plan.units()).collect();
        py.detach(|| self.plan.missing(&all, &self.kept))
    }

    /// Computes a unit and keeps it, unless it is there.
    #[pyo3(signature = (unit, threads, progress))]
    fn run(
        &self,
        py: Python<'_>,
        unit: usize,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        How::new(threads, progress).run(py, |progress| self.plan.run_unit(unit, &self.kept, progress))
    }

    /// Refuses what does not fit into memory: what is allowed, or the machine has left.
    #[pyo3(signature = (threads, memory_bytes))]
    fn check_memory(
        &self,
        py: Python<'_>,
        threads: Option<usize>,
        memory_bytes: Option<u64>,
    ) -> PyResult<()> {
        let allowed = match memory_bytes {
            Some(bytes) => Allowance { bytes, asked: true },
            None => available_memory().map_or(Allowance::UNKNOWN, |bytes| Allowance { bytes, asked: false }),
        };
        How::new(threads, None).run(py, |progress| {
            let most = self.plan.total_cost(rayon::current_num_threads(), progress)?.bytes;
            allowed.check("this comparison", most, "a smaller width, fewer layers or longer wavelengths")
        })
    }

    /// Compares what is kept, and computes what is not; writes the folder. The numbers as JSON.
    #[pyo3(signature = (threads, progress))]
    fn finish(
        &self,
        py: Python<'_>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        How::new(threads, progress).run(py, |progress: &dyn Progress| {
            let mut compared = self.plan.finish(Some(&self.kept), progress)?;
            let (version, seed) = (env!("CARGO_PKG_VERSION"), self.seed.to_string());
            let made = json!({"version": version, "seed": self.seed});
            compared.write(&self.folder, made, &[("version", version), ("seed", &seed)])?;
            Ok(compared.numbers.to_string())
        })
    }

    fn __len__(&self) -> usize {
        self.plan.units()
    }

    fn __repr__(&self) -> String {
        let folder: &Path = &self.folder;
        format!(
            "<barbule._native.Comparison {}, {} {}>",
            folder.display(),
            self.plan.units(),
            self.plan.what()
        )
    }
}
