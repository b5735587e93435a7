//! Values of many pairs of directions.
//!
//! A single evaluation waits most of its time: the place in the tables follows from roots and divisions, the nodes from that place, the
//! noise from the nodes. Here eight pairs are prepared side by side, one step after the other for all of them, and what is left for each is the
//! kernel over its wavelengths, which finds all that it needs in the nearest cache. Operations and their order are those of a single
//! evaluation, so values are the same bits.

use fearless_simd::{Simd, f32x4, f32x8, f64x8, prelude::*};
use glam::DVec3;

use super::evaluate::{At, FeatherBrdf, Pair, is_above};
use super::lanes::{Cosine, Outgoing, Simplices, exp_of_negative};
use super::longitudinal::PARTS;
use super::noise::Draw;
use super::table::{Corners, LEAST_COSINE, LEAST_OUTGOING};
use super::tables::Reciprocity;
use crate::math::simd::dispatch_large;
use crate::scattering::statistics::Sides;

/// Pairs that are prepared side by side.
const EIGHT: usize = 8;

impl FeatherBrdf {
    /// [`eval`](Self::eval) of each pair of ω_i and ω_o at as many fours of wavelengths, the same bits in less time; `instances` name their
    /// barbules, the smooth mean without. Wavelengths and values of a pair follow each other.
    ///
    /// # Panics
    /// There are not as many instances as pairs, or values as wavelengths, or wavelengths for each pair.
    pub fn eval_all(
        &self,
        pairs: &[[DVec3; 2]],
        wavelengths_nm: &[[f32; 4]],
        instances: Option<&[u64]>,
        values: &mut [[f32; 4]],
    ) {
        if pairs.is_empty() {
            return;
        }
        let fours = wavelengths_nm.len() / pairs.len();
        assert!(fours > 0 && fours * pairs.len() == wavelengths_nm.len(), "wavelengths for each pair");
        assert_eq!(values.len(), wavelengths_nm.len(), "values for all wavelengths");
        assert!(instances.is_none_or(|names| names.len() == pairs.len()), "an instance for each pair");
        let spectra = wavelengths_nm.chunks(EIGHT * fours).zip(values.chunks_mut(EIGHT * fours));
        for (block, (pairs, (wavelengths_nm, values))) in pairs.chunks(EIGHT).zip(spectra).enumerate() {
            let draws = instances.map(|names| {
                let names = &names[block * EIGHT..];
                std::array::from_fn(|k| self.instance(names[k.min(names.len() - 1)]))
            });
            let mut eight = Eight { pairs, draws: draws.as_ref(), wavelengths_nm, values };
            eight.fill(self);
        }
    }
}

/// Up to eight pairs.
struct Eight<'a> {
    pairs: &'a [[DVec3; 2]],
    draws: Option<&'a [Draw; EIGHT]>,
    wavelengths_nm: &'a [[f32; 4]],
    values: &'a mut [[f32; 4]],
}

impl Eight<'_> {
    fn fill(&mut self, brdf: &FeatherBrdf) {
        self.values.fill([0.0; 4]);
        match brdf.reciprocity {
            Reciprocity::AsFitted => self.add(brdf, |_| false),
            Reciprocity::Steeper => {
                self.add(brdf, Reciprocity::is_steeper);
                self.level_at_horizon(brdf);
            }
            Reciprocity::Mean => {
                self.add(brdf, |_| false);
                self.add(brdf, |_| true);
                self.values.as_flattened_mut().iter_mut().for_each(|value| *value *= 0.5);
            }
        }
    }

    /// Values again of those few pairs that both tables are asked about.
    fn level_at_horizon(&mut self, brdf: &FeatherBrdf) {
        let fours = self.values.len() / self.pairs.len();
        let spectra = self.wavelengths_nm.chunks_exact(fours).zip(self.values.chunks_exact_mut(fours));
        for (k, (pair, (nm, values))) in self.pairs.iter().zip(spectra).enumerate() {
            if Reciprocity::at_horizon(*pair) > 0.0 && pair.iter().all(|w| is_above(*w)) {
                values.fill([0.0; 4]);
                let draw = self.draws.map(|draws| &draws[k]);
                brdf.add_both_ways(nm.as_flattened(), *pair, None, draw, values.as_flattened_mut());
            }
        }
    }

    /// Adds f from the one to the other direction, or where `is_turned` from the other to the one.
    fn add(&mut self, brdf: &FeatherBrdf, is_turned: impl Fn([DVec3; 2]) -> bool) {
        let directions = Directions::new(self.pairs, is_turned);
        let prepared = Prepared::new(brdf, &directions);
        let fours = self.values.len() / self.pairs.len();
        let spectra = self.wavelengths_nm.chunks_exact(fours).zip(self.values.chunks_exact_mut(fours));
        for (k, (nm, values)) in spectra.enumerate() {
            let [wi, wo] = directions.pair(k);
            // Most directions are far off the barbule's narrow cone, and of its halo.
            if prepared.factors[k] == [0.0; PARTS] || !is_above(wi) || !is_above(wo) {
                continue;
            }
            match self.draws {
                None => {
                    let asked = brdf.tables.polarization.is_some();
                    let facet = if asked { (wi.x + wo.x) / (wi.z + wo.z) } else { 0.0 };
                    let pair = prepared.pair(k, facet);
                    for (nm, values) in nm.iter().zip(values) {
                        brdf.add_prepared_smooth(&prepared, k, &pair, nm, values);
                    }
                }
                Some(draws) => {
                    let at = At::new(&draws[k], [wi, wo]);
                    let pair = prepared.pair(k, at.facet);
                    for (nm, values) in nm.iter().zip(values) {
                        brdf.add_prepared_drawn(&prepared, k, (&pair, &at), nm, values);
                    }
                }
            }
        }
    }
}

// A kernel for each, without what the other needs.
impl FeatherBrdf {
    #[inline(never)]
    fn add_prepared_smooth(
        &self,
        all: &Prepared,
        k: usize,
        pair: &Pair,
        nm: &[f32; 4],
        values: &mut [f32; 4],
    ) {
        for set in 0..self.tables.sets.len() {
            dispatch_large!(self.level, simd => {
                self.add_four(simd, set, &all.simplices(simd, self, k, nm), (pair, None), nm, values);
            });
        }
    }

    #[inline(never)]
    fn add_prepared_drawn(
        &self,
        all: &Prepared,
        k: usize,
        (pair, at): (&Pair, &At<'_>),
        nm: &[f32; 4],
        values: &mut [f32; 4],
    ) {
        for set in 0..self.tables.sets.len() {
            dispatch_large!(self.level, simd => {
                self.add_four(simd, set, &all.simplices(simd, self, k, nm), (pair, Some(at)), nm, values);
            });
        }
    }
}

/// Eight pairs of directions, number by number.
struct Directions {
    wi: [[f64; EIGHT]; 3],
    wo: [[f64; EIGHT]; 3],
}

impl Directions {
    /// Where there are fewer, along the normal.
    fn new(pairs: &[[DVec3; 2]], is_turned: impl Fn([DVec3; 2]) -> bool) -> Self {
        let along = [[0.0; EIGHT], [0.0; EIGHT], [1.0; EIGHT]];
        let mut all = Self { wi: along, wo: along };
        for (k, &[wi, wo]) in pairs.iter().enumerate() {
            let (first, second) = if is_turned([wi, wo]) { (wo, wi) } else { (wi, wo) };
            for axis in 0..3 {
                (all.wi[axis][k], all.wo[axis][k]) = (first[axis], second[axis]);
            }
        }
        all
    }

    fn pair(&self, k: usize) -> [DVec3; 2] {
        [&self.wi, &self.wo].map(|[x, y, z]| DVec3::new(x[k], y[k], z[k]))
    }
}

/// What the kernels of eight pairs begin with.
struct Prepared {
    corners: [Corners; EIGHT],
    /// What an [`Outgoing`] holds.
    tau: [f32; EIGHT],
    level: [[f32; EIGHT]; 3],
    z: [[f32; EIGHT]; 3],
    scale: [[f32; EIGHT]; 3],
    /// See [`Pair`].
    factors: [[f32; PARTS]; EIGHT],
    /// 1, or −1 where the tables hold the mirror image.
    side: [f64; EIGHT],
}

impl Prepared {
    fn new(brdf: &FeatherBrdf, directions: &Directions) -> Self {
        let grid = &brdf.tables.grid;
        let places = dispatch_large!(brdf.level, simd => grid.places(simd, &directions.wi));
        let corners: [Corners; EIGHT] = std::array::from_fn(|k| grid.corners(places.theta[k], places.phi[k]));
        let is_alike = grid.sides() == Sides::Alike;
        let mut all = Self {
            corners,
            tau: [0.0; EIGHT],
            level: [[0.0; EIGHT]; 3],
            z: [[0.0; EIGHT]; 3],
            scale: [[0.0; EIGHT]; 3],
            factors: [[0.0; PARTS]; EIGHT],
            side: directions.wi[0].map(|x| if is_alike && x < 0.0 { -1.0 } else { 1.0 }),
        };
        let share = if brdf.tables.sets.len() == 2 { 0.5 } else { 1.0 };
        let (mut spread, mut scales) = ([[0.0; EIGHT]; PARTS], [0.0; EIGHT]);
        dispatch_large!(brdf.level, simd => {
            let towards = all.towards(simd, directions, &places.cos_theta, brdf.cosine());
            let [exponent, scale] = spread_of(simd, directions, &places.cos_theta, &towards, share);
            scales = scale.into();
            for (inverse, spread) in brdf.inverse_sigma2.iter().zip(&mut spread) {
                *spread = exp_of_eight(simd, (exponent * *inverse).into());
            }
        });
        for (k, factors) in all.factors.iter_mut().enumerate() {
            let inverse_q = brdf.tables.longitudinal.inverse_q(places.cos_theta[k]);
            *factors = std::array::from_fn(|part| spread[part][k] * (inverse_q[part] * scales[k]) as f32);
        }
        all
    }

    /// Fills what an [`Outgoing`] holds; gives cosθ_o, and that times cosφ_o.
    #[inline(always)]
    fn towards<S: Simd>(
        &mut self,
        simd: S,
        directions: &Directions,
        cos_theta: &[f64; EIGHT],
        Cosine(with_cosine): Cosine,
    ) -> [f64x8<S>; 2] {
        let [x, _, z] = directions.wi.map(|part| f64x8::from_slice(simd, &part));
        let [x_o, _, z_o] = directions.wo.map(|part| f64x8::from_slice(simd, &part));
        let (side, cos_theta) = (f64x8::from_slice(simd, &self.side), f64x8::from_slice(simd, cos_theta));
        let [above, below] = tangents(simd, x * side, z.max(cos_theta * LEAST_COSINE), cos_theta);
        let cos_theta_o = (x_o * x_o + z_o * z_o).sqrt();
        let cosine = z_o.max(cos_theta_o * LEAST_OUTGOING);
        let [above_o, below_o] = tangents(simd, x_o * side, cosine, cos_theta_o);
        let tau: [f64; EIGHT] = (above * above_o / (below * below_o)).into();
        self.tau = tau.map(|tau| tau as f32);
        let tau = f32x8::from_slice(simd, &self.tau);
        for corner in 0..3 {
            let (mut tangents, mut cosines) = ([0.0; EIGHT], [0.0; EIGHT]);
            for (k, corners) in self.corners.iter().enumerate() {
                (tangents[k], cosines[k]) = (corners.tangents[corner], corners.cos_theta[corner]);
            }
            // As `Outgoing::new`.
            let tangent = f32x8::from_slice(simd, &tangents);
            let square = tangent * tangent;
            let level = f32x8::splat(simd, 1.0) / (square + tau * tau);
            let root = level.sqrt();
            let cosine = tangent * level * (tau * 2.0);
            let z = f32x8::from_slice(simd, &cosines) * cosine;
            let scale = z * cosine * (root * with_cosine + (1.0 - with_cosine));
            self.level[corner] = level.into();
            self.z[corner] = z.into();
            self.scale[corner] = scale.into();
        }
        [cos_theta_o, cosine]
    }

    #[inline(always)]
    fn simplices<S: Simd>(&self, simd: S, brdf: &FeatherBrdf, k: usize, nm: &[f32; 4]) -> Simplices<S> {
        let Corners { first, shares, .. } = &self.corners[k];
        let of = |all: &[[f32; EIGHT]; 3]| [all[0][k], all[1][k], all[2][k]];
        let outgoing = Outgoing::of(self.tau[k], of(&self.level), of(&self.z), of(&self.scale));
        let shares = shares.map(|share| share as f32);
        Simplices::new(simd, &brdf.tables.grid, (first, shares), &outgoing, nm, brdf.cosine())
    }

    #[inline(always)]
    fn pair(&self, k: usize, facet: f64) -> Pair {
        let facet = (facet * self.side[k]) as f32;
        Pair { slope: self.corners[k].slope, facet, factors: self.factors[k] }
    }
}

/// [`tangent`](super::table::tangent) of eight azimuths.
#[inline(always)]
fn tangents<S: Simd>(simd: S, sine: f64x8<S>, cosine: f64x8<S>, factor: f64x8<S>) -> [f64x8<S>; 2] {
    let sum = factor + sine.abs();
    let is_below = sine.simd_lt(f64x8::splat(simd, 0.0));
    [is_below.select(cosine, sum), is_below.select(sum, cosine)]
}

/// sin²((θ_i + θ_o)/2), as `half_sine_squared`, and what f has beside the spread along the barbule.
#[inline(always)]
fn spread_of<S: Simd>(
    simd: S,
    directions: &Directions,
    cos_theta: &[f64; EIGHT],
    [cos_theta_o, cosine]: &[f64x8<S>; 2],
    share: f64,
) -> [f64x8<S>; 2] {
    let (y, cos_theta) = (f64x8::from_slice(simd, &directions.wi[1]), f64x8::from_slice(simd, cos_theta));
    let [_, y_o, z_o] = directions.wo.map(|part| f64x8::from_slice(simd, &part));
    let (cos_theta_o, cosine_o) = (*cos_theta_o, *cosine);
    let sine = y * cos_theta_o + y_o * cos_theta;
    let cosine = cos_theta * cos_theta_o - y * y_o;
    let one = f64x8::splat(simd, 1.0);
    let is_together = cosine.simd_gt(f64x8::splat(simd, 0.0));
    let half = is_together.select(sine * sine / ((one + cosine) * 2.0), (one - cosine) * 0.5);
    [half, cos_theta_o * share / (z_o * cosine_o)]
}

#[inline(always)]
fn exp_of_eight<S: Simd>(simd: S, exponents: [f64; EIGHT]) -> [f32; EIGHT] {
    let exponents = exponents.map(|exponent| exponent as f32);
    let [low, high] = [&exponents[..4], &exponents[4..]];
    let (low, high) = (f32x4::from_slice(simd, low), f32x4::from_slice(simd, high));
    exp_of_negative(simd, low).combine(exp_of_negative(simd, high)).into()
}
