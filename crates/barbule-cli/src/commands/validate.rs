//! `barbule validate`: how accurate the fast simulation is.

use std::io::Write;
use std::path::PathBuf;

use barbule::clock;
use barbule::io::Units;
use barbule::math::simd::Width;
use barbule::open::Located;
use barbule::progress::Shard;
use barbule::solve::full_wave::ELEMENTS_PER_WAVELENGTH;
use barbule::structure::{Ends, Smoothing};
use barbule::validate::three_d::{Plan, SegmentOptions};
use barbule::validate::{Comparing, FullWaveOptions, FullWaves, UNITS, units_in};
use barbule::{Error, Result};
use serde_json::json;

use crate::common::{Common, duration, print, print_json};
use crate::materials;
use crate::progress::Terminal;
use crate::provenance::Provenance;
use crate::segment_args::SegmentArgs;
use crate::{sets, shard, structure_arg};

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
    /// SIMD instructions to compute segments with, alike on all machines of one folder [default: the widest of this processor]
    #[arg(long, value_name = "NAME", conflicts_with = "full_wave", value_parser = Width::named)]
    simd: Option<Width>,
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
        let units = units_in(&self.folder)?;
        if self.three_d {
            return self.compare(out, &self.segments()?, &units);
        }
        self.segment.check_unused()?;
        self.compare(out, &self.full_waves()?, &units)
    }

    /// Against full waves, within the memory that there is; says what they take.
    fn full_waves(&self) -> Result<FullWaves> {
        let structure = structure_arg::parse(&self.structure, &self.common)?;
        let options = FullWaveOptions {
            wavelengths_nm: self.nm(),
            phi_deg: self.phi.as_ref().map(|sets::Angles(degrees)| degrees.clone()),
            width_um: self.width,
            layers: self.layers,
            elements_per_wavelength: self.elements,
            ends: match self.ends {
                EndsArg::Open => Ends::Open,
                EndsArg::Closed => Ends::Closed,
            },
            shadowing: self.shadowing,
            smooth_um: self.smooth.map(|smoothing| smoothing.deviation_um(None).unwrap_or(0.0)),
            instance: self.instance,
            individuals: self.ensemble.map_or(1, |count| count as usize),
            quick: self.quick,
            seed: self.common.seed,
        };
        let plan = options.plan(structure, self.common.allowance().bytes, clock::system)?;
        let cost = plan.total_cost(rayon::current_num_threads(), &Terminal::new(&self.common))?;
        let fewer = "a smaller --width, fewer --layers or --elements, or longer --wavelengths";
        self.common.allowance().check("this comparison", cost.bytes, fewer)?;
        for change in &plan.individuals()[0].closed.changes {
            self.common.explain(change);
        }
        self.common.say(&format!(
            "full waves: {} unknowns and {:.2} GB at most, about {} in all",
            cost.unknowns,
            cost.bytes as f64 / 1e9,
            duration(cost.seconds.unwrap_or_default())
        ));
        Ok(plan)
    }

    /// Against segments, within the memory that there is; says what they take.
    fn segments(&self) -> Result<Plan> {
        let structure = structure_arg::parse(&self.structure, &self.common)?;
        let roughness = self.segment.roughness(self.invariant)?;
        let options = SegmentOptions {
            wavelengths_nm: self.nm(),
            width_um: self.width,
            layers: self.layers,
            instances: self.instances.map(|count| count as usize),
            length_um: self.segment.length_asked_um(),
            roughness_um: roughness.amplitude_um,
            correlation_um: roughness.correlation_um,
            quick: self.quick,
            seed: self.common.seed,
        };
        let name = self.material.as_ref().or(options.is_as_named().then_some(&self.structure));
        let material = match name.map(|name| materials::locate(name, &self.common)).transpose()? {
            Some(Located::There(found)) => Some(Box::new(found.material)),
            _ => {
                self.common.explain(
                    "no material of this structure is at hand; the BRDF is left out of the pictures",
                );
                None
            }
        };
        let plan = options.plan(structure, material, self.simd.unwrap_or_default(), clock::system)?;
        let cost = plan.total_cost(rayon::current_num_threads(), &Terminal::new(&self.common))?;
        let fewer = "a smaller --length or longer --wavelengths";
        self.common.allowance().check("this comparison", cost.bytes, fewer)?;
        let [across, along] = plan.cells()?;
        self.common.say(&format!(
            "{} far fields of segments of up to {across} × {along} cells, {:.2} GB at most",
            plan.count(),
            cost.bytes as f64 / 1e9
        ));
        Ok(plan)
    }

    /// Computes a part or says its state, or computes and draws everything.
    fn compare(&self, out: &mut dyn Write, plan: &dyn Comparing, units: &Units) -> Result<()> {
        // Where only the state is asked for, nothing is drawn.
        if let Some(shard) = self.shard.or(self.status.then_some(Shard::WHOLE)) {
            return self.part(out, plan, shard, units);
        }
        let (count, what) = (plan.units(), plan.what());
        self.say_found(plan.done(units), count, what);
        let progress = Terminal::new(&self.common);
        let compared = plan.finish(Some(units), &progress);
        drop(progress);
        let mut compared = compared.map_err(|error| interrupted(error, || plan.done(units), count, what))?;
        let provenance = Provenance::new(&self.common);
        compared.write(&self.folder, provenance.json(), &provenance.notes())?;
        let (figures, name) = (compared.figures.len(), &compared.name);
        self.common.wrote(&self.folder, &format!("{figures} figures, numbers.json and tables of {name}"));
        if self.common.json { print_json(out, &compared.numbers) } else { print(out, &compared.table) }
    }

    /// Computes and keeps a part of the work, unless only its state is asked for; says how many of its units are there, and how many it has.
    fn part(&self, out: &mut dyn Write, plan: &dyn Comparing, shard: Shard, units: &Units) -> Result<()> {
        let what = plan.what();
        let own = plan.part(shard, &Terminal::new(&self.common))?;
        let count = own.len();
        let done = || count - plan.missing(&own, units).len();
        let found = done();
        if !self.status && found < count {
            self.say_found(found, count, what);
            let progress = Terminal::new(&self.common);
            let outcome = plan.run_units(&own, units, &progress);
            drop(progress);
            outcome.map_err(|error| interrupted(error, done, count, what))?;
            let words =
                format!("{} of {count} {what} of its part; the command without --shard draws", done());
            self.common.wrote(&self.folder.join(UNITS), &words);
        } else if !self.status {
            self.common.say("everything is there already: nothing to do");
        }
        let done = if self.status { found } else { done() };
        if self.common.json {
            let missing = count - done;
            return print_json(out, &json!({"units": count, "done": done, "missing": missing}));
        }
        if self.status {
            return print(out, &format!("{done} of {count} {what} done, {} missing", count - done));
        }
        Ok(())
    }

    fn say_found(&self, done: usize, count: usize, what: &str) {
        if done > 0 {
            self.common.say(&format!("{done} of {count} {what} are there from before"));
        }
    }

    /// Vacuum wavelengths that are asked for, nm.
    fn nm(&self) -> Option<Vec<f64>> {
        self.wavelengths.as_ref().map(|Nm(nm)| nm.clone())
    }
}

/// Ctrl-C: what is kept, and how it goes on.
fn interrupted(error: Error, done: impl Fn() -> usize, count: usize, what: &str) -> Error {
    if !error.is_interrupted() {
        return error;
    }
    Error::interrupted_after(format!("{} of {count} {what} are kept; the same command goes on", done()))
}
