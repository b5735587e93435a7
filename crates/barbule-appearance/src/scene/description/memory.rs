//! The memory that a scene takes: foretold from what its files say of their sizes, before they are read, and exactly once they are.

use std::collections::{BTreeMap, BTreeSet};

use super::files::Named;
use super::form::FormDescription;
use super::objects::{ObjectDescription, ObjectShape};
use super::shapes::{SPHERE, nodes};
use super::slot::Slot;
use super::surfaces::NamedSurface;
use super::{LowerSide, SceneDescription};
use crate::bsdf::{Grating, MeasuredTables, Texture};
use crate::scattering::grating::Powers;
use crate::scene::geometry::Mesh;
use crate::scene::memory::PER_PLACE;
use crate::scene::spline::ControlCurve;

/// Bytes at most of a triangle, a vertex, a segment and a control point while hierarchies are built: what was read, its copy in the scene,
/// and the hierarchy with what it is built of. Measured: 1e6 vertices and 2e6 triangles took 0.80 GB, 8e5 points of 7.6e5 slanting
/// segments 0.66 GB.
const PER_TRIANGLE: f64 = 380.0;
const PER_VERTEX: f64 = 90.0;
const PER_SEGMENT: f64 = 850.0;
const PER_POINT: f64 = 32.0;

/// Of a pixel of a picture on a surface or behind a scene; of one of a sky with what chooses directions of it, which turned objects
/// have a second time.
const PER_TEXEL: f64 = 12.0;
const PER_SKY_PIXEL: f64 = 40.0;
const PER_TURNED_PIXEL: f64 = 20.0;

/// What a grating is rendered from, over its powers, whatever its coherence.
const PER_POWER: f64 = 4.0;

/// Of a material with its tables.
const PER_MATERIAL: f64 = 10e6;

/// What a file of a scene holds, as its header says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Holds {
    /// A picture of so many pixels.
    Pixels(f64),
    /// A mesh of so many vertices and triangles.
    Mesh([f64; 2]),
    /// Curves of so many control points.
    Points(f64),
    /// Powers of gratings of so many bytes.
    Powers(f64),
    /// Tables of a measured material in a file of so many bytes.
    Measured(f64),
}

/// What the files and samples of a scene hold that are not read yet, by their names.
pub type Foreseen = BTreeMap<String, Holds>;

impl SceneDescription {
    /// Memory that its feathers, its other objects and their pictures take while the scene is built, bytes, at most; of files that are not
    /// read as `foreseen` has them.
    #[must_use]
    pub fn bytes(&self, foreseen: &Foreseen) -> u64 {
        let width_mm = self.camera.width_mm;
        let objects: f64 = self.objects.iter().map(|object| object.bytes(width_mm, foreseen)).sum();
        // Tables of gratings are made for each object.
        let worn = self.objects.iter().filter_map(|object| self.surfaces.0.get(object.surface.as_deref()?));
        let tables: f64 = worn.map(|surface| surface.grating_bytes(foreseen)).sum();
        (objects + tables + self.shared_bytes(foreseen)) as u64
    }

    /// What is held once however many objects have it: of each file once.
    fn shared_bytes(&self, foreseen: &Foreseen) -> f64 {
        let mut scene = self.clone();
        let (mut seen, mut bytes) = (BTreeSet::new(), 0.0);
        let per_sky_pixel = PER_SKY_PIXEL + if self.turn_deg == 0.0 { 0.0 } else { PER_TURNED_PIXEL };
        for (_, named) in scene.needed_mut() {
            let (kind, name, own) = match named {
                Named::Colours(slot) => (0, slot.name.clone(), texels(slot, foreseen)),
                Named::Numbers(slot) => (1, slot.name.clone(), texels(slot, foreseen)),
                Named::Sky(slot, _) => {
                    let read = slot.get().map(|sky| sky.size().iter().product::<usize>() as f64);
                    (
                        2,
                        slot.name.clone(),
                        per_sky_pixel * read.unwrap_or_else(|| pixels(&slot.name, foreseen)),
                    )
                }
                Named::Backdrop(slot) => {
                    let read = slot.get().map(|picture| picture.pixels() as f64);
                    (3, slot.name.clone(), PER_TEXEL * read.unwrap_or_else(|| pixels(&slot.name, foreseen)))
                }
                Named::Grating(slot) | Named::Sample(slot) => (4, slot.name.clone(), powers(slot, foreseen)),
                Named::Material(slot) => (5, slot.name.clone(), PER_MATERIAL),
                Named::Lower(upper, slot) => {
                    let is_keratin = slot.get().is_some_and(|LowerSide(brdf)| brdf.is_none());
                    (6, upper, if is_keratin { 0.0 } else { PER_MATERIAL })
                }
                Named::Measured(slot) => (7, slot.name.clone(), measured(slot, foreseen)),
                Named::Mesh(_) | Named::Curves(..) | Named::Spectrum(_) => continue,
            };
            if seen.insert((kind, name)) {
                bytes += own;
            }
        }
        bytes
    }
}

impl ObjectDescription {
    /// Memory that it takes while its hierarchy is built; `width_mm`: of the picture.
    fn bytes(&self, width_mm: f64, foreseen: &Foreseen) -> f64 {
        let width_mm = self.width_on_it(width_mm);
        let mesh = |[vertices, triangles]: [f64; 2]| vertices * PER_VERTEX + triangles * PER_TRIANGLE;
        let shape = match &self.shape {
            ObjectShape::Sphere { .. } => {
                let quadrangles = f64::from(SPHERE[0] * SPHERE[1]);
                mesh([quadrangles, 2.0 * quadrangles])
            }
            ObjectShape::Rectangle { .. } => mesh([4.0, 2.0]),
            ObjectShape::Snake(snake) => mesh(snake.snake().size().map(|count| count as f64)),
            ObjectShape::Form(form) => {
                let (size, grid) = form.size();
                mesh(size) + grid
            }
            ObjectShape::Mesh(file) => mesh(corners(file, foreseen)),
            ObjectShape::Curves { file, basis } => match file.get() {
                Some(curves) => {
                    let one = |curve: &ControlCurve| {
                        curve.len() as f64 * PER_POINT + basis.segments(&nodes(curve)) as f64 * PER_SEGMENT
                    };
                    curves.iter().map(one).sum()
                }
                None => match foreseen.get(&file.name) {
                    // At least a segment from point to point.
                    Some(Holds::Points(points)) => points * (PER_POINT + PER_SEGMENT),
                    _ => 0.0,
                },
            },
            ObjectShape::Feather(of) => {
                let repeated = of.places(width_mm) * (self.placements().len() - 1) as f64;
                of.bytes(width_mm) + repeated * PER_PLACE
            }
            ObjectShape::Coat(of) => {
                let form = of.coat.form.as_ref().map_or(([0.0; 2], 0.0), FormDescription::size);
                let triangles = of.coat.mesh.as_ref().map_or(form.0[1], |file| corners(file, foreseen)[1]);
                of.bytes(triangles, width_mm) + form.1
            }
            ObjectShape::Row(of) => of.bytes(self.placements().len(), width_mm),
        };
        shape + self.placements().len() as f64 * PER_PLACE
    }
}

impl NamedSurface {
    /// Bytes of the tables and probabilities that it is rendered from beside its powers, where it is a grating.
    fn grating_bytes(&self, foreseen: &Foreseen) -> f64 {
        let Self::Grating(of) = self else { return 0.0 };
        let Some(slot) = of.powers() else { return 0.0 };
        match slot.get() {
            Some(powers) => Grating::bytes(powers, of.coherence_um) as f64,
            None => PER_POWER * powers(slot, foreseen),
        }
    }
}

fn powers(slot: &Slot<Powers>, foreseen: &Foreseen) -> f64 {
    match (slot.get(), foreseen.get(&slot.name)) {
        (Some(powers), _) => size_of_val(powers.series()) as f64,
        (None, Some(Holds::Powers(bytes))) => *bytes,
        _ => 0.0,
    }
}

/// What is kept of the densities takes three times as much as the file has, values as much.
fn measured(slot: &Slot<MeasuredTables>, foreseen: &Foreseen) -> f64 {
    match (slot.get(), foreseen.get(&slot.name)) {
        (Some(tables), _) => tables.bytes() as f64,
        (None, Some(Holds::Measured(bytes))) => 2.0 * bytes,
        _ => 0.0,
    }
}

fn pixels(name: &str, foreseen: &Foreseen) -> f64 {
    match foreseen.get(name) {
        Some(Holds::Pixels(count)) => *count,
        _ => 0.0,
    }
}

fn texels(slot: &Slot<Texture>, foreseen: &Foreseen) -> f64 {
    slot.get().map_or_else(|| PER_TEXEL * pixels(&slot.name, foreseen), |texture| texture.bytes() as f64)
}

/// Vertices and triangles of a mesh.
fn corners(slot: &Slot<Mesh>, foreseen: &Foreseen) -> [f64; 2] {
    match (slot.get(), foreseen.get(&slot.name)) {
        (Some(mesh), _) => [mesh.positions.len() as f64, mesh.triangles.len() as f64],
        (None, Some(Holds::Mesh(counts))) => *counts,
        _ => [0.0; 2],
    }
}
