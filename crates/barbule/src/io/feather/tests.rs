//! What is written is read again by this program's own readers.

use glam::Vec3;

use super::*;
use crate::io::{read_curves, read_mesh};
use crate::scene::feather::{Feather, Level, VaneDisc};
use crate::scene::spline::Basis;

fn grown(barbules: bool) -> Grown {
    let mut feather = Feather::of_type("contour").unwrap();
    feather.shaft.length_mm = 6.0;
    feather.barbs.leading_half_width_mm = 1.5;
    feather.barbs.trailing_half_width_mm = 2.0;
    let whole = VaneDisc { along_mm: 0.0, radius_mm: None };
    if barbules {
        feather.grow(whole, Level::Barbules, None, 1, 1).unwrap()
    } else {
        feather.grow_barbs(whole, 1, 1, &crate::progress::Unobserved).unwrap()
    }
}

fn bounds(points: impl Iterator<Item = Vec3>) -> [Vec3; 2] {
    points.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

#[test]
fn meshes_are_read_back_with_all_triangles_in_their_places() {
    let folder = tempfile::tempdir().unwrap();
    for barbules in [false, true] {
        let grown = grown(barbules);
        let parts = Part::all(&grown);
        assert_eq!(parts.len(), 2 + usize::from(barbules));
        let counts = grown.counts();
        assert!(counts.barbs > 20 && (counts.barbules > 4000) == barbules, "{counts:?}");
        let triangles: usize = parts.iter().map(|part| part.triangles.len()).sum();
        let expected = grown.shaft.meshes[0].triangles.len()
            + 2 * (grown.barbs.curve_nodes.len() - counts.barbs)
            + 2 * (grown.all_barbules().ribbon_nodes.len() - counts.barbules);
        assert_eq!(triangles, expected);
        let of_parts = bounds(parts.iter().flat_map(|part| part.positions.iter().copied()));
        for ending in ["ply", "obj", "gltf"] {
            let path = folder.path().join(format!("a.{ending}"));
            write_feather(&path, &grown, &[("command", "barbule feather\nx")]).unwrap();
            let (mesh, _) = read_mesh(&path).unwrap();
            assert_eq!(mesh.triangles.len(), triangles, "{ending}");
            let [low, high] = bounds(mesh.positions.iter().copied());
            assert!(
                (low - of_parts[0]).length() + (high - of_parts[1]).length() < 1e-4,
                "{ending}: {low} {high}"
            );
            assert_eq!(mesh.normals.len(), mesh.positions.len());
            // Faces look as their normals do.
            let away = mesh.triangles.iter().filter(|corners| {
                let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
                (b - a).cross(c - a).dot(mesh.normals[corners[0] as usize]) < 0.0
            });
            assert!(away.count() * 200 < triangles, "{ending}");
        }
    }
}

#[test]
fn curves_are_read_back_with_their_radii() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    let grown = grown(true);
    write_feather(&path, &grown, &[]).unwrap();
    let curves = read_curves(&path, Basis::Linear).unwrap();
    assert_eq!(curves.len(), 1 + grown.counts().barbs + grown.counts().barbules);
    // The shaft from its base to its tip, then the first barb.
    let shaft = &curves[0];
    assert!(shaft[0][1].abs() < 0.02 && shaft[shaft.len() - 1][1] > 5.5, "{:?}", shaft[shaft.len() - 1]);
    assert!(shaft.iter().any(|point| (point[3] - 0.25).abs() < 0.03));
    for (point, node) in curves[1].iter().zip(grown.barbs.nodes_of_curve(&grown.barbs.curves[0])) {
        assert!((point[0] - f64::from(node.point.x)).abs() < 1e-6);
        assert!((point[3] - f64::from(node.radius)).abs() < 1e-6);
    }
}

#[test]
fn usd_and_pbrt_hold_every_curve() {
    let folder = tempfile::tempdir().unwrap();
    let grown = grown(true);
    let written = |ending: &str| {
        let path = folder.path().join(format!("a.{ending}"));
        write_feather(&path, &grown, &[("seed", "1")]).unwrap();
        std::fs::read_to_string(&path).unwrap()
    };
    let usd = written("usda");
    let list = |text: &str, from: &str, key: &str| -> usize {
        let text = &text[text.find(from).unwrap()..];
        let text = &text[text.find(key).unwrap()..];
        let text = &text[text.find("= [").unwrap() + 3..];
        text[..text.find(']').unwrap()].matches([',', '(']).count()
    };
    assert_eq!(list(&usd, "\"Barbs\"", "curveVertexCounts") + 1, grown.counts().barbs);
    assert_eq!(list(&usd, "\"Barbules\"", "curveVertexCounts") + 1, grown.counts().barbules);
    // A parenthesis, two commas and, but for the last, one more a point.
    assert_eq!(list(&usd, "\"Barbules\"", "points") + 1, 4 * grown.all_barbules().ribbon_nodes.len());
    assert_eq!(list(&usd, "\"Barbs\"", "widths") + 1, grown.barbs.curve_nodes.len());
    assert!(usd.starts_with("#usda 1.0\n") && usd.matches('{').count() == usd.matches('}').count());
    let pbrt = written("pbrt");
    assert_eq!(pbrt.matches("Shape \"curve\"").count(), grown.counts().barbs);
    assert_eq!(pbrt.matches("Shape \"trianglemesh\"").count(), 2);
    let line = pbrt.lines().find(|line| line.starts_with("Shape \"curve\"")).unwrap();
    let points = &line[line.find('[').unwrap() + 1..line.find(']').unwrap()];
    let nodes = grown.barbs.curves[0].count as usize;
    assert_eq!(points.split_whitespace().count(), 3 * (3 * (nodes - 1) + 1));
}

/// The name of a barbule is told by two numbers, and the material's by text that no quote ends.
#[test]
fn usd_tells_barbules_apart_and_what_they_wear() {
    let folder = tempfile::tempdir().unwrap();
    let grown = grown(true);
    let look = UsdLook {
        colour: [0.1, 0.2, 0.3],
        roughness: 0.4,
        material: "a \"b\"".into(),
        material_hash: "c0ffee".into(),
    };
    let path = folder.path().join("a.usda");
    write_usd(&path, &grown, &look, &[]).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let numbers = |key: &str| -> Vec<i64> {
        let from = text.find(key).unwrap() + key.len();
        let list = &text[from + 4..];
        list[..list.find(']').unwrap()].split(", ").map(|n| n.parse().unwrap()).collect()
    };
    let (low, high) = (numbers("primvars:instance_lo"), numbers("primvars:instance_hi"));
    let all = grown.all_barbules();
    assert_eq!(low.len(), all.ribbons.len());
    for ((low, high), ribbon) in low.iter().zip(&high).zip(&all.ribbons) {
        let name = u64::from(*high as u32) << 32 | u64::from(*low as u32);
        assert_eq!(name, ribbon.id);
    }
    assert!(text.contains("string material = \"a 'b'\"") && text.contains("(0.1, 0.2, 0.3)"));
    assert_eq!(text.matches("material:binding").count(), 1);
    assert_eq!(text.matches('{').count(), text.matches('}').count());
    let message = write_usd(&folder.path().join("a.ply"), &grown, &look, &[]).unwrap_err().to_string();
    assert!(message.contains(".usda"), "{message}");
}

#[test]
fn other_endings_are_refused() {
    let message = write_feather(Path::new("a.stl"), &Grown::default(), &[]).unwrap_err().to_string();
    assert!(message.contains("a.stl: feathers are written as .usda, .ply"), "{message}");
}
