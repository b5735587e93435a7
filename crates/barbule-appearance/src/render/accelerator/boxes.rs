//! A ray against the eight boxes of a node, at once.

use glam::Vec3A;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::ray::Ray;

/// What crosses a box nearer than this is taken to cross it here; as obvhs has it.
const NEAREST: f32 = 1e-4;

/// Which children of a node a ray crosses, as [`CwBvhNode::intersect_ray`] tells it. Loops over arrays of eight, which become
/// registers where this is inlined into a function that is compiled for wide ones; obvhs converts the boxes' sides one by one.
#[inline(always)]
pub(super) fn crossed(node: &CwBvhNode, ray: &Ray, oct_inv4: u32) -> u32 {
    let scale = node.compute_extent() * ray.inv_direction;
    let start = (Vec3A::from(node.p) - ray.origin) * ray.inv_direction;
    let mut between = ([NEAREST; 8], [ray.tmax; 8]);
    slab(&mut between, &node.child_min_x, &node.child_max_x, scale.x, start.x);
    slab(&mut between, &node.child_min_y, &node.child_max_y, scale.y, start.y);
    slab(&mut between, &node.child_min_z, &node.child_max_z, scale.z, start.z);
    let (near, far) = between;
    let (bits, places) = node.get_child_and_index_bits(oct_inv4);
    let (bits, places) = (bits.to_le_bytes(), places.to_le_bytes());
    let mut found = 0;
    for k in 0..8 {
        let child = u32::from(bits[k]) << (places[k] & 31);
        found |= if near[k] <= far[k] { child } else { 0 };
    }
    found
}

/// Cuts what a ray has between the two sides of each box along an axis.
#[inline(always)]
fn slab((near, far): &mut ([f32; 8], [f32; 8]), min: &[u8; 8], max: &[u8; 8], scale: f32, start: f32) {
    for k in 0..8 {
        let (a, b) = (f32::from(min[k]) * scale + start, f32::from(max[k]) * scale + start);
        let (first, last) = if a < b { (a, b) } else { (b, a) };
        near[k] = if first > near[k] { first } else { near[k] };
        far[k] = if last < far[k] { last } else { far[k] };
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, Simd};
    use obvhs::Boundable;
    use obvhs::aabb::Aabb;

    use super::*;
    use crate::math::rng::Stream;
    use crate::math::simd::dispatch_large;

    struct Cube(Aabb);

    impl Boundable for Cube {
        fn aabb(&self) -> Aabb {
            self.0
        }
    }

    #[inline(always)]
    fn with<S: Simd>(_simd: S, node: &CwBvhNode, ray: &Ray, oct_inv4: u32) -> u32 {
        crossed(node, ray, oct_inv4)
    }

    /// All nodes of a hierarchy, also with empty places, for rays in all directions, some along axes.
    #[test]
    fn the_same_boxes_are_crossed_as_one_by_one() {
        let mut stream = Stream::new(31, &[]);
        let mut random = |scale: f32| {
            Vec3A::new(stream.normal() as f32, stream.normal() as f32, stream.normal() as f32) * scale
        };
        let cubes: Vec<Cube> = (0..200)
            .map(|_| {
                let (middle, half) = (random(2.0), random(0.3).abs());
                Cube(Aabb::new(middle - half, middle + half))
            })
            .collect();
        let hierarchy = super::super::build::hierarchy(&cubes, &crate::progress::Unobserved).unwrap();
        let mut crossings = 0;
        for k in 0..500 {
            let direction = match k % 10 {
                0 => Vec3A::X,
                1 => Vec3A::NEG_Z,
                _ => random(1.0).normalize(),
            };
            let ray = Ray::new(random(2.0), direction, 0.0, if k % 2 == 0 { 1e30 } else { 2.0 });
            let state = hierarchy.new_traversal(ray.direction);
            for node in &hierarchy.nodes {
                let expected = node.intersect_ray_basic(&ray, state.oct_inv4);
                assert_eq!(crossed(node, &ray, state.oct_inv4), expected);
                let found = dispatch_large!(Level::new(), simd => with(simd, node, &ray, state.oct_inv4));
                assert_eq!(found, expected);
                crossings += expected.count_ones();
            }
        }
        assert!(crossings > 1000, "{crossings}");
    }
}
