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
    /// Places across the barbule at which instances are lit in turn ([`places`]).
    pub places: usize,
}

/// Places across an arch, which faces another way at each: a quarter of the width apart, so that their windows together light all of
/// it evenly within 2 %.
pub const PLACES: usize = 5;

/// At how many places the instances of a structure are lit: flat ones are everywhere alike; an arch's are lit in turn at
/// [`PLACES`], if there are at least two for each.
#[must_use]
pub fn places(structure: &Structure, instances: usize) -> usize {
    if structure.is_curved() && instances >= 2 * PLACES { PLACES } else { 1 }
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

    /// At which of the places an instance is lit.
    pub(crate) fn place(&self, instance: usize) -> usize {
        instance % self.places.max(1)
    }

    /// Where the window of an instance stands on a barbule, x in µm, where there are several places.
    fn place_um(&self, instance: usize, width_um: f64) -> Option<f64> {
        let from_middle = self.place(instance) as f64 - 0.5 * (self.places as f64 - 1.0);
        (self.places > 1).then_some(from_middle * width_um / (self.places as f64 - 1.0))
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
    /// Incident power at θ_i = 0 per instance and simulated φ_i, µm, times what makes each place count by the light on it.
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
    /// Places at which instances were lit in turn.
    pub(crate) places: usize,
    /// Values per (φ_i, polarization, component).
    pub(crate) points: usize,
    /// How many times finer than [`AZIMUTHS`] the azimuths are.
    pub(crate) refine: usize,
    /// rad
    pub(crate) theta_i: f64,
}

impl Fields {
    /// The place at which a field's instance was lit.
    pub(crate) fn place(&self, field: usize) -> usize {
        field / self.ways % self.places
    }
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
                let place = |section: &Section| parameters.place_um(instance, section.width_um);
                let barbule = match sections.get(instance) {
                    Some(section) => Barbule::at_place(section, parts, place(section))?,
                    None => {
                        let section = structure.instance(parameters.seed, individual(structure, instance))?;
                        Barbule::at_place(&section, parts, place(&section))?
                    }
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
        let mut powers_um: Vec<Vec<f64>> = tilts
            .par_iter()
            .enumerate()
            .map(|(instance, tilt)| {
                let barbule = &barbules[instance % distinct];
                azimuths(&simulated).map(|phi| barbule.incident_power_um(0.0, phi + tilt)).collect()
            })
            .collect();
        weigh(&mut powers_um, &parameters);
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
        Ok(Fields { values, ways, places: self.parameters.places, points: grid.points(), refine, theta_i })
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

/// Instances that differ by more than their tilts: a single section serves all of one place.
fn distinct(structure: &Structure, parameters: &CampaignParameters) -> usize {
    if structure.count() == Some(1) { parameters.places } else { parameters.instances }
}

/// The individual of a structure that a distinct instance is of.
fn individual(structure: &Structure, distinct: usize) -> usize {
    if structure.count() == Some(1) { 0 } else { distinct }
}

/// Multiplies the power of each instance by the mean over all places over that of its own. What is reflected is divided by it, so
/// that the mean over instances is what a whole barbule reflects of what falls on it: places that face away count less.
fn weigh(powers_um: &mut [Vec<f64>], parameters: &CampaignParameters) {
    if parameters.places == 1 {
        return;
    }
    for phi in 0..powers_um.first().map_or(0, Vec::len) {
        let mut means = vec![[0.0; 2]; parameters.places];
        for (instance, powers) in powers_um.iter().enumerate() {
            let [sum, count] = &mut means[parameters.place(instance)];
            *sum += powers[phi];
            *count += 1.0;
        }
        // Every instance of a place stands for as much of the barbule, however many there are.
        let counts = powers_um.len() as f64 / parameters.places as f64;
        let means: Vec<[f64; 2]> = means.into_iter().map(|[sum, count]| [sum / count, count]).collect();
        let all = means.iter().map(|[mean, _]| mean).sum::<f64>() / means.len() as f64;
        for (instance, powers) in powers_um.iter_mut().enumerate() {
            let [mean, count] = means[parameters.place(instance)];
            // Where no light falls nothing is reflected, whatever it is divided by.
            powers[phi] *= all / mean.max(f64::MIN_POSITIVE) * count / counts;
        }
    }
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
    let asked = asked.map(|instance| structure.instance(parameters.seed, individual(structure, instance)));
    let sections = asked.collect::<Result<Vec<_>>>()?;
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
    let azimuths = AZIMUTHS * refine;
    let step = std::f64::consts::PI / azimuths as f64;
    // Margins keep the formal continuation, which interpolation near the horizon needs; only the first and the last azimuths
    // can be below.
    let reach = ((tilt.abs() / step) as usize + 1).min(azimuths);
    for n in (0..reach).chain(azimuths - reach..azimuths) {
        let phi_o = (n as f64 + 0.5) * step - std::f64::consts::FRAC_PI_2;
        if (phi_o + tilt).abs() > std::f64::consts::FRAC_PI_2 {
            out[AZIMUTH_MARGIN + n] = Complex::new(0.0, 0.0);
        }
    }
}
