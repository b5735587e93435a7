//! Levels of detail: the same patch of a vane, barbule by barbule, as stretches of rows, and as a surface.

use std::sync::Arc;

use barbule::SceneDescription;
use barbule::brdf::fixtures::example;
use barbule::brdf::{FeatherBrdf, Options};
use barbule::math::rng::Stream;
use barbule::progress::Unobserved;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Transport};
use barbule::render::light::Lighting;
use barbule::render::run::{Goal, run};
use barbule::render::stage::Stage;
use barbule::scene::emission::Emission;
use barbule::scene::sky::{Environment, Sky};
use glam::DVec3;

/// Three millimetres of a starling's vane beside its shaft, seen from above and from both sides.
const PATCH: &str = "[window]
radius_mm = 3.0
[camera]
projection = 'orthographic'
lens = 0.0
roll_deg = 0.0
width_mm = 1.0
target_mm = [1.1, 0.8, 0.0]
elevation_deg = 60.0
";
const AZIMUTHS: [f64; 4] = [180.0, 270.0, 0.0, 90.0];
const SIDE: u32 = 32;

/// Mean X, Y and Z of the patch under each light, over the cameras and two feathers, which grow once for all lights.
fn means(level: &str, extra: &str) -> [[f64; 3]; 2] {
    let brdf = Arc::new(FeatherBrdf::new(&example(3), Options::default()).unwrap());
    let mut sums = [[0.0; 3]; 2];
    for seed in [1, 2] {
        let text = |light: &str| {
            format!("preset = 'starling'\nlights = []\n{light}\n{PATCH}[detail]\nlevel = '{level}'\n{extra}")
        };
        let scene = SceneDescription::parse(&text(SKY)).unwrap().wearing(brdf.clone()).unwrap();
        let (objects, counts) = scene.objects(seed).unwrap();
        assert!(level == "vane" || counts.barbules > 5000, "{counts:?}");
        let stage = Stage::new(objects).unwrap();
        for ((light, samples), sum) in LIGHTS.into_iter().zip(&mut sums) {
            let lit = SceneDescription::parse(&text(light)).unwrap().wearing(brdf.clone()).unwrap();
            let lighting = Lighting::new(lit.lamps().unwrap(), lit.environment().unwrap().as_ref()).unwrap();
            for azimuth in AZIMUTHS {
                let turned = text(light).replace(
                    "elevation_deg = 60.0\n",
                    &format!("elevation_deg = 60.0\nazimuth_deg = {azimuth}\n"),
                );
                let camera = SceneDescription::parse(&turned).unwrap().camera();
                let integrator = Integrator::new(&stage, &lighting, &camera, Transport::default());
                let mut film = Film::new([SIDE; 2]).unwrap();
                run(&integrator, &mut film, seed, Goal::samples(samples), &Unobserved, &mut |_| Ok(()))
                    .unwrap();
                for pixel in 0..SIDE * SIDE {
                    let xyz = film.xyz(pixel % SIDE, pixel / SIDE);
                    (0..3).for_each(|k| sum[k] += xyz[k]);
                }
            }
        }
    }
    sums
}

const SKY: &str = "sky = 1.0\n[light]\nstrength = 0.0";
const SOFT_LAMP: &str =
    "sky = 0.0\n[light]\nazimuth_deg = 20.0\nelevation_deg = 62.0\nradius_deg = 30.0\nstrength = 3.0";
/// With samples of a pixel: noise is that of the lamp alone.
const LIGHTS: [(&str, u32); 2] = [(SKY, 6), (SOFT_LAMP, 24)];
/// Light passes plain barbules, and most of what is seen was scattered several times.
const PLAIN: &str = "[surfaces.barbule]
longitudinal_roughness = 0.3
azimuthal_roughness = 0.4
eumelanin = 0.1
height_over_width = 0.7
[surfaces.hair]
longitudinal_roughness = 0.3
azimuthal_roughness = 0.4
eumelanin = 0.1
";

/// Stretches of rows and windows onto swatches: means of X, Y and Z. Each level draws its own barbules, so they differ as two feathers
/// would, by 0.03 at most here.
#[test]
fn levels_look_like_barbules_that_grew_one_by_one() {
    for extra in ["", PLAIN] {
        let expected = means("barbules", extra);
        for level in ["barbs", "vane"] {
            let found = means(level, extra);
            for ((light, _), (found, expected)) in LIGHTS.into_iter().zip(found.iter().zip(&expected)) {
                let apart = [0, 1, 2].map(|k| found[k] / expected[k] - 1.0);
                assert!(apart.iter().all(|d| d.abs() < 0.03), "{level} {light} {extra} {apart:.4?}");
            }
        }
    }
}

/// A primary's vane is closed: of light along its normal hardly any passes, between barbules of stretches as between those that grew.
#[test]
fn light_along_the_normal_hardly_passes_a_flight_feather() {
    for level in ["barbules", "barbs"] {
        let text = format!(
            "preset = 'osprey'\n[feather]\ntype = 'primary'\n[feather.splits]\nmean_count = 0.0\n[window]\nwhole = false\n\
             along_mm = 90.0\nradius_mm = 8.0\n[detail]\nlevel = '{level}'"
        );
        let scene = SceneDescription::parse(&text).unwrap();
        let (objects, _) = scene.clone().wearing(None).unwrap().objects(1).unwrap();
        let stage = Stage::new(objects).unwrap();
        let mut stream = Stream::new(81, &[]);
        let count = 20_000;
        let met = (0..count)
            .filter(|_| {
                // The trailing vane's closed part, off the shaft and its outline.
                let from = DVec3::new(stream.uniform(2.5, 5.0), stream.uniform(-2.0, 2.0), 20.0);
                stage.hit(from, DVec3::NEG_Z, 0.0, 100.0).is_some()
            })
            .count();
        let share = met as f64 / f64::from(count);
        assert!(share >= 0.97, "{level}: {share}");
    }
}

/// Without pigment all light that a vane takes in comes out again, whichever way it goes: under the same light from everywhere it vanishes.
/// What is left, 0.0011 at most, is the noise of the roulette.
#[test]
fn clear_feathers_vanish_in_a_white_furnace() {
    let clear = PLAIN.replace("eumelanin = 0.1", "eumelanin = 0.0\npheomelanin = 0.0");
    for level in ["barbules", "barbs", "vane"] {
        let text = format!(
            "preset = 'starling'\nlights = []\nscatterings = 1000\n{SKY}\n{PATCH}[detail]\nlevel = '{level}'\n{clear}"
        );
        let scene = SceneDescription::parse(&text).unwrap();
        let (objects, _) = scene.clone().wearing(None).unwrap().objects(1).unwrap();
        // The vane alone: shafts are pigmented.
        let stage = Stage::new(objects.into_iter().skip(1).collect()).unwrap();
        let sky = Sky::grey(64, 32, Emission::daylight(), |_| 1.0).unwrap();
        let lighting = Lighting::new(Vec::new(), Some(&Environment { sky, weight: 1.0 })).unwrap();
        let camera = scene.camera();
        let transport = Transport { most_scatterings: scene.scatterings, ..Transport::default() };
        let integrator = Integrator::new(&stage, &lighting, &camera, transport);
        let mut film = Film::new([SIDE; 2]).unwrap();
        run(&integrator, &mut film, 3, Goal::samples(32), &Unobserved, &mut |_| Ok(())).unwrap();
        let hits: u32 = (0..SIDE * SIDE).map(|k| film.pixel(k % SIDE, k / SIDE).hits).sum();
        let mean =
            (0..SIDE * SIDE).map(|k| film.xyz(k % SIDE, k / SIDE)[1]).sum::<f64>() / f64::from(SIDE * SIDE);
        assert!((mean - 1.0).abs() < 0.004 && hits > SIDE * SIDE * 16, "{level}: {mean:.4}, {hits} hits");
    }
}
