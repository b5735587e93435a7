//! Scenes and their pictures.

use std::path::PathBuf;

use barbule::export::scene::{ExportOptions, Exported};
use barbule::io::Folder;
use barbule::open::{self, material, worn};
use barbule::picture::{Denoise, Quality};
use barbule::progress::Progress;
use barbule::render::film::{Film, Pixel, check_size};
use barbule::render::planes::{Bands, Planes};
use barbule::scene::description::{
    Motion, Moved, ReadyScene, ToldLamp, Tone, ToneWord, USUAL_ARC_DEG, WhiteBalance,
};
use barbule::scene::preset;
use barbule::{Error, PictureOptions, Result, SceneDescription, Sensor, resolve};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::arrays::{check_count, shaped};
use crate::error::OrRaise as _;
use crate::opening::Given;
use crate::work::How;

/// Names of the presets and what they show.
#[pyfunction]
pub(crate) fn presets() -> Vec<(String, String)> {
    preset::names()
        .map(|name| (name.to_owned(), preset::about(name).unwrap_or_default().to_owned()))
        .collect()
}

/// A scene of which nothing is read yet that it names.
#[pyclass(frozen, module = "barbule._native")]
pub(crate) struct Scene {
    description: SceneDescription,
    folder: PathBuf,
}

/// How a scene is rendered, as Python says it.
pub(crate) struct Chosen<'a> {
    pub(crate) size: [u32; 2],
    pub(crate) samples: Option<u32>,
    pub(crate) noise: Option<f64>,
    pub(crate) quality: Option<&'a str>,
    pub(crate) seed: u64,
    pub(crate) spectral_nm: Vec<f64>,
    pub(crate) compositing: bool,
    pub(crate) denoise: bool,
    /// The denoiser's file; the system's without one.
    pub(crate) library: Option<PathBuf>,
}

impl Chosen<'_> {
    /// The same as the library takes it.
    ///
    /// # Errors
    /// A number out of range, or an unknown word.
    pub(crate) fn options(self) -> Result<PictureOptions> {
        let Chosen { size, samples, noise, quality, seed, spectral_nm, compositing, denoise, library } = self;
        check_count("samples", samples.unwrap_or(1) as usize, 1 << 24)?;
        check_size(size)?;
        if let Some(bad) = noise.filter(|noise| !(*noise > 0.0 && *noise <= 1.0)) {
            return Err(Error::input(format!("'noise' is {bad}; give a part over 0 and up to 1")));
        }
        let quality = quality.map(|word| Quality::named("'quality'", word)).transpose()?;
        let (samples, noise) = match quality {
            Some(quality) => quality.with(samples, noise),
            None => (samples.unwrap_or(if noise.is_some() { 4096 } else { 16 }), noise),
        };
        let denoise = match (denoise, library) {
            (false, _) => Denoise::No,
            (true, None) => Denoise::BySystem,
            (true, Some(file)) => Denoise::By(file),
        };
        let sensor = Sensor::human();
        let spectral = Bands::new(&spectral_nm, sensor.band()).map_err(|e| e.at("'spectral_nm'"))?;
        // A denoiser asks for albedo.
        let compositing = compositing || denoise != Denoise::No;
        let planes = Planes { sensor, compositing, spectral };
        Ok(PictureOptions { size, samples, noise, seed, planes, denoise })
    }
}

#[pymethods]
impl Scene {
    /// What `barbule render` takes: a preset, which may have several models, a scene file, a material or a structure.
    #[staticmethod]
    #[pyo3(signature = (text, model, media, progress))]
    fn open(
        py: Python<'_>,
        text: &str,
        model: Option<&str>,
        media: Vec<(String, String)>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let text = match model {
            Some(model) => &*preset::by_model(text, model).or_raise(py)?,
            None => text,
        };
        let opening = Given { media, ..Given::default() }.opening().or_raise(py)?;
        let how = How::new(None, progress);
        let description = how.run(py, |progress| open::description(text, &opening, progress))?;
        Ok(Self { description, folder: open::folder_of(text) })
    }

    /// A scene from the text of a scene file, whose files lie in `folder`.
    #[staticmethod]
    fn parse(py: Python<'_>, toml: &str, folder: PathBuf) -> PyResult<Self> {
        Ok(Self { description: SceneDescription::parse(toml).or_raise(py)?, folder })
    }

    /// The same scene with another material on its barbules.
    fn with_material(&self, name: &str) -> Self {
        let mut description = self.description.clone();
        description.set_material(name);
        Self { description, folder: self.folder.clone() }
    }

    /// The scenes of a sequence in which `light`, `camera` or `feather` swing over arcs in degrees; the light as usual without any.
    fn frames(&self, py: Python<'_>, count: u32, arcs: Vec<(String, f64)>) -> PyResult<Vec<Self>> {
        check_count("count", count as usize, 9999).or_raise(py)?;
        let arc = |(name, degrees): &(String, f64)| -> Result<(Moved, Motion)> {
            Ok((Moved::named("'arcs'", name)?, Motion::Arc(*degrees)))
        };
        let mut moves = arcs.iter().map(arc).collect::<Result<Vec<_>>>().or_raise(py)?;
        if moves.is_empty() {
            moves.push((Moved::Light, Motion::Arc(USUAL_ARC_DEG)));
        }
        let frames = self.description.frames(&moves, count).or_raise(py)?;
        Ok(frames.into_iter().map(|description| Self { description, folder: self.folder.clone() }).collect())
    }

    /// The folder in which the files lie that it names.
    #[getter]
    fn folder(&self) -> PathBuf {
        self.folder.clone()
    }

    /// The text of a scene file.
    fn toml(&self, py: Python<'_>) -> PyResult<String> {
        self.description.to_toml().or_raise(py)
    }

    /// Renders it.
    #[pyo3(signature = (size, samples, noise, quality, seed, spectral_nm, compositing, denoise, library, tone, white_balance, media, cache, threads, progress))]
    #[allow(clippy::too_many_arguments)] // they have names in Python
    fn render(
        &self,
        py: Python<'_>,
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
        media: Vec<(String, String)>,
        cache: Option<PathBuf>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Picture> {
        let chosen =
            Chosen { size, samples, noise, quality, seed, spectral_nm, compositing, denoise, library };
        let options = chosen.options().or_raise(py)?;
        let given = Given { media, cache, seed: Some(seed), may_compute: true };
        let developed = self.developed(tone, white_balance).or_raise(py)?;
        How::new(threads, progress).run(py, |progress| {
            let scene = developed.ready(&given, progress)?;
            let lamps = scene.told_lamps()?;
            Ok(Picture::new(barbule::Picture::of(&scene, &options, progress)?, lamps))
        })
    }

    /// Writes its files for Mitsuba into a folder; the tree of plugins as JSON.
    #[pyo3(signature = (folder, size, samples, seed, without, media, cache, progress))]
    #[allow(clippy::too_many_arguments)] // they have names in Python
    fn mitsuba(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        size: [u32; 2],
        samples: u32,
        seed: u64,
        without: Vec<String>,
        media: Vec<(String, String)>,
        cache: Option<PathBuf>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        check_count("samples", samples as usize, 1 << 24).or_raise(py)?;
        check_size(size).or_raise(py)?;
        let given = Given { media, cache, seed: Some(seed), may_compute: true };
        let options = ExportOptions { size, samples, seed, without };
        How::new(None, progress).run(py, |progress| {
            let ready = self.ready(&given, progress)?;
            Exported::new(&ready, options, progress)?.mitsuba_json(&folder)
        })
    }

    /// Width and height of its pictures, pixels, where it gives them.
    #[getter]
    fn size(&self) -> Option<(u32, u32)> {
        self.description.size.map(|[width, height]| (width, height))
    }
}

impl Scene {
    /// The scene with everything that it names.
    pub(crate) fn ready(&self, given: &Given, progress: &dyn Progress) -> Result<ReadyScene> {
        let opening = given.opening()?;
        let mut dye = |name: &str| {
            let found = material(name, &opening, progress)?;
            worn(&found.material, found.hash)
        };
        resolve(self.description.clone(), &Folder(self.folder.clone()), &mut dye, opening.seed, progress)
    }

    /// The same scene with another tone or white, where they are given.
    pub(crate) fn developed(&self, tone: Option<&str>, white_balance: Option<&str>) -> Result<Self> {
        let mut description = self.description.clone();
        if let Some(word) = tone {
            description.tone = Tone(ToneWord::named("'tone'", word)?);
        }
        if let Some(text) = white_balance {
            description.white_balance = WhiteBalance::parse(text).map_err(|e| e.at("'white_balance'"))?;
        }
        Ok(Self { description, folder: self.folder.clone() })
    }
}

/// A rendered picture: what a sensor saw, and what a screen shows of it.
///
/// Example:
///
///     >>> import barbule
///     >>> picture: barbule.Picture = barbule.render("starling", size=(16, 12), samples=1)
///     >>> picture.planes()["normal"].shape
///     (12, 16, 3)
#[pyclass(frozen, module = "barbule._native")]
pub(crate) struct Picture {
    inner: barbule::Picture,
    lamps: Vec<ToldLamp>,
}

impl Picture {
    pub(crate) fn new(inner: barbule::Picture, lamps: Vec<ToldLamp>) -> Self {
        Self { inner, lamps }
    }

    fn size(&self) -> [usize; 2] {
        self.inner.film().size().map(|side| side as usize)
    }

    /// An array `[row, column]` or `[row, column, k]` of what each pixel gives.
    fn plane<'py, T: numpy::Element + Copy>(
        &self,
        py: Python<'py>,
        of: impl Fn(&Film, u32, u32) -> Vec<T>,
        is_flat: bool,
    ) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
        let [width, height] = self.inner.film().size();
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let values: Vec<T> = places.flat_map(|(x, y)| of(self.inner.film(), x, y)).collect();
        let (rows, columns) = (height as usize, width as usize);
        let depth = values.len() / (rows * columns);
        let shape = [rows, columns, depth];
        shaped(py, values, if is_flat { &shape[..2] } else { &shape })
    }
}

#[pymethods]
impl Picture {
    /// 8-bit sRGB, `[row, column, 3]`.
    fn rgb<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<u8>>> {
        let [width, height] = self.size();
        shaped(py, py.detach(|| self.inner.rgb()), &[height, width, 3])
    }

    /// The planes by name.
    fn planes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        let film = self.inner.film();
        let per_hit = |pixel: &Pixel, value: f64| value / f64::from(pixel.hits.max(1));
        let single = |values: [f64; 3]| values.map(|value| value as f32).to_vec();
        all.set_item("xyz", self.plane(py, |film, x, y| single(film.xyz(x, y)), false)?)?;
        let [width, height] = self.size();
        let linear = film.linear_srgb().concat();
        all.set_item("linear_srgb", shaped(py, linear, &[height, width, 3])?)?;
        if let Some(smooth) = self.inner.denoised() {
            all.set_item("denoised_xyz", shaped(py, smooth.concat(), &[height, width, 3])?)?;
        }
        all.set_item("alpha", self.plane(py, |film, x, y| vec![film.alpha(x, y) as f32], true)?)?;
        let normal = |film: &Film, x, y| {
            let pixel = film.pixel(x, y);
            single(pixel.normal.map(|part| per_hit(pixel, part)))
        };
        all.set_item("normal", self.plane(py, normal, false)?)?;
        let depth = |film: &Film, x, y| {
            let pixel = film.pixel(x, y);
            vec![if pixel.hits == 0 { f32::INFINITY } else { per_hit(pixel, pixel.depth) as f32 }]
        };
        all.set_item("depth_mm", self.plane(py, depth, true)?)?;
        all.set_item("id", self.plane(py, |film, x, y| vec![film.pixel(x, y).id], true)?)?;
        let variance = |film: &Film, x, y| vec![film.variance(x, y) as f32];
        all.set_item("variance", self.plane(py, variance, true)?)?;
        if !film.planes().spectral.nm().is_empty() {
            let spectrum =
                |film: &Film, x, y| film.spectrum(x, y).into_iter().map(|v| v as f32).collect::<Vec<_>>();
            all.set_item("spectrum", self.plane(py, spectrum, false)?)?;
        }
        if film.planes().compositing {
            let albedo = |film: &Film, x, y| {
                let values = film.albedo(x, y).unwrap_or_default();
                values.into_iter().map(|value| value as f32).collect::<Vec<_>>()
            };
            all.set_item("albedo", self.plane(py, albedo, false)?)?;
        }
        Ok(all)
    }

    /// Width and height, pixels.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        let [width, height] = self.size();
        (height, width)
    }

    /// The scene's lights that shine: name, illuminant and correlated colour temperature, K.
    #[getter]
    fn lamps(&self) -> Vec<(String, String, Option<f64>)> {
        let told = |lamp: &ToldLamp| (lamp.name.clone(), lamp.illuminant.clone(), lamp.cct_k);
        self.lamps.iter().map(told).collect()
    }

    /// Wavelengths of the plane `spectrum`, nm.
    #[getter]
    fn spectral_nm(&self) -> Vec<f64> {
        self.inner.film().planes().spectral.nm().to_vec()
    }

    /// Writes `.png`, `.jpg`, `.webp`, or all planes as `.exr`.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| self.inner.save(path)).or_raise(py)
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| self.inner.png()).or_raise(py)?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn __repr__(&self) -> String {
        let [width, height] = self.size();
        format!("<barbule.Picture {width} × {height}>")
    }
}
