//! Measuring that several tests and the programs in `examples/` share.

pub(crate) mod crystals;
pub(crate) mod fields;
pub(crate) mod golden;
pub(crate) mod laws;
pub(crate) mod material;
pub(crate) mod peacock_film;
pub(crate) mod picture;
pub(crate) mod polarized;
pub(crate) mod simulation;
pub(crate) mod speckle;
pub(crate) mod treams;
