//! A material's values formula after formula, in double precision from the same tables: what is printed as numbers, and
//! the reference of the registers that pictures are made with.

use glam::DVec3;
use rayon::prelude::*;

use super::evaluate::{FeatherBrdf, is_above};
use super::material::part_of_first;
use super::noise::{At, Draw};
use super::slope::Slope;
use super::table::{EXTRAS, Incident, LOBES, M2, MIDDLE, Node, REST, STRENGTH, Simplex, Table};
use super::tables::Reciprocity;
use crate::scattering::far_field::Polarization;
use crate::scattering::lobe::FitKind;
use crate::spectrum::wave_number_per_um;

/// What a material says about one pair of directions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Values {
    /// f of the instance asked for, or of the smooth mean; 1/sr, without the cosine.
    pub f: f64,
    /// The steady part s ≤ f̂ of the mean, which is the same in all instances; 1/sr.
    pub steady: f64,
    /// Density per sr with which ω_o is drawn.
    pub pdf: f64,
}

/// A [`FeatherBrdf`] at one wavelength and incident direction, in double precision.
#[derive(Debug, Clone)]
pub struct ExactBrdf<'a> {
    pub(super) brdf: &'a FeatherBrdf,
    wavelength_nm: f64,
    pub(super) incident: DVec3,
    /// None below the horizon.
    place: Option<(Incident, Simplex)>,
}

/// P of one set at one azimuth, rad⁻¹, and what else the nodes hold.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Across {
    pub(super) mean: f64,
    pub(super) steady: f64,
    pub(super) inverse_length: f64,
    correlation: f64,
    /// Polarization 1's part and its slope.
    first: [f64; 2],
}

impl FeatherBrdf {
    /// The formulas themselves at one wavelength (nm) and incident direction, to be used with many outgoing ones. Slower
    /// than [`prepare`](Self::prepare), which rounds to single precision.
    #[must_use]
    pub fn exact(&self, wavelength_nm: f64, wi: DVec3) -> ExactBrdf<'_> {
        let place = is_above(wi).then(|| {
            let incident = self.incident(wi);
            (incident, self.tables.grid.simplex(&incident, wavelength_nm))
        });
        ExactBrdf { brdf: self, wavelength_nm, incident: wi, place }
    }
}

impl ExactBrdf<'_> {
    /// Values towards ω_o: all zero unless both directions leave the surface.
    #[must_use]
    pub fn values(&self, wo: DVec3, instance: Option<u64>) -> Values {
        if self.place.is_none() || !is_above(wo) {
            return Values::default();
        }
        let draw = instance.map(|instance| self.brdf.noise().draw(instance));
        let there = || self.one_way(wo, draw.as_ref());
        let back = || self.brdf.exact(self.wavelength_nm, wo).one_way(self.incident, draw.as_ref());
        let both = |mean: &dyn Fn(f64, f64) -> f64| {
            let (there, back) = (there(), back());
            Values { f: mean(there.f, back.f), steady: mean(there.steady, back.steady), pdf: 0.0 }
        };
        let pair = [self.incident, wo];
        let mut values = match self.brdf.reciprocity {
            Reciprocity::AsFitted => there(),
            Reciprocity::Mean => both(&|there, back| 0.5 * (there + back)),
            Reciprocity::Steeper => {
                let (is_steeper, horizon) = (Reciprocity::is_steeper(pair), Reciprocity::at_horizon(pair));
                match (is_steeper, horizon > 0.0) {
                    (true, false) => back(),
                    (false, false) => there(),
                    (_, true) => both(&|there, back| {
                        let steeper = if is_steeper { back } else { there };
                        steeper + horizon * (there.max(0.0).sqrt() * back.max(0.0).sqrt() - steeper)
                    }),
                }
            }
        };
        values.pdf = self.density(wo);
        values
    }

    /// ∫ f (z·ω_o) dω_o of the smooth mean, before any symmetrization: what the mixed nodes reflect.
    #[must_use]
    pub fn reflected(&self) -> f64 {
        let Some((_, simplex)) = &self.place else { return 0.0 };
        let of = |table: &Table| -> f64 {
            (0..4).map(|k| f64::from(simplex.weight[k]) * table.reflected(simplex.at[k])).sum()
        };
        self.brdf.tables.sets.iter().map(of).sum::<f64>() / self.brdf.tables.sets.len() as f64
    }

    /// f and s before any symmetrization, without the density.
    fn one_way(&self, wo: DVec3, draw: Option<&Draw>) -> Values {
        let cos_o = wo.x.hypot(wo.z);
        let along = self.along([wo.y, cos_o]) / wo.z;
        let across = self.across([wo.x / cos_o, wo.z / cos_o], cos_o, draw);
        Values { f: along * across.f, steady: along * across.steady, pdf: 0.0 }
    }

    /// The factor along the barbule towards an ω_o by its y and cosθ_o.
    pub(super) fn along(&self, outgoing: [f64; 2]) -> f64 {
        let Some((incident, simplex)) = &self.place else { return 0.0 };
        let longitudinal = &self.brdf.tables.longitudinal;
        longitudinal.value(&longitudinal.mixed(simplex), incident.along, outgoing)
    }

    /// The factors across the barbule, in rad⁻¹, mean over the sets: f (of an instance) and s, at an azimuth by its sine and
    /// cosine. Noise and slope are those at this cosθ_o.
    pub(super) fn across(&self, [sin_phi, cos_phi]: [f64; 2], cos_theta: f64, draw: Option<&Draw>) -> Values {
        let tables = &self.brdf.tables.sets;
        let share = 1.0 / tables.len() as f64;
        let mut sum = Values::default();
        let [x, z] = [self.incident.x + cos_theta * sin_phi, self.incident.z + cos_theta * cos_phi];
        for (number, table) in tables.iter().enumerate() {
            let across = self.mixed(table, sin_phi, cos_phi);
            let first = part_of_first(across.first, self.facet([x, z]));
            let own = match self.brdf.tables.polarization_of(number) {
                Some(Polarization::First) => 2.0 * first,
                Some(Polarization::Second) => 2.0 - 2.0 * first,
                None => 1.0,
            };
            let across = Across { mean: own * across.mean, steady: own * across.steady, ..across };
            let of_instance = |draw| self.speckled(&across, number, first, [x, z], draw);
            sum.f += share * draw.map_or(across.mean, of_instance);
            sum.steady += share * across.steady;
        }
        sum
    }

    /// The slope of the facet that mirrors, on the side of the tables.
    fn facet(&self, [x, z]: [f64; 2]) -> f64 {
        let mirrored = self.place.as_ref().is_some_and(|(incident, _)| incident.mirrored);
        if mirrored { -x / z } else { x / z }
    }

    /// 1/l of each set.
    pub(super) fn inverse_lengths(&self, sin_phi: f64, cos_phi: f64) -> Vec<f64> {
        let of = |table: &Table| self.mixed(table, sin_phi, cos_phi).inverse_length;
        self.brdf.tables.sets.iter().map(of).collect()
    }

    /// f of an instance, S.25, each polarization with its own noise, at x = x_i + x_o and z = z_i + z_o.
    fn speckled(&self, across: &Across, set: usize, part: f64, [x, z]: [f64; 2], draw: &Draw) -> f64 {
        let slope = self.place.as_ref().map_or(Slope::default(), |(incident, _)| incident.corners.slope);
        let at = At {
            x: x * across.inverse_length,
            achromatic_x: x * slope.achromatic_inverse_length,
            height_phase_per_um: z * wave_number_per_um(self.wavelength_nm),
        };
        let [first, second] = self.brdf.noise().at_both(draw, &at, across.correlation);
        let of = |mean: f64, steady: f64, [qr, qi]: [f64; 2]| {
            let steady = steady.clamp(0.0, mean);
            let spread = (0.5 * (mean - steady)).sqrt();
            (spread * qr + steady.sqrt()).powi(2) + (spread * qi).powi(2)
        };
        let factor = draw.factor(slope.part([x, z], across.inverse_length), x);
        factor
            * match self.brdf.tables.polarization_of(set) {
                Some(Polarization::First) => of(across.mean, across.steady, first),
                Some(Polarization::Second) => of(across.mean, across.steady, second),
                None => {
                    let of =
                        |part: f64, noise| of(2.0 * part * across.mean, 2.0 * part * across.steady, noise);
                    0.5 * (of(part, first) + of(1.0 - part, second))
                }
            }
    }

    /// One set at one azimuth.
    fn mixed(&self, table: &Table, sin_phi: f64, cos_phi: f64) -> Across {
        let Some((incident, simplex)) = &self.place else { return Across::default() };
        let (tau, cos_phi) = incident.product(sin_phi, cos_phi, 1.0);
        let mut sum = Across::default();
        for k in 0..4 {
            let weight = f64::from(simplex.weight[k]);
            let node = &table.nodes[simplex.at[k] as usize];
            let turned = Turned::new(incident.corner(simplex.corners()[k]), tau, cos_phi);
            let mean =
                turned.shape(node, 0, self.brdf.tables.kind) + turned.shape(node, 1, self.brdf.tables.kind);
            sum.mean += weight * turned.stretch * mean;
            sum.steady += weight * turned.steady(node);
            let extra = |k: usize| weight * f64::from(node.0[EXTRAS + k]);
            sum.inverse_length += extra(0);
            sum.correlation += extra(1);
            sum.first[0] += extra(2);
            sum.first[1] += extra(3);
        }
        Across { steady: sum.steady.min(1.0) * sum.mean, ..sum }
    }

    /// Density per sr, over the sets in proportion to what they reflect.
    fn density(&self, wo: DVec3) -> f64 {
        let Some((incident, simplex)) = &self.place else { return 0.0 };
        let cos_o = wo.x.hypot(wo.z);
        let (tau, cosine) = incident.product(wo.x, wo.z, cos_o);
        let cos_phi = cosine / cos_o;
        let (mut sum, mut total) = (0.0, 0.0);
        for table in &self.brdf.tables.sets {
            for k in 0..4 {
                let weight = f64::from(simplex.weight[k]);
                let at = simplex.at[k] as usize;
                let turned = Turned::new(incident.corner(simplex.corners()[k]), tau, cos_phi);
                for lobe in 0..2 {
                    let share = f64::from(table.shares[at].0[lobe]);
                    sum += weight * turned.stretch * share * turned.drawn(&table.nodes[at], lobe);
                    total += weight * f64::from(table.shares[at].0[2 + lobe]);
                }
            }
        }
        let longitudinal = &self.brdf.tables.longitudinal;
        let along = longitudinal.density(&longitudinal.mixed(simplex), incident.along, [wo.y, cos_o]);
        sum / total * along
    }
}

/// An outgoing azimuth turned into that of a node, as τ = τ(φ_i) τ(φ_o).
struct Turned {
    tau: f64,
    /// τ(φ_i) of the node.
    tangent: f64,
    /// cosine of half the turned azimuth and 45° over the node's τ(φ_i).
    half_cosine: f64,
    z: f64,
    stretch: f64,
}

impl Turned {
    fn new([cos_theta, tangent]: [f64; 2], tau: f64, cos_phi: f64) -> Self {
        let half_cosine = 1.0 / tangent.hypot(tau);
        let cosine = 2.0 * tau * tangent * half_cosine * half_cosine;
        Self { tau, tangent, half_cosine, z: cos_theta * cosine, stretch: cosine / cos_phi }
    }

    /// m² + (1 − m²) h_x².
    fn half(&self, node: &Node, lobe: usize) -> f64 {
        let [m2, rest, middle] = [M2, REST, MIDDLE].map(|first| f64::from(node.0[first + lobe]));
        m2 + rest * ((self.tau - middle) * self.half_cosine).powi(2)
    }

    /// A lobe's value, rad⁻¹.
    fn shape(&self, node: &Node, lobe: usize, kind: FitKind) -> f64 {
        let [m2, middle, strength] = [M2, MIDDLE, STRENGTH].map(|first| f64::from(node.0[first + lobe]));
        let q = self.half(node, lobe);
        let aligned = match kind {
            FitKind::Marginal => (self.tau + middle) * self.half_cosine,
            FitKind::Cone => 1.0,
        };
        let root = (self.z * self.z + m2 * (1.0 - self.z * self.z)).sqrt();
        strength * aligned * self.z / (q * q * (self.z + root))
    }

    /// The part of the mean that is steady.
    fn steady(&self, node: &Node) -> f64 {
        f64::from(node.0[STRENGTH + LOBES - 1]) / self.half(node, LOBES - 1).powi(2)
    }

    /// A lobe's density over its share.
    fn drawn(&self, node: &Node, lobe: usize) -> f64 {
        let along = self.tangent + self.tau * f64::from(node.0[MIDDLE + lobe]) / self.tangent;
        along * self.half_cosine / self.half(node, lobe).powi(2)
    }
}

/// [`ExactBrdf::values`] at several wavelengths (nm) and towards several directions, `[wavelength][wo]`.
#[must_use]
pub fn values(
    brdf: &FeatherBrdf,
    wavelengths_nm: &[f64],
    wi: DVec3,
    wo: &[DVec3],
    instance: Option<u64>,
) -> Vec<Vec<Values>> {
    wavelengths_nm
        .iter()
        .map(|&nm| {
            let exact = brdf.exact(nm, wi);
            wo.par_iter().map(|&wo| exact.values(wo, instance)).collect()
        })
        .collect()
}
