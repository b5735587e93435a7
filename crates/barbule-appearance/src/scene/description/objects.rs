//! `[[objects]]` and the named `[surfaces.NAME]` that they are made of.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DMat3, DVec3, Vec2, Vec3};
use serde::Serialize;
use serde_json::Value;

use super::colour::colour;
use super::lights::point;
use super::{FibreDescription, PigmentedKeratin};
use crate::bsdf::Texture;
use crate::error::{did_you_mean, shortened};
use crate::fields::{Fields, list};
use crate::math::rng::hash;
use crate::scene::geometry::{Geometry, Mesh, Place};
use crate::{Error, Result};

/// Most objects, and most instances of one.
const MOST_OBJECTS: usize = 1000;
const MOST_INSTANCES: usize = 100_000;

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

/// A surface with a name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum NamedSurface {
    /// Perfectly diffuse.
    Diffuse {
        /// sRGB, 0 … 1.
        colour: [f64; 3],
        /// Pictures by their keys: `albedo`, `alpha`, `normal`.
        pictures: BTreeMap<&'static str, TextureFile>,
    },
    /// Pigmented keratin.
    Keratin(PigmentedKeratin),
    /// Fibres of hair.
    Hair(FibreDescription),
    /// Glass.
    Dielectric {
        /// Refractive index.
        index: f64,
    },
}

/// A picture on a surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TextureFile {
    /// The file.
    #[serde(skip)]
    pub file: String,
    /// What is in it, once it is read.
    #[serde(skip)]
    pub texture: Option<Texture>,
    /// BLAKE3 of the file.
    pub content: String,
}

impl TextureFile {
    fn new(file: &str) -> Self {
        Self { file: file.to_owned(), texture: None, content: String::new() }
    }

    /// The picture.
    ///
    /// # Errors
    /// It is not read.
    pub fn read(&self) -> Result<Texture> {
        let unread = || Error::input(format!("the texture '{}' is not read", self.file));
        self.texture.clone().ok_or_else(unread)
    }
}

/// Keys of pictures on diffuse surfaces: what the colour is multiplied with, what is black where there are holes, normals.
const PICTURES: [&str; 3] = ["albedo", "alpha", "normal"];

const TYPES: [&str; 4] = ["diffuse", "keratin", "hair", "dielectric"];

impl NamedSurface {
    /// Reads `[surfaces.NAME]` with a `type`.
    pub(super) fn read(table: &Value, place: &str) -> Result<Self> {
        let kind = match table.get("type") {
            Some(Value::String(kind)) => kind.as_str(),
            _ => {
                return Err(Error::input(format!(
                    "{place}.type is missing; give one of {}",
                    TYPES.join(", ")
                )));
            }
        };
        match kind {
            "diffuse" => {
                let fields =
                    Fields::new(table, place, &["type", "colour", PICTURES[0], PICTURES[1], PICTURES[2]])?;
                let white = [1.0; 3];
                let mut pictures = BTreeMap::new();
                for key in PICTURES {
                    if let Some(file) = fields.text(key)? {
                        pictures.insert(key, TextureFile::new(file));
                    }
                }
                let colour = fields.get("colour").map_or(Ok(white), |c| colour(c, &fields.path("colour")))?;
                Ok(Self::Diffuse { colour, pictures })
            }
            "keratin" => Ok(Self::Keratin(PigmentedKeratin::read(&untyped(table), place)?)),
            "hair" => Ok(Self::Hair(FibreDescription::read(&untyped(table), place)?)),
            "dielectric" => {
                let fields = Fields::new(table, place, &["type", "index"])?;
                Ok(Self::Dielectric { index: fields.number_within("index", 1.01, 3.9)? })
            }
            other => {
                let other = shortened(other);
                let near = did_you_mean(&other, TYPES);
                Err(Error::input(format!("{place}.type is '{other}'{near}; known are {}", TYPES.join(", "))))
            }
        }
    }

    /// Its table in a scene file.
    pub(super) fn table(&self) -> Value {
        let (kind, mut table) = match self {
            Self::Diffuse { colour, pictures } => {
                let mut table = serde_json::json!({"colour": colour});
                if let Value::Object(table) = &mut table {
                    let named = |(key, picture): (&&str, &TextureFile)| {
                        ((*key).to_owned(), picture.file.as_str().into())
                    };
                    table.extend(pictures.iter().map(named));
                }
                ("diffuse", table)
            }
            Self::Keratin(keratin) => ("keratin", keratin.table()),
            Self::Hair(hair) => ("hair", hair.table()),
            Self::Dielectric { index } => ("dielectric", serde_json::json!({"index": index})),
        };
        if let Value::Object(table) = &mut table {
            table.insert("type".to_owned(), kind.into());
        }
        table
    }
}

/// A table without its `type`.
fn untyped(table: &Value) -> Value {
    let mut table = table.clone();
    if let Value::Object(table) = &mut table {
        table.remove("type");
    }
    table
}

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

impl ObjectDescription {
    fn read(table: &Value, place: &str, surfaces: &BTreeMap<String, NamedSurface>) -> Result<Self> {
        const KEYS: [&str; 10] = [
            "name",
            "sphere_mm",
            "rectangle_mm",
            "mesh",
            "surface",
            "scale",
            "rotate_deg",
            "translate_mm",
            "instances",
            "curves",
        ];
        let fields = Fields::new(table, place, &KEYS[..9])?;
        let given: Vec<&str> = KEYS[1..4].iter().copied().filter(|key| fields.get(key).is_some()).collect();
        let shape = match given[..] {
            ["sphere_mm"] => ObjectShape::Sphere { radius_mm: fields.number_within("sphere_mm", 1e-3, 1e5)? },
            ["rectangle_mm"] => match fields.numbers("rectangle_mm")?[..] {
                [x, y] if [x, y].iter().all(|v| (1e-3..=1e5).contains(v)) => {
                    ObjectShape::Rectangle { size_mm: [x, y] }
                }
                _ => {
                    return Err(Error::input(format!(
                        "{}: give two lengths in mm, each 0.001 to 100000",
                        fields.path("rectangle_mm")
                    )));
                }
            },
            ["mesh"] => ObjectShape::Mesh {
                file: fields.text("mesh")?.unwrap_or_default().to_owned(),
                mesh: None,
                content: String::new(),
            },
            _ => {
                return Err(Error::input(format!(
                    "{place} has {} shapes; give one of sphere_mm, rectangle_mm, mesh",
                    given.len()
                )));
            }
        };
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
            ObjectShape::Mesh { file, .. } => ("mesh", serde_json::json!(file)),
        };
        if let Value::Object(table) = &mut table {
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
    /// A mesh that is not read.
    pub fn geometry(&self, index: usize) -> Result<Geometry> {
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
            ObjectShape::Mesh { mesh: Some(mesh), .. } => mesh.as_ref(),
            ObjectShape::Mesh { file, .. } => {
                return Err(Error::input(format!("the mesh '{file}' is not read")));
            }
        };
        let identity = |instance: usize| hash(0x006f_626a, &[index as u64, instance as u64]);
        let mesh = Mesh { tangents: upwards(mesh), id: identity(0), ..mesh.clone() };
        let places = self.places.iter().enumerate().map(|(i, place)| place.place(identity(i)));
        Ok(Geometry { meshes: vec![mesh], places: places.collect(), ..Geometry::default() })
    }
}

impl Placement {
    /// Where a shape is made.
    pub const HERE: Self = Self { scale: 1.0, rotate_deg: [0.0; 3], translate_mm: [0.0; 3] };

    fn read(fields: &Fields<'_>) -> Result<Self> {
        let vector = |key: &str| fields.get(key).map_or(Ok([0.0; 3]), |_| point(fields, key));
        Ok(Self {
            scale: fields.get("scale").map_or(Ok(1.0), |_| fields.number_within("scale", 1e-6, 1e6))?,
            rotate_deg: vector("rotate_deg")?,
            translate_mm: vector("translate_mm")?,
        })
    }

    fn place(&self, id: u64) -> Place {
        let [x, y, z] = self.rotate_deg.map(f64::to_radians);
        let turn = DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x);
        Place { scale: self.scale, turn, shift: self.translate_mm.into(), id }
    }
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
        let surfaces = BTreeMap::from([("white".to_owned(), NamedSurface::Dielectric { index: 1.5 })]);
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

    #[test]
    fn bad_objects_are_refused_by_key() {
        let message = |text: &str| objects(&format!("[[objects]]\n{text}")).unwrap_err().to_string();
        assert!(message("surface = 'white'").contains("objects[0] has 0 shapes"));
        assert!(message("sphere_mm = 1\nmesh = 'a.ply'\nsurface = 'white'").contains("has 2 shapes"));
        assert!(message("sphere_mm = 0\nsurface = 'white'").contains("objects[0].sphere_mm is 0, outside"));
        assert!(message("sphere_mm = 1").contains("surface is missing"));
        assert!(message("sphere_mm = 1\nsurface = 'whit'").contains("did you mean 'white'"));
        assert!(message("sphre_mm = 1\nsurface = 'white'").contains("did you mean 'sphere_mm'"));
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
        let surface = |text: &str| {
            let table: Value = toml::from_str(text).unwrap();
            NamedSurface::read(&table, "surfaces.table").unwrap_err().to_string()
        };
        assert!(surface("index = 1").contains("surfaces.table.type is missing"));
        assert!(surface("type = 'difuse'").contains("did you mean 'diffuse'"));
        assert!(surface("type = 'dielectric'\nindex = 9").contains("surfaces.table.index is 9"));
        assert!(surface("type = 'diffuse'\ncolour = 3").contains("surfaces.table.colour"));
        assert!(
            surface("type = 'keratin'\nroughness = 0.2\nindex = 1.5")
                .contains("surfaces.table.melanin is missing")
        );
    }
}
