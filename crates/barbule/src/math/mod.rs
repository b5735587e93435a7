//! Mathematics without physics: seeded random streams, SIMD kernels, interpolation, elementary statistics.

pub mod band_limited;
pub mod normal;
pub mod rng;
pub mod simd;
