//! Which way the faces of triangle meshes look, and turning those of closed ones outwards.
//!
//! A face looks to where its corners run counter-clockwise. Programs that write meshes do not all keep to that.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use super::geometry::Mesh;

/// Corners nearer than this share of the mesh's size are one.
const WELD: f64 = 1e-6;

/// The volume that open faces have in front of them over their area to the power 3/2 counts as inside from here on: half a sphere has
/// 0.1, a flat sheet 0.
const HOLLOW: f64 = 0.02;

/// Which way the faces of a mesh look.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Facing {
    /// Of each triangle, whether it looks into a closed part of the mesh and so is to be turned.
    pub is_turned: Vec<bool>,
    /// Whether parts of it are open, and so have no inside.
    pub is_open: bool,
    /// Whether the faces of the open parts, like those of a bowl turned inside out, look to the hollow side.
    pub is_hollow: bool,
}

impl Facing {
    /// Whether any triangle is to be turned.
    #[must_use]
    pub fn is_inside_out(&self) -> bool {
        self.is_turned.contains(&true)
    }

    /// Which way the triangles of these corners look; corners at the same point are one.
    ///
    /// Triangles that share an edge belong to one part. A part is closed if each of its edges has two triangles and they can all be
    /// ordered alike. Parts that are ordered alike already stay together as they are: where their volume is negative in the sum, all are
    /// turned, so that a cavity stays one. A part that is not is made to look outwards by itself.
    #[must_use]
    pub fn of(points: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let parts = Parts::of(triangles);
        let mut is_turned = parts.is_turned.clone();
        let mut volumes = vec![0.0; parts.count];
        for ((&corners, &part), &turned) in triangles.iter().zip(&parts.part).zip(&parts.is_turned) {
            let from = points[triangles[parts.first[part]][0] as usize];
            let own = volume(points, corners, from);
            volumes[part] += if turned { -own } else { own };
        }
        let is_even = |part: usize| parts.is_closed[part] && !parts.is_mixed[part];
        let even_volume: f64 = (0..parts.count).filter(|&part| is_even(part)).map(|part| volumes[part]).sum();
        for (turned, &part) in is_turned.iter_mut().zip(&parts.part) {
            let inwards = if is_even(part) { even_volume < 0.0 } else { volumes[part] < 0.0 };
            *turned = parts.is_closed[part] && (*turned != inwards);
        }
        let open = triangles.iter().zip(&parts.part).filter(|(_, part)| !parts.is_closed[**part]);
        let open: Vec<[u32; 3]> = open.map(|(corners, _)| *corners).collect();
        Self { is_turned, is_open: !open.is_empty(), is_hollow: is_hollow(points, &open) }
    }

    /// Which way the triangles of a mesh look; those without an area are left out of account.
    #[must_use]
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let positions: Vec<DVec3> = mesh.positions.iter().map(|p| p.as_dvec3()).collect();
        if positions.iter().any(|p| !p.is_finite())
            || mesh.triangles.iter().flatten().any(|&corner| corner as usize >= positions.len())
        {
            return Self { is_turned: vec![false; mesh.triangles.len()], ..Self::default() };
        }
        let Welded { points, of, step } = Welded::of(&positions);
        let (kept, triangles): (Vec<usize>, Vec<[u32; 3]>) = mesh
            .triangles
            .iter()
            .map(|corners| corners.map(|corner| of[corner as usize]))
            .enumerate()
            .filter(|(_, corners)| has_area(&points, *corners, step))
            .unzip();
        let facing = Self::of(&points, &triangles);
        let mut is_turned = vec![false; mesh.triangles.len()];
        kept.into_iter().zip(facing.is_turned).for_each(|(index, turned)| is_turned[index] = turned);
        Self { is_turned, ..facing }
    }
}

/// The mesh with the faces of its closed parts turned outwards, and the normals of its corners with them; the same where all look
/// outwards.
#[must_use]
pub fn outwards(mut mesh: Mesh) -> Mesh {
    let facing = Facing::of_mesh(&mesh);
    if !facing.is_inside_out() {
        return mesh;
    }
    let mut normals = vec![Vec3::ZERO; mesh.normals.len()];
    for (corners, &turned) in mesh.triangles.iter_mut().zip(&facing.is_turned) {
        if turned {
            corners.swap(1, 2);
        }
        let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
        let normal = (b - a).cross(c - a);
        if turned && !normals.is_empty() {
            corners.iter().for_each(|&corner| normals[corner as usize] += normal);
        }
    }
    // A program that orders corners wrongly may have written normals that are right.
    for (own, of_faces) in mesh.normals.iter_mut().zip(normals) {
        if own.dot(of_faces) < 0.0 {
            *own = -*own;
        }
    }
    mesh
}

/// The mesh with all its faces turned; normals of corners stay as they are.
#[must_use]
pub(super) fn turned_round(mesh: &Mesh) -> Mesh {
    let triangles = mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    Mesh { triangles, ..mesh.clone() }
}

/// A mesh's corners with those at the same point made one.
pub(super) struct Welded {
    /// The points.
    pub(super) points: Vec<DVec3>,
    /// Which point each corner is.
    pub(super) of: Vec<u32>,
    /// How near corners are one, mm.
    pub(super) step: f64,
}

impl Welded {
    pub(super) fn of(positions: &[DVec3]) -> Self {
        let (low, high) = positions
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        let step = WELD * (high - low).max_element().max(1e-9);
        let mut known = HashMap::new();
        let mut points = Vec::new();
        let of = positions
            .iter()
            .map(|&p| {
                let cell = ((p - low) / step).round().as_i64vec3();
                *known.entry(cell).or_insert_with(|| {
                    points.push(p);
                    points.len() as u32 - 1
                })
            })
            .collect();
        Self { points, of, step }
    }
}

/// Whether a triangle has an area, where corners nearer than `step` are one.
pub(super) fn has_area(points: &[DVec3], corners: [u32; 3], step: f64) -> bool {
    let [p, q, r] = corners.map(|corner| points[corner as usize]);
    (q - p).cross(r - p).length() > step * step
}

/// Six times the volume of the tetrahedron between a triangle and a point, mm³; positive where the triangle looks away from it.
fn volume(points: &[DVec3], corners: [u32; 3], from: DVec3) -> f64 {
    let [p, q, r] = corners.map(|corner| points[corner as usize] - from);
    p.dot(q.cross(r))
}

/// Whether open triangles look to the side on which their own middle lies.
fn is_hollow(points: &[DVec3], triangles: &[[u32; 3]]) -> bool {
    let (mut middle, mut area) = (DVec3::ZERO, 0.0);
    for corners in triangles {
        let [p, q, r] = corners.map(|corner| points[corner as usize]);
        let own = 0.5 * (q - p).cross(r - p).length();
        (middle, area) = (middle + (p + q + r) / 3.0 * own, area + own);
    }
    let within: f64 = triangles.iter().map(|&corners| volume(points, corners, middle / area) / 6.0).sum();
    area > 0.0 && within < -HOLLOW * area * area.sqrt()
}

/// Triangles by the parts of a mesh that edges hold together.
struct Parts {
    count: usize,
    /// Of each triangle its part.
    part: Vec<usize>,
    /// Of each triangle whether it is ordered otherwise than the first of its part.
    is_turned: Vec<bool>,
    /// Of each part its first triangle.
    first: Vec<usize>,
    /// Of each part whether every edge has two triangles, and all can be ordered alike.
    is_closed: Vec<bool>,
    /// Of each part whether not all are ordered alike.
    is_mixed: Vec<bool>,
}

/// A triangle's neighbour over an edge, and whether both run along the edge in the same direction, which none does that is ordered
/// alike.
type Neighbour = (u32, bool);

impl Parts {
    fn of(triangles: &[[u32; 3]]) -> Self {
        let (neighbours, has_border) = neighbours(triangles);
        let mut parts = Self {
            count: 0,
            part: vec![usize::MAX; triangles.len()],
            is_turned: vec![false; triangles.len()],
            first: Vec::new(),
            is_closed: Vec::new(),
            is_mixed: Vec::new(),
        };
        let mut open = Vec::new();
        for first in 0..triangles.len() {
            if parts.part[first] != usize::MAX {
                continue;
            }
            let own = parts.count;
            let (mut is_closed, mut is_mixed) = (true, false);
            parts.part[first] = own;
            open.push(first);
            while let Some(triangle) = open.pop() {
                is_closed &= !has_border[triangle];
                is_mixed |= parts.is_turned[triangle];
                for &(other, is_same) in &neighbours[triangle] {
                    let (other, turned) = (other as usize, parts.is_turned[triangle] != is_same);
                    if parts.part[other] == usize::MAX {
                        (parts.part[other], parts.is_turned[other]) = (own, turned);
                        open.push(other);
                    }
                    // A surface of one side, as a Möbius strip, has no outside.
                    is_closed &= parts.is_turned[other] == turned;
                }
            }
            parts.count += 1;
            parts.first.push(first);
            parts.is_closed.push(is_closed);
            parts.is_mixed.push(is_mixed);
        }
        parts
    }
}

/// Neighbours of each triangle over its edges that have two, and whether it has an edge of one triangle or more than two.
fn neighbours(triangles: &[[u32; 3]]) -> (Vec<Vec<Neighbour>>, Vec<bool>) {
    let mut edges: Vec<([u32; 2], u32, bool)> = (0_u32..)
        .zip(triangles)
        .flat_map(|(index, &[a, b, c])| {
            [[a, b], [b, c], [c, a]].map(|[from, to]| ([from.min(to), from.max(to)], index, from < to))
        })
        .collect();
    edges.sort_unstable();
    let mut found = vec![Vec::new(); triangles.len()];
    let mut has_border = vec![false; triangles.len()];
    for edge in edges.chunk_by(|(a, ..), (b, ..)| a == b) {
        if let &[(_, one, forth), (_, other, too)] = edge {
            found[one as usize].push((other, forth == too));
            found[other as usize].push((one, forth == too));
        } else {
            edge.iter().for_each(|&(_, triangle, _)| has_border[triangle as usize] = true);
        }
    }
    (found, has_border)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Stream;

    /// A tetrahedron at a place, of a size; a negative one looks inwards.
    fn tetrahedron(at: f32, size: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let mut triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        if size < 0.0 {
            triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        (corners.map(|p| p * size.abs() + Vec3::splat(at)).to_vec(), triangles)
    }

    fn both(
        (mut points, mut triangles): (Vec<Vec3>, Vec<[u32; 3]>),
        (more, others): (Vec<Vec3>, Vec<[u32; 3]>),
    ) -> Mesh {
        let from = points.len() as u32;
        points.extend(more);
        triangles.extend(others.into_iter().map(|corners| corners.map(|corner| corner + from)));
        Mesh { positions: points, triangles, ..Mesh::default() }
    }

    fn one((positions, triangles): (Vec<Vec3>, Vec<[u32; 3]>)) -> Mesh {
        Mesh { positions, triangles, ..Mesh::default() }
    }

    /// Every face of a tetrahedron about (0.25, 0.25, 0.25) looks away from there.
    fn looks_outwards(mesh: &Mesh) -> bool {
        mesh.triangles.iter().all(|corners| {
            let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
            (b - a).cross(c - a).dot(a - Vec3::splat(0.25)) > 0.0
        })
    }

    /// However the faces of a closed mesh are ordered, they are turned outwards; right ones stay as they are.
    #[test]
    fn any_order_of_a_closed_mesh_is_turned_outwards() {
        for pattern in 0_u32..16 {
            let mut mesh = one(tetrahedron(0.0, 1.0));
            let right = mesh.clone();
            for (bit, corners) in mesh.triangles.iter_mut().enumerate() {
                if pattern >> bit & 1 == 1 {
                    corners.swap(1, 2);
                }
            }
            let facing = Facing::of_mesh(&mesh);
            assert_eq!((facing.is_inside_out(), facing.is_open), (pattern > 0, false), "{pattern}");
            let turned = outwards(mesh);
            assert!(looks_outwards(&turned));
            assert_eq!(turned, right, "{pattern}");
        }
    }

    #[test]
    fn a_cavity_stays_one_and_is_turned_with_its_body() {
        let solid = both(tetrahedron(0.0, 1.0), tetrahedron(0.1, -0.2));
        assert!(!Facing::of_mesh(&solid).is_inside_out());
        let inside_out = both(tetrahedron(0.0, -1.0), tetrahedron(0.1, 0.2));
        assert_eq!(Facing::of_mesh(&inside_out).is_turned, [true; 8]);
        assert_eq!(outwards(inside_out), solid);
    }

    #[test]
    fn open_meshes_stay_as_they_are_and_bowls_tell_their_inside() {
        let (points, triangles) = tetrahedron(0.0, -1.0);
        // Without the face opposite to the origin it is a bowl that looks inwards.
        let bowl = one((points.clone(), triangles[..3].to_vec()));
        let facing = Facing::of_mesh(&bowl);
        assert_eq!((facing.is_inside_out(), facing.is_open, facing.is_hollow), (false, true, true));
        assert_eq!(outwards(bowl.clone()), bowl);
        let (points, triangles) = tetrahedron(0.0, 1.0);
        let dome = Facing::of_mesh(&one((points.clone(), triangles[..3].to_vec())));
        assert!(dome.is_open && !dome.is_hollow);
        let sheet = Facing::of_mesh(&one((points, triangles[..1].to_vec())));
        assert!(sheet.is_open && !sheet.is_hollow);
    }

    /// A band of five triangles whose ends are joined crosswise has one side only.
    #[test]
    fn a_surface_of_one_side_is_not_turned() {
        let band: Vec<[u32; 3]> = (0..5).map(|k| [k, (k + 1) % 5, (k + 2) % 5]).collect();
        let mut stream = Stream::new(4, &[]);
        let mut point = || Vec3::new(stream.unit() as f32, stream.unit() as f32, stream.unit() as f32);
        let mesh = one(((0..5).map(|_| point()).collect(), band));
        assert!(!Facing::of_mesh(&mesh).is_inside_out() && Facing::of_mesh(&mesh).is_open);
    }

    /// Normals go with the faces, whichever of both was wrong.
    #[test]
    fn normals_of_corners_go_with_the_faces() {
        for sign in [1.0, -1.0] {
            let mut mesh = one(tetrahedron(0.0, -1.0));
            let normal = |p: &Vec3| sign * (*p - Vec3::splat(0.25)).normalize();
            mesh.normals = mesh.positions.iter().map(normal).collect();
            let turned = outwards(mesh);
            let right = turned.positions.iter().zip(&turned.normals);
            assert!(right.clone().all(|(p, n)| n.dot(*p - Vec3::splat(0.25)) > 0.0), "{sign}");
        }
    }
}
