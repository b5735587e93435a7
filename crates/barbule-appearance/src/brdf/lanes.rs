//! The lobes of four wavelengths at once, in vector registers.
//!
//! Two nodes of four lanes (their three lobes, and one lane that is not used) fill a register of eight; a value costs
//! one root and one division. Everything here is inlined into one dispatched function, so it has neither closures nor
//! calls that the compiler could leave outside. Their reference is the module `exact`.

use fearless_simd::{Simd, f32x4, f32x8, prelude::*};

use super::simd::transposed;
use super::table::{COSINE, Corner, EXTRAS, Incident, M2, Node, SINE, STRENGTH, Simplex, Table};

/// An outgoing direction as the three corners of a cell see it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outgoing {
    corners: [Seen; 3],
}

/// What the shape of a lobe needs of ω_o, each in four lanes; after the turn into the node's azimuth.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(16))]
struct Seen {
    /// sin(φ_o/2) and cos(φ_o/2).
    half_sine: [f32; 4],
    half_cosine: [f32; 4],
    /// z·ω_o, its square, and 1 less that.
    z: [f32; 4],
    z2: [f32; 4],
    rest: [f32; 4],
    /// The turn's dφ'/dφ_o.
    stretch: f32,
}

impl Outgoing {
    /// Of ω_o with these sinφ_o and cosφ_o.
    #[inline(always)]
    pub(super) fn new(incident: &Incident, sin_phi: f64, cos_phi: f64) -> Self {
        let mut corners = [Seen::default(); 3];
        for k in 0..3 {
            let Corner { cos_theta, level, shift, scale, .. } = incident.corners[k];
            let inverse = 1.0 / (level + shift * sin_phi);
            let stretch = scale * inverse;
            let (sine, cosine) = ((level * sin_phi + shift) * inverse, cos_phi * stretch);
            let half_cosine = (0.5 + 0.5 * cosine).sqrt();
            let half_sine = 0.5 * sine / half_cosine;
            let z = cos_theta * cosine;
            corners[k] = Seen {
                half_sine: [half_sine as f32; 4],
                half_cosine: [half_cosine as f32; 4],
                z: [z as f32; 4],
                z2: [(z * z) as f32; 4],
                rest: [(1.0 - z * z) as f32; 4],
                stretch: stretch as f32,
            };
        }
        Self { corners }
    }

    #[inline(always)]
    fn seen(&self, corner: u8) -> &Seen {
        &self.corners[usize::from(corner & 3).min(2)]
    }
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
        outgoing: &Outgoing,
        cosine: Cosine,
    ) -> Self {
        let [a, b, c, d] = simplices;
        let (sum_a, extras_a) = mixed(simd, table, a, outgoing, cosine);
        let (sum_b, extras_b) = mixed(simd, table, b, outgoing, cosine);
        let (sum_c, extras_c) = mixed(simd, table, c, outgoing, cosine);
        let (sum_d, extras_d) = mixed(simd, table, d, outgoing, cosine);
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
    outgoing: &Outgoing,
    cosine: Cosine,
) -> (f32x4<S>, f32x4<S>) {
    let Simplex { at, corner, weight } = simplex;
    let (a, b) = (node(&table.nodes, at[0]), node(&table.nodes, at[1]));
    let (c, d) = (node(&table.nodes, at[2]), node(&table.nodes, at[3]));
    let low = two(
        simd,
        [a, b],
        [outgoing.seen(corner[0]), outgoing.seen(corner[1])],
        [weight[0], weight[1]],
        cosine,
    );
    let high = two(
        simd,
        [c, d],
        [outgoing.seen(corner[2]), outgoing.seen(corner[3])],
        [weight[2], weight[3]],
        cosine,
    );
    let (first, second) = (low + high).split();
    let extras = part(simd, a, EXTRAS) * weight[0]
        + part(simd, b, EXTRAS) * weight[1]
        + part(simd, c, EXTRAS) * weight[2]
        + part(simd, d, EXTRAS) * weight[3];
    (first + second, extras)
}

#[inline(always)]
fn part<S: Simd>(simd: S, node: &Node, first: usize) -> f32x4<S> {
    f32x4::from_slice(simd, &node.0[first..first + 4])
}

/// A parameter of the lobes of two nodes.
#[inline(always)]
fn parts<S: Simd>(simd: S, nodes: [&Node; 2], first: usize) -> f32x8<S> {
    part(simd, nodes[0], first).combine(part(simd, nodes[1], first))
}

#[inline(always)]
fn both<S: Simd>(simd: S, a: &[f32; 4], b: &[f32; 4]) -> f32x8<S> {
    f32x4::from_slice(simd, a).combine(f32x4::from_slice(simd, b))
}

/// The weighted values of the lobes of two nodes; the last lane of each is nothing.
#[inline(always)]
fn two<S: Simd>(
    simd: S,
    nodes: [&Node; 2],
    [a, b]: [&Seen; 2],
    weights: [f32; 2],
    Cosine(with_cosine): Cosine,
) -> f32x8<S> {
    let one = f32x8::splat(simd, 1.0);
    let (m2, sine) = (parts(simd, nodes, M2), parts(simd, nodes, SINE));
    let (cosine, strength) = (parts(simd, nodes, COSINE), parts(simd, nodes, STRENGTH));
    let (s, c) = (both(simd, &a.half_sine, &b.half_sine), both(simd, &a.half_cosine, &b.half_cosine));
    let (z, z2) = (both(simd, &a.z, &b.z), both(simd, &a.z2, &b.z2));
    let rest = both(simd, &a.rest, &b.rest);
    let weight =
        f32x4::splat(simd, weights[0] * a.stretch).combine(f32x4::splat(simd, weights[1] * b.stretch));
    let h = s.mul_add(cosine, c * sine);
    let h2 = h * h;
    let aligned = c.mul_add(cosine, s * sine);
    let shape = aligned.mul_add(f32x8::splat(simd, with_cosine), f32x8::splat(simd, 1.0 - with_cosine));
    // m² + (1 − m²) h²
    let q = m2.mul_add(one - h2, h2);
    let q2 = q * q;
    // The steady lobe's wings fall with the fourth power.
    let mask = f32x8::simd_from(simd, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let narrower = q2.mul_add(mask, one - mask);
    let root = m2.mul_add(rest, z2).sqrt();
    strength * weight * shape * z / (q2 * narrower * (z + root))
}

/// Σ w dφ'/dφ ρ_k p_k(φ') in rad⁻¹ at one wavelength, and Σ w ρ_k.
#[inline(always)]
pub(super) fn density<S: Simd>(simd: S, table: &Table, simplex: &Simplex, outgoing: &Outgoing) -> (f32, f32) {
    let (mut sum, mut total) = (f32x4::splat(simd, 0.0), f32x4::splat(simd, 0.0));
    let one = f32x4::splat(simd, 1.0);
    for k in 0..4 {
        let at = simplex.at[k];
        let (lobes, seen) = (node(&table.nodes, at), outgoing.seen(simplex.corner[k]));
        let (m2, sine, cosine) = (part(simd, lobes, M2), part(simd, lobes, SINE), part(simd, lobes, COSINE));
        let (s, c) = (f32x4::from_slice(simd, &seen.half_sine), f32x4::from_slice(simd, &seen.half_cosine));
        let factor = f32x4::from_slice(simd, &node(&table.shares, at).0);
        let h = s.mul_add(cosine, c * sine);
        let h2 = h * h;
        let q = m2.mul_add(one - h2, h2);
        let along = (c * cosine - s * sine).max(0.0);
        sum += factor * along / (q * q) * (simplex.weight[k] * seen.stretch);
        total += factor * simplex.weight[k];
    }
    (sum[0] + sum[1], total[2] + total[3])
}
