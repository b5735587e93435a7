//! `[[lights]]`: further lamps of a scene.

use std::f64::consts::PI;

use glam::DVec3;
use serde::Serialize;
use serde_json::Value;

use super::colour::colour;
use super::kinds::kind_of;
use super::{Bearing, MOST_TURN_DEG};
use crate::fields::{Fields, list};
use crate::scene::emission::Emission;
use crate::scene::light::{Light, Point, Rectangle, Sphere, Spot, Sun, disc_radiance};
use crate::scene::primaries::primaries;
use crate::spectrum::Spectrum;
use crate::spectrum::colour::{Illuminant, decode};
use crate::spectrum::sensor::Band;
use crate::{Error, Result};

/// Most lights of a scene: each is asked for at every ray that leaves a surface.
const MOST_LIGHTS: usize = 64;

/// One lamp beside the key light.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LightDescription {
    /// Its shape and place.
    pub shape: LightShape,
    /// Its colour.
    pub colour: LightColour,
    /// Illuminance that a surface facing it gets at the origin over that under a sky of radiance 1.
    pub strength: f64,
}

/// What shines, and where. Lengths are mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum LightShape {
    /// A disc at infinity.
    Sun {
        /// Where it stands.
        bearing: Bearing,
        /// Angular radius, degrees.
        radius_deg: f64,
    },
    /// A point that shines alike into all directions.
    Point {
        /// Where it is.
        position: [f64; 3],
    },
    /// A point that shines into a cone.
    Spot {
        /// Where it is.
        position: [f64; 3],
        /// What it points at.
        target: [f64; 3],
        /// Half angle of the cone, degrees.
        cone_deg: f64,
        /// By how much earlier it begins to fade, degrees.
        edge_deg: f64,
    },
    /// A sphere.
    Sphere {
        /// Its middle.
        position: [f64; 3],
        /// Its radius.
        radius_mm: f64,
    },
    /// A rectangle that shines towards its target alone.
    Rectangle {
        /// Its middle.
        position: [f64; 3],
        /// What it faces.
        target: [f64; 3],
        /// Its width, which lies in the vane's plane, and its height.
        size_mm: [f64; 2],
    },
}

/// The colour of a lamp; its brightness is the strength's.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum LightColour {
    /// An illuminant of the CIE, by its name.
    Illuminant(&'static str),
    /// Of a screen: sRGB, 0 … 1.
    Rgb([f64; 3]),
    /// A table of wavelengths in nm and relative powers.
    Table {
        /// The file.
        #[serde(skip)]
        file: String,
        /// What is in it, once it is read: wavelengths and values.
        #[serde(serialize_with = "numbers")]
        spectrum: Option<Spectrum>,
    },
}

fn numbers<S: serde::Serializer>(spectrum: &Option<Spectrum>, to: S) -> std::result::Result<S::Ok, S::Error> {
    spectrum.as_ref().map(|spectrum| (spectrum.wavelengths().nm(), spectrum.values())).serialize(to)
}

const TYPES: [&str; 5] = ["sun", "point", "spot", "sphere", "rectangle"];

/// Keys that all lights have.
const COMMON: [&str; 5] = ["type", "strength", "illuminant", "colour", "spectrum"];

/// Keys that say where a lamp stands.
const PLACE: [&str; 4] = ["position_mm", "azimuth_deg", "elevation_deg", "distance_mm"];

/// Reads the list `[[lights]]`.
pub(super) fn read(value: &Value) -> Result<Vec<LightDescription>> {
    let lights = list(value, "lights")?;
    if lights.len() > MOST_LIGHTS {
        return Err(Error::input(format!("lights: {} are over the limit of {MOST_LIGHTS}", lights.len())));
    }
    lights
        .iter()
        .enumerate()
        .map(|(i, light)| LightDescription::read(light, &format!("lights[{i}]")))
        .collect()
}

impl LightDescription {
    fn read(table: &Value, place: &str) -> Result<Self> {
        let kind = kind_of(table, place, &TYPES)?;
        let own: &[&str] = match kind {
            "sun" => &["azimuth_deg", "elevation_deg", "radius_deg"],
            "point" => &[],
            "spot" => &["target_mm", "cone_deg", "edge_deg"],
            "sphere" => &["radius_mm"],
            _ => &["target_mm", "size_mm"],
        };
        let known: Vec<&str> =
            COMMON.iter().chain(own).chain(PLACE.iter().filter(|_| kind != "sun")).copied().collect();
        let fields = Fields::new(table, place, &known)?;
        let within = |key: &str, usual: f64, low: f64, high: f64| match fields.get(key) {
            None => Ok(usual),
            Some(_) => fields.number_within(key, low, high),
        };
        let target = || fields.get("target_mm").map_or(Ok([0.0; 3]), |_| point(&fields, "target_mm"));
        let shape = match kind {
            "sun" => {
                let bearing = bearing(&fields)?;
                LightShape::Sun { bearing, radius_deg: within("radius_deg", 1.0, 0.1, 60.0)? }
            }
            "point" => LightShape::Point { position: position(&fields)? },
            "spot" => LightShape::Spot {
                position: position(&fields)?,
                target: target()?,
                cone_deg: fields.number_within("cone_deg", 0.1, 89.0)?,
                edge_deg: within("edge_deg", 0.0, 0.0, 89.0)?,
            },
            "sphere" => LightShape::Sphere {
                position: position(&fields)?,
                radius_mm: fields.number_within("radius_mm", 1e-3, 1e6)?,
            },
            _ => LightShape::Rectangle {
                position: position(&fields)?,
                target: target()?,
                size_mm: pair(&fields, "size_mm")?,
            },
        };
        let light = Self {
            shape,
            colour: LightColour::read(&fields)?,
            strength: fields.number_within("strength", 0.0, 1e4)?,
        };
        light.check(place)?;
        Ok(light)
    }

    /// Refuses what has no direction: a lamp that stands where it points at, or around the origin.
    fn check(&self, place: &str) -> Result<()> {
        let apart = match self.shape {
            LightShape::Sun { .. } => return Ok(()),
            LightShape::Point { position } => length(position),
            LightShape::Spot { position, target, cone_deg, edge_deg } => {
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
            LightShape::Sphere { position, radius_mm } => {
                if length(position) <= radius_mm {
                    return Err(Error::input(format!(
                        "{place}: the middle of the scene lies inside the sphere; give a smaller radius_mm or another place"
                    )));
                }
                length(position)
            }
            LightShape::Rectangle { position, target, .. } => {
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
            LightShape::Sun { radius_deg, .. } => Some(disc_radiance(radius_deg.to_radians(), 1.0)),
            LightShape::Point { position } => Some(PI * DVec3::from(position).length_squared()),
            LightShape::Sphere { position, radius_mm } => {
                Some(DVec3::from(position).length_squared() / (radius_mm * radius_mm))
            }
            LightShape::Spot { .. } | LightShape::Rectangle { .. } => match self.light(&Emission::daylight())
            {
                Light::Spot(spot) => {
                    let share = spot.share(-spot.position.normalize_or_zero());
                    (share > 0.0).then(|| PI * spot.position.length_squared() / share)
                }
                Light::Rectangle(rectangle) => Some(PI / rectangle.irradiance_at_origin()),
                Light::Sun(_) | Light::Point(_) | Light::Sphere(_) => None,
            },
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
            LightShape::Sun { bearing, radius_deg } => Light::Sun(Sun {
                direction: bearing.direction(),
                cos_radius: radius_deg.to_radians().cos(),
                emission,
            }),
            LightShape::Point { position } => Light::Point(Point { position: position.into(), emission }),
            LightShape::Spot { position, target, cone_deg, edge_deg } => Light::Spot(Spot {
                position: position.into(),
                axis: (DVec3::from(target) - DVec3::from(position)).normalize_or(DVec3::NEG_Z),
                cos_outer: cone_deg.to_radians().cos(),
                cos_inner: (cone_deg - edge_deg).to_radians().cos(),
                emission,
            }),
            LightShape::Sphere { position, radius_mm } => {
                Light::Sphere(Sphere { centre: position.into(), radius: radius_mm, emission })
            }
            LightShape::Rectangle { position, target, size_mm } => {
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

impl LightColour {
    fn read(fields: &Fields<'_>) -> Result<Self> {
        let given: Vec<&str> = ["illuminant", "colour", "spectrum"]
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
        if let Some(value) = fields.get("colour") {
            let rgb = colour(value, &fields.path("colour"))?;
            if rgb == [0.0; 3] {
                return Err(Error::input(format!(
                    "{} is black; a lamp that is off has strength = 0",
                    fields.path("colour")
                )));
            }
            return Ok(Self::Rgb(rgb));
        }
        if let Some(file) = fields.text("spectrum")? {
            return Ok(Self::Table { file: file.to_owned(), spectrum: None });
        }
        let name = fields.text("illuminant")?.unwrap_or("D65");
        let found = Illuminant::named(name).map_err(|error| error.at(fields.path("illuminant")))?;
        let name = Illuminant::ALL.iter().find(|(_, known)| *known == found).map_or("D65", |(name, _)| name);
        Ok(Self::Illuminant(name))
    }

    /// As bright to the eye as daylight of radiance 1.
    fn emission(&self) -> Result<Emission> {
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
            Self::Table { file, spectrum: None } => {
                return Err(Error::input(format!("the spectrum '{file}' is not read")));
            }
            Self::Table { file, spectrum: Some(table) } => {
                let power = |nm: f64| table.value(nm).unwrap_or(0.0);
                // What the eye does not see of a measurement may be a spectrometer's noise about 0.
                let held = |nm: f64| if Band::HUMAN.contains(nm) { power(nm) } else { power(nm).max(0.0) };
                Emission::new(held).map_err(|error| error.at(file))?
            }
        };
        let luminance = emission.luminance();
        if !(luminance.is_finite() && luminance > 0.0) {
            return Err(Error::input("a light has no power that the eye sees between 380 and 720 nm"));
        }
        Ok(emission.scaled(Emission::daylight().luminance() / luminance))
    }
}

fn length(v: [f64; 3]) -> f64 {
    DVec3::from(v).length()
}

fn bearing(fields: &Fields<'_>) -> Result<Bearing> {
    Ok(Bearing {
        azimuth_deg: fields.number_within("azimuth_deg", -MOST_TURN_DEG, MOST_TURN_DEG)?,
        elevation_deg: fields.number_within("elevation_deg", -90.0, 90.0)?,
    })
}

/// A lamp's place: `position_mm`, or azimuth, elevation and distance.
fn position(fields: &Fields<'_>) -> Result<[f64; 3]> {
    if fields.get("position_mm").is_some() {
        if let Some(key) = PLACE[1..].iter().find(|key| fields.get(key).is_some()) {
            return Err(Error::input(format!(
                "{} and {} are both given; leave one out",
                fields.path("position_mm"),
                fields.path(key)
            )));
        }
        return point(fields, "position_mm");
    }
    let place = "position_mm, or azimuth_deg, elevation_deg and distance_mm";
    let distance =
        fields.need("distance_mm", place).and_then(|_| fields.number_within("distance_mm", 1e-3, 1e6))?;
    Ok((bearing(fields)?.direction() * distance).into())
}

/// Three coordinates within a kilometre.
pub(super) fn point(fields: &Fields<'_>, key: &str) -> Result<[f64; 3]> {
    match fields.numbers(key)?[..] {
        [x, y, z] if [x, y, z].iter().all(|v| v.abs() <= 1e6) => Ok([x, y, z]),
        _ => Err(Error::input(format!(
            "{}: give three numbers [x, y, z] in mm, each at most 1000000",
            fields.path(key)
        ))),
    }
}

fn pair(fields: &Fields<'_>, key: &str) -> Result<[f64; 2]> {
    match fields.numbers(key)?[..] {
        [width, height] if [width, height].iter().all(|v| (1e-3..=1e6).contains(v)) => Ok([width, height]),
        _ => Err(Error::input(format!(
            "{}: give width and height in mm, each 0.001 to 1000000",
            fields.path(key)
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lights(text: &str) -> Result<Vec<LightDescription>> {
        let table: Value = toml::from_str(text).unwrap();
        read(&table["lights"])
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
