//! Materials, scenes and films in files of other programs.

use std::path::PathBuf;

use barbule::brdf::{FeatherBrdf, Options};
use barbule::export::{Format, Needs, Request, Source, export as written};
use barbule::progress::Progress;
use barbule::render::film::check_size;
use barbule::{Error, Result, open};
use pyo3::prelude::*;

use crate::arrays::check_count;
use crate::error::OrRaise as _;
use crate::material::Material;
use crate::opening::Given;
use crate::scene::Scene;
use crate::work::How;

/// What is exported: something that is open, or what people type.
#[derive(FromPyObject)]
pub(crate) enum What {
    Material(Py<Material>),
    Scene(Py<Scene>),
    Name(String),
}

/// Exports; what was written as JSON.
#[pyfunction]
#[pyo3(signature = (what, to, path, size_mb, picture, samples, without, seed, media, cache, threads, progress))]
#[allow(clippy::too_many_arguments)] // they have names in Python
pub(crate) fn export(
    py: Python<'_>,
    what: What,
    to: &str,
    path: PathBuf,
    size_mb: f64,
    picture: Option<[u32; 2]>,
    samples: u32,
    without: Vec<String>,
    seed: u64,
    media: Vec<(String, String)>,
    cache: Option<PathBuf>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let format = Format::named("'to'", to).or_raise(py)?;
    if !(1.0..=2000.0).contains(&size_mb) {
        return Err(Error::input(format!("'size_mb' is {size_mb}; give 1 to 2000"))).or_raise(py);
    }
    check_count("samples", samples as usize, 1 << 24).or_raise(py)?;
    picture.map_or(Ok(()), check_size).or_raise(py)?;
    let given = Given { media, cache, seed: Some(seed), may_compute: true };
    let order = Order { format, path, most_bytes: (size_mb * 1e6) as usize, picture, samples, without, seed };
    How::new(threads, progress).run(py, |progress| match &what {
        What::Material(material) => {
            let material = material.get();
            order.write(Source::Material(&material.brdf), &[("material_hash", &material.hash)], progress)
        }
        What::Scene(scene) => {
            order.write(Source::Scene(&scene.get().ready(&given, progress)?), &[], progress)
        }
        What::Name(name) => order.write_named(name, &given, progress),
    })
}

/// How something is exported.
struct Order {
    format: Format,
    path: PathBuf,
    most_bytes: usize,
    picture: Option<[u32; 2]>,
    samples: u32,
    without: Vec<String>,
    seed: u64,
}

impl Order {
    fn write(&self, source: Source<'_>, notes: &[(&str, &str)], progress: &dyn Progress) -> Result<String> {
        let notes = [&[("version", env!("CARGO_PKG_VERSION"))], notes].concat();
        let Self { format, ref path, most_bytes, picture, samples, ref without, seed } = *self;
        let request = Request { format, path, most_bytes, picture, samples, without, seed, notes: &notes };
        written(source, &request, progress).map(|written| written.json().to_string())
    }

    /// Opens what people type, as the format needs it.
    fn write_named(&self, name: &str, given: &Given, progress: &dyn Progress) -> Result<String> {
        let opening = given.opening()?;
        let exported = ("exported", name);
        match self.format.needs() {
            Needs::Material => {
                let found = open::material(name, &opening, progress)?;
                let brdf = FeatherBrdf::new(&found.material, Options::default())?;
                self.write(Source::Material(&brdf), &[exported, ("material_hash", &found.hash)], progress)
            }
            Needs::Scene => {
                self.write(Source::Scene(&open::scene(name, &opening, progress)?), &[exported], progress)
            }
            Needs::Stack => {
                let stack = open::film_stack(name, opening.media.library())?;
                self.write(Source::Stack(&stack, name), &[exported], progress)
            }
        }
    }
}
