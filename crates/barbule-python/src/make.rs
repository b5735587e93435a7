//! Campaigns and fits: from structures to materials.

use std::path::PathBuf;

use barbule::brdf::fit::FitOptions;
use barbule::campaign::{Allowance, Demand, Keep, Resources, Results, run};
use barbule::characterize::{
    CampaignDescription, CampaignOptions, Execution, Found, Origin, Plan, as_filed, characterize as made_of,
    material_of,
};
use barbule::io::available_memory;
use barbule::io::store::Store;
use barbule::material::Library;
use barbule::progress::Shard;
use barbule::{Error, Result};
use pyo3::prelude::*;

use crate::error::OrRaise as _;
use crate::material::{Choices, Material};
use crate::opening::Given;
use crate::structure::Structure;
use crate::work::How;

/// What `options`, JSON, says of a campaign; what it leaves out is usual.
pub(crate) fn campaign(options: &str) -> Result<CampaignOptions> {
    serde_json::from_str(options).map_err(|error| Error::input(format!("the campaign's options: {error}")))
}

/// What a campaign may be computed with in so many bytes; in what the machine has left without them.
fn resources(plan: &Plan, results: Results, memory_bytes: Option<u64>) -> Result<Resources> {
    let allowed = match memory_bytes {
        Some(bytes) => Allowance { bytes, asked: true },
        None => available_memory().map_or(Allowance::UNKNOWN, |bytes| Allowance { bytes, asked: false }),
    };
    let units_at_once =
        Demand::units_allowed(&plan.structure, &plan.parameters, Keep::Statistics, results, allowed)?;
    Ok(Resources { units_at_once, ..Resources::default() })
}

/// Simulates a structure and fits its material.
#[pyfunction]
#[pyo3(signature = (structure, options, halo, sigma, store, cache, memory_bytes, threads, progress))]
#[allow(clippy::too_many_arguments)] // they have names in Python
pub(crate) fn characterize(
    py: Python<'_>,
    structure: &Structure,
    options: &str,
    halo: bool,
    sigma: Option<f64>,
    store: Option<PathBuf>,
    cache: Option<PathBuf>,
    memory_bytes: Option<u64>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Material> {
    let plan = campaign(options).and_then(|options| options.plan(structure.inner.clone())).or_raise(py)?;
    let catalog = Given { cache, ..Given::default() }.opening().or_raise(py)?.catalog;
    let usual = FitOptions::default();
    let fitted = FitOptions { halo, sigma: sigma.unwrap_or(usual.sigma), ..usual };
    let found = How::new(threads, progress).run(py, |progress| {
        let resources = resources(&plan, Results::Gathered, memory_bytes)?;
        let how = Execution { resources, store: store.as_deref() };
        let made = made_of(&plan, &fitted, &catalog, &how, progress)?;
        let (material, hash) = as_filed(&made.material)?;
        Ok(Found { material, hash, origin: Origin::Memory })
    })?;
    let media = match &structure.inner {
        barbule::Structure::Species(model) => model.library.clone(),
        _ => Library::default(),
    };
    Material::of(py, found, Choices::default(), media)
}

/// Fills a campaign's store, or goes on with it; how many units were computed and how many were there.
#[pyfunction]
#[pyo3(signature = (structure, path, options, keep_fields_nm, shard, cache, memory_bytes, threads, progress))]
#[allow(clippy::too_many_arguments)] // they have names in Python
pub(crate) fn simulate(
    py: Python<'_>,
    structure: &Structure,
    path: PathBuf,
    options: &str,
    keep_fields_nm: Vec<f64>,
    shard: (usize, usize),
    cache: Option<PathBuf>,
    memory_bytes: Option<u64>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(usize, usize)> {
    let plan = campaign(options).and_then(|options| options.plan(structure.inner.clone())).or_raise(py)?;
    let catalog = Given { cache, ..Given::default() }.opening().or_raise(py)?.catalog;
    How::new(threads, progress).run(py, |progress| {
        let resources = resources(&plan, Results::Stored, memory_bytes)?;
        let (number, of) = shard;
        if number >= of {
            return Err(Error::input(format!("'shard' is ({number}, {of}); give (i, n) with i below n")));
        }
        let shard = Shard::new(number, of)?;
        let store = plan.store(&path, &keep_fields_nm, &resources)?;
        let units = store.axes().shard(number, of);
        if units.iter().all(|unit| store.is_whole(unit.wavelength, unit.theta)) {
            // Nothing is prepared for nothing.
            if !store.damaged_coordinates().is_empty() {
                store.prepare_writing()?;
            }
            store.end_writing();
            return Ok((0, units.len()));
        }
        store.prepare_writing()?;
        let _announced = store.announce(shard);
        let campaign = plan.campaign(&resources, &catalog, progress)?;
        let outcome = run(&campaign, &units, &store, progress)?;
        Ok((outcome.computed, outcome.found))
    })
}

/// Fits the material of a finished store.
#[pyfunction]
#[pyo3(signature = (store, sigma, threads, progress))]
pub(crate) fn fit(
    py: Python<'_>,
    store: PathBuf,
    sigma: Option<f64>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Material> {
    let usual = FitOptions::default();
    let options = FitOptions { sigma: sigma.unwrap_or(usual.sigma), ..usual };
    let found = How::new(threads, progress).run(py, |progress| {
        let opened = Store::open(&store)?;
        let statistics = opened.statistics()?;
        let described = CampaignDescription::read(opened.description()).map_err(|e| e.in_file(&store))?;
        let (material, _) = material_of(&statistics, opened.name(), &described, &options, progress)?;
        let (material, hash) = as_filed(&material)?;
        Ok(Found { material, hash, origin: Origin::Memory })
    })?;
    Material::of(py, found, Choices::default(), Library::default())
}
