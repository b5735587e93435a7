//! `albedo`: a picture of a vane, as a scanner or camera sees it, that its rami and barbules take their colours from.
//!
//! The picture's colours are gathered into a few, each the colour of a zone, so that feathers show them at every level of detail. Fibres absorb
//! what makes vanes of them look like that ([`Absorption::of_vane`](crate::bsdf::Absorption::of_vane)).

use super::colour::Colour;
use super::dress::{BarbuleDress, FeatherObject, RamusDress, Zone};
use super::slot::Slot;
use super::surfaces::FibreDescription;
use crate::bsdf::{Palette, Texture};
use crate::fields::path_of;
use crate::spectrum::colour::encode;
use crate::{Error, Result};

/// Most colours that a picture keeps.
pub(super) const MOST_COLOURS: usize = 24;

/// How many zones a picture becomes: as many as it has colours once it is read.
pub(super) fn zones(albedo: &Slot<Texture>) -> usize {
    albedo.get().map_or(MOST_COLOURS, |picture| Palette::of(picture, MOST_COLOURS).colours.len())
}

impl FeatherObject {
    /// Refuses a picture on what it cannot colour.
    pub(super) fn agree_on_albedo(&self, place: &str) -> Result<()> {
        if self.albedo.is_none() {
            return Ok(());
        }
        let path = path_of(place, "albedo");
        if !self.zones.is_empty() {
            return Err(Error::input(format!("{path} and zones are both given; leave one out")));
        }
        let is_hair = |dress: &BarbuleDress| matches!(dress, BarbuleDress::Hair(_));
        let is_plain = is_hair(&self.dress.distal) && is_hair(&self.dress.proximal);
        if !is_plain || !matches!(self.dress.ramus, RamusDress::Hair(_)) {
            return Err(Error::input(format!(
                "{path} colours fibres, but rami or barbules are something else; give both of type 'hair', as [surfaces.hair] and [surfaces.barbule]"
            )));
        }
        Ok(())
    }

    /// The same with the picture's colours as zones; nothing where there is no picture.
    ///
    /// # Errors
    /// A picture that is not read.
    pub(super) fn coloured(&self) -> Result<Option<Self>> {
        let Some(slot) = &self.albedo else { return Ok(None) };
        let Palette { colours, places } = Palette::of(slot.value()?, MOST_COLOURS);
        let zones = colours.into_iter().map(|colour| self.zone_of(Colour(colour.map(encode)))).collect();
        let mut zone_map = Slot::new(&slot.name);
        zone_map.fill(places, slot.hash().to_owned());
        Ok(Some(Self { albedo: None, zones, zone_map: Some(zone_map), ..self.clone() }))
    }

    /// A zone of which rami and barbules have a colour.
    fn zone_of(&self, colour: Colour) -> Zone {
        let of = |fibre: &FibreDescription| fibre.with_vane_colour(colour);
        let barbule = |dress: &BarbuleDress| match dress {
            BarbuleDress::Hair(fibre) => BarbuleDress::Hair(of(fibre)),
            plates => plates.clone(),
        };
        let ramus = match &self.dress.ramus {
            RamusDress::Hair(fibre) => RamusDress::Hair(of(fibre)),
            other => other.clone(),
        };
        let [distal, proximal] = [&self.dress.distal, &self.dress.proximal].map(barbule);
        Zone { ramus: Some(ramus), distal: Some(distal), proximal: Some(proximal), ..Zone::everywhere() }
    }
}

#[cfg(test)]
mod tests {
    use super::{RamusDress, Zone};
    use crate::bsdf::Texture;
    use crate::scene::description::{ObjectShape, SceneDescription};

    fn scene(text: &str) -> crate::Result<SceneDescription> {
        SceneDescription::parse(&format!("preset = 'osprey'\n{text}"))
    }

    /// Of a picture of two colours there are two zones, where they are, whose fibres absorb what makes these colours; the scene comes back
    /// from its text.
    #[test]
    fn a_picture_becomes_zones_of_its_colours() {
        let mut scene = scene("albedo = 'scan.png'\n[detail]\nlevel = 'barbs'").unwrap();
        assert_eq!(SceneDescription::parse(&scene.to_toml().unwrap()).unwrap(), scene);
        assert!(scene.clone().wearing(None).unwrap_err().to_string().contains("albedo is not read"));
        let unread = scene.object_names().len();
        let ObjectShape::Feather(of) = &mut scene.objects[0].shape else { panic!() };
        let (dark, pale) = ([0.05_f32, 0.02, 0.01], [0.8, 0.7, 0.5]);
        let picture = Texture::new([2, 1], vec![dark, pale]).unwrap();
        of.albedo.as_mut().unwrap().fill(picture, "hash".into());
        let coloured = of.coloured().unwrap().unwrap();
        assert_eq!(coloured.zones.len(), 2);
        assert_eq!(coloured.zone_map.as_ref().unwrap().get().unwrap().highest_value().unwrap(), 2);
        let depth = |zone: &Zone| match &zone.ramus {
            Some(RamusDress::Hair(fibre)) => fibre.absorption(of.feather.cover()).unwrap().at(500.0),
            _ => f64::NAN,
        };
        let depths: Vec<f64> = coloured.zones.iter().map(depth).collect();
        assert!(depths[0].max(depths[1]) > 10.0 * depths[0].min(depths[1]), "{depths:?}");
        let (objects, _) = scene.clone().wearing(None).unwrap().objects(1).unwrap();
        assert_eq!(objects.len(), scene.object_names().len());
        assert_eq!(unread - objects.len(), 3 * (super::MOST_COLOURS - 2));
    }

    #[test]
    fn pictures_on_what_they_cannot_colour_are_refused() {
        let message = |text: &str| scene(text).unwrap_err().to_string();
        assert!(message("albedo = 'a.png'\nzones = [{along = [0, 0.5]}]").contains("both given"));
        let plates = SceneDescription::parse("preset = 'starling-feather'\nalbedo = 'a.png'").unwrap_err();
        assert!(plates.to_string().contains("albedo colours fibres"), "{plates}");
        let number = message("albedo = 3");
        assert!(number.contains("albedo is the number 3, but must be a text"), "{number}");
    }
}
