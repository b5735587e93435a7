//! Directions towards lamps, and what is seen of them.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::sample::LightSample;
use crate::bsdf::Frame;
use crate::scene::light::Light;
use crate::spectrum::dense::{Lambdas, WAVES};

impl Light {
    /// Whether only rays that leave the scene see it.
    #[inline(always)]
    pub(super) fn is_infinite(&self) -> bool {
        matches!(self, Self::Sun(_))
    }

    /// Whether no ray ever meets it.
    pub(super) fn is_point(&self) -> bool {
        matches!(self, Self::Point(_) | Self::Spot(_))
    }

    /// A direction from `point` towards the light; `None` where the light cannot be seen from there.
    #[inline(always)]
    pub(super) fn sample(&self, point: DVec3, u: DVec2, wavelengths: Lambdas) -> Option<LightSample> {
        match self {
            Self::Sun(sun) => {
                let direction = cone(sun.direction, sun.cos_radius, u);
                let pdf = 1.0 / (TAU * (1.0 - sun.cos_radius));
                let radiance = sun.emission.at_each(wavelengths);
                Some(LightSample { direction, distance: f64::INFINITY, pdf, radiance, is_point: false })
            }
            Self::Rectangle(rectangle) => {
                let to = rectangle.corner + rectangle.edge_u * u.x + rectangle.edge_v * u.y - point;
                let normal = rectangle.edge_u.cross(rectangle.edge_v);
                let distance = to.length();
                let direction = to / distance;
                // The normal's length is the area, so this is cos · area.
                let projected = -normal.dot(direction);
                (projected > 0.0).then(|| LightSample {
                    direction,
                    distance,
                    pdf: distance * distance / projected,
                    radiance: rectangle.emission.at_each(wavelengths),
                    is_point: false,
                })
            }
            Self::Sphere(sphere) => {
                let to = sphere.centre - point;
                let squared = to.length_squared();
                let sin2 = sphere.radius * sphere.radius / squared;
                if sin2 >= 1.0 {
                    return None;
                }
                let one_minus_cos = sin2 / (1.0 + (1.0 - sin2).sqrt());
                let direction = cone(to / squared.sqrt(), 1.0 - one_minus_cos, u);
                let distance = self.hit(point, direction).unwrap_or_else(|| to.dot(direction));
                let pdf = 1.0 / (TAU * one_minus_cos);
                let radiance = sphere.emission.at_each(wavelengths);
                Some(LightSample { direction, distance, pdf, radiance, is_point: false })
            }
            Self::Point(lamp) => from_point(lamp.position - point, 1.0, lamp.emission.at_each(wavelengths)),
            Self::Spot(lamp) => {
                let to = lamp.position - point;
                from_point(to, lamp.share(-to.normalize_or_zero()), lamp.emission.at_each(wavelengths))
            }
        }
    }

    /// Density with which [`Light::sample`] draws this direction, 1/sr, for a ray known to see the light.
    pub(super) fn pdf(&self, point: DVec3, direction: DVec3) -> f64 {
        match self {
            Self::Sun(sun) if sun.direction.dot(direction) >= sun.cos_radius => {
                1.0 / (TAU * (1.0 - sun.cos_radius))
            }
            Self::Sun(_) => 0.0,
            Self::Rectangle(rectangle) => self.hit(point, direction).map_or(0.0, |distance| {
                distance * distance / -rectangle.edge_u.cross(rectangle.edge_v).dot(direction)
            }),
            Self::Sphere(sphere) => {
                let sin2 = sphere.radius * sphere.radius / (sphere.centre - point).length_squared();
                if sin2 >= 1.0 || self.hit(point, direction).is_none() {
                    return 0.0;
                }
                1.0 / (TAU * sin2 / (1.0 + (1.0 - sin2).sqrt()))
            }
            Self::Point(_) | Self::Spot(_) => 0.0,
        }
    }

    /// Radiance along a ray that leaves the scene; zero for lights that stand in it.
    pub(super) fn escaped(&self, direction: DVec3, wavelengths: Lambdas) -> [f64; WAVES] {
        if self.is_behind(direction) { self.emission().at_each(wavelengths) } else { [0.0; WAVES] }
    }

    /// Whether a ray that leaves the scene sees it.
    pub(super) fn is_behind(&self, direction: DVec3) -> bool {
        matches!(self, Self::Sun(sun) if sun.direction.dot(direction) >= sun.cos_radius)
    }

    /// Radiance of a light that stands in the scene, seen along a ray that hits it.
    pub(super) fn emitted(&self, wavelengths: Lambdas) -> [f64; WAVES] {
        match self {
            Self::Rectangle(rectangle) => rectangle.emission.at_each(wavelengths),
            Self::Sphere(sphere) => sphere.emission.at_each(wavelengths),
            Self::Sun(_) | Self::Point(_) | Self::Spot(_) => [0.0; WAVES],
        }
    }

    /// Distance at which a ray hits the shining side of a light that stands in the scene.
    #[inline(always)]
    pub(super) fn hit(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        match self {
            Self::Sun(_) | Self::Point(_) | Self::Spot(_) => None,
            Self::Rectangle(rectangle) => {
                let normal = rectangle.edge_u.cross(rectangle.edge_v);
                let cosine = normal.dot(direction);
                if cosine >= 0.0 {
                    return None;
                }
                let distance = normal.dot(rectangle.corner - origin) / cosine;
                let at = origin + direction * distance - rectangle.corner;
                let along = |edge: DVec3| (0.0..=1.0).contains(&(at.dot(edge) / edge.length_squared()));
                (distance > 0.0 && along(rectangle.edge_u) && along(rectangle.edge_v)).then_some(distance)
            }
            Self::Sphere(sphere) => {
                let to = sphere.centre - origin;
                let along = to.dot(direction);
                let miss2 = (to - direction * along).length_squared();
                let half2 = sphere.radius * sphere.radius - miss2;
                if half2 < 0.0 {
                    return None;
                }
                let distance = along - half2.sqrt();
                (distance > 0.0).then_some(distance)
            }
        }
    }
}

/// What a point gives that lies `to` mm away, a share of its intensity.
fn from_point(to: DVec3, share: f64, intensity: [f64; WAVES]) -> Option<LightSample> {
    let squared = to.length_squared();
    (squared > 0.0 && share > 0.0).then(|| {
        let distance = squared.sqrt();
        let radiance = intensity.map(|value| value * share / squared);
        LightSample { direction: to / distance, distance, pdf: 1.0, radiance, is_point: true }
    })
}

/// Uniform in a cone about a unit vector.
fn cone(axis: DVec3, cos_radius: f64, u: DVec2) -> DVec3 {
    let cosine = 1.0 - u.x * (1.0 - cos_radius);
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (sin_azimuth, cos_azimuth) = (TAU * u.y).sin_cos();
    Frame::around(axis).to_world(DVec3::new(sine * cos_azimuth, sine * sin_azimuth, cosine))
}
