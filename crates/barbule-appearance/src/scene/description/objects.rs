//! `[[objects]]`: shapes beside the feather.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DMat3, DVec3, Vec2, Vec3};
use serde::Serialize;
use serde_json::Value;

use super::kinds::unknown;
use super::lights::point;
use super::surfaces::NamedSurface;
use crate::error::{did_you_mean, shortened};
use crate::fields::{Fields, list};
use crate::math::rng::hash;
use crate::scene::geometry::{CurveNode, Geometry, Mesh, Place};
use crate::scene::snake::Snake;
use crate::scene::spline::{Basis, ControlCurve};
use crate::{Error, Result};

/// Most objects, and most instances of one.
const MOST_OBJECTS: usize = 1000;
const MOST_INSTANCES: usize = 100_000;

/// Most points of a snake's line.
const MOST_POINTS: usize = 1000;

/// Most conical segments of an object's curves: as many as a mesh may have triangles.
const MOST_SEGMENTS: usize = 5_000_000;

/// Memory that a triangle, a vertex, a segment, a control point and an instance take at most while hierarchies are built, bytes: what
/// was read, its copy in the scene, and the hierarchy with what it is built of. Measured: 1e6 vertices and 2e6 triangles took
/// 0.80 GB, 8e5 points of 7.6e5 slanting segments 0.66 GB.
const BYTES_PER_TRIANGLE: usize = 380;
const BYTES_PER_VERTEX: usize = 90;
const BYTES_PER_SEGMENT: usize = 850;
const BYTES_PER_POINT: usize = 32;
const BYTES_PER_INSTANCE: usize = 400;

/// Columns and rows of a sphere's quadrangles.
const SPHERE: [u32; 2] = [192, 96];

/// A shape of one surface, once or several times.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObjectDescription {
    /// What mattes call it.
    pub name: String,
    /// Its shape.
    pub shape: ObjectShape,
    /// The name of its surface.
    pub surface: String,
    /// Where it stands; one instance each.
    pub places: Vec<Placement>,
}

/// The shape of an object about its own origin.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum ObjectShape {
    /// A sphere.
    Sphere {
        /// Its radius, mm.
        radius_mm: f64,
    },
    /// A rectangle in the plane z = 0 that faces +z.
    Rectangle {
        /// Along x and y, mm.
        size_mm: [f64; 2],
    },
    /// The scales of a snake's body.
    Snake {
        /// Points that guide its middle line, from the neck to the tail, mm.
        path_mm: Vec<[f64; 3]>,
        /// Radius of the middle, mm.
        radius_mm: f64,
        /// Rows of dorsal scales, odd.
        rows: usize,
        /// How strongly scales are keeled, 0 … 1.
        keel: f64,
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
    /// Round curves from a file, in mm.
    Curves {
        /// The file.
        #[serde(skip)]
        file: String,
        /// How its control points make curves.
        basis: Basis,
        /// What is in it, once it is read.
        #[serde(skip)]
        curves: Option<Arc<Vec<ControlCurve>>>,
        /// BLAKE3 of the file.
        content: String,
    },
}

/// Where an object stands: scaled, then turned about x, y and z in this order, then moved.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Placement {
    /// Factor to all lengths.
    pub scale: f64,
    /// Turns about x, y, z, degrees, counter-clockwise seen from the axis' tip.
    pub rotate_deg: [f64; 3],
    /// The move, mm.
    pub translate_mm: [f64; 3],
}

/// Names of the bases of curves.
const BASES: [(&str, Basis); 2] = [("bspline", Basis::BSpline), ("linear", Basis::Linear)];

/// Reads the list `[[objects]]`; their surfaces must be among `surfaces`.
pub(super) fn read(
    value: &Value,
    surfaces: &BTreeMap<String, NamedSurface>,
) -> Result<Vec<ObjectDescription>> {
    let objects = list(value, "objects")?;
    if objects.len() > MOST_OBJECTS {
        return Err(Error::input(format!("objects: {} are over the limit of {MOST_OBJECTS}", objects.len())));
    }
    let read =
        |(i, object): (usize, &Value)| ObjectDescription::read(object, &format!("objects[{i}]"), surfaces);
    objects.iter().enumerate().map(read).collect()
}

impl ObjectShape {
    /// The one shape that a table gives by one of these keys.
    fn read(fields: &Fields<'_>, place: &str, keys: &[&str]) -> Result<Self> {
        let given: Vec<&str> = keys.iter().copied().filter(|key| fields.get(key).is_some()).collect();
        let shape = match given[..] {
            ["sphere_mm"] => Self::Sphere { radius_mm: fields.number_within("sphere_mm", 1e-3, 1e5)? },
            ["rectangle_mm"] => match fields.numbers("rectangle_mm")?[..] {
                [x, y] if [x, y].iter().all(|v| (1e-3..=1e5).contains(v)) => {
                    Self::Rectangle { size_mm: [x, y] }
                }
                _ => {
                    return Err(Error::input(format!(
                        "{}: give two lengths in mm, each 0.001 to 100000",
                        fields.path("rectangle_mm")
                    )));
                }
            },
            ["snake"] => Self::read_snake(fields)?,
            ["mesh"] => Self::Mesh {
                file: fields.text("mesh")?.unwrap_or_default().to_owned(),
                mesh: None,
                content: String::new(),
            },
            ["curves"] => Self::Curves {
                file: fields.text("curves")?.unwrap_or_default().to_owned(),
                basis: basis(fields)?,
                curves: None,
                content: String::new(),
            },
            _ => {
                return Err(Error::input(format!(
                    "{place} has {} shapes; give one of {}",
                    given.len(),
                    keys.join(", ")
                )));
            }
        };
        if fields.get("basis").is_some() && !matches!(shape, Self::Curves { .. }) {
            return Err(Error::input(format!("{} is given, but there are no curves", fields.path("basis"))));
        }
        Ok(shape)
    }
}

impl ObjectShape {
    fn read_snake(fields: &Fields<'_>) -> Result<Self> {
        let place = fields.path("snake");
        let table = fields.need("snake", "a table with path_mm and radius_mm")?;
        let own = Fields::new(table, &place, &["path_mm", "radius_mm", "rows", "keel"])?;
        let path = own.path("path_mm");
        let points = own.list("path_mm", "a list of points [x, y, z] in mm")?;
        if !(2..=MOST_POINTS).contains(&points.len()) {
            return Err(Error::input(format!("{path}: give 2 to {MOST_POINTS} points")));
        }
        let coordinates = |(i, value): (usize, &Value)| {
            let numbers: Option<Vec<f64>> =
                value.as_array().and_then(|list| list.iter().map(Value::as_f64).collect());
            match numbers.as_deref() {
                Some(&[x, y, z]) if [x, y, z].iter().all(|v| v.abs() <= 1e5) => Ok([x, y, z]),
                _ => Err(Error::input(format!("{path}[{i}]: give three numbers in mm, each up to 100000"))),
            }
        };
        let path_mm: Vec<[f64; 3]> = points.iter().enumerate().map(coordinates).collect::<Result<_>>()?;
        let rows = own.get("rows").map_or(Ok(15.0), |_| own.number_within("rows", 5.0, 61.0))?;
        if rows % 2.0 != 1.0 {
            return Err(Error::input(format!("{} is {rows}; give an odd number", own.path("rows"))));
        }
        let shape = Self::Snake {
            path_mm,
            radius_mm: own.number_within("radius_mm", 0.1, 1000.0)?,
            rows: rows as usize,
            keel: own.get("keel").map_or(Ok(0.0), |_| own.number_within("keel", 0.0, 1.0))?,
        };
        if shape.snake().is_some_and(|snake| snake.size()[1] > MOST_SEGMENTS) {
            return Err(Error::input(format!(
                "{place} has too many scales for its length; give a greater radius_mm or fewer rows"
            )));
        }
        Ok(shape)
    }

    fn snake(&self) -> Option<Snake> {
        let Self::Snake { path_mm, radius_mm, rows, keel } = self else { return None };
        let path_mm = path_mm.iter().copied().map(DVec3::from_array).collect();
        Some(Snake { path_mm, radius_mm: *radius_mm, rows: *rows, keel: *keel })
    }
}

/// A B-spline unless said otherwise.
fn basis(fields: &Fields<'_>) -> Result<Basis> {
    let name = fields.text("basis")?.unwrap_or(BASES[0].0);
    let known = BASES.iter().find(|(known, _)| *known == name).map(|(_, basis)| *basis);
    known.ok_or_else(|| unknown(&fields.path("basis"), name, &BASES.map(|(known, _)| known)))
}

impl ObjectDescription {
    fn read(table: &Value, place: &str, surfaces: &BTreeMap<String, NamedSurface>) -> Result<Self> {
        const KEYS: [&str; 12] = [
            "sphere_mm",
            "rectangle_mm",
            "snake",
            "mesh",
            "curves",
            "basis",
            "name",
            "surface",
            "scale",
            "rotate_deg",
            "translate_mm",
            "instances",
        ];
        let fields = Fields::new(table, place, &KEYS)?;
        let shape = ObjectShape::read(&fields, place, &KEYS[..5])?;
        let surface = fields.text("surface")?.ok_or_else(|| {
            Error::input(format!("{place}.surface is missing; give the name of a table [surfaces.NAME]"))
        })?;
        if !surfaces.contains_key(surface) {
            let near = did_you_mean(surface, surfaces.keys().map(String::as_str));
            let surface = shortened(surface);
            return Err(Error::input(format!(
                "{place}.surface is '{surface}'{near}; there is no table [surfaces.{surface}] with a type"
            )));
        }
        let own = Placement::read(&fields)?;
        let places = match fields.get("instances") {
            None => vec![own],
            Some(value) => {
                let path = fields.path("instances");
                let instances = list(value, &path)?;
                if !(1..=MOST_INSTANCES).contains(&instances.len()) {
                    return Err(Error::input(format!("{path}: give 1 to {MOST_INSTANCES} instances")));
                }
                if own != Placement::HERE {
                    return Err(Error::input(format!(
                        "{place} has instances and a place of its own; give scale, rotate_deg and translate_mm in the instances"
                    )));
                }
                let one = |(i, table): (usize, &Value)| {
                    let known = ["scale", "rotate_deg", "translate_mm"];
                    Placement::read(&Fields::new(table, &format!("{path}[{i}]"), &known)?)
                };
                instances.iter().enumerate().map(one).collect::<Result<_>>()?
            }
        };
        let name = fields.text("name")?.unwrap_or(surface).to_owned();
        Ok(Self { name, shape, surface: surface.to_owned(), places })
    }

    /// Its table in a scene file.
    pub(super) fn table(&self) -> Value {
        let mut table = serde_json::json!({"name": self.name, "surface": self.surface});
        let (key, value) = match &self.shape {
            ObjectShape::Sphere { radius_mm } => ("sphere_mm", serde_json::json!(radius_mm)),
            ObjectShape::Rectangle { size_mm } => ("rectangle_mm", serde_json::json!(size_mm)),
            ObjectShape::Snake { path_mm, radius_mm, rows, keel } => (
                "snake",
                serde_json::json!({"path_mm": path_mm, "radius_mm": radius_mm, "rows": rows, "keel": keel}),
            ),
            ObjectShape::Mesh { file, .. } => ("mesh", serde_json::json!(file)),
            ObjectShape::Curves { file, .. } => ("curves", serde_json::json!(file)),
        };
        if let Value::Object(table) = &mut table {
            if let ObjectShape::Curves { basis: Basis::Linear, .. } = self.shape {
                table.insert("basis".to_owned(), "linear".into());
            }
            table.insert(key.to_owned(), value);
            table.insert(
                "instances".to_owned(),
                self.places.iter().map(|place| serde_json::json!(place)).collect(),
            );
        }
        table
    }

    /// Its shape and where it stands; `index`: its own among the objects.
    ///
    /// # Errors
    /// A mesh or curves that are not read; curves of too many segments.
    pub fn geometry(&self, index: usize) -> Result<Geometry> {
        let identity = |instance: usize| hash(0x006f_626a, &[index as u64, instance as u64]);
        let places = self.places.iter().enumerate().map(|(i, place)| place.place(identity(i))).collect();
        let made;
        let mesh = match &self.shape {
            ObjectShape::Sphere { radius_mm } => {
                made = sphere(*radius_mm);
                &made
            }
            ObjectShape::Rectangle { size_mm } => {
                made = rectangle(*size_mm);
                &made
            }
            ObjectShape::Snake { .. } => {
                let mesh = self.shape.snake().map(|snake| snake.mesh(identity(0))).unwrap_or_default();
                let meshes = vec![Mesh { id: identity(0), ..mesh }];
                return Ok(Geometry { meshes, places, ..Geometry::default() });
            }
            ObjectShape::Mesh { mesh: Some(mesh), .. } => mesh.as_ref(),
            ObjectShape::Mesh { file, .. } => {
                return Err(Error::input(format!("the mesh '{file}' is not read")));
            }
            ObjectShape::Curves { file, basis, curves, .. } => {
                let curves = curves
                    .as_ref()
                    .ok_or_else(|| Error::input(format!("the curves '{file}' are not read")))?;
                let grown = grow(curves, *basis, identity(0)).map_err(|error| error.at(file))?;
                return Ok(Geometry { places, ..grown });
            }
        };
        let mesh = Mesh { tangents: upwards(mesh), id: identity(0), ..mesh.clone() };
        Ok(Geometry { meshes: vec![mesh], places, ..Geometry::default() })
    }
}

impl ObjectDescription {
    /// Memory that it takes while its hierarchy is built, bytes, once its file is read.
    pub(super) fn bytes(&self) -> usize {
        let mesh =
            |vertices: usize, triangles: usize| vertices * BYTES_PER_VERTEX + triangles * BYTES_PER_TRIANGLE;
        let shape = match &self.shape {
            ObjectShape::Sphere { .. } => {
                let quadrangles = (SPHERE[0] * SPHERE[1]) as usize;
                mesh(quadrangles, 2 * quadrangles)
            }
            ObjectShape::Rectangle { .. } => mesh(4, 2),
            ObjectShape::Snake { .. } => self.shape.snake().map_or(0, |snake| {
                let [vertices, triangles] = snake.size();
                mesh(vertices, triangles)
            }),
            ObjectShape::Mesh { mesh: read, .. } => {
                read.as_ref().map_or(0, |read| mesh(read.positions.len(), read.triangles.len()))
            }
            ObjectShape::Curves { basis, curves, .. } => {
                let all = curves.iter().flat_map(|curves| curves.iter());
                let one = |curve: &ControlCurve| {
                    curve.len() * BYTES_PER_POINT + basis.segments(&nodes(curve)) * BYTES_PER_SEGMENT
                };
                all.map(one).sum()
            }
        };
        shape + self.places.len() * BYTES_PER_INSTANCE
    }
}

impl Placement {
    /// Where a shape is made.
    pub const HERE: Self = Self { scale: 1.0, rotate_deg: [0.0; 3], translate_mm: [0.0; 3] };

    pub(super) fn read(fields: &Fields<'_>) -> Result<Self> {
        let vector = |key: &str| fields.get(key).map_or(Ok([0.0; 3]), |_| point(fields, key));
        Ok(Self {
            scale: fields.get("scale").map_or(Ok(1.0), |_| fields.number_within("scale", 1e-6, 1e6))?,
            rotate_deg: vector("rotate_deg")?,
            translate_mm: vector("translate_mm")?,
        })
    }

    pub(super) fn place(&self, id: u64) -> Place {
        let [x, y, z] = self.rotate_deg.map(f64::to_radians);
        let turn = DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x);
        Place { scale: self.scale, turn, shift: self.translate_mm.into(), id }
    }
}

fn nodes(curve: &ControlCurve) -> Vec<CurveNode> {
    let node = |&[x, y, z, radius]: &[f64; 4]| CurveNode {
        point: DVec3::new(x, y, z).as_vec3(),
        radius: radius as f32,
        ..CurveNode::default()
    };
    curve.iter().map(node).collect()
}

/// Curves as conical segments; `id`: the object's.
fn grow(curves: &[ControlCurve], basis: Basis, id: u64) -> Result<Geometry> {
    let mut geometry = Geometry::default();
    let mut segments = 0;
    for (index, curve) in (0_u64..).zip(curves) {
        let nodes = nodes(curve);
        segments += basis.segments(&nodes);
        if segments > MOST_SEGMENTS {
            return Err(Error::input(format!(
                "its curves need over {MOST_SEGMENTS} segments; give fewer or less bent ones, or share them among several objects"
            )));
        }
        geometry.add_control_curve(&nodes, basis, hash(id, &[index]));
    }
    Ok(geometry)
}

/// At each vertex the direction in which the texture's v grows, the mean over its triangles; none where a mesh has no texture
/// coordinates.
fn upwards(mesh: &Mesh) -> Vec<Vec3> {
    if mesh.uvs.is_empty() {
        return Vec::new();
    }
    let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|corner| corner as usize);
        let (p, q) = (mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
        let (s, t) = (mesh.uvs[b] - mesh.uvs[a], mesh.uvs[c] - mesh.uvs[a]);
        // p = s.x ∂u + s.y ∂v, q = t.x ∂u + t.y ∂v, times the determinant's sign.
        let along = (q * s.x - p * t.x) * s.perp_dot(t).signum();
        for corner in [a, b, c] {
            sums[corner] += along;
        }
    }
    sums.into_iter().map(|sum| sum.normalize_or(Vec3::Y)).collect()
}

/// A sphere of quadrangles; u goes round from +y clockwise seen from +z, v from the lower pole to the upper one.
fn sphere(radius_mm: f64) -> Mesh {
    let [columns, rows] = SPHERE;
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let (u, v) = (f64::from(column) / f64::from(columns), f64::from(row) / f64::from(rows));
            let (around, polar) = (TAU * u, PI * (1.0 - v));
            let (sine, cosine) = (libm::sin(polar), libm::cos(polar));
            let normal = DVec3::new(sine * libm::sin(around), sine * libm::cos(around), cosine);
            mesh.positions.push((normal * radius_mm).as_vec3());
            mesh.normals.push(normal.as_vec3());
            mesh.uvs.push(Vec2::new(u as f32, v as f32));
        }
    }
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let at = row * (columns + 1) + column;
        let (above, right) = (at + columns + 1, 1);
        mesh.triangles.push([at, above, at + right]);
        mesh.triangles.push([at + right, above, above + right]);
    }
    mesh
}

fn rectangle([x, y]: [f64; 2]) -> Mesh {
    let (x, y) = ((0.5 * x) as f32, (0.5 * y) as f32);
    Mesh {
        positions: vec![
            Vec3::new(-x, -y, 0.0),
            Vec3::new(x, -y, 0.0),
            Vec3::new(x, y, 0.0),
            Vec3::new(-x, y, 0.0),
        ],
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn objects(text: &str) -> Result<Vec<ObjectDescription>> {
        let surfaces =
            BTreeMap::from([("white".to_owned(), NamedSurface::Dielectric { index: 1.5, roughness: None })]);
        let table: Value = toml::from_str(text).unwrap();
        read(&table["objects"], &surfaces)
    }

    /// Outwards, closed, of the sphere's area but for the facets.
    #[test]
    fn spheres_are_closed_and_face_outwards() {
        let mesh = sphere(2.0);
        let (mut area, mut volume) = (0.0, 0.0);
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize].as_dvec3());
            let normal = (b - a).cross(c - a);
            assert!(normal.dot(a + b + c) >= -1e-9);
            area += 0.5 * normal.length();
            volume += a.dot(b.cross(c)) / 6.0;
        }
        assert!((area / (16.0 * PI) - 1.0).abs() < 1e-3 && (volume / (32.0 / 3.0 * PI) - 1.0).abs() < 2e-3);
        let all = Geometry { meshes: vec![mesh], ..Geometry::default() };
        all.check().unwrap();
    }

    #[test]
    fn instances_are_scaled_turned_and_moved_in_this_order() {
        let text = "[[objects]]\nrectangle_mm = [2, 4]\nsurface = 'white'\n\
                    instances = [{}, {scale = 3, rotate_deg = [90, 0, 90], translate_mm = [0, 0, 5]}]";
        let geometry = objects(text).unwrap()[0].geometry(4).unwrap();
        let corner = geometry.meshes[0].positions[2].as_dvec3();
        assert_eq!(geometry.places[0].point(corner), DVec3::new(1.0, 2.0, 0.0));
        // (3, 6, 0) → about x (3, 0, 6) → about z (0, 3, 6) → moved.
        let place = geometry.places[1];
        assert!((place.point(corner) - DVec3::new(0.0, 3.0, 11.0)).length() < 1e-12);
        assert!((place.point_back(place.point(corner)) - corner).length() < 1e-12);
        assert_ne!(geometry.places[0].id, place.id);
        // A texture's upward direction turns with the shape: y → z → z.
        let upwards = geometry.meshes[0].tangents[0].as_dvec3();
        assert!(
            (upwards - DVec3::Y).length() < 1e-6 && (place.direction(upwards) - DVec3::Z).length() < 1e-6
        );
    }

    /// In mm where the file says so; what is not read, or too many segments, is refused.
    #[test]
    fn curves_stand_where_their_points_are() {
        let mut object =
            objects("[[objects]]\ncurves = 'a.txt'\nbasis = 'linear'\nsurface = 'white'\nscale = 2")
                .unwrap()
                .remove(0);
        assert!(object.geometry(0).unwrap_err().to_string().contains("the curves 'a.txt' are not read"));
        let mut fill = |points: Vec<[f64; 4]>| {
            let ObjectShape::Curves { curves, .. } = &mut object.shape else { panic!() };
            *curves = Some(Arc::new(vec![points.clone(), points]));
            object.geometry(0)
        };
        let geometry = fill(vec![[1.0, 2.0, 3.0, 0.5], [1.0, 2.0, 4.0, 0.25]]).unwrap();
        assert_eq!(geometry.curves.len(), 2);
        assert_ne!(geometry.curves[0].id, geometry.curves[1].id);
        let end = geometry.curve_nodes[3];
        assert_eq!((end.point, end.radius), (Vec3::new(1.0, 2.0, 4.0), 0.25));
        assert_eq!(geometry.places[0].point(end.point.as_dvec3()), DVec3::new(2.0, 4.0, 8.0));
        let message = fill(vec![[0.0, 0.0, 0.0, 1.0]; MOST_SEGMENTS / 2 + 2]).unwrap_err().to_string();
        assert!(message.starts_with("a.txt: its curves need over 5000000 segments"), "{message}");
    }

    #[test]
    fn bad_objects_are_refused_by_key() {
        let message = |text: &str| objects(&format!("[[objects]]\n{text}")).unwrap_err().to_string();
        assert!(message("surface = 'white'").contains("objects[0] has 0 shapes"));
        assert!(message("sphere_mm = 1\nmesh = 'a.ply'\nsurface = 'white'").contains("has 2 shapes"));
        assert!(message("sphere_mm = 0\nsurface = 'white'").contains("objects[0].sphere_mm is 0, outside"));
        assert!(message("sphere_mm = 1").contains("surface is missing"));
        assert!(message("sphere_mm = 1\nsurface = 'whit'").contains("did you mean 'white'"));
        assert!(message("sphre_mm = 1\nsurface = 'white'").contains("did you mean 'sphere_mm'"));
        assert!(
            message("curves = 'a.txt'\nbasis = 'bsplin'\nsurface = 'white'")
                .contains("did you mean 'bspline'")
        );
        assert!(message("curve = 'a.txt'\nsurface = 'white'").contains("did you mean 'curves'"));
        assert!(
            message("sphere_mm = 1\nbasis = 'linear'\nsurface = 'white'").contains("there are no curves")
        );
        assert!(message("rectangle_mm = [1]\nsurface = 'white'").contains("two lengths"));
        assert!(message("sphere_mm = 1\nsurface = 'white'\ninstances = []").contains("1 to 100000"));
        assert!(
            message("sphere_mm = 1\nsurface = 'white'\nscale = 2\ninstances = [{}]")
                .contains("a place of its own")
        );
        assert!(
            message("sphere_mm = 1\nsurface = 'white'\ninstances = [{scale = 0}]")
                .contains("instances[0].scale")
        );
        assert!(message("sphere_mm = 1\nsurface = 'white'\ntranslate_mm = [1, 2]").contains("three numbers"));
    }
}
