//! Windows: meshes that show finer shapes, far too many to stand there one by one.

use super::Object;
use crate::bsdf::{Mark, Markings};

/// What a mesh shows where it is met, and goes on showing to light that is scattered there until it leaves.
///
/// Any place of the mesh shows any place of the flat layer, so a pixel that holds many sees their mean.
#[derive(Debug, Clone)]
pub struct Window {
    /// The layers: the feather's own, those of the markings' zones, and, where these have a pattern, that without pigment.
    pub layers: Vec<Layer>,
    /// Which stands where, at texture coordinates of the place of a barb's base and the place on the barb, mm.
    pub markings: Markings,
    /// Which vane the mesh is: −1 left, 1 right of the shaft.
    pub side: f64,
}

impl Window {
    /// Index of the layer at texture coordinates, for a place of this name.
    #[inline]
    #[must_use]
    pub fn layer_at(&self, [station, arc]: [f64; 2], name: u64) -> usize {
        match self.markings.at(self.side, station, arc, name) {
            Mark::Zone(zone) => zone,
            Mark::Pale => self.layers.len() - 1,
        }
    }
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
