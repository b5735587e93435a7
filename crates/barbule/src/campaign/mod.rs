//! Many illuminations of many instances: from a structure to the statistics that its BRDF is made of.
//!
//! A unit of work is one (λ, θ_i): all φ_i, polarizations and instances. Its fields stay in memory, their statistics
//! are formed in instance order (so that bits do not depend on threads), and the fields are dropped.

pub mod figures;
mod memory;
mod reduce;
mod resolution;
mod run;
pub mod single;
pub mod spectrum;

pub use memory::Demand;
pub use run::{Outcome, run, statistics};

use num_complex::Complex;
use rayon::prelude::*;

use crate::math::rng::Stream;
use crate::math::simd::Width;
use crate::progress::Progress;
use crate::scattering::directions::AZIMUTH_MARGIN;
use crate::scattering::orders::OrderTable;
use crate::scattering::statistics::{AZIMUTHS, Axes, Unit};
use crate::solve::crystal::{Multipole, order_table};
use crate::solve::surface::{
    CAMPAIGN_ELEMENT_UM, Cone, CrystalOrders, Nodes, Rays, ReflectanceTable, Stacks, Surface, Window,
    Workspace, inverse_root, refinement,
};
use crate::structure::{Lattice, Structure};
use crate::{Error, Result};

/// Stream path of the permutation that spreads tilts over instances.
const TILT_STREAM: u64 = 0x7469_6c74;

/// What a campaign simulates.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    /// Wavelengths and directions.
    pub axes: Axes,
    /// Number of instances M.
    pub instances: usize,
    /// Seed of instances and tilts.
    pub seed: u64,
    /// Largest tilt of an instance about y, rad.
    pub tilt: f64,
}

impl Parameters {
    /// The tilt δ_m of each instance, rad: (−1 + 2π(m)/(M−1))·tilt with π a random permutation of 0 … M − 1.
    #[must_use]
    pub fn tilts(&self) -> Vec<f64> {
        let order = Stream::new(self.seed, &[TILT_STREAM]).permutation(self.instances);
        let last = self.instances.saturating_sub(1).max(1) as f64;
        if self.instances == 1 {
            return vec![0.0];
        }
        order.into_iter().map(|rank| (2.0 * rank as f64 / last - 1.0) * self.tilt).collect()
    }
}

/// A structure's instances, prepared for any unit of work.
pub struct Campaign {
    parameters: Parameters,
    /// One per instance, or a single one that serves all.
    surfaces: Vec<Surface>,
    under: Under,
    tilts: Vec<f64>,
    /// Incident power at θ_i = 0 per instance and φ_i, µm.
    powers_um: Vec<Vec<f64>>,
    width: Width,
    units_at_once: usize,
}

/// What reflects under the tops.
enum Under {
    /// Layers: the rays through those of each surface.
    Layers(Vec<Rays>),
    /// The same photonic crystal under all, and how deep it is.
    Crystal { orders: OrderTable, depth_um: f64 },
}

/// What all units of one wavelength share.
pub struct Wavelength {
    index: usize,
    reflectors: Reflectors,
}

enum Reflectors {
    /// Of each surface.
    Layers(Vec<ReflectanceTable>),
    /// At each θ_i.
    Crystal(Vec<CrystalOrders<f32>>),
}

impl Wavelength {
    /// Bytes of its tables.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match &self.reflectors {
            Reflectors::Layers(tables) => tables.iter().map(ReflectanceTable::bytes).sum(),
            Reflectors::Crystal(orders) => orders.iter().map(CrystalOrders::bytes).sum(),
        }
    }
}

/// The orders of a structure's crystal on the axes of a campaign; `None` for layers.
///
/// # Errors
/// The crystal cannot be solved, or the user cancelled.
pub fn orders(structure: &Structure, axes: &Axes, progress: &dyn Progress) -> Result<Option<OrderTable>> {
    let table = |lattice: Lattice| {
        order_table(&Multipole::default(), &lattice, &axes.wavelengths_nm, &axes.cos_theta, progress)
    };
    structure.lattice().map(table).transpose()
}

/// Fields of one unit: `[instance][φ_i][polarization][e₁, e₂][azimuth with margins]`, over √Φ_i.
pub(crate) struct Fields {
    pub(crate) values: Vec<Vec<Complex<f32>>>,
    /// Values per (φ_i, polarization, component).
    pub(crate) points: usize,
    /// How many times finer than [`AZIMUTHS`] the azimuths are.
    pub(crate) refine: usize,
}

impl Campaign {
    /// Generates the instances and casts their layers, or solves their crystal; a single given section serves all
    /// instances, which then differ by their tilts only.
    ///
    /// # Errors
    /// An instance cannot be made, a medium's table does not cover the wavelengths, the crystal cannot be solved, or the
    /// progress cancelled.
    pub fn new(
        structure: &Structure,
        parameters: Parameters,
        width: Width,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let orders = orders(structure, &parameters.axes, progress)?;
        Self::with_orders(structure, parameters, orders, width, progress)
    }

    /// As [`Self::new`], with what [`orders`] gave for the structure and the axes.
    ///
    /// # Errors
    /// As [`Self::new`], or the orders belong to other axes.
    pub fn with_orders(
        structure: &Structure,
        parameters: Parameters,
        orders: Option<OrderTable>,
        width: Width,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let distinct = if structure.count() == Some(1) { 1 } else { parameters.instances };
        let axes = &parameters.axes;
        progress.begin("preparing instances", distinct as u64);
        let sections = |instance: usize| {
            if progress.is_cancelled() {
                return Err(Error::interrupted());
            }
            structure.instance(parameters.seed, instance)
        };
        let (surfaces, under) = match orders {
            Some(orders) => {
                if orders.wavelengths_nm != axes.wavelengths_nm || orders.cos_theta != axes.cos_theta {
                    return Err(Error::machine("the orders of the crystal belong to other axes"));
                }
                let surfaces = (0..distinct)
                    .into_par_iter()
                    .map(|instance| {
                        let surface =
                            Surface::new(&sections(instance)?, CAMPAIGN_ELEMENT_UM, Window::Gaussian)?;
                        progress.advance(1);
                        Ok(surface)
                    })
                    .collect::<Result<Vec<_>>>()?;
                let depth_um = structure.lattice().map_or(0.0, |lattice| lattice.bottom_um());
                (surfaces, Under::Crystal { orders, depth_um })
            }
            None => {
                let shortest_nm = axes.wavelengths_nm.first().copied().unwrap_or(400.0);
                let parts = resolution::ray_parts(
                    structure,
                    parameters.seed,
                    distinct,
                    shortest_nm,
                    width,
                    progress,
                )?;
                let pairs = (0..distinct)
                    .into_par_iter()
                    .map(|instance| {
                        let section = sections(instance)?;
                        let surface = Surface::new(&section, CAMPAIGN_ELEMENT_UM, Window::Gaussian)?;
                        let rays = Rays::cast(&section, CAMPAIGN_ELEMENT_UM, parts)?;
                        progress.advance(1);
                        Ok((surface, rays))
                    })
                    .collect::<Result<Vec<_>>>()?;
                let (surfaces, rays) = pairs.into_iter().unzip();
                (surfaces, Under::Layers(rays))
            }
        };
        if let (Some(surface), Some(first), Some(last)) =
            (surfaces.first(), axes.wavelengths_nm.first(), axes.wavelengths_nm.last())
        {
            // Tables that do not reach are refused before any work.
            surface.optics::<f32>(*first)?;
            surface.optics::<f32>(*last)?;
        }
        let tilts = parameters.tilts();
        let powers_um = tilts
            .par_iter()
            .enumerate()
            .map(|(instance, tilt)| {
                let surface = &surfaces[instance % distinct];
                azimuths(&parameters.axes).map(|phi| surface.incident_power_um(0.0, phi + tilt)).collect()
            })
            .collect();
        Ok(Self { parameters, surfaces, under, tilts, powers_um, width, units_at_once: most_units() })
    }

    /// Prepares the units of one wavelength.
    ///
    /// # Errors
    /// A medium's table does not reach the wavelength, or the user cancelled.
    pub fn wavelength(&self, index: usize, progress: &dyn Progress) -> Result<Wavelength> {
        let wavelength_nm = self.parameters.axes.wavelengths_nm[index];
        let reflectors = match &self.under {
            Under::Layers(rays) => {
                let table = |(surface, rays)| {
                    if progress.is_cancelled() {
                        return Err(Error::interrupted());
                    }
                    ReflectanceTable::new(self.width, surface, rays, wavelength_nm)
                };
                Reflectors::Layers(self.surfaces.par_iter().zip(rays).map(table).collect::<Result<_>>()?)
            }
            Under::Crystal { orders, depth_um } => {
                let cos_theta = &self.parameters.axes.cos_theta;
                let at = |theta: usize| {
                    let theta_i = cos_theta[theta].clamp(0.0, 1.0).acos();
                    CrystalOrders::new(orders.at(index, theta), theta_i, *depth_um)
                };
                Reflectors::Crystal((0..cos_theta.len()).into_par_iter().map(at).collect())
            }
        };
        Ok(Wavelength { index, reflectors })
    }

    /// Parts into which elements are cut for the rays under them; `None` over a crystal.
    #[must_use]
    pub fn ray_parts(&self) -> Option<usize> {
        match &self.under {
            Under::Layers(rays) => rays.first().map(Rays::parts),
            Under::Crystal { .. } => None,
        }
    }

    /// Units of a wavelength that are computed at the same time, at most.
    #[must_use]
    pub fn units_at_once(&self) -> usize {
        self.units_at_once
    }

    /// Limits the units that are computed, and so kept in memory, at the same time; bits do not depend on it.
    pub fn limit_units(&mut self, at_once: usize) {
        self.units_at_once = at_once.clamp(1, most_units());
    }

    /// What is simulated.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The fields of one (λ, θ_i).
    pub(crate) fn fields(&self, wavelength: &Wavelength, theta: usize) -> (Fields, Cone) {
        let axes = &self.parameters.axes;
        let theta_i = axes.cos_theta[theta].clamp(0.0, 1.0).acos();
        let radius = self.surfaces.iter().fold(0f64, |r, surface| r.max(surface.radius_um));
        let k = std::f64::consts::TAU / (axes.wavelengths_nm[wavelength.index] * 1e-3);
        let cone = Cone::new(k, theta_i, radius);
        let refine = refinement(&cone, AZIMUTHS);
        let values = (0..self.parameters.instances)
            .into_par_iter()
            .map_init(
                || (Workspace::<f32>::new(self.width), Vec::new(), Vec::new(), Vec::new()),
                |(workspace, coefficients, circle, scratch), instance| {
                    let distinct = instance % self.surfaces.len();
                    let surface = &self.surfaces[distinct];
                    let tilt = self.tilts[instance];
                    let nodes = Nodes::equidistant(surface, cone.kappa);
                    let turned: Vec<f64> = azimuths(axes).map(|phi| phi + tilt).collect();
                    let scales: Vec<f64> = self.powers_um[instance]
                        .iter()
                        .map(|&power_um| inverse_root(power_um * theta_i.cos()))
                        .collect();
                    match &wavelength.reflectors {
                        Reflectors::Layers(tables) => {
                            let stacks = Stacks(&tables[distinct]);
                            workspace.far_fields(
                                surface,
                                &stacks,
                                &nodes,
                                &cone,
                                &turned,
                                &scales,
                                coefficients,
                            );
                        }
                        Reflectors::Crystal(orders) => {
                            let orders = &orders[theta];
                            workspace.far_fields(
                                surface,
                                orders,
                                &nodes,
                                &cone,
                                &turned,
                                &scales,
                                coefficients,
                            );
                        }
                    }
                    let synthesis = workspace.synthesis(&cone, AZIMUTHS * refine, AZIMUTH_MARGIN);
                    let points = synthesis.points();
                    let mut fields = vec![Complex::new(0.0, 0.0); coefficients.len() / cone.angles * points];
                    for (component, out) in
                        coefficients.chunks_exact(cone.angles).zip(fields.chunks_exact_mut(points))
                    {
                        synthesis.evaluate(component, tilt, circle, scratch, out);
                        hide_below_horizon(out, tilt, refine);
                    }
                    fields
                },
            )
            .collect();
        let points = AZIMUTHS * refine + 2 * AZIMUTH_MARGIN;
        (Fields { values, points, refine }, cone)
    }

    /// The statistics of one (λ, θ_i), with the fields themselves if they are to be kept.
    #[must_use]
    pub fn unit(&self, wavelength: &Wavelength, theta: usize, keep_fields: bool) -> Unit {
        let (fields, cone) = self.fields(wavelength, theta);
        let mut unit = reduce::unit(&self.parameters.axes, &fields, cone.theta_i);
        if keep_fields {
            unit.fields = reduce::kept(&fields, self.parameters.axes.cos_phi.len());
        }
        unit
    }
}

/// Units at once that keep all threads busy, since the instances of a unit are shared out too; more only take memory.
fn most_units() -> usize {
    2 * rayon::current_num_threads()
}

/// The incident azimuths, rad.
fn azimuths(axes: &Axes) -> impl Iterator<Item = f64> + '_ {
    axes.cos_phi.iter().map(|c| c.clamp(0.0, 1.0).acos())
}

/// Zeroes what a tilted instance would send below its own horizon.
fn hide_below_horizon(out: &mut [Complex<f32>], tilt: f64, refine: usize) {
    let step = std::f64::consts::PI / (AZIMUTHS * refine) as f64;
    for (n, value) in out.iter_mut().enumerate() {
        let phi_o = (n as f64 - AZIMUTH_MARGIN as f64 + 0.5) * step - std::f64::consts::FRAC_PI_2;
        // Margins keep the formal continuation, which interpolation near the horizon needs.
        if phi_o.abs() < std::f64::consts::FRAC_PI_2 && (phi_o + tilt).abs() > std::f64::consts::FRAC_PI_2 {
            *value = Complex::new(0.0, 0.0);
        }
    }
}
