//! Mathematics without physics: seeded random streams, transforms, quadrature, small kernels.

pub mod normal;
pub mod rng;
