//! Perfectly diffuse surfaces, opaque or translucent: constant f on each side.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::hit::Hit;
use super::lobes::Lobes;
use super::phase_film::PhaseFilm;
use super::reflectance::Reflectance;
use super::relief::Relief;
use super::texture::Texture;
use super::{Bsdf, Model};
use crate::spectrum::dense::{DenseSpectrum, Lambdas, WAVES};
use crate::spectrum::primaries::shares;
use crate::{Error, Result};

/// Perfectly diffuse, the same seen from both sides.
#[derive(Debug, Clone)]
pub struct Lambertian {
    reflectance: Reflectance,
    /// What goes diffusely to the other side.
    transmittance: Option<Reflectance>,
    /// What is painted on it, in place of the reflectance.
    paint: Option<Paint>,
}

/// A colour that may change from place to place.
#[derive(Debug, Clone)]
struct Paint {
    /// Linear sRGB, 0 … 1.
    colour: [f64; 3],
    pictures: Pictures,
    basis: [DenseSpectrum; 3],
    /// What it shows where its colour is blue.
    film: Option<PhaseFilm>,
}

/// Pictures on a surface.
#[derive(Debug, Clone, Default)]
pub struct Pictures {
    /// What its colour is multiplied with.
    pub albedo: Option<Texture>,
    /// Whose mean is its opacity.
    pub alpha: Option<Texture>,
    /// How its normal leans.
    pub relief: Option<Relief>,
}

impl Lambertian {
    /// Opaque.
    #[must_use]
    pub fn new(reflectance: Reflectance) -> Self {
        Self { reflectance, transmittance: None, paint: None }
    }

    /// Of a colour (linear sRGB, 0 … 1), with pictures. A colour's reflectance is its smoothest spectrum within 0 … 1.
    ///
    /// # Errors
    /// A colour outside 0 … 1.
    pub fn painted(colour: [f64; 3], pictures: Pictures) -> Result<Self> {
        if !colour.iter().all(|v| (0.0..=1.0).contains(v)) {
            return Err(Error::input("a surface's colour must lie between 0 and 1"));
        }
        let reflectance = Reflectance::new(|_| 0.0)?;
        let paint = Paint { colour, pictures, basis: shares(), film: None };
        Ok(Self { reflectance, transmittance: None, paint: Some(paint) })
    }

    /// The same paint with a film where it is blue; without paint nothing is.
    #[must_use]
    pub fn iridescent(mut self, film: PhaseFilm) -> Self {
        self.paint.iter_mut().for_each(|paint| paint.film = Some(film));
        self
    }

    /// Its reflectance where that is the same everywhere and nothing passes.
    #[must_use]
    pub fn even(&self) -> Option<Reflectance> {
        let Some(Paint { colour, pictures, film, .. }) = &self.paint else {
            return self.transmittance.is_none().then(|| self.reflectance.clone());
        };
        match pictures {
            Pictures { albedo: None, alpha: None, relief: None } if film.is_none() => {
                Reflectance::of_colour(*colour).ok()
            }
            _ => None,
        }
    }

    /// See [`super::Surface::opacity`].
    #[inline]
    pub(super) fn opacity(&self, hit: &Hit) -> f64 {
        let alpha = self.paint.as_ref().and_then(|paint| paint.pictures.alpha.as_ref());
        alpha.map_or(1.0, |texture| texture.at(hit.uv).iter().sum::<f64>() / 3.0)
    }

    /// Whether it has no holes.
    pub(super) fn is_opaque(&self) -> bool {
        self.paint.as_ref().is_none_or(|paint| paint.pictures.alpha.is_none())
    }

    /// A thin sheet that also lets light through, diffusely.
    ///
    /// # Errors
    /// Both together exceed 1 somewhere.
    pub fn translucent(reflectance: Reflectance, transmittance: Reflectance) -> Result<Self> {
        let both = reflectance.values().iter().zip(transmittance.values());
        if both.into_iter().any(|(r, t)| r + t > 1.0 + 1e-12) {
            return Err(Error::input(
                "a translucent surface reflects and transmits over 1 together; give less of either",
            ));
        }
        Ok(Self { reflectance, transmittance: Some(transmittance), paint: None })
    }

    /// At a hit, seen from `wo`.
    #[inline(always)]
    pub(super) fn bind<'a>(&self, hit: &Hit, wo: DVec3, wavelengths: Lambdas) -> Bsdf<'a> {
        let f = |side: &Reflectance| side.at_each(wavelengths).map(|value| value / PI);
        let transmitted = self.transmittance.as_ref().map(f);
        let reflected_share = self.transmittance.as_ref().map_or(1.0, |transmittance| {
            let (r, t) = (self.reflectance.mean(), transmittance.mean());
            if r + t > 0.0 { r / (r + t) } else { 1.0 }
        });
        let relief = self.paint.as_ref().and_then(|paint| paint.pictures.relief.as_ref());
        let side = relief.map_or_else(|| hit.side(wo), |relief| relief.bent(hit).side(wo));
        let reflected = self
            .paint
            .as_ref()
            .map_or_else(|| f(&self.reflectance), |paint| paint.reflected(hit, side.wo.z, wavelengths));
        let bound = Bound { reflected, transmitted, reflected_share };
        Bsdf::new(Model::Lambertian(bound), side)
    }
}

impl Paint {
    /// 1/sr, at a hit that is seen under this cosine.
    #[inline]
    fn reflected(&self, hit: &Hit, cosine: f64, wavelengths: Lambdas) -> [f64; WAVES] {
        let picture = self.pictures.albedo.as_ref().map_or([1.0; 3], |texture| texture.at(hit.uv));
        let colour: [f64; 3] = std::array::from_fn(|c| self.colour[c] * picture[c]);
        let mut albedo = [0.0; WAVES];
        for (colour, basis) in colour.iter().zip(&self.basis) {
            for (albedo, share) in albedo.iter_mut().zip(basis.at_each(wavelengths)) {
                *albedo += colour * share;
            }
        }
        if let Some(film) = &self.film {
            albedo = film.over(albedo, colour, cosine, wavelengths);
        }
        albedo.map(|albedo| albedo / PI)
    }
}

/// Its values at the wavelengths of a path.
pub(super) struct Bound {
    /// 1/sr, on the viewer's side.
    reflected: [f64; WAVES],
    /// 1/sr, on the other.
    transmitted: Option<[f64; WAVES]>,
    /// Share of the samples that stay on the viewer's side.
    reflected_share: f64,
}

impl Bound {
    #[inline(always)]
    pub(super) fn lobes(&self) -> Lobes {
        let lobes = Lobes::REFLECTION.and(Lobes::DIFFUSE);
        if self.transmitted.is_some() { lobes.and(Lobes::TRANSMISSION) } else { lobes }
    }

    #[inline(always)]
    pub(super) fn eval(&self, _wo: DVec3, wi: DVec3) -> ([f64; WAVES], [f64; WAVES]) {
        match self.transmitted {
            None => (self.reflected, [wi.z / PI; WAVES]),
            Some(_) if wi.z > 0.0 => (self.reflected, [self.reflected_share * wi.z / PI; WAVES]),
            Some(transmitted) => (transmitted, [(1.0 - self.reflected_share) * -wi.z / PI; WAVES]),
        }
    }

    #[inline(always)]
    pub(super) fn sample(&self, _wo: DVec3, u: [f64; 3]) -> Option<(DVec3, Lobes)> {
        let above = self.transmitted.is_none() || u[2] < self.reflected_share;
        let (sine, azimuth) = (u[0].sqrt(), TAU * u[1]);
        let z = (1.0 - u[0]).max(0.0).sqrt();
        let side = if above { Lobes::REFLECTION } else { Lobes::TRANSMISSION };
        let wi = DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), if above { z } else { -z });
        Some((wi, side.and(Lobes::DIFFUSE)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paint_is_the_colour_times_the_picture_and_has_holes() {
        let picture = |left: f32, right: f32| Texture::new([2, 1], vec![[left; 3], [right; 3]]).unwrap();
        let half = picture(0.5, 1.0);
        let surface = Lambertian::painted(
            [1.0; 3],
            Pictures { albedo: Some(half), alpha: Some(picture(0.0, 1.0)), relief: None },
        )
        .unwrap();
        let at = |u: f64| Hit { uv: [u, 0.5], ..Hit::default() };
        for (u, albedo, opacity) in [(0.25, 0.5, 0.0), (0.75, 1.0, 1.0)] {
            let bsdf = surface.bind(
                &at(u),
                DVec3::Z,
                Lambdas::new([400.0, 450.0, 500.0, 550.0, 600.0, 650.0, 680.0, 700.0]),
            );
            let f = bsdf.eval(DVec3::Z).f;
            assert!(f.iter().all(|f| (f * PI - albedo).abs() < 1e-9), "{f:?}");
            assert_eq!(surface.opacity(&at(u)), opacity);
        }
        assert!(!surface.is_opaque() && Lambertian::painted([1.1, 0.0, 0.0], Pictures::default()).is_err());
    }

    /// A normal that leans by 45° to the right sees light from there at full cosine; a straight one changes nothing.
    #[test]
    fn normal_maps_lean_the_shading_frame() {
        let leaning = 0.5 + 0.5 * std::f32::consts::FRAC_1_SQRT_2;
        let at = |texel: [f32; 3]| {
            let relief = Some(Relief::Normals(Texture::new([1, 1], vec![texel]).unwrap()));
            let surface = Lambertian::painted([1.0; 3], Pictures { relief, ..Pictures::default() }).unwrap();
            surface
                .bind(&Hit::default(), DVec3::Z, Lambdas::splat(550.0))
                .eval(DVec3::new(0.6, 0.0, 0.8))
                .cosine
        };
        assert!((at([0.5, 0.5, 1.0]) - 0.8).abs() < 1e-6);
        assert!((at([leaning, 0.5, leaning]) - 1.4 * std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-6);
        assert!((at([0.5, leaning, leaning]) - 0.8 * std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-6);
    }

    /// Where a picture is blue the film's own formula at the viewer's angle, at every wavelength; elsewhere the picture.
    #[test]
    fn blue_paint_shows_the_film_of_2005() {
        let picture = Texture::new([2, 1], vec![[0.02, 0.02, 0.5], [0.4, 0.2, 0.1]]).unwrap();
        let pictures = Pictures { albedo: Some(picture), ..Pictures::default() };
        let plain = Lambertian::painted([1.0; 3], pictures).unwrap();
        let film = plain.clone().iridescent(PhaseFilm::new(140.0, 1.54).unwrap());
        let waves = Lambdas::new([400.0, 431.2, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0]);
        for angle in [0.0_f64, 0.4, 1.1] {
            let wo = DVec3::new(0.0, angle.sin(), angle.cos());
            let wi = DVec3::new(0.3, 0.2, 0.9).normalize();
            let f = |surface: &Lambertian, u: f64| {
                surface.bind(&Hit { uv: [u, 0.5], ..Hit::default() }, wo, waves).eval(wi).f
            };
            for (found, nm) in f(&film, 0.25).into_iter().zip(waves.nm()) {
                let delta = 4.0 * PI * 140.0 / nm * (1.54 * 1.54 - angle.sin() * angle.sin()).sqrt() + PI;
                assert!((found * PI - delta.cos().powi(2)).abs() < 1e-12, "{nm} {angle}");
            }
            assert_eq!(f(&film, 0.75), f(&plain, 0.75));
            assert_ne!(f(&film, 0.25), f(&plain, 0.25));
        }
        assert!(film.even().is_none());
    }

    #[test]
    fn a_sheet_that_gives_more_than_it_gets_is_refused() {
        let half = || Reflectance::new(|_| 0.6).unwrap();
        assert!(Lambertian::translucent(half(), half()).is_err());
        assert!(Lambertian::translucent(half(), Reflectance::new(|_| 0.4).unwrap()).is_ok());
    }
}
