//! Scattering at a surface point, whatever the surface is made of.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::point::SurfacePoint;
use crate::brdf::Prepared;
use crate::scene::frame::Frame;
use crate::scene::keratin::{Keratin, Reflectance};
use crate::scene::surface::Surface;

/// The scattering function of one surface point seen from one direction at four wavelengths.
///
/// Directions are unit vectors of the scene that point away from the surface. `f` is in 1/sr without the cosine. The
/// camera's side is the incident one of models that are not reciprocal: light paths are followed backwards.
pub struct Bsdf<'a> {
    model: Model<'a>,
    frame: Frame,
    normal: DVec3,
    /// Towards the camera, in the frame.
    local: DVec3,
    wavelengths_nm: [f64; 4],
}

#[allow(clippy::large_enum_variant)] // lives on the stack for one point; a box would be an allocation a hit
enum Model<'a> {
    Lambertian(&'a Reflectance),
    Keratin(&'a Keratin),
    Feather(Prepared<'a>, Option<u64>),
}

/// Value and densities for one direction.
#[derive(Debug, Clone, Copy)]
pub struct Evaluation {
    /// 1/sr, at each wavelength.
    pub f: [f64; 4],
    /// Density of the direction if that wavelength were the hero, 1/sr.
    pub pdf: [f64; 4],
    /// Cosine between the direction and the shading normal.
    pub cosine: f64,
}

const NOTHING: Evaluation = Evaluation { f: [0.0; 4], pdf: [0.0; 4], cosine: 0.0 };

impl<'a> Bsdf<'a> {
    /// At a point, for light that leaves in the direction `towards` (the camera's side).
    #[must_use]
    pub fn new(surface: &'a Surface, point: &SurfacePoint, towards: DVec3, wavelengths_nm: [f64; 4]) -> Self {
        let upper = towards.dot(point.normal) >= 0.0;
        let (normal, mut frame) =
            if upper { (point.normal, point.frame) } else { (-point.normal, point.frame.flipped()) };
        if towards.dot(frame.z) <= 0.0 {
            // The interpolated normal looks away although the face does not: shade the face itself.
            frame = Frame::new(normal, frame.y);
        }
        let local = frame.to_local(towards);
        let model = match surface {
            Surface::Lambertian(reflectance) => Model::Lambertian(reflectance),
            Surface::Keratin(keratin) => Model::Keratin(keratin),
            Surface::Barbule(barbule) if upper && local.z > 0.0 => {
                let prepared = barbule.brdf.prepare(wavelengths_nm.map(|w| w as f32), local);
                Model::Feather(prepared, barbule.instances.then_some(point.instance))
            }
            Surface::Barbule(barbule) => Model::Keratin(&barbule.under),
        };
        Self { model, frame, normal, local, wavelengths_nm }
    }

    /// The shading normal on the camera's side.
    #[must_use]
    pub fn shading_normal(&self) -> DVec3 {
        self.frame.z
    }

    /// Scattering into `direction`.
    #[must_use]
    pub fn eval(&self, direction: DVec3) -> Evaluation {
        let local = self.frame.to_local(direction);
        if direction.dot(self.normal) <= 0.0 || local.z <= 0.0 || self.local.z <= 0.0 {
            return NOTHING;
        }
        match &self.model {
            Model::Lambertian(reflectance) => Evaluation {
                f: self.wavelengths_nm.map(|w| reflectance.at(w) / PI),
                pdf: [local.z / PI; 4],
                cosine: local.z,
            },
            Model::Keratin(keratin) => {
                let (f, pdf) = keratin.eval(self.local, local, self.wavelengths_nm);
                Evaluation { f, pdf: [pdf; 4], cosine: local.z }
            }
            Model::Feather(prepared, instance) => Evaluation {
                f: prepared.eval(local, *instance).map(f64::from),
                pdf: prepared.pdf4(local),
                cosine: local.z,
            },
        }
    }

    /// Draws a direction from three uniform numbers; `None` where nothing is scattered.
    #[must_use]
    pub fn sample(&self, u: [f64; 3]) -> Option<(DVec3, Evaluation)> {
        let local = match &self.model {
            Model::Lambertian(_) => {
                let (sine, azimuth) = (u[0].sqrt(), TAU * u[1]);
                DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), (1.0 - u[0]).max(0.0).sqrt())
            }
            Model::Keratin(keratin) => keratin.sample(self.local, u),
            Model::Feather(prepared, _) => prepared.direction(0, [u[0], u[1]])?,
        };
        let direction = self.frame.to_world(local).normalize();
        let evaluation = self.eval(direction);
        (evaluation.pdf[0] > 0.0).then_some((direction, evaluation))
    }
}
