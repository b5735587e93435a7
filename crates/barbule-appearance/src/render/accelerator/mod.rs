//! Rays against a scene's shapes, through obvhs's compressed eight-wide hierarchy.
//!
//! Ribbons and curves enter as their segments, so leaves are split along the length, and slanting segments again. Each primitive is one cache line,
//! in the order of the hierarchy's leaves. Nothing is allocated per ray.

mod beam;
mod boxes;
mod build;
mod hits;
mod instances;
mod primitive;

use fearless_simd::{Level, Simd};
use glam::{DVec3, UVec2, Vec3A};
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::ray::Ray;

pub(super) use beam::Beam;
use boxes::crossed;
pub(super) use instances::Instances;
use primitive::{Meeting, Primitive, collect, meet};

use crate::bsdf::Hit;
use crate::math::simd::dispatch_large;
use crate::scene::Object;
use crate::scene::geometry::Geometry;
use crate::scene::memory::MOST_IN_PIECES;

/// What the hierarchy is built of: the box about a piece of a primitive.
struct Piece {
    aabb: Aabb,
    primitive: u32,
}

impl Boundable for Piece {
    fn aabb(&self) -> Aabb {
        self.aabb
    }
}

/// A hierarchy over all primitives of a list of objects.
pub(super) struct Accelerator {
    hierarchy: CwBvh,
    primitives: Vec<Primitive>,
    level: Level,
}

impl Accelerator {
    /// Builds the hierarchy of those of a list of objects that stand where they were made.
    #[must_use]
    pub(super) fn new(objects: &[Object]) -> Self {
        let geometries = (0..).zip(objects.iter().map(|object| &object.geometry));
        Self::of(geometries.filter(|(_, geometry)| geometry.places.is_empty()))
    }

    /// Builds the hierarchy of geometries with the indices of their objects.
    fn of<'a>(geometries: impl Iterator<Item = (u32, &'a Geometry)>) -> Self {
        let primitives = collect(geometries);
        if primitives.is_empty() {
            return Self { hierarchy: CwBvh::default(), primitives, level: Level::new() };
        }
        let whole = primitives.len() > MOST_IN_PIECES;
        let pieces: Vec<Piece> = (0_u32..)
            .zip(&primitives)
            .flat_map(|(index, primitive)| {
                let count = if whole { 1 } else { primitive.pieces() };
                (0..count).map(move |k| Piece { aabb: primitive.piece(k, count), primitive: index })
            })
            .collect();
        let hierarchy = build::hierarchy(&pieces);
        // A primitive of several pieces is stored with each of them.
        let primitives = hierarchy
            .primitive_indices
            .iter()
            .map(|&index| primitives[pieces[index as usize].primitive as usize])
            .collect();
        Self { hierarchy, primitives, level: Level::new() }
    }

    /// Bytes of nodes and primitives.
    #[must_use]
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.hierarchy.nodes[..]) + size_of_val(&self.primitives[..])
    }

    /// The nearest hit between `nearest` and `farthest`, mm along the unit direction.
    #[must_use]
    pub(super) fn hit(
        &self,
        objects: &[Object],
        origin: DVec3,
        direction: DVec3,
        nearest: f64,
        farthest: f64,
    ) -> Option<Hit> {
        if self.primitives.is_empty() {
            return None;
        }
        let ray = ray(origin, direction, nearest, farthest);
        let (index, meeting) = dispatch_large!(self.level, simd => self.first(simd, ray))?;
        let primitive = &self.primitives[index as usize];
        let geometry = &objects[primitive.object as usize].geometry;
        Some(Hit {
            object: primitive.object,
            primitive: index,
            distance: f64::from(meeting.distance),
            ..hits::hit(geometry, primitive, meeting, origin, direction)
        })
    }

    /// Whether anything stands between `nearest` and `farthest`.
    #[must_use]
    pub(super) fn is_blocked(&self, origin: DVec3, direction: DVec3, nearest: f64, farthest: f64) -> bool {
        if self.primitives.is_empty() {
            return false;
        }
        let ray = ray(origin, direction, nearest, farthest);
        dispatch_large!(self.level, simd => self.any(simd, ray))
    }

    /// Whether a ray of a beam may meet anything; where not, none does.
    #[must_use]
    pub(super) fn may_meet(&self, beam: &Beam) -> bool {
        !self.primitives.is_empty() && enters(&self.hierarchy, beam)
    }

    /// The nearest hit. Compiled for each instruction set: traversal counts and finds bits.
    #[inline(always)]
    fn first<S: Simd>(&self, _simd: S, mut ray: Ray) -> Option<(u32, Meeting)> {
        let mut best = None;
        let mut state = self.hierarchy.new_traversal(ray.direction);
        let mut node;
        obvhs::traverse!(self.hierarchy, node, state, crossed(node, &ray, state.oct_inv4), {
            if let Some(meeting) = meet(&self.primitives[state.primitive_id as usize], &ray) {
                ray.tmax = meeting.distance;
                best = Some((state.primitive_id, meeting));
            }
        });
        best
    }

    #[inline(always)]
    fn any<S: Simd>(&self, _simd: S, ray: Ray) -> bool {
        let mut state = self.hierarchy.new_traversal(ray.direction);
        let mut node;
        obvhs::traverse!(self.hierarchy, node, state, crossed(node, &ray, state.oct_inv4), {
            if meet(&self.primitives[state.primitive_id as usize], &ray).is_some() {
                return true;
            }
        });
        false
    }
}

/// Whether a ray of a beam may cross the box of a leaf.
fn enters(hierarchy: &CwBvh, beam: &Beam) -> bool {
    let mut state = hierarchy.new_traversal(beam.middle());
    let mut node;
    obvhs::traverse!(hierarchy, node, state, beam.crossed(node, state.oct_inv4), {
        return true;
    });
    false
}

fn ray(origin: DVec3, direction: DVec3, nearest: f64, farthest: f64) -> Ray {
    let (o, d) = (origin.as_vec3(), direction.as_vec3());
    Ray::new(Vec3A::from(o), Vec3A::from(d), nearest as f32, farthest.min(1e30) as f32)
}
