//! Evaluation of a feather material: what renderers call.

mod prepared;

use std::sync::Arc;

use fearless_simd::{Level, Simd, f32x4, prelude::*};
use glam::DVec3;
use std::f64::consts::TAU;

pub use self::prepared::PreparedBrdf;
use super::lanes::{Cosine, Extras, Mixed, Outgoing, Simplices, density, exp_of_negative, parts};
use super::longitudinal::{PARTS, half_sine_squared};
use super::material::FeatherMaterial;
use super::noise::{Draw, Noise};
use super::slope::{FARTHEST, RISE, Slope};
use super::table::Incident;
use super::tables::{BrdfTables, Options, Reciprocity};
use crate::Result;
use crate::math::simd::dispatch_large;
use crate::scattering::far_field::Polarization;
use crate::scattering::lobe::FitKind;
use crate::scattering::statistics::Sides;

/// A feather material that is ready for evaluation. Shared between threads; nothing in it changes.
#[derive(Debug, Clone)]
pub struct FeatherBrdf {
    pub(super) tables: Arc<BrdfTables>,
    pub(super) reciprocity: Reciprocity,
    /// 1/σ² of the Gaussians along the barbule; 0 where there is none.
    pub(super) inverse_sigma2: [f64; PARTS],
    pub(super) level: Level,
}

impl FeatherBrdf {
    /// Checks the material, integrates the lobes of its nodes and draws its noise: about a second per million nodes.
    ///
    /// # Errors
    /// A material that fails [`FeatherMaterial::check`], or σ out of range.
    pub fn new(material: &FeatherMaterial, options: Options) -> Result<Self> {
        Ok(Self::from_tables(BrdfTables::new(material, options)?))
    }

    /// What these tables hold.
    #[must_use]
    pub fn from_tables(tables: BrdfTables) -> Self {
        let sigmas = tables.longitudinal.sigmas();
        let inverse_sigma2 = std::array::from_fn(|k| sigmas.get(k).map_or(0.0, |s| 1.0 / (s * s)));
        let reciprocity = usable(tables.reciprocity, &tables);
        Self { tables: Arc::new(tables), reciprocity, inverse_sigma2, level: Level::new() }
    }

    /// The same tables evaluated so that values are reciprocal in another way.
    #[must_use]
    pub fn reciprocal_by(&self, reciprocity: Reciprocity) -> Self {
        Self { reciprocity: usable(reciprocity, &self.tables), ..self.clone() }
    }

    /// What makes values reciprocal.
    #[must_use]
    pub fn reciprocity(&self) -> Reciprocity {
        self.reciprocity
    }

    /// The tables that are evaluated.
    #[must_use]
    pub fn tables(&self) -> &BrdfTables {
        &self.tables
    }

    /// f in 1/sr at N wavelengths (four, eight, …), without the cosine; zero unless both directions have z > 0.
    ///
    /// `instance` names a barbule, whose speckle is a draw of its own; without one the smooth mean is returned.
    #[must_use]
    pub fn eval<const N: usize>(
        &self,
        wavelengths_nm: [f32; N],
        wi: DVec3,
        wo: DVec3,
        instance: Option<u64>,
    ) -> [f32; N] {
        let mut values = [0.0; N];
        if is_above(wi) && is_above(wo) {
            let instance = instance.map(|name| self.instance(name));
            self.add_both_ways(&wavelengths_nm, [wi, wo], None, instance.as_ref(), &mut values);
        }
        values
    }

    /// An outgoing direction drawn from the mean lobes at this wavelength, with its density per sr; none for light from
    /// below the horizon.
    #[must_use]
    pub fn sample(&self, wavelength_nm: f32, wi: DVec3, u: [f64; 2]) -> Option<(DVec3, f64)> {
        self.prepare([wavelength_nm; 4], wi).sample(0, u)
    }

    /// Density of [`sample`](Self::sample) per sr; zero below the horizon.
    #[must_use]
    pub fn pdf(&self, wavelength_nm: f32, wi: DVec3, wo: DVec3) -> f64 {
        self.prepare([wavelength_nm; 4], wi).pdf(0, wo)
    }

    /// The densities at N wavelengths, for spectral multiple importance sampling.
    #[must_use]
    pub fn pdfs<const N: usize>(&self, wavelengths_nm: [f32; N], wi: DVec3, wo: DVec3) -> [f64; N] {
        self.prepare(wavelengths_nm, wi).pdfs(wo)
    }

    /// Shortest and longest wavelength of the tables, nm; beyond them the end values hold.
    #[must_use]
    pub fn wavelength_range_nm(&self) -> (f64, f64) {
        self.tables.grid.wavelength_range_nm()
    }

    /// The longitudinal spread in use: with a halo, that of the narrow part.
    #[must_use]
    pub fn sigma(&self) -> f64 {
        self.tables.longitudinal.sigma()
    }

    /// σ of the Gaussians beside it.
    #[must_use]
    pub fn halo_sigmas(&self) -> &[f64] {
        &self.tables.longitudinal.sigmas()[1..]
    }

    /// The noise in use.
    #[must_use]
    pub fn noise(&self) -> &Noise {
        &self.tables.noise
    }

    /// ∫ f (z·ω_o) dω_o of the smooth mean (before any symmetrization): what the mixed nodes reflect.
    #[must_use]
    pub fn albedo(&self, wavelength_nm: f32, wi: DVec3) -> f64 {
        self.exact(f64::from(wavelength_nm), wi).reflected()
    }

    /// The barbule of this name, for [`PreparedBrdf::eval`].
    #[must_use]
    #[inline]
    pub fn instance(&self, name: u64) -> Draw {
        self.tables.noise.draw(name)
    }

    /// Everything about N wavelengths and one incident direction, to be used with many outgoing ones.
    #[must_use]
    #[inline]
    pub fn prepare<const N: usize>(&self, wavelengths_nm: [f32; N], wi: DVec3) -> PreparedBrdf<'_, N> {
        const { assert!(N.is_multiple_of(4), "wavelengths come in fours") };
        PreparedBrdf { brdf: self, wavelengths_nm, wi, incident: self.incident(wi) }
    }

    /// ω_i in the tables.
    pub(super) fn incident(&self, wi: DVec3) -> Incident {
        self.tables.grid.incident([wi.x, wi.y, wi.z])
    }

    #[inline(always)]
    pub(super) fn cosine(&self) -> Cosine {
        Cosine(if self.tables.kind == FitKind::Marginal { 1.0 } else { 0.0 })
    }

    /// f cosφ_o of one set at four wavelengths but for what the spread along the barbule makes of it.
    #[inline(always)]
    fn across<S: Simd>(
        &self,
        simd: S,
        set: usize,
        simplices: &Simplices<S>,
        (Pair { slope, facet, .. }, instance): (&Pair, Option<&At<'_>>),
        inverse_nm: f32x4<S>,
    ) -> f32x4<S> {
        let facet = *facet;
        let Some(at) = instance else {
            let mean = Mixed::new(simd, &self.tables.sets[set], simplices).mean;
            let Some(polarization) = self.tables.polarization else { return mean };
            let extras = Extras::new(simd, &self.tables.sets[set], simplices);
            return mean * own(simd, &extras, facet, polarization);
        };
        // Noise before lobes: its loads wait longest.
        let extras = Extras::new(simd, &self.tables.sets[set], simplices);
        let inverse_length = if at.draw.is_achromatic() {
            f32x4::splat(simd, slope.achromatic_inverse_length as f32)
        } else {
            extras.inverse_length
        };
        let place = self.tables.noise.place(simd, at.draw, inverse_length * at.x, inverse_nm * at.phase_nm);
        let [qr, qi, own_r, own_i] = self.tables.noise.at_four(simd, at.draw, &place);
        let Mixed { mut mean, mut steady } = Mixed::new(simd, &self.tables.sets[set], simplices);
        if let Some(polarization) = self.tables.polarization {
            let own = own(simd, &extras, facet, polarization);
            (mean, steady) = (mean * own, steady * own);
        }
        let value = if self.tables.polarization_of(set) == Some(Polarization::First) {
            speckled(mean, steady, qr, qi)
        } else {
            let (gamma, rest) = (extras.correlation, extras.rest);
            let (second_r, second_i) = (gamma.mul_add(qr, rest * own_r), gamma.mul_add(qi, rest * own_i));
            if self.tables.polarization_of(set).is_some() {
                speckled(mean, steady, second_r, second_i)
            } else {
                // Half of each polarization's own values.
                let part = part_of_first(simd, &extras, facet);
                let (first, first_steady) = (mean * part, steady * part);
                let mean = first.combine(mean - first);
                let steady = first_steady.combine(steady - first_steady);
                let both = speckled(mean, steady, qr.combine(second_r), qi.combine(second_i));
                let (first, second) = both.split();
                first + second
            }
        };
        value * at.factor(simd, slope, extras.inverse_length)
    }
}

/// [`material::part_of_first`](super::material::part_of_first) of four wavelengths.
#[inline(always)]
fn part_of_first<S: Simd>(simd: S, extras: &Extras<S>, facet: f32) -> f32x4<S> {
    let facet = f32x4::splat(simd, facet.clamp(-1.0, 1.0));
    extras.fraction_slope.mul_add(facet, extras.fraction).max(0.0).min(1.0)
}

/// The values of one polarization over those of unpolarized light.
#[inline(always)]
fn own<S: Simd>(simd: S, extras: &Extras<S>, facet: f32, polarization: Polarization) -> f32x4<S> {
    let first = part_of_first(simd, extras, facet);
    let part = if polarization == Polarization::First { first } else { f32x4::splat(simd, 1.0) - first };
    part * 2.0
}

/// What tables of two sides can do without a step in the lobe.
fn usable(reciprocity: Reciprocity, tables: &BrdfTables) -> Reciprocity {
    match (reciprocity, tables.grid.sides()) {
        (Reciprocity::Steeper, Sides::Both) => Reciprocity::Mean,
        (other, _) => other,
    }
}

/// What z of a direction that leaves the surface is above: what is divided by it stays within single precision.
const LEAST_COSINE: f64 = 1e-10;

/// Whether a direction leaves the surface.
#[inline(always)]
pub(super) fn is_above(w: DVec3) -> bool {
    w.z > LEAST_COSINE
}

/// Wave number times wavelength, (rad/µm) nm.
const PHASE_NM: f64 = 1000.0 * TAU;

/// What all wavelengths of a pair of directions share beside their simplices.
pub(super) struct Pair {
    pub(super) slope: Slope,
    /// Slope of the facet that mirrors, on the side of the tables, where somebody asks for it.
    pub(super) facet: f32,
    /// What each Gaussian along the barbule, z·ω_o and cosφ_o make of f.
    pub(super) factors: [f32; PARTS],
}

/// Which instance, and where its noise is looked up but for the length: x_i + x_o.
pub(super) struct At<'a> {
    draw: &'a Draw,
    x: f32,
    /// Height phase times the wavelength, (rad/µm) nm.
    phase_nm: f32,
    /// b of the module `slope`.
    bend: f64,
    /// Slope t of the facet that mirrors.
    pub(super) facet: f64,
    /// E − 1 on its side.
    wing: f32,
}

impl<'a> At<'a> {
    #[inline(always)]
    pub(super) fn new(draw: &'a Draw, [wi, wo]: [DVec3; 2]) -> Self {
        let (x, z) = (wi.x + wo.x, wi.z + wo.z);
        let phase_nm = (z * PHASE_NM) as f32;
        let facet = x / z;
        Self { draw, x: x as f32, phase_nm, bend: 0.5 * x * facet, facet, wing: draw.wing(x) - 1.0 }
    }

    /// τ, see the module `slope`.
    #[inline(always)]
    fn factor<S: Simd>(&self, simd: S, slope: &Slope, inverse_length: f32x4<S>) -> f32x4<S> {
        let steep = slope.steepness * slope.steepness * self.bend;
        let a = (inverse_length * steep as f32).min(FARTHEST as f32);
        let (square, one) = (a * a, f32x4::splat(simd, 1.0));
        let [start, rise, fall] = RISE.map(|part| f32x4::splat(simd, part as f32));
        let part = square / (square * a).mul_add(fall, rise.mul_add(a, start));
        part.mul_add(f32x4::splat(simd, slope.strength as f32 * self.wing), one)
    }
}

/// (σ q_r + √s)² + (σ q_i)², S.25, with σ² = (f̂ − s)/2.
#[inline(always)]
fn speckled<S: Simd, V: SimdFloat<S, Element = f32>>(mean: V, steady: V, qr: V, qi: V) -> V {
    let spread = ((mean - steady).max(0.0) * 0.5).sqrt();
    let (r, i) = (spread.mul_add(qr, steady.max(0.0).sqrt()), spread * qi);
    r.mul_add(r, i * i)
}

/// A pair of directions in the tables.
struct Towards {
    incident: Incident,
    outgoing: Outgoing,
    /// cosθ_o, and cosθ_o cosφ_o.
    cos_theta: f64,
    z: f64,
    /// See [`Pair`].
    facet: f32,
}

// Not generic over the number of wavelengths, so that the kernels are compiled once, here; and each without a loop: in
// loops their many bounds checks occupy the compiler for minutes.
impl FeatherBrdf {
    /// Adds f as [`Reciprocity`] has it to values that are 0; `prepared` is ω_i in the tables if it is known.
    #[inline]
    pub(super) fn add_both_ways(
        &self,
        wavelengths_nm: &[f32],
        [wi, wo]: [DVec3; 2],
        prepared: Option<&Incident>,
        instance: Option<&Draw>,
        values: &mut [f32],
    ) {
        let (there, back) = ([wi, wo], [wo, wi]);
        match self.reciprocity {
            Reciprocity::AsFitted => self.add_values(wavelengths_nm, there, prepared, instance, values),
            Reciprocity::Steeper => {
                let horizon = Reciprocity::at_horizon(there);
                if Reciprocity::is_steeper(there) {
                    self.add_values(wavelengths_nm, back, None, instance, values);
                    self.level_at_horizon(horizon, wavelengths_nm, (there, prepared), instance, values);
                } else {
                    self.add_values(wavelengths_nm, there, prepared, instance, values);
                    self.level_at_horizon(horizon, wavelengths_nm, (back, None), instance, values);
                }
            }
            Reciprocity::Mean => {
                self.add_values(wavelengths_nm, there, prepared, instance, values);
                self.add_values(wavelengths_nm, back, None, instance, values);
                values.iter_mut().for_each(|value| *value *= 0.5);
            }
        }
    }

    /// Brings values of the steeper direction's tables nearer to the geometric mean with those of the other `order`.
    fn level_at_horizon(
        &self,
        horizon: f64,
        wavelengths_nm: &[f32],
        (order, prepared): ([DVec3; 2], Option<&Incident>),
        instance: Option<&Draw>,
        values: &mut [f32],
    ) {
        if horizon == 0.0 {
            return;
        }
        for (nm, values) in wavelengths_nm.chunks(8).zip(values.chunks_mut(8)) {
            let mut flatter = [0.0; 8];
            let flatter = &mut flatter[..nm.len()];
            self.add_values(nm, order, prepared, instance, flatter);
            for (value, other) in values.iter_mut().zip(flatter) {
                // What rounding leaves below 0 has no root.
                *value += horizon as f32 * (value.max(0.0).sqrt() * other.max(0.0).sqrt() - *value);
            }
        }
    }

    /// Adds f, mean over the sets, at each wavelength; `prepared` is ω_i in the tables if it is known.
    fn add_values(
        &self,
        wavelengths_nm: &[f32],
        [wi, wo]: [DVec3; 2],
        prepared: Option<&Incident>,
        instance: Option<&Draw>,
        values: &mut [f32],
    ) {
        for set in 0..self.tables.sets.len() {
            for (nm, values) in wavelengths_nm.chunks(8).zip(values.chunks_mut(8)) {
                // A kernel for each, without what the other needs.
                match instance {
                    None => self.add_smooth(set, nm, [wi, wo], prepared, values),
                    Some(draw) => self.add_drawn(set, nm, [wi, wo], prepared, draw, values),
                }
            }
        }
    }

    #[inline(never)]
    fn add_smooth(
        &self,
        set: usize,
        nm: &[f32],
        directions: [DVec3; 2],
        prepared: Option<&Incident>,
        values: &mut [f32],
    ) {
        dispatch_large!(self.level, simd => self.add_eight(simd, set, nm, directions, prepared, None, values));
    }

    #[inline(never)]
    fn add_drawn(
        &self,
        set: usize,
        nm: &[f32],
        directions: [DVec3; 2],
        prepared: Option<&Incident>,
        draw: &Draw,
        values: &mut [f32],
    ) {
        dispatch_large!(self.level, simd => self.add_eight(simd, set, nm, directions, prepared, Some(draw), values));
    }

    /// Four wavelengths of a set or eight, with what they share, so that that stays in registers.
    #[expect(clippy::too_many_arguments, reason = "all of it is inlined")]
    #[inline(always)]
    fn add_eight<S: Simd>(
        &self,
        simd: S,
        set: usize,
        wavelengths_nm: &[f32],
        [wi, wo]: [DVec3; 2],
        prepared: Option<&Incident>,
        instance: Option<&Draw>,
        values: &mut [f32],
    ) {
        let instance = instance.map(|draw| At::new(draw, [wi, wo]));
        let instance = instance.as_ref();
        let incident = match prepared {
            Some(incident) => *incident,
            None => self.tables.grid.incident([wi.x, wi.y, wi.z]),
        };
        let mut towards = self.towards(simd, incident, wo);
        let factors = self.factors(simd, &towards, wo);
        // Most directions are far off the barbule's narrow cone, and of its halo.
        if factors == [0.0; PARTS] {
            return;
        }
        let facet = match instance {
            Some(at) => at.facet,
            None if self.tables.polarization.is_some() => (wi.x + wo.x) / (wi.z + wo.z),
            None => 0.0,
        };
        towards.facet = if incident.mirrored { -facet } else { facet } as f32;
        let (fours, _) = wavelengths_nm.as_chunks::<4>();
        let (lanes, _) = values.as_chunks_mut::<4>();
        let pair = Pair { slope: towards.incident.corners.slope, facet: towards.facet, factors };
        if let ([four, ..], [lanes, ..]) = (fours, &mut *lanes) {
            self.add_four(simd, set, &self.simplices(simd, &towards, four), (&pair, instance), four, lanes);
        }
        if let ([_, four, ..], [_, lanes, ..]) = (fours, lanes) {
            self.add_four(simd, set, &self.simplices(simd, &towards, four), (&pair, instance), four, lanes);
        }
    }

    #[inline(always)]
    pub(super) fn add_four<S: Simd>(
        &self,
        simd: S,
        set: usize,
        simplices: &Simplices<S>,
        (pair, instance): (&Pair, Option<&At<'_>>),
        four: &[f32; 4],
        lanes: &mut [f32; 4],
    ) {
        let inverse_nm = f32x4::splat(simd, 1.0) / f32x4::from_slice(simd, four);
        let across = self.across(simd, set, simplices, (pair, instance), inverse_nm);
        let shares = self.tables.longitudinal.shares();
        let [first, second, third, fourth] = pair.factors;
        let value = if shares.is_empty() {
            across * first
        } else {
            let [a, b, c, d] = parts(simd, shares, simplices);
            across * ((a * first + b * second) + (c * third + d * fourth))
        };
        *lanes = (f32x4::from_slice(simd, lanes) + value).into();
    }

    /// Densities of ω_o per sr at each wavelength.
    fn densities(&self, wavelengths_nm: &[f32], incident: &Incident, wo: DVec3, densities: &mut [f64]) {
        let towards = dispatch_large!(self.level, simd => self.towards(simd, *incident, wo));
        let longitudinal = &self.tables.longitudinal;
        let along = longitudinal
            .densities(incident.along, [wo.y, towards.cos_theta])
            .map(|density| density * towards.cos_theta / towards.z);
        let (fours, _) = wavelengths_nm.as_chunks::<4>();
        let (lanes, _) = densities.as_chunks_mut::<4>();
        for (four, lanes) in fours.iter().zip(lanes) {
            let (mut sums, mut totals) = ([0.0_f32; 4], [0.0_f32; 4]);
            let mut mixed = [along[0]; 4];
            if !longitudinal.shares().is_empty() {
                let shares = dispatch_large!(self.level, simd => {
                    let simplices = self.simplices(simd, &towards, four);
                    parts(simd, longitudinal.shares(), &simplices).map(|lanes| <[f32; 4]>::from(lanes))
                });
                let of = |lane: usize| shares.iter().zip(along).map(|(s, d)| f64::from(s[lane]) * d).sum();
                mixed = std::array::from_fn(of);
            }
            for table in &self.tables.sets {
                dispatch_large!(self.level, simd => {
                    let simplices = self.simplices(simd, &towards, four);
                    let [sum, total] = density(simd, table, &simplices);
                    sums = (f32x4::from_slice(simd, &sums) + sum).into();
                    totals = (f32x4::from_slice(simd, &totals) + total).into();
                });
            }
            for (((value, sum), total), along) in lanes.iter_mut().zip(sums).zip(totals).zip(mixed) {
                *value = f64::from(sum / total) * along;
            }
        }
    }

    #[inline(always)]
    fn towards<S: Simd>(&self, simd: S, incident: Incident, wo: DVec3) -> Towards {
        let cos_theta = (wo.x * wo.x + wo.z * wo.z).sqrt();
        let (tau, z) = incident.product(wo.x, wo.z, cos_theta);
        let outgoing = Outgoing::new(simd, &incident, tau as f32, self.cosine());
        Towards { incident, outgoing, cos_theta, z, facet: 0.0 }
    }

    /// What each Gaussian along the barbule, z·ω_o and cosφ_o make of f.
    #[inline(always)]
    fn factors<S: Simd>(&self, simd: S, towards: &Towards, wo: DVec3) -> [f32; PARTS] {
        let Towards { incident: Incident { along, .. }, cos_theta, z, .. } = towards;
        let t2 = half_sine_squared(*along, [wo.y, *cos_theta]);
        let exponents = self.inverse_sigma2.map(|inverse| (t2 * inverse) as f32);
        let spread = exp_of_negative(simd, f32x4::from_slice(simd, &exponents));
        let share = if self.tables.sets.len() == 2 { 0.5 } else { 1.0 };
        let scale = share * cos_theta / (wo.z * z);
        let scales = self.tables.longitudinal.inverse_q(along[1]).map(|inverse| (inverse * scale) as f32);
        (spread * f32x4::from_slice(simd, &scales)).into()
    }

    #[inline(always)]
    fn simplices<S: Simd>(&self, simd: S, towards: &Towards, four: &[f32; 4]) -> Simplices<S> {
        let Towards { incident: Incident { corners, .. }, outgoing, .. } = towards;
        let shares = corners.shares.map(|share| share as f32);
        Simplices::new(simd, &self.tables.grid, (&corners.first, shares), outgoing, four, self.cosine())
    }
}

#[cfg(test)]
mod tests;
