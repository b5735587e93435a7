//! A smooth boundary between air and a clear medium: mirror reflection and refraction, in single directions.

use glam::DVec3;

use super::hit::{Hit, Side};
use super::lobes::Lobes;
use super::{Bsdf, BsdfSample, Evaluation, Model};
use crate::fresnel::fresnel;
use crate::spectrum::dense::WAVES;
use crate::{Error, Result};

/// Glass, water: one refractive index for all wavelengths, nothing absorbed. Outside is where the normal points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dielectric {
    index: f64,
}

impl Dielectric {
    /// A medium of this refractive index in air.
    ///
    /// # Errors
    /// An index outside 1.01 to 3.9.
    pub fn new(index: f64) -> Result<Self> {
        if (1.01..=3.9).contains(&index) {
            return Ok(Self { index });
        }
        Err(Error::input(format!("a dielectric's index is {index}; give 1.01 to 3.9")))
    }

    /// At a hit, seen from `wo`.
    #[inline]
    pub(super) fn bind<'a>(&self, hit: &Hit, wo: DVec3) -> Bsdf<'a> {
        let side = hit.side(wo);
        let index = if side.is_upper { self.index } else { 1.0 / self.index };
        Bsdf::new(Model::Dielectric(Bound { index }), side)
    }
}

/// How often the fainter of both directions is drawn at least.
const LEAST_DRAWN: f64 = 0.1;

/// Seen from one side.
pub(super) struct Bound {
    /// Index beyond the boundary over that on the viewer's side.
    index: f64,
}

impl Bound {
    #[inline]
    pub(super) fn lobes(&self) -> Lobes {
        Lobes::REFLECTION.and(Lobes::TRANSMISSION).and(Lobes::DELTA)
    }

    /// No light's sample meets a single direction.
    #[inline]
    pub(super) fn eval(&self, _wo: DVec3, _wi: DVec3) -> ([f64; WAVES], [f64; WAVES]) {
        ([0.0; WAVES], [0.0; WAVES])
    }

    /// What goes into the mirror direction, and how often that is drawn: at least [`LEAST_DRAWN`] of the times, and so often the other
    /// one where that can be, or a lamp's faint image is noise.
    #[inline]
    fn reflected(&self, wo: DVec3) -> (f64, f64) {
        let share = fresnel(wo.z, self.index);
        (share, if share < 1.0 { share.clamp(LEAST_DRAWN, 1.0 - LEAST_DRAWN) } else { 1.0 })
    }

    /// The mirror direction or the refracted one.
    #[inline]
    pub(super) fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<(DVec3, Lobes)> {
        if u[2] < self.reflected(wo).1 {
            return Some((DVec3::new(-wo.x, -wo.y, wo.z), Lobes::REFLECTION.and(Lobes::DELTA)));
        }
        // Snell's law; beyond the critical angle all is reflected.
        let (x, y) = (-wo.x / self.index, -wo.y / self.index);
        let squared = 1.0 - x * x - y * y;
        (squared > 0.0).then(|| (DVec3::new(x, y, -squared.sqrt()), Lobes::TRANSMISSION.and(Lobes::DELTA)))
    }

    /// The same in the scene with the probability of the direction as its density. Where face and shading normal disagree on the
    /// side of the direction, the face decides both.
    pub(super) fn sample_in_scene(&self, side: &Side, u: [f64; 3]) -> Option<BsdfSample> {
        let leaves = |wi: DVec3, lobes: Lobes| (wi.dot(side.normal) > 0.0) == lobes.has(Lobes::REFLECTION);
        let towards = side.frame.to_world(side.wo);
        let drawn = |frame: super::Frame| {
            let wo = frame.to_local(towards);
            let (local, lobes) = self.sample(wo, u)?;
            Some((frame.to_world(local).normalize(), lobes, self.reflected(wo)))
        };
        let (wi, lobes, (reflected, drawn_often)) = drawn(side.frame)
            .filter(|(wi, lobes, _)| leaves(*wi, *lobes))
            .or_else(|| drawn(super::Frame::new(side.normal, side.frame.y)))?;
        // Radiance is concentrated in a denser medium by the square of the index; the viewer sees it on the way out.
        let (share, chance, scale) = if lobes.has(Lobes::REFLECTION) {
            (reflected, drawn_often, 1.0)
        } else {
            (1.0 - reflected, 1.0 - drawn_often, 1.0 / (self.index * self.index))
        };
        let cosine = wi.dot(side.normal).abs().max(1e-12);
        let evaluation = Evaluation { f: [share * scale / cosine; WAVES], pdf: [chance; WAVES], cosine };
        (share > 0.0).then_some(BsdfSample { wi, evaluation, lobes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Surface;
    use crate::spectrum::dense::Lambdas;

    /// Directions follow Snell's law, both ways, and what goes there sums up to 1 (radiance over the square of the index).
    #[test]
    fn light_is_split_as_fresnel_says_and_bent_as_snell_says() {
        let glass = Surface::Dielectric(Dielectric::new(1.5).unwrap());
        for (polar, is_outside) in [(0.3_f64, true), (1.2, true), (0.4, false), (1.2, false)] {
            let z = if is_outside { polar.cos() } else { -polar.cos() };
            let wo = DVec3::new(polar.sin(), 0.0, z);
            let bsdf = glass.bind(&Hit::default(), wo, Lambdas::splat(550.0));
            let eta: f64 = if is_outside { 1.5 } else { 1.0 / 1.5 };
            let reflected = fresnel(polar.cos(), eta);
            let mirror = bsdf.sample([0.5, 0.5, 0.0]).unwrap();
            assert!((mirror.wi - DVec3::new(-wo.x, 0.0, wo.z)).length() < 1e-12);
            let value = |s: &BsdfSample| s.evaluation.f[0] * s.evaluation.cosine;
            assert!((value(&mirror) - reflected).abs() < 1e-12);
            assert!(mirror.evaluation.pdf[0] >= reflected.max(LEAST_DRAWN));
            let beyond = bsdf.sample([0.5, 0.5, 0.999_999]);
            if polar.sin() > eta {
                assert!(reflected == 1.0 && beyond.is_some_and(|s| s.lobes.has(Lobes::REFLECTION)));
                continue;
            }
            let beyond = beyond.unwrap();
            assert!((beyond.wi.x * eta + wo.x).abs() < 1e-12 && beyond.wi.z * wo.z < 0.0);
            assert!((value(&mirror) + value(&beyond) * eta * eta - 1.0).abs() < 1e-12);
            assert!((mirror.evaluation.pdf[0] + beyond.evaluation.pdf[0] - 1.0).abs() < 1e-12);
            assert!(bsdf.eval(beyond.wi).f == [0.0; WAVES]);
        }
        // Normal incidence: ((n − 1)/(n + 1))².
        assert!((fresnel(1.0, 1.5) - 0.04).abs() < 1e-12);
        assert!(Dielectric::new(1.0).is_err() && Dielectric::new(f64::NAN).is_err());
    }
}
