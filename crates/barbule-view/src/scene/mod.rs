//! Meshes of what is shown, as plain vertices and triangles: a ball, a bent piece of a vane, a feather's own barbules, a snake.
//!
//! Positions are mm, as scenes have them. Every vertex says which shape it is of and where on it, so that a shader gives each cell
//! of each barbule the name from which the renderer draws its individual.

mod clad;
mod envelope;
mod feather;
mod names;
mod ribbon;
mod snake;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

pub use clad::{BARBULE_LAYOUT, Bend, SPHERE_MM, sphere, vane, vane_obj};
pub use feather::{FeatherDetail, FeatherRequest, feather};
pub use names::{clad_instance, name_at, ribbon_instance};
pub use snake::snake;

use barbule_appearance::bsdf::Layout;
use barbule_base::{Error, Result};
use names::words_of;

/// Most triangles of a shape, so that old graphics adapters draw it many times a second.
pub const MOST_TRIANGLES: usize = 300_000;

/// A corner of triangles. 64 bytes without gaps, in the order of the fields.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Vertex {
    /// In the scene, mm.
    pub position_mm: [f32; 3],
    /// Unit normal, out of the upper side of barbules.
    pub normal: [f32; 3],
    /// Unit vector along the barbule, barb or fibre, at a right angle to the normal.
    pub tangent: [f32; 3],
    /// Where on its shape it is, as [`Naming`] says.
    pub place: [f32; 2],
    /// Cells of barbules are low arches: slope at their ends, rad.
    pub swelling: f32,
    /// Half the barbule's width here, mm; 0 where there is none.
    pub half_width_mm: f32,
    /// What it is made of: [`Part::code`].
    pub part: u32,
    /// The low and the high word of the shape's name.
    pub name: [u32; 2],
}

/// What a part of a shape is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Barbules towards the feather's tip.
    Distal,
    /// Barbules on the other side of barbs.
    Proximal,
    /// Barbules without pigment.
    Pale,
    /// Barbules and barbs of the downy part.
    Down,
    /// The rami of barbs.
    Ramus,
    /// The shaft.
    Shaft,
    /// A surface that is all one grating.
    Grating,
}

impl Part {
    /// All of them, in the order of their codes.
    pub const ALL: [Self; 7] =
        [Self::Distal, Self::Proximal, Self::Pale, Self::Down, Self::Ramus, Self::Shaft, Self::Grating];

    /// Codes of zones are this far apart.
    const ZONES: u32 = 16;

    /// Its number in vertices; parts in a feather's zone have the zone's number, from 1, times 16 more.
    #[must_use]
    pub fn code(self, zone: usize) -> u32 {
        self as u32 + Self::ZONES * zone as u32
    }
}

/// What vertices' places are, and so how the names of individuals follow from them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Naming {
    /// Along the barbule in cells, the first of which may begin before it, and −1 to 1 across. [`ribbon_instance`] names the cell.
    Ribbon,
    /// Texture coordinates: barbules lie side by side on the surface like this. [`clad_instance`] names the cell.
    Clad(Layout),
    /// Texture coordinates; there are no individuals.
    Plain,
}

/// A mesh to be drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Its corners.
    pub vertices: Vec<Vertex>,
    /// Three of them each, counter-clockwise seen from the upper side.
    pub triangles: Vec<[u32; 3]>,
    /// How its individuals are named.
    pub naming: Naming,
}

impl Shape {
    /// Nothing yet.
    #[must_use]
    pub fn new(naming: Naming) -> Self {
        Self { vertices: Vec::new(), triangles: Vec::new(), naming }
    }

    /// Smallest and largest coordinates, mm; nothing where there is nothing.
    #[must_use]
    pub fn bounds_mm(&self) -> Option<[Vec3; 2]> {
        let points = self.vertices.iter().map(|vertex| Vec3::from(vertex.position_mm));
        points.map(|point| [point, point]).reduce(|[low, high], [a, b]| [low.min(a), high.max(b)])
    }

    /// The vertices as bytes for a buffer.
    #[must_use]
    pub fn vertex_bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.vertices)
    }

    /// Refuses what no adapter should be given: corners that do not exist, numbers that are not finite, vectors of another length
    /// than 1, and more triangles than [`MOST_TRIANGLES`].
    ///
    /// # Errors
    /// The first such fault.
    pub fn check(&self) -> Result<()> {
        let refuse = |what: String| Err(Error::machine(format!("the mesh is not drawn: {what}")));
        if self.triangles.len() > MOST_TRIANGLES {
            return refuse(format!("{} triangles are over {MOST_TRIANGLES}", self.triangles.len()));
        }
        if let Some(corner) = self.triangles.iter().flatten().find(|c| **c as usize >= self.vertices.len()) {
            return refuse(format!("corner {corner} does not exist"));
        }
        let is_unit = |vector: [f32; 3]| (Vec3::from(vector).length() - 1.0).abs() < 1e-4;
        let is_sound = |v: &Vertex| {
            Vec3::from(v.position_mm).is_finite()
                && is_unit(v.normal)
                && is_unit(v.tangent)
                && v.place.iter().chain([&v.swelling, &v.half_width_mm]).all(|value| value.is_finite())
        };
        match self.vertices.iter().position(|vertex| !is_sound(vertex)) {
            None => Ok(()),
            Some(at) => refuse(format!(
                "vertex {at} has a vector that is no unit vector, or a number that is not finite"
            )),
        }
    }

    /// Adds a corner, and gives its number.
    fn push(&mut self, vertex: Vertex) -> u32 {
        self.vertices.push(vertex);
        self.vertices.len() as u32 - 1
    }
}

impl Vertex {
    /// A corner of a shape of this name; normal and tangent of any length become unit vectors at a right angle.
    fn at(position_mm: Vec3, normal: Vec3, along: Vec3, name: u64) -> Self {
        let normal = normal.normalize_or(Vec3::Z);
        let tangent = along - normal * normal.dot(along);
        let tangent = tangent.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
        Self {
            position_mm: position_mm.into(),
            normal: normal.into(),
            tangent: tangent.into(),
            name: words_of(name),
            ..Self::zeroed()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_told_by_their_codes() {
        for zone in [0, 1, 255] {
            for (part, number) in Part::ALL.into_iter().zip(0..) {
                let code = part.code(zone);
                assert_eq!((code % 16, code / 16), (number, zone as u32));
            }
        }
        assert_eq!(size_of::<Vertex>(), 64);
    }

    #[test]
    fn faults_of_meshes_are_found() {
        let corner = |x: f32| Vertex::at(Vec3::new(x, 0.0, 0.0), Vec3::Z, Vec3::Y, 7);
        let mut shape = Shape::new(Naming::Plain);
        assert_eq!(shape.bounds_mm(), None);
        (0..3).for_each(|k| _ = shape.push(corner(k as f32)));
        shape.triangles.push([0, 1, 2]);
        shape.check().unwrap();
        assert_eq!(shape.bounds_mm(), Some([Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0)]));
        assert_eq!(shape.vertex_bytes().len(), 192);
        shape.vertices[1].normal = [0.0, 0.0, 0.9];
        assert!(shape.check().unwrap_err().to_string().contains("vertex 1 has a vector that is no unit"));
        shape.vertices[1] = corner(f32::NAN);
        assert!(shape.check().is_err());
        shape.vertices[1] = corner(1.0);
        shape.triangles.push([0, 1, 3]);
        assert!(shape.check().unwrap_err().to_string().contains("corner 3 does not exist"));
        shape.triangles = vec![[0, 1, 2]; MOST_TRIANGLES + 1];
        assert!(shape.check().unwrap_err().to_string().contains("300001 triangles"));
    }

    #[test]
    fn tangents_are_made_to_lie_in_the_surface() {
        let vertex = Vertex::at(Vec3::ZERO, Vec3::new(0.0, 0.0, 2.0), Vec3::new(0.0, 1.0, 5.0), 1);
        assert_eq!((vertex.normal, vertex.tangent), ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]));
        let none = Vertex::at(Vec3::ZERO, Vec3::Z, Vec3::Z, 1);
        assert!(Vec3::from(none.tangent).dot(Vec3::Z).abs() < 1e-6);
    }
}
