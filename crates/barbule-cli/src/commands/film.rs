//! `barbule film`: what flat layers reflect, transmit and absorb.

mod figure;
mod tables;

use std::io::Write;
use std::path::PathBuf;

use barbule::film::{self, Deviations, Ensemble, Sweep};
use barbule::open;
use barbule::spectrum::look::Look;
use barbule::spectrum::peaks::Origin;
use barbule::spectrum::{Spectrum, Wavelengths};
use barbule::stack::Stack;
use barbule::{Error, Result};

use crate::common::{Common, LEAST_MEMORY, print, print_json};
use crate::figure::FigureArgs;
use crate::peak_args::PeakArgs;
use crate::progress::Terminal;
use crate::provenance::{Provenance, check_outputs};
use crate::sets;

/// Bytes of text for each wavelength and angle, at most: of a table on the screen, of CSV, of JSON, and there of each layer.
const TEXT_OF_TABLE: u64 = 420;
const TEXT_OF_CSV: u64 = 480;
const TEXT_OF_JSON: u64 = 1700;
const TEXT_OF_LAYER: u64 = 120;

/// What a sweep may take in memory unless `--memory` says otherwise.
const USUAL_MEMORY: u64 = 4 << 30;
/// Individuals of a stack whose thicknesses spread.
const USUAL_INSTANCES: usize = 50;
/// Fewer samples make no colour.
const FEWEST_SAMPLES: usize = 10;

/// Arguments of `barbule film`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  barbule film 'air/6*(melanin:99/keratin:100)/keratin' --angles 0,30,60 -o film.svg\n\nThicknesses may spread between individuals:\n  barbule film 'air/keratin:200±5%/melanin:300/air' --instances 100"
)]
pub(crate) struct Args {
    /// A stack, as in 'air/keratin:595/air' or 'air/keratin:595±5%/air', or a TOML file
    stack: String,
    /// Wavelengths in nm: 520, or 400,442,484, or 400:694:6
    #[arg(long, visible_alias = "wavelength", value_name = "SET", default_value = "400:694:6",
        value_parser = sets::wavelength_set)]
    wavelengths: Wavelengths,
    /// Angles from the normal in the first medium in degrees
    #[arg(long, visible_alias = "angle", value_name = "SET", default_value = "0", allow_hyphen_values = true,
        value_parser = |text: &str| sets::angles("--angles", text))]
    angles: sets::Angles,
    /// Random individuals of a stack whose thicknesses spread, as in keratin:200±5% [default: 50]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    instances: Option<u64>,
    #[command(flatten)]
    peak: PeakArgs,
    #[command(flatten)]
    figure: FigureArgs,
    /// Write a table: `angle_deg,wavelength_nm,R_s,R_p,T_s,T_p,A_s,A_p,R,T,A`, the last three unpolarized
    #[arg(long, value_name = "F")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// What is shown: one stack's response, or means over individuals.
struct Found {
    mean: Sweep,
    angle_deg: Vec<f64>,
    spread: Option<Spread>,
}

/// The standard deviations between individuals.
struct Spread {
    std: [Deviations; 2],
    unpolarized: Vec<f64>,
    individuals: usize,
}

/// The looks of unpolarized, s and p light at one angle.
struct Looks {
    angle_deg: f64,
    unpolarized: Look,
    s: Look,
    p: Look,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        let peak_range = self.peak.within(&self.wavelengths)?;
        self.figure.check(&self.common)?;
        check_outputs(self.figure.path(), self.csv.as_deref())?;
        let media = self.common.opening()?.media;
        let stack = open::stack(&self.stack, media.library())?;
        let used: Vec<&str> = (0..stack.layers() + 2).map(|region| stack.medium(region)).collect();
        self.common.say_unused(&self.stack, &media.unused(&used));
        if let Some(doubt) = stack.doubt() {
            self.common.say(&doubt);
        }
        self.check_memory(&stack)?;
        let found = self.find(&stack)?;
        if media.guesses(&used, self.wavelengths.range_nm().0) {
            self.common.say_guessed();
        }
        let looks = found.looks(peak_range)?;
        let provenance = Provenance::new(&self.common);
        let shown = format!("{} at {} wavelengths", angles(&found.angle_deg), found.mean.at.len());
        if let Some(path) = self.figure.path() {
            let title = self.figure.title(self.stack.as_str());
            provenance.write_figure(path, &figure::figure(&title, &found, &self.figure.page()?))?;
            self.common.wrote(path, &format!("R, T and A at {shown}"));
        }
        if let Some(path) = &self.csv {
            provenance.write_csv(path, &tables::csv(&found))?;
            self.common.wrote(path, &format!("R, T and A at {shown}"));
        }
        if self.common.json {
            return print_json(out, &tables::document(&found, &looks, stack.layers()));
        }
        let words = tables::words(&found, &looks);
        if self.figure.output.is_none() && self.csv.is_none() {
            return print(out, &[vec![tables::table(&found)], words].concat().join("\n"));
        }
        if words.is_empty() { Ok(()) } else { print(out, &words.join("\n")) }
    }

    fn find(&self, stack: &Stack) -> Result<Found> {
        let (at, angle_deg) = (&self.wavelengths, self.angles.0.clone());
        self.common.explain(&format!(
            "{} layers, {} wavelengths, {} angles",
            stack.layers(),
            at.len(),
            angle_deg.len()
        ));
        let angle: Vec<f64> = angle_deg.iter().map(|a| a.to_radians()).collect();
        let progress = Terminal::new(&self.common);
        if !stack.is_random() {
            if self.instances.is_some() {
                self.common.say(
                    "--instances has no effect: no thickness of this stack spreads, as keratin:200±5% does",
                );
            }
            let mean = film::sweep(stack, at, &angle, &progress)?;
            mean.doubt(stack).iter().for_each(|doubt| self.common.say(doubt));
            return Ok(Found { mean, angle_deg, spread: None });
        }
        let count = self.instances.map_or(USUAL_INSTANCES, |count| count as usize);
        let found = film::ensemble(stack, at, &angle, count, self.common.seed, &progress)?;
        let Ensemble { mean, std, unpolarized_std, individuals } = found;
        Ok(Found { mean, angle_deg, spread: Some(Spread { std, unpolarized: unpolarized_std, individuals }) })
    }

    fn check_memory(&self, stack: &Stack) -> Result<()> {
        let (wavelengths, angles) = (self.wavelengths.len(), self.angles.0.len());
        let allowed = self.common.memory.unwrap_or(USUAL_MEMORY);
        // One individual at a time, beside the means.
        let tables = if stack.is_random() { 2 } else { 1 };
        let places = (wavelengths as u64).saturating_mul(angles as u64);
        let of_json = TEXT_OF_JSON + TEXT_OF_LAYER * stack.layers() as u64;
        // One text after the other.
        let text = [(self.csv.is_some(), TEXT_OF_CSV), (self.common.json, of_json)];
        let text = text.into_iter().filter(|(asked, _)| *asked).map(|(_, bytes)| bytes).max();
        let needed = film::bytes(stack.layers(), wavelengths, angles)
            .saturating_mul(tables)
            .saturating_add(places.saturating_mul(text.unwrap_or(TEXT_OF_TABLE)))
            .saturating_add(LEAST_MEMORY as u64);
        if needed <= allowed {
            let what = format!("{wavelengths} wavelengths at {angles} angles");
            self.common.say_memory(&what, needed);
            return Ok(());
        }
        Err(Error::input(format!(
            "{wavelengths} wavelengths at {angles} angles through {} layers need {} MB of memory, but {} MB are allowed; give fewer, or raise --memory",
            stack.layers(),
            needed / 1_000_000,
            allowed / 1_000_000
        )))
    }
}

impl Found {
    /// The numbers of the colours, angle by angle; none of too few samples.
    fn looks(&self, peak_range_nm: Option<[f64; 2]>) -> Result<Vec<Looks>> {
        let at = &self.mean.at;
        if at.len() < FEWEST_SAMPLES {
            return Ok(Vec::new());
        }
        let [s, p] = &self.mean.polarization;
        let series = |values: &[f64]| {
            let rows = values.chunks_exact(at.len()).map(|row| Spectrum::new(at.clone(), row.to_vec()));
            Ok::<_, Error>(Look::series(
                &self.angle_deg,
                &rows.collect::<Result<Vec<_>>>()?,
                Origin::Computed,
                peak_range_nm,
            ))
        };
        let [unpolarized, s, p] =
            [&self.mean.unpolarized(), &s.reflected, &p.reflected].map(|values| series(values));
        let all = self.angle_deg.iter().zip(unpolarized?).zip(s?.into_iter().zip(p?));
        Ok(all.map(|((&angle_deg, unpolarized), (s, p))| Looks { angle_deg, unpolarized, s, p }).collect())
    }
}

/// The angles in words: all of a few, else their number.
fn angles(angle_deg: &[f64]) -> String {
    if angle_deg.len() > 4 {
        return format!("{} angles", angle_deg.len());
    }
    angle_deg.iter().map(|angle| format!("{angle}°")).collect::<Vec<_>>().join(", ")
}
