//! A scene's lamps and sky, ready to be sampled. They know nothing of shapes: a lamp moves without a new hierarchy.

mod lamp;
mod sample;
mod sky;

use std::sync::Arc;

use glam::{DVec2, DVec3};

pub use sample::LightSample;
use sky::SkySampler;

use crate::scene::light::Lamp;
use crate::scene::sky::Environment;
use crate::spectrum::dense::Lambda4;
use crate::{Error, Result};

/// All lights of a scene. Each has an index: lamps in their order, then the sky.
#[derive(Debug, Clone)]
pub struct Lighting {
    lamps: Vec<Lamp>,
    sky: Option<Sky>,
    /// Lamps that stand in the scene, which rays can hit.
    standing: Vec<usize>,
    /// Probability of choosing each light.
    chances: Vec<f64>,
}

/// The sky and its weight.
#[derive(Debug, Clone)]
struct Sky {
    sampler: Arc<SkySampler>,
    weight: f64,
}

impl Lighting {
    /// Lamps and a sky; one light at least.
    ///
    /// # Errors
    /// No light, or a weight that is not positive.
    pub fn new(lamps: Vec<Lamp>, environment: Option<&Environment>) -> Result<Self> {
        let sky = environment.map(|environment| Sky {
            sampler: Arc::new(SkySampler::new(environment.sky.clone())),
            weight: environment.weight,
        });
        Self::of(lamps, sky)
    }

    /// Other lamps under the same sky, which is not prepared again.
    ///
    /// # Errors
    /// As [`Lighting::new`].
    pub fn with_lamps(&self, lamps: Vec<Lamp>) -> Result<Self> {
        Self::of(lamps, self.sky.clone())
    }

    fn of(lamps: Vec<Lamp>, sky: Option<Sky>) -> Result<Self> {
        let weights: Vec<f64> = lamps.iter().map(|l| l.weight).chain(sky.iter().map(|s| s.weight)).collect();
        if weights.is_empty() {
            return Err(Error::input("the scene has no light"));
        }
        if weights.iter().any(|weight| !(weight.is_finite() && *weight > 0.0)) {
            return Err(Error::input("a light's weight must be finite and greater than zero"));
        }
        let total: f64 = weights.iter().sum();
        let chances = weights.iter().map(|weight| weight / total).collect();
        let standing = (0..lamps.len()).filter(|&i| !lamps[i].light.is_infinite()).collect();
        Ok(Self { lamps, sky, standing, chances })
    }

    /// A light chosen by its weight from a uniform number, and the probability of that choice.
    #[inline]
    #[must_use]
    pub fn choose(&self, mut u: f64) -> (usize, f64) {
        let mut index = 0;
        while index + 1 < self.chances.len() && u >= self.chances[index] {
            u -= self.chances[index];
            index += 1;
        }
        (index, self.chances[index])
    }

    /// A direction from `point` towards a light; `None` where the light cannot be seen from there.
    #[must_use]
    pub fn sample(&self, light: usize, point: DVec3, u: DVec2, wavelengths: Lambda4) -> Option<LightSample> {
        match self.lamps.get(light) {
            Some(lamp) => lamp.light.sample(point, u, wavelengths),
            None => self.sky.as_ref()?.sampler.sample(u, wavelengths),
        }
    }

    /// Density of a direction, 1/sr, when the light is chosen and sampled, for a ray known to see it.
    #[must_use]
    pub fn pdf(&self, light: usize, point: DVec3, direction: DVec3) -> f64 {
        let pdf = match (self.lamps.get(light), &self.sky) {
            (Some(lamp), _) => lamp.light.pdf(point, direction),
            (None, Some(sky)) => sky.sampler.pdf(direction),
            (None, None) => 0.0,
        };
        self.chances[light] * pdf
    }

    /// The lights that a ray sees when it leaves the scene, with their radiance.
    pub fn escaped(
        &self,
        direction: DVec3,
        wavelengths: Lambda4,
    ) -> impl Iterator<Item = (usize, [f64; 4])> + '_ {
        let lamps = self.lamps.iter().enumerate();
        let infinite = lamps.filter(|(_, lamp)| lamp.light.is_infinite());
        let suns = infinite.map(move |(index, lamp)| (index, lamp.light.escaped(direction, wavelengths)));
        let sky = self.sky.iter().map(move |sky| {
            let radiance = sky.sampler.radiance(direction, wavelengths);
            (self.lamps.len(), radiance)
        });
        suns.chain(sky)
    }

    /// The nearest lamp that a ray hits farther than `from` mm, and where, mm.
    #[inline]
    #[must_use]
    pub fn hit(&self, origin: DVec3, direction: DVec3, from: f64) -> Option<(usize, f64)> {
        let mut best: Option<(usize, f64)> = None;
        for &index in &self.standing {
            if let Some(distance) = self.lamps[index].light.hit(origin, direction)
                && distance > from
                && best.is_none_or(|(_, nearest)| distance < nearest)
            {
                best = Some((index, distance));
            }
        }
        best
    }

    /// Radiance of a lamp that a ray hits.
    #[must_use]
    pub fn emitted(&self, light: usize, wavelengths: Lambda4) -> [f64; 4] {
        self.lamps[light].light.emitted(wavelengths)
    }
}
