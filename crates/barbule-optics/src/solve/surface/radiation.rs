//! From currents to far fields on the whole specular cone.
//!
//! The far field is a trigonometric polynomial in the azimuth on the full circle (orders end near κ·max|ρ'|), so it is
//! evaluated at N angles of the circle and carried as Fourier coefficients to any other grid. All illuminations of one
//! (surface, λ, θ_i) share the kernel: one real matrix product, [cos; sin](angle, node) × currents(node, column). The
//! half circle suffices for it, since the kernel at φ + π is the conjugate of that at φ.

use fearless_simd::{dispatch, prelude::*};
use num_complex::Complex;

use super::cone::Cone;
use super::nodes::Nodes;
use super::points::Points;
use super::reflection::{BLOCK, COMPONENTS, Currents, Incidence, Lit, TOGETHER};
use super::reflector::Reflector;
use super::scalar::Scalar;
use crate::Result;
use crate::math::fft::Plans;
use crate::math::simd::{Width, sin_cos};

/// Points whose kernel is formed at a time, where every point is a node.
const NODE_CHUNK: usize = 512;

/// No kernel has more values than this, however wide the barbule.
const MOST_KERNEL: usize = 1 << 24;

/// Nodes of which the kernel at `angles` angles is formed at a time, at most.
pub(super) fn nodes_at_once(angles: usize, gathered: bool) -> usize {
    let most = (MOST_KERNEL / angles / BLOCK).max(1) * BLOCK;
    if gathered { most } else { NODE_CHUNK.min(most) }
}

/// Blocks of points between laps.
const BLOCKS_PER_LAP: usize = 256;

/// What is called after each stage, with its name.
pub(super) type Lap<'a> = dyn FnMut(&'static str) -> Result<()> + 'a;

/// Buffers of one thread.
pub(super) struct Radiator<T: Scalar> {
    width: Width,
    pub(super) plans: Plans<T>,
    row: Vec<f64>,
    kernel: Vec<T>,
    sources: Vec<T>,
    part: Vec<T>,
    products: Vec<T>,
    scratch: Vec<Complex<T>>,
}

impl<T: Scalar> Radiator<T> {
    /// Empty buffers; they grow to what is asked of them and are then reused.
    pub(super) fn new(width: Width) -> Self {
        Self {
            width,
            plans: Plans::default(),
            row: Vec::new(),
            kernel: Vec::new(),
            sources: Vec::new(),
            part: Vec::new(),
            products: Vec::new(),
            scratch: Vec::new(),
        }
    }

    /// Far fields of a barbule's points for azimuths `phi_i` (rad) on one cone, calling `lap` with its name after each
    /// stage; its error ends the work.
    ///
    /// `out` receives Fourier coefficients times `scales` (one per φ_i), shape
    /// `[phi_i][incident polarization][e₁, e₂][order]`, orders 0 … N/2 − 1, −N/2 … −1; for scales 1 they belong to unit
    /// |E|.
    ///
    /// # Errors
    /// That of `lap`.
    pub(super) fn far_fields(
        &mut self,
        points: &Points,
        reflector: &Reflector<T>,
        nodes: &Nodes<T>,
        cone: &Cone,
        phi_i: &[f64],
        scales: &[f64],
        out: &mut Vec<Complex<T>>,
        lap: &mut Lap<'_>,
    ) -> Result<()> {
        let columns = phi_i.len() * COMPONENTS;
        let n = cone.angles;
        resize(&mut self.products, n * columns);
        let count = nodes.x_um.len();
        let lit: Vec<_> = phi_i
            .iter()
            .map(|&phi| Lit {
                arrays: T::arrays(points),
                rise_um: &nodes.rise_um[..],
                k: cone.k,
                incidence: Incidence::new(cone.theta_i, phi),
            })
            .collect();
        // Points are nodes in chunks; nodes gather from all points at once.
        let gathered = nodes.taps.is_some();
        if gathered {
            resize(&mut self.sources, count * columns);
            self.sources.fill(T::of(0.0));
            self.gather_sources(reflector, nodes, &lit, 0..points.padded(), count, lap)?;
        }
        let chunk = nodes_at_once(n, gathered).min(count);
        for start in (0..count).step_by(chunk) {
            let end = (start + chunk).min(count);
            if !gathered {
                resize(&mut self.sources, (end - start) * columns);
                self.gather_sources(reflector, nodes, &lit, start..end, end - start, lap)?;
            }
            self.form_kernel(nodes, cone, start, end);
            lap("radiation kernel")?;
            if gathered && chunk < count {
                self.part.clear();
                self.part.extend(self.sources.chunks_exact(count).flat_map(|column| &column[start..end]));
                std::mem::swap(&mut self.part, &mut self.sources);
                self.multiply(n, end - start, columns, start > 0);
                std::mem::swap(&mut self.part, &mut self.sources);
            } else {
                self.multiply(n, end - start, columns, start > 0);
            }
            lap("matrix product")?;
        }
        self.form_coefficients(cone, phi_i.len(), scales, out);
        lap("components and transform")
    }

    /// Currents of the points `range` for every φ_i, moved onto nodes, `[phi_i][component][node]`.
    fn gather_sources(
        &mut self,
        reflector: &Reflector<T>,
        nodes: &Nodes<T>,
        lit: &[Lit<'_, T>],
        range: std::ops::Range<usize>,
        stride: usize,
        lap: &mut Lap<'_>,
    ) -> Result<()> {
        let mut currents: [Currents<T>; TOGETHER] = [[[T::of(0.0); BLOCK]; COMPONENTS]; TOGETHER];
        // Blocks outside, so that what is known of a block's points stays near.
        for (number, block) in range.clone().step_by(BLOCK).enumerate() {
            if number % BLOCKS_PER_LAP == BLOCKS_PER_LAP - 1 {
                lap("reflection and spreading")?;
            }
            let at = block - range.start;
            let (together, alone) = lit.as_chunks::<TOGETHER>();
            let (first, rest) = self.sources.split_at_mut(together.len() * TOGETHER * COMPONENTS * stride);
            for (lit, columns) in together.iter().zip(first.chunks_exact_mut(TOGETHER * COMPONENTS * stride))
            {
                reflector.currents(self.width, lit, block, &mut currents);
                add_currents(self.width, nodes, &currents, [block, at], stride, columns);
            }
            for (lit, columns) in alone.iter().zip(rest.chunks_exact_mut(COMPONENTS * stride)) {
                let currents = std::array::from_mut(&mut currents[0]);
                reflector.currents(self.width, std::array::from_ref(lit), block, currents);
                add_currents(self.width, nodes, currents, [block, at], stride, columns);
            }
        }
        lap("reflection and spreading")
    }

    /// cos and sin of κ(x sinφ + z cosφ), `[node][2][angle of the half circle]`.
    fn form_kernel(&mut self, nodes: &Nodes<T>, cone: &Cone, start: usize, end: usize) {
        let n = cone.angles;
        resize(&mut self.kernel, n * (end - start));
        self.row.resize(n, 0.0);
        for (node, target) in (start..end).zip(self.kernel.chunks_exact_mut(n)) {
            let (x, z) = (nodes.x_um[node] * cone.kappa, nodes.z_um[node] * cone.kappa);
            dispatch!(self.width.0, simd => kernel_row(simd, x, z, &cone.sin_phi, &cone.cos_phi, &mut self.row));
            for (value, exact) in target.iter_mut().zip(&self.row) {
                *value = T::of(*exact);
            }
        }
    }

    fn multiply(&mut self, n: usize, nodes: usize, columns: usize, add: bool) {
        T::multiply(&mut self.products, add, &self.kernel, &self.sources, n, nodes, columns);
    }

    /// Far-field components on the circle from the transforms J̃ and M̃, then their Fourier coefficients.
    ///
    /// e₁·[(1 − ωωᵀ)J̃ − ω × M̃] = e₁·J̃ − e₂·M̃ and e₂·[…] = e₂·J̃ + e₁·M̃, times
    /// (j/4)·jk·√(2/(πκ))·e^{−jπ/4}.
    fn form_coefficients(
        &mut self,
        cone: &Cone,
        incidences: usize,
        scales: &[f64],
        out: &mut Vec<Complex<T>>,
    ) {
        let n = cone.angles;
        let half = n / 2;
        let (sin_theta, cos_theta) = cone.theta_i.sin_cos();
        let transform = self.plans.forward(n);
        let zero = Complex { re: T::of(0.0), im: T::of(0.0) };
        self.scratch.resize(transform.scratch_len(), zero);
        out.resize(incidences * 4 * n, zero);
        let size = -cone.k / 4.0 * (2.0 / (std::f64::consts::PI * cone.kappa)).sqrt() / n as f64;
        let (cos_theta, sin_theta) = (T::of(cos_theta), T::of(sin_theta));
        for (pair, fields) in out.chunks_exact_mut(2 * n).enumerate() {
            let factor =
                Complex::new(size, 0.0) * Complex::from_polar(scales[pair / 2], -std::f64::consts::FRAC_PI_4);
            let factor = Complex { re: T::of(factor.re), im: T::of(factor.im) };
            let products = &self.products[pair * 12 * n..(pair + 1) * 12 * n];
            let (first, second) = fields.split_at_mut(n);
            for j in 0..half {
                let (s, c) = (T::of(cone.sin_phi[j]), T::of(cone.cos_phi[j]));
                let [near, far] = transforms(products, n, half, j);
                for (at, [jx, jy, jz, mx, my, mz], s, c) in [(j, near, s, c), (j + half, far, -s, -c)] {
                    let e1 = jy * cos_theta + (jx * s + jz * c) * sin_theta - (mx * c - mz * s);
                    let e2 = (jx * c - jz * s) + my * cos_theta + (mx * s + mz * c) * sin_theta;
                    first[at] = e1 * factor;
                    second[at] = e2 * factor;
                }
            }
            transform.process(first, &mut self.scratch);
            transform.process(second, &mut self.scratch);
        }
    }
}

/// Adds currents of the points from `block` on to their `columns`, `[light][component][node]`, which are those of nodes, or of
/// points of which the first is number `at`.
fn add_currents<T: Scalar>(
    width: Width,
    nodes: &Nodes<T>,
    currents: &[Currents<T>],
    [block, at]: [usize; 2],
    stride: usize,
    columns: &mut [T],
) {
    for (currents, columns) in currents.iter().zip(columns.chunks_exact_mut(COMPONENTS * stride)) {
        match &nodes.taps {
            Some(taps) => T::spread(width, taps, block, currents, stride, columns),
            None => {
                for (row, column) in currents.iter().zip(columns.chunks_exact_mut(stride)) {
                    column[at..at + BLOCK].copy_from_slice(row);
                }
            }
        }
    }
}

/// The six Fourier transforms of the currents at angle j and at its opposite.
#[inline(always)]
fn transforms<T: Scalar>(products: &[T], n: usize, half: usize, j: usize) -> [[Complex<T>; 6]; 2] {
    // Written out, since `array::from_fn` and `array::map` are not always inlined, which doubles the time of this stage.
    let parts = [
        part(products, n, half, j, 0),
        part(products, n, half, j, 1),
        part(products, n, half, j, 2),
        part(products, n, half, j, 3),
        part(products, n, half, j, 4),
        part(products, n, half, j, 5),
    ];
    let mut both = [[Complex { re: T::of(0.0), im: T::of(0.0) }; 6]; 2];
    for (component, (re_cos, re_sin, im_cos, im_sin)) in parts.into_iter().enumerate() {
        both[0][component] = Complex { re: re_cos + im_sin, im: im_cos - re_sin };
        both[1][component] = Complex { re: re_cos - im_sin, im: im_cos + re_sin };
    }
    both
}

/// The cosine and the sine sum of the real part of one component, then those of its imaginary part, at angle j.
#[inline(always)]
fn part<T: Scalar>(products: &[T], n: usize, half: usize, j: usize, component: usize) -> (T, T, T, T) {
    let re = &products[2 * component * n..(2 * component + 1) * n];
    let im = &products[(2 * component + 1) * n..(2 * component + 2) * n];
    (re[j], re[j + half], im[j], im[j + half])
}

#[inline(always)]
fn kernel_row<S: Simd>(simd: S, x: f64, z: f64, sin_phi: &[f64], cos_phi: &[f64], out: &mut [f64]) {
    let lanes = S::f64s::LEN;
    let (cos_row, sin_row) = out.split_at_mut(sin_phi.len());
    for at in (0..sin_phi.len()).step_by(lanes) {
        let s = S::f64s::from_slice(simd, &sin_phi[at..at + lanes]);
        let c = S::f64s::from_slice(simd, &cos_phi[at..at + lanes]);
        let (sin, cos) = sin_cos::<S, S::f64s>(simd, s.mul_add(S::f64s::splat(simd, x), c * z));
        cos.store_slice(&mut cos_row[at..at + lanes]);
        sin.store_slice(&mut sin_row[at..at + lanes]);
    }
}

fn resize<T: Scalar>(values: &mut Vec<T>, length: usize) {
    values.resize(length, T::of(0.0));
}
