//! Pictures in parts, for workers on several machines.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use barbule::picture::{self, Set};
use barbule::progress::{MOST_SHARDS, Progress, Shard};
use barbule::render::film::{Film, TILE};
use barbule::render::run::{Ended, Goal, is_done};
use barbule::scene::description::ReadyScene;
use barbule::{Error, PictureOptions, Result};
use pyo3::prelude::*;

use crate::arrays::check_count;
use crate::error::OrRaise as _;
use crate::opening::Given;
use crate::scene::{Chosen, Picture, Scene};
use crate::work::How;

/// So many parts make a picture where nothing else is said.
const USUAL_PARTS: usize = 256;

/// A picture in parts of about equally many tiles, each a file beside it; the scene's hierarchy is made with the first part that is rendered.
#[pyclass(frozen, module = "barbule._native")]
pub(crate) struct Parts {
    scene: ReadyScene,
    options: PictureOptions,
    parts: picture::Parts,
    of: usize,
    set: Mutex<Option<Arc<Set>>>,
}

#[pymethods]
impl Parts {
    /// Reads all that the scene names; `tiles`: how many go into a part.
    #[new]
    #[pyo3(signature = (scene, output, size, samples, noise, quality, seed, spectral_nm, compositing, denoise, library, tone, white_balance, tiles, media, cache, threads, progress))]
    #[allow(clippy::too_many_arguments)] // they have names in Python
    fn new(
        py: Python<'_>,
        scene: &Scene,
        output: PathBuf,
        size: [u32; 2],
        samples: Option<u32>,
        noise: Option<f64>,
        quality: Option<&str>,
        seed: u64,
        spectral_nm: Vec<f64>,
        compositing: bool,
        denoise: bool,
        library: Option<PathBuf>,
        tone: Option<&str>,
        white_balance: Option<&str>,
        tiles: Option<usize>,
        media: Vec<(String, String)>,
        cache: Option<PathBuf>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let chosen =
            Chosen { size, samples, noise, quality, seed, spectral_nm, compositing, denoise, library };
        let options = chosen.options().or_raise(py)?;
        let of = parts_of(size, tiles).or_raise(py)?;
        let developed = scene.developed(tone, white_balance).or_raise(py)?;
        let given = Given { media, cache, seed: Some(seed), may_compute: true };
        How::new(threads, progress).run(py, |progress| {
            // One that is not there is missed before any work.
            options.denoise.cleaner()?;
            let scene = developed.ready(&given, progress)?;
            let goal = goal(&options);
            let parts = picture::Parts::new(&output, (&scene, seed), &goal, (size, &options.planes));
            Ok(Self { scene, options, parts, of, set: Mutex::new(None) })
        })
    }

    /// A hash of all that decides the parts.
    #[getter]
    fn name(&self) -> String {
        self.parts.name().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// Whether there is a file of a part, whatever it holds.
    fn is_there(&self, py: Python<'_>, number: usize) -> PyResult<bool> {
        let shard = self.shard(number).or_raise(py)?;
        Ok(py.detach(|| self.parts.path(shard).is_file()))
    }

    /// Grows what stands in the scene, which the first part does else; other threads wait for it.
    #[pyo3(signature = (threads, progress))]
    fn prepare(&self, py: Python<'_>, threads: Option<usize>, progress: Option<Py<PyAny>>) -> PyResult<()> {
        How::new(threads, progress).run(py, |progress| self.set(progress).map(|_| ()))
    }

    /// Renders what a part lacks, and keeps it; whether there was anything to do.
    #[pyo3(signature = (number, threads = Some(1), progress = None))]
    fn run(
        &self,
        py: Python<'_>,
        number: usize,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<bool> {
        let shard = self.shard(number).or_raise(py)?;
        How::new(threads, progress).run(py, |progress| self.rendered(shard, progress))
    }

    /// The picture; `None` where parts are missing, damaged or not done, with their numbers.
    #[pyo3(signature = (threads, progress))]
    fn join(
        &self,
        py: Python<'_>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(Option<Picture>, Vec<usize>)> {
        How::new(threads, progress).run(py, |progress| self.joined(progress))
    }

    /// Deletes the files of all parts.
    fn delete(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| self.shards().try_for_each(|shard| self.parts.delete(&[shard?]))).or_raise(py)
    }

    fn __len__(&self) -> usize {
        self.of
    }
}

impl Parts {
    fn shard(&self, number: usize) -> Result<Shard> {
        Shard::new(number, self.of)
    }

    fn shards(&self) -> impl Iterator<Item = Result<Shard>> + '_ {
        (0..self.of).map(|number| self.shard(number))
    }

    fn set(&self, progress: &dyn Progress) -> Result<Arc<Set>> {
        let mut set = self.set.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(set) = &*set {
            return Ok(set.clone());
        }
        Ok(set.insert(Arc::new(Set::new(&self.scene, self.options.seed, progress)?)).clone())
    }

    fn rendered(&self, shard: Shard, progress: &dyn Progress) -> Result<bool> {
        let goal = goal(&self.options);
        // What is damaged is rendered anew.
        let (mut film, _) = self.parts.film(shard)?;
        if is_done(&film, &goal) {
            return Ok(false);
        }
        let set = self.set(progress)?;
        let ended = set.render(&self.scene, &mut film, self.options.seed, goal, progress, &mut |_| Ok(()))?;
        if ended == Ended::Stopped {
            return Err(Error::interrupted());
        }
        self.parts.keep(&film)?;
        Ok(true)
    }

    fn joined(&self, progress: &dyn Progress) -> Result<(Option<Picture>, Vec<usize>)> {
        let PictureOptions { size, planes, denoise, .. } = &self.options;
        let (mut film, mut lacking) = (Film::with(*size, planes.clone())?, Vec::new());
        progress.begin("joining", self.of as u64);
        for shard in self.shards() {
            let shard = shard?;
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let (part, _) = self.parts.film(shard)?;
            if is_done(&part, &goal(&self.options)) {
                film.join(part)?;
            } else {
                lacking.push(shard.number());
            }
            progress.advance(1);
        }
        if !lacking.is_empty() {
            return Ok((None, lacking));
        }
        let cleaner = denoise.cleaner()?;
        let inner = barbule::Picture::developed(&self.scene, film, cleaner.as_ref())?;
        Ok((Some(Picture::new(inner, self.scene.told_lamps()?)), lacking))
    }
}

fn goal(options: &PictureOptions) -> Goal {
    Goal { noise: options.noise, ..Goal::samples(options.samples) }
}

/// How many parts there are.
fn parts_of(size: [u32; 2], tiles: Option<usize>) -> Result<usize> {
    let [across, down] = size.map(|side| side.div_ceil(TILE) as usize);
    let all = (across * down).max(1);
    let Some(tiles) = tiles else { return Ok(all.min(USUAL_PARTS)) };
    check_count("tiles", tiles, all)?;
    let of = all.div_ceil(tiles);
    if of > MOST_SHARDS {
        return Err(Error::input(format!(
            "'tiles' is {tiles}, which makes {of} parts; give at least {}",
            all.div_ceil(MOST_SHARDS)
        )));
    }
    Ok(of)
}
