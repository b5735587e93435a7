//! GGX microfacets: normals, masking, and sampling of those that are seen.

use std::f64::consts::PI;

use glam::DVec3;

use crate::math::elementary::sin_cos_turns;

/// Roughness of a boundary: GGX α towards both axes of its frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacetRoughness {
    /// Along the frame's y, the long axis of what was hit.
    pub along: f64,
    /// Across it.
    pub across: f64,
}

impl FacetRoughness {
    /// The same in all directions.
    #[must_use]
    pub fn even(alpha: f64) -> Self {
        Self { along: alpha, across: alpha }
    }

    /// Whether both are 0.02 … 1, as rough boundaries take them.
    pub(super) fn is_allowed(self) -> bool {
        [self.along, self.across].iter().all(|alpha| (0.02..=1.0).contains(alpha))
    }
}

/// A GGX surface of two roughnesses, along x and y of its frame (Trowbridge & Reitz 1975; Walter et al. 2007), with Smith's
/// masking.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ggx {
    alpha: [f64; 2],
    /// Of both.
    inverse: [f64; 2],
    /// 1/(π α_x α_y).
    scale: f64,
}

impl Ggx {
    /// Roughness over 0.
    pub(super) fn new(roughness: FacetRoughness) -> Self {
        let alpha = [roughness.across, roughness.along];
        Self { alpha, inverse: alpha.map(|a| 1.0 / a), scale: 1.0 / (PI * alpha[0] * alpha[1]) }
    }

    /// Along x and y.
    pub(super) fn alpha(&self) -> [f64; 2] {
        self.alpha
    }

    /// Density of normals, per sr of the projected surface.
    #[inline(always)]
    pub(super) fn distribution(&self, h: DVec3) -> f64 {
        let (x, y) = (h.x * self.inverse[0], h.y * self.inverse[1]);
        let t = x * x + y * y + h.z * h.z;
        self.scale / (t * t)
    }

    /// Smith's Λ: what a direction's neighbours hide of the surface, over what they leave.
    #[inline(always)]
    pub(super) fn lambda(&self, w: DVec3) -> f64 {
        let (x, y) = (w.x * self.alpha[0], w.y * self.alpha[1]);
        0.5 * ((1.0 + (x * x + y * y) / (w.z * w.z).max(1e-30)).sqrt() - 1.0)
    }

    /// A normal that `w` sees, with its visible density (Dupuy & Benyoub 2023: spherical caps).
    #[inline(always)]
    pub(super) fn visible_normal(&self, w: DVec3, u: f64, v: f64) -> DVec3 {
        let stretched = DVec3::new(w.x * self.alpha[0], w.y * self.alpha[1], w.z).normalize();
        let z = (1.0 - v) * (1.0 + stretched.z) - stretched.z;
        let sine = (1.0 - z * z).clamp(0.0, 1.0).sqrt();
        let [sin_azimuth, cos_azimuth] = sin_cos_turns(u);
        let h = DVec3::new(sine * cos_azimuth, sine * sin_azimuth, z) + stretched;
        DVec3::new(h.x * self.alpha[0], h.y * self.alpha[1], h.z).normalize()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// ∫ D cosθ = 1, and the normals that a direction sees cover its own cosine (Heitz 2014, eqs. 10 and 22), by the
    /// midpoint rule over the hemisphere.
    #[test]
    fn normals_cover_the_surface_and_what_is_seen_of_it() {
        let ggx = Ggx::new(FacetRoughness { across: 0.3, along: 0.1 });
        let w = DVec3::new(0.5, -0.6, 0.4).normalize();
        let (mut whole, mut seen) = (0.0, 0.0);
        let side = 2000;
        for i in 0..side {
            // Even in the square of the polar angle's tangent over (1 + tangent): resolves the peak.
            let t = (f64::from(i) + 0.5) / f64::from(side);
            let theta = t * t * PI / 2.0;
            let width = t * PI / f64::from(side);
            for j in 0..400 {
                let azimuth = TAU * (f64::from(j) + 0.5) / 400.0;
                let (sin, cos) = theta.sin_cos();
                let h = DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos);
                let area = sin * width * TAU / 400.0 * ggx.distribution(h);
                whole += area * cos;
                seen += area * w.dot(h).max(0.0);
            }
        }
        assert!((whole - 1.0).abs() < 1e-4, "{whole}");
        assert!((seen / (1.0 + ggx.lambda(w)) / w.z - 1.0).abs() < 1e-4, "{seen}");
    }
}
