//! Local reflection by a photonic crystal: at each point of the top, the currents that the ideal flat crystal would carry
//! whose normal is the top's there.
//!
//! With t the tangent, y the barbule's axis and n the outward normal, light from ω_i has the azimuth φ = φ_i + slope in
//! the frame (t, y, n) and the same θ_i; e₁, e₂ are the same vectors in either frame, since both turn about y. Order m
//! leaves along φ_m with E = a e₁ + b e₂, (a, b) = J_m's column, so H̃ = −a e₂ + b e₁ and
//!
//! ```text
//! J =  n × H̃ = −b cosθ t + (b sinθ sinφ_m − a cosφ_m) y
//! M = −n × E =  a cosθ t − (a sinθ sinφ_m + b cosφ_m) y
//! ```
//!
//! times e^{2πjm s/Δ} for the place s of the point in the lattice.

use std::f64::consts::FRAC_PI_2;

use fearless_simd::prelude::*;

use super::super::crystal::{Cell, Multipole, order_series_between, order_table};
use super::reflection::{BLOCK, COMPONENTS, Currents, Lit};
use crate::Result;
use crate::math::simd::{Complex, Real, load, sin_cos, splat};
use crate::progress::Progress;
use crate::scattering::orders::{JONES, OrderSeries, OrderTable};
use crate::structure::Lattice;

/// Azimuths at which orders are tabulated for linear interpolation, per µm of the crystal's depth, and at least: then
/// the interpolation is off by less than 3e-5 in single precision, 2e-6 in double.
const NODES: [(f64, f64); 2] = [(4096.0, 4096.0), (16384.0, 16384.0)];

/// More than the distance of two nodes, rad.
const BETWEEN_NODES: f64 = 1e-3;

/// Never more than this.
const MOST_NODES: f64 = 262_144.0;

/// The solver of the crystals under barbules.
pub(in crate::solve) fn solver() -> Multipole {
    Multipole::default()
}

/// The orders of a crystal under barbules at vacuum wavelengths (nm) and cosθ_i.
///
/// # Errors
/// The crystal cannot be solved, or the user cancelled.
pub fn orders(
    lattice: &Lattice,
    wavelengths_nm: &[f64],
    cos_theta: &[f64],
    progress: &dyn Progress,
) -> Result<OrderTable> {
    order_table(&solver(), lattice, wavelengths_nm, cos_theta, progress)
}

/// The orders of a crystal at one vacuum wavelength (nm) and θ_i (rad), for azimuths from `phi[0]` to `phi[1]` (rad).
///
/// # Errors
/// The crystal cannot be solved, or the user cancelled.
pub(in crate::solve) fn series(
    lattice: &Lattice,
    wavelength_nm: f64,
    theta_i: f64,
    phi: [f64; 2],
    progress: &dyn Progress,
) -> Result<OrderSeries> {
    let cell = Cell::new(lattice, wavelength_nm)?;
    // Interpolation reads the nodes on either side.
    let [from, to] = phi.map(|phi| phi.clamp(-FRAC_PI_2, FRAC_PI_2));
    let sines = [(from - BETWEEN_NODES).max(-FRAC_PI_2).sin(), (to + BETWEEN_NODES).min(FRAC_PI_2).sin()];
    order_series_between(&solver(), &cell, wavelength_nm, theta_i, sines, progress)
}

/// The orders of a crystal at one wavelength and one θ_i, tabulated over the azimuth.
pub(in crate::solve) struct CrystalOrders<T> {
    sin_theta: f64,
    cos_theta: f64,
    /// λ/(Δ cosθ_i)
    step: f64,
    /// Steps of the azimuth over [−90°, 90°].
    steps: usize,
    orders: Vec<Tabulated<T>>,
}

/// One order.
struct Tabulated<T> {
    m: i32,
    /// Node of the first row.
    first: usize,
    /// Jones matrices at nodes from there on; the order does not propagate elsewhere.
    rows: Vec<[T; JONES]>,
}

impl<T: Real> CrystalOrders<T> {
    /// Tabulates a series for a crystal that is `depth_um` deep.
    pub(in crate::solve) fn new(series: &OrderSeries, theta_i: f64, depth_um: f64) -> Self {
        let (per_um, least) = NODES[usize::from(size_of::<T>() == 8)];
        let steps = (per_um * depth_um).clamp(least, MOST_NODES) as usize;
        let (sin_theta, cos_theta) = theta_i.sin_cos();
        let mut orders: Vec<Tabulated<T>> = Vec::new();
        let mut found = Vec::new();
        let none = [T::of(0.0); JONES];
        for node in 0..=steps {
            found.clear();
            let phi = std::f64::consts::PI * (node as f64 / steps as f64 - 0.5);
            series.evaluate(phi, &mut found);
            for (m, jones) in &found {
                let at = orders.iter().position(|order| order.m == *m).unwrap_or_else(|| {
                    orders.push(Tabulated { m: *m, first: node, rows: Vec::new() });
                    orders.len() - 1
                });
                let order = &mut orders[at];
                // An order may come, go, and come again where two of its Rayleigh angles meet.
                order.rows.resize(node - order.first, none);
                let [a, b, c, d] = [jones[0][0], jones[0][1], jones[1][0], jones[1][1]];
                order.rows.push([a.re, a.im, b.re, b.im, c.re, c.im, d.re, d.im].map(T::of));
            }
        }
        Self { sin_theta, cos_theta, step: series.step, steps, orders }
    }

    /// Bytes that the rows take.
    pub(super) fn bytes(&self) -> usize {
        self.orders.iter().map(|order| size_of_val(&order.rows[..])).sum()
    }
}

impl CrystalOrders<f64> {
    /// Calls `with` for each order that may propagate for light from an azimuth, with its number, λ/(Δ cosθ_i) and its
    /// Jones matrix: J₁₁, J₁₂, J₂₁, J₂₂, each re, im.
    pub(in crate::solve) fn each(&self, phi_i: f64, mut with: impl FnMut(i32, f64, [f64; JONES])) {
        let at = (self.steps as f64 * (phi_i / std::f64::consts::PI + 0.5)).clamp(0.0, self.steps as f64);
        let (node, part) = (at as usize, at.fract());
        for order in &self.orders {
            let mut jones = [0.0; JONES];
            let mut any = false;
            for (row, weight) in order.pair(node).into_iter().zip([1.0 - part, part]) {
                any |= row.is_some();
                for (sum, value) in jones.iter_mut().zip(row.unwrap_or(&[0.0; JONES])) {
                    *sum += weight * value;
                }
            }
            if any {
                with(order.m, self.step, jones);
            }
        }
    }
}

impl<T> Tabulated<T> {
    /// The rows at a node and the next one; `None` stands for zero.
    #[inline(always)]
    fn pair(&self, node: usize) -> [Option<&[T; JONES]>; 2] {
        let row = |node: usize| node.checked_sub(self.first).and_then(|at| self.rows.get(at));
        [row(node), row(node + 1)]
    }
}

/// One order's matrices around each point of a block.
struct Near<T> {
    m: i32,
    /// At the nodes on either side, `[side][element][point]`.
    sides: [[[T; BLOCK]; JONES]; 2],
    /// The part of a step from the first side at which each point's azimuth lies.
    part: [T; BLOCK],
}

impl<T: Real> CrystalOrders<T> {
    /// The currents g·J·dl and g·M·dl of the points `start` … `start + BLOCK`, for both incident polarizations, times the
    /// phase of the rise towards where each point sends an order.
    #[inline(always)]
    pub(super) fn reflect_block<S: Simd>(
        &self,
        simd: S,
        lit: &Lit<'_, T>,
        start: usize,
        out: &mut Currents<T>,
    ) {
        let lanes = T::Native::<S>::LEN;
        let zero = T::of(0.0);
        for row in out.iter_mut() {
            row.fill(zero);
        }
        let mut whole = [zero; BLOCK];
        let mut near = Near { m: 0, sides: [[[zero; BLOCK]; JONES]; 2], part: [zero; BLOCK] };
        let per_rad = self.steps as f64 / std::f64::consts::PI;
        for offset in (0..BLOCK).step_by(lanes) {
            let slope: T::Native<S> = load(simd, &lit.arrays.slope, start + offset);
            let from_left = slope + splat::<S, T::Native<S>>(simd, lit.incidence.phi + FRAC_PI_2);
            let at = (from_left * splat::<S, T::Native<S>>(simd, per_rad))
                .max(splat::<S, T::Native<S>>(simd, 0.0))
                .min(splat::<S, T::Native<S>>(simd, self.steps as f64));
            let floor = at.floor();
            floor.store_slice(&mut whole[offset..offset + lanes]);
            (at - floor).store_slice(&mut near.part[offset..offset + lanes]);
        }
        for order in &self.orders {
            let mut any = false;
            for (p, node) in whole.iter().enumerate() {
                for (side, row) in order.pair(node.index()).into_iter().enumerate() {
                    any |= row.is_some();
                    for c in 0..JONES {
                        near.sides[side][c][p] = row.map_or(zero, |row| row[c]);
                    }
                }
            }
            if any {
                near.m = order.m;
                self.add(simd, lit, start, &near, out);
            }
        }
    }

    /// Adds the currents of one order.
    #[inline(always)]
    fn add<S: Simd>(&self, simd: S, lit: &Lit<'_, T>, start: usize, near: &Near<T>, out: &mut Currents<T>) {
        let Lit { arrays, rise_um, k, incidence } = *lit;
        let lanes = T::Native::<S>::LEN;
        let zero: T::Native<S> = splat(simd, 0.0);
        let one: T::Native<S> = splat(simd, 1.0);
        let sin_phi: T::Native<S> = splat(simd, incidence.sin_phi());
        let cos_phi: T::Native<S> = splat(simd, incidence.cos_phi());
        let sin_theta: T::Native<S> = splat(simd, self.sin_theta);
        let cos_theta: T::Native<S> = splat(simd, self.cos_theta);
        let backward: T::Native<S> = splat(simd, -k * self.cos_theta);
        let shift: T::Native<S> = splat(simd, f64::from(near.m) * self.step);
        let turn: T::Native<S> = splat(simd, f64::from(near.m) * std::f64::consts::TAU);
        for offset in (0..BLOCK).step_by(lanes) {
            let at = start + offset;
            let tangent_x: T::Native<S> = load(simd, &arrays.tangent_x, at);
            let tangent_z: T::Native<S> = load(simd, &arrays.tangent_z, at);
            let sin_i = tangent_x * sin_phi + tangent_z * cos_phi;
            let cos_i = tangent_x * cos_phi - tangent_z * sin_phi;
            let sin_o = (shift - sin_i).max(-one).min(one);
            let cos_o = if near.m == 0 { cos_i } else { (one - sin_o * sin_o).max(zero).sqrt() };
            let x: T::Native<S> = load(simd, &arrays.x_um, at);
            let z: T::Native<S> = load(simd, &arrays.z_um, at);
            let rise: T::Native<S> = load(simd, rise_um, at);
            let turns: T::Native<S> = load(simd, &arrays.lattice_turns, at);
            let upward = sin_o * tangent_z + cos_o * tangent_x;
            let path = x * sin_phi + z * cos_phi + rise * upward;
            let (sin, cos) = sin_cos::<S, T::Native<S>>(simd, path.mul_add(backward, turns * turn));
            let lit = cos_i.simd_gt(zero);
            let weight = lit.select(load(simd, &arrays.window_length_um, at), zero);
            let wave = Complex { re: cos * weight, im: sin * weight };
            let between: T::Native<S> = load(simd, &near.part, offset);
            let (first, second) = out.split_at_mut(COMPONENTS / 2);
            for (q, rows) in [first, second].into_iter().enumerate() {
                let a = element::<S, T>(simd, &near.sides, 2 * q, between, offset).times::<S>(wave);
                let b = element::<S, T>(simd, &near.sides, 4 + 2 * q, between, offset).times::<S>(wave);
                let tilted = sin_theta * sin_o;
                let j_t = b.scale::<S>(-cos_theta);
                let j_y = b.scale::<S>(tilted).minus::<S>(a.scale::<S>(cos_o));
                let m_t = a.scale::<S>(cos_theta);
                let m_y = a.scale::<S>(-tilted).minus::<S>(b.scale::<S>(cos_o));
                let vectors = [
                    j_t.scale::<S>(tangent_x),
                    j_y,
                    j_t.scale::<S>(tangent_z),
                    m_t.scale::<S>(tangent_x),
                    m_y,
                    m_t.scale::<S>(tangent_z),
                ];
                for (pair, value) in rows.chunks_exact_mut(2).zip(vectors) {
                    let (re, im) = pair.split_at_mut(1);
                    accumulate::<S, T>(simd, &mut re[0], offset, value.re);
                    accumulate::<S, T>(simd, &mut im[0], offset, value.im);
                }
            }
        }
    }
}

/// One element of the Jones matrices, whose real part is row `c`, interpolated.
#[inline(always)]
fn element<S: Simd, T: Real>(
    simd: S,
    sides: &[[[T; BLOCK]; JONES]; 2],
    c: usize,
    between: T::Native<S>,
    offset: usize,
) -> Complex<T::Native<S>> {
    let [re, im] = [c, c + 1].map(|c| {
        let low: T::Native<S> = load(simd, &sides[0][c], offset);
        let high: T::Native<S> = load(simd, &sides[1][c], offset);
        (high - low).mul_add(between, low)
    });
    Complex { re, im }
}

#[inline(always)]
fn accumulate<S: Simd, T: Real>(simd: S, row: &mut [T; BLOCK], offset: usize, value: T::Native<S>) {
    let sum = load::<S, T::Native<S>>(simd, row, offset) + value;
    sum.store_slice(&mut row[offset..offset + T::Native::<S>::LEN]);
}
