//! `barbule spectrum`: reflectance against wavelength, mean and spread over instances.

use std::fmt::Write as _;
use std::io::Write;
use std::path::PathBuf;

use barbule::campaign::spectrum::{Collect, Grazing, Spectra, SpectrumRequest, spectra};
use barbule::campaign::spectrum_bytes;
use barbule::figures;
use barbule::io::tables::read_spectrum;
use barbule::spectrum::Wavelengths;
use barbule::{Error, Result};
use clap::ValueEnum;
use serde_json::json;

use crate::campaign::grazing;
use crate::common::{Common, print, print_json};
use crate::progress::Terminal;
use crate::provenance::{Provenance, check_outputs};
use crate::{sets, structure_arg};

/// Arguments of `barbule spectrum`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  barbule spectrum starling --angle 0,30,60 -o starling.svg --csv starling.csv"
)]
pub(crate) struct Args {
    #[arg(help = structure_arg::HELP)]
    structure: String,
    /// Angles of incidence in degrees
    #[arg(long, value_name = "SET", default_value = "0", allow_hyphen_values = true,
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
    /// Random instances
    #[arg(long, value_name = "N", default_value_t = 50)]
    instances: usize,
    /// Wavelengths in nm
    #[arg(long, value_name = "SET", default_value = "400:694:6", value_parser = sets::wavelength_set)]
    wavelengths: Wavelengths,
    /// A measured spectrum to draw beside (CSV: nm, reflectance)
    #[arg(long, value_name = "FILE")]
    measured: Option<PathBuf>,
    /// Draw a figure: .svg or .png
    #[arg(short, long, value_name = "FIG")]
    output: Option<PathBuf>,
    /// Write a table: angle_deg,wavelength_nm,mean,std
    #[arg(long, value_name = "F")]
    csv: Option<PathBuf>,
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

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        let angles_deg = &self.angle.0;
        if !(1..=10_000).contains(&self.instances) {
            return Err(Error::input(format!(
                "--instances {}: give a number from 1 to 10000",
                self.instances
            )));
        }
        check_outputs(self.output.as_deref(), self.csv.as_deref())?;
        let structure = structure_arg::parse(&self.structure, &self.common)?;
        let instances = structure.count().map_or(self.instances, |given| given.min(self.instances));
        let measured = self.measured.as_deref().map(read_spectrum).transpose()?;
        let direction = |angle: &f64| match self.plane {
            Plane::Across => (0.0, angle.to_radians()),
            Plane::Along => (angle.to_radians(), 0.0),
        };
        let request = SpectrumRequest {
            wavelengths: self.wavelengths.clone(),
            directions: angles_deg.iter().map(direction).collect(),
            instances,
            seed: self.common.seed,
            collect: self.collect,
            polarization: self.polarization,
        };
        let bytes = spectrum_bytes(&structure, &request)?;
        self.common.allowance().check(
            "this spectrum",
            bytes,
            "fewer --wavelengths, angles, --instances or --threads",
        )?;
        let found = spectra(&structure, &request, &Terminal::new(&self.common))?;
        if let Some(Grazing { direction, wavelength, mirror_fraction, flagged }) = found.grazing() {
            let symbol = if self.plane == Plane::Across { "φ" } else { "θ" };
            let incidence = format!("{symbol} = {}°", angles_deg[direction]);
            let nm = request.wavelengths[wavelength];
            let said = grazing(&incidence, nm, structure.width_um(), mirror_fraction);
            let all = angles_deg.len() * request.wavelengths.len();
            self.common.say(&format!("{said} ({flagged} of {all} values are flagged)"));
        }
        let provenance = Provenance::new(&self.common);
        if let Some(path) = &self.output {
            let title = format!("{}, {} instances", structure.name(), instances);
            let symbol = if self.plane == Plane::Across { "φ" } else { "θ" };
            let names: Vec<_> = angles_deg.iter().map(|angle| format!("{symbol} = {angle}°")).collect();
            let measured: Vec<_> = measured.into_iter().map(|m| ("measured".to_owned(), m)).collect();
            provenance.write_figure(path, &figures::spectra(&title, &request, &found, &names, &measured)?)?;
        }
        let csv = csv(&request, &found, angles_deg);
        if let Some(path) = &self.csv {
            provenance.write_csv(path, &csv)?;
        }
        if self.common.json {
            return print_json(
                out,
                &json!({
                    "angle_deg": angles_deg,
                    "wavelength_nm": request.wavelengths.nm(),
                    "mean": found.mean,
                    "std": found.std,
                    "mirror_fraction": found.mirror,
                    "flagged": found.flagged(),
                    "instances": instances,
                }),
            );
        }
        if self.output.is_none() && self.csv.is_none() {
            return print(out, csv.trim_end());
        }
        Ok(())
    }
}

fn csv(request: &SpectrumRequest, found: &Spectra, angles_deg: &[f64]) -> String {
    let mut text = String::from("angle_deg,wavelength_nm,mean,std\n");
    for (a, angle) in angles_deg.iter().enumerate() {
        for (w, nm) in request.wavelengths.iter().enumerate() {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{angle},{nm},{},{}", found.mean[a][w], found.std[a][w]);
        }
    }
    text
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
                "--collect {text}: write hemisphere, or cone:HALF with HALF up to 90 degrees, as in cone:5"
            ))
        })
}

fn polarization(text: &str) -> Result<[f64; 2]> {
    match text {
        "mean" => Ok([0.5, 0.5]),
        "1" => Ok([1.0, 0.0]),
        "2" => Ok([0.0, 1.0]),
        _ => Err(Error::input(format!("--polarization {text}: write mean, 1 or 2"))),
    }
}
