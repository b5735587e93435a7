//! The files and materials that a scene names: one walk over all of them, and scenes that lack none.

use std::collections::BTreeSet;
use std::ops::Deref;
use std::sync::Arc;

use super::barbules::{BarbuleClothing, LowerSide, Under};
use super::coat::CoatObject;
use super::dress::{FeatherObject, Zone};
use super::lights::LightColour;
use super::objects::ObjectShape;
use super::row::RowFeather;
use super::sky::{Background, SkyDescription};
use super::slot::Slot;
use super::surfaces::{FilmOf2005, NamedSurface};
use super::{Motion, Moved, SceneDescription};
use crate::brdf::FeatherBrdf;
use crate::bsdf::{MeasuredTables, Texture};
use crate::error::shortened;
use crate::fields::path_of;
use crate::scattering::grating::Powers;
use crate::scene::backdrop::BackdropPicture;
use crate::scene::eye_maps::is_made;
use crate::scene::geometry::Mesh;
use crate::scene::sky::Sky;
use crate::scene::spline::{Basis, ControlCurve};
use crate::spectrum::Spectrum;
use crate::{Error, Result};

/// Something that a scene names, by what it must be.
#[derive(Debug)]
pub enum Named<'a> {
    /// A table of wavelengths and powers.
    Spectrum(&'a mut Slot<Spectrum>),
    /// A picture behind everything.
    Backdrop(&'a mut Slot<BackdropPicture>),
    /// An image of the sky, its factor, and its turn, degrees.
    Sky(&'a mut Slot<Sky>, [f64; 2]),
    /// A mesh.
    Mesh(&'a mut Slot<Mesh>),
    /// Round curves, and how their control points make them.
    Curves(&'a mut Slot<Vec<ControlCurve>>, Basis),
    /// A picture of colours.
    Colours(&'a mut Slot<Texture>),
    /// A picture of numbers.
    Numbers(&'a mut Slot<Texture>),
    /// A `.grating` file.
    Grating(&'a mut Slot<Powers>),
    /// A `.bsdf` or MERL's `.binary`.
    Measured(&'a mut Slot<MeasuredTables>),
    /// A built-in sample of heights: no file.
    Sample(&'a mut Slot<Powers>),
    /// A material: a name, a structure or a file.
    Material(&'a mut Slot<FeatherBrdf>),
    /// The lower sides of the barbules of the material that is named first.
    Lower(String, &'a mut Slot<LowerSide>),
}

impl Named<'_> {
    /// Whether it is read.
    #[must_use]
    pub fn is_read(&self) -> bool {
        match self {
            Self::Spectrum(slot) => slot.is_read(),
            Self::Backdrop(slot) => slot.is_read(),
            Self::Sky(slot, _) => slot.is_read(),
            Self::Mesh(slot) => slot.is_read(),
            Self::Curves(slot, _) => slot.is_read(),
            Self::Colours(slot) | Self::Numbers(slot) => slot.is_read(),
            Self::Grating(slot) | Self::Sample(slot) => slot.is_read(),
            Self::Measured(slot) => slot.is_read(),
            Self::Material(slot) => slot.is_read(),
            Self::Lower(_, slot) => slot.is_read(),
        }
    }

    /// The name of a file; nothing of a sample or a material, which may be something else, nor of pictures that are made by rule.
    pub fn file(&mut self) -> Option<&mut String> {
        match self {
            Self::Spectrum(slot) => Some(&mut slot.name),
            Self::Backdrop(slot) => Some(&mut slot.name),
            Self::Sky(slot, _) => Some(&mut slot.name),
            Self::Mesh(slot) => Some(&mut slot.name),
            Self::Curves(slot, _) => Some(&mut slot.name),
            Self::Colours(slot) | Self::Numbers(slot) => Some(&mut slot.name).filter(|name| !is_made(name)),
            Self::Grating(slot) => Some(&mut slot.name),
            Self::Measured(slot) => Some(&mut slot.name),
            Self::Sample(_) | Self::Material(_) | Self::Lower(..) => None,
        }
    }
}

impl SceneDescription {
    /// Everything that the scene names, with the key that does; of a sky that gives no light nothing.
    pub fn named_mut(&mut self) -> Vec<(String, Named<'_>)> {
        self.walk(None)
    }

    /// What of that a picture needs: nothing of surfaces that no object has, and nothing of the lower sides of barbules that curves alone
    /// wear, which lie inside of these.
    pub fn needed_mut(&mut self) -> Vec<(String, Named<'_>)> {
        let used_by = |is_one: &dyn Fn(&ObjectShape) -> bool| -> BTreeSet<String> {
            let objects = self.objects.iter().filter(|object| is_one(&object.shape));
            let names = objects.filter_map(|object| object.surface.as_deref());
            self.surfaces.used_by(names).into_iter().map(str::to_owned).collect()
        };
        let used = used_by(&|_| true);
        let two_sided = used_by(&|shape| !matches!(shape, ObjectShape::Curves { .. }));
        let mut named = self.walk(Some(&used));
        let is_inside = |key: &str| {
            let surface = key.strip_prefix("surfaces.").and_then(|key| key.strip_suffix(".under"));
            surface.is_some_and(|name| !two_sided.iter().any(|used| shortened(used) == name))
        };
        named.retain(|(key, _)| !is_inside(key));
        named
    }

    /// Everything that the scene names, of surfaces only these, where some are given.
    fn walk(&mut self, surfaces: Option<&BTreeSet<String>>) -> Vec<(String, Named<'_>)> {
        let places = self.object_places();
        let mut named = Vec::new();
        for (index, light) in self.lights.iter_mut().enumerate() {
            if let LightColour::Table(slot) = &mut light.colour {
                named.push((format!("lights[{index}].spectrum"), Named::Spectrum(slot)));
            }
        }
        if let SkyDescription::Image(image) = &mut self.sky
            && image.strength > 0.0
        {
            let how = [image.strength, image.turn_deg];
            named.push(("sky_image.file".to_owned(), Named::Sky(&mut image.file, how)));
        }
        if let Background::Picture(slot) = &mut self.background {
            named.push(("background".to_owned(), Named::Backdrop(slot)));
        }
        for (object, place) in self.objects.iter_mut().zip(&places) {
            object.shape.named_mut(place, &mut named);
        }
        let is_needed = |name: &String| surfaces.is_none_or(|needed| needed.contains(name));
        for (name, surface) in self.surfaces.0.iter_mut().filter(|(name, _)| is_needed(name)) {
            surface.named_mut(&format!("surfaces.{}", shortened(name)), &mut named);
        }
        named
    }

    /// The scene with the same material on whatever wears one, whatever it is called, and keratin below where nothing else is named; the
    /// files that it names must be read.
    ///
    /// # Errors
    /// A file that is not read, a number out of range, or a material that is needed and not given.
    pub fn wearing(mut self, material: impl Into<Option<Arc<FeatherBrdf>>>) -> Result<ReadyScene> {
        if let Some(material) = material.into() {
            for (_, named) in self.named_mut() {
                match named {
                    Named::Material(slot) => slot.fill(material.clone(), String::new()),
                    Named::Lower(_, slot) => slot.fill(LowerSide(None), Under::KERATIN.to_owned()),
                    _ => {}
                }
            }
        }
        ReadyScene::new(self)
    }

    /// The names of the materials that are worn, each once, in their order.
    #[must_use]
    pub fn material_names(&self) -> Vec<String> {
        let mut scene = self.clone();
        let mut names: Vec<String> = Vec::new();
        for (_, named) in scene.named_mut() {
            if let Named::Material(slot) = named
                && !names.contains(&slot.name)
            {
                names.push(slot.name.clone());
            }
        }
        names
    }
}

impl ObjectShape {
    fn named_mut<'a>(&'a mut self, place: &str, named: &mut Vec<(String, Named<'a>)>) {
        let mut add = |key: &str, one: Named<'a>| named.push((path_of(place, key), one));
        match self {
            Self::Mesh(slot) => add("mesh", Named::Mesh(slot)),
            Self::Curves { file, basis } => add("curves", Named::Curves(file, *basis)),
            Self::Feather(of) => {
                let FeatherObject { dress, zones, zone_map, albedo, .. } = &mut **of;
                if let Some(slot) = zone_map {
                    add("zone_map", Named::Numbers(slot));
                }
                if let Some(slot) = albedo {
                    add("albedo", Named::Colours(slot));
                }
                dress.clothing_mut().for_each(|of| of.named_mut("", &mut add));
                for zone in zones {
                    zone.clothing_mut().for_each(|of| of.named_mut("zones.", &mut add));
                }
            }
            Self::Coat(of) => {
                let CoatObject { coat, dress, .. } = &mut **of;
                if let Some(slot) = &mut coat.mesh {
                    add("coat.mesh", Named::Mesh(slot));
                }
                if let Some(slot) = &mut coat.map {
                    add("coat.map", Named::Numbers(slot));
                }
                dress.clothing_mut().for_each(|of| of.named_mut("", &mut add));
                let further = coat.feathers.iter_mut().flat_map(|kind| kind.dress.clothing_mut());
                further.for_each(|of| of.named_mut("coat.feathers.", &mut add));
            }
            Self::Row(of) => {
                let further = of.row.feathers.iter_mut().map(|kind| ("row.feathers.", kind));
                for (table, kind) in std::iter::once(("", &mut of.first)).chain(further) {
                    let RowFeather { dress, zones, zone_map, albedo, .. } = kind;
                    if let Some(slot) = zone_map {
                        add(&format!("{table}zone_map"), Named::Numbers(slot));
                    }
                    if let Some(slot) = albedo {
                        add(&format!("{table}albedo"), Named::Colours(slot));
                    }
                    dress.clothing_mut().for_each(|of| of.named_mut(table, &mut add));
                    let zones = zones.iter_mut().flat_map(Zone::clothing_mut);
                    zones.for_each(|of| of.named_mut(&format!("{table}zones."), &mut add));
                }
            }
            Self::Sphere { .. } | Self::Rectangle { .. } | Self::Snake(_) | Self::Form(_) => {}
        }
    }
}

impl BarbuleClothing {
    /// Adds its material and that of its lower sides, under keys of this table.
    fn named_mut<'a>(&'a mut self, table: &str, add: &mut impl FnMut(&str, Named<'a>)) {
        let Self { material, under, .. } = self;
        let name = material.name.clone();
        add(&format!("{table}material"), Named::Material(material));
        let key = format!("{table}under");
        match under {
            Under::Own(slot) => add(&key, Named::Lower(name, slot)),
            Under::Material(slot) => add(&key, Named::Material(slot)),
            Under::Keratin => {}
        }
    }
}

impl NamedSurface {
    fn named_mut<'a>(&'a mut self, place: &str, named: &mut Vec<(String, Named<'a>)>) {
        let mut add = |key: &str, one: Named<'a>| named.push((path_of(place, key), one));
        match self {
            Self::Diffuse(of) | Self::Film2005(FilmOf2005 { paint: of, .. }) => {
                if let Some(slot) = &mut of.albedo {
                    add("albedo", Named::Colours(slot));
                }
                for (key, slot) in
                    [("alpha", &mut of.alpha), ("normal", &mut of.normal), ("bump", &mut of.bump)]
                {
                    if let Some(slot) = slot {
                        add(key, Named::Numbers(slot));
                    }
                }
            }
            Self::Map(of) => add("file", Named::Numbers(&mut of.file)),
            Self::Grating(of) => {
                if let Some(slot) = &mut of.file {
                    add("file", Named::Grating(slot));
                }
                if let Some(slot) = &mut of.sample {
                    add("sample", Named::Sample(slot));
                }
            }
            Self::Measured(of) => add("file", Named::Measured(&mut of.file)),
            Self::Barbule(of) => of.named_mut("", &mut add),
            Self::Keratin(_) | Self::Hair(_) | Self::Dielectric(_) | Self::Conductor(_) | Self::Film(_) => {}
        }
    }
}

/// A scene of which everything that it names is read: what is rendered.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadyScene(SceneDescription);

impl ReadyScene {
    /// The scene, once everything that it names is read.
    ///
    /// # Errors
    /// The first name that is not read, or a number out of range.
    pub fn new(mut scene: SceneDescription) -> Result<Self> {
        scene.check()?;
        for (key, named) in scene.needed_mut() {
            if !named.is_read() {
                return Err(Error::input(format!("{key} is not read")));
            }
        }
        Ok(Self(scene))
    }

    /// The scene with changes; what they name further must be read.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn changed(&self, change: impl FnOnce(&mut SceneDescription)) -> Result<Self> {
        let mut scene = self.0.clone();
        change(&mut scene);
        Self::new(scene)
    }

    /// The frames of a sequence; see [`SceneDescription::frames`].
    ///
    /// # Errors
    /// As there.
    pub fn frames(&self, moves: &[(Moved, Motion)], count: u32) -> Result<Vec<Self>> {
        Ok(self.0.frames(moves, count)?.into_iter().map(Self).collect())
    }
}

impl Deref for ReadyScene {
    type Target = SceneDescription;

    fn deref(&self) -> &SceneDescription {
        &self.0
    }
}
