//! Round curves given by control points.

use super::geometry::{CurveNode, Geometry};
use crate::words;

/// A curve by its control points: x, y, z and radius, of one unit.
pub type ControlCurve = Vec<[f64; 4]>;

words! {
    /// How control points make a curve.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Basis {
        /// A uniform cubic B-spline, of points and radii: of n points n − 3 pieces, from near the second to near the last but
        /// one.
        "bspline": BSpline,
        /// Straight from each to the next.
        "linear": Linear,
    }
}

/// How far the segments of a curve may stray from it, over its least radius.
const STRAY: f32 = 0.02;

/// Most segments of one cubic piece.
const MOST_SEGMENTS: u32 = 64;

impl Basis {
    /// The fewest control points of a curve.
    #[must_use]
    pub fn least_points(self) -> usize {
        match self {
            Self::Linear => 2,
            Self::BSpline => 4,
        }
    }

    /// How many conical segments [`Geometry::add_control_curve`] makes of a curve.
    #[must_use]
    pub fn segments(self, points: &[CurveNode]) -> usize {
        match self {
            _ if points.len() < self.least_points() => 0,
            Self::Linear => points.len() - 1,
            Self::BSpline => points.windows(4).map(|four| segments(four) as usize).sum(),
        }
    }
}

impl Geometry {
    /// Adds a round curve by its control points, in conical segments that follow it within 2 % of its least radius. Fewer
    /// points than the basis needs add nothing.
    pub fn add_control_curve(&mut self, points: &[CurveNode], basis: Basis, id: u64) {
        if points.len() < basis.least_points() {
            return;
        }
        if basis == Basis::Linear {
            return self.add_curve(points, id);
        }
        let mut nodes = vec![at(&points[..4], 0.0)];
        for four in points.windows(4) {
            let count = segments(four);
            nodes.extend((1..=count).map(|k| at(four, k as f32 / count as f32)));
        }
        self.add_curve(&nodes, id);
    }
}

/// A chord over the share h of a cubic strays from it by at most h²/8 of the largest second derivative; that of a B-spline
/// is linear between the second differences of its points.
fn segments(four: &[CurveNode]) -> u32 {
    let bend = |i: usize| (four[i - 1].point - 2.0 * four[i].point + four[i + 1].point).length();
    let radius = four.iter().map(|node| node.radius).fold(f32::INFINITY, f32::min);
    let needed = (bend(1).max(bend(2)) / (8.0 * STRAY * radius.max(f32::MIN_POSITIVE))).sqrt();
    (needed.ceil() as u32).clamp(1, MOST_SEGMENTS)
}

/// A point of a cubic piece, `t` from 0 to 1.
fn at(four: &[CurveNode], t: f32) -> CurveNode {
    let r = 1.0 - t;
    let weights = [
        r * r * r / 6.0,
        (t * t * (3.0 * t - 6.0) + 4.0) / 6.0,
        (r * r * (3.0 * r - 6.0) + 4.0) / 6.0,
        t * t * t / 6.0,
    ];
    let mut node = CurveNode::default();
    for (point, weight) in four.iter().zip(weights) {
        node.point += point.point * weight;
        node.radius += point.radius * weight;
    }
    node
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn node(x: f32, y: f32, radius: f32) -> CurveNode {
        CurveNode { point: Vec3::new(x, y, 0.5), radius, ..CurveNode::default() }
    }

    /// Points in line are met at thirds' means, (a + 4b + c)/6; B-splines of linear data are linear.
    #[test]
    fn splines_begin_and_end_near_their_inner_points() {
        let points: Vec<CurveNode> =
            (0..5).map(|k| node(k as f32, 2.0 * k as f32, 0.1 + 0.01 * k as f32)).collect();
        let mut geometry = Geometry::default();
        geometry.add_control_curve(&points, Basis::BSpline, 3);
        let nodes = &geometry.curve_nodes;
        assert_eq!((geometry.curves.len(), nodes.len(), geometry.curves[0].id), (1, 3, 3));
        for (found, expected) in nodes.iter().zip([1.0, 2.0, 3.0]) {
            assert!((found.point - Vec3::new(expected, 2.0 * expected, 0.5)).length() < 1e-6);
            assert!((found.radius - 0.1 - 0.01 * expected).abs() < 1e-6);
        }
    }

    /// The curve between the nodes, evaluated by its definition in truncated cubes, stays within what is promised.
    #[test]
    fn segments_follow_a_bent_curve() {
        let points =
            [node(0.0, 0.0, 0.01), node(1.0, 0.3, 0.01), node(2.0, -0.4, 0.02), node(2.5, 1.0, 0.01)];
        let cube = |x: f32| x.max(0.0).powi(3) / 6.0;
        let basis = |x: f32| cube(x) - 4.0 * cube(x - 1.0) + 6.0 * cube(x - 2.0) - 4.0 * cube(x - 3.0);
        let mut geometry = Geometry::default();
        geometry.add_control_curve(&points, Basis::BSpline, 0);
        let nodes = &geometry.curve_nodes;
        assert!(nodes.len() > 5);
        assert_eq!(Basis::BSpline.segments(&points), nodes.len() - 1);
        for step in 0..=500 {
            let t = step as f32 / 500.0;
            let point: Vec3 = (0..4).map(|k| points[k].point * basis(t + 3.0 - k as f32)).sum();
            let away = nodes.windows(2).map(|pair| {
                let (a, along) = (pair[0].point, pair[1].point - pair[0].point);
                let share = ((point - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                (point - a - along * share).length()
            });
            assert!(away.fold(f32::INFINITY, f32::min) < 1.01 * STRAY * 0.01, "{t}");
        }
    }

    #[test]
    fn too_few_points_add_nothing_and_straight_curves_are_kept() {
        let points = [node(0.0, 0.0, 0.1), node(1.0, 0.0, 0.2), node(1.0, 1.0, 0.2)];
        let mut geometry = Geometry::default();
        geometry.add_control_curve(&points, Basis::BSpline, 0);
        assert_eq!(geometry.primitives(), 0);
        geometry.add_control_curve(&points, Basis::Linear, 0);
        assert_eq!(geometry.curve_nodes, points);
        assert_eq!((Basis::BSpline.segments(&points), Basis::Linear.segments(&points)), (0, 2));
    }
}
