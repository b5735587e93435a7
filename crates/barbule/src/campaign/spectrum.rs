//! Reflectance spectra of a structure: mean and spread over instances; all that is reflected, or what instruments read.

mod mount;
mod reading;

use num_complex::Complex;
use rayon::prelude::*;

use super::crystal::Crystal;
use crate::math::simd::Width;
use crate::progress::Progress;
use crate::scattering::far_field::{IncidentLight, Window};
use crate::scattering::statistics::AZIMUTHS;
use crate::solve::surface::{
    self, Barbule, Batch, Cone, Grid, LARGEST_MIRROR_ERROR, Workspace, mirror_fraction,
};
use crate::spectrum::Wavelengths;
use crate::structure::{Lattice, Structure};
use crate::{Error, Result};

#[cfg(test)]
pub(crate) use mount::Beam;
pub(crate) use mount::{Lobes, Tilted};
pub use mount::{Mount, Vane};
pub use reading::{ReadingRequest, reading_bytes, readings_and_individuals};

/// Which part of the reflected light a spectrum collects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Collect {
    /// All of it.
    Hemisphere,
    /// What falls within this angle of the mirror direction, rad.
    Cone(f64),
}

/// What a spectrum is asked of.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectrumRequest {
    /// Vacuum wavelengths.
    pub wavelengths: Wavelengths,
    /// Incident directions (θ_i, φ_i), rad.
    pub directions: Vec<(f64, f64)>,
    /// Number of instances.
    pub instances: usize,
    /// Seed of the instances.
    pub seed: u64,
    /// What is collected.
    pub collect: Collect,
    /// Weights of the two incident polarizations; they sum to 1.
    pub polarization: [f64; 2],
}

/// Mean and standard deviation over instances, `[direction][wavelength]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectra {
    /// Mean reflected fraction.
    pub mean: Vec<Vec<f64>>,
    /// Standard deviation of the reflected fraction; 0 for a single instance.
    pub std: Vec<Vec<f64>>,
    /// What a flat perfect mirror as wide would reflect in all by the same formulas: how far off they are there.
    pub mirror: Vec<Vec<f64>>,
    /// Whether the values are readings beside a white diffuser, which may exceed 1, rather than parts of the light.
    pub beside_white: bool,
}

/// Reflected power near grazing incidence, where the simulation makes a perfect mirror reflect what it does not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grazing {
    /// Number of the direction that is furthest off.
    pub direction: usize,
    /// Number of the wavelength there.
    pub wavelength: usize,
    /// What the mirror reflects there.
    pub mirror_fraction: f64,
    /// Values that are off by more than [`LARGEST_MIRROR_ERROR`].
    pub flagged: usize,
}

/// A reflected fraction over all light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Over {
    /// Number of the direction of the largest.
    pub direction: usize,
    /// Number of its wavelength.
    pub wavelength: usize,
    /// The largest.
    pub reflected: f64,
    /// How many there are.
    pub count: usize,
}

/// What a reflected fraction may be: all light, and a sum's rounding in single precision.
const ALL_LIGHT: f64 = 1.0 + 1e-5;

impl Spectra {
    /// Whether the simulation is off by more than [`LARGEST_MIRROR_ERROR`], or reflects more than all light, `[direction][wavelength]`.
    #[must_use]
    pub fn flagged(&self) -> Vec<Vec<bool>> {
        let off = |mirror: &f64| (mirror - 1.0).abs() > LARGEST_MIRROR_ERROR;
        let over = |reflected: &f64| !self.beside_white && *reflected > ALL_LIGHT;
        let rows = self.mirror.iter().zip(&self.mean);
        rows.map(|(mirror, mean)| mirror.iter().zip(mean).map(|(m, r)| off(m) || over(r)).collect()).collect()
    }

    /// Where the simulation reflects more than all light though a mirror would reflect what it should: the largest such value, and
    /// how many there are.
    #[must_use]
    pub fn over(&self) -> Option<Over> {
        if self.beside_white {
            return None;
        }
        let mut found: Option<Over> = None;
        for (direction, (mirror, mean)) in self.mirror.iter().zip(&self.mean).enumerate() {
            for (wavelength, (mirror, reflected)) in mirror.iter().zip(mean).enumerate() {
                if *reflected <= ALL_LIGHT || (mirror - 1.0).abs() > LARGEST_MIRROR_ERROR {
                    continue;
                }
                let count = found.map_or(0, |over| over.count) + 1;
                let largest = found.filter(|over| over.reflected >= *reflected);
                let here = Over { direction, wavelength, reflected: *reflected, count };
                found = Some(largest.map_or(here, |over| Over { count, ..over }));
            }
        }
        found
    }

    /// Where the simulation is furthest off; `None` where it holds everywhere.
    #[must_use]
    pub fn grazing(&self) -> Option<Grazing> {
        let off = |mirror: f64| (mirror - 1.0).abs();
        let values = self.mirror.iter().enumerate().flat_map(|(direction, row)| {
            row.iter().enumerate().map(move |(wavelength, mirror)| (direction, wavelength, *mirror))
        });
        let flagged: Vec<_> = values.filter(|(.., mirror)| off(*mirror) > LARGEST_MIRROR_ERROR).collect();
        let (direction, wavelength, mirror_fraction) =
            flagged.iter().copied().max_by(|a, b| off(a.2).total_cmp(&off(b.2)))?;
        Some(Grazing { direction, wavelength, mirror_fraction, flagged: flagged.len() })
    }
}

/// The reflected fraction of each instance.
#[derive(Debug, Clone, PartialEq)]
pub struct Individuals {
    /// `[instance][direction · wavelength]`.
    fractions: Vec<Vec<f64>>,
    wavelengths: usize,
}

impl Individuals {
    /// How many instances there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.fractions.len()
    }

    /// The reflected fractions of one instance at one direction, one for each wavelength.
    ///
    /// # Panics
    /// There is no such instance or direction.
    #[must_use]
    pub fn of(&self, instance: usize, direction: usize) -> &[f64] {
        &self.fractions[instance][direction * self.wavelengths..][..self.wavelengths]
    }
}

/// Simulates the spectra; instances in parallel, none tilted.
///
/// # Errors
/// An instance cannot be made, a table does not reach a wavelength, or the user cancelled.
pub fn spectra(structure: &Structure, request: &SpectrumRequest, progress: &dyn Progress) -> Result<Spectra> {
    Ok(spectra_and_individuals(structure, request, progress)?.0)
}

/// The same with these SIMD instructions, on which roundings depend: machines that share work use the same.
///
/// # Errors
/// As [`spectra`].
pub fn spectra_by(
    width: Width,
    structure: &Structure,
    request: &SpectrumRequest,
    progress: &dyn Progress,
) -> Result<Spectra> {
    Ok(with_individuals(width, structure, request, progress)?.0)
}

/// The same with the instances one by one.
///
/// # Errors
/// As [`spectra`].
pub fn spectra_and_individuals(
    structure: &Structure,
    request: &SpectrumRequest,
    progress: &dyn Progress,
) -> Result<(Spectra, Individuals)> {
    with_individuals(Width::best(), structure, request, progress)
}

fn with_individuals(
    width: Width,
    structure: &Structure,
    request: &SpectrumRequest,
    progress: &dyn Progress,
) -> Result<(Spectra, Individuals)> {
    let columns = request.wavelengths.len();
    let individuals =
        Individuals { fractions: fractions(width, structure, request, progress)?, wavelengths: columns };
    let (mean, std) = moments(&individuals, request.directions.len());
    let mirror = request.directions.iter().map(|&(theta_i, phi_i)| {
        let of_mirror = |&nm: &f64| mirror_fraction(structure.width_um(), nm, theta_i, phi_i);
        request.wavelengths.iter().map(of_mirror).collect()
    });
    Ok((Spectra { mean, std, mirror: mirror.collect(), beside_white: false }, individuals))
}

/// Mean and standard deviation over the instances, `[direction][wavelength]`.
fn moments(individuals: &Individuals, directions: usize) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let (columns, count) = (individuals.wavelengths, individuals.count() as f64);
    let of = |direction: usize| {
        let values = |wavelength: usize| {
            individuals.fractions.iter().map(move |v| v[direction * columns + wavelength])
        };
        let mean: Vec<f64> = (0..columns).map(|w| values(w).sum::<f64>() / count).collect();
        let std = (0..columns)
            .map(|w| (values(w).map(|v| (v - mean[w]).powi(2)).sum::<f64>() / (count - 1.0).max(1.0)).sqrt())
            .collect();
        (mean, std)
    };
    (0..directions).map(of).unzip()
}

/// Reflected fractions, `[instance][direction · wavelength]`; instances in parallel.
fn fractions(
    width: Width,
    structure: &Structure,
    request: &SpectrumRequest,
    progress: &dyn Progress,
) -> Result<Vec<Vec<f64>>> {
    let crystal = structure.lattice().map(|lattice| crystal(&lattice, request, progress)).transpose()?;
    progress.begin("simulating", (request.instances * request.wavelengths.len()) as u64);
    (0..request.instances)
        .into_par_iter()
        .map(|instance| of_instance(width, structure, request, crystal.as_ref(), instance, progress))
        .collect()
}

/// A crystal's orders at the request's wavelengths and θ_i.
fn crystal(lattice: &Lattice, request: &SpectrumRequest, progress: &dyn Progress) -> Result<Crystal> {
    let mut cos_theta: Vec<f64> = request.directions.iter().map(|d| d.0.cos()).collect();
    cos_theta.sort_by(f64::total_cmp);
    cos_theta.dedup();
    Ok(Crystal::of(surface::orders(lattice, &request.wavelengths, &cos_theta, progress)?, lattice))
}

/// The light on a barbule: an arch shows its colours from edge to edge only where it is lit from edge to edge; what is flat is alike
/// everywhere.
pub(super) fn window(structure: &Structure) -> Window {
    if structure.is_curved() { Window::PlaneWave } else { Window::Gaussian }
}

/// Longest quadrature element, µm: reflected fractions of means over instances are then good to 1e-3.
pub(super) const ELEMENT_UM: f64 = 0.02;

/// Directions of one θ_i that are lit together, at most.
pub(super) const DIRECTIONS_AT_ONCE: usize = 256;

/// Reflected fractions of one instance, `[direction · wavelength]`.
fn of_instance(
    width: Width,
    structure: &Structure,
    request: &SpectrumRequest,
    crystal: Option<&Crystal>,
    instance: usize,
    progress: &dyn Progress,
) -> Result<Vec<f64>> {
    let section = structure.instance(request.seed, instance)?;
    let barbule = Barbule::new(&section, ELEMENT_UM, window(structure))?;
    let columns = request.wavelengths.len();
    let mut result = vec![0.0; request.directions.len() * columns];
    let mut workspace = Workspace::new(width);
    for (column, &wavelength_nm) in request.wavelengths.iter().enumerate() {
        if progress.is_cancelled() {
            return Err(Error::interrupted());
        }
        let stacks = barbule.stacks(wavelength_nm)?;
        let mut start = 0;
        while start < request.directions.len() {
            // Directions of the same θ_i share a cone.
            let theta_i = request.directions[start].0;
            let same = request.directions[start..].iter().take(DIRECTIONS_AT_ONCE);
            let run = same.take_while(|d| d.0 == theta_i).count();
            let phis: Vec<f64> = request.directions[start..start + run].iter().map(|d| d.1).collect();
            let cone = Cone::around(std::slice::from_ref(&barbule), wavelength_nm, theta_i);
            let beam = |&phi: &f64| IncidentLight::Beam { power_um: barbule.incident_power_um(theta_i, phi) };
            let lights: Vec<IncidentLight> = phis.iter().map(beam).collect();
            let batch = Batch { cone: &cone, phi_i: &phis, lights: &lights };
            let grid = Grid { azimuths: AZIMUTHS * cone.refinement(AZIMUTHS), margin: 0, shift: 0.0 };
            let orders = crystal.map(|crystal| {
                let theta = crystal.orders.cos_theta.partition_point(|&c| c < theta_i.cos());
                crystal.underside(column, theta, theta_i)
            });
            let underside = orders.as_ref().unwrap_or(&stacks);
            let fields = workspace.scatter(&barbule, underside, &batch, grid, progress)?;
            for (index, component) in fields.chunks_exact(grid.points()).enumerate() {
                let (direction, polarization) = (index / 4, index / 2 % 2);
                let collected = collected(component, request.collect, theta_i, phis[direction]);
                result[(start + direction) * columns + column] +=
                    request.polarization[polarization] * theta_i.cos() * collected;
            }
            start += run;
        }
        progress.advance(1);
    }
    Ok(result)
}

/// ∫|E|² dφ_o over what is collected, by the midpoint rule with partial cells at the ends.
fn collected(values: &[Complex<f32>], collect: Collect, theta_i: f64, phi_i: f64) -> f64 {
    let step = std::f64::consts::PI / values.len() as f64;
    let (from, to) = match collect {
        Collect::Hemisphere => (f64::NEG_INFINITY, f64::INFINITY),
        Collect::Cone(half) => {
            // ω_o·ω_mirror = cos²θ cos(φ_o + φ_i) + sin²θ on the specular cone.
            let (sin, cos) = theta_i.sin_cos();
            let reach = ((half.cos() - sin * sin) / (cos * cos)).clamp(-1.0, 1.0).acos();
            (-phi_i - reach, -phi_i + reach)
        }
    };
    values
        .iter()
        .enumerate()
        .map(|(n, value)| {
            let left = n as f64 * step - std::f64::consts::FRAC_PI_2;
            let part = ((left + step).min(to) - left.max(from)).max(0.0);
            f64::from(value.norm_sqr()) * part
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_all_light_is_flagged_where_no_grazing_light_explains_it() {
        let spectra = Spectra {
            mean: vec![vec![0.4, 1.2, 0.9], vec![1.5, 1.3, 1.0]],
            std: vec![vec![0.0; 3]; 2],
            mirror: vec![vec![1.0, 1.0, 1.0], vec![2.0, 1.01, 1.0]],
            beside_white: false,
        };
        assert_eq!(spectra.flagged(), [[false, true, false], [true, true, false]]);
        assert_eq!(spectra.over(), Some(Over { direction: 1, wavelength: 1, reflected: 1.3, count: 2 }));
        let passive = Spectra { mean: vec![vec![1.0; 3]; 2], ..spectra };
        assert_eq!(passive.over(), None);
    }
}
