//! Segments in three dimensions: what one takes, and how far its field is from that of finer cells.
//!
//! ```text
//! segment_table WIDTH_UM LENGTH_UM WAVELENGTH_NM SPECIES…
//! ```

#![allow(clippy::print_stdout)] // a program that prints

use std::time::Instant;

use barbule::progress::Unobserved;
use barbule::solve::segment::{Hemisphere, SegmentAccuracy, SegmentLight, far_field};
use barbule::structure::{Roughness, Structure};
use barbule::{Error, Result};

fn distance(a: &Hemisphere, b: &Hemisphere) -> f64 {
    let (mut apart, mut whole) = (0.0, 0.0);
    for (a, b) in a.intensity().iter().zip(b.intensity()) {
        apart += (a - b).powi(2);
        whole += b * b;
    }
    (apart / whole).sqrt()
}

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [width, length, wavelength, species @ ..] = &words[..] else {
        return Err(Error::input("give WIDTH_UM LENGTH_UM WAVELENGTH_NM SPECIES…"));
    };
    let number = |word: &str| word.parse::<f64>().map_err(|_| Error::input(format!("{word} is no number")));
    let (width_um, length_um, wavelength_nm) = (number(width)?, number(length)?, number(wavelength)?);
    println!("species        seconds  reflected  of half cells: reflected  intensities apart");
    for name in species {
        let Structure::Species(model) = Structure::builtin(name)? else {
            return Err(Error::input(format!("{name} is no species")));
        };
        let model = model.with_parameters(&[("width_um", width_um.into())])?;
        let structure = Structure::Species(Box::new(model));
        let segment = structure.segment(1, 0, length_um, Roughness::default())?;
        let light = SegmentLight {
            wavelength_nm,
            theta_i: 0.3,
            phi_i: 0.3,
            window_um: [width_um / 4.0, length_um / 4.0],
            turn: 0.0,
        };
        let usual = SegmentAccuracy::default();
        let start = Instant::now();
        let far = far_field(&segment, &light, &usual, &Unobserved)?;
        let seconds = start.elapsed().as_secs_f64();
        let halved = SegmentAccuracy { cells: usual.cells.map(|c| 0.5 * c), ..usual };
        let fine = far_field(&segment, &light, &halved, &Unobserved)?;
        println!(
            "{name:<12} {seconds:9.3} {:10.5} {:24.5} {:18.2e}",
            far.reflected(),
            fine.reflected(),
            distance(&far, &fine)
        );
    }
    Ok(())
}
