//! Keratin with pigment: a rough dielectric boundary over a diffuse, absorbing body. Shafts, rami and the undersides
//! of barbules.
//!
//! The boundary is a GGX microsurface with Fresnel reflectance (Walter et al. 2007, height-correlated Smith
//! shadowing). What it lets in is scattered diffusely: (1 − E(ω_i)) (1 − E(ω_o)) ρ / (π (1 − Ē)), with E the
//! boundary's directional albedo and Ē its mean (Kelemen & Szirmay-Kalos 2001). So the whole albedo is
//! E + (1 − E) ρ ≤ 1, and the model is reciprocal.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::hit::Hit;
use super::lobes::Lobes;
use super::microfacet::{FacetRoughness, Ggx};
use super::reflectance::Reflectance;
use super::{Bsdf, Model};
use crate::fresnel::fresnel;
use crate::spectrum::dense::{Lambdas, WAVES};
use crate::{Error, Result};

/// Nodes of the boundary's albedo in the cosine.
const NODES: usize = 33;

/// Pigmented keratin.
#[derive(Debug, Clone)]
pub struct Keratin {
    ggx: Ggx,
    index: f64,
    body: Reflectance,
    /// Directional albedo of the boundary at cos = k/32.
    albedo: [f64; NODES],
    /// Its cosine-weighted mean.
    mean_albedo: f64,
}

impl Keratin {
    /// `roughness`: GGX α, 0.02 … 1; `index`: refractive index, over 1.
    ///
    /// # Errors
    /// A parameter out of range.
    pub fn new(roughness: f64, index: f64, body: Reflectance) -> Result<Self> {
        let allowed = (0.02..=1.0).contains(&roughness) && index > 1.0 && index < 4.0;
        if !allowed {
            return Err(Error::input(format!(
                "keratin of roughness {roughness} and index {index}: give a roughness of 0.02 to 1 and an index of 1 to 4"
            )));
        }
        let mut keratin = Self {
            ggx: Ggx::new(FacetRoughness::even(roughness)),
            index,
            body,
            albedo: [0.0; NODES],
            mean_albedo: 0.0,
        };
        for node in 0..NODES {
            keratin.albedo[node] = keratin.boundary_albedo((node as f64 / (NODES - 1) as f64).max(1e-3));
        }
        // The mean is that of the linear interpolation, so the furnace holds to rounding of the tables.
        let h = 1.0 / (NODES - 1) as f64;
        keratin.mean_albedo = (0..NODES - 1)
            .map(|i| {
                let (a, b, c) = (keratin.albedo[i], keratin.albedo[i + 1], i as f64 * h);
                2.0 * h * (a * (c / 2.0 + h / 6.0) + b * (c / 2.0 + h / 3.0))
            })
            .sum();
        Ok(keratin)
    }

    /// GGX α.
    #[must_use]
    pub fn roughness(&self) -> f64 {
        self.ggx.alpha()[0]
    }

    /// Refractive index.
    #[must_use]
    pub fn index(&self) -> f64 {
        self.index
    }

    /// The boundary's directional albedo at cosines that are even from 0 to 1, linear between, and its cosine-weighted mean.
    #[must_use]
    pub fn boundary(&self) -> (&[f64], f64) {
        (&self.albedo, self.mean_albedo)
    }

    /// The diffuse body.
    #[must_use]
    pub fn body(&self) -> &Reflectance {
        &self.body
    }

    /// f in 1/sr at each wavelength and the density of [`Keratin::sample`], 1/sr. Both directions in the local frame,
    /// z > 0.
    #[must_use]
    pub fn eval(&self, wi: DVec3, wo: DVec3, wavelengths: Lambdas) -> ([f64; WAVES], f64) {
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return ([0.0; WAVES], 0.0);
        }
        let h = (wi + wo).normalize();
        let d = self.ggx.distribution(h);
        let fresnel = fresnel(wi.dot(h), self.index);
        let (lambda_i, lambda_o) = (self.ggx.lambda(wi), self.ggx.lambda(wo));
        let gloss = fresnel * d / (4.0 * wi.z * wo.z * (1.0 + lambda_i + lambda_o));
        let (in_i, in_o) = (1.0 - self.lookup(wi.z), 1.0 - self.lookup(wo.z));
        let diffuse = in_i * in_o / (PI * (1.0 - self.mean_albedo));
        let f = wavelengths.map(|w| gloss + diffuse * self.body.at(w));
        let share = self.gloss_share(wi.z);
        let visible = d / (4.0 * wi.z * (1.0 + lambda_i));
        (f, share * visible + (1.0 - share) * wo.z / PI)
    }

    /// A direction for light that leaves towards `wi`, from three uniform numbers, and its lobe; the direction may lie
    /// below the horizon.
    #[must_use]
    pub fn sample(&self, wi: DVec3, u: [f64; 3]) -> (DVec3, Lobes) {
        if u[2] < self.gloss_share(wi.z) {
            let h = self.ggx.visible_normal(wi, u[0], u[1]);
            return (2.0 * wi.dot(h) * h - wi, Lobes::REFLECTION.and(Lobes::GLOSSY));
        }
        let (sine, azimuth) = (u[0].sqrt(), TAU * u[1]);
        let wo = DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), (1.0 - u[0]).max(0.0).sqrt());
        (wo, Lobes::REFLECTION.and(Lobes::DIFFUSE))
    }

    /// At a hit, seen from `wo`.
    #[inline]
    pub(super) fn bind<'a>(&'a self, hit: &Hit, wo: DVec3, wavelengths: Lambdas) -> Bsdf<'a> {
        Bsdf::new(Model::Keratin(Bound { keratin: self, wavelengths }), hit.side(wo))
    }

    /// Share of the samples spent on the boundary's reflection.
    fn gloss_share(&self, cosine: f64) -> f64 {
        let gloss = self.lookup(cosine);
        (gloss / (gloss + (1.0 - gloss) * self.body.mean()).max(1e-9)).clamp(0.1, 0.9)
    }

    fn lookup(&self, cosine: f64) -> f64 {
        let at = cosine.clamp(0.0, 1.0) * (NODES - 1) as f64;
        let index = (at as usize).min(NODES - 2);
        self.albedo[index] + (self.albedo[index + 1] - self.albedo[index]) * (at - index as f64)
    }

    /// Directional albedo of the boundary by a 32 × 32 midpoint rule over visible normals.
    fn boundary_albedo(&self, cosine: f64) -> f64 {
        const SIDE: usize = 32;
        let wi = DVec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
        let mut sum = 0.0;
        for i in 0..SIDE * SIDE {
            let u = ((i % SIDE) as f64 + 0.5) / SIDE as f64;
            let v = ((i / SIDE) as f64 + 0.5) / SIDE as f64;
            let h = self.ggx.visible_normal(wi, u, v);
            let wo = 2.0 * wi.dot(h) * h - wi;
            if wo.z > 0.0 {
                let (lambda_i, lambda_o) = (self.ggx.lambda(wi), self.ggx.lambda(wo));
                sum += fresnel(wi.dot(h), self.index) * (1.0 + lambda_i) / (1.0 + lambda_i + lambda_o);
            }
        }
        sum / (SIDE * SIDE) as f64
    }
}

/// Keratin at the wavelengths of a path.
pub(super) struct Bound<'a> {
    pub(super) keratin: &'a Keratin,
    pub(super) wavelengths: Lambdas,
}

impl Bound<'_> {
    #[inline]
    pub(super) fn lobes(&self) -> Lobes {
        Lobes::REFLECTION.and(Lobes::DIFFUSE).and(Lobes::GLOSSY)
    }

    #[inline]
    pub(super) fn eval(&self, wo: DVec3, wi: DVec3) -> ([f64; WAVES], [f64; WAVES]) {
        let (f, pdf) = self.keratin.eval(wo, wi, self.wavelengths);
        (f, [pdf; WAVES])
    }

    #[inline]
    pub(super) fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<(DVec3, Lobes)> {
        Some(self.keratin.sample(wo, u))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Stream;

    fn furnace(keratin: &Keratin, cosine: f64) -> f64 {
        let wi = DVec3::new((1.0f64 - cosine * cosine).sqrt(), 0.0, cosine);
        let mut stream = Stream::new(3, &[(cosine * 1000.0) as u64]);
        let count = 40_000;
        let mut sum = 0.0;
        for _ in 0..count {
            let (wo, _) = keratin.sample(wi, [stream.unit(), stream.unit(), stream.unit()]);
            let (f, pdf) = keratin.eval(wi, wo, Lambdas::splat(550.0));
            if pdf > 0.0 {
                sum += f[0] * wo.z / pdf;
            }
        }
        sum / f64::from(count)
    }

    /// Single scattering off the boundary loses what its second bounce would bring: 1 … 2 % at these roughnesses;
    /// the body takes all the rest. Monte Carlo: 0.5 %.
    #[test]
    fn white_keratin_stays_white_in_the_furnace() {
        let white = Reflectance::new(|_| 1.0).unwrap();
        for roughness in [0.1, 0.3, 0.6] {
            let keratin = Keratin::new(roughness, 1.56, white.clone()).unwrap();
            for cosine in [0.15, 0.5, 1.0] {
                let albedo = furnace(&keratin, cosine);
                assert!((albedo - 1.0).abs() < 0.01, "roughness {roughness}, cos {cosine}: {albedo}");
            }
        }
    }

    #[test]
    fn keratin_is_reciprocal() {
        let keratin = Keratin::new(0.3, 1.56, Reflectance::melanin(2.0).unwrap()).unwrap();
        let a = DVec3::new(0.3, 0.5, 0.7).normalize();
        let b = DVec3::new(-0.6, 0.1, 0.4).normalize();
        let (ab, _) = keratin.eval(a, b, Lambdas::splat(450.0));
        let (ba, _) = keratin.eval(b, a, Lambdas::splat(450.0));
        assert!((ab[0] / ba[0] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn densities_integrate_to_at_most_one() {
        let keratin = Keratin::new(0.2, 1.56, Reflectance::melanin(1.0).unwrap()).unwrap();
        let wi = DVec3::new(0.6, 0.0, 0.8);
        let mut stream = Stream::new(5, &[]);
        let count = 200_000;
        let mut sum = 0.0;
        for _ in 0..count {
            let z = stream.unit();
            let azimuth = TAU * stream.unit();
            let sine = (1.0 - z * z).sqrt();
            let wo = DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), z);
            sum += TAU * keratin.eval(wi, wo, Lambdas::splat(550.0)).1;
        }
        let total = sum / f64::from(count);
        assert!((0.97..1.02).contains(&total), "{total}");
    }
}
