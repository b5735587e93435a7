//! MATERIAL as people type it: what is said before a long characterization, and where the cache is.

use std::path::PathBuf;

use barbule::brdf::FeatherMaterial;
use barbule::brdf::fit::FitOptions;
use barbule::campaign::{Keep, Resources, Results};
use barbule::characterize::{Barbules, Catalog, Found, Plan};
use barbule::error::shortened;
use barbule::io::make_folder;
use barbule::open::{self, Located, Opening};
use barbule::{Error, Result};

use crate::arguments::spoken;
use crate::campaign::{expected, explain_sides, say_given, units_at_once};
use crate::common::Common;
use crate::progress::Terminal;
use crate::structure_arg;

/// What every MATERIAL argument says in `--help`.
pub(crate) const HELP: &str = "A material file, or a structure, which is characterized on first use: SPECIES[:VARIANT], a stack as in 'air/keratin:595/air', a section .json, a species or lattice .toml, or a folder of sections";

/// The material of a name or file, and BLAKE3 of its bytes: a material file, or any structure, shipped or else
/// characterized into the cache on first use (its duration is said first). Where it cannot be kept it is used all the same.
///
/// # Errors
/// Unknown name, unreadable file, or a characterization that fails or is interrupted.
pub(crate) fn find(name: &str, common: &Common) -> Result<(FeatherMaterial, String)> {
    let found = match locate(name, common)? {
        Located::There(found) => *found,
        Located::Missing(plan) => make(&plan, common)?,
    };
    Ok((found.material, found.hash))
}

/// Where the material of a name or file is, as [`open::locate`] has it; structures are opened by [`structure_arg::parse`].
///
/// # Errors
/// Unknown name, or unreadable file.
pub(crate) fn locate(name: &str, common: &Common) -> Result<Located> {
    match open::material_file(name)? {
        Some(found) => Ok(Located::There(Box::new(found))),
        None => open::material_of(structure_arg::parse(name, common)?, &common.opening()?),
    }
}

/// Characterizes what is missing, and keeps it where the cache can be written.
fn make(plan: &Plan, common: &Common) -> Result<Found> {
    say_given(plan, common);
    explain_sides(plan, common);
    let opening = common.opening()?;
    let room = known_folder(common).and_then(|_| opening.catalog.room(plan, &FitOptions::default()));
    let kept = match &room {
        Ok(path) => format!("it is kept as {}", path.display()),
        Err(error) => format!("it cannot be kept: {}", spoken(error)),
    };
    let (name, time) = (plan.structure.name(), expected(plan));
    common
        .say(&format!("the material {name} is not there yet: characterizing it takes about {time}; {kept}"));
    let units_at_once = units_at_once(plan, Keep::Statistics, Results::Gathered, common)?;
    let resources = Resources { units_at_once, ..Resources::default() };
    open::made(plan, &Opening { resources, ..opening }, &Terminal::new(common))
}

/// The barbules that a material was made of, made again.
///
/// # Errors
/// As [`Barbules::of`].
pub(crate) fn barbules(material: &FeatherMaterial, common: &Common) -> Result<Barbules> {
    let given = |name: &str| structure_arg::parse(name, common);
    Barbules::of(material, common.opening()?.media.library().clone(), &given, catalog(common))
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

/// Where the cache is: `--cache`, else the usual one.
pub(crate) fn known_folder(common: &Common) -> Result<PathBuf> {
    common.cache.clone().map_or_else(usual_cache_folder, Ok)
}

/// Where the cache is if nobody says otherwise: `$XDG_CACHE_HOME/barbule`, `%LOCALAPPDATA%\barbule` or `~/.cache/barbule`.
///
/// # Errors
/// None is known, or the variable names a place that changes with the working folder.
pub fn usual_cache_folder() -> Result<PathBuf> {
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
