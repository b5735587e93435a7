//! `barbule._native`: what the Python package `barbule` is made of.
//!
//! Each module is one subject. Functions take and give plain NumPy arrays and names; labels, units and documentation are
//! in `python/barbule`. Whatever may take longer than 10 ms runs without the interpreter's lock ([`work`]).

mod arrays;
mod atlas;
mod batch;
mod campaign;
mod colour;
mod crystal;
mod diffraction;
mod error;
mod export;
mod field;
mod film;
mod inverse;
mod make;
mod material;
mod measured;
mod opening;
mod parts;
mod program;
mod scene;
mod spectrum;
mod structure;
mod trace;
mod validate;
mod vision;
mod work;

/// What `barbule` is made of. Private: use `barbule`.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use super::atlas::{AtlasUnits, atlas, foretell_atlas};
    #[pymodule_export]
    use super::campaign::{Campaign, simd};
    #[pymodule_export]
    use super::colour::{colour_doubt, delta_e_2000, xyz_of};
    #[pymodule_export]
    use super::crystal::crystal;
    #[pymodule_export]
    use super::diffraction::Heights;
    #[pymodule_export]
    use super::export::export;
    #[pymodule_export]
    use super::field::far_fields;
    #[pymodule_export]
    use super::film::{film, film_gradients};
    #[pymodule_export]
    use super::inverse::fit_structure;
    #[pymodule_export]
    use super::make::{characterize, fit, simulate};
    #[pymodule_export]
    use super::material::{Material, keratin_boundary, read_tables};
    #[pymodule_export]
    use super::measured::{compare, intervals, measured};
    #[pymodule_export]
    use super::opening::{open, species};
    #[pymodule_export]
    use super::parts::Parts;
    #[pymodule_export]
    use super::program::{run, version};
    #[pymodule_export]
    use super::scene::{Picture, Scene, presets};
    #[pymodule_export]
    use super::spectrum::{angle_law, material_readings, readings, spectra};
    #[pymodule_export]
    use super::structure::{Section, Structure};
    #[pymodule_export]
    use super::trace::{Traced, trace};
    #[pymodule_export]
    use super::validate::Comparison;
    #[pymodule_export]
    use super::vision::{catches, eye, eye_names, jnd, tetrahedral, things};
}
