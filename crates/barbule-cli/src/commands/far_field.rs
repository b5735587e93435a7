//! `barbule far-field`: what one instance scatters at one wavelength and direction.

use std::io::Write;

use barbule::scattering::far_field::{FarField, Illumination, IncidentLight, Polarization, Window};
use barbule::solve::direct;
use barbule::solve::surface::{Accuracy, FINE_ELEMENT_UM, far_field};
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
    #[arg(long, value_name = "NM", value_parser = |text: &str| sets::wavelength("--wavelength", text))]
    wavelength: f64,
    /// Longitudinal angle of incidence in degrees
    #[arg(long, value_name = "DEG", allow_hyphen_values = true,
        value_parser = |text: &str| sets::angle("--theta", text))]
    theta: f64,
    /// Azimuth of incidence in degrees
    #[arg(long, value_name = "DEG", allow_hyphen_values = true,
        value_parser = |text: &str| sets::angle("--phi", text))]
    phi: f64,
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
    #[arg(long, value_enum, default_value_t = WindowArg::Gaussian)]
    window: WindowArg,
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
    #[value(hide = true)] // not in this version
    FullWave,
}

/// Windows of the incident light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum WindowArg {
    /// Light of limited coherence
    Gaussian,
    /// A plane wave
    None,
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
        if self.solver == Solver::FullWave {
            return Err(Error::input(
                "--solver full-wave: this version has no full-wave solver; use fast or direct",
            ));
        }
        let window = match self.window {
            WindowArg::Gaussian => Window::Gaussian,
            WindowArg::None => Window::PlaneWave,
        };
        let section =
            structure_arg::parse(&self.structure, &self.common)?.instance(self.common.seed, self.instance)?;
        let (theta_i, phi_i) = (self.theta.to_radians(), self.phi.to_radians());
        let illumination = Illumination { wavelength_nm: self.wavelength, theta_i, phi_i, window };
        let far = match self.solver {
            Solver::Direct => direct::far_field(&section, &illumination, self.azimuths, FINE_ELEMENT_UM)?,
            _ => far_field(&section, &illumination, self.azimuths, &Accuracy::default())?,
        };
        if self.common.json {
            return print_json(out, &document(&far));
        }
        print(out, &table(&far))
    }
}

/// c₀|𝓔|²/Φ_i in 1/rad of a beam, the differential width in µm/rad of a plane wave.
fn per_radian(far: &FarField, polarization: Polarization) -> Vec<f64> {
    far.intensity(polarization).unwrap_or_else(|| far.differential_width_um(polarization))
}

/// The contract's JSON.
fn document(far: &FarField) -> Value {
    let complex = |values: &[Complex64]| values.iter().map(|z| json!([z.re, z.im])).collect::<Vec<_>>();
    let polarization = |p: Polarization| {
        let [e1, e2] = &far.amplitudes[p.index()];
        json!({
            "intensity": per_radian(far, p),
            "e1": complex(e1),
            "e2": complex(e2),
            "reflected_fraction": far.reflected_fraction(p),
        })
    };
    let incident_power_um = match far.light {
        IncidentLight::Beam { power_um } => Some(power_um),
        IncidentLight::PlaneWave => None,
    };
    json!({
        "phi_out_deg": far.azimuths.phi_o().iter().map(|phi| phi.to_degrees()).collect::<Vec<_>>(),
        "incident_power": incident_power_um,
        "polarization_1": polarization(Polarization::First),
        "polarization_2": polarization(Polarization::Second),
    })
}

/// Azimuths and intensities as columns.
fn table(far: &FarField) -> String {
    let intensity = Polarization::BOTH.map(|p| per_radian(far, p));
    let [first, second] = far.radiated;
    let (unit, mut text) = match far.light {
        IncidentLight::Beam { power_um } => (
            "1/rad",
            format!(
                "incident power {power_um:.6} µm, reflected fraction {first:.6} (polarization 1), {second:.6} (2)\n"
            ),
        ),
        IncidentLight::PlaneWave => {
            ("µm/rad", format!("reflected width {first:.6} µm (polarization 1), {second:.6} µm (2)\n"))
        }
    };
    text += &format!("phi_out_deg  intensity_1 ({unit})  intensity_2 ({unit})");
    for (n, phi) in far.azimuths.phi_o().iter().enumerate() {
        text += &format!("\n{:11.4}  {:20.6e}  {:20.6e}", phi.to_degrees(), intensity[0][n], intensity[1][n]);
    }
    text
}
