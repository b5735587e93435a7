//! The two precisions of the simulation: double where single illuminations are computed, single in campaigns.

use fearless_simd::{dispatch, f32x8, prelude::*};

use super::nodes::{Nodes, Taps};
use super::points::{Arrays, Points};
use super::reflection::{BLOCK, Currents, Reflectances};
use super::table::ReflectanceTable;
use crate::math::band_limited::TAPS;
use crate::math::dense::Factor;
use crate::math::fft::Transformable;
use crate::math::simd::{Complex, Real, Width};

/// The precision of kernel, currents and fields.
pub(super) trait Scalar: Real + Transformable + Factor {
    /// Reflectances that were tabulated in this precision.
    type Table: Reflectances<Self>;
    /// The arrays over the points in this precision.
    fn arrays(points: &Points) -> &Arrays<Self>;
    /// Where currents radiate from: the points themselves in double precision, nodes for transverse wave numbers up to
    /// `kappa` (rad/µm) in single precision.
    fn nodes(points: &Points, kappa: f64) -> Nodes<Self>;
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

/// There are no tables in double precision.
pub(super) enum Never {}

impl Reflectances<f64> for Never {
    #[inline(always)]
    fn at<S: Simd>(&self, _: S, _: &Arrays<f64>, _: usize, _: S::f64s) -> [Complex<S::f64s>; 2] {
        match *self {}
    }
}

impl Scalar for f64 {
    type Table = Never;

    fn nodes(points: &Points, _kappa: f64) -> Nodes<Self> {
        Nodes::at_points(points)
    }

    fn arrays(points: &Points) -> &Arrays<Self> {
        &points.double
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
    type Table = ReflectanceTable;

    fn nodes(points: &Points, kappa: f64) -> Nodes<Self> {
        Nodes::equidistant(points, kappa)
    }

    fn arrays(points: &Points) -> &Arrays<Self> {
        &points.single
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
