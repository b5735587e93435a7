//! The lobes of four wavelengths at once, in vector registers.
//!
//! Four nodes of four lanes (their three lobes, and one lane that is not used) fill a register of sixteen; a value costs
//! one root and one division. Everything here is inlined into one dispatched function, so it has neither closures nor
//! calls that the compiler could leave outside. Their reference is the module `exact`.

use fearless_simd::{Simd, f32x4, f32x8, f32x16, f64x4, i32x4, prelude::*};
use std::f32::consts::{LN_2, LOG2_E};

use super::simd::transposed;
use super::table::{COSINE, EXTRAS, Incident, M2, Node, SINE, STRENGTH, Simplex, Table};

/// What the shapes of lobes need of ω_o, turned into the azimuths of the three corners of a cell; lanes are corners.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outgoing {
    /// sin(φ_o/2) and cos(φ_o/2).
    half_sine: [f32; 4],
    half_cosine: [f32; 4],
    /// z·ω_o.
    z: [f32; 4],
    /// The turn's dφ'/dφ_o.
    stretch: [f32; 4],
}

impl Outgoing {
    /// Of ω_o with these sinφ_o and cosφ_o. Numerators and denominators of the turns are in double precision, since
    /// towards grazing azimuths they cancel.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, incident: &Incident, [sin_phi, cos_phi]: [f64; 2]) -> Self {
        let (level, shift) =
            (f64x4::from_slice(simd, &incident.level), f64x4::from_slice(simd, &incident.shift));
        let sin_phi = f64x4::splat(simd, sin_phi);
        let denominator = single(simd, shift.mul_add(sin_phi, level));
        let numerator = single(simd, level.mul_add(sin_phi, shift));
        let inverse = f32x4::splat(simd, 1.0) / denominator;
        let stretch = single(simd, f64x4::from_slice(simd, &incident.scale)) * inverse;
        let cosine = stretch * cos_phi as f32;
        let half_cosine = cosine.mul_add(f32x4::splat(simd, 0.5), f32x4::splat(simd, 0.5)).sqrt();
        let half_sine = numerator * inverse * 0.5 / half_cosine;
        let z = single(simd, f64x4::from_slice(simd, &incident.cos_theta)) * cosine;
        Self {
            half_sine: half_sine.into(),
            half_cosine: half_cosine.into(),
            z: z.into(),
            stretch: stretch.into(),
        }
    }
}

#[inline(always)]
fn single<S: Simd>(simd: S, values: f64x4<S>) -> f32x4<S> {
    f32x4::simd_from(simd, [values[0] as f32, values[1] as f32, values[2] as f32, values[3] as f32])
}

/// The same for the pairs of nodes that a simplex can have: of the first two nodes two, of the last two another two.
pub(super) struct Pairs<S: Simd> {
    low: [Pair<S>; 2],
    high: [Pair<S>; 2],
}

/// Two corners, each in four lanes.
#[derive(Clone, Copy)]
struct Pair<S: Simd> {
    half_sine: f32x8<S>,
    half_cosine: f32x8<S>,
    z: f32x8<S>,
    /// z times the stretch.
    stretched: f32x8<S>,
}

impl<S: Simd> Pairs<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, outgoing: &Outgoing) -> Self {
        Self {
            low: [Pair::new(simd, outgoing, 0, 0), Pair::new(simd, outgoing, 0, 1)],
            high: [Pair::new(simd, outgoing, 1, 2), Pair::new(simd, outgoing, 2, 2)],
        }
    }
}

impl<S: Simd> Pair<S> {
    #[inline(always)]
    fn new(simd: S, outgoing: &Outgoing, a: usize, b: usize) -> Self {
        let Outgoing { half_sine, half_cosine, z, stretch } = outgoing;
        let z = both(simd, z[a], z[b]);
        Self {
            half_sine: both(simd, half_sine[a], half_sine[b]),
            half_cosine: both(simd, half_cosine[a], half_cosine[b]),
            z,
            stretched: z * both(simd, stretch[a], stretch[b]),
        }
    }
}

#[inline(always)]
fn both<S: Simd>(simd: S, a: f32, b: f32) -> f32x8<S> {
    f32x4::splat(simd, a).combine(f32x4::splat(simd, b))
}

/// P of the mean and of the steady part, rad⁻¹, and what else the nodes hold, at four wavelengths.
#[derive(Clone, Copy)]
pub(super) struct Mixed<S: Simd> {
    pub(super) mean: f32x4<S>,
    pub(super) steady: f32x4<S>,
    pub(super) inverse_length: f32x4<S>,
    pub(super) correlation: f32x4<S>,
    pub(super) fraction: f32x4<S>,
    pub(super) steady_fraction: f32x4<S>,
}

/// The part of the cosine cos((φ_o − φ_eff)/2) in a shape: 1 with it, 0 without.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cosine(pub(super) f32);

impl<S: Simd> Mixed<S> {
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        table: &Table,
        simplices: &[Simplex; 4],
        pairs: &Pairs<S>,
        cosine: Cosine,
    ) -> Self {
        let [a, b, c, d] = simplices;
        let (sum_a, extras_a) = mixed(simd, table, a, pairs, cosine);
        let (sum_b, extras_b) = mixed(simd, table, b, pairs, cosine);
        let (sum_c, extras_c) = mixed(simd, table, c, pairs, cosine);
        let (sum_d, extras_d) = mixed(simd, table, d, pairs, cosine);
        let [first, second, steady, _] = transposed(sum_a, sum_b, sum_c, sum_d);
        let [inverse_length, correlation, fraction, steady_fraction] =
            transposed(extras_a, extras_b, extras_c, extras_d);
        let mean = first + second;
        Self { mean, steady: steady.min(mean), inverse_length, correlation, fraction, steady_fraction }
    }
}

/// Nodes of a simplex, whatever its numbers are.
#[inline(always)]
fn node<T>(nodes: &[T], at: u32) -> &T {
    &nodes[at as usize]
}

/// The lobes' values and the extras at one wavelength.
#[inline(always)]
fn mixed<S: Simd>(
    simd: S,
    table: &Table,
    simplex: &Simplex,
    pairs: &Pairs<S>,
    cosine: Cosine,
) -> (f32x4<S>, f32x4<S>) {
    let Simplex { at, weight, middle } = simplex;
    let (a, b) = (node(&table.nodes, at[0]), node(&table.nodes, at[1]));
    let (c, d) = (node(&table.nodes, at[2]), node(&table.nodes, at[3]));
    let low = &pairs.low[usize::from(middle[0] & 1)];
    // The third node's corner is 1 or 2.
    let high = &pairs.high[usize::from(middle[1] >> 1)];
    let weights = both(simd, weight[0], weight[1]).combine(both(simd, weight[2], weight[3]));
    let (low, high) = four(simd, [a, b, c, d], low, high, weights, cosine).split();
    let (first, second) = (low + high).split();
    let extras = part(simd, d, EXTRAS) * weight[3];
    let extras = part(simd, c, EXTRAS).mul_add(f32x4::splat(simd, weight[2]), extras);
    let extras = part(simd, b, EXTRAS).mul_add(f32x4::splat(simd, weight[1]), extras);
    let extras = part(simd, a, EXTRAS).mul_add(f32x4::splat(simd, weight[0]), extras);
    (first + second, extras)
}

#[inline(always)]
fn part<S: Simd>(simd: S, node: &Node, first: usize) -> f32x4<S> {
    f32x4::from_slice(simd, &node.0[first..first + 4])
}

/// A parameter of the lobes of four nodes.
#[inline(always)]
fn parts<S: Simd>(simd: S, [a, b, c, d]: [&Node; 4], first: usize) -> f32x16<S> {
    let low: f32x8<S> = part(simd, a, first).combine(part(simd, b, first));
    low.combine(part(simd, c, first).combine(part(simd, d, first)))
}

/// The weighted values of the lobes of four nodes; the last lane of each is nothing.
#[inline(always)]
fn four<S: Simd>(
    simd: S,
    nodes: [&Node; 4],
    low: &Pair<S>,
    high: &Pair<S>,
    weight: f32x16<S>,
    Cosine(with_cosine): Cosine,
) -> f32x16<S> {
    let one = f32x16::splat(simd, 1.0);
    let (s, c) = (low.half_sine.combine(high.half_sine), low.half_cosine.combine(high.half_cosine));
    let z: f32x16<S> = low.z.combine(high.z);
    let stretched: f32x16<S> = low.stretched.combine(high.stretched);
    let (m2, sine) = (parts(simd, nodes, M2), parts(simd, nodes, SINE));
    let (cosine, strength) = (parts(simd, nodes, COSINE), parts(simd, nodes, STRENGTH));
    let h: f32x16<S> = cosine.mul_add(s, sine * c);
    let h2 = h * h;
    let aligned = cosine.mul_add(c, sine * s);
    let shape = aligned.mul_add(f32x16::splat(simd, with_cosine), f32x16::splat(simd, 1.0 - with_cosine));
    // m² + (1 − m²) h²
    let q = m2.mul_add(one - h2, h2);
    let q2 = q * q;
    // The steady lobe's wings fall with the fourth power.
    let mask = f32x16::from_slice(simd, &STEADY);
    let narrower = q2.mul_add(mask, one - mask);
    let z2 = z * z;
    let root = m2.mul_add(one - z2, z2).sqrt();
    (strength * weight) * (shape * stretched) / ((q2 * narrower) * (z + root))
}

/// Which lanes belong to steady lobes.
const STEADY: [f32; 16] = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// Σ w dφ'/dφ ρ_k p_k(φ') in rad⁻¹ at one wavelength, and Σ w ρ_k.
#[inline(always)]
pub(super) fn density<S: Simd>(simd: S, table: &Table, simplex: &Simplex, outgoing: &Outgoing) -> (f32, f32) {
    let (mut sum, mut total) = (f32x4::splat(simd, 0.0), f32x4::splat(simd, 0.0));
    let one = f32x4::splat(simd, 1.0);
    for k in 0..4 {
        let at = simplex.at[k];
        let (lobes, corner) = (node(&table.nodes, at), usize::from(simplex.corners()[k] & 3));
        let (m2, sine, cosine) = (part(simd, lobes, M2), part(simd, lobes, SINE), part(simd, lobes, COSINE));
        let s = f32x4::splat(simd, outgoing.half_sine[corner]);
        let c = f32x4::splat(simd, outgoing.half_cosine[corner]);
        let factor = f32x4::from_slice(simd, &node(&table.shares, at).0);
        let h = s.mul_add(cosine, c * sine);
        let h2 = h * h;
        let q = m2.mul_add(one - h2, h2);
        let along = (c * cosine - s * sine).max(0.0);
        sum += factor * along / (q * q) * (simplex.weight[k] * outgoing.stretch[corner]);
        total += factor * simplex.weight[k];
    }
    (sum[0] + sum[1], total[2] + total[3])
}

/// exp(−u) for u ≥ 0, relative error 3e-7; zero (below 1e-37) for large u.
#[inline(always)]
pub(super) fn exp_of_negative<S: Simd>(simd: S, u: f32x4<S>) -> f32x4<S> {
    let y = (u * -LOG2_E).max(-125.0);
    let whole = y.round_ties_even();
    let f = (y - whole) * LN_2;
    let bits = (whole.to_int::<i32x4<S>>() + i32x4::splat(simd, 127)) << 23;
    let mut series = f32x4::splat(simd, 1.0 / 720.0);
    for coefficient in [1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0] {
        series = series.mul_add(f, f32x4::splat(simd, coefficient));
    }
    let zero = f32x4::splat(simd, 0.0);
    u.simd_gt(f32x4::splat(simd, 86.0)).select(zero, series * bits.bitcast::<f32x4<S>>())
}
