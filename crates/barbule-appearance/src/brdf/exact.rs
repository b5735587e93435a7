//! A material's values formula after formula, in double precision from the same tables: what is printed as numbers, and
//! the reference of the registers that pictures are made with.

use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

use super::evaluate::FeatherBrdf;
use super::noise::{Draw, Noise};
use super::sample::half_distribution;
use super::table::{INVERSE_LENGTH, M, STATIONARY, STRENGTH, TILT, Table, effective};

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
    /// One, or one for each incident polarization; none below the horizon.
    pub(super) sets: Vec<Lobes>,
}

/// The two lobes of one parameter set, and the scale of its noise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lobes {
    pub(super) mean: Lobe,
    pub(super) steady: Lobe,
    /// 1/l.
    pub(super) inverse_length: f64,
}

/// One lobe for one incident direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lobe {
    pub(super) m: f64,
    /// ω_eff.
    pub(super) incident: DVec3,
    /// ρ (z·ω_eff)/J.
    pub(super) strength: f64,
}

/// The half vector of ω_eff and ω_o.
struct Half {
    h: DVec3,
    /// exp(−h_y²/σ²)
    spread: f64,
}

impl FeatherBrdf {
    /// The formulas themselves at one wavelength (nm) and incident direction, to be used with many outgoing ones. Slower
    /// than [`prepare`](Self::prepare), which rounds to single precision.
    #[must_use]
    pub fn exact(&self, wavelength_nm: f64, wi: DVec3) -> ExactBrdf<'_> {
        let lobes = |table: &Table| Lobes::new(table, wavelength_nm, wi);
        let sets = if wi.z > 0.0 { self.tables.iter().map(lobes).collect() } else { Vec::new() };
        ExactBrdf { brdf: self, wavelength_nm, incident: wi, sets }
    }
}

impl ExactBrdf<'_> {
    /// Values towards ω_o: all zero unless both directions have z > 0.
    #[must_use]
    pub fn values(&self, wo: DVec3, instance: Option<u64>) -> Values {
        if self.sets.is_empty() || wo.z.is_nan() || wo.z <= 0.0 {
            return Values::default();
        }
        let draw = instance.map(|instance| self.brdf.noise().draw(instance));
        let mut values = self.one_way(wo, draw.as_ref());
        if self.brdf.options.reciprocal {
            let back = self.brdf.exact(self.wavelength_nm, wo).one_way(self.incident, draw.as_ref());
            values.f = 0.5 * (values.f + back.f);
            values.steady = 0.5 * (values.steady + back.steady);
        }
        values.pdf = self.density(wo);
        values
    }

    /// f and s before any symmetrization, without the density.
    pub(super) fn one_way(&self, wo: DVec3, draw: Option<&Draw>) -> Values {
        let sigma = self.brdf.sigma();
        let share = 1.0 / self.sets.len().max(1) as f64;
        let mut sum = Values::default();
        for lobes in &self.sets {
            let mean = lobes.mean.value(wo, sigma);
            let steady = lobes.steady.value(wo, sigma).min(mean);
            let place = (self.incident.x + wo.x) * lobes.inverse_length;
            sum.f += share * draw.map_or(mean, |draw| speckled(mean, steady, self.brdf.noise(), draw, place));
            sum.steady += share * steady;
        }
        sum
    }

    /// The sets' densities, weighted by what each reflects.
    fn density(&self, wo: DVec3) -> f64 {
        let sigma = self.brdf.sigma();
        let (mut sum, mut total) = (0.0, 0.0);
        for Lobes { mean, .. } in &self.sets {
            let weight = mean.strength / (sigma * PI.sqrt() * PI) + LEAST_WEIGHT;
            sum += weight * mean.density(wo, sigma);
            total += weight;
        }
        sum / total
    }
}

/// Weight of a set that reflects nothing, so that there is always something to draw from.
const LEAST_WEIGHT: f64 = 1e-9;

/// f of an instance, S.25.
fn speckled(mean: f64, steady: f64, noise: &Noise, draw: &Draw, place: f64) -> f64 {
    let [qr, qi] = noise.exact(draw, place);
    let spread = (0.5 * (mean - steady)).sqrt();
    (spread * qr + steady.sqrt()).powi(2) + (spread * qi).powi(2)
}

impl Lobes {
    fn new(table: &Table, wavelength_nm: f64, wi: DVec3) -> Self {
        let cos_theta = wi.x.hypot(wi.z).max(1e-6);
        let cos_phi = wi.z / cos_theta;
        let p = table.exact(wavelength_nm, cos_theta, cos_phi);
        let lobe = |base: usize| {
            let mut incident = effective(cos_theta, cos_phi, p[base + TILT]);
            incident.x = incident.x.copysign(wi.x * incident.x);
            incident.y = wi.y;
            Lobe { m: p[base + M], incident, strength: p[base + STRENGTH] }
        };
        Self { mean: lobe(0), steady: lobe(STATIONARY), inverse_length: p[INVERSE_LENGTH] }
    }
}

impl Lobe {
    fn half(&self, wo: DVec3, sigma: f64) -> Half {
        let h = (self.incident + wo).normalize();
        Half { h, spread: libm::exp(-(h.y / sigma).powi(2)) }
    }

    /// f̂ = ρ m/(2σ√π J) · D₁ D₂ G₁(ω_o)/(z·ω_o).
    fn value(&self, wo: DVec3, sigma: f64) -> f64 {
        let Half { h, spread } = self.half(wo, sigma);
        let m2 = self.m * self.m;
        let q = m2 + (1.0 - m2) * h.x * h.x;
        let d = m2 / (PI * q * q) * spread;
        // G₁(ω_o)/(z·ω_o)
        let g = 2.0 / (wo.z + (wo.z * wo.z + m2 * (1.0 - wo.z * wo.z)).sqrt());
        self.strength * self.m / (2.0 * sigma * PI.sqrt() * self.incident.z) * d * g
    }

    /// p(h_y) p(h_x | h_y) h_z / (4 ω_eff·h).
    fn density(&self, wo: DVec3, sigma: f64) -> f64 {
        let Half { h, spread } = self.half(wo, sigma);
        // a grows without bound as m → 1, where h_x is uniform.
        let a = self.m / (1.0 - self.m * self.m).max(1e-12).sqrt();
        let end = (1.0 - h.y * h.y).max(0.0).sqrt();
        let along = 1.0 / (PI * a * (1.0 + (h.x / a).powi(2)).powi(2) * half_distribution(end / a));
        let across = spread / (sigma * PI.sqrt() * libm::erf(1.0 / sigma));
        along * across * h.z / (4.0 * self.incident.dot(h))
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
