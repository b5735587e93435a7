//! Shapes where they stand, as files: binary PLY meshes and control points of round curves.

use std::fmt::Write as _;

use glam::{Vec2, Vec3};

use crate::scene::geometry::{CurveNode, Geometry, Mesh, Place, Ribbon, RibbonNode};

/// Shapes and where they stand; without a place where they were made.
pub(super) type Stands<'a> = Vec<(&'a Geometry, Option<Place>)>;

/// Every place of an object's shapes and of those that repeat in it.
pub(super) fn stands(whole: &Geometry) -> Stands<'_> {
    let mut all: Stands<'_> = match &whole.places[..] {
        [] => vec![(whole, None)],
        places => places.iter().map(|place| (whole, Some(*place))).collect(),
    };
    for repeated in &whole.repeated {
        all.extend(whole.places_of(repeated).map(|place| (repeated, Some(place))));
    }
    all
}

/// What all ribbons of a file share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RibbonKind {
    /// Length of a cell, mm; 0: a ribbon is one.
    pub cell_mm: f32,
    /// Slope of its arches, rad.
    pub swelling: f32,
    /// Whether names of places come with those of ribbons.
    pub is_placed: bool,
}

impl RibbonKind {
    fn of(ribbon: &Ribbon, place: Option<Place>) -> Self {
        Self { cell_mm: ribbon.cell, swelling: ribbon.swelling, is_placed: place.is_some() }
    }

    /// Every kind that stands there.
    pub(super) fn all(stands: &Stands<'_>) -> Vec<Self> {
        let mut kinds: Vec<Self> = Vec::new();
        for (geometry, place) in stands {
            for kind in geometry.ribbons.iter().map(|ribbon| Self::of(ribbon, *place)) {
                if !kinds.contains(&kind) {
                    kinds.push(kind);
                }
            }
        }
        kinds
    }
}

/// Columns of a vertex of a ribbon: place, normal, texture coordinates, the frame's axes as they are interpolated, half the width.
const RIBBON_COLUMNS: [&str; 15] = [
    "x", "y", "z", "nx", "ny", "nz", "u", "v", "along_0", "along_1", "along_2", "across_0", "across_1",
    "across_2", "half_0",
];

/// The ribbons of a kind. u counts cells from the ribbon's base; where it is one cell, u stays within 0 and 1. v is −1 … 1 across.
pub(super) fn ribbons(stands: &Stands<'_>, kind: RibbonKind) -> Vec<u8> {
    let mut ply = Ply::default();
    for (geometry, place) in stands {
        for ribbon in geometry.ribbons.iter().filter(|ribbon| RibbonKind::of(ribbon, *place) == kind) {
            ply.ribbon(geometry, ribbon, place.as_ref());
        }
    }
    let names: &[&str] = if kind.is_placed {
        &["inst_0", "inst_1", "inst_2", "place_0", "place_1", "place_2"]
    } else {
        &["inst_0", "inst_1", "inst_2"]
    };
    ply.encoded(&RIBBON_COLUMNS, names)
}

/// Which columns a mesh has beside places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MeshKind {
    /// Normals of its vertices; else faces are flat.
    pub is_smooth: bool,
    /// Texture coordinates.
    pub has_uv: bool,
}

impl MeshKind {
    fn of(mesh: &Mesh) -> Self {
        Self { is_smooth: !mesh.normals.is_empty(), has_uv: !mesh.uvs.is_empty() }
    }

    /// Every kind that stands there.
    pub(super) fn all(stands: &Stands<'_>) -> Vec<Self> {
        let mut kinds: Vec<Self> = Vec::new();
        let meshes = stands.iter().flat_map(|(geometry, _)| &geometry.meshes);
        for kind in meshes.filter(|mesh| !mesh.triangles.is_empty()).map(Self::of) {
            if !kinds.contains(&kind) {
                kinds.push(kind);
            }
        }
        kinds
    }
}

/// The meshes of a kind as one.
pub(super) fn meshes(stands: &Stands<'_>, kind: MeshKind) -> Vec<u8> {
    let mut ply = Ply::default();
    for (geometry, place) in stands {
        for mesh in geometry.meshes.iter().filter(|mesh| MeshKind::of(mesh) == kind) {
            ply.mesh(mesh, place.as_ref());
        }
    }
    let columns = [
        &["x", "y", "z"][..],
        if kind.is_smooth { &["nx", "ny", "nz"] } else { &[] },
        if kind.has_uv { &["u", "v"] } else { &[] },
    ];
    ply.encoded(&columns.concat(), &[])
}

/// Round linear curves: x, y, z and the radius of their points.
pub(super) fn curves(stands: &Stands<'_>) -> Vec<Vec<[f32; 4]>> {
    let moved = |node: &CurveNode, place: Option<&Place>| {
        let Vec3 { x, y, z } = point(node.point, place);
        [x, y, z, (f64::from(node.radius) * place.map_or(1.0, |place| place.scale)) as f32]
    };
    let all = stands.iter().flat_map(|(geometry, place)| {
        let nodes = |curve| geometry.nodes_of_curve(curve).iter().map(|node| moved(node, place.as_ref()));
        geometry.curves.iter().map(move |curve| nodes(curve).collect::<Vec<_>>()).collect::<Vec<_>>()
    });
    all.collect()
}

/// The file of round curves that Mitsuba reads: "x y z radius" a line, and an empty line after each curve.
pub(super) fn curves_text(curves: &[Vec<[f32; 4]>]) -> Vec<u8> {
    let mut text = String::new();
    for curve in curves {
        for [x, y, z, radius] in curve {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{x} {y} {z} {radius}");
        }
        text.push('\n');
    }
    text.into_bytes()
}

fn point(at: Vec3, place: Option<&Place>) -> Vec3 {
    place.map_or(at, |place| place.point(at.as_dvec3()).as_vec3())
}

fn direction(v: Vec3, place: Option<&Place>) -> Vec3 {
    place.map_or(v, |place| place.direction(v.as_dvec3()).as_vec3())
}

/// A name in numbers that single precision holds: its lowest 22 bits, the next 22 and the last 20.
fn name_parts(name: u64) -> [f32; 3] {
    let low = (1 << 22) - 1;
    [name & low, name >> 22 & low, name >> 44].map(|part| part as f32)
}

/// A mesh in the making: rows of numbers, and triangles with the numbers of their faces.
#[derive(Default)]
struct Ply {
    vertices: Vec<f32>,
    count: u32,
    triangles: Vec<([u32; 3], u32)>,
    /// Numbers of faces, each row for as many triangles as name it.
    names: Vec<Vec<f32>>,
}

impl Ply {
    fn ribbon(&mut self, geometry: &Geometry, ribbon: &Ribbon, place: Option<&Place>) {
        let nodes = geometry.nodes_of(ribbon);
        let last = nodes.len() - 2;
        let (from, length) = (nodes[0].arc, (nodes[last + 1].arc - nodes[0].arc).max(f32::MIN_POSITIVE));
        let first = self.count;
        for (i, node) in nodes.iter().enumerate() {
            let u = if ribbon.cell > 0.0 {
                (f64::from(node.arc) / f64::from(ribbon.cell) + f64::from(ribbon.phase)) as f32
            } else {
                0.25 + 0.5 * (node.arc - from) / length
            };
            let (along, across) = (RibbonNode::tangent(nodes, i), node.across.normalize_or(Vec3::X));
            let normal = across.cross(along).normalize_or(Vec3::Z);
            for side in [-1.0, 1.0] {
                self.vertices.extend(point(node.point + node.across * side, place).to_array());
                self.vertices.extend(direction(normal, place).to_array());
                self.vertices.extend([u, side]);
                self.vertices.extend(direction(along, place).to_array());
                self.vertices.extend(direction(across, place).to_array());
                self.vertices.push(node.across.length());
            }
            self.count += 2;
        }
        // Cells are named within the object first, and then by its place.
        let mut names = name_parts(ribbon.id).to_vec();
        names.extend(place.iter().flat_map(|place| name_parts(place.id)));
        let names = self.face_names(names);
        for i in 0..=last as u32 {
            let [a, b, c, d] = [0, 1, 2, 3].map(|corner| first + 2 * i + corner);
            self.triangles.extend([([a, b, d], names), ([a, d, c], names)]);
        }
    }

    fn mesh(&mut self, mesh: &Mesh, place: Option<&Place>) {
        let first = self.count;
        for (i, at) in mesh.positions.iter().enumerate() {
            self.vertices.extend(point(*at, place).to_array());
            if let Some(normal) = mesh.normals.get(i) {
                self.vertices.extend(direction(*normal, place).to_array());
            }
            if let Some(Vec2 { x, y }) = mesh.uvs.get(i) {
                self.vertices.extend([x, y]);
            }
        }
        self.count += mesh.positions.len() as u32;
        let names = self.face_names(Vec::new());
        self.triangles.extend(mesh.triangles.iter().map(|t| (t.map(|corner| first + corner), names)));
    }

    fn face_names(&mut self, names: Vec<f32>) -> u32 {
        self.names.push(names);
        self.names.len() as u32 - 1
    }

    /// The file, with these columns of vertices and of faces.
    fn encoded(&self, columns: &[&str], names: &[&str]) -> Vec<u8> {
        let properties = |columns: &[&str]| -> String {
            columns.iter().map(|name| format!("property float {name}\n")).collect()
        };
        let header = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\n{}element face {}\nproperty list uchar int vertex_indices\n{}end_header\n",
            self.count,
            properties(columns),
            self.triangles.len(),
            properties(names)
        );
        let mut bytes = header.into_bytes();
        bytes.reserve(4 * self.vertices.len() + (13 + 4 * names.len()) * self.triangles.len());
        bytes.extend(self.vertices.iter().flat_map(|value| value.to_le_bytes()));
        for (corners, row) in &self.triangles {
            bytes.push(3);
            bytes.extend(corners.iter().flat_map(|corner| corner.to_le_bytes()));
            bytes.extend(self.names[*row as usize].iter().flat_map(|value| value.to_le_bytes()));
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ribbon() -> Geometry {
        let mut geometry = Geometry::default();
        let node = |y: f32| RibbonNode { point: Vec3::new(0.0, y, 0.0), across: Vec3::X * 0.01, arc: y };
        let kind = Ribbon { id: 0xfedc_ba98_7654_3210, cell: 0.05, phase: 0.25, ..Ribbon::default() };
        geometry.add_ribbon(&[node(0.0), node(0.1), node(0.2)], kind);
        geometry
    }

    /// Numbers of a vertex and of a face, by their row.
    fn rows(bytes: &[u8], columns: usize, vertices: usize, names: usize) -> (Vec<Vec<f32>>, Vec<Vec<f32>>) {
        let at = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        let single = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().unwrap());
        let body = &bytes[at..];
        let row = |bytes: &[u8]| bytes.chunks_exact(4).map(single).collect::<Vec<f32>>();
        let (vertex, face) = body.split_at(4 * columns * vertices);
        let faces = face.chunks_exact(13 + 4 * names).map(|face| row(&face[13..])).collect();
        (vertex.chunks_exact(4 * columns).map(row).collect(), faces)
    }

    #[test]
    fn ribbons_carry_cells_names_and_frames() {
        let geometry = ribbon();
        let stands = stands(&geometry);
        let kinds = RibbonKind::all(&stands);
        assert_eq!(kinds.len(), 1);
        let (vertices, faces) = rows(&ribbons(&stands, kinds[0]), 15, 6, 3);
        assert_eq!(vertices[0][..3], [-0.01, 0.0, 0.0]);
        assert_eq!(vertices[5][..3], [0.01, 0.2, 0.0]);
        assert_eq!(vertices[3][3..6], [0.0, 0.0, 1.0]);
        assert!((vertices[4][6] - 4.25).abs() < 1e-6 && vertices[4][7] == -1.0);
        assert_eq!(faces.len(), 4);
        let name = faces[2][0] as u64 | (faces[2][1] as u64) << 22 | (faces[2][2] as u64) << 44;
        assert_eq!(name, 0xfedc_ba98_7654_3210);
    }

    #[test]
    fn placed_ribbons_are_moved_and_name_their_place() {
        let place = Place { scale: 2.0, shift: glam::DVec3::Z, id: 77, ..Place::HERE };
        let geometry = Geometry { places: vec![place; 3], ..ribbon() };
        let stands = stands(&geometry);
        let kind = RibbonKind::all(&stands)[0];
        let (vertices, faces) = rows(&ribbons(&stands, kind), 15, 18, 6);
        assert_eq!(vertices[7][..3], [0.02, 0.0, 1.0]);
        // Half the width is the ribbon's own.
        assert_eq!(vertices[7][14], 0.01);
        assert_eq!((faces.len(), faces[0][3]), (12, 77.0));
    }
}
