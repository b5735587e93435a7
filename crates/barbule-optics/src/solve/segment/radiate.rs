//! From currents to far fields over the hemisphere.

use fearless_simd::{dispatch, prelude::*};
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use super::layered::Room;
use super::{COMPONENTS, Currents, Hemisphere, Incidence, Reflector, SegmentAccuracy, SegmentLight};
use crate::math::dense::Factor;
use crate::math::fft::{Transformable, fast_length};
use crate::math::simd::{Width, sin_cos};
use crate::progress::Progress;
use crate::solve::surface::LANES;
use crate::structure::{Line, Roughness, Sampled, SegmentGrid};
use crate::{Error, Result};

/// Lines that are transformed together: a cache line of values.
const LINES: usize = 16;

/// Lines whose kernel is formed at a time.
const CHUNK: usize = 512;

/// Real numbers of both polarizations' currents at a point.
const VALUES: usize = 2 * 2 * COMPONENTS;

/// CPU seconds of a multiplication in matrix products, and of a value of their kernels with what is made of it. These and those of places and
/// crystals fit starlings of 8 and 25 µm, films, doves, hummingbirds and mallards from 400 to 600 nm.
const PRODUCT_S: f64 = 2.5e-11;
const KERNEL_S: f64 = 3e-8;

/// Standard deviations of the roughness that the interpolation over ω_z holds.
const HIGHEST: f64 = 5.0;

/// Where currents go.
struct Plan {
    k: f64,
    /// Spacing of ω_x and ω_y.
    step: [f64; 2],
    reach: usize,
    /// First and one past the last row, in steps from the mirror's.
    rows: std::ops::Range<i64>,
    mirror_y: f64,
    /// y of the first cell.
    first_um: f64,
    /// Points of the transforms along y.
    length: usize,
    /// Nodes of ω_z.
    nodes: Vec<f64>,
    held_bytes: usize,
}

impl Plan {
    fn new(
        grid: &SegmentGrid,
        roughness: Roughness,
        light: &SegmentLight,
        accuracy: &SegmentAccuracy,
    ) -> Result<Self> {
        let wavelength_um = light.wavelength_nm * 1e-3;
        let k = std::f64::consts::TAU / wavelength_um;
        let length = fast_length(grid.cells[1].max(2));
        let step = [
            wavelength_um / (grid.cells[0] as f64 * grid.step_um[0]),
            wavelength_um / (length as f64 * grid.step_um[1]),
        ];
        let mirror_y = -light.theta_i.sin();
        let rows =
            ((-1.0 - mirror_y) / step[1]).ceil() as i64..((1.0 - mirror_y) / step[1]).floor() as i64 + 1;
        let most = (rows.end - rows.start) as usize;
        if most > length {
            return Err(Error::input(format!(
                "cells of {:.4} µm along y are too long for a wavelength of {} nm; make them shorter than half of it",
                grid.step_um[1], light.wavelength_nm
            )));
        }
        // e^{jat} on −1 ≤ t ≤ 1 from n Chebyshev nodes is off by less than 4(a/2)ⁿ/n!.
        let a = 0.5 * k * HIGHEST * roughness.amplitude_um;
        let (mut count, mut error) = (1, if a > 0.0 { 2.0 * a } else { 0.0 });
        while error > accuracy.interpolation {
            count += 1;
            error *= 0.5 * a / count as f64;
        }
        let turn = |node: usize| std::f64::consts::PI * (node as f64 + 0.5) / count as f64;
        Ok(Self {
            k,
            step,
            reach: (1.0 / step[0]).floor() as usize,
            rows,
            mirror_y,
            first_um: grid.centre_um(1, 0),
            length,
            nodes: (0..count).map(|node| 0.5 + 0.5 * turn(node).cos()).collect(),
            held_bytes: accuracy.held_bytes,
        })
    }

    /// Real numbers of a line at one ω_y.
    fn columns(&self) -> usize {
        VALUES * self.nodes.len()
    }

    fn omega_y(&self, row: i64) -> f64 {
        self.mirror_y + row as f64 * self.step[1]
    }

    fn directions(&self) -> usize {
        2 * self.reach + 1
    }

    /// Rows of a pass.
    fn at_once(&self, lines: usize) -> usize {
        (self.held_bytes / (4 * self.columns() * lines.next_multiple_of(LINES))).max(1)
    }

    /// Multiplications of the matrix products, and values of their kernels.
    fn operations(&self, lines: usize) -> [f64; 2] {
        // Of each row so many directions are above the horizon.
        let directions = std::f64::consts::FRAC_PI_4 * self.directions() as f64;
        let kernels = (self.rows.end - self.rows.start) as f64 * directions * lines as f64;
        [2.0 * kernels * self.columns() as f64, kernels]
    }

    /// Memory on so many threads.
    fn bytes(&self, grid: &SegmentGrid, threads: usize) -> u64 {
        let lines = grid.cells[0].next_multiple_of(LINES);
        let rows = (self.rows.end - self.rows.start) as usize;
        let held = rows.min(self.at_once(lines)) * self.columns() * lines * 4;
        let results = rows * self.directions() * 2 * size_of::<[Complex32; 2]>();
        let line = self.length * 8 + 16 * grid.cells[1] * (VALUES + 40) + rows * self.columns() * LINES * 4;
        let kernel = 4 * (2 * self.directions() * (CHUNK + self.columns()) + self.columns() * lines);
        (held + results + threads * line.max(kernel)) as u64
    }
}

/// Memory that a far field takes on so many threads, bytes, and CPU seconds of radiating.
///
/// # Errors
/// Cells are too long for the wavelength.
pub(super) fn cost(
    grid: &SegmentGrid,
    roughness: Roughness,
    light: &SegmentLight,
    accuracy: &SegmentAccuracy,
    threads: usize,
) -> Result<(u64, f64)> {
    let plan = Plan::new(grid, roughness, light, accuracy)?;
    let [products, kernels] = plan.operations(grid.cells[0]);
    Ok((plan.bytes(grid, threads), products * PRODUCT_S + kernels * KERNEL_S))
}

pub(super) fn radiate(
    sampled: &Sampled<'_>,
    reflector: &Reflector<'_>,
    incidence: &Incidence,
    light: &SegmentLight,
    accuracy: &SegmentAccuracy,
    progress: &dyn Progress,
) -> Result<Hemisphere> {
    let grid = &sampled.grid;
    let plan = Plan::new(grid, sampled.roughness(), light, accuracy)?;
    let rows = (plan.rows.end - plan.rows.start) as usize;
    let (lines, at_once) = (grid.cells[0].next_multiple_of(LINES), plan.at_once(grid.cells[0]));
    let passes = rows.div_ceil(at_once);
    progress.begin("segment", ((lines / LINES) * passes + rows) as u64);
    let width = plan.directions();
    let mut out = Hemisphere {
        step: plan.step,
        reach: plan.reach,
        omega_y: plan.rows.clone().map(|row| plan.omega_y(row)).collect(),
        amplitudes: [(); 2].map(|()| vec![[Complex32::ZERO; 2]; rows * width]),
        incident_um2: 0.0,
    };
    let line_of = |column: usize| {
        let mut line = Line::default();
        sampled.line(column, &mut line);
        (line.x_um, line.z_um)
    };
    let places: Vec<(f64, f64)> = (0..grid.cells[0]).into_par_iter().map(line_of).collect();
    let mut held = vec![0f32; lines * at_once.min(rows) * plan.columns()];
    for first in (0..rows).step_by(at_once) {
        let count = at_once.min(rows - first);
        let from = plan.rows.start + first as i64;
        let held = &mut held[..lines * count * plan.columns()];
        let transformer =
            Transformer { plan: &plan, sampled, reflector, incidence, rows: from..from + count as i64 };
        out.incident_um2 = transformer.fill(held, progress)?;
        let [a, b] = &mut out.amplitudes;
        a[first * width..(first + count) * width]
            .par_chunks_exact_mut(width)
            .zip(b[first * width..(first + count) * width].par_chunks_exact_mut(width))
            .enumerate()
            .try_for_each_init(RowRoom::default, |room, (index, (a, b))| {
                if progress.is_cancelled() {
                    return Err(Error::interrupted());
                }
                let row = RowOf {
                    plan: &plan,
                    places: &places,
                    turn: light.turn,
                    width: accuracy.width,
                    held,
                    count,
                    index,
                };
                row.radiate(plan.omega_y(from + index as i64), room, [a, b]);
                progress.advance(1);
                Ok(())
            })?;
    }
    Ok(out)
}

/// Makes the transforms along y of all lines' currents for some rows of directions.
struct Transformer<'a> {
    plan: &'a Plan,
    sampled: &'a Sampled<'a>,
    reflector: &'a Reflector<'a>,
    incidence: &'a Incidence,
    rows: std::ops::Range<i64>,
}

impl Transformer<'_> {
    /// Fills `held`, shape `[lines/16][row][node][polarization][component][re, im][16]`, and returns the incident power, µm².
    fn fill(&self, held: &mut [f32], progress: &dyn Progress) -> Result<f64> {
        let grid = &self.sampled.grid;
        let transform = f32::forward(self.plan.length);
        let block = (self.rows.end - self.rows.start) as usize * self.plan.columns() * LINES;
        let powers: Vec<f64> = held
            .par_chunks_exact_mut(block)
            .enumerate()
            .map_init(
                || {
                    let mut currents = Currents::default();
                    for row in currents.iter_mut().flatten() {
                        row.resize(grid.cells[1], Complex64::ZERO);
                    }
                    let buffer = vec![Complex32::ZERO; self.plan.length];
                    (
                        Line::default(),
                        Room::default(),
                        currents,
                        buffer,
                        vec![Complex32::ZERO; transform.scratch_len()],
                    )
                },
                |(line, room, currents, buffer, scratch), (number, out)| {
                    if progress.is_cancelled() {
                        return Err(Error::interrupted());
                    }
                    let mut power = 0.0;
                    out.fill(0.0);
                    for lane in 0..LINES.min(grid.cells[0].saturating_sub(number * LINES)) {
                        self.sampled.line(number * LINES + lane, line);
                        power += self.reflector.currents(self.incidence, line, room, currents);
                        for (node, &height) in self.plan.nodes.iter().enumerate() {
                            let turns: Vec<Complex64> = line
                                .rise_um
                                .iter()
                                .map(|rise| {
                                    Complex64::from_polar(1.0, -self.plan.k * height * f64::from(*rise))
                                })
                                .collect();
                            for (component, values) in currents.iter().flatten().enumerate() {
                                for (to, (value, turn)) in buffer.iter_mut().zip(values.iter().zip(&turns)) {
                                    let turned = value * turn;
                                    *to = Complex32::new(turned.re as f32, turned.im as f32);
                                }
                                buffer[grid.cells[1]..].fill(Complex32::ZERO);
                                transform.process(buffer, scratch);
                                self.scatter(buffer, VALUES * node + 2 * component, lane, out);
                            }
                        }
                    }
                    progress.advance(1);
                    Ok(power)
                },
            )
            .collect::<Result<_>>()?;
        Ok(powers.iter().sum())
    }

    /// Puts the wanted rows of a transform to their places.
    fn scatter(&self, transformed: &[Complex32], column: usize, lane: usize, out: &mut [f32]) {
        let length = self.plan.length as i64;
        for (row, values) in self.rows.clone().zip(out.chunks_exact_mut(self.plan.columns() * LINES)) {
            let value = transformed[row.rem_euclid(length) as usize];
            values[column * LINES + lane] = value.re;
            values[(column + 1) * LINES + lane] = value.im;
        }
    }
}

/// Buffers for one row of directions.
#[derive(Default)]
struct RowRoom {
    kernel: Vec<f32>,
    sources: Vec<f32>,
    products: Vec<f32>,
    row: Vec<f64>,
    /// Directions in the segment's own frame, filled up to whole vectors.
    omega_x: Vec<f64>,
    omega_z: Vec<f64>,
}

/// One row of directions: a cone around y.
struct RowOf<'a> {
    plan: &'a Plan,
    /// x and z₀ of each line.
    places: &'a [(f64, f64)],
    turn: f64,
    width: Width,
    held: &'a [f32],
    /// Rows that are held, and which of them.
    count: usize,
    index: usize,
}

impl RowOf<'_> {
    fn radiate(&self, omega_y: f64, room: &mut RowRoom, out: [&mut [[Complex32; 2]]; 2]) {
        let plan = self.plan;
        let radius = (1.0 - omega_y * omega_y).max(0.0).sqrt();
        let reach = ((radius / plan.step[0]).ceil() as usize).saturating_sub(1).min(plan.reach);
        // Directions in the segment's own frame: ω_x, ω_z.
        let (sin_turn, cos_turn) = self.turn.sin_cos();
        room.omega_x.clear();
        room.omega_z.clear();
        for i in 0..=2 * reach {
            let x = (i as f64 - reach as f64) * plan.step[0];
            let z = (radius * radius - x * x).max(0.0).sqrt();
            room.omega_x.push(x * cos_turn + z * sin_turn);
            room.omega_z.push(z * cos_turn - x * sin_turn);
        }
        let padded = room.omega_x.len().next_multiple_of(LANES);
        room.omega_x.resize(padded, 0.0);
        room.omega_z.resize(padded, 0.0);
        self.multiply(room);
        // The transforms began at the first cell's centre.
        let start = Complex64::from_polar(1.0, -plan.k * (omega_y - plan.mirror_y) * plan.first_um);
        // jk/4π
        let factor = start * Complex64::new(0.0, plan.k / (4.0 * std::f64::consts::PI));
        let n = 2 * padded;
        let mut weights = vec![0.0; plan.nodes.len()];
        let [a, b] = out;
        let shift = plan.reach - reach;
        for at in 0..=2 * reach {
            let (x, z) = (room.omega_x[at], room.omega_z[at]);
            if z <= 0.0 {
                continue;
            }
            for (node, weight) in weights.iter_mut().enumerate() {
                *weight = cardinal(&plan.nodes, node, z);
            }
            let (sin_phi, cos_phi) = (x / radius, z / radius);
            let (sin_theta, cos_theta) = (omega_y, radius);
            for (q, field) in [&mut a[shift + at], &mut b[shift + at]].into_iter().enumerate() {
                let sums: [Complex64; COMPONENTS] = std::array::from_fn(|component| {
                    let mut sum = Complex64::ZERO;
                    for (node, weight) in weights.iter().enumerate() {
                        let column = VALUES * node + 2 * (q * COMPONENTS + component);
                        let read = |column: usize, part: usize| {
                            f64::from(room.products[column * n + part * padded + at])
                        };
                        let (re, im) =
                            (read(column, 0) + read(column + 1, 1), read(column + 1, 0) - read(column, 1));
                        sum += Complex64::new(re, im) * *weight;
                    }
                    sum
                });
                let [jx, jy, jz, mx, my, mz] = sums;
                // e₁·[(1 − ωωᵀ)J̃ − ω × M̃] = e₁·J̃ − e₂·M̃ and e₂·[…] = e₂·J̃ + e₁·M̃.
                let e1 = jy * cos_theta
                    - (jx * sin_phi + jz * cos_phi) * sin_theta
                    - (mx * cos_phi - mz * sin_phi);
                let e2 = (jx * cos_phi - jz * sin_phi) + my * cos_theta
                    - (mx * sin_phi + mz * cos_phi) * sin_theta;
                *field = [e1, e2].map(|value| {
                    let value = value * factor;
                    Complex32::new(value.re as f32, value.im as f32)
                });
            }
        }
    }

    /// Sums of cos and sin of k(xω_x + z₀ω_z) times the currents, `[column][cos, sin][direction]`.
    fn multiply(&self, room: &mut RowRoom) {
        let (n, columns) = (2 * room.omega_x.len(), self.plan.columns());
        room.row.resize(n, 0.0);
        room.products.clear();
        room.products.resize(n * columns, 0.0);
        let block = self.count * columns * LINES;
        for (number, places) in self.places.chunks(CHUNK).enumerate() {
            let lines = places.len().next_multiple_of(LINES);
            room.kernel.clear();
            room.kernel.resize(n * lines, 0.0);
            for (&(x, z), target) in places.iter().zip(room.kernel.chunks_exact_mut(n)) {
                let (x, z) = (self.plan.k * x, self.plan.k * z);
                dispatch!(self.width.0, simd => kernel_row(simd, x, z, &room.omega_x, &room.omega_z, &mut room.row));
                for (value, exact) in target.iter_mut().zip(&room.row) {
                    *value = *exact as f32;
                }
            }
            room.sources.clear();
            room.sources.resize(lines * columns, 0.0);
            for (group, target) in
                (0..lines / LINES).map(|group| (number * (CHUNK / LINES) + group, group * LINES))
            {
                let from = &self.held[group * block + self.index * columns * LINES..][..columns * LINES];
                for (values, column) in from.chunks_exact(LINES).zip(room.sources.chunks_exact_mut(lines)) {
                    column[target..target + LINES].copy_from_slice(values);
                }
            }
            f32::multiply(&mut room.products, true, &room.kernel, &room.sources, n, lines, columns);
        }
    }
}

/// cos, then sin, of xω_x + zω_z for each direction.
#[inline(always)]
fn kernel_row<S: Simd>(simd: S, x: f64, z: f64, omega_x: &[f64], omega_z: &[f64], out: &mut [f64]) {
    let lanes = S::f64s::LEN;
    let (cosines, sines) = out.split_at_mut(omega_x.len());
    for at in (0..omega_x.len()).step_by(lanes) {
        let across = S::f64s::from_slice(simd, &omega_x[at..at + lanes]) * S::f64s::splat(simd, x);
        let up = S::f64s::from_slice(simd, &omega_z[at..at + lanes]);
        let (sin, cos) = sin_cos::<S, S::f64s>(simd, up.mul_add(S::f64s::splat(simd, z), across));
        cos.store_slice(&mut cosines[at..at + lanes]);
        sin.store_slice(&mut sines[at..at + lanes]);
    }
}

/// Lagrange's polynomial of one of some nodes.
fn cardinal(nodes: &[f64], node: usize, at: f64) -> f64 {
    let others = nodes.iter().enumerate().filter(|(other, _)| *other != node);
    others.map(|(_, other)| (at - other) / (nodes[node] - other)).product()
}
