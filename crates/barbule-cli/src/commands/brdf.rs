//! `barbule brdf`: values of a material's BRDF as numbers.

use std::fmt::Write as _;
use std::io::Write;
use std::path::PathBuf;

use barbule::brdf::pictures::projected_grid;
use barbule::brdf::{FeatherBrdf, Marginal, Options, Values, marginals, values};
use barbule::error::shortened;
use barbule::figures;
use barbule::plot::Drawing;
use barbule::scattering::directions::{azimuths, omega};
use barbule::scattering::far_field::Polarization;
use barbule::{DVec3, Error, Result};
use clap::ValueEnum;
use serde_json::{Map, Value, json};

use crate::common::{Common, print, print_json};
use crate::progress::Terminal;
use crate::provenance::{Provenance, check_outputs};
use crate::{materials, sets};

/// Most values of one run: wavelengths times outgoing directions or azimuths.
const MOST_VALUES: usize = 2_000_000;

/// Bytes of the program with a material, and of a value as a number and as text, at most.
const MATERIAL_BYTES: u64 = 24_000_000;
const VALUE_BYTES: u64 = 560;

/// Most curves or maps in one figure.
const MOST_DRAWN: usize = 9;

/// Where examples and the meaning of angles are.
const AFTER: &str = "\
Angles are degrees: THETA is the longitude towards the barbule's base and tip, PHI the azimuth across it, each between -90 \
and 90, and the direction is (cosθ sinφ, sinθ, cosθ cosφ) with x across, y along, z out of the barbule. At THETA,PHI = 0,30 \
the mirror direction is 0,-30.

Examples:
  barbule brdf starling --wavelength 520 --wi 0,30 --wo 0,-30 --wo 0,-20
  barbule brdf starling --wavelength 450,550,650 --wi 0,0 --wo-grid 64 --instance 3 --csv grid.csv
  barbule brdf starling --wavelength 400:694:6 --wi 0,30 --marginal --json";

/// Arguments of `barbule brdf`.
#[derive(Debug, clap::Args)]
#[command(after_help = AFTER)]
#[command(group = clap::ArgGroup::new("outgoing").required(true).args(["wo", "wo_grid", "marginal"]))]
pub(crate) struct Args {
    /// A material file, or SPECIES[:VARIANT]
    material: String,
    /// Vacuum wavelengths in nm, within the material's
    #[arg(long, alias = "wavelengths", value_name = "SET", value_parser = wavelengths)]
    wavelength: Wavelengths,
    /// Direction towards the light
    #[arg(long, value_name = "THETA,PHI", allow_hyphen_values = true,
        value_parser = |text: &str| direction("--wi", text))]
    wi: Direction,
    /// Direction towards the eye (repeatable)
    #[arg(long, value_name = "THETA,PHI", allow_hyphen_values = true,
        value_parser = |text: &str| direction("--wo", text))]
    wo: Vec<Direction>,
    /// Towards the eye: the centres of N × N cells over the hemisphere seen from above, where they lie inside it
    #[arg(long, value_name = "N")]
    wo_grid: Option<usize>,
    /// In place of values their integral over the outgoing θ at each azimuth: what far fields call intensity
    #[arg(long)]
    marginal: bool,
    /// Outgoing azimuths of --marginal, at (n+½)·180°/N − 90° [default: 400]
    #[arg(long, value_name = "N")]
    azimuths: Option<usize>,
    /// Which instance, from 0 to 2⁶⁴ − 1; without it the smooth mean
    #[arg(long, value_name = "K", allow_hyphen_values = true)]
    instance: Option<u64>,
    /// Incident polarization: of the electric field along e₁ (1) or e₂ (2), or unpolarized light
    #[arg(long, value_enum, default_value_t = Light::Mean)]
    polarization: Light,
    /// Draw --marginal as curves or --wo-grid as maps: .svg or .png
    #[arg(short, long, value_name = "FIG")]
    output: Option<PathBuf>,
    /// Write a table, one row per wavelength and direction
    #[arg(long, value_name = "F")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// Wavelengths, rising.
#[derive(Debug, Clone)]
struct Wavelengths(Vec<f64>);

/// θ and φ in degrees.
type Direction = [f64; 2];

/// Incident polarizations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Light {
    /// Unpolarized
    Mean,
    /// Polarization 1
    #[value(name = "1")]
    First,
    /// Polarization 2
    #[value(name = "2")]
    Second,
}

impl Light {
    fn polarization(self) -> Option<Polarization> {
        match self {
            Self::Mean => None,
            Self::First => Some(Polarization::First),
            Self::Second => Some(Polarization::Second),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::First => "1",
            Self::Second => "2",
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Mean => "unpolarized",
            Self::First => "polarization 1",
            Self::Second => "polarization 2",
        }
    }
}

/// What was computed, in each form of output.
struct Answer {
    /// One JSON document without what was asked.
    json: Map<String, Value>,
    /// Names, and rows of numbers, of the table.
    columns: Vec<&'static str>,
    rows: Vec<Vec<f64>>,
    drawing: Option<Drawing>,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        self.check()?;
        check_outputs(self.output.as_deref(), self.csv.as_deref())?;
        let (material, hash) = materials::find(&self.material, &self.common)?;
        self.check_range(material.axes.wavelengths_nm())?;
        let options = Options { polarization: self.polarization.polarization(), ..Options::default() };
        // Only what decides the values is prepared.
        let brdf = FeatherBrdf::new(&material.around(&self.wavelength.0)?, options)?;
        let title = self.title(&figures::title(&material));
        let answer = if self.marginal { self.marginal(&brdf, &title)? } else { self.values(&brdf, &title) };
        let provenance =
            Provenance::new(&self.common).with("material", &self.material).with("material_hash", &hash);
        if let (Some(path), Some(drawing)) = (&self.output, &answer.drawing) {
            provenance.write_figure(path, drawing)?;
            self.common.wrote(path, &format!("{} of {title}", if self.marginal { "marginals" } else { "f" }));
        }
        if let Some(path) = &self.csv {
            provenance.write_csv(path, &csv(&answer))?;
            self.common.wrote(path, &format!("{} of {title}", answer.columns.join(", ")));
        }
        if self.common.json {
            let mut document = json!({
                "material": self.material,
                "material_hash": hash,
                "instance": self.instance,
                "polarization": self.polarization.name(),
                "sigma": brdf.sigma(),
                "wavelength_nm": self.wavelength.0,
                "theta_in_deg": self.wi[0],
                "phi_in_deg": self.wi[1],
            });
            if let Value::Object(keys) = &mut document {
                keys.extend(answer.json);
            }
            return print_json(out, &document);
        }
        if self.output.is_none() && self.csv.is_none() {
            return print(out, &format!("{title}\n{}", aligned(&answer)));
        }
        Ok(())
    }

    /// What can be refused before any work.
    fn check(&self) -> Result<()> {
        let refuse = |message: String| Err(Error::input(message));
        if let Some(size) = self.wo_grid.filter(|size| !(1..=1000).contains(size)) {
            return refuse(format!("--wo-grid {size}: give a number from 1 to 1000"));
        }
        if self.azimuths.is_some() && !self.marginal {
            return refuse("--azimuths is of --marginal only; give --marginal, or leave it out".into());
        }
        if let Some(count) = self.azimuths.filter(|count| !(2..=100_000).contains(count)) {
            return refuse(format!("--azimuths {count}: give a number from 2 to 100000"));
        }
        let waves = self.wavelength.0.len();
        let each = self.wo.len() + self.wo_grid.map_or(0, |size| size * size) + self.azimuth_count();
        if waves * each > MOST_VALUES {
            return refuse(format!(
                "{waves} wavelengths times {each} directions are over {MOST_VALUES} values; give fewer"
            ));
        }
        let needed = MATERIAL_BYTES + (waves * each) as u64 * VALUE_BYTES;
        let what = format!("{waves} wavelengths times {each} directions");
        self.common.check_memory(&what, needed, "fewer of either")?;
        if self.output.is_some() {
            if !self.wo.is_empty() {
                return refuse("-o draws --marginal or --wo-grid; single directions have no figure".into());
            }
            if waves > MOST_DRAWN {
                return refuse(format!("-o draws at most {MOST_DRAWN} wavelengths, not {waves}; give fewer"));
            }
        }
        Ok(())
    }

    fn azimuth_count(&self) -> usize {
        if self.marginal { self.azimuths.unwrap_or(400) } else { 0 }
    }

    fn check_range(&self, nodes_nm: &[f64]) -> Result<()> {
        let (first, last) = (nodes_nm[0], nodes_nm[nodes_nm.len() - 1]);
        match self.wavelength.0.iter().find(|nm| !(first..=last).contains(*nm)) {
            Some(bad) => Err(Error::input(format!(
                "--wavelength: {bad} nm is outside {first} to {last} nm, the wavelengths of {}",
                shortened(&self.material)
            ))),
            None => Ok(()),
        }
    }

    fn title(&self, material: &str) -> String {
        let which = self.instance.map_or("mean".to_owned(), |instance| format!("instance {instance}"));
        let [theta, phi] = self.wi;
        format!("{material}, {which}, {}, θ_i {theta}°, φ_i {phi}°", self.polarization.words())
    }

    fn values(&self, brdf: &FeatherBrdf, title: &str) -> Answer {
        let nm = &self.wavelength.0;
        let grid = self.wo_grid.map(projected_grid);
        let asked = || self.wo.iter().map(|wo| towards(*wo)).collect();
        let wo: Vec<DVec3> = grid.clone().unwrap_or_else(asked);
        // As typed where they were typed.
        let angles: Vec<Direction> =
            if grid.is_some() { wo.iter().map(angles_of).collect() } else { self.wo.clone() };
        let found = values(brdf, nm, towards(self.wi), &wo, self.instance);
        let each = |part: fn(&Values) -> f64| -> Vec<Vec<f64>> {
            found.iter().map(|row| row.iter().map(part).collect()).collect()
        };
        let mut json = Map::new();
        json.insert("theta_out_deg".into(), angles.iter().map(|a| a[0]).collect());
        json.insert("phi_out_deg".into(), angles.iter().map(|a| a[1]).collect());
        let mut columns = vec!["wavelength_nm", "theta_out_deg", "phi_out_deg"];
        if let Some(size) = self.wo_grid {
            json.insert("grid".into(), size.into());
            json.insert("x_out".into(), wo.iter().map(|w| w.x).collect());
            json.insert("y_out".into(), wo.iter().map(|w| w.y).collect());
            columns.extend(["x_out", "y_out"]);
        }
        columns.extend(["f", "s", "pdf"]);
        json.insert("f".into(), json!(each(|v| v.f)));
        json.insert("s".into(), json!(each(|v| v.steady)));
        json.insert("pdf".into(), json!(each(|v| v.pdf)));
        let mut rows = Vec::new();
        for (nm, found) in nm.iter().zip(&found) {
            for ((wo, [theta, phi]), v) in wo.iter().zip(&angles).zip(found) {
                let mut row = vec![*nm, *theta, *phi];
                if grid.is_some() {
                    row.extend([wo.x, wo.y]);
                }
                row.extend([v.f, v.steady, v.pdf]);
                rows.push(row);
            }
        }
        let maps = |size| figures::hemisphere_maps(title, size, nm, &each(|v| v.f));
        let drawing = self.wo_grid.filter(|_| self.output.is_some()).map(maps);
        Answer { json, columns, rows, drawing }
    }

    fn marginal(&self, brdf: &FeatherBrdf, title: &str) -> Result<Answer> {
        let nm = &self.wavelength.0;
        let phi_out: Vec<f64> = azimuths(self.azimuth_count()).collect();
        let progress = Terminal::new(&self.common);
        let found = marginals(brdf, nm, towards(self.wi), &phi_out, self.instance, &progress)?;
        drop(progress);
        let step = std::f64::consts::PI / phi_out.len() as f64 * self.wi[0].to_radians().cos();
        let reflected = found.iter().map(|row| step * row.f.iter().sum::<f64>());
        let each = |part: fn(&Marginal) -> &Vec<f64>| -> Vec<Vec<f64>> {
            found.iter().map(|m| part(m).clone()).collect()
        };
        let phi_out_deg: Vec<f64> = phi_out.iter().map(|phi| phi.to_degrees()).collect();
        let mut json = Map::new();
        json.insert("phi_out_deg".into(), json!(phi_out_deg));
        json.insert("marginal".into(), json!(each(|m| &m.f)));
        json.insert("marginal_s".into(), json!(each(|m| &m.steady)));
        json.insert("reflected_fraction".into(), reflected.collect());
        let rows = nm.iter().zip(&found).flat_map(|(nm, Marginal { f, steady })| {
            let values = phi_out_deg.iter().zip(f).zip(steady);
            values.map(|((phi, f), steady)| vec![*nm, *phi, *f, *steady])
        });
        Ok(Answer {
            json,
            columns: vec!["wavelength_nm", "phi_out_deg", "marginal", "marginal_s"],
            rows: rows.collect(),
            drawing: self
                .output
                .is_some()
                .then(|| figures::marginals(title, nm, &phi_out_deg, &each(|m| &m.f))),
        })
    }
}

fn towards([theta, phi]: Direction) -> DVec3 {
    omega(theta.to_radians(), phi.to_radians())
}

/// θ and φ in degrees.
fn angles_of(w: &DVec3) -> Direction {
    [w.y.clamp(-1.0, 1.0).asin().to_degrees(), w.x.atan2(w.z).to_degrees()]
}

fn csv(answer: &Answer) -> String {
    let mut text = answer.columns.join(",");
    for row in &answer.rows {
        text.push('\n');
        text += &row.iter().map(|value| written(*value)).collect::<Vec<_>>().join(",");
    }
    text + "\n"
}

/// A number in as few digits as tell it apart.
fn written(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-4 { format!("{value:e}") } else { value.to_string() }
}

/// The table for people: columns as wide as their names.
fn aligned(answer: &Answer) -> String {
    let unit = |name: &&str| match *name {
        "f" | "s" | "pdf" => format!("{name} (1/sr)"),
        "marginal" | "marginal_s" => format!("{name} (1/rad)"),
        name => name.to_owned(),
    };
    let names: Vec<String> = answer.columns.iter().map(unit).collect();
    let mut text = names.iter().map(|name| format!("{name:>14}")).collect::<String>();
    for row in &answer.rows {
        text.push('\n');
        for (value, name) in row.iter().zip(&names) {
            // Writing to a string cannot fail.
            let _ = if name.ends_with(')') {
                write!(text, "{value:14.6e}")
            } else {
                write!(text, "{value:14.4}")
            };
        }
    }
    text
}

fn wavelengths(text: &str) -> Result<Wavelengths> {
    sets::wavelengths(text).map(Wavelengths)
}

fn direction(flag: &str, text: &str) -> Result<Direction> {
    match text.split(',').collect::<Vec<_>>()[..] {
        [theta, phi] => Ok([sets::angle(flag, theta)?, sets::angle(flag, phi)?]),
        _ => Err(Error::input(format!("{flag} {}: write THETA,PHI in degrees, as in 0,30", shortened(text)))),
    }
}
