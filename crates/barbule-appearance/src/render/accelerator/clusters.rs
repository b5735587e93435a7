//! Binary hierarchies by merging neighbours along a space-filling curve (parallel locally ordered clustering; Meister & Bittner 2018):
//! the same as obvhs builds, but for boxes of which next to none would be merged.
//!
//! Two boxes are merged where each is the other's best. Of many boxes at one place, or of a row of boxes that grow towards its end, each
//! takes the one beside it for the best, and one pair of all finds itself. A round like that is followed by one in which every other box asks
//! and those between are asked: at least one box of all that see each other is merged then, half of them as a rule.

use glam::DVec3;
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, DEFAULT_MAX_STACK_DEPTH, node::Bvh2Node};
use obvhs::ploc::morton::morton_encode_u128_unorm;
use rayon::prelude::*;

use crate::Result;
use crate::progress::Progress;
use crate::scene::go_on;

/// How far along the curve others are looked at, as in obvhs's slow build.
const REACH: usize = 24;
/// Rounds that look at the two boxes beside each only, as there.
const SHORT_ROUNDS: usize = 2;
/// A round that merges less than one box in so many is stuck, and so few boxes are never stuck.
const STUCK: usize = 32;
const FEW: usize = 64;
/// Boxes whose neighbours one thread looks for at a time.
const PART: usize = 4096;

/// The hierarchy over some boxes.
///
/// # Errors
/// A stop by `progress`.
pub(super) fn merged<T: Boundable>(boxes: &[T], progress: &dyn Progress) -> Result<Bvh2> {
    let mut binary = Bvh2::zeroed(boxes.len());
    binary.primitive_indices = (0..boxes.len() as u32).collect();
    let leaves = boxes.iter().zip(0..).map(|(one, index)| Bvh2Node::new(one.aabb(), 1, index)).collect();
    let mut nodes: Vec<Bvh2Node> = along_curve(leaves);
    let mut next = Vec::with_capacity(nodes.len());
    let (mut free, mut rounds, mut is_stuck) = (binary.nodes.len(), 0, false);
    while nodes.len() > 1 {
        go_on(progress)?;
        let partners = match rounds {
            _ if is_stuck => asked(&nodes),
            0..SHORT_ROUNDS => beside(&nodes),
            _ => nearest(&nodes, progress)?,
        };
        for (index, node) in nodes.iter().enumerate() {
            let other = index.wrapping_add_signed(partners[index].into());
            if other == index || partners[other] != -partners[index] {
                next.push(*node);
            } else if other < index {
                // Children stand behind their parents, in pairs.
                free -= 2;
                (binary.nodes[free], binary.nodes[free + 1]) = (*node, nodes[other]);
                next.push(Bvh2Node::new(node.aabb().union(nodes[other].aabb()), 0, free as u32));
            }
        }
        is_stuck = next.len() > FEW && STUCK * (nodes.len() - next.len()) < nodes.len();
        std::mem::swap(&mut nodes, &mut next);
        next.clear();
        rounds += 1;
    }
    if let (Some(root), Some(last)) = (binary.nodes.first_mut(), nodes.first()) {
        *root = *last;
    }
    binary.max_depth = DEFAULT_MAX_STACK_DEPTH.max(rounds + 1);
    binary.children_are_ordered_after_parents = true;
    Ok(binary)
}

/// Leaves in the order of their middles on a Morton curve.
fn along_curve(leaves: Vec<Bvh2Node>) -> Vec<Bvh2Node> {
    let whole = leaves.iter().fold(Aabb::empty(), |whole, leaf| whole.union(leaf.aabb()));
    let scale: DVec3 = 1.0 / whole.diagonal().as_dvec3();
    let offset = -whole.min.as_dvec3() * scale;
    let code = |leaf: &Bvh2Node| morton_encode_u128_unorm(leaf.aabb().center().as_dvec3() * scale + offset);
    let mut codes: Vec<(u128, u32)> =
        leaves.par_iter().zip(0..leaves.len() as u32).map(|(leaf, index)| (code(leaf), index)).collect();
    codes.par_sort_unstable_by_key(|(code, _)| *code);
    codes.into_iter().map(|(_, index)| leaves[index as usize]).collect()
}

/// What the merged box of two would cost.
fn cost(a: &Bvh2Node, b: &Bvh2Node) -> f32 {
    a.aabb().union(b.aabb()).half_area()
}

/// Of each node the better of the two beside it, as a step along the curve.
fn beside(nodes: &[Bvh2Node]) -> Vec<i8> {
    let mut before = f32::INFINITY;
    let mut partners: Vec<i8> = nodes
        .windows(2)
        .map(|pair| {
            let after = cost(&pair[0], &pair[1]);
            let step = if before < after { -1 } else { 1 };
            before = after;
            step
        })
        .collect();
    partners.push(-1);
    partners
}

/// Of each node the best within reach, the last of equals.
fn nearest(nodes: &[Bvh2Node], progress: &dyn Progress) -> Result<Vec<i8>> {
    let mut partners = vec![0; nodes.len()];
    partners.par_chunks_mut(PART).enumerate().for_each(|(part, partners)| {
        if !progress.is_cancelled() {
            nearest_of(nodes, part * PART, partners);
        }
    });
    go_on(progress)?;
    Ok(partners)
}

/// The same of the nodes from `first` on.
fn nearest_of(nodes: &[Bvh2Node], first: usize, partners: &mut [i8]) {
    // What each node and those after it cost, until the last of those has looked back.
    let mut ahead = [[0.0_f32; REACH]; REACH];
    for (partner, index) in partners.iter_mut().zip(first..) {
        let (mut best, mut least) = (0, f32::INFINITY);
        for other in index.saturating_sub(REACH)..index {
            let cost = match other < first {
                true => cost(&nodes[index], &nodes[other]),
                false => ahead[other % REACH][index % REACH],
            };
            if cost <= least {
                (best, least) = (other as isize - index as isize, cost);
            }
        }
        for other in index + 1..(index + REACH + 1).min(nodes.len()) {
            let cost = cost(&nodes[index], &nodes[other]);
            ahead[index % REACH][other % REACH] = cost;
            if cost <= least {
                (best, least) = (other as isize - index as isize, cost);
            }
        }
        *partner = best as i8;
    }
}

/// Every other node asks the best within reach of those between, the nearest of equals; these take the best that asks. 0 for who stays
/// alone.
fn asked(nodes: &[Bvh2Node]) -> Vec<i8> {
    let better = |a: &(f32, i8), b: &(f32, i8)| {
        a.0.total_cmp(&b.0).then_with(|| (a.1.unsigned_abs(), a.1).cmp(&(b.1.unsigned_abs(), b.1)))
    };
    let asks: Vec<(f32, i8)> = (0..nodes.len().div_ceil(2))
        .into_par_iter()
        .with_min_len(PART)
        .map(|half| {
            let index = 2 * half;
            let odd = (index.saturating_sub(REACH) | 1..(index + REACH).min(nodes.len())).step_by(2);
            let all = odd
                .map(|other| (cost(&nodes[index], &nodes[other]), (other as isize - index as isize) as i8));
            all.min_by(better).unwrap_or((f32::INFINITY, 0))
        })
        .collect();
    let mut best: Vec<Option<(f32, i8)>> = vec![None; nodes.len()];
    for (half, &(cost, step)) in asks.iter().enumerate().filter(|(_, (_, step))| *step != 0) {
        let asked = &mut best[(2 * half).wrapping_add_signed(step.into())];
        let offer = (cost, -step);
        if asked.is_none_or(|so_far| better(&offer, &so_far).is_lt()) {
            *asked = Some(offer);
        }
    }
    let mut partners = vec![0; nodes.len()];
    for (index, (_, step)) in best.iter().enumerate().filter_map(|(index, best)| Some((index, (*best)?))) {
        partners[index] = step;
        partners[index.wrapping_add_signed(step.into())] = -step;
    }
    partners
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;
    use obvhs::BvhBuildParams;
    use obvhs::ploc::PlocBuilder;

    use super::*;
    use crate::math::rng::Stream;
    use crate::progress::{Shared, Unobserved};

    fn built(boxes: &[Aabb]) -> Bvh2 {
        merged(boxes, &Unobserved).unwrap()
    }

    fn depth(binary: &Bvh2) -> usize {
        binary.depth(0)
    }

    /// Node by node what obvhs builds, of more boxes than one thread looks at.
    #[test]
    fn boxes_apart_give_the_hierarchy_of_obvhs() {
        for count in [0, 1, 2, 3, 50, 3 * PART + 17] {
            let mut stream = Stream::new(4, &[count as u64]);
            let mut unit = || stream.unit() as f32;
            let boxes: Vec<Aabb> = (0..count)
                .map(|_| {
                    let low = Vec3A::new(unit(), 3.0 * unit(), unit() * unit());
                    Aabb::new(low, low + 0.02 * Vec3A::new(unit(), unit(), unit()))
                })
                .collect();
            let how = BvhBuildParams::slow_build();
            let theirs = PlocBuilder::new().build(
                how.ploc_search_distance,
                &boxes,
                (0..count as u32).collect(),
                how.sort_precision,
                how.search_depth_threshold,
            );
            let ours = built(&boxes);
            let of = |binary: &Bvh2| -> Vec<_> {
                let of =
                    |node: &Bvh2Node| (node.aabb().min, node.aabb().max, node.prim_count, node.first_index);
                binary.nodes.iter().map(of).collect()
            };
            assert_eq!(of(&ours), of(&theirs));
            assert_eq!(ours.max_depth, theirs.max_depth);
        }
    }

    /// Boxes at one place, in a row that grows, and nested ones: all are there, in a hierarchy that is not deep.
    #[test]
    fn boxes_at_one_place_make_no_deep_hierarchy() {
        let count = 20_000_usize;
        let flat = |_| Aabb::new(Vec3A::ONE, Vec3A::ONE);
        let row = |i: usize| {
            let (at, pad) = (Vec3A::X * i as f32, 1e-6 + 1e-6 * i as f32);
            Aabb::new(at - pad, at + 1.0 + pad)
        };
        let nested = |i: usize| Aabb::new(Vec3A::splat(-1.0 - i as f32), Vec3A::splat(1.0 + i as f32));
        let makers: [&dyn Fn(usize) -> Aabb; 3] = [&flat, &row, &nested];
        for make in makers {
            let boxes: Vec<Aabb> = (0..count).map(make).collect();
            let binary = built(&boxes);
            binary.validate(&boxes, false, true);
            assert!(depth(&binary) < 64, "{}", depth(&binary));
        }
    }

    #[test]
    fn a_stop_ends_it() {
        let stopped = Shared::default();
        stopped.cancel();
        assert!(merged(&[Aabb::new(Vec3A::ZERO, Vec3A::ONE); 2], &stopped).err().unwrap().is_interrupted());
    }
}
