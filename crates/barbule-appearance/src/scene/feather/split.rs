//! What befalls a laid out vane: splits, where it gapes, and clumps of wet barbs.

use glam::DVec2;

use super::row::{FlatBarb, PATH_STEPS};
use super::{BarbShape, Disorder, Feather, SplitShape};
use crate::math::rng::{Stream, hash};

/// Splits lie within this part of the closed vane.
const PLACES: [f64; 2] = [0.06, 0.92];
/// Most of the distance of neighbours' ends that one split takes: two may meet, and barbs must not cross.
const MOST_CLOSED: f64 = 0.35;

/// Power of the arc length with which a turn grows.
const GROWTH: f64 = 1.5;
/// How far the direction of a barb's end turns over how far the end itself does.
const TANGENT: f64 = 1.0 + GROWTH;
/// Most of a barb's angle at its end by which that turns towards the tip, so that it does not point back to the shaft.
const MOST_TURNED: f64 = 0.25;

/// Opens the splits of one side's barbs; `name` names the draws.
pub(super) fn open(feather: &Feather, barbs: &mut [FlatBarb], name: u64) {
    let (shape, spacing) = (&feather.splits, 1e-3 * feather.barbs.spacing_um);
    let mut stream = Stream::new(name, &[]);
    let mut cuts: Vec<(f64, f64)> = Vec::new();
    for index in 0..poisson(0.5 * shape.count, &mut stream) {
        let place = feather.downy.share + (1.0 - feather.downy.share) * stream.uniform(PLACES[0], PLACES[1]);
        let Some(cut) = barbs.iter().position(|barb| barb.t >= place && !barb.is_tuft) else { continue };
        let longest = barbs[cut].length;
        let opening = shape.opening * Stream::new(name, &[index as u64]).uniform(0.6, 1.0);
        // Beyond the cut barbs turn towards the tip, and stand the closer.
        let end = angle_at_end(&feather.barbs, barbs[cut].angle);
        let closing = libm::sin(end - TANGENT * opening.min(MOST_TURNED * end)) / libm::sin(barbs[cut].angle);
        let room = MOST_CLOSED * spacing * closing.min(1.0);
        let reach = shape.reach.max(opening * longest / room);
        let middle = cut as f64 - 0.5;
        // Two splits whose reaches overlap would press the barbs between them together.
        if cut == 0 || cuts.iter().any(|(other, far)| (other - middle).abs() < 3.0 * (far + reach)) {
            continue;
        }
        cuts.push((middle, reach));
        turn_apart(barbs, &feather.barbs, middle, opening, reach);
        barbs[cut - 1].is_free[0] = true;
        barbs[cut].is_free[1] = true;
    }
}

/// Turns the barbs on both sides of a cut away from it, the more the nearer they are and the farther along them; those on its
/// proximal side slide under their neighbours.
fn turn_apart(barbs: &mut [FlatBarb], shape: &BarbShape, middle: f64, opening: f64, reach: f64) {
    let longest = barbs[(middle + 0.5) as usize].length;
    for (index, barb) in barbs.iter_mut().enumerate().filter(|(_, barb)| barb.looseness == 0.0) {
        let away = middle - index as f64;
        let near = libm::exp(-away.abs() / reach);
        if near < 1e-4 {
            continue;
        }
        let room = if away < 0.0 { MOST_TURNED * angle_at_end(shape, barb.angle) } else { opening };
        let most = (opening * near).min(room) * away.signum();
        let base = barb.path[0];
        for (i, point) in barb.path.iter_mut().enumerate() {
            // By arc length, so that neighbours of any length turn alike.
            let share = (i as f64 / PATH_STEPS as f64 * barb.length / longest).min(1.0);
            let turn = most * libm::pow(share, GROWTH);
            let (sin, cos) = (libm::sin(turn), libm::cos(turn));
            let v = *point - base;
            *point = base + DVec2::new(v.x * cos + v.y * sin, v.y * cos - v.x * sin);
        }
        if away > 0.0 {
            barb.under = 1e-3 * shape.spacing_um * near;
        }
    }
}

/// Angle to the shaft of a barb's end.
fn angle_at_end(shape: &BarbShape, angle: f64) -> f64 {
    angle - shape.curl_at(angle)
}

/// Draws the ends of barbs together in clumps about the middle barb of each.
pub(super) fn clump(disorder: &Disorder, barbs: &mut [FlatBarb]) {
    if disorder.clump <= 0.0 {
        return;
    }
    for group in barbs.chunks_mut(libm::round(disorder.clump_barbs) as usize) {
        let middle = group[group.len() / 2].path;
        for barb in group {
            for (i, point) in barb.path.iter_mut().enumerate() {
                let share = i as f64 / PATH_STEPS as f64;
                *point = point.lerp(middle[i], disorder.clump * share * share);
            }
        }
    }
}

/// A number of Poisson's distribution, by counting unit exponential waits.
fn poisson(mean: f64, stream: &mut Stream) -> usize {
    let mut waited = 0.0;
    for count in 0.. {
        waited -= libm::log(1.0 - stream.unit());
        if waited > mean {
            return count;
        }
    }
    0
}

impl SplitShape {
    /// Names the splits of one side.
    pub(super) fn name(side: u64) -> u64 {
        hash(side, &[4])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poisson_has_its_mean_and_variance() {
        let mut stream = Stream::new(5, &[]);
        let draws: Vec<f64> = (0..20_000).map(|_| poisson(1.7, &mut stream) as f64).collect();
        let mean = draws.iter().sum::<f64>() / draws.len() as f64;
        let variance = draws.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / draws.len() as f64;
        assert!((mean - 1.7).abs() < 0.04 && (variance - 1.7).abs() < 0.08, "{mean} {variance}");
        assert_eq!(poisson(0.0, &mut stream), 0);
    }
}
