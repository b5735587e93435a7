//! What is to be traced: a scene with what it names, and in how many pixels and samples.

use std::collections::BTreeMap;
use std::path::PathBuf;

use barbule::campaign::Allowance;
use barbule::io::{Assets, Folder, Memory, available_memory};
use barbule::open::{self, Opening};
use barbule::picture::bytes_needed;
use barbule::progress::Progress;
use barbule::render::film::check_size;
use barbule::render::planes::Planes;
use barbule::resolve::{Worn, foretell_files, resolve};
use barbule::scene::description::{
    Exposure, ObjectDescription, ReadyScene, SceneDescription, SkyDescription, Surfaces, Tone, WhiteBalance,
};
use barbule::spectrum::sensor::Sensor;
use barbule::structure::{Side, SpeciesFile, Structure};
use barbule::{Error, Result};

use crate::live::{MaterialJob, material};

/// What of a scene takes less memory.
const SMALLER: &str =
    "a coarser detail.level, fewer variants of a coat, smaller meshes, or a smaller picture";

/// A picture to be traced.
#[derive(Debug, Clone)]
pub struct TraceJob {
    /// The scene, of which nothing need be read.
    pub scene: SceneDescription,
    /// Texts of files that it names, which lie in no folder, by their names: species with sizes that were moved, meshes.
    pub files: BTreeMap<String, String>,
    /// Where all others lie.
    pub folder: PathBuf,
    /// Who sees it.
    pub sensor: Sensor,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples per pixel.
    pub samples: u32,
    /// Whether its noise is taken away, where the system has Open Image Denoise.
    pub denoise: bool,
    /// Whether a hand still moves the camera: the exposure then stays, and what stands in the scene is as fine as it was.
    pub is_moving: bool,
    /// Whether a material that is not there is made wholly, which takes minutes; else coarsely, where anything may be computed.
    pub whole: bool,
    /// Media, cache and the seed of everything.
    pub opening: Opening,
}

/// What decides what stands in a scene.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Stand {
    objects: Vec<ObjectDescription>,
    surfaces: Surfaces,
    sky: SkyDescription,
    files: BTreeMap<String, String>,
    folder: PathBuf,
    seed: u64,
    may_compute: [bool; 2],
    /// Feathers are as fine as the picture's width asks for: their parts, and the memory that they take.
    level: (Vec<String>, u64),
}

impl Stand {
    /// The same but for how fine feathers are.
    fn but_for_its_level(&self, other: &Self) -> bool {
        let level = self.level.clone();
        *self == Self { level, ..other.clone() }
    }

    /// Whether what was grown for this serves a job.
    pub(super) fn serves(&self, job: &TraceJob) -> bool {
        let asked = job.stand();
        *self == asked || job.is_moving && self.but_for_its_level(&asked)
    }
}

/// Files in memory, and those of a folder.
struct Files {
    memory: Memory,
    folder: Folder,
}

impl Files {
    fn of(&self, name: &str) -> &dyn Assets {
        if self.memory.0.contains_key(name) { &self.memory } else { &self.folder }
    }
}

impl Assets for Files {
    fn read(&self, name: &str, largest: u64) -> Result<Vec<u8>> {
        self.of(name).read(name, largest)
    }

    fn beginning(&self, name: &str, most: usize) -> Option<(Vec<u8>, u64)> {
        self.of(name).beginning(name, most)
    }

    fn place(&self, name: &str) -> String {
        self.of(name).place(name)
    }
}

impl TraceJob {
    pub(super) fn stand(&self) -> Stand {
        let Self { scene, files, folder, opening, .. } = self;
        Stand {
            objects: scene.objects.clone(),
            surfaces: scene.surfaces.clone(),
            sky: scene.sky.clone(),
            files: files.clone(),
            folder: folder.clone(),
            seed: opening.seed,
            may_compute: [opening.may_compute, self.whole],
            level: (scene.object_names(), scene.bytes(&BTreeMap::new())),
        }
    }

    /// Whether a picture of this is one of the other's things too, if from elsewhere or in another light.
    pub(super) fn shows_the_same_as(&self, other: &Self) -> bool {
        self.stand().but_for_its_level(&other.stand())
    }

    /// Everything that decides its samples but their number.
    pub(super) fn samples_of(&self) -> SceneDescription {
        SceneDescription {
            size: None,
            exposure: Exposure::AUTO,
            tone: Tone::default(),
            white_balance: WhiteBalance::None,
            ..self.scene.clone()
        }
    }

    /// What pixels keep.
    pub(super) fn planes(&self) -> Planes {
        // A denoiser asks for albedo.
        Planes { sensor: self.sensor.clone(), compositing: self.denoise, ..Planes::default() }
    }

    fn assets(&self) -> Files {
        let bytes = self.files.iter().map(|(name, text)| (name.clone(), text.clone().into_bytes()));
        Files { memory: Memory(bytes.collect()), folder: Folder(self.folder.clone()) }
    }

    /// Memory that it takes at most, bytes: what stands in the scene while it grows, with its pictures, and two films. Files are looked at
    /// where they say at their beginning what they hold.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let [none, films] = self.film_bytes();
        let (foreseen, reading) = foretell_files(&self.scene, &self.assets(), self.opening.seed);
        self.scene.bytes(&foreseen) + films.max(none + reading)
    }

    /// Memory of the program without any film, and with two: one is developed while the other grows.
    fn film_bytes(&self) -> [u64; 2] {
        let planes = self.planes();
        let [none, one] = [[0; 2], self.size].map(|size| bytes_needed(size, &planes));
        [none, 2 * one - none]
    }

    /// Refuses what the machine has no memory for, and pictures of no size; `is_grown`: what stands in the scene is there.
    ///
    /// # Errors
    /// It is that.
    pub(super) fn check(&self, is_grown: bool) -> Result<()> {
        check_size(self.size)?;
        let free = available_memory().map_or(Allowance::UNKNOWN, |bytes| Allowance { bytes, asked: false });
        let [width, height] = self.size;
        let bytes = if is_grown { self.film_bytes()[1] } else { self.bytes() };
        free.check(&format!("this scene in {width}x{height} pixels"), bytes, SMALLER)
    }

    /// The scene with everything read that it names, and by how much the coarsest of its materials was thinned; what `known` has of the
    /// same objects, surfaces and sky is not read again.
    ///
    /// # Errors
    /// As [`resolve`] and [`open::material()`].
    pub(super) fn ready(
        &self,
        known: Option<&ReadyScene>,
        progress: &dyn Progress,
    ) -> Result<(ReadyScene, Option<usize>)> {
        let mut scene = self.scene.clone();
        if let Some(known) = known {
            scene.objects.clone_from(&known.objects);
            scene.surfaces.clone_from(&known.surfaces);
            scene.sky.clone_from(&known.sky);
        }
        let mut thinned = None;
        let mut dye = |name: &str| {
            let (worn, every) = self.worn(name, progress)?;
            thinned = thinned.max(every);
            Ok(worn)
        };
        let ready = resolve(scene, &self.assets(), &mut dye, self.opening.seed, progress)?;
        Ok((ready, thinned))
    }

    /// A material by its name, and by how much it was thinned.
    fn worn(&self, name: &str, progress: &dyn Progress) -> Result<(Worn, Option<usize>)> {
        if let Some(found) = open::material_file(name)?.filter(|_| !self.files.contains_key(name)) {
            return Ok((open::worn(&found.material, found.hash)?, None));
        }
        let structure = match self.own_species(name)? {
            Some(own) => own,
            None => open::structure(name, &self.opening, progress)?,
        };
        let job = MaterialJob { structure, opening: self.opening.clone(), whole: self.whole };
        let mut made = None;
        material(&job, progress, &mut |found| made = Some(found))?;
        let found = made.ok_or_else(|| {
            Error::input(format!(
                "the material {name} is not there yet; make it first, or let it be computed"
            ))
        })?;
        Ok((open::worn(&found.found.material, found.found.hash.clone())?, found.thinned))
    }

    /// The species of a file in memory, of which the lower side may be meant.
    fn own_species(&self, name: &str) -> Result<Option<Structure>> {
        let (file, is_below) = match name.strip_suffix(Side::BELOW) {
            Some(file) => (file, true),
            None => (name, false),
        };
        let Some(text) = self.files.get(file) else { return Ok(None) };
        let model = SpeciesFile::parse(text)
            .and_then(|species| species.model(None, self.opening.media.library().clone()))
            .map_err(|error| error.at(file))?;
        let upper = Structure::Species(Box::new(model));
        if is_below { upper.underside().map(Some) } else { Ok(Some(upper)) }
    }
}
