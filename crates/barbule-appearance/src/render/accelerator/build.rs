//! Building hierarchies: the steps of obvhs's `build_cwbvh`, one by one. That asks for the time, and so fails in browsers, cannot be
//! stopped, and takes the square of the number of boxes where they lie at one place.

use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh};
use obvhs::{Boundable, BvhBuildParams};

use super::clusters;
use crate::Result;
use crate::progress::Progress;
use crate::scene::go_on;

/// Most primitives of a leaf that a compressed node can have.
const MOST_IN_LEAF: u32 = 3;

/// The hierarchy over some boxes, as good as obvhs makes one.
///
/// # Errors
/// A stop by `progress`.
pub(super) fn hierarchy<T: Boundable>(boxes: &[T], progress: &dyn Progress) -> Result<CwBvh> {
    let mut binary = clusters::merged(boxes, progress)?;
    // The passes of obvhs's own run, which begin and end for themselves.
    for pass in (1..32).step_by(2) {
        go_on(progress)?;
        let share = 1.0 / pass as f32;
        let ratio = BvhBuildParams::slow_build().reinsertion_batch_ratio;
        ReinsertionOptimizer::default().run(&mut binary, ratio, Some(vec![share]));
    }
    go_on(progress)?;
    Ok(bvh2_to_cwbvh(&binary, MOST_IN_LEAF, true, false))
}
