//! The fast simulation in figures, as `barbule bench campaign` prints them.
//! `cargo bench --workspace --bench campaign [SPECIES]`

#![allow(clippy::print_stdout)] // its output is its result

use barbule::material::Library;
use barbule::math::simd::Width;
use barbule::progress::Unobserved;
use barbule::structure::{SpeciesModel, Structure};
use barbule_bench::campaign::measure;

fn main() {
    let species = std::env::args().skip(1).find(|a| !a.starts_with('-')).unwrap_or_else(|| "starling".into());
    let structure = Structure::Species(Box::new(
        SpeciesModel::builtin(&species, None, Library::builtin()).expect("a known species"),
    ));
    let figures = measure(&structure, 1, Width::best(), &Unobserved).expect("figures");
    println!("{figures:#?}");
    println!("illuminations per CPU second: {:.0}", figures.illuminations_per_second());
}
