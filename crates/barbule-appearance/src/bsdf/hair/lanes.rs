//! The kernels of a fibre: all lobes at once, then all wavelengths at once. The plain forms stand in
//! [`spread`](super::spread), for the tests.

use std::f64::consts::TAU;

use fearless_simd::{Simd, f64x8, mask64x8, prelude::*};
use glam::DVec2;

use super::ellipse::{Ellipse, Ellipses};
use super::section::{FOLLOWED, Round, Rounds, WAYS, wrap_each};
use super::spread::{Azimuthal, LARGE_I0, Longitudinal, NEGLIGIBLE, SMALL, SMALL_I0};
use crate::math::elementary::exp_each;
use crate::math::simd::{dispatch_large, level};
use crate::spectrum::dense::WAVES;

/// Lanes: of each way along the fibre, then of each followed way around it, then one that is idle.
const LANES: usize = 8;
const IOTA: [f64; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// What the lobes of a material have in common.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spread {
    /// One over the variance along, one over the scale around.
    inverse: [f64; LANES],
    /// Normalizations.
    scale: [f64; LANES],
}

/// Shares of the power on each way at each wavelength, `[way][wavelength]`, and one over their sums.
#[derive(Debug, Clone, Copy)]
pub(super) struct Powers {
    pub(super) of: [[f64; WAVES]; WAYS],
    pub(super) inverse_albedo: [f64; WAVES],
}

impl Powers {
    /// Of a section that is the same at all wavelengths; `depths`: absorption over one radius.
    #[inline(never)] // one copy for all callers, which are inlined into one function
    pub(super) fn new(section: &Round, depths: &[f64; WAVES]) -> Self {
        dispatch_large!(level(), simd => powers(simd, section, depths))
    }

    /// Of an elliptical section that is the same at all wavelengths; `depths`: absorption over one half width.
    #[inline(never)]
    pub(super) fn of_ellipse(section: &Ellipse, depths: &[f64; WAVES]) -> Self {
        dispatch_large!(level(), simd => powers_of_ellipse(simd, section, depths))
    }
}

#[inline(always)]
fn powers_of_ellipse<S: Simd>(simd: S, section: &Ellipse, depths: &[f64; WAVES]) -> Powers {
    shares(simd, Ellipses::same(simd, section).attenuations(simd, depths))
}

#[inline(always)]
fn powers<S: Simd>(simd: S, section: &Round, depths: &[f64; WAVES]) -> Powers {
    shares(simd, section.attenuations(simd, depths))
}

#[inline(always)]
fn shares<S: Simd>(simd: S, [r, tt, trt, rest]: [f64x8<S>; WAYS]) -> Powers {
    let inverse = f64x8::splat(simd, 1.0) / (((r + tt) + trt) + rest);
    Powers {
        of: [r.to_array(), tt.to_array(), trt.to_array(), rest.to_array()],
        inverse_albedo: inverse.to_array(),
    }
}

/// Middles and powers of a fibre whose index at each wavelength is another; arguments as of [`Round::new`] and
/// [`Powers::new`].
#[inline(never)]
pub(super) fn dispersed(
    offset: f64,
    inclination: [f64; 2],
    index: &[f64; WAVES],
    depths: &[f64; WAVES],
) -> (Middles, Powers) {
    dispatch_large!(level(), simd => rounds(simd, offset, inclination, index, depths))
}

#[inline(always)]
fn rounds<S: Simd>(
    simd: S,
    offset: f64,
    inclination: [f64; 2],
    index: &[f64; WAVES],
    depths: &[f64; WAVES],
) -> (Middles, Powers) {
    let rounds = Rounds::new(simd, offset, inclination, index);
    let [r, tt, trt] = rounds.azimuths;
    let middles = Middles::Each([r.to_array(), tt.to_array(), trt.to_array()]);
    (middles, shares(simd, rounds.attenuations(simd, depths)))
}

/// [`dispersed`] of an elliptical section; arguments as of [`Ellipse::new`].
#[inline(never)]
pub(super) fn dispersed_ellipse(
    height: f64,
    toward: DVec2,
    offset: f64,
    inclination: [f64; 2],
    index: &[f64; WAVES],
    depths: &[f64; WAVES],
) -> (Middles, Powers) {
    dispatch_large!(level(), simd => ellipses(simd, height, toward, offset, inclination, index, depths))
}

#[inline(always)]
fn ellipses<S: Simd>(
    simd: S,
    height: f64,
    toward: DVec2,
    offset: f64,
    inclination: [f64; 2],
    index: &[f64; WAVES],
    depths: &[f64; WAVES],
) -> (Middles, Powers) {
    let sections = Ellipses::new(simd, height, toward, offset, inclination, index);
    let [r, tt, trt] = sections.azimuths;
    let middles = Middles::Each([r.to_array(), tt.to_array(), trt.to_array()]);
    (middles, shares(simd, sections.attenuations(simd, depths)))
}

/// Where light comes from, as a fibre sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Incidence {
    /// Sine and cosine of the light's inclination.
    pub(super) sin: f64,
    pub(super) cos: f64,
    /// Its azimuth from the viewer's, −π … π.
    pub(super) azimuth: f64,
}

impl Spread {
    pub(super) fn new(along: &[Longitudinal; WAYS], around: &Azimuthal) -> Self {
        let [a, b, c, d] = along.map(|lobe| lobe.inverse());
        let e = around.inverse();
        let inverse = [a, b, c, d, e, e, e, 1.0];
        let [a, b, c, d] = along.map(|lobe| lobe.scale());
        let e = around.normalization();
        Self { inverse, scale: [a, b, c, d, e, e, e, 0.0] }
    }

    /// Σ_p M_p A_p N_p at each wavelength.
    ///
    /// - `inclinations`: sine and cosine of the viewer's, as each way sees it
    /// - `middles`: azimuths at which the followed ways leave; at each wavelength where they differ
    #[inline(never)]
    pub(super) fn scattered(
        &self,
        powers: &Powers,
        light: Incidence,
        inclinations: &[[f64; 2]; WAYS],
        middles: &Middles,
    ) -> [f64; WAVES] {
        dispatch_large!(level(), simd => scattered(simd, self, powers, light, inclinations, middles))
    }
}

/// Azimuths at which the followed ways leave, from the viewer's, −π … π.
#[derive(Debug, Clone, Copy)]
pub(super) enum Middles {
    /// The same at all wavelengths.
    Same([f64; FOLLOWED]),
    /// `[way][wavelength]`.
    Each([[f64; WAVES]; FOLLOWED]),
}

impl Middles {
    /// Those of the hero.
    #[inline(always)]
    pub(super) fn of_hero(&self) -> [f64; FOLLOWED] {
        match self {
            Self::Same(middles) => *middles,
            Self::Each([r, tt, trt]) => [r[0], tt[0], trt[0]],
        }
    }
}

#[inline(always)]
fn scattered<S: Simd>(
    simd: S,
    spread: &Spread,
    powers: &Powers,
    light: Incidence,
    inclinations: &[[f64; 2]; WAYS],
    middles: &Middles,
) -> [f64; WAVES] {
    let all = |v: f64| f64x8::splat(simd, v);
    let [r, tt, trt] = middles.of_hero();
    let from = light.azimuth;
    let turns = f64x8::from_slice(simd, &[0.0, 0.0, 0.0, 0.0, from - r, from - tt, from - trt, 0.0]);
    let values = lobes(simd, spread, light, inclinations, turns).to_array();
    let of = |way: usize| f64x8::from_slice(simd, &powers.of[way]);
    let rest = of(FOLLOWED) * all(values[FOLLOWED] * (1.0 / TAU));
    let sum = match middles {
        Middles::Same(_) => {
            rest + of(0) * all(values[0] * values[4])
                + of(1) * all(values[1] * values[5])
                + of(2) * all(values[2] * values[6])
        }
        Middles::Each([r, tt, trt]) => {
            rest + of(0) * all(values[0]) * around(simd, spread, from, r)
                + of(1) * all(values[1]) * around(simd, spread, from, tt)
                + of(2) * all(values[2]) * around(simd, spread, from, trt)
        }
    };
    sum.to_array()
}

/// Density around the fibre of a way that leaves elsewhere at each wavelength. Not a closure, which would be left outside
/// of what is compiled for the processor's instructions.
#[inline(always)]
fn around<S: Simd>(simd: S, spread: &Spread, from: f64, middles: &[f64; WAVES]) -> f64x8<S> {
    let turns = f64x8::splat(simd, from) - f64x8::from_slice(simd, middles);
    let power = -wrap_each(simd, turns).abs() * f64x8::splat(simd, spread.inverse[4]);
    logistic(simd, exp_each(simd, power), f64x8::splat(simd, spread.scale[4]))
}

/// Densities of all lobes.
#[inline(always)]
fn lobes<S: Simd>(
    simd: S,
    spread: &Spread,
    light: Incidence,
    [r, tt, trt, rest]: &[[f64; 2]; WAYS],
    turns: f64x8<S>,
) -> f64x8<S> {
    let all = |v: f64| f64x8::splat(simd, v);
    let inverse = f64x8::from_slice(simd, &spread.inverse);
    let sin_o = f64x8::from_slice(simd, &[r[0], tt[0], trt[0], rest[0], 0.0, 0.0, 0.0, 0.0]);
    let cos_o = f64x8::from_slice(simd, &[r[1], tt[1], trt[1], rest[1], 1.0, 1.0, 1.0, 1.0]);
    let a = all(light.cos) * cos_o * inverse;
    let b = -(all(light.sin) * sin_o + all(1.0)) * inverse;
    let is_small = a.simd_lt(all(SMALL));
    let along = is_small.select(b, a + b);
    let around = -wrap_each(simd, turns).abs() * inverse;
    let is_along: mask64x8<S> = f64x8::from_slice(simd, &IOTA).simd_lt(all(WAYS as f64));
    let power = is_along.select(along, around);
    let e = exp_each(simd, power);
    let m =
        is_small.select(i0_small(simd, a), i0_large(simd, a)) * e * f64x8::from_slice(simd, &spread.scale);
    let m = power.simd_lt(all(NEGLIGIBLE)).select(all(0.0), m);
    is_along.select(m, logistic(simd, e, f64x8::from_slice(simd, &spread.scale)))
}

#[inline(always)]
fn logistic<S: Simd>(simd: S, e: f64x8<S>, scale: f64x8<S>) -> f64x8<S> {
    let one_more = e + f64x8::splat(simd, 1.0);
    scale * e / (one_more * one_more)
}

#[inline(always)]
fn i0_small<S: Simd>(simd: S, x: f64x8<S>) -> f64x8<S> {
    let all = |v: f64| f64x8::splat(simd, v);
    let t = x * all(1.0 / SMALL);
    let t = t * t;
    let [a, b, c, d, e, f] = SMALL_I0;
    let sum = ((((all(f) * t + all(e)) * t + all(d)) * t + all(c)) * t + all(b)) * t + all(a);
    sum * t + all(1.0)
}

#[inline(always)]
fn i0_large<S: Simd>(simd: S, x: f64x8<S>) -> f64x8<S> {
    let all = |v: f64| f64x8::splat(simd, v);
    let x = x.max(all(SMALL));
    let t = all(SMALL) / x;
    let [a, b, c, d, e, f, g, h, i] = LARGE_I0;
    let high = ((((all(i) * t + all(h)) * t + all(g)) * t + all(f)) * t + all(e)) * t + all(d);
    let sum = ((high * t + all(c)) * t + all(b)) * t + all(a);
    sum / x.sqrt()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::math::rng::Stream;
    use crate::math::simd::Width;

    /// Each wavelength against the plain form with its index; the tolerance is rounding.
    #[test]
    fn dispersed_sections_are_those_of_each_index_at_every_width() {
        let mut stream = Stream::new(92, &[]);
        for _ in 0..300 {
            let offset = stream.uniform(-1.0, 1.0);
            let (sin, cos) = stream.uniform(-1.5, 1.5).sin_cos();
            let index: [f64; WAVES] = std::array::from_fn(|_| stream.uniform(1.2, 2.0));
            let depths = std::array::from_fn(|_| stream.uniform(0.0, 3.0));
            for Width(level) in Width::available() {
                let (middles, powers) =
                    dispatch_large!(level, simd => rounds(simd, offset, [sin, cos], &index, &depths));
                let Middles::Each(middles) = middles else { panic!("one middle for all") };
                for k in 0..WAVES {
                    let section = Round::new(offset, [sin, cos], index[k]);
                    let shares = section.attenuations_at(depths[k]);
                    for (powers, share) in powers.of.iter().zip(shares) {
                        assert!((powers[k] - share).abs() < 1e-14, "{} {share}", powers[k]);
                    }
                    for (way, azimuth) in section.azimuths.into_iter().enumerate() {
                        assert!((middles[way][k] - azimuth).abs() < 1e-13, "way {way}");
                    }
                }
            }
        }
    }

    /// The same for ellipses of all shapes, of which wavelengths leave after chords of their own number. Near the critical angle the
    /// outer cosine loses digits.
    #[test]
    fn dispersed_ellipses_are_those_of_each_index_at_every_width() {
        let mut stream = Stream::new(93, &[]);
        let mut worst = [0.0_f64; 2];
        for _ in 0..600 {
            let (height, offset) = (libm::exp(stream.uniform(-2.3, 2.3)), stream.uniform(-1.0, 1.0));
            let (z, x) = stream.uniform(-PI, PI).sin_cos();
            let toward = DVec2::new(x, z);
            let (sin, cos) = stream.uniform(-1.5, 1.5).sin_cos();
            let index: [f64; WAVES] = std::array::from_fn(|_| stream.uniform(1.2, 2.0));
            let depths = std::array::from_fn(|_| stream.uniform(0.0, 3.0));
            for Width(level) in Width::available() {
                let (middles, powers) = dispatch_large!(level, simd => ellipses(simd, height, toward, offset, [sin, cos], &index, &depths));
                let Middles::Each(middles) = middles else { panic!("one middle for all") };
                for k in 0..WAVES {
                    let section = Ellipse::new(height, toward, offset, [sin, cos], index[k]);
                    let shares = section.attenuations_at(depths[k]);
                    for (way, share) in shares.into_iter().enumerate() {
                        worst[0] = worst[0].max((powers.of[way][k] - share).abs());
                        if way < FOLLOWED && share > 0.0 {
                            let difference = (middles[way][k] - section.azimuths[way]).rem_euclid(TAU);
                            worst[1] = worst[1].max(difference.min(TAU - difference));
                        }
                    }
                }
            }
        }
        println!("worst power and azimuth: {worst:?}");
        assert!(worst[0] < 1e-12 && worst[1] < 1e-10, "{worst:?}");
    }

    /// Against the sum over ways and wavelengths one by one, at every width. The tolerance is rounding.
    #[test]
    fn kernels_are_the_plain_sum_at_every_width() {
        let mut stream = Stream::new(91, &[]);
        for _ in 0..300 {
            let along = std::array::from_fn(|_| Longitudinal::new(stream.uniform(1e-3, 2.0)));
            let around = Azimuthal::new(stream.uniform(0.02, 2.0));
            let spread = Spread::new(&along, &around);
            let depths = std::array::from_fn(|_| stream.uniform(0.0, 3.0));
            let inclinations = std::array::from_fn(|_| {
                let (sin, cos) = stream.uniform(-1.5, 1.5).sin_cos();
                [sin, cos]
            });
            let section = Round::new(stream.uniform(-1.0, 1.0), inclinations[0], 1.55);
            let (sin, cos) = stream.uniform(-1.57, 1.57).sin_cos();
            let light = Incidence { sin, cos, azimuth: stream.uniform(-PI, PI) };
            let each = std::array::from_fn(|_| std::array::from_fn(|_| stream.uniform(-PI, PI)));
            for middles in [Middles::Same(section.azimuths), Middles::Each(each)] {
                for Width(level) in Width::available() {
                    let powers = dispatch_large!(level, simd => powers(simd, &section, &depths));
                    let found = dispatch_large!(level, simd => scattered(simd, &spread, &powers, light, &inclinations, &middles));
                    for k in 0..WAVES {
                        let shares = section.attenuations_at(depths[k]);
                        let mut expected = 0.0;
                        for way in 0..WAYS {
                            let m = along[way].density(inclinations[way], sin, cos);
                            let n = match (&middles, way) {
                                (_, FOLLOWED) => 1.0 / TAU,
                                (Middles::Same(at), _) => around.density(light.azimuth - at[way]),
                                (Middles::Each(at), _) => around.density(light.azimuth - at[way][k]),
                            };
                            expected += shares[way] * m * n;
                        }
                        assert!(
                            (found[k] - expected).abs() < 1e-12 * expected.max(1e-12),
                            "{} {expected}",
                            found[k]
                        );
                        let albedo: f64 = shares.iter().sum();
                        assert!((powers.inverse_albedo[k] * albedo - 1.0).abs() < 1e-14);
                    }
                }
            }
        }
    }
}
