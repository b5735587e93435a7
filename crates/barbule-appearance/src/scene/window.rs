//! Windows: meshes that show finer shapes, far too many to stand there one by one.

use super::Object;
use crate::bsdf::Pattern;

/// What a mesh shows where it is met, and goes on showing to light that is scattered there until it leaves.
///
/// Any place of the mesh shows any place of the flat layer, so a pixel that holds many sees their mean.
#[derive(Debug, Clone)]
pub struct Window {
    /// The layer.
    pub layer: Layer,
    /// What stands there instead where a pattern has no pigment: at texture coordinates of the place of a barb's base and the place
    /// on the barb, mm.
    pub pale: Option<(Pattern, Layer)>,
}

/// Shapes about the plane z = 0, as high and deep as they are; of a mesh x, y and z are its frame's.
#[derive(Debug, Clone)]
pub struct Layer {
    /// The shapes.
    pub objects: Vec<Object>,
    /// The part of the plane that is shown: lowest and highest x, mm.
    pub across_mm: [f64; 2],
    /// Lowest and highest y, mm.
    pub along_mm: [f64; 2],
}
