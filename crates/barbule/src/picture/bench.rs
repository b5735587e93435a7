//! The renderer's speed in figures, on the scenes that other renderers are measured on.

use std::time::{Duration, Instant};

use cpu_time::ProcessTime;

use crate::io::peak_memory;
use crate::progress::Progress;
use crate::render::film::Film;
use crate::render::integrator::{Integrator, Transport};
use crate::render::light::Lighting;
use crate::render::run::{Ended, Goal, run};
use crate::render::stage::Stage;
use crate::scene::Scene;
use crate::{Error, Result};

/// What is rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Width and height of the picture, pixels.
    pub side: u32,
    /// Samples per pixel.
    pub samples: u32,
    /// Renders, of which the middle one by its CPU time counts.
    pub runs: u32,
}

impl Effort {
    /// A third of a million paths: for a look.
    pub const QUICK: Self = Self { side: 144, samples: 16, runs: 1 };
    /// Five times a million paths.
    pub const USUAL: Self = Self { side: 256, samples: 16, runs: 5 };
}

/// Scatterings of a path.
pub const SCATTERINGS: u32 = 7;

/// What a scene costs, with all threads at work.
#[derive(Debug, Clone)]
pub struct RenderFigures {
    /// Camera paths per CPU second.
    pub paths_per_cpu_second: f64,
    /// Camera paths per second.
    pub paths_per_second: f64,
    /// Rays per path that look for the nearest hit, the camera's among them.
    pub rays_per_path: f64,
    /// Rays per path that ask only whether a light is seen.
    pub shadow_rays_per_path: f64,
    /// Primitives that rays are tested against.
    pub primitives: usize,
    /// Bytes of the hierarchy, primitives included.
    pub hierarchy_bytes: usize,
    /// Wall seconds of building it.
    pub build_seconds: f64,
    /// The most bytes that the process held by the end.
    pub peak_bytes: Option<u64>,
    /// Mean linear sRGB of the picture.
    pub mean: [f64; 3],
}

/// Renders a scene a few times.
///
/// # Errors
/// Broken geometry, no light, an effort of nothing, or the user cancelled.
pub fn measure(scene: Scene, effort: Effort, seed: u64, progress: &dyn Progress) -> Result<RenderFigures> {
    if effort.runs == 0 {
        return Err(Error::input("a benchmark of no runs: give 1 or more"));
    }
    let Scene { objects, lamps, environment, camera } = scene;
    let begun = Instant::now();
    let stage = Stage::new(objects)?;
    let build_seconds = begun.elapsed().as_secs_f64();
    let lighting = Lighting::new(lamps, environment.as_ref())?;
    let transport = Transport { most_scatterings: SCATTERINGS, ..Transport::default() };
    let integrator = Integrator::new(&stage, &lighting, &camera, transport);
    let size = [effort.side; 2];
    let goal = Goal::samples(effort.samples);
    let mut times: Vec<[Duration; 2]> = Vec::new();
    let mut mean = [0.0; 3];
    for number in 0..effort.runs {
        let mut film = Film::new(size)?;
        let (wall, cpu) = (Instant::now(), ProcessTime::now());
        let ended = run(&integrator, &mut film, seed + u64::from(number), goal, progress, &mut |_| Ok(()))?;
        times.push([cpu.elapsed(), wall.elapsed()]);
        if ended == Ended::Stopped {
            return Err(Error::interrupted());
        }
        mean = mean_colour(&film);
    }
    times.sort();
    let [cpu, wall] = times[times.len() / 2].map(|time| time.as_secs_f64().max(1e-9));
    let paths = f64::from(effort.side) * f64::from(effort.side) * f64::from(effort.samples);
    let [rays, shadow_rays] = rays_per_path(&integrator, size, seed);
    Ok(RenderFigures {
        paths_per_cpu_second: paths / cpu,
        paths_per_second: paths / wall,
        rays_per_path: rays,
        shadow_rays_per_path: shadow_rays,
        primitives: stage.primitives(),
        hierarchy_bytes: stage.hierarchy_bytes(),
        build_seconds,
        peak_bytes: peak_memory(),
        mean,
    })
}

/// Of one sample in each pixel.
fn rays_per_path(integrator: &Integrator<'_>, size: [u32; 2], seed: u64) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for y in 0..size[1] {
        for x in 0..size[0] {
            let rays = integrator.sample([x, y], size, 0, seed).rays;
            sums = [sums[0] + f64::from(rays[0]), sums[1] + f64::from(rays[1])];
        }
    }
    sums.map(|sum| sum / (f64::from(size[0]) * f64::from(size[1])))
}

/// Mean linear sRGB of a film.
fn mean_colour(film: &Film) -> [f64; 3] {
    let pixels = film.linear_srgb();
    let sum = |k: usize| pixels.iter().map(|pixel| f64::from(pixel[k])).sum::<f64>();
    [0, 1, 2].map(|k| sum(k) / pixels.len() as f64)
}
