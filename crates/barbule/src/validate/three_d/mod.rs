//! Whether invariance along y suffices: the 2.5D simulation and its BRDF against segments in three dimensions.
//!
//! Both simulate the same instances under the same light, in windows of a quarter of the width and of the length. What a
//! segment scatters off the cone, along y, is what the 2.5D side only assumes: the spread σ of its BRDF.

mod figures;
mod halo;
mod kept;
mod numbers;
mod options;

pub use halo::WithHalo;
pub use numbers::{Found, Moments, Sigma};
pub use options::SegmentOptions;

use rayon::prelude::*;

use crate::brdf::{FeatherBrdf, FeatherMaterial, Options, Values, values};
use crate::io::Units;
use crate::math::simd::Width;
use crate::progress::{Clock, OnlyStops, Progress};
use crate::scattering::directions::omega;
use crate::scattering::far_field::{FarField, Illumination, Polarization, Window};
use crate::solve::segment::{self, Hemisphere, SegmentAccuracy, SegmentLight};
use crate::solve::surface;
use crate::spectrum::{Wavelengths, wave_number_per_um};
use crate::structure::{Roughness, Segment, Structure};
use crate::{DVec3, Error, Result};
use kept::{Cell, Scattered};
use numbers::{Correlations, Tally};

/// Pixels across the pictures of hemispheres.
pub const PIXELS: usize = 161;

/// Azimuths of the 2.5D far fields.
const AZIMUTHS: usize = 1440;

/// What is compared.
#[derive(Debug, Clone)]
pub struct Plan {
    /// What both simulate.
    pub structure: Structure,
    /// Seed of instances and of their roughness.
    pub seed: u64,
    /// How many instances.
    pub instances: usize,
    /// Vacuum wavelengths.
    pub wavelengths: Wavelengths,
    /// θ_i and φ_i, rad.
    pub directions: Vec<[f64; 2]>,
    /// Length of the segments, µm.
    pub length_um: f64,
    /// Of their boundaries.
    pub roughness: Roughness,
    /// Largest turn of an instance about y, rad, as in campaigns.
    pub tilt: f64,
    /// The material of the structure, where it has one.
    pub material: Option<Box<FeatherMaterial>>,
    /// SIMD instructions that both are computed with, which decide roundings.
    pub width: Width,
    /// Times both.
    pub clock: Clock,
}

/// Both simulations of one structure.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// What was compared.
    pub plan: Plan,
    /// σ of the BRDF.
    pub sigma: f64,
    /// By direction and wavelength.
    pub found: Vec<Vec<Found>>,
    /// By direction.
    pub pictures: Vec<Pictures>,
    /// Wall time of both simulations.
    pub seconds: [f64; 2],
}

/// BRDF values over the hemisphere, `[wavelength][pixel]` from the lower left corner; 0 outside.
#[derive(Debug, Clone, Default)]
pub struct Pictures {
    /// The smooth BRDF and one instance of it; empty without a material.
    pub brdf: [Vec<Vec<f64>>; 2],
    /// The mean of the 2.5D simulations and one of them, each spread by σ.
    pub flat: [Vec<Vec<f64>>; 2],
    /// The mean of the segments and one of them.
    pub segments: [Vec<Vec<f64>>; 2],
}

impl Plan {
    fn light(&self, wavelength_nm: f64, [theta_i, phi_i]: [f64; 2], instance: usize) -> SegmentLight {
        let window_um = [0.25 * self.structure.width_um(), 0.25 * self.length_um];
        SegmentLight { wavelength_nm, theta_i, phi_i, window_um, turn: self.turn(instance) }
    }

    /// The turn of an instance: they are spread evenly.
    fn turn(&self, instance: usize) -> f64 {
        if self.instances < 2 {
            return 0.0;
        }
        (2.0 * instance as f64 / (self.instances - 1) as f64 - 1.0) * self.tilt
    }

    /// How segments are computed.
    fn accuracy(&self) -> SegmentAccuracy {
        SegmentAccuracy { width: self.width, ..SegmentAccuracy::default() }
    }

    /// An instance.
    fn segment(&self, index: usize) -> Result<Segment> {
        self.structure.segment(self.seed, index, self.length_um, self.roughness)
    }

    /// The cells of the largest far field, along x and y.
    ///
    /// # Errors
    /// A segment cannot be made, or cells do not suit the light.
    pub fn cells(&self) -> Result<[usize; 2]> {
        let shortest = self.wavelengths.nm().iter().copied().fold(f64::INFINITY, f64::min);
        let (segment, light) = (self.segment(0)?, self.light(shortest, self.directions[0], 0));
        Ok(segment::grid(&segment, &light, &self.accuracy())?.cells)
    }

    /// θ_i and φ_i of a direction, degrees, as they were meant.
    fn direction_deg(&self, direction: usize) -> [f64; 2] {
        self.directions[direction].map(|angle| (angle.to_degrees() * 1e9).round() / 1e9)
    }

    /// Far fields of segments in all.
    #[must_use]
    pub fn count(&self) -> usize {
        self.instances * self.wavelengths.len() * self.directions.len()
    }

    /// Runs both. The far field of each segment is kept as it comes, and those of all instances as one unit when they are there;
    /// what was kept is taken from there another time: to the same bits, times and all.
    ///
    /// # Errors
    /// As the solvers; a unit cannot be written; or the user cancelled.
    pub fn run(&self, units: Option<&Units>, progress: &dyn Progress) -> Result<Comparison> {
        let brdf = self.material.as_deref().map(|m| FeatherBrdf::new(m, Options::default())).transpose()?;
        let sigma = self.sigma();
        let instances = (0..self.instances).map(|index| self.segment(index)).collect::<Result<Vec<_>>>()?;
        progress.begin("segments", self.count() as u64);
        let wo = pixels();
        let (mut all_found, mut all_pictures, mut seconds) = (Vec::new(), Vec::new(), [0.0; 2]);
        for &direction in &self.directions {
            let (mut found, mut pictures) = (Vec::new(), Pictures::default());
            for &nm in self.wavelengths.nm() {
                let cell = match units.and_then(|units| self.kept_cell(units, direction, nm, sigma)) {
                    Some(cell) => {
                        progress.advance(self.instances as u64);
                        cell
                    }
                    None => self.one(direction, nm, sigma, &instances, &wo, units, progress)?,
                };
                seconds.iter_mut().zip(cell.seconds).for_each(|(sum, own)| *sum += own);
                found.push(cell.found);
                for (kind, pixels) in cell.flat.into_iter().enumerate() {
                    pictures.flat[kind].push(pixels);
                }
                for (kind, pixels) in cell.segments.into_iter().enumerate() {
                    pictures.segments[kind].push(pixels);
                }
            }
            if let Some(brdf) = &brdf {
                let wi = omega(direction[0], direction[1]);
                for (picture, instance) in pictures.brdf.iter_mut().zip([None, Some(0)]) {
                    *picture = over_hemisphere(brdf, self.wavelengths.nm(), wi, &wo, instance);
                }
            }
            all_found.push(found);
            all_pictures.push(pictures);
        }
        Ok(Comparison { plan: self.clone(), sigma, found: all_found, pictures: all_pictures, seconds })
    }

    /// Both simulations of all instances at one wavelength under light from one direction.
    fn one(
        &self,
        direction: [f64; 2],
        wavelength_nm: f64,
        sigma: f64,
        instances: &[Segment],
        wo: &[Option<DVec3>],
        units: Option<&Units>,
        progress: &dyn Progress,
    ) -> Result<Cell> {
        let k = wave_number_per_um(wavelength_nm);
        let begun = (self.clock)();
        let flats: Vec<FarField> = (0..instances.len())
            .into_par_iter()
            .map(|index| {
                let illumination = Illumination {
                    wavelength_nm,
                    theta_i: direction[0],
                    phi_i: direction[1] + self.turn(index),
                    window: Window::Gaussian,
                };
                let accuracy = surface::Accuracy { width: self.width, ..surface::Accuracy::default() };
                surface::far_field_observed(
                    &instances[index].section,
                    &illumination,
                    AZIMUTHS,
                    &accuracy,
                    &OnlyStops(progress),
                )
            })
            .collect::<Result<_>>()?;
        let mut cell = Cell::default();
        cell.seconds[0] = ((self.clock)() - begun).as_secs_f64();
        let flats: Vec<Vec<f64>> = flats.iter().map(per_radian).collect();
        let mut tally = None;
        let mut correlations = Correlations::new(direction[0]);
        let model = Spread::new(direction[0], sigma);
        for (index, segment) in instances.iter().enumerate() {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let light = self.light(wavelength_nm, direction, index);
            let Scattered { far, intensity, seconds } =
                self.scattered(segment, &light, index, units, progress)?;
            cell.seconds[1] += seconds;
            let sums = tally.get_or_insert_with(|| Tally::new(&far, direction[0], k, sigma));
            sums.add(&far, &intensity, &flats[index], light.turn);
            correlations.add(&far, &intensity, &flats[index], light.turn);
            let both = [
                rendered(wo, |w| model.value(&flats[index], light.turn, w)),
                rendered(wo, |w| at(&far, &intensity, w) / w.z),
            ];
            for (sums, pixels) in [&mut cell.flat, &mut cell.segments].into_iter().zip(both) {
                sums[0].resize(pixels.len(), 0.0);
                sums[0]
                    .iter_mut()
                    .zip(&pixels)
                    .for_each(|(sum, value)| *sum += value / instances.len() as f64);
                if index == 0 {
                    sums[1] = pixels;
                }
            }
            progress.advance(1);
        }
        let window_um = self.light(wavelength_nm, direction, 0).window_um;
        if let Some(tally) = tally {
            cell.found = tally.found(wavelength_nm, direction, window_um, &correlations);
        }
        if let Some(units) = units {
            self.keep_cell(units, direction, wavelength_nm, sigma, &cell)?;
        }
        Ok(cell)
    }
}

/// σ where no material says another.
const USUAL_SIGMA: f64 = 0.04;

/// The part of unpolarized light that leaves over the azimuths, 1/rad.
fn per_radian(far: &FarField) -> Vec<f64> {
    let [a, b] = Polarization::BOTH.map(|p| far.per_radian(p));
    a.iter().zip(&b).map(|(a, b)| 0.5 * far.theta_i.cos() * (a + b)).collect()
}

/// The directions of the pictures' pixels, row by row from below; `None` outside.
fn pixels() -> Vec<Option<DVec3>> {
    let centre = |k: usize| (2 * k + 1) as f64 / PIXELS as f64 - 1.0;
    (0..PIXELS * PIXELS)
        .map(|at| {
            let (x, y) = (centre(at % PIXELS), centre(at / PIXELS));
            let up = 1.0 - x * x - y * y;
            (up > 0.0).then(|| DVec3::new(x, y, up.sqrt()))
        })
        .collect()
}

fn rendered(wo: &[Option<DVec3>], value: impl Fn(DVec3) -> f64 + Sync) -> Vec<f64> {
    wo.par_iter().map(|w| w.map_or(0.0, &value)).collect()
}

/// f of a BRDF, `[wavelength][pixel]`.
fn over_hemisphere(
    brdf: &FeatherBrdf,
    nm: &[f64],
    wi: DVec3,
    wo: &[Option<DVec3>],
    instance: Option<u64>,
) -> Vec<Vec<f64>> {
    let inside: Vec<DVec3> = wo.iter().flatten().copied().collect();
    let spread = |row: Vec<Values>| {
        let mut row = row.into_iter();
        wo.iter().map(|w| w.and_then(|_| row.next()).map_or(0.0, |value| value.f)).collect()
    };
    values(brdf, nm, wi, &inside, instance).into_iter().map(spread).collect()
}

/// The intensity of a segment towards a direction, between the directions of its grid.
fn at(far: &Hemisphere, intensity: &[f64], w_o: DVec3) -> f64 {
    let x = w_o.x / far.step[0] + far.reach as f64;
    let y = (w_o.y - far.omega_y[0]) / far.step[1];
    let (column, row) = (x.floor(), y.floor());
    let (s, t) = (x - column, y - row);
    let read = |column: f64, row: f64| {
        let is_there =
            (0.0..far.columns() as f64).contains(&column) && (0.0..far.omega_y.len() as f64).contains(&row);
        if is_there { intensity[row as usize * far.columns() + column as usize] } else { 0.0 }
    };
    (1.0 - t) * ((1.0 - s) * read(column, row) + s * read(column + 1.0, row))
        + t * ((1.0 - s) * read(column, row + 1.0) + s * read(column + 1.0, row + 1.0))
}

/// A 2.5D far field (over its azimuths) between two of them; 0 beyond the horizon.
fn between(flat: &[f64], phi: f64) -> f64 {
    let place = (phi / std::f64::consts::PI + 0.5) * flat.len() as f64 - 0.5;
    let (left, part) = (place.floor(), place - place.floor());
    let read = |at: f64| if (0.0..flat.len() as f64).contains(&at) { flat[at as usize] } else { 0.0 };
    (1.0 - part) * read(left) + part * read(left + 1.0)
}

/// The BRDF's model of the spread along y: exp(−t²/σ²), t = sin((θ_i + θ_o)/2).
struct Spread {
    theta_i: f64,
    sigma: f64,
    /// ∫ exp(−t²/σ²) cosθ_o dθ_o
    whole: f64,
}

impl Spread {
    fn new(theta_i: f64, sigma: f64) -> Self {
        let mut spread = Self { theta_i, sigma, whole: 1.0 };
        let steps = 4000;
        let step = std::f64::consts::PI / f64::from(steps);
        let theta = |i: i32| (f64::from(i) + 0.5) * step - std::f64::consts::FRAC_PI_2;
        spread.whole = (0..steps).map(|i| spread.along(theta(i)) * theta(i).cos() * step).sum();
        spread
    }

    fn along(&self, theta_o: f64) -> f64 {
        (-((0.5 * (self.theta_i + theta_o)).sin() / self.sigma).powi(2)).exp()
    }

    /// f of a 2.5D far field (1/rad over its azimuths) of an instance turned by `turn`.
    fn value(&self, flat: &[f64], turn: f64, w_o: DVec3) -> f64 {
        let across = between(flat, w_o.x.atan2(w_o.z) + turn);
        across * self.along(w_o.y.asin()) / (self.whole * w_o.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ f (z·ω_o) dω_o over the hemisphere is the 2.5D far field's power, whatever σ.
    #[test]
    fn spreading_a_far_field_keeps_its_power() {
        let flat: Vec<f64> =
            (0..720).map(|n| 0.2 * (-((f64::from(n) - 400.0) / 60.0).powi(2)).exp()).collect();
        let power: f64 = flat.iter().sum::<f64>() * std::f64::consts::PI / 720.0;
        for (theta, sigma) in [(0.0, 0.04), (0.5, 0.08)] {
            let spread = Spread::new(theta, sigma);
            let steps = 600;
            let step = std::f64::consts::PI / f64::from(steps);
            let angle = |i: i32| (f64::from(i) + 0.5) * step - std::f64::consts::FRAC_PI_2;
            let mut sum = 0.0;
            for i in 0..steps {
                for j in 0..steps {
                    let w = omega(angle(i), angle(j));
                    sum += spread.value(&flat, 0.0, w) * w.z * angle(i).cos() * step * step;
                }
            }
            assert!((sum / power - 1.0).abs() < 2e-3, "{theta} {sigma}: {sum} {power}");
        }
    }

    #[test]
    fn a_grids_intensities_are_read_between_its_directions() {
        let far = Hemisphere {
            step: [0.1, 0.2],
            reach: 9,
            omega_y: (0..9).map(|row| 0.2 * f64::from(row) - 0.8).collect(),
            amplitudes: Default::default(),
            incident_um2: 1.0,
        };
        let plane = |x: f64, y: f64| 2.0 + 0.5 * x - 0.3 * y;
        let intensity: Vec<f64> = far
            .omega_y
            .iter()
            .flat_map(|&y| (0..far.columns()).map(move |column| (column, y)))
            .map(|(column, y)| plane(far.omega_x(column), y))
            .collect();
        for (x, y) in [(0.0, 0.0), (0.33, -0.41), (-0.57, 0.63)] {
            let w = DVec3::new(x, y, (1.0_f64 - x * x - y * y).sqrt());
            assert!((at(&far, &intensity, w) - plane(x, y)).abs() < 1e-12);
        }
    }
}
