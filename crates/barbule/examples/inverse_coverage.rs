//! How often the intervals of `fit-structure` hold the truth: the table of `docs/theory/inverse.md`.
//!
//! `cargo run --release -p barbule --example inverse_coverage [FITS] [SEED]`: films and multilayers of random thicknesses are simulated, scaled, made
//! noisy, and fitted; printed is in how many of a hundred fits each size lies in its 95 % interval, of the best solution and of
//! whichever fits as well.

#![allow(clippy::print_stdout)] // a program that prints a table

use barbule::Result;
use barbule::film::{Polarization, reflect};
use barbule::instrument::Instrument;
use barbule::inverse::{Beam, Reading, Settings, Solution, fit_stack};
use barbule::material::Library;
use barbule::math::rng::Stream;
use barbule::spectrum::{Spectrum, Wavelengths};
use barbule::stack::Stack;

/// One line of the table.
struct Case {
    about: &'static str,
    /// The stack, with `?` for each thickness, and where these are drawn from, nm.
    stack: &'static str,
    drawn_nm: &'static [[f64; 2]],
    searched_nm: [f64; 2],
    /// First and last wavelength and step, nm.
    at_nm: [f64; 3],
    /// Deviation of the errors over the mean reflectance, and their correlation length, nm.
    errors: [f64; 2],
    instrument: Option<&'static str>,
}

const CASES: &[Case] = &[
    Case {
        about: "film, 3 %, independent",
        stack: "air/keratin:?/air",
        drawn_nm: &[[80.0, 2500.0]],
        searched_nm: [50.0, 3000.0],
        at_nm: [300.0, 700.0, 5.0],
        errors: [0.03, 0.0],
        instrument: None,
    },
    Case {
        about: "film, 10 %, alike over 15 nm, 400–700 nm",
        stack: "air/keratin:?/air",
        drawn_nm: &[[80.0, 2500.0]],
        searched_nm: [50.0, 3000.0],
        at_nm: [400.0, 700.0, 5.0],
        errors: [0.1, 15.0],
        instrument: None,
    },
    Case {
        about: "film, 10 %, alike over 40 nm, every 2 nm",
        stack: "air/keratin:?/air",
        drawn_nm: &[[80.0, 2500.0]],
        searched_nm: [50.0, 3000.0],
        at_nm: [300.0, 700.0, 2.0],
        errors: [0.1, 40.0],
        instrument: None,
    },
    Case {
        about: "film on melanin under a probe of 10°, 5 %, alike over 15 nm",
        stack: "air/keratin:?/melanin",
        drawn_nm: &[[80.0, 1500.0]],
        searched_nm: [50.0, 3000.0],
        at_nm: [300.0, 700.0, 5.0],
        errors: [0.05, 15.0],
        instrument: Some("probe:10"),
    },
    Case {
        about: "six pairs, both thicknesses, 3 %, alike over 15 nm, every 10 nm",
        stack: "air/keratin:10/6*(melanin:?/keratin:?)/keratin",
        drawn_nm: &[[50.0, 200.0], [50.0, 200.0]],
        searched_nm: [20.0, 300.0],
        at_nm: [300.0, 700.0, 10.0],
        errors: [0.03, 15.0],
        instrument: None,
    },
];

fn main() -> Result<()> {
    let number = |k: usize, usual: u64| std::env::args().nth(k).and_then(|n| n.parse().ok()).unwrap_or(usual);
    let (fits, seed) = (number(1, 100), number(2, 1));
    println!("| case | held by the best, of 100 | by one that fits as well | fits with several such |");
    println!("| --- | --- | --- | --- |");
    for case in CASES {
        let [mut best, mut any, mut several] = [0, 0, 0];
        for k in 0..fits {
            let (truth, solutions) = one(case, &mut Stream::new(seed, &[k]))?;
            let inside = |solution: &Solution| {
                let sizes = solution.sizes.iter().zip(&truth);
                sizes.filter(|(size, truth)| (size.low..=size.high).contains(truth)).count()
            };
            let as_good = || solutions.iter().filter(|solution| solution.as_good);
            best += inside(&solutions[0]);
            any += as_good().map(inside).max().unwrap_or(0);
            several += usize::from(as_good().count() > 1);
        }
        let sizes = (fits * case.drawn_nm.len() as u64) as f64;
        let part = |count: usize| 100.0 * count as f64 / sizes;
        println!("| {} | {:.0} | {:.0} | {several} of {fits} |", case.about, part(best), part(any));
    }
    Ok(())
}

/// The thicknesses that were drawn and what was found of their spectrum.
fn one(case: &Case, stream: &mut Stream) -> Result<(Vec<f64>, Vec<Solution>)> {
    let library = Library::builtin();
    let truth: Vec<f64> = case.drawn_nm.iter().map(|[low, high]| stream.uniform(*low, *high)).collect();
    let text = truth.iter().fold(case.stack.to_owned(), |text, nm| text.replacen('?', &nm.to_string(), 1));
    let stack = Stack::parse(&text, &library)?;
    let beams: Vec<Beam> = match case.instrument {
        None => vec![Beam { direction: (0.0, 0.0), weight: 1.0 }],
        Some(text) => {
            let light = Instrument::parse(text)?.planar(0.0, 0.0);
            light.iter().map(|l| Beam { direction: (0.0, l.angle), weight: l.weight }).collect()
        }
    };
    let [first, last, step] = case.at_nm;
    let count = ((last - first) / step).round() as usize;
    let at = Wavelengths::new((0..=count).map(|k| first + step * k as f64).collect::<Vec<_>>())?;
    let mut exact = Vec::with_capacity(at.len());
    for &nm in at.iter() {
        let indices = stack.indices(nm)?;
        let mut value = 0.0;
        for beam in &beams {
            for polarization in Polarization::BOTH {
                let r = reflect(&indices, stack.thickness_nm(), nm, beam.direction.1, polarization)?;
                value += 0.5 * beam.weight * r.norm_sqr();
            }
        }
        exact.push(value);
    }
    let [part, length_nm] = case.errors;
    let size = part * exact.iter().sum::<f64>() / exact.len() as f64;
    let kept = if length_nm > 0.0 { (-step / length_nm).exp() } else { 0.0 };
    let level = stream.uniform(0.3, 1.2);
    let mut error = stream.normal();
    let noisy = exact.iter().map(|value| {
        error = kept * error + (1.0 - kept * kept).sqrt() * stream.normal();
        level * (value + size * error)
    });
    let measured = Spectrum::new(at.clone(), noisy.collect())?;
    let reading = Reading::new(case.about, &measured, &[], beams, None)?;
    let found = fit_stack(case.stack, case.searched_nm, &library, &[reading], &Settings::default())?;
    Ok((truth, found.fit.solutions))
}
