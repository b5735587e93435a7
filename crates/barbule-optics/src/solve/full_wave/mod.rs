//! Full waves on a section of closed regions: what the fast simulation is judged by.
//!
//! Maxwell's equations for fields ∝ e^{jk_y y}, exact up to discretization: in each region fields follow from those on its
//! boundaries (S.53), and Müller's combination of the two sides of each boundary, ε and μ as weights, leaves equations of the
//! second kind whose kernels are at most logarithmic. They are solved at the nodes of Gauss–Legendre panels (Nyström's method);
//! near panels are integrated with the kernel's own behaviour. The theory page on full waves derives it.

mod green;
mod incidence;
mod kernel;
mod mesh;
mod near;
mod operator;
mod outgoing;
mod shape;
#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::f64::consts::{FRAC_PI_4, PI};

use super::beam;
use super::cost::Cost;
use super::far_fields::{Effort, Exact, Illuminations, Prepared, Scattered, SectionSolver, Settings};
use crate::math::dense::Dense;
use crate::math::hierarchical::HierarchicalFactors;
use crate::math::large::LargeFactors;
use crate::progress::{Clock, Progress};
use crate::scattering::directions::{e1, e2};
use crate::scattering::far_field::{
    Azimuths, FarField, Illumination, IncidentLight, Polarization, Window, coefficients,
};
use crate::structure::{Beneath, Ends, Section};
use crate::{Complex64, Error, Result};
use incidence::Incidence;
use kernel::{COMPONENTS, Kernel};
use mesh::Mesh;
use operator::{Coupled, Operator, Weighted};
use outgoing::{Fields, absorbed_um, radiate};

pub use crate::solve::far_fields::{ELEMENTS, ELEMENTS_PER_WAVELENGTH};

/// Bytes of a complex number.
const COMPLEX: u64 = size_of::<Complex64>() as u64;

/// Equations up to which all elements are kept.
const MOST_DENSE: usize = 1500;

/// What far blocks may be off by, where the equations' diagonal is 1.
const TOLERANCE: f64 = 1e-5;

/// What thin products take by nodes and components, fitted to starlings from 5 to 25 µm: CPU seconds, and bytes at most at
/// once, of which about two thirds are the factors and the rest the crosses that these are made from.
const THIN_SECONDS: f64 = 4.3e-6;
const THIN_SECONDS_POWER: f64 = 1.48;
const THIN_BYTES: f64 = 270.0;
const THIN_BYTES_POWER: f64 = 1.44;

/// Bytes of the near panels of a node.
const NEAR_BYTES: u64 = 8192;

/// At how many nodes solutions by thin products are put into the equations, and by how much they may miss them, as a part of
/// the largest right side.
const SAMPLES: usize = 200;
const MOST_RESIDUAL: f64 = 1e-3;

/// Operations per second and core that predictions of time suppose.
const OPERATIONS_PER_SECOND: f64 = 4e10;

/// A section at one wavelength and θ_i, ready to be solved.
pub struct Problem<'a> {
    section: &'a Section,
    mesh: Mesh,
    wavelength_nm: f64,
    theta_i: f64,
    elements_per_wavelength: f64,
    method: Method,
    memory_bytes: u64,
}

/// How the equations are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// By LU factors of the whole matrix: time grows with the cube of the unknowns, memory with their square.
    Dense,
    /// By factors whose far blocks are thin products ([`HierarchicalFactors`]).
    Hierarchical,
}

/// Full waves as a solver of sections, which it closes; its far fields are over the full circle.
#[derive(Debug, Clone, Copy)]
pub struct FullWave {
    /// Nodes per wavelength in the denser of the media at each boundary.
    pub elements_per_wavelength: f64,
    /// Given up where thin products would take more, bytes.
    pub memory_bytes: u64,
    /// Times it.
    pub clock: Clock,
}

/// A section whose regions are closed.
struct Regions<'a> {
    section: Cow<'a, Section>,
    changes: Vec<String>,
    solver: FullWave,
}

impl FullWave {
    /// With what concerns it of the settings.
    #[must_use]
    pub fn new(settings: &Settings) -> Self {
        let Settings { elements_per_wavelength, memory_bytes, clock } = *settings;
        Self { elements_per_wavelength, memory_bytes, clock }
    }
}

impl SectionSolver for FullWave {
    fn prepare<'a>(&self, section: &'a Section) -> Result<Box<dyn Prepared + 'a>> {
        let is_closed = section.boundaries.is_empty();
        let (section, changes) = if is_closed {
            (Cow::Borrowed(section), Vec::new())
        } else {
            let closed = section.closed(Beneath::Absorbing, Ends::Closed)?;
            (Cow::Owned(closed.regions), closed.changes)
        };
        Ok(Box::new(Regions { section, changes, solver: *self }))
    }
}

impl Regions<'_> {
    /// What light of each wavelength and θ_i asks for, which shares one solution.
    fn problems(&self, light: &Illuminations) -> impl Iterator<Item = Result<Problem<'_>>> {
        let FullWave { elements_per_wavelength, memory_bytes, .. } = self.solver;
        light.wavelengths_nm.iter().flat_map(move |&wavelength_nm| {
            light.theta_i.iter().map(move |&theta_i| {
                let problem = Problem::new(&self.section, wavelength_nm, theta_i, elements_per_wavelength)?;
                Ok(problem.within(memory_bytes))
            })
        })
    }
}

impl Prepared for Regions<'_> {
    fn changes(&self) -> &[String] {
        &self.changes
    }

    fn cost(
        &self,
        light: &Illuminations,
        _azimuths: usize,
        threads: usize,
        progress: &dyn Progress,
    ) -> Result<Cost> {
        progress.begin("sizes of the equations", (light.wavelengths_nm.len() * light.theta_i.len()) as u64);
        self.problems(light).try_fold(Cost::default(), |all, problem| {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            let cost = problem?.cost(threads);
            progress.advance(1);
            Ok(all.then(cost))
        })
    }

    fn scatter(
        &self,
        light: &Illuminations,
        azimuths: usize,
        progress: &dyn Progress,
    ) -> Result<Vec<Scattered>> {
        let mut all = Vec::with_capacity(light.count());
        for problem in self.problems(light) {
            all.extend(problem?.solve(&light.phi_i, light.window, azimuths, self.solver.clock, progress)?);
        }
        Ok(all)
    }
}

impl<'a> Problem<'a> {
    /// A section of closed regions under light of `wavelength_nm` and longitudinal angle `theta_i` (rad).
    ///
    /// # Errors
    /// Open boundaries or a crystal, media that vary inside a region, circles that touch other curves, or an index that is
    /// not known at the wavelength.
    pub fn new(
        section: &'a Section,
        wavelength_nm: f64,
        theta_i: f64,
        elements_per_wavelength: f64,
    ) -> Result<Self> {
        let mesh = Mesh::new(section, wavelength_nm, elements_per_wavelength)?;
        let rows = mesh.nodes.len() * if theta_i == 0.0 { 2 } else { 4 };
        let method = if rows <= MOST_DENSE { Method::Dense } else { Method::Hierarchical };
        Ok(Self {
            section,
            mesh,
            wavelength_nm,
            theta_i,
            elements_per_wavelength,
            method,
            memory_bytes: u64::MAX,
        })
    }

    /// The same problem, solved in this way; without, small problems are solved densely.
    #[must_use]
    pub fn by(self, method: Method) -> Self {
        Self { method, ..self }
    }

    /// The same problem, given up where thin products would take more than so many bytes.
    #[must_use]
    pub fn within(self, memory_bytes: u64) -> Self {
        Self { memory_bytes, ..self }
    }

    /// What it will take on so many threads.
    #[must_use]
    pub fn cost(&self, threads: usize) -> Cost {
        let nodes = self.mesh.nodes.len();
        let systems = self.systems();
        let components = systems[0].0.components().len() as f64;
        let count = nodes as f64;
        let size = count * components;
        let (bytes, work) = match self.method {
            Method::Dense => {
                // Complex LU is 8n³/3 real operations; an element's block takes about 150 ns.
                let factor = 8.0 / 3.0 * size.powi(3) / OPERATIONS_PER_SECOND;
                (COMPLEX as f64 * size * size, factor + 150e-9 * count * count)
            }
            Method::Hierarchical => {
                let bytes = THIN_BYTES * components.powi(2) * count.powf(THIN_BYTES_POWER);
                (bytes, THIN_SECONDS * components.powi(3) * count.powf(THIN_SECONDS_POWER))
            }
        };
        Cost {
            unknowns: nodes * COMPONENTS,
            // Near panels have their blocks beside.
            bytes: bytes as u64 + nodes as u64 * NEAR_BYTES,
            seconds: Some(systems.len() as f64 * work / threads.max(1) as f64),
        }
    }

    /// The independent systems of equations, and which incident polarizations each needs.
    fn systems(&self) -> Vec<(Coupled, Vec<Polarization>)> {
        if self.theta_i == 0.0 {
            // e₁ is along the barbule, and so is H̃ of e₂.
            return vec![
                (Coupled::ElectricAlong, vec![Polarization::First]),
                (Coupled::MagneticAlong, vec![Polarization::Second]),
            ];
        }
        vec![(Coupled::All, Polarization::BOTH.to_vec())]
    }

    /// Solves for light from each azimuth `phi_i` (rad), in both polarizations, on so many azimuths of the full circle; `clock` times it.
    ///
    /// # Errors
    /// The equations are singular, or the user cancelled.
    pub fn solve(
        self,
        phi_i: &[f64],
        window: Window,
        azimuths: usize,
        clock: Clock,
        progress: &dyn Progress,
    ) -> Result<Vec<Scattered>> {
        let start = clock();
        let lights: Vec<Illumination> = phi_i
            .iter()
            .map(|&phi_i| Illumination {
                wavelength_nm: self.wavelength_nm,
                theta_i: self.theta_i,
                phi_i,
                window,
            })
            .collect();
        let cost = self.cost(rayon::current_num_threads());
        let systems = self.systems();
        let Self { section, mesh, wavelength_nm, theta_i, elements_per_wavelength, method, memory_bytes } =
            self;
        let mut bytes = 0;
        let k = crate::spectrum::wave_number_per_um(wavelength_nm);
        let kernel = Kernel::new(&mesh, k, -k * theta_i.sin())?;
        let radius_um = mesh.radius_um();
        let operator = Operator::new(mesh, kernel);
        // [light][polarization]
        let mut fields = vec![[Fields::new(), Fields::new()]; lights.len()];
        for (coupled, polarizations) in systems {
            let columns: Vec<(usize, Polarization)> =
                (0..lights.len()).flat_map(|l| polarizations.iter().map(move |&p| (l, p))).collect();
            let mut unknowns =
                Dense::zeros(operator.mesh.nodes.len() * coupled.components().len(), columns.len());
            for (c, &(light, polarization)) in columns.iter().enumerate() {
                let incidence = Incidence::new(&lights[light], polarization, section.width_um, radius_um);
                operator.right_side(coupled, &incidence, unknowns.column_mut(c));
            }
            let taken = match method {
                Method::Dense => solve_dense(&operator, coupled, &mut unknowns, progress)?,
                Method::Hierarchical => {
                    solve_hierarchically(&operator, coupled, &mut unknowns, memory_bytes, progress)?
                }
            };
            bytes = bytes.max(taken);
            for (c, &(light, polarization)) in columns.iter().enumerate() {
                let field = coupled.fields(unknowns.column(c));
                fields[light][polarization.index()] = field;
            }
        }
        if !fields.iter().flatten().flatten().flatten().all(|value| value.is_finite()) {
            return Err(Error::not_settled("the fields on the boundaries are not finite"));
        }
        let far = lights.iter().zip(&fields).map(|(light, fields)| {
            scatter(&operator.mesh, light, fields, beam::power_um(section.width_um, light), azimuths)
        });
        let scattered: Vec<Scattered> = far.collect();
        for (light, scattered) in lights.iter().zip(&scattered) {
            if let Some(doubt) = balance_doubt(light, scattered) {
                progress.doubt(&doubt);
            }
        }
        let effort = Some(Effort {
            unknowns: cost.unknowns,
            elements_per_wavelength,
            seconds: (clock() - start).as_secs_f64(),
            memory_bytes: bytes,
        });
        Ok(scattered.into_iter().map(|scattered| Scattered { effort, ..scattered }).collect())
    }
}

/// By which part of all light, or of the extinction, the balance of power may be off before it is said.
const MOST_IMBALANCE: f64 = 0.05;

/// What is wrong with the balance of power, in a sentence: of a plane wave extinction is what is scattered and absorbed, and of a beam no
/// more than all light is reflected and absorbed.
fn balance_doubt(light: &Illumination, scattered: &Scattered) -> Option<String> {
    let exact = scattered.exact.as_ref()?;
    let place = format!("at {} nm and φ_i = {:.4}°", light.wavelength_nm, light.phi_i.to_degrees());
    for p in 0..2 {
        let absorbed = exact.absorbed_um[p];
        if let Some(extinction) = exact.extinction_um {
            let found = exact.scattered_um[p] + absorbed;
            if (found - extinction[p]).abs() > MOST_IMBALANCE * extinction[p].abs() {
                return Some(format!(
                    "{place} polarization {} scatters and absorbs {found:.4} µm of an extinction of {:.4} µm: the full waves are not resolved; give more elements per wavelength",
                    p + 1,
                    extinction[p]
                ));
            }
        }
        if let Some(reflected) = scattered.reflected {
            let absorbed = absorbed * scattered.far.light.scale().powi(2);
            if reflected[p] + absorbed > 1.0 + MOST_IMBALANCE || absorbed < -MOST_IMBALANCE {
                return Some(format!(
                    "{place} polarization {} reflects {:.4} and absorbs {absorbed:.4} of the light: the shadow reaches over the horizon, or the full waves are not resolved and need more elements per wavelength",
                    p + 1,
                    reflected[p]
                ));
            }
        }
    }
    None
}

/// x ← A⁻¹ x by LU factors; the bytes that it took.
fn solve_dense(
    operator: &Operator,
    coupled: Coupled,
    unknowns: &mut Dense,
    progress: &dyn Progress,
) -> Result<u64> {
    progress.begin("filling the matrix", operator.mesh.nodes.len() as u64);
    let matrix = operator.matrix(coupled, progress)?;
    progress.begin("solving", LargeFactors::steps(unknowns.rows()));
    LargeFactors::new(matrix, progress)?.solve(unknowns);
    Ok((unknowns.rows() as u64).pow(2) * COMPLEX)
}

/// x ← A⁻¹ x by thin products; the bytes that they took.
fn solve_hierarchically(
    operator: &Operator,
    coupled: Coupled,
    unknowns: &mut Dense,
    memory_bytes: u64,
    progress: &dyn Progress,
) -> Result<u64> {
    let weighted = Weighted { operator, coupled };
    let factors = HierarchicalFactors::new(&weighted, TOLERANCE, memory_bytes, progress)?;
    let roots = weighted.roots();
    for k in 0..unknowns.columns() {
        unknowns.column_mut(k).iter_mut().zip(&roots).for_each(|(value, root)| *value *= root);
    }
    let right = unknowns.clone();
    factors.solve(unknowns);
    let residual = weighted.residual(unknowns, &right, SAMPLES);
    progress.note(&format!(
        "thin products of rank {} at most; equations hold to {residual:.1e}",
        factors.largest_rank()
    ));
    if residual.is_nan() || residual > MOST_RESIDUAL {
        let refusal = Error::not_settled(format!(
            "the equations of this full wave are only solved to {residual:.1e} of the light; give more `elements`"
        ));
        return Err(refusal.naming(&["elements"]));
    }
    for k in 0..unknowns.columns() {
        unknowns.column_mut(k).iter_mut().zip(&roots).for_each(|(value, root)| *value /= root);
    }
    Ok(factors.bytes())
}

/// The far field of fields on the boundaries, by incident polarization.
fn scatter(
    mesh: &Mesh,
    light: &Illumination,
    fields: &[Fields; 2],
    power_um: f64,
    azimuths: usize,
) -> Scattered {
    let (k, theta_i) = (light.wave_number_per_um(), light.theta_i);
    let kappa = k * theta_i.cos();
    let incident = light.window.light(power_um);
    let is_beam = incident != IncidentLight::PlaneWave;
    let circle = Azimuths::FullCircle(azimuths);
    let amplitudes = radiate(mesh, fields, (k, theta_i), &circle.phi_o());
    // Squares have twice the band of fields.
    let fine = Azimuths::FullCircle((2 * coefficients(kappa, mesh.radius_um())).max(720) / 4 * 4);
    let phi_fine = fine.phi_o();
    let resolved = radiate(mesh, fields, (k, theta_i), &phi_fine);
    let power = |field: &[Vec<Complex64>; 2], part: &dyn Fn(f64) -> f64| -> f64 {
        let squares = field[0].iter().zip(&field[1]).map(|(a, b)| a.norm_sqr() + b.norm_sqr());
        let sum: f64 = squares.zip(&phi_fine).map(|(square, &phi)| square * part(phi)).sum();
        theta_i.cos() * fine.step() * sum
    };
    // The trapezoidal rule from horizon to horizon, which are grid points.
    let upper = |phi: f64| {
        let beyond = (phi.abs() - PI / 2.0) / fine.step();
        if beyond < -0.5 {
            1.0
        } else if beyond < 0.5 {
            0.5
        } else {
            0.0
        }
    };
    let scattered_um = [0, 1].map(|p| power(&resolved[p], &|_| 1.0));
    let scale = incident.scale();
    let forward = radiate(mesh, fields, (k, theta_i), &[light.phi_i + PI]);
    let extinction = |p: usize| {
        // The incident unit vector, in terms of the forward direction's e₁ and e₂.
        let vector = [e1(theta_i, light.phi_i), e2(light.phi_i)][p];
        let (first, second) = (e1(-theta_i, light.phi_i + PI), e2(light.phi_i + PI));
        let along = forward[p][0][0] * first.dot(vector) + forward[p][1][0] * second.dot(vector);
        -4.0 / k * ((PI * kappa / 2.0).sqrt() * Complex64::from_polar(1.0, FRAC_PI_4) * along).re
    };
    let far = FarField {
        light: incident,
        theta_i,
        azimuths: circle,
        amplitudes: std::array::from_fn(|p| {
            std::array::from_fn(|c| amplitudes[p][c].iter().map(|value| value * scale).collect())
        }),
        radiated: scattered_um.map(|um| um * scale * scale),
    };
    Scattered {
        far,
        reflected: is_beam.then(|| [0, 1].map(|p| power(&resolved[p], &upper) * scale * scale)),
        exact: Some(Exact {
            scattered_um,
            extinction_um: (!is_beam).then(|| [0, 1].map(extinction)),
            absorbed_um: [0, 1].map(|p| absorbed_um(mesh, &fields[p])),
        }),
        effort: None,
    }
}
