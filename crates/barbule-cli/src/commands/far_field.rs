//! `barbule far-field`: what one instance scatters, at one wavelength and direction or over sets of them.

mod output;

use std::io::Write;
use std::path::PathBuf;

use barbule::clock;
use barbule::figures;
use barbule::scattering::far_field::{Illumination, Window};
use barbule::solve::far_fields::{
    ELEMENTS, ELEMENTS_PER_WAVELENGTH, Illuminations, Method, Prepared, Scattered, Settings, bytes,
};
use barbule::solve::surface::{LARGEST_MIRROR_ERROR, mirror_fraction};
use barbule::solve::{FAST, METHODS, method};
use barbule::{Error, Result};
use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::campaign::grazing;
use crate::common::{Common, duration, print, print_json};
use crate::figure::FigureArgs;
use crate::progress::Terminal;
use crate::provenance::{Provenance, check_outputs};
use crate::structure_arg::SideArg;
use crate::{sets, structure_arg};
use output::{Document, csv, summary, table};

/// What far fields and their texts may take in memory unless `--memory` says otherwise.
const USUAL_MEMORY: u64 = 4 << 30;

/// Far fields that take longer are announced, s.
const SOON_SECONDS: f64 = 20.0;

/// Bytes of the program with a section that is prepared.
const PREPARED_BYTES: u64 = 24_000_000;

/// Bytes of text for each outgoing azimuth, at most: the ten numbers of JSON and of CSV.
const TEXT_OF_JSON: u64 = 480;
const TEXT_OF_CSV: u64 = 260;

/// Arguments of `barbule far-field`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  barbule far-field starling --wavelength 520 --theta 0 --phi 30 --json\n  \
    barbule far-field starling --wavelength 400:700:10 --theta 0 --phi 30 -o map.png --csv fields.csv\n  \
    barbule far-field mallard --side below --wavelength 520 --theta 0 --phi=-30 --json\n  \
    barbule far-field hummingbird --smooth off --wavelength 550 --theta 0 --phi 0\n  \
    barbule far-field examples/rods.json --solver full-wave --wavelength 500 --theta 30 --phi 0"
)]
pub(crate) struct Args {
    #[arg(help = structure_arg::HELP)]
    structure: String,
    /// Vacuum wavelengths in nm: 520, or 400,442,484, or 400:694:6
    #[arg(long, visible_alias = "wavelengths", value_name = "SET",
        value_parser = |text: &str| sets::wavelengths_of("--wavelength", text).map(Wavelengths))]
    wavelength: Wavelengths,
    /// Longitudinal angles of incidence in degrees
    #[arg(long, value_name = "SET", allow_hyphen_values = true,
        value_parser = |text: &str| sets::angles("--theta", text))]
    theta: sets::Angles,
    /// Azimuths of incidence in degrees
    #[arg(long, value_name = "SET", allow_hyphen_values = true,
        value_parser = |text: &str| sets::angles("--phi", text))]
    phi: sets::Angles,
    #[command(flatten)]
    side: SideArg,
    /// Which random instance, from 0
    #[arg(long, value_name = "K", default_value_t = 0)]
    instance: usize,
    /// Number of outgoing azimuths
    #[arg(long, value_name = "N", default_value_t = 400)]
    azimuths: usize,
    /// How to compute
    #[arg(long, default_value = FAST.name, value_parser = solvers())]
    solver: Method,
    /// How the light falls on the section
    #[arg(long, value_enum, default_value_t = WindowArg::Gaussian)]
    window: WindowArg,
    /// Of full waves: nodes per wavelength in the denser medium at each boundary [default: 10]
    #[arg(long, value_name = "N", value_parser = elements)]
    elements: Option<f64>,
    #[command(flatten)]
    figure: FigureArgs,
    /// Write a table, one row for each outgoing azimuth
    #[arg(long, value_name = "F")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// Nodes per wavelength that make sense.
pub(super) fn elements(text: &str) -> std::result::Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|elements| ELEMENTS.contains(elements));
    let [least, most] = [ELEMENTS.start(), ELEMENTS.end()];
    number.ok_or_else(|| format!("{text} is not a number of nodes per wavelength from {least} to {most}"))
}

/// Vacuum wavelengths in nm, rising.
#[derive(Debug, Clone)]
struct Wavelengths(Vec<f64>);

/// Reads the name of a solver.
fn solvers() -> impl TypedValueParser<Value = Method> {
    let names = METHODS.iter().map(|method| PossibleValue::new(method.name).help(method.about));
    PossibleValuesParser::new(names).try_map(|name| method(&name).ok_or("is no solver"))
}

/// Windows of the incident light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum WindowArg {
    /// Light of limited coherence, the same on the top wherever it rises; full waves take a beam
    Gaussian,
    /// A beam that has this window on the plane z = 0
    Beam,
    /// A plane wave
    None,
}

/// The directions as they were typed, in degrees, with what came out.
struct Fields<'a> {
    wavelengths_nm: &'a [f64],
    theta_deg: &'a [f64],
    phi_deg: &'a [f64],
    found: &'a [Scattered],
    /// None of exact solvers.
    mirrors: &'a [Mirror],
}

/// How far the simulation is off near grazing: what it makes a flat perfect mirror as wide reflect; none under a plane wave.
struct Mirror {
    fraction: Option<f64>,
}

impl Mirror {
    fn is_flagged(&self) -> bool {
        self.error() > LARGEST_MIRROR_ERROR
    }

    fn error(&self) -> f64 {
        self.fraction.map_or(0.0, |fraction| (fraction - 1.0).abs())
    }
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        if !(2..=100_000).contains(&self.azimuths) {
            return Err(Error::input(format!(
                "--azimuths {}: give a number from 2 to 100000",
                self.azimuths
            )));
        }
        let illuminations = self.illuminations();
        self.check_size(illuminations.count())?;
        if self.solver.is_exact && self.side.is_smoothed() {
            return Err(Error::input(format!(
                "--smooth is of the fast simulation's formulas; {}s need none",
                self.solver.noun
            )));
        }
        if self.elements.is_some() && !self.solver.is_exact {
            self.common.idle("--elements", "it is of full waves; give --solver full-wave");
        }
        self.figure.check(&self.common)?;
        check_outputs(self.figure.path(), self.csv.as_deref())?;
        if self.figure.output.is_some() {
            figures::check_far_fields(&illuminations).map_err(|error| error.at("--output"))?;
        }
        let structure = self.side.open(&self.structure, &self.common)?;
        let section = structure.instance(self.common.seed, self.instance)?;
        let solver = (self.solver.solver)(&self.settings());
        let found = self.scatter(&*solver.prepare(&section)?, &illuminations)?;
        let mirrors = match self.solver.is_exact {
            true => Vec::new(),
            false => self.mirrors(&illuminations, section.width_um),
        };
        let title = self.title(&figures::heading(&structure.name()));
        let provenance = Provenance::new(&self.common);
        if let Some(path) = self.figure.path() {
            let (heading, page) = (self.figure.title(title.as_str()), self.figure.page()?);
            let drawing = figures::far_fields(&heading, &illuminations, &found, &page)?;
            provenance.write_figure(path, &drawing)?;
            self.common.wrote(path, &format!("intensity against the outgoing azimuth, {title}"));
        }
        let fields = Fields {
            wavelengths_nm: &self.wavelength.0,
            theta_deg: &self.theta.0,
            phi_deg: &self.phi.0,
            found: &found,
            mirrors: &mirrors,
        };
        if let Some(path) = &self.csv {
            provenance.write_csv(path, &csv(&fields))?;
            let rows = found.len() * self.azimuths;
            self.common.wrote(path, &format!("{} far fields of {title}, {rows} rows", found.len()));
        }
        if self.common.json {
            return print_json(out, &Document(&fields));
        }
        if self.figure.output.is_some() || self.csv.is_some() {
            return Ok(());
        }
        match &found[..] {
            [one] => print(out, &format!("{title}\n{}", table(one))),
            _ => print(out, &format!("{title}\n{}", summary(&fields))),
        }
    }

    fn illuminations(&self) -> Illuminations {
        let radians = |angles: &sets::Angles| angles.0.iter().map(|angle| angle.to_radians()).collect();
        Illuminations {
            wavelengths_nm: self.wavelength.0.clone(),
            theta_i: radians(&self.theta),
            phi_i: radians(&self.phi),
            window: match self.window {
                WindowArg::Gaussian => Window::Gaussian,
                WindowArg::Beam => Window::Beam,
                WindowArg::None => Window::PlaneWave,
            },
        }
    }

    fn settings(&self) -> Settings {
        Settings {
            elements_per_wavelength: self.elements.unwrap_or(ELEMENTS_PER_WAVELENGTH),
            memory_bytes: self.common.allowance().bytes,
            clock: clock::system,
        }
    }

    /// What the section scatters, after refusing what does not fit into memory and saying what takes long.
    fn scatter(&self, section: &dyn Prepared, illuminations: &Illuminations) -> Result<Vec<Scattered>> {
        let Method { noun, smaller, .. } = self.solver;
        if !section.changes().is_empty() {
            self.common.say(&format!("closed for {noun}s: {}", section.changes().join("; ")));
        }
        let progress = Terminal::new(&self.common);
        let cost = section.cost(illuminations, self.azimuths, rayon::current_num_threads(), &progress)?;
        self.common.allowance().check(&format!("this {noun}"), cost.bytes, smaller)?;
        if let Some(seconds) = cost.seconds {
            let said = format!(
                "{noun}s: {} unknowns, {:.2} GB of memory, about {}",
                cost.unknowns,
                cost.bytes as f64 / 1e9,
                duration(seconds)
            );
            if seconds > SOON_SECONDS {
                self.common.say(&said);
            } else {
                self.common.explain(&said);
            }
        }
        section.scatter(illuminations, self.azimuths, &progress)
    }

    /// What a mirror would reflect in each case; says where the simulation is off, by the worst case.
    fn mirrors(&self, illuminations: &Illuminations, width_um: f64) -> Vec<Mirror> {
        let fraction = |light: &Illumination| {
            (light.window != Window::PlaneWave)
                .then(|| mirror_fraction(width_um, light.wavelength_nm, light.theta_i, light.phi_i))
        };
        let lights: Vec<Illumination> = illuminations.iter().collect();
        let mirrors: Vec<Mirror> = lights.iter().map(|light| Mirror { fraction: fraction(light) }).collect();
        let worst = mirrors.iter().zip(&lights).max_by(|(a, _), (b, _)| a.error().total_cmp(&b.error()));
        if let Some((Mirror { fraction: Some(fraction) }, light)) =
            worst.filter(|(mirror, _)| mirror.is_flagged())
        {
            let [theta, phi] = [light.theta_i, light.phi_i].map(f64::to_degrees);
            let incidence = format!("θ = {theta:.6}°, φ = {phi:.6}°");
            let said = grazing(&incidence, light.wavelength_nm, width_um, *fraction);
            let flagged = mirrors.iter().filter(|mirror| mirror.is_flagged()).count();
            self.common.say(&match mirrors.len() {
                1 => said,
                all => format!("{said} ({flagged} of {all} far fields are flagged)"),
            });
        }
        mirrors
    }

    /// Refuses, before any work, more far fields than there is memory for.
    fn check_size(&self, count: usize) -> Result<()> {
        let allowed = self.common.memory.unwrap_or(USUAL_MEMORY);
        let texts = TEXT_OF_JSON * u64::from(self.common.json) + TEXT_OF_CSV * u64::from(self.csv.is_some());
        let azimuths = (count as u64).saturating_mul(self.azimuths as u64);
        let needed = bytes(count, self.azimuths)
            .saturating_add(azimuths.saturating_mul(texts))
            .saturating_add(PREPARED_BYTES);
        if needed <= allowed {
            let what = format!("{count} far fields on {} azimuths", self.azimuths);
            self.common.say_memory(&what, needed);
            return Ok(());
        }
        Err(Error::input(format!(
            "{count} far fields on {} azimuths need {:.1} MB of memory, but {:.1} MB are allowed; give fewer, or raise --memory",
            self.azimuths,
            needed as f64 / 1e6,
            allowed as f64 / 1e6
        )))
    }

    /// What is lit how.
    fn title(&self, structure: &str) -> String {
        let set = |values: &[f64], unit: &str| match values {
            [one] => format!("{one}{unit}"),
            [first, .., last] => format!("{first} to {last}{unit} ({} values)", values.len()),
            [] => String::new(),
        };
        format!(
            "{structure}, instance {}, {}, θ_i = {}, φ_i = {}",
            self.instance,
            set(&self.wavelength.0, " nm"),
            set(&self.theta.0, "°"),
            set(&self.phi.0, "°")
        )
    }
}
