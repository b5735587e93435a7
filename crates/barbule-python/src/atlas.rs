//! Atlases: sweeps over sizes into one store.

use std::path::{Path, PathBuf};
use std::sync::Once;

use barbule::atlas::{Atlas, Plan, foretell, memory_bytes, run};
use barbule::campaign::Allowance;
use barbule::figures::{AtlasColours, atlas_map, atlas_page, claim_atlas_page, write_atlas_page};
use barbule::io::sweep::SweepStore;
use barbule::io::{available_memory, check_writable, write_whole};
use barbule::math::simd::Width;
use barbule::plot::{Format, Page};
use barbule::progress::{Progress, Shard};
use barbule::{Error, Result};
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

/// SIMD instructions by name; the widest of this processor without one.
fn width_of(simd: Option<&str>) -> Result<Width> {
    simd.map_or_else(|| Ok(Width::best()), Width::named)
}

/// Where a page and a picture of an atlas go.
struct Drawn {
    page: Option<PathBuf>,
    picture: Option<PathBuf>,
}

impl Drawn {
    /// Refuses before any work what cannot be written.
    fn check(&self, atlas: &Atlas) -> Result<()> {
        if let Some(picture) = &self.picture {
            AtlasColours::check(atlas)?;
            Format::of(picture)?;
            check_writable(picture)?;
        }
        let claimed = |page: &PathBuf| claim_atlas_page(page, atlas).map_err(|error| error.at("'page'"));
        self.page.as_ref().map_or(Ok(()), claimed)
    }

    fn draw(&self, atlas: &Atlas, store: &SweepStore) -> Result<()> {
        if let Some(picture) = &self.picture {
            let map = atlas_map(atlas.name(), atlas, &AtlasColours::read(atlas, store)?, &Page::default())?;
            write_whole(picture, &map.encode(Format::of(picture)?, &[])?)?;
        }
        self.page.as_ref().map_or(Ok(()), |page| write_atlas_page(page, &atlas_page(atlas, store, &[])?))
    }
}

/// Fills the store of a plan, or goes on with it.
#[pyfunction]
#[pyo3(signature = (plan, store, shard, seed, media, simd, cache, allowed_bytes, page, picture, threads, progress))]
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
    allowed_bytes: Option<u64>,
    page: Option<PathBuf>,
    picture: Option<PathBuf>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Done> {
    let given = Given { media, cache, seed: Some(seed), ..Given::default() };
    let width = width_of(simd.as_deref()).or_raise(py)?;
    let drawn = Drawn { page, picture };
    How::new(threads, progress).run(py, |progress| {
        let shard = Shard::new(shard.0, shard.1).map_err(|error| error.at("'shard'"))?;
        let atlas = opened(&plan, &given, width, progress)?;
        drawn.check(&atlas)?;
        let store = atlas.create(&store)?;
        let units = atlas.units(shard);
        if !(0..atlas.layout().units()).any(|unit| store.is_done(unit)) {
            let allowed = match allowed_bytes {
                Some(bytes) => Allowance { bytes, asked: true },
                None => {
                    available_memory().map_or(Allowance::UNKNOWN, |bytes| Allowance { bytes, asked: false })
                }
            };
            let needed = memory_bytes(&atlas, progress)?;
            allowed.check("the atlas", needed, "fewer angles, wavelengths or individuals")?;
        }
        let _announced = store.announce(shard);
        let outcome = run(&atlas, &store, &units, progress)?;
        drawn.draw(&atlas, &store)?;
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

/// An atlas with its store, whose units workers compute one by one.
#[pyclass(frozen, module = "barbule._native")]
pub(crate) struct AtlasUnits {
    atlas: Atlas,
    store: SweepStore,
    /// Done by the first unit: from then on others see that this process computes.
    announced: Once,
}

#[pymethods]
impl AtlasUnits {
    /// Opens a plan and creates its store, or opens it to go on.
    #[new]
    #[pyo3(signature = (plan, store, seed, media, simd))]
    fn new(
        py: Python<'_>,
        plan: PathBuf,
        store: PathBuf,
        seed: u64,
        media: Vec<(String, String)>,
        simd: Option<String>,
    ) -> PyResult<Self> {
        let given = Given { media, seed: Some(seed), ..Given::default() };
        let width = width_of(simd.as_deref()).or_raise(py)?;
        How::default().run(py, |progress| {
            let atlas = opened(&plan, &given, width, progress)?;
            let store = atlas.create(&store)?;
            Ok(Self { atlas, store, announced: Once::new() })
        })
    }

    /// The SIMD instructions that a store is computed with; `None` where there is none that can be read.
    #[staticmethod]
    fn simd_of(py: Python<'_>, store: PathBuf) -> Option<String> {
        py.detach(|| SweepStore::width_of(&store))
    }

    /// Seconds of a unit on one thread and memory of a process that computes on so many, bytes, foretold; takes seconds.
    #[pyo3(signature = (threads, progress))]
    fn foretell(&self, py: Python<'_>, threads: usize, progress: Option<Py<PyAny>>) -> PyResult<(f64, u64)> {
        let found = How::new(Some(threads), progress).run(py, |progress| foretell(&self.atlas, progress))?;
        Ok((found.core_hours() * 3600.0 / found.units as f64, found.memory_bytes))
    }

    /// Whether a unit is in the store and its checksums hold.
    fn is_done(&self, py: Python<'_>, unit: usize) -> bool {
        py.detach(|| unit < self.store.layout().units() && self.store.is_whole(unit))
    }

    /// Computes a unit, unless it is in the store.
    #[pyo3(signature = (unit, threads = Some(1), progress = None))]
    fn run(
        &self,
        py: Python<'_>,
        unit: usize,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        How::new(threads, progress).run(py, |progress| {
            let units = self.store.layout().units();
            if unit >= units {
                return Err(Error::input(format!("there is no unit {unit} of {units} (they count from 0)")));
            }
            self.announced.call_once(|| self.store.enter(Shard::WHOLE));
            run(&self.atlas, &self.store, &[unit], progress).map(drop)
        })
    }

    /// Ends the announcement that this process computes, and removes what writing needed, unless other processes still write.
    fn end(&self, py: Python<'_>) {
        py.detach(|| {
            self.store.leave();
            self.store.end_writing();
        });
    }

    fn __len__(&self) -> usize {
        self.store.layout().units()
    }

    fn __repr__(&self) -> String {
        format!("<barbule._native.AtlasUnits {}, {} units>", self.atlas.name(), self.__len__())
    }
}
