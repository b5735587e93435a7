//! A sphere of a film in glTF 2.0.

use std::f64::consts::{PI, TAU};

use base64::prelude::{BASE64_STANDARD, Engine as _};
use serde_json::{Map, Value, json};

use super::OneFilm;
use crate::{Error, Result};

/// Steps around the sphere and from pole to pole.
const AROUND: usize = 96;
const DOWN: usize = 48;

/// The file, its buffer embedded: a sphere of 1 cm, since formats of scenes have no bare materials.
pub(super) fn encoded(film: &OneFilm, name: &str, notes: &[(&str, &str)]) -> Result<Vec<u8>> {
    let (points, corners) = sphere();
    // Points of a unit sphere are its normals too.
    let mut buffer: Vec<u8> = points.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    let points_length = buffer.len();
    buffer.extend(corners.iter().flat_map(|corner| corner.to_le_bytes()));
    let extras: Map<String, Value> =
        notes.iter().map(|(name, text)| ((*name).to_owned(), (*text).into())).collect();
    let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&buffer));
    let mut extensions = json!({
        "KHR_materials_iridescence": {
            "iridescenceFactor": 1.0,
            "iridescenceIor": film.index,
            "iridescenceThicknessMaximum": film.thickness_nm,
        },
        "KHR_materials_ior": {"ior": film.base_index},
    });
    let mut used = vec!["KHR_materials_iridescence", "KHR_materials_ior"];
    if film.is_clear {
        extensions["KHR_materials_transmission"] = json!({"transmissionFactor": 1.0});
        used.push("KHR_materials_transmission");
    }
    // What an opaque base lets in, it absorbs.
    let base = if film.is_clear { [1.0; 4] } else { [0.0, 0.0, 0.0, 1.0] };
    let document = json!({
        "asset": {"version": "2.0", "generator": "barbule", "extras": extras},
        "extensionsUsed": used,
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": name, "mesh": 0, "scale": [0.01, 0.01, 0.01]}],
        "meshes": [{"name": name, "primitives": [
            {"attributes": {"POSITION": 0, "NORMAL": 0}, "indices": 1, "material": 0}
        ]}],
        "materials": [{
            "name": name,
            "doubleSided": film.is_clear,
            "pbrMetallicRoughness": {"baseColorFactor": base, "metallicFactor": 0.0, "roughnessFactor": 0.0},
            "extensions": extensions,
        }],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": points.len(), "type": "VEC3",
             "min": [-1.0, -1.0, -1.0], "max": [1.0, 1.0, 1.0]},
            {"bufferView": 1, "componentType": 5125, "count": corners.len(), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": points_length, "target": 34962},
            {"buffer": 0, "byteOffset": points_length, "byteLength": buffer.len() - points_length, "target": 34963},
        ],
        "buffers": [{"byteLength": buffer.len(), "uri": uri}],
    });
    serde_json::to_vec(&document).map_err(|error| Error::machine(format!("no glTF: {error}")))
}

/// Points of a unit sphere, the poles along y, and corners of its triangles, anticlockwise from outside.
fn sphere() -> (Vec<[f32; 3]>, Vec<u32>) {
    let point = |row: usize, column: usize| {
        let (polar, turn) = (PI * row as f64 / DOWN as f64, TAU * (column % AROUND) as f64 / AROUND as f64);
        let sine = if row == 0 || row == DOWN { 0.0 } else { libm::sin(polar) };
        [sine * libm::sin(turn), libm::cos(polar), sine * libm::cos(turn)].map(|v| v as f32)
    };
    let points = (0..=DOWN).flat_map(|row| (0..AROUND).map(move |column| point(row, column))).collect();
    let at = |row: usize, column: usize| (row * AROUND + column % AROUND) as u32;
    let mut corners = Vec::with_capacity(6 * AROUND * (DOWN - 1));
    for row in 0..DOWN {
        for column in 0..AROUND {
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            if row > 0 {
                corners.extend([a, c, b]);
            }
            if row + 1 < DOWN {
                corners.extend([b, c, d]);
            }
        }
    }
    (points, corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Its faces look outwards and are together nearly a sphere's.
    #[test]
    fn the_sphere_is_closed_and_looks_outwards() {
        let (points, corners) = sphere();
        let at = |k: u32| glam::Vec3::from_array(points[k as usize]).as_dvec3();
        let mut area = 0.0;
        for triangle in corners.chunks(3) {
            let [a, b, c] = [at(triangle[0]), at(triangle[1]), at(triangle[2])];
            let normal = (b - a).cross(c - a);
            assert!(normal.dot(a + b + c) > 0.0);
            area += 0.5 * normal.length();
        }
        assert!((area / (4.0 * PI) - 1.0).abs() < 3e-3, "{area}");
        let range = |c: usize| points.iter().map(|p| p[c]).fold(0.0_f32, |most, v| most.max(v.abs()));
        assert!((0..3).all(|c| range(c) <= 1.0));
    }
}
