//! Prints and draws the tone curves of `docs/theory/rendering.md`: `tone_curves docs/figures/tone.svg`.

#![allow(clippy::print_stdout)] // a program

use std::path::Path;

use barbule::io::write_whole;
use barbule::plot::{Axis, Curve, Figure, Format};
use barbule::render::tone::shown;
use barbule::scene::description::ToneWord;

/// Light whose values are printed.
const PRINTED: [f64; 11] = [0.01, 0.045, 0.09, 0.18, 0.36, 0.72, 1.0, 2.0, 4.0, 8.0, 16.3];

fn main() -> barbule::Result<()> {
    let grey = |tone: ToneWord, value: f64| shown(tone, [value; 3])[0];
    let range = |label: &str, from, to| Axis { range: Some([from, to]), ..Axis::logarithmic(label) };
    let mut figure = Figure::new(
        "Tone curves",
        range("linear light after exposure (grey card 0.18)", 0.005, 20.0),
        range("linear value on the screen (white 1)", 0.002, 1.2),
    );
    let steps = 200;
    let place = |k: u32| 0.005 * 4000_f64.powf(f64::from(k) / f64::from(steps));
    for (word, tone) in ToneWord::ALL {
        let printed: Vec<String> = PRINTED.iter().map(|&v| format!("{:.3}", grey(*tone, v))).collect();
        println!("| {word} | {} |", printed.join(" | "));
        let points = (0..=steps).map(|k| [place(k), grey(*tone, place(k))]).collect();
        figure.curves.push(Curve::line(*word, points));
    }
    figure.curves.push(Curve::points("grey card", vec![[0.18, 0.18]]));
    if let Some(path) = std::env::args().nth(1) {
        let path = Path::new(&path);
        write_whole(path, &figure.draw().encode(Format::of(path)?, &[])?)?;
    }
    Ok(())
}
