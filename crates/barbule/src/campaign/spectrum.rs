//! Reflectance spectra of a structure: mean and spread over instances.

use num_complex::Complex;
use rayon::prelude::*;

use crate::math::simd::Width;
use crate::progress::Progress;
use crate::scattering::orders::OrderTable;
use crate::scattering::statistics::AZIMUTHS;
use crate::solve::crystal::{Multipole, order_table};
use crate::solve::surface::{
    Cone, CrystalOrders, Nodes, Stacks, Surface, Window, Workspace, inverse_root, refinement,
};
use crate::structure::{Lattice, Structure};
use crate::{Error, Result};

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
    /// Vacuum wavelengths, nm.
    pub wavelengths_nm: Vec<f64>,
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
}

/// Simulates the spectra; instances in parallel, none tilted.
///
/// # Errors
/// An instance cannot be made, a table does not reach a wavelength, or the observer cancelled.
pub fn spectra(
    structure: &Structure,
    request: &SpectrumRequest,
    width: Width,
    observer: &dyn Progress,
) -> Result<Spectra> {
    let crystal = structure.lattice().map(|lattice| crystal(&lattice, request, observer)).transpose()?;
    observer.begin("simulating", (request.instances * request.wavelengths_nm.len()) as u64);
    let per_instance = (0..request.instances)
        .into_par_iter()
        .map(|instance| of_instance(structure, request, crystal.as_ref(), instance, width, observer))
        .collect::<Result<Vec<_>>>()?;
    let count = request.instances as f64;
    let mut spectra = Spectra { mean: Vec::new(), std: Vec::new() };
    let columns = request.wavelengths_nm.len();
    for direction in 0..request.directions.len() {
        let values =
            |wavelength: usize| per_instance.iter().map(move |v| v[direction * columns + wavelength]);
        let mean: Vec<f64> = (0..columns).map(|w| values(w).sum::<f64>() / count).collect();
        let std = (0..columns)
            .map(|w| (values(w).map(|v| (v - mean[w]).powi(2)).sum::<f64>() / (count - 1.0).max(1.0)).sqrt())
            .collect();
        spectra.mean.push(mean);
        spectra.std.push(std);
    }
    Ok(spectra)
}

/// A crystal's orders at the request's wavelengths and θ_i, and its depth.
struct Crystal {
    table: OrderTable,
    depth_um: f64,
}

fn crystal(lattice: &Lattice, request: &SpectrumRequest, observer: &dyn Progress) -> Result<Crystal> {
    let mut cos_theta: Vec<f64> = request.directions.iter().map(|d| d.0.cos()).collect();
    cos_theta.sort_by(f64::total_cmp);
    cos_theta.dedup();
    let table = order_table(&Multipole::default(), lattice, &request.wavelengths_nm, &cos_theta, observer)?;
    Ok(Crystal { table, depth_um: lattice.bottom_um() })
}

impl Crystal {
    /// The orders at a wavelength by its number and a θ_i of the request, rad.
    fn at(&self, wavelength: usize, theta_i: f64) -> CrystalOrders<f32> {
        let theta = self.table.cos_theta.partition_point(|&c| c < theta_i.cos());
        CrystalOrders::new(self.table.at(wavelength, theta), theta_i, self.depth_um)
    }
}

/// Longest quadrature element, µm: reflected fractions of means over instances are then good to 1e-3.
const ELEMENT_UM: f64 = 0.02;

/// Reflected fractions of one instance, `[direction][wavelength]`.
fn of_instance(
    structure: &Structure,
    request: &SpectrumRequest,
    crystal: Option<&Crystal>,
    instance: usize,
    width: Width,
    observer: &dyn Progress,
) -> Result<Vec<f64>> {
    let section = structure.instance(request.seed, instance)?;
    let surface = Surface::new(&section, ELEMENT_UM, Window::Gaussian)?;
    let columns = request.wavelengths_nm.len();
    let mut result = vec![0.0; request.directions.len() * columns];
    let mut workspace = Workspace::<f32>::new(width);
    let (mut coefficients, mut circle, mut scratch) = (Vec::new(), Vec::new(), Vec::new());
    for (column, &wavelength_nm) in request.wavelengths_nm.iter().enumerate() {
        if observer.is_cancelled() {
            return Err(Error::interrupted());
        }
        let optics = surface.optics(wavelength_nm)?;
        let mut start = 0;
        while start < request.directions.len() {
            // Directions of the same θ_i share a cone.
            let theta_i = request.directions[start].0;
            let run = request.directions[start..].iter().take_while(|d| d.0 == theta_i).count();
            let phis: Vec<f64> = request.directions[start..start + run].iter().map(|d| d.1).collect();
            let cone = Cone::new(optics.k, theta_i, surface.radius_um);
            let nodes = Nodes::equidistant(&surface, cone.kappa);
            let scales: Vec<f64> =
                phis.iter().map(|&phi| inverse_root(surface.incident_power_um(theta_i, phi))).collect();
            match crystal.map(|crystal| crystal.at(column, theta_i)) {
                Some(orders) => {
                    workspace.far_fields(&surface, &orders, &nodes, &cone, &phis, &scales, &mut coefficients)
                }
                None => {
                    let stacks = Stacks(&optics);
                    workspace.far_fields(&surface, &stacks, &nodes, &cone, &phis, &scales, &mut coefficients);
                }
            }
            let synthesis = workspace.synthesis(&cone, AZIMUTHS * refinement(&cone, AZIMUTHS), 0);
            let mut values = vec![Complex::new(0f32, 0.0); synthesis.points()];
            for (index, component) in coefficients.chunks_exact(cone.angles).enumerate() {
                let (direction, polarization) = (index / 4, index / 2 % 2);
                synthesis.evaluate(component, 0.0, &mut circle, &mut scratch, &mut values);
                let collected = collected(&values, request.collect, theta_i, phis[direction]);
                result[(start + direction) * columns + column] +=
                    request.polarization[polarization] * theta_i.cos() * collected;
            }
            start += run;
        }
        observer.advance(1);
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
