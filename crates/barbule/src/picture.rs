//! From a scene and a material to a picture in a file: what `barbule render` does, as library calls.

mod denoise;
mod parts;
mod quality;

use std::path::{Path, PathBuf};

pub use denoise::Cleaner;
pub use parts::{Joined, Parts, part_bytes_needed, part_path};
pub use quality::Quality;

use crate::error::shortened;
use crate::io::hash_bytes;
use crate::io::image::{Facts, encode_png, write_exr, write_png};
use crate::io::web::{write_jpeg, write_webp};
use crate::progress::Progress;
use crate::render::exposure;
use crate::render::film::{Film, bytes_per_pixel};
use crate::render::integrator::{Integrator, Transport};
use crate::render::light::Lighting;
use crate::render::picture::{self, Bytes, Development};
use crate::render::planes::{COVERS, Planes};
use crate::render::run::{Ended, Goal, run};
use crate::render::stage::Stage;
use crate::scene::backdrop::Backdrop;
use crate::scene::description::{
    Background, Exposure, LightShape, ReadyScene, SceneDescription, Tone, ToneWord,
};
use crate::scene::feather::{Counts, Feather};
use crate::scene::preset;
use crate::scene::sky::Environment;
use crate::spectrum::sensor::Sensor;
use crate::{Error, Result};

/// What all pictures of a scene share, made once: the objects with their hierarchy, and the sky. Lamps, camera and how the objects
/// are turned are each picture's own.
pub struct Set {
    stage: Stage,
    counts: Counts,
    lighting: Lighting,
    /// The sky about objects that are not turned.
    environment: Option<Environment>,
}

impl Set {
    /// Grows what stands in a scene.
    ///
    /// # Errors
    /// A number of the scene out of range, or a stop by `progress`.
    pub fn new(scene: &ReadyScene, seed: u64, progress: &dyn Progress) -> Result<Self> {
        let (objects, counts) = scene.objects_watched(seed, progress)?;
        let stage = Stage::watched(objects, progress)?;
        let environment = scene.environment()?;
        let lighting = Lighting::new(scene.lamps()?, environment.as_ref())?;
        Ok(Self { stage, counts, lighting, environment })
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
        scene: &ReadyScene,
        film: &mut Film,
        seed: u64,
        goal: Goal,
        progress: &dyn Progress,
        after_round: &mut dyn FnMut(&Film) -> Result<()>,
    ) -> Result<Ended> {
        let lighting = if scene.turn_deg == 0.0 {
            self.lighting.with_lamps(scene.lamps()?)?
        } else {
            let sky = self.environment.clone().map(|environment| scene.around_objects(environment));
            Lighting::new(scene.lamps()?, sky.as_ref())?
        };
        let camera = scene.camera();
        let transport = Transport {
            most_scatterings: scene.scatterings,
            shows_sky: scene.background == Background::Sky,
            ..Transport::default()
        };
        let integrator = Integrator::new(&self.stage, &lighting, &camera, transport);
        run(&integrator, film, seed, goal, progress, after_round)
    }
}

/// How a picture is made; the default is that of `barbule render`.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureOptions {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples per pixel; the most, where `noise` may end a tile earlier.
    pub samples: u32,
    /// As [`Goal::noise`].
    pub noise: Option<f64>,
    /// Seed of feather, instances and samples.
    pub seed: u64,
    /// Who sees it, and what else pixels keep.
    pub planes: Planes,
    /// Whether its noise is taken away.
    pub denoise: Denoise,
}

/// Whether and by what a picture's noise is taken away.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Denoise {
    /// It stays.
    #[default]
    No,
    /// By the Open Image Denoise that the system has.
    BySystem,
    /// By that in a file.
    By(PathBuf),
}

impl Denoise {
    /// What takes it away, if anything does.
    ///
    /// # Errors
    /// As [`Cleaner::load`].
    pub fn cleaner(&self) -> Result<Option<Cleaner>> {
        match self {
            Self::No => Ok(None),
            Self::BySystem => Cleaner::load(None).map(Some),
            Self::By(file) => Cleaner::load(Some(file)).map(Some),
        }
    }
}

impl Default for PictureOptions {
    fn default() -> Self {
        let (planes, denoise) = (Planes::default(), Denoise::default());
        Self { size: [1280, 800], samples: 16, noise: None, seed: 1, planes, denoise }
    }
}

/// A rendered picture.
#[derive(Debug, Clone)]
pub struct Picture {
    film: Film,
    development: Development,
    objects: Vec<String>,
}

impl Picture {
    /// Renders a scene of which everything is read, as `barbule render` does.
    ///
    /// # Errors
    /// A number of scene or options out of range, a denoiser that is not there, or a stop by `progress`.
    pub fn of(scene: &ReadyScene, options: &PictureOptions, progress: &dyn Progress) -> Result<Self> {
        let PictureOptions { size, samples, noise, seed, ref planes, ref denoise } = *options;
        let cleaner = denoise.cleaner()?;
        let set = Set::new(scene, seed, progress)?;
        let compositing = planes.compositing || cleaner.is_some();
        let mut film = Film::with(size, Planes { compositing, ..planes.clone() })?;
        let goal = Goal { noise, ..Goal::samples(samples) };
        match set.render(scene, &mut film, seed, goal, progress, &mut |_| Ok(()))? {
            Ended::Stopped => Err(Error::interrupted()),
            Ended::Done | Ended::OutOfTime => Self::developed(scene, film, cleaner.as_ref()),
        }
    }

    /// Develops a film of a scene.
    ///
    /// # Errors
    /// As [`development`], or of the denoiser.
    pub fn developed(scene: &ReadyScene, film: Film, cleaner: Option<&Cleaner>) -> Result<Self> {
        let mut development = development(scene, &film)?;
        development.denoised = cleaner.map(|cleaner| cleaner.clean(&film)).transpose()?;
        Ok(Self { film, development, objects: scene.object_names() })
    }

    /// CIE XYZ of its pixels without noise, row by row, where that was taken away.
    #[must_use]
    pub fn denoised(&self) -> Option<&[[f32; 3]]> {
        self.development.denoised.as_deref()
    }

    /// The film: what the sensor's channels saw, normals, depth and identities per pixel.
    #[must_use]
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// 8-bit sRGB, row by row, after exposure and tone curve; grey of a sensor without colours. Shape: `[height, width, 3]`.
    #[must_use]
    pub fn rgb(&self) -> Vec<u8> {
        let Bytes { values, has_alpha } = picture::bytes(&self.film, &self.development);
        if !has_alpha {
            return values;
        }
        values.chunks_exact(4).flat_map(|pixel| pixel[..3].to_vec()).collect()
    }

    /// The bytes of a PNG of it.
    ///
    /// # Errors
    /// None of a picture that has pixels.
    pub fn png(&self) -> Result<Vec<u8>> {
        let Bytes { values, has_alpha } = picture::bytes(&self.film, &self.development);
        encode_png(self.film.size(), &values, has_alpha, &[])
    }

    /// Writes the picture as `.png`, `.jpg` or `.webp`, or all its planes as `.exr`.
    ///
    /// # Errors
    /// Another ending, a picture other than an `.exr` of a sensor without colours, or the file cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let version = [("version", env!("CARGO_PKG_VERSION"))];
        Developed::new(path.as_ref(), &self.film, &self.development, &self.objects)?.write(&version)
    }
}

/// How a scene's film is developed: by the scene's exposure, or by what it shows where that gives none, before its background, with the scene's tone and
/// white.
///
/// # Errors
/// A white of lights that shine nowhere from above.
pub fn development(scene: &ReadyScene, film: &Film) -> Result<Development> {
    let exposure = scene.exposure.or_by(|| exposure::automatic(film));
    Ok(Development {
        backdrop: scene.backdrop()?,
        tone: scene.tone.0,
        balance: scene.white_balance.matrix(scene)?,
        ..Development::exposed(exposure)
    })
}

/// The program that renders nothing, bytes.
const PROGRAM: u64 = 26_000_000;

/// Memory that a picture of this size takes, bytes: its pixels while it is rendered or while it is written (the film, its planes
/// and their encoded bytes), and the program; what stands in the scene aside
/// ([`SceneDescription::bytes`](crate::scene::description::SceneDescription::bytes)).
#[must_use]
pub fn bytes_needed(size: [u32; 2], planes: &Planes) -> u64 {
    let rendered = bytes_per_pixel(planes);
    // A PNG has 4 bytes.
    let own = 2 * planes.sensor.channels().len();
    let channels = if planes.compositing { 14 + own + 4 * COVERS + planes.spectral.nm().len() } else { 1 };
    let written = rendered / 2 + 2 * channels * size_of::<f32>();
    PROGRAM + u64::from(size[0]) * u64::from(size[1]) * rendered.max(written) as u64
}

/// Refuses what no picture can be written as.
///
/// # Errors
/// The name ends in none of `.png`, `.jpg`, `.jpeg`, `.webp` and `.exr`.
pub fn check_kind(path: &Path) -> Result<()> {
    match extension(path).as_str() {
        "png" | "jpg" | "jpeg" | "webp" | "exr" => Ok(()),
        _ => Err(Error::input(format!(
            "{}: pictures are written as .png, .jpg, .webp or .exr",
            path.display()
        ))),
    }
}

/// Refuses a JPEG for a picture that is cut out: it knows no alpha.
///
/// # Errors
/// It is that.
pub fn check_alpha(path: &Path, background: &Background) -> Result<()> {
    if *background == Background::None && is_jpeg(path) {
        return Err(Error::input(format!(
            "{}: a JPEG cannot be cut out; write .png, .webp or .exr, or give another background",
            path.display()
        )));
    }
    Ok(())
}

/// Refuses a name that does not end in `.exr` for what a sensor without colours sees.
///
/// # Errors
/// It is that.
pub fn check_colours(path: &Path, sensor: &Sensor) -> Result<()> {
    if is_exr(path) || sensor.has_colours() {
        return Ok(());
    }
    Err(Error::input(format!(
        "{}: the sensor '{}' does not say how its channels look on a screen (to_xyz); write them as .exr",
        path.display(),
        shortened(sensor.name())
    )))
}

/// What of a film goes into a file.
enum Pixels {
    /// 8-bit sRGB, row by row: a PNG, JPEG or WebP.
    Screen(Bytes),
    /// All planes, linear.
    Exr(picture::Planes),
}

/// A film as the file that it will be, without its metadata.
pub struct Developed<'a> {
    path: &'a Path,
    size: [u32; 2],
    pixels: Pixels,
}

impl<'a> Developed<'a> {
    /// Develops a film for a file: `.png`, `.jpg` or `.webp` (8 bits, after exposure and the tone curve) or `.exr` (all its planes, linear).
    /// `objects`: the names of the scene's objects, for mattes.
    ///
    /// # Errors
    /// As [`check_kind`], [`check_colours`] and [`check_alpha`].
    pub fn new(path: &'a Path, film: &Film, development: &Development, objects: &[String]) -> Result<Self> {
        check_kind(path)?;
        check_colours(path, &film.planes().sensor)?;
        if development.backdrop == Backdrop::None {
            check_alpha(path, &Background::None)?;
        }
        let pixels = if is_exr(path) {
            Pixels::Exr(picture::planes(film, development, objects))
        } else {
            Pixels::Screen(picture::bytes(film, development))
        };
        Ok(Self { path, size: film.size(), pixels })
    }

    /// BLAKE3 of the pixels alone, hexadecimal: equal where pictures are, whatever their metadata say. Of a PNG or WebP, of its bytes
    /// row by row, of a JPEG of those that it was made from; of an EXR, of each plane's 32-bit values, little-endian, row by row, in the order of the planes'
    /// names.
    #[must_use]
    pub fn pixel_hash(&self) -> String {
        let planes = match &self.pixels {
            Pixels::Screen(bytes) => return hash_bytes(&bytes.values),
            Pixels::Exr(planes) => planes,
        };
        let identities = &planes.identities;
        let mut names: Vec<(&str, Option<&[f32]>)> =
            planes.floats.iter().map(|plane| (plane.name.as_str(), Some(&plane.values[..]))).collect();
        names.push((&identities.name, None));
        names.sort_by_key(|(name, _)| *name);
        let mut hasher = blake3::Hasher::new();
        for (_, values) in names {
            match values {
                Some(values) => values.iter().for_each(|v| _ = hasher.update(&v.to_le_bytes())),
                None => identities.values.iter().for_each(|v| _ = hasher.update(&v.to_le_bytes())),
            }
        }
        hasher.finalize().to_hex().to_string()
    }

    /// Writes the file with its metadata.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(self, facts: &Facts<'_>) -> Result<()> {
        match self.pixels {
            Pixels::Screen(Bytes { values, has_alpha }) => match extension(self.path).as_str() {
                "webp" => write_webp(self.path, self.size, &values, has_alpha, facts),
                _ if is_jpeg(self.path) => write_jpeg(self.path, self.size, &values, facts),
                _ => write_png(self.path, self.size, &values, has_alpha, facts),
            },
            Pixels::Exr(picture::Planes { floats, identities, attributes }) => {
                let (names, values): (Vec<_>, Vec<_>) =
                    floats.into_iter().map(|plane| (plane.name, plane.values)).unzip();
                let floats = names.iter().map(String::as_str).zip(values).collect();
                let counts = vec![(identities.name.as_str(), identities.values)];
                let others: Vec<(&str, &str)> =
                    attributes.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
                write_exr(self.path, self.size, floats, counts, facts, &others)
            }
        }
    }
}

fn is_jpeg(path: &Path) -> bool {
    matches!(extension(path).as_str(), "jpg" | "jpeg")
}

/// Whether a picture of this name is written as EXR.
#[must_use]
pub fn is_exr(path: &Path) -> bool {
    extension(path) == "exr"
}

/// The scene that shows a material in which no scene is named: the preset of this name where there is one, else the `usual` one, in
/// softer light, on film, before a gradient and exposed by what it shows, since its own light and exposure are for another bird; with a feather
/// of one's own where there is such, in the same part of its vane and on no ground.
///
/// # Errors
/// There is no preset of the usual name, or one is no scene; never for those built in.
pub fn scene_for(own: Option<&str>, usual: &str, feather: Option<Feather>) -> Result<SceneDescription> {
    let own = own.filter(|own| preset::names().any(|name| name == *own));
    let mut scene = SceneDescription::named(own.unwrap_or(usual))?;
    if own.is_none() {
        in_the_studio(&mut scene);
    }
    if feather.is_some() {
        scene.leave_ground();
    }
    if let (Some(feather), Some(shown)) = (feather, scene.lone_feather_mut()) {
        shown.window.along_mm *= feather.shaft.length_mm / shown.feather.shaft.length_mm;
        shown.feather = feather;
    }
    Ok(scene)
}

/// Least angular radius of the lamps of a scene that shows what nobody has lit: barbules of which it is not known where they mirror are seen
/// by large lamps.
const SOFT_DEG: f64 = 8.0;

/// The colours behind such a scene, from the upper edge down.
const BEHIND: [[f64; 3]; 2] = [[0.42, 0.44, 0.46], [0.16, 0.17, 0.18]];

/// Large soft lamps, film, an exposure by a key and a gradient behind.
fn in_the_studio(scene: &mut SceneDescription) {
    scene.exposure = Exposure::AUTO;
    scene.tone = Tone(ToneWord::Filmic);
    scene.background = Background::Gradient(BEHIND.to_vec());
    scene.light.radius_deg = scene.light.radius_deg.max(SOFT_DEG);
    for light in &mut scene.lights {
        if let LightShape::Sun(sun) = &mut light.shape {
            sun.radius_deg = sun.radius_deg.max(SOFT_DEG);
        }
    }
}

fn extension(path: &Path) -> String {
    path.extension().map_or_else(String::new, |e| e.to_string_lossy().to_lowercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film() -> Film {
        Film::new([5, 3]).unwrap()
    }

    #[test]
    fn the_hash_of_pixels_is_that_of_what_a_reader_of_the_file_gets() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let hash = |facts: &Facts<'_>| {
            let developed = Developed::new(&path, &film(), &Development::exposed(1.0), &[]).unwrap();
            let hash = developed.pixel_hash();
            developed.write(facts).unwrap();
            hash
        };
        let written = hash(&[("seed", "1")]);
        let file = std::fs::read(&path).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&file)).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut rgb).unwrap();
        assert_eq!((rgb.len(), hash_bytes(&rgb)), (45, written.clone()));
        assert_eq!(hash(&[("seed", "2")]), written);
        assert_ne!(std::fs::read(&path).unwrap(), file);
        let exr = folder.path().join("a.exr");
        let developed = Developed::new(&exr, &film(), &Development::exposed(1.0), &[]).unwrap();
        assert_ne!(developed.pixel_hash(), written);
    }

    #[test]
    fn a_bird_of_ones_own_is_shown_as_the_nearest_preset() {
        let named = |name: &str| SceneDescription::named(name).unwrap();
        let shown = |usual: &str, own: Option<&str>| {
            let (scene, preset) = (scene_for(own, usual, None).unwrap(), named(usual));
            assert_eq!((&scene.objects, &scene.camera), (&preset.objects, &preset.camera));
            assert_eq!((scene.exposure, scene.tone), (Exposure::AUTO, Tone(ToneWord::Filmic)));
            assert_eq!(scene.light.bearing, preset.light.bearing);
            assert!(preset.light.radius_deg < SOFT_DEG && scene.light.radius_deg == SOFT_DEG);
            assert_eq!(scene.lights.len(), preset.lights.len());
            let is_soft =
                |light: &LightShape| matches!(light, LightShape::Sun(sun) if sun.radius_deg == SOFT_DEG);
            assert!(scene.lights.iter().all(|light| is_soft(&light.shape)));
        };
        assert_eq!(scene_for(Some("magpie"), "starling", None).unwrap(), named("magpie"));
        shown("mallard", Some("swallow"));
        shown("rock-dove", None);
        let lone = |scene: &SceneDescription| scene.lone_feather().unwrap().clone();
        let (mut feather, starling) = (lone(&named("peafowl")).feather, lone(&named("starling")));
        feather.shaft.length_mm = 2.0 * starling.feather.shaft.length_mm;
        let scene = scene_for(Some("starling"), "mallard", Some(feather)).unwrap();
        assert_eq!((lone(&scene).feather, &scene.camera), (feather, &named("starling").camera));
        assert_eq!(lone(&scene).window.along_mm, 2.0 * starling.window.along_mm);
        let whole = scene_for(Some("starling-feather"), "mallard", Some(lone(&scene).feather)).unwrap();
        assert_eq!(whole.objects.len(), 1, "another feather would stick in the preset's ground");
    }
}
