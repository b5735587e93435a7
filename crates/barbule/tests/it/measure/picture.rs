//! The small picture that is held against a stored one.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use barbule::brdf::fixtures::example;
use barbule::brdf::{FeatherBrdf, Options};
use barbule::progress::Unobserved;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Transport};
use barbule::render::light::Lighting;
use barbule::render::run::{Goal, run};
use barbule::render::stage::Stage;
use barbule::scene::description::SceneDescription;

/// Pixels.
pub(crate) const SIZE: [u32; 2] = [64, 48];

/// Samples per pixel of the test and of the reference.
pub(crate) const SAMPLES: [u32; 2] = [64, 1024];

/// A starling's feather in a light and a framing of the tests' own: presets may be composed anew.
pub(crate) fn close_up() -> SceneDescription {
    SceneDescription::parse(include_str!("../data/close-up.toml")).unwrap()
}

/// Part of the close-up with the example's material.
pub(crate) fn picture(samples: u32, seed: u64) -> Film {
    let brdf = Arc::new(FeatherBrdf::new(&example(6), Options::default()).unwrap());
    let mut description = close_up();
    description.lone_feather_mut().unwrap().window.radius_mm = Some(1.0);
    description.camera.width_mm = 1.2;
    let (scene, _) = description.wearing(brdf).unwrap().scene(1).unwrap();
    let stage = Stage::new(scene.objects).unwrap();
    let lighting = Lighting::new(scene.lamps, scene.environment.as_ref()).unwrap();
    let integrator = Integrator::new(&stage, &lighting, &scene.camera, Transport::default());
    let mut film = Film::new(SIZE).unwrap();
    let goal = Goal::samples(samples);
    run(&integrator, &mut film, seed, goal, &Unobserved, &mut |_| Ok(())).unwrap();
    film
}

/// The stored picture.
pub(crate) fn reference() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it/data/starling.exr")
}
