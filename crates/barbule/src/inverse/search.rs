//! From every region of the sizes to the least squares of each.

use rayon::prelude::*;

use super::Parameter;
use super::problem::{Left, Problem};
use super::small::{cholesky, solve};
use crate::Result;
use crate::math::golden::GoldenPoints;

/// Steps of one descent, at most.
pub(super) const MOST_STEPS: usize = 60;
/// Steps after which it is seen which descents lead anywhere.
const FIRST_STEPS: usize = 6;
/// A descent has arrived once a step changes no size by more than this part of its range.
const ARRIVED: f64 = 1e-8;
/// Points of a search over several sizes, at least and at most.
const POINTS: [usize; 2] = [600, 12_000];
/// Descents from the best of all points, at most: of one size, whose points miss nothing, and of several.
const MOST_ON_A_LINE: usize = 16;
const MOST_DESCENTS: usize = 32;

/// Sizes at a least sum of squares.
#[derive(Debug, Clone)]
pub(super) struct Found {
    pub(super) sizes: Vec<f64>,
    pub(super) left: Left,
}

/// About where the sum of squares is least, over the whole range, the best first, none twice.
pub(super) fn minima(problem: &Problem) -> Result<Vec<Found>> {
    let parameters = problem.model.parameters();
    let steps = problem.model.steps();
    let starts = match parameters {
        [one] => along_a_line(problem, one, steps[0])?,
        several => scattered(problem, several, &steps)?,
    };
    let mut found: Vec<Found> = starts
        .into_par_iter()
        .map(|start| descend(problem, start, None, FIRST_STEPS))
        .collect::<Result<_>>()?;
    found.sort_by(|a, b| a.left.squares.total_cmp(&b.left.squares));
    Ok(distinct(found, &steps))
}

/// The first of any that lie within half a step of each other.
pub(super) fn distinct(sorted: Vec<Found>, steps: &[f64]) -> Vec<Found> {
    let mut kept: Vec<Found> = Vec::new();
    for one in sorted {
        let same = |other: &Found| {
            let near = one.sizes.iter().zip(&other.sizes).zip(steps);
            near.into_iter().all(|((a, b), step)| (a - b).abs() < 0.5 * step)
        };
        if !kept.iter().any(same) {
            kept.push(one);
        }
    }
    kept
}

/// The lowest points between neighbours on a line, its ends among them.
fn along_a_line(problem: &Problem, parameter: &Parameter, step: f64) -> Result<Vec<Vec<f64>>> {
    let Parameter { low, high, .. } = *parameter;
    let count = ((high - low) / step).ceil().clamp(8.0, 100_000.0) as usize;
    let at = |k: usize| low + (high - low) * k as f64 / count as f64;
    let squares: Vec<f64> =
        (0..=count).into_par_iter().map(|k| problem.squares(&[at(k)])).collect::<Result<_>>()?;
    let lowest = |&k: &usize| {
        let beside = |other: Option<&f64>| other.is_none_or(|other| squares[k] <= *other);
        beside(k.checked_sub(1).map(|k| &squares[k])) && beside(squares.get(k + 1))
    };
    let mut places: Vec<usize> = (0..=count).filter(lowest).collect();
    places.sort_by(|a, b| squares[*a].total_cmp(&squares[*b]));
    places.truncate(MOST_ON_A_LINE);
    Ok(places.into_iter().map(|k| vec![at(k)]).collect())
}

/// The best points of a low-discrepancy sequence that lie apart from each other.
fn scattered(problem: &Problem, parameters: &[Parameter], steps: &[f64]) -> Result<Vec<Vec<f64>>> {
    let sequence = GoldenPoints::new(parameters.len());
    let cells: f64 =
        parameters.iter().zip(steps).map(|(p, step)| ((p.high - p.low) / step).max(1.0)).product();
    let points = (cells as usize).clamp(POINTS[0], POINTS[1]);
    let at = |k: usize| -> Vec<f64> {
        let place = |(axis, p): (usize, &Parameter)| p.low + (p.high - p.low) * sequence.at(k, axis);
        parameters.iter().enumerate().map(place).collect()
    };
    let mut tried: Vec<(f64, usize)> =
        (0..points).into_par_iter().map(|k| Ok((problem.squares(&at(k))?, k))).collect::<Result<_>>()?;
    tried.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut starts: Vec<Vec<f64>> = Vec::new();
    for (_, k) in tried {
        let point = at(k);
        let near = |other: &Vec<f64>| {
            point.iter().zip(other).zip(steps).all(|((a, b), step)| (a - b).abs() < 2.0 * step)
        };
        if !starts.iter().any(near) {
            starts.push(point);
        }
        if starts.len() == MOST_DESCENTS {
            break;
        }
    }
    Ok(starts)
}

/// The least squares that a way downhill leads to (Levenberg and Marquardt) within the range of each size; `held` is a size that
/// stays as it is.
pub(super) fn descend(
    problem: &Problem,
    start: Vec<f64>,
    held: Option<usize>,
    steps: usize,
) -> Result<Found> {
    let parameters = problem.model.parameters();
    let mut at = Found { left: problem.left(&start)?, sizes: start };
    let mut damping = 1e-3;
    for _ in 0..steps {
        let Some(step) = step(&at, parameters, held, damping) else { break };
        let next: Vec<f64> = at
            .sizes
            .iter()
            .zip(&step)
            .zip(parameters)
            .map(|((size, step), p)| (size + step).clamp(p.low, p.high))
            .collect();
        let moved = next.iter().zip(&at.sizes).zip(parameters);
        let moved = moved.map(|((a, b), p)| (a - b).abs() / (p.high - p.low)).fold(0.0, f64::max);
        let left = problem.left(&next)?;
        if left.squares <= at.left.squares {
            at = Found { sizes: next, left };
            damping = (damping * 0.1).max(1e-12);
            if moved < ARRIVED {
                break;
            }
        } else {
            damping *= 10.0;
            if moved < ARRIVED || damping > 1e10 {
                break;
            }
        }
    }
    Ok(at)
}

/// A damped step; 0 for what is held, for sizes that nothing depends on, and for those at an end of their range that would leave it.
fn step(at: &Found, parameters: &[Parameter], held: Option<usize>, damping: f64) -> Option<Vec<f64>> {
    let count = at.sizes.len();
    let normal = at.left.normal();
    let pull: Vec<f64> =
        at.left.slopes.iter().map(|slope| super::problem::product(slope, &at.left.residuals)).collect();
    let outward = |k: usize| {
        let (p, size) = (&parameters[k], at.sizes[k]);
        (size <= p.low && pull[k] < 0.0) || (size >= p.high && pull[k] > 0.0)
    };
    let free: Vec<usize> =
        (0..count).filter(|&k| held != Some(k) && normal[k * count + k] > 0.0 && !outward(k)).collect();
    if free.is_empty() {
        return None;
    }
    let matrix: Vec<f64> = free
        .iter()
        .flat_map(|&a| {
            let normal = &normal;
            free.iter().map(move |&b| normal[a * count + b] * if a == b { 1.0 + damping } else { 1.0 })
        })
        .collect();
    let mut change: Vec<f64> = free.iter().map(|&k| pull[k]).collect();
    solve(&cholesky(&matrix, free.len())?, &mut change);
    let mut step = vec![0.0; count];
    free.iter().zip(change).for_each(|(&k, change)| step[k] = change);
    Some(step)
}
