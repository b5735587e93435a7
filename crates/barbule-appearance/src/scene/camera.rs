//! Cameras: perspective with a thin lens, or orthographic.

use std::f64::consts::{FRAC_PI_4, TAU};

use glam::{DVec2, DVec3};

/// How a camera projects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Rays from the eye through the focal plane; `lens_radius` mm (0: a pinhole).
    Perspective {
        /// Radius of the lens, mm.
        lens_radius: f64,
    },
    /// Parallel rays.
    Orthographic,
}

/// A camera that looks from `eye` at `target`; the plane through `target` is in focus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Where it stands, mm.
    pub eye: DVec3,
    /// What it looks at and focuses on, mm.
    pub target: DVec3,
    /// Upwards in the picture.
    pub up: DVec3,
    /// Width of the picture in the plane of focus, mm.
    pub width_mm: f64,
    /// How it projects.
    pub projection: Projection,
}

/// A camera ray with its footprint.
#[derive(Debug, Clone, Copy)]
pub struct CameraRay {
    /// Origin, mm.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
    /// Radius of a pixel's footprint at the origin, mm.
    pub footprint: f64,
    /// Growth of that radius per mm along the ray.
    pub spread: f64,
}

impl Camera {
    /// Prepares it for rays of a picture of this size, pixels.
    #[must_use]
    pub fn view(&self, size: [u32; 2]) -> View {
        let ahead = self.target - self.eye;
        let distance = ahead.length();
        let forward = ahead / distance;
        let right = forward.cross(self.up).normalize();
        let up = right.cross(forward);
        let height = self.width_mm * f64::from(size[1]) / f64::from(size[0]);
        let pixel = 0.5 * self.width_mm / f64::from(size[0]);
        let (lens_radius, spread) = match self.projection {
            Projection::Orthographic => (None, 0.0),
            Projection::Perspective { lens_radius } => (Some(lens_radius), pixel / distance),
        };
        View { camera: *self, forward, right, up, height, pixel, lens_radius, spread }
    }

    /// The ray through a point of the picture. `point`: 0 … 1 from left to right, 0 … 1 from top to bottom;
    /// `lens`: two uniform numbers; `size`: pixels.
    #[must_use]
    pub fn ray(&self, point: DVec2, lens: DVec2, size: [u32; 2]) -> CameraRay {
        self.view(size).ray(point, lens)
    }
}

/// What all rays of a camera and a size share.
#[derive(Debug, Clone, Copy)]
pub struct View {
    camera: Camera,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    /// Of the picture in the plane of focus, mm.
    height: f64,
    /// Half the width of a pixel there, mm.
    pixel: f64,
    /// `None`: parallel rays.
    lens_radius: Option<f64>,
    spread: f64,
}

impl View {
    /// As [`Camera::ray`].
    #[inline(always)]
    #[must_use]
    pub fn ray(&self, point: DVec2, lens: DVec2) -> CameraRay {
        let Self { camera, right, up, .. } = *self;
        let shift = right * ((point.x - 0.5) * camera.width_mm) + up * ((0.5 - point.y) * self.height);
        let Some(lens_radius) = self.lens_radius else {
            let origin = camera.eye + shift;
            return CameraRay { origin, direction: self.forward, footprint: self.pixel, spread: 0.0 };
        };
        let mut origin = camera.eye;
        if lens_radius > 0.0 {
            let on_lens = disk(lens) * lens_radius;
            origin += right * on_lens.x + up * on_lens.y;
        }
        let direction = (camera.target + shift - origin).normalize();
        CameraRay { origin, direction, footprint: 0.0, spread: self.spread }
    }

    /// Origins and directions (not of length 1) that all rays through a rectangle of the picture lie between.
    #[must_use]
    pub fn corners(&self, low: DVec2, high: DVec2) -> Vec<(DVec3, DVec3)> {
        let Self { camera, right, up, .. } = *self;
        let mut corners = Vec::with_capacity(16);
        for [x, y] in [[low.x, low.y], [high.x, low.y], [low.x, high.y], [high.x, high.y]] {
            let at = camera.target + right * ((x - 0.5) * camera.width_mm) + up * ((0.5 - y) * self.height);
            let Some(radius) = self.lens_radius else {
                corners.push((at - camera.target + camera.eye, self.forward));
                continue;
            };
            for [u, v] in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
                let origin = camera.eye + (right * u + up * v) * radius;
                corners.push((origin, at - origin));
            }
        }
        corners
    }
}

/// Uniform on the unit disk from two uniform numbers (Shirley and Chiu 1997, the concentric map).
#[must_use]
pub fn disk(u: DVec2) -> DVec2 {
    let p = 2.0 * u - DVec2::ONE;
    if p == DVec2::ZERO {
        return DVec2::ZERO;
    }
    let (radius, angle) = if p.x.abs() > p.y.abs() {
        (p.x, FRAC_PI_4 * p.y / p.x)
    } else {
        (p.y, TAU / 4.0 - FRAC_PI_4 * p.x / p.y)
    };
    radius * DVec2::new(angle.cos(), angle.sin())
}

/// The direction of an azimuth and elevation in the vane's frame, rad: azimuth in the vane's plane from the shaft's
/// tip (+y) clockwise seen from above (+z), elevation above the plane.
#[must_use]
pub fn direction(azimuth: f64, elevation: f64) -> DVec3 {
    let (sin_azimuth, cos_azimuth) = azimuth.sin_cos();
    let (sin_elevation, cos_elevation) = elevation.sin_cos();
    DVec3::new(cos_elevation * sin_azimuth, cos_elevation * cos_azimuth, sin_elevation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_ray_hits_the_target_and_the_right_edge_is_half_a_width_away() {
        let camera = Camera {
            eye: DVec3::new(0.0, 0.0, 10.0),
            target: DVec3::ZERO,
            up: DVec3::Y,
            width_mm: 4.0,
            projection: Projection::Perspective { lens_radius: 0.5 },
        };
        for (x, expected) in [(0.5, 0.0), (1.0, 2.0)] {
            let ray = camera.ray(DVec2::new(x, 0.5), DVec2::new(0.9, 0.2), [100, 50]);
            let at = ray.origin + ray.direction * (-ray.origin.z / ray.direction.z);
            assert!((at - DVec3::new(expected, 0.0, 0.0)).length() < 1e-12);
        }
    }

    #[test]
    fn azimuth_90_is_to_the_right_of_the_tip() {
        assert!((direction(std::f64::consts::FRAC_PI_2, 0.0) - DVec3::X).length() < 1e-15);
        assert!((direction(0.0, 0.0) - DVec3::Y).length() < 1e-15);
    }
}
