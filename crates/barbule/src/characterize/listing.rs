//! What a cache folder holds.

use std::path::Path;

use super::catalog::material_key;
use super::{CampaignDescription, CampaignOptions, thinned};
use crate::Result;
use crate::brdf::fit::{FitOptions, LobeForm};
use crate::io::{CacheFile, HASH_DIGITS, hash_file, list_cache, read_keyed_orders, read_material};
use crate::scattering::lobe::FitKind;

/// A file of a cache folder.
#[derive(Debug, Clone, PartialEq)]
pub struct Cached {
    /// The file.
    pub file: CacheFile,
    /// BLAKE3 of its bytes, hexadecimal; empty where it cannot be read.
    pub hash: String,
    /// What it holds.
    pub contents: Contents,
    /// Whether this program put it there: its name says what it holds, as nobody else's would.
    pub is_ours: bool,
}

/// What a file of a cache folder holds.
#[derive(Debug, Clone, PartialEq)]
pub enum Contents {
    /// A material.
    Material(Box<CachedMaterial>),
    /// The orders of a crystal.
    Orders(CachedOrders),
    /// Neither, or damaged: why.
    Unknown(String),
}

/// What a material in a cache says of itself.
#[derive(Debug, Clone, PartialEq)]
pub struct CachedMaterial {
    /// Its structure's name; empty where it does not say.
    pub name: String,
    /// Version of the program that made it; empty where it does not say.
    pub version: String,
    /// Every how many-th wavelength and direction was simulated, of a quick look.
    pub thinned: Option<usize>,
    /// Wavelengths, nm, rising.
    pub wavelengths_nm: Vec<f64>,
    /// How many cosθ_i and cosφ_i.
    pub directions: [usize; 2],
    /// Random instances, where it says.
    pub instances: Option<usize>,
    /// Seed of instances and noise.
    pub seed: u64,
    /// Whether it keeps both incident polarizations apart.
    pub is_polarized: bool,
    /// Longitudinal spread σ of the lobe.
    pub sigma: f64,
    /// Whether segments in three dimensions gave it a halo beside.
    pub has_halo: bool,
    /// What the lobe was fitted to.
    pub kind: FitKind,
    /// What stands for its mean intensity.
    pub lobe: LobeForm,
}

impl CachedMaterial {
    /// Whether it has the wavelengths and directions of a default campaign.
    #[must_use]
    pub fn is_full(&self) -> bool {
        let usual = CampaignOptions::default();
        (&self.wavelengths_nm, self.directions) == (&usual.wavelengths_nm, usual.directions)
    }
}

/// What a table of a crystal's orders holds.
#[derive(Debug, Clone, PartialEq)]
pub struct CachedOrders {
    /// Wavelengths, nm, rising.
    pub wavelengths_nm: Vec<f64>,
    /// How many cosθ_i.
    pub angles: usize,
}

impl Cached {
    /// Everything in a folder that is a material or a table of orders by its name's end; nothing where there is no folder.
    ///
    /// # Errors
    /// The path is a file, or the folder cannot be read.
    pub fn all(folder: &Path) -> Result<Vec<Self>> {
        Ok(list_cache(folder)?.into_iter().map(Self::of).collect())
    }

    fn of(file: CacheFile) -> Self {
        let is_orders = file.path.extension().is_some_and(|end| end == "orders");
        let read = if is_orders { orders(&file.path) } else { material(&file.path) };
        let (contents, key) = read.unwrap_or_else(|error| (Contents::Unknown(error.to_string()), None));
        let stem = file.path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let is_ours = stem.rsplit_once('-').is_some_and(|(_, digits)| {
            digits.len() == HASH_DIGITS && key.is_some_and(|key| key.starts_with(digits))
        });
        let hash = hash_file(&file.path).unwrap_or_default();
        Self { file, hash, contents, is_ours }
    }
}

/// What a file holds, and what names it by all that decides it.
type Read = (Contents, Option<String>);

fn orders(path: &Path) -> Result<Read> {
    let (key, table) = read_keyed_orders(path)?;
    let orders = CachedOrders { wavelengths_nm: table.wavelengths_nm, angles: table.cos_theta.len() };
    Ok((Contents::Orders(orders), Some(key)))
}

fn material(path: &Path) -> Result<Read> {
    let material = read_material(path)?;
    let campaign = CampaignDescription::read(&material.info["campaign"]).ok();
    let lobe = LobeForm::of(&material);
    let options = FitOptions {
        kind: material.kind,
        lobe,
        sigma: material.sigma,
        halo: material.halo.is_some(),
        ..FitOptions::default()
    };
    let key = campaign.as_ref().map(|campaign| material_key(campaign, &options));
    let text = |key: &str| material.info[key].as_str().unwrap_or_default().to_owned();
    let axes = &material.axes;
    let said = CachedMaterial {
        name: text("name"),
        version: text("version"),
        thinned: thinned(&material),
        wavelengths_nm: axes.wavelengths_nm().to_vec(),
        directions: [axes.cos_theta().len(), axes.cos_phi().len()],
        instances: campaign.map(|campaign| campaign.instances),
        seed: material.seed,
        is_polarized: material.sets.len() == 2,
        sigma: material.sigma,
        has_halo: options.halo,
        kind: material.kind,
        lobe,
    };
    Ok((Contents::Material(Box::new(said)), key))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::{Resources, statistics};
    use crate::characterize::{Catalog, material_of};
    use crate::io::write_material;
    use crate::progress::Unobserved;
    use crate::structure::Structure;

    #[test]
    fn only_what_the_program_named_by_its_contents_is_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let catalog = Catalog { cache: Some(folder.path().to_owned()) };
        let (options, fit) = (
            CampaignOptions {
                wavelengths_nm: vec![500.0],
                directions: [2, 2],
                instances: Some(2),
                ..Default::default()
            },
            FitOptions::default(),
        );
        let plan = options.plan(Structure::builtin("magpie").unwrap()).unwrap();
        let campaign = plan.campaign(&Resources::default(), &catalog, &Unobserved).unwrap();
        let found = statistics(&campaign, &Unobserved).unwrap();
        let name = plan.structure.name();
        let (material, _) = material_of(&found, &name, &plan.description, &fit, &Unobserved).unwrap();
        let kept = catalog.keep(&plan, &fit, &material).unwrap();
        // A copy of it, the same under another hash, a fit of one's own, and something else.
        std::fs::copy(&kept, folder.path().join("mine.barbule")).unwrap();
        std::fs::copy(&kept, folder.path().join("magpie-violet-0123456789abcdef.barbule")).unwrap();
        let (own, _) =
            material_of(&found, &name, &plan.description, &FitOptions { sigma: 0.06, ..fit }, &Unobserved)
                .unwrap();
        write_material(&folder.path().join("own.barbule"), &own).unwrap();
        std::fs::write(folder.path().join("words.barbule"), "words").unwrap();
        let all = Cached::all(folder.path()).unwrap();
        let ours: Vec<&Cached> = all.iter().filter(|cached| cached.is_ours).collect();
        assert_eq!((all.len(), ours.len()), (6, 2));
        let mut said = Vec::new();
        for cached in ours {
            match &cached.contents {
                Contents::Material(material) => {
                    assert_eq!(cached.file.path, kept);
                    assert_eq!((&*material.name, material.directions), ("magpie:violet", [2, 2]));
                    assert_eq!((material.instances, material.is_full()), (Some(2), false));
                    said.push("material");
                }
                Contents::Orders(orders) => {
                    assert_eq!((&orders.wavelengths_nm[..], orders.angles), (&[500.0][..], 2));
                    said.push("orders");
                }
                Contents::Unknown(why) => panic!("{why}"),
            }
        }
        said.sort_unstable();
        assert_eq!(said, ["material", "orders"]);
        let words = all.iter().find(|cached| cached.file.path.ends_with("words.barbule")).unwrap();
        assert!(matches!(&words.contents, Contents::Unknown(why) if why.contains("is not a material file")));
    }
}
