//! What surfaces are made of.

use super::keratin::{Keratin, Reflectance};

/// The material of a surface.
#[derive(Debug, Clone)]
pub enum Surface {
    /// Perfectly diffuse, the same on both sides.
    Lambertian(Reflectance),
    /// Pigmented keratin, the same on both sides: shafts, rami.
    Keratin(Keratin),
}
