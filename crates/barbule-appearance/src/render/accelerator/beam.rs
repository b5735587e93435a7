//! A bundle of rays against the eight boxes of a node, at once: what none of them crosses.

use glam::{DVec3, Vec3A};
use obvhs::cwbvh::node::CwBvhNode;

/// Share by which beams are wider than their rays, which go on in single precision.
const MARGIN: f64 = 1e-5;

/// Rays whose origins lie in one box and whose directions, of any length, in another.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Beam {
    origin: [Vec3A; 2],
    direction: [Vec3A; 2],
}

impl Beam {
    /// The beam about the rays that lie between these: origins and directions are combinations of theirs with weights between 0 and 1.
    #[must_use]
    pub(in super::super) fn about(rays: &[(DVec3, DVec3)]) -> Self {
        let bounds = |of: fn(&(DVec3, DVec3)) -> DVec3| {
            let low = rays.iter().map(of).fold(DVec3::INFINITY, DVec3::min);
            let high = rays.iter().map(of).fold(DVec3::NEG_INFINITY, DVec3::max);
            let pad = MARGIN * low.abs().max(high.abs()).max_element();
            [(low - pad).as_vec3a(), (high + pad).as_vec3a()]
        };
        Self { origin: bounds(|ray| ray.0), direction: bounds(|ray| ray.1) }
    }

    /// Some direction of it: it decides in which order boxes are looked at.
    #[inline(always)]
    #[must_use]
    pub(super) fn middle(&self) -> Vec3A {
        0.5 * (self.direction[0] + self.direction[1])
    }

    /// Which children of a node a ray of the beam may cross, as [`super::boxes::crossed`] tells it of one ray: those that each pair
    /// of sides leaves a stretch of, in interval arithmetic.
    #[inline(always)]
    pub(super) fn crossed(&self, node: &CwBvhNode, oct_inv4: u32) -> u32 {
        let (scale, start) = (node.compute_extent(), Vec3A::from(node.p));
        let mut between = ([0.0; 8], [f32::INFINITY; 8]);
        let sides = [
            (&node.child_min_x, &node.child_max_x),
            (&node.child_min_y, &node.child_max_y),
            (&node.child_min_z, &node.child_max_z),
        ];
        for (axis, (min, max)) in sides.into_iter().enumerate() {
            let side = |q: u8| f32::from(q) * scale[axis] + start[axis];
            for k in 0..8 {
                let (first, last) = self.between(axis, side(min[k]), side(max[k]));
                between.0[k] = f32::max(between.0[k], first);
                between.1[k] = f32::min(between.1[k], last);
            }
        }
        let (bits, places) = node.get_child_and_index_bits(oct_inv4);
        let (bits, places) = (bits.to_le_bytes(), places.to_le_bytes());
        let of = |k: usize| u32::from(bits[k]) << (places[k] & 31);
        (0..8).filter(|&k| between.0[k] <= between.1[k]).fold(0, |found, k| found | of(k))
    }

    /// From where to where, in lengths of their directions, rays can be between two sides of a box at most.
    #[inline(always)]
    fn between(&self, axis: usize, low: f32, high: f32) -> (f32, f32) {
        let [slowest, fastest] = self.direction.map(|d| d[axis]);
        // The whole way to the box: up to its lower side from the highest origin, and down to its upper one from the lowest.
        let (up, down) = (low - self.origin[1][axis], high - self.origin[0][axis]);
        let first = if up > 0.0 {
            if fastest > 0.0 { up / fastest } else { f32::INFINITY }
        } else if down < 0.0 {
            if slowest < 0.0 { down / slowest } else { f32::INFINITY }
        } else {
            0.0
        };
        let last = if slowest > 0.0 {
            down / slowest
        } else if fastest < 0.0 {
            up / fastest
        } else {
            f32::INFINITY
        };
        (first, last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Lambertian, Reflectance, Surface};
    use crate::math::rng::Stream;
    use crate::progress::Unobserved;
    use crate::render::accelerator::Accelerator;
    use crate::scene::Object;
    use crate::scene::geometry::{CurveNode, Geometry};

    /// What a ray of a beam meets the beam may meet; narrow beams that no ray meets are mostly known to miss.
    #[test]
    fn beams_miss_only_what_all_their_rays_miss() {
        let mut stream = Stream::new(19, &[]);
        let mut geometry = Geometry::default();
        for id in 0..150 {
            let mut point = |spread: f32| {
                glam::Vec3::from_array(std::array::from_fn(|_| spread * stream.normal() as f32))
            };
            let (start, along) = (point(2.0), point(0.15));
            let node = |point| CurveNode { point, radius: 0.02, ..CurveNode::default() };
            geometry.add_curve(&[node(start), node(start + along)], id);
        }
        let surface = Surface::Lambertian(Lambertian::new(Reflectance::new(|_| 1.0).unwrap()));
        let objects = [Object { geometry, surface }];
        let accelerator = Accelerator::new(&objects, &Unobserved).unwrap();
        let (mut met, mut missed, mut known) = (0, 0, 0);
        for turn in 0..3000 {
            let mut random = || DVec3::new(stream.normal(), stream.normal(), stream.normal());
            let ahead = match turn % 4 {
                0 => DVec3::NEG_Z,
                _ => random().normalize(),
            };
            let from = random() - 12.0 * ahead;
            let (to, lens) = (0.05 * random(), if turn % 2 == 0 { DVec3::ZERO } else { 0.1 * random() });
            let along = 5.0 * ahead;
            let corners = [
                (from, along),
                (from + lens, along - lens),
                (from, along + to),
                (from + lens, along + to - lens),
            ];
            let beam = Beam::about(&corners);
            let any = (0..200).any(|_| {
                let (u, v) = (stream.unit(), stream.unit());
                let (origin, direction) = (from + u * lens, along + v * to - u * lens);
                accelerator.is_blocked(origin, direction.normalize(), 0.0, 1e9)
            });
            assert!(!any || accelerator.may_meet(&beam));
            met += usize::from(any);
            missed += usize::from(!any);
            known += usize::from(!accelerator.may_meet(&beam));
        }
        // Boxes in space about beams that slant are wide.
        assert!(met > 300 && 5 * known > missed, "{met} {missed} {known}");
    }
}
