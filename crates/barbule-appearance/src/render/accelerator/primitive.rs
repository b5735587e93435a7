//! What the hierarchy holds, and where rays meet it.

use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::ray::Ray;

use crate::scene::geometry::{Geometry, RibbonNode};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Triangle,
    Ribbon,
    Curve,
}

/// One triangle, ribbon segment or cone, with where it came from.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Primitive {
    /// Triangle: three corners. Ribbon: −x and +x edge at the start, then at the end. Curve: both ends, both radii, and
    /// the directions of the segments before and after, packed.
    pub(super) data: [Vec3; 4],
    pub(super) kind: Kind,
    /// Index of its object.
    pub(super) object: u32,
    /// Index of the mesh, ribbon or curve in the object.
    pub(super) shape: u32,
    /// Index of the triangle or segment in the shape.
    pub(super) part: u32,
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
    pub(super) fn pieces(&self) -> u32 {
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

    pub(super) fn piece(&self, index: u32, count: u32) -> Aabb {
        self.aabb(index as f32 / count as f32, (index + 1) as f32 / count as f32)
    }
}

/// Boxes of twice as many pieces must shrink to this in total.
const WORTHWHILE: f32 = 0.75;

/// Where a ray met a primitive.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meeting {
    pub(super) distance: f32,
    /// Triangle: barycentric coordinates of corners 1 and 2. Ribbon: 0 … 1 along the segment, −1 … 1 across.
    /// Curve: 0 … 1 along.
    pub(super) u: f32,
    pub(super) v: f32,
}

/// All primitives of geometries with the indices of their objects: of each the meshes', the ribbons' and the curves'. What repeats is
/// left out.
pub(super) fn collect<'a>(geometries: impl IntoIterator<Item = (u32, &'a Geometry)>) -> Vec<Primitive> {
    let mut primitives = Vec::new();
    for (object, geometry) in geometries {
        primitives.reserve(geometry.primitives());
        let mut add = |kind, shape: usize, part: usize, data| {
            primitives.push(Primitive { data, kind, object, shape: shape as u32, part: part as u32 });
        };
        for (shape, mesh) in geometry.meshes.iter().enumerate() {
            for (part, corners) in mesh.triangles.iter().enumerate() {
                let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
                add(Kind::Triangle, shape, part, [a, b, c, Vec3::ZERO]);
            }
        }
        for (shape, ribbon) in geometry.ribbons.iter().enumerate() {
            for (part, pair) in geometry.nodes_of(ribbon).windows(2).enumerate() {
                let edges = |n: &RibbonNode| (n.point - n.across, n.point + n.across);
                let ((a, b), (c, d)) = (edges(&pair[0]), edges(&pair[1]));
                add(Kind::Ribbon, shape, part, [a, b, c, d]);
            }
        }
        for (shape, curve) in geometry.curves.iter().enumerate() {
            let nodes = geometry.nodes_of_curve(curve);
            let direction = |from: usize| {
                let along = nodes.get(from + 1).map(|next| next.point - nodes[from].point);
                pack(along.map_or(Vec3::ZERO, Vec3::normalize_or_zero))
            };
            for (part, pair) in nodes.windows(2).enumerate() {
                let before = if part == 0 { NO_NEIGHBOUR } else { direction(part - 1) };
                let after = direction(part + 1);
                let ends = Vec3::new(pair[0].radius, pair[1].radius, before[0]);
                let rest = Vec3::new(before[1], after[0], after[1]);
                add(Kind::Curve, shape, part, [pair[0].point, pair[1].point, ends, rest]);
            }
        }
    }
    primitives
}

/// Where a curve has no further segment.
const NO_NEIGHBOUR: [f32; 2] = [2.0; 2];

/// A unit vector in two numbers: the octahedron |x| + |y| + |z| = 1 with its lower half unfolded (Meyer et al. 2010). The
/// zero vector is no neighbour.
fn pack(v: Vec3) -> [f32; 2] {
    let sum = v.abs().element_sum();
    if sum == 0.0 {
        return NO_NEIGHBOUR;
    }
    let (x, y) = (v.x / sum, v.y / sum);
    if v.z >= 0.0 { [x, y] } else { [(1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)] }
}

/// The vector that was packed, not of unit length; `None` where there is no neighbour.
fn unpack([x, y]: [f32; 2]) -> Option<DVec3> {
    if [x, y] == NO_NEIGHBOUR {
        return None;
    }
    let z = 1.0 - x.abs() - y.abs();
    let v = if z >= 0.0 { [x, y, z] } else { [(1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y), z] };
    Some(Vec3::from_array(v).as_dvec3())
}

/// Where a ray meets a primitive, if it does.
#[inline(always)]
pub(super) fn meet(primitive: &Primitive, ray: &Ray) -> Option<Meeting> {
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
        Kind::Curve => cone(ray, a, b, [c.x, c.y], [[c.z, d.x], [d.y, d.z]]),
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

/// A cone between two spheres (the convex hull of both), from outside, in double precision about the ray's point nearest to
/// it. What of the spheres lies inside the cone or inside a neighbouring segment is no wall: fibres are solid, and light
/// that goes through one meets nothing in it.
fn cone(ray: &Ray, a: Vec3, b: Vec3, radii: [f32; 2], neighbours: [[f32; 2]; 2]) -> Option<Meeting> {
    let direction = Vec3::from(ray.direction).as_dvec3();
    let origin = Vec3::from(ray.origin).as_dvec3();
    let (a, b) = (a.as_dvec3(), b.as_dvec3());
    let (ra, rb) = (f64::from(radii[0]), f64::from(radii[1]));
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
    // The round ends: beyond the circle in which cone and sphere touch, and not in the neighbour.
    let end = |centre: DVec3, radius: f64, outward: DVec3, least: f64, neighbour: Option<DVec3>| {
        let to = start - centre;
        let along = to.dot(direction);
        let h = along * along - to.dot(to) + radius * radius;
        if h <= 0.0 {
            return None;
        }
        let t = -along - h.sqrt();
        let from = to + direction * t;
        let is_wall = from.dot(outward) >= least && neighbour.is_none_or(|inward| from.dot(inward) <= 0.0);
        is_wall.then_some(t)
    };
    let [before, after] = neighbours.map(unpack);
    let end_a = end(a, ra, -ba, -ra * rr, before.map(|direction| -direction));
    let end_b = end(b, rb, ba, rb * rr, after);
    match (end_a, end_b) {
        (Some(ta), Some(tb)) if tb < ta => accept(tb, 1.0),
        (Some(ta), _) => accept(ta, 0.0),
        (None, Some(tb)) => accept(tb, 1.0),
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Stream;
    use crate::scene::geometry::{CurveNode, Geometry};

    /// Distance from the surface of a cone between two spheres, negative inside (least distance to the spheres between).
    fn distance(point: DVec3, a: &CurveNode, b: &CurveNode) -> f64 {
        let (from, to) = (a.point.as_dvec3(), b.point.as_dvec3());
        let of = |t: f64| {
            (point - from.lerp(to, t)).length() - f64::from(a.radius) - f64::from(b.radius - a.radius) * t
        };
        (0..=400).map(|i| of(f64::from(i) / 400.0)).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn directions_come_back_from_their_packing() {
        let mut stream = Stream::new(51, &[]);
        for _ in 0..1000 {
            let v =
                Vec3::new(stream.normal() as f32, stream.normal() as f32, stream.normal() as f32).normalize();
            let back = unpack(pack(v)).unwrap().normalize();
            assert!((back - v.as_dvec3()).length() < 1e-6);
        }
        assert!(unpack(pack(Vec3::ZERO)).is_none() && unpack(pack(Vec3::NEG_Z)).is_some());
    }

    /// A bent, tapering fibre: rays that start inside meet no wall, and rays from outside meet it where it begins.
    #[test]
    fn fibres_are_solid() {
        let nodes: Vec<CurveNode> = (0..9)
            .map(|k| {
                let t = k as f32;
                let point = Vec3::new((0.4 * t).sin(), 0.5 * t, 0.3 * (0.9 * t).cos());
                CurveNode { point, radius: 0.2 - 0.015 * t, ..CurveNode::default() }
            })
            .collect();
        let mut geometry = Geometry::default();
        geometry.add_curve(&nodes, 1);
        let primitives = collect([(0, &geometry)]);
        let inside = |point: DVec3| {
            nodes.windows(2).map(|pair| distance(point, &pair[0], &pair[1])).fold(f64::INFINITY, f64::min)
        };
        let mut stream = Stream::new(52, &[]);
        let (mut walls, mut outer) = (0, 0);
        for _ in 0..4000 {
            let part = (stream.unit() * 8.0) as usize;
            let (a, b, t) = (nodes[part], nodes[part + 1], stream.unit());
            let jitter = DVec3::new(stream.normal(), stream.normal(), stream.normal()).normalize();
            let radius = f64::from(a.radius.min(b.radius)) * stream.unit();
            let origin = a.point.as_dvec3().lerp(b.point.as_dvec3(), t) + jitter * radius;
            let direction = DVec3::new(stream.normal(), stream.normal(), stream.normal()).normalize();
            let first = |origin: DVec3| {
                let to = |v: DVec3| Vec3A::from(v.as_vec3());
                let ray = Ray::new(to(origin), to(direction), 1e-5, 1e30);
                let hits = primitives.iter().filter_map(|primitive| meet(primitive, &ray));
                hits.map(|meeting| f64::from(meeting.distance)).fold(f64::INFINITY, f64::min)
            };
            let found = first(origin);
            // Whatever is met lies behind a gap, as seen from inside: half way there is outside, or some of the way.
            if found.is_finite() {
                let gap =
                    (1..100).any(|i| inside(origin + direction * (found * f64::from(i) / 100.0)) > 1e-4);
                walls += usize::from(!gap && found > 0.02);
            }
            let far = origin - direction * 10.0;
            let met = first(far);
            assert!(met < 10.0);
            outer += usize::from(inside(far + direction * met).abs() > 1e-3);
        }
        // One ray in 4,000 meets the next cone's side on the hollow side of these bends of 0.4 rad; if ends were whole
        // spheres it would be one in twelve.
        assert!(walls <= 4 && outer == 0, "{walls} inner walls, {outer} misplaced hits");
    }
}
