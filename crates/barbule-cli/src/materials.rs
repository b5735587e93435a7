//! Finding a material: shipped with the program, computed into the cache, or a user's file.

use std::path::{Path, PathBuf};

use barbule::brdf::FeatherMaterial;
use barbule::brdf::fit::FitOptions;
use barbule::campaign::{Keep, Resources, Results};
use barbule::characterize::{
    Barbules, CampaignOptions, Catalog, Execution, Found, Plan, as_filed, characterize,
};
use barbule::error::shortened;
use barbule::io::{InputKind, check_writable, kind_of, make_folder};
use barbule::{Error, Result};

use crate::campaign::{expected, explain_sides, say_given, units_at_once};
use crate::common::Common;
use crate::progress::Terminal;
use crate::structure_arg;

/// What every MATERIAL argument says in `--help`.
pub(crate) const HELP: &str = "A material file, or a structure, which is characterized on first use: SPECIES[:VARIANT], a stack as in 'air/keratin:595/air', a section .json, a species or lattice .toml, or a folder of sections";

/// Where the material of a name is.
pub(crate) enum Place {
    /// It is there.
    There(Box<Found>),
    /// Nobody made it yet; this does.
    Missing(Box<Plan>),
}

/// The material of a name or file, and BLAKE3 of its bytes: a material file, or any structure, shipped or else
/// characterized into the cache on first use (its duration is said first). Where it cannot be kept it is used all the same.
///
/// # Errors
/// Unknown name, unreadable file, or a characterization that fails or is interrupted.
pub(crate) fn find(name: &str, common: &Common) -> Result<(FeatherMaterial, String)> {
    match locate(name, common)? {
        Place::There(found) => Ok((found.material, found.hash)),
        Place::Missing(plan) => make(*plan, common),
    }
}

/// Where the material of a name or file is; built-in names come before files and folders that are called so.
///
/// # Errors
/// Unknown name, or unreadable file.
pub(crate) fn locate(name: &str, common: &Common) -> Result<Place> {
    let path = Path::new(name);
    let is_named = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("barbule"));
    if !structure_arg::is_built_in(name) && (is_named || path.is_file()) {
        // A damaged material is refused as one.
        if is_named || kind_of(path)? == InputKind::Material {
            return Ok(Place::There(Box::new(Found::in_file(path)?)));
        }
    }
    let structure = structure_arg::parse(name, common)?;
    let catalog = catalog(common);
    if let Some(found) = catalog.shipped(&structure)? {
        return Ok(Place::There(Box::new(found)));
    }
    let plan = CampaignOptions { seed: common.seed, ..CampaignOptions::default() }.plan(structure)?;
    Ok(match catalog.cached(&plan, &FitOptions::default()) {
        Some(found) => Place::There(Box::new(found)),
        None => Place::Missing(Box::new(plan)),
    })
}

/// Characterizes what is missing, and keeps it where the cache can be written.
fn make(plan: Plan, common: &Common) -> Result<(FeatherMaterial, String)> {
    let (catalog, options) = (catalog(common), FitOptions::default());
    say_given(&plan, common);
    explain_sides(&plan, common);
    let place = known_folder(common).and_then(|folder| {
        make_folder(&folder)?;
        let path = catalog.path(&plan, &options)?;
        check_writable(&path).map(|()| path)
    });
    let kept = match &place {
        Ok(path) => format!("it is kept as {}", path.display()),
        Err(error) => format!("it cannot be kept: {error}"),
    };
    let (name, time) = (plan.structure.name(), expected(&plan));
    common
        .say(&format!("the material {name} is not there yet: characterizing it takes about {time}; {kept}"));
    let units_at_once = units_at_once(&plan, Keep::Statistics, Results::Gathered, common)?;
    let resources = Resources { units_at_once, ..Resources::default() };
    let how = Execution { resources, ..Execution::default() };
    let made = characterize(&plan, &options, &catalog, &how, &Terminal::new(common))?;
    if place.is_ok()
        && let Err(error) = catalog.keep(&plan, &options, &made.material)
    {
        common.say(&format!("the material {name} is used, but not kept: {error}"));
    }
    as_filed(&made.material)
}

/// The barbules that a material was made of, made again.
///
/// # Errors
/// As [`Barbules::of`].
pub(crate) fn barbules(material: &FeatherMaterial, common: &Common) -> Result<Barbules> {
    let given = |name: &str| structure_arg::parse(name, common);
    Barbules::of(material, common.library()?, &given, catalog(common))
}

/// Shipped materials, and the cache where one is known.
pub(crate) fn catalog(common: &Common) -> Catalog {
    Catalog { cache: known_folder(common).ok() }
}

/// The cache folder, which is made when it is not there.
pub(crate) fn cache_folder(common: &Common) -> Result<PathBuf> {
    let folder = known_folder(common)?;
    make_folder(&folder)?;
    Ok(folder)
}

/// Where the cache is: `--cache`, else `$XDG_CACHE_HOME/barbule`, `~/.cache/barbule`, or `%LOCALAPPDATA%\barbule`.
///
/// # Errors
/// None is known, or the variable names a place that changes with the working folder.
pub(crate) fn known_folder(common: &Common) -> Result<PathBuf> {
    if let Some(folder) = &common.cache {
        return Ok(folder.clone());
    }
    for (name, below) in [("XDG_CACHE_HOME", ""), ("LOCALAPPDATA", ""), ("HOME", ".cache")] {
        let Some(base) = std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from) else {
            continue;
        };
        if !base.is_absolute() {
            return Err(Error::input(format!(
                "{name} is '{}', but must be an absolute path; mend it, or give the cache with --cache",
                shortened(&base.to_string_lossy())
            )));
        }
        return Ok(base.join(below).join("barbule"));
    }
    Err(Error::input("no cache folder is known here; give one with --cache"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::structure::Structure;
    use clap::Parser;

    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        common: Common,
    }

    #[test]
    fn a_material_is_kept_where_it_can_be_and_used_where_it_cannot() {
        let folder = tempfile::tempdir().unwrap();
        let options = CampaignOptions {
            wavelengths_nm: vec![500.0, 600.0],
            directions: [2, 2],
            instances: 2,
            ..CampaignOptions::default()
        };
        let plan = options.plan(Structure::builtin("starling").unwrap()).unwrap();
        let made = |cache: &Path| {
            let words = ["x", "--quiet", "--cache", &cache.to_string_lossy()].map(str::to_owned);
            make(plan.clone(), &Line::try_parse_from(words).unwrap().common).unwrap()
        };
        let cache = folder.path().join("cache");
        let kept = made(&cache);
        let catalog = Catalog { cache: Some(cache.clone()) };
        let found = catalog.cached(&plan, &FitOptions::default()).unwrap();
        assert_eq!(kept, (found.material, found.hash));
        // A folder that cannot be: in a file.
        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();
        assert_eq!(made(&file.join("cache")), kept);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    }
}
