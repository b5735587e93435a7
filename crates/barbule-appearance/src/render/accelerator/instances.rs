//! Objects that stand in several places: a hierarchy over the places above one of each object.

use fearless_simd::{Level, Simd};
use glam::{DVec3, UVec2, Vec3A};
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::ray::Ray;

use super::boxes::crossed;
use super::primitive::Meeting;
use super::{Accelerator, Beam, build, enters, hits, ray};
use crate::Result;
use crate::bsdf::{Frame, Hit};
use crate::math::rng::split_mix;
use crate::math::simd::dispatch_large;
use crate::progress::Progress;
use crate::scene::Object;
use crate::scene::geometry::Place;

/// All shapes that have places, and these.
pub(in super::super) struct Instances {
    shapes: Vec<Shapes>,
    top: CwBvh,
    /// In the order of the hierarchy's leaves.
    instances: Vec<Instance>,
    level: Level,
}

/// All shapes of an object with places, or one that repeats in it.
struct Shapes {
    accelerator: Accelerator,
    /// Which of those that repeat.
    repeated: Option<usize>,
}

/// One place of one of them.
#[derive(Debug, Clone, Copy)]
struct Instance {
    shapes: u32,
    place: Place,
}

/// What the hierarchy over places is built of.
struct Boxed(Aabb);

impl Boundable for Boxed {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

impl Instances {
    /// Those of a list of objects; `None` where no object has places.
    ///
    /// # Errors
    /// A stop by `progress`.
    pub(in super::super) fn new(objects: &[Object], progress: &dyn Progress) -> Result<Option<Self>> {
        let (mut shapes, mut instances, mut boxes) = (Vec::new(), Vec::new(), Vec::new());
        let all = (0_u32..).zip(objects).flat_map(|(index, Object { geometry: whole, .. })| {
            let repeated = whole.repeated.iter().enumerate().map(|(k, geometry)| (Some(k), geometry));
            std::iter::once((None, whole)).chain(repeated).map(move |(k, shapes)| (index, whole, k, shapes))
        });
        for (index, whole, repeated, geometry) in all {
            let Some(bounds) = geometry.own_bounds() else { continue };
            let (own, before) = (geometry.places.iter().copied(), instances.len());
            let places = if repeated.is_some() { whole.places_of(geometry) } else { Box::new(own) };
            let widest = geometry.widest();
            let bounds = [bounds[0] - widest, bounds[1] + widest];
            for place in places {
                let [low, high] = place.bounds(bounds).map(Vec3A::from);
                // Rays come through in single precision, and flat boxes are missed by rays in their plane.
                let pad = 1e-6 + 1e-6 * low.abs().max(high.abs());
                boxes.push(Boxed(Aabb::new(low - pad, high + pad)));
                instances.push(Instance { shapes: shapes.len() as u32, place });
            }
            if instances.len() == before {
                continue;
            }
            let accelerator = Accelerator::of(std::iter::once((index, geometry)), progress)?;
            shapes.push(Shapes { accelerator, repeated });
        }
        if instances.is_empty() {
            return Ok(None);
        }
        let top = build::hierarchy(&boxes, progress)?;
        let instances = top.primitive_indices.iter().map(|&index| instances[index as usize]).collect();
        Ok(Some(Self { shapes, top, instances, level: Level::new() }))
    }

    /// Bytes of all hierarchies, primitives included.
    pub(in super::super) fn bytes(&self) -> usize {
        let own: usize = self.shapes.iter().map(|shapes| shapes.accelerator.bytes()).sum();
        own + size_of_val(&self.top.nodes[..]) + size_of_val(&self.instances[..])
    }

    /// The nearest hit between `nearest` and `farthest`, mm along the unit direction.
    #[must_use]
    pub(in super::super) fn hit(
        &self,
        objects: &[Object],
        origin: DVec3,
        direction: DVec3,
        nearest: f64,
        farthest: f64,
    ) -> Option<Hit> {
        let (index, primitive, meeting) =
            dispatch_large!(self.level, simd => self.first(simd, origin, direction, nearest, farthest))?;
        let Instance { shapes, place } = self.instances[index as usize];
        let Shapes { accelerator, repeated } = &self.shapes[shapes as usize];
        let met = &accelerator.primitives[primitive as usize];
        let (from, along) = (place.point_back(origin), place.direction_back(direction));
        let geometry = &objects[met.object as usize].geometry;
        let geometry = repeated.map_or(geometry, |k| &geometry.repeated[k]);
        let hit = hits::hit(geometry, met, meeting, from, along);
        let turned = |v: DVec3| place.direction(v);
        let Frame { x, y, z } = hit.frame;
        Some(Hit {
            position: place.point(hit.position),
            normal: turned(hit.normal),
            vane_normal: turned(hit.vane_normal),
            frame: Frame { x: turned(x), y: turned(y), z: turned(z) },
            uv_gradients: hit.uv_gradients.map(|gradient| turned(gradient) / place.scale),
            object: met.object,
            primitive,
            id: split_mix(hit.id ^ split_mix(place.id)),
            instance: split_mix(hit.instance ^ split_mix(place.id)),
            distance: f64::from(meeting.distance) * place.scale,
            ..hit
        })
    }

    /// Whether anything stands between `nearest` and `farthest`.
    #[must_use]
    pub(in super::super) fn is_blocked(
        &self,
        origin: DVec3,
        direction: DVec3,
        nearest: f64,
        farthest: f64,
    ) -> bool {
        dispatch_large!(self.level, simd => self.any(simd, origin, direction, nearest, farthest))
    }

    /// Whether a ray of a beam may cross the box about a place.
    #[must_use]
    pub(in super::super) fn may_meet(&self, beam: &Beam) -> bool {
        enters(&self.top, beam)
    }

    #[inline(always)]
    fn first<S: Simd>(
        &self,
        simd: S,
        origin: DVec3,
        direction: DVec3,
        nearest: f64,
        farthest: f64,
    ) -> Option<(u32, u32, Meeting)> {
        let mut outer = ray(origin, direction, nearest, farthest);
        let mut best = None;
        let mut state = self.top.new_traversal(outer.direction);
        let mut node;
        obvhs::traverse!(self.top, node, state, crossed(node, &outer, state.oct_inv4), {
            let instance = &self.instances[state.primitive_id as usize];
            let accelerator = &self.shapes[instance.shapes as usize].accelerator;
            let inner = instance.inner(origin, direction, nearest, f64::from(outer.tmax));
            if let Some((primitive, meeting)) = accelerator.first(simd, inner) {
                outer.tmax = meeting.distance * instance.place.scale as f32;
                best = Some((state.primitive_id, primitive, meeting));
            }
        });
        best
    }

    #[inline(always)]
    fn any<S: Simd>(&self, simd: S, origin: DVec3, direction: DVec3, nearest: f64, farthest: f64) -> bool {
        let outer = ray(origin, direction, nearest, farthest);
        let mut state = self.top.new_traversal(outer.direction);
        let mut node;
        obvhs::traverse!(self.top, node, state, crossed(node, &outer, state.oct_inv4), {
            let instance = &self.instances[state.primitive_id as usize];
            let inner = instance.inner(origin, direction, nearest, farthest);
            if self.shapes[instance.shapes as usize].accelerator.any(simd, inner) {
                return true;
            }
        });
        false
    }
}

impl Instance {
    /// A ray of the scene in the object; its direction stays a unit vector, its lengths are the object's.
    #[inline(always)]
    fn inner(&self, origin: DVec3, direction: DVec3, nearest: f64, farthest: f64) -> Ray {
        let Place { scale, .. } = self.place;
        ray(
            self.place.point_back(origin),
            self.place.direction_back(direction),
            nearest / scale,
            farthest / scale,
        )
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, Vec3};

    use super::*;
    use crate::bsdf::{Lambertian, Reflectance, Surface};
    use crate::math::rng::Stream;
    use crate::progress::Unobserved;
    use crate::scene::geometry::{CurveNode, Geometry, Mesh};

    fn object(geometry: Geometry) -> Object {
        Object { geometry, surface: Surface::Lambertian(Lambertian::new(Reflectance::new(|_| 1.0).unwrap())) }
    }

    /// A bent fibre and a triangle.
    fn shapes() -> Geometry {
        let node =
            |x: f32, y: f32| CurveNode { point: Vec3::new(x, y, 0.2), radius: 0.1, ..CurveNode::default() };
        let mut geometry = Geometry::default();
        geometry.add_curve(&[node(-1.0, 0.0), node(0.0, 0.4), node(1.0, 0.1)], 7);
        let positions =
            vec![Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.3), Vec3::new(0.0, 1.0, -0.2)];
        geometry.meshes.push(Mesh { positions, triangles: vec![[0, 1, 2]], id: 3, ..Mesh::default() });
        geometry
    }

    /// The same shapes with the place in their own coordinates.
    fn moved(place: &Place) -> Geometry {
        let mut geometry = shapes();
        let point = |p: &mut Vec3| *p = place.point(p.as_dvec3()).as_vec3();
        for node in &mut geometry.curve_nodes {
            point(&mut node.point);
            node.radius *= place.scale as f32;
        }
        geometry.meshes[0].positions.iter_mut().for_each(point);
        geometry
    }

    /// A straight fibre is met beside its axis too.
    #[test]
    fn a_lone_fibre_is_as_wide_as_it_is() {
        let node = |x: f32| CurveNode { point: Vec3::new(x, 0.0, 0.0), radius: 0.1, ..CurveNode::default() };
        let place = Place { scale: 2.0, turn: DMat3::IDENTITY, shift: DVec3::Y, id: 1 };
        let mut geometry = Geometry { places: vec![place], ..Geometry::default() };
        geometry.add_curve(&[node(-1.0), node(1.0)], 7);
        let objects = [object(geometry)];
        let instances = Instances::new(&objects, &Unobserved).unwrap().unwrap();
        for (y, expected) in [(1.19, true), (0.81, true), (1.21, false), (0.79, false)] {
            let hit = instances.hit(&objects, DVec3::new(0.3, y, 5.0), DVec3::NEG_Z, 0.0, 10.0);
            assert_eq!(hit.is_some(), expected, "{y}");
        }
    }

    /// Rays find in places what they find where copies stand.
    #[test]
    fn instances_are_met_where_their_copies_are() {
        let mut stream = Stream::new(71, &[]);
        let places: Vec<Place> = (0..40)
            .map(|i| {
                let axis = DVec3::new(stream.normal(), stream.normal(), stream.normal()).normalize();
                Place {
                    scale: 0.3 + stream.unit(),
                    turn: DMat3::from_axis_angle(axis, 6.0 * stream.unit()),
                    shift: 4.0 * DVec3::new(stream.normal(), stream.normal(), stream.normal()),
                    id: i,
                }
            })
            .collect();
        let copies: Vec<Object> = places.iter().map(|place| object(moved(place))).collect();
        let placed = [object(Geometry { places, ..shapes() })];
        let flat_of = |objects: &[Object]| Accelerator::new(objects, &Unobserved).unwrap();
        let instances_of = |objects: &[Object]| Instances::new(objects, &Unobserved).unwrap();
        let (flat, instances) = (flat_of(&copies), instances_of(&placed).unwrap());
        assert!(flat_of(&placed).primitives.is_empty() && instances_of(&copies).is_none());
        let (mut met, mut apart, mut ids) = (0, 0, std::collections::BTreeSet::new());
        for _ in 0..20_000 {
            let direction = DVec3::new(stream.normal(), stream.normal(), stream.normal()).normalize();
            let origin =
                3.0 * DVec3::new(stream.normal(), stream.normal(), stream.normal()) - 20.0 * direction;
            let expected = flat.hit(&copies, origin, direction, 0.0, 1e9);
            let found = instances.hit(&placed, origin, direction, 0.0, 1e9);
            let (Some(expected), Some(found)) = (&expected, &found) else {
                apart += usize::from(expected.is_some() || found.is_some());
                continue;
            };
            if (found.distance - expected.distance).abs() > 1e-3 {
                apart += 1;
                continue;
            }
            met += 1;
            ids.insert(found.id);
            assert!((found.position - expected.position).length() < 1e-3);
            assert!(found.normal.dot(expected.normal) > 0.999, "{} {}", found.normal, expected.normal);
            assert!((found.frame.x.cross(found.frame.y) - found.frame.z).length() < 1e-9);
            let (near, far) = (found.distance - 0.01, found.distance + 0.01);
            assert!(instances.is_blocked(origin, direction, 0.0, far));
            assert!(!instances.is_blocked(origin, direction, 0.0, near));
        }
        // Single precision decides differently along outlines.
        assert!(met > 3000 && apart < met / 200 && ids.len() > 50, "{met} {apart} {}", ids.len());
    }
}
