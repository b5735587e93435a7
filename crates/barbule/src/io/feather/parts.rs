//! The parts of a feather as triangles: the shaft's tube, barbs and barbules as flat ribbons.

use glam::Vec3;

use crate::scene::feather::Grown;
use crate::scene::geometry::{CurveNode, Geometry, Mesh};

/// One part of a feather, all its shapes in one mesh with normals.
pub(super) struct Part {
    pub name: &'static str,
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Part {
    /// The parts that a feather has.
    pub(super) fn all(grown: &Grown) -> Vec<Self> {
        let parts = [Self::shaft(grown), Self::barbs(&grown.barbs), Self::barbules(&grown.all_barbules())];
        parts.into_iter().filter(|part| !part.triangles.is_empty()).collect()
    }

    fn new(name: &'static str) -> Self {
        Self { name, positions: Vec::new(), normals: Vec::new(), triangles: Vec::new() }
    }

    pub(super) fn shaft(grown: &Grown) -> Self {
        let mut part = Self::new("shaft");
        grown.shaft.meshes.iter().for_each(|mesh| part.add(mesh));
        part
    }

    fn add(&mut self, mesh: &Mesh) {
        let first = self.positions.len() as u32;
        self.positions.extend(&mesh.positions);
        self.normals.extend(&mesh.normals);
        self.triangles.extend(mesh.triangles.iter().map(|corners| corners.map(|corner| first + corner)));
    }

    /// Every barb as a ribbon of its ramus' width in the vane.
    fn barbs(fibres: &Geometry) -> Self {
        let mut part = Self::new("barbs");
        for curve in &fibres.curves {
            let nodes = fibres.nodes_of_curve(curve);
            let across = |i: usize| {
                let tangent = tangent(nodes, i);
                tangent.cross(nodes[i].vane_normal).normalize_or(Vec3::X) * nodes[i].radius
            };
            let node = |i: usize| (nodes[i].point, across(i), nodes[i].vane_normal);
            part.ribbon((0..nodes.len()).map(node));
        }
        part
    }

    pub(super) fn barbules(barbules: &Geometry) -> Self {
        let mut part = Self::new("barbules");
        for ribbon in &barbules.ribbons {
            let nodes = barbules.nodes_of(ribbon);
            let normal = |i: usize| {
                let along = nodes[(i + 1).min(nodes.len() - 1)].point - nodes[i.saturating_sub(1)].point;
                nodes[i].across.cross(along).normalize_or(Vec3::Z)
            };
            part.ribbon((0..nodes.len()).map(|i| (nodes[i].point, nodes[i].across, normal(i))));
        }
        part
    }

    /// Adds a ribbon through points with the vectors to its +x edge and its normals; it faces along them.
    fn ribbon(&mut self, nodes: impl ExactSizeIterator<Item = (Vec3, Vec3, Vec3)>) {
        let (first, count) = (self.positions.len() as u32, nodes.len() as u32);
        for (point, across, normal) in nodes {
            self.positions.extend([point - across, point + across]);
            self.normals.extend([normal; 2]);
        }
        for i in 0..count.saturating_sub(1) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|corner| first + 2 * i + corner);
            self.triangles.extend([[a, b, c], [c, b, d]]);
        }
    }
}

/// Direction of a curve at one of its nodes.
fn tangent(nodes: &[CurveNode], i: usize) -> Vec3 {
    (nodes[(i + 1).min(nodes.len() - 1)].point - nodes[i.saturating_sub(1)].point).normalize_or(Vec3::Y)
}
