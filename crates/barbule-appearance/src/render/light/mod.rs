//! A scene's lamps and sky, ready to be sampled. They know nothing of shapes: a lamp moves without a new hierarchy.

mod cumulative;
mod lamp;
mod sample;
mod sky;

use std::sync::Arc;

use glam::{DVec2, DVec3};

pub use sample::LightSample;
use sky::SkySampler;

use super::response::Response;
use crate::scene::light::{Lamp, Light};
use crate::scene::sky::Environment;
use crate::spectrum::dense::{Lambdas, WAVES};
use crate::spectrum::sensor::MOST_CHANNELS;
use crate::{Error, Result};

/// Of so many lights each is sampled at every point; of more so many are drawn, by their weights.
const AT_ONCE: usize = 4;

/// All lights of a scene. Each has an index: lamps in their order, then the sky.
#[derive(Debug, Clone)]
pub struct Lighting {
    lamps: Vec<Lamp>,
    sky: Option<Sky>,
    /// Lamps that stand in the scene, which rays can hit.
    standing: Vec<usize>,
    /// Lamps that only rays which leave the scene see.
    infinite: Vec<usize>,
    /// Samples of each light that a point takes in the mean.
    counts: Vec<f64>,
}

/// The sky and its weight.
#[derive(Debug, Clone)]
struct Sky {
    sampler: Arc<SkySampler>,
    weight: f64,
}

/// What a sensor's channels see of lights themselves.
#[derive(Debug, Clone)]
pub(super) struct Glow {
    /// Of each lamp.
    lamps: Vec<[f64; MOST_CHANNELS]>,
    /// Of each of the sky's spectra.
    sky: Vec<[f64; MOST_CHANNELS]>,
}

/// What a ray that leaves the scene sees.
#[derive(Debug, Clone, Copy)]
pub enum Far {
    /// The lamp of this index.
    Lamp(usize),
    /// The sky, in this row and column.
    Sky([usize; 2]),
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
        let few = weights.len() <= AT_ONCE;
        let count = |weight: &f64| if few { 1.0 } else { AT_ONCE as f64 * weight / total };
        let counts = weights.iter().map(count).collect();
        let infinite = (0..lamps.len()).filter(|&i| lamps[i].light.is_infinite()).collect();
        let meets = |light: &Light| !light.is_infinite() && !light.is_point();
        let standing = (0..lamps.len()).filter(|&i| meets(&lamps[i].light)).collect();
        Ok(Self { lamps, sky, standing, infinite, counts })
    }

    /// How many samples of lights a point takes.
    #[inline]
    #[must_use]
    pub fn draws(&self) -> usize {
        self.counts.len().min(AT_ONCE)
    }

    /// The light of one of these samples, with a uniform number where there are more lights than samples.
    #[inline]
    #[must_use]
    pub fn choose(&self, draw: usize, u: f64) -> usize {
        if self.counts.len() <= AT_ONCE {
            return draw;
        }
        let mut left = u * AT_ONCE as f64;
        let found = self.counts.iter().position(|count| {
            left -= count;
            left < 0.0
        });
        found.unwrap_or(self.counts.len() - 1)
    }

    /// A direction from `point` towards a light, with its density in all of the point's samples; `None` where the light
    /// cannot be seen from there.
    #[inline(always)]
    #[must_use]
    pub fn sample(&self, light: usize, point: DVec3, u: DVec2, wavelengths: Lambdas) -> Option<LightSample> {
        let mut sample = match self.lamps.get(light) {
            Some(lamp) => lamp.light.sample(point, u, wavelengths),
            None => self.sky.as_ref()?.sampler.sample(u, wavelengths),
        }?;
        sample.pdf *= self.counts[light];
        Some(sample)
    }

    /// Density of a direction in all of a point's samples, 1/sr, from a light that a ray along it is known to see.
    #[must_use]
    pub fn pdf(&self, light: usize, point: DVec3, direction: DVec3) -> f64 {
        let pdf = match (self.lamps.get(light), &self.sky) {
            (Some(lamp), _) => lamp.light.pdf(point, direction),
            (None, Some(sky)) => sky.sampler.pdf(direction),
            (None, None) => 0.0,
        };
        self.counts[light] * pdf
    }

    /// Tells what a ray sees of each light when it leaves the scene: radiance, and for whoever needs it what finds the
    /// direction's density with [`Lighting::far_pdf`].
    #[inline(always)]
    pub fn escaped(&self, direction: DVec3, wavelengths: Lambdas, mut see: impl FnMut([f64; WAVES], Far)) {
        for &light in &self.infinite {
            see(self.lamps[light].light.escaped(direction, wavelengths), Far::Lamp(light));
        }
        if let Some(sky) = &self.sky {
            let texel = sky.sampler.texel(direction);
            see(sky.sampler.spectrum(texel, wavelengths), Far::Sky(texel));
        }
    }

    /// What a sensor sees of the lights themselves.
    pub(super) fn glow(&self, response: &Response) -> Glow {
        let sky = self.sky.iter().flat_map(|sky| sky.sampler.basis());
        Glow {
            lamps: self.lamps.iter().map(|lamp| response.of(lamp.light.emission())).collect(),
            sky: sky.map(|light| response.of(light)).collect(),
        }
    }

    /// What of a glow a ray sees that meets no surface, and whether that is a lamp that stands in the scene.
    #[inline(always)]
    #[must_use]
    pub(super) fn behind<const LANES: usize>(
        &self,
        glow: &Glow,
        origin: DVec3,
        direction: DVec3,
    ) -> ([f64; LANES], bool) {
        if let Some((lamp, _)) = self.hit(origin, direction, 0.0) {
            return (std::array::from_fn(|k| glow.lamps[lamp][k]), true);
        }
        let mut seen = [0.0; LANES];
        if let Some(Sky { sampler, .. }) = &self.sky {
            seen = sampler.glow(&glow.sky, sampler.texel(direction));
        }
        for &lamp in &self.infinite {
            if self.lamps[lamp].light.is_behind(direction) {
                seen.iter_mut().zip(glow.lamps[lamp]).for_each(|(sum, value)| *sum += value);
            }
        }
        (seen, false)
    }

    /// Density of a direction in all of a point's samples, 1/sr, from what [`Lighting::escaped`] saw along it: whatever lies
    /// at infinity is seen from everywhere alike.
    #[inline(always)]
    #[must_use]
    pub fn far_pdf(&self, far: Far, direction: DVec3) -> f64 {
        match (far, &self.sky) {
            (Far::Lamp(light), _) => self.pdf(light, DVec3::ZERO, direction),
            (Far::Sky(texel), Some(sky)) => self.counts[self.lamps.len()] * sky.sampler.texel_pdf(texel),
            (Far::Sky(_), None) => 0.0,
        }
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
    pub fn emitted(&self, light: usize, wavelengths: Lambdas) -> [f64; WAVES] {
        self.lamps[light].light.emitted(wavelengths)
    }
}
