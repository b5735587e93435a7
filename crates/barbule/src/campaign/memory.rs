//! The memory that a campaign will take, before it takes it.
//!
//! Peak = program + instances + the larger of what preparing them takes and of what simulating takes: tables of one
//! wavelength + statistics kept + threads · workspace + units at once · unit. Units of a wavelength run at the same time,
//! all of them if there is room, and each keeps the fields of all its instances; with less room fewer run at once.

use crate::math::simd::Width;
use crate::progress::{Progress, Unobserved};
use crate::scattering::directions::AZIMUTH_MARGIN;
use crate::scattering::statistics::{AZIMUTHS, Axes, GLINTS, LAGS};
use crate::solve::cost::PROGRAM;
use crate::solve::surface::{Barbule, CAMPAIGN_ELEMENT_UM, Cone, MOST_RAY_PARTS, Size, Underside, orders};
use crate::structure::{Section, Structure};
use crate::{Error, Result};

use super::spectrum::SpectrumRequest;
use super::{ASKED, CampaignParameters, Keep};

/// Instances differ from the first ones, and allocators lose some.
const MARGIN: f64 = 1.25;

/// Bytes of the statistics of one (λ, θ_i, φ_i), both polarizations, so many fields.
const fn statistics(realizations: usize) -> u64 {
    ((2 * (3 * AZIMUTHS + LAGS) + GLINTS.len() * realizations) * 4 + 6 * 8) as u64
}

/// Bytes of a reflectance table per point, at most: blocks of longer series have none.
const LARGEST_TABLE: usize = 256 * 16;

/// Bytes of a value of a spectrum with its deviation, as numbers and as text.
const SPECTRUM_VALUE: usize = 300;

/// What may be taken, and who says so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Allowance {
    /// Bytes.
    pub bytes: u64,
    /// Whether somebody asked for it; else it is what the machine has left.
    pub asked: bool,
}

impl Allowance {
    /// No limit is known.
    pub const UNKNOWN: Self = Self { bytes: u64::MAX, asked: false };

    /// Refuses what needs more. `what` begins the sentence, `remedy` ends it: what to give fewer of.
    ///
    /// # Errors
    /// It needs more.
    pub fn check(&self, what: &str, bytes: u64, remedy: &str) -> Result<()> {
        if bytes <= self.bytes {
            return Ok(());
        }
        let (need, limit) = (bytes.div_ceil(1_000_000), self.bytes / 1_000_000);
        let refusal = Error::input(if self.asked {
            format!(
                "{what} needs {need} MB of memory, but {limit} MB are allowed; raise `memory`, or give {remedy}"
            )
        } else {
            format!("{what} needs {need} MB of memory, but {limit} MB are free; give {remedy}")
        });
        Err(refusal.naming(&["memory", "instances", "threads", "directions"]))
    }
}

/// Where the statistics of a campaign go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Results {
    /// Into a store, unit by unit.
    Stored,
    /// All into memory, as for a fit.
    Gathered,
}

/// What a campaign needs in memory, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Demand {
    /// Whatever runs at once.
    pub fixed: u64,
    /// Each unit in work.
    pub unit: u64,
    /// Units that may be in work at the same time: those of a wavelength.
    pub most_units: usize,
}

/// The first instances, and how large their preparation becomes.
struct First {
    sections: Vec<Section>,
    size: Size,
}

impl First {
    fn of(structure: &Structure, seed: u64, distinct: usize, element_um: f64) -> Result<Self> {
        let sections = (0..distinct.clamp(1, ASKED))
            .map(|instance| structure.instance(seed, super::individual(structure, instance)))
            .collect::<Result<Vec<_>>>()?;
        let mut sizes = sections.iter().map(|section| Size::foretell(section, element_um));
        let first = sizes.next().ok_or_else(|| Error::input("there is no instance"))??;
        let size = sizes.try_fold(first, |largest, size| Ok::<_, Error>(largest.max(size?)))?;
        Ok(Self { sections, size })
    }
}

impl Demand {
    /// More than it can be, from the sizes of the first instances alone: where this is allowed, nothing need be
    /// predicted more closely.
    ///
    /// # Errors
    /// An instance cannot be made.
    pub fn bound(
        structure: &Structure,
        parameters: &CampaignParameters,
        keep: Keep,
        results: Results,
    ) -> Result<Self> {
        let distinct = super::distinct(structure, parameters);
        let first = First::of(structure, parameters.seed, distinct, CAMPAIGN_ELEMENT_UM)?;
        let size = first.size;
        let (parts, table) = if structure.lattice().is_some() {
            (1, 0)
        } else {
            (MOST_RAY_PARTS, LARGEST_TABLE * size.points)
        };
        let rays = 8 * parts * size.points * size.slots;
        let instance = size.bytes() + rays + table + 8 * size.points * size.slots;
        let workspace = size.workspace_bytes(shortest(parameters)?, parameters.simulated().phis(), 4);
        let threads = rayon::current_num_threads();
        let fixed = threads * (workspace + 2 * table + size.casting_bytes(2 * parts))
            + (2.0 * distinct as f64 * instance as f64) as usize;
        Ok(Self::with(parameters, keep, results, fixed as u64, azimuths(&first.sections, parameters)?))
    }

    /// Predicts from the first instances at the ends and the middle of the wavelengths; SIMD instructions make no
    /// difference beyond the margin. Takes no more memory than `allowed` itself.
    ///
    /// # Errors
    /// The instances cannot be made, or take more than is allowed; a medium's table does not cover the wavelengths; or the
    /// user cancelled.
    pub fn predict(
        structure: &Structure,
        parameters: &CampaignParameters,
        keep: Keep,
        results: Results,
        allowed: Allowance,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let width = Width::best();
        let axes = &parameters.simulated();
        let (first_nm, last_nm) =
            (shortest(parameters)?, axes.wavelengths_nm()[axes.wavelengths_nm().len() - 1]);
        let distinct = super::distinct(structure, parameters);
        let First { sections, size } = First::of(structure, parameters.seed, distinct, CAMPAIGN_ELEMENT_UM)?;
        let threads = rayon::current_num_threads().min(distinct);
        let workspace = size.workspace_bytes(first_nm, axes.phis(), 4);
        let least = PROGRAM + (size.casting_bytes(1) + size.bytes() + workspace) as u64;
        allowed.check(WHAT, least, FEWER)?;
        let (barbule, table, shared, casting) = if let Some(lattice) = structure.lattice() {
            let barbule = Barbule::for_campaign(&sections[0], 1)?;
            // The table over all wavelengths, and one wavelength's sampled; most orders propagate at the shortest.
            let solved = orders(&lattice, &[first_nm], &[1.0], progress)?;
            let series = solved.at(0, 0);
            let sampled = Underside::crystal(series, 0.0, lattice.bottom_um()).bytes();
            let whole = axes.wavelengths_nm().len() * series.bytes();
            (barbule, 0, axes.cos_theta().len() * (whole + sampled), size.casting_bytes(1))
        } else {
            let tried = size.casting_bytes(2) as u64;
            allowed.check(WHAT, PROGRAM + tried, FEWER)?;
            let (sections, parts) = super::ray_parts(structure, parameters, width, progress)?;
            let barbule = Barbule::for_campaign(&sections[0], parts)?;
            let mut table = 0;
            for wavelength_nm in [first_nm, 0.5 * (first_nm + last_nm), last_nm] {
                table = table.max(barbule.table(wavelength_nm, width, progress)?.bytes());
            }
            // Asking how many rays there must be tries twice as many.
            let casting = size.casting_bytes(parts);
            (barbule, table, 0, (threads * casting).max(2 * casting).div_ceil(threads))
        };
        // Media that vary along the top are kept beside the series; those of the rays only while a table is made.
        let media = barbule.media_bytes();
        let cone = Cone::around(std::slice::from_ref(&barbule), first_nm, 0.0);
        let workspace = barbule.workspace_bytes(&cone, axes.phis())
            + 2 * table
            + media * barbule.ray_parts().unwrap_or(0);
        let scaled = |bytes: usize| (distinct as f64 * MARGIN * bytes as f64) as usize;
        let simulating = scaled(table + media) + shared + rayon::current_num_threads() * workspace;
        let fixed = scaled(barbule.bytes()) + simulating.max(threads * casting);
        let refined = AZIMUTHS * cone.refinement(AZIMUTHS) + 2 * AZIMUTH_MARGIN;
        Ok(Self::with(parameters, keep, results, fixed as u64, refined))
    }

    /// What of it follows from the parameters; `azimuths` are those of a field, refined and with their margins.
    fn with(
        parameters: &CampaignParameters,
        keep: Keep,
        results: Results,
        instances: u64,
        azimuths: usize,
    ) -> Self {
        let axes = &parameters.axes;
        let fields = 4 * axes.phis() * parameters.realizations();
        let kept = if keep == Keep::Fields { 3 * 8 * fields * AZIMUTHS } else { 0 };
        let gathered = if results == Results::Gathered {
            2 * statistics(parameters.realizations()) * axes.len() as u64
        } else {
            0
        };
        Self {
            fixed: PROGRAM + instances + gathered,
            unit: (8 * fields * azimuths + kept) as u64
                + 2 * statistics(parameters.realizations()) * axes.phis() as u64,
            most_units: axes.cos_theta().len().min(super::most_units()),
        }
    }

    /// Peak memory, bytes, with so many units in work.
    #[must_use]
    pub fn bytes(&self, units: usize) -> u64 {
        self.fixed.saturating_add(self.unit.saturating_mul(units.min(self.most_units) as u64))
    }

    /// The units that can be in work at once, whatever a campaign needs. A closer look than [`Self::bound`] takes seconds, and most campaigns
    /// are far from the machine's limits: it is taken where somebody asked for a limit, and where the bound is over it.
    ///
    /// # Errors
    /// An instance cannot be made, or not even one unit can be in work.
    pub fn units_allowed(
        structure: &Structure,
        parameters: &CampaignParameters,
        keep: Keep,
        results: Results,
        allowed: Allowance,
    ) -> Result<usize> {
        if !allowed.asked {
            let bound = Self::bound(structure, parameters, keep, results)?;
            if bound.bytes(usize::MAX) <= allowed.bytes {
                return Ok(usize::MAX);
            }
        }
        Self::predict(structure, parameters, keep, results, allowed, &Unobserved)?.units_within(allowed)
    }

    /// The units that can be in work at once.
    ///
    /// # Errors
    /// Not even one can be.
    pub fn units_within(&self, allowed: Allowance) -> Result<usize> {
        allowed.check(WHAT, self.bytes(1), FEWER)?;
        let units = allowed.bytes.saturating_sub(self.fixed) / self.unit.max(1);
        Ok(usize::try_from(units).unwrap_or(usize::MAX).min(self.most_units))
    }
}

const WHAT: &str = "this campaign, with one unit of work at a time,";
const FEWER: &str = "fewer `instances`, `threads` or `directions`";

fn shortest(parameters: &CampaignParameters) -> Result<f64> {
    let first = parameters.axes.wavelengths_nm().first().copied();
    first.ok_or_else(|| Error::input("the campaign has no wavelength"))
}

/// Azimuths of a field of the first sections, refined and with their margins.
fn azimuths(sections: &[Section], parameters: &CampaignParameters) -> Result<usize> {
    let radius_um = sections.iter().map(Size::radius_um).fold(0.0, f64::max);
    Ok(AZIMUTHS * Cone::new(shortest(parameters)?, 0.0, radius_um).refinement(AZIMUTHS) + 2 * AZIMUTH_MARGIN)
}

/// What the statistics of all units, each of so many fields at a direction, take in memory while a material is fitted to them, bytes, at most.
#[must_use]
pub fn statistics_bytes(axes: &Axes, realizations: usize) -> u64 {
    PROGRAM + 2 * statistics(realizations) * axes.len() as u64
}

/// What a request for spectra takes in memory, bytes, at most.
///
/// # Errors
/// An instance cannot be made.
pub fn spectrum_bytes(structure: &Structure, request: &SpectrumRequest) -> Result<u64> {
    let SpectrumRequest { wavelengths, directions, instances, seed, .. } = request;
    let threads = rayon::current_num_threads().min(*instances);
    let size = First::of(structure, *seed, *instances, super::spectrum::ELEMENT_UM)?.size;
    let incidences = directions.len().min(super::spectrum::DIRECTIONS_AT_ONCE);
    let (first_nm, _) = wavelengths.range_nm();
    let own = size.casting_bytes(1) + size.bytes() + size.workspace_bytes(first_nm, incidences, 4);
    let values = directions.len().saturating_mul(wavelengths.len());
    let results = values.saturating_mul(8 * instances + SPECTRUM_VALUE);
    Ok(PROGRAM.saturating_add(((MARGIN * (threads * own) as f64) as u64).saturating_add(results as u64)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Library;
    use crate::progress::Unobserved;
    use crate::spectrum::Wavelengths;
    use crate::structure::SpeciesModel;

    #[test]
    fn the_cap_lowers_the_units_at_once_and_one_byte_too_few_is_refused() {
        let demand = Demand { fixed: 1_000_000, unit: 300_000, most_units: 5 };
        let within = |bytes: u64| demand.units_within(Allowance { bytes, asked: true });
        assert_eq!(within(1_300_000).unwrap(), 1);
        assert_eq!(within(1_899_999).unwrap(), 2);
        assert_eq!(within(1_900_000).unwrap(), 3);
        assert_eq!(within(u64::MAX).unwrap(), 5);
        let refusal = within(1_299_999).unwrap_err();
        assert!(refusal.is_input() && refusal.to_string().contains("needs 2 MB"), "{refusal}");
        assert!(refusal.to_string().contains("raise `memory`, or give fewer `instances`"), "{refusal}");
        let free = demand.units_within(Allowance { bytes: 1_000_000, asked: false }).unwrap_err();
        assert!(free.to_string().contains("1 MB are free; give fewer"), "{free}");
    }

    #[test]
    fn demand_grows_with_instances_directions_and_what_is_kept() {
        let model = SpeciesModel::builtin("starling", None, Library::builtin()).unwrap();
        let structure = Structure::Species(Box::new(model));
        let demand = |instances: usize, phis: usize, keep: Keep| {
            let cos_phi = (1..=phis).map(|i| i as f64 / phis as f64).collect();
            let axes =
                Axes::new(&Wavelengths::new([450.0, 650.0]).unwrap(), vec![0.5, 1.0], cos_phi).unwrap();
            let parameters =
                CampaignParameters { axes, instances, seed: 1, tilt: 0.0, mirror: false, places: 1 };
            let bound = Demand::bound(&structure, &parameters, keep, Results::Stored).unwrap();
            let allowed = Allowance::UNKNOWN;
            let found = Demand::predict(&structure, &parameters, keep, Results::Stored, allowed, &Unobserved)
                .unwrap();
            assert!(bound.bytes(1) >= found.bytes(1), "{bound:?} {found:?}");
            found
        };
        let small = demand(2, 2, Keep::Statistics);
        // 2 instances × 2 φ_i × 4 components of at least 400 values of 8 bytes.
        assert!(small.unit >= 2 * 2 * 4 * 400 * 8);
        assert!(
            demand(4, 2, Keep::Statistics).fixed > small.fixed
                && demand(4, 2, Keep::Statistics).unit > small.unit
        );
        assert!(
            demand(2, 4, Keep::Statistics).unit > small.unit && demand(2, 2, Keep::Fields).unit > small.unit
        );
    }
}
