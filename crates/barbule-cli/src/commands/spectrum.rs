//! `barbule spectrum`: reflectance against wavelength, mean and spread over instances, and the numbers of its colour.

mod tables;

use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

use barbule::campaign::spectrum::{
    Collect, Grazing, Individuals, Over, Spectra, SpectrumRequest, spectra_and_individuals,
};
use barbule::campaign::spectrum_bytes;
use barbule::error::{counted, shortened};
use barbule::figures::{self, Simulated};
use barbule::io::measured::{Measured, Scale, read_measured};
use barbule::plot::{Band, MeasuredBand};
use barbule::progress::{Progress, Several};
use barbule::solve::core_fringes::{CoreFringes, core_fringes};
use barbule::solve::surface::LARGEST_MIRROR_ERROR;
use barbule::spectrum::comparison::Comparison;
use barbule::spectrum::look::Look;
use barbule::spectrum::{Spectrum, Wavelengths};
use barbule::structure::{Side, Structure};
use barbule::{Error, Result};
use clap::ValueEnum;
use clap::builder::ArgPredicate;
use serde_json::{Value, json};

use crate::bird_args::{BirdArgs, Sight, Viewer};
use crate::campaign::grazing;
use crate::common::{Common, print, print_json};
use crate::figure::FigureArgs;
use crate::peak_args::{self, PeakArgs};
use crate::progress::Terminal;
use crate::provenance::{Provenance, check_outputs, csv_cell};
use crate::structure_arg::SideArg;
use crate::{sets, structure_arg};

/// Random instances unless told otherwise.
const INSTANCES: usize = 50;

/// Curves that one figure of several structures holds: as many as its legend names.
const MOST_CURVES: usize = 18;

/// Arguments of `barbule spectrum`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  barbule spectrum starling --angle 0,30,60 -o starling.svg --csv starling.csv
  barbule spectrum starling --measured examples/measured/starling-back.csv -o both.png
  barbule spectrum starling rock-dove bronzewing --summary birds.csv
  barbule spectrum rock-dove --side below --angle=-30,30
  barbule spectrum starling --csv birds.csv --csv-layout tidy --individuals
  barbule spectrum starling --angle 0,40 --bird starling --bird peafowl
  barbule spectrum rock-dove --angle 0:60:15 --wavelengths 300:700:4 --peak-range 400:700

Printed, and in --json under 'look': peak (through several angles that of one order of interference, from the angle \
nearest to the normal; --json lists all peaks), full width at half maximum (half-way between the peak and the lowest \
reflectance), mean reflectance (pavo's B2), saturation (S8), wavelength of the highest sample (H1, in --json and \
--summary), luminous reflectance Y, x, y, dominant wavelength, purity, Oklab's hue angle, sRGB at true and at \
normalized luminance, all under D65.")]
pub(crate) struct Args {
    #[arg(help = structure_arg::HELP, value_name = "STRUCTURE", required = true)]
    structures: Vec<String>,
    #[command(flatten)]
    side: SideArg,
    /// Angles of incidence in degrees (also --angles)
    #[arg(long, alias = "angles", value_name = "SET", default_value = "0", allow_hyphen_values = true,
        value_parser = |text: &str| sets::angles("--angle", text))]
    angle: sets::Angles,
    /// The plane in which the angle lies: across the barbule (φ_i) or along it (θ_i)
    #[arg(long, value_enum, default_value_t = Plane::Across)]
    plane: Plane,
    /// What is collected: hemisphere, or cone:HALF, what falls within HALF degrees of the mirror direction
    #[arg(long, value_name = "hemisphere|cone:HALF", default_value = "hemisphere", value_parser = collect)]
    collect: Collect,
    /// Incident polarization
    #[arg(long, value_name = "mean|1|2", default_value = "mean", value_parser = polarization)]
    polarization: [f64; 2],
    /// Random instances [default: 50]
    #[arg(long, value_name = "N")]
    instances: Option<usize>,
    /// Wavelengths in nm (also --wavelength); birds see from 300: 300:700:4
    #[arg(long, alias = "wavelength", value_name = "SET", default_value = "400:694:6",
        default_value_if("birds", ArgPredicate::IsPresent, "300:700:4"), value_parser = sets::wavelength_set)]
    wavelengths: Wavelengths,
    #[command(flatten)]
    birds: BirdArgs,
    #[command(flatten)]
    peak: PeakArgs,
    /// A measured spectrum to compare with: a table of text (commas, semicolons, tabs or blanks; decimal points or
    /// commas; with names or without; one column per sample, or a line for each wavelength of each sample; parts of 1 or
    /// percent), the text of Ocean Optics, Avantes and similar spectrometers, or JCAMP-DX (.jdx). How it is read is said
    #[arg(long, value_name = "FILE")]
    measured: Option<PathBuf>,
    /// The column or sample of --measured to use, by name or by number from 1 [default: all samples and their mean]
    #[arg(long, value_name = "NAME|N", requires = "measured")]
    column: Option<String>,
    /// Whether --measured is percent or parts of 1 [default: percent where names say so or values exceed 1.5]
    #[arg(long, value_enum, value_name = "UNIT", requires = "measured")]
    measured_unit: Option<MeasuredUnit>,
    #[command(flatten)]
    figure: FigureArgs,
    /// Write a table: angle_deg,wavelength_nm,mean,std (of several structures with their names in front), with --measured
    /// also the measured mean
    #[arg(long, value_name = "F")]
    csv: Option<PathBuf>,
    /// A line of --csv for each angle and wavelength, or for each of every curve, as R's and pandas' grouping wants it
    #[arg(long, value_enum, value_name = "LAYOUT", default_value_t = Layout::Wide, requires = "csv")]
    csv_layout: Layout,
    /// With the spectrum of each random individual, and the standard error, in --csv and --json
    #[arg(long)]
    individuals: bool,
    /// Write the numbers of the colours, one row for each structure and angle, with --measured also those of the
    /// comparison
    #[arg(long, value_name = "F.csv")]
    summary: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// Planes of incidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Plane {
    /// The angle is φ_i
    Across,
    /// The angle is θ_i
    Along,
}

/// Layouts of tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Layout {
    /// A column for each curve
    Wide,
    /// A line for each value
    Tidy,
}

/// Units of measured values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MeasuredUnit {
    /// 0 to 100
    Percent,
    /// 0 to 1
    Fraction,
}

/// A structure with its spectra.
struct Found {
    /// As it was typed.
    typed: String,
    /// As people call it.
    name: String,
    instances: usize,
    spectra: Spectra,
    /// Where they are asked for.
    individuals: Option<Individuals>,
    /// Of a core between two sides, in the mean over several instances.
    core_fringes: Option<CoreFringes>,
    /// One for each angle.
    looks: Vec<Look>,
    /// One for each angle, with a measurement.
    comparisons: Vec<Comparison>,
    /// What each bird that was asked for sees.
    sights: Vec<Sight>,
    /// Whether keratin in it is taken to be clear where it is not.
    has_guess: bool,
}

impl Found {
    /// What birds see of the mean at each angle.
    fn sights(&self, views: &[Viewer], at: &Wavelengths) -> Result<Vec<Sight>> {
        let means = self.spectra.mean.iter().map(|mean| Spectrum::new(at.clone(), mean.clone()));
        let means = means.collect::<Result<Vec<_>>>()?;
        views.iter().map(|view| Sight::of(view, &means)).collect()
    }

    /// At how many wavelengths of an angle light grazes so that the simulation is off.
    fn flagged(&self, angle: usize) -> usize {
        self.spectra.flagged()[angle].iter().filter(|flagged| **flagged).count()
    }
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        self.check()?;
        let structures = self
            .structures
            .iter()
            .map(|text| self.side.of(structure_arg::parse(text, &self.common)?))
            .collect::<Result<Vec<_>>>()?;
        let measured = self.measured()?;
        let views = self.birds.views(self.wavelengths.range_nm())?;
        let mut all = self.simulate(&structures, measured.as_ref())?;
        let (media, shortest_nm) = (self.common.opening()?.media, self.wavelengths.range_nm().0);
        for (found, structure) in all.iter_mut().zip(&structures) {
            found.sights = found.sights(&views, &self.wavelengths)?;
            found.has_guess = media.guesses_in(structure, self.common.seed, shortest_nm);
        }
        if all.iter().any(|found| found.has_guess) {
            self.common.say_guessed();
        }
        self.write(&all, measured.as_ref())?;
        if self.common.json {
            return print_json(out, &self.document(&all, measured.as_ref()));
        }
        self.print(out, &all)
    }

    /// Refuses before any work what could not be done after it.
    fn check(&self) -> Result<()> {
        if let Some(instances) = self.instances.filter(|n| !(1..=10_000).contains(n)) {
            return Err(Error::input(format!("--instances {instances}: give a number from 1 to 10000")));
        }
        if self.individuals && self.csv.is_none() && !self.common.json {
            return Err(Error::input("--individuals: give --csv F or --json, which hold them"));
        }
        self.peak.within(&self.wavelengths)?;
        self.figure.check(&self.common)?;
        check_outputs(self.figure.path(), self.csv.as_deref())?;
        check_outputs(None, self.summary.as_deref())?;
        let curves = self.structures.len() * self.angle.0.len();
        if self.figure.output.is_some() && self.structures.len() > 1 && curves > MOST_CURVES {
            return Err(Error::input(format!(
                "-o: {curves} curves of {} structures do not fit one figure, which holds {MOST_CURVES}; give fewer, or --summary in place of -o",
                self.structures.len()
            )));
        }
        Ok(())
    }

    /// Reads the measurement, says how, and refuses one that has nothing in common with the wavelengths.
    fn measured(&self) -> Result<Option<Measured>> {
        let Some(path) = &self.measured else { return Ok(None) };
        let scale = self.measured_unit.map(|unit| match unit {
            MeasuredUnit::Percent => Scale::Percent,
            MeasuredUnit::Fraction => Scale::Fraction,
        });
        let measured = read_measured(path, self.column.as_deref(), scale)?;
        self.common.say(&measured.reading);
        let nothing = Spectrum::new(self.wavelengths.clone(), vec![0.0; self.wavelengths.len()])?;
        Comparison::of(&nothing, &measured.mean, None).map_err(|e| e.at(path.display()))?;
        Ok(Some(measured))
    }

    fn simulate(&self, structures: &[Structure], measured: Option<&Measured>) -> Result<Vec<Found>> {
        let terminal = Terminal::new(&self.common);
        let label = format!("simulating {} structures", structures.len());
        let several = (structures.len() > 1).then(|| Several::begin(&terminal, &label, structures.len()));
        let mut all = Vec::with_capacity(structures.len());
        for (typed, structure) in self.structures.iter().zip(structures) {
            let found = match several.as_ref().map(Several::part) {
                Some(part) => {
                    self.one(typed, structure, measured, &part).map_err(|e| e.at(shortened(typed)))?
                }
                None => self.one(typed, structure, measured, &terminal)?,
            };
            all.push(found);
        }
        Ok(all)
    }

    fn one(
        &self,
        typed: &str,
        structure: &Structure,
        measured: Option<&Measured>,
        progress: &dyn Progress,
    ) -> Result<Found> {
        let wanted = self.instances.unwrap_or(INSTANCES);
        let instances = structure.count().map_or(wanted, |given| given.min(wanted));
        if self.instances.is_some_and(|asked| asked > instances) {
            self.common.say(&format!(
                "{}: --instances {wanted}, but there {}: {} simulated",
                shortened(typed),
                if instances == 1 { "is 1 section".to_owned() } else { format!("are {instances} sections") },
                if instances == 1 { "it is" } else { "all are" },
            ));
        }
        let direction = |angle: &f64| match self.plane {
            Plane::Across => (0.0, angle.to_radians()),
            Plane::Along => (angle.to_radians(), 0.0),
        };
        let request = SpectrumRequest {
            wavelengths: self.wavelengths.clone(),
            directions: self.angle.0.iter().map(direction).collect(),
            instances,
            seed: self.common.seed,
            collect: self.collect,
            polarization: self.polarization,
        };
        let bytes = spectrum_bytes(structure, &request)?;
        let fewer = "fewer --wavelengths, angles, --instances or --threads";
        self.common.check_memory("this spectrum", bytes, fewer)?;
        let (found, individuals) = spectra_and_individuals(structure, &request, progress)?;
        self.say_grazing(&found, structure.width_um());
        let core_fringes = match instances {
            // What one individual has is no mean's.
            1 => None,
            _ => core_fringes(structure, self.common.seed, instances, &self.wavelengths)?,
        };
        let means = found
            .mean
            .iter()
            .map(|mean| Spectrum::new(self.wavelengths.clone(), mean.clone()))
            .collect::<Result<Vec<_>>>()?;
        let peak_range = self.peak.within(&self.wavelengths)?;
        let comparisons = measured.map_or(Ok(Vec::new()), |measured| {
            means.iter().map(|mean| Comparison::of(mean, &measured.mean, peak_range)).collect()
        })?;
        let name = structure.name();
        Ok(Found {
            typed: match structure.side() {
                Side::Above => typed.to_owned(),
                Side::Below => typed.to_owned() + Side::BELOW,
            },
            name: name.strip_suffix(":default").unwrap_or(&name).to_owned(),
            instances,
            spectra: found,
            individuals: self.individuals.then_some(individuals),
            core_fringes: core_fringes.filter(CoreFringes::mislead),
            looks: Look::series(&self.angle.0, &means, peak_range),
            comparisons,
            sights: Vec::new(),
            has_guess: false,
        })
    }

    /// Says where light grazes so that the simulation is off, and where more than all of it comes back.
    fn say_grazing(&self, found: &Spectra, width_um: f64) {
        if let Some(Over { direction, wavelength, reflected, count }) = found.over() {
            self.common.say(&format!(
                "at {} and {} nm {:.1} % of the light come back, more than all of it: this structure is beyond what single reflections describe ({count} values are flagged)",
                self.direction_name(self.angle.0[direction]),
                self.wavelengths[wavelength],
                100.0 * reflected
            ));
        }
        let Some(Grazing { direction, wavelength, mirror_fraction, flagged }) = found.grazing() else {
            return;
        };
        let incidence = self.direction_name(self.angle.0[direction]);
        let said = grazing(&incidence, self.wavelengths[wavelength], width_um, mirror_fraction);
        let all = self.angle.0.len() * self.wavelengths.len();
        self.common.say(&format!("{said} ({flagged} of {all} values are flagged)"));
    }

    fn write(&self, all: &[Found], measured: Option<&Measured>) -> Result<()> {
        let provenance = Provenance::new(&self.common);
        let shown = |what: &str| {
            let whose = match all {
                [one] => one.name.clone(),
                many => format!("{} structures", many.len()),
            };
            format!("{what} of {whose} at {}", counted(self.angle.0.len(), "angle"))
        };
        let beside = if measured.is_some() { ", and what was measured" } else { "" };
        if let Some(path) = &self.figure.output {
            provenance.write_figure(path, &self.figure(all, measured)?)?;
            self.common.wrote(path, &format!("{}{beside}", shown("reflectance")));
        }
        if let Some(path) = &self.csv {
            let tables =
                tables::Tables { all, angles_deg: &self.angle.0, nm: self.wavelengths.nm(), measured };
            let text = match self.csv_layout {
                Layout::Wide => tables.wide(),
                Layout::Tidy => tables.tidy(),
            };
            provenance.write_csv(path, &text)?;
            self.common.wrote(path, &format!("{}{beside}", shown("reflectance")));
        }
        if let Some(path) = &self.summary {
            provenance.write_csv(path, &self.summary_text(all))?;
            let beside = if measured.is_some() { " and of the comparison" } else { "" };
            self.common.wrote(path, &format!("{}{beside}", shown("numbers of the colour")));
        }
        Ok(())
    }

    fn direction_name(&self, angle: f64) -> String {
        format!("{} = {angle}°", if self.plane == Plane::Across { "φ" } else { "θ" })
    }

    fn figure(&self, all: &[Found], measured: Option<&Measured>) -> Result<barbule::plot::Drawing> {
        let most = all.iter().map(|found| found.instances).max().unwrap_or(0);
        let angles: Vec<String> = self.angle.0.iter().map(|angle| self.direction_name(*angle)).collect();
        let title = match (all, &angles[..]) {
            ([one], _) => format!("{}, {}", one.name, counted(one.instances, "instance")),
            (_, [angle]) => format!("{angle}, {}", counted(most, "instance")),
            _ => counted(most, "instance"),
        };
        let names: Vec<Vec<String>> = all
            .iter()
            .map(|found| match (all.len(), angles.len()) {
                (1, _) => angles.clone(),
                (_, 1) => vec![shortened(&found.typed)],
                _ => angles.iter().map(|angle| format!("{}, {angle}", shortened(&found.typed))).collect(),
            })
            .collect();
        let simulated: Vec<Simulated> = all
            .iter()
            .zip(&names)
            .map(|(found, names)| Simulated {
                names,
                spectra: &found.spectra,
                instances: found.instances,
                looks: &found.looks,
                has_guess: found.has_guess,
            })
            .collect();
        let measured = measured.map(|measured| MeasuredBand {
            band: Band {
                name: match &measured.samples[..] {
                    [_] => "measured".into(),
                    many => format!("measured, mean of {}", many.len()),
                },
                mean: measured.mean.clone(),
                std: measured.std.clone(),
                peak: None,
            },
            samples: match &measured.samples[..] {
                [_] => Vec::new(),
                many => many.iter().map(|sample| sample.spectrum.clone()).collect(),
            },
        });
        let (title, page) = (self.figure.title(figures::heading(&title)), self.figure.page()?);
        figures::spectra(&title, &self.wavelengths, &simulated, measured.as_ref(), &page)
    }

    fn summary_text(&self, all: &[Found]) -> String {
        let mut text = String::from("structure,angle_deg,instances");
        let first = all.iter().flat_map(|found| found.looks.first()).next();
        let compared = all.iter().flat_map(|found| found.comparisons.first()).next();
        if let Some(fields) = first.map(Look::fields) {
            let _ = write!(text, ",{},flagged_wavelengths", fields.csv_header());
        }
        if let Some(fields) = compared.map(Comparison::fields) {
            let _ = write!(text, ",{}", fields.csv_header());
        }
        for found in all {
            for (a, angle) in self.angle.0.iter().enumerate() {
                let name = csv_cell(&found.typed);
                let cells = found.looks[a].fields().csv_cells();
                let flagged = found.flagged(a);
                let _ = write!(text, "\n{name},{angle},{},{cells},{flagged}", found.instances);
                if let Some(comparison) = found.comparisons.get(a) {
                    let _ = write!(text, ",{}", comparison.fields().csv_cells());
                }
            }
        }
        text.push('\n');
        text
    }

    fn document(&self, all: &[Found], measured: Option<&Measured>) -> Value {
        let of = |found: &Found| {
            let error = |std: &Vec<f64>| -> Vec<f64> {
                std.iter().map(|s| s / (found.instances as f64).sqrt()).collect()
            };
            let standard_error =
                (found.instances > 1).then(|| found.spectra.std.iter().map(error).collect::<Vec<_>>());
            let mut document = json!({
                "structure": found.typed,
                "angle_deg": self.angle.0,
                "wavelength_nm": self.wavelengths.nm(),
                "mean": found.spectra.mean,
                "std": found.spectra.std,
                "mirror_fraction": found.spectra.mirror,
                "flagged": found.spectra.flagged(),
                "standard_error": standard_error,
                "instances": found.instances,
                "look": found.looks,
                "core_note": found.core_fringes.map(|fringes| core_note(&fringes, found.instances)),
                "order_notes": peak_args::notes(&self.angle.0, &found.looks),
            });
            if let Some(individuals) = &found.individuals {
                let of = |a: usize| {
                    (0..individuals.count()).map(move |i| individuals.of(i, a)).collect::<Vec<_>>()
                };
                document["individuals"] = json!((0..self.angle.0.len()).map(of).collect::<Vec<_>>());
            }
            if !found.sights.is_empty() {
                document["birds"] = found.sights.iter().map(Sight::document).collect();
            }
            if measured.is_some() {
                document["comparison"] = json!(found.comparisons);
            }
            document
        };
        let mut document = match all {
            [one] => of(one),
            many => json!({ "structures": many.iter().map(of).collect::<Vec<_>>() }),
        };
        if let Some(measured) = measured {
            document["measured"] = json!({
                "reading": measured.reading,
                "samples": measured.samples.iter().map(|sample| &sample.name).collect::<Vec<_>>(),
                "wavelength_nm": measured.mean.wavelengths().nm(),
                "mean": measured.mean.values(),
                "std": measured.std,
                "look": Look::with_peak_in(&measured.mean, self.peak.within(&self.wavelengths).ok().flatten()),
            });
        }
        document
    }

    /// The colours, and how they compare, one line each.
    fn print(&self, out: &mut dyn Write, all: &[Found]) -> Result<()> {
        let file = self.measured.as_deref().map(Path::display);
        for found in all {
            for (a, angle) in self.angle.0.iter().enumerate() {
                let name = if all.len() > 1 { shortened(&found.typed) } else { found.name.clone() };
                let flagged = match found.flagged(a) {
                    0 => String::new(),
                    count => format!(
                        ", flagged: off by over {:.0} % at {count} of {}",
                        100.0 * LARGEST_MIRROR_ERROR,
                        counted(self.wavelengths.len(), "wavelength")
                    ),
                };
                let words = found.looks[a].words();
                print(out, &format!("{name}, {}: {words}{flagged}", self.direction_name(*angle)))?;
                for sight in &found.sights {
                    print(out, &format!("  {}", sight.words(a)))?;
                }
                if let (Some(comparison), Some(file)) = (found.comparisons.get(a), &file) {
                    print(out, &format!("  against {file}: {}", comparison.words()))?;
                }
            }
            let core = found.core_fringes.map(|fringes| core_note(&fringes, found.instances));
            for note in peak_args::notes(&self.angle.0, &found.looks).into_iter().chain(core) {
                let name =
                    if all.len() > 1 { format!("{}: ", shortened(&found.typed)) } else { String::new() };
                self.common.say(&format!("{name}{note}"));
            }
        }
        if let Some(note) = all.first().and_then(|found| found.looks[0].colour_note.as_ref()) {
            self.common.say(note);
        }
        Ok(())
    }
}

/// What to tell of fringes that look like peaks of the structure.
fn core_note(fringes: &CoreFringes, instances: usize) -> String {
    format!(
        "the core, a film between both sides, makes fringes of ±{:.1} % of the light ({:.0} % of the mean) about {:.0} nm at normal incidence, {:.0} nm from one to the next; the mean of {instances} individuals keeps {:.0} % of them, since their cores are alike: core_spread = 0.1 in the species file, or lower = \"none\", takes them out",
        100.0 * fringes.amplitude,
        100.0 * fringes.part,
        fringes.near_nm,
        fringes.period_nm,
        100.0 * fringes.kept
    )
}

fn collect(text: &str) -> Result<Collect> {
    if text == "hemisphere" {
        return Ok(Collect::Hemisphere);
    }
    text.strip_prefix("cone:")
        .and_then(|half| half.trim().parse::<f64>().ok())
        .filter(|half| *half > 0.0 && *half <= 90.0)
        .map(|half| Collect::Cone(half.to_radians()))
        .ok_or_else(|| {
            Error::input(format!(
                "--collect {}: write hemisphere, or cone:HALF with HALF up to 90 degrees, as in cone:5",
                shortened(text)
            ))
        })
}

fn polarization(text: &str) -> Result<[f64; 2]> {
    match text {
        "mean" => Ok([0.5, 0.5]),
        "1" => Ok([1.0, 0.0]),
        "2" => Ok([0.0, 1.0]),
        _ => Err(Error::input(format!("--polarization {}: write mean, 1 or 2", shortened(text)))),
    }
}
