//! The outlines of whole barbules.

use super::curve::{Roughness, grid, mean, periodic, point_count};
use super::section::Polyline;
use crate::math::rng::Stream;

/// Where the half-ellipses are cut off, as a part of their half-height: the tips beyond it, where top and bottom
/// would run into each other, belong to neither.
const KEPT_HEIGHT: f64 = 0.7;

/// The top and the bottom of a flat slab with rounded ends.
///
/// A slab of `width` and `thickness` is closed by half-ellipses with axis ratio U(2,3):1; their tips are cut off at 0.7
/// of the half-height; x is scaled so that the top has `width` again, centred; a rough profile along the closed contour
/// is added to z (measured after the scaling, so that its correlation length holds for the finished outline; it
/// spans exactly its range on the top and on the bottom); then top and bottom are moved to mean heights 0 and −thickness.
pub(super) fn rounded(
    stream: &mut Stream,
    width: f64,
    thickness: f64,
    roughness: Roughness,
    spacing: f64,
) -> (Polyline, Polyline) {
    let half = 0.5 * thickness;
    let (left, right) = (half * stream.uniform(2.0, 3.0), half * stream.uniform(2.0, 3.0));
    let kept = libm::sqrt(1.0 - KEPT_HEIGHT * KEPT_HEIGHT);
    let total = width + kept * (left + right);
    let count = point_count(width, spacing);
    let x_um = grid(width, count);
    let base: Vec<f64> = x_um
        .iter()
        .map(|x| {
            let along = (x / width + 0.5) * total;
            let past =
                |axis: f64, reach: f64| half * libm::sqrt((1.0 - (reach / axis) * (reach / axis)).max(0.0));
            if along < kept * left {
                past(left, kept * left - along)
            } else if along > kept * left + width {
                past(right, along - kept * left - width)
            } else {
                half
            }
        })
        .collect();
    // Clockwise along the contour: top, right tip, bottom from right to left, left tip.
    let lengths: Vec<f64> = std::iter::once(0.0)
        .chain((1..count).scan(0.0, |sum, i| {
            *sum += libm::hypot(x_um[i] - x_um[i - 1], base[i] - base[i - 1]);
            Some(*sum)
        }))
        .collect();
    let length = lengths[count - 1];
    let tip = 2.0 * KEPT_HEIGHT * half;
    let period = 2.0 * (length + tip);
    let samples = point_count(period, spacing);
    let step = period / samples as f64;
    let wave = periodic(stream, roughness.correlation_um, period, samples, step);
    let value = |s: f64| {
        let at = s / step;
        let (i, part) = (at as usize % samples, at - libm::floor(at));
        wave[i] * (1.0 - part) + wave[(i + 1) % samples] * part
    };
    let side = |sign: f64, at: &dyn Fn(usize) -> f64, height: f64| {
        let mut rough: Vec<f64> = (0..count).map(|i| value(at(i))).collect();
        roughness.span(&mut rough);
        let mut z_um: Vec<f64> = base.iter().zip(&rough).map(|(z, r)| sign * z + r).collect();
        let shift = height - mean(&z_um);
        z_um.iter_mut().for_each(|z| *z += shift);
        Polyline { x_um: x_um.clone(), z_um }
    };
    let top = side(1.0, &|i| lengths[i], 0.0);
    let bottom = side(-1.0, &|i| 2.0 * length + tip - lengths[i], -thickness);
    (top, bottom)
}

/// An arc of an ellipse that ends with the slope ±tanβ, sampled at equal arc length, with a rough profile along x, moved
/// to the mean height `height`.
///
/// Half-axes a = W/(2 cosΦ), b = a tanΦ tanβ, swept from π−Φ to Φ; `phi` in rad.
pub(super) fn arched(
    stream: &mut Stream,
    width: f64,
    phi: f64,
    tan_beta: f64,
    roughness: Roughness,
    spacing: f64,
    height: f64,
) -> Polyline {
    let (sin, cos) = (libm::sin(phi), libm::cos(phi));
    let a = 0.5 * width / cos;
    let b = a * (sin / cos) * tan_beta;
    // A fine sampling in the angle, then points at equal arc length on it.
    let fine = 4 * point_count(width, spacing);
    let angle =
        |i: usize| std::f64::consts::PI - phi - (std::f64::consts::PI - 2.0 * phi) * i as f64 / fine as f64;
    let mut lengths = vec![0.0; fine + 1];
    for i in 1..=fine {
        let (s, t) = (angle(i - 1), angle(i));
        let dx = a * (libm::cos(t) - libm::cos(s));
        let dz = b * (libm::sin(t) - libm::sin(s));
        lengths[i] = lengths[i - 1] + libm::hypot(dx, dz);
    }
    let count = point_count(lengths[fine], spacing);
    let step = lengths[fine] / (count - 1) as f64;
    let rough = roughness.along(stream, count, step);
    let mut curve = Polyline { x_um: Vec::with_capacity(count), z_um: Vec::with_capacity(count) };
    let mut after = 1;
    for (i, r) in rough.iter().enumerate() {
        let s = i as f64 * step;
        while after < fine && lengths[after] < s {
            after += 1;
        }
        let part = (s - lengths[after - 1]) / (lengths[after] - lengths[after - 1]);
        let t = angle(after - 1) + (angle(after) - angle(after - 1)) * part;
        curve.x_um.push(a * libm::cos(t));
        curve.z_um.push(b * libm::sin(t) + r);
    }
    // The ends exactly, where rounding left them within 1e-12.
    curve.x_um[0] = -0.5 * width;
    curve.x_um[count - 1] = 0.5 * width;
    let shift = height - mean(&curve.z_um);
    curve.z_um.iter_mut().for_each(|z| *z += shift);
    curve
}
