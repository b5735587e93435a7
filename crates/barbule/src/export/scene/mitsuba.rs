//! A scene as Mitsuba 3 reads it, with the plugins of `barbule.mitsuba`.

use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use serde_json::{Value as Json, json};

use super::pixels::portable_floats;
use super::plugin::{Class, Plugin, Value};
use super::shapes::{RibbonKind, curves_text};
use super::{Exported, NamedBytes, Part, Shape, number_of, table_file, write_all};
use crate::brdf::FeatherBrdf;
use crate::bsdf::{BarbuleSurface, Keratin, Surface};
use crate::scene::camera::{Camera, Projection};
use crate::scene::emission::Emission;
use crate::scene::light::{Light, Rectangle, Sphere, Spot};
use crate::scene::sky::{Environment, Sky};
use crate::spectrum::colour::matching;
use crate::spectrum::dense::SHORTEST_NM;
use crate::{Error, Result};

/// Vacuum wavelengths that Mitsuba draws, nm.
const MITSUBA_NM: [f64; 2] = [360.0, 830.0];
/// Mitsuba's integral of ȳ: a flat spectrum of 1 has luminance 1.
const MITSUBA_WHITE: f64 = 106.750_259_399_414;
/// Columns that an environment's picture has at least: Mitsuba mixes neighbouring texels, where skies here are constant in each.
const SKY_COLUMNS: usize = 1024;

impl Exported {
    /// As a dictionary for `mitsuba.load_dict`, whose files are written into `folder`: `{"scene": …, "remarks": […]}`, where
    /// `{"file": NAME}` stands for a file of the folder and `{"matrix": ROWS}` for a transformation.
    ///
    /// # Errors
    /// A surface or lamp that Mitsuba has nothing for, or a file that cannot be written.
    pub fn mitsuba_json(&self, folder: &Path) -> Result<String> {
        let (scene, files) = self.for_mitsuba()?;
        let json: Json = json!({ "scene": scene.json(), "remarks": self.remarks() });
        let text = json.to_string();
        write_all((&folder.join("scene.json"), text.as_bytes()), folder, &files)?;
        Ok(text)
    }

    /// Writes a Mitsuba scene file, and its files into a folder beside it that is named as it is without the ending. All appear, or
    /// none.
    ///
    /// # Errors
    /// As [`Exported::mitsuba_json`].
    pub fn write_mitsuba(&self, path: &Path) -> Result<()> {
        let (scene, files) = self.for_mitsuba()?;
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        let stem = stem.ok_or_else(|| Error::input("has no name; give one as in scene.xml").in_file(path))?;
        write_all((path, scene.xml(&stem).as_bytes()), &path.with_file_name(&stem), &files)
    }

    fn for_mitsuba(&self) -> Result<(Plugin, Vec<NamedBytes>)> {
        let mut files = self.tables()?;
        let mut scene = Plugin::new(Class::Scene, "scene")
            .holding("integrator", self.integrator())
            .holding("sensor", self.sensor());
        let brdfs = self.brdfs();
        for part in &self.parts {
            files.push((shape_file(part), shape_bytes(part)));
            let surface = format!("surface-{}", part.name);
            scene = scene
                .holding(&surface, self.surface(part, &brdfs)?)
                .holding(&part.name, shape(part, &surface));
        }
        for (number, lamp) in self.lamps.iter().enumerate() {
            let file = format!("lamp-{number}.pfm");
            if let Light::Spot(spot) = &lamp.light {
                files.push((file.clone(), spot_picture(spot)));
            }
            scene = scene.holding(format!("lamp-{number}"), self.lamp(&lamp.light, file)?);
        }
        if let Some(environment) = &self.environment {
            files.push(("sky.pfm".to_owned(), sky_picture(&environment.sky)));
            scene = scene.holding("sky", sky(environment));
        }
        Ok((scene, files))
    }

    fn integrator(&self) -> Plugin {
        // Mitsuba counts the light itself.
        let plugin = Plugin::new(Class::Integrator, "path")
            .with("max_depth", Value::Whole(u64::from(self.scatterings) + 1));
        plugin.with("hide_emitters", Value::Flag(!self.shows_sky))
    }

    fn sensor(&self) -> Plugin {
        let [width, height] = self.options.size.map(u64::from);
        let film = Plugin::new(Class::Film, "hdrfilm")
            .with("width", Value::Whole(width))
            .with("height", Value::Whole(height))
            .with("pixel_format", Value::Text("rgba".to_owned()))
            .with("component_format", Value::Text("float32".to_owned()))
            .holding("rfilter", Plugin::new(Class::Filter, "tent"));
        let sampler = Plugin::new(Class::Sampler, "independent")
            .with("sample_count", Value::Whole(u64::from(self.options.samples)));
        camera(&self.camera).holding("film", film).holding("sampler", sampler)
    }

    fn surface(&self, part: &Part, brdfs: &[Arc<FeatherBrdf>]) -> Result<Plugin> {
        match (&part.surface, &part.shape) {
            (Surface::Keratin(surface), _) => {
                Ok(keratin(surface, Plugin::new(Class::Bsdf, "barbule_keratin"), "reflectance"))
            }
            (Surface::Barbule(surface), Shape::Ribbons(kind, _)) if surface.opacity >= 1.0 => {
                Ok(self.barbule(surface, *kind, brdfs))
            }
            (Surface::Lambertian(surface), _) => {
                let reflectance = surface
                    .even()
                    .ok_or_else(|| refused(&part.of, "pictures or translucency on diffuse surfaces"))?;
                let diffuse = Plugin::new(Class::Bsdf, "diffuse")
                    .holding("reflectance", spectrum(reflectance.values(), 1.0));
                Ok(Plugin::new(Class::Bsdf, "twosided").holding("bsdf", diffuse))
            }
            (Surface::Barbule(_), _) => {
                Err(refused(&part.of, "translucent barbules, or barbules that are no ribbons"))
            }
            (Surface::Clad(_), _) => Err(refused(&part.of, "meshes and curves that wear barbules")),
            (Surface::Barb(_), _) => Err(refused(&part.of, "barbs whose barbules are looked up")),
            (Surface::Hair(_), _) => Err(refused(&part.of, "fibres of hair")),
            (Surface::Grating(_), _) => Err(refused(&part.of, "gratings")),
            (Surface::Measured(_), _) => Err(refused(&part.of, "measured materials")),
            (Surface::Map(_), _) => Err(refused(&part.of, "maps of surfaces")),
            (
                Surface::Conductor(_)
                | Surface::Dielectric(_)
                | Surface::RoughDielectric(_)
                | Surface::ThinFilm(_),
                _,
            ) => Err(refused(&part.of, "metals, glass and rough films")),
        }
    }

    fn barbule(&self, surface: &BarbuleSurface, kind: RibbonKind, brdfs: &[Arc<FeatherBrdf>]) -> Plugin {
        let table = |brdf: &FeatherBrdf| Value::File(table_file(number_of(brdfs, brdf).unwrap_or_default()));
        let word = |brdf: &FeatherBrdf| Value::Text(brdf.reciprocity().word().to_owned());
        let mut plugin = Plugin::new(Class::Bsdf, "barbule_ribbon")
            .with("tables", table(&surface.brdf))
            .with("reciprocity", word(&surface.brdf))
            .with("instances", Value::Flag(surface.instances));
        if let Some(below) = &surface.below {
            plugin = plugin.with("below", table(below)).with("below_reciprocity", word(below));
        }
        let cells = &surface.cells;
        plugin = plugin
            .number("cell_mm", kind.cell_mm.into())
            .number("swelling", kind.swelling.into())
            .number("wall_mm", cells.wall_mm)
            .number("cell_size", cells.size)
            .number("barbule_size", cells.barbule_size)
            .with("placed", Value::Flag(kind.is_placed));
        if let Some(arch) = cells.arch {
            plugin = plugin
                .number("arch_low", arch.low)
                .number("arch_high", arch.high)
                .number("arch_blur", arch.blur);
        }
        let pixel = 0.5 * self.camera.width_mm / f64::from(self.options.size[0]);
        plugin = match self.camera.projection {
            Projection::Orthographic => plugin.number("footprint_mm", pixel),
            Projection::Perspective { .. } => {
                let distance = (self.camera.target - self.camera.eye).length();
                plugin
                    .with("eye", Value::Point(self.camera.eye.to_array()))
                    .number("spread", pixel / distance)
            }
        };
        keratin(&surface.under, plugin, "under")
    }

    fn lamp(&self, light: &Light, picture: String) -> Result<Plugin> {
        let area = |emission: &Emission| {
            Plugin::new(Class::Emitter, "area")
                .holding("radiance", spectrum(emission.spectrum().values(), white()))
        };
        let shape = |kind: &'static str| Plugin::new(Class::Shape, kind);
        Ok(match light {
            Light::Sun(sun) => {
                let (direction, [distance, radius]) = (sun.direction, self.disc_mm(sun));
                let frame = facing(-direction);
                let to_world = matrix(
                    [frame.x_axis * radius, frame.y_axis * radius, frame.z_axis],
                    direction * distance,
                );
                shape("disk").with("to_world", to_world).holding("emitter", area(&self.sun_and_sky(sun)?))
            }
            Light::Rectangle(Rectangle { corner, edge_u, edge_v, emission }) => {
                let (u, v) = (0.5 * *edge_u, 0.5 * *edge_v);
                let to_world = matrix([u, v, u.cross(v).normalize_or(DVec3::Z)], *corner + u + v);
                shape("rectangle").with("to_world", to_world).holding("emitter", area(emission))
            }
            Light::Sphere(Sphere { centre, radius, emission }) => shape("sphere")
                .with("center", Value::Point(centre.to_array()))
                .number("radius", *radius)
                .holding("emitter", area(emission)),
            Light::Point(lamp) => Plugin::new(Class::Emitter, "point")
                .with("position", Value::Point(lamp.position.to_array()))
                .holding("intensity", spectrum(lamp.emission.spectrum().values(), white())),
            Light::Spot(spot) => {
                let frame = facing(spot.axis);
                let picture = Plugin::new(Class::Texture, "bitmap")
                    .with("filename", Value::File(picture))
                    .with("raw", Value::Flag(true))
                    .with("wrap_mode", Value::Text("clamp".to_owned()));
                // The picture alone says how it fades.
                let cutoff = spot.cos_outer.acos().to_degrees();
                Plugin::new(Class::Emitter, "spot")
                    .with("to_world", matrix([frame.x_axis, frame.y_axis, frame.z_axis], spot.position))
                    .number("cutoff_angle", cutoff)
                    .number("beam_width", cutoff * (1.0 - 1e-6))
                    .holding("intensity", spectrum(spot.emission.spectrum().values(), white()))
                    .holding("texture", picture)
            }
        })
    }
}

fn refused(part: &str, what: &str) -> Error {
    Error::input(format!(
        "'{part}' cannot be shown in Mitsuba, which has nothing for {what}; leave this part out"
    ))
}

/// Factor from radiance here, where white in daylight has 1, to Mitsuba's, so that pictures have the same linear values.
fn white() -> f64 {
    let daylight = Emission::daylight();
    let [low, high] = MITSUBA_NM;
    let luminance: f64 =
        (low as u32..=high as u32).map(|nm| daylight.at(f64::from(nm)) * matching(f64::from(nm))[1]).sum();
    MITSUBA_WHITE / luminance
}

/// A spectrum from values for each nm from 300 to 830 nm.
fn spectrum(values: &[f64], factor: f64) -> Plugin {
    let [low, high] = MITSUBA_NM;
    let range = (low - SHORTEST_NM) as usize..=(high - SHORTEST_NM) as usize;
    let numbers: Vec<String> =
        values[range].iter().map(|value| format!("{:e}", (value * factor) as f32)).collect();
    Plugin::new(Class::Spectrum, "regular")
        .number("wavelength_min", low)
        .number("wavelength_max", high)
        .with("values", Value::Text(numbers.join(", ")))
}

fn keratin(surface: &Keratin, plugin: Plugin, name: &'static str) -> Plugin {
    plugin
        .number("roughness", surface.roughness())
        .number("index", surface.index())
        .holding(name, spectrum(surface.body().values(), 1.0))
}

fn shape_file(part: &Part) -> String {
    let ending = if matches!(part.shape, Shape::Curves(_)) { "txt" } else { "ply" };
    format!("{}.{ending}", part.name)
}

fn shape_bytes(part: &Part) -> Vec<u8> {
    match &part.shape {
        Shape::Ribbons(_, ply) | Shape::Mesh(_, ply) => ply.clone(),
        Shape::Curves(curves) => curves_text(curves),
    }
}

fn shape(part: &Part, surface: &str) -> Plugin {
    let plugin = match part.shape {
        Shape::Curves(_) => Plugin::new(Class::Shape, "linearcurve"),
        Shape::Ribbons(..) => Plugin::new(Class::Shape, "ply"),
        Shape::Mesh(kind, _) => {
            Plugin::new(Class::Shape, "ply").with("face_normals", Value::Flag(!kind.is_smooth))
        }
    };
    plugin.with("filename", Value::File(shape_file(part))).holding("bsdf", Plugin::reference(surface))
}

/// A transformation by where it takes the axes and the origin.
fn matrix([x, y, z]: [DVec3; 3], origin: DVec3) -> Value {
    let row = |k: usize| [x[k], y[k], z[k], origin[k]];
    Value::Matrix([row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]])
}

/// A turn that takes z to a unit vector.
fn facing(z: DVec3) -> DMat3 {
    let x = z.any_orthonormal_vector();
    DMat3::from_cols(x, z.cross(x), z)
}

/// Cameras look along z, with x to the left of the picture.
fn camera(camera: &Camera) -> Plugin {
    let ahead = camera.target - camera.eye;
    let (distance, forward) = (ahead.length(), ahead.normalize_or(DVec3::NEG_Z));
    let left = camera.up.cross(forward).normalize_or(DVec3::X);
    let up = forward.cross(left);
    let half = 0.5 * camera.width_mm;
    let plugin = match camera.projection {
        Projection::Orthographic => Plugin::new(Class::Sensor, "orthographic")
            .with("to_world", matrix([left * half, up * half, forward], camera.eye)),
        Projection::Perspective { lens_radius } => {
            let kind = if lens_radius > 0.0 { "thinlens" } else { "perspective" };
            let plugin = Plugin::new(Class::Sensor, kind)
                .with("to_world", matrix([left, up, forward], camera.eye))
                .with("fov_axis", Value::Text("x".to_owned()))
                .number("fov", 2.0 * libm::atan2(half, distance).to_degrees());
            if lens_radius > 0.0 {
                plugin.number("aperture_radius", lens_radius).number("focus_distance", distance)
            } else {
                plugin
            }
        }
    };
    plugin.number("near_clip", 1e-3 * distance).number("far_clip", 1e5 * distance)
}

fn sky(environment: &Environment) -> Plugin {
    let sky = &environment.sky;
    // Mitsuba's map has its zenith at y and begins at −z, where this one has z and y, and turns clockwise seen from above.
    let own = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y);
    let turned = sky.rotation() * DMat3::from_rotation_z(-TAU * sky.turn()) * own;
    Plugin::new(Class::Emitter, "envmap")
        .with("filename", Value::File("sky.pfm".to_owned()))
        .with("to_world", matrix([turned.x_axis, turned.y_axis, turned.z_axis], DVec3::ZERO))
}

/// The sky's texels, each as often as makes what lies between them narrow.
fn sky_picture(sky: &Sky) -> Vec<u8> {
    let [width, height] = sky.size();
    let times = SKY_COLUMNS.div_ceil(width);
    let is_grey = sky.basis().len() == 1;
    portable_floats([times * width, times * height], |x, y| {
        let texel = sky.texels()[y / times * width + x / times];
        if is_grey { [texel[0]; 3] } else { texel }
    })
}

/// How a spot fades, as a picture over the square that its cone lies in.
fn spot_picture(spot: &Spot) -> Vec<u8> {
    const SIDE: usize = 512;
    let widest = spot.cos_outer.acos().min(0.499 * PI).tan();
    portable_floats([SIDE; 2], |x, y| {
        let at = |k: usize| widest * (2.0 * (k as f64 + 0.5) / SIDE as f64 - 1.0);
        let direction = facing(spot.axis) * DVec3::new(at(x), at(y), 1.0).normalize();
        [spot.share(direction) as f32]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sky's gradient is Mitsuba's grey times its own daylight, whose value at 560 nm this factor is.
    #[test]
    fn daylight_of_radiance_1_is_mitsubas_white() {
        assert!((white() - 1.010_13).abs() < 2e-4, "{}", white());
    }
}
