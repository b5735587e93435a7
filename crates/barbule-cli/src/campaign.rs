//! Flags of `simulate`, `fit` and `characterize`, and what these say to people.

use barbule::brdf::check_sigma;
use barbule::brdf::fit::{FitOptions, FitReport, LobeForm};
use barbule::campaign::{Demand, Keep, Results};
use barbule::characterize::{CampaignOptions, Plan};
use barbule::error::shortened;
use barbule::math::simd::Width;
use barbule::progress::Unobserved;
use barbule::scattering::lobe::FitKind;
use barbule::solve::surface::LARGEST_MIRROR_ERROR;
use barbule::structure::{Structure, Symmetry};
use barbule::{Error, Result};
use clap::ValueEnum;

use crate::common::{Common, duration};
use crate::sets;

/// Flags that say what is simulated.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct CampaignArgs {
    /// Wavelengths in nm
    #[arg(long, value_name = "SET", default_value_t = sets::written(&CampaignOptions::default().wavelengths_nm))]
    wavelengths: String,
    /// Directions: cosθ_i in N equal steps up to 1, cosφ_i in M
    #[arg(long, value_name = "NxM", default_value_t = usual_directions())]
    directions: String,
    /// Random instances [default: 50, with --thin 12]
    #[arg(long, value_name = "N")]
    instances: Option<usize>,
    /// Keep both incident polarizations apart in the material
    #[arg(long)]
    polarized: bool,
    /// Largest tilt of an instance about its axis, degrees
    #[arg(long, value_name = "DEG", default_value_t = CampaignOptions::default().tilt_deg)]
    tilt: f64,
    /// Every N-th wavelength and direction only, and 12 instances unless --instances says another number: a quick look
    #[arg(long, value_name = "N")]
    thin: Option<usize>,
    /// Barbules lie either way round: each instance counts with its mirror image, and both sides are alike
    #[arg(long)]
    mirror: bool,
    /// SIMD instructions to compute with [default: the widest of this processor]
    #[arg(long, value_name = "NAME", value_parser = Width::named)]
    simd: Option<Width>,
}

/// Flags that say how a material is fitted.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct FitArgs {
    /// Longitudinal spread of the lobe
    #[arg(long, value_name = "S", default_value_t = FitOptions::default().sigma)]
    sigma: f64,
    /// What the lobe is fitted to
    #[arg(long, value_enum, default_value_t = Kind::Marginal)]
    fit: Kind,
    /// What stands for the mean intensity
    #[arg(long, value_enum, default_value_t = Lobe::Pair)]
    lobe: Lobe,
}

/// Readings of the fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// What the lobe radiates per azimuth
    Marginal,
    /// The lobe on the specular cone itself, as published
    Cone,
}

/// Forms of the mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Lobe {
    /// Two GGX lobes
    Pair,
    /// A single GGX lobe, as published
    Ggx,
}

impl CampaignArgs {
    /// Checks the flags and describes the campaign.
    pub(crate) fn plan(&self, structure: Structure, common: &Common) -> Result<Plan> {
        let options = CampaignOptions {
            wavelengths_nm: sets::wavelengths(&self.wavelengths)?,
            directions: directions(&self.directions)?,
            instances: self.instances,
            tilt_deg: self.tilt,
            polarized: self.polarized,
            thin: self.thin,
            seed: common.seed,
            mirror: self.mirror,
        };
        // Options are called as their flags.
        options.check().map_err(|e| Error::input(format!("--{e}")))?;
        let plan = options.plan(structure)?;
        if self.mirror && !plan.parameters.mirror {
            let why = format!("{} is its own mirror image, each or in the mean", plan.structure.name());
            common.idle("--mirror", &why);
        }
        say_given(&plan, common);
        explain_sides(&plan, common);
        Ok(plan)
    }

    /// The SIMD width asked for.
    pub(crate) fn width(&self) -> Width {
        self.simd.unwrap_or_default()
    }
}

/// Says where given sections are fewer than the instances asked for.
pub(crate) fn say_given(plan: &Plan, common: &Common) {
    match plan.structure.count() {
        Some(1) => common.say("one section: its instances differ by their tilts only"),
        Some(given) if given < plan.asked => {
            common.say(&format!("{given} sections are all the instances there are"));
        }
        _ => {}
    }
}

/// Holds what may be taken in memory against what a campaign will take, before any work: the number of units that may be
/// in work at once.
pub(crate) fn units_at_once(plan: &Plan, keep: Keep, results: Results, common: &Common) -> Result<usize> {
    let allowed = common.allowance();
    let Plan { structure, parameters, .. } = plan;
    if !common.verbose {
        return Demand::units_allowed(structure, parameters, keep, results, allowed);
    }
    let demand = Demand::predict(structure, parameters, keep, results, allowed, &Unobserved)?;
    let at_once = demand.units_within(allowed)?;
    common.explain(&format!(
        "up to {at_once} units at once, {} MB of memory at most",
        demand.bytes(at_once).div_ceil(1_000_000)
    ));
    Ok(at_once)
}

/// Explains why both signs of φ_i are simulated.
pub(crate) fn explain_sides(plan: &Plan, common: &Common) {
    if let Symmetry::OneSided(why) = &plan.symmetry {
        let then = if plan.parameters.mirror { "; each instance counts with its mirror image" } else { "" };
        common.explain(&format!("both signs of φ_i are simulated: {why}{then}"));
    }
}

/// What is said where light grazes: what a flat perfect mirror as wide would reflect.
pub(crate) fn grazing(incidence: &str, wavelength_nm: f64, width_um: f64, mirror_fraction: f64) -> String {
    let reflected = match mirror_fraction {
        r if r < 100.0 => format!("{r:.2}"),
        r => format!("{r:.1e}"),
    };
    format!(
        "at {incidence} and {wavelength_nm} nm a flat mirror {width_um} µm wide would reflect {reflected} of the light: the simulation is that far off so near grazing"
    )
}

/// The duration to expect of a campaign, in words.
pub(crate) fn expected(plan: &Plan) -> String {
    duration(plan.seconds(rayon::current_num_threads()))
}

impl FitArgs {
    /// Checks the flags.
    pub(crate) fn options(&self) -> Result<FitOptions> {
        check_sigma(self.sigma).map_err(|e| e.at("--sigma"))?;
        let kind = match self.fit {
            Kind::Marginal => FitKind::Marginal,
            Kind::Cone => FitKind::Cone,
        };
        let lobe = match self.lobe {
            Lobe::Pair => LobeForm::Pair,
            Lobe::Ggx => LobeForm::Ggx,
        };
        Ok(FitOptions { kind, lobe, sigma: self.sigma, ..FitOptions::default() })
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
    let [correlation, contrast] = report.mean_patterns();
    let pair = |[simulated, synthesized]: [f64; 2]| {
        if simulated.is_finite() && synthesized.is_finite() {
            format!("{simulated:.3} simulated, {synthesized:.3} synthesized")
        } else {
            "none, since nothing is reflected".to_owned()
        }
    };
    let mut text = format!(
        "{} mean intensities fitted: residual {:.3} (median), {:.3} (95th percentile), {} flagged\n\
         where cosθ_i cosφ_i ≥ 0.1: residual {:.3} (median), {:.3} (95th percentile)\n\
         steady part {:.2} (median), of the mean field alone {:.2}\n\
         l at the longest wavelength, normal incidence: {:.3} (by 1/e lengths {:.3})\n\
         correlation of the polarizations' patterns: {}\n\
         contrast of unpolarized intensity: {}",
        report.fits,
        report.residual_median,
        report.residual_95,
        report.flagged.len(),
        report.residual_off_grazing[0],
        report.residual_off_grazing[1],
        report.steady_median,
        report.coherent_median,
        report.longest_length[0],
        report.longest_length[1],
        pair(correlation),
        pair(contrast),
    );
    for (part, found) in
        ["about the mirror direction", "on the shoulders", "in the wings"].iter().zip(report.mean_regions())
    {
        if let Some(found) = found {
            text += &format!("\ncontrast of one polarization {part}: {}", pair(found));
        }
    }
    let errors = report.spectral;
    text += &format!(
        "\ncorrelation of instances between wavelengths: off by {:.2} in the mirror direction, {:.2} beside it; between lights by {:.2}",
        errors.mirror, errors.beside, errors.turned
    );
    if !report.grazing.is_empty() {
        text += &format!(
            "\n{} wavelengths and directions are so near grazing that the simulation would be over {:.0} % off for a flat mirror",
            report.grazing_nodes(),
            100.0 * LARGEST_MIRROR_ERROR
        );
    }
    if !report.clipped.is_empty() {
        text += &format!("\n{} reflected over all light and are clipped to 1", report.clipped.len());
    }
    text
}

fn usual_directions() -> String {
    let [thetas, phis] = CampaignOptions::default().directions;
    format!("{thetas}x{phis}")
}

fn directions(text: &str) -> Result<[usize; 2]> {
    text.split_once('x').and_then(|(a, b)| Some([a.trim().parse().ok()?, b.trim().parse().ok()?])).ok_or_else(
        || {
            Error::input(format!(
                "--directions {}: write NxM with 2 to 200 each, as in 20x20",
                shortened(text)
            ))
        },
    )
}
