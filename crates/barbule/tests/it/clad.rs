//! Surfaces clad in barbules against barbules that a feather grew: the same ribbons as meshes with texture coordinates.

use std::sync::Arc;

use barbule::brdf::fixtures::example;
use barbule::brdf::{FeatherBrdf, Options};
use barbule::bsdf::{
    BarbuleSurface, Bsdf, Clad, Evaluation, Hit, Keratin, Lambertian, Layout, Reflectance, Surface,
};
use barbule::math::rng::{Stream, hash};
use barbule::render::stage::Stage;
use barbule::scene::Object;
use barbule::scene::emission::Emission;
use barbule::scene::feather::{Feather, Level, VaneDisc};
use barbule::scene::geometry::{CurveNode, Geometry, Mesh, Ribbon, RibbonNode};
use barbule::scene::light::{Light, Sun, disc_radiance};
use barbule::spectrum::dense::{Lambdas, WAVES};
use glam::{DVec3, Vec2, Vec3};

use crate::small_scenes::{camera, film_of, lamp, luminance, scene};

const PATH: [f64; WAVES] = [550.0, 610.0, 470.0, 510.0, 400.0, 430.0, 650.0, 690.0];

/// A contour feather with barbules of swelling cells and an arched section.
fn feather() -> Feather {
    let mut feather = Feather::of_type("contour").unwrap();
    let distal = &mut feather.distal;
    (distal.cell_um, distal.swelling, distal.wall_um) = (30.0, 0.035, 2.0);
    (distal.arch_low, distal.arch_high) = (-0.3, 0.2);
    (feather.disorder.cell_size, feather.disorder.barbule_size) = (0.03, 0.01);
    feather
}

/// What its distal barbules are made of.
fn barbule(instances: bool) -> BarbuleSurface {
    let feather = feather();
    BarbuleSurface {
        brdf: Arc::new(FeatherBrdf::new(&example(6), Options::default()).unwrap()),
        instances,
        below: None,
        under: Keratin::new(0.3, 1.56, Reflectance::melanin(20.0).unwrap()).unwrap(),
        cells: feather.distal.cells(&feather.disorder),
        opacity: 1.0,
    }
}

/// Distal barbules of the feather, each from the origin, and cells counted from there.
fn grown() -> Vec<(Vec<RibbonNode>, Ribbon)> {
    let feather = feather();
    let window = VaneDisc { along_mm: 0.6 * feather.shaft.length_mm, radius_mm: Some(1.0) };
    let grown = feather.grow(window, Level::Barbules, None, 1, 1).unwrap();
    let [distal, _] = &grown.barbules;
    let step = distal.ribbons.len() / 24;
    let of = |ribbon: &Ribbon| {
        let nodes = distal.nodes_of(ribbon);
        let moved = |node: &RibbonNode| RibbonNode { point: node.point - nodes[0].point, ..*node };
        (nodes.iter().map(moved).collect(), Ribbon { phase: 0.0, ..*ribbon })
    };
    distal.ribbons.iter().step_by(step).map(of).collect()
}

/// Without its bends and its taper, along `along`, steps of whole `grain`s.
fn straight(nodes: &[RibbonNode], [across, along]: [Vec3; 2], grain: f32) -> Vec<RibbonNode> {
    let whole = |length: f32| (length / grain).round() * grain;
    let (step, half_width) = (whole(nodes[1].arc), whole(nodes[3].across.length()));
    (0..nodes.len())
        .map(|k| {
            let arc = step * k as f32;
            RibbonNode { point: along * arc, across: across * half_width, arc }
        })
        .collect()
}

/// The same triangles as a ribbon's, with its arc length and −1 … 1 as texture coordinates, and its normals at the nodes.
fn mesh(nodes: &[RibbonNode], id: u64) -> Mesh {
    let mut mesh = Mesh { id, ..Mesh::default() };
    for (k, node) in nodes.iter().enumerate() {
        let along = nodes[(k + 1).min(nodes.len() - 1)].point - nodes[k.saturating_sub(1)].point;
        for side in [-1.0, 1.0] {
            mesh.positions.push(node.point + node.across * side);
            mesh.normals.push(node.across.cross(along).normalize());
            mesh.uvs.push(Vec2::new(node.arc, side));
        }
    }
    for k in 0..nodes.len() as u32 - 1 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|corner| 2 * k + corner);
        mesh.triangles.extend([[a, b, d], [a, d, c]]);
    }
    mesh
}

/// The largest differences between a ribbon and its mesh: of frames, of texture coordinates with the place in the cell, and of values
/// and densities over their peak.
#[derive(Debug, Default)]
struct Worst {
    frame: f64,
    place: f64,
    value: f64,
    rays: usize,
    /// Rays that a twisted segment shows to either of its triangles: a ribbon takes the first of them, a mesh the nearer.
    apart: usize,
}

impl Worst {
    /// Rays from all around at a ribbon and at its mesh.
    fn add(&mut self, nodes: &[RibbonNode], ribbon: Ribbon, barbule: &BarbuleSurface) {
        let half_width = f64::from(nodes[3].across.length());
        let layout = Layout {
            uv_mm: [1.0, half_width],
            width_mm: 0.0,
            length_mm: 0.0,
            cell_mm: f64::from(ribbon.cell),
            swelling: f64::from(ribbon.swelling),
        };
        let clad = Surface::Clad(Box::new(Clad::new(barbule.clone(), layout).unwrap()));
        let mut geometry = Geometry::default();
        geometry.add_ribbon(nodes, ribbon);
        let plain = Surface::Barbule(barbule.clone());
        let own = Stage::new(vec![Object { geometry, surface: plain.clone() }]).unwrap();
        let geometry = Geometry { meshes: vec![mesh(nodes, ribbon.id)], ..Geometry::default() };
        let worn = Stage::new(vec![Object { geometry, surface: clad.clone() }]).unwrap();
        let mut stream = Stream::new(ribbon.id, &[]);
        for _ in 0..40 {
            let node = &nodes[1 + (stream.unit() * 4.0) as usize];
            let target = (node.point + node.across * stream.uniform(-0.9, 0.9) as f32).as_dvec3();
            let wo = random(&mut stream);
            let meet = |stage: &Stage| stage.hit(target + wo, -wo, 0.0, 10.0);
            let (Some(on_ribbon), Some(on_mesh)) = (meet(&own), meet(&worn)) else { continue };
            self.rays += 1;
            if (on_ribbon.position - on_mesh.position).length() > 1e-4 {
                self.apart += 1;
                continue;
            }
            let found = layout.on_barbule(&on_mesh);
            self.compare(&on_ribbon, &found);
            // A hit within rounding of a cell's end may lie in the next one.
            if on_ribbon.instance != found.instance {
                continue;
            }
            let bound = [(&plain, &on_ribbon), (&clad, &on_mesh)]
                .map(|(surface, hit)| surface.bind(hit, wo, Lambdas::new(PATH)));
            let mut drawn = || bound[0].sample([stream.unit(), stream.unit(), stream.unit()]);
            // Where the lobe is, and all around.
            let mut directions: Vec<DVec3> = (0..8).filter_map(|_| Some(drawn()?.wi)).collect();
            directions.extend((0..4).map(|_| random(&mut stream)));
            let values =
                |bsdf: Bsdf<'_>| -> Vec<Evaluation> { directions.iter().map(|wi| bsdf.eval(*wi)).collect() };
            let [expected, found] = bound.map(values);
            for of in [|e: &Evaluation| e.f, |e: &Evaluation| e.pdf] {
                let peak = expected.iter().flat_map(of).fold(0.0, f64::max);
                for (a, b) in expected.iter().flat_map(of).zip(found.iter().flat_map(of)) {
                    self.value = self.value.max((a - b).abs() / peak.max(1e-9));
                }
            }
        }
    }

    fn compare(&mut self, ribbon: &Hit, mesh: &Hit) {
        let (a, b) = (ribbon.frame, mesh.frame);
        for apart in [a.x - b.x, a.y - b.y, a.z - b.z] {
            self.frame = self.frame.max(apart.length());
        }
        let place = |hit: &Hit| hit.ribbon.cell as f64 + hit.ribbon.place;
        let apart = [ribbon.uv[0] - mesh.uv[0], ribbon.uv[1] - mesh.uv[1], place(ribbon) - place(mesh)];
        self.place = apart.iter().fold(self.place, |worst, apart| worst.max(apart.abs()));
        assert_eq!((ribbon.id, ribbon.ribbon.cell_length), (mesh.id, mesh.ribbon.cell_length));
    }
}

fn random(stream: &mut Stream) -> DVec3 {
    DVec3::new(stream.normal(), stream.normal(), stream.normal()).normalize()
}

/// Straight and flat, along an axis and of lengths that single precision holds, a ribbon and its mesh are the same to rounding.
#[test]
fn barbules_as_meshes_scatter_as_those_that_grew() {
    let barbule = barbule(true);
    let mut worst = Worst::default();
    for (nodes, ribbon) in grown() {
        let ribbon = Ribbon { swelling: 0.0, ..ribbon };
        worst.add(&straight(&nodes, [Vec3::X, Vec3::Y], 1.0 / 4096.0), ribbon, &barbule);
    }
    println!("{worst:?}");
    assert!(worst.rays > 500 && worst.apart == 0, "{worst:?}");
    assert!(worst.frame < 1e-6 && worst.place < 1e-6 && worst.value < 1e-6, "{worst:?}");
}

/// Straight but as they point in the feather: what single precision leaves of directions, and of values on the flanks of narrow lobes.
#[test]
fn barbules_that_slant_are_the_same_to_single_precision() {
    let barbule = barbule(true);
    let mut worst = Worst::default();
    for (nodes, ribbon) in grown() {
        let along = nodes[6].point.normalize();
        let across = (nodes[3].across - along * along.dot(nodes[3].across)).normalize();
        worst.add(&straight(&nodes, [across, along], 1e-7), ribbon, &barbule);
    }
    println!("{worst:?}");
    assert!(worst.rays > 500 && worst.apart == 0, "{worst:?}");
    assert!(worst.frame < 3e-6 && worst.place < 5e-5 && worst.value < 1e-4, "{worst:?}");
}

/// As they grew, bent and tapering: a face of a mesh has one direction of u, which a ribbon's turns over.
#[test]
fn bends_and_tapers_turn_a_meshs_frames_by_a_few_degrees_at_most() {
    let barbule = barbule(false);
    let mut worst = Worst::default();
    grown().into_iter().for_each(|(nodes, ribbon)| worst.add(&nodes, ribbon, &barbule));
    println!("{worst:?}");
    assert!(worst.rays > 500 && 50 * worst.apart < worst.rays, "{worst:?}");
    assert!(worst.frame < 0.06 && worst.place < 1e-4, "{worst:?}");
}

/// Ribbons side by side and a square clad in them: the means agree within four deviations of both pictures' noise; where cells and
/// barbules draw sizes and glints of their own, within two hundredths more, for fifty barbules are seen.
#[test]
fn a_patch_of_ribbons_looks_as_a_mesh_that_wears_them() {
    const SIDE: f32 = 4.0;
    let (width, cell) = (0.04_f32, 0.03_f32);
    let mut ribbons = Geometry::default();
    for k in 0..(SIDE / width).round() as u64 {
        let x = (k as f32 + 0.5) * width - 0.5 * SIDE;
        let node = |arc: f32| RibbonNode {
            point: Vec3::new(x, arc - 0.5 * SIDE, 0.0),
            across: 0.5 * width * Vec3::X,
            arc,
        };
        let phase = Stream::new(5, &[k]).unit() as f32;
        let ribbon = Ribbon { id: hash(5, &[k]), cell, phase, swelling: 0.05, ..Ribbon::default() };
        ribbons.add_ribbon(&[node(0.0), node(0.5 * SIDE), node(SIDE)], ribbon);
    }
    let corner = |x: f32, y: f32| 0.5 * SIDE * Vec3::new(x, y, 0.0);
    let square = Mesh {
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        uvs: vec![Vec2::ZERO, Vec2::Y, Vec2::ONE, Vec2::X],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        id: 5,
        ..Mesh::default()
    };
    let square = Geometry { meshes: vec![square], ..Geometry::default() };
    let layout = Layout {
        uv_mm: [f64::from(SIDE); 2],
        width_mm: f64::from(width),
        length_mm: 0.0,
        cell_mm: f64::from(cell),
        swelling: 0.05,
    };
    let view = camera(0.9, 2.0);
    let eye = view.eye.normalize();
    let emission = Emission::daylight().scaled(disc_radiance(0.3, 1.0));
    let sun = Sun { direction: DVec3::new(-eye.x, -eye.y, eye.z), cos_radius: 0.95, emission };
    let mean = |geometry: &Geometry, surface: Surface| {
        let lights = lamp(Light::Sun(sun.clone()));
        luminance(&film_of(scene(geometry.clone(), surface, lights, view), [32, 32], 64))
    };
    for (draws, more) in [(false, 0.0), (true, 0.02)] {
        let mut barbule = barbule(draws);
        if !draws {
            (barbule.cells.size, barbule.cells.barbule_size) = (0.0, 0.0);
        }
        let clad = Clad::new(barbule.clone(), layout).unwrap();
        let own = mean(&ribbons, Surface::Barbule(barbule));
        let worn = mean(&square, Surface::Clad(Box::new(clad)));
        println!("ribbons {own:?}, mesh {worn:?}");
        let most = 4.0 * own.1.hypot(worn.1) + more * own.0;
        assert!(own.0 > 0.01 && (own.0 - worn.0).abs() < most, "{draws}: {own:?} {worn:?}");
    }
}

/// A fibre shows a barbule that faces the viewer: across it lies what of the fibre is seen there.
#[test]
fn a_fibre_wears_a_barbule_that_faces_the_viewer() {
    let node = |y: f32| CurveNode { point: Vec3::new(0.0, y, 0.0), radius: 0.1, ..CurveNode::default() };
    let mut geometry = Geometry::default();
    geometry.add_curve(&[node(-1.0), node(1.0)], 3);
    let surface = Surface::Lambertian(Lambertian::new(Reflectance::new(|_| 1.0).unwrap()));
    let stage = Stage::new(vec![Object { geometry, surface }]).unwrap();
    let layout = Layout { uv_mm: [2.0, 0.1], width_mm: 0.0, length_mm: 0.0, cell_mm: 0.25, swelling: 0.0 };
    let wo = DVec3::new(0.6, 0.0, 0.8);
    let right = DVec3::Y.cross(wo);
    for (y, x) in [(0.3, 0.5), (-0.2, -0.8), (0.9, 0.1)] {
        let hit = stage.hit(DVec3::Y * y + 0.1 * x * right + wo, -wo, 0.0, 10.0).unwrap();
        let on = layout.on_barbule(&hit);
        assert!((on.uv[0] - (y + 1.0)).abs() < 1e-5 && (on.uv[1] - x).abs() < 1e-4, "{:?} {x}", on.uv);
        assert_eq!(on.ribbon.cell, ((y + 1.0) / 0.25) as u64);
        assert!(on.frame.y.dot(DVec3::Y) > 0.999 && on.frame.z == hit.frame.z);
    }
}
