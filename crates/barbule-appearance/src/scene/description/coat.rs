//! Coats: feathers many times on a body.

use std::sync::Arc;

use glam::DVec3;

use super::colour::Colour;
use super::detail::{Detail, DetailLevel, ViewModel};
use super::dress::Dress;
use super::form::FormDescription;
use super::objects::Placement;
use super::slot::Slot;
use crate::bsdf::{Lambertian, NumberMap, Pictures, Surface, Texture};
use crate::fields::{Several, Text, up_to, within};
use crate::math::rng::hash;
use crate::progress::{Progress, Unobserved};
use crate::scene::Object;
use crate::scene::coat::body::{Body, MOST_TRIANGLES};
use crate::scene::coat::field::Guide;
use crate::scene::coat::follicles::{Bare, Region};
use crate::scene::coat::kinds::Kinds;
use crate::scene::coat::{Coat, Laid, MOST_FEATHERS, MOST_LIFT, Number, Variant, seed_of, window};
use crate::scene::faces::{outwards, turned_round};
use crate::scene::feather::{Counts, Feather, Level};
use crate::scene::geometry::{Geometry, Mesh, Place};
use crate::scene::memory::PER_PLACE;
use crate::scene::window::Window;
use crate::spectrum::colour::decode;
use crate::{Error, Result, record};

/// Most variants, guides and kinds of feathers beside the first.
const MOST_VARIANTS: u8 = 64;
const MOST_GUIDES: usize = 1000;
const MOST_KINDS: usize = 254;
const MOST_BARE: usize = 200;

/// Skin where no colour is given: dark grey.
const SKIN: Colour = Colour([0.1, 0.09, 0.085]);

/// Identity of the skin and of the feathers' places.
const COAT: u64 = 0x636f_6174;

/// Memory at most of a body's triangle while it is laid, bytes.
const PER_BODY_TRIANGLE: f64 = 1500.0;

/// Objects that a feather has.
const PARTS: usize = 5;

/// A coat of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct CoatObject {
    /// What it grows on, and how its feathers stand.
    pub coat: CoatDescription,
    /// Its feathers.
    pub feather: Feather,
    /// How finely they are made.
    pub detail: Detail,
    /// What their parts are made of.
    pub dress: Dress,
}

record! {
    /// What a coat grows on, and how its feathers stand.
    #[derive(Debug, Clone, PartialEq)]
    pub struct CoatDescription {
        /// Half axes of an ellipsoid that it grows on.
        ellipsoid_mm: Option<[f64; 3]> = "ellipsoid_mm", within(0.1, 1e4);
        /// A body that it grows on, made of ellipsoids and tubes.
        form: Option<FormDescription> = "form", ();
        /// A mesh that it grows on, in mm.
        mesh: Option<Slot<Mesh>> = "mesh", Text("the name of a .ply, .obj, .gltf or .glb");
        /// Whether they grow on the other side of an open mesh than that to which its faces look; of a closed one they grow outwards.
        other_side: bool = "other_side", (), or false;
        /// How many feathers there are.
        count: Option<usize> = "count", within(1, MOST_FEATHERS as f64);
        /// In place of that, how many on the body's surface.
        density_per_cm2: Option<f64> = "density_per_cm2", within(1e-3, 1e5);
        /// Two corners of a box outside which none grow.
        within_mm: Option<Vec<[f64; 3]>> = "within_mm", Several { least: 0, most: 64, of: within(-1e6, 1e6) };
        /// Balls in which no feathers grow, and into which those about them do not reach.
        bare: Vec<BareDescription> = "bare", up_to(MOST_BARE), or Vec::new();
        /// Directions in which they lie; down the picture where nothing is said.
        guides: Vec<GuideDescription> = "guides", Several { least: 1, most: MOST_GUIDES, of: () }, or vec![DOWN];
        /// Angle between the skin and a feather's base.
        erection_deg: f64 = "erection_deg", within(0, 60), or 8.0;
        /// Its standard deviation.
        erection_jitter_deg: f64 = "erection_jitter_deg", within(0, 20), or 0.5;
        /// Standard deviation of their turn within the skin.
        turn_jitter_deg: f64 = "turn_jitter_deg", within(0, 60), or 3.0;
        /// Standard deviation of their size, as a share.
        size_jitter: f64 = "size_jitter", within(0, 0.3), or 0.05;
        /// How many are grown of each kind; each stands at many places.
        variants: usize = "variants", within(1, MOST_VARIANTS), or 16;
        /// How far over the feathers beneath they lie.
        clearance_mm: f64 = "clearance_mm", within(0, 2), or 0.1;
        /// By how much a feather is lifted at most to lie over those beneath.
        most_lift_deg: Option<f64> = "most_lift_deg", within(0, 60);
        /// 0: bent as the feather says; 1: bent as the body is.
        hug: f64 = "hug", within(0, 1), or 1.0;
        /// Colour of the skin.
        skin_colour: Colour = "skin_colour", (), or SKIN;
        /// Further kinds of feathers, from 1; the object's own is kind 0.
        feathers: Vec<CoatFeather> = "feathers", up_to(MOST_KINDS), or Vec::new();
        /// Width of the band over which the kinds of neighbouring guides mix.
        mix_mm: f64 = "mix_mm", within(0, 1000), or 0.0;
        /// A grey picture over the body's texture coordinates: pixels of value i (of 255) bear the i-th kind.
        map: Option<Slot<Texture>> = "map", Text("a grey .png");
        @agree CoatDescription::agree;
    }
}

record! {
    /// A direction that feathers near a place take.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct GuideDescription {
        /// The place.
        position_mm: [f64; 3] = "position_mm", within(-1e6, 1e6), or [0.0; 3];
        /// From a feather's root to its tip; of any length.
        direction: [f64; 3] = "direction", within(-1e6, 1e6);
        /// Which kind of feather grows about there.
        kind: usize = "kind", within(0, 254), or 0;
        /// Factor to their size there; between guides it changes evenly, and follicles stand as near as it asks for.
        size: f64 = "size", within(0.02, 50), or 1.0;
        /// Angle between the skin and their base there; the coat's where nothing is said.
        erection_deg: Option<f64> = "erection_deg", within(0, 60);
        @agree GuideDescription::agree;
    }
}

record! {
    /// A ball in which no feather grows.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct BareDescription {
        /// Its middle.
        position_mm: [f64; 3] = "position_mm", within(-1e6, 1e6);
        /// Its radius.
        radius_mm: f64 = "radius_mm", within(1e-3, 1e6);
    }
}

record! {
    /// A further kind of feather of a coat.
    #[derive(Debug, Clone, PartialEq)]
    pub struct CoatFeather {
        /// Its sizes, or the name of a type.
        feather: Feather = "feather", ();
        /// What its parts are made of.
        dress: Dress = "dress", ();
    }
}

/// Where nothing is said feathers lie down the picture.
const DOWN: GuideDescription = GuideDescription {
    position_mm: [0.0; 3],
    direction: [0.0, -1.0, 0.0],
    kind: 0,
    size: 1.0,
    erection_deg: None,
};

impl GuideDescription {
    fn agree(&self, place: &str) -> Result<()> {
        if DVec3::from(self.direction).length() < 1e-6 {
            return Err(Error::input(format!("{place}.direction has no length; give where feathers point")));
        }
        Ok(())
    }
}

impl CoatDescription {
    fn agree(&self, place: &str) -> Result<()> {
        let both = |a: &str, b: &str| {
            Err(Error::input(format!("{place}.{a} and {place}.{b} are both given; leave one out")))
        };
        match (&self.ellipsoid_mm, &self.form, &self.mesh) {
            (Some(_), Some(_), _) => return both("ellipsoid_mm", "form"),
            (Some(_), _, Some(_)) => return both("ellipsoid_mm", "mesh"),
            (_, Some(_), Some(_)) => return both("form", "mesh"),
            (None, None, None) => {
                return Err(Error::input(format!("[{place}] has no body; give ellipsoid_mm, form or mesh")));
            }
            _ => {}
        }
        match (self.count, self.density_per_cm2) {
            (Some(_), Some(_)) => return both("count", "density_per_cm2"),
            (None, None) => {
                return Err(Error::input(format!(
                    "{place}.count is missing; give the number of feathers, or density_per_cm2"
                )));
            }
            _ => {}
        }
        if self.within_mm.is_some() && self.region().is_none() {
            return Err(Error::input(format!(
                "{place}.within_mm: give a box as [[x, y, z], [x, y, z]] in mm, each number of the second over that of the first"
            )));
        }
        let kinds = self.feathers.len();
        if let Some((i, guide)) = self.guides.iter().enumerate().find(|(_, guide)| guide.kind > kinds) {
            return Err(Error::input(format!(
                "{place}.guides[{i}].kind is {}, but the coat has {} kinds of feathers, from 0",
                guide.kind,
                kinds + 1
            )));
        }
        if self.map.is_some() && kinds == 0 {
            return Err(Error::input(format!(
                "{place}.map is given, but {place}.feathers has no further kinds"
            )));
        }
        Ok(())
    }

    fn region(&self) -> Option<Region> {
        match self.within_mm.as_deref() {
            Some(&[low, high]) if (0..3).all(|k| low[k] < high[k]) => Some(Region { low, high }),
            _ => None,
        }
    }

    fn number(&self) -> Number {
        match (self.count, self.density_per_cm2) {
            (Some(count), _) => Number::Count(count),
            (None, density) => Number::PerCm2(density.unwrap_or_default()),
        }
    }

    fn coat(&self) -> Coat {
        let guide =
            |&GuideDescription { position_mm, direction, kind, size, erection_deg }: &GuideDescription| {
                Guide { position_mm, direction, kind, size, erection_deg }
            };
        let bare =
            |&BareDescription { position_mm, radius_mm }: &BareDescription| Bare { position_mm, radius_mm };
        Coat {
            number: self.number(),
            region: self.region(),
            bare: self.bare.iter().map(bare).collect(),
            guides: self.guides.iter().map(guide).collect(),
            erection_deg: self.erection_deg,
            erection_jitter_deg: self.erection_jitter_deg,
            turn_jitter_deg: self.turn_jitter_deg,
            size_jitter: self.size_jitter,
            variants: self.variants,
            clearance_mm: self.clearance_mm,
            most_lift: self.most_lift_deg.map_or(MOST_LIFT, f64::to_radians),
            hug: self.hug,
        }
    }

    fn grown_on(
        &self,
        placement: &Placement,
        edge_mm: f64,
        progress: &dyn Progress,
    ) -> Result<(Body, Geometry)> {
        let place = placement.place(COAT);
        match (&self.ellipsoid_mm, &self.form, &self.mesh) {
            (Some(radii_mm), ..) => {
                let body = Body::ellipsoid(*radii_mm, &place, edge_mm);
                let skin = Geometry { meshes: vec![body.skin(COAT)], ..Geometry::default() };
                Ok((body, skin))
            }
            (None, Some(form), _) => {
                let mesh = Mesh { id: COAT, ..form.mesh(progress)? };
                let body = Body::mesh(&mesh, &place, edge_mm).map_err(|error| error.at("coat.form"))?;
                Ok((body, Geometry { meshes: vec![mesh], places: vec![place], ..Geometry::default() }))
            }
            (None, None, Some(mesh)) => {
                let mesh = mesh.value()?;
                let turned;
                let sided = if self.other_side {
                    turned = turned_round(mesh);
                    &turned
                } else {
                    mesh.as_ref()
                };
                let body = Body::mesh(sided, &place, edge_mm).map_err(|error| error.at("coat.mesh"))?;
                let meshes = vec![Mesh { id: COAT, ..outwards(sided.clone()) }];
                Ok((body, Geometry { meshes, places: vec![place], ..Geometry::default() }))
            }
            (None, None, None) => Err(Error::input("[coat] has no body; give ellipsoid_mm, form or mesh")),
        }
    }
}

impl CoatObject {
    /// Refuses a coat of what does not stand on a body.
    pub(super) fn agree(&self, place: &str) -> Result<()> {
        let path = |key: &str| crate::fields::path_of(place, key);
        if self.detail.view_model == ViewModel::Both {
            return Err(Error::input(format!(
                "{} is both, but [coat] has no second coat beside it; give substructure or fibre",
                path("detail.view_model")
            )));
        }
        Ok(())
    }

    /// The coat as it is laid, and what is under it.
    fn laid_on(&self, place: &Placement, seed: u64, progress: &dyn Progress) -> Result<(Laid, Geometry)> {
        let further = self.coat.feathers.iter().map(|kind| kind.feather);
        let feathers: Vec<Feather> = std::iter::once(self.feather).chain(further).collect();
        let coat = self.coat.coat();
        let (body, skin) = self.coat.grown_on(place, coat.edge_mm(&feathers), progress)?;
        let map = self.coat.map.as_ref().map(|slot| {
            let map = NumberMap::new(Texture::clone(slot.value()?), feathers.len(), "kinds of feathers");
            map.map_err(|error| error.at(&slot.name))
        });
        let map = map.transpose()?;
        let kinds = match &map {
            Some(map) => Kinds::Map(map),
            None => Kinds::Guides { mix_mm: self.coat.mix_mm },
        };
        Ok((coat.lay_watched(body, &feathers, kinds, seed, progress)?, skin))
    }

    /// The coat as it is laid.
    ///
    /// # Errors
    /// A mesh that is not read, or that bears no coat.
    pub fn laid(&self, place: &Placement, seed: u64) -> Result<Laid> {
        Ok(self.laid_on(place, seed, &Unobserved)?.0)
    }

    /// The skin, then the parts of each variant, at their places; `width_mm`: of the picture.
    pub(super) fn parts(
        &self,
        place: &Placement,
        width_mm: f64,
        seed: u64,
        progress: &dyn Progress,
    ) -> Result<(Vec<Object>, Counts)> {
        let (laid, skin) = self.laid_on(place, seed, progress)?;
        let surface = Lambertian::painted(self.coat.skin_colour.0.map(decode), Pictures::default())?;
        let mut objects = vec![Object { geometry: skin, surface: Surface::Lambertian(surface) }];
        let (mut counts, mut windows) = (Counts::default(), None);
        let detail = self.detail_on_body(width_mm);
        for (variant, Variant { kind, feather }) in laid.variants.iter().enumerate() {
            let one = self.one(*kind, *feather, detail);
            let (mut parts, own) = one.parts(width_mm, seed_of(variant, seed), progress)?;
            // The vanes of all of a kind show the same swatches, which take memory once.
            match &windows {
                Some((shown, windows)) if shown == kind => {
                    parts.iter_mut().zip(windows).for_each(
                        |(part, window): (&mut Object, &Option<Arc<Window>>)| {
                            part.geometry.window = window.clone().or(part.geometry.window.take());
                        },
                    );
                }
                _ => {
                    let own = parts.iter().map(|part| part.geometry.window.clone()).collect::<Vec<_>>();
                    windows = Some((*kind, own));
                }
            }
            let at_variant = laid.stands.iter().enumerate().filter(|(_, stand)| stand.variant == variant);
            let places: Vec<Place> =
                at_variant.map(|(index, stand)| stand.place(hash(COAT, &[index as u64]))).collect();
            counts.barbs += own.barbs * places.len();
            counts.barbules += own.barbules * places.len();
            // A variant that stands nowhere, in a coat of few feathers, has no shape.
            let placed = |geometry: Geometry| match places.is_empty() {
                true => Geometry::default(),
                false => Geometry { places: places.clone(), ..geometry },
            };
            objects.extend(parts.into_iter().map(|part| Object { geometry: placed(part.geometry), ..part }));
        }
        Ok((objects, counts))
    }

    /// One of its feathers.
    fn one(&self, kind: usize, feather: Feather, detail: Detail) -> super::FeatherObject {
        let further = kind.checked_sub(1).and_then(|index| self.coat.feathers.get(index));
        super::FeatherObject {
            feather,
            window: window(&feather),
            detail,
            dress: further.map_or(&self.dress, |kind| &kind.dress).clone(),
            zones: Vec::new(),
            zone_map: None,
            albedo: None,
        }
    }

    /// Memory that it takes while it is laid and its hierarchy is built, bytes, at most; `triangles`: of the mesh that it grows on.
    pub(super) fn bytes(&self, triangles: f64, width_mm: f64) -> f64 {
        let feathers = self.coat.count.unwrap_or(MOST_FEATHERS);
        let detail = self.detail_on_body(width_mm);
        let further = self.coat.feathers.iter().map(|kind| kind.feather);
        let mut most_places = PARTS as f64;
        let variants: f64 = std::iter::once(self.feather)
            .chain(further)
            .enumerate()
            .map(|(kind, feather)| {
                let one = self.one(kind, feather, detail);
                let shown = one.shown_bytes(width_mm);
                most_places = most_places.max(one.places(width_mm));
                // Each variant makes what its vanes show, but all of a kind show the first one's.
                self.coat.variants as f64 * (one.bytes(width_mm) - shown) + 2.0 * shown
            })
            .sum();
        feathers as f64 * most_places * PER_PLACE
            + (triangles + MOST_TRIANGLES as f64) * PER_BODY_TRIANGLE
            + variants
    }

    /// As fine as is said, or surfaces.
    fn detail_on_body(&self, width_mm: f64) -> Detail {
        let level =
            match (self.detail.level, self.detail.level_of(&self.feather, window(&self.feather), width_mm)) {
                (_, Level::Envelopes) => DetailLevel::Envelopes,
                (DetailLevel::Auto, _) => DetailLevel::Vane,
                (level, _) => level,
            };
        Detail { level, ..self.detail }
    }

    /// Names of its parts, in their order.
    pub(super) fn part_names(&self, width_mm: f64) -> Vec<String> {
        let one = self.one(0, self.feather, self.detail_on_body(width_mm));
        let mut names = vec!["skin".to_owned()];
        (0..self.coat.variants * (1 + self.coat.feathers.len()))
            .for_each(|_| names.extend(one.part_names(width_mm)));
        names
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::coat::Stand;
    use crate::scene::description::{Foreseen, ObjectShape, SceneDescription};
    use crate::scene::faces::Facing;

    fn scene(text: &str) -> Result<SceneDescription> {
        SceneDescription::parse(&format!("preset = 'osprey'\n{text}"))
    }

    /// Every part at the places of its variant, each feather once; names for all; the scene comes back from its text.
    #[test]
    fn a_coat_is_its_variants_at_their_places() {
        let text = "[detail]\nlevel = 'vane'\n[coat]\nellipsoid_mm = [80, 120, 80]\ncount = 40\nvariants = 3\n\
                    within_mm = [[-90, -130, 0], [90, 130, 90.5]]\nskin_colour = '#402010'\nscale = 1.5\n\
                    guides = [{direction = [0, -1, 0.25]}, {position_mm = [0, 100, 0], direction = [1, 0, 0]}]";
        let scene = scene(text).unwrap();
        assert_eq!(SceneDescription::parse(&scene.to_toml().unwrap()).unwrap(), scene);
        let (objects, counts) = scene.clone().wearing(None).unwrap().objects(3).unwrap();
        assert_eq!(objects.len(), 1 + 3 * PARTS);
        assert_eq!(scene.object_names().len(), objects.len());
        for part in 0..PARTS {
            let places: usize = (0..3).map(|v| objects[1 + v * PARTS + part].geometry.places.len()).sum();
            assert_eq!(places, 40);
        }
        let laid = scene.laid_coats(3).unwrap().remove(0);
        // The box is in the scene's own place: the body is 120 mm deep, of which it holds the upper 90 mm.
        assert!(laid.stands.iter().all(|stand| (0.0..=90.5).contains(&stand.spot.point.z)));
        assert!(counts.barbs > 0 && scene.bytes(&Foreseen::new()) > 0);
        let one = "[coat]\nellipsoid_mm = [80, 120, 80]\ncount = 1\nvariants = 3";
        let few = super::tests::scene(one).unwrap();
        let (objects, _) = few.clone().wearing(None).unwrap().objects(3).unwrap();
        assert_eq!(objects.len(), few.object_names().len());
    }

    /// The birds that ship, with a twentieth of their feathers on a coarser skin: every part of them is there, feathers grow on closed
    /// skins and in no bare place, and each tract has its own size.
    #[test]
    fn birds_wear_their_coats() {
        // Bodies in coarser steps, but for the dove, whose eyes' sockets would break through them.
        for (name, kinds, coarser) in [
            ("mallard-head", 3, 2.0),
            ("hummingbird-gorget", 3, 2.0),
            ("starling-bird", 3, 1.5),
            ("dove-bird", 5, 1.0),
        ] {
            let mut scene = SceneDescription::named(name).unwrap();
            for object in &mut scene.objects {
                if let ObjectShape::Coat(of) = &mut object.shape {
                    of.coat.density_per_cm2 = of.coat.density_per_cm2.map(|density| density / 20.0);
                    of.coat.variants = 1;
                    let form = of.coat.form.as_mut().unwrap();
                    form.resolution_mm *= coarser;
                    assert!(!Facing::of_mesh(&form.mesh(&Unobserved).unwrap()).is_open, "{name}");
                }
            }
            let laid = scene.laid_coats(1).unwrap().remove(0);
            let stands = &laid.stands;
            assert!((100..2000).contains(&stands.len()), "{name}: {}", stands.len());
            assert!((0..kinds).all(|kind| stands.iter().any(|stand| stand.kind == kind)), "{name}");
            let sizes = || stands.iter().map(|stand| stand.size);
            let [least, most] = [sizes().fold(f64::MAX, f64::min), sizes().fold(0.0, f64::max)];
            assert!(most / least > 3.0, "{name}: {least} {most}");
            let ObjectShape::Coat(of) = &scene.objects[0].shape else { panic!() };
            for bare in &of.coat.bare {
                let far = |stand: &Stand| (stand.spot.point - DVec3::from(bare.position_mm)).length();
                assert!(stands.iter().all(|stand| far(stand) >= bare.radius_mm), "{name}");
            }
        }
    }

    #[test]
    fn bad_coats_are_refused_by_key() {
        let message = |text: &str| scene(text).unwrap_err().to_string();
        let coat = |text: &str| message(&format!("[coat]\nellipsoid_mm = [9, 9, 9]\n{text}"));
        assert_eq!(message("[coat]\ncount = 5"), "[coat] has no body; give ellipsoid_mm, form or mesh");
        assert!(coat("mesh = 'a.ply'\ncount = 5").contains("both given"));
        assert!(
            message("[coat]\nellipsoid_mm = [9, 9]\ncount = 5")
                .contains("coat.ellipsoid_mm has 2 numbers; give three numbers")
        );
        assert!(coat("").starts_with("coat.count is missing"));
        assert!(coat("count = 5\ndensity_per_cm2 = 2").contains("both given"));
        assert_eq!(coat("count = 60000"), "coat.count is 60000, outside 1 to 50000");
        assert!(coat("count = 1.5").contains("whole number"));
        assert!(coat("count = 5\nguides = []").contains("give 1 to 1000 of them"));
        assert!(coat("count = 5\nguides = [{direction = [0, 0, 0]}]").contains("coat.guides[0].direction"));
        assert!(
            coat("count = 5\nguides = [{position_mm = [0, 0, 0]}]")
                .contains("guides[0].direction is missing")
        );
        assert!(coat("count = 5\nwithin_mm = [[0, 0, 0], [1, -1, 1]]").contains("give a box"));
        assert!(coat("count = 5\nwithin_mm = [[0, 0, 0]]").contains("give a box"));
        assert!(coat("count = 5\nhug = 2").contains("coat.hug is 2, outside 0 to 1"));
        assert!(coat("count = 5\nerection = 2").contains("did you mean 'erection_deg'"));
        assert!(coat("count = 5\n[detail]\nview_model = 'both'").contains("no second coat"));
        assert!(
            message("shows_feather = false\n[coat]\nellipsoid_mm = [9, 9, 9]\ncount = 5")
                .contains("shows_feather")
        );
        let built = |text: &str| scene(text).unwrap().laid_coats(1).unwrap_err().to_string();
        assert_eq!(built("[coat]\nmesh = 'a.ply'\ncount = 5"), "'a.ply' is not read");
        let far = "[coat]\nellipsoid_mm = [9, 9, 9]\ncount = 5\nwithin_mm = [[20, 0, 0], [30, 1, 1]]";
        assert!(built(far).contains("leave hardly any of the body's surface"));
        let dense = "[coat]\nellipsoid_mm = [900, 900, 900]\ndensity_per_cm2 = 99";
        assert!(built(dense).contains("coat.density_per_cm2 makes"));
    }
}
