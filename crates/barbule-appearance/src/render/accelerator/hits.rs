//! Hits: position, normals, frame and identities where a ray met a primitive.

use glam::{DVec3, Vec2, Vec3};

use super::primitive::{Kind, Meeting, Primitive};
use crate::bsdf::{Frame, Hit, OnRibbon};
use crate::math::rng::split_mix;
use crate::scene::geometry::{Geometry, RibbonNode};

/// The hit on a primitive of a geometry; its object and place in the hierarchy are the caller's.
pub(super) fn hit(
    geometry: &Geometry,
    primitive: &Primitive,
    at: Meeting,
    origin: DVec3,
    direction: DVec3,
) -> Hit {
    match primitive.kind {
        Kind::Triangle => on_triangle(geometry, primitive, at),
        Kind::Ribbon => on_ribbon(geometry, primitive, at),
        Kind::Curve => on_curve(geometry, primitive, at, origin, direction),
    }
}

fn on_triangle(geometry: &Geometry, primitive: &Primitive, at: Meeting) -> Hit {
    let mesh = &geometry.meshes[primitive.shape as usize];
    let corners = mesh.triangles[primitive.part as usize].map(|c| c as usize);
    let weights = [1.0 - at.u - at.v, at.u, at.v];
    let mix = |values: &[Vec3]| -> Vec3 { corners.iter().zip(weights).map(|(&c, w)| values[c] * w).sum() };
    let [a, b, c, _] = primitive.data;
    let normal = (b - a).cross(c - a).as_dvec3().normalize_or(DVec3::Z);
    let shading =
        if mesh.normals.is_empty() { normal } else { mix(&mesh.normals).as_dvec3().normalize_or(normal) };
    let along = if mesh.tangents.is_empty() { (b - a).as_dvec3() } else { mix(&mesh.tangents).as_dvec3() };
    let uvs = if mesh.uvs.is_empty() { [Vec2::ZERO, Vec2::X, Vec2::Y] } else { corners.map(|c| mesh.uvs[c]) };
    let uv: Vec2 = uvs.iter().zip(weights).map(|(&uv, w)| uv * w).sum();
    Hit {
        position: (a * weights[0] + b * weights[1] + c * weights[2]).as_dvec3(),
        normal,
        vane_normal: shading,
        frame: Frame::new(shading, along),
        uv: [f64::from(uv.x), f64::from(uv.y)],
        uv_gradients: uv_gradients((b - a).as_dvec3(), (c - a).as_dvec3(), uvs),
        id: mesh.id,
        instance: mesh.id,
        ..Hit::default()
    }
}

/// How fast texture coordinates grow over a triangle of these edges, 1/mm: they are linear in the barycentric coordinates, whose
/// gradients are (q × n)/n² and (n × p)/n² with n = p × q.
fn uv_gradients(p: DVec3, q: DVec3, [a, b, c]: [Vec2; 3]) -> [DVec3; 2] {
    let n = p.cross(q);
    let scale = 1.0 / n.length_squared().max(f64::MIN_POSITIVE);
    let (along_p, along_q) = (q.cross(n) * scale, n.cross(p) * scale);
    let (s, t) = ((b - a).as_dvec2(), (c - a).as_dvec2());
    [along_p * s.x + along_q * t.x, along_p * s.y + along_q * t.y]
}

fn on_ribbon(geometry: &Geometry, primitive: &Primitive, at: Meeting) -> Hit {
    let ribbon = &geometry.ribbons[primitive.shape as usize];
    let nodes = geometry.nodes_of(ribbon);
    let part = primitive.part as usize;
    let (start, end) = (&nodes[part], &nodes[part + 1]);
    let u = at.u;
    let tangent = |i: usize| RibbonNode::tangent(nodes, i);
    let along = tangent(part).lerp(tangent(part + 1), u).as_dvec3().normalize_or(DVec3::Y);
    let across = start.across.normalize_or(Vec3::X).lerp(end.across.normalize_or(Vec3::X), u).as_dvec3();
    let z = across.cross(along).normalize_or(DVec3::Z);
    let frame = Frame { x: along.cross(z), y: along, z };
    let [a, b, c, d] = primitive.data;
    // Rays meet two triangles. Where the ribbon tapers u and v are linear in each, and not over both together.
    let half = 0.5 * (at.v + 1.0);
    let (flat, position) = if half > u {
        ((b - a).cross(d - a), a * (1.0 - half) + b * (half - u) + d * u)
    } else {
        ((d - a).cross(c - a), a * (1.0 - u) + d * half + c * (u - half))
    };
    let arc = f64::from(start.arc + (end.arc - start.arc) * u);
    let place = if ribbon.cell > 0.0 { arc / f64::from(ribbon.cell) + f64::from(ribbon.phase) } else { 0.5 };
    let cell = place.floor();
    let frame = frame.pitched(f64::from(ribbon.swelling) * (1.0 - 2.0 * (place - cell)));
    Hit {
        position: position.as_dvec3(),
        normal: flat.as_dvec3().normalize_or(z),
        vane_normal: frame.z,
        frame,
        uv: [arc, f64::from(at.v)],
        ribbon: OnRibbon {
            half_width: f64::from(start.across.length() * (1.0 - u) + end.across.length() * u),
            cell: cell as u64,
            place: place - cell,
            cell_length: f64::from(ribbon.cell),
            station: f64::from(ribbon.station),
            contrast: 1.0,
        },
        id: ribbon.id,
        instance: split_mix(ribbon.id ^ split_mix(cell as u64)),
        ..Hit::default()
    }
}

fn on_curve(geometry: &Geometry, primitive: &Primitive, at: Meeting, origin: DVec3, direction: DVec3) -> Hit {
    let curve = &geometry.curves[primitive.shape as usize];
    let [a, b, radii, _] = primitive.data;
    let axis = (b - a).as_dvec3();
    let position = origin + direction * f64::from(at.distance);
    let u = f64::from(at.u);
    let centre = a.as_dvec3() + axis * u;
    let radius = f64::from(radii.x) + f64::from(radii.y - radii.x) * u;
    // Of a cone the normal points from the axis point where the touching sphere has its centre; `u` is that point.
    let normal = (position - centre).normalize_or(-direction);
    let offset = axis.normalize_or(DVec3::Y).cross(direction).normalize_or(DVec3::X).dot(position - centre);
    let nodes = geometry.nodes_of_curve(curve);
    let part = primitive.part as usize;
    let vane_normal = nodes[part].vane_normal.lerp(nodes[part + 1].vane_normal, at.u);
    Hit {
        position,
        normal,
        vane_normal: vane_normal.as_dvec3().normalize_or(normal),
        frame: Frame::new(normal, axis),
        uv: [
            (f64::from(primitive.part) + u) / f64::from(curve.count - 1),
            (offset / radius).clamp(-1.0, 1.0),
        ],
        id: curve.id,
        instance: curve.id,
        ..Hit::default()
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;
    use obvhs::ray::Ray;

    use super::*;
    use crate::bsdf::{Lambertian, Reflectance, Surface};
    use crate::math::rng::Stream;
    use crate::render::accelerator::primitive::{collect, meet};
    use crate::scene::Object;
    use crate::scene::geometry::{CurveNode, Ribbon};

    /// The coordinate across a fibre is where its frame sees the viewer: hair takes the ray's offset from the frame. Rays
    /// are in single precision.
    #[test]
    fn offsets_across_a_fibre_are_those_of_its_frame() {
        let mut geometry = Geometry::default();
        let node = |point: Vec3| CurveNode { point, radius: 0.1, ..CurveNode::default() };
        geometry.add_curve(&[node(Vec3::new(-1.0, -2.0, 0.5)), node(Vec3::new(1.0, 2.0, -0.5))], 1);
        let surface = Surface::Lambertian(Lambertian::new(Reflectance::new(|_| 1.0).unwrap()));
        let objects = [Object { geometry, surface }];
        let primitives = collect([(0, &objects[0].geometry)]);
        let mut stream = Stream::new(61, &[]);
        let mut met = 0;
        for _ in 0..500 {
            let mut random = || DVec3::new(stream.normal(), stream.normal(), stream.normal());
            let direction = random().normalize();
            let origin = 0.05 * random() - 3.0 * direction;
            let to = |v: DVec3| Vec3A::from(v.as_vec3());
            let Some(at) = meet(&primitives[0], &Ray::new(to(origin), to(direction), 0.0, 1e30)) else {
                continue;
            };
            let hit = hit(&objects[0].geometry, &primitives[0], at, origin, direction);
            let wo = hit.frame.to_local(-direction);
            let offset = wo.x / wo.x.hypot(wo.z);
            assert!((hit.uv[1] - offset).abs() < 1e-4, "{} {offset}", hit.uv[1]);
            met += 1;
        }
        assert!(met > 200);
    }

    /// Places on a ribbon that tapers and is twisted lie on the rays that met it.
    #[test]
    fn places_on_a_tapering_ribbon_lie_on_their_rays() {
        let mut geometry = Geometry::default();
        let node = |y: f32, across: Vec3| RibbonNode { point: Vec3::new(0.0, y, 0.0), across, arc: y };
        let nodes = [node(0.0, Vec3::new(0.4, 0.0, 0.0)), node(1.0, Vec3::new(0.1, 0.0, 0.05))];
        geometry.add_ribbon(&nodes, Ribbon { id: 1, ..Ribbon::default() });
        let primitives = collect([(0, &geometry)]);
        let mut stream = Stream::new(62, &[]);
        let mut met = 0;
        for _ in 0..2000 {
            let origin = DVec3::new(stream.uniform(-0.5, 0.5), stream.uniform(-0.1, 1.1), 1.0);
            let direction =
                DVec3::new(stream.uniform(-0.3, 0.3), stream.uniform(-0.3, 0.3), -1.0).normalize();
            let to = |v: DVec3| Vec3A::from(v.as_vec3());
            let Some(at) = meet(&primitives[0], &Ray::new(to(origin), to(direction), 0.0, 1e30)) else {
                continue;
            };
            let hit = hit(&geometry, &primitives[0], at, origin, direction);
            let on_ray = origin + direction * f64::from(at.distance);
            assert!((hit.position - on_ray).length() < 2e-6, "{} {on_ray}", hit.position);
            met += 1;
        }
        assert!(met > 300, "{met}");
    }
}
