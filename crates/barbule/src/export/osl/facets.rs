//! Microfacets as Cycles has them: what its closures `microfacet("ggx" | "beckmann", …)` evaluate to.

use std::f64::consts::{PI, TAU};

use crate::DVec3;

/// How slopes of facets are distributed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Distribution {
    /// Trowbridge & Reitz 1975, as Walter et al. 2007 have it: long tails.
    Ggx,
    /// Beckmann & Spizzichino 1963: Gaussian.
    Beckmann,
}

impl Distribution {
    /// What the closure calls it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ggx => "ggx",
            Self::Beckmann => "beckmann",
        }
    }
}

/// A rough mirror without Fresnel's factor, in the barbule's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facets {
    /// Of their slopes.
    pub distribution: Distribution,
    /// α along the barbule (y).
    pub along: f64,
    /// α across it (x).
    pub across: f64,
}

impl Facets {
    /// Density of normals per sr of the surface.
    fn density(&self, h: DVec3) -> f64 {
        let (x, y) = (h.x / (self.across * h.z), h.y / (self.along * h.z));
        let square = x * x + y * y;
        let shape = match self.distribution {
            Distribution::Ggx => 1.0 / ((1.0 + square) * (1.0 + square)),
            Distribution::Beckmann => libm::exp(-square),
        };
        shape / (PI * self.across * self.along * h.z.powi(4))
    }

    /// Smith's Λ; of Beckmann the rational fit of Walter et al. 2007, equation 23, which Cycles takes too.
    fn lambda(&self, w: DVec3) -> f64 {
        let square = ((w.x * self.across).powi(2) + (w.y * self.along).powi(2)) / (w.z * w.z).max(1e-30);
        match self.distribution {
            Distribution::Ggx => 0.5 * ((1.0 + square).sqrt() - 1.0),
            Distribution::Beckmann => {
                let a = 1.0 / square.max(1e-30).sqrt();
                if a >= 1.6 { 0.0 } else { (1.0 - a * (1.259 - 0.396 * a)) / (a * (3.535 + 2.181 * a)) }
            }
        }
    }

    /// f cosθ_o in 1/sr, with masking and shadowing that know of each other.
    #[must_use]
    pub fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        let h = (wi + wo).normalize();
        let shadowed = 1.0 / (1.0 + self.lambda(wi) + self.lambda(wo));
        self.density(h) * shadowed / (4.0 * wi.z)
    }

    /// ∫ f cosθ_o dω_o: by the normals themselves, in even steps of their distribution, so many of each of two numbers.
    pub(super) fn albedo(&self, wi: DVec3, steps: usize) -> f64 {
        let mut sum = 0.0;
        for i in 0..steps {
            let u = (i as f64 + 0.5) / steps as f64;
            let slope = match self.distribution {
                Distribution::Ggx => u / (1.0 - u),
                Distribution::Beckmann => -libm::log(1.0 - u),
            }
            .sqrt();
            for j in 0..steps {
                let turn = TAU * (j as f64 + 0.5) / steps as f64;
                let slopes = [self.across * libm::cos(turn), self.along * libm::sin(turn)].map(|s| s * slope);
                let h = DVec3::new(-slopes[0], -slopes[1], 1.0).normalize();
                let seen = wi.dot(h);
                let wo = 2.0 * seen * h - wi;
                if seen > 0.0 && wo.z > 0.0 {
                    // A facet covers its cosine of the surface.
                    sum += seen / (wi.z * h.z * (1.0 + self.lambda(wi) + self.lambda(wo)));
                }
            }
        }
        sum / (steps * steps) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The two ways to an albedo agree: by the normals, and by the light, midpoint rule over the hemisphere.
    #[test]
    fn albedos_are_the_integral_of_values() {
        let wi = DVec3::new(0.4, 0.3, 0.8).normalize();
        for distribution in [Distribution::Ggx, Distribution::Beckmann] {
            let facets = Facets { distribution, along: 0.15, across: 0.3 };
            let (side, mut sum) = (1200, 0.0);
            for i in 0..side {
                for j in 0..side {
                    let [x, y] = [i, j].map(|k| (2.0 * f64::from(k) + 1.0) / f64::from(side) - 1.0);
                    let z2 = 1.0 - x * x - y * y;
                    if z2 > 0.0 {
                        let wo = DVec3::new(x, y, z2.sqrt());
                        sum += facets.value(wi, wo) / wo.z * (2.0 / f64::from(side)).powi(2);
                    }
                }
            }
            let found = facets.albedo(wi, 32);
            assert!((found / sum - 1.0).abs() < 0.01, "{distribution:?}: {found} {sum}");
            // Some light is lost between facets, not more than that.
            assert!((0.8..1.0).contains(&found), "{distribution:?}: {found}");
        }
    }

    /// What Blender 5.0.1 renders of a plane in a white world, seen from so many degrees towards x, with 65,536 samples (its draws of
    /// Beckmann normals are approximate):
    /// `microfacet(distribution, N, T, 0.3, α, 0, 0)` with T along x.
    #[test]
    fn albedos_are_those_that_cycles_renders() {
        let rendered = [
            (Distribution::Ggx, 0.05, [0.9329, 0.9124, 0.8642]),
            (Distribution::Ggx, 0.4, [0.8291, 0.8071, 0.7856]),
            (Distribution::Beckmann, 0.05, [1.0, 0.9885, 0.9188]),
            (Distribution::Beckmann, 0.4, [0.9958, 0.9608, 0.8936]),
        ];
        for (distribution, along, expected) in rendered {
            let facets = Facets { distribution, along, across: 0.3 };
            for (degrees, expected) in [0.0_f64, 40.0, 70.0].into_iter().zip(expected) {
                let angle = degrees.to_radians();
                let found = facets.albedo(DVec3::new(angle.sin(), 0.0, angle.cos()), 64);
                assert!((found - expected).abs() < 0.01, "{facets:?} {degrees}: {found} {expected}");
            }
        }
    }

    #[test]
    fn values_change_places() {
        let facets = Facets { distribution: Distribution::Beckmann, along: 0.1, across: 0.4 };
        let (a, b) = (DVec3::new(0.3, 0.1, 0.9).normalize(), DVec3::new(-0.5, 0.0, 0.7).normalize());
        let [there, back] = [facets.value(a, b) / b.z, facets.value(b, a) / a.z];
        assert!((there / back - 1.0).abs() < 1e-12);
    }
}
