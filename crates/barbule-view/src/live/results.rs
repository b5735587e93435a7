//! What has been computed of what is open and of what is pinned, as far as it is there.

use std::sync::Arc;

use barbule::brdf::FeatherBrdf;

use super::{Curves, Hemisphere, Individual, MaterialFound};

/// Of what is open, and of what is pinned beside it.
#[derive(Debug, Clone, Default)]
pub struct Results {
    /// Of what is open.
    pub own: Known,
    /// Of what is pinned.
    pub pinned: Known,
}

/// What has been computed of one of them. What is not there yet, or cannot be, is none; what was there before a change stays until the
/// new is there, so that nothing flickers.
#[derive(Debug, Clone, Default)]
pub struct Known {
    /// Reflectance against wavelength at several angles: of films exactly, of everything else the mean over individuals.
    pub curves: Option<Curves>,
    /// Over so many individuals; 1 of what has none.
    pub individuals: usize,
    /// Whether the curves are all that was asked for.
    pub is_whole: bool,
    /// The individual that is looked at.
    pub individual: Option<Individual>,
    /// The material.
    pub material: Option<MaterialFound>,
    /// The material, ready to be evaluated.
    pub brdf: Option<Arc<FeatherBrdf>>,
    /// The material's lobe over the hemisphere.
    pub hemisphere: Option<Hemisphere>,
}
