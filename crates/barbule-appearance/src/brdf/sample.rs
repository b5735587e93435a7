//! Sampling of ω_o in proportion to the mean lobes, without their shadowing.
//!
//! Of the nodes that are mixed one is chosen by its weight, of its two lobes one by what it reflects. Across the barbule
//! h = sin((φ_o + φ_eff)/2) follows 1/(a² + h²)², a = m/√(1−m²), a Student t with three degrees of freedom; along it t =
//! sin((θ_i + θ_o)/2) follows a mixture of normal distributions (the module `longitudinal`). Both are cut at the horizon, and
//! their densities know it, so that every draw leaves the surface.

use glam::DVec3;
use std::f64::consts::PI;

use super::arrays::{Arrays, TableArray};
use super::table::{Incident, M2, MIDDLE, Node, tangent};
use crate::Result;

/// From this a on, h is uniform within a relative 2e-6.
const UNIFORM: f64 = 1000.0;

/// Intervals of the tabulated inverse of h's distribution.
const INTERVALS: usize = 64;

/// What all draws share.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sampler {
    /// δ and dδ/ds at evenly spaced s; see [`Sampler::inverse`].
    nodes: Vec<[f64; 2]>,
}

impl Sampler {
    pub(super) fn new() -> Self {
        let nodes = (0..=INTERVALS)
            .map(|k| {
                let s = LAST * k as f64 / INTERVALS as f64;
                let delta = solve_kepler(s * s * s / 6.0);
                // dz/ds = s²/2, dz/dδ = 1 − cosδ; both vanish at 0, where the ratio is 1.
                let slope = if k == 0 { 1.0 } else { 0.5 * s * s / (1.0 - libm::cos(delta)) };
                [delta, slope]
            })
            .collect();
        Self { nodes }
    }

    pub(super) fn array(&self) -> TableArray<'_> {
        TableArray::new("student", &[INTERVALS + 1, 2], self.nodes.as_flattened())
    }

    pub(super) fn from_arrays(from: Arrays<'_>) -> Result<Self> {
        let nodes = from.get("student", &[INTERVALS + 1, 2], &[[0.0, 3.2], [0.5, 2.0]])?;
        Ok(Self { nodes: nodes.as_chunks().0.to_vec() })
    }

    /// sinφ_o and cosφ_o of a lobe of a node whose own φ_i has this τ, as the light's side sees them.
    pub(super) fn azimuth(
        &self,
        node: &Node,
        lobe: usize,
        incident: &Incident,
        own: f64,
        u: f64,
    ) -> [f64; 2] {
        let [m2, middle] = [M2, MIDDLE].map(|first| f64::from(node.0[first + lobe]));
        // Sine and cosine of φ_eff/2 from tan(π/4 − φ_eff/2).
        let middle = middle / own;
        let scale = std::f64::consts::FRAC_1_SQRT_2 / middle.hypot(1.0);
        let [sine, cosine] = [(1.0 - middle) * scale, (1.0 + middle) * scale];
        let a = (m2 / (1.0 - m2).max(1e-12)).sqrt();
        // sin((φ_o + φ_eff)/2) at both horizons.
        let (below, above) = (
            std::f64::consts::FRAC_1_SQRT_2 * (sine - cosine),
            std::f64::consts::FRAC_1_SQRT_2 * (sine + cosine),
        );
        let h = if a > UNIFORM {
            below + u * (above - below)
        } else {
            let (first, last) = (distribution(below / a), distribution(above / a));
            a * self.inverse(first + u * (last - first))
        };
        let h = h.clamp(below, above);
        let cos_h = (1.0 - h * h).sqrt();
        let (sin_eff, cos_eff) = (2.0 * sine * cosine, cosine * cosine - sine * sine);
        let (sin_2, cos_2) = (2.0 * h * cos_h, 1.0 - 2.0 * h * h);
        let (x, z) = (sin_2 * cos_eff - cos_2 * sin_eff, cos_2 * cos_eff + sin_2 * sin_eff);
        // Back from the node's azimuth.
        let ([above, below], [light, over]) = (tangent(x, z.max(0.0), 1.0), incident.tangent);
        let (above, below) = (above * own * over, below * light);
        let inverse = 1.0 / (above * above + below * below);
        [(above - below) * (above + below) * inverse, 2.0 * above * below * inverse]
    }

    /// The t of a value of [`distribution`] in (−½, ½).
    ///
    /// With t = cot(δ/2) the equation becomes Kepler's, δ − sinδ = z = π − 2π|v|. δ is smooth in s = ∛(6z): cubic
    /// interpolation is right to 1e-8 and one step of Newton's method to rounding.
    fn inverse(&self, v: f64) -> f64 {
        let z = (PI - 2.0 * PI * v.abs()).max(0.0);
        let position = (6.0 * z).cbrt() * (INTERVALS as f64 / LAST);
        let index = (position as usize).min(INTERVALS - 1);
        let (t, h) = (position - index as f64, LAST / INTERVALS as f64);
        let ([low, low_slope], [high, high_slope]) = (self.nodes[index], self.nodes[index + 1]);
        let u = 1.0 - t;
        let delta = low * u * u * (1.0 + 2.0 * t)
            + high * t * t * (3.0 - 2.0 * t)
            + h * t * u * (low_slope * u - high_slope * t);
        let (mut sin, mut cos) = (0.5 * delta).sin_cos();
        if delta > 1e-3 {
            // Half the step, by which sine and cosine are turned.
            let half = 0.25 * (delta - 2.0 * sin * cos - z) / (sin * sin);
            (sin, cos) = (sin - half * cos, cos + half * sin);
        }
        (cos / sin.max(1e-300)).copysign(v)
    }
}

/// ω_o from its angles' sines and cosines.
pub(super) fn direction(
    incident: &Incident,
    [sin_phi, cos_phi]: [f64; 2],
    [y, cos_theta]: [f64; 2],
) -> DVec3 {
    let x = if incident.mirrored { -sin_phi } else { sin_phi };
    DVec3::new(cos_theta * x, y, cos_theta * cos_phi)
}

/// Largest s: z = π.
const LAST: f64 = 2.661_340_078_986_675;

/// ∫₀^t 2/(π (1+s²)²) ds, between −½ and ½.
pub(super) fn distribution(t: f64) -> f64 {
    if t.abs() > 50.0 {
        // Two terms of the tail: relative error t⁻⁷.
        let inverse = 1.0 / (t * t);
        return (0.5 - inverse / (t.abs() * PI) * (2.0 / 3.0 - 0.8 * inverse)).copysign(t);
    }
    (t / (1.0 + t * t) + libm::atan(t)) / PI
}

/// The δ of δ − sinδ = z, 0 ≤ z ≤ π: the series in the cube root starts Newton's method within 2 %.
fn solve_kepler(z: f64) -> f64 {
    let s = libm::cbrt(6.0 * z);
    let s2 = s * s;
    let mut delta = s * (1.0 + s2 * (1.0 / 60.0 + s2 * (1.0 / 1400.0 + s2 / 25_200.0)));
    if delta > 1e-3 {
        for _ in 0..8 {
            let (sin, cos) = libm::sincos(delta);
            let step = (delta - sin - z) / (1.0 - cos);
            delta -= step;
            if step.abs() < 1e-14 {
                break;
            }
        }
    }
    delta
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_inverts() {
        let shared = Sampler::new();
        for k in 0..1000 {
            let v = -0.499_999 + 0.999_998 * f64::from(k) / 999.0;
            let t = shared.inverse(v);
            let back = distribution(t);
            assert!((back - v).abs() < 1e-12, "{v} {t} {back}");
        }
        assert!((distribution(50.0 + 1e-9) - distribution(50.0 - 1e-9)).abs() < 1e-12);
    }
}
