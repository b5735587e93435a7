//! The lobes of four wavelengths at once, in vector registers.
//!
//! Of each wavelength four nodes are mixed. The first nodes of all four wavelengths fill a register of sixteen lanes (their
//! three lobes, and a lane that is not used), so do the second, the third and the fourth: what the nodes give is summed
//! without shuffles, and a register's values cost one root and one reciprocal. Everything here is inlined into one dispatched
//! function, so it has neither closures nor calls that the compiler could leave outside. Its reference is the module
//! `exact`.

use fearless_simd::{Simd, f32x4, f32x8, f32x16, i32x4, mask32x16, prelude::*};
use std::f32::consts::{LN_2, LOG2_E};

use super::longitudinal::{END, PARTS};
use super::simd::{columns, spread};
use super::table::{EXTRAS, Grid, Incident, M2, MIDDLE, Node, REST, STRENGTH, Shares, Table};

/// What the shapes of lobes need of τ = τ(φ_i) τ(φ_o) at the three corners of a cell; lanes are corners. φ' is φ_o turned
/// to the corner.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outgoing {
    /// τ itself.
    tau: f32,
    /// 1/(τ_n² + τ²) with the corner's τ_n = τ(φ_i).
    level: [f32; 4],
    /// z·ω_o of φ'.
    z: [f32; 4],
    /// z cosφ', and √level if shapes have the cosine.
    scale: [f32; 4],
    /// τ_n².
    square: [f32; 4],
    /// cosφ' √level/τ_n.
    drawn: [f32; 4],
}

impl Outgoing {
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, incident: &Incident, tau: f32, Cosine(with_cosine): Cosine) -> Self {
        let tangent = f32x4::from_slice(simd, &incident.corners.tangents);
        let square = tangent * tangent;
        let level = f32x4::splat(simd, 1.0) / (square + tau * tau);
        let root = level.sqrt();
        let cosine = tangent * level * (2.0 * tau);
        let z = f32x4::from_slice(simd, &incident.corners.cos_theta) * cosine;
        let scale = z * cosine * (root * with_cosine + (1.0 - with_cosine));
        let drawn = cosine * root / tangent;
        Self {
            tau,
            level: level.into(),
            z: z.into(),
            scale: scale.into(),
            square: square.into(),
            drawn: drawn.into(),
        }
    }

    /// Of numbers that are known at each corner; without what densities need.
    #[inline(always)]
    pub(super) fn of(tau: f32, level: [f32; 3], z: [f32; 3], scale: [f32; 3]) -> Self {
        let [level, z, scale] = [level, z, scale].map(|[a, b, c]| [a, b, c, c]);
        Self { tau, level, z, scale, square: [0.0; 4], drawn: [0.0; 4] }
    }
}

/// One of the four nodes of each wavelength.
#[derive(Clone, Copy)]
struct Role<S: Simd> {
    /// Numbers of the nodes.
    at: [u32; 4],
    weight: f32x16<S>,
    /// The corner that they belong to.
    corner: Corner<S>,
}

/// [`Outgoing`], in the lanes of each wavelength that of one corner.
#[derive(Clone, Copy)]
struct Corner<S: Simd> {
    level: f32x16<S>,
    z: f32x16<S>,
    scale: f32x16<S>,
    square: f32x16<S>,
    drawn: f32x16<S>,
}

impl<S: Simd> Corner<S> {
    #[inline(always)]
    fn new(simd: S, outgoing: &Outgoing, corner: usize) -> Self {
        Self {
            level: f32x16::splat(simd, outgoing.level[corner]),
            z: f32x16::splat(simd, outgoing.z[corner]),
            scale: f32x16::splat(simd, outgoing.scale[corner]),
            square: f32x16::splat(simd, outgoing.square[corner]),
            drawn: f32x16::splat(simd, outgoing.drawn[corner]),
        }
    }

    /// This corner where the mask is set, the other elsewhere.
    #[inline(always)]
    fn or(&self, other: &Self, mask: mask32x16<S>) -> Self {
        Self {
            level: mask.select(self.level, other.level),
            z: mask.select(self.z, other.z),
            scale: mask.select(self.scale, other.scale),
            square: mask.select(self.square, other.square),
            drawn: mask.select(self.drawn, other.drawn),
        }
    }
}

/// The simplices of four wavelengths: see [`Grid::simplex`], which is the same for one.
pub(super) struct Simplices<S: Simd> {
    roles: [Role<S>; 4],
    tau: f32x16<S>,
    cosine: Cosine,
}

impl<S: Simd> Simplices<S> {
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        grid: &Grid,
        (corners, [larger, smaller]): (&[u32; 3], [f32; 2]),
        outgoing: &Outgoing,
        wavelengths_nm: &[f32; 4],
        cosine: Cosine,
    ) -> Self {
        let (wave, share) = grid.waves_at(simd, wavelengths_nm);
        let first = share.simd_ge(f32x4::splat(simd, larger));
        let second = share.simd_ge(f32x4::splat(simd, smaller));
        let below = corners.map(|first| i32x4::splat(simd, first as i32) + wave);
        let up = grid.next_wave() as i32;
        let at = [
            below[0],
            first.select(below[0] + up, below[1]),
            second.select(below[1] + up, below[2]),
            below[2] + up,
        ];
        let share = spread(share);
        let (first, second) =
            (share.simd_ge(f32x16::splat(simd, larger)), share.simd_ge(f32x16::splat(simd, smaller)));
        let (a, c) = (share.max(larger), share.min(smaller));
        let b = share.min(larger).max(smaller);
        let one = f32x16::splat(simd, 1.0);
        let corners =
            [Corner::new(simd, outgoing, 0), Corner::new(simd, outgoing, 1), Corner::new(simd, outgoing, 2)];
        let middle = [corners[0].or(&corners[1], first), corners[1].or(&corners[2], second)];
        let roles = [
            Role { at: numbers(at[0]), weight: one - a, corner: corners[0] },
            Role { at: numbers(at[1]), weight: a - b, corner: middle[0] },
            Role { at: numbers(at[2]), weight: b - c, corner: middle[1] },
            Role { at: numbers(at[3]), weight: c, corner: corners[2] },
        ];
        Self { roles, tau: f32x16::splat(simd, outgoing.tau), cosine }
    }
}

#[inline(always)]
fn numbers<S: Simd>(at: i32x4<S>) -> [u32; 4] {
    [at[0] as u32, at[1] as u32, at[2] as u32, at[3] as u32]
}

/// P cosφ_o of the mean and of the steady part, rad⁻¹, at four wavelengths.
#[derive(Clone, Copy)]
pub(super) struct Mixed<S: Simd> {
    pub(super) mean: f32x4<S>,
    pub(super) steady: f32x4<S>,
}

/// What else the nodes hold, at four wavelengths.
#[derive(Clone, Copy)]
pub(super) struct Extras<S: Simd> {
    pub(super) inverse_length: f32x4<S>,
    pub(super) correlation: f32x4<S>,
    /// √(1 − γ²).
    pub(super) rest: f32x4<S>,
    pub(super) fraction: f32x4<S>,
    pub(super) fraction_slope: f32x4<S>,
}

/// The part of the cosine cos((φ_o − φ_eff)/2) in a shape: 1 with it, 0 without.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cosine(pub(super) f32);

impl<S: Simd> Mixed<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, table: &Table, simplices: &Simplices<S>) -> Self {
        let Simplices { roles: [a, b, c, d], tau, cosine } = simplices;
        let sum = a.lobes(simd, table, *tau, *cosine) + b.lobes(simd, table, *tau, *cosine);
        let sum = sum + (c.lobes(simd, table, *tau, *cosine) + d.lobes(simd, table, *tau, *cosine));
        let [first, second, steady, _] = columns(sum);
        let mean = first + second;
        Self { mean, steady: steady.min(1.0) * mean }
    }
}

impl<S: Simd> Extras<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, table: &Table, simplices: &Simplices<S>) -> Self {
        let [a, b, c, d] = &simplices.roles;
        let sum = b.part(simd, table, EXTRAS).mul_add(b.weight, a.part(simd, table, EXTRAS) * a.weight);
        let more = d.part(simd, table, EXTRAS).mul_add(d.weight, c.part(simd, table, EXTRAS) * c.weight);
        let [inverse_length, correlation, fraction, fraction_slope] = columns(sum + more);
        let rest = (f32x4::splat(simd, 1.0) - correlation * correlation).max(0.0).sqrt();
        Self { inverse_length, correlation, rest, fraction, fraction_slope }
    }
}

impl<S: Simd> Role<S> {
    /// Four numbers of each node.
    #[inline(always)]
    fn part(&self, simd: S, table: &Table, first: usize) -> f32x16<S> {
        let [a, b, c, d] = self.at;
        let nodes = &table.nodes[..];
        let low: f32x8<S> =
            part(simd, &nodes[a as usize], first).combine(part(simd, &nodes[b as usize], first));
        low.combine(part(simd, &nodes[c as usize], first).combine(part(simd, &nodes[d as usize], first)))
    }

    /// The weighted values of the lobes; the last of four lanes is nothing.
    #[inline(always)]
    fn lobes(&self, simd: S, table: &Table, tau: f32x16<S>, Cosine(with_cosine): Cosine) -> f32x16<S> {
        let Corner { level, z, scale, .. } = self.corner;
        let one = f32x16::splat(simd, 1.0);
        let (m2, rest) = (self.part(simd, table, M2), self.part(simd, table, REST));
        let (middle, strength) = (self.part(simd, table, MIDDLE), self.part(simd, table, STRENGTH));
        let away = tau - middle;
        let aligned = tau + middle;
        let shape = aligned.mul_add(f32x16::splat(simd, with_cosine), f32x16::splat(simd, 1.0 - with_cosine));
        // m² + (1 − m²) h²
        let q = (rest * level).mul_add(away * away, m2);
        let q2 = q * q;
        let z2 = z * z;
        let root = m2.mul_add(one - z2, z2).sqrt();
        // A share of the mean is a power of q alone.
        let (of_mean, of_steady) = (f32x16::from_slice(simd, &MEAN), f32x16::from_slice(simd, &STEADY));
        let above = (shape * scale).mul_add(of_mean, of_steady);
        let below = (z + root).mul_add(of_mean, of_steady);
        (strength * self.weight) * above * inverse(simd, q2 * below)
    }
}

/// 1/x of normal numbers, to rounding: an estimate and steps of Newton's method, each of which squares its error. They take
/// less time than a division of sixteen lanes.
#[inline(always)]
fn inverse<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    let one = f32x16::splat(simd, 1.0);
    let mut estimate = x.approximate_recip();
    // 11 bits at least, 8 where the architecture has no better.
    if cfg!(target_arch = "aarch64") {
        estimate = (-x).mul_add(estimate, one).mul_add(estimate, estimate);
    }
    (-x).mul_add(estimate, one).mul_add(estimate, estimate)
}

#[inline(always)]
fn part<S: Simd>(simd: S, node: &Node, first: usize) -> f32x4<S> {
    f32x4::from_slice(simd, &node.0[first..first + 4])
}

/// Which lanes belong to steady shares, and which to lobes of the mean.
const STEADY: [f32; 16] = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
const MEAN: [f32; 16] = [1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0, 1.0];

/// The shares of the Gaussians along the barbule, each at four wavelengths.
#[inline(always)]
pub(super) fn parts<S: Simd>(simd: S, shares: &[Shares], simplices: &Simplices<S>) -> [f32x4<S>; PARTS] {
    let [a, b, c, d] = &simplices.roles;
    let sum = a.shares(simd, shares) * a.weight;
    let sum = b.shares(simd, shares).mul_add(b.weight, sum);
    let sum = c.shares(simd, shares).mul_add(c.weight, sum);
    columns(d.shares(simd, shares).mul_add(d.weight, sum))
}

/// Σ w cosφ' ρ_k p_k(φ') in rad⁻¹, and Σ w ρ_k, at four wavelengths.
#[inline(always)]
pub(super) fn density<S: Simd>(simd: S, table: &Table, simplices: &Simplices<S>) -> [f32x4<S>; 2] {
    let Simplices { roles: [a, b, c, d], tau, .. } = simplices;
    let ([a, all_a], [b, all_b]) = (a.density(simd, table, *tau), b.density(simd, table, *tau));
    let ([c, all_c], [d, all_d]) = (c.density(simd, table, *tau), d.density(simd, table, *tau));
    let [first, second, ..] = columns((a + b) + (c + d));
    let [.., third, fourth] = columns((all_a + all_b) + (all_c + all_d));
    [first + second, third + fourth]
}

impl<S: Simd> Role<S> {
    /// Weighted densities in the first two lanes of each wavelength; weighted shares, reflected fractions in the last two.
    #[inline(always)]
    fn density(&self, simd: S, table: &Table, tau: f32x16<S>) -> [f32x16<S>; 2] {
        let Corner { level, square, drawn, .. } = self.corner;
        let (m2, rest) = (self.part(simd, table, M2), self.part(simd, table, REST));
        let middle = self.part(simd, table, MIDDLE);
        let shares = self.weight * self.shares(simd, &table.shares);
        let away = tau - middle;
        let q = (rest * level).mul_add(away * away, m2);
        [shares * (tau.mul_add(middle, square) * drawn) / (q * q), shares]
    }

    #[inline(always)]
    fn shares(&self, simd: S, shares: &[Shares]) -> f32x16<S> {
        let [a, b, c, d] = self.at;
        let (a, b) = (&shares[a as usize].0, &shares[b as usize].0);
        let (c, d) = (&shares[c as usize].0, &shares[d as usize].0);
        let low: f32x8<S> = f32x4::from_slice(simd, a).combine(f32x4::from_slice(simd, b));
        low.combine(f32x4::from_slice(simd, c).combine(f32x4::from_slice(simd, d)))
    }
}

/// exp(−u) for u ≥ 0, relative error 3e-7; zero from [`END`] on.
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
    u.simd_gt(f32x4::splat(simd, END as f32)).select(zero, series * bits.bitcast::<f32x4<S>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::simd::{Width, dispatch_large};

    /// The estimate has an error of 1.5 · 2⁻¹² at most, its square is 1.3e-7; the rest is rounding.
    #[test]
    fn reciprocals_are_right_to_rounding_at_every_width() {
        for width in Width::available() {
            for power in -30..30 {
                let x: [f32; 16] = std::array::from_fn(|k| (1.0 + k as f32 / 16.1) * 10.0_f32.powi(power));
                let found: [f32; 16] =
                    dispatch_large!(width.0, simd => inverse(simd, f32x16::from_slice(simd, &x)).into());
                for (x, found) in x.into_iter().zip(found) {
                    let error = (f64::from(x) * f64::from(found) - 1.0).abs();
                    assert!(error < 3e-7, "{} 1/{x}: {found}, {error}", width.name());
                }
            }
        }
    }
}
