//! From currents to far fields on the whole specular cone.
//!
//! The far field is a trigonometric polynomial in the azimuth on the full circle (orders end near κ·max|ρ'|), so it is
//! evaluated at N angles of the circle and carried as Fourier coefficients to any other grid. All illuminations of one
//! (surface, λ, θ_i) share the kernel: one real matrix product, [cos; sin](angle, node) × currents(node, column). The
//! half circle suffices for it, since the kernel at φ + π is the conjugate of that at φ.

use fearless_simd::{dispatch, f32x8, prelude::*};
use num_complex::Complex;

use super::nodes::{Nodes, Taps};
use super::points::{Arrays, Surface};
use super::reflection::{BLOCK, COMPONENTS, Currents, Incidence, Reflector};
use crate::math::band_limited::TAPS;
use crate::math::dense::Factor;
use crate::math::fft::{Plans, Transform, Transformable};
use crate::math::simd::{Real, Width, sin_cos};

/// Nodes whose kernel is formed at a time; bounds memory when every point is a node.
const NODE_CHUNK: usize = 512;

/// The precision of kernel, currents and fields.
pub trait Scalar: Real + Transformable + Factor {
    /// A surface's arrays in this precision.
    fn arrays(surface: &Surface) -> &Arrays<Self>;
    /// Adds a block of currents to the nodes around their points; `out` is `[component][node]` of row length `stride`.
    fn spread(
        width: Width,
        taps: &Taps,
        start: usize,
        currents: &Currents<Self>,
        stride: usize,
        out: &mut [Self],
    );
}

impl Scalar for f64 {
    fn arrays(surface: &Surface) -> &Arrays<Self> {
        &surface.double
    }

    fn spread(
        _width: Width,
        taps: &Taps,
        start: usize,
        currents: &Currents<Self>,
        stride: usize,
        out: &mut [Self],
    ) {
        for (component, row) in currents.iter().enumerate() {
            for (p, current) in row.iter().enumerate() {
                let at = component * stride + taps.first[start + p] as usize;
                for (node, weight) in out[at..at + TAPS].iter_mut().zip(taps.weights[start + p]) {
                    *node += f64::from(weight) * current;
                }
            }
        }
    }
}

impl Scalar for f32 {
    fn arrays(surface: &Surface) -> &Arrays<Self> {
        &surface.single
    }

    fn spread(
        width: Width,
        taps: &Taps,
        start: usize,
        currents: &Currents<Self>,
        stride: usize,
        out: &mut [Self],
    ) {
        dispatch!(width.0, simd => spread_f32(simd, taps, start, currents, stride, out));
    }
}

/// Components that are summed side by side, to hide the latency of one sum.
const GROUP: usize = 8;

/// Points with the same first node are gathered in registers before the nodes are touched.
#[inline(always)]
fn spread_f32<S: Simd>(
    simd: S,
    taps: &Taps,
    start: usize,
    currents: &Currents<f32>,
    stride: usize,
    out: &mut [f32],
) {
    let firsts = &taps.first[start..start + BLOCK];
    let weights = &taps.weights[start..start + BLOCK];
    let mut run = 0;
    while run < BLOCK {
        let first = firsts[run];
        let end = run + firsts[run..].iter().take_while(|&&other| other == first).count();
        for (group, rows) in currents.chunks_exact(GROUP).enumerate() {
            let at = |member: usize| (group * GROUP + member) * stride + first as usize;
            let mut sums = [f32x8::splat(simd, 0.0); GROUP];
            for p in run..end {
                let weight = f32x8::from_slice(simd, &weights[p]);
                for (sum, row) in sums.iter_mut().zip(rows) {
                    *sum = weight.mul_add(f32x8::splat(simd, row[p]), *sum);
                }
            }
            for (member, sum) in sums.into_iter().enumerate() {
                let nodes = &mut out[at(member)..at(member) + TAPS];
                (sum + f32x8::from_slice(simd, nodes)).store_slice(nodes);
            }
        }
        run = end;
    }
}

/// The specular cone of one (λ, θ_i): its angles and constants.
#[derive(Debug, Clone)]
pub struct Cone {
    /// θ_i, rad.
    pub theta_i: f64,
    /// Transverse wave number κ = k cosθ_i, rad/µm.
    pub kappa: f64,
    k: f64,
    /// N, the number of angles and of Fourier coefficients.
    pub angles: usize,
    sin_phi: Vec<f64>,
    cos_phi: Vec<f64>,
}

impl Cone {
    /// For wave number `k` (rad/µm) and a structure that stays within `radius_um` of the origin.
    #[must_use]
    pub fn new(k: f64, theta_i: f64, radius_um: f64) -> Self {
        let kappa = k * theta_i.cos();
        let least = 2.1 * kappa * radius_um + 40.0;
        let angles = fast_length(least.ceil() as usize);
        let step = std::f64::consts::TAU / angles as f64;
        let (sin_phi, cos_phi) = (0..angles / 2).map(|j| (j as f64 * step).sin_cos()).unzip();
        Self { theta_i, kappa, k, angles, sin_phi, cos_phi }
    }

    /// Orders that a field can contain end here.
    pub fn band(&self) -> usize {
        self.angles / 2
    }
}

/// The least multiple of 16 that is ≥ `least` and has no prime factor over 5.
fn fast_length(least: usize) -> usize {
    (least.div_ceil(16)..)
        .map(|n| n * 16)
        .find(|&length| {
            let mut rest = length;
            for prime in [2, 3, 5] {
                while rest % prime == 0 {
                    rest /= prime;
                }
            }
            rest == 1
        })
        .unwrap_or(least)
}

/// Buffers of one thread.
pub struct Workspace<T: Scalar> {
    width: Width,
    plans: Plans<T>,
    row: Vec<f64>,
    kernel: Vec<T>,
    sources: Vec<T>,
    products: Vec<T>,
    scratch: Vec<Complex<T>>,
}

impl<T: Scalar> Workspace<T> {
    /// Empty buffers; they grow to what is asked of them and are then reused.
    #[must_use]
    pub fn new(width: Width) -> Self {
        Self {
            width,
            plans: Plans::default(),
            row: Vec::new(),
            kernel: Vec::new(),
            sources: Vec::new(),
            products: Vec::new(),
            scratch: Vec::new(),
        }
    }

    /// Far fields of one surface for azimuths `phi_i` (rad) on one cone.
    ///
    /// `out` receives Fourier coefficients over √Φ_i, shape `[phi_i][incident polarization][e₁, e₂][order]`, orders
    /// 0 … N/2 − 1, −N/2 … −1; `incident_um` the Φ_i. Without a window fields belong to unit |E| and Φ_i is not used.
    pub fn far_fields(
        &mut self,
        surface: &Surface,
        reflector: &impl Reflector<T>,
        nodes: &Nodes<T>,
        cone: &Cone,
        phi_i: &[f64],
        scales: &[f64],
        out: &mut Vec<Complex<T>>,
    ) {
        self.timed_far_fields(surface, reflector, nodes, cone, phi_i, scales, out, |_| {});
    }

    /// [`Self::far_fields`], calling `lap` with its name after each stage.
    pub fn timed_far_fields(
        &mut self,
        surface: &Surface,
        reflector: &impl Reflector<T>,
        nodes: &Nodes<T>,
        cone: &Cone,
        phi_i: &[f64],
        scales: &[f64],
        out: &mut Vec<Complex<T>>,
        mut lap: impl FnMut(&'static str),
    ) {
        let columns = phi_i.len() * COMPONENTS;
        let n = cone.angles;
        resize(&mut self.products, n * columns);
        let count = nodes.x_um.len();
        // Points are nodes in chunks; nodes gather from all points at once.
        let chunk = if nodes.taps.is_some() { count } else { NODE_CHUNK };
        for start in (0..count).step_by(chunk) {
            let end = (start + chunk).min(count);
            resize(&mut self.sources, (end - start) * columns);
            let points = if nodes.taps.is_some() {
                self.sources.fill(T::of(0.0));
                0..surface.padded()
            } else {
                start..end
            };
            self.gather_sources(surface, reflector, nodes, cone, phi_i, points, end - start);
            lap("reflection and spreading");
            self.form_kernel(nodes, cone, start, end);
            lap("radiation kernel");
            self.multiply(n, end - start, columns, start > 0);
            lap("matrix product");
        }
        self.form_coefficients(cone, phi_i.len(), scales, out);
        lap("components and transform");
    }

    /// Currents of `points` for every φ_i, moved onto nodes, `[phi_i][component][node]`.
    fn gather_sources(
        &mut self,
        surface: &Surface,
        reflector: &impl Reflector<T>,
        nodes: &Nodes<T>,
        cone: &Cone,
        phi_i: &[f64],
        points: std::ops::Range<usize>,
        stride: usize,
    ) {
        let arrays = T::arrays(surface);
        let mut currents: Currents<T> = [[T::of(0.0); BLOCK]; COMPONENTS];
        let incidences: Vec<_> = phi_i.iter().map(|&phi| Incidence::new(cone.theta_i, phi)).collect();
        // Blocks outside, so that what is known of a block's points stays near.
        for block in points.clone().step_by(BLOCK) {
            for (incidence, columns) in
                incidences.iter().zip(self.sources.chunks_exact_mut(stride * COMPONENTS))
            {
                dispatch!(self.width.0, simd => reflector.currents(
                    simd, arrays, cone.k, incidence, &nodes.rise_um, block, &mut currents
                ));
                match &nodes.taps {
                    Some(taps) => T::spread(self.width, taps, block, &currents, stride, columns),
                    None => {
                        for (row, column) in currents.iter().zip(columns.chunks_exact_mut(stride)) {
                            let at = block - points.start;
                            column[at..at + BLOCK].copy_from_slice(row);
                        }
                    }
                }
            }
        }
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

    /// A plan to evaluate fields at (n + ½)·π/`azimuths` − π/2 + shift, with `margin` more points on either side.
    pub fn synthesis(&mut self, cone: &Cone, azimuths: usize, margin: usize) -> Synthesis<T> {
        let circle = 2 * azimuths;
        Synthesis { transform: self.plans.inverse(circle), angles: cone.angles, azimuths, margin }
    }
}

/// The six Fourier transforms of the currents at angle j and at its opposite.
#[inline(always)]
fn transforms<T: Scalar>(products: &[T], n: usize, half: usize, j: usize) -> [[Complex<T>; 6]; 2] {
    let pick = |component: usize| {
        let re = &products[2 * component * n..(2 * component + 1) * n];
        let im = &products[(2 * component + 1) * n..(2 * component + 2) * n];
        (re[j], re[j + half], im[j], im[j + half])
    };
    let parts: [_; 6] = std::array::from_fn(pick);
    [
        parts.map(|(re_cos, re_sin, im_cos, im_sin)| Complex { re: re_cos + im_sin, im: im_cos - re_sin }),
        parts.map(|(re_cos, re_sin, im_cos, im_sin)| Complex { re: re_cos - im_sin, im: im_cos + re_sin }),
    ]
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

/// Evaluates Fourier coefficients on equidistant azimuths of the upper half of the cone.
pub struct Synthesis<T: Scalar> {
    transform: Transform<T>,
    angles: usize,
    azimuths: usize,
    margin: usize,
}

impl<T: Scalar> Synthesis<T> {
    /// Values at (n + ½)·π/azimuths − π/2 + `shift` for n = −margin … azimuths + margin − 1; `circle` is scratch.
    pub fn evaluate(
        &self,
        coefficients: &[Complex<T>],
        shift: f64,
        circle: &mut Vec<Complex<T>>,
        scratch: &mut Vec<Complex<T>>,
        out: &mut [Complex<T>],
    ) {
        let length = 2 * self.azimuths;
        let zero = Complex { re: T::of(0.0), im: T::of(0.0) };
        circle.clear();
        circle.resize(length, zero);
        let start = 0.5 * std::f64::consts::PI / self.azimuths as f64 - std::f64::consts::FRAC_PI_2 + shift;
        let half = self.angles / 2;
        let turn = Complex::from_polar(1.0, start);
        let mut phase = Complex::new(1.0, 0.0);
        for order in 0..half {
            // A rotation that is renewed often enough to stay exact to rounding.
            if order % 64 == 0 {
                phase = Complex::from_polar(1.0, start * order as f64);
            }
            let (re, im) = (T::of(phase.re), T::of(phase.im));
            let bin = &mut circle[order % length];
            *bin += coefficients[order] * Complex { re, im };
            if order > 0 {
                let bin = &mut circle[(length - order % length) % length];
                *bin += coefficients[self.angles - order] * Complex { re, im: -im };
            }
            phase *= turn;
        }
        scratch.resize(self.transform.scratch_len(), zero);
        self.transform.process(circle, scratch);
        for (n, value) in out.iter_mut().enumerate() {
            *value = circle[(n + length - self.margin) % length];
        }
    }

    /// Points that [`Self::evaluate`] gives.
    pub fn points(&self) -> usize {
        self.azimuths + 2 * self.margin
    }
}
