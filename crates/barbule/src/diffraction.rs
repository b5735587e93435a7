//! What a heightfield does with light, in colours: the reference, and how far its tables are from it.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::error::{did_you_mean, shortened};
use crate::math::rng::hash;
use crate::progress::Progress;
use crate::scattering::grating::{Place, Powers, Setup, TableGrid, Tables};
use crate::solve::diffraction::{Amplitudes, Builder, Reach, Series};
use crate::spectrum::Wavelengths;
use crate::spectrum::colour::Observer;
use crate::spectrum::difference::{delta_e_2000, lab};
use crate::spectrum::sensor::Band;
use crate::structure::{Fingers, Heightfield, SAMPLES};
use crate::{Error, Result};

/// Tables are judged where the reference is brighter than this of its brightest.
const SEEN: f64 = 1e-3;

/// A direction by its polar angle from the normal and its azimuth from +x towards +y, both in degrees.
#[must_use]
pub fn direction(polar_deg: f64, azimuth_deg: f64) -> DVec3 {
    let (sin_theta, cos_theta) = sin_cos(polar_deg);
    let (sin_phi, cos_phi) = sin_cos(azimuth_deg);
    DVec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta)
}

fn sin_cos(degrees: f64) -> (f64, f64) {
    let angle = degrees.to_radians();
    (libm::sin(angle), libm::cos(angle))
}

/// The direction of a place of the unit disc, if it is one.
#[must_use]
pub fn over(place: DVec2) -> Option<DVec3> {
    let up = 1.0 - place.length_squared();
    (up > 0.0).then(|| place.extend(up.sqrt()))
}

/// The reference in colours: every wavelength and direction from the transforms of a patch.
pub struct Reference {
    amplitudes: Amplitudes,
    setup: Setup,
    at: Wavelengths,
    weights: crate::spectrum::colour::Weights,
}

impl Reference {
    /// Of a patch under an observer's light.
    ///
    /// # Errors
    /// A setup out of range, a patch too large, interruption.
    pub fn new(
        field: &Heightfield,
        setup: &Setup,
        observer: &Observer,
        at: &Wavelengths,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let amplitudes = Amplitudes::new(field, setup, Reach::of(setup, at), Series::Chebyshev, progress)?;
        Ok(Self { amplitudes, setup: *setup, at: at.clone(), weights: observer.weights(at) })
    }

    /// f at each wavelength.
    #[must_use]
    pub fn spectrum(&self, w_i: DVec3, w_o: DVec3) -> Vec<f64> {
        self.at.nm().iter().map(|nm| self.amplitudes.value(&self.setup, nm * 1e-3, w_i, w_o)).collect()
    }

    /// X, Y, Z of f.
    #[must_use]
    pub fn xyz(&self, w_i: DVec3, w_o: DVec3) -> [f64; 3] {
        self.weights.xyz(&self.spectrum(w_i, w_o))
    }

    /// π times the mean of f over a detector that sees a cone of this half angle (rad) about `w_o`: reflectance relative to a
    /// perfect diffuser's.
    #[must_use]
    pub fn reflectance_factor(&self, w_i: DVec3, w_o: DVec3, half_angle: f64) -> Vec<f64> {
        // Directions on a sunflower of even density over the disc.
        const SEEDS: usize = 256;
        let (e1, e2) = w_o.any_orthonormal_pair();
        let sines: Vec<Vec<f64>> = (0..SEEDS)
            .into_par_iter()
            .map(|i| {
                let radius = libm::sin(half_angle) * ((i as f64 + 0.5) / SEEDS as f64).sqrt();
                let turn = PI * (3.0 - 5.0_f64.sqrt()) * i as f64;
                let aside = radius * (libm::cos(turn) * e1 + libm::sin(turn) * e2);
                self.spectrum(w_i, (aside + (1.0 - radius * radius).sqrt() * w_o).normalize())
            })
            .collect();
        (0..self.at.len()).map(|k| PI / SEEDS as f64 * sines.iter().map(|row| row[k]).sum::<f64>()).collect()
    }

    /// Where in the plane of azimuth 0 and 180° light of a wavelength leaves brightest, as sinθ_o along +x, between two sines: by
    /// steps, then by bisecting the brightest's neighbourhood.
    #[must_use]
    pub fn brightest(&self, wavelength_nm: f64, w_i: DVec3, between: [f64; 2]) -> f64 {
        let value = |x: f64| {
            over(DVec2::new(x, 0.0))
                .map_or(0.0, |w_o| self.amplitudes.value(&self.setup, wavelength_nm * 1e-3, w_i, w_o))
        };
        let (mut low, mut high) = (between[0], between[1]);
        const STEPS: usize = 400;
        loop {
            let step = (high - low) / STEPS as f64;
            let best = (0..=STEPS)
                .map(|i| low + step * i as f64)
                .map(|x| (x, value(x)))
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .map_or(low, |(x, _)| x);
            if step < 1e-7 {
                return best;
            }
            (low, high) = (best - 2.0 * step, best + 2.0 * step);
        }
    }
}

/// Luminances up to this, 1/sr or of a mirror's peak, are black: 3e-6 of what a white that scatters evenly has. What two
/// computations leave there is rounding.
const BLACK: f64 = 1e-6;

/// ΔE00 of two colours, both scaled so that the first has luminance 1, or the second where the first is black; 0 where both
/// are.
#[must_use]
pub fn delta_e(reference: [f64; 3], other: [f64; 3]) -> f64 {
    let white = if reference[1] > BLACK { reference[1] } else { other[1] };
    if white <= BLACK {
        return 0.0;
    }
    let scaled = |xyz: [f64; 3]| lab(xyz.map(|v| (v / white).max(0.0)), crate::spectrum::colour::D65_WHITE);
    delta_e_2000(scaled(reference), scaled(other))
}

/// How far tables are from the reference, over many directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableErrors {
    /// Pairs of directions that are bright enough to count.
    pub compared: usize,
    /// Largest |ΔY| over the reference's brightest Y.
    pub largest_of_peak: f64,
    /// Mean of |ΔY|/Y.
    pub mean: f64,
    /// Largest |ΔY|/Y.
    pub largest: f64,
    /// Mean ΔE00, see [`delta_e`].
    pub mean_delta_e: f64,
    /// Largest ΔE00.
    pub largest_delta_e: f64,
}

/// Tables against the reference for light from one direction, over a grid of so many places along the diameter of the
/// hemisphere's disc of direction cosines.
#[must_use]
pub fn table_errors(reference: &Reference, tables: &Tables, w_i: DVec3, places: usize) -> TableErrors {
    let pairs: Vec<[[f64; 3]; 2]> = (0..places * places)
        .into_par_iter()
        .filter_map(|i| {
            let at = |i: usize| (2.0 * i as f64 + 1.0) / places as f64 - 1.0;
            // At the horizon obliquity diverges.
            let w_o = over(DVec2::new(at(i % places), at(i / places))).filter(|w_o| w_o.z > 0.1)?;
            Some([reference.xyz(w_i, w_o), tables.xyz(w_i, w_o)])
        })
        .collect();
    let peak = pairs.iter().map(|[reference, _]| reference[1]).fold(0.0, f64::max);
    let seen: Vec<&[[f64; 3]; 2]> = pairs.iter().filter(|[r, _]| r[1] > SEEN * peak).collect();
    let count = seen.len().max(1) as f64;
    let largest = |of: &dyn Fn(&[[f64; 3]; 2]) -> f64| seen.iter().map(|pair| of(pair)).fold(0.0, f64::max);
    let mean = |of: &dyn Fn(&[[f64; 3]; 2]) -> f64| seen.iter().map(|pair| of(pair)).sum::<f64>() / count;
    let relative = |[r, t]: &[[f64; 3]; 2]| (t[1] - r[1]).abs() / r[1];
    let colours = |[r, t]: &[[f64; 3]; 2]| delta_e(*r, *t);
    TableErrors {
        compared: seen.len(),
        largest_of_peak: pairs.iter().map(|[r, t]| (t[1] - r[1]).abs()).fold(0.0, f64::max)
            / peak.max(1e-300),
        mean: mean(&relative),
        largest: largest(&relative),
        mean_delta_e: mean(&colours),
        largest_delta_e: largest(&colours),
    }
}

/// The period that the first order at grazing incidence tells, by the grating equation d = λ/(sinθ_i + sinθ_o), at each
/// wavelength: for each the brightest direction within ±20 % of the expected period's. Light comes from azimuth 0, 75° from the
/// normal.
///
/// # Errors
/// Interruption, a setup out of range.
pub fn recovered_periods(
    field: &Heightfield,
    setup: &Setup,
    expected_um: f64,
    at: &Wavelengths,
    progress: &dyn Progress,
) -> Result<Vec<f64>> {
    let w_i = direction(75.0, 0.0);
    let reference = Reference::new(field, setup, &Observer::default(), at, progress)?;
    Ok(at
        .nm()
        .par_iter()
        .map(|nm| {
            let sine = |period: f64| (nm * 1e-3 / period - w_i.x).clamp(-1.0, 1.0);
            let between = [sine(1.2 * expected_um), sine(0.8 * expected_um)];
            nm * 1e-3 / (w_i.x + reference.brightest(*nm, w_i, between))
        })
        .collect())
}

/// Polar angles over the plane of azimuths 0 (positive) and 180° (negative), in even steps.
#[must_use]
pub fn in_plane(steps: usize) -> Vec<f64> {
    (0..steps).map(|i| ((i as f64 + 0.5) / steps as f64 - 0.5) * 2.0 * FRAC_PI_2).collect()
}

/// Patches of a snake whose powers are averaged for a scene: scales differ, and one patch has speckles.
const PATCHES: u64 = 2;
/// Their heights along either side: as near as the shortest wavelength asks for, a number that transforms are fast for.
const PATCH_CELLS: usize = 768;

/// The fingers of a sample of which several patches are averaged.
fn fingers_of(sample: &str) -> Option<Fingers> {
    let fingers = match sample {
        "elaphe" => Fingers::ELAPHE,
        "xenopeltis" => Fingers::XENOPELTIS,
        _ => return None,
    };
    // White noise keeps its density over frequencies.
    let noise_um = fingers.noise_um * PATCH_CELLS as f64 / fingers.cells as f64;
    Some(Fingers { cells: PATCH_CELLS, noise_um, ..fingers })
}

/// For which wavelengths and through which window the powers of samples are.
fn of_samples() -> Result<(Wavelengths, Setup)> {
    let at = Wavelengths::new([Band::HUMAN.low_nm(), Band::HUMAN.high_nm()])?;
    Ok((at, Setup { place: Place::Anywhere, ..Setup::default() }))
}

/// Memory of a sample's powers, and what [`sample_powers`] takes at most at once, bytes; nothing where there is none of this name.
#[must_use]
pub fn foretell_sample(sample: &str, seed: u64) -> Option<[u64; 2]> {
    let (at, setup) = of_samples().ok()?;
    let (field, sums) = match fingers_of(sample) {
        Some(fingers) => (Heightfield::fingers(&fingers, hash(seed, &[0])).ok()?, 2),
        None => (Heightfield::sample(sample, seed)?.ok()?, 1),
    };
    let need = Builder::need(&field, &setup, TableGrid::USUAL, Series::Chebyshev, &at);
    let heights = size_of_val(field.height_um()) as u64;
    Some([need.powers, need.making + sums * need.powers + heights])
}

/// The powers of a built-in sample at the wavelengths of pictures, for snakes the mean of several patches.
///
/// # Errors
/// There is none of this name; interruption.
pub fn sample_powers(sample: &str, seed: u64, progress: &dyn Progress) -> Result<Powers> {
    let (at, setup) = of_samples()?;
    let powers = |field: Heightfield| {
        Amplitudes::new(&field, &setup, Reach::of(&setup, &at), Series::Chebyshev, progress)?.powers()
    };
    if let Some(fingers) = fingers_of(sample) {
        let patch = |patch: u64| powers(Heightfield::fingers(&fingers, hash(seed, &[patch]))?);
        return Powers::mean((0..PATCHES).map(patch));
    }
    match Heightfield::sample(sample, seed) {
        Some(field) => powers(field?),
        None => {
            let near = did_you_mean(sample, SAMPLES);
            Err(Error::input(format!(
                "there is no sample '{}'{near}; known are {}",
                shortened(sample),
                SAMPLES.join(", ")
            )))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Unobserved;
    use crate::scattering::grating::Normalization;

    #[test]
    fn gratings_tell_their_periods() {
        let at = Wavelengths::new([380.0, 500.0, 620.0, 780.0]).unwrap();
        for (sample, period) in [("blazed", 2.5), ("sinusoid", 2.5)] {
            let field = Heightfield::sample(sample, 1).unwrap().unwrap();
            let setup = Setup { normalization: Normalization::Relative, ..Setup::default() };
            for found in recovered_periods(&field, &setup, period, &at, &Unobserved).unwrap() {
                assert!((found - period).abs() < 5e-4, "{sample}: {found}");
            }
        }
    }

    /// Tables of a grating that is bright along one line, at its peak and beside it.
    #[test]
    fn errors_of_tables_are_those_of_their_grid() {
        let at = Wavelengths::new((0..81).map(|i| 380.0 + 5.0 * f64::from(i)).collect::<Vec<_>>()).unwrap();
        let field = Heightfield::sample("blazed", 1).unwrap().unwrap();
        let (setup, observer) = (Setup::default(), Observer::default());
        let reference = Reference::new(&field, &setup, &observer, &at, &Unobserved).unwrap();
        let errors = [101, 301].map(|size| {
            let grid = TableGrid { size, ..TableGrid::USUAL };
            let builder = Builder::new(&field, &setup, grid, Series::Chebyshev, &observer, &at, &Unobserved);
            table_errors(&reference, &builder.unwrap().tables(&Unobserved).unwrap(), DVec3::Z, 21)
        });
        assert!(errors[0].compared > 10 && errors[0].compared == errors[1].compared);
        let [coarse, fine] = errors.map(|e| e.largest_of_peak);
        assert!(fine < 0.02 && fine < 0.5 * coarse, "{errors:?}");
        assert!(errors[1].mean_delta_e < errors[0].mean_delta_e, "{errors:?}");
    }

    #[test]
    fn a_mirrors_reflectance_factor_is_its_reflectance_over_the_detectors_solid_angle() {
        let field = Heightfield::new([8, 8], [65.0; 2], vec![0.0; 64]).unwrap();
        let at = Wavelengths::new([550.0]).unwrap();
        let setup = Setup { place: Place::Anywhere, ..Setup::default() };
        let reference = Reference::new(&field, &setup, &Observer::default(), &at, &Unobserved).unwrap();
        let (w_i, w_o) = (direction(30.0, 0.0), direction(30.0, 180.0));
        // The whole lobe is seen: π R/(cosθ_o π sin²a).
        let half = 3.0_f64.to_radians();
        let found = reference.reflectance_factor(w_i, w_o, half)[0];
        let expected = crate::fresnel::fresnel(w_i.z, 1.5) / (w_o.z * half.sin().powi(2));
        assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
    }

    #[test]
    fn samples_are_offered_by_name() {
        let error = sample_powers("elafe", 1, &Unobserved).unwrap_err().to_string();
        assert!(error.contains("did you mean 'elaphe'"), "{error}");
    }
}
