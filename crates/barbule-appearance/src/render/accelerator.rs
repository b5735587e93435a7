//! Rays against a scene's shapes, through obvhs's compressed eight-wide hierarchy.
//!
//! Ribbons and curves enter as their segments, so leaves are split along the length, and slanting segments again. Each primitive is one cache line,
//! in the order of the hierarchy's leaves. Nothing is allocated per ray.

use fearless_simd::{Level, Simd, dispatch};
use glam::{DVec3, UVec2, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::ray::Ray;
use obvhs::{Boundable, BvhBuildParams};

use super::point::SurfacePoint;
use crate::math::rng::split_mix;
use crate::scene::frame::Frame;
use crate::scene::geometry::{Geometry, RibbonNode};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Triangle,
    Ribbon,
    Curve,
}

/// One triangle, ribbon segment or cone, with where it came from.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Primitive {
    /// Triangle: three corners. Ribbon: −x and +x edge at the start, then at the end. Curve: both ends, both radii.
    data: [Vec3; 4],
    kind: Kind,
    object: u32,
    part: u32,
}

impl Primitive {
    /// The box about the piece from `start` to `end`, fractions of its length; triangles have no pieces.
    fn aabb(&self, start: f32, end: f32) -> Aabb {
        let [a, b, c, d] = self.data;
        let (low, high) = match self.kind {
            Kind::Triangle => (a.min(b).min(c), a.max(b).max(c)),
            Kind::Ribbon => {
                // Across, both triangles meet on the diagonal.
                let at = |t: f32| [a.lerp(c, t), a.lerp(d, t), b.lerp(d, t)];
                let ([p, q, r], [s, t, u]) = (at(start), at(end));
                (p.min(q).min(r).min(s).min(t).min(u), p.max(q).max(r).max(s).max(t).max(u))
            }
            Kind::Curve => {
                let at = |t: f32| (a.lerp(b, t), c.x + (c.y - c.x) * t);
                let ((p, rp), (q, rq)) = (at(start), at(end));
                ((p - rp).min(q - rq), (p + rp).max(q + rq))
            }
        };
        // Flat boxes are missed by rays in their plane; a billionth of a metre is nothing to a feather.
        let pad = Vec3A::splat(1e-6);
        Aabb::new(Vec3A::from(low) - pad, Vec3A::from(high) + pad)
    }

    /// How many pieces to enter: the box about a slanting segment is mostly empty, and halves of it are less so.
    fn pieces(&self) -> u32 {
        if self.kind == Kind::Triangle {
            return 1;
        }
        let area = |count: u32| -> f32 { (0..count).map(|k| self.piece(k, count).half_area()).sum() };
        let (one, two, four) = (area(1), area(2), area(4));
        if four < WORTHWHILE * two {
            4
        } else if two < WORTHWHILE * one {
            2
        } else {
            1
        }
    }

    fn piece(&self, index: u32, count: u32) -> Aabb {
        self.aabb(index as f32 / count as f32, (index + 1) as f32 / count as f32)
    }
}

/// Boxes of twice as many pieces must shrink to this in total.
const WORTHWHILE: f32 = 0.75;

/// More primitives than this are entered whole, to save memory.
const MOST_IN_PIECES: usize = 2_000_000;

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

/// Where a ray met a primitive.
#[derive(Debug, Clone, Copy)]
struct Meeting {
    distance: f32,
    /// Triangle: barycentric coordinates of corners 1 and 2. Ribbon: 0 … 1 along the segment, −1 … 1 across.
    /// Curve: 0 … 1 along.
    u: f32,
    v: f32,
}

/// A hierarchy over all primitives of a scene.
pub struct Accelerator {
    hierarchy: CwBvh,
    primitives: Vec<Primitive>,
    level: Level,
}

impl Accelerator {
    /// Builds the hierarchy.
    #[must_use]
    pub fn new(geometry: &Geometry) -> Self {
        let primitives = collect(geometry);
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
        let mut time = std::time::Duration::ZERO;
        let hierarchy = build_cwbvh(&pieces, BvhBuildParams::slow_build(), &mut time);
        // A primitive of several pieces is stored with each of them.
        let primitives = hierarchy
            .primitive_indices
            .iter()
            .map(|&index| primitives[pieces[index as usize].primitive as usize])
            .collect();
        Self { hierarchy, primitives, level: Level::new() }
    }

    /// The nearest hit between `nearest` and `farthest`, mm along the unit direction.
    #[must_use]
    pub fn hit(
        &self,
        geometry: &Geometry,
        origin: DVec3,
        direction: DVec3,
        nearest: f64,
        farthest: f64,
    ) -> Option<SurfacePoint> {
        if self.primitives.is_empty() {
            return None;
        }
        let ray = ray(origin, direction, nearest, farthest);
        let (index, meeting) = dispatch!(self.level, simd => self.first(simd, ray))?;
        Some(self.point(geometry, index, meeting, origin, direction))
    }

    /// Whether anything stands between `nearest` and `farthest`.
    #[must_use]
    pub fn is_blocked(&self, origin: DVec3, direction: DVec3, nearest: f64, farthest: f64) -> bool {
        if self.primitives.is_empty() {
            return false;
        }
        let ray = ray(origin, direction, nearest, farthest);
        dispatch!(self.level, simd => self.any(simd, ray))
    }

    /// The nearest hit. Compiled for each instruction set: traversal counts and finds bits.
    #[inline(always)]
    fn first<S: Simd>(&self, _simd: S, mut ray: Ray) -> Option<(u32, Meeting)> {
        let mut best = None;
        let mut state = self.hierarchy.new_traversal(ray.direction);
        let mut node;
        obvhs::traverse!(self.hierarchy, node, state, node.intersect_ray(&ray, state.oct_inv4), {
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
        obvhs::traverse!(self.hierarchy, node, state, node.intersect_ray(&ray, state.oct_inv4), {
            if meet(&self.primitives[state.primitive_id as usize], &ray).is_some() {
                return true;
            }
        });
        false
    }

    fn point(
        &self,
        geometry: &Geometry,
        index: u32,
        at: Meeting,
        origin: DVec3,
        direction: DVec3,
    ) -> SurfacePoint {
        let primitive = &self.primitives[index as usize];
        let mut point = match primitive.kind {
            Kind::Triangle => triangle_point(geometry, primitive, at),
            Kind::Ribbon => ribbon_point(geometry, primitive, at),
            Kind::Curve => curve_point(geometry, primitive, at, origin, direction),
        };
        point.primitive = index;
        point.distance = f64::from(at.distance);
        point
    }
}

fn ray(origin: DVec3, direction: DVec3, nearest: f64, farthest: f64) -> Ray {
    let (o, d) = (origin.as_vec3(), direction.as_vec3());
    Ray::new(Vec3A::from(o), Vec3A::from(d), nearest as f32, farthest.min(1e30) as f32)
}

fn collect(geometry: &Geometry) -> Vec<Primitive> {
    let mut primitives = Vec::with_capacity(geometry.primitives());
    for (object, mesh) in geometry.meshes.iter().enumerate() {
        for (part, corners) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
            let data = [a, b, c, Vec3::ZERO];
            primitives.push(Primitive {
                data,
                kind: Kind::Triangle,
                object: object as u32,
                part: part as u32,
            });
        }
    }
    for (object, ribbon) in geometry.ribbons.iter().enumerate() {
        for (part, pair) in geometry.nodes_of(ribbon).windows(2).enumerate() {
            let edges = |n: &RibbonNode| (n.point - n.across, n.point + n.across);
            let ((a, b), (c, d)) = (edges(&pair[0]), edges(&pair[1]));
            let data = [a, b, c, d];
            primitives.push(Primitive { data, kind: Kind::Ribbon, object: object as u32, part: part as u32 });
        }
    }
    for (object, curve) in geometry.curves.iter().enumerate() {
        let nodes = &geometry.curve_nodes[curve.first as usize..(curve.first + curve.count) as usize];
        for (part, pair) in nodes.windows(2).enumerate() {
            let radii = Vec3::new(pair[0].radius, pair[1].radius, 0.0);
            let data = [pair[0].point, pair[1].point, radii, Vec3::ZERO];
            primitives.push(Primitive { data, kind: Kind::Curve, object: object as u32, part: part as u32 });
        }
    }
    primitives
}

#[inline(always)]
fn meet(primitive: &Primitive, ray: &Ray) -> Option<Meeting> {
    let [a, b, c, d] = primitive.data;
    match primitive.kind {
        Kind::Triangle => {
            let (distance, u, v) = triangle(ray, a, b, c)?;
            Some(Meeting { distance, u, v })
        }
        Kind::Ribbon => {
            // The diagonal from the −x edge at the start to the +x edge at the end cuts the patch in two.
            if let Some((distance, u, v)) = triangle(ray, a, b, d) {
                return Some(Meeting { distance, u: v, v: 2.0 * (u + v) - 1.0 });
            }
            let (distance, u, v) = triangle(ray, a, d, c)?;
            Some(Meeting { distance, u: u + v, v: 2.0 * u - 1.0 })
        }
        Kind::Curve if passes_by(ray, a, b, c.x.max(c.y)) => None,
        Kind::Curve => cone(ray, a, b, c.x, c.y),
    }
}

/// Whether a ray's line surely passes the axis' line at more than the radius; most do. Rounding is allowed for.
#[inline(always)]
fn passes_by(ray: &Ray, a: Vec3, b: Vec3, radius: f32) -> bool {
    let to = a - Vec3::from(ray.origin);
    let normal = (b - a).cross(Vec3::from(ray.direction));
    let reach = 1.01 * radius + 1e-6 * to.length();
    let apart = to.dot(normal);
    apart * apart > reach * reach * normal.length_squared()
}

/// Möller and Trumbore 1997, both sides.
#[inline(always)]
fn triangle(ray: &Ray, a: Vec3, b: Vec3, c: Vec3) -> Option<(f32, f32, f32)> {
    let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let inverse = 1.0 / determinant;
    let s = origin - a;
    let u = s.dot(p) * inverse;
    if !(0.0..=1.0).contains(&u) {
        return None;
    }
    let q = s.cross(ab);
    let v = direction.dot(q) * inverse;
    if v < 0.0 || u + v > 1.0 {
        return None;
    }
    let t = ac.dot(q) * inverse;
    (t > ray.tmin && t < ray.tmax).then_some((t, u, v))
}

/// A cone between two spheres (the convex hull of both), in double precision about the ray's point nearest to it.
fn cone(ray: &Ray, a: Vec3, b: Vec3, radius_a: f32, radius_b: f32) -> Option<Meeting> {
    let direction = Vec3::from(ray.direction).as_dvec3();
    let origin = Vec3::from(ray.origin).as_dvec3();
    let (a, b) = (a.as_dvec3(), b.as_dvec3());
    let (ra, rb) = (f64::from(radius_a), f64::from(radius_b));
    let near = (0.5 * (a + b) - origin).dot(direction);
    let start = origin + direction * near;
    let (ba, oa) = (b - a, start - a);
    let rr = ra - rb;
    let m0 = ba.dot(ba);
    let d2 = m0 - rr * rr;
    let (m1, m2, m3) = (ba.dot(oa), ba.dot(direction), direction.dot(oa));
    let accept = |t: f64, u: f64| {
        let distance = (near + t) as f32;
        (distance > ray.tmin && distance < ray.tmax).then_some(Meeting { distance, u: u as f32, v: 0.0 })
    };
    if d2 > 0.0 {
        let k2 = d2 - m2 * m2;
        let k1 = d2 * m3 - m1 * m2 + m2 * rr * ra;
        let k0 = d2 * oa.dot(oa) - m1 * m1 + 2.0 * m1 * rr * ra - m0 * ra * ra;
        let h = k1 * k1 - k0 * k2;
        if h >= 0.0 && k2.abs() > 1e-18 {
            let t = (-h.sqrt() - k1) / k2;
            let y = m1 - ra * rr + t * m2;
            if y > 0.0 && y < d2 {
                return accept(t, y / d2);
            }
        }
    }
    // The round ends, from outside.
    let end = |centre: DVec3, radius: f64| {
        let to = start - centre;
        let along = to.dot(direction);
        let h = along * along - to.dot(to) + radius * radius;
        (h > 0.0).then(|| -along - h.sqrt())
    };
    match (end(a, ra), end(b, rb)) {
        (Some(ta), Some(tb)) if tb < ta => accept(tb, 1.0),
        (Some(ta), _) => accept(ta, 0.0),
        (None, Some(tb)) => accept(tb, 1.0),
        (None, None) => None,
    }
}

fn triangle_point(geometry: &Geometry, primitive: &Primitive, at: Meeting) -> SurfacePoint {
    let mesh = &geometry.meshes[primitive.object as usize];
    let corners = mesh.triangles[primitive.part as usize].map(|c| c as usize);
    let weights = [1.0 - at.u - at.v, at.u, at.v];
    let mix = |values: &[Vec3]| -> Vec3 { corners.iter().zip(weights).map(|(&c, w)| values[c] * w).sum() };
    let [a, b, c, _] = primitive.data;
    let normal = (b - a).cross(c - a).as_dvec3().normalize_or(DVec3::Z);
    let shading =
        if mesh.normals.is_empty() { normal } else { mix(&mesh.normals).as_dvec3().normalize_or(normal) };
    let along = if mesh.tangents.is_empty() { (b - a).as_dvec3() } else { mix(&mesh.tangents).as_dvec3() };
    let uv = if mesh.uvs.is_empty() {
        [f64::from(at.u), f64::from(at.v)]
    } else {
        let uv: glam::Vec2 = corners.iter().zip(weights).map(|(&c, w)| mesh.uvs[c] * w).sum();
        [f64::from(uv.x), f64::from(uv.y)]
    };
    SurfacePoint {
        position: (a * weights[0] + b * weights[1] + c * weights[2]).as_dvec3(),
        normal,
        frame: Frame::new(shading, along),
        uv,
        surface: mesh.surface,
        object: mesh.id,
        instance: mesh.id,
        ..SurfacePoint::default()
    }
}

fn ribbon_point(geometry: &Geometry, primitive: &Primitive, at: Meeting) -> SurfacePoint {
    let ribbon = &geometry.ribbons[primitive.object as usize];
    let nodes = geometry.nodes_of(ribbon);
    let part = primitive.part as usize;
    let (start, end) = (&nodes[part], &nodes[part + 1]);
    // Tangents at nodes are central differences, so the frame turns smoothly along the ribbon.
    let tangent = |i: usize| {
        let (low, high) = (i.saturating_sub(1), (i + 1).min(nodes.len() - 1));
        (nodes[high].point - nodes[low].point).normalize_or(Vec3::Y)
    };
    let u = at.u;
    let along = tangent(part).lerp(tangent(part + 1), u).as_dvec3().normalize_or(DVec3::Y);
    let across = start.across.normalize_or(Vec3::X).lerp(end.across.normalize_or(Vec3::X), u).as_dvec3();
    let z = across.cross(along).normalize_or(DVec3::Z);
    let frame = Frame { x: along.cross(z), y: along, z };
    let [a, b, c, d] = primitive.data;
    let flat = if at.v > 2.0 * u - 1.0 { (b - a).cross(d - a) } else { (d - a).cross(c - a) };
    let arc = f64::from(start.arc + (end.arc - start.arc) * u);
    let place = if ribbon.cell > 0.0 { arc / f64::from(ribbon.cell) + f64::from(ribbon.phase) } else { 0.5 };
    let cell = place.floor();
    let (sin, cos) = (f64::from(ribbon.swelling) * (1.0 - 2.0 * (place - cell))).sin_cos();
    let frame = Frame { x: frame.x, y: frame.y * cos + frame.z * sin, z: frame.z * cos - frame.y * sin };
    let (w, half) = (u, 0.5 * (at.v + 1.0));
    let position = (a * (1.0 - half) + b * half) * (1.0 - w) + (c * (1.0 - half) + d * half) * w;
    SurfacePoint {
        position: position.as_dvec3(),
        normal: flat.as_dvec3().normalize_or(z),
        frame,
        uv: [arc, f64::from(at.v)],
        surface: ribbon.surface,
        object: ribbon.id,
        instance: split_mix(ribbon.id ^ split_mix(cell as u64)),
        ..SurfacePoint::default()
    }
}

fn curve_point(
    geometry: &Geometry,
    primitive: &Primitive,
    at: Meeting,
    origin: DVec3,
    direction: DVec3,
) -> SurfacePoint {
    let curve = &geometry.curves[primitive.object as usize];
    let [a, b, radii, _] = primitive.data;
    let axis = (b - a).as_dvec3();
    let position = origin + direction * f64::from(at.distance);
    let u = f64::from(at.u);
    let centre = a.as_dvec3() + axis * u;
    let radius = f64::from(radii.x) + f64::from(radii.y - radii.x) * u;
    // Of a cone the normal points from the axis point where the touching sphere has its centre; `u` is that point.
    let normal = (position - centre).normalize_or(-direction);
    let offset = axis.normalize_or(DVec3::Y).cross(direction).normalize_or(DVec3::X).dot(position - centre);
    SurfacePoint {
        position,
        normal,
        frame: Frame::new(normal, axis),
        uv: [
            (f64::from(primitive.part) + u) / f64::from(curve.count - 1),
            (offset / radius).clamp(-1.0, 1.0),
        ],
        surface: curve.surface,
        object: curve.id,
        instance: curve.id,
        ..SurfacePoint::default()
    }
}
