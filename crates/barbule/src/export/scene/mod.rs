//! Whole scenes for other renderers: shapes as files, and what they are made of, lit by and seen with.
//!
//! [`Exported`] is what all of them share; `mitsuba` and `pbrt` write it as theirs.

mod mitsuba;
mod pbrt;
mod pixels;
mod plugin;
mod shapes;

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;

use crate::brdf::FeatherBrdf;
use crate::bsdf::Surface;
use crate::error::{did_you_mean, shortened};
use crate::io::{MOST_WRITTEN_BARBULES, encode_tables, make_folder, write_together};
use crate::progress::Progress;
use crate::scene::camera::Camera;
use crate::scene::description::{
    Background, Detail, DetailLevel, ObjectShape, ReadyScene, SceneDescription, SkyDescription, ViewModel,
};
use crate::scene::emission::Emission;
use crate::scene::feather::Level;
use crate::scene::geometry::Geometry;
use crate::scene::light::{Lamp, Sun};
use crate::scene::sky::Environment;
use crate::{Error, Result};

pub use pbrt::MeasuredFiles;
use shapes::{MeshKind, RibbonKind, stands};

/// Discs at infinity stand so many times as far as the scene reaches, so that they have no parallax that is seen.
const FAR: f64 = 2000.0;

/// How a scene is seen by another renderer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExportOptions {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples per pixel.
    pub samples: u32,
    /// Seed of feather and instances.
    pub seed: u64,
    /// Names of parts that are left out, as mattes call them: `down`, `shaft`.
    pub without: Vec<String>,
}

impl Default for ExportOptions {
    fn default() -> Self {
        Self { size: [1280, 800], samples: 64, seed: 1, without: Vec::new() }
    }
}

/// A scene of which everything that other renderers read is made.
#[derive(Debug, Clone)]
pub struct Exported {
    options: ExportOptions,
    parts: Vec<Part>,
    lamps: Vec<Lamp>,
    environment: Option<Environment>,
    camera: Camera,
    scatterings: u32,
    shows_sky: bool,
    /// The farthest point from the origin, mm.
    reach_mm: f64,
    remarks: Vec<String>,
}

/// Shapes of one kind and surface.
#[derive(Debug, Clone)]
struct Part {
    /// As the scene calls it, then its number.
    name: String,
    /// As the scene calls it.
    of: String,
    surface: Surface,
    shape: Shape,
}

#[derive(Debug, Clone)]
enum Shape {
    /// A PLY file.
    Ribbons(RibbonKind, Vec<u8>),
    /// A PLY file.
    Mesh(MeshKind, Vec<u8>),
    /// x, y, z and the radius of points.
    Curves(Vec<Vec<[f32; 4]>>),
}

/// A file by its name, and what it holds.
type NamedBytes = (String, Vec<u8>);

impl Exported {
    /// Grows what stands in a scene, every barbule by itself.
    ///
    /// # Errors
    /// A coat, more than 350,000 barbules, a number out of range, or a stop by `progress`.
    pub fn new(ready: &ReadyScene, options: ExportOptions, progress: &dyn Progress) -> Result<Self> {
        let mut remarks = Vec::new();
        let one_by_one = ReadyScene::new(grown_one_by_one(ready, &mut remarks)?)?;
        let names = one_by_one.object_names();
        if let Some(unknown) = options.without.iter().find(|name| !names.contains(name)) {
            let near = did_you_mean(unknown, names.iter().map(String::as_str));
            let (unknown, known) = (shortened(unknown), names.join(", "));
            return Err(Error::input(format!(
                "there is no part '{unknown}' to leave out{near} (there are {known})"
            )));
        }
        let (objects, _) = one_by_one.objects_watched(options.seed, progress)?;
        let ribbons: usize = objects.iter().map(|object| object.geometry.ribbon_count()).sum();
        if ribbons > MOST_WRITTEN_BARBULES {
            return Err(too_many(ribbons as f64));
        }
        let reach = |low: Vec3, high: Vec3| f64::from(low.abs().max(high.abs()).length());
        let bounds = objects.iter().filter_map(|object| object.geometry.bounds());
        let reach_mm = bounds.map(|[low, high]| reach(low, high)).fold(1e-3, f64::max);
        let mut parts = Vec::new();
        let wanted = objects.iter().zip(&names).filter(|(_, name)| !options.without.contains(name));
        for (object, name) in wanted {
            add_parts(&mut parts, &object.geometry, &object.surface, name);
        }
        remarks.extend(backdrop_remark(&one_by_one));
        Ok(Self {
            options,
            parts,
            lamps: one_by_one.lamps()?,
            environment: one_by_one.environment()?.map(|sky| one_by_one.around_objects(sky)),
            camera: one_by_one.camera(),
            scatterings: one_by_one.scatterings,
            shows_sky: one_by_one.background == Background::Sky,
            reach_mm,
            remarks,
        })
    }

    /// What other renderers show differently, a sentence each.
    #[must_use]
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// Distance and radius of the disc that stands for a sun, mm.
    fn disc_mm(&self, sun: &Sun) -> [f64; 2] {
        let distance = FAR * self.reach_mm;
        [distance, distance * (1.0 - sun.cos_radius * sun.cos_radius).max(0.0).sqrt() / sun.cos_radius]
    }

    /// What shines where a sun is: other renderers have discs, which hide the sky behind them.
    fn sun_and_sky(&self, sun: &Sun) -> Result<Emission> {
        let Some(Environment { sky, .. }) = &self.environment else { return Ok(sun.emission.clone()) };
        let (row, column) = sky.texel(sun.direction);
        let texel = sky.texels()[row * sky.size()[0] + column];
        let behind = |nm: f64| -> f64 {
            texel.iter().zip(sky.basis()).map(|(weight, basis)| f64::from(*weight) * basis.at(nm)).sum()
        };
        Emission::new(|nm| sun.emission.at(nm) + behind(nm))
    }

    /// The BRDFs that barbules wear, of the same tables one.
    fn brdfs(&self) -> Vec<Arc<FeatherBrdf>> {
        let mut all: Vec<Arc<FeatherBrdf>> = Vec::new();
        for part in &self.parts {
            if let Surface::Barbule(barbule) = &part.surface {
                for brdf in [Some(&barbule.brdf), barbule.below.as_ref()].into_iter().flatten() {
                    if number_of(&all, brdf).is_none() {
                        all.push(Arc::clone(brdf));
                    }
                }
            }
        }
        all
    }

    /// The tables of BRDFs, each as a file.
    fn tables(&self) -> Result<Vec<NamedBytes>> {
        let encoded = |(number, brdf): (usize, Arc<FeatherBrdf>)| {
            Ok((table_file(number), encode_tables(brdf.tables())?))
        };
        self.brdfs().into_iter().enumerate().map(encoded).collect()
    }
}

/// Which of several BRDFs has the same tables.
fn number_of(all: &[Arc<FeatherBrdf>], brdf: &FeatherBrdf) -> Option<usize> {
    all.iter().position(|other| std::ptr::eq(other.tables(), brdf.tables()))
}

fn table_file(number: usize) -> String {
    format!("barbule-{number}.tables")
}

/// Writes files beside each other, all or none; those with a folder in their name into it.
fn write_all(main: (&Path, &[u8]), folder: &Path, files: &[NamedBytes]) -> Result<()> {
    make_folder(folder)?;
    let paths: Vec<_> = files.iter().map(|(name, _)| folder.join(name)).collect();
    let mut all: Vec<(&Path, &[u8])> =
        paths.iter().zip(files).map(|(path, (_, bytes))| (path.as_path(), &bytes[..])).collect();
    all.push(main);
    write_together(&all)
}

/// The scene with every feather at its finest.
fn grown_one_by_one(ready: &ReadyScene, remarks: &mut Vec<String>) -> Result<SceneDescription> {
    let mut scene = SceneDescription::clone(ready);
    let width_mm = scene.camera.width_mm;
    for object in &mut scene.objects {
        match &mut object.shape {
            ObjectShape::Coat(_) | ObjectShape::Row(_) => {
                return Err(Error::input(
                    "coats and rows are not written for other renderers: their barbules are too many; write a feather of it",
                ));
            }
            ObjectShape::Feather(of) => {
                let barbules = of.feather.barbules_in(of.window);
                // Windows hold about so many.
                if barbules > 1.2 * MOST_WRITTEN_BARBULES as f64 {
                    return Err(too_many(barbules));
                }
                if of.detail.level_of(&of.feather, of.window, width_mm) != Level::Barbules {
                    remarks.push(
                        "every barbule stands there by itself, where the scene shows surfaces".to_owned(),
                    );
                }
                of.detail = Detail { level: DetailLevel::Barbules, view_model: ViewModel::Grown };
            }
            _ => {}
        }
    }
    Ok(scene)
}

fn too_many(barbules: f64) -> Error {
    Error::input(format!(
        "the scene has about {barbules:.0} barbules, over the limit of {MOST_WRITTEN_BARBULES} for other renderers; give [window] a smaller radius_mm"
    ))
}

fn backdrop_remark(scene: &SceneDescription) -> Option<String> {
    let colours = matches!(&scene.sky, SkyDescription::Image(image) if image.strength > 0.0);
    let sky = colours.then_some(
        "colours of the sky's image have the other renderer's spectra, which look the same in daylight",
    );
    let behind = match scene.background {
        Background::Sky | Background::None => None,
        Background::Colour(_) | Background::Gradient(_) | Background::Picture(_) => {
            Some("the picture is cut out (alpha); what the scene has behind it is not written")
        }
    };
    let both: Vec<_> = sky.into_iter().chain(behind).collect();
    (!both.is_empty()).then(|| both.join("; "))
}

fn add_parts(parts: &mut Vec<Part>, geometry: &Geometry, surface: &Surface, name: &str) {
    let stands = stands(geometry);
    let slug: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    let mut add = |shape: Shape| {
        parts.push(Part {
            name: format!("{slug}-{}", parts.len()),
            of: name.to_owned(),
            surface: surface.clone(),
            shape,
        });
    };
    for kind in RibbonKind::all(&stands) {
        add(Shape::Ribbons(kind, shapes::ribbons(&stands, kind)));
    }
    for kind in MeshKind::all(&stands) {
        add(Shape::Mesh(kind, shapes::meshes(&stands, kind)));
    }
    let curves = shapes::curves(&stands);
    if !curves.is_empty() {
        add(Shape::Curves(curves));
    }
}
