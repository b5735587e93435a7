//! Fitted curves over a measurement, and what they leave of it.

use crate::inverse::{Estimate, Fit, Parameter, Reading, Solution, in_words};
use crate::plot::{Axis, Curve, Drawing, Figure, Ink, Stroke};
use crate::spectrum::Spectrum;

/// Curves of solutions that are drawn of one reading, and of the best one of several readings.
const MOST_DRAWN: usize = 4;
const MOST_READINGS: usize = 6;

/// The size of the plane of residuals, px, as wide as that of the curves.
const RESIDUALS: [f64; 2] = [520.0, 130.0];

/// The solutions over the measurement, each with its sizes and their intervals, and below them measured − fitted. Of several
/// readings the best solution of each is drawn.
#[must_use]
pub fn inverse(title: &str, fit: &Fit, readings: &[Reading]) -> Drawing {
    let mut above = Figure::new(title, Axis::new("wavelength (nm)"), Axis::new("reflectance"));
    let mut below = Figure::new("", Axis::new("wavelength (nm)"), Axis::new("measured − fitted"));
    below.size = RESIDUALS;
    match readings {
        [reading] => one(&mut above, &mut below, fit, reading),
        several => many(&mut above, &mut below, fit, several),
    }
    let (above, below) = (above.draw(), below.draw());
    let mut both = Drawing::new(above.width.max(below.width), above.height + below.height);
    let down = above.height;
    both.place(above, [0.0, 0.0]);
    both.place(below, [0.0, down]);
    both
}

fn points(curve: &Spectrum) -> Vec<[f64; 2]> {
    curve.wavelengths().iter().zip(curve.values()).map(|(&x, &y)| [x, y]).collect()
}

fn dashed() -> Stroke {
    Stroke { ink: Ink::BLACK, width: 1.8, dash: vec![6.0, 3.0] }
}

fn residual(reading: &Reading, fitted: &Spectrum) -> Vec<[f64; 2]> {
    let difference = reading.mean.values().iter().zip(fitted.values()).map(|(m, f)| m - f);
    reading.mean.wavelengths().iter().zip(difference).map(|(&x, y)| [x, y]).collect()
}

fn one(above: &mut Figure, below: &mut Figure, fit: &Fit, reading: &Reading) {
    let thin = Stroke::solid(Ink::BLACK.with_opacity(0.5), 0.6);
    let samples = reading.samples.iter();
    above.curves.extend(
        samples.map(|sample| Curve { stroke: Some(thin.clone()), ..Curve::line("", points(sample)) }),
    );
    above.curves.push(Curve { stroke: Some(dashed()), ..Curve::line("measured", points(&reading.mean)) });
    for (k, solution) in fit.solutions.iter().take(MOST_DRAWN).enumerate() {
        let stroke = Some(crate::plot::style(k));
        let name = legend(fit, solution, k);
        let fitted = &solution.fitted[0];
        above.curves.push(Curve { stroke: stroke.clone(), ..Curve::line(name, points(fitted)) });
        below.curves.push(Curve { stroke, ..Curve::line("", residual(reading, fitted)) });
    }
    above.footnote = Some("in brackets: 95 % intervals; ruled out: at 95 %, against the first".to_owned());
}

fn many(above: &mut Figure, below: &mut Figure, fit: &Fit, readings: &[Reading]) {
    let best = &fit.solutions[0];
    for (k, (reading, fitted)) in readings.iter().zip(&best.fitted).take(MOST_READINGS).enumerate() {
        let stroke = crate::plot::style(k);
        let dotted = Stroke { width: 2.2, dash: vec![1.5, 2.5], ..stroke.clone() };
        above.curves.push(Curve { stroke: Some(dotted), ..Curve::line("", points(&reading.mean)) });
        let solid = Stroke { dash: Vec::new(), ..stroke.clone() };
        above.curves.push(Curve { stroke: Some(solid), ..Curve::line(reading.name.clone(), points(fitted)) });
        below.curves.push(Curve { stroke: Some(stroke), ..Curve::line("", residual(reading, fitted)) });
    }
    let sizes: Vec<String> =
        fit.parameters.iter().zip(&best.sizes).map(|(p, size)| in_words(p, size)).collect();
    let more = readings.len().saturating_sub(MOST_READINGS);
    let more = if more > 0 { format!("; {more} further readings are not drawn") } else { String::new() };
    above.footnote = Some(format!("{}; dotted: measured{more}", sizes.join("; ")));
}

/// A solution's sizes, shortly.
fn legend(fit: &Fit, solution: &Solution, place: usize) -> String {
    let size = |(p, size): (&Parameter, &Estimate)| {
        let digits = size.digits();
        let Estimate { value, low, high, .. } = *size;
        format!("{} {value:.digits$} ({low:.digits$}–{high:.digits$})", p.name)
    };
    let sizes: Vec<String> = fit.parameters.iter().zip(&solution.sizes).map(size).collect();
    let ruled_out = if solution.as_good { "" } else { ", ruled out" };
    format!("{}{ruled_out}: {}", place + 1, sizes.join(", "))
}
