//! The film of a picture of 2005 beside what such a film reflects: numbers of docs/theory/peacock.md.

use barbule::Result;
use barbule::bsdf::PhaseFilm;
use barbule::film::{Polarization, response};
use barbule::material::Library;
use barbule::spectrum::colour::{Observer, encode};
use barbule::spectrum::{Spectrum, Wavelengths};
use barbule::stack::Stack;

/// Keratin by Zi et al. 2003, and the thickness that was taken for a film's.
pub(crate) const INDEX: f64 = 1.54;
pub(crate) const THICKNESS_NM: f64 = 140.0;
/// The film as it would be.
pub(crate) const STACK: &str = "air/1.54:140/air";

/// Both at one angle, over 400 to 700 nm.
pub(crate) struct Row {
    /// Where cos² δ is highest, nm; its colour.
    pub(crate) peak_nm: f64,
    pub(crate) colour: [u8; 3],
    /// Highest reflectance of the film, and its colour.
    pub(crate) highest: f64,
    pub(crate) film_colour: [u8; 3],
    /// Correlation of the two, and the ratio of their means.
    pub(crate) correlation: f64,
    pub(crate) ratio: f64,
}

/// cos²(δ/2) times four times the reflectance of one boundary, beside the film at normal incidence.
pub(crate) struct Halved {
    pub(crate) correlation: f64,
    pub(crate) absolute: f64,
    pub(crate) relative: f64,
}

pub(crate) fn row(angle_deg: f64) -> Result<Row> {
    let phase = PhaseFilm::new(THICKNESS_NM, INDEX)?;
    let cosine = angle_deg.to_radians().cos();
    let taken: Vec<f64> = nm().map(|nm| phase.reflectance(nm, cosine)).collect();
    let film = film(angle_deg)?;
    let highest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let peak = taken.iter().position(|r| *r == highest(&taken)).unwrap_or_default();
    Ok(Row {
        peak_nm: nm().nth(peak).unwrap_or_default(),
        colour: hue(&taken)?,
        highest: highest(&film),
        film_colour: hue(&film)?,
        correlation: correlation(&taken, &film),
        ratio: mean(&taken) / mean(&film),
    })
}

pub(crate) fn halved() -> Result<Halved> {
    let exact = film(0.0)?;
    let boundary = ((INDEX - 1.0) / (INDEX + 1.0)).powi(2);
    let two_beams = |nm: f64| {
        let delta = 4.0 * std::f64::consts::PI * THICKNESS_NM * INDEX / nm + std::f64::consts::PI;
        4.0 * boundary * (0.5 * delta).cos().powi(2)
    };
    let taken: Vec<f64> = nm().map(two_beams).collect();
    let errors = || taken.iter().zip(&exact).map(|(a, b)| ((a - b).abs(), *b));
    Ok(Halved {
        correlation: correlation(&taken, &exact),
        absolute: errors().map(|(error, _)| error).fold(0.0, f64::max),
        relative: errors().map(|(error, of)| error / of).fold(0.0, f64::max),
    })
}

fn nm() -> impl Iterator<Item = f64> {
    (400..=700).map(f64::from)
}

/// What the film reflects of unpolarized light.
pub(crate) fn film(angle_deg: f64) -> Result<Vec<f64>> {
    let stack = Stack::parse(STACK, &Library::builtin())?;
    let of = |nm: f64, polarization| response(&stack, nm, angle_deg.to_radians(), polarization);
    nm().map(|nm| Ok(0.5 * (of(nm, Polarization::S)?.reflected + of(nm, Polarization::P)?.reflected)))
        .collect()
}

/// A colour in daylight, as bright as a screen shows it.
fn hue(reflectance: &[f64]) -> Result<[u8; 3]> {
    let spectrum = Spectrum::new(Wavelengths::new(nm().collect::<Vec<_>>())?, reflectance.to_vec())?;
    let rgb = Observer::default().linear_rgb(&spectrum);
    let most = rgb.into_iter().fold(0.0, f64::max);
    Ok(rgb.map(|v| (255.0 * encode((v / most).clamp(0.0, 1.0))).round() as u8))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let [mean_a, mean_b] = [a, b].map(mean);
    let sum =
        |of: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(a, b)| of(a - mean_a, b - mean_b)).sum::<f64>();
    sum(&|a, b| a * b) / (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt()
}
