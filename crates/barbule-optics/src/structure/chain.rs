//! Chains of touching melanosomes that form one scalloped layer.

use super::curve::Increasing;
use super::section::Polyline;
use crate::math::rng::Stream;

/// The fewest segments of an arc.
const FEWEST_SEGMENTS: usize = 5;

/// The upper and the lower boundary of a chain along `guide`, over the guide's whole length.
///
/// Circles of diameter `diameter`·U(1−`spread`, 1+`spread`) touch with their centres on the guide; neighbours are joined at
/// a notch whose half-height is a third of the smaller diameter.
pub(super) fn chain(
    stream: &mut Stream,
    guide: &Polyline,
    diameter: f64,
    spread: f64,
    spacing: f64,
) -> (Polyline, Polyline) {
    let mut walk = Walk::new(guide);
    let mut radii = Vec::new();
    let mut frames = Vec::new();
    let mut at = 0.0;
    let mut before = 0.0;
    loop {
        let radius = 0.5 * diameter * stream.uniform(1.0 - spread, 1.0 + spread);
        at += if radii.is_empty() { radius } else { before + radius };
        let Some(frame) = walk.frame(at) else { break };
        radii.push(radius);
        frames.push(frame);
        before = radius;
    }
    let (mut upper, mut lower) = (Increasing::default(), Increasing::default());
    for (i, (&radius, frame)) in radii.iter().zip(&frames).enumerate() {
        let notch = |neighbour: Option<&f64>| {
            libm::asin(neighbour.map_or(1.0, |n| n.min(radius) / radius) * (2.0 / 3.0))
        };
        let from = std::f64::consts::PI - notch(if i == 0 { None } else { radii.get(i - 1) });
        let to = notch(radii.get(i + 1));
        let segments = (((from - to) * radius / spacing).ceil() as usize).max(FEWEST_SEGMENTS);
        for step in 0..=segments {
            let angle = from + (to - from) * step as f64 / segments as f64;
            let (along, across) = (radius * libm::cos(angle), radius * libm::sin(angle));
            let ([x, z], [tx, tz]) = (frame.0, frame.1);
            upper.push(x + along * tx - across * tz, z + along * tz + across * tx);
            lower.push(x + along * tx + across * tz, z + along * tz - across * tx);
        }
    }
    (upper.curve, lower.curve)
}

/// Walks along a curve by arc length.
pub(super) struct Walk<'a> {
    curve: &'a Polyline,
    segment: usize,
    /// Arc length at the start of the segment.
    passed: f64,
}

impl<'a> Walk<'a> {
    pub(super) fn new(curve: &'a Polyline) -> Self {
        Self { curve, segment: 0, passed: 0.0 }
    }

    /// The point at an arc length not before the last one asked for, and the unit tangent there; `None` past the end.
    pub(super) fn frame(&mut self, length: f64) -> Option<([f64; 2], [f64; 2])> {
        let (xs, zs) = (&self.curve.x_um, &self.curve.z_um);
        loop {
            let i = self.segment;
            if i + 1 >= xs.len() {
                return None;
            }
            let (dx, dz) = (xs[i + 1] - xs[i], zs[i + 1] - zs[i]);
            let long = libm::hypot(dx, dz);
            if length - self.passed <= long {
                let t = (length - self.passed) / long;
                return Some(([xs[i] + t * dx, zs[i] + t * dz], [dx / long, dz / long]));
            }
            self.passed += long;
            self.segment += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_of_equal_circles_has_its_diameter_and_its_notches() {
        let guide = Polyline { x_um: vec![0.0, 2.0, 4.0], z_um: vec![0.0; 3] };
        let (upper, lower) = chain(&mut Stream::new(1, &[]), &guide, 0.3, 0.0, 0.01);
        assert!((upper.height(1.05) - 0.15).abs() < 2e-4);
        assert!((upper.height(1.2) - 0.1).abs() < 1e-12);
        assert!((lower.height(1.05) + 0.15).abs() < 2e-4);
        let thinnest = upper.z_um.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((thinnest - 0.1).abs() < 1e-12);
    }
}
