//! How the error of a picture falls with the time that it takes: table and figure of docs/performance.md.
//!
//! `target/release/examples/render_error PRESET REFERENCE [WIDTHxHEIGHT] [-o FIGURE.svg]` (after `cargo build --release
//! --workspace --examples`). PRESET may also be `close-up`, the scene of the tests, which stays as it is. REFERENCE is a file of
//! its own with 4096 samples per pixel, made when it is not there: minutes. The figure has what was measured before paths
//! changed too, which is that close-up's at the usual size.

#![allow(clippy::print_stdout, clippy::unwrap_used)] // a program over what is built in

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use barbule::brdf::{FeatherBrdf, Options};
use barbule::io::{decode_material, write_whole};
use barbule::plot::{Axis, Curve, Figure, Format, Ink, Mark, Stroke};
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

/// Samples per pixel of the pictures.
const COUNTS: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];

/// Pictures of each, of which the middle one's time counts.
const RUNS: usize = 5;

/// CPU seconds and errors of earlier versions, of 4, 16 and 64 samples of the picture of 160 × 100 pixels.
const EARLIER: [(&str, [[f64; 2]; 3]); 2] = [
    ("four wavelengths, one light, one pixel", [[0.13, 0.94], [0.51, 0.45], [2.0, 0.203]]),
    ("eight wavelengths, every light, tent", [[0.19, 0.44], [0.70, 0.206], [3.0, 0.099]]),
];

struct Prepared {
    stage: Stage,
    lighting: Lighting,
    camera: barbule::scene::camera::Camera,
}

impl Prepared {
    /// The middle of the preset's picture: its pixels are those of the default size.
    fn new(preset: &str, size: [u32; 2]) -> barbule::Result<Self> {
        let mut description = match preset {
            "close-up" => SceneDescription::parse(include_str!("../../barbule/tests/it/data/close-up.toml"))?,
            _ => SceneDescription::named(preset)?,
        };
        description.camera.width_mm *= f64::from(size[0]) / 1280.0;
        let wanted = description.material().unwrap_or_default().replace(':', "-");
        let (_, bytes) = barbule_birds::materials().find(|(name, _)| name.starts_with(&wanted)).unwrap();
        let material = decode_material(bytes)?;
        let brdf = Arc::new(FeatherBrdf::new(&material, Options::default())?);
        let (Scene { objects, lamps, environment, camera }, _) = description.wearing(brdf)?.scene(1)?;
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

/// Errors against CPU seconds: earlier ones and `now`, CPU seconds and relative RMSE.
fn figure(title: &str, now: &[[f64; 2]]) -> Figure {
    let range = |label: &str, from, to| Axis { range: Some([from, to]), ..Axis::logarithmic(label) };
    let mut figure = Figure::new(
        title,
        range("CPU time of the picture (s)", 0.02, 5.0),
        range("relative RMSE of linear sRGB", 0.05, 2.0),
    );
    let both = |name: &str, points: Vec<[f64; 2]>| Curve { mark: Mark::Both, ..Curve::line(name, points) };
    figure.curves.extend(EARLIER.map(|(name, points)| both(name, points.to_vec())));
    figure.curves.push(both("the same, faster paths: now", now.to_vec()));
    let grey = Stroke::solid(Ink::of([150; 3]), 1.0);
    let root = vec![[0.02, 1.8], [5.0, 1.8 / 250_f64.sqrt()]];
    figure
        .curves
        .push(Curve { stroke: Some(grey), ..Curve::line("half the error in four times the time", root) });
    figure
}

fn main() -> barbule::Result<()> {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let drawn = arguments.iter().position(|word| word == "-o").map(|at| arguments.split_off(at));
    let [preset, file, rest @ ..] = &arguments[..] else {
        println!("render_error PRESET REFERENCE [WIDTHxHEIGHT] [-o FIGURE.svg]");
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
        write_whole(path, &bytes)?;
    }
    let bytes = std::fs::read(path).unwrap();
    let reference: Vec<f64> =
        bytes.as_chunks::<4>().0.iter().map(|v| f64::from(f32::from_le_bytes(*v))).collect();
    let power: f64 = reference.iter().map(|v| v * v).sum();
    println!("| samples | CPU s | relative RMSE | its grey part | its colour |");
    let mut now = Vec::new();
    for samples in COUNTS {
        let mut runs =
            (0..RUNS).map(|_| prepared.picture(size, samples, SEED)).collect::<barbule::Result<Vec<_>>>()?;
        runs.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (picture, seconds) = &runs[RUNS / 2];
        let apart: Vec<f64> =
            picture.as_flattened().iter().zip(&reference).map(|(v, r)| f64::from(*v) - r).collect();
        let whole: f64 = apart.iter().map(|d| d * d).sum();
        // The mean over the channels, and what they differ by from it.
        let grey: f64 = apart.chunks(3).map(|d| d.iter().sum::<f64>().powi(2) / 3.0).sum();
        let errors = [whole, grey, whole - grey].map(|sum| (sum.max(0.0) / power).sqrt());
        println!("| {samples} | {seconds:.3} | {} |", errors.map(|e| format!("{e:.4}")).join(" | "));
        now.push([*seconds, errors[0]]);
    }
    if let Some([_, name]) = drawn.as_deref() {
        let path = Path::new(name);
        let title = format!("{preset}, {} × {} pixels, 1 to 64 samples", size[0], size[1]);
        let name = path.file_name().unwrap_or_default().display();
        let command = format!("render_error {preset} REFERENCE -o {name}");
        let notes = [("command", command.as_str())];
        write_whole(path, &figure(&title, &now).draw().encode(Format::of(path)?, &notes)?)?;
    }
    Ok(())
}
