//! `barbule validate`: how accurate the fast simulation is.

use std::io::Write;
use std::path::{Path, PathBuf};

use barbule::io::{make_folder, write_together};
use barbule::plot::Format;
use barbule::solve::full_wave;
use barbule::spectrum::Wavelengths;
use barbule::structure::{Beneath, Section, Structure};
use barbule::validate::{Plan, usual_azimuths};
use barbule::{Error, Result};
use serde_json::Value;

use crate::common::{Common, print, print_json};
use crate::progress::Terminal;
use crate::provenance::Provenance;
use crate::{sets, structure_arg};

/// The wavelengths that are compared unless others are asked for, nm: 400 to 694 in steps of 42.
const USUAL_NM: [f64; 8] = [400.0, 442.0, 484.0, 526.0, 568.0, 610.0, 652.0, 694.0];
/// And for a quick look.
const QUICK_NM: [f64; 3] = [400.0, 550.0, 694.0];
/// How wide species are then, µm.
const QUICK_WIDTH_UM: f64 = 6.0;

/// Azimuths of incidence, degrees.
const PHI_DEG: [f64; 3] = [0.0, 30.0, 60.0];

/// Arguments of `barbule validate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  barbule validate starling --full-wave --quick -o starling-quick\n  \
    barbule validate hummingbird:anna --full-wave --width 10 --layers 5 -o anna")]
pub(crate) struct Args {
    #[arg(help = structure_arg::HELP)]
    structure: String,
    /// Against full waves: Maxwell's equations on the same section
    #[arg(long, required = true)]
    full_wave: bool,
    /// Which random individual, from 0
    #[arg(long, value_name = "K", default_value_t = 0)]
    instance: usize,
    /// Width of a species' barbule in µm
    #[arg(long, value_name = "UM", value_parser = width)]
    width: Option<f64>,
    /// Number of layers of a species that has layers
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    layers: Option<u32>,
    /// Vacuum wavelengths in nm [default: 400:694:42]
    #[arg(long, value_name = "SET", value_parser = |text: &str| sets::wavelengths_of("--wavelengths", text).map(Nm))]
    wavelengths: Option<Nm>,
    /// Nodes per wavelength in the denser medium at each boundary
    #[arg(long, value_name = "N", default_value_t = full_wave::ELEMENTS_PER_WAVELENGTH, value_parser = super::far_field::elements)]
    elements: f64,
    /// A narrow barbule at three wavelengths: a starling in under a minute
    #[arg(long)]
    quick: bool,
    /// Folder for figures and numbers.json
    #[arg(short = 'o', long = "output", value_name = "FOLDER")]
    folder: PathBuf,
    #[command(flatten)]
    common: Common,
}

/// Vacuum wavelengths in nm, rising.
#[derive(Debug, Clone)]
struct Nm(Vec<f64>);

fn width(text: &str) -> std::result::Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|width| (1.0..=1000.0).contains(width));
    number.ok_or_else(|| format!("{text} is not a width from 1 to 1000 µm"))
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        let plan = self.plan()?;
        let cost = plan.cost(rayon::current_num_threads())?;
        let fewer = "a smaller --width, fewer --layers or --elements, or longer --wavelengths";
        self.common.allowance().check("this comparison", cost.bytes, fewer)?;
        for change in &plan.closed.changes {
            self.common.explain(change);
        }
        self.common.say(&format!(
            "full waves: {} unknowns and {:.2} GB at most, about {} in all",
            cost.unknowns,
            cost.bytes as f64 / 1e9,
            super::far_field::duration(cost.seconds)
        ));
        let progress = Terminal::new(&self.common);
        let comparison = plan.run(&progress)?;
        drop(progress);
        let mut numbers = comparison.numbers();
        let provenance = Provenance::new(&self.common);
        if let Value::Object(map) = &mut numbers {
            map.insert("made".into(), provenance.json());
        }
        let mut files: Vec<(PathBuf, Vec<u8>)> = Vec::new();
        for (name, drawing) in comparison.figures() {
            files.push((self.folder.join(name), drawing.encode(Format::Svg, &provenance.notes())?));
        }
        files.push((self.folder.join("numbers.json"), format!("{numbers:#}\n").into_bytes()));
        make_folder(&self.folder)?;
        let together: Vec<(&Path, &[u8])> = files.iter().map(|(path, bytes)| (&**path, &**bytes)).collect();
        write_together(&together)?;
        let words = format!("{} figures and numbers.json of {}", files.len() - 1, comparison.name);
        self.common.wrote(&self.folder, &words);
        if self.common.json { print_json(out, &numbers) } else { print(out, &comparison.table()) }
    }

    /// Everything that is compared, checked before any work.
    fn plan(&self) -> Result<Plan> {
        if self.folder.exists() && !self.folder.is_dir() {
            return Err(Error::input(format!("{}: is no folder; give another name", self.folder.display())));
        }
        let structure = structure_arg::parse(&self.structure, &self.common)?;
        let section = self.section(&structure)?;
        let nm = match &self.wavelengths {
            Some(Nm(nm)) => nm.clone(),
            None if self.quick => QUICK_NM.to_vec(),
            None => USUAL_NM.to_vec(),
        };
        let azimuths = usual_azimuths(&section, nm.iter().copied().fold(f64::INFINITY, f64::min));
        let closed = section.closed(Beneath::Absorbing)?;
        if closed.fast.boundaries.is_empty() {
            return Err(Error::input(format!(
                "{}: the section has no top boundary, which the fast simulation needs; give one with boundaries",
                self.structure
            )));
        }
        Ok(Plan {
            name: section.name.clone(),
            closed,
            wavelengths: Wavelengths::new(nm)?,
            phi_i: PHI_DEG.map(f64::to_radians).to_vec(),
            azimuths,
            elements_per_wavelength: self.elements,
            memory_bytes: self.common.allowance().bytes,
        })
    }

    fn section(&self, structure: &Structure) -> Result<Section> {
        let Structure::Species(model) = structure else {
            if self.width.is_some() || self.layers.is_some() {
                return Err(Error::input(
                    "--width and --layers change species; a section is validated as it is, so leave them out",
                ));
            }
            return structure.instance(self.common.seed, self.instance);
        };
        let quick = self.quick.then_some(QUICK_WIDTH_UM.min(model.width_um()));
        let mut model = (**model).clone();
        if let Some(width_um) = self.width.or(quick) {
            model = model.with_parameters(&[("width_um", width_um.into())])?;
        }
        if let Some(layers) = self.layers {
            let by = |key| model.with_parameters(&[(key, Value::from(layers))]);
            model = by("layers").or_else(|_| by("rows"))?;
        }
        model.section(self.common.seed, self.instance)
    }
}
