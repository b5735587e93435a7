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
    /// Density of the direction, 1/sr; of a point, whose direction is the only one, a number of samples.
    pub pdf: f64,
    /// Radiance that arrives if nothing stands between; of a point irradiance.
    pub radiance: [f64; WAVES],
    /// Whether the light is a point, which no other technique finds.
    pub is_point: bool,
}
