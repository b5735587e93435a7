//! The fields and one step of them.
//!
//! All fields are ∝ e^{jβy}. With E_y = j e_y, H̃_x = j h_x, H̃_z = j h_z the equations have real coefficients,
//!
//!   ∂h_x = ∂_z e_y − βE_z,    ∂H_y = ∂_x E_z − ∂_z E_x,    ∂h_z = βE_x − ∂_x e_y,
//!   ∂D_x = −βh_z − ∂_z H_y,   ∂d_y = ∂_z h_x − ∂_x h_z,    ∂D_z = ∂_x H_y + βh_x,
//!
//! so real and imaginary parts are two real grids that only the Bloch boundary and the source couple. Components lie on
//! Yee's lattice in x and z: E_x, h_z at (i + ½, k), e_y at (i, k), E_z, h_x at (i, k + ½), H_y at (i + ½, k + ½).
//! Each row is a line along z.

use fearless_simd::dispatch;

use super::grid::{Grid, Real, blend};
use super::medium::Material;
use crate::Complex64;
use crate::math::simd::Width;

/// One component: real rows −1 … nx, then imaginary ones; the first and last are copies across the period.
type Component = Vec<Real>;

pub(super) struct Fields {
    nx: usize,
    nz: usize,
    absorber: usize,
    pub e: [Component; 3],
    pub d: [Component; 3],
    pub h: [Component; 3],
    /// a and b of each component; one part, rows 0 … nx − 1.
    a: [Vec<Real>; 3],
    b: [Vec<Real>; 3],
    cross: Vec<Cross>,
    /// dt·f/(Δκ) at planes and between them, and the recursions of the absorbing layers.
    along_z: [Vec<Real>; 2],
    keep: [Vec<Real>; 2],
    feed: [Vec<Real>; 2],
    /// Memories of ∂_z of e_y, E_x, H_y, h_x, lower layer then upper.
    memory: [Vec<Real>; 4],
    along_x: Real,
    beta: Real,
    /// e^{jk_xΔ}, from one end of the period to the other.
    bloch: [Real; 2],
    width: Width,
}

/// The off-diagonal ξ at a node (i, k), which couples D_x left and right of it to E_z above and below it and back, a
/// symmetric operator.
struct Cross {
    right: usize,
    left: usize,
    /// What turns D at `left` into D half a cell left of the node.
    turn: [Real; 2],
    above: usize,
    a: Real,
    b: Real,
    /// Sums of D_x and D_z at the step before, complex.
    before: [[Real; 2]; 2],
}

/// The incident wave's tangential fields at the source plane, complex, times e^{jωt}; one value per column.
pub(super) struct Source {
    pub plane: usize,
    pub e_x: Vec<Complex64>,
    pub e_y: Vec<Complex64>,
    pub h_x: Vec<Complex64>,
    pub h_y: Vec<Complex64>,
}

impl Fields {
    pub(super) fn new(grid: &Grid, material: &Material, beta: f64, kx: f64, width: Width) -> Self {
        let (nx, nz) = (grid.nx, grid.nz);
        let empty = || vec![0.0; 2 * (nx + 2) * nz];
        let three = || [empty(), empty(), empty()];
        let profiles = [grid.absorbing(0.0), grid.absorbing(0.5)];
        let scale = grid.dt * grid.fz / grid.spacing;
        let profile = |index: usize, scale: f64| -> [Vec<Real>; 2] {
            std::array::from_fn(|half| profiles[half].iter().map(|p| (p[index] * scale) as Real).collect())
        };
        let (sine, cosine) = (kx * grid.spacing * nx as f64).sin_cos();
        let mut fields = Self {
            nx,
            nz,
            absorber: grid.absorber,
            e: three(),
            d: three(),
            h: three(),
            a: std::array::from_fn(|_| vec![0.0; nx * nz]),
            b: std::array::from_fn(|_| vec![0.0; nx * nz]),
            cross: Vec::new(),
            along_z: profile(0, scale),
            keep: profile(1, 1.0),
            feed: profile(2, scale),
            memory: std::array::from_fn(|_| vec![0.0; 2 * nx * 2 * grid.absorber]),
            along_x: (grid.dt * grid.fx / grid.spacing) as Real,
            beta: (grid.dt * beta) as Real,
            bloch: [cosine as Real, sine as Real],
            width,
        };
        fields.fill(grid, material);
        fields
    }

    fn fill(&mut self, grid: &Grid, material: &Material) {
        let angle = grid.omega * grid.dt;
        for (component, values) in material.diagonal.iter().enumerate() {
            for (index, &value) in values.iter().enumerate() {
                let (a, b) = blend(value, angle);
                self.a[component][index] = a as Real;
                self.b[component][index] = b as Real;
            }
        }
        for &(i, k, xz) in &material.cross {
            let left = (i + self.nx - 1) % self.nx;
            let (a, b) = blend(xz, angle);
            self.cross.push(Cross {
                right: self.index(0, i as isize, k),
                left: self.index(0, left as isize, k),
                turn: if i == 0 { [self.bloch[0], -self.bloch[1]] } else { [1.0, 0.0] },
                above: self.index(0, i as isize, k),
                a: (0.25 * a) as Real,
                b: (0.25 * b) as Real,
                before: [[0.0; 2]; 2],
            });
        }
    }

    /// Where a component's value of part 0 (real) or 1 (imaginary) in column i (−1 … nx) and plane k lies.
    fn index(&self, part: usize, i: isize, k: usize) -> usize {
        (part * (self.nx + 2) + (i + 1) as usize) * self.nz + k
    }

    /// A complex value of a component.
    pub(super) fn get(&self, component: &Component, i: usize, k: usize) -> Complex64 {
        let part = |part| f64::from(component[self.index(part, i as isize, k)]);
        Complex64::new(part(0), part(1))
    }

    /// Steps the fields as often as there are factors: those of the incident wave (with e^{−jωt}) at E's and at H̃'s
    /// times.
    pub(super) fn advance(&mut self, source: &Source, factors: &[[Complex64; 2]]) {
        dispatch!(self.width.0, _simd => self.steps(source, factors));
    }

    #[inline(always)]
    fn steps(&mut self, source: &Source, factors: &[[Complex64; 2]]) {
        for factor in factors {
            self.step_h();
            self.source_h(source, factor[0]);
            self.step_e();
            self.source_e(source, factor[1]);
            self.step_cross();
        }
    }

    #[inline(always)]
    fn step_h(&mut self) {
        let (nx, nz, n) = (self.nx, self.nz, self.absorber);
        wrap(&mut self.e[1], nx, nz, nx + 1, 1, self.bloch);
        wrap(&mut self.e[2], nx, nz, nx + 1, 1, self.bloch);
        let [hx, hy, hz] = &mut self.h;
        let [ex, ey, ez] = &self.e;
        let [memory_y, memory_x, ..] = &mut self.memory;
        for part in 0..2 {
            for i in 0..nx {
                let start = (part * (nx + 2) + i + 1) * nz;
                let (here, next) = (start..start + nz, start + nz..start + 2 * nz);
                magnetic_row(
                    [&mut hx[here.clone()], &mut hy[here.clone()], &mut hz[here.clone()]],
                    [&ex[here.clone()], &ey[here.clone()], &ez[here.clone()]],
                    [&ey[next.clone()], &ez[next]],
                    &self.along_z[1],
                    self.along_x,
                    self.beta,
                );
                let own = (part * nx + i) * 2 * n..(part * nx + i + 1) * 2 * n;
                let (keep, feed) = (&self.keep[1], &self.feed[1]);
                for (at, k) in [(0, 0), (n, nz - 1 - n)] {
                    let own = own.start + at..own.start + at + n;
                    let row = start + k..start + k + n;
                    let ahead = row.start + 1..row.end + 1;
                    let range = k..k + n;
                    let (keep, feed) = (&keep[range.clone()], &feed[range]);
                    absorb(
                        &mut hx[row.clone()],
                        &mut memory_y[own.clone()],
                        &ey[row.clone()],
                        &ey[ahead.clone()],
                        keep,
                        feed,
                        1.0,
                    );
                    absorb(&mut hy[row.clone()], &mut memory_x[own], &ex[row], &ex[ahead], keep, feed, -1.0);
                }
            }
        }
    }

    #[inline(always)]
    fn step_e(&mut self) {
        let (nx, nz, n) = (self.nx, self.nz, self.absorber);
        let back = [self.bloch[0], -self.bloch[1]];
        wrap(&mut self.h[1], nx, nz, 0, nx, back);
        wrap(&mut self.h[2], nx, nz, 0, nx, back);
        let [ex, ey, ez] = &mut self.e;
        let [dx, dy, dz] = &mut self.d;
        let [hx, hy, hz] = &self.h;
        let [_, _, memory_y, memory_x] = &mut self.memory;
        for part in 0..2 {
            for i in 0..nx {
                let start = (part * (nx + 2) + i + 1) * nz;
                let (here, last) = (start..start + nz, start - nz..start);
                let cell = i * nz..(i + 1) * nz;
                // D of the step before, until E is formed.
                ex[here.clone()].copy_from_slice(&dx[here.clone()]);
                ey[here.clone()].copy_from_slice(&dy[here.clone()]);
                ez[here.clone()].copy_from_slice(&dz[here.clone()]);
                electric_row(
                    [&mut dx[here.clone()], &mut dy[here.clone()], &mut dz[here.clone()]],
                    [&hx[here.clone()], &hy[here.clone()], &hz[here.clone()]],
                    [&hy[last.clone()], &hz[last]],
                    &self.along_z[0],
                    self.along_x,
                    self.beta,
                );
                let own = (part * nx + i) * 2 * n;
                for (at, k) in [(0, 1), (n, nz - 1 - n)] {
                    let own = own + at..own + at + n;
                    let row = start + k..start + k + n;
                    let behind = row.start - 1..row.end - 1;
                    let (keep, feed) = (&self.keep[0][k..k + n], &self.feed[0][k..k + n]);
                    absorb(
                        &mut dx[row.clone()],
                        &mut memory_y[own.clone()],
                        &hy[behind.clone()],
                        &hy[row.clone()],
                        keep,
                        feed,
                        -1.0,
                    );
                    absorb(&mut dy[row.clone()], &mut memory_x[own], &hx[behind], &hx[row], keep, feed, 1.0);
                }
                for (component, (e, d)) in
                    [(&mut *ex, &*dx), (&mut *ey, &*dy), (&mut *ez, &*dz)].into_iter().enumerate()
                {
                    blend_row(
                        &mut e[here.clone()],
                        &d[here.clone()],
                        &self.a[component][cell.clone()],
                        &self.b[component][cell.clone()],
                    );
                }
            }
        }
    }

    /// Planes above the source hold the scattered field alone: the curl across it sees the incident wave.
    #[inline(always)]
    fn source_h(&mut self, source: &Source, factor: Complex64) {
        let along = self.along_z[1][source.plane];
        for i in 0..self.nx {
            let (ey, ex) = (source.e_y[i] * factor, source.e_x[i] * factor);
            // e_y = −jE_y
            for (part, (ey, ex)) in [(ey.im, ex.re), (-ey.re, ex.im)].into_iter().enumerate() {
                let index = self.index(part, i as isize, source.plane);
                self.h[0][index] += along * ey as Real;
                self.h[1][index] -= along * ex as Real;
            }
        }
    }

    #[inline(always)]
    fn source_e(&mut self, source: &Source, factor: Complex64) {
        let along = self.along_z[0][source.plane];
        for i in 0..self.nx {
            let (hx, hy) = (source.h_x[i] * factor, source.h_y[i] * factor);
            let cell = i * self.nz + source.plane;
            for (part, (hx, hy)) in [(hx.im, hy.re), (-hx.re, hy.im)].into_iter().enumerate() {
                let index = self.index(part, i as isize, source.plane);
                for (component, change) in [(0, -along * hy as Real), (1, along * hx as Real)] {
                    self.d[component][index] += change;
                    self.e[component][index] += self.a[component][cell] * change;
                }
            }
        }
    }

    #[inline(always)]
    fn step_cross(&mut self) {
        let part = (self.nx + 2) * self.nz;
        let [ex, _, ez] = &mut self.e;
        let [dx, _, dz] = &self.d;
        for node in &mut self.cross {
            let [c, s] = node.turn;
            let (left, right) =
                ([dx[node.left], dx[node.left + part]], [dx[node.right], dx[node.right + part]]);
            let x = [right[0] + c * left[0] - s * left[1], right[1] + c * left[1] + s * left[0]];
            let z: [Real; 2] =
                std::array::from_fn(|p| dz[node.above + p * part] + dz[node.above - 1 + p * part]);
            let to_x: [Real; 2] = std::array::from_fn(|p| node.a * z[p] + node.b * node.before[1][p]);
            let to_z: [Real; 2] = std::array::from_fn(|p| node.a * x[p] + node.b * node.before[0][p]);
            node.before = [x, z];
            let turned = [c * to_x[0] + s * to_x[1], c * to_x[1] - s * to_x[0]];
            for p in 0..2 {
                ex[node.right + p * part] += to_x[p];
                ex[node.left + p * part] += turned[p];
                ez[node.above + p * part] += to_z[p];
                ez[node.above - 1 + p * part] += to_z[p];
            }
        }
    }
}

/// Copies the row `from` (counted from −1) to the row `to` of both parts, turned by a phase.
#[inline(always)]
fn wrap(component: &mut Component, nx: usize, nz: usize, to: usize, from: usize, turn: [Real; 2]) {
    let (re, im) = component.split_at_mut((nx + 2) * nz);
    let (from, to) = (from * nz..(from + 1) * nz, to * nz..(to + 1) * nz);
    for (k_from, k_to) in from.zip(to) {
        let value = [re[k_from], im[k_from]];
        re[k_to] = turn[0] * value[0] - turn[1] * value[1];
        im[k_to] = turn[0] * value[1] + turn[1] * value[0];
    }
}

#[inline(always)]
fn magnetic_row(
    [hx, hy, hz]: [&mut [Real]; 3],
    [ex, ey, ez]: [&[Real]; 3],
    [ey_next, ez_next]: [&[Real]; 2],
    along_z: &[Real],
    along_x: Real,
    beta: Real,
) {
    // Slices of one length, so that no index is checked and loops become vector instructions.
    let last = hx.len() - 1;
    let (hx, hy, hz) = (&mut hx[..last], &mut hy[..last], &mut hz[..last]);
    let (ex_up, ey_up) = (&ex[1..=last], &ey[1..=last]);
    let (ex, ey, ez) = (&ex[..last], &ey[..last], &ez[..last]);
    let (ey_next, ez_next, along_z) = (&ey_next[..last], &ez_next[..last], &along_z[..last]);
    for k in 0..last {
        hx[k] += (ey_up[k] - ey[k]) * along_z[k] - beta * ez[k];
    }
    for k in 0..last {
        hy[k] += (ez_next[k] - ez[k]) * along_x - (ex_up[k] - ex[k]) * along_z[k];
    }
    for k in 0..last {
        hz[k] += beta * ex[k] - (ey_next[k] - ey[k]) * along_x;
    }
}

#[inline(always)]
fn electric_row(
    [dx, dy, dz]: [&mut [Real]; 3],
    [hx, hy, hz]: [&[Real]; 3],
    [hy_last, hz_last]: [&[Real]; 2],
    along_z: &[Real],
    along_x: Real,
    beta: Real,
) {
    let last = dx.len() - 1;
    let inner = last - 1;
    let (dx, dy, dz) = (&mut dx[1..last], &mut dy[1..last], &mut dz[..last]);
    let (hx_down, hy_down) = (&hx[..inner], &hy[..inner]);
    let (hx_up, hy_up, hz_up) = (&hx[1..last], &hy[1..last], &hz[1..last]);
    let (hz_last, along_z) = (&hz_last[1..last], &along_z[1..last]);
    for k in 0..inner {
        dx[k] -= beta * hz_up[k] + (hy_up[k] - hy_down[k]) * along_z[k];
    }
    for k in 0..inner {
        dy[k] += (hx_up[k] - hx_down[k]) * along_z[k] - (hz_up[k] - hz_last[k]) * along_x;
    }
    let (hx, hy, hy_last) = (&hx[..last], &hy[..last], &hy_last[..last]);
    for k in 0..last {
        dz[k] += (hy[k] - hy_last[k]) * along_x + beta * hx[k];
    }
}

/// Adds the memory of the differences `high` − `low`.
#[inline(always)]
fn absorb(
    field: &mut [Real],
    memory: &mut [Real],
    low: &[Real],
    high: &[Real],
    keep: &[Real],
    feed: &[Real],
    sign: Real,
) {
    let count = field.len();
    let (memory, low, high, keep, feed) =
        (&mut memory[..count], &low[..count], &high[..count], &keep[..count], &feed[..count]);
    for k in 0..count {
        memory[k] = keep[k] * memory[k] + feed[k] * (high[k] - low[k]);
        field[k] += sign * memory[k];
    }
}

/// E = a·D + b·D before, which `e` holds.
#[inline(always)]
fn blend_row(e: &mut [Real], d: &[Real], a: &[Real], b: &[Real]) {
    let count = e.len();
    let (d, a, b) = (&d[..count], &a[..count], &b[..count]);
    for k in 0..count {
        e[k] = a[k] * d[k] + b[k] * e[k];
    }
}
