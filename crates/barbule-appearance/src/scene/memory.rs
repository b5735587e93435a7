//! What shapes take in memory while the hierarchy over them is built, bytes at most: what was read, its copy in the scene, the hierarchy, and
//! what that is built of.

/// Of a segment that may be entered in pieces, as slanting ones are; of a long one of down, which is so in most; of one that is entered
/// whole; of one of a shape that repeats, whose hierarchy is small beside the others.
pub(in crate::scene) const IN_PIECES: f64 = 520.0;
const OF_DOWN: f64 = 1250.0;
const WHOLE: f64 = 330.0;
pub(in crate::scene) const REPEATED: f64 = 230.0;

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

/// Of a segment of the closed vane and of one of down among so many primitives.
pub(in crate::scene) fn per_segment(primitives: f64) -> [f64; 2] {
    if primitives > MOST_IN_PIECES as f64 { [WHOLE; 2] } else { [IN_PIECES, OF_DOWN] }
}
