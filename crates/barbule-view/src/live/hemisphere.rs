//! A material's lobe over the hemisphere: its colour everywhere, and its spectrum where somebody touches it.
//!
//! The hemisphere is seen from above on a disc of radius 1 on which equal areas are equal solid angles (Lambert's projection): a
//! direction at the polar angle θ lies √2 sin(θ/2) from the middle; x is across the barbule and y along it.

use std::f64::consts::{PI, SQRT_2};
use std::sync::Arc;

use barbule::brdf::FeatherBrdf;
use barbule::progress::Progress;
use barbule::spectrum::colour::{Illuminant, Observer};
use barbule::spectrum::{Spectrum, Wavelengths};
use barbule::{DVec3, Error, Result};

/// Wavelengths that are evaluated together.
const FOUR: usize = 4;

/// A lobe over the hemisphere.
#[derive(Debug, Clone)]
pub struct HemisphereJob {
    /// The material.
    pub brdf: Arc<FeatherBrdf>,
    /// Unit vector towards the light, in the barbule's frame.
    pub incident: DVec3,
    /// The name of the individual; the mean over them without one.
    pub individual: Option<u64>,
    /// Pixels along the disc's diameter.
    pub side: usize,
    /// Wavelengths of which colours are made.
    pub at: Wavelengths,
}

/// The colours of a lobe.
#[derive(Debug, Clone, PartialEq)]
pub struct Hemisphere {
    /// Pixels along the disc's diameter.
    pub side: usize,
    /// Linear sRGB of πf in daylight, where a white diffuser is 1. Shape: `[row, column, 3]` from the disc's upper left; 0 outside it.
    pub rgb: Vec<f32>,
    /// The largest value of a channel.
    pub peak: f32,
}

/// The direction at a place of the disc; none outside of it.
#[must_use]
pub fn direction_at([x, y]: [f64; 2]) -> Option<DVec3> {
    let squared = x * x + y * y;
    // z = cosθ = 1 − r² follows from r = √2 sin(θ/2).
    let z = 1.0 - squared;
    let spread = (2.0 - squared).max(0.0).sqrt();
    (squared < 1.0).then(|| DVec3::new(x * spread, y * spread, z))
}

/// The place of a unit direction above the horizon on the disc.
#[must_use]
pub fn place_of(direction: DVec3) -> [f64; 2] {
    let sine_of_half = (0.5 * (1.0 - direction.z)).max(0.0).sqrt();
    let flat = direction.x.hypot(direction.y);
    if flat == 0.0 {
        return [0.0; 2];
    }
    let radius = SQRT_2 * sine_of_half;
    [direction.x / flat * radius, direction.y / flat * radius]
}

/// Unit vector towards light that comes across a barbule at this angle from its normal, rad.
#[must_use]
pub fn lit_across(angle: f64) -> DVec3 {
    DVec3::new(libm::sin(angle), 0.0, libm::cos(angle))
}

/// How far from the middle of the disc directions at this angle from the normal lie, rad.
#[must_use]
pub fn radius_of(theta: f64) -> f64 {
    SQRT_2 * libm::sin(0.5 * theta)
}

impl Hemisphere {
    /// The brightness that a screen's white best shows, where a white diffuser is 1: all but the brightest hundredth of what is lit at
    /// all is under it. 1 of a lobe that is black.
    #[must_use]
    pub fn white(&self) -> f64 {
        let lit = |rgb: &[f32]| {
            let most = rgb.iter().copied().fold(0.0, f32::max);
            (most > 0.0).then_some(most)
        };
        let mut brightest: Vec<f32> = self.rgb.chunks_exact(3).filter_map(lit).collect();
        brightest.sort_by(f32::total_cmp);
        let place = brightest.len().saturating_sub(1 + brightest.len() / 100);
        brightest.get(place).map_or(1.0, |value| f64::from(*value))
    }
}

/// The lobe's colours.
///
/// # Errors
/// A stop by `progress`, or a disc without pixels.
pub fn hemisphere(job: &HemisphereJob, progress: &dyn Progress) -> Result<Hemisphere> {
    let side = job.side;
    if side == 0 {
        return Err(Error::input("the disc of the lobe has no pixels; give at least 1 along its diameter"));
    }
    let weights = Observer::under(Illuminant::D65).weights(&job.at);
    let mut rgb = vec![0.0; 3 * side * side];
    progress.begin("lobe", side as u64);
    for row in 0..side {
        if progress.is_cancelled() {
            return Err(Error::interrupted());
        }
        let centre = |k: usize| 2.0 * (k as f64 + 0.5) / side as f64 - 1.0;
        let seen =
            (0..side).filter_map(|column| Some((column, direction_at([centre(column), -centre(row)])?)));
        let (columns, outgoing): (Vec<usize>, Vec<DVec3>) = seen.unzip();
        let values = values(&job.brdf, job.incident, &outgoing, job.individual, &job.at);
        for (column, spectrum) in columns.into_iter().zip(values.chunks_exact(job.at.len())) {
            let colour = weights.linear_rgb(spectrum).map(|channel| (PI * channel) as f32);
            rgb[3 * (row * side + column)..][..3].copy_from_slice(&colour);
        }
        progress.advance(1);
    }
    let peak = rgb.iter().copied().fold(0.0, f32::max);
    Ok(Hemisphere { side, rgb, peak })
}

/// What a white diffuser's reflectance is 1 for, πf, into one direction; `individual` as in [`HemisphereJob`].
///
/// # Errors
/// None of a material that is sound.
pub fn lobe_spectrum(
    brdf: &FeatherBrdf,
    [incident, outgoing]: [DVec3; 2],
    individual: Option<u64>,
    at: &Wavelengths,
) -> Result<Spectrum> {
    let values = values(brdf, incident, &[outgoing], individual, at);
    Spectrum::new(at.clone(), values.into_iter().map(|f| PI * f).collect())
}

/// f in 1/sr into each direction. Shape: `[direction, wavelength]`.
fn values(
    brdf: &FeatherBrdf,
    incident: DVec3,
    outgoing: &[DVec3],
    individual: Option<u64>,
    at: &Wavelengths,
) -> Vec<f64> {
    // The last four are filled with the last wavelength.
    let fours = at.len().div_ceil(FOUR);
    let nm = |k: usize| at[k.min(at.len() - 1)] as f32;
    let own: Vec<[f32; FOUR]> =
        (0..fours).map(|four| std::array::from_fn(|lane| nm(FOUR * four + lane))).collect();
    let pairs: Vec<[DVec3; 2]> = outgoing.iter().map(|wo| [incident, *wo]).collect();
    let wavelengths = own.repeat(pairs.len());
    let names = individual.map(|name| vec![name; pairs.len()]);
    let mut found = vec![[0.0; FOUR]; wavelengths.len()];
    brdf.eval_all(&pairs, &wavelengths, names.as_deref(), &mut found);
    let of_pairs = found.as_flattened().chunks_exact(FOUR * fours);
    of_pairs.flat_map(|values| values[..at.len()].iter().map(|f| f64::from(*f))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::Unobserved;
    use barbule::brdf::Options;
    use barbule::characterize::Catalog;
    use barbule::progress::Shared;
    use barbule::structure::Structure;

    fn starling() -> Arc<FeatherBrdf> {
        let found = Catalog::default().shipped(&Structure::builtin("starling").unwrap()).unwrap().unwrap();
        Arc::new(FeatherBrdf::new(&found.material, Options::default()).unwrap())
    }

    #[test]
    fn directions_and_places_belong_to_each_other_and_areas_are_solid_angles() {
        for place in [[0.0, 0.0], [0.3, -0.6], [-0.9, 0.2]] {
            let direction = direction_at(place).unwrap();
            assert!((direction.length() - 1.0).abs() < 1e-12 && direction.z > 0.0);
            let back = place_of(direction);
            assert!((back[0] - place[0]).hypot(back[1] - place[1]) < 1e-12, "{place:?} {back:?}");
        }
        assert!(direction_at([0.8, 0.7]).is_none());
        for theta in [0.3, 1.0, 1.5] {
            let place = place_of(lit_across(theta));
            assert!((place[0] - radius_of(theta)).abs() < 1e-12 && place[1] == 0.0);
        }
        assert!((radius_of(std::f64::consts::FRAC_PI_2) - 1.0).abs() < 1e-12);
        // The mean of cosθ over the hemisphere's solid angle is ½.
        let side = 400;
        let centre = |k: usize| 2.0 * (k as f64 + 0.5) / side as f64 - 1.0;
        let all: Vec<f64> = (0..side * side)
            .filter_map(|k| direction_at([centre(k % side), centre(k / side)]))
            .map(|direction| direction.z)
            .collect();
        assert!((all.iter().sum::<f64>() / all.len() as f64 - 0.5).abs() < 1e-3);
    }

    #[test]
    fn spectra_and_colours_are_those_of_the_material() {
        let brdf = starling();
        let at = Wavelengths::usual();
        let (wi, wo) = (direction_at([0.2, 0.05]).unwrap(), direction_at([-0.2, -0.05]).unwrap());
        for individual in [None, Some(7)] {
            let spectrum = lobe_spectrum(&brdf, [wi, wo], individual, &at).unwrap();
            let own =
                brdf.eval([at[12] as f32, at[13] as f32, at[14] as f32, at[15] as f32], wi, wo, individual);
            assert!((spectrum.values()[13] - PI * f64::from(own[1])).abs() < 1e-9);
        }
        let job = HemisphereJob {
            brdf: Arc::clone(&brdf),
            incident: wi,
            individual: None,
            side: 20,
            at: at.clone(),
        };
        let lobe = hemisphere(&job, &Unobserved).unwrap();
        assert_eq!((lobe.rgb.len(), lobe.rgb[..3].to_vec()), (1200, vec![0.0; 3]));
        let (row, column) = (10, 7);
        let there = direction_at([2.0 * 7.5 / 20.0 - 1.0, 1.0 - 2.0 * 10.5 / 20.0]).unwrap();
        let seen = Observer::default().linear_rgb(&lobe_spectrum(&brdf, [wi, there], None, &at).unwrap());
        for (found, seen) in lobe.rgb[3 * (row * 20 + column)..].iter().zip(seen) {
            assert!((f64::from(*found) - seen).abs() < 1e-5 * (1.0 + seen.abs()), "{found} {seen}");
        }
        assert!(lobe.peak > 0.0 && lobe.rgb.iter().all(|value| *value <= lobe.peak));
    }

    #[test]
    fn white_is_under_the_brightest_hundredth() {
        let mut rgb = vec![0.0; 3 * 400];
        (0..200).for_each(|k| rgb[3 * k + 1] = 1.0 + k as f32);
        let lobe = Hemisphere { side: 20, rgb, peak: 200.0 };
        assert_eq!(lobe.white(), 198.0);
        assert_eq!(Hemisphere { side: 1, rgb: vec![0.0; 3], peak: 0.0 }.white(), 1.0);
    }

    #[test]
    fn whoever_watches_stops_it() {
        let progress = Shared::default();
        progress.cancel();
        let job = HemisphereJob {
            brdf: starling(),
            incident: DVec3::Z,
            individual: None,
            side: 8,
            at: Wavelengths::usual(),
        };
        assert!(hemisphere(&job, &progress).unwrap_err().is_interrupted());
        assert!(hemisphere(&HemisphereJob { side: 0, ..job }, &Unobserved).unwrap_err().is_input());
    }
}
