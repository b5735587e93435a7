//! Time, memory and accuracy of full waves against the number of unknowns: all elements, and thin products.
//!
//! ```text
//! full_wave_scaling SPECIES WAVELENGTH_NM THETA_DEG WIDTH_UM,WIDTH_UM,… [MOST_DENSE_UNKNOWNS]
//! ```

#![allow(clippy::print_stdout)] // a program that prints

use barbule::progress::Unobserved;
use barbule::scattering::far_field::Window;
use barbule::solve::full_wave::{ELEMENTS_PER_WAVELENGTH, Method, Problem, Solved};
use barbule::structure::{Beneath, Section, Structure};
use barbule::{Error, Result};

/// The largest difference of amplitudes against the largest one.
fn apart(a: &Solved, b: &Solved) -> f64 {
    let all = |solved: &Solved| {
        solved.scattered.far.amplitudes.iter().flatten().flatten().copied().collect::<Vec<_>>()
    };
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

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |at: usize| -> Result<f64> {
        let word =
            words.get(at).ok_or_else(|| Error::input("give SPECIES WAVELENGTH_NM THETA_DEG WIDTHS_UM"))?;
        word.parse().map_err(|_| Error::input(format!("{word} is no number")))
    };
    let (wavelength_nm, theta) = (number(1)?, number(2)?.to_radians());
    let most_dense = number(4).unwrap_or(20_000.0);
    println!("width_um,unknowns,method,seconds,megabytes,balance_1,balance_2,difference");
    for width in words.get(3).map_or("", |widths| widths).split(',') {
        let width_um = width.parse().map_err(|_| Error::input(format!("{width} is no width in µm")))?;
        let section = narrowed(&words[0], width_um)?.closed(Beneath::Absorbing)?.regions;
        let run = |method| -> Result<Solved> {
            let problem = Problem::new(&section, wavelength_nm, theta, ELEMENTS_PER_WAVELENGTH)?.by(method);
            Ok(problem.solve(&[0.0], Window::PlaneWave, 720, &Unobserved)?.swap_remove(0))
        };
        let told = |name: &str, solved: &Solved, difference: Option<f64>| {
            let (found, effort) = (&solved.scattered, solved.effort);
            let balance = |p: usize| {
                let extinct = found.extinction_um.map_or(f64::NAN, |both| both[p]);
                (found.scattered_um[p] + found.absorbed_um[p]) / extinct - 1.0
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
        }
        match run(Method::Hierarchical) {
            Ok(thin) => told("thin", &thin, dense.as_ref().map(|dense| apart(dense, &thin))),
            Err(error) => println!("{width_um},{unknowns},thin,{error}"),
        }
    }
    Ok(())
}
