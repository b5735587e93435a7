//! Finding a material: shipped with the program, computed into the cache, or a user's file.

use std::path::{Path, PathBuf};

use barbule::brdf::{FeatherMaterial, example};
use barbule::campaign::{Campaign, Keep, Parameters, Results, statistics};
use barbule::io::{decode_material, read_material, write_material};
use barbule::math::simd::Width;
use barbule::scattering::far_field::Window;
use barbule::scattering::statistics::Axes;
use barbule::solve::surface::{Barbule, CAMPAIGN_ELEMENT_UM};
use barbule::structure::{SpeciesModel, Structure};
use barbule::{Error, Result};
use clap::Parser;

use crate::campaign::{CampaignArgs, FitArgs, Planned, crystal_orders};
use crate::common::Common;
use crate::progress::Terminal;
use crate::structure_arg;

/// Illuminations per second and core of a starling's barbule, to foretell durations (`barbule bench campaign`).
const TYPICAL_SPEED: f64 = 10_000.0;

/// The width that [`TYPICAL_SPEED`] was measured with, µm.
const TYPICAL_WIDTH_UM: f64 = 25.0;

/// The defaults of the flags of a campaign and a fit.
#[derive(Debug, Parser)]
struct Defaults {
    #[command(flatten)]
    campaign: CampaignArgs,
    #[command(flatten)]
    fit: FitArgs,
}

/// The material of a name or file, and BLAKE3 of its bytes: `FILE.barbule`, or SPECIES[:VARIANT], shipped or else
/// characterized into the cache on first use (its duration is said first), or `example`, a made-up one.
///
/// # Errors
/// Unknown name, unreadable file, or a characterization that fails or is interrupted.
pub(crate) fn find(name: &str, common: &Common) -> Result<(FeatherMaterial, String)> {
    if name == "example" {
        return Ok((example(50), barbule::io::hash_bytes(name.as_bytes())));
    }
    let path = Path::new(name);
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("barbule")) || path.is_file() {
        let material = read_material(path)?;
        let hash = barbule::io::hash_file(path)?;
        return Ok((material, hash));
    }
    let structure = structure_arg::parse(name, common)?;
    let stem = file_stem(&structure.name());
    if let (Structure::Species(_), Some(bytes)) = (&structure, barbule_materials::material(&stem)) {
        let material = decode_material(bytes).map_err(|e| e.at(format!("the shipped material {stem}")))?;
        // A user's own species may bear the name of a built-in one.
        if material.info["campaign"]["structure"] == structure.description() {
            return Ok((material, barbule::io::hash_bytes(bytes)));
        }
    }
    let cached = cache_path(common, &structure.name())?;
    let defaults = Defaults::try_parse_from(["defaults"]).map_err(|e| Error::machine(e.to_string()))?;
    let name = structure.name();
    let planned = defaults.campaign.plan(structure, common)?;
    if cached.is_file()
        && let Ok(material) = read_material(&cached)
        && material.info["campaign"] == planned.description
    {
        return Ok((material, barbule::io::hash_file(&cached)?));
    }
    common.say(&format!(
        "the material {name} is not there yet: characterizing it takes about {}",
        expected(&planned)
    ));
    let width = defaults.campaign.width()?;
    let at_once = planned.units_at_once(width, Keep::Statistics, Results::Gathered, common)?;
    let progress = Terminal::new(common);
    let campaign = planned.campaign(width, at_once, common, &progress)?;
    let statistics = statistics(&campaign, &progress)?;
    let (material, _) = defaults.fit.fit(&statistics, &name, &planned.description, &progress)?;
    write_material(&cached, &material)?;
    Ok((material, barbule::io::hash_file(&cached)?))
}

/// The structure that a material was made of, from what the material records.
///
/// # Errors
/// It records too little, or its sections or media are not to be had any more or have changed.
pub(crate) fn structure_of(material: &FeatherMaterial, common: &Common) -> Result<Structure> {
    let recorded = &material.info["campaign"]["structure"];
    let text = |key: &str| recorded[key].as_str().unwrap_or_default();
    let structure = if recorded["parameters"].is_object() {
        let model = SpeciesModel::from_parameters(
            text("species"),
            text("variant"),
            &recorded["parameters"],
            common.library()?,
        );
        model.ok().map(|model| Structure::Species(Box::new(model)))
    } else {
        Some(text("sections"))
            .filter(|name| !name.is_empty())
            .and_then(|name| structure_arg::parse(name, common).ok())
    };
    structure.filter(|structure| structure.description() == *recorded).ok_or_else(|| {
        Error::input(
            "the barbules that this material was simulated from cannot be made again from what it records; characterize \
             the structure again, or give its sections and --medium as they were then",
        )
    })
}

/// The campaign that a material was made in, on other axes; with fewer instances or without tilt where asked.
pub(crate) fn campaign_of(
    material: &FeatherMaterial,
    axes: Axes,
    instances: Option<usize>,
    tilted: bool,
    common: &Common,
) -> Result<Campaign> {
    let structure = structure_of(material, common)?;
    let made = &material.info["campaign"];
    let recorded =
        made["instances"].as_u64().and_then(|n| usize::try_from(n).ok()).unwrap_or(1).clamp(1, 10_000);
    let mut instances = instances.unwrap_or(recorded).max(1);
    if let Some(count) = structure.count().filter(|count| *count > 1) {
        instances = instances.min(count);
    }
    let tilt =
        if tilted { made["tilt_deg"].as_f64().unwrap_or(0.0).clamp(0.0, 30.0).to_radians() } else { 0.0 };
    let parameters = Parameters { axes, instances, seed: made["seed"].as_u64().unwrap_or(1), tilt };
    let progress = Terminal::new(common);
    let orders = crystal_orders(&structure, &parameters.axes, common, &progress)?;
    Campaign::with_orders(&structure, parameters, orders, Width::best(), &progress)
}

/// The duration to expect of a campaign, in words.
pub(crate) fn expected(planned: &Planned) -> String {
    let slots = planned
        .structure
        .instance(planned.parameters.seed, 0)
        .and_then(|section| Barbule::new(&section, CAMPAIGN_ELEMENT_UM, Window::Gaussian))
        .map_or(6, |barbule| barbule.slots());
    // Each ray crosses all layers, and structures of many layers need many rays.
    let layers = 0.9 + 0.000_33 * (slots * slots) as f64;
    let work = planned.structure.width_um() / TYPICAL_WIDTH_UM * layers;
    let cores = rayon::current_num_threads() as f64;
    let seconds = planned.illuminations() as f64 * work / (TYPICAL_SPEED * cores);
    match seconds {
        s if s < 60.0 => format!("{:.0} s", s.max(1.0)),
        s => format!("{:.0} min", (s / 60.0).ceil()),
    }
}

/// A file name for a structure: `starling:green` → `starling-green`.
pub(crate) fn file_stem(name: &str) -> String {
    let last = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let stem: String = last
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' })
        .take(100)
        .collect();
    if stem.is_empty() { "material".into() } else { stem }
}

/// Where a computed material goes.
pub(crate) fn cache_path(common: &Common, name: &str) -> Result<PathBuf> {
    Ok(cache_folder(common)?.join(format!("{}.barbule", file_stem(name))))
}

/// The cache folder, which is made when it is not there: `--cache`, else `$XDG_CACHE_HOME/barbule`,
/// `~/.cache/barbule`, or `%LOCALAPPDATA%\barbule`.
pub(crate) fn cache_folder(common: &Common) -> Result<PathBuf> {
    let folder = match &common.cache {
        Some(folder) => folder.clone(),
        None => {
            let variable = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
            variable("XDG_CACHE_HOME")
                .or_else(|| variable("LOCALAPPDATA"))
                .or_else(|| variable("HOME").map(|home| home.join(".cache")))
                .map(|base| base.join("barbule"))
                .ok_or_else(|| Error::input("no cache folder is known here; give one with --cache"))?
        }
    };
    barbule::io::make_folder(&folder)?;
    Ok(folder)
}
