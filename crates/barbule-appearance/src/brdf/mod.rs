//! Feather BRDFs: the smooth lobe, its random instances, evaluation and sampling.
//!
//! [`fit::fit`] turns the [`Statistics`](crate::scattering::statistics::Statistics) of a campaign into a [`FeatherMaterial`],
//! the tables that a `.barbule` file holds; [`FeatherBrdf`] prepares one for evaluation. Directions are in the
//! barbule's frame (x across, y along, z up) and point away from the surface; values are in 1/sr without the cosine.

mod arrays;
mod batch;
mod container;
mod correlation;
mod evaluate;
mod exact;
mod file;
pub mod fit;
mod fitted;
mod fitted_node;
// What tests and benchmarks of several crates need, but no user.
#[doc(hidden)]
pub mod fixtures;
mod halo;
mod lanes;
mod length;
mod longitudinal;
mod marginal;
mod material;
mod noise;
mod patterns;
pub mod pictures;
mod plain;
mod profile;
mod report;
mod sample;
mod simd;
mod slope;
mod spectral;
mod steady;
mod table;
mod tables;

pub use arrays::{Numbers, TableArray};
pub use container::{checksum_of, container_checksum};
pub use evaluate::{FeatherBrdf, PreparedBrdf};
pub use exact::{ExactBrdf, Values, values};
pub use file::{decode_material, encode_material};
pub use halo::{HALO_SIGMAS, Halo, HaloAt, MOST_HALOS};
pub use marginal::{Marginal, marginals, reflected_fractions};
pub use material::{
    FeatherMaterial, LobeSet, NOISE_TERMS, ParameterSet, STEEPEST_FRACTION, SteadySet, achromatic_lengths,
    check_axes, check_sigma, table_axes,
};
pub use noise::{At, Draw, NOISE_SLICE, Noise, Spectral, spectrum as noise_spectrum};
pub use patterns::Synthesis;
pub use plain::PlainBrdf;
pub use profile::lobe_integral;
pub use tables::{BrdfTables, Options, Reciprocity, TABLES_VERSION, TablesHeader};
