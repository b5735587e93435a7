//! Finished materials and tables: those that ship, and those in a cache folder.

use std::path::PathBuf;

use super::{CAMPAIGN_VERSION, Plan};
use crate::brdf::FeatherMaterial;
use crate::campaign::orders;
use crate::identity::Hasher;
use crate::io::{
    decode_material, hash_bytes, hash_file, make_folder, read_material, read_orders, write_material,
    write_orders,
};
use crate::progress::Progress;
use crate::scattering::orders::OrderTable;
use crate::scattering::statistics::Axes;
use crate::structure::{Lattice, Structure};
use crate::{Error, Result};

/// The shipped materials, and a cache of computed ones.
#[derive(Debug, Clone, Default)]
pub struct Catalog {
    /// Folder of computed materials and tables, made when it is written to; `None`: nothing is kept.
    pub cache: Option<PathBuf>,
}

/// A material that is there.
#[derive(Debug, Clone)]
pub struct Found {
    /// The material.
    pub material: FeatherMaterial,
    /// BLAKE3 of its file's bytes, hexadecimal.
    pub hash: String,
}

impl Catalog {
    /// The shipped material of a structure, at the default options.
    ///
    /// # Errors
    /// A shipped file is damaged.
    pub fn shipped(&self, structure: &Structure) -> Result<Option<Found>> {
        let stem = file_stem(&structure.name());
        let (Structure::Species(_), Some(bytes)) = (structure, barbule_materials::material(&stem)) else {
            return Ok(None);
        };
        let material = decode_material(bytes).map_err(|e| e.at(format!("the shipped material {stem}")))?;
        let recorded = &material.info["campaign"]["structure"];
        // A user's own species may bear the name of a built-in one.
        let is_it = *recorded == structure.description_like(recorded);
        Ok(is_it.then(|| Found { hash: hash_bytes(bytes), material }))
    }

    /// The cached material of a plan.
    #[must_use]
    pub fn cached(&self, plan: &Plan) -> Option<Found> {
        let path = self.path(&plan.structure.name()).ok().filter(|path| path.is_file())?;
        let material = read_material(&path).ok()?;
        let is_it = plan.description.is_recorded(&material.info["campaign"], &plan.structure);
        is_it.then(|| Some(Found { hash: hash_file(&path).ok()?, material }))?
    }

    /// Keeps a plan's material in the cache, and gives it as it is found from then on: files round its parameters to sixteen
    /// bits, and the first picture must be the bits of all later ones.
    ///
    /// # Errors
    /// There is no cache, or it cannot be written.
    pub fn keep(&self, plan: &Plan, material: &FeatherMaterial) -> Result<Found> {
        let path = self.path(&plan.structure.name())?;
        path.parent().map_or(Ok(()), make_folder)?;
        write_material(&path, material)?;
        Ok(Found { hash: hash_file(&path)?, material: read_material(&path)? })
    }

    /// Where the computed material of a structure's name is.
    ///
    /// # Errors
    /// There is no cache.
    pub fn path(&self, name: &str) -> Result<PathBuf> {
        let folder = self.cache.as_ref().ok_or_else(|| Error::input("no cache folder is given; give one"))?;
        Ok(folder.join(format!("{}.barbule", file_stem(name))))
    }

    /// The orders of a structure's crystal on these axes, from the cache or solved and kept there; `None` for layers.
    ///
    /// # Errors
    /// A medium's table does not reach a wavelength, the series does not settle, or a stop by `progress`.
    pub fn orders(
        &self,
        structure: &Structure,
        axes: &Axes,
        progress: &dyn Progress,
    ) -> Result<Option<OrderTable>> {
        let Some(lattice) = structure.lattice() else { return Ok(None) };
        let stem = file_stem(&structure.name());
        // Without a cache the orders are solved every time.
        let folder = self.cache.as_ref().filter(|folder| make_folder(folder).is_ok());
        let path = |key: &str| folder.map(|f| f.join(format!("{stem}-{}.orders", &key[..16])));
        let read = |key: &str| path(key).and_then(|path| read_orders(&path, key).ok());
        let [key, legacy] = order_keys(&lattice, axes);
        if let Some(found) = read(&key).or_else(|| read(&legacy)) {
            progress.note("the orders of the crystal are in the cache");
            return Ok(Some(found));
        }
        let table = orders(structure, axes, progress)?;
        if let (Some(path), Some(table)) = (path(&key), &table)
            && let Err(error) = write_orders(&path, &key, table)
        {
            progress.note(&format!("the orders of the crystal are not kept: {error}"));
        }
        Ok(table)
    }
}

/// What names a table of orders: now, and in version 0.1.0.
fn order_keys(lattice: &Lattice, axes: &Axes) -> [String; 2] {
    let (wavelengths_nm, cos_theta) = (axes.wavelengths_nm(), axes.cos_theta());
    let key = Hasher::new("orders")
        .count("campaign", CAMPAIGN_VERSION)
        .part("lattice", lattice)
        .numbers("wavelengths_nm", wavelengths_nm)
        .numbers("cos_theta", cos_theta)
        .hex();
    let legacy = format!("2 {} {wavelengths_nm:?} {cos_theta:?}", lattice.legacy_hash());
    [key, hash_bytes(legacy.as_bytes())]
}

/// A file name for a structure: `starling:green` → `starling-green`.
#[must_use]
pub fn file_stem(name: &str) -> String {
    let last = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let stem: String = last
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' })
        .take(100)
        .collect();
    if stem.is_empty() { "material".into() } else { stem }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::characterize::CampaignOptions;
    use crate::material::Library;
    use crate::spectrum::Wavelengths;
    use crate::structure::SpeciesModel;

    #[test]
    fn tables_of_version_0_1_are_found_by_their_names() {
        let model = SpeciesModel::builtin("mallard", None, Library::builtin()).unwrap();
        let wavelengths = Wavelengths::new([500.0, 520.0]).unwrap();
        let axes = Axes::new(&wavelengths, vec![1.0 / 3.0, 2.0 / 3.0, 1.0], vec![1.0]).unwrap();
        let [key, legacy] = order_keys(&model.lattice().unwrap(), &axes);
        assert_eq!(&legacy[..16], "3d635b5358e5c050");
        assert_ne!(key, legacy);
    }

    #[test]
    fn every_shipped_material_is_found() {
        for (stem, bytes) in barbule_materials::MATERIALS {
            let info = decode_material(bytes).unwrap().info;
            let (species, variant) = (info["species"].as_str().unwrap(), info["variant"].as_str().unwrap());
            let model = SpeciesModel::builtin(species, Some(variant), Library::builtin()).unwrap();
            let found = Catalog::default().shipped(&Structure::Species(Box::new(model))).unwrap();
            assert_eq!(found.unwrap().hash, hash_bytes(bytes), "{stem}");
        }
    }

    #[test]
    fn a_material_is_the_same_when_it_is_kept_and_ever_after() {
        let folder = tempfile::tempdir().unwrap();
        let catalog = Catalog { cache: Some(folder.path().join("cache")) };
        let plan = CampaignOptions::default().plan(Structure::builtin("starling").unwrap()).unwrap();
        let mut material = decode_material(barbule_materials::material("starling-green").unwrap()).unwrap();
        // Between two of the numbers that a file can hold.
        material.sets[0].mean.reflected[0] *= 0.999_99;
        let kept = catalog.keep(&plan, &material).unwrap();
        let later = catalog.cached(&plan).unwrap();
        assert_ne!(kept.material, material);
        assert_eq!((kept.material, kept.hash), (later.material, later.hash));
    }

    #[test]
    fn stems_are_names_of_files() {
        assert_eq!(file_stem("a/b/starling:green"), "starling-green");
        assert_eq!(file_stem("x/"), "material");
    }
}
