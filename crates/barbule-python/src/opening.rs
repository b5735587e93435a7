//! What people type, opened.

use std::path::{Path, PathBuf};

use barbule::campaign::Resources;
use barbule::characterize::Catalog;
use barbule::open::{Media, Opened, Opening, open as opened_as, stack};
use barbule::structure::{SpeciesFile, species_names};
use barbule::{Result, Stack};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::OrRaise as _;
use crate::material::Material;
use crate::structure;
use crate::work::How;

/// What decides how names are opened, as Python gives it.
#[derive(Default)]
pub(crate) struct Given {
    /// Media of the caller's own: names and files of n and k.
    pub(crate) media: Vec<(String, String)>,
    /// The cache folder; that of the command line without one.
    pub(crate) cache: Option<PathBuf>,
    /// Seed of what is simulated for a material.
    pub(crate) seed: Option<u64>,
    /// Whether a material that is not there may be made.
    pub(crate) may_compute: bool,
}

impl Given {
    pub(crate) fn opening(&self) -> Result<Opening> {
        let mut media = Media::default();
        for (name, file) in &self.media {
            media.add(name, Path::new(file))?;
        }
        let usual = Opening::default();
        let cache = self.cache.clone().or_else(|| barbule_cli::usual_cache_folder().ok());
        Ok(Opening {
            media,
            catalog: Catalog { cache },
            seed: self.seed.unwrap_or(usual.seed),
            may_compute: self.may_compute,
            resources: Resources::default(),
        })
    }

    /// A stack of the stack language, or a stack file.
    pub(crate) fn stack(&self, text: &str) -> Result<Stack> {
        stack(text, self.opening()?.media.library())
    }
}

/// Opens a structure or a material file.
#[pyfunction]
#[pyo3(signature = (text, media, threads, progress))]
pub(crate) fn open<'py>(
    py: Python<'py>,
    text: &str,
    media: Vec<(String, String)>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let given = Given { media, ..Given::default() };
    let opening = given.opening().or_raise(py)?;
    let opened = How::new(threads, progress).run(py, |progress| opened_as(text, &opening, progress))?;
    match opened {
        Opened::Material(found) => {
            let media = opening.media.library().clone();
            Ok(Bound::new(py, Material::of(py, *found, Default::default(), media)?)?.into_any())
        }
        Opened::Structure(found) => Ok(Bound::new(py, structure::Structure::of(found))?.into_any()),
        _ => Err(barbule::Error::input("this is nothing that Python can hold yet")).or_raise(py),
    }
}

/// All species with their variants: `{name: [variant, …]}`.
///
/// Example:
///
///     >>> import barbule
///     >>> "pink" in barbule.species()["starling"]
///     True
#[pyfunction]
pub(crate) fn species(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    for name in species_names() {
        let file = SpeciesFile::builtin(name).or_raise(py)?;
        all.set_item(name, file.variants().collect::<Vec<_>>())?;
    }
    Ok(all)
}
