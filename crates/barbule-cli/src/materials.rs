//! Finding a material: shipped with the program, computed into the cache, or a user's file.

use std::path::{Path, PathBuf};

use barbule::brdf::FeatherMaterial;
use barbule::brdf::fit::FitOptions;
use barbule::campaign::{Keep, Resources, Results};
use barbule::characterize::{Barbules, CampaignOptions, Catalog, Execution, Found, characterize};
use barbule::io::read_material;
use barbule::progress::Progress;
use barbule::{Error, Result};

use crate::campaign::{compare_sides, expected, plan, units_at_once};
use crate::common::Common;
use crate::progress::Terminal;
use crate::structure_arg;

/// The material of a name or file, and BLAKE3 of its bytes: `FILE.barbule`, or SPECIES[:VARIANT], shipped or else
/// characterized into the cache on first use (its duration is said first).
///
/// # Errors
/// Unknown name, unreadable file, or a characterization that fails or is interrupted.
pub(crate) fn find(name: &str, common: &Common) -> Result<(FeatherMaterial, String)> {
    let path = Path::new(name);
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("barbule")) || path.is_file() {
        let material = read_material(path)?;
        let hash = barbule::io::hash_file(path)?;
        return Ok((material, hash));
    }
    let structure = structure_arg::parse(name, common)?;
    if let Some(Found { material, hash }) = Catalog::default().shipped(&structure)? {
        return Ok((material, hash));
    }
    let catalog = Catalog { cache: Some(cache_folder(common)?) };
    let mut plan =
        plan(&CampaignOptions { seed: common.seed, ..CampaignOptions::default() }, structure, common)?;
    if let Some(Found { material, hash }) = catalog.cached(&plan) {
        return Ok((material, hash));
    }
    common.say(&format!(
        "the material {} is not there yet: characterizing it takes about {}",
        plan.structure.name(),
        expected(&plan)
    ));
    compare_sides(&mut plan, common)?;
    let units_at_once = units_at_once(&plan, Keep::Statistics, Results::Gathered, common)?;
    let resources = Resources { units_at_once, ..Resources::default() };
    let how = Execution { resources, ..Execution::default() };
    let made = characterize(&plan, &FitOptions::default(), &catalog, &how, &Terminal::new(common))?;
    let Found { material, hash } = catalog.keep(&plan, &made.material)?;
    Ok((material, hash))
}

/// The barbules that a material was made of, made again.
///
/// # Errors
/// As [`Barbules::of`].
pub(crate) fn barbules<'a>(
    material: &FeatherMaterial,
    catalog: &'a Catalog,
    progress: &'a dyn Progress,
    common: &Common,
) -> Result<Barbules<'a>> {
    let given = |name: &str| structure_arg::parse(name, common);
    Barbules::of(material, common.library()?, &given, catalog, progress)
}

/// Shipped materials, and the cache where one is known.
pub(crate) fn catalog(common: &Common) -> Catalog {
    Catalog { cache: known_folder(common).ok() }
}

/// The cache folder, which is made when it is not there.
pub(crate) fn cache_folder(common: &Common) -> Result<PathBuf> {
    let folder = known_folder(common)?;
    barbule::io::make_folder(&folder)?;
    Ok(folder)
}

/// Where the cache is: `--cache`, else `$XDG_CACHE_HOME/barbule`, `~/.cache/barbule`, or `%LOCALAPPDATA%\barbule`.
fn known_folder(common: &Common) -> Result<PathBuf> {
    if let Some(folder) = &common.cache {
        return Ok(folder.clone());
    }
    let variable = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    variable("XDG_CACHE_HOME")
        .or_else(|| variable("LOCALAPPDATA"))
        .or_else(|| variable("HOME").map(|home| home.join(".cache")))
        .map(|base| base.join("barbule"))
        .ok_or_else(|| Error::input("no cache folder is known here; give one with --cache"))
}
