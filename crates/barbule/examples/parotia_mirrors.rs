//! The three mirrors of a Lawes' parotia's barbule against wavelength, as `docs/guide/multilayers.md` shows them:
//! `target/release/examples/parotia_mirrors FIGURE.svg` (after `cargo build --release --workspace --examples`), 20 CPU seconds.

#![allow(clippy::print_stdout)] // a program

use std::path::Path;

use barbule::io::{read_structure_toml, write_whole};
use barbule::material::Library;
use barbule::plot::{Axis, Curve, Figure, Format};
use barbule::scattering::far_field::{Illumination, Polarization, Window};
use barbule::solve::surface::{Accuracy, far_field};
use barbule::structure::Structure;
use barbule::{Error, Result};

/// Individuals that are averaged.
const INDIVIDUALS: usize = 6;
const AZIMUTHS: usize = 360;
/// Where light that falls along the normal leaves each mirror, and the half width of what is collected, degrees.
const MIRRORS_DEG: [(&str, f64); 3] =
    [("level middle, 0°", 0.0), ("left arm, −60°", -60.0), ("right arm, 60°", 60.0)];
const HALF_DEG: f64 = 15.0;

fn main() -> Result<()> {
    let figure = std::env::args().nth(1).ok_or_else(|| Error::input("name the figure's file"))?;
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/species/lawes-parotia.toml");
    let parotia = read_structure_toml(Path::new(file), None, &Library::builtin())?;
    let wavelengths: Vec<f64> = (0..51).map(|i| 400.0 + 6.0 * f64::from(i)).collect();
    let powers = wavelengths.iter().map(|nm| mirrors(&parotia, *nm)).collect::<Result<Vec<_>>>()?;
    let x = Axis::new("wavelength (nm)");
    let mut chart = Figure::new("Lawes' parotia", x, Axis::new("reflected power, part of its maximum"));
    for (k, (name, _)) in MIRRORS_DEG.iter().enumerate() {
        let most = powers.iter().map(|p| p[k]).fold(0.0, f64::max);
        let peak = wavelengths.iter().zip(&powers).find(|(_, p)| p[k] == most).map_or(0.0, |(nm, _)| *nm);
        println!("{name}: {:.2} % at {peak} nm", 100.0 * most);
        let points = wavelengths.iter().zip(&powers).map(|(nm, p)| [*nm, p[k] / most]).collect();
        chart.curves.push(Curve::line(format!("{name}: {:.2} %", 100.0 * most), points));
    }
    chart.legend = "to where, and its maximum".into();
    let path = Path::new(&figure);
    write_whole(path, &chart.draw().encode(Format::of(path)?, &[])?)
}

/// The parts of light along the normal that leave near each mirror's direction.
fn mirrors(structure: &Structure, wavelength_nm: f64) -> Result<[f64; 3]> {
    let mut sums = [0.0; 3];
    for index in 0..INDIVIDUALS {
        let section = structure.instance(1, index)?;
        let light = Illumination { wavelength_nm, theta_i: 0.0, phi_i: 0.0, window: Window::Gaussian };
        let far = far_field(&section, &light, AZIMUTHS, &Accuracy::default())?;
        let phi_deg: Vec<f64> = far.azimuths.phi_o().iter().map(|phi| phi.to_degrees()).collect();
        for polarization in Polarization::BOTH {
            let intensity = far.intensity(polarization).unwrap_or_default();
            for (phi, value) in phi_deg.iter().zip(&intensity) {
                for (sum, (_, at)) in sums.iter_mut().zip(MIRRORS_DEG) {
                    if (phi - at).abs() < HALF_DEG {
                        *sum += 0.5 * value * far.azimuths.step() / INDIVIDUALS as f64;
                    }
                }
            }
        }
    }
    Ok(sums)
}
