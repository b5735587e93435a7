//! Triangle meshes: PLY, OBJ and glTF.

mod gltf;
mod obj;
mod ply;

use std::path::Path;

use glam::{Vec2, Vec3};
pub(super) use gltf::{chunks, local};

use super::assets::{Assets, Folder, ending};
use super::whole::folder_of;
use crate::scene::geometry::Mesh;
use crate::{Error, Result};

/// The largest file of a mesh: 256 MiB.
pub(super) const LARGEST_MESH: u64 = 256 << 20;

/// Most vertices, and most faces.
const MOST_VERTICES: usize = 5_000_000;

/// Reads a mesh, `.ply` or `.obj` in mm, `.gltf` or `.glb` in m; polygons become fans of triangles. Give it an identity of its own.
/// Also gives BLAKE3 of what was read: the file, then glTF's buffers in files of their own.
///
/// # Errors
/// Missing, over 256 MiB, of another kind, damaged, or without a triangle.
pub fn read_mesh(path: &Path) -> Result<(Mesh, String)> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    decode_mesh(&name, &Folder(folder_of(path).to_path_buf()))
}

/// Reads a mesh and what it names from where a scene's files are; see [`read_mesh`].
///
/// # Errors
/// As there.
pub fn decode_mesh(name: &str, assets: &dyn Assets) -> Result<(Mesh, String)> {
    let place = assets.place(name);
    let refuse = |error: Error| error.in_file(Path::new(&place));
    let read: Reader = match ending(name).as_str() {
        "ply" => |bytes, _| ply::read(bytes).map(Found::from),
        "obj" => |bytes, _| obj::read(&String::from_utf8_lossy(bytes)).map(Found::from),
        "gltf" | "glb" => gltf::read,
        _ => return Err(refuse(Error::input("meshes are read from .ply, .obj, .gltf or .glb"))),
    };
    let bytes = assets.read(name, LARGEST_MESH)?;
    // Names in a file are as seen from it.
    let beside = |other: &str, largest: u64| {
        let other = Path::new(name).with_file_name(other);
        assets.read(&other.to_string_lossy(), largest)
    };
    let Found { parts, beside } = read(&bytes, &beside).map_err(refuse)?;
    let mut hasher = blake3::Hasher::new();
    hasher.update(&bytes);
    beside.iter().for_each(|bytes| _ = hasher.update(bytes));
    Ok((parts.finish().map_err(refuse)?, hasher.finalize().to_hex().to_string()))
}

/// How many vertices and triangles a mesh says that it has, by the ending of its name, its first bytes and its length; `None` where
/// its kind of file does not say so at its beginning.
#[must_use]
pub fn foretell_mesh(name: &str, head: &[u8], length: u64) -> Option<[f64; 2]> {
    if ending(name) == "ply" { ply::foretell(head, length) } else { None }
}

/// Reads a mesh from a file's bytes, and what it names beside it by name and greatest size.
type Reader = fn(&[u8], &dyn Fn(&str, u64) -> Result<Vec<u8>>) -> Result<Found>;

/// What a file holds of shapes.
struct Found {
    parts: Parts,
    /// What it names that lies in files of its own.
    beside: Vec<Vec<u8>>,
}

impl From<Parts> for Found {
    fn from(parts: Parts) -> Self {
        Self { parts, beside: Vec::new() }
    }
}

/// A mesh that is being read.
#[derive(Debug, Default)]
struct Parts {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
}

impl Parts {
    /// Adds a polygon as a fan; what has fewer than three corners is left out.
    fn add_polygon(&mut self, corners: &[u32]) -> Result<()> {
        for pair in corners.get(1..).unwrap_or_default().windows(2) {
            self.triangles.push([corners[0], pair[0], pair[1]]);
        }
        if self.triangles.len() > MOST_VERTICES {
            return Err(Error::input(format!("has over {MOST_VERTICES} triangles")));
        }
        Ok(())
    }

    /// The mesh, checked. Normals are made unit; where one is zero nobody has any.
    fn finish(self) -> Result<Mesh> {
        let Self { positions, normals, uvs, triangles } = self;
        if triangles.is_empty() {
            return Err(Error::input("has no triangle"));
        }
        if triangles.iter().flatten().any(|corner| *corner as usize >= positions.len()) {
            return Err(Error::input("has a face with a corner that does not exist"));
        }
        // Farther away than a kilometre single precision is no use.
        let numbers =
            || positions.iter().flat_map(|p| p.to_array()).chain(uvs.iter().flat_map(|uv| uv.to_array()));
        if numbers().any(|v| !v.is_finite() || v.abs() > 1e6) {
            return Err(Error::input("has a coordinate that is not finite or over 1000000"));
        }
        let units: Vec<Vec3> = normals.into_iter().map(unit).collect();
        let normals = if units.contains(&Vec3::ZERO) { Vec::new() } else { units };
        Ok(Mesh { positions, normals, uvs, triangles, ..Mesh::default() })
    }
}

/// A normal of length 1; zero where it has no direction. In single precision the squares of very short ones lose their digits.
fn unit(normal: Vec3) -> Vec3 {
    if (1e-20..1e20).contains(&normal.length_squared()) {
        normal.normalize()
    } else {
        normal.as_dvec3().normalize_or_zero().as_vec3()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLY: &str = "ply\nformat ascii 1.0\ncomment a roof\nelement vertex 5\nproperty float x\nproperty float y\n\
                       property double z\nproperty float u\nproperty float v\nelement face 2\n\
                       property list uchar int vertex_indices\nend_header\n\
                       0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n0.5 0.5 1 0.5 0.5\n4 0 1 2 3\n3 0 1 4\n";
    const OBJ: &str = "# a roof\nmtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1\nvt 0 0\nvt 1 0\nvt 1 1\n\
                       vt 0 1\nvt 0.5 0.5\ng roof\nf 1/1 2/2 3/3 4/4\nf -5/-5 2/2 5/5\n";

    #[test]
    fn normals_of_any_length_are_made_unit() {
        for length in [1e-38_f32, 1e-22, 1e-3, 1.0, 1e25, 3e38] {
            let made = unit(Vec3::new(0.6, 0.0, -0.8) * length);
            assert!(made.distance(Vec3::new(0.6, 0.0, -0.8)) < 1e-6, "{length}: {made}");
        }
        assert_eq!(unit(Vec3::ZERO), Vec3::ZERO);
        assert_eq!(unit(Vec3::splat(f32::NAN)), Vec3::ZERO);
    }

    fn read(name: &str, bytes: &[u8]) -> Result<Mesh> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let (mesh, content) = read_mesh(&path)?;
        assert_eq!(content, super::super::hash_bytes(bytes));
        Ok(mesh)
    }

    /// The same mesh in binary, of either order.
    fn binary(is_big: bool) -> Vec<u8> {
        let order = if is_big { "big" } else { "little" };
        let (head, _) = PLY.split_once("end_header\n").unwrap();
        let mut bytes =
            format!("{}end_header\n", head.replace("ascii", &format!("binary_{order}_endian"))).into_bytes();
        let mut put = |value: &[u8]| {
            let mut value = value.to_vec();
            if is_big {
                value.reverse();
            }
            bytes.extend(value);
        };
        for [x, y, z] in
            [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, 1.0]]
        {
            put(&x.to_le_bytes());
            put(&y.to_le_bytes());
            put(&f64::from(z).to_le_bytes());
            put(&x.to_le_bytes());
            put(&y.to_le_bytes());
        }
        for face in [&[0_i32, 1, 2, 3][..], &[0, 1, 4]] {
            put(&[face.len() as u8]);
            face.iter().for_each(|corner| put(&corner.to_le_bytes()));
        }
        bytes
    }

    #[test]
    fn the_same_mesh_comes_from_every_kind_of_file() {
        let text = read("a.ply", PLY.as_bytes()).unwrap();
        assert_eq!((text.positions.len(), text.triangles.len(), text.uvs.len()), (5, 3, 5));
        assert_eq!(text.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 4]]);
        for other in
            [read("a.ply", &binary(false)), read("a.PLY", &binary(true)), read("a.obj", OBJ.as_bytes())]
        {
            let other = other.unwrap();
            assert_eq!((&other.positions, &other.triangles), (&text.positions, &text.triangles));
            assert_eq!(other.uvs, text.uvs);
        }
    }

    #[test]
    fn the_header_of_a_ply_says_what_it_holds() {
        let foretold = |bytes: &[u8]| foretell_mesh("a.ply", bytes, bytes.len() as u64);
        // Two faces of which one has four corners: text does not say so at its beginning.
        assert_eq!(foretold(PLY.as_bytes()), Some([5.0, 2.0]));
        assert_eq!(foretold(&binary(false)), Some([5.0, 3.0]));
        let many = PLY.replace("face 2", "face 99999999999");
        assert_eq!(foretold(many.as_bytes()).map(|[_, faces]| faces), Some(many.len() as f64));
        assert_eq!((foretold(b"ply\nform"), foretell_mesh("a.obj", b"v 1", 3)), (None, None));
    }

    #[test]
    fn damaged_meshes_are_refused_with_their_name() {
        let message = |name: &str, text: &str| {
            let message = read(name, text.as_bytes()).unwrap_err().to_string();
            assert!(message.contains(name) && message.len() < 500, "{message}");
            message
        };
        let changed = |from: &str, to: &str| message("a.ply", &PLY.replacen(from, to, 1));
        assert!(changed("ply\n", "").contains("first line"));
        assert!(changed("ascii", "utf16").contains("'utf16' is unknown"));
        assert!(changed("vertex 5", "vertex 99999999999999").contains("more than the file can hold"));
        assert!(changed("vertex 5", "vertex -1").contains("count is no number"));
        assert!(changed("float x", "float w").contains("x, y and z"));
        assert!(changed("double z", "quadruple z").contains("'quadruple'"));
        assert!(changed("4 0 1 2 3", "4 0 1 2 9").contains("does not exist"));
        assert!(changed("4 0 1 2 3", "4 0 1 2 -3").contains("negative corner"));
        assert!(changed("4 0 1 2 3", "4000 0 1 2 3").contains("at most 256"));
        assert!(changed("0.5 0.5 1", "0.5 inf 1").contains("not finite"));
        assert!(changed("0.5 0.5 1", "0.5 x 1").contains("'x'"));
        assert!(changed("vertex_indices", "corners").contains("vertex_indices"));
        assert!(
            message("a.obj", &OBJ.replace("5/5", "6/5")).contains("line 15: the corner '6/5' does not exist")
        );
        assert!(message("a.obj", "v 1 2\n").contains("3 numbers"));
        assert!(message("a.obj", "f a b c\n").contains("no corner of a face"));
        assert!(message("a.obj", "").contains("no triangle"));
        assert!(message("a.stl", PLY).contains(".ply, .obj, .gltf or .glb"));
        let whole = binary(false);
        for cut in 0..whole.len() {
            assert!(read("a.ply", &whole[..cut]).is_err(), "{cut}");
        }
    }
}
