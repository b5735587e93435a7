//! Orthonormal frames.

use glam::DVec3;

/// A right-handed orthonormal frame. For a barbule x lies across, y along its long axis, z is the plate's normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Across.
    pub x: DVec3,
    /// Along.
    pub y: DVec3,
    /// Normal.
    pub z: DVec3,
}

impl Frame {
    /// The frame with this unit normal and y as near as possible to `along`; any frame when they are parallel.
    #[must_use]
    pub fn new(z: DVec3, along: DVec3) -> Self {
        let y = along - z * z.dot(along);
        let y = if y.length_squared() > 1e-16 { y.normalize() } else { z.any_orthonormal_vector() };
        Self { x: y.cross(z), y, z }
    }

    /// The frame with this unit normal and any y.
    #[must_use]
    pub fn around(z: DVec3) -> Self {
        Self::new(z, z.any_orthonormal_vector())
    }

    /// A world direction in this frame.
    #[inline(always)]
    #[must_use]
    pub fn to_local(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }

    /// A direction of this frame in the world.
    #[inline(always)]
    #[must_use]
    pub fn to_world(&self, v: DVec3) -> DVec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    /// The frame turned about x, so that y rises by this angle.
    #[inline(always)]
    #[must_use]
    pub fn pitched(&self, angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { x: self.x, y: self.y * cos + self.z * sin, z: self.z * cos - self.y * sin }
    }

    /// The same axis along, upside down: what the underside sees.
    #[inline(always)]
    #[must_use]
    pub fn flipped(&self) -> Self {
        Self { x: -self.x, y: self.y, z: -self.z }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_right_handed_and_invert() {
        let frame = Frame::new(DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.3, 1.0, -0.2));
        assert!((frame.x.cross(frame.y) - frame.z).length() < 1e-14);
        let v = DVec3::new(0.1, -0.7, 0.4);
        assert!((frame.to_world(frame.to_local(v)) - v).length() < 1e-14);
        let f = frame.flipped();
        assert!((f.x.cross(f.y) - f.z).length() < 1e-14);
    }
}
