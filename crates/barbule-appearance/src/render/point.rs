//! What a BSDF sees of the place that a ray hit.

use glam::DVec3;

use crate::scene::frame::Frame;

/// A point of a surface.
#[derive(Debug, Clone, Copy)]
pub struct SurfacePoint {
    /// In the scene, mm.
    pub position: DVec3,
    /// Geometric unit normal; for a ribbon on its upper side.
    pub normal: DVec3,
    /// Shading frame: y along the barbule, barb or fibre, z the shading normal.
    pub frame: Frame,
    /// Ribbon: arc length from its base in mm, and −1 … 1 across. Curve: 0 … 1 along, and the ray's signed distance
    /// from the axis over the radius. Mesh: its texture coordinates.
    pub uv: [f64; 2],
    /// Index into the scene's surfaces.
    pub surface: u32,
    /// Index of the primitive in the hierarchy.
    pub primitive: u32,
    /// Identity of the object: one barbule, one barb.
    pub object: u64,
    /// Identity from which a material draws its instance: one cell of a barbule.
    pub instance: u64,
    /// Along the ray, mm.
    pub distance: f64,
    /// Radius of the ray's footprint here, mm.
    pub footprint: f64,
}

impl Default for SurfacePoint {
    fn default() -> Self {
        Self {
            position: DVec3::ZERO,
            normal: DVec3::Z,
            frame: Frame { x: DVec3::X, y: DVec3::Y, z: DVec3::Z },
            uv: [0.0; 2],
            surface: 0,
            primitive: 0,
            object: 0,
            instance: 0,
            distance: 0.0,
            footprint: 0.0,
        }
    }
}
