//! `barbule geometry`: a cross section as a picture or as JSON.

use std::io::Write;
use std::path::PathBuf;

use barbule::figures;
use barbule::io::{check_writable, section_json, write_section};
use barbule::plot::{Drawing, Format};
use barbule::structure::{GeneratorParameters, Structure};
use barbule::{Error, Result};

use crate::common::{Common, print_json};
use crate::provenance::Provenance;
use crate::structure_arg;

/// Arguments of `barbule geometry`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  barbule geometry starling:pink --instance 3 -o starling.svg")]
pub(crate) struct Args {
    #[arg(help = structure_arg::HELP)]
    structure: String,
    /// Which random individual, or which file of a folder; the first is 0
    #[arg(long, value_name = "K", default_value_t = 0)]
    instance: usize,
    /// A segment in three dimensions (not in this version)
    #[arg(long)]
    three_d: bool,
    /// Where to: a picture (.svg, .png) or the section itself (.json)
    #[arg(short, long, value_name = "F")]
    output: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        if self.three_d {
            return Err(Error::input(
                "geometry --three-d: segments in three dimensions are not made by this version yet; leave --three-d out",
            ));
        }
        if self.output.is_none() && !self.common.json {
            return Err(Error::input(
                "geometry: say where to write with -o F.svg, F.png or F.json, or give --json",
            ));
        }
        let is_json = |path: &PathBuf| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
        if let Some(path) = &self.output {
            if !is_json(path) {
                Format::of(path).map_err(|_| {
                    Error::input(format!(
                        "{}: geometry writes .svg, .png or .json; end the name with one of these",
                        path.display()
                    ))
                })?;
            }
            check_writable(path)?;
        }
        let structure = structure_arg::parse(&self.structure, &self.common)?;
        let section = structure.instance(self.common.seed, self.instance)?;
        if let Some(path) = &self.output {
            if is_json(path) {
                write_section(path, &section)?;
            } else {
                let provenance = Provenance::new(&self.common).with("structure_hash", structure.hash());
                let sketch = sketch(&structure, self.common.seed)?;
                let drawing = figures::section(&section, &section.name, sketch.as_ref());
                provenance.write_figure(path, &drawing)?;
            }
            self.common.wrote(path, &format!("the section {}", section.name));
        }
        if self.common.json { print_json(out, &section_json(&section)) } else { Ok(()) }
    }
}

/// The parameter sketch of a hummingbird.
fn sketch(structure: &Structure, seed: u64) -> Result<Option<Drawing>> {
    let Structure::Species(model) = structure else { return Ok(None) };
    let GeneratorParameters::Hummingbird(parameters) = &model.parameters else { return Ok(None) };
    let mut regular = (**model).clone();
    regular.parameters = GeneratorParameters::Hummingbird(parameters.without_randomness());
    Ok(Some(figures::hummingbird_sketch(parameters, &regular.section(seed, 0)?)))
}
