//! Mathematics without physics: seeded random streams, SIMD kernels, transforms, dense algebra, special functions.
//!
//! Libraries that are generic over their number types stand here behind functions of concrete ones.

pub mod band_limited;
pub mod bessel;
pub mod chebyshev;
pub mod dense;
pub mod elementary;
pub mod fft;
pub mod golden;
#[cfg(feature = "full-waves")]
pub mod hierarchical;
#[cfg(feature = "full-waves")]
pub mod large;
pub mod normal;
pub mod quadrature;
pub mod rng;
pub mod roots;
pub mod simd;
#[cfg(feature = "full-waves")]
mod single;
pub mod spline;
pub mod steps;
pub mod student;
