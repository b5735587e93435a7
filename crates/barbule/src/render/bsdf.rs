//! Scattering at a surface point, whatever the surface is made of.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::point::SurfacePoint;
use crate::scene::frame::Frame;
use crate::scene::surface::Surface;

/// The scattering function of one surface point seen from one direction at four wavelengths.
///
/// Directions are unit vectors of the scene that point away from the surface. `f` is in 1/sr without the cosine. The
/// camera's side is the incident one of models that are not reciprocal: light paths are followed backwards.
pub struct Bsdf<'a> {
    surface: &'a Surface,
    frame: Frame,
    normal: DVec3,
    towards: DVec3,
    local: DVec3,
    wavelengths_nm: [f64; 4],
}

/// Value and densities for one direction.
#[derive(Debug, Clone, Copy)]
pub struct Evaluation {
    /// 1/sr, at each wavelength.
    pub f: [f64; 4],
    /// Density of the direction if that wavelength were the hero, 1/sr.
    pub pdf: [f64; 4],
    /// |cos| between the direction and the shading normal.
    pub cosine: f64,
}

const NOTHING: Evaluation = Evaluation { f: [0.0; 4], pdf: [0.0; 4], cosine: 0.0 };

impl<'a> Bsdf<'a> {
    /// At a point, for light that leaves in the direction `towards` (the camera's side).
    #[must_use]
    pub fn new(
        surface: &'a Surface,
        point: &SurfacePoint,
        towards: DVec3,
        wavelengths_nm: [f64; 4],
    ) -> Self {
        let upper = towards.dot(point.normal) >= 0.0;
        let (normal, mut frame) =
            if upper { (point.normal, point.frame) } else { (-point.normal, point.frame.flipped()) };
        if towards.dot(frame.z) <= 0.0 {
            // The interpolated normal looks away although the face does not: shade the face itself.
            frame = Frame::new(normal, frame.y);
        }
        let local = frame.to_local(towards);
        Self { surface, frame, normal, towards, local, wavelengths_nm }
    }

    /// Share of the light that passes the surface unchanged in direction, 0 … 1.
    #[must_use]
    pub fn straight_through(&self) -> f64 {
        0.0
    }

    /// The shading normal on the camera's side.
    #[must_use]
    pub fn shading_normal(&self) -> DVec3 {
        self.frame.z
    }

    /// Scattering into `direction`.
    #[must_use]
    pub fn eval(&self, direction: DVec3) -> Evaluation {
        if direction.dot(self.normal) <= 0.0 || self.towards.dot(self.normal) <= 0.0 {
            return NOTHING;
        }
        let local = self.frame.to_local(direction);
        if local.z <= 0.0 {
            return NOTHING;
        }
        match self.surface {
            Surface::Lambertian(reflectance) => Evaluation {
                f: self.wavelengths_nm.map(|w| reflectance.at(w) / PI),
                pdf: [local.z / PI; 4],
                cosine: local.z,
            },
            Surface::Keratin(keratin) => {
                let (f, pdf) = keratin.eval(self.local, local, self.wavelengths_nm);
                Evaluation { f, pdf: [pdf; 4], cosine: local.z }
            }
        }
    }

    /// Draws a direction from three uniform numbers; `None` where nothing is scattered.
    #[must_use]
    pub fn sample(&self, u: [f64; 3]) -> Option<(DVec3, Evaluation)> {
        let local = match self.surface {
            Surface::Lambertian(_) => {
                let (sine, azimuth) = (u[0].sqrt(), TAU * u[1]);
                DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), (1.0 - u[0]).max(0.0).sqrt())
            }
            Surface::Keratin(keratin) => keratin.sample(self.local, u),
        };
        let direction = self.frame.to_world(local).normalize();
        let evaluation = self.eval(direction);
        (evaluation.pdf[0] > 0.0).then_some((direction, evaluation))
    }
}
