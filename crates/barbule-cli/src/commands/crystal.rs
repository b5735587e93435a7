//! `barbule crystal`: what a photonic crystal reflects.

use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;

use barbule::figures;
use barbule::plot::{Axis, Drawing, HeatMap, abreast};
use barbule::solve::crystal::{
    Cell, CrystalResponse, CrystalSolver, Fdtd, Incidence, Multipole, NearField, Rcwa, sweep,
};
use barbule::spectrum::Wavelengths;
use barbule::structure::Lattice;
use barbule::{Complex64, Error, Result};
use clap::ValueEnum;
use serde_json::{Value, json};

use crate::common::{Common, print, print_json};
use crate::figure::FigureArgs;
use crate::progress::Terminal;
use crate::provenance::Provenance;
use crate::{sets, structure_arg};

/// Angles of a map, degrees: −89 to 89 in steps of 2.
const MAP_ANGLES: usize = 90;

/// Resolution of pictures of the field, how far they reach above the surface, and their height in px.
const FIELD_CELLS_PER_UM: f64 = 200.0;
const FIELD_ABOVE_UM: f64 = 0.15;
const PANEL_HEIGHT: f64 = 420.0;

/// Wavelength and φ_i of a point or a field where nothing is said, and wavelengths of a map.
const USUAL_WAVELENGTH_NM: f64 = 550.0;
const USUAL_WAVELENGTHS: &str = "300:800:5";
const USUAL_PHI_DEG: f64 = 0.0;

/// Cosine of the angle from the normal below which a pulse takes over a minute.
const NEAR_THE_HORIZON: f64 = 0.035;

/// Arguments of `barbule crystal`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  barbule crystal mallard:green --wavelength 520 --theta 20 --phi 30\n  barbule crystal magpie --map -o map.png\n  barbule crystal peafowl --field --wavelength 560 -o field.png"
)]
pub(crate) struct Args {
    /// mallard, magpie or peafowl[:VARIANT], a species .toml of a crystal, or a lattice in TOML or JSON
    structure: String,
    /// Wavelength in nm, of a map a set [default: 550, of a map 300:800:5]
    #[arg(long, visible_alias = "wavelengths", value_name = "SET", value_parser = wavelengths)]
    wavelength: Option<Wavelengths>,
    /// Longitudinal angle of incidence in degrees
    #[arg(long, value_name = "DEG", default_value = "0", allow_hyphen_values = true,
        value_parser = |text: &str| sets::angle("--theta", text))]
    theta: f64,
    /// Azimuth of incidence in degrees [default: 0]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true,
        value_parser = |text: &str| sets::angle("--phi", text))]
    phi: Option<f64>,
    /// How it is solved [default: multipole]; a field always by fdtd
    #[arg(long, value_enum)]
    solver: Option<Method>,
    /// Draw reflectance against wavelength and φ_i at θ, both polarizations
    #[arg(long, conflicts_with = "field", requires = "output")]
    map: bool,
    /// Draw |E|² of both polarizations and the permittivity in the unit cell
    #[arg(long, requires = "output")]
    field: bool,
    #[command(flatten)]
    figure: FigureArgs,
    #[command(flatten)]
    common: Common,
}

fn wavelengths(text: &str) -> Result<Wavelengths> {
    Wavelengths::new(sets::wavelengths_of("--wavelength", text)?)
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
enum Method {
    #[default]
    /// Cylinder multipoles: exact for circular rods
    Multipole,
    /// The Fourier modal method
    Rcwa,
    /// Finite differences in time, 100 cells/µm
    Fdtd,
}

impl Method {
    fn solver(self) -> Box<dyn CrystalSolver> {
        match self {
            Self::Multipole => Box::new(Multipole::default()),
            Self::Rcwa => Box::new(Rcwa::default()),
            Self::Fdtd => Box::new(Fdtd::default()),
        }
    }
}

impl Args {
    pub(crate) fn run(&self, out: &mut dyn Write) -> Result<()> {
        self.common.start_threads()?;
        self.figure.check(&self.common)?;
        if self.figure.output.is_some() && !self.map && !self.field {
            return Err(Error::input("-o draws a map or a field; give --map or --field"));
        }
        let lattice = structure_arg::lattice(&self.structure, &self.common)?;
        match self.figure.path() {
            Some(path) if self.map => self.draw_map(out, path, &lattice),
            Some(path) => self.draw_field(out, path, &lattice, &self.incidence()?),
            None => self.point(out, &lattice, &self.incidence()?),
        }
    }

    /// The wave of a point or a field.
    fn incidence(&self) -> Result<Incidence> {
        let wavelength_nm = match self.wavelength.as_ref().map(Wavelengths::nm) {
            None => USUAL_WAVELENGTH_NM,
            Some([nm]) => *nm,
            Some(several) => {
                return Err(Error::input(format!(
                    "--wavelength: {} wavelengths are given, but only a map has several; give one, or draw a map with --map -o FILE",
                    several.len()
                )));
            }
        };
        Ok(Incidence { wavelength_nm, theta_i: self.theta.to_radians(), phi_i: self.phi_deg().to_radians() })
    }

    fn method(&self) -> Method {
        self.solver.unwrap_or_default()
    }

    fn phi_deg(&self) -> f64 {
        self.phi.unwrap_or(USUAL_PHI_DEG)
    }

    fn point(&self, out: &mut dyn Write, lattice: &Lattice, incidence: &Incidence) -> Result<()> {
        let cell = Cell::new(lattice, incidence.wavelength_nm)?;
        if self.method() == Method::Fdtd && incidence.theta_i.cos() * incidence.phi_i.cos() < NEAR_THE_HORIZON
        {
            self.common.say("so near the horizon finite differences in time take minutes");
        }
        let response = self.method().solver().respond(&cell, incidence)?;
        if self.common.json {
            return print_json(out, &document(&response, incidence.phi_i));
        }
        print(out, &table(&response, incidence.phi_i))
    }

    fn draw_map(&self, out: &mut dyn Write, path: &Path, lattice: &Lattice) -> Result<()> {
        if self.method() == Method::Fdtd {
            return Err(Error::input("a map takes thousands of points; use --solver multipole or rcwa"));
        }
        if self.phi.is_some() {
            self.common.idle("--phi", "a map is of all φ_i");
        }
        let at = &self.wavelength.clone().map_or_else(|| wavelengths(USUAL_WAVELENGTHS), Ok)?;
        let phi_deg: Vec<f64> = (0..MAP_ANGLES).map(|i| 2.0 * i as f64 - (MAP_ANGLES - 1) as f64).collect();
        let phi_i: Vec<f64> = phi_deg.iter().map(|d| d.to_radians()).collect();
        let progress = Terminal::new(&self.common);
        let theta_i = self.theta.to_radians();
        let found = sweep(&*self.method().solver(), lattice, at.nm(), theta_i, &phi_i, &progress)?;
        Provenance::new(&self.common).write_figure(path, &self.map_figure(at, &found)?)?;
        let name = figures::heading(&self.structure);
        self.common
            .wrote(path, &format!("what {name} reflects against wavelength and φ_i, both polarizations"));
        if self.common.json {
            let rows = |polarization: usize| {
                found
                    .chunks_exact(at.len())
                    .map(|row| row.iter().map(|r| r[polarization]).collect::<Vec<_>>())
                    .collect::<Vec<_>>()
            };
            let document = json!({
                "wavelength_nm": at.nm(), "theta_deg": self.theta, "phi_deg": phi_deg,
                "R_1": rows(0), "R_2": rows(1),
            });
            return print_json(out, &document);
        }
        Ok(())
    }

    /// Both polarizations side by side; `found` is `[φ_i][wavelength]`.
    fn map_figure(&self, at: &Wavelengths, found: &[[f64; 2]]) -> Result<Drawing> {
        let most = found.iter().flatten().fold(0.0, |a: f64, &b| a.max(b));
        let (first, last) = at.range_nm();
        let panels = [0, 1].map(|polarization| {
            let x = Axis::with_range("wavelength in vacuum (nm)", first, last);
            let y = Axis::with_range("φ_i (°)", -90.0, 90.0);
            let values = found.iter().map(|r| r[polarization]).collect();
            let mut map = HeatMap::new(format!("polarization {}", polarization + 1), x, y, at.len(), values);
            map.label = "reflectance, all orders".into();
            map.range = Some([0.0, most]);
            map
        });
        let usual = format!("{}, θ_i = {}°", figures::heading(&self.structure), self.theta);
        Ok(abreast(&self.figure.title(usual), &panels, &self.figure.page()?))
    }

    fn draw_field(
        &self,
        out: &mut dyn Write,
        path: &Path,
        lattice: &Lattice,
        incidence: &Incidence,
    ) -> Result<()> {
        if self.solver.is_some_and(|method| method != Method::Fdtd) {
            self.common.idle("--solver", "fields are found by finite differences in time");
        }
        let cell = Cell::new(lattice, incidence.wavelength_nm)?;
        let solver = Fdtd { cells_per_um: FIELD_CELLS_PER_UM, ..Fdtd::default() };
        let field = solver.near_field(&cell, incidence, FIELD_ABOVE_UM)?;
        let (top, bottom) = (1e3 * field.top_um, 1e3 * field.bottom_um);
        // As many periods as make a picture to scale that is not too narrow.
        let periods = (0.5 * (field.top_um - field.bottom_um) / field.period_um).ceil().clamp(1.0, 8.0);
        let right = periods * field.period_um * 1e3;
        let panel = |title: String, label: &str, values: &[f64]| {
            let x = Axis::with_range("x (nm)", 0.0, right);
            let y = Axis::with_range("z (nm)", bottom, top);
            let rows = values.chunks_exact(field.columns);
            let repeated: Vec<f64> = rows.flat_map(|row| row.repeat(periods as usize)).collect();
            let mut heat = HeatMap::new(title, x, y, periods as usize * field.columns, repeated);
            heat.label = label.into();
            heat.size = [PANEL_HEIGHT * right / (top - bottom), PANEL_HEIGHT];
            heat.keeps_shape = true;
            heat
        };
        let title = |polarization: usize| format!("polarization {}", polarization + 1);
        let panels = [
            panel("permittivity".into(), "Re ε", &field.permittivity),
            panel(title(0), "|E|²/|E_i|²", &field.intensity[0]),
            panel(title(1), "|E|²/|E_i|²", &field.intensity[1]),
        ];
        let name = figures::heading(&self.structure);
        let (nm, theta, phi) = (incidence.wavelength_nm, self.theta, self.phi_deg());
        let usual = format!("{name}, {nm} nm, θ_i = {theta}°, φ_i = {phi}°");
        let drawing = abreast(&self.figure.title(usual), &panels, &self.figure.page()?);
        Provenance::new(&self.common).write_figure(path, &drawing)?;
        self.common.wrote(path, &format!("the field in {name} at {nm} nm, both polarizations"));
        if self.common.json { print_json(out, &self.field_document(nm, &field)) } else { Ok(()) }
    }

    /// What the picture of a field shows, one period of it.
    fn field_document(&self, wavelength_nm: f64, field: &NearField) -> Value {
        let rows = |values: &[f64]| json!(values.chunks_exact(field.columns).collect::<Vec<_>>());
        json!({
            "wavelength_nm": wavelength_nm,
            "theta_deg": self.theta,
            "phi_deg": self.phi_deg(),
            "period_um": field.period_um,
            "top_um": field.top_um,
            "bottom_um": field.bottom_um,
            "permittivity": rows(&field.permittivity),
            "intensity": field.intensity.each_ref().map(|values| rows(values)),
        })
    }
}

/// The contract's JSON.
fn document(response: &CrystalResponse, phi_i: f64) -> Value {
    let complex = |z: &Complex64| json!([z.re, z.im]);
    let orders: Vec<_> = response
        .orders
        .iter()
        .map(|order| {
            json!({
                "m": order.m,
                "phi_deg": order.phi_o.to_degrees(),
                "R": order.reflectance(phi_i),
                "J": order.jones.each_ref().map(|row| row.each_ref().map(complex)),
            })
        })
        .collect();
    json!({
        "orders": orders,
        "transmitted": response.transmitted,
        "absorbed": response.absorbed,
        "convergence": response.convergence,
    })
}

fn table(response: &CrystalResponse, phi_i: f64) -> String {
    let mut text = format!("{:>12} {:>9} {:>10} {:>10}", "", "φ_o (°)", "1", "2");
    for order in &response.orders {
        let [first, second] = order.reflectance(phi_i);
        // Writing to a String cannot fail, here and below.
        let _ = write!(
            text,
            "\nR, order {:>3} {:>9.3} {first:>10.6} {second:>10.6}",
            order.m,
            order.phi_o.to_degrees()
        );
    }
    for (name, [first, second]) in [("transmitted", response.transmitted), ("absorbed", response.absorbed)] {
        let _ = write!(text, "\n{name:>12} {:>9} {first:>10.6} {second:>10.6}", "");
    }
    if let Some(error) = response.convergence {
        let _ = write!(text, "\nestimated error of R: {error:.1e}");
    }
    text
}
