//! Lamps: sun discs, rectangles and spheres.
//!
//! Radiance is in units in which a white diffuse surface lit by a hemisphere of radiance 1 of standard daylight has
//! luminance 1. The zenith is +z, the side of the vane that the camera sees.

use std::f64::consts::PI;

use glam::DVec3;

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

/// Radiance of a disc of this angular radius, rad, that gives a surface facing it irradiance π · `exposure`: as much
/// light as a hemisphere of radiance `exposure`.
#[must_use]
pub fn disc_radiance(radius: f64, exposure: f64) -> f64 {
    let sine = radius.sin();
    PI * exposure / (PI * sine * sine)
}
