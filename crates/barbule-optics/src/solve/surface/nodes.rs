//! Where the radiation kernel is evaluated: at every quadrature point, or at equidistant nodes onto which points are
//! moved.
//!
//! Along a smooth top the kernel e^{−jκ(x sinφ_o + z cosφ_o)} is, as a function of arc length, band-limited to κ. So
//! a current at any point radiates like weighted currents at the [`TAPS`] nodes around it. What the node curve misses
//! of the true position (the sagitta between vertices) enters as a phase for the mirror direction. A top with corners is
//! cut there; every piece has nodes of its own that run past its ends along the end tangents.

use super::points::Points;
use crate::math::band_limited::{NODES_PER_PERIOD, TAPS, weights};
use crate::math::simd::Real;

/// Positions at which currents radiate.
pub(super) struct Nodes<T> {
    /// Across.
    pub(super) x_um: Vec<f64>,
    /// Up.
    pub(super) z_um: Vec<f64>,
    /// How points are moved onto nodes; `None` where nodes are the points.
    pub(super) taps: Option<Taps>,
    /// How far each point lies above where its nodes stand for it, µm.
    pub(super) rise_um: Vec<T>,
}

/// For each point, the first of its [`TAPS`] nodes and their weights.
pub(super) struct Taps {
    pub(super) first: Vec<u32>,
    pub(super) weights: Vec<[f32; TAPS]>,
}

/// How many nodes a smooth top of this arc length needs, about, for transverse wave numbers up to `kappa` (rad/µm).
pub(super) fn nodes_for(arc_um: f64, kappa: f64) -> usize {
    (arc_um * NODES_PER_PERIOD * kappa / std::f64::consts::TAU) as usize + 4 * TAPS
}

impl<T: Real> Nodes<T> {
    /// The points themselves: exact.
    pub(super) fn at_points(points: &Points) -> Self {
        Self {
            x_um: points.double.x_um.clone(),
            z_um: points.double.z_um.clone(),
            taps: None,
            rise_um: vec![T::of(0.0); points.padded()],
        }
    }

    /// Equidistant nodes for transverse wave numbers up to `kappa` (rad/µm), or the points where these are fewer.
    pub(super) fn equidistant(points: &Points, kappa: f64) -> Self {
        let step = std::f64::consts::TAU / (NODES_PER_PERIOD * kappa);
        let padded = points.padded();
        let lead = TAPS / 2 - 1;
        let mut nodes =
            Self { x_um: Vec::new(), z_um: Vec::new(), taps: None, rise_um: vec![T::of(0.0); padded] };
        let mut taps = Taps { first: vec![0; padded], weights: vec![[0.0; TAPS]; padded] };
        let mut start = 0;
        for &end in &points.pieces {
            if end == start {
                continue;
            }
            let base = nodes.x_um.len();
            // One node more than the taps reach, so that rounding cannot fall off the end.
            let origin = points.arc_um[start] - (lead + 1) as f64 * step;
            let span = points.arc_um[end - 1] - origin;
            let count = (span / step) as usize + 2 + TAPS - lead;
            let mut right = start;
            for node in 0..count {
                let arc = origin + node as f64 * step;
                while right < end && points.arc_um[right] < arc {
                    right += 1;
                }
                let (x, z) = position(points, start, end, right, arc);
                nodes.x_um.push(x);
                nodes.z_um.push(z);
            }
            for p in start..end {
                let u = (points.arc_um[p] - origin) / step;
                let cell = u as usize;
                let w = weights(u - cell as f64);
                let first = base + cell - lead;
                let rise: f64 = (0..TAPS)
                    .map(|k| f64::from(w[k]) * (points.double.z_um[p] - nodes.z_um[first + k]))
                    .sum();
                nodes.rise_um[p] = T::of(rise);
                taps.first[p] = first as u32;
                taps.weights[p] = w;
            }
            start = end;
        }
        // Padding has no weight; it only must lead to nodes that exist.
        for p in points.count..padded {
            taps.first[p] = taps.first[points.count - 1];
        }
        if nodes.x_um.len() >= padded {
            return Self::at_points(points);
        }
        // Whole vectors for the matrix product.
        let fill = nodes.x_um.len().next_multiple_of(8);
        nodes.x_um.resize(fill, 0.0);
        nodes.z_um.resize(fill, 0.0);
        nodes.taps = Some(taps);
        nodes
    }
}

/// The curve at an arc length: between the points around it, or on the line through an end along its tangent.
fn position(points: &Points, start: usize, end: usize, right: usize, arc: f64) -> (f64, f64) {
    let along = |p: usize| {
        let d = arc - points.arc_um[p];
        (
            points.double.x_um[p] + d * points.double.tangent_x[p],
            points.double.z_um[p] + d * points.double.tangent_z[p],
        )
    };
    if right == start {
        return along(start);
    }
    if right == end {
        return along(end - 1);
    }
    let left = right - 1;
    let t = (arc - points.arc_um[left]) / (points.arc_um[right] - points.arc_um[left]);
    let mix = |values: &[f64]| values[left] + t * (values[right] - values[left]);
    (mix(&points.double.x_um), mix(&points.double.z_um))
}
