//! Surfaces that barbules lie on side by side: a ball, and a piece of a vane that is bent about an axis along them.
//!
//! Both are objects that scene files have, with the same texture coordinates and names: what is drawn here is what the renderer draws.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

use barbule_appearance::bsdf::Layout;
use barbule_appearance::scene::description::{ObjectDescription, ObjectShape};
use barbule_base::{Error, Result};
use glam::{DVec2, DVec3};

use super::names::name_at;
use super::{Naming, Part, Shape, Vertex};

/// Radius of the ball, mm: some hundred barbules lie between its poles.
pub const SPHERE_MM: f64 = 1.0;

/// How barbules lie on the ball and the vane but for what a unit of u and v is, mm: as wide and long as a starling's, with cells.
pub const BARBULE_LAYOUT: Layout =
    Layout { uv_mm: [1.0, 1.0], width_mm: 0.025, length_mm: 0.4, cell_mm: 0.025, swelling: 0.0 };

/// Columns and rows of the ball's quadrangles, and of the vane's across and along: a ball's outline is right to a quarter of a pixel in a
/// thousand, and processors that draw have few small triangles.
const SPHERE: [u32; 2] = [96, 48];
const VANE: [u32; 2] = [48, 6];

/// A piece of a vane, bent about the y axis, along which its barbules lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bend {
    /// Across and along the barbules, on the surface, mm.
    pub size_mm: [f64; 2],
    /// The angle between the normals at its two edges, rad; 0: flat.
    pub angle: f64,
}

impl Bend {
    /// A few dozen barbules, over which the normal turns by 100°.
    pub const USUAL: Self = Self { size_mm: [1.6, 1.2], angle: 100.0 * PI / 180.0 };

    /// Place and normal at shares of its extent across and along.
    fn at(&self, [across, along]: [f64; 2]) -> (DVec3, DVec3) {
        let [width, length] = self.size_mm;
        let turn = (across - 0.5) * self.angle;
        let (sine, cosine) = (libm::sin(turn), libm::cos(turn));
        let y = (along - 0.5) * length;
        let normal = DVec3::new(sine, 0.0, cosine);
        if self.angle.abs() < 1e-9 {
            return (DVec3::new((across - 0.5) * width, y, 0.0), normal);
        }
        let radius = width / self.angle;
        (DVec3::new(radius * sine, y, radius * (cosine - 1.0)), normal)
    }
}

/// The names of the first object of a scene and of the first place that it stands in.
fn first_object() -> Result<u64> {
    let object = ObjectDescription::here("ball", ObjectShape::Sphere { radius_mm: SPHERE_MM });
    let geometry = object.geometry(0)?;
    match (geometry.meshes.first(), geometry.places.first()) {
        (Some(mesh), Some(place)) => Ok(name_at(mesh.id, place.id)),
        _ => Err(Error::machine("a ball has no mesh or no place")),
    }
}

/// The ball, clad in barbules along its parallels. Texture coordinates: u goes round from +y clockwise seen from +z, v from the lower
/// pole to the upper one.
///
/// # Errors
/// None, as long as scenes have balls.
pub fn sphere() -> Result<Shape> {
    let layout = Layout { uv_mm: [TAU * SPHERE_MM, PI * SPHERE_MM], ..BARBULE_LAYOUT };
    let of = |u: f64, v: f64| {
        let (around, polar) = (TAU * u, PI * (1.0 - v));
        let (sine, cosine) = (libm::sin(polar), libm::cos(polar));
        let normal = DVec3::new(sine * libm::sin(around), sine * libm::cos(around), cosine);
        let along = DVec3::new(libm::cos(around), -libm::sin(around), 0.0);
        (normal * SPHERE_MM, normal, along)
    };
    Ok(grid(SPHERE, layout, first_object()?, of))
}

/// A bent piece of a vane. Texture coordinates: u along the barbules from 0 to 1, v across them.
///
/// # Errors
/// As [`sphere`].
pub fn vane(bend: &Bend) -> Result<Shape> {
    let [width, length] = bend.size_mm;
    let layout = Layout { uv_mm: [length, width], ..BARBULE_LAYOUT };
    let of = |u: f64, v: f64| {
        let (place, normal) = bend.at([v, u]);
        (place, normal, DVec3::Y)
    };
    let [across, along] = VANE;
    Ok(grid([along, across], layout, first_object()?, of))
}

/// The quadrangles over (u, v) from 0 to 1; `of`: place, normal and tangent. v grows to the right of u, seen from outside.
fn grid(
    [columns, rows]: [u32; 2],
    layout: Layout,
    name: u64,
    of: impl Fn(f64, f64) -> (DVec3, DVec3, DVec3),
) -> Shape {
    let mut shape = Shape::new(Naming::Clad(layout));
    for (row, column) in (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))) {
        let (u, v) = (f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows));
        let (place, normal, along) = of(u, v);
        let vertex = Vertex::at(place.as_vec3(), normal.as_vec3(), along.as_vec3(), name);
        shape.push(Vertex {
            place: DVec2::new(u, v).as_vec2().into(),
            half_width_mm: (0.5 * layout.width_mm) as f32,
            part: Part::Distal.code(0),
            ..vertex
        });
    }
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let at = row * (columns + 1) + column;
        let (above, right) = (at + columns + 1, at + 1);
        shape.triangles.extend([[at, above, right], [right, above, above + 1]]);
    }
    shape
}

/// The vane as the text of an OBJ file, mm, for scene files.
///
/// # Errors
/// As [`vane`].
pub fn vane_obj(bend: &Bend) -> Result<String> {
    let shape = vane(bend)?;
    let mut text = String::from("# a bent piece of a vane, mm; u along the barbules, v across\n");
    let failed = |_| Error::machine("a text cannot be written");
    for vertex in &shape.vertices {
        let ([x, y, z], [nx, ny, nz], [u, v]) = (vertex.position_mm, vertex.normal, vertex.place);
        write!(text, "v {x} {y} {z}\nvn {nx} {ny} {nz}\nvt {u} {v}\n").map_err(failed)?;
    }
    for corners in &shape.triangles {
        let [a, b, c] = corners.map(|corner| corner + 1);
        writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}").map_err(failed)?;
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::names::{clad_instance, words_of};
    use barbule_appearance::bsdf::Hit;
    use glam::Vec3;

    /// Faces look where their normals do.
    fn look_outwards(shape: &Shape) -> bool {
        shape.triangles.iter().all(|corners| {
            let [a, b, c] = corners.map(|corner| Vec3::from(shape.vertices[corner as usize].position_mm));
            let normal = Vec3::from(shape.vertices[corners[0] as usize].normal);
            (b - a).cross(c - a).dot(normal) >= -1e-9
        })
    }

    #[test]
    fn the_ball_is_the_renderers() {
        let shape = sphere().unwrap();
        shape.check().unwrap();
        let [columns, rows] = SPHERE.map(|side| side as usize);
        assert_eq!(shape.vertices.len(), (columns + 1) * (rows + 1));
        assert_eq!(shape.triangles.len(), 2 * columns * rows);
        assert!(look_outwards(&shape));
        let object = ObjectDescription::here("ball", ObjectShape::Sphere { radius_mm: SPHERE_MM });
        let geometry = object.geometry(0).unwrap();
        let (mesh, place) = (&geometry.meshes[0], &geometry.places[0]);
        // The renderer's has twice as many, of which every other corner is one of these.
        assert_eq!(mesh.positions.len(), (2 * columns + 1) * (2 * rows + 1));
        for (k, vertex) in shape.vertices.iter().enumerate() {
            let (row, column) = (k / (columns + 1), k % (columns + 1));
            let k = 2 * row * (2 * columns + 1) + 2 * column;
            assert_eq!(vertex.place, [mesh.uvs[k].x, mesh.uvs[k].y]);
            assert!(mesh.positions[k].distance(vertex.position_mm.into()) < 1e-6);
            assert!(mesh.normals[k].distance(vertex.normal.into()) < 1e-6);
            assert_eq!(vertex.name, words_of(name_at(mesh.id, place.id)));
        }
    }

    /// A hit where a ray would meet the surface has the name that the renderer gives it, and the frame that the vertices have.
    #[test]
    fn names_and_frames_are_those_of_hits() {
        let shape = sphere().unwrap();
        let Naming::Clad(layout) = shape.naming else { panic!() };
        let name = first_object().unwrap();
        for k in (0..shape.vertices.len()).step_by(997) {
            let vertex = &shape.vertices[k];
            let uv = vertex.place.map(f64::from);
            let normal = Vec3::from(vertex.normal).as_dvec3();
            let (north, east) = (DVec3::Z - normal * normal.z, Vec3::from(vertex.tangent).as_dvec3());
            if north.length() < 0.1 {
                continue;
            }
            let gradients = [east / (TAU * north.length()), north.normalize() / PI];
            let mut hit = Hit { uv, uv_gradients: gradients, id: name, ..Hit::default() };
            hit.frame.z = normal;
            let on = layout.on_barbule(&hit);
            assert_eq!(on.instance, clad_instance(&layout, name, uv));
            assert!(on.frame.y.distance(east) < 1e-5, "{k}: {} {east}", on.frame.y);
        }
    }

    #[test]
    fn a_bent_vane_is_as_large_as_it_says_and_its_file_is_read_as_it() {
        let shape = vane(&Bend::USUAL).unwrap();
        shape.check().unwrap();
        assert_eq!(shape.triangles.len(), 2 * 48 * 6);
        assert!(look_outwards(&shape));
        let area: f64 = (shape.triangles.iter())
            .map(|corners| {
                let at = |c: u32| Vec3::from(shape.vertices[c as usize].position_mm).as_dvec3();
                let [a, b, c] = corners.map(at);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum();
        assert!((area / (1.6 * 1.2) - 1.0).abs() < 1e-3, "{area}");
        let turned = Vec3::from(shape.vertices[0].normal)
            .angle_between(shape.vertices[shape.vertices.len() - 1].normal.into());
        assert!((f64::from(turned) - Bend::USUAL.angle).abs() < 1e-4);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("vane.obj");
        std::fs::write(&path, vane_obj(&Bend::USUAL).unwrap()).unwrap();
        let (mesh, _) = barbule::io::read_mesh(&path).unwrap();
        assert_eq!(mesh.triangles.len(), shape.triangles.len());
        for (corners, own) in mesh.triangles.iter().zip(&shape.triangles) {
            for (read, own) in corners.iter().zip(own) {
                let vertex = &shape.vertices[*own as usize];
                assert_eq!(<[f32; 3]>::from(mesh.positions[*read as usize]), vertex.position_mm);
                assert_eq!(<[f32; 2]>::from(mesh.uvs[*read as usize]), vertex.place);
            }
        }
        let flat = vane(&Bend { angle: 0.0, ..Bend::USUAL }).unwrap();
        assert!(flat.vertices.iter().all(|vertex| vertex.position_mm[2] == 0.0));
    }
}
