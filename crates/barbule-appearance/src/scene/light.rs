//! Lights: a sky from an image or a gradient, sun discs, rectangles and spheres.
//!
//! Radiance is in units in which a white diffuse surface lit by a hemisphere of radiance 1 of standard daylight has
//! luminance 1. The sky's zenith is +z, the side of the vane that the camera sees.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::emission::Emission;
use super::frame::Frame;
use super::sky::Sky;

/// A light.
#[derive(Debug, Clone)]
pub enum Light {
    /// From everywhere.
    Sky(Sky),
    /// A disc at infinity.
    Sun(Sun),
    /// A rectangle that shines to one side.
    Rectangle(Rectangle),
    /// A sphere.
    Sphere(Sphere),
}

/// A disc at infinity of uniform radiance.
#[derive(Debug, Clone)]
pub struct Sun {
    /// Unit vector towards its middle.
    pub direction: DVec3,
    /// Cosine of its angular radius.
    pub cos_radius: f64,
    /// Radiance.
    pub emission: Emission,
}

/// A rectangle; shines where `edge_u` × `edge_v` points.
#[derive(Debug, Clone)]
pub struct Rectangle {
    /// One corner, mm.
    pub corner: DVec3,
    /// From that corner along one side, mm.
    pub edge_u: DVec3,
    /// Along the other, perpendicular to the first, mm.
    pub edge_v: DVec3,
    /// Radiance.
    pub emission: Emission,
}

/// A sphere of uniform radiance.
#[derive(Debug, Clone)]
pub struct Sphere {
    /// Middle, mm.
    pub centre: DVec3,
    /// Radius, mm.
    pub radius: f64,
    /// Radiance.
    pub emission: Emission,
}

/// A direction towards a light.
#[derive(Debug, Clone, Copy)]
pub struct LightSample {
    /// Unit vector from the point towards the light.
    pub direction: DVec3,
    /// How far the light is, mm; infinite for skies and suns.
    pub distance: f64,
    /// Density of the direction, 1/sr.
    pub pdf: f64,
    /// Radiance that arrives if nothing stands between.
    pub radiance: [f64; 4],
}

impl Light {
    /// Whether only rays that leave the scene see it.
    #[must_use]
    pub fn is_infinite(&self) -> bool {
        matches!(self, Self::Sky(_) | Self::Sun(_))
    }

    /// A direction from `point` towards the light; `None` where the light cannot be seen from there.
    #[must_use]
    pub fn sample(&self, point: DVec3, u: DVec2, wavelengths_nm: [f64; 4]) -> Option<LightSample> {
        match self {
            Self::Sky(sky) => sky.sample(u, wavelengths_nm),
            Self::Sun(sun) => {
                let direction = cone(sun.direction, sun.cos_radius, u);
                let pdf = 1.0 / (TAU * (1.0 - sun.cos_radius));
                let radiance = sun.emission.at4(wavelengths_nm);
                Some(LightSample { direction, distance: f64::INFINITY, pdf, radiance })
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
                    radiance: rectangle.emission.at4(wavelengths_nm),
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
                Some(LightSample { direction, distance, pdf, radiance: sphere.emission.at4(wavelengths_nm) })
            }
        }
    }

    /// Density with which [`Light::sample`] draws this direction, 1/sr, for a ray known to see the light.
    #[must_use]
    pub fn pdf(&self, point: DVec3, direction: DVec3) -> f64 {
        match self {
            Self::Sky(sky) => sky.pdf(direction),
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
        }
    }

    /// Radiance along a ray that leaves the scene; zero for lights that stand in it.
    #[must_use]
    pub fn escaped(&self, direction: DVec3, wavelengths_nm: [f64; 4]) -> [f64; 4] {
        match self {
            Self::Sky(sky) => sky.radiance(direction, wavelengths_nm),
            Self::Sun(sun) if sun.direction.dot(direction) >= sun.cos_radius => {
                sun.emission.at4(wavelengths_nm)
            }
            _ => [0.0; 4],
        }
    }

    /// Radiance of a light that stands in the scene, seen along a ray that hits it.
    #[must_use]
    pub fn emitted(&self, wavelengths_nm: [f64; 4]) -> [f64; 4] {
        match self {
            Self::Rectangle(rectangle) => rectangle.emission.at4(wavelengths_nm),
            Self::Sphere(sphere) => sphere.emission.at4(wavelengths_nm),
            Self::Sky(_) | Self::Sun(_) => [0.0; 4],
        }
    }

    /// Distance at which a ray hits the shining side of a light that stands in the scene.
    #[must_use]
    pub fn hit(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        match self {
            Self::Sky(_) | Self::Sun(_) => None,
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

/// Uniform in a cone about a unit vector.
#[must_use]
pub fn cone(axis: DVec3, cos_radius: f64, u: DVec2) -> DVec3 {
    let cosine = 1.0 - u.x * (1.0 - cos_radius);
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (sin_azimuth, cos_azimuth) = (TAU * u.y).sin_cos();
    Frame::around(axis).to_world(DVec3::new(sine * cos_azimuth, sine * sin_azimuth, cosine))
}

/// Radiance of a disc of this angular radius, rad, that gives a surface facing it irradiance π · `exposure`: as much
/// light as a hemisphere of radiance `exposure`.
#[must_use]
pub fn disc_radiance(radius: f64, exposure: f64) -> f64 {
    let sine = radius.sin();
    PI * exposure / (PI * sine * sine)
}
