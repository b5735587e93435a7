//! What the hierarchy holds, and where rays meet it.

use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::ray::Ray;

use crate::scene::Object;
use crate::scene::geometry::RibbonNode;

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
    /// Triangle: three corners. Ribbon: −x and +x edge at the start, then at the end. Curve: both ends, both radii.
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

/// All primitives of a list of objects: of each the meshes', the ribbons' and the curves'.
pub(super) fn collect(objects: &[Object]) -> Vec<Primitive> {
    let mut primitives = Vec::with_capacity(objects.iter().map(|o| o.geometry.primitives()).sum());
    for (object, Object { geometry, .. }) in (0_u32..).zip(objects) {
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
            for (part, pair) in geometry.nodes_of_curve(curve).windows(2).enumerate() {
                let radii = Vec3::new(pair[0].radius, pair[1].radius, 0.0);
                add(Kind::Curve, shape, part, [pair[0].point, pair[1].point, radii, Vec3::ZERO]);
            }
        }
    }
    primitives
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
