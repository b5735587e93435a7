//! The commands, one file each.

use std::io::Write;

use barbule::Result;
use clap::Subcommand;

mod atlas;
mod bench;
mod birds;
mod brdf;
mod cache;
mod characterize;
mod completions;
mod crystal;
mod diffract;
mod export;
mod far_field;
mod feather;
mod film;
mod fit;
mod fit_structure;
mod geometry;
mod keys;
mod lobes;
mod man;
mod render;
mod see;
mod simulate;
mod species;
mod spectrum;
mod trace;
mod validate;
mod view;

/// A command with its arguments.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Reflection, transmission and absorption of a stack of flat layers
    Film(film::Args),
    /// Pictures of a material's BRDF, parameters, noise and fits
    Lobes(lobes::Args),
    /// Values of a material's BRDF: f, its steady part, sampling densities, marginals
    Brdf(brdf::Args),
    /// The far field of one instance at one wavelength and direction
    FarField(far_field::Args),
    /// Reflectance against wavelength, mean and spread over instances
    Spectrum(spectrum::Args),
    /// Whether a bird tells things apart: catches, just noticeable differences, hues
    See(see::Args),
    /// Whose eyes are known, and what their cones answer to
    Birds(birds::Args),
    /// What a photonic crystal reflects: one point, a map, or the field inside
    Crystal(crystal::Args),
    /// What a heightfield does with light: colours, tables, a material
    Diffract(diffract::Args),
    /// A material in files of other programs, and how near these come
    Export(export::Args),
    /// Simulate a whole campaign into a store that survives interruptions
    Simulate(simulate::Args),
    /// Fit a material to a finished store
    Fit(fit::Args),
    /// From measured spectra to the sizes of what reflected them
    FitStructure(fit_structure::Args),
    /// Simulate and fit: from a structure to its material
    Characterize(characterize::Args),
    /// Sweep sizes of a structure into one store: spectra, colours, maps, a page
    Atlas(atlas::Args),
    /// List or clear the materials computed on first use
    Cache(cache::Args),
    /// A cross section, drawn to scale or as JSON
    Geometry(geometry::Args),
    /// From a micrograph to a section, a lattice or layers that simulate
    Trace(trace::Args),
    /// The species that are built in, with their colours
    Species(species::Args),
    /// A feather's geometry in a file, or its measures beside their sources
    Feather(feather::Args),
    /// Print completions for a shell
    Completions(completions::Args),
    /// Print pages of the manual, or write them into a folder
    Man(man::Args),
    /// The keys of scenes, species and plans of atlases: listings, schemas for editors
    Keys(keys::Args),
    /// Render a picture of a feather
    Render(render::Args),
    /// Open the viewer: structures, materials and feathers in a window
    View(view::Args),
    /// How accurate the fast simulation is: against full waves
    Validate(validate::Args),
    /// Speed in figures
    Bench(bench::Args),
}

impl Command {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        match self {
            Self::Film(args) => args.run(out),
            Self::Lobes(args) => args.run(out),
            Self::Brdf(args) => args.run(out),
            Self::FarField(args) => args.run(out),
            Self::Spectrum(args) => args.run(out),
            Self::See(args) => args.run(out),
            Self::Birds(args) => args.run(out),
            Self::Crystal(args) => args.run(out),
            Self::Diffract(args) => args.run(out),
            Self::Export(args) => args.run(out),
            Self::Simulate(args) => args.run(out),
            Self::Fit(args) => args.run(out),
            Self::FitStructure(args) => args.run(out),
            Self::Characterize(args) => args.run(out),
            Self::Atlas(args) => args.run(out),
            Self::Cache(args) => args.run(out),
            Self::Geometry(args) => args.run(out),
            Self::Trace(args) => args.run(out),
            Self::Species(args) => args.run(out),
            Self::Feather(args) => args.run(out),
            Self::Completions(args) => args.run(out),
            Self::Man(args) => args.run(out),
            Self::Keys(args) => args.run(out),
            Self::Render(args) => args.run(out),
            Self::View(args) => args.run(),
            Self::Validate(args) => args.run(out),
            Self::Bench(args) => args.run(out),
        }
    }
}
