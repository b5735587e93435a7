//! Light's ways through a fibre's section: where each one leaves and what it keeps.
//!
//! The section is the plane across the fibre, in which directions are azimuths. A ray that meets a smooth fibre at an
//! inclination θ to that plane moves in it as in a plane problem with the index η' = √(η² − sin²θ)/cosθ (Marschner et
//! al. 2003, appendix B), and leaves at the inclination −θ whatever happened inside.

use std::f64::consts::{PI, TAU};

use fearless_simd::{Simd, f64x8, prelude::*};

use super::spread::wrap;
use crate::fresnel::fresnel;
use crate::math::elementary::{asin, asin_each, exp_each};
use crate::spectrum::dense::WAVES;

/// Ways that are followed one by one: R (reflected), TT (through), TRT (reflected once inside).
pub(super) const FOLLOWED: usize = 3;
/// With what is reflected inside more than once.
pub(super) const WAYS: usize = FOLLOWED + 1;

/// Where a ray meets a round section and how it goes on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Round {
    /// Azimuths at which the followed ways leave, from that of the viewer, −π … π.
    pub(super) azimuths: [f64; FOLLOWED],
    /// Fresnel reflectance at the surface, the same from inside.
    fresnel: f64,
    /// Length of a chord inside in radii.
    chord: f64,
}

impl Round {
    /// - `offset`: signed distance of the ray from the axis over the radius, −1 … 1; positive where the point met lies at
    ///   a positive azimuth from the viewer's
    /// - `sin`, `cos`: of the viewer's inclination
    /// - `index`: refractive index, over 1
    #[inline(always)]
    pub(super) fn new(offset: f64, [sin, cos]: [f64; 2], index: f64) -> Self {
        let cos_outside = (1.0 - offset * offset).max(0.0).sqrt();
        let sin_inside = offset * cos / (index * index - sin * sin).sqrt();
        let cos_inside = (1.0 - sin_inside * sin_inside).max(0.0).sqrt();
        let sin_along = sin / index;
        let cos_along = (1.0 - sin_along * sin_along).max(0.0).sqrt();
        // γ of the point met, and the turn of the point with each chord.
        let outside = asin(offset);
        let turn = PI - 2.0 * asin(sin_inside);
        let reflected = 2.0 * outside;
        Self {
            azimuths: [wrap(reflected), wrap(reflected + turn), wrap(wrap(reflected + turn) + turn)],
            fresnel: fresnel(cos * cos_outside, index),
            chord: 2.0 * cos_inside / cos_along,
        }
    }

    /// Shares of the power on each way at each wavelength, what is reflected inside more than once together last:
    /// `[way][wavelength]`.
    ///
    /// `depths`: absorption over one radius; the section is the same at all wavelengths.
    #[inline(always)]
    pub(super) fn attenuations<S: Simd>(&self, simd: S, depths: &[f64; WAVES]) -> [f64x8<S>; WAYS] {
        let all = |v: f64| f64x8::splat(simd, v);
        attenuations(simd, all(self.fresnel), all(self.chord), depths)
    }

    /// As [`Round::attenuations`] at one wavelength, the plain form.
    #[cfg(test)]
    pub(super) fn attenuations_at(&self, depth: f64) -> [f64; WAYS] {
        let kept = libm::exp(-depth * self.chord);
        let f = self.fresnel;
        let through = (1.0 - f) * (1.0 - f) * kept;
        let again = f * kept;
        let rest = through * again * again / (1.0 - again).max(f64::MIN_POSITIVE);
        [f, through, through * again, rest]
    }
}

/// Of each Fresnel reflectance and chord, `[way][wavelength]`.
#[inline(always)]
fn attenuations<S: Simd>(simd: S, f: f64x8<S>, chord: f64x8<S>, depths: &[f64; WAVES]) -> [f64x8<S>; WAYS] {
    let one = f64x8::splat(simd, 1.0);
    let kept = exp_each(simd, -f64x8::from_slice(simd, depths) * chord);
    let through = (one - f) * (one - f) * kept;
    let again = f * kept;
    let through_again = through * again;
    // At f = 1 nothing enters.
    let rest = through_again * again / (one - again).max(f64x8::splat(simd, f64::MIN_POSITIVE));
    [f, through, through_again, rest]
}

/// [`Round`] of a dispersive fibre, which each wavelength sees differently.
pub(super) struct Rounds<S: Simd> {
    /// Azimuths at which the followed ways leave, `[way][wavelength]`.
    pub(super) azimuths: [f64x8<S>; FOLLOWED],
    fresnel: f64x8<S>,
    chord: f64x8<S>,
}

impl<S: Simd> Rounds<S> {
    /// As [`Round::new`], with the index at each wavelength.
    #[inline(always)]
    pub(super) fn new(simd: S, offset: f64, [sin, cos]: [f64; 2], index: &[f64; WAVES]) -> Self {
        let all = |v: f64| f64x8::splat(simd, v);
        let (one, zero, two) = (all(1.0), all(0.0), all(2.0));
        let index = f64x8::from_slice(simd, index);
        let cos_outside = (1.0 - offset * offset).max(0.0).sqrt();
        let sin_inside = all(offset * cos) / (index * index - all(sin * sin)).sqrt();
        let cos_inside = (one - sin_inside * sin_inside).max(zero).sqrt();
        let sin_along = all(sin) / index;
        let cos_along = (one - sin_along * sin_along).max(zero).sqrt();
        let reflected = 2.0 * asin(offset);
        let turn = all(PI) - two * asin_each(simd, sin_inside);
        let once = wrap_each(simd, all(reflected) + turn);
        Self {
            azimuths: [all(wrap(reflected)), once, wrap_each(simd, once + turn)],
            fresnel: fresnel_each(simd, all(cos * cos_outside), index),
            chord: two * cos_inside / cos_along,
        }
    }

    /// As [`Round::attenuations`].
    #[inline(always)]
    pub(super) fn attenuations(&self, simd: S, depths: &[f64; WAVES]) -> [f64x8<S>; WAYS] {
        attenuations(simd, self.fresnel, self.chord, depths)
    }
}

/// [`fresnel`] at each index.
#[inline(always)]
pub(super) fn fresnel_each<S: Simd>(simd: S, cosine: f64x8<S>, index: f64x8<S>) -> f64x8<S> {
    let all = |v: f64| f64x8::splat(simd, v);
    let (one, zero) = (all(1.0), all(0.0));
    let c = cosine.max(zero).min(one);
    let t = (one - (one - c * c) / (index * index)).max(zero).sqrt();
    let s = (c - index * t) / (c + index * t);
    let p = (index * c - t) / (index * c + t);
    all(0.5) * (s * s + p * p)
}

/// Angles between −2π and 2π, turned to −π … π.
#[inline(always)]
pub(super) fn wrap_each<S: Simd>(simd: S, angle: f64x8<S>) -> f64x8<S> {
    let all = |v: f64| f64x8::splat(simd, v);
    let angle = angle.simd_gt(all(PI)).select(angle - all(TAU), angle);
    angle.simd_lt(all(-PI)).select(angle + all(TAU), angle)
}

#[cfg(test)]
pub(super) mod tests {
    use glam::DVec3;

    use super::*;
    use crate::math::rng::Stream;
    use crate::math::simd::{dispatch_large, level};

    /// Snell's law for vectors: `d` goes on, `n` points back; the ratio is that of the indices. Also the Fresnel
    /// reflectance by its amplitudes.
    pub(in super::super) fn refract(d: DVec3, n: DVec3, from: f64, to: f64) -> (Option<DVec3>, f64) {
        let cosine = -d.dot(n);
        let tangential = (d + n * cosine) * (from / to);
        let square = 1.0 - tangential.length_squared();
        if square < 0.0 {
            return (None, 1.0);
        }
        let inner = square.sqrt();
        let s = (from * cosine - to * inner) / (from * cosine + to * inner);
        let p = (to * cosine - from * inner) / (to * cosine + from * inner);
        (Some(tangential - n * inner), 0.5 * (s * s + p * p))
    }

    #[test]
    fn fresnel_of_each_has_the_bits_of_one() {
        let mut stream = Stream::new(23, &[]);
        for _ in 0..2000 {
            let (mut cosine, mut index) = ([0.0; WAVES], [0.0; WAVES]);
            cosine.fill_with(|| stream.uniform(1e-6, 1.1));
            index.fill_with(|| stream.uniform(0.4, 2.5));
            let found = dispatch_large!(level(), simd => {
                fresnel_each(simd, f64x8::from_slice(simd, &cosine), f64x8::from_slice(simd, &index)).to_array()
            });
            let expected: [f64; WAVES] = std::array::from_fn(|k| fresnel(cosine[k], index[k]));
            assert_eq!(found, expected, "{cosine:?} {index:?}");
        }
    }

    /// Follows a ray through a cylinder of radius 1 about y, surface by surface, in space: directions and powers of the
    /// ways R, TT, TRT.
    fn traced(toward_viewer: DVec3, point: DVec3, index: f64, depth: f64) -> [(DVec3, f64); FOLLOWED] {
        let across = |v: DVec3| DVec3::new(v.x, 0.0, v.z);
        let d = -toward_viewer;
        let (inside, reflectance) = refract(d, point, 1.0, index);
        let mut out = [(d - point * (2.0 * d.dot(point)), reflectance); FOLLOWED];
        let mut inside = inside.unwrap();
        let (mut at, mut power) = (point, 1.0 - reflectance);
        for way in &mut out[1..] {
            let flat = across(inside);
            let length = -2.0 * across(at).dot(flat) / flat.length_squared();
            at += inside * length;
            power *= (-depth * length).exp();
            let outward = across(at).normalize();
            let (leaving, reflectance) = refract(inside, -outward, index, 1.0);
            *way = (leaving.unwrap(), power * (1.0 - reflectance));
            power *= reflectance;
            inside -= outward * (2.0 * inside.dot(outward));
        }
        out
    }

    /// A way through the section against the ray followed in space by Snell's and Fresnel's laws and the length of its
    /// path alone. Rounding; near grazing the inner reflectance loses digits.
    #[test]
    fn ways_are_those_of_a_ray_that_is_traced_in_space() {
        let mut stream = Stream::new(21, &[]);
        for _ in 0..2000 {
            let (offset, index) = (stream.uniform(-0.999, 0.999), stream.uniform(1.2, 2.0));
            let (sin, cos) = stream.uniform(-1.4, 1.4).sin_cos();
            let depth = stream.uniform(0.0, 2.0);
            // The viewer's azimuth is 0, counted from x to z; the point's is asin of the offset.
            let viewer = DVec3::new(cos, sin, 0.0);
            let point = DVec3::new((1.0 - offset * offset).sqrt(), 0.0, offset);
            let section = Round::new(offset, [sin, cos], index);
            let powers = section.attenuations_at(depth);
            for (way, (direction, power)) in traced(viewer, point, index, depth).into_iter().enumerate() {
                let azimuth = direction.z.atan2(direction.x);
                assert!(wrap(section.azimuths[way] - azimuth).abs() < 1e-9, "way {way}, h {offset}");
                assert!((direction.y + sin).abs() < 1e-12);
                assert!((powers[way] - power).abs() < 1e-9, "way {way}, h {offset}: {} {power}", powers[way]);
            }
        }
    }

    /// Light straight through a plane problem: Snell's deviation 2(γ − γ_t), here with numbers by hand: sin 30° over 1.5.
    #[test]
    fn light_through_the_fibre_deviates_by_snells_law() {
        let section = Round::new(0.5, [0.0, 1.0], 1.5);
        let expected = PI - 2.0 * ((1.0_f64 / 3.0).asin() - 30_f64.to_radians());
        assert!(wrap(section.azimuths[1] - expected).abs() < 1e-12);
        assert!((section.azimuths[0] - 60_f64.to_radians()).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_lost_without_absorption() {
        for offset in [-1.0, -0.9, 0.0, 0.3, 0.999_999, 1.0] {
            for inclination in [0.0, 0.8, -1.5, PI / 2.0] {
                let (sin, cos) = f64::sin_cos(inclination);
                let sum: f64 =
                    Round::new(offset, [sin, cos.max(0.0)], 1.55).attenuations_at(0.0).iter().sum();
                assert!((sum - 1.0).abs() < 1e-12, "{offset} {inclination}: {sum}");
            }
        }
    }
}
