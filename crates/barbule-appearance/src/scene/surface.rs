//! What surfaces are made of.

use std::sync::Arc;

use super::keratin::{Keratin, Reflectance};
use crate::brdf::FeatherBrdf;

/// The material of a surface.
#[derive(Debug, Clone)]
pub enum Surface {
    /// Perfectly diffuse, the same on both sides.
    Lambertian(Reflectance),
    /// Pigmented keratin, the same on both sides: shafts, rami.
    Keratin(Keratin),
    /// A barbule's plate.
    Barbule(Barbule),
}

/// A barbule: its own BRDF above, dark keratin below. What neither reflects is absorbed by the melanin inside.
#[derive(Debug, Clone)]
pub struct Barbule {
    /// Of the upper side.
    pub brdf: Arc<FeatherBrdf>,
    /// Whether every cell is a draw of its own (its glints), or all show the smooth mean.
    pub instances: bool,
    /// Of the underside.
    pub under: Keratin,
    /// Share of light that passes unchanged, 0 … 1.
    pub passes: f64,
}

impl Surface {
    /// Share of light that passes the surface unchanged, 0 … 1.
    #[must_use]
    pub fn passes(&self) -> f64 {
        match self {
            Self::Barbule(barbule) => barbule.passes,
            Self::Lambertian(_) | Self::Keratin(_) => 0.0,
        }
    }
}
