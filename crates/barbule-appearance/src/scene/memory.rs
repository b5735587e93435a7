//! What shapes take in memory while the hierarchy over them is built, bytes at most: what was read, its copy in the scene, the hierarchy, and
//! what that is built of.

/// Of a segment that may be entered in pieces, as slanting ones are; of one that is entered whole.
pub(in crate::scene) const IN_PIECES: f64 = 520.0;
const WHOLE: f64 = 330.0;

/// More primitives than this are entered whole, to save memory.
pub(crate) const MOST_IN_PIECES: usize = 2_000_000;

/// Of a place of a shape.
pub(in crate::scene) const PER_PLACE: f64 = 560.0;

/// What rami become.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rami {
    /// Tubes of triangles.
    Meshes,
    /// Round fibres.
    Fibres,
}

/// Of a segment among so many primitives.
pub(in crate::scene) fn per_segment(primitives: f64) -> f64 {
    if primitives > MOST_IN_PIECES as f64 { WHOLE } else { IN_PIECES }
}
