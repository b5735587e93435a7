//! Predictions beside what was measured of feathers, as `docs/theory/measured.md` shows them:
//! `target/release/examples/measured_feathers FOLDER` (after `cargo build --release --workspace --examples`), 20 CPU seconds.

#![allow(clippy::print_stdout)] // a program

use std::path::Path;

use barbule::io::write_whole;
use barbule::material::Library;
use barbule::plot::{Axis, Curve, Figure, Format};
use barbule::progress::Unobserved;
use barbule::solve::crystal::{Multipole, sweep};
use barbule::spectrum::peaks::{Origin, highest, peaks};
use barbule::spectrum::{Spectrum, Wavelengths};
use barbule::stack::Stack;
use barbule::structure::SpeciesModel;
use barbule::{Error, Result, film};

const TEAL: &str = include_str!("../../../examples/published/green-winged-teal.csv");
/// What the documentation of pavo prints: angle, degrees, and peak, nm.
const PRINTED: [[f64; 2]; 2] = [[20.0, 517.0], [55.0, 468.0]];
/// The pigeon's nape: 1/λ in µm⁻¹ of the peak and of the trough.
const PIGEON_NM: [(&str, f64); 2] =
    [("measured peak, near 440 nm", 440.0), ("measured trough, near 500 nm", 500.0)];
const PIGEON_FILM: &str = "air/keratin:643/air";

fn main() -> Result<()> {
    let folder = std::env::args().nth(1).ok_or_else(|| Error::input("name the folder of the figures"))?;
    draw(&teal()?, &Path::new(&folder).join("measured-teal.svg"))?;
    draw(&pigeon()?, &Path::new(&folder).join("measured-pigeon.svg"))
}

fn draw(figure: &Figure, path: &Path) -> Result<()> {
    write_whole(path, &figure.draw().encode(Format::of(path)?, &[])?)
}

/// Peaks against the angle: read from colours, printed, and those of the mallard's lattice.
fn teal() -> Result<Figure> {
    let lines = TEAL.lines().filter(|line| !line.starts_with('#')).skip(1);
    let cells =
        lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect::<Vec<f64>>());
    let rows: Vec<Vec<f64>> = cells.filter(|row| row[2].is_finite()).collect();
    let column = |k: usize| rows.iter().map(|row| [row[0], row[k]]).collect::<Vec<_>>();
    let angles_deg: Vec<f64> = (0..=13).map(|k| 5.0 * f64::from(k)).collect();
    let lattice = mallard(&angles_deg)?;
    for ([angle, nm], ours) in column(2).iter().zip(&lattice[3..]) {
        println!(
            "{angle}°: {nm} nm, lattice {:.0} nm, {:.1} %, half way down {:.0} nm",
            ours[1],
            100.0 * ours[2],
            ours[3]
        );
    }
    let mut chart = Figure::new(
        "Green-winged teal, wing patch",
        Axis::new("angle of incidence (°)"),
        Axis::new("wavelength of the peak (nm)"),
    );
    let middles = rows.iter().map(|row| [row[0], 0.5 * (row[3] + row[4])]).collect();
    let halves = rows.iter().map(|row| 0.5 * (row[4] - row[3])).collect();
    chart.curves.push(Curve { spread: Some(halves), ..Curve::line("range of readings", middles) });
    chart.curves.push(Curve::points("measured, printed by pavo", PRINTED.to_vec()));
    chart.curves.push(Curve::points("measured, read from colours", column(2)));
    chart
        .curves
        .push(Curve::line("mallard:green, nothing fitted", lattice.iter().map(|p| [p[0], p[1]]).collect()));
    Ok(chart)
}

/// Angle, degrees, peak, nm, its reflectance, and its full width, of the flat lattice lit across its rods.
fn mallard(angles_deg: &[f64]) -> Result<Vec<[f64; 4]>> {
    let species = SpeciesModel::builtin("mallard", Some("green"), Library::builtin())?;
    let lattice = species.lattice().ok_or_else(|| Error::input("the mallard has no lattice"))?;
    let at = Wavelengths::new((0..=60).map(|k| 380.0 + 4.0 * f64::from(k)).collect::<Vec<_>>())?;
    let angles: Vec<f64> = angles_deg.iter().map(|angle| angle.to_radians()).collect();
    let found = sweep(&Multipole::default(), &lattice, at.nm(), 0.0, &angles, &Unobserved)?;
    let rows = angles_deg.iter().zip(found.chunks(at.len()));
    rows.map(|(angle, row)| {
        let curve = Spectrum::new(at.clone(), row.iter().map(|[a, b]| 0.5 * (a + b)).collect())?;
        let top = highest(&peaks(&curve, Origin::Computed, None), None)
            .ok_or_else(|| Error::input("a lattice without a peak"))?;
        Ok([*angle, top.nm, top.reflectance, top.half.nm().unwrap_or(f64::NAN)])
    })
    .collect()
}

/// The film's reflectance against 1/λ, with the measured peak and trough.
fn pigeon() -> Result<Figure> {
    let stack = Stack::parse(PIGEON_FILM, &Library::builtin())?;
    let at = Wavelengths::new((0..=250).map(|k| 330.0 + 2.0 * f64::from(k)).collect::<Vec<_>>())?;
    let found = film::sweep(&stack, &at, &[2.5_f64.to_radians()], &Unobserved)?.unpolarized();
    let points = at.nm().iter().zip(&found).map(|(nm, r)| [1e3 / nm, *r]).collect();
    let mut chart =
        Figure::new("Feral pigeon, nape", Axis::new("1/wavelength (1/µm)"), Axis::new("reflectance"));
    chart.curves.push(Curve::line(format!("{PIGEON_FILM} at 2.5°"), points));
    for (name, nm) in PIGEON_NM {
        chart.curves.push(Curve::line(name, vec![[1e3 / nm, 0.0], [1e3 / nm, 0.18]]));
    }
    Ok(chart)
}
