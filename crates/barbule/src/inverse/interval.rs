//! Intervals of sizes: how far each may go until the measurement speaks against it, all others following.

use super::Estimate;
use super::problem::Problem;
use super::search::{Found, MOST_STEPS, descend};
use crate::Result;

/// Trials for each end of an interval.
const TRIALS: usize = 12;
/// An end has been found once the sum of squares there is off by this part of what is wanted.
const CLOSE: f64 = 2e-3;

/// The interval of one size in which the sum of squares, least over all other sizes, stays within `worse` of that of `found`.
/// `expected` is half its length where the model is linear.
pub(super) fn interval(
    problem: &Problem,
    found: &Found,
    size: usize,
    worse: f64,
    expected: f64,
) -> Result<Estimate> {
    let p = &problem.model.parameters()[size];
    let (low, low_open) = end(problem, found, size, worse, -expected, p.low)?;
    let (high, high_open) = end(problem, found, size, worse, expected, p.high)?;
    Ok(Estimate { value: found.sizes[size], low, high, open: [low_open, high_open] })
}

/// Where the sum of squares has grown by `worse` on one side, and whether that is beyond the range's end.
fn end(
    problem: &Problem,
    found: &Found,
    size: usize,
    worse: f64,
    expected: f64,
    last: f64,
) -> Result<(f64, bool)> {
    let value = found.sizes[size];
    let reach = (last - value).abs();
    let towards = if last < value { -1.0 } else { 1.0 };
    if reach == 0.0 {
        return Ok((last, true));
    }
    let mut best = found.clone();
    // The root of what is lost grows linearly where the model is linear; (distance, root) inside and outside.
    let wanted = worse.sqrt();
    let (mut inside, mut outside) = ([0.0, 0.0], None::<[f64; 2]>);
    let mut distance = if expected.is_finite() { expected.abs().min(reach) } else { reach };
    for _ in 0..TRIALS {
        let mut start = best.sizes.clone();
        start[size] = value + towards * distance;
        best = descend(problem, start, Some(size), MOST_STEPS)?;
        let root = (best.left.squares - found.left.squares).max(0.0).sqrt();
        if (root / wanted - 1.0).abs() < CLOSE {
            return Ok((value + towards * distance, false));
        }
        if root < wanted {
            inside = [distance, root];
            if distance >= reach {
                return Ok((last, true));
            }
        } else {
            outside = Some([distance, root]);
        }
        distance = match outside {
            None => (distance * (wanted / root.max(0.2 * wanted)).clamp(1.05, 4.0)).min(reach),
            Some([far, root]) => {
                let along = (wanted - inside[1]) / (root - inside[1]);
                inside[0] + (far - inside[0]) * along.clamp(0.05, 0.95)
            }
        };
    }
    Ok((value + towards * distance, false))
}
