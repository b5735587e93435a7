//! Time, memory and accuracy of full waves against the number of unknowns: all elements, and thin products.
//!
//! ```text
//! full_wave_scaling SPECIES WAVELENGTH_NM THETA_DEG WIDTH_UM,WIDTH_UM,… [MOST_DENSE_UNKNOWNS [FIGURE.svg]]
//! ```

#![allow(clippy::print_stdout)] // a program that prints

use barbule::clock;
use barbule::plot::{Axis, Curve, Figure, Format, Mark};
use barbule::progress::Unobserved;
use barbule::scattering::far_field::Window;
use barbule::solve::far_fields::{Effort, Scattered};
use barbule::solve::full_wave::{ELEMENTS_PER_WAVELENGTH, Method, Problem};
use barbule::structure::{Beneath, Ends, Section, Structure};
use barbule::{Error, Result};

/// The largest difference of amplitudes against the largest one.
fn apart(a: &Scattered, b: &Scattered) -> f64 {
    let all =
        |found: &Scattered| found.far.amplitudes.iter().flatten().flatten().copied().collect::<Vec<_>>();
    let (a, b) = (all(a), all(b));
    let worst = a.iter().zip(&b).map(|(x, y)| (x - y).norm()).fold(0.0, f64::max);
    worst / a.iter().map(|x| x.norm()).fold(0.0, f64::max)
}

/// An individual of a species, but so wide.
fn narrowed(name: &str, width_um: f64) -> Result<Section> {
    let Structure::Species(model) = Structure::builtin(name)? else {
        return Err(Error::input(format!("{name} is no species")));
    };
    let model = model.with_parameters(&[("width_um", width_um.into())])?;
    model.section(1, 0)
}

/// What solutions of growing size took: unknowns, seconds, bytes.
type Efforts = Vec<[f64; 3]>;

/// The power of the unknowns with which a quantity grows: the slope of the line through the logarithms.
fn exponent(efforts: &Efforts, quantity: usize) -> f64 {
    let points: Vec<[f64; 2]> = efforts.iter().map(|row| [row[0].ln(), row[quantity].ln()]).collect();
    let mean = |axis: usize| points.iter().map(|p| p[axis]).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let along: f64 = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    along / points.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>()
}

/// Time and memory against unknowns.
fn figure(title: String, methods: &[(&str, &Efforts)]) -> Figure {
    let (x, y) = (Axis::logarithmic("unknowns"), Axis::logarithmic("time (s), memory (GB)"));
    let mut figure = Figure::new(title, x, y);
    for (name, efforts) in methods {
        for (quantity, unit, word) in [(1, 1.0, "time"), (2, 1e-9, "memory")] {
            let points: Vec<[f64; 2]> = efforts.iter().map(|row| [row[0], unit * row[quantity]]).collect();
            let power = exponent(efforts, quantity);
            let name = format!("{name}: {word}, power {power:.1}");
            figure.curves.push(Curve { mark: Mark::Both, ..Curve::line(name, points) });
        }
    }
    figure
}

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |at: usize| -> Result<f64> {
        let word =
            words.get(at).ok_or_else(|| Error::input("give SPECIES WAVELENGTH_NM THETA_DEG WIDTHS_UM"))?;
        word.parse().map_err(|_| Error::input(format!("{word} is no number")))
    };
    let (wavelength_nm, theta) = (number(1)?, number(2)?.to_radians());
    let most_dense = number(4).unwrap_or(20_000.0);
    let mut efforts: [Efforts; 2] = Default::default();
    let row = |effort: Effort| [effort.unknowns as f64, effort.seconds, effort.memory_bytes as f64];
    println!("width_um,unknowns,method,seconds,megabytes,balance_1,balance_2,difference");
    for width in words.get(3).map_or("", |widths| widths).split(',') {
        let width_um = width.parse().map_err(|_| Error::input(format!("{width} is no width in µm")))?;
        let section = narrowed(&words[0], width_um)?.closed(Beneath::Absorbing, Ends::Closed)?.regions;
        let run = |method| -> Result<(Scattered, Effort)> {
            let problem = Problem::new(&section, wavelength_nm, theta, ELEMENTS_PER_WAVELENGTH)?.by(method);
            let found =
                problem.solve(&[0.0], Window::PlaneWave, 720, clock::system, &Unobserved)?.swap_remove(0);
            let effort = found.effort.ok_or_else(|| Error::machine("full waves say what they took"))?;
            Ok((found, effort))
        };
        let told = |name: &str, (found, effort): &(Scattered, Effort), difference: Option<f64>| {
            let balance = |p: usize| {
                found.exact.map_or(f64::NAN, |exact| {
                    let extinct = exact.extinction_um.map_or(f64::NAN, |both| both[p]);
                    (exact.scattered_um[p] + exact.absorbed_um[p]) / extinct - 1.0
                })
            };
            println!(
                "{width_um},{},{name},{:.2},{:.0},{:.1e},{:.1e},{}",
                effort.unknowns,
                effort.seconds,
                effort.memory_bytes as f64 / 1e6,
                balance(0),
                balance(1),
                difference.map_or(String::new(), |value| format!("{value:.1e}"))
            );
        };
        let unknowns =
            Problem::new(&section, wavelength_nm, theta, ELEMENTS_PER_WAVELENGTH)?.cost(1).unknowns;
        let dense = if unknowns as f64 <= most_dense { Some(run(Method::Dense)?) } else { None };
        if let Some(dense) = &dense {
            told("dense", dense, None);
            efforts[0].push(row(dense.1));
        }
        match run(Method::Hierarchical) {
            Ok(thin) => {
                told("thin", &thin, dense.as_ref().map(|dense| apart(&dense.0, &thin.0)));
                efforts[1].push(row(thin.1));
            }
            Err(error) => println!("{width_um},{unknowns},thin,{error}"),
        }
    }
    if let Some(path) = words.get(5) {
        let title = format!(
            "{} at {wavelength_nm} nm, {}",
            words[0],
            if theta == 0.0 { "θ_i = 0" } else { "oblique" }
        );
        let figure = figure(title, &[("all elements", &efforts[0]), ("thin products", &efforts[1])]);
        barbule::io::write_whole(path.as_ref(), &figure.draw().encode(Format::Svg, &[])?)?;
    }
    Ok(())
}
