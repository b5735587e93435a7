//! From a structure to the material of a feather, with the product's defaults: what is simulated, what is recorded, and
//! where finished materials are.
//!
//! [`CampaignOptions`] and a structure make a [`Plan`]; [`characterize`] simulates and fits it. A [`Catalog`] finds what
//! is there already. [`Barbules`] are those that a material was made of, made again. [`Portions`] are a plan for workers on
//! several machines.

mod again;
mod catalog;
mod description;
mod grazing;
mod halo;
mod listing;
mod options;
mod portions;

pub use again::{Barbules, species_of};
pub use catalog::{Catalog, Found, Origin, as_filed};
pub use description::CampaignDescription;
use grazing::grazing;
use halo::HALO_VERSION;
pub use halo::HaloPlan;
pub use listing::{Cached, CachedMaterial, CachedOrders, Contents};
pub use options::{CampaignOptions, Plan, WAVELENGTHS_NM, outside_wavelengths};
pub use portions::Portions;

use std::path::Path;

use serde_json::json;

use crate::brdf::fit::{FitOptions, FitReport, LobeForm, fit};
use crate::brdf::{FeatherMaterial, check_axes, check_sigma};
use crate::campaign::{Outcome, Resources, run, statistics};
use crate::error::shortened;
use crate::io::Units;
use crate::io::store::Store;
use crate::math::simd::Width;
use crate::progress::{Progress, Shard};
use crate::scattering::statistics::Statistics;
use crate::{Error, Result};

/// Version of what a campaign computes: raised when its numbers change, so that old results are not mistaken for new.
pub const CAMPAIGN_VERSION: u64 = 2;

/// How a characterization is run; what it computes depends on none of this, but on bits for the width.
#[derive(Debug, Clone, Copy, Default)]
pub struct Execution<'a> {
    /// What the simulation is computed with.
    pub resources: Resources,
    /// The campaign store to fill or to go on with; else statistics stay in memory.
    pub store: Option<&'a Path>,
}

/// A finished characterization.
#[derive(Debug, Clone)]
pub struct Characterized {
    /// The material.
    pub material: FeatherMaterial,
    /// How well it fits.
    pub report: FitReport,
    /// Damaged units of the store that were computed again.
    pub repaired: usize,
}

/// Simulates a plan and fits its material, with a halo if `options` ask for it; orders of crystals come from the catalog's cache or go there.
///
/// # Errors
/// What no material can have is refused before any work ([`check`]); media whose tables do not reach a wavelength, a store that
/// cannot be written or holds another campaign, or a stop by `progress`.
pub fn characterize(
    plan: &Plan,
    options: &FitOptions,
    catalog: &Catalog,
    how: &Execution<'_>,
    progress: &dyn Progress,
) -> Result<Characterized> {
    check(plan, options)?;
    let campaign = plan.campaign(&how.resources, catalog, progress)?;
    let (statistics, repaired) = match how.store {
        None => (statistics(&campaign, progress)?, 0),
        Some(path) => {
            let store = plan.store(path, &[], &how.resources)?;
            let _announced = store.announce(Shard::WHOLE);
            let outcome = run(&campaign, &store.axes().shard(0, 1), &store, progress)?;
            (store.statistics()?, outcome.repaired)
        }
    };
    let units = how.store.map(halo_units);
    let width = how.resources.width;
    let (material, report) = finished(plan, &statistics, options, width, units.as_ref(), progress)?;
    Ok(Characterized { material, report, repaired })
}

/// Where the halo of a campaign is kept: beside its store, which is of 2.5D alone.
fn halo_units(store: &Path) -> Units {
    Units::new(&store.with_extension("halo"))
}

/// Fits the material of a plan's statistics; with its halo, which `units` may have and is else computed with the instructions `width`, if
/// `options` ask for it.
fn finished(
    plan: &Plan,
    statistics: &Statistics,
    options: &FitOptions,
    width: Width,
    units: Option<&Units>,
    progress: &dyn Progress,
) -> Result<(FeatherMaterial, FitReport)> {
    let name = plan.structure.name();
    let (mut material, report) = material_of(statistics, &name, &plan.description, options, progress)?;
    if options.halo {
        let halo = HaloPlan::new(plan, width);
        material.halo = Some(halo.measure(units, progress)?);
        material.info["halo"] = halo.info();
    }
    Ok((material, report))
}

/// Simulates a part of a plan into its store, and of its halo if `options` ask for it: [`characterize`] then finds it there, whoever
/// simulated it.
///
/// # Errors
/// As [`characterize`]; there is no store.
pub fn characterize_part(
    plan: &Plan,
    options: &FitOptions,
    shard: Shard,
    catalog: &Catalog,
    how: &Execution<'_>,
    progress: &dyn Progress,
) -> Result<Outcome> {
    check(plan, options)?;
    let Some(path) = how.store else {
        return Err(Error::input("parts of a campaign meet in its store; name one"));
    };
    let store = plan.store(path, &[], &how.resources)?;
    let units = store.axes().shard(shard.number(), shard.of());
    let outcome = if units.iter().all(|unit| store.is_whole(unit.wavelength, unit.theta)) {
        // Nothing is prepared for nothing.
        Outcome { computed: 0, found: units.len(), repaired: 0 }
    } else {
        let _announced = store.announce(shard);
        run(&plan.campaign(&how.resources, catalog, progress)?, &units, &store, progress)?
    };
    if options.halo {
        HaloPlan::new(plan, how.resources.width).measure_part(shard, &halo_units(path), progress)?;
    }
    Ok(outcome)
}

/// Refuses, before any work, a plan of which no material can be made.
///
/// # Errors
/// σ is outside 0.002 to 0.25; more than 512 wavelengths or 4,000,000 nodes.
pub fn check(plan: &Plan, options: &FitOptions) -> Result<()> {
    check_sigma(options.sigma)?;
    check_axes(&plan.parameters.axes)
}

/// Fits the material of a campaign's statistics and records how it was made; polarizations and seed are the campaign's.
///
/// # Errors
/// As [`fit`].
pub fn material_of(
    statistics: &Statistics,
    name: &str,
    campaign: &CampaignDescription,
    options: &FitOptions,
    progress: &dyn Progress,
) -> Result<(FeatherMaterial, FitReport)> {
    let options = FitOptions { polarized: campaign.polarized, seed: campaign.seed, ..*options };
    let (mut material, mut report) = fit(statistics, &options, progress)?;
    report.grazing = campaign.width_um().map_or_else(Vec::new, |width| grazing(&statistics.axes, width));
    let [correlation, contrast] = report.mean_patterns();
    material.info = json!({
        "name": name,
        "species": campaign.structure["species"],
        "variant": campaign.structure["variant"],
        "tilt_deg": campaign.tilt_deg,
        "version": env!("CARGO_PKG_VERSION"),
        "campaign": campaign.to_json()?,
        "residual_median": report.residual_median,
        "residual_95": report.residual_95,
        "lobes": report.fits,
        "flagged": report.flagged.len(),
        "clipped": report.clipped.len(),
        "grazing": report.grazing_nodes(),
        "longest_length": report.longest_length,
        "pattern_correlation": correlation,
        "pattern_contrast": contrast,
        "steady": report.steady_median,
        "coherent": report.coherent_median,
    });
    if options.lobe != LobeForm::default() {
        material.info["lobe"] = json!("ggx");
    }
    Ok((material, report))
}

/// Of a material that was simulated as a quick look: every how many-th wavelength and direction was.
#[must_use]
pub fn thinned(material: &FeatherMaterial) -> Option<usize> {
    let every = material.info["campaign"]["thinned"].as_u64()?;
    usize::try_from(every).ok()
}

/// Refuses a store of another campaign than the one that a material was fitted to.
///
/// # Errors
/// The campaigns differ, or one of them is not recorded; the message names both, and the caller the store's path.
pub fn check_belongs(material: &FeatherMaterial, store: &Store) -> Result<()> {
    let [theirs, ours] = [store.description(), &material.info["campaign"]].map(CampaignDescription::read);
    if let (Ok(theirs), Ok(ours)) = (&theirs, &ours)
        && theirs == ours
    {
        return Ok(());
    }
    let name = shortened(material.info["name"].as_str().unwrap_or("unknown"));
    Err(Error::input(format!(
        "is of a campaign of {}, not of the one that the material {name} was fitted to; fit the material from this store, or move it away",
        shortened(store.name())
    )))
}

/// An error where a result lacks what is asked for.
fn unrecorded() -> Error {
    Error::input(
        "the barbules that this material was simulated from cannot be made again from what it records; characterize \
         the structure again, or give its sections and `media` as they were then",
    )
    .naming(&["media"])
}
