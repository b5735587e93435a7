//! The lattice on which rods stand.

use super::fit::Normal;
use super::rods::Rod;
use super::spread::Spread;

/// A lattice of rods in px. Rows run along `turn_deg`, which is the direction nearest to the picture's x.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice {
    /// Distance of neighbours in a row; the spread is that of single distances.
    pub period: Spread,
    /// Distance of rows; the spread is that of single ones.
    pub row_pitch: Spread,
    /// By how much of the period each row is moved against the one above, 0 to 0.5.
    pub row_shift: Spread,
    /// Outer diameters.
    pub diameter: Spread,
    /// Diameters of the air inside; 0 where most rods are solid.
    pub hollow: Spread,
    /// How many rows there are.
    pub rows: usize,
    /// Direction of the rows, degrees, from the picture's x towards its lower edge.
    pub turn_deg: f64,
    /// The middle of each row's first and last rod, px, from the first row down.
    pub ends: Vec<[[f64; 2]; 2]>,
    /// Root mean square of what rods lie beside their places, px.
    pub misfit: f64,
}

/// Rows within this angle of the picture's x are looked for first.
const MOST_TURN: f64 = 0.45;
/// Rods beside their places by more than this part of the period are no lattice.
const MOST_MISFIT: f64 = 0.2;
/// A lattice has this many rods.
const LEAST_RODS: usize = 6;

/// The lattice of rods, if they stand on one.
pub(super) fn lattice_of(rods: &[Rod]) -> Option<Lattice> {
    if rods.len() < LEAST_RODS {
        return None;
    }
    let places: Vec<[f64; 2]> = rods.iter().map(|rod| rod.middle).collect();
    let (turn, period) = along_rows(&places)?;
    let mut rows = rows_of(&places, turn, period)?;
    // Twice, since the first direction is that of neighbours only.
    let turn = turn + tilt_of(&places, turn, &rows)?;
    rows = rows_of(&places, turn, period)?;
    measured(rods, turn, period, &rows)
}

/// The direction of rows, radians, and the distance of neighbours in them.
fn along_rows(places: &[[f64; 2]]) -> Option<(f64, f64)> {
    let mut nearest: Vec<f64> = Vec::new();
    for (i, a) in places.iter().enumerate() {
        let apart =
            places.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
        nearest.push(apart.fold(f64::INFINITY, f64::min));
    }
    let near = super::field::part(&mut nearest, 0.5);
    // Steps between neighbours to the right that are nearly level; in rows farther apart than rods of the next row, too.
    let mut steps: Vec<(f64, f64)> = Vec::new();
    for a in places {
        let right = places.iter().filter_map(|b| {
            let [x, y] = [b[0] - a[0], b[1] - a[1]];
            let (length, angle) = (x.hypot(y), y.atan2(x));
            (angle.abs() < MOST_TURN && (0.3 * near..2.6 * near).contains(&length)).then_some((length, angle))
        });
        steps.extend(right.min_by(|a, b| a.0.total_cmp(&b.0)));
    }
    if steps.len() * 3 < places.len() {
        return None;
    }
    let mut angles: Vec<f64> = steps.iter().map(|(_, angle)| *angle).collect();
    let angle = super::field::part(&mut angles, 0.5);
    let mut lengths: Vec<f64> =
        steps.iter().filter(|(_, a)| (a - angle).abs() < 0.12).map(|(length, _)| *length).collect();
    Some((angle, super::field::part(&mut lengths, 0.5)))
}

/// A place along rows and across them.
fn turned([x, y]: [f64; 2], turn: f64) -> [f64; 2] {
    let (sin, cos) = turn.sin_cos();
    [cos * x + sin * y, cos * y - sin * x]
}

/// The rods of each row from the first row down, each row from left to right.
fn rows_of(places: &[[f64; 2]], turn: f64, period: f64) -> Option<Vec<Vec<usize>>> {
    let at = |rod: &usize| turned(places[*rod], turn);
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|a, b| at(a)[1].total_cmp(&at(b)[1]));
    let mut rows: Vec<Vec<usize>> = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for rod in order {
        // Rows are no nearer than half the period; those of the densest packing are at 0.87.
        let here = at(&rod)[1];
        if here - last > 0.25 * period {
            rows.push(Vec::new());
        }
        last = here;
        rows.last_mut()?.push(rod);
    }
    rows.iter_mut().for_each(|row| row.sort_by(|a, b| at(a)[0].total_cmp(&at(b)[0])));
    Some(rows)
}

/// How the rows lie turned against the direction in which they were found, radians.
fn tilt_of(places: &[[f64; 2]], turn: f64, rows: &[Vec<usize>]) -> Option<f64> {
    let (mut upper, mut lower) = (0.0, 0.0);
    for row in rows.iter().filter(|row| row.len() > 1) {
        let at: Vec<[f64; 2]> = row.iter().map(|rod| turned(places[*rod], turn)).collect();
        let mean = [0, 1].map(|i| at.iter().map(|p| p[i]).sum::<f64>() / at.len() as f64);
        for p in &at {
            upper += (p[0] - mean[0]) * (p[1] - mean[1]);
            lower += (p[0] - mean[0]).powi(2);
        }
    }
    (lower > 0.0).then(|| (upper / lower).atan())
}

fn measured(rods: &[Rod], turn: f64, period: f64, rows: &[Vec<usize>]) -> Option<Lattice> {
    let at = |rod: usize| turned(rods[rod].middle, turn);
    // Number in the row by its distance from the row's first; x = start of the row + number · period, z = depth of the row.
    let mut normal = Normal::new(rows.len() + 1);
    let mut depths = Vec::new();
    let mut gaps = Vec::new();
    let mut numbers: Vec<(usize, usize, f64)> = Vec::new();
    let mut near = period;
    for (index, row) in rows.iter().enumerate() {
        let depth = row.iter().map(|rod| at(*rod)[1]).sum::<f64>() / row.len() as f64;
        depths.push(depth);
        let mut number = 0.0;
        for (k, rod) in row.iter().enumerate() {
            if k > 0 {
                let step = at(*rod)[0] - at(row[k - 1])[0];
                let steps = (step / near).round().max(1.0);
                number += steps;
                gaps.push(step / steps);
                near = 0.9 * near + 0.1 * step / steps;
            }
            numbers.push((index, *rod, number));
        }
    }
    for (row, rod, number) in &numbers {
        let mut equation = vec![0.0; rows.len() + 1];
        equation[0] = *number;
        equation[row + 1] = 1.0;
        normal.add(&equation, at(*rod)[0]);
    }
    let found = normal.solved()?;
    let mean = found[0];
    if gaps.is_empty() || mean <= 0.0 {
        return None;
    }
    let beside = numbers.iter().map(|(row, rod, number)| {
        let [x, z] = at(*rod);
        let [dx, dz] = [x - found[row + 1] - number * mean, z - depths[*row]];
        dx * dx + dz * dz
    });
    let misfit = (beside.sum::<f64>() / numbers.len() as f64).sqrt();
    let pitches: Vec<f64> = depths.windows(2).map(|d| d[1] - d[0]).collect();
    let shifts: Vec<f64> = found[1..]
        .windows(2)
        .map(|starts| {
            let shift = ((starts[1] - starts[0]) / mean).rem_euclid(1.0);
            shift.min(1.0 - shift)
        })
        .collect();
    let usual = super::field::part(&mut pitches.clone(), 0.5);
    let even = pitches.iter().all(|pitch| (pitch - usual).abs() < 0.35 * usual);
    if misfit > MOST_MISFIT * mean || !even {
        return None;
    }
    let hollows: Vec<f64> = rods.iter().map(|rod| rod.hollow).filter(|d| *d > 0.0).collect();
    let diameters: Vec<f64> = rods.iter().map(|rod| rod.diameter).collect();
    let row_pitch = Spread {
        // Of all rows, as the distance of the first and the last.
        mean: depths.first().zip(depths.last()).map_or(0.0, |(a, b)| (b - a) / pitches.len().max(1) as f64),
        ..Spread::of(&pitches)
    };
    Some(Lattice {
        period: Spread { mean, ..Spread::of(&gaps) },
        row_pitch,
        row_shift: Spread::of(&shifts),
        diameter: Spread::of(&diameters),
        hollow: if 2 * hollows.len() > rods.len() { Spread::of(&hollows) } else { Spread::default() },
        rows: rows.len(),
        turn_deg: turn.to_degrees(),
        ends: rows.iter().map(|row| [rods[row[0]].middle, rods[row[row.len() - 1]].middle]).collect(),
        misfit,
    })
}
