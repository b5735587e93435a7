//! Materials as people name them: files, or structures whose material ships, is cached or is characterized.

use super::{Opening, material_file, structure};
use crate::brdf::FeatherMaterial;
use crate::brdf::fit::FitOptions;
use crate::characterize::{
    CampaignOptions, Catalog, Execution, Found, Origin, Plan, as_filed, characterize, species_of,
};
use crate::error::shortened;
use crate::material::Library;
use crate::progress::Progress;
use crate::resolve::{Below, Worn};
use crate::structure::Structure;
use crate::{Error, Result};

/// Where a material is.
#[derive(Debug, Clone)]
pub enum Located {
    /// It is there.
    There(Box<Found>),
    /// Nobody made it yet; [`made`] makes it of this.
    Missing(Box<Plan>),
}

/// Opens the material of a file or of a structure, shipped, cached or, where [`Opening::may_compute`], made now and kept.
///
/// # Errors
/// As [`locate`]; a characterization that fails, is interrupted, or is needed and not allowed.
///
/// ```
/// use barbule::Unobserved;
/// use barbule::characterize::Catalog;
/// use barbule::open::{Opening, material};
///
/// # let folder = tempfile::tempdir().unwrap();
/// let catalog = Catalog { cache: Some(folder.path().join("cache")) };
/// let opening = Opening { catalog, may_compute: false, ..Opening::default() };
/// let starling = material("starling:green", &opening, &Unobserved)?; // ships
/// std::fs::write(folder.path().join("mine.barbule"), starling.bytes()?)?;
///
/// let mine = material(&folder.path().join("mine.barbule").to_string_lossy(), &opening, &Unobserved)?;
/// assert_eq!(mine.hash, starling.hash);
/// let missing = material("air/keratin:320/air", &opening, &Unobserved).unwrap_err();
/// assert!(missing.to_string().contains("is not there yet"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn material(text: &str, opening: &Opening, progress: &dyn Progress) -> Result<Found> {
    match locate(text, opening, progress)? {
        Located::There(found) => Ok(*found),
        Located::Missing(plan) if opening.may_compute => made(&plan, opening, progress),
        Located::Missing(_) => Err(Error::input(format!(
            "the material {} is not there yet; characterize its structure, or let it be computed",
            shortened(text)
        ))),
    }
}

/// Where the material of a name or file is; built-in names come before files and folders that are called so. Nothing is
/// simulated.
///
/// # Errors
/// An unknown name, or an unreadable file.
pub fn locate(text: &str, opening: &Opening, progress: &dyn Progress) -> Result<Located> {
    if let Some(found) = material_file(text)? {
        return Ok(Located::There(Box::new(found)));
    }
    material_of(structure(text, opening, progress)?, opening)
}

/// Where the material of a structure is.
///
/// # Errors
/// A shipped file is damaged.
pub fn material_of(structure: Structure, opening: &Opening) -> Result<Located> {
    if let Some(found) = opening.catalog.shipped(&structure)? {
        return Ok(Located::There(Box::new(found)));
    }
    let plan = CampaignOptions { seed: opening.seed, ..CampaignOptions::default() }.plan(structure)?;
    Ok(match opening.catalog.cached(&plan, &FitOptions::default()) {
        Some(found) => Located::There(Box::new(found)),
        None => Located::Missing(Box::new(plan)),
    })
}

/// Characterizes what is missing, and keeps it where [`Catalog::room`](crate::characterize::Catalog::room) is. Where there is
/// none it is only in memory; `progress` hears of a doubt where there was and keeping it fails.
///
/// # Errors
/// As [`characterize`].
pub fn made(plan: &Plan, opening: &Opening, progress: &dyn Progress) -> Result<Found> {
    let (catalog, options) = (&opening.catalog, FitOptions::default());
    let room = catalog.room(plan, &options).ok();
    let how = Execution { resources: opening.resources, ..Execution::default() };
    let made = characterize(plan, &options, catalog, &how, progress)?;
    let (material, hash) = as_filed(&made.material)?;
    let kept = room.map(|_| catalog.keep(plan, &options, &made.material));
    let origin = match kept {
        Some(Ok(path)) => Origin::File(path),
        Some(Err(error)) => {
            progress.doubt(&format!("the material {} is used, but not kept: {error}", plan.structure.name()));
            Origin::Memory
        }
        None => Origin::Memory,
    };
    Ok(Found { material, hash, origin })
}

/// A material ready to be worn, with what is known of the lower sides of its barbules: of species that are alike on both, and of those
/// of which the other side's material ships. `hash` is BLAKE3 of its bytes.
///
/// # Errors
/// As [`Worn::new`].
pub fn worn(material: &FeatherMaterial, hash: String) -> Result<Worn> {
    Ok(Worn { below: below(material), ..Worn::new(material, hash)? })
}

fn below(material: &FeatherMaterial) -> Below {
    let recorded = &material.info["campaign"]["structure"];
    let Some(model) = species_of(material, Library::builtin()) else { return Below::Keratin };
    if model.is_alike_below() {
        return Below::Same;
    }
    let is_upper = recorded["side"].as_str() != Some("below");
    let upper = Structure::Species(Box::new(model));
    let Ok(lower) = upper.clone().underside() else { return Below::Keratin };
    let (own, other) = if is_upper { (upper, lower) } else { (lower, upper) };
    match Catalog::default().shipped(&other) {
        // A user's own media are not those that ship.
        Ok(Some(_)) if own.description() == *recorded => Below::Named(other.name()),
        _ => Below::Keratin,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Unobserved;
    use crate::structure::Side;

    #[test]
    fn shipped_materials_know_their_other_sides() {
        for (stem, bytes) in barbule_birds::materials() {
            let material = crate::io::decode_material(bytes).unwrap();
            let (bird, _) = stem.split_once('-').unwrap();
            let (variant, is_lower) = (material.info["variant"].as_str().unwrap(), stem.ends_with("-below"));
            let expected = match bird {
                "starling" | "bronzewing" => Below::Same,
                // Of the peafowl's eye the upper sides alone ship.
                "peafowl" if variant.starts_with("scaled-") => Below::Keratin,
                "mallard" | "magpie" | "peafowl" => {
                    let end = if is_lower { "" } else { Side::BELOW };
                    Below::Named(format!("{bird}:{variant}{end}"))
                }
                _ => Below::Keratin,
            };
            assert_eq!(below(&material), expected, "{stem}");
        }
        // Made of other media it is another bird.
        let mut own = crate::io::decode_material(barbule_birds::material("mallard-lime").unwrap()).unwrap();
        own.info["campaign"]["structure"]["materials"]["keratin"] = "another".into();
        assert_eq!(below(&own), Below::Keratin);
    }

    #[test]
    fn a_material_is_kept_where_it_can_be_and_used_where_it_cannot() {
        let folder = tempfile::tempdir().unwrap();
        let options = CampaignOptions {
            wavelengths_nm: vec![500.0, 600.0],
            directions: [2, 2],
            instances: Some(2),
            ..CampaignOptions::default()
        };
        let plan = options.plan(Structure::builtin("starling").unwrap()).unwrap();
        let made_in = |cache: std::path::PathBuf| {
            let opening = Opening { catalog: Catalog { cache: Some(cache) }, ..Opening::default() };
            let found = made(&plan, &opening, &Unobserved).unwrap();
            (found, opening.catalog.cached(&plan, &FitOptions::default()))
        };
        let (kept, cached) = made_in(folder.path().join("cache"));
        let cached = cached.unwrap();
        assert_eq!(
            (&kept.material, &kept.hash, &kept.origin),
            (&cached.material, &cached.hash, &cached.origin)
        );
        // A folder that cannot be: in a file.
        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();
        let (unkept, cached) = made_in(file.join("cache"));
        assert!(cached.is_none() && unkept.origin == Origin::Memory);
        assert_eq!((&unkept.material, &unkept.hash), (&kept.material, &kept.hash));
        assert_eq!(unkept.bytes().unwrap(), kept.bytes().unwrap());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    }
}
