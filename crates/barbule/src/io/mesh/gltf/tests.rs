use serde_json::{Value, json};

use super::super::read_mesh;
use super::*;
use crate::scene::geometry::Mesh;

/// A square of 1 m, its corners' texture coordinates and normals, and six indices of two bytes.
fn buffer() -> Vec<u8> {
    let mut bytes = Vec::new();
    let corners = [[0.0_f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    for [x, y] in corners {
        bytes.extend([x, y, 0.0].iter().flat_map(|v| v.to_le_bytes()));
    }
    for [u, v] in corners {
        bytes.extend([u, 1.0 - v].iter().flat_map(|v| v.to_le_bytes()));
    }
    (0..4).for_each(|_| bytes.extend([0.0_f32, 0.0, 1.0].iter().flat_map(|v| v.to_le_bytes())));
    bytes.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

fn base64(bytes: &[u8]) -> String {
    READ_BASE64.encode(bytes)
}

/// A file of the square, once.
fn square() -> Value {
    json!({
        "asset": {"version": "2.0", "generator": "a hand"},
        "scene": 0,
        "scenes": [{"name": "all", "nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "materials": [{"name": "passed over"}],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "TEXCOORD_0": 1, "NORMAL": 2, "COLOR_0": 7},
            "indices": 3, "material": 0,
        }]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 0, "byteOffset": 48, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 0, "byteOffset": 80, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 128}, {"buffer": 0, "byteOffset": 128, "byteLength": 12}],
        "buffers": [{"byteLength": 140, "uri": format!("data:application/octet-stream;base64,{}", base64(&buffer()))}],
    })
}

/// The same in a binary file.
fn binary() -> Vec<u8> {
    let mut document = square();
    document["buffers"][0] = json!({"byteLength": 140});
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let data = buffer();
    let mut bytes = b"glTF".to_vec();
    for word in [2, (12 + 8 + text.len() + 8 + data.len()) as u32, text.len() as u32, JSON] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(&text);
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(BINARY.to_le_bytes());
    bytes.extend(&data);
    bytes
}

fn read_file(name: &str, bytes: &[u8]) -> Result<(Mesh, String)> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::create_dir(folder.path().join("parts")).unwrap();
    std::fs::write(folder.path().join("parts/a b.bin"), buffer()).unwrap();
    std::fs::write(&path, bytes).unwrap();
    read_mesh(&path)
}

fn read_document(document: &Value) -> Result<Mesh> {
    read_file("a.gltf", document.to_string().as_bytes()).map(|(mesh, _)| mesh)
}

#[test]
fn the_same_mesh_comes_embedded_beside_and_in_binary() {
    let embedded = read_document(&square()).unwrap();
    assert_eq!(embedded.positions[2], Vec3::new(1000.0, 1000.0, 0.0));
    assert_eq!(embedded.uvs, [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]);
    assert_eq!(embedded.normals, [Vec3::Z; 4]);
    assert_eq!(embedded.triangles, [[0, 1, 2], [0, 2, 3]]);
    let mut library = square();
    library["nodes"] = json!([{"mesh": 0}, {"children": [0]}]);
    library.as_object_mut().unwrap().retain(|key, _| !key.starts_with("scene"));
    assert_eq!(read_document(&library).unwrap(), embedded);
    let (whole, _) = read_file("a.GLB", &binary()).unwrap();
    assert_eq!(whole, embedded);
    let mut apart = square();
    apart["buffers"][0]["uri"] = "parts/a%20b.bin".into();
    let (beside, content) = read_file("a.gltf", apart.to_string().as_bytes()).unwrap();
    assert_eq!(beside, embedded);
    let both = [apart.to_string().as_bytes(), &buffer()].concat();
    assert_eq!(content, crate::io::hash_bytes(&both));
    for length in 0..7 {
        let bytes = &buffer()[40..40 + length];
        assert_eq!(decoded(&format!(";base64,{}", base64(bytes))).unwrap(), bytes);
    }
}

/// Scaled, turned, moved, from the leaf to the root; a mirrored node keeps its outside.
#[test]
fn nodes_place_their_meshes() {
    let mut document = square();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    document["nodes"] = json!([
        {"children": [1, 2], "translation": [0, 0, 5]},
        // A quarter turn about z after doubling x.
        {"mesh": 0, "scale": [2, 1, 1], "rotation": [0, 0, half, half]},
        {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 0, 0, 1]},
    ]);
    let mesh = read_document(&document).unwrap();
    assert!((mesh.positions[1] - Vec3::new(0.0, 2000.0, 5000.0)).length() < 1e-2);
    assert!((mesh.positions[5] - Vec3::new(6000.0, 0.0, 5000.0)).length() < 1e-2);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]]);
    for [a, b, c] in &mesh.triangles {
        let [a, b, c] = [a, b, c].map(|k| mesh.positions[*k as usize]);
        assert!((b - a).cross(c - a).z > 0.0);
    }
    assert!(mesh.normals.iter().all(|n| (*n - Vec3::Z).length() < 1e-6));
    // Normals of 45° in x lean less where x is stretched.
    let mut leaning = buffer();
    for k in 0..4 {
        leaning[80 + 12 * k..84 + 12 * k].copy_from_slice(&1.0_f32.to_le_bytes());
    }
    document["buffers"][0]["uri"] = format!("data:;base64,{}", base64(&leaning)).into();
    document["nodes"] = json!([{"mesh": 0, "scale": [3, 1, 1]}]);
    let normal = read_document(&document).unwrap().normals[0];
    assert!((normal - Vec3::new(1.0, 0.0, 3.0).normalize()).length() < 1e-6, "{normal}");
}

#[test]
fn strips_fans_and_bare_corners_are_triangles() {
    let triangles = |mode: u32, indices: bool| {
        let mut document = square();
        let primitive = &mut document["meshes"][0]["primitives"][0];
        primitive["mode"] = mode.into();
        if !indices {
            primitive.as_object_mut().unwrap().remove("indices");
        }
        read_document(&document).map(|mesh| mesh.triangles)
    };
    assert_eq!(triangles(STRIP, false).unwrap(), [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(triangles(FAN, false).unwrap(), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(triangles(TRIANGLES, false).unwrap(), [[0, 1, 2]]);
    assert!(triangles(1, true).unwrap_err().to_string().contains("has no triangle"));
    for (code, bytes, normalized, expected) in
        [(5121, &[255_u8][..], true, 1.0), (5120, &[0x81], true, -1.0), (5122, &[0xfe, 0xff], false, -2.0)]
    {
        assert_eq!(Number::of(code).unwrap().value(bytes, normalized), expected);
    }
}

#[test]
fn damaged_files_are_refused_with_what_is_wrong() {
    let refused = |change: &dyn Fn(&mut Value)| {
        let mut document = square();
        change(&mut document);
        let message = read_document(&document).unwrap_err().to_string();
        assert!(message.contains("a.gltf") && message.len() < 500, "{message}");
        message
    };
    assert!(refused(&|d| d["asset"]["version"] = "1.0".into()).contains("version 1.0; 2.0 is read"));
    assert!(refused(&|d| d["scene"] = 4.into()).contains("names scene 4, but has 1"));
    assert!(refused(&|d| d["nodes"][0]["children"] = json!([0])).contains("node 0 in two places"));
    assert!(refused(&|d| d["nodes"][0]["mesh"] = 3.into()).contains("names mesh 3, but has 1"));
    assert!(refused(&|d| d["nodes"][0]["scale"] = json!([1e9, 1, 1])).contains("over 1000000"));
    assert!(
        refused(&|d| d["accessors"][0]["count"] = 9_000_000_000_u64.into())
            .contains("larger than its buffer")
    );
    assert!(refused(&|d| d["accessors"][0]["count"] = u64::MAX.into()).contains("larger than its buffer"));
    assert!(refused(&|d| d["accessors"][0]["byteOffset"] = u64::MAX.into()).contains("outside its buffer"));
    assert!(refused(&|d| d["accessors"][0]["componentType"] = 1.into()).contains("of no known kind"));
    assert!(refused(&|d| d["accessors"][0]["sparse"] = json!({})).contains("is sparse"));
    assert!(refused(&|d| d["accessors"][0]["type"] = "MAT4".into()).contains("kind 'MAT4'"));
    assert!(refused(&|d| d["bufferViews"][0]["byteStride"] = 4.into()).contains("larger than its buffer"));
    assert!(refused(&|d| d["bufferViews"][0]["byteLength"] = 999.into()).contains("outside its buffer"));
    assert!(refused(&|d| d["bufferViews"][1]["byteOffset"] = 12.into()).contains("corner 16256 of 4"));
    assert!(
        refused(&|d| d["buffers"][0]["byteLength"] = 141.into()).contains("141 bytes, but there are 140")
    );
    assert!(refused(&|d| d["buffers"][0]["uri"] = "data:;base64,a_b".into()).contains("no base64"));
    assert!(refused(&|d| d["buffers"][0] = json!({"byteLength": 1})).contains("no data of buffer 0"));
    assert!(refused(&|d| d["buffers"][0]["uri"] = "none.bin".into()).contains("no such file"));
    for uri in ["../a.bin", "/etc/passwd", "%2e%2e/a.bin", "https://a/b.bin", "", "a%zz", "%e2%82"] {
        assert!(refused(&|d| d["buffers"][0]["uri"] = uri.into()).contains("files in its folder"), "{uri}");
    }
    assert!(refused(&|d| d["nodes"] = vec![json!({}); 100_001].into()).contains("over 100000 entries"));
    assert!(
        refused(&|d| d["extensionsRequired"] = json!(["KHR_texture_transform", "KHR_draco_mesh_compression"]))
            .contains("'KHR_draco_mesh_compression'")
    );
    assert!(
        read_file("a.gltf", b"{}").unwrap_err().to_string().contains("is no glTF: missing field `asset`")
    );
    let whole = binary();
    for cut in 0..whole.len() {
        assert!(read_file("a.glb", &whole[..cut]).is_err(), "{cut}");
    }
    for at in 0..28 {
        let mut changed = whole.clone();
        changed[at] ^= 0xff;
        assert!(read_file("a.glb", &changed).is_err(), "{at}");
    }
}
