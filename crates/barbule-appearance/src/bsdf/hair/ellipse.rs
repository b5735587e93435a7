//! Light's ways through an elliptical section, by following the ray.
//!
//! In the plane across the fibre a ray moves as in a plane problem with the index η' (see [`section`](super::section)).
//! Inside an ellipse, unlike a circle, every chord meets the wall at another angle, also beyond the critical one: what is
//! reflected totally loses nothing and goes on. So TT is the light that leaves the first time it can, and TRT what leaves
//! the second time.

use fearless_simd::{Simd, f64x8, prelude::*};
use glam::DVec2;

use super::section::{FOLLOWED, WAYS};
use crate::bsdf::fresnel::fresnel;
use crate::math::elementary::{atan2, exp_each};
use crate::spectrum::dense::WAVES;

/// Chords that are followed. Light that blades guide by total reflection over more of them leaves anywhere, with what is
/// reflected inside more than twice; `docs/theory/hair.md` says how little that is.
const MOST_CHORDS: usize = 12;

/// Square of the cosine under which a ray that leaves only grazes the wall: its Fresnel reflectance is 1 within 1e-9.
const GRAZING: f64 = 1e-20;

/// Where a ray meets an elliptical section and how it goes on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ellipse {
    /// Azimuths at which the followed ways leave, from that of the viewer, −π … π.
    pub(super) azimuths: [f64; FOLLOWED],
    /// Fresnel reflectances where the ray enters and where it may leave for the first and the second time; 1 where there
    /// is no such place.
    reflectances: [f64; FOLLOWED],
    /// Of the last of these places.
    last: f64,
    /// Lengths inside up to the first of the places where it may leave, and on to the second, in half widths.
    lengths: [f64; 2],
}

impl Ellipse {
    /// - `height`: half height over half width
    /// - `toward`: unit vector towards the viewer in the section: across, up
    /// - `offset`: signed distance of the ray from the axis over half the width that is seen, −1 … 1; positive where the
    ///   point met lies at a positive azimuth (from across to up) from the viewer's
    /// - `sin`, `cos`: of the viewer's inclination
    /// - `index`: refractive index, over 1
    pub(super) fn new(height: f64, toward: DVec2, offset: f64, [sin, cos]: [f64; 2], index: f64) -> Self {
        // Stretched to a circle of radius 1, a section keeps the ratios of distances from the axis: so the offset too.
        let stretch = DVec2::new(1.0, 1.0 / height);
        let at = (toward * stretch).normalize();
        let mut met = at * (1.0 - offset * offset).max(0.0).sqrt() + at.perp() * offset;
        let normal = (met * stretch).normalize();
        let cos_outside = normal.dot(toward).clamp(0.0, 1.0);
        // 1/η'. Refraction scales what of a direction lies along the wall.
        let ratio = cos / (index * index - sin * sin).sqrt();
        let tangential = (normal * cos_outside - toward) * ratio;
        let mut inside = tangential - normal * (1.0 - tangential.length_squared()).max(0.0).sqrt();
        let sin_along = sin / index;
        let cos_along = (1.0 - sin_along * sin_along).max(0.0).sqrt();

        let azimuth = |to: DVec2| atan2(toward.perp_dot(to), toward.dot(to));
        let entry = fresnel(cos * cos_outside, index);
        let mut ways = Self {
            azimuths: [azimuth(normal * (2.0 * cos_outside) - toward), 0.0, 0.0],
            reflectances: [entry, 1.0, 1.0],
            last: entry,
            lengths: [0.0; 2],
        };
        let mut way = 1;
        for _ in 0..MOST_CHORDS {
            let direction = inside * stretch;
            let chord = -2.0 * met.dot(direction) / direction.length_squared();
            met += direction * chord;
            ways.lengths[way - 1] += chord / cos_along;
            let normal = (met * stretch).normalize();
            let cos_inside = inside.dot(normal).clamp(0.0, 1.0);
            let tangential = inside - normal * cos_inside;
            let square = ratio * ratio - tangential.length_squared();
            if square > GRAZING * ratio * ratio {
                let cos_outside = square.sqrt() / ratio;
                ways.azimuths[way] = azimuth(tangential / ratio + normal * cos_outside);
                ways.reflectances[way] = fresnel(cos * cos_outside, index);
                ways.last = ways.reflectances[way];
                way += 1;
                if way == FOLLOWED {
                    break;
                }
            }
            inside = tangential - normal * cos_inside;
        }
        ways
    }

    /// Shares of the power on each way for an absorption of this depth over one half width, what leaves later together
    /// last: the plain form.
    #[cfg(test)]
    pub(super) fn attenuations_at(&self, depth: f64) -> [f64; WAYS] {
        let [r, first, second] = self.reflectances;
        let [kept, kept_again] = self.lengths.map(|length| libm::exp(-depth * length));
        let inside = (1.0 - r) * kept;
        let again = inside * first * kept_again;
        let later = kept_again * (1.0 - self.last) / (1.0 - self.last * kept_again).max(f64::MIN_POSITIVE);
        [r, inside * (1.0 - first), again * (1.0 - second), again * second * later]
    }
}

/// [`Ellipse`] of each wavelength, which a dispersive fibre shows another way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ellipses {
    /// `[way][wavelength]`.
    pub(super) azimuths: [[f64; WAVES]; FOLLOWED],
    reflectances: [[f64; WAVES]; FOLLOWED],
    last: [f64; WAVES],
    lengths: [[f64; WAVES]; 2],
}

impl Ellipses {
    /// One for all wavelengths.
    pub(super) fn same(ellipse: &Ellipse) -> Self {
        Self {
            azimuths: ellipse.azimuths.map(|azimuth| [azimuth; WAVES]),
            reflectances: ellipse.reflectances.map(|reflectance| [reflectance; WAVES]),
            last: [ellipse.last; WAVES],
            lengths: ellipse.lengths.map(|length| [length; WAVES]),
        }
    }

    /// As [`Ellipse::new`], with the index at each wavelength.
    pub(super) fn new(
        height: f64,
        toward: DVec2,
        offset: f64,
        inclination: [f64; 2],
        index: &[f64; WAVES],
    ) -> Self {
        let mut ellipses = Self {
            azimuths: [[0.0; WAVES]; FOLLOWED],
            reflectances: [[0.0; WAVES]; FOLLOWED],
            last: [0.0; WAVES],
            lengths: [[0.0; WAVES]; 2],
        };
        for (k, &index) in index.iter().enumerate() {
            let one = Ellipse::new(height, toward, offset, inclination, index);
            for way in 0..FOLLOWED {
                ellipses.azimuths[way][k] = one.azimuths[way];
                ellipses.reflectances[way][k] = one.reflectances[way];
            }
            ellipses.last[k] = one.last;
            ellipses.lengths[0][k] = one.lengths[0];
            ellipses.lengths[1][k] = one.lengths[1];
        }
        ellipses
    }

    /// Shares of the power on each way at each wavelength, `[way][wavelength]`; `depths`: absorption over one half width.
    #[inline(always)]
    pub(super) fn attenuations<S: Simd>(&self, simd: S, depths: &[f64; WAVES]) -> [f64x8<S>; WAYS] {
        let [r, first, second] = &self.reflectances;
        let one = f64x8::splat(simd, 1.0);
        let (r, first) = (f64x8::from_slice(simd, r), f64x8::from_slice(simd, first));
        let (second, last) = (f64x8::from_slice(simd, second), f64x8::from_slice(simd, &self.last));
        let depths = f64x8::from_slice(simd, depths);
        let kept = exp_each(simd, -depths * f64x8::from_slice(simd, &self.lengths[0]));
        let kept_again = exp_each(simd, -depths * f64x8::from_slice(simd, &self.lengths[1]));
        let inside = (one - r) * kept;
        let again = inside * first * kept_again;
        let least = f64x8::splat(simd, f64::MIN_POSITIVE);
        let later = kept_again * (one - last) / (one - last * kept_again).max(least);
        [r, inside * (one - first), again * (one - second), again * second * later]
    }
}

#[cfg(test)]
mod tests;
