//! Perfectly diffuse surfaces, opaque or translucent: constant f on each side.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::hit::Hit;
use super::lobes::Lobes;
use super::reflectance::Reflectance;
use super::{Bsdf, Model};
use crate::spectrum::dense::{Lambdas, WAVES};
use crate::{Error, Result};

/// Perfectly diffuse, the same seen from both sides.
#[derive(Debug, Clone)]
pub struct Lambertian {
    reflectance: Reflectance,
    /// What goes diffusely to the other side.
    transmittance: Option<Reflectance>,
}

impl Lambertian {
    /// Opaque.
    #[must_use]
    pub fn new(reflectance: Reflectance) -> Self {
        Self { reflectance, transmittance: None }
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
        Ok(Self { reflectance, transmittance: Some(transmittance) })
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
        let bound = Bound { reflected: f(&self.reflectance), transmitted, reflected_share };
        Bsdf::new(Model::Lambertian(bound), hit.side(wo))
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
    fn a_sheet_that_gives_more_than_it_gets_is_refused() {
        let half = || Reflectance::new(|_| 0.6).unwrap();
        assert!(Lambertian::translucent(half(), half()).is_err());
        assert!(Lambertian::translucent(half(), Reflectance::new(|_| 0.4).unwrap()).is_ok());
    }
}
