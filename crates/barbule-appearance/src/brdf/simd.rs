//! What several kernels do with vector registers.

use fearless_simd::{Simd, f32x4, i32x4, prelude::*};

/// Rows as columns.
#[inline(always)]
pub(super) fn transposed<S: Simd>(a: f32x4<S>, b: f32x4<S>, c: f32x4<S>, d: f32x4<S>) -> [f32x4<S>; 4] {
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
