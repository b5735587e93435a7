//! `barbule see`: whether a bird tells things apart.

use std::io::Write;
use std::path::PathBuf;

use barbule::error::{counted, shortened};
use barbule::figures::{self, Seen};
use barbule::open::{self, Simulation, Thing};
use barbule::spectrum::colour::D65_WHITE;
use barbule::spectrum::difference::{delta_e_2000, lab};
use barbule::spectrum::look::Look;
use barbule::spectrum::{Spectrum, Wavelengths};
use barbule::vision::{Compared, Differences, Eye, View};
use barbule::{Error, Result};
use serde_json::{Value, json};

use crate::bird_args::{self, REACH, tetrahedral_json};
use crate::common::{Common, print, print_json};
use crate::figure::FigureArgs;
use crate::progress::Terminal;
use crate::provenance::{Provenance, check_outputs, csv_cell};
use crate::sets;
use crate::structure_arg::with_advice;

/// Things that are looked at together.
const MOST_THINGS: usize = 1000;

/// How structures are simulated where nothing is said: wavelengths in nm, and individuals.
const USUAL_NM: &str = "300:700:4";
const USUAL_INSTANCES: usize = 50;

/// Curves that a figure holds.
const MOST_CURVES: usize = 18;

/// Arguments of `barbule see`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  barbule see mine.csv 'air/keratin:320/melanin' --bird starling -o both.svg
  barbule see mine.csv --samples --bird blue-tit --illuminant forest
  barbule see mine.csv 'air/keratin:330/melanin' --bird average-uvs --ratio 1,2,2,4

Catches are of quanta, each cone's over those of white in the same light (von Kries). ΔS is in just noticeable \
differences (receptor noise), once with the Weber fraction that of the longest cones, once that of the rarest; ΔL is by the \
double cones; ΔE is CIEDE2000 to people. Hue θ, φ and chroma r are those of the tetrahedron.")]
pub(crate) struct Args {
    /// Measured spectra as `spectrum --measured` reads them, or structures as `spectrum` takes them
    #[arg(value_name = "FILE|STRUCTURE", required = true)]
    structures: Vec<String>,
    #[arg(long, value_name = "NAME|FILE", help = bird_args::BIRD)]
    bird: String,
    #[arg(long, value_name = "NAME|FILE", default_value = "D65", help = bird_args::LIGHT)]
    illuminant: String,
    /// How many cones of each class there are, from short to long wavelengths, as in 1,2,2,4 [default: the bird's]
    #[arg(long, value_name = "SET")]
    ratio: Option<String>,
    /// Weber fraction of the longest cones [default: the bird's]
    #[arg(long, value_name = "W")]
    weber: Option<f64>,
    /// Weber fraction of the double cones [default: the bird's]
    #[arg(long, value_name = "W")]
    weber_double: Option<f64>,
    /// Every sample of a file by itself, not their mean
    #[arg(long)]
    samples: bool,
    /// Angle of incidence of structures, degrees, across the barbule [default: 0]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true,
        value_parser = |text: &str| sets::angles("--angle", text))]
    angle: Option<sets::Angles>,
    /// Random individuals of structures [default: 50]
    #[arg(long, value_name = "N")]
    instances: Option<usize>,
    /// Wavelengths of structures in nm (also --wavelength) [default: 300:700:4]
    #[arg(long, alias = "wavelength", value_name = "SET", value_parser = sets::wavelength_set)]
    wavelengths: Option<Wavelengths>,
    #[command(flatten)]
    figure: FigureArgs,
    /// Write a table of every pair: its differences
    #[arg(long, value_name = "F")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// Everything that is told.
struct Found {
    things: Vec<Thing>,
    view: View,
    compared: Compared,
    /// CIEDE2000 of each thing from each.
    delta_e: Differences,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        self.figure.check(&self.common)?;
        check_outputs(self.figure.path(), self.csv.as_deref())?;
        let simulation = self.simulation()?;
        let view = bird_args::view(self.eye()?, open::light(&self.illuminant)?)?;
        let things = self.things(&view, &simulation)?;
        let spectra: Vec<Spectrum> = things.iter().map(|thing| thing.reflectance.clone()).collect();
        self.say_idle(&view, things.len());
        let compared = view.compare(&spectra).map_err(|(i, error)| error.at(&things[i].name))?;
        let found = Found { delta_e: delta_e(&spectra), things, view, compared };
        self.write(&found)?;
        if self.common.json { print_json(out, &found.document()) } else { found.print(out) }
    }

    fn eye(&self) -> Result<Eye> {
        let mut eye = open::eye(&self.bird).map_err(|error| error.at("--bird"))?;
        for (flag, given, to) in [
            ("--weber", self.weber, &mut eye.weber),
            ("--weber-double", self.weber_double, &mut eye.weber_double),
        ] {
            let Some(given) = given else { continue };
            if !(given > 0.0 && given <= 10.0) {
                return Err(Error::input(format!(
                    "{flag} {given}: give a number over 0 and up to 10, as in 0.1"
                )));
            }
            *to = given;
        }
        match &self.ratio {
            None => Ok(eye),
            Some(set) => {
                eye.with_abundance(&sets::parse("--ratio", set)?).map_err(|error| error.at("--ratio"))
            }
        }
    }

    /// Says which flags change no difference.
    fn say_idle(&self, view: &View, things: usize) {
        if self.weber_double.is_some() && view.eye.double.is_none() {
            self.common.idle("--weber-double", "this eye has no double cones");
        }
        if things > 1 {
            return;
        }
        for (flag, is_given) in [
            ("--weber", self.weber.is_some()),
            ("--weber-double", self.weber_double.is_some()),
            ("--ratio", self.ratio.is_some()),
        ] {
            if is_given {
                self.common.idle(flag, "one thing has no differences");
            }
        }
    }

    /// How structures are simulated.
    fn simulation(&self) -> Result<Simulation> {
        let instances = self.instances.unwrap_or(USUAL_INSTANCES);
        if !(1..=10_000).contains(&instances) {
            return Err(Error::input(format!("--instances {instances}: give a number from 1 to 10000")));
        }
        let angle = match self.angle.as_ref().map(|angles| &angles.0[..]) {
            None => 0.0,
            Some([angle]) => angle.to_radians(),
            Some(angles) => {
                return Err(Error::input(format!(
                    "--angle: {} angles; give one, and `barbule spectrum --bird` for several",
                    angles.len()
                )));
            }
        };
        let wavelengths = self.wavelengths.clone().map_or_else(|| sets::wavelength_set(USUAL_NM), Ok)?;
        Ok(Simulation { wavelengths, angle, instances })
    }

    fn things(&self, view: &View, simulation: &Simulation) -> Result<Vec<Thing>> {
        let opening = self.common.opening()?;
        let mut things = Vec::new();
        for text in &self.structures {
            let found = open::things(text, self.samples, simulation, &opening, &Terminal::new(&self.common))
                .map_err(|error| with_advice(error, text))?;
            if let Some(reading) = found.first().and_then(|thing| thing.reading.as_ref()) {
                self.common.say(reading);
            }
            for thing in &found {
                let range = thing.reflectance.wavelengths().range_nm();
                view.check("the reflectance", range.into())
                    .map_err(|error| error.followed_by(REACH).at(shortened(text)))?;
            }
            things.extend(found);
            if things.len() > MOST_THINGS {
                return Err(Error::input(format!(
                    "over {MOST_THINGS} things are too many at once; give fewer"
                )));
            }
        }
        if things.iter().any(|thing| thing.has_guess) {
            self.common.say_guessed();
        }
        if self.samples && things.iter().all(|thing| thing.reading.is_none()) {
            self.common.idle("--samples", "nothing that is seen is measured");
        }
        // What is measured says how it was read.
        if things.iter().all(|thing| thing.reading.is_some()) {
            for (flag, is_given) in [
                ("--angle", self.angle.is_some()),
                ("--instances", self.instances.is_some()),
                ("--wavelengths", self.wavelengths.is_some()),
            ] {
                if is_given {
                    self.common.idle(flag, "all that is seen is measured, and no structure simulated");
                }
            }
        }
        Ok(things)
    }

    fn write(&self, found: &Found) -> Result<()> {
        let provenance = Provenance::new(&self.common)
            .with("bird", &found.view.eye.name)
            .with("illuminant", &found.view.light.name);
        let shown = format!("{} as {} sees them", counted(found.things.len(), "thing"), found.view.eye.name);
        if let Some(path) = self.figure.path() {
            if found.things.len() > MOST_CURVES {
                return Err(Error::input(format!(
                    "-o: {} things do not fit one figure, which holds {MOST_CURVES}; give fewer, or --csv",
                    found.things.len()
                )));
            }
            provenance.write_figure(path, &found.figure(&self.figure)?)?;
            self.common.wrote(path, &shown);
        }
        if let Some(path) = &self.csv {
            provenance.write_csv(path, &found.table())?;
            self.common.wrote(path, &format!("differences of {shown}"));
        }
        Ok(())
    }
}

impl Found {
    fn figure(&self, flags: &FigureArgs) -> Result<barbule::plot::Drawing> {
        let eye = &self.view.eye;
        let each = self.things.iter().zip(&self.compared.tetrahedral);
        let seen: Vec<Seen> = each
            .map(|(thing, place)| Seen {
                name: thing.name.clone(),
                reflectance: thing.reflectance.clone(),
                tetrahedral: *place,
            })
            .collect();
        let title = flags.title(format!("{} in {}", eye.name, self.view.light.name));
        let has_guess = self.things.iter().any(|thing| thing.has_guess);
        figures::seen(&title, eye, &seen, has_guess, &flags.page()?)
    }

    /// Pairs in which the first comes before the second.
    fn pairs(&self) -> impl Iterator<Item = (usize, usize)> {
        let count = self.things.len();
        (0..count).flat_map(move |i| (i + 1..count).map(move |j| (i, j)))
    }

    fn table(&self) -> String {
        let mut text = String::from("one,other,delta_s,delta_s_rarest,delta_l,delta_e\n");
        let cell = |value: Option<f64>| value.map_or_else(String::new, |v| v.to_string());
        for (i, j) in self.pairs() {
            let compared = &self.compared;
            let [one, other] = [i, j].map(|k| csv_cell(&self.things[k].name));
            let cells = [&compared.delta_s, &compared.delta_s_rarest, &compared.delta_l, &self.delta_e]
                .map(|differences| cell(differences[i][j]));
            text += &format!("{one},{other},{}\n", cells.join(","));
        }
        text
    }

    fn document(&self) -> Value {
        let (eye, compared) = (&self.view.eye, &self.compared);
        let abundance: Vec<f64> = eye.cones.iter().map(|cone| cone.abundance).collect();
        json!({
            "bird": eye.name,
            "illuminant": self.view.light.name,
            "items": self.things.iter().map(|thing| &thing.name).collect::<Vec<_>>(),
            "cones": eye.cones.iter().map(|cone| &cone.name).collect::<Vec<_>>(),
            "ratio": abundance,
            "weber": eye.weber,
            "weber_double": eye.weber_double,
            "catches": compared.catches.iter().map(|catches| &catches.cones).collect::<Vec<_>>(),
            "double": compared.catches.iter().map(|catches| catches.double).collect::<Vec<_>>(),
            "tetrahedral": compared.tetrahedral.iter().map(|place| place.map(tetrahedral_json)).collect::<Vec<_>>(),
            "delta_s": compared.delta_s,
            "delta_s_rarest": compared.delta_s_rarest,
            "delta_l": compared.delta_l,
            "delta_e": self.delta_e,
        })
    }

    fn print(&self, out: &mut dyn Write) -> Result<()> {
        let (eye, compared) = (&self.view.eye, &self.compared);
        let names: Vec<String> = eye.cones.iter().map(|cone| cone.name.clone()).collect();
        print(out, &format!("{} in {}, each cone over white:", eye.name, self.view.light.name))?;
        for ((thing, catches), place) in self.things.iter().zip(&compared.catches).zip(&compared.tetrahedral)
        {
            print(out, &format!("  {}: {}", thing.name, bird_args::words(&names, catches, place.as_ref())))?;
        }
        if self.things.len() < 2 {
            return Ok(());
        }
        let numbers: Vec<String> = eye.cones.iter().map(|cone| cone.abundance.to_string()).collect();
        print(
            out,
            &format!(
                "just noticeable differences, cones {}, Weber fraction {} of the longest (of the rarest in brackets):",
                numbers.join(":"),
                eye.weber
            ),
        )?;
        let number = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| format!("{v:.2}"));
        for (i, j) in self.pairs() {
            print(
                out,
                &format!(
                    "  {} – {}: ΔS {} ({}), ΔL {}, to people ΔE {}",
                    self.things[i].name,
                    self.things[j].name,
                    number(compared.delta_s[i][j]),
                    number(compared.delta_s_rarest[i][j]),
                    number(compared.delta_l[i][j]),
                    number(self.delta_e[i][j])
                ),
            )?;
        }
        Ok(())
    }
}

/// CIEDE2000 of each reflectance from each under D65; none where too much of what people see is unknown.
fn delta_e(spectra: &[Spectrum]) -> Differences {
    let colour = |spectrum: &Spectrum| Look::of(spectrum).colour.map(|colour| lab(colour.xyz, D65_WHITE));
    let colours: Vec<_> = spectra.iter().map(colour).collect();
    let of = |one: &Option<_>, other: &Option<_>| Some(delta_e_2000((*one)?, (*other)?));
    colours.iter().map(|one| colours.iter().map(|other| of(one, other)).collect()).collect()
}
