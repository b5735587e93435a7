//! Lamps: sun discs, rectangles, spheres, points and spots.
//!
//! Radiance is in units in which a white diffuse surface lit by a hemisphere of radiance 1 of standard daylight has
//! luminance 1. The zenith is +z, the side of the vane that the camera sees.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::emission::Emission;

/// A light of its own place and shape.
#[derive(Debug, Clone)]
pub enum Light {
    /// A disc at infinity.
    Sun(Sun),
    /// A rectangle that shines to one side.
    Rectangle(Rectangle),
    /// A sphere.
    Sphere(Sphere),
    /// A point.
    Point(Point),
    /// A point that shines into a cone.
    Spot(Spot),
}

impl Light {
    /// Its spectrum: radiance, or of points intensity.
    #[must_use]
    pub fn emission(&self) -> &Emission {
        match self {
            Self::Sun(Sun { emission, .. })
            | Self::Rectangle(Rectangle { emission, .. })
            | Self::Sphere(Sphere { emission, .. })
            | Self::Point(Point { emission, .. })
            | Self::Spot(Spot { emission, .. }) => emission,
        }
    }

    /// The light after a turn about the origin.
    #[must_use]
    pub fn turned(mut self, turn: DMat3) -> Self {
        match &mut self {
            Self::Sun(sun) => sun.direction = turn * sun.direction,
            Self::Rectangle(Rectangle { corner, edge_u, edge_v, .. }) => {
                for v in [corner, edge_u, edge_v] {
                    *v = turn * *v;
                }
            }
            Self::Sphere(sphere) => sphere.centre = turn * sphere.centre,
            Self::Point(point) => point.position = turn * point.position,
            Self::Spot(spot) => {
                spot.position = turn * spot.position;
                spot.axis = turn * spot.axis;
            }
        }
        self
    }
}

/// A light with its share of the samples.
#[derive(Debug, Clone)]
pub struct Lamp {
    /// The light.
    pub light: Light,
    /// How often it is chosen, relative to the others; over 0.
    pub weight: f64,
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

/// A point that shines alike into all directions.
#[derive(Debug, Clone)]
pub struct Point {
    /// Where it is, mm.
    pub position: DVec3,
    /// Intensity: irradiance times the square of the distance in mm.
    pub emission: Emission,
}

/// A point that shines into a cone, at whose edge it fades.
#[derive(Debug, Clone)]
pub struct Spot {
    /// Where it is, mm.
    pub position: DVec3,
    /// Unit vector along the middle of the cone.
    pub axis: DVec3,
    /// Cosine of the angle from the axis beyond which there is no light.
    pub cos_outer: f64,
    /// Cosine of the angle within which there is all of it; at least `cos_outer`.
    pub cos_inner: f64,
    /// Intensity within: irradiance times the square of the distance in mm.
    pub emission: Emission,
}

impl Spot {
    /// Share of the intensity in a unit direction away from the spot: a cubic step between both cosines.
    #[inline]
    #[must_use]
    pub fn share(&self, direction: DVec3) -> f64 {
        let cosine = self.axis.dot(direction);
        if cosine < self.cos_outer {
            return 0.0;
        }
        let width = self.cos_inner - self.cos_outer;
        let t = if width > 0.0 { ((cosine - self.cos_outer) / width).min(1.0) } else { 1.0 };
        t * t * (3.0 - 2.0 * t)
    }
}

impl Rectangle {
    /// Irradiance of a surface at the origin that faces the rectangle's middle if the radiance were 1, of a rectangle that lies
    /// wholly above its horizon (Lambert 1760; Arvo 1994, eq. 2.19).
    #[must_use]
    pub fn irradiance_at_origin(&self) -> f64 {
        let Self { corner, edge_u, edge_v, .. } = self;
        let corners = [*corner, corner + edge_u, corner + edge_u + edge_v, corner + edge_v];
        let facing = (corner + 0.5 * (edge_u + edge_v)).normalize_or_zero();
        let edges = (0..4).map(|i| {
            let (from, to) = (corners[i].normalize_or_zero(), corners[(i + 1) % 4].normalize_or_zero());
            let across = from.cross(to);
            let angle = libm::atan2(across.length(), from.dot(to));
            angle * across.normalize_or_zero().dot(facing)
        });
        0.5 * edges.sum::<f64>().abs()
    }
}

/// Radiance of a disc of this angular radius, rad, that gives a surface facing it irradiance π · `exposure`: as much
/// light as a hemisphere of radiance `exposure`.
#[must_use]
pub fn disc_radiance(radius: f64, exposure: f64) -> f64 {
    let sine = radius.sin();
    PI * exposure / (PI * sine * sine)
}
