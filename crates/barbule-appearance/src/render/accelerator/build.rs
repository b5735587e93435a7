//! Building hierarchies: the steps of obvhs's `build_cwbvh`, which asks for the time and so fails in browsers.

use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh};
use obvhs::ploc::PlocBuilder;
use obvhs::{Boundable, BvhBuildParams};

/// The hierarchy over some boxes, as good as obvhs makes one.
pub(super) fn hierarchy<T: Boundable>(boxes: &[T]) -> CwBvh {
    let how = BvhBuildParams::slow_build();
    let mut binary = PlocBuilder::with_capacity(boxes.len()).build(
        how.ploc_search_distance,
        boxes,
        (0..boxes.len() as u32).collect(),
        how.sort_precision,
        how.search_depth_threshold,
    );
    ReinsertionOptimizer::default().run(&mut binary, how.reinsertion_batch_ratio, None);
    bvh2_to_cwbvh(&binary, how.max_prims_per_leaf.clamp(1, 3), true, false)
}
