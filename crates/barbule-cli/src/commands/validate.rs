//! `barbule validate`: how accurate the fast simulation is.

use std::io::Write;
use std::path::{Path, PathBuf};

use barbule::characterize::CampaignOptions;
use barbule::clock;
use barbule::error::shortened;
use barbule::io::{Units, claim_output, files_in, make_folder, write_together};
use barbule::open::Located;
use barbule::plot::{Drawing, Format};
use barbule::progress::{Progress, Shard};
use barbule::solve::cost::Cost;
use barbule::solve::full_wave::{ELEMENTS_PER_WAVELENGTH, FullWave};
use barbule::solve::{FAST, SHADOWED};
use barbule::spectrum::Wavelengths;
use barbule::structure::{Beneath, Ends, Smoothing, SpeciesModel, Structure};
use barbule::validate::{Plan, done_of_part, run_all, solve_part, three_d, usual_azimuths};
use barbule::{Error, Result};
use serde_json::{Value, json};

use crate::common::{Common, duration, print, print_json};
use crate::materials;
use crate::progress::Terminal;
use crate::provenance::Provenance;
use crate::segment_args::SegmentArgs;
use crate::{sets, shard, structure_arg};

/// The wavelengths of full waves unless others are asked for: first, step (nm) and number. In steps of 24.5 nm colours can still be told.
const USUAL_NM: [f64; 3] = [400.0, 12.0, 25.0];
const QUICK_NM: [f64; 3] = [400.0, 24.5, 13.0];
/// Those of segments, nm.
const SEGMENTS_NM: [f64; 8] = [400.0, 442.0, 484.0, 526.0, 568.0, 610.0, 652.0, 694.0];
const QUICK_SEGMENTS_NM: [f64; 3] = [400.0, 550.0, 694.0];
/// How wide species are in a quick look, µm.
const QUICK_WIDTH_UM: f64 = 6.0;

/// Azimuths of incidence, degrees. On 6 µm no beam comes from 60° alone.
const PHI_DEG: [f64; 3] = [0.0, 30.0, 60.0];
const QUICK_PHI_DEG: [f64; 2] = [0.0, 30.0];

/// How many segments are averaged.
const USUAL_INSTANCES: usize = 50;
const QUICK_INSTANCES: usize = 10;

/// θ_i and φ_i of the light on segments, degrees.
const DIRECTIONS_DEG: [[f64; 2]; 3] = [[0.0, 0.0], [0.0, 30.0], [30.0, 30.0]];

/// Arguments of `barbule validate`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  barbule validate starling --full-wave --quick -o starling-quick\n  \
    barbule validate hummingbird:anna --full-wave --width 10 --layers 5 --ensemble 5 -o anna\n  \
    barbule validate starling --three-d --quick -o starling-three-d\n\n\
    What is done is kept in the folder's `units`: after Ctrl-C the same command goes on. With --shard i/n several processes, on machines \
    that share the folder, compute a part each; the command without it then draws.")]
#[command(group = clap::ArgGroup::new("against").required(true).args(["full_wave", "three_d"]))]
pub(crate) struct Args {
    #[arg(help = structure_arg::HELP)]
    structure: String,
    /// Against full waves: Maxwell's equations on the same section
    #[arg(long)]
    full_wave: bool,
    /// Against segments in three dimensions, which are not invariant along the barbule
    #[arg(long)]
    three_d: bool,
    /// With segments that are invariant all the same
    #[arg(long, conflicts_with = "full_wave")]
    invariant: bool,
    /// The material to compare segments with [default: that of the structure, where it is at hand]
    #[arg(long, value_name = "M", conflicts_with = "full_wave")]
    material: Option<String>,
    /// How many segments [default: 50, --quick 10]
    #[arg(long, value_name = "N", conflicts_with = "full_wave", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    instances: Option<u32>,
    #[command(flatten)]
    segment: SegmentArgs,
    /// Which random individual meets full waves, from 0
    #[arg(long, value_name = "K", default_value_t = 0, conflicts_with = "three_d")]
    instance: usize,
    /// Compare so many individuals, from that one on: means and spreads
    #[arg(long, value_name = "N", conflicts_with = "three_d", value_parser = clap::value_parser!(u32).range(1..=1000))]
    ensemble: Option<u32>,
    /// How layers end at the sides: in air, or in walls that close the barbule's outline
    #[arg(long, value_name = "ENDS", value_enum, default_value_t = EndsArg::Open, conflicts_with = "three_d")]
    ends: EndsArg,
    /// Azimuths of the light on full waves in degrees [default: 0,30,60, --quick 0,30]
    #[arg(long, value_name = "SET", allow_hyphen_values = true, conflicts_with = "three_d",
        value_parser = |text: &str| sets::angles("--phi", text))]
    phi: Option<sets::Angles>,
    /// Width of a species' barbule in µm
    #[arg(long, value_name = "UM", value_parser = width)]
    width: Option<f64>,
    /// Number of layers of a species that has layers
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    layers: Option<u32>,
    /// Vacuum wavelengths in nm [default: 400:694:12, --three-d 400:694:42]
    #[arg(long, value_name = "SET", value_parser = |text: &str| sets::wavelengths_of("--wavelengths", text).map(Nm))]
    wavelengths: Option<Nm>,
    /// Nodes per wavelength in the denser medium at each boundary
    #[arg(long, value_name = "N", default_value_t = ELEMENTS_PER_WAVELENGTH, conflicts_with = "three_d",
        value_parser = super::far_field::elements)]
    elements: f64,
    /// Let the top stand in its own light in the fast simulation's formulas, evaluated plainly (slower)
    #[arg(long, conflicts_with = "three_d")]
    shadowing: bool,
    #[arg(long, value_name = "UM", conflicts_with = "three_d", value_parser = structure_arg::smoothing, help = structure_arg::SMOOTH)]
    smooth: Option<Smoothing>,
    /// Less of all: a barbule 6 µm wide at 13 wavelengths from 0° and 30° against full waves, few segments at three wavelengths
    #[arg(long)]
    quick: bool,
    /// Only compute and keep part i of n (i from 0), for several processes on one folder
    #[arg(long, value_name = "i/n", allow_hyphen_values = true, value_parser = shard::parse)]
    shard: Option<Shard>,
    /// Say how much of the work is done, with --shard of that part, and do nothing
    #[arg(long)]
    status: bool,
    /// Folder for figures, numbers.json and tables
    #[arg(short = 'o', long = "output", value_name = "FOLDER")]
    folder: PathBuf,
    #[command(flatten)]
    common: Common,
}

/// How layers end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum EndsArg {
    Open,
    Closed,
}

/// The folder, in that of the figures, in which what is done is kept.
const UNITS: &str = "units";

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
        if self.folder.exists() && !self.folder.is_dir() {
            return Err(Error::input(format!("{}: is no folder; give another name", self.folder.display())));
        }
        // What a figure may take the place of is known before anything is read.
        let figures = files_in(&self.folder, "svg");
        let tables = ["numbers.json", "numbers.csv", "patterns.csv"].map(|name| self.folder.join(name));
        for path in figures.iter().chain(&tables) {
            claim_output(path, &format!("-o {}", path.display()))?;
        }
        if self.three_d { self.three_d(out) } else { self.full_wave(out) }
    }

    fn full_wave(&self, out: &mut dyn Write) -> Result<()> {
        self.segment.check_unused()?;
        let plans = self.plans()?;
        let threads = rayon::current_num_threads();
        let mut cost = Cost::default();
        for plan in &plans {
            cost = plan.costs(threads)?.into_iter().fold(cost, Cost::then);
        }
        let fewer = "a smaller --width, fewer --layers or --elements, or longer --wavelengths";
        self.common.allowance().check("this comparison", cost.bytes, fewer)?;
        for change in &plans[0].closed.changes {
            self.common.explain(change);
        }
        self.common.say(&format!(
            "full waves: {} unknowns and {:.2} GB at most, about {} in all",
            cost.unknowns,
            cost.bytes as f64 / 1e9,
            duration(cost.seconds.unwrap_or_default())
        ));
        let units = self.units();
        let count = plans.iter().map(|plan| plan.wavelengths.len()).sum();
        let what = if plans.len() > 1 { "individuals' wavelengths" } else { "wavelengths" };
        let done = || plans.iter().map(|plan| plan.done(&units)).sum();
        if let Some(shard) = self.part() {
            let of_part = || done_of_part(&plans, shard, &units);
            return self
                .compute(out, what, &of_part, &|progress| solve_part(&plans, shard, &units, progress));
        }
        self.say_found(done(), count, what);
        let progress = Terminal::new(&self.common);
        let ensemble = run_all(&plans, Some(&units), &progress);
        drop(progress);
        let ensemble = ensemble.map_err(|error| interrupted(error, done, count, what))?;
        let tables = [("numbers.csv", ensemble.csv()), ("patterns.csv", ensemble.patterns_csv())];
        let name = &plans[0].name;
        self.write(out, name, ensemble.numbers(), ensemble.figures(), &tables, &ensemble.table())
    }

    /// Against segments.
    fn three_d(&self, out: &mut dyn Write) -> Result<()> {
        let plan = self.three_d_plan()?;
        let cost = plan.cost(rayon::current_num_threads())?;
        let fewer = "a smaller --length or longer --wavelengths";
        self.common.allowance().check("this comparison", cost.bytes, fewer)?;
        let [across, along] = plan.cells()?;
        self.common.say(&format!(
            "{} far fields of segments of up to {across} × {along} cells, {:.2} GB at most",
            plan.count(),
            cost.bytes as f64 / 1e9
        ));
        let (units, count) = (self.units(), plan.count());
        if let Some(shard) = self.part() {
            let of_part = || Ok(plan.done_of_part(shard, &units));
            return self
                .compute(out, "far fields", &of_part, &|progress| plan.run_part(shard, &units, progress));
        }
        self.say_found(plan.done(&units), count, "far fields");
        let progress = Terminal::new(&self.common);
        let comparison = plan.run(Some(&units), &progress);
        drop(progress);
        let comparison =
            comparison.map_err(|error| interrupted(error, || plan.done(&units), count, "far fields"))?;
        let name = comparison.plan.structure.name();
        self.write(out, &name, comparison.numbers(), comparison.figures(), &[], &comparison.table())
    }

    /// The part of the work that is asked for or about, where nothing is to be drawn.
    fn part(&self) -> Option<Shard> {
        self.shard.or(self.status.then_some(Shard::WHOLE))
    }

    /// Computes and keeps a part of the work, unless only its state is asked for; says how many of its units are there, and how many it has.
    fn compute(
        &self,
        out: &mut dyn Write,
        what: &str,
        of_part: &dyn Fn() -> Result<[usize; 2]>,
        work: &dyn Fn(&dyn Progress) -> Result<()>,
    ) -> Result<()> {
        let [found, count] = of_part()?;
        if !self.status && found < count {
            self.say_found(found, count, what);
            let progress = Terminal::new(&self.common);
            let outcome = work(&progress);
            drop(progress);
            let done = || of_part().map_or(0, |[done, _]| done);
            outcome.map_err(|error| interrupted(error, done, count, what))?;
            let words =
                format!("{} of {count} {what} of its part; the command without --shard draws", done());
            self.common.wrote(&self.folder.join(UNITS), &words);
        } else if !self.status {
            self.common.say("everything is there already: nothing to do");
        }
        let [done, _] = if self.status { [found, count] } else { of_part()? };
        if self.common.json {
            let missing = count - done;
            return print_json(out, &json!({"units": count, "done": done, "missing": missing}));
        }
        if self.status {
            return print(out, &format!("{done} of {count} {what} done, {} missing", count - done));
        }
        Ok(())
    }

    /// Where what is done is kept.
    fn units(&self) -> Units {
        Units::new(&self.folder.join(UNITS))
    }

    fn say_found(&self, done: usize, count: usize, what: &str) {
        if done > 0 {
            self.common.say(&format!("{done} of {count} {what} are there from before"));
        }
    }

    fn three_d_plan(&self) -> Result<three_d::Plan> {
        // Segments take each column for itself, and so does what they are held against.
        let structure = structure_arg::parse(&self.structure, &self.common)?.smoothed(Smoothing::Off);
        let structure = self.narrowed(structure, None)?;
        let most = if self.quick { QUICK_INSTANCES } else { USUAL_INSTANCES };
        let asked = self.instances.map_or(most, |count| count as usize);
        // A changed species has no material of its own.
        let is_as_named = self.width.is_none() && self.layers.is_none();
        let name = self.material.as_ref().or(is_as_named.then_some(&self.structure));
        let material = match name.map(|name| materials::locate(name, &self.common)).transpose()? {
            Some(Located::There(found)) => Some(Box::new(found.material)),
            _ => {
                self.common.explain(
                    "no material of this structure is at hand; the BRDF is left out of the pictures",
                );
                None
            }
        };
        let roughness = self.segment.roughness(self.invariant)?;
        Ok(three_d::Plan {
            seed: self.common.seed,
            instances: structure.count().map_or(asked, |given| asked.min(given)),
            wavelengths: Wavelengths::new(self.nm())?,
            directions: DIRECTIONS_DEG.map(|direction| direction.map(f64::to_radians)).to_vec(),
            length_um: self.segment.length_um(&structure),
            roughness,
            // The BRDF contains it.
            tilt: CampaignOptions::default().tilt_deg.to_radians(),
            material,
            structure,
        })
    }

    /// Writes figures and numbers, and prints the numbers or their table.
    fn write(
        &self,
        out: &mut dyn Write,
        name: &str,
        mut numbers: Value,
        figures: Vec<(String, Drawing)>,
        tables: &[(&str, String)],
        table: &str,
    ) -> Result<()> {
        let provenance = Provenance::new(&self.common);
        if let Value::Object(map) = &mut numbers {
            map.insert("made".into(), provenance.json());
        }
        let mut files: Vec<(PathBuf, Vec<u8>)> = Vec::new();
        for (file, drawing) in figures {
            files.push((self.folder.join(file), drawing.encode(Format::Svg, &provenance.notes())?));
        }
        let of_figures = files.len();
        files.extend(tables.iter().map(|(file, text)| (self.folder.join(file), text.clone().into_bytes())));
        files.push((self.folder.join("numbers.json"), format!("{numbers:#}\n").into_bytes()));
        make_folder(&self.folder)?;
        let together: Vec<(&Path, &[u8])> = files.iter().map(|(path, bytes)| (&**path, &**bytes)).collect();
        write_together(&together)?;
        let words = format!("{of_figures} figures, numbers.json and tables of {name}");
        self.common.wrote(&self.folder, &words);
        if self.common.json { print_json(out, &numbers) } else { print(out, table) }
    }

    fn nm(&self) -> Vec<f64> {
        let evenly =
            |[first, step, count]: [f64; 3]| (0..count as u32).map(|i| first + step * f64::from(i)).collect();
        match (&self.wavelengths, self.three_d, self.quick) {
            (Some(Nm(nm)), _, _) => nm.clone(),
            (None, true, true) => QUICK_SEGMENTS_NM.to_vec(),
            (None, true, false) => SEGMENTS_NM.to_vec(),
            (None, false, true) => evenly(QUICK_NM),
            (None, false, false) => evenly(USUAL_NM),
        }
    }

    /// Azimuths of incidence, rad, rising and none twice.
    fn phi_i(&self) -> Vec<f64> {
        let mut degrees = match &self.phi {
            Some(sets::Angles(degrees)) => degrees.clone(),
            None if self.quick => QUICK_PHI_DEG.to_vec(),
            None => PHI_DEG.to_vec(),
        };
        degrees.sort_by(f64::total_cmp);
        degrees.dedup();
        degrees.into_iter().map(f64::to_radians).collect()
    }

    /// Everything that is compared, checked before any work.
    fn plans(&self) -> Result<Vec<Plan>> {
        let structure = structure_arg::parse(&self.structure, &self.common)?;
        let structure = self.smooth.into_iter().fold(structure, Structure::smoothed);
        let quick = self.quick.then_some(QUICK_WIDTH_UM.min(structure.width_um()));
        let structure = self.narrowed(structure, quick)?;
        let count = self.ensemble.map_or(1, |count| count as usize);
        (self.instance..self.instance + count).map(|instance| self.plan(&structure, instance)).collect()
    }

    fn plan(&self, structure: &Structure, instance: usize) -> Result<Plan> {
        let section = structure.instance(self.common.seed, instance)?;
        let nm = self.nm();
        let azimuths = usual_azimuths(&section, nm.iter().copied().fold(f64::INFINITY, f64::min));
        let ends = match self.ends {
            EndsArg::Open => Ends::Open,
            EndsArg::Closed => Ends::Closed,
        };
        let closed = section.closed(Beneath::Absorbing, ends)?;
        if closed.fast.boundaries.is_empty() {
            return Err(Error::input(format!(
                "{}: the section has no top boundary, which the fast simulation needs; give one with boundaries",
                self.structure
            )));
        }
        let plan = Plan {
            name: section.name.clone(),
            instance,
            closed,
            wavelengths: Wavelengths::new(nm)?,
            phi_i: self.phi_i(),
            azimuths,
            full: FullWave {
                elements_per_wavelength: self.elements,
                memory_bytes: self.common.allowance().bytes,
                clock: clock::system,
            },
            method: if self.shadowing { SHADOWED } else { FAST },
        };
        plan.check_beams().map_err(|error| error.at("--phi"))?;
        Ok(plan)
    }

    /// The structure with another width and number of layers; as wide as `usual` where nothing is asked.
    fn narrowed(&self, structure: Structure, usual: Option<f64>) -> Result<Structure> {
        let Structure::Species(model) = structure else {
            if self.width.is_some() || self.layers.is_some() {
                return Err(Error::input(
                    "--width and --layers change species; a section is validated as it is, so leave them out",
                ));
            }
            return Ok(structure);
        };
        let mut model = *model;
        if let Some(width_um) = self.width.or(usual) {
            model = model.with_parameters(&[("width_um", width_um.into())])?;
        }
        if let Some(layers) = self.layers {
            model = with_layers(&model, layers)?;
        }
        Ok(Structure::Species(Box::new(model)))
    }
}

/// Ctrl-C: what is kept, and how it goes on.
fn interrupted(error: Error, done: impl Fn() -> usize, count: usize, what: &str) -> Error {
    if !error.is_interrupted() {
        return error;
    }
    Error::interrupted_after(format!("{} of {count} {what} are kept; the same command goes on", done()))
}

/// The species with so many layers or rows, where it counts them.
fn with_layers(model: &SpeciesModel, count: u32) -> Result<SpeciesModel> {
    let parameters = serde_json::to_value(&model.parameters)
        .map_err(|error| Error::machine(format!("parameters cannot be written: {error}")))?;
    if let Some(key) = ["layers", "rows"].into_iter().find(|key| parameters[*key].is_number()) {
        return model.with_parameters(&[(key, count.into())]).map_err(|error| error.at("--layers"));
    }
    let title = model.title();
    let what = if parameters["layers"].is_array() {
        "lists its layers one by one, so no number changes them; take some out of `layers` in its file"
    } else {
        "has neither layers nor rows that are counted; leave it out"
    };
    Err(Error::input(format!("--layers {count}: {} {what}", shortened(&title))))
}
