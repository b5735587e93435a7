//! What `simulate`, `fit` and `characterize` share: flags, the campaign they describe, the material they make.

use barbule::brdf::FeatherMaterial;
use barbule::brdf::fit::{FitOptions, FitReport, Pattern, fit};
use barbule::campaign::{Campaign, Demand, Keep, Parameters, Results, orders};
use barbule::io::{read_orders, write_orders};
use barbule::math::simd::Width;
use barbule::progress::Progress;
use barbule::scattering::lobe::FitKind;
use barbule::scattering::orders::OrderTable;
use barbule::scattering::statistics::{Axes, Statistics};
use barbule::structure::Structure;
use barbule::{Error, Result};
use clap::ValueEnum;
use serde_json::{Value, json};

use crate::common::Common;
use crate::materials::{cache_folder, file_stem};
use crate::sets;

/// Instances of a thinned campaign.
const THINNED_INSTANCES: usize = 12;

/// Version of what a campaign computes: raised when its numbers change, so that old results are not mistaken for new.
const CAMPAIGN_VERSION: u64 = 2;

/// Flags that say what is simulated.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct CampaignArgs {
    /// Wavelengths in nm
    #[arg(long, value_name = "SET", default_value = "400:694:6")]
    wavelengths: String,
    /// Directions: cosθ_i in N equal steps up to 1, cosφ_i in M
    #[arg(long, value_name = "NxM", default_value = "20x20")]
    directions: String,
    /// Random instances
    #[arg(long, value_name = "N", default_value_t = 50)]
    instances: usize,
    /// Keep both incident polarizations apart in the material
    #[arg(long)]
    polarized: bool,
    /// Largest tilt of an instance about its axis, degrees
    #[arg(long, value_name = "DEG", default_value_t = 2.0)]
    tilt: f64,
    /// Every N-th wavelength and direction only, and 12 instances: a quick look
    #[arg(long, value_name = "N")]
    thin: Option<usize>,
    /// SIMD instructions to compute with [default: the widest of this processor]
    #[arg(long, value_name = "NAME")]
    pub(crate) simd: Option<String>,
}

/// Flags that say how a material is fitted.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct FitArgs {
    /// Longitudinal spread of the lobe
    #[arg(long, value_name = "S", default_value_t = 0.04)]
    sigma: f64,
    /// What the lobe is fitted to
    #[arg(long, value_enum, default_value_t = Kind::Marginal)]
    fit: Kind,
}

/// Readings of the fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Kind {
    /// What the lobe radiates per azimuth
    Marginal,
    /// The lobe on the specular cone itself, as published
    Cone,
}

/// A campaign that has been checked.
pub(crate) struct Planned {
    pub(crate) structure: Structure,
    pub(crate) parameters: Parameters,
    /// Everything that decides the numbers.
    pub(crate) description: Value,
}

impl CampaignArgs {
    /// Checks the flags and describes the campaign.
    pub(crate) fn plan(&self, structure: Structure, common: &Common) -> Result<Planned> {
        let (thetas, phis) = directions(&self.directions)?;
        let mut axes = Axes {
            wavelengths_nm: sets::wavelengths(&self.wavelengths)?,
            cos_theta: steps(thetas),
            cos_phi: steps(phis),
        };
        let mut instances = self.instances;
        if !(1..=10_000).contains(&instances) {
            return Err(Error::input(format!("--instances {instances}: give a number from 1 to 10000")));
        }
        if !(0.0..=30.0).contains(&self.tilt) {
            return Err(Error::input(format!("--tilt {}: give degrees from 0 to 30", self.tilt)));
        }
        if let Some(thin) = self.thin {
            if !(1..=20).contains(&thin) {
                return Err(Error::input(format!("--thin {thin}: give a number from 1 to 20")));
            }
            axes.wavelengths_nm = axes.wavelengths_nm.into_iter().step_by(thin).collect();
            // From the end, so that normal incidence stays.
            let keep = |values: &[f64]| {
                let mut kept: Vec<f64> = values.iter().rev().step_by(thin).copied().collect();
                kept.reverse();
                kept
            };
            axes.cos_theta = keep(&axes.cos_theta);
            axes.cos_phi = keep(&axes.cos_phi);
            instances = instances.min(THINNED_INSTANCES);
        }
        match structure.count() {
            Some(1) => common.say("one section: its instances differ by their tilts only"),
            Some(given) if given < instances => {
                common.say(&format!("{given} sections are all the instances there are"));
                instances = given;
            }
            _ => {}
        }
        let description = json!({
            "campaign_version": CAMPAIGN_VERSION,
            "structure": structure.description(),
            "wavelengths_nm": axes.wavelengths_nm,
            "cos_theta_i": axes.cos_theta,
            "cos_phi_i": axes.cos_phi,
            "instances": instances,
            "seed": common.seed,
            "tilt_deg": self.tilt,
            "polarized": self.polarized,
            "thinned": self.thin,
        });
        let parameters = Parameters { axes, instances, seed: common.seed, tilt: self.tilt.to_radians() };
        Ok(Planned { structure, parameters, description })
    }

    /// The SIMD width asked for.
    pub(crate) fn width(&self) -> Result<Width> {
        self.simd.as_deref().map_or_else(|| Ok(Width::best()), Width::named)
    }
}

impl Planned {
    /// Holds `--memory` against what the campaign will take, before any work: the number of units that may be in work
    /// at once.
    pub(crate) fn units_at_once(
        &self,
        width: Width,
        keep: Keep,
        results: Results,
        common: &Common,
    ) -> Result<usize> {
        if common.memory.is_none() && !common.verbose {
            return Ok(usize::MAX);
        }
        let demand = Demand::predict(&self.structure, &self.parameters, width, keep, results)?;
        let at_once = demand.units_within(common.memory.unwrap_or(u64::MAX))?;
        common.explain(&format!(
            "up to {at_once} units at once, {} MB of memory at most",
            demand.bytes(at_once).div_ceil(1_000_000)
        ));
        Ok(at_once)
    }

    /// Prepares the instances, and that so many units are in work at once.
    pub(crate) fn campaign(
        &self,
        width: Width,
        units_at_once: usize,
        common: &Common,
        progress: &dyn Progress,
    ) -> Result<Campaign> {
        let orders = crystal_orders(&self.structure, &self.parameters.axes, common, progress)?;
        let mut campaign =
            Campaign::with_orders(&self.structure, self.parameters.clone(), orders, width, progress)?;
        campaign.limit_units(units_at_once);
        Ok(campaign)
    }

    /// Illuminations of the whole campaign.
    pub(crate) fn illuminations(&self) -> usize {
        self.parameters.axes.len() * self.parameters.instances * 2
    }
}

/// The orders of a structure's crystal on these axes: from the cache, or solved and kept there.
pub(crate) fn crystal_orders(
    structure: &Structure,
    axes: &Axes,
    common: &Common,
    progress: &dyn Progress,
) -> Result<Option<OrderTable>> {
    let Some(lattice) = structure.lattice() else { return Ok(None) };
    let key = format!("{CAMPAIGN_VERSION} {} {:?} {:?}", lattice.hash(), axes.wavelengths_nm, axes.cos_theta);
    let key = barbule::io::hash_bytes(key.as_bytes());
    // Without a cache the orders are solved every time.
    let folder = cache_folder(common).ok();
    let path = folder.map(|f| f.join(format!("{}-{}.orders", file_stem(&structure.name()), &key[..16])));
    if let Some(found) = path.as_ref().and_then(|path| read_orders(path, &key).ok()) {
        common.explain("the orders of the crystal are in the cache");
        return Ok(Some(found));
    }
    let table = orders(structure, axes, progress)?;
    if let (Some(path), Some(table)) = (&path, &table)
        && let Err(error) = write_orders(path, &key, table)
    {
        common.explain(&format!("the orders of the crystal are not kept: {error}"));
    }
    Ok(table)
}

impl FitArgs {
    /// Refuses values that no fit takes, before any work.
    pub(crate) fn check(&self) -> Result<()> {
        if (0.005..=0.5).contains(&self.sigma) {
            return Ok(());
        }
        Err(Error::input(format!("--sigma {}: give a number from 0.005 to 0.5", self.sigma)))
    }

    /// Fits a material to statistics; `description` is the campaign's.
    pub(crate) fn fit(
        &self,
        statistics: &Statistics,
        name: &str,
        description: &Value,
        progress: &dyn Progress,
    ) -> Result<(FeatherMaterial, FitReport)> {
        self.check()?;
        let options = FitOptions {
            kind: match self.fit {
                Kind::Marginal => FitKind::Marginal,
                Kind::Cone => FitKind::Cone,
            },
            sigma: self.sigma,
            polarized: description["polarized"] == json!(true),
            seed: description["seed"].as_u64().unwrap_or(1),
            info: Value::Null,
        };
        let (mut material, report) = fit(statistics, &options, progress)?;
        let [correlation, contrast] = mean_patterns(&report);
        material.info = json!({
            "name": name,
            "species": description["structure"]["species"],
            "variant": description["structure"]["variant"],
            "tilt_deg": description["tilt_deg"],
            "version": env!("CARGO_PKG_VERSION"),
            "campaign": description,
            "residual_median": report.residual_median,
            "residual_95": report.residual_95,
            "lobes": report.fits,
            "flagged": report.flagged.len(),
            "longest_length": report.longest_length,
            "pattern_correlation": correlation,
            "pattern_contrast": contrast,
        });
        Ok((material, report))
    }
}

/// Says that units were damaged and are computed again.
pub(crate) fn say_repaired(repaired: usize, common: &Common) {
    if repaired > 0 {
        common.say(&format!("{repaired} damaged units were computed again"));
    }
}

/// What a fit says to people.
pub(crate) fn summary(report: &FitReport) -> String {
    let [correlation, contrast] = mean_patterns(report);
    format!(
        "{} lobes fitted: residual {:.3} (median), {:.3} (95th percentile), {} flagged\n\
         l at the longest wavelength, normal incidence: {:.3} (by 1/e lengths {:.3})\n\
         correlation of the polarizations' patterns: {:.3} simulated, {:.3} synthesized\n\
         contrast of unpolarized intensity: {:.3} simulated, {:.3} synthesized",
        report.fits,
        report.residual_median,
        report.residual_95,
        report.flagged.len(),
        report.longest_length[0],
        report.longest_length[1],
        correlation[0],
        correlation[1],
        contrast[0],
        contrast[1],
    )
}

/// Correlation and contrast of the report's patterns, each simulated and synthesized; correlations weighted as they
/// enter the variance of unpolarized light.
fn mean_patterns(report: &FitReport) -> [[f64; 2]; 2] {
    let mean = |value: &dyn Fn(&Pattern) -> f64| {
        report.patterns.iter().map(value).sum::<f64>() / report.patterns.len().max(1) as f64
    };
    let balance = mean(&|p| p.balance).max(f64::MIN_POSITIVE);
    let correlation = [0, 1].map(|side| mean(&|p| p.balance * p.correlation[side]) / balance);
    [correlation, [0, 1].map(|side| mean(&|p| p.contrast[side]))]
}

fn directions(text: &str) -> Result<(usize, usize)> {
    text.split_once('x')
        .and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)))
        .filter(|(a, b)| (2..=200).contains(a) && (2..=200).contains(b))
        .ok_or_else(|| {
            Error::input(format!("--directions {text}: write NxM with 2 to 200 each, as in 20x20"))
        })
}

/// i/count for i = 1 … count.
fn steps(count: usize) -> Vec<f64> {
    (1..=count).map(|i| i as f64 / count as f64).collect()
}
