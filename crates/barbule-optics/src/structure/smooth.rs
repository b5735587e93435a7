//! Inclusions with outlines as smooth as light sees them: what the fast simulation, which takes each column under the top for
//! itself, may be given in place of outlines that are finer than a wavelength.

use super::curve::grid;
use super::section::{Inclusion, Loop, Parts, Polyline, Section};
use crate::{Error, Result};

/// Points of a smoothed outline per standard deviation.
const POINTS_PER_DEVIATION: f64 = 5.0;

/// A Gaussian ends after so many standard deviations.
const GAUSSIAN_END: f64 = 4.0;

/// Only inclusions are smoothed that are longer than so many standard deviations: rods and granules stay as they are.
const LEAST_LENGTH: f64 = 12.0;

/// Standard deviations that make sense, µm.
const DEVIATIONS_UM: std::ops::RangeInclusive<f64> = 0.005..=1.0;

impl Section {
    /// The section with the middle line and the thickness of each long inclusion averaged along x, by a Gaussian of this standard
    /// deviation. Its ends keep their shape. Bubbles in a row, each shorter than a wavelength, become a layer of air of their
    /// mean thickness.
    ///
    /// # Errors
    /// A standard deviation outside 0.005 to 1 µm, or averages that cross other outlines.
    pub fn smoothed(&self, deviation_um: f64) -> Result<Self> {
        if !DEVIATIONS_UM.contains(&deviation_um) {
            return Err(Error::input(format!(
                "outlines averaged over {deviation_um} µm: give 0.005 to 1 µm"
            )));
        }
        let smooth = |inclusion: &Inclusion| {
            let outline = match &inclusion.outline {
                Loop::Polygon(corners) => Loop::Polygon(averaged(corners, deviation_um)),
                circle @ Loop::Circle { .. } => circle.clone(),
            };
            Inclusion { outline, ..inclusion.clone() }
        };
        let parts = Parts {
            name: self.name.clone(),
            width_um: Some(self.width_um),
            boundaries: self.boundaries.clone(),
            media: self.media.clone(),
            inclusions: self.inclusions.iter().map(smooth).collect(),
            crystal: self.crystal.clone(),
            source: self.source.clone(),
        };
        Self::new(parts, self.library.clone())
    }
}

/// The outline with its middle and thickness averaged; as it is where it is short.
fn averaged(corners: &Polyline, deviation_um: f64) -> Polyline {
    let xs = &corners.x_um;
    let by_x = |a: &usize, b: &usize| xs[*a].total_cmp(&xs[*b]);
    let Some((left, right)) = (0..xs.len()).min_by(by_x).zip((0..xs.len()).max_by(by_x)) else {
        return corners.clone();
    };
    let length = xs[right] - xs[left];
    if length < LEAST_LENGTH * deviation_um {
        return corners.clone();
    }
    let count = (length / deviation_um * POINTS_PER_DEVIATION).ceil() as usize + 1;
    let step = length / (count - 1) as f64;
    let middle_um = 0.5 * (xs[left] + xs[right]);
    let x_um: Vec<f64> = grid(length, count).iter().map(|x| x + middle_um).collect();
    let [one, other] = [side(corners, left, right), side(corners, right, left)];
    let heights = |line: &Polyline| -> Vec<f64> { x_um.iter().map(|&x| line.height(x)).collect() };
    let (one, other) = (heights(&one), heights(&other));
    let both = |of: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        let values: Vec<f64> = one.iter().zip(&other).map(|(a, b)| of(*a, *b)).collect();
        let smooth = blurred(&values, deviation_um / step);
        let blend = |(i, (value, smooth)): (usize, (&f64, f64))| {
            let from_end = i.min(count - 1 - i) as f64 * step;
            let weight = (from_end / deviation_um - 1.0).clamp(0.0, 1.0);
            value + (smooth - value) * weight
        };
        values.iter().zip(smooth).enumerate().map(blend).collect()
    };
    let (middle, half) = (both(&|a, b| 0.5 * (a + b)), both(&|a, b| 0.5 * (a - b)));
    let there = x_um.iter().zip(middle.iter().zip(&half)).map(|(x, (m, h))| (*x, m + h));
    // Both sides meet at the ends.
    let back = x_um.iter().zip(middle.iter().zip(&half)).map(|(x, (m, h))| (*x, m - h));
    let inner: Vec<(f64, f64)> = back.skip(1).take(count - 2).collect();
    let (x_um, z_um) = there.chain(inner.into_iter().rev()).unzip();
    Polyline { x_um, z_um }
}

/// One side of an outline between two of its corners, as a function of x.
fn side(corners: &Polyline, from: usize, to: usize) -> Polyline {
    let count = corners.x_um.len();
    let steps = (to + count - from) % count;
    let mut points: Vec<(f64, f64)> = (0..=steps)
        .map(|i| (from + i) % count)
        .map(|corner| (corners.x_um[corner], corners.z_um[corner]))
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.dedup_by(|a, b| a.0 == b.0);
    let (x_um, z_um) = points.into_iter().unzip();
    Polyline { x_um, z_um }
}

/// Values after a Gaussian of this standard deviation, in steps; near the ends over what there is.
fn blurred(values: &[f64], deviation: f64) -> Vec<f64> {
    let reach = (GAUSSIAN_END * deviation).ceil() as usize;
    let weights: Vec<f64> =
        (0..=reach).map(|k| libm::exp(-0.5 * (k as f64 / deviation) * (k as f64 / deviation))).collect();
    let at = |i: usize| {
        let about = i.saturating_sub(reach)..(i + reach + 1).min(values.len());
        let sums = about.map(|k| (weights[k.abs_diff(i)], values[k]));
        let (mass, sum) = sums.fold((0.0, 0.0), |(mass, sum), (w, v)| (mass + w, sum + w * v));
        sum / mass
    };
    (0..values.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::Structure;

    fn scalloped(deviation_um: f64) -> (Polyline, Polyline) {
        let count = 400;
        let x: Vec<f64> = (0..=count).map(|i| 2.0 * f64::from(i) / f64::from(count) - 1.0).collect();
        let half = |x: f64| (0.05 + 0.02 * libm::cos(60.0 * x)) * (1.0 - x.powi(8)).sqrt();
        let above: Vec<f64> = x.iter().map(|&x| 0.3 * x + half(x)).collect();
        let below = x.iter().rev().skip(1).take(count as usize - 1).map(|&x| 0.3 * x - half(x));
        let z_um = above.iter().copied().chain(below).collect();
        let x_um =
            x.iter().copied().chain(x.iter().rev().skip(1).take(count as usize - 1).copied()).collect();
        let corners = Polyline { x_um, z_um };
        let smooth = averaged(&corners, deviation_um);
        (corners, smooth)
    }

    fn area(line: &Polyline) -> f64 {
        let count = line.x_um.len();
        let cross = |i: usize| {
            let j = (i + 1) % count;
            line.x_um[i] * line.z_um[j] - line.x_um[j] * line.z_um[i]
        };
        0.5 * (0..count).map(cross).sum::<f64>().abs()
    }

    #[test]
    fn scallops_go_and_the_area_stays() {
        let (corners, smooth) = scalloped(0.06);
        assert!((area(&smooth) / area(&corners) - 1.0).abs() < 0.01, "{} {}", area(&smooth), area(&corners));
        for (x, z) in smooth.x_um.iter().zip(&smooth.z_um).filter(|(x, _)| x.abs() < 0.6) {
            let half = (z - 0.3 * x).abs();
            // e^{−(60·0.06)²/2} of the scallops are left.
            assert!((half - 0.05).abs() < 1e-3, "{x}: {half}");
        }
        // Too short for such an average.
        let (corners, smooth) = scalloped(0.2);
        assert_eq!(corners, smooth);
    }

    #[test]
    fn a_hummingbirds_bubbles_become_layers_and_other_species_stay() {
        let hummingbird = Structure::builtin("hummingbird").unwrap().instance(1, 0).unwrap();
        let smooth = hummingbird.smoothed(0.05).unwrap();
        assert_eq!(smooth.inclusions.len(), hummingbird.inclusions.len());
        assert_ne!(smooth, hummingbird);
        let section = Structure::builtin("starling").unwrap().instance(1, 0).unwrap();
        assert_eq!(section.smoothed(0.05).unwrap().boundaries, section.boundaries);
        assert!(section.smoothed(2.0).is_err() && section.smoothed(f64::NAN).is_err());
    }
}
