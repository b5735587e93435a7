//! Light's ways through an elliptical section, by following the ray.
//!
//! In the plane across the fibre a ray moves as in a plane problem with the index η' (see [`section`](super::section)).
//! Inside an ellipse, unlike a circle, every chord meets the wall at another angle, also beyond the critical one: what is
//! reflected totally loses nothing and goes on. So TT is the light that leaves the first time it can, and TRT what leaves
//! the second time.

use std::f64::consts::{FRAC_PI_2, PI};

use fearless_simd::{Simd, f64x8, prelude::*};
use glam::DVec2;

use super::section::{FOLLOWED, WAYS, fresnel_each};
use crate::fresnel::fresnel;
use crate::math::elementary::{asin_each, atan2, exp_each};
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
pub(super) struct Ellipses<S: Simd> {
    /// Azimuths at which the followed ways leave, `[way][wavelength]`.
    pub(super) azimuths: [f64x8<S>; FOLLOWED],
    reflectances: [f64x8<S>; FOLLOWED],
    last: f64x8<S>,
    lengths: [f64x8<S>; 2],
}

impl<S: Simd> Ellipses<S> {
    /// One for all wavelengths.
    #[inline(always)]
    pub(super) fn same(simd: S, one: &Ellipse) -> Self {
        let all = |v: f64| f64x8::splat(simd, v);
        let ([a, b, c], [d, e, f], [g, h]) = (one.azimuths, one.reflectances, one.lengths);
        Self {
            azimuths: [all(a), all(b), all(c)],
            reflectances: [all(d), all(e), all(f)],
            last: all(one.last),
            lengths: [all(g), all(h)],
        }
    }

    /// As [`Ellipse::new`], with the index at each wavelength: every wavelength's ray is followed until all have left twice.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        height: f64,
        toward: DVec2,
        offset: f64,
        [sin, cos]: [f64; 2],
        index: &[f64; WAVES],
    ) -> Self {
        let all = |v: f64| f64x8::splat(simd, v);
        let (one, zero) = (all(1.0), all(0.0));
        let index = f64x8::from_slice(simd, index);
        let stretch = DVec2::new(1.0, 1.0 / height);
        let at = (toward * stretch).normalize();
        let start = at * (1.0 - offset * offset).max(0.0).sqrt() + at.perp() * offset;
        let normal = (start * stretch).normalize();
        let cos_outside = normal.dot(toward).clamp(0.0, 1.0);
        let along_wall = normal * cos_outside - toward;
        let mirrored = normal * (2.0 * cos_outside) - toward;

        let ratio = all(cos) / (index * index - all(sin * sin)).sqrt();
        let sin_along = all(sin) / index;
        let inverse_cos_along = one / (one - sin_along * sin_along).max(zero).sqrt();
        let (tx, tz) = (all(along_wall.x) * ratio, all(along_wall.y) * ratio);
        let cos_inside = (one - (tx * tx + tz * tz)).max(zero).sqrt();
        let (mut dx, mut dz) = (tx - all(normal.x) * cos_inside, tz - all(normal.y) * cos_inside);
        let (mut x, mut z) = (all(start.x), all(start.y));
        let (vx, vz, rise) = (all(toward.x), all(toward.y), all(stretch.y));

        let entry = fresnel_each(simd, all(cos * cos_outside), index);
        let (mut first_azimuth, mut second_azimuth) = (zero, zero);
        let (mut first, mut second, mut last) = (one, one, entry);
        let (mut first_length, mut second_length) = (zero, zero);
        let mut has_left = zero.simd_gt(one);
        let mut has_left_again = has_left;
        for _ in 0..MOST_CHORDS {
            let up = dz * rise;
            let chord = all(-2.0) * (x * dx + z * up) / (dx * dx + up * up);
            x += dx * chord;
            z += up * chord;
            let length = chord * inverse_cos_along;
            let is_between = has_left & !has_left_again;
            first_length += has_left.select(zero, length);
            second_length += is_between.select(length, zero);
            let steep = z * rise;
            let inverse = one / (x * x + steep * steep).sqrt();
            let (nx, nz) = (x * inverse, steep * inverse);
            let cos_inside = (dx * nx + dz * nz).max(zero).min(one);
            let (tx, tz) = (dx - nx * cos_inside, dz - nz * cos_inside);
            let square = ratio * ratio - (tx * tx + tz * tz);
            let leaves = square.simd_gt(all(GRAZING) * ratio * ratio);
            let cos_outside = square.max(zero).sqrt() / ratio;
            let (ox, oz) = (tx / ratio + nx * cos_outside, tz / ratio + nz * cos_outside);
            let azimuth = angle_each(simd, vx * oz - vz * ox, vx * ox + vz * oz);
            let reflectance = fresnel_each(simd, all(cos) * cos_outside, index);
            let is_first = leaves & !has_left;
            let is_second = leaves & is_between;
            first_azimuth = is_first.select(azimuth, first_azimuth);
            first = is_first.select(reflectance, first);
            second_azimuth = is_second.select(azimuth, second_azimuth);
            second = is_second.select(reflectance, second);
            last = (is_first | is_second).select(reflectance, last);
            has_left |= is_first;
            has_left_again |= is_second;
            if has_left_again.all_true() {
                break;
            }
            dx = tx - nx * cos_inside;
            dz = tz - nz * cos_inside;
        }
        let reflected = atan2(toward.perp_dot(mirrored), toward.dot(mirrored));
        Self {
            azimuths: [all(reflected), first_azimuth, second_azimuth],
            reflectances: [entry, first, second],
            last,
            lengths: [first_length, second_length],
        }
    }

    /// Shares of the power on each way at each wavelength, `[way][wavelength]`; `depths`: absorption over one half width.
    #[inline(always)]
    pub(super) fn attenuations(&self, simd: S, depths: &[f64; WAVES]) -> [f64x8<S>; WAYS] {
        let [r, first, second] = self.reflectances;
        let one = f64x8::splat(simd, 1.0);
        let depths = f64x8::from_slice(simd, depths);
        let kept = exp_each(simd, -depths * self.lengths[0]);
        let kept_again = exp_each(simd, -depths * self.lengths[1]);
        let inside = (one - r) * kept;
        let again = inside * first * kept_again;
        let least = f64x8::splat(simd, f64::MIN_POSITIVE);
        let later = kept_again * (one - self.last) / (one - self.last * kept_again).max(least);
        [r, inside * (one - first), again * (one - second), again * second * later]
    }
}

/// Angles of unit vectors, −π … π.
#[inline(always)]
fn angle_each<S: Simd>(simd: S, sin: f64x8<S>, cos: f64x8<S>) -> f64x8<S> {
    let all = |v: f64| f64x8::splat(simd, v);
    let (s, c) = (sin.abs(), cos.abs());
    // The arc sine of the smaller loses no digits.
    let angle = asin_each(simd, s.min(c));
    let angle = s.simd_gt(c).select(all(FRAC_PI_2) - angle, angle);
    let angle = cos.simd_lt(all(0.0)).select(all(PI) - angle, angle);
    angle.copysign(sin)
}

#[cfg(test)]
mod tests;
