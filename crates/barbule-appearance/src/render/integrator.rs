//! Unidirectional spectral path tracing: a pure function of (pixel, sample, seed).
//!
//! At each point every light is sampled (of many some) and one direction from the BSDF; all are weighted by the balance
//! heuristic over these techniques and over the wavelengths that could have been the hero (Wilkie et al. 2014; the
//! bookkeeping of rescaled path densities follows pbrt-v4, ch. 13.4).

use glam::{DVec2, DVec3};

use super::accelerator::Beam;
use super::light::{Glow, Lighting};
use super::response::Response;
use super::sampler::Sampler;
use super::stage::Stage;
use super::window::{Inside, Met};
use crate::bsdf::{Bsdf, Hit, Lobes, Surface};
use crate::math::rng::split_mix;
use crate::scene::camera::{Camera, CameraRay, View};
use crate::spectrum::dense::WAVES;
use crate::spectrum::hero::{Hero, HeroDensity};
use crate::spectrum::sensor::{Band, Sensor};
use crate::{Error, Result};

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

/// How light is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transport {
    /// Most scatterings of a path.
    pub most_scatterings: u32,
    /// Which techniques gather light.
    pub technique: Technique,
    /// Whether the camera sees the lights that shine from infinity; without them what stands in the scene is cut out.
    pub shows_sky: bool,
}

impl Default for Transport {
    fn default() -> Self {
        Self { most_scatterings: 5, technique: Technique::Both, shows_sky: true }
    }
}

/// A stage under a lighting, seen by a camera. Making one costs nothing.
#[derive(Clone, Copy)]
pub struct Integrator<'a> {
    stage: &'a Stage,
    lighting: &'a Lighting,
    camera: &'a Camera,
    transport: Transport,
}

/// What the first hit of a sample was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstHit {
    /// Shading normal on the camera's side.
    pub normal: DVec3,
    /// Distance from the camera, mm.
    pub depth: f64,
    /// Identity of the shape, folded to 32 bits; 0 for nothing.
    pub id: u32,
    /// Index of its object.
    pub object: u32,
    /// Share of light from all directions that it scatters to the camera, at each wavelength: an estimate from one
    /// direction.
    pub albedo: [f64; WAVES],
}

/// One sample of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Spectral radiance over the wavelengths' densities, at each wavelength.
    pub radiance: [f64; WAVES],
    /// The wavelengths.
    pub hero: Hero,
    /// What was hit first.
    pub first: FirstHit,
    /// Where in the pixel it was taken, from its upper left corner, pixels.
    pub offset: [f64; 2],
    /// Rays that were traced: for the nearest hit, and for whether a light is seen.
    pub rays: [u32; 2],
    /// 1 where something was seen, 0 where the camera sees through the scene.
    pub alpha: f64,
}

/// Which sample of a picture is taken.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shot {
    /// Column and row of its pixel.
    pub(super) pixel: [u32; 2],
    /// Width and height of the picture, pixels.
    pub(super) size: [u32; 2],
    /// Its number in the pixel.
    pub(super) sample: u64,
    /// Seed of the picture.
    pub(super) seed: u64,
}

/// One sample of a pixel that sees no surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Behind<const LANES: usize> {
    /// What the sensor's channels answer to the light that is seen.
    pub(super) channels: [f64; LANES],
    /// As of a [`Sample`].
    pub(super) alpha: f64,
    /// As of a [`Sample`].
    pub(super) offset: [f64; 2],
}

/// Nothing was hit.
pub(super) const NO_HIT: FirstHit =
    FirstHit { normal: DVec3::ZERO, depth: 0.0, id: 0, object: 0, albedo: [0.0; WAVES] };

impl<'a> Integrator<'a> {
    /// Puts them together.
    #[must_use]
    pub fn new(stage: &'a Stage, lighting: &'a Lighting, camera: &'a Camera, transport: Transport) -> Self {
        Self { stage, lighting, camera, transport }
    }

    /// One sample of a pixel, of wavelengths for the human eye; `size` in pixels.
    #[must_use]
    pub fn sample(&self, pixel: [u32; 2], size: [u32; 2], sample: u64, seed: u64) -> Sample {
        self.seen(&self.camera.view(size), Shot { pixel, size, sample, seed }, Sensor::human().density())
    }

    /// Refuses a sensor that sees wavelengths for which a surface has no values.
    ///
    /// # Errors
    /// A surface whose tables end within the sensor's band.
    pub(super) fn check(&self, sensor: &Sensor) -> Result<()> {
        let (band, surfaces) = (sensor.band(), self.stage.objects().iter().map(|object| &object.surface));
        let short = |known: &Band| !(known.contains(band.low_nm()) && known.contains(band.high_nm()));
        match surfaces.filter_map(Surface::tabulated).find(short) {
            None => Ok(()),
            Some(known) => Err(Error::input(format!(
                "the scene's gratings and films are known from {} to {} nm, but the sensor '{}' sees {} to {} nm; leave them out",
                known.low_nm(),
                known.high_nm(),
                sensor.name(),
                band.low_nm(),
                band.high_nm()
            ))),
        }
    }

    /// What a sensor sees of the lights themselves.
    pub(super) fn glow(&self, response: &Response) -> Glow {
        self.lighting.glow(response)
    }

    /// The camera as [`Integrator::seen`] wants it.
    pub(super) fn view(&self, size: [u32; 2]) -> View {
        self.camera.view(size)
    }

    /// Whether a ray through the pixels from `low` to below `high` may meet a surface; where not, none does.
    pub(super) fn may_meet(&self, view: &View, low: [u32; 2], high: [u32; 2], size: [u32; 2]) -> bool {
        let point = |pixel: [u32; 2]| {
            DVec2::from_array(std::array::from_fn(|k| f64::from(pixel[k]) / f64::from(size[k])))
        };
        self.stage.may_meet(&Beam::about(&view.corners(point(low), point(high))))
    }

    /// As [`Integrator::sample`], with the camera prepared for the size. Inlined with all that it calls often, so that it is
    /// compiled for the caller's instructions.
    #[inline(always)]
    pub(super) fn seen(&self, view: &View, shot: Shot, density: &HeroDensity) -> Sample {
        let mut sampler = shot.sampler();
        let (offset, ray) = shot.aimed(view, &mut sampler);
        let [wavelength, ..] = sampler.next4();
        let hero = density.draw(wavelength);
        let mut path = Path::new(ray.origin, ray.direction, hero, [ray.footprint, ray.spread]);
        let mut first = NO_HIT;
        for depth in 0..=self.transport.most_scatterings {
            if !self.step(&mut path, depth, &mut sampler, &mut first) {
                break;
            }
        }
        let mut radiance = path.sum;
        for (value, pdf) in radiance.iter_mut().zip(hero.pdf) {
            *value /= pdf;
        }
        let alpha = if path.is_through { 0.0 } else { 1.0 };
        Sample { radiance, hero, first, offset, alpha, rays: path.rays }
    }

    /// The same of a ray that is known to meet no surface, without noise.
    #[inline(always)]
    pub(super) fn behind<const LANES: usize>(&self, view: &View, shot: Shot, glow: &Glow) -> Behind<LANES> {
        let (offset, ray) = shot.aimed(view, &mut shot.sampler());
        let (channels, is_lamp) = self.lighting.behind(glow, ray.origin, ray.direction);
        if is_lamp || self.transport.shows_sky {
            Behind { channels, alpha: 1.0, offset }
        } else {
            Behind { channels: [0.0; LANES], alpha: 0.0, offset }
        }
    }

    /// Follows the path to its next scattering; `false` when it ends.
    #[inline(always)]
    fn step(&self, path: &mut Path, depth: u32, sampler: &mut Sampler, first: &mut FirstHit) -> bool {
        let pass = if self.stage.is_opaque() { 1.0 } else { sampler.next4()[0] };
        let Some(met) = self.next_surface(path, pass) else {
            return false;
        };
        let hit = &met.hit;
        let bsdf = self.stage.met_surface(&met).bind(hit, -path.direction, path.hero.wavelengths);
        if depth == 0 {
            let id = split_mix(met.id()) as u32;
            *first = FirstHit {
                normal: bsdf.shading_normal(),
                depth: path.travelled,
                id: id.max(1),
                object: hit.object,
                ..NO_HIT
            };
        }
        if depth == self.transport.most_scatterings {
            return false;
        }
        let [u, v, component, roulette] = sampler.next4();
        if self.transport.technique != Technique::BsdfOnly {
            for draw in 0..self.lighting.draws() {
                let [choice, light_u, light_v, shadow] = sampler.next4();
                let index = self.lighting.choose(draw, choice);
                self.light(path, &met, &bsdf, index, DVec2::new(light_u, light_v), shadow);
            }
        }
        let Some(drawn) = bsdf.sample([u, v, component]) else {
            return false;
        };
        let evaluation = drawn.evaluation;
        let pdf = evaluation.pdf[0];
        if depth == 0 {
            // Each wavelength could have been the hero.
            let density = mean(&evaluation.pdf);
            first.albedo = evaluation.f.map(|f| f * evaluation.cosine / density);
        }
        path.scattered = true;
        // No light's sample could have found a single direction.
        let is_delta = drawn.lobes.has(Lobes::DELTA);
        path.through_lights = if is_delta { [0.0; WAVES] } else { path.through.map(|t| t / pdf) };
        for k in 0..WAVES {
            path.weight[k] *= evaluation.f[k] * evaluation.cosine / pdf;
            path.through[k] *= evaluation.pdf[k] / pdf;
        }
        path.origin = hit.position;
        path.direction = drawn.wi;
        path.inside = met.inside;
        let weight = path.weight.iter().copied().fold(0.0, f64::max) / mean(&path.through);
        let keep = (weight / ROULETTE_BELOW).min(1.0);
        if roulette >= keep {
            return false;
        }
        path.weight = path.weight.map(|w| w / keep);
        true
    }

    /// The next surface that scatters; adds the light seen when there is none or a light stands in front.
    #[inline(always)]
    fn next_surface(&self, path: &mut Path, mut pass: f64) -> Option<Met> {
        let nearest = self.stage.nearest_mm();
        if let Some(inside) = path.inside.take()
            && let Some(pane) = self.stage.pane(inside.object())
            && let Some(mut met) = pane.go_on(&inside, path.direction)
        {
            met.hit.set_footprint(path.footprint[0] + path.footprint[1] * path.travelled);
            return Some(met);
        }
        let mut from = if path.scattered { nearest } else { 0.0 };
        for _ in 0..MOST_PASSES {
            let lamp = self.lighting.hit(path.origin, path.direction, from);
            let farthest = lamp.map_or(f64::INFINITY, |(_, distance)| distance);
            path.rays[0] += 1;
            let Some(mut hit) = self.stage.hit(path.origin, path.direction, from, farthest) else {
                match lamp {
                    Some((index, _)) => {
                        let radiance = self.lighting.emitted(index, path.hero.wavelengths);
                        let (origin, direction) = (path.origin, path.direction);
                        self.arrive(path, radiance, || self.lighting.pdf(index, origin, direction));
                    }
                    None => self.escape(path),
                }
                return None;
            };
            let footprint = path.footprint[0] + path.footprint[1] * (path.travelled + hit.distance);
            if let Some(pane) = self.stage.pane(hit.object as usize) {
                if let Some(mut met) = pane.enter(&hit, path.direction) {
                    met.hit.set_footprint(footprint);
                    path.travelled += hit.distance;
                    return Some(met);
                }
            } else {
                hit.set_footprint(footprint);
                let through = self.transparency(&hit, path.direction);
                if pass >= through {
                    path.travelled += hit.distance;
                    return Some(Met { hit, inside: None });
                }
                // One number decides every pass: what is left of it is uniform again.
                pass /= through;
            }
            from = hit.distance + nearest;
        }
        None
    }

    /// Share of light that passes a hit unchanged.
    #[inline(always)]
    fn transparency(&self, hit: &Hit, direction: DVec3) -> f64 {
        if self.stage.is_opaque() {
            return 0.0;
        }
        1.0 - self.stage.surface(hit).opacity(hit, direction, -direction)
    }

    /// Adds what a path that leaves the scene sees.
    #[inline(always)]
    fn escape(&self, path: &mut Path) {
        if !path.scattered && !self.transport.shows_sky {
            path.is_through = true;
            return;
        }
        let (direction, wavelengths) = (path.direction, path.hero.wavelengths);
        self.lighting.escaped(direction, wavelengths, |radiance, far| {
            self.arrive(path, radiance, || self.lighting.far_pdf(far, direction));
        });
    }

    /// Adds the radiance of a light that the path ran into. `pdf`: density that the light's own samples would have had, 1/sr.
    #[inline(always)]
    fn arrive(&self, path: &mut Path, radiance: [f64; WAVES], pdf: impl FnOnce() -> f64) {
        if radiance == [0.0; WAVES] || (path.scattered && self.transport.technique == Technique::LightsOnly) {
            return;
        }
        let mut density = mean(&path.through);
        if path.scattered && self.transport.technique == Technique::Both {
            density += mean(&path.through_lights) * pdf();
        }
        path.add(radiance, density);
    }

    /// Adds the light of one lamp. `shadow` decides whether little light is worth a ray.
    #[inline(always)]
    fn light(&self, path: &mut Path, met: &Met, bsdf: &Bsdf<'_>, index: usize, u: DVec2, shadow: f64) {
        let wavelengths = path.hero.wavelengths;
        let Some(sample) = self.lighting.sample(index, met.hit.position, u, wavelengths) else { return };
        let evaluation = bsdf.eval(sample.direction);
        if evaluation.f == [0.0; WAVES] || sample.radiance == [0.0; WAVES] {
            return;
        }
        let pdf = sample.pdf;
        let has_rival = self.transport.technique == Technique::Both && !sample.is_point;
        let both = if has_rival { 1.0 / pdf } else { 0.0 };
        let densities: [f64; WAVES] =
            std::array::from_fn(|k| path.through[k] * (1.0 + both * evaluation.pdf[k]));
        let density = mean(&densities);
        let share = evaluation.cosine / pdf;
        let radiance: [f64; WAVES] = std::array::from_fn(|k| sample.radiance[k] * evaluation.f[k] * share);
        let most = (0..WAVES).fold(0.0, |most, k| f64::max(most, radiance[k] * path.weight[k])) / density;
        let keep = (most / SHADOW_BELOW).min(1.0);
        if shadow >= keep {
            return;
        }
        path.rays[1] += 1;
        let passed = self.passed(met, sample.direction, sample.distance);
        if passed > 0.0 {
            path.add(radiance.map(|r| r * passed / keep), density);
        }
    }

    /// Share of light that passes along a straight line from a hit: 1 free, 0 blocked.
    #[inline(always)]
    fn passed(&self, start: &Met, direction: DVec3, distance: f64) -> f64 {
        let (origin, nearest) = (start.hit.position, self.stage.nearest_mm());
        let farthest = distance - nearest;
        if self.lighting.hit(origin, direction, nearest).is_some_and(|(_, d)| d < farthest) {
            return 0.0;
        }
        if self.stage.is_opaque() {
            let blocked = self.stage.is_blocked(origin, direction, nearest, farthest);
            return if blocked { 0.0 } else { 1.0 };
        }
        if let Some(inside) = &start.inside
            && self.stage.pane(inside.object()).is_some_and(|pane| pane.is_blocked(inside, direction))
        {
            return 0.0;
        }
        let mut share = 1.0;
        let mut from = nearest;
        for _ in 0..MOST_PASSES {
            let Some(mut hit) = self.stage.hit(origin, direction, from, farthest) else {
                return share;
            };
            from = hit.distance + nearest;
            if let Some(pane) = self.stage.pane(hit.object as usize) {
                if pane.enter(&hit, direction).is_some() {
                    return 0.0;
                }
                continue;
            }
            hit.footprint = start.hit.footprint;
            share *= self.transparency(&hit, direction);
            if share == 0.0 {
                return 0.0;
            }
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
    weight: [f64; WAVES],
    /// Density of the path with each wavelength as hero over that with the true one.
    through: [f64; WAVES],
    /// The same with the last direction drawn from a light instead, per unit of the light's density.
    through_lights: [f64; WAVES],
    sum: [f64; WAVES],
    scattered: bool,
    /// Whether the camera saw through the scene.
    is_through: bool,
    /// Where in what a window shows it starts.
    inside: Option<Inside>,
    travelled: f64,
    footprint: [f64; 2],
    rays: [u32; 2],
}

impl Path {
    #[inline(always)]
    fn new(origin: DVec3, direction: DVec3, hero: Hero, footprint: [f64; 2]) -> Self {
        Self {
            origin,
            direction,
            hero,
            weight: [1.0; WAVES],
            through: [1.0; WAVES],
            through_lights: [0.0; WAVES],
            sum: [0.0; WAVES],
            scattered: false,
            is_through: false,
            inside: None,
            travelled: 0.0,
            footprint,
            rays: [0; 2],
        }
    }

    #[inline(always)]
    fn add(&mut self, radiance: [f64; WAVES], density: f64) {
        for (sum, (weight, value)) in self.sum.iter_mut().zip(self.weight.iter().zip(radiance)) {
            *sum += weight * value / density;
        }
    }
}

impl Shot {
    /// Its numbers.
    #[inline(always)]
    fn sampler(self) -> Sampler {
        let Self { pixel: [x, y], size, sample, seed } = self;
        Sampler::new(u64::from(y) * u64::from(size[0]) + u64::from(x), sample, seed)
    }

    /// Where in the pixel it is taken, and its ray.
    #[inline(always)]
    fn aimed(self, view: &View, sampler: &mut Sampler) -> ([f64; 2], CameraRay) {
        let Self { pixel, size, .. } = self;
        let [x, y, lens_u, lens_v] = sampler.next4();
        let point = DVec2::new(
            (f64::from(pixel[0]) + x) / f64::from(size[0]),
            (f64::from(pixel[1]) + y) / f64::from(size[1]),
        );
        ([x, y], view.ray(point, DVec2::new(lens_u, lens_v)))
    }
}

#[inline(always)]
fn mean(values: &[f64; WAVES]) -> f64 {
    values.iter().sum::<f64>() / WAVES as f64
}
