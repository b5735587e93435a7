//! Many illuminations of many instances: from a structure to the statistics that its BRDF is made of.
//!
//! A [unit](crate::scattering::statistics::Unit) of work is one (λ, θ_i): all φ_i, polarizations and instances. Its fields stay in memory, their statistics
//! are formed in instance order (so that bits do not depend on threads) and go to a [`Sink`], and the fields are dropped.

mod covariance;
mod crystal;
mod memory;
mod mirror;
mod reduce;
mod run;
pub mod single;
mod sink;
pub mod spectrum;

pub use memory::{Allowance, Demand, Results, spectrum_bytes, statistics_bytes};
pub use run::{Outcome, run, statistics};
pub use sink::{Held, Memory, Sink};

use num_complex::Complex;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::math::rng::Stream;
use crate::math::simd::Width;
use crate::progress::Progress;
use crate::scattering::directions::AZIMUTH_MARGIN;
use crate::scattering::far_field::IncidentLight;
use crate::scattering::orders::OrderTable;
use crate::scattering::statistics::{AZIMUTHS, Axes, Sides, UnitStatistics};
use crate::solve::surface::{self, Barbule, Batch, Cone, Grid, Underside, Workspace};
use crate::structure::{Section, Structure, Symmetry};
use crate::{Error, Result};
use crystal::Crystal;

/// Stream path of the permutation that spreads tilts over instances.
const TILT_STREAM: u64 = 0x7469_6c74;

/// What a campaign simulates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CampaignParameters {
    /// Wavelengths and directions.
    pub axes: Axes,
    /// Number of instances M.
    pub instances: usize,
    /// Seed of instances and tilts.
    pub seed: u64,
    /// Largest tilt of an instance about y, rad.
    pub tilt: f64,
    /// Whether barbules lie either way round: each instance counts with its mirror image.
    pub mirror: bool,
}

impl CampaignParameters {
    /// The directions that are simulated: for mirror images both signs of φ_i.
    #[must_use]
    pub fn simulated(&self) -> Axes {
        let axes = self.axes.clone();
        if self.mirror { axes.with_sides(Sides::Both) } else { axes }
    }

    /// Fields at each direction: one of each instance, and one of its mirror image where it counts.
    #[must_use]
    pub fn realizations(&self) -> usize {
        self.instances * self.ways()
    }

    /// In how many ways each instance lies.
    pub(crate) fn ways(&self) -> usize {
        if self.mirror { 2 } else { 1 }
    }

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

/// What a campaign is computed with; nothing it computes depends on this, but roundings on the width.
#[derive(Debug, Clone, Copy)]
pub struct Resources {
    /// SIMD instructions.
    pub width: Width,
    /// Units of one wavelength that may be in work, and so in memory, at once ([`Demand`] foretells what they take).
    pub units_at_once: usize,
}

impl Default for Resources {
    fn default() -> Self {
        Self { width: Width::best(), units_at_once: usize::MAX }
    }
}

/// What a unit keeps beside its statistics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keep {
    /// Nothing.
    Statistics,
    /// The fields on the tabulated azimuths.
    Fields,
}

/// A structure's instances, prepared for any unit of work.
pub struct Campaign {
    parameters: CampaignParameters,
    /// One per instance, or a single one that serves all.
    barbules: Vec<Barbule>,
    /// The crystal under all of them.
    crystal: Option<Crystal>,
    tilts: Vec<f64>,
    /// What is simulated, of the parameters.
    simulated: Axes,
    /// Incident power at θ_i = 0 per instance and simulated φ_i, µm.
    powers_um: Vec<Vec<f64>>,
    width: Width,
    units_at_once: usize,
}

/// What all units of one wavelength share.
pub struct WavelengthTables {
    wavelength: usize,
    /// Layers: of each barbule, for all θ_i. A crystal: at each θ_i, for all barbules.
    undersides: Vec<Underside>,
}

impl WavelengthTables {
    /// Bytes that they take.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.undersides.iter().map(Underside::bytes).sum()
    }
}

/// The orders of a structure's crystal on the axes of a campaign; `None` for layers.
///
/// # Errors
/// The crystal cannot be solved, or the user cancelled.
pub fn orders(structure: &Structure, axes: &Axes, progress: &dyn Progress) -> Result<Option<OrderTable>> {
    let lattice = structure.lattice();
    lattice.map(|l| surface::orders(&l, axes.wavelengths_nm(), axes.cos_theta(), progress)).transpose()
}

/// Fields of one unit: `[instance][φ_i][polarization][e₁, e₂][azimuth with margins]`, over √Φ_i.
pub(crate) struct Fields {
    /// Where instances count with their mirror images, these follow them.
    pub(crate) values: Vec<Vec<Complex<f32>>>,
    /// In how many ways each instance lies.
    pub(crate) ways: usize,
    /// Values per (φ_i, polarization, component).
    pub(crate) points: usize,
    /// How many times finer than [`AZIMUTHS`] the azimuths are.
    pub(crate) refine: usize,
    /// rad
    pub(crate) theta_i: f64,
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
        parameters: CampaignParameters,
        resources: &Resources,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let orders = orders(structure, &parameters.axes, progress)?;
        Self::with_orders(structure, parameters, orders, resources, progress)
    }

    /// As [`Self::new`], with what [`orders`] gave for the structure and the axes.
    ///
    /// # Errors
    /// As [`Self::new`], or the orders belong to other axes.
    pub fn with_orders(
        structure: &Structure,
        parameters: CampaignParameters,
        orders: Option<OrderTable>,
        resources: &Resources,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let width = resources.width;
        let units_at_once = resources.units_at_once.clamp(1, most_units());
        let axes = &parameters.axes;
        let distinct = distinct(structure, &parameters);
        progress.begin("preparing instances", distinct as u64);
        let crystal = match (orders, structure.lattice()) {
            (None, None) => None,
            (Some(orders), Some(lattice)) => Some(Crystal::new(orders, &lattice, axes)?),
            _ => return Err(Error::machine("the orders of a crystal belong to another structure")),
        };
        let (sections, parts) = match &crystal {
            Some(_) => (Vec::new(), 1),
            None => ray_parts(structure, &parameters, width, progress)?,
        };
        let barbules = (0..distinct)
            .into_par_iter()
            .map(|instance| {
                if progress.is_cancelled() {
                    return Err(Error::interrupted());
                }
                let barbule = match sections.get(instance) {
                    Some(section) => Barbule::for_campaign(section, parts)?,
                    None => Barbule::for_campaign(&structure.instance(parameters.seed, instance)?, parts)?,
                };
                progress.advance(1);
                Ok(barbule)
            })
            .collect::<Result<Vec<_>>>()?;
        if let (Some(barbule), Some(first), Some(last)) =
            (barbules.first(), axes.wavelengths_nm().first(), axes.wavelengths_nm().last())
        {
            // Tables that do not reach are refused before any work.
            barbule.stacks(*first)?;
            barbule.stacks(*last)?;
        }
        let tilts = parameters.tilts();
        let simulated = parameters.simulated();
        let powers_um = tilts
            .par_iter()
            .enumerate()
            .map(|(instance, tilt)| {
                let barbule = &barbules[instance % distinct];
                azimuths(&simulated).map(|phi| barbule.incident_power_um(0.0, phi + tilt)).collect()
            })
            .collect();
        Ok(Self { parameters, barbules, crystal, tilts, simulated, powers_um, width, units_at_once })
    }

    /// Prepares the units of a wavelength by its number.
    ///
    /// # Errors
    /// A medium's table does not reach the wavelength, or the user cancelled.
    pub fn tables(&self, wavelength: usize, progress: &dyn Progress) -> Result<WavelengthTables> {
        let axes = &self.parameters.axes;
        let undersides = match &self.crystal {
            None => self
                .barbules
                .par_iter()
                .map(|barbule| {
                    if progress.is_cancelled() {
                        return Err(Error::interrupted());
                    }
                    barbule.table(axes.wavelengths_nm()[wavelength], self.width, progress)
                })
                .collect::<Result<_>>()?,
            Some(crystal) => (0..axes.cos_theta().len())
                .into_par_iter()
                .map(|theta| crystal.underside(wavelength, theta, axes.theta_i(theta)))
                .collect(),
        };
        Ok(WavelengthTables { wavelength, undersides })
    }

    /// Parts into which elements are cut for the rays under them; `None` over a crystal.
    #[must_use]
    pub fn ray_parts(&self) -> Option<usize> {
        self.barbules.first().and_then(Barbule::ray_parts)
    }

    /// Units of a wavelength that are computed at the same time, at most.
    #[must_use]
    pub fn units_at_once(&self) -> usize {
        self.units_at_once
    }

    /// What is simulated.
    #[must_use]
    pub fn parameters(&self) -> &CampaignParameters {
        &self.parameters
    }

    /// The fields of one (λ, θ_i), or a stop by `progress`.
    pub(crate) fn fields(
        &self,
        tables: &WavelengthTables,
        theta: usize,
        progress: &dyn Progress,
    ) -> Result<Fields> {
        let axes = &self.simulated;
        let theta_i = axes.theta_i(theta);
        let cone = Cone::around(&self.barbules, axes.wavelengths_nm()[tables.wavelength], theta_i);
        let refine = cone.refinement(AZIMUTHS);
        let grid = Grid { azimuths: AZIMUTHS * refine, margin: AZIMUTH_MARGIN, shift: 0.0 };
        let ways = self.parameters.ways();
        let values: Vec<Vec<Vec<_>>> = (0..self.parameters.instances)
            .into_par_iter()
            .map_init(
                || Workspace::new(self.width),
                |workspace, instance| {
                    let distinct = instance % self.barbules.len();
                    let tilt = self.tilts[instance];
                    let turned: Vec<f64> = azimuths(axes).map(|phi| phi + tilt).collect();
                    let beam = |power_um: &f64| IncidentLight::Beam { power_um: power_um * theta_i.cos() };
                    let lights: Vec<IncidentLight> = self.powers_um[instance].iter().map(beam).collect();
                    let batch = Batch { cone: &cone, phi_i: &turned, lights: &lights };
                    let underside = &tables.undersides[if self.crystal.is_some() { theta } else { distinct }];
                    let grid = Grid { shift: tilt, ..grid };
                    let barbule = &self.barbules[distinct];
                    let mut fields = workspace.scatter(barbule, underside, &batch, grid, progress)?;
                    for component in fields.chunks_exact_mut(grid.points()) {
                        hide_below_horizon(component, tilt, refine);
                    }
                    Ok(match ways {
                        1 => vec![fields],
                        _ => mirror::with_image(fields, axes, grid.points()).into(),
                    })
                },
            )
            .collect::<Result<_>>()?;
        let values = values.into_iter().flatten().collect();
        Ok(Fields { values, ways, points: grid.points(), refine, theta_i })
    }

    /// The statistics of one (λ, θ_i), with what else is kept of it.
    ///
    /// # Errors
    /// A stop by `progress`.
    pub fn unit(
        &self,
        tables: &WavelengthTables,
        theta: usize,
        keep: Keep,
        progress: &dyn Progress,
    ) -> Result<UnitStatistics> {
        let fields = self.fields(tables, theta, progress)?;
        let mut unit = reduce::unit(&self.parameters.axes, &fields);
        if keep == Keep::Fields {
            unit.fields = reduce::kept(&fields, self.parameters.axes.phis());
        }
        Ok(unit)
    }
}

/// The signs of φ_i that say all about a structure.
#[must_use]
pub fn sides(symmetry: &Symmetry) -> Sides {
    if symmetry.is_mirrored() { Sides::Alike } else { Sides::Both }
}

/// Instances that differ by more than their tilts.
fn distinct(structure: &Structure, parameters: &CampaignParameters) -> usize {
    if structure.count() == Some(1) { 1 } else { parameters.instances }
}

/// Instances that are asked how densely rays must lie.
const ASKED: usize = 2;

/// The first instances of layers, and the parts into which elements must be cut for rays under them.
fn ray_parts(
    structure: &Structure,
    parameters: &CampaignParameters,
    width: Width,
    progress: &dyn Progress,
) -> Result<(Vec<Section>, usize)> {
    let asked = 0..distinct(structure, parameters).min(ASKED);
    let sections =
        asked.map(|instance| structure.instance(parameters.seed, instance)).collect::<Result<Vec<_>>>()?;
    let shortest_nm = parameters.axes.wavelengths_nm().first().copied().unwrap_or(400.0);
    let parts = surface::ray_parts(&sections, shortest_nm, width, progress)?;
    Ok((sections, parts))
}

/// Units at once that keep all threads busy, since the instances of a unit are shared out too; more only take memory.
fn most_units() -> usize {
    2 * rayon::current_num_threads()
}

/// The incident azimuths, rad.
fn azimuths(axes: &Axes) -> impl Iterator<Item = f64> + '_ {
    (0..axes.phis()).map(|phi| axes.phi_i(phi))
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
