//! The renderer's speed in figures, on the scenes that other renderers are measured on.

use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use glam::{DVec3, DVec4};

use barbule::io::peak_memory;
use barbule::progress::Progress;
use barbule::render::film::Film;
use barbule::render::integrator::{Integrator, Transport};
use barbule::render::light::Lighting;
use barbule::render::run::{Ended, Goal, run};
use barbule::render::stage::Stage;
use barbule::scene::Scene;
use barbule::spectrum::colour::xyz_from_rgb;
use barbule::{Error, Result};

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
    /// Mean linear sRGB of the pictures.
    pub mean: [f64; 3],
    /// How far a pixel of one picture lies from its mean; `None` of a single run.
    pub noise: Option<Noise>,
}

/// Root mean square errors of a picture's pixels, found from how pictures of other seeds differ.
#[derive(Debug, Clone, Copy)]
pub struct Noise {
    /// Of linear sRGB.
    pub rgb: [f64; 3],
    /// Of luminance.
    pub luminance: f64,
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
    let mut pictures = Pictures::default();
    for number in 0..effort.runs {
        let mut film = Film::new(size)?;
        let (wall, cpu) = (Instant::now(), ProcessTime::now());
        let ended = run(&integrator, &mut film, seed + u64::from(number), goal, progress, &mut |_| Ok(()))?;
        times.push([cpu.elapsed(), wall.elapsed()]);
        if ended == Ended::Stopped {
            return Err(Error::interrupted());
        }
        pictures.add(&film.linear_srgb());
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
        mean: pictures.mean(),
        noise: pictures.noise(),
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

/// Sums over pictures of one scene with different seeds.
#[derive(Default)]
struct Pictures {
    count: u32,
    /// Linear sRGB and luminance of each pixel, and their squares.
    sums: Vec<[DVec4; 2]>,
}

impl Pictures {
    fn add(&mut self, picture: &[[f32; 3]]) {
        self.count += 1;
        self.sums.resize(picture.len(), [DVec4::ZERO; 2]);
        for ([sum, squares], pixel) in self.sums.iter_mut().zip(picture) {
            let rgb = pixel.map(f64::from);
            let [_, luminance, _] = xyz_from_rgb(rgb);
            let pixel = DVec3::from_array(rgb).extend(luminance);
            *sum += pixel;
            *squares += pixel * pixel;
        }
    }

    fn mean(&self) -> [f64; 3] {
        let total: DVec4 = self.sums.iter().map(|[sum, _]| *sum).sum();
        (total / (self.sums.len() as f64 * f64::from(self.count))).truncate().into()
    }

    fn noise(&self) -> Option<Noise> {
        let count = f64::from(self.count);
        let of_pixel = |[sum, squares]: &[DVec4; 2]| (*squares - *sum * *sum / count) / (count - 1.0);
        let total: DVec4 = self.sums.iter().map(of_pixel).sum();
        let [r, g, b, luminance] = (total / self.sums.len() as f64).to_array().map(|v| v.max(0.0).sqrt());
        (self.count > 1).then_some(Noise { rgb: [r, g, b], luminance })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two pixels of three pictures: variances by hand.
    #[test]
    fn noise_is_what_pictures_differ_by() {
        let mut pictures = Pictures::default();
        pictures.add(&[[0.0, 1.0, 0.5], [2.0; 3]]);
        assert!(pictures.noise().is_none());
        pictures.add(&[[3.0, 1.0, 0.5], [2.0; 3]]);
        pictures.add(&[[6.0, 1.0, 0.5], [2.0; 3]]);
        let noise = pictures.noise().unwrap();
        // The first pixel's red has the variance 9, all else none.
        assert!((noise.rgb[0] - 4.5_f64.sqrt()).abs() < 1e-12, "{noise:?}");
        assert!(noise.rgb[1] < 1e-12 && noise.rgb[2] < 1e-12, "{noise:?}");
        assert!((noise.luminance - 0.2126 * 4.5_f64.sqrt()).abs() < 1e-3, "{noise:?}");
        assert_eq!(pictures.mean(), [2.5, 1.5, 1.25]);
    }
}
