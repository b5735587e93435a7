//! The memory that a campaign will take, before it takes it.
//!
//! Peak = program + instances + tables of one wavelength + statistics kept + threads · workspace + units at once · unit.
//! Units of a wavelength run at the same time, all of them if there is room, and each keeps the fields of all its
//! instances; with less room fewer run at once.

use crate::math::simd::Width;
use crate::progress::Unobserved;
use crate::scattering::directions::AZIMUTH_MARGIN;
use crate::scattering::statistics::{AZIMUTHS, LAGS};
use crate::solve::surface::{Barbule, Cone, Underside, orders};
use crate::structure::Structure;
use crate::{Error, Result};

use super::{CampaignParameters, Keep};

/// The program itself with its data, and what allocators keep.
const PROGRAM: u64 = 48 << 20;

/// Instances differ from the first one, and allocators lose some.
const MARGIN: f64 = 1.25;

/// Bytes of the statistics of one (λ, θ_i, φ_i), both polarizations.
const STATISTICS: u64 = (2 * (2 * AZIMUTHS + LAGS) * 4 + 6 * 8) as u64;

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

impl Demand {
    /// Predicts from the first instance at the ends and the middle of the wavelengths; SIMD instructions make no
    /// difference beyond the margin.
    ///
    /// # Errors
    /// The instance cannot be made, or a medium's table does not cover the wavelengths.
    pub fn predict(
        structure: &Structure,
        parameters: &CampaignParameters,
        keep: Keep,
        results: Results,
    ) -> Result<Self> {
        let width = Width::best();
        let axes = &parameters.axes;
        let (Some(&shortest), Some(&longest)) = (axes.wavelengths_nm().first(), axes.wavelengths_nm().last())
        else {
            return Err(Error::input("the campaign has no wavelength"));
        };
        let distinct = super::distinct(structure, parameters);
        let (barbule, table, shared) = if let Some(lattice) = structure.lattice() {
            let barbule = Barbule::for_campaign(&structure.instance(parameters.seed, 0)?, 1)?;
            // The table over all wavelengths, and one wavelength's sampled; most orders propagate at the shortest.
            let solved = orders(&lattice, &[shortest], &[1.0], &Unobserved)?;
            let series = solved.at(0, 0);
            let sampled = Underside::crystal(series, 0.0, lattice.bottom_um()).bytes();
            let whole = axes.wavelengths_nm().len() * series.bytes();
            (barbule, 0, axes.cos_theta().len() * (whole + sampled))
        } else {
            let (sections, parts) = super::ray_parts(structure, parameters, width, &Unobserved)?;
            let first = sections.first().ok_or_else(|| Error::input("the campaign has no instance"))?;
            let barbule = Barbule::for_campaign(first, parts)?;
            let mut table = 0;
            for wavelength_nm in [shortest, 0.5 * (shortest + longest), longest] {
                table = table.max(barbule.table(wavelength_nm, width)?.bytes());
            }
            (barbule, table, 0)
        };
        // Media that vary along the top are kept beside the series; those of the rays only while a table is made.
        let media = barbule.media_bytes();
        let cone = Cone::around(std::slice::from_ref(&barbule), shortest, 0.0);
        let directions = 4 * axes.cos_phi().len();
        let fields = AZIMUTHS * cone.refinement(AZIMUTHS) + 2 * AZIMUTH_MARGIN;
        let workspace = barbule.workspace_bytes(&cone, axes.cos_phi().len())
            + 2 * table
            + media * barbule.ray_parts().unwrap_or(0);
        let kept =
            if keep == Keep::Fields { 3 * 8 * directions * parameters.instances * AZIMUTHS } else { 0 };
        let phis = axes.cos_phi().len() as u64;
        let threads = rayon::current_num_threads() as u64;
        let gathered = if results == Results::Gathered { 2 * STATISTICS * axes.len() as u64 } else { 0 };
        let scaled = |bytes: usize| (distinct as f64 * MARGIN * bytes as f64) as u64;
        Ok(Self {
            fixed: PROGRAM
                + scaled(barbule.bytes() + table + media)
                + shared as u64
                + gathered
                + threads * workspace as u64,
            unit: (8 * directions * parameters.instances * fields + kept) as u64 + 2 * STATISTICS * phis,
            most_units: axes.cos_theta().len().min(super::most_units()),
        })
    }

    /// Peak memory, bytes, with so many units in work.
    #[must_use]
    pub fn bytes(&self, units: usize) -> u64 {
        self.fixed + self.unit * units.min(self.most_units) as u64
    }

    /// The units that can be in work at once within `allowed` bytes.
    ///
    /// # Errors
    /// Not even one can be.
    pub fn units_within(&self, allowed: u64) -> Result<usize> {
        let units = allowed.saturating_sub(self.fixed) / self.unit.max(1);
        if units == 0 {
            return Err(Error::input(format!(
                "this campaign needs {} MB of memory with one unit of work at a time, but {} MB are allowed; raise --memory, or give fewer --instances, --threads or --directions",
                self.bytes(1).div_ceil(1_000_000),
                allowed / 1_000_000
            )));
        }
        Ok(usize::try_from(units).unwrap_or(usize::MAX).min(self.most_units))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Library;
    use crate::scattering::statistics::Axes;
    use crate::spectrum::Wavelengths;
    use crate::structure::SpeciesModel;

    #[test]
    fn the_cap_lowers_the_units_at_once_and_one_byte_too_few_is_refused() {
        let demand = Demand { fixed: 1_000_000, unit: 300_000, most_units: 5 };
        assert_eq!(demand.units_within(1_300_000).unwrap(), 1);
        assert_eq!(demand.units_within(1_899_999).unwrap(), 2);
        assert_eq!(demand.units_within(1_900_000).unwrap(), 3);
        assert_eq!(demand.units_within(u64::MAX).unwrap(), 5);
        let refusal = demand.units_within(1_299_999).unwrap_err();
        assert!(refusal.is_input() && refusal.to_string().contains("needs 2 MB"), "{refusal}");
    }

    #[test]
    fn demand_grows_with_instances_directions_and_what_is_kept() {
        let model = SpeciesModel::builtin("starling", None, Library::builtin()).unwrap();
        let structure = Structure::Species(Box::new(model));
        let demand = |instances: usize, phis: usize, keep: Keep| {
            let cos_phi = (1..=phis).map(|i| i as f64 / phis as f64).collect();
            let axes =
                Axes::new(&Wavelengths::new([450.0, 650.0]).unwrap(), vec![0.5, 1.0], cos_phi).unwrap();
            let parameters = CampaignParameters { axes, instances, seed: 1, tilt: 0.0 };
            Demand::predict(&structure, &parameters, keep, Results::Stored).unwrap()
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
