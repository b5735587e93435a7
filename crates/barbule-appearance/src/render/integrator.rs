//! Unidirectional spectral path tracing: a pure function of (pixel, sample, seed).
//!
//! At each point one light is sampled and one direction from the BSDF; both are weighted by the balance heuristic over
//! both techniques and over the four wavelengths that could have been the hero (Wilkie et al. 2014; the bookkeeping of
//! rescaled path densities follows pbrt-v4, ch. 13.4).

use glam::{DVec2, DVec3};

use super::accelerator::Accelerator;
use super::bsdf::Bsdf;
use super::point::SurfacePoint;
use super::sampler::Sampler;
use super::wavelengths::Hero;
use crate::math::rng::split_mix;
use crate::scene::Scene;

/// Which techniques gather light: all for pictures, one alone for tests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Technique {
    /// Lights and BSDF together.
    Both,
    /// Only directions drawn from the BSDF.
    BsdfOnly,
    /// Only directions drawn from the lights (and lights that the camera sees).
    LightsOnly,
}

/// Points that a path may pass straight through without scattering.
const MOST_PASSES: u32 = 256;
/// Paths go on surely while their weight is above this and in proportion to it below: feathers absorb most light at
/// each bounce, and what is left is rarely worth a ray.
const ROULETTE_BELOW: f64 = 0.3;

/// Light that would add less radiance than this to its path (white under daylight has about 1) gets a shadow ray only
/// in proportion: most lamps lie far off a feather's narrow lobe. It adds at most this times the radiance itself to
/// the variance.
const SHADOW_BELOW: f64 = 0.02;

/// A scene ready for rays.
pub struct Integrator<'a> {
    scene: &'a Scene,
    accelerator: Accelerator,
    /// Nearest distance at which a ray that leaves a surface may hit another, mm.
    nearest: f64,
    /// Probability of choosing each light, and their cumulative sums.
    chances: Vec<f64>,
    technique: Technique,
}

/// What the first hit of a sample was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstHit {
    /// Shading normal on the camera's side.
    pub normal: DVec3,
    /// Distance from the camera, mm.
    pub depth: f64,
    /// Identity of the object, folded to 32 bits; 0 for nothing.
    pub id: u32,
}

/// One sample of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Spectral radiance over the wavelengths' densities, at each wavelength.
    pub radiance: [f64; 4],
    /// The wavelengths.
    pub hero: Hero,
    /// What was hit first.
    pub first: FirstHit,
}

/// Nothing was hit.
pub(super) const NO_HIT: FirstHit = FirstHit { normal: DVec3::ZERO, depth: 0.0, id: 0 };

impl<'a> Integrator<'a> {
    /// Builds the hierarchy of a scene.
    #[must_use]
    pub fn new(scene: &'a Scene) -> Self {
        Self::with_technique(scene, Technique::Both)
    }

    /// The same with a single technique.
    #[must_use]
    pub fn with_technique(scene: &'a Scene, technique: Technique) -> Self {
        let accelerator = Accelerator::new(&scene.geometry);
        let total: f64 = scene.lights.iter().map(|l| l.weight).sum();
        let chances = scene.lights.iter().map(|l| l.weight / total).collect();
        Self { scene, accelerator, nearest: scene.nearest_mm(), chances, technique }
    }

    /// One sample of a pixel; `size` in pixels.
    #[must_use]
    pub fn sample(&self, pixel: [u32; 2], size: [u32; 2], sample: u64, seed: u64) -> Sample {
        let index = u64::from(pixel[1]) * u64::from(size[0]) + u64::from(pixel[0]);
        let mut sampler = Sampler::new(index, sample, seed);
        let [x, y, lens_u, lens_v] = sampler.next4();
        let [wavelength, ..] = sampler.next4();
        let hero = Hero::new(wavelength);
        let point = DVec2::new(
            (f64::from(pixel[0]) + 0.5 + tent(x)) / f64::from(size[0]),
            (f64::from(pixel[1]) + 0.5 + tent(y)) / f64::from(size[1]),
        );
        let ray = self.scene.camera.ray(point, DVec2::new(lens_u, lens_v), size);
        let mut path = Path::new(ray.origin, ray.direction, hero, [ray.footprint, ray.spread]);
        let mut first = NO_HIT;
        for depth in 0..=self.scene.max_depth {
            if !self.step(&mut path, depth, &mut sampler, &mut first) {
                break;
            }
        }
        let mut radiance = path.sum;
        for (value, pdf) in radiance.iter_mut().zip(hero.pdf) {
            *value /= pdf;
        }
        Sample { radiance, hero, first }
    }

    /// Follows the path to its next scattering; `false` when it ends.
    fn step(&self, path: &mut Path, depth: u32, sampler: &mut Sampler, first: &mut FirstHit) -> bool {
        let pass = if self.scene.passes_light() { sampler.next4()[0] } else { 1.0 };
        let Some(point) = self.next_surface(path, pass) else {
            return false;
        };
        let surface = &self.scene.surfaces[point.surface as usize];
        let bsdf = Bsdf::new(surface, &point, -path.direction, path.hero.nm);
        if depth == 0 {
            let id = split_mix(point.object) as u32;
            *first = FirstHit { normal: bsdf.shading_normal(), depth: path.travelled, id: id.max(1) };
        }
        if depth == self.scene.max_depth {
            return false;
        }
        let [light_choice, light_u, light_v, roulette] = sampler.next4();
        let [u, v, component, shadow] = sampler.next4();
        if self.technique != Technique::BsdfOnly {
            self.light(path, &point, &bsdf, light_choice, DVec2::new(light_u, light_v), shadow);
        }
        let Some((direction, evaluation)) = bsdf.sample([u, v, component]) else {
            return false;
        };
        let pdf = evaluation.pdf[0];
        path.scattered = true;
        path.through_lights = path.through.map(|t| t / pdf);
        for k in 0..4 {
            path.weight[k] *= evaluation.f[k] * evaluation.cosine / pdf;
            path.through[k] *= evaluation.pdf[k] / pdf;
        }
        path.origin = point.position;
        path.direction = direction;
        let weight = path.weight.iter().copied().fold(0.0, f64::max) / mean(&path.through);
        let keep = (weight / ROULETTE_BELOW).min(1.0);
        if roulette >= keep {
            return false;
        }
        path.weight = path.weight.map(|w| w / keep);
        true
    }

    /// The next surface that scatters; adds the light seen when there is none or a light stands in front.
    fn next_surface(&self, path: &mut Path, mut pass: f64) -> Option<SurfacePoint> {
        let mut from = if path.scattered { self.nearest } else { 0.0 };
        for _ in 0..MOST_PASSES {
            let lamp = self.nearest_lamp(path.origin, path.direction, from);
            let farthest = lamp.map_or(f64::INFINITY, |(_, distance)| distance);
            let hit = self.accelerator.hit(&self.scene.geometry, path.origin, path.direction, from, farthest);
            let Some(mut point) = hit else {
                match lamp {
                    Some((index, _)) => {
                        let radiance = self.scene.lights[index].light.emitted(path.hero.nm);
                        self.arrive(path, index, radiance);
                    }
                    None => self.escape(path),
                }
                return None;
            };
            let surface = &self.scene.surfaces[point.surface as usize];
            let through = surface.passes();
            point.footprint = path.footprint[0] + path.footprint[1] * (path.travelled + point.distance);
            if pass >= through {
                path.travelled += point.distance;
                return Some(point);
            }
            // One number decides every pass: what is left of it is uniform again.
            pass /= through;
            from = point.distance + self.nearest;
        }
        None
    }

    fn nearest_lamp(&self, origin: DVec3, direction: DVec3, from: f64) -> Option<(usize, f64)> {
        let mut best: Option<(usize, f64)> = None;
        for (index, lamp) in self.scene.lights.iter().enumerate() {
            if let Some(distance) = lamp.light.hit(origin, direction)
                && distance > from
                && best.is_none_or(|(_, nearest)| distance < nearest)
            {
                best = Some((index, distance));
            }
        }
        best
    }

    /// Adds what a path that leaves the scene sees.
    fn escape(&self, path: &mut Path) {
        for index in 0..self.scene.lights.len() {
            let light = &self.scene.lights[index].light;
            if light.is_infinite() {
                let radiance = light.escaped(path.direction, path.hero.nm);
                self.arrive(path, index, radiance);
            }
        }
    }

    /// Adds the radiance of a light that the path ran into.
    fn arrive(&self, path: &mut Path, index: usize, radiance: [f64; 4]) {
        if radiance == [0.0; 4] || (path.scattered && self.technique == Technique::LightsOnly) {
            return;
        }
        let mut density = mean(&path.through);
        if path.scattered && self.technique == Technique::Both {
            let pdf = self.chances[index] * self.scene.lights[index].light.pdf(path.origin, path.direction);
            density += mean(&path.through_lights) * pdf;
        }
        path.add(radiance, density);
    }

    /// Adds the light of one lamp, chosen by its weight. `shadow` decides whether little light is worth a ray.
    fn light(
        &self,
        path: &mut Path,
        point: &SurfacePoint,
        bsdf: &Bsdf<'_>,
        mut choice: f64,
        u: DVec2,
        shadow: f64,
    ) {
        let mut index = 0;
        while index + 1 < self.chances.len() && choice >= self.chances[index] {
            choice -= self.chances[index];
            index += 1;
        }
        let Some(chance) = self.chances.get(index) else { return };
        let light = &self.scene.lights[index].light;
        let Some(sample) = light.sample(point.position, u, path.hero.nm) else { return };
        let evaluation = bsdf.eval(sample.direction);
        if evaluation.f == [0.0; 4] || sample.radiance == [0.0; 4] {
            return;
        }
        let pdf = chance * sample.pdf;
        let both = if self.technique == Technique::Both { 1.0 / pdf } else { 0.0 };
        let densities: [f64; 4] = std::array::from_fn(|k| path.through[k] * (1.0 + both * evaluation.pdf[k]));
        let density = mean(&densities);
        let share = evaluation.cosine / pdf;
        let radiance: [f64; 4] = std::array::from_fn(|k| sample.radiance[k] * evaluation.f[k] * share);
        let most = (0..4).fold(0.0, |most, k| f64::max(most, radiance[k] * path.weight[k])) / density;
        let keep = (most / SHADOW_BELOW).min(1.0);
        if shadow >= keep {
            return;
        }
        let passed = self.passed(point.position, sample.direction, sample.distance);
        if passed > 0.0 {
            path.add(radiance.map(|r| r * passed / keep), density);
        }
    }

    /// Share of light that passes along a straight line: 1 free, 0 blocked.
    fn passed(&self, origin: DVec3, direction: DVec3, distance: f64) -> f64 {
        let farthest = distance - self.nearest;
        if self.nearest_lamp(origin, direction, self.nearest).is_some_and(|(_, d)| d < farthest) {
            return 0.0;
        }
        if !self.scene.passes_light() {
            let blocked = self.accelerator.is_blocked(origin, direction, self.nearest, farthest);
            return if blocked { 0.0 } else { 1.0 };
        }
        let mut share = 1.0;
        let mut from = self.nearest;
        for _ in 0..MOST_PASSES {
            let Some(point) = self.accelerator.hit(&self.scene.geometry, origin, direction, from, farthest)
            else {
                return share;
            };
            let surface = &self.scene.surfaces[point.surface as usize];
            share *= surface.passes();
            if share == 0.0 {
                return 0.0;
            }
            from = point.distance + self.nearest;
        }
        0.0
    }
}

/// The state of one path.
struct Path {
    origin: DVec3,
    direction: DVec3,
    hero: Hero,
    /// Throughput over the hero's density, at each wavelength.
    weight: [f64; 4],
    /// Density of the path with each wavelength as hero over that with the true one.
    through: [f64; 4],
    /// The same with the last direction drawn from a light instead, per unit of the light's density.
    through_lights: [f64; 4],
    sum: [f64; 4],
    scattered: bool,
    travelled: f64,
    footprint: [f64; 2],
}

impl Path {
    fn new(origin: DVec3, direction: DVec3, hero: Hero, footprint: [f64; 2]) -> Self {
        Self {
            origin,
            direction,
            hero,
            weight: [1.0; 4],
            through: [1.0; 4],
            through_lights: [0.0; 4],
            sum: [0.0; 4],
            scattered: false,
            travelled: 0.0,
            footprint,
        }
    }

    fn add(&mut self, radiance: [f64; 4], density: f64) {
        for (sum, (weight, value)) in self.sum.iter_mut().zip(self.weight.iter().zip(radiance)) {
            *sum += weight * value / density;
        }
    }
}

fn mean(values: &[f64; 4]) -> f64 {
    0.25 * (values[0] + values[1] + values[2] + values[3])
}

/// A tent of half width 1 about 0, from a uniform number: the reconstruction filter.
fn tent(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() }
}
