//! How far a barbule's top bends across its width.

use super::{Polyline, Structure};
use crate::Result;

/// Top boundaries whose ends slope by more than this against each other are curved, as tangents.
const CURVED_SLOPE: f64 = 0.3;

/// Individuals that a bend is the mean of.
const MEASURED: usize = 50;

impl Structure {
    /// Where the top is an arch, how its normal leans at the edges towards −x and +x, rad, positive towards +x: those of the parabolas of
    /// least squares through the tops of 50 individuals, or of all given ones, in the mean.
    ///
    /// # Errors
    /// As [`instance`](Self::instance).
    pub fn edge_normals(&self, seed: u64) -> Result<Option<[f64; 2]>> {
        if !self.is_curved() {
            return Ok(None);
        }
        let count = self.count().unwrap_or(MEASURED).min(MEASURED);
        let mut sum = [0.0; 2];
        for index in 0..count {
            let own = edge_normals(self.instance(seed, index)?.top());
            sum = [sum[0] + own[0], sum[1] + own[1]];
        }
        Ok(Some(sum.map(|angle| angle / count as f64)))
    }
}

/// Of one top, by its parabola.
fn edge_normals(top: &Polyline) -> [f64; 2] {
    let last = top.x_um.len() - 1;
    let (left, right) = (top.x_um[0], top.x_um[last]);
    let (middle, half) = (0.5 * (left + right), 0.5 * (right - left));
    // Legendre's polynomials of u = −1 … 1 are orthogonal; points stand for the width about them.
    let (mut first, mut second) = (0.0, 0.0);
    for (x, z) in top.x_um.windows(2).zip(top.z_um.windows(2)) {
        let (u, z) = ((0.5 * (x[0] + x[1]) - middle) / half, 0.5 * (z[0] + z[1]));
        let share = (x[1] - x[0]) / half;
        first += 1.5 * share * z * u;
        second += 2.5 * share * z * 0.5 * (3.0 * u * u - 1.0);
    }
    [-1.0, 1.0].map(|u| -libm::atan((first + 3.0 * second * u) / half))
}

/// Whether the slopes of the left and the right third of a curve differ as an arch's do.
pub(super) fn is_arch(top: &Polyline) -> bool {
    let count = top.x_um.len();
    if count < 3 {
        return false;
    }
    let (left, right) = (top.x_um[0], top.x_um[count - 1]);
    let third = (right - left) / 3.0;
    let slope = |from: f64, to: f64| (top.height(to) - top.height(from)) / (to - from);
    slope(left, left + third) - slope(right - third, right) > CURVED_SLOPE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parabolas_have_the_slopes_of_their_ends() {
        let x_um: Vec<f64> = (0..=400).map(|k| 3.0 + f64::from(k) / 20.0).collect();
        // Slopes 0.1 + 0.4 and 0.1 − 0.4.
        let z_um = x_um.iter().map(|x| 7.0 + 0.1 * (x - 13.0) - 0.02 * (x - 13.0) * (x - 13.0)).collect();
        let [low, high] = edge_normals(&Polyline { x_um, z_um });
        assert!((low + 0.5_f64.atan()).abs() < 1e-4 && (high - 0.3_f64.atan()).abs() < 1e-4, "{low} {high}");
    }
}
