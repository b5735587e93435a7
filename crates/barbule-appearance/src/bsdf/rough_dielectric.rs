//! A rough boundary between air and a clear medium: GGX microfacets that reflect and refract (Walter et al., *Microfacet
//! models for refraction through rough surfaces*, EGSR 2007).
//!
//! Light meets one facet: what a second one would send on is lost. Both sides of the boundary see the same facets.

use glam::DVec3;

use super::hit::Hit;
use super::lobes::Lobes;
use super::microfacet::{FacetRoughness, Ggx};
use super::{Bsdf, Model};
use crate::fresnel::fresnel;
use crate::spectrum::dense::WAVES;
use crate::{Error, Result};

/// Frosted glass: one refractive index for all wavelengths, nothing absorbed. Outside is where the normal points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoughDielectric {
    ggx: Ggx,
    index: f64,
}

impl RoughDielectric {
    /// - `roughness`: each 0.02 … 1
    /// - `index`: refractive index in air
    ///
    /// # Errors
    /// A roughness out of range, or an index outside 1.01 to 3.9.
    pub fn new(roughness: FacetRoughness, index: f64) -> Result<Self> {
        if roughness.is_allowed() && (1.01..=3.9).contains(&index) {
            return Ok(Self { ggx: Ggx::new(roughness), index });
        }
        let FacetRoughness { along, across } = roughness;
        Err(Error::input(format!(
            "a dielectric of roughness {across} across and {along} along and index {index}: give 0.02 to 1 for both, and an index of 1.01 to 3.9"
        )))
    }

    /// At a hit, seen from `wo`.
    #[inline]
    pub(super) fn bind<'a>(&self, hit: &Hit, wo: DVec3) -> Bsdf<'a> {
        let side = hit.side(wo);
        let index = if side.is_upper { self.index } else { 1.0 / self.index };
        let lambda_o = self.ggx.lambda(side.wo);
        Bsdf::new(Model::RoughDielectric(Bound { ggx: self.ggx, index, lambda_o }), side)
    }
}

/// Seen from one side.
pub(super) struct Bound {
    ggx: Ggx,
    /// Index beyond the boundary over that on the viewer's side.
    index: f64,
    /// Smith's Λ of the viewer's direction.
    lambda_o: f64,
}

impl Bound {
    #[inline]
    pub(super) fn lobes(&self) -> Lobes {
        Lobes::REFLECTION.and(Lobes::TRANSMISSION).and(Lobes::GLOSSY)
    }

    #[inline]
    pub(super) fn eval(&self, wo: DVec3, wi: DVec3) -> ([f64; WAVES], [f64; WAVES]) {
        let (f, pdf) = if wi.z > 0.0 { self.reflected(wo, wi) } else { self.refracted(wo, wi) };
        ([f; WAVES], [pdf; WAVES])
    }

    /// Value and density on the viewer's side. Shadowing is that of facets whose heights both directions share.
    fn reflected(&self, wo: DVec3, wi: DVec3) -> (f64, f64) {
        let h = (wi + wo).normalize();
        let visible = fresnel(wo.dot(h), self.index) * self.ggx.distribution(h) / (4.0 * wo.z);
        let f = visible / (wi.z * (1.0 + self.lambda_o + self.ggx.lambda(wi)));
        (f, visible / (1.0 + self.lambda_o))
    }

    /// The same beyond the boundary: Walter et al., eqs. 16, 17 and 21, with the light beyond and the viewer here, so that
    /// radiance is over the square of the index. Directions on opposite sides are shadowed independently.
    fn refracted(&self, wo: DVec3, wi: DVec3) -> (f64, f64) {
        let h = (wo + self.index * wi).normalize();
        let h = if h.z < 0.0 { -h } else { h };
        let (cos_o, cos_i) = (wo.dot(h), wi.dot(h));
        if cos_o <= 0.0 || cos_i >= 0.0 {
            return (0.0, 0.0);
        }
        let spread = cos_o + self.index * cos_i;
        let crossing = (1.0 - fresnel(cos_o, self.index)) * self.ggx.distribution(h) * cos_o * -cos_i
            / (spread * spread * wo.z * (1.0 + self.lambda_o));
        (crossing / (-wi.z * (1.0 + self.ggx.lambda(wi))), self.index * self.index * crossing)
    }

    /// A facet that the viewer sees, and what Fresnel's share decides that it does.
    #[inline]
    pub(super) fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<(DVec3, Lobes)> {
        let h = self.ggx.visible_normal(wo, u[0], u[1]);
        let cosine = wo.dot(h);
        if u[2] < fresnel(cosine, self.index) {
            let wi = 2.0 * cosine * h - wo;
            return (wi.z > 0.0).then_some((wi, Lobes::REFLECTION.and(Lobes::GLOSSY)));
        }
        let squared = 1.0 - (1.0 - cosine * cosine) / (self.index * self.index);
        let wi = h * (cosine / self.index - squared.max(0.0).sqrt()) - wo / self.index;
        (squared > 0.0 && wi.z < 0.0).then_some((wi, Lobes::TRANSMISSION.and(Lobes::GLOSSY)))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::bsdf::Surface;
    use crate::spectrum::dense::Lambdas;

    fn direction(polar: f64, azimuth: f64) -> DVec3 {
        DVec3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos())
    }

    fn bound(surface: &Surface, wo: DVec3) -> Bsdf<'_> {
        surface.bind(&Hit::default(), wo, Lambdas::splat(550.0))
    }

    fn frosted(roughness: f64) -> Surface {
        Surface::RoughDielectric(RoughDielectric::new(FacetRoughness::even(roughness), 1.5).unwrap())
    }

    /// Power that is reflected, and that goes through, by the midpoint rule over all directions: from the values alone.
    fn powers(surface: &Surface, wo: DVec3) -> [f64; 2] {
        let (polars, azimuths) = (1500, 240);
        let bsdf = bound(surface, wo);
        let index: f64 = if wo.z > 0.0 { 1.5 } else { 1.0 / 1.5 };
        let mut sums = [0.0; 2];
        for k in 0..2 * polars {
            let polar = TAU / 4.0 * (f64::from(k) + 0.5) / f64::from(polars);
            let ring: f64 = (0..azimuths)
                .map(|j| {
                    let found = bsdf.eval(direction(polar, TAU * (f64::from(j) + 0.5) / f64::from(azimuths)));
                    found.f[0] * found.cosine
                })
                .sum();
            let solid = polar.sin() * TAU / 4.0 / f64::from(polars) * TAU / f64::from(azimuths);
            let is_through = (polar.cos() > 0.0) != (wo.z > 0.0);
            // Radiance within glass is higher by the square of the index; power is not.
            let scale = if is_through { index * index } else { 1.0 };
            sums[usize::from(is_through)] += scale * ring * solid;
        }
        sums
    }

    /// The same from facets that lie as the distribution says, each a mirror and a smooth boundary: no half vectors and no
    /// densities of directions.
    fn powers_of_facets(roughness: f64, wo: DVec3) -> [f64; 2] {
        let index: f64 = if wo.z > 0.0 { 1.5 } else { 1.0 / 1.5 };
        let (x, z, side) = (wo.truncate().length(), wo.z.abs(), 700);
        let unshadowed = |z: f64| 0.5 * (1.0 + (1.0 + roughness * roughness * (1.0 / (z * z) - 1.0)).sqrt());
        let mut sums = [0.0; 2];
        for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
            let [s, v] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(side));
            // Of shares u = 1 − s² of the facets: the steepest ones count most, and so have steps of their own.
            let polar = (roughness * (1.0 - s * s).sqrt() / s).atan();
            let h = DVec3::new(polar.sin() * (TAU * v).cos(), 0.0, polar.cos());
            let c = h.x * x + h.z * z;
            if c <= 0.0 {
                continue;
            }
            let (seen, share) = (2.0 * s * c / (z * h.z) / f64::from(side * side), fresnel(c, index));
            let up = 2.0 * c * h.z - z;
            if up > 0.0 {
                sums[0] += seen * share / (unshadowed(z) + unshadowed(up) - 1.0);
            }
            let squared = 1.0 - (1.0 - c * c) / (index * index);
            let down = h.z * (c / index - squared.max(0.0).sqrt()) - z / index;
            if squared > 0.0 && down < 0.0 {
                sums[1] += seen * (1.0 - share) / (unshadowed(z) * unshadowed(down));
            }
        }
        sums
    }

    /// Both lobes give what their facets give, together never more than what comes in, and from outside nearly all of it. From
    /// within, facets near the critical angle send much to others.
    #[test]
    fn lobes_are_the_sum_of_their_facets() {
        for (roughness, least) in [(0.1, 0.995), (0.3, 0.965), (0.6, 0.895)] {
            for polar in [0.2, 0.8, 2.0, 2.5, 3.0] {
                let wo = direction(polar, 0.7);
                let (found, expected) = (powers(&frosted(roughness), wo), powers_of_facets(roughness, wo));
                let place = format!("roughness {roughness}, {polar}: {found:?} {expected:?}");
                // Facets of long tails are few.
                assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 2e-3), "{place}");
                let sum = found[0] + found[1];
                assert!(sum < 1.0 && (polar > 1.0 || sum > least), "{place}");
            }
        }
    }

    /// As rough as may be least it reflects Fresnel's share, and light comes from where Snell's law says.
    #[test]
    fn nearly_smooth_glass_is_smooth_glass() {
        for polar in [0.3_f64, 0.9, 2.8, 2.0] {
            let wo = direction(polar, 0.0);
            let surface =
                Surface::RoughDielectric(RoughDielectric::new(FacetRoughness::even(0.02), 1.5).unwrap());
            let index: f64 = if wo.z > 0.0 { 1.5 } else { 1.0 / 1.5 };
            let share = fresnel(wo.z.abs(), index);
            let (side, mut reflected, mut through) = (60, 0.0, DVec3::ZERO);
            let bsdf = bound(&surface, wo);
            for (i, j, k) in
                (0..side).flat_map(|i| (0..side).flat_map(move |j| (0..20).map(move |k| (i, j, k))))
            {
                let at = |k: u32, n: u32| (f64::from(k) + 0.5) / f64::from(n);
                let Some(drawn) = bsdf.sample([at(i, side), at(j, side), at(k, 20)]) else { continue };
                let weight = drawn.evaluation.f[0] * drawn.evaluation.cosine / drawn.evaluation.pdf[0];
                if drawn.lobes.has(Lobes::REFLECTION) {
                    reflected += weight / f64::from(side * side * 20);
                } else {
                    through += drawn.wi;
                }
            }
            // Twenty strata of the choice resolve the share to a fortieth.
            assert!((reflected - share).abs() < 0.026, "{polar}: {reflected} {share}");
            if wo.z.abs().acos().sin() < index {
                let sine = -wo.x / index;
                let expected = DVec3::new(sine, 0.0, -wo.z.signum() * (1.0 - sine * sine).sqrt());
                assert!(through.normalize().dot(expected) > 0.9999, "{polar}: {through} {expected}");
            } else {
                assert_eq!(through, DVec3::ZERO);
            }
        }
    }

    /// Helmholtz: seen backwards through the boundary the value is the square of the relative index times as large.
    #[test]
    fn both_ways_through_differ_by_the_square_of_the_index() {
        let surface = Surface::RoughDielectric(
            RoughDielectric::new(FacetRoughness { across: 0.4, along: 0.15 }, 1.5).unwrap(),
        );
        for (polar, other, azimuth) in [(0.3, 2.9, 3.0), (0.9, 2.6, 3.5), (1.2, 2.6, 3.0)] {
            let (a, b) = (direction(polar, 0.4), direction(other, azimuth));
            let [ab, ba] = [(a, b), (b, a)].map(|(wo, wi)| bound(&surface, wo).eval(wi).f[0]);
            assert!(ab > 0.0 && (ba / ab / 2.25 - 1.0).abs() < 1e-12, "{ab} {ba}");
            let (up, other_up) = (direction(polar, 0.4), direction(0.5, azimuth));
            let [one, two] =
                [(up, other_up), (other_up, up)].map(|(wo, wi)| bound(&surface, wo).eval(wi).f[0]);
            assert!(one > 0.0 && (one / two - 1.0).abs() < 1e-12);
        }
        assert!(
            RoughDielectric::new(FacetRoughness { across: 0.01, along: 0.1 }, 1.5).is_err()
                && RoughDielectric::new(FacetRoughness::even(0.1), 1.0).is_err()
        );
    }
}
