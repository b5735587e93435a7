//! The small picture that is held against a stored one.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use barbule::brdf::{FeatherBrdf, Options, example};
use barbule::progress::Unobserved;
use barbule::render::film::Film;
use barbule::render::integrator::Integrator;
use barbule::render::run::{Goal, run};
use barbule::scene::preset;

/// Pixels.
pub(crate) const SIZE: [u32; 2] = [64, 48];

/// Samples per pixel of the test and of the reference.
pub(crate) const SAMPLES: [u32; 2] = [64, 1024];

/// Part of the starling's close-up with the example's material.
pub(crate) fn picture(samples: u32, seed: u64) -> Film {
    let brdf = Arc::new(FeatherBrdf::new(&example(6), Options::default()).unwrap());
    let mut preset = preset::named("starling").unwrap();
    preset.window.radius_mm = 1.0;
    preset.width_mm = 1.2;
    let (scene, _) = preset.scene(brdf, 1).unwrap();
    let mut film = Film::new(SIZE).unwrap();
    let goal = Goal { samples, noise: None, time: None };
    run(&Integrator::new(&scene), &mut film, seed, goal, &Unobserved, &mut |_| Ok(())).unwrap();
    film
}

/// The stored picture.
pub(crate) fn reference() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it/data/starling.exr")
}
