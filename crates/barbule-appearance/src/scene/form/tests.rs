use std::collections::HashMap;
use std::f64::consts::PI;

use super::*;
use crate::progress::Unobserved;

fn ball(radius: f64) -> Part {
    Part {
        nodes: vec![(DVec3::ZERO, radius)],
        stretch: DVec3::ONE,
        turn: DMat3::IDENTITY,
        shift: DVec3::ZERO,
        blend_mm: 0.0,
        is_mirrored: false,
        is_cut: false,
    }
}

fn made(parts: Vec<Part>, resolution_mm: f64) -> (Form, Mesh) {
    let form = Form { parts, resolution_mm };
    let mesh = form.mesh(&Unobserved).unwrap();
    (form, mesh)
}

fn volume(mesh: &Mesh) -> f64 {
    let of = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|k| mesh.positions[k as usize].as_dvec3());
        a.dot(b.cross(c)) / 6.0
    };
    mesh.triangles.iter().map(of).sum()
}

/// Corners − edges + faces; every edge runs once in each direction, so that the mesh is closed and all faces look to one side.
fn euler(mesh: &Mesh) -> i64 {
    let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        for edge in [(a, b), (b, c), (c, a)] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    for (&(a, b), &count) in &edges {
        assert_eq!((count, edges.get(&(b, a))), (1, Some(&1)), "edge {a} {b}");
    }
    mesh.positions.len() as i64 - edges.len() as i64 / 2 + mesh.triangles.len() as i64
}

/// A sphere, an ellipsoid, a capsule and a rounded cone against their volumes: that of a cone between two spheres is the frustum
/// between the circles where it leaves them, and two caps.
#[test]
fn volumes_are_those_of_solids() {
    let sphere = made(vec![ball(10.0)], 0.8).1;
    let stretched = Part {
        stretch: DVec3::new(10.0, 20.0, 5.0),
        turn: DMat3::from_rotation_z(0.6) * DMat3::from_rotation_x(0.4),
        shift: DVec3::new(7.0, -3.0, 2.0),
        ..ball(1.0)
    };
    let ellipsoid = made(vec![stretched], 0.7).1;
    let tube = |r: f64, s: f64| Part { nodes: vec![(DVec3::ZERO, r), (DVec3::Y * 20.0, s)], ..ball(1.0) };
    let capsule = made(vec![tube(5.0, 5.0)], 0.6).1;
    let cone = made(vec![tube(6.0, 3.0)], 0.5).1;
    let sine = 3.0_f64 / 20.0;
    let cosine = (1.0 - sine * sine).sqrt();
    let [r, s] = [6.0 * cosine, 3.0 * cosine];
    let height = 20.0 + (3.0 - 6.0) * sine;
    let frustum = PI / 3.0 * height * (r * r + r * s + s * s);
    let cap = |radius: f64, share: f64| PI * radius.powi(3) * (2.0 / 3.0 - share + share.powi(3) / 3.0);
    let expected = frustum + cap(6.0, -sine) + cap(3.0, sine);
    for (mesh, expected) in [
        (sphere, 4.0 / 3.0 * PI * 1000.0),
        (ellipsoid, 4.0 / 3.0 * PI * 1000.0),
        (capsule, PI * 25.0 * 20.0 + 4.0 / 3.0 * PI * 125.0),
        (cone, expected),
    ] {
        assert!((volume(&mesh) / expected - 1.0).abs() < 0.01, "{} {expected}", volume(&mesh));
        assert_eq!(euler(&mesh), 2);
    }
}

/// Two balls that melt into each other: one closed surface without a crease. Without the blend the same places have one.
#[test]
fn a_blend_has_no_crease() {
    let steepest = |blend_mm: f64| {
        let second = Part { shift: DVec3::X * 14.0, blend_mm, ..ball(9.0) };
        let (form, mesh) = made(vec![ball(10.0), second], 0.5);
        assert_eq!(euler(&mesh), 2);
        let mut worst: f64 = 0.0;
        for corners in &mesh.triangles {
            let [a, b, c] = corners.map(|k| mesh.normals[k as usize].as_dvec3());
            let [p, ..] = corners.map(|k| mesh.positions[k as usize].as_dvec3());
            assert!(blend_mm == 0.0 || form.distance(p).abs() < 0.02, "{p}");
            worst = worst.max(a.angle_between(b)).max(b.angle_between(c));
            let face = |k: usize| mesh.positions[corners[k] as usize].as_dvec3();
            let out = (face(1) - face(0)).cross(face(2) - face(0));
            assert!(out.dot(a + b + c) > 0.0);
        }
        worst.to_degrees()
    };
    let (smooth, sharp) = (steepest(8.0), steepest(0.0));
    println!("normals of neighbours differ by at most {smooth:.1}°, without a blend {sharp:.1}°");
    // Spheres of 9 and 10 mm meet at 95°; edges are up to 0.9 mm long, 5° on these spheres.
    assert!(smooth < 12.0 && sharp > 80.0, "{smooth} {sharp}");
}

/// What is cut out is gone, what is mirrored stands on both sides; paths go through their points.
#[test]
fn parts_are_cut_and_mirrored() {
    let bite = Part { shift: DVec3::new(8.0, 0.0, 0.0), is_mirrored: true, is_cut: true, ..ball(4.0) };
    let (form, mesh) = made(vec![ball(10.0), bite], 0.5);
    for side in [-1.0, 1.0] {
        assert!(form.distance(DVec3::X * side * 8.0) > 0.0);
    }
    assert!(form.distance(DVec3::Y * 8.0) < 0.0 && volume(&mesh) < 0.96 * 4.0 / 3.0 * PI * 1000.0);
    let points = [DVec3::ZERO, DVec3::new(5.0, 8.0, 1.0), DVec3::new(4.0, 20.0, 0.0)];
    let nodes = Part::path(&points, &[3.0, 2.0, 1.0]);
    for (i, point) in points.iter().enumerate() {
        let (node, radius) = nodes[i * STEPS as usize];
        assert!((node - *point).length() < 1e-12 && (radius - (3.0 - i as f64)).abs() < 1e-12);
    }
}

/// Too fine a grid is refused before anything is made; a form whose parts are all cut away too.
#[test]
fn forms_that_make_no_mesh_are_refused() {
    let refused =
        |parts, resolution_mm| Form { parts, resolution_mm }.mesh(&Unobserved).unwrap_err().to_string();
    let fine = refused(vec![ball(1000.0)], 0.01);
    assert!(fine.contains("over the limit of 3e7; give a coarser one"), "{fine}");
    let cut = Part { is_cut: true, ..ball(20.0) };
    assert!(refused(vec![ball(10.0), cut], 1.0).starts_with("nothing of the form is seen"));
}
