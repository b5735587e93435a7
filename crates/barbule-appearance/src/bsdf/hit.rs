//! What a surface sees of the place that a ray hit.

use glam::DVec3;

use super::frame::Frame;

/// Length over width of a barbule that is one cell.
const LONG_CELL: f64 = 10.0;

/// Texture coordinates whose directions are as near to each other as this, squared, give no frame.
const LEAST_ANGLE: f64 = 1e-12;

/// A point of a surface where a ray met it.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    /// In the scene, mm.
    pub position: DVec3,
    /// Geometric unit normal; for a ribbon on its upper side.
    pub normal: DVec3,
    /// Unit normal of the feather's vane: for curves that of their nodes, where they have one; else the shading normal.
    pub vane_normal: DVec3,
    /// Shading frame: y along the barbule, barb or fibre, z the shading normal.
    pub frame: Frame,
    /// Ribbon: arc length from its base in mm, and −1 … 1 across. Curve: 0 … 1 along, and the ray's signed distance
    /// from the axis over the radius. Mesh: its texture coordinates.
    pub uv: [f64; 2],
    /// How fast these texture coordinates grow along the surface, 1/mm; zero where they are not a mesh's.
    pub uv_gradients: [DVec3; 2],
    /// Where on a ribbon it is.
    pub ribbon: OnRibbon,
    /// Index of the object.
    pub object: u32,
    /// Index of the primitive in the hierarchy.
    pub primitive: u32,
    /// Identity of the shape: one barbule, one barb.
    pub id: u64,
    /// Identity from which a material draws its instance: one cell of a barbule.
    pub instance: u64,
    /// Along the ray, mm.
    pub distance: f64,
    /// Radius of the ray's footprint here, mm; of a shadow ray where it began.
    pub footprint: f64,
}

/// Where on a ribbon a hit is, in the ribbon's own lengths: those of an instance are not scaled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnRibbon {
    /// Half the width here, mm.
    pub half_width: f64,
    /// Number of the cell.
    pub cell: u64,
    /// Where in the cell, 0 … 1 towards the ribbon's end.
    pub place: f64,
    /// Length of a cell, mm; 0 where the whole ribbon is one.
    pub cell_length: f64,
    /// Of a barb: arc length of its base on the shaft, mm.
    pub station: f64,
    /// Share of its instance's contrast that is seen: less than 1 where the footprint holds several.
    pub contrast: f64,
}

impl Default for OnRibbon {
    fn default() -> Self {
        Self { half_width: 0.0, cell: 0, place: 0.5, cell_length: 0.0, station: 0.0, contrast: 1.0 }
    }
}

/// The side of a surface that is seen from a direction.
#[derive(Debug, Clone, Copy)]
pub struct Side {
    /// Whether it is the one that the normal points out of.
    pub is_upper: bool,
    /// Geometric unit normal on this side.
    pub normal: DVec3,
    /// Shading frame; z on this side.
    pub frame: Frame,
    /// Towards the viewer, in the frame.
    pub wo: DVec3,
}

impl Hit {
    /// Sets the radius of the ray's footprint, mm. On a barbule that is one of many within it, what is seen of its instance's contrast is
    /// that of their mean: 1/√n of n cells.
    #[inline]
    pub fn set_footprint(&mut self, radius_mm: f64) {
        self.footprint = radius_mm;
        let on = &mut self.ribbon;
        let width = 2.0 * on.half_width;
        if width > 0.0 {
            let length = if on.cell_length > 0.0 { on.cell_length } else { LONG_CELL * width };
            let cells = (2.0 * radius_mm / width).max(1.0) * (2.0 * radius_mm / length).max(1.0);
            on.contrast = 1.0 / cells.sqrt();
        }
    }

    /// The frame of texture coordinates, and which way across it v grows: 1 to +x, −1 to −x.
    #[inline]
    pub(super) fn texture_frame(&self) -> (Frame, f64) {
        let [to_u, to_v] = self.uv_gradients;
        let along = to_u - to_v * (to_u.dot(to_v) / to_v.length_squared().max(f64::MIN_POSITIVE));
        if along.length_squared() <= LEAST_ANGLE * to_u.length_squared() {
            // Where a fibre is seen, its v grows to −x of a ribbon that faces the viewer.
            return (self.frame, -1.0);
        }
        let frame = Frame::new(self.frame.z, along.normalize());
        (frame, if to_v.dot(frame.x) < 0.0 { -1.0 } else { 1.0 })
    }

    /// The side seen from `wo`, a unit vector towards the viewer.
    #[inline(always)]
    #[must_use]
    pub fn side(&self, wo: DVec3) -> Side {
        let is_upper = wo.dot(self.normal) >= 0.0;
        let (normal, mut frame) =
            if is_upper { (self.normal, self.frame) } else { (-self.normal, self.frame.flipped()) };
        if wo.dot(frame.z) <= 0.0 {
            // The interpolated normal looks away although the face does not: shade the face itself.
            frame = Frame::new(normal, frame.y);
        }
        Side { is_upper, normal, frame, wo: frame.to_local(wo) }
    }
}

impl Default for Hit {
    fn default() -> Self {
        Self {
            position: DVec3::ZERO,
            normal: DVec3::Z,
            vane_normal: DVec3::Z,
            frame: Frame { x: DVec3::X, y: DVec3::Y, z: DVec3::Z },
            uv: [0.0; 2],
            uv_gradients: [DVec3::ZERO; 2],
            ribbon: OnRibbon::default(),
            object: 0,
            primitive: 0,
            id: 0,
            instance: 0,
            distance: 0.0,
            footprint: 0.0,
        }
    }
}
