//! A small picture against a stored one: whatever changes what is seen, on purpose or not, shows here.
//!
//! After an intended change the reference is made again with
//! `cargo test --release -p barbule --test it picture -- --ignored`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use barbule::brdf::{FeatherBrdf, Options, example};
use barbule::io::image::{read_exr, write_exr};
use barbule::progress::Unobserved;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Transport};
use barbule::render::light::Lighting;
use barbule::render::run::{Goal, run};
use barbule::render::stage::Stage;
use barbule::scene::description::Description;

const SIZE: [u32; 2] = [64, 48];

/// Samples per pixel of the test and of the reference.
const SAMPLES: [u32; 2] = [64, 1024];

/// Side of the blocks that are compared, pixels.
const BLOCK: u32 = 8;

/// Part of the starling's close-up with the example's material.
fn picture(samples: u32, seed: u64) -> Film {
    let brdf = Arc::new(FeatherBrdf::new(&example(6), Options::default()).unwrap());
    let mut description = Description::named("starling").unwrap();
    description.window.radius_mm = 1.0;
    description.camera.width_mm = 1.2;
    let (scene, _) = description.scene(brdf, 1).unwrap();
    let stage = Stage::new(scene.objects).unwrap();
    let lighting = Lighting::new(scene.lamps, scene.environment.as_ref()).unwrap();
    let integrator = Integrator::new(&stage, &lighting, &scene.camera, Transport::default());
    let mut film = Film::new(SIZE).unwrap();
    let goal = Goal { samples, noise: None, time: None };
    run(&integrator, &mut film, seed, goal, &Unobserved, &mut |_| Ok(())).unwrap();
    film
}

fn reference() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it/data/starling.exr")
}

#[test]
#[ignore = "makes the stored picture again"]
fn make_the_reference() {
    let film = picture(SAMPLES[1], 1);
    let rgb = film.linear_srgb();
    let plane = |k: usize| rgb.iter().map(|p| p[k]).collect::<Vec<f32>>();
    write_exr(&reference(), SIZE, vec![("R", plane(0)), ("G", plane(1)), ("B", plane(2))], vec![], &[])
        .unwrap();
}

/// Blocks differ by their noise alone: the variance of the new picture plus the reference's, which has 16 times the
/// samples. Colour is compared over the whole picture.
#[test]
fn the_picture_is_the_stored_one_but_for_noise() {
    let film = picture(SAMPLES[0], 2);
    let stored = read_exr(&reference()).unwrap();
    assert_eq!(stored.size, SIZE.map(|s| s as usize));
    let rgb = film.linear_srgb();
    let luminance =
        |p: [f32; 3]| 0.2126 * f64::from(p[0]) + 0.7152 * f64::from(p[1]) + 0.0722 * f64::from(p[2]);
    let share = 1.0 + f64::from(SAMPLES[0]) / f64::from(SAMPLES[1]);
    let (mut squares, mut largest, mut blocks) = (0.0, 0.0_f64, 0.0);
    let (mut total, mut total_variance) = (0.0, 0.0);
    for top in (0..SIZE[1]).step_by(BLOCK as usize) {
        for left in (0..SIZE[0]).step_by(BLOCK as usize) {
            let (mut difference, mut variance) = (0.0, 0.0);
            for (x, y) in (top..top + BLOCK).flat_map(|y| (left..left + BLOCK).map(move |x| (x, y))) {
                let at = (y * SIZE[0] + x) as usize;
                difference += luminance(rgb[at]) - luminance(stored.pixels[at]);
                variance += share * film.variance(x, y);
            }
            let deviation = difference / variance.sqrt();
            squares += deviation * deviation;
            largest = largest.max(deviation.abs());
            blocks += 1.0;
            total += difference;
            total_variance += variance;
        }
    }
    let spread = f64::sqrt(squares / blocks);
    let whole = total / total_variance.sqrt();
    println!(
        "deviations of blocks: {spread:.2} on average, {largest:.2} at most; of the picture: {whole:.2}"
    );
    assert!(spread < 1.4 && largest < 5.0 && whole.abs() < 4.0, "{spread} {largest} {whole}");
    let mean = |pixels: &[[f32; 3]], k: usize| -> f64 { pixels.iter().map(|p| f64::from(p[k])).sum() };
    for k in 0..3 {
        let ratio = mean(&rgb, k) / mean(&stored.pixels, k);
        println!("channel {k}: {ratio:.4} of the stored mean");
        assert!((ratio - 1.0).abs() < 0.02, "channel {k}: {ratio}");
    }
}
