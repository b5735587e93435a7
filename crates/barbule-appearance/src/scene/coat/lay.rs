//! Laying feathers over each other: from the tail to the head, each lifted until it lies over those before it.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use glam::{DVec3, I64Vec3};
use rayon::prelude::*;

use super::Stand;
use super::body::{Body, Spot};
use super::follicles::Near;
use super::shape::Shape;
use crate::Result;
use crate::progress::Progress;
use crate::scene::go_on;

/// Cells in which the coat's height is kept, over the feathers' length.
const CELL: f64 = 0.02;
/// Cells are those of the shortest feather, down to this share of the longest one's, which has as many points as there are cells.
const FINEST: f64 = 0.25;
/// Most times that a feather is lifted, and the least angle, rad.
const MOST_LIFTS: u32 = 8;
const LEAST_LIFT: f64 = 5e-4;

/// Size of the cells in which the height of a coat of feathers of these lengths is kept, mm.
pub(super) fn cell_mm([shortest_mm, longest_mm]: [f64; 2]) -> f64 {
    CELL * shortest_mm.max(FINEST * longest_mm)
}

/// The order in which feathers are laid: of two within a length of each other, the one whose root is nearer the head comes
/// later. Where that runs in circles, the one with the fewest beneath it still missing comes first.
///
/// Pairs are looked for twice and never kept: a crowd of feathers has billions of them.
///
/// # Errors
/// A stop by `progress`.
pub(super) fn order(stands: &[Stand], length_mm: f64, progress: &dyn Progress) -> Result<Vec<u32>> {
    let largest = |of: &dyn Fn(&Stand) -> f64| stands.iter().map(of).fold(0.0, f64::max);
    let reach = 1.1 * length_mm * largest(&|stand| stand.scale);
    let largest_size = largest(&|stand| stand.size);
    let near = Near::new(stands.iter().map(|stand| stand.spot.point), reach);
    // Side by side in memory: in a crowd that is most of the time.
    let at: Vec<([DVec3; 2], f64)> = stands
        .iter()
        .map(|stand| ([stand.spot.point, stand.along], reach * stand.size / largest_size))
        .collect();
    // Of two the one that is nearer the tail lies beneath.
    let lies_over = |upper: u32, lower: u32| {
        let (([point, along], own), ([other, other_along], others)) =
            (at[upper as usize], at[lower as usize]);
        let apart = other - point;
        apart.length() < own.max(others) && apart.dot(other_along + along) > 0.0
    };
    progress.begin("ordering the coat's feathers", 2 * stands.len() as u64);
    let mut missing: Vec<u32> = (0..at.len() as u32)
        .into_par_iter()
        .map(|index| {
            go_on(progress)?;
            progress.advance(1);
            let mut beneath = 0;
            near.visit(at[index as usize].0[0], |other| {
                beneath += u32::from(other != index && lies_over(index, other));
            });
            Ok(beneath)
        })
        .collect::<Result<_>>()?;
    // Those with nothing beneath them, the first of them first.
    let mut free: BinaryHeap<Reverse<u32>> =
        (0_u32..).zip(&missing).filter(|(_, count)| **count == 0).map(|(index, _)| Reverse(index)).collect();
    let mut order = Vec::with_capacity(stands.len());
    while order.len() < at.len() {
        go_on(progress)?;
        progress.advance(1);
        let fewest = || (0_u32..).zip(&missing).min_by_key(|(_, count)| **count).map(|(index, _)| index);
        let Some(index) = free.pop().map(|Reverse(index)| index).or_else(fewest) else { break };
        missing[index as usize] = LAID;
        order.push(index);
        near.visit(at[index as usize].0[0], |upper| {
            let count = &mut missing[upper as usize];
            if *count != LAID && lies_over(upper, index) {
                *count -= 1;
                if *count == 0 {
                    free.push(Reverse(upper));
                }
            }
        });
    }
    Ok(order)
}

/// In place of how many are missing beneath a feather: it is laid.
const LAID: u32 = u32::MAX;

/// Height of what lies on a body so far.
struct Heights {
    cells: HashMap<I64Vec3, f64>,
    cell_mm: f64,
}

impl Heights {
    fn cell(&self, foot: DVec3) -> I64Vec3 {
        (foot / self.cell_mm).floor().as_i64vec3()
    }

    /// The foot of a point and its height over that; none where it is beside the body.
    fn foot(&self, body: &Body, point: DVec3, start: &mut u32) -> Option<(Spot, f64)> {
        let foot = body.foot(point, *start);
        *start = body.triangles[foot.triangle as usize][0];
        let off = point - foot.point;
        let height = off.dot(foot.normal);
        let is_beside = off.length_squared() - height * height > self.cell_mm * self.cell_mm;
        (!is_beside).then_some((foot, height))
    }
}

/// How far feathers are lifted off each other.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lifting {
    /// Cells in which heights are kept, mm.
    pub(super) cell_mm: f64,
    /// How far over those beneath a feather of size 1 lies, mm.
    pub(super) clearance_mm: f64,
    /// By how much one is lifted at most, rad: where feathers run together, as at the tail's end, they cut through each other rather
    /// than pile up, for a pile lifts all that lie over it.
    pub(super) most: f64,
}

/// Turns each feather about its base until its test points are clear of those beneath and out of the body.
///
/// # Errors
/// A stop by `progress`.
pub(super) fn lift(
    body: &Body,
    stands: &mut [Stand],
    (order, shapes): (&[u32], &[Shape]),
    Lifting { cell_mm, clearance_mm, most: most_lifted }: Lifting,
    progress: &dyn Progress,
) -> Result<()> {
    let mut heights = Heights { cells: HashMap::new(), cell_mm };
    progress.begin("laying the coat's feathers", order.len() as u64);
    for &index in order {
        go_on(progress)?;
        progress.advance(1);
        let stand = &mut stands[index as usize];
        let shape = &shapes[stand.variant];
        let begin = body.triangles[stand.spot.triangle as usize][0];
        let most = stand.erection + most_lifted;
        for _ in 0..MOST_LIFTS {
            let need = missing(body, &heights, stand, &shape.tests, clearance_mm * stand.size);
            if need < LEAST_LIFT || stand.erection >= most {
                break;
            }
            stand.erection = (stand.erection + need).min(most);
        }
        let place = stand.place(0);
        let mut start = begin;
        for point in &shape.surface {
            if let Some((foot, height)) = heights.foot(body, place.point(*point), &mut start) {
                let cell = heights.cell(foot.point);
                let highest = heights.cells.entry(cell).or_insert(height);
                *highest = highest.max(height);
            }
        }
    }
    Ok(())
}

/// The angle by which a feather must be lifted so that its points are free, if heights grow with the distance from its base.
fn missing(body: &Body, heights: &Heights, stand: &Stand, tests: &[DVec3], clearance_mm: f64) -> f64 {
    let place = stand.place(0);
    let mut start = body.triangles[stand.spot.triangle as usize][0];
    let mut most: f64 = 0.0;
    for test in tests {
        let point = place.point(*test);
        if let Some((foot, height)) = heights.foot(body, point, &mut start) {
            let under = heights.cells.get(&heights.cell(foot.point)).copied().unwrap_or(0.0);
            let arm = (point - stand.spot.point).length();
            most = most.max((under.max(0.0) + clearance_mm - height) / arm.max(heights.cell_mm));
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rng::Stream;
    use crate::progress::{Shared, Unobserved};

    /// Feathers in a square of 10 mm that lie any way: so close together much of it runs in circles.
    fn crowd(count: usize) -> Vec<Stand> {
        let mut stream = Stream::new(8, &[count as u64]);
        (0..count)
            .map(|_| {
                let point = DVec3::new(10.0 * stream.unit(), 10.0 * stream.unit(), 0.0);
                let along = DVec3::new(stream.normal(), 3.0 + stream.normal(), 0.0).normalize();
                let spot = Spot { point, normal: DVec3::Z, triangle: 0, weights: [1.0, 0.0, 0.0] };
                Stand { spot, along, erection: 0.1, scale: 1.0, size: 1.0, kind: 0, variant: 0 }
            })
            .collect()
    }

    /// By looking at all pairs each time: the first of those with the fewest beneath them that are not laid.
    fn plain_order(stands: &[Stand], length_mm: f64) -> Vec<u32> {
        let is_over = |upper: &Stand, lower: &Stand| {
            let apart = lower.spot.point - upper.spot.point;
            apart.length() < 1.1 * length_mm && apart.dot(lower.along + upper.along) > 0.0
        };
        let mut left: Vec<usize> = (0..stands.len()).collect();
        let mut order = Vec::new();
        while !left.is_empty() {
            let missing = |&&of: &&usize| left.iter().filter(|&&b| is_over(&stands[of], &stands[b])).count();
            let next = *left.iter().min_by_key(missing).unwrap();
            left.retain(|&index| index != next);
            order.push(next as u32);
        }
        order
    }

    #[test]
    fn the_order_is_that_of_all_pairs() {
        for (count, length_mm) in [(1, 1.0), (150, 0.8), (150, 3.0), (90, 30.0)] {
            let stands = crowd(count);
            assert_eq!(order(&stands, length_mm, &Unobserved).unwrap(), plain_order(&stands, length_mm));
        }
    }

    /// Among 200 million pairs.
    #[test]
    fn a_crowd_is_stopped() {
        let stands = crowd(20_000);
        let stopped = Shared::default();
        std::thread::scope(|scope| {
            let work = scope.spawn(|| order(&stands, 30.0, &stopped));
            while stopped.snapshot().done == 0 {
                std::thread::yield_now();
            }
            stopped.cancel();
            assert!(work.join().unwrap().unwrap_err().is_interrupted());
        });
    }
}
