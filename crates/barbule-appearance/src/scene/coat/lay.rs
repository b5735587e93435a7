//! Laying feathers over each other: from the tail to the head, each lifted until it lies over those before it.

use std::collections::{BTreeSet, HashMap};

use glam::{DVec3, I64Vec3};

use super::Stand;
use super::body::{Body, Spot};
use super::follicles::Near;
use super::shape::Shape;

/// Cells in which the coat's height is kept, over the feathers' length.
const CELL: f64 = 0.02;
/// Cells are those of the shortest feather, down to this share of the longest one's, which has as many points as there are cells.
const FINEST: f64 = 0.25;
/// Most times that a feather is lifted, and the least angle, rad.
const MOST_LIFTS: u32 = 8;
const LEAST_LIFT: f64 = 5e-4;
/// By how much it is lifted at most, rad: where feathers run together, as at the tail's end, they cut through each other
/// rather than pile up, for a pile lifts all that lie over it.
const MOST_LIFTED: f64 = 0.2;

/// Size of the cells in which the height of a coat of feathers of these lengths is kept, mm.
pub(super) fn cell_mm(shortest_mm: f64, longest_mm: f64) -> f64 {
    CELL * shortest_mm.max(FINEST * longest_mm)
}

/// The order in which feathers are laid: of two within a length of each other, the one whose root is nearer the head comes
/// later. Where that runs in circles, the one with the fewest beneath it still missing comes first.
pub(super) fn order(stands: &[Stand], length_mm: f64) -> Vec<u32> {
    let largest = stands.iter().map(|stand| stand.scale).fold(0.0, f64::max);
    let reach = 1.1 * length_mm * largest;
    let near = Near::new(stands.iter().map(|stand| stand.spot.point), reach);
    let mut above: Vec<Vec<u32>> = vec![Vec::new(); stands.len()];
    let mut missing = vec![0_u32; stands.len()];
    for (index, stand) in (0_u32..).zip(stands) {
        near.visit(stand.spot.point, |other| {
            let there = &stands[other as usize];
            let apart = there.spot.point - stand.spot.point;
            // The other one is nearer the tail: it lies beneath.
            if other != index && apart.length() < reach && apart.dot(there.along + stand.along) > 0.0 {
                above[other as usize].push(index);
                missing[index as usize] += 1;
            }
        });
    }
    let mut waiting: BTreeSet<(u32, u32)> =
        (0_u32..).zip(&missing).map(|(index, &count)| (count, index)).collect();
    let mut is_laid = vec![false; stands.len()];
    let mut order = Vec::with_capacity(stands.len());
    while let Some((_, index)) = waiting.pop_first() {
        is_laid[index as usize] = true;
        order.push(index);
        for &upper in above[index as usize].iter().filter(|&&upper| !is_laid[upper as usize]) {
            let count = &mut missing[upper as usize];
            waiting.remove(&(*count, upper));
            *count -= 1;
            waiting.insert((*count, upper));
        }
    }
    order
}

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

/// Turns each feather about its base until its test points are `clearance_mm` over those beneath and out of the body.
pub(super) fn lift(
    body: &Body,
    stands: &mut [Stand],
    order: &[u32],
    shapes: &[Shape],
    cell_mm: f64,
    clearance_mm: f64,
) {
    let mut heights = Heights { cells: HashMap::new(), cell_mm };
    for &index in order {
        let stand = &mut stands[index as usize];
        let shape = &shapes[stand.variant];
        let begin = body.triangles[stand.spot.triangle as usize][0];
        let most = stand.erection + MOST_LIFTED;
        for _ in 0..MOST_LIFTS {
            let need = missing(body, &heights, stand, &shape.tests, clearance_mm);
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
