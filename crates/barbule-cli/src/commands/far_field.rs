//! `barbule far-field`: what one instance scatters at one wavelength and direction.

use std::io::Write;

use barbule::math::simd::Width;
use barbule::solve::direct;
use barbule::solve::surface::{FINE_ELEMENT_UM, FarField, Surface, Window, far_field};
use barbule::{Complex64, Error, Result};
use clap::ValueEnum;
use serde_json::{Value, json};

use crate::common::{Common, print, print_json};
use crate::{sets, structure_arg};

/// Arguments of `barbule far-field`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  barbule far-field starling --wavelength 520 --theta 0 --phi 30 --json")]
pub(crate) struct Args {
    #[arg(help = structure_arg::HELP)]
    structure: String,
    /// Vacuum wavelength in nm
    #[arg(long, value_name = "NM")]
    wavelength: String,
    /// Longitudinal angle of incidence in degrees
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    theta: String,
    /// Azimuth of incidence in degrees
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    phi: String,
    /// Which random instance, from 0
    #[arg(long, value_name = "K", default_value_t = 0)]
    instance: usize,
    /// Number of outgoing azimuths
    #[arg(long, value_name = "N", default_value_t = 400)]
    azimuths: usize,
    /// How to compute
    #[arg(long, value_enum, default_value_t = Solver::Fast)]
    solver: Solver,
    /// How the light falls on the section
    #[arg(long, value_enum, default_value_t = Illumination::Gaussian)]
    window: Illumination,
    #[command(flatten)]
    common: Common,
}

/// Solvers of far fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Solver {
    /// The fast 2.5D simulation
    Fast,
    /// The same formulas, evaluated plainly
    Direct,
    /// Boundary elements
    FullWave,
}

/// Windows of the incident light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Illumination {
    /// Light of limited coherence
    Gaussian,
    /// A plane wave
    None,
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        let single = |flag: &str, text: &str, values: Vec<f64>| match values[..] {
            [value] => Ok(value),
            _ => Err(Error::input(format!("{flag} {text}: give one value"))),
        };
        let wavelength_nm = single("--wavelength", &self.wavelength, sets::wavelengths(&self.wavelength)?)?;
        let theta_deg = single("--theta", &self.theta, sets::angles("--theta", &self.theta)?)?;
        let phi_deg = single("--phi", &self.phi, sets::angles("--phi", &self.phi)?)?;
        if !(2..=100_000).contains(&self.azimuths) {
            return Err(Error::input(format!(
                "--azimuths {}: give a number from 2 to 100000",
                self.azimuths
            )));
        }
        if self.solver == Solver::FullWave {
            return Err(Error::input(
                "--solver full-wave: this version has no full-wave solver; use fast or direct",
            ));
        }
        let window = match self.window {
            Illumination::Gaussian => Window::Gaussian,
            Illumination::None => Window::None,
        };
        let section =
            structure_arg::parse(&self.structure, &self.common)?.instance(self.common.seed, self.instance)?;
        let (theta_i, phi_i) = (theta_deg.to_radians(), phi_deg.to_radians());
        let far = match self.solver {
            Solver::Direct => direct::far_field(
                &section,
                window,
                FINE_ELEMENT_UM,
                wavelength_nm,
                theta_i,
                phi_i,
                self.azimuths,
            )?,
            _ => {
                let surface = Surface::new(&section, FINE_ELEMENT_UM, window)?;
                far_field(&surface, window, wavelength_nm, theta_i, phi_i, self.azimuths, Width::best())?
            }
        };
        if self.common.json {
            return print_json(out, &document(&far));
        }
        print(out, &table(&far))
    }
}

/// The contract's JSON.
fn document(far: &FarField) -> Value {
    let complex = |values: &[Complex64]| values.iter().map(|z| json!([z.re, z.im])).collect::<Vec<_>>();
    let polarization = |p: usize| {
        json!({
            "intensity": far.intensity(p),
            "e1": complex(&far.fields[p][0]),
            "e2": complex(&far.fields[p][1]),
            "reflected_fraction": far.incident_power_um.map(|_| far.reflected[p]),
        })
    };
    json!({
        "phi_out_deg": far.phi_o.iter().map(|phi| phi.to_degrees()).collect::<Vec<_>>(),
        "incident_power": far.incident_power_um,
        "polarization_1": polarization(0),
        "polarization_2": polarization(1),
    })
}

/// Azimuths and intensities as columns.
fn table(far: &FarField) -> String {
    let intensity = [far.intensity(0), far.intensity(1)];
    let unit = if far.incident_power_um.is_some() { "1/rad" } else { "µm/rad" };
    let mut text = match far.incident_power_um {
        Some(power) => format!(
            "incident power {power:.6} µm, reflected fraction {:.6} (polarization 1), {:.6} (2)\n",
            far.reflected[0], far.reflected[1]
        ),
        None => format!(
            "reflected width {:.6} µm (polarization 1), {:.6} µm (2)\n",
            far.reflected[0], far.reflected[1]
        ),
    };
    text += &format!("phi_out_deg  intensity_1 ({unit})  intensity_2 ({unit})");
    for (n, phi) in far.phi_o.iter().enumerate() {
        text += &format!("\n{:11.4}  {:20.6e}  {:20.6e}", phi.to_degrees(), intensity[0][n], intensity[1][n]);
    }
    text
}
