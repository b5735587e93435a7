//! From a scene to one that can be rendered: whatever it names is read or made, by one walk.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use crate::brdf::{FeatherBrdf, FeatherMaterial, Options};
use crate::bsdf::{MeasuredTables, Texture};
use crate::diffraction::{foretell_sample, sample_powers};
use crate::io::image::{Meaning, RgbImage, check_ending, decode_picture, foretell_picture};
use crate::io::measured::{LARGEST_TABLE, Scale, parse_measured};
use crate::io::{
    Assets, LARGEST_BSDF, LARGEST_CURVES, LARGEST_GRATING, LARGEST_INPUT, decode_bsdf, decode_curves,
    decode_grating, decode_mesh, foretell_curves, foretell_mesh, hash_bytes,
};
use crate::progress::Progress;
use crate::scattering::grating::Powers;
use crate::scene::backdrop::BackdropPicture;
use crate::scene::description::{
    Foreseen, Holds, LowerSide, Named, ReadyScene, Remark, SceneDescription, Slot, Under,
};
use crate::scene::eye_maps;
use crate::scene::geometry::Mesh;
use crate::scene::sky::Sky;
use crate::{Error, Result};

/// A material ready to be worn.
#[derive(Debug, Clone)]
pub struct Worn {
    /// What is evaluated.
    pub brdf: Arc<FeatherBrdf>,
    /// BLAKE3 of the material's bytes.
    pub hash: String,
    /// What is known of the lower sides of its barbules.
    pub below: Below,
}

/// What the lower sides of a material's barbules show.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Below {
    /// Nothing is known: keratin.
    Keratin,
    /// The same as their upper sides.
    Same,
    /// Another material of this name.
    Named(String),
}

impl Worn {
    /// A material as it is evaluated by default, with keratin below; `hash` is BLAKE3 of its bytes.
    ///
    /// # Errors
    /// Tables that do not belong together.
    pub fn new(material: &FeatherMaterial, hash: String) -> Result<Self> {
        let brdf = Arc::new(FeatherBrdf::new(material, Options::default())?);
        Ok(Self { brdf, hash, below: Below::Keratin })
    }
}

/// Reads and makes everything that a scene names and that is not there yet: files from `assets`, materials by `materials`, which is
/// asked once for each name, and for those of lower sides ([`Worn::below`]) only where the scene shows them; `seed` is that of samples' heights. `progress` is told on which side of meshes feathers and barbules grow.
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
    let mut wardrobe = Wardrobe { worn: BTreeMap::new(), materials };
    read_files(&mut scene, assets, seed, progress)?;
    for (_, named) in scene.needed_mut().into_iter().filter(|(_, named)| !named.is_read()) {
        match named {
            Named::Material(slot) => {
                let Worn { brdf, hash, .. } = wardrobe.worn(&slot.name)?;
                slot.fill(brdf, hash);
            }
            Named::Lower(upper, slot) => {
                let own = wardrobe.worn(&upper)?;
                let lower = match own.below.clone() {
                    Below::Keratin => None,
                    Below::Same => Some(own),
                    Below::Named(name) => Some(wardrobe.worn(&name)?),
                };
                let (brdf, hash) = lower.map(|Worn { brdf, hash, .. }| (brdf, hash)).unzip();
                slot.fill(LowerSide(brdf), hash.unwrap_or_else(|| Under::KERATIN.to_owned()));
            }
            _ => {}
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

/// Materials, each asked for once.
struct Wardrobe<'a> {
    worn: BTreeMap<String, Worn>,
    materials: &'a mut dyn FnMut(&str) -> Result<Worn>,
}

impl Wardrobe<'_> {
    fn worn(&mut self, name: &str) -> Result<Worn> {
        if let Some(worn) = self.worn.get(name) {
            return Ok(worn.clone());
        }
        let worn = (self.materials)(name)?;
        self.worn.insert(name.to_owned(), worn.clone());
        Ok(worn)
    }
}

/// Reads and makes everything that a picture of a scene needs and that is not there yet, but its materials: a file that is named several
/// times once.
///
/// # Errors
/// As [`resolve`].
pub fn read_files(
    scene: &mut SceneDescription,
    assets: &dyn Assets,
    seed: u64,
    progress: &dyn Progress,
) -> Result<()> {
    let mut known = Known::default();
    for (key, mut named) in scene.needed_mut().into_iter().filter(|(_, named)| is_left(named)) {
        if known.fill(&mut named) {
            continue;
        }
        read_named(&mut named, assets, seed, progress).map_err(|error| error.at(key))?;
        known.keep(&named)?;
    }
    Ok(())
}

fn is_left(named: &Named<'_>) -> bool {
    !named.is_read() && !matches!(named, Named::Material(_) | Named::Lower(..))
}

/// What was read of a name, with its hash.
type Read<T> = BTreeMap<String, (Arc<T>, String)>;

/// What was read, for whoever names it again.
#[derive(Default)]
struct Known {
    colours: Read<Texture>,
    numbers: Read<Texture>,
    meshes: Read<Mesh>,
    powers: Read<Powers>,
    measured: Read<MeasuredTables>,
}

impl Known {
    /// Fills in what is known; whether it is.
    fn fill(&self, named: &mut Named<'_>) -> bool {
        fn from<T>(known: &Read<T>, slot: &mut Slot<T>) -> bool {
            let found = known.get(&slot.name).cloned();
            found.map(|(value, hash)| slot.fill(value, hash)).is_some()
        }
        match named {
            Named::Colours(slot) => from(&self.colours, slot),
            Named::Numbers(slot) => from(&self.numbers, slot),
            Named::Mesh(slot) => from(&self.meshes, slot),
            Named::Grating(slot) | Named::Sample(slot) => from(&self.powers, slot),
            Named::Measured(slot) => from(&self.measured, slot),
            Named::Spectrum(_)
            | Named::Backdrop(_)
            | Named::Sky(..)
            | Named::Curves(..)
            | Named::Material(_)
            | Named::Lower(..) => false,
        }
    }

    /// Keeps what was read.
    fn keep(&mut self, named: &Named<'_>) -> Result<()> {
        fn in_<T>(known: &mut Read<T>, slot: &Slot<T>) -> Result<()> {
            known.insert(slot.name.clone(), (slot.value()?.clone(), slot.hash().to_owned()));
            Ok(())
        }
        match named {
            Named::Colours(slot) => in_(&mut self.colours, slot),
            Named::Numbers(slot) => in_(&mut self.numbers, slot),
            Named::Mesh(slot) => in_(&mut self.meshes, slot),
            Named::Grating(slot) | Named::Sample(slot) => in_(&mut self.powers, slot),
            Named::Measured(slot) => in_(&mut self.measured, slot),
            Named::Spectrum(_)
            | Named::Backdrop(_)
            | Named::Sky(..)
            | Named::Curves(..)
            | Named::Material(_)
            | Named::Lower(..) => Ok(()),
        }
    }
}

/// What a scene's files hold, as they say at their beginnings, and how much memory reading one of them takes at most beside what is
/// kept of it, bytes. What cannot be looked at is left out; reading it will say why.
#[must_use]
pub fn foretell_files(scene: &SceneDescription, assets: &dyn Assets, seed: u64) -> (Foreseen, u64) {
    let (mut foreseen, mut reading) = (Foreseen::new(), 0);
    let mut scene = scene.clone();
    for (_, mut named) in scene.needed_mut().into_iter().filter(|(_, named)| is_left(named)) {
        if let Named::Sample(slot) = &named {
            if let (false, Some([kept, making])) =
                (foreseen.contains_key(&slot.name), foretell_sample(&slot.name, seed))
            {
                foreseen.insert(slot.name.clone(), Holds::Powers(kept as f64));
                reading = reading.max(making);
            }
            continue;
        }
        let Some(name) = named.file().cloned().filter(|name| !foreseen.contains_key(name)) else { continue };
        let Some((head, length)) = assets.beginning(&name, HEAD) else { continue };
        let (holds, beside) = match &named {
            Named::Colours(_) | Named::Numbers(_) | Named::Sky(..) | Named::Backdrop(_) => {
                let Some(pixels) = foretell_picture(&name, &head) else { continue };
                (Some(Holds::Pixels(pixels as f64)), length + DECODED_PER_PIXEL * pixels as u64)
            }
            Named::Mesh(_) => (foretell_mesh(&name, &head, length).map(Holds::Mesh), 2 * length),
            Named::Curves(..) => (Some(Holds::Points(foretell_curves(&head, length))), length),
            Named::Grating(_) => (Some(Holds::Powers(length as f64)), length),
            Named::Measured(_) => (Some(Holds::Measured(length as f64)), length),
            Named::Spectrum(_) | Named::Sample(_) | Named::Material(_) | Named::Lower(..) => (None, length),
        };
        foreseen.extend(holds.map(|holds| (name, holds)));
        reading = reading.max(beside);
    }
    (foreseen, reading)
}

/// So many bytes of a file tell what it holds.
const HEAD: usize = 1 << 16;

/// A picture's pixels as they are decoded, and once more in linear light before they are shared.
const DECODED_PER_PIXEL: u64 = 16;

/// Reads or makes one thing that a scene names and that is no material.
///
/// # Errors
/// As [`resolve`].
pub fn read_named(
    named: &mut Named<'_>,
    assets: &dyn Assets,
    seed: u64,
    progress: &dyn Progress,
) -> Result<()> {
    match named {
        Named::Spectrum(slot) => fill(slot, assets, LARGEST_TABLE, |place, bytes| {
            Ok(parse_measured(place, bytes, None, Some(Scale::Power))?.mean)
        }),
        Named::Backdrop(slot) => fill_picture(slot, assets, Meaning::Colour, |image, is_radiance| {
            BackdropPicture::new(image.size, image.pixels, is_radiance)
        }),
        &mut Named::Sky(ref mut slot, [strength, turn_deg]) => fill_picture(
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
        Named::Colours(slot) | Named::Numbers(slot) if eye_maps::is_made(&slot.name) => {
            let (picture, hash) = eye_maps::made(&slot.name)?;
            slot.fill(picture, hash);
            Ok(())
        }
        Named::Colours(slot) => fill_picture(slot, assets, Meaning::Colour, texture),
        Named::Numbers(slot) => fill_picture(slot, assets, Meaning::Number, texture),
        Named::Mesh(slot) => {
            let (mesh, hash) = decode_mesh(&slot.name, assets)?;
            slot.fill(mesh, hash);
            Ok(())
        }
        Named::Curves(slot, basis) => {
            fill(slot, assets, LARGEST_CURVES, |place, bytes| decode_curves(place, bytes, *basis))
        }
        Named::Grating(slot) => fill(slot, assets, LARGEST_GRATING, |place, bytes| {
            Ok(decode_grating(bytes).map_err(|error| error.in_file(Path::new(place)))?.powers)
        }),
        Named::Measured(slot) => fill(slot, assets, LARGEST_BSDF, |place, bytes| {
            decode_bsdf(bytes).map_err(|error| error.in_file(Path::new(place)))
        }),
        Named::Sample(slot) => {
            let hash = format!("{} {seed}", slot.name);
            slot.fill(sample_powers(&slot.name, seed, progress)?, hash);
            Ok(())
        }
        Named::Material(Slot { name, .. }) | Named::Lower(name, _) => {
            Err(Error::input(format!("'{name}' is a material, not a file")))
        }
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
