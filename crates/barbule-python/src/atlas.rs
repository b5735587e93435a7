//! Atlases: sweeps over sizes into one store.

use std::path::{Path, PathBuf};

use barbule::Result;
use barbule::atlas::{Atlas, Plan, foretell, run};
use barbule::campaign::Allowance;
use barbule::io::available_memory;
use barbule::math::simd::Width;
use barbule::progress::{Progress, Shard};
use pyo3::prelude::*;

use crate::error::OrRaise as _;
use crate::opening::Given;
use crate::work::How;

/// Units computed now, units that were there, units that were damaged, and numbers and seconds of those computed now.
type Done = (usize, usize, usize, Vec<(usize, f64)>);

/// Cells, units, files, bytes, bytes of memory, cores, seconds of each cell that was tried, seconds of all.
type Foretold = (usize, usize, usize, u64, u64, usize, Vec<f64>, f64);

/// The plan of a file with its names opened.
fn opened(plan: &Path, given: &Given, width: Width, progress: &dyn Progress) -> Result<Atlas> {
    let (read, folder) = Plan::open(plan)?;
    Atlas::new(&read, &folder, &given.opening()?, width, progress).map_err(|error| error.in_file(plan))
}

/// Fills the store of a plan, or goes on with it.
#[pyfunction]
#[pyo3(signature = (plan, store, shard, seed, media, simd, cache, memory_bytes, threads, progress))]
#[allow(clippy::too_many_arguments)] // they have names in Python
pub(crate) fn atlas(
    py: Python<'_>,
    plan: PathBuf,
    store: PathBuf,
    shard: (usize, usize),
    seed: u64,
    media: Vec<(String, String)>,
    simd: Option<String>,
    cache: Option<PathBuf>,
    memory_bytes: Option<u64>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Done> {
    let given = Given { media, cache, seed: Some(seed), ..Given::default() };
    let width = simd.map(|name| Width::named(&name)).transpose().or_raise(py)?.unwrap_or_default();
    How::new(threads, progress).run(py, |progress| {
        let shard = Shard::new(shard.0, shard.1).map_err(|error| error.at("'shard'"))?;
        let atlas = opened(&plan, &given, width, progress)?;
        let store = atlas.create(&store)?;
        let units = atlas.units(shard);
        if !(0..atlas.layout().units()).any(|unit| store.is_done(unit)) {
            let allowed = match memory_bytes {
                Some(bytes) => Allowance { bytes, asked: true },
                None => {
                    available_memory().map_or(Allowance::UNKNOWN, |bytes| Allowance { bytes, asked: false })
                }
            };
            let needed = foretell(&atlas, progress)?.memory_bytes;
            allowed.check("the atlas", needed, "fewer angles, wavelengths or individuals")?;
        }
        let _announced = store.announce(shard);
        let outcome = run(&atlas, &store, &units, progress)?;
        Ok((outcome.computed, outcome.found, outcome.repaired, outcome.seconds))
    })
}

/// What the atlas of a plan will take.
#[pyfunction]
#[pyo3(signature = (plan, seed, media, threads, progress))]
pub(crate) fn foretell_atlas(
    py: Python<'_>,
    plan: PathBuf,
    seed: u64,
    media: Vec<(String, String)>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Foretold> {
    let given = Given { media, seed: Some(seed), ..Given::default() };
    How::new(threads, progress).run(py, |progress| {
        let found = foretell(&opened(&plan, &given, Width::best(), progress)?, progress)?;
        let (bytes, memory) = (found.bytes, found.memory_bytes);
        Ok((
            found.cells,
            found.units,
            found.files,
            bytes,
            memory,
            found.cores,
            found.cell_seconds,
            found.seconds,
        ))
    })
}
