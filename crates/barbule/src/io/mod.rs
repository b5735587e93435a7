//! The only module that opens files.

mod arrays;
mod assets;
mod brdf_tables;
mod bsdf;
mod cache;
mod curves;
mod denoiser;
mod eye;
mod feather;
mod grating;
mod heights;
pub mod image;
mod kind;
mod lattice;
mod ledger;
mod machine;
mod material;
pub mod measured;
mod media;
mod mesh;
mod micrograph;
mod named;
mod orders;
mod output;
mod radiance;
mod section;
mod sensor;
mod species;
mod stack;
pub mod store;
pub mod sweep;
pub mod tables;
mod temporary;
mod units;
pub mod web;
mod whole;
mod zarr;

pub use crate::brdf::{decode_material, encode_material};
pub use arrays::{Coordinate, LabelledArrays, Numbers, Quantity, check_new_zarr, write_zarr};
pub use assets::{Assets, Folder, Memory};
pub use brdf_tables::{decode_tables, encode_tables, read_tables, write_tables};
pub use bsdf::{LARGEST_BSDF, decode_bsdf, encode_bsdf, rgl_arrays};
pub use cache::{CacheFile, delete_file, list_cache};
pub use curves::{LARGEST_CURVES, curves_text, decode_curves, foretell_curves, parse_curves, read_curves};
pub use denoiser::{Denoiser, Noisy, Plane};
pub use eye::read_eye;
pub use feather::{
    FEW_BARBULES, FeatherFormat, MOST_WRITTEN_BARBULES, UsdLook, WRITTEN_IDENTITY, foretell_written,
    write_feather, write_usd,
};
pub use grating::{GratingFile, LARGEST_GRATING, decode_grating, read_grating, write_grating};
pub use heights::{Clean, HeightUnit, HeightsOptions, foretell_heights, read_heights};
pub use kind::{InputKind, kind_of};
pub use lattice::{lattice_toml, read_lattice};
pub use ledger::{Ledger, claim_output, note_input};
pub use machine::{available_memory, peak_memory};
pub use material::{read_material, write_material};
pub use mesh::{decode_mesh, foretell_mesh, read_mesh};
pub use micrograph::{decode_micrograph, read_micrograph};
pub use named::files_in;
pub use orders::{read_keyed_orders, read_orders, write_orders};
pub use output::{check_writable, is_inside_store, is_same_file, is_stream, write_together, write_whole};
pub use section::{parse_section, read_section, read_sections, section_json, write_section};
pub use sensor::read_sensor;
pub use species::{
    Shown, feather_of, is_species, read_flat_stack, read_shown, read_species, read_species_file,
    read_structure_toml, shown_of,
};
pub use stack::{parse_stack, read_stack};
pub use units::{HASH_DIGITS, Units};
pub use whole::{
    LARGEST_INPUT, bytes_of, endings_beside, hash_bytes, hash_file, make_folder, read_at_most, read_bytes,
    read_own, read_text,
};
