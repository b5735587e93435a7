//! `[light]` and `[[lights]]`: the lamps of a scene.

use std::f64::consts::PI;

use glam::DVec3;

use super::colour::Colour;
use super::slot::Slot;
use super::{Bearing, MOST_TURN_DEG};
use crate::fields::{Fields, Key, Map, Record, Text, Value, within};
use crate::identity::Hasher;
use crate::scene::emission::Emission;
use crate::scene::light::{Light, Point, Rectangle, Sphere, Spot, Sun, disc_radiance};
use crate::scene::primaries::primaries;
use crate::spectrum::Spectrum;
use crate::spectrum::colour::{Illuminant, decode};
use crate::spectrum::glassner::Glassner;
use crate::spectrum::sensor::Band;
use crate::{Error, Result, record, variants};

/// Most lights of a scene: each is asked for at every ray that leaves a surface.
pub(super) const MOST_LIGHTS: usize = 64;

record! {
    /// The key light, a disc at infinity in daylight.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct KeyLight {
        /// Angular radius.
        radius_deg: f64 = "radius_deg" | "radius", within(0.1, 60);
        /// Irradiance over that of a sky of radiance 1; 0: there is none.
        strength: f64 = "strength", within(0, 1e4);
        @flat {
            /// Where it stands.
            bearing: Bearing;
        }
    }
}

record! {
    /// One lamp.
    #[derive(Debug, Clone, PartialEq)]
    pub struct LightDescription {
        /// Illuminance that a surface facing it gets at the origin over that under a sky of radiance 1.
        strength: f64 = "strength", within(0, 1e4);
        @flat {
            /// Its shape and place.
            shape: LightShape;
            /// Its colour.
            colour: LightColour;
        }
        @agree LightDescription::agree;
    }
}

variants! {
    /// What shines, and where.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub enum LightShape by "type" {
        /// A disc at infinity.
        "sun": Sun(SunShape),
        /// A point that shines alike into all directions.
        "point": Point(PointShape),
        /// A point that shines into a cone.
        "spot": Spot(SpotShape),
        /// A sphere.
        "sphere": Sphere(SphereShape),
        /// A rectangle that shines towards its target alone.
        "rectangle": Rectangle(RectangleShape),
    }
}

record! {
    /// A disc at infinity.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct SunShape {
        /// Angular radius.
        radius_deg: f64 = "radius_deg", within(0.1, 60), or 1.0;
        @flat {
            /// Where it stands.
            bearing: Bearing;
        }
    }
}

record! {
    /// A point.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct PointShape {
        @flat {
            /// Where it is.
            position: Position;
        }
    }
}

record! {
    /// A point that shines into a cone.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct SpotShape {
        /// What it points at.
        target: [f64; 3] = "target_mm", within(-1e6, 1e6), or [0.0; 3];
        /// Half angle of the cone.
        cone_deg: f64 = "cone_deg", within(0.1, 89);
        /// By how much earlier it begins to fade.
        edge_deg: f64 = "edge_deg", within(0, 89), or 0.0;
        @flat {
            /// Where it is.
            position: Position;
        }
    }
}

record! {
    /// A sphere.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct SphereShape {
        /// Its radius.
        radius_mm: f64 = "radius_mm", within(1e-3, 1e6);
        @flat {
            /// Its middle.
            position: Position;
        }
    }
}

record! {
    /// A rectangle.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct RectangleShape {
        /// What it faces.
        target: [f64; 3] = "target_mm", within(-1e6, 1e6), or [0.0; 3];
        /// Its width, which lies in the vane's plane, and its height.
        size_mm: [f64; 2] = "size_mm", within(1e-3, 1e6);
        @flat {
            /// Its middle.
            position: Position;
        }
    }
}

/// Where a lamp is, mm: told as a place, or as a bearing and a distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position(pub [f64; 3]);

record! {
    /// A place as files have it.
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct PositionKeys {
        /// Where it is.
        position_mm: Option<[f64; 3]> = "position_mm", within(-1e6, 1e6);
        /// In place of that, its azimuth.
        azimuth_deg: Option<f64> = "azimuth_deg", within(-MOST_TURN_DEG, MOST_TURN_DEG);
        /// Its elevation.
        elevation_deg: Option<f64> = "elevation_deg", within(-90, 90);
        /// How far it is.
        distance_mm: Option<f64> = "distance_mm", within(1e-3, 1e6);
    }
}

impl Position {
    fn keys_of(&self) -> PositionKeys {
        PositionKeys { position_mm: Some(self.0), azimuth_deg: None, elevation_deg: None, distance_mm: None }
    }
}

impl Record for Position {
    fn keys() -> Vec<Key> {
        PositionKeys::keys()
    }

    fn read_fields(fields: &Fields<'_>) -> Result<Self> {
        let keys = PositionKeys::read_fields(fields)?;
        if let Some(position) = keys.position_mm {
            let others = ["azimuth_deg", "elevation_deg", "distance_mm"];
            return match others.into_iter().find(|key| fields.get(key).is_some()) {
                None => Ok(Self(position)),
                Some(key) => Err(Error::input(format!(
                    "{} and {} are both given; leave one out",
                    fields.path("position_mm"),
                    fields.path(key)
                ))),
            };
        }
        let place = "position_mm, or azimuth_deg, elevation_deg and distance_mm";
        let need = |key: &str, value: Option<f64>| match value {
            Some(value) => Ok(value),
            None => fields.need(key, place).map(|_| 0.0),
        };
        let distance = need("distance_mm", keys.distance_mm)?;
        let bearing = Bearing {
            azimuth_deg: need("azimuth_deg", keys.azimuth_deg)?,
            elevation_deg: need("elevation_deg", keys.elevation_deg)?,
        };
        Ok(Self((bearing.direction() * distance).into()))
    }

    fn check_given(fields: &Fields<'_>) -> Result<()> {
        PositionKeys::check_given(fields)
    }

    fn write_into(&self, table: &mut Map<String, Value>) {
        self.keys_of().write_into(table);
    }

    fn check(&self, place: &str) -> Result<()> {
        self.keys_of().check(place)
    }

    fn feed_fields(&self, to: &mut Hasher) {
        to.numbers("position_mm", &self.0);
    }
}

/// The colour of a lamp; its brightness is the strength's.
#[derive(Debug, Clone, PartialEq)]
pub enum LightColour {
    /// An illuminant of the CIE, by its name.
    Illuminant(&'static str),
    /// Of a screen: sRGB, 0 … 1.
    Rgb([f64; 3]),
    /// A table of wavelengths in nm and relative powers.
    Table(Slot<Spectrum>),
    /// Linear R, G and B by Glassner's three functions, as in pictures of 2005; 0 where these are negative.
    Glassner([f64; 3]),
}

record! {
    /// A colour as files have it.
    #[derive(Debug, Clone, PartialEq)]
    struct ColourKeys {
        /// An illuminant of the CIE; D65 where no colour is given.
        illuminant: Option<String> = "illuminant", Text("the name of an illuminant, as in D65 or A");
        /// The colour that a screen shows.
        colour: Option<Colour> = "colour", ();
        /// A table of wavelengths in nm and relative powers.
        spectrum: Option<Slot<Spectrum>> = "spectrum", Text("the name of a file of wavelengths and powers");
        /// Linear R, G and B by Glassner's three functions, as in pictures of 2005; 0 where these are negative.
        glassner: Option<[f64; 3]> = "glassner", within(0, 1);
    }
}

impl LightColour {
    fn keys_of(&self) -> ColourKeys {
        let none = ColourKeys { illuminant: None, colour: None, spectrum: None, glassner: None };
        match self {
            Self::Illuminant(name) => ColourKeys { illuminant: Some((*name).to_owned()), ..none },
            Self::Rgb(rgb) => ColourKeys { colour: Some(Colour(*rgb)), ..none },
            Self::Table(spectrum) => ColourKeys { spectrum: Some(spectrum.clone()), ..none },
            Self::Glassner(rgb) => ColourKeys { glassner: Some(*rgb), ..none },
        }
    }
    /// As bright to the eye as daylight of radiance 1.
    pub(super) fn emission(&self) -> Result<Emission> {
        let emission = match self {
            Self::Illuminant("D65") => return Ok(Emission::daylight()),
            Self::Illuminant(name) => {
                let illuminant = Illuminant::named(name)?;
                Emission::new(|nm| illuminant.power(nm))?
            }
            Self::Rgb(rgb) => {
                let (rgb, basis) = (rgb.map(decode), primaries()?);
                Emission::new(|nm| rgb.iter().zip(&basis).map(|(weight, one)| weight * one.at(nm)).sum())?
            }
            Self::Glassner(rgb) => {
                let functions = Glassner::of_2005();
                Emission::new(|nm| if nm < 360.0 { 0.0 } else { functions.value(*rgb, nm).max(0.0) })?
            }
            Self::Table(slot) => {
                let table = slot.value()?;
                let power = |nm: f64| table.value(nm).unwrap_or(0.0);
                // What the eye does not see of a measurement may be a spectrometer's noise about 0.
                let held = |nm: f64| if Band::HUMAN.contains(nm) { power(nm) } else { power(nm).max(0.0) };
                Emission::new(held).map_err(|error| error.at(&slot.name))?
            }
        };
        let luminance = emission.luminance();
        if !(luminance.is_finite() && luminance > 0.0) {
            return Err(Error::input("a light has no power that the eye sees between 380 and 720 nm"));
        }
        Ok(emission.scaled(Emission::daylight().luminance() / luminance))
    }
}

impl Record for LightColour {
    fn keys() -> Vec<Key> {
        ColourKeys::keys()
    }

    fn read_fields(fields: &Fields<'_>) -> Result<Self> {
        let given: Vec<&str> = ["illuminant", "colour", "spectrum", "glassner"]
            .into_iter()
            .filter(|key| fields.get(key).is_some())
            .collect();
        if let [first, second, ..] = given[..] {
            return Err(Error::input(format!(
                "{} and {} are both given; leave one out",
                fields.path(first),
                fields.path(second)
            )));
        }
        match ColourKeys::read_fields(fields)? {
            ColourKeys { colour: Some(Colour::BLACK), .. } => Err(Error::input(format!(
                "{} is black; a lamp that is off has strength = 0",
                fields.path("colour")
            ))),
            ColourKeys { colour: Some(Colour(rgb)), .. } => Ok(Self::Rgb(rgb)),
            ColourKeys { spectrum: Some(spectrum), .. } => Ok(Self::Table(spectrum)),
            ColourKeys { glassner: Some(rgb), .. } if rgb.iter().all(|v| *v == 0.0) => Err(Error::input(
                format!("{} is black; a lamp that is off has strength = 0", fields.path("glassner")),
            )),
            ColourKeys { glassner: Some(rgb), .. } => Ok(Self::Glassner(rgb)),
            ColourKeys { illuminant, .. } => {
                let name = illuminant.as_deref().unwrap_or("D65");
                let found = Illuminant::named(name).map_err(|error| error.at(fields.path("illuminant")))?;
                let known = Illuminant::ALL.iter().find(|(_, known)| *known == found);
                Ok(Self::Illuminant(known.map_or("D65", |(name, _)| name)))
            }
        }
    }

    fn check_given(fields: &Fields<'_>) -> Result<()> {
        ColourKeys::check_given(fields)
    }

    fn write_into(&self, table: &mut Map<String, Value>) {
        self.keys_of().write_into(table);
    }

    fn check(&self, place: &str) -> Result<()> {
        self.keys_of().check(place)
    }

    fn feed_fields(&self, to: &mut Hasher) {
        self.keys_of().feed_fields(to);
    }
}

impl KeyLight {
    /// None.
    pub const OFF: Self =
        Self { radius_deg: 2.5, strength: 0.0, bearing: Bearing { azimuth_deg: 0.0, elevation_deg: 45.0 } };

    /// The lamp itself.
    #[must_use]
    pub fn build(&self) -> Light {
        let radius = self.radius_deg.to_radians();
        Light::Sun(Sun {
            direction: self.bearing.direction(),
            cos_radius: radius.cos(),
            emission: Emission::daylight().scaled(disc_radiance(radius, self.strength)),
        })
    }
}

fn length(v: [f64; 3]) -> f64 {
    DVec3::from(v).length()
}

impl LightDescription {
    /// Refuses what has no direction: a lamp that stands where it points at, or around the origin.
    fn agree(&self, place: &str) -> Result<()> {
        let apart = match self.shape {
            LightShape::Sun(SunShape { .. }) => return Ok(()),
            LightShape::Point(PointShape { position: Position(position) }) => length(position),
            LightShape::Spot(SpotShape { position: Position(position), target, cone_deg, edge_deg }) => {
                if edge_deg > cone_deg {
                    return Err(Error::input(format!(
                        "{place}.edge_deg is {edge_deg}, but must be at most cone_deg, {cone_deg}"
                    )));
                }
                if self.unit_emission().is_none() {
                    return Err(Error::input(format!(
                        "{place}: the middle of the scene lies outside the spot's cone, so no strength there can be given; turn target_mm"
                    )));
                }
                length(position).min((DVec3::from(position) - DVec3::from(target)).length())
            }
            LightShape::Sphere(SphereShape { position: Position(position), radius_mm }) => {
                if length(position) <= radius_mm {
                    return Err(Error::input(format!(
                        "{place}: the middle of the scene lies inside the sphere; give a smaller radius_mm or another place"
                    )));
                }
                length(position)
            }
            LightShape::Rectangle(RectangleShape { position: Position(position), target, .. }) => {
                if (DVec3::from(target) - DVec3::from(position)).dot(-DVec3::from(position)) <= 0.0 {
                    return Err(Error::input(format!(
                        "{place}: the rectangle turns its back to the middle of the scene; turn target_mm"
                    )));
                }
                length(position).min((DVec3::from(position) - DVec3::from(target)).length())
            }
        };
        if apart < 1e-3 {
            return Err(Error::input(format!(
                "{place}: stands within 0.001 mm of the scene's middle or of its target; give it a place of its own"
            )));
        }
        Ok(())
    }

    /// Radiance, or intensity of a point (per sr, for mm), of a light of this shape that has strength 1 at the origin; `None`
    /// where no light of it comes there.
    fn unit_emission(&self) -> Option<f64> {
        match self.shape {
            LightShape::Sun(SunShape { radius_deg, .. }) => Some(disc_radiance(radius_deg.to_radians(), 1.0)),
            LightShape::Point(PointShape { position: Position(position) }) => {
                Some(PI * DVec3::from(position).length_squared())
            }
            LightShape::Sphere(SphereShape { position: Position(position), radius_mm }) => {
                Some(DVec3::from(position).length_squared() / (radius_mm * radius_mm))
            }
            LightShape::Spot(SpotShape { .. }) | LightShape::Rectangle(RectangleShape { .. }) => {
                match self.light(&Emission::daylight()) {
                    Light::Spot(spot) => {
                        let share = spot.share(-spot.position.normalize_or_zero());
                        (share > 0.0).then(|| PI * spot.position.length_squared() / share)
                    }
                    Light::Rectangle(rectangle) => Some(PI / rectangle.irradiance_at_origin()),
                    Light::Sun(_) | Light::Point(_) | Light::Sphere(_) => None,
                }
            }
        }
    }

    /// The lamp itself.
    ///
    /// # Errors
    /// A table that is not read, or has no power between 380 and 720 nm.
    pub fn build(&self) -> Result<Light> {
        let scale = self.unit_emission().unwrap_or_default();
        Ok(self.light(&self.colour.emission()?.scaled(scale * self.strength)))
    }

    fn light(&self, emission: &Emission) -> Light {
        let emission = emission.clone();
        match self.shape {
            LightShape::Sun(SunShape { bearing, radius_deg }) => Light::Sun(Sun {
                direction: bearing.direction(),
                cos_radius: radius_deg.to_radians().cos(),
                emission,
            }),
            LightShape::Point(PointShape { position: Position(position) }) => {
                Light::Point(Point { position: position.into(), emission })
            }
            LightShape::Spot(SpotShape { position: Position(position), target, cone_deg, edge_deg }) => {
                Light::Spot(Spot {
                    position: position.into(),
                    axis: (DVec3::from(target) - DVec3::from(position)).normalize_or(DVec3::NEG_Z),
                    cos_outer: cone_deg.to_radians().cos(),
                    cos_inner: (cone_deg - edge_deg).to_radians().cos(),
                    emission,
                })
            }
            LightShape::Sphere(SphereShape { position: Position(position), radius_mm }) => {
                Light::Sphere(Sphere { centre: position.into(), radius: radius_mm, emission })
            }
            LightShape::Rectangle(RectangleShape { position: Position(position), target, size_mm }) => {
                let facing = (DVec3::from(target) - DVec3::from(position)).normalize_or(DVec3::NEG_Z);
                let level = DVec3::Z.cross(facing);
                let across = level.normalize_or(DVec3::X);
                let (u, v) = (across * size_mm[0], facing.cross(across) * size_mm[1]);
                let corner = DVec3::from(position) - 0.5 * (u + v);
                Light::Rectangle(Rectangle { corner, edge_u: u, edge_v: v, emission })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fields::{FieldValue as _, up_to};

    fn lights(text: &str) -> Result<Vec<LightDescription>> {
        let table: Value = toml::from_str(text).unwrap();
        Vec::<LightDescription>::of_value(&table["lights"], "lights", &up_to(MOST_LIGHTS))
    }

    /// Whatever the shape and the colour, a white card at the origin that faces the lamp is as bright as under the sky.
    #[test]
    fn strengths_are_illuminances_at_the_origin() {
        let text = "[[lights]]\ntype = 'sphere'\nposition_mm = [0, 0, 20]\nradius_mm = 4\nstrength = 2\nilluminant = 'A'\n\
                    [[lights]]\ntype = 'point'\nazimuth_deg = 0\nelevation_deg = 90\ndistance_mm = 20\nstrength = 2\ncolour = '#ff8000'\n\
                    [[lights]]\ntype = 'spot'\nposition_mm = [0, 0, 20]\ntarget_mm = [1, 0, 0]\ncone_deg = 20\nedge_deg = 19\nstrength = 2\nilluminant = 'd50'\n\
                    [[lights]]\ntype = 'rectangle'\nposition_mm = [3, 4, 12]\ntarget_mm = [1, 0, 0]\nsize_mm = [9, 5]\nstrength = 2\n\
                    [[lights]]\ntype = 'sun'\nazimuth_deg = 3\nelevation_deg = 80\nstrength = 2\nilluminant = 'E'\n";
        let lights = lights(text).unwrap();
        let white = Emission::daylight().luminance();
        for light in &lights {
            // Illuminance over π, in daylight of radiance 1.
            let found = match light.build().unwrap() {
                Light::Sphere(sphere) => {
                    let sine = sphere.radius / sphere.centre.length();
                    sphere.emission.luminance() * sine * sine
                }
                Light::Point(point) => point.emission.luminance() / PI / point.position.length_squared(),
                Light::Spot(spot) => {
                    spot.share(DVec3::NEG_Z) * spot.emission.luminance() / PI / spot.position.length_squared()
                }
                Light::Sun(sun) => sun.emission.luminance() * (1.0 - sun.cos_radius * sun.cos_radius),
                Light::Rectangle(Rectangle { corner, edge_u, edge_v, emission }) => {
                    let facing = (corner + 0.5 * (edge_u + edge_v)).normalize();
                    let (side, mut sum) = (400, 0.0);
                    for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
                        let [s, t] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(side));
                        let at: DVec3 = corner + edge_u * s + edge_v * t;
                        let cosines = facing.dot(at) * -edge_u.cross(edge_v).dot(at);
                        sum += cosines / at.length_squared().powi(2) / f64::from(side * side);
                    }
                    sum * emission.luminance() / PI
                }
            };
            // The rectangle's sum is a midpoint rule.
            assert!((found / white - 2.0).abs() < 1e-5, "{light:?}: {}", found / white);
        }
        let tungsten = lights[0].colour.emission().unwrap();
        assert!(tungsten.at(650.0) > 3.0 * tungsten.at(450.0));
    }

    #[test]
    fn bad_lights_are_refused_by_key() {
        let message = |text: &str| lights(&format!("[[lights]]\n{text}")).unwrap_err().to_string();
        assert!(message("strength = 1").contains("lights[0].type is missing"));
        assert!(message("type = 'spott'").contains("did you mean 'spot'"));
        assert!(message("type = 'point'\nstrengt = 1").contains("did you mean 'strength'"));
        assert!(message("type = 'point'\nstrength = 1").contains("lights[0].distance_mm is missing"));
        assert!(message("type = 'point'\nposition_mm = [0, 0]\nstrength = 1").contains("three numbers"));
        assert!(
            message("type = 'point'\nposition_mm = [0, 0, 0]\nstrength = 1").contains("a place of its own")
        );
        let sphere = "type = 'sphere'\nposition_mm = [0, 0, 5]\nstrength = 1\n";
        assert!(message(&format!("{sphere}radius_mm = 6")).contains("inside the sphere"));
        assert!(message(&format!("{sphere}radius_mm = 0")).contains("lights[0].radius_mm is 0, outside"));
        assert!(
            message(&format!("{sphere}radius_mm = 1\nilluminant = 'D56'")).contains("did you mean 'D65'")
        );
        assert!(
            message(&format!("{sphere}radius_mm = 1\nilluminant = 'A'\ncolour = '#ffffff'"))
                .contains("both given")
        );
        assert!(message(&format!("{sphere}radius_mm = 1\ncolour = '#000000'")).contains("is black"));
        let spot = "type = 'spot'\nposition_mm = [0, 0, 5]\nstrength = 1\ncone_deg = 10\n";
        assert!(message(&format!("{spot}edge_deg = 11")).contains("at most cone_deg"));
        assert!(message(&format!("{spot}target_mm = [9, 0, 5]")).contains("outside the spot's cone"));
        let rectangle = "type = 'rectangle'\nposition_mm = [0, 0, 5]\nstrength = 1\nsize_mm = [1, 1]\n";
        assert!(message(&format!("{rectangle}target_mm = [0, 0, 9]")).contains("turns its back"));
        let many = "[[lights]]\ntype = 'point'\nposition_mm = [0, 0, 5]\nstrength = 1\n".repeat(65);
        assert!(lights(&many).unwrap_err().to_string().contains("over the limit of 64"));
    }
}
