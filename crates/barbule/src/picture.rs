//! From a scene and a material to a picture in a file: what `barbule render` does, as library calls.

use std::path::Path;
use std::sync::Arc;

use crate::brdf::{FeatherBrdf, FeatherMaterial, Options};
use crate::io::image::{Facts, write_exr, write_png};
use crate::progress::Progress;
use crate::render::film::{BYTES_PER_PIXEL, Film};
use crate::render::integrator::{Integrator, Transport};
use crate::render::light::Lighting;
use crate::render::picture;
use crate::render::run::{Ended, Goal, run};
use crate::render::stage::Stage;
use crate::scene::description::SceneDescription;
use crate::scene::feather::Counts;
use crate::scene::sky::Sky;
use crate::{Error, Result};

/// What all pictures of a scene share, made once: the feather with its hierarchy, and the sky. Key light and camera are
/// each picture's own.
pub struct Set {
    stage: Stage,
    counts: Counts,
    lighting: Lighting,
}

impl Set {
    /// Grows the feather of a scene; `sky` takes the place of the scene's own.
    ///
    /// # Errors
    /// A number of the scene out of range, or a scene whose sky is an image when none is given.
    pub fn new(
        scene: &SceneDescription,
        brdf: Arc<FeatherBrdf>,
        sky: Option<Sky>,
        seed: u64,
    ) -> Result<Self> {
        let (objects, counts) = scene.objects(brdf, seed)?;
        let stage = Stage::new(objects)?;
        let lighting = Lighting::new(scene.lamps(), Some(&scene.environment(sky)?))?;
        Ok(Self { stage, counts, lighting })
    }

    /// How many barbs and barbules there are.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Number of primitives that rays are tested against.
    #[must_use]
    pub fn primitives(&self) -> usize {
        self.stage.primitives()
    }

    /// Adds samples to a film, in the key light and to the camera of `scene`, until the goal is reached; the same bits
    /// for any number of threads and however often it was interrupted. `after_round` may keep the film.
    ///
    /// # Errors
    /// A goal or a lamp out of range, or what `after_round` returns.
    pub fn render(
        &self,
        scene: &SceneDescription,
        film: &mut Film,
        seed: u64,
        goal: Goal,
        progress: &dyn Progress,
        after_round: &mut dyn FnMut(&Film) -> Result<()>,
    ) -> Result<Ended> {
        let lighting = self.lighting.with_lamps(scene.lamps())?;
        let camera = scene.camera();
        let transport = Transport { most_scatterings: scene.scatterings, ..Transport::default() };
        let integrator = Integrator::new(&self.stage, &lighting, &camera, transport);
        run(&integrator, film, seed, goal, progress, after_round)
    }
}

/// How a picture is made; the default is that of `barbule render`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureOptions {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples per pixel.
    pub samples: u32,
    /// Seed of feather, instances and samples.
    pub seed: u64,
}

impl Default for PictureOptions {
    fn default() -> Self {
        Self { size: [1280, 800], samples: 16, seed: 1 }
    }
}

/// A rendered picture.
#[derive(Debug, Clone)]
pub struct Picture {
    film: Film,
    exposure: f64,
}

impl Picture {
    /// Renders a scene whose feather has this material.
    ///
    /// # Errors
    /// A number of scene or options out of range, or a stop by `progress`.
    pub fn of(
        scene: &SceneDescription,
        material: &FeatherMaterial,
        options: &PictureOptions,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let PictureOptions { size, samples, seed } = *options;
        let brdf = Arc::new(FeatherBrdf::new(material, Options::default())?);
        let set = Set::new(scene, brdf, None, seed)?;
        let mut film = Film::new(size)?;
        let goal = Goal { samples, noise: None, time: None };
        match set.render(scene, &mut film, seed, goal, progress, &mut |_| Ok(()))? {
            Ended::Stopped => Err(Error::interrupted()),
            Ended::Done | Ended::OutOfTime => Ok(Self { film, exposure: scene.exposure }),
        }
    }

    /// The film: linear radiance, normals, depth and identities per pixel.
    #[must_use]
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// 8-bit sRGB, row by row, after exposure and tone curve. Shape: `[height, width, 3]`.
    #[must_use]
    pub fn rgb(&self) -> Vec<u8> {
        picture::bytes(&self.film, self.exposure)
    }

    /// Writes the picture as `.png`, or all its planes as `.exr`.
    ///
    /// # Errors
    /// Another ending, or the file cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let version = [("barbule_version", env!("CARGO_PKG_VERSION"))];
        write_picture(path.as_ref(), &self.film, self.exposure, &version)
    }
}

/// Memory that a picture of this size takes, bytes: its pixels (afterwards their planes and encoded bytes, which are
/// fewer), and 64 MB for program, material and feather.
#[must_use]
pub fn bytes_needed(size: [u32; 2]) -> u64 {
    64_000_000 + u64::from(size[0]) * u64::from(size[1]) * BYTES_PER_PIXEL as u64
}

/// Refuses what no picture can be written as.
///
/// # Errors
/// The name ends in neither `.png` nor `.exr`.
pub fn check_kind(path: &Path) -> Result<()> {
    match extension(path).as_str() {
        "png" | "exr" => Ok(()),
        _ => Err(Error::input(format!("{}: pictures are written as .png or .exr", path.display()))),
    }
}

/// Writes a film as `.png` (8 bits, after `exposure` and the tone curve) or all its planes, linear, as `.exr`; `facts`
/// are its metadata.
///
/// # Errors
/// As [`check_kind`], or the file cannot be written.
pub fn write_picture(path: &Path, film: &Film, exposure: f64, facts: &Facts<'_>) -> Result<()> {
    check_kind(path)?;
    if extension(path) == "exr" {
        let (floats, ids) = picture::planes(film);
        let floats = floats.into_iter().map(|plane| (plane.name, plane.values)).collect();
        return write_exr(path, film.size(), floats, vec![(ids.name, ids.values)], facts);
    }
    write_png(path, film.size(), &picture::bytes(film, exposure), facts)
}

fn extension(path: &Path) -> String {
    path.extension().map_or_else(String::new, |e| e.to_string_lossy().to_lowercase())
}
