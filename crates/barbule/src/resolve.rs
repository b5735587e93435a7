//! From a scene to one that can be rendered: whatever it names is read or made, by one walk.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use crate::brdf::{FeatherBrdf, FeatherMaterial, Options};
use crate::bsdf::Texture;
use crate::diffraction::sample_powers;
use crate::io::image::{Meaning, RgbImage, check_ending, decode_picture};
use crate::io::measured::{LARGEST_TABLE, Scale, parse_measured};
use crate::io::{
    Assets, LARGEST_CURVES, LARGEST_GRATING, LARGEST_INPUT, decode_curves, decode_grating, decode_mesh,
    hash_bytes,
};
use crate::progress::Progress;
use crate::scene::backdrop::BackdropPicture;
use crate::scene::description::{Named, ReadyScene, Remark, SceneDescription, Slot};
use crate::scene::sky::Sky;
use crate::{Error, Result};

/// A material ready to be worn.
#[derive(Debug, Clone)]
pub struct Worn {
    /// What is evaluated.
    pub brdf: Arc<FeatherBrdf>,
    /// BLAKE3 of the material's bytes.
    pub hash: String,
}

impl Worn {
    /// A material as it is evaluated by default; `hash` is BLAKE3 of its bytes.
    ///
    /// # Errors
    /// Tables that do not belong together.
    pub fn new(material: &FeatherMaterial, hash: String) -> Result<Self> {
        Ok(Self { brdf: Arc::new(FeatherBrdf::new(material, Options::default())?), hash })
    }
}

/// Reads and makes everything that a scene names and that is not there yet: files from `assets`, materials by `materials`, which is
/// asked once for each name; `seed` is that of samples' heights. `progress` is told on which side of meshes feathers and barbules grow.
///
/// # Errors
/// A file or material that is missing, too large or of another kind; the message begins with the key. Interruption.
pub fn resolve(
    mut scene: SceneDescription,
    assets: &dyn Assets,
    materials: &mut dyn FnMut(&str) -> Result<Worn>,
    seed: u64,
    progress: &dyn Progress,
) -> Result<ReadyScene> {
    let mut worn: BTreeMap<String, Worn> = BTreeMap::new();
    read_files(&mut scene, assets, seed, progress)?;
    for (_, named) in scene.named_mut().into_iter().filter(|(_, named)| !named.is_read()) {
        if let Named::Material(slot) = named {
            let material = match worn.get(&slot.name) {
                Some(material) => material.clone(),
                None => materials(&slot.name)?,
            };
            slot.fill(material.brdf.clone(), material.hash.clone());
            worn.insert(slot.name.clone(), material);
        }
    }
    for Remark { sentence, is_doubt } in scene.remarks_on_sides() {
        if is_doubt {
            progress.doubt(&sentence);
        } else {
            progress.note(&sentence);
        }
    }
    ReadyScene::new(scene)
}

/// Reads and makes everything that a scene names and that is not there yet, but its materials.
///
/// # Errors
/// As [`resolve`].
pub fn read_files(
    scene: &mut SceneDescription,
    assets: &dyn Assets,
    seed: u64,
    progress: &dyn Progress,
) -> Result<()> {
    let is_left = |named: &Named<'_>| !named.is_read() && !matches!(named, Named::Material(_));
    for (key, named) in scene.named_mut().into_iter().filter(|(_, named)| is_left(named)) {
        read_named(named, assets, seed, progress).map_err(|error| error.at(key))?;
    }
    Ok(())
}

/// Reads or makes one thing that a scene names and that is no material.
///
/// # Errors
/// As [`resolve`].
pub fn read_named(named: Named<'_>, assets: &dyn Assets, seed: u64, progress: &dyn Progress) -> Result<()> {
    match named {
        Named::Spectrum(slot) => fill(slot, assets, LARGEST_TABLE, |place, bytes| {
            Ok(parse_measured(place, bytes, None, Some(Scale::Power))?.mean)
        }),
        Named::Backdrop(slot) => fill_picture(slot, assets, Meaning::Colour, |image, is_radiance| {
            BackdropPicture::new(image.size, image.pixels, is_radiance)
        }),
        Named::Sky(slot, [strength, turn_deg]) => fill_picture(
            slot,
            assets,
            Meaning::Colour,
            |RgbImage { size: [width, height], pixels }, is_radiance| {
                if !is_radiance {
                    return Err(Error::input("skies are read from .exr or .hdr"));
                }
                Sky::image(width, height, pixels, strength, turn_deg)
            },
        ),
        Named::Colours(slot) => fill_picture(slot, assets, Meaning::Colour, texture),
        Named::Numbers(slot) => fill_picture(slot, assets, Meaning::Number, texture),
        Named::Mesh(slot) => {
            let (mesh, hash) = decode_mesh(&slot.name, assets)?;
            slot.fill(mesh, hash);
            Ok(())
        }
        Named::Curves(slot, basis) => {
            fill(slot, assets, LARGEST_CURVES, |place, bytes| decode_curves(place, bytes, basis))
        }
        Named::Grating(slot) => fill(slot, assets, LARGEST_GRATING, |place, bytes| {
            Ok(decode_grating(bytes).map_err(|error| error.in_file(Path::new(place)))?.powers)
        }),
        Named::Sample(slot) => {
            let hash = format!("{} {seed}", slot.name);
            slot.fill(sample_powers(&slot.name, seed, progress)?, hash);
            Ok(())
        }
        Named::Material(slot) => Err(Error::input(format!("'{}' is a material, not a file", slot.name))),
    }
}

fn texture(image: RgbImage, _: bool) -> Result<Texture> {
    Texture::new(image.size, image.pixels)
}

fn fill<T>(
    slot: &mut Slot<T>,
    assets: &dyn Assets,
    largest: u64,
    decode: impl Fn(&str, &[u8]) -> Result<T>,
) -> Result<()> {
    let bytes = assets.read(&slot.name, largest)?;
    slot.fill(decode(&assets.place(&slot.name), &bytes)?, hash_bytes(&bytes));
    Ok(())
}

fn fill_picture<T>(
    slot: &mut Slot<T>,
    assets: &dyn Assets,
    meaning: Meaning,
    make: impl Fn(RgbImage, bool) -> Result<T>,
) -> Result<()> {
    check_ending(&assets.place(&slot.name))?;
    fill(slot, assets, LARGEST_INPUT, |place, bytes| {
        let (image, is_radiance) = decode_picture(place, bytes, meaning)?;
        make(image, is_radiance).map_err(|error| error.in_file(Path::new(place)))
    })
}
