//! `barbule spectrum`: reflectance against wavelength, mean and spread over instances, and the numbers of its colour.

mod instrument;
mod intervals;
mod outputs;
mod tables;

use std::io::Write;
use std::path::PathBuf;

use barbule::campaign::spectrum::{
    Collect, Grazing, Individuals, Over, Spectra, SpectrumRequest, reading_bytes, readings_and_individuals,
    spectra_and_individuals,
};
use barbule::campaign::spectrum_bytes;
use barbule::confidence::{Intervals, check_individuals};
use barbule::error::{counted, shortened};
use barbule::figures;
use barbule::io::measured::{Measured, Measurements, read_measurements};
use barbule::progress::{Progress, Several};
use barbule::solve::core_fringes::{CoreFringes, core_fringes};
use barbule::spectrum::comparison::Comparison;
use barbule::spectrum::look::Look;
use barbule::spectrum::peaks::Origin;
use barbule::spectrum::{Spectrum, Wavelengths};
use barbule::structure::{Side, Structure};
use barbule::{Error, Result};
use clap::ValueEnum;
use clap::builder::ArgPredicate;

use crate::bird_args::{BirdArgs, Sight, Viewer};
use crate::campaign::grazing;
use crate::common::{Common, print_json};
use crate::figure::FigureArgs;
use crate::measured_args::{MeasuredUnit, Plane};
use crate::peak_args::PeakArgs;
use crate::progress::Terminal;
use crate::provenance::check_outputs;
use crate::structure_arg::SideArg;
use crate::{sets, structure_arg};
use instrument::{InstrumentArgs, Row, Subject};

/// Random instances unless told otherwise.
const INSTANCES: usize = 50;

/// So many files' readings are said without being asked for.
const FEW_READINGS: usize = 4;

/// Curves that one figure of several structures holds: as many as its legend names.
const MOST_CURVES: usize = 18;

/// Arguments of `barbule spectrum`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  barbule spectrum starling --angle 0,30,60 -o starling.svg --csv starling.csv
  barbule spectrum starling --measured examples/measured/starling-back.csv -o both.png
  barbule spectrum starling --measured mine.csv@0 --measured yours.csv@30 -o angles.png
  barbule spectrum starling --intervals --uncertain keratin=0.005 --uncertain cortex_um=2%
  barbule spectrum starling rock-dove bronzewing --summary birds.csv
  barbule spectrum rock-dove --side below --angle=-30,30
  barbule spectrum starling --csv birds.csv --csv-layout tidy --individuals
  barbule spectrum starling --angle 0,40 --bird starling --bird peafowl
  barbule spectrum rock-dove --angle 0:60:15 --wavelengths 300:700:4 --peak-range 400:700
  barbule spectrum air/keratin:200/air --instrument probe:10 --instrument sphere -o probe.svg

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
    /// Angles of incidence in degrees (also --angles) [default: those that --measured says, else 0]
    #[arg(long, alias = "angles", value_name = "SET", allow_hyphen_values = true,
        value_parser = |text: &str| sets::angles("--angle", text))]
    angle: Option<sets::Angles>,
    /// The plane in which the angle lies: across the barbule (φ_i) or along it (θ_i)
    #[arg(long, value_enum, default_value_t = Plane::Across)]
    plane: Plane,
    /// What is collected: hemisphere, or cone:HALF, what falls within HALF degrees of the mirror direction
    #[arg(long, value_name = "hemisphere|cone:HALF", default_value = "hemisphere", value_parser = collect)]
    collect: Collect,
    #[command(flatten)]
    instrument: InstrumentArgs,
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
    /// A measured spectrum to compare with, a folder of them, or several (repeat the flag): samples of the same angle are individuals;
    /// angles are those behind @, or in names as 30deg, or of a column 'angle'. Read are tables of text (commas, semicolons, tabs or blanks; decimal points or
    /// commas; with names or without; one column per sample, or a line for each wavelength of each sample; parts of 1 or
    /// percent), the text of Ocean Optics, Avantes and similar spectrometers, or JCAMP-DX (.jdx). How it is read is said
    #[arg(long, value_name = "FILE[@ANGLE]|FOLDER")]
    measured: Vec<String>,
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
    #[command(flatten)]
    sure: intervals::IntervalArgs,
    /// Write the numbers of the colours, one row for each structure and angle, with --measured also those of the
    /// comparison
    #[arg(long, value_name = "F.csv")]
    summary: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// Layouts of tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Layout {
    /// A column for each curve
    Wide,
    /// A line for each value
    Tidy,
    /// As spectrometers deliver them: wavelengths, and a column in percent for each curve, or with --individuals for each
    /// individual of it
    Spectrometer,
}

/// What all structures are asked.
#[derive(Clone, Copy)]
struct Asked<'a> {
    rows: &'a [Row],
    measured: Option<&'a Measurements>,
}

impl<'a> Asked<'a> {
    /// What was measured at the angle of a row.
    fn measured_at(self, row: usize) -> Option<&'a Measured> {
        self.measured?.at(self.rows[row].angle_deg)
    }
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
    /// One for each angle, with a measurement; none at angles at which nothing was measured.
    comparisons: Vec<Option<Comparison>>,
    /// One for each angle, where they are asked for.
    intervals: Option<Vec<Intervals>>,
    /// What each bird that was asked for sees.
    sights: Vec<Sight>,
    /// Whether keratin in it is taken to be clear where it is not.
    has_guess: bool,
}

impl Found {
    /// What birds see of the mean at each angle, and how far it is from what was measured there.
    fn sights(&self, views: &[Viewer], at: &Wavelengths, asked: Asked) -> Result<Vec<Sight>> {
        let means = self.spectra.mean.iter().map(|mean| Spectrum::new(at.clone(), mean.clone()));
        let means = means.collect::<Result<Vec<_>>>()?;
        let known = (0..means.len()).map(|row| asked.measured_at(row).map(|measured| &measured.mean));
        let measured: Vec<Option<&Spectrum>> = known.collect();
        let sight = |view: &Viewer| match asked.measured {
            Some(_) => Sight::of(view, &means)?.beside(view, &means, &measured),
            None => Sight::of(view, &means),
        };
        views.iter().map(sight).collect()
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
        let structures = self.structures.iter().map(|text| self.subject(text)).collect::<Result<Vec<_>>>()?;
        let measured = self.measured()?;
        let views = self.birds.views(self.wavelengths.range_nm())?;
        // Before any work.
        for (at, (_, view)) in
            measured.iter().flat_map(|found| &found.angles).flat_map(|at| views.iter().map(move |v| (at, v)))
        {
            let range = at.measured.mean.wavelengths().range_nm();
            view.check("the measured reflectance", range.into()).map_err(|error| error.at("--measured"))?;
        }
        let rows = self.rows(&self.angles(measured.as_ref())?);
        self.check_rows(&rows)?;
        let asked = Asked { rows: &rows, measured: measured.as_ref() };
        let mut all = self.simulate(&structures, asked)?;
        let (media, shortest_nm) = (self.common.opening()?.media, self.wavelengths.range_nm().0);
        for (found, subject) in all.iter_mut().zip(&structures) {
            found.sights = found.sights(&views, &self.wavelengths, asked)?;
            let structure = subject.structure();
            found.has_guess =
                structure.is_some_and(|one| media.guesses_in(one, self.common.seed, shortest_nm));
        }
        if all.iter().any(|found| found.has_guess) {
            self.common.say_guessed();
        }
        self.write(&all, asked)?;
        if self.common.json {
            return print_json(out, &self.document(&all, asked));
        }
        self.print(out, &all, asked)
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
        Ok(())
    }

    /// Refuses rows that cannot be read, and more curves than a figure holds.
    fn check_rows(&self, rows: &[Row]) -> Result<()> {
        self.check_instruments(rows)?;
        let curves = self.structures.len() * rows.len();
        if self.figure.output.is_some() && self.structures.len() > 1 && curves > MOST_CURVES {
            return Err(Error::input(format!(
                "-o: {curves} curves of {} structures do not fit one figure, which holds {MOST_CURVES}; give fewer, or --summary in place of -o",
                self.structures.len()
            )));
        }
        Ok(())
    }

    /// Reads the measurements, says how, and refuses one that has nothing in common with the wavelengths.
    fn measured(&self) -> Result<Option<Measurements>> {
        if self.measured.is_empty() {
            return Ok(None);
        }
        let scale = self.measured_unit.map(Into::into);
        let found = read_measurements(&self.measured, self.column.as_deref(), scale)?;
        self.say_readings(&found);
        let nothing = Spectrum::new(self.wavelengths.clone(), vec![0.0; self.wavelengths.len()])?;
        for at in &found.angles {
            Comparison::of(&nothing, &at.measured.mean, None).map_err(|e| e.at(self.measured_name()))?;
        }
        Ok(Some(found))
    }

    /// How files were read; of many the first and at which angles they are, and all where whatever is decided is wanted.
    fn say_readings(&self, Measurements { reading, angles }: &Measurements) {
        if self.common.verbose || reading.len() <= FEW_READINGS {
            reading.iter().for_each(|one| self.common.say(one));
            return;
        }
        self.common.say(&format!(
            "{}; and {} more (-v says how each was read)",
            reading[0],
            counted(reading.len() - 1, "file")
        ));
        let said: Vec<String> = angles.iter().filter_map(|at| Some(format!("{}°", at.angle_deg?))).collect();
        if !said.is_empty() {
            self.common.say(&format!("measured at {}: {}", counted(said.len(), "angle"), said.join(", ")));
        }
    }

    /// What the measurements are called.
    fn measured_name(&self) -> String {
        match &self.measured[..] {
            [one] => one.clone(),
            several => counted(several.len(), "measurement"),
        }
    }

    /// The angles of incidence, degrees: those that are asked for, else those at which was measured.
    fn angles(&self, measured: Option<&Measurements>) -> Result<Vec<f64>> {
        let said = measured.and_then(Measurements::angles_deg);
        let Some(asked) = &self.angle else { return Ok(said.unwrap_or_else(|| vec![0.0])) };
        let none = measured.is_some_and(|found| asked.0.iter().all(|angle| found.at(*angle).is_none()));
        if let (true, Some(said)) = (none, said) {
            let said: Vec<String> = said.iter().map(|angle| format!("{angle}°")).collect();
            return Err(Error::input(format!(
                "--angle: none of them was measured, which was at {}; leave --angle out to take those",
                said.join(", ")
            )));
        }
        Ok(asked.0.clone())
    }

    fn simulate(&self, structures: &[Subject], asked: Asked) -> Result<Vec<Found>> {
        let terminal = Terminal::new(&self.common);
        let label = format!("simulating {} structures", structures.len());
        let several = (structures.len() > 1).then(|| Several::begin(&terminal, &label, structures.len()));
        let mut all = Vec::with_capacity(structures.len());
        for (typed, structure) in self.structures.iter().zip(structures) {
            let found = match several.as_ref().map(Several::part) {
                Some(part) => self.one(typed, structure, asked, &part).map_err(|e| e.at(shortened(typed)))?,
                None => self.one(typed, structure, asked, &terminal)?,
            };
            all.push(found);
        }
        Ok(all)
    }

    fn one(&self, typed: &str, subject: &Subject, asked: Asked, progress: &dyn Progress) -> Result<Found> {
        let structure = match subject {
            Subject::Structure(structure) => structure,
            Subject::Material(material) => {
                let mean = self.of_material(typed, material, asked.rows, progress)?;
                let [std, mirror] =
                    [0.0, 1.0].map(|value| vec![vec![value; self.wavelengths.len()]; mean.len()]);
                let spectra = Spectra { mean, std, mirror, beside_white: true };
                return self.found(typed.to_owned(), &figures::title(material), spectra, None, asked);
            }
        };
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
        if self.sure.is_asked() {
            check_individuals(structure, instances).map_err(|e| Error::input(format!("--{e}")))?;
        }
        let (spectra, individuals) = self.spectra(typed, structure, instances, asked.rows, progress)?;
        self.say_grazing(&spectra, structure.width_um(), asked.rows);
        let core_fringes = match instances {
            // What one individual has is no mean's.
            1 => None,
            _ => core_fringes(structure, self.common.seed, instances, &self.wavelengths)?,
        };
        // Turned over by its name, by --side, or by both and so not at all.
        let upper = typed.strip_suffix(Side::BELOW).unwrap_or(typed);
        let name = match structure.side() {
            Side::Above => upper.to_owned(),
            Side::Below => upper.to_owned() + Side::BELOW,
        };
        let found = self.found(name, &structure.name(), spectra, Some(&individuals), asked)?;
        let intervals = self.intervals(typed, &found, &individuals, asked, progress)?;
        Ok(Found {
            intervals,
            individuals: self.individuals.then_some(individuals),
            core_fringes: core_fringes.filter(CoreFringes::mislead),
            ..found
        })
    }

    /// All that is reflected or, with instruments, what they read.
    fn spectra(
        &self,
        typed: &str,
        structure: &Structure,
        instances: usize,
        rows: &[Row],
        progress: &dyn Progress,
    ) -> Result<(Spectra, Individuals)> {
        let fewer = "fewer --wavelengths, angles, --instances or --threads";
        let mut mounts = self.mounts(typed, rows)?;
        let vanes = mounts.iter_mut().filter_map(|mount| mount.vane.as_mut());
        vanes.for_each(|vane| vane.width_um = structure.width_um());
        if !mounts.is_empty() {
            let request = self.reading_request(mounts, instances);
            self.common.check_memory("this spectrum", reading_bytes(structure, &request)?, fewer)?;
            return readings_and_individuals(structure, &request, progress);
        }
        let direction = |row: &Row| match self.plane {
            Plane::Across => (0.0, row.angle_deg.to_radians()),
            Plane::Along => (row.angle_deg.to_radians(), 0.0),
        };
        let request = SpectrumRequest {
            wavelengths: self.wavelengths.clone(),
            directions: rows.iter().map(direction).collect(),
            instances,
            seed: self.common.seed,
            collect: self.collect,
            polarization: self.polarization,
        };
        self.common.check_memory("this spectrum", spectrum_bytes(structure, &request)?, fewer)?;
        spectra_and_individuals(structure, &request, progress)
    }

    /// Spectra with the numbers of their colours and of the comparison.
    fn found(
        &self,
        typed: String,
        name: &str,
        spectra: Spectra,
        individuals: Option<&Individuals>,
        asked: Asked,
    ) -> Result<Found> {
        let means = spectra
            .mean
            .iter()
            .map(|mean| Spectrum::new(self.wavelengths.clone(), mean.clone()))
            .collect::<Result<Vec<_>>>()?;
        let peak_range = self.peak.within(&self.wavelengths)?;
        let comparisons = match asked.measured {
            Some(_) => self.comparisons(&means, individuals, asked)?,
            None => Vec::new(),
        };
        Ok(Found {
            typed,
            name: name.strip_suffix(":default").unwrap_or(name).to_owned(),
            instances: individuals.map_or(1, Individuals::count),
            spectra,
            individuals: None,
            core_fringes: None,
            looks: Look::series(&self.law_angles_deg(asked.rows), &means, Origin::Computed, peak_range),
            comparisons,
            intervals: None,
            sights: Vec::new(),
            has_guess: false,
        })
    }

    /// Each mean against what was measured at its angle, with how individuals differ.
    fn comparisons(
        &self,
        means: &[Spectrum],
        individuals: Option<&Individuals>,
        asked: Asked,
    ) -> Result<Vec<Option<Comparison>>> {
        let peak_range = self.peak.within(&self.wavelengths)?;
        let compared = |(a, mean): (usize, &Spectrum)| {
            let Some(measured) = asked.measured_at(a) else { return Ok(None) };
            let of = |all: &Individuals| {
                (0..all.count())
                    .map(|i| Spectrum::new(self.wavelengths.clone(), all.of(i, a).to_vec()))
                    .collect::<Result<Vec<_>>>()
            };
            let simulated = individuals.map_or(Ok(Vec::new()), of)?;
            let samples: Vec<Spectrum> = measured.samples.iter().map(|s| s.spectrum.clone()).collect();
            let found = Comparison::of(mean, &measured.mean, peak_range)?;
            Ok(Some(found.with_individuals(&simulated, &samples)))
        };
        means.iter().enumerate().map(compared).collect()
    }

    /// Says where light grazes so that the simulation is off, and where more than all of it comes back.
    fn say_grazing(&self, found: &Spectra, width_um: f64, rows: &[Row]) {
        if let Some(Over { direction, wavelength, reflected, count }) = found.over() {
            self.common.say(&format!(
                "at {} and {} nm {:.1} % of the light come back, more than all of it: this structure is beyond what single reflections describe ({count} values are flagged)",
                self.row_name(&rows[direction]),
                self.wavelengths[wavelength],
                100.0 * reflected
            ));
        }
        let Some(Grazing { direction, wavelength, mirror_fraction, flagged }) = found.grazing() else {
            return;
        };
        let incidence = self.row_name(&rows[direction]);
        let said = grazing(&incidence, self.wavelengths[wavelength], width_um, mirror_fraction);
        let all = found.mean.len() * self.wavelengths.len();
        self.common.say(&format!("{said} ({flagged} of {all} values are flagged)"));
    }
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
