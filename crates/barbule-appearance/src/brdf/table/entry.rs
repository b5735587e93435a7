//! What a table holds of one node of a material.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::super::material::{FeatherMaterial, LobeSet, ParameterSet, SteadySet, part_of_first};
use super::super::profile::Areas;
use super::super::sample::distribution;
use super::{EXTRAS, LEAST_SHARE, LOBES, M2, MIDDLE, Node, REST, STRENGTH, Shares};
use crate::scattering::lobe::{FitKind, Lobe};

/// One node of a set.
pub(super) struct Entry<'a> {
    pub(super) material: &'a FeatherMaterial,
    pub(super) set: &'a ParameterSet,
    pub(super) at: usize,
    pub(super) cos_theta: f64,
    pub(super) phi_i: f64,
    pub(super) areas: &'a Areas,
}

impl Entry<'_> {
    pub(super) fn node(&self) -> (Node, Shares) {
        let Self { material, set, at, .. } = *self;
        let mut node = Node([0.0; 16]);
        let mut shares = Shares([0.0; 4]);
        for number in 0..LOBES {
            let is_steady = number + 1 == LOBES;
            let lobe_of = |m: &[f32], phi: &[f32]| Lobe { m: f64::from(m[at]), phi: bounded(phi[at]) };
            let (lobe, reflected) = match set.mean.get(number) {
                _ if is_steady => {
                    let SteadySet { m, phi, share: part } = &set.steady;
                    (lobe_of(m, phi), f64::from(part[at]))
                }
                Some(LobeSet { m, phi, reflected }) => (lobe_of(m, phi), f64::from(reflected[at])),
                None => (Lobe { m: 1.0, phi: 0.0 }, 0.0),
            };
            let m2 = lobe.m * lobe.m;
            // ψ and the node's own, in which the middle is a tangent of each.
            let [(sine, cosine), (own_sine, own_cosine)] =
                [-lobe.phi, self.phi_i].map(|phi| libm::sincos(0.5 * phi + FRAC_PI_4));
            let strength = if is_steady {
                m2 * m2 * reflected.min(1.0)
            } else {
                let aligned = if material.kind == FitKind::Marginal { cosine } else { 1.0 };
                2.0 / PI * m2 * aligned * reflected / self.areas.area(lobe, self.cos_theta)
            };
            let rest = (1.0 - m2) * cosine * cosine;
            let middle = sine * own_sine / (cosine * own_cosine);
            for (first, value) in [(M2, m2), (REST, rest), (MIDDLE, middle), (STRENGTH, strength)] {
                node.0[first + number] = value as f32;
            }
            if !is_steady {
                let rest = (1.0 - m2).max(1e-12);
                let a = (m2 / rest).sqrt();
                let [first, last] = [-FRAC_PI_2, FRAC_PI_2]
                    .map(|phi_o| distribution(libm::sin(0.5 * (phi_o + lobe.phi)) / a));
                let drawn = reflected.max(LEAST_SHARE);
                shares.0[number] = (drawn * cosine * a.powi(3) * rest * rest / (PI * (last - first))) as f32;
                shares.0[2 + number] = drawn as f32;
            }
        }
        let [first, first_slope] = self.first_part();
        let extras =
            [material.inverse_length(set, at), f64::from(material.correlation[at]), first, first_slope];
        for (slot, extra) in node.0[EXTRAS..].iter_mut().zip(extras) {
            *slot = extra as f32;
        }
        (node, shares)
    }

    /// Polarization 1's part and its slope; one half in a set of one polarization, whose values are those of no other.
    fn first_part(&self) -> [f64; 2] {
        let ParameterSet { fraction_1, fraction_1_slope, .. } = self.set;
        match (fraction_1.get(self.at), fraction_1_slope.get(self.at)) {
            (Some(&first), Some(&slope)) => [first, slope].map(f64::from),
            _ => [0.5, 0.0],
        }
    }

    /// Polarization 1's part of what is reflected.
    pub(super) fn first_energy(&self) -> f64 {
        let (parts, at) = (self.first_part(), self.at);
        let (mut whole, mut first) = (0.0, 0.0);
        for LobeSet { m, phi, reflected } in &self.set.mean {
            let lobe = Lobe { m: f64::from(m[at]), phi: bounded(phi[at]) };
            let part = |phi_o: f64| part_of_first(parts, libm::tan(0.5 * (self.phi_i + phi_o)));
            let mean =
                self.areas.integral(lobe, self.cos_theta, part) / self.areas.area(lobe, self.cos_theta);
            whole += f64::from(reflected[at]);
            first += f64::from(reflected[at]) * mean;
        }
        if whole > 0.0 { first / whole } else { part_of_first(parts, 0.0) }
    }
}

/// φ_eff stays above the horizon.
fn bounded(phi: f32) -> f64 {
    let largest = FRAC_PI_2 - 1e-4;
    f64::from(phi).clamp(-largest, largest)
}
