//! What sampling a light gives.

use glam::DVec3;

use crate::spectrum::dense::WAVES;

/// A direction towards a light.
#[derive(Debug, Clone, Copy)]
pub struct LightSample {
    /// Unit vector from the point towards the light.
    pub direction: DVec3,
    /// How far the light is, mm; infinite for skies and suns.
    pub distance: f64,
    /// Density of the direction, 1/sr.
    pub pdf: f64,
    /// Radiance that arrives if nothing stands between.
    pub radiance: [f64; WAVES],
}
