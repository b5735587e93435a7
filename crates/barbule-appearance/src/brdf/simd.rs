//! What several kernels do with vector registers.

use fearless_simd::{Simd, f32x4, f32x8, f32x16, i32x4, prelude::*};

/// Rows as columns.
#[inline(always)]
pub(super) fn transposed<S: Simd, V: SimdBase<S>>(a: V, b: V, c: V, d: V) -> [V; 4] {
    let (ac, bd) = (a.zip_low(c), b.zip_low(d));
    let (ac_high, bd_high) = (a.zip_high(c), b.zip_high(d));
    [ac.zip_low(bd), ac.zip_high(bd), ac_high.zip_low(bd_high), ac_high.zip_high(bd_high)]
}

/// Whole part (towards zero) of each lane below 2²², and the rest.
#[inline(always)]
pub(super) fn whole_and_rest<S: Simd>(x: f32x4<S>) -> (i32x4<S>, f32x4<S>) {
    let floor = x.floor();
    (floor.to_int::<i32x4<S>>(), x - floor)
}

/// Each lane in four.
#[inline(always)]
pub(super) fn spread<S: Simd>(values: f32x4<S>) -> f32x16<S> {
    let (low, high) = (values.zip_low(values), values.zip_high(values));
    let low: f32x8<S> = low.zip_low(low).combine(low.zip_high(low));
    low.combine(high.zip_low(high).combine(high.zip_high(high)))
}

/// The four lanes of each wavelength as columns.
#[inline(always)]
pub(super) fn columns<S: Simd>(values: f32x16<S>) -> [f32x4<S>; 4] {
    let (low, high) = values.split();
    let ((a, b), (c, d)) = (low.split(), high.split());
    transposed(a, b, c, d)
}
