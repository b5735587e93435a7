//! PLY, OBJ, USD, pbrt and curve files.
//!
//! Writing to a String cannot fail, so what `write!` returns is dropped.

use std::fmt::Write as _;

use glam::Vec3;

use super::UsdLook;
use super::parts::Part;
use crate::io::curves_text;
use crate::scene::feather::Grown;
use crate::scene::geometry::CurveNode;

/// Numbers of a line of text.
fn numbers(text: &mut String, values: impl IntoIterator<Item = Vec3>) {
    for v in values {
        let _ = write!(text, " {} {} {}", v.x, v.y, v.z);
    }
}

fn comments(text: &mut String, mark: &str, notes: &[(&str, &str)]) {
    for (name, note) in notes {
        let _ = writeln!(text, "{mark} {name}: {}", note.replace(['\n', '\r'], " "));
    }
}

/// PLY, binary little endian: corners with normals, then triangles; the parts follow each other as comments say.
pub(super) fn ply(parts: &[Part], notes: &[(&str, &str)]) -> Vec<u8> {
    let corners: usize = parts.iter().map(|part| part.positions.len()).sum();
    let triangles: usize = parts.iter().map(|part| part.triangles.len()).sum();
    let mut header = "ply\nformat binary_little_endian 1.0\n".to_owned();
    comments(&mut header, "comment", notes);
    for part in parts {
        let _ = writeln!(header, "comment {}: {} triangles", part.name, part.triangles.len());
    }
    let _ = writeln!(header, "element vertex {corners}");
    for name in ["x", "y", "z", "nx", "ny", "nz"] {
        let _ = writeln!(header, "property float {name}");
    }
    let _ = writeln!(header, "element face {triangles}\nproperty list uchar uint vertex_indices\nend_header");
    let mut bytes = header.into_bytes();
    bytes.reserve(24 * corners + 13 * triangles);
    for part in parts {
        for (position, normal) in part.positions.iter().zip(&part.normals) {
            let values = position.to_array().into_iter().chain(normal.to_array());
            bytes.extend(values.flat_map(f32::to_le_bytes));
        }
    }
    let mut first = 0;
    for part in parts {
        for corners in &part.triangles {
            bytes.push(3);
            bytes.extend(corners.iter().flat_map(|corner| (first + corner).to_le_bytes()));
        }
        first += part.positions.len() as u32;
    }
    bytes
}

/// OBJ: an object a part.
pub(super) fn obj(parts: &[Part], notes: &[(&str, &str)]) -> Vec<u8> {
    let mut text = String::new();
    comments(&mut text, "#", notes);
    // Corners are counted from 1.
    let mut first = 1;
    for part in parts {
        let _ = writeln!(text, "o {}", part.name);
        for (mark, values) in [("v", &part.positions), ("vn", &part.normals)] {
            for v in values {
                let _ = writeln!(text, "{mark} {} {} {}", v.x, v.y, v.z);
            }
        }
        for corners in &part.triangles {
            let [a, b, c] = corners.map(|corner| first + corner);
            let _ = writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}");
        }
        first += part.positions.len() as u32;
    }
    text.into_bytes()
}

/// Rami as they are written in curves: points with radii and normals.
fn rami(grown: &Grown) -> impl Iterator<Item = &[CurveNode]> {
    grown.barbs.curves.iter().map(|curve| grown.barbs.nodes_of_curve(curve))
}

/// A feather's axis as a round curve: the middles of the shaft's rings.
fn shaft_curve(grown: &Grown) -> Vec<[f64; 4]> {
    let mut rings: Vec<(f32, Vec<Vec3>)> = Vec::new();
    for mesh in &grown.shaft.meshes {
        for (position, uv) in mesh.positions.iter().zip(&mesh.uvs) {
            match rings.last_mut() {
                Some((along, ring)) if *along == uv.y => ring.push(*position),
                _ => rings.push((uv.y, vec![*position])),
            }
        }
    }
    // The ends' own corners come last, at the rings' places.
    let tubes = rings.windows(2).take_while(|pair| pair[1].0 >= pair[0].0).count() + 1;
    rings
        .iter()
        .take(tubes)
        .filter(|(_, ring)| ring.len() > 2)
        .map(|(_, ring)| {
            let middle = ring.iter().map(|p| p.as_dvec3()).sum::<glam::DVec3>() / ring.len() as f64;
            let radius =
                ring.iter().map(|p| (p.as_dvec3() - middle).length()).sum::<f64>() / ring.len() as f64;
            [middle.x, middle.y, middle.z, radius]
        })
        .collect()
}

/// Control points of round curves: the shaft, the rami, the barbules.
pub(super) fn curves(grown: &Grown) -> Vec<u8> {
    let point = |p: Vec3, radius: f32| [p.x.into(), p.y.into(), p.z.into(), f64::from(radius).max(1e-6)];
    let mut all = vec![shaft_curve(grown)];
    all.extend(rami(grown).map(|nodes| nodes.iter().map(|node| point(node.point, node.radius)).collect()));
    let barbules = &grown.all_barbules();
    all.extend(barbules.ribbons.iter().map(|ribbon| {
        barbules.nodes_of(ribbon).iter().map(|node| point(node.point, node.across.length())).collect()
    }));
    curves_text(&all).into_bytes()
}

/// USD in text: the shaft as a mesh, barbs and barbules as linear curves with widths and normals, which are ribbons. Names of barbules are two
/// integers of 32 bits, the lower first; what they wear, if that is told, is a material of its own.
pub(super) fn usda(grown: &Grown, look: Option<&UsdLook>, notes: &[(&str, &str)]) -> Vec<u8> {
    let mut text =
        "#usda 1.0\n(\n    defaultPrim = \"Feather\"\n    metersPerUnit = 0.001\n    upAxis = \"Z\"\n)\n\n"
            .to_owned();
    comments(&mut text, "#", notes);
    text += "def Xform \"Feather\"\n{\n";
    if let Some(look) = look {
        usd_material(&mut text, look);
    }
    let shaft = Part::shaft(grown);
    text += "    def Mesh \"Shaft\"\n    {\n        uniform token subdivisionScheme = \"none\"\n";
    extent(&mut text, shaft.positions.iter().map(|p| (*p, 0.0)));
    text += "        int[] faceVertexCounts = [";
    listed(&mut text, shaft.triangles.iter().map(|_| 3));
    text += "]\n        int[] faceVertexIndices = [";
    listed(&mut text, shaft.triangles.iter().flatten());
    text += "]\n        point3f[] points = [";
    tuples(&mut text, shaft.positions.iter().copied());
    text += "]\n        normal3f[] normals = [";
    tuples(&mut text, shaft.normals.iter().copied());
    text += "] (interpolation = \"vertex\")\n    }\n";
    let nodes = &grown.barbs.curve_nodes;
    usd_curves(
        &mut text,
        "Barbs",
        None,
        grown.barbs.curves.iter().map(|curve| curve.count),
        nodes.iter().map(|node| (node.point, node.vane_normal, 2.0 * node.radius)),
    );
    let barbules = &grown.all_barbules();
    if !barbules.ribbons.is_empty() {
        let normals = Part::barbules(barbules).normals;
        let nodes = barbules.ribbon_nodes.iter().zip(normals.chunks_exact(2));
        let names: Vec<u64> = barbules.ribbons.iter().map(|ribbon| ribbon.id).collect();
        usd_curves(
            &mut text,
            "Barbules",
            Some((&names, look.is_some())),
            barbules.ribbons.iter().map(|ribbon| ribbon.count),
            nodes.map(|(node, normal)| (node.point, normal[0], 2.0 * node.across.length())),
        );
    }
    text += "}\n";
    text.into_bytes()
}

/// A preview of barbules: a rough mirror of their colour.
fn usd_material(text: &mut String, look: &UsdLook) {
    let [r, g, b] = look.colour;
    let quoted = |text: &str| text.replace('\\', "/").replace('"', "'").replace(['\n', '\r'], " ");
    let _ = write!(
        text,
        r#"    def Material "Barbule" (
        customData = {{
            dictionary barbule = {{
                string material = "{}"
                string material_hash = "{}"
            }}
        }}
    )
    {{
        token outputs:surface.connect = </Feather/Barbule/Preview.outputs:surface>

        def Shader "Preview"
        {{
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = ({r}, {g}, {b})
            float inputs:metallic = 1
            float inputs:roughness = {}
            token outputs:surface
        }}
    }}
"#,
        quoted(&look.material),
        quoted(&look.material_hash),
        look.roughness
    );
}

/// Curves; barbules have names, and may wear the material.
fn usd_curves(
    text: &mut String,
    name: &str,
    barbules: Option<(&[u64], bool)>,
    counts: impl Iterator<Item = u32>,
    nodes: impl Iterator<Item = (Vec3, Vec3, f32)> + Clone,
) {
    let wears = matches!(barbules, Some((_, true)));
    let schema = if wears { " (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )" } else { "" };
    let _ = write!(
        text,
        "    def BasisCurves \"{name}\"{schema}\n    {{\n        uniform token type = \"linear\"\n"
    );
    if wears {
        *text += "        rel material:binding = </Feather/Barbule>\n";
    }
    extent(text, nodes.clone().map(|(point, _, width)| (point, 0.5 * width)));
    *text += "        int[] curveVertexCounts = [";
    listed(text, counts);
    *text += "]\n        point3f[] points = [";
    tuples(text, nodes.clone().map(|(point, ..)| point));
    *text += "]\n        normal3f[] normals = [";
    tuples(text, nodes.clone().map(|(_, normal, _)| normal));
    *text += "] (interpolation = \"vertex\")\n        float[] widths = [";
    listed(text, nodes.map(|(.., width)| width));
    *text += "] (interpolation = \"vertex\")\n";
    if let Some((names, _)) = barbules {
        for (half, shift) in [("lo", 0), ("hi", 32)] {
            let _ = write!(text, "        int[] primvars:instance_{half} = [");
            // USD has no unsigned numbers of a list: the same 32 bits with a sign.
            listed(text, names.iter().map(|name| (name >> shift) as u32 as i32));
            *text += "] (interpolation = \"uniform\")\n";
        }
    }
    *text += "    }\n";
}

/// The box about points with radii; none of nothing.
fn extent(text: &mut String, points: impl Iterator<Item = (Vec3, f32)>) {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for (point, radius) in points {
        (low, high) = (low.min(point - radius), high.max(point + radius));
    }
    if low.is_finite() {
        *text += "        float3[] extent = [";
        tuples(text, [low, high].into_iter());
        *text += "]\n";
    }
}

fn listed<T: std::fmt::Display>(text: &mut String, values: impl Iterator<Item = T>) {
    for (index, value) in values.enumerate() {
        let comma = if index == 0 { "" } else { ", " };
        let _ = write!(text, "{comma}{value}");
    }
}

fn tuples(text: &mut String, values: impl Iterator<Item = Vec3>) {
    for (index, v) in values.enumerate() {
        let comma = if index == 0 { "" } else { ", " };
        let _ = write!(text, "{comma}({}, {}, {})", v.x, v.y, v.z);
    }
}

/// Shapes of pbrt: the shaft and the barbules as triangles, a barb as a cylinder about a cubic Bézier curve.
pub(super) fn pbrt(grown: &Grown, notes: &[(&str, &str)]) -> Vec<u8> {
    let mut text = String::new();
    comments(&mut text, "#", notes);
    triangles(&mut text, &Part::shaft(grown));
    for nodes in rami(grown) {
        let ends = [nodes[0].radius, nodes[nodes.len() - 1].radius].map(|radius| 2.0 * radius);
        text += "Shape \"curve\" \"string type\" \"cylinder\" \"string basis\" \"bezier\" \"point3 P\" [";
        numbers(&mut text, bezier(nodes));
        let _ = writeln!(text, " ] \"float width0\" [ {} ] \"float width1\" [ {} ]", ends[0], ends[1]);
    }
    let barbules = grown.all_barbules();
    if !barbules.ribbons.is_empty() {
        triangles(&mut text, &Part::barbules(&barbules));
    }
    text.into_bytes()
}

fn triangles(text: &mut String, part: &Part) {
    let _ = write!(text, "# {}\nShape \"trianglemesh\" \"point3 P\" [", part.name);
    numbers(text, part.positions.iter().copied());
    *text += " ] \"normal N\" [";
    numbers(text, part.normals.iter().copied());
    *text += " ] \"integer indices\" [";
    for corner in part.triangles.iter().flatten() {
        let _ = write!(text, " {corner}");
    }
    *text += " ]\n";
}

/// Control points of the cubic Bézier pieces through a curve's nodes with the slopes of Catmull and Rom.
fn bezier(nodes: &[CurveNode]) -> Vec<Vec3> {
    let last = nodes.len() - 1;
    let slope = |i: usize| {
        let (from, to) = (i.saturating_sub(1), (i + 1).min(last));
        (nodes[to].point - nodes[from].point) / (to - from) as f32
    };
    let mut points = vec![nodes[0].point];
    for i in 0..last {
        let (from, to) = (nodes[i].point, nodes[i + 1].point);
        points.extend([from + slope(i) / 3.0, to - slope(i + 1) / 3.0, to]);
    }
    points
}
