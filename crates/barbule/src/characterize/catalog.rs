//! Finished materials and tables: those that ship, and those in a cache folder.

use std::path::{Path, PathBuf};

use super::{CAMPAIGN_VERSION, CampaignDescription, HALO_VERSION, Plan};
use crate::brdf::FeatherMaterial;
use crate::brdf::fit::{FitOptions, LobeForm};
use crate::campaign::orders;
use crate::identity::Hasher;
use crate::io::{
    HASH_DIGITS, LARGEST_INPUT, check_writable, decode_material, encode_material, hash_bytes, list_cache,
    make_folder, read_bytes, read_orders, read_own, write_orders, write_whole,
};
use crate::progress::Progress;
use crate::scattering::lobe::FitKind;
use crate::scattering::orders::OrderTable;
use crate::scattering::statistics::Axes;
use crate::structure::{Lattice, Side, Smoothing, Structure};
use crate::{Error, Result};

/// What the file names of lower sides end in.
const BELOW: &str = "-below";

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
    /// Where it comes from.
    pub origin: Origin,
}

/// Where a material comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// It ships inside the program, as these bytes of a file.
    Shipped(&'static [u8]),
    /// A file.
    File(PathBuf),
    /// It was made just now and is kept nowhere.
    Memory,
}

impl Found {
    /// The material of a user's file.
    ///
    /// # Errors
    /// As [`crate::io::read_material`].
    pub fn in_file(path: &Path) -> Result<Self> {
        Self::from_bytes(path, &read_bytes(path)?)
    }

    fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self> {
        let material = decode_material(bytes).map_err(|error| error.in_file(path))?;
        Ok(Self { material, hash: hash_bytes(bytes), origin: Origin::File(path.to_owned()) })
    }

    /// The bytes of its file.
    ///
    /// # Errors
    /// The file is not there any more.
    pub fn bytes(&self) -> Result<Vec<u8>> {
        match &self.origin {
            Origin::Shipped(bytes) => Ok(bytes.to_vec()),
            Origin::File(path) => read_bytes(path),
            Origin::Memory => encode_material(&self.material),
        }
    }
}

/// A fresh material as every later command reads it from its file, and the hash of that file: files round parameters to
/// sixteen bits, and the first picture must be the bits of all later ones.
///
/// # Errors
/// A material that fails its checks.
pub fn as_filed(material: &FeatherMaterial) -> Result<(FeatherMaterial, String)> {
    let bytes = encode_material(material)?;
    Ok((decode_material(&bytes)?, hash_bytes(&bytes)))
}

impl Catalog {
    /// The shipped material of a structure, at the default options; that of a lower side is called `NAME-below`.
    ///
    /// # Errors
    /// A shipped file is damaged.
    pub fn shipped(&self, structure: &Structure) -> Result<Option<Found>> {
        let stem = structure.name().replace(Side::BELOW, BELOW).replace(':', "-");
        let (Structure::Species(model), Some(bytes)) = (structure.upper(), barbule_birds::material(&stem))
        else {
            return Ok(None);
        };
        let material = decode_material(bytes).map_err(|e| e.at(format!("the shipped material {stem}")))?;
        let campaign = &material.info["campaign"];
        // Whoever does not ask for an average takes the one that it was made with.
        let is_averaged_so =
            model.smoothing == Smoothing::Usual || campaign["smooth_um"].as_f64() == structure.smooth_um();
        // A user's own species may bear the name of a built-in one.
        let is_it = campaign["structure"] == structure.description() && is_averaged_so;
        Ok(is_it.then(|| Found { hash: hash_bytes(bytes), material, origin: Origin::Shipped(bytes) }))
    }

    /// The cached material of a plan that is fitted so.
    #[must_use]
    pub fn cached(&self, plan: &Plan, options: &FitOptions) -> Option<Found> {
        let is_it = |found: &Found| {
            let FitOptions { kind, lobe, sigma, halo, .. } = *options;
            plan.description.is_recorded(&found.material.info["campaign"])
                && (found.material.kind, found.material.sigma) == (kind, sigma)
                && (LobeForm::of(&found.material), found.material.halo.is_some()) == (lobe, halo)
        };
        let path = self.path(plan, options).ok()?;
        let bytes = read_own(&path, LARGEST_INPUT).ok()?;
        Found::from_bytes(&path, &bytes).ok().filter(is_it)
    }

    /// Keeps a plan's material in the cache, whole or not at all, and says where.
    ///
    /// # Errors
    /// There is no cache, or it cannot be written.
    pub fn keep(&self, plan: &Plan, options: &FitOptions, material: &FeatherMaterial) -> Result<PathBuf> {
        let path = self.path(plan, options)?;
        path.parent().map_or(Ok(()), make_folder)?;
        write_whole(&path, &encode_material(material)?)?;
        Ok(path)
    }

    /// Where the material of a plan that is fitted so is kept: its name holds a hash of everything that decides it, so that
    /// materials of other structures or options stand beside it. One that is there under another name of the structure
    /// keeps its name.
    ///
    /// # Errors
    /// There is no cache.
    pub fn path(&self, plan: &Plan, options: &FitOptions) -> Result<PathBuf> {
        let folder = self.cache.as_ref().ok_or_else(|| Error::input("no cache folder is given; give one"))?;
        let key = material_key(&plan.description, options);
        Ok(place(folder, &plan.structure.name(), &key, "barbule"))
    }

    /// Where a plan's material can be kept, tried before any work; the folder is made.
    ///
    /// # Errors
    /// There is no cache, or it cannot be written.
    pub fn room(&self, plan: &Plan, options: &FitOptions) -> Result<PathBuf> {
        let path = self.path(plan, options)?;
        path.parent().map_or(Ok(()), make_folder)?;
        check_writable(&path)?;
        Ok(path)
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
        // Without a cache the orders are solved every time.
        let folder = self.cache.as_ref().filter(|folder| make_folder(folder).is_ok());
        let path = |key: &str| folder.map(|folder| place(folder, &structure.name(), key, "orders"));
        let read = |key: &str| path(key).and_then(|path| read_orders(&path, key).ok());
        let key = orders_key(&lattice, axes);
        if let Some(found) = read(&key) {
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

/// Where a cache has what a key names: the file whose name ends in the key's first digits, whatever the structure was called
/// then; else a new one of this name.
fn place(folder: &Path, name: &str, key: &str, extension: &str) -> PathBuf {
    let end = format!("-{}.{extension}", &key[..HASH_DIGITS]);
    let is_it = |path: &Path| path.file_name().is_some_and(|name| name.to_string_lossy().ends_with(&end));
    let there = list_cache(folder).unwrap_or_default().into_iter().map(|file| file.path);
    let mut there = there.filter(|path| is_it(path));
    there.next().unwrap_or_else(|| folder.join(format!("{}{end}", file_stem(name))))
}

/// What names a material by everything that decides it: its campaign, and how it was fitted.
pub(super) fn material_key(campaign: &CampaignDescription, options: &FitOptions) -> String {
    let kind = match options.kind {
        FitKind::Marginal => "marginal",
        FitKind::Cone => "cone",
    };
    let lobe = match options.lobe {
        LobeForm::Pair => "pair",
        LobeForm::Ggx => "ggx",
    };
    let mut hasher = Hasher::new("cached material");
    hasher.part("campaign", campaign).text("fit", kind).text("lobe", lobe).number("sigma", options.sigma);
    if options.halo {
        hasher.count("halo", HALO_VERSION);
    }
    hasher.hex()
}

/// What names a table of orders by everything that decides it.
fn orders_key(lattice: &Lattice, axes: &Axes) -> String {
    Hasher::new("orders")
        .count("campaign", CAMPAIGN_VERSION)
        .part("lattice", lattice)
        .numbers("wavelengths_nm", axes.wavelengths_nm())
        .numbers("cos_theta", axes.cos_theta())
        .hex()
}

/// The readable part of a file name for a structure: `starling:green` → `starling-green`, `air/keratin:300/air` →
/// `air-keratin-300-air`, `a/bird.toml` → `bird`, `mallard:lime (below)` → `mallard-lime-below`.
pub(super) fn file_stem(name: &str) -> String {
    const LONGEST: usize = 60;
    if let Some(upper) = name.strip_suffix(Side::BELOW) {
        return file_stem(upper) + BELOW;
    }
    let is_stack = name.contains([':', '(']);
    let last = Path::new(name).file_stem().map_or(name.into(), |stem| stem.to_string_lossy());
    let mut stem = String::new();
    for c in if is_stack { name } else { &last }.chars() {
        if c.is_ascii_alphanumeric() || "_.".contains(c) {
            stem.push(c);
        } else if !stem.is_empty() && !stem.ends_with('-') {
            stem.push('-');
        }
        if stem.len() == LONGEST {
            break;
        }
    }
    let stem = stem.trim_matches(['-', '.']);
    if stem.is_empty() { "material".into() } else { stem.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::characterize::CampaignOptions;
    use crate::io::write_material;
    use crate::material::Library;
    use crate::structure::SpeciesModel;

    #[test]
    fn every_shipped_material_is_found() {
        for (stem, bytes) in barbule_birds::materials() {
            let info = decode_material(bytes).unwrap().info;
            let (species, variant) = (info["species"].as_str().unwrap(), info["variant"].as_str().unwrap());
            let model = SpeciesModel::builtin(species, Some(variant), Library::builtin()).unwrap();
            let upper = Structure::Species(Box::new(model));
            let structure = if stem.ends_with(BELOW) { upper.underside().unwrap() } else { upper };
            let found = Catalog::default().shipped(&structure).unwrap().unwrap();
            assert_eq!((found.hash.clone(), found.bytes().unwrap()), (hash_bytes(bytes), bytes.to_vec()));
            assert_eq!(found.origin, Origin::Shipped(bytes), "{stem}");
        }
    }

    #[test]
    fn a_shipped_material_is_not_that_of_another_average() {
        let bird = || Structure::builtin("hummingbird").unwrap();
        let found = |structure: &Structure| Catalog::default().shipped(structure).unwrap();
        let recorded = found(&bird()).unwrap().material.info["campaign"]["smooth_um"].as_f64();
        assert!(found(&bird().smoothed(recorded.into())).is_some());
        assert!(found(&bird().smoothed(Smoothing::Over(0.2))).is_none());
    }

    fn starling_in(folder: &Path) -> (Catalog, Plan, FeatherMaterial) {
        let catalog = Catalog { cache: Some(folder.join("cache")) };
        let plan = CampaignOptions::default().plan(Structure::builtin("starling").unwrap()).unwrap();
        let mut material = decode_material(barbule_birds::material("starling-green").unwrap()).unwrap();
        // As a plan without segments makes it.
        material.halo = None;
        // Between two of the numbers that a file can hold.
        material.sets[0].mean[0].reflected[0] *= 0.999_99;
        (catalog, plan, material)
    }

    #[test]
    fn a_material_is_the_same_when_it_is_kept_and_ever_after() {
        let folder = tempfile::tempdir().unwrap();
        let (catalog, plan, material) = starling_in(folder.path());
        let now = as_filed(&material).unwrap();
        let path = catalog.keep(&plan, &FitOptions::default(), &material).unwrap();
        let later = catalog.cached(&plan, &FitOptions::default()).unwrap();
        assert_ne!(now.0, material);
        assert_eq!(now, (later.material, later.hash));
        assert_eq!(later.origin, Origin::File(path));
    }

    #[test]
    fn a_cached_material_is_found_only_if_it_is_what_is_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let (catalog, plan, material) = starling_in(folder.path());
        let usual = FitOptions::default();
        let path = catalog.keep(&plan, &usual, &material).unwrap();
        assert_eq!(catalog.cached(&plan, &usual).unwrap().origin, Origin::File(path));
        let thinned = CampaignOptions { thin: Some(4), ..CampaignOptions::default() };
        let thinned = thinned.plan(Structure::builtin("starling").unwrap()).unwrap();
        for (plan, options) in [(&plan, FitOptions { sigma: 0.05, ..usual }), (&thinned, usual)] {
            assert!(catalog.cached(plan, &options).is_none());
            write_material(&catalog.path(plan, &options).unwrap(), &material).unwrap();
            assert!(catalog.cached(plan, &options).is_none());
        }
    }

    #[test]
    fn whatever_decides_a_material_changes_its_name_and_spelling_does_not() {
        let catalog = Catalog { cache: Some("cache".into()) };
        let name = |structure: &str, options: &CampaignOptions, fit: &FitOptions| {
            let plan = options.plan(Structure::flat(structure).unwrap()).unwrap();
            catalog.path(&plan, fit).unwrap().file_name().unwrap().to_string_lossy().into_owned()
        };
        let (usual, fit) = (CampaignOptions::default, FitOptions::default());
        let film = "air/keratin:300/air";
        let names = [
            name(film, &usual(), &fit),
            name("air/melanin:100/air", &usual(), &fit),
            name(film, &CampaignOptions { thin: Some(1), instances: Some(12), ..usual() }, &fit),
            name(film, &CampaignOptions { thin: Some(4), ..usual() }, &fit),
            name(film, &CampaignOptions { wavelengths_nm: vec![500.0, 600.0], ..usual() }, &fit),
            name(film, &CampaignOptions { directions: [20, 19], ..usual() }, &fit),
            name(film, &CampaignOptions { instances: Some(49), ..usual() }, &fit),
            name(film, &CampaignOptions { tilt_deg: 1.0, ..usual() }, &fit),
            name(film, &CampaignOptions { polarized: true, ..usual() }, &fit),
            name(film, &CampaignOptions { seed: 2, ..usual() }, &fit),
            name(film, &usual(), &FitOptions { sigma: 0.05, ..fit }),
            name(film, &usual(), &FitOptions { halo: true, ..fit }),
            name(film, &usual(), &FitOptions { kind: FitKind::Cone, ..fit }),
            name(film, &usual(), &FitOptions { lobe: LobeForm::Ggx, ..fit }),
        ];
        for (index, one) in names.iter().enumerate() {
            assert!(!names[..index].contains(one), "{index}: {one}");
        }
        let hash = |name: &str| name.rsplit_once('-').unwrap().1.to_owned();
        assert!(names[0].starts_with("air-keratin-300-air-") && hash(&names[0]).len() == HASH_DIGITS + 8);
        assert_eq!(hash(&names[0]), hash(&name("air/keratin:300.0/air", &usual(), &fit)));
    }

    #[test]
    fn stems_are_names_of_files() {
        for (name, stem) in [
            ("starling:green", "starling-green"),
            ("air/6*(keratin:300/melanin:5)/air", "air-6-keratin-300-melanin-5-air"),
            ("a/b/bird.toml", "bird"),
            ("a/b/bird.toml (below)", "bird-below"),
            ("mallard:lime (below)", "mallard-lime-below"),
            ("./sections/", "sections"),
            ("..", "material"),
            ("", "material"),
        ] {
            assert_eq!(file_stem(name), stem);
        }
        assert_eq!(file_stem(&"ab:".repeat(1000)).len(), 59);
    }
}
