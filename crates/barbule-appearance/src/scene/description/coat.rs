//! `[coat]`: the scene's feather many times on a body.

use std::sync::Arc;

use glam::DVec3;
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::SceneDescription;
use super::colour::colour;
use super::detail::{Detail, DetailLevel, ViewModel};
use super::lights::point;
use super::objects::Placement;
use crate::brdf::FeatherBrdf;
use crate::bsdf::{Lambertian, Pictures, Surface};
use crate::fields::{Fields, list};
use crate::math::rng::hash;
use crate::scene::Object;
use crate::scene::coat::body::{Body, MOST_TRIANGLES};
use crate::scene::coat::field::Guide;
use crate::scene::coat::follicles::Region;
use crate::scene::coat::kinds::Kinds;
use crate::scene::coat::{Coat, Laid, MOST_FEATHERS, Number, Variant, edge_mm, seed_of, window};
use crate::scene::feather::{Counts, Level};
use crate::scene::geometry::{Geometry, Mesh, Place};
use crate::spectrum::colour::decode;
use crate::{Error, Result};

/// Most variants and guides.
const MOST_VARIANTS: usize = 64;
const MOST_GUIDES: usize = 1000;

/// Skin where no colour is given: dark grey.
const SKIN: [f64; 3] = [0.1, 0.09, 0.085];

/// What mattes call the skin.
const SKIN_NAME: &str = "skin";

/// Identity of the skin and of the feathers' places.
const COAT: u64 = 0x636f_6174;

/// Memory at most, bytes: of a feather's place in a part's list and in the hierarchy, of a body's triangle, and of a feather that is
/// grown, its barbs and their barbules one by one aside.
const BYTES_PER_PLACE: usize = 500;
const BYTES_PER_TRIANGLE: usize = 1500;
const BYTES_PER_VARIANT: usize = 8_000_000;

/// Objects that a feather has.
const PARTS: usize = 5;

/// A coat of the scene's feather.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CoatDescription {
    /// What it grows on.
    pub body: CoatBody,
    /// Where that stands.
    pub place: Placement,
    /// How the feathers stand.
    pub coat: Coat,
    /// The skin's colour on a screen, sRGB, 0 … 1.
    pub skin: [f64; 3],
}

/// A body under a coat.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum CoatBody {
    /// An ellipsoid about the origin.
    Ellipsoid {
        /// Its half axes along x, y, z, mm.
        radii_mm: [f64; 3],
    },
    /// A mesh from a file, in mm.
    Mesh {
        /// The file.
        #[serde(skip)]
        file: String,
        /// What is in it, once it is read.
        #[serde(skip)]
        mesh: Option<Arc<Mesh>>,
        /// BLAKE3 of the file.
        content: String,
    },
}

const KEYS: [&str; 17] = [
    "ellipsoid_mm",
    "mesh",
    "scale",
    "rotate_deg",
    "translate_mm",
    "count",
    "density_per_cm2",
    "within_mm",
    "guides",
    "erection_deg",
    "erection_jitter_deg",
    "turn_jitter_deg",
    "size_jitter",
    "variants",
    "clearance_mm",
    "hug",
    "skin_colour",
];

impl CoatDescription {
    pub(super) fn read(table: &Value) -> Result<Self> {
        let fields = Fields::new(table, "coat", &KEYS)?;
        let within = |key: &str, usual: f64, low: f64, high: f64| {
            fields.get(key).map_or(Ok(usual), |_| fields.number_within(key, low, high))
        };
        let coat = Coat {
            number: number(&fields)?,
            region: region(&fields)?,
            guides: guides(&fields)?,
            erection_deg: within("erection_deg", 8.0, 0.0, 60.0)?,
            erection_jitter_deg: within("erection_jitter_deg", 0.5, 0.0, 20.0)?,
            turn_jitter_deg: within("turn_jitter_deg", 3.0, 0.0, 60.0)?,
            size_jitter: within("size_jitter", 0.05, 0.0, 0.3)?,
            variants: fields
                .get("variants")
                .map_or(Ok(16), |_| fields.count_within("variants", 1, MOST_VARIANTS))?,
            clearance_mm: within("clearance_mm", 0.1, 0.0, 2.0)?,
            hug: within("hug", 1.0, 0.0, 1.0)?,
        };
        let skin = fields.get("skin_colour").map_or(Ok(SKIN), |value| colour(value, "coat.skin_colour"))?;
        Ok(Self { body: body(&fields)?, place: Placement::read(&fields)?, coat, skin })
    }

    /// Its table in a scene file.
    pub(super) fn table(&self) -> Value {
        let coat = &self.coat;
        let mut table = Map::new();
        let mut put = |key: &str, value: Value| table.insert(key.to_owned(), value);
        match &self.body {
            CoatBody::Ellipsoid { radii_mm } => put("ellipsoid_mm", json!(radii_mm)),
            CoatBody::Mesh { file, .. } => put("mesh", json!(file)),
        };
        put("scale", self.place.scale.into());
        put("rotate_deg", json!(self.place.rotate_deg));
        put("translate_mm", json!(self.place.translate_mm));
        match coat.number {
            Number::Count(count) => put("count", count.into()),
            Number::PerCm2(density) => put("density_per_cm2", density.into()),
        };
        if let Some(Region { low, high }) = coat.region {
            put("within_mm", json!([low, high]));
        }
        put("guides", coat.guides.iter().map(|guide| json!(guide)).collect());
        put("erection_deg", coat.erection_deg.into());
        put("erection_jitter_deg", coat.erection_jitter_deg.into());
        put("turn_jitter_deg", coat.turn_jitter_deg.into());
        put("size_jitter", coat.size_jitter.into());
        put("variants", coat.variants.into());
        put("clearance_mm", coat.clearance_mm.into());
        put("hug", coat.hug.into());
        put("skin_colour", json!(self.skin));
        Value::Object(table)
    }

    /// Memory that it takes while it is laid and its hierarchy is built, bytes, at most.
    pub(super) fn bytes(&self) -> usize {
        let feathers = match self.coat.number {
            Number::Count(count) => count,
            Number::PerCm2(_) => MOST_FEATHERS,
        };
        let triangles = match &self.body {
            CoatBody::Mesh { mesh: Some(mesh), .. } => mesh.triangles.len(),
            CoatBody::Mesh { .. } | CoatBody::Ellipsoid { .. } => 0,
        };
        feathers * PARTS * BYTES_PER_PLACE
            + (triangles + MOST_TRIANGLES) * BYTES_PER_TRIANGLE
            + self.coat.variants * BYTES_PER_VARIANT
    }

    fn grown_on(&self, edge_mm: f64) -> Result<(Body, Geometry)> {
        let place = self.place.place(COAT);
        match &self.body {
            CoatBody::Ellipsoid { radii_mm } => {
                let body = Body::ellipsoid(*radii_mm, &place, edge_mm);
                let skin = Geometry { meshes: vec![body.skin(COAT)], ..Geometry::default() };
                Ok((body, skin))
            }
            CoatBody::Mesh { mesh: Some(mesh), .. } => {
                let body = Body::mesh(mesh, &place, edge_mm).map_err(|error| error.at("coat.mesh"))?;
                let meshes = vec![Mesh { id: COAT, ..mesh.as_ref().clone() }];
                Ok((body, Geometry { meshes, places: vec![place], ..Geometry::default() }))
            }
            CoatBody::Mesh { file, .. } => Err(Error::input(format!("the mesh '{file}' is not read"))),
        }
    }
}

fn body(fields: &Fields<'_>) -> Result<CoatBody> {
    match (fields.get("ellipsoid_mm"), fields.text("mesh")?) {
        (Some(_), None) => match fields.numbers("ellipsoid_mm")?[..] {
            [x, y, z] if [x, y, z].iter().all(|v| (0.1..=1e4).contains(v)) => {
                Ok(CoatBody::Ellipsoid { radii_mm: [x, y, z] })
            }
            _ => Err(Error::input(
                "coat.ellipsoid_mm: give three half axes [x, y, z] in mm, each 0.1 to 10000",
            )),
        },
        (None, Some(file)) => {
            Ok(CoatBody::Mesh { file: file.to_owned(), mesh: None, content: String::new() })
        }
        (Some(_), Some(_)) => {
            Err(Error::input("coat.ellipsoid_mm and coat.mesh are both given; leave one out"))
        }
        (None, None) => Err(Error::input("[coat] has no body; give ellipsoid_mm or mesh")),
    }
}

fn number(fields: &Fields<'_>) -> Result<Number> {
    match (fields.get("count"), fields.get("density_per_cm2")) {
        (Some(_), None) => Ok(Number::Count(fields.count_within("count", 1, MOST_FEATHERS)?)),
        (None, Some(_)) => Ok(Number::PerCm2(fields.number_within("density_per_cm2", 1e-3, 1e5)?)),
        (Some(_), Some(_)) => {
            Err(Error::input("coat.count and coat.density_per_cm2 are both given; leave one out"))
        }
        (None, None) => {
            Err(Error::input("coat.count is missing; give the number of feathers, or density_per_cm2"))
        }
    }
}

fn region(fields: &Fields<'_>) -> Result<Option<Region>> {
    if fields.get("within_mm").is_none() {
        return Ok(None);
    }
    let corners = fields.list("within_mm", "two corners of a box")?;
    let corner = |value: &Value| -> Option<[f64; 3]> { serde_json::from_value(value.clone()).ok() };
    match corners {
        [low, high] => match (corner(low), corner(high)) {
            (Some(low), Some(high)) if (0..3).all(|k| low[k] < high[k]) => Ok(Some(Region { low, high })),
            _ => Err(box_wanted()),
        },
        _ => Err(box_wanted()),
    }
}

fn box_wanted() -> Error {
    Error::input(
        "coat.within_mm: give a box as [[x, y, z], [x, y, z]] in mm, each number of the second over that of the first",
    )
}

/// Where nothing is said feathers lie down the picture.
fn guides(fields: &Fields<'_>) -> Result<Vec<Guide>> {
    let Some(value) = fields.get("guides") else {
        return Ok(vec![Guide { position_mm: [0.0; 3], direction: DVec3::NEG_Y.into(), kind: 0 }]);
    };
    let guides = list(value, "coat.guides")?;
    if !(1..=MOST_GUIDES).contains(&guides.len()) {
        return Err(Error::input(format!("coat.guides: give 1 to {MOST_GUIDES} of them")));
    }
    let read = |(i, table): (usize, &Value)| {
        let place = format!("coat.guides[{i}]");
        let fields = Fields::new(table, &place, &["position_mm", "direction"])?;
        let direction = point(&fields, "direction")?;
        if DVec3::from(direction).length() < 1e-6 {
            return Err(Error::input(format!("{place}.direction has no length; give where feathers point")));
        }
        let position_mm =
            fields.get("position_mm").map_or(Ok([0.0; 3]), |_| point(&fields, "position_mm"))?;
        Ok(Guide { position_mm, direction, kind: 0 })
    };
    guides.iter().enumerate().map(read).collect()
}

impl SceneDescription {
    /// The coat as it is laid, and what is under it.
    ///
    /// # Errors
    /// A mesh that is not read, or that bears no coat.
    fn laid_on(&self, coat: &CoatDescription, seed: u64) -> Result<(Laid, Geometry)> {
        let feathers = std::slice::from_ref(&self.feather);
        let (body, skin) = coat.grown_on(edge_mm(feathers))?;
        Ok((coat.coat.lay(body, feathers, Kinds::Guides { mix_mm: 0.0 }, seed)?, skin))
    }

    /// The coat as it is laid; none where the scene has none.
    ///
    /// # Errors
    /// A number out of range, a mesh that is not read, or that bears no coat.
    pub fn laid_coat(&self, seed: u64) -> Result<Option<Laid>> {
        self.check()?;
        self.coat.as_ref().map(|coat| Ok(self.laid_on(coat, seed)?.0)).transpose()
    }

    /// The skin, then the parts of each variant, at their places.
    pub(super) fn coat_parts(
        &self,
        coat: &CoatDescription,
        brdf: Option<Arc<FeatherBrdf>>,
        seed: u64,
    ) -> Result<(Vec<Object>, Counts)> {
        let (laid, skin) = self.laid_on(coat, seed)?;
        let surface = Lambertian::painted(coat.skin.map(decode), Pictures::default())?;
        let mut objects = vec![Object { geometry: skin, surface: Surface::Lambertian(surface) }];
        let (mut counts, mut windows) = (Counts::default(), None);
        let mut one = Self { detail: self.coat_detail(), coat: None, ..self.clone() };
        for (variant, Variant { feather, .. }) in laid.variants.iter().enumerate() {
            (one.feather, one.window) = (*feather, window(feather));
            let (mut parts, own) = one.feather_parts(brdf.clone(), seed_of(variant, seed))?;
            // The vanes of all show the same swatches, which take memory once.
            match &windows {
                None => {
                    windows = Some(parts.iter().map(|part| part.geometry.window.clone()).collect::<Vec<_>>())
                }
                Some(windows) => parts.iter_mut().zip(windows).for_each(|(part, shared)| {
                    part.geometry.window = shared.clone().or(part.geometry.window.take());
                }),
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

    /// As fine as the scene says, or surfaces.
    fn coat_detail(&self) -> Detail {
        let level = match (self.detail.level, self.level()) {
            (_, Level::Envelopes) => Level::Envelopes,
            (DetailLevel::Auto, _) => Level::Vane,
            (_, level) => level,
        };
        Detail { level: DetailLevel::Fixed(level), ..self.detail }
    }

    /// Names of the parts of a coat, in their order.
    pub(super) fn coat_names(&self, coat: &CoatDescription) -> Vec<&'static str> {
        let one = Self { detail: self.coat_detail(), coat: None, ..self.clone() };
        let mut names = vec![SKIN_NAME];
        (0..coat.coat.variants).for_each(|_| names.extend(one.part_names()));
        names
    }

    /// Refuses a coat of what does not stand on a body.
    pub(super) fn check_coat(&self) -> Result<()> {
        if self.coat.is_none() {
            return Ok(());
        }
        if !self.shows_feather {
            return Err(Error::input(
                "shows_feather is false, but [coat] is made of the feather; leave one out",
            ));
        }
        if self.detail.level == DetailLevel::Fixed(Level::Barbs) {
            return Err(Error::input(
                "detail.level is 'barbs', but a coat's feathers are surfaces, envelopes or barbules; give 'vane'",
            ));
        }
        if self.detail.view_model == ViewModel::Both {
            return Err(Error::input(
                "detail.view_model is both, but [coat] has no second coat beside it; give substructure or fibre",
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let (objects, counts) = scene.objects(None, 3).unwrap();
        assert_eq!(objects.len(), 1 + 3 * PARTS);
        assert_eq!(scene.object_names().len(), objects.len());
        for part in 0..PARTS {
            let places: usize = (0..3).map(|v| objects[1 + v * PARTS + part].geometry.places.len()).sum();
            assert_eq!(places, 40);
        }
        let laid = scene.laid_coat(3).unwrap().unwrap();
        // The box is in the scene's own place: the body is 120 mm deep, of which it holds the upper 90 mm.
        assert!(laid.stands.iter().all(|stand| (0.0..=90.5).contains(&stand.spot.point.z)));
        assert!(counts.barbs > 0 && scene.object_bytes() > 0);
        let one = "[coat]\nellipsoid_mm = [80, 120, 80]\ncount = 1\nvariants = 3";
        let few = super::tests::scene(one).unwrap();
        let (objects, _) = few.objects(None, 3).unwrap();
        assert_eq!(objects.len(), few.object_names().len());
    }

    #[test]
    fn bad_coats_are_refused_by_key() {
        let message = |text: &str| scene(text).unwrap_err().to_string();
        let coat = |text: &str| message(&format!("[coat]\nellipsoid_mm = [9, 9, 9]\n{text}"));
        assert_eq!(message("[coat]\ncount = 5"), "[coat] has no body; give ellipsoid_mm or mesh");
        assert!(coat("mesh = 'a.ply'\ncount = 5").contains("both given"));
        assert!(message("[coat]\nellipsoid_mm = [9, 9]\ncount = 5").contains("three half axes"));
        assert!(coat("").starts_with("coat.count is missing"));
        assert!(coat("count = 5\ndensity_per_cm2 = 2").contains("both given"));
        assert_eq!(coat("count = 60000"), "coat.count is 60000, outside 1 to 50000");
        assert!(coat("count = 1.5").contains("whole number"));
        assert!(coat("count = 5\nguides = []").contains("give 1 to 1000"));
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
        let built = |text: &str| scene(text).unwrap().objects(None, 1).unwrap_err().to_string();
        assert_eq!(built("[coat]\nmesh = 'a.ply'\ncount = 5"), "the mesh 'a.ply' is not read");
        let far = "[coat]\nellipsoid_mm = [9, 9, 9]\ncount = 5\nwithin_mm = [[20, 0, 0], [30, 1, 1]]";
        assert!(built(far).contains("hardly any of the body's surface"));
        let dense = "[coat]\nellipsoid_mm = [900, 900, 900]\ndensity_per_cm2 = 99";
        assert!(built(dense).contains("coat.density_per_cm2 makes"));
    }
}
