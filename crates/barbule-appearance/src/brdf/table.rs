//! A material's parameters on a fine regular grid, ready for lookup.
//!
//! At load every array is extended to grazing (linearly from the two lowest nodes), interpolated by monotone cubics
//! onto a regular grid in (cosθ_i, cosφ_i) at half the spacing of the stored nodes, and looked up bilinearly there,
//! linearly in λ. φ_eff is kept as sinφ_eff/sinφ_i, which is even and smooth at normal incidence, where φ_i itself has
//! an infinite slope against cosφ_i.

use fearless_simd::{Simd, f32x4, f32x8, i32x4, prelude::*};
use glam::DVec3;
use rayon::prelude::*;

use super::integral::{Fine, Rough};
use super::material::{FeatherMaterial, LobeSet, ParameterSet};
use crate::scattering::far_field::Polarization;
use crate::scattering::lobe::SMALLEST_M;

/// Columns of a node, twice: of the mean lobe and, from [`STATIONARY`] on, of the stationary one.
pub(super) const WIDTH: usize = 8;
/// Roughness.
pub(super) const M: usize = 0;
/// sinφ_eff/sinφ_i.
pub(super) const TILT: usize = 1;
/// ρ (z·ω_eff)/J, smooth up to grazing; J and ρ themselves are not needed apart.
pub(super) const STRENGTH: usize = 2;
/// 1/l in the first half.
pub(super) const INVERSE_LENGTH: usize = 3;
/// Where the stationary lobe's columns begin.
pub(super) const STATIONARY: usize = 4;

/// |sinφ_eff| never exceeds this, so that ω_eff stays above the horizon.
pub(super) const LARGEST_SINE: f32 = 0.9998;

/// A cell's four corners at one wavelength: two cache lines that are read together. Nodes are stored up to four times,
/// which costs memory (10 MB for a full material) and halves the lines that an evaluation touches.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Patch([[f32; WIDTH]; 4]);

/// Lookup table of one parameter set.
#[derive(Debug, Clone)]
pub(super) struct Table {
    /// Shape `[θ cell, φ cell, λ]`.
    patches: Vec<Patch>,
    wavelengths_nm: Vec<f32>,
    /// The same unrounded.
    nodes_nm: Vec<f64>,
    /// 1/spacing where the wavelengths are evenly spaced.
    inverse_spacing: Option<f32>,
    theta_cells: usize,
    phi_cells: usize,
}

/// Where a wavelength falls: lower index and weight of the upper one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    index: usize,
    weight: f32,
}

/// A cell: its first patch and the weights of its corners.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    first: usize,
    weights: [f32; 4],
}

impl Table {
    /// Prepares one set; `polarization` scales ρ by the share of one incident polarization.
    pub(super) fn new(
        material: &FeatherMaterial,
        set: &ParameterSet,
        sigma: f64,
        polarization: Option<Polarization>,
    ) -> Self {
        let axes = &material.axes;
        let theta = Axis::new(axes.cos_theta());
        let phi = Axis::new(axes.cos_phi());
        let (phis, waves) = (phi.cells + 1, axes.wavelengths_nm().len());
        let (fine, rough) = (Fine::new(), Rough::new());
        let layers: Vec<Vec<[f32; WIDTH]>> = (0..waves)
            .into_par_iter()
            .map(|wave| {
                let nodes = axes.cos_theta().len() * axes.cos_phi().len();
                let range = wave * nodes..(wave + 1) * nodes;
                let layer = Layer { theta: &theta, phi: &phi, range, sigma, fine: &fine, rough: &rough };
                layer.parameters(set, polarization)
            })
            .collect();
        let mut patches = Vec::with_capacity(theta.cells * phi.cells * waves.max(2));
        for t in 0..theta.cells {
            for p in 0..phi.cells {
                let first = t * phis + p;
                let corners = [first, first + 1, first + phis, first + phis + 1];
                // One wavelength alone is its own neighbour.
                let again = layers.iter().filter(|_| waves == 1);
                patches.extend(layers.iter().chain(again).map(|layer| Patch(corners.map(|at| layer[at]))));
            }
        }
        let wavelengths_nm: Vec<f32> = axes.wavelengths_nm().iter().map(|&w| w as f32).collect();
        let spacing =
            (axes.wavelengths_nm()[waves - 1] - axes.wavelengths_nm()[0]) / (waves.max(2) - 1) as f64;
        let even = waves > 1
            && axes
                .wavelengths_nm()
                .iter()
                .enumerate()
                .all(|(k, w)| (axes.wavelengths_nm()[0] + k as f64 * spacing - w).abs() < 1e-4 * spacing);
        Self {
            patches,
            wavelengths_nm,
            nodes_nm: axes.wavelengths_nm().to_vec(),
            inverse_spacing: even.then_some((1.0 / spacing) as f32),
            theta_cells: theta.cells,
            phi_cells: phi.cells,
        }
    }

    /// Beyond the ends the end values hold.
    #[inline]
    pub(super) fn place(&self, wavelength_nm: f32) -> Place {
        let waves = &self.wavelengths_nm;
        if waves.len() == 1 {
            return Place { index: 0, weight: 0.0 };
        }
        let last = waves.len() - 2;
        match self.inverse_spacing {
            Some(inverse) => {
                let position = ((wavelength_nm - waves[0]) * inverse).clamp(0.0, (last + 1) as f32);
                let index = (position as usize).min(last);
                Place { index, weight: position - index as f32 }
            }
            None => {
                let index = waves.partition_point(|w| *w <= wavelength_nm).clamp(1, last + 1) - 1;
                let weight = (wavelength_nm - waves[index]) / (waves[index + 1] - waves[index]);
                Place { index, weight: weight.clamp(0.0, 1.0) }
            }
        }
    }

    /// [`place`](Self::place) of four wavelengths: indices and weights.
    #[inline(always)]
    pub(super) fn places<S: Simd>(&self, simd: S, wavelengths_nm: [f32; 4]) -> ([usize; 4], [f32; 4]) {
        let waves = &self.wavelengths_nm;
        if let (Some(inverse), [first, _, ..]) = (self.inverse_spacing, &waves[..]) {
            let last = waves.len() - 2;
            let position = (f32x4::from_slice(simd, &wavelengths_nm) - *first) * inverse;
            let position = position.min((last + 1) as f32).max(0.0);
            let whole = position.floor().min(last as f32);
            let weight: [f32; 4] = (position - whole).into();
            let index = whole.to_int::<i32x4<S>>();
            return (
                [
                    at_most(index[0], last),
                    at_most(index[1], last),
                    at_most(index[2], last),
                    at_most(index[3], last),
                ],
                weight,
            );
        }
        let (mut index, mut weight) = ([0; 4], [0.0; 4]);
        for lane in 0..4 {
            let place = self.place(wavelengths_nm[lane]);
            (index[lane], weight[lane]) = (place.index, place.weight);
        }
        (index, weight)
    }

    /// The cell of an incident direction with these cosines.
    #[inline(always)]
    pub(super) fn cell<S: Simd>(&self, simd: S, cos_theta: f32, cos_phi: f32) -> Cell {
        let cells = [self.theta_cells as f32, self.phi_cells as f32, 1.0, 1.0];
        let position = f32x4::simd_from(simd, [cos_theta, cos_phi, 0.0, 0.0]).min(1.0).max(0.0)
            * f32x4::simd_from(simd, cells);
        let whole = position.floor().min(f32x4::simd_from(simd, cells) - 1.0);
        let index = whole.to_int::<i32x4<S>>();
        let rest = position - whole;
        let (t, p) = (at_most(index[0], self.theta_cells - 1), at_most(index[1], self.phi_cells - 1));
        let (wt, wp) = (rest[0], rest[1]);
        Cell {
            first: (t * self.phi_cells + p) * self.wavelengths_nm.len().max(2),
            weights: [(1.0 - wt) * (1.0 - wp), (1.0 - wt) * wp, wt * (1.0 - wp), wt * wp],
        }
    }

    /// All parameters there, at a wavelength's index and the weight of the next.
    #[inline(always)]
    pub(super) fn lookup<S: Simd>(&self, simd: S, cell: &Cell, index: usize, weight: f32) -> f32x8<S> {
        let at = cell.first + index;
        let [low, high] = &self.patches[at..at + 2] else { return f32x8::splat(simd, 0.0) };
        let [a, b, c, d] = cell.weights;
        let low = mixed(simd, low, [a, b, c, d]);
        let high = mixed(simd, high, [a, b, c, d]);
        low + (high - low) * weight
    }

    /// All parameters at a wavelength and incident direction, in double precision.
    pub(super) fn exact(&self, wavelength_nm: f64, cos_theta: f64, cos_phi: f64) -> [f64; WIDTH] {
        let place = |cosine: f64, cells: usize| {
            let position = cosine.clamp(0.0, 1.0) * cells as f64;
            let cell = position.floor().min(cells as f64 - 1.0);
            (cell as usize, position - cell)
        };
        let ((t, wt), (p, wp)) = (place(cos_theta, self.theta_cells), place(cos_phi, self.phi_cells));
        let corners = [(1.0 - wt) * (1.0 - wp), (1.0 - wt) * wp, wt * (1.0 - wp), wt * wp];
        let nm = &self.nodes_nm;
        // One wavelength alone is stored twice.
        let (wave, weight) = if nm.len() == 1 {
            (0, 0.0)
        } else {
            let wave = nm.partition_point(|w| *w <= wavelength_nm).clamp(1, nm.len() - 1) - 1;
            (wave, ((wavelength_nm - nm[wave]) / (nm[wave + 1] - nm[wave])).clamp(0.0, 1.0))
        };
        let at = (t * self.phi_cells + p) * nm.len().max(2) + wave;
        let mix = |patch: &Patch, k: usize| -> f64 {
            patch.0.iter().zip(corners).map(|(corner, w)| w * f64::from(corner[k])).sum()
        };
        let [low, high] = [&self.patches[at], &self.patches[at + 1]];
        std::array::from_fn(|k| (1.0 - weight) * mix(low, k) + weight * mix(high, k))
    }
}

#[inline(always)]
fn mixed<S: Simd>(simd: S, patch: &Patch, [a, b, c, d]: [f32; 4]) -> f32x8<S> {
    let corners = &patch.0;
    let first = f32x8::from_slice(simd, &corners[1])
        .mul_add(f32x8::splat(simd, b), f32x8::from_slice(simd, &corners[0]) * a);
    let second = f32x8::from_slice(simd, &corners[3])
        .mul_add(f32x8::splat(simd, d), f32x8::from_slice(simd, &corners[2]) * c);
    first + second
}

/// An index bounded, whatever the conversion made of a number that is not one.
#[inline(always)]
fn at_most(index: i32, last: usize) -> usize {
    (index as u32 as usize).min(last)
}

/// One axis: the stored nodes, extended to 0 and 1, and the regular fine nodes.
struct Axis {
    /// Stored nodes with 0 in front and 1 behind where they are missing.
    nodes: Vec<f64>,
    prepended: bool,
    appended: bool,
    cells: usize,
}

impl Axis {
    fn new(stored: &[f64]) -> Self {
        let prepended = stored[0] > 1e-9;
        let appended = stored[stored.len() - 1] < 1.0 - 1e-9;
        let mut nodes = Vec::with_capacity(stored.len() + 2);
        if prepended {
            nodes.push(0.0);
        }
        nodes.extend_from_slice(stored);
        if appended {
            nodes.push(1.0);
        }
        // The coarsest regular grid that holds every node, then half its spacing; else a fine one that holds none.
        let holds = |n: usize| nodes.iter().all(|c| (c * n as f64 - (c * n as f64).round()).abs() < 1e-6);
        let coarse = (1..=64).find(|&n| holds(n));
        let cells = coarse.map_or(64, |n| n * 40_usize.div_ceil(n).max(1));
        Self { nodes, prepended, appended, cells }
    }

    /// The fine nodes at (or next to) the extended ones.
    fn places(&self) -> Vec<usize> {
        self.nodes.iter().map(|c| (c * self.cells as f64).round() as usize).collect()
    }

    /// Values at the extended nodes.
    fn extend(&self, stored: &[f64], low: f64, high: f64) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.nodes.len());
        if self.prepended {
            let extrapolated = match (stored, &self.nodes[..]) {
                ([a, b, ..], [_, x, y, ..]) => a - (b - a) * x / (y - x),
                _ => stored[0],
            };
            values.push(extrapolated.clamp(low, high));
        }
        values.extend_from_slice(stored);
        if self.appended {
            values.push(stored[stored.len() - 1]);
        }
        values
    }

    /// Monotone cubic (Fritsch and Butland's slopes) through the extended nodes, at the fine ones.
    fn refine(&self, values: &[f64]) -> Vec<f64> {
        let x = &self.nodes;
        let count = x.len();
        if count == 1 {
            return vec![values[0]; self.cells + 1];
        }
        let secant: Vec<f64> =
            (0..count - 1).map(|k| (values[k + 1] - values[k]) / (x[k + 1] - x[k])).collect();
        let slope: Vec<f64> = (0..count)
            .map(|k| {
                if k == 0 || k == count - 1 {
                    return end_slope(k == 0, x, &secant);
                }
                let (a, b) = (secant[k - 1], secant[k]);
                if a * b <= 0.0 {
                    return 0.0;
                }
                let (left, right) = (x[k] - x[k - 1], x[k + 1] - x[k]);
                let (wa, wb) = (2.0 * right + left, right + 2.0 * left);
                (wa + wb) / (wa / a + wb / b)
            })
            .collect();
        (0..=self.cells)
            .map(|k| {
                let at = k as f64 / self.cells as f64;
                let i = x.partition_point(|n| *n <= at + 1e-9).clamp(1, count - 1) - 1;
                let h = x[i + 1] - x[i];
                let t = ((at - x[i]) / h).clamp(0.0, 1.0);
                let (u, t2) = (1.0 - t, t * t);
                values[i] * u * u * (1.0 + 2.0 * t)
                    + values[i + 1] * t2 * (3.0 - 2.0 * t)
                    + h * t * u * (slope[i] * u - slope[i + 1] * t)
            })
            .collect()
    }
}

/// The three-point slope at an end, limited so that the piece stays monotone.
fn end_slope(first: bool, x: &[f64], secant: &[f64]) -> f64 {
    let last = secant.len() - 1;
    if last == 0 {
        return secant[0];
    }
    let (near, next, h, h_next) = if first {
        (secant[0], secant[1], x[1] - x[0], x[2] - x[1])
    } else {
        (secant[last], secant[last - 1], x[last + 1] - x[last], x[last] - x[last - 1])
    };
    let slope = ((2.0 * h + h_next) * near - h * next) / (h + h_next);
    if slope * near <= 0.0 {
        0.0
    } else if near * next <= 0.0 && slope.abs() > 3.0 * near.abs() {
        3.0 * near
    } else {
        slope
    }
}

/// One wavelength of one set on its way to the fine grid.
struct Layer<'a> {
    theta: &'a Axis,
    phi: &'a Axis,
    range: std::ops::Range<usize>,
    sigma: f64,
    fine: &'a Fine,
    rough: &'a Rough,
}

impl Layer<'_> {
    /// Parameters of all fine nodes, `[θ, φ]`.
    fn parameters(&self, set: &ParameterSet, polarization: Option<Polarization>) -> Vec<[f32; WIDTH]> {
        let count = (self.theta.cells + 1) * (self.phi.cells + 1);
        let mut out = vec![[0.0_f32; WIDTH]; count];
        let mut bright = Vec::new();
        let mut put = |column: usize, values: &[f64]| {
            for (node, value) in out.iter_mut().zip(values) {
                node[column] = *value as f32;
            }
        };
        for (lobe, fractions, base) in
            [(&set.mean, &set.fraction_1, 0), (&set.stationary, &set.stationary_fraction_1, STATIONARY)]
        {
            let ln_m = self.refine(&self.stored(&lobe.m, f64::ln), SMALLEST_M.ln(), 0.0, None);
            let m: Vec<f64> = ln_m.iter().map(|v| v.exp()).collect();
            let tilt = self.tilt(lobe);
            let mut reflected = self.refine(&self.stored(&lobe.reflected, |v| v), 0.0, 1.0, None);
            if let Some(polarization) = polarization.filter(|_| !fractions.is_empty()) {
                let first = self.refine(&self.stored(fractions, |v| v), 0.0, 1.0, None);
                for (rho, first) in reflected.iter_mut().zip(first) {
                    *rho *= 2.0 * if polarization == Polarization::First { first } else { 1.0 - first };
                }
            }
            put(base + M, &m);
            put(base + TILT, &tilt);
            put(base + STRENGTH, &self.strengths(&m, &tilt, &reflected));
            if base != STATIONARY {
                bright = reflected;
            }
        }
        put(INVERSE_LENGTH, &self.refine(&self.stored(&set.length, |v| 1.0 / v), 1.0 / 64.0, 64.0, None));
        self.limit(&mut out, &bright);
        out
    }

    /// Scales down the nodes of cells inside which interpolation would reflect more than all light. Next to grazing J
    /// bends within σ, which no table follows; only where ρ itself comes close to 1 does that matter.
    fn limit(&self, nodes: &mut [[f32; WIDTH]], reflected: &[f64]) {
        let phis = self.phi.cells + 1;
        let mut factors = vec![1.0_f64; nodes.len()];
        for t in 0..self.theta.cells {
            for p in 0..self.phi.cells {
                let corners = [t * phis + p, t * phis + p + 1, (t + 1) * phis + p, (t + 1) * phis + p + 1];
                if corners.iter().all(|&c| reflected[c] < BRIGHT) {
                    continue;
                }
                // The lowest cells bend most. A few points tell whether more are needed.
                let (few, many): (&[f64], &[f64]) = if t == 0 || p == 0 {
                    (
                        &[0.01, 0.1, 0.3, 0.7],
                        &[0.01, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.95],
                    )
                } else {
                    (&[0.1, 0.5, 0.9], &[0.1, 0.3, 0.5, 0.7, 0.9])
                };
                let largest = |inside: &[f64]| {
                    let mut largest = 0.0_f64;
                    for (x, y) in inside.iter().flat_map(|&x| inside.iter().map(move |&y| (x, y))) {
                        let weights = [(1.0 - x) * (1.0 - y), (1.0 - x) * y, x * (1.0 - y), x * y];
                        let mix = |column: usize| -> f64 {
                            corners.iter().zip(weights).map(|(&c, w)| w * f64::from(nodes[c][column])).sum()
                        };
                        let cos_theta = (t as f64 + x) / self.theta.cells as f64;
                        let cos_phi = (p as f64 + y) / self.phi.cells as f64;
                        let incident = effective(cos_theta, cos_phi, mix(TILT));
                        let integral = self.rough.scaled_integral(mix(M), incident, self.sigma);
                        largest = largest.max(mix(STRENGTH) * integral / incident.z);
                    }
                    largest
                };
                let largest = if largest(few) < NEARLY_ALL { 0.0 } else { largest(many) };
                // Between the points tried there may be slightly more.
                let largest = if largest > 1.0 { 1.01 * largest } else { 1.0 };
                for corner in corners {
                    factors[corner] = factors[corner].max(largest);
                }
            }
        }
        for (node, factor) in nodes.iter_mut().zip(factors) {
            node[STRENGTH] = (f64::from(node[STRENGTH]) / factor) as f32;
        }
    }

    /// A stored array of this wavelength, mapped.
    fn stored(&self, values: &[f32], map: fn(f64) -> f64) -> Vec<f64> {
        values[self.range.clone()].iter().map(|&v| map(f64::from(v))).collect()
    }

    /// A stored array `[θ, φ]` on the fine grid; `grazing` is the value at cosφ = 0, else extrapolated.
    fn refine(&self, stored: &[f64], low: f64, high: f64, grazing: Option<f64>) -> Vec<f64> {
        let rows: Vec<Vec<f64>> = stored
            .chunks_exact(stored.len() / self.stored_thetas())
            .map(|row| {
                let mut extended = self.phi.extend(row, low, high);
                if let (true, Some(value)) = (self.phi.prepended, grazing) {
                    extended[0] = value;
                }
                self.phi.refine(&extended)
            })
            .collect();
        let (thetas, phis) = (self.theta.cells + 1, self.phi.cells + 1);
        let mut out = vec![0.0; thetas * phis];
        for p in 0..phis {
            let column: Vec<f64> = rows.iter().map(|row| row[p]).collect();
            let fine = self.theta.refine(&self.theta.extend(&column, low, high));
            for (t, value) in fine.into_iter().enumerate() {
                out[t * phis + p] = value.clamp(low, high);
            }
        }
        out
    }

    fn stored_thetas(&self) -> usize {
        self.theta.nodes.len() - usize::from(self.theta.prepended) - usize::from(self.theta.appended)
    }

    /// sinφ_eff/sinφ_i on the fine grid. At φ_i = 0 the ratio is extrapolated from the two nodes beside it; at grazing
    /// azimuth it is 1.
    fn tilt(&self, lobe: &LobeSet) -> Vec<f64> {
        let axis = self.phi;
        let skip = usize::from(axis.prepended);
        let end = axis.nodes.len() - usize::from(axis.appended);
        let cosines = &axis.nodes[skip..end];
        let ratios: Vec<f64> = lobe.phi[self.range.clone()]
            .chunks_exact(cosines.len())
            .flat_map(|row| {
                let mut ratio: Vec<f64> = row
                    .iter()
                    .zip(cosines)
                    .map(|(&phi, &c)| libm::sin(f64::from(phi)) / (1.0 - c * c).max(1e-12).sqrt())
                    .collect();
                if cosines[cosines.len() - 1] > 1.0 - 1e-9 {
                    let last = ratio.len() - 1;
                    ratio[last] = match ratio[..last] {
                        [.., a, b] => {
                            let (x, y) = (cosines[last - 2], cosines[last - 1]);
                            b + (b - a) * (1.0 - y) / (y - x)
                        }
                        [a] => a,
                        [] => 1.0,
                    };
                }
                ratio
            })
            .collect();
        self.refine(&ratios, -LARGEST_TILT, LARGEST_TILT, Some(1.0))
    }

    /// ρ (z·ω_eff)/J on the fine grid: exact at the stored nodes and at cos = 0, between them interpolated.
    fn strengths(&self, m: &[f64], tilt: &[f64], reflected: &[f64]) -> Vec<f64> {
        let (thetas, phis) = (self.theta.cells + 1, self.phi.cells + 1);
        let exact = |t: usize, p: usize| {
            let at = t * phis + p;
            if reflected[at] == 0.0 {
                return 0.0;
            }
            let cos_theta = (t as f64 / self.theta.cells as f64).max(GRAZING);
            let cos_phi = (p as f64 / self.phi.cells as f64).max(GRAZING);
            let incident = effective(cos_theta, cos_phi, tilt[at]);
            let integral = self.fine.scaled_integral(m[at], incident, self.sigma);
            reflected[at] * incident.z / integral.max(SMALLEST_INTEGRAL)
        };
        let (rows, columns) = (self.theta.places(), self.phi.places());
        let fine_rows: Vec<Vec<f64>> = rows
            .iter()
            .map(|&t| self.phi.refine(&columns.iter().map(|&p| exact(t, p)).collect::<Vec<_>>()))
            .collect();
        let mut out = vec![0.0; thetas * phis];
        for p in 0..phis {
            let column: Vec<f64> = fine_rows.iter().map(|row| row[p]).collect();
            for (t, value) in self.theta.refine(&column).into_iter().enumerate() {
                out[t * phis + p] = value.max(0.0);
            }
        }
        out
    }
}

/// Cells whose corners all reflect less than this cannot exceed 1 inside.
const BRIGHT: f64 = 0.8;

/// Cells that reflect less than this at a few points do not exceed 1 anywhere.
const NEARLY_ALL: f64 = 0.93;

/// Bound of sinφ_eff/sinφ_i, met only where noise in a fit is divided by a small sinφ_i.
const LARGEST_TILT: f64 = 10.0;

/// Nodes at cos = 0 are evaluated this far above the horizon.
const GRAZING: f64 = 1e-3;

/// A smaller J could only come from rounding.
const SMALLEST_INTEGRAL: f64 = 1e-7;

/// ω_eff of a positive (θ_i, φ_i) with this sinφ_eff/sinφ_i.
pub(super) fn effective(cos_theta: f64, cos_phi: f64, tilt: f64) -> DVec3 {
    let sine = (tilt * (1.0 - cos_phi * cos_phi).max(0.0).sqrt())
        .clamp(-f64::from(LARGEST_SINE), f64::from(LARGEST_SINE));
    let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
    DVec3::new(cos_theta * sine, sin_theta, cos_theta * (1.0 - sine * sine).sqrt())
}
