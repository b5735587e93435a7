//! `barbule fit-structure`: from measured spectra to the sizes of what reflected them.

use std::io::Write;
use std::path::{Path, PathBuf};

use barbule::campaign::spectrum::Collect;
use barbule::error::{counted, shortened};
use barbule::figures;
use barbule::instrument::Instrument;
use barbule::inverse::{Level, Lighting, Open, Outcome, Reading, Settings, Simulation, Target, in_words};
use barbule::io::measured::{Measurements, read_measurements};
use barbule::io::{check_writable, write_whole};
use barbule::{Error, Result, open};
use clap::ValueEnum;

use crate::common::{Common, print, print_json};
use crate::measured_args::{MeasuredUnit, Plane};
use crate::progress::Terminal;
use crate::provenance::{Provenance, check_outputs};
use crate::sets;

/// Random individuals of a species unless told otherwise: each table has dozens of spectra.
const INSTANCES: u64 = 8;

/// Arguments of `barbule fit-structure`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  barbule fit-structure --measured mine.csv --model film --stack 'air/keratin:?±?/melanin'
  barbule fit-structure --measured mine.csv --model starling --instances 4 -o mine.toml
  barbule fit-structure --measured mine.csv@0 yours.csv@30 --model film --picture both.svg
  barbule fit-structure --measured mine.csv --model multilayer --stack 'air/melanin:?/keratin:?/air'

In a stack ? or LOW..HIGH stands for what is to be found: a thickness in nm, its standard deviation between places or \
individuals (keratin:?±?), the fraction of a mixture (mix(keratin,air,?)), an index (1.4..1.7). What stands in a \
repetition is one number for all of its layers.

Printed are the sizes with their 95 % intervals, and the other solutions that fit as well: often a spectrum does not \
decide between orders of interference.")]
pub(crate) struct Args {
    /// Measured spectra, as `spectrum --measured` reads them: FILE, FILE@ANGLE (degrees) or a folder; samples at one angle
    /// are individuals, whose mean is fitted
    #[arg(long, value_name = "FILE[@ANGLE]", num_args = 1.., required = true)]
    measured: Vec<String>,
    /// What reflects: film, multilayer, lattice, SPECIES[:VARIANT], or the .toml file of a species or lattice
    #[arg(long, value_name = "MODEL")]
    model: String,
    /// The stack of a film or multilayer, with ? or LOW..HIGH for what is to be found [default of film: air/keratin:?/air]
    #[arg(long, value_name = "TEXT")]
    stack: Option<String>,
    /// A size of a species or lattice to be found, and where, as in cortex_um=0.2..0.5 (repeatable; up to three) [default: those that set
    /// the colour most, 25 % down and 35 % up]
    #[arg(long, value_name = "KEY[=LOW..HIGH]", value_parser = Open::parse)]
    free: Vec<Open>,
    /// What it was measured with, of flat layers: probe:CONE, arms:IN,OUT,CONE, sphere or microscope:NA (degrees) [default: light
    /// from one direction, all that is reflected]
    #[arg(long, value_name = "INSTRUMENT", value_parser = Instrument::parse)]
    instrument: Option<Instrument>,
    /// The plane in which angles lie: across the barbule or along it [default: across]
    #[arg(long, value_enum)]
    plane: Option<Plane>,
    /// The wavelengths that are fitted, as in 320:680 [default: all that are measured]
    #[arg(long, value_name = "FROM:TO", value_parser = range)]
    range: Option<[f64; 2]>,
    /// The column or sample to use, by name or by number from 1 [default: all samples and their mean]
    #[arg(long, value_name = "NAME|N")]
    column: Option<String>,
    /// Whether the measurements are percent or parts of 1 [default: percent where names say so or values exceed 1.5]
    #[arg(long, value_enum, value_name = "UNIT")]
    measured_unit: Option<MeasuredUnit>,
    /// Whether each reading has a factor of its own, or reflectances are absolute
    #[arg(long, value_enum, default_value_t = Levels::Free)]
    level: Levels,
    /// Each reading has a constant of its own too, as of gloss and stray light
    #[arg(long)]
    offset: bool,
    /// Solutions to give at least; those that fit as well as the best always are
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=50))]
    solutions: u64,
    /// Random individuals of a species in each simulated spectrum [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1000))]
    instances: Option<u64>,
    /// Write the best solution as a stack, species or lattice file (.toml), which all commands take
    #[arg(short, long, value_name = "BEST.toml")]
    output: Option<PathBuf>,
    /// Draw the solutions over the measurement, and what they leave: .svg, .pdf or .png
    #[arg(long, value_name = "FIG")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// What is known of the scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Levels {
    /// A factor for each reading
    Free,
    /// Absolute reflectances
    Fixed,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        self.check()?;
        let opening = self.common.opening()?;
        let simulation = Simulation {
            instances: self.instances.unwrap_or(INSTANCES) as usize,
            seed: self.common.seed,
            collect: Collect::Hemisphere,
        };
        let target =
            open::target(&self.model, self.stack.as_deref(), self.free.clone(), simulation, &opening)?;
        target.check_instrument(self.instrument.as_ref())?;
        self.say_idle(&target);
        let measured = self.read()?;
        let lighting = Lighting {
            instrument: self.instrument.as_ref(),
            along: self.plane == Some(Plane::Along),
            thickest_nm: target.thickest_nm()?,
        };
        let readings = Reading::of(&measured, lighting, self.range)?;
        let settings = Settings {
            level: if self.level == Levels::Free { Level::Free } else { Level::Fixed },
            offset: self.offset,
            solutions: self.solutions as usize,
        };
        let terminal = Terminal::new(&self.common);
        let outcome = target.fit(&readings, &settings, &terminal)?;
        drop(terminal);
        self.write(&outcome, &readings)?;
        outcome.fit.doubts.iter().for_each(|doubt| self.common.say(doubt));
        if self.common.json {
            return print_json(out, &outcome.document(&readings));
        }
        print(out, &words(&outcome).join("\n"))
    }

    /// Refuses before any work what could not be written after it.
    fn check(&self) -> Result<()> {
        if let Some(path) = &self.output {
            let is_toml = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("toml"));
            if !is_toml {
                return Err(Error::input(format!(
                    "-o {}: the best solution is written as TOML; end the name with .toml (--picture draws a figure)",
                    path.display()
                )));
            }
            check_writable(path)?;
        }
        check_outputs(self.picture.as_deref(), None)
    }

    /// Says what is of barbules where flat layers are fitted.
    fn say_idle(&self, target: &Target) {
        if !matches!(target, Target::Stack { .. }) {
            return;
        }
        for (flag, is_given, why) in [
            ("--instances", self.instances.is_some(), "flat layers have no random individuals"),
            ("--plane", self.plane.is_some(), "flat layers reflect the same in every plane"),
        ] {
            if is_given {
                self.common.idle(flag, why);
            }
        }
    }

    fn read(&self) -> Result<Measurements> {
        let scale = self.measured_unit.map(Into::into);
        let measured = read_measurements(&self.measured, self.column.as_deref(), scale)?;
        measured.reading.iter().for_each(|reading| self.common.say(reading));
        if measured.angles.iter().all(|at| at.angle_deg.is_none()) {
            self.common.explain("no angle is said: 0°");
        }
        Ok(measured)
    }

    fn write(&self, outcome: &Outcome, readings: &[Reading]) -> Result<()> {
        let provenance = Provenance::new(&self.common);
        if let Some(path) = &self.output {
            let notes = provenance.notes();
            let notes = notes.iter().map(|(name, text)| format!("# {name}: {}\n", text.replace('\n', " ")));
            let text = notes.collect::<String>() + &outcome.toml;
            write_whole(path, text.as_bytes())?;
            self.common.wrote(path, &format!("the best of {}", self.solutions(outcome)));
        }
        if let Some(path) = &self.picture {
            let names: Vec<String> = self.measured.iter().map(|place| file_name(place)).collect();
            let title = format!("{} fitted to {}", shortened(&self.model), shortened(&names.join(", ")));
            provenance.write_figure(path, &figures::inverse(&title, &outcome.fit, readings))?;
            self.common.wrote(path, &format!("{} over the measurement", self.solutions(outcome)));
        }
        Ok(())
    }

    fn solutions(&self, outcome: &Outcome) -> String {
        counted(outcome.fit.solutions.len(), "solution")
    }
}

fn file_name(place: &str) -> String {
    Path::new(place).file_name().map_or_else(|| place.to_owned(), |name| name.to_string_lossy().into_owned())
}

/// A range of wavelengths, `FROM:TO`.
fn range(text: &str) -> Result<[f64; 2]> {
    let values = text.split_once(':').map(|(from, to)| [from, to].map(sets::wavelengths));
    match values {
        Some([Ok(from), Ok(to)]) if from.len() == 1 && to.len() == 1 && from[0] < to[0] => {
            Ok([from[0], to[0]])
        }
        _ => Err(Error::input(format!(
            "--range {}: give FROM:TO in nm within 300 to 830, as in 320:680",
            shortened(text)
        ))),
    }
}

/// The solutions in words, the best first.
fn words(outcome: &Outcome) -> Vec<String> {
    let mut lines = Vec::new();
    for (k, solution) in outcome.fit.solutions.iter().enumerate() {
        let standing = match (k, solution.as_good) {
            (0, _) => "best".to_owned(),
            (_, true) => format!("fits as well (Δχ² {:.1})", solution.worse_by),
            (_, false) => format!("ruled out at 95 % (Δχ² {:.0})", solution.worse_by),
        };
        // A model may be further from the measurement than its mean is.
        let explained = match solution.explained {
            part if part > 0.0 => format!("{:.1} %", 100.0 * part),
            _ => "none".to_owned(),
        };
        lines.push(format!(
            "{}. {standing}: rmse {:.5}, {explained} of the variance explained",
            k + 1,
            solution.rmse,
        ));
        for (j, (p, size)) in outcome.fit.parameters.iter().zip(&solution.sizes).enumerate() {
            let between = match &solution.between_samples {
                _ if size.open == [true, true] => "; what was measured does not tell it".to_owned(),
                Some(std) => {
                    format!("; ±{} {} between samples", rounded(std[j]), p.unit).trim_end().to_owned()
                }
                None => String::new(),
            };
            lines.push(format!("   {}{between}", in_words(p, size)));
        }
        let levels: Vec<String> = solution.levels.iter().map(|[level, _]| rounded(*level)).collect();
        lines.push(format!("   level {}", levels.join(", ")));
    }
    if let Some((error, simulated)) = outcome.tables {
        lines.push(format!("{simulated} spectra simulated; interpolation off by {}", rounded(error)));
    }
    lines
}

/// Three figures.
fn rounded(value: f64) -> String {
    let digits = (2.0 - value.abs().max(1e-12).log10().floor()).clamp(0.0, 12.0) as usize;
    format!("{value:.digits$}")
}
