//! How the error of a picture falls with the time that it takes: the table of docs/performance.md.
//!
//! `target/release/examples/render_error PRESET REFERENCE [WIDTHxHEIGHT]` (after `cargo build --release --workspace
//! --examples`). REFERENCE is a file of its own with 4096 samples per pixel, made when it is not there: minutes.

#![allow(clippy::print_stdout, clippy::unwrap_used)] // a program over what is built in

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use barbule::brdf::{FeatherBrdf, Options};
use barbule::io::decode_material;
use barbule::progress::Unobserved;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Transport};
use barbule::render::light::Lighting;
use barbule::render::run::{Goal, run};
use barbule::render::stage::Stage;
use barbule::scene::Scene;
use barbule::scene::description::SceneDescription;
use cpu_time::ProcessTime;

/// Of the reference.
const MANY: u32 = 4096;

/// Of pictures; the reference has another.
const SEED: u64 = 1;

struct Prepared {
    stage: Stage,
    lighting: Lighting,
    camera: barbule::scene::camera::Camera,
}

impl Prepared {
    /// The middle of the preset's picture: its pixels are those of the default size.
    fn new(preset: &str, size: [u32; 2]) -> barbule::Result<Self> {
        let mut description = SceneDescription::named(preset)?;
        description.camera.width_mm *= f64::from(size[0]) / 1280.0;
        let wanted = description.material.replace(':', "-");
        let (_, bytes) =
            barbule_materials::MATERIALS.iter().find(|(name, _)| name.starts_with(&wanted)).unwrap();
        let material = decode_material(bytes)?;
        let brdf = Arc::new(FeatherBrdf::new(&material, Options::default())?);
        let (Scene { objects, lamps, environment, camera }, _) = description.scene(brdf, 1)?;
        Ok(Self {
            stage: Stage::new(objects)?,
            lighting: Lighting::new(lamps, environment.as_ref())?,
            camera,
        })
    }

    /// Linear sRGB, and the CPU seconds that it took.
    fn picture(&self, size: [u32; 2], samples: u32, seed: u64) -> barbule::Result<(Vec<[f32; 3]>, f64)> {
        let integrator = Integrator::new(&self.stage, &self.lighting, &self.camera, Transport::default());
        let mut film = Film::new(size)?;
        let before = ProcessTime::now();
        let goal = Goal::samples(samples);
        run(&integrator, &mut film, seed, goal, &Unobserved, &mut |_| Ok(()))?;
        Ok((film.linear_srgb(), before.elapsed().as_secs_f64()))
    }
}

fn main() -> barbule::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [preset, file, rest @ ..] = &arguments[..] else {
        println!("render_error PRESET REFERENCE [WIDTHxHEIGHT]");
        return Ok(());
    };
    let size: Vec<u32> =
        rest.first().map_or("160x100", String::as_str).split('x').map(|side| side.parse().unwrap()).collect();
    let size = [size[0], size[1]];
    let begun = Instant::now();
    let prepared = Prepared::new(preset, size)?;
    println!("{preset}, {}x{}: ready in {:.1} s", size[0], size[1], begun.elapsed().as_secs_f64());
    let path = Path::new(file);
    if !path.exists() {
        let (picture, seconds) = prepared.picture(size, MANY, SEED + 1000)?;
        println!("reference of {MANY} samples: {seconds:.0} CPU s");
        let bytes: Vec<u8> = picture.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        barbule::io::write_whole(path, &bytes)?;
    }
    let bytes = std::fs::read(path).unwrap();
    let reference: Vec<f64> =
        bytes.as_chunks::<4>().0.iter().map(|v| f64::from(f32::from_le_bytes(*v))).collect();
    let power: f64 = reference.iter().map(|v| v * v).sum();
    println!("| samples | CPU s | relative RMSE | its grey part | its colour |");
    for samples in [4, 16, 64] {
        let (picture, seconds) = prepared.picture(size, samples, SEED)?;
        let apart: Vec<f64> =
            picture.as_flattened().iter().zip(&reference).map(|(v, r)| f64::from(*v) - r).collect();
        let whole: f64 = apart.iter().map(|d| d * d).sum();
        // The mean over the channels, and what they differ by from it.
        let grey: f64 = apart.chunks(3).map(|d| d.iter().sum::<f64>().powi(2) / 3.0).sum();
        let errors = [whole, grey, whole - grey].map(|sum| format!("{:.4}", (sum.max(0.0) / power).sqrt()));
        println!("| {samples} | {seconds:.2} | {} |", errors.join(" | "));
    }
    Ok(())
}
